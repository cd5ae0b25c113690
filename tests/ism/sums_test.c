/* sums_test - ism.h beside brute force in double: every effect of a possible VPL, every draw, every point and disc,
   every texel of a map, its pull and push, every light of a pixel. */

#define ISM_STATIC
#define ISM_IMPLEMENTATION
#include "ism.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "util.h"

/* Of ism.h, only its random numbers, its basis about a direction and its places in maps (T46) are used here. */

static soup mesh;
static grid lit, eye;
static uint32_t state_of_random;

static double any(void)                          /* -1..1 */
{
    state_of_random = state_of_random * 1664525u + 1013904223u;
    return (double)(state_of_random >> 8) / 8388608.0 - 1;
}

typedef struct vec { double x, y, z; } vec;

static vec v3(double x, double y, double z) { vec v = { x, y, z }; return v; }
static vec load(const float *p) { return v3((double)p[0], (double)p[1], (double)p[2]); }
static vec along(vec a, vec b, double s) { return v3(a.x + b.x * s, a.y + b.y * s, a.z + b.z * s); }
static vec minus(vec a, vec b) { return along(a, b, -1); }
static vec times(vec a, double s) { return v3(a.x * s, a.y * s, a.z * s); }
static double dot(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static vec cross(vec a, vec b) { return v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x); }
static double length(vec a) { return sqrt(dot(a, a)); }
static vec unit(vec a) { return times(a, 1 / length(a)); }
static void store(float *p, vec v) { p[0] = (float)v.x; p[1] = (float)v.y; p[2] = (float)v.z; }
/* Function arguments are evaluated in any order: one number after the other here. */
static vec any3(double x, double y, double z)
{
    vec v;
    v.x = x * any();
    v.y = y * any();
    v.z = z * any();
    return v;
}

static int near_to(double a, double b, double relative) { return fabs(a - b) <= relative * (fabs(b) + 1e-6); }
static double mean3(const float *f) { return ((double)f[0] + (double)f[1] + (double)f[2]) / 3; }

static double unit_of(uint32_t bits) { return (double)ism__to_unit(bits); }

/* ---- light of a list of VPLs ---- */

enum { VPLS = 37, W = 21, H = 18, PIXELS = W * H };

static ism_vpl list[VPLS];
static float geometric[3 * PIXELS], albedos[3 * PIXELS], light[3 * PIXELS];

static void make_list(void)
{
    int i;
    state_of_random = 3;
    for (i = 0; i < VPLS; i++) {
        vec n = unit(along(v3(0, 0.5, 0), any3(1, 1, 1), 1)), a = unit(along(n, any3(1, 1, 1), 0.5)),
            at = any3(1.5, 0.2, 1.5);
        list[i] = util_vpl((float)at.x, (float)at.y, (float)at.z, (float)n.x, (float)n.y, (float)n.z, 1);
        list[i].area = i % 5 ? (float)(0.2 + 0.1 * any()) : 0;
        list[i].flux[1] = (float)(0.5 + 0.4 * any());
        list[i].flux[2] = (float)(2 + any());
        if (i % 6 == 1) {
            list[i].exponent = (float)(i % 4 ? 5.5 : 0);
            store(list[i].axis, a);
        }
        if (i % 9 == 4) {                        /* a sky's: position is the direction to it */
            list[i].directional = 1;
            store(list[i].position, times(n, 1));
            store(list[i].normal, times(n, -1));
            store(list[i].axis, times(n, -1));
        }
    }
    memcpy(list[12].position, list[11].position, 12);       /* two at one place share a square */
    memcpy(list[12].normal, list[11].normal, 12);
    list[11].area = list[12].area = 0.03f;
    for (i = 0; i < PIXELS; i++) {
        vec n = unit(along(v3(0, -1, 0), any3(0.3, 0, 0.3), 1));
        store(eye.p + 3 * i, v3(1.6 * (i % W) / W - 0.8, 0.9 + 0.004 * (i % W), 1.6 * (i / W) / H - 0.8));
        store(eye.n + 3 * i, n);
        store(geometric + 3 * i, unit(along(n, any3(1, 1, 1), 0.1)));
        store(albedos + 3 * i, v3(0.5, 0.25 + 0.2 * any(), 1));
        if (i % 50 == 49) memset(eye.n + 3 * i, 0, 12);     /* background */
        if (i % W >= 14 && i % W < 16) store(eye.n + 3 * i, v3(0.8, -0.6, 0));
    }
    geometric[3 * 30] = ism__from_bits(0x7fc00000u);        /* the shading normal then */
    albedos[3 * 31] = ism__from_bits(0x7fc00000u);
    eye.w = W;
    eye.h = H;
}

static ism_points view_of_list(void)
{
    ism_points v = grid_view(&eye);
    v.geometric_normals = geometric;
    v.albedos = albedos;
    return v;
}

/* The side of a VPL's square: its area, of which none reaches farther than its fourth neighbour, or a quarter of
   the disc as far as that. */
static double side_of(size_t index, size_t count)
{
    const ism_vpl *v = &list[index];
    double near2[4] = { 1e30, 1e30, 1e30, 1e30 }, area = (double)v->area, most;
    size_t i;
    int k, j;
    if (v->directional || v->exponent < 1 || v->exponent > 1) return 0;
    for (i = 0; i < count; i++) {
        vec d = minus(load(list[i].position), load(v->position));
        double d2 = dot(d, d);
        if (i == index || list[i].directional || dot(load(list[i].normal), load(v->normal)) < 0.5) continue;
        if (!(d2 > 0)) {
            area += (double)list[i].area;
            continue;
        }
        for (k = 0; k < 4 && near2[k] < d2; k++) {}
        for (j = 3; j > k; j--) near2[j] = near2[j - 1];
        if (k < 4) near2[k] = d2;
    }
    most = near2[3] < 1e30 ? UTIL_PI * near2[3] : 0;
    if (!(area > 0)) area = 0.25 * most;
    else if (most > 0) area = fmin(area, 2 * most);
    return sqrt(area);
}

static void squares_reach_to_their_neighbours(void **state)
{
    size_t counts[4] = { VPLS, 13, 5, 2 }, n, i, k;
    ism_maps *m;
    ism_desc d;
    (void)state;
    make_list();
    memset(&d, 0, sizeof d);
    d.vpl_count = VPLS;
    assert_int_equal(ism_create(&d, &m), ISM_OK);
    for (k = 0; k < 4; k++) {
        assert_int_equal(ism_set_vpls(m, list, counts[k]), ISM_OK);
        for (i = 0; i < counts[k]; i++) {
            if (!near_to((double)ism_vpls(m, &n)[i].edge, side_of(i, counts[k]), 1e-5))
                fail_msg("%d of %d: %g, not %g", (int)i, (int)counts[k], (double)ism_vpls(m, &n)[i].edge,
                         side_of(i, counts[k]));
        }
        assert_int_equal(n, counts[k]);
    }
    ism_free(m);
}

/* Lambert's sum over the part of a polygon above the horizon; the share of its area that this is. */
static double form_of(vec n, const vec *corner, double *share)
{
    vec p[8], area = v3(0, 0, 0), whole = area;
    double sum = 0;
    int i, k = 0;
    for (i = 0; i < 4; i++) {
        vec a = corner[i], b = corner[(i + 1) % 4];
        double s = dot(n, a), t = dot(n, b);
        if (s > 0) p[k++] = a;
        if (s * t < 0) p[k++] = along(a, minus(b, a), s / (s - t));
        whole = along(whole, cross(a, b), 1);
    }
    for (i = 0; i < k; i++) {
        vec c = cross(p[(i + 1) % k], p[i]);
        sum += atan2(length(c), dot(p[i], p[(i + 1) % k])) * dot(n, c) / length(c);
        area = along(area, cross(p[i], p[(i + 1) % k]), 1);
    }
    *share = k ? length(area) / length(whole) : 0;
    return sum / (2 * UTIL_PI);
}

/* What VPL i gives a receiver, x pi; plain: without the rule near by. */
static double kernel_of(const ism_vpl *v, vec p, vec n, const ism_shading *s, double *plain)
{
    vec d = minus(load(v->position), p), vn = load(v->normal);
    double d2 = dot(d, d), l = sqrt(d2), a = dot(n, d) / l, b = -dot(vn, d) / l, side = (double)v->edge, k;
    int diffuse = v->exponent >= 1 && v->exponent <= 1;
    if (v->directional) return *plain = fmax(0, dot(load(v->position), n)) * UTIL_PI;
    if (diffuse) k = a > 0 && b > 0 ? a * b / d2 : 0;
    else {
        double c = -dot(load(v->axis), d) / l;
        k = a > 0 && c > 0 ? 0.5 * ((double)v->exponent + 1) * pow(c, (double)v->exponent) * a / d2 : 0;
    }
    *plain = k;
    if (s->near_mode == ISM_NEAR_CLAMP) return fmin(k, s->clamp > 0 ? (double)s->clamp : 1.0);
    if (!diffuse || !(side > 0) || !(k > 0)) return k;
    if (s->near_mode == ISM_NEAR_SPHERE && d2 < 16 * side * side) {
        double r2 = side * side / UTIL_PI, least = d2 > r2 ? sqrt(1 - r2 / d2) : -1, sum = 0;
        ism__v3 x, y;
        int i;
        vec z = unit(d);
        ism__v3_basis(ism__v3_make((float)z.x, (float)z.y, (float)z.z), &x, &y);
        for (i = 0; i < 16; i++) {
            double c = 1 - (1 - least) * (i + 0.5) / 16, r = sqrt(1 - c * c), t = 2.39996323 * i;
            vec w = along(along(times(z, c), v3((double)x.x, (double)x.y, (double)x.z), r * cos(t)),
                          v3((double)y.x, (double)y.y, (double)y.z), r * sin(t));
            if (dot(n, w) > 0 && dot(vn, w) < 0) sum -= dot(n, w) * dot(vn, w) / 16;
        }
        return sum * 2 * (1 - least) / r2;
    }
    if ((s->near_mode == ISM_NEAR_PATCH || s->near_mode == ISM_NEAR_DEFAULT) && d2 < 9 * side * side) {
        vec c[4], x, y;
        ism__v3 bx, by;
        double share, form, facing = -2 * dot(n, vn);
        int i;
        ism__v3_basis(ism__v3_load(v->normal), &bx, &by);
        x = times(v3((double)bx.x, (double)bx.y, (double)bx.z), side / 2);
        y = times(v3((double)by.x, (double)by.y, (double)by.z), side / 2);
        for (i = 0; i < 4; i++) c[i] = along(along(d, x, i == 0 || i == 3 ? -1 : 1), y, i < 2 ? -1 : 1);
        form = form_of(n, c, &share);
        form = share > 0 ? form * UTIL_PI / (side * side * share) : 0;
        *plain = form;
        return facing > 0 && form > k ? form + fmin(1, facing) * (k - form) : form;
    }
    return k;
}

