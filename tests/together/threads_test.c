/* Every header with threads of its own choosing underneath: the results are those of one thread, and ThreadSanitizer
   finds no race (`make config=thread`). A crew takes the tasks in whatever order its threads come. */
#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "csm.h"
#include "shadowfield.h"
#include "envlights.h"
#include "envshadow.h"
#include "rsm.h"
#include "ism.h"
#include "sky_lights.h"

/* An entity of no fields that stands at the origin, not tinted. */
static const sfield_entity upright = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };

enum { THREADS = 4, GRID = 24, CELLS = GRID * GRID, SIDE = 48, POINTS = SIDE * SIDE };

/* ---- the crew ---- */

typedef struct crew {
    pthread_mutex_t lock;
    size_t          next, count;
    void          (*task)(void *context, size_t index);
    void           *context;
} crew;

static void *crew_member(void *user)
{
    crew *c = (crew *)user;
    for (;;) {
        size_t i;
        pthread_mutex_lock(&c->lock);
        i = c->next < c->count ? c->next++ : c->count;
        pthread_mutex_unlock(&c->lock);
        if (i == c->count) return NULL;
        c->task(c->context, i);
    }
}

static void crew_for(void *user, size_t count, void (*task)(void *context, size_t index), void *context)
{
    pthread_t thread[THREADS];
    crew c = { PTHREAD_MUTEX_INITIALIZER, 0, 0, NULL, NULL };
    size_t i;
    c.count = count;
    c.task = task;
    c.context = context;
    for (i = 0; i < THREADS; i++) assert_int_equal(pthread_create(&thread[i], NULL, crew_member, &c), 0);
    for (i = 0; i < THREADS; i++) assert_int_equal(pthread_join(thread[i], NULL), 0);
    *(size_t *)user += 1;
}

/* ---- a wavy sheet over a floor ---- */

static float    sheet[3 * (GRID + 1) * (GRID + 1)], positions[3 * POINTS], normals[3 * POINTS];
static uint32_t indices[6 * CELLS];

/* The same fields in every header's mesh. */
#define THE_SHEET(mesh)                                                                                                \
    ((mesh).positions = sheet, (mesh).vertex_count = (GRID + 1) * (GRID + 1), (mesh).indices = indices,                \
     (mesh).index_count = 6 * CELLS)

static int make_scene(void **state)
{
    uint32_t x, y, n = 0;
    (void)state;
    for (y = 0; y <= GRID; y++)
        for (x = 0; x <= GRID; x++) {
            float *p = sheet + 3 * (y * (GRID + 1) + x);
            p[0] = 2.0f * (float)x / GRID - 1;
            p[2] = 2.0f * (float)y / GRID - 1;
            p[1] = 1 + 0.3f * sinf(5 * p[0]) * cosf(4 * p[2]);
        }
    for (y = 0; y < GRID; y++)
        for (x = 0; x < GRID; x++) {
            uint32_t a = y * (GRID + 1) + x, b = a + GRID + 1;
            indices[n++] = a, indices[n++] = b, indices[n++] = a + 1;
            indices[n++] = a + 1, indices[n++] = b, indices[n++] = b + 1;
        }
    for (n = 0; n < POINTS; n++) {
        positions[3 * n] = 5.0f * (float)(n % SIDE) / SIDE - 2.5f;
        positions[3 * n + 2] = 5.0f * (float)(n / SIDE) / SIDE - 2.5f;
        normals[3 * n + 1] = 1;
    }
    return 0;
}

static void expect_light(const float *one, const float *many, size_t count)
{
    size_t i, lit = 0;
    for (i = 0; i < count; i++) lit += one[i] > 0;
    assert_true(lit > count / 4);
    assert_memory_equal(one, many, count * sizeof *one);
}

/* ---- each header: run 0 on this thread, run 1 by a crew ---- */

static void csm_is_the_same_on_many_threads(void **state)
{
    cohsm_mesh mesh;
    cohsm_maps *maps[2];
    const void *data[2];
    size_t runs = 0, size[2];
    int k, layers;
    (void)state;
    memset(&mesh, 0, sizeof mesh);
    THE_SHEET(mesh);
    for (layers = COHSM_LAYERS_Z1Z2; layers <= COHSM_LAYERS_Z1Z3_FAR; layers++) {
        for (k = 0; k < 2; k++) {
            cohsm_desc d;
            memset(&d, 0, sizeof d);
            d.layers = (cohsm_layers)layers;
            d.domain.side[0] = d.domain.side[1] = 12;
            d.map_side = 24;
            if (k) d.system.parallel_for = crew_for, d.system.user = &runs;
            assert_int_equal(cohsm_build(&d, &mesh, &maps[k], NULL), COHSM_OK);
        }
        for (k = 0; k < 2; k++) data[k] = cohsm_data(maps[k], &size[k]);
        assert_int_equal(size[0], size[1]);
        assert_memory_equal(data[0], data[1], size[0]);
        cohsm_free(maps[0]);
        cohsm_free(maps[1]);
    }
    assert_true(runs > 3);
}

