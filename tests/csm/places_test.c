/* places_test - few maps that stand for many: the places that cohsm_places_choose takes, against all choices by brute
   force, and against places that are spread evenly. */

#include "csm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "conformance.h"
#include "util.h"
#include "making.h"

enum { MOST = 128, POINTS = 1200 };

static char said[256];

static void remember(void *user, const char *message)
{
    (void)user;
    snprintf(said, sizeof said, "%s", message);
}

static cohsm_maps *maps_at(const model *m, const float (*at)[4], uint32_t count, uint32_t side)
{
    cohsm_desc d = desc_of(COHSM_DOMAIN_LIST, 0, side);
    d.domain.side[1] = 0;
    d.domain.locations = at[0];
    d.domain.location_count = count;
    return build(&d, m);
}

static cohsm_places_desc choosing(const cohsm_maps *maps, const float *points, uint32_t count)
{
    cohsm_places_desc d;
    memset(&d, 0, sizeof d);
    d.system.log = remember;
    d.candidates = maps;
    d.receivers = points;
    d.receiver_count = POINTS;
    d.place_count = count;
    said[0] = 0;
    return d;
}

/* What each map answers for each point. */
static void ask_all(const cohsm_maps *maps, const float *points, uint32_t count, float *answers)
{
    uint32_t i;
    for (i = 0; i < count; i++) {
        cohsm_query q = query_of(points, POINTS, &i, COHSM_LIGHT_INDEX, COHSM_FILTER_NEAREST);
        q.one_light = 1;
        assert_int_equal(cohsm_visible(maps, &q, answers + (size_t)i * POINTS, NULL), COHSM_OK);
    }
}

static double apart(const float *answers, uint32_t a, uint32_t b)
{
    size_t k, n = 0;
    for (k = 0; k < POINTS; k++)
        n += (answers[(size_t)a * POINTS + k] > 0.5f) != (answers[(size_t)b * POINTS + k] > 0.5f);
    return (double)n / POINTS;
}

static void make_scene(float *points, float (*at)[4], uint32_t count, uint64_t seed)
{
    uint32_t i;
    for (i = 0; i < 3 * POINTS; i++) points[i] = (float)rnd_in(&seed, -2, 2);
    for (i = 0; i < count; i++) {               /* along a bent line through the object's surroundings */
        const double t = (double)i / count;
        at[i][0] = (float)(2.4 * t - 1.2);
        at[i][1] = (float)(1.1 + 0.3 * sin(9 * t));
        at[i][2] = (float)(0.4 * cos(5 * t));
        at[i][3] = 1;
    }
}

/* With three places of ten there are 120 choices: the best of them, or nearly so, and its error is the true one. */
static void the_choice_is_nearly_the_best_of_all(void **state)
{
    enum { N = 10, K = 3 };
    static float points[3 * POINTS], answers[N * POINTS];
    float at[N][4];
    uint64_t seed;
    int exact = 0;
    (void)state;
    for (seed = 1; seed <= 6; seed++) {
        model m = model_soup(30, 0.35, seed);
        uint32_t places[K], instead[N], a, b, c, i, k;
        double error = -1, best = 1, sum = 0, reached = 0;
        cohsm_places_desc d;
        cohsm_maps *maps;
        make_scene(points, at, N, seed);
        maps = maps_at(&m, (const float (*)[4])at, N, 32);
        d = choosing(maps, points, K);
        assert_int_equal(cohsm_places_choose(&d, places, instead, &error), COHSM_OK);
        ask_all(maps, points, N, answers);
        for (a = 0; a < N; a++)
            for (b = a + 1; b < N; b++)
                for (c = b + 1; c < N; c++) {
                    for (sum = 0, i = 0; i < N; i++)
                        sum += fmin(apart(answers, i, a), fmin(apart(answers, i, b), apart(answers, i, c)));
                    best = fmin(best, sum / N);
                }
        for (i = 0; i < N; i++) {
            double nearest = 1;
            assert_true(instead[i] < K);
            for (k = 0; k < K; k++) nearest = fmin(nearest, apart(answers, i, places[k]));
            assert_true(fabs(apart(answers, i, places[instead[i]]) - nearest) < 1e-9);
            reached += nearest / N;
        }
        assert_true(places[0] < places[1] && places[1] < places[2] && places[2] < N);
        assert_true(fabs(reached - error) < 1e-9);
        assert_true(error < 1.05 * best + 1e-9);
        exact += error < best + 1e-9;
        cohsm_free(maps);
        model_free(&m);
    }
    assert_true(exact >= 4);
}

/* Two rooms with a wall between: whoever stands in one sees all of it and nothing of the other. Two places, one in
   each, answer for all; a single one is wrong wherever the other stands. All candidates as places have no error. */