static int seen_by(uint32_t vpl, double x, double z)
{
    return (int)(1000 * x + 37 * z + 3.3 * vpl + 5000) % 3 != 0;
}

static void see(void *user, const float p[3], const float n[3], const uint32_t *vpls, size_t count, float *visible)
{
    size_t i;
    (void)user;
    assert_true(count <= 64 && fabsf(n[0]) <= 1);
    for (i = 0; i < count; i++) visible[i] = (float)seen_by(vpls[i], (double)p[0], (double)p[2]);
}

static int is_receiver(size_t i) { return fabsf(eye.n[3 * i + 1]) > 0; }

static void shade_brute(const ism_vpl *v, size_t count, const ism_shading *s, double *out, double lost[2])
{
    const int pattern = s->interleave ? (int)s->interleave : 1;
    static double raw[3 * PIXELS];
    int i, c, x, y;
    lost[0] = lost[1] = 0;
    memset(raw, 0, sizeof raw);
    for (i = 0; i < PIXELS; i++) {
        const int first = i / W % pattern * pattern + i % W % pattern, classes = pattern * pattern;
        vec p = load(eye.p + 3 * i), n = load(eye.n + 3 * i);
        double of_class = 0, mean = 0, plain, power;
        size_t k;
        if (!is_receiver((size_t)i)) continue;
        for (k = (size_t)first; k < count; k += (size_t)classes) {
            of_class++;
            mean += kernel_of(&v[k], p, n, s, &plain) * mean3(v[k].flux);
        }
        mean /= fmax(1, of_class);
        for (k = (size_t)first; k < count; k += (size_t)classes) {
            double form = kernel_of(&v[k], p, n, s, &plain);
            power = mean3(v[k].flux);
            if (s->near_mode == ISM_NEAR_CLAMP_MEAN)
                form = fmin(form, (s->clamp > 0 ? (double)s->clamp : 1.0) * mean / power);
            if (!(form > 0) || (s->visible_fn && !seen_by((uint32_t)k, (double)eye.p[3 * i], (double)eye.p[3 * i + 2])))
                continue;
            for (c = 0; c < 3; c++) raw[3 * i + c] += form * (double)v[k].flux[c] / UTIL_PI * classes;
            lost[0] += fmax(0, plain - form) * power;
            lost[1] += fmax(plain, form) * power;
        }
    }
    memcpy(out, raw, sizeof raw);
    for (i = 0; i < PIXELS && pattern > 1; i++) {
        vec p = load(eye.p + 3 * i), n = load(eye.n + 3 * i);
        double sum[3] = { 0, 0, 0 }, weights = 0;
        const int r = pattern / 2;
        if (!is_receiver((size_t)i)) continue;
        for (y = -r; y <= r; y++)
            for (x = -r; x <= r; x++) {
                const int j = i + y * W + x;
                double w = (abs(x) == r ? 0.5 : 1) * (abs(y) == r ? 0.5 : 1), off, facing;
                vec d, m;
                if (i % W + x < 0 || i % W + x >= W || i / W + y < 0 || i / W + y >= H || !is_receiver((size_t)j))
                    continue;
                d = minus(load(eye.p + 3 * j), p);
                m = load(eye.n + 3 * j);
                facing = fmax(0, dot(n, m));
                off = fabs(dot(n, d)) + fabs(dot(m, d));
                w *= facing * facing * (i == j ? 1 : fmax(0, 1 - off / length(d)));
                for (c = 0; c < 3; c++) sum[c] += w * raw[3 * j + c];
                weights += w;
            }
        for (c = 0; c < 3; c++) out[3 * i + c] = sum[c] / weights;
    }
}

static void every_light_is_summed(void **state)
{
    static double expected[3 * PIXELS];
    ism_points view = view_of_list();
    ism_maps *m;
    ism_desc d;
    int way;
    (void)state;
    make_list();
    view = view_of_list();
    memset(&d, 0, sizeof d);
    d.vpl_count = VPLS;
    assert_int_equal(ism_create(&d, &m), ISM_OK);
    for (way = 0; way < 14; way++) {
        ism_shading s = { 0 };
        ism_stats stats;
        size_t count, used = way == 12 ? 3 : VPLS, i, c;
        const ism_vpl *v;
        double lost[2];
        assert_int_equal(ism_set_vpls(m, list, used), ISM_OK);
        v = ism_vpls(m, &count);
        s.no_maps = 1;
        if (way < 6) s.near_mode = (ism_near)way;
        if (way == 3 || way == 4) s.clamp = 0.4f;
        if (way >= 6 && way < 9) s.interleave = 1u << (way - 5);
        if (way == 9) s.visible_fn = see;
        if (way == 10) {
            s.visible_fn = see; s.interleave = 2; s.near_mode = ISM_NEAR_CLAMP; s.clamp = 0.3f; s.cull = 1;
        }
        if (way == 11) s.cull = 1;
        if (way == 12) s.interleave = 4;            /* most classes are empty */
        if (way == 13) view.albedos = NULL;
        memset(light, 0x55, sizeof light);
        assert_int_equal(ism_shade(m, &view, &s, light, &stats), ISM_OK);
        shade_brute(v, count, &s, expected, lost);
        for (i = 0; i < PIXELS; i++)
            for (c = 0; c < 3; c++) {
                double e = expected[3 * i + c];
                if (way != 13) e *= i == 31 && c == 0 ? 0 : (double)albedos[3 * i + c] / UTIL_PI;
                if (!(fabs((double)light[3 * i + c] - e) < 2e-4 * (e + 0.01)))
                    fail_msg("way %d, pixel %d: %g, not %g", way, (int)i, (double)light[3 * i + c], e);
            }
        assert_true(fabs(stats.lost_energy - lost[0] / lost[1]) < 1e-5 * (1 + lost[0] / lost[1]));
        if (way == 3 || way == 4 || way == 10) assert_true(stats.lost_energy > 0.01);
    }
    ism_free(m);
}

/* Pixels at one place: those of a window take each class of VPLs once, and their mean is the light of all of them,
   however few of them there are and whether or not they fill the classes evenly. */
static void patterns_share_out_all_the_light(void **state)
{
    enum { SIDE = 24, MIDDLE = 12 * SIDE + 12 };
    static const uint32_t counts[] = { 1, 3, 16, 37 };
    static float pictured[3 * SIDE * SIDE];
    const float a[3] = { 0.2f, 0.9f, -0.1f }, none[3] = { 0, 0, 0 }, down[3] = { 0, -1, 0 };
    ism_points view;
    ism_maps *m;
    ism_desc d;
    uint32_t i, k, pattern, c;
    (void)state;
    make_list();
    grid_fill(&eye, SIDE, SIDE, a, none, none, down, 0);
    view = grid_view(&eye);
    memset(&d, 0, sizeof d);
    d.vpl_count = VPLS;
    assert_int_equal(ism_create(&d, &m), ISM_OK);
    for (i = 0; i < 4; i++) {
        double expected[3] = { 0, 0, 0 }, plain;
        ism_shading s = { 0 };
        assert_int_equal(ism_set_vpls(m, list, counts[i]), ISM_OK);
        s.no_maps = 1;
        s.near_mode = ISM_NEAR_NONE;
        for (k = 0; k < counts[i]; k++)
            for (c = 0; c < 3; c++)
                expected[c] += kernel_of(&list[k], load(a), load(down), &s, &plain) * (double)list[k].flux[c] / UTIL_PI;
        for (pattern = 1; pattern <= 8; pattern *= 2) {
            s.interleave = pattern;
            assert_int_equal(ism_shade(m, &view, &s, pictured, NULL), ISM_OK);
            for (c = 0; c < 3; c++)
                if (!near_to((double)pictured[3 * MIDDLE + c], expected[c], 1e-5))
                    fail_msg("%u VPLs, pattern %u: %g, not %g", counts[i], pattern,
                             (double)pictured[3 * MIDDLE + c], expected[c]);
        }
    }
    ism_free(m);
}

/* The same of near points, as few of which as there may be lie within reach. */
static void patterns_share_out_near_points(void **state)
{
    enum { SIDE = 24, MIDDLE = 12 * SIDE + 12 };
    static float pictured[3 * SIDE * SIDE];
    const float a[3] = { -1, 0, -1 }, u[3] = { 2, 0, 0 }, v[3] = { 0, 0, 2 }, up[3] = { 0, 1, 0 };
    const float at[3] = { 0.1f, 0.15f, 0.05f }, none[3] = { 0, 0, 0 }, down[3] = { 0, -1, 0 };
    ism_source source;
    ism_frame f;
    ism_points view;
    ism_maps *m;
    ism_desc d;
    uint32_t near_points, pattern, c;
    (void)state;
    grid_fill(&lit, 32, 32, a, u, v, up, 0.01f);
    grid_fill(&eye, SIDE, SIDE, at, none, none, down, 0);
    source = grid_source(&lit);
    view = grid_view(&eye);
    memset(&f, 0, sizeof f);
    f.sources = &source;
    f.source_count = 1;
    f.points = &view;
    for (near_points = 1; near_points <= 3; near_points++) {
        ism_shading s = { 0 };
        float all[3] = { 0, 0, 0 };
        size_t count;
        memset(&d, 0, sizeof d);
        d.vpl_count = 11;
        d.near_point_count = (int32_t)near_points;
        assert_int_equal(ism_create(&d, &m), ISM_OK);
        assert_int_equal(ism_choose(m, &f), ISM_OK);
        (void)ism_near_points(m, &count);
        assert_int_equal(count, 11 * near_points);
        s.no_maps = 1;
        for (pattern = 1; pattern <= 8; pattern *= 2) {
            s.interleave = pattern;
            assert_int_equal(ism_shade(m, &view, &s, pictured, NULL), ISM_OK);
            if (pattern == 1) memcpy(all, pictured + 3 * MIDDLE, sizeof all);
            for (c = 0; c < 3; c++)
                if (!near_to((double)pictured[3 * MIDDLE + c], (double)all[c], 1e-5))
                    fail_msg("%u near points, pattern %u: %g, not %g", 11 * near_points, pattern,
                             (double)pictured[3 * MIDDLE + c], (double)all[c]);
        }
        ism_free(m);
    }
}

