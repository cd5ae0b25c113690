/* segments_test - a builder that is given the segments of all views writes the block that it writes of their layers.
   The segments are found here, pixel by pixel, by equation (1) as the paper has it. */

#include "csm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "util.h"
#include "making.h"

enum { M = 12, PIXELS = M * M };

static char said[256];

static void remember(void *user, const char *message)
{
    (void)user;
    snprintf(said, sizeof said, "%s", message);
}

/* Layers of a view: quiet pixels, busy ones, ones that nothing hits, ones whose layers coincide. */
static void layers_of(uint32_t view, float *z1, float *z2)
{
    uint64_t seed = 1000 + view;
    uint32_t p;
    for (p = 0; p < PIXELS; p++) {
        const double noise = rnd(&seed);
        z1[p] = p % 5 == 0 ? 0.25f : (float)(0.2 + 0.6 * noise * (p % 7) / 7.0);
        z2[p] = z1[p] + (p % 11 == 3 ? 0.0f : p % 3 ? 0.15f : 0.004f);
        if (p % 13 == 5 && view % 4) z1[p] = z2[p] = 2.0f;
        if (p == 1) z1[p] = z2[p] = 2.0f;
    }
}

typedef struct list { cohsm_segment *s; size_t count, room; } list;

static void add_segment(list *l, uint32_t first, uint32_t pixel, uint32_t value)
{
    if (l->count == l->room) {
        l->room = 2 * l->room + 1024;
        l->s = (cohsm_segment *)realloc(l->s, l->room * sizeof *l->s);
        if (!l->s) abort();
    }
    l->s[l->count].first = first;
    l->s[l->count].pixel = pixel;
    l->s[l->count++].value = value;
}

/* Equation (1) for one pixel after the other, within chunks of 65,536 views. */
static list find_segments(uint32_t views, uint32_t depth_bits)
{
    const uint32_t top = (1u << depth_bits) - 1u;
    float *z1 = (float *)malloc(2 * PIXELS * sizeof *z1), *z2 = z1 + PIXELS;
    uint16_t *near_far = (uint16_t *)malloc((size_t)views * PIXELS * 4);
    list l = { NULL, 0, 0 };
    uint32_t v, p, begin, end;
    assert_non_null(z1);
    assert_non_null(near_far);
    for (v = 0; v < views; v++) {
        layers_of(v, z1, z2);
        for (p = 0; p < PIXELS; p++) {
            uint32_t a = z1[p] <= 1 ? (uint32_t)(z1[p] * 65533.0f) : 65535;
            uint32_t b = z2[p] <= 1 ? (uint32_t)(z2[p] * 65533.0f) : 0;
            uint16_t *to = near_far + 2 * ((size_t)v * PIXELS + p);
            to[0] = (uint16_t)a;
            to[1] = (uint16_t)(a == 65535 ? 65535 : b > a ? b - 1 : a);
        }
    }
    for (begin = 0; begin < views; begin = end) {
        end = views - begin < 65536 ? views : begin + 65536;
        for (p = 0; p < PIXELS; p++) {
            uint32_t first = begin, lo = 0, hi = top;
            for (v = begin; v < end; v++) {
                const uint16_t *z = near_far + 2 * ((size_t)v * PIXELS + p);
                uint32_t least = (uint32_t)z[0] * top / 65535u, most = (uint32_t)z[1] * top / 65535u;
                while (least * 65535u / top < z[0]) least++;            /* the grid values within the interval */
                while (most < top && (most + 1) * 65535u / top <= z[1]) most++;
                if (least > most) {       /* none: the depth itself */
                    if (first != v) add_segment(&l, first, p, lo | hi << 8);
                    add_segment(&l, v, p, ((uint32_t)z[0] + z[1]) / 2 | 1u << 16);
                    first = v + 1;
                    lo = 0;
                    hi = top;
                    continue;
                }
                if ((least > lo ? least : lo) > (most < hi ? most : hi)) {
                    if (first != v) add_segment(&l, first, p, lo | hi << 8);
                    first = v;
                    lo = least;
                    hi = most;
                } else {
                    lo = least > lo ? least : lo;
                    hi = most < hi ? most : hi;
                }
            }
            if (first != end) add_segment(&l, first, p, lo | hi << 8);
        }
    }
    free(z1);
    free(near_far);
    return l;
}

