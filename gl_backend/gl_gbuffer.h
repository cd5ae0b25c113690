/* gl_gbuffer.h - v0.9.0 - one G-buffer for all techniques, OpenGL 3.3, ES 3.0, WebGL 2 - MIT-0 OR Unlicense

   What it does

   A G-buffer holds what a camera sees in each pixel: the place, the normals, the material and the entity.
   gl_csm.h, gl_shadowfield.h, gl_wavelets.h, gl_envshadow.h, gl_rsm.h and gl_ism.h light it. It is filled
   in one of three ways: it is drawn from your vertex arrays, whatever the locations of their attributes;
   it is uploaded from the CPU; or one pass makes it from textures that your renderer has anyway
   (glbk_gbuffer_import): depth or places, normals in four packings, colours, gloss, entities. Shaders of
   your own read it by glbk_read_point() of lib/gbuffer.glsl.

   What it does not do

   - It needs gl_backend.h beside it, which makes the context object, textures and targets, and whose
     conventions, errors and rules about GL's state hold here; and gl_programs.h, which makes programs.
     Materials are those of lightsampling.h, whose implementation is not needed.
   - It holds one sample and one surface a pixel: there is no transparency and no multisampling.

   Quick start

       #define GL_BACKEND_IMPLEMENTATION
       #define GL_PROGRAMS_IMPLEMENTATION
       #define GL_GBUFFER_IMPLEMENTATION
       #include "gl_backend/gl_gbuffer.h"
       #include <stdio.h>
       #include <string.h>

       // With GLFW: return glfwGetProcAddress(name);  with EGL: return eglGetProcAddress(name);
       static glbk_proc_fn get_proc(const char *name, void *user)
       {
           (void)name; (void)user;
           return NULL;                                     // no GL here: init says so below
       }

       int main(void)
       {
           glbk_context gl;
           glbk_gbuffer seen;
           glbk_desc desc;
           glbk_gbuffer_desc sizes;
           glbk_import mine;
           glbk_texture depth, normals;
           glbk_result result;
           int i;

           memset(&desc, 0, sizeof desc);
           memset(&sizes, 0, sizeof sizes);
           memset(&mine, 0, sizeof mine);
           memset(&depth, 0, sizeof depth);
           memset(&normals, 0, sizeof normals);
           desc.get_proc_fn = get_proc;                     // a context is current
           result = glbk_init(&gl, &desc);
           if (result != GLBK_OK) {
               printf("no GL: %s\n", glbk_result_text(result));
               return result != GLBK_ERR_FUNCTION;
           }
           sizes.width = depth.width = normals.width = 640;
           sizes.height = depth.height = normals.height = 360;
           result = glbk_gbuffer_create(&gl, &sizes, &seen);
           depth.name = 1;                                  // of your renderer: what glGenTextures gave it
           normals.name = 2;
           mine.depth = &depth;                             // with the matrix by which it was drawn
           mine.normals = &normals;
           mine.normal_packing = GLBK_NORMAL_PACKING_UNIT;  // RGBA8: 0..1 for -1..1
           for (i = 0; i < 4; i++) mine.world_to_clip[5 * i] = 1;
           for (i = 0; i < 3; i++) mine.material.diffuse[i] = 0.5f;
           if (result == GLBK_OK) result = glbk_gbuffer_import(&gl, &seen, &mine);
           printf("%s\n", glbk_result_text(result));
           glbk_gbuffer_free(&gl, &seen);
           glbk_free(&gl);
           return result != GLBK_OK;
       }

   Vectors

   A vector that is said to be unit may have a length of 0.97 to 1.03 and is used as it is, and any other
   length is an error; vectors that are drawn or imported are normalised by the shaders.

   Configuration

     GL_GBUFFER_IMPLEMENTATION   in one source file: compiles the code; another file may have those of
                                 gl_backend.h and gl_programs.h

   Layouts: docs/gpu-layouts.md. How to bring your own: docs/gbuffer.md. State: docs/gl-state.md.
   Licence: end of file. */
/* These stand outside the guard, because a second inclusion of this file may ask for their implementations.
   lightsampling.h lies above this folder. */
#include "gl_programs.h"
#include "../lightsampling.h"

#ifndef GL_GBUFFER_H
#define GL_GBUFFER_H

#if GLBK_VERSION != 900
#error "gl_gbuffer.h and gl_backend.h are of different versions"
#endif
#if defined(GLBK_STATIC) && !defined(GL_GBUFFER_IMPLEMENTATION)
#error "GLBK_STATIC makes all functions private: GL_GBUFFER_IMPLEMENTATION belongs into the same file"
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ==== src/gl_gbuffer/api_page_one.h ==== */

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

/* ==== src/gl_gbuffer/api.h ==== */

/* ---- the rest ---- */

GLBK_DEF glbk_result glbk_gbuffer_resize(glbk_context *ctx, glbk_gbuffer *gbuffer,
                                         const struct glbk_gbuffer_desc *desc);
/* Gives the G-buffer another size, without what it held. Its programs stay, whereas a new G-buffer would
   compile them anew; so call it when a window has changed its size. Its textures are new ones: targets of
   yours that have its depth must be made anew.
   desc     attributes is not read: they stay as they were created. depth is that of the new size
   Errors   those of glbk_gbuffer_create. GLBK_ERR_ARGUMENT, too: the G-buffer was not created. After an error
            of desc it is as it was, after any other it is freed and zeroed */

GLBK_DEF void glbk_gbuffer_free(glbk_context *ctx, glbk_gbuffer *gbuffer);
/* Deletes the G-buffer's objects of GL, not your depth texture, and zeroes the struct. NULL is allowed. */

GLBK_DEF glbk_result glbk_gbuffer_read(glbk_context *ctx, const glbk_gbuffer *gbuffer, uint32_t row,
                                       uint32_t row_count, glbk_pixel *pixels);
/* Reads whole rows back, to look at what a G-buffer holds, and waits for the GPU. Normals of surfaces and
   tangents are off by up to 5e-5, occlusion by 1 / 131070.
   pixels   receives gbuffer->width x row_count pixels, in the order of glbk_gbuffer_upload
   Memory   64 bytes a pixel while it runs
   Errors   those of glbk_gbuffer_upload, and of glbk_target_read */

/* ---- shaders of your own ----

   After glbk_gbuffer_bind they read the G-buffer by lib/gbuffer.glsl:

       bool glbk_read_point(ivec2 at, out glbk_point p);            // false: nothing is seen in this pixel

   docs/gpu-layouts.md describes the four textures. */

GLBK_DEF const glbk_part *glbk_gbuffer_part(void);
/* Returns the GLSL of this header, for glbk_source.parts of a program of yours that uses its library
   files. */

GLBK_DEF glbk_result glbk_gbuffer_bind(glbk_context *ctx, const glbk_gbuffer *gbuffer,
                                       const glbk_offset *offset);
/* Binds the four textures for a program of yours that uses lib/gbuffer.glsl and is bound (glbk_begin).
   offset   what glbk_source.offsets gives this part in the program; NULL = none
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the G-buffer was not created */

/* ---- pictures: what the techniques draw at last ---- */

/* The techniques' glbk_..._resolve draw a picture one texel a pixel, its lower left corner at the viewport's.
   A smaller viewport cuts it off; a larger one, or a larger target without a viewport, is GLBK_ERR_DESC:
   nothing is scaled. To show a picture in another size, resolve to a target of its own size and draw that. */

typedef struct glbk_picture {       /* what glbk_..._resolve draws, beside what the pass says. NULL or all
                                       zero: every pixel, without depths */
    int          keep_empty;        /* not 0: where nothing is seen, nothing is drawn: what lies there
                                       stays */
    const float *world_to_clip;     /* 16 floats, OpenGL's clip space -1..1: depths are drawn too, those of
                                       what is seen, 1 where nothing is; pass.depth tests and writes them.
                                       They are recomputed from places, so they may differ in the last bits
                                       from those of a draw of the same surface. NULL: one depth, 0.5, for
                                       all */
} glbk_picture;
/* With desc.check, glbk_..._resolve without pass.target is GLBK_ERR_ORDER while the framebuffer that is bound
   is a technique's, see glbk_check. */

/* ---- for the techniques' headers: not for you, may change without notice ---- */

/* Checks an argument that must not be NULL: returns GLBK_OK, or logs that FIELD is NULL and returns
   GLBK_ERR_ARGUMENT. The other function checks an object, too: `name` points to its name of GL, or is NULL if
   the argument is; an object without a name was not created. Without a context both return GLBK_ERR_ARGUMENT
   and log nothing. */
GLBK__DEF glbk_result glbk__require(const glbk_context *ctx, const char *function, const char *field,
                                    const void *argument);
GLBK__DEF glbk_result glbk__require_created(const glbk_context *ctx, const char *function, const char *field,
                                            const uint32_t *name);

/* Checks a width or height of a desc in pixels, 1 .. ctx->max_side: of too many GLBK_ERR_LIMIT comes, of
   none GLBK_ERR_DESC. */
GLBK__DEF glbk_result glbk__require_side(const glbk_context *ctx, const char *function, const char *field,
                                         uint32_t side);

/* Checks that a G-buffer was created, for pictures of width x height pixels. */
GLBK__DEF glbk_result glbk__require_gbuffer(const glbk_context *ctx, const char *function,
                                            const glbk_gbuffer *gbuffer, uint32_t width, uint32_t height);

/* These log of a member (".radius") of an element of an array what glbk__refuse and glbk__refuse_value log of
   a field: "FUNCTION: ARRAY[INDEX]MEMBER TEXT". With the index GLBK__NO_INDEX the field is ARRAY MEMBER.
   glbk__name_element writes such a field's name. */
enum { GLBK__ELEMENT_ROOM = GLBK__LINE_ROOM };
#define GLBK__NO_INDEX SIZE_MAX
GLBK__DEF void glbk__name_element(char out[GLBK__ELEMENT_ROOM], const char *array, size_t index,
                                  const char *member);
GLBK__DEF glbk_result glbk__refuse_element(const glbk_context *ctx, glbk_result result, const char *function,
                                           const char *array, size_t index, const char *member,
                                           const char *text);
GLBK__DEF glbk_result glbk__refuse_element_value(const glbk_context *ctx, glbk_result result,
                                                 const char *function, const char *array, size_t index,
                                                 const char *member, double value, const char *wanted);

/* Does what glbk__program_create does, for a program of one pass over the screen or of compute that uses
   lib/gbuffer.glsl beside files of its own part. */
GLBK__DEF glbk_result glbk__gbuffer_program(glbk_context *ctx, const glbk_part *part, const char *name,
                                            const char *defines, glbk_program *out);
/* The same with texts of a user, as glbk__program_of_parts takes them. */
GLBK__DEF glbk_result glbk__gbuffer_program_with(glbk_context *ctx, const glbk_part *part, const char *name,
                                                 const char *defines, const char *const texts[2],
                                                 glbk_program *out);

/* The same for a header that stands above another technique's: `under` is the part of that one. */
GLBK__DEF glbk_result glbk__gbuffer_program_above(glbk_context *ctx, const glbk_part *part,
                                                  const glbk_part *under, const char *name,
                                                  const char *defines, glbk_program *out);

