/* ---- page one: what a camera sees, for all techniques ----

   A program calls glbk_gbuffer_create once. In each frame it fills the G-buffer in one of three ways, and
   then gives it to the passes of the techniques:

       glbk_gbuffer_begin(gl, &seen, world_to_clip, eye);           // draw it: then for each object
       glbk_gbuffer_object(gl, &seen, &surface);                    // this, your vertex array and your draw
       glbk_gbuffer_import(gl, &seen, &mine);                       // or: one pass reads textures of your own
       glbk_gbuffer_upload(gl, &seen, row, row_count, pixels);      // or: pixels come from the CPU */

typedef struct glbk_gbuffer glbk_gbuffer;   /* four textures, which take 64 bytes a pixel: see below */
struct glbk_gbuffer_desc;           /* how large it is, and where meshes have their attributes */
struct glbk_surface;                /* an object's place, material, entity and maps */
struct glbk_import;                 /* textures of your own, and what they hold */
struct glbk_pixel;                  /* a pixel from the CPU */

GLBK_DEF glbk_result glbk_gbuffer_create(glbk_context *ctx, const struct glbk_gbuffer_desc *desc,
                                         glbk_gbuffer *out);
/* Makes a G-buffer in which nothing is seen. Give it back by glbk_gbuffer_free.
   out      zeroed on errors
   Memory   on the GPU 64 bytes a pixel, and 4 for a depth texture of its own
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: width or height is 0, a location is above 15
            or used twice, or there is no position. GLBK_ERR_MISMATCH: desc->depth has another size, or no
            format of depth. GLBK_ERR_LIMIT: width or height is above ctx->max_side. GLBK_ERR_ALLOC, and those
            of glbk_texture_create and glbk_target_create */

GLBK_DEF glbk_result glbk_gbuffer_import(glbk_context *ctx, glbk_gbuffer *gbuffer,
                                         const struct glbk_import *import);
/* Fills the G-buffer from textures of yours, by one pass over all pixels; the first call compiles its
   program. A depth texture of its own is written where depths are known; one of yours (desc.depth) is left as
   it is, and may be import->depth.
   Cost     a pixel: 2 to 8 texels are read, 4 to 8 more if normals of surfaces come from neighbours, and 64
            bytes are written
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the G-buffer was not created. GLBK_ERR_DESC: a required
            field is missing, a matrix has no inverse, or a number is out of range. GLBK_ERR_MISMATCH: a
            texture has another size. Those of glbk_program_compile in the first call */

GLBK_DEF glbk_result glbk_gbuffer_begin(glbk_context *ctx, glbk_gbuffer *gbuffer,
                                        const float world_to_clip[16], const float eye[3]);
/* Clears the G-buffer and its depth, even if that texture is yours, and binds both with the program that
   draws objects, which the first call compiles.
   world_to_clip   column-major; clip space is OpenGL's, with depths -1..1, whatever your glClipControl says:
                   the pass sets it (glbk_begin)
   eye             x, y, z in world space; normals of surfaces are turned towards it
   Errors          GLBK_ERR_ARGUMENT: a pointer is NULL, or the G-buffer was not created. Those of
                   glbk_program_compile in the first call */

GLBK_DEF glbk_result glbk_gbuffer_object(glbk_context *ctx, glbk_gbuffer *gbuffer,
                                         const struct glbk_surface *surface);
/* Says which object the next draws are of, until the next call: bind your vertex array and draw.
   Call it after glbk_gbuffer_begin. An attribute of desc.attributes that the vertex array has not enabled
   must have been set to zero.
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the G-buffer was not created. GLBK_ERR_DESC: a field of
            surface is out of range. GLBK_ERR_ORDER: glbk_gbuffer_begin has not been called */

GLBK_DEF glbk_result glbk_gbuffer_upload(glbk_context *ctx, glbk_gbuffer *gbuffer, uint32_t row,
                                         uint32_t row_count, const struct glbk_pixel *pixels);
/* Writes whole rows of pixels, row .. row + row_count - 1, from memory. Row 0 is the lowest of a picture on
   the screen, and the first that the _read functions of the techniques return. The G-buffer has no depth and
   no matrix afterwards: has_depth and has_clip are 0.
   pixels   gbuffer->width x row_count, row by row. Of their numbers only vectors are checked; a plane counts
            modulo 256, occlusion is clamped to 0..1
   Memory   64 bytes a pixel while it runs
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, the G-buffer was not created, row_count is 0, or the rows
            reach beyond height. GLBK_ERR_INPUT: a finite vector is neither unit nor 0 0 0.
            GLBK_ERR_ALLOC */

