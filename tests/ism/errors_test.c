/* errors_test - bad input: a specific error with outputs untouched, or finite results; cancelling; descs. */

#define ISM_STATIC
#define ISM_IMPLEMENTATION
#include "ism.h"

#include <float.h>
#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "util.h"

#define NOT_A_NUMBER ism__from_bits(0x7fc00000u)
#define INF ism__from_bits(0x7f800000u)

enum { W = 16, H = 8, PIXELS = W * H };

typedef struct world { ism_mesh mesh; ism_source source; ism_points view; ism_frame frame; ism_maps *maps; } world;

static soup soup_of_test;
static grid lit, eye;

static ism_desc small_desc(void)
{
    ism_desc d;
    memset(&d, 0, sizeof d);
    d.vpl_count = 16;
    d.surfel_count = 64;
    d.tile_side = 16;
    return d;
}

static void open_world(world *w, const ism_desc *desc)
{
    const float lo[3] = { -1, 0.5f, -1 }, hi[3] = { 0, 1, 1 }, a[3] = { -2, 0, -2 }, u[3] = { 4, 0, 0 },
                v[3] = { 0, 0, 4 };
    const float up[3] = { 0, 1, 0 }, down[3] = { 0, -1, 0 }, high[3] = { -2, 2, -2 };
    ism_desc d = desc ? *desc : small_desc();
    memset(w, 0, sizeof *w);
    soup_of_test.triangles = 0;
    soup_box(&soup_of_test, lo, hi, 1, 2);
    w->mesh = soup_mesh(&soup_of_test);
    grid_fill(&lit, 8, 8, a, u, v, up, 1);
    grid_fill(&eye, W, H, high, u, v, down, 0);
    w->source = grid_source(&lit);
    w->view = grid_view(&eye);
    w->frame.mesh = &w->mesh;
    w->frame.sources = &w->source;
    w->frame.source_count = 1;
    w->frame.points = &w->view;
    assert_int_equal(ism_create(&d, &w->maps), ISM_OK);
}

/* Renders: on failure nothing may be written, on success all must be finite and not negative. */
static ism_result try_render(world *w, const ism_shading *s)
{
    float out[3 * PIXELS], before[3 * PIXELS];
    ism_stats stats, untouched;
    ism_result r;
    size_t i;
    memset(out, 0x31, sizeof out);
    memcpy(before, out, sizeof out);
    memset(&stats, 0x31, sizeof stats);
    untouched = stats;
    r = ism_render(w->maps, &w->frame, s, out, &stats);
    if (r != ISM_OK) {
        assert_memory_equal(out, before, sizeof out);
        assert_memory_equal(&stats, &untouched, sizeof stats);
    } else {
        for (i = 0; i < 3 * PIXELS; i++) assert_true(out[i] >= 0 && out[i] < 1e30f);
    }
    return r;
}

static void descs_are_checked(void **state)
{
    ism_maps *maps = NULL;
    ism_desc d;
    int i;
    (void)state;
    for (i = 0; i < 19; i++) {
        d = small_desc();
        switch (i) {
        case 0: d.vpl_count = 16385; break;
        case 1: d.surfel_count = 7; break;
        case 2: d.surfel_count = 65537; break;
        case 3: d.tile_side = 4; break;
        case 4: d.tile_side = 48; break;
        case 5: d.tile_side = 512; break;
        case 6: d.importance = ISM_IMPORTANCE_COUNT; break;
        case 7: d.spread = ISM_SPREAD_COUNT; break;
        case 8: d.projection = ISM_PROJECTION_COUNT; break;
        case 9: d.view_grid_side = 17; break;
        case 10: d.blur_radius = 17; break;
        case 11: d.lazy_frames = 65; break;
        case 12: d.flux_share = -0.1f; break;
        case 13: d.area_share = 1.5f; break;
        case 14: d.splat_scale = NOT_A_NUMBER; break;
        case 15: d.window_rim = 1; break;
        case 16: d.tile_side = 0; d.window_rim = 33; break;
        case 17: d.tile_side = 8; d.window_rim = 5; break;
        default: d.system.allocator.alloc_fn = ledger_alloc; break;
        }
        assert_int_equal(ism_create(&d, &maps), ISM_ERR_DESC);
        assert_null(maps);
    }
    assert_int_equal(ism_create(NULL, NULL), ISM_ERR_ARGUMENT);
    ism_free(NULL);
    for (i = 0; i < ISM_RESULT_COUNT; i++) assert_true(strlen(ism_result_text((ism_result)i)) > 1);
    assert_string_equal(ism_result_text((ism_result)999), "unknown result");
}

