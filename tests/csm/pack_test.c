/* pack_test - the packed file: bytes of the block come back, hostile files do no harm, all allocations may fail. */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#define COHSM_STATIC
#define CSM_IMPLEMENTATION
#include "csm.h"

/* ---- allocation that counts and fails ---- */

typedef struct heap { size_t live, used, peak, calls, fail_at; int fail_on; } heap;    /* fail_at: from 1; 0 never */

static void *heap_alloc(size_t size, void *user)
{
    heap *h = (heap *)user;
    size_t *p;

    h->calls++;
    if (h->fail_at && (h->fail_on ? h->calls >= h->fail_at : h->calls == h->fail_at)) return NULL;
    p = (size_t *)malloc(size + 16);
    if (!p) return NULL;
    p[0] = size;
    h->live++;
    h->used += size;
    if (h->used > h->peak) h->peak = h->used;
    return (char *)p + 16;
}

static void heap_free(void *memory, void *user)
{
    heap *h = (heap *)user;
    size_t *p = (size_t *)(void *)((char *)memory - 16);

    h->live--;
    h->used -= p[0];
    free(p);
}

static cohsm_desc services_of(heap *h)
{
    cohsm_desc d;
    memset(&d, 0, sizeof d);
    d.system.allocator.alloc_fn = heap_alloc;
    d.system.allocator.free_fn = heap_free;
    d.system.allocator.user = h;
    return d;
}

/* ---- meshes: a torus, whose tube may be thin, a sphere (no hole), a sheet with a wave ---- */

enum { RING = 24, TUBE = 12 };

typedef struct shape { float positions[RING * TUBE * 3]; uint32_t indices[RING * TUBE * 6]; cohsm_mesh mesh; } shape;

typedef enum kind { TORUS, SPHERE, SHEET } kind;

static void point_of(kind k, uint32_t i, uint32_t j, float *p)
{
    double a = 6.283185307179586 * i / RING, b = 6.283185307179586 * j / TUBE;

    if (k == TORUS) {
        p[0] = (float)(cos(a) * (1.0 + 0.35 * cos(b)));
        p[1] = (float)(0.35 * sin(b));
        p[2] = (float)(sin(a) * (1.0 + 0.35 * cos(b)));
    } else if (k == SPHERE) {
        b = 3.141592653589793 * j / (TUBE - 1);
        p[0] = (float)(cos(a) * sin(b));
        p[1] = (float)cos(b);
        p[2] = (float)(sin(a) * sin(b));
    } else {
        p[0] = (float)i / RING - 0.5f;
        p[1] = (float)(0.05 * sin(a));
        p[2] = (float)j / TUBE - 0.5f;
    }
}

static void shape_make(shape *s, kind k)
{
    uint32_t i, j, n = 0, rows = k == TORUS ? TUBE : TUBE - 1, columns = k == SHEET ? RING - 1 : RING;

    for (i = 0; i < RING; i++)
        for (j = 0; j < TUBE; j++) point_of(k, i, j, s->positions + 3 * (i * TUBE + j));
    for (i = 0; i < columns; i++)
        for (j = 0; j < rows; j++) {
            uint32_t a = i * TUBE + j, b = (i + 1) % RING * TUBE + j, c = i * TUBE + (j + 1) % TUBE;
            uint32_t d = (i + 1) % RING * TUBE + (j + 1) % TUBE;
            s->indices[n++] = a;
            s->indices[n++] = c;
            s->indices[n++] = b;
            s->indices[n++] = b;
            s->indices[n++] = c;
            s->indices[n++] = d;
        }
    memset(&s->mesh, 0, sizeof s->mesh);
    s->mesh.positions = s->positions;
    s->mesh.vertex_count = RING * TUBE;
    s->mesh.indices = s->indices;
    s->mesh.index_count = n;
}

static cohsm_desc desc_of(uint32_t side, uint32_t map_side)
{
    cohsm_desc d;
    memset(&d, 0, sizeof d);
    d.domain.side[0] = d.domain.side[1] = side;
    d.map_side = map_side;
    d.order = COHSM_ORDER_HILBERT;
    return d;
}

static cohsm_maps *build(const cohsm_desc *d, kind k)
{
    static shape s;
    cohsm_maps *maps = NULL;
    shape_make(&s, k);
    assert_int_equal(cohsm_build(d, &s.mesh, &maps, NULL), COHSM_OK);
    return maps;
}

