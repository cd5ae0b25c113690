/* gl_wavelets.h - v0.9.0 - shadow fields of wavelets on OpenGL 3.3, ES 3.0, WebGL 2 - MIT-0 OR Unlicense

   What it does

   It lights a picture by fields of wavelets (SFIELD_BASIS_HAAR): shadows with edges, which the few bands of
   harmonics of gl_shadowfield.h blur. Entities, self-visibility, sky and G-buffer are the same for both.

   What it does not do

   - It needs gl_shadowfield.h beside it, which makes its tables and moves its entities; gl_gbuffer.h, which
     has what a camera sees; gl_programs.h, which makes programs; gl_backend.h, which makes the context
     object, textures and targets, and whose conventions, errors and rules about GL's state hold here; and
     shadowfield.h above it. The implementations of all of them belong into some file of the program.
   - No shader of yours can call it: its passes shade batches of points.
   - It has no resolve: light is a texture that your lighting pass multiplies by the surface's colour.

   Quick start

       #define SHADOWFIELD_IMPLEMENTATION
       #define GL_BACKEND_IMPLEMENTATION
       #define GL_PROGRAMS_IMPLEMENTATION
       #define GL_GBUFFER_IMPLEMENTATION
       #define GL_SHADOWFIELD_IMPLEMENTATION
       #define GL_WAVELETS_IMPLEMENTATION
       #include "gl_backend/gl_wavelets.h"
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
           static const float corners[9] = { -1, 0, -1, 0, 0, 1, 1, 0, -1 };
           static float texels[3 * 6 * 16 * 16];            // of the sky: an overcast one
           glbk_context gl;
           glbk_sfield_scene scene;
           glbk_sfield_haar light;
           glbk_desc desc;
           glbk_sfield_haar_scene_desc fields;
           glbk_sfield_haar_desc sizes;
           glbk_result result;
           sfield_desc how;
           sfield_mesh mesh;
           sfield_field *field = NULL;
           const sfield_field *list[1];
           size_t i;

           memset(&desc, 0, sizeof desc);
           memset(&fields, 0, sizeof fields);
           memset(&sizes, 0, sizeof sizes);
           memset(&how, 0, sizeof how);
           memset(&mesh, 0, sizeof mesh);
           desc.get_proc_fn = get_proc;                     // a context is current
           result = glbk_init(&gl, &desc);
           if (result != GLBK_OK) {
               printf("no GL: %s\n", glbk_result_text(result));
               return result != GLBK_ERR_FUNCTION;
           }
           how.basis = SFIELD_BASIS_HAAR;
           how.cube_side = fields.cube_side = sizes.cube_side = 16;
           mesh.positions = corners;
           mesh.vertex_count = 3;
           if (sfield_build(&how, &mesh, &field, NULL) != SFIELD_OK) return 1;
           list[0] = field;
           fields.fields = list;
           fields.field_count = 1;
           fields.entity_capacity = 100;
           sizes.width = 640;
           sizes.height = 360;
           for (i = 0; i < sizeof texels / sizeof texels[0]; i++) texels[i] = 1;
           result = glbk_sfield_haar_upload(&gl, &fields, &scene);
           if (result == GLBK_OK) result = glbk_sfield_haar_create(&gl, &sizes, &light);
           if (result == GLBK_OK) result = glbk_sfield_haar_sky(&gl, &scene, texels);
           printf("%s\n", glbk_result_text(result));        // each frame: see below
           if (result == GLBK_OK) glbk_sfield_haar_free(&gl, &light);
           glbk_sfield_scene_free(&gl, &scene);
           sfield_free(field);
           glbk_free(&gl);
           return result != GLBK_OK;
       }

   A frame

       glbk_sfield_scene_entities(gl, &scene, entities, count);     // where all is, as for harmonics
       glbk_sfield_haar_sky(gl, &scene, texels);                    // sfield_scene_sky, if it has changed
       glbk_gbuffer_begin(gl, &gbuffer, world_to_clip, eye);        // or _import, or _upload
       glbk_gbuffer_object(gl, &gbuffer, &surface);                 // for each object, with your draw
       glbk_sfield_haar_shade(gl, &haar, &gbuffer, &scene, eye, 0); // haar.light: times albedo; gloss

   Conventions

   A batch of points is shaded at a time. Its passes list what each point meets from near to far, write
   the cubes of these lists, multiply texels, and add them up. Nothing is left out: a point that meets
   more than 16 takes further rounds. Products are on texels, as SFIELD_PRODUCT_TEXELS has them, so
   results are sfield_shade's but for roundings: docs/shadowfield.md has the bound. Where the context has
   compute shaders (4.3) and cubes at most 32 texels a side, a work group shades a point in one pass, as
   the CPU does: it adds lists of coefficients up and turns them into texels only where they hide. A point
   costs far more than one of harmonics: docs/measured/shadowfield.md.

   From the paper to the code

   The paper is that of shadowfield.h: Zhou, Hu, Lin, Guo and Shum, "Precomputed Shadow Fields for Dynamic
   Scenes", SIGGRAPH 2005. A line has the call, its twin in shadowfield.h, and the rows of docs/conformance.md
   that test both.

     section 3.1  S_d, the environment            glbk_sfield_haar_sky     sfield_scene_sky       -
     section 3.1  O_p, self-visibility            glbk_sfield_haar_self    sfield_build_self      -
     section 3.3  wavelets, cut                   glbk_sfield_haar_upload  sfield_query           wavelets
     section 4.1  the BRDF at the beginning       glbk_sfield_haar_shade   sfield_shade           gloss
     section 4.1  products of wavelets            glbk_sfield_haar_shade   sfield_haar_product    wavelets

   Configuration

     GL_WAVELETS_IMPLEMENTATION      in one source file: compiles the code; other files may have those of
                                     gl_backend.h, gl_programs.h, gl_gbuffer.h, gl_shadowfield.h and
                                     shadowfield.h

   Layouts: docs/gpu-layouts.md. The technique: docs/shadowfield.md, "Wavelets on OpenGL". State:
   docs/gl-state.md. Licence: end of file. */
/* This stands outside the guard, because a second inclusion of this file may ask for its implementation. */
#include "gl_shadowfield.h"

#ifndef GL_WAVELETS_H
#define GL_WAVELETS_H

#if GLBK_VERSION != 900
#error "gl_wavelets.h and gl_backend.h are of different versions"
#endif
#if defined(GLBK_STATIC) && !defined(GL_WAVELETS_IMPLEMENTATION)
#error "GLBK_STATIC makes all functions private: GL_WAVELETS_IMPLEMENTATION belongs into the same file"
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ==== src/gl_wavelets/api_page_one.h ==== */

/* ---- page one: a scene of wavelets that lights the pixels of a G-buffer ---- */

typedef struct glbk_sfield_haar glbk_sfield_haar;   /* the light of a picture: see "objects" below */
struct glbk_sfield_haar_scene_desc;     /* which fields, how many entities: below */
struct glbk_sfield_haar_desc;           /* how large the picture is: below */

GLBK_DEF glbk_result glbk_sfield_haar_upload(glbk_context *ctx,
                                             const struct glbk_sfield_haar_scene_desc *desc,
                                             glbk_sfield_scene *out);
/* Makes a scene of fields of wavelets, with room for entities. They go up as trees or, if ctx->compute is set
   and cube_side is at most 32, as lists of coefficients. glbk_sfield_scene_free takes the scene back.
   Memory   on the GPU of trees 16 bytes, of sources 32, for each square that holds a wavelet or has such
            squares within, and for six squares of each sample; of lists 4 bytes, of sources 8, for each
            coefficient, and 16 to 28 bytes for each sample; 112 bytes for each of entity_capacity, and 98
            KB for the sky of 32 texels a side. Here 40 bytes a field and, while the call runs, the
            longest file of a field and 150 KB
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: a field is out of range. GLBK_ERR_MISMATCH: a
            field of harmonics, of other texels, or a shard. GLBK_ERR_LIMIT: more than 2^28 texels.
            GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_sfield_haar_sky(glbk_context *ctx, glbk_sfield_scene *scene, const float *texels);
/* Sets the environment and its suns.
   texels   3 x 6 cube_side^2 numbers from sfield_scene_sky; NULL = no sky
   Errors   GLBK_ERR_ARGUMENT: scene is NULL or was not created. GLBK_ERR_MISMATCH: the scene has harmonics.
            GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_sfield_haar_create(glbk_context *ctx, const struct glbk_sfield_haar_desc *desc,
                                             glbk_sfield_haar *out);
/* Compiles the four programs and makes their textures; or the compute shader, where scenes have lists. For
   another size free it and create it anew.
   Memory   on the GPU 16 bytes a pixel and, for each point of a batch, 456 cube_side^2 + 1,280 bytes: 30 MB
            for 256 points of 16 texels a side. By compute 24 cube_side^2 bytes for each point of a batch,
            above 16 texels a side: 50 MB for 2,048 points of 32. With gloss 16 bytes a pixel and, for each
            point of a batch, 48 cube_side^2 bytes more, 72 by compute
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: a field is out of range. GLBK_ERR_LIMIT:
            width or height is above ctx->max_side. GLBK_ERR_ALLOC. Those of textures, targets and
            glbk_program_compile */

GLBK_DEF glbk_result glbk_sfield_haar_shade(glbk_context *ctx, glbk_sfield_haar *haar,
                                            const glbk_gbuffer *gbuffer, const glbk_sfield_scene *scene,
                                            const float eye[3], int open);
/* Shades all pixels into haar->light and gloss, in (pixels / batch) batches of 3 passes a round and one
   more, or of one pass by compute. A round takes 16 of what the scene has: its entities, and each light
   three times more.
   eye      world, for gloss; NULL = that of the G-buffer, which knows it if it was drawn or imported
   open     not 0: light.a is wanted even if there is no sky; else it is 0 then
   Errors   GLBK_ERR_ARGUMENT: an object is NULL or was not created, or gloss is shaded and no eye is known.
            GLBK_ERR_MISMATCH: the scene has harmonics or other texels, was uploaded with another
            ctx->compute, or is not the one that self-visibility was named for, or the G-buffer has another
            size. GLBK_ERR_LOST */

GLBK_DEF void glbk_sfield_haar_free(glbk_context *ctx, glbk_sfield_haar *haar);
/* Deletes the renderer's objects of GL and zeroes the struct. Accepts NULL. */

/* ---- structs of page one ---- */

typedef struct glbk_sfield_haar_scene_desc {
    const sfield_field *const *fields;  /* of wavelets, all with as many texels: occlusion, sources and what
                                           sfield_build_self made. Entities name the first two by these
                                           pointers, glbk_sfield_own the last, so they must outlive the
                                           scene */
    size_t   field_count;
    uint32_t cube_side;                 /* that of the fields; 0 = 32 */
    uint32_t entity_capacity;           /* the most entities, 1..65535 */
    float    reach;                     /* as in glbk_sfield_scene_desc */
} glbk_sfield_haar_scene_desc;

typedef struct glbk_sfield_haar_desc {
    uint32_t width;                     /* pixels, 1 .. ctx->max_side, like height */
    uint32_t height;
    uint32_t cube_side;                 /* that of the scene: a power of two, 4..64; 0 = 32 */
    uint32_t batch;                     /* points that are shaded at a time, at most so many as textures of
                                           2048 or ctx->max_side a side hold: 672 of cubes of 16, 168 of 32,
                                           40 of 64; by compute 2048. A greater number is taken for that; 0 =
                                           256, or 2048 by compute without gloss. More points make fewer
                                           passes */
    int      self;                      /* not 0: there is room for self-visibility, 4 bytes a pixel */
    int      gloss;                     /* not 0: gloss is shaded by Phong's lobe and by glTF's metal-rough
                                           BRDF, as each pixel's material says */
} glbk_sfield_haar_desc;

/* ==== src/gl_wavelets/api_objects.h ==== */

/* ---- self-visibility: what a point's own object leaves open ---- */

typedef struct glbk_sfield_own {        /* what a point's own object hides of it */
    const sfield_field *self;           /* by sfield_build_self, one of the scene's fields; NULL = nothing */
    uint32_t            point;          /* its number there */
} glbk_sfield_own;

GLBK_DEF glbk_result glbk_sfield_haar_self(glbk_context *ctx, glbk_sfield_haar *haar,
                                           const glbk_sfield_scene *scene, uint32_t row, uint32_t row_count,
                                           const glbk_sfield_own *own);
/* Says for whole rows of pixels which self-visibility they have, in the space of the entity that the G-buffer
   names there. Pixels that no call named have none. What is said stays from frame to frame, until another
   call says something else of these rows.
   scene    the one that glbk_sfield_haar_shade is given then, since the texture names places in its table, or
            one of the same fields in the same order. The first call for another scene takes self-visibility
            from all other pixels
   own      haar->width x row_count of them
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, an object was not created, or rows reach beyond height.
            GLBK_ERR_MISMATCH: haar has no desc.self, or a field is none of the scene's self-visibilities.
            GLBK_ERR_INPUT: a point is beyond those of its field. GLBK_ERR_ALLOC */

/* For the library's tools and tests: returns the GLSL of this header, which is for its own programs alone. */
GLBK__DEF const glbk_part *glbk__wavelets(void);

/* ---- objects: read only ---- */

struct glbk_sfield_haar {               /* the light of a picture; read only; zeroed = none */
    glbk_texture light;                 /* GLBK_FORMAT_COLOR: rgb times albedo is radiance; a is the open
                                           share of the cosine-weighted sphere */
    glbk_texture gloss;                 /* Phong: rgb times the specular color is radiance; metal-rough: rgb
                                           is radiance, and light's rgb has its factor 1 - F. Made if
                                           desc.gloss is set */
    glbk_target  target;                /* of light and gloss, for glbk_target_read */
    glbk_texture self;                  /* private, like all that follows but width, height and cube_side */
    glbk_texture list[3];               /* kinds, and weights of corners and of shells */
    glbk_texture met[2];
    glbk_texture cubes;
    glbk_texture left[2][4];            /* T, in two parts, and sums of light and gloss */
    glbk_target  list_target[2];
    glbk_target  cubes_target;
    glbk_target  left_target[2];
    glbk_program find;
    glbk_program write;
    glbk_program multiply;
    glbk_program sum;
    glbk_program shade;                 /* by compute, in place of all these */
    glbk_buffer  kept;                  /* T and kernels of a batch */
    glbk_buffer  block;
    uint32_t     width;
    uint32_t     height;
    uint32_t     cube_side;
    uint32_t     batch;                 /* points */
    uint32_t     columns;               /* cubes in a row of their texture */
    int          has_self;
    int          has_gloss;
    int          compute;               /* not 0: pixels are shaded by a compute shader */
    uint64_t     self_of;               /* which scene's places self has; 0 = nothing was said */
};

/* ==== src/gl_wavelets/bindings.h ==== */

/* ---- what the GLSL declares; see "bindings" in gl_programs.h ---- */

/* Programs read what a batch of points wrote before: lists, cubes, T and sums. They stand beside the tables
   and self-visibility of gl_shadowfield.h. */
