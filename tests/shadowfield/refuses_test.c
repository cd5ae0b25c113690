/* refuses_test - every argument of every function of shadowfield.h that can be wrong, one at a time, the others
   right; and what is at the edge and allowed. */
#include "shadowfield.h"
#include "util.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

/* An entity of no fields that stands at the origin, not tinted. */
static const sfield_entity upright = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };

#define IS(call, result) assert_int_equal(call, SFIELD_##result)
#define REFUSED(call) IS(call, ERR_ARGUMENT)

static const float even[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };

static sfield_system half_allocator(void)
{
    sfield_system half = { 0 };
    half.allocator.alloc_fn = counting_alloc;
    return half;
}

static void the_algebra_refuses_bad_arguments(void **state)
{
    static float v[3 * 6 * 64], out[3 * 6 * 64];
    sfield_system half = half_allocator();
    sfield_algebra *t;
    sfield_rotation r, bad;
    double d[64];
    float factors[SFIELD_MAX_BANDS], dir[3] = { 0, 0, 1 };
    uint32_t k;
    (void)state;
    IS(sfield_algebra_create(2, NULL, &t), OK);
    REFUSED(sfield_sh_product(t, 1, NULL, v, out, 1));
    REFUSED(sfield_sh_product(t, 1, v, NULL, out, 1));
    REFUSED(sfield_sh_product(t, 1, v, v, NULL, 1));
    REFUSED(sfield_sh_dot(0, 1, v, v, out, 1));
    REFUSED(sfield_sh_dot(2, 1, v, NULL, out, 1));
    REFUSED(sfield_sh_dot(2, 1, v, v, NULL, 1));
    REFUSED(sfield_sh_dot(2, 2, v, v, out, 1));
    REFUSED(sfield_sh_rotation(NULL, even, &r));
    REFUSED(sfield_sh_rotation(t, even, NULL));
    IS(sfield_sh_rotation(t, even, &r), OK);
    REFUSED(sfield_sh_rotate(&r, 1, NULL, out, 1));
    REFUSED(sfield_sh_rotate(&r, 1, v, NULL, 1));
    REFUSED(sfield_sh_rotate(&r, 2, v, out, 1));
    for (k = 0; k <= 9; k += 9) {
        bad = r;
        bad.bands = k;
        REFUSED(sfield_sh_rotate(&bad, 1, v, out, 1));
        REFUSED(sfield_sh_product_n(k, 1, v, NULL, d));
        REFUSED(sfield_sh_project(k, 8, v, 1, out));
        REFUSED(sfield_cube_basis(k, 8, 0, out));
        assert_true(sfield_sh_window_fit(k, v, 0) == 0);
    }
    REFUSED(sfield_sh_product_n(2, 1, NULL, NULL, d));
    REFUSED(sfield_sh_product_n(2, 1, v, NULL, NULL));
    IS(sfield_sh_product_n(2, 1, v, &half, d), ERR_DESC);
    REFUSED(sfield_sh_log(NULL, v, out));
    REFUSED(sfield_sh_log(t, v, NULL));
    REFUSED(sfield_sh_exp(NULL, 1, v, out, 1));
    REFUSED(sfield_sh_exp(t, 1, v, NULL, 1));
    REFUSED(sfield_sh_exp(t, 2, v, out, 1));
    sfield_sh_window(99, 1, factors);           /* no more than there is room for */
    assert_true(factors[7] < factors[6] && factors[0] == 1);
    sfield_sh_cosine(99, factors);
    assert_true(factors[7] == 0 && factors[6] > 0);
    assert_true(sfield_cube_texel(8, 0, NULL) == 0 && sfield_cube_texel(128, 0, dir) == 0);
    assert_true(sfield_cube_find(7, dir) == 0 && sfield_cube_find(8, NULL) == 0 && sfield_cube_find(8, dir) != 0);
    REFUSED(sfield_sh_project(2, 8, NULL, 1, out));
    REFUSED(sfield_sh_project(2, 8, v, 1, NULL));
    REFUSED(sfield_sh_project(2, 8, v, 0, out));
    REFUSED(sfield_sh_project(2, 8, v, 4, out));
    IS(sfield_sh_project(2, 8, v, 3, out), OK);
    REFUSED(sfield_haar_forward(8, NULL, out));
    REFUSED(sfield_haar_forward(8, v, NULL));
    REFUSED(sfield_haar_forward(8, v, v));
    REFUSED(sfield_haar_inverse(8, NULL, out));
    REFUSED(sfield_haar_inverse(8, v, NULL));
    REFUSED(sfield_haar_inverse(9, v, out));
    REFUSED(sfield_haar_product(9, v, v, out));
    REFUSED(sfield_haar_product(8, NULL, v, out));
    REFUSED(sfield_haar_product(8, v, NULL, out));
    REFUSED(sfield_haar_product(8, v, v, NULL));
    REFUSED(sfield_haar_product(8, out, v, out));
    REFUSED(sfield_haar_product(8, v, out, out));
    sfield_algebra_free(t);
}

