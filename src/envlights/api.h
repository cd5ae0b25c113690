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

typedef enum envlt_projection {     /* how the sphere of directions lies on a map */
    ENVLT_PROJECTION_DEFAULT,       /* = ENVLT_PROJECTION_LATLONG */
    ENVLT_PROJECTION_LATLONG,       /* latitude and longitude: row 0 is +Y */
    ENVLT_PROJECTION_CUBE,          /* six faces, +X -X +Y -Y +Z -Z */
    ENVLT_PROJECTION_COUNT
} envlt_projection;

typedef struct envlt_map {          /* the sky */
    envlt_projection projection;
    uint32_t     width, height;     /* of the map, or of one face of a cube, which must be a square; at most
                                       2^27 texels in all */
    const float *rgb;               /* linear radiance of each texel, W/(sr m^2); row 0 first, the faces of a
                                       cube one after another */
    size_t       texel_stride;      /* bytes from one texel to the next, a multiple of 4, >= 12; 0 = 12 */
} envlt_map;

typedef struct envlt_light {        /* a directional light that stands for a stratum, a region of the map */
    float    direction[3];          /* unit, towards the light: the mean of the stratum's directions, weighted
                                       by luminance */
    float    irradiance[3];         /* of a surface that faces the light, W/m^2: the sum of radiance x solid
                                       angle over the stratum */
    float    solid_angle;           /* of the stratum, sr */
    float    axis_u[3], axis_v[3];  /* extent: half axes of the ellipse over which the stratum's radiance
                                       spreads, at right angles to direction and to each other, with
                                       |axis_u| >= |axis_v|. Lengths are tangents of angles, below 1e3 */
    uint32_t id;                    /* stays with a light through envlt_follow and envlt_match */
    uint32_t flags;                 /* ENVLT_LIGHT_SUN or 0 */
} envlt_light;

#define ENVLT_LIGHT_SUN 1u          /* the light is what split_sun took out of the map */

typedef struct envlt_lights envlt_lights;   /* lights and their strata, kept from frame to frame */
typedef struct envlt_desc envlt_desc;       /* how many lights, by which method: below */
typedef struct envlt_stats envlt_stats;     /* what a call counted: below */

ENVLT_DEF envlt_result envlt_create(const envlt_desc *desc, const envlt_map *map, envlt_lights **out,
                                    envlt_stats *stats);
/* Makes lights that together have the energy of the map. The map is not kept.
   desc    NULL = all defaults: 128 lights by minimum variance
   out     receives the lights, on ENVLT_OK only; give them back by envlt_free. A black map gives 0 lights
   stats   may be NULL; receives what the call counted, on ENVLT_OK only
   Errors  ENVLT_ERR_ARGUMENT: map, map->rgb or out is NULL, a side is 0, the faces of a cube are not squares,
           or the stride is out of range.
           ENVLT_ERR_DESC: a field of desc is out of range.
           ENVLT_ERR_INPUT: there is no such projection.
           ENVLT_ERR_LIMIT: the map has more than 2^27 texels.
           ENVLT_ERR_ALLOC: the allocator returned no memory.
   Cost    about 20 ms for 1024 x 512 texels and 300 lights; the time is O(texels log k) */

ENVLT_DEF const envlt_light *envlt_get_lights(const envlt_lights *lights, uint32_t *count);
/* Returns the array of lights, which is valid until the next envlt_follow or envlt_free, and writes how many
   there are. envshadow.h can read the array as it is: envsh_lights with a stride of sizeof(envlt_light).
   lights  NULL gives NULL and a count of 0
   count   may be NULL */

ENVLT_DEF envlt_result envlt_follow(envlt_lights *lights, const envlt_map *map, uint32_t light_count,
                                    envlt_stats *stats);
/* Changes the lights to those of the next frame of a video map, or to another number of lights. Each light
   keeps its stratum, so that a light moves only by what changed in its stratum. If the video has made the
   shares of the lights very uneven, the stratum that spreads most is split, and the two neighbours that lose
   least by it are merged, for at most an eighth of the lights a call; lights that come of a split have a new
   id. A call with the same map and the same count as the call before leaves the lights as they are (except
   for the first call after ENVLT_METHOD_CDF, from which on these lights take mean directions).
   map          of the size and projection that envlt_create was given
   light_count  the number of lights wanted, 1..ENVLT_MAX_LIGHTS; 0 = as many as there are. If an earlier map
                had fewer lit texels than lights were wanted, as a nearly black sky does, 0 still wants that
                number: the first map with more lit texels builds all lights anew, with new ids. So a copy of
                the lights needs room for the number wanted, not for the number that came
   stats        may be NULL; receives what the call counted, on ENVLT_OK only
   Errors       those of envlt_create for the map, and these, after all of which the lights are as they were.
                ENVLT_ERR_ARGUMENT: lights is NULL, or light_count is above ENVLT_MAX_LIGHTS.
                ENVLT_ERR_MISMATCH: the map has another size or projection.
   Cost         time is O(texels + k^2), and for each split the time of the stratum's texels; memory
                meanwhile is 32 bytes a texel, 37 with split_sun, and 300 a light */