#define GLBK_HAAR_TEXTURES(X)                                                               \
    X(usampler2D, glbk_haar_what, 4)                /* kind, first sample, entity, field */ \
    X(usampler2D, glbk_haar_corner, 5)              /* weights of four samples */           \
    X(usampler2D, glbk_haar_weight, 6)              /* of two shells and frames */          \
    X(usampler2D, glbk_haar_met, 1)                 /* distances and ids of a round */      \
    X(usampler2D, glbk_haar_cubes, 2)               /* texels of lists' cubes */            \
    X(usampler2D, glbk_haar_lower, 12)              /* T after the round before */          \
    X(usampler2D, glbk_haar_upper, 13)                                                      \
    X(usampler2D, glbk_haar_sums, 14)               /* light of the rounds before */        \
    X(usampler2D, glbk_haar_shine, 1)               /* their gloss; no program reads met, too */

/* This block says which points a batch has, and how textures hold them. */
#define GLBK_HAAR_BATCH_MEMBERS(X)                                                          \
    X(uint, left, 1) X(uint, bottom, 1)     /* a rectangle of pixels */                     \
    X(uint, width, 1)                                                                       \
    X(uint, count, 1)                       /* points */                                    \
    X(uint, slots, 1)                       /* places of a list */                          \
    X(uint, round, 1)                       /* lists of so many places before this one */   \
    X(uint, last, 1)                        /* not 0: adds the sky and the open share */    \
    X(uint, own, 1)                         /* not 0: there is self-visibility */           \
    X(uint, side, 1)                        /* texels a side of a cube's face */            \
    X(uint, columns, 1)                     /* cubes of a row */                            \
    X(uint, unused0, 1) X(uint, unused1, 1)                                                 \
    X(vec4, eye, 1)                         /* world; w is not used */

#define GLBK_HAAR_BLOCKS(X) X(glbk_haar_batch, 4, GLBK_HAAR_BATCH_MEMBERS)
/* The compute shader keeps T there if shared memory has no room for it, and kernels of BRDFs. */
#define GLBK_HAAR_STORAGE(X) X(restrict, float, glbk_haar_left, 0)

#define GLBK_HAAR_IMAGES(X)

GLBK__PART(HAAR)

/* ==== src/gl_wavelets/begin.h ==== */

/* ---- end of the declarations ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_WAVELETS_H */

/* ==== implementation ==================================================================================== */

#if defined(GL_WAVELETS_IMPLEMENTATION) && !defined(GL_WAVELETS_IMPLEMENTED)
#define GL_WAVELETS_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ==== src/shared/mem.h ==== */

/* unit mem: checked sizes, and the caller's allocator with malloc and free as its default */

typedef struct glbk_haar__allocator {
    void *(*alloc_fn)(size_t size, void *user);
    void (*free_fn)(void *memory, void *user);
    void *user;
} glbk_haar__allocator;

static inline void *glbk_haar__default_alloc(size_t size, void *user)
{
    (void)user;
    return malloc(size);
}

static inline void glbk_haar__default_free(void *memory, void *user)
{
    (void)user;
    free(memory);
}

/* Writes a * b and returns 1; returns 0, with *out untouched, if the product does not fit. */
static inline int glbk_haar__mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b) return 0;
    *out = a * b;
    return 1;
}

static inline glbk_haar__allocator glbk_haar__allocator_make(void *(*alloc_fn)(size_t, void *),
                                           void (*free_fn)(void *, void *), void *user)
{
    glbk_haar__allocator a;
    a.alloc_fn = alloc_fn && free_fn ? alloc_fn : glbk_haar__default_alloc;
    a.free_fn = alloc_fn && free_fn ? free_fn : glbk_haar__default_free;
    a.user = user;
    return a;
}

/* Returns NULL if there is no memory, and also if the size is 0, so that a caller has one thing to test. */
static inline void *glbk_haar__alloc(const glbk_haar__allocator *a, size_t size)
{
    return size ? a->alloc_fn(size, a->user) : NULL;
}

static inline void *glbk_haar__alloc_array(const glbk_haar__allocator *a, size_t count, size_t item_size)
{
    size_t size;
    return glbk_haar__mul_size(count, item_size, &size) ? glbk_haar__alloc(a, size) : NULL;
}

static inline void glbk_haar__free(const glbk_haar__allocator *a, void *memory)
{
    if (memory) a->free_fn(memory, a->user);
}

/* ==== src/shared/gl_memory.h ==== */

/* unit gl_memory, needs mem: the allocator of a glbk_context (gl_backend.h) */

static inline glbk_haar__allocator glbk_haar__memory(const glbk_context *ctx)
{
    const glbk_allocator *a = &ctx->system.allocator;
    return glbk_haar__allocator_make(a->alloc_fn, a->free_fn, a->user);
}

/* ==== src/shared/bytes.h ==== */

/* unit bytes: little-endian values in byte arrays, whatever the host's order and alignment */

