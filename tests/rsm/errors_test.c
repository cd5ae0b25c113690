/* errors_test - bad input: a specific error with outputs untouched, or finite
   results; threads, cancelling, SIMD, agreement of the ways to the same result. */

#define RSM_STATIC
#define RSM_IMPLEMENTATION
#include "rsm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "util.h"

#define NOT_A_NUMBER rsm__from_bits(0x7fc00000u)
#define INF rsm__from_bits(0x7f800000u)

enum { SIDE = 16 };

static model disc;
static rsm_mesh mesh;
static rsm_map *good;
static float positions[3 * SIDE * SIDE], normals[3 * SIDE * SIDE], result[3 * SIDE * SIDE], other[3 * SIDE * SIDE];
static rsm_points points;

static int setup(void **state)
{
    rsm_desc d = sun_desc(1, 1.2, 64);
    int i;
    (void)state;
    disc = model_disc(32, 1);
    mesh = mesh_of(&disc, 0.5);
    good = map_of(&d, &mesh, 1, NULL);
    for (i = 0; i < SIDE * SIDE; i++) {
        set3(positions + 3 * i, i % SIDE * 0.1 - 0.8, 1, i / SIDE * 0.1 - 0.8);
        set3(normals + 3 * i, 0, -1, 0);
    }
    points = points_of(positions, normals, SIDE * SIDE, SIDE);
    return good ? 0 : -1;
}

static int teardown(void **state)
{
    (void)state;
    rsm_map_free(good);
    model_free(&disc);
    return 0;
}

static void map_is(const rsm_desc *d, rsm_result expected, int line)
{
    rsm_map *map = NULL;
    rsm_result r = rsm_map_create(d, &map);
    if (r != expected || (r != RSM_OK) != (map == NULL) || (r == RSM_ERR_DESC && rsm_map_bytes(d) != 0))
        fail_msg("line %d: result %d", line, (int)r);
    if (map) {
        r = rsm_rasterize(map, &mesh, 1);
        if (r != RSM_OK || rsm_finish(map, NULL) != RSM_OK) fail_msg("line %d: drawing: %d", line, (int)r);
    }
    rsm_map_free(map);
}

#define REFUSED(change) do { rsm_desc d = base; change; map_is(&d, RSM_ERR_DESC, __LINE__); } while (0)
#define ACCEPTED(change) do { rsm_desc d = base; change; map_is(&d, RSM_OK, __LINE__); } while (0)

static void lights_out_of_range_are_refused(void **state)
{
    rsm_desc base = sun_desc(1, 1, 8);
    const float odd[3] = { NOT_A_NUMBER, INF, -INF };
    int i, c;
    (void)state;
    REFUSED(d.side = 3);
    REFUSED(d.side = 4097);
    REFUSED(d.side = UINT32_MAX);
    REFUSED(d.light.kind = RSM_LIGHT_COUNT);
    REFUSED(d.light.kind = (rsm_light_kind)1000);
    REFUSED(d.light.radius = 0);
    REFUSED(d.light.radius = -1);
    REFUSED(d.light.radius = 2e9f);
    REFUSED(d.light.direction[1] = 0);
    REFUSED(d.clip_depth = RSM_CLIP_DEPTH_COUNT);
    REFUSED(d.clip_y = RSM_CLIP_Y_COUNT);
    REFUSED(d.rows = (rsm_rows)-1);
    REFUSED(d.light.value[1] = -1);
    REFUSED(d.light.value[1] = 2e12f);
    REFUSED(d.light.near_depth = 2; d.light.far_depth = 1);
    REFUSED(d.light.kind = RSM_LIGHT_POINT; d.light.near_depth = -1; d.light.far_depth = 1);
    REFUSED(d.light.kind = RSM_LIGHT_SPOT; d.light.cone_half_angle = 0);
    REFUSED(d.light.kind = RSM_LIGHT_SPOT; d.light.cone_half_angle = 3.5f);
    REFUSED(d.light.kind = RSM_LIGHT_SQUARE_SPOT; d.light.cone_half_angle = 1.25f);
    REFUSED(d.system.allocator.alloc_fn = ledger_alloc);
    REFUSED(d.system.allocator.free_fn = ledger_free);
    for (i = 0; i < 3; i++) {
        for (c = 0; c < 3; c++) {
            REFUSED(d.light.position[c] = odd[i]);
            REFUSED(d.light.direction[c] = odd[i]);
            REFUSED(d.light.up[c] = odd[i]);
            REFUSED(d.light.value[c] = odd[i]);
        }
        REFUSED(d.light.radius = odd[i]);
        REFUSED(d.light.near_depth = odd[i]);
        REFUSED(d.light.kind = RSM_LIGHT_SPOT; d.light.cone_half_angle = 0.5f * (odd[i]));
    }
    ACCEPTED(d.light.kind = RSM_LIGHT_DEFAULT);
    ACCEPTED(d.light.value[0] = 0);
    ACCEPTED(d.light.up[1] = 1);                 /* along the direction: another is taken */
    ACCEPTED(d.light.kind = RSM_LIGHT_SPOT; d.light.cone_half_angle = 0.5f);
    ACCEPTED(d.light.kind = RSM_LIGHT_SPOT; d.light.cone_half_angle = 2);
    ACCEPTED(d.light.kind = RSM_LIGHT_POINT; d.light.direction[1] = 0);
    ACCEPTED(d.light.kind = RSM_LIGHT_PATCH);
    ACCEPTED(d.side = 5);
}

static void bad_meshes_are_refused(void **state)
{
    const float odd[3] = { NOT_A_NUMBER, INF, 1e30f };
    rsm_desc d = sun_desc(1, 1.2, 16);
    rsm_stats stats;
    rsm_map *map;
    uint32_t bad_index[3] = { 0, 1, 99 };
    float transform[16] = { 0 };
    int i;
    (void)state;
    assert_int_equal(rsm_map_create(&d, &map), RSM_OK);
#define DRAWN(expected, change) \
    do { rsm_mesh m = mesh; change; assert_int_equal(rsm_rasterize(map, &m, 1), expected); } while (0)
    DRAWN(RSM_ERR_ARGUMENT, m.positions = NULL);
    DRAWN(RSM_ERR_ARGUMENT, m.vertex_stride = 8);
    DRAWN(RSM_ERR_ARGUMENT, m.vertex_stride = 13);
    DRAWN(RSM_ERR_INPUT, m.tap_side = 17);
    DRAWN(RSM_ERR_ARGUMENT, m.index_count = 4);
    DRAWN(RSM_ERR_INPUT, m.indices = bad_index; m.index_count = 3);
    DRAWN(RSM_ERR_INPUT, m.albedo[0] = -1);
    DRAWN(RSM_ERR_INPUT, m.albedo[2] = odd[0]);
    transform[3] = odd[0];
    DRAWN(RSM_ERR_INPUT, m.transform = transform);
    assert_int_equal(rsm_rasterize(map, NULL, 1), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_rasterize(NULL, &mesh, 1), RSM_ERR_ARGUMENT);
    DRAWN(RSM_OK, m.index_count = 0);
    assert_int_equal(rsm_rasterize(map, NULL, 0), RSM_OK);
    for (i = 0; i < 3; i++) {                    /* a vertex that is not finite: its two triangles are left out */
        float keep = disc.p[3];
        disc.p[3] = odd[i];
        assert_int_equal(rsm_rasterize(map, &mesh, 1), RSM_OK);
        disc.p[3] = keep;
    }
    assert_int_equal(rsm_finish(map, &stats), RSM_OK);
    assert_int_equal(stats.skipped_triangles, 2);
    assert_int_equal(stats.bad_texels, 0);
    assert_int_equal(rsm_finish(map, NULL), RSM_ERR_ORDER);
    assert_int_equal(rsm_rasterize(map, &mesh, 1), RSM_ERR_ORDER);
    rsm_map_free(map);
}