/* ---- the choice ---- */

enum { LIT = 12, SEEN_W = 24, SEEN_H = 16 };

static ism_frame choice_frame(ism_source *s, ism_points *view)
{
    const float a[3] = { -2, 0, -2 }, u[3] = { 4, 0, 0 }, v[3] = { 0, 0, 4 }, up[3] = { 0, 1, 0 };
    const float b[3] = { -1.5f, 2, -1.5f }, p[3] = { 3, 0.3f, 0 }, q[3] = { 0, -0.3f, 3 }, down[3] = { 0, -1, 0 };
    ism_frame f;
    int i;
    static const float matrix[16] = { 0.6f,  0.05f,  0, 0.03f, 0.1f,  -0.07f, 0, 0.3f,
                                      0.08f, -0.55f, 0, 0.02f, 0.04f, 0.06f,  0, 1 };
    grid_fill(&lit, LIT, LIT, a, u, v, up, 1);
    grid_fill(&eye, SEEN_W, SEEN_H, b, p, q, down, 0);
    state_of_random = 31;
    for (i = 0; i < LIT * LIT; i++) {
        store(lit.f + 3 * i, along(v3(0.5, 1, i % 13 ? 0.3 : 4), any3(0.4, 1, 0), 1));
        if (i % 29 == 3) store(lit.f + 3 * i, v3(0, 0, 0));
        if (i % LIT > 7) {
            lit.p[3 * i + 1] = 0.6f;             /* a step, then a slope */
            if (i / LIT > 6) {
                lit.p[3 * i + 1] = 0.6f + 0.02f * (float)(i / LIT);
                store(lit.n + 3 * i, unit(v3(0.3 * any(), 1, -0.06)));
            }
        }
    }
    for (i = 0; i < SEEN_W * SEEN_H; i++) {
        store(eye.n + 3 * i, unit(along(v3(0, -1, 0), any3(0.3, 0, 0.3), 1)));
        if (i % 31 == 5) memset(eye.n + 3 * i, 0, 12);
    }
    *s = grid_source(&lit);
    *view = grid_view(&eye);
    view->rows = ISM_ROWS_TOP_FIRST;
    /* The floor fills most of the picture, aslant and in perspective. */
    memcpy(view->world_to_clip, matrix, sizeof matrix);
    memset(&f, 0, sizeof f);
    f.sources = s;
    f.source_count = 1;
    f.points = view;
    return f;
}

static void pixel_of(const ism_points *view, vec p, double *x, double *y)
{
    double c[4];
    int k;
    for (k = 0; k < 4; k++)
        c[k] = (double)view->world_to_clip[k] * p.x + (double)view->world_to_clip[4 + k] * p.y +
               (double)view->world_to_clip[8 + k] * p.z + (double)view->world_to_clip[12 + k];
    *x = (0.5 + 0.5 * c[0] / c[3]) * SEEN_W;
    *y = (0.5 - 0.5 * c[1] / c[3]) * SEEN_H;
}

/* Mean square of the effect of a pVPL on the picture, by grid x grid samples, half of them about its place if guided.
 */
static double effect_of(const ism_points *view, int i, uint32_t many, int guided, uint32_t seed, double extent,
                        int *sure)
{
    const double w = SEEN_W, h = SEEN_H, r0 = 0.05 * fmax(w, h), reach = w + h, inner = 1 / (1 + 2 * log(reach / r0));
    vec q = load(lit.p + 3 * i), n = load(lit.n + 3 * i);
    double cx, cy, sum = 0;
    uint32_t k, rank = 0;
    pixel_of(view, q, &cx, &cy);
    for (k = 0; k < many * many; k++) {
        uint32_t hash = ism__hash_combine(seed, (uint32_t)i * 256u + k);
        double u = ((double)(k % many) + unit_of(hash)) / many,
               v = ((double)(k / many) + unit_of(ism__hash32(hash))) / many;
        double x, y, density = 1 / (w * h), d2, a, b, odd = floor(many * many / 2.0) / (many * many);
        size_t at;
        vec d;
        int about = guided && (k % many + k / many) % 2;
        if (about && many % 2) {                 /* numbers of their own: rows have not as many of either kind */
            u = (rank + unit_of(hash)) / (many * many / 2);
            v = unit_of(ism__hash_combine(seed, (uint32_t)i * 256u + 255u) + rank++ * 2654435769u);
        }
        x = u * w;
        y = v * h;
        if (about) {
            double r = u < inner ? r0 * sqrt(u / inner) : r0 * pow(reach / r0, (u - inner) / (1 - inner));
            x = cx + r * cos(2 * UTIL_PI * v);
            y = cy + r * sin(2 * UTIL_PI * v);
        }
        if (fabs(x - floor(x + 0.5)) < 3e-5 || fabs(y - floor(y + 0.5)) < 3e-5) *sure = 0;
        if (x < 0 || y < 0 || x >= w || y >= h) continue;
        if (guided) {
            double r2 = (x - cx) * (x - cx) + (y - cy) * (y - cy);
            density = (1 - odd) * density + odd * inner / (UTIL_PI * r0 * r0) * fmin(1, r0 * r0 / r2);
        }
        at = (size_t)y * SEEN_W + (size_t)x;
        if (!is_receiver(at)) continue;
        d = minus(load(eye.p + 3 * at), q);
        d2 = dot(d, d) + 1e-4 * extent * extent;
        a = -dot(load(eye.n + 3 * at), d);
        b = dot(n, d);
        if (a > 0 && b > 0) sum += pow(a * b / (d2 * d2), 2) / (w * h * density);
    }
    return sum / (many * many);
}

/* flux x (blurred effect + flux_share of the mean). */
static void importance_brute(const ism_points *view, const ism_desc *d, int guided, double *out, int *sure)
{
    const int r = d->blur_radius < 0 ? 0 : d->blur_radius ? (int)d->blur_radius : (int)(0.05 * LIT);
    static double effect[LIT * LIT];
    static int known[LIT * LIT];
    const uint32_t seed = ism__hash_combine(d->seed, 0), many = d->view_grid_side ? d->view_grid_side : 4;
    double lo[3] = { 1e9, 1e9, 1e9 }, hi[3] = { -1e9, -1e9, -1e9 }, extent = 0, total = 0, flux = 0,
           share = (double)d->flux_share;
    int i, x, y, k;
    for (i = 0; i < SEEN_W * SEEN_H; i++)
        for (k = 0; k < 3 && is_receiver((size_t)i); k++) {
            lo[k] = fmin(lo[k], (double)eye.p[3 * i + k]);
            hi[k] = fmax(hi[k], (double)eye.p[3 * i + k]);
        }
    for (k = 0; k < 3; k++) extent += (hi[k] - lo[k]) * (hi[k] - lo[k]);
    for (i = 0; i < LIT * LIT; i++) {
        known[i] = 1;
        effect[i] = mean3(lit.f + 3 * i) > 0 ? effect_of(view, i, many, guided, seed, sqrt(extent), &known[i]) : 0;
    }
    if (!(share > 0)) share = 0.1;
    for (i = 0; i < LIT * LIT; i++) {
        double sum = 0, weights = 0;
        int wide = 1;
        for (y = -r; y <= r; y++)
            for (x = -r; x <= r; x++) {
                const int j = i + y * LIT + x;
                vec n = load(lit.n + 3 * i), e;
                double w;
                if (i % LIT + x < 0 || i % LIT + x >= LIT || i / LIT + y < 0 || i / LIT + y >= LIT) continue;
                if (!(mean3(lit.f + 3 * j) > 0)) continue;
                e = minus(load(lit.p + 3 * j), load(lit.p + 3 * i));
                w = dot(n, load(lit.n + 3 * j));
                if (w <= 0.5 || fabs(dot(n, e)) > 0.3 * length(e)) continue;
                sum += w * effect[j];
                weights += w;
                wide &= known[j];
            }
        out[i] = mean3(lit.f + 3 * i) > 0 ? sqrt(sum / weights) : 0;
        sure[i] = wide;
        flux += mean3(lit.f + 3 * i);
        total += mean3(lit.f + 3 * i) * out[i];
    }
    for (i = 0; i < LIT * LIT; i++)
        out[i] = mean3(lit.f + 3 * i) * (out[i] + total / flux * share / (1 - 0.999 * share));
}

static void importances_are_effects(void **state)
{
    static double expected[LIT * LIT];
    static int sure[LIT * LIT];
    ism_source s;
    ism_points view;
    ism_frame f = choice_frame(&s, &view);
    int way;
    (void)state;
    for (way = 0; way < 6; way++) {
        ism_desc d;
        ism_maps *m;
        const float *got;
        size_t count, i, known = 0;
        memset(&d, 0, sizeof d);
        d.vpl_count = 8;
        d.seed = (uint32_t)way;
        d.importance = way % 2 ? ISM_IMPORTANCE_BRSM : ISM_IMPORTANCE_GUIDED;
        if (way >= 2) d.blur_radius = 2;
        if (way >= 4) { d.blur_radius = -1; d.view_grid_side = 7; d.flux_share = 0.3f; }
        assert_int_equal(ism_create(&d, &m), ISM_OK);
        assert_int_equal(ism_choose(m, &f), ISM_OK);
        got = ism_importances(m, 0, &count);
        assert_int_equal(count, LIT * LIT);
        importance_brute(&view, &d, way % 2 == 0, expected, sure);
        for (i = 0; i < count; i++) {
            if (!sure[i]) continue;
            known++;
            /* what is not sure moves the mean that flux_share is of */
            if (!near_to((double)got[i], expected[i], 3e-4))
                fail_msg("way %d, texel %d: %g, not %g", way, (int)i, (double)got[i], expected[i]);
        }
        if (known < LIT * LIT / 2) fail_msg("way %d: only %d are sure", way, (int)known);
        ism_free(m);
    }
}

/* Guided samples of odd grids too lie about the pVPL: of a light over the middle of the picture, which shines on that
   alone, their mean over many pVPLs at one place is the mean over all pixels, but for the squares of the chessboard:
   of three a side the middle is one that the others look at, of two none is. */