static inline uint32_t glbk_haar__get_u32(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static inline float glbk_haar__get_f32(const uint8_t *p)
{
    uint32_t bits = glbk_haar__get_u32(p);
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

/* ==== GLSL of src/gl_wavelets ==== */


static const struct { char facts[39];
    char s0[156]; char end; } glbk__glsl_lib_haar_batch_glsl GLBK__TIGHT = {
    "lib/haar_batch.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_haar_batch",
    "\nlayout(std140)uniform glbk_haar_batch_block{\n"
    "uint left,bottom,width,count,slots,round,last,own,side,columns,unused0,\n"
    "unused1;\n"
    "vec4 eye;\n"
    "}glbk_haar_batch;\n", 0
};

static const struct { char facts[27];
    char s0[284]; char end; } glbk__glsl_lib_haar_bindings_glsl GLBK__TIGHT = {
    "lib/haar_bindings.glsl\0" "" "\0" "" "\0"
    "" "\0" "",
    "\nuniform usampler2D glbk_haar_what,glbk_haar_corner,glbk_haar_weight,glbk_haar_met,\n"
    "glbk_haar_cubes,glbk_haar_lower,glbk_haar_upper,glbk_haar_sums,glbk_haar_shine;\n"
    "#if __VERSION__ >= 430\n"
    "layout(std430,binding=0)restrict buffer glbk_haar_left_storage{float glbk_haar_left[];};\n"
    "#endif\n", 0
};

static const struct { char facts[87];
    char s0[1768]; char end; } glbk__glsl_lib_sfield_haar_glsl GLBK__TIGHT = {
    "lib/sfield_haar.glsl\0" "table sfield_bindings sfield_contents haar_bindings haar_batch" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\n#define SFIELD_TEXEL(i) texelFetch(glbk_sfield_table, glbk_table_at(i), 0)\n"
    "#define SFIELD_MOVING(i) texelFetch(glbk_sfield_moving, glbk_table_at(i), 0)\n"
    "#define SFIELD_EMPTY 0u\n"
    "#define SFIELD_OCCLUDER 1u\n"
    "#define SFIELD_LIGHT 2u\n"
    "#define SFIELD_OWN 5u\n"
    "#define SFIELD_NOBODY 0xffffffffu\n"
    "\n\nuvec4 sfield_entity(uint entity,uint k)\n"
    "{\n"
    "return SFIELD_MOVING(glbk_sfield_contents.entity_texel+7u*entity+k);\n"
    "}\n"
    "\n\nvec3 sfield_turn(uint entity,vec3 v)\n"
    "{\n"
    "return vec3(dot(uintBitsToFloat(sfield_entity(entity,2u).xyz),v),\n"
    "dot(uintBitsToFloat(sfield_entity(entity,3u).xyz),v),\n"
    "dot(uintBitsToFloat(sfield_entity(entity,4u).xyz),v));\n"
    "}\n"
    "\n\nbool sfield_is_turned(uint entity)\n"
    "{\n"
    "return entity!=SFIELD_NOBODY&&sfield_entity(entity,5u).z!=SFIELD_NOBODY;\n"
    "}\n"
    "\n\nivec2 sfield_pixel(uint point)\n"
    "{\n"
    "return ivec2(glbk_haar_batch.left+point%glbk_haar_batch.width,\n"
    "glbk_haar_batch.bottom+point/glbk_haar_batch.width);\n"
    "}\n"
    "\n\n\nivec2 sfield_square(uint cube,uint columns,uint face,uvec2 at,uvec2 size)\n"
    "{\n"
    "return ivec2(uvec2(cube%columns*6u+face,cube/columns)*size+at);\n"
    "}\n"
    "\n\nvec3 sfield_from_face(uint face,vec2 st)\n"
    "{\n"
    "float s=st.x,t=st.y,sign_of=(face&1u)==0u?1.:-1.;\n"
    "vec3 x=vec3(sign_of,-t,-sign_of*s),y=vec3(s,sign_of,sign_of*t);\n"
    "vec3 z=vec3(sign_of*s,-t,sign_of);\n"
    "return face<2u?x:face<4u?y:z;\n"
    "}\n"
    "\n\nvec2 sfield_middle(ivec2 texel){return(2.*vec2(texel)+1.)/float(glbk_haar_batch.side)-1.;}\n"
    "\n\nuint sfield_share(uvec4 what,vec4 corner,uvec4 weight,uint side,uint i,out float share)\n"
    "{\n"
    "bool right=(i&1u)!=0u,up=(i&2u)!=0u,outer=(i&4u)!=0u,after=(i&8u)!=0u;\n"
    "vec4 shells=uintBitsToFloat(weight);\n"
    "share=up?(right?corner.w:corner.z):(right?corner.y:corner.x);\n"
    "share*=(outer?shells.y:shells.x)*(after?shells.z:1.-shells.z);\n"
    "return what.y+(right?1u:0u)+(up?side:0u)+(outer?6u*side*side:0u)+\n"
    "(after?weight.w:0u);\n"
    "}\n", 0
};

static const struct { char facts[50];
    char s0[2918]; char end; } glbk__glsl_lib_sfield_haar_gloss_glsl GLBK__TIGHT = {
    "lib/sfield_haar_gloss.glsl\0" "sfield_haar gbuffer" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n#ifndef SFIELD_GLOSS\n"
    "#define SFIELD_GLOSS 0\n"
    "#endif\n"
    "#if SFIELD_GLOSS\n"
    "\nstruct sfield_look{\n"
    "vec3 n,v,mirror;\n"
    "bool metal;\n"
    "float exponent;\n"
    "float a2,nv,go;\n"
    "float width;\n"
    "vec3 facing;\n"
    "};\n"
    "\n\n\n\nbool sfield_read_look(const glbk_point p,out sfield_look b)\n"
    "{\n"
    "vec3 view=glbk_haar_batch.eye.xyz-p.position;\n"
    "bool seen=dot(view,view)>.0;\n"
    "b.n=p.normal;\n"
    "b.v=seen?normalize(view):p.normal;\n"
    "b.nv=dot(b.n,b.v);\n"
    "float least=mix(.08,.105/float(glbk_haar_batch.side),clamp(10.*b.nv,.0,1.));\n"
    "float alpha=clamp(p.roughness*p.roughness,least,1.);\n"
    "b.mirror=2.*b.nv*b.n-b.v;\n"
    "b.metal=p.kind==GLBK_METAL_ROUGH;\n"
    "b.exponent=p.exponent>.0&&seen?clamp(p.exponent,1.,1000.):.0;\n"
    "b.facing=vec3(1.);\n"
    "if(b.metal)b.facing=.04+clamp(p.metallic,.0,1.)*(clamp(p.diffuse,.0,1.)-.04);\n"
    "if(b.nv<1e-3&&b.metal){\n"
    "vec3 t=b.v-b.nv*b.n,x=abs(b.n.x)<.6?vec3(1.,.0,.0):vec3(.0,1.,.0);\n"
    "if(dot(t,t)<1e-12)t=cross(b.n,x);\n"
    "b.nv=1e-3;\n"
    "b.v=normalize(t)+1e-3*b.n;\n"
    "}\n"
    "b.a2=alpha*alpha;\n"
    "b.go=sqrt(b.a2+(1.-b.a2)*b.nv*b.nv);\n"
    "b.width=b.metal?alpha:sqrt(2./max(b.exponent,1.));\n"
    "return seen||!b.metal;\n"
    "}\n"
    "\n\nfloat sfield_power(float x,float e)\n"
    "{\n"
    "float whole=floor(e),power=pow(max(x,1e-30),e-whole);\n"
    "for(int i=0;i<10;i++){\n"
    "float half_of=floor(.5*whole);\n"
    "power*=whole>2.*half_of?x:1.;\n"
    "whole=half_of;\n"
    "x*=x;\n"
    "}\n"
    "return power;\n"
    "}\n"
    "\n\nvec3 sfield_response(const sfield_look b,vec3 l)\n"
    "{\n"
    "float nl=max(dot(b.n,l),.0),along=max(dot(b.mirror,l),.0);\n"
    "float lobe=b.exponent>.0?(b.exponent+2.)*.159154943*sfield_power(along,b.exponent):.0;\n"
    "vec3 h=l+b.v,off=cross(h,b.n);\n"
    "float hh=max(dot(h,h),4e-6),nh=dot(h,b.n);\n"
    "float q=(dot(off,off)+nh*nh*b.a2)/hh;\n"
    "float fifth=1.-sqrt(min(.25*hh,1.));\n"
    "fifth*=fifth*fifth*(fifth*fifth);\n"
    "float all=nl*.159154943*b.a2/(q*q);\n"
    "all/=nl*b.go+b.nv*sqrt(b.a2+(1.-b.a2)*nl*nl);\n"
    "vec3 metal=vec3(nl*.318309886*(1.-fifth),all*(1.-fifth),all*fifth);\n"
    "vec3 plain=vec3(nl,nl*lobe,.0);\n"
    "if(nl==.0)metal=vec3(.0);\n"
    "return b.metal?metal:plain;\n"
    "}\n"
    "\n\n\nuint sfield_count_parts(const sfield_look b,vec3 l)\n"
    "{\n"
    "float texel=1.57079633/float(glbk_haar_batch.side);\n"
    "vec3 h=l+b.v;\n"
    "float hh=dot(h,h),off=dot(h,b.n),hv=dot(h,b.v);\n"
    "float turned=texel*.5*sqrt(hh)/max(hv,1e-3);\n"
    "float tail=sqrt(max(hh/max(off*off,1e-12)-1.,.0));\n"
    "float wide=max(.5*(tail-turned),b.width);\n"
    "uint parts=off>.0?min(uint(2.*turned/wide)+1u,16u):1u;\n"
    "bool far=b.exponent==.0||dot(l,b.mirror)<1.-8.*b.width*b.width-texel;\n"
    "uint of_lobe=far?1u:uint(2.*texel/b.width)+1u;\n"
    "return b.metal?parts:of_lobe;\n"
    "}\n"
    "\n\n\nvec3 sfield_kernels(const sfield_look b,uint face,ivec2 texel)\n"
    "{\n"
    "vec3 middle=normalize(sfield_from_face(face,sfield_middle(texel))),sum=vec3(.0);\n"
    "uint parts=sfield_count_parts(b,middle);\n"
    "float side=float(glbk_haar_batch.side*parts);\n"
    "for(uint i=0u;i<parts*parts;i++){\n"
    "vec2 at=vec2(texel)*float(parts)+vec2(float(i%parts),float(i/parts));\n"
    "sum+=sfield_response(b,normalize(sfield_from_face(face,(2.*at+1.)/side-1.)));\n"
    "}\n"
    "sum/=float(parts*parts);\n"
    "vec3 plain=vec3(max(dot(middle,b.n),.0),sum.y,.0);\n"
    "return b.metal?sum:plain;\n"
    "}\n"
    "#endif\n", 0
};

static const struct { char facts[54];
    char s0[2753]; char end; } glbk__glsl_lib_sfield_haar_list_glsl GLBK__TIGHT = {
    "lib/sfield_haar_list.glsl\0" "sfield_haar sfield_field" "\0" "" "\0"
    "" "\0" "",
    "\n\n\nbool sfield_after(float d2,uint id,float of,uint other){return d2>of||(d2==of&&id>other);}\n"
    "\n\nfloat sfield_reach(uint entity,vec3 position,vec3 normal,out vec3 v)\n"
    "{\n"
    "vec4 place=uintBitsToFloat(sfield_entity(entity,0u));\n"
    "v=place.xyz-position;\n"
    "float d2=dot(v,v);\n"
    "bool counts=d2<place.w&&dot(v,normal)>-uintBitsToFloat(sfield_entity(entity,3u).w);\n"
    "return counts?d2:-1.;\n"
    "}\n"
    "\n\n\n\nvoid sfield_find(vec3 position,vec3 normal,uint own,uint first,uint step,inout float d2,inout uint id)\n"
    "{\n"
    "float best=3e38;\n"
    "uint found=SFIELD_NONE;\n"
    "for(uint e=first;e<glbk_sfield_contents.entity_count;e+=step){\n"
    "vec4 source=uintBitsToFloat(sfield_entity(e,1u));\n"
    "vec3 v,w=source.xyz-position;\n"
    "float far=sfield_reach(e,position,normal,v),light=source.w>.0?dot(w,w):-1.;\n"
    "for(uint k=0u;k<4u;k++){\n"
    "float d=k==3u?far:light;\n"
    "uint n=4u*e+k;\n"
    "bool counts=e+1u!=own&&d>=.0;\n"
    "if(counts&&sfield_after(d,n,d2,id)&&sfield_after(best,found,d,n)){\n"
    "best=d;\n"
    "found=n;\n"
    "}\n"
    "}\n"
    "}\n"
    "d2=best;\n"
    "id=found;\n"
    "}\n"
    "\n\nbool sfield_hidden(vec3 position,vec3 normal,uint own,uint first,uint step,float d2,uint id)\n"
    "{\n"
    "uint a=id>>2;\n"
    "vec3 v=uintBitsToFloat(sfield_entity(a,0u).xyz)-position;\n"
    "float sin_a=uintBitsToFloat(sfield_entity(a,3u).w)*inversesqrt(d2);\n"
    "bool hidden=false;\n"
    "for(uint b=first;b<glbk_sfield_contents.entity_count;b+=step){\n"
    "vec3 w;\n"
    "float inscribed=uintBitsToFloat(sfield_entity(b,2u).w);\n"
    "float reach=uintBitsToFloat(sfield_entity(b,0u).w);\n"
    "float e2=sfield_reach(b,position,normal,w),sin_b=inscribed*inversesqrt(max(e2,1e-30));\n"
    "float cosines=sqrt(max(1.-sin_a*sin_a,.0)*max(1.-sin_b*sin_b,.0));\n"
    "bool counts=b!=a&&b+1u!=own&&inscribed>.0&&inscribed*inscribed<e2;\n"
    "bool nearer=sfield_after(d2,id,e2,4u*b+3u)&&e2<=.5625*reach;\n"
    "bool within=sin_a<sin_b&&dot(v,w)>=(cosines+sin_a*sin_b)*sqrt(d2*e2);\n"
    "hidden=hidden||(counts&&nearer&&within);\n"
    "}\n"
    "return hidden;\n"
    "}\n"
    "\n\nvoid sfield_surround(vec3 position,float d2,uint id,out uvec4 what,out uvec4 corner,out uvec4 weight)\n"
    "{\n"
    "uint entity=id>>2,before,after;\n"
    "bool hides=(id&3u)==3u;\n"
    "uint field=hides?sfield_entity(entity,5u).x:sfield_entity(entity,5u).y;\n"
    "vec4 reach=uintBitsToFloat(sfield_entity(entity,0u));\n"
    "vec4 sphere=hides?vec4(reach.xyz,uintBitsToFloat(sfield_entity(entity,3u).w))\n"
    ":uintBitsToFloat(sfield_entity(entity,1u));\n"
    "sfield_place place=sfield_locate(field,sfield_turn(entity,position-sphere.xyz)/sphere.w);\n"
    "float fade=hides?clamp(4.*(1.-sqrt(d2)*inversesqrt(reach.w)),.0,1.):1.;\n"
    "uvec4 head=SFIELD_TEXEL(field);\n"
    "uint frame=6u*head.w*head.w*head.z;\n"
    "float t=sfield_frames(field,uintBitsToFloat(sfield_entity(entity,4u).w),before,after);\n"
    "uint kind=hides?SFIELD_OCCLUDER:SFIELD_LIGHT+(id&3u);\n"
    "what=uvec4(kind,place.first+before*frame,entity,field);\n"
    "corner=floatBitsToUint(place.corner);\n"
    "weight=uvec4(floatBitsToUint(vec3(place.weight*fade,t)),after*frame-before*frame);\n"
    "}\n", 0
};

static const struct { char facts[41];
    char s0[1174]; char end; } glbk__glsl_lib_sfield_haar_turn_glsl GLBK__TIGHT = {
    "lib/sfield_haar_turn.glsl\0" "sfield_haar" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\nuint sfield_to_face(vec3 d,out vec2 st)\n"
    "{\n"
    "vec3 a=abs(d);\n"
    "bool on_x=a.x>=a.y&&a.x>=a.z,on_y=!on_x&&a.y>=a.z;\n"
    "float axis=on_x?d.x:on_y?d.y:d.z;\n"
    "st=on_x?vec2(axis>.0?-d.z:d.z,-d.y):on_y?vec2(d.x,axis>.0?d.z:-d.z)\n"
    ":vec2(axis>.0?d.x:-d.x,-d.y);\n"
    "st/=abs(axis);\n"
    "return(on_x?0u:on_y?2u:4u)+(axis>.0?0u:1u);\n"
    "}\n"
    "\n\n\nivec2 sfield_wrap(inout uint face,ivec2 texel)\n"
    "{\n"
    "int side=int(glbk_haar_batch.side);\n"
    "vec2 st;\n"
    "if(all(greaterThanEqual(texel,ivec2(0)))&&all(lessThan(texel,ivec2(side))))return texel;\n"
    "face=sfield_to_face(sfield_from_face(face,sfield_middle(texel)),st);\n"
    "return clamp(ivec2((st+1.)*(.5*float(side))),ivec2(0),ivec2(side-1));\n"
    "}\n"
    "\n\nfloat sfield_tap(uint cube,uint face,ivec2 texel);\n"
    "\n\nfloat sfield_between(uint cube,vec3 d)\n"
    "{\n"
    "vec2 st;\n"
    "uint face=sfield_to_face(d,st);\n"
    "vec2 at=(st+1.)*(.5*float(glbk_haar_batch.side))-.5,low=floor(at);\n"
    "float sum=.0;\n"
    "for(int k=0;k<4;k++){\n"
    "ivec2 step_by=ivec2(k&1,k>>1);\n"
    "vec2 part=at-low;\n"
    "float x=step_by.x==0?1.-part.x:part.x,y=step_by.y==0?1.-part.y:part.y;\n"
    "sum+=x*y*sfield_tap(cube,face,ivec2(low)+step_by);\n"
    "}\n"
    "return sum;\n"
    "}\n"
    "\n\nvec3 sfield_direction(uint face,ivec2 texel)\n"
    "{\n"
    "return normalize(sfield_from_face(face,sfield_middle(texel)));\n"
    "}\n", 0
};

static const struct { char facts[82];
    char s0[2545]; char end; } glbk__glsl_prog_sfield_haar_cubes_frag GLBK__TIGHT = {
    "prog/sfield_haar_cubes.frag\0" "sfield_haar gbuffer" "\0" "" "\0"
    "SFIELD_GLOSS=0 | SFIELD_GLOSS=1" "\0" "",
    "\n\n\n\n\n#ifndef SFIELD_GLOSS\n"
    "#define SFIELD_GLOSS 0\n"
    "#endif\n"
    "layout(location=0)out uvec4 quad;\n"
    "\n\nvec2 sfield_halves(uint word){return vec2(float(int(word<<16)>>16),float(int(word)>>16));}\n"
    "\n\nvec4 sfield_descend(uint root,uint texels,uint channel,uvec2 at,uint levels)\n"
    "{\n"
    "uint node=root;\n"
    "uvec4 head=SFIELD_TEXEL(node);\n"
    "vec4 values=vec4(.0);\n"
    "for(uint level=levels;level>0u;level--){\n"
    "uvec2 words=head.xy;\n"
    "if(channel>0u){\n"
    "uvec4 other=SFIELD_TEXEL(node+1u);\n"
    "words=channel==1u?other.xy:other.zw;\n"
    "}\n"
    "values=vec4(sfield_halves(words.x),sfield_halves(words.y))*uintBitsToFloat(head.w);\n"
    "if(level==1u)break;\n"
    "uint x=at.x>>(level-2u)&1u,y=at.y>>(level-2u)&1u,quarter=x+2u*y;\n"
    "uint below=head.z>>28&((1u<<quarter)-1u);\n"
    "if((head.z>>28>>quarter&1u)==0u){\n"
    "values=vec4(x==0u?(y==0u?values.x:values.z):(y==0u?values.y:values.w));\n"
    "break;\n"
    "}\n"
    "node=(head.z&0xfffffffu)+texels*((below&1u)+(below>>1&1u)+(below>>2));\n"
    "head=SFIELD_TEXEL(node);\n"
    "}\n"
    "return values;\n"
    "}\n"
    "\n\n\n\nbool sfield_below(uint point,uint entity,uint face,uvec2 at)\n"
    "{\n"
    "glbk_point p;\n"
    "bool seen=glbk_read_point(sfield_pixel(point),p);\n"
    "bool turned=sfield_is_turned(entity);\n"
    "float side=float(glbk_haar_batch.side),margin=(turned?8.:2.)/side;\n"
    "#if SFIELD_GLOSS\n"
    "margin+=1.5/side;\n"
    "#endif\n"
    "vec3 n=p.normal;\n"
    "if(turned)n=sfield_turn(entity,n);\n"
    "return!seen||dot(normalize(sfield_from_face(face,(4.*vec2(at)+2.)/side-1.)),n)<-margin;\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "uint half_side=glbk_haar_batch.side/2u,levels=0u;\n"
    "uvec2 at=uvec2(gl_FragCoord.xy),cell=at/uvec2(6u*half_side,half_side);\n"
    "uint cube=cell.y*glbk_haar_batch.columns+cell.x,face=at.x/half_side%6u;\n"
    "uint point=cube/glbk_haar_batch.slots;\n"
    "vec4 sum=vec4(.0);\n"
    "quad=uvec4(0u);\n"
    "if(point>=glbk_haar_batch.count||cell.x>=glbk_haar_batch.columns)return;\n"
    "ivec2 place=ivec2(cube%glbk_haar_batch.slots,point);\n"
    "uvec4 what=texelFetch(glbk_haar_what,place,0),weight=texelFetch(glbk_haar_weight,place,0);\n"
    "vec4 corner=uintBitsToFloat(texelFetch(glbk_haar_corner,place,0)),shells=uintBitsToFloat(weight);\n"
    "if(what.x==SFIELD_EMPTY||sfield_below(point,what.z,face,at%half_side))return;\n"
    "while(1u<<levels<glbk_haar_batch.side)levels++;\n"
    "at%=half_side;\n"
    "if(what.x==SFIELD_OWN){\n"
    "quad=floatBitsToUint(sfield_descend(what.y+face,1u,0u,at,levels));\n"
    "return;\n"
    "}\n"
    "uint side=SFIELD_TEXEL(what.w).w,channel=what.x<SFIELD_LIGHT?0u:what.x-SFIELD_LIGHT;\n"
    "uvec4 parts=SFIELD_TEXEL(what.w+1u);\n"
    "for(uint i=0u;i<(shells.z>.0?16u:8u);i++){\n"
    "float w;\n"
    "uint sample_at=sfield_share(what,corner,weight,side,i,w);\n"
    "if(w>.0)\n"
    "sum+=\n"
    "w*sfield_descend(parts.y+(6u*sample_at+face)*parts.x,parts.x,channel,at,levels);\n"
    "}\n"
    "quad=floatBitsToUint(sum);\n"
    "}\n", 0
};

static const struct { char facts[105];
    char s0[3992]; char s1[866]; char end; } glbk__glsl_prog_sfield_haar_light_frag GLBK__TIGHT = {
    "prog/sfield_haar_light.frag\0" "sfield_haar_turn sfield_haar_gloss gbuffer" "\0" "" "\0"
    "SFIELD_GLOSS=0 | SFIELD_GLOSS=1" "\0" "",
    "\n\n\n\n\n\nlayout(location=0)out uvec4 lower;\n"
    "layout(location=1)out uvec4 upper;\n"
    "layout(location=2)out uvec4 light;\n"
    "#if SFIELD_GLOSS\n"
    "layout(location=3)out uvec4 shine;\n"
    "#endif\n"
    "\n\nfloat sfield_tap(uint cube,uint face,ivec2 texel)\n"
    "{\n"
    "texel=sfield_wrap(face,texel);\n"
    "uvec4 quad=texelFetch(glbk_haar_cubes,\n"
    "sfield_square(cube,glbk_haar_batch.columns,face,uvec2(texel)/2u,\n"
    "uvec2(glbk_haar_batch.side/2u)),0);\n"
    "bool right=(texel.x&1)!=0,up=(texel.y&1)!=0;\n"
    "return uintBitsToFloat(up?(right?quad.w:quad.z):(right?quad.y:quad.x));\n"
    "}\n"
    "\n\nvec4 sfield_component(int k,float x)\n"
    "{\n"
    "return mix(vec4(.0),vec4(x),equal(ivec4(k),ivec4(0,1,2,3)));\n"
    "}\n"
    "\n\nivec2 sfield_step(int i){return ivec2((i&1)+2*(i>>2),i>>1&1);}\n"
    "\n\nvec4 sfield_sky(uint face,ivec2 texel)\n"
    "{\n"
    "uint side=glbk_haar_batch.side,at=(face*side+uint(texel.y))*side+uint(texel.x);\n"
    "return uintBitsToFloat(SFIELD_MOVING(glbk_sfield_contents.sky_texel+at));\n"
    "}\n"
    "\n#if SFIELD_GLOSS\n"
    "\nstruct sfield_weights{vec4 a[3],b[3];};\n"
    "\n\nsfield_look sfield_begin_gloss(uint point,uint face,ivec2 corner,inout vec4 a,inout vec4 b,\n"
    "out sfield_weights w)\n"
    "{\n"
    "glbk_point p;\n"
    "sfield_look look;\n"
    "for(int k=0;k<3;k++)w.a[k]=w.b[k]=vec4(.0);\n"
    "bool seen=glbk_read_point(sfield_pixel(point),p);\n"
    "seen=sfield_read_look(p,look)&&seen;\n"
    "int count=seen?int(min(glbk_haar_batch.columns+7u,8u)):0;\n"
    "for(int i=0;i<count;i++){\n"
    "ivec2 texel=corner+sfield_step(i);\n"
    "vec3 kernels=sfield_kernels(look,face,texel);\n"
    "float t=any(greaterThan(kernels,vec3(.0)))?sfield_sky(face,texel).w:.0;\n"
    "a+=sfield_component(i,t);\n"
    "b+=sfield_component(i-4,t);\n"
    "for(int k=0;k<3;k++){\n"
    "w.a[k]+=sfield_component(i,kernels[k]);\n"
    "w.b[k]+=sfield_component(i-4,kernels[k]);\n"
    "}\n"
    "}\n"
    "return look;\n"
    "}\n"
    "#endif\n"
    "\n\nvoid sfield_begin(uint point,uint face,ivec2 corner,inout vec4 a,inout vec4 b)\n"
    "{\n"
    "glbk_point p;\n"
    "if(!glbk_read_point(sfield_pixel(point),p))return;\n"
    "for(int i=0;i<8;i++){\n"
    "ivec2 texel=corner+sfield_step(i);\n"
    "float t=max(dot(sfield_direction(face,texel),p.normal),.0)*sfield_sky(face,texel).w;\n"
    "a+=sfield_component(i,t);\n"
    "b+=sfield_component(i-4,t);\n"
    "}\n"
    "}\n"
    "\n\nvoid sfield_read(uint cube,uint entity,uint face,ivec2 corner,out vec4 p,out vec4 q)\n"
    "{\n"
    "bool turned=sfield_is_turned(entity);\n"
    "ivec2 at=sfield_square(cube,glbk_haar_batch.columns,face,uvec2(corner)/2u,\n"
    "uvec2(glbk_haar_batch.side/2u));\n"
    "p=turned?vec4(.0):uintBitsToFloat(texelFetch(glbk_haar_cubes,at,0));\n"
    "q=turned?vec4(.0):uintBitsToFloat(texelFetch(glbk_haar_cubes,at+ivec2(1,0),0));\n"
    "for(int i=0;i<8&&turned;i++){\n"
    "vec3 d=sfield_direction(face,corner+sfield_step(i));\n"
    "float x=sfield_between(cube,sfield_turn(entity,d));\n"
    "p+=sfield_component(i,x);\n"
    "q+=sfield_component(i-4,x);\n"
    "}\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "uint side=glbk_haar_batch.side,columns=2u*glbk_haar_batch.columns;\n"
    "uvec2 size=uvec2(side/4u,side/2u),here=uvec2(gl_FragCoord.xy),cell=here/size;\n"
    "uint face=cell.x%6u,point=cell.y*columns+cell.x/6u;\n"
    "ivec2 corner=ivec2(here%size*uvec2(4u,2u));\n"
    "vec4 a=vec4(.0),b=vec4(.0),sums=vec4(.0),p,q;\n"
    "lower=upper=light=uvec4(0u);\n"
    "#if SFIELD_GLOSS\n"
    "shine=uvec4(0u);\n"
    "#endif\n"
    "if(point>=glbk_haar_batch.count||cell.x>=6u*columns)return;\n"
    "#if SFIELD_GLOSS\n"
    "vec3 glossy=vec3(.0);\n"
    "sfield_weights w;\n"
    "sfield_look look=sfield_begin_gloss(point,face,corner,a,b,w);\n"
    "if(glbk_haar_batch.round>0u){\n"
    "glossy=uintBitsToFloat(texelFetch(glbk_haar_shine,ivec2(here),0).xyz);\n"
    "#else\n"
    "if(glbk_haar_batch.round==0u){\n"
    "sfield_begin(point,face,corner,a,b);\n"
    "}else{\n"
    "#endif\n"
    "a=uintBitsToFloat(texelFetch(glbk_haar_lower,ivec2(here),0));\n"
    "b=uintBitsToFloat(texelFetch(glbk_haar_upper,ivec2(here),0));\n"
    "sums=uintBitsToFloat(texelFetch(glbk_haar_sums,ivec2(here),0));\n"
    "}\n"
    "bool dark=a==vec4(.0)&&b==vec4(.0);\n"
    "for(uint slot=0u;slot<glbk_haar_batch.slots&&!dark;slot++){\n"
    "uvec4 what=texelFetch(glbk_haar_what,ivec2(slot,point),0);\n"
    "if(what.x==SFIELD_EMPTY)break;\n"
    "sfield_read(point*glbk_haar_batch.slots+slot,what.z,face,corner,p,q);\n"
    "if(what.x==SFIELD_OCCLUDER||what.x==SFIELD_OWN){\n"
    "a-=a*p;\n"
    "b-=b*q;\n"
    "}else{\n"
    "bvec3 channel=equal(uvec3(what.x-SFIELD_LIGHT),uvec3(0u,1u,2u));\n"
    "vec3 tint=uintBitsToFloat(sfield_entity(what.z,6u).xyz)*vec3(channel);\n"
    "#if SFIELD_GLOSS\n"
    "p*=a;\n"
    "q*=b;\n",
    "sums.xyz+=(dot(p,w.a[0])+dot(q,w.b[0]))*tint;\n"
    "glossy+=(dot(p,w.a[1])+dot(q,w.b[1]))*tint*look.facing;\n"
    "glossy+=(dot(p,w.a[2])+dot(q,w.b[2]))*tint;\n"
    "#else\n"
    "sums.xyz+=(dot(a,p)+dot(b,q))*tint;\n"
    "#endif\n"
    "}\n"
    "}\n"
    "for(int i=0;i<8&&!dark&&glbk_haar_batch.last!=0u;i++){\n"
    "vec4 left=sfield_component(i,1.),right=sfield_component(i-4,1.);\n"
    "float t=dot(left,a)+dot(right,b);\n"
    "vec3 sky=sfield_sky(face,corner+sfield_step(i)).xyz;\n"
    "#if SFIELD_GLOSS\n"
    "float cosine=max(dot(sfield_direction(face,corner+sfield_step(i)),look.n),.0);\n"
    "sums+=t*vec4((dot(left,w.a[0])+dot(right,w.b[0]))*sky,cosine);\n"
    "glossy+=t*(dot(left,w.a[1])+dot(right,w.b[1]))*sky*look.facing;\n"
    "glossy+=t*(dot(left,w.a[2])+dot(right,w.b[2]))*sky;\n"
    "#else\n"
    "sums+=vec4(t*sky,t);\n"
    "#endif\n"
    "}\n"
    "lower=floatBitsToUint(a);\n"
    "upper=floatBitsToUint(b);\n"
    "light=floatBitsToUint(sums);\n"
    "#if SFIELD_GLOSS\n"
    "shine=uvec4(floatBitsToUint(glossy),0u);\n"
    "#endif\n"
    "}\n", 0
};

static const struct { char facts[69];
    char s0[1234]; char end; } glbk__glsl_prog_sfield_haar_list_frag GLBK__TIGHT = {
    "prog/sfield_haar_list.frag\0" "sfield_haar_list gbuffer" "\0" "" "\0"
    "SFIELD_BANDS=1" "\0" "",
    "\n\n\n\n\nlayout(location=0)out uvec4 what;\n"
    "layout(location=1)out uvec4 corner;\n"
    "layout(location=2)out uvec4 weight;\n"
    "layout(location=3)out uvec4 met;\n"
    "\nvoid main()\n"
    "{\n"
    "uint rest=uint(gl_FragCoord.x),point=uint(gl_FragCoord.y),id=0u,root=0u;\n"
    "ivec2 at=sfield_pixel(point);\n"
    "float d2=-1.;\n"
    "glbk_point p;\n"
    "bool seen=glbk_read_point(at,p),first=glbk_haar_batch.round==0u;\n"
    "what=corner=weight=uvec4(0u);\n"
    "met=uvec4(0u,SFIELD_NONE,0u,0u);\n"
    "if(!first){\n"
    "uvec4 last=texelFetch(glbk_haar_met,ivec2(glbk_haar_batch.slots-1u,point),0);\n"
    "d2=uintBitsToFloat(last.x);\n"
    "id=last.y;\n"
    "}\n"
    "if(first&&glbk_haar_batch.own!=0u)root=texelFetch(glbk_sfield_self,ivec3(at,0),0).x;\n"
    "if(!seen||id==SFIELD_NONE)return;\n"
    "if(root!=0u&&rest==0u){\n"
    "bool turns=p.entity-1u<glbk_sfield_contents.entity_count;\n"
    "what=uvec4(SFIELD_OWN,root,turns?p.entity-1u:SFIELD_NOBODY,0u);\n"
    "met=uvec4(floatBitsToUint(d2),id,0u,0u);\n"
    "return;\n"
    "}\n"
    "if(root!=0u)rest--;\n"
    "for(uint more=rest+1u;more>0u&&id!=SFIELD_NONE;){\n"
    "sfield_find(p.position,p.normal,p.entity,0u,1u,d2,id);\n"
    "bool hides=(id&3u)==3u&&id!=SFIELD_NONE;\n"
    "if(!hides||!sfield_hidden(p.position,p.normal,p.entity,0u,1u,d2,id))more--;\n"
    "}\n"
    "if(id==SFIELD_NONE)return;\n"
    "met=uvec4(floatBitsToUint(d2),id,0u,0u);\n"
    "sfield_surround(p.position,d2,id,what,corner,weight);\n"
    "}\n", 0
};

static const struct { char facts[276];
    char s0[3997]; char s1[3985]; char s2[1452]; char end; } glbk__glsl_prog_sfield_haar_shade_comp GLBK__TIGHT = {
    "prog/sfield_haar_shade.comp\0" "sfield_haar_turn sfield_haar_list sfield_haar_gloss gbuffer" "\0" "" "\0"
    "SFIELD_BANDS=1 SFIELD_SIDE=16 SFIELD_GLOSS=0 | SFIELD_BANDS=1 SFIELD_SIDE=32 SFIELD_GLOSS=0 | SFIELD_BANDS=1 SFIELD_SIDE=16 SFIELD_GLOSS=1 | SFIELD_BANDS=1 SFIELD_SIDE=32 SFIELD_GLOSS=1" "\0" "",
    "\n\n\n\n\n\n\n\n\n#ifndef SFIELD_SIDE\n"
    "#define SFIELD_SIDE 16\n"
    "#endif\n"
    "#define SFIELD_FACE uint(SFIELD_SIDE * SFIELD_SIDE)\n"
    "#define SFIELD_GROUP 64u\n"
    "#define SFIELD_RIM uint(SFIELD_SIDE + 2)\n"
    "#define SFIELD_EACH(i, count) (uint i = gl_LocalInvocationIndex; i < count; i += SFIELD_GROUP)\n"
    "#define SFIELD_HAS(faces, face) ((faces >> (face) & 1u) != 0u)\n"
    "layout(local_size_x=64)in;\n"
    "\nshared float sfield_w[6*(SFIELD_SIDE+2)*(SFIELD_SIDE+2)];\n"
    "#if SFIELD_SIDE > 16\n"
    "#define SFIELD_PLANES (1u + 3u * uint(SFIELD_GLOSS))\n"
    "#define SFIELD_T(i) glbk_haar_left[sfield_plane(0u) + (i)]\n"
    "#else\n"
    "#define SFIELD_PLANES (3u * uint(SFIELD_GLOSS))\n"
    "shared float sfield_t[6*SFIELD_SIDE*SFIELD_SIDE];\n"
    "#define SFIELD_T(i) sfield_t[i]\n"
    "#endif\n"
    "#if SFIELD_GLOSS\n"
    "#define SFIELD_CHAINS 3u\n"
    "#define SFIELD_K(k, i) glbk_haar_left[sfield_plane((k) + SFIELD_PLANES - 3u) + (i)]\n"
    "shared vec4 sfield_shines[64];\n"
    "#else\n"
    "#define SFIELD_CHAINS 1u\n"
    "#define SFIELD_K(k, i) 1.0\n"
    "#endif\n"
    "shared uint sfield_least,sfield_next,sfield_covered,sfield_faces;\n"
    "shared uvec3 sfield_samples[16];\n"
    "shared vec4 sfield_parts[64];\n"
    "\n\nvoid sfield_wait()\n"
    "{\n"
    "memoryBarrierShared();\n"
    "barrier();\n"
    "}\n"
    "\n\nuint sfield_plane(uint number)\n"
    "{\n"
    "uint group=gl_WorkGroupID.y*gl_NumWorkGroups.x+gl_WorkGroupID.x;\n"
    "return(group*SFIELD_PLANES+number)*6u*SFIELD_FACE;\n"
    "}\n"
    "\n\nuint sfield_at(uint face,uint x,uint y){return(face*SFIELD_RIM+y+1u)*SFIELD_RIM+x+1u;}\n"
    "\nfloat sfield_tap(uint cube,uint face,ivec2 texel)\n"
    "{\n"
    "return sfield_w[cube+sfield_at(face,uint(texel.x),uint(texel.y))];\n"
    "}\n"
    "\n\nivec2 sfield_texel_of(uint i)\n"
    "{\n"
    "return ivec2(i%uint(SFIELD_SIDE),i/uint(SFIELD_SIDE)%uint(SFIELD_SIDE));\n"
    "}\n"
    "\nuint sfield_w_of(uint i)\n"
    "{\n"
    "ivec2 texel=sfield_texel_of(i);\n"
    "return sfield_at(i/SFIELD_FACE,uint(texel.x),uint(texel.y));\n"
    "}\n"
    "\n\nvec4 sfield_sky(uint i){return uintBitsToFloat(SFIELD_MOVING(glbk_sfield_contents.sky_texel+i));}\n"
    "\n\nfloat sfield_short(uint word){return float(int(word<<16)>>16);}\n"
    "\n\n\nvoid sfield_transform(bool to_texels,uint faces)\n"
    "{\n"
    "for(uint step=1u;step<uint(SFIELD_SIDE);step*=2u){\n"
    "uint quarter=to_texels?uint(SFIELD_SIDE)/2u/step:step;\n"
    "uint row=uint(SFIELD_SIDE)/2u/quarter;\n"
    "sfield_wait();\n"
    "for SFIELD_EACH(i,6u*row*row){\n"
    "uint face=i/(row*row),x=i%row,y=i/row%row;\n"
    "if(!SFIELD_HAS(faces,face))continue;\n"
    "uint at=sfield_at(face,2u*quarter*x,2u*quarter*y),up=at+quarter*SFIELD_RIM;\n"
    "float a=sfield_w[at]+sfield_w[at+quarter],b=sfield_w[at]-sfield_w[at+quarter];\n"
    "float c=sfield_w[up]+sfield_w[up+quarter],d=sfield_w[up]-sfield_w[up+quarter];\n"
    "sfield_w[at]=.5*(a+c);\n"
    "sfield_w[at+quarter]=.5*(b+d);\n"
    "sfield_w[up]=.5*(a-c);\n"
    "sfield_w[up+quarter]=.5*(b-d);\n"
    "}\n"
    "}\n"
    "sfield_wait();\n"
    "}\n"
    "\nvoid sfield_clear(uint faces)\n"
    "{\n"
    "sfield_wait();\n"
    "for SFIELD_EACH(i,6u*SFIELD_FACE)\n"
    "if(SFIELD_HAS(faces,i/SFIELD_FACE))sfield_w[sfield_w_of(i)]=.0;\n"
    "}\n"
    "\n\n\nvoid sfield_expand(uint count,uint channel,bool turned)\n"
    "{\n"
    "for(uint k=0u;k<count;k++){\n"
    "uvec3 list=sfield_samples[k];\n"
    "if(list.y==0u)continue;\n"
    "sfield_wait();\n"
    "for SFIELD_EACH(i,(list.y+3u)/4u){\n"
    "uvec4 words=SFIELD_TEXEL(list.x+i);\n"
    "for(int n=0;n<4;n++){\n"
    "if(4u*i+uint(n)>=list.y||(channel<3u&&(n&1)!=0))continue;\n"
    "uint value=channel==1u?words[n|1]>>16:channel==2u?words[n|1]:words[n];\n"
    "sfield_w[words[n]>>16]+=uintBitsToFloat(list.z)*sfield_short(value);\n"
    "}\n"
    "}\n"
    "}\n"
    "sfield_transform(true,sfield_faces);\n"
    "if(!turned)return;\n"
    "for SFIELD_EACH(i,24u*(SFIELD_RIM-1u)){\n"
    "uint face=i/(4u*(SFIELD_RIM-1u)),from=face,along=i%(SFIELD_RIM-1u);\n"
    "uint side=i/(SFIELD_RIM-1u)%4u,last=SFIELD_RIM-1u;\n"
    "uvec2 at=side<2u?uvec2(along+side,side*last)\n"
    ":uvec2((side-2u)*last,along+3u-side);\n"
    "ivec2 texel=sfield_wrap(from,ivec2(at)-1);\n"
    "sfield_w[(face*SFIELD_RIM+at.y)*SFIELD_RIM+at.x]=sfield_tap(0u,from,texel);\n"
    "}\n"
    "sfield_wait();\n"
    "}\n"
    "\n\nvec3 sfield_shine(uint count)\n"
    "{\n"
    "vec3 sum=vec3(.0);\n"
    "for(uint k=0u;k<count;k++){\n"
    "uvec3 list=sfield_samples[k];\n"
    "for SFIELD_EACH(i,(list.y+3u)/4u){\n"
    "uvec4 words=SFIELD_TEXEL(list.x+i);\n"
    "for(int n=0;n<4;n+=2){\n"
    "vec3 rgb=vec3(sfield_short(words[n]),sfield_short(words[n+1]>>16),\n"
    "sfield_short(words[n+1]));\n"
    "if(4u*i+uint(n)<list.y)\n"
    "sum+=sfield_w[words[n]>>16]*uintBitsToFloat(list.z)*rgb;\n"
    "}\n"
    "}\n"
    "}\n"
    "return sum;\n"
    "}\n",
    "\n\nmat3 sfield_turn_of(uint entity)\n"
    "{\n"
    "return transpose(mat3(uintBitsToFloat(sfield_entity(entity,2u).xyz),\n"
    "uintBitsToFloat(sfield_entity(entity,3u).xyz),\n"
    "uintBitsToFloat(sfield_entity(entity,4u).xyz)));\n"
    "}\n"
    "\n\nfloat sfield_seen(uint i,mat3 turn,uint faces)\n"
    "{\n"
    "vec3 d=turn*sfield_from_face(i/SFIELD_FACE,sfield_middle(sfield_texel_of(i)));\n"
    "vec2 st;\n"
    "uint face=sfield_to_face(d,st);\n"
    "bool inside=max(abs(st.x),abs(st.y))<1.-1./float(SFIELD_SIDE);\n"
    "float seen=.0;\n"
    "if(!inside||SFIELD_HAS(faces,face))seen=sfield_between(0u,d);\n"
    "return seen;\n"
    "}\n"
    "\n\nvoid sfield_hide(uint count,uint entity)\n"
    "{\n"
    "bool turned=sfield_is_turned(entity);\n"
    "uint faces=sfield_faces;\n"
    "if(faces==0u)return;\n"
    "sfield_expand(count,3u,turned);\n"
    "if(turned){\n"
    "mat3 turn=sfield_turn_of(entity);\n"
    "for SFIELD_EACH(i,6u*SFIELD_FACE)\n"
    "if(SFIELD_T(i)!=.0){\n"
    "float hidden=sfield_seen(i,turn,faces);\n"
    "if(hidden!=.0)SFIELD_T(i)*=1.-hidden;\n"
    "}\n"
    "}else{\n"
    "for SFIELD_EACH(i,6u*SFIELD_FACE)\n"
    "if(SFIELD_HAS(faces,i/SFIELD_FACE))SFIELD_T(i)*=1.-sfield_w[sfield_w_of(i)];\n"
    "}\n"
    "sfield_clear(faces);\n"
    "}\n"
    "\n\nvoid sfield_light(uint entity,inout mat3 sums)\n"
    "{\n"
    "uint faces=sfield_faces;\n"
    "vec3 tint=uintBitsToFloat(sfield_entity(entity,6u).xyz);\n"
    "if(faces==0u)return;\n"
    "if(sfield_is_turned(entity)){\n"
    "mat3 turn=sfield_turn_of(entity);\n"
    "for(uint c=0u;c<3u;c++){\n"
    "vec3 channel=tint*vec3(equal(uvec3(c),uvec3(0u,1u,2u)));\n"
    "sfield_expand(16u,c,true);\n"
    "for SFIELD_EACH(i,6u*SFIELD_FACE)\n"
    "if(SFIELD_T(i)!=.0){\n"
    "vec3 rgb=SFIELD_T(i)*sfield_seen(i,turn,faces)*channel;\n"
    "sums[0]+=SFIELD_K(0u,i)*rgb;\n"
    "#if SFIELD_GLOSS\n"
    "sums[1]+=SFIELD_K(1u,i)*rgb;\n"
    "sums[2]+=SFIELD_K(2u,i)*rgb;\n"
    "#endif\n"
    "}\n"
    "sfield_clear(faces);\n"
    "}\n"
    "}else{\n"
    "for(uint k=0u;k<SFIELD_CHAINS;k++){\n"
    "for SFIELD_EACH(i,6u*SFIELD_FACE)\n"
    "if(SFIELD_HAS(faces,i/SFIELD_FACE))\n"
    "sfield_w[sfield_w_of(i)]=SFIELD_T(i)*SFIELD_K(k,i);\n"
    "sfield_transform(false,faces);\n"
    "vec3 rgb=sfield_shine(16u)*tint;\n"
    "sums[0]+=k==0u?rgb:vec3(.0);\n"
    "sums[1]+=k==1u?rgb:vec3(.0);\n"
    "sums[2]+=k==2u?rgb:vec3(.0);\n"
    "sfield_clear(faces);\n"
    "}\n"
    "}\n"
    "}\n"
    "\n\nbool sfield_choose(float mine,uint id,out float d2,out uint chosen)\n"
    "{\n"
    "if(gl_LocalInvocationIndex==0u){\n"
    "sfield_least=sfield_next=SFIELD_NONE;\n"
    "sfield_covered=sfield_faces=0u;\n"
    "}\n"
    "sfield_wait();\n"
    "if(id!=SFIELD_NONE)atomicMin(sfield_least,floatBitsToUint(mine));\n"
    "sfield_wait();\n"
    "if(id!=SFIELD_NONE&&floatBitsToUint(mine)==sfield_least)atomicMin(sfield_next,id);\n"
    "sfield_wait();\n"
    "d2=uintBitsToFloat(sfield_least);\n"
    "chosen=sfield_next;\n"
    "return chosen!=SFIELD_NONE;\n"
    "}\n"
    "\n\nvoid sfield_collect(vec3 position,float d2,uint id)\n"
    "{\n"
    "uvec4 what,corner,weight,head=uvec4(0u);\n"
    "float share;\n"
    "if(gl_LocalInvocationIndex>=16u)return;\n"
    "sfield_surround(position,d2,id,what,corner,weight);\n"
    "uint at=sfield_share(what,uintBitsToFloat(corner),weight,SFIELD_TEXEL(what.w).w,\n"
    "gl_LocalInvocationIndex,share);\n"
    "if(share>.0)head=SFIELD_TEXEL(SFIELD_TEXEL(what.w+1u).y+at);\n"
    "share*=uintBitsToFloat(head.z);\n"
    "sfield_samples[gl_LocalInvocationIndex]=uvec3(head.xy,floatBitsToUint(share));\n"
    "atomicOr(sfield_faces,head.w);\n"
    "}\n"
    "\n\n\nmat3 sfield_walk(glbk_point p)\n"
    "{\n"
    "mat3 sum=mat3(.0);\n"
    "float mine=-1.,d2;\n"
    "uint me=gl_LocalInvocationIndex,found=0u,id;\n"
    "sfield_find(p.position,p.normal,p.entity,me,SFIELD_GROUP,mine,found);\n"
    "while(sfield_choose(mine,found,d2,id)){\n"
    "bool hides=(id&3u)==3u;\n"
    "if(found==id){\n"
    "if(!hides)found+=2u;\n"
    "sfield_find(p.position,p.normal,p.entity,me,SFIELD_GROUP,mine,found);\n"
    "}\n"
    "if(hides&&sfield_hidden(p.position,p.normal,p.entity,me,SFIELD_GROUP,d2,id))\n"
    "atomicOr(sfield_covered,1u);\n"
    "sfield_collect(p.position,d2,id);\n"
    "sfield_wait();\n"
    "if(hides&&sfield_covered==0u)sfield_hide(16u,id>>2);\n"
    "if(!hides)sfield_light(id>>2,sum);\n"
    "sfield_wait();\n"
    "}\n"
    "return sum;\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(glbk_haar_batch.left,glbk_haar_batch.bottom)+ivec2(gl_WorkGroupID.xy);\n"
    "uint me=gl_LocalInvocationIndex,own=0u;\n"
    "float open=.0;\n"
    "vec4 scale=vec4(1./3.14159265),light;\n"
    "mat3 sums=mat3(.0);\n"
    "glbk_point p;\n"
    "bool seen=glbk_read_point(at,p);\n"
    "#if SFIELD_GLOSS\n"
    "sfield_look look;\n"
    "seen=sfield_read_look(p,look)&&seen;\n"
    "if(look.metal)scale.xyz=1.-look.facing;\n"
    "#endif\n"
    "if(seen){\n"
    "for SFIELD_EACH(i,6u*SFIELD_FACE){\n"
    "#if SFIELD_GLOSS\n",
    "vec3 kernels=sfield_kernels(look,i/SFIELD_FACE,sfield_texel_of(i));\n"
    "SFIELD_T(i)=any(greaterThan(kernels,vec3(.0)))?sfield_sky(i).w:.0;\n"
    "for(uint k=0u;k<3u;k++)SFIELD_K(k,i)=kernels[k];\n"
    "#else\n"
    "vec3 direction=sfield_direction(i/SFIELD_FACE,sfield_texel_of(i));\n"
    "SFIELD_T(i)=max(dot(direction,p.normal),.0)*sfield_sky(i).w;\n"
    "#endif\n"
    "sfield_w[sfield_w_of(i)]=.0;\n"
    "}\n"
    "if(glbk_haar_batch.own!=0u)own=texelFetch(glbk_sfield_self,ivec3(at,0),0).x;\n"
    "if(own!=0u){\n"
    "bool turns=p.entity-1u<glbk_sfield_contents.entity_count;\n"
    "uvec4 head=SFIELD_TEXEL(own);\n"
    "if(me==0u)sfield_samples[0]=head.xyz;\n"
    "if(me==0u)sfield_faces=head.w;\n"
    "sfield_wait();\n"
    "sfield_hide(1u,turns?p.entity-1u:SFIELD_NOBODY);\n"
    "sfield_wait();\n"
    "}\n"
    "sums=sfield_walk(p);\n"
    "for SFIELD_EACH(i,6u*SFIELD_FACE)\n"
    "if(glbk_haar_batch.last!=0u){\n"
    "vec3 sky=SFIELD_T(i)*sfield_sky(i).xyz;\n"
    "float t=SFIELD_T(i);\n"
    "sums[0]+=SFIELD_K(0u,i)*sky;\n"
    "#if SFIELD_GLOSS\n"
    "sums[1]+=SFIELD_K(1u,i)*sky;\n"
    "sums[2]+=SFIELD_K(2u,i)*sky;\n"
    "t*=max(dot(sfield_direction(i/SFIELD_FACE,sfield_texel_of(i)),p.normal),.0);\n"
    "#endif\n"
    "open+=t;\n"
    "}\n"
    "}\n"
    "light=vec4(sums[0],open);\n"
    "sfield_parts[me]=light;\n"
    "#if SFIELD_GLOSS\n"
    "vec4 shine=vec4(sums[1]*look.facing+sums[2],.0);\n"
    "sfield_shines[me]=shine;\n"
    "#endif\n"
    "sfield_wait();\n"
    "if(me!=0u)return;\n"
    "for(uint i=1u;i<SFIELD_GROUP;i++)light+=sfield_parts[i];\n"
    "imageStore(glbk_sfield_light_image,at,light*scale);\n"
    "#if SFIELD_GLOSS\n"
    "for(uint i=1u;i<SFIELD_GROUP;i++)shine+=sfield_shines[i];\n"
    "imageStore(glbk_sfield_gloss_image,at,shine);\n"
    "#endif\n"
    "}\n", 0
};

static const struct { char facts[80];
    char s0[1001]; char end; } glbk__glsl_prog_sfield_haar_sum_frag GLBK__TIGHT = {
    "prog/sfield_haar_sum.frag\0" "sfield_haar gbuffer" "\0" "" "\0"
    "SFIELD_GLOSS=0 | SFIELD_GLOSS=1" "\0" "",
    "\n\n\n\n#ifndef SFIELD_GLOSS\n"
    "#define SFIELD_GLOSS 0\n"
    "#endif\n"
    "layout(location=0)out glbk_color light;\n"
    "#if SFIELD_GLOSS\n"
    "layout(location=1)out glbk_color gloss;\n"
    "#endif\n"
    "\nvoid main()\n"
    "{\n"
    "uint side=glbk_haar_batch.side,columns=2u*glbk_haar_batch.columns;\n"
    "uvec2 at=uvec2(gl_FragCoord.xy)-uvec2(glbk_haar_batch.left,glbk_haar_batch.bottom);\n"
    "uint point=at.y*glbk_haar_batch.width+at.x;\n"
    "ivec2 size=ivec2(6u*(side/4u),side/2u),first=ivec2(point%columns,point/columns)*size;\n"
    "vec4 sum=vec4(.0),scale=vec4(1./3.14159265);\n"
    "#if SFIELD_GLOSS\n"
    "vec4 glossy=vec4(.0);\n"
    "glbk_point p;\n"
    "if(glbk_read_point(ivec2(gl_FragCoord.xy),p)&&p.kind==GLBK_METAL_ROUGH)\n"
    "scale.xyz=.96-clamp(p.metallic,.0,1.)*(clamp(p.diffuse,.0,1.)-.04);\n"
    "#endif\n"
    "for(int y=0;y<size.y;y++)\n"
    "for(int x=0;x<size.x;x++){\n"
    "sum+=uintBitsToFloat(texelFetch(glbk_haar_sums,first+ivec2(x,y),0));\n"
    "#if SFIELD_GLOSS\n"
    "glossy+=uintBitsToFloat(texelFetch(glbk_haar_shine,first+ivec2(x,y),0));\n"
    "#endif\n"
    "}\n"
    "light=glbk_pack(sum*scale);\n"
    "#if SFIELD_GLOSS\n"
    "gloss=glbk_pack(glossy);\n"
    "#endif\n"
    "}\n", 0
};

static const glbk_file glbk__haar_files[] = {
    { (const char *)&glbk__glsl_lib_haar_batch_glsl },
    { (const char *)&glbk__glsl_lib_haar_bindings_glsl },
    { (const char *)&glbk__glsl_lib_sfield_haar_glsl },
    { (const char *)&glbk__glsl_lib_sfield_haar_gloss_glsl },
    { (const char *)&glbk__glsl_lib_sfield_haar_list_glsl },
    { (const char *)&glbk__glsl_lib_sfield_haar_turn_glsl },
    { (const char *)&glbk__glsl_prog_sfield_haar_cubes_frag },
    { (const char *)&glbk__glsl_prog_sfield_haar_light_frag },
    { (const char *)&glbk__glsl_prog_sfield_haar_list_frag },
    { (const char *)&glbk__glsl_prog_sfield_haar_shade_comp },
    { (const char *)&glbk__glsl_prog_sfield_haar_sum_frag }
};


/* ==== src/gl_wavelets/part.h ==== */

/* ---- wavelets: this header's GLSL, textures and block, by which programs find them ---- */

GLBK__LISTS_CODE(haar, HAAR)
GLBK__PART_DATA(haar)

GLBK__DEF const glbk_part *glbk__wavelets(void) { return &glbk__haar_part; }

/* ==== src/gl_wavelets/trees.h ==== */

/* ---- wavelets: fields as trees ---- */

enum { GLBK__HAAR_SQUARES = 1365 };     /* of a face of 64 x 64 texels: 1 + 4 + 16 + ... */

/* A face of a sample while its tree is made. The squares of all levels are numbered one after the other, so
   that the quarters of square k are squares 4 k + 1 to 4 k + 4. */
typedef struct glbk__haar_tree {
    uint32_t side, channels, squares;   /* squares: of all levels */
    float    scale;                     /* of the sample */
    float    coef[3][4096];             /* 0 between two faces */
    float    mean[3][4 * GLBK__HAAR_SQUARES + 1];
    uint8_t  mark[GLBK__HAAR_SQUARES];          /* 1: wavelets lie in the square or in its quarters */
} glbk__haar_tree;

/* The lists of a file of wavelets. */
typedef struct glbk__haar_lists {
    const uint8_t *offsets, *scales, *entries;
    uint32_t       samples, words;      /* words of an entry */
} glbk__haar_lists;

static glbk__haar_lists glbk__haar_lists_of(const uint8_t *bytes, const glbk__sfield_view *v)
{
    glbk__haar_lists l;
    l.offsets = bytes + v->scales;
    l.samples = v->samples;
    l.scales = l.offsets + 4 * ((size_t)v->samples + 1);
    l.entries = l.scales + 4 * (size_t)v->samples;
    l.words = v->stride;
    return l;
}

/* Returns the bytes of entry i. glbk__haar_face moves *end past those entries of a sample whose number is
   below `texels`: there the entries of the next face begin. */
static const uint8_t *glbk__haar_entry(const glbk__haar_lists *l, size_t i)
{
    return l->entries + 4 * i * l->words;
}

static void glbk__haar_face(const glbk__haar_lists *l, uint32_t sample, uint32_t texels, size_t *end)
{
    const size_t last = glbk_haar__get_u32(l->offsets + 4 * ((size_t)sample + 1));
    while (*end < last && glbk_haar__get_u32(glbk__haar_entry(l, *end)) >> 16 < texels) (*end)++;
}

/* Marks the squares of a face's entries and all above these. Returns how many nodes the tree has but the
   root. */
static uint32_t glbk__haar_mark(glbk__haar_tree *t, const glbk__haar_lists *l, size_t from, size_t end)
{
    const uint32_t in_face = t->side * t->side - 1;
    uint32_t nodes = 0;
    memset(t->mark, 0, t->squares);
    for (; from < end; from++) {
        uint32_t k = glbk_haar__get_u32(glbk__haar_entry(l, from)) >> 16 & in_face;
        if (!k) continue;
        for (k = (k - 1) / 3; k && !t->mark[k]; k = (k - 1) / 4) {
            t->mark[k] = 1;
            nodes++;
        }
    }
    return nodes;
}

/* Writes the coefficients of a face's entries, or zeros in their places. */
static void glbk__haar_scatter(glbk__haar_tree *t, const glbk__haar_lists *l, size_t from, size_t end,
                               float scale)
{
    const uint32_t in_face = t->side * t->side - 1;
    for (; from < end; from++) {
        const uint8_t *e = glbk__haar_entry(l, from);
        const uint32_t first = glbk_haar__get_u32(e), at = first >> 16 & in_face;
        uint32_t value[3], c;
        value[0] = first;
        value[1] = l->words > 1 ? glbk_haar__get_u32(e + 4) >> 16 : 0;
        value[2] = l->words > 1 ? glbk_haar__get_u32(e + 4) : 0;
        for (c = 0; c < t->channels; c++)
            t->coef[c][at] = scale * ((float)(int32_t)((value[c] & 0xffffu) ^ 0x8000u) - 32768.0f);
    }
}

/* Computes the means of the quarters of square k, which has so many texels a side. Returns the greatest. */
static float glbk__haar_quarter(glbk__haar_tree *t, uint32_t k, float side)
{
    float most = 0, scale = 1 / side;
    uint32_t c, q;
    for (c = 0; c < t->channels; c++)
        for (q = 0; q < 4; q++) {
            const float *w = t->coef[c] + 1 + 3 * k, x = q & 1 ? -scale : scale, y = q & 2 ? -scale : scale;
            const float z = q == 0 || q == 3 ? scale : -scale;
            const float mean = t->mean[c][k] + x * w[0] + y * w[1] + z * w[2];
            t->mean[c][4 * k + 1 + q] = mean;
            most = fabsf(mean) > most ? fabsf(mean) : most;
        }
    return most;
}

/* Writes the node of square k, whose quarters' first node is texel `below` of the table. Returns how many
   quarters have a node. */
static uint32_t glbk__haar_node(glbk__haar_tree *t, uint32_t k, float side, uint32_t below,
                                glbk__sfield_stage *s)
{
    const float most = glbk__haar_quarter(t, k, side), scale = most / 32767;
    uint32_t *texel = glbk__sfield_texel(s), *second = texel;
    uint32_t q, c, nodes = 0, mask = 0;
    for (q = 0; q < 4; q++) {
        const uint32_t quarter = 4 * k + 1 + q;
        if (quarter >= t->squares || !t->mark[quarter]) continue;
        mask |= 1u << q;
        nodes++;
    }
    texel[2] = mask << 28 | (mask ? below : 0);     /* past the last of 2^28 texels it has 29 bits */
    memcpy(texel + 3, &scale, 4);
    for (c = 0; c < t->channels; c++) {
        if (c == 1) second = glbk__sfield_texel(s);
        for (q = 0; q < 4; q++) {
            const float x = scale > 0 ? t->mean[c][4 * k + 1 + q] / scale : 0;
            const uint32_t bits = (uint32_t)(int32_t)(x + (x < 0 ? -0.5f : 0.5f)) & 0xffffu;
            second[(c > 1 ? 2 : 0) + q / 2] |= bits << q % 2 * 16;
        }
    }
    return nodes;
}

/* Writes the tree of a face: its root to one stage, all other nodes to the other, level by level. */
static void glbk__haar_plant(glbk__haar_tree *t, glbk__sfield_stage *roots, glbk__sfield_stage *nodes)
{
    const uint32_t step = t->channels > 1 ? 2 : 1;
    uint32_t k, level_end = 1, below = (uint32_t)(nodes->at + nodes->count), c;
    float side = (float)t->side;
    for (c = 0; c < t->channels; c++) t->mean[c][0] = t->coef[c][0] / side;
    for (k = 0; k < t->squares; k++) {
        if (k == level_end) {
            level_end = 4 * level_end + 1;
            side *= 0.5f;
        }
        if (!k || t->mark[k]) below += step * glbk__haar_node(t, k, side, below, k ? nodes : roots);
    }
}

/* Counts the nodes of a file but the roots or, with stages, writes all trees. */
static uint64_t glbk__haar_trees(glbk__haar_tree *t, const glbk__haar_lists *l,
                                 glbk__sfield_stage *roots, glbk__sfield_stage *nodes)
{
    const uint32_t texels = t->side * t->side;
    uint64_t count = 0;
    uint32_t sample, face;
    for (sample = 0; sample < l->samples; sample++) {
        size_t from = glbk_haar__get_u32(l->offsets + 4 * (size_t)sample), end = from;
        for (face = 0; face < 6; face++, from = end) {
            glbk__haar_face(l, sample, (face + 1) * texels, &end);
            count += glbk__haar_mark(t, l, from, end);
            if (!roots) continue;
            glbk__haar_scatter(t, l, from, end, glbk_haar__get_f32(l->scales + 4 * (size_t)sample));
            glbk__haar_plant(t, roots, nodes);
            glbk__haar_scatter(t, l, from, end, 0);
        }
    }
    return count;
}

/* ==== src/gl_wavelets/lists.h ==== */

/* ---- wavelets: fields as lists of coefficients, for compute shaders ----

   A compute shader adds the lists round a point up in shared memory, as the CPU does, where fragment shaders
   have to read each texel from trees by itself. The lists are those of a file of sfield_write, but for the
   number of a coefficient, which becomes its place in shared memory. */

enum { GLBK__HAAR_SHARED = 32 };        /* texels a side that compute shaders have shared memory for */

/* Finds the column and the row of texel i of a face, from its place in Morton order. */
static void glbk__haar_unfold(uint32_t i, uint32_t *x, uint32_t *y)
{
    uint32_t bit;
    for (*x = *y = bit = 0; bit < 6; bit++) {
        *x |= (i >> 2 * bit & 1) << bit;
        *y |= (i >> (2 * bit + 1) & 1) << bit;
    }
}

/* Returns the place of a coefficient in W of prog/sfield_haar_shade.comp: wavelet k of a square stands where
   quarter k of the square begins. */
static uint32_t glbk__haar_place(uint32_t side, uint32_t index)
{
    const uint32_t texels = side * side;
    uint32_t squares = 1, at = index & (texels - 1), x, y;
    if (at) {
        while (4 * squares <= at) squares *= 4;
        at = texels / (4 * squares) * (4 * ((at - squares) / 3) + (at - squares) % 3 + 1);
    }
    glbk__haar_unfold(at, &x, &y);
    return (index / texels * (side + 2) + y + 1) * (side + 2) + x + 1;
}

/* Counts the texels of the entries of a file or, with stages, writes its lists: a texel for each sample to
   one stage, entries to the other. */
static uint64_t glbk__haar_copy(const glbk__haar_tree *t, const glbk__haar_lists *l,
                                glbk__sfield_stage *samples, glbk__sfield_stage *entries)
{
    uint32_t sample, word, *texel, *to = NULL;
    uint64_t count = 0;
    for (sample = 0; sample < l->samples; sample++) {
        const uint32_t first = glbk_haar__get_u32(l->offsets + 4 * (size_t)sample),
                       end = glbk_haar__get_u32(l->offsets + 4 * ((size_t)sample + 1)),
                       words = (end - first) * l->words;
        const uint8_t *from = glbk__haar_entry(l, first);
        count += (words + 3) / 4;
        if (!samples) continue;
        texel = glbk__sfield_texel(samples);
        texel[0] = (uint32_t)(entries->at + entries->count);
        texel[1] = words;
        texel[2] = glbk_haar__get_u32(l->scales + 4 * (size_t)sample);
        for (word = 0; word < words; word++) {
            const uint32_t entry = glbk_haar__get_u32(from + 4 * (size_t)word), index = entry >> 16;
            if (word % 4 == 0) to = glbk__sfield_texel(entries);
            to[word % 4] = entry;
            if (word % l->words) continue;
            to[word % 4] = glbk__haar_place(t->side, index) << 16 | (entry & 0xffffu);
            texel[3] |= 1u << index / (t->side * t->side);
        }
    }
    return count;
}

/* ==== src/gl_wavelets/scene.h ==== */

/* ---- wavelets: scenes ---- */

enum { GLBK__HAAR_IS_SELF = 2 };        /* a kind of glbk_sfield_field.source */

/* Writes the first texels of a field, up to its roots. Those of harmonics have the same places. */
static void glbk__haar_head(glbk__sfield_stage *s, const glbk__sfield_view *v)
{
    const uint32_t first = (uint32_t)(s->at + s->count);
    uint32_t *texel = glbk__sfield_texel(s), i;
    float pair[2];
    texel[0] = (v->kind == 1 ? 1u : 0u) | (v->spacing == SFIELD_SPACING_UNIFORM ? 2u : 0u);
    texel[0] |= v->loop ? 4u : 0u;
    texel[1] = v->frames;
    texel[2] = v->shells;
    texel[3] = v->side;
    texel = glbk__sfield_texel(s);
    texel[0] = v->channels > 1 ? 2 : 1;
    texel[1] = first + 3 + v->shells;
    texel = glbk__sfield_texel(s);
    texel[0] = glbk_haar__get_u32(v->bytes + 92);
    for (i = 0; i < v->shells; i++) {
        pair[0] = glbk_haar__get_f32(v->bytes + 4 * (GLBK__SFIELD_HEADER + (size_t)i));
        pair[0] *= pair[0];
        pair[1] = glbk__sfield_measure(pair[0], v->kind == 1, v->spacing == SFIELD_SPACING_UNIFORM);
        memcpy(glbk__sfield_texel(s), pair, sizeof pair);
    }
}

/* Returns why a scene of wavelets cannot have a field, or NULL if it can. */
static const char *glbk__haar_refuse(const sfield_info *info, uint32_t side)
{
    if (info->basis != SFIELD_BASIS_HAAR) return "is one of harmonics, which glbk_sfield_scene_create takes";
    if (info->cube_side != side) return "has another cube_side than desc.cube_side";
    return info->shard_end ? "is a shard: sfield_merge first" : NULL;
}

static glbk_result glbk__haar_check(const glbk_context *ctx, const char *function,
                                    const glbk_sfield_haar_scene_desc *d, uint32_t side)
{
    glbk_result result;
    size_t i;
    if (side < 4 || side > 64 || (side & (side - 1)))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.cube_side", side,
                                  "a power of two within 4..64, or 0");
    result = glbk__sfield_check_lists(ctx, function, d->fields, d->field_count, d->entity_capacity, d->reach);
    if (result != GLBK_OK) return result;
    for (i = 0; i < d->field_count; i++) {
        sfield_info info;
        const char *why = "is NULL";
        if (d->fields[i]) {
            sfield_get_info(d->fields[i], &info);
            why = glbk__haar_refuse(&info, side);
        }
        if (why)
            return glbk__refuse_element(ctx, d->fields[i] ? GLBK_ERR_MISMATCH : GLBK_ERR_DESC, function,
                                        "desc.fields", i, "", why);
    }
    return GLBK_OK;
}

/* What making a scene of wavelets needs for a while. */
typedef struct glbk__haar_nursery {
    const glbk_sfield_haar_scene_desc *d;
    glbk__haar_tree *tree;
    uint8_t  *bytes;                    /* of the file of a field */
    size_t    most_bytes;
    uint64_t  texels;                   /* so far */
    int       lists;                    /* not 0: fields go up as lists, not as trees */
    glbk__sfield_stage roots, nodes;
} glbk__haar_nursery;

/* Reads field i, and says of the scene's entry where it begins. Returns the lists. */
static glbk__haar_lists glbk__haar_open(glbk__haar_nursery *n, size_t i, glbk__sfield_view *v)
{
    (void)sfield_write(n->d->fields[i], n->bytes, n->most_bytes);
    glbk__sfield_read(n->bytes, v);
    v->scales = 4 * (GLBK__SFIELD_HEADER + (size_t)v->shells);
    n->tree->channels = v->channels;
    return glbk__haar_lists_of(n->bytes, v);
}

/* Returns how many texels come before the nodes of a field's trees but the roots, or before the entries of
   its lists. */
static uint64_t glbk__haar_first(const glbk__haar_nursery *n, const glbk__sfield_view *v)
{
    const uint32_t step = v->channels > 1 ? 2 : 1;
    return 3 + v->shells + (n->lists ? 1 : 6 * step) * (uint64_t)v->samples;
}

/* Finds where all fields begin, and where they end. */
static void glbk__haar_lay_out(glbk__haar_nursery *n, glbk_sfield_field *fields)
{
    size_t i;
    for (i = 0; i < n->d->field_count && n->texels <= (uint64_t)1 << 28; i++) {
        glbk__sfield_view v;
        const glbk__haar_lists l = glbk__haar_open(n, i, &v);
        const uint64_t rest = n->lists ? glbk__haar_copy(n->tree, &l, NULL, NULL)
                                       : (v.channels > 1 ? 2 : 1) * glbk__haar_trees(n->tree, &l, NULL, NULL);
        sfield_info info;
        sfield_get_info(n->d->fields[i], &info);
        fields[i].field = n->d->fields[i];
        fields[i].start = (uint32_t)n->texels;
        fields[i].source = info.kind == SFIELD_KIND_SOURCE      ? 1
                           : info.kind == SFIELD_KIND_OCCLUSION ? 0
                                                                : GLBK__HAAR_IS_SELF;
        memcpy(fields[i].center, info.center, sizeof info.center);
        fields[i].radius = info.radius;
        fields[i].inscribed = info.inscribed;
        fields[i].outer = info.outer;
        n->texels += glbk__haar_first(n, &v) + rest;
    }
}

/* Uploads all fields. */
static glbk_result glbk__haar_fill(glbk__haar_nursery *n, const glbk_sfield_field *fields)
{
    size_t i;
    for (i = 0; i < n->d->field_count && n->roots.result == GLBK_OK; i++) {
        glbk__sfield_view v;
        const glbk__haar_lists l = glbk__haar_open(n, i, &v);
        n->roots.at = fields[i].start;
        n->nodes.at = fields[i].start + (size_t)glbk__haar_first(n, &v);
        glbk__haar_head(&n->roots, &v);
        if (n->lists) (void)glbk__haar_copy(n->tree, &l, &n->roots, &n->nodes);
        else (void)glbk__haar_trees(n->tree, &l, &n->roots, &n->nodes);
        glbk__sfield_flush(&n->roots);
        glbk__sfield_flush(&n->nodes);
        if (n->roots.result == GLBK_OK) n->roots.result = n->nodes.result;
    }
    return n->roots.result;
}

/* Returns a number for where a scene's fields begin and end in its table, never 0. Scenes of one number have
   the self-visibilities of each other: a field made anew at an old one's address has another size. */
static uint64_t glbk__haar_key(const glbk_sfield_scene *s)
{
    uint64_t key = s->texels;
    size_t i;
    for (i = 0; i < s->field_count; i++)
        key = (key ^ ((uint64_t)(uintptr_t)s->fields[i].field << 8 ^ s->fields[i].start)) * 1099511628211u;
    return key | 1;
}

/* Makes the tables of a scene of wavelets. */
static glbk_result glbk__haar_tables(glbk_context *ctx, const char *function, glbk__haar_nursery *n,
                                     glbk_sfield_scene *out)
{
    const uint64_t most = (uint64_t)1 << 28;
    glbk_result result;
    glbk__haar_lay_out(n, out->fields);
    if (n->texels > most)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "the number of texels of desc.fields",
                                  (double)n->texels, 0, (double)most);
    out->texels = (uint32_t)n->texels;
    out->entities_at = 6 * out->cube_side * out->cube_side;
    result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, out->texels + (size_t)1, &out->table);
    if (result == GLBK_OK)
        result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL,
                                    out->entities_at + (size_t)out->entity_capacity * GLBK__SFIELD_ENTITY,
                                    &out->moving);
    if (result == GLBK_OK)
        result = glbk_buffer_create(ctx, sizeof(glbk_sfield_contents), NULL, &out->contents);
    n->roots.ctx = n->nodes.ctx = ctx;
    n->roots.table = n->nodes.table = &out->table;
    if (result == GLBK_OK) result = glbk__haar_fill(n, out->fields);
    qsort(out->fields, out->field_count, sizeof *out->fields, glbk__sfield_by_pointer);
    out->key = glbk__haar_key(out);
    return result == GLBK_OK ? glbk__leave_created(ctx, glbk_sfield_haar_sky(ctx, out, NULL)) : result;
}