static void bad_buffers_are_refused_and_bad_texels_counted(void **state)
{
    rsm_desc d = sun_desc(1, 1, 4);
    float n[48], p[48], a[48];
    rsm_buffers b;
    rsm_stats stats;
    rsm_map *map;
    int i;
    (void)state;
    for (i = 0; i < 16; i++) {
        set3(n + 3 * i, 0, 2, 0);
        set3(p + 3 * i, i % 4 * 0.5 - 0.75, 0, i / 4 * 0.5 - 0.75);
        set3(a + 3 * i, 0.5, 0.5, 0.5);
    }
    assert_int_equal(rsm_map_create(&d, &map), RSM_OK);
    memset(&b, 0, sizeof b);
    assert_int_equal(rsm_fill(map, 0, &b), RSM_ERR_ARGUMENT);
    b.normals = n;
    assert_int_equal(rsm_fill(map, 0, &b), RSM_ERR_ARGUMENT);
    b.positions = p;
    b.albedo = a;
    assert_int_equal(rsm_fill(map, 1, &b), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_fill(NULL, 0, &b), RSM_ERR_ARGUMENT);
    b.normal_stride = 10;
    assert_int_equal(rsm_fill(map, 0, &b), RSM_ERR_ARGUMENT);
    b.normal_stride = 0;
    p[0] = NOT_A_NUMBER;
    n[4] = INF;
    a[6] = -0.5f;
    a[9] = INF;
    set3(n + 12, 0, 0, 0);
    assert_int_equal(rsm_fill(map, 0, &b), RSM_OK);
    assert_int_equal(rsm_finish(map, &stats), RSM_OK);
    assert_int_equal(stats.bad_texels, 4);
    assert_int_equal(stats.lit_texels, 11);
    assert_int_equal(rsm_fill(map, 0, &b), RSM_ERR_ORDER);
    for (i = 0; i < 16; i++)                     /* normals are made unit, bad ones empty */
        assert_true(rsm_map_texels(map)[i].normal[1] == (i < 5 ? 0.0f : 1.0f));
    rsm_map_free(map);
}

static rsm_result gather(const rsm_gather_desc *g, const rsm_points *p)
{
    rsm_gather_stats stats, before;
    rsm_result r;
    memset(&stats, 0x31, sizeof stats);
    before = stats;
    memset(result, 0x31, sizeof result);
    memcpy(other, result, sizeof result);
    r = rsm_gather((const rsm_map *const *)&good, 1, g, p, result, &stats);
    if (r != RSM_OK) {
        assert_memory_equal(result, other, sizeof result);
        assert_memory_equal(&stats, &before, sizeof stats);
    }
    return r;
}

static void gathers_out_of_range_are_refused(void **state)
{
    rsm_gather_desc base = gather_desc(RSM_PATTERN_EQUATION3, 16);
    const float odd[3] = { NOT_A_NUMBER, INF, -1 };
    rsm_material bad = { { 0.5f, 2, 0 }, 1 };
    float noise[4] = { 0, 0.5f, 2, 0 };
    rsm_map *open;
    rsm_desc d = sun_desc(1, 1, 8);
    rsm_points p = points;
    uint32_t far_index = SIDE * SIDE;
    int i;
    (void)state;
#define GATHERED(expected, change) \
    do { rsm_gather_desc g = base; change; assert_int_equal(gather(&g, &points), expected); } while (0)
    GATHERED(RSM_OK, g.seed = UINT32_MAX);
    GATHERED(RSM_ERR_DESC, g.pattern = RSM_PATTERN_COUNT);
    GATHERED(RSM_ERR_DESC, g.sample_count = (1 << 20) + 1);
    GATHERED(RSM_ERR_DESC, g.pattern = RSM_PATTERN_POISSON; g.sample_count = 5000);
    GATHERED(RSM_ERR_DESC, g.r_min = 1);
    GATHERED(RSM_ERR_DESC, g.interleave = 3);
    GATHERED(RSM_ERR_DESC, g.interleave = 16);
    GATHERED(RSM_OK, g.interleave = 2);
    p.width = 0;                    /* points that are no picture would all lie in row 0: 2 of 4 sets for all of them */
    base.interleave = 2;
    assert_int_equal(gather(&base, &p), RSM_ERR_DESC);
    base.interleave = 1;
    assert_int_equal(gather(&base, &p), RSM_OK);
    p = points;
    GATHERED(RSM_ERR_INPUT, g.materials = &bad; g.material_count = 1);
    GATHERED(RSM_ERR_DESC, g.material_count = 1);
    GATHERED(RSM_ERR_DESC, g.noise = noise);
    GATHERED(RSM_ERR_INPUT, g.noise = noise; g.noise_side = 2);
    GATHERED(RSM_ERR_DESC, g.system.allocator.alloc_fn = ledger_alloc);
    for (i = 0; i < 3; i++) {
        GATHERED(RSM_ERR_DESC, g.r_max = odd[i]);
        GATHERED(RSM_ERR_DESC, g.r_min = odd[i]);
        GATHERED(RSM_ERR_DESC, g.offset = odd[i]);
        GATHERED(RSM_ERR_DESC, g.clamp = odd[i]);
        GATHERED(RSM_ERR_DESC, g.near_limit = odd[i]);
        GATHERED(RSM_ERR_DESC, g.near_field = odd[i]);
    }
    assert_int_equal(gather(NULL, &points), RSM_OK);
    assert_int_equal(gather(&base, NULL), RSM_ERR_ARGUMENT);
    p.normals = NULL;
    assert_int_equal(gather(&base, &p), RSM_ERR_ARGUMENT);
    p = points;
    p.position_stride = 10;
    assert_int_equal(gather(&base, &p), RSM_ERR_ARGUMENT);
    p = points;
    p.indices = &far_index;
    p.index_count = 1;
    assert_int_equal(gather(&base, &p), RSM_ERR_INPUT);
    assert_int_equal(rsm_map_create(&d, &open), RSM_OK);
    assert_int_equal(rsm_gather((const rsm_map *const *)&open, 1, &base, &points, result, NULL), RSM_ERR_ORDER);
    assert_int_equal(rsm_gather(NULL, 1, &base, &points, result, NULL), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_gather((const rsm_map *const *)&open, 0, &base, &points, result, NULL), RSM_ERR_ARGUMENT);
    rsm_map_free(open);
    p = points;
    p.count = 0;
    assert_int_equal(gather(&base, &p), RSM_OK);
}

static void pictures_out_of_range_are_refused(void **state)
{
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 16);
    rsm_interpolation in;
    rsm_points p = points;
    rsm_direct_desc direct = direct_desc();
    const rsm_map *const *maps = (const rsm_map *const *)&good;
    (void)state;
    memset(&in, 0, sizeof in);
#define DONE(expected, change) \
    do { rsm_interpolation i = in; change; \
         assert_int_equal(rsm_interpolate(maps, 1, &g, &i, &p, result, NULL), expected); } while (0)
    DONE(RSM_OK, i.step = 0);
    DONE(RSM_ERR_DESC, i.step = 3);
    DONE(RSM_ERR_DESC, i.step = 128);
    DONE(RSM_ERR_DESC, i.level_count = 7);
    DONE(RSM_ERR_DESC, i.normal_cosine = NOT_A_NUMBER);
    DONE(RSM_ERR_DESC, i.plane_slope = -1);
    DONE(RSM_ERR_DESC, i.distance = INF);
    DONE(RSM_ERR_DESC, i.contrast = NOT_A_NUMBER);
    DONE(RSM_ERR_DESC, i.light_share = INF);
    DONE(RSM_OK, i.light_share = -1);
    DONE(RSM_ERR_ARGUMENT, p.width = 0);
    DONE(RSM_ERR_ARGUMENT, p.width = 7);
    p.width = SIDE;
    DONE(RSM_ERR_DESC, g.interleave = 2);
    rsm_map_free(NULL);
    direct.tap_side = 16;
    assert_int_equal(rsm_direct(good, &direct, &points, result), RSM_ERR_DESC);
    direct.tap_side = 1;
    direct.bias = NOT_A_NUMBER;
    assert_int_equal(rsm_direct(good, &direct, &points, result), RSM_ERR_DESC);
    assert_int_equal(rsm_direct(NULL, &direct, &points, result), RSM_ERR_ARGUMENT);
    assert_string_equal(rsm_result_text(RSM_OK), "ok");
    assert_string_equal(rsm_result_text((rsm_result)99), "unknown result");
}

