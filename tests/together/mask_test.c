/* mask_test - alpha masks in every header that takes a mesh: a board with a round hole, whose shadow is known in closed
   form. The mask is one function for all of them. */
#include "csm.h"
#include "shadowfield.h"
#include "envshadow.h"
#include "rsm.h"
#include "ism.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Triangles 0 and 1 are the board, 2 x 2 at height 0, with a hole of radius 0.6 about (0.1, -0.2); 2 and 3 the floor,
   which the mask leaves whole. The corners of the board's triangles stand in another order each. */
static const float corners[8 * 3] = { -1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1,
                                      -4, -1, -4, 4, -1, -4, 4, -1, 4, -4, -1, 4 };
static const uint32_t indices[12] = { 2, 0, 1, 3, 0, 2, 4, 6, 5, 4, 7, 6 };

enum { OPAQUE, CUT, WAYS };
static int way;                             /* OPAQUE: the mask is called, and finds no hole */

static double hole_distance(double x, double z) { return sqrt((x - 0.1) * (x - 0.1) + (z + 0.2) * (z + 0.2)) - 0.6; }

static int mask(void *user, uint32_t triangle, const float w[3])
{
    double p[2] = { 0, 0 };
    int k;
    if (user != &way || triangle > 3 || !(w[0] >= -1e-5f && w[1] >= -1e-5f && w[2] >= -1e-5f) ||
        !(fabsf(w[0] + w[1] + w[2] - 1) < 1e-5f))
        abort();                            /* threads may not use cmocka's */
    for (k = 0; k < 3; k++) {
        p[0] += (double)w[k] * (double)corners[3 * indices[3 * triangle + (uint32_t)k]];
        p[1] += (double)w[k] * (double)corners[3 * indices[3 * triangle + (uint32_t)k] + 2];
    }
    return triangle > 1 || way == OPAQUE || hole_distance(p[0], p[1]) > 0;
}

/* Does the board hide what comes through (x, 0, z)? -1: too near to an edge to say. */
static int hides(double x, double z, double doubt)
{
    double edge = fmax(fabs(x), fabs(z)) - 1, hole = hole_distance(x, z);
    if (fabs(edge) < doubt || (way == CUT && edge < 0 && fabs(hole) < doubt)) return -1;
    return edge < 0 && (way == OPAQUE || hole > 0);
}

typedef struct tally { int asked, hidden, wrong; } tally;

static void count(tally *t, int expected, int hidden)
{
    if (expected < 0) return;
    t->asked++;
    t->hidden += expected;
    t->wrong += expected != hidden;
}

static double next(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(*seed >> 40) / 16777216.0;
}

/* ---- csm ---- */

static cohsm_mesh csm_board(void)
{
    cohsm_mesh m = { corners, 4, 0, indices, 6, NULL, mask, &way };
    return m;
}

/* Receivers below the board, lights above it. Maps of places end where a light may stand, so that their rays are not
   parallel, and triangles are clipped. */
static void csm_answers(const cohsm_maps *maps, cohsm_light_kind kind, double doubt, tally *t)
{
    enum { COUNT = 4000 };
    static float points[3 * COUNT], lights[3 * COUNT], visible[COUNT];
    cohsm_query q;
    uint64_t seed = 7;
    int i;
    for (i = 0; i < 3 * COUNT; i++) {
        points[i] = (float)(i % 3 == 1 ? -0.6 - 0.3 * next(&seed) : 2.4 * next(&seed) - 1.2);
        lights[i] = (float)(i % 3 == 1 ? 1 : 0.8 * next(&seed) - 0.4);
        if (kind == COHSM_LIGHT_INDEX) lights[i] = 0;
    }
    memset(&q, 0, sizeof q);
    q.count = COUNT;
    q.positions = points;
    q.light_kind = kind;
    q.lights = lights;
    q.light_stride = kind == COHSM_LIGHT_INDEX ? 4 : 0;
    if (kind == COHSM_LIGHT_INDEX) memset(lights, 0, sizeof lights);
    assert_int_equal(cohsm_visible(maps, &q, visible, NULL), COHSM_OK);
    for (i = 0; i < COUNT; i++) {
        const float *p = points + 3 * i, *l = lights + 3 * i;
        double dx = (double)l[0], dy = (double)l[1], dz = (double)l[2], s;
        if (kind == COHSM_LIGHT_INDEX) {
            dx = 0.2 - (double)p[0];
            dy = 0.5 - (double)p[1];
            dz = 0.1 - (double)p[2];
        }
        s = -(double)p[1] / dy;
        count(t, hides((double)p[0] + s * dx, (double)p[2] + s * dz, doubt), visible[i] < 0.5f);
    }
}

