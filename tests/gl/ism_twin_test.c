/* ism_twin_test - the GLSL of ism_*.glsl against ism.h: whole atlases, empty and filled, of every projection and of skies and
   lobes; light by every rule near by, by lists and by interleaved pictures; moving meshes and renewed points. */
#define _POSIX_C_SOURCE 200809L
#define ISM_IMPLEMENTATION
#include "ism.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>

#define GL_BACKEND_IMPLEMENTATION
#include "gl_backend.h"

#include "gl/gl_test.h"
#include "unit/ism_util.h"

enum { VPLS = 40, POINTS = 600, TILE = 32, WIDTH = 40, HEIGHT = 30, PIXELS = WIDTH * HEIGHT };

/* A room with an octahedron, a few lamps in it and a picture of its floor and one wall. */
typedef struct stage {
    soup      mesh;
    ism_mesh  ism;
    ism_vpl   vpls[VPLS];
    grid      picture;
    float     albedos[3 * PIXELS];
    ism_view  view;
    ism_frame frame;
    ism_maps *maps;
    ism_desc  desc;
} stage;

static stage stage_now;     /* large */

static stage *stage_open(const ism_desc *desc, int kinds)
{
    static const float lo[3] = { -2, 0, -2 }, hi[3] = { 2, 3, 2 }, up[3] = { 0, 1, 0 }, a[3] = { -2, 0, -2 };
    static const float u[3] = { 4, 0, 0 }, v[3] = { 0, 0, 4 };
    stage *s = &stage_now;
    uint32_t seed = 3, i, k;
    memset(s, 0, sizeof *s);
    soup_box(&s->mesh, lo, hi, -1, 6);
    soup_octahedron(&s->mesh, 0.7f);
    for (i = 0; i < 8 * 3; i++) s->mesh.p[9 * (s->mesh.triangles - 8) + 3 * i + 1] += 1.0f;
    s->ism = soup_mesh(&s->mesh);
    grid_fill(&s->picture, WIDTH, HEIGHT, a, u, v, up, 1);
    for (i = 0; i < PIXELS; i++) {
        if (i % 3 == 0) {               /* a wall */
            s->picture.p[3 * i + 1] = 0.1f + 2.8f * util_unit(&seed);
            s->picture.p[3 * i + 2] = -2;
            s->picture.n[3 * i + 1] = 0;
            s->picture.n[3 * i + 2] = 1;
        }
        if (i % 101 == 0) s->picture.n[3 * i] = s->picture.n[3 * i + 1] = s->picture.n[3 * i + 2] = 0;
        for (k = 0; k < 3; k++) s->albedos[3 * i + k] = 0.2f + 0.6f * util_unit(&seed);
    }
    s->view = grid_view(&s->picture);
    s->view.albedos = s->albedos;
    for (i = 0; i < VPLS; i++) {
        ism_vpl *l = &s->vpls[i];
        int axis = (int)(i % 3), far = (int)(i / 3 % 2);
        float n[3] = { 0, 0, 0 };
        n[axis] = far ? -1.0f : 1.0f;
        *l = util_vpl(0, 0, 0, n[0], n[1], n[2], 0.5f + util_unit(&seed));
        for (k = 0; k < 3; k++) l->position[k] = lo[k] + (hi[k] - lo[k]) * (0.1f + 0.8f * util_unit(&seed));
        l->position[axis] = (far ? hi : lo)[axis];
        l->area = 0.1f;
        if (kinds && i % 4 == 1) {      /* a lobe about another axis */
            l->exponent = 1 + 20 * util_unit(&seed);
            l->axis[(axis + 1) % 3] = 0.5f;
            for (k = 0; k < 3; k++) l->axis[k] *= (float)(1 / sqrt(1.25));
        }
        if (kinds && i % 4 == 2) {      /* a direction of a sky */
            ism__v3 w = ism__v3_normalize(ism__v3_make(util_unit(&seed) - 0.5f, 0.6f, util_unit(&seed) - 0.5f));
            l->directional = 1;
            ism__v3_store(l->position, w);
            ism__v3_store(l->normal, ism__v3_scale(w, -1));
            ism__v3_store(l->axis, ism__v3_scale(w, -1));
        }
    }
    s->frame.mesh = &s->ism;
    s->frame.view = &s->view;
    s->desc = *desc;
    s->desc.vpl_count = VPLS;
    s->desc.points = POINTS;
    if (!s->desc.tile_size) s->desc.tile_size = TILE;
    if (!s->desc.lazy) s->desc.lazy = 8;
    assert_int_equal(ism_create(&s->desc, &s->maps), ISM_OK);
    assert_int_equal(ism_set_vpls(s->maps, s->vpls, VPLS), ISM_OK);
    return s;
}