/* Receivers that are not finite, or lie on a light, or behind the lamp: finite results, counted. */
static void odd_receivers_get_finite_light(void **state)
{
    const float odd[6] = { NOT_A_NUMBER, INF, -INF, 1e30f, -1e10f, 1e9f };
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 64);
    rsm_direct_desc direct = direct_desc();
    float p[3 * 12], n[3 * 12], e[3 * 12];
    rsm_points points12 = points_of(p, n, 12, 0);
    rsm_gather_stats stats;
    rsm_desc d = sun_desc(1, 1, 16);
    rsm_map *map;
    int i, kind, pattern;
    (void)state;
    for (i = 0; i < 12; i++) {
        set3(p + 3 * i, 0.1, 0.2, 0.3);
        set3(n + 3 * i, 0, 1, 0);
        if (i < 6) p[3 * i + i % 3] = odd[i];
        else if (i < 9) n[3 * i] = odd[i - 6];
        else if (i == 9) set3(p + 3 * i, 0, 2, 0);       /* the lamp itself */
        else if (i == 10) memcpy(p + 3 * i, rsm_map_texels(good)[64 * 32 + 32].position, 12);
    }
    for (kind = RSM_LIGHT_SUN; kind < RSM_LIGHT_COUNT; kind++) {
        d.light.kind = (rsm_light_kind)kind;
        set3(d.light.position, 0, 2, 0);
        set3(d.light.direction, 0, kind == RSM_LIGHT_SUN ? 1 : -1, 0);
        d.light.cone_half_angle = 0.5f;
        map = map_of(&d, &mesh, 1, NULL);
        assert_non_null(map);
        for (pattern = 0; pattern < RSM_PATTERN_COUNT; pattern++) {
            g.pattern = (rsm_pattern)pattern;
            assert_int_equal(rsm_gather((const rsm_map *const *)&map, 1, &g, &points12, e, &stats), RSM_OK);
            for (i = 0; i < 36; i++) assert_true(rsm__finite(e[i]) && e[i] >= 0);
            assert_int_equal(stats.bad_points, 8);
        }
        assert_int_equal(rsm_direct(map, &direct, &points12, e), RSM_OK);
        for (i = 0; i < 36; i++) assert_true(rsm__finite(e[i]) && e[i] >= 0);
        rsm_map_free(map);
    }
}

/* The last value that is taken and the first that is not, for every range. */
static void limits_are_exact(void **state)
{
    rsm_desc base = sun_desc(1, 1, 8), own = base;
    float uv[2], depth, big[3] = { 1e9f, 0, 0 };
    rsm_map *map;
    uint32_t face;
    size_t count;
    uint64_t room[2048];
    (void)state;
    ACCEPTED(d.side = 4);
    own.side = 4096;
    assert_true(rsm_map_bytes(&own) > (size_t)56 * 4096 * 4096);
    ACCEPTED(d.light.radius = 1e9f);
    ACCEPTED(d.light.value[2] = 1e12f);
    ACCEPTED(d.light.direction[1] = 1e-6f);      /* any length */
    ACCEPTED(d.light.direction[1] = 1e6f; d.light.up[2] = 7);
    REFUSED(d.light.near_depth = 1; d.light.far_depth = 1);
    REFUSED(d.light.near_depth = -2e9f; d.light.far_depth = 1);
    REFUSED(d.light.near_depth = 1; d.light.far_depth = 2e9f);
    ACCEPTED(d.light.near_depth = -1e9f; d.light.far_depth = 1e9f);
    REFUSED(d.light.kind = RSM_LIGHT_POINT; d.light.far_depth = 1);
    REFUSED(d.light.kind = RSM_LIGHT_SPOT; d.light.cone_half_angle = 0.0005f);
    ACCEPTED(d.light.kind = RSM_LIGHT_SPOT; d.light.cone_half_angle = 3.14f);
    REFUSED(d.light.kind = RSM_LIGHT_SPOT; d.light.cone_half_angle = 3.145f);
    ACCEPTED(d.light.kind = RSM_LIGHT_SQUARE_SPOT; d.light.cone_half_angle = 1);
    REFUSED(d.light.kind = RSM_LIGHT_SQUARE_SPOT; d.light.cone_half_angle = 0.0005f);
    REFUSED(d.light.position[1] = 1.1e9f);
    REFUSED(d.light.kind = (rsm_light_kind)-1);
    own = base;                                    /* two radians are the widest flat spot */
    own.light.kind = RSM_LIGHT_SPOT;
    own.light.cone_half_angle = 1;
    assert_int_equal(rsm_map_create(&own, &map), RSM_OK);
    assert_int_equal(map_faces(map), 1);
    rsm_map_free(map);
    assert_true(map_faces(NULL) == 0 && map_side(NULL) == 0 && rsm_map_texels(NULL) == NULL);
    /* memory of the caller's: all of it, aligned */
    own = base;
    count = rsm_map_bytes(&own);
    assert_true(count <= sizeof room && rsm_map_bytes(NULL) == 0);
    assert_int_equal(rsm_map_init(&own, room, count - 1, &map), RSM_ERR_MEMORY);
    assert_int_equal(rsm_map_init(&own, (char *)room + 4, sizeof room - 4, &map), RSM_ERR_MEMORY);
    assert_int_equal(rsm_map_init(NULL, room, count, &map), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_map_init(&own, NULL, count, &map), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_map_init(&own, room, count, NULL), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_map_init(&own, room, count, &map), RSM_OK);
    rsm_map_free(map);                           /* leaves it alone */
    assert_int_equal(rsm_rasterize(map, &mesh, 1), RSM_OK);
    assert_int_equal(rsm_map_create(NULL, &map), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_map_create(&own, NULL), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_finish(NULL, NULL), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_map_project(good, big, &face, uv, &depth), RSM_OK);
    big[0] = 1.1e9f;
    assert_int_equal(rsm_map_project(good, big, &face, uv, &depth), RSM_ERR_INPUT);
    big[0] = 0;
    assert_int_equal(rsm_map_project(NULL, big, &face, uv, &depth), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_map_project(good, NULL, &face, uv, &depth), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_map_project(good, big, NULL, uv, &depth), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_map_project(good, big, &face, NULL, &depth), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_map_project(good, big, &face, uv, NULL), RSM_ERR_ARGUMENT);
}

static void limits_of_gathers_are_exact(void **state)
{
    static const float no_noise[4] = { 0, 1, 0.5f, 1 };
    static const uint32_t one[1] = { SIDE * SIDE - 1 };
    rsm_gather_desc g0 = gather_desc(RSM_PATTERN_EQUATION3, 16);
    rsm_material edge = { { 0, 1, 0.5f }, 1e4f };
    const rsm_map *const *maps = (const rsm_map *const *)&good;
    rsm_points p = points;
    float pattern[3 * 16];
    rsm_texel texels[4];
    size_t count;
    (void)state;
    memset(texels, 0, sizeof texels);
#define TAKEN(change) do { rsm_gather_desc g = g0; change; assert_int_equal(gather(&g, &p), RSM_OK); } while (0)
#define LEFT_AS(expected, change) \
    do { rsm_gather_desc g = g0; change; assert_int_equal(gather(&g, &p), expected); } while (0)
#define LEFT(change) LEFT_AS(RSM_ERR_DESC, change)
    TAKEN(g.r_max = 1e3f);
    LEFT(g.r_max = 1.1e3f);
    TAKEN(g.r_min = 0.99f);
    TAKEN(g.offset = 1e9f);
    LEFT(g.offset = 1.1e9f);
    TAKEN(g.clamp = 1e18f);
    LEFT(g.clamp = 1.1e18f);
    TAKEN(g.near_limit = 1e6f);
    LEFT(g.near_limit = 1.1e6f);
    TAKEN(g.near_field = 32);
    LEFT(g.near_field = 32.1f);
    TAKEN(g.interleave = 8);
    LEFT(g.interleave = 6);
    LEFT(g.pattern = (rsm_pattern)-1);
    TAKEN(g.noise = no_noise; g.noise_side = 2);
    LEFT(g.noise = no_noise; g.noise_side = 4097);
    TAKEN(g.materials = &edge; g.material_count = 1);
    edge.exponent = 1.1e4f;
    LEFT_AS(RSM_ERR_INPUT, g.materials = &edge; g.material_count = 1);
    edge.exponent = -1;
    LEFT_AS(RSM_ERR_INPUT, g.materials = &edge; g.material_count = 1);
    edge.exponent = 0;
    TAKEN(g.materials = &edge; g.material_count = 1);
    edge.specular[0] = -0.1f;
    LEFT_AS(RSM_ERR_INPUT, g.materials = &edge; g.material_count = 1);
    TAKEN(g.sample_count = 1);
    LEFT(g.pattern = RSM_PATTERN_POISSON; g.sample_count = 4097);
    p.indices = one;
    p.index_count = 1;
    TAKEN(g.seed = 1);
    p = points;
    p.normal_stride = 10;
    assert_int_equal(gather(&g0, &p), RSM_ERR_ARGUMENT);
    p = points;
    p.open_stride = 2;
    assert_int_equal(gather(&g0, &p), RSM_ERR_ARGUMENT);
    p = points;
    p.positions = NULL;
    assert_int_equal(gather(&g0, &p), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_gather(maps, 1, &g0, &points, NULL, NULL), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_gather_list(NULL, 1, &g0, &points, result, NULL), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_gather_list(texels, 0, NULL, &points, result, NULL), RSM_OK);
    assert_int_equal(rsm_gather_list(texels, 0, &g0, NULL, result, NULL), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_gather_list(texels, 0, &g0, &points, NULL, NULL), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_gather_list(texels, 0, &g0, &points, result, NULL), RSM_OK);
    /* lists, clusters, patterns */
    assert_int_equal(rsm_pixel_lights(maps, 1, 4, 0, texels, 4, NULL), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_pixel_lights(maps, 1, 4, 0, NULL, 4, &count), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_pixel_lights(maps, 1, (1 << 20) + 1, 0, NULL, 0, &count), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_pixel_lights(maps, 1, 4, 0, texels, 4, &count), RSM_OK);
    assert_int_equal(rsm_cluster(texels, 4, 0, NULL, texels, &count), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_cluster(texels, 4, 65537, NULL, texels, &count), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_cluster(NULL, 4, 1, NULL, texels, &count), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_cluster(texels, 4, 1, NULL, NULL, &count), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_cluster(texels, 4, 1, NULL, texels, NULL), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_cluster(texels, 0x80000000u, 1, NULL, texels, &count), RSM_ERR_LIMIT);
    assert_int_equal(rsm_cluster(texels, 4, 1, NULL, texels, &count), RSM_OK);
#define BUILT(expected, kind, samples, r_min, to) \
    assert_int_equal(rsm_pattern_build(kind, samples, r_min, 0, 0, to), expected)
    BUILT(RSM_OK, RSM_PATTERN_EQUATION3, 1, 0, pattern);
    BUILT(RSM_OK, RSM_PATTERN_LOG_RADIAL, 1, 0, pattern);
    BUILT(RSM_OK, RSM_PATTERN_LOG_RADIAL, 2, 0.99f, pattern);
    BUILT(RSM_ERR_ARGUMENT, RSM_PATTERN_LOG_RADIAL, 2, 1, pattern);
    BUILT(RSM_ERR_ARGUMENT, RSM_PATTERN_LOG_RADIAL, 2, -0.1f, pattern);
    BUILT(RSM_ERR_ARGUMENT, RSM_PATTERN_LOG_RADIAL, 0, 0, pattern);
    BUILT(RSM_ERR_ARGUMENT, RSM_PATTERN_LOG_RADIAL, 2, 0, NULL);
    BUILT(RSM_ERR_ARGUMENT, RSM_PATTERN_EQUATION3, (1 << 20) + 1, 0, pattern);
    BUILT(RSM_ERR_ARGUMENT, RSM_PATTERN_POISSON, 4097, 0, pattern);
    BUILT(RSM_ERR_ARGUMENT, RSM_PATTERN_FLUX, 2, 0, pattern);
    BUILT(RSM_ERR_ARGUMENT, RSM_PATTERN_DEFAULT, 2, 0, pattern);
    BUILT(RSM_ERR_ARGUMENT, RSM_PATTERN_MIXED, 2, 0, pattern);
}

