/* file_test - files of shadowfield.h: the same bytes again, every truncation, every header bit, seeded mutations
   and then every query on what was accepted. SFIELD_MUTATIONS: how many (100000). */
#define SFIELD_STATIC
#define SHADOWFIELD_IMPLEMENTATION
#include "shadowfield.h"
#include "util.h"
#include "use.h"
#include "ledger.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

typedef struct file { uint8_t *data; size_t size; } file;
enum { FILES = 10 };
static file files[FILES];

static void mend(uint8_t *data, size_t size)
{
    if (size >= 128) sfield__put_u32(data + 12, sfield__crc32(0, data + 16, size - 16));
}

/* Opens the file, which may take its own size and 18,000 bytes at any time, and uses it if asked to. Nothing leaks. */
static sfield_result try_file(const uint8_t *data, size_t size, int use)
{
    uint8_t *copy = (uint8_t *)malloc(size ? size : 1);              /* its end is where the sanitizer looks */
    sfield_field *f = NULL;
    sfield_system system;
    sfield_result r;
    ledger l;
    if (!copy) abort();
    memcpy(copy, data, size);
    memset(&l, 0, sizeof l);
    memset(&system, 0, sizeof system);
    system.allocator.alloc_fn = ledger_alloc;
    system.allocator.free_fn = ledger_free;
    system.allocator.user = &l;
    r = sfield_open(copy, size, &system, &f);
    free(copy);
    if (l.peak > size + 18000)
        fail_msg("%lu bytes asked for by a file of %lu", (unsigned long)l.peak, (unsigned long)size);
    if (r == SFIELD_OK) {
        if (use && !use_field(f)) fail_msg("an accepted file cannot be used");
        sfield_free(f);
    } else if (f) fail_msg("output touched");
    assert_int_equal(l.live, 0);
    return r;
}

static int make_files(void **state)
{
    model m = model_soup(6, 0.5, 1);
    sfield_mesh mesh = mesh_of(&m);
    float radiance[36], points[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 }, normals[9] = { 0, 1, 0, 1, 0, 0, 0, 1, 0 };
    int i, k;
    (void)state;
    for (i = 0; i < 36; i++) radiance[i] = (float)(i % 5);
    for (k = 0; k < FILES; k++) {
        sfield_desc d = small_desc(k & 1 ? SFIELD_BASIS_HAAR : SFIELD_BASIS_SH);
        sfield_field *f = NULL;
        d.shell_count = 2;
        d.position_side = 2;
        d.cube_side = 4;
        d.bands = k & 1 ? 0 : 3;
        if (k == 6) d.logarithm = 1;
        if (k > 6) d.shard_begin = k == 7 || k == 9 ? 0 : 1;
        if (k > 6) d.shard_end = k == 7 ? 1 : 2;
        if (k == 2 || k == 3) {
            d.frame_count = 2;
            assert_int_equal(sfield_build_emissive(&d, &mesh, radiance, &f, NULL), SFIELD_OK);
        } else if (k == 4 || k == 5)
            assert_int_equal(sfield_build_self(&d, &mesh, AT(points, normals, 3), 0.01f, &f, NULL), SFIELD_OK);
        else assert_int_equal(sfield_build(&d, &mesh, &f, NULL), SFIELD_OK);
        files[k].size = sfield_bytes(f);
        files[k].data = (uint8_t *)malloc(files[k].size);
        assert_non_null(files[k].data);
        assert_int_equal(sfield_write(f, files[k].data, files[k].size), SFIELD_OK);
        assert_int_equal(sfield_write(f, files[k].data, files[k].size - 1), SFIELD_ERR_MEMORY);
        sfield_free(f);
    }
    model_free(&m);
    return 0;
}

static int free_files(void **state)
{
    int k;
    (void)state;
    for (k = 0; k < FILES; k++) free(files[k].data);
    return 0;
}

static void files_round_trip(void **state)
{
    int k;
    (void)state;
    for (k = 0; k < FILES; k++) {
        uint8_t *again = (uint8_t *)malloc(files[k].size);
        sfield_field *f;
        assert_int_equal(sfield_open(files[k].data, files[k].size, NULL, &f), SFIELD_OK);
        assert_int_equal(sfield_bytes(f), files[k].size);
        assert_int_equal(sfield_write(f, again, files[k].size), SFIELD_OK);
        assert_memory_equal(again, files[k].data, files[k].size);
        assert_true(use_field(f));
        sfield_free(f);
        free(again);
    }
}