/* The terms, for shaders, make the product; and without room for them their number is told. */
static void terms_make_the_product(void **state)
{
    uint32_t terms[2000], bands, k, i;
    float factors[2000], a[25], b[25], out[25], sum[25];
    uint64_t seed = 9;
    (void)state;
    assert_int_equal(sfield_sh_terms(NULL, terms, factors), 0);
    for (bands = 1; bands <= 5; bands++) {
        sfield_algebra *t;
        uint32_t n = bands * bands;
        size_t count, q;
        IS(sfield_algebra_create(bands, NULL, &t), OK);
        count = sfield_sh_terms(t, NULL, NULL);
        assert_true(count <= 2000 && (bands > 2) == (count > 0));
        assert_int_equal(sfield_sh_terms(t, terms, NULL), count);
        assert_int_equal(sfield_sh_terms(t, NULL, factors), count);
        assert_int_equal(sfield_sh_terms(t, terms, factors), count);
        for (k = 0; k < n; k++) {
            a[k] = rnd_in(&seed, -1, 1);
            b[k] = rnd_in(&seed, -1, 1);
        }
        sum[0] = 0;
        for (k = 0; k < n; k++) sum[0] += 0.282094792f * a[k] * b[k];
        for (k = 1; k < n; k++) sum[k] = 0.282094792f * (a[0] * b[k] + a[k] * b[0]);
        for (q = 0; q < count; q++) {
            uint32_t j = terms[q] >> 8 & 255;
            i = terms[q] & 255;
            k = terms[q] >> 16;
            assert_true(i >= j && j >= 1 && k >= 1 && k < n && (!q || k >= terms[q - 1] >> 16));
            sum[k] += factors[q] * (i == j ? a[i] * b[i] : a[i] * b[j] + a[j] * b[i]);
        }
        IS(sfield_sh_product(t, 1, a, b, out, 1), OK);
        for (k = 0; k < n; k++) assert_true(fabsf(out[k] - sum[k]) <= 1e-5f);
        sfield_algebra_free(t);
    }
}

/* Whole tiles and what is left, and rotations of which only one element of the matrix says that they are any. */
static void dots_and_turns_hold_for_tiles_and_what_is_left(void **state)
{
    enum { N = 37 };
    static const float axes[6][4] = { { 1, 0, 0, 0.5f }, { 0, 1, 0, 0.5f }, { 0, 0, 1, 0.5f }, { 1, 0, 0, 1 },
                                      { 0, 1, 0, 1 }, { 0, 0, 1, 1 } };
    float a[9 * N], b[9 * N], out[N], turned[9 * 32];
    sfield_algebra *t;
    uint64_t seed = 10;
    int i, k, q;
    (void)state;
    IS(sfield_algebra_create(3, NULL, &t), OK);
    for (i = 0; i < 9 * N; i++) {
        a[i] = rnd_in(&seed, -1, 1);
        b[i] = rnd_in(&seed, -1, 1);
    }
    IS(sfield_sh_dot(3, N, a, b, out, N), OK);
    for (i = 0; i < N; i++) {
        double sum = 0;
        for (k = 0; k < 9; k++) sum += (double)a[k * N + i] * (double)b[k * N + i];
        assert_true(fabs(sum - (double)out[i]) <= 1e-5);
    }
    for (q = 0; q < 6; q++) {
        sfield_rotation r;
        float m[16];
        matrix_of(m, (double)axes[q][0], (double)axes[q][1], (double)axes[q][2], PI * (double)axes[q][3], 1, 0, 0, 0);
        for (k = 0; k < 16; k++) m[k] = floorf(m[k] + 0.5f);        /* 0, 1 and -1 alone */
        IS(sfield_sh_rotation(t, m, &r), OK);
        assert_false(r.identity);
        IS(sfield_sh_rotate(&r, 32, a, turned, 32), OK);            /* two tiles, nothing left */
        for (i = 0; i < 32; i++) {
            float before[9], after[9];
            double d[3], e[3];
            for (k = 0; k < 9; k++) {
                before[k] = a[k * 32 + i];
                after[k] = turned[k * 32 + i];
            }
            rnd_direction(&seed, d);
            turn(m, d, e);
            assert_true(fabs(sh_value(3, before, d) - sh_value(3, after, e)) <= 1e-5);
        }
    }
    sfield_algebra_free(t);
}

