/* ---- building: what a build holds ---- */

enum { SFIELD__MOST_WIDTH = 512, SFIELD__EMISSIVE_WIDTH = 256, SFIELD__MOST_VIEWS = 256 };

typedef struct sfield__texels {     /* of a cube: tables */
    float *direction, *basis;       /* 3 floats; integrals of the basis, `planes` floats */
    float *angle;                   /* solid angle */
    float  node[64];                /* coordinates of the position grid */
} sfield__texels;

typedef struct sfield__view {       /* of one task */
    uint64_t *bits;                 /* 6 x width rows of width samples */
    float    *depth;                /* emissive meshes: 1 / distance and triangle + 1 of each sample */
    uint32_t *owner;
    uint8_t   touched[6 * SFIELD__MOST_WIDTH];      /* 1: something was drawn in this row */
    float    *texel, *haar, *key;   /* channels x 6 N^2; keys once */
    double   *work;                 /* logarithms */
    double    lost, total;          /* squares of wavelets */
    uint64_t  moved;
    uint32_t  width, scale;         /* samples a side of a face, of a texel */
} sfield__view;

typedef enum sfield__what {
    SFIELD__MESH, SFIELD__EMISSIVE, SFIELD__ANALYTIC, SFIELD__CALLBACK, SFIELD__SELF, SFIELD__VIEWS
} sfield__what;

typedef struct sfield__build {
    sfield__what      what;
    sfield__allocator allocator;
    sfield__logger    log;
    sfield_desc       desc;
    sfield__header    h;
    void             *held[24];
    uint32_t          held_count;
    size_t            bytes, peak;
    sfield_algebra   *algebra;      /* logarithms */
    float            *position;     /* of vertices, about the center, in r */
    uint32_t         *index, *original;
    float            *corner;       /* of triangles: planes of x, y, z of first corners, then of the others */
    size_t            vertices, triangles, corner_room;     /* room: from one plane to the next */
    sfield_mask_fn    mask_fn;      /* of the mesh, and what is given to it */
    void             *mask_user;
    const float      *radiance;     /* of triangles, this frame's */
    sfield_emitter    emitter;
    float             cosine;       /* of its cone */
    const sfield_points *points;
    float             offset, time;
    sfield__texels    texels;
    sfield__view     *view;
    uint32_t          pieces, planes, cells, most;     /* most: wavelets kept of a cube */
    float             window[SFIELD_MAX_BANDS];
    size_t            first, count; /* samples of this batch: a shell, or some points */
    size_t            from, to;     /* of them, those that tasks do now */
    sfield_views_fn   see;          /* VIEWS: and what it saw, `seen_size` floats an eye */
    void             *see_user;
    float            *eyes, *seen;
    uint8_t          *moved;        /* of each of them: taken outside the mesh */
    size_t            seen_size;
    float             radius;       /* of this shell */
    float             radii[64];
    float            *value;        /* SH: stride floats a sample of the batch */
    uint32_t         *kept, *entry; /* HAAR: number and `most` entries a sample of the batch */
    float            *kept_scale;
    sfield_field     *out;
    uint32_t         *all, all_used, all_room, *offsets;
    float            *scales;
    uint32_t          skipped;
    int               simd;         /* sfield__simd_level */
} sfield__build;

/* Allocates memory that lives as long as the build. If it returns NULL the caller has only to return: all
   that a build holds is freed at its end. */
static void *sfield__hold_memory(sfield__build *b, size_t count, size_t size)
{
    const int room = b->held_count < sizeof b->held / sizeof b->held[0];
    void *memory = room ? sfield__alloc_array(&b->allocator, count ? count : 1, size) : NULL;
    if (!memory) return NULL;
    b->held[b->held_count++] = memory;
    b->bytes += (count ? count : 1) * size;
    b->peak = b->bytes > b->peak ? b->bytes : b->peak;
    return memory;
}

static void sfield__release_build(sfield__build *b)
{
    while (b->held_count) sfield__free(&b->allocator, b->held[--b->held_count]);
    sfield__free(&b->allocator, b->all);
    sfield_algebra_free(b->algebra);
    sfield_free(b->out);
}

static int sfield__tell_progress(const sfield__build *b, float fraction)
{
    return !b->desc.system.progress || b->desc.system.progress(b->desc.system.user, fraction) == 0;
}

static void sfield__run_tasks(sfield__build *b, void (*task)(void *, size_t))
{
    size_t p;
    if (b->desc.system.parallel_for) b->desc.system.parallel_for(b->desc.system.user, b->pieces, task, b);
    else for (p = 0; p < b->pieces; p++) task(b, p);
}

/* Callbacks cannot be measured: the bounding sphere has to be given. */
static sfield_result sfield__need_radius(const sfield__build *b)
{
    return sfield__check_value(&b->log, b->desc.radius > 0, "desc.radius", (double)b->desc.radius,
                        "> 0 without a mesh")
               ? SFIELD_OK
               : SFIELD_ERR_DESC;
}
