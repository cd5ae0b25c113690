/* odd.h - services such as a caller may have, none of them usual, for fuzz targets:

     memory    aligned to 8 bytes exactly, full of garbage when it is given and when it was given back; one call fails
     tasks     in an odd order: backwards, every other one first, by any stride, shuffled
     progress  cancels at one call; its fraction must lie in 0..1 and never fall within a call of the library
     log       must be one line, at most once in a call, and never in a call that succeeds

   The last bytes of the fuzzer's input choose them (odd_take). A call of the library by these services does what it
   does without, or ends with the code of the service that failed; then the same call again does (ODDLY), and nothing
   leaks (odd_done). Result codes are those that all headers have (src/README.md): 0 is OK, 4 ALLOC, 7 CANCELLED. */
#ifndef DAPPLE_ODD_H
#define DAPPLE_ODD_H

#include "input.h"
#include "ledger.h"
#include <stdint.h>
#include <stdio.h>

enum { ODD_OK = 0, ODD_ALLOC = 4, ODD_CANCELLED = 7 };

typedef struct odd {
    ledger   memory;
    uint32_t order;             /* of tasks */
    uint32_t cancel_at;         /* the call of progress, of all, that returns not 0; 0 = none */
    /* of the call of the library that is under way */
    size_t   memory_before;     /* calls of the allocator before it */
    uint32_t progress_calls, log_calls;
    float    fraction;
    int      cancelled;
    uint32_t failures;          /* calls of the library that a service failed */
    uint64_t hash;              /* of what odd_keep was given */
} odd;

#define ODD_ABORT(what) do { fprintf(stderr, "odd.h: %s\n", what); abort(); } while (0)

/* Numbers 0 to 2017: each of the small ones, and some of the large. Half of all inputs have 0, which is never. */
static inline uint32_t odd_number(uint32_t byte)
{
    uint32_t k = byte >> 1;
    return byte & 1u ? 1u + k * (k + 7u) / 8u : 0u;
}

static inline void odd_take(odd *o, const uint8_t *data, size_t size)
{
    memset(o, 0, sizeof *o);
    o->order = size > 0 ? data[size - 1] : 0u;
    o->memory.fail_at = odd_number(size > 1 ? data[size - 2] : 0u);
    o->cancel_at = odd_number(size > 2 ? data[size - 3] : 0u);
}

/* Which of count tasks comes as the i-th. */
static inline size_t odd_place(size_t i, size_t count, uint32_t order)
{
    size_t step = 1 + (order >> 2) * 2u, a, b, t;
    switch (order & 3u) {
    case 0: return count - 1 - i;
    case 1: return i < (count + 1) / 2 ? 2 * i : 2 * (i - (count + 1) / 2) + 1;
    case 2: return (i + count / 2) % count;                 /* from the middle */
    default:
        for (;; step += 2) {                                /* any stride that meets each task once */
            for (a = step, b = count; b; t = a % b, a = b, b = t) { }
            if (a == 1) return i * step % count;
        }
    }
}

static inline void odd_parallel_for(void *user, size_t count, void (*task)(void *context, size_t index),
                                    void *context)
{
    const odd *o = (const odd *)user;
    size_t i;
    for (i = 0; i < count; i++) task(context, odd_place(i, count, o->order));
}

static inline int odd_progress(void *user, float fraction)
{
    odd *o = (odd *)user;
    if (!(fraction >= o->fraction && fraction <= 1)) ODD_ABORT("progress fell, or is not within 0..1");
    if (o->cancelled) ODD_ABORT("progress is called after it cancelled");
    o->fraction = fraction;
    if (++o->progress_calls == o->cancel_at) o->cancelled = 1;
    return o->cancelled;
}

static inline void odd_log(void *user, const char *message)
{
    odd *o = (odd *)user;
    if (!message || !*message || strchr(message, '\n')) ODD_ABORT("what is logged is no line");
    o->log_calls++;
}

/* Gives a header's system these services. */
#define ODD_SYSTEM(system, o)                     \
    do {                                          \
        (system)->allocator.alloc_fn = ledger_alloc; \
        (system)->allocator.free_fn = ledger_free;   \
        (system)->allocator.user = &(o)->memory;     \
        (system)->parallel_for = odd_parallel_for;   \
        (system)->progress = odd_progress;           \
        (system)->log = odd_log;                     \
        (system)->user = (o);                        \
    } while (0)

/* Before and after a call of the library. odd_after returns whether a service failed it: it may then be made again. */
static inline void odd_before(odd *o)
{
    o->memory_before = o->memory.calls;
    o->log_calls = 0;
    o->fraction = 0;
    o->cancelled = 0;
}

static inline int odd_after(odd *o, int result, int calm)
{
    int failed = o->memory.fail_at > o->memory_before && o->memory.fail_at <= o->memory.calls;
    if (o->log_calls > (result != ODD_OK)) ODD_ABORT("a call that succeeded has logged, or one twice");
    if (o->cancelled && result == ODD_OK) ODD_ABORT("a cancelled call succeeded");
    if ((o->cancelled && result == ODD_CANCELLED) || (failed && result == ODD_ALLOC)) {
        o->failures++;
        return 1;
    }
    if (result != calm) {
        fprintf(stderr, "odd.h: %d by odd services, %d without\n", result, calm);
        abort();
    }
    return 0;
}

/* Makes a call until no service fails it: at most three times. */
#define ODDLY(o, calm, call)                            \
    do odd_before(o);                                   \
    while (odd_after(o, (int)(call), (int)(calm)))

/* Does not know what a call does without these services: ALLOC and CANCELLED must be theirs, others are taken. */
static inline int odd_after_any(odd *o, int result)
{
    return odd_after(o, result, result == ODD_ALLOC || result == ODD_CANCELLED ? ODD_OK : result);
}

/* As ODDLY, where it is not known what the call does without; the caller compares that. */
#define ODD_TRY(o, result, call)         \
    do {                                 \
        odd_before(o);                   \
        (result) = (call);               \
    } while (odd_after_any(o, (int)(result)))

/* Takes what was computed into the hash, for runs that are compared as a whole. */
static inline void odd_keep(odd *o, const void *data, size_t bytes)
{
    const uint8_t *p = (const uint8_t *)data;
    size_t i;
    for (i = 0; i < bytes; i++) o->hash = (o->hash ^ p[i]) * 1099511628211u;
}

static inline void odd_keep_result(odd *o, int result) { odd_keep(o, &result, sizeof result); }

static inline void odd_done(const odd *o)
{
    if (o->memory.live) ODD_ABORT("memory is not given back");
}

/* Runs a target by usual services, then by odd ones on the same input, and returns whether what it kept differs. */
static inline int odd_changes(void (*run)(input *in, odd *o, int is_odd), const uint8_t *data, size_t size, odd *o)
{
    input in = input_of(data, size);
    odd usual;
    odd_take(&usual, NULL, 0);
    run(&in, &usual, 0);
    in = input_of(data, size);
    odd_take(o, data, size);
    run(&in, o, 1);
    return o->hash != usual.hash;
}

static inline void odd_equal(const void *a, const void *b, size_t bytes)
{
    if (memcmp(a, b, bytes) != 0) ODD_ABORT("odd services change what is computed");
}

#endif
