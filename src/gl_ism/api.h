/* ---- more of maps ---- */

GLBK_DEF const glbk_part *glbk_ism_part(void);
/* Returns the GLSL of this header, for programs of your own that use its library files: see
   glbk_source.parts. */

GLBK_DEF glbk_result glbk_ism_near_points_upload(glbk_context *ctx, glbk_ism_maps *maps,
                                                 const ism_near_point *points, uint32_t count);
/* Sets the near points of the VPLs that glbk_ism_vpls_upload was given last, for ISM_NEAR_GATHER, which is
   the default.
   points   as ism_near_points has them
   count    at most desc.vpl_count x desc.near_point_count; 0 = none: ISM_NEAR_GATHER then does what
            ISM_NEAR_PATCH does
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or maps were not created. GLBK_ERR_INPUT: a number is not
            finite, negative, or that of no VPL. GLBK_ERR_LIMIT: count is too large. GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_ism_mesh_move(glbk_context *ctx, glbk_ism_maps *maps, const float *positions,
                                        size_t stride);
/* Sets new places of the same vertices. You may instead render them into the layers of maps->positions, an
   RGBA32F table (docs/gpu-layouts.md), or copy them there from a buffer that transform feedback or compute
   has filled (glTexSubImage3D with GL_PIXEL_UNPACK_BUFFER): glbk_ism_scatter takes them from there. ism.h
   scatters its surfels over the places that ism_scatter is given in any case.
   positions   x, y, z of each of maps->vertex_count vertices
   stride      bytes from one to the next, a multiple of 4, >= 12; 0 = 12
   Errors      GLBK_ERR_ARGUMENT: a pointer is NULL, maps were not created, or stride is another.
               GLBK_ERR_ORDER: there is no mesh. GLBK_ERR_ALLOC */

/* ---- complete passes ---- */

typedef struct glbk_ism_renderer_desc {
    uint32_t width;                     /* pixels of the picture, 1 to ctx->max_side; both must be set */
    uint32_t height;
} glbk_ism_renderer_desc;

GLBK_DEF glbk_result glbk_ism_renderer_create(glbk_context *ctx, const glbk_ism_renderer_desc *desc,
                                              glbk_ism_renderer *out);
/* Makes a renderer for pictures of one size, which glbk_ism_renderer_free takes back.
   out      zeroed on errors
   Memory   on the GPU: 32 bytes for each pixel
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: width or height is 0. GLBK_ERR_LIMIT: width
            or height is above ctx->max_side. Those of programs, textures and targets */

GLBK_DEF glbk_result glbk_ism_renderer_resize(glbk_context *ctx, glbk_ism_renderer *renderer, uint32_t width,
                                              uint32_t height);
/* Gives the renderer another size, without what it had drawn. Its programs stay, whereas a new renderer would
   compile them anew; so call it when a window has changed its size, with glbk_gbuffer_resize. Its textures
   are new ones.
   Errors   GLBK_ERR_ARGUMENT: the renderer is NULL or was not created. GLBK_ERR_DESC, GLBK_ERR_LIMIT: as for
            glbk_ism_renderer_create. After these it is as it was, after those of textures and targets
            it is freed and zeroed */

GLBK_DEF void glbk_ism_renderer_free(glbk_context *ctx, glbk_ism_renderer *renderer);
/* Frees what glbk_ism_renderer_create made, and zeroes the struct. NULL and a zeroed renderer are allowed. */

typedef struct glbk_ism_visible {       /* ism_shading.visible_fn as GLSL */
    const char *text;                   /* GLSL of yours, kept as a pointer until glbk_ism_renderer_see is
                                           given another; NULL = none: the maps say what is seen */
    void (*bind_fn)(void *user, glbk_context *ctx);     /* called before each draw with the program in use,
                                       ctx->program, to set uniforms and bind textures; NULL = none */
    void *user;                         /* given to bind_fn */
} glbk_ism_visible;