ENVLT_DEF void envlt_free(envlt_lights *lights);
/* Gives back the lights and their memory. NULL is allowed. */

ENVLT_DEF const char *envlt_result_text(envlt_result result);
/* Returns a constant string that says what a result means; "unknown result" for a number that is none. */

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

typedef enum envlt_method {         /* how the map is cut into strata: "How it works" above */
    ENVLT_METHOD_DEFAULT,           /* = ENVLT_METHOD_VARIANCE, the best by measurement
                                       (docs/measured/envlights.md) */
    ENVLT_METHOD_STRUCTURED,        /* structured importance sampling, Agarwal et al. 2003. A cube map with
                                       fewer than 6 lights, the sun not counted, is cut by this method
                                       whatever you set */
    ENVLT_METHOD_MEDIAN_CUT,        /* median cut, Debevec 2005, for any number of lights */
    ENVLT_METHOD_VARIANCE,          /* minimum variance, after Viriyothai and Debevec 2009 */
    ENVLT_METHOD_CDF,               /* inversion of the cumulative distribution, the simplest of the four */
    ENVLT_METHOD_COUNT
} envlt_method;

#define ENVLT_MAX_LIGHTS 8192u      /* the most lights that envlt_create makes */

struct envlt_desc {                 /* zero it, then set what you care about */
    envlt_system system;
    uint32_t     light_count;       /* k, 1..ENVLT_MAX_LIGHTS; 0 = 128. There may be fewer lights, if the map
                                       has fewer lit texels or cuts fall into single texels or below the
                                       horizon: use the count of envlt_get_lights */
    envlt_method method;
    int          hemisphere;        /* not 0: only directions with y > 0 count */
    int          split_sun;         /* not 0: the brightest spot becomes light 0, with a stratum of its own,
                                       if the spot is smaller than 0.03 sr and has at least a light's share of
                                       the energy. If such a spot comes up in a later map, envlt_follow makes
                                       it light 0; if it goes out, light 0 keeps its place until a spot comes
                                       up again */
};

struct envlt_stats {                /* what envlt_create and envlt_follow counted */
    uint32_t lights;                /* how many lights there are now */
    uint32_t changed;               /* envlt_follow: how many lights have a new id */
    uint64_t bad_texels;            /* texels with a channel that is not finite, negative or above 1e30; such
                                       a channel counts as 0 */
    double   energy[3];             /* integral of radiance over all directions that count, W/m^2 */
    float    largest_move;          /* envlt_follow: the largest angle by which a light that kept its id
                                       turned, radians */
    float    mean_move;             /* the mean of these angles, weighted by energy */
    size_t   peak_bytes;            /* the most bytes that the allocator had given out at once */
};

/* ---- turning, jittering, matching ---- */

ENVLT_DEF envlt_result envlt_rotate(envlt_light *lights, uint32_t count, const float matrix[16]);
/* Turns directions and extents of lights with the environment (Knuth and Fuhrmann, section 3), in place. The
   lengths of extents do not change.
   matrix    a rotation: columns must be at right angles and of equal length within 1e-4, and of length 1
             within 1e-3
   Errors    this call has no log.
             ENVLT_ERR_ARGUMENT: matrix is NULL, or lights is NULL and count is not 0.
             ENVLT_ERR_INPUT: the matrix is not a rotation, or a light's direction is not unit. */

ENVLT_DEF envlt_result envlt_jitter(const envlt_lights *lights, uint32_t frame, uint32_t seed,
                                    envlt_light *out);
/* Writes the lights with other directions, each of them inside the light's stratum and chosen in proportion
   to luminance. Each frame has its own directions, by a low-discrepancy sequence, so that the mean of many
   frames tends to the exact picture. Energy is exact in each frame. Extents stay as they are, at right angles
   to the direction that the light had before.
   frame   the number of the frame
   seed    another seed gives other directions
   out     receives as many lights as there are
   Errors  ENVLT_ERR_ARGUMENT: lights or out is NULL. */

ENVLT_DEF envlt_result envlt_match(const envlt_light *previous, uint32_t previous_count, envlt_light *lights,
                                   uint32_t count);