static cohsm_desc making(uint32_t side)
{
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, side, M);
    d.radius = 1;
    d.order = COHSM_ORDER_SCANLINE;
    d.orientation = COHSM_ORIENTATION_POLAR;
    d.system.log = remember;
    said[0] = 0;
    return d;
}

static cohsm_maps *by_layers(const cohsm_desc *d)
{
    float z1[PIXELS], z2[PIXELS];
    cohsm_builder *b = NULL;
    cohsm_maps *maps = NULL;
    uint32_t v;
    assert_int_equal(cohsm_builder_create(d, &b), COHSM_OK);
    for (v = 0; v < cohsm_builder_view_count(b); v++) {
        layers_of(v, z1, z2);
        assert_int_equal(cohsm_builder_add(b, v, z1, z2, NULL), COHSM_OK);
    }
    assert_int_equal(cohsm_builder_finish(b, &maps, NULL), COHSM_OK);
    cohsm_builder_free(b);
    return maps;
}

static void expect_same(const cohsm_desc *d, const list *l)
{
    cohsm_maps *wanted = by_layers(d), *maps = NULL;
    cohsm_builder *b = NULL;
    cohsm_stats stats;
    const void *blocks[2];
    size_t sizes[2];
    assert_int_equal(cohsm_builder_create(d, &b), COHSM_OK);
    assert_int_equal(cohsm_builder_import(b, l->s, l->count), COHSM_OK);
    assert_int_equal(cohsm_builder_import(b, l->s, l->count), COHSM_ERR_ORDER);
    assert_int_equal(cohsm_builder_finish(b, &maps, &stats), COHSM_OK);
    cohsm_builder_free(b);
    blocks[0] = cohsm_data(wanted, &sizes[0]);
    blocks[1] = cohsm_data(maps, &sizes[1]);
    assert_int_equal(sizes[0], sizes[1]);
    assert_memory_equal(blocks[0], blocks[1], sizes[0]);
    if (!d->pixel_end) assert_int_equal(stats.segments, l->count);
    assert_true(stats.exact_depths > 0);
    cohsm_free(wanted);
    cohsm_free(maps);
}

static void segments_make_the_block_of_their_layers(void **state)
{
    cohsm_desc d = making(20);
    list l = find_segments(400, 8);
    (void)state;
    expect_same(&d, &l);
    d.pixel_begin = 17;                 /* a shard: others are left out */
    d.pixel_end = 101;
    expect_same(&d, &l);
    free(l.s);
    d = making(20);
    d.depth_bits = 5;
    l = find_segments(400, 5);
    expect_same(&d, &l);
    free(l.s);
}

/* More than 65,536 views: lists begin anew. Segments come chunk by chunk. */
static void segments_of_several_chunks_make_the_block_of_their_layers(void **state)
{
    cohsm_desc d = making(257);
    list l = find_segments(257 * 257, 8);
    cohsm_builder *b = NULL;
    (void)state;
    expect_same(&d, &l);
    l.s[l.count - 1].first = 65535;
    assert_int_equal(cohsm_builder_create(&d, &b), COHSM_OK);
    assert_int_equal(cohsm_builder_import(b, l.s, l.count), COHSM_ERR_INPUT);
    assert_non_null(strstr(said, "] has the first view 65535; it must be at or above the multiple of 65536"));
    cohsm_builder_free(b);
    free(l.s);
}

