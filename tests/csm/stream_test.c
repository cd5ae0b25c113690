/* stream_test - files in place, budgets at opening, and streams of more objects than memory holds. */

#define _DEFAULT_SOURCE
#define COHSM_STATIC
#define CSM_IMPLEMENTATION
#include "csm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "util.h"
#include "making.h"
#include "use.h"
#if defined(__unix__) || defined(__APPLE__)
#include <sys/mman.h>
#include <unistd.h>
#endif

enum { OBJECTS = 40 };

/* A file at a multiple of 64 bytes, plain or packed. */
typedef struct file { void *memory; uint8_t *data; size_t size; } file;

static file plain[OBJECTS], packed[2];
static cohsm_maps *whole[OBJECTS];      /* of the same objects, in memory */
static char said[256];

static void remember(void *user, const char *message)
{
    (void)user;
    snprintf(said, sizeof said, "%s", message);
}

static file file_of_bytes(const void *bytes, size_t size)
{
    file f;
    f.memory = malloc(size + 64);
    if (!f.memory) abort();
    f.data = (uint8_t *)f.memory + (64 - (uintptr_t)f.memory % 64);
    f.size = size;
    memcpy(f.data, bytes, size);
    return f;
}

static void write_file(file *f, const cohsm_maps *maps)
{
    cohsm_info info;
    void *bytes;
    cohsm_get_info(maps, &info);
    bytes = malloc(info.bytes);
    if (!bytes || cohsm_write(maps, bytes, info.bytes) != COHSM_OK) abort();
    *f = file_of_bytes(bytes, info.bytes);
    free(bytes);
}

static int make_objects(void **state)
{
    int i;
    (void)state;
    for (i = 0; i < OBJECTS; i++) {
        model m = i % 3 ? model_sphere(10 + (uint32_t)i % 5, 7, 0.3) : model_soup(30, 0.4, 7 + (uint64_t)i);
        cohsm_desc d = desc_of(i % 4 ? COHSM_DOMAIN_LATLONG : COHSM_DOMAIN_OCTAHEDRAL, 16, 16 + 2 * (uint32_t)(i % 5));
        d.order = i % 2 ? COHSM_ORDER_HILBERT : COHSM_ORDER_ZIGZAG;
        d.orientation = COHSM_ORIENTATION_POLAR;
        whole[i] = build(&d, &m);
        write_file(&plain[i], whole[i]);
        model_free(&m);
    }
    for (i = 0; i < 2; i++) {
        void *bytes;
        size_t size;
        if (cohsm_pack(whole[i], NULL, &bytes, &size) != COHSM_OK) return -1;
        packed[i] = file_of_bytes(bytes, size);
        free(bytes);
    }
    return 0;
}

static int free_objects(void **state)
{
    int i;
    (void)state;
    for (i = 0; i < OBJECTS; i++) {
        cohsm_free(whole[i]);
        free(plain[i].memory);
    }
    for (i = 0; i < 2; i++) free(packed[i].memory);
    return 0;
}

static cohsm_open_desc opening(ledger *l, int in_place, size_t budget)
{
    cohsm_open_desc d;
    memset(&d, 0, sizeof d);
    d.system.allocator = ledger_allocator(l);
    d.system.log = remember;
    d.in_place = in_place;
    d.budget_bytes = budget;
    said[0] = 0;
    return d;
}

/* ---- one file ---- */

static void a_file_in_place_is_read_where_it_lies(void **state)
{
    const size_t block = plain[1].size;
    uint8_t *before = (uint8_t *)malloc(block);
    cohsm_open_desc d;
    cohsm_maps *maps = NULL;
    cohsm_info info;
    size_t bytes;
    ledger l;
    (void)state;
    if (!cohsm__host_is_little_endian()) {
        free(before);
        print_message("skip: files are copied here\n");
        skip();
    }
    assert_non_null(before);
    memcpy(before, plain[1].data, block);
    d = opening(&l, 1, 0);
    assert_int_equal(cohsm_open_file(&d, plain[1].data, block, &maps), COHSM_OK);
    assert_ptr_equal(cohsm_data(maps, &bytes), plain[1].data);
    assert_int_equal(bytes, block);
    cohsm_get_info(maps, &info);
    assert_int_equal(info.memory_bytes, l.used);
    assert_int_equal(l.used, l.peak);
    assert_true(l.used < sizeof(cohsm_maps) + 8 * 32 + 1);          /* cosines and sines of 16 + 16 angles */
    assert_true(use_maps(maps));
    cohsm_free(maps);
    assert_int_equal(l.live, 0);
    assert_memory_equal(before, plain[1].data, block);
    d = opening(&l, 0, 0);
    assert_int_equal(cohsm_open_file(&d, plain[1].data, block, &maps), COHSM_OK);
    cohsm_get_info(maps, &info);
    assert_int_equal(info.memory_bytes, l.used);
    assert_true(l.used >= block + 64);
    cohsm_free(maps);
    assert_int_equal(l.live, 0);
    free(before);
}

