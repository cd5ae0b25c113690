/* scene_test - scenes of many instances: whatever their spheres leave out, the answers are the products of what each
   instance answers alone, bit by bit; and the spheres leave out most. */

#define COHSM_STATIC
#define CSM_IMPLEMENTATION
#include "csm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "util.h"
#include "making.h"

enum { SAMPLES = 2300, INSTANCES = 37 };     /* more than a block of samples, two bunches and a part */

static float points[SAMPLES][4], lights[SAMPLES][5], wanted[SAMPLES], alone[SAMPLES], answers[SAMPLES];
static uint32_t entities[SAMPLES];
static cohsm_instance instances[INSTANCES];
static int totals[3];                   /* answers 0, 1 and COHSM_REFUSED so far */

/* Samples in and round the cloud; a few far off, at infinity, or not numbers; lights likewise. */
static void place_samples(uint64_t *seed, double wide, double middle, int positions)
{
    static const float odd[6] = { (float)NAN, (float)INFINITY, 1e9f, 3e18f, 1e30f, -2e38f };
    int i, c;
    for (i = 0; i < SAMPLES; i++) {
        float l[3];
        rnd_direction(seed, l);
        for (c = 0; c < 3; c++) {
            points[i][c] = (float)(middle + rnd_in(seed, -1.3 * wide, 1.3 * wide));
            lights[i][c] = positions ? (float)(middle + rnd_in(seed, -2 * wide, 2 * wide)) : 3 * l[c];
        }
        if (i % 50 == 7) points[i][i % 3] = odd[i / 50 % 6];
        if (i % 50 == 11) lights[i][i % 3] = odd[i / 50 % 6];
        if (i % 50 == 13) memset(lights[i], 0, sizeof lights[i]);
        if (i % 50 == 17) memcpy(lights[i], points[i], 12);
        entities[i] = i % 3 ? (uint32_t)rnd_in(seed, 0, INSTANCES + 3) : 0;
    }
}

/* The product by calls with one instance each, which no sphere leaves out: the own instance first, then the others in
   their order, until a sample is dark or refused. */
static void multiply_alone(const cohsm_query *query)
{
    int pass, i, s;
    for (s = 0; s < SAMPLES; s++) wanted[s] = 1;
    for (pass = query->entities ? 0 : 1; pass < 2; pass++)
        for (i = 0; i < INSTANCES; i++) {
            cohsm_query q = *query;
            q.entities = NULL;
            q.seed += 0x9e3779b9u * (uint32_t)i;            /* what roulette of this instance draws with */
            assert_int_equal(cohsm_visible_scene(&instances[i], 1, &q, alone, NULL), COHSM_OK);
            for (s = 0; s < SAMPLES; s++) {
                const int own = query->entities && query->entities[s] == (uint32_t)i + 1;
                if (own == pass || !(wanted[s] > 0)) continue;
                if (alone[s] == COHSM_REFUSED) wanted[s] = COHSM_REFUSED;
                else wanted[s] *= alone[s];
            }
        }
}

static void compare(const cohsm_query *q, const char *what)
{
    size_t refused = 0, count = 0;
    int s, dark = 0, lit = 0;
    assert_int_equal(cohsm_visible_scene(instances, INSTANCES, q, answers, &refused), COHSM_OK);
    multiply_alone(q);
    for (s = 0; s < SAMPLES; s++) {
        if (memcmp(&wanted[s], &answers[s], 4) != 0)
            fail_msg("%s, filter %d, sample %d (%g %g %g): %g, not %g", what, (int)q->filter, s, (double)points[s][0],
                     (double)points[s][1], (double)points[s][2], (double)answers[s], (double)wanted[s]);
        count += wanted[s] == COHSM_REFUSED;
        dark += wanted[s] == 0;
        lit += wanted[s] == 1;
    }
    assert_int_equal(refused, count);
    totals[0] += dark;
    totals[1] += lit;
    totals[2] += (int)count;
}

