/* ---- page one: direct light in a picture, with shadows by the blocks of csm.h ----

   A program makes maps, lights and a renderer once. A frame:

       glbk_csm_maps_place(gl, &maps, instances, n);               // if an object has moved, and then
       glbk_csm_reset(&r);                                         // this, as if the camera or a light has
       glbk_gbuffer_begin(gl, &seen, world_to_clip, eye);          // or glbk_gbuffer_import, or _upload
       glbk_gbuffer_object(gl, &seen, &surface);                   // for each object, with your draw
       glbk_csm_render(gl, &r, &seen, &frame);
       glbk_csm_resolve(gl, &r, &seen, &pass, NULL); */

typedef struct glbk_csm_maps glbk_csm_maps;         /* blocks of csm.h, and where their objects stand */
typedef struct glbk_csm_lights glbk_csm_lights;     /* a table of lights */
typedef struct glbk_csm_renderer glbk_csm_renderer; /* the light of a picture, summed up over frames */
struct glbk_csm_block;              /* the maps of one object: see "structs of page one" below, as for all */
struct glbk_csm_instance;           /* an object of a scene: its block, and where it stands */
struct glbk_csm_lights_desc;        /* what a table of lights is made of */
struct glbk_csm_renderer_desc;      /* how large a picture is */
struct glbk_csm_frame_desc;         /* what shines in a frame, and how it is sampled */

GLBK_DEF glbk_result glbk_csm_maps_create(glbk_context *ctx, const struct glbk_csm_block *blocks,
                                          size_t count, uint32_t capacity, uint32_t *starts,
                                          glbk_csm_maps *out);
/* Uploads blocks, their bytes as they are, and makes room for instances, none of which is placed yet. Give
   them back by glbk_csm_maps_free.
   blocks     count of them; they are read during the call only
   capacity   the most instances that are ever placed, up to 2^28 / 5
   starts     receives for each block where it begins, for glbk_csm_instance.start
   out        zeroed on errors, like the out of all calls
   Memory     on the GPU the bytes of all blocks, and 80 bytes an instance beyond 16. What cohsm_fast_data
              returns is about 1.4 times as large as the block. Here 116 bytes a block
   Errors     GLBK_ERR_ARGUMENT: a pointer is NULL, or capacity is out of range. GLBK_ERR_FORMAT: not a block
              of csm.h, or a damaged one. GLBK_ERR_VERSION: a block of another version. GLBK_ERR_LIMIT: more
              than 4 GB, or than ctx->max_layers layers of 16 MB, of which GL guarantees 256.
              GLBK_ERR_ALLOC. Those of textures and buffers */

GLBK_DEF glbk_result glbk_csm_maps_place(glbk_context *ctx, glbk_csm_maps *maps,
                                         const struct glbk_csm_instance *instances, uint32_t count);
/* Replaces all instances of the scene, by one upload of 80 bytes an instance (3 KB if there are no more than
   16). Call it whenever an object has moved.
   count    0 .. maps->capacity
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_INPUT: a start is none of these maps', or a
            transform shears, mirrors or scales unevenly. GLBK_ERR_LIMIT: count is above maps->capacity.
            GLBK_ERR_ALLOC, with more than 16 instances */

GLBK_DEF glbk_result glbk_csm_lights_create(glbk_context *ctx, const struct glbk_csm_lights_desc *desc,
                                            uint32_t *starts, glbk_csm_lights *out);
/* Uploads lights as they are at their desc.time, lobes and patterns. Give them back by glbk_csm_lights_free.
   starts   receives for each light where it begins, for glbk_csm_use.start
   Memory   16 bytes a texel, on the GPU and here while it runs: 2 texels a lobe, 10 a light, 2 more for each
            texel of its L, 3 a triangle, 128 for each point of a pattern
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or a pointer, count or stride of a mesh is out of range.
            GLBK_ERR_DESC: a field is out of range. GLBK_ERR_INPUT: an index of a mesh is out of range, or a
            mesh has no area. GLBK_ERR_LIMIT: there are more than 2^28 texels. GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_csm_renderer_create(glbk_context *ctx, const struct glbk_csm_renderer_desc *desc,
                                              glbk_csm_renderer *out);
/* Makes a renderer without frames, which glbk_csm_renderer_free takes back. Programs that shade are compiled
   when they are first used: see glbk_csm_prepare. If ctx->compute is set, it renders by compute.
   Memory   on the GPU 32 bytes a pixel, 16 if it computes
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: a number is out of range. GLBK_ERR_LIMIT:
            width or height is above ctx->max_side. Those of textures, targets and glbk_program_compile */

GLBK_DEF glbk_result glbk_csm_render(glbk_context *ctx, glbk_csm_renderer *renderer,
                                     const glbk_gbuffer *gbuffer, const struct glbk_csm_frame_desc *desc);
