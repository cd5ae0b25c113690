/* file_test - files of csm.h: round trips, every truncation, every flipped bit of the header, 100,000 seeded
   mutations (half with the checksum mended, so that the deeper checks are reached) and then every function on what was
   accepted. Every eighth of them is opened in place as well. */

#define COHSM_STATIC
#define CSM_IMPLEMENTATION
#include "csm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "util.h"
#include "making.h"
#include "use.h"

enum { FILES = 12 };

typedef struct file { uint8_t *data; size_t size; } file;

static file files[FILES];
static size_t tries;

static void mend(uint8_t *data, size_t size)
{
    cohsm__put_u32(data + 12, cohsm__crc32(0, data + 16, size - 16));
}

static file file_of(const cohsm_maps *maps)
{
    file f;
    cohsm_data(maps, &f.size);
    f.data = (uint8_t *)malloc(f.size);
    if (!f.data || cohsm_write(maps, f.data, f.size) != COHSM_OK) abort();
    return f;
}

/* All domains, orders, layers; constants, ranges, palettes and exact depths; a shard; more than a chunk. */
static int make_files(void **state)
{
    static const cohsm_domain_kind kinds[9] = { COHSM_DOMAIN_LATLONG,   COHSM_DOMAIN_OCTAHEDRAL, COHSM_DOMAIN_LINE,
                                                COHSM_DOMAIN_RECTANGLE, COHSM_DOMAIN_DISC,       COHSM_DOMAIN_SPHERE,
                                                COHSM_DOMAIN_VOLUME,    COHSM_DOMAIN_LIST,       COHSM_DOMAIN_TABLE };
    float where[12][4];
    uint64_t seed = 5;
    int k;
    (void)state;
    for (k = 0; k < 12; k++) {
        rnd_direction(&seed, where[k]);
        where[k][3] = 0;
    }
    for (k = 0; k < FILES; k++) {
        model m = k % 2 ? model_soup(40, 0.5, 3 + (uint64_t)k) : model_sphere(12, 8, 0.3);
        cohsm_mesh mesh = mesh_of(&m);
        cohsm_desc d = desc_of(kinds[k % 9], k % 9 == 6 ? 3 : 7, 6 + (uint32_t)(k % 3));
        cohsm_maps *maps;
        d.order = (cohsm_order)(1 + k % 4);
        d.layers = (cohsm_layers)(1 + k % 3);
        d.depth_bits = 4 + (uint32_t)(k % 5);
        d.orientation = (cohsm_orientation)(1 + k % 3);
        place_domain(&d, -1, 1.5f, -1, 2);
        if (k % 9 == 7 || k % 9 == 8) {
            d.domain.locations = where[0];
            d.domain.location_count = 12;
            d.domain.side[0] = 4;
            d.domain.side[1] = 3;
        }
        if (k == 9) {
            d.pixel_begin = 5;
            d.pixel_end = 23;
            d.domain.side[0] = d.domain.side[1] = 40;
        }
        if (k == 10) {
            d.domain.side[0] = d.domain.side[1] = 260;
            d.map_side = 4;
            d.order = COHSM_ORDER_HILBERT;
            d.pixel_begin = 5;
            d.pixel_end = 7;
        }
        if (cohsm_build(&d, &mesh, &maps, NULL) != COHSM_OK) return -1;
        files[k] = file_of(maps);
        cohsm_free(maps);
        model_free(&m);
    }
    return 0;
}

static int free_files(void **state)
{
    int k;
    (void)state;
    for (k = 0; k < FILES; k++) free(files[k].data);
    return 0;
}

/* What a file is worth where it lies is what it is worth as a copy. */
static void try_in_place(const uint8_t *data, size_t size, int use, cohsm_result copied)
{
    uint8_t *room = (uint8_t *)malloc(size + 64), *at = room + (64 - (uintptr_t)room % 64);
    cohsm_open_desc desc;
    cohsm_maps *maps = NULL;
    cohsm_result result;

    assert_non_null(room);
    memcpy(at, data, size);
    memset(&desc, 0, sizeof desc);
    desc.in_place = 1;
    result = cohsm_open_file(&desc, at, size, &maps);
    if (result != copied) fail_msg("in place %d, copied %d", (int)result, (int)copied);
    if (result == COHSM_OK && use && !use_maps(maps)) fail_msg("an accepted file in place gave a wrong answer");
    cohsm_free(maps);
    free(room);
}

/* Exactly size bytes, so that a sanitizer sees a read beyond; any address. Nothing may leak, and no more may be asked
   for than promised. */