/* Copies the locations of attributes with their defaults resolved, and checks that each is at most 15 and
   used once, and that there is a position. function is __func__ of a call whose desc has them. */
GLBK__DEF glbk_result glbk__take_attributes(const glbk_context *ctx, const char *function,
                                            const glbk_attributes *from, glbk_attributes *to);

/* Does what glbk__program_create does, for a program that draws meshes of the user's: its shaders use
   lib/mesh_vertex.glsl and lib/mesh_fragment.glsl, with GLBK_PLACE among the defines for depth alone.
   at     from glbk__take_attributes
   more   defines, which may be "" and have up to 96 characters */
#define GLBK__ATTRIBUTES_ROOM 220
GLBK__DEF glbk_result glbk__drawing_program(glbk_context *ctx, const glbk_part *part, const char *name,
                                            const glbk_attributes *at, const char *more, glbk_program *out);

/* Begins the pass of a resolve as glbk_begin does, for a program that uses lib/picture.glsl and a picture of
   width x height pixels; it checks that the picture covers what is drawn to (glbk_picture). function is
   __func__ of the resolve. */
GLBK__DEF glbk_result glbk__begin_picture(glbk_context *ctx, const char *function, const glbk_pass *pass,
                                          const glbk_picture *picture, uint32_t width, uint32_t height,
                                          glbk_program *program);

/* ==== src/gl_gbuffer/bindings.h ==== */

/* ---- gbuffer: what its GLSL declares; see "bindings" in gl_programs.h ---- */

/* The four textures of the G-buffer, which are read; no technique uses these slots for anything else. */
#define GLBK_GBUFFER_READ_TEXTURES(X)           \
    X(usampler2D, glbk_gbuffer_place, 8)        \
    X(usampler2D, glbk_gbuffer_normal, 9)       \
    X(usampler2D, glbk_gbuffer_color, 10)       \
    X(usampler2D, glbk_gbuffer_gloss, 11)

/* Maps of objects that are drawn; an import has the first two. */
#define GLBK_GBUFFER_MAP_TEXTURES(X)            \
    X(sampler2D, glbk_gbuffer_color_map, 0)     \
    X(sampler2D, glbk_gbuffer_gloss_map, 1)     \
    X(sampler2D, glbk_gbuffer_normal_map, 2)

/* Textures that are imported besides. */
#define GLBK_GBUFFER_IMPORT_TEXTURES(X)         \
    X(sampler2D, glbk_gbuffer_place_in, 2)      \
    X(sampler2D, glbk_gbuffer_depth_in, 3)      \
    X(sampler2D, glbk_gbuffer_normal_in, 4)     \
    X(sampler2D, glbk_gbuffer_flat_in, 5)       \
    X(sampler2D, glbk_gbuffer_open_in, 6)       \
    X(usampler2D, glbk_gbuffer_entity_in, 7)

#define GLBK_GBUFFER_TEXTURES(X)                \
    GLBK_GBUFFER_READ_TEXTURES(X)               \
    GLBK_GBUFFER_MAP_TEXTURES(X)                \
    GLBK_GBUFFER_IMPORT_TEXTURES(X)

/* The material of an object, or of all that is imported. */
#define GLBK_GBUFFER_MATERIAL_MEMBERS(X)                                                    \
    X(vec4, diffuse, 1)             /* rgb: albedo or base colour; a: opacity, of objects */ \
    X(vec4, gloss, 1)               /* Phong: specular colour, exponent; metal-rough: metallic, roughness */ \
    X(uint, kind, 1)                /* lsamp_material_kind, never the default */            \
    X(uint, entity, 1)                                                                      \
    X(uint, plane, 1)                                                                       \
    X(float, occlusion, 1)                                                                  \
    X(uint, first_lobe, 1)                                                                  \
    X(uint, lobe_count, 1)

/* One object that is drawn. */
#define GLBK_GBUFFER_DRAWN_MEMBERS(X)                                                       \
    X(mat4, transform, 1)           /* object to world */                                   \
    X(mat4, clip, 1)                /* world to clip space */                               \
    X(vec4, eye, 1)                 /* world; w is not used */                              \
    GLBK_GBUFFER_MATERIAL_MEMBERS(X)                                                        \
    X(uint, maps, 1)                /* bits: 1 a colour map, 2 a gloss map, 4 a normal map */ \
    X(float, alpha_cutoff, 1)

/* One import. */
#define GLBK_GBUFFER_IMPORTED_MEMBERS(X)                                                    \
    X(mat4, from_clip, 1)           /* clip space to world */                               \
    X(mat4, to_clip, 1)             /* world to clip space */                               \
    X(mat4, to_world, 1)            /* the space of positions and normals to world */       \
    X(vec4, eye, 1)                 /* world; w is not used */                              \
    GLBK_GBUFFER_MATERIAL_MEMBERS(X)                                                        \
    X(uint, given, 1)               /* bits of gbuffer_import.frag: the textures that there are */ \
    X(uint, normal_packing, 1)      /* glbk_normal_packing */                               \
    X(uint, width, 1) X(uint, height, 1)                                                    \
    X(float, depth_scale, 1)        /* clip z of a depth d is depth_scale d + depth_offset */ \
    X(float, depth_offset, 1)

/* This block says which pixels a resolve draws to, and has the fields of a glbk_picture. */
#define GLBK_SHOWN_MEMBERS(X)                                                                           \
    X(mat4, to_clip, 1)             /* world to clip space, with has_depth */                           \
    X(uint, left, 1)                /* pixels of the target, an int by its bits */                      \
    X(uint, bottom, 1)                                                                                  \
    X(uint, keep_empty, 1)                                                                              \
    X(uint, has_depth, 1)

#define GLBK_GBUFFER_BLOCKS(X)                                  \
    X(glbk_gbuffer_drawn, 0, GLBK_GBUFFER_DRAWN_MEMBERS)        \
    X(glbk_gbuffer_imported, 0, GLBK_GBUFFER_IMPORTED_MEMBERS)  \
    X(glbk_shown, 7, GLBK_SHOWN_MEMBERS)

#define GLBK_GBUFFER_STORAGE(X)
#define GLBK_GBUFFER_IMAGES(X)

GLBK__PART(GBUFFER)

/* ==== src/gl_gbuffer/begin.h ==== */

/* ---- end of the declarations ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_GBUFFER_H */

/* ==== implementation ==================================================================================== */

#if defined(GL_GBUFFER_IMPLEMENTATION) && !defined(GL_GBUFFER_IMPLEMENTED)
#define GL_GBUFFER_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ==== src/shared/mem.h ==== */

/* unit mem: checked sizes, and the caller's allocator with malloc and free as its default */

typedef struct glbk_gbuf__allocator {
    void *(*alloc_fn)(size_t size, void *user);
    void (*free_fn)(void *memory, void *user);
    void *user;
} glbk_gbuf__allocator;

static inline void *glbk_gbuf__default_alloc(size_t size, void *user)
{
    (void)user;
    return malloc(size);
}

static inline void glbk_gbuf__default_free(void *memory, void *user)
{
    (void)user;
    free(memory);
}

/* Writes a * b and returns 1; returns 0, with *out untouched, if the product does not fit. */
static inline int glbk_gbuf__mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b) return 0;
    *out = a * b;
    return 1;
}

static inline glbk_gbuf__allocator glbk_gbuf__allocator_make(void *(*alloc_fn)(size_t, void *),
                                           void (*free_fn)(void *, void *), void *user)
{
    glbk_gbuf__allocator a;
    a.alloc_fn = alloc_fn && free_fn ? alloc_fn : glbk_gbuf__default_alloc;
    a.free_fn = alloc_fn && free_fn ? free_fn : glbk_gbuf__default_free;
    a.user = user;
    return a;
}

/* Returns NULL if there is no memory, and also if the size is 0, so that a caller has one thing to test. */
static inline void *glbk_gbuf__alloc(const glbk_gbuf__allocator *a, size_t size)
{
    return size ? a->alloc_fn(size, a->user) : NULL;
}

static inline void *glbk_gbuf__alloc_array(const glbk_gbuf__allocator *a, size_t count, size_t item_size)
{
    size_t size;
    return glbk_gbuf__mul_size(count, item_size, &size) ? glbk_gbuf__alloc(a, size) : NULL;
}

static inline void glbk_gbuf__free(const glbk_gbuf__allocator *a, void *memory)
{
    if (memory) a->free_fn(memory, a->user);
}

/* ==== src/shared/m4.h ==== */

/* unit m4, needs v3: column-major 4 x 4 matrices, float[16], affine */

/* Returns m, or the identity if all sixteen numbers are 0: so a struct that was zeroed stands where it is. */
static inline const float *glbk_gbuf__m4_or_identity(const float *m)
{
    static const float identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    int i;
    for (i = 0; i < 16; i++)
        if (m[i] != 0.0f) return m;         /* so does NaN, for others to refuse */
    return identity;
}

/* ==== src/shared/unit.h ==== */

/* unit unit: which vectors count as unit, the same in every header (src/README.md, "Unit vectors") */

/* The squares of the least and the greatest length that count as 1: an 8-bit normal map makes such
   vectors. */
#define GLBK_GBUF__UNIT_LEAST2 0.9409f       /* 0.97^2 */
#define GLBK_GBUF__UNIT_MOST2 1.0609f        /* 1.03^2 */

/* Says whether a vector is unit, by the square of its length. If that is not a number, the vector is not. */
static inline int glbk_gbuf__is_unit2(float length2)
{
    return length2 >= GLBK_GBUF__UNIT_LEAST2 && length2 <= GLBK_GBUF__UNIT_MOST2;
}

/* ==== src/shared/gl_memory.h ==== */

/* unit gl_memory, needs mem: the allocator of a glbk_context (gl_backend.h) */

static inline glbk_gbuf__allocator glbk_gbuf__memory(const glbk_context *ctx)
{
    const glbk_allocator *a = &ctx->system.allocator;
    return glbk_gbuf__allocator_make(a->alloc_fn, a->free_fn, a->user);
}

/* ==== GLSL of src/gl_gbuffer ==== */


static const struct { char facts[50];
    char s0[890]; char end; } glbk__glsl_lib_gbuffer_glsl GLBK__TIGHT = {
    "lib/gbuffer.glsl\0" "gbuffer_bindings gbuffer_pack" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\nbool glbk_read_point(ivec2 at,out glbk_point p)\n"
    "{\n"
    "uvec4 place=texelFetch(glbk_gbuffer_place,at,0),normal=texelFetch(glbk_gbuffer_normal,at,0);\n"
    "uvec4 color=texelFetch(glbk_gbuffer_color,at,0),gloss=texelFetch(glbk_gbuffer_gloss,at,0);\n"
    "vec4 values=uintBitsToFloat(gloss);\n"
    "p.kind=normal.w&0xffu;\n"
    "bool phong=p.kind==GLBK_PHONG,metal=p.kind==GLBK_METAL_ROUGH,lobes=p.kind==GLBK_LAFORTUNE;\n"
    "p.position=uintBitsToFloat(place.xyz);\n"
    "p.entity=place.w;\n"
    "p.normal=uintBitsToFloat(normal.xyz);\n"
    "p.plane=(normal.w>>8)&0xffu;\n"
    "p.occlusion=float(normal.w>>16)/65535.;\n"
    "p.diffuse=uintBitsToFloat(color.xyz);\n"
    "p.geometric=glbk_unpack_unit(color.w);\n"
    "p.specular=phong?values.xyz:vec3(.0);\n"
    "p.exponent=phong?values.w:.0;\n"
    "p.metallic=metal?values.x:.0;\n"
    "p.roughness=metal?values.y:.0;\n"
    "p.lobe=lobes?gloss.x:0u;\n"
    "p.lobe_count=lobes?gloss.y:0u;\n"
    "p.tangent=lobes?glbk_unpack_unit(gloss.z):vec3(.0);\n"
    "return p.kind!=0u;\n"
    "}\n", 0
};