static void limits_of_pictures_are_exact(void **state)
{
    static const float no_noise[4] = { 0, 1, 0.5f, 1 };
    static const uint32_t one[1] = { SIDE * SIDE - 1 };
    rsm_gather_desc g0 = gather_desc(RSM_PATTERN_FLUX, 16);
    const rsm_map *const *maps = (const rsm_map *const *)&good;
    rsm_points p = points;
    rsm_interpolation in;
    rsm_direct_desc d0 = direct_desc();
    (void)state;
    memset(&in, 0, sizeof in);
#define GRID(expected, change) \
    do { rsm_interpolation i = in; change; \
         assert_int_equal(rsm_interpolate(maps, 1, &g0, &i, &p, result, NULL), expected); } while (0)
    GRID(RSM_OK, i.step = 2);
    GRID(RSM_OK, i.step = 64);
    GRID(RSM_ERR_DESC, i.step = 1);
    GRID(RSM_OK, i.level_count = 6);
    GRID(RSM_OK, i.normal_cosine = 1);
    GRID(RSM_OK, i.normal_cosine = -1);
    GRID(RSM_ERR_DESC, i.normal_cosine = -1.1f);
    GRID(RSM_OK, i.plane_slope = 1e6f);
    GRID(RSM_ERR_DESC, i.plane_slope = 1.1e6f);
    GRID(RSM_OK, i.distance = 1e9f);
    GRID(RSM_ERR_DESC, i.distance = 1.1e9f);
    GRID(RSM_ERR_DESC, i.distance = -1);
    GRID(RSM_OK, i.contrast = -1e6f);
    GRID(RSM_ERR_DESC, i.contrast = 1.1e6f);
    GRID(RSM_OK, i.light_share = 1e6f);
    GRID(RSM_ERR_DESC, i.light_share = -1.1e6f);
    p.indices = one;
    p.index_count = 1;
    GRID(RSM_ERR_ARGUMENT, i.step = 0);
    p = points;
    g0.add = 1;
    GRID(RSM_ERR_DESC, i.step = 0);
    g0.add = 0;
    g0.noise = no_noise;
    g0.noise_side = 2;
    GRID(RSM_ERR_DESC, i.step = 0);
    g0.noise = NULL;
    assert_int_equal(rsm_interpolate(maps, 1, NULL, &in, &p, result, NULL), RSM_OK);
    assert_int_equal(rsm_interpolate(maps, 1, &g0, &in, &p, NULL, NULL), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_interpolate(maps, 1, &g0, NULL, &p, result, NULL), RSM_OK);
    /* direct light */
#define LIGHTED(expected, change) \
    do { rsm_direct_desc q = d0; change; assert_int_equal(rsm_direct(good, &q, &points, result), expected); } while (0)
    LIGHTED(RSM_OK, q.tap_side = 15);
    LIGHTED(RSM_OK, q.bias = 1e6f);
    LIGHTED(RSM_ERR_DESC, q.bias = 1.1e6f);
    LIGHTED(RSM_OK, q.bias = -1);
    LIGHTED(RSM_ERR_DESC, q.bias = -1.1e6f);
    LIGHTED(RSM_OK, q.slope_bias = 1e6f);
    LIGHTED(RSM_ERR_DESC, q.slope_bias = 1.1e6f);
    LIGHTED(RSM_OK, q.slope_bias = -1);
    LIGHTED(RSM_ERR_DESC, q.slope_bias = NOT_A_NUMBER);
    LIGHTED(RSM_ERR_DESC, q.system.allocator.alloc_fn = ledger_alloc);
    assert_int_equal(rsm_direct(good, NULL, &points, result), RSM_OK);
    assert_int_equal(rsm_direct(good, &d0, NULL, result), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_direct(good, &d0, &points, NULL), RSM_ERR_ARGUMENT);
}

/* Fractions begin at 0, never fall, and every task runs once between them, whatever their number. */
typedef struct record { float last; int calls, runs[100]; } record;

static int record_fraction(void *user, float fraction)
{
    record *r = (record *)user;
    assert_true(r->calls ? fraction > r->last : !(fraction > 0));
    r->last = fraction;
    r->calls++;
    return 0;
}

static void record_run(void *context, size_t i) { ((record *)context)->runs[i]++; }

static void tasks_run_once_between_fractions(void **state)
{
    size_t count, i;
    (void)state;
    for (count = 0; count <= 100; count++) {
        rsm_system s;
        record r;
        memset(&s, 0, sizeof s);
        memset(&r, 0, sizeof r);
        s.progress = record_fraction;
        s.user = &r;
        assert_int_equal(rsm__run_steps(&s, count, record_run, &r, 0, 0.5f), 1);
        assert_true(r.calls == 16 && r.last < 0.5f && r.last > 0.46f);
        for (i = 0; i < 100; i++) assert_int_equal(r.runs[i], i < count);
    }
}

/* Of a picture by grids too, however many levels there are. */
static void fractions_of_levels_never_fall(void **state)
{
    uint32_t levels;
    (void)state;
    for (levels = 0; levels <= 6; levels++) {
        rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 0);
        rsm_interpolation in;
        record r;
        memset(&in, 0, sizeof in);
        memset(&r, 0, sizeof r);
        in.level_count = levels;
        in.step = 16;
        in.contrast = 1e-6f;                     /* every level has something to evaluate */
        g.system.progress = record_fraction;
        g.system.user = &r;
        assert_int_equal(rsm_interpolate((const rsm_map *const *)&good, 1, &g, &in, &points, result, NULL), RSM_OK);
        assert_true(r.calls >= 32 && r.last > 0.9f && r.last < 1);
    }
}

/* ---- threads, cancelling, SIMD ---- */

