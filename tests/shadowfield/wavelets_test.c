/* wavelets_test - what scenes of wavelets leave out, which must be nothing that shows, and which wavelets a field
   keeps. */
#define SFIELD_STATIC
#define SHADOWFIELD_IMPLEMENTATION
#include "shadowfield.h"
#include "util.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

enum { SIDE = 16 };

static sfield_field *ball;

static int make_ball(void **state)
{
    model m = model_sphere(32, 16, 1);
    sfield_mesh mesh = mesh_of(&m);
    sfield_desc d;
    (void)state;
    memset(&d, 0, sizeof d);
    d.basis = SFIELD_BASIS_HAAR;
    d.shell_count = 12;
    d.position_side = 7;
    d.cube_side = SIDE;
    d.keep = 0.1f;
    d.outer = 12;
    assert_int_equal(sfield_build(&d, &mesh, &ball, NULL), SFIELD_OK);
    model_free(&m);
    return 0;
}

static int free_ball(void **state)
{
    (void)state;
    sfield_free(ball);
    return 0;
}

/* Light of a sky of 1 at the origin, looking up, past balls at the places given. */
static float light_past(const float places[][3], size_t count, sfield_scene_stats *stats)
{
    static const float p[3] = { 0, 0, 0 }, up[3] = { 0, 1, 0 }, one[3] = { 1, 1, 1 };
    sfield_scene_desc d;
    sfield_entity e[4];
    sfield_points set;
    sfield_scene *s;
    float rgb[3];
    size_t i;
    int k;
    memset(&d, 0, sizeof d);
    d.basis = SFIELD_BASIS_HAAR;
    d.cube_side = SIDE;
    memset(e, 0, sizeof e);
    for (i = 0; i < count; i++) {
        e[i].occlusion = ball;
        for (k = 0; k < 16; k += 5) e[i].transform[k] = 1;
        for (k = 0; k < 3; k++) e[i].transform[12 + k] = places[i][k], e[i].tint[k] = 1;
    }
    memset(&set, 0, sizeof set);
    set.count = 1;
    set.positions = p;
    set.normals = up;
    set.rgb = rgb;
    assert_int_equal(sfield_scene_create(&d, &s), SFIELD_OK);
    assert_int_equal(sfield_scene_entities(s, e, count), SFIELD_OK);
    assert_int_equal(sfield_scene_environment(s, one, 1, 1, NULL), SFIELD_OK);
    assert_int_equal(sfield_shade(s, &set, 1, stats), SFIELD_OK);
    sfield_scene_free(s);
    return rgb[0];
}

/* Of a ball with its centre on the horizon the upper half hides (a - sin a cos a) / pi of a level point's light, where
   sin a is radius over distance: the integral of sin rho sin rho over its half disc. One that ends below the
   horizon hides nothing. */
static void a_ball_on_the_horizon_hides_by_its_upper_half(void **state)
{
    static const float on[1][3] = { { 1.6f, 0, 0 } }, under[1][3] = { { 1.6f, -1.1f, 0 } };
    double a = asin(1 / 1.6), exact = 1 - (a - sin(a) * cos(a)) / PI;
    sfield_scene_stats stats;
    double got = (double)light_past(on, 1, &stats);
    (void)state;
    print_message("ball on the horizon: %.4f, exactly %.4f\n", got, exact);
    assert_true(stats.culled_horizon == 0 && stats.products == 1);
    assert_true(fabs(got - exact) < 0.02);
    got = (double)light_past(under, 1, &stats);
    assert_true(stats.culled_horizon == 1 && stats.products == 0);
    assert_true(fabs(got - 1) < 0.002);
}

/* Of two balls side by side each hides (r / d)^2 cos: neither is hidden by the other. One behind the other is, and
   changes nothing. */
static void balls_side_by_side_both_hide(void **state)
{
    static const float beside[2][3] = { { 2, 2, 0 }, { -2.5f, 2.5f, 0 } }, behind[2][3] = { { 0, 2, 0 }, { 0, 6, 0 } };
    double exact = 1 - (1 / 8.0 + 1 / 12.5) * sqrt(0.5);
    sfield_scene_stats stats;
    double got = (double)light_past(beside, 2, &stats);
    (void)state;
    print_message("two balls: %.4f, exactly %.4f\n", got, exact);
    assert_true(stats.culled_hidden == 0 && stats.products == 2);
    assert_true(fabs(got - exact) < 0.02);
    assert_true(light_past(behind, 2, &stats) == light_past(behind, 1, NULL));
    assert_true(stats.culled_hidden == 1);
}

/* A field keeps the wavelets of the greatest height times area: one of a whole face, of coefficient 1, comes before one
   of the finest squares, of 6, since that one's square is 8 times smaller each way. */