/* Reorders the lights of a new build so that each stands where a previous light like it stood, with the same
   id, for maps that change their size or method. The previous lights, brightest first, give their place and
   id to the nearest light that is left. If there are more previous lights than new ones, the faintest
   previous lights are forgotten, and a light whose place is beyond count takes the place of a forgotten one.
   If there are fewer previous lights, the other new lights follow with new ids.
   Errors  this call has no log.
           ENVLT_ERR_ARGUMENT: an array is NULL and its count is not 0.
           ENVLT_ERR_INPUT: a light's direction is not unit.
   Cost    O(previous_count x count) */

/* ---- what a light stands for, and what all of them leave out ---- */

#define ENVLT_NO_LIGHT UINT32_MAX   /* stands for a texel that no light stands for: below the horizon with
                                       desc.hemisphere, or in a black map */

ENVLT_DEF const uint32_t *envlt_strata(const envlt_lights *lights, size_t *count);
/* Returns an array that has for each texel of the map the index of its light, or ENVLT_NO_LIGHT, and writes
   how many texels there are. The array is valid until the next envlt_follow or envlt_free.
   lights  NULL gives NULL and a count of 0
   count   may be NULL */

ENVLT_DEF envlt_result envlt_residual(const envlt_lights *lights, const envlt_map *map, float *rgb);
/* Writes the radiance of the map minus that of the lights, each light spread evenly over its stratum: what a
   renderer may add by other means, glossy or without shadows. The integral over every stratum is 0 in every
   channel.
   rgb     receives 3 floats a texel, negative ones too
   Errors  those of envlt_create for the map, and these.
           ENVLT_ERR_ARGUMENT: lights, map or rgb is NULL.
           ENVLT_ERR_MISMATCH: the map has another size or projection than that of the lights. */

ENVLT_DEF envlt_result envlt_residual_sh(const envlt_lights *lights, const envlt_map *map, float sh[27]);
/* Writes the radiance of the map minus that of the lights, each light at its direction, as 9 spherical
   harmonics for each channel. If you add envlt_sh_irradiance of them, shading without shadows is exact to
   that order.
   sh      receives sh[3 j + channel] for harmonic j. Harmonic 0 comes out as 0 but for rounding, since the
           lights have the energy of the map
   Errors  those of envlt_residual; ENVLT_ERR_ARGUMENT also if sh is NULL. */

ENVLT_DEF void envlt_sh_irradiance(const float sh[27], const float normal[3], float rgb[3]);
/* Writes the irradiance that radiance given as harmonics makes on a surface, W/m^2. It may be negative if the
   harmonics are those of a residual.
   normal  unit. This function returns no result and checks no length: the irradiance is that of the vector as
           it is */

/* ---- glTF ---- */

ENVLT_DEF size_t envlt_gltf_bytes(const envlt_light *lights, uint32_t count);
/* Returns the bytes that envlt_gltf_write needs, the zero at the end of the text included, or 0 if lights is
   NULL. */

ENVLT_DEF envlt_result envlt_gltf_write(const envlt_light *lights, uint32_t count, char *text, size_t bytes);
/* Writes a glTF 2.0 document with a node and a directional light of KHR_lights_punctual for each light, and a
   zero at the end of the text. Intensities are written in W/m^2, where glTF expects lux. Numbers that are not
   finite become 0.
   Errors  this call has no log.
           ENVLT_ERR_ARGUMENT: lights or text is NULL.
           ENVLT_ERR_INPUT: a light's direction is not unit.
           ENVLT_ERR_MEMORY: bytes is less than envlt_gltf_bytes returns. */

/* ---- texels of a map ---- */

ENVLT_DEF double envlt_texel_solid_angle(envlt_projection projection, uint32_t width, uint32_t height,
                                         uint32_t x, uint32_t y);
/* Returns the solid angle of texel x, y in steradians, exactly: all texels of a map add up to 4 pi. All
   faces of a cube have the same solid angles. Returns 0 for texels outside the map. */

ENVLT_DEF void envlt_texel_direction(envlt_projection projection, uint32_t width, uint32_t height,
                                     uint32_t face, float x, float y, float direction[3]);
/* Writes the unit direction towards the point x, y of a map.
   face    0..5 of a cube, else 0
   x, y    in texels from the top left corner: the centre of texel (i, j) is at (i + 0.5, j + 0.5). Beyond the
           map the point goes on round the sphere, or on the plane of the face, up to 8 times the map's size.
           A number that is not finite counts as 0 */

#ifdef __cplusplus
}
#endif

#endif /* ENVLIGHTS_H */
