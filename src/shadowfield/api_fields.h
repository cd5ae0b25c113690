/* ---- fields ---- */

typedef enum sfield_basis {
    SFIELD_BASIS_DEFAULT,           /* = SFIELD_BASIS_SH */
    SFIELD_BASIS_SH,                /* spherical harmonics: soft and fast */
    SFIELD_BASIS_HAAR,              /* Haar wavelets: all frequencies, slow. A header joined without them
                                       refuses it */
    SFIELD_BASIS_COUNT
} sfield_basis;

typedef enum sfield_spacing {       /* of the shells */
    SFIELD_SPACING_DEFAULT,         /* = SFIELD_SPACING_GEOMETRIC */
    SFIELD_SPACING_GEOMETRIC,       /* interpolated in solid angle: within 2 % of a sphere between shells */
    SFIELD_SPACING_UNIFORM,         /* as in the paper, interpolated in the distance: 15 % wrong at 1.5 r */
    SFIELD_SPACING_COUNT
} sfield_spacing;

typedef struct sfield_desc {        /* zero it, then set what you care about */
    sfield_system  system;
    sfield_basis   basis;
    uint32_t       bands;           /* harmonics: 1..8; 0 = 4 */
    uint32_t       cube_side;       /* texels a side of a cube's face, a power of two, 4..64; 0 = 16 (wavelets
                                       32) */
    uint32_t       shells;          /* 2..64; 0 = 16 (wavelets 32) */
    uint32_t       position_side;   /* sample points a side of a face of a shell, 2..64; 0 = 16 (wavelets
                                       32) */
    sfield_spacing spacing;
    float          inner, outer;    /* first and last shell, in r, 0.001 <= inner, 1.1 inner <= outer <= 1000,
                                       no two shells within 0.02 %; 0 = 0.2 and 8 (wavelets 20) */
    float          keep;            /* wavelets: the share of a cube's coefficients that is kept at most,
                                       0..1; 0 = 0.01 */
    float          window;          /* harmonics: strength of sfield_sh_window for every cube, >= 0 */
    int            logarithm;       /* harmonics: not 0 stores log visibility, for SFIELD_PRODUCT_EXP */
    uint32_t       frames;          /* sources: 1..256 steps of time; 0 = 1 */
    float          frames_per_second; /* > 0; 0 = 30 */
    int            loop;            /* not 0: after the last frame comes the first; 0: the last stays */
    float          center[3], radius; /* the bounding sphere, which must hold the mesh or emitter; radius 0 =
                                         fitted, which callbacks do not allow */
    uint32_t       shard_begin, shard_end; /* only these shells, counted through all frames; 0, 0 = all */
    int            keep_inside;     /* not 0: sample points inside a closed mesh see nothing, as in the paper;
                                       0: they take the view from just outside the surface */
} sfield_desc;

typedef struct sfield_stats {       /* of a build */
    uint32_t triangles;             /* used */
    uint32_t skipped_triangles;     /* with a vertex that is not finite, or two equal corners */
    uint64_t coefficients;          /* wavelets that were kept */
    double   lost;                  /* wavelets: relative L2 error of those that were not kept, over all
                                       samples */
    size_t   peak_bytes;            /* asked of the allocator at once */
    uint64_t moved;                 /* sample points inside the mesh whose view was taken outside */
} sfield_stats;

/* sfield_build, on page one, builds the occlusion field of a mesh.
   Errors   SFIELD_ERR_DESC, SFIELD_ERR_ARGUMENT (NULL), SFIELD_ERR_INPUT (stride, index count, an index
            beyond vertex_count, both kinds of indices, no triangle left), SFIELD_ERR_ALLOC, SFIELD_ERR_LIMIT,
            SFIELD_ERR_CANCELLED
   Memory   the field + 16 tasks of about 26 bytes a vertex and 0.2 MB + the samples of one shell
   Cost     shells x 6 side^2 views of all triangles, and as many again for sample points inside: of 10,000
            triangles seconds (harmonics) to minutes (wavelets), of a box 0.6 and 15 s */

SFIELD_DEF sfield_result sfield_build_emissive(const sfield_desc *desc, const sfield_mesh *mesh,
                                               const float *radiance, sfield_field **out,
                                               sfield_stats *stats);
