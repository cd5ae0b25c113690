/* vpls_rows_test - virtual point lights and their light: power (T41), inter-texel places (T55), culling (T56), equal
   frames and flicker (T57). */

#include "ism.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include "conformance.h"
#include "util.h"

static soup mesh;
static grid lit, eye;

/* A floor of 4 x 4 m with a step in it, lit by a sun whose map is n x n and begins at `from`; flux varies. */
static ism_source make_floor(uint32_t n, float from)
{
    const float u[3] = { 4, 0, 0 }, v[3] = { 0, 0, 4 }, up[3] = { 0, 1, 0 };
    float a[3];
    uint32_t i;
    a[0] = from;
    a[1] = 0;
    a[2] = -2;
    grid_fill(&lit, n, n, a, u, v, up, 0);
    for (i = 0; i < n * n; i++) {
        float x = lit.p[3 * i], z = lit.p[3 * i + 2], f = (1.2f + sinf(3 * x) * cosf(2 * z)) * 16 / (float)(n * n);
        if (x > 0.5f) lit.p[3 * i + 1] = 0.7f;
        lit.f[3 * i] = f;
        lit.f[3 * i + 1] = 0.5f * f;
        lit.f[3 * i + 2] = 0.25f * f;
    }
    return grid_source(&lit);
}

static ism_points make_wall(uint32_t w, uint32_t h)
{
    const float a[3] = { -2, 2, -2 }, u[3] = { 4, 0, 0 }, v[3] = { 0, -2, 0 }, n[3] = { 0, 0, 1 };
    ism_points view;
    grid_fill(&eye, w, h, a, u, v, n, 0);
    view = grid_view(&eye);
    /* clip x = x / 2, y = y - 1, w = 1: the wall fills the picture */
    view.world_to_clip[0] = 0.5f;
    view.world_to_clip[5] = 1;
    view.world_to_clip[13] = -1;
    view.world_to_clip[15] = 1;
    view.rows = ISM_ROWS_TOP_FIRST;
    return view;
}