/* A packed file in place is decoded, wherever it lies; a plain one must lie at a multiple of 64 bytes. */
static void files_in_place_lie_at_multiples_of_64_bytes(void **state)
{
    uint8_t *moved = (uint8_t *)malloc(plain[0].size + 132);
    uint8_t *at = moved + (64 - (uintptr_t)moved % 64) + 4;
    cohsm_open_desc d;
    cohsm_maps *maps = NULL;
    ledger l;
    (void)state;
    assert_non_null(moved);
    memcpy(at, plain[0].data, plain[0].size);
    d = opening(&l, 1, 0);
    if (cohsm__host_is_little_endian()) {
        assert_int_equal(cohsm_open_file(&d, at, plain[0].size, &maps), COHSM_ERR_MEMORY);
        assert_string_equal(said, "cohsm_open_file: data is not at a multiple of 64 bytes");
        assert_null(maps);
        assert_int_equal(l.calls, 0);
    }
    memcpy(at, packed[0].data, packed[0].size);
    assert_int_equal(cohsm_open_file(&d, at, packed[0].size, &maps), COHSM_OK);
    free(moved);                                                    /* nothing of it is needed any more */
    assert_true(use_maps(maps));
    cohsm_free(maps);
    assert_int_equal(l.live, 0);
}

#if defined(__unix__) || defined(__APPLE__)
/* The file ends where the next page, which nobody may read, begins: at 16 bytes past a multiple of 64, so that 48 bytes
   are left to be read in vain. */
static void no_query_reads_beyond_the_line_in_which_a_file_ends(void **state)
{
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    int i;
    (void)state;
    for (i = 0; i < OBJECTS; i++) {
        const size_t lines = (plain[i].size + 63) / 64 * 64, pages = (lines + page - 1) / page;
        uint8_t *room = (uint8_t *)mmap(NULL, (pages + 1) * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS,
                                        -1, 0);
        uint8_t *at;
        cohsm_open_desc d;
        cohsm_maps *maps = NULL;
        ledger l;
        assert_true(room != (uint8_t *)MAP_FAILED);
        at = room + pages * page - lines;
        memcpy(at, plain[i].data, plain[i].size);
        assert_int_equal(mprotect(room, pages * page, PROT_READ), 0);       /* and nobody writes to it */
        assert_int_equal(mprotect(room + pages * page, page, PROT_NONE), 0);
        d = opening(&l, 1, 0);
        assert_int_equal(cohsm_open_file(&d, at, plain[i].size, &maps), COHSM_OK);
        assert_true(use_maps(maps));
        cohsm_free(maps);
        assert_int_equal(munmap(room, (pages + 1) * page), 0);
    }
}
#endif

/* The least budget with which a file opens is what the log names, and no more is asked for. */
static void a_budget_bounds_what_a_file_may_take(void **state)
{
    int k;
    (void)state;
    for (k = 0; k < 3; k++) {
        const file *f = k < 2 ? &plain[1] : &packed[1];
        cohsm_open_desc d;
        cohsm_maps *maps = NULL;
        const char *least;
        size_t needed;
        ledger l;
        d = opening(&l, k == 1, 1);
        assert_int_equal(cohsm_open_file(&d, f->data, f->size, &maps), COHSM_ERR_LIMIT);
        assert_int_equal(l.calls, 0);
        assert_null(maps);
        least = strstr(said, "at least ");
        assert_non_null(least);
        needed = (size_t)strtoul(least + 9, NULL, 10);
        d = opening(&l, k == 1, needed - 1);
        assert_int_equal(cohsm_open_file(&d, f->data, f->size, &maps), COHSM_ERR_LIMIT);
        assert_int_equal(l.calls, 0);
        d = opening(&l, k == 1, needed);
        assert_int_equal(cohsm_open_file(&d, f->data, f->size, &maps), COHSM_OK);
        assert_true(l.peak <= needed);
        if (k < 2) assert_int_equal(l.peak, needed);
        cohsm_free(maps);
        assert_int_equal(l.live, 0);
    }
}