static void compare_ways(const char *what, int positions)
{
    int filter, way;
    for (filter = 0; filter < 3; filter++)
        for (way = 0; way < 4; way++) {
            cohsm_query q = query_of(points[0], SAMPLES, lights[0],
                                     positions ? COHSM_LIGHT_POSITION : COHSM_LIGHT_DIRECTION, (cohsm_filter)filter);
            q.position_stride = sizeof points[0];
            q.light_stride = sizeof lights[0];
            q.seed = 11;
            if (way & 1) q.entities = entities;
            if (way & 2) q.one_light = 1;
            compare(&q, what);
        }
}

static void answers_are_those_of_all_instances(void **state)
{
    static const struct { double wide, middle; const char *name; } clouds[] = {
        { 9, 0, "a cloud" }, { 2, 0, "a heap" }, { 40, 0, "far apart" }, { 30, 5000, "off the origin" }
    };
    cohsm_maps *maps[KINDS];
    uint64_t seed = 3;
    int i, k, positions;
    (void)state;
    build_kinds(maps);
    for (i = 0; i < 4; i++)
        for (positions = 0; positions < 2; positions++) {
            place_instances(instances, INSTANCES, maps, &seed, clouds[i].wide, clouds[i].middle);
            place_samples(&seed, clouds[i].wide, clouds[i].middle, positions);
            compare_ways(clouds[i].name, positions);
        }
    printf("%d dark, %d lit, %d refused\n", totals[0], totals[1], totals[2]);
    assert_true(totals[0] > 10000 && totals[1] > 10000 && totals[2] > 1000);
#if COHSM__SIMD_SETS
    for (k = 0; k < KINDS; k++) maps[k]->simd = 0;          /* the kernels without intrinsics */
    compare_ways("plain", 1);
#endif
    for (k = 0; k < KINDS; k++) cohsm_free(maps[k]);
}

/* Packed points and directions, which are loaded as many at a time as there are lanes, and counts that are no multiple
   of these. */
static void packed_samples_are_those_with_strides(void **state)
{
    static float p[SAMPLES][3], l[SAMPLES][3], loose[SAMPLES];
    cohsm_maps *maps[KINDS];
    uint64_t seed = 8;
    size_t n;
    int s, k;
    (void)state;
    build_kinds(maps);
    place_instances(instances, INSTANCES, maps, &seed, 9, 0);
    place_samples(&seed, 9, 0, 0);
    for (s = 0; s < SAMPLES; s++) {
        memcpy(p[s], points[s], 12);
        memcpy(l[s], lights[s], 12);
    }
    for (n = 1; n <= SAMPLES; n = n < 40 ? n + 1 : 3 * n + 1) {
        cohsm_query q = query_of(p[0], n, l[0], COHSM_LIGHT_DIRECTION, COHSM_FILTER_NEAREST);
        assert_int_equal(cohsm_visible_scene(instances, INSTANCES, &q, answers, NULL), COHSM_OK);
        q.positions = points[0];
        q.lights = lights[0];
        q.position_stride = sizeof points[0];
        q.light_stride = sizeof lights[0];
        assert_int_equal(cohsm_visible_scene(instances, INSTANCES, &q, loose, NULL), COHSM_OK);
        assert_memory_equal(answers, loose, n * sizeof *loose);
    }
    for (k = 0; k < KINDS; k++) cohsm_free(maps[k]);
}

static double radius_of(const cohsm_instance *in)
{
    const float *t = in->transform;
    return (double)in->maps->head.radius * sqrt(pow((double)t[0], 2) + pow((double)t[1], 2) + pow((double)t[2], 2));
}

/* From the centre of the instance's sphere to the ray or segment of sample i. */
static double distance(const cohsm_instance *in, int i, int positions)
{
    double v = 0, d = 0, along = 0, s;
    int c;
    for (c = 0; c < 3; c++) {
        const float *h = in->maps->head.center, *t = in->transform;
        const double middle = (double)t[c] * (double)h[0] + (double)t[4 + c] * (double)h[1] +
                              (double)t[8 + c] * (double)h[2] + (double)t[12 + c];
        const double to = middle - (double)points[i][c];
        const double way = (double)lights[i][c] - (positions ? (double)points[i][c] : 0);
        v += to * to;
        d += way * way;
        along += way * to;
    }
    if (d > 1e30) return HUGE_VAL;                          /* lights whose length float has not count as none */
    s = along / d;
    if (s < 0) s = 0;
    if (positions && s > 1) s = 1;
    return sqrt(v - 2 * s * along + s * s * d);
}