static const struct { char facts[30];
    char s0[343]; char end; } glbk__glsl_lib_gbuffer_bindings_glsl GLBK__TIGHT = {
    "lib/gbuffer_bindings.glsl\0" "" "\0" "" "\0"
    "" "\0" "",
    "\nuniform usampler2D glbk_gbuffer_place,glbk_gbuffer_normal,glbk_gbuffer_color,\n"
    "glbk_gbuffer_gloss;\n"
    "uniform sampler2D glbk_gbuffer_color_map,glbk_gbuffer_gloss_map,glbk_gbuffer_normal_map,\n"
    "glbk_gbuffer_place_in,glbk_gbuffer_depth_in,glbk_gbuffer_normal_in,\n"
    "glbk_gbuffer_flat_in,glbk_gbuffer_open_in;\n"
    "uniform usampler2D glbk_gbuffer_entity_in;\n", 0
};

static const struct { char facts[45];
    char s0[210]; char end; } glbk__glsl_lib_gbuffer_drawn_glsl GLBK__TIGHT = {
    "lib/gbuffer_drawn.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_gbuffer_drawn",
    "\nlayout(std140)uniform glbk_gbuffer_drawn_block{\n"
    "mat4 transform,clip;\n"
    "vec4 eye,diffuse,gloss;\n"
    "uint kind,entity,plane;\n"
    "float occlusion;\n"
    "uint first_lobe,lobe_count,maps;\n"
    "float alpha_cutoff;\n"
    "}glbk_gbuffer_drawn;\n", 0
};

static const struct { char facts[51];
    char s0[269]; char end; } glbk__glsl_lib_gbuffer_imported_glsl GLBK__TIGHT = {
    "lib/gbuffer_imported.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_gbuffer_imported",
    "\nlayout(std140)uniform glbk_gbuffer_imported_block{\n"
    "mat4 from_clip,to_clip,to_world;\n"
    "vec4 eye,diffuse,gloss;\n"
    "uint kind,entity,plane;\n"
    "float occlusion;\n"
    "uint first_lobe,lobe_count,given,normal_packing,width,height;\n"
    "float depth_scale,depth_offset;\n"
    "}glbk_gbuffer_imported;\n", 0
};

static const struct { char facts[26];
    char s0[999]; char end; } glbk__glsl_lib_gbuffer_pack_glsl GLBK__TIGHT = {
    "lib/gbuffer_pack.glsl\0" "" "\0" "" "\0"
    "" "\0" "",
    "\n#define GLBK_LAMBERT 1u\n"
    "#define GLBK_PHONG 2u\n"
    "#define GLBK_LAFORTUNE 3u\n"
    "#define GLBK_METAL_ROUGH 4u\n"
    "\nstruct glbk_point{\n"
    "vec3 position;\n"
    "vec3 normal;\n"
    "vec3 geometric;\n"
    "vec3 tangent;\n"
    "uint kind;\n"
    "vec3 diffuse;\n"
    "vec3 specular;\n"
    "float exponent;\n"
    "float metallic;\n"
    "float roughness;\n"
    "uint lobe;\n"
    "uint lobe_count;\n"
    "float occlusion;\n"
    "uint entity;\n"
    "uint plane;\n"
    "};\n"
    "\n\nvec3 glbk_unit(vec3 v)\n"
    "{\n"
    "float d=dot(v,v);\n"
    "return d>.0?v*inversesqrt(d):vec3(.0);\n"
    "}\n"
    "\n\nvec3 glbk_unit_of_square(vec2 p)\n"
    "{\n"
    "float z=1.-abs(p.x)-abs(p.y),t=max(-z,.0);\n"
    "return glbk_unit(vec3(p.x+(p.x>=.0?-t:t),p.y+(p.y>=.0?-t:t),z));\n"
    "}\n"
    "\n\nuint glbk_pack_unit(vec3 n)\n"
    "{\n"
    "float sum=abs(n.x)+abs(n.y)+abs(n.z);\n"
    "if(!(sum>.0))return 0xffffffffu;\n"
    "n/=sum;\n"
    "vec2 p=n.z>=.0?n.xy:(1.-abs(n.yx))*vec2(n.x>=.0?1.:-1.,n.y>=.0?1.:-1.);\n"
    "uvec2 q=uvec2(floor(clamp(p*.5+.5,.0,1.)*65534.+.5));\n"
    "return q.x|(q.y<<16);\n"
    "}\n"
    "\n\nvec3 glbk_unpack_unit(uint bits)\n"
    "{\n"
    "if(bits==0xffffffffu)return vec3(.0);\n"
    "return glbk_unit_of_square(vec2(float(bits&0xffffu),float(bits>>16))*(2./65534.)-1.);\n"
    "}\n", 0
};

static const struct { char facts[39];
    char s0[971]; char end; } glbk__glsl_lib_gbuffer_write_glsl GLBK__TIGHT = {
    "lib/gbuffer_write.glsl\0" "gbuffer_pack" "\0" "" "\0"
    "" "\0" "",
    "\n\nlayout(location=0)out uvec4 glbk_out_place;\n"
    "layout(location=1)out uvec4 glbk_out_normal;\n"
    "layout(location=2)out uvec4 glbk_out_color;\n"
    "layout(location=3)out uvec4 glbk_out_gloss;\n"
    "\n\n\nvoid glbk_set_gloss(inout glbk_point p,vec4 numbers,vec3 map)\n"
    "{\n"
    "p.specular=numbers.xyz*map;\n"
    "p.exponent=numbers.w;\n"
    "p.metallic=numbers.x*map.z;\n"
    "p.roughness=numbers.y*map.y;\n"
    "}\n"
    "\n\nvoid glbk_write_point(glbk_point p)\n"
    "{\n"
    "uint shade=uint(clamp(p.occlusion,.0,1.)*65535.+.5);\n"
    "glbk_out_place=uvec4(floatBitsToUint(p.position),p.entity);\n"
    "glbk_out_normal=uvec4(floatBitsToUint(p.normal),p.kind|(p.plane<<8)|(shade<<16));\n"
    "glbk_out_color=uvec4(floatBitsToUint(p.diffuse),glbk_pack_unit(p.geometric));\n"
    "glbk_out_gloss=uvec4(0u);\n"
    "if(p.kind==GLBK_PHONG)glbk_out_gloss=floatBitsToUint(vec4(p.specular,p.exponent));\n"
    "if(p.kind==GLBK_METAL_ROUGH)glbk_out_gloss.xy=floatBitsToUint(vec2(p.metallic,p.roughness));\n"
    "if(p.kind==GLBK_LAFORTUNE)glbk_out_gloss=uvec4(p.lobe,p.lobe_count,glbk_pack_unit(p.tangent),0u);\n"
    "}\n", 0
};

static const struct { char facts[26];
    char s0[443]; char end; } glbk__glsl_lib_picture_glsl GLBK__TIGHT = {
    "lib/picture.glsl\0" "shown" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\nivec2 glbk_picture_at(){return ivec2(gl_FragCoord.xy)-ivec2(glbk_shown.left,glbk_shown.bottom);}\n"
    "\n\nbool glbk_picture_asks(){return(glbk_shown.keep_empty|glbk_shown.has_depth)!=0u;}\n"
    "\n\n\nvoid glbk_picture_show(bool seen,vec3 p)\n"
    "{\n"
    "if(glbk_shown.keep_empty!=0u&&!seen)discard;\n"
    "vec4 clip=glbk_shown.to_clip*vec4(p,1.);\n"
    "float deep=seen&&clip.w>.0?clamp(clip.z/clip.w*.5+.5,.0,1.):1.;\n"
    "gl_FragDepth=glbk_shown.has_depth!=0u?deep:gl_FragCoord.z;\n"
    "}\n", 0
};

static const struct { char facts[29];
    char s0[108]; char end; } glbk__glsl_lib_shown_glsl GLBK__TIGHT = {
    "lib/shown.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_shown",
    "\nlayout(std140)uniform glbk_shown_block{\n"
    "mat4 to_clip;\n"
    "uint left,bottom,keep_empty,has_depth;\n"
    "}glbk_shown;\n", 0
};

static const struct { char facts[173];
    char s0[1495]; char end; } glbk__glsl_prog_gbuffer_draw_frag GLBK__TIGHT = {
    "prog/gbuffer_draw.frag\0" "gbuffer_bindings gbuffer_drawn gbuffer_write mesh_fragment" "\0" "gbuffer_draw.vert" "\0"
    "| GBUFFER_POSITION=5 GBUFFER_NORMAL=-1 GBUFFER_UV=-1 GBUFFER_TANGENT=-1" "\0" "",
    "\n\n\n\nin vec3 glbk_place,glbk_facing;\n"
    "in vec2 glbk_uv;\n"
    "in vec4 glbk_along;\n"
    "\nconst uint has_color_map=1u,has_gloss_map=2u,has_normal_map=4u;\n"
    "\nbool has(uint map){return(glbk_gbuffer_drawn.maps&map)!=0u;}\n"
    "\n\nvoid main()\n"
    "{\n"
    "glbk_point p;\n"
    "p.position=glbk_place;\n"
    "p.geometric=glbk_unit(cross(dFdx(glbk_place),dFdy(glbk_place)));\n"
    "if(dot(p.geometric,p.geometric)==.0)\n"
    "p.geometric=glbk_unit(glbk_facing);\n"
    "if(dot(p.geometric,glbk_gbuffer_drawn.eye.xyz-glbk_place)<.0)p.geometric=-p.geometric;\n"
    "vec3 n=dot(glbk_facing,glbk_facing)>.0?glbk_unit(glbk_facing):p.geometric;\n"
    "if(dot(n,p.geometric)<.0)n=-n;\n"
    "p.tangent=glbk_unit(glbk_along.xyz-n*dot(glbk_along.xyz,n));\n"
    "if(has(has_normal_map)){\n"
    "vec3 bump=texture(glbk_gbuffer_normal_map,glbk_uv).xyz*2.-1.;\n"
    "bump.y*=glbk_along.w<.0?-1.:1.;\n"
    "if(dot(p.tangent,p.tangent)>.0)\n"
    "n=glbk_unit(p.tangent*bump.x+cross(n,p.tangent)*bump.y+n*bump.z);\n"
    "}\n"
    "p.normal=n;\n"
    "vec4 color=glbk_gbuffer_drawn.diffuse;\n"
    "vec3 map=vec3(1.);\n"
    "if(has(has_color_map))color*=texture(glbk_gbuffer_color_map,glbk_uv);\n"
    "if(has(has_gloss_map))map=texture(glbk_gbuffer_gloss_map,glbk_uv).xyz;\n"
    "bool there=glbk_fragment(glbk_uv,color);\n"
    "if(!there||color.a<glbk_gbuffer_drawn.alpha_cutoff)discard;\n"
    "p.diffuse=color.xyz;\n"
    "glbk_set_gloss(p,glbk_gbuffer_drawn.gloss,map);\n"
    "p.kind=glbk_gbuffer_drawn.kind;\n"
    "p.entity=glbk_gbuffer_drawn.entity;\n"
    "p.plane=glbk_gbuffer_drawn.plane;\n"
    "p.occlusion=glbk_gbuffer_drawn.occlusion;\n"
    "p.lobe=glbk_gbuffer_drawn.first_lobe;\n"
    "p.lobe_count=glbk_gbuffer_drawn.lobe_count;\n"
    "glbk_write_point(p);\n"
    "}\n", 0
};

