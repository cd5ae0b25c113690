/* ---- state: what an ism_maps holds, how its memory grows, how its tasks run ---- */

#define ISM__PI 3.14159265f
#define ISM__MAX_FLOAT 3.402823466e38f
/* The square of a disc's radius is at most this, in squares of its distance from the VPL; ISM__WIDEST_BACK is
   for discs that are seen from behind. Discs that are made smaller so are counted in wide_splats. */
#define ISM__WIDEST 1.0f
#define ISM__WIDEST_BACK 0.04f
#define ISM__EITHER 0.05            /* weight of what the view alone, or the VPL alone, sees of a cluster; the
                                       geometric mean of both has the weight 1 */
#define ISM__CUT_SCALE 6.0f         /* area of discs that their triangle cuts off, over that of the others */
#define ISM__EDGE 1e-4f             /* discs reach over their triangle's edge by this much of a barycentric
                                       coordinate, so that no light leaks between triangles */
#define ISM__GRAZING 1e-4f          /* a VPL whose cosine to a receiver's plane is less counts as behind that
                                       plane, since only rounding tells the sides apart */
#define ISM__HOLE 2                 /* texels to each side that are searched for surfels around a hole */
#define ISM__LANES 64u              /* tiles drawn at once at most; each lane has scratch memory of its own */
#define ISM__BLOCK 16u              /* pixels a side of what one task shades */
#define ISM__CHUNK 64u              /* VPLs whose form factors are computed together */
#define ISM__BATCHES 16u            /* calls of progress in a stage */
#define ISM__NEAR_BLOCK 64u         /* near points that lie together */
#define ISM__STEPS 64u              /* the square's side has so many steps, at which windows begin and end */
#define ISM__SLACK 2u               /* a window stays where it was if it reaches no more steps than this
                                       farther out than it must */
#define ISM__SIGHTS 64u             /* blocks of the picture; eight receivers of each make the windows */
#define ISM__PAD 0.015625f          /* share of the extent of those receivers that is added at either side,
                                       since other receivers may lie a little outside */
#define ISM__NEAR_RANK 8u           /* the reach of a near point is twice its distance from the VPL that has
                                       this rank among the nearest */

typedef struct ism__buffer { void *data; size_t size; } ism__buffer;

typedef struct ism__texel {         /* a texel of a tile while the tile is drawn */
    float    g[3];                  /* plane of the surfel: 1 / t = g . direction; in maps of directions t =
                                       g . (x, y, 1) */
    uint32_t triangle, filled;      /* filled: push gave the depth, which is g[0] */
} ism__texel;

typedef struct ism__surfel { uint32_t triangle; uint16_t b1, b2; float weight; } ism__surfel;

typedef struct ism__orientation { ism__v3 x, y, z; } ism__orientation;

/* How one axis of the square is mapped to the tile: the window lo..hi becomes a..b; below, inside and above
   are the slopes in the three parts. If `on` is 0, the map is the identity. */
typedef struct ism__axis { int on; float lo, hi, a, b, below, inside, above; } ism__axis;
typedef struct ism__window { ism__axis u, v; } ism__window;

enum { ISM__DISCS = 16,             /* points that are drawn together */
       ISM__AHEAD = 16 };           /* points whose memory is fetched before it is wanted */

/* What shading reads of a VPL: arrays of one float each, so that compilers vectorise the loop over them. */
enum { ISM__PX, ISM__PY, ISM__PZ, ISM__NX, ISM__NY, ISM__NZ, ISM__FIELDS };

/* Receivers as a picture of width x height; a list is one row. */
typedef struct ism__view { const ism_points *points; uint32_t width, height; } ism__view;

/* The arguments of a public call after they were checked, with its progress and its log. */
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
    int             chosen, built;  /* there are VPLs; there are maps */
    ism__buffer     atlas, hits, scratch, directions;       /* maps, and the memory that drawing them takes */
    ism__buffer     surfels, counts;                        /* points of all VPLs, and how many each has */
    ism__buffer     sums, clusters, shares, weights;        /* distributions from which points are drawn */
    ism__buffer     sources, importance, blurred, cdf;      /* distributions from which VPLs are drawn */
    ism__buffer     previous, windows, pixels;              /* VPLs of the last frame; receivers */
    ism__buffer     near_points, near_blocks, near_drawn, near_keys;
    uint32_t        window_count;   /* VPLs of the frame before, whose ism_vpl.window is kept in `windows`
                                       after the ism__window of each VPL of this frame */
    uint32_t        near_count;     /* near points in use */
    uint32_t        blank_from;     /* tiles of the atlas from this one on show nothing */
    size_t          triangles;      /* triangles that the points lie on; 0 = there are no points yet */
    size_t          source_count, cells;    /* cells: pVPLs of all sources */
    float           center[3], radius;      /* bounding sphere of the mesh, for directions */
    ism_stats       stats;
};

/* Where a source's arrays begin in the buffers importance and cdf; the sum of its fluxes, and of its
   importances. */
typedef struct ism__source_of { size_t first, cdf_first; double flux, total; } ism__source_of;

/* Makes a buffer large enough; its content is lost if it grows. Returns 0 if there is no memory. */
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

/* Runs all tasks, in batches between which the caller's progress goes from..to of the part. Returns 0 if the
   caller cancels. */
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