static void backwards(void *user, size_t count, rsm_task task, void *context)
{
    (void)user;
    while (count-- > 0) task(context, count);
}

static int cancel_at(void *user, float fraction)
{
    float *limit = (float *)user;
    return fraction >= *limit;
}

/* A map's own texels as a renderer's buffers of face 0, of albedo 1. */
static rsm_buffers buffers_of(const rsm_map *map)
{
    rsm_buffers b;
    memset(&b, 0, sizeof b);
    b.positions = rsm_map_texels(map)->position;
    b.normals = rsm_map_texels(map)->normal;
    b.position_stride = b.normal_stride = sizeof(rsm_texel);
    return b;
}

static void the_order_of_tasks_changes_nothing(void **state)
{
    int pattern;
    (void)state;
    for (pattern = 0; pattern < RSM_PATTERN_COUNT; pattern++) {
        rsm_gather_desc g = gather_desc((rsm_pattern)pattern, 100);
        assert_int_equal(gather(&g, &points), RSM_OK);
        memcpy(other, result, sizeof result);
        g.system.parallel_for = backwards;
        assert_int_equal(rsm_gather((const rsm_map *const *)&good, 1, &g, &points, result, NULL), RSM_OK);
        assert_memory_equal(result, other, sizeof result);
    }
    {
        rsm_desc d = sun_desc(1, 1.2, 64);
        rsm_map *map;
        d.system.parallel_for = backwards;
        map = map_of(&d, &mesh, 1, NULL);
        assert_non_null(map);
        assert_memory_equal(rsm_map_texels(map), rsm_map_texels(good), 64 * 64 * sizeof(rsm_texel));
        rsm_map_free(map);
    }
    {
        rsm_desc d = sun_desc(1, 1.2, 64);
        rsm_buffers b = buffers_of(good);
        rsm_map *maps[2];
        int i;
        for (i = 0; i < 2; i++) {
            d.system.parallel_for = i == 0 ? NULL : backwards;
            assert_int_equal(rsm_map_create(&d, &maps[i]), RSM_OK);
            assert_int_equal(rsm_fill(maps[i], 0, &b), RSM_OK);
        }
        assert_memory_equal(rsm_map_texels(maps[0]), rsm_map_texels(maps[1]), 64 * 64 * sizeof(rsm_texel));
        for (i = 0; i < 64 * 64; i++)
            assert_true((rsm_map_texels(maps[0])[i].depth < RSM_FAR) == (rsm_map_texels(good)[i].depth < RSM_FAR));
        for (i = 0; i < 2; i++) rsm_map_free(maps[i]);
    }
}

static void a_cancelled_map_is_empty(void **state)
{
    float limit;
    rsm_map *map;
    rsm_desc d = sun_desc(1, 1.2, 64);
    (void)state;
    for (limit = 0; limit < 1; limit += 0.4f) {
        rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 100);
        size_t i;
        g.system.progress = cancel_at;
        g.system.user = &limit;
        assert_int_equal(rsm_gather((const rsm_map *const *)&good, 1, &g, &points, result, NULL), RSM_ERR_CANCELLED);
        d.system = g.system;
        assert_int_equal(rsm_map_create(&d, &map), RSM_OK);
        assert_int_equal(rsm_rasterize(map, &mesh, 1), RSM_ERR_CANCELLED);
        for (i = 0; i < 64 * 64; i++) assert_true(rsm_map_texels(map)[i].depth >= RSM_FAR);
        rsm_map_free(map);
    }
}

/* A face that is cancelled in its middle is empty, and no other face is touched. */
static void a_cancelled_face_is_empty_and_no_other(void **state)
{
    enum { TEXELS = 64 * 64 };
    float limit = 2;
    rsm_desc d = sun_desc(1, 1.2, 64);
    rsm_buffers b = buffers_of(good);
    rsm_texel *kept = (rsm_texel *)malloc(TEXELS * sizeof *kept);
    rsm_map *map;
    size_t i, filled = 0;
    (void)state;
    d.system.progress = cancel_at;
    d.system.user = &limit;
    d.light.kind = RSM_LIGHT_POINT;
    assert_non_null(kept);
    assert_int_equal(rsm_map_create(&d, &map), RSM_OK);
    assert_int_equal(rsm_fill(map, 1, &b), RSM_OK);
    assert_int_equal(rsm_fill(map, 2, &b), RSM_OK);
    memcpy(kept, rsm_map_texels(map) + TEXELS, TEXELS * sizeof *kept);
    limit = 0.4f;
    assert_int_equal(rsm_fill(map, 2, &b), RSM_ERR_CANCELLED);
    assert_memory_equal(rsm_map_texels(map) + TEXELS, kept, TEXELS * sizeof *kept);
    for (i = 0; i < TEXELS; i++) {
        filled += rsm_map_texels(map)[TEXELS + i].depth < RSM_FAR;
        assert_true(rsm_map_texels(map)[2 * TEXELS + i].depth >= RSM_FAR);
    }
    assert_true(filled > TEXELS / 4);
    limit = 2;
    assert_int_equal(rsm_fill(map, 2, &b), RSM_OK);
    assert_true(rsm_map_texels(map)[2 * TEXELS + TEXELS / 2 + 32].depth < RSM_FAR);
    rsm_map_free(map);
    free(kept);
}

static void vector_units_agree(void **state)
{
#if RSM__SIMD_SETS
    static rsm__block block[2];
    static rsm__tile t, u;
    const float x[7] = { 0.1f, 0.9f, 0.2f, 0, -1, 0, 1e-6f }, limits[3] = { 0.9f, 0.01f, 0.5f };
    const size_t lanes = RSM__BLOCK + 24;
    static const rsm__sum none;
    rsm__sum a = none, b = none;
    double nearest = 1e9;
    size_t i, k;
    for (i = 0; i < 2 * RSM__BLOCK; i++) {
        const rsm_texel *texel = rsm_map_texels(good) + 64 * 32 + i;
        rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 0);
        g.near_limit = 1e-6f;
        rsm__lane_set(&g, &block[i / RSM__BLOCK], i % RSM__BLOCK, texel, 1, 1);
        t.px[i] = texel->position[0];
        t.py[i] = texel->position[1];
        t.pz[i] = texel->position[2];
        t.ny[i] = 1;
        if (i < lanes && texel->depth < RSM_FAR) {
            double d2 = 0;
            for (k = 0; k < 3; k++)
                d2 += ((double)texel->position[k] - (double)x[k]) * ((double)texel->position[k] - (double)x[k]);
            nearest = d2 < nearest ? d2 : nearest;
        }
    }
    u = t;
    rsm__sum_lights_near_lossy_plain(block, lanes, x, &a);
    assert_float_equal(1 / a.nearby, (float)nearest, 1e-4f * (float)nearest);
    rsm__suit_tile_plain(&t, lanes, x, limits, 4);
    if (rsm__cpu_has_avx2()) {
        rsm__sum_lights_near_lossy_avx2(block, lanes, x, &b);
        assert_memory_equal(&a, &b, sizeof a);
        b = none;
        rsm__sum_lights_lossy_avx2(block, lanes, x, &b);
        assert_memory_equal(a.rgb, b.rgb, sizeof a.rgb);
        b = none;
        rsm__sum_lights_near_avx2(block, lanes, x, &b);
        assert_true(memcmp(a.rgb, b.rgb, sizeof a.rgb) == 0 && !(b.nearby < a.nearby || b.nearby > a.nearby));
        b = none;
        rsm__sum_lights_avx2(block, lanes, x, &b);
        assert_memory_equal(a.rgb, b.rgb, sizeof a.rgb);
        rsm__suit_tile_avx2(&u, lanes, x, limits, 4);
        assert_memory_equal(&t, &u, sizeof t);
    }
    b = none;
    rsm__sum_lights_plain(block, lanes, x, &b);
    assert_memory_equal(a.rgb, b.rgb, sizeof a.rgb);
    assert_true(a.rgb[0] > 0 && a.full > 0 && a.lost > 0);
#endif
    (void)state;
}