/* Makes a scene whose cube_side, entity_capacity and reach are set. */
static glbk_result glbk__haar_make(glbk_context *ctx, const char *function,
                                   const glbk_sfield_haar_scene_desc *d, glbk_sfield_scene *out)
{
    const glbk_haar__allocator memory = glbk_haar__memory(ctx);
    glbk_result result = GLBK_ERR_ALLOC;
    glbk__haar_nursery n;
    uint32_t *words;
    size_t i;
    memset(&n, 0, sizeof n);
    n.d = d;
    n.lists = out->lists;
    for (i = 0; i < d->field_count; i++) {
        sfield_info info;
        sfield_get_info(d->fields[i], &info);
        if (info.bytes > n.most_bytes) n.most_bytes = info.bytes;
    }
    out->fields =
        (glbk_sfield_field *)glbk_haar__alloc_array(&memory, d->field_count + 1, sizeof *out->fields);
    out->field_count = out->fields ? d->field_count : 0;
    n.tree = (glbk__haar_tree *)glbk_haar__alloc(&memory, sizeof *n.tree);
    n.bytes = (uint8_t *)glbk_haar__alloc(&memory, n.most_bytes + 1);
    words = (uint32_t *)glbk_haar__alloc(&memory, 32 * GLBK__SFIELD_STAGE);
    if (out->fields && n.tree && n.bytes && words) {
        memset(n.tree, 0, sizeof *n.tree);
        n.tree->side = out->cube_side;
        n.tree->squares = (out->cube_side * out->cube_side - 1) / 3;
        n.roots.words = words;
        n.nodes.words = words + 4 * GLBK__SFIELD_STAGE;
        n.roots.room = n.nodes.room = GLBK__SFIELD_STAGE;
        result = glbk__haar_tables(ctx, function, &n, out);
    }
    glbk_haar__free(&memory, words);
    glbk_haar__free(&memory, n.bytes);
    glbk_haar__free(&memory, n.tree);
    return result;
}

