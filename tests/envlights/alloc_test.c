/* alloc_test - every allocation fails once, and from then on: an error code, nothing leaked, outputs untouched;
   and the peaks that the header's comment states. */

#include "envlights.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>
#include "util.h"

static sky day, black, dim, bright;     /* dim: one lit texel; bright: with a sun that is one texel */

static int setup(void **state)
{
    (void)state;
    day = sky_alloc(ENVLT_PROJECTION_LATLONG, 32, 16);
    black = sky_alloc(ENVLT_PROJECTION_LATLONG, 32, 16);
    dim = sky_alloc(ENVLT_PROJECTION_LATLONG, 32, 16);
    dim.rgb[3 * 100] = 1;
    sky_fill(&day, sunny);
    bright = sky_alloc(ENVLT_PROJECTION_LATLONG, 64, 32);
    sky_fill(&bright, even);
    bright.rgb[3 * (8 * 64 + 20)] = 1e4f;
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    sky_free(&day);
    sky_free(&black);
    sky_free(&dim);
    sky_free(&bright);
    return 0;
}

typedef envlt_result (*act)(ledger *l, int what);

static void fail_everywhere(const char *name, act run, int what)
{
    ledger l;
    size_t calls, i;
    int on;
    ledger_allocator(&l);
    assert_int_equal(run(&l, what), ENVLT_OK);
    assert_int_equal(l.live, 0);
    calls = l.calls;
    assert_true(calls > 0);
    for (on = 0; on < 2; on++)
        for (i = 1; i <= calls; i++) {
            envlt_result r;
            memset(&l, 0, sizeof l);
            l.fail_at = i;
            l.fail_on = on;
            r = run(&l, what);
            if (r != ENVLT_ERR_ALLOC) fail_msg("%s: allocation %lu failed: result %d", name, (unsigned long)i, (int)r);
            if (l.live) fail_msg("%s: allocation %lu failed: %lu left", name, (unsigned long)i, (unsigned long)l.live);
        }
}

static envlt_allocator allocator_of(ledger *l)
{
    envlt_allocator a;
    a.alloc_fn = ledger_alloc;
    a.free_fn = ledger_free;
    a.user = l;
    return a;
}

/* what: method, + 8 with the sun split off */
static envlt_result act_build(ledger *l, int what)
{
    envlt_desc d = desc_of((envlt_method)(what & 7), 12);
    envlt_lights *lights = NULL;
    envlt_result r;
    d.split_sun = what & 8;
    d.system.allocator = allocator_of(l);
    r = envlt_create(&d, what & 8 ? &bright.map : &day.map, &lights, NULL);
    if (r != ENVLT_OK) assert_null(lights);
    else if (what & 8) assert_int_equal(envlt_get_lights(lights, NULL)->flags, ENVLT_LIGHT_SUN);
    envlt_free(lights);
    return r;
}

/* A failed follow leaves the lights as they were. what: the new count, 0 = as before; from 100 on: from a black map,
   from 200 on: from one with a single lit texel */
static envlt_result act_follow(ledger *l, int what)
{
    envlt_desc d = desc_of(ENVLT_METHOD_VARIANCE, 12);
    envlt_lights *lights = NULL;
    envlt_light before[12];
    uint32_t count, again;
    envlt_result r;
    const envlt_light *list;
    const envlt_map *map = what == 20 ? &bright.map : &day.map;
    size_t fail_at = l->fail_at;
    d.split_sun = what == 20;
    d.system.allocator = allocator_of(l);
    l->fail_at = 0;
    if (envlt_create(&d, what >= 200 ? &dim.map : what >= 100 ? &black.map : map, &lights, NULL) != ENVLT_OK)
        return ENVLT_ERR_ARGUMENT;
    list = envlt_get_lights(lights, &count);
    memcpy(before, list, count * sizeof *before);
    if (fail_at) l->fail_at = l->calls + fail_at;
    r = envlt_follow(lights, map, (uint32_t)what % 100, NULL);
    if (r != ENVLT_OK && count) {
        assert_memory_equal(before, envlt_get_lights(lights, &again), count * sizeof *before);
        assert_int_equal(again, count);
        assert_int_equal(envlt_jitter(lights, 1, 1, before), ENVLT_OK);
    } else if (r == ENVLT_OK && what >= 200) {
        envlt_get_lights(lights, &again);
        assert_int_equal(count, 1);
        assert_int_equal(again, 12);
    }
    envlt_free(lights);
    return r;
}