/* And so for several receivers at a time. */
static void vector_units_agree_on_pictures(void **state)
{
#if RSM__SIMD_SETS
    static rsm__block block[2];
    rsm__receiver_lanes groups[4], wide;
    rsm__sum none;
    size_t i, k, l;
    if (!rsm__cpu_has_avx2()) return;
    memset(&none, 0, sizeof none);
    memset(groups, 0, sizeof groups);
    memset(&wide, 0, sizeof wide);
    for (i = 0; i < 100; i++) {
        rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 0);
        g.near_limit = 1e-6f;
        rsm__lane_set(&g, &block[i / RSM__BLOCK], i % RSM__BLOCK, rsm_map_texels(good) + 64 * 32 + i, 1, 1);
    }
    for (l = 0; l < RSM__LANES; l++) {
        float x[7] = { 0, 0.9f, 0.2f, 0, -1, 0, 1e-6f };
        rsm__sum one = none;
        x[0] = 0.1f * (float)l;
        for (k = 0; k < 7; k++) groups[0].x[k][l] = groups[1].x[k][l] = groups[2].x[k][l] = wide.x[k][l] = x[k];
        x[1] = 0.7f;
        for (k = 0; k < 7; k++) groups[3].x[k][l] = wide.x[k][l + RSM__LANES] = x[k];
        x[1] = 0.9f;
        rsm__sum_lights_lossy_plain(block, 104, x, &one);
        if (l + 1 < RSM__LANES) continue;
        rsm__light_receivers_lossy_plain(block, 100, &groups[0]);
        rsm__light_receivers_lossy_avx2(block, 100, &groups[1]);
        assert_memory_equal(&groups[0], &groups[1], sizeof groups[0]);
        assert_true(groups[0].sums[4][l] > 0);
        for (k = 0; k < 3; k++) assert_float_equal(groups[0].sums[k][l], one.rgb[k], 1e-5f * one.rgb[k]);
        rsm__light_receivers_plain(block, 100, &groups[2]);
        assert_memory_equal(groups[0].sums, groups[2].sums, 3 * sizeof groups[0].sums[0]);
        rsm__light_receivers_lossy_plain(block, 100, &groups[3]);
    }
    if (!rsm__cpu_has_avx512()) return;
    rsm__light_receivers_lossy_avx512(block, 100, &wide);
    for (k = 0; k < 5; k++) {
        assert_memory_equal(wide.sums[k], groups[0].sums[k], RSM__LANES * sizeof(float));
        assert_memory_equal(wide.sums[k] + RSM__LANES, groups[3].sums[k], RSM__LANES * sizeof(float));
    }
    memset(wide.sums, 0, sizeof wide.sums);
    rsm__light_receivers_avx512(block, 100, &wide);
    for (k = 0; k < 3; k++) assert_memory_equal(wide.sums[k], groups[0].sums[k], RSM__LANES * sizeof(float));
#endif
    (void)state;
}

/* What is asked of a list, of maps that are not there or not finished, of black ones and of receivers that are none. */
static int nothing_but_holes(void *user, uint32_t triangle, const float w[3])
{
    (void)user;
    (void)triangle;
    (void)w;
    return 0;
}

static void maps_without_lit_texels_give_no_light(void **state)
{
    static const rsm_light_kind kinds[2] = { RSM_LIGHT_SUN, RSM_LIGHT_POINT };
    const float nowhere[3] = { 0, 0, 0 };
    const rsm_map *two[2] = { NULL, NULL };
    const rsm_map *const *maps = (const rsm_map *const *)&good;
    rsm_gather_desc g = gather_desc(RSM_PATTERN_LOG_RADIAL, 16);
    rsm_direct_desc direct = direct_desc();
    rsm_gather_stats stats;
    rsm_system half;
    rsm_points p = points;
    rsm_texel lights[4];
    rsm_map *map;
    rsm_mesh m = mesh;
    rsm_buffers b;
    size_t count = 77;
    float limit = 0;
    int i;
    (void)state;
    memset(lights, 0, sizeof lights);
    memset(&half, 0, sizeof half);
    half.allocator.alloc_fn = ledger_alloc;
    for (i = 0; i < 2; i++) {                    /* sizes left to the header */
        rsm_desc d = sun_desc(1, 1, 0);
        d.light.kind = kinds[i];
        assert_int_equal(rsm_map_create(&d, &map), RSM_OK);
        assert_int_equal(map_side(map), i ? 256 : 512);
        assert_int_equal(rsm_gather((const rsm_map *const *)&map, 1, &g, &points, result, NULL), RSM_ERR_ORDER);
        assert_int_equal(rsm_direct(map, &direct, &points, result), RSM_ERR_ORDER);
        assert_int_equal(rsm_pixel_lights((const rsm_map *const *)&map, 1, 4, 0, lights, 4, &count), RSM_ERR_ORDER);
        memset(&b, 0, sizeof b);
        b.normals = b.positions = positions;
#define FILLED(change) do { rsm_buffers kept = b; change; \
        assert_int_equal(rsm_fill(map, 0, &b), RSM_ERR_ARGUMENT); b = kept; } while (0)
        FILLED(b.position_stride = 10);
        FILLED(b.depth_stride = 6);
        FILLED(b.albedo_stride = 8);
        FILLED(b.material_stride = 3);
        FILLED(b.albedo_srgb_stride = 2);
        rsm_map_free(map);
    }
    two[0] = good;
    assert_int_equal(rsm_gather(two, 2, &g, &points, result, NULL), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_interpolate(two, 2, &g, NULL, &points, result, NULL), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_cluster(lights, 4, 1, &half, lights, &count), RSM_ERR_DESC);
    assert_int_equal(rsm_blue_noise(8, 1, &half, result), RSM_ERR_DESC);
    g.r_max = -1;
    assert_int_equal(rsm_gather_list(lights, 4, &g, &points, result, NULL), RSM_ERR_DESC);
    assert_int_equal(rsm_interpolate(maps, 1, &g, NULL, &points, result, NULL), RSM_ERR_DESC);
    g.r_max = 0.3f;
    p.count = SIZE_MAX / 4;
    assert_int_equal(rsm_gather_list(lights, 4, &g, &p, result, NULL), RSM_ERR_LIMIT);
    m.mask_fn = nothing_but_holes;
    {
        rsm_desc d = sun_desc(1, 1.2, 16);
        rsm_stats s;
        map = map_of(&d, &m, 1, &s);
        assert_non_null(map);
        assert_true(!(s.incident[0] > 0) && !(s.reflected[0] > 0) && s.lit_texels == 0);
    }
    for (i = 0; i < RSM_PATTERN_COUNT; i++) {
        g.pattern = (rsm_pattern)i;
        assert_int_equal(rsm_gather((const rsm_map *const *)&map, 1, &g, &points, result, &stats), RSM_OK);
        assert_true(!(result[0] > 0) && !(stats.outside_share > 0));
    }
    assert_int_equal(rsm_pixel_lights((const rsm_map *const *)&map, 1, 4, 0, lights, 4, &count), RSM_OK);
    assert_int_equal(count, 0);
    rsm_map_free(map);
    /* no receiver: what is there stays if it is added to, else it is 0; interpolation has nothing to evaluate */
    p = points_of(nowhere, nowhere, 1, 1);
    for (i = 0; i < 2; i++) {
        g.add = i;
        result[0] = 7;
        assert_int_equal(rsm_gather(maps, 1, &g, &p, result, &stats), RSM_OK);
        assert_true(result[0] >= (i ? 7 : 0) && result[0] <= (i ? 7 : 0) && stats.evaluated == 0);
    }
    g.add = 0;
    assert_int_equal(rsm_interpolate(maps, 1, &g, NULL, &p, result, &stats), RSM_OK);
    assert_true(!(result[0] > 0) && stats.evaluated == 0);
    direct.system.progress = cancel_at;
    direct.system.user = &limit;
    assert_int_equal(rsm_direct(good, &direct, &points, result), RSM_ERR_CANCELLED);
    for (i = 0; i < RSM_RESULT_COUNT; i++) assert_true(strlen(rsm_result_text((rsm_result)i)) > 1);
    assert_string_equal(rsm_result_text(RSM_RESULT_COUNT), "unknown result");
}

/* ---- ways to the same result ---- */

