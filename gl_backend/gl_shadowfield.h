/* gl_shadowfield.h - v0.9.0 - shadow fields on OpenGL 3.3, ES 3.0, WebGL 2 - MIT-0 OR Unlicense

   What it does

   It brings fields of shadowfield.h onto the GPU: shaders of your own call sfield_shade(), a complete pass
   shades a G-buffer, and cubes of new fields are drawn and projected by the GPU.

   What it does not do

   - It needs gl_backend.h beside it, which makes the context object, textures and targets, and whose
     conventions, errors and rules about GL's state hold here; gl_programs.h, which makes programs;
     gl_gbuffer.h, which has what a camera sees; and shadowfield.h above it, whose fields and entities it
     takes and whose functions it calls. The implementations of all of them belong into some file of the
     program.
   - Fields of wavelets are lit by gl_wavelets.h, which stands above this header: scenes here have harmonics.
   - It has no resolve: light is a texture that your lighting pass multiplies by the surface's colour.

   Quick start

       #define SHADOWFIELD_IMPLEMENTATION
       #define GL_BACKEND_IMPLEMENTATION
       #define GL_PROGRAMS_IMPLEMENTATION
       #define GL_GBUFFER_IMPLEMENTATION
       #define GL_SHADOWFIELD_IMPLEMENTATION
       #include "gl_backend/gl_shadowfield.h"
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
           static const char fragment[] =                   // a shader of yours that calls the library
               "out vec4 color;\n"
               "void main()\n"
               "{\n"
               "    vec3 place = vec3(gl_FragCoord.xy, 0.0), up = vec3(0.0, 1.0, 0.0);\n"
               "    float t[SFIELD_COEFS];\n"
               "    sfield_cosine(up, t);\n"
               "    color = vec4(sfield_shade(place, up, 0u, t, t).light, 1.0);\n"
               "}\n";
           glbk_context gl;
           glbk_program program;
           glbk_desc desc;
           glbk_source source;
           glbk_result result;

           memset(&desc, 0, sizeof desc);
           desc.get_proc_fn = get_proc;                     // a context is current
           result = glbk_init(&gl, &desc);
           if (result != GLBK_OK) {
               printf("no GL: %s\n", glbk_result_text(result));
               return result != GLBK_ERR_FUNCTION;
           }
           memset(&source, 0, sizeof source);
           source.parts[0] = glbk_sfield_part();            // the GLSL of this header
           source.uses = "sfield_shade";
           source.defines = "SFIELD_BANDS=4";
           source.fragment = fragment;
           result = glbk_program_compile(&gl, &source, &program);
           printf("%s\n", glbk_result_text(result));
           glbk_program_free(&gl, &program);
           glbk_free(&gl);
           return result != GLBK_OK;
       }

   The whole frame, with a window: examples/09_shadowfield_gl_minimal.c; as complete passes, with own
   visibility: examples/09b_shadowfield_gl_passes.c.

   A frame

       glbk_sfield_scene_entities(gl, &scene, entities, count);     // or _scene_sky: where all is
       glbk_gbuffer_begin(gl, &gbuffer, world_to_clip, eye);        // or _import, or _upload
       glbk_gbuffer_object(gl, &gbuffer, &surface);                 // for each object, with your draw
       glbk_sfield_shade(gl, &renderer, &gbuffer, &scene, eye, 0);

   renderer.light then holds the light at each pixel without the surface's colour. No function resolves the
   light to a picture, as those of other techniques do, since how light meets colour is your lighting pass's
   matter: albedo times light.rgb, and specular colour times gloss.rgb. With desc.materials metal-rough pixels
   send base (1 - metallic) light.rgb + gloss.rgb to the eye.

   In shaders of your own

   Two functions of lib/sfield_shade.glsl can be called after glbk_sfield_bind, with SFIELD_BANDS defined:

       void sfield_cosine(vec3 n, out float t[SFIELD_COEFS]);
       sfield_sums sfield_shade(vec3 position, vec3 normal, uint own, float t[SFIELD_COEFS],
                                float g[SFIELD_COEFS]);

       position, normal   world space; the normal is unit
       own                the entity that the point lies on, counted from 1; 0 = none
       t                  from sfield_cosine, or self-visibility x cosine, turned into the world
       g                  t times Phong's lobe, which is read if SFIELD_GLOSS is defined as 1 or 2

   With SFIELD_GLOSS=2 a third function of direction, h, follows g, and the result's grazing is of h: so the
   three kernels of the metal-rough BRDF find their light in one call (lib/sfield_point.glsl). sfield_kernel
   of lib/sfield_brdf.glsl makes them from the scene's table of BRDFs.

   The result has light, which times albedo is radiance, as in renderer.light and sfield_points.rgb; gloss;
   and open, the share of the cosine-weighted sky that nothing hides.

   Conventions

   The fields of a scene are uploaded once, into one table, with the terms of the product; entities and the
   sky stand in another one, so that moving them leaves the fields alone. Fields, entities and self-visibility
   are shadowfield.h's, and so are the numbers of entities: they count from 1, 0 is none. The points that are
   shaded are the pixels of a G-buffer (gl_gbuffer.h): of the screen, or vertices.

   A vector that is said to be unit may have a length of 0.97 to 1.03 and is used as it is, so interpolated
   normals must be normalised before they come.

   From the paper to the code

   The paper is that of shadowfield.h: Zhou, Hu, Lin, Guo and Shum, "Precomputed Shadow Fields for Dynamic
   Scenes", SIGGRAPH 2005. A line has the function in GLSL or the call, its twin in shadowfield.h, and the
   rows of docs/conformance.md that test both.

     section 3.1  an object occlusion field       glbk_sfield_builder_see  sfield_build           T72
     section 3.1  a source radiance field         glbk_sfield_builder_see  sfield_build_emissive  T73
     section 3.1  S_d, the environment            sfield_sky               sfield_scene_sky       -
     section 3.1  O_p, self-visibility            glbk_sfield_self_object   sfield_build_self      -
     section 3.3  eight samples of shells         sfield_locate            sfield_query           T74 T75
     section 3.3  16 coefficients of 8 bits       sfield_fetch             sfield_query           T74
     section 4    B, the rendering equation       glbk_sfield_shade        sfield_shade           T73
     section 4.1  triple products                 sfield_product           sfield_sh_product      T5 T6
     section 4.1  the double product              sfield_dot               sfield_sh_dot          -
     section 4.1  the BRDF at the beginning       sfield_kernel            sfield_sh_brdf         -
     section 4.1  rotations                       sfield_rotate            sfield_sh_rotate       T9 T76
     section 4.1  the basis, the cosine           sfield_basis             sfield_sh_basis        T3 T10
     figure 5     entities from near to far       sfield_shade             sfield_shade           T78
     section 4.2  culling                         sfield_occlusion         sfield_scene_stats     -

   Configuration

     GL_SHADOWFIELD_IMPLEMENTATION   in one source file: compiles the code; other files may have those of
                                     gl_backend.h, gl_programs.h, gl_gbuffer.h and shadowfield.h

   Layouts: docs/gpu-layouts.md. The technique: docs/shadowfield.md. State: docs/gl-state.md.
   Licence: end of file. */
/* These stand outside the guard, because a second inclusion of this file may ask for their implementations.
   shadowfield.h lies above this folder. */
#include "gl_gbuffer.h"
#include "../shadowfield.h"

#ifndef GL_SHADOWFIELD_H
#define GL_SHADOWFIELD_H

#if GLBK_VERSION != 900
#error "gl_shadowfield.h and gl_backend.h are of different versions"
#endif
#if defined(GLBK_STATIC) && !defined(GL_SHADOWFIELD_IMPLEMENTATION)
#error "GLBK_STATIC makes all functions private: GL_SHADOWFIELD_IMPLEMENTATION belongs into the same file"
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ==== src/gl_shadowfield/api_page_one.h ==== */

/* ---- page one: a scene of fields that lights the pixels of a G-buffer ---- */

typedef struct glbk_sfield_scene glbk_sfield_scene;         /* fields, entities: see "objects" below */
typedef struct glbk_sfield_renderer glbk_sfield_renderer;   /* the light of a picture: see there, too */
struct glbk_sfield_scene_desc;      /* which fields, how many entities: below */
struct glbk_sfield_renderer_desc;   /* how large the picture is: below */

GLBK_DEF glbk_result glbk_sfield_scene_create(glbk_context *ctx, const struct glbk_sfield_scene_desc *desc,
                                              glbk_sfield_scene *out);
/* Uploads fields, and makes room for entities. The scene is empty and its sky is black at first.
   Memory   on the GPU the fields, their coefficients filled up to a multiple of 16, and with desc.brdf 332 KB
            for 4 bands, 1 MB for 8; here 40 bytes a field and, while the call runs, the longest file of a
            field (sfield_bytes) and 16 KB
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: a field is out of range. GLBK_ERR_MISMATCH:
            a field of wavelets, self-visibility or other bands, a shard, or some occlusion fields of
            logarithms and some of others. GLBK_ERR_LIMIT: more than 2^28 texels. GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_sfield_scene_entities(glbk_context *ctx, glbk_sfield_scene *scene,
                                                const sfield_entity *entities, size_t count);
/* Says where all entities are now, as sfield_scene_entities does; entity 1 is entities[0]. Call it whenever
   one of them has moved or changed: the call uploads all of them, 112 bytes each and their rotations.
   count    0 .. scene->entity_capacity
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the scene was not created. GLBK_ERR_LIMIT: count is above
            entity_capacity. GLBK_ERR_INPUT: a transform, tint or time cannot be used. GLBK_ERR_MISMATCH: a
            field was not uploaded, or is of the other kind. The scene is as it was then. GLBK_ERR_ALLOC and
            GLBK_ERR_LOST: some entities may have moved */

GLBK_DEF glbk_result glbk_sfield_scene_sky(glbk_context *ctx, glbk_sfield_scene *scene, const float *coefs);
/* Sets the environment and its suns.
   coefs    3 bands^2 numbers from sfield_scene_sky; NULL = no sky
   Errors   GLBK_ERR_ARGUMENT: scene is NULL or was not created. GLBK_ERR_MISMATCH: it has wavelets */

GLBK_DEF glbk_result glbk_sfield_renderer_create(glbk_context *ctx,
                                                 const struct glbk_sfield_renderer_desc *desc,
                                                 glbk_sfield_renderer *out);
/* Compiles the program that shades and makes its textures.
   Memory   on the GPU 16 bytes a pixel, 16 more with gloss or materials, 16 more with grazing, and what
            desc.self takes
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: a field is out of range, algebra is NULL, or
            grazing is wanted without materials. GLBK_ERR_LIMIT: width or height is above ctx->max_side.
            GLBK_ERR_ALLOC. Those of textures, targets and glbk_program_compile */

GLBK_DEF glbk_result glbk_sfield_shade(glbk_context *ctx, glbk_sfield_renderer *renderer,
                                       const glbk_gbuffer *gbuffer, const glbk_sfield_scene *scene,
                                       const float eye[3], int open);
/* Shades all pixels into renderer->light and gloss. Light is not clamped: ringing may take it below 0. The
   compute path finds entities for blocks of 8 x 8 pixels, so points near each other belong in one block.
   eye      world, for lobes; NULL = that of the G-buffer, which knows it if it was drawn or imported
   open     not 0: light.a is wanted even if there is no sky
   Errors   GLBK_ERR_ARGUMENT: an object is NULL or was not created, or the renderer shades lobes and no eye
            is known. GLBK_ERR_MISMATCH: the scene has wavelets, other bands, no BRDFs for desc.materials, or
            logarithms without desc.logarithms or none with it, or the G-buffer has another size.
            GLBK_ERR_LOST */

GLBK_DEF void glbk_sfield_scene_free(glbk_context *ctx, glbk_sfield_scene *scene);
/* Deletes the scene's objects of GL, frees its memory and zeroes the struct; the fields are yours. Accepts
   NULL. */

GLBK_DEF void glbk_sfield_renderer_free(glbk_context *ctx, glbk_sfield_renderer *renderer);
/* Deletes the renderer's objects of GL and zeroes the struct. Accepts NULL. */

/* ---- structs of page one ---- */

typedef struct glbk_sfield_scene_desc {
    const sfield_algebra      *algebra; /* of the fields' bands; the scene turns entities by it, so it must
                                           outlive the scene */
    const sfield_field *const *fields;  /* occlusion and source fields of harmonics, all of as many bands.
                                           Entities name them by these pointers, so they must outlive the
                                           scene */
    size_t   field_count;
    uint32_t entity_capacity;           /* the most entities, 1..65535 */
    float    reach;                     /* as in sfield_scene_desc: occluders count up to this many of their
                                           radii, to 1e6; 0 = to the outermost shell of each */
    const float *brdf;                  /* for renderers with desc.materials: what sfield_sh_brdf wrote for
                                           the bands of algebra, read until glbk_sfield_scene_create returns.
                                           NULL = no BRDFs */
} glbk_sfield_scene_desc;

typedef struct glbk_sfield_renderer_desc {
    uint32_t width;                     /* pixels, 1 .. ctx->max_side, like height */
    uint32_t height;
    const sfield_algebra *algebra;      /* required: of the scene's bands; it is read until
                                           glbk_sfield_renderer_create returns */
    int      gloss;                     /* not 0: lobes of the G-buffer's Phong materials are shaded, too */
    int      self;                      /* not 0: there is room for self-visibility, 32 bytes a pixel; for 5
                                           to 8 bands 64 to 128 */
    uint32_t self_attribute;            /* location of a mesh's first four coefficients of self-visibility;
                                           the next locations have the other coefficients; 1..12, 0 = 4 */
    int      product_in_table;          /* not 0: shaders read the terms of the product from the table, as
                                           from 5 bands on anyway. 0: they are written into the program, which
                                           takes longer to compile and runs several times as fast */
    int      materials;                 /* not 0: gloss is shaded by Phong's lobe and by glTF's metal-rough
                                           BRDF, as each pixel's material says; the scene has desc.brdf */
    int      grazing;                   /* not 0: renderer->grazing is wanted, too; only with materials */
    int      logarithms;                /* not 0: for scenes whose occlusion fields hold logarithms
                                           (sfield_desc.logarithm), as SFIELD_PRODUCT_EXP */
} glbk_sfield_renderer_desc;

/* ==== src/gl_shadowfield/api.h ==== */

/* ---- the light of a picture ---- */

GLBK_DEF glbk_result glbk_sfield_renderer_resize(glbk_context *ctx, glbk_sfield_renderer *renderer,
                                                 uint32_t width, uint32_t height);
/* Gives the renderer another size, without what it had drawn; self-visibility is forgotten, too. Its programs
   stay, whereas a new renderer would compile them anew; so call it when a window has changed its size, with
   glbk_gbuffer_resize.
   Errors   GLBK_ERR_ARGUMENT: the renderer is NULL or was not created. GLBK_ERR_DESC, GLBK_ERR_LIMIT: as for
            glbk_sfield_renderer_create. After these it is as it was, after those of textures and targets
            it is freed and zeroed */

GLBK_DEF glbk_result glbk_sfield_read(glbk_context *ctx, glbk_sfield_renderer *renderer, float *light,
                                      float *gloss);
/* Waits for the GPU and reads the light of all pixels, as the textures hold it, rows from the bottom up.
   light, gloss   receive 4 floats a pixel each; NULL = not wanted
   Errors         GLBK_ERR_ARGUMENT: renderer is NULL or was not created. GLBK_ERR_MISMATCH: gloss is asked of
                  a renderer without it. Those of glbk_target_read */

/* ---- shaders of your own ---- */

GLBK_DEF const glbk_part *glbk_sfield_part(void);
/* Returns the GLSL of this header, for programs of your own that use its library files: see
   glbk_source.parts. */

GLBK_DEF void glbk_sfield_bind(glbk_context *ctx, const glbk_sfield_scene *scene, const glbk_offset *offset);
/* Binds the scene for a program of yours that uses lib/sfield_shade.glsl and is bound (glbk_begin). The
   program is compiled with SFIELD_BANDS=n, n being scene->bands.
   offset   the offset that glbk_source.offsets gives this part in the program; NULL = none */

GLBK_DEF size_t glbk_sfield_write_product(const sfield_algebra *algebra, char *out, size_t out_bytes);
/* Writes the GLSL function sfield_product with its numbers in the text, which runs several times as fast as
   the function that reads them from the table. The text is for a program that defines SFIELD_UNROLLED, and
   goes after lib/sfield_access.glsl and lib/sfield_field.glsl and before lib/sfield_shade.glsl. The call
   needs no context and has no log.
   out      receives the text, cut to out_bytes and ended by 0; it may be NULL with out_bytes 0
   Returns the bytes needed with the 0, or 0 without an algebra and for more than 4 bands, which do not gain
   by it. */

/* ---- self-visibility: what a point's own object leaves open ----

   Fields say what other objects hide of a point; what its own object hides is recorded for the vertices of
   its mesh, by sfield_build_self, as visibility x cosine. A renderer with desc.self has room for
   self-visibility, and keeps it from frame to frame until it is given anew; pixels without it take the
   cosine. Self-visibility is in the space of the entity that the G-buffer names there, and turns with the
   entity. After the draws into the G-buffer come these calls:

       glbk_sfield_self_begin(gl, &renderer, &gbuffer);
       glbk_sfield_self_object(gl, &renderer, surface.transform);   // for each object, and your draw */

GLBK_DEF glbk_result glbk_sfield_self_begin(glbk_context *ctx, glbk_sfield_renderer *renderer,
                                            const glbk_gbuffer *gbuffer);
/* Forgets self-visibility at all pixels and begins a pass that draws it anew, at the places that were drawn
   into the G-buffer, whose depth and matrix the pass uses. The first call compiles a program.
   Errors   GLBK_ERR_ARGUMENT: an object is NULL or was not created. GLBK_ERR_ORDER: the G-buffer was not
            drawn. GLBK_ERR_LIMIT: more than 4 bands. GLBK_ERR_MISMATCH: the renderer was made without
            desc.self, the G-buffer has another size, or its position attribute is one of the four from
            desc.self_attribute on. Those of glbk_program_compile */

GLBK_DEF glbk_result glbk_sfield_self_object(glbk_context *ctx, glbk_sfield_renderer *renderer,
                                             const float transform[16]);
/* Says which object the next draws are of: bind its vertex array and draw. The array has the position in the
   attribute of the G-buffer, and four coefficients each in the attributes from desc.self_attribute on.
   transform   that of its glbk_surface, so that depths are equal; zeros = identity
   Errors      GLBK_ERR_ARGUMENT: a pointer is NULL, or renderer was not created. GLBK_ERR_MISMATCH: the
               renderer has no desc.self. GLBK_ERR_ORDER: glbk_sfield_self_begin has not been called */

GLBK_DEF glbk_result glbk_sfield_self_upload(glbk_context *ctx, glbk_sfield_renderer *renderer, uint32_t row,
                                             uint32_t row_count, const float *const *self);
/* Writes self-visibility of whole rows of pixels from memory, for a G-buffer that was uploaded. Coefficients
   are kept with 16 bits, off by 5e-5.
   self     renderer->width x row_count pointers: bands^2 coefficients from sfield_self, mixed as you like, or
            NULL where nothing is known
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, renderer was not created, or rows reach beyond height.
            GLBK_ERR_MISMATCH: the renderer has no desc.self. GLBK_ERR_ALLOC */

/* ---- objects: read only ---- */

typedef struct glbk_sfield_field {      /* a field in the table; read only */
    const sfield_field *field;
    uint32_t start;                     /* its first texel, for sfield_locate() and sfield_fetch() */
    int      source;                    /* 0: an occlusion field; 1: a source; 2: self-visibility */
    float    center[3];                 /* in the field's own space */
    float    radius;
    float    inscribed;                 /* radius of the inscribed sphere */
    float    outer;                     /* the outermost shell, in radii */
} glbk_sfield_field;

struct glbk_sfield_scene {              /* fields and where they stand; read only; zeroed = none */
    glbk_texture table;                 /* terms and fields */
    glbk_texture moving;                /* the sky, entities, rotations */
    glbk_buffer  contents;              /* the uniform block */
    uint32_t     bands;                 /* of harmonics */
    uint32_t     cube_side;             /* of wavelets; 0: the fields are of harmonics */
    uint32_t     entity_capacity;
    uint32_t     entity_count;
    uint32_t     light_count;           /* entities that shine */
    glbk_sfield_field *fields;          /* in the order of their pointers */
    size_t       field_count;
    uint32_t     terms;                 /* private, like all that follows: texels of the terms */
    uint32_t     texels;                /* texels of the table */
    uint32_t     entities_at;           /* the texel of moving at which entities begin */
    int          sky;                   /* not 0: there is a sky */
    int          has_brdf;              /* not 0: BRDFs come after the terms */
    int          logarithms;            /* not 0: occlusion fields hold logarithms */
    int          lists;                 /* of wavelets: not 0: fields are lists, for compute shaders */
    float        reach;
    uint64_t     key;                   /* of wavelets: which fields begin where */
    const sfield_algebra *algebra;
};

struct glbk_sfield_renderer {           /* the light of a picture; read only; zeroed = none */
    glbk_texture light;                 /* GLBK_FORMAT_COLOR: rgb times albedo is radiance; a is the open
                                           share of the cosine-weighted sphere */
    glbk_texture gloss;                 /* Phong: rgb times the specular colour is radiance; metal-rough: rgb
                                           is radiance, and light's rgb has its factor 1 - F. Made if
                                           desc.gloss or desc.materials is set */
    glbk_texture grazing;               /* metal-rough: the part of gloss that F0 does not color, as
                                           sfield_points.grazing; none without desc.grazing */
    glbk_texture self;                  /* self-visibility; none without desc.self */
    glbk_target  target;                /* of light, gloss and grazing */
    glbk_target  self_target;           /* private, like all that follows but width, height and compute */
    glbk_program shade;
    glbk_program record;
    glbk_buffer  frame;
    glbk_buffer  object;
    uint32_t     width;
    uint32_t     height;
    uint32_t     bands;
    uint32_t     self_attribute;
    int          materials;
    int          logarithms;
    int          compute;               /* not 0: pixels are shaded by a compute shader */
    int32_t      record_position;       /* the attribute that record was compiled for */
    const char  *record_vertex;         /* the function of yours that it was compiled with */
    float        world_to_clip[16];     /* the matrix of glbk_sfield_self_begin */
};

/* ==== src/gl_shadowfield/api_building.h ==== */

/* ---- building on the GPU ----

   A builder draws the object as seen from the sample points of a field, up to 256 faces of cubes at a time in
   one atlas, counts samples into texels and projects these on harmonics. shadowfield.h asks for the samples
   and makes the field:

       int see(void *user, const sfield_views *views)
       {
           return glbk_sfield_builder_see(gl, &builder, views) != GLBK_OK;
       }
       ... sfield_build_views(&desc, 0, &mesh, see, NULL, &field, NULL); */

typedef void (*glbk_sfield_draw_fn)(void *user, glbk_context *ctx, int32_t instances);
/* Draws so many instances of your object, which lies within the field's sphere. The function binds a vertex
   array with the position in the field's space and, for sources, the radiance of the triangle. It must change
   neither program nor state. */

typedef struct glbk_sfield_builder glbk_sfield_builder; /* see below */

typedef struct glbk_sfield_builder_desc {
    const sfield_desc  *field;      /* the desc that sfield_build_views gets: its basis, bands and cube_side
                                       tell the projection. NULL = all defaults */
    const sfield_mesh  *mesh;       /* the object in the field's space, without a mask; NULL = draw_fn draws
                                       the object */
    int                 source;     /* not 0: radiance is built, else alpha */
    const float        *radiance;   /* sources: r, g, b of each triangle of mesh, 0..1e18, which is one frame;
                                       draw_fn draws others */
    glbk_sfield_draw_fn draw_fn;    /* used without a mesh */
    void               *user;       /* given to draw_fn */
    glbk_attributes     attributes; /* of what draw_fn draws: position counts, all zero = 0 */
    uint32_t            radiance_attribute; /* location of its radiance, 1..15; 0 = 1 */
} glbk_sfield_builder_desc;         /* keep all of it until glbk_sfield_builder_create returns */

GLBK_DEF glbk_result glbk_sfield_builder_create(glbk_context *ctx, const glbk_sfield_builder_desc *desc,
                                                glbk_sfield_builder *out);
/* Makes a builder for one object.
   Memory   on the GPU 4 MB (sources 20), cubes of a batch, the mesh, and bands^2 x 24 side^2 bytes; here the
            numbers that are read back of a batch, and while the call runs the mesh or the basis
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, a pointer, count or stride of the mesh is out of range, or
            the mesh has a mask.
            GLBK_ERR_DESC: a field is out of range. GLBK_ERR_INPUT: an index of the mesh or radiance is out of
            range, or no triangle can be used. GLBK_ERR_LIMIT: the mesh is too large. GLBK_ERR_ALLOC. Those of
            textures and glbk_program_compile */

GLBK_DEF glbk_result glbk_sfield_builder_see(glbk_context *ctx, glbk_sfield_builder *builder,
                                             const sfield_views *views);
/* Draws the faces of cubes round all eyes of views, writes views->values and waits for the GPU. Samples are
   those of sfield_build: 64 to 512 a side of a face (sources 256), by distance. No float targets are needed.
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, the builder was not created, or views->count is 0.
            GLBK_ERR_INPUT: views are not finite. Those of glbk_begin and of reading, after which values may
            be half written */

GLBK_DEF void glbk_sfield_builder_free(glbk_context *ctx, glbk_sfield_builder *builder);
/* Deletes the builder's objects of GL, frees its memory and zeroes the struct. Accepts NULL. */