static void trays_stay_within_the_budget(void **state)
{
    cohsm_open_desc d;
    cohsm_maps *maps = NULL;
    cohsm_info info;
    size_t both;
    ledger l;
    (void)state;
    d = opening(&l, 0, 0);
    d.layout = COHSM_LAYOUT_FAST;
    assert_int_equal(cohsm_open_file(&d, plain[1].data, plain[1].size, &maps), COHSM_OK);
    cohsm_get_info(maps, &info);
    assert_int_equal(info.memory_bytes, l.used);
    assert_true(info.fast_bytes > 0);
    both = info.memory_bytes;
    cohsm_free(maps);
    d = opening(&l, 0, both);
    d.layout = COHSM_LAYOUT_FAST;
    assert_int_equal(cohsm_open_file(&d, plain[1].data, plain[1].size, &maps), COHSM_OK);
    cohsm_free(maps);
    d = opening(&l, 0, both - 1);
    d.layout = COHSM_LAYOUT_FAST;
    maps = NULL;
    assert_int_equal(cohsm_open_file(&d, plain[1].data, plain[1].size, &maps), COHSM_ERR_LIMIT);
    assert_null(maps);
    assert_int_equal(l.live, 0);
    d.layout = COHSM_LAYOUT_BUDGET;
    d.layout_bytes = (size_t)1 << 30;
    assert_int_equal(cohsm_open_file(&d, plain[1].data, plain[1].size, &maps), COHSM_OK);
    cohsm_get_info(maps, &info);
    assert_int_equal(info.layout, COHSM_LAYOUT_COMPACT);
    cohsm_free(maps);
    assert_int_equal(l.live, 0);
}

/* A file's header says what the opened maps say. */
static void a_file_tells_its_facts_before_it_is_opened(void **state)
{
    int i;
    (void)state;
    for (i = 0; i < 4; i++) {
        const file *f = i < 2 ? &plain[i] : &packed[i - 2];
        cohsm_info told, known;
        cohsm_maps *maps = NULL;
        memset(&told, 0xff, sizeof told);
        memset(&known, 0xff, sizeof known);
        assert_int_equal(cohsm_file_info(f->data, f->size, NULL, &told), COHSM_OK);
        assert_int_equal(cohsm_open(f->data, f->size, NULL, &maps), COHSM_OK);
        cohsm_get_info(maps, &known);
        assert_memory_equal(&told, &known, sizeof told);
        assert_int_equal(cohsm_file_info(f->data, f->size - 1, NULL, &told), COHSM_ERR_FORMAT);
        cohsm_free(maps);
    }
}

/* A packed file whose header asks for a list of 2^32 - 1 segments is a damaged one, whatever the budget. */
static void a_packed_file_that_promises_too_much_is_damaged(void **state)
{
    uint8_t *bytes = (uint8_t *)malloc(packed[0].size);
    cohsm_open_desc d;
    cohsm_maps *maps = NULL;
    cohsm_info info;
    ledger l;
    (void)state;
    assert_non_null(bytes);
    memcpy(bytes, packed[0].data, packed[0].size);
    memset(bytes + 12, 0xff, 4);
    assert_int_equal(cohsm_open(bytes, packed[0].size, NULL, &maps), COHSM_ERR_FORMAT);
    d = opening(&l, 0, 1000);
    assert_int_equal(cohsm_open_file(&d, bytes, packed[0].size, &maps), COHSM_ERR_FORMAT);
    assert_int_equal(l.calls, 0);
    assert_int_equal(cohsm_file_info(bytes, packed[0].size, NULL, &info), COHSM_ERR_FORMAT);
    assert_null(maps);
    free(bytes);
}

static void bad_openings_are_named(void **state)
{
    cohsm_open_desc d;
    cohsm_info info;
    cohsm_maps *maps = NULL;
    ledger l;
    (void)state;
    d = opening(&l, 0, 0);
    assert_int_equal(cohsm_open_file(&d, NULL, 4, &maps), COHSM_ERR_ARGUMENT);
    assert_string_equal(said, "cohsm_open_file: data is NULL");
    assert_int_equal(cohsm_open_file(&d, plain[0].data, plain[0].size, NULL), COHSM_ERR_ARGUMENT);
    assert_string_equal(said, "cohsm_open_file: out is NULL");
    assert_int_equal(cohsm_open_file(NULL, plain[0].data, plain[0].size, &maps), COHSM_OK);
    cohsm_free(maps);
    maps = NULL;
    d.layout = (cohsm_layout)COHSM_LAYOUT_COUNT;
    assert_int_equal(cohsm_open_file(&d, plain[0].data, plain[0].size, &maps), COHSM_ERR_DESC);
    d.layout = COHSM_LAYOUT_COMPACT;
    assert_int_equal(cohsm_open_file(&d, said, 9, &maps), COHSM_ERR_FORMAT);
    assert_string_equal(said, "cohsm_open_file: data is no file of csm.h, or a damaged one");
    d.system.allocator.free_fn = NULL;
    assert_int_equal(cohsm_open_file(&d, plain[0].data, plain[0].size, &maps), COHSM_ERR_DESC);
    assert_int_equal(cohsm_file_info(NULL, 4, &d.system, &info), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_file_info(plain[0].data, plain[0].size, &d.system, NULL), COHSM_ERR_ARGUMENT);
    assert_null(maps);
}

/* ---- streams ---- */

