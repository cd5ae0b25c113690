/* window_test - windows of tiles: square and tile are each other's inverse, every texel has its part, discs keep
   their solid angle, what the picture shows lies in the window, which stays where little moves. */
#define ISM_STATIC
#define ISM_IMPLEMENTATION
#include "ism.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "util.h"

static uint32_t window_of(uint32_t u0, uint32_t v0, uint32_t u1, uint32_t v1)
{
    return u0 | v0 << 6 | u1 << 12 | v1 << 18;
}

/* Both ways for every cut of an axis, every size and the least and largest rims: rising, onto 0..1, and where the
   window ends a texel does. */
static void square_and_tile_are_inverse(void **state)
{
    uint32_t size, below, above, k;
    (void)state;
    for (size = 8; size <= 256; size *= 2)
        for (below = 0; below < 64; below++)
            for (above = 0; below + above < 64; above++) {
                const uint32_t window = window_of(below, 0, above, 0);
                const uint32_t rims[3] = { 2, size < 16 ? 2 : size / 8, size / 2 };
                uint32_t r;
                for (r = 0; r < 3; r++) {
                    float last = -1, uv[2], at[2], back[2];
                    const double steepest = 64.0;       /* of the way back, times the rounding of 1 */
                    for (k = 0; k <= 40; k++) {
                        uv[0] = uv[1] = (float)k / 40;
                        ism_zoom(window, size, rims[r], uv, at);
                        ism_unzoom(window, size, rims[r], at, back);
                        assert_true(at[0] > last && at[0] <= 1 && at[1] >= uv[1] && at[1] <= uv[1]);
                        assert_true(fabs((double)back[0] - (double)uv[0]) < 2.4e-7 * steepest);
                        last = at[0];
                    }
                    assert_true(last >= 1);
                    uv[0] = (float)below / 64;
                    ism_zoom(window, size, rims[r], uv, at);
                    if ((below + above) * size > 64 * rims[r]) {
                        const double texels = (double)at[0] * size;
                        assert_true(fabs(texels - floor(texels + 0.5)) < 1e-3);
                        assert_true((below > 0) == (texels > 0.5));
                        uv[0] = (float)(64 - above) / 64;
                        ism_zoom(window, size, rims[r], uv, back);
                        assert_true(fabs((double)(back[0] - at[0]) * size - (double)(size - rims[r])) < 1e-3);
                        assert_true((above > 0) == (back[0] < 1));
                    } else {
                        assert_true(fabs((double)at[0] - (double)uv[0]) < 1e-9);
                    }
                }
            }
    {
        const float beyond[2] = { -0.5f, 1.5f };
        float at[2];
        ism_zoom(window_of(20, 20, 20, 20), 64, 8, beyond, at);
        assert_true(at[0] >= 0 && at[0] <= 0 && at[1] >= 1 && at[1] <= 1);
        ism_unzoom(window_of(20, 20, 20, 20), 64, 8, beyond, at);
        assert_true(at[0] >= 0 && at[0] <= 0 && at[1] >= 1 && at[1] <= 1);
    }
}

/* A wall ahead of a VPL and to its side, which fills a small part of its hemisphere, and receivers before it. */
typedef struct scene { soup mesh; grid eye; ism_vpl vpl; } scene;

static scene s;

static void make_scene(void)
{
    const float a[3] = { 6, 10, -2 }, u[3] = { 0, 0, 4 }, v[3] = { 4, -1, 0 };
    const float ea[3] = { 5.5f, 9.5f, -2.5f }, eu[3] = { 0, 0, 5 }, ev[3] = { 5, -1.25f, 0 }, down[3] = { 0, -1, 0 };
    memset(&s, 0, sizeof s);
    soup_quad(&s.mesh, a, u, v, 6);
    grid_fill(&s.eye, 16, 16, ea, eu, ev, down, 0);
    s.vpl = util_vpl(0, 0, 0, 0, 1, 0, 1);
}

/* One VPL, seen by what the scene's eye sees. */
static ism_desc one_vpl(ism_points *view)
{
    ism_desc d;
    make_scene();
    *view = grid_view(&s.eye);
    memset(&d, 0, sizeof d);
    d.vpl_count = 1;
    return d;
}

static ism_maps *maps_of(const ism_desc *d, const ism_points *view)
{
    ism_mesh m = soup_mesh(&s.mesh);
    ism_frame f;
    ism_maps *maps;
    memset(&f, 0, sizeof f);
    f.mesh = &m;
    f.points = view;
    assert_int_equal(ism_create(d, &maps), ISM_OK);
    assert_int_equal(ism_set_vpls(maps, &s.vpl, 1), ISM_OK);
    assert_int_equal(ism_build(maps, &f), ISM_OK);
    return maps;
}