struct glbk_sfield_builder {            /* draws one object from all sides; read only; zeroed = none */
    uint32_t      batch;                /* the most eyes of which cubes are kept at once */
    uint32_t      side;                 /* private, like all that follows: texels a side of a face */
    uint32_t      bands;                /* of the coefficients; 0 = texels are wanted */
    uint32_t      groups;               /* groups of four coefficients */
    uint32_t      height;               /* pixels of the atlas */
    int           source;               /* as in the desc, like the next two */
    glbk_sfield_draw_fn draw_fn;
    void         *user;
    float         center[3];            /* of the sphere round your mesh */
    float         radius;               /* of that sphere */
    uint32_t      vertex_array;
    uint32_t      index_count;
    glbk_buffer   vertices;
    glbk_buffer   indices;
    glbk_buffer   block;
    glbk_texture  seen;                 /* the atlas */
    glbk_texture  depth;
    glbk_texture  cube;
    glbk_texture  coefs;
    glbk_texture  basis;                /* integrals of the basis over texels */
    glbk_target   seen_target;
    glbk_target   cube_target;
    glbk_target   coef_target;
    glbk_program  see;
    glbk_program  sum;
    glbk_program  project;
    struct glbk_sfield_views *views;    /* the block's values */
    uint32_t     *words;                /* texels that were read back */
    int           compute;
};

/* ==== src/gl_shadowfield/bindings.h ==== */

/* ---- what the GLSL declares; see "bindings" in gl_programs.h ---- */

/* Programs that shade read the two tables, and self-visibility of a picture. */
#define GLBK_SFIELD_SCENE_TEXTURES(X)                                                       \
    X(usampler2DArray, glbk_sfield_table, 0)        /* terms of the product, fields */      \
    X(usampler2DArray, glbk_sfield_moving, 7)       /* sky, entities, rotations */          \
    X(usampler2DArray, glbk_sfield_self, 3)         /* self-visibility of a picture */

/* Programs that build read samples of tiles, texels of cubes, and integrals of the basis over texels. */
#define GLBK_SFIELD_BUILD_TEXTURES(X)                                                       \
    X(usampler2D, glbk_sfield_seen, 4)              /* samples of tiles */                  \
    X(usampler2D, glbk_sfield_cube, 5)              /* texels of cubes */                   \
    X(usampler2DArray, glbk_sfield_basis, 6)        /* integrals over texels */

#define GLBK_SFIELD_TEXTURES(X)                                                             \
    GLBK_SFIELD_SCENE_TEXTURES(X)                                                           \
    GLBK_SFIELD_BUILD_TEXTURES(X)

/* This block says what the tables hold. */
#define GLBK_SFIELD_CONTENTS_MEMBERS(X)                                                     \
    X(uint, entity_texel, 1)        /* where entities begin in glbk_sfield_moving */        \
    X(uint, entity_count, 1)        /* entities in use */                                   \
    X(uint, light_count, 1)         /* entities that shine */                               \
    X(uint, wants_sky, 1)           /* not 0: the sky, or the open share, is wanted */      \
    X(uint, term_texel, 1)          /* where terms begin in glbk_sfield_table */            \
    X(uint, term_count, 1)          /* texels of terms, two terms each */                   \
    X(uint, sky_texel, 1)           /* where the sky begins in glbk_sfield_moving */        \
    X(uint, brdf_texel, 1)          /* where kernels of BRDFs begin in glbk_sfield_table */

#define GLBK_SFIELD_FRAME_MEMBERS(X) X(vec4, eye, 1)        /* world; w is not used */

/* This block has an object whose self-visibility is drawn. */
#define GLBK_SFIELD_OBJECT_MEMBERS(X)                                                       \
    X(mat4, transform, 1)           /* object to world */                                   \
    X(mat4, clip, 1)                /* world to clip space */

#ifndef GLBK_SFIELD_WITHOUT_BUILD
/* This block has the tiles of an atlas, each of which is a face of an eye's cube. */
#define GLBK_SFIELD_VIEWS_MEMBERS(X)                                                        \
    X(vec4, sphere, 1)              /* of the field: centre, radius */                      \
    X(uint, first_tile, 1)          /* the first tile of the column that is drawn */        \
    X(uint, rows, 1)                /* tiles of a column */                                 \
    X(uint, width, 1)               /* samples a side of a tile */                          \
    X(uint, side, 1)                /* texels a side of a face */                           \
    X(uint, batch, 1)               /* eyes */                                              \
    X(uint, groups, 1)              /* of four coefficients */                              \
    X(uint, unused0, 1)                                                                     \
    X(uint, unused1, 1)                                                                     \
    GLBK_SFIELD_TILE_MEMBERS(X)

#define GLBK_SFIELD_TILE_MEMBERS(X)                                                         \
    X(vec4, eyes, 256)              /* places in radii about the centre; 1 / greatest depth */ \
    X(uvec4, places, 256)           /* face, number of the eye; column, row of the atlas */

#define GLBK_SFIELD_BUILD_BLOCKS(X) X(glbk_sfield_views, 3, GLBK_SFIELD_VIEWS_MEMBERS)
#else
#define GLBK_SFIELD_BUILD_BLOCKS(X)
#endif

#define GLBK_SFIELD_BLOCKS(X)                                                               \
    X(glbk_sfield_contents, 0, GLBK_SFIELD_CONTENTS_MEMBERS)                                \
    X(glbk_sfield_frame, 1, GLBK_SFIELD_FRAME_MEMBERS)                                      \
    X(glbk_sfield_object, 2, GLBK_SFIELD_OBJECT_MEMBERS)                                    \
    GLBK_SFIELD_BUILD_BLOCKS(X)

#define GLBK_SFIELD_STORAGE(X)

/* Compute shaders write a picture's light, gloss and grazing, and cubes and coefficients of a builder. */
#define GLBK_SFIELD_IMAGES(X)                                                               \
    X(writeonly, rgba32f, image2D, glbk_sfield_light_image, 0)                              \
    X(writeonly, rgba32f, image2D, glbk_sfield_gloss_image, 1)                              \
    X(writeonly, rgba32ui, uimage2D, glbk_sfield_cube_image, 2)                             \
    X(writeonly, rgba32ui, uimage2D, glbk_sfield_coefs_image, 3)                            \
    X(writeonly, rgba32f, image2D, glbk_sfield_grazing_image, 4)

GLBK__PART(SFIELD)

/* ==== src/gl_shadowfield/inside.h ==== */

/* ---- for gl_wavelets.h: not for you, may change without notice ----

   Its implementation may stand in another file than this header's, hence no static functions: GLBK__DEF is
   GLBK_DEF for them. What stands in one block of lines with an enum stays in leaner headers. */

/* The header of a file of sfield_write, and where the file's parts begin. */
typedef struct glbk__sfield_view {
    const uint8_t *bytes;           /* private, like all that follows */
    uint32_t kind;
    uint32_t bands;
    uint32_t shells;
    uint32_t side;
    uint32_t spacing;               /* an sfield_spacing */
    uint32_t frames;
    uint32_t loop;
    uint32_t channels;
    uint32_t samples;               /* of all frames and shells */
    uint32_t stride;                /* bytes of a sample */
    uint32_t cells;                 /* texels of a sample and channel in the table */
    size_t   scales;                /* where scales and biases begin, bytes */
    size_t   first;                 /* where samples begin, bytes */
} glbk__sfield_view;

/* A stage holds texels on their way into a table. */
typedef struct glbk__sfield_stage {
    glbk_context *ctx;
    const glbk_texture *table;
    uint32_t *words;
    size_t    at;                   /* where in the table the first of them goes */
    size_t    count;                /* texels that wait in words */
    size_t    room;
    glbk_result result;             /* of the first upload that failed */
} glbk__sfield_stage;

enum {
    GLBK__SFIELD_HEADER = 32,           /* words of the header of a file */
    GLBK__SFIELD_STAGE = 1024,          /* texels that go up together */
    GLBK__SFIELD_ENTITY = 7             /* texels of an entity */
};
/* Returns this header's part with its library files for reading fields alone, so that a linker leaves out its
   programs; see glbk__gbuffer_program_above. */
GLBK__DEF const glbk_part *glbk__sfield_reader(void);
/* Reads the header of a file. */
GLBK__DEF void glbk__sfield_read(const uint8_t *bytes, glbk__sfield_view *v);
/* glbk__sfield_texel returns the words of a stage's next texel, zeroed; glbk__sfield_flush uploads the texels
   that wait. */
GLBK__DEF uint32_t *glbk__sfield_texel(glbk__sfield_stage *s);
GLBK__DEF void glbk__sfield_flush(glbk__sfield_stage *s);
/* Returns the measure of a distance, as sfield_measure of lib/sfield_field.glsl does. */
GLBK__DEF float glbk__sfield_measure(float d2, int source, int uniform);
/* Compares two of a scene's fields by their pointers, for qsort; glbk__sfield_find returns a field as it was
   uploaded to a scene whose fields are sorted so, or NULL for NULL and for other fields. */
GLBK__DEF int glbk__sfield_by_pointer(const void *a, const void *b);
GLBK__DEF const glbk_sfield_field *glbk__sfield_find(const glbk_sfield_scene *s, const sfield_field *field);
/* Returns the values of the block that tells shaders what a scene's tables hold; sky: not 0 if the sky or the
   open share is wanted. glbk__sfield_tell uploads the block. */
GLBK__DEF glbk_sfield_contents glbk__sfield_contents_of(const glbk_sfield_scene *s, int sky);
GLBK__DEF glbk_result glbk__sfield_tell(glbk_context *ctx, const glbk_sfield_scene *s);
/* Writes zeros to the first layer of a texture of self-visibility: nothing is recorded. */
GLBK__DEF glbk_result glbk__sfield_blank(glbk_context *ctx, const glbk_texture *self);
/* These check, and log what is wrong: that a scene was created; what descs of scenes of either basis have;
   that a G-buffer has the size of a renderer; that some rows of a picture are there. */
GLBK__DEF glbk_result glbk__sfield_check_scene(const glbk_context *ctx, const char *function,
                                               const glbk_sfield_scene *s);
GLBK__DEF glbk_result glbk__sfield_check_lists(const glbk_context *ctx, const char *function,
                                               const sfield_field *const *fields, size_t field_count,
                                               uint32_t entity_capacity, float reach);
GLBK__DEF glbk_result glbk__sfield_check_gbuffer(const glbk_context *ctx, const char *function,
                                                 uint32_t width, uint32_t height, const glbk_gbuffer *g);
GLBK__DEF glbk_result glbk__sfield_check_rows(const glbk_context *ctx, const char *function, uint32_t height,
                                              uint32_t row, uint32_t row_count);

/* ==== src/gl_shadowfield/begin.h ==== */

/* ---- end of the declarations ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_SHADOWFIELD_H */

/* ==== implementation ==================================================================================== */

#if defined(GL_SHADOWFIELD_IMPLEMENTATION) && !defined(GL_SHADOWFIELD_IMPLEMENTED)
#define GL_SHADOWFIELD_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ==== src/shared/mem.h ==== */

/* unit mem: checked sizes, and the caller's allocator with malloc and free as its default */

typedef struct glbk_sfield__allocator {
    void *(*alloc_fn)(size_t size, void *user);
    void (*free_fn)(void *memory, void *user);
    void *user;
} glbk_sfield__allocator;

static inline void *glbk_sfield__default_alloc(size_t size, void *user)
{
    (void)user;
    return malloc(size);
}

static inline void glbk_sfield__default_free(void *memory, void *user)
{
    (void)user;
    free(memory);
}

/* Writes a * b and returns 1; returns 0, with *out untouched, if the product does not fit. */
static inline int glbk_sfield__mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b) return 0;
    *out = a * b;
    return 1;
}

/* Returns 1 if so many bytes may lie between elements of floats that are `standard` bytes large: 0, which
   stands for `standard`, or a multiple of 4 with which elements do not overlap. */
static inline int glbk_sfield__stride_valid(size_t stride, size_t standard)
{
    return stride == 0 || (stride >= standard && stride % 4 == 0);
}

static inline glbk_sfield__allocator glbk_sfield__allocator_make(void *(*alloc_fn)(size_t, void *),
                                           void (*free_fn)(void *, void *), void *user)
{
    glbk_sfield__allocator a;
    a.alloc_fn = alloc_fn && free_fn ? alloc_fn : glbk_sfield__default_alloc;
    a.free_fn = alloc_fn && free_fn ? free_fn : glbk_sfield__default_free;
    a.user = user;
    return a;
}

/* Returns NULL if there is no memory, and also if the size is 0, so that a caller has one thing to test. */
static inline void *glbk_sfield__alloc(const glbk_sfield__allocator *a, size_t size)
{
    return size ? a->alloc_fn(size, a->user) : NULL;
}

static inline void *glbk_sfield__alloc_array(const glbk_sfield__allocator *a, size_t count, size_t item_size)
{
    size_t size;
    return glbk_sfield__mul_size(count, item_size, &size) ? glbk_sfield__alloc(a, size) : NULL;
}

static inline void glbk_sfield__free(const glbk_sfield__allocator *a, void *memory)
{
    if (memory) a->free_fn(memory, a->user);
}

/* ==== src/shared/v3.h ==== */

/* unit v3: three floats */

/* tcc 0.9.27 stores a returned struct of 12 bytes as 16, over the caller's next variable. */
typedef struct glbk_sfield__v3 {
    float x, y, z;
#ifdef __TINYC__
    float unused;
#endif
} glbk_sfield__v3;

static inline glbk_sfield__v3 glbk_sfield__v3_make(float x, float y, float z)
{
    glbk_sfield__v3 v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}

static inline glbk_sfield__v3 glbk_sfield__v3_load(const float *p) { return glbk_sfield__v3_make(p[0], p[1], p[2]); }
static inline void glbk_sfield__v3_store(float *p, glbk_sfield__v3 v) { p[0] = v.x; p[1] = v.y; p[2] = v.z; }

static inline glbk_sfield__v3 glbk_sfield__v3_scale(glbk_sfield__v3 a, float s)
{
    return glbk_sfield__v3_make(a.x * s, a.y * s, a.z * s);
}

static inline float glbk_sfield__v3_dot(glbk_sfield__v3 a, glbk_sfield__v3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline float glbk_sfield__v3_length(glbk_sfield__v3 a)
{
    return sqrtf(glbk_sfield__v3_dot(a, a));
}

static inline glbk_sfield__v3 glbk_sfield__v3_cross(glbk_sfield__v3 a, glbk_sfield__v3 b)
{
    return glbk_sfield__v3_make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

/* Returns 1 if x is finite, by its exponent bits: under -ffast-math compilers may take isfinite() for always
   true. */
static inline int glbk_sfield__finite(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (bits & 0x7f800000u) != 0x7f800000u;
}

/* ==== src/shared/m4.h ==== */

/* unit m4, needs v3: column-major 4 x 4 matrices, float[16], affine */

static inline glbk_sfield__v3 glbk_sfield__m4_point(const float *m, glbk_sfield__v3 p)
{
    return glbk_sfield__v3_make(m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12],
                     m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13],
                     m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14]);
}

/* Returns m, or the identity if all sixteen numbers are 0: so a struct that was zeroed stands where it is. */
static inline const float *glbk_sfield__m4_or_identity(const float *m)
{
    static const float identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    int i;
    for (i = 0; i < 16; i++)
        if (m[i] != 0.0f) return m;         /* so does NaN, for others to refuse */
    return identity;
}

/* Returns 1 if a matrix is finite and its last row is 0 0 0 1. */
static inline int glbk_sfield__m4_is_affine(const float *m)
{
    int i;
    for (i = 0; i < 16; i++)
        if (!glbk_sfield__finite(m[i])) return 0;
    return m[3] == 0.0f && m[7] == 0.0f && m[11] == 0.0f && m[15] == 1.0f;
}

/* Returns 1 and writes *scale if m is a rotation times one scale > 0, without mirroring, and a translation.
   Its columns must be of equal length and at right angles within 1e-4, which products of float rotations
   reach. */
static inline int glbk_sfield__m4_is_rigid_uniform(const float *m, float *scale)
{
    glbk_sfield__v3 x = glbk_sfield__v3_load(m), y = glbk_sfield__v3_load(m + 4), z = glbk_sfield__v3_load(m + 8);
    float lx, ly, lz;
    float s, tolerance;

    if (!glbk_sfield__m4_is_affine(m)) return 0;
    lx = glbk_sfield__v3_length(x);
    ly = glbk_sfield__v3_length(y);
    lz = glbk_sfield__v3_length(z);
    if (!(lx > 0.0f && ly > 0.0f && lz > 0.0f) || !glbk_sfield__finite(lx + ly + lz)) return 0;
    s = (lx + ly + lz) / 3.0f;
    tolerance = 1e-4f * s;
    if (fabsf(lx - s) > tolerance || fabsf(ly - s) > tolerance || fabsf(lz - s) > tolerance) return 0;
    x = glbk_sfield__v3_scale(x, 1.0f / lx);
    y = glbk_sfield__v3_scale(y, 1.0f / ly);
    z = glbk_sfield__v3_scale(z, 1.0f / lz);
    if (fabsf(glbk_sfield__v3_dot(x, y)) > 1e-4f || fabsf(glbk_sfield__v3_dot(x, z)) > 1e-4f) return 0;
    if (fabsf(glbk_sfield__v3_dot(y, z)) > 1e-4f ||
        glbk_sfield__v3_dot(glbk_sfield__v3_cross(x, y), z) < 0.0f) return 0;
    *scale = s;
    return 1;
}

/* ==== src/shared/gl_memory.h ==== */

/* unit gl_memory, needs mem: the allocator of a glbk_context (gl_backend.h) */

static inline glbk_sfield__allocator glbk_sfield__memory(const glbk_context *ctx)
{
    const glbk_allocator *a = &ctx->system.allocator;
    return glbk_sfield__allocator_make(a->alloc_fn, a->free_fn, a->user);
}

/* ==== src/shared/message.h ==== */

/* unit message: one line for the caller's log that says why a call failed */

/* GLBK_SFIELD__COLD stands before functions that are needed only by calls that fail: compilers make these functions
   small, and take branches to them for unlikely. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define GLBK_SFIELD__COLD __attribute__((cold))
#else
#define GLBK_SFIELD__COLD
#endif

/* Where a message goes, and the name of the function that failed. If log is NULL, nothing is written. */
typedef struct glbk_sfield__logger {
    void (*log)(void *user, const char *message);
    void *user;
    const char *function;
} glbk_sfield__logger;

typedef struct glbk_sfield__message { char text[256]; size_t used; } glbk_sfield__message;

/* Appends a text; what does not fit is cut off. */
static inline GLBK_SFIELD__COLD void glbk_sfield__message_text(glbk_sfield__message *m, const char *s)
{
    while (*s && m->used + 1 < sizeof m->text) m->text[m->used++] = *s++;
    m->text[m->used] = 0;
}

static inline GLBK_SFIELD__COLD void glbk_sfield__message_count(glbk_sfield__message *m, uint64_t value)
{
    char digits[24];
    size_t at = sizeof digits - 1;
    digits[at] = 0;
    do digits[--at] = (char)('0' + (int)(value % 10));
    while ((value /= 10) != 0);
    glbk_sfield__message_text(m, digits + at);
}

/* Begins a line: "FUNCTION: FIELD". */
static inline GLBK_SFIELD__COLD void glbk_sfield__message_begin(glbk_sfield__message *m,
                                          const glbk_sfield__logger *logger, const char *field)
{
    m->used = 0;
    glbk_sfield__message_text(m, logger->function);
    glbk_sfield__message_text(m, ": ");
    glbk_sfield__message_text(m, field);
}

/* Logs "FUNCTION: mesh: index 2 of triangle 17 is 90, but the mesh has 80 vertices". position counts the
   indices from 0. */
static inline GLBK_SFIELD__COLD void glbk_sfield__log_index(const glbk_sfield__logger *logger, const char *mesh,
                                      uint64_t position, uint64_t index, uint64_t vertex_count)
{
    glbk_sfield__message m;
    if (!logger->log) return;
    glbk_sfield__message_begin(&m, logger, mesh);
    glbk_sfield__message_text(&m, ": index ");
    glbk_sfield__message_count(&m, position % 3);
    glbk_sfield__message_text(&m, " of triangle ");
    glbk_sfield__message_count(&m, position / 3);
    glbk_sfield__message_text(&m, " is ");
    glbk_sfield__message_count(&m, index);
    glbk_sfield__message_text(&m, ", but the mesh has ");
    glbk_sfield__message_count(&m, vertex_count);
    glbk_sfield__message_text(&m, vertex_count == 1 ? " vertex" : " vertices");
    logger->log(logger->user, m.text);
}

/* ==== GLSL of src/gl_shadowfield ==== */


static const struct { char facts[48];
    char s0[359]; char end; } glbk__glsl_lib_sfield_access_glsl GLBK__TIGHT = {
    "lib/sfield_access.glsl\0" "table sfield_bindings" "\0" "" "\0"
    "" "\0" "",
    "\n\n#define SFIELD_TEXEL(i) texelFetch(glbk_sfield_table, glbk_table_at(i), 0)\n"
    "#define SFIELD_MOVING(i) texelFetch(glbk_sfield_moving, glbk_table_at(i), 0)\n"
    "#ifndef SFIELD_BANDS\n"
    "#define SFIELD_BANDS 4\n"
    "#endif\n"
    "#ifndef SFIELD_GLOSS\n"
    "#define SFIELD_GLOSS 0\n"
    "#endif\n"
    "#ifndef SFIELD_EXP\n"
    "#define SFIELD_EXP 0\n"
    "#endif\n"
    "#ifndef SFIELD_GRAZING\n"
    "#define SFIELD_GRAZING 0\n"
    "#endif\n", 0
};

static const struct { char facts[29];
    char s0[593]; char end; } glbk__glsl_lib_sfield_bindings_glsl GLBK__TIGHT = {
    "lib/sfield_bindings.glsl\0" "" "\0" "" "\0"
    "" "\0" "",
    "\nuniform usampler2DArray glbk_sfield_table,glbk_sfield_moving,glbk_sfield_self;\n"
    "uniform usampler2D glbk_sfield_seen,glbk_sfield_cube;\n"
    "uniform usampler2DArray glbk_sfield_basis;\n"
    "#if __VERSION__ >= 430\n"
    "layout(rgba32f,binding=0)writeonly uniform image2D glbk_sfield_light_image;\n"
    "layout(rgba32f,binding=1)writeonly uniform image2D glbk_sfield_gloss_image;\n"
    "layout(rgba32ui,binding=2)writeonly uniform uimage2D glbk_sfield_cube_image;\n"
    "layout(rgba32ui,binding=3)writeonly uniform uimage2D glbk_sfield_coefs_image;\n"
    "layout(rgba32f,binding=4)writeonly uniform image2D glbk_sfield_grazing_image;\n"
    "#endif\n", 0
};

static const struct { char facts[67];
    char s0[1988]; char end; } glbk__glsl_lib_sfield_brdf_glsl GLBK__TIGHT = {
    "lib/sfield_brdf.glsl\0" "sfield_access sfield_field sfield_contents" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\n\n#define SFIELD_ROUGHNESSES 24\n"
    "#define SFIELD_ANGLES 48\n"
    "#define SFIELD_KERNEL ((SFIELD_BANDS * (SFIELD_BANDS + 1) / 2 + 3) / 4)\n"
    "\n#if SFIELD_GLOSS > 1\n"
    "\nvoid sfield_turn_about_z(vec2 angle,inout float v[SFIELD_COEFS])\n"
    "{\n"
    "float c=1.,s=.0;\n"
    "for(int m=1;m<SFIELD_BANDS;m++){\n"
    "float next=c*angle.x-s*angle.y;\n"
    "s=s*angle.x+c*angle.y;\n"
    "c=next;\n"
    "for(int l=m;l<SFIELD_BANDS;l++){\n"
    "float p=v[l*l+l+m],q=v[l*l+l-m];\n"
    "v[l*l+l+m]=c*p-s*q;\n"
    "v[l*l+l-m]=s*p+c*q;\n"
    "}\n"
    "}\n"
    "}\n"
    "\n\n\nvoid sfield_mix_kernel(uint kernel,float roughness,float facing,out float v[SFIELD_COEFS])\n"
    "{\n"
    "float x=sqrt(1.-clamp(facing,.0,1.))*float(SFIELD_ANGLES-1);\n"
    "float y=clamp(roughness,.0,1.)*float(SFIELD_ROUGHNESSES-1);\n"
    "uint i=min(uint(x),uint(SFIELD_ANGLES-2)),j=min(uint(y),uint(SFIELD_ROUGHNESSES-2));\n"
    "float u=x-float(i),w=y-float(j);\n"
    "uint step=uint(6*SFIELD_KERNEL),row=uint(SFIELD_ANGLES)*step;\n"
    "uint at=glbk_sfield_contents.brdf_texel+j*row+i*step+kernel*uint(SFIELD_KERNEL);\n"
    "float half_of[4*SFIELD_KERNEL];\n"
    "for(int k=0;k<SFIELD_KERNEL;k++,at++){\n"
    "vec4 a=uintBitsToFloat(SFIELD_TEXEL(at)),b=uintBitsToFloat(SFIELD_TEXEL(at+step));\n"
    "vec4 c=uintBitsToFloat(SFIELD_TEXEL(at+row)),d=uintBitsToFloat(SFIELD_TEXEL(at+row+step));\n"
    "vec4 q=(1.-w)*((1.-u)*a+u*b)+w*((1.-u)*c+u*d);\n"
    "for(int n=0;n<4;n++)half_of[4*k+n]=q[n];\n"
    "}\n"
    "for(int l=0;l<SFIELD_BANDS;l++)\n"
    "for(int m=0;m<=l;m++){\n"
    "v[l*l+l-m]=.0;\n"
    "v[l*l+l+m]=half_of[l*(l+1)/2+m];\n"
    "}\n"
    "}\n"
    "\n\n\nvoid sfield_kernel(uint kernel,float roughness,vec3 n,vec3 view,out float v[SFIELD_COEFS])\n"
    "{\n"
    "float ring=length(n.xy);\n"
    "vec2 heading=ring>1e-6?n.xy/ring:vec2(1.,.0);\n"
    "vec2 tilt=vec2(n.z,ring)/length(vec2(n.z,ring));\n"
    "vec2 across=vec2(n.z*dot(heading,view.xy)-ring*view.z,heading.x*view.y-heading.y*view.x);\n"
    "float far=length(across);\n"
    "sfield_mix_kernel(kernel,roughness,dot(n,view),v);\n"
    "sfield_turn_about_z(far>1e-6?across/far:vec2(1.,.0),v);\n"
    "uint turns=min(glbk_sfield_contents.term_count+2u,2u);\n"
    "for(uint i=0u;i<turns;i++){\n"
    "sfield_rotate(uint(SFIELD_COEFS),i>0u,v);\n"
    "sfield_turn_about_z(i==0u?tilt:heading,v);\n"
    "}\n"
    "}\n"
    "#endif\n", 0
};