GLBK_DEF glbk_result glbk_ism_renderer_see(glbk_context *ctx, glbk_ism_renderer *renderer,
                                           const glbk_ism_visible *own);
/* Has glbk_ism_shade ask a function of yours in place of the maps, as ism_shade asks visible_fn: near points
   are seen as their VPLs are, and no_maps does not count. Maps need not be drawn then. The text is compiled
   before the library's main, may declare uniforms as it likes, and defines

       float glbk_visible(uint vpl, vec3 position, vec3 geometric_normal)
           returns how much of a VPL the receiver sees, 0..1; vpl is its number

   A sampler of yours takes a unit that the library does not use: from glbk_desc.first_unit + 16 on. Pixels
   are shaded by fragments then, also with compute. A fault in the text comes as GLBK_ERR_COMPILE or
   GLBK_ERR_LINK from glbk_ism_shade, and is logged as "your text".
   own      is copied; NULL = the maps again
   Cost     the programs of glbk_ism_shade are freed: its next call compiles one, seconds on some drivers
   Errors   GLBK_ERR_ARGUMENT: renderer is NULL or was not created */

GLBK_DEF glbk_result glbk_ism_shade(glbk_context *ctx, glbk_ism_renderer *renderer,
                                    const glbk_gbuffer *gbuffer, const glbk_ism_maps *maps,
                                    const ism_shading *shading, uint32_t pairs_per_pass);
/* Computes the irradiance of each pixel by all VPLs, as ism_shade does it for receivers without albedos. The
   first use of a near_mode compiles a program.
   gbuffer          the points that are lit, of the renderer's size
   maps             whose maps glbk_ism_draw has drawn, unless shading->no_maps is set or a function of yours
                    says what is seen (glbk_ism_renderer_see)
   shading          NULL = all defaults. visible_fn and near_visible_fn must be NULL, since functions of C run
                    on the CPU; glbk_ism_renderer_see takes one in GLSL. cull changes nothing
   pairs_per_pass   how many pairs of a pixel and a VPL one pass takes; 0 = 2^28. Give fewer if the driver
                    stops passes that take long, since near points do not count
   Cost             each pixel asks vpl_count / interleave^2 VPLs, a texel of its map for each that faces it.
                    With ISM_NEAR_GATHER it asks besides, whatever interleave is, a sphere about each 64 near
                    points, and all of those whose sphere holds it
   Errors           GLBK_ERR_ARGUMENT: a pointer is NULL, or an object was not created. GLBK_ERR_DESC: a field
                    of the shading is out of range. GLBK_ERR_MISMATCH: the G-buffer has another size.
                    GLBK_ERR_ORDER: the maps were never drawn. Those of glbk_program_compile at first use */

GLBK_DEF glbk_result glbk_ism_resolve(glbk_context *ctx, glbk_ism_renderer *renderer,
                                      const glbk_gbuffer *gbuffer, const glbk_pass *pass,
                                      const glbk_picture *picture);
/* Draws irradiance x albedo / pi, which is linear radiance, to the pass's target. The albedo is the
   G-buffer's diffuse colour, of metal-rough surfaces times 1 - metallic.
   pass     where the picture is drawn and how it is blended; its viewport says where in the target
   picture  whether empty pixels and depths are drawn, see glbk_picture; NULL = every pixel, without depths
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or an object was not created. GLBK_ERR_MISMATCH: the
            G-buffer has another size. Those of glbk_begin */

GLBK_DEF glbk_result glbk_ism_read(glbk_context *ctx, const glbk_ism_renderer *renderer, float *rgba);
/* Reads the irradiance, W/m^2, back to the CPU, and waits for the GPU meanwhile.
   rgba     gets 4 floats for each pixel, row 0 of the G-buffer first. The last of four is the irradiance,
            mean of the three channels, that ism_shading.near_mode took off
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the renderer was not created. GLBK_ERR_LOST */

