/* ---- fields ---- */

typedef enum sfield_basis {         /* the functions by which a field keeps what is seen from a point */
    SFIELD_BASIS_DEFAULT,           /* = SFIELD_BASIS_SH */
    SFIELD_BASIS_SH,                /* spherical harmonics: soft and fast */
    SFIELD_BASIS_HAAR,              /* Haar wavelets: all frequencies, slow. A header joined without them
                                       refuses it */
    SFIELD_BASIS_COUNT
} sfield_basis;

typedef enum sfield_spacing {       /* how far apart the shells are */
    SFIELD_SPACING_DEFAULT,         /* = SFIELD_SPACING_GEOMETRIC */
    SFIELD_SPACING_GEOMETRIC,       /* radii grow by a factor, and weights are linear in solid angle: between
                                       shells a sphere hides what it should within 2 % */
    SFIELD_SPACING_UNIFORM,         /* as in the paper: radii grow by a step, and weights are linear in the
                                       distance: 15 % wrong at 1.5 r */
    SFIELD_SPACING_COUNT
} sfield_spacing;

#ifndef SFIELD_WITHOUT_BUILD
typedef struct sfield_desc {        /* zero it, then set what you care about */
    sfield_system  system;
    sfield_basis   basis;
    uint32_t       bands;           /* of harmonics, 1..8; 0 = 4 */
    uint32_t       cube_side;       /* texels a side of a cube's face, a power of two, 4..64; 0 = 16 (wavelets
                                       32) */
    uint32_t       shell_count;     /* 2..64; 0 = 16 (wavelets 32) */
    uint32_t       position_side;   /* sample points a side of a face of a shell, 2..64; 0 = 16 (wavelets
                                       32) */
    sfield_spacing spacing;
    float          inner;           /* radius of the first shell, in radii of the bounding sphere,
                                       0.001..1000; 0 = 0.2 */
    float          outer;           /* radius of the last shell, in the same unit, 1.1 inner..1000; 0 = 8
                                       (wavelets 20). Neighbouring shells must be 0.02 % apart at least */
    const float   *radii;           /* shell_count radii in place of those from inner to outer, which are not
                                       used then, in the same unit: 0.001..1000, each 0.02 % above the one
                                       before at least. sfield_place chooses such. NULL = as spacing says */
    float          keep;            /* of wavelets: the share of a cube's coefficients that is kept at most,
                                       0..1; 0 = 0.01 */
    float          window;          /* of harmonics: the strength of sfield_sh_window for every cube, 0..1e6;
                                       0 = no window */
    int            logarithm;       /* of occlusion in harmonics: not 0 stores the logarithm of visibility,
                                       which SFIELD_PRODUCT_EXP needs */
    uint32_t       frame_count;     /* of sources: steps of time, 1..256; 0 = 1 */
    float          frames_per_second; /* of sources, 1e-6..1e6; 0 = 30 */
    int            loop;            /* not 0: after the last frame comes the first; 0: the last stays */
    float          center[3];       /* of the bounding sphere, -1e18..1e18 */
    float          radius;          /* of the bounding sphere, which must hold the mesh or emitter,
                                       1e-18..1e18. 0 = fitted: to a mesh, center too; to an emitter about
                                       center, where the emitter stands. Callbacks need a radius */
    uint32_t       shard_begin;     /* to build in parts, each by another process: the first shell of this
                                       part, counted through all frames */
    uint32_t       shard_end;       /* the shell after the last one of this part; 0 = all shells, the whole
                                       field, as self-visibility needs. sfield_merge joins the parts */
    int            keep_inside;     /* not 0: sample points inside a closed mesh see nothing, as in the paper;
                                       0: they take the view from just outside the surface */
} sfield_desc;

typedef struct sfield_stats {       /* what a build counted */
    uint32_t triangles;             /* triangles that were used */
    uint32_t skipped_triangles;     /* triangles with a vertex that is not finite, or with two equal
                                       corners */
    uint64_t coefficients;          /* wavelets that were kept */
    double   lost;                  /* relative L2 error, over all samples, of the wavelets that were not
                                       kept */
    size_t   peak_bytes;            /* the most memory that was asked of the allocator at once */
    uint64_t moved;                 /* sample points inside the mesh whose view was taken outside */
} sfield_stats;

SFIELD_DEF sfield_result sfield_build_emissive(const sfield_desc *desc, const sfield_mesh *mesh,
                                               const float *radiance, sfield_field **out,
                                               sfield_stats *stats);