static void csm_casts_the_shadow_of_the_hole(void **state)
{
    static const float places[4] = { 0.2f, 0.5f, 0.1f, 1 };
    (void)state;
    for (way = 0; way < WAYS; way++) {
        cohsm_mesh mesh = csm_board();
        cohsm_maps *maps;
        cohsm_desc d;
        tally t = { 0, 0, 0 };
        memset(&d, 0, sizeof d);
        d.domain.side[0] = d.domain.side[1] = 64;
        d.map_side = 128;
        assert_int_equal(cohsm_build(&d, &mesh, &maps, NULL), COHSM_OK);
        csm_answers(maps, COHSM_LIGHT_DIRECTION, 0.06, &t);
        cohsm_free(maps);
        memset(&d, 0, sizeof d);
        d.domain.kind = COHSM_DOMAIN_LIST;
        d.domain.locations = places;
        d.domain.location_count = 1;
        d.order = COHSM_ORDER_SCANLINE;
        assert_int_equal(cohsm_build(&d, &mesh, &maps, NULL), COHSM_OK);
        csm_answers(maps, COHSM_LIGHT_INDEX, 0.03, &t);
        cohsm_free(maps);
        print_message("csm: %d of %d answers are wrong, %d of them shadows\n", t.wrong, t.asked, t.hidden);
        assert_true(t.asked > 5000 && t.hidden > 2000 && t.hidden < t.asked - 1000);
        assert_int_equal(t.wrong, 0);
    }
}

static void a_mask_without_holes_changes_no_byte_of_csm(void **state)
{
    static const float places[8] = { 0.2f, 0.5f, 0.1f, 1, -0.4f, 0.05f, 0.9f, 1 };
    int kind;
    (void)state;
    way = OPAQUE;
    for (kind = 0; kind < 4; kind++) {
        cohsm_mesh mesh = csm_board();
        cohsm_maps *maps[2];
        static uint8_t data[2][1 << 20];
        cohsm_info info[2];
        int i;
        cohsm_desc d;
        memset(&d, 0, sizeof d);
        d.map_side = 37;
        d.layers = kind & 1 ? COHSM_LAYERS_Z1Z3_SPHERE : COHSM_LAYERS_Z1Z2;
        d.domain.side[0] = d.domain.side[1] = 24;
        if (kind & 2) {
            d.domain.kind = COHSM_DOMAIN_LIST;
            d.domain.locations = places;
            d.domain.location_count = 2;
            d.order = COHSM_ORDER_SCANLINE;
        }
        mesh.index_count = 12;
        mesh.vertex_count = 8;
        assert_int_equal(cohsm_build(&d, &mesh, &maps[0], NULL), COHSM_OK);
        mesh.mask_fn = NULL;
        assert_int_equal(cohsm_build(&d, &mesh, &maps[1], NULL), COHSM_OK);
        for (i = 0; i < 2; i++) {
            cohsm_get_info(maps[i], &info[i]);
            assert_int_equal(cohsm_write(maps[i], data[i], sizeof data[i]), COHSM_OK);
            cohsm_free(maps[i]);
        }
        assert_int_equal(info[0].bytes, info[1].bytes);
        assert_memory_equal(data[0], data[1], info[0].bytes);
    }
}

/* ---- shadowfield ---- */

