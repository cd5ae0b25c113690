/* alloc_test - an allocation that fails, at every site: once, and from then on. No crash, no leak, GIFILT_ERR_ALLOC,
   no filter; what a filter takes, and that frames take nothing. */

#include "gifilter.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "util.h"

enum { WIDE = 100, HIGH = 12 };

static float positions[3 * WIDE * HIGH], normals[3 * WIDE * HIGH], light[3 * WIDE * HIGH];

static void every_allocation_may_fail(void **state)
{
    gifilt_filter *filter;
    ledger l;
    gifilt_system system = ledger_system(&l);
    size_t calls, at;
    int on;
    (void)state;
    assert_int_equal(create(WIDE, HIGH, &system, &filter), GIFILT_OK);
    gifilt_free(filter);
    calls = l.calls;
    assert_true(calls > 0 && l.live == 0);
    for (on = 0; on < 2; on++)
        for (at = 1; at <= calls; at++) {
            system = ledger_system(&l);
            l.fail_at = at;
            l.fail_on = on;
            filter = NULL;
            assert_int_equal(create(WIDE, HIGH, &system, &filter), GIFILT_ERR_ALLOC);
            assert_null(filter);
            assert_int_equal(l.live, 0);
        }
}

/* gifilter.h: "80 bytes a pixel and 4 KB a row. gifilt_apply takes no memory." */
static void frames_take_no_memory(void **state)
{
    gifilt_filter *filter;
    ledger l;
    gifilt_system system = ledger_system(&l);
    gifilt_points points = points_of(positions, normals, WIDE * HIGH);
    gifilt_frame d;
    size_t calls;
    (void)state;
    assert_int_equal(create(WIDE, HIGH, &system, &filter), GIFILT_OK);
    assert_true(l.peak <= 80 * WIDE * HIGH + 4096 * HIGH);
    calls = l.calls;
    memset(&d, 0, sizeof d);
    for (d.passes = -1; d.passes <= 6; d.passes++)
        assert_int_equal(gifilt_apply(filter, &d, &points, light, light), GIFILT_OK);
    assert_int_equal(l.calls, calls);
    gifilt_free(filter);
    assert_int_equal(l.live, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(frames_take_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