static void one_place_in_each_room_answers_for_all(void **state)
{
    enum { N = 24 };
    static float points[3 * POINTS];
    const double lo[3] = { -0.05, -3, -3 }, hi[3] = { 0.05, 3, 3 };
    float at[N][4];
    model m = model_box(lo, hi, 0);
    uint32_t places[N], instead[N], i;
    uint64_t seed = 3;
    double error = -1;
    cohsm_places_desc d;
    cohsm_maps *maps;
    (void)state;
    for (i = 0; i < 3 * POINTS; i++) {
        points[i] = (float)rnd_in(&seed, -0.5, 0.5);
        if (i % 3 == 0) points[i] += i % 2 ? 1.0f : -1.0f;
    }
    for (i = 0; i < N; i++) {
        at[i][0] = i % 3 ? 1.0f : -1.0f;
        at[i][1] = (float)rnd_in(&seed, -0.5, 0.5);
        at[i][2] = (float)rnd_in(&seed, -0.5, 0.5);
        at[i][3] = 1;
    }
    maps = maps_at(&m, (const float (*)[4])at, N, 32);
    d = choosing(maps, points, 2);
    assert_int_equal(cohsm_places_choose(&d, places, instead, &error), COHSM_OK);
    assert_true(error >= 0 && error < 1e-12);
    assert_true(at[places[0]][0] * at[places[1]][0] < 0);
    for (i = 0; i < N; i++) assert_true(at[i][0] * at[places[instead[i]]][0] > 0);
    d.place_count = 1;                          /* in the room of two thirds: a third of all is wrong everywhere */
    assert_int_equal(cohsm_places_choose(&d, places, instead, &error), COHSM_OK);
    assert_true(fabs(error - 1.0 / 3.0) < 1e-9 && at[places[0]][0] > 0);
    d.place_count = N;
    assert_int_equal(cohsm_places_choose(&d, places, instead, &error), COHSM_OK);
    for (i = 0; i < N; i++) assert_true(places[i] == i);
    assert_true(error < 1e-12);
    cohsm_free(maps);
    model_free(&m);
}

/* A line of lights that runs through the open and past a wall with gaps: points that took no part in the choice are
   asked by maps of 16 places, once chosen, once spread evenly along the line. */
static void t70_chosen_places_answer_better_than_even_ones(void **state)
{
    enum { N = MOST, K = 16 };
    static float points[3 * POINTS], others[3 * POINTS], answers[N * POINTS];
    static float at[N][4];
    model bars[4], m = model_alloc(0, 0);
    uint32_t places[K], instead[N], i, k;
    uint64_t seed = 12;
    double chosen = 0, even = 0, error;
    cohsm_places_desc d;
    cohsm_maps *maps;
    (void)state;
    for (i = 0; i < 4; i++) {
        const double lo[3] = { 0.3 * i, 0.4, -1 }, hi[3] = { 0.3 * i + 0.17, 0.5, 1 };
        model both;
        bars[i] = model_box(lo, hi, 0);
        both = model_join(&m, &bars[i]);
        model_free(&m);
        model_free(&bars[i]);
        m = both;
    }
    for (i = 0; i < POINTS; i++)
        for (k = 0; k < 3; k++) {
            const double low = k == 0 ? -4 : k == 1 ? -0.5 : -1, high = k == 0 ? 1.4 : k == 1 ? -0.1 : 1;
            points[3 * i + k] = (float)rnd_in(&seed, low, high);
            others[3 * i + k] = (float)rnd_in(&seed, low, high);
        }
    for (i = 0; i < N; i++) {
        at[i][0] = (float)(-4 + 5.4 * (i + 0.5) / N);
        at[i][1] = 1;
        at[i][2] = 0;
        at[i][3] = 1;
    }
    maps = maps_at(&m, (const float (*)[4])at, N, 64);
    d = choosing(maps, points, K);
    assert_int_equal(cohsm_places_choose(&d, places, instead, &error), COHSM_OK);
    ask_all(maps, others, N, answers);
    for (i = 0; i < N; i++) {
        chosen += apart(answers, i, places[instead[i]]) / N;
        even += apart(answers, i, i * K / N * (N / K) + N / K / 2) / N;
    }
    print_message("places: 16 of 128 chosen %.4f (%.4f where they were chosen), spread evenly %.4f\n", chosen, error,
                  even);
    CONFORM_MAX("T70", "changed answers, 16 of 128 maps chosen by error, of those spread evenly", 0.8, chosen / even);
    cohsm_free(maps);
    model_free(&m);
}