static const struct { char facts[52];
    char s0[497]; char end; } glbk__glsl_prog_gbuffer_draw_vert GLBK__TIGHT = {
    "prog/gbuffer_draw.vert\0" "gbuffer_drawn mesh_vertex" "\0" "" "\0"
    "" "\0" "",
    "\n\ninvariant gl_Position;\n"
    "out vec3 glbk_place,glbk_facing;\n"
    "out vec2 glbk_uv;\n"
    "out vec4 glbk_along;\n"
    "\nvoid main()\n"
    "{\n"
    "vec3 position,normal;\n"
    "vec2 uv;\n"
    "vec4 tangent;\n"
    "glbk_vertex(position,normal,uv,tangent);\n"
    "mat3 m=mat3(glbk_gbuffer_drawn.transform);\n"
    "glbk_place=(glbk_gbuffer_drawn.transform*vec4(position,1.)).xyz;\n"
    "glbk_facing=mat3(cross(m[1],m[2]),cross(m[2],m[0]),cross(m[0],m[1]))*normal;\n"
    "glbk_along=vec4(m*tangent.xyz,tangent.w);\n"
    "glbk_uv=uv;\n"
    "gl_Position=glbk_gbuffer_drawn.clip*vec4(glbk_place,1.);\n"
    "}\n", 0
};

static const struct { char facts[109];
    char s0[3387]; char end; } glbk__glsl_prog_gbuffer_import_frag GLBK__TIGHT = {
    "prog/gbuffer_import.frag\0" "gbuffer_bindings gbuffer_imported gbuffer_write" "\0" "" "\0"
    "GBUFFER_DEPTH=0 | GBUFFER_DEPTH=1" "\0" "",
    "\n\n\n\n#ifndef GBUFFER_DEPTH\n"
    "#define GBUFFER_DEPTH 0\n"
    "#endif\n"
    "\n\nconst uint has_places=1u,has_depth=2u,has_flat=4u,has_colors=8u;\n"
    "const uint has_gloss=16u,has_occlusion=32u,has_entities=64u,reversed=128u;\n"
    "\nbool has(uint what){return(glbk_gbuffer_imported.given&what)!=0u;}\n"
    "float depth_at(ivec2 at){return texelFetch(glbk_gbuffer_depth_in,at,0).x;}\n"
    "\n\n\nvec4 place_at(ivec2 at)\n"
    "{\n"
    "ivec2 sides=ivec2(glbk_gbuffer_imported.width,glbk_gbuffer_imported.height);\n"
    "if(at.x<0||at.y<0||at.x>=sides.x||at.y>=sides.y)return vec4(.0);\n"
    "float depth=has(has_depth)?depth_at(at):.5;\n"
    "bool seen=has(reversed)?depth>.0:depth<1.;\n"
    "if(!seen)return vec4(.0);\n"
    "if(has(has_places)){\n"
    "vec4 p=texelFetch(glbk_gbuffer_place_in,at,0);\n"
    "return p.w==.0?vec4(.0):vec4((glbk_gbuffer_imported.to_world*vec4(p.xyz,1.)).xyz,1.);\n"
    "}\n"
    "vec2 xy=(vec2(at)+.5)/vec2(sides)*2.-1.;\n"
    "float z=depth*glbk_gbuffer_imported.depth_scale+glbk_gbuffer_imported.depth_offset;\n"
    "vec4 p=glbk_gbuffer_imported.from_clip*vec4(xy,z,1.);\n"
    "return vec4(p.xyz/p.w,1.);\n"
    "}\n"
    "\n\nconst uint packed_unit=2u,packed_octahedral=3u,packed_octahedral_unit=4u;\n"
    "\n\nvec3 normal_of(vec3 v)\n"
    "{\n"
    "uint packing=glbk_gbuffer_imported.normal_packing;\n"
    "if(packing==packed_unit||packing==packed_octahedral_unit)v=v*2.-1.;\n"
    "if(packing>=packed_octahedral)v=glbk_unit_of_square(v.xy);\n"
    "float d=dot(v,v);\n"
    "if(!(d>.25&&d<2.25))return vec3(.0);\n"
    "return glbk_unit(mat3(glbk_gbuffer_imported.to_world)*v);\n"
    "}\n"
    "\n\n\n\nvec3 step_along(ivec2 at,ivec2 by,vec3 p,vec3 n)\n"
    "{\n"
    "vec4 a=place_at(at+by),b=place_at(at-by);\n"
    "vec3 da=a.xyz-p,db=p-b.xyz;\n"
    "float off_a=dot(da,n)*dot(da,n)*dot(db,db),off_b=dot(db,n)*dot(db,n)*dot(da,da);\n"
    "bool first=a.w!=.0&&(b.w==.0||off_a<=off_b);\n"
    "return first?da:b.w!=.0?db:vec3(.0);\n"
    "}\n"
    "\n\nvec3 flat_normal(ivec2 at,vec3 place,vec3 n)\n"
    "{\n"
    "if(has(has_flat))return normal_of(texelFetch(glbk_gbuffer_flat_in,at,0).xyz);\n"
    "return glbk_unit(cross(step_along(at,ivec2(1,0),place,n),step_along(at,ivec2(0,1),place,n)));\n"
    "}\n"
    "\n#if GBUFFER_DEPTH\n"
    "\nfloat drawn_depth(ivec2 at,vec3 place)\n"
    "{\n"
    "if(has(has_depth))return has(reversed)?1.-depth_at(at):depth_at(at);\n"
    "vec4 clip=glbk_gbuffer_imported.to_clip*vec4(place,1.);\n"
    "return clip.w>.0?clamp(clip.z/clip.w*.5+.5,.0,1.):.0;\n"
    "}\n"
    "#endif\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_FragCoord.xy);\n"
    "vec4 place=place_at(at);\n"
    "vec3 n=normal_of(texelFetch(glbk_gbuffer_normal_in,at,0).xyz);\n"
    "if(place.w==.0||dot(n,n)==.0)discard;\n"
    "vec3 view=glbk_gbuffer_imported.eye.xyz-place.xyz;\n"
    "vec3 flat_n=flat_normal(at,place.xyz,n);\n"
    "if(dot(flat_n,view)<.0)flat_n=-flat_n;\n"
    "if(dot(n,flat_n)<.0)n=-n;\n"
    "if(!has(has_flat)&&dot(n,flat_n)<.25){\n"
    "flat_n=dot(n,view)<.0?-n:n;\n"
    "n=flat_n;\n"
    "}\n"
    "vec3 map=vec3(1.);\n"
    "glbk_point p;\n"
    "p.position=place.xyz;\n"
    "p.normal=n;\n"
    "p.geometric=flat_n;\n"
    "p.tangent=vec3(.0);\n"
    "p.kind=glbk_gbuffer_imported.kind;\n"
    "p.plane=glbk_gbuffer_imported.plane;\n"
    "p.lobe=glbk_gbuffer_imported.first_lobe;\n"
    "p.lobe_count=glbk_gbuffer_imported.lobe_count;\n"
    "p.diffuse=glbk_gbuffer_imported.diffuse.xyz;\n"
    "p.occlusion=glbk_gbuffer_imported.occlusion;\n"
    "p.entity=glbk_gbuffer_imported.entity;\n"
    "if(has(has_colors))p.diffuse*=texelFetch(glbk_gbuffer_color_map,at,0).xyz;\n"
    "if(has(has_gloss))map=texelFetch(glbk_gbuffer_gloss_map,at,0).xyz;\n"
    "if(has(has_occlusion))p.occlusion=1.-texelFetch(glbk_gbuffer_open_in,at,0).x;\n"
    "if(has(has_entities))p.entity=texelFetch(glbk_gbuffer_entity_in,at,0).x;\n"
    "glbk_set_gloss(p,glbk_gbuffer_imported.gloss,map);\n"
    "#if GBUFFER_DEPTH\n"
    "gl_FragDepth=drawn_depth(at,place.xyz);\n"
    "#endif\n"
    "glbk_write_point(p);\n"
    "}\n", 0
};

static const glbk_file glbk__gbuffer_files[] = {
    { (const char *)&glbk__glsl_lib_gbuffer_glsl },
    { (const char *)&glbk__glsl_lib_gbuffer_bindings_glsl },
    { (const char *)&glbk__glsl_lib_gbuffer_drawn_glsl },
    { (const char *)&glbk__glsl_lib_gbuffer_imported_glsl },
    { (const char *)&glbk__glsl_lib_gbuffer_pack_glsl },
    { (const char *)&glbk__glsl_lib_gbuffer_write_glsl },
    { (const char *)&glbk__glsl_lib_picture_glsl },
    { (const char *)&glbk__glsl_lib_shown_glsl },
    { (const char *)&glbk__glsl_prog_gbuffer_draw_frag },
    { (const char *)&glbk__glsl_prog_gbuffer_draw_vert },
    { (const char *)&glbk__glsl_prog_gbuffer_import_frag }
};


/* ==== src/gl_gbuffer/part.h ==== */

/* ---- gbuffer: this header's GLSL, textures and blocks, by which programs find them ---- */

GLBK__PART_CODE(gbuffer, GBUFFER)

/* The part as the techniques' own programs use it has only the files that read and those of pictures,
   so that a linker leaves out those that draw and import. */
static const glbk_file glbk__gbuffer_reads[] = {
    { (const char *)&glbk__glsl_lib_gbuffer_glsl },
    { (const char *)&glbk__glsl_lib_gbuffer_bindings_glsl },
    { (const char *)&glbk__glsl_lib_gbuffer_pack_glsl },
    { (const char *)&glbk__glsl_lib_picture_glsl },
    { (const char *)&glbk__glsl_lib_shown_glsl }
};
static const glbk_part glbk__gbuffer_reader = {
    "gbuffer", glbk__gbuffer_reads, sizeof glbk__gbuffer_reads / sizeof glbk__gbuffer_reads[0],
    glbk__gbuffer_slots
};

/* ==== src/gl_gbuffer/refusing.h ==== */

/* ---- gbuffer: why a call fails, for all techniques ---- */