static void white(void *user, float time, const float position[3], const float direction[3], float rgb[3])
{
    (void)user, (void)time, (void)position, (void)direction;
    rgb[0] = rgb[1] = rgb[2] = 1;
}

static int see_nothing(void *user, const sfield_views *v)
{
    (void)user;
    memset(v->values, 0, v->count * sizeof *v->values);
    return 0;
}

static void building_refuses_bad_arguments(void **state)
{
    sfield_desc d = small_desc(SFIELD_BASIS_SH), bad = small_desc(SFIELD_BASIS_SH), halved = bad;
    model m = model_box(1, 1, 1);
    sfield_mesh mesh = mesh_of(&m);
    sfield_system half = half_allocator();
    const sfield_field *both[2] = { NULL, NULL };
    sfield_field *f, *shard, *none = NULL;
    float radiance[36], p[3] = { 0, 1, 0 }, n[3] = { 0, 1, 0 }, out[64];
    uint8_t bytes[64] = { 0 };
    sfield_info info;
    int i;
    (void)state;
    for (i = 0; i < 36; i++) radiance[i] = 1;
    bad.bands = 9;
    REFUSED(sfield_build_emissive(&d, NULL, radiance, &none, NULL));
    REFUSED(sfield_build_emissive(&d, &mesh, NULL, &none, NULL));
    REFUSED(sfield_build_emissive(&d, &mesh, radiance, NULL, NULL));
    radiance[35] = -1;
    IS(sfield_build_emissive(&d, &mesh, radiance, &none, NULL), ERR_INPUT);
    IS(sfield_build_callback(&bad, white, NULL, &none, NULL), ERR_DESC);
    IS(sfield_build_callback(&d, white, NULL, &none, NULL), ERR_DESC);          /* no radius */
    REFUSED(sfield_build_callback(NULL, white, NULL, &none, NULL));
    REFUSED(sfield_build_callback(&d, white, NULL, NULL, NULL));
    REFUSED(sfield_build_views(&d, 0, &mesh, NULL, NULL, &none, NULL));
    REFUSED(sfield_build_views(&d, 0, &mesh, see_nothing, NULL, NULL, NULL));
    IS(sfield_build_views(&d, 0, NULL, see_nothing, NULL, &none, NULL), ERR_DESC);
    REFUSED(sfield_build_self(&d, NULL, AT(p, n, 1), 0, &none, NULL));
    REFUSED(sfield_build_self(&d, &mesh, AT(p, n, 1), 0, NULL, NULL));
    REFUSED(sfield_build_self(&d, &mesh, AT(NULL, n, 1), 0, &none, NULL));
    REFUSED(sfield_build_self(&d, &mesh, AT(p, NULL, 1), 0, &none, NULL));
    p[2] = 1e19f;
    IS(sfield_build_self(&d, &mesh, AT(p, n, 1), 0, &none, NULL), ERR_INPUT);
    p[2] = 0;
    for (i = 0; i < 6; i++) {
        sfield_emitter e;
        memset(&e, 0, sizeof e);
        e.radius = 1;
        e.kind = i < 3 ? SFIELD_EMITTER_RECTANGLE : SFIELD_EMITTER_SPHERE;
        e.u[0] = e.v[1] = i < 3 ? 1.0f : 0.0f;
        switch (i) {
        case 0: e.u[0] = NAN; break;
        case 1: e.v[2] = INFINITY; break;
        case 2: e.v[0] = 1, e.v[1] = 0; break;                        /* no area */
        case 3: e.normal[2] = 2; break;
        case 4: e.kind = SFIELD_EMITTER_CALLBACK, e.view_fn = white; break;      /* no radius */
        default: e.radiance[2] = NAN; break;
        }
        IS(sfield_build_emitter(&d, &e, &none, NULL), ERR_DESC);
    }
    IS(sfield_build(NULL, &mesh, NULL, NULL), ERR_ARGUMENT);
    IS(sfield_build(&d, &mesh, &f, NULL), OK);
    {
        sfield_emitter e;
        memset(&e, 0, sizeof e);
        e.radius = 1;
        REFUSED(sfield_build_emitter(&d, &e, NULL, NULL));
    }
    REFUSED(sfield_write(NULL, bytes, sizeof bytes));
    IS(sfield_write(f, bytes, sizeof bytes), ERR_MEMORY);
    REFUSED(sfield_open(bytes, sizeof bytes, NULL, NULL));
    halved.system = half;
    IS(sfield_open(bytes, sizeof bytes, &halved.system, &none), ERR_DESC);
    sfield_get_info(f, NULL);
    memset(&info, 99, sizeof info);
    sfield_get_info(NULL, &info);
    REFUSED(sfield_merge(NULL, 1, NULL, &none));
    REFUSED(sfield_merge(both, 0, NULL, &none));
    REFUSED(sfield_merge(both, 2, NULL, NULL));
    REFUSED(sfield_merge(both, 2, NULL, &none));
    both[0] = f;
    IS(sfield_merge(both, 1, &halved.system, &none), ERR_DESC);
    REFUSED(sfield_query(f, 1, NULL, 0, out));
    REFUSED(sfield_query(f, 1, p, 0, NULL));
    REFUSED(sfield_ambient(NULL, 1, p, out));
    REFUSED(sfield_ambient(f, 1, NULL, out));
    REFUSED(sfield_ambient(f, 1, p, NULL));
    REFUSED(sfield_self(NULL, 0, 0, out));
    REFUSED(sfield_self(f, 0, 0, NULL));
    d.shard_end = 2;
    IS(sfield_build(&d, &mesh, &shard, NULL), OK);
    IS(sfield_ambient(shard, 1, p, out), ERR_MISMATCH);
    both[0] = shard;
    REFUSED(sfield_merge(both, 2, NULL, &none));                /* the second is not there */
    assert_null(none);
    sfield_free(shard);
    sfield_free(f);
    model_free(&m);
}

