/* ---- page one: a sky becomes lights ---- */

#define ENVLT_RESULTS(X)                                                                                     \
    X(ENVLT_OK, "ok")                                                                                        \
    X(ENVLT_ERR_ARGUMENT, "a pointer is NULL, or a count or stride is out of range")                         \
    X(ENVLT_ERR_DESC, "a field of a desc is out of range")                                                   \
    X(ENVLT_ERR_INPUT, "the data cannot be used")                                                            \
    X(ENVLT_ERR_ALLOC, "the allocator returned no memory")                                                   \
    X(ENVLT_ERR_MEMORY, "the caller's memory is too small or misaligned")                                    \
    X(ENVLT_ERR_LIMIT, "a size overflows or passes a limit")                                                 \
    X(ENVLT_ERR_CANCELLED, "cancelled by the progress callback")                                             \
    X(ENVLT_ERR_ORDER, "this call comes too early, too late or twice")                                       \
    X(ENVLT_ERR_FORMAT, "not a file of this kind, or a damaged one")                                         \
    X(ENVLT_ERR_VERSION, "a file of an unknown version")                                                     \
    X(ENVLT_ERR_MISMATCH, "what was given does not belong together")

typedef enum envlt_result {
#define ENVLT__ENUM(name, text) name,
    ENVLT_RESULTS(ENVLT__ENUM)
#undef ENVLT__ENUM
    ENVLT_RESULT_COUNT
} envlt_result;

typedef enum envlt_projection {
    ENVLT_PROJECTION_DEFAULT,       /* = ENVLT_PROJECTION_LATLONG */
    ENVLT_PROJECTION_LATLONG,       /* latitude and longitude: row 0 is +Y */
    ENVLT_PROJECTION_CUBE,          /* six faces, +X -X +Y -Y +Z -Z */
    ENVLT_PROJECTION_COUNT
} envlt_projection;

typedef struct envlt_map {          /* the sky */
    envlt_projection projection;
    uint32_t     width, height;     /* of the map, or of a face of a cube: those are squares. At most 2^27
                                       texels in all */
    const float *rgb;               /* linear radiance of each texel; row 0 first, the faces of a cube one
                                       after another */
    size_t       texel_stride;      /* bytes from one texel to the next, a multiple of 4, >= 12; 0 = 12 */
} envlt_map;

typedef struct envlt_light {        /* a directional light that stands for a stratum, a region of the map */
    float    direction[3];          /* unit, to the light: mean of the stratum's directions, weighted by
                                       luminance */
    float    irradiance[3];         /* on a plane that faces it: radiance x solid angle over the stratum,
                                       W/m^2 */
    float    solid_angle;           /* of the stratum, sr */
    float    axis_u[3], axis_v[3];  /* extent: half axes of the ellipse with the spread of its radiance, at
                                       right angles to direction and each other; |axis_u| >= |axis_v|,
                                       tangents of angles, below 1e3 */
    uint32_t id;                    /* stays with a light through envlt_follow and envlt_match */
    uint32_t flags;                 /* ENVLT_LIGHT_SUN or 0 */
} envlt_light;

#define ENVLT_LIGHT_SUN 1u          /* the light is what split_sun took out of the map */

typedef struct envlt_lights envlt_lights;   /* lights and their strata, kept from frame to frame */
typedef struct envlt_desc envlt_desc;       /* how many lights, by which method: below */
typedef struct envlt_stats envlt_stats;     /* what a call counted: below */

ENVLT_DEF envlt_result envlt_create(const envlt_desc *desc, const envlt_map *map, envlt_lights **out,
                                    envlt_stats *stats);
/* Makes lights whose energy is the map's, which envlt_free takes back. The map is not kept.
   desc    NULL = all defaults: 128 lights by minimum variance
   out     written on ENVLT_OK only; a black map gives 0 lights
   stats   may be NULL
   Errors  ENVLT_ERR_ARGUMENT (NULL, a side of 0, the stride), ENVLT_ERR_DESC, ENVLT_ERR_INPUT (the
           projection, or faces that are not squares), ENVLT_ERR_LIMIT, ENVLT_ERR_ALLOC
   Cost    about 20 ms for 1024 x 512 texels and 300 lights; O(texels log k) */

ENVLT_DEF const envlt_light *envlt_get_lights(const envlt_lights *lights, uint32_t *count);
/* Returns the lights, valid until the next envlt_follow or envlt_free. envshadow.h takes them as they lie
   there. NULL for NULL; count may be NULL. */