GLBK_DEF glbk_result glbk_sfield_haar_upload(glbk_context *ctx, const glbk_sfield_haar_scene_desc *d,
                                             glbk_sfield_scene *out)
{
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!out) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "out", "is NULL");
    memset(out, 0, sizeof *out);
    if (!d) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "desc", "is NULL");
    out->bands = 1;                             /* no rotations of coefficients are uploaded */
    out->cube_side = d->cube_side ? d->cube_side : 32;
    out->entity_capacity = d->entity_capacity;
    out->reach = d->reach;
    out->lists = ctx->compute && out->cube_side <= GLBK__HAAR_SHARED;
    result = glbk__haar_check(ctx, __func__, d, out->cube_side);
    if (result == GLBK_OK) result = glbk__haar_make(ctx, __func__, d, out);
    if (result != GLBK_OK) glbk_sfield_scene_free(ctx, out);
    return result;
}

GLBK_DEF glbk_result glbk_sfield_haar_sky(glbk_context *ctx, glbk_sfield_scene *s, const float *texels)
{
    glbk_haar__allocator memory;
    uint32_t cells, face, i, c;
    uint32_t x, y;
    glbk_result result;
    float *rgba;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__sfield_check_scene(ctx, __func__, s);
    if (result != GLBK_OK) return result;
    if (!s->cube_side) return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "scene", "has harmonics");
    memory = glbk_haar__memory(ctx);
    cells = 6 * s->cube_side * s->cube_side;
    rgba = (float *)glbk_haar__alloc_array(&memory, cells, 16);
    if (!rgba) return GLBK_ERR_ALLOC;
    for (i = 0; i < cells; i++) {               /* from Morton order to rows */
        float direction[3], *to;
        face = i / (s->cube_side * s->cube_side);
        glbk__haar_unfold(i % (s->cube_side * s->cube_side), &x, &y);
        to = rgba + 4 * (((size_t)face * s->cube_side + y) * s->cube_side + x);
        for (c = 0; c < 3; c++) to[c] = texels ? texels[c * (size_t)cells + i] : 0;
        to[3] = sfield_cube_texel(s->cube_side, i, direction);
    }
    result = glbk__table_update(ctx, &s->moving, 0, cells, rgba);
    glbk_haar__free(&memory, rgba);
    if (result != GLBK_OK) return result;
    s->sky = texels != NULL;
    return glbk__sfield_tell(ctx, s);
}