static void arguments_are_checked(void **state)
{
    world w;
    float out[3 * PIXELS];
    size_t n;
    uint32_t bad_index[3] = { 0, 1, 4000000000u };
    ism_shading s = { 0 };
    ism_vpl v = util_vpl(0, 0, 0, 0, 1, 0, 1);
    (void)state;
    open_world(&w, NULL);
    assert_int_equal(ism_shade(w.maps, &w.view, NULL, out, NULL), ISM_ERR_ORDER);
    assert_int_equal(ism_build(w.maps, &w.frame), ISM_ERR_ORDER);
    assert_int_equal(ism_surfels(w.maps, 0, NULL, 0, &n), ISM_ERR_ORDER);
    assert_null(ism_atlas(w.maps, NULL, NULL));
    assert_null(ism_importances(w.maps, 0, &n));
    assert_int_equal(util_visible(w.maps, 0, out, out, 1, 0, out), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_render(NULL, &w.frame, NULL, out, NULL), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_render(w.maps, NULL, NULL, out, NULL), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_render(w.maps, &w.frame, NULL, NULL, NULL), ISM_ERR_ARGUMENT);
    assert_int_equal(try_render(&w, NULL), ISM_OK);
    s.interleave = 3;
    assert_int_equal(try_render(&w, &s), ISM_ERR_DESC);
    memset(&s, 0, sizeof s);
    s.bias = 1;
    assert_int_equal(try_render(&w, &s), ISM_ERR_DESC);
    memset(&s, 0, sizeof s);
    s.clamp = NOT_A_NUMBER;
    assert_int_equal(try_render(&w, &s), ISM_ERR_DESC);
    w.view.count = 0;
    assert_int_equal(try_render(&w, NULL), ISM_ERR_ARGUMENT);
    w.view.count = PIXELS;
    w.view.position_stride = 10;
    assert_int_equal(try_render(&w, NULL), ISM_ERR_ARGUMENT);
    w.view.position_stride = 0;
    w.view.world_to_clip[3] = INF;
    assert_int_equal(try_render(&w, NULL), ISM_ERR_INPUT);
    w.view.world_to_clip[3] = 0;
    w.source.normals = NULL;
    assert_int_equal(try_render(&w, NULL), ISM_ERR_ARGUMENT);
    w.source.normals = lit.n;
    w.source.width = w.source.height = 65535;
    assert_int_equal(try_render(&w, NULL), ISM_ERR_LIMIT);
    w.source.width = w.source.height = 8;
    w.mesh.vertex_stride = 6;
    assert_int_equal(try_render(&w, NULL), ISM_ERR_ARGUMENT);
    w.mesh.vertex_stride = 0;
    w.mesh.indices = bad_index;
    w.mesh.index_count = 3;
    assert_int_equal(try_render(&w, NULL), ISM_ERR_INPUT);
    w.mesh.indices = NULL;
    v.flux[1] = -1;
    assert_int_equal(ism_set_vpls(w.maps, &v, 1), ISM_ERR_INPUT);
    v.flux[1] = 1;
    v.normal[0] = 3;
    assert_int_equal(ism_set_vpls(w.maps, &v, 1), ISM_ERR_INPUT);
    assert_int_equal(ism_set_vpls(w.maps, &v, 17), ISM_ERR_LIMIT);
    assert_int_equal(ism_bounce(w.maps, &w.mesh, 8, out, out, out), ISM_ERR_MISMATCH);
    assert_int_equal(ism_bounce(w.maps, &w.mesh, 3, out, out, out), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_sky_directions(out, 4, 0, 0, out, out, NULL), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_emitter_points(&w.mesh, NULL, 1, 0, NULL, out, out, out), ISM_ERR_ARGUMENT);
    assert_int_equal(try_render(&w, NULL), ISM_OK);         /* and it goes on */
    ism_free(w.maps);
}

/* The last value that is taken and the first that is not, for every range. */
#define MADE(expected, change)                                                                                         \
    do {                                                                                                               \
        ism_desc d = small_desc();                                                                                     \
        ism_maps *made = NULL;                                                                                         \
        change;                                                                                                        \
        assert_int_equal(ism_create(&d, &made), expected);                                                             \
        assert_true((made == NULL) == (expected != ISM_OK));                                                           \
        ism_free(made);                                                                                                \
    } while (0)

static void limits_of_descs_are_exact(void **state)
{
    (void)state;
    MADE(ISM_OK, d.vpl_count = 16384);
    MADE(ISM_OK, d.surfel_count = 8);
    MADE(ISM_OK, d.surfel_count = 65536);
    MADE(ISM_OK, d.tile_side = 8);
    MADE(ISM_OK, d.tile_side = 256);
    MADE(ISM_ERR_DESC, d.tile_side = 24);
    MADE(ISM_OK, d.view_grid_side = 16);
    MADE(ISM_OK, d.blur_radius = 16);
    MADE(ISM_OK, d.lazy_frames = 64);
    MADE(ISM_OK, d.flux_share = 1);
    MADE(ISM_ERR_DESC, d.flux_share = 1.0001f);
    MADE(ISM_ERR_DESC, d.flux_share = NOT_A_NUMBER);
    MADE(ISM_OK, d.area_share = 1);
    MADE(ISM_ERR_DESC, d.area_share = -0.0001f);
    MADE(ISM_OK, d.splat_scale = 16);
    MADE(ISM_ERR_DESC, d.splat_scale = 16.01f);
    MADE(ISM_ERR_DESC, d.splat_scale = -0.01f);
    MADE(ISM_ERR_DESC, d.importance = (ism_importance)-1);
    MADE(ISM_ERR_DESC, d.spread = (ism_spread)-1);
    MADE(ISM_ERR_DESC, d.projection = (ism_projection)-1);
    MADE(ISM_ERR_DESC, d.system.allocator.free_fn = ledger_free);
}