static void wavelets_are_kept_by_area(void **state)
{
    enum { N = 16, CELLS = 6 * N * N };
    static float texel[CELLS], haar[CELLS], key[2 * CELLS];
    uint32_t entry[3], kept, coarse[3], i;
    sfield__build b;
    sfield__view v;
    float scale;
    (void)state;
    memset(&b, 0, sizeof b);
    memset(&v, 0, sizeof v);
    b.h.cube_side = N;
    b.h.channels = b.h.stride = 1;
    b.cells = CELLS;
    b.most = 3;
    for (i = 0; i < 3; i++) {
        coarse[i] = 2 * i * N * N + 1;                  /* of faces 0, 2 and 4 */
        haar[coarse[i]] = 1;
        haar[(2 * i + 1) * N * N + N * N / 4 + i] = -6; /* the finest three quarters of faces 1, 3 and 5 */
    }
    assert_int_equal(sfield_haar_inverse(N, haar, texel), SFIELD_OK);
    v.texel = texel;
    v.haar = haar;
    v.key = key;
    sfield__encode_haar(&b, &v, &kept, &scale, entry);
    assert_int_equal(kept, 3);
    for (i = 0; i < 3; i++) assert_int_equal(entry[i] >> 16, coarse[i]);
}

/* The lazy cache keeps 256 wavelets by the same measure: those of whole faces come before the finest of 6 times their
   coefficient, of which there are more than it has room for, on whichever face they are. What it gives back is within
   half a step of 16 bits. */
static void the_cache_keeps_wavelets_by_area(void **state)
{
    enum { CELLS = 6 * SIDE * SIDE, FACE = SIDE * SIDE };
    static float haar[CELLS], work[CELLS], coefs[3 * CELLS];
    sfield_scene_desc d;
    sfield_scene *s;
    sfield_cache *c;
    sfield__point p;
    uint32_t i, coarse = 0;
    (void)state;
    memset(&d, 0, sizeof d);
    d.basis = SFIELD_BASIS_HAAR;
    d.cube_side = SIDE;
    assert_int_equal(sfield_scene_create(&d, &s), SFIELD_OK);
    assert_int_equal(sfield_cache_create(s, 1, 1, &c), SFIELD_OK);
    memset(&p, 0, sizeof p);
    p.s = s;
    p.haar = haar;
    p.work = work;
    p.coefs = coefs;
    for (i = 0; i < CELLS; i++) haar[i] = i % FACE < 4 ? 1.0f : i % FACE >= FACE / 4 ? -6.0f : 0.0f;
    sfield__keep_wavelets(&p, c, 0);
    for (i = 0; i < SFIELD__CACHED; i++) {
        const uint32_t in_face = c->index[i] % FACE;
        const float exact = in_face < 4 ? 1.0f : -6.0f;
        assert_true(i == 0 || c->index[i] > c->index[i - 1]);
        assert_true(in_face < 4 || in_face >= FACE / 4);
        assert_true(fabsf((float)c->value[i] * c->scale[0] - exact) <= 0.51f * 6 / 32767);
        coarse += in_face < 4;
    }
    assert_int_equal(coarse, 24);
    for (i = 0; i < 3 * CELLS; i++) assert_true(coefs[i] == 0); /* as the next point finds it */
    sfield_cache_free(c);
    sfield_scene_free(s);
}

/* Trowbridge and Reitz's distribution with Smith's shadowing, as appendix B of glTF 2.0 writes them, in doubles. Half
   vectors of shallow lights and shallow eyes are short; only what lies across the normal says how far off they are. */
static void shallow_eyes_keep_their_digits(void **state)
{
    static const float rough[3] = { 0.3f, 0.6f, 1 };
    double worst = 0;
    uint64_t seed = 3;
    (void)state;
    for (int i = 0; i < 30000; i++) {
        const float up[3] = { 0, 0, 1 }, z = rnd_in(&seed, 0.02, 0.2), y = rnd_in(&seed, 0.02, 0.2);
        const float phi = rnd_in(&seed, 2.8, 3.5), alpha = rough[i % 3] * rough[i % 3];
        const float v[3] = { sqrtf(1 - z * z), 0, z };
        const float l[3] = { sqrtf(1 - y * y) * cosf(phi), sqrtf(1 - y * y) * sinf(phi), y };
        float material[5] = { 1, 1, 1, 1, 0 }, out[3] = { 0, 0, 0 };
        double h[3], hh = 0, a2, d, truth;
        sfield__lobe lobe;
        sfield_points set;
        memset(&set, 0, sizeof set);
        material[4] = rough[i % 3];
        set.materials = material;
        sfield__read_lobe(&set, 0, up, v, &lobe);
        sfield__add_response(&lobe, l, out);
        for (int k = 0; k < 3; k++) {
            h[k] = (double)l[k] + (double)v[k];
            hh += h[k] * h[k];
        }
        a2 = (double)alpha * (double)alpha;
        d = a2 / (PI * pow((h[0] * h[0] + h[1] * h[1] + a2 * h[2] * h[2]) / hh, 2));
        truth = (double)l[2] * d * 0.5 / ((double)l[2] * sqrt(a2 + (1 - a2) * (double)v[2] * (double)v[2]) +
                                           (double)v[2] * sqrt(a2 + (1 - a2) * (double)l[2] * (double)l[2]));
        worst = fmax(worst, fabs((double)out[1] + (double)out[2] - truth) / truth);
    }
    printf("shallow: off by %.2g of the response at most\n", worst);
    assert_true(worst < 2e-5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shallow_eyes_keep_their_digits),
        cmocka_unit_test(a_ball_on_the_horizon_hides_by_its_upper_half),
        cmocka_unit_test(balls_side_by_side_both_hide),
        cmocka_unit_test(wavelets_are_kept_by_area),
        cmocka_unit_test(the_cache_keeps_wavelets_by_area),
    };
    return cmocka_run_group_tests(tests, make_ball, free_ball);
}