/* ==== src/gl_wavelets/renderer.h ==== */

/* ---- wavelets: the renderer, and self-visibility of its pixels ---- */

enum {
    GLBK__HAAR_SLOTS = 16,            /* places of a list */
    GLBK__HAAR_WIDE = 2048            /* texels a side of a texture, at most */
};

/* Makes a texture of so many texels. */
static glbk_result glbk__haar_texture(glbk_context *ctx, glbk_format format, uint32_t width,
                                      uint32_t height, uint32_t layers, glbk_texture *out)
{
    glbk_texture_desc d;
    memset(&d, 0, sizeof d);
    d.format = format;
    d.width = width;
    d.height = height;
    d.layers = layers;
    return glbk_texture_create(ctx, &d, out);
}

/* Chooses how many points a batch has, and how many cubes stand in a row: textures have at most so many
   texels a side. */
static void glbk__haar_fit(const glbk_context *ctx, uint32_t wanted, glbk_sfield_haar *h)
{
    const uint32_t side = ctx->max_side < GLBK__HAAR_WIDE ? ctx->max_side : (uint32_t)GLBK__HAAR_WIDE;
    const uint32_t half = h->cube_side / 2, pixels = h->width * h->height;
    uint32_t most;
    h->columns = side / (6 * half);
    most = side / half * h->columns / GLBK__HAAR_SLOTS;
    most = most < side && !h->compute ? most : side;
    if (!wanted) wanted = h->compute && !h->has_gloss ? most : 256;
    h->batch = wanted < most ? wanted : most;
    if (pixels < h->batch) h->batch = pixels;
}