static void limits_of_frames_are_exact(void **state)
{
    static const uint32_t patterns[10] = { 1, 1, 1, 0, 1, 0, 0, 0, 1, 0 };
    float out[3 * PIXELS];
    ism_vpl v0 = util_vpl(0, 0, 0, 0, 1, 0, 1);
    ism_shading s;
    world w;
    int i;
    (void)state;
    open_world(&w, NULL);
    for (i = 0; i < 10; i++) {
        memset(&s, 0, sizeof s);
        s.interleave = (uint32_t)i;
        assert_int_equal(try_render(&w, &s), patterns[i] ? ISM_OK : ISM_ERR_DESC);
    }
#define SHADED(expected, change)                                                                                       \
    do {                                                                                                               \
        memset(&s, 0, sizeof s);                                                                                       \
        change;                                                                                                        \
        assert_int_equal(try_render(&w, &s), expected);                                                                \
    } while (0)
    SHADED(ISM_OK, s.bias = 0);
    SHADED(ISM_OK, s.bias = -1);
    SHADED(ISM_ERR_DESC, s.bias = NOT_A_NUMBER);
    SHADED(ISM_OK, s.bias = 0.999f);
    SHADED(ISM_ERR_DESC, s.bias = 1);
    SHADED(ISM_OK, memset(&s, 0, sizeof s));
    SHADED(ISM_OK, s.clamp = 0);
    SHADED(ISM_ERR_DESC, s.clamp = -1);
    SHADED(ISM_OK, s.near_mode = ISM_NEAR_CLAMP; s.clamp = 0);
    SHADED(ISM_OK, s.near_mode = ISM_NEAR_CLAMP_MEAN; s.clamp = 0);
    SHADED(ISM_ERR_DESC, s.clamp = INF);
    SHADED(ISM_ERR_DESC, s.near_mode = ISM_NEAR_COUNT);
    SHADED(ISM_ERR_DESC, s.near_mode = (ism_near)-1);
#define SOURCED(expected, change)                                                                                      \
    do {                                                                                                               \
        const ism_source kept = w.source;                                                                              \
        change;                                                                                                        \
        assert_int_equal(try_render(&w, NULL), expected);                                                              \
        w.source = kept;                                                                                               \
    } while (0)
    SOURCED(ISM_ERR_ARGUMENT, w.source.width = 0);
    SOURCED(ISM_ERR_ARGUMENT, w.source.height = 0);
    SOURCED(ISM_ERR_ARGUMENT, w.source.positions = NULL);
    SOURCED(ISM_ERR_ARGUMENT, w.source.fluxes = NULL);
    SOURCED(ISM_ERR_ARGUMENT, w.source.position_stride = 10);
    SOURCED(ISM_ERR_ARGUMENT, w.source.position_stride = 8);
    SOURCED(ISM_ERR_ARGUMENT, w.source.normal_stride = 13);
    SOURCED(ISM_ERR_ARGUMENT, w.source.flux_stride = 4);
    SOURCED(ISM_ERR_ARGUMENT, w.source.lobe_stride = 12);
    SOURCED(ISM_ERR_ARGUMENT, w.source.area_stride = 6);
    SOURCED(ISM_ERR_INPUT, w.source.kind = (ism_source_kind)7);
    SOURCED(ISM_ERR_LIMIT, w.source.width = (1u << 26) / 8u + 1u);
    w.frame.sources = NULL;
    assert_int_equal(try_render(&w, NULL), ISM_ERR_ARGUMENT);
    w.frame.sources = &w.source;
#define VIEWED(expected, change)                                                                                       \
    do {                                                                                                               \
        const ism_points kept = w.view;                                                                                \
        change;                                                                                                        \
        assert_int_equal(try_render(&w, NULL), expected);                                                              \
        w.view = kept;                                                                                                 \
    } while (0)
    VIEWED(ISM_ERR_ARGUMENT, w.view.positions = NULL);
    VIEWED(ISM_ERR_ARGUMENT, w.view.normals = NULL);
    VIEWED(ISM_ERR_ARGUMENT, w.view.count = 0);
    VIEWED(ISM_ERR_ARGUMENT, w.view.count--);
    VIEWED(ISM_ERR_LIMIT, w.view.count = (1u << 28) + 1u; w.view.width = 0);
    VIEWED(ISM_ERR_ARGUMENT, w.view.normal_stride = 6);
    VIEWED(ISM_ERR_ARGUMENT, w.view.geometric_normal_stride = 14);
    VIEWED(ISM_ERR_ARGUMENT, w.view.albedo_stride = 8);
    for (i = 0; i < 16; i++) VIEWED(ISM_ERR_INPUT, w.view.world_to_clip[i] = NOT_A_NUMBER);
    VIEWED(ISM_ERR_INPUT, w.view.rows = ISM_ROWS_COUNT);
    VIEWED(ISM_ERR_INPUT, w.view.rows = (ism_rows)-1);
    w.mesh.vertex_count = 4;
    assert_int_equal(try_render(&w, NULL), ISM_ERR_ARGUMENT);
    w.mesh.vertex_count = 3;
    w.mesh.positions = NULL;
    assert_int_equal(try_render(&w, NULL), ISM_ERR_ARGUMENT);
    w.mesh.vertex_count = 0;
    assert_int_equal(try_render(&w, NULL), ISM_OK);
#define LISTED(expected, change)                                                                                       \
    do {                                                                                                               \
        ism_vpl v = v0;                                                                                                \
        change;                                                                                                        \
        assert_int_equal(ism_set_vpls(w.maps, &v, 1), expected);                                                       \
    } while (0)
    for (i = 0; i < 3; i++) {
        LISTED(ISM_ERR_INPUT, v.position[i] = INF);
        LISTED(ISM_ERR_INPUT, v.normal[i] = NOT_A_NUMBER);
        LISTED(ISM_ERR_INPUT, v.axis[i] = NOT_A_NUMBER);
        LISTED(ISM_ERR_INPUT, v.flux[i] = -0.1f);
        LISTED(ISM_ERR_INPUT, v.flux[i] = INF);
        LISTED(ISM_OK, v.flux[i] = 1e30f);
        LISTED(ISM_ERR_INPUT, v.flux[i] = 2e30f);
    }
    LISTED(ISM_OK, v.normal[1] = 1.0299f);
    LISTED(ISM_OK, v.axis[1] = 0.9701f);
    LISTED(ISM_ERR_INPUT, v.normal[1] = 1.0301f);
    LISTED(ISM_ERR_INPUT, v.axis[1] = 0.9699f);
    LISTED(ISM_ERR_INPUT, v.normal[1] = 0);
    LISTED(ISM_OK, v.exponent = 0);
    LISTED(ISM_OK, v.exponent = 1e5f);
    LISTED(ISM_ERR_INPUT, v.exponent = 1.1e5f);
    LISTED(ISM_ERR_INPUT, v.exponent = -0.1f);
    LISTED(ISM_OK, v.area = 0);
    LISTED(ISM_ERR_INPUT, v.area = -0.1f);
    LISTED(ISM_ERR_INPUT, v.area = INF);
    assert_int_equal(ism_set_vpls(w.maps, NULL, 1), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_set_vpls(NULL, &v0, 1), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_set_vpls(w.maps, NULL, 0), ISM_OK);
    assert_int_equal(ism_choose(w.maps, NULL), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_choose(NULL, &w.frame), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_scatter(NULL, &w.frame), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_build(NULL, &w.frame), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_shade(w.maps, &w.view, NULL, NULL, NULL), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_shade(NULL, &w.view, NULL, out, NULL), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_shade(w.maps, NULL, NULL, out, NULL), ISM_ERR_ARGUMENT);
    assert_null(ism_vpls(NULL, NULL));
    ism_free(w.maps);
}