/* Counts the samples that are left with an instance beside those whose segments meet its sphere, by double: all of
   these, and few more. The sphere's margin and the angle of a cell are what is more. */
static void spheres_leave_out_most(void **state)
{
    enum { N = COHSM__BLOCK };
    static cohsm__bunch b;
    model m = model_sphere(14, 9, 0);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 96, 16);
    cohsm_maps *maps[KINDS];
    uint64_t seed = 21;
    int positions, plain, simd, k, i;
    (void)state;
    d.domain.side[1] = 48;
    maps[0] = build(&d, &m);
    for (k = 1; k < KINDS; k++) maps[k] = maps[0];
    simd = maps[0]->simd;
    place_instances(instances, INSTANCES, maps, &seed, 5, 0);
    for (positions = 0; positions < 2; positions++)
        for (plain = 0; plain < 2; plain++) {
            cohsm_query q = query_of(points[0], N, lights[0],
                                     positions ? COHSM_LIGHT_POSITION : COHSM_LIGHT_DIRECTION, COHSM_FILTER_NEAREST);
            int asked = 0, met = 0;
            q.position_stride = sizeof points[0];
            q.light_stride = sizeof lights[0];
            place_samples(&seed, 5, 0, positions);
            maps[0]->simd = plain ? 0 : simd;
            b.count = COHSM__BUNCH;
            cohsm__find_asked(&b, instances, 0, &q, 0, N, 0, 1);
            for (k = 0; k < COHSM__BUNCH; k++)
                for (i = 0; i < N; i++) {
                    const int bit = (int)(b.asked[k][i / 32] >> i % 32 & 1u);
                    const double r = radius_of(&instances[k]), away = distance(&instances[k], i, positions);
                    if (!(away < 1e6)) continue;                    /* odd samples */
                    asked += bit;
                    met += away < r;
                    if (away < r && !bit) fail_msg("instance %d is left out for sample %d, %g of %g", k, i, away, r);
                }
            printf("%s%s: %d asked, %d met, of %d\n", positions ? "positions" : "directions", plain ? ", plain" : "",
                   asked, met, N * COHSM__BUNCH);
            assert_true(met > 100 && asked < 4 * met);
        }
    cohsm_free(maps[0]);
    model_free(&m);
}

/* Of maps whose empty pixels shadow anything and do not say so, a sphere keeps what lies in the corners of their
   squares from being asked; three instances are asked without spheres. */
static void instances_whose_spheres_are_missed_are_not_asked(void **state)
{
    enum { FEW = 3, MANY = 8 };
    model m = model_sphere(14, 9, 0.3);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 96, 16);
    cohsm_maps *maps;
    cohsm_query q = query_of(points[0], SAMPLES, lights[0], COHSM_LIGHT_DIRECTION, COHSM_FILTER_NEAREST);
    uint64_t seed = 5;
    int count, i, differ;
    (void)state;
    d.domain.side[1] = 48;
    d.self_only = 1;
    maps = build(&d, &m);
    maps->head.self_only = 0;
    place_samples(&seed, 2, 0, 0);
    q.position_stride = sizeof points[0];
    q.light_stride = sizeof lights[0];
    for (i = 0; i < MANY; i++) {
        instances[i].maps = maps;
        identity(instances[i].transform);
    }
    assert_int_equal(cohsm_visible_scene(instances, 1, &q, alone, NULL), COHSM_OK);
    for (count = FEW; count <= MANY; count += MANY - FEW) {
        assert_int_equal(cohsm_visible_scene(instances, (size_t)count, &q, answers, NULL), COHSM_OK);
        for (differ = 0, i = 0; i < SAMPLES; i++) differ += answers[i] > alone[i];
        printf("%d instances: %d samples are lit that each would have shadowed\n", count, differ);
        assert_true(count == FEW ? differ == 0 : differ > 0);
    }
    cohsm_free(maps);
    model_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(answers_are_those_of_all_instances),
        cmocka_unit_test(packed_samples_are_those_with_strides),
        cmocka_unit_test(spheres_leave_out_most),
        cmocka_unit_test(instances_whose_spheres_are_missed_are_not_asked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
