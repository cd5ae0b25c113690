/* ledger.h - an allocator that counts, fills, and fails on demand: alloc_fn, free_fn and their user. */
#ifndef DAPPLE_LEDGER_H
#define DAPPLE_LEDGER_H

#include <stdlib.h>
#include <string.h>

#if defined(__GNUC__)
#define LEDGER_OK __attribute__((unused)) static
#else
#define LEDGER_OK static
#endif

typedef struct ledger {
    size_t live, calls, fail_at, now, peak;
    int fail_on;
} ledger; /* fail_at: 1, 2, ..; 0 never */

LEDGER_OK void *ledger_alloc(size_t size, void *user)
{
    ledger *l = (ledger *)user;
    size_t *p;
    l->calls++;
    if (l->fail_at && (l->calls == l->fail_at || (l->fail_on && l->calls > l->fail_at))) return NULL;
    p = (size_t *)malloc(size + 8);
    if (!p) return NULL;
    memset(p, 0xcd, size + 8);
    p[0] = size;
    l->live++;
    l->now += size;
    if (l->now > l->peak) l->peak = l->now;
    return (char *)p + 8;
}

LEDGER_OK void ledger_free(void *memory, void *user)
{
    ledger *l = (ledger *)user;
    char *p = (char *)memory - 8;
    size_t size;
    memcpy(&size, p, sizeof size);
    memset(p, 0xdd, size + 8);
    l->now -= size;
    l->live--;
    free(p);
}

#endif