static void guided_grids_see_what_is_near(void **state)
{
    enum { MANY = 1024 };
    static const uint32_t grids[] = { 2, 3, 4, 5, 7 };
    static float p[3 * MANY], n[3 * MANY], flux[3 * MANY];
    static const float matrix[16] = { 1, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1 };
    const float a[3] = { -1, 0, -1 }, u[3] = { 2, 0, 0 }, v[3] = { 0, 0, 2 }, up[3] = { 0, 1, 0 };
    uint32_t k;
    int i;
    (void)state;
    grid_fill(&eye, 48, 48, a, u, v, up, 0);
    for (i = 0; i < MANY; i++) {
        store(p + 3 * i, v3(0, 0.03, 0));
        store(n + 3 * i, v3(0, -1, 0));
        store(flux + 3 * i, v3(1, 1, 1));
    }
    for (k = 0; k < 5; k++) {
        ism_desc d;
        ism_source s;
        ism_points view = grid_view(&eye);
        ism__choice c;
        ism_frame f;
        ism__job job;
        ism_maps *m;
        double mean = 0, expected = 0;
        memset(&d, 0, sizeof d);
        memset(&s, 0, sizeof s);
        memset(&c, 0, sizeof c);
        memset(&f, 0, sizeof f);
        d.view_grid_side = grids[k];
        assert_int_equal(ism_create(&d, &m), ISM_OK);
        memcpy(view.world_to_clip, matrix, sizeof matrix);
        view.rows = ISM_ROWS_TOP_FIRST;
        s.width = MANY;
        s.height = 1;
        s.positions = p;
        s.normals = n;
        s.fluxes = flux;
        f.points = &view;
        c.m = m;
        ism__begin_job(&d.system, "", &f, &job);
        assert_int_equal(ism__open_view(&job.log, &view, &job.view), ISM_OK);
        c.job = &job;
        c.extent = 2.83f;
        for (i = 0; i < MANY; i++) mean += (double)ism__estimate_effect(&c, &s, (size_t)i) / MANY;
        for (i = 0; i < 48 * 48; i++) {
            vec to = minus(v3(0, 0.03, 0), load(eye.p + 3 * i));
            double d2 = dot(to, to) + 1e-4 * (double)(c.extent * c.extent), e = to.y * to.y / (d2 * d2);
            expected += e * e / (48 * 48);
        }
        if (!(fabs(mean / expected - 1) < 0.15))
            fail_msg("a grid of %u: mean square %g, of all pixels %g", grids[k], mean, expected);
        ism_free(m);
    }
}

/* VPL i of N: the number (i + 0.5) / N picks the row by the sums of importance, a lattice the texel and the place in
   it; its place is mixed from the four texels about it that lie on one surface. */
static void vpls_are_drawn_by_importance(void **state)
{
    enum { N = 64 };
    ism_source s;
    ism_points view;
    ism_frame f = choice_frame(&s, &view);
    int way;
    (void)state;
    for (way = 0; way < 3; way++) {
        ism_desc d;
        ism_maps *m;
        const float *w;
        const ism_vpl *v;
        static float areas[LIT * LIT];
        double total = 0;
        size_t count, i, sure = 0;
        int c, k;
        memset(&d, 0, sizeof d);
        d.vpl_count = N;
        d.seed = 5;
        d.no_inter_texel = way == 1;
        for (i = 0; i < LIT * LIT; i++) areas[i] = 0.01f * (float)(i + 1);
        s.areas = way == 2 ? areas : NULL;
        assert_int_equal(ism_create(&d, &m), ISM_OK);
        assert_int_equal(ism_choose(m, &f), ISM_OK);
        w = ism_importances(m, 0, &count);
        v = ism_vpls(m, &i);
        assert_int_equal(i, N);
        for (i = 0; i < count; i++) total += (double)w[i];
        for (i = 0; i < N; i++) {
            double u = ((double)i + 0.5) / N * total, before = 0, row = 0, fx, fy, at = 0;
            double t = unit_of((uint32_t)i * 2654435769u + ism__hash_combine(d.seed, 12u));
            size_t y, x, texel;
            vec p0, n0, p, n;
            double scale, share[4], weights = 0, behind = 0;
            vec offsets[4], normals[4], sum = v3(0, 0, 0), normal = sum;
            int used = 0;
            for (y = 0; y < LIT; y++, before += row) {
                for (row = 0, x = 0; x < LIT; x++) row += (double)w[y * LIT + x];
                if (u < before + row) break;
            }
            fy = (u - before) / row;
            for (x = 0; x < LIT; at += (double)w[y * LIT + x], x++)
                if (t * row < at + (double)w[y * LIT + x]) break;
            texel = y * LIT + x;
            fx = (t * row - at) / (double)w[texel];
            if (fx < 1e-3 || fx > 0.999 || fy < 1e-3 || fy > 0.999) continue;
            sure++;
            assert_int_equal(v[i].texel, texel);
            assert_int_equal(v[i].source, 0);
            scale = total / (N * (double)w[texel]);
            for (c = 0; c < 3; c++)
                assert_true(near_to((double)v[i].flux[c], (double)lit.f[3 * texel + (size_t)c] * scale, 1e-4));
            assert_true(near_to((double)v[i].area, way == 2 ? (double)areas[texel] * scale : 0, 1e-4));
            p0 = load(lit.p + 3 * texel);
            n0 = load(lit.n + 3 * texel);
            for (k = 0; k < 4; k++) {
                int ox = k & 1 ? (fx < 0.5 ? -1 : 1) : 0, oy = k & 2 ? (fy < 0.5 ? -1 : 1) : 0;
                double a =
                    (k & 1 ? fabs(fx - 0.5) : 1 - fabs(fx - 0.5)) * (k & 2 ? fabs(fy - 0.5) : 1 - fabs(fy - 0.5));
                double x0, y0, x1, y1, ex, ey;
                size_t j = (size_t)((int)texel + oy * LIT + ox);
                vec q, nq, e;
                if ((int)x + ox < 0 || (int)x + ox >= LIT || (int)y + oy < 0 || (int)y + oy >= LIT) continue;
                if (!(mean3(lit.f + 3 * j) > 0)) continue;
                q = load(lit.p + 3 * j);
                nq = load(lit.n + 3 * j);
                e = minus(q, p0);
                if (k && (dot(n0, nq) <= 0.9 || fabs(dot(n0, e)) > 0.1 * length(e))) continue;
                pixel_of(&view, p0, &x0, &y0);
                pixel_of(&view, q, &x1, &y1);
                ex = 2 * (x1 - x0) / SEEN_W;
                ey = 2 * (y1 - y0) / SEEN_H;
                a *= exp(-(ex * ex + ey * ey) / (2 * 0.01));
                share[used] = a;
                offsets[used] = e;
                normals[used++] = nq;
                weights += a;
                sum = along(sum, e, a);
                normal = along(normal, nq, a);
            }
            sum = times(sum, 1 / weights);
            n = unit(normal);
            for (k = 0; k < used; k++)
                behind += share[k] / weights * dot(normals[k], minus(offsets[k], sum)) * dot(normals[k], n);
            p = along(along(p0, sum, 1), n, fmax(0, behind));
            if (way == 1) { p = p0; n = n0; }
            assert_true(length(minus(load(v[i].position), p)) < 1e-3);
            assert_true(length(minus(load(v[i].normal), n)) < 1e-3);
        }
        assert_true(sure > N * 3 / 4);
        ism_free(m);
    }
}

/* ---- points ---- */

enum { POINTS = 256, SAMPLED = 6 };

static vec corner_of(const ism_mesh *m, size_t t, int k)
{
    size_t i = m->indices ? m->indices[3 * t + (size_t)k] : 3 * t + (size_t)k;
    return load(m->positions + 3 * i);
}