static void maps_lists_and_sums_of_both_are_the_same_light(void **state)
{
    static rsm_texel lights[4096];
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 500);
    const rsm_map *const twice[2] = { good, good };
    rsm_texel clusters[64];
    float ao[SIDE * SIDE];
    rsm_points p = points;
    size_t count, clustered;
    double flux = 0, kept = 0;
    int i;
    (void)state;
    assert_int_equal(gather(&g, &points), RSM_OK);
    memcpy(other, result, sizeof result);
    assert_int_equal(rsm_pixel_lights((const rsm_map *const *)&good, 1, 500, 0, lights, 4096, &count), RSM_OK);
    assert_int_equal(rsm_gather_list(lights, count, &g, &points, result, NULL), RSM_OK);
    for (i = 0; i < 3 * SIDE * SIDE; i++) assert_float_equal(result[i], other[i], 1e-5);
    assert_int_equal(rsm_gather(twice, 2, &g, &points, result, NULL), RSM_OK);
    for (i = 0; i < 3 * SIDE * SIDE; i++) assert_float_equal(result[i], 2 * other[i], 1e-5);
    g.add = 1;                                   /* over a light map */
    for (i = 0; i < 3 * SIDE * SIDE; i++) result[i] = 7;
    assert_int_equal(rsm_gather((const rsm_map *const *)&good, 1, &g, &points, result, NULL), RSM_OK);
    for (i = 0; i < 3 * SIDE * SIDE; i++) assert_float_equal(result[i], 7 + other[i], 1e-5);
    g.add = 0;
    for (i = 0; i < SIDE * SIDE; i++) ao[i] = (float)i / (SIDE * SIDE);
    p.open = ao;
    assert_int_equal(gather(&g, &p), RSM_OK);
    assert_int_equal(rsm_gather((const rsm_map *const *)&good, 1, &g, &points, other, NULL), RSM_OK);
    for (i = 0; i < 3 * SIDE * SIDE; i++) assert_float_equal(result[i], other[i] * ao[i / 3], 1e-6);
    assert_int_equal(rsm_pixel_lights((const rsm_map *const *)&good, 1, 0, 0, lights, 4096, &count), RSM_OK);
    assert_int_equal(rsm_cluster(lights, count, 64, NULL, clusters, &clustered), RSM_OK);
    assert_int_equal(clustered, 64);
    for (i = 0; i < (int)count; i++) flux += (double)lights[i].flux[1];
    for (i = 0; i < 64; i++) kept += (double)clusters[i].flux[1];
    assert_true(fabs(kept / flux - 1) < 1e-6);
    assert_int_equal(rsm_gather_list(clusters, clustered, &g, &points, result, NULL), RSM_OK);
    /* 64 lights of a disc at a distance of 1: each 0.2 across, 0.2^2 / 4 */
    for (i = 0; i < 3 * SIDE * SIDE; i++) assert_float_equal(result[i] / other[i], 1, 0.02);
    assert_int_equal(rsm_pixel_lights((const rsm_map *const *)&good, 1, 0, 0, NULL, 0, &clustered), RSM_ERR_MEMORY);
    assert_int_equal(clustered, count);
}

/* Textures: 16 taps a texel give the mean of a checker finer than texels. */
static const rsm_mesh *checkered;

static void checker_place(const float w[3], uint32_t triangle, double *x, double *z)
{
    int k;
    for (k = 0, *x = *z = 0; k < 3; k++) {
        const float *p = checkered->positions + 3 * checkered->indices[3 * triangle + (uint32_t)k];
        *x += (double)(w[k] * p[0]);
        *z += (double)(w[k] * p[2]);
    }
}

static int round_hole(void *user, uint32_t triangle, const float w[3])
{
    double x, z;
    (void)user;
    checker_place(w, triangle, &x, &z);
    return x * x + z * z >= 0.25;
}

static void checker(void *user, const rsm_mesh *m, uint32_t triangle, const float w[3], float albedo[3])
{
    double x, z;
    (void)user;
    (void)m;
    checker_place(w, triangle, &x, &z);
    albedo[0] = albedo[1] = albedo[2] = ((int)floor(x * 97) + (int)floor(z * 97)) & 1 ? 1.0f : 0.0f;
}

static void textures_are_averaged_over_taps(void **state)
{
    rsm_desc d = sun_desc(1, 1.2, 32);
    rsm_mesh m = mesh;
    rsm_stats stats;
    rsm_map *map;
    const rsm_texel *t;
    double spread = 0;
    uint32_t i, n = 0;
    (void)state;
    m.surface_fn = checker;
    m.tap_side = 16;
    m.mask_fn = round_hole;
    checkered = &m;
    map = map_of(&d, &m, 1, &stats);
    assert_non_null(map);
    assert_true(fabs(stats.reflected[0] - 0.5 * stats.incident[0]) < 0.02 * stats.incident[0]);
    assert_true(fabs(stats.incident[0] - PI * 0.75) < 0.04);
    t = rsm_map_texels(map);
    for (i = 0; i < 32 * 32; i++)
        if (t[i].depth < RSM_FAR) {
            double f = (double)t[i].flux[0] / (2.4 * 2.4 / 1024) - 0.5;
            spread += f * f;
            n++;
        }
    assert_true(sqrt(spread / n) < 0.12);        /* one tap: 0.5 */
    rsm_map_free(map);
}

/* Taps stand on a grid of their own about the texel's centre: over 2 x 2 of them the mean is the centre, the mean
   square of each coordinate a quarter of half a texel's. */
enum { TAPPED = 16 };
typedef struct taps { int n[TAPPED * TAPPED]; double sum[TAPPED * TAPPED][2], square[TAPPED * TAPPED][2]; } taps;

static void record_tap(void *user, const rsm_mesh *m, uint32_t triangle, const float w[3], float albedo[3])
{
    taps *to = user;
    double p[2] = { 0, 0 };
    int k, c, cell[2];
    (void)triangle;
    for (k = 0; k < 3; k++)
        for (c = 0; c < 2; c++) p[c] += (double)(w[k] * m->positions[3 * m->indices[k] + 2 * (uint32_t)c]);
    for (c = 0; c < 2; c++) {
        double at = 0.5 * TAPPED * (p[c] + 1), centre;
        cell[c] = (int)at;
        centre = cell[c] + 0.5;
        p[c] = at - centre;
    }
    k = cell[1] * TAPPED + cell[0];
    to->n[k]++;
    for (c = 0; c < 2; c++) {
        to->sum[k][c] += p[c];
        to->square[k][c] += p[c] * p[c];
    }
    albedo[0] = albedo[1] = albedo[2] = 1;
}

static void the_callback_gets_the_taps_of_a_texel(void **state)
{
    static const float wide[9] = { -8, 0, -8, 0, 0, 16, 16, 0, -8 };
    static const uint32_t corners[3] = { 0, 1, 2 };
    static taps seen;
    rsm_desc d = sun_desc(1, 1, TAPPED);
    rsm_mesh m = mesh;
    rsm_map *map;
    int i, c;
    (void)state;
    memset(&seen, 0, sizeof seen);
    m.positions = wide;
    m.indices = corners;
    m.vertex_count = m.index_count = 3;
    m.surface_fn = record_tap;
    m.user = &seen;
    m.tap_side = 2;
    map = map_of(&d, &m, 1, NULL);
    assert_non_null(map);
    for (i = 0; i < TAPPED * TAPPED; i++) {
        assert_int_equal(seen.n[i], 4);
        for (c = 0; c < 2; c++) {
            assert_true(fabs(seen.sum[i][c]) < 1e-4);
            assert_true(fabs(seen.square[i][c] - 4 * 0.0625) < 1e-4);
        }
    }
    rsm_map_free(map);
}

/* Vectors that are empty have no data. */
static void nothing_is_no_error(void **state)
{
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 0);
    rsm_direct_desc d = direct_desc();
    rsm_desc sun = sun_desc(1, 1, 8);
    rsm_points none;
    rsm_mesh empty;
    rsm_texel cluster;
    rsm_map *map;
    float e[3] = { 7, 7, 7 }, at[3] = { 0, 1, 0 }, down[3] = { 0, -1, 0 };
    rsm_points one = points_of(at, down, 1, 0);
    size_t count = 7;
    (void)state;
    memset(&none, 0, sizeof none);
    memset(&empty, 0, sizeof empty);
    assert_int_equal(rsm_gather((const rsm_map *const *)&good, 1, &g, &none, NULL, NULL), RSM_OK);
    assert_int_equal(rsm_gather_list(rsm_map_texels(good), 4, &g, &none, NULL, NULL), RSM_OK);
    assert_int_equal(rsm_direct(good, &d, &none, NULL), RSM_OK);
    assert_int_equal(rsm_gather_list(NULL, 0, &g, &one, e, NULL), RSM_OK);
    assert_true(e[0] == 0 && e[1] == 0 && e[2] == 0);
    assert_int_equal(rsm_gather_list(NULL, 1, &g, &one, e, NULL), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_cluster(NULL, 0, 1, NULL, &cluster, &count), RSM_OK);
    assert_int_equal(count, 0);
    assert_int_equal(rsm_map_create(&sun, &map), RSM_OK);
    assert_int_equal(rsm_rasterize(map, &empty, 1), RSM_OK);
    rsm_map_free(map);
}