/* Builds the source field of an emissive mesh.
   radiance  r, g, b of each triangle, 0..1e18 W/(sr m^2); with several frames one such array after the other.
             A triangle shines on the side from which its corners are counter-clockwise; for both sides give
             the triangle once more, turned over. A triangle of radiance 0 hides those behind it
   Errors    as sfield_build; SFIELD_ERR_INPUT also for a radiance out of its range */

typedef void (*sfield_view_fn)(void *user, float time, const float position[3], const float direction[3],
                               float rgb[3]);
/* A function of yours that writes what arrives at a position from a direction: for sources the radiance, for
   occlusion alpha in rgb[0], 1 = hidden. parallel_for's threads call the function. Values that are negative
   or not finite count as 0, those above 1e18 as 1e18.
   time       seconds from the first frame
   position   in the field's space
   direction  unit, pointing away from the position */

typedef enum sfield_emitter_kind {  /* the shape of an analytic light */
    SFIELD_EMITTER_DEFAULT,         /* = SFIELD_EMITTER_SPHERE */
    SFIELD_EMITTER_SPHERE,          /* a sphere of `radius` about the centre */
    SFIELD_EMITTER_DISC,            /* a disc of `radius` about the centre, which shines along `normal` */
    SFIELD_EMITTER_RECTANGLE,       /* a rectangle about the centre with the half axes u and v, which shines
                                       along u x v */
    SFIELD_EMITTER_LINE,            /* a line about the centre, from -u to u, of no width. Its radiance is in
                                       W/(sr m): that of a thin tube times the diameter of the tube */
    SFIELD_EMITTER_CYLINDER,        /* a lamp tube: the side of a cylinder of `radius` about the centre, from
                                       -u to u. Whoever looks into an open end sees the dark; points within
                                       the tube see light all round, as those within a sphere do */
    SFIELD_EMITTER_CALLBACK,        /* whatever view_fn says. Directions that miss the bounding sphere are not
                                       asked */
    SFIELD_EMITTER_COUNT
} sfield_emitter_kind;

typedef struct sfield_emitter {     /* an analytic light in the field's space, about desc.center */
    sfield_emitter_kind kind;
    float radius;                   /* of a sphere, disc or cylinder, 1e-17..1e17 */
    float normal[3];                /* of a disc, unit; the others but rectangles may have one, or 0 0 0 */
    float u[3], v[3];               /* of a rectangle, any length; half a diagonal is 1e-17..1e17. u alone of
                                       a line or cylinder, whose bounding sphere has a radius in that range */
    float radiance[3];              /* r, g, b, 0..1e18 W/(sr m^2); of a line, W/(sr m) */
    float cone_half_angle;          /* the light leaves within this angle about the normal, 0..pi; 0 = pi / 2.
                                       What may have a normal and has none shines everywhere */
    sfield_view_fn view_fn;         /* of SFIELD_EMITTER_CALLBACK */
    void *user;                     /* given to view_fn */
} sfield_emitter;

SFIELD_DEF sfield_result sfield_build_emitter(const sfield_desc *desc, const sfield_emitter *emitter,
                                              sfield_field **out, sfield_stats *stats);
/* Builds the source field of an analytic light or of a callback. desc and stats may be NULL, but a callback
   needs desc.radius.
   Errors  SFIELD_ERR_DESC (a field of desc or emitter), SFIELD_ERR_ARGUMENT (NULL), SFIELD_ERR_ALLOC,
           SFIELD_ERR_LIMIT, SFIELD_ERR_CANCELLED */

SFIELD_DEF sfield_result sfield_build_callback(const sfield_desc *desc, sfield_view_fn alpha_fn, void *user,
                                               sfield_field **out, sfield_stats *stats);
/* Builds an occlusion field by asking a function of yours, such as a ray tracer's, whether each direction
   from each sample point is hidden. desc is needed, since desc.radius must be set.
   alpha_fn  called with user for several directions in each texel; what it writes above 1 counts as 1
   Errors    as sfield_build_emitter */

typedef struct sfield_views {       /* sample points, 1..256 at a time, from which your renderer is to look */
    float        center[3], radius; /* bounding sphere of the field */
    float        time;              /* seconds from the first frame of a source */
    size_t       count;             /* eyes */
    const float *eyes;              /* (position - center) / radius, three floats each. Eyes lie on the shell,
                                       or just outside the mesh */
    float       *values;            /* to be written, for one eye after the other: alpha, where 1 is hidden;
                                       of sources r, then g, then b. Harmonics: bands^2 coefficients, as
                                       sfield_sh_project makes them from texels. Wavelets: 6 N^2 texels */
} sfield_views;

typedef int (*sfield_views_fn)(void *user, const sfield_views *views);
/* A function of yours that fills views->values. The thread that called sfield_build_views calls the function,
   shell after shell. Returns 0 to go on; anything else ends the build. */