/* The share of all directions in which the board hides the view from p: by a fine grid of the board. */
static double share_hidden(const double *p)
{
    enum { STEPS = 1000 };
    double sum = 0;
    int i, j;
    for (i = 0; i < STEPS; i++)
        for (j = 0; j < STEPS; j++) {
            double x = (2 * i + 1.0) / STEPS - 1, z = (2 * j + 1.0) / STEPS - 1;
            double dx = x - p[0], dz = z - p[2], r2 = dx * dx + p[1] * p[1] + dz * dz;
            if (way == OPAQUE || hole_distance(x, z) > 0) sum += fabs(p[1]) / (r2 * sqrt(r2));
        }
    return sum * 4 / ((double)STEPS * STEPS) / (4 * 3.14159265358979);
}

static sfield_field *field_of_board(int masked)
{
    sfield_mesh mesh = { corners, 4, 0, indices, 6, NULL, mask, &way };
    sfield_field *field;
    sfield_desc d;
    memset(&d, 0, sizeof d);
    d.shell_count = 2;
    d.inner = 1.5f;
    d.outer = 2.5f;
    if (!masked) mesh.mask_fn = NULL;
    assert_int_equal(sfield_build(&d, &mesh, &field, NULL), SFIELD_OK);
    return field;
}

/* The first coefficient is the share of all directions that are hidden. Both shells are asked, where nothing is
   interpolated between them; what lies between positions of a shell errs by the same share with and without hole. */
static void shadowfield_sees_through_the_hole(void **state)
{
    double off[WAYS][8];
    int of_one;
    (void)state;
    for (way = 0; way < WAYS; way++) {
        sfield_field *f = field_of_board(1);
        sfield_info info;
        int i, k;
        sfield_get_info(f, &info);
        for (i = 0; i < 8; i++) {
            static const double to[8][3] = { { 0, -1, 0 }, { 0, 1, 0 }, { 0, -1, 0 }, { 0, 1, 0 },
                                             { 0.6, -0.8, 0 }, { 0, 0.8, 0.6 }, { 1, -0.5, 0 }, { -0.5, 1, 0.5 } };
            double p[3], length = sqrt(to[i][0] * to[i][0] + to[i][1] * to[i][1] + to[i][2] * to[i][2]), got, exact;
            float at[3], c[64];
            for (k = 0; k < 3; k++) {
                p[k] = to[i][k] / length * (double)info.radius * (i < 2 ? 1.5 : 2.5);
                at[k] = (float)p[k];
            }
            assert_int_equal(sfield_query(f, 1, at, 0, c), SFIELD_OK);
            got = 1 - (double)c[0] / sqrt(4 * 3.14159265358979);
            exact = share_hidden(p);
            print_message("shadowfield: %.5f hidden, exactly %.5f\n", got, exact);
            off[way][i] = got / exact - 1;
        }
        sfield_free(f);
    }
    for (of_one = 0; of_one < 8; of_one++) {
        assert_true(fabs(off[OPAQUE][of_one]) < 0.05);
        assert_true(fabs(off[CUT][of_one] - off[OPAQUE][of_one]) < 0.015);
    }
}

static void a_mask_without_holes_changes_no_byte_of_shadowfield(void **state)
{
    static uint8_t data[2][1 << 20];
    size_t bytes[2];
    int i;
    (void)state;
    way = OPAQUE;
    for (i = 0; i < 2; i++) {
        sfield_field *f = field_of_board(i);
        bytes[i] = sfield_bytes(f);
        assert_int_equal(sfield_write(f, data[i], sizeof data[i]), SFIELD_OK);
        sfield_free(f);
    }
    assert_int_equal(bytes[0], bytes[1]);
    assert_memory_equal(data[0], data[1], bytes[0]);
}

/* ---- envshadow ---- */