static const struct { char facts[49];
    char s0[173]; char end; } glbk__glsl_lib_sfield_contents_glsl GLBK__TIGHT = {
    "lib/sfield_contents.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_sfield_contents",
    "\nlayout(std140)uniform glbk_sfield_contents_block{\n"
    "uint entity_texel,entity_count,light_count,wants_sky,term_texel,term_count,\n"
    "sky_texel,brdf_texel;\n"
    "}glbk_sfield_contents;\n", 0
};

static const struct { char facts[26];
    char s0[3954]; char s1[2363]; char end; } glbk__glsl_lib_sfield_field_glsl GLBK__TIGHT = {
    "lib/sfield_field.glsl\0" "" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\n#ifndef SFIELD_TEXEL\n"
    "#error \"SFIELD_TEXEL(i): texel i of the table as uvec4\"\n"
    "#endif\n"
    "#ifndef SFIELD_BANDS\n"
    "#error \"SFIELD_BANDS: 1 to 8\"\n"
    "#endif\n"
    "#ifndef SFIELD_MOVING\n"
    "#define SFIELD_MOVING(i) SFIELD_TEXEL(i)\n"
    "#endif\n"
    "#ifndef SFIELD_ROTATION\n"
    "#define SFIELD_ROTATION(i) SFIELD_MOVING(i)\n"
    "#endif\n"
    "#define SFIELD_COEFS (SFIELD_BANDS * SFIELD_BANDS)\n"
    "#define SFIELD_CELLS ((SFIELD_COEFS + 15) / 16)\n"
    "#define SFIELD_NONE 0xffffffffu\n"
    "#define SFIELD_PI 3.14159265\n"
    "#define SFIELD_Y00 0.282094792\n"
    "\n\n\nstruct sfield_place{\n"
    "uint first;\n"
    "uint shell;\n"
    "vec4 corner;\n"
    "vec2 weight;\n"
    "};\n"
    "\n\nfloat sfield_warp(float u)\n"
    "{\n"
    "float z=u*u;\n"
    "float p=.0946681494+z*(-.0487783181+z*.0127531015);\n"
    "return u+u*(1.-z)*(.273219633+z*(-.150161507+z*p));\n"
    "}\n"
    "\n\n\nfloat sfield_measure(float d2,uint how)\n"
    "{\n"
    "float inverse=1./d2,u=min(inverse,1.);\n"
    "if((how&2u)!=0u)return-sqrt(d2);\n"
    "return(how&1u)!=0u||d2<1.?inverse:u/(1.+sqrt(1.-u));\n"
    "}\n"
    "\n\nsfield_place sfield_locate(uint field,vec3 p)\n"
    "{\n"
    "uvec4 head=SFIELD_TEXEL(field);\n"
    "vec3 a=abs(p);\n"
    "float m=max(max(a.x,a.y),a.z),d2=dot(p,p),inverse=1./max(m,1e-20);\n"
    "bool on_x=m==a.x,on_y=m==a.y&&!on_x;\n"
    "uint face=on_x?(p.x>.0?0u:1u):on_y?(p.y>.0?2u:3u):p.z>.0?4u:5u;\n"
    "float s=on_x?(p.x>.0?-p.z:p.z):on_y?p.x:p.z>.0?p.x:-p.x;\n"
    "float t=on_y?(p.y>.0?p.z:-p.z):-p.y;\n"
    "vec2 grid=(vec2(sfield_warp(s*inverse),sfield_warp(t*inverse))+1.)*(.5*float(head.w-1u));\n"
    "uvec2 at=uvec2(min(grid,vec2(float(head.w)-1.5)));\n"
    "vec2 f=grid-vec2(at);\n"
    "uint low=0u,high=head.z-1u;\n"
    "while(high-low>1u){\n"
    "uint middle=(low+high)>>1;\n"
    "if(uintBitsToFloat(SFIELD_TEXEL(field+3u+middle).x)<=d2)low=middle;\n"
    "else high=middle;\n"
    "}\n"
    "vec2 inner=uintBitsToFloat(SFIELD_TEXEL(field+3u+low).xy);\n"
    "vec2 outer=uintBitsToFloat(SFIELD_TEXEL(field+4u+low).xy);\n"
    "float last=uintBitsToFloat(SFIELD_TEXEL(field+2u+head.z).x),q=max(d2,1e-12);\n"
    "float w=clamp((sfield_measure(q,head.x)-outer.y)/(inner.y-outer.y),.0,1.);\n"
    "sfield_place place;\n"
    "place.first=((low*6u+face)*head.w+at.y)*head.w+at.x;\n"
    "place.shell=low;\n"
    "place.corner=vec4((1.-f.x)*(1.-f.y),f.x*(1.-f.y),(1.-f.x)*f.y,f.x*f.y);\n"
    "place.weight=vec2(w,(1.-w)*min(last/q,1.));\n"
    "return place;\n"
    "}\n"
    "\n\nvec4 sfield_bytes(uint word)\n"
    "{\n"
    "return vec4(float(word&255u),float((word>>8)&255u),float((word>>16)&255u),float(word>>24));\n"
    "}\n"
    "\n\nvoid sfield_mix(uint field,uint first,uint group,uint channel,vec4 corner,float weight,\n"
    "inout float v[SFIELD_COEFS])\n"
    "{\n"
    "uvec4 parts=SFIELD_TEXEL(field+1u);\n"
    "uint side=SFIELD_TEXEL(field).w,cells=uint(SFIELD_CELLS),step=parts.x*cells;\n"
    "uint from=field+parts.z+first*step+channel*cells;\n"
    "uint scale=field+parts.y+(group*parts.x+channel)*8u*cells;\n"
    "for(int cell=0;cell<SFIELD_CELLS;cell++,from++){\n"
    "uvec4 a=SFIELD_TEXEL(from),b=SFIELD_TEXEL(from+step);\n"
    "uvec4 c=SFIELD_TEXEL(from+side*step),d=SFIELD_TEXEL(from+(side+1u)*step);\n"
    "for(int word=0;word<4;word++){\n"
    "uint at=scale+uint(4*cell+word);\n"
    "vec4 q=corner.x*sfield_bytes(a[word])+corner.y*sfield_bytes(b[word])+\n"
    "corner.z*sfield_bytes(c[word])+corner.w*sfield_bytes(d[word]);\n"
    "vec4 scales=uintBitsToFloat(SFIELD_TEXEL(at));\n"
    "vec4 biases=uintBitsToFloat(SFIELD_TEXEL(at+4u*cells));\n"
    "q=weight*(q*scales+biases);\n"
    "for(int i=0;i<4;i++)\n"
    "if(16*cell+4*word+i<SFIELD_COEFS)v[16*cell+4*word+i]+=q[i];\n"
    "}\n"
    "}\n"
    "}\n"
    "\n\nfloat sfield_frames(uint field,float time,out uint before,out uint after)\n"
    "{\n"
    "uvec4 head=SFIELD_TEXEL(field);\n"
    "before=after=0u;\n"
    "if(head.y<2u)return .0;\n"
    "float n=float(head.y),t=time*uintBitsToFloat(SFIELD_TEXEL(field+2u).x);\n"
    "bool loop=(head.x&4u)!=0u;\n"
    "if(loop)t=clamp(t,-1e7,1e7)-n*floor(clamp(t,-1e7,1e7)/n);\n"
    "t=max(t,.0);\n"
    "t=t<n?t:loop?.0:n;\n"
    "before=min(uint(t),head.y-1u);\n"
    "after=before+1u<head.y?before+1u:loop?0u:before;\n"
    "return t-float(before)<1.?t-float(before):.0;\n"
    "}\n"
    "\n\n\n\nvoid sfield_fetch(uint field,sfield_place at,uint channel,float time,float weight,\n"
    "out float v[SFIELD_COEFS])\n"
    "{\n"
    "uvec4 head=SFIELD_TEXEL(field);\n"
    "uint before,after,shell=6u*head.w*head.w;\n"
    "for(int k=0;k<SFIELD_COEFS;k++)v[k]=.0;\n"
    "float t=sfield_frames(field,time,before,after);\n"
    "for(uint i=0u;i<(t>.0?4u:2u);i++){\n"
    "uint frame=(i<2u?before:after)*head.z,outer=i&1u;\n",
    "float w=weight*(i<2u?1.-t:t)*(outer==0u?at.weight.x:at.weight.y);\n"
    "if(w!=.0)\n"
    "sfield_mix(field,(frame+outer)*shell+at.first,frame+at.shell+outer,channel,\n"
    "at.corner,w,v);\n"
    "}\n"
    "}\n"
    "\n\n\n\n\nvoid sfield_rotate(uint rotation,bool back,inout float v[SFIELD_COEFS])\n"
    "{\n"
    "uint row=rotation;\n"
    "for(int l=1;l<SFIELD_BANDS;l++){\n"
    "float sum[2*SFIELD_BANDS];\n"
    "int n=2*l+1,first=l*l;\n"
    "for(int x=0;x<n;x++)sum[x]=.0;\n"
    "for(int y=0;y<n;y++){\n"
    "vec4 m=vec4(.0);\n"
    "for(int x=0;x<n;x++){\n"
    "if(x%4==0)m=uintBitsToFloat(SFIELD_ROTATION(row++));\n"
    "if(back)sum[x]+=m[x%4]*v[first+y];\n"
    "else sum[y]+=m[x%4]*v[first+x];\n"
    "}\n"
    "}\n"
    "for(int x=0;x<n;x++)v[first+x]=sum[x];\n"
    "}\n"
    "}\n"
    "\n\n\n\n\n#ifndef SFIELD_UNROLLED\n"
    "void sfield_product(uvec2 terms,float a[SFIELD_COEFS],float b[SFIELD_COEFS],out float r[SFIELD_COEFS])\n"
    "{\n"
    "r[0]=a[0]*b[0];\n"
    "for(int k=1;k<SFIELD_COEFS;k++){\n"
    "r[0]+=a[k]*b[k];\n"
    "r[k]=SFIELD_Y00*(a[0]*b[k]+a[k]*b[0]);\n"
    "}\n"
    "r[0]*=SFIELD_Y00;\n"
    "for(uint e=0u;e<terms.y;e+=4u)\n"
    "for(uint of=0u;of<4u;of++){\n"
    "uvec4 two=SFIELD_TEXEL(terms.x+e+of);\n"
    "for(int h=0;h<2;h++){\n"
    "uint which=h==0?two.x:two.z,i=which&255u,j=(which>>8)&255u;\n"
    "r[which>>16]+=uintBitsToFloat(h==0?two.y:two.w)*(a[i]*b[j]+a[j]*b[i]);\n"
    "}\n"
    "}\n"
    "}\n"
    "#endif\n"
    "\n\nvoid sfield_basis(vec3 d,out float y[SFIELD_COEFS])\n"
    "{\n"
    "float c=1.,s=.0,diagonal=SFIELD_Y00;\n"
    "for(int m=0;m<SFIELD_BANDS;m++){\n"
    "float older=.0,now=m>0?1.41421356*diagonal:diagonal,fm=float(m);\n"
    "for(int l=m;l<SFIELD_BANDS;l++){\n"
    "float fl=float(l),back=l>0?sqrt((fl*fl-fm*fm)/(4.*fl*fl-1.)):.0;\n"
    "float a=sqrt((4.*(fl+1.)*(fl+1.)-1.)/((fl+1.)*(fl+1.)-fm*fm));\n"
    "float next=a*(d.z*now-back*older);\n"
    "y[l*l+l-m]=now*s;\n"
    "y[l*l+l+m]=now*c;\n"
    "older=now;\n"
    "now=next;\n"
    "}\n"
    "diagonal*=sqrt((2.*fm+3.)/(2.*fm+2.));\n"
    "float turned=c*d.x-s*d.y;\n"
    "s=c*d.y+s*d.x;\n"
    "c=turned;\n"
    "}\n"
    "}\n"
    "\n\nvoid sfield_cosine(vec3 n,out float t[SFIELD_COEFS])\n"
    "{\n"
    "const float a[8]=\n"
    "float[8](3.14159265,2.09439510,.785398163,.0,-.130899694,.0,.0490873852,.0);\n"
    "sfield_basis(n,t);\n"
    "for(int l=0;l<SFIELD_BANDS;l++)\n"
    "for(int k=l*l;k<(l+1)*(l+1);k++)t[k]*=a[l];\n"
    "}\n"
    "\n\nvoid sfield_lobe(vec3 mirrored,float n,out float t[SFIELD_COEFS])\n"
    "{\n"
    "float before=(n+2.)/(n+1.),now=1.;\n"
    "sfield_basis(mirrored,t);\n"
    "t[0]*=before;\n"
    "for(int l=1;l<SFIELD_BANDS;l++){\n"
    "for(int k=l*l;k<(l+1)*(l+1);k++)t[k]*=now;\n"
    "float next=before*(n-float(l)+1.)/(n+float(l)+2.);\n"
    "before=now;\n"
    "now=next;\n"
    "}\n"
    "}\n"
    "\n\nfloat sfield_dot(float a[SFIELD_COEFS],float b[SFIELD_COEFS])\n"
    "{\n"
    "float sum=.0;\n"
    "for(int k=0;k<SFIELD_COEFS;k++)sum+=a[k]*b[k];\n"
    "return sum;\n"
    "}\n", 0
};

static const struct { char facts[43];
    char s0[79]; char end; } glbk__glsl_lib_sfield_frame_glsl GLBK__TIGHT = {
    "lib/sfield_frame.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_sfield_frame",
    "\nlayout(std140)uniform glbk_sfield_frame_block{\n"
    "vec4 eye;\n"
    "}glbk_sfield_frame;\n", 0
};

static const struct { char facts[54];
    char s0[3998]; char s1[741]; char end; } glbk__glsl_lib_sfield_list_glsl GLBK__TIGHT = {
    "lib/sfield_list.glsl\0" "sfield_access sfield_contents" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n#ifndef SFIELD_GROUP\n"
    "#define SFIELD_GROUP 64u\n"
    "#endif\n"
    "#define SFIELD_ENTITY 7u\n"
    "#define SFIELD_LISTED 128u\n"
    "#define SFIELD_STAGED 768u\n"
    "#define SFIELD_TURNED 0x80000000u\n"
    "\nshared uvec4 sfield_texels[SFIELD_LISTED*SFIELD_ENTITY+SFIELD_STAGED];\n"
    "shared uint sfield_numbers[SFIELD_LISTED],sfield_turns[SFIELD_LISTED],sfield_listed,sfield_turned;\n"
    "shared vec2 sfield_spans[SFIELD_LISTED];\n"
    "\n\nbool sfield_all(){return sfield_listed>SFIELD_LISTED;}\n"
    "\n\n\nuint sfield_name(uint i){return sfield_all()?i<<8|255u:sfield_numbers[i]<<8|i;}\n"
    "\n\nuvec4 sfield_record(uint name,uint k)\n"
    "{\n"
    "if((name&255u)!=255u)return sfield_texels[(name&255u)*SFIELD_ENTITY+k];\n"
    "return SFIELD_MOVING(glbk_sfield_contents.entity_texel+(name>>8)*SFIELD_ENTITY+k);\n"
    "}\n"
    "\n\nuvec4 sfield_rotation_texel(uint i)\n"
    "{\n"
    "if(i<SFIELD_TURNED)return SFIELD_MOVING(i);\n"
    "return sfield_texels[SFIELD_LISTED*SFIELD_ENTITY+(i&~SFIELD_TURNED)];\n"
    "}\n"
    "\n#define SFIELD_COUNT (sfield_all() ? glbk_sfield_contents.entity_count : sfield_listed)\n"
    "#define SFIELD_NAME(i) sfield_name(i)\n"
    "#define SFIELD_NUMBER(name) (name >> 8)\n"
    "#define SFIELD_RECORD(name, k) sfield_record(name, k)\n"
    "#define SFIELD_NEAR(i) (sfield_all() ? 0.0 : sfield_spans[i].x)\n"
    "#define SFIELD_FAR(i) (sfield_all() ? 3e38 : sfield_spans[i].y)\n"
    "#define SFIELD_ROTATION(i) sfield_rotation_texel(i)\n"
    "\n\nvoid sfield_wait()\n"
    "{\n"
    "memoryBarrierShared();\n"
    "barrier();\n"
    "}\n"
    "\n\nstruct sfield_box{\n"
    "vec3 low;\n"
    "vec3 high;\n"
    "vec3 normal_low;\n"
    "vec3 normal_high;\n"
    "};\n"
    "\n\nsfield_box sfield_bound(vec3 position,vec3 normal,bool seen)\n"
    "{\n"
    "uint me=gl_LocalInvocationIndex;\n"
    "bool counts=seen&&all(lessThan(abs(position),vec3(1e18)));\n"
    "vec3 least[4]=vec3[4](position,-position,normal,-normal);\n"
    "for(uint k=0u;k<4u;k++)\n"
    "sfield_texels[k*SFIELD_GROUP+me]=floatBitsToUint(vec4(counts?least[k]:vec3(3e38),.0));\n"
    "for(uint rest=SFIELD_GROUP/2u;rest>0u;rest>>=1u){\n"
    "sfield_wait();\n"
    "for(uint k=0u;k<4u&&me<rest;k++){\n"
    "uint at=k*SFIELD_GROUP+me;\n"
    "vec4 a=uintBitsToFloat(sfield_texels[at]),b=uintBitsToFloat(sfield_texels[at+rest]);\n"
    "sfield_texels[at]=floatBitsToUint(min(a,b));\n"
    "}\n"
    "}\n"
    "sfield_wait();\n"
    "for(uint k=0u;k<4u;k++)least[k]=uintBitsToFloat(sfield_texels[k*SFIELD_GROUP].xyz);\n"
    "sfield_wait();\n"
    "return sfield_box(least[0],-least[1],least[2],-least[3]);\n"
    "}\n"
    "\n\n\nvec2 sfield_span(sfield_box b,vec3 p)\n"
    "{\n"
    "vec3 near=max(max(b.low-p,p-b.high),.0),far=max(abs(b.low-p),abs(b.high-p));\n"
    "return vec2(.99999*dot(near,near),1.00001*dot(far,far));\n"
    "}\n"
    "\n\nbool sfield_above(sfield_box b,vec3 p,float radius)\n"
    "{\n"
    "vec3 from=p-b.high,to=p-b.low;\n"
    "vec3 most=max(max(from*b.normal_low,from*b.normal_high),\n"
    "max(to*b.normal_low,to*b.normal_high));\n"
    "vec3 room=1e-6*max(abs(from),abs(to));\n"
    "return most.x+most.y+most.z+room.x+room.y+room.z>-radius;\n"
    "}\n"
    "\n\nvoid sfield_list(vec3 position,vec3 normal,bool seen)\n"
    "{\n"
    "const uint rotation_texels[8]=uint[8](1u,3u,13u,27u,54u,87u,139u,199u);\n"
    "const uint turn=rotation_texels[SFIELD_BANDS-1],turns=min(SFIELD_STAGED/turn,SFIELD_LISTED);\n"
    "uint me=gl_LocalInvocationIndex;\n"
    "sfield_listed=sfield_turned=0u;\n"
    "sfield_box box=sfield_bound(position,normal,seen);\n"
    "if(box.low.x>box.high.x)return;\n"
    "for(uint e=me;e<glbk_sfield_contents.entity_count;e+=SFIELD_GROUP){\n"
    "uint at=glbk_sfield_contents.entity_texel+e*SFIELD_ENTITY;\n"
    "vec4 occluder=uintBitsToFloat(SFIELD_MOVING(at)),source=uintBitsToFloat(SFIELD_MOVING(at+1u));\n"
    "vec2 span=sfield_span(box,occluder.xyz),light=vec2(.0);\n"
    "float radius=uintBitsToFloat(SFIELD_MOVING(at+3u).w);\n"
    "bool hides=span.x<occluder.w&&sfield_above(box,occluder.xyz,radius);\n"
    "if(source.w>.0)light=sfield_span(box,source.xyz);\n"
    "if(!hides&&!(source.w>.0))continue;\n"
    "span=vec2(source.w>.0?light.x:span.x,hides?max(span.y,light.y):light.y);\n"
    "uint slot=atomicAdd(sfield_listed,1u);\n"
    "if(slot<SFIELD_LISTED)sfield_texels[slot]=uvec4(e,floatBitsToUint(span),0u);\n"
    "}\n"
    "sfield_wait();\n"
    "uint listed=sfield_listed;\n"
    "if(listed>SFIELD_LISTED)return;\n"
    "for(uint i=me;i<listed;i+=SFIELD_GROUP){\n"
    "uvec4 mine=sfield_texels[i];\n"
    "uint rank=0u;\n"
    "for(uint k=0u;k<listed;k++){\n"
    "uvec4 other=sfield_texels[k];\n"
    "if(other.y<mine.y||(other.y==mine.y&&other.x<mine.x))rank++;\n"
    "}\n"
    "sfield_numbers[rank]=mine.x;\n",
    "sfield_spans[rank]=uintBitsToFloat(mine.yz);\n"
    "}\n"
    "sfield_wait();\n"
    "for(uint i=me;i<listed*SFIELD_ENTITY;i+=SFIELD_GROUP){\n"
    "uint entity=glbk_sfield_contents.entity_texel+sfield_numbers[i/SFIELD_ENTITY]*SFIELD_ENTITY;\n"
    "sfield_texels[i]=SFIELD_MOVING(entity+i%SFIELD_ENTITY);\n"
    "}\n"
    "sfield_wait();\n"
    "for(uint i=me;i<listed;i+=SFIELD_GROUP){\n"
    "uint at=i*SFIELD_ENTITY+5u,rotation=sfield_texels[at].z;\n"
    "if(rotation==0xffffffffu)continue;\n"
    "uint slot=atomicAdd(sfield_turned,1u);\n"
    "if(slot>=turns)continue;\n"
    "sfield_turns[slot]=rotation;\n"
    "sfield_texels[at].z=SFIELD_TURNED|slot*turn;\n"
    "}\n"
    "sfield_wait();\n"
    "for(uint i=me;i<min(sfield_turned,turns)*turn;i+=SFIELD_GROUP)\n"
    "sfield_texels[SFIELD_LISTED*SFIELD_ENTITY+i]=SFIELD_MOVING(sfield_turns[i/turn]+i%turn);\n"
    "sfield_wait();\n"
    "}\n", 0
};

static const struct { char facts[45];
    char s0[92]; char end; } glbk__glsl_lib_sfield_object_glsl GLBK__TIGHT = {
    "lib/sfield_object.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_sfield_object",
    "\nlayout(std140)uniform glbk_sfield_object_block{\n"
    "mat4 transform,clip;\n"
    "}glbk_sfield_object;\n", 0
};