typedef struct shelf {                  /* where a stream of these tests takes its files from */
    int    out[OBJECTS];                /* how often each file is out */
    size_t calls;
    long   refuse;                      /* the object that has no file; -1 = none */
    const file *instead;                /* what object 5 has instead, unless NULL */
} shelf;

static int take_file(void *user, uint32_t object, const void **data, size_t *bytes)
{
    shelf *s = (shelf *)user;
    const file *f = object == 5 && s->instead ? s->instead : &plain[object];
    s->calls++;
    if ((long)object == s->refuse) return 1;
    s->out[object]++;
    *data = f->data;
    *bytes = f->size;
    return 0;
}

static void give_file_back(void *user, uint32_t object, const void *data, size_t bytes)
{
    shelf *s = (shelf *)user;
    const file *f = object == 5 && s->instead ? s->instead : &plain[object];
    assert_ptr_equal(data, f->data);
    assert_int_equal(bytes, f->size);
    s->out[object]--;
}

static cohsm_stream_desc stream_of(shelf *s, ledger *l, int in_place, size_t budget)
{
    cohsm_stream_desc d;
    memset(&d, 0, sizeof d);
    memset(s, 0, sizeof *s);
    s->refuse = -1;
    d.system.allocator = ledger_allocator(l);
    d.system.log = remember;
    d.object_count = OBJECTS;
    d.budget_bytes = budget;
    d.in_place = in_place;
    d.load_fn = take_file;
    d.unload_fn = give_file_back;
    d.user = s;
    said[0] = 0;
    return d;
}

/* What all objects take together. */
static size_t all_bytes(void)
{
    size_t sum = 0;
    int i;
    for (i = 0; i < OBJECTS; i++) {
        cohsm_info info;
        cohsm_get_info(whole[i], &info);
        sum += info.memory_bytes;
    }
    return sum;
}

/* The rule as arrays: of those in memory that nobody holds, the one whose last hold ended first leaves. */
typedef struct rule { size_t bytes[OBJECTS], in_use; unsigned holds[OBJECTS]; uint64_t ended[OBJECTS], now; } rule;

/* Lets objects leave until `need` bytes fit; returns how many left. */
static unsigned leave(rule *r, int *there, size_t need, size_t budget)
{
    unsigned left = 0;
    while (r->in_use + need > budget) {
        int i, first = -1;
        for (i = 0; i < OBJECTS; i++)
            if (there[i] && !r->holds[i] && (first < 0 || r->ended[i] < r->ended[first])) first = i;
        assert_true(first >= 0);
        there[first] = 0;
        r->in_use -= r->bytes[first];
        left++;
    }
    return left;
}

static void end_hold(rule *r, cohsm_stream *s, uint32_t object)
{
    cohsm_stream_end(s, object);
    if (--r->holds[object] == 0) r->ended[object] = ++r->now;
}

static void the_object_whose_last_hold_ended_first_leaves_first(void **state)
{
    const size_t budget = all_bytes() / 4;
    int there[OBJECTS] = { 0 };
    uint64_t seed = 11, loads = 0, hits = 0, left = 0, refused = 0;
    uint32_t n, i;
    cohsm_stream_stats info;
    cohsm_stream_desc d;
    cohsm_stream *s = NULL;
    shelf files;
    ledger l;
    rule r;
    (void)state;
    memset(&r, 0, sizeof r);
    for (i = 0; i < OBJECTS; i++) {
        cohsm_info of;
        cohsm_get_info(whole[i], &of);
        r.bytes[i] = of.memory_bytes;
    }
    d = stream_of(&files, &l, 0, budget);
    assert_int_equal(cohsm_stream_create(&d, &s), COHSM_OK);
    for (n = 0; n < 3000; n++) {
        const uint32_t object = rnd_below(&seed, 3) ? rnd_below(&seed, OBJECTS / 3) : rnd_below(&seed, OBJECTS);
        const cohsm_maps *maps = NULL;
        size_t need = there[object] ? 0 : r.bytes[object], held = 0;
        if (r.holds[object] && rnd_below(&seed, 2)) {
            end_hold(&r, s, object);
            continue;
        }
        for (i = 0; i < OBJECTS; i++) held += there[i] && r.holds[i] ? r.bytes[i] : 0;
        if (need && held + need > budget) {         /* nothing leaves; then all holds end */
            assert_int_equal(cohsm_stream_use(s, object, &maps), COHSM_ERR_LIMIT);
            assert_null(maps);
            refused++;
            for (i = 0; i < OBJECTS; i++)
                while (r.holds[i]) end_hold(&r, s, i);
            continue;
        }
        assert_int_equal(cohsm_stream_use(s, object, &maps), COHSM_OK);
        if (there[object]) hits++;
        else {
            loads++;
            left += leave(&r, there, need, budget);
            r.in_use += need;
            there[object] = 1;
        }
        r.holds[object]++;
        if (rnd_below(&seed, 4)) end_hold(&r, s, object);
        if (cohsm__host_is_little_endian())
            assert_memory_equal(cohsm_data(maps, NULL), plain[object].data, plain[object].size);
        cohsm_stream_get_stats(s, &info);
        for (i = 0; i < OBJECTS; i++) {
            info.objects -= (uint32_t)there[i];
            info.held -= r.holds[i] > 0;
        }
        assert_true(info.objects == 0 && info.held == 0);
        assert_true(info.bytes == r.in_use && info.bytes <= budget && info.peak_bytes <= budget);
        assert_true(info.hits == hits && info.loads == loads && info.evictions == left);
    }
    print_message("streams: %lu hits, %lu loads, %lu objects left, %lu refused\n", (unsigned long)hits,
                  (unsigned long)loads, (unsigned long)left, (unsigned long)refused);
    assert_true(hits > 300 && left > 300 && refused > 3);
    cohsm_stream_free(s);
    assert_int_equal(l.live, 0);
    for (i = 0; i < OBJECTS; i++) assert_int_equal(files.out[i], 0);
}