static void limits_of_queries_are_exact(void **state)
{
    static float p[3 * 16 * 16 * 16], n[3 * 16 * 16 * 16], f[3 * 16 * 16 * 16], radiance[3 * 4096];
    ism_surfel points[64];
    ism_system half = { { ledger_alloc, NULL, NULL }, NULL, NULL, NULL, NULL };
    float visible[PIXELS];
    ism_info info = { { 0 }, 0, 0, 0, 0, 0, { 0 }, 7 };
    ism_desc d = small_desc();
    ism_mesh other;
    size_t count;
    uint32_t side, tiles, indices[3 * 4096];
    uint64_t bad;
    world w;
    (void)state;
    d.keep_hits = 1;
    open_world(&w, &d);
    assert_int_equal(ism_choose(w.maps, &w.frame), ISM_OK);
    assert_int_equal(util_visible(w.maps, 0, eye.p, eye.n, 1, 0, visible), ISM_ERR_ORDER);
    assert_int_equal(ism_build(w.maps, &w.frame), ISM_OK);
    assert_int_equal(util_visible(w.maps, 15, eye.p, eye.n, 1, 0, visible), ISM_OK);
    assert_int_equal(util_visible(w.maps, 16, eye.p, eye.n, 1, 0, visible), ISM_ERR_ARGUMENT);
    assert_int_equal(util_visible(w.maps, 0, eye.p, eye.n, 1, 1, visible), ISM_ERR_ARGUMENT);
    assert_int_equal(util_visible(w.maps, 0, eye.p, eye.n, 1, -0.1f, visible), ISM_OK);
    assert_int_equal(ism_visible(w.maps, 0, NULL, 0, visible), ISM_ERR_ARGUMENT);
    assert_int_equal(util_visible(w.maps, 0, NULL, eye.n, 1, 0, visible), ISM_ERR_ARGUMENT);
    assert_int_equal(util_visible(w.maps, 0, eye.p, NULL, 1, 0, visible), ISM_ERR_ARGUMENT);
    assert_int_equal(util_visible(w.maps, 0, eye.p, eye.n, 1, 0, NULL), ISM_ERR_ARGUMENT);
    assert_int_equal(util_visible(w.maps, 0, eye.p, eye.n, 0, 0, visible), ISM_ERR_ARGUMENT);
    assert_int_equal(util_visible(NULL, 0, eye.p, eye.n, 1, 0, visible), ISM_ERR_ARGUMENT);
    memset(points, 0x55, sizeof points);
    assert_int_equal(ism_surfels(w.maps, 15, points, 3, &count), ISM_OK);
    assert_true(count == 64 && points[2].area > 0 && points[2].area < 1e6f && points[3].triangle == 0x55555555u);
    assert_int_equal(ism_surfels(w.maps, 16, points, 3, &count), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_surfels(w.maps, 0, NULL, 3, &count), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_surfels(w.maps, 0, points, 3, NULL), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_surfels(NULL, 0, points, 3, &count), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_phase_surfels(w.maps, 7, points, 64, &count), ISM_OK);
    assert_int_equal(count, 16 * 8);
    assert_int_equal(ism_phase_surfels(w.maps, 8, points, 64, &count), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_phase_surfels(w.maps, 0, NULL, 64, &count), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_phase_surfels(w.maps, 0, points, 64, NULL), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_phase_surfels(NULL, 0, points, 64, &count), ISM_ERR_ARGUMENT);
    ism_get_info(NULL, &info);
    ism_get_info(w.maps, NULL);
    assert_true(info.radius >= 7 && info.radius <= 7);
    ism_get_info(w.maps, &info);
    assert_true(info.vpl_count == 16 && info.surfel_count == 64 && info.tile_side == 16 && info.lazy_frames == 8);
    assert_non_null(ism_atlas(w.maps, &side, &tiles));
    assert_true(side == 64 && tiles == 4);
    assert_null(ism_atlas(NULL, &side, &tiles));
    assert_non_null(ism_importances(w.maps, 0, NULL));
    assert_null(ism_importances(w.maps, 1, &count));
    assert_null(ism_importances(NULL, 0, &count));
    other = w.mesh;
    other.vertex_count -= 3;
    assert_int_equal(ism_bounce(w.maps, &w.mesh, 16, p, n, f), ISM_OK);
    assert_int_equal(ism_bounce(w.maps, &other, 16, p, n, f), ISM_ERR_MISMATCH);
    other = w.mesh;                              /* as many triangles, with indices of another mesh's */
    other.indices = indices;
    other.index_count = w.mesh.vertex_count;
    for (count = 0; count < other.index_count; count++) indices[count] = (uint32_t)count;
    assert_int_equal(ism_bounce(w.maps, &other, 16, p, n, f), ISM_OK);
    other.vertex_count--;
    f[0] = 77;
    assert_int_equal(ism_bounce(w.maps, &other, 16, p, n, f), ISM_ERR_INPUT);
    assert_true(f[0] >= 77 && f[0] <= 77);
    assert_int_equal(ism_bounce(w.maps, &w.mesh, 32, p, n, f), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_bounce(w.maps, &w.mesh, 12, p, n, f), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_bounce(w.maps, &w.mesh, 0, p, n, f), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_bounce(NULL, &w.mesh, 8, p, n, f), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_bounce(w.maps, NULL, 8, p, n, f), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_bounce(w.maps, &w.mesh, 8, NULL, n, f), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_bounce(w.maps, &w.mesh, 8, p, NULL, f), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_bounce(w.maps, &w.mesh, 8, p, n, NULL), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_sky_directions(f, 4, 2, INF, p, n, NULL), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_sky_directions(f, 0, 2, 0, p, n, NULL), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_sky_directions(NULL, 4, 2, 0, p, n, NULL), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_sky_directions(f, 4, 2, 0, NULL, n, NULL), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_sky_directions(f, 4, 2, 0, p, NULL, NULL), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_sky_directions(radiance, 4, 2, 0, p, n, &bad), ISM_OK);
    assert_int_equal(bad, 0);
    assert_int_equal(ism_emitter_points(&w.mesh, radiance, 4, 0, NULL, p, n, f), ISM_ERR_INPUT);   /* all dark */
    radiance[5] = -1;
    radiance[7] = NOT_A_NUMBER;
    assert_int_equal(ism_emitter_points(&w.mesh, radiance, 4, 0, NULL, p, n, f), ISM_ERR_INPUT);
    radiance[9] = 1;
    assert_int_equal(ism_emitter_points(&w.mesh, radiance, 4, 0, NULL, p, n, f), ISM_OK);
    assert_int_equal(ism_emitter_points(&w.mesh, radiance, 0, 0, NULL, p, n, f), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_emitter_points(NULL, radiance, 4, 0, NULL, p, n, f), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_emitter_points(&w.mesh, radiance, 4, 0, NULL, NULL, n, f), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_emitter_points(&w.mesh, radiance, 4, 0, NULL, p, NULL, f), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_emitter_points(&w.mesh, radiance, 4, 0, NULL, p, n, NULL), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_emitter_points(&w.mesh, radiance, 4, 0, &half, p, n, f), ISM_ERR_DESC);
    other.vertex_count = 0;
    assert_int_equal(ism_emitter_points(&other, radiance, 4, 0, NULL, p, n, f), ISM_ERR_ARGUMENT);
    other.indices = NULL;
    assert_int_equal(ism_emitter_points(&other, radiance, 4, 0, NULL, p, n, f), ISM_ERR_ARGUMENT);
    ism_free(w.maps);
}