static cohsm_result try_file(const uint8_t *data, size_t size, int use)
{
    uint8_t *copy = (uint8_t *)malloc(size + 1);
    cohsm_maps *maps = (cohsm_maps *)(void *)files;
    cohsm_desc services;
    cohsm_result result;
    ledger l;

    assert_non_null(copy);
    memcpy(copy + 1, data, size);
    memset(&services, 0, sizeof services);
    services.system.allocator = ledger_allocator(&l);
    result = cohsm_open(copy + 1, size, &services.system, &maps);
    free(copy);
    if (l.peak > 64 * size)
        fail_msg("%lu bytes asked for by a file of %lu", (unsigned long)l.peak, (unsigned long)size);
    if (result == COHSM_OK) {
        if (use && !use_maps(maps)) fail_msg("an accepted file gave a wrong answer");
        cohsm_free(maps);
    } else assert_ptr_equal(maps, files);
    assert_int_equal(l.live, 0);
    assert_int_equal(l.wrong, 0);
    if (++tries % 8 == 0) try_in_place(data, size, use, result);
    return result;
}

static void files_round_trip(void **state)
{
    int k;
    (void)state;
    for (k = 0; k < FILES; k++) {
        cohsm_maps *maps, *again;
        file f;
        size_t size;
        uint8_t small[4];
        assert_int_equal(cohsm_open(files[k].data, files[k].size, NULL, &maps), COHSM_OK);
        f = file_of(maps);
        assert_int_equal(f.size, files[k].size);
        assert_memory_equal(f.data, files[k].data, f.size);
        if (cohsm__host_is_little_endian()) assert_memory_equal(cohsm_data(maps, &size), f.data, f.size);
        assert_int_equal(cohsm_write(maps, f.data, f.size - 1), COHSM_ERR_MEMORY);
        assert_int_equal(cohsm_write(maps, small, 0), COHSM_ERR_MEMORY);
        assert_int_equal(cohsm_open(f.data, f.size, NULL, &again), COHSM_OK);
        assert_true(use_maps(again));
        free(f.data);
        cohsm_free(maps);
        cohsm_free(again);
    }
}

static void every_truncation_is_refused(void **state)
{
    size_t tried = 0, n;
    int k;
    (void)state;
    for (k = 0; k < FILES; k++)
        for (n = 0; n < files[k].size; n += n < 600 ? 1 : 1 + files[k].size / (k == 10 ? 50 : 900)) {
            cohsm_result r = try_file(files[k].data, n, 0);
            if (r != COHSM_ERR_FORMAT)
                fail_msg("file %d, %lu of %lu bytes: %d", k, (unsigned long)n, (unsigned long)files[k].size, (int)r);
            tried++;
        }
    for (k = 0; k < FILES; k++)         /* the others from the file's own memory: a sanitizer sees less */
        for (n = 0; n < files[k].size; n++) {
            cohsm_maps *maps = NULL;
            cohsm_result r = cohsm_open(files[k].data, n, NULL, &maps);
            if (r != COHSM_ERR_FORMAT || maps)
                fail_msg("file %d, %lu of %lu bytes: %d", k, (unsigned long)n, (unsigned long)files[k].size, (int)r);
        }
    for (k = 0; k < FILES; k++) {       /* and one byte too many */
        uint8_t *longer = (uint8_t *)calloc(files[k].size + 1, 1);
        assert_non_null(longer);
        memcpy(longer, files[k].data, files[k].size);
        assert_int_equal(try_file(longer, files[k].size + 1, 0), COHSM_ERR_FORMAT);
        free(longer);
    }
    print_message("files: %lu truncations refused\n", (unsigned long)tried);
}

/* Without mending the checksum every flip is refused; with it, whatever is accepted must be safe. */
static void a_flipped_bit_of_the_header_is_refused_or_safe(void **state)
{
    size_t refused = 0, accepted = 0, bit;
    int k, mended;
    (void)state;
    for (k = 0; k < FILES; k++) {
        uint8_t *data = (uint8_t *)malloc(files[k].size);
        assert_non_null(data);
        for (mended = 0; mended < 2; mended++)
            for (bit = 0; bit < 8 * sizeof(cohsm__header); bit += k == 10 ? 13 : 1) {      /* file 10 is long */
                cohsm_result r;
                memcpy(data, files[k].data, files[k].size);
                data[bit / 8] ^= (uint8_t)(1u << bit % 8);
                if (mended) mend(data, files[k].size);
                if (mended && bit >= 96 && bit < 128) continue;          /* the checksum itself */
                r = try_file(data, files[k].size, mended);
                if (!mended && bit >= 32 && bit < 64) assert_int_equal(r, COHSM_ERR_VERSION);
                else if (!mended) assert_int_equal(r, COHSM_ERR_FORMAT);
                if (r == COHSM_OK) accepted++;
                else refused++;
            }
        free(data);
    }
    print_message("files: %lu header bits refused, %lu accepted (checksum mended) and used\n", (unsigned long)refused,
                  (unsigned long)accepted);
}