static int is_stored(const void *data) { return cohsm__get_u32((const uint8_t *)data + 12) == 0; }

static void check_same(const cohsm_maps *a, const cohsm_maps *b)
{
    size_t size, other;
    const void *p = cohsm_data(a, &size), *q = cohsm_data(b, &other);
    assert_int_equal(size, other);
    assert_memory_equal(p, q, size);
}

/* Takes the maps. Returns packed over plain size. */
static double check_round_trip(cohsm_maps *maps, int stored)
{
    cohsm_info info;
    cohsm_maps *back = NULL;
    void *data = NULL;
    size_t size = 0;

    assert_int_equal(cohsm_pack(maps, NULL, &data, &size), COHSM_OK);
    assert_int_equal(is_stored(data), stored);
    assert_int_equal(cohsm_open(data, size, NULL, &back), COHSM_OK);
    check_same(maps, back);
    cohsm_get_info(maps, &info);
    cohsm_free(back);
    cohsm_free(maps);
    free(data);
    return (double)size / (double)info.bytes;
}

/* ---- round trips ---- */

static void all_layers_orders_and_depth_bits_come_back(void **state)
{
    uint32_t layers, order, bits, k;

    (void)state;
    for (layers = 1; layers < COHSM_LAYERS_COUNT; layers++)
        for (order = 1; order < COHSM_ORDER_COUNT; order++)
            for (bits = 4, k = 0; bits <= 8; bits++, k = (k + 1) % 3) {
                cohsm_desc d = desc_of(13, 11);
                if ((kind)k == SHEET && layers != COHSM_LAYERS_Z1Z2) continue;
                d.layers = (cohsm_layers)layers;
                d.order = (cohsm_order)order;
                d.depth_bits = bits;
                d.self_only = (int)(bits & 1u);
                check_round_trip(build(&d, (kind)k), 0);
            }
}

static void all_domains_come_back(void **state)
{
    static const float path[9][4] = { { 2, 1, 0, 1 }, { 2, 1, 1, 1 }, { 1, 2, 1, 1 }, { 0, 2, 2, 1 }, { -1, 2, 2, 1 },
                                      { -2, 2, 1, 1 }, { -2, 1, 0, 1 }, { -2, 0, 0, 1 }, { 0, 0, 0, 1 } };
    cohsm_desc d = desc_of(32, 24);

    (void)state;
    assert_true(check_round_trip(build(&d, TORUS), 0) < 0.8);
    d.domain.kind = COHSM_DOMAIN_OCTAHEDRAL;
    assert_true(check_round_trip(build(&d, TORUS), 0) < 0.8);
    d = desc_of(6, 16);
    d.domain.kind = COHSM_DOMAIN_RECTANGLE;
    d.domain.origin[0] = d.domain.origin[2] = -1.0f;
    d.domain.origin[1] = 2.0f;
    d.domain.u[0] = d.domain.v[2] = 2.0f;
    check_round_trip(build(&d, TORUS), 0);
    d = desc_of(0, 16);
    d.domain.kind = COHSM_DOMAIN_LIST;
    d.domain.locations = path[0];
    d.domain.location_count = 9;
    check_round_trip(build(&d, SPHERE), 0);
    d.order = COHSM_ORDER_SCANLINE;
    check_round_trip(build(&d, SHEET), 0);
}

static void maps_of_two_chunks_come_back(void **state)
{
    cohsm_desc d = desc_of(258, 8);
    (void)state;
    check_round_trip(build(&d, TORUS), 0);
}

static void shards_of_maps_come_back(void **state)
{
    static const uint32_t cut[] = { 0, 1, 13, 16 * 7 + 3, 16 * 16 };
    cohsm_desc d = desc_of(16, 16);
    uint32_t i;

    (void)state;
    for (i = 0; i < 4; i++) {
        d.pixel_begin = cut[i];
        d.pixel_end = cut[i + 1];
        check_round_trip(build(&d, TORUS), 0);
    }
}

/* A sound block that no builder writes: a bit set where a line's last words are unused. It is stored as it is. */
static void a_block_that_no_builder_writes_comes_back(void **state)
{
    cohsm_desc d = desc_of(16, 12);
    cohsm_maps *maps = build(&d, TORUS), *foreign = NULL;
    size_t size;
    const void *data = cohsm_data(maps, &size);
    uint32_t *words = (uint32_t *)malloc(size);

    (void)state;
    assert_non_null(words);
    memcpy(words, data, size);
    words[size / 4 - 1] = 1;
    words[3] = cohsm__block_crc(words, size / 4);
    cohsm__host_words(words, size / 4);
    assert_int_equal(cohsm_open(words, size, NULL, &foreign), COHSM_OK);
    check_round_trip(foreign, 1);
    free(words);
    cohsm_free(maps);
}