static int take_packed(void *user, uint32_t object, const void **data, size_t *bytes)
{
    (void)user;
    *data = packed[object].data;
    *bytes = packed[object].size;
    return 0;
}

/* What decoding takes counts, too: the least budget is what the log names, and no more than that and the stream's own
   is ever asked for. in_place changes nothing. */
static void packed_files_are_decoded_within_the_budget(void **state)
{
    int in_place;
    (void)state;
    for (in_place = 0; in_place < 2; in_place++) {
        const cohsm_maps *maps = NULL;
        cohsm_stream_desc d;
        cohsm_stream_stats stats;
        cohsm_stream *s = NULL;
        const char *least;
        size_t needed, own, bytes, wanted;
        cohsm_info info;
        shelf files;
        ledger l;
        d = stream_of(&files, &l, in_place, 1);
        d.object_count = 2;
        d.load_fn = take_packed;
        d.unload_fn = NULL;
        assert_int_equal(cohsm_stream_create(&d, &s), COHSM_OK);
        assert_int_equal(cohsm_stream_use(s, 1, &maps), COHSM_ERR_LIMIT);
        least = strstr(said, "objects[1] takes ");
        assert_non_null(least);
        needed = (size_t)strtoul(least + strlen("objects[1] takes "), NULL, 10);
        cohsm_stream_free(s);
        assert_int_equal(l.live, 0);
        d = stream_of(&files, &l, in_place, needed);
        d.object_count = 2;
        d.load_fn = take_packed;
        d.unload_fn = NULL;
        assert_int_equal(cohsm_stream_create(&d, &s), COHSM_OK);
        own = l.used;
        assert_int_equal(cohsm_stream_use(s, 1, &maps), COHSM_OK);
        assert_true(l.peak <= own + needed);
        cohsm_get_info(whole[1], &info);
        cohsm_stream_get_stats(s, &stats);
        assert_true(stats.peak_bytes == needed && stats.bytes == info.memory_bytes && needed > info.memory_bytes);
        wanted = info.bytes;
        assert_memory_equal(cohsm_data(maps, &bytes), cohsm_data(whole[1], NULL), wanted);
        assert_int_equal(bytes, wanted);
        cohsm_stream_free(s);
        assert_int_equal(l.live, 0);
    }
}

/* ---- scenes ---- */

enum { INSTANCES = 60, POINTS = 3000 };

static void make_scene(cohsm_instance *in_memory, cohsm_stream_instance *streamed, float *points, float *lights,
                       uint32_t *entities, double wide)
{
    uint64_t seed = 77;
    int i, k;
    for (i = 0; i < INSTANCES; i++) {
        streamed[i].object = rnd_below(&seed, OBJECTS);
        in_memory[i].maps = whole[streamed[i].object];
        placed(in_memory[i].transform, &seed, rnd_in(&seed, 0.4, 1.2));
        for (k = 0; k < 3; k++) in_memory[i].transform[12 + k] *= (float)wide;
        memcpy(streamed[i].transform, in_memory[i].transform, sizeof in_memory[i].transform);
    }
    for (i = 0; i < POINTS; i++) {
        for (k = 0; k < 3; k++) points[3 * i + k] = (float)rnd_in(&seed, -6, 6);
        rnd_direction(&seed, lights + 3 * i);
        entities[i] = rnd_below(&seed, INSTANCES + 9);
    }
}

