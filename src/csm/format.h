/* ---- format: the block, and what maps keep in memory ---- */

/* The block consists of 32-bit little-endian words, so that one rule serves memory, file, upload and hosts of
   either byte order:

     header        COHSM__HEADER_WORDS words, cohsm__header below
     order table   HILBERT only: place in the sequence of each cell, 16 bits each up to 65,536 cells, else 32
     locations     TABLE and LIST only: 4 floats a cell
     lookup        one word for each 65,536 views (a chunk) and pixel: where its directory begins,
                   or COHSM__CONSTANT | depth where all maps of the chunk store the same depth there
     directories   see "lists" below; filled up to a multiple of 16 words from the beginning
     lines         the blocks of all lists, 16 words each, then 4 words of padding so that readers may load
                   ahead */

enum {
    COHSM__MAGIC = 0x4d534344,          /* "DCSM" */
    COHSM__PACK_MAGIC = 0x50534344,     /* "DCSP", of a packed file */
    COHSM__FAST_MAGIC = 0x46534344,     /* "DCSF", of what cohsm_fast_data returns */
    COHSM__FAST_FLAG = 2,               /* beside self_only, in such a header: the last three sections are
                                           lines, base and at of the trays, where a block has its lookup */
    COHSM__MOST_WORDS = 0x3fffffff,     /* of a block */
    COHSM__FORMAT = 1,
    COHSM__HEADER_WORDS = 96,
    COHSM__PADDING = 4,
    COHSM__BLOCK_WORDS = 16,            /* a block of a list is one cache line */
    COHSM__CHUNK_BITS = 16,
    COHSM__DOP_AXES = 13,
    COHSM__OPEN = 65534,                /* depth of the sphere's far side; hits are at most COHSM__HIT_MAX */
    COHSM__HIT_MAX = 65533,
    COHSM__INFINITE = 65535
};
#define COHSM__CONSTANT 0x80000000u
#define COHSM__CHUNK (1u << COHSM__CHUNK_BITS)

typedef struct cohsm__header {          /* 32-bit fields only */
    uint32_t magic, format, words, crc; /* crc of everything after this field */
    uint32_t domain, layers, order, orientation;
    uint32_t side[3], map_count, view_count;
    uint32_t map_side, depth_bits, dimensions;
    uint32_t positional, self_only, pixel_begin, pixel_end;
    uint32_t order_words, location_words, lookup_words;
    uint32_t directory_words, line_words;
    uint32_t segments_low, segments_high;
    float    center[3], radius, depth_far, open_thickness;
    float    origin[3], u[3], v[3], w[3];
    float    dop[2 * COHSM__DOP_AXES];  /* least and greatest extent along each axis of cohsm__dop_axis */
    uint32_t reserved[COHSM__HEADER_WORDS - 71];
} cohsm__header;

typedef char cohsm__header_size[sizeof(cohsm__header) == 4 * COHSM__HEADER_WORDS ? 1 : -1];

/* Returns which kernels to use: 2 those of AVX-512, 1 those of AVX2, 0 those of the instruction set that the
   program is compiled for. */
static int cohsm__simd(void) { return cohsm__simd_level(); }

typedef struct cohsm__trays {           /* the fast layout: see trays.h */
    void           *memory;             /* what the allocator gave, of so many bytes */
    size_t          bytes;
    const void     *data;               /* what cohsm_fast_data returns */
    size_t          data_bytes;
    const uint8_t  *lines;              /* 64-byte aligned; NULL: the layout is compact */
    const uint32_t *base;               /* for each bucket of views and group of pixels: its first line */
    const uint16_t *at;                 /* for each bucket and pixel: where the tray is, from that line on */
    uint32_t        groups;             /* of pixels, in a bucket */
} cohsm__trays;

struct cohsm_maps {
    cohsm__allocator  allocator;
    void             *memory;           /* what the allocator gave */
    const uint32_t   *words;            /* the block, 64-byte aligned in it so that its lines are cache
                                           lines; in the caller's file if memory is NULL */
    cohsm__header     head;
    const uint32_t   *order, *lookup, *directories, *lines;
    const float      *locations;
    uint32_t          range;            /* pixel_end - pixel_begin */
    float            *angles;           /* LATLONG: cos, sin of each column, then of each row */
    float             dop[2 * COHSM__DOP_AXES]; /* in radii about the centre */
    uint16_t          depth_of[512];    /* stored grid value -> 16-bit depth */
    int               simd;             /* cohsm__simd */
    void (*log)(void *user, const char *message);   /* of the system that the maps were made with */
    void             *log_user;
    cohsm__trays      trays;
};

static void cohsm__run_tasks(const cohsm_system *s, size_t count, cohsm_task task, void *context)
{
    size_t i;
    if (s->parallel_for) s->parallel_for(s->user, count, task, context);
    else
        for (i = 0; i < count; i++) task(context, i);
}

/* The caller's allocator, with a count of the bytes that it has given out, for cohsm_stats.peak_bytes. */
typedef struct cohsm__counted_heap { cohsm__allocator allocator; size_t used, peak; } cohsm__counted_heap;

