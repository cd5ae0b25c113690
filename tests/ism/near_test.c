/* near_test - near points: what they light beside what is known in closed form, their sums to the letter, that
   nothing is lost where they take over, and who has none. */

#define ISM_STATIC
#define ISM_IMPLEMENTATION
#include "ism.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>
#include "util.h"
#include "conformance.h"

enum { SIDE = 64, SEEN_W = 20, SEEN_H = 12, SEEN = SEEN_W * SEEN_H };

static const float up[3] = { 0, 1, 0 }, back[3] = { 0, 0, 1 };
static grid lit, seen;
static float areas[SIDE * SIDE];

/* A floor of 4 m x 4 m of radiosity 1, and a wall that stands on its edge. */
static void make_corner(ism_source *s, ism_points *view)
{
    const float a[3] = { -2, 0, 0 }, u[3] = { 4, 0, 0 }, v[3] = { 0, 0, 4 }, b[3] = { -2, 0, 0 }, h[3] = { 0, 1.2f, 0 };
    size_t i;
    grid_fill(&lit, SIDE, SIDE, a, u, v, up, 16.0f / (SIDE * SIDE));
    grid_fill(&seen, SEEN_W, SEEN_H, b, u, h, back, 0);
    for (i = 0; i < SIDE * SIDE; i++) areas[i] = 16.0f / (SIDE * SIDE);
    *s = grid_source(&lit);
    s->areas = areas;
    *view = grid_view(&seen);
}

static ism_maps *choose(const ism_desc *desc, const ism_source *s, size_t sources, const ism_points *view)
{
    ism_frame f;
    ism_maps *m;
    memset(&f, 0, sizeof f);
    f.sources = s;
    f.source_count = sources;
    f.points = view;
    assert_int_equal(ism_create(desc, &m), ISM_OK);
    assert_int_equal(ism_choose(m, &f), ISM_OK);
    return m;
}

/* Radiosity times form factor, for every receiver. Relative RMSE and ratio of the means. */
static void beside_the_floor(const float *light, double *rmse, double *ratio)
{
    double sum = 0, all = 0, mean = 0;
    size_t i;
    int k;
    for (i = 0; i < SEEN; i++) {
        static const float corner[4][2] = { { -2, 0 }, { -2, 4 }, { 2, 4 }, { 2, 0 } };
        float c[12];
        double e;
        for (k = 0; k < 4; k++) {
            c[3 * k] = corner[k][0] - seen.p[3 * i];
            c[3 * k + 1] = -seen.p[3 * i + 1];
            c[3 * k + 2] = corner[k][1] - seen.p[3 * i + 2];
        }
        e = (double)util_form_factor(back, c);
        sum += ((double)light[3 * i] - e) * ((double)light[3 * i] - e);
        mean += e;
        all += (double)light[3 * i];
    }
    *rmse = sqrt(sum / SEEN) * SEEN / mean;
    *ratio = all / mean;
}

static void light_in_a_corner_is_near_the_truth(void **state)
{
    static const uint32_t patterns[3] = { 1, 2, 4 };
    static float light[3 * SEEN];
    int k;
    (void)state;
    for (k = 0; k < 3; k++) {
        double rmse[2], ratio[2];
        ism_source s;
        ism_points view;
        ism_desc d;
        ism_maps *m;
        int gather;
        make_corner(&s, &view);
        memset(&d, 0, sizeof d);
        d.vpl_count = 256;
        m = choose(&d, &s, 1, &view);
        for (gather = 0; gather < 2; gather++) {
            ism_shading shading = { 0 };
            shading.no_maps = 1;
            shading.interleave = patterns[k];
            shading.near_mode = gather ? ISM_NEAR_GATHER : ISM_NEAR_PATCH;
            assert_int_equal(ism_shade(m, &view, &shading, light, NULL), ISM_OK);
            beside_the_floor(light, &rmse[gather], &ratio[gather]);
        }
        printf("pattern %u: relative RMSE %.4f by patches, %.4f by near points; means %.4f, %.4f\n", patterns[k],
               rmse[0], rmse[1], ratio[0], ratio[1]);
        assert_true(rmse[1] < (k ? 0.08 : 0.03) && rmse[1] < 0.6 * rmse[0]);
        assert_true(fabs(ratio[1] - 1) < 0.02);
        if (!k) {                       /* bounds: 256 VPLs and 4096 near points are a stratified sum */
            CONFORM("T44", "wall beside a lit floor, by near points: mean over the form factor's", 1, ratio[1], 0.02);
            CONFORM_MAX("T44", "the same: relative RMSE", 0.03, rmse[1]);
        }
        ism_free(m);
    }
}