/* More positions than one tile: the same as each alone. */
static void many_positions_equal_each_alone(void **state)
{
    sfield_desc d = small_desc(SFIELD_BASIS_SH);
    float p[3 * 37], open[37], one;
    uint64_t seed = 8;
    sfield_field *f = field_of_sphere(&d);
    int i;
    (void)state;
    for (i = 0; i < 3 * 37; i++) p[i] = rnd_in(&seed, -4, 4);
    IS(sfield_ambient(f, 37, p, open), OK);
    for (i = 0; i < 37; i++) {
        IS(sfield_ambient(f, 1, p + 3 * i, &one), OK);
        assert_true(one == open[i] && one >= 0.4f && one <= 1);
    }
    sfield_free(f);
}

static void scenes_refuse_bad_arguments(void **state)
{
    static float coefs[3 * 16], texels[3 * 6 * 8 * 8];
    sfield_desc d = small_desc(SFIELD_BASIS_SH);
    sfield_scene_desc sd;
    sfield_scene *sh, *haar, *sparse, *logs;
    sfield_field *f, *wavelets, *self, *self_haar;
    sfield_entity e = upright, turned = e;
    sfield_points good, set;
    sfield_cache *cache;
    model m = model_box(1, 1, 1);
    sfield_mesh mesh = mesh_of(&m);
    float p[6] = { 0, 1, 0, 1, 1, 0 }, n[6] = { 0, 1, 0, 0, 1, 0 }, rgb[6], sky[3] = { 1, 1, 1 }, dir[3] = { 0, 1, 0 };
    int i;
    (void)state;
    IS(sfield_build(&d, &mesh, &f, NULL), OK);
    IS(sfield_build_self(&d, &mesh, AT(p, n, 2), 1e-3f, &self, NULL), OK);
    d.basis = SFIELD_BASIS_HAAR;
    IS(sfield_build(&d, &mesh, &wavelets, NULL), OK);
    IS(sfield_build_self(&d, &mesh, AT(p, n, 2), 1e-3f, &self_haar, NULL), OK);
    memset(&sd, 0, sizeof sd);
    IS(sfield_scene_create(&sd, &sh), OK);
    sd.product = SFIELD_PRODUCT_EXP;
    IS(sfield_scene_create(&sd, &logs), OK);
    sd.basis = SFIELD_BASIS_HAAR;
    sd.product = SFIELD_PRODUCT_DEFAULT;
    sd.cube_side = 16;
    IS(sfield_scene_create(&sd, &haar), OK);
    e.occlusion = wavelets;                     /* of 8 */
    IS(sfield_scene_entities(haar, &e, 1), ERR_MISMATCH);
    e.occlusion = f;
    IS(sfield_scene_entities(haar, &e, 1), ERR_MISMATCH);
    IS(sfield_scene_entities(logs, &e, 1), ERR_MISMATCH);            /* not of logarithms */
    sfield_scene_free(haar);
    sd.cube_side = 8;
    IS(sfield_scene_create(&sd, &haar), OK);
    sd.product = SFIELD_PRODUCT_SPARSE;
    IS(sfield_scene_create(&sd, &sparse), OK);
    REFUSED(sfield_scene_entities(NULL, &e, 1));
    REFUSED(sfield_scene_environment(NULL, sky, 1, 1, NULL));
    REFUSED(sfield_scene_environment(sh, sky, 1, 0, NULL));
    REFUSED(sfield_scene_environment(sh, sky, 65537, 1, NULL));
    REFUSED(sfield_scene_environment(sh, sky, 1, 65537, NULL));
    REFUSED(sfield_scene_turn(NULL, even));
    REFUSED(sfield_scene_turn(sh, NULL));
    REFUSED(sfield_scene_sun(NULL, dir, sky));
    REFUSED(sfield_scene_sun(sh, dir, NULL));
    dir[0] = 2;
    IS(sfield_scene_sun(sh, dir, sky), ERR_INPUT);
    dir[0] = 0;
    sky[1] = -1;
    IS(sfield_scene_sun(sh, dir, sky), ERR_INPUT);
    sky[1] = 1;
    REFUSED(sfield_scene_sky(NULL, coefs));
    REFUSED(sfield_scene_sky(sh, NULL));
    REFUSED(sfield_scene_sky(haar, NULL));
    IS(sfield_scene_environment(haar, sky, 1, 1, NULL), OK);
    IS(sfield_scene_sky(haar, texels), OK);
    assert_true(fabsf(texels[0] - 1) < 1e-5f && fabsf(texels[3 * 6 * 64 - 1] - 1) < 1e-5f);
    IS(sfield_scene_environment(haar, NULL, 0, 0, NULL), OK);
    IS(sfield_scene_environment(sh, sky, 1, 1, NULL), OK);
    IS(sfield_scene_sky(sh, coefs), OK);
    assert_true(fabsf(coefs[32] - 3.5449077f) < 1e-5f && fabsf(coefs[33]) < 1e-6f);
    REFUSED(sfield_cache_create(NULL, 1, 1, &cache));
    REFUSED(sfield_cache_create(sh, 1, 1, NULL));
    REFUSED(sfield_cache_create(sh, 1, 0, &cache));
    REFUSED(sfield_cache_create(sh, 1, 65537, &cache));
    REFUSED(sfield_cache_create(sh, (size_t)0x7fffffff + 1, 1, &cache));
    assert_int_equal(sfield_cache_bytes(NULL), 0);

    e.occlusion = NULL;
    matrix_of(turned.transform, 0, 1, 0, 1, 1, 0, 0, 0);
    IS(sfield_scene_entities(sh, &e, 1), OK);
    IS(sfield_scene_entities(haar, &e, 1), OK);
    IS(sfield_scene_entities(logs, &e, 1), OK);
    IS(sfield_scene_entities(sparse, &turned, 1), OK);            /* no field: it only receives */
    turned.occlusion = wavelets;
    IS(sfield_scene_entities(sparse, &turned, 1), ERR_MISMATCH);
    IS(sfield_scene_entities(sparse, &e, 1), OK);
    memset(&good, 0, sizeof good);
    good.count = 2;
    good.positions = p;
    good.normals = n;
    good.entity = 1;
    good.rgb = rgb;
    IS(sfield_shade(sh, &good, 1, NULL), OK);
    IS(sfield_shade(sh, NULL, 0, NULL), OK);
    REFUSED(sfield_shade(sh, NULL, 1, NULL));
    for (i = 0; i < 11; i++) {
        sfield_result expected = SFIELD_ERR_ARGUMENT;
        set = good;
        switch (i) {
        case 0: set.positions = NULL; break;
        case 1: set.normals = NULL; break;
        case 2: set.count = (size_t)0x7fffffff + 1; expected = SFIELD_ERR_LIMIT; break;
        case 3: set.normal_stride = 6; break;
        case 4: set.to_eye_stride = 2; break;
        case 5: set.exponent_stride = 1; break;
        case 6: set.position_stride = 4; break;                       /* vectors that run into each other */
        case 7: set.position_stride = 14; break;
        case 8: set.normal_stride = 8; break;
        case 9: set.to_eye = n; set.to_eye_stride = 4; break;
        default: set.entity = 7; expected = SFIELD_ERR_INPUT; break;
        }
        assert_int_equal(sfield_shade(sh, &set, 1, NULL), expected);
        assert_int_equal(sfield_incident(sh, &set, coefs), expected);
    }
    set = good;
    set.to_eye_stride = 4;                        /* of no views */
    IS(sfield_shade(sh, &set, 1, NULL), OK);
    set.count = 0;
    set.positions = NULL;
    IS(sfield_shade(sh, &set, 1, NULL), OK);
    set = good;
    set.gloss = rgb;
    rgb[0] = rgb[5] = 1;
    IS(sfield_shade(haar, &set, 1, NULL), OK);                   /* no exponents: black */
    assert_true(rgb[0] == 0 && rgb[5] == 0);
    rgb[0] = rgb[5] = 1;
    IS(sfield_shade(sh, &set, 1, NULL), OK);
    assert_true(rgb[0] == 0 && rgb[5] == 0);
    set = good;
    set.self = self;
    IS(sfield_shade(sh, &set, 1, NULL), OK);
    IS(sfield_shade(haar, &set, 1, NULL), ERR_MISMATCH);
    set.count = 1;
    IS(sfield_shade(sh, &set, 1, NULL), ERR_MISMATCH);
    set = good;
    set.self = self_haar;
    IS(sfield_shade(sh, &set, 1, NULL), ERR_MISMATCH);
    IS(sfield_shade(sparse, &set, 1, NULL), OK);
    IS(sfield_shade(haar, &set, 1, NULL), OK);
    set = good;
    IS(sfield_cache_create(haar, 2, 1, &set.cache), OK);
    IS(sfield_shade(sh, &set, 1, NULL), ERR_MISMATCH);
    sfield_cache_free(set.cache);
    REFUSED(sfield_incident(NULL, &good, coefs));
    REFUSED(sfield_incident(sh, NULL, coefs));
    IS(sfield_incident(haar, &good, coefs), ERR_MISMATCH);
    IS(sfield_incident(logs, &good, coefs), ERR_MISMATCH);
    sfield_scene_free(sh);
    sfield_scene_free(logs);
    sfield_scene_free(haar);
    sfield_scene_free(sparse);
    sfield_free(f);
    sfield_free(wavelets);
    sfield_free(self);
    sfield_free(self_haar);
    model_free(&m);
}