/* Tiles beyond the last VPL, which are drawn by nobody, whatever was there before. */
static void tiles_of_no_vpl_are_empty(void **state)
{
    static const size_t counts[] = { 10, 3, 7, 0 };
    ism_desc d = small_desc();
    ism_vpl list[10];
    size_t i, k, x, y;
    ledger l;
    world w;
    (void)state;
    d.vpl_count = 10;
    d.keep_hits = 1;
    d.system.allocator = ledger_allocator(&l);
    open_world(&w, &d);
    assert_int_equal(ism_choose(w.maps, &w.frame), ISM_OK);
    memcpy(list, ism_vpls(w.maps, NULL), sizeof list);
    for (i = 0; i < 4; i++) {
        uint32_t side, tiles;
        const float *atlas;
        size_t full = 0;
        assert_int_equal(ism_set_vpls(w.maps, list, counts[i]), ISM_OK);
        assert_int_equal(ism_build(w.maps, &w.frame), ISM_OK);
        atlas = ism_atlas(w.maps, &side, &tiles);
        assert_true(atlas && side == 64 && tiles == 4);
        for (k = 0; k < 16; k++)
            for (y = k / 4 * 16; y < k / 4 * 16 + 16; y++)
                for (x = k % 4 * 16; x < k % 4 * 16 + 16; x++) {
                    uint32_t hit = ((const uint32_t *)w.maps->hits.data)[y * side + x];
                    full += atlas[y * side + x] < ISM_FAR;
                    if (k >= counts[i]) assert_true(atlas[y * side + x] >= ISM_FAR && atlas[y * side + x] <= ISM_FAR);
                    if (k >= counts[i]) assert_int_equal(hit, UINT32_MAX);
                }
        assert_true((full > 0) == (counts[i] > 0));
    }
    ism_free(w.maps);
    assert_int_equal(l.live, 0);
}

/* One flux whose mean is infinite takes no VPLs from the others. */
static void fluxes_beyond_all_sums_are_bad(void **state)
{
    const ism_vpl *v;
    ism_stats stats;
    size_t count, i;
    world w;
    (void)state;
    open_world(&w, NULL);
    lit.f[3 * 9] = lit.f[3 * 9 + 1] = lit.f[3 * 9 + 2] = 2e38f;
    assert_int_equal(ism_choose(w.maps, &w.frame), ISM_OK);
    stats = util_stats(w.maps);
    assert_int_equal(stats.bad_pvpls, 1);
    v = ism_vpls(w.maps, &count);
    assert_int_equal(count, 16);
    for (i = 0; i < count; i++) assert_true(v[i].texel != 9 && v[i].flux[0] > 0 && v[i].flux[0] < 100);
    ism_free(w.maps);
}

static int cancel_after(void *user, float fraction)
{
    (void)fraction;
    return --*(int *)user < 0;
}

/* Importances of a choice that was cancelled are none, though VPLs may be set after it. */
static void a_cancelled_choice_has_no_importances(void **state)
{
    ism_desc d = small_desc();
    ism_vpl v = util_vpl(0, 0, 0, 0, 1, 0, 1);
    int left = 1 << 30, calls, at;
    ism_source two[2];
    size_t n;
    world w;
    (void)state;
    d.system.progress = cancel_after;
    d.system.user = &left;
    open_world(&w, &d);
    two[0] = two[1] = w.source;
    assert_int_equal(ism_choose(w.maps, &w.frame), ISM_OK);
    w.frame.sources = two;
    w.frame.source_count = 2;
    assert_int_equal(ism_choose(w.maps, &w.frame), ISM_OK);
    calls = (1 << 30) - left;
    for (at = 0; at < calls; at++) {
        ism_result r;
        left = at;
        r = ism_choose(w.maps, &w.frame);
        if (r == ISM_OK) break;
        assert_int_equal(r, ISM_ERR_CANCELLED);
        assert_null(ism_importances(w.maps, 0, &n));
        assert_int_equal(ism_build(w.maps, &w.frame), ISM_ERR_ORDER);
        left = 1 << 30;
        assert_int_equal(ism_set_vpls(w.maps, &v, 1), ISM_OK);
        if (ism_importances(w.maps, 1, &n)) assert_int_equal(n, 64);    /* cancelled while VPLs were finished */
        left = at / 2;
        if (ism_set_vpls(w.maps, &v, 1) == ISM_ERR_CANCELLED)
            assert_int_equal(ism_build(w.maps, &w.frame), ISM_ERR_ORDER);
    }
    assert_true(at > 4);
    ism_free(w.maps);
}

/* Three sources: one dark, lobes of which some are no lobes, a sky. VPLs are of the last two alone, in proportion to
   their flux, with the lobe of their texel; what is not usable is counted. */
