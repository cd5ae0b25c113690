/* service_test - calls of shadowfield.h that build nothing, opening and merging, tell their progress and can be
   cancelled: on files large enough for each to ask several times, of harmonics in one colour, whose channels are
   compared, and of wavelets. */
#include "shadowfield.h"
#include "util.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

enum { OPEN_SH, OPEN_HAAR, MERGE_SH, MERGE_HAAR, SERVICED };

typedef struct bundle {
    sfield_field *shard[2];
    uint8_t      *file;
    size_t        size;
} bundle;

typedef struct meter { float last; int calls, stop_at, bad; } meter;

static int watch(void *user, float fraction)
{
    meter *w = (meter *)user;
    if (!(fraction >= w->last && fraction >= 0 && fraction <= 1)) w->bad++;
    w->last = fraction;
    return ++w->calls == w->stop_at ? -7 : 0;
}

static void bundle_make(bundle *b, sfield_basis basis)
{
    sfield_desc d = small_desc(basis);
    sfield_emitter lamp;
    sfield_field *whole;
    memset(&lamp, 0, sizeof lamp);
    lamp.radius = 1;
    lamp.radiance[0] = lamp.radiance[1] = lamp.radiance[2] = 2;
    d.position_side = basis == SFIELD_BASIS_SH ? 20 : 14;
    if (basis == SFIELD_BASIS_SH) d.cube_side = 4;
    d.keep = 0.4f;
    assert_int_equal(sfield_build_emitter(&d, &lamp, &whole, NULL), SFIELD_OK);
    b->size = sfield_bytes(whole);
    b->file = (uint8_t *)malloc(b->size);
    assert_non_null(b->file);
    assert_int_equal(sfield_write(whole, b->file, b->size), SFIELD_OK);
    sfield_free(whole);
    d.shard_end = 3;
    assert_int_equal(sfield_build_emitter(&d, &lamp, &b->shard[0], NULL), SFIELD_OK);
    d.shard_begin = 3;
    d.shard_end = 4;
    assert_int_equal(sfield_build_emitter(&d, &lamp, &b->shard[1], NULL), SFIELD_OK);
}

static void bundle_free(bundle *b)
{
    sfield_free(b->shard[0]);
    sfield_free(b->shard[1]);
    free(b->file);
}

/* One call. What it makes must be the file. */
static sfield_result serviced(int call, const bundle *b, const sfield_system *d, sfield_field **out)
{
    const sfield_result r = call >= MERGE_SH ? sfield_merge((const sfield_field *const *)b->shard, 2, d, out)
                                             : sfield_open(b->file, b->size, d, out);
    uint8_t *again;
    if (r != SFIELD_OK) return r;
    again = (uint8_t *)malloc(b->size);
    assert_non_null(again);
    assert_int_equal(sfield_bytes(*out), b->size);
    assert_int_equal(sfield_write(*out, again, b->size), SFIELD_OK);
    assert_memory_equal(again, b->file, b->size);
    free(again);
    sfield_free(*out);
    return r;
}

static void calls_tell_progress_and_cancel_without_a_trace(void **state)
{
    /* parts of 256 KB through the checksum, and into the block; 4 shells' colours, 5 times 1,024 samples; shards */
    static const int asked[SERVICED] = { 2 + 3 + 4, 6 + 6 + 5, 2 + 3 + 4, 2 + 6 };
    bundle b[2];
    int call, calls, k;
    (void)state;
    bundle_make(&b[0], SFIELD_BASIS_SH);
    bundle_make(&b[1], SFIELD_BASIS_HAAR);
    for (call = 0; call < SERVICED; call++) {
        const bundle *of = &b[call & 1];
        sfield_field *untouched = (sfield_field *)(void *)b, *f = untouched;
        sfield_system d;
        counting c;
        meter w = { 0, 0, 0, 0 };
        memset(&d, 0, sizeof d);
        memset(&c, 0, sizeof c);
        d.allocator = counting_allocator(&c);
        d.progress = watch;
        d.user = &w;
        assert_int_equal(serviced(call, of, &d, &f), SFIELD_OK);
        assert_int_equal(w.calls, asked[call]);
        assert_int_equal(w.bad, 0);
        assert_true(w.last > 0.75f);
        assert_int_equal(c.now, 0);
        for (k = 1, calls = w.calls; k <= calls; k++) {
            f = untouched;
            w.last = 0;
            w.calls = 0;
            w.stop_at = k;
            assert_int_equal(serviced(call, of, &d, &f), SFIELD_ERR_CANCELLED);
            assert_int_equal(w.calls, k);
            assert_true(k > 1 || w.last == 0.0f);
            assert_ptr_equal(f, untouched);
            assert_int_equal(c.now, 0);
        }
    }
    bundle_free(&b[0]);
    bundle_free(&b[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(calls_tell_progress_and_cancel_without_a_trace) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