static void bad_choices_are_named(void **state)
{
    static float points[3 * POINTS];
    float at[4][4];
    model m = model_cube(0.4, 0);
    uint32_t places[4] = { 9, 9, 9, 9 }, instead[4] = { 9, 9, 9, 9 };
    size_t fail;
    cohsm_places_desc d;
    cohsm_maps *maps;
    ledger l;
    (void)state;
    make_scene(points, at, 4, 1);
    maps = maps_at(&m, (const float (*)[4])at, 4, 16);
    d = choosing(maps, points, 2);
    assert_int_equal(cohsm_places_choose(NULL, places, instead, NULL), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_places_choose(&d, NULL, instead, NULL), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_places_choose(&d, places, NULL, NULL), COHSM_ERR_ARGUMENT);
    d.candidates = NULL;
    assert_int_equal(cohsm_places_choose(&d, places, instead, NULL), COHSM_ERR_DESC);
    assert_string_equal(said, "cohsm_places_choose: desc.candidates is NULL");
    d = choosing(maps, NULL, 2);
    assert_int_equal(cohsm_places_choose(&d, places, instead, NULL), COHSM_ERR_DESC);
    d = choosing(maps, points, 5);
    assert_int_equal(cohsm_places_choose(&d, places, instead, NULL), COHSM_ERR_DESC);
    d = choosing(maps, points, 0);
    assert_int_equal(cohsm_places_choose(&d, places, instead, NULL), COHSM_ERR_DESC);
    d = choosing(maps, points, 2);
    d.receiver_stride = 10;
    assert_int_equal(cohsm_places_choose(&d, places, instead, NULL), COHSM_ERR_DESC);
    d.receiver_stride = 0;
    d.bias = (float)NAN;
    assert_int_equal(cohsm_places_choose(&d, places, instead, NULL), COHSM_ERR_DESC);
    d.bias = 0;
    d.receiver_count = 0;
    assert_int_equal(cohsm_places_choose(&d, places, instead, NULL), COHSM_ERR_DESC);
    d.receiver_count = POINTS;
    d.system.allocator = ledger_allocator(&l);
    for (fail = 1; fail <= 7; fail++) {
        l.calls = 0;
        l.fail_at = fail;
        assert_int_equal(cohsm_places_choose(&d, places, instead, NULL), COHSM_ERR_ALLOC);
        assert_int_equal(l.live, 0);
    }
    assert_true(places[0] == 9 && instead[0] == 9);
    l.fail_at = 0;
    assert_int_equal(cohsm_places_choose(&d, places, instead, NULL), COHSM_OK);
    assert_int_equal(l.live, 0);
    cohsm_free(maps);
    model_free(&m);
}

typedef struct stop { size_t calls, at; float last; int falls; } stop;

static int stop_there(void *user, float fraction)
{
    stop *s = (stop *)user;
    s->falls += !(fraction >= s->last && fraction <= 1);
    s->last = fraction;
    return ++s->calls == s->at;
}

/* At any call of progress, those of the exchanges among them: nothing is written, nothing leaks, and fractions never
   fall. */
static void a_choice_may_be_cancelled_at_any_time(void **state)
{
    enum { N = 10, K = 3, BEFORE = 2 * N + K };         /* calls of asking, comparing, and taking one by one */
    static float points[3 * POINTS];
    float at[N][4];
    model m = model_soup(30, 0.35, 1);
    uint32_t places[K] = { 99, 99, 99 }, instead[N];
    cohsm_result result = COHSM_ERR_CANCELLED;
    cohsm_places_desc d;
    cohsm_maps *maps;
    size_t when;
    stop s;
    ledger l;
    (void)state;
    make_scene(points, at, N, 1);
    maps = maps_at(&m, (const float (*)[4])at, N, 16);
    for (when = 1; when < 1000 && result == COHSM_ERR_CANCELLED; when++) {
        memset(&s, 0, sizeof s);
        s.at = when;
        d = choosing(maps, points, K);
        d.system.log = NULL;
        d.system.allocator = ledger_allocator(&l);
        d.system.progress = stop_there;
        d.system.user = &s;
        result = cohsm_places_choose(&d, places, instead, NULL);
        assert_int_equal(l.live, 0);
        assert_int_equal(s.falls, 0);
        if (result == COHSM_ERR_CANCELLED) assert_true(places[0] == 99 && s.calls == when);
    }
    assert_int_equal(result, COHSM_OK);
    assert_true(s.calls >= BEFORE + K && s.calls <= BEFORE + 8 * N);
    cohsm_free(maps);
    model_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_choice_is_nearly_the_best_of_all),
        cmocka_unit_test(one_place_in_each_room_answers_for_all),
        cmocka_unit_test(t70_chosen_places_answer_better_than_even_ones),
        cmocka_unit_test(bad_choices_are_named),
        cmocka_unit_test(a_choice_may_be_cancelled_at_any_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