static const struct { char facts[71];
    char s0[2508]; char end; } glbk__glsl_lib_sfield_point_glsl GLBK__TIGHT = {
    "lib/sfield_point.glsl\0" "gbuffer sfield_shade sfield_brdf sfield_frame" "\0" "" "\0"
    "" "\0" "",
    "\n\n#ifndef SFIELD_SELF\n"
    "#define SFIELD_SELF 0\n"
    "#endif\n"
    "\n\n\nbool sfield_start(ivec2 at,glbk_point p,out float t[SFIELD_COEFS])\n"
    "{\n"
    "sfield_cosine(p.normal,t);\n"
    "#if SFIELD_SELF\n"
    "if((texelFetch(glbk_sfield_self,ivec3(at,0),0).x&0xffffu)==0u)return false;\n"
    "for(int layer=0;8*layer<SFIELD_COEFS;layer++){\n"
    "uvec4 words=texelFetch(glbk_sfield_self,ivec3(at,layer),0);\n"
    "for(int k=0;k<8;k++){\n"
    "int bits=int((k&1)!=0?words[k>>1]:words[k>>1]<<16)>>16;\n"
    "if(8*layer+k<SFIELD_COEFS)t[8*layer+k]=float(bits)*(1.5/32767.);\n"
    "}\n"
    "}\n"
    "if(p.entity-1u<glbk_sfield_contents.entity_count){\n"
    "uint rotation=SFIELD_MOVING(sfield_at(p.entity-1u)+5u).z;\n"
    "if(rotation!=SFIELD_NONE)sfield_rotate(rotation,false,t);\n"
    "}\n"
    "return true;\n"
    "#else\n"
    "return false;\n"
    "#endif\n"
    "}\n"
    "\n#if SFIELD_GLOSS > 1\n"
    "\n\nsfield_sums sfield_shade_material(glbk_point p,float t[SFIELD_COEFS],bool recorded)\n"
    "{\n"
    "float g[SFIELD_COEFS],h[SFIELD_COEFS],own[SFIELD_COEFS],r[SFIELD_COEFS],q[SFIELD_COEFS],whole=1.;\n"
    "vec3 view=glbk_sfield_frame.eye.xyz-p.position;\n"
    "bool metal=p.kind==GLBK_METAL_ROUGH,seen=dot(view,view)>.0;\n"
    "uint kernels=metal?(recorded?4u:3u):p.exponent>.0&&seen?1u:0u;\n"
    "if(metal&&!seen)return sfield_no_light();\n"
    "view=seen?normalize(view):vec3(.0);\n"
    "for(int k=0;k<SFIELD_COEFS;k++){\n"
    "own[k]=t[k];\n"
    "g[k]=h[k]=.0;\n"
    "}\n"
    "for(uint i=0u;i<kernels;i++){\n"
    "bool last=i==3u;\n"
    "if(metal)sfield_kernel(last?0u:recorded?i+3u:i,p.roughness,p.normal,view,r);\n"
    "else sfield_lobe(reflect(-view,p.normal),clamp(p.exponent,1.,1000.),r);\n"
    "if(metal&&(last||(i==0u&&!recorded)))whole=r[0];\n"
    "if(!metal||recorded){\n"
    "sfield_product(SFIELD_TERMS,own,r,q);\n"
    "r=q;\n"
    "}\n"
    "for(int k=0;k<SFIELD_COEFS;k++){\n"
    "t[k]=metal&&i==0u?r[k]:t[k];\n"
    "g[k]=!metal||i==1u?r[k]:g[k];\n"
    "h[k]=metal&&i==2u?r[k]:h[k];\n"
    "}\n"
    "}\n"
    "sfield_sums sums=sfield_shade(p.position,p.normal,p.entity,t,g,h);\n"
    "if(!metal)return sums;\n"
    "vec3 f0=.04+clamp(p.metallic,.0,1.)*(clamp(p.diffuse,.0,1.)-.04);\n"
    "sums.light*=SFIELD_PI*(1.-f0);\n"
    "sums.gloss=sums.gloss*f0+sums.grazing;\n"
    "sums.open*=SFIELD_PI*SFIELD_Y00/whole;\n"
    "return sums;\n"
    "}\n"
    "#endif\n"
    "\n\nsfield_sums sfield_shade_point(ivec2 at,glbk_point p)\n"
    "{\n"
    "float t[SFIELD_COEFS],g[SFIELD_COEFS];\n"
    "bool recorded=sfield_start(at,p,t);\n"
    "#if SFIELD_GLOSS > 1\n"
    "return sfield_shade_material(p,t,recorded);\n"
    "#else\n"
    "for(int k=0;k<SFIELD_COEFS;k++)g[k]=.0;\n"
    "#if SFIELD_GLOSS\n"
    "vec3 view=glbk_sfield_frame.eye.xyz-p.position;\n"
    "float r[SFIELD_COEFS];\n"
    "if(p.exponent>.0&&dot(view,view)>.0){\n"
    "sfield_lobe(reflect(-normalize(view),p.normal),clamp(p.exponent,1.,1000.),r);\n"
    "sfield_product(SFIELD_TERMS,t,r,g);\n"
    "}\n"
    "#endif\n"
    "return sfield_shade(p.position,p.normal,p.entity,t,g);\n"
    "#endif\n"
    "}\n", 0
};

static const struct { char facts[68];
    char s0[3975]; char s1[3999]; char s2[458]; char end; } glbk__glsl_lib_sfield_shade_glsl GLBK__TIGHT = {
    "lib/sfield_shade.glsl\0" "sfield_access sfield_field sfield_contents" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\n\n\n#ifndef SFIELD_ENTITY\n"
    "#define SFIELD_ENTITY 7u\n"
    "#endif\n"
    "#define SFIELD_TERMS uvec2(glbk_sfield_contents.term_texel, glbk_sfield_contents.term_count)\n"
    "#define SFIELD_TURNS_LIGHT (SFIELD_GLOSS > 1 || SFIELD_EXP)\n"
    "#if SFIELD_GLOSS > 1\n"
    "#define SFIELD_AND_H(x) , x\n"
    "#define SFIELD_WITH_H(x) x\n"
    "#else\n"
    "#define SFIELD_AND_H(x)\n"
    "#define SFIELD_WITH_H(x)\n"
    "#endif\n"
    "#if SFIELD_EXP\n"
    "#define SFIELD_AND_E(x) , x\n"
    "#else\n"
    "#define SFIELD_AND_E(x)\n"
    "#endif\n"
    "#define SFIELD_BATCH 8\n"
    "#define SFIELD_OCCLUDERS 4\n"
    "\nstruct sfield_sums{\n"
    "vec3 light;\n"
    "vec3 gloss;\n"
    "float open;\n"
    "vec3 grazing;\n"
    "};\n"
    "\nsfield_sums sfield_no_light(){return sfield_sums(vec3(.0),vec3(.0),.0,vec3(.0));}\n"
    "\n\n\nuint sfield_at(uint i){return glbk_sfield_contents.entity_texel+i*SFIELD_ENTITY;}\n"
    "\n\n\n\n#ifndef SFIELD_NAME\n"
    "#define SFIELD_COUNT glbk_sfield_contents.entity_count\n"
    "#define SFIELD_NAME(i) i\n"
    "#define SFIELD_NUMBER(name) name\n"
    "#define SFIELD_RECORD(name, k) SFIELD_MOVING(sfield_at(name) + k)\n"
    "#define SFIELD_NEAR(i) 0.0\n"
    "#define SFIELD_FAR(i) 3e38\n"
    "#endif\n"
    "#define SFIELD_HIDES 0x80000000u\n"
    "\n\nvec3 sfield_turn(uint entity,vec3 v)\n"
    "{\n"
    "return vec3(dot(uintBitsToFloat(SFIELD_RECORD(entity,2u).xyz),v),\n"
    "dot(uintBitsToFloat(SFIELD_RECORD(entity,3u).xyz),v),\n"
    "dot(uintBitsToFloat(SFIELD_RECORD(entity,4u).xyz),v));\n"
    "}\n"
    "\n\n\n\n\nvoid sfield_find(vec3 position,uint own,float d2,uint id,inout uint first,out float key[SFIELD_BATCH],\n"
    "out uint name[SFIELD_BATCH])\n"
    "{\n"
    "uint count=SFIELD_COUNT;\n"
    "while(first<count&&SFIELD_FAR(first)<d2)first++;\n"
    "for(int i=0;i<SFIELD_BATCH;i++){\n"
    "key[i]=3e38;\n"
    "name[i]=SFIELD_NONE;\n"
    "}\n"
    "for(uint at=first;at<count&&SFIELD_NEAR(at)<=key[SFIELD_BATCH-1];at++){\n"
    "uint e=SFIELD_NAME(at);\n"
    "if(SFIELD_NUMBER(e)+1u==own)continue;\n"
    "vec4 occluder=uintBitsToFloat(SFIELD_RECORD(e,0u)),source=uintBitsToFloat(SFIELD_RECORD(e,1u));\n"
    "vec3 v=occluder.xyz-position,w=source.xyz-position;\n"
    "float far=dot(v,v),light=source.w>.0?dot(w,w):.0;\n"
    "for(int what=0;what<2;what++){\n"
    "float k=what==0?light:max(far,light);\n"
    "uint n=what==0?e:e|SFIELD_HIDES;\n"
    "bool there=what==0?source.w>.0:far<occluder.w;\n"
    "if(!there||!(k>d2||(k==d2&&(id==SFIELD_NONE||n>id))))continue;\n"
    "for(int i=0;i<SFIELD_BATCH;i++)\n"
    "if(k<key[i]||(k==key[i]&&n<name[i])){\n"
    "float a=key[i];\n"
    "uint b=name[i];\n"
    "key[i]=k;\n"
    "name[i]=n;\n"
    "k=a;\n"
    "n=b;\n"
    "}\n"
    "}\n"
    "}\n"
    "}\n"
    "\n\nvoid sfield_pick(float key[SFIELD_BATCH],uint name[SFIELD_BATCH],uint i,out float d2,out uint id)\n"
    "{\n"
    "d2=key[0];\n"
    "id=name[0];\n"
    "for(int k=1;k<SFIELD_BATCH;k++)\n"
    "if(uint(k)==i){\n"
    "d2=key[k];\n"
    "id=name[k];\n"
    "}\n"
    "}\n"
    "\n\nstruct sfield_occluders{\n"
    "vec4 cone[SFIELD_OCCLUDERS];\n"
    "int count;\n"
    "};\n"
    "\n\n\nbool sfield_hidden(sfield_occluders b,vec3 v,float sin_a)\n"
    "{\n"
    "float cos_a=sqrt(max(1.-sin_a*sin_a,.0));\n"
    "bool hidden=false;\n"
    "for(int i=0;i<SFIELD_OCCLUDERS;i++){\n"
    "float cos_b=b.cone[i].w,sin_b=sqrt(max(1.-cos_b*cos_b,.0));\n"
    "bool within=dot(v,b.cone[i].xyz)>=cos_a*cos_b+sin_a*sin_b;\n"
    "hidden=hidden||(i<b.count&&sin_a<sin_b&&within);\n"
    "}\n"
    "return hidden;\n"
    "}\n"
    "\n\nvec3 sfield_local(uint entity,vec4 sphere,vec3 position)\n"
    "{\n"
    "return sfield_turn(entity,position-sphere.xyz)/sphere.w;\n"
    "}\n"
    "\n\n\nbool sfield_occlusion(uint entity,vec3 position,vec3 normal,inout sfield_occluders met,\n"
    "out float o[SFIELD_COEFS])\n"
    "{\n"
    "uvec4 what=SFIELD_RECORD(entity,5u);\n"
    "vec4 place=uintBitsToFloat(SFIELD_RECORD(entity,0u));\n"
    "float radius=uintBitsToFloat(SFIELD_RECORD(entity,3u).w);\n"
    "float inscribed=uintBitsToFloat(SFIELD_RECORD(entity,2u).w);\n"
    "vec3 v=place.xyz-position;\n"
    "float d=length(v),factor=clamp(4.*(1.-d*inversesqrt(place.w)),.0,1.);\n"
    "if(!(factor>.0)||!(dot(v,normal)>-radius))return false;\n"
    "if(radius<d&&sfield_hidden(met,v/d,radius/d))return false;\n"
    "if(inscribed>.0&&inscribed<d&&factor>=1.&&met.count<SFIELD_OCCLUDERS){\n"
    "for(int i=0;i<SFIELD_OCCLUDERS;i++)\n"
    "if(i==met.count)met.cone[i]=vec4(v/d,sqrt(1.-inscribed*inscribed/(d*d)));\n"
    "met.count++;\n"
    "}\n"
    "for(int k=0;k<SFIELD_COEFS;k++)o[k]=.0;\n"
    "vec3 local=sfield_local(entity,vec4(place.xyz,radius),position);\n"
    "sfield_fetch(what.x,sfield_locate(what.x,local),0u,.0,factor,o);\n"
    "if(what.z!=SFIELD_NONE)sfield_rotate(what.z,false,o);\n"
    "return true;\n"
    "}\n"
    "\n\n\nvec3 sfield_channel(vec3 rgb,uint c,float sum)\n"
    "{\n",
    "return c==0u?vec3(sum):c==1u?vec3(rgb.x,sum,sum):vec3(rgb.xy,sum);\n"
    "}\n"
    "\n\n\n\nvoid sfield_light(uint entity,vec3 position,float t[SFIELD_COEFS],float g[SFIELD_COEFS]\n"
    "SFIELD_AND_H(float h[SFIELD_COEFS])SFIELD_AND_E(float e[SFIELD_COEFS]),\n"
    "inout sfield_sums sums)\n"
    "{\n"
    "uvec4 what=SFIELD_RECORD(entity,5u);\n"
    "vec4 sphere=uintBitsToFloat(SFIELD_RECORD(entity,1u));\n"
    "sfield_place place=sfield_locate(what.y,sfield_local(entity,sphere,position));\n"
    "float time=uintBitsToFloat(SFIELD_RECORD(entity,4u).w),v[SFIELD_COEFS];\n"
    "vec3 light=vec3(.0),gloss=vec3(.0),tint=uintBitsToFloat(SFIELD_RECORD(entity,6u).xyz);\n"
    "#if SFIELD_GLOSS > 1\n"
    "vec3 grazing=vec3(.0);\n"
    "#endif\n"
    "#if SFIELD_EXP\n"
    "float open[SFIELD_COEFS];\n"
    "#endif\n"
    "#if !SFIELD_TURNS_LIGHT\n"
    "if(what.z!=SFIELD_NONE){\n"
    "sfield_rotate(what.z,true,t);\n"
    "#if SFIELD_GLOSS\n"
    "sfield_rotate(what.z,true,g);\n"
    "#endif\n"
    "}\n"
    "#endif\n"
    "for(uint c=0u;c<SFIELD_TEXEL(what.y+1u).x;c++){\n"
    "sfield_fetch(what.y,place,c,time,1.,v);\n"
    "#if SFIELD_TURNS_LIGHT\n"
    "if(what.z!=SFIELD_NONE)sfield_rotate(what.z,false,v);\n"
    "#endif\n"
    "#if SFIELD_EXP\n"
    "sfield_product(SFIELD_TERMS,v,e,open);\n"
    "v=open;\n"
    "#endif\n"
    "#if SFIELD_GLOSS > 1\n"
    "grazing=sfield_channel(grazing,c,sfield_dot(v,h));\n"
    "#endif\n"
    "light=sfield_channel(light,c,sfield_dot(v,t));\n"
    "#if SFIELD_GLOSS\n"
    "gloss=sfield_channel(gloss,c,sfield_dot(v,g));\n"
    "#endif\n"
    "}\n"
    "#if SFIELD_GLOSS > 1\n"
    "sums.grazing+=grazing*tint;\n"
    "#endif\n"
    "sums.light+=light*tint;\n"
    "sums.gloss+=gloss*tint;\n"
    "}\n"
    "\n\nvec3 sfield_sky(float t[SFIELD_COEFS])\n"
    "{\n"
    "uint at=glbk_sfield_contents.sky_texel;\n"
    "vec3 rgb=vec3(.0);\n"
    "for(int k=0;k<SFIELD_COEFS;k++)rgb+=t[k]*uintBitsToFloat(SFIELD_MOVING(at+uint(k)).xyz);\n"
    "return rgb;\n"
    "}\n"
    "\n\nvoid sfield_add_sky(float t[SFIELD_COEFS],float g[SFIELD_COEFS]SFIELD_AND_H(float h[SFIELD_COEFS]),\n"
    "inout sfield_sums sums)\n"
    "{\n"
    "sums.light+=sfield_sky(t);\n"
    "#if SFIELD_GLOSS\n"
    "sums.gloss+=sfield_sky(g);\n"
    "#endif\n"
    "SFIELD_WITH_H(sums.grazing+=sfield_sky(h);)\n"
    "}\n"
    "\n\nvoid sfield_apply(float o[SFIELD_COEFS],inout float t[SFIELD_COEFS])\n"
    "{\n"
    "float r[SFIELD_COEFS];\n"
    "sfield_product(SFIELD_TERMS,t,o,r);\n"
    "for(int k=0;k<SFIELD_COEFS;k++)t[k]-=r[k];\n"
    "}\n"
    "\n#if SFIELD_EXP\n"
    "\n\nvoid sfield_exponentiate(float h[SFIELD_COEFS],out float e[SFIELD_COEFS])\n"
    "{\n"
    "float constant=exp(h[0]*SFIELD_Y00),most=.0,scale=1.,r[SFIELD_COEFS];\n"
    "int squares=0;\n"
    "for(int k=1;k<SFIELD_COEFS;k++)most+=h[k]*h[k];\n"
    "while(squares<12&&most*scale*scale>.25){\n"
    "scale*=.5;\n"
    "squares++;\n"
    "}\n"
    "h[0]=.0;\n"
    "for(int k=0;k<SFIELD_COEFS;k++){\n"
    "h[k]*=scale;\n"
    "e[k]=h[k]*(1./3.);\n"
    "}\n"
    "e[0]+=1./SFIELD_Y00;\n"
    "for(int i=0;i<2+squares;i++){\n"
    "bool horner=i<2;\n"
    "if(i>1)\n"
    "for(int k=0;k<SFIELD_COEFS;k++)h[k]=e[k];\n"
    "sfield_product(SFIELD_TERMS,e,h,r);\n"
    "for(int k=0;k<SFIELD_COEFS;k++)e[k]=i==0?.5*r[k]:r[k];\n"
    "if(horner)e[0]+=1./SFIELD_Y00;\n"
    "}\n"
    "for(int k=0;k<SFIELD_COEFS;k++)e[k]*=constant;\n"
    "}\n"
    "\n\nvoid sfield_open(float e[SFIELD_COEFS],inout float t[SFIELD_COEFS])\n"
    "{\n"
    "float r[SFIELD_COEFS];\n"
    "sfield_product(SFIELD_TERMS,t,e,r);\n"
    "t=r;\n"
    "}\n"
    "#endif\n"
    "\n\n\n\n\nsfield_sums sfield_shade(vec3 position,vec3 normal,uint own,float t[SFIELD_COEFS],float g[SFIELD_COEFS]\n"
    "SFIELD_AND_H(float h[SFIELD_COEFS]))\n"
    "{\n"
    "sfield_sums sums=sfield_no_light();\n"
    "uint count=glbk_sfield_contents.entity_count,left=glbk_sfield_contents.light_count;\n"
    "uint id=SFIELD_NONE,first=0u;\n"
    "uint name[SFIELD_BATCH];\n"
    "if(own-1u<count&&uintBitsToFloat(SFIELD_MOVING(sfield_at(own-1u)+1u).w)>.0)left--;\n"
    "bool sky=glbk_sfield_contents.wants_sky!=0u,more=left>0u||sky;\n"
    "float d2=.0,o[SFIELD_COEFS],key[SFIELD_BATCH];\n"
    "#if SFIELD_EXP\n"
    "float logs[SFIELD_COEFS],e[SFIELD_COEFS];\n"
    "bool fresh=false;\n"
    "for(int k=0;k<SFIELD_COEFS;k++)logs[k]=.0;\n"
    "#endif\n"
    "sfield_occluders met;\n"
    "met.count=0;\n"
    "for(int i=0;i<SFIELD_OCCLUDERS;i++)met.cone[i]=vec4(.0);\n"
    "while(more){\n"
    "sfield_find(position,own,d2,id,first,key,name);\n"
    "for(uint i=0u;i<min(uint(SFIELD_BATCH),2u*count+1u)&&more;i++){\n"
    "sfield_pick(key,name,i,d2,id);\n"
    "if(id==SFIELD_NONE){\n"
    "more=false;\n"
    "}else if(id<SFIELD_HIDES){\n"
    "#if SFIELD_EXP\n"
    "if(!fresh)sfield_exponentiate(logs,e);\n"
    "fresh=true;\n"
    "#endif\n"
    "sfield_light(id,position,t,g SFIELD_AND_H(h)SFIELD_AND_E(e),sums);\n"
    "left--;\n"
    "more=left>0u||sky;\n"
    "}else if(sfield_occlusion(id&~SFIELD_HIDES,position,normal,met,o)){\n",
    "#if SFIELD_EXP\n"
    "for(int k=0;k<SFIELD_COEFS;k++)logs[k]+=o[k];\n"
    "fresh=false;\n"
    "#else\n"
    "sfield_apply(o,t);\n"
    "#if SFIELD_GLOSS\n"
    "sfield_apply(o,g);\n"
    "#endif\n"
    "SFIELD_WITH_H(sfield_apply(o,h);)\n"
    "#endif\n"
    "}\n"
    "}\n"
    "}\n"
    "if(sky){\n"
    "#if SFIELD_EXP\n"
    "if(!fresh)sfield_exponentiate(logs,e);\n"
    "sfield_open(e,t);\n"
    "sfield_open(e,g);\n"
    "SFIELD_WITH_H(sfield_open(e,h);)\n"
    "#endif\n"
    "sfield_add_sky(t,g SFIELD_AND_H(h),sums);\n"
    "}\n"
    "sums.light*=1./SFIELD_PI;\n"
    "sums.open=t[0]*(1./(SFIELD_PI*SFIELD_Y00));\n"
    "return sums;\n"
    "}\n", 0
};

static const struct { char facts[43];
    char s0[179]; char end; } glbk__glsl_lib_sfield_views_glsl GLBK__TIGHT = {
    "lib/sfield_views.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_sfield_views",
    "\nlayout(std140)uniform glbk_sfield_views_block{\n"
    "vec4 sphere;\n"
    "uint first_tile,rows,width,side,batch,groups,unused0,unused1;\n"
    "vec4 eyes[256];\n"
    "uvec4 places[256];\n"
    "}glbk_sfield_views;\n", 0
};

static const struct { char facts[126];
    char s0[1233]; char end; } glbk__glsl_prog_sfield_project_comp GLBK__TIGHT = {
    "prog/sfield_project.comp\0" "table sfield_bindings sfield_views" "\0" "" "\0"
    "SFIELD_SOURCE=0 SFIELD_BANDS=4 | SFIELD_SOURCE=1 SFIELD_BANDS=8" "\0" "",
    "\n\n\n\n#ifndef SFIELD_BANDS\n"
    "#define SFIELD_BANDS 4\n"
    "#endif\n"
    "#define SFIELD_GROUPS ((SFIELD_BANDS * SFIELD_BANDS + 3) / 4)\n"
    "layout(local_size_x=64)in;\n"
    "shared vec4 sfield_shares[64*SFIELD_GROUPS];\n"
    "\n\nvec4 sfield_basis_at(uint i){return uintBitsToFloat(texelFetch(glbk_sfield_basis,glbk_table_at(i),0));}\n"
    "\nvoid main()\n"
    "{\n"
    "uint eye=gl_WorkGroupID.x,channel=gl_WorkGroupID.y;\n"
    "uint side=glbk_sfield_views.side,cells=6u*side*side;\n"
    "uint me=gl_LocalInvocationID.x;\n"
    "vec4 sum[SFIELD_GROUPS];\n"
    "for(int g=0;g<SFIELD_GROUPS;g++)sum[g]=vec4(.0);\n"
    "for(uint cell=me;cell<cells;cell+=64u){\n"
    "uint x=cell%(6u*side),y=eye*side+cell/(6u*side);\n"
    "#if SFIELD_SOURCE\n"
    "float a=uintBitsToFloat(texelFetch(glbk_sfield_cube,ivec2(x,y),0)[channel]);\n"
    "#else\n"
    "float a=uintBitsToFloat(texelFetch(glbk_sfield_cube,ivec2(x/4u,y),0)[x&3u]);\n"
    "#endif\n"
    "if(a!=.0)\n"
    "for(int g=0;g<SFIELD_GROUPS;g++)sum[g]+=a*sfield_basis_at(uint(g)*cells+cell);\n"
    "}\n"
    "for(int g=0;g<SFIELD_GROUPS;g++)sfield_shares[me*uint(SFIELD_GROUPS)+uint(g)]=sum[g];\n"
    "memoryBarrierShared();\n"
    "barrier();\n"
    "if(me>=uint(SFIELD_GROUPS))return;\n"
    "vec4 all=vec4(.0);\n"
    "for(uint i=0u;i<64u;i++)all+=sfield_shares[i*uint(SFIELD_GROUPS)+me];\n"
    "imageStore(glbk_sfield_coefs_image,ivec2(channel*uint(SFIELD_GROUPS)+me,eye),floatBitsToUint(all));\n"
    "}\n", 0
};

static const struct { char facts[96];
    char s0[897]; char end; } glbk__glsl_prog_sfield_project_frag GLBK__TIGHT = {
    "prog/sfield_project.frag\0" "table sfield_bindings sfield_views" "\0" "" "\0"
    "SFIELD_SOURCE=0 | SFIELD_SOURCE=1" "\0" "",
    "\n\n\n\n\n\nlayout(location=0)out uvec4 coefs;\n"
    "\n\nvec4 sfield_basis_at(uint i){return uintBitsToFloat(texelFetch(glbk_sfield_basis,glbk_table_at(i),0));}\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_FragCoord.xy);\n"
    "int side=int(glbk_sfield_views.side);\n"
    "uint group=uint(at.x)%glbk_sfield_views.groups,channel=uint(at.x)/glbk_sfield_views.groups;\n"
    "uint cell=group*uint(6*side*side);\n"
    "vec4 sum=vec4(.0);\n"
    "#if SFIELD_SOURCE\n"
    "int width=6*side;\n"
    "#else\n"
    "int width=6*side/4;\n"
    "#endif\n"
    "for(int y=0;y<side;y++)\n"
    "for(int x=0;x<width;x++){\n"
    "vec4 v=uintBitsToFloat(texelFetch(glbk_sfield_cube,ivec2(x,at.y*side+y),0));\n"
    "#if SFIELD_SOURCE\n"
    "float a=channel==0u?v.x:channel==1u?v.y:v.z;\n"
    "if(a!=.0)sum+=a*sfield_basis_at(cell);\n"
    "cell++;\n"
    "#else\n"
    "if(v!=vec4(.0)){\n"
    "sum+=v.x*sfield_basis_at(cell);\n"
    "sum+=v.y*sfield_basis_at(cell+1u);\n"
    "sum+=v.z*sfield_basis_at(cell+2u);\n"
    "sum+=v.w*sfield_basis_at(cell+3u);\n"
    "}\n"
    "cell+=4u;\n"
    "#endif\n"
    "}\n"
    "coefs=floatBitsToUint(sum);\n"
    "}\n", 0
};