/* Places whose squares pass what a float holds: the weights of the same places times a power of two. */
static void sparse_points_far_apart_have_the_same_weights(void **state)
{
    const float n[9] = { 0, 1, 0, 0, 1, 0, 0, 1, 0 };
    float w[2][9];
    uint32_t chosen[3], from[2][9], i, k;
    size_t count;
    (void)state;
    for (i = 0; i < 2; i++) {
        const float s = (float)ldexp(1, i ? 67 : 0), p[9] = { 0.1f * s, 0, 0, 0.45f * s, 0, 0, 1.3f * s, 0, 0 };
        IS(sfield_sparse(AT(p, n, 3), s, NULL, chosen, &count, from[i], w[i]), OK);
        assert_int_equal(count, 2);
    }
    for (k = 0; k < 9; k++) assert_true(w[1][k] == w[0][k] && from[1][k] == from[0][k]);
    assert_true(w[0][0] > 0.5f && w[0][0] < 1);
}

static void sparse_points_refuse_bad_arguments(void **state)
{
    float p[6] = { 0, 0, 0, 1, 0, 0 }, n[6] = { 0, 1, 0, 0, 1, 0 }, w[6], rgb[6] = { 0 }, out[6];
    uint32_t chosen[2], from[6];
    sfield_system half = half_allocator();
    size_t count;
    (void)state;
    IS(sfield_sparse(AT(p, n, 2), 0.1f, NULL, chosen, &count, from, w), OK);
    REFUSED(sfield_sparse(AT(NULL, n, 2), 0.1f, NULL, chosen, &count, from, w));
    REFUSED(sfield_sparse(AT(p, NULL, 2), 0.1f, NULL, chosen, &count, from, w));
    REFUSED(sfield_sparse(AT(p, n, 0), 0.1f, NULL, chosen, &count, from, w));
    IS(sfield_sparse(AT(p, n, (size_t)0x7fffffff + 1), 0.1f, NULL, chosen, &count, from, w), ERR_LIMIT);
    REFUSED(sfield_sparse(AT(p, n, 2), 0, NULL, chosen, &count, from, w));
    REFUSED(sfield_sparse(AT(p, n, 2), INFINITY, NULL, chosen, &count, from, w));
    IS(sfield_sparse(AT(p, n, 2), 0.1f, &half, chosen, &count, from, w), ERR_DESC);
    REFUSED(sfield_sparse(AT(p, n, 2), 0.1f, NULL, NULL, &count, from, w));
    REFUSED(sfield_sparse(AT(p, n, 2), 0.1f, NULL, chosen, NULL, from, w));
    REFUSED(sfield_sparse(AT(p, n, 2), 0.1f, NULL, chosen, &count, NULL, w));
    REFUSED(sfield_sparse(AT(p, n, 2), 0.1f, NULL, chosen, &count, from, NULL));
    IS(sfield_sparse(AT(p, n, 2), 1e-30f, NULL, chosen, &count, from, w), ERR_INPUT);   /* more cells than numbers */
    n[4] = NAN;
    IS(sfield_sparse(AT(p, n, 2), 0.1f, NULL, chosen, &count, from, w), ERR_INPUT);
    IS(sfield_spread(2, from, w, count, rgb, out), OK);
    REFUSED(sfield_spread(2, NULL, w, count, rgb, out));
    REFUSED(sfield_spread(2, from, NULL, count, rgb, out));
    REFUSED(sfield_spread(2, from, w, count, NULL, out));
    REFUSED(sfield_spread(2, from, w, count, rgb, NULL));
    IS(sfield_spread(2, from, w, 1, rgb, out), ERR_INPUT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_algebra_refuses_bad_arguments),
        cmocka_unit_test(terms_make_the_product),
        cmocka_unit_test(dots_and_turns_hold_for_tiles_and_what_is_left),
        cmocka_unit_test(building_refuses_bad_arguments),
        cmocka_unit_test(many_positions_equal_each_alone),
        cmocka_unit_test(scenes_refuse_bad_arguments),
        cmocka_unit_test(sparse_points_refuse_bad_arguments),
        cmocka_unit_test(sparse_points_far_apart_have_the_same_weights),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