/* Projected solid angle of what has a depth, over pi: of COSINE a texel has as much as of the square. *full: texels. */
static double seen_of(const ism_maps *maps, uint32_t size, uint32_t rim, int *full)
{
    const float *atlas = ism_atlas(maps, NULL, NULL);
    const uint32_t window = ism_vpls(maps, NULL)->window;
    double sum = 0, all = 0;
    uint32_t i;
    *full = 0;
    for (i = 0; i < size * size; i++) {
        float a[2], b[2], from[2], to[2];
        double share;
        a[0] = (float)(i % size) / (float)size;
        a[1] = (float)(i / size) / (float)size;
        b[0] = (float)(i % size + 1) / (float)size;
        b[1] = (float)(i / size + 1) / (float)size;
        ism_unzoom(window, size, rim, a, from);
        ism_unzoom(window, size, rim, b, to);
        share = ((double)to[0] - (double)from[0]) * ((double)to[1] - (double)from[1]);
        assert_true(share > 0);
        all += share;
        if (atlas[i] < ISM_FAR) {
            sum += share;
            ++*full;
        }
    }
    assert_true(fabs(all - 1) < 1e-5);          /* every direction has one texel */
    return sum;
}

static void discs_keep_their_solid_angle(void **state)
{
    const float up[3] = { 0, 1, 0 };
    float corners[12] = { 6, 10, -2, 10, 9, -2, 10, 9, 2, 6, 10, 2 };
    double exact, even, fine;
    ism_points view;
    ism_maps *maps;
    ism_desc d;
    int even_texels, fine_texels;
    (void)state;
    d = one_vpl(&view);
    d.no_fill = 1;
    exact = (double)util_form_factor(up, corners);
    d.window_rim = -1;
    maps = maps_of(&d, &view);
    assert_int_equal(ism_vpls(maps, NULL)->window, 0);
    even = seen_of(maps, 64, 8, &even_texels);
    ism_free(maps);
    d.window_rim = 0;
    maps = maps_of(&d, &view);
    assert_true(ism_vpls(maps, NULL)->window != 0);
    fine = seen_of(maps, 64, 8, &fine_texels);
    ism_free(maps);
    printf("form factor %.5f, by even texels %.5f (%d), in the window %.5f (%d)\n", exact, even, even_texels, fine,
           fine_texels);
    assert_true(exact > 0.01);
    assert_true(fabs(even / exact - 1) < 0.1);
    assert_true(fabs(fine / exact - 1) < 0.01);
    assert_true(fine_texels > 8 * even_texels);
    d.window_rim = 32;
    maps = maps_of(&d, &view);
    assert_true(fabs(seen_of(maps, 64, 32, &even_texels) / exact - 1) < 0.02);
    assert_true(even_texels < fine_texels / 2);
    ism_free(maps);
    /* what the picture does not show is drawn too, by the rim alone */
    {
        const float a[3] = { -2, 10, -2 }, u[3] = { 1, 0, 0 }, v[3] = { 0, 0, 1 }, down[3] = { 0, -1, 0 };
        static grid elsewhere;
        grid_fill(&elsewhere, 8, 8, a, u, v, down, 0);
        view = grid_view(&elsewhere);
        d.window_rim = 0;
        d.spread = ISM_SPREAD_AREA;
        maps = maps_of(&d, &view);
        assert_true(ism_vpls(maps, NULL)->window != 0);
        assert_true(fabs(seen_of(maps, 64, 8, &even_texels) / exact - 1) < 0.5);
        assert_true(even_texels > 0 && even_texels < 40);
        ism_free(maps);
    }
}

/* Every receiver that faces the VPL lies in the window; of a view that shows nothing to it there is none, nor where
   ism_bounce needs all. */
static void windows_hold_what_is_seen(void **state)
{
    ism_points view;
    ism_maps *maps;
    ism_desc d;
    uint32_t window, i, projection;
    (void)state;
    d = one_vpl(&view);
    d.surfel_count = 64;
    for (projection = 1; projection < ISM_PROJECTION_COUNT; projection++) {
        uint32_t outside = 0;
        d.projection = (ism_projection)projection;
        maps = maps_of(&d, &view);
        window = ism_vpls(maps, NULL)->window;
        assert_true(window != 0);
        for (i = 0; i < 256; i++) {
            ism__v3 p = ism__v3_load(s.eye.p + 3 * i), x, y, up = ism__v3_make(0, 1, 0);
            float direction[3], uv[2];
            ism__v3_basis(up, &x, &y);
            p = ism__v3_normalize(ism__v3_make(ism__v3_dot(x, p), ism__v3_dot(y, p), ism__v3_dot(up, p)));
            ism__v3_store(direction, p);
            assert_true(ism_map_coordinates(d.projection, 1, direction, uv));
            outside += uv[0] * 64 < (float)(window & 63) || uv[0] * 64 > (float)(64 - (window >> 12 & 63)) ||
                       uv[1] * 64 < (float)(window >> 6 & 63) || uv[1] * 64 > (float)(64 - (window >> 18 & 63));
        }
        assert_int_equal(outside, 0);
        ism_free(maps);
    }
    d.projection = ISM_PROJECTION_DEFAULT;
    d.keep_hits = 1;
    maps = maps_of(&d, &view);
    assert_int_equal(ism_vpls(maps, NULL)->window, 0);
    ism_free(maps);
    d.keep_hits = 0;
    for (i = 0; i < 256; i++) s.eye.n[3 * i + 1] = 1;
    maps = maps_of(&d, &view);
    assert_int_equal(ism_vpls(maps, NULL)->window, 0);
    ism_free(maps);
    /* a list of receivers has no rows */
    for (i = 0; i < 256; i++) s.eye.n[3 * i + 1] = -1;
    maps = maps_of(&d, &view);
    window = ism_vpls(maps, NULL)->window;
    ism_free(maps);
    view.count = 256;
    view.width = 0;
    maps = maps_of(&d, &view);
    assert_int_equal(ism_vpls(maps, NULL)->window, window);
    ism_free(maps);
}