/* ---- arguments, memory ---- */

static void packing_refuses_bad_arguments(void **state)
{
    cohsm_desc d = desc_of(8, 8);
    cohsm_maps *maps = build(&d, TORUS);
    cohsm_desc half;
    cohsm_maps huge;
    void *data = NULL;
    size_t size = 0;

    (void)state;
    memset(&half.system, 0, sizeof half);
    half.system.allocator.alloc_fn = heap_alloc;
    assert_int_equal(cohsm_pack(NULL, NULL, &data, &size), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_pack(maps, NULL, NULL, &size), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_pack(maps, NULL, &data, NULL), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_pack(maps, &half.system, &data, &size), COHSM_ERR_DESC);
    memset(&huge, 0, sizeof huge);
    huge.head.words = 0x3fffffff;                   /* the largest block is 4 bytes below 4 GB, its file too large */
    assert_int_equal(cohsm_pack(&huge, NULL, &data, &size), COHSM_ERR_LIMIT);
    assert_null(data);
    cohsm_free(maps);
}

static void packing_survives_failing_memory(void **state)
{
    cohsm_desc d = desc_of(16, 12);
    cohsm_maps *maps = build(&d, TORUS);
    size_t i, size;
    int on, done;

    (void)state;
    for (on = 0; on < 2; on++)
        for (i = 1, done = 0; !done; i++) {
            heap h;
            cohsm_desc services = services_of(&h);
            cohsm_maps *back = NULL;
            void *data = NULL;
            cohsm_result result;

            memset(&h, 0, sizeof h);
            h.fail_at = i;
            h.fail_on = on;
            result = cohsm_pack(maps, &services.system, &data, &size);
            if (result == COHSM_OK) {
                h.calls = 0;
                result = cohsm_open(data, size, &services.system, &back);
                done = result == COHSM_OK && h.calls < i;
            } else assert_null(data);
            if (result == COHSM_OK) check_same(maps, back);
            else assert_int_equal(result, COHSM_ERR_ALLOC);
            cohsm_free(back);
            if (data) heap_free(data, &h);
            assert_int_equal(h.live, 0);
        }
    cohsm_free(maps);
}

/* What opening asks for: 64 bytes a byte of file and the model, even where nearly all of the block is constant. */
static void opening_takes_at_most_64_bytes_a_byte_of_file(void **state)
{
    uint32_t side;

    (void)state;
    for (side = 4; side <= 64; side *= 4) {
        cohsm_desc d = desc_of(side, 128);
        cohsm_maps *maps, *back = NULL;
        heap h;
        cohsm_desc services = services_of(&h);
        void *data = NULL;
        size_t size = 0;

        memset(&h, 0, sizeof h);
        d.center[0] = 20.0f;                        /* the torus is a dot, all else is background */
        d.radius = 60.0f;
        maps = build(&d, TORUS);
        assert_int_equal(cohsm_pack(maps, NULL, &data, &size), COHSM_OK);
        assert_int_equal(cohsm_open(data, size, &services.system, &back), COHSM_OK);
        assert_true(h.peak <= 64 * size + (1u << 18));
        check_same(maps, back);
        cohsm_free(back);
        cohsm_free(maps);
        free(data);
    }
}

/* ---- hostile files ---- */

static uint8_t *packed_sample(kind k, cohsm_maps **maps, size_t *size)
{
    cohsm_desc d = desc_of(12, 8);
    void *data = NULL;
    *maps = build(&d, k);
    assert_int_equal(cohsm_pack(*maps, NULL, &data, size), COHSM_OK);
    assert_false(is_stored(data));
    return (uint8_t *)data;
}

/* Opening may refuse; what it takes must be the block that was packed, by the checksum, and answer. */
static int try_open(const uint8_t *data, size_t size, const cohsm_maps *whole)
{
    uint8_t *copy = (uint8_t *)malloc(size ? size : 1);     /* its own, so that the sanitizer sees its end */
    cohsm_maps *maps = NULL;
    cohsm_result result;
    uint16_t depths[64];

    assert_non_null(copy);
    memcpy(copy, data, size);
    result = cohsm_open(copy, size, NULL, &maps);
    free(copy);
    if (result == COHSM_OK) {
        check_same(maps, whole);
        assert_int_equal(cohsm_depths(maps, 0, depths), COHSM_OK);
    } else assert_null(maps);
    cohsm_free(maps);
    return result == COHSM_OK;
}