static const struct { char facts[124];
    char s0[357]; char end; } glbk__glsl_prog_sfield_see_frag GLBK__TIGHT = {
    "prog/sfield_see.frag\0" "sfield_bindings mesh_fragment" "\0" "sfield_see.vert" "\0"
    "SFIELD_SOURCE=0 GLBK_PLACE | SFIELD_SOURCE=1 GLBK_PLACE" "\0" "",
    "\n\n\n\n#if SFIELD_SOURCE\n"
    "flat in vec3 sfield_radiance;\n"
    "in float sfield_depth;\n"
    "#endif\n"
    "layout(location=0)out uvec4 seen;\n"
    "\nvoid main()\n"
    "{\n"
    "if(glbk_is_hole())discard;\n"
    "#if SFIELD_SOURCE\n"
    "seen=uvec4(floatBitsToUint(gl_FrontFacing?sfield_radiance:vec3(.0)),0u);\n"
    "\ngl_FragDepth=clamp(gl_FrontFacing?sfield_depth:1.0001*sfield_depth,.0,1.);\n"
    "#else\n"
    "seen=uvec4(1u);\n"
    "#endif\n"
    "}\n", 0
};

static const struct { char facts[120];
    char s0[922]; char end; } glbk__glsl_prog_sfield_see_vert GLBK__TIGHT = {
    "prog/sfield_see.vert\0" "sfield_bindings mesh_vertex sfield_views" "\0" "" "\0"
    "SFIELD_SOURCE=0 GLBK_PLACE | SFIELD_SOURCE=1 GLBK_PLACE" "\0" "",
    "\n\n\n\n\n#ifndef SFIELD_RADIANCE\n"
    "#define SFIELD_RADIANCE 1\n"
    "#endif\n"
    "#if SFIELD_SOURCE\n"
    "layout(location=SFIELD_RADIANCE)in vec3 radiance;\n"
    "flat out vec3 sfield_radiance;\n"
    "out float sfield_depth;\n"
    "#endif\n"
    "\n\nvec3 sfield_to_face(uint face,vec3 p)\n"
    "{\n"
    "if(face==0u)return vec3(-p.z,-p.y,p.x);\n"
    "if(face==1u)return vec3(p.z,-p.y,-p.x);\n"
    "if(face==2u)return vec3(p.x,p.z,p.y);\n"
    "if(face==3u)return vec3(p.x,-p.z,-p.y);\n"
    "return face==4u?vec3(p.x,-p.y,p.z):vec3(-p.x,-p.y,-p.z);\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "uint tile=glbk_sfield_views.first_tile+uint(gl_InstanceID);\n"
    "vec4 eye=glbk_sfield_views.eyes[tile];\n"
    "uvec4 place=glbk_sfield_views.places[tile];\n"
    "vec4 sphere=glbk_sfield_views.sphere;\n"
    "vec3 q=sfield_to_face(place.x,(glbk_vertex_place()-sphere.xyz)/sphere.w-eye.xyz);\n"
    "float rows=float(glbk_sfield_views.rows);\n"
    "gl_Position=vec4(q.x,(q.y+(float(2u*place.w)+1.)*q.z)/rows-q.z,q.y,q.z);\n"
    "#if SFIELD_SOURCE\n"
    "sfield_radiance=radiance;\n"
    "sfield_depth=q.z*eye.w;\n"
    "#endif\n"
    "}\n", 0
};

static const struct { char facts[52];
    char s0[538]; char end; } glbk__glsl_prog_sfield_self_frag GLBK__TIGHT = {
    "prog/sfield_self.frag\0" "" "\0" "sfield_self.vert" "\0"
    "GLBK_PLACE" "\0" "",
    "\n\n\nin vec4 sfield_self0,sfield_self1,sfield_self2,sfield_self3;\n"
    "layout(location=0)out uvec4 sfield_out_self0;\n"
    "layout(location=1)out uvec4 sfield_out_self1;\n"
    "\n\nuvec2 sfield_halves(vec4 v)\n"
    "{\n"
    "ivec4 q=ivec4(floor(clamp(v*(1./1.5),-1.,1.)*32767.+.5));\n"
    "uvec4 u=uvec4(q)&0xffffu;\n"
    "return u.xz|(u.yw<<16);\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "sfield_out_self0=uvec4(sfield_halves(sfield_self0),sfield_halves(sfield_self1));\n"
    "sfield_out_self1=uvec4(sfield_halves(sfield_self2),sfield_halves(sfield_self3));\n"
    "if((sfield_out_self0.x&0xffffu)==0u)sfield_out_self0.x|=1u;\n"
    "}\n", 0
};

static const struct { char facts[77];
    char s0[611]; char end; } glbk__glsl_prog_sfield_self_vert GLBK__TIGHT = {
    "prog/sfield_self.vert\0" "sfield_bindings mesh_vertex sfield_object" "\0" "" "\0"
    "GLBK_PLACE" "\0" "",
    "\n\n\n\n#ifndef SFIELD_SELF0\n"
    "#define SFIELD_SELF0 4\n"
    "#define SFIELD_SELF1 5\n"
    "#define SFIELD_SELF2 6\n"
    "#define SFIELD_SELF3 7\n"
    "#endif\n"
    "layout(location=SFIELD_SELF0)in vec4 self0;\n"
    "layout(location=SFIELD_SELF1)in vec4 self1;\n"
    "layout(location=SFIELD_SELF2)in vec4 self2;\n"
    "layout(location=SFIELD_SELF3)in vec4 self3;\n"
    "invariant gl_Position;\n"
    "out vec4 sfield_self0,sfield_self1,sfield_self2,sfield_self3;\n"
    "\nvoid main()\n"
    "{\n"
    "vec3 place=(glbk_sfield_object.transform*vec4(glbk_vertex_place(),1.)).xyz;\n"
    "sfield_self0=self0;\n"
    "sfield_self1=self1;\n"
    "sfield_self2=self2;\n"
    "sfield_self3=self3;\n"
    "gl_Position=glbk_sfield_object.clip*vec4(place,1.);\n"
    "}\n", 0
};

static const struct { char facts[311];
    char s0[631]; char end; } glbk__glsl_prog_sfield_shade_comp GLBK__TIGHT = {
    "prog/sfield_shade.comp\0" "sfield_list sfield_point" "\0" "" "\0"
    "SFIELD_BANDS=4 SFIELD_GLOSS=0 SFIELD_SELF=1 | SFIELD_BANDS=3 SFIELD_GLOSS=1 | SFIELD_BANDS=8 SFIELD_GLOSS=0 | SFIELD_BANDS=4 SFIELD_GLOSS=2 SFIELD_GRAZING=1 SFIELD_SELF=1 | SFIELD_BANDS=4 SFIELD_EXP=1 SFIELD_GLOSS=0 | SFIELD_BANDS=3 SFIELD_EXP=1 SFIELD_GLOSS=2" "\0" "",
    "\n\n\n\n\n\n\nlayout(local_size_x=8,local_size_y=8)in;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_GlobalInvocationID.xy);\n"
    "ivec2 size=textureSize(glbk_gbuffer_place,0);\n"
    "bool inside=all(lessThan(at,size));\n"
    "glbk_point p;\n"
    "sfield_sums sums=sfield_no_light();\n"
    "bool seen=glbk_read_point(min(at,size-1),p)&&inside;\n"
    "sfield_list(p.position,p.normal,seen);\n"
    "if(seen)sums=sfield_shade_point(at,p);\n"
    "if(!inside)return;\n"
    "imageStore(glbk_sfield_light_image,at,vec4(sums.light,sums.open));\n"
    "#if SFIELD_GLOSS\n"
    "imageStore(glbk_sfield_gloss_image,at,vec4(sums.gloss,1.));\n"
    "#endif\n"
    "#if SFIELD_GRAZING\n"
    "imageStore(glbk_sfield_grazing_image,at,vec4(sums.grazing,1.));\n"
    "#endif\n"
    "}\n", 0
};

static const struct { char facts[299];
    char s0[512]; char end; } glbk__glsl_prog_sfield_shade_frag GLBK__TIGHT = {
    "prog/sfield_shade.frag\0" "sfield_point" "\0" "" "\0"
    "SFIELD_BANDS=4 SFIELD_GLOSS=0 SFIELD_SELF=1 | SFIELD_BANDS=3 SFIELD_GLOSS=1 | SFIELD_BANDS=8 SFIELD_GLOSS=0 | SFIELD_BANDS=4 SFIELD_GLOSS=2 SFIELD_GRAZING=1 SFIELD_SELF=1 | SFIELD_BANDS=4 SFIELD_EXP=1 SFIELD_GLOSS=0 | SFIELD_BANDS=3 SFIELD_EXP=1 SFIELD_GLOSS=2" "\0" "",
    "\n\n\n\n\n\n\n\nlayout(location=0)out glbk_color light;\n"
    "#if SFIELD_GLOSS\n"
    "layout(location=1)out glbk_color gloss;\n"
    "#endif\n"
    "#if SFIELD_GRAZING\n"
    "layout(location=2)out glbk_color grazing;\n"
    "#endif\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_FragCoord.xy);\n"
    "glbk_point p;\n"
    "sfield_sums sums=sfield_no_light();\n"
    "if(glbk_read_point(at,p))sums=sfield_shade_point(at,p);\n"
    "light=glbk_pack(vec4(sums.light,sums.open));\n"
    "#if SFIELD_GLOSS\n"
    "gloss=glbk_pack(vec4(sums.gloss,1.));\n"
    "#endif\n"
    "#if SFIELD_GRAZING\n"
    "grazing=glbk_pack(vec4(sums.grazing,1.));\n"
    "#endif\n"
    "}\n", 0
};

static const struct { char facts[86];
    char s0[1472]; char end; } glbk__glsl_prog_sfield_sum_comp GLBK__TIGHT = {
    "prog/sfield_sum.comp\0" "sfield_bindings sfield_views" "\0" "" "\0"
    "SFIELD_SOURCE=0 | SFIELD_SOURCE=1" "\0" "",
    "\n\n\n\n\nlayout(local_size_x=32)in;\n"
    "#if SFIELD_SOURCE\n"
    "shared vec3 sfield_columns[256];\n"
    "#else\n"
    "shared uint sfield_columns[256];\n"
    "#endif\n"
    "\nvoid main()\n"
    "{\n"
    "uvec4 place=glbk_sfield_views.places[gl_WorkGroupID.y];\n"
    "uint width=glbk_sfield_views.width,side=glbk_sfield_views.side,scale=width/side;\n"
    "uint me=gl_LocalInvocationID.x;\n"
    "ivec2 from=ivec2(place.zw*width+uvec2(0u,gl_WorkGroupID.x*scale));\n"
    "ivec2 to=ivec2(place.x*side,place.y*side+gl_WorkGroupID.x);\n"
    "float share=1./float(scale*scale);\n"
    "#if SFIELD_SOURCE\n"
    "for(uint x=me;x<width;x+=32u){\n"
    "vec3 sum=vec3(.0);\n"
    "for(uint y=0u;y<scale;y++)\n"
    "sum+=uintBitsToFloat(texelFetch(glbk_sfield_seen,from+ivec2(x,y),0).xyz);\n"
    "sfield_columns[x]=sum;\n"
    "}\n"
    "memoryBarrierShared();\n"
    "barrier();\n"
    "for(uint x=me;x<side;x+=32u){\n"
    "vec3 sum=vec3(.0);\n"
    "for(uint k=0u;k<scale;k++)sum+=sfield_columns[x*scale+k];\n"
    "imageStore(glbk_sfield_cube_image,to+ivec2(x,0),uvec4(floatBitsToUint(sum*share),0u));\n"
    "}\n"
    "#else\n"
    "vec2 unit=1./vec2(textureSize(glbk_sfield_seen,0));\n"
    "for(uint x=me;x<width/2u;x+=32u){\n"
    "uvec4 sum=uvec4(0u);\n"
    "for(uint y=0u;y<scale;y+=2u)\n"
    "sum+=textureGather(glbk_sfield_seen,vec2(from+ivec2(2u*x+1u,y+1u))*unit);\n"
    "sfield_columns[x]=sum.x+sum.y+sum.z+sum.w;\n"
    "}\n"
    "memoryBarrierShared();\n"
    "barrier();\n"
    "for(uint x=me;x<side/4u;x+=32u){\n"
    "uvec4 sum=uvec4(0u);\n"
    "for(uint k=0u;k<scale/2u;k++)\n"
    "for(uint i=0u;i<4u;i++)sum[i]+=sfield_columns[(4u*x+i)*(scale/2u)+k];\n"
    "ivec2 at=ivec2(place.x*side/4u+x,to.y);\n"
    "imageStore(glbk_sfield_cube_image,at,floatBitsToUint(vec4(sum)*share));\n"
    "}\n"
    "#endif\n"
    "}\n", 0
};

static const struct { char facts[101];
    char s0[1027]; char end; } glbk__glsl_prog_sfield_sum_frag GLBK__TIGHT = {
    "prog/sfield_sum.frag\0" "sfield_bindings sfield_views" "\0" "sfield_sum.vert" "\0"
    "SFIELD_SOURCE=0 | SFIELD_SOURCE=1" "\0" "",
    "\n\n\n\nflat in uint sfield_tile;\n"
    "layout(location=0)out uvec4 texels;\n"
    "\nvoid main()\n"
    "{\n"
    "uvec4 place=glbk_sfield_views.places[sfield_tile];\n"
    "int width=int(glbk_sfield_views.width),side=int(glbk_sfield_views.side),scale=width/side;\n"
    "ivec2 at=ivec2(gl_FragCoord.xy),tile=ivec2(place.zw)*width;\n"
    "float share=1./float(scale*scale);\n"
    "#if SFIELD_SOURCE\n"
    "ivec2 from=tile+(at-ivec2(place.xy)*side)*scale;\n"
    "vec3 sum=vec3(.0);\n"
    "for(int y=0;y<scale;y++)\n"
    "for(int x=0;x<scale;x++)\n"
    "sum+=uintBitsToFloat(texelFetch(glbk_sfield_seen,from+ivec2(x,y),0).xyz);\n"
    "texels=uvec4(floatBitsToUint(sum*share),0u);\n"
    "#else\n"
    "ivec2 from=tile+(at-ivec2(int(place.x)*side/4,int(place.y)*side))*ivec2(4*scale,scale);\n"
    "uvec4 sum=uvec4(0u);\n"
    "for(int y=0;y<scale;y++)\n"
    "for(int x=0;x<scale;x++){\n"
    "ivec2 p=from+ivec2(x,y),next=ivec2(scale,0);\n"
    "sum.x+=texelFetch(glbk_sfield_seen,p,0).x;\n"
    "sum.y+=texelFetch(glbk_sfield_seen,p+next,0).x;\n"
    "sum.z+=texelFetch(glbk_sfield_seen,p+2*next,0).x;\n"
    "sum.w+=texelFetch(glbk_sfield_seen,p+3*next,0).x;\n"
    "}\n"
    "texels=floatBitsToUint(vec4(sum)*share);\n"
    "#endif\n"
    "}\n", 0
};

static const struct { char facts[86];
    char s0[338]; char end; } glbk__glsl_prog_sfield_sum_vert GLBK__TIGHT = {
    "prog/sfield_sum.vert\0" "sfield_bindings sfield_views" "\0" "" "\0"
    "SFIELD_SOURCE=0 | SFIELD_SOURCE=1" "\0" "",
    "\n\n\nflat out uint sfield_tile;\n"
    "\nvoid main()\n"
    "{\n"
    "uvec4 place=glbk_sfield_views.places[gl_InstanceID];\n"
    "uint side=glbk_sfield_views.side;\n"
    "vec2 corner=vec2(float(gl_VertexID&1)+float(place.x),float(gl_VertexID>>1)+float(place.y));\n"
    "sfield_tile=uint(gl_InstanceID);\n"
    "gl_Position=vec4(2.*corner/vec2(6.,float(glbk_sfield_views.batch))-1.,.0,1.);\n"
    "}\n", 0
};

static const glbk_file glbk__sfield_files[] = {
    { (const char *)&glbk__glsl_lib_sfield_access_glsl },
    { (const char *)&glbk__glsl_lib_sfield_bindings_glsl },
    { (const char *)&glbk__glsl_lib_sfield_brdf_glsl },
    { (const char *)&glbk__glsl_lib_sfield_contents_glsl },
    { (const char *)&glbk__glsl_lib_sfield_field_glsl },
    { (const char *)&glbk__glsl_lib_sfield_frame_glsl },
    { (const char *)&glbk__glsl_lib_sfield_list_glsl },
    { (const char *)&glbk__glsl_lib_sfield_object_glsl },
    { (const char *)&glbk__glsl_lib_sfield_point_glsl },
    { (const char *)&glbk__glsl_lib_sfield_shade_glsl },
    { (const char *)&glbk__glsl_lib_sfield_views_glsl },
    { (const char *)&glbk__glsl_prog_sfield_project_comp },
    { (const char *)&glbk__glsl_prog_sfield_project_frag },
    { (const char *)&glbk__glsl_prog_sfield_see_frag },
    { (const char *)&glbk__glsl_prog_sfield_see_vert },
    { (const char *)&glbk__glsl_prog_sfield_self_frag },
    { (const char *)&glbk__glsl_prog_sfield_self_vert },
    { (const char *)&glbk__glsl_prog_sfield_shade_comp },
    { (const char *)&glbk__glsl_prog_sfield_shade_frag },
    { (const char *)&glbk__glsl_prog_sfield_sum_comp },
    { (const char *)&glbk__glsl_prog_sfield_sum_frag },
    { (const char *)&glbk__glsl_prog_sfield_sum_vert }
};


/* ==== src/gl_shadowfield/part.h ==== */

/* ---- sfield: this header's GLSL, textures and blocks, by which programs find them ---- */

GLBK__PART_CODE(sfield, SFIELD)

/* The part as the programs of gl_wavelets.h use it has only the files that read fields. */
static const glbk_file glbk__sfield_reads[] = {
    { (const char *)&glbk__glsl_lib_sfield_bindings_glsl },
    { (const char *)&glbk__glsl_lib_sfield_contents_glsl },
    { (const char *)&glbk__glsl_lib_sfield_field_glsl }
};
static const glbk_part glbk__sfield_reads_part = {
    "sfield", glbk__sfield_reads, sizeof glbk__sfield_reads / sizeof glbk__sfield_reads[0],
    glbk__sfield_slots
};

GLBK__DEF const glbk_part *glbk__sfield_reader(void) { return &glbk__sfield_reads_part; }

/* ==== src/gl_shadowfield/fields.h ==== */

/* ---- sfield: fields: files of shadowfield.h as texels of one table ---- */

enum { GLBK__SFIELD_KERNELS = 24 * 48 * 6 };    /* of the table of sfield_sh_brdf */

static const uint32_t glbk__sfield_none = 0xffffffffu;  /* SFIELD_NONE of the GLSL */

/* Writes the name of an element of a call's arguments, as the log has it: "ARRAY[INDEX]FIELD". field: "" or
   ".NAME". Returns the name's text. */
static const char *glbk__sfield_name(glbk_sfield__message *name, const char *array, size_t index,
                                     const char *field)
{
    name->used = 0;
    glbk_sfield__message_text(name, array);
    glbk_sfield__message_text(name, "[");
    glbk_sfield__message_count(name, index);
    glbk_sfield__message_text(name, "]");
    glbk_sfield__message_text(name, field);
    return name->text;
}

GLBK__DEF glbk_result glbk__sfield_check_scene(const glbk_context *ctx, const char *function,
                                               const glbk_sfield_scene *s)
{
    if (s && s->table.name) return GLBK_OK;
    return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "scene", s ? "was not created" : "is NULL");
}

/* Appends a number. */
static void glbk__sfield_number(glbk__sink *sink, uint32_t n)
{
    char digits[12];
    size_t at = sizeof digits;
    do digits[--at] = (char)('0' + n % 10);
    while ((n /= 10) != 0);
    glbk__append(sink, digits + at, sizeof digits - at);
}

/* Returns the bands of an algebra, or 0 without one. */
static uint32_t glbk__sfield_bands(const sfield_algebra *algebra)
{
    static const float upright[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    sfield_rotation rotation;
    return sfield_sh_rotation(algebra, upright, &rotation) == SFIELD_OK ? rotation.bands : 0;
}

/* Returns how many texels a rotation has: rows of the blocks from the second band on, each filled up to a
   multiple of four numbers. */
static uint32_t glbk__sfield_rotation_texels(uint32_t bands)
{
    uint32_t l, n = 0;
    for (l = 1; l < bands; l++) n += (2 * l + 1) * ((2 * l + 4) / 4);
    return n;
}

/* Returns how many texels an entity and its rotation have. */
static uint32_t glbk__sfield_entity_texels(uint32_t bands)
{
    return GLBK__SFIELD_ENTITY + glbk__sfield_rotation_texels(bands);
}

/* Returns the little-endian number at p; glbk__sfield_float returns a float. */
static uint32_t glbk__sfield_word(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static float glbk__sfield_float(const uint8_t *p)
{
    const uint32_t word = glbk__sfield_word(p);
    float x;
    memcpy(&x, &word, 4);
    return x;
}

/* Returns how many texels a field has: for its head, its shells, scales and biases for each channel of a
   shell and frame, and samples. */
static uint64_t glbk__sfield_texels_of(const sfield_info *info)
{
    const uint32_t channels = info->kind == SFIELD_KIND_SOURCE ? 3 : 1,
                   cells = (info->bands * info->bands + 15) / 16;
    const uint64_t groups = (uint64_t)info->frame_count * info->shell_count;
    return 3 + info->shell_count + (groups * 8 + info->sample_count) * channels * cells;
}

GLBK__DEF void glbk__sfield_read(const uint8_t *bytes, glbk__sfield_view *v)
{
    size_t groups;
    v->bytes = bytes;
    v->kind = glbk__sfield_word(bytes + 16);
    v->bands = glbk__sfield_word(bytes + 28);
    v->shells = glbk__sfield_word(bytes + 36);
    v->side = glbk__sfield_word(bytes + 40);
    v->spacing = glbk__sfield_word(bytes + 44);
    v->frames = glbk__sfield_word(bytes + 48);
    v->loop = glbk__sfield_word(bytes + 52);
    v->channels = glbk__sfield_word(bytes + 56);
    v->samples = glbk__sfield_word(bytes + 60);
    v->stride = glbk__sfield_word(bytes + 64);
    v->cells = (v->bands * v->bands + 15) / 16;
    groups = (size_t)v->frames * v->shells;
    v->scales = 4 * (GLBK__SFIELD_HEADER + (size_t)v->shells);
    v->first = v->scales + 8 * groups * v->stride;
}

GLBK__DEF void glbk__sfield_flush(glbk__sfield_stage *s)
{
    if (s->count && s->result == GLBK_OK)
        s->result = glbk__table_update(s->ctx, s->table, s->at, s->count, s->words);
    s->at += s->count;
    s->count = 0;
}

GLBK__DEF uint32_t *glbk__sfield_texel(glbk__sfield_stage *s)
{
    if (s->count == s->room) glbk__sfield_flush(s);
    return (uint32_t *)memset(s->words + 4 * s->count++, 0, 16);
}

/* Writes the scales, or the biases, of one channel of a shell and frame. */
static void glbk__sfield_put_floats(glbk__sfield_stage *s, const glbk__sfield_view *v, const uint8_t *from)
{
    uint32_t k, *texel = NULL;
    for (k = 0; k < 16 * v->cells; k++) {
        if (k % 4 == 0) texel = glbk__sfield_texel(s);
        if (k < v->bands * v->bands) texel[k % 4] = glbk__sfield_word(from + 4 * (size_t)k);
    }
}

GLBK__DEF float glbk__sfield_measure(float d2, int source, int uniform)
{
    float inverse = 1 / d2, u = inverse < 1 ? inverse : 1;
    if (uniform) return -sqrtf(d2);
    return source || d2 < 1 ? inverse : u / (1 + sqrtf(1 - u));
}

/* Writes the texels of a field. */
static void glbk__sfield_put(glbk__sfield_stage *s, const glbk__sfield_view *v)
{
    const uint32_t step = v->stride / v->channels, groups = v->frames * v->shells;
    uint32_t *texel = glbk__sfield_texel(s), i, c, k;
    float pair[2];
    texel[0] = (v->kind ? 1u : 0u) | (v->spacing == SFIELD_SPACING_UNIFORM ? 2u : 0u) | (v->loop ? 4u : 0u);
    texel[1] = v->frames;
    texel[2] = v->shells;
    texel[3] = v->side;
    texel = glbk__sfield_texel(s);
    texel[0] = v->channels;
    texel[1] = 3 + v->shells;
    texel[2] = texel[1] + groups * v->channels * v->cells * 8;
    texel = glbk__sfield_texel(s);
    texel[0] = glbk__sfield_word(v->bytes + 92);
    for (i = 0; i < v->shells; i++) {
        pair[0] = glbk__sfield_float(v->bytes + 4 * (GLBK__SFIELD_HEADER + (size_t)i));
        pair[0] *= pair[0];
        pair[1] = glbk__sfield_measure(pair[0], v->kind == 1, v->spacing == SFIELD_SPACING_UNIFORM);
        memcpy(glbk__sfield_texel(s), pair, sizeof pair);
    }
    for (i = 0; i < groups; i++)
        for (c = 0; c < v->channels; c++)
            for (k = 0; k < 2; k++)
                glbk__sfield_put_floats(
                    s, v, v->bytes + v->scales + 4 * (((size_t)k * groups + i) * v->stride + c * step));
    for (i = 0; i < v->samples; i++)
        for (c = 0; c < v->channels; c++) {
            const uint8_t *from = v->bytes + v->first + (size_t)i * v->stride + c * step;
            for (k = 0; k < 16 * v->cells; k++) {
                if (k % 16 == 0) texel = glbk__sfield_texel(s);
                if (k < v->bands * v->bands) texel[k / 4 % 4] |= (uint32_t)from[k] << k % 4 * 8;
            }
        }
}

/* Returns the terms of the product in memory of their own, as sfield_sh_terms writes them, or NULL without
   memory. */
static uint32_t *glbk__sfield_terms(const glbk_sfield__allocator *memory, const sfield_algebra *algebra,
                                    uint32_t *count)
{
    const size_t terms = sfield_sh_terms(algebra, NULL, NULL);
    uint32_t *out = (uint32_t *)glbk_sfield__alloc_array(memory, terms + 1, 8);
    if (out) (void)sfield_sh_terms(algebra, out, (float *)(void *)(out + terms));
    *count = (uint32_t)terms;
    return out;
}

/* Writes the terms of the product, two a texel. */
static void glbk__sfield_put_terms(glbk__sfield_stage *s, const uint32_t *terms, uint32_t count)
{
    uint32_t i, *texel = NULL;
    for (i = 0; i < count; i++) {
        float c;
        memcpy(&c, terms + count + i, 4);
        if ((terms[i] & 255u) == (terms[i] >> 8 & 255u)) c *= 0.5f;     /* since a_i b_j + a_j b_i counts it
                                                                           twice */
        if (i % 2 == 0) texel = glbk__sfield_texel(s);
        texel[i % 2 * 2] = terms[i];
        memcpy(texel + i % 2 * 2 + 1, &c, 4);
    }
    for (i = (i + 1) / 2; i % 4; i++) (void)glbk__sfield_texel(s);      /* fills up with terms of factor 0 to
                                                                           a multiple of 4 texels */
}

/* Returns how many texels a scene's table of BRDFs has. */
static uint32_t glbk__sfield_brdf_texels(const glbk_sfield_scene_desc *d, uint32_t bands)
{
    return d->brdf ? GLBK__SFIELD_KERNELS * ((bands * (bands + 1) / 2 + 3) / 4) : 0;
}

/* Writes the table of BRDFs, each kernel filled up to a multiple of four numbers. */
static void glbk__sfield_put_brdf(glbk__sfield_stage *s, const float *table, uint32_t bands)
{
    const uint32_t half = bands * (bands + 1) / 2;
    uint32_t i, k, *texel = NULL;
    for (i = 0; i < GLBK__SFIELD_KERNELS; i++)
        for (k = 0; k < half; k++) {
            if (k % 4 == 0) texel = glbk__sfield_texel(s);
            memcpy(texel + k % 4, table++, 4);
        }
}

/* Returns whether the first occlusion field of a desc holds logarithms, as all then do. */
static int glbk__sfield_logarithms(const glbk_sfield_scene_desc *d)
{
    size_t i;
    for (i = 0; i < d->field_count; i++) {
        sfield_info info;
        if (!d->fields[i]) continue;
        sfield_get_info(d->fields[i], &info);
        if (info.kind == SFIELD_KIND_OCCLUSION && info.basis == SFIELD_BASIS_SH) return info.logarithm;
    }
    return 0;
}

/* Returns why the GPU cannot have a field of this kind, or NULL if it can. */
static const char *glbk__sfield_refuse(const sfield_info *info, uint32_t bands, int logarithms)
{
    if (info->kind != SFIELD_KIND_OCCLUSION && info->kind != SFIELD_KIND_SOURCE)
        return "is neither an occlusion nor a source field";
    if (info->basis != SFIELD_BASIS_SH)
        return "is one of wavelets, which glbk_sfield_haar_upload takes";
    if (info->bands != bands) return "has other bands than desc.algebra";
    if (info->kind == SFIELD_KIND_OCCLUSION && !info->logarithm != !logarithms)
        return info->logarithm ? "is one of logarithms, as others are not"
                               : "is none of logarithms, as others are";
    return info->shard_end ? "is a shard: sfield_merge first" : NULL;
}

GLBK__DEF glbk_result glbk__sfield_check_lists(const glbk_context *ctx, const char *function,
                                               const sfield_field *const *fields, size_t field_count,
                                               uint32_t entity_capacity, float reach)
{
    if (field_count && !fields) return glbk__refuse(ctx, GLBK_ERR_DESC, function, "desc.fields", "is NULL");
    if (!entity_capacity || entity_capacity > 65535)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "desc.entity_capacity", entity_capacity, 1,
                                  65535);
    if (!(reach >= 0 && reach <= 1e6f))
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "desc.reach", (double)reach, 0, 1e6);
    return GLBK_OK;
}