/* Adds one frame of what the G-buffer holds to the sum: for each use sample_count / samples_per_pass passes.
   The first use of a combination of kind, ask, filter and defines of maps compiles a program
   (glbk_csm_prepare).
   After an error the sum may have some lights of the frame: call glbk_csm_reset.
   gbuffer   its entity is the number of the instance that a pixel lies on, its plane that of one of
             glbk_csm_frame_desc.planes, both counted from 1; its first_lobe counts in
             glbk_csm_lights_desc.lobes. Its occlusion, which is of bounced light, plays no part
   Errors    GLBK_ERR_ARGUMENT: a pointer is NULL, or an object was not created. GLBK_ERR_DESC: a field is out
             of range, or an object in it is NULL or was not created. GLBK_ERR_MISMATCH: a sample_count is not
             the patterns' length, or the G-buffer has another size. GLBK_ERR_LIMIT: the frame needs more than
             GLBK_CSM_MAX_PROGRAMS programs, or there were 2^32 - 1 frames. Those of glbk_program_compile and
             glbk_buffer_update */

GLBK_DEF glbk_result glbk_csm_resolve(glbk_context *ctx, glbk_csm_renderer *renderer,
                                      const glbk_gbuffer *gbuffer, const glbk_pass *pass,
                                      const glbk_picture *picture);
/* Draws the mean of the frames, linear radiance, to the pass's target, a texel a pixel; glbk_pass says how
   viewports cut it.
   gbuffer   the one that was rendered; it may be NULL if picture does not ask what is seen
   picture   may be NULL: every pixel is drawn, without depths
   Errors    GLBK_ERR_ARGUMENT: a pointer is NULL, gbuffer too if picture asks what is seen, or an object was
             not created. GLBK_ERR_MISMATCH: the G-buffer has another size. Those of glbk_begin */

/* ---- structs of page one ---- */

typedef struct glbk_csm_block {     /* the maps of one object: what cohsm_data returns, or cohsm_fast_data, by
                                       which questions are answered faster, with the same answers */
    const void *data;
    size_t      bytes;
} glbk_csm_block;

typedef struct glbk_csm_instance {
    uint32_t start;                 /* which block: what glbk_csm_maps_create wrote for it */
    float    transform[16];         /* object to world, column-major: a rotation, one scale > 0, a
                                       translation; all zero = the identity */
    float    offset;                /* world units by which the renderer moves receivers on this object along
                                       their geometric normal, lest they shadow themselves */
} glbk_csm_instance;

struct glbk_csm_maps {              /* read only; zeroed = none */
    glbk_texture blocks;            /* the table of all blocks */
    glbk_texture instances;         /* the table of instances; none if they fit into the uniform block */
    glbk_buffer  scene;             /* the uniform block */
    uint32_t     texel_count;       /* of all blocks */
    uint32_t     capacity;          /* the most instances */
    uint32_t     count;             /* instances that are placed */
    char         defines[104];      /* what all blocks have in common, for programs of your own: see
                                       glbk_csm_bind */
    uint32_t     key;               /* private, like all that follows: a number for defines */
    uint32_t     near_count;        /* instances that the uniform block has room for; 0 = they are in the
                                       table */
    uint32_t     block_count;
    void         *heads;            /* of all blocks: where they begin and what instances ask them */
};

/* A light is a lsamp_light_desc, and is refused if lsamp_light_init refuses it. The differences are these:
   - LSAMP_LIGHT_CALLBACK and emission_fn are refused, too, since GPUs call no functions, unless GLSL of yours
     stands for them (own).
   - cone_half_angle of a spot may reach pi.
   - A mesh is sampled triangle by triangle, in their order, by area, whereas lightsampling.h cuts it first;
     its places and radius do not matter here. Samples and their coordinates are those of lsamp_sample if the
     mesh is made of lsamp_light_triangles, without indices: take these where the light's maps are asked by
     COHSM_LIGHT_PARAMETER.
   - Texels of L that are negative or not finite count as 0. */
typedef struct glbk_csm_lights_desc {
    const lsamp_light_desc *lights;
    uint32_t                light_count;
    const lsamp_lobe       *lobes;          /* of all Lafortune materials one after the other; NULL = none */
    uint32_t                lobe_count;     /* up to 2^20 */
    const float            *patterns;       /* from lsamp_patterns_build; NULL = scrambled (0, 2)-sequences */
    uint32_t                pattern_length; /* S, 1..65536 with patterns, else 0; every light of a frame must
                                               then have S samples */
    int                     own;            /* not 0: lights may be of LSAMP_LIGHT_CALLBACK or have an
                                               emission_fn. Neither is called, and shape_fn may be NULL:
                                               renderers that draw them have GLSL of yours in their place,
                                               glbk_csm_renderer_desc.light */
} glbk_csm_lights_desc;

struct glbk_csm_lights {            /* read only; zeroed = none */
    glbk_texture texels;
    uint32_t     lobe_count;
    uint32_t     patterns_at;       /* texel of the first pattern */
    uint32_t     pattern_length;
    int          own;
};

