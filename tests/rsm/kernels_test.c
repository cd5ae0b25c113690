/* kernels_test - rsm.h's kernels give the same bits in every instruction set that this machine has. */

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#define RSM_STATIC
#define RSM_IMPLEMENTATION
#include "rsm.h"

#if RSM__SIMD_SETS

static float uniform(uint32_t *state, float low, float high)
{
    *state = *state * 1664525u + 1013904223u;
    return low + (high - low) * (float)(*state >> 8) / 16777216.0f;
}

/* Every eighth light lies in the receivers' plane, every ninth has no flux, every fifth a low bound. */
static void make_lights(rsm__block *blocks, size_t count)
{
    uint32_t state = 5;
    size_t i;
    memset(blocks, 0, (count + RSM__BLOCK - 1) / RSM__BLOCK * sizeof *blocks);
    for (i = 0; i < count; i++) {
        rsm__block *k = blocks + i / RSM__BLOCK;
        size_t j = i % RSM__BLOCK;
        k->px[j] = uniform(&state, -1, 1);
        k->py[j] = i % 8 ? uniform(&state, -1, 1) : 0.0f;
        k->pz[j] = uniform(&state, -1, 1);
        k->nx[j] = uniform(&state, -1, 1);
        k->ny[j] = uniform(&state, -1, 1);
        k->nz[j] = uniform(&state, -1, 1);
        k->r[j] = i % 9 ? uniform(&state, 0, 1) : 0.0f;
        k->g[j] = uniform(&state, 0, 1);
        k->b[j] = uniform(&state, 0, 1);
        k->cap[j] = i % 5 ? RSM__NO_CAP : 0.125f;
        k->rounding[j] = rsm__rounding(k->px[j], k->py[j], k->pz[j]);
    }
}

static const float receiver[7] = { 0.125f, 0, -0.25f, 0, 1, 0, 1e-7f };

static void lights_on_one_receiver_have_the_same_sum(void **state)
{
    static const rsm__kernel plain[4] = { rsm__sum_lights_plain, rsm__sum_lights_lossy_plain,
                                          rsm__sum_lights_near_plain, rsm__sum_lights_near_lossy_plain };
    static const rsm__kernel avx2[4] = { rsm__sum_lights_avx2, rsm__sum_lights_lossy_avx2, rsm__sum_lights_near_avx2,
                                         rsm__sum_lights_near_lossy_avx2 };
    rsm__block blocks[3];
    size_t count, k;
    (void)state;
    if (!rsm__simd_level()) skip();
    for (count = 8; count <= 3 * RSM__BLOCK; count += 8)
        for (k = 0; k < 4; k++) {
            rsm__sum a = { { 1, 2, 3 }, 4, 5, 0 }, b = a;
            make_lights(blocks, count);
            plain[k](blocks, count, receiver, &a);
            avx2[k](blocks, count, receiver, &b);
            assert_memory_equal(&a, &b, sizeof a);
            if (count < RSM__BLOCK) continue;
            assert_true(a.rgb[0] > 1.0f && (a.full > 4.0f) == (k & 1) && (a.nearby > 0.0f) == k >> 1);
        }
}

static void make_receivers(rsm__receiver_lanes *p)
{
    uint32_t state = 99;
    int c, l;
    memset(p, 0, sizeof *p);
    for (l = 0; l < RSM__WIDE; l++)
        for (c = 0; c < 7; c++) p->x[c][l] = c == 6 ? 1e-7f : uniform(&state, -1, 1);
}

static void lights_on_several_receivers_have_the_same_sums(void **state)
{
    rsm__block blocks[2];
    rsm__receiver_lanes plain, avx2, avx512;
    int lossy, c;
    (void)state;
    if (!rsm__simd_level()) skip();
    make_lights(blocks, 100);
    for (lossy = 0; lossy < 2; lossy++) {
        make_receivers(&plain);
        make_receivers(&avx2);
        make_receivers(&avx512);
        (lossy ? rsm__light_receivers_lossy_plain : rsm__light_receivers_plain)(blocks, 100, &plain);
        (lossy ? rsm__light_receivers_lossy_avx2 : rsm__light_receivers_avx2)(blocks, 100, &avx2);
        assert_memory_equal(&plain, &avx2, sizeof plain);
        assert_true(plain.sums[0][0] + plain.sums[0][1] + plain.sums[0][2] > 0.0f && plain.sums[0][8] == 0.0f);
        assert_true((plain.sums[3][0] + plain.sums[3][1] + plain.sums[3][2] > 0.0f) == lossy);
        if (rsm__simd_level() < 2) continue;
        (lossy ? rsm__light_receivers_lossy_avx512 : rsm__light_receivers_avx512)(blocks, 100, &avx512);
        for (c = 0; c < 5; c++) assert_memory_equal(plain.sums[c], avx512.sums[c], 8 * sizeof(float));
    }
}

static void a_sample_suits_the_same_pixels(void **state)
{
    static const float sample[6] = { 0, 0, 0, 0, 1, 0 }, limits[3] = { 0.8f, 0.25f, 1.0f };
    rsm__tile plain, avx2;
    uint32_t seed = 3;
    size_t i, found = 0;
    (void)state;
    if (!rsm__simd_level()) skip();
    memset(&plain, 0, sizeof plain);
    for (i = 0; i < RSM__TILE; i++) {
        plain.px[i] = uniform(&seed, -1, 1);
        plain.py[i] = uniform(&seed, -0.5f, 0.5f);
        plain.pz[i] = uniform(&seed, -1, 1);
        plain.nx[i] = uniform(&seed, -0.6f, 0.6f);
        plain.ny[i] = 1.0f - fabsf(plain.nx[i]) * 0.5f;
    }
    avx2 = plain;
    rsm__suit_tile_plain(&plain, RSM__TILE, sample, limits, 4);
    rsm__suit_tile_avx2(&avx2, RSM__TILE, sample, limits, 4);
    assert_memory_equal(&plain, &avx2, sizeof plain);
    for (i = 0; i < RSM__TILE; i++) {
        assert_true(plain.good[i] == 0 || plain.good[i] == 4);
        found += plain.good[i] != 0;
    }
    assert_true(found > 10 && found < RSM__TILE - 10);
}

#else
static void there_is_one_set_only(void **state)
{
    int level = rsm__simd_level();
    (void)state;
    assert_int_equal(level, 0);
}
#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
#if RSM__SIMD_SETS
        cmocka_unit_test(lights_on_one_receiver_have_the_same_sum),
        cmocka_unit_test(lights_on_several_receivers_have_the_same_sums),
        cmocka_unit_test(a_sample_suits_the_same_pixels)
#else
        cmocka_unit_test(there_is_one_set_only)
#endif
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