static void several_sources_share_the_vpls(void **state)
{
    enum { TEXELS = 64, ALL = 4096 };
    static float lobes[4 * TEXELS], areas[2 * TEXELS], dark[3 * TEXELS], sky[3 * 4], to_sky[3 * 4];
    static float out[3 * PIXELS];
    uint32_t indices[3] = { 0, 1, 2 }, of_source[3] = { 0, 0, 0 };
    float radiance[3] = { 1, 1, 1 }, p[3], n[3], f[3];
    ism_desc d = small_desc();
    ism_shading s = { 0 };
    ism_source sources[3];
    const ism_vpl *v;
    ism_stats stats;
    ism_points flat;
    size_t count, i;
    world w;
    (void)state;
    d.vpl_count = ALL;
    d.surfel_count = 8;
    d.tile_side = 8;
    d.importance = ISM_IMPORTANCE_FLUX;
    open_world(&w, &d);
    for (i = 0; i < TEXELS; i++) {
        lobes[4 * i] = 0.6f;
        lobes[4 * i + 1] = 0.8f;
        lobes[4 * i + 3] = (float)i;
        areas[2 * i] = 0.5f;
    }
    lobes[0] = NOT_A_NUMBER;
    lobes[4] = lobes[5] = 0;
    lobes[4 * 2 + 3] = -1;
    lobes[4 * 3 + 3] = 2e5f;
    lobes[4 * 4 + 3] = NOT_A_NUMBER;
    areas[2 * 5] = NOT_A_NUMBER;
    areas[2 * 6] = -1;
    areas[2 * 7] = INF;
    for (i = 0; i < 4; i++) {
        to_sky[3 * i + 1] = i % 2 ? 1.0f : 0.0f;
        to_sky[3 * i + 2] = i % 2 ? 0.0f : 1.0f;
        sky[3 * i] = sky[3 * i + 1] = sky[3 * i + 2] = 59.0f / 4;
    }
    sources[0] = sources[1] = sources[2] = w.source;
    sources[0].fluxes = dark;
    sources[1].lobes = lobes;
    sources[1].areas = areas;
    sources[1].area_stride = 8;
    sources[2].kind = ISM_SOURCE_DIRECTIONS;
    sources[2].width = sources[2].height = 2;
    sources[2].positions = to_sky;
    sources[2].normals = NULL;
    sources[2].fluxes = sky;
    w.frame.sources = sources;
    w.frame.source_count = 3;
    assert_int_equal(ism_choose(w.maps, &w.frame), ISM_OK);
    stats = util_stats(w.maps);
    assert_int_equal(stats.bad_pvpls, 5);
    v = ism_vpls(w.maps, &count);
    assert_int_equal(count, ALL);
    for (i = 0; i < count; i++) {
        assert_in_range(v[i].source, 1, 2);
        of_source[v[i].source]++;
        if (v[i].source == 2) {
            assert_true(v[i].directional && v[i].exponent >= 1 && v[i].exponent <= 1);
            continue;
        }
        assert_in_range(v[i].texel, 5, TEXELS - 1);
        assert_true(!(v[i].exponent < (float)v[i].texel) && !(v[i].exponent > (float)v[i].texel));
        assert_true(fabsf(v[i].axis[1] - 0.8f) < 1e-6f);
        assert_true(v[i].texel < 8 ? !(v[i].area > 0) : v[i].area > 0);
    }
    assert_in_range(of_source[1], ALL / 2 - 2, ALL / 2 + 2);    /* 59 watts each */
    assert_non_null(ism_importances(w.maps, 2, &count));
    assert_int_equal(count, 4);
    assert_non_null(ism_importances(w.maps, 1, &count));
    assert_int_equal(count, TEXELS);
    assert_ptr_equal(ism_vpls(w.maps, NULL), v);
    /* rays or nothing in place of maps need no maps */
    s.no_maps = 1;
    assert_int_equal(ism_render(w.maps, &w.frame, &s, out, NULL), ISM_OK);
    assert_int_equal(ism_shade(w.maps, &w.view, NULL, out, NULL), ISM_ERR_ORDER);
    flat = w.view;
    flat.width = 0;
    s.interleave = 2;
    assert_int_equal(ism_shade(w.maps, &flat, &s, out, NULL), ISM_ERR_DESC);
    s.interleave = 0;
    assert_int_equal(ism_shade(w.maps, &flat, &s, out, NULL), ISM_OK);
    w.mesh.indices = indices;
    w.mesh.index_count = 3;
    assert_int_equal(ism_emitter_points(&w.mesh, radiance, 1, 0, NULL, p, n, f), ISM_OK);
    indices[2] = (uint32_t)w.mesh.vertex_count;
    assert_int_equal(ism_emitter_points(&w.mesh, radiance, 1, 0, NULL, p, n, f), ISM_ERR_INPUT);
    indices[2] = 1;                              /* no area: nothing emits */
    assert_int_equal(ism_emitter_points(&w.mesh, radiance, 1, 0, NULL, p, n, f), ISM_ERR_INPUT);
    ism_free(w.maps);
}

/* Values that real data holds, put into each array in turn. */
/* Points without an atlas are the atlas's own, sorted by the frame that renews them. */
static void surfels_without_an_atlas_are_the_atlas_s_own(void **state)
{
    world w, whole;
    ism_desc d = small_desc();
    ism_surfel all[64], phase[16 * 13], before[1];
    float out[3 * PIXELS], center[3] = { 9, 9, 9 }, radius = 9;
    size_t n, p, v, j;
    (void)state;
    d.surfel_count = 61;                          /* not a multiple of lazy */
    d.lazy_frames = 5;
    open_world(&w, &d);
    assert_int_equal(ism_scatter(w.maps, &w.frame), ISM_ERR_ORDER);
    assert_int_equal(ism_phase_surfels(w.maps, 0, NULL, 0, &n), ISM_ERR_ORDER);
    assert_int_equal(ism_choose(w.maps, &w.frame), ISM_OK);
    assert_int_equal(ism_scatter(w.maps, NULL), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_scatter(w.maps, &w.frame), ISM_OK);
    assert_null(ism_atlas(w.maps, NULL, NULL));
    assert_int_equal(ism_shade(w.maps, &w.view, NULL, out, NULL), ISM_ERR_ORDER);
    assert_int_equal(ism_phase_surfels(w.maps, 5, NULL, 0, &n), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_phase_surfels(w.maps, 0, NULL, 1, &n), ISM_ERR_ARGUMENT);
    memset(before, 0x31, sizeof before);
    assert_int_equal(ism_phase_surfels(w.maps, 0, before, 0, &n), ISM_OK);
    assert_int_equal(n, 16 * 13);
    assert_int_equal(before[0].triangle, 0x31313131);
    open_world(&whole, &d);
    assert_int_equal(try_render(&whole, NULL), ISM_OK);
    for (p = 0; p < 5; p++) {
        assert_int_equal(ism_phase_surfels(w.maps, (uint32_t)p, phase, 16 * 13, &n), ISM_OK);
        for (v = 0; v < 16; v++) {
            assert_int_equal(ism_surfels(whole.maps, (uint32_t)v, all, 64, &n), ISM_OK);
            for (j = 0; j < 13; j++) {
                if (p + 5 * j < 61) assert_memory_equal(&phase[13 * v + j], &all[p + 5 * j], sizeof all[0]);
                else assert_true(phase[13 * v + j].area == 0);
            }
        }
    }
    util_bounds(w.maps, center, &radius);    /* of a box 1 x 0.5 x 2 */
    assert_true(fabsf(center[0] + 0.5f) < 1e-5f && fabsf(center[1] - 0.75f) < 1e-5f && fabsf(center[2]) < 1e-5f);
    assert_true(fabsf(radius - 0.5f * sqrtf(5.25f)) < 0.01f);
    ism_free(w.maps);
    ism_free(whole.maps);
}