static void mutate(uint8_t *data, size_t size, uint64_t *seed)
{
    uint32_t n = 1 + rnd_below(seed, 4), i;
    for (i = 0; i < n; i++) {
        size_t at = rnd_below(seed, 4) ? rnd_below(seed, (uint32_t)size) : rnd_below(seed, 384);
        uint32_t word;
        switch (rnd_below(seed, 5)) {
        case 0: data[at] ^= (uint8_t)(1u << rnd_below(seed, 8)); break;
        case 1: data[at] = (uint8_t)rnd_u32(seed); break;
        case 2: data[at] = rnd_below(seed, 2) ? 0xffu : 0u; break;
        case 3:                                             /* a whole word, small changes and large ones */
            at &= ~(size_t)3;
            word = cohsm__get_u32(data + at) + rnd_below(seed, 9) - 4u;
            cohsm__put_u32(data + at, word);
            break;
        default:                                            /* a word from elsewhere */
            at &= ~(size_t)3;
            memmove(data + at, data + (rnd_below(seed, (uint32_t)size) & ~3u), 4);
        }
    }
}

static void mutated_files_are_refused_or_usable(void **state)
{
    const char *more = getenv("CSM_MUTATIONS");
    long count = more ? atol(more) : 100000, i;
    uint64_t seed = 2024;
    size_t accepted = 0;
    (void)state;
    for (i = 0; i < count; i++) {
        const file *f = &files[i % FILES];
        size_t size = f->size;
        uint8_t *data;
        if (size > 60000) f = &files[0], size = f->size;
        data = (uint8_t *)malloc(size);
        assert_non_null(data);
        memcpy(data, f->data, size);
        mutate(data, size, &seed);
        if (i & 16) {
            if (rnd_below(&seed, 4)) {                      /* past the first checks too */
                memcpy(data, f->data, 12);
                mend(data, size);
            } else mend(data, size);
        }
        accepted += try_file(data, size, 1) == COHSM_OK;
        free(data);
    }
    print_message("files: %ld mutations, %lu accepted and used\n", count, (unsigned long)accepted);
    assert_true(accepted > 100);
}

/* ---- what single defects were ---- */

/* Is there a list at all? *lookup_at = word where the lookup begins. */
static int has_list(const uint8_t *data, uint32_t *lookup_at)
{
    cohsm__header h;
    uint32_t i, at;
    memcpy(&h, data, sizeof h);
    at = COHSM__HEADER_WORDS + h.order_words + h.location_words;
    *lookup_at = at;
    for (i = 0; i < h.lookup_words; i++) {
        uint32_t entry = cohsm__get_u32(data + 4 * (size_t)(at + i));
        if (!(entry & COHSM__CONSTANT)) return 1;
    }
    return 0;
}

static void lists_in_another_order_are_refused_or_safe(void **state)
{
    int k;
    (void)state;
    if (!cohsm__host_is_little_endian()) {
        print_message("skip: reads the header as the host does\n");
        skip();
    }
    for (k = 0; k < FILES; k++) {
        uint8_t *data = (uint8_t *)malloc(files[k].size);
        uint32_t at, i, n, first = 0, last = 0;
        cohsm__header h;
        assert_non_null(data);
        memcpy(data, files[k].data, files[k].size);
        memcpy(&h, data, sizeof h);
        if (has_list(data, &at)) {
            n = h.lookup_words;
            for (i = 0; i < n; i++)
                if (!(cohsm__get_u32(data + 4 * (size_t)(at + i)) & COHSM__CONSTANT)) {
                    if (!first) first = at + i;
                    last = at + i;
                }
            for (i = 0; i < 4; i++) {                       /* the first list and the last one change places */
                uint8_t t = data[4 * (size_t)first + i];
                data[4 * (size_t)first + i] = data[4 * (size_t)last + i];
                data[4 * (size_t)last + i] = t;
            }
            mend(data, files[k].size);
            (void)try_file(data, files[k].size, 1);
        }
        free(data);
    }
}