/* Whatever the filter, the light and the order of loading: the same bits as with all objects in memory. */
static void a_streamed_scene_answers_as_one_in_memory(void **state)
{
    static float points[3 * POINTS], lights[3 * POINTS], far_lights[3 * POINTS], wanted[POINTS], got[POINTS];
    static uint32_t entities[POINTS];
    cohsm_instance in_memory[INSTANCES];
    cohsm_stream_instance streamed[INSTANCES];
    int place, kind, filter, own, i, dark = 0, in_place;
    (void)state;
    make_scene(in_memory, streamed, points, lights, entities, 1);
    for (i = 0; i < 3 * POINTS; i++) far_lights[i] = 9 * lights[i];
    for (in_place = 0; in_place < 2; in_place++) {
        cohsm_stream_desc d;
        cohsm_stream_stats info;
        cohsm_stream *s = NULL;
        shelf files;
        ledger l;
        size_t refused[2] = { 0, 0 };
        d = stream_of(&files, &l, in_place, all_bytes() / 4);
        assert_int_equal(cohsm_stream_create(&d, &s), COHSM_OK);
        for (place = 0; place < 18; place++) {
            cohsm_query q;
            kind = place % 2;
            filter = place / 2 % 3;
            own = place / 6;
            q = query_of(points, POINTS, kind ? far_lights : lights,
                         kind ? COHSM_LIGHT_POSITION : COHSM_LIGHT_DIRECTION, (cohsm_filter)filter);
            q.entities = own ? entities : NULL;
            q.one_light = own == 2;
            q.seed = (uint32_t)place;
            assert_int_equal(cohsm_visible_scene(in_memory, INSTANCES, &q, wanted, &refused[0]), COHSM_OK);
            assert_int_equal(cohsm_stream_visible_scene(s, streamed, INSTANCES, &q, got, &refused[1]), COHSM_OK);
            assert_memory_equal(got, wanted, sizeof got);
            assert_int_equal(refused[0], refused[1]);
            for (i = 0; i < POINTS; i++) dark += got[i] < 0.5f;
        }
        cohsm_stream_get_stats(s, &info);
        assert_true(info.held == 0 && info.evictions > 0 && info.peak_bytes <= all_bytes() / 4);
        if (!in_place) assert_true(l.peak <= all_bytes() / 4 + sizeof *s + (OBJECTS + 1) * sizeof(cohsm__object) +
                                                 POINTS * sizeof(float));
        cohsm_stream_free(s);
        assert_int_equal(l.live, 0);
        for (i = 0; i < OBJECTS; i++) assert_int_equal(files.out[i], 0);
    }
    assert_true(dark > POINTS && dark < 30 * POINTS);
}

/* Objects to which no way leads are not loaded any more once their spheres are known. */
static void objects_that_no_way_meets_stay_where_they_are(void **state)
{
    static const float point[3] = { 0, 0, 0 };
    static float up[3] = { 0, 1, 0 };
    cohsm_stream_instance row[OBJECTS];
    cohsm_stream_desc d;
    cohsm_stream_stats first, second;
    cohsm_stream *s = NULL;
    cohsm_query q = query_of(point, 1, up, COHSM_LIGHT_DIRECTION, COHSM_FILTER_NEAREST);
    float visible = -3;
    uint32_t i;
    shelf files;
    ledger l;
    (void)state;
    memset(row, 0, sizeof row);
    for (i = 0; i < OBJECTS; i++) {
        identity(row[i].transform);
        row[i].object = i;
        row[i].transform[12] = 8.0f * (float)i;         /* object 0 above the point, the others beside it */
        row[i].transform[13] = 4;
    }
    d = stream_of(&files, &l, 0, all_bytes() / 4);
    assert_int_equal(cohsm_stream_create(&d, &s), COHSM_OK);
    assert_int_equal(cohsm_stream_visible_scene(s, row, OBJECTS, &q, &visible, NULL), COHSM_OK);
    cohsm_stream_get_stats(s, &first);
    assert_true(first.loads == OBJECTS + 1 && files.calls == OBJECTS + 1);      /* object 0 had left again */
    for (i = 0; i < 5; i++)
        assert_int_equal(cohsm_stream_visible_scene(s, row, OBJECTS, &q, &visible, NULL), COHSM_OK);
    cohsm_stream_get_stats(s, &second);
    assert_true(second.loads == first.loads && second.hits == first.hits + 5);
    cohsm_stream_free(s);
    assert_int_equal(l.live, 0);
}

/* ---- what goes wrong ---- */