/* The camera sways: the window stays unless it must grow. Once it might be more than two steps smaller it follows. */
static void a_window_stays_until_it_must_change(void **state)
{
    ism_mesh m;
    ism_points view;
    ism_frame f;
    ism_maps *maps;
    ism_desc d;
    uint32_t first, i, changes = 0, last;
    size_t k;
    (void)state;
    make_scene();
    m = soup_mesh(&s.mesh);
    view = grid_view(&s.eye);
    memset(&d, 0, sizeof d);
    d.vpl_count = 1;
    d.surfel_count = 64;
    memset(&f, 0, sizeof f);
    f.mesh = &m;
    f.points = &view;
    assert_int_equal(ism_create(&d, &maps), ISM_OK);
    assert_int_equal(ism_set_vpls(maps, &s.vpl, 1), ISM_OK);
    assert_int_equal(ism_build(maps, &f), ISM_OK);
    first = last = ism_vpls(maps, NULL)->window;
    for (i = 1; i < 64; i++) {          /* to and fro by 10 cm, 14 m away: less than half a step */
        for (k = 0; k < 256; k++) s.eye.p[3 * k] += i & 1 ? 0.1f : -0.1f;
        f.index = i;
        assert_int_equal(ism_build(maps, &f), ISM_OK);
        changes += ism_vpls(maps, NULL)->window != last;
        last = ism_vpls(maps, NULL)->window;
    }
    assert_true(changes <= 1);
    for (k = 0; k < 256; k++) s.eye.p[3 * k] -= 4;     /* far: it follows */
    f.index++;
    assert_int_equal(ism_build(maps, &f), ISM_OK);
    assert_true(ism_vpls(maps, NULL)->window != first);
    {
        ism_maps *fresh = maps_of(&d, &view);
        for (i = 0; i < 24; i += 6) {
            int now = (int)(ism_vpls(maps, NULL)->window >> i & 63);
            int then = (int)(ism_vpls(fresh, NULL)->window >> i & 63);
            assert_true(now <= then && now >= then - 2);
        }
        ism_free(fresh);
    }
    ism_free(maps);
}

/* The shadow of a post 20 m from the VPL, whose width is half an even texel's there. */
static void thin_shadows_are_seen_from_far(void **state)
{
    const float a[3] = { -0.1f, 18, -2 }, u[3] = { 0, 0, 4 }, v[3] = { 0.2f, 0, 0 };
    const float ea[3] = { -2, 20, -2 }, eu[3] = { 4, 0, 0 }, ev[3] = { 0, 0, 4 }, down[3] = { 0, -1, 0 };
    double wrong[2];
    ism_points view;
    ism_desc d;
    int windows;
    (void)state;
    memset(&s, 0, sizeof s);
    soup_quad(&s.mesh, a, u, v, 4);
    grid_fill(&s.eye, 64, 64, ea, eu, ev, down, 0);
    s.vpl = util_vpl(0.03f, 0, 0.01f, 0, 1, 0, 1);
    view = grid_view(&s.eye);
    memset(&d, 0, sizeof d);
    d.vpl_count = 1;
    for (windows = 0; windows < 2; windows++) {
        static float visible[4096];
        ism_maps *maps;
        size_t i, off = 0;
        d.window_rim = windows ? 0 : -1;
        maps = maps_of(&d, &view);
        assert_int_equal(util_visible(maps, 0, s.eye.p, s.eye.n, 4096, 0.02f, visible), ISM_OK);
        for (i = 0; i < 4096; i++) {        /* where the way to the receiver passes y = 18 */
            const double x = 0.03 + ((double)s.eye.p[3 * i] - 0.03) * 0.9;
            const double z = 0.01 + ((double)s.eye.p[3 * i + 2] - 0.01) * 0.9;
            off += (visible[i] > 0) == (fabs(x) < 0.1 && fabs(z) < 2);
        }
        wrong[windows] = (double)off / 4096;
        ism_free(maps);
    }
    printf("wrong: %.4f by even texels, %.4f in the window\n", wrong[0], wrong[1]);
    assert_true(wrong[0] > 0.02 && wrong[1] < wrong[0] / 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(square_and_tile_are_inverse), cmocka_unit_test(discs_keep_their_solid_angle),
        cmocka_unit_test(windows_hold_what_is_seen), cmocka_unit_test(a_window_stays_until_it_must_change),
        cmocka_unit_test(thin_shadows_are_seen_from_far)
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