static int wrong_lengths(const float *normals)
{
    size_t i, wrong = 0;
    for (i = 0; i < PIXELS; i++) {
        const double x = (double)normals[3 * i], y = (double)normals[3 * i + 1], z = (double)normals[3 * i + 2];
        const double length = sqrt(x * x + y * y + z * z);
        wrong += isfinite(length) && (x != 0 || y != 0 || z != 0) && !(length >= 0.97 && length <= 1.03);
    }
    return wrong > 0;
}

static void odd_values_give_finite_light(void **state)
{
    const float odd[] = { NOT_A_NUMBER, INF, -INF, 1e30f, -1e30f, 1e-40f, FLT_MAX, 0.0f, -1.0f };
    size_t k, array;
    uint32_t projection, mode;
    (void)state;
    for (k = 0; k < sizeof odd / sizeof odd[0]; k++)
        for (array = 0; array < 6; array++) {
            world w;
            size_t i;
            float *to[6];
            ism_shading s = { 0 };
            ism_desc d = small_desc();
            d.projection = (ism_projection)(1 + k % 4);
            open_world(&w, &d);
            s.near_mode = (ism_near)(1 + (k + array) % 4);
            s.interleave = k % 2 ? 2 : 1;
            to[0] = soup_of_test.p;
            to[1] = lit.p;
            to[2] = lit.n;
            to[3] = lit.f;
            to[4] = eye.p;
            to[5] = eye.n;
            for (i = 0; i < 20; i++) to[array][7 * i] = odd[k];
            if (array == 3 && odd[k] > 1e20f) {     /* light without bounds has no finite sum */
                ism_free(w.maps);
                continue;
            }
            /* finite normals are unit or 0 0 0 */
            assert_int_equal(try_render(&w, &s), array % 3 == 2 && wrong_lengths(to[array]) ? ISM_ERR_INPUT : ISM_OK);
            ism_free(w.maps);
        }
    for (projection = 1; projection < ISM_PROJECTION_COUNT; projection++)
        for (mode = 1; mode < ISM_NEAR_COUNT; mode++) {
            /* a receiver in, on and behind every VPL; lobes; opacities */
            static float lobes[4 * 64], opacities[4096];
            world w;
            ism_desc d = small_desc();
            ism_shading s = { 0 };
            size_t i;
            d.projection = (ism_projection)projection;
            d.vary_surfels = 1;
            open_world(&w, &d);
            for (i = 0; i < 64; i++) {
                lobes[4 * i] = 0;
                lobes[4 * i + 1] = 1;
                lobes[4 * i + 2] = 0;
                lobes[4 * i + 3] = i % 2 ? 1.0f : (float)i;
            }
            for (i = 0; i < soup_of_test.triangles; i++) opacities[i] = (float)(i % 5) * 0.25f;
            w.source.lobes = lobes;
            w.mesh.opacities = opacities;
            memcpy(eye.p, lit.p, 3 * PIXELS / 2 * sizeof(float));
            s.near_mode = (ism_near)mode;
            if (mode != ISM_NEAR_NONE) assert_int_equal(try_render(&w, &s), ISM_OK);
            ism_free(w.maps);
        }
}

static void nothing_to_do_is_no_error(void **state)
{
    world w;
    size_t n;
    (void)state;
    open_world(&w, NULL);
    memset(lit.f, 0, sizeof lit.f);
    assert_int_equal(try_render(&w, NULL), ISM_OK);         /* no light */
    ism_vpls(w.maps, &n);
    assert_int_equal(n, 0);
    w.frame.source_count = 0;
    assert_int_equal(try_render(&w, NULL), ISM_OK);
    ism_free(w.maps);
    open_world(&w, NULL);
    w.frame.mesh = NULL;
    assert_int_equal(try_render(&w, NULL), ISM_OK);         /* no occluders */
    memset(soup_of_test.p, 0, sizeof soup_of_test.p);
    w.frame.mesh = &w.mesh;
    assert_int_equal(try_render(&w, NULL), ISM_OK);         /* degenerate ones */
    memset(eye.n, 0, sizeof eye.n);
    assert_int_equal(try_render(&w, NULL), ISM_OK);         /* background alone */
    ism_free(w.maps);
}

static void a_sky_lights_and_shadows(void **state)
{
    static float texels[3 * 32 * 16], directions[3 * 32 * 16], fluxes[3 * 32 * 16], out[3 * PIXELS];
    world w;
    ism_desc d = small_desc();
    uint64_t bad;
    double sum = 0;
    size_t i;
    (void)state;
    for (i = 0; i < 3 * 32 * 16; i++) texels[i] = 1;
    texels[5] = NOT_A_NUMBER;
    assert_int_equal(ism_sky_directions(texels, 32, 16, 0, directions, fluxes, &bad), ISM_OK);
    assert_int_equal(bad, 1);
    texels[5] = 1;
    assert_int_equal(ism_sky_directions(texels, 32, 16, 0.3f, directions, fluxes, &bad), ISM_OK);
    for (i = 0; i < 32 * 16; i++) sum += (double)fluxes[3 * i];
    assert_true(fabs(sum - 4 * UTIL_PI) < 1e-4);
    d.vpl_count = 512;
    d.surfel_count = 1024;
    d.tile_side = 32;
    open_world(&w, &d);
    memset(&w.source, 0, sizeof w.source);
    w.source.kind = ISM_SOURCE_DIRECTIONS;
    w.source.width = 32;
    w.source.height = 16;
    w.source.positions = directions;
    w.source.fluxes = fluxes;
    for (i = 0; i < PIXELS; i++) {                          /* on the ground, the left half under the box */
        eye.p[3 * i + 1] = 0;
        eye.n[3 * i + 1] = 1;
        eye.p[3 * i] = i % 2 ? 3.5f : -0.5f;
        eye.p[3 * i + 2] = 0;
    }
    assert_int_equal(ism_render(w.maps, &w.frame, NULL, out, NULL), ISM_OK);
    assert_true(fabs((double)out[3] - UTIL_PI) < 0.3);               /* the box covers 2 % of that sky */
    assert_true(out[0] < 0.6f * out[3]);
    ism_free(w.maps);
}