GLBK__DEF glbk_result glbk__require(const glbk_context *ctx, const char *function, const char *field,
                                    const void *argument)
{
    if (ctx && argument) return GLBK_OK;
    return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, field, "is NULL");
}

GLBK__DEF glbk_result glbk__require_created(const glbk_context *ctx, const char *function, const char *field,
                                            const uint32_t *name)
{
    const glbk_result result = glbk__require(ctx, function, field, name);
    if (result != GLBK_OK || *name) return result;
    return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, field, "was not created");
}

GLBK__DEF glbk_result glbk__require_side(const glbk_context *ctx, const char *function, const char *field,
                                         uint32_t side)
{
    const glbk_result result = side ? GLBK_ERR_LIMIT : GLBK_ERR_DESC;
    if (side && side <= ctx->max_side) return GLBK_OK;
    return glbk__refuse_range(ctx, result, function, field, side, 1, ctx->max_side);
}

GLBK__DEF glbk_result glbk__require_gbuffer(const glbk_context *ctx, const char *function,
                                            const glbk_gbuffer *gbuffer, uint32_t width, uint32_t height)
{
    glbk_result result =
        glbk__require_created(ctx, function, "gbuffer", gbuffer ? &gbuffer->colors.name : NULL);
    if (result != GLBK_OK) return result;
    result = GLBK_ERR_MISMATCH;
    if (gbuffer->width != width)
        return glbk__refuse_range(ctx, result, function, "gbuffer->width", gbuffer->width, width, width);
    if (gbuffer->height != height)
        return glbk__refuse_range(ctx, result, function, "gbuffer->height", gbuffer->height, height, height);
    return GLBK_OK;
}

GLBK__DEF void glbk__name_element(char out[GLBK__ELEMENT_ROOM], const char *array, size_t index,
                                  const char *member)
{
    glbk__sink sink;
    glbk__begin_line(&sink, out);
    glbk__append_text(&sink, array);
    if (index != GLBK__NO_INDEX) {
        glbk__append_text(&sink, "[");
        glbk__append_number(&sink, index);
        glbk__append_text(&sink, "]");
    }
    glbk__append_text(&sink, member);
}

GLBK__DEF glbk_result glbk__refuse_element(const glbk_context *ctx, glbk_result result, const char *function,
                                           const char *array, size_t index, const char *member,
                                           const char *text)
{
    char field[GLBK__ELEMENT_ROOM];
    glbk__name_element(field, array, index, member);
    return glbk__refuse(ctx, result, function, field, text);
}

GLBK__DEF glbk_result glbk__refuse_element_value(const glbk_context *ctx, glbk_result result,
                                                 const char *function, const char *array, size_t index,
                                                 const char *member, double value, const char *wanted)
{
    char field[GLBK__ELEMENT_ROOM];
    glbk__name_element(field, array, index, member);
    return glbk__refuse_value(ctx, result, function, field, value, wanted);
}

/* ==== src/gl_gbuffer/making.h ==== */

/* ---- gbuffer: creating, uploading, reading ---- */

/* Logs that a field of a desc is bad, and returns the error. */
static glbk_result glbk__gbuffer_bad(const glbk_context *ctx, const char *function, const char *field,
                                     const char *text)
{
    return glbk__refuse(ctx, GLBK_ERR_DESC, function, field, text);
}

/* Returns 1 if a number is within its range, else logs it and returns 0. */
static int glbk__gbuffer_within(const glbk_context *ctx, const char *function, const char *field,
                                double value, double low, double high)
{
    if (value >= low && value <= high) return 1;
    (void)glbk__refuse_range(ctx, GLBK_ERR_DESC, function, field, value, low, high);
    return 0;
}

/* Returns 1 if the numbers of a material and its place are in range, else logs which one is not and returns
   0. */
static int glbk__gbuffer_material_valid(const glbk_context *ctx, const char *function,
                                        const lsamp_material *m, uint32_t plane, float occlusion)
{
    return glbk__gbuffer_within(ctx, function, "material.kind", m->kind, 0, LSAMP_MATERIAL_COUNT - 1) &&
           glbk__gbuffer_within(ctx, function, "material.lobe_count", m->lobe_count, 0, LSAMP_MAX_LOBES) &&
           glbk__gbuffer_within(ctx, function, "plane", plane, 0, 255) &&
           glbk__gbuffer_within(ctx, function, "occlusion", (double)occlusion, 0, 1);
}

/* Returns the kind of a material with the default resolved, as the G-buffer stores it. */
static uint32_t glbk__gbuffer_kind(const lsamp_material *m)
{
    return m->kind == LSAMP_MATERIAL_DEFAULT ? (uint32_t)LSAMP_MATERIAL_LAMBERT : (uint32_t)m->kind;
}

/* Writes the numbers of a material other than its diffuse colour and its lobes, as the texture of gloss has
   them. */
static void glbk__gbuffer_gloss(const lsamp_material *m, float gloss[4])
{
    memset(gloss, 0, 4 * sizeof *gloss);
    if (m->kind == LSAMP_MATERIAL_PHONG) {
        memcpy(gloss, m->specular, sizeof m->specular);
        gloss[3] = m->exponent;
    } else if (m->kind == LSAMP_MATERIAL_METAL_ROUGH) {
        gloss[0] = m->metallic;
        gloss[1] = m->roughness;
    }
}

/* Returns 1 if all `count` numbers are 0. */
static int glbk__gbuffer_is_zero(const float *v, int count)
{
    int i;
    for (i = 0; i < count && v[i] == 0; i++) {}
    return i == count;
}

GLBK__DEF glbk_result glbk__take_attributes(const glbk_context *ctx, const char *function,
                                            const glbk_attributes *from, glbk_attributes *to)
{
    static const char *const names[4] = { "desc.attributes.position", "desc.attributes.normal",
                                          "desc.attributes.uv", "desc.attributes.tangent" };
    int32_t at[4];
    int i, k;
    *to = *from;
    if (from->vertex) return GLBK_OK;       /* which finds its attributes itself */
    if (!from->position && !from->normal && !from->uv && !from->tangent)
        to->normal = 1, to->uv = 2, to->tangent = 3;
    at[0] = to->position;
    at[1] = to->normal;
    at[2] = to->uv;
    at[3] = to->tangent;
    if (at[0] < 0)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, names[0], at[0], 0, 15);
    for (i = 0; i < 4; i++) {
        if (at[i] > 15)
            return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, names[i], at[i], "at most 15");
        for (k = 0; k < i && at[i] >= 0; k++)
            if (at[i] == at[k])
                return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, names[i], at[i],
                                          "used by no other attribute");
    }
    return GLBK_OK;
}

/* Writes defines for a program whose vertex shader has its attributes there. */
static void glbk__write_attributes(const glbk_attributes *at, const char *more,
                                   char defines[GLBK__ATTRIBUTES_ROOM])
{
    static const char *const names[4] = { "GBUFFER_POSITION=", " GBUFFER_NORMAL=", " GBUFFER_UV=",
                                          " GBUFFER_TANGENT=" };
    int32_t locations[4];
    size_t used = 0;
    int i;

    locations[0] = at->position;
    locations[1] = at->normal;
    locations[2] = at->uv;
    locations[3] = at->tangent;
    for (i = 0; i < 4; i++) {
        memcpy(defines + used, names[i], strlen(names[i]));
        used += strlen(names[i]);
        if (locations[i] < 0) defines[used++] = '-';
        if (locations[i] > 9) defines[used++] = '1';
        defines[used++] = (char)(locations[i] < 0 ? '1' : '0' + locations[i] % 10);
    }
    defines[used++] = ' ';
    memcpy(defines + used, more, strlen(more) + 1);
}

GLBK__DEF glbk_result glbk__drawing_program(glbk_context *ctx, const glbk_part *part, const char *name,
                                            const glbk_attributes *at, const char *more, glbk_program *out)
{
    const char *texts[2];
    char defines[GLBK__ATTRIBUTES_ROOM];
    size_t used;
    glbk__write_attributes(at, more, defines);
    used = strlen(defines);
    if (at->vertex) memcpy(defines + used, " GLBK_OWN_VERTEX", 17);
    used = strlen(defines);
    if (at->fragment) memcpy(defines + used, " GLBK_OWN_FRAGMENT", 19);
    texts[0] = at->vertex;
    texts[1] = at->fragment;
    return glbk__program_of_parts(ctx, part, NULL, name, defines, texts, out);
}

/* Makes textures and targets of a G-buffer whose width and height are set. */
static glbk_result glbk__gbuffer_make(glbk_context *ctx, const glbk_gbuffer_desc *d, glbk_gbuffer *out)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result = GLBK_OK;
    int i;

    memset(&texture, 0, sizeof texture);
    memset(&target, 0, sizeof target);
    texture.width = out->width;
    texture.height = out->height;
    texture.format = GLBK_FORMAT_RGBA32UI;
    for (i = 0; i < 4 && result == GLBK_OK; i++) {
        result = glbk_texture_create(ctx, &texture, &out->words[i]);
        target.color[i] = &out->words[i];
    }
    if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &out->colors);
    texture.format = GLBK_FORMAT_DEPTH32F;
    out->own_depth = !d->depth;
    if (d->depth) out->depth = *d->depth;
    else if (result == GLBK_OK) result = glbk_texture_create(ctx, &texture, &out->depth);
    target.depth = &out->depth;
    if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &out->target);
    return result;
}

/* Fills the four textures with zeros, by which nothing is seen anywhere, some rows a call: up to 2^16 pixels,
   1 MB. A call a row takes browsers a tenth of a second. */
static glbk_result glbk__gbuffer_clear_words(glbk_context *ctx, glbk_gbuffer *g)
{
    glbk_gbuf__allocator memory = glbk_gbuf__memory(ctx);
    const uint32_t most = g->width < 65536u ? 65536u / g->width : 1;
    const uint32_t rows = most < g->height ? most : g->height;
    const size_t count = 4 * (size_t)g->width * rows;
    uint32_t *zeros = (uint32_t *)glbk_gbuf__alloc_array(&memory, count, sizeof *zeros), y;
    glbk_result result = zeros ? GLBK_OK : GLBK_ERR_ALLOC;
    int i;
    if (zeros) memset(zeros, 0, count * sizeof *zeros);
    for (i = 0; i < 4; i++)
        for (y = 0; y < g->height && result == GLBK_OK; y += rows) {
            const uint32_t left = g->height - y;
            const glbk_box box = { 0, 0, y, 0, g->width, left < rows ? left : rows, 1 };
            result = glbk_texture_update(ctx, &g->words[i], &box, zeros);
        }
    glbk_gbuf__free(&memory, zeros);
    return result;
}

/* Checks the sizes of a desc. */
static glbk_result glbk__gbuffer_check_desc(const glbk_context *ctx, const char *function,
                                            const glbk_gbuffer_desc *d)
{
    glbk_result result = glbk__require(ctx, function, "desc", d);
    if (result != GLBK_OK) return result;
    result = glbk__require_side(ctx, function, "desc.width", d->width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, function, "desc.height", d->height);
    if (result != GLBK_OK) return result;
    if (d->depth && d->depth->width != d->width)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "desc.depth->width", d->depth->width,
                                  "desc.width");
    if (d->depth && d->depth->height != d->height)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "desc.depth->height", d->depth->height,
                                  "desc.height");
    if (d->depth && (d->depth->format < GLBK_FORMAT_DEPTH24 || d->depth->format > GLBK_FORMAT_DEPTH32F))
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "desc.depth->format",
                                  (double)d->depth->format, "a GLBK_FORMAT_DEPTH...");
    return GLBK_OK;
}