/* One field from shards of these shells; the bytes are those of the whole. */
static void merge_case(sfield_desc d, const model *m, const float *radiance, const uint32_t *ends, size_t count)
{
    sfield_mesh mesh = mesh_of(m);
    sfield_field *part[8], *whole, *merged = NULL;
    uint8_t *a, *b;
    size_t i;
    assert_int_equal(radiance ? sfield_build_emissive(&d, &mesh, radiance, &whole, NULL)
                              : sfield_build(&d, &mesh, &whole, NULL), SFIELD_OK);
    for (i = 0; i < count; i++) {
        d.shard_begin = i ? ends[i - 1] : 0;
        d.shard_end = ends[i];
        assert_int_equal(radiance ? sfield_build_emissive(&d, &mesh, radiance, &part[i], NULL)
                                  : sfield_build(&d, &mesh, &part[i], NULL), SFIELD_OK);
    }
    assert_int_equal(sfield_merge((const sfield_field *const *)part, count, NULL, &merged), SFIELD_OK);
    assert_int_equal(sfield_bytes(merged), sfield_bytes(whole));
    a = (uint8_t *)malloc(sfield_bytes(whole));
    b = (uint8_t *)malloc(sfield_bytes(whole));
    sfield_write(whole, a, sfield_bytes(whole));
    sfield_write(merged, b, sfield_bytes(whole));
    assert_memory_equal(a, b, sfield_bytes(whole));
    sfield_free(merged);
    merged = NULL;
    if (count > 1) {        /* the last one missing, the first one missing, one twice, a whole field */
        const sfield_field *twice[2] = { part[0], part[0] }, *not_one[1] = { whole };
        float out[3 * 512], p[3] = { 1, 2, 3 };
        assert_int_equal(sfield_merge((const sfield_field *const *)part, count - 1, NULL, &merged),
                         SFIELD_ERR_MISMATCH);
        assert_int_equal(sfield_merge((const sfield_field *const *)part + 1, count - 1, NULL, &merged),
                         SFIELD_ERR_MISMATCH);
        assert_int_equal(sfield_merge(twice, 2, NULL, &merged), SFIELD_ERR_MISMATCH);
        assert_int_equal(sfield_merge(not_one, 1, NULL, &merged), SFIELD_ERR_MISMATCH);
        assert_int_equal(sfield_query(part[0], 1, p, 0, out), SFIELD_ERR_MISMATCH);
        d.radius = 3;           /* of another desc */
        sfield_free(part[count - 1]);
        assert_int_equal(radiance ? sfield_build_emissive(&d, &mesh, radiance, &part[count - 1], NULL)
                                  : sfield_build(&d, &mesh, &part[count - 1], NULL), SFIELD_OK);
        assert_int_equal(sfield_merge((const sfield_field *const *)part, count, NULL, &merged), SFIELD_ERR_MISMATCH);
        assert_null(merged);
    }
    for (i = 0; i < count; i++) sfield_free(part[i]);
    sfield_free(whole);
    free(a);
    free(b);
}

static void shards_merge_to_the_same_bytes(void **state)
{
    static const uint32_t one[1] = { 4 }, two[2] = { 3, 4 }, four[4] = { 1, 2, 3, 4 }, frames[3] = { 1, 5, 8 };
    model m = model_soup(6, 0.5, 1);
    float radiance[36];
    int i, haar;
    (void)state;
    for (i = 0; i < 36; i++) radiance[i] = (float)(i % 5);
    for (haar = 0; haar < 2; haar++) {
        sfield_desc d = small_desc(haar ? SFIELD_BASIS_HAAR : SFIELD_BASIS_SH);
        d.shell_count = 4;
        d.position_side = 3;
        d.cube_side = 8;
        d.bands = haar ? 0 : 3;
        merge_case(d, &m, NULL, one, 1);
        merge_case(d, &m, NULL, two, 2);
        merge_case(d, &m, NULL, four, 4);
        d.frame_count = 2;
        merge_case(d, &m, radiance, frames, 3);
        d.frame_count = 1;
        d.shard_begin = 2;
        d.shard_end = 5;        /* one beyond, none, and of a kind without shells */
        for (i = 0; i < 3; i++) {
            sfield_mesh mesh = mesh_of(&m);
            sfield_field *f = NULL;
            float p[3] = { 1, 0, 0 };
            assert_int_equal(i < 2 ? sfield_build(&d, &mesh, &f, NULL)
                                   : sfield_build_self(&d, &mesh, AT(p, p, 1), 0, &f, NULL),
                             SFIELD_ERR_DESC);
            assert_null(f);
            d.shard_end = i ? 1 : 2;
            d.shard_begin = i ? 0 : 2;
        }
    }
    model_free(&m);
}

static void every_truncation_is_refused(void **state)
{
    size_t tried = 0, n;
    int k;
    (void)state;
    for (k = 0; k < FILES; k++) {
        uint8_t *longer = (uint8_t *)calloc(files[k].size + 1, 1);
        for (n = 0; n < files[k].size; n++, tried++)
            if (try_file(files[k].data, n, 0) != SFIELD_ERR_FORMAT) fail_msg("file %d, %lu bytes", k, (unsigned long)n);
        memcpy(longer, files[k].data, files[k].size);
        assert_int_equal(try_file(longer, files[k].size + 1, 0), SFIELD_ERR_FORMAT);
        free(longer);
    }
    print_message("files: %lu truncations refused\n", (unsigned long)tried);
}