/* Builds the source field of an emissive mesh.
   radiance  r, g, b of each triangle, >= 0, for each frame one array after the other. A triangle shines on
             the side from which it is counter-clockwise; for both sides give it once more, turned over. One
             of radiance 0 hides those behind it
   Errors    as sfield_build; SFIELD_ERR_INPUT also for a radiance that is negative or not finite */

typedef void (*sfield_view_fn)(void *user, float time, const float position[3], const float direction[3],
                               float rgb[3]);
/* Writes what arrives at a position in the field's space from a unit direction, which points away from the
   position: radiance, or alpha in rgb[0]. It is called from your threads. Values that are negative or not
   finite count as 0. */

typedef enum sfield_emitter_kind {
    SFIELD_EMITTER_DEFAULT,         /* = SFIELD_EMITTER_SPHERE */
    SFIELD_EMITTER_SPHERE,          /* radius about the centre */
    SFIELD_EMITTER_DISC,            /* radius about the centre, emits along normal */
    SFIELD_EMITTER_RECTANGLE,       /* half axes u and v about the centre, emits along u x v */
    SFIELD_EMITTER_CALLBACK,        /* view_fn; nothing comes from outside the bounding sphere */
    SFIELD_EMITTER_COUNT
} sfield_emitter_kind;

typedef struct sfield_emitter {     /* in the field's space, about desc.center */
    sfield_emitter_kind kind;
    float radius;                   /* > 0 */
    float normal[3];                /* unit; a sphere may have 0 0 0 */
    float u[3], v[3];
    float radiance[3];              /* >= 0 */
    float cone_half_angle;          /* radians about the normal, 0..pi; 0 = pi / 2. A sphere without a normal
                                       shines everywhere */
    sfield_view_fn view_fn;
    void *user;                     /* given to view_fn */
} sfield_emitter;

SFIELD_DEF sfield_result sfield_build_emitter(const sfield_desc *desc, const sfield_emitter *emitter,
                                              sfield_field **out, sfield_stats *stats);
/* Builds the source field of an analytic light or of a callback. desc.radius 0 = fitted, but for callbacks.
   Errors  SFIELD_ERR_DESC (a field of desc or emitter), SFIELD_ERR_ARGUMENT, SFIELD_ERR_ALLOC, _LIMIT,
           _CANCELLED */

SFIELD_DEF sfield_result sfield_build_callback(const sfield_desc *desc, sfield_view_fn alpha_fn, void *user,
                                               sfield_field **out, sfield_stats *stats);
/* Builds an occlusion field from your own renderer: alpha is 0..1. desc.radius is required. Errors as
   above. */

/* sample points of a shell, 1..256 at a time, from which your renderer looks */
typedef struct sfield_views {
    float        center[3], radius; /* bounding sphere of the field */
    float        time;              /* seconds, of a source's frame */
    size_t       count;
    const float *eyes;              /* (position - center) / radius, three floats each */
    float       *values;            /* for you to write, for each eye. Harmonics: bands^2 coefficients;
                                       wavelets: 6 N^2 texels. Of alpha, where 1 is hidden; of sources: of r,
                                       then of g, then of b */
} sfield_views;

typedef int (*sfield_views_fn)(void *user, const sfield_views *views);
/* Returns not 0 to end the build. It is called from the thread that called us, shell after shell.
   Coefficients are those that sfield_cube_basis makes. The eyes lie on the shell, or just outside the
   mesh. */

SFIELD_DEF sfield_result sfield_build_views(const sfield_desc *desc, int source, const sfield_mesh *mesh,
                                            sfield_views_fn see_fn, void *user, sfield_field **out,
                                            sfield_stats *stats);
/* Builds a field whose cubes another renderer draws and projects, such as gl_backend's. Windows, logarithms,
   the choice of wavelets and the block are made here.
   source   not 0: of radiance, else of occlusion
   mesh     the mesh that you draw, for the bounding sphere, the inscribed one and the sample points inside,
            which are asked again from outside (keep_inside); NULL = desc.radius is required, none is
            inscribed, none is moved
   Values that are not finite or beyond 1e18 count as 0.
   Errors   as sfield_build; SFIELD_ERR_CANCELLED where see_fn returned not 0 */

SFIELD_DEF sfield_result sfield_build_self(const sfield_desc *desc, const sfield_mesh *mesh,
                                           const sfield_points *points, float offset, sfield_field **out,
                                           sfield_stats *stats);