/* Gives a G-buffer, which has no textures, those of a checked desc, in which nothing is seen. */
static glbk_result glbk__gbuffer_fill(glbk_context *ctx, const glbk_gbuffer_desc *d, glbk_gbuffer *out)
{
    glbk_result result;
    out->width = d->width;
    out->height = d->height;
    result = glbk__gbuffer_make(ctx, d, out);
    if (result == GLBK_OK) result = glbk__gbuffer_clear_words(ctx, out);
    return result;
}

GLBK_DEF glbk_result glbk_gbuffer_create(glbk_context *ctx, const glbk_gbuffer_desc *d, glbk_gbuffer *out)
{
    glbk_result result;
    if (out) memset(out, 0, sizeof *out);
    result = glbk__require(ctx, __func__, "out", out);
    if (result == GLBK_OK) result = glbk__gbuffer_check_desc(ctx, __func__, d);
    if (result != GLBK_OK) return result;
    result = glbk__take_attributes(ctx, __func__, &d->attributes, &out->attributes);
    if (result == GLBK_OK) result = glbk__gbuffer_fill(ctx, d, out);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_gbuffer_drawn), NULL, &out->drawn);
    if (result == GLBK_OK)
        result = glbk_buffer_create(ctx, sizeof(glbk_gbuffer_imported), NULL, &out->imported);
    result = glbk__leave_created(ctx, result);
    if (result != GLBK_OK) glbk_gbuffer_free(ctx, out);
    return result;
}

/* Deletes textures and targets. */
static void glbk__gbuffer_empty(glbk_context *ctx, glbk_gbuffer *g)
{
    int i;
    glbk_target_free(ctx, &g->target);
    glbk_target_free(ctx, &g->colors);
    for (i = 0; i < 4; i++) glbk_texture_free(ctx, &g->words[i]);
    if (g->own_depth) glbk_texture_free(ctx, &g->depth);
}

GLBK_DEF glbk_result glbk_gbuffer_resize(glbk_context *ctx, glbk_gbuffer *g, const glbk_gbuffer_desc *d)
{
    glbk_result result = glbk__require_created(ctx, __func__, "gbuffer", g ? &g->target.name : NULL);
    if (result == GLBK_OK) result = glbk__gbuffer_check_desc(ctx, __func__, d);
    if (result != GLBK_OK) return result;
    glbk__gbuffer_empty(ctx, g);
    g->has_depth = g->has_clip = 0;
    result = glbk__leave_created(ctx, glbk__gbuffer_fill(ctx, d, g));
    if (result != GLBK_OK) glbk_gbuffer_free(ctx, g);
    return result;
}

GLBK_DEF void glbk_gbuffer_free(glbk_context *ctx, glbk_gbuffer *g)
{
    if (!g) return;
    glbk__gbuffer_empty(ctx, g);
    glbk_program_free(ctx, &g->draw_program);
    glbk_program_free(ctx, &g->import_program);
    glbk_buffer_free(ctx, &g->drawn);
    glbk_buffer_free(ctx, &g->imported);
    memset(g, 0, sizeof *g);
}

/* Packs a unit vector into 32 bits as glbk_pack_unit of lib/gbuffer_pack.glsl does, octahedrally; a vector of
   no length becomes 0xffffffff. */
static uint32_t glbk__gbuffer_pack_unit(const float *v)
{
    const float ax = fabsf(v[0]), ay = fabsf(v[1]), sum = ax + ay + fabsf(v[2]);
    float x, y;

    if (!(sum > 0)) return 0xffffffffu;
    x = v[0] / sum;
    y = v[1] / sum;
    if (v[2] < 0) {
        x = (1 - ay / sum) * (v[0] < 0 ? -1.0f : 1.0f);
        y = (1 - ax / sum) * (v[1] < 0 ? -1.0f : 1.0f);
    }
    x = (x * 0.5f + 0.5f) * 65534.0f + 0.5f;
    y = (y * 0.5f + 0.5f) * 65534.0f + 0.5f;
    return (uint32_t)(x > 0 ? x : 0) | (uint32_t)(y > 0 ? y : 0) << 16;
}

/* Unpacks what glbk__gbuffer_pack_unit packed; 0xffffffff becomes a vector of no length. */
static void glbk__gbuffer_unpack_unit(uint32_t bits, float *v)
{
    float x = (float)(bits & 0xffffu) * (2.0f / 65534.0f) - 1;
    float y = (float)(bits >> 16) * (2.0f / 65534.0f) - 1;
    float z = 1 - fabsf(x) - fabsf(y), t = z < 0 ? -z : 0, size;

    memset(v, 0, 3 * sizeof *v);
    if (bits == 0xffffffffu) return;
    x += x < 0 ? t : -t;
    y += y < 0 ? t : -t;
    size = sqrtf(x * x + y * y + z * z);
    v[0] = x / size;
    v[1] = y / size;
    v[2] = z / size;
}

/* Writes the four words of each texture for one pixel. Where its normal is 0 or not finite, nothing is
   seen. */
static void glbk__gbuffer_words(const glbk_pixel *p, uint32_t words[4][4])
{
    const lsamp_material *m = &p->material;
    const float *n = p->normal;
    const float d = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    const float shade = p->occlusion > 0 ? p->occlusion < 1 ? p->occlusion : 1.0f : 0.0f;
    float gloss[4];

    memset(words, 0, 16 * sizeof words[0][0]);
    if (!(d > 0 && d < 3e38f)) return;
    memcpy(words[0], p->position, 12);
    words[0][3] = p->entity;
    memcpy(words[1], n, 12);
    words[1][3] = glbk__gbuffer_kind(m) | (p->plane & 255u) << 8 | (uint32_t)(shade * 65535.0f + 0.5f) << 16;
    memcpy(words[2], m->diffuse, 12);
    words[2][3] =
        glbk__gbuffer_pack_unit(glbk__gbuffer_is_zero(p->geometric_normal, 3) ? n : p->geometric_normal);
    glbk__gbuffer_gloss(m, gloss);
    memcpy(words[3], gloss, sizeof gloss);
    if (m->kind != LSAMP_MATERIAL_LAFORTUNE) return;
    words[3][0] = p->first_lobe;
    words[3][1] = m->lobe_count;
    words[3][2] = glbk__gbuffer_pack_unit(p->tangent);
}

/* Reads back what glbk__gbuffer_words wrote. */
static void glbk__gbuffer_pixel(uint32_t words[4][4], glbk_pixel *p)
{
    lsamp_material *m = &p->material;
    float gloss[4];

    memset(p, 0, sizeof *p);
    if (!(words[1][3] & 255u)) return;
    memcpy(p->position, words[0], 12);
    p->entity = words[0][3];
    memcpy(p->normal, words[1], 12);
    m->kind = (lsamp_material_kind)(words[1][3] & 255u);
    p->plane = words[1][3] >> 8 & 255u;
    p->occlusion = (float)(words[1][3] >> 16) / 65535.0f;
    memcpy(m->diffuse, words[2], 12);
    glbk__gbuffer_unpack_unit(words[2][3], p->geometric_normal);
    memcpy(gloss, words[3], sizeof gloss);
    if (m->kind == LSAMP_MATERIAL_PHONG) {
        memcpy(m->specular, gloss, sizeof m->specular);
        m->exponent = gloss[3];
    } else if (m->kind == LSAMP_MATERIAL_METAL_ROUGH) {
        m->metallic = gloss[0];
        m->roughness = gloss[1];
    } else if (m->kind == LSAMP_MATERIAL_LAFORTUNE) {
        p->first_lobe = words[3][0];
        m->lobe_count = words[3][1];
        glbk__gbuffer_unpack_unit(words[3][2], p->tangent);
    }
}

/* The words of some rows on their way: texture k has those of pixel i from words + 4 (k count + i) on. */
typedef struct glbk__gbuffer_rows {
    glbk_gbuf__allocator memory;
    size_t    count;                /* pixels */
    uint32_t *words;
} glbk__gbuffer_rows;

/* Checks the arguments of an upload or a reading and gets memory for its words, which glbk_gbuf__free
   frees. */
static glbk_result glbk__gbuffer_take_rows(const glbk_context *ctx, const char *function,
                                           const glbk_gbuffer *g, uint32_t row, uint32_t row_count,
                                           const glbk_pixel *pixels, glbk__gbuffer_rows *out)
{
    const glbk_result bad = GLBK_ERR_ARGUMENT;
    glbk_result result = glbk__require_created(ctx, function, "gbuffer", g ? &g->colors.name : NULL);
    if (result == GLBK_OK) result = glbk__require(ctx, function, "pixels", pixels);
    if (result != GLBK_OK) return result;
    if (row >= g->height)
        return glbk__refuse_range(ctx, bad, function, "row", row, 0, g->height - 1.0);
    if (!row_count || row_count > g->height - row)
        return glbk__refuse_range(ctx, bad, function, "row_count", row_count, 1, g->height - row);
    out->memory = glbk_gbuf__memory(ctx);
    out->count = (size_t)g->width * row_count;
    out->words = (uint32_t *)glbk_gbuf__alloc_array(&out->memory, out->count, 64);
    return out->words ? GLBK_OK : GLBK_ERR_ALLOC;
}

/* Checks that a vector of pixel i is unit, 0 0 0, or not finite (src/README.md). */
static glbk_result glbk__gbuffer_check_unit(const glbk_context *ctx, size_t i, const char *member,
                                            const float *v)
{
    const float square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    if (glbk_gbuf__is_unit2(square) || !(square > 0 && square <= 3e38f)) return GLBK_OK;
    return glbk__refuse_element_value(ctx, GLBK_ERR_INPUT, "glbk_gbuffer_upload", "pixels", i, member,
                                      (double)sqrtf(square), "0.97..1.03, or 0");
}

/* Checks the vectors of pixels. */
static glbk_result glbk__gbuffer_check_pixels(const glbk_context *ctx, const glbk_pixel *pixels, size_t count)
{
    glbk_result result = GLBK_OK;
    size_t i;
    for (i = 0; i < count && result == GLBK_OK; i++) {
        result = glbk__gbuffer_check_unit(ctx, i, ".normal: its length", pixels[i].normal);
        if (result == GLBK_OK)
            result = glbk__gbuffer_check_unit(ctx, i, ".geometric_normal: its length",
                                              pixels[i].geometric_normal);
        if (result == GLBK_OK)
            result = glbk__gbuffer_check_unit(ctx, i, ".tangent: its length", pixels[i].tangent);
    }
    return result;
}