/* A small file that stands for 2^24 views: one pixel of a long, thin domain. */
static void small_files_of_many_views_open_in_little_memory(void **state)
{
    static const cohsm_domain_kind kinds[3] = { COHSM_DOMAIN_LATLONG, COHSM_DOMAIN_OCTAHEDRAL, COHSM_DOMAIN_RECTANGLE };
    int k;
    (void)state;
    for (k = 0; k < 3; k++) {
        model m = model_cube(0.2, 0);
        cohsm_mesh mesh = mesh_of(&m);
        cohsm_desc d = desc_of(kinds[k], 8, 8);
        cohsm_maps *maps;
        cohsm__header h;
        file f;
        uint32_t i;
        d.center[0] = 0.5f;                 /* pixel 0 sees nothing: one constant entry */
        d.radius = 10;
        d.order = COHSM_ORDER_SCANLINE;
        d.pixel_end = 1;
        place_domain(&d, -1, 1.5f, -1, 2);
        assert_int_equal(cohsm_build(&d, &mesh, &maps, NULL), COHSM_OK);
        f = file_of(maps);
        for (i = 0; i + 4 <= sizeof h; i += 4) ((uint32_t *)(void *)&h)[i / 4] = cohsm__get_u32(f.data + i);
        for (i = 0; i < 2; i++) {
            h.side[0] = i ? 65535 : 1u << 24;
            h.side[1] = i ? 256 : 1;
            h.map_count = h.side[0] * h.side[1];
            h.view_count = h.map_count * (h.positional ? 6 : 1);
            for (uint32_t w = 0; w < COHSM__HEADER_WORDS; w++)
                cohsm__put_u32(f.data + 4 * w, ((uint32_t *)(void *)&h)[w]);
            mend(f.data, f.size);
            (void)try_file(f.data, f.size, 0);
        }
        free(f.data);
        cohsm_free(maps);
        model_free(&m);
    }
}

/* Returns a file at M = 1024 with as many lookup entries as asked for. The first of them names the longest list of the
   maps, as do all others if `again` is set; else these are constants. */
static file many_entries(const cohsm_maps *maps, uint32_t entries, int again)
{
    cohsm__header h = maps->head;
    uint32_t longest = 0, before = (uint32_t)COHSM__HEADER_WORDS + h.order_words + h.location_words, i, *words;
    uint32_t at = before + entries, padding = (0u - (at + h.directory_words)) % COHSM__BLOCK_WORDS;
    file f;
    for (i = 0; i < h.lookup_words; i++) {
        if (maps->lookup[i] & COHSM__CONSTANT) continue;
        if (cohsm__block_count(maps->directories + maps->lookup[i]) > cohsm__block_count(maps->directories + longest))
            longest = maps->lookup[i];
    }
    h.map_side = 1024;
    h.pixel_begin = 0;
    h.pixel_end = h.lookup_words = entries;
    h.words = at + h.directory_words + padding + h.line_words;
    f.size = 4 * (size_t)h.words;
    f.data = (uint8_t *)calloc(1, f.size);
    words = (uint32_t *)(void *)f.data;
    if (!words) abort();
    memcpy(words + at, maps->directories, 4 * (size_t)h.directory_words);
    memcpy(words + at + h.directory_words + padding, maps->lines, 4 * (size_t)h.line_words);
    h.directory_words += padding;
    memcpy(words, &h, sizeof h);
    memcpy(words + COHSM__HEADER_WORDS, maps->words + COHSM__HEADER_WORDS,
           4 * ((size_t)h.order_words + h.location_words));
    for (i = 0; i < entries; i++) words[before + i] = i == 0 || again ? longest : COHSM__CONSTANT | COHSM__INFINITE;
    for (i = 0; i < h.words; i++) cohsm__put_u32(f.data + 4 * (size_t)i, words[i]);
    mend(f.data, f.size);
    return f;
}

/* Entries that all name the longest list would have it checked once for each: time that grows with the square. No
   builder shares a list, so such a file is refused as soon as it has named more words than there are. */
static void a_list_is_checked_for_one_entry_only(void **state)
{
    enum { ENTRIES = 100000 };
    cohsm_maps *maps = torture_maps(COHSM_LAYOUT_COMPACT);
    file sound = many_entries(maps, ENTRIES, 0), hostile = many_entries(maps, ENTRIES, 1);
    (void)state;
    assert_int_equal(try_file(sound.data, sound.size, 0), COHSM_OK);
    assert_int_equal(try_file(hostile.data, hostile.size, 0), COHSM_ERR_FORMAT);
    free(sound.data);
    free(hostile.data);
    cohsm_free(maps);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_round_trip),
        cmocka_unit_test(every_truncation_is_refused),
        cmocka_unit_test(a_flipped_bit_of_the_header_is_refused_or_safe),
        cmocka_unit_test(mutated_files_are_refused_or_usable),
        cmocka_unit_test(lists_in_another_order_are_refused_or_safe),
        cmocka_unit_test(small_files_of_many_views_open_in_little_memory),
        cmocka_unit_test(a_list_is_checked_for_one_entry_only),
    };
    return cmocka_run_group_tests(tests, make_files, free_files);
}