/* A pixel that is alone on its surface has one class of 16 of the VPLs, but all near points: 3 cm above the floor,
   where these give nearly all light, it is nearly as bright by each of the 16 classes as by all. With a class of the
   near points as well the 16 differed by 0.29 of the light, and the largest were white specks. */
static void a_pixel_alone_has_all_near_points(void **state)
{
    float places[3 * 16], normals[3 * 16], light[3 * 16];
    double square = 0, whole = 0;
    ism_points view, one;
    ism_source s;
    ism_desc d;
    ism_maps *m;
    size_t i, k;
    (void)state;
    make_corner(&s, &view);
    memset(&d, 0, sizeof d);
    d.vpl_count = 256;
    m = choose(&d, &s, 1, &view);
    memset(&one, 0, sizeof one);
    one.count = 16;
    one.width = 4;
    one.positions = places;
    one.normals = normals;
    for (k = 0; k < 17; k++) {
        ism_shading shading = { 0 };
        const size_t at = k < 16 ? k : 0;
        memset(normals, 0, sizeof normals);
        for (i = 0; i < 16; i++) {
            places[3 * i] = 0.3f;
            places[3 * i + 1] = 0.03f;
            places[3 * i + 2] = 0;
        }
        normals[3 * at + 2] = 1;
        shading.no_maps = 1;
        shading.interleave = k < 16 ? 4 : 1;
        assert_int_equal(ism_shade(m, &one, &shading, light, NULL), ISM_OK);
        if (k < 16) square += (double)light[3 * at] * (double)light[3 * at] / 16;
        if (k < 16) whole += (double)light[3 * at] / 16;
        else assert_true(fabs(whole / (double)light[0] - 1) < 1e-5);       /* the mean of the classes */
    }
    printf("classes differ by %.3f of the light\n", sqrt(fmax(square / (whole * whole) - 1, 0)));
    assert_true(sqrt(fmax(square / (whole * whole) - 1, 0)) < 0.1);
    ism_free(m);
}

/* By flux alone all VPLs are equal, and so are all near points, with equal sums. */
static void no_flux_is_lost(void **state)
{
    static const uint32_t each[3] = { 1, 16, 64 };
    int k;
    (void)state;
    for (k = 0; k < 3; k++) {
        ism_source s;
        ism_points view;
        ism_desc d;
        ism_maps *m;
        ism_stats stats;
        const ism_near_point *p;
        double sum = 0;
        size_t n, i;
        make_corner(&s, &view);
        memset(&d, 0, sizeof d);
        d.vpl_count = 50;
        d.near_point_count = (int32_t)each[k];
        d.importance = ISM_IMPORTANCE_FLUX;
        m = choose(&d, &s, 1, &view);
        p = ism_near_points(m, &n);
        assert_int_equal(n, 50 * each[k]);
        for (i = 0; i < n; i++) {
            sum += (double)p[i].flux[0];
            assert_true(fabs((double)p[i].flux[1] * (double)n - 16) < 1e-4 && p[i].normal[1] >= 1);
            assert_true(p[i].reach > 0 && p[i].vpl >= 0 && p[i].vpl < 50 && p[i].edge > 0);
        }
        assert_true(fabs(sum - 16) < 1e-4);
        stats = util_stats(m);
        assert_int_equal(stats.near_points, n);
        assert_true(fabs(stats.flux[0] - 16) < 1e-3);
        ism_free(m);
    }
}

/* ---- the sum, written once more ---- */

static int seen_by(uint32_t i, float x, int near_point)
{
    return ((int)(x * 100 + 500) + (int)i) % (near_point ? 4 : 3) != 0;
}

static void see(void *user, const float p[3], const float n[3], const uint32_t *list, size_t count, float *visible)
{
    size_t i;
    (void)n;
    assert_true(user == areas && count <= 64);
    for (i = 0; i < count; i++) visible[i] = (float)seen_by(list[i], p[0], 0);
}

static void see_near(void *user, const float p[3], const float n[3], const uint32_t *list, size_t count, float *visible)
{
    size_t i;
    (void)n;
    assert_true(user == areas && count <= 64);
    for (i = 0; i < count; i++) visible[i] = (float)seen_by(list[i], p[0], 1);
}