GLBK_DEF glbk_result glbk_gbuffer_upload(glbk_context *ctx, glbk_gbuffer *g, uint32_t row, uint32_t row_count,
                                         const glbk_pixel *pixels)
{
    glbk__gbuffer_rows rows;
    uint32_t pixel[4][4], k;
    glbk_result result = glbk__gbuffer_take_rows(ctx, __func__, g, row, row_count, pixels, &rows);
    glbk_box box = { 0, 0, 0, 0, 0, 0, 1 };
    size_t i;

    if (result != GLBK_OK) return result;
    box.y = row;
    box.width = g->width;
    box.height = row_count;
    result = glbk__gbuffer_check_pixels(ctx, pixels, rows.count);
    for (i = 0; i < rows.count && result == GLBK_OK; i++) {
        glbk__gbuffer_words(&pixels[i], pixel);
        for (k = 0; k < 4; k++) memcpy(rows.words + 4 * (k * rows.count + i), pixel[k], sizeof pixel[k]);
    }
    for (k = 0; k < 4 && result == GLBK_OK; k++)
        result = glbk_texture_update(ctx, &g->words[k], &box, rows.words + 4 * k * rows.count);
    glbk_gbuf__free(&rows.memory, rows.words);
    if (result == GLBK_OK) g->has_depth = g->has_clip = 0;
    return result;
}

GLBK_DEF glbk_result glbk_gbuffer_read(glbk_context *ctx, const glbk_gbuffer *g, uint32_t row,
                                       uint32_t row_count, glbk_pixel *pixels)
{
    glbk__gbuffer_rows rows;
    uint32_t pixel[4][4], k;
    glbk_result result = glbk__gbuffer_take_rows(ctx, __func__, g, row, row_count, pixels, &rows);
    size_t i;

    if (result != GLBK_OK) return result;
    for (k = 0; k < 4 && result == GLBK_OK; k++)
        result = glbk_target_read(ctx, &g->colors, k, 0, row, g->width, row_count,
                                  rows.words + 4 * k * rows.count);
    for (i = 0; i < rows.count && result == GLBK_OK; i++) {
        for (k = 0; k < 4; k++) memcpy(pixel[k], rows.words + 4 * (k * rows.count + i), sizeof pixel[k]);
        glbk__gbuffer_pixel(pixel, &pixels[i]);
    }
    glbk_gbuf__free(&rows.memory, rows.words);
    return result;
}

GLBK_DEF glbk_result glbk_gbuffer_bind(glbk_context *ctx, const glbk_gbuffer *g, const glbk_offset *offset)
{
    const uint32_t first = GLBK_SLOT_glbk_gbuffer_place + glbk__offset(offset).unit;
    const glbk_result result = glbk__require_created(ctx, __func__, "gbuffer", g ? &g->colors.name : NULL);
    uint32_t i;
    if (result != GLBK_OK) return result;
    for (i = 0; i < 4; i++) glbk_bind_texture(ctx, first + i, &g->words[i]);
    return GLBK_OK;
}

GLBK__DEF glbk_result glbk__gbuffer_program_with(glbk_context *ctx, const glbk_part *part, const char *name,
                                                 const char *defines, const char *const texts[2],
                                                 glbk_program *out)
{
    const glbk_part *const others[2] = { &glbk__gbuffer_reader, NULL };
    return glbk__program_of_parts(ctx, part, others, name, defines, texts, out);
}

GLBK__DEF glbk_result glbk__gbuffer_program_above(glbk_context *ctx, const glbk_part *part,
                                                  const glbk_part *under, const char *name,
                                                  const char *defines, glbk_program *out)
{
    const glbk_part *const others[2] = { &glbk__gbuffer_reader, under };
    return glbk__program_of_parts(ctx, part, others, name, defines, NULL, out);
}

GLBK__DEF glbk_result glbk__gbuffer_program(glbk_context *ctx, const glbk_part *part, const char *name,
                                            const char *defines, glbk_program *out)
{
    return glbk__gbuffer_program_with(ctx, part, name, defines, NULL, out);
}

/* ==== src/gl_gbuffer/drawing.h ==== */

/* ---- gbuffer: drawing ---- */

enum { GLBK__DRAWN_COLOR_MAP = 1, GLBK__DRAWN_GLOSS_MAP = 2, GLBK__DRAWN_NORMAL_MAP = 4 };

/* Compiles the program that draws objects, for the locations of the G-buffer's attributes, unless there is
   one. */
static glbk_result glbk__gbuffer_draw_program(glbk_context *ctx, glbk_gbuffer *g)
{
    if (g->draw_program.name) return GLBK_OK;
    return glbk__drawing_program(ctx, glbk_gbuffer_part(), "gbuffer_draw.frag", &g->attributes, "",
                                 &g->draw_program);
}

/* Binds a target of the G-buffer with a program, and clears its textures to 0 and its depth, if any, to 1. */
static glbk_result glbk__gbuffer_start(glbk_context *ctx, const glbk_target *target, glbk_depth depth,
                                       glbk_program *program)
{
    static const float zero[4] = { 0, 0, 0, 0 };
    glbk_pass pass;
    glbk_result result;
    uint32_t i;

    memset(&pass, 0, sizeof pass);
    pass.target = target;
    pass.depth = depth;
    result = glbk_begin(ctx, &pass, program);
    if (result != GLBK_OK) return result;
    for (i = 0; i < 4; i++) glbk_clear(ctx, target, i, zero);
    if (depth != GLBK_DEPTH_OFF) glbk_clear_depth(ctx, 1);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_gbuffer_begin(glbk_context *ctx, glbk_gbuffer *g, const float world_to_clip[16],
                                        const float eye[3])
{
    glbk_result result;
    uint32_t i;

    result = glbk__require_created(ctx, __func__, "gbuffer", g ? &g->target.name : NULL);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "world_to_clip", world_to_clip);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "eye", eye);
    if (result == GLBK_OK) result = glbk__gbuffer_draw_program(ctx, g);
    if (result == GLBK_OK) result = glbk__gbuffer_start(ctx, &g->target, GLBK_DEPTH_LESS, &g->draw_program);
    if (result != GLBK_OK) return result;
    /* The program declares the samplers of maps, which an object without maps leaves as they are. */
    for (i = 0; i < 3; i++) glbk_bind_texture(ctx, GLBK_SLOT_glbk_gbuffer_color_map + i, NULL);
    memcpy(g->world_to_clip, world_to_clip, sizeof g->world_to_clip);
    memcpy(g->eye, eye, sizeof g->eye);
    g->has_depth = g->has_clip = 1;
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_gbuffer_object(glbk_context *ctx, glbk_gbuffer *g, const glbk_surface *s)
{
    glbk_gbuffer_drawn drawn;
    glbk_result result;

    result = glbk__require_created(ctx, __func__, "gbuffer", g ? &g->target.name : NULL);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "surface", s);
    if (result != GLBK_OK) return result;
    if (!g->draw_program.name || !g->has_clip)
        return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "gbuffer", "was not begun: glbk_gbuffer_begin");
    if (!glbk__gbuffer_material_valid(ctx, __func__, &s->material, s->plane, s->occlusion))
        return GLBK_ERR_DESC;
    memset(&drawn, 0, sizeof drawn);
    memcpy(drawn.transform, glbk_gbuf__m4_or_identity(s->transform), sizeof drawn.transform);
    memcpy(drawn.clip, g->world_to_clip, sizeof drawn.clip);
    memcpy(drawn.eye, g->eye, sizeof g->eye);
    memcpy(drawn.diffuse, s->material.diffuse, sizeof s->material.diffuse);
    drawn.diffuse[3] = s->alpha > 0 ? s->alpha : 1.0f;
    drawn.alpha_cutoff = s->alpha_cutoff;
    drawn.occlusion = s->occlusion;
    drawn.kind = glbk__gbuffer_kind(&s->material);
    drawn.entity = s->entity;
    drawn.plane = s->plane;
    drawn.first_lobe = s->first_lobe;
    drawn.lobe_count = s->material.lobe_count;
    if (s->color_map) drawn.maps |= GLBK__DRAWN_COLOR_MAP;
    if (s->gloss_map) drawn.maps |= GLBK__DRAWN_GLOSS_MAP;
    if (s->normal_map) drawn.maps |= GLBK__DRAWN_NORMAL_MAP;
    glbk__gbuffer_gloss(&s->material, drawn.gloss);
    result = glbk__put_block(ctx, GLBK_SLOT_glbk_gbuffer_drawn, &g->drawn, &drawn);
    if (result != GLBK_OK) return result;
    if (s->color_map) glbk_bind_texture(ctx, GLBK_SLOT_glbk_gbuffer_color_map, s->color_map);
    if (s->gloss_map) glbk_bind_texture(ctx, GLBK_SLOT_glbk_gbuffer_gloss_map, s->gloss_map);
    if (s->normal_map) glbk_bind_texture(ctx, GLBK_SLOT_glbk_gbuffer_normal_map, s->normal_map);
    return GLBK_OK;
}

/* ==== src/gl_gbuffer/importing.h ==== */

/* ---- gbuffer: from textures of the user's own ---- */

/* Bits of the block's `given`, as gbuffer_import.frag has them. */
enum {
    GLBK__IMPORT_PLACES = 1, GLBK__IMPORT_DEPTH = 2, GLBK__IMPORT_FLAT = 4, GLBK__IMPORT_COLORS = 8,
    GLBK__IMPORT_GLOSS = 16, GLBK__IMPORT_OPEN = 32, GLBK__IMPORT_ENTITIES = 64, GLBK__IMPORT_REVERSED = 128
};

/* Inverts a matrix by elimination with pivots, in double; returns 0 if it has no inverse. */
static int glbk__gbuffer_invert(const float *from, float *to)
{
    double m[4][8], keep;
    int c, r, k, best;

    for (r = 0; r < 4; r++)
        for (c = 0; c < 4; c++) {
            m[r][c] = (double)from[4 * c + r];
            m[r][4 + c] = r == c ? 1 : 0;
        }
    for (c = 0; c < 4; c++) {
        best = c;
        for (r = c + 1; r < 4; r++)
            if (fabs(m[r][c]) > fabs(m[best][c])) best = r;
        if (!(fabs(m[best][c]) > 1e-30)) return 0;
        for (k = 0; k < 8; k++) {
            keep = m[best][k];
            m[best][k] = m[c][k];
            m[c][k] = keep;
        }
        for (k = 7; k >= c; k--) m[c][k] /= m[c][c];
        for (r = 0; r < 4; r++)
            for (k = 7; r != c && k >= c; k--) m[r][k] -= m[r][c] * m[c][k];
    }
    for (r = 0; r < 4; r++)
        for (c = 0; c < 4; c++) to[4 * c + r] = (float)m[r][4 + c];
    return 1;
}

/* Checks that each texture of the user's is not given or is a 2D texture of the right size. */
static glbk_result glbk__gbuffer_check_textures(const glbk_context *ctx, const glbk_gbuffer *g,
                                                const glbk_import *d)
{
    static const char *const names[8] = { "import.depth", "import.positions", "import.normals",
                                          "import.geometric_normals", "import.color_map", "import.gloss_map",
                                          "import.open_map", "import.entities" };
    const glbk_texture *const textures[8] = { d->depth, d->positions, d->normals, d->geometric_normals,
                                              d->color_map, d->gloss_map, d->open_map, d->entities };
    const char *text = NULL;
    int i;
    for (i = 0; i < 8; i++) {
        const glbk_texture *t = textures[i];
        if (!t) continue;
        if (!t->name || t->layers)
            return glbk__gbuffer_bad(ctx, "glbk_gbuffer_import", names[i],
                                     t->name ? "is an array, not 2D" : "has no name of GL");
        if (t->width != g->width) text = "has not the width of the G-buffer";
        else if (t->height != g->height) text = "has not the height of the G-buffer";
        if (text) return glbk__refuse(ctx, GLBK_ERR_MISMATCH, "glbk_gbuffer_import", names[i], text);
    }
    return GLBK_OK;
}

