/* ---- gbuffer: what a camera sees, for all techniques ----

   Once glbk_gbuffer_create. A frame, by one of three ways; then the passes of the techniques, which are given the
   G-buffer:

       glbk_gbuffer_begin(gl, &seen, world_to_clip, eye);           // draw: for each object glbk_gbuffer_object, and
       glbk_gbuffer_object(gl, &seen, &surface);                    // your vertex array and your draw
       glbk_gbuffer_import(gl, &seen, &mine);                       // or: textures of your own, by one pass
       glbk_gbuffer_upload(gl, &seen, row, rows, pixels);           // or: from the CPU

   For shaders of your own, lib/gbuffer.glsl with glbk_gbuffer_bind:

       bool glbk_read_point(ivec2 at, out glbk_point p);            // false: nothing is seen there

   docs/gpu-layouts.md has the four textures. */

#define GLBK_GBUFFER_TEXTURES(X)                                                                    \
    X(usampler2D, glbk_gbuffer_place, 8)        /* what is read; these are in nobody else's way */  \
    X(usampler2D, glbk_gbuffer_normal, 9)                                                           \
    X(usampler2D, glbk_gbuffer_color, 10)                                                           \
    X(usampler2D, glbk_gbuffer_gloss, 11)                                                           \
    X(sampler2D, glbk_gbuffer_color_map, 0)     /* what is drawn or imported */                     \
    X(sampler2D, glbk_gbuffer_gloss_map, 1)                                                         \
    X(sampler2D, glbk_gbuffer_normal_map, 2)                                                        \
    X(sampler2D, glbk_gbuffer_place_in, 2)      /* what is imported */                              \
    X(sampler2D, glbk_gbuffer_depth_in, 3)                                                          \
    X(sampler2D, glbk_gbuffer_normal_in, 4)                                                         \
    X(sampler2D, glbk_gbuffer_flat_in, 5)                                                           \
    X(sampler2D, glbk_gbuffer_open_in, 6)                                                           \
    X(usampler2D, glbk_gbuffer_entity_in, 7)

#define GLBK_GBUFFER_DRAWN_MEMBERS(X)                                                               \
    X(mat4, world, 1)                                                                               \
    X(mat4, clip, 1)                                                                                \
    X(uvec4, numbers, 1)        /* kind, entity, plane, which maps */                               \
    X(uvec4, lobes, 1)                                                                              \
    X(vec4, diffuse, 1)                                                                             \
    X(vec4, gloss, 1)                                                                               \
    X(vec4, eye, 1)                                                                                 \
    X(vec4, values, 1)          /* texels of less alpha are holes; occlusion */

#define GLBK_GBUFFER_IMPORTED_MEMBERS(X)                                                            \
    X(mat4, from_clip, 1)                                                                           \
    X(mat4, to_clip, 1)                                                                             \
    X(mat4, to_world, 1)                                                                            \
    X(uvec4, numbers, 1)        /* kind, entity, plane */                                           \
    X(uvec4, lobes, 1)                                                                              \
    X(uvec4, how, 1)            /* which textures; packing; width, height */                        \
    X(vec4, diffuse, 1)                                                                             \
    X(vec4, gloss, 1)                                                                               \
    X(vec4, eye, 1)                                                                                 \
    X(vec4, depths, 1)          /* from depths to clip z: scale, offset; occlusion */

#define GLBK_GBUFFER_BLOCKS(X)                                  \
    X(glbk_gbuffer_drawn, 0, GLBK_GBUFFER_DRAWN_MEMBERS)        \
    X(glbk_gbuffer_imported, 0, GLBK_GBUFFER_IMPORTED_MEMBERS)

#define GLBK_GBUFFER_STORAGE(X)
#define GLBK_GBUFFER_IMAGES(X)

GLBK__PART(GBUFFER)

GLBK_DEF const glbk_part *glbk_gbuffer_part(void);
/* The GLSL of this header, for programs of your own that use its library files: glbk_source.parts. */

typedef struct glbk_attributes {    /* locations of a mesh's attributes, 0..15; below 0: it has no such attribute.
                                       All four 0 = 0, 1, 2, 3 */
    int32_t position, normal;       /* without normals: those of the triangles */
    int32_t uv, tangent;            /* tangent: w is the handedness, as in glTF */
} glbk_attributes;

typedef struct glbk_gbuffer_desc {
    uint32_t            width, height;      /* pixels, 1 .. what the context allows */
    glbk_attributes     attributes;         /* of what is drawn into it */
    const glbk_texture *depth;              /* yours, of the same size and a depth format, which must outlive it; NULL =
                                               one of its own, DEPTH32F */
} glbk_gbuffer_desc;                        /* zero it, then set what you care about */