static void shadowfield_is_the_same_on_many_threads(void **state)
{
    static float rgb[2][3 * POINTS];
    static uint8_t bytes[2][1 << 20];
    const float sky[3] = { 1, 2, 3 };
    size_t runs = 0;
    int k, basis;
    (void)state;
    for (basis = SFIELD_BASIS_SH; basis <= SFIELD_BASIS_HAAR; basis++) {
        for (k = 0; k < 2; k++) {
            sfield_mesh mesh;
            sfield_desc d;
            sfield_scene_desc sd;
            sfield_field *f;
            sfield_scene *scene;
            sfield_entity e = upright;
            sfield_points set;
            memset(&mesh, 0, sizeof mesh);
            memset(&d, 0, sizeof d);
            memset(&sd, 0, sizeof sd);
            memset(&set, 0, sizeof set);
            THE_SHEET(mesh);
            d.basis = sd.basis = (sfield_basis)basis;
            d.cube_side = 8;
            if (basis == SFIELD_BASIS_HAAR) sd.cube_side = 8;
            d.shell_count = 3;
            d.position_side = 4;
            if (k) {
                d.system.parallel_for = sd.system.parallel_for = crew_for;
                d.system.user = sd.system.user = &runs;
            }
            assert_int_equal(sfield_build(&d, &mesh, &f, NULL), SFIELD_OK);
            assert_true(sfield_bytes(f) <= sizeof bytes[k]);
            assert_int_equal(sfield_write(f, bytes[k], sizeof bytes[k]), SFIELD_OK);
            assert_int_equal(sfield_scene_create(&sd, &scene), SFIELD_OK);
            e.occlusion = f;
            assert_int_equal(sfield_scene_entities(scene, &e, 1), SFIELD_OK);
            assert_int_equal(sfield_scene_environment(scene, sky, 1, 1, NULL), SFIELD_OK);
            set.count = POINTS;
            set.positions = positions;
            set.normals = normals;
            set.entity = 0;
            set.rgb = rgb[k];
            assert_int_equal(sfield_shade(scene, &set, 1, NULL), SFIELD_OK);
            sfield_scene_free(scene);
            sfield_free(f);
        }
        assert_memory_equal(bytes[0], bytes[1], sizeof bytes[0]);
        expect_light(rgb[0], rgb[1], 3 * POINTS);
    }
    assert_true(runs >= 4);
}

static void envshadow_is_the_same_on_many_threads(void **state)
{
    static float sky[3 * 32 * 16], out[2][3 * POINTS];
    envlt_map map = { ENVLT_PROJECTION_LATLONG, 32, 16, sky, 0 };
    envlt_desc desc;
    envlt_lights *lights;
    const envlt_light *list;
    size_t runs = 0;
    uint32_t count;
    int k;
    (void)state;
    for (k = 0; k < 3 * 32 * 16; k++) sky[k] = 1 + (float)(k % 7);
    memset(&desc, 0, sizeof desc);
    desc.light_count = 24;
    assert_int_equal(envlt_create(&desc, &map, &lights, NULL), ENVLT_OK);
    list = envlt_get_lights(lights, &count);
    for (k = 0; k < 2; k++) {
        envsh_mesh mesh = { sheet, (GRID + 1) * (GRID + 1), 0, indices, 6 * CELLS, NULL, NULL, NULL };
        envsh_points receivers = { POINTS, positions, 0, normals, 0, NULL, 0, 0 };
        envsh_maps_desc md;
        envsh_maps *maps;
        memset(&md, 0, sizeof md);
        if (k) md.system.parallel_for = crew_for, md.system.user = &runs;
        assert_int_equal(envsh_maps_create(&md, count, &maps), ENVSH_OK);
        envsh_maps_begin(maps, AS_LIGHTS(list, count), envsh_bounds_of(&mesh, 1, NULL));
        envsh_maps_draw(maps, &mesh, NULL);
        envsh_maps_end(maps);
        assert_int_equal(envsh_shade(maps, NULL, &receivers, out[k]), ENVSH_OK);
        envsh_maps_free(maps);
    }
    envlt_free(lights);
    expect_light(out[0], out[1], 3 * POINTS);
    assert_true(runs >= 3);
}