static void stage_close(stage *s) { ism_destroy(s->maps); }

/* ---- what a renderer does ---- */

static void send_vpls(gl_test *t, const stage *s, glbk_ism_maps *m)
{
    glbk_ism_vpl to[VPLS];
    size_t count, i;
    const ism_vpl *from = ism_vpls(s->maps, &count);
    float center[3], radius;
    memset(to, 0, sizeof to);
    for (i = 0; i < count; i++) {
        memcpy(to[i].position, from[i].position, 12);
        memcpy(to[i].normal, from[i].normal, 12);
        memcpy(to[i].flux, from[i].flux, 12);
        memcpy(to[i].axis, from[i].axis, 12);
        to[i].exponent = from[i].exponent;
        to[i].side = from[i].side;
        to[i].directional = from[i].directional;
    }
    ism_bounds(s->maps, center, &radius);
    assert_glbk(t, glbk_ism_vpls_upload(&t->gl, m, to, (uint32_t)count, center, radius));
}

static void send_phase(gl_test *t, const stage *s, glbk_ism_maps *m, uint32_t phase)
{
    static ism_point points[VPLS * POINTS];
    size_t count;
    assert_int_equal(ism_phase_points(s->maps, phase, points, VPLS * POINTS, &count), ISM_OK);
    assert_int_equal(count, VPLS * m->each);
    assert_glbk(t, glbk_ism_phase(&t->gl, m, phase, points));
}

static void open_maps(gl_test *t, const stage *s, glbk_ism_maps *m)
{
    glbk_ism_desc d;
    glbk_ism_mesh mesh = { s->ism.positions, s->ism.vertex_count, s->ism.vertex_stride, s->ism.indices, s->ism.index_count,
                           s->ism.opacities };
    uint32_t phase;
    memset(&d, 0, sizeof d);
    d.vpl_count = VPLS;
    d.points = POINTS;
    d.tile_size = s->desc.tile_size;
    d.projection = (uint32_t)s->desc.projection;
    d.lazy = s->desc.lazy;
    d.no_fill = s->desc.no_fill;
    assert_glbk(t, glbk_ism_maps_create(&t->gl, &d, m));
    send_vpls(t, s, m);
    assert_glbk(t, glbk_ism_mesh_upload(&t->gl, m, &mesh));
    assert_int_equal(glbk_ism_draw(&t->gl, m), GLBK_ERR_ARGUMENT);      /* no points yet */
    for (phase = 0; phase < s->desc.lazy; phase++) send_phase(t, s, m, phase);
}

/* Texels whose depths differ by more than 1e-4: rays through the rim of a disc, where floats decide. */
static double atlas_difference(gl_test *t, const stage *s, glbk_ism_maps *m, const char *what)
{
    uint32_t side, tiles;
    const float *cpu = ism_atlas(s->maps, &side, &tiles);
    float *gl = (float *)malloc((size_t)side * side * sizeof *gl);
    size_t i, full = 0, used = 0, off = 0;
    assert_non_null(gl);
    assert_int_equal(side, m->side);
    assert_glbk(t, glbk_ism_draw(&t->gl, m));
    assert_glbk(t, glbk_ism_read(&t->gl, m, gl));
    for (i = 0; i < (size_t)side * side; i++) {
        size_t tile = i / side / s->desc.tile_size * tiles + i % side / s->desc.tile_size;
        if (tile >= VPLS) continue;
        used++;
        full += cpu[i] < ISM_FAR;
        off += !(fabsf(gl[i] - cpu[i]) <= 1e-4f * cpu[i]);
    }
    free(gl);
    printf("%s: %zu texels, %zu with a surface, %zu differ\n", what, used, full, off);
    assert_true(full > used / 3);               /* or this compares nothing */
    return (double)off / (double)used;
}

static void atlases_agree(void **state)
{
    GL_TEST(t, state)
    static const char *const names[] = { "default", "cosine", "paraboloid", "octahedral", "lobe" };
    int projection, fill;
    for (projection = 1; projection < 5; projection++)
        for (fill = 0; fill < 2; fill++) {
            ism_desc d;
            glbk_ism_maps m;
            char what[64];
            stage *s;
            memset(&d, 0, sizeof d);
            d.projection = (ism_projection)projection;
            d.no_fill = !fill;
            s = stage_open(&d, 1);
            assert_int_equal(ism_build(s->maps, &s->frame), ISM_OK);
            open_maps(t, s, &m);
            snprintf(what, sizeof what, "%s %s", names[projection], fill ? "filled" : "with holes");
            assert_true(atlas_difference(t, s, &m, what) < 1e-3);
            glbk_ism_maps_destroy(&t->gl, &m);
            stage_close(s);
        }
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = { gl_unit_test(atlases_agree) };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_USUAL);
}