/* Points alone: sides are 0, so that no square takes part. */
static double point_kernel(const float *p, const float *n, const float *q, const float *m, double reach, int near_point)
{
    double d[3], d2 = 0, a = 0, b = 0, h;
    int k;
    for (k = 0; k < 3; k++) {
        d[k] = (double)q[k] - (double)p[k];
        d2 += d[k] * d[k];
        a += d[k] * (double)n[k];
        b -= d[k] * (double)m[k];
    }
    h = fmin(1, fmax(0, 2 - 2 * d2 / (reach * reach)));
    return a > 0 && b > 0 ? a * b / (d2 * d2) * (near_point ? h : 1 - h) : 0;
}

static void vpls_and_near_points_sum_to_the_formula(void **state)
{
    static float light[3 * SEEN];
    ism_source s;
    ism_points view;
    ism_desc d;
    ism_maps *m;
    const ism_near_point *points;
    const ism_vpl *vpls;
    ism_shading shading;
    size_t n, count, i, j;
    int way, near_lit = 0;
    (void)state;
    make_corner(&s, &view);
    for (i = 0; i < SIDE * SIDE; i++) areas[i] = 0;
    memset(&d, 0, sizeof d);
    d.vpl_count = 37;
    d.near_point_count = 5;
    d.seed = 3;
    m = choose(&d, &s, 1, &view);
    for (i = 0; i < 37; i++) m->vpls[i].edge = 0;
    points = ism_near_points(m, &n);
    vpls = ism_vpls(m, &count);
    for (way = 0; way < 3; way++) {
        view.count = SEEN;
        view.width = 0;
        memset(&shading, 0, sizeof shading);
        shading.near_mode = ISM_NEAR_GATHER;
        shading.visible_user = shading.near_visible_user = areas;
        if (way) shading.visible_fn = see;
        if (way == 2) shading.near_visible_fn = see_near;
        shading.no_maps = way == 0;
        assert_int_equal(ism_shade(m, &view, &shading, light, NULL), ISM_OK);
        for (i = 0; i < SEEN; i++) {
            const float *p = seen.p + 3 * i;
            double sum = 0, of_near = 0;
            for (j = 0; j < count; j++)
                if (way == 0 || seen_by((uint32_t)j, p[0], 0))
                    sum += point_kernel(p, back, vpls[j].position, vpls[j].normal, (double)vpls[j].reach, 0) *
                           (double)vpls[j].flux[0];
            for (j = 0; j < n; j++)
                if (way == 0 || (way == 1 ? seen_by((uint32_t)points[j].vpl, p[0], 0) : seen_by((uint32_t)j, p[0], 1)))
                    of_near += point_kernel(p, back, points[j].position, points[j].normal, (double)points[j].reach, 1) *
                               (double)points[j].flux[0];
            near_lit += of_near > 0;
            sum = (sum + of_near) / UTIL_PI;
            if (!(fabs((double)light[3 * i] - sum) < 1e-4 * (sum + 1e-3)))
                fail_msg("way %d, receiver %d: %g, not %g", way, (int)i, (double)light[3 * i], sum);
        }
    }
    assert_true(near_lit > SEEN);
    ism_free(m);
}

/* A reach is twice the distance to the eighth of the VPLs about the place; a point belongs to the nearest VPL. */
static void a_near_point_belongs_to_its_nearest_vpl(void **state)
{
    ism_source s;
    ism_points view;
    ism_desc d;
    ism_maps *m;
    const ism_near_point *points;
    const ism_vpl *v;
    size_t n, count, i, j, k;
    (void)state;
    make_corner(&s, &view);
    memset(&d, 0, sizeof d);
    d.vpl_count = 100;
    m = choose(&d, &s, 1, &view);
    points = ism_near_points(m, &n);
    v = ism_vpls(m, &count);
    for (i = 0; i < n + count; i++) {
        const float *p = i < n ? points[i].position : v[i - n].position;
        float reach = i < n ? points[i].reach : v[i - n].reach;
        double nearest = 1e9, own = 0, d2;
        int inside = 0;
        for (j = 0; j < count; j++) {
            for (k = 0, d2 = 0; k < 3; k++)
                d2 += ((double)p[k] - (double)v[j].position[k]) * ((double)p[k] - (double)v[j].position[k]);
            inside += 2 * sqrt(d2) <= (double)reach * 1.000001;
            nearest = fmin(nearest, d2);
            if (i < n && j == (size_t)points[i].vpl) own = d2;
        }
        assert_int_equal(inside, 8);
        if (i < n) assert_true(own <= nearest * 1.0001);
    }
    ism_free(m);
}