typedef struct glbk_gbuffer {       /* read only; zeroed = none */
    uint32_t        width, height;
    glbk_texture    words[4];       /* place and entity; normal and numbers; colour and geometric normal; gloss */
    glbk_texture    depth;          /* that was drawn with, or yours; see has_depth */
    glbk_target     target, colors; /* with and without the depth */
    glbk_attributes attributes;     /* defaults resolved */
    int             own_depth;      /* private */
    int             has_depth;      /* depth holds that of this frame: 0..1, the smaller the nearer */
    int             has_clip;       /* clip and eye are those of this frame */
    float           clip[16];       /* world to clip space, in OpenGL's convention */
    float           eye[3];
    glbk_program    draw, take;     /* private, as what follows: compiled when they are first used */
    glbk_buffer     drawn, imported;
} glbk_gbuffer;

GLBK_DEF glbk_result glbk_gbuffer_create(glbk_context *ctx, const glbk_gbuffer_desc *desc, glbk_gbuffer *out);
/* Nothing is seen in it. Memory on the GPU: 64 bytes a pixel, and 4 for the depth.
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC: a size of 0, a location above 15 or twice, no position; GLBK_ERR_MISMATCH:
            a depth of another size; GLBK_ERR_LIMIT, GLBK_ERR_ALLOC; those of textures and targets */
GLBK_DEF void glbk_gbuffer_free(glbk_context *ctx, glbk_gbuffer *gbuffer);

/* ---- gbuffer: drawing ---- */

typedef struct glbk_surface {       /* an object; all zero: black, Lambert, on no entity */
    float          world[16];       /* object to world; all zero = identity */
    lsamp_material material;        /* diffuse, specular, ... are factors of the maps'; lobes is not looked at: */
    uint32_t       first_lobe;      /* Lafortune: the first of material.lobe_count in the table that the technique was
                                       given (glbk_csm_lights_desc.lobes) */
    uint32_t       entity;          /* counted from 1, in the order in which the technique has them; 0 = none */
    uint32_t       plane;           /* receiver plane (csm) that it lies on, counted from 1, at most 255; 0 = none */
    float          occlusion;       /* of bounced light: 0 open .. 1 none of it comes */
    float          alpha;           /* opacity, a factor of the colour map's; 0 = 1 */
    float          alpha_cutoff;    /* what is less opaque is a hole; 0 = none */
    const glbk_texture *color_map;  /* or NULL, like the others: factors of diffuse, and alpha */
    const glbk_texture *gloss_map;  /* factors of specular; metal-rough: roughness in g, metallic in b, as in glTF */
    const glbk_texture *normal_map; /* tangent space; needs tangents */
} glbk_surface;

GLBK_DEF glbk_result glbk_gbuffer_begin(glbk_context *ctx, glbk_gbuffer *gbuffer, const float world_to_clip[16],
                                        const float eye[3]);
/* Clears the G-buffer and its depth, your own one too, and binds it with its program, which is compiled at first use.
   world_to_clip   OpenGL's clip space, -1..1: a pass sets it so (glbk_begin)
   eye             world; all surfaces are turned to it
   Errors          GLBK_ERR_ARGUMENT; those of glbk_program_create at first use */
GLBK_DEF glbk_result glbk_gbuffer_object(glbk_context *ctx, glbk_gbuffer *gbuffer, const glbk_surface *surface);
/* After glbk_gbuffer_begin, once or often: then bind your vertex array and draw. Attributes of desc.attributes that the
   array has not enabled must have been set to zero.
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC, a field out of range; GLBK_ERR_ORDER, before glbk_gbuffer_begin */

/* ---- gbuffer: from the CPU ---- */

typedef struct glbk_pixel {
    float          position[3];     /* world */
    float          normal[3];       /* unit, for shading, on the side that is seen; 0 0 0: nothing is seen here */
    float          geometric[3];    /* unit, the surface's own; 0 0 0 = normal */
    float          tangent[3];      /* unit, for Lafortune's lobes; 0 0 0 = any */
    lsamp_material material;        /* lobes is not looked at: */
    uint32_t       first_lobe;      /* this, and the rest, as in glbk_surface */
    uint32_t       entity, plane;
    float          occlusion;
} glbk_pixel;

GLBK_DEF glbk_result glbk_gbuffer_upload(glbk_context *ctx, glbk_gbuffer *gbuffer, uint32_t row, uint32_t rows,
                                         const glbk_pixel *pixels);
/* Whole rows. Row 0 comes back first where a technique reads its light; for a picture on the screen it is the lowest.
   There is no depth of it: has_depth and has_clip are 0 afterwards.
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_ALLOC */

/* ---- gbuffer: from textures of your own ---- */