/* Twice: on the floor as it is, and so near to the light's map that the board is cut to its reach first. */
static void envshadow_casts_the_shadow_of_the_hole(void **state)
{
    static const float sun[3] = { 0.28f, 0.96f, 0 }, white[3] = { 1, 1, 1 };
    enum { COUNT = 10000 };
    static float points[3 * COUNT], normals[3 * COUNT], lit[3 * COUNT];
    int i, near_by;
    (void)state;
    for (way = 0; way < WAYS; way++)
        for (near_by = 0; near_by < 2; near_by++) {
            envsh_mesh mesh = { corners, 8, 0, indices, 12, NULL, mask, &way };
            envsh_lights lights;
            envsh_bounds bounds = { { -1, -1, -1 }, { 1, 0, 1 } };
            envsh_maps_desc d;
            envsh_points receivers;
            envsh_query q;
            envsh_maps *maps;
            tally t = { 0, 0, 0 };
            uint64_t seed = 3;
            if (near_by)                    /* a ten-thousandth of the scene, at the hole's rim */
                for (i = 0; i < 3; i++) {
                    static const float low[3] = { 0.6999f, -1e-4f, -0.2001f }, high[3] = { 0.7001f, 1e-4f, -0.1999f };
                    bounds.low[i] = low[i];
                    bounds.high[i] = high[i];
                }
            memset(&lights, 0, sizeof lights);
            memset(&d, 0, sizeof d);
            memset(&q, 0, sizeof q);
            memset(&receivers, 0, sizeof receivers);
            lights.count = 1;
            lights.directions = sun;
            lights.irradiances = white;
            d.map_side = 256;
            q.filter = ENVSH_FILTER_PLAIN;
            for (i = 0; i < COUNT; i++) {
                points[3 * i] = (float)(2.6 * next(&seed) - 1.5);
                points[3 * i + 1] = -1;
                points[3 * i + 2] = (float)(2.6 * next(&seed) - 1.3);
                if (near_by) {
                    points[3 * i] = (float)(0.7 + 1.8e-4 * (next(&seed) - 0.5));
                    points[3 * i + 1] = -5e-5f;
                    points[3 * i + 2] = (float)(-0.2 + 1.8e-4 * (next(&seed) - 0.5));
                }
                normals[3 * i + 1] = 1;
            }
            receivers.count = COUNT;
            receivers.positions = points;
            receivers.normals = normals;
            if (near_by) mesh.index_count = 6;          /* the receivers lie on no floor */
            assert_int_equal(envsh_maps_create(&d, 1, &maps), ENVSH_OK);
            assert_int_equal(envsh_maps_begin(maps, &lights, bounds), ENVSH_OK);
            assert_int_equal(envsh_maps_draw(maps, &mesh, NULL), ENVSH_OK);
            assert_int_equal(envsh_maps_end(maps), ENVSH_OK);
            assert_int_equal(envsh_shade(maps, &q, &receivers, lit), ENVSH_OK);
            for (i = 0; i < COUNT; i++) {
                double s = -(double)points[3 * i + 1] / 0.96;
                count(&t, hides((double)points[3 * i] + 0.28 * s, (double)points[3 * i + 2], near_by ? 2e-6 : 0.02),
                      lit[3 * i] < 0.5f);
            }
            envsh_maps_free(maps);
            print_message("envshadow: %d of %d answers are wrong, %d of them shadows\n", t.wrong, t.asked, t.hidden);
            assert_true(t.asked > 8000 && t.hidden > 2000 && (t.hidden < t.asked - 2000 || (near_by && way == OPAQUE)));
            assert_int_equal(t.wrong, 0);
        }
}

/* ---- rsm ---- */

