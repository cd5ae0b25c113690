/* ---- state: what an ism_maps holds, how its memory grows, how its tasks run ---- */

#define ISM__PI 3.14159265f
#define ISM__MAX_FLOAT 3.402823466e38f
/* Square of radius / distance that a disc may have, counted in wide_splats where it had more. */
#define ISM__WIDEST 1.0f
#define ISM__WIDEST_BACK 0.04f
#define ISM__EITHER 0.05             /* of points by what only the view sees, by what the VPL sees, to the
                                        mean's 1 */
#define ISM__CUT_SCALE 6.0f         /* area of discs that their triangle cuts off, over that of the others */
#define ISM__EDGE 1e-4f              /* of barycentric coordinates: so far discs reach over an edge, that none
                                        leaks */
#define ISM__GRAZING 1e-4f           /* cosine to a receiver's plane below which a VPL is behind it:
                                        rounding */
#define ISM__HOLE 2                  /* texels about one that may close it */
#define ISM__LANES 64u              /* tiles drawn at once at most; each lane has scratch memory of its own */
#define ISM__BLOCK 16u              /* pixels a side of what one task shades */
#define ISM__CHUNK 64u              /* VPLs whose form factors are computed together */
#define ISM__BATCHES 16u            /* calls of progress in a stage */
#define ISM__NEAR_BLOCK 64u         /* near points that lie together: a whole number of each interleave's
                                       classes */
#define ISM__STEPS 64u               /* of a tile's side, at which windows begin and end */
#define ISM__SLACK 2u                /* of these: so much farther out than need be a window may stay */
#define ISM__SIGHTS 64u              /* blocks of the picture, of each of which eight receivers make the
                                        windows */
#define ISM__PAD 0.015625f           /* of their extent, added at either side: for those between them */
#define ISM__NEAR_RANK 8u           /* a point's reach is twice the distance to this one of the VPLs about
                                       it */

typedef struct ism__buffer { void *data; size_t size; } ism__buffer;

typedef struct ism__texel {         /* of a tile while it is drawn */
    float    g[3];                  /* plane of the surfel: 1 / t = g . direction, or t = g . (x, y, 1) */
    uint32_t triangle, filled;      /* filled: g[0] is the depth that push gave */
} ism__texel;

typedef struct ism__surfel { uint32_t triangle; uint16_t b1, b2; float weight; } ism__surfel;

typedef struct ism__orientation { ism__v3 x, y, z; } ism__orientation;

/* From the square (lo, hi) to the tile (a, b), and how steeply. Not on: one is the other. */
typedef struct ism__axis { int on; float lo, hi, a, b, below, inside, above; } ism__axis;
typedef struct ism__window { ism__axis u, v; } ism__window;

/* What shading reads of a VPL. Arrays of one float each, so that compilers vectorise the loop over them. */
enum { ISM__DISCS = 16,             /* points that are drawn together */
       ISM__AHEAD = 16 };           /* points whose memory is fetched before it is wanted */
enum { ISM__PX, ISM__PY, ISM__PZ, ISM__NX, ISM__NY, ISM__NZ, ISM__FIELDS };

/* Receivers as a picture of width x height; a list is one row. */
typedef struct ism__view { const ism_points *points; uint32_t width, height; } ism__view;

/* What a public call was given, once it has been checked. */
typedef struct ism__job {
    const ism_frame *frame;
    ism__view        view;
    ism__part        part;          /* of the caller's progress */
    ism__logger      log;
} ism__job;

struct ism_maps {
    ism_desc        desc;           /* with defaults resolved: near_point_count and window_rim are 0 where
                                       there are none */
    ism__allocator  memory;
    uint32_t        tiles;          /* a side of the atlas */
    uint32_t        side;           /* texels a side of the atlas */
    ism_vpl        *vpls;           /* N; the first vpl_count are in use */
    uint32_t        vpl_count;
    uint32_t        previous_count; /* VPLs of the frame before, for `jumped` */
    int             chosen, built;
    ism__buffer     atlas, hits, scratch, directions;       /* maps; what they are drawn with */
    ism__buffer     surfels, counts;                        /* points of all VPLs, and how many each has */
    ism__buffer     sums, clusters, shares, weights;        /* what points are drawn by */
    ism__buffer     sources, importance, blurred, cdf;      /* what VPLs are drawn by */
    ism__buffer     previous, windows, pixels;              /* VPLs of the last frame; receivers */
    ism__buffer     near_points, near_blocks, near_drawn, near_keys;
    uint32_t        window_count;   /* of the frame before, each ism_vpl.window after the ism__window of this
                                       one */
    uint32_t        near_count;     /* of near_points, in use */
    uint32_t        blank_from;     /* tiles of the atlas from here on show nothing */
    size_t          triangles;      /* that the points lie on; 0 = there are none yet */
    size_t          source_count, cells;    /* cells: pVPLs of all sources */
    float           center[3], radius;      /* bounding sphere of the mesh, for directions */
    ism_stats       stats;
};

/* Where a source's arrays begin in the buffers importance and cdf. */
typedef struct ism__source_of { size_t first, cdf_first; double flux, total; } ism__source_of;

static int ism__grow(ism_maps *m, ism__buffer *b, size_t count, size_t item)
{
    size_t size;
    void *data;
    if (!ism__mul_size(count ? count : 1u, item, &size)) return 0;
    if (size <= b->size) return 1;
    data = ism__alloc(&m->memory, size);
    if (!data) return 0;
    m->stats.bytes += size;
    if (m->stats.bytes > m->stats.peak_bytes) m->stats.peak_bytes = m->stats.bytes;
    ism__free(&m->memory, b->data);
    m->stats.bytes -= b->size;
    b->data = data;
    b->size = size;
    return 1;
}

static void ism__release(ism_maps *m, ism__buffer *b)
{
    ism__free(&m->memory, b->data);
    m->stats.bytes -= b->size;
    b->data = NULL;
    b->size = 0;
}

/* Runs all tasks, in batches between which progress is told: from..to of the part. Returns 0 if the caller
   cancels. */
static int ism__run(const ism_maps *m, const ism__part *part, float from, float to, size_t count,
                    ism_task task, void *context)
{
    const ism_system *system = &m->desc.system;
    size_t batches = part->progress ? (count < ISM__BATCHES ? count : ISM__BATCHES) : 1u, i, k;
    ism__part own = ism__part_of(part, from, to);
    for (i = 0; i < batches; i++) {
        ism__batch b;
        size_t first = count / batches * i + (i < count % batches ? i : count % batches);
        size_t size = count / batches + (i < count % batches ? 1u : 0u);
        if (ism__cancelled(&own, i, batches, 1u)) return 0;
        b.task = task;
        b.context = context;
        b.first = first;
        if (system->parallel_for) system->parallel_for(system->user, size, ism__batch_task, &b);
        else for (k = 0; k < size; k++) ism__batch_task(&b, k);
    }
    return !(own.progress && ism__part_tell(&own, 1.0f));
}