/* Builds the self-visibility of points on a mesh, O_p in the paper: the view from each position + offset x
   its normal. It is for sfield_points.self. Harmonics store visibility x max(0, cosine), wavelets the
   occlusion. Points in parts that run into each other are taken outside too (keep_inside).
   points   count, positions and normals with their strides; the other members are not read
   Errors   as sfield_build; SFIELD_ERR_INPUT also for positions that are not finite and normals that are not
            unit */

SFIELD_DEF sfield_result sfield_merge(const sfield_field *const *shards, size_t count,
                                      const sfield_system *system, sfield_field **out);
/* Joins shards of one desc whose shells follow each other from the first to the last. The bytes are those of
   the whole build. system may be NULL.
   Errors   SFIELD_ERR_ARGUMENT, SFIELD_ERR_DESC (allocator), SFIELD_ERR_MISMATCH (these are not the shards of
            one field), SFIELD_ERR_LIMIT, SFIELD_ERR_ALLOC, SFIELD_ERR_CANCELLED */

typedef enum sfield_kind {
    SFIELD_KIND_NONE,
    SFIELD_KIND_OCCLUSION,
    SFIELD_KIND_SOURCE,
    SFIELD_KIND_SELF,
    SFIELD_KIND_COUNT
} sfield_kind;

typedef struct sfield_info {
    sfield_kind    kind;
    sfield_basis   basis;
    uint32_t       bands, cube_side, shells, position_side, frames;
    sfield_spacing spacing;
    int            logarithm;
    size_t         samples;         /* cubes that were recorded; of self-visibility: points */
    uint64_t       coefficients;    /* wavelets in all of them */
    size_t         bytes;           /* of the field, in memory and as a file */
    float          center[3], radius;
    float          inscribed;       /* radius of a sphere about the centre inside the closed mesh; 0 = none is
                                       known */
    float          inner, outer;    /* in r */
    uint32_t       shard_begin, shard_end; /* 0, 0: the whole field */
} sfield_info;

SFIELD_DEF void sfield_get_info(const sfield_field *field, sfield_info *out);
/* Writes what a field is; nothing where one of them is NULL. */

SFIELD_DEF sfield_result sfield_query(const sfield_field *field, size_t count, const float *positions,
                                      float time, float *out);
/* Interpolates the field between eight samples at positions in its own space, three floats each.
   out      harmonics: bands^2 coefficients for each position (sources: of r, then of g, then of b); wavelets:
            6 N^2 texels likewise. Of visibility (or its logarithm, as stored), or of radiance
   Errors   SFIELD_ERR_ARGUMENT; SFIELD_ERR_MISMATCH for self-visibility and for shards. Positions that are
            not finite see nothing: visibility 1, radiance 0 */

SFIELD_DEF sfield_result sfield_self(const sfield_field *field, size_t first, size_t count, float *out);
/* Writes the coefficients or texels of self-visibility as they are stored, from point `first` on. Errors
   SFIELD_ERR_ARGUMENT, SFIELD_ERR_MISMATCH. */

SFIELD_DEF sfield_result sfield_ambient(const sfield_field *field, size_t count, const float *positions,
                                        float *out);
/* Writes the share of all directions that stays open at each position, 0..1; harmonics tell it from the first
   coefficient alone. Errors SFIELD_ERR_ARGUMENT, SFIELD_ERR_MISMATCH (not an occlusion field, its logarithm,
   a shard). */

SFIELD_DEF size_t sfield_bytes(const sfield_field *field);
/* Returns how many bytes sfield_write needs; 0 for NULL. */
SFIELD_DEF sfield_result sfield_write(const sfield_field *field, void *memory, size_t memory_bytes);
/* Writes the file, little-endian: docs/shadowfield-format.md. Errors SFIELD_ERR_ARGUMENT,
   SFIELD_ERR_MEMORY. */
SFIELD_DEF sfield_result sfield_open(const void *data, size_t data_bytes, const sfield_system *system,
                                     sfield_field **out);
/* Copies and checks a file: every size, offset, index and number in it. system may be NULL.
   Errors  SFIELD_ERR_ARGUMENT, SFIELD_ERR_DESC (allocator), SFIELD_ERR_FORMAT, SFIELD_ERR_VERSION,
           SFIELD_ERR_MISMATCH (wavelets, in a header joined without them), SFIELD_ERR_ALLOC,
           SFIELD_ERR_CANCELLED */
