/* sums_test - the filter beside brute force in double: passes tap by tap, frames pixel by pixel. */

#include "gifilter.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "util.h"

static uint32_t state_of_random;

static double any(void)                          /* -1..1 */
{
    state_of_random = state_of_random * 1664525u + 1013904223u;
    return (double)(state_of_random >> 8) / 8388608.0 - 1;
}

static double dot3(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

enum { W = 45, H = 29, N = W * H };

static float at[3 * N], facing[3 * N];

/* A floor with a ramp, a round pillar, a step, and holes in the picture. */
static void make_picture(void)
{
    int x, y;
    for (y = 0; y < H; y++)
        for (x = 0; x < W; x++) {
            double u = (x + 0.5) / W * 3 - 1.5, v = (y + 0.5) / H * 2 - 1, h = 0.2, nx = 0, nz = 0, l;
            float *p = at + 3 * (y * W + x), *n = facing + 3 * (y * W + x);
            if (u > 0.8) h = 0.6;
            if (u < -0.5) {
                h += 0.4 * (-0.5 - u);
                nx = 0.4;
            }
            if (hypot(u - 0.2, v) < 0.3) {
                h += 0.3 - hypot(u - 0.2, v);
                nx = (u - 0.2) / hypot(u - 0.2, v);
                nz = v / hypot(u - 0.2, v);
            }
            l = sqrt(nx * nx + 1 + nz * nz);
            set3(p, u, h, v);
            set3(n, nx / l, 1 / l, nz / l);
            if (x == 16 && y == 8) set3(n, 0, 0, 0);
            if (x > 30 && x < 34 && y > 20) set3(n, 0, 0, 0);
        }
    at[3 * (3 * W + 11)] = INFINITY;
}

typedef struct seen { double p[3], n[3], rgb[3], frames; } seen;

static double alike(const seen *a, const seen *b, double cosine, double slope)
{
    double d[3], d2, off, c;
    int k;
    for (k = 0; k < 3; k++) d[k] = b->p[k] - a->p[k];
    d2 = dot3(d, d);
    off = dot3(d, a->n);
    c = fmin(1, fmax(0, (dot3(a->n, b->n) - cosine) / (1 - cosine)));
    return c * fmax(0, 1 - off * off / (slope * slope * d2 + 1e-12));
}

static void smooth_brute(seen *picture, int passes, double cosine, double slope)
{
    static seen next[N];
    int pass, x, y, i, j, c;
    for (pass = 0; pass < passes; pass++) {
        int step = 1 << pass;
        memcpy(next, picture, sizeof next);
        for (y = 0; y < H; y++)
            for (x = 0; x < W; x++) {
                double total = 4, sum[3], most[3] = { 0, 0, 0 };
                const seen *me = picture + y * W + x;
                for (c = 0; c < 3; c++) sum[c] = 4 * me->rgb[c];
                for (j = -step; j <= step; j += step)
                    for (i = -step; i <= step; i += step) {
                        const seen *it = picture + (y + j) * W + x + i;
                        double w = i && j ? 1 : 2;
                        if ((!i && !j) || x + i < 0 || y + j < 0 || x + i >= W || y + j >= H) continue;
                        w *= alike(me, it, cosine, slope);
                        total += w;
                        for (c = 0; c < 3; c++) {
                            sum[c] += w * it->rgb[c];
                            most[c] = fmax(most[c], it->rgb[c]);
                        }
                    }
                for (c = 0; c < 3; c++) {
                    double value = sum[c] / total;
                    if (total < 8 && most[c] > 0) value = fmin(value, most[c]);
                    next[y * W + x].rgb[c] = value;
                }
            }
        memcpy(picture, next, sizeof next);
    }
}

/* What the last frame saw of a pixel, bilinear over the four about the place x, y; frames 0: nothing. */
static void recall_brute(const seen *last, seen *me, double x, double y, double far2, int motion, double history)
{
    double total = 0, rgb[3] = { 0, 0, 0 }, frames = 0;
    int i, j, c;
    if (fabs(x - 0.5 - floor(x)) < 1.0 / 64) x = floor(x) + 0.5;       /* a pixel's centre is meant */
    if (fabs(y - 0.5 - floor(y)) < 1.0 / 64) y = floor(y) + 0.5;
    for (j = (int)floor(y - 0.5); j <= (int)floor(y - 0.5) + 1; j++)
        for (i = (int)floor(x - 0.5); i <= (int)floor(x - 0.5) + 1; i++) {
            double w = (1 - fabs(x - 0.5 - i)) * (1 - fabs(y - 0.5 - j)), d[3];
            const seen *it = last + j * W + i;
            if (i < 0 || j < 0 || i >= W || j >= H || !(it->frames > 0)) continue;
            for (c = 0; c < 3; c++) d[c] = it->p[c] - me->p[c];
            if (dot3(d, d) > far2) continue;
            w *= motion ? dot3(me->n, it->n) > 0.5 : alike(me, it, 0.9, 0.1);
            total += w;
            frames += w * it->frames;
            for (c = 0; c < 3; c++) rgb[c] += w * it->rgb[c];
        }
    if (!(total > 0.01)) return;
    me->frames = fmin(history, frames / total + 1);
    for (c = 0; c < 3; c++) me->rgb[c] = rgb[c] / total + (me->rgb[c] - rgb[c] / total) / me->frames;
}

static void look(seen *picture, const float *light)
{
    int i, c;
    for (i = 0; i < N; i++) {
        seen *s = picture + i;
        memset(s, 0, sizeof *s);
        for (c = 0; c < 3; c++) s->n[c] = (double)facing[3 * i + c];
        if (!(dot3(s->n, s->n) > 0) || i == 3 * W + 11) {
            memset(s, 0, sizeof *s);
            continue;
        }
        s->frames = 1;
        for (c = 0; c < 3; c++) {
            s->p[c] = (double)at[3 * i + c];
            s->rgb[c] = light[3 * i + c] < 1e30f ? (double)light[3 * i + c] : 0;
        }
    }
}

static void filter_is(const seen *picture, const float *out, const char *what, int frame)
{
    int i, c;
    for (i = 0; i < N; i++)
        for (c = 0; c < 3; c++)
            if (!(fabs((double)out[3 * i + c] - picture[i].rgb[c]) < 2e-4))
                fail_msg("%s, frame %d, pixel %d %d: %g, not %g", what, frame, i % W, i / W, (double)out[3 * i + c],
                         picture[i].rgb[c]);
}

static void noise_into(float *light)
{
    int i;
    for (i = 0; i < 3 * N; i++) light[i] = (float)(0.5 + 0.5 * any());
    light[3 * 100 + 1] = INFINITY;       /* counts as dark, as does what sums of neighbours could not hold */
    light[3 * 200 + 2] = 2e38f;
}

static void passes_are_taps(void **state)
{
    static float light[3 * N], out[3 * N];
    static seen picture[N];
    gifilt_points p = points_of(at, facing, N);
    int passes;
    (void)state;
    make_picture();
    state_of_random = 5;
    for (passes = 0; passes <= 6; passes++) {
        gifilt_filter *filter;
        gifilt_frame f;
        memset(&f, 0, sizeof f);
        f.passes = passes ? passes : -1;
        if (passes % 2) {
            f.normal_cosine = 0.7f;
            f.plane_slope = 0.5f;
        }
        noise_into(light);
        look(picture, light);
        smooth_brute(picture, passes, passes % 2 ? 0.7 : 0.9, passes % 2 ? 0.5 : 0.1);
        assert_int_equal(create(W, H, NULL, &filter), GIFILT_OK);
        assert_int_equal(gifilt_apply(filter, &f, &p, light, out), GIFILT_OK);
        filter_is(picture, out, "passes", passes);
        gifilt_free(filter);
    }
}

static double clip_of(const float m[16], const double p[3], int row)
{
    return (double)m[row] * p[0] + (double)m[4 + row] * p[1] + (double)m[8 + row] * p[2] + (double)m[12 + row];
}

/* A camera that looks down and moves, by a matrix with perspective; or by motion. */
static void frames_are_reprojected(void **state)
{
    static float light[3 * N], out[3 * N], motion[2 * N];
    static seen now[N], last[N];
    gifilt_points p = points_of(at, facing, N);
    int way, frame, i;
    (void)state;
    make_picture();
    state_of_random = 9;
    for (way = 0; way < 4; way++) {              /* y down, y up, motion, a short history */
        gifilt_filter *filter;
        assert_int_equal(create(W, H, NULL, &filter), GIFILT_OK);
        memset(last, 0, sizeof last);
        for (frame = 0; frame < 5; frame++) {
            static float before[16];
            float m[16] = { 0 };
            gifilt_frame f;
            memset(&f, 0, sizeof f);
            m[0] = 0.6667f * 2;                  /* mostly x / w, z / w, w = 2 - y */
            m[1] = 0.03f;
            m[3] = 0.02f;
            m[4] = 0.05f;
            m[5] = -0.04f;
            m[8] = 0.06f;
            m[11] = -0.03f;
            m[12] = 0.02f * (float)frame;
            m[9] = way == 1 ? 2.0f : -2.0f;
            m[13] = 0.013f * (float)frame;
            m[7] = -1;
            m[15] = 2;
            f.world_to_clip = m;
            f.rows = way != 1 ? GIFILT_ROWS_TOP_FIRST : GIFILT_ROWS_DEFAULT;
            f.history = way == 3 ? 3 : 0;
            f.passes = -1;
            if (way == 2) f.motion = motion;
            noise_into(light);
            look(now, light);
            for (i = 0; i < N; i++) {
                const int other = i % W + 1 < W ? i + 1 : i - 1;
                double x, y, w, d[3], far2;
                int c;
                motion[2 * i] = (float)(i % W + 0.5 + 0.7 * any());
                motion[2 * i + 1] = (float)(i / W + 0.5 + 1.4 * any());
                if (!frame && way != 2) continue;
                if (!(now[i].frames > 0)) continue;
                for (c = 0; c < 3; c++) d[c] = (double)at[3 * other + c] - (double)at[3 * i + c];
                far2 = dot3(d, d) < 1e18 ? 16 * dot3(d, d) + 1e-12 : 1e-12;
                w = clip_of(before, now[i].p, 3);
                x = clip_of(before, now[i].p, 0) / w;
                y = clip_of(before, now[i].p, 1) / w;
                x = (0.5 + 0.5 * x) * W;
                y = (way == 1 ? 0.5 + 0.5 * y : 0.5 - 0.5 * y) * H;
                if (way == 2) recall_brute(last, &now[i], (double)motion[2 * i], (double)motion[2 * i + 1], 1e30, 1, 8);
                else recall_brute(last, &now[i], x, y, far2, 0, way == 3 ? 3 : 8);
            }
            assert_int_equal(gifilt_apply(filter, &f, &p, light, out), GIFILT_OK);
            filter_is(now, out, way == 0 ? "y down" : way == 1 ? "y up" : way == 2 ? "motion" : "history of 3", frame);
            memcpy(last, now, sizeof last);
            memcpy(before, m, sizeof before);
        }
        gifilt_free(filter);
    }
}

/* A bright pixel: on a floor the filter spreads it; where no neighbour is like it, it must not stay. Widths that are no
   multiple of eight and pictures smaller than a step have the same borders as others. */
static void no_lone_spike_is_left(void **state)
{
    static float light[3 * N], out[3 * N];
    const size_t lone = 12 * W + 20, flat = 20 * W + 9;
    gifilt_points p = points_of(at, facing, N), small = points_of(at, facing, 5 * 3);
    gifilt_filter *filter;
    gifilt_frame f;
    double sum = 0;
    size_t i;
    (void)state;
    for (i = 0; i < N; i++) {
        set3(at + 3 * i, (double)(i % W) * 0.1, 0, (double)(i / W) * 0.1);
        set3(facing + 3 * i, 0, 1, 0);
    }
    for (i = 0; i < 3 * N; i++) light[i] = 1;
    for (i = 0; i < 3; i++) light[3 * lone + i] = light[3 * flat + i] = 16;
    set3(facing + 3 * lone, 1, 0, 0);
    memset(&f, 0, sizeof f);
    f.passes = 2;
    assert_int_equal(create(W, H, NULL, &filter), GIFILT_OK);
    assert_int_equal(gifilt_apply(filter, &f, &p, light, out), GIFILT_OK);
    gifilt_free(filter);
    assert_true(out[3 * lone] == 1);
    for (i = 0; i < N; i++) sum += (double)out[3 * i];
    assert_true(fabs(sum - (N + 15)) < 0.01);
    assert_int_equal(create(5, 3, NULL, &filter), GIFILT_OK);
    for (f.passes = -1; f.passes <= 6; f.passes++) {
        for (i = 0; i < 3 * 5 * 3; i++) light[i] = 2;
        assert_int_equal(gifilt_apply(filter, &f, &small, light, light), GIFILT_OK);
        for (i = 0; i < 3 * 5 * 3; i++) assert_true(light[i] == 2);
    }
    gifilt_free(filter);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(passes_are_taps),
        cmocka_unit_test(frames_are_reprojected),
        cmocka_unit_test(no_lone_spike_is_left),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