static void a_build_survives_failing_memory(void **state)
{
    (void)state;
    for (int m = 0; m < ENVLT_METHOD_COUNT; m++) fail_everywhere("build", act_build, m);
    fail_everywhere("build with the sun", act_build, 8 + ENVLT_METHOD_STRUCTURED);
}

static void following_survives_failing_memory(void **state)
{
    static const int plans[] = { 0, 20, 5, 108, 200 };
    (void)state;
    for (int p = 0; p < 5; p++) {
        ledger l;
        size_t first, calls;
        /* how many allocations are follow's own */
        memset(&l, 0, sizeof l);
        assert_int_equal(act_follow(&l, plans[p]), ENVLT_OK);
        assert_int_equal(l.live, 0);
        calls = l.calls;
        memset(&l, 0, sizeof l);
        {
            envlt_desc d = desc_of(ENVLT_METHOD_VARIANCE, 12);
            envlt_lights *lights = NULL;
            d.split_sun = plans[p] == 20;
            d.system.allocator = allocator_of(&l);
            const envlt_map *map = plans[p] == 20 ? &bright.map : plans[p] >= 200 ? &dim.map :
                                   plans[p] >= 100 ? &black.map : &day.map;
            assert_int_equal(envlt_create(&d, map, &lights, NULL), ENVLT_OK);
            envlt_free(lights);
        }
        first = l.calls;
        assert_true(calls > first);
        for (int on = 0; on < 2; on++)
            for (size_t i = 1; i <= calls - first; i++) {
                envlt_result r;
                memset(&l, 0, sizeof l);
                l.fail_at = i;
                l.fail_on = on;
                r = act_follow(&l, plans[p]);
                if (r != ENVLT_ERR_ALLOC || l.live)
                    fail_msg("follow %d: allocation %lu failed: result %d, %lu left", plans[p], (unsigned long)i,
                             (int)r, (unsigned long)l.live);
            }
    }
}

/* The formulas of the header's comment. */
static void peaks_are_as_stated(void **state)
{
    (void)state;
    for (int m = 2; m < 2 * ENVLT_METHOD_COUNT; m++) {
        sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 256, 128);
        envlt_desc d = desc_of((envlt_method)(m / 2), 64);
        envlt_lights *lights;
        envlt_stats stats;
        size_t kept;
        ledger l;
        d.split_sun = m & 1;
        d.system.allocator = ledger_allocator(&l);
        sky_fill(&s, sunny);
        assert_int_equal(envlt_create(&d, &s.map, &lights, &stats), ENVLT_OK);
        assert_int_equal(stats.peak_bytes, l.peak);
        assert_true(l.peak <= (d.split_sun ? 79 : 76) * s.texels + 1024 * 64);
        assert_true(l.now <= 16 * s.texels + 512 * 64);
        kept = l.now;
        l.peak = l.now;
        assert_int_equal(envlt_follow(lights, &s.map, 0, &stats), ENVLT_OK);
        assert_int_equal(stats.peak_bytes, l.peak);
        assert_true(l.peak <= kept + (d.split_sun ? 37 : 32) * s.texels + 1024 * 64);
        memset(s.rgb, 0, 3 * s.texels * sizeof *s.rgb);
        envlt_free(lights);
        assert_int_equal(envlt_create(&d, &s.map, &lights, NULL), ENVLT_OK);
        sky_fill(&s, sunny);
        l.peak = l.now;
        assert_int_equal(envlt_follow(lights, &s.map, 0, &stats), ENVLT_OK);       /* built anew in place */
        assert_int_equal(stats.peak_bytes, l.peak);
        envlt_free(lights);
        assert_int_equal(l.live, 0);
        assert_int_equal(l.now, 0);
        sky_free(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_build_survives_failing_memory),
        cmocka_unit_test(following_survives_failing_memory),
        cmocka_unit_test(peaks_are_as_stated),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