ENVLT_DEF envlt_result envlt_follow(envlt_lights *lights, const envlt_map *map, uint32_t light_count,
                                    envlt_stats *stats);
/* Takes the next frame of a video map, or another number of lights. Strata stay, so that a light moves by
   what changed inside its own; where the video has made shares very uneven, at most an eighth of the lights,
   or as many as light_count asks for, begin anew (with a new id) by splitting the stratum that spreads most,
   and the two neighbours that lose least are merged. The same map and count give the same bytes (after
   ENVLT_METHOD_CDF from the second call on: it then takes mean directions).
   light_count  0 = as before; where the map was too black for that, as many as were asked for, as soon as
                another has the texels: all begin anew then. So give what keeps the lights room for as many as
                you ask for
   Errors  those of envlt_create; ENVLT_ERR_MISMATCH for a map of another size or projection. The lights are
           as they were
   Cost    O(texels + k^2), and O(texels) for each light that begins anew, of its stratum only. Memory: 32
           bytes a texel meanwhile, 37 with split_sun */

ENVLT_DEF void envlt_free(envlt_lights *lights);
/* Takes back the lights and their memory; NULL is allowed. */

ENVLT_DEF const char *envlt_result_text(envlt_result result);
/* Returns a constant string for any value, "unknown result" beyond the list. */

/* ---- memory, threads, progress, log: the caller's ---- */

typedef struct envlt_allocator {    /* all zero: malloc and free; else both functions */
    void *(*alloc_fn)(size_t bytes, void *user);    /* aligned like malloc's (8 bytes suffice), or NULL */
    void (*free_fn)(void *memory, void *user);
    void *user;
} envlt_allocator;

typedef void (*envlt_task)(void *context, size_t index);

typedef struct envlt_system {       /* all zero: malloc and free, this thread alone, no progress, no log */
    envlt_allocator allocator;      /* called from the thread that called us */
    void (*parallel_for)(void *user, size_t count, envlt_task task, void *context);
    /* Must call task(context, i) once for each i < count, in any order and on any threads, and return when
       all are done. What is computed does not depend on the threads. This header does not call parallel_for:
       it computes for milliseconds. */
    int (*progress)(void *user, float fraction);
    /* Called from the thread that called us, fraction 0..1 never falling within a call; not 0 cancels. This
       header does not call it. */
    void (*log)(void *user, const char *message);
    /* Called at most once by a call that fails, from the thread that called us, before it returns: one line
       without a line end that names the function, the field or element, its value and its range. */
    void *user;                     /* given to parallel_for, progress and log */
} envlt_system;

/* ---- settings and counts ---- */

typedef enum envlt_method {
    ENVLT_METHOD_DEFAULT,           /* = ENVLT_METHOD_VARIANCE, the best by measurement
                                       (docs/measured/envlights.md) */
    ENVLT_METHOD_STRUCTURED,        /* structured importance sampling, Agarwal et al. 2003. All methods are
                                       this one where a cube map becomes fewer than 6 lights (the sun not
                                       counted) */
    ENVLT_METHOD_MEDIAN_CUT,        /* Debevec 2005, for any number of lights */
    ENVLT_METHOD_VARIANCE,          /* minimum variance, after Viriyothai and Debevec 2009 */
    ENVLT_METHOD_CDF,               /* stratified inversion of the distribution: the baseline */
    ENVLT_METHOD_COUNT
} envlt_method;

#define ENVLT_MAX_LIGHTS 8192u

struct envlt_desc {                 /* zero it, then set what you care about */
    envlt_system system;
    uint32_t     light_count;       /* k, 1..ENVLT_MAX_LIGHTS; 0 = 128. Fewer come where the map has fewer lit
                                       texels, or cuts fall into single texels or below the horizon: take the
                                       count that comes */
    envlt_method method;
    int          hemisphere;        /* not 0: only directions with y > 0 count */
    int          split_sun;         /* not 0: a small spot that outshines a light's share becomes light 0 of
                                       its own, here or when it comes up in envlt_follow; where it goes out,
                                       light 0 stays what it was until there is a spot again */
};

struct envlt_stats {
    uint32_t lights;                /* how many there are now */
    uint32_t changed;               /* envlt_follow: lights that were split off, and thus begin anew */
    uint64_t bad_texels;            /* with a channel that is not finite, negative or above 1e30: it counts as
                                       0 */
    double   energy[3];             /* integral of the map over what counts, W/m^2 */
    float    largest_move;          /* envlt_follow: of a light that stayed, radians */
    float    mean_move;             /* the same, weighted by energy */
    size_t   peak_bytes;            /* asked of the allocator at once, kept memory included */
};