/* Checks the desc of glbk_sfield_scene_create. */
static glbk_result glbk__sfield_check(const glbk_context *ctx, const char *function,
                                      const glbk_sfield_scene_desc *d, uint32_t bands)
{
    glbk_sfield__message name;
    glbk_result result;
    size_t i;
    if (!d->algebra) return glbk__refuse(ctx, GLBK_ERR_DESC, function, "desc.algebra", "is NULL");
    result = glbk__sfield_check_lists(ctx, function, d->fields, d->field_count, d->entity_capacity, d->reach);
    if (result != GLBK_OK) return result;
    for (i = 0; i < d->field_count; i++) {
        sfield_info info;
        const char *why = "is NULL";
        if (d->fields[i]) {
            sfield_get_info(d->fields[i], &info);
            why = glbk__sfield_refuse(&info, bands, glbk__sfield_logarithms(d));
        }
        if (why)
            return glbk__refuse(ctx, d->fields[i] ? GLBK_ERR_MISMATCH : GLBK_ERR_DESC, function,
                                glbk__sfield_name(&name, "desc.fields", i, ""), why);
    }
    return GLBK_OK;
}

GLBK__DEF int glbk__sfield_by_pointer(const void *a, const void *b)
{
    const uintptr_t x = (uintptr_t)((const glbk_sfield_field *)a)->field;
    const uintptr_t y = (uintptr_t)((const glbk_sfield_field *)b)->field;
    return (x > y) - (x < y);
}

/* Says of each field where it begins, and raises *most_bytes to the bytes of the longest file. Returns the
   texels of all. */
static uint64_t glbk__sfield_lay_out(const glbk_sfield_scene_desc *d, uint64_t texels,
                                     glbk_sfield_field *fields, size_t *most_bytes)
{
    size_t i;
    for (i = 0; i < d->field_count && texels <= (uint64_t)1 << 28; i++) {
        sfield_info info;
        sfield_get_info(d->fields[i], &info);
        fields[i].field = d->fields[i];
        fields[i].start = (uint32_t)texels;
        fields[i].source = info.kind == SFIELD_KIND_SOURCE;
        memcpy(fields[i].center, info.center, sizeof info.center);
        fields[i].radius = info.radius;
        fields[i].inscribed = info.inscribed;
        fields[i].outer = info.outer;
        texels += glbk__sfield_texels_of(&info);
        if (info.bytes > *most_bytes) *most_bytes = info.bytes;
    }
    return texels;
}

/* Uploads terms, BRDFs and fields, these by way of the bytes of each field's file. */
static glbk_result glbk__sfield_fill(const glbk_sfield_scene_desc *d, uint32_t bands,
                                     const glbk_sfield__allocator *memory, size_t most_bytes,
                                     glbk__sfield_stage *s)
{
    uint32_t count, *terms = glbk__sfield_terms(memory, d->algebra, &count);
    uint8_t *bytes = (uint8_t *)glbk_sfield__alloc(memory, most_bytes + 1);
    glbk__sfield_view v;
    size_t i;
    s->words = (uint32_t *)glbk_sfield__alloc(memory, 16 * GLBK__SFIELD_STAGE);
    s->room = GLBK__SFIELD_STAGE;
    if (!terms || !bytes || !s->words) s->result = GLBK_ERR_ALLOC;
    else {
        glbk__sfield_put_terms(s, terms, count);
        if (d->brdf) glbk__sfield_put_brdf(s, d->brdf, bands);
        for (i = 0; i < d->field_count && s->result == GLBK_OK; i++) {
            (void)sfield_write(d->fields[i], bytes, most_bytes);
            glbk__sfield_read(bytes, &v);
            glbk__sfield_put(s, &v);
        }
        glbk__sfield_flush(s);
    }
    glbk_sfield__free(memory, s->words);
    glbk_sfield__free(memory, bytes);
    glbk_sfield__free(memory, terms);
    return s->result;
}

static glbk_result glbk__sfield_put_quarter(glbk_context *ctx, const glbk_sfield_scene *s);

/* Makes the tables of a scene whose bands, entity_capacity, reach and algebra are set. */
static glbk_result glbk__sfield_create(glbk_context *ctx, const char *function,
                                       const glbk_sfield_scene_desc *d, glbk_sfield_scene *out)
{
    const glbk_sfield__allocator memory = glbk_sfield__memory(ctx);
    const uint64_t most = (uint64_t)1 << 28;
    uint64_t texels, moving;
    size_t most_bytes = 0;
    glbk__sfield_stage s;

    out->terms = ((uint32_t)sfield_sh_terms(d->algebra, NULL, NULL) + 7) / 8 * 4;
    out->has_brdf = d->brdf != NULL;
    out->logarithms = glbk__sfield_logarithms(d);
    out->entities_at = out->bands * out->bands;
    if (d->brdf) out->entities_at += glbk__sfield_rotation_texels(out->bands);
    moving = out->entities_at + (uint64_t)d->entity_capacity * glbk__sfield_entity_texels(out->bands);
    out->fields =
        (glbk_sfield_field *)glbk_sfield__alloc_array(&memory, d->field_count + 1, sizeof *out->fields);
    if (!out->fields) return GLBK_ERR_ALLOC;
    out->field_count = d->field_count;
    texels = glbk__sfield_lay_out(d, out->terms + glbk__sfield_brdf_texels(d, out->bands), out->fields,
                                  &most_bytes);
    if (texels > most || moving > most)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function,
                                  texels > most ? "the number of texels of desc.fields"
                                                : "the number of texels of desc.entity_capacity",
                                  (double)(texels > most ? texels : moving), 0, (double)most);
    qsort(out->fields, d->field_count, sizeof *out->fields, glbk__sfield_by_pointer);
    out->texels = (uint32_t)texels;
    memset(&s, 0, sizeof s);
    s.ctx = ctx;
    s.table = &out->table;
    s.result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, out->texels + (size_t)1, &out->table);
    if (s.result == GLBK_OK)
        s.result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, (size_t)moving, &out->moving);
    if (s.result == GLBK_OK)
        s.result = glbk_buffer_create(ctx, sizeof(glbk_sfield_contents), NULL, &out->contents);
    if (s.result == GLBK_OK) s.result = glbk__sfield_fill(d, out->bands, &memory, most_bytes, &s);
    if (s.result == GLBK_OK && d->brdf) s.result = glbk__sfield_put_quarter(ctx, out);
    return s.result == GLBK_OK ? glbk__leave_created(ctx, glbk_sfield_scene_sky(ctx, out, NULL)) : s.result;
}

GLBK_DEF glbk_result glbk_sfield_scene_create(glbk_context *ctx, const glbk_sfield_scene_desc *d,
                                              glbk_sfield_scene *out)
{
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!out) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "out", "is NULL");
    memset(out, 0, sizeof *out);
    if (!d) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "desc", "is NULL");
    out->bands = glbk__sfield_bands(d->algebra);
    result = glbk__sfield_check(ctx, __func__, d, out->bands);
    out->algebra = d->algebra;
    out->entity_capacity = d->entity_capacity;
    out->reach = d->reach;
    if (result == GLBK_OK) result = glbk__sfield_create(ctx, __func__, d, out);
    if (result != GLBK_OK) glbk_sfield_scene_free(ctx, out);
    return result;
}

GLBK_DEF void glbk_sfield_scene_free(glbk_context *ctx, glbk_sfield_scene *s)
{
    if (!s) return;
    glbk_texture_free(ctx, &s->table);
    glbk_texture_free(ctx, &s->moving);
    glbk_buffer_free(ctx, &s->contents);
    if (ctx) {
        const glbk_sfield__allocator memory = glbk_sfield__memory(ctx);
        glbk_sfield__free(&memory, s->fields);
    }
    memset(s, 0, sizeof *s);
}

/* ==== src/gl_shadowfield/entities.h ==== */

/* ---- sfield: entities and sky, which frames change ---- */

enum { GLBK__SFIELD_MOVING = 65536 };      /* texels that go up together */

/* Returns 1 if the coefficients of an entity's fields have to be turned: the first band does not turn. */
static int glbk__sfield_turns(const float *m, uint32_t bands)
{
    return bands > 1 && (m[0] < 0 || m[5] < 0 || m[1] != 0 || m[2] != 0 || m[4] != 0 || m[6] != 0);
}

GLBK__DEF const glbk_sfield_field *glbk__sfield_find(const glbk_sfield_scene *s, const sfield_field *field)
{
    glbk_sfield_field key;
    memset(&key, 0, sizeof key);
    key.field = field;
    if (!field) return NULL;
    return (const glbk_sfield_field *)bsearch(&key, s->fields, s->field_count, sizeof key,
                                              glbk__sfield_by_pointer);
}

/* Checks entity `index` of a list. */
static glbk_result glbk__sfield_check_entity(const glbk_context *ctx, const char *function,
                                             const glbk_sfield_scene *s, const sfield_entity *e, size_t index)
{
    const glbk_sfield_field *occlusion = glbk__sfield_find(s, e->occlusion),
                            *source = glbk__sfield_find(s, e->source);
    const glbk_result input = GLBK_ERR_INPUT, mismatch = GLBK_ERR_MISMATCH;
    glbk_sfield__message name;
    float scale;
    int k;
    if (!glbk_sfield__m4_is_rigid_uniform(glbk_sfield__m4_or_identity(e->transform), &scale))
        return glbk__refuse(ctx, input, function, glbk__sfield_name(&name, "entities", index, ".transform"),
                            "is no rotation with one scale above 0 and a translation");
    for (k = 0; k < 3; k++)
        if (!(e->tint[k] >= -1e18f && e->tint[k] <= 1e18f))
            return glbk__refuse_value(ctx, input, function,
                                      glbk__sfield_name(&name, "entities", index, ".tint"),
                                      (double)e->tint[k], "-1e18..1e18");
    if (!glbk_sfield__finite(e->time))
        return glbk__refuse_value(ctx, input, function, glbk__sfield_name(&name, "entities", index, ".time"),
                                  (double)e->time, "finite");
    if (e->occlusion && (!occlusion || occlusion->source))
        return glbk__refuse(ctx, mismatch, function,
                            glbk__sfield_name(&name, "entities", index, ".occlusion"),
                            "is none of the scene's occlusion fields");
    if (!e->source || (source && source->source == 1)) return GLBK_OK;
    return glbk__refuse(ctx, mismatch, function, glbk__sfield_name(&name, "entities", index, ".source"),
                        "is none of the scene's source fields");
}

/* Writes the centre and radius of a field in the world. */
static void glbk__sfield_sphere(const float *m, const glbk_sfield_field *f, float scale, float *out)
{
    glbk_sfield__v3_store(out, glbk_sfield__m4_point(m, glbk_sfield__v3_load(f->center)));
    out[3] = scale * f->radius;
}

/* Writes the texels of an entity, which docs/gpu-layouts.md lists. rotation is the first texel of its
   rotation. */
static void glbk__sfield_entity_words(const glbk_sfield_scene *s, const sfield_entity *e, uint32_t rotation,
                                      uint32_t *words)
{
    const glbk_sfield_field *occlusion = glbk__sfield_find(s, e->occlusion),
                            *source = glbk__sfield_find(s, e->source);
    const float *m = glbk_sfield__m4_or_identity(e->transform);
    float f[4 * GLBK__SFIELD_ENTITY], scale = 1;
    uint32_t r, c;
    (void)glbk_sfield__m4_is_rigid_uniform(m, &scale);
    memset(f, 0, sizeof f);
    for (r = 0; r < 3; r++)
        for (c = 0; c < 3; c++) f[8 + 4 * r + c] = m[4 * r + c] / scale;
    if (occlusion) {
        glbk__sfield_sphere(m, occlusion, scale, f);
        f[11] = occlusion->inscribed * scale;
        f[15] = f[3];
        f[3] *= s->reach > 0 ? s->reach : occlusion->outer;
        f[3] *= f[3];
    }
    if (source) glbk__sfield_sphere(m, source, scale, f + 4);
    f[19] = e->time;
    memcpy(f + 24, e->tint, 12);
    memcpy(words, f, sizeof f);
    words[20] = occlusion ? occlusion->start : glbk__sfield_none;
    words[21] = source ? source->start : glbk__sfield_none;
    words[22] = glbk__sfield_turns(m, s->cube_side ? 2 : s->bands) ? rotation : glbk__sfield_none;
}

/* Writes the rotation of an entity, or as many texels of zeros if nothing turns. */
static void glbk__sfield_put_rotation(const glbk_sfield_scene *s, const sfield_entity *e,
                                      glbk__sfield_stage *stage)
{
    const float *m = glbk_sfield__m4_or_identity(e->transform), *block;
    uint32_t l, y, x, n;
    uint32_t *texel = NULL;
    sfield_rotation rotation;
    if (!glbk__sfield_turns(m, s->bands)) {
        for (n = glbk__sfield_rotation_texels(s->bands); n > 0; n--) (void)glbk__sfield_texel(stage);
        return;
    }
    (void)sfield_sh_rotation(s->algebra, m, &rotation);
    block = rotation.block + 1;
    for (l = 1; l < s->bands; l++)
        for (y = 0, n = 2 * l + 1; y < n; y++)
            for (x = 0; x < n; x++) {
                if (x % 4 == 0) texel = glbk__sfield_texel(stage);
                memcpy(texel + x % 4, block++, 4);
            }
}

/* Uploads a quarter turn about x, by which shaders turn BRDFs to their normals: after the sky. */
static glbk_result glbk__sfield_put_quarter(glbk_context *ctx, const glbk_sfield_scene *s)
{
    static const float turn[16] = { 1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1 };
    uint32_t words[4 * 200];                    /* 199 texels for 8 bands */
    glbk__sfield_stage stage;
    sfield_entity e;
    memset(&stage, 0, sizeof stage);
    memset(&e, 0, sizeof e);
    memcpy(e.transform, turn, sizeof turn);
    stage.ctx = ctx;
    stage.table = &s->moving;
    stage.at = s->bands * s->bands;
    stage.words = words;
    stage.room = 200;
    glbk__sfield_put_rotation(s, &e, &stage);
    glbk__sfield_flush(&stage);
    return stage.result;
}

GLBK__DEF glbk_sfield_contents glbk__sfield_contents_of(const glbk_sfield_scene *s, int sky)
{
    glbk_sfield_contents contents;
    memset(&contents, 0, sizeof contents);
    contents.entity_texel = s->entities_at;
    contents.entity_count = s->entity_count;
    contents.light_count = s->light_count;
    contents.wants_sky = sky != 0;
    contents.term_count = s->terms;
    contents.brdf_texel = s->terms;
    return contents;
}

GLBK__DEF glbk_result glbk__sfield_tell(glbk_context *ctx, const glbk_sfield_scene *s)
{
    const glbk_sfield_contents contents = glbk__sfield_contents_of(s, s->sky);
    return glbk_buffer_update(ctx, &s->contents, 0, sizeof contents, &contents);
}

/* Uploads the entities of a frame, then their rotations. */
static glbk_result glbk__sfield_move(glbk_context *ctx, const glbk_sfield_scene *s,
                                     const sfield_entity *entities, size_t count)
{
    const glbk_sfield__allocator memory = glbk_sfield__memory(ctx);
    const uint32_t step = glbk__sfield_rotation_texels(s->bands);
    const size_t texels = count * (GLBK__SFIELD_ENTITY + step),
                 first = s->entities_at + GLBK__SFIELD_ENTITY * count;
    uint32_t words[4 * GLBK__SFIELD_ENTITY], k;
    glbk__sfield_stage stage;
    size_t i;

    memset(&stage, 0, sizeof stage);
    stage.ctx = ctx;
    stage.table = &s->moving;
    stage.at = s->entities_at;
    stage.room = texels < GLBK__SFIELD_MOVING ? texels : (size_t)GLBK__SFIELD_MOVING;
    stage.words = (uint32_t *)glbk_sfield__alloc(&memory, 16 * (stage.room + 1));
    if (!stage.words) return GLBK_ERR_ALLOC;
    for (i = 0; i < count; i++) {
        glbk__sfield_entity_words(s, &entities[i], (uint32_t)(first + i * step), words);
        for (k = 0; k < GLBK__SFIELD_ENTITY; k++) memcpy(glbk__sfield_texel(&stage), words + 4 * k, 16);
    }
    for (i = 0; i < count; i++) glbk__sfield_put_rotation(s, &entities[i], &stage);
    glbk__sfield_flush(&stage);
    glbk_sfield__free(&memory, stage.words);
    return stage.result;
}

GLBK_DEF glbk_result glbk_sfield_scene_entities(glbk_context *ctx, glbk_sfield_scene *s,
                                                const sfield_entity *entities, size_t count)
{
    glbk_result result;
    uint32_t lights = 0;
    size_t i;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__sfield_check_scene(ctx, __func__, s);
    if (result != GLBK_OK) return result;
    if (count && !entities) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "entities", "is NULL");
    if (count > s->entity_capacity)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, __func__, "count", (double)count, 0,
                                  s->entity_capacity);
    for (i = 0; i < count && result == GLBK_OK; i++) {
        result = glbk__sfield_check_entity(ctx, __func__, s, &entities[i], i);
        lights += entities[i].source != NULL;
    }
    if (result == GLBK_OK) result = glbk__sfield_move(ctx, s, entities, count);
    if (result != GLBK_OK) return result;
    s->entity_count = (uint32_t)count;
    s->light_count = lights;
    return glbk__sfield_tell(ctx, s);
}

GLBK_DEF glbk_result glbk_sfield_scene_sky(glbk_context *ctx, glbk_sfield_scene *s, const float *coefs)
{
    uint32_t words[4 * 64] = { 0 }, n, k, c;
    glbk_result result;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__sfield_check_scene(ctx, __func__, s);
    if (result != GLBK_OK) return result;
    if (s->cube_side) return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "scene", "has wavelets");
    n = s->bands * s->bands;
    for (k = 0; k < n && coefs; k++)
        for (c = 0; c < 3; c++) memcpy(&words[4 * k + c], &coefs[c * n + k], 4);
    result = glbk__table_update(ctx, &s->moving, 0, n, words);
    if (result != GLBK_OK) return result;
    s->sky = coefs != NULL;
    return glbk__sfield_tell(ctx, s);
}

GLBK_DEF void glbk_sfield_bind(glbk_context *ctx, const glbk_sfield_scene *s, const glbk_offset *offset)
{
    const glbk_offset at = glbk__offset(offset);
    if (!s) return;
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_sfield_table, &s->table);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_sfield_moving, &s->moving);
    glbk_bind_block(ctx, at.block + GLBK_SLOT_glbk_sfield_contents, &s->contents);
}

/* ==== src/gl_shadowfield/self_visibility.h ==== */

/* ---- sfield: self-visibility: drawn or uploaded, pixel by pixel ---- */

GLBK__DEF glbk_result glbk__sfield_blank(glbk_context *ctx, const glbk_texture *self)
{
    const glbk_sfield__allocator memory = glbk_sfield__memory(ctx);
    void *zeros = glbk_sfield__alloc_array(&memory, self->width, 16);
    glbk_result result = GLBK_OK;
    uint32_t y;

    if (!zeros) return GLBK_ERR_ALLOC;
    memset(zeros, 0, (size_t)self->width * 16);
    for (y = 0; y < self->height && result == GLBK_OK; y++) {
        const glbk_box box = { 0, 0, y, 0, self->width, 1, 1 };
        result = glbk_texture_update(ctx, self, &box, zeros);
    }
    glbk_sfield__free(&memory, zeros);
    return result;
}

/* Makes the texture of self-visibility, in which nothing is recorded yet. */
static glbk_result glbk__sfield_self_create(glbk_context *ctx, glbk_sfield_renderer *r)
{
    glbk_texture_desc texture;
    glbk_result result;

    memset(&texture, 0, sizeof texture);
    texture.format = GLBK_FORMAT_RGBA32UI;
    texture.width = r->width;
    texture.height = r->height;
    texture.layers = (r->bands * r->bands + 7) / 8;
    if (texture.layers < 2) texture.layers = 2;         /* since drawing writes two */
    result = glbk_texture_create(ctx, &texture, &r->self);
    return result == GLBK_OK ? glbk__sfield_blank(ctx, &r->self) : result;
}

/* Returns a coefficient in signed 16 bits, with 32767 for 1.5, since functions that are at most a cosine have
   norms up to 1.45. */
static uint32_t glbk__sfield_short(float x)
{
    x = x * (1 / 1.5f);
    x = x > -1 ? (x < 1 ? x : 1) : -1;
    return (uint32_t)(int32_t)(x * 32767 + (x < 0 ? -0.5f : 0.5f)) & 0xffffu;
}

/* Checks that a renderer has self-visibility. */
static glbk_result glbk__sfield_check_self(const glbk_context *ctx, const char *function,
                                           const glbk_sfield_renderer *r)
{
    if (!r || !r->shade.name)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "renderer", r ? "was not created" : "is NULL");
    if (!r->self.name)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, "renderer", "was created without desc.self");
    return GLBK_OK;
}

GLBK__DEF glbk_result glbk__sfield_check_gbuffer(const glbk_context *ctx, const char *function,
                                                 uint32_t width, uint32_t height, const glbk_gbuffer *g)
{
    if (!g || !g->words[0].name)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "gbuffer", g ? "was not created" : "is NULL");
    if (g->width != width)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "gbuffer->width", g->width,
                                  "that of the renderer");
    if (g->height != height)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "gbuffer->height", g->height,
                                  "that of the renderer");
    return GLBK_OK;
}