SFIELD_DEF sfield_result sfield_build_views(const sfield_desc *desc, int source, const sfield_mesh *mesh,
                                            sfield_views_fn see_fn, void *user, sfield_field **out,
                                            sfield_stats *stats);
/* Builds a field whose cubes another renderer draws and projects, such as gl_shadowfield.h.
   sfield_build_views itself applies windows and logarithms, chooses wavelets and compresses.
   source   not 0: the field is a source's, and values are radiances; 0: it is of occlusion
   mesh     the mesh that you draw. The bounding sphere and the inscribed one are taken from it, and sample
            points inside it are asked again from outside (desc.keep_inside). NULL: desc.radius must be set,
            no sphere is inscribed, and no sample point is moved
   see_fn   called with user. Values that are not finite, or beyond 1e18 (of occlusion 100), count as 0
   Errors   as sfield_build; SFIELD_ERR_CANCELLED also if see_fn returned not 0 */

SFIELD_DEF sfield_result sfield_build_self(const sfield_desc *desc, const sfield_mesh *mesh,
                                           const sfield_points *points, float offset, sfield_field **out,
                                           sfield_stats *stats);
/* Builds the self-visibility of points on a mesh (O_p in the paper), for sfield_points.self: what each point
   sees from its position + offset x its normal. Harmonics store visibility x max(0, cosine), wavelets the
   occlusion. A point inside another part of the mesh looks from outside too (desc.keep_inside).
   points   count (1..2^31 - 1), positions (-1e18..1e18) and normals with their strides; the other members are
            not read
   offset   0..1e18, in units of the mesh; a thousandth of its size keeps a point from seeing its own triangle
   Errors   as sfield_build; SFIELD_ERR_ARGUMENT also for a stride, no points or the offset; SFIELD_ERR_INPUT
            also for positions out of range and normals that are not unit */

typedef struct sfield_placement {   /* where the sample points of a field are to lie */
    uint32_t shell_count;           /* for desc.shell_count */
    float    radii[64];             /* for desc.radii, shell_count of them */
    uint32_t position_side;         /* for desc.position_side */
    float    between;               /* the greatest error that was measured between shells ... */
    float    across;                /* ... and between the points of a shell */
} sfield_placement;

SFIELD_DEF sfield_result sfield_place(const sfield_desc *desc, const sfield_mesh *mesh,
                                      const sfield_emitter *emitter, float bound, sfield_placement *out);
/* Chooses the sample points of a field by the error of interpolation that it measures: what queries would
   interpolate beside what is seen, from 26 directions at 129 distances, and in 24 squares of each shell. Give
   the same desc with these values to sfield_build or sfield_build_emitter. Errors leave out what 8 bits or
   `keep` lose. With wavelets they are those of means over 8 x 8 squares a face.
   desc     as for the build, NULL = all defaults. Shells lie from inner to outer, or from the first to the
            last of desc.radii. shell_count is the most that may be used (0: 64 with a bound), and a
            position_side that is not 0 is kept. Points inside a mesh take their view from its surface, which
            jumps from point to point: with a bound set inner to 1 or more
   mesh     of an occlusion field, or NULL; one of mesh and emitter is given
   emitter  of a source field, or NULL. A function is asked at time 0 only
   bound    0..1, of the sum of both errors, half of it for each. They are RMS over all directions, at the
            worst distance: of visibility (or its logarithm, if that is stored), or of a source's radiance
            divided by the RMS of that. 0 = no bound: desc.shell_count shells (0: as for a build) are placed
            so that they err least
   out      written on SFIELD_OK only
   Errors   as sfield_build; SFIELD_ERR_ARGUMENT also for the bound and if mesh and emitter are both given or
            both NULL, SFIELD_ERR_LIMIT also if the bound needs more shells or points than there may be
   Cost     3,354 views, and 120 for each shell and each position_side that is tried; then, without a bound,
            up to 180,000 comparisons of 26 views, on one thread. Memory: as a build, and 0.3 MB (harmonics of
            4 bands) to 16 MB */

SFIELD_DEF sfield_result sfield_merge(const sfield_field *const *shards, size_t count,
                                      const sfield_system *system, sfield_field **out);
/* Joins the shards of one field, given in the order of their shells, from the first shell to the last. The
   bytes are those of the whole build. system may be NULL.
   Errors   SFIELD_ERR_ARGUMENT (a pointer is NULL, or count is 0), SFIELD_ERR_DESC (allocator),
            SFIELD_ERR_MISMATCH (these are not the shards of one field), SFIELD_ERR_LIMIT (more wavelets than
            one field has), SFIELD_ERR_ALLOC, SFIELD_ERR_CANCELLED */