static void a_failed_load_leaves_answers_and_stream_as_they_were(void **state)
{
    static float points[3 * POINTS], lights[3 * POINTS], got[POINTS];
    static uint32_t entities[POINTS];
    static uint8_t broken_bytes[1 << 17];
    cohsm_instance in_memory[INSTANCES];
    cohsm_stream_instance streamed[INSTANCES];
    cohsm_stream_desc d;
    cohsm_stream *s = NULL;
    cohsm_query q;
    const cohsm_maps *maps = NULL;
    file broken, other;
    shelf files;
    ledger l;
    int i;
    (void)state;
    make_scene(in_memory, streamed, points, lights, entities, 1);
    streamed[3].object = 5;
    streamed[4].object = 6;
    q = query_of(points, POINTS, lights, COHSM_LIGHT_DIRECTION, COHSM_FILTER_NEAREST);
    d = stream_of(&files, &l, 1, all_bytes() / 4);
    assert_int_equal(cohsm_stream_create(&d, &s), COHSM_OK);
    for (i = 0; i < POINTS; i++) got[i] = -7;
    files.refuse = 6;
    assert_int_equal(cohsm_stream_visible_scene(s, streamed, INSTANCES, &q, got, NULL), COHSM_ERR_CANCELLED);
    assert_string_equal(said, "cohsm_stream_visible_scene: objects[6] has no file: desc.load_fn said so");
    files.refuse = -1;
    assert_true(plain[5].size < sizeof broken_bytes);
    memcpy(broken_bytes, plain[5].data, plain[5].size);
    broken_bytes[plain[5].size / 2] ^= 4;
    broken = file_of_bytes(broken_bytes, plain[5].size);
    other = file_of_bytes(plain[8].data, plain[8].size);
    cohsm_stream_free(s);
    assert_int_equal(cohsm_stream_create(&d, &s), COHSM_OK);
    files.instead = &broken;
    assert_int_equal(cohsm_stream_visible_scene(s, streamed, INSTANCES, &q, got, NULL), COHSM_ERR_FORMAT);
    assert_string_equal(said,
                        "cohsm_stream_visible_scene: objects[5] is no file of csm.h, or a damaged one");
    assert_int_equal(files.out[5], 0);
    files.instead = NULL;
    assert_int_equal(cohsm_stream_use(s, 5, &maps), COHSM_OK);
    cohsm_stream_end(s, 5);
    for (i = 10; i < OBJECTS; i++) {                    /* object 5 leaves, and comes back as another one */
        assert_int_equal(cohsm_stream_use(s, (uint32_t)i, &maps), COHSM_OK);
        cohsm_stream_end(s, (uint32_t)i);
    }
    assert_int_equal(files.out[5], 0);
    files.instead = &other;
    maps = NULL;
    assert_int_equal(cohsm_stream_use(s, 5, &maps), COHSM_ERR_INPUT);
    assert_string_equal(said, "cohsm_stream_use: objects[5] has another file than before");
    assert_null(maps);
    files.instead = NULL;
    for (i = 0; i < POINTS; i++) assert_true(got[i] < -6);
    assert_int_equal(cohsm_stream_visible_scene(s, streamed, INSTANCES, &q, got, NULL), COHSM_OK);
    for (i = 0; i < POINTS; i++) assert_true(got[i] >= 0);
    cohsm_stream_free(s);
    assert_int_equal(l.live, 0);
    for (i = 0; i < OBJECTS; i++) assert_int_equal(files.out[i], 0);
    free(broken.memory);
    free(other.memory);
}

static void memory_may_run_out_at_any_call(void **state)
{
    static float points[3 * POINTS], lights[3 * POINTS], got[POINTS];
    static uint32_t entities[POINTS];
    cohsm_instance in_memory[INSTANCES];
    cohsm_stream_instance streamed[INSTANCES];
    size_t at, failed = 0;
    (void)state;
    make_scene(in_memory, streamed, points, lights, entities, 1);
    for (at = 1; at < 200; at += at < 12 ? 1 : 13) {
        cohsm_stream_desc d;
        cohsm_stream *s = NULL;
        cohsm_query q = query_of(points, 100, lights, COHSM_LIGHT_DIRECTION, COHSM_FILTER_NEAREST);
        cohsm_result result;
        shelf files;
        ledger l;
        int i;
        d = stream_of(&files, &l, (int)(at & 1), all_bytes() / 4);
        l.fail_at = at;
        got[0] = -7;
        result = cohsm_stream_create(&d, &s);
        if (result == COHSM_OK) {
            result = cohsm_stream_visible_scene(s, streamed, INSTANCES, &q, got, NULL);
            if (result != COHSM_OK) {
                assert_true(got[0] < -6);
                assert_int_equal(cohsm_stream_visible_scene(s, streamed, INSTANCES, &q, got, NULL), COHSM_OK);
            }
        } else assert_null(s);
        failed += result != COHSM_OK;
        if (result != COHSM_OK) {
            assert_int_equal(result, COHSM_ERR_ALLOC);
            assert_non_null(strstr(said, "system.allocator returned no memory"));
        }
        cohsm_stream_free(s);
        assert_int_equal(l.live, 0);
        assert_int_equal(l.wrong, 0);
        for (i = 0; i < OBJECTS; i++) assert_int_equal(files.out[i], 0);
    }
    assert_true(failed > 12);
}