GLBK__DEF glbk_result glbk__sfield_check_rows(const glbk_context *ctx, const char *function, uint32_t height,
                                              uint32_t row, uint32_t row_count)
{
    if (row >= height) return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, function, "row", row, 0, height - 1);
    if (row_count && row_count <= height - row) return GLBK_OK;
    return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, function, "row_count", row_count, 1, height - row);
}

GLBK_DEF glbk_result glbk_sfield_self_upload(glbk_context *ctx, glbk_sfield_renderer *r, uint32_t row,
                                             uint32_t row_count, const float *const *self)
{
    glbk_box box = { 0, 0, 0, 0, 0, 0, 1 };
    glbk_sfield__allocator memory;
    uint32_t *words, layer, k, n;
    size_t count, i;
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__sfield_check_self(ctx, __func__, r);
    if (result != GLBK_OK) return result;
    if (!self) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "self", "is NULL");
    result = glbk__sfield_check_rows(ctx, __func__, r->height, row, row_count);
    if (result != GLBK_OK) return result;
    memory = glbk_sfield__memory(ctx);
    count = (size_t)r->width * row_count;
    n = r->bands * r->bands;
    words = (uint32_t *)glbk_sfield__alloc_array(&memory, count, 16);
    if (!words) return GLBK_ERR_ALLOC;
    box.y = row;
    box.width = r->width;
    box.height = row_count;
    for (layer = 0; 8 * layer < n && result == GLBK_OK; layer++) {
        memset(words, 0, 16 * count);
        for (i = 0; i < count; i++) {
            for (k = 0; k < 8 && 8 * layer + k < n && self[i]; k++)
                words[4 * i + k / 2] |= glbk__sfield_short(self[i][8 * layer + k]) << k % 2 * 16;
            if (!layer && self[i] && !(words[4 * i] & 0xffffu))
                words[4 * i] |= 1;      /* since 0 says that none was recorded */
        }
        box.layer = layer;
        result = glbk_texture_update(ctx, &r->self, &box, words);
    }
    glbk_sfield__free(&memory, words);
    return result;
}

/* Compiles the program for meshes as the G-buffer draws them, unless there is one. */
static glbk_result glbk__sfield_record(glbk_context *ctx, glbk_sfield_renderer *r, const glbk_attributes *at)
{
    static const char *const names[4] = { "GLBK_PLACE SFIELD_SELF0=", " SFIELD_SELF1=", " SFIELD_SELF2=",
                                          " SFIELD_SELF3=" };
    char defines[96];
    glbk_attributes place;
    glbk__sink sink;
    uint32_t i;

    if (r->record.name && r->record_vertex == at->vertex && r->record_position == at->position)
        return GLBK_OK;
    glbk_program_free(ctx, &r->record);
    r->record_vertex = at->vertex;
    r->record_position = at->position;
    place = *at;
    place.fragment = NULL;      /* the depth test leaves out holes */
    sink.out = defines;
    sink.bytes = sizeof defines;
    sink.used = 0;
    for (i = 0; i < 4; i++) {
        glbk__append_text(&sink, names[i]);
        glbk__sfield_number(&sink, r->self_attribute + i);
    }
    defines[sink.used] = 0;
    return glbk__drawing_program(ctx, glbk_sfield_part(), "sfield_self.frag", &place, defines, &r->record);
}

GLBK_DEF glbk_result glbk_sfield_self_begin(glbk_context *ctx, glbk_sfield_renderer *r, const glbk_gbuffer *g)
{
    static const float zero[4] = { 0, 0, 0, 0 };
    glbk_target_desc target;
    glbk_result result;
    glbk_pass pass;
    uint32_t i;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__sfield_check_self(ctx, __func__, r);
    if (result == GLBK_OK) result = glbk__sfield_check_gbuffer(ctx, __func__, r->width, r->height, g);
    if (result != GLBK_OK) return result;
    if (!g->has_depth || !g->has_clip)
        return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "gbuffer",
                            "was not drawn: its depth or matrix is not known");
    if (r->bands > 4)
        return glbk__refuse_value(ctx, GLBK_ERR_LIMIT, __func__, "the number of bands", r->bands,
                                  "1..4 to be drawn");
    if (!g->attributes.vertex && g->attributes.position >= (int32_t)r->self_attribute &&
        g->attributes.position < (int32_t)r->self_attribute + 4)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, __func__, "desc.self_attribute", r->self_attribute,
                                  "such that the position is in none of four attributes from it on");
    result = glbk__sfield_record(ctx, r, &g->attributes);
    memset(&target, 0, sizeof target);
    target.color[0] = target.color[1] = &r->self;
    target.layer[1] = 1;
    target.depth = &g->depth;
    if (result == GLBK_OK && !r->self_target.name)
        result = glbk__target_create(ctx, &target, &r->self_target);
    memset(&pass, 0, sizeof pass);
    pass.target = &r->self_target;
    pass.depth = GLBK_DEPTH_EQUAL;
    if (result == GLBK_OK) result = glbk_begin(ctx, &pass, &r->record);
    if (result == GLBK_OK)
        glbk__attach(ctx, GLBK_GL_DEPTH_ATTACHMENT, &g->depth, 0, 0);   /* since the buffer may be another */
    for (i = 0; i < 2 && result == GLBK_OK; i++) glbk_clear(ctx, &r->self_target, i, zero);
    memcpy(r->world_to_clip, g->world_to_clip, sizeof r->world_to_clip);
    return result;
}

GLBK_DEF glbk_result glbk_sfield_self_object(glbk_context *ctx, glbk_sfield_renderer *r,
                                             const float transform[16])
{
    glbk_sfield_object object;
    glbk_result result;
    int i, given = 0;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__sfield_check_self(ctx, __func__, r);
    if (result != GLBK_OK) return result;
    if (!transform) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "transform", "is NULL");
    if (!r->self_target.name)
        return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "renderer",
                            "was not begun: glbk_sfield_self_begin");
    memset(&object, 0, sizeof object);
    memcpy(object.transform, transform, sizeof object.transform);
    for (i = 0; i < 16; i++) given = given || transform[i] != 0;
    for (i = 0; i < 16 && !given; i += 5) object.transform[i] = 1;
    memcpy(object.clip, r->world_to_clip, sizeof object.clip);
    return glbk__put_block(ctx, GLBK_SLOT_glbk_sfield_object, &r->object, &object);
}

/* ==== src/gl_shadowfield/renderer.h ==== */

/* ---- sfield: the renderer: light of a scene at the pixels of a G-buffer ---- */

enum { GLBK__SFIELD_TERMS = 200 };      /* leaves room for the 163 of 4 bands */

/* Makes the textures of a size: light, gloss and grazing with their target, and self-visibility. */
static glbk_result glbk__sfield_textures(glbk_context *ctx, glbk_sfield_renderer *r, int gloss, int grazing,
                                         int self)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result;

    memset(&texture, 0, sizeof texture);
    memset(&target, 0, sizeof target);
    texture.width = r->width;
    texture.height = r->height;
    texture.format = GLBK_FORMAT_COLOR;
    result = glbk_texture_create(ctx, &texture, &r->light);
    target.color[0] = &r->light;
    if (gloss && result == GLBK_OK) {
        result = glbk_texture_create(ctx, &texture, &r->gloss);
        target.color[1] = &r->gloss;
    }
    if (grazing && result == GLBK_OK) {
        result = glbk_texture_create(ctx, &texture, &r->grazing);
        target.color[2] = &r->grazing;
    }
    if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &r->target);
    return result == GLBK_OK && self ? glbk__sfield_self_create(ctx, r) : result;
}

/* Appends "ARRAY[N]". */
static void glbk__sfield_index(glbk__sink *sink, const char *array, uint32_t n)
{
    glbk__append_text(sink, array);
    glbk__append_text(sink, "[");
    glbk__sfield_number(sink, n);
    glbk__append_text(sink, "]");
}

/* Appends "(a[i]*b[j]+a[j]*b[i])", or "(a[i]*b[i])" if i and j are the same. */
static void glbk__sfield_pair(glbk__sink *sink, uint32_t i, uint32_t j)
{
    glbk__sfield_index(sink, "(a", i);
    glbk__sfield_index(sink, "*b", j);
    if (i != j) {
        glbk__sfield_index(sink, "+a", j);
        glbk__sfield_index(sink, "*b", i);
    }
    glbk__append_text(sink, ")");
}

GLBK_DEF size_t glbk_sfield_write_product(const sfield_algebra *algebra, char *out, size_t out_bytes)
{
    static const char head[] =
        "void sfield_product(uvec2 terms, float a[SFIELD_COEFS], float b[SFIELD_COEFS], "
        "out float r[SFIELD_COEFS])\n{\nfloat s=0.0;\n";
    const uint32_t bands = algebra ? glbk__sfield_bands(algebra) : 0;
    uint32_t terms[GLBK__SFIELD_TERMS], k, e, count;
    float factors[GLBK__SFIELD_TERMS];
    glbk__sink sink;

    if (bands < 1 || bands > 4) return 0;
    count = (uint32_t)sfield_sh_terms(algebra, terms, factors);
    sink.out = out;
    sink.bytes = out ? out_bytes : 0;
    sink.used = 0;
    glbk__append_text(&sink, head);
    for (k = 0; k < bands * bands; k++) {
        glbk__sfield_index(&sink, "s+=a", k);
        glbk__sfield_index(&sink, "*b", k);
        glbk__append_text(&sink, ";\n");
        if (!k) continue;
        glbk__sfield_index(&sink, "r", k);
        glbk__append_text(&sink, "=SFIELD_Y00*");
        glbk__sfield_pair(&sink, 0, k);
        for (e = 0; e < count; e++) {
            uint32_t bits;
            if (terms[e] >> 16 != k) continue;
            memcpy(&bits, &factors[e], 4);      /* its bits are the same in every locale */
            glbk__append_text(&sink, "\n+uintBitsToFloat(");
            glbk__sfield_number(&sink, bits);
            glbk__append_text(&sink, "u)*");
            glbk__sfield_pair(&sink, terms[e] & 255u, terms[e] >> 8 & 255u);
        }
        glbk__append_text(&sink, ";\n");
    }
    glbk__append_text(&sink, "r[0]=SFIELD_Y00*s;\n}\n");
    if (sink.bytes) out[sink.used < sink.bytes ? sink.used : sink.bytes - 1] = 0;
    return sink.used + 1;
}

/* Compiles the pass's program with the product written out, which stands after sfield_field and before the
   functions that call it. */
static glbk_result glbk__sfield_compile(glbk_context *ctx, const sfield_algebra *algebra, const char *defines,
                                        int compute, glbk_program *out)
{
    const char *const names[] = { "lib/sfield_shade.glsl", "lib/sfield_point.glsl",
                                  compute ? "prog/sfield_shade.comp" : "prog/sfield_shade.frag" };
    glbk_sfield__allocator memory = glbk_sfield__memory(ctx);
    size_t product = glbk_sfield_write_product(algebra, NULL, 0);
    glbk_source source;
    glbk__sink sink = { NULL, 0, 0 };
    glbk_result result;
    uint32_t i;

    for (i = 0; i < 3; i++) glbk__append_file(&sink, glbk_find_file(glbk_sfield_part(), names[i]));
    sink.bytes = product + sink.used;
    sink.out = (char *)glbk_sfield__alloc(&memory, sink.bytes);
    if (!sink.out) return GLBK_ERR_ALLOC;
    glbk_sfield_write_product(algebra, sink.out, sink.bytes);
    sink.used = product - 1;
    for (i = 0; i < 3; i++) glbk__append_file(&sink, glbk_find_file(glbk_sfield_part(), names[i]));
    sink.out[sink.used] = 0;
    memset(&source, 0, sizeof source);
    source.parts[0] = glbk_sfield_part();
    source.parts[1] = glbk_gbuffer_part();
    *(compute ? &source.compute : &source.fragment) = sink.out;
    source.uses = compute ? "sfield_list sfield_brdf gbuffer" : "sfield_access sfield_brdf gbuffer";
    source.defines = defines;
    result = glbk_program_compile(ctx, &source, out);
    glbk_sfield__free(&memory, sink.out);
    return result;
}

/* Checks the desc of glbk_sfield_renderer_create. */
static glbk_result glbk__sfield_check_renderer(const glbk_context *ctx, const char *function,
                                               const glbk_sfield_renderer_desc *d)
{
    glbk_result result;
    if (!d) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "desc", "is NULL");
    if (!d->algebra) return glbk__refuse(ctx, GLBK_ERR_DESC, function, "desc.algebra", "is NULL");
    result = glbk__require_side(ctx, function, "desc.width", d->width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, function, "desc.height", d->height);
    if (result != GLBK_OK) return result;
    if (d->grazing && !d->materials)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, "desc.grazing", "is wanted without desc.materials");
    if (d->self_attribute > 12)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "desc.self_attribute", d->self_attribute, 0,
                                  12);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_sfield_renderer_create(glbk_context *ctx, const glbk_sfield_renderer_desc *d,
                                                 glbk_sfield_renderer *out)
{
    char defines[] = "SFIELD_BANDS=4 SFIELD_GLOSS=0 SFIELD_SELF=0 SFIELD_GRAZING=0 SFIELD_EXP=0 "
                     "SFIELD_UNROLLED";
    int unrolled;
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!out) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "out", "is NULL");
    memset(out, 0, sizeof *out);
    result = glbk__sfield_check_renderer(ctx, __func__, d);
    if (result != GLBK_OK) return result;
    out->width = d->width;
    out->height = d->height;
    out->bands = glbk__sfield_bands(d->algebra);
    out->compute = ctx->compute;
    unrolled = !d->product_in_table && out->bands < 5;
    if (!unrolled) defines[73] = 0;
    out->materials = d->materials != 0;
    out->logarithms = d->logarithms != 0;
    defines[13] = (char)('0' + out->bands);
    defines[28] = d->materials ? '2' : d->gloss ? '1' : '0';
    defines[42] = d->self ? '1' : '0';
    defines[59] = d->grazing ? '1' : '0';
    defines[72] = d->logarithms ? '1' : '0';
    out->self_attribute = d->self_attribute ? d->self_attribute : 4;
    result = glbk__sfield_textures(ctx, out, d->gloss || d->materials, d->grazing, d->self);
    if (result == GLBK_OK)
        result = unrolled ? glbk__sfield_compile(ctx, d->algebra, defines, out->compute, &out->shade)
                          : glbk__gbuffer_program(ctx, glbk_sfield_part(),
                                                  out->compute ? "sfield_shade.comp" : "sfield_shade.frag",
                                                  defines, &out->shade);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_sfield_frame), NULL, &out->frame);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_sfield_object), NULL, &out->object);
    if (result != GLBK_OK) glbk_sfield_renderer_free(ctx, out);
    return result;
}

static void glbk__sfield_free_textures(glbk_context *ctx, glbk_sfield_renderer *r)
{
    glbk_target_free(ctx, &r->target);
    glbk_target_free(ctx, &r->self_target);
    glbk_texture_free(ctx, &r->light);
    glbk_texture_free(ctx, &r->gloss);
    glbk_texture_free(ctx, &r->grazing);
    glbk_texture_free(ctx, &r->self);
}

GLBK_DEF glbk_result glbk_sfield_renderer_resize(glbk_context *ctx, glbk_sfield_renderer *r, uint32_t width,
                                                 uint32_t height)
{
    const int gloss = r && r->gloss.name, grazing = r && r->grazing.name, self = r && r->self.name;
    glbk_result result = glbk__require_created(ctx, __func__, "renderer", r ? &r->target.name : NULL);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "width", width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "height", height);
    if (result != GLBK_OK) return result;
    glbk__sfield_free_textures(ctx, r);
    r->width = width;
    r->height = height;
    result = glbk__sfield_textures(ctx, r, gloss, grazing, self);
    if (result != GLBK_OK) glbk_sfield_renderer_free(ctx, r);
    return result;
}

GLBK_DEF void glbk_sfield_renderer_free(glbk_context *ctx, glbk_sfield_renderer *r)
{
    if (!r) return;
    glbk_program_free(ctx, &r->shade);
    glbk_program_free(ctx, &r->record);
    glbk__sfield_free_textures(ctx, r);
    glbk_buffer_free(ctx, &r->frame);
    glbk_buffer_free(ctx, &r->object);
    memset(r, 0, sizeof *r);
}

GLBK_DEF glbk_result glbk_sfield_shade(glbk_context *ctx, glbk_sfield_renderer *r, const glbk_gbuffer *g,
                                       const glbk_sfield_scene *s, const float eye[3], int open)
{
    glbk_sfield_frame frame;
    glbk_sfield_contents contents;
    glbk_pass pass;
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!r || !r->shade.name)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "renderer", r ? "was not created" : "is NULL");
    result = glbk__sfield_check_scene(ctx, __func__, s);
    if (result == GLBK_OK) result = glbk__sfield_check_gbuffer(ctx, __func__, r->width, r->height, g);
    if (result != GLBK_OK) return result;
    if (!eye && g->has_clip) eye = g->eye;
    if (r->gloss.name && !eye)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "eye",
                            "is NULL: lobes need it, and the G-buffer has none");
    if (s->cube_side) return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "scene", "has wavelets");
    if (s->bands != r->bands)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, __func__, "scene->bands", s->bands,
                                  "that of the renderer");
    if (r->materials && !s->has_brdf)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "scene",
                            "has no desc.brdf, which the renderer's materials need");
    if (!r->logarithms != !s->logarithms)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "scene",
                            r->logarithms ? "has no logarithms, which desc.logarithms says"
                                          : "has fields of logarithms, without desc.logarithms");
    memset(&frame, 0, sizeof frame);
    memset(&pass, 0, sizeof pass);
    if (eye) memcpy(frame.eye, eye, 12);
    contents = glbk__sfield_contents_of(s, s->sky || open);
    result = glbk__put_block(ctx, GLBK_SLOT_glbk_sfield_frame, &r->frame, &frame);
    if (result == GLBK_OK)
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_sfield_contents, &s->contents, &contents);
    pass.target = &r->target;
    if (result == GLBK_OK && !r->compute) result = glbk_begin(ctx, &pass, &r->shade);
    if (result != GLBK_OK) return result;
    glbk_sfield_bind(ctx, s, NULL);
    result = glbk_gbuffer_bind(ctx, g, NULL);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_sfield_self, &r->self);
    if (r->compute) {
        glbk_bind_image(ctx, GLBK_SLOT_glbk_sfield_light_image, &r->light);
        glbk_bind_image(ctx, GLBK_SLOT_glbk_sfield_gloss_image, &r->gloss);
        glbk_bind_image(ctx, GLBK_SLOT_glbk_sfield_grazing_image, &r->grazing);
        return glbk_dispatch(ctx, &r->shade, (r->width + 7) / 8, (r->height + 7) / 8, 1);
    }
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_sfield_read(glbk_context *ctx, glbk_sfield_renderer *r, float *light, float *gloss)
{
    glbk_result result = GLBK_OK;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!r || !r->target.name)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "renderer", r ? "was not created" : "is NULL");
    if (gloss && !r->gloss.name)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "gloss",
                            "is asked of a renderer without desc.gloss");
    if (light) result = glbk_target_read(ctx, &r->target, 0, 0, 0, r->width, r->height, light);
    if (gloss && result == GLBK_OK)
        result = glbk_target_read(ctx, &r->target, 1, 0, 0, r->width, r->height, gloss);
    return result;
}

/* ==== src/gl_shadowfield/building.h ==== */

/* ---- sfield: building: meshes, textures and programs ---- */

enum {
    GLBK__SFIELD_TILES = 256,       /* the most tiles of an atlas, as the uniform block has them */
    GLBK__SFIELD_BATCH = 128,       /* the most eyes */
    GLBK__SFIELD_VERTEX_ARRAY_BINDING = 0x85B5,     /* a constant of GL, like the next one */
    GLBK__SFIELD_ARRAY_BUFFER_BINDING = 0x8894
};

/* Returns how many numbers an eye has in a channel: coefficients, or texels of a cube. */
static size_t glbk__sfield_values(const glbk_sfield_builder *b)
{
    return b->bands ? (size_t)b->bands * b->bands : (size_t)6 * b->side * b->side;
}

/* Returns how many corners all triangles have. glbk__sfield_mesh_index returns the vertex of a corner,
   glbk__sfield_vertex the place of a vertex. */
static size_t glbk__sfield_mesh_corners(const sfield_mesh *m)
{
    return m->indices || m->indices16 ? m->index_count : m->vertex_count;
}

static uint32_t glbk__sfield_mesh_index(const sfield_mesh *m, size_t i)
{
    return m->indices ? m->indices[i] : m->indices16 ? m->indices16[i] : (uint32_t)i;
}

static const float *glbk__sfield_vertex(const sfield_mesh *m, size_t i)
{
    size_t stride = m->vertex_stride ? m->vertex_stride : 12;
    return (const float *)(const void *)((const char *)(const void *)m->positions + i * stride);
}

/* Writes the corners of triangle t, whose indices are in range. Returns 0 if sfield_build would skip it. */
static int glbk__sfield_corners(const sfield_mesh *m, size_t t, uint32_t corner[3])
{
    int i, k;
    for (i = 0; i < 3; i++) {
        const float *p;
        corner[i] = glbk__sfield_mesh_index(m, 3 * t + (size_t)i);
        p = glbk__sfield_vertex(m, corner[i]);
        for (k = 0; k < 3; k++)
            if (!(fabsf(p[k]) < 1e18f)) return 0;
    }
    return 1;
}

/* Fits the sphere by which faces are chosen. Returns 0 if no triangle can be used. */
static int glbk__sfield_fit(const sfield_mesh *m, glbk_sfield_builder *b)
{
    const size_t triangles = glbk__sfield_mesh_corners(m) / 3;
    float low[3] = { 2e18f, 2e18f, 2e18f }, high[3] = { -2e18f, -2e18f, -2e18f }, r2 = 0;
    uint32_t corner[3];
    size_t t;
    int pass, i, k;
    for (pass = 0; pass < 2; pass++) {
        for (t = 0; t < triangles; t++) {
            if (!glbk__sfield_corners(m, t, corner)) continue;
            for (i = 0; i < 3; i++) {
                const float *p = glbk__sfield_vertex(m, corner[i]);
                float sum = 0;
                for (k = 0; k < 3; k++) {
                    low[k] = p[k] < low[k] ? p[k] : low[k];
                    high[k] = p[k] > high[k] ? p[k] : high[k];
                    sum += (p[k] - b->center[k]) * (p[k] - b->center[k]);
                }
                r2 = pass && sum > r2 ? sum : r2;
            }
        }
        for (k = 0; k < 3; k++) b->center[k] = 0.5f * low[k] + 0.5f * high[k];
    }
    b->radius = sqrtf(r2);
    return low[0] <= high[0];
}

/* Uploads vertices and the indices of usable triangles; of sources, three corners with their radiance for
   each triangle. */
static glbk_result glbk__sfield_upload_mesh(glbk_context *ctx, const glbk_sfield_builder_desc *d,
                                            glbk_sfield_builder *b)
{
    const sfield_mesh *m = d->mesh;
    const size_t triangles = glbk__sfield_mesh_corners(m) / 3;
    glbk_sfield__allocator memory = glbk_sfield__memory(ctx);
    const size_t vertices = d->source ? 3 * triangles : m->vertex_count, floats = d->source ? 6 : 3;
    size_t t, i, n = 0;
    float *vertex = (float *)glbk_sfield__alloc_array(&memory, vertices, floats * sizeof *vertex),
          *v = vertex;
    uint32_t *index = (uint32_t *)glbk_sfield__alloc_array(&memory, triangles, 3 * sizeof *index), corner[3];
    glbk_result result = vertex && index ? GLBK_OK : GLBK_ERR_ALLOC;

    for (i = 0; i < vertices && !d->source && result == GLBK_OK; i++)
        memcpy(vertex + 3 * i, glbk__sfield_vertex(m, i), 12);
    for (t = 0; t < triangles && result == GLBK_OK; t++) {
        if (!glbk__sfield_corners(m, t, corner)) continue;
        for (i = 0; i < 3; i++, n++) {
            index[n] = d->source ? (uint32_t)n : corner[i];
            if (!d->source) continue;
            memcpy(v, glbk__sfield_vertex(m, corner[i]), 12);
            memcpy(v + 3, d->radiance + 3 * t, 12);
            v += 6;
        }
    }
    b->index_count = (uint32_t)n;
    if (result == GLBK_OK)
        result = glbk_buffer_create(ctx, vertices * floats * sizeof *vertex, vertex, &b->vertices);
    if (result == GLBK_OK) result = glbk_indices_create(ctx, n * sizeof *index, index, &b->indices);
    glbk_sfield__free(&memory, vertex);
    glbk_sfield__free(&memory, index);
    return result;
}

/* Makes the vertex array of the mesh, and leaves GL's state as it was. */
static glbk_result glbk__sfield_vertex_array(glbk_context *ctx, glbk_sfield_builder *b)
{
    int32_t array = 0, buffer = 0, stride = b->source ? 24 : 12;
    glbk_result result = glbk__enter(ctx);

    if (result != GLBK_OK) return result;
    ctx->gl.GetIntegerv(GLBK__SFIELD_VERTEX_ARRAY_BINDING, &array);
    ctx->gl.GetIntegerv(GLBK__SFIELD_ARRAY_BUFFER_BINDING, &buffer);
    ctx->gl.GenVertexArrays(1, &b->vertex_array);
    ctx->gl.BindVertexArray(b->vertex_array);
    ctx->gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, b->vertices.name);
    ctx->gl.BindBuffer(GLBK_GL_ELEMENT_ARRAY_BUFFER, b->indices.name);
    ctx->gl.EnableVertexAttribArray(0);
    ctx->gl.VertexAttribPointer(0, 3, GLBK_GL_FLOAT, 0, stride, NULL);
    if (b->source) {
        ctx->gl.EnableVertexAttribArray(1);
        ctx->gl.VertexAttribPointer(1, 3, GLBK_GL_FLOAT, 0, stride, (const void *)(size_t)12);
    }
    ctx->gl.BindVertexArray((uint32_t)array);
    ctx->gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, (uint32_t)buffer);
    return glbk__leave(ctx);
}