/* ---- an ornament ---- */

/* Before a wall stands a lit sheet of 0.3 x 0.3 m, 0.15 m off, its lit side to the wall; VPLs are few. Its light on the
   wall is the square's form factor. A box beside it, which no ray passes, has no part in that. */
static void an_ornament_lights_the_wall_by_its_form_factor(void **state)
{
    static grid sheet, wall;
    static soup box;
    static float light[3 * SEEN], small[SIDE * SIDE];
    const float a[3] = { -0.15f, -0.15f, 0.15f }, u[3] = { 0.3f, 0, 0 }, v[3] = { 0, 0.3f, 0 },
                to_wall[3] = { 0, 0, -1 };
    const float b[3] = { -0.5f, -0.3f, 0 }, w[3] = { 1, 0, 0 }, h[3] = { 0, 0.6f, 0 };
    const float lo[3] = { 3, -1, 0 }, hi[3] = { 4, 1, 1 }, corner[4][2] = { { 0, 0 }, { 0, 1 }, { 1, 1 }, { 1, 0 } };
    double error[2] = { 0, 0 }, all[2] = { 0, 0 }, mean = 0, peak[2] = { 0, 0 };
    ism_frame f;
    ism_mesh mesh;
    ism_source s;
    ism_points view;
    ism_desc d;
    ism_maps *m;
    size_t i;
    int gather, k;
    (void)state;
    grid_fill(&sheet, 32, 32, a, u, v, to_wall, 0.09f / 1024);
    grid_fill(&wall, SEEN_W, SEEN_H, b, w, h, back, 0);
    for (i = 0; i < 1024; i++) small[i] = 0.09f / 1024;
    box.triangles = 0;
    soup_box(&box, lo, hi, 1, 2);
    mesh = soup_mesh(&box);
    s = grid_source(&sheet);
    s.areas = small;
    view = grid_view(&wall);
    memset(&d, 0, sizeof d);
    memset(&f, 0, sizeof f);
    d.vpl_count = 12;
    d.surfel_count = 64;
    f.mesh = &mesh;
    f.sources = &s;
    f.source_count = 1;
    f.points = &view;
    assert_int_equal(ism_create(&d, &m), ISM_OK);
    for (gather = 0; gather < 2; gather++) {
        ism_shading shading = { 0 };
        shading.near_mode = gather ? ISM_NEAR_DEFAULT : ISM_NEAR_NONE;
        assert_int_equal(ism_render(m, &f, &shading, light, NULL), ISM_OK);
        for (i = 0, mean = 0; i < SEEN; i++) {
            float c[12];
            double e;
            for (k = 0; k < 4; k++) {       /* its lit side towards the wall: counter-clockwise from there */
                c[3 * k] = a[0] + 0.3f * corner[k][0] - wall.p[3 * i];
                c[3 * k + 1] = a[1] + 0.3f * corner[k][1] - wall.p[3 * i + 1];
                c[3 * k + 2] = a[2];
            }
            e = (double)util_form_factor(back, c);
            mean += e / SEEN;
            error[gather] += ((double)light[3 * i] - e) * ((double)light[3 * i] - e) / SEEN;
            all[gather] += (double)light[3 * i] / SEEN;
            peak[gather] = fmax(peak[gather], fabs((double)light[3 * i] - e));
        }
    }
    printf("ornament: relative RMSE %.4f by VPLs, %.4f by near points; means %.4f, %.4f; worst %.3f, %.3f\n",
           sqrt(error[0]) / mean, sqrt(error[1]) / mean, all[0] / mean, all[1] / mean, peak[0], peak[1]);
    assert_true(sqrt(error[1]) < 0.05 * mean && error[1] < 0.25 * error[0] && fabs(all[1] / mean - 1) < 0.03);
    ism_free(m);
}

/* ---- who has none ---- */