static void power_is_kept(void **state)
{
    static const char *const names[4] = { "", "importance by flux", "bidirectional importance", "guided importance" };
    ism_source s = make_floor(32, -2);
    ism_points view = make_wall(32, 16);
    int importance;
    size_t i;
    double truth = 0;
    (void)state;
    for (i = 0; i < 32 * 32; i++) truth += (double)lit.f[3 * i];
    for (importance = 1; importance <= ISM_IMPORTANCE_GUIDED; importance++) {
        enum { RUNS = 200 };
        double sum = 0, square = 0, least = 1e30, most = 0, sigma;
        ism_desc d;
        ism_maps *m;
        ism_frame f;
        char text[80];
        memset(&d, 0, sizeof d);
        memset(&f, 0, sizeof f);
        d.vpl_count = 64;
        d.importance = (ism_importance)importance;
        d.unstable = 1;
        f.sources = &s;
        f.source_count = 1;
        f.points = &view;
        assert_int_equal(ism_create(&d, &m), ISM_OK);
        for (f.index = 0; f.index < RUNS; f.index++) {
            size_t n;
            const ism_vpl *v;
            double total = 0;
            assert_int_equal(ism_choose(m, &f), ISM_OK);
            v = ism_vpls(m, &n);
            assert_int_equal(n, 64);
            for (i = 0; i < n; i++) {
                total += (double)v[i].flux[0];
                least = fmin(least, (double)v[i].flux[0]);
                most = fmax(most, (double)v[i].flux[0]);
            }
            sum += total / RUNS;
            square += total * total / RUNS;
        }
        sigma = sqrt(fmax(square - sum * sum, 0) / RUNS) / truth;
        snprintf(text, sizeof text, "%s: mean power of VPLs over that of the map", names[importance]);
        CONFORM("T41", text, 1, sum / truth, 3 * sigma + 1e-5);
        if (importance == ISM_IMPORTANCE_FLUX)
            CONFORM("T41", "importance by flux: brightest over darkest VPL", 1, most / least, 1e-4);
        ism_free(m);
    }
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

typedef struct glide { double median, most, off, jumps; } glide;

/* The light, and its texels of 125 mm with it, moves by eps a frame. How far VPLs go that are not flagged as jumped, in
   eps: median and 95th percentile; farthest place off the surface; share of flagged ones. */
static glide glide_of(float eps, int unstable)
{
    enum { N = 256, FRAMES = 20 };
    static double ways[N * FRAMES];
    ism_points view = make_wall(32, 16);
    ism_source s = make_floor(32, -2);
    glide g = { 0, 0, 0, 0 };
    size_t count = 0;
    ism_desc d;
    ism_maps *m;
    ism_frame f;
    uint32_t step;
    memset(&d, 0, sizeof d);
    memset(&f, 0, sizeof f);
    d.vpl_count = N;
    d.unstable = unstable;
    f.sources = &s;
    f.source_count = 1;
    f.points = &view;
    assert_int_equal(ism_create(&d, &m), ISM_OK);
    for (step = 0; step < FRAMES; step++) {
        static ism_vpl before[N];
        const ism_vpl *v;
        size_t n, i;
        s = make_floor(32, -2 + eps * (float)step);
        f.index = step;
        v = ism_vpls(m, &n);
        memcpy(before, v, n * sizeof *v);
        assert_int_equal(ism_choose(m, &f), ISM_OK);
        v = ism_vpls(m, &n);
        assert_int_equal(n, N);
        for (i = 0; i < n; i++) {
            float dx = v[i].position[0] - before[i].position[0], dz = v[i].position[2] - before[i].position[2];
            double y = (double)v[i].position[1];
            g.off = fmax(g.off, fmin(fabs(y), fabs(y - 0.7)));
            if (step == 0) continue;
            if (v[i].jumped) g.jumps += 1.0 / (N * (FRAMES - 1));
            else ways[count++] = sqrt((double)(dx * dx + dz * dz)) / (double)eps;
        }
    }
    qsort(ways, count, sizeof *ways, by_size);
    g.median = ways[count / 2];
    g.most = ways[count * 95 / 100];
    ism_free(m);
    return g;
}

/* A sky of three directions of equal flux over a level floor: overhead, 0.2 above the horizon, below it. What a unit of
   flux does to the floor is its cosine, so VPLs go by that and by the share of flux_share, and the flux that they carry
   is the sky's. Rows of the source are drawn in even steps: counts are exact but for 1. */
static void skies_are_chosen_by_the_cosine(void **state)
{
    enum { N = 1200 };
    static const double cosine[3] = { 1, 0.2, 0 };
    const float a[3] = { -1, 0, -1 }, u[3] = { 2, 0, 0 }, v[3] = { 0, 0, 2 }, up[3] = { 0, 1, 0 };
    float p[9] = { 0, 1, 0, 0, 0.2f, 0, 0, -1, 0 }, f[9];
    ism_source sky;
    ism_points floor_points;
    ism_frame frame;
    ism_desc d;
    ism_maps *maps;
    const ism_vpl *vpls;
    double share = 0.1, least, sum[3] = { 0, 0, 0 };
    size_t count, i;
    int k;
    (void)state;
    p[3] = (float)sqrt(1 - 0.04);
    for (k = 0; k < 9; k++) f[k] = 2;
    memset(&sky, 0, sizeof sky);
    sky.kind = ISM_SOURCE_DIRECTIONS;
    sky.width = 1;
    sky.height = 3;
    sky.positions = p;
    sky.fluxes = f;
    grid_fill(&eye, 16, 16, a, u, v, up, 0);
    floor_points = grid_view(&eye);
    memset(&frame, 0, sizeof frame);
    frame.sources = &sky;
    frame.source_count = 1;
    frame.points = &floor_points;
    memset(&d, 0, sizeof d);
    d.vpl_count = N;
    assert_int_equal(ism_create(&d, &maps), ISM_OK);
    assert_int_equal(ism_choose(maps, &frame), ISM_OK);
    vpls = ism_vpls(maps, &count);
    assert_int_equal(count, N);
    least = 1.2 / 3 * share / (1 - 0.999 * share);
    for (i = 0; i < count; i++) {
        sum[vpls[i].texel] += 1;
        for (k = 0; k < 3; k++) {
            assert_true(fabsf(vpls[i].position[k] - p[3 * vpls[i].texel + (size_t)k]) < 1e-6f);
            assert_true(fabsf(vpls[i].normal[k] + vpls[i].position[k]) < 1e-6f);      /* it looks down from the sky */
        }
        assert_true(fabs((double)vpls[i].flux[0] * N * (cosine[vpls[i].texel] + least) / (2 * (1.2 + 3 * least)) - 1) <
                    1e-4);
    }
    for (k = 0; k < 3; k++) {
        double expected = N * (cosine[k] + least) / (1.2 + 3 * least);
        if (!(fabs(sum[k] - expected) <= 1)) fail_msg("direction %d: %g VPLs, expected %g", k, sum[k], expected);
    }
    ism_free(maps);
}

/* The way is O(eps): bounded by the same factors for two eps of which one is a quarter of the other. Measured medians
   1.5 and 1.0; 95th percentiles 16 and 9, where the row of the map that a VPL's number picks changes. A texel would be
   62 and 250 eps; other random numbers every frame take VPLs right across the floor. */
static void vpls_glide_as_the_light_moves(void **state)
{
    const glide coarse = glide_of(0.002f, 0), fine = glide_of(0.0005f, 0), loose = glide_of(0.002f, 1);
    (void)state;
    CONFORM_MAX("T55", "distance from the surface, m", 1e-5, fmax(coarse.off, fine.off));
    CONFORM_MAX("T55", "light moves 2 mm a frame: median way of a VPL, of the light's", 2, coarse.median);
    CONFORM_MAX("T55", "light moves 2 mm a frame: 95th percentile of the ways", 20, coarse.most);
    CONFORM_MAX("T55", "light moves 0.5 mm a frame: median way of a VPL, of the light's", 2, fine.median);
    CONFORM_MAX("T55", "light moves 0.5 mm a frame: 95th percentile of the ways", 20, fine.most);
    CONFORM_MAX("T55", "VPLs flagged as jumping at 2 mm, share", 0.02, coarse.jumps);
    CONFORM_MAX("T55", "VPLs flagged as jumping at 0.5 mm, share", 0.008, fine.jumps);
    assert_true(loose.jumps > 0.5 || loose.median > 20);
}

/* A bent sheet, a cylinder of radius 1 m whose texels lie `step` radians apart, lit from outside (1) or inside (-1):
   the least and the largest height of VPLs over it, on the lit side, in sagittas of its chords. */
static void heights_over_a_bend(float side, double *least, double *most)
{
    const float step = 0.15f, a[3] = { 0, 0, 0 }, u[3] = { 1, 0, 0 }, v[3] = { 0, 0, 2 }, n[3] = { 0, 1, 0 };
    ism_points view = make_wall(8, 8);
    ism_source s;
    ism_desc d;
    ism_frame f;
    ism_maps *m;
    const ism_vpl *vpls;
    size_t count, i;
    double sagitta = 1 - cos(0.5 * (double)step);
    memset(&view.world_to_clip, 0, sizeof view.world_to_clip);
    grid_fill(&lit, 8, 8, a, u, v, n, 1);
    for (i = 0; i < 64; i++) {
        float angle = step * (float)(i % 8);
        lit.p[3 * i] = cosf(angle);
        lit.p[3 * i + 1] = sinf(angle);
        lit.n[3 * i] = side * cosf(angle);
        lit.n[3 * i + 1] = side * sinf(angle);
    }
    s = grid_source(&lit);
    memset(&d, 0, sizeof d);
    memset(&f, 0, sizeof f);
    d.vpl_count = 256;
    d.importance = ISM_IMPORTANCE_FLUX;
    f.sources = &s;
    f.source_count = 1;
    f.points = &view;
    assert_int_equal(ism_create(&d, &m), ISM_OK);
    assert_int_equal(ism_choose(m, &f), ISM_OK);
    vpls = ism_vpls(m, &count);
    assert_int_equal(count, 256);
    *least = 1e30;
    *most = -1e30;
    for (i = 0; i < count; i++) {
        double x = (double)vpls[i].position[0], y = (double)vpls[i].position[1];
        double h = (double)side * (sqrt(x * x + y * y) - 1) / sagitta;
        *least = fmin(*least, h);
        *most = fmax(*most, h);
    }
    ism_free(m);
}

static void vpls_stay_before_a_bent_sheet(void **state)
{
    double least, most;
    (void)state;
    heights_over_a_bend(1, &least, &most);
    CONFORM_MAX("T55", "bent sheet lit from outside: depth of VPLs behind it, sagittas", 0.001, -least);
    CONFORM_MAX("T55", "height over it, sagittas", 1.02, most);
    heights_over_a_bend(-1, &least, &most);
    CONFORM_MAX("T55", "bent sheet lit from inside: depth of VPLs behind it, sagittas", 0.001, -least);
    CONFORM_MAX("T55", "height over it, sagittas (inside)", 1.02, most);
}

/* A receiver on the lower side of a sheet that seems, by its shading normal, to look at a VPL on the upper one. */
static void a_sheet_is_dark_from_behind(void **state)
{
    const float at[6] = { 1, 0.05f, 0, 1, 0.05f, 0 }, normals[6] = { 0, -1, 0, 0, -1, 0 };
    const float geometric[6] = { 0.2f, -0.98f, 0, -0.2f, -0.98f, 0 };       /* the VPL lies behind, before this plane */
    float visible[2], light[6];
    ism_vpl vpl[2];
    ism_points view;
    ism_frame f;
    ism_desc d;
    ism_maps *m;
    int i;
    (void)state;
    memset(&view, 0, sizeof view);
    memset(&f, 0, sizeof f);
    memset(&d, 0, sizeof d);
    view.positions = at;
    view.normals = normals;
    view.geometric_normals = geometric;
    view.count = 2;
    f.points = &view;
    d.vpl_count = 2;
    vpl[0] = util_vpl(0, 0, 0, 0, 1, 0, 1);
    vpl[1] = util_vpl(-1, 0, 0, 1, 0, 0, 1);         /* a sky's: from the side that the second one's plane faces */
    vpl[1].directional = 1;
    assert_int_equal(ism_create(&d, &m), ISM_OK);
    assert_int_equal(ism_set_vpls(m, vpl, 2), ISM_OK);
    assert_int_equal(ism_build(m, &f), ISM_OK);
    for (i = 0; i < 2; i++) {
        assert_int_equal(util_visible(m, (uint32_t)i, at, geometric, 2, 0.02f, visible), ISM_OK);
        assert_true(visible[0] == 0 && visible[1] == 1);
    }
    assert_int_equal(ism_shade(m, &view, NULL, light, NULL), ISM_OK);
    assert_true(light[0] == 0 && light[3] > 0);
    ism_free(m);
}

/* ---- T56, T57 ---- */

typedef struct setting { ism_mesh mesh; ism_points view; ism_source source; ism_frame frame; ism_maps *maps; } setting;

static void open_setting(setting *t, const ism_desc *extra)
{
    const float lo[3] = { -2, 0.01f, -1 }, hi[3] = { -1, 1.5f, 0.3f };
    ism_desc d;
    mesh.triangles = 0;
    soup_box(&mesh, lo, hi, 1, 4);
    memset(&d, 0, sizeof d);
    if (extra) d = *extra;
    d.vpl_count = 128;
    d.surfel_count = 512;
    d.tile_side = 32;
    t->mesh = soup_mesh(&mesh);
    t->view = make_wall(64, 48);
    t->source = make_floor(32, -2);
    memset(&t->frame, 0, sizeof t->frame);
    t->frame.mesh = &t->mesh;
    t->frame.sources = &t->source;
    t->frame.source_count = 1;
    t->frame.points = &t->view;
    assert_int_equal(ism_create(&d, &t->maps), ISM_OK);
}

static void culling_changes_nothing(void **state)
{
    static float all[3 * 64 * 48], culled[3 * 64 * 48];
    setting t;
    ism_shading s = { 0 };
    ism_stats stats;
    uint32_t i;
    (void)state;
    open_setting(&t, NULL);
    /* half of the receivers below the step: VPLs on top of it face away from them */
    for (i = 0; i < 64 * 48; i++)
        if (eye.p[3 * i + 1] < 0.6f) eye.p[3 * i + 1] -= 1;
    for (s.interleave = 1; s.interleave <= 2; s.interleave++) {
        s.cull = 0;
        assert_int_equal(ism_render(t.maps, &t.frame, &s, all, NULL), ISM_OK);
        s.cull = 1;
        assert_int_equal(ism_shade(t.maps, &t.view, &s, culled, &stats), ISM_OK);
        assert_true(stats.culled > 0.05);
        assert_memory_equal(all, culled, sizeof all);
    }
    CONFORM_MIN("T56", "same bits; pairs of VPL and block culled, share", 0.05, stats.culled);
    ism_free(t.maps);
}

static void frames_are_equal(void **state)
{
    static float first[3 * 64 * 48], now[3 * 64 * 48];
    setting t;
    ism_desc d;
    ism_shading s = { 0 };
    double differ = 0;
    (void)state;
    s.interleave = 4;
    open_setting(&t, NULL);
    assert_int_equal(ism_render(t.maps, &t.frame, &s, first, NULL), ISM_OK);
    for (t.frame.index = 1; t.frame.index < 10; t.frame.index++) {
        assert_int_equal(ism_render(t.maps, &t.frame, &s, now, NULL), ISM_OK);
        differ += memcmp(first, now, sizeof now) != 0;
    }
    ism_free(t.maps);
    assert_true(differ == 0);
    memset(&d, 0, sizeof d);        /* tasks in the opposite order: the same bits too */
    d.system.parallel_for = backwards;
    open_setting(&t, &d);
    assert_int_equal(ism_render(t.maps, &t.frame, &s, now, NULL), ISM_OK);
    assert_memory_equal(first, now, sizeof now);
    ism_free(t.maps);
}

/* Mean absolute difference of successive frames over the mean, for a light that moves 5 mm a frame. */
static double flicker(int unstable)
{
    static float before[3 * 64 * 48], now[3 * 64 * 48];
    setting t;
    ism_desc d;
    double change = 0, mean = 0;
    uint32_t step, i;
    memset(&d, 0, sizeof d);
    d.unstable = unstable;
    open_setting(&t, &d);
    for (step = 0; step < 12; step++) {
        t.source = make_floor(32, -2 + 0.005f * (float)step);
        t.frame.index = step;
        assert_int_equal(ism_render(t.maps, &t.frame, NULL, now, NULL), ISM_OK);
        for (i = 0; step && i < 3 * 64 * 48; i++) {
            change += fabs((double)now[i] - (double)before[i]);
            mean += (double)now[i];
        }
        memcpy(before, now, sizeof now);
    }
    ism_free(t.maps);
    return change / mean;
}

static void persistence_halves_flicker(void **state)
{
    double stable = flicker(0), unstable = flicker(1);
    (void)state;
    CONFORM_MAX("T57", "moving light: difference of frames with persistence over without", 0.5, stable / unstable);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(power_is_kept),
        cmocka_unit_test(skies_are_chosen_by_the_cosine),
        cmocka_unit_test(vpls_glide_as_the_light_moves),
        cmocka_unit_test(vpls_stay_before_a_bent_sheet),
        cmocka_unit_test(a_sheet_is_dark_from_behind),
        cmocka_unit_test(culling_changes_nothing),
        cmocka_unit_test(frames_are_equal),
        cmocka_unit_test(persistence_halves_flicker),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