static int stop_at;
static int count_down(void *user, float fraction)
{
    (void)user;
    assert_true(fraction >= 0 && fraction <= 1);
    return stop_at-- == 0;
}

/* VPL n is point n of all sources, as ism_set_vpls takes it; points without flux keep their number, whatever else they
   hold. */
static void sources_become_vpls_point_by_point(void **state)
{
    static float at[3 * 4] = { 0, 1, 0, 1, 2, 3, 0, 0, 0, -1, 0, 2 };
    static float normal[3 * 4] = { 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0 };
    static float flux[3 * 4] = { 1, 2, 3, 4, 5, 6, 0, 0, 0, 7, 8, 9 }, area[4] = { 1, -1, 2, 3 };
    static float lobe[4 * 4] = { 0, 1, 0, 1, 0, 0, 1, 20, 0, 0, 0, 0, 1, 0, 0, 0 };
    static float to_sky[6] = { 0, 1, 0, 0, 0.6f, 0.8f }, sky[6] = { 1, 1, 1, 2, 2, 2 };
    ism_source sources[2], good;
    ism_desc d = small_desc();
    const ism_vpl *v;
    ism_vpl same[6];
    size_t count;
    world w;
    (void)state;
    open_world(&w, &d);
    memset(sources, 0, sizeof sources);
    sources[0].width = sources[0].height = 2;
    sources[0].positions = at;
    sources[0].normals = normal;
    sources[0].fluxes = flux;
    sources[0].areas = area;
    sources[0].lobes = lobe;
    sources[1].kind = ISM_SOURCE_DIRECTIONS;
    sources[1].width = 2;
    sources[1].height = 1;
    sources[1].positions = to_sky;
    sources[1].fluxes = sky;
    assert_int_equal(ism_set_sources(w.maps, sources, 2), ISM_OK);
    v = ism_vpls(w.maps, &count);
    assert_int_equal(count, 6);
    memcpy(same, v, sizeof same);
    for (size_t i = 0; i < 4; i++) {
        assert_true(v[i].source == 0 && v[i].texel == i && !v[i].directional);
        assert_memory_equal(v[i].flux, flux + 3 * i, 12);
        if (i == 2) continue;
        assert_memory_equal(v[i].position, at + 3 * i, 12);
        assert_memory_equal(v[i].normal, normal + 3 * i, 12);
        assert_memory_equal(v[i].axis, lobe + 4 * i, 16);
        assert_true(fabsf(v[i].area - (i == 1 ? 0 : area[i])) <= 0);
    }
    for (size_t i = 4; i < 6; i++) {
        assert_true(v[i].source == 1 && v[i].texel == i - 4 && v[i].directional);
        for (int k = 0; k < 3; k++) assert_true(fabsf(v[i].normal[k] + to_sky[3 * (i - 4) + (size_t)k]) <= 0);
    }
    assert_int_equal(ism_build(w.maps, &w.frame), ISM_OK);
    assert_int_equal(ism_set_vpls(w.maps, same, 6), ISM_OK);
    for (size_t i = 0; i < 6; i++)
        assert_memory_equal(same[i].flux, v[i].flux, sizeof(ism_vpl) - offsetof(ism_vpl, flux));

    good = sources[0];
#define TAKEN(expected, change)                                                                                        \
    do {                                                                                                               \
        change;                                                                                                        \
        assert_int_equal(ism_set_sources(w.maps, sources, 1), expected);                                               \
        assert_int_equal(ism_vpls(w.maps, &count)[5].texel, 1);         /* untouched */                                \
        sources[0] = good;                                                                                             \
    } while (0)
    TAKEN(ISM_ERR_ARGUMENT, sources[0].positions = NULL);
    TAKEN(ISM_ERR_ARGUMENT, sources[0].width = 0);
    TAKEN(ISM_ERR_ARGUMENT, sources[0].flux_stride = 10);
    TAKEN(ISM_ERR_INPUT, sources[0].kind = ISM_SOURCE_COUNT);
    TAKEN(ISM_ERR_LIMIT, sources[0].width = 9);
    flux[3] = -1;
    TAKEN(ISM_ERR_INPUT, (void)0);
    flux[3] = 4;
    normal[5] = 0.9f;
    TAKEN(ISM_ERR_INPUT, (void)0);
    normal[5] = 1;
    lobe[7] = 2e5f;
    TAKEN(ISM_ERR_INPUT, (void)0);
    lobe[7] = 20;
    TAKEN(ISM_OK, (void)0);
    assert_int_equal(ism_set_sources(w.maps, NULL, 1), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_set_sources(NULL, sources, 1), ISM_ERR_ARGUMENT);
    assert_int_equal(ism_set_sources(w.maps, NULL, 0), ISM_OK);
    ism_free(w.maps);
}

static void every_call_of_progress_may_cancel(void **state)
{
    int at;
    (void)state;
    for (at = 0; at < 1000; at++) {
        world w;
        ism_desc d = small_desc();
        ism_result r;
        d.system.progress = count_down;
        stop_at = 1000000;
        open_world(&w, &d);
        stop_at = at;
        r = try_render(&w, NULL);
        stop_at = 1000000;
        if (r == ISM_ERR_CANCELLED) assert_int_equal(try_render(&w, NULL), ISM_OK);
        ism_free(w.maps);
        if (r == ISM_OK) break;
        assert_int_equal(r, ISM_ERR_CANCELLED);
    }
    assert_true(at > 10 && at < 1000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(descs_are_checked),
        cmocka_unit_test(arguments_are_checked), cmocka_unit_test(limits_of_descs_are_exact),
        cmocka_unit_test(limits_of_frames_are_exact), cmocka_unit_test(limits_of_queries_are_exact),
        cmocka_unit_test(several_sources_share_the_vpls), cmocka_unit_test(tiles_of_no_vpl_are_empty),
        cmocka_unit_test(a_cancelled_choice_has_no_importances), cmocka_unit_test(fluxes_beyond_all_sums_are_bad),
        cmocka_unit_test(surfels_without_an_atlas_are_the_atlas_s_own),
        cmocka_unit_test(odd_values_give_finite_light),
        cmocka_unit_test(nothing_to_do_is_no_error),
        cmocka_unit_test(a_sky_lights_and_shadows),
        cmocka_unit_test(sources_become_vpls_point_by_point),
        cmocka_unit_test(every_call_of_progress_may_cancel),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