typedef enum glbk_normal_packing {
    GLBK_NORMAL_PACKING_DEFAULT,            /* = GLBK_NORMAL_PACKING_FLOAT */
    GLBK_NORMAL_PACKING_FLOAT,              /* x, y, z, -1..1: float textures, signed ones */
    GLBK_NORMAL_PACKING_UNIT,               /* x, y, z, 0..1 for -1..1: RGBA8, RGB10_A2 */
    GLBK_NORMAL_PACKING_OCTAHEDRAL,         /* x, y on the octahedron about z, -1..1: RG16F, RG8_SNORM */
    GLBK_NORMAL_PACKING_OCTAHEDRAL_UNIT,    /* the same, 0..1 for -1..1: RG8, RGBA8 */
    GLBK_NORMAL_PACKING_COUNT
} glbk_normal_packing;

typedef enum glbk_clip_depth {
    GLBK_CLIP_DEPTH_DEFAULT,                /* = GLBK_CLIP_DEPTH_MINUS_ONE_TO_ONE */
    GLBK_CLIP_DEPTH_MINUS_ONE_TO_ONE,       /* OpenGL; its depth buffers hold 0 near .. 1 far */
    GLBK_CLIP_DEPTH_ZERO_TO_ONE,            /* glClipControl's other one */
    GLBK_CLIP_DEPTH_REVERSED,               /* 1 near .. 0 far, in depth buffers too */
    GLBK_CLIP_DEPTH_COUNT
} glbk_clip_depth;

/* Textures are 2D, of the G-buffer's size, not multisampled. Of a texture that this library has not made, set name,
   width and height of a zeroed glbk_texture; it must be complete (without mipmaps: GL_NEAREST or GL_LINEAR), a depth
   texture without a comparison mode. NULL = not given. */
typedef struct glbk_import {
    const glbk_texture *depth;              /* what a depth buffer holds; or */
    const glbk_texture *positions;          /* floats. 0 in the fourth channel: nothing is seen. Both: places of these,
                                               what is seen and the depth by the other */
    float               world_to_clip[16];  /* by which it was drawn; needed with depth alone. All zero = not known:
                                               then there is no depth but by a depth texture */
    glbk_clip_depth     clip_depth;         /* of world_to_clip and depth */
    float               to_world[16];       /* of positions and normals: rotation, translation; view to world where they
                                               are in view space. All zero = identity */
    float               eye[3];             /* world */
    const glbk_texture *normals;            /* required. Lengths beyond 0.5..1.5: nothing is seen */
    const glbk_texture *geometric;          /* normals of the surfaces; NULL = from the places of neighbouring pixels */
    glbk_normal_packing normal_packing;     /* of both */
    lsamp_material      material;           /* as in glbk_surface, as is first_lobe */
    uint32_t            first_lobe;
    const glbk_texture *color_map;          /* factors of diffuse. Linear: an sRGB texture, or one that holds it so */
    const glbk_texture *gloss_map;          /* as in glbk_surface: pixel for pixel here */
    const glbk_texture *open_map;           /* red: 1 open .. 0 occluded, as glTF has it; else occlusion holds */
    const glbk_texture *entities;           /* unsigned integers, red: from 1, 0 none; else entity holds */
    uint32_t            entity, plane;
    float               occlusion;
} glbk_import;                              /* zero it, then set what you care about */

GLBK_DEF glbk_result glbk_gbuffer_import(glbk_context *ctx, glbk_gbuffer *gbuffer, const glbk_import *import);
/* One pass over all pixels: it reads 2 to 8 texels of yours, 4 to 8 more where it finds normals of surfaces by
   neighbours, and writes 64 bytes. Compiles its program at first use. The G-buffer's own depth is written where it is
   known; yours, by desc.depth, is left as it is, and may be import->depth.
   Errors   GLBK_ERR_ARGUMENT; GLBK_ERR_DESC: what is required is missing, a texture of another size, a matrix that has
            no inverse; those of glbk_program_create at first use */

GLBK_DEF glbk_result glbk_gbuffer_bind(glbk_context *ctx, const glbk_gbuffer *gbuffer,
                                      const glbk_offset *offset);
/* For a program of yours with gbuffer among its library files, which is bound (glbk_begin): the four textures.
   offset   that gbuffer has in the program; NULL = none
   Errors   GLBK_ERR_ARGUMENT */

GLBK_DEF glbk_result glbk_gbuffer_read(glbk_context *ctx, const glbk_gbuffer *gbuffer, uint32_t row, uint32_t rows,
                                       glbk_pixel *pixels);
/* The way back, to look at what a G-buffer holds: rows as glbk_gbuffer_upload takes them. Normals of surfaces and
   tangents are off by up to 5e-5, occlusion by 1 / 131070. Waits for the GPU.
   Errors   GLBK_ERR_ARGUMENT, GLBK_ERR_ALLOC */

/* ---- for the techniques' headers: not for you, may change without notice ---- */

GLBK_DEF glbk_result glbk__gbuffer_program(glbk_context *ctx, const glbk_part *part, const char *name,
                                           const char *defines, glbk_program *out);
/* glbk_program_create for a program of one pass over the screen or of compute that uses lib/gbuffer.glsl beside files
   of its own part. */