/* Each fault alone, and memory that runs out at any call: an error, and nothing leaks. */
static void segments_out_of_order_are_refused(void **state)
{
    static const char *const words[9] = {
        "] has the pixel 144; it must be below map_side^2",
        "] has the first view 400; it must be below the number of views",
        "] has the first view 0; it must be above that of the segment before it of its pixel",
        "] has the value 1543; it must be lo | hi << 8 with lo <= hi < 2^depth_bits, or a depth | 1 << 16",
        "] has the value 131072; it must be lo | hi << 8",
        "segments[0] has the first view 1; it must be a multiple of 65536, as the first of its pixel",
        "the pixel without a segment is 143; it must be none",
        "; it must be above that of the segment before it of its pixel",
        "the pixel without a segment is 0; it must be none"
    };
    list l = find_segments(400, 8);
    cohsm_segment *s = (cohsm_segment *)malloc(l.count * sizeof *s);
    int fault;
    (void)state;
    assert_non_null(s);
    for (fault = 0; fault < 9; fault++) {
        cohsm_desc d = making(20);
        cohsm_builder *b = NULL;
        cohsm_maps *maps = NULL;
        size_t count = l.count, i = 0;
        ledger memory;
        d.system.allocator = ledger_allocator(&memory);
        memcpy(s, l.s, l.count * sizeof *s);
        while (s[i].pixel != 4 || s[i].first == 0) i++;
        if (fault == 0) s[i].pixel = PIXELS;
        if (fault == 1) s[i].first = 400;
        if (fault == 2) s[i].first = 0;                             /* twice */
        if (fault == 3) s[i].value = 7 | 6u << 8;                   /* lo above hi */
        if (fault == 4) s[i].value = 1u << 17;
        if (fault == 5) s[0].first = 1;                             /* none for view 0 */
        if (fault == 6) while (s[count - 1].pixel == PIXELS - 1) count--;       /* none for the last pixel */
        if (fault == 7) s[i].first = s[i - 1].first;
        if (fault == 8) count = 0;
        assert_int_equal(cohsm_builder_create(&d, &b), COHSM_OK);
        if (cohsm_builder_import(b, s, count) != COHSM_ERR_INPUT) fail_msg("fault %d", fault);
        if (strncmp(said, "cohsm_builder_import: ", 22) != 0 || !strstr(said, words[fault]))
            fail_msg("fault %d: %s", fault, said);
        assert_int_equal(cohsm_builder_finish(b, &maps, NULL), COHSM_ERR_ORDER);
        assert_null(maps);
        cohsm_builder_free(b);
        assert_int_equal(memory.live, 0);
    }
    free(s);
    free(l.s);
}

static void memory_may_run_out_while_segments_are_taken(void **state)
{
    list l = find_segments(400, 8);
    size_t at, failed = 0;
    (void)state;
    for (at = 1; at < 400; at++) {
        cohsm_desc d = making(20);
        cohsm_builder *b = NULL;
        cohsm_maps *maps = NULL;
        cohsm_result result;
        ledger memory;
        d.system.allocator = ledger_allocator(&memory);
        memory.fail_at = at;
        result = cohsm_builder_create(&d, &b);
        if (result == COHSM_OK) result = cohsm_builder_import(b, l.s, l.count);
        if (result == COHSM_OK) result = cohsm_builder_finish(b, &maps, NULL);
        if (result != COHSM_OK) {
            failed++;
            assert_int_equal(result, COHSM_ERR_ALLOC);
            assert_null(maps);
        }
        cohsm_builder_free(b);
        cohsm_free(maps);
        assert_int_equal(memory.live, 0);
        if (result == COHSM_OK) break;
    }
    assert_true(failed > 10);
    free(l.s);
}

static void segments_come_in_place_of_layers(void **state)
{
    float z1[PIXELS], z2[PIXELS];
    list l = find_segments(400, 8);
    cohsm_desc d = making(20);
    cohsm_builder *b = NULL;
    (void)state;
    assert_int_equal(cohsm_builder_create(&d, &b), COHSM_OK);
    assert_int_equal(cohsm_builder_import(NULL, l.s, l.count), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_builder_import(b, NULL, 0), COHSM_ERR_ARGUMENT);
    assert_string_equal(said, "cohsm_builder_import: segments is NULL");
    layers_of(0, z1, z2);
    assert_int_equal(cohsm_builder_add(b, 0, z1, z2, NULL), COHSM_OK);
    assert_int_equal(cohsm_builder_import(b, l.s, l.count), COHSM_ERR_ORDER);
    cohsm_builder_free(b);
    free(l.s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(segments_make_the_block_of_their_layers),
        cmocka_unit_test(segments_of_several_chunks_make_the_block_of_their_layers),
        cmocka_unit_test(segments_out_of_order_are_refused),
        cmocka_unit_test(memory_may_run_out_while_segments_are_taken),
        cmocka_unit_test(segments_come_in_place_of_layers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