/* ---- structs of page one ---- */

/* Where a mesh has its attributes: locations 0..15, each used once. All four 0 stands for 0, 1, 2, 3. All
   calls that draw your meshes take it: what they do not read may stand anywhere. */
typedef struct glbk_attributes {
    int32_t position;
    int32_t normal;                 /* below 0: the mesh has no normals, and those of its triangles are
                                       used */
    int32_t uv;                     /* texture coordinates; below 0: the mesh has none, and maps are read at
                                       0, 0 */
    int32_t tangent;                /* w is the handedness, as in glTF; below 0: the mesh has none, and normal
                                       maps are ignored */
    const char *vertex;             /* GLSL of yours that finds the vertices, see below; NULL = the attributes
                                       above, which do not count if it is given */
    const char *fragment;           /* GLSL of yours that colours pixels and leaves some out, see below;
                                       NULL = none */
} glbk_attributes;

/* GLSL of your own: skinning, morphing, wind, instances, alpha masks. All passes that draw your meshes take
   it: G-buffer, reflective shadow maps, shadow maps of a sky, builders of coherent shadow maps and of shadow
   fields, self-visibility. The texts are compiled before the library's main, may declare attributes,
   uniforms and varyings as they like, and define

       void glbk_vertex(out vec3 position, out vec3 normal, out vec2 uv, out vec4 tangent)
           all in the space of the object, on which glbk_surface.transform acts; a normal 0 0 0 stands for
           that of the triangle, a tangent 0 0 0 0 for none
       bool glbk_fragment(vec2 uv, inout vec4 color)
           returns whether the pixel is there. color comes as the surface's colour times its color_map, with
           the alpha in a, and may be changed; passes that draw depths alone give 1 1 1 1 and take none back

   While a pass draws, ctx->program is the program for glGetUniformLocation and glUniform. A sampler of yours
   takes a unit that the library does not use: from glbk_desc.first_unit + 16 on. gl_InstanceID is the
   library's in shadow maps of a sky and in builders of shadow fields, and yours elsewhere. The texts must
   live as long as the object that was made with them. A fault in them comes as GLBK_ERR_COMPILE or
   GLBK_ERR_LINK from the call that compiles, and is logged as "your text". */

typedef struct glbk_gbuffer_desc {
    uint32_t            width;      /* pixels, 1 .. ctx->max_side */
    uint32_t            height;
    glbk_attributes     attributes; /* of all meshes that are drawn into it */
    const glbk_texture *depth;      /* a depth texture of yours, of the same width and height, to draw with;
                                       it must outlive the G-buffer. NULL: the G-buffer makes one of its own,
                                       DEPTH32F */
} glbk_gbuffer_desc;                /* zero it, then set what you care about */

struct glbk_gbuffer {               /* read only; zeroed = none */
    uint32_t        width;
    uint32_t        height;
    glbk_texture    words[4];       /* they hold place and entity; normal, kind, plane and occlusion; diffuse
                                       colour and geometric normal; gloss */
    glbk_texture    depth;          /* its own depth texture or yours; has_depth says what it holds */
    glbk_target     target;         /* the four textures with the depth */
    glbk_target     colors;         /* the four textures alone */
    glbk_attributes attributes;     /* those of the desc, defaults resolved */
    int             own_depth;      /* private: depth is freed with the G-buffer */
    int             has_depth;      /* not 0: depth holds that of this frame, 0..1, the smaller the nearer */
    int             has_clip;       /* not 0: world_to_clip and eye are those of this frame */
    float           world_to_clip[16];  /* world to clip space, whose depth is -1..1 */
    float           eye[3];         /* world */
    glbk_program    draw_program;   /* private, like all that follows; compiled when it is first used */
    glbk_program    import_program;
    glbk_buffer     drawn;
    glbk_buffer     imported;
};