/* ---- turning, jittering, matching ---- */

ENVLT_DEF envlt_result envlt_rotate(envlt_light *lights, uint32_t count, const float rotation[16]);
/* Turns directions and extents with the environment (Knuth and Fuhrmann, section 3). The lengths of extents
   do not change.
   rotation  columns at right angles and of equal length within 1e-4, of length 1 within 1e-3, else
             ENVLT_ERR_INPUT */

ENVLT_DEF envlt_result envlt_jitter(const envlt_lights *lights, uint32_t frame, uint32_t seed,
                                    envlt_light *out);
/* Writes the same lights with directions inside their strata, chosen in proportion to luminance, other ones
   each frame (a low-discrepancy sequence): the mean of many frames tends to the exact picture. Energy stays
   exact in each frame. Extents stay as they are, at right angles to the light's own direction.
   out     as many as there are lights */

ENVLT_DEF envlt_result envlt_match(const envlt_light *previous, uint32_t previous_count, envlt_light *lights,
                                   uint32_t count);
/* Reorders the lights of another build, for maps that change their size or method: the previous lights,
   brightest first, give place and id to the nearest light that is left. Of more previous lights than there
   are now the faintest are forgotten, and a light whose place is beyond count takes a forgotten one's. The
   rest follow with new ids.
   Cost    O(previous_count x count) */

/* ---- what a light stands for, and what all of them leave out ---- */

#define ENVLT_NO_LIGHT UINT32_MAX   /* stratum of texels below the horizon of hemisphere */

ENVLT_DEF const uint32_t *envlt_get_strata(const envlt_lights *lights, size_t *count);
/* Returns for each texel of the map the index of its light, or ENVLT_NO_LIGHT. count, which may be NULL, is
   that of the texels. */

ENVLT_DEF envlt_result envlt_residual(const envlt_lights *lights, const envlt_map *map, float *rgb);
/* Writes map minus lights, each light spread evenly over its stratum: 3 floats a texel, negative ones too;
   their integral over every stratum is 0 in every channel. For glossy or unshadowed detail by your own means.
   Errors  those of a map; ENVLT_ERR_MISMATCH for one of another size or projection */

ENVLT_DEF envlt_result envlt_residual_sh(const envlt_lights *lights, const envlt_map *map, float sh[27]);
/* Writes map minus lights as directions, in 9 spherical harmonics x 3 channels (sh[3 j + channel]); those of
   j = 0 are 0 but for rounding, since energy is exact. envlt_sh_irradiance of it makes unshadowed shading
   exact to that order.
   Errors  as envlt_residual */

ENVLT_DEF void envlt_sh_irradiance(const float sh[27], const float normal[3], float rgb[3]);
/* Writes the irradiance of a surface with that unit normal, W/m^2; it may be negative for a residual. */

/* ---- glTF ---- */

ENVLT_DEF size_t envlt_gltf_bytes(const envlt_light *lights, uint32_t count);
/* Returns the bytes that envlt_gltf_write needs, with the zero at the end of the text. 0 for NULL. */

ENVLT_DEF envlt_result envlt_gltf_write(const envlt_light *lights, uint32_t count, char *text, size_t bytes);
/* Writes a glTF 2.0 document with a node and a KHR_lights_punctual directional light for each, and a zero
   behind it. W/m^2 go where lux are expected. Numbers that are not finite become 0.
   Errors  ENVLT_ERR_ARGUMENT (NULL), ENVLT_ERR_MEMORY: fewer bytes than envlt_gltf_bytes says; nothing is
           written */

/* ---- texels of a map ---- */

ENVLT_DEF double envlt_texel_solid_angle(envlt_projection projection, uint32_t width, uint32_t height,
                                         uint32_t x, uint32_t y);
/* Returns the steradians of texel x, y (of any face of a cube), exactly: all texels add up to 4 pi. 0 outside
   the map. */

ENVLT_DEF void envlt_texel_direction(envlt_projection projection, uint32_t width, uint32_t height,
                                     uint32_t face,
                                     float x, float y, float direction[3]);
/* Writes the unit direction of the point x, y in texels from the top left corner; + 0.5 is a texel's centre.
   face    of a cube, else 0
   x, y    beyond the map the direction goes on round the sphere, or on the face's plane, to 8 times the map's
           size; what is not finite counts as 0 */

#ifdef __cplusplus
}
#endif

#endif /* ENVLIGHTS_H */