static void bad_streams_are_named(void **state)
{
    cohsm_stream_instance instance;
    cohsm_stream_desc d;
    cohsm_stream *s = NULL;
    cohsm_stream_stats info;
    const cohsm_maps *maps = NULL;
    static const float point[3] = { 0, 0, 0 };
    cohsm_query q = query_of(point, 1, point, COHSM_LIGHT_DIRECTION, COHSM_FILTER_NEAREST);
    float visible = -7;
    shelf files;
    ledger l;
    (void)state;
    d = stream_of(&files, &l, 0, 100);
    assert_int_equal(cohsm_stream_create(NULL, &s), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_stream_create(&d, NULL), COHSM_ERR_ARGUMENT);
    d.object_count = 0;
    assert_int_equal(cohsm_stream_create(&d, &s), COHSM_ERR_DESC);
    assert_string_equal(said, "cohsm_stream_create: desc.object_count is 0; it must be 1..2^24");
    d.object_count = OBJECTS;
    d.budget_bytes = 0;
    assert_int_equal(cohsm_stream_create(&d, &s), COHSM_ERR_DESC);
    d.budget_bytes = 100;
    d.load_fn = NULL;
    assert_int_equal(cohsm_stream_create(&d, &s), COHSM_ERR_DESC);
    d.load_fn = take_file;
    d.system.allocator.alloc_fn = NULL;
    assert_int_equal(cohsm_stream_create(&d, &s), COHSM_ERR_DESC);
    assert_null(s);
    d = stream_of(&files, &l, 0, 100);
    assert_int_equal(cohsm_stream_create(&d, &s), COHSM_OK);
    assert_int_equal(cohsm_stream_use(s, 0, &maps), COHSM_ERR_LIMIT);
    assert_non_null(strstr(said, "cohsm_stream_use: objects[0] takes "));
    assert_int_equal(cohsm_stream_use(s, OBJECTS, &maps), COHSM_ERR_ARGUMENT);
    assert_string_equal(said, "cohsm_stream_use: object is 40; it must be below 40, the number of objects");
    assert_int_equal(cohsm_stream_use(s, 0, NULL), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_stream_use(NULL, 0, &maps), COHSM_ERR_ARGUMENT);
    cohsm_stream_end(s, 0);
    cohsm_stream_end(s, OBJECTS);
    cohsm_stream_end(NULL, 0);
    identity(instance.transform);
    instance.object = OBJECTS;
    assert_int_equal(cohsm_stream_visible_scene(s, &instance, 1, &q, &visible, NULL), COHSM_ERR_INPUT);
    assert_string_equal(said, "cohsm_stream_visible_scene: instances[0] has the object 40; it must be below "
                              "desc.object_count");
    assert_int_equal(cohsm_stream_visible_scene(s, &instance, 1, NULL, &visible, NULL), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_stream_visible_scene(s, NULL, 1, &q, &visible, NULL), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_stream_visible_scene(s, &instance, 1, &q, NULL, NULL), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_stream_visible_scene(NULL, &instance, 1, &q, &visible, NULL), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_stream_visible_scene(s, &instance, UINT32_MAX, &q, &visible, NULL), COHSM_ERR_LIMIT);
    assert_true(visible < -6);
    assert_int_equal(cohsm_stream_visible_scene(s, NULL, 0, &q, &visible, NULL), COHSM_OK);
    assert_true(visible > 0.99f && visible < 1.01f);
    memset(&info, 0xff, sizeof info);
    cohsm_stream_get_stats(s, &info);
    cohsm_stream_get_stats(NULL, &info);
    cohsm_stream_get_stats(s, NULL);
    assert_true(info.loads == 0 && info.bytes == 0);
    cohsm_stream_free(s);
    cohsm_stream_free(NULL);
    assert_int_equal(l.live, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_in_place_is_read_where_it_lies),
        cmocka_unit_test(files_in_place_lie_at_multiples_of_64_bytes),
#if defined(__unix__) || defined(__APPLE__)
        cmocka_unit_test(no_query_reads_beyond_the_line_in_which_a_file_ends),
#endif
        cmocka_unit_test(a_budget_bounds_what_a_file_may_take),
        cmocka_unit_test(trays_stay_within_the_budget),
        cmocka_unit_test(a_file_tells_its_facts_before_it_is_opened),
        cmocka_unit_test(a_packed_file_that_promises_too_much_is_damaged),
        cmocka_unit_test(bad_openings_are_named),
        cmocka_unit_test(the_object_whose_last_hold_ended_first_leaves_first),
        cmocka_unit_test(packed_files_are_decoded_within_the_budget),
        cmocka_unit_test(a_streamed_scene_answers_as_one_in_memory),
        cmocka_unit_test(objects_that_no_way_meets_stay_where_they_are),
        cmocka_unit_test(a_failed_load_leaves_answers_and_stream_as_they_were),
        cmocka_unit_test(memory_may_run_out_at_any_call),
        cmocka_unit_test(bad_streams_are_named),
    };
    return cmocka_run_group_tests(tests, make_objects, free_objects);
}