#endif

typedef enum sfield_kind {          /* what a field holds */
    SFIELD_KIND_NONE,
    SFIELD_KIND_OCCLUSION,          /* what an object hides from points round it */
    SFIELD_KIND_SOURCE,             /* what a light radiates to points round it */
    SFIELD_KIND_SELF,               /* what an object hides from points on it: sfield_build_self */
    SFIELD_KIND_COUNT
} sfield_kind;

typedef struct sfield_info {        /* most fields are those of sfield_desc, with defaults in place of 0 */
    sfield_kind    kind;
    sfield_basis   basis;
    uint32_t       bands;
    uint32_t       cube_side;
    uint32_t       shell_count;
    uint32_t       position_side;
    uint32_t       frame_count;
    sfield_spacing spacing;
    int            logarithm;
    size_t         sample_count;    /* cubes that were recorded; of self-visibility: points */
    uint64_t       coefficient_count;   /* wavelets in all of these cubes */
    size_t         bytes;           /* of the field, in memory and as a file */
    float          center[3], radius;
    float          inscribed;       /* radius of a sphere about the centre inside the closed mesh; 0 = none is
                                       known */
    float          inner, outer;    /* radii of the first and last shell, in radii of the bounding sphere */
    uint32_t       shard_begin, shard_end; /* 0, 0: the field is whole */
} sfield_info;

SFIELD_DEF void sfield_get_info(const sfield_field *field, sfield_info *out);
/* Writes what a field is. If field or out is NULL, nothing is written. */

SFIELD_DEF sfield_result sfield_query(const sfield_field *field, size_t count, const float *positions,
                                      float time, float *out);
/* Interpolates what is seen from positions, each between eight samples of the field.
   positions  three floats each, in the field's own space. From a position that is not finite nothing is seen:
              visibility 1, radiance 0
   time       seconds, of a source with frames
   out        visibility (or its logarithm, if that is stored) or radiance, for one position after the other:
              bands^2 coefficients or, with wavelets, 6 N^2 texels; of sources of r, then of g, then of b
   Errors     SFIELD_ERR_ARGUMENT (NULL), SFIELD_ERR_MISMATCH (self-visibility, a shard) */

#ifndef SFIELD_WITHOUT_TABLES
SFIELD_DEF sfield_result sfield_self(const sfield_field *field, size_t first, size_t count, float *out);
/* Writes the self-visibility of count points from point `first` on, as it is stored.
   out      for each point bands^2 coefficients or, with wavelets, 6 N^2 texels
   Errors   SFIELD_ERR_ARGUMENT (NULL, points beyond the last), SFIELD_ERR_MISMATCH (a field of another
            kind) */
#endif

SFIELD_DEF sfield_result sfield_ambient(const sfield_field *field, size_t count, const float *positions,
                                        float *out);
/* Writes the share of all directions that an object leaves open at each position, 0..1: one float each, for
   ambient occlusion. With harmonics the first coefficient alone is read, which makes this much cheaper than
   sfield_query.
   positions  three floats each, in the field's own space; one that is not finite gets 1
   Errors     SFIELD_ERR_ARGUMENT (NULL), SFIELD_ERR_MISMATCH (not an occlusion field, one of logarithms, a
              shard) */

SFIELD_DEF size_t sfield_bytes(const sfield_field *field);
/* Returns how many bytes sfield_write needs; 0 for NULL. */

SFIELD_DEF sfield_result sfield_write(const sfield_field *field, void *memory, size_t memory_bytes);
/* Writes a field as a file into your memory, little-endian: docs/shadowfield-format.md describes the bytes.
   Errors  SFIELD_ERR_ARGUMENT (NULL), SFIELD_ERR_MEMORY (memory_bytes is below sfield_bytes) */

SFIELD_DEF sfield_result sfield_open(const void *data, size_t bytes, const sfield_system *system,
                                     sfield_field **out);
/* Makes a field from a file in memory, of which nothing is needed afterwards. Every size, offset, index and
   number in the file is checked. It takes `bytes` of memory, and up to 18,000 more. system may be NULL.
   Errors  SFIELD_ERR_ARGUMENT (data or out is NULL), SFIELD_ERR_DESC (allocator), SFIELD_ERR_FORMAT (not a
           file of this header, or a damaged one), SFIELD_ERR_VERSION (a file of an unknown version),
           SFIELD_ERR_MISMATCH (wavelets, in a header joined without them), SFIELD_ERR_ALLOC,
           SFIELD_ERR_CANCELLED */