static void lists_lobes_and_directions_have_no_near_points(void **state)
{
    static float lobes[4 * SIDE * SIDE];
    ism_source s[2];
    ism_points view;
    ism_desc d;
    ism_maps *m;
    ism_vpl list[20];
    const ism_vpl *v;
    float a[3 * SEEN], b[3 * SEEN];
    ism_shading shading = { 0 };
    ism_frame f;
    size_t n, i, count;
    (void)state;
    assert_null(ism_near_points(NULL, &n));
    assert_int_equal(n, 0);
    make_corner(&s[0], &view);
    memset(&d, 0, sizeof d);
    d.vpl_count = 8;                        /* too few for a reach */
    m = choose(&d, s, 1, &view);
    assert_null(ism_near_points(m, &n));
    ism_free(m);
    d.vpl_count = 9;
    m = choose(&d, s, 1, &view);
    assert_non_null(ism_near_points(m, &n));
    memset(&f, 0, sizeof f);
    f.points = &view;                         /* black */
    assert_int_equal(ism_choose(m, &f), ISM_OK);
    assert_null(ism_near_points(m, &n));
    ism_free(m);
    d.vpl_count = 20;
    d.near_point_count = -1;
    m = choose(&d, s, 1, &view);
    assert_null(ism_near_points(m, &n));
    shading.no_maps = 1;
    assert_int_equal(ism_shade(m, &view, &shading, a, NULL), ISM_OK);
    shading.near_mode = ISM_NEAR_PATCH;
    assert_int_equal(ism_shade(m, &view, &shading, b, NULL), ISM_OK);
    assert_memory_equal(a, b, sizeof a);
    ism_free(m);
    d.near_point_count = 0;
    m = choose(&d, s, 1, &view);
    v = ism_vpls(m, &count);
    assert_true(v[7].reach > 0);
    memcpy(list, v, sizeof list);           /* one's own list: the reaches in it do not count */
    assert_int_equal(ism_set_vpls(m, list, 20), ISM_OK);
    assert_null(ism_near_points(m, &n));
    v = ism_vpls(m, &count);
    for (i = 0; i < 20; i++) assert_true(!(v[i].reach > 0));
    ism_free(m);
    /* half of the flux from lobes, and directions besides: neither has near points, the rest has */
    for (i = 0; i < SIDE * SIDE; i++) {
        lobes[4 * i + 1] = 1;
        lobes[4 * i + 3] = i % SIDE < SIDE / 2 ? 8.0f : 1.0f;
    }
    s[0].lobes = lobes;
    s[1] = s[0];
    s[1].kind = ISM_SOURCE_DIRECTIONS;
    s[1].positions = lit.n;
    s[1].lobes = NULL;
    s[1].areas = NULL;
    d.vpl_count = 200;
    d.importance = ISM_IMPORTANCE_FLUX;
    m = choose(&d, s, 2, &view);
    v = ism_vpls(m, &count);
    for (i = 0; i < count; i++) assert_true((v[i].reach > 0) == (!v[i].directional && v[i].exponent < 2));
    assert_non_null(ism_near_points(m, &n));
    assert_in_range(n, 750, 850);           /* a quarter of 3200 */
    for (i = 0; i < n; i++) assert_true(ism_near_points(m, NULL)[i].position[0] > -0.1f);
    ism_free(m);
    d.near_point_count = 65;
    assert_int_equal(ism_create(&d, &m), ISM_ERR_DESC);
}

/* Any order of the tasks, and the same again, give the same bytes; another seed gives others. */
static void any_order_of_tasks_gives_the_same_bytes(void **state)
{
    ism_source s;
    ism_points view;
    ism_desc d;
    ism_maps *m[3];
    const ism_near_point *p[3];
    size_t n[3];
    int k;
    (void)state;
    make_corner(&s, &view);
    memset(&d, 0, sizeof d);
    d.vpl_count = 128;
    for (k = 0; k < 3; k++) {
        d.system.parallel_for = k == 1 ? backwards : NULL;
        d.seed = k == 2;
        m[k] = choose(&d, &s, 1, &view);
        p[k] = ism_near_points(m[k], &n[k]);
        assert_int_equal(n[k], 128 * 16);
    }
    assert_memory_equal(p[0], p[1], n[0] * sizeof *p[0]);
    assert_true(memcmp(p[0], p[2], n[0] * sizeof *p[0]) != 0);
    for (k = 0; k < 3; k++) ism_free(m[k]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pixel_alone_has_all_near_points),
        cmocka_unit_test(light_in_a_corner_is_near_the_truth), cmocka_unit_test(no_flux_is_lost),
        cmocka_unit_test(vpls_and_near_points_sum_to_the_formula),
        cmocka_unit_test(a_near_point_belongs_to_its_nearest_vpl),
        cmocka_unit_test(an_ornament_lights_the_wall_by_its_form_factor),
        cmocka_unit_test(lists_lobes_and_directions_have_no_near_points),
        cmocka_unit_test(any_order_of_tasks_gives_the_same_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