/* Checks a mesh as sfield_build does. */
static glbk_result glbk__sfield_check_mesh(const glbk_context *ctx, const char *function,
                                           const sfield_mesh *m)
{
    const size_t corners = glbk__sfield_mesh_corners(m);
    const char *count = m->indices || m->indices16 ? "mesh.index_count" : "mesh.vertex_count";
    glbk_sfield__logger log;
    size_t i;

    if (!m->positions) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "mesh.positions", "is NULL");
    if (m->indices && m->indices16)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "mesh.indices",
                            "and mesh.indices16 are both given");
    if (m->mask_fn)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "mesh.mask_fn",
                            "is set: the GPU cannot call it, and draw_fn draws masks");
    if (!glbk_sfield__stride_valid(m->vertex_stride, 12))
        return glbk__refuse_value(ctx, GLBK_ERR_ARGUMENT, function, "mesh.vertex_stride",
                                  (double)m->vertex_stride, "0, or a multiple of 4 of at least 12");
    if (!corners || corners % 3)
        return glbk__refuse_value(ctx, GLBK_ERR_ARGUMENT, function, count, (double)corners,
                                  "a multiple of 3, > 0");
    if (corners > 0x7fffffffu)
        return glbk__refuse_value(ctx, GLBK_ERR_LIMIT, function, count, (double)corners, "below 2^31");
    if (m->vertex_count > 0xffffffffu)
        return glbk__refuse_value(ctx, GLBK_ERR_LIMIT, function, "mesh.vertex_count", (double)m->vertex_count,
                                  "below 2^32");
    log.log = ctx->system.log;
    log.user = ctx->system.user;
    log.function = function;
    for (i = 0; i < corners; i++) {
        const uint32_t index = glbk__sfield_mesh_index(m, i);
        if (index < m->vertex_count) continue;
        glbk_sfield__log_index(&log, "mesh", i, index, m->vertex_count);
        return GLBK_ERR_INPUT;
    }
    return GLBK_OK;
}

/* Checks and uploads the mesh of a builder. */
static glbk_result glbk__sfield_take_mesh(glbk_context *ctx, const char *function,
                                          const glbk_sfield_builder_desc *d, glbk_sfield_builder *b)
{
    glbk_result result = glbk__sfield_check_mesh(ctx, function, d->mesh);
    glbk_sfield__message name;
    size_t i;

    if (result != GLBK_OK) return result;
    for (i = 0; d->source && i < glbk__sfield_mesh_corners(d->mesh); i++)
        if (!(d->radiance[i] >= 0 && d->radiance[i] <= 1e18f))
            return glbk__refuse_value(ctx, GLBK_ERR_INPUT, function,
                                      glbk__sfield_name(&name, "desc.radiance", i, ""),
                                      (double)d->radiance[i], "0..1e18");
    if (!glbk__sfield_fit(d->mesh, b))
        return glbk__refuse(ctx, GLBK_ERR_INPUT, function, "mesh", "has no triangle that can be used");
    result = glbk__sfield_upload_mesh(ctx, d, b);
    return result == GLBK_OK ? glbk__sfield_vertex_array(ctx, b) : result;
}

/* Returns where texel (face, x, y) of a cube stands in the order of shadowfield.h. */
static uint32_t glbk__sfield_morton(uint32_t side, uint32_t face, uint32_t x, uint32_t y)
{
    uint32_t morton = 0, bit;
    for (bit = 0; bit < 6; bit++) morton |= (x >> bit & 1u) << 2 * bit | (y >> bit & 1u) << (2 * bit + 1);
    return face * side * side + morton;
}

/* Uploads the integrals of the basis over each texel (sfield_cube_basis): groups of four coefficients, each
   with all texels in rows as the cubes have them. */
static glbk_result glbk__sfield_upload_basis(glbk_context *ctx, glbk_sfield_builder *b)
{
    glbk_sfield__allocator memory = glbk_sfield__memory(ctx);
    const uint32_t n = b->bands * b->bands, side = b->side, cells = 6 * side * side;
    float *table = (float *)glbk_sfield__alloc_array(&memory, (size_t)cells * b->groups, 16),
          of[SFIELD_MAX_COEFS];
    uint32_t face, x, y, k;
    glbk_result result;

    if (!table) return GLBK_ERR_ALLOC;
    memset(table, 0, (size_t)cells * b->groups * 16);
    for (y = 0; y < side; y++)
        for (face = 0; face < 6; face++)
            for (x = 0; x < side; x++) {
                size_t at = (size_t)y * 6 * side + face * side + x;
                (void)sfield_cube_basis(b->bands, side, glbk__sfield_morton(side, face, x, y), of);
                for (k = 0; k < n; k++) table[4 * (at + (size_t)(k / 4) * cells) + k % 4] = of[k];
            }
    result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, table, (size_t)cells * b->groups, &b->basis);
    glbk_sfield__free(&memory, table);
    return result;
}

/* Makes the textures that a builder draws to. */
static glbk_result glbk__sfield_canvases(glbk_context *ctx, glbk_sfield_builder *b)
{
    const uint32_t size = !b->source && ctx->max_side >= 2048 ? 2048u : 1024u, channels = b->source ? 3 : 1;
    glbk_texture_desc depth;
    glbk_result result = GLBK_OK;

    memset(&depth, 0, sizeof depth);
    depth.format = GLBK_FORMAT_DEPTH32F;
    depth.width = depth.height = b->height = size;
    if (b->source) result = glbk_texture_create(ctx, &depth, &b->depth);
    if (result == GLBK_OK)
        result = glbk__canvas(ctx, b->source ? GLBK_FORMAT_RGBA32UI : GLBK_FORMAT_R8UI, size, size,
                              b->source ? &b->depth : NULL, &b->seen, &b->seen_target);
    b->batch = (ctx->max_side >= 2048 ? 2048 : 1024) / b->side;
    b->batch = b->batch < GLBK__SFIELD_BATCH ? b->batch : (uint32_t)GLBK__SFIELD_BATCH;
    if (result == GLBK_OK)
        result = glbk__canvas(ctx, GLBK_FORMAT_RGBA32UI, 6 * b->side / (b->source ? 1 : 4),
                              b->batch * b->side, NULL, &b->cube, &b->cube_target);
    if (result == GLBK_OK && b->bands)
        result = glbk__canvas(ctx, GLBK_FORMAT_RGBA32UI, b->groups * channels, b->batch, NULL, &b->coefs,
                              &b->coef_target);
    return result;
}

/* Checks a desc and copies it into the builder, with the defaults of sfield_desc. */
static glbk_result glbk__sfield_read_builder(const glbk_context *ctx, const char *function,
                                             const glbk_sfield_builder_desc *d, glbk_sfield_builder *b)
{
    const glbk_result bad = GLBK_ERR_DESC;
    sfield_desc f;
    int haar;

    if (!d) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "desc", "is NULL");
    memset(&f, 0, sizeof f);
    if (d->field) f = *d->field;
    haar = f.basis == SFIELD_BASIS_HAAR;
    if ((uint32_t)f.basis > SFIELD_BASIS_HAAR)
        return glbk__refuse_range(ctx, bad, function, "desc.field->basis", (double)f.basis, 0,
                                  SFIELD_BASIS_HAAR);
    if (f.bands > SFIELD_MAX_BANDS)
        return glbk__refuse_range(ctx, bad, function, "desc.field->bands", f.bands, 0, SFIELD_MAX_BANDS);
    if (f.cube_side && (f.cube_side < 4 || f.cube_side > 64 || (f.cube_side & (f.cube_side - 1))))
        return glbk__refuse_value(ctx, bad, function, "desc.field->cube_side", f.cube_side,
                                  "0 or a power of two of 4..64");
    if (!d->mesh && !d->draw_fn)
        return glbk__refuse(ctx, bad, function, "desc.mesh", "is NULL, like desc.draw_fn");
    if (d->mesh && d->source && !d->radiance)
        return glbk__refuse(ctx, bad, function, "desc.radiance", "is NULL");
    if (d->mesh && d->source && f.frame_count > 1)
        return glbk__refuse_value(ctx, bad, function, "desc.field->frame_count", f.frame_count,
                                  "0 or 1 with a mesh: other frames are drawn by draw_fn");
    b->side = f.cube_side ? f.cube_side : haar ? 32 : 16;
    b->bands = haar ? 0 : f.bands ? f.bands : 4;
    b->groups = (b->bands * b->bands + 3) / 4;
    b->source = d->source != 0;
    b->draw_fn = d->mesh ? NULL : d->draw_fn;
    b->user = d->user;
    b->compute = ctx->compute;
    return GLBK_OK;
}

/* Compiles the program that draws what a builder sees; the library draws a mesh with attributes of its
   own. */
static glbk_result glbk__sfield_see_program(glbk_context *ctx, const glbk_sfield_builder_desc *d,
                                            glbk_sfield_builder *b)
{
    static const char function[] = "glbk_sfield_builder_create";
    const uint32_t radiance = d->radiance_attribute && !d->mesh ? d->radiance_attribute : 1;
    char more[60];
    glbk_attributes at;
    glbk__sink sink;
    glbk_result result = glbk__take_attributes(ctx, function, &d->attributes, &at);

    if (result != GLBK_OK) return result;
    if (radiance > 15)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "desc.radiance_attribute", radiance, 0, 15);
    if (d->mesh) {
        memset(&at, 0, sizeof at);
        at.normal = at.uv = at.tangent = -1;
    }
    if (b->source && !at.vertex && (uint32_t)at.position == radiance)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.radiance_attribute", radiance,
                                  "other than desc.attributes.position");
    sink.out = more;
    sink.bytes = sizeof more;
    sink.used = 0;
    glbk__append_text(&sink, b->source ? "SFIELD_SOURCE=1" : "SFIELD_SOURCE=0");
    glbk__append_text(&sink, " GLBK_PLACE SFIELD_RADIANCE=");
    glbk__sfield_number(&sink, radiance);
    more[sink.used] = 0;
    return glbk__drawing_program(ctx, glbk_sfield_part(), "sfield_see.frag", &at, more, &b->see);
}

/* Compiles the programs of a builder. */
static glbk_result glbk__sfield_builder_programs(glbk_context *ctx, const glbk_sfield_builder_desc *d,
                                                 glbk_sfield_builder *b)
{
    char defines[] = "SFIELD_SOURCE=0 SFIELD_BANDS=0";
    glbk_result result = glbk__sfield_see_program(ctx, d, b);

    defines[14] = b->source ? '1' : '0';
    defines[29] = (char)('0' + b->bands);
    if (result == GLBK_OK)
        result = glbk__program_create(ctx, glbk_sfield_part(),
                                      b->compute ? "sfield_sum.comp" : "sfield_sum.frag", defines, &b->sum);
    if (result == GLBK_OK && b->bands)
        result = glbk__program_create(ctx, glbk_sfield_part(),
                                      b->compute ? "sfield_project.comp" : "sfield_project.frag", defines,
                                      &b->project);
    return result;
}

GLBK_DEF glbk_result glbk_sfield_builder_create(glbk_context *ctx, const glbk_sfield_builder_desc *d,
                                                glbk_sfield_builder *out)
{
    const glbk_texture *last;
    glbk_sfield__allocator memory;
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!out) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "out", "is NULL");
    memset(out, 0, sizeof *out);
    result = glbk__sfield_read_builder(ctx, __func__, d, out);
    if (result == GLBK_OK && d->mesh) result = glbk__sfield_take_mesh(ctx, __func__, d, out);
    if (result == GLBK_OK && out->bands) result = glbk__sfield_upload_basis(ctx, out);
    if (result == GLBK_OK) result = glbk__sfield_canvases(ctx, out);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_sfield_views), NULL, &out->block);
    if (result == GLBK_OK) result = glbk__sfield_builder_programs(ctx, d, out);
    if (result == GLBK_OK) {
        last = out->bands ? &out->coefs : &out->cube;
        memory = glbk_sfield__memory(ctx);
        out->views = (glbk_sfield_views *)glbk_sfield__alloc(&memory, sizeof *out->views);
        out->words = (uint32_t *)glbk_sfield__alloc_array(&memory, (size_t)last->width * last->height, 16);
        if (!out->views || !out->words) result = GLBK_ERR_ALLOC;
    }
    if (result != GLBK_OK) glbk_sfield_builder_free(ctx, out);
    return result;
}

GLBK_DEF void glbk_sfield_builder_free(glbk_context *ctx, glbk_sfield_builder *b)
{
    if (!b) return;
    if (ctx && !ctx->lost && b->vertex_array) ctx->gl.DeleteVertexArrays(1, &b->vertex_array);
    glbk_buffer_free(ctx, &b->vertices);
    glbk_buffer_free(ctx, &b->indices);
    glbk_buffer_free(ctx, &b->block);
    glbk_target_free(ctx, &b->seen_target);
    glbk_target_free(ctx, &b->cube_target);
    glbk_target_free(ctx, &b->coef_target);
    glbk_texture_free(ctx, &b->seen);
    glbk_texture_free(ctx, &b->depth);
    glbk_texture_free(ctx, &b->cube);
    glbk_texture_free(ctx, &b->coefs);
    glbk_texture_free(ctx, &b->basis);
    glbk_program_free(ctx, &b->see);
    glbk_program_free(ctx, &b->sum);
    glbk_program_free(ctx, &b->project);
    if (ctx) {
        glbk_sfield__allocator memory = glbk_sfield__memory(ctx);
        glbk_sfield__free(&memory, b->views);
        glbk_sfield__free(&memory, b->words);
    }
    memset(b, 0, sizeof *b);
}

/* ==== src/gl_shadowfield/seeing.h ==== */

/* ---- sfield: building: views from sample points ---- */

/* Returns the samples a side of a face for an eye, which lie as close as those of sfield_build. */
static uint32_t glbk__sfield_width(const glbk_sfield_builder *b, const float *eye)
{
    float d = sqrtf(eye[0] * eye[0] + eye[1] * eye[1] + eye[2] * eye[2]);
    uint32_t most = b->source ? 256 : 512, width;
    if (most > 64 * b->side) most = 64 * b->side;
    for (width = 64; width < most && ((float)width < 24 * d || width < 2 * b->side);) width *= 2;
    return width;
}

/* Returns 1 if a sphere, whose centre is given in radii from the eye, may reach into the pyramid of a face.
   In doubt the result is 1, since a face that is drawn in vain costs time only. */
static int glbk__sfield_faces(const float *center, float radius, uint32_t face)
{
    uint32_t axis = face / 2, k;
    float along = face % 2 ? -center[axis] : center[axis], reach = 1.001f * radius * 1.41421356f;
    if (along < -1.001f * radius) return 0;
    for (k = 0; k < 3; k++)
        if (k != axis && fabsf(center[k]) - along > reach) return 0;
    return 1;
}

/* Draws the tiles of one atlas, column by column, and counts their samples into the cubes. */
static glbk_result glbk__sfield_draw_tiles(glbk_context *ctx, glbk_sfield_builder *b, uint32_t tiles)
{
    static const float none[4] = { 0, 0, 0, 0 };
    const uint32_t width = b->views->width, rows = b->views->rows;
    glbk_pass pass;
    glbk_result result;
    uint32_t first;

    memset(&pass, 0, sizeof pass);
    pass.target = &b->seen_target;
    pass.depth = b->source ? GLBK_DEPTH_LESS : GLBK_DEPTH_OFF;
    pass.viewport[2] = (int32_t)width;
    pass.viewport[3] = (int32_t)(rows * width);
    for (first = 0; first < tiles; first += rows) {
        const int32_t count = (int32_t)(tiles - first < rows ? tiles - first : rows);
        b->views->first_tile = first;
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_sfield_views, &b->block, b->views);
        pass.viewport[0] = (int32_t)(first / rows * width);
        if (result == GLBK_OK) result = glbk_begin(ctx, &pass, &b->see);
        if (result != GLBK_OK) return result;
        if (!first) {
            glbk_clear(ctx, &b->seen_target, 0, none);
            if (b->source) glbk_clear_depth(ctx, 1);
        }
        if (b->draw_fn) b->draw_fn(b->user, ctx, count);
        else {
            ctx->gl.BindVertexArray(b->vertex_array);
            ctx->gl.DrawElementsInstanced(GLBK_GL_TRIANGLES, (int32_t)b->index_count, GLBK_GL_UNSIGNED_INT,
                                          NULL, count);
        }
    }
    memset(&pass, 0, sizeof pass);
    pass.target = &b->cube_target;
    result = b->compute ? GLBK_OK : glbk_begin(ctx, &pass, &b->sum);
    if (result != GLBK_OK) return result;
    glbk_bind_block(ctx, GLBK_SLOT_glbk_sfield_views, &b->block);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_sfield_seen, &b->seen);
    if (b->compute) {
        glbk_bind_image(ctx, GLBK_SLOT_glbk_sfield_cube_image, &b->cube);
        return glbk_dispatch(ctx, &b->sum, b->side, tiles, 1);
    }
    ctx->gl.DrawArraysInstanced(GLBK_GL_TRIANGLE_STRIP, 0, 4, (int32_t)tiles);
    return GLBK_OK;
}

/* Draws the cubes of a batch of eyes that take tiles of one width. Faces that see nothing are not drawn. */
static glbk_result glbk__sfield_draw_cubes(glbk_context *ctx, glbk_sfield_builder *b, uint32_t count,
                                           const float *eyes)
{
    static const float none[4] = { 0, 0, 0, 0 };
    glbk_sfield_views *v = b->views;
    const uint32_t width = v->width, rows = b->height / width;
    uint32_t most = rows * rows < GLBK__SFIELD_TILES ? rows * rows : (uint32_t)GLBK__SFIELD_TILES;
    uint32_t tiles = 0, i, face, k;
    glbk_pass pass;
    glbk_result result;

    memset(&pass, 0, sizeof pass);
    pass.target = &b->cube_target;
    result = glbk_begin(ctx, &pass, &b->see);
    if (result != GLBK_OK) return result;
    glbk_clear(ctx, &b->cube_target, 0, none);
    v->rows = rows;
    for (i = 0; i < count && result == GLBK_OK; i++) {
        const float *eye = eyes + 3 * (size_t)i;
        float center[3] = { 0, 0, 0 }, radius = 1, far_depth = 0;
        for (k = 0; k < 3; k++) {
            if (!b->draw_fn) center[k] = (b->center[k] - v->sphere[k]) / v->sphere[3];
            center[k] -= eye[k];
            far_depth += center[k] * center[k];
        }
        if (!b->draw_fn) radius = b->radius / v->sphere[3];
        far_depth = 1.001f * (sqrtf(far_depth) + radius);
        for (face = 0; face < 6 && result == GLBK_OK; face++) {
            float *at = v->eyes + 4 * (size_t)tiles;
            uint32_t *place = v->places + 4 * (size_t)tiles;
            if (!glbk__sfield_faces(center, radius, face)) continue;
            memcpy(at, eye, 12);
            at[3] = 1 / far_depth;
            place[0] = face;
            place[1] = i;
            place[2] = tiles / rows;
            place[3] = tiles % rows;
            if (++tiles < most) continue;
            result = glbk__sfield_draw_tiles(ctx, b, tiles);
            tiles = 0;
        }
    }
    return result == GLBK_OK && tiles ? glbk__sfield_draw_tiles(ctx, b, tiles) : result;
}

/* Projects the cubes of a batch and reads the coefficients back. */
static glbk_result glbk__sfield_read_coefs(glbk_context *ctx, glbk_sfield_builder *b, uint32_t count,
                                           float *values)
{
    const uint32_t n = b->bands * b->bands, channels = b->source ? 3 : 1, width = b->groups * channels;
    uint32_t i, c;
    glbk_pass pass;
    glbk_result result = GLBK_OK;

    memset(&pass, 0, sizeof pass);
    pass.target = &b->coef_target;
    pass.viewport[2] = (int32_t)width;
    pass.viewport[3] = (int32_t)count;
    if (!b->compute) result = glbk_begin(ctx, &pass, &b->project);
    if (result != GLBK_OK) return result;
    glbk_bind_block(ctx, GLBK_SLOT_glbk_sfield_views, &b->block);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_sfield_cube, &b->cube);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_sfield_basis, &b->basis);
    if (b->compute) {
        glbk_bind_image(ctx, GLBK_SLOT_glbk_sfield_coefs_image, &b->coefs);
        result = glbk_dispatch(ctx, &b->project, count, channels, 1);
    } else glbk_draw_screen(ctx);
    if (result == GLBK_OK) result = glbk_target_read(ctx, &b->coef_target, 0, 0, 0, width, count, b->words);
    for (i = 0; i < count && result == GLBK_OK; i++)
        for (c = 0; c < channels; c++, values += n)
            memcpy(values, b->words + 4 * ((size_t)i * width + c * b->groups), n * sizeof *values);
    return result;
}

/* Copies a row of a face's texels to the values of an eye, channel by channel. */
static void glbk__sfield_copy_row(const glbk_sfield_builder *b, const uint32_t *row, uint32_t face,
                                  uint32_t y, float *values)
{
    const uint32_t channels = b->source ? 3 : 1, words = b->source ? 4 : 1;
    const size_t cells = (size_t)6 * b->side * b->side;
    uint32_t x, c;
    for (x = 0; x < b->side; x++)
        for (c = 0; c < channels; c++)
            memcpy(values + c * cells + glbk__sfield_morton(b->side, face, x, y), row + x * words + c,
                   sizeof *values);
}

/* Reads the texels of the cubes of a batch back. */
static glbk_result glbk__sfield_read_texels(glbk_context *ctx, glbk_sfield_builder *b, uint32_t count,
                                            float *values)
{
    const uint32_t side = b->side, words = b->source ? 4 : 1;
    const size_t numbers = glbk__sfield_values(b) * (b->source ? 3u : 1u);
    uint32_t i, face, y;
    const uint32_t *from = b->words;
    glbk_result result =
        glbk_target_read(ctx, &b->cube_target, 0, 0, 0, b->cube.width, count * side, b->words);

    for (i = 0; i < count && result == GLBK_OK; i++, values += numbers)
        for (y = 0; y < side; y++)
            for (face = 0; face < 6; face++, from += side * words)
                glbk__sfield_copy_row(b, from, face, y, values);
    return result;
}

/* Checks the arguments of glbk_sfield_builder_see. */
static glbk_result glbk__sfield_check_views(const glbk_context *ctx, const char *function,
                                            const glbk_sfield_builder *b, const sfield_views *v)
{
    glbk_sfield__message name;
    size_t i;
    if (!b || !b->words)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "builder", b ? "was not created" : "is NULL");
    if (!v || !v->eyes || !v->values)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function,
                            !v         ? "views"
                            : !v->eyes ? "views.eyes"
                                       : "views.values",
                            "is NULL");
    if (!v->count) return glbk__refuse_value(ctx, GLBK_ERR_ARGUMENT, function, "views.count", 0, "> 0");
    if (!(v->radius > 0) || !glbk_sfield__finite(v->radius))
        return glbk__refuse_value(ctx, GLBK_ERR_INPUT, function, "views.radius", (double)v->radius,
                                  "> 0 and finite");
    for (i = 0; i < 3; i++)
        if (!glbk_sfield__finite(v->center[i]))
            return glbk__refuse_value(ctx, GLBK_ERR_INPUT, function,
                                      glbk__sfield_name(&name, "views.center", i, ""),
                                      (double)v->center[i], "finite");
    for (i = 0; i < 3 * v->count; i++)
        if (!(fabsf(v->eyes[i]) < 1e6f))
            return glbk__refuse_value(ctx, GLBK_ERR_INPUT, function,
                                      glbk__sfield_name(&name, "views.eyes", i, ""), (double)v->eyes[i],
                                      "-1e6..1e6");
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_sfield_builder_see(glbk_context *ctx, glbk_sfield_builder *b, const sfield_views *v)
{
    float *values;
    size_t from;
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__sfield_check_views(ctx, __func__, b, v);
    if (result != GLBK_OK) return result;
    values = v->values;
    memset(b->views, 0, sizeof *b->views);
    memcpy(b->views->sphere, v->center, sizeof v->center);
    b->views->sphere[3] = v->radius;
    b->views->side = b->side;
    b->views->batch = b->batch;
    b->views->groups = b->groups;
    for (from = 0; from < v->count && result == GLBK_OK;) {
        const float *eyes = v->eyes + 3 * from;
        uint32_t width = glbk__sfield_width(b, eyes), n = 1;
        while (n < b->batch && from + n < v->count && glbk__sfield_width(b, eyes + 3 * (size_t)n) == width)
            n++;
        b->views->width = width;
        result = glbk__sfield_draw_cubes(ctx, b, n, eyes);
        if (result == GLBK_OK)
            result = b->bands ? glbk__sfield_read_coefs(ctx, b, n, values)
                              : glbk__sfield_read_texels(ctx, b, n, values);
        values += n * glbk__sfield_values(b) * (b->source ? 3u : 1u);
        from += n;
    }
    return result;
}

/* ==== src/gl_shadowfield/end.h ==== */

#endif /* GL_SHADOWFIELD_IMPLEMENTATION */

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