/* Makes the picture of light and, if it is wanted, of gloss. */
static glbk_result glbk__haar_picture(glbk_context *ctx, glbk_sfield_haar *h)
{
    glbk_target_desc target;
    glbk_result result = glbk__haar_texture(ctx, GLBK_FORMAT_COLOR, h->width, h->height, 0, &h->light);
    memset(&target, 0, sizeof target);
    target.color[0] = &h->light;
    if (h->has_gloss && result == GLBK_OK) {
        result = glbk__haar_texture(ctx, GLBK_FORMAT_COLOR, h->width, h->height, 0, &h->gloss);
        target.color[1] = &h->gloss;
    }
    return result == GLBK_OK ? glbk__target_create(ctx, &target, &h->target) : result;
}

/* Makes the textures and targets of a batch. */
static glbk_result glbk__haar_textures(glbk_context *ctx, glbk_sfield_haar *h)
{
    const glbk_format format = GLBK_FORMAT_RGBA32UI;
    const uint32_t half = h->cube_side / 2, wide = h->columns * 6 * half;
    const uint32_t rows = (h->batch * GLBK__HAAR_SLOTS + h->columns - 1) / h->columns,
                   strips = (h->batch + 2 * h->columns - 1) / (2 * h->columns);
    const int sums = h->has_gloss ? 4 : 3;
    glbk_target_desc target;
    glbk_result result = glbk__haar_picture(ctx, h);
    int i, k;
    for (i = 0; i < 3 && result == GLBK_OK; i++)
        result = glbk__haar_texture(ctx, format, GLBK__HAAR_SLOTS, h->batch, 0, &h->list[i]);
    if (result == GLBK_OK)
        result = glbk__canvas(ctx, format, wide, rows * half, NULL, &h->cubes, &h->cubes_target);
    for (i = 0; i < 2 && result == GLBK_OK; i++) {
        memset(&target, 0, sizeof target);
        result = glbk__haar_texture(ctx, format, GLBK__HAAR_SLOTS, h->batch, 0, &h->met[i]);
        for (k = 0; k < 3; k++) target.color[k] = &h->list[k];
        target.color[3] = &h->met[i];
        if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &h->list_target[i]);
        memset(&target, 0, sizeof target);
        for (k = 0; k < sums && result == GLBK_OK; k++) {
            result = glbk__haar_texture(ctx, format, wide, strips * half, 0, &h->left[i][k]);
            target.color[k] = &h->left[i][k];
        }
        if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &h->left_target[i]);
    }
    return result;
}

/* Compiles a program of this header, which uses files of gl_shadowfield.h and gl_gbuffer.h. */
static glbk_result glbk__haar_program(glbk_context *ctx, const char *name, const char *defines,
                                      glbk_program *out)
{
    return glbk__gbuffer_program_above(ctx, &glbk__haar_part, glbk__sfield_reader(), name, defines, out);
}

/* Makes what the compute shader needs: the picture and a buffer for T, where shared memory has no room for
   it, and for the kernels of BRDFs. */
static glbk_result glbk__haar_compute(glbk_context *ctx, glbk_sfield_haar *h)
{
    char defines[] = "SFIELD_BANDS=1 SFIELD_GLOSS=0 SFIELD_SIDE=..";
    const size_t planes = (h->cube_side > 16 ? 1u : 0u) + (h->has_gloss ? 3u : 0u);
    const size_t bytes = planes * 24 * h->cube_side * h->cube_side * h->batch;
    glbk_result result = glbk__haar_picture(ctx, h);
    defines[28] = h->has_gloss ? '1' : '0';
    defines[42] = (char)('0' + (h->cube_side < 10 ? h->cube_side : h->cube_side / 10));
    defines[43] = (char)(h->cube_side < 10 ? 0 : '0' + h->cube_side % 10);
    if (result == GLBK_OK && planes) result = glbk_buffer_create(ctx, bytes, NULL, &h->kept);
    return result == GLBK_OK ? glbk__haar_program(ctx, "sfield_haar_shade.comp", defines, &h->shade) : result;
}