static void *cohsm__heap_alloc(cohsm__counted_heap *h, size_t count, size_t size)
{
    void *p = cohsm__alloc_array(&h->allocator, count, size);
    if (p) {
        h->used += count * size;
        if (h->used > h->peak) h->peak = h->used;
    }
    return p;
}

static void cohsm__heap_free(cohsm__counted_heap *h, void *p, size_t count, size_t size)
{
    if (!p) return;
    h->used -= count * size;
    cohsm__free(&h->allocator, p);
}

/* A system for one step of a call: its progress is a part of the whole's; all else is passed on. */
typedef struct cohsm__step_system { cohsm__part part; cohsm_system whole; } cohsm__step_system;

static void cohsm__step_run(void *user, size_t count, cohsm_task task, void *context)
{
    const cohsm_system *whole = &((const cohsm__step_system *)user)->whole;
    whole->parallel_for(whole->user, count, task, context);
}

static int cohsm__step_progress(void *user, float fraction)
{
    return cohsm__part_tell(&((const cohsm__step_system *)user)->part, fraction);
}

static void cohsm__step_log(void *user, const char *message)
{
    const cohsm_system *whole = &((const cohsm__step_system *)user)->whole;
    whole->log(whole->user, message);
}

/* Turns *system into one whose progress runs from..to of what it was. *step must live as long as it is
   used. */
static void cohsm__system_for_step(cohsm_system *system, cohsm__step_system *step, float from, float to)
{
    step->whole = *system;
    step->part.progress = system->progress;
    step->part.user = system->user;
    step->part.from = from;
    step->part.to = to;
    if (system->parallel_for) system->parallel_for = cohsm__step_run;
    if (system->progress) system->progress = cohsm__step_progress;
    if (system->log) system->log = cohsm__step_log;
    system->user = step;
}

static cohsm__allocator cohsm__allocator_of(const cohsm_system *s)
{
    return cohsm__allocator_make(s->allocator.alloc_fn, s->allocator.free_fn, s->allocator.user);
}

static cohsm__logger cohsm__logger_of(const cohsm_system *s, const char *function)
{
    cohsm__logger log;
    log.log = s ? s->log : NULL;
    log.user = s ? s->user : NULL;
    log.function = function;
    return log;
}

/* Returns the log that maps keep; maps may be NULL. */
static cohsm__logger cohsm__logger_of_maps(const cohsm_maps *m, const char *function)
{
    cohsm__logger log;
    log.log = m ? m->log : NULL;
    log.user = m ? m->log_user : NULL;
    log.function = function;
    return log;
}

static int cohsm__system_valid(const cohsm_system *s)
{
    return cohsm__allocator_valid(s->allocator.alloc_fn, s->allocator.free_fn);
}

/* Logs "FIELD TEXT" and returns the result, for a call that returns it too. */
static cohsm_result cohsm__refuse(const cohsm__logger *log, cohsm_result result, const char *field,
                                  const char *text)
{
    cohsm__log_text(log, field, text);
    return result;
}

/* Logs that a field of a desc or a query is out of range, and returns COHSM_ERR_DESC. */
static cohsm_result cohsm__refuse_value(const cohsm__logger *log, const char *field, double value,
                                        const char *wanted)
{
    cohsm__log_value(log, field, value, wanted);
    return COHSM_ERR_DESC;
}

/* Logs that memory was short, if this is the result of a call whose arguments were right. Returns the
   result. */
static cohsm_result cohsm__log_result(const cohsm__logger *log, cohsm_result result)
{
    if (result == COHSM_ERR_ALLOC) cohsm__log_text(log, "system.allocator", "returned no memory");
    return result;
}

/* Writes the allocator of a system, which may be NULL, and the whole of its progress. Returns 0, and logs so,
   if the allocator has one function of the two. */
static int cohsm__services_of(const cohsm_system *system, const cohsm__logger *log, cohsm__allocator *a,
                              cohsm__part *part)
{
    cohsm_system none;

    if (!system) {
        memset(&none, 0, sizeof none);
        system = &none;
    }
    if (!cohsm__system_valid(system)) {
        cohsm__log_text(log, "system.allocator", "has one function of the two");
        return 0;
    }
    *a = cohsm__allocator_of(system);
    part->progress = system->progress;
    part->user = system->user;
    part->from = 0.0f;
    part->to = 1.0f;
    return 1;
}

static uint32_t cohsm__min_u32(uint32_t a, uint32_t b) { return a < b ? a : b; }
static uint32_t cohsm__max_u32(uint32_t a, uint32_t b) { return a > b ? a : b; }

/* Says whether all floats of a header are finite. Locations so far away that distances overflow make it 0. */
static int cohsm__floats_finite(const cohsm__header *h)
{
    const float *f;
    for (f = h->center; f < h->dop + 2 * COHSM__DOP_AXES; f++)
        if (!cohsm__finite(*f)) return 0;
    return 1;
}

/* How many lists are copied or coded between two calls of progress, which takes milliseconds. */
enum { COHSM__LISTS_COPIED = 4096, COHSM__LISTS_CODED = 64 };