static void rsm_lights_through_the_hole(void **state)
{
    enum { SIDE = 128 };
    (void)state;
    for (way = 0; way < WAYS; way++) {
        rsm_desc d;
        rsm_mesh mesh;
        rsm_map *map;
        const rsm_texel *texels;
        tally t = { 0, 0, 0 };
        int i;
        memset(&d, 0, sizeof d);
        memset(&mesh, 0, sizeof mesh);
        d.light.kind = RSM_LIGHT_SPOT;
        d.light.position[1] = 2;
        d.light.direction[1] = -1;
        d.light.cone_half_angle = 0.7f;
        d.light.value[0] = 1;
        d.side = SIDE;
        mesh.positions = corners;
        mesh.vertex_count = 8;
        mesh.indices = indices;
        mesh.index_count = 12;
        mesh.albedo[0] = 0.5f;
        mesh.mask_fn = mask;
        mesh.user = &way;
        assert_int_equal(rsm_map_create(&d, &map), RSM_OK);
        assert_int_equal(rsm_rasterize(map, &mesh, 1), RSM_OK);
        assert_int_equal(rsm_finish(map, NULL), RSM_OK);
        texels = rsm_map_texels(map);
        for (i = 0; i < SIDE * SIDE; i++) {
            const float *p = texels[i].position;
            double s = 2 / (2 - (double)p[1]);
            if (texels[i].depth < RSM_FAR) count(&t, hides((double)p[0] * s, (double)p[2] * s, 1e-4), p[1] > -0.5f);
        }
        rsm_map_free(map);
        print_message("rsm: %d of %d texels are wrong, %d on the board\n", t.wrong, t.asked, t.hidden);
        assert_true(t.asked > 15000 && t.hidden > 3000 && t.hidden < t.asked - 3000);
        assert_int_equal(t.wrong, 0);
    }
}

/* ---- ism ---- */

enum { VPLS = 4, RECEIVERS = 3000 };

static ism_maps *make_ism(int masked, uint32_t surfels, uint32_t frame_index, ism_maps *maps)
{
    static float p[3 * RECEIVERS], n[3 * RECEIVERS];
    static ism_vpl vpls[VPLS];
    ism_mesh mesh = { corners, 8, 0, indices, 12, NULL, NULL, NULL, mask, &way };
    ism_frame frame;
    ism_points view;
    ism_desc d;
    uint64_t seed = 5;
    int i;
    for (i = 0; i < RECEIVERS; i++) {
        p[3 * i] = (float)(5 * next(&seed) - 2.5);
        p[3 * i + 1] = -1;
        p[3 * i + 2] = (float)(5 * next(&seed) - 2.5);
        n[3 * i + 1] = 1;
    }
    memset(vpls, 0, sizeof vpls);
    for (i = 0; i < VPLS; i++) {
        vpls[i].position[0] = 0.2f * (float)i - 0.3f;
        vpls[i].position[1] = 1.5f;
        vpls[i].normal[1] = vpls[i].axis[1] = -1;
        vpls[i].exponent = vpls[i].flux[0] = vpls[i].flux[1] = vpls[i].flux[2] = 1;
    }
    memset(&view, 0, sizeof view);
    view.count = RECEIVERS;
    view.positions = p;
    view.normals = n;
    memset(&frame, 0, sizeof frame);
    if (!masked) mesh.mask_fn = NULL;
    frame.mesh = &mesh;
    frame.points = &view;
    frame.index = frame_index;
    memset(&d, 0, sizeof d);
    d.vpl_count = VPLS;
    d.surfel_count = surfels;
    d.tile_side = 128;
    if (!maps) assert_int_equal(ism_create(&d, &maps), ISM_OK);
    assert_int_equal(ism_set_vpls(maps, vpls, VPLS), ISM_OK);
    assert_int_equal(ism_build(maps, &frame), ISM_OK);
    return maps;
}

static void ism_shadows(const ism_maps *maps, double doubt, tally *t)
{
    static float p[3 * RECEIVERS], n[3 * RECEIVERS], visible[RECEIVERS];
    size_t vpl_count;
    const ism_vpl *vpls = ism_vpls(maps, &vpl_count);
    uint64_t seed = 77;
    uint32_t v;
    int i;
    for (i = 0; i < RECEIVERS; i++) {
        p[3 * i] = (float)(4 * next(&seed) - 2);
        p[3 * i + 1] = -1;
        p[3 * i + 2] = (float)(4 * next(&seed) - 2);
        n[3 * i + 1] = 1;
    }
    for (v = 0; v < vpl_count; v++) {
        ism_points points;
        memset(&points, 0, sizeof points);
        points.count = RECEIVERS;
        points.positions = p;
        points.normals = n;
        assert_int_equal(ism_visible(maps, v, &points, 0, visible), ISM_OK);
        for (i = 0; i < RECEIVERS; i++) {
            double s = 1 / 2.5;                 /* from the floor at -1 to the board, of the way to the VPL at 1.5 */
            count(t, hides((double)p[3 * i] + s * ((double)vpls[v].position[0] - (double)p[3 * i]),
                           (double)p[3 * i + 2] * (1 - s), doubt), visible[i] < 0.5f);
        }
    }
}