/* Makes what fragment shaders need. */
static glbk_result glbk__haar_fragments(glbk_context *ctx, glbk_sfield_haar *h)
{
    const char *gloss = h->has_gloss ? "SFIELD_GLOSS=1" : "SFIELD_GLOSS=0";
    glbk_result result = glbk__haar_textures(ctx, h);
    if (result == GLBK_OK)
        result = glbk__haar_program(ctx, "sfield_haar_list.frag", "SFIELD_BANDS=1", &h->find);
    if (result == GLBK_OK) result = glbk__haar_program(ctx, "sfield_haar_cubes.frag", gloss, &h->write);
    if (result == GLBK_OK) result = glbk__haar_program(ctx, "sfield_haar_light.frag", gloss, &h->multiply);
    if (result == GLBK_OK) result = glbk__haar_program(ctx, "sfield_haar_sum.frag", gloss, &h->sum);
    return result;
}

static glbk_result glbk__haar_check_desc(const glbk_context *ctx, const char *function,
                                         const glbk_sfield_haar_desc *d)
{
    const uint32_t side = d ? d->cube_side : 0;
    glbk_result result;
    if (!d) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "desc", "is NULL");
    result = glbk__require_side(ctx, function, "desc.width", d->width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, function, "desc.height", d->height);
    if (result != GLBK_OK) return result;
    if (side && (side < 4 || side > 64 || (side & (side - 1))))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.cube_side", side,
                                  "a power of two within 4..64, or 0");
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_sfield_haar_create(glbk_context *ctx, const glbk_sfield_haar_desc *d,
                                             glbk_sfield_haar *out)
{
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!out) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "out", "is NULL");
    memset(out, 0, sizeof *out);
    result = glbk__haar_check_desc(ctx, __func__, d);
    if (result != GLBK_OK) return result;
    out->width = d->width;
    out->height = d->height;
    out->cube_side = d->cube_side ? d->cube_side : 32;
    out->has_self = d->self != 0;
    out->has_gloss = d->gloss != 0;
    out->compute = ctx->compute && out->cube_side <= GLBK__HAAR_SHARED;
    glbk__haar_fit(ctx, d->batch, out);
    result = out->compute ? glbk__haar_compute(ctx, out) : glbk__haar_fragments(ctx, out);
    if (result == GLBK_OK && d->self)
        result = glbk__haar_texture(ctx, GLBK_FORMAT_R32UI, out->width, out->height, 1, &out->self);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_haar_batch), NULL, &out->block);
    if (result != GLBK_OK) glbk_sfield_haar_free(ctx, out);
    return result;
}

GLBK_DEF void glbk_sfield_haar_free(glbk_context *ctx, glbk_sfield_haar *h)
{
    int i, k;
    if (!h) return;
    glbk_program_free(ctx, &h->find);
    glbk_program_free(ctx, &h->write);
    glbk_program_free(ctx, &h->multiply);
    glbk_program_free(ctx, &h->sum);
    glbk_program_free(ctx, &h->shade);
    glbk_buffer_free(ctx, &h->kept);
    glbk_target_free(ctx, &h->target);
    glbk_target_free(ctx, &h->cubes_target);
    glbk_texture_free(ctx, &h->light);
    glbk_texture_free(ctx, &h->gloss);
    glbk_texture_free(ctx, &h->self);
    glbk_texture_free(ctx, &h->cubes);
    for (i = 0; i < 3; i++) glbk_texture_free(ctx, &h->list[i]);
    for (i = 0; i < 2; i++) {
        glbk_target_free(ctx, &h->list_target[i]);
        glbk_target_free(ctx, &h->left_target[i]);
        glbk_texture_free(ctx, &h->met[i]);
        for (k = 0; k < 4; k++) glbk_texture_free(ctx, &h->left[i][k]);
    }
    glbk_buffer_free(ctx, &h->block);
    memset(h, 0, sizeof *h);
}

/* Checks a renderer and a scene of wavelets, which belong together. */
static glbk_result glbk__haar_check_pair(const glbk_context *ctx, const char *function,
                                         const glbk_sfield_haar *h, const glbk_sfield_scene *s)
{
    glbk_result result;
    if (!h || !h->block.name)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "haar", h ? "was not created" : "is NULL");
    result = glbk__sfield_check_scene(ctx, function, s);
    if (result != GLBK_OK) return result;
    if (s->cube_side == h->cube_side && !s->lists == !h->compute) return GLBK_OK;
    if (!s->cube_side) return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, "scene", "has harmonics");
    if (s->cube_side == h->cube_side)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, "scene",
                            "was uploaded with another ctx->compute than the renderer was made with");
    return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "scene->cube_side", s->cube_side,
                              "that of the renderer");
}

/* Writes where the trees of a point's self-visibility begin, 0 for none. */
static glbk_result glbk__haar_root(const glbk_context *ctx, const char *function,
                                   const glbk_sfield_scene *s, const glbk_sfield_own *own,
                                   size_t index, uint32_t *root)
{
    const glbk_sfield_field *field = glbk__sfield_find(s, own->self);
    char name[GLBK__ELEMENT_ROOM];
    sfield_info info;
    *root = 0;
    if (!own->self) return GLBK_OK;
    if (!field || field->source != GLBK__HAAR_IS_SELF)
        return glbk__refuse_element(ctx, GLBK_ERR_MISMATCH, function, "own", index, ".self",
                                    "is none of the scene's self-visibilities");
    sfield_get_info(own->self, &info);
    if (own->point >= info.sample_count) {
        glbk__name_element(name, "own", index, ".point");
        return glbk__refuse_range(ctx, GLBK_ERR_INPUT, function, name, own->point, 0,
                                  (double)info.sample_count - 1);
    }
    *root = field->start + 3 + (s->lists ? 1 : 6) * own->point;
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_sfield_haar_self(glbk_context *ctx, glbk_sfield_haar *h, const glbk_sfield_scene *s,
                                           uint32_t row, uint32_t row_count, const glbk_sfield_own *own)
{
    glbk_box box = { 0, 0, 0, 0, 0, 0, 1 };
    glbk_haar__allocator memory;
    glbk_result result;
    uint32_t *roots;
    size_t i, count;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__haar_check_pair(ctx, __func__, h, s);
    if (result != GLBK_OK) return result;
    if (!h->has_self)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "haar", "was created without desc.self");
    if (!own) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "own", "is NULL");
    result = glbk__sfield_check_rows(ctx, __func__, h->height, row, row_count);
    if (result != GLBK_OK) return result;
    memory = glbk_haar__memory(ctx);
    count = (size_t)h->width * row_count;
    roots = (uint32_t *)glbk_haar__alloc_array(&memory, count, 4);
    if (!roots) return GLBK_ERR_ALLOC;
    for (i = 0; i < count && result == GLBK_OK; i++)
        result = glbk__haar_root(ctx, __func__, s, &own[i], i, &roots[i]);
    box.y = row;
    box.width = h->width;
    box.height = row_count;
    if (result == GLBK_OK && h->self_of != s->key) result = glbk__sfield_blank(ctx, &h->self);
    if (result == GLBK_OK) h->self_of = s->key;
    if (result == GLBK_OK) result = glbk_texture_update(ctx, &h->self, &box, roots);
    glbk_haar__free(&memory, roots);
    return result;
}

/* ==== src/gl_wavelets/shading.h ==== */

/* ---- wavelets: the passes of a batch of points ---- */

/* Begins a pass of a batch: draws cover `width` x `height` texels of a target, from (left, bottom) on. */
static glbk_result glbk__haar_pass(glbk_context *ctx, const glbk_sfield_haar *h, glbk_program *program,
                                   const glbk_target *target, const uint32_t viewport[4])
{
    glbk_pass pass;
    glbk_result result;
    int i;
    memset(&pass, 0, sizeof pass);
    pass.target = target;
    for (i = 0; i < 4; i++) pass.viewport[i] = (int32_t)viewport[i];
    result = glbk_begin(ctx, &pass, program);
    if (result == GLBK_OK) glbk_bind_block(ctx, GLBK_SLOT_glbk_haar_batch, &h->block);
    return result;
}

/* Binds what passes read of a list. */
static void glbk__haar_bind(glbk_context *ctx, const glbk_sfield_haar *h, const glbk_sfield_scene *s)
{
    glbk_sfield_bind(ctx, s, NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_what, &h->list[0]);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_corner, &h->list[1]);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_weight, &h->list[2]);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_cubes, &h->cubes);
}

/* Draws a round of a batch: lists, their cubes, and what T and light come to. */
static glbk_result glbk__haar_round(glbk_context *ctx, glbk_sfield_haar *h, const glbk_gbuffer *g,
                                    const glbk_sfield_scene *s, const glbk_haar_batch *b)
{
    const uint32_t now = b->round & 1, half = h->cube_side / 2, cubes = b->count * b->slots;
    const uint32_t lists[4] = { 0, 0, b->slots, b->count },
                   squares[4] = { 0, 0, h->columns * 6 * half, (cubes + h->columns - 1) / h->columns * half },
                   strips[4] = { 0, 0, h->columns * 6 * half,
                                 (b->count + 2 * h->columns - 1) / (2 * h->columns) * half };
    glbk_result result = glbk__put_block(ctx, GLBK_SLOT_glbk_haar_batch, &h->block, b);
    if (result == GLBK_OK) result = glbk__haar_pass(ctx, h, &h->find, &h->list_target[now], lists);
    if (result != GLBK_OK) return result;
    glbk_sfield_bind(ctx, s, NULL);
    result = glbk_gbuffer_bind(ctx, g, NULL);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_sfield_self, &h->self);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_met, b->round ? &h->met[!now] : NULL);
    glbk_draw_screen(ctx);
    result = glbk__haar_pass(ctx, h, &h->write, &h->cubes_target, squares);
    if (result != GLBK_OK) return result;
    glbk__haar_bind(ctx, h, s);
    result = glbk_gbuffer_bind(ctx, g, NULL);
    if (result != GLBK_OK) return result;
    glbk_draw_screen(ctx);
    result = glbk__haar_pass(ctx, h, &h->multiply, &h->left_target[now], strips);
    if (result != GLBK_OK) return result;
    glbk__haar_bind(ctx, h, s);
    result = glbk_gbuffer_bind(ctx, g, NULL);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_lower, b->round ? &h->left[!now][0] : NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_upper, b->round ? &h->left[!now][1] : NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_sums, b->round ? &h->left[!now][2] : NULL);
    if (h->has_gloss)
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_shine, b->round ? &h->left[!now][3] : NULL);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

/* Shades the points of a batch by compute. */
static glbk_result glbk__haar_dispatch(glbk_context *ctx, glbk_sfield_haar *h, const glbk_gbuffer *g,
                                       const glbk_sfield_scene *s, const glbk_haar_batch *b)
{
    glbk_result result = glbk__put_block(ctx, GLBK_SLOT_glbk_haar_batch, &h->block, b);
    if (result != GLBK_OK) return result;
    glbk_sfield_bind(ctx, s, NULL);
    result = glbk_gbuffer_bind(ctx, g, NULL);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_sfield_self, &h->self);
    glbk_bind_storage(ctx, GLBK_SLOT_glbk_haar_left, &h->kept);
    glbk_bind_image(ctx, GLBK_SLOT_glbk_sfield_light_image, &h->light);
    if (h->has_gloss) glbk_bind_image(ctx, GLBK_SLOT_glbk_sfield_gloss_image, &h->gloss);
    return glbk_dispatch(ctx, &h->shade, b->width, b->count / b->width, 1);
}

/* Shades the points of a batch, whose rectangle is set, in so many rounds. sky: not 0 if the sky or the open
   share is wanted. */
static glbk_result glbk__haar_batch(glbk_context *ctx, glbk_sfield_haar *h, const glbk_gbuffer *g,
                                    const glbk_sfield_scene *s, uint32_t rounds, int sky,
                                    glbk_haar_batch *b)
{
    const uint32_t pixels[4] = { b->left, b->bottom, b->width, b->count / b->width };
    glbk_result result = GLBK_OK;
    b->last = sky != 0;
    if (h->compute) return glbk__haar_dispatch(ctx, h, g, s, b);
    for (b->round = 0; b->round < rounds && result == GLBK_OK; b->round++) {
        b->last = sky && b->round + 1 == rounds;
        result = glbk__haar_round(ctx, h, g, s, b);
    }
    if (result == GLBK_OK) result = glbk__haar_pass(ctx, h, &h->sum, &h->target, pixels);
    if (result != GLBK_OK) return result;
    glbk_sfield_bind(ctx, s, NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_sums, &h->left[!(rounds & 1)][2]);
    if (h->has_gloss) {
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_haar_shine, &h->left[!(rounds & 1)][3]);
        result = glbk_gbuffer_bind(ctx, g, NULL);
        if (result != GLBK_OK) return result;
    }
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_sfield_haar_shade(glbk_context *ctx, glbk_sfield_haar *h, const glbk_gbuffer *g,
                                            const glbk_sfield_scene *s, const float eye[3], int open)
{
    glbk_sfield_contents contents;
    glbk_haar_batch b;
    glbk_result result;
    uint32_t most, wide, high;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__haar_check_pair(ctx, __func__, h, s);
    if (result == GLBK_OK) result = glbk__sfield_check_gbuffer(ctx, __func__, h->width, h->height, g);
    if (result != GLBK_OK) return result;
    if (h->self_of && h->self_of != s->key)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "scene",
                            "is not the one of glbk_sfield_haar_self");
    if (!eye && g->has_clip) eye = g->eye;
    if (h->has_gloss && !eye)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "eye",
                            "is NULL: lobes need it, and the G-buffer has none");
    most = s->entity_count + 3 * s->light_count + (h->self_of ? 1u : 0u);
    memset(&b, 0, sizeof b);
    if (eye) memcpy(b.eye, eye, 12);
    b.slots = most < GLBK__HAAR_SLOTS ? (most ? most : 1) : (uint32_t)GLBK__HAAR_SLOTS;
    b.own = h->self_of != 0;
    b.side = h->cube_side;
    b.columns = h->columns;
    contents = glbk__sfield_contents_of(s, s->sky || open);
    result = glbk__put_block(ctx, GLBK_SLOT_glbk_sfield_contents, &s->contents, &contents);
    wide = h->width < h->batch ? h->width : h->batch;
    if (wide > 32 && !h->compute) wide = 32;    /* points that are near each other read the same samples */
    high = h->batch / wide;
    for (b.bottom = 0; b.bottom < h->height && result == GLBK_OK; b.bottom += high)
        for (b.left = 0; b.left < h->width && result == GLBK_OK; b.left += wide) {
            const uint32_t rows = h->height - b.bottom < high ? h->height - b.bottom : high;
            b.width = h->width - b.left < wide ? h->width - b.left : wide;
            b.count = b.width * rows;
            result = glbk__haar_batch(ctx, h, g, s, most ? (most + b.slots - 1) / b.slots : 1,
                                      s->sky || open, &b);
        }
    return result;
}

/* ==== src/gl_wavelets/end.h ==== */

#endif /* GL_WAVELETS_IMPLEMENTATION */

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