static void a_flipped_bit_of_the_header_is_refused_or_safe(void **state)
{
    size_t refused = 0, accepted = 0, bit;
    int k, mended;
    (void)state;
    for (k = 0; k < FILES; k++) {
        uint8_t *data = (uint8_t *)malloc(files[k].size);
        for (mended = 0; mended < 2; mended++)
            for (bit = 0; bit < 8 * sizeof(sfield__header); bit++) {
                sfield_result r;
                memcpy(data, files[k].data, files[k].size);
                data[bit / 8] ^= (uint8_t)(1u << bit % 8);
                if (mended && bit >= 96 && bit < 128) continue;
                if (mended) mend(data, files[k].size);
                r = try_file(data, files[k].size, mended);
                if (!mended) assert_int_equal(r, bit >= 32 && bit < 64 ? SFIELD_ERR_VERSION : SFIELD_ERR_FORMAT);
                if (r == SFIELD_OK) accepted++;
                else refused++;
            }
        free(data);
    }
    print_message("files: %lu header bits refused, %lu accepted (checksum mended) and used\n", (unsigned long)refused,
                  (unsigned long)accepted);
    assert_true(accepted > 0);
}

/* Scales and biases are bounded by what a build can make: 1e4 of what hides, 1e20 of what shines. */
static void numbers_that_no_build_makes_are_refused(void **state)
{
    static const float scales[] = { 9e23f, -9e23f, 1e21f, 1e5f, INFINITY, NAN };
    int k, i;
    (void)state;
    for (k = 0; k < FILES; k++) {
        const int haar = k & 1, shines = k == 2 || k == 3, self = k == 4 || k == 5;
        const uint32_t shells = self ? 0 : 2, samples = sfield__get_u32(files[k].data + 60);
        const size_t at = 128 + 4 * (size_t)(shells + (haar ? samples + 1 : 0));
        uint8_t *data = (uint8_t *)malloc(files[k].size);
        assert_non_null(data);
        for (i = 0; i < (int)(sizeof scales / sizeof *scales); i++) {
            uint32_t bits;
            memcpy(data, files[k].data, files[k].size);
            memcpy(&bits, &scales[i], 4);
            sfield__put_u32(data + at, bits);
            mend(data, files[k].size);
            assert_int_equal(try_file(data, files[k].size, 1), i == 3 && shines ? SFIELD_OK : SFIELD_ERR_FORMAT);
        }
        free(data);
    }
}

static void mutate(uint8_t *data, size_t size, uint64_t *seed)
{
    uint32_t n = 1 + rnd_below(seed, 4), i;
    for (i = 0; i < n; i++) {
        size_t at = rnd_below(seed, 3) ? rnd_below(seed, (uint32_t)size) : rnd_below(seed, 160);
        switch (rnd_below(seed, 5)) {
        case 0: data[at] ^= (uint8_t)(1u << rnd_below(seed, 8)); break;
        case 1: data[at] = (uint8_t)rnd_u32(seed); break;
        case 2: data[at] = rnd_below(seed, 2) ? 0xffu : 0u; break;
        case 3:
            at &= ~(size_t)3;
            sfield__put_u32(data + at, sfield__get_u32(data + at) + rnd_below(seed, 9) - 4u);
            break;
        default:
            at &= ~(size_t)3;
            memmove(data + at, data + (rnd_below(seed, (uint32_t)size) & ~3u), 4);
        }
    }
}

static void mutated_files_are_refused_or_usable(void **state)
{
    const char *more = getenv("SFIELD_MUTATIONS");
    long count = more ? atol(more) : 100000, i;
    uint64_t seed = 2025;
    size_t accepted = 0;
    (void)state;
    for (i = 0; i < count; i++) {
        const file *f = &files[i % FILES];
        static uint8_t data[1 << 16];
        assert_true(f->size <= sizeof data);
        memcpy(data, f->data, f->size);
        mutate(data, f->size, &seed);
        if (i & 16) {
            if (rnd_below(&seed, 4)) memcpy(data, f->data, 16);
            mend(data, f->size);
        }
        accepted += try_file(data, f->size, i % 8 == 0) == SFIELD_OK;
    }
    print_message("files: %ld mutations, %lu accepted\n", count, (unsigned long)accepted);
    assert_true(accepted > 100);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_round_trip),
        cmocka_unit_test(shards_merge_to_the_same_bytes),
        cmocka_unit_test(every_truncation_is_refused),
        cmocka_unit_test(a_flipped_bit_of_the_header_is_refused_or_safe),
        cmocka_unit_test(numbers_that_no_build_makes_are_refused),
        cmocka_unit_test(mutated_files_are_refused_or_usable),
    };
    return cmocka_run_group_tests(tests, make_files, free_files);
}