static void rsm_is_the_same_on_many_threads(void **state)
{
    static float out[2][3 * POINTS];
    static rsm_texel texels[64 * 64];
    size_t runs = 0;
    int k, pattern;
    (void)state;
    for (pattern = 0; pattern < RSM_PATTERN_COUNT; pattern++) {
        for (k = 0; k < 2; k++) {
            rsm_desc d;
            rsm_gather_desc g;
            rsm_points points;
            rsm_mesh mesh;
            rsm_map *map;
            memset(&d, 0, sizeof d);
            memset(&g, 0, sizeof g);
            memset(&points, 0, sizeof points);
            memset(&mesh, 0, sizeof mesh);
            THE_SHEET(mesh);
            mesh.albedo[0] = mesh.albedo[1] = mesh.albedo[2] = 0.5f;
            d.light.direction[1] = -1;                          /* from below: the sheet lights the floor */
            d.light.value[0] = d.light.value[1] = d.light.value[2] = 4;
            d.light.radius = 1.6f;
            d.side = 64;
            g.pattern = (rsm_pattern)pattern;
            g.sample_count = 50;
            if (k) {
                d.system.parallel_for = g.system.parallel_for = crew_for;
                d.system.user = g.system.user = &runs;
            }
            assert_int_equal(rsm_map_create(&d, &map), RSM_OK);
            assert_int_equal(rsm_rasterize(map, &mesh, 1), RSM_OK);
            assert_int_equal(rsm_finish(map, NULL), RSM_OK);
            if (k) assert_memory_equal(texels, rsm_map_texels(map), sizeof texels);
            else memcpy(texels, rsm_map_texels(map), sizeof texels);
            points.count = POINTS;
            points.positions = positions;
            points.normals = normals;
            assert_int_equal(rsm_gather((const rsm_map *const *)&map, 1, &g, &points, out[k], NULL), RSM_OK);
            rsm_map_free(map);
        }
        expect_light(out[0], out[1], 3 * POINTS);
    }
    assert_true(runs >= 2 * RSM_PATTERN_COUNT);
}

static void ism_is_the_same_on_many_threads(void **state)
{
    enum { LIT = 12 };
    static float at[3 * LIT * LIT], up[3 * LIT * LIT], flux[3 * LIT * LIT], area[LIT * LIT], out[2][3 * POINTS];
    size_t runs = 0;
    uint32_t i;
    int k;
    (void)state;
    for (i = 0; i < LIT * LIT; i++) {                           /* a ceiling shines through the sheet */
        at[3 * i] = 2.0f * (float)(i % LIT) / LIT - 1;
        at[3 * i + 1] = 2;
        at[3 * i + 2] = 2.0f * (float)(i / LIT) / LIT - 1;
        up[3 * i + 1] = -1;
        area[i] = 4.0f / (LIT * LIT);
        flux[3 * i] = flux[3 * i + 1] = flux[3 * i + 2] = area[i];
    }
    for (k = 0; k < 2; k++) {
        ism_mesh mesh = { sheet, (GRID + 1) * (GRID + 1), 0, indices, 6 * CELLS, NULL, NULL, NULL, NULL, NULL };
        ism_source source = { ISM_SOURCE_SURFACE, LIT, LIT, 0, at, 0, up, 0, flux, 0, area, 0, NULL, 0 };
        ism_points view = { SIDE * SIDE, positions, 0, normals, 0, NULL, 0, NULL, 0, SIDE, { 0 }, ISM_ROWS_DEFAULT };
        ism_frame frame = { &mesh, &source, 1, &view, 0 };
        ism_shading shading = { 0 };
        ism_desc d;
        ism_maps *maps;
        memset(&d, 0, sizeof d);
        d.vpl_count = 64;
        d.surfel_count = 1024;
        if (k) d.system.parallel_for = crew_for, d.system.user = &runs;
        assert_int_equal(ism_create(&d, &maps), ISM_OK);
        assert_int_equal(ism_render(maps, &frame, &shading, out[k], NULL), ISM_OK);
        ism_free(maps);
    }
    expect_light(out[0], out[1], 3 * POINTS);
    assert_true(runs >= 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(csm_is_the_same_on_many_threads),
        cmocka_unit_test(shadowfield_is_the_same_on_many_threads),
        cmocka_unit_test(envshadow_is_the_same_on_many_threads),
        cmocka_unit_test(rsm_is_the_same_on_many_threads),
        cmocka_unit_test(ism_is_the_same_on_many_threads),
    };
    return cmocka_run_group_tests(tests, make_scene, NULL);
}