/* Nothing that lies in the hole has an area, and what is left has the area of what is left of the board. */
static double surfel_areas(const ism_maps *maps)
{
    static ism_surfel s[65536];
    double sum = 0;
    uint32_t v;
    size_t n, i;
    for (v = 0; v < VPLS; v++) {
        assert_int_equal(ism_surfels(maps, v, s, 65536, &n), ISM_OK);
        for (i = 0; i < n; i++) {
            float w[3];
            w[1] = s[i].barycentric[0];
            w[2] = s[i].barycentric[1];
            w[0] = 1 - w[1] - w[2];
            if (!mask(&way, s[i].triangle, w)) assert_true(!(s[i].area > 0));
            else if (s[i].triangle < 2) sum += 2 * (double)s[i].area / VPLS;
        }
    }
    return sum;
}

static void ism_has_no_surfels_in_the_hole(void **state)
{
    int opaque_wrong = 0;
    (void)state;
    for (way = 0; way < WAYS; way++) {
        ism_maps *maps = make_ism(1, 32768, 0, NULL);
        double area = surfel_areas(maps), exact = way == CUT ? 4 - 3.14159265358979 * 0.36 : 4;
        tally t = { 0, 0, 0 };
        ism_shadows(maps, 0.1, &t);
        print_message("ism: area %.4f, exactly %.4f; %d of %d answers are wrong, %d of them shadows\n", area, exact,
                      t.wrong, t.asked, t.hidden);
        assert_true(fabs(area - exact) < 0.02 * exact);
        assert_true(t.asked > 5000 && t.hidden > 1500 && t.hidden < t.asked - 1500);
        if (way == OPAQUE) opaque_wrong = t.wrong;
        else assert_true(t.wrong <= opaque_wrong + t.asked / 200);
        ism_free(maps);
    }
}

/* Holes that open while frames go on are seen after lazy_frames, 8, and not before. */
static void ism_sees_a_new_hole_after_its_lazy_frames(void **state)
{
    double first, area;
    uint32_t i;
    ism_maps *maps;
    (void)state;
    way = OPAQUE;
    maps = make_ism(1, 8192, 0, NULL);
    first = surfel_areas(maps);
    way = CUT;
    for (i = 1; i <= 8; i++) make_ism(1, 8192, i, maps);
    area = surfel_areas(maps);
    print_message("ism: area %.4f, 8 frames after a hole opens %.4f\n", first, area);
    assert_true(fabs(first - 4) < 0.08 && fabs(area - (4 - 3.14159265358979 * 0.36)) < 0.08);
    ism_free(maps);
}

static void a_mask_without_holes_changes_no_depth_of_ism(void **state)
{
    ism_maps *maps[2];
    const float *atlas[2];
    uint32_t side;
    int i;
    (void)state;
    way = OPAQUE;
    for (i = 0; i < 2; i++) {
        maps[i] = make_ism(i, 4096, 0, NULL);
        atlas[i] = ism_atlas(maps[i], &side, NULL);
    }
    assert_memory_equal(atlas[0], atlas[1], (size_t)side * side * sizeof(float));
    ism_free(maps[0]);
    ism_free(maps[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(csm_casts_the_shadow_of_the_hole),
        cmocka_unit_test(a_mask_without_holes_changes_no_byte_of_csm),
        cmocka_unit_test(shadowfield_sees_through_the_hole),
        cmocka_unit_test(a_mask_without_holes_changes_no_byte_of_shadowfield),
        cmocka_unit_test(envshadow_casts_the_shadow_of_the_hole),
        cmocka_unit_test(rsm_lights_through_the_hole),
        cmocka_unit_test(ism_has_no_surfels_in_the_hole),
        cmocka_unit_test(ism_sees_a_new_hole_after_its_lazy_frames),
        cmocka_unit_test(a_mask_without_holes_changes_no_depth_of_ism),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