static double solid_of(vec a, vec b, vec c)
{
    double la = length(a), lb = length(b), lc = length(c);
    return 2 * atan2(fabs(dot(a, cross(b, c))), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
}

/* A triangle is as likely as what it has of the area (a fifth) and of the view samples' solid angle, times, cluster by
   cluster, the root of what the VPL sees of the cluster over that. */
static void points_are_drawn(const ism_mesh *m, const ism_points *view, size_t triangles, ism_spread spread)
{
    static double weight[100000], shares[40000], effect[40000];
    const size_t size = triangles / 32768 + 1, clusters = (triangles + size - 1) / size;
    const size_t pixels = view->count;
    static uint32_t valid[65536];
    static ism_surfel points[POINTS];
    uint32_t valid_count = 0, seed = 9, v;
    double area_sum = 0, solid_sum = 0;
    static double solid[100000], area[100000];
    ism_desc d;
    ism_maps *maps;
    ism_frame f;
    size_t t, c, i, sure = 0;
    int k;
    for (i = 0; i < pixels; i++)
        if (is_receiver(i)) valid[valid_count++] = (uint32_t)i;
    for (t = 0; t < triangles; t++) {
        const uint32_t samples = spread == ISM_SPREAD_VIEW_1 ? 1 : 8;
        vec a = corner_of(m, t, 0), b = corner_of(m, t, 1), e = corner_of(m, t, 2), n = cross(minus(b, a), minus(e, a));
        uint32_t key = ism__hash_combine(seed, 0x7000u + (samples == 1 ? 0u : (uint32_t)t)), j;
        area[t] = 0.5 * length(n);
        solid[t] = 0;
        for (j = 0; j < samples && spread != ISM_SPREAD_AREA && area[t] > 0; j++) {
            const uint32_t at = valid[(uint64_t)ism__hash_combine(key, j) * valid_count >> 32];
            vec p = load(eye.p + 3 * at), l = minus(a, p);
            double d2 = dot(l, l);
            solid[t] += (2 * area[t] < 0.01 * d2 ? 0.5 * fabs(dot(n, l)) / (d2 * sqrt(d2))
                                                 : solid_of(l, minus(b, p), minus(e, p))) /
                        samples;
        }
        area_sum += area[t];
        solid_sum += solid[t];
    }
    for (t = 0; t < triangles; t++)
        weight[t] =
            spread == ISM_SPREAD_AREA ? area[t] / area_sum : 0.2 * area[t] / area_sum + 0.8 * solid[t] / solid_sum;
    memset(&d, 0, sizeof d);
    memset(&f, 0, sizeof f);
    d.vpl_count = SAMPLED;
    d.surfel_count = POINTS;
    d.tile_side = 8;
    d.seed = seed;
    d.spread = spread;
    d.window_rim = -1;
    f.mesh = m;
    f.points = view;
    assert_int_equal(ism_create(&d, &maps), ISM_OK);
    assert_int_equal(ism_set_vpls(maps, list, SAMPLED), ISM_OK);
    assert_int_equal(ism_set_vpls(maps, list, SAMPLED - 1), ISM_OK);   /* the last has points of the view alone */
    assert_int_equal(ism_scatter(maps, &f), ISM_OK);
    for (v = 0; v < SAMPLED; v++) {
        const int pair = spread == ISM_SPREAD_PAIR, used = v < SAMPLED - 1;
        double seen = 0, sum = 0;
        const uint32_t key = ism__hash_combine(seed, 0x9000u + v);
        size_t count, j;
        for (c = 0; c < clusters; c++) {
            const size_t end = (c + 1) * size < triangles ? (c + 1) * size : triangles;
            double a = 0, square = 0, facing2 = 0, d2, away;
            vec mean = v3(0, 0, 0), n = load(list[v].normal), l;
            for (t = c * size; t < end; t++) {
                vec g = times(along(along(corner_of(m, t, 0), corner_of(m, t, 1), 1), corner_of(m, t, 2), 1), 1.0 / 3);
                a += area[t];
                mean = along(mean, g, area[t]);
            }
            mean = times(mean, 1 / a);
            l = list[v].directional ? n : minus(mean, load(list[v].position));
            for (t = c * size; t < end; t++) {
                vec o[3], g,
                    q = cross(minus(corner_of(m, t, 1), corner_of(m, t, 0)),
                              minus(corner_of(m, t, 2), corner_of(m, t, 0)));
                for (k = 0; k < 3; k++) o[k] = minus(corner_of(m, t, k), mean);
                g = times(along(along(o[0], o[1], 1), o[2], 1), 1.0 / 3);
                square += area[t] * (9 * dot(g, g) + dot(o[0], o[0]) + dot(o[1], o[1]) + dot(o[2], o[2])) / 12 / a;
                if (area[t] > 0) facing2 += area[t] / a * pow(dot(unit(q), l), 2);
            }
            if (list[v].directional) effect[c] = a * sqrt(facing2);
            else {
                d2 = dot(l, l) + square + 0.16 * a;
                away = dot(l, n) + sqrt(square);
                effect[c] = away > 0 ? a * sqrt(facing2 + square + 0.16 * a) * away / (d2 * d2) : 0;
            }
            seen += effect[c];
        }
        for (c = 0; c < clusters; c++) {
            const size_t end = (c + 1) * size < triangles ? (c + 1) * size : triangles;
            double p = 0, q;
            for (t = c * size; t < end; t++) p += weight[t];
            q = used ? effect[c] / seen : p;
            shares[c] = pair ? sqrt(p * q) + 0.05 * (p + q) : p;
            sum += shares[c];
        }
        assert_int_equal(ism_surfels(maps, v, points, POINTS, &count), ISM_OK);
        assert_int_equal(count, POINTS);
        for (j = 0; j < count; j++) {
            double x = ((double)j + unit_of(ism__hash_combine(key, (uint32_t)j))) / POINTS * sum, before = 0, inside,
                   p = 0;
            double b1 = unit_of(key + (uint32_t)j * 3242174889u),
                   b2 = unit_of(ism__hash32(key) + (uint32_t)j * 2447445413u);
            size_t end;
            for (c = 0; c + 1 < clusters && x >= before + shares[c]; c++) before += shares[c];
            end = (c + 1) * size < triangles ? (c + 1) * size : triangles;
            for (t = c * size; t < end; t++) p += weight[t];
            inside = (x - before) / shares[c] * p;
            if (fabs(x - before) < 1e-4 * shares[c] || fabs(x - before - shares[c]) < 1e-4 * shares[c]) continue;
            for (t = c * size; t + 1 < end && inside >= weight[t]; t++) inside -= weight[t];
            if (size > 1 && (inside < 1e-3 * p || inside > weight[t] - 1e-3 * p)) continue;
            sure++;
            assert_int_equal(points[j].triangle, t);
            if (!near_to((double)points[j].area * POINTS * shares[c] / sum * weight[t] / p, 1, 2e-4))
                fail_msg("VPL %d, point %d: area %g", (int)v, (int)j,
                         (double)points[j].area * POINTS * shares[c] / sum * weight[t] / p);
            if (b2 > b1) { b1 *= 0.5; b2 -= b1; }
            else { b2 *= 0.5; b1 -= b2; }
            assert_true(fabs((double)points[j].barycentric[0] - b1) < 2e-5 &&
                        fabs((double)points[j].barycentric[1] - b2) < 2e-5);
        }
    }
    assert_true(sure > SAMPLED * POINTS * 8 / 10);
    ism_free(maps);
}

/* A box in a room; then a wavy sheet of 70,000 triangles, three to a cluster. */
static void points_follow_view_and_vpl(void **state)
{
    const float lo[3] = { -3, -1, -3 }, hi[3] = { 3, 2, 3 }, blo[3] = { 0.3f, 0.2f, -0.5f },
                bhi[3] = { 0.9f, 1.1f, 0.4f };
    enum { SHEET = 187 };
    static float sheet[3 * (SHEET + 1) * (SHEET + 1)];
    static uint32_t indices[6 * SHEET * SHEET];
    ism_points view;
    ism_mesh m;
    int i, c, spread;
    (void)state;
    make_list();
    list[2] = list[4];                           /* a sky's among the first */
    view = view_of_list();
    mesh.triangles = 0;
    soup_box(&mesh, lo, hi, -1, 3);
    soup_box(&mesh, blo, bhi, 1, 2);
    m = soup_mesh(&mesh);
    for (spread = ISM_SPREAD_AREA; spread < ISM_SPREAD_COUNT; spread++)
        points_are_drawn(&m, &view, mesh.triangles, (ism_spread)spread);
    for (i = 0; i < (SHEET + 1) * (SHEET + 1); i++) {
        double x = (double)(i % (SHEET + 1)) / SHEET, z = (double)(i / (SHEET + 1)) / SHEET;
        store(sheet + 3 * i, v3(4 * x - 2, 0.5 * sin(9 * x) * cos(7 * z) - 0.3, 3 * z - 1));
    }
    for (i = 0; i < SHEET * SHEET; i++) {
        static const uint32_t order[6] = { 0, 1, SHEET + 2, 0, SHEET + 2, SHEET + 1 };
        for (c = 0; c < 6; c++) indices[6 * i + c] = (uint32_t)(i / SHEET * (SHEET + 1) + i % SHEET) + order[c];
    }
    memset(&m, 0, sizeof m);
    m.positions = sheet;
    m.vertex_count = (SHEET + 1) * (SHEET + 1);
    m.indices = indices;
    m.index_count = 6 * SHEET * SHEET;
    points_are_drawn(&m, &view, 2 * SHEET * SHEET, ISM_SPREAD_PAIR);
}

/* ---- maps ---- */

enum { TILE = 16, DRAWN = 6, WINDOWS = 40 };

typedef struct surfel { double g[3], t; uint32_t triangle; } surfel;

typedef struct tile {
    vec frame[3], direction[TILE * TILE];
    const ism_vpl *v;
    ism_projection p;
    surfel at[TILE * TILE];
    uint32_t window;
} tile;

/* A corner of the room, so that windows are small. */
static ism_points view_of_corner(void)
{
    static grid corner;
    const float a[3] = { 1.5f, 1.4f, -2.5f }, u[3] = { 1, 0.2f, 0 }, v[3] = { 0, 0.2f, 2 }, down[3] = { 0, -1, 0 };
    int i;
    grid_fill(&corner, 8, 8, a, u, v, down, 0);
    for (i = 0; i < 64; i += 2) corner.n[3 * i + 1] = 1;        /* a sky lights these */
    return grid_view(&corner);
}

/* Where u of an axis lies in the tile, in texels. */
static double texels_of(const tile *t, double u, double v, int axis)
{
    float uv[2], at[2];
    uv[0] = (float)u;
    uv[1] = (float)v;
    ism_zoom(t->window, TILE, TILE / 8, uv, at);
    return t->window ? (double)at[axis] * TILE : axis ? v * TILE : u * TILE;
}

static vec local(const tile *t, vec v) { return v3(dot(t->frame[0], v), dot(t->frame[1], v), dot(t->frame[2], v)); }

static void open_tile(tile *t, const ism_vpl *v, ism_projection p, uint32_t window)
{
    ism__v3 x, y;
    int i;
    memset(t, 0, sizeof *t);
    t->v = v;
    t->window = window;
    t->p = p == ISM_PROJECTION_LOBE && v->exponent >= 1 && v->exponent <= 1 ? ISM_PROJECTION_COSINE : p;
    t->frame[2] = load(t->p == ISM_PROJECTION_LOBE && !v->directional ? v->axis : v->normal);
    ism__v3_basis(ism__v3_make((float)t->frame[2].x, (float)t->frame[2].y, (float)t->frame[2].z), &x, &y);
    t->frame[0] = v3((double)x.x, (double)x.y, (double)x.z);
    t->frame[1] = v3((double)y.x, (double)y.y, (double)y.z);
    for (i = 0; i < TILE * TILE; i++) {
        float uv[2], d[3];
        uv[0] = ((float)(i % TILE) + 0.5f) / TILE;
        uv[1] = ((float)(i / TILE) + 0.5f) / TILE;
        ism_unzoom(window, TILE, TILE / 8, uv, uv);
        ism_map_direction(t->p, v->exponent, uv, d);
        t->direction[i] = v->directional ? v3(2 * (double)uv[0] - 1, 2 * (double)uv[1] - 1, 1) : load(d);
        t->at[i].t = 1e30;
    }
}

static double depth_at(const tile *t, const surfel *s, int i)
{
    double d = s->g[0] * t->direction[i].x + s->g[1] * t->direction[i].y + s->g[2] * t->direction[i].z;
    if (t->v->directional) return fmax(0, d);
    return d > 1e-20 ? 1 / d : 0;
}

/* One disc: where its plane lies before what is there, inside its radius and, where it stands for less than its
   triangle, inside that. */
static void draw_brute(tile *t, const ism_mesh *m, const ism_surfel *point, vec centre, double radius)
{
    vec a = corner_of(m, point->triangle, 0), e1 = minus(corner_of(m, point->triangle, 1), a),
        e2 = minus(corner_of(m, point->triangle, 2), a), n = cross(e1, e2), p, l, ln, d1, d2, at;
    double b1 = (double)point->barycentric[0], b2 = (double)point->barycentric[1],
           area = 0.5 * length(n) * (double)point->area;
    double r2, depth, reach, per_unit, u, v, back;
    int cut = point->area < 1, i, x, y;
    surfel s;
    p = along(along(a, e1, b1), e2, b2);
    d1 = local(t, times(cross(e2, n), 1 / dot(n, n)));
    d2 = local(t, times(cross(n, e1), 1 / dot(n, n)));
    ln = local(t, unit(n));
    r2 = area * (cut ? 6 : 1) / UTIL_PI;
    s.triangle = point->triangle;
    if (t->v->directional) {
        double slope = fabs(ln.z) > 0.05 ? 1 / ln.z : 0;
        l = local(t, minus(p, centre));
        depth = l.z + radius;
        u = 0.5 * l.x / radius + 0.5;
        v = 0.5 * l.y / radius + 0.5;
        at = v3(l.x, l.y, depth);
        s.g[0] = -ln.x * slope * radius;
        s.g[1] = -ln.y * slope * radius;
        s.g[2] = depth + (ln.x * l.x + ln.y * l.y) * slope;
        if (u < 0 || v < 0 || u >= 1 || v >= 1) return;
        reach = sqrt(r2) * 0.5 * TILE / radius;
    } else {
        float uv[2], d[3];
        vec g;
        l = local(t, minus(p, load(t->v->position)));
        depth = length(l);
        if (!(l.z > 1e-3 * depth)) return;
        if (t->p == ISM_PROJECTION_LOBE &&
            !(fabs(dot(minus(p, load(t->v->position)), load(t->v->normal))) > 1e-3 * depth)) return;
        back = dot(ln, l);
        r2 = fmin(r2, (back > 0 && !cut ? 0.04 : 1) * depth * depth);
        store(d, times(l, 1 / depth));
        assert_true(ism_map_coordinates(t->p, t->v->exponent, d, uv));
        u = (double)uv[0];
        v = (double)uv[1];
        g = fabs(back) > 1e-3 * depth ? times(ln, 1 / back) : times(l, 1 / (depth * depth));
        at = l;
        if (!cut) {                              /* a radius farther away, as large to the VPL */
            double away = 1 + sqrt(r2) / depth;
            at = times(l, away);
            g = times(g, 1 / away);
            r2 *= away * away;
            depth *= away;
        }
        s.g[0] = g.x;
        s.g[1] = g.y;
        s.g[2] = g.z;
        per_unit = t->p == ISM_PROJECTION_PARABOLOID ? 0.5 * TILE
                 : t->p == ISM_PROJECTION_LOBE ? 0.9 * TILE * sqrt(0.5 * ((double)t->v->exponent + 1)) : 0.9 * TILE;
        reach = fmin(TILE, sqrt(r2) * per_unit / depth);
    }
    for (y = 0; y < TILE; y++)
        for (x = 0; x < TILE; x++) {
            double where;
            vec q;
            i = y * TILE + x;
            if (x < floor(texels_of(t, u - reach / TILE, v, 0)) || x > texels_of(t, u + reach / TILE, v, 0) ||
                y < floor(texels_of(t, u, v - reach / TILE, 1)) || y > texels_of(t, u, v + reach / TILE, 1))
                continue;
            where = depth_at(t, &s, i);
            if (!(where > 0 && where < t->at[i].t)) continue;
            q = t->v->directional ? v3(t->direction[i].x * radius, t->direction[i].y * radius, where)
                                  : times(t->direction[i], where);
            q = minus(q, at);
            if (dot(q, q) > r2) continue;
            if (cut) {
                double c1 = b1 + dot(q, d1), c2 = b2 + dot(q, d2);
                if (c1 < -1e-4 || c2 < -1e-4 || c1 + c2 > 1 + 1e-4) continue;
            }
            s.t = where;
            t->at[i] = s;
        }
}

static int quadrant(int dx, int dy)
{
    return dx > 0 && dy >= 0 ? 1 : dx <= 0 && dy > 0 ? 2 : dx < 0 && dy <= 0 ? 4 : 8;
}

/* Of eight sectors, the first about the x axis. */
static int sector(int dx, int dy)
{
    const double turn = atan2((double)dy, (double)dx) / 0.78539816339744831;
    return 1 << ((int)floor(turn + 8.5) % 8);
}

/* No three sectors in a row are empty; those beyond the border are not, if their neighbours inside are not, or of what
   the first level found the neighbours' neighbours. */
static int surrounded(int found, int close, int beyond)
{
    int k, row = 0, counts = 1;
    for (k = 0; k < 8; k++) {
        const int left = 1 << (k + 7) % 8, right = 1 << (k + 1) % 8;
        if (beyond & 1 << k || !(beyond & (left | right))) continue;
        counts &= (found & 1 << k || close & (left | right)) != 0;
    }
    for (k = 0; k < 10; k++) {
        row = (found | (counts ? beyond : 0)) & 1 << k % 8 ? 0 : row + 1;
        if (row == 3) return 0;
    }
    return 1;
}

/* Holes that nearer planes of all four quadrants pass before are emptied; then the empty texels, by the nearest surfels
   of three levels of cells, each of which keeps the one nearest to its middle. */
static void fill_brute(tile *t)
{
    static uint8_t hole[TILE * TILE];
    static int cell[4][TILE * TILE];
    static double filled[TILE * TILE];
    static uint32_t of[TILE * TILE];
    int i, x, y, level, k;
    for (i = 0; i < TILE * TILE; i++) {
        int found = 0;
        hole[i] = 0;
        for (y = i / TILE - 2; y <= i / TILE + 2; y++)
            for (x = i % TILE - 2; x <= i % TILE + 2; x++) {
                const int q = quadrant(x - i % TILE, y - i / TILE), j = y * TILE + x;
                if (x < 0 || y < 0 || x >= TILE || y >= TILE) found |= q;
                else if (j != i && t->at[j].t < 0.9 * t->at[i].t && depth_at(t, &t->at[j], i) > 0.5 * t->at[j].t &&
                         depth_at(t, &t->at[j], i) < 0.95 * t->at[i].t)
                    found |= q;
            }
        hole[i] = t->at[i].t < 1e29 && found == 15;
    }
    for (i = 0; i < TILE * TILE; i++)
        if (hole[i]) t->at[i].t = 1e30;
    for (i = 0; i < TILE * TILE; i++) cell[0][i] = t->at[i].t < 1e29 ? i : -1;
    for (level = 1; level <= 3; level++)
        for (y = 0; y < TILE >> level; y++)
            for (x = 0; x < TILE >> level; x++) {
                double least = 1e9, middle = 0.5 * (1 << level);
                int best = -1;
                for (k = 0; k < 4; k++) {
                    int from = cell[level - 1][(2 * y + (k >> 1)) * (TILE >> (level - 1)) + 2 * x + (k & 1)];
                    double dx = from % TILE + 0.5 - (x << level) - middle,
                           dy = from / TILE + 0.5 - (y << level) - middle;
                    if (from < 0 || dx * dx + dy * dy >= least) continue;
                    least = dx * dx + dy * dy;
                    best = from;
                }
                cell[level][y * (TILE >> level) + x] = best;
            }
    for (i = 0; i < TILE * TILE; i++) {
        int found = 0, close = 0, beyond = 0, first = -1, second = -1, d1 = 0, d2 = 0;
        filled[i] = 0;
        for (level = 1; level <= 3 && t->at[i].t > 1e29; level++) {
            int side = TILE >> level, cx = i % TILE >> level, cy = i / TILE >> level;
            if (second >= 0 && surrounded(found, close, beyond)) break;
            for (y = cy - 1; y <= cy + 1; y++)
                for (x = cx - 1; x <= cx + 1; x++) {
                    int at = x < 0 || y < 0 || x >= side || y >= side ? -2 : cell[level][y * side + x], dx, dy;
                    if (at == -2) beyond |= sector(x - cx, y - cy);
                    if (at < 0) continue;
                    dx = at % TILE - i % TILE;
                    dy = at / TILE - i / TILE;
                    found |= sector(dx, dy);
                    if (at == first || (second == at && dx * dx + dy * dy >= d1)) continue;
                    if (first < 0 || dx * dx + dy * dy < d1) {
                        second = first;
                        d2 = d1;
                        first = at;
                        d1 = dx * dx + dy * dy;
                    } else if (second < 0 || dx * dx + dy * dy < d2) {
                        second = at;
                        d2 = dx * dx + dy * dy;
                    }
                }
            if (level == 1) close = found;
        }
        if (second >= 0 && surrounded(found, close, beyond)) {
            const surfel *a = &t->at[first], *b = &t->at[second];
            double flat = fabs(a->t - b->t), tilted = fabs(depth_at(t, a, second) - b->t), here = depth_at(t, a, i);
            filled[i] = flat > tilted && here > 0.5 * a->t && here < 2 * a->t ? here : a->t;
            of[i] = a->triangle;
        }
    }
    for (i = 0; i < TILE * TILE; i++)
        if (filled[i] > 0) {
            t->at[i].t = filled[i];
            t->at[i].triangle = of[i];
        }
}

static void make_rocks(void)
{
    const float lo[3] = { -3, -2, -3 }, hi[3] = { 3, 2, 3 }, blo[3] = { 0.3f, 0.4f, -0.5f },
                bhi[3] = { 0.9f, 1.1f, 0.4f };
    int i, k;
    mesh.triangles = 0;
    soup_box(&mesh, lo, hi, -1, 2);
    soup_box(&mesh, blo, bhi, 1, 5);
    state_of_random = 77;
    for (i = 0; i < 60; i++, mesh.triangles++) {
        vec at = along(v3(0, 0.6, 0), any3(1.5, 0.8, 1.5), 1);
        for (k = 0; k < 3; k++) store(mesh.p + 9 * mesh.triangles + 3 * k, along(at, any3(1, 1, 1), 0.25));
    }
}

static void every_disc_is_drawn(void **state)
{
    static ism_surfel points[1024];
    static tile t;
    ism_points view;
    ism_mesh m;
    int projection, fill;
    size_t wrong = 0, all = 0, known = 0, windows = 0;
    (void)state;
    make_list();
    list[3].directional = 1;
    store(list[3].normal, unit(v3(0.2, -0.9, 0.3)));
    view = view_of_list();
    make_rocks();
    m = soup_mesh(&mesh);
    for (projection = ISM_PROJECTION_COSINE; projection < ISM_PROJECTION_COUNT; projection++)
        for (fill = 0; fill < 4; fill++) {
            ism_desc d;
            ism_maps *maps;
            ism_frame f;
            const float *atlas;
            float centre[3], radius;
            uint32_t side, tiles, v, i;
            memset(&d, 0, sizeof d);
            memset(&f, 0, sizeof f);
            d.vpl_count = DRAWN;
            d.surfel_count = 400;
            d.splat_scale = 1;
            d.tile_side = TILE;
            d.no_fill = !(fill & 1);
            d.keep_hits = fill < 2;             /* then even, else with windows */
            view = d.keep_hits ? view_of_list() : view_of_corner();
            d.projection = (ism_projection)projection;
            f.mesh = &m;
            f.points = &view;
            assert_int_equal(ism_create(&d, &maps), ISM_OK);
            assert_int_equal(ism_set_vpls(maps, list, DRAWN), ISM_OK);
            assert_int_equal(ism_build(maps, &f), ISM_OK);
            atlas = ism_atlas(maps, &side, &tiles);
            assert_true(side == TILE * tiles && tiles == 3);
            util_bounds(maps, centre, &radius);
            assert_true(near_to((double)radius, sqrt(9 + 4 + 9) * 1.001, 1e-4) && fabsf(centre[1]) < 1e-5f);
            for (v = 0; v < DRAWN; v++) {
                size_t count, j;
                open_tile(&t, &list[v], (ism_projection)projection, ism_vpls(maps, &count)[v].window);
                windows += t.window != 0;
                assert_true(t.window == 0 || !d.keep_hits);
                assert_int_equal(ism_surfels(maps, v, points, 1024, &count), ISM_OK);
                for (j = 0; j < count; j++) draw_brute(&t, &m, &points[j], load(centre), (double)radius);
                if (fill & 1) fill_brute(&t);
                for (i = 0; i < TILE * TILE; i++) {
                    const size_t at = (v / tiles * TILE + i / TILE) * side + v % tiles * TILE + i % TILE;
                    const int there = t.at[i].t < 1e29;
                    const uint32_t expected = there ? t.at[i].triangle : UINT32_MAX;
                    const uint32_t hit = d.keep_hits ? ((const uint32_t *)maps->hits.data)[at] : expected;
                    all++;
                    known += there != 0;
                    wrong +=
                        hit != expected || (there ? !near_to((double)atlas[at], t.at[i].t, 1e-3) : atlas[at] < ISM_FAR);
                }
            }
            ism_free(maps);
        }
    /* rims of discs that pass within 1e-6 of a texel's centre, and what is filled from them */
    if (wrong > all / 500) fail_msg("%d of %d texels", (int)wrong, (int)all);
    assert_true(known > all / 2);
    assert_int_equal(windows, WINDOWS);
}

/* ---- visibility and bounces by the same maps ---- */

static int lit_brute(const tile *t, const float *atlas, uint32_t side, vec p, vec n, double bias, vec centre,
                     double radius, int *sure)
{
    vec l = local(t, minus(p, t->v->directional ? centre : load(t->v->position))), ln = local(t, n);
    double depth, d = length(l), there, cosine;
    float uv[2], w[3];
    int i;
    if (t->v->directional) {
        double u = (0.5 * l.x / radius + 0.5) * TILE, v = (0.5 * l.y / radius + 0.5) * TILE, dx, dy;
        if (ln.z >= -1e-4) return 0;
        if (u < 0 || v < 0 || u >= TILE || v >= TILE) return 1;
        cosine = texels_of(t, u / TILE, v / TILE, 0);
        v = texels_of(t, u / TILE, v / TILE, 1);
        u = cosine;
        if (fabs(u - floor(u + 0.5)) < 1e-3 || fabs(v - floor(v + 0.5)) < 1e-3) *sure = 0;
        i = (int)v * TILE + (int)u;
        dx = t->direction[i].x * radius - l.x;
        dy = t->direction[i].y * radius - l.y;
        depth = l.z + radius - (fabs(ln.z) > 0.1 ? (ln.x * dx + ln.y * dy) / ln.z : 0) - bias * radius;
    } else {
        if (l.z <= 0) return 1;
        if (dot(ln, l) >= -1e-4 * d) return 0;
        store(w, times(l, 1 / d));
        if (!ism_map_coordinates(t->p, t->v->exponent, w, uv)) return 1;
        ism_zoom(t->window, TILE, TILE / 8, uv, uv);
        if (fabs((double)uv[0] * TILE - floor((double)uv[0] * TILE + 0.5)) < 1e-3 ||
            fabs((double)uv[1] * TILE - floor((double)uv[1] * TILE + 0.5)) < 1e-3) *sure = 0;
        i = (int)fmin(TILE - 1, (double)uv[1] * TILE) * TILE + (int)fmin(TILE - 1, (double)uv[0] * TILE);
        cosine = dot(ln, t->direction[i]);
        depth = dot(ln, l) / cosine;
        if (!(depth > 0.5 * d && depth < 2 * d)) depth = d;
        depth *= 1 - bias;
    }
    there = (double)atlas[(uint32_t)(i / TILE) * side + (uint32_t)(i % TILE)];
    if (fabs(depth - there) < 1e-4 * depth) *sure = 0;
    return depth <= there;
}

static void receivers_are_compared_on_their_plane(void **state)
{
    static tile t;
    static float p[3 * 500], n[3 * 500], visible[500];
    ism_points view;
    ism_mesh m;
    int projection, even, i;
    size_t compared = 0, dark = 0, windows = 0;
    (void)state;
    make_list();
    list[3].directional = 1;
    store(list[3].normal, unit(v3(0.2, -0.9, 0.3)));
    view = view_of_corner();
    make_rocks();
    m = soup_mesh(&mesh);
    state_of_random = 5;
    for (i = 0; i < 500; i++) {
        store(p + 3 * i, i % 3 ? any3(2.9, 1.9, 2.9) : along(v3(0, 2, 0), any3(2.9, 0, 2.9), 1));
        store(n + 3 * i, i % 3 ? unit(any3(1, 1, 1)) : v3(0, -1, 0));
    }
    for (even = 0; even < 2; even++)
    for (projection = ISM_PROJECTION_COSINE; projection < ISM_PROJECTION_COUNT; projection++) {
        ism_desc d;
        ism_maps *maps;
        ism_frame f;
        const float *atlas;
        float centre[3], radius;
        uint32_t side, tiles, v;
        memset(&d, 0, sizeof d);
        memset(&f, 0, sizeof f);
        d.vpl_count = DRAWN;
        d.surfel_count = 2000;
        d.tile_side = TILE;
        d.projection = (ism_projection)projection;
        d.window_rim = even ? -1 : 0;
        f.mesh = &m;
        f.points = &view;
        assert_int_equal(ism_create(&d, &maps), ISM_OK);
        assert_int_equal(ism_set_vpls(maps, list, DRAWN), ISM_OK);
        assert_int_equal(ism_build(maps, &f), ISM_OK);
        atlas = ism_atlas(maps, &side, &tiles);
        util_bounds(maps, centre, &radius);
        for (v = 0; v < DRAWN; v++) {
            open_tile(&t, &list[v], (ism_projection)projection, ism_vpls(maps, NULL)[v].window);
            windows += t.window != 0;
            assert_int_equal(util_visible(maps, v, p, n, 500, 0.03f, visible), ISM_OK);
            for (i = 0; i < 500; i++) {
                int sure = 1,
                    expected = lit_brute(&t, atlas + v / tiles * TILE * side + v % tiles * TILE, side, load(p + 3 * i),
                                         load(n + 3 * i), (double)0.03f, load(centre), (double)radius, &sure);
                if (!sure) continue;
                compared++;
                dark += expected == 0;
                if ((visible[i] > 0) != expected)
                    fail_msg("projection %d, VPL %d, receiver %d: %g", projection, (int)v, i, (double)visible[i]);
            }
        }
        ism_free(maps);
    }
    assert_true(compared > 20000 && dark > 6000 && dark < compared - 2000);
    assert_int_equal(windows, WINDOWS / 2);
}

/* A pVPL of the next bounce lies where its texel's depth is, its normal is its triangle's towards the VPL, and the
   fluxes of a tile are the VPL's shared by the light that leaves through each cell. */
static void texels_bounce_the_light_of_their_cells(void **state)
{
    enum { SIDE = 8 };
    static float p[3 * DRAWN * SIDE * SIDE], n[3 * DRAWN * SIDE * SIDE], flux[3 * DRAWN * SIDE * SIDE],
        albedo[3 * 4096];
    static tile t;
    ism_points view;
    ism_mesh m;
    int projection, c;
    size_t i, lit_texels = 0;
    (void)state;
    make_list();
    view = view_of_list();
    make_rocks();
    m = soup_mesh(&mesh);
    for (i = 0; i < 3 * mesh.triangles; i++) albedo[i] = 0.1f + 0.002f * (float)i;
    for (projection = ISM_PROJECTION_COSINE; projection < ISM_PROJECTION_COUNT; projection++) {
        ism_desc d;
        ism_maps *maps;
        ism_frame f;
        const float *atlas;
        uint32_t side, tiles, v, k;
        memset(&d, 0, sizeof d);
        memset(&f, 0, sizeof f);
        d.vpl_count = DRAWN;
        d.surfel_count = 400;
        d.tile_side = TILE;
        d.keep_hits = 1;
        d.projection = (ism_projection)projection;
        f.mesh = &m;
        f.points = &view;
        m.albedos = projection % 2 ? albedo : NULL;
        assert_int_equal(ism_create(&d, &maps), ISM_OK);
        assert_int_equal(ism_set_vpls(maps, list, DRAWN - 1), ISM_OK);
        assert_int_equal(ism_build(maps, &f), ISM_OK);
        memset(flux, 0x55, sizeof flux);
        assert_int_equal(ism_bounce(maps, &m, SIDE, p, n, flux), ISM_OK);
        atlas = ism_atlas(maps, &side, &tiles);
        for (v = 0; v < DRAWN; v++) {
            double share[SIDE * SIDE], sum = 0;
            if (v < DRAWN - 1) open_tile(&t, &list[v], (ism_projection)projection, 0);
            for (k = 0; k < SIDE * SIDE;
                 k++) { /* cos^e x solid angle of the middle texel, by a square of half its side */
                const uint32_t x = k % SIDE * 2 + 1, y = k / SIDE * 2 + 1;
                float uv[2], a[4][3];
                share[k] = 1;
                if (t.p != ISM_PROJECTION_COSINE && t.p != ISM_PROJECTION_LOBE) {
                    for (c = 0; c < 4; c++) {
                        uv[0] = ((float)x + (c == 1 || c == 2 ? 0.75f : 0.25f)) / TILE;
                        uv[1] = ((float)y + (c >= 2 ? 0.75f : 0.25f)) / TILE;
                        ism_map_direction(t.p, t.v->exponent, uv, a[c]);
                    }
                    share[k] = length(cross(minus(load(a[2]), load(a[0])), minus(load(a[3]), load(a[1]))));
                    share[k] *= a[0][2] > 0 ? pow((double)a[0][2], (double)t.v->exponent) : 0;
                }
                sum += share[k];
            }
            for (k = 0; k < SIDE * SIDE; k++) {
                const uint32_t x = k % SIDE * 2 + 1, y = k / SIDE * 2 + 1;
                const size_t at = (v / tiles * TILE + y) * side + v % tiles * TILE + x,
                             o = 3 * (size_t)(v * SIDE * SIDE + k);
                const uint32_t hit = ((const uint32_t *)maps->hits.data)[at];
                vec w, normal, e1, e2;
                if (v == DRAWN - 1 || hit == UINT32_MAX || list[v].directional || !(t.direction[y * TILE + x].z > 0)) {
                    for (c = 0; c < 3; c++) assert_true(!(flux[o + (size_t)c] > 0) && !(flux[o + (size_t)c] < 0));
                    continue;
                }
                lit_texels++;
                w = t.direction[y * TILE + x];
                w = along(along(times(t.frame[0], w.x), t.frame[1], w.y), t.frame[2], w.z);
                assert_true(length(minus(load(p + o), along(load(list[v].position), w, (double)atlas[at]))) <
                            1e-4 * (1 + (double)atlas[at]));
                e1 = minus(corner_of(&m, hit, 1), corner_of(&m, hit, 0));
                e2 = minus(corner_of(&m, hit, 2), corner_of(&m, hit, 0));
                normal = unit(cross(e1, e2));
                if (fabs(dot(normal, w)) > 1e-4)
                    assert_true(length(minus(load(n + o), dot(normal, w) > 0 ? times(normal, -1) : normal)) < 1e-4);
                for (c = 0; c < 3; c++) {
                    double a = m.albedos ? (double)albedo[3 * hit + (uint32_t)c] : 0.5;
                    assert_true(
                        near_to((double)flux[o + (size_t)c], (double)list[v].flux[c] * a * share[k] / sum, 1e-3));
                }
            }
        }
        ism_free(maps);
    }
    assert_true(lit_texels > 500);
}

/* ---- sources ---- */

static void points_on_lamps_have_equal_power(void **state)
{
    enum { N = 500 };
    static float radiance[3 * 4096], p[3 * N], n[3 * N], flux[3 * N];
    double power[4096], total = 0;
    ism_mesh m;
    size_t i, t, sure = 0;
    int c;
    (void)state;
    make_rocks();
    m = soup_mesh(&mesh);
    for (t = 0; t < mesh.triangles; t++) {
        store(radiance + 3 * t, t % 4 ? v3(0.01 * (double)t, 1, 0.5) : v3(0, 0, 0));
        power[t] = mean3(radiance + 3 * t) * 0.5 *
                   length(cross(minus(corner_of(&m, t, 1), corner_of(&m, t, 0)),
                                minus(corner_of(&m, t, 2), corner_of(&m, t, 0))));
        total += power[t];
    }
    assert_int_equal(ism_emitter_points(&m, radiance, N, 3, NULL, p, n, flux), ISM_OK);
    for (i = 0; i < N; i++) {
        double x = ((double)i + 0.5) / N * total, b1, b2;
        const uint32_t key = ism__hash_combine(3, 21u);
        vec e1, e2, at;
        for (t = 0; x >= power[t]; t++) x -= power[t];
        if (x < 1e-5 * total || power[t] - x < 1e-5 * total) continue;
        sure++;
        b1 = unit_of(key + (uint32_t)i * 3242174889u);
        b2 = unit_of(ism__hash32(key) + (uint32_t)i * 2447445413u);
        if (b2 > b1) { b1 *= 0.5; b2 -= b1; }
        else { b2 *= 0.5; b1 -= b2; }
        at = corner_of(&m, t, 0);
        e1 = minus(corner_of(&m, t, 1), at);
        e2 = minus(corner_of(&m, t, 2), at);
        assert_true(length(minus(load(p + 3 * i), along(along(at, e1, b1), e2, b2))) < 1e-5);
        assert_true(length(minus(load(n + 3 * i), unit(cross(e1, e2)))) < 1e-5);
        for (c = 0; c < 3; c++)                  /* each has the mean power of all, in its triangle's colour */
            assert_true(near_to((double)flux[3 * i + (size_t)c],
                                UTIL_PI * total / N * (double)radiance[3 * t + (size_t)c] / mean3(radiance + 3 * t),
                                1e-4));
    }
    assert_true(sure > N * 9 / 10);
}

static void sky_texels_are_directions(void **state)
{
    enum { A = 10, B = 6 };
    static float texels[3 * A * B], d[3 * A * B], flux[3 * A * B];
    uint64_t bad;
    int i, c;
    (void)state;
    state_of_random = 8;
    for (i = 0; i < 3 * A * B; i++) texels[i] = (float)(1 + any());
    texels[3] = -1;
    texels[10] = ism__from_bits(0x7f800000u);
    texels[11] = ism__from_bits(0x7fc00000u);
    assert_int_equal(ism_sky_directions(texels, A, B, 0.7f, d, flux, &bad), ISM_OK);
    assert_int_equal(bad, 2);
    for (i = 0; i < A * B; i++) {
        double theta = UTIL_PI * (i / A + 0.5) / B, phi = 2 * UTIL_PI * ((i % A + 0.5) / A - 0.5) - (double)0.7f;
        double solid = 2 * UTIL_PI / A * (cos(UTIL_PI * (i / A) / B) - cos(UTIL_PI * (i / A + 1) / B));
        assert_true(length(minus(load(d + 3 * i), v3(sin(theta) * cos(phi), cos(theta), sin(theta) * sin(phi)))) <
                    1e-6);
        for (c = 0; c < 3; c++) {
            int spoilt = 3 * i + c == 3 || 3 * i + c == 10 || 3 * i + c == 11;
            assert_true(near_to((double)flux[3 * i + c], spoilt ? 0 : (double)texels[3 * i + c] * solid, 1e-5));
        }
    }
}

/* Rows next to the poles of maps that exist: their solid angles are differences of cosines that floats do not tell
   apart. Rotations of clocks that have run for long. */
static void skies_are_exact_at_poles_and_after_many_turns(void **state)
{
    static const uint32_t heights[] = { 1, 2, 3, 2048, 8192, 16384 };
    static float texels[3 * 16384], d[3 * 16384], flux[3 * 16384], other[3 * 16384];
    double worst = 0, aslant = 0;
    uint32_t k, y;
    int i, turns;
    (void)state;
    for (i = 0; i < 3 * 16384; i++) texels[i] = 1;
    for (k = 0; k < 6; k++) {
        const uint32_t h = heights[k];
        double sum = 0;
        assert_int_equal(ism_sky_directions(texels, 1, h, 0, d, flux, NULL), ISM_OK);
        for (y = 0; y < h; y++) {
            double theta = UTIL_PI * (y + 0.5) / h;
            double solid = 4 * UTIL_PI * sin(theta) * sin(0.5 * UTIL_PI / h);
            worst = fmax(worst, fabs((double)flux[3 * y] / solid - 1));
            aslant = fmax(aslant, fabs((double)d[3 * y + 1] - cos(theta)));
            aslant = fmax(aslant, fabs(hypot((double)d[3 * y], (double)d[3 * y + 2]) / sin(theta) - 1));
            sum += (double)flux[3 * y];
        }
        assert_true(fabs(sum / (4 * UTIL_PI) - 1) < 1e-6);
    }
    if (worst > 1e-6) fail_msg("solid angle off by %g", worst);
    if (aslant > 1e-6) fail_msg("direction off by %g", aslant);
    assert_int_equal(ism_sky_directions(texels, 16, 8, 0.7f, d, flux, NULL), ISM_OK);
    for (turns = -3; turns <= 3; turns++) {
        const double angle = 0.7 + 2 * UTIL_PI * 5000 * turns * turns * turns;
        const float rotation = (float)angle;
        assert_int_equal(ism_sky_directions(texels, 16, 8, rotation, other, flux, NULL), ISM_OK);
        for (i = 0; i < 16 * 8; i++) {           /* what the float has lost of the angle is no fault of the map's */
            double phi = 2 * UTIL_PI * ((i % 16 + 0.5) / 16 - 0.5) - (double)rotation;
            double theta = UTIL_PI * (i / 16 + 0.5) / 8;
            assert_true(length(minus(load(other + 3 * i),
                                     v3(sin(theta) * cos(phi), cos(theta), sin(theta) * sin(phi)))) < 1e-6);
        }
    }
    assert_int_equal(ism_sky_directions(texels, 16, 8, 3e38f, other, flux, NULL), ISM_OK);
    for (i = 0; i < 16 * 8; i++) assert_true(fabs(length(load(other + 3 * i)) - 1) < 1e-6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(squares_reach_to_their_neighbours), cmocka_unit_test(every_light_is_summed),
        cmocka_unit_test(patterns_share_out_all_the_light), cmocka_unit_test(patterns_share_out_near_points),
        cmocka_unit_test(importances_are_effects), cmocka_unit_test(vpls_are_drawn_by_importance),
        cmocka_unit_test(guided_grids_see_what_is_near), cmocka_unit_test(points_follow_view_and_vpl),
        cmocka_unit_test(every_disc_is_drawn), cmocka_unit_test(receivers_are_compared_on_their_plane),
        cmocka_unit_test(texels_bounce_the_light_of_their_cells), cmocka_unit_test(points_on_lamps_have_equal_power),
        cmocka_unit_test(sky_texels_are_directions), cmocka_unit_test(skies_are_exact_at_poles_and_after_many_turns)
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