typedef struct glbk_surface {       /* one object; all zero: black, Lambert, on no entity */
    float          transform[16];   /* object to world, column-major; all zero = identity */
    lsamp_material material;        /* its numbers are multiplied by the maps; the pointer lobes is not read,
                                       see first_lobe */
    uint32_t       first_lobe;      /* Lafortune: number of the first of material.lobe_count lobes in the
                                       table that the technique has (glbk_csm_lights_desc.lobes) */
    uint32_t       entity;          /* number of the technique's entity, counted from 1 in its order; 0 =
                                       none */
    uint32_t       plane;           /* number of csm's receiver plane that the object lies on, 1..255; 0 =
                                       none */
    float          occlusion;       /* share of bounced light that does not reach the object, 0..1 */
    float          alpha;           /* opacity, which the colour map's alpha multiplies; 0 = 1 */
    float          alpha_cutoff;    /* pixels of less opacity are not drawn; 0 = all are */
    const glbk_texture *color_map;  /* rgb multiplies diffuse, a multiplies alpha. NULL = no map, like the
                                       next two */
    const glbk_texture *gloss_map;  /* Phong: rgb multiplies specular; metal-rough: g multiplies roughness and
                                       b metallic, as in glTF */
    const glbk_texture *normal_map; /* normals in tangent space, 0..1 for -1..1; needs tangents */
} glbk_surface;

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
    GLBK_CLIP_DEPTH_MINUS_ONE_TO_ONE,       /* OpenGL's; its depth buffers hold 0 near .. 1 far */
    GLBK_CLIP_DEPTH_ZERO_TO_ONE,            /* glClipControl with GL_ZERO_TO_ONE, 0 near .. 1 far */
    GLBK_CLIP_DEPTH_REVERSED,               /* the same, 1 near .. 0 far, in depth buffers too */
    GLBK_CLIP_DEPTH_COUNT
} glbk_clip_depth;

/* Textures are 2D, of the G-buffer's width and height, and not multisampled. For a texture that this library
   has not made, zero a glbk_texture and set name, width and height; it must be complete (without mipmaps its
   filter is GL_NEAREST or GL_LINEAR), and a depth texture has no comparison mode. NULL = not given. */
typedef struct glbk_import {
    const glbk_texture *depth;              /* holds what a depth buffer holds. depth or positions is
                                               required; with both, places come from positions, depths and
                                               what is seen from depth */
    const glbk_texture *positions;          /* floats x, y, z; a 0 in the fourth channel: nothing is seen */
    float               world_to_clip[16];  /* the matrix by which depth was drawn; required where depth comes
                                               without positions. All zero = not known, and then only a depth
                                               texture gives depths */
    glbk_clip_depth     clip_depth;         /* the convention of world_to_clip and depth */
    float               to_world[16];       /* the space of positions and normals to world, a rotation and
                                               translation: the view's where they are in view space. All zero
                                               = identity */
    float               eye[3];             /* world */
    const glbk_texture *normals;            /* required; of lengths 0.5..1.5, else nothing is seen */
    const glbk_texture *geometric_normals;  /* normals of the surfaces; NULL: they are found from the places
                                               of neighbouring pixels */
    glbk_normal_packing normal_packing;     /* of normals and geometric_normals */
    lsamp_material      material;           /* as in glbk_surface, like first_lobe */
    uint32_t            first_lobe;
    const glbk_texture *color_map;          /* linear colours that multiply diffuse: an sRGB texture is
                                               fine */
    const glbk_texture *gloss_map;          /* as in glbk_surface, but a texel for each pixel */
    const glbk_texture *open_map;           /* red: 1 open .. 0 occluded, as in glTF; it replaces occlusion */
    const glbk_texture *entities;           /* unsigned integers, red: an entity from 1 on, or 0; it replaces
                                               entity */
    uint32_t            entity;             /* as in glbk_surface, like plane and occlusion */
    uint32_t            plane;
    float               occlusion;
} glbk_import;                              /* zero it, then set what you care about */

typedef struct glbk_pixel {
    float          position[3];     /* world */
    float          normal[3];       /* unit, for shading, on the side that is seen; 0 0 0: nothing is seen
                                       here */
    float          geometric_normal[3]; /* unit, the surface's own normal on the same side; 0 0 0 = normal */
    float          tangent[3];      /* unit, world: the x axis of Lafortune's lobes; 0 0 0 = any */
    lsamp_material material;        /* as in glbk_surface, like all that follows */
    uint32_t       first_lobe;
    uint32_t       entity;
    uint32_t       plane;
    float          occlusion;
} glbk_pixel;