typedef struct glbk_csm_renderer_desc {
    uint32_t width;                 /* pixels of the picture and of its G-buffers, 1 .. ctx->max_side */
    uint32_t height;
    uint32_t lobe_count;            /* the most lobes of a material, 1..8; 0 = 1 */
    int      patterns;              /* not 0: lights are sampled by patterns, which their table must have */
    const char *light;              /* GLSL of yours for shapes and emission, see below; NULL = none. It must
                                       live as long as the renderer */
} glbk_csm_renderer_desc;

/* Lights by GLSL of your own: a shape of any kind (A of section 5) and emission by place and direction. The
   text is compiled before the library's main, may declare functions and constants as it likes, and defines

       void glbk_light_point(vec4 own, vec3 x, out vec3 position, out vec3 normal, out float area)
           what lsamp_shape_fn does: the point of the surface at x in 0..1, the normal of the side that emits
           (0 0 0: a volume), and d area / dx there. Asked for LSAMP_LIGHT_CALLBACK
       vec3 glbk_light_emission(vec4 own, vec3 x, vec3 direction)
           what lsamp_emission_fn does: factors of the radiance that leaves x along the direction, which for a
           sky points to it. Asked for lights with an emission_fn, whichever function it is

   own are the four numbers of glbk_csm_use: a time, the number of a light, whatever the text wants to know.
   With the same numbers lightsampling.h draws the same samples by functions that compute the same. A fault in
   the text comes as GLBK_ERR_COMPILE or GLBK_ERR_LINK from the call that compiles. */

typedef struct glbk_csm_use {           /* a light in a frame */
    uint32_t             start;         /* which light: what glbk_csm_lights_create wrote for it */
    lsamp_light_kind     kind;          /* of that light */
    const glbk_csm_maps *maps;          /* the maps that its samples ask */
    cohsm_light_kind     ask;           /* what the samples ask the maps by: direction, position, ... */
    uint32_t             sample_count;  /* S, samples a pixel and frame, 1..65536 */
    uint32_t             seed;          /* of its random numbers; give each light another one */
    float                own[4];        /* numbers for your GLSL */
} glbk_csm_use;

#define GLBK_CSM_MAX_PLANES 8u

typedef struct glbk_csm_frame_desc {
    const glbk_csm_lights *lights;
    const glbk_csm_use    *uses;        /* the lights that shine in this frame */
    uint32_t               use_count;
    float                  eye[3];      /* world */
    float                  planes[GLBK_CSM_MAX_PLANES][4];  /* infinite planes that receive light, have no
                                                               maps and hide what lies behind them: unit
                                                               normal, distance from the origin along it */
    uint32_t               plane_count; /* 0..GLBK_CSM_MAX_PLANES */
    lsamp_sampling         sampling;    /* as in lsamp_sample_desc */
    cohsm_filter           filter;      /* as in cohsm_query */
    float                  bias;        /* as in cohsm_query: 0 = 1 pixel of a map, negative = none */
    float                  offset;      /* pixels of a map by which receivers of local lights are moved along
                                           their geometric normal, >= 0; receivers of other lights are moved
                                           by glbk_csm_instance.offset */
    uint32_t               frame;       /* number of the frame in progressive rendering: each has random
                                           numbers of its own */
    uint32_t               samples_per_pass;    /* samples that one draw takes, so that a driver that stops
                                                   long draws does not stop it; 0 = 64 */
} glbk_csm_frame_desc;

#define GLBK_CSM_MAX_PROGRAMS 64u   /* programs that are kept, one for each combination of light kind, ask,
                                       filter and defines of maps; then the one that was not used for longest
                                       makes room */

typedef struct glbk_csm_programs {  /* private */
    glbk_program list[GLBK_CSM_MAX_PROGRAMS];
    uint32_t     keys[GLBK_CSM_MAX_PROGRAMS];   /* the combination of each */
    uint32_t     used[GLBK_CSM_MAX_PROGRAMS];   /* the frame in which each was asked for last */
    uint32_t     count;
    uint32_t     frame;
} glbk_csm_programs;

struct glbk_csm_renderer {              /* read only; zeroed = none */
    glbk_csm_programs shade;            /* private, like resolve, targets and frame */
    glbk_program resolve;
    uint32_t     lobe_count;            /* of the desc, like patterns, width and height */
    int          patterns;
    const char  *light;
    uint32_t     width;
    uint32_t     height;
    glbk_texture sums[2];               /* sums[now]: the sum of all frames, GLBK_FORMAT_COLOR */
    glbk_target  targets[2];
    glbk_buffer  frame;
    uint32_t     frame_count;           /* in the sum */
    uint32_t     passes;                /* 0: the sum has no pass yet */
    uint32_t     now;                   /* which of the two sums is up to date */
    int          compute;               /* not 0: it renders by compute shaders */
};
