/* alloc_test - every allocation fails once, and from then on: an error code, nothing leaked, outputs untouched;
   and the peaks that the header's comment states. */

#include "envlights.h"
#include "envshadow.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>
#include "util.h"

typedef envsh_result (*act)(ledger *l, int what);

static void fail_everywhere(const char *name, act run, int what)
{
    ledger l;
    size_t calls, i;
    int on;
    memset(&l, 0, sizeof l);
    assert_int_equal(run(&l, what), ENVSH_OK);
    assert_int_equal(l.live, 0);
    calls = l.calls;
    assert_true(calls > 0);
    for (on = 0; on < 2; on++)
        for (i = 1; i <= calls; i++) {
            envsh_result r;
            memset(&l, 0, sizeof l);
            l.fail_at = i;
            l.fail_on = on;
            r = run(&l, what);
            if (r != ENVSH_ERR_ALLOC) fail_msg("%s: allocation %lu failed: result %d", name, (unsigned long)i, (int)r);
            if (l.live) fail_msg("%s: allocation %lu failed: %lu left", name, (unsigned long)i, (unsigned long)l.live);
        }
}

static envsh_result act_maps(ledger *l, int what)
{
    envsh_maps_desc d;
    envsh_maps *m = NULL;
    envsh_result r;
    memset(&d, 0, sizeof d);
    d.map_side = 16;
    d.rgba = what & 1;
    d.no_depth = what & 2;
    d.system.allocator = shadow_allocator(l);
    r = envsh_maps_create(&d, 5, &m);
    if (r != ENVSH_OK) assert_null(m);
    envsh_maps_free(m);
    return r;
}

static void maps_survive_failing_memory(void **state)
{
    (void)state;
    for (int what = 0; what < 4; what++) fail_everywhere("maps", act_maps, what);
}

/* The formulas of the header's comment. */
static void peaks_are_as_stated(void **state)
{
    envsh_maps_desc d;
    envsh_maps *maps;
    envsh_info atlas;
    ledger l;
    (void)state;
    memset(&d, 0, sizeof d);
    d.map_side = 64;
    memset(&l, 0, sizeof l);
    d.system.allocator = shadow_allocator(&l);
    assert_int_equal(envsh_maps_create(&d, 16, &maps), ENVSH_OK);
    envsh_get_info(maps, &atlas);
    assert_int_equal(atlas.bytes, l.now);
    assert_true(l.now <= 4 * 64 * 64 * 16 * 33 / 32 + 16 * sizeof(envsh_view) + 512);
    envsh_maps_free(maps);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(maps_survive_failing_memory),
        cmocka_unit_test(peaks_are_as_stated),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