/* ---- objects: read only ---- */

#define GLBK_ISM_LEVELS 3u              /* the most levels of pull and push */

struct glbk_ism_maps {                  /* the maps of all VPLs; read only; zeroed = none */
    ism_desc     desc;                  /* with its defaults, 0 for none, and without its system */
    uint32_t     side;                  /* texels a side of the atlas, as ism_atlas has it */
    uint32_t     tiles_across;          /* tiles a side of the atlas, as ism_atlas has them */
    uint32_t     phase_surfel_count;    /* of a VPL in a phase: surfel_count / lazy_frames, rounded up */
    uint32_t     vpl_count;             /* VPLs in use */
    uint32_t     near_point_count;      /* near points in use */
    uint32_t     vertex_count;
    uint32_t     triangle_count;
    uint64_t     phases;                /* a bit for each phase whose surfels were given */
    int          drawn;                 /* not 0: glbk_ism_draw has succeeded once */
    int          fewer;                 /* not 0: the mesh has lost triangles since glbk_ism_scatter */
    int          outdated;              /* not 0: the same since glbk_ism_draw */
    int          masked;                /* not 0: the mesh has a mask, which only ism_scatter knows */
    float        sphere[4];             /* about the mesh: centre, radius */
    glbk_texture vpls;                  /* the table of VPLs and near points */
    glbk_texture surfels;               /* the table of surfels of all phases (compute path) */
    glbk_texture triangle_table;        /* the table of triangles */
    glbk_texture positions;             /* the table of vertices */
    glbk_texture albedos;               /* the table of the triangles' albedos, with desc.keep_hits */
    glbk_texture planes;                /* the nearest surfels; of the atlas's size */
    glbk_texture hits;                  /* their triangles, with desc.keep_hits; of the atlas's size */
    glbk_texture depth;                 /* the depth buffer that surfels are drawn with */
    glbk_texture kept;                  /* which texels keep their surfels; of the atlas's size */
    glbk_texture pull[GLBK_ISM_LEVELS]; /* the levels of pull, each of half the size of the one before */
    glbk_texture atlas;                 /* the depths of all maps */
    glbk_target  plane_target;          /* of planes, hits and depth */
    glbk_target  kept_target;           /* of kept */
    glbk_target  pull_target[GLBK_ISM_LEVELS];      /* of pull */
    glbk_target  atlas_target;          /* of atlas */
    glbk_buffer  frame;                 /* the uniform block of the maps */
    glbk_buffer  view;                  /* the uniform block of glbk_ism_bind */
    glbk_program splat;                 /* draws surfels */
    glbk_program holes;                 /* finds holes */
    glbk_program pull_program[GLBK_ISM_LEVELS];     /* draws the levels of pull */
    glbk_program push;                  /* fills holes */
    glbk_program fill;                  /* finds, pulls and fills by compute */
    int          quads;                 /* not 0: surfels are drawn as rectangles, not as points */
    int          compute;               /* not 0: the compute path, which has no depth, kept and pull */
    glbk_texture phase_surfels[64];     /* surfels of each phase (core path) */
};

struct glbk_ism_renderer {              /* the light of a picture; read only; zeroed = none */
    uint32_t     width;                 /* pixels */
    uint32_t     height;
    glbk_texture light;                 /* irradiance before the blur, GLBK_FORMAT_COLOR */
    glbk_texture result;                /* irradiance after the blur, GLBK_FORMAT_COLOR */
    glbk_target  light_target;          /* of light */
    glbk_target  result_target;         /* of result */
    glbk_buffer  view;                  /* the uniform block */
    glbk_program shade[ISM_PROJECTION_COUNT][ISM_NEAR_COUNT];   /* compiled at first use */
    glbk_program blur;
    glbk_program resolve;
    int          compute;               /* not 0: light is summed up and blurred by compute */
    glbk_ism_visible own;               /* of glbk_ism_renderer_see */
};