/* Both sides of a sheet, alike: the cluster lights as its brightest light does, not nowhere. */
static void opposite_normals_do_not_cancel_out(void **state)
{
    rsm_texel lights[4], cluster;
    size_t count;
    int i;
    (void)state;
    memset(lights, 0, sizeof lights);
    for (i = 0; i < 4; i++) {
        set3(lights[i].position, i % 2, 0, 0);
        set3(lights[i].normal, 0, i / 2 ? -1 : 1, 0);
        set3(lights[i].flux, 1 + i % 2, 1, 1);
    }
    assert_int_equal(rsm_cluster(lights, 4, 1, NULL, &cluster, &count), RSM_OK);
    assert_int_equal(count, 1);
    assert_true(fabsf(cluster.normal[1]) >= 1 && fabsf(cluster.normal[1]) <= 1);
}

static void a_matrix_of_no_face_is_refused(void **state)
{
    float m[16];
    rsm_desc d = sun_desc(1, 1, 8);
    rsm_map *map;
    (void)state;
    assert_int_equal(rsm_map_create(&d, &map), RSM_OK);
    assert_int_equal(rsm_map_matrix(map, 0, m), RSM_OK);
    assert_int_equal(rsm_map_matrix(map, 1, m), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_map_matrix(map, 0, NULL), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_map_matrix(NULL, 0, m), RSM_ERR_ARGUMENT);
    rsm_map_free(map);
}

/* A black texel's lobe is what a grey one's adds to its diffuse light. */
static void black_texels_shine(void **state)
{
    static const rsm_material shiny = { { 0.5f, 0.25f, 0.75f }, 12 };
    rsm_desc d = sun_desc(1, 1.2, 32);
    rsm_map *map[2];
    int way, k, i;
    (void)state;
    set3(d.light.direction, 0.6, 0.8, 0);
    for (k = 0; k < 2; k++) {
        rsm_mesh m = mesh_of(&disc, k ? 0.5 : 0);
        m.material = 1;
        map[k] = map_of(&d, &m, 1, NULL);
        assert_non_null(map[k]);
    }
    for (way = 0; way < 3; way++) {
        static float black[3 * SIDE * SIDE], grey[3 * SIDE * SIDE], plain[3 * SIDE * SIDE];
        rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 0);
        double seen = 0;
        g.interleave = way == 1 ? 2 : 1;
        g.near_field = way == 2 ? 3 : 0;
        assert_int_equal(rsm_gather((const rsm_map *const *)&map[1], 1, &g, &points, plain, NULL), RSM_OK);
        g.materials = &shiny;
        g.material_count = 1;
        assert_int_equal(rsm_gather((const rsm_map *const *)&map[0], 1, &g, &points, black, NULL), RSM_OK);
        assert_int_equal(rsm_gather((const rsm_map *const *)&map[1], 1, &g, &points, grey, NULL), RSM_OK);
        for (i = 0; i < 3 * SIDE * SIDE; i++) {
            assert_true(fabsf(black[i] - (grey[i] - plain[i])) <= 2e-5f * grey[i]);
            seen += (double)black[i];
        }
        assert_true(seen > 0.01 * 3 * SIDE * SIDE);
    }
    for (k = 0; k < 2; k++) rsm_map_free(map[k]);
}

/* Non-diffuse: the lobe carries specular x incident flux, and peaks along the mirrored sun. */
static void a_lobe_carries_specular_flux_along_the_mirrored_sun(void **state)
{
    static const rsm_material shiny = { { 0.5f, 0.5f, 0.5f }, 40 };
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 0);
    rsm_mesh m = mesh_of(&disc, 0);
    rsm_desc d = sun_desc(1, 1.2, 128);
    rsm_map *map;
    double sum = 0, peak = 0, side = 0;
    int i, j;
    (void)state;
    m.material = 1;
    set3(d.light.direction, 0.6, 0.8, 0);
    map = map_of(&d, &m, 1, NULL);
    assert_non_null(map);
    g.materials = &shiny;
    g.material_count = 1;
    g.sample_count = 256;
    assert_true(gather_at(map, &g, 0, 3, 0, 0, -1, 0) == 0);      /* black to the diffuse part: no flux to choose by */
    rsm_map_free(map);
    set3(m.albedo, 1e-6, 1e-6, 1e-6);
    map = map_of(&d, &m, 1, NULL);
    assert_non_null(map);
    /* flux through a hemisphere of radius 100 about the disc */
    for (i = 0; i < 64; i++)
        for (j = 0; j < 64; j++) {
            double y = (i + 0.5) / 64, s = sqrt(1 - y * y), phi = 2 * PI * (j + 0.5) / 64, x = s * cos(phi),
                   z = s * sin(phi);
            double e = gather_at(map, &g, 100 * x, 100 * y, 100 * z, -x, -y, -z);
            sum += e * 2 * PI * 1e4 / 4096;
            if (x < -0.5 && fabs(z) < 0.1 && y > 0.75 && y < 0.85) peak = e > peak ? e : peak;
            if (x > 0.5 && fabs(z) < 0.1 && y > 0.75 && y < 0.85) side = e > side ? e : side;
        }
    /* specular 0.5 of the flux pi x 0.8; the cosine takes a part of the lobe away: (n + 2) / (n + 1) x 0.8 + rim */
    assert_in_range((uint32_t)(1000 * sum / (0.5 * PI * 0.8)), 700, 1000);
    assert_true(peak > 100 * side);
    rsm_map_free(map);
}

/* ---- noise ---- */

static void blue_noise_has_each_value_once(void **state)
{
    enum { N = 32 };
    static float v[N * N];
    static int seen[N * N];
    double low = 0, high = 0;
    int i, x, y;
    (void)state;
    assert_int_equal(rsm_blue_noise(N, 5, NULL, v), RSM_OK);
    memset(seen, 0, sizeof seen);
    for (i = 0; i < N * N; i++) seen[(int)(v[i] * (N * N))]++;
    for (i = 0; i < N * N; i++) {
        assert_int_equal(seen[i], 1);            /* each value is the middle of its share */
        assert_true(fabs((double)v[i] * (N * N) - floor((double)v[i] * (N * N)) - 0.5) < 1e-3);
    }
    for (y = 0; y < N; y++)                      /* neighbours differ more, means over 4 x 4 less than white noise's */
        for (x = 0; x < N; x++) {
            double mean = 0, d = (double)v[y * N + x] - (double)v[y * N + (x + 1) % N];
            for (i = 0; i < 16; i++) mean += (double)v[(y + i / 4) % N * N + (x + i % 4) % N] / 16;
            low += (mean - 0.5) * (mean - 0.5) / (N * N);
            high += d * d / (N * N);
        }
    if (!(low < 0.4 / 12 / 16 && high > 1.2 / 6)) fail_msg("mean of 4 x 4: %g, neighbours %g", low * 12 * 16, high * 6);
    assert_int_equal(rsm_blue_noise(3, 5, NULL, v), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_blue_noise(65, 5, NULL, v), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_blue_noise(8, 5, NULL, NULL), RSM_ERR_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lights_out_of_range_are_refused), cmocka_unit_test(bad_meshes_are_refused),
        cmocka_unit_test(bad_buffers_are_refused_and_bad_texels_counted),
        cmocka_unit_test(gathers_out_of_range_are_refused),
        cmocka_unit_test(pictures_out_of_range_are_refused), cmocka_unit_test(limits_are_exact),
        cmocka_unit_test(limits_of_gathers_are_exact), cmocka_unit_test(limits_of_pictures_are_exact),
        cmocka_unit_test(tasks_run_once_between_fractions), cmocka_unit_test(fractions_of_levels_never_fall),
        cmocka_unit_test(odd_receivers_get_finite_light), cmocka_unit_test(the_order_of_tasks_changes_nothing),
        cmocka_unit_test(a_cancelled_map_is_empty), cmocka_unit_test(a_cancelled_face_is_empty_and_no_other),
        cmocka_unit_test(vector_units_agree), cmocka_unit_test(vector_units_agree_on_pictures),
        cmocka_unit_test(maps_without_lit_texels_give_no_light),
        cmocka_unit_test(maps_lists_and_sums_of_both_are_the_same_light),
        cmocka_unit_test(textures_are_averaged_over_taps), cmocka_unit_test(the_callback_gets_the_taps_of_a_texel),
        cmocka_unit_test(a_matrix_of_no_face_is_refused), cmocka_unit_test(nothing_is_no_error),
        cmocka_unit_test(opposite_normals_do_not_cancel_out), cmocka_unit_test(black_texels_shine),
        cmocka_unit_test(a_lobe_carries_specular_flux_along_the_mirrored_sun),
        cmocka_unit_test(blue_noise_has_each_value_once)
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