/* Behind the headers every n-th byte or bit alone where few mutations are asked for (emulators, checkers): a prime. */
static size_t step_at(size_t byte)
{
    const char *few = getenv("CSM_MUTATIONS");
    return byte < COHSM__PACK_HEADER + 384 || !few || atol(few) >= 100000 ? 1 : 11;
}

static void truncated_files_are_refused(void **state)
{
    cohsm_maps *maps;
    size_t size, i;
    uint8_t *data = packed_sample(TORUS, &maps, &size);

    (void)state;
    assert_true(try_open(data, size, maps));
    for (i = 0; i < size; i += step_at(i)) {
        assert_false(try_open(data, i, maps));
        if (i < 12) continue;
        cohsm__put_u32(data + 8, (uint32_t)i);      /* as if whole: the last bits may not matter */
        if (try_open(data, i, maps)) assert_true(i + 16 >= size);
        cohsm__put_u32(data + 8, (uint32_t)size);
    }
    free(data);
    cohsm_free(maps);
}

static void flipped_bits_are_refused_but_for_the_last(void **state)
{
    cohsm_maps *maps;
    size_t size, i, taken = 0;
    uint8_t *data = packed_sample(SHEET, &maps, &size);

    (void)state;
    for (i = 0; i < 8 * size; i += step_at(i / 8)) {
        data[i / 8] = (uint8_t)(data[i / 8] ^ 1u << i % 8);
        taken += (size_t)try_open(data, size, maps);
        data[i / 8] = (uint8_t)(data[i / 8] ^ 1u << i % 8);
    }
    assert_true(taken < 128);                       /* the last bits, and a longest list said to be longer */
    free(data);
    cohsm_free(maps);
}

/* Mutations with the checksum left wrong reach the decoder all the same: it runs before the sum can be known. */
static void mutated_packs_are_refused_or_usable(void **state)
{
    cohsm_maps *maps[3];
    size_t size[3], i;
    uint8_t *data[3];
    uint32_t k, j, n;

    (void)state;
    for (k = 0; k < 3; k++) data[k] = packed_sample((kind)k, &maps[k], &size[k]);
    for (i = 0; i < 20000; i += step_at(size[0])) {
        uint8_t *d, *copy;
        k = (uint32_t)(i % 3);
        d = data[k];
        copy = (uint8_t *)malloc(size[k]);
        assert_non_null(copy);
        memcpy(copy, d, size[k]);
        n = 1 + cohsm__hash32((uint32_t)i) % 8;
        for (j = 0; j < n; j++) {
            uint32_t r = cohsm__hash32((uint32_t)i * 16 + j), s = cohsm__hash32(r);
            size_t at = r & 1u ? 16 + s % 384u : s % size[k];
            if (at < size[k]) copy[at] = (uint8_t)(r >> 8);
        }
        try_open(copy, size[k], maps[k]);
        for (j = COHSM__PACK_HEADER + 384; j < size[k]; j++)         /* lists of nothing but noise */
            copy[j] = (uint8_t)cohsm__hash32((uint32_t)i * 65536u + j);
        memcpy(copy, d, COHSM__PACK_HEADER + 384);
        if (i % 16 == 0) try_open(copy, size[k], maps[k]);
        free(copy);
    }
    for (k = 0; k < 3; k++) {
        free(data[k]);
        cohsm_free(maps[k]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_layers_orders_and_depth_bits_come_back), cmocka_unit_test(all_domains_come_back),
        cmocka_unit_test(maps_of_two_chunks_come_back), cmocka_unit_test(shards_of_maps_come_back),
        cmocka_unit_test(a_block_that_no_builder_writes_comes_back), cmocka_unit_test(packing_refuses_bad_arguments),
        cmocka_unit_test(packing_survives_failing_memory),
        cmocka_unit_test(opening_takes_at_most_64_bytes_a_byte_of_file),
        cmocka_unit_test(truncated_files_are_refused), cmocka_unit_test(flipped_bits_are_refused_but_for_the_last),
        cmocka_unit_test(mutated_packs_are_refused_or_usable)
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