/* Checks that an import can be done. */
static glbk_result glbk__gbuffer_check_import(const glbk_context *ctx, const glbk_gbuffer *g,
                                              const glbk_import *d)
{
    const char *const function = "glbk_gbuffer_import";
    glbk_result result;
    if (!d->normals || (!d->depth && !d->positions))
        return glbk__gbuffer_bad(ctx, function, d->normals ? "import.depth" : "import.normals",
                                 d->normals ? "and import.positions are NULL; one is needed" : "is NULL");
    if (d->depth && !d->positions && glbk__gbuffer_is_zero(d->world_to_clip, 16))
        return glbk__gbuffer_bad(ctx, function, "import.world_to_clip",
                                 "is needed for places by their depths");
    result = glbk__gbuffer_check_textures(ctx, g, d);
    if (result != GLBK_OK) return result;
    return glbk__gbuffer_within(ctx, function, "import.clip_depth", d->clip_depth, 0,
                                GLBK_CLIP_DEPTH_COUNT - 1) &&
                   glbk__gbuffer_within(ctx, function, "import.normal_packing", d->normal_packing, 0,
                                        GLBK_NORMAL_PACKING_COUNT - 1) &&
                   glbk__gbuffer_material_valid(ctx, function, &d->material, d->plane, d->occlusion)
               ? GLBK_OK
               : GLBK_ERR_DESC;
}

/* Writes world to clip space in OpenGL's convention, with depths -1..1. */
static void glbk__gbuffer_clip(const glbk_import *d, float clip[16])
{
    const int reversed = d->clip_depth == GLBK_CLIP_DEPTH_REVERSED;
    int c;
    memcpy(clip, d->world_to_clip, sizeof d->world_to_clip);
    if (!reversed && d->clip_depth != GLBK_CLIP_DEPTH_ZERO_TO_ONE) return;
    for (c = 0; c < 4; c++)
        clip[4 * c + 2] =
            reversed ? clip[4 * c + 3] - 2 * clip[4 * c + 2] : 2 * clip[4 * c + 2] - clip[4 * c + 3];
}

/* Returns which textures there are, as bits. */
static uint32_t glbk__gbuffer_given(const glbk_import *d)
{
    uint32_t bits = 0;
    if (d->positions) bits |= GLBK__IMPORT_PLACES;
    if (d->depth) bits |= GLBK__IMPORT_DEPTH;
    if (d->geometric_normals) bits |= GLBK__IMPORT_FLAT;
    if (d->color_map) bits |= GLBK__IMPORT_COLORS;
    if (d->gloss_map) bits |= GLBK__IMPORT_GLOSS;
    if (d->open_map) bits |= GLBK__IMPORT_OPEN;
    if (d->entities) bits |= GLBK__IMPORT_ENTITIES;
    if (d->clip_depth == GLBK_CLIP_DEPTH_REVERSED) bits |= GLBK__IMPORT_REVERSED;
    return bits;
}

/* Fills the block of an import, all but from_clip. */
static void glbk__gbuffer_fill_import(const glbk_gbuffer *g, const glbk_import *d, glbk_gbuffer_imported *out)
{
    const int full_range =
        d->clip_depth != GLBK_CLIP_DEPTH_REVERSED && d->clip_depth != GLBK_CLIP_DEPTH_ZERO_TO_ONE;

    glbk__gbuffer_clip(d, out->to_clip);
    memcpy(out->to_world, glbk_gbuf__m4_or_identity(d->to_world), sizeof out->to_world);
    out->kind = glbk__gbuffer_kind(&d->material);
    out->entity = d->entity;
    out->plane = d->plane;
    out->occlusion = d->occlusion;
    out->first_lobe = d->first_lobe;
    out->lobe_count = d->material.lobe_count;
    out->given = glbk__gbuffer_given(d);
    out->normal_packing = (uint32_t)d->normal_packing;
    out->width = g->width;
    out->height = g->height;
    memcpy(out->diffuse, d->material.diffuse, sizeof d->material.diffuse);
    glbk__gbuffer_gloss(&d->material, out->gloss);
    memcpy(out->eye, d->eye, sizeof d->eye);
    out->depth_scale = full_range ? 2.0f : 1.0f;
    out->depth_offset = full_range ? -1.0f : 0.0f;
}

/* Binds a texture of the user's, whose glbk_texture need not have gl_target; NULL binds none. */
static void glbk__gbuffer_bind_in(glbk_context *ctx, uint32_t slot, const glbk_texture *texture)
{
    glbk_texture t;
    memset(&t, 0, sizeof t);
    if (texture) t = *texture;
    t.gl_target = GLBK_GL_TEXTURE_2D;
    glbk_bind_texture(ctx, slot, &t);
}

static void glbk__gbuffer_bind_import(glbk_context *ctx, const glbk_import *d)
{
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_color_map, d->color_map);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_gloss_map, d->gloss_map);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_place_in, d->positions);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_depth_in, d->depth);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_normal_in, d->normals);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_flat_in, d->geometric_normals);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_open_in, d->open_map);
    glbk__gbuffer_bind_in(ctx, GLBK_SLOT_glbk_gbuffer_entity_in, d->entities);
}

GLBK_DEF glbk_result glbk_gbuffer_import(glbk_context *ctx, glbk_gbuffer *g, const glbk_import *d)
{
    glbk_gbuffer_imported block;
    glbk_result result = glbk__require_created(ctx, __func__, "gbuffer", g ? &g->target.name : NULL);
    int own;

    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "import", d);
    if (result == GLBK_OK) result = glbk__gbuffer_check_import(ctx, g, d);
    if (result != GLBK_OK) return result;
    own = g->own_depth;
    memset(&block, 0, sizeof block);
    g->has_clip = !glbk__gbuffer_is_zero(d->world_to_clip, 16);
    if (g->has_clip && !glbk__gbuffer_invert(d->world_to_clip, block.from_clip))
        return glbk__gbuffer_bad(ctx, __func__, "import.world_to_clip", "has no inverse");
    glbk__gbuffer_fill_import(g, d, &block);
    if (!g->import_program.name)
        result = glbk__program_create(ctx, glbk_gbuffer_part(), "gbuffer_import.frag",
                                     own ? "GBUFFER_DEPTH=1" : "GBUFFER_DEPTH=0", &g->import_program);
    if (result == GLBK_OK)
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_gbuffer_imported, &g->imported, &block);
    if (result == GLBK_OK)
        result = glbk__gbuffer_start(ctx, own ? &g->target : &g->colors,
                                     own ? GLBK_DEPTH_LESS : GLBK_DEPTH_OFF, &g->import_program);
    if (result != GLBK_OK) return result;
    glbk__gbuffer_bind_import(ctx, d);
    glbk_draw_screen(ctx);
    memcpy(g->world_to_clip, block.to_clip, sizeof g->world_to_clip);
    memcpy(g->eye, d->eye, sizeof g->eye);
    g->has_depth = own ? d->depth || g->has_clip : d->depth && d->depth->name == g->depth.name &&
                                                       d->clip_depth != GLBK_CLIP_DEPTH_REVERSED;
    return GLBK_OK;
}

/* ==== src/gl_gbuffer/pictures.h ==== */

/* ---- gbuffer: pictures of the techniques ---- */

/* Finds where a resolve draws its picture: the corner of the viewport. See glbk_picture. */
static glbk_result glbk__gbuffer_corner(const glbk_context *ctx, const char *function,
                                        const glbk_pass *pass, uint32_t width, uint32_t height,
                                        glbk_shown *shown)
{
    const int32_t *v = pass->viewport;
    const int whole = pass->target && !v[2] && !v[3];
    const uint32_t wide = whole ? pass->target->width : (uint32_t)v[2];
    const uint32_t high = whole ? pass->target->height : (uint32_t)v[3];

    shown->left = whole ? 0u : (uint32_t)v[0];
    shown->bottom = whole ? 0u : (uint32_t)v[1];
    if (wide <= width && high <= height) return GLBK_OK;
    if (wide > width)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "the width that pass draws to", wide, 0,
                                  width);
    return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "the height that pass draws to", high, 0, height);
}

GLBK__DEF glbk_result glbk__begin_picture(glbk_context *ctx, const char *function, const glbk_pass *pass,
                                          const glbk_picture *picture, uint32_t width, uint32_t height,
                                          glbk_program *program)
{
    glbk_shown shown;
    glbk_buffer buffer;
    glbk_result result;
    memset(&shown, 0, sizeof shown);
    result = pass->target ? GLBK_OK : glbk__check_bound(ctx, function);
    if (result == GLBK_OK) result = glbk__gbuffer_corner(ctx, function, pass, width, height, &shown);
    if (result == GLBK_OK) result = glbk_begin(ctx, pass, program);
    if (result != GLBK_OK) return result;
    shown.keep_empty = picture && picture->keep_empty;
    shown.has_depth = picture && picture->world_to_clip;
    if (shown.has_depth) memcpy(shown.to_clip, picture->world_to_clip, sizeof shown.to_clip);
    buffer.name = ctx->shown;
    buffer.bytes = sizeof shown;
    return glbk__put_block(ctx, GLBK_SLOT_glbk_shown, &buffer, &shown);
}

/* ==== src/gl_gbuffer/end.h ==== */

#endif /* GL_GBUFFER_IMPLEMENTATION */

/*
Dapple is available under either of the two licences below, at your choice:
MIT-0 OR Unlicense.

------------------------------------------------------------------------------
MIT No Attribution

Copyright 2026 The Dapple authors

Permission is hereby granted, free of charge, to any person obtaining a copy
of this software and associated documentation files (the "Software"), to deal
in the Software without restriction, including without limitation the rights
to use, copy, modify, merge, publish, distribute, sublicense, and/or sell
copies of the Software, and to permit persons to whom the Software is
furnished to do so.

THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR
IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY,
FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE
AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER
LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM,
OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE
SOFTWARE.

------------------------------------------------------------------------------
The Unlicense

This is free and unencumbered software released into the public domain.

Anyone is free to copy, modify, publish, use, compile, sell, or distribute
this software, either in source code form or as a compiled binary, for any
purpose, commercial or non-commercial, and by any means.

In jurisdictions that recognize copyright laws, the author or authors of this
software dedicate any and all copyright interest in the software to the public
domain. We make this dedication for the benefit of the public at large and to
the detriment of our heirs and successors. We intend this dedication to be an
overt act of relinquishment in perpetuity of all present and future rights to
this software under copyright law.

THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR
IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY,
FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE
AUTHORS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN
ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION
WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE.

For more information, please refer to <https://unlicense.org/>
*/
