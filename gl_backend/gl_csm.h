/* gl_csm.h - v0.9.0 - coherent shadow maps on OpenGL 3.3, ES 3.0, WebGL 2 - MIT-0 OR Unlicense

   What it does

   It brings the blocks that csm.h built onto the GPU. In shaders of your own csm_visible() says whether a
   point is lit; many questions are answered at once; a complete Monte Carlo renderer adds up direct light;
   and blocks are built from layers that the GPU draws.

   What it does not do

   - It needs gl_gbuffer.h beside it, which holds what the renderer shades; gl_programs.h, which makes
     programs; and gl_backend.h, which makes the context object, textures and targets, and whose conventions,
     errors and rules about GL's state hold here.
   - It has no blocks, lights or materials of its own: csm.h builds the blocks, or reads them from files, and
     lights and materials are those of lightsampling.h. Both headers are included; their implementations are
     not needed.

   Quick start

       #define GL_BACKEND_IMPLEMENTATION
       #define GL_PROGRAMS_IMPLEMENTATION
       #define GL_GBUFFER_IMPLEMENTATION
       #define GL_CSM_IMPLEMENTATION
       #include "gl_backend/gl_csm.h"
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
               "    cohsm_query query = cohsm_ask(COHSM_LIGHT_POSITION, COHSM_FILTER_NEAREST, 1.0);\n"
               "    color = vec4(csm_visible(0u, query, place, vec3(0.0, 3.0, 0.0)));\n"
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
           source.parts[0] = glbk_csm_part();               // the GLSL of this header
           source.uses = "csm_visible";
           source.defines = NULL;
           source.fragment = fragment;
           result = glbk_program_compile(&gl, &source, &program);
           printf("%s\n", glbk_result_text(result));
           glbk_program_free(&gl, &program);
           glbk_free(&gl);
           return result != GLBK_OK;
       }

   The whole frame, with a window: examples/06_csm_gl_minimal.c.

   Vectors

   A vector that is said to be unit may have a length of 0.97 to 1.03 and is used as it is, and any other
   length is an error; in shaders of your own nothing is checked.

   From the paper to the code

   The paper is that of csm.h and lightsampling.h: Ritschel, Grosch, Kautz and Mueller, "Interactive
   Illumination with Coherent Shadow Maps", EGSR 2007. A line has the function in GLSL or the call, its twin
   in csm.h or lightsampling.h, and the rows of docs/conformance.md that test both.

     section 3.1  layers, view by view            glbk_csm_builder_draw      cohsm_builder_add       -
     eq. (1)      segments: one depth for many    glbk_csm_builder_compress  cohsm__compress_view    -
     section 3.2  project, find segment, compare  cohsm_see, cohsm_pixel     cohsm__project_point    T61 T66
     section 3.2  the search for a segment        cohsm_list_depth           cohsm__block_find       T61
     section 3.3  six faces of a cube             cohsm_face_coordinates     cohsm__face_of          T70
     section 4    D, where the maps look from     cohsm_map_parameter        cohsm__map_parameter    T73
     section 4.1  from a direction to its map     cohsm_domain_position      cohsm__domain_position  T43 T73
     section 4.3  lights outside the convex hull  cohsm_hull                 cohsm__light_refused    T67 T68
     section 4.5  filtering                       cohsm_pcf                  cohsm__pcf              T69
     section 4.5  Russian roulette                cohsm_jitter               cohsm__jitter           -
     section 4.6  several objects, D times T^-1   cohsm_visible_scene        cohsm_visible_scene     T62 T66
     section 5    A and L, shape and radiance     cohsm_light_draw           lsamp_light_sample      -
     section 5.1  the mean of f L V cos / p       cohsm_estimate             lsamp__estimate         -
     section 5.1  P_L, the inverse of a CDF       cohsm_pick_coords          lsamp__invert_sums      -
     section 5.1  P_f, lobes by Russian roulette  cohsm_brdf_draw            lsamp__brdf_draw        -
     section 5.1  256 patterns, one for a pixel   cohsm_numbers              lsamp__random_numbers   -
     section 5.2  the mean of frames              glbk_csm_resolve           lsamp_progressive_add   -

   Lines without a row are compared with their twins: by tests/csm/gl_build_test.c, gl_shade_test.c and
   gl_twin_test.c.

   Configuration

     GL_CSM_IMPLEMENTATION   in one source file: compiles the code; another file may have those of
                             gl_backend.h, gl_programs.h and gl_gbuffer.h

   Layouts: docs/gpu-layouts.md. The technique: docs/csm.md. State: docs/gl-state.md. Licence: end of file. */
/* These stand outside the guard, because a second inclusion of this file may ask for their implementations.
   csm.h and lightsampling.h lie above this folder. */
#include "gl_programs.h"
#include "gl_gbuffer.h"
#include "../csm.h"
#include "../lightsampling.h"

#ifndef GL_CSM_H
#define GL_CSM_H

#if GLBK_VERSION != 900
#error "gl_csm.h and gl_backend.h are of different versions"
#endif
#if defined(GLBK_STATIC) && !defined(GL_CSM_IMPLEMENTATION)
#error "GLBK_STATIC makes all functions private: GL_CSM_IMPLEMENTATION belongs into the same file"
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ==== src/gl_csm/api_page_one.h ==== */

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

/* ==== src/gl_csm/api.h ==== */

/* ---- maps, lights, frames ---- */

GLBK_DEF void glbk_csm_maps_free(glbk_context *ctx, glbk_csm_maps *maps);
/* Deletes the maps' objects of GL and zeroes the struct. NULL is allowed. */

GLBK_DEF glbk_result glbk_csm_lights_update(glbk_context *ctx, glbk_csm_lights *lights, uint32_t start,
                                            const lsamp_light_desc *desc);
/* Replaces a light that has moved or changed, or whose desc->time went on. Its texture must have the size
   that it had, and its mesh as many triangles.
   start    what glbk_csm_lights_create wrote for it
   Errors   those of glbk_csm_lights_create. GLBK_ERR_ARGUMENT, too: start is that of no light with as many
            texels */

GLBK_DEF void glbk_csm_lights_free(glbk_context *ctx, glbk_csm_lights *lights);
/* Deletes the table and zeroes the struct. NULL is allowed. */

GLBK_DEF glbk_result glbk_csm_prepare(glbk_context *ctx, glbk_csm_renderer *renderer,
                                      const glbk_csm_frame_desc *desc);
/* Compiles the programs that such a frame needs, so that the first one does not stutter.
   Errors   those of glbk_csm_render that are not about the G-buffer */

GLBK_DEF void glbk_csm_reset(glbk_csm_renderer *renderer);
/* Forgets all frames: the next one begins the sum. Call it if the camera, a light or an object has moved.
   NULL is allowed. */

GLBK_DEF glbk_result glbk_csm_read(glbk_context *ctx, glbk_csm_renderer *renderer, float *rgba);
/* Waits for the GPU and reads the mean of the frames.
   rgba     receives 4 floats a pixel, rows from the bottom up: linear radiance, and how many samples of a
            frame were refused, because their light lies inside a hull
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the renderer was not created. GLBK_ERR_ORDER: there is no
            frame yet. Those of glbk_target_read */

GLBK_DEF glbk_result glbk_csm_renderer_resize(glbk_context *ctx, glbk_csm_renderer *renderer, uint32_t width,
                                              uint32_t height);
/* Gives the renderer another size, without frames. Its programs stay, whereas a new renderer would compile
   them anew, seconds on some drivers; so call it when a window has changed its size, with
   glbk_gbuffer_resize. Its textures are new ones.
   Errors   GLBK_ERR_ARGUMENT: the renderer is NULL or was not created. GLBK_ERR_DESC, GLBK_ERR_LIMIT: as for
            glbk_csm_renderer_create. After these it is as it was, after those of textures and targets it is
            freed and zeroed */

GLBK_DEF void glbk_csm_renderer_free(glbk_context *ctx, glbk_csm_renderer *renderer);
/* Deletes the renderer's objects of GL and zeroes the struct. NULL is allowed. */

/* ---- shaders of your own ----

   After glbk_csm_bind, shaders of your own ask the maps of a scene by lib/csm_visible.glsl:

       cohsm_query cohsm_ask(int light, int filtering, float bias);
       float csm_visible(uint entity, cohsm_query query, vec3 point, vec3 light);

   cohsm_ask takes a COHSM_LIGHT_..., a COHSM_FILTER_... and a bias in pixels of a map. csm_visible returns 1
   lit, 0 dark, something between with PCF, or -1 if the light lies inside an object's hull.

       entity   the instance that the point lies on, counted from 1; 0 = none
       point    world space
       light    COHSM_LIGHT_DIRECTION: the unit direction to it; _POSITION: a place in world space;
                _PARAMETER: its coordinates 0..1; _INDEX: the cell, as uintBitsToFloat(cell) in x

   With COHSM_FILTER_ROULETTE also set query.seed, and query.id to another number for each sample.
   docs/gpu-layouts.md has all layouts, for those who bring their own API. */

GLBK_DEF const glbk_part *glbk_csm_part(void);
/* Returns the GLSL of this header, for glbk_source.parts of a program of yours that uses its library
   files. */

GLBK_DEF void glbk_csm_bind(glbk_context *ctx, const glbk_csm_maps *maps, const glbk_offset *offset);
/* Binds textures and uniform block of the maps for a program of yours that uses lib/csm_visible.glsl and is
   bound (glbk_begin). A program that was compiled with maps->defines among its own is much faster, since it
   holds the code of one domain, one order and one orientation. Such a program gives right answers
   for maps with the same defines only.
   offset   what glbk_source.offsets gives this part in the program; NULL = none */

GLBK_DEF size_t glbk_csm_light_texels(const lsamp_light_desc *desc);
/* Returns how many texels, of 16 bytes each, a light takes in a table, or 0 if it is refused or desc is NULL.
   This call and the next need no context. They serve renderers on another API, whose shaders have
   lib/cohsm_light.glsl or a translation of it: examples/06b_csm_own_api.c; there LSAMP_LIGHT_CALLBACK and
   emission_fn are what your shader does with COHSM_OWN_LIGHT. This one has no log: the next says
   why a light is refused. */

GLBK_DEF glbk_result glbk_csm_light_write(const lsamp_light_desc *desc, uint32_t *words);
/* Writes a light as it stands in a table, at desc->time; docs/gpu-layouts.md has the layout.
   words    receives 4 words for each of glbk_csm_light_texels(desc) texels
   Errors   those of glbk_csm_lights_create, but for memory. desc->system.log is told which field is wrong;
            there is no log if desc is NULL */

/* ---- many questions at once ----

   An asker answers queries of points and lights in bulk, as cohsm_visible_scene does. If ctx->compute is set,
   it uses storage buffers, unless they may not be as large as 32 bytes a question; else a pass draws the
   answers into a texture. */

typedef struct glbk_csm_asker {     /* read only; zeroed = none */
    glbk_csm_programs programs;
    uint32_t     capacity;          /* the most questions */
    uint32_t     question;          /* private: 1 + 3 light_kind + filter of those uploaded; 0 = none */
    glbk_texture questions;         /* core path: questions and answers, the answers as the bits of floats,
                                       question i at (i & 1023, i >> 10) */
    glbk_texture answers;
    glbk_target  target;            /* private */
    glbk_buffer  frame;             /* private */
    glbk_buffer  asked;             /* compute path: questions and answers, a float each */
    glbk_buffer  answered;
} glbk_csm_asker;

GLBK_DEF glbk_result glbk_csm_asker_create(glbk_context *ctx, uint32_t capacity, glbk_csm_asker *out);
/* Makes room on the GPU for questions and their answers, which glbk_csm_asker_free takes back.
   capacity   the most questions at once, 1..2^22; 2^20 is what GL guarantees on the core path, whose answers
              are rows of 1024 texels, of which there are ctx->max_side at most
   Memory     36 bytes a question
   Errors     GLBK_ERR_ARGUMENT: a pointer is NULL, or capacity is out of range. Those of textures and
              buffers */

GLBK_DEF glbk_result glbk_csm_ask_upload(glbk_context *ctx, glbk_csm_asker *asker, const cohsm_query *query);
/* Uploads the points and lights of a query, 1 .. capacity of them. With COHSM_LIGHT_PARAMETER light_stride
   must be 12 or more, and three floats are read for each light, since the dimensions of the maps are not
   known yet.
   Memory   32 bytes a question while it runs
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, the asker was not created, or a count or stride is out of
            range. GLBK_ERR_DESC: light_kind, filter or bias is out of range. GLBK_ERR_LIMIT: query->count is
            above the capacity. GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_csm_ask_run(glbk_context *ctx, glbk_csm_asker *asker, const glbk_csm_maps *maps,
                                      uint32_t count);
/* Answers the first questions of those uploaded, on the GPU. The call may be repeated, with other maps, too.
   The first use of a combination of maps->defines, light_kind and filter compiles a program. Maps that cannot
   answer this kind of light give numbers without a meaning: ask cohsm_visible with the same query once, which
   returns COHSM_ERR_MISMATCH then.
   count    1 .. asker->capacity
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, an object was not created, or count is 0. GLBK_ERR_LIMIT:
            count is above the capacity. GLBK_ERR_ORDER: nothing was uploaded yet. Those of
            glbk_program_compile */

GLBK_DEF glbk_result glbk_csm_ask_read(glbk_context *ctx, glbk_csm_asker *asker, uint32_t count,
                                       float *visible);
/* Waits for the GPU and copies the first answers: 1 lit, 0 dark, something between with PCF, -1 if the light
   lies inside an object's hull.
   visible   receives count floats, count being 1 .. asker->capacity
   Errors    GLBK_ERR_ARGUMENT: a pointer is NULL, the asker was not created, or count is 0. GLBK_ERR_LIMIT:
             count is above the capacity. Those of glbk_buffer_read and glbk_target_read */

GLBK_DEF void glbk_csm_asker_free(glbk_context *ctx, glbk_csm_asker *asker);
/* Deletes the asker's objects of GL and zeroes the struct. NULL is allowed. */

/* ==== src/gl_csm/api_building.h ==== */

/* ---- building on the GPU ----

   A builder of this header draws the layers of views by depth peeling and finds their segments (equation 1).
   csm.h then writes the block from the segments alone; its bytes are those which its builder would have made
   of the layers that were drawn, with COHSM_LAYERS_Z1Z3_SPHERE but for roundings of where rays leave the
   sphere. Views come in batches:

       for (from = 0; from < view_count; from += n) {              // n <= b.batch
           glbk_csm_builder_draw(gl, &b, from, n);
           glbk_csm_builder_compress(gl, &b);
       }
       glbk_csm_builder_end(gl, &b);
       cohsm_builder_import(builder, b.segments, b.segment_count);
       cohsm_builder_finish(builder, &maps, NULL); */

typedef void (*glbk_csm_view_fn)(void *user, uint32_t index, cohsm_view *out);
/* Writes the camera of a view, as cohsm_builder_view does. The builder reads matrix and depth_scale, and of
   views of positions with COHSM_LAYERS_Z1Z3_SPHERE also location and face. */

typedef void (*glbk_csm_draw_fn)(void *user, glbk_context *ctx);
/* Draws your object: it binds a vertex array with the position in object space, and draws. It changes neither
   program nor state. */

typedef struct glbk_csm_builder_desc {
    const cohsm_desc *maps;             /* the desc that cohsm_builder_create gets; NULL = all defaults. Here
                                           map_side, layers, depth_bits, open_thickness and self_only count,
                                           with COHSM_LAYERS_Z1Z3_SPHERE center and radius, which must be
                                           above 0, and whether domain is of positions. Views are drawn whole,
                                           also for a shard */
    glbk_csm_view_fn  view_fn;          /* required, like draw_fn */
    glbk_csm_draw_fn  draw_fn;
    void             *user;             /* given to both */
    glbk_attributes   attributes;       /* of your object: position counts, all zero = 0 */
} glbk_csm_builder_desc;                /* maps is read until glbk_csm_builder_create returns */

typedef struct glbk_csm_builder {       /* read only; zeroed = none */
    uint32_t              batch;        /* the most views that are drawn at once, a power of two */
    uint32_t              tiles;        /* private, like all that follows: tiles in a row of the atlas */
    uint32_t              drawn;        /* views that glbk_csm_builder_draw drew last */
    uint32_t              drawn_from;   /* the first of them */
    uint32_t              next_view;    /* the first that is not compressed yet */
    uint32_t              passes;       /* runs of the shader that compresses */
    uint32_t              map_side;     /* of the desc's maps, like the next five, without defaults */
    uint32_t              depth_bits;
    uint32_t              layer_count;
    float                 open_thickness;
    int                   positional;
    int                   self_only;
    int                   sphere;
    float                 center[3], radius;
    float                 eyes[64][4];  /* of the views drawn last: see glbk_csm_peel */
    glbk_csm_view_fn      view_fn;
    glbk_csm_draw_fn      draw_fn;
    void                 *user;
    glbk_program          first_layer;
    glbk_program          next_layer;
    glbk_program          compress;
    glbk_texture          layers[3];    /* an atlas of tiles each */
    glbk_texture          depth;
    glbk_texture          opened[2];    /* core path: open segments, read from one and written to the other */
    glbk_texture          records[3];   /* core path */
    glbk_target           layer_targets[3];
    glbk_target           targets[2];
    glbk_buffer           block;
    glbk_buffer           storage;      /* compute path: open segments and records */
    int                   now;          /* core path: which of opened and targets is up to date */
    int                   compute;
    uint32_t             *words;        /* what was read back */
    uint32_t             *firsts;       /* the first view of the open segment of each pixel */
    cohsm_segment        *segments;     /* not private: after glbk_csm_builder_end all of them, in the order
                                           that cohsm_builder_import wants, until the builder is freed */
    size_t                segment_count;
    size_t                segment_room;
} glbk_csm_builder;

GLBK_DEF glbk_result glbk_csm_builder_create(glbk_context *ctx, const glbk_csm_builder_desc *desc,
                                             glbk_csm_builder *out);
/* Makes a builder that has drawn no view yet, which glbk_csm_builder_free takes back.
   Memory   here 84 map_side^2 bytes; on the GPU 4 layers of up to 4 MB, and 64 map_side^2 bytes
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: a field is out of range. GLBK_ERR_ALLOC, and
            those of textures, targets and glbk_program_compile */

GLBK_DEF glbk_result glbk_csm_builder_draw(glbk_context *ctx, glbk_csm_builder *builder, uint32_t from,
                                           uint32_t count);
/* Draws the layers of views from .. from + count - 1, calling view_fn and draw_fn once for each view and
   layer.
   count    1 .. builder->batch
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, the builder was not created, or count is 0. GLBK_ERR_LIMIT:
            count is above builder->batch. Those of glbk_begin */

GLBK_DEF glbk_result glbk_csm_builder_compress(glbk_context *ctx, glbk_csm_builder *builder);
/* Finds the segments of the views that were drawn last, which must follow those compressed before, and reads
   them back.
   Memory   12 bytes a segment
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the builder was not created. GLBK_ERR_ORDER: no views
            were drawn, others come next, or they lie on both sides of a multiple of 65,536. GLBK_ERR_ALLOC,
            and those of glbk_target_read and glbk_buffer_read */

GLBK_DEF glbk_result glbk_csm_builder_end(glbk_context *ctx, glbk_csm_builder *builder);
/* Ends the segments that are open. Call it once, after the last view: builder->segments are complete then. In
   the cohsm_stats of such a build empty_intervals and open_entries mean nothing, since csm.h does not see the
   layers.
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the builder was not created. GLBK_ERR_ORDER: no view was
            compressed. GLBK_ERR_ALLOC */

GLBK_DEF void glbk_csm_builder_free(glbk_context *ctx, glbk_csm_builder *builder);
/* Deletes the builder's objects of GL, frees its memory and zeroes the struct. NULL is allowed. */

/* ==== src/gl_csm/bindings.h ==== */

/* ---- csm: what its GLSL declares; see "bindings" in gl_programs.h ---- */

/* Tables of blocks, lights and instances, and questions. */
#define GLBK_CSM_SCENE_TEXTURES(X)              \
    X(usampler2DArray, glbk_csm_blocks, 0)      \
    X(usampler2DArray, glbk_csm_lights, 1)      \
    X(usampler2DArray, glbk_csm_instances, 7)   \
    X(usampler2DArray, glbk_csm_questions, 5)

/* Pictures: the sum of the frames, and two textures of the G-buffer, whose own slots are 8 to 11. */
#define GLBK_CSM_PICTURE_TEXTURES(X)            \
    X(usampler2D, glbk_csm_place, 2)            \
    X(usampler2D, glbk_csm_normal, 3)           \
    X(glbk_color_sampler, glbk_csm_sum, 6)

/* Building: depth layers of a batch of views, and the open segment of each pixel. */
#define GLBK_CSM_BUILD_TEXTURES(X)              \
    X(usampler2D, glbk_csm_layer0, 2)           \
    X(usampler2D, glbk_csm_layer1, 3)           \
    X(usampler2D, glbk_csm_layer2, 4)           \
    X(usampler2D, glbk_csm_opened, 5)

#define GLBK_CSM_TEXTURES(X)                    \
    GLBK_CSM_SCENE_TEXTURES(X)                  \
    GLBK_CSM_PICTURE_TEXTURES(X)                \
    GLBK_CSM_BUILD_TEXTURES(X)

/* The instances of a scene. */
#define GLBK_CSM_SCENE_MEMBERS(X)                                                               \
    X(uint, count, 1)                                                                           \
    X(uint, in_block, 1)            /* 1: they stand in this block, 0: in their table */        \
    X(uint, pad0, 1) X(uint, pad1, 1)                                                           \
    X(uvec4, instances, 192)        /* 12 for each of 16: its record, texels 1 to 7 of its block */

/* This block says what one pass shades: samples of one light. */
#define GLBK_CSM_LIGHT_MEMBERS(X)                                                               \
    X(uint, light_texel, 1)         /* where the light begins in its table */                   \
    X(uint, pattern_texel, 1)       /* where the patterns begin in that table */                \
    X(uint, sample_count, 1)        /* S, of this light in this frame */                        \
    X(uint, sampling, 1)            /* lsamp_sampling */                                        \
    X(uint, seed, 1)                                                                            \
    X(uint, roulette_seed, 1)                                                                   \
    X(uint, frame, 1)                                                                           \
    X(uint, first, 1)               /* the pass takes samples first .. end - 1 of each pixel; */ \
    X(uint, end, 1)                 /* of an asker there are questions 0 .. end - 1 */

/* A pass of the renderer, a resolve, or questions. */
#define GLBK_CSM_FRAME_MEMBERS(X)                                                               \
    GLBK_CSM_LIGHT_MEMBERS(X)                                                                   \
    X(uint, plane_count, 1)                                                                     \
    X(uint, width, 1) X(uint, height, 1)                                                        \
    X(float, bias, 1)               /* pixels of a map */                                       \
    X(float, offset, 1)             /* pixels of a map that receivers of local lights move */   \
    X(uint, adds, 1)                /* 0: the sum begins with this pass */                      \
    X(float, frame_share, 1)        /* resolve: 1 / frames in the sum; 0: there are none */     \
    X(vec4, eye, 1)                 /* world; w is not used */                                  \
    X(vec4, own, 1)                 /* numbers for GLSL of the user's */                        \
    X(vec4, planes, 8)              /* unit normal, distance from the origin */

#ifndef GLBK_CSM_WITHOUT_BUILD
/* A batch of views that are drawn and compressed. */
#define GLBK_CSM_PEEL_MEMBERS(X)                                                                \
    X(mat4, view, 1)                /* object space to pixels of a tile, and depth or w */      \
    X(float, clip_per_pixel, 1)     /* 2 / side */                                              \
    X(float, depth_scale, 1)        /* of w, in perspective views; 0: z is the depth */         \
    X(float, open_thickness, 1)     /* in 16-bit depths; of the depth, in perspective views */  \
    X(uint, depth_top, 1)           /* the greatest value of the grid of depths */              \
    X(uint, side, 1) X(uint, tiles_across, 1) X(uint, view_count, 1)                            \
    GLBK_CSM_LAYER_MEMBERS(X)

#define GLBK_CSM_LAYER_MEMBERS(X)                                                               \
    X(uint, far_layer, 1)           /* not 0: COHSM_LAYERS_Z1Z3_FAR, or _SPHERE */              \
    X(uint, positional, 1)          /* not 0: perspective views */                              \
    X(uint, self_only, 1)           /* as in cohsm_desc */                                      \
    X(uint, sphere, 1)              /* not 0: COHSM_LAYERS_Z1Z3_SPHERE */                       \
    X(uint, pad0, 1)                                                                            \
    X(vec4, eyes, 64)               /* of each view: place along the axes of its face, in radii about the \
                                       sphere; a radius in depths */

#define GLBK_CSM_BUILD_BLOCKS(X) X(glbk_csm_peel, 3, GLBK_CSM_PEEL_MEMBERS)
#else
#define GLBK_CSM_BUILD_BLOCKS(X)
#endif

#define GLBK_CSM_BLOCKS(X)                              \
    X(glbk_csm_scene, 0, GLBK_CSM_SCENE_MEMBERS)        \
    X(glbk_csm_frame, 1, GLBK_CSM_FRAME_MEMBERS)        \
    GLBK_CSM_BUILD_BLOCKS(X)

/* Questions, two uvec4 each, and their answers; open segments and records of a builder, four uvec4 a
   pixel. */
#define GLBK_CSM_STORAGE(X)                             \
    X(readonly, uvec4, glbk_csm_asked, 1)               \
    X(writeonly, float, glbk_csm_answers, 2)            \
    X(restrict, uvec4, glbk_csm_records, 3)

/* The sum of the frames, changed in place. */
#define GLBK_CSM_IMAGES(X) X(restrict, rgba32f, image2D, glbk_csm_total, 0)

GLBK__PART(CSM)

/* ==== src/gl_csm/begin.h ==== */

/* ---- end of the declarations ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_CSM_H */

/* ==== implementation ==================================================================================== */

#if defined(GL_CSM_IMPLEMENTATION) && !defined(GL_CSM_IMPLEMENTED)
#define GL_CSM_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ==== src/shared/mem.h ==== */

/* unit mem: checked sizes, and the caller's allocator with malloc and free as its default */

typedef struct glbk_csm__allocator {
    void *(*alloc_fn)(size_t size, void *user);
    void (*free_fn)(void *memory, void *user);
    void *user;
} glbk_csm__allocator;

static inline void *glbk_csm__default_alloc(size_t size, void *user)
{
    (void)user;
    return malloc(size);
}

static inline void glbk_csm__default_free(void *memory, void *user)
{
    (void)user;
    free(memory);
}

/* Writes a * b and returns 1; returns 0, with *out untouched, if the product does not fit. */
static inline int glbk_csm__mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b) return 0;
    *out = a * b;
    return 1;
}

static inline glbk_csm__allocator glbk_csm__allocator_make(void *(*alloc_fn)(size_t, void *),
                                           void (*free_fn)(void *, void *), void *user)
{
    glbk_csm__allocator a;
    a.alloc_fn = alloc_fn && free_fn ? alloc_fn : glbk_csm__default_alloc;
    a.free_fn = alloc_fn && free_fn ? free_fn : glbk_csm__default_free;
    a.user = user;
    return a;
}

/* Returns NULL if there is no memory, and also if the size is 0, so that a caller has one thing to test. */
static inline void *glbk_csm__alloc(const glbk_csm__allocator *a, size_t size)
{
    return size ? a->alloc_fn(size, a->user) : NULL;
}

static inline void *glbk_csm__alloc_array(const glbk_csm__allocator *a, size_t count, size_t item_size)
{
    size_t size;
    return glbk_csm__mul_size(count, item_size, &size) ? glbk_csm__alloc(a, size) : NULL;
}

static inline void glbk_csm__free(const glbk_csm__allocator *a, void *memory)
{
    if (memory) a->free_fn(memory, a->user);
}

/* ==== src/shared/v3.h ==== */

/* unit v3: three floats */

/* tcc 0.9.27 stores a returned struct of 12 bytes as 16, over the caller's next variable. */
typedef struct glbk_csm__v3 {
    float x, y, z;
#ifdef __TINYC__
    float unused;
#endif
} glbk_csm__v3;

static inline glbk_csm__v3 glbk_csm__v3_make(float x, float y, float z)
{
    glbk_csm__v3 v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}

static inline glbk_csm__v3 glbk_csm__v3_load(const float *p) { return glbk_csm__v3_make(p[0], p[1], p[2]); }
static inline void glbk_csm__v3_store(float *p, glbk_csm__v3 v) { p[0] = v.x; p[1] = v.y; p[2] = v.z; }

static inline glbk_csm__v3 glbk_csm__v3_sub(glbk_csm__v3 a, glbk_csm__v3 b)
{
    return glbk_csm__v3_make(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline glbk_csm__v3 glbk_csm__v3_scale(glbk_csm__v3 a, float s)
{
    return glbk_csm__v3_make(a.x * s, a.y * s, a.z * s);
}

static inline float glbk_csm__v3_dot(glbk_csm__v3 a, glbk_csm__v3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline float glbk_csm__v3_length(glbk_csm__v3 a)
{
    return sqrtf(glbk_csm__v3_dot(a, a));
}

static inline glbk_csm__v3 glbk_csm__v3_cross(glbk_csm__v3 a, glbk_csm__v3 b)
{
    return glbk_csm__v3_make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

/* Returns a with length 1. The largest component scales the others first, so that neither tiny nor huge
   vectors leave the range of floats. The zero vector stays zero. */
static inline glbk_csm__v3 glbk_csm__v3_normalize(glbk_csm__v3 a)
{
    float x = fabsf(a.x), y = fabsf(a.y), z = fabsf(a.z), m = x > y ? x : y;
    m = m > z ? m : z;
    if (!(m > 0.0f)) return glbk_csm__v3_make(0.0f, 0.0f, 0.0f);
    if (m < 1e-30f) {
        a = glbk_csm__v3_scale(a, 1e30f);
        m *= 1e30f;
    }
    a = glbk_csm__v3_make(a.x / m, a.y / m, a.z / m);
    m = glbk_csm__v3_length(a);
    return glbk_csm__v3_make(a.x / m, a.y / m, a.z / m);
}

/* Returns 1 if x is finite, by its exponent bits: under -ffast-math compilers may take isfinite() for always
   true. */
static inline int glbk_csm__finite(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (bits & 0x7f800000u) != 0x7f800000u;
}

/* Writes b1 and b2, which are orthonormal and right-handed together with a unit n; n.z may be -0 or -1. Duff
   et al., "Building an orthonormal basis, revisited", JCGT 6(1), 2017. */
static inline void glbk_csm__v3_basis(glbk_csm__v3 n, glbk_csm__v3 *b1, glbk_csm__v3 *b2)
{
    float s = n.z >= 0.0f ? 1.0f : -1.0f;
    float a = -1.0f / (s + n.z), b = n.x * n.y * a;
    *b1 = glbk_csm__v3_make(1.0f + s * n.x * n.x * a, s * b, -s * n.x);
    *b2 = glbk_csm__v3_make(b, s + n.y * n.y * a, -n.y);
}

/* ==== src/shared/m4.h ==== */

/* unit m4, needs v3: column-major 4 x 4 matrices, float[16], affine */

static inline glbk_csm__v3 glbk_csm__m4_point(const float *m, glbk_csm__v3 p)
{
    return glbk_csm__v3_make(m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12],
                     m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13],
                     m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14]);
}

/* Returns m, or the identity if all sixteen numbers are 0: so a struct that was zeroed stands where it is. */
static inline const float *glbk_csm__m4_or_identity(const float *m)
{
    static const float identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    int i;
    for (i = 0; i < 16; i++)
        if (m[i] != 0.0f) return m;         /* so does NaN, for others to refuse */
    return identity;
}

/* Returns 1 if a matrix is finite and its last row is 0 0 0 1. */
static inline int glbk_csm__m4_is_affine(const float *m)
{
    int i;
    for (i = 0; i < 16; i++)
        if (!glbk_csm__finite(m[i])) return 0;
    return m[3] == 0.0f && m[7] == 0.0f && m[11] == 0.0f && m[15] == 1.0f;
}

/* Writes the inverse of m, which may be out itself, and returns 1. Returns 0, with out untouched, if m is
   singular to float precision; the test compares the determinant with the product of the column lengths and
   is therefore free of scale. The arithmetic is double, since the inverse of a badly scaled matrix is used
   on points. */
static inline int glbk_csm__m4_affine_inverse(float *out, const float *m)
{
    double n[3][3], r[12], det, size;
    double tx = (double)m[12], ty = (double)m[13], tz = (double)m[14];
    int i, j;

    for (i = 0; i < 9; i++) n[i % 3][i / 3] = (double)m[4 * (i / 3) + i % 3];
    for (i = 0; i < 3; i++)         /* cofactors: rows and columns in turn give them their signs */
        for (j = 0; j < 3; j++)
            r[3 * j + i] = n[(j + 1) % 3][(i + 1) % 3] * n[(j + 2) % 3][(i + 2) % 3] -
                           n[(j + 1) % 3][(i + 2) % 3] * n[(j + 2) % 3][(i + 1) % 3];
    det = n[0][0] * r[0] + n[0][1] * r[1] + n[0][2] * r[2];
    size = sqrt((n[0][0] * n[0][0] + n[1][0] * n[1][0] + n[2][0] * n[2][0]) *
                (n[0][1] * n[0][1] + n[1][1] * n[1][1] + n[2][1] * n[2][1])) *
           sqrt(n[0][2] * n[0][2] + n[1][2] * n[1][2] + n[2][2] * n[2][2]);
    if (!(det > 1e-7 * size || det < -1e-7 * size)) return 0;
    for (i = 0; i < 9; i++) r[i] /= det;
    for (i = 0; i < 3; i++) r[9 + i] = -(r[i] * tx + r[3 + i] * ty + r[6 + i] * tz);
    for (i = 0; i < 12; i++)
        if (!glbk_csm__finite((float)r[i])) return 0;
    for (i = 0; i < 4; i++) {
        out[4 * i] = (float)r[3 * i];
        out[4 * i + 1] = (float)r[3 * i + 1];
        out[4 * i + 2] = (float)r[3 * i + 2];
        out[4 * i + 3] = i == 3 ? 1.0f : 0.0f;
    }
    return 1;
}

/* Returns 1 and writes *scale if m is a rotation times one scale > 0, without mirroring, and a translation.
   Its columns must be of equal length and at right angles within 1e-4, which products of float rotations
   reach. */
static inline int glbk_csm__m4_is_rigid_uniform(const float *m, float *scale)
{
    glbk_csm__v3 x = glbk_csm__v3_load(m), y = glbk_csm__v3_load(m + 4), z = glbk_csm__v3_load(m + 8);
    float lx, ly, lz;
    float s, tolerance;

    if (!glbk_csm__m4_is_affine(m)) return 0;
    lx = glbk_csm__v3_length(x);
    ly = glbk_csm__v3_length(y);
    lz = glbk_csm__v3_length(z);
    if (!(lx > 0.0f && ly > 0.0f && lz > 0.0f) || !glbk_csm__finite(lx + ly + lz)) return 0;
    s = (lx + ly + lz) / 3.0f;
    tolerance = 1e-4f * s;
    if (fabsf(lx - s) > tolerance || fabsf(ly - s) > tolerance || fabsf(lz - s) > tolerance) return 0;
    x = glbk_csm__v3_scale(x, 1.0f / lx);
    y = glbk_csm__v3_scale(y, 1.0f / ly);
    z = glbk_csm__v3_scale(z, 1.0f / lz);
    if (fabsf(glbk_csm__v3_dot(x, y)) > 1e-4f || fabsf(glbk_csm__v3_dot(x, z)) > 1e-4f) return 0;
    if (fabsf(glbk_csm__v3_dot(y, z)) > 1e-4f ||
        glbk_csm__v3_dot(glbk_csm__v3_cross(x, y), z) < 0.0f) return 0;
    *scale = s;
    return 1;
}

/* ==== src/shared/unit.h ==== */

/* unit unit: which vectors count as unit, the same in every header (src/README.md, "Unit vectors") */

/* The squares of the least and the greatest length that count as 1: an 8-bit normal map makes such
   vectors. */
#define GLBK_CSM__UNIT_LEAST2 0.9409f       /* 0.97^2 */
#define GLBK_CSM__UNIT_MOST2 1.0609f        /* 1.03^2 */

/* Says whether a vector is unit, by the square of its length. If that is not a number, the vector is not. */
static inline int glbk_csm__is_unit2(float length2)
{
    return length2 >= GLBK_CSM__UNIT_LEAST2 && length2 <= GLBK_CSM__UNIT_MOST2;
}

/* ==== src/shared/gl_memory.h ==== */

/* unit gl_memory, needs mem: the allocator of a glbk_context (gl_backend.h) */

static inline glbk_csm__allocator glbk_csm__memory(const glbk_context *ctx)
{
    const glbk_allocator *a = &ctx->system.allocator;
    return glbk_csm__allocator_make(a->alloc_fn, a->free_fn, a->user);
}

/* ==== GLSL of src/gl_csm ==== */


static const struct { char facts[34];
    char s0[3977]; char s1[1574]; char end; } glbk__glsl_lib_cohsm_brdf_glsl GLBK__TIGHT = {
    "lib/cohsm_brdf.glsl\0" "cohsm_math" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\n\n#ifndef COHSM_LOBES\n"
    "#error \"cohsm_brdf: COHSM_LOBES, 1..8\"\n"
    "#endif\n"
    "#ifndef COHSM_LOBE\n"
    "#error \"cohsm_brdf: COHSM_LOBE(i), texel i of the lobes\"\n"
    "#endif\n"
    "\n#define COHSM_BRDF_LAMBERT 1u\n"
    "#define COHSM_BRDF_PHONG 2u\n"
    "#define COHSM_BRDF_LAFORTUNE 3u\n"
    "#define COHSM_BRDF_METAL_ROUGH 4u\n"
    "\nstruct cohsm_material{\n"
    "uint type;\n"
    "vec3 diffuse,\n"
    "specular;\n"
    "float exponent,\n"
    "metallic,\n"
    "roughness;\n"
    "uint lobe,\n"
    "lobe_count;\n"
    "};\n"
    "\nstruct cohsm_surface{\n"
    "vec3 t;\n"
    "vec3 b;\n"
    "vec3 n;\n"
    "vec3 to_eye;\n"
    "vec3 diffuse;\n"
    "vec3 f0;\n"
    "float alpha;\n"
    "int lobe_count;\n"
    "vec4 lobes[COHSM_LOBES];\n"
    "vec4 scales[COHSM_LOBES];\n"
    "float diffuse_share,\n"
    "peak;\n"
    "bool black;\n"
    "};\n"
    "\nstruct cohsm_response{\n"
    "vec3 diffuse;\n"
    "vec3 specular;\n"
    "float diffuse_pdf,\n"
    "specular_pdf;\n"
    "};\n"
    "\nfloat cohsm_mean(vec3 c){return(c.x+c.y+c.z)*(1./3.);}\n"
    "\n\nvec3 cohsm_to_axes(cohsm_surface s,vec3 w){return vec3(dot(w,s.t),dot(w,s.b),dot(w,s.n));}\n"
    "vec3 cohsm_from_axes(cohsm_surface s,vec3 w){return s.t*w.x+s.b*w.y+s.n*w.z;}\n"
    "\n\nvec3 cohsm_schlick(vec3 f0,float cosine)\n"
    "{\n"
    "float x=1.-cosine,f=x*x*(x*x)*x;\n"
    "return f0*(1.-f)+f;\n"
    "}\n"
    "\n\nfloat cohsm_add_lobe(inout cohsm_surface s,vec3 c,float exponent,vec3 scale)\n"
    "{\n"
    "vec3 a=c*s.to_eye;\n"
    "float size=sqrt(dot(a,a));\n"
    "if(!(size>.0)||s.lobe_count>=COHSM_LOBES)return .0;\n"
    "a/=size;\n"
    "if(exponent>.0)scale*=cohsm_pow(size,exponent);\n"
    "float albedo=cohsm_mean(scale)*2.*COHSM_PI/(exponent+2.)*max(a.z,.1);\n"
    "if(!(albedo>.0)||!cohsm_finite3(scale))return .0;\n"
    "for(int i=0;i<COHSM_LOBES;i++)\n"
    "if(i==s.lobe_count){\n"
    "s.lobes[i]=vec4(a,exponent);\n"
    "s.scales[i]=vec4(scale,albedo);\n"
    "}\n"
    "s.lobe_count++;\n"
    "return albedo;\n"
    "}\n"
    "\n\nfloat cohsm_specular_init(inout cohsm_surface s,const cohsm_material m)\n"
    "{\n"
    "if(m.type==COHSM_BRDF_METAL_ROUGH){\n"
    "s.alpha=max(m.roughness*m.roughness,.002);\n"
    "s.f0=vec3(.04)*(1.-m.metallic)+m.diffuse*m.metallic;\n"
    "s.diffuse=m.diffuse*(1.-m.metallic);\n"
    "s.lobe_count=1;\n"
    "float share=cohsm_mean(cohsm_schlick(s.f0,s.to_eye.z));\n"
    "s.scales[0]=vec4(.0,.0,.0,share);\n"
    "return share;\n"
    "}\n"
    "if(m.type==COHSM_BRDF_PHONG)\n"
    "return cohsm_add_lobe(s,vec3(-1.,-1.,1.),m.exponent,\n"
    "m.specular*((m.exponent+2.)/(2.*COHSM_PI)));\n"
    "float sum=.0;\n"
    "if(m.type==COHSM_BRDF_LAFORTUNE)\n"
    "for(uint i=0u;i<m.lobe_count;i++){\n"
    "vec4 axis=uintBitsToFloat(COHSM_LOBE(2u*(m.lobe+i)));\n"
    "vec3 scale=uintBitsToFloat(COHSM_LOBE(2u*(m.lobe+i)+1u)).xyz;\n"
    "sum+=cohsm_add_lobe(s,axis.xyz,axis.w,scale);\n"
    "}\n"
    "return sum;\n"
    "}\n"
    "\n\ncohsm_surface cohsm_surface_at(const cohsm_material m,vec3 normal,vec3 tangent,vec3 to_eye)\n"
    "{\n"
    "cohsm_surface s;\n"
    "s.n=cohsm_normalize(normal);\n"
    "vec3 t=tangent-s.n*dot(tangent,s.n);\n"
    "if(dot(t,t)>1e-6){\n"
    "s.t=cohsm_normalize(t);\n"
    "s.b=cross(s.n,s.t);\n"
    "}else\n"
    "cohsm_basis(s.n,s.t,s.b);\n"
    "s.to_eye=cohsm_to_axes(s,cohsm_normalize(to_eye));\n"
    "if(s.to_eye.z<1e-3)s.to_eye=cohsm_normalize(vec3(s.to_eye.xy,1e-3));\n"
    "s.to_eye.z=min(s.to_eye.z,1.);\n"
    "s.diffuse=m.diffuse;\n"
    "s.f0=vec3(.0);\n"
    "s.alpha=.0;\n"
    "s.lobe_count=0;\n"
    "for(int i=0;i<COHSM_LOBES;i++){\n"
    "s.lobes[i]=vec4(.0);\n"
    "s.scales[i]=vec4(.0);\n"
    "}\n"
    "float specular=cohsm_specular_init(s,m),diffuse=cohsm_mean(s.diffuse);\n"
    "s.black=!(diffuse+specular>.0);\n"
    "s.diffuse_share=cohsm_if(s.black,1.,diffuse/(diffuse+specular));\n"
    "s.peak=s.diffuse_share*(1./COHSM_PI);\n"
    "for(int i=0;i<COHSM_LOBES;i++)\n"
    "if(i<s.lobe_count){\n"
    "s.scales[i].w/=specular;\n"
    "float lobe=(s.lobes[i].w+1.)/(2.*COHSM_PI);\n"
    "if(s.alpha>.0)lobe=.25/(COHSM_PI*s.alpha*s.alpha);\n"
    "s.peak+=(1.-s.diffuse_share)*s.scales[i].w*lobe;\n"
    "}\n"
    "return s;\n"
    "}\n"
    "\n\nvoid cohsm_ggx(cohsm_surface s,vec3 wi,inout cohsm_response r)\n"
    "{\n"
    "vec3 h=cohsm_normalize(s.to_eye+wi);\n"
    "float a2=s.alpha*s.alpha,q=h.x*h.x+h.y*h.y+a2*h.z*h.z,d=a2/(COHSM_PI*q*q);\n"
    "float go=sqrt(a2+(1.-a2)*s.to_eye.z*s.to_eye.z),gi=sqrt(a2+(1.-a2)*wi.z*wi.z);\n"
    "vec3 f=cohsm_schlick(s.f0,clamp(dot(s.to_eye,h),.0,1.));\n"
    "r.specular=f*(.5*d/(wi.z*go+s.to_eye.z*gi));\n"
    "r.diffuse*=1.-f;\n"
    "r.specular_pdf=.5*d/(s.to_eye.z+go);\n"
    "}\n"
    "\n\ncohsm_response cohsm_respond(cohsm_surface s,vec3 wi)\n"
    "{\n"
    "cohsm_response r=cohsm_response(vec3(.0),vec3(.0),.0,.0);\n"
    "if(!(wi.z>.0))return r;\n"
    "r.diffuse=s.diffuse*(1./COHSM_PI);\n"
    "r.diffuse_pdf=wi.z*(1./COHSM_PI);\n"
    "if(s.lobe_count>0&&s.alpha>.0){\n"
    "cohsm_ggx(s,wi,r);\n"
    "return r;\n"
    "}\n",
    "for(int i=0;i<COHSM_LOBES;i++){\n"
    "float c=dot(s.lobes[i].xyz,wi);\n"
    "if(i<s.lobe_count&&c>.0){\n"
    "c=cohsm_pow(c,s.lobes[i].w);\n"
    "r.specular+=s.scales[i].xyz*c;\n"
    "r.specular_pdf+=s.scales[i].w*c*(s.lobes[i].w+1.)/(2.*COHSM_PI);\n"
    "}\n"
    "}\n"
    "return r;\n"
    "}\n"
    "\n\nfloat cohsm_brdf_pdf(cohsm_surface s,const cohsm_response r)\n"
    "{\n"
    "return s.diffuse_share*r.diffuse_pdf+(1.-s.diffuse_share)*r.specular_pdf;\n"
    "}\n"
    "\n\n\nvec3 cohsm_ggx_draw(cohsm_surface s,vec2 u)\n"
    "{\n"
    "vec3 o=cohsm_normalize(vec3(s.to_eye.xy*s.alpha,s.to_eye.z));\n"
    "float z=(1.-u.x)*(1.+o.z)-o.z,r=cohsm_safe_sqrt(1.-z*z);\n"
    "vec2 sc=cohsm_sincos(2.*COHSM_PI*u.y);\n"
    "vec3 h=vec3(r*sc.y,r*sc.x,z)+o;\n"
    "h=cohsm_normalize(vec3(h.xy*s.alpha,h.z));\n"
    "return cohsm_normalize(h*(2.*dot(s.to_eye,h))-s.to_eye);\n"
    "}\n"
    "\n\nvec3 cohsm_lobe_draw(vec4 lobe,vec2 u)\n"
    "{\n"
    "vec3 t,b;\n"
    "float c=cohsm_pow(1.-u.x,1./(lobe.w+1.)),r=cohsm_safe_sqrt(1.-c*c);\n"
    "vec2 sc=cohsm_sincos(2.*COHSM_PI*u.y);\n"
    "cohsm_basis(lobe.xyz,t,b);\n"
    "return t*(r*sc.y)+b*(r*sc.x)+lobe.xyz*c;\n"
    "}\n"
    "\n\nvec3 cohsm_brdf_draw(cohsm_surface s,float diffuse_share,vec2 u)\n"
    "{\n"
    "if(u.x<diffuse_share||s.lobe_count==0){\n"
    "if(diffuse_share>.0)u.x=cohsm_clamp_unit(u.x/diffuse_share);\n"
    "vec2 p=cohsm_concentric(u);\n"
    "return vec3(p,cohsm_safe_sqrt(1.-p.x*p.x-p.y*p.y));\n"
    "}\n"
    "u.x=(u.x-diffuse_share)/(1.-diffuse_share);\n"
    "if(s.alpha>.0)return cohsm_ggx_draw(s,vec2(cohsm_clamp_unit(u.x),u.y));\n"
    "vec4 lobe=s.lobes[0];\n"
    "float share=s.scales[0].w;\n"
    "bool on=true;\n"
    "for(int i=1;i<COHSM_LOBES;i++){\n"
    "on=on&&i<s.lobe_count&&u.x>=share;\n"
    "if(on){\n"
    "u.x-=share;\n"
    "share=s.scales[i].w;\n"
    "lobe=s.lobes[i];\n"
    "}\n"
    "}\n"
    "return cohsm_lobe_draw(lobe,vec2(cohsm_clamp_unit(u.x/share),u.y));\n"
    "}\n", 0
};

static const struct { char facts[38];
    char s0[3972]; char s1[1338]; char end; } glbk__glsl_lib_cohsm_emission_glsl GLBK__TIGHT = {
    "lib/cohsm_emission.glsl\0" "cohsm_math" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\n\n\n#ifndef COHSM_LIGHT_TEXEL\n"
    "#error \"cohsm_emission: COHSM_LIGHT_TEXEL(i), texel i of the lights\"\n"
    "#endif\n"
    "\n#define COHSM_SHAPE_ENVIRONMENT 1u\n"
    "#define COHSM_SHAPE_SUN 2u\n"
    "#define COHSM_SHAPE_POINT 3u\n"
    "#define COHSM_SHAPE_SPOT 4u\n"
    "#define COHSM_SHAPE_LINE 5u\n"
    "#define COHSM_SHAPE_RECTANGLE 6u\n"
    "#define COHSM_SHAPE_DISC 7u\n"
    "#define COHSM_SHAPE_SPHERE 8u\n"
    "#define COHSM_SHAPE_OWN 9u\n"
    "#define COHSM_SHAPE_MESH 10u\n"
    "#define COHSM_SHAPE_SURFACE 11u\n"
    "#ifdef COHSM_OWN_LIGHT\n"
    "void glbk_light_point(vec4 own,vec3 x,out vec3 position,out vec3 normal,out float area);\n"
    "vec3 glbk_light_emission(vec4 own,vec3 x,vec3 direction);\n"
    "#endif\n"
    "#ifdef COHSM_ONE_SHAPE\n"
    "#define COHSM_SHAPE_OF(l) uint(COHSM_ONE_SHAPE)\n"
    "#else\n"
    "#define COHSM_SHAPE_OF(l) l.shape\n"
    "#endif\n"
    "#define COHSM_INFINITY 3.402823466e38\n"
    "\nstruct cohsm_light{\n"
    "uint base;\n"
    "uint shape;\n"
    "uint width;\n"
    "uint height;\n"
    "uint flags;\n"
    "\nuint texels_at;\n"
    "uint sums_at;\n"
    "uint triangles_at;\n"
    "uint triangle_count;\n"
    "vec3 origin;\n"
    "vec3 n;\n"
    "vec3 ex;\n"
    "vec3 ey;\n"
    "vec3 u;\n"
    "vec3 v;\n"
    "vec3 radiance;\n"
    "vec4 own;\n"
    "float radius,\n"
    "lx,\n"
    "ly,\n"
    "area,\n"
    "cos_cone,\n"
    "turn,\n"
    "cosine_power;\n"
    "};\n"
    "\nstruct cohsm_aim{\n"
    "vec3 p;\n"
    "vec3 axis;\n"
    "float range,\n"
    "spread,\n"
    "solid_pdf,\n"
    "solid;\n"
    "vec4 edges;\n"
    "vec4 cap;\n"
    "};\n"
    "\nstruct cohsm_emission{\n"
    "vec3 direction;\n"
    "float range;\n"
    "vec3 coords;\n"
    "vec3 radiance;\n"
    "float pdf;\n"
    "};\n"
    "\n\nvec4 cohsm_floats(uint i){return uintBitsToFloat(COHSM_LIGHT_TEXEL(i));}\n"
    "\n\ncohsm_light cohsm_light_open(uint base)\n"
    "{\n"
    "cohsm_light l;\n"
    "uvec4 a=COHSM_LIGHT_TEXEL(base),b=COHSM_LIGHT_TEXEL(base+1u);\n"
    "vec4 c=cohsm_floats(base+2u),d=cohsm_floats(base+3u);\n"
    "vec4 e=cohsm_floats(base+4u),f=cohsm_floats(base+5u);\n"
    "vec4 g=cohsm_floats(base+6u),h=cohsm_floats(base+7u);\n"
    "l.base=base;\n"
    "l.shape=a.x;\n"
    "l.width=a.y;\n"
    "l.height=a.z;\n"
    "l.flags=a.w;\n"
    "l.texels_at=base+b.x;\n"
    "l.sums_at=base+b.y;\n"
    "l.triangles_at=base+b.z;\n"
    "l.triangle_count=b.w;\n"
    "l.origin=c.xyz;\n"
    "l.radius=c.w;\n"
    "l.n=d.xyz;\n"
    "l.lx=d.w;\n"
    "l.ex=e.xyz;\n"
    "l.ly=e.w;\n"
    "l.ey=f.xyz;\n"
    "l.area=f.w;\n"
    "l.radiance=g.xyz;\n"
    "l.cos_cone=g.w;\n"
    "l.own=vec4(.0);\n"
    "l.turn=h.w;\n"
    "c=cohsm_floats(base+8u);\n"
    "l.u=c.xyz;\n"
    "l.cosine_power=c.w;\n"
    "l.v=cohsm_floats(base+9u).xyz;\n"
    "return l;\n"
    "}\n"
    "\nbool cohsm_light_textured(const cohsm_light l){return(l.flags&1u)!=0u;}\n"
    "\n\nbool cohsm_light_is_delta(const cohsm_light l)\n"
    "{\n"
    "return COHSM_SHAPE_OF(l)>=COHSM_SHAPE_SUN&&COHSM_SHAPE_OF(l)<=COHSM_SHAPE_SPOT;\n"
    "}\n"
    "\n\nuint cohsm_index(float x,uint count){return min(uint(x*float(count)),count-1u);}\n"
    "\n\nvec4 cohsm_light_texel(const cohsm_light l,uint x,uint y)\n"
    "{\n"
    "return cohsm_floats(l.texels_at+y*l.width+x);\n"
    "}\n"
    "\n\n\nvec4 cohsm_texel_at(const cohsm_light l,vec2 x)\n"
    "{\n"
    "if(!cohsm_light_textured(l))return vec4(1.);\n"
    "uint i=cohsm_index(x.x,l.width),j=cohsm_index(x.y,l.height);\n"
    "vec4 a=cohsm_light_texel(l,i,j);\n"
    "if((l.flags&4u)==0u)return a;\n"
    "vec2 f=vec2(x.x*float(l.width)-(float(i)+.5),x.y*float(l.height)-(float(j)+.5));\n"
    "bool round_about=(l.flags&8u)!=0u;\n"
    "uint before=cohsm_if(i>0u,i-1u,cohsm_if(round_about,l.width-1u,0u));\n"
    "uint after=cohsm_if(i+1u<l.width,i+1u,cohsm_if(round_about,0u,i));\n"
    "uint i2=f.x<.0?before:after;\n"
    "uint j2=cohsm_if(f.y<.0,max(j,1u)-1u,min(j+1u,l.height-1u));\n"
    "f=abs(f);\n"
    "vec3 row=a.xyz*(1.-f.x)+cohsm_light_texel(l,i2,j).xyz*f.x;\n"
    "vec3 other=cohsm_light_texel(l,i,j2).xyz*(1.-f.x)+cohsm_light_texel(l,i2,j2).xyz*f.x;\n"
    "return vec4(row*(1.-f.y)+other*f.y,a.w);\n"
    "}\n"
    "\n\n\n\nuint cohsm_invert(uint at,uint count,float u,out float fraction)\n"
    "{\n"
    "uvec4 t=COHSM_LIGHT_TEXEL(at+cohsm_index(u,count));\n"
    "uint lo=t.z,hi=t.w;\n"
    "while(hi-lo>1u){\n"
    "uint middle=lo+(hi-lo)/2u;\n"
    "bool later=cohsm_floats(at+middle).x<=u;\n"
    "lo=later?middle:lo;\n"
    "hi=later?hi:middle;\n"
    "}\n"
    "vec2 sums=cohsm_floats(at+lo).xy;\n"
    "while(lo+1u<count&&sums.y<=u)sums=cohsm_floats(at+ ++lo).xy;\n"
    "while(lo>0u&&(sums.x>u||!(sums.y>sums.x)))\n"
    "sums=cohsm_floats(at+--lo).xy;\n"
    "fraction=cohsm_clamp_unit((u-sums.x)/(sums.y-sums.x));\n"
    "return lo;\n"
    "}\n"
    "\n\nuvec2 cohsm_pick_cell(const cohsm_light l,vec2 u,out vec2 inside)\n"
    "{\n"
    "uint y=cohsm_invert(l.sums_at,l.height,u.y,inside.y);\n"
    "uint x=cohsm_invert(l.sums_at+l.height+y*l.width,l.width,u.x,inside.x);\n"
    "return uvec2(x,y);\n"
    "}\n"
    "\n\nvec2 cohsm_pick_coords(const cohsm_light l,vec2 u)\n"
    "{\n",
    "if(!cohsm_light_textured(l))return u;\n"
    "vec2 inside;\n"
    "uvec2 cell=cohsm_pick_cell(l,u,inside);\n"
    "return vec2(cohsm_clamp_unit((float(cell.x)+inside.x)/float(l.width)),\n"
    "cohsm_clamp_unit((float(cell.y)+inside.y)/float(l.height)));\n"
    "}\n"
    "\n\nbool cohsm_emit(const cohsm_light l,vec3 texel,float cosine,inout cohsm_emission e)\n"
    "{\n"
    "e.radiance=l.radiance*texel;\n"
    "if(l.cosine_power>.0)e.radiance*=cohsm_pow(cosine,l.cosine_power);\n"
    "#ifdef COHSM_OWN_LIGHT\n"
    "if((l.flags&32u)!=0u){\n"
    "vec3 away=cohsm_if(COHSM_SHAPE_OF(l)==COHSM_SHAPE_ENVIRONMENT,e.direction,-e.direction);\n"
    "e.radiance*=max(glbk_light_emission(l.own,e.coords,away),vec3(.0));\n"
    "}\n"
    "#endif\n"
    "return cohsm_finite3(e.radiance)&&e.radiance.x+e.radiance.y+e.radiance.z>.0;\n"
    "}\n"
    "\n\n\n\nbool cohsm_emit_area(const cohsm_light l,const cohsm_aim a,vec3 q,vec3 n,vec2 x,float area_pdf,\n"
    "inout cohsm_emission e)\n"
    "{\n"
    "vec3 d=q-a.p;\n"
    "float square=dot(d,d),range=sqrt(square);\n"
    "if(!(range>.0)||!cohsm_finite(square))return false;\n"
    "vec3 w=d*(1./range);\n"
    "float cosine=-dot(n,w);\n"
    "#ifdef COHSM_OWN_LIGHT\n"
    "cosine=n==vec3(.0)?1.:cosine;\n"
    "#endif\n"
    "if(!(cosine>1e-7))return false;\n"
    "cosine=min(cosine,1.);\n"
    "e.coords.xy=vec2(cohsm_clamp_unit(x.x),cohsm_clamp_unit(x.y));\n"
    "e.range=range;\n"
    "vec4 texel=cohsm_texel_at(l,x);\n"
    "e.pdf=cohsm_if(a.solid_pdf>.0,a.solid_pdf,texel.w*area_pdf*square/cosine);\n"
    "e.direction=w;\n"
    "return cohsm_emit(l,texel.xyz,cosine,e);\n"
    "}\n", 0
};

static const struct { char facts[63];
    char s0[2737]; char end; } glbk__glsl_lib_cohsm_estimate_glsl GLBK__TIGHT = {
    "lib/cohsm_estimate.glsl\0" "cohsm_random cohsm_brdf cohsm_light" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\n\n\n#define COHSM_SAMPLING_BOTH 0\n"
    "#define COHSM_SAMPLING_LIGHT 1\n"
    "#define COHSM_SAMPLING_BRDF 2\n"
    "#define COHSM_SAMPLING_PAPER 3\n"
    "\nstruct cohsm_estimator{\n"
    "uint samples;\n"
    "uint seed;\n"
    "uint frame;\n"
    "cohsm_surface surface;\n"
    "cohsm_light light;\n"
    "cohsm_aim aim;\n"
    "bool reachable;\n"
    "bool split;\n"
    "float light_share;\n"
    "};\n"
    "\n\nvec3 cohsm_numbers(const cohsm_estimator e,uint pixel,uint k)\n"
    "{\n"
    "uint key=cohsm_hash_combine(e.seed,pixel),index=e.frame*e.samples+k;\n"
    "vec3 u;\n"
    "#ifdef COHSM_PATTERN\n"
    "u.xy=COHSM_PATTERN((key+e.frame*159u)&255u,k);\n"
    "if(e.frame>255u){\n"
    "u.xy+=vec2(cohsm_random(key,e.frame>>8,0u),cohsm_random(key,e.frame>>8,1u));\n"
    "u.xy-=floor(u.xy);\n"
    "u.xy=vec2(cohsm_clamp_unit(u.x),cohsm_clamp_unit(u.y));\n"
    "}\n"
    "#else\n"
    "u.xy=cohsm_sobol2(index,key);\n"
    "#endif\n"
    "u.z=.0;\n"
    "if(COHSM_SHAPE_OF(e.light)>=COHSM_SHAPE_OWN)u.z=cohsm_random(key,0x9e3779b9u,index);\n"
    "return u;\n"
    "}\n"
    "\n\ncohsm_estimator cohsm_estimator_at(cohsm_surface surface,const cohsm_light light,vec3 position,\n"
    "int sampling,uint samples,uint seed,uint frame)\n"
    "{\n"
    "cohsm_estimator e;\n"
    "e.samples=samples;\n"
    "e.seed=seed;\n"
    "e.frame=frame;\n"
    "e.surface=surface;\n"
    "e.light=light;\n"
    "e.reachable=cohsm_aim_at(light,position,e.aim)&&!surface.black;\n"
    "bool unseen=cohsm_light_is_delta(light)||COHSM_SHAPE_OF(light)>=COHSM_SHAPE_OWN;\n"
    "bool distant=COHSM_SHAPE_OF(light)==COHSM_SHAPE_ENVIRONMENT;\n"
    "e.split=distant&&sampling==COHSM_SAMPLING_PAPER;\n"
    "e.light_share=1.;\n"
    "if(unseen||sampling==COHSM_SAMPLING_LIGHT||!e.reachable)return e;\n"
    "if(sampling==COHSM_SAMPLING_BRDF)e.light_share=.0;\n"
    "else if(sampling==COHSM_SAMPLING_PAPER)e.light_share=cohsm_if(distant,surface.diffuse_share,1.);\n"
    "else if(distant)e.light_share=.5;\n"
    "else{\n"
    "float q=e.aim.solid*surface.peak;\n"
    "e.light_share=8./(8.+q*q*q);\n"
    "e.light_share=floor(e.light_share*float(samples)+.5)/float(samples);\n"
    "}\n"
    "return e;\n"
    "}\n"
    "\n\n\nvec3 cohsm_estimate(const cohsm_estimator e,vec3 u,out cohsm_emission found)\n"
    "{\n"
    "float c=e.light_share;\n"
    "bool by_light=u.x<c,hit;\n"
    "vec3 wi;\n"
    "u.x=cohsm_clamp_unit(cohsm_if(by_light,u.x/c,(u.x-c)/(1.-c)));\n"
    "if(by_light)\n"
    "hit=cohsm_light_draw(e.light,e.aim,u,found);\n"
    "else{\n"
    "wi=cohsm_brdf_draw(e.surface,cohsm_if(e.split,.0,e.surface.diffuse_share),u.xy);\n"
    "hit=cohsm_light_hit(e.light,e.aim,cohsm_from_axes(e.surface,wi),found)&&wi.z>.0;\n"
    "}\n"
    "if(!hit){\n"
    "found=cohsm_emission(e.surface.n,COHSM_INFINITY,vec3(.0),vec3(.0),.0);\n"
    "return vec3(.0);\n"
    "}\n"
    "wi=cohsm_to_axes(e.surface,found.direction);\n"
    "cohsm_response r=cohsm_respond(e.surface,wi);\n"
    "vec3 f=cohsm_if(e.split,cohsm_if(by_light,r.diffuse,r.specular),r.diffuse+r.specular);\n"
    "float split_pdf=cohsm_if(by_light,c*found.pdf,(1.-c)*r.specular_pdf);\n"
    "float pdf=cohsm_if(e.split,split_pdf,c*found.pdf+(1.-c)*cohsm_brdf_pdf(e.surface,r));\n"
    "if(!(wi.z>.0)||!(pdf>.0))return vec3(.0);\n"
    "f=f*found.radiance*(wi.z/pdf);\n"
    "return cohsm_if(cohsm_finite3(f),f,vec3(.0));\n"
    "}\n", 0
};

static const struct { char facts[50];
    char s0[3952]; char s1[3971]; char s2[2030]; char end; } glbk__glsl_lib_cohsm_light_glsl GLBK__TIGHT = {
    "lib/cohsm_light.glsl\0" "cohsm_emission cohsm_octa" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\n\n\nbool cohsm_environment_found(const cohsm_light l,uvec2 cell,vec2 x,vec3 w,inout cohsm_emission e)\n"
    "{\n"
    "vec4 texel=cohsm_light_texel(l,cell.x,cell.y);\n"
    "if((l.flags&4u)!=0u)\n"
    "texel.xyz=cohsm_texel_at(l,vec2(cohsm_clamp_unit(x.x),cohsm_clamp_unit(x.y))).xyz;\n"
    "x.x-=l.turn;\n"
    "e.coords.xy=vec2(cohsm_clamp_unit(x.x-floor(x.x)),cohsm_clamp_unit(x.y));\n"
    "e.range=COHSM_INFINITY;\n"
    "e.pdf=texel.w;\n"
    "e.direction=w;\n"
    "return cohsm_emit(l,texel.xyz,1.,e)&&e.pdf>.0;\n"
    "}\n"
    "\n\nfloat cohsm_row_edge(uint y,uint h)\n"
    "{\n"
    "uint m=min(y,h-y);\n"
    "float s=cohsm_sincos(1.57079633*float(m)/float(h)).x;\n"
    "s=1.-2.*s*s;\n"
    "return m==y?s:-s;\n"
    "}\n"
    "\nbool cohsm_environment_draw(const cohsm_light l,vec2 u,inout cohsm_emission e)\n"
    "{\n"
    "vec2 inside;\n"
    "uvec2 cell=cohsm_pick_cell(l,u,inside);\n"
    "float x=(float(cell.x)+inside.x)/float(l.width),top=cohsm_row_edge(cell.y,l.height);\n"
    "float y=top+(cohsm_row_edge(cell.y+1u,l.height)-top)*inside.y;\n"
    "float r=cohsm_safe_sqrt((1.-y)*(1.+y));\n"
    "vec2 sc=cohsm_sincos(2.*COHSM_PI*(x-l.turn-.5));\n"
    "vec2 coords=vec2(x,cohsm_acos(y)/COHSM_PI);\n"
    "return cohsm_environment_found(l,cell,coords,vec3(r*sc.y,y,r*sc.x),e);\n"
    "}\n"
    "\nbool cohsm_environment_hit(const cohsm_light l,vec3 w,inout cohsm_emission e)\n"
    "{\n"
    "vec2 x=vec2(.5+cohsm_atan2(w.z,w.x)/(2.*COHSM_PI)+l.turn,cohsm_acos(w.y)/COHSM_PI);\n"
    "x.x-=floor(x.x);\n"
    "return cohsm_environment_found(l,uvec2(cohsm_index(x.x,l.width),cohsm_index(x.y,l.height)),x,w,e);\n"
    "}\n"
    "\n\n\n\nvoid cohsm_rectangle_aim(const cohsm_light l,inout cohsm_aim a)\n"
    "{\n"
    "vec3 d=l.origin-a.p;\n"
    "float x0=dot(d,l.ex)*l.lx,y0=dot(d,l.ey)*l.ly,x1=x0+l.lx,y1=y0+l.ly,z=dot(d,l.n);\n"
    "float z2=z*z,n0=-y0/sqrt(z2+y0*y0),n1=x1/sqrt(z2+x1*x1);\n"
    "float n2=y1/sqrt(z2+y1*y1),n3=-x0/sqrt(z2+x0*x0);\n"
    "float k=2.*COHSM_PI-cohsm_acos(-n2*n3)-cohsm_acos(-n3*n0);\n"
    "a.edges=vec4(x0,x1,y0,y1);\n"
    "a.cap=vec4(z,n0,n2,k);\n"
    "a.solid=cohsm_acos(-n0*n1)+cohsm_acos(-n1*n2)-k;\n"
    "if(a.solid>.05&&cohsm_finite(a.solid))a.solid_pdf=1./a.solid;\n"
    "}\n"
    "\n\nfloat cohsm_flat_solid(vec3 n,vec3 d,float area)\n"
    "{\n"
    "float d2=dot(d,d),cosine=abs(dot(n,d))/sqrt(d2>.0?d2:1.);\n"
    "float near2=area*(1./(2.*COHSM_PI));\n"
    "return area*(cosine*d2+near2)/((d2+near2)*(d2+near2));\n"
    "}\n"
    "\n\nvec2 cohsm_rectangle_pick(const cohsm_aim a,vec2 u)\n"
    "{\n"
    "float z=a.cap.x,b0=a.cap.y;\n"
    "vec2 sc=cohsm_sincos(u.x*a.solid+a.cap.w);\n"
    "float f=(sc.y*b0-a.cap.z)/sc.x,c=1./sqrt(f*f+b0*b0);\n"
    "c=clamp(f>.0?c:-c,-1.,1.);\n"
    "float x=clamp(-(c*z)/sqrt(max(1.-c*c,1e-12)),a.edges.x,a.edges.y);\n"
    "float d=sqrt(x*x+z*z),h0=a.edges.z/sqrt(d*d+a.edges.z*a.edges.z);\n"
    "float h1=a.edges.w/sqrt(d*d+a.edges.w*a.edges.w),h=h0+u.y*(h1-h0);\n"
    "float y=cohsm_if(h*h<1.-1e-6,h*d/sqrt(1.-h*h),a.edges.w);\n"
    "return(vec2(x,y)-a.edges.xz)/(a.edges.yw-a.edges.xz);\n"
    "}\n"
    "\n\nbool cohsm_aim_at(const cohsm_light l,vec3 p,out cohsm_aim a)\n"
    "{\n"
    "vec3 d=l.origin-p;\n"
    "float r=l.radius;\n"
    "a=cohsm_aim(p,vec3(.0),.0,.0,.0,.0,vec4(.0),vec4(.0));\n"
    "if(COHSM_SHAPE_OF(l)==COHSM_SHAPE_RECTANGLE){\n"
    "if(!(dot(l.n,d)<.0))return false;\n"
    "if((l.flags&2u)!=0u&&!cohsm_light_textured(l))cohsm_rectangle_aim(l,a);\n"
    "if(!(a.solid_pdf>.0))a.solid=cohsm_flat_solid(l.n,d+(l.u+l.v)*.5,l.area);\n"
    "return true;\n"
    "}\n"
    "if(COHSM_SHAPE_OF(l)==COHSM_SHAPE_DISC){\n"
    "a.solid=cohsm_flat_solid(l.n,d,l.area);\n"
    "return dot(l.n,d)<.0;\n"
    "}\n"
    "if(COHSM_SHAPE_OF(l)==COHSM_SHAPE_SPHERE){\n"
    "a.range=sqrt(dot(d,d));\n"
    "if(!(a.range>r))return false;\n"
    "a.axis=d*(1./a.range);\n"
    "float s=(r/a.range)*(r/a.range);\n"
    "a.spread=s/(1.+sqrt(1.-s));\n"
    "a.solid=2.*COHSM_PI*a.spread;\n"
    "if(!cohsm_light_textured(l)&&a.spread>.0)a.solid_pdf=1./a.solid;\n"
    "return true;\n"
    "}\n"
    "if(COHSM_SHAPE_OF(l)==COHSM_SHAPE_LINE){\n"
    "float s=dot(d,l.n);\n"
    "d=l.n*s-d;\n"
    "a.range=sqrt(dot(d,d));\n"
    "if(!(a.range>r))return false;\n"
    "a.axis=d*(1./a.range);\n"
    "a.spread=cohsm_safe_sqrt(1.-(r/a.range)*(r/a.range));\n"
    "vec2 ends=vec2(s,s+l.lx);\n"
    "ends/=sqrt(a.range*a.range+ends*ends);\n"
    "a.solid=2.*r/a.range*(ends.y-ends.x);\n"
    "}\n"
    "return true;\n"
    "}\n"
    "\n\n\n\nbool cohsm_line_at(const cohsm_light l,const cohsm_aim a,float x,float sine,inout cohsm_emission e)\n"
    "{\n"
    "float cosine=cohsm_safe_sqrt(1.-sine*sine);\n"
    "vec3 n=a.axis*cosine+cross(l.n,a.axis)*sine;\n"
    "vec3 q=(l.origin+l.n*(x*l.lx))+n*l.radius;\n",
    "return cohsm_emit_area(l,a,q,n,vec2(x,.0),cosine/(2.*a.spread*l.radius*l.lx),e);\n"
    "}\n"
    "\n\nbool cohsm_sphere_at(const cohsm_light l,const cohsm_aim a,vec3 n,inout cohsm_emission e)\n"
    "{\n"
    "vec2 x=vec2(cohsm_clamp_unit(.5+cohsm_atan2(n.z,n.x)/(2.*COHSM_PI)),\n"
    "cohsm_clamp_unit(.5*(1.-n.y)));\n"
    "return cohsm_emit_area(l,a,l.origin+n*l.radius,n,x,1./l.area,e);\n"
    "}\n"
    "\nbool cohsm_sphere_draw(const cohsm_light l,const cohsm_aim a,vec2 u,inout cohsm_emission e)\n"
    "{\n"
    "if(!(a.solid_pdf>.0)){\n"
    "vec2 x=cohsm_pick_coords(l,u);\n"
    "float y=1.-2.*x.y,ring=cohsm_safe_sqrt(1.-y*y);\n"
    "vec2 sc=cohsm_sincos(2.*COHSM_PI*(x.x-.5));\n"
    "return cohsm_sphere_at(l,a,cohsm_normalize(vec3(ring*sc.y,y,ring*sc.x)*l.radius),e);\n"
    "}\n"
    "\n\nfloat r=l.radius,c=u.x*a.spread,s2=c*(2.-c);\n"
    "c=1.-c;\n"
    "float reach=cohsm_safe_sqrt(r*r-a.range*a.range*s2),along=a.range*s2+c*reach;\n"
    "float x=cohsm_safe_sqrt(s2)*(a.range*c-reach)/r;\n"
    "vec2 sc=cohsm_sincos(2.*COHSM_PI*u.y);\n"
    "vec3 t,b;\n"
    "cohsm_basis(a.axis,t,b);\n"
    "return cohsm_sphere_at(l,a,cohsm_normalize(t*(x*sc.y)+b*(x*sc.x)+a.axis*(-along/r)),e);\n"
    "}\n"
    "\n\nbool cohsm_delta_draw(const cohsm_light l,const cohsm_aim a,inout cohsm_emission e)\n"
    "{\n"
    "float scale=1.;\n"
    "e.pdf=1.;\n"
    "e.range=COHSM_INFINITY;\n"
    "e.direction=l.n;\n"
    "if(COHSM_SHAPE_OF(l)!=COHSM_SHAPE_SUN){\n"
    "vec3 d=l.origin-a.p;\n"
    "float range=sqrt(dot(d,d));\n"
    "if(!(range>.0)||!cohsm_finite(range))return false;\n"
    "e.direction=d*(1./range);\n"
    "if(COHSM_SHAPE_OF(l)==COHSM_SHAPE_SPOT&&-dot(e.direction,l.n)<l.cos_cone)return false;\n"
    "scale=1./(range*range);\n"
    "e.range=range;\n"
    "}\n"
    "return cohsm_emit(l,vec3(scale),1.,e);\n"
    "}\n"
    "\n\nvec3 cohsm_light_corner(const cohsm_light l,uint i){return cohsm_floats(l.triangles_at+i).xyz;}\n"
    "\n\n\nbool cohsm_mesh_draw(const cohsm_light l,const cohsm_aim a,vec3 u,inout cohsm_emission e)\n"
    "{\n"
    "uint lo=0u,hi=l.triangle_count-1u;\n"
    "while(lo<hi){\n"
    "uint middle=(lo+hi)/2u;\n"
    "bool later=cohsm_floats(l.triangles_at+3u*middle).w<=u.x;\n"
    "lo=cohsm_if(later,middle+1u,lo);\n"
    "hi=later?hi:middle;\n"
    "}\n"
    "lo*=3u;\n"
    "vec3 v0=cohsm_light_corner(l,lo),v1=cohsm_light_corner(l,lo+1u);\n"
    "vec3 v2=cohsm_light_corner(l,lo+2u);\n"
    "float root=sqrt(u.y),c=root*u.z;\n"
    "vec3 q=v0*(1.-root)+v1*(root*(1.-u.z))+v2*c;\n"
    "e.coords.z=u.z;\n"
    "vec3 n=cohsm_normalize(cross(v1-v0,v2-v0));\n"
    "return cohsm_emit_area(l,a,q,n,u.xy,1./l.area,e);\n"
    "}\n"
    "\n\n\nvoid cohsm_surface_point(const cohsm_light l,vec2 x,out vec3 q,out vec3 n,out float area)\n"
    "{\n"
    "uint width=l.triangle_count&0xffffu,rows=(l.triangle_count>>16)-1u;\n"
    "uint columns=cohsm_if((l.flags&16u)!=0u,width,width-1u);\n"
    "uint i=cohsm_index(x.x,columns),j=cohsm_index(x.y,rows);\n"
    "uint next=cohsm_if(i+1u<width,i+1u,0u),at=j*width;\n"
    "vec2 f=vec2(x.x*float(columns)-float(i),x.y*float(rows)-float(j));\n"
    "vec3 p0=cohsm_light_corner(l,at+i),p1=cohsm_light_corner(l,at+next);\n"
    "vec3 p2=cohsm_light_corner(l,at+width+i),p3=cohsm_light_corner(l,at+width+next);\n"
    "vec3 along=(p1-p0)*(1.-f.y)+(p3-p2)*f.y;\n"
    "vec3 across=(p2-p0)*(1.-f.x)+(p3-p1)*f.x;\n"
    "q=(p0+(p1-p0)*f.x)+across*f.y;\n"
    "n=cross(along*float(columns),across*float(rows));\n"
    "area=sqrt(dot(n,n));\n"
    "}\n"
    "\n\nbool cohsm_shape_draw(const cohsm_light l,const cohsm_aim a,vec3 u,inout cohsm_emission e)\n"
    "{\n"
    "vec2 x=cohsm_pick_coords(l,u.xy);\n"
    "vec3 q,n;\n"
    "float area;\n"
    "e.coords.xy=x;\n"
    "#ifdef COHSM_OWN_LIGHT\n"
    "if(COHSM_SHAPE_OF(l)==COHSM_SHAPE_OWN){\n"
    "e.coords.z=u.z;\n"
    "glbk_light_point(l.own,e.coords,q,n,area);\n"
    "}else cohsm_surface_point(l,x,q,n,area);\n"
    "#else\n"
    "cohsm_surface_point(l,x,q,n,area);\n"
    "#endif\n"
    "if(!cohsm_finite3(q)||!cohsm_finite3(n)||!cohsm_finite(area)||!(area>.0))return false;\n"
    "return cohsm_emit_area(l,a,q,cohsm_normalize(n),x,1./area,e);\n"
    "}\n"
    "\n\n\nbool cohsm_light_draw(const cohsm_light l,const cohsm_aim a,vec3 u,out cohsm_emission e)\n"
    "{\n"
    "e=cohsm_emission(vec3(.0),.0,vec3(.0),vec3(.0),.0);\n"
    "if(COHSM_SHAPE_OF(l)==COHSM_SHAPE_ENVIRONMENT)return cohsm_environment_draw(l,u.xy,e);\n"
    "if(cohsm_light_is_delta(l))return cohsm_delta_draw(l,a,e);\n"
    "if(COHSM_SHAPE_OF(l)==COHSM_SHAPE_SPHERE)return cohsm_sphere_draw(l,a,u.xy,e);\n"
    "if(COHSM_SHAPE_OF(l)==COHSM_SHAPE_MESH)return cohsm_mesh_draw(l,a,u,e);\n"
    "if(COHSM_SHAPE_OF(l)==COHSM_SHAPE_SURFACE||COHSM_SHAPE_OF(l)==COHSM_SHAPE_OWN)\n",
    "return cohsm_shape_draw(l,a,u,e);\n"
    "vec2 x=a.solid_pdf>.0?cohsm_rectangle_pick(a,u.xy):cohsm_pick_coords(l,u.xy);\n"
    "if(COHSM_SHAPE_OF(l)==COHSM_SHAPE_LINE)\n"
    "return cohsm_line_at(l,a,x.x,(2.*u.y-1.)*a.spread,e);\n"
    "vec3 q;\n"
    "if(COHSM_SHAPE_OF(l)==COHSM_SHAPE_DISC){\n"
    "vec2 p=cohsm_concentric(x);\n"
    "q=l.origin+(l.ex*p.x+l.ey*p.y)*l.radius;\n"
    "}else\n"
    "q=l.origin+(l.u*x.x+l.v*x.y);\n"
    "return cohsm_emit_area(l,a,q,l.n,x,1./l.area,e);\n"
    "}\n"
    "\n\nbool cohsm_plane_hit(const cohsm_light l,const cohsm_aim a,vec3 w,inout cohsm_emission e)\n"
    "{\n"
    "vec3 d=a.p-l.origin;\n"
    "float slope=-dot(l.n,w),height=dot(l.n,d);\n"
    "if(!(slope>1e-7)||!(height>.0))return false;\n"
    "d+=w*(height/slope);\n"
    "vec2 x=vec2(dot(d,l.ex),dot(d,l.ey));\n"
    "if(COHSM_SHAPE_OF(l)==COHSM_SHAPE_DISC){\n"
    "x/=l.radius;\n"
    "if(!(x.x*x.x+x.y*x.y<1.))return false;\n"
    "x=cohsm_disc_square(x);\n"
    "}else if(!(x.x>=.0&&x.x<1.&&x.y>=.0&&x.y<1.))\n"
    "return false;\n"
    "return cohsm_emit_area(l,a,l.origin+d,l.n,x,1./l.area,e);\n"
    "}\n"
    "\n\nbool cohsm_round_hit(const cohsm_light l,const cohsm_aim a,vec3 w,inout cohsm_emission e)\n"
    "{\n"
    "bool line=COHSM_SHAPE_OF(l)==COHSM_SHAPE_LINE;\n"
    "vec3 d=cohsm_if(line,a.axis*-a.range,l.origin-a.p),v=cohsm_if(line,w-l.n*dot(w,l.n),w);\n"
    "float square=dot(v,v);\n"
    "if(!(square>1e-14))return false;\n"
    "float along=dot(d,v)/square;\n"
    "vec3 n=v*along-d;\n"
    "float s=l.radius*l.radius-dot(n,n);\n"
    "if(!(along>.0)||!(s>.0))return false;\n"
    "s=sqrt(s/square);\n"
    "n=(n-v*s)*(1./l.radius);\n"
    "if(!line)return cohsm_sphere_at(l,a,cohsm_normalize(n),e);\n"
    "float x=dot((a.p-l.origin)+w*(along-s),l.n)/l.lx;\n"
    "if(!(x>=.0&&x<1.))return false;\n"
    "return cohsm_line_at(l,a,x,dot(n,cross(l.n,a.axis)),e);\n"
    "}\n"
    "\n\n\nbool cohsm_light_hit(const cohsm_light l,const cohsm_aim a,vec3 w,out cohsm_emission e)\n"
    "{\n"
    "e=cohsm_emission(vec3(.0),.0,vec3(.0),vec3(.0),.0);\n"
    "if(COHSM_SHAPE_OF(l)==COHSM_SHAPE_ENVIRONMENT)return cohsm_environment_hit(l,w,e);\n"
    "if(COHSM_SHAPE_OF(l)==COHSM_SHAPE_RECTANGLE||COHSM_SHAPE_OF(l)==COHSM_SHAPE_DISC)\n"
    "return cohsm_plane_hit(l,a,w,e);\n"
    "if(COHSM_SHAPE_OF(l)==COHSM_SHAPE_SPHERE||COHSM_SHAPE_OF(l)==COHSM_SHAPE_LINE)\n"
    "return cohsm_round_hit(l,a,w,e);\n"
    "return false;\n"
    "}\n", 0
};

static const struct { char facts[26];
    char s0[3999]; char s1[3960]; char s2[3655]; char end; } glbk__glsl_lib_cohsm_lookup_glsl GLBK__TIGHT = {
    "lib/cohsm_lookup.glsl\0" "" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\n\n#ifndef COHSM_TEXEL\n"
    "#error \"cohsm_lookup: COHSM_TEXEL(i), texel i of the blocks\"\n"
    "#endif\n"
    "\n\n\n#ifdef COHSM_ONE_DOMAIN\n"
    "#define COHSM_DOMAIN_OF(m) uint(COHSM_ONE_DOMAIN)\n"
    "#else\n"
    "#define COHSM_DOMAIN_OF(m) m.domain\n"
    "#endif\n"
    "#if defined(COHSM_ONE_DOMAIN) && COHSM_ONE_DOMAIN < 8\n"
    "#define COHSM_POSITIONAL(m) (COHSM_ONE_DOMAIN > 2)\n"
    "#else\n"
    "#define COHSM_POSITIONAL(m) m.positional\n"
    "#endif\n"
    "#ifdef COHSM_ONE_ORDER\n"
    "#define COHSM_ORDER_OF(m) uint(COHSM_ONE_ORDER)\n"
    "#else\n"
    "#define COHSM_ORDER_OF(m) m.order\n"
    "#endif\n"
    "#ifdef COHSM_ONE_ORIENTATION\n"
    "#define COHSM_ORIENTATION_OF(m) uint(COHSM_ONE_ORIENTATION)\n"
    "#else\n"
    "#define COHSM_ORIENTATION_OF(m) m.orientation\n"
    "#endif\n"
    "#ifdef COHSM_ONE_LAYOUT\n"
    "#define COHSM_FAST(m) (COHSM_ONE_LAYOUT > 1)\n"
    "#else\n"
    "#define COHSM_FAST(m) m.fast\n"
    "#endif\n"
    "\n#define COHSM_DOMAIN_LATLONG 1u\n"
    "#define COHSM_DOMAIN_OCTAHEDRAL 2u\n"
    "#define COHSM_DOMAIN_DISC 5u\n"
    "#define COHSM_DOMAIN_SPHERE 6u\n"
    "#define COHSM_DOMAIN_TABLE 8u\n"
    "#define COHSM_DOMAIN_LIST 9u\n"
    "#define COHSM_ORDER_ZIGZAG 2u\n"
    "#define COHSM_ORDER_ZIGZAG_THETA 3u\n"
    "#define COHSM_ORDER_HILBERT 4u\n"
    "#define COHSM_ORIENTATION_POLAR 1u\n"
    "#define COHSM_ORIENTATION_MINIMAL 2u\n"
    "\nstruct cohsm_maps{\n"
    "uint base;\n"
    "uint domain;\n"
    "uint order;\n"
    "uint orientation;\n"
    "uvec3 side;\n"
    "uint map_count;\n"
    "uint map_size;\n"
    "uint depth_top;\n"
    "uint depth_step;\n"
    "uint dimensions;\n"
    "bool positional;\n"
    "bool self_only;\n"
    "uint pixel_begin;\n"
    "uint pixel_end;\n"
    "uint order_at;\n"
    "uint locations_at;\n"
    "uint lookup_at;\n"
    "uint directories_at;\n"
    "uint lines_at;\n"
    "bool fast;\n"
    "uint bases_at;\n"
    "uint trays_at;\n"
    "vec3 center;\n"
    "float radius,\n"
    "depth_far;\n"
    "};\n"
    "\n\ncohsm_maps cohsm_unpack(uint base,uvec4 kinds,uvec4 sides,uvec4 sizes,uvec4 range,uvec4 lengths,\n"
    "uvec4 rest,uvec4 sphere)\n"
    "{\n"
    "cohsm_maps m;\n"
    "m.base=base;\n"
    "m.domain=kinds.x;\n"
    "m.order=kinds.z;\n"
    "m.orientation=kinds.w;\n"
    "m.side=sides.xyz;\n"
    "m.map_count=sides.w;\n"
    "m.map_size=sizes.y;\n"
    "m.depth_top=(1u<<sizes.z)-1u;\n"
    "m.depth_step=65535u*65536u/m.depth_top+1u;\n"
    "m.dimensions=sizes.w;\n"
    "m.positional=range.x!=0u;\n"
    "m.self_only=(range.y&1u)!=0u;\n"
    "m.pixel_begin=range.z;\n"
    "m.pixel_end=range.w;\n"
    "m.order_at=96u;\n"
    "m.locations_at=m.order_at+lengths.x;\n"
    "m.lookup_at=m.locations_at+lengths.y;\n"
    "m.directories_at=m.lookup_at+lengths.z;\n"
    "m.fast=(range.y&2u)!=0u;\n"
    "#ifdef COHSM_ONE_LAYOUT\n"
    "m.fast=COHSM_ONE_LAYOUT>1;\n"
    "#endif\n"
    "m.lines_at=cohsm_if(m.fast,(m.lookup_at+15u)&~15u,m.directories_at+lengths.w);\n"
    "m.bases_at=m.lines_at+lengths.z;\n"
    "m.trays_at=m.bases_at+lengths.w;\n"
    "m.center=vec3(uintBitsToFloat(rest.w),uintBitsToFloat(sphere.xy));\n"
    "m.radius=uintBitsToFloat(sphere.z);\n"
    "m.depth_far=uintBitsToFloat(sphere.w);\n"
    "#ifdef COHSM_ONE_DOMAIN\n"
    "m.domain=uint(COHSM_ONE_DOMAIN);\n"
    "#if COHSM_ONE_DOMAIN < 8\n"
    "m.positional=COHSM_ONE_DOMAIN>2;\n"
    "m.dimensions=COHSM_ONE_DOMAIN==3?1u:COHSM_ONE_DOMAIN==7?3u:2u;\n"
    "#endif\n"
    "#endif\n"
    "#ifdef COHSM_ONE_ORDER\n"
    "m.order=uint(COHSM_ONE_ORDER);\n"
    "#endif\n"
    "#ifdef COHSM_ONE_ORIENTATION\n"
    "m.orientation=uint(COHSM_ONE_ORIENTATION);\n"
    "#endif\n"
    "return m;\n"
    "}\n"
    "\n\ncohsm_maps cohsm_open(uint base)\n"
    "{\n"
    "return cohsm_unpack(base,COHSM_TEXEL(base+1u),COHSM_TEXEL(base+2u),COHSM_TEXEL(base+3u),\n"
    "COHSM_TEXEL(base+4u),COHSM_TEXEL(base+5u),COHSM_TEXEL(base+6u),\n"
    "COHSM_TEXEL(base+7u));\n"
    "}\n"
    "\n\nuint cohsm_pick(uvec4 t,uint i)\n"
    "{\n"
    "return cohsm_if((i&2u)!=0u,cohsm_if((i&1u)!=0u,t.w,t.z),cohsm_if((i&1u)!=0u,t.y,t.x));\n"
    "}\n"
    "\n\nuint cohsm_word(const cohsm_maps m,uint i){return cohsm_pick(COHSM_TEXEL(m.base+(i>>2)),i);}\n"
    "\n\nvec3 cohsm_floats(const cohsm_maps m,uint i)\n"
    "{\n"
    "return uintBitsToFloat(uvec3(cohsm_word(m,i),cohsm_word(m,i+1u),cohsm_word(m,i+2u)));\n"
    "}\n"
    "\n\nuint cohsm_popcount(uint x)\n"
    "{\n"
    "#if __VERSION__ >= 400 || (defined(GL_ES) && __VERSION__ >= 310)\n"
    "return uint(bitCount(x));\n"
    "#endif\n"
    "x-=(x>>1)&0x55555555u;\n"
    "x=(x&0x33333333u)+((x>>2)&0x33333333u);\n"
    "x=(x+(x>>4))&0x0f0f0f0fu;\n"
    "return(x*0x01010101u)>>24;\n"
    "}\n"
    "\n\n\nuint cohsm_select(uint x,uint number)\n"
    "{\n"
    "uint two=x-((x>>1)&0x55555555u);\n"
    "uint four=(two&0x33333333u)+((two>>2)&0x33333333u);\n"
    "uint eight=(four+(four>>4))&0x0f0f0f0fu,at=0u,n=(eight+(eight>>8))&0xffu;\n"
    "if(number>=n){number-=n;at=16u;}\n"
    "n=(eight>>at)&15u;\n"
    "if(number>=n){number-=n;at+=8u;}\n"
    "n=(four>>at)&7u;\n"
    "if(number>=n){number-=n;at+=4u;}\n"
    "n=(two>>at)&3u;\n",
    "if(number>=n){number-=n;at+=2u;}\n"
    "n=(x>>at)&1u;\n"
    "return cohsm_if(number>=n,at+1u,at);\n"
    "}\n"
    "\n\nuvec2 cohsm_marks(uint w0,uint w1,uint w2)\n"
    "{\n"
    "return uvec2((w0>>16)|(w1<<16),(w1>>16)|(w2<<16));\n"
    "}\n"
    "\n\nuint cohsm_after_zero(uvec2 marks,uint number)\n"
    "{\n"
    "uvec2 zeros=~marks;\n"
    "uint low=cohsm_popcount(zeros.x);\n"
    "bool second=number>=low;\n"
    "uint at=cohsm_select(cohsm_if(second,zeros.y,zeros.x),cohsm_if(second,number-low,number));\n"
    "return at+cohsm_if(second,33u,1u);\n"
    "}\n"
    "\n\n\n\nuint cohsm_grid_depth(const cohsm_maps m,uint g)\n"
    "{\n"
    "return cohsm_if(g>=m.depth_top,65535u,(g*m.depth_step)>>16);\n"
    "}\n"
    "\n\n\nstruct cohsm_line{\n"
    "uvec4 a,b,c,d;\n"
    "uint bit;\n"
    "};\n"
    "\n\ncohsm_line cohsm_fetch_line(const cohsm_maps m,uint word)\n"
    "{\n"
    "uint i=m.base+(word>>4<<2);\n"
    "return cohsm_line(COHSM_TEXEL(i),COHSM_TEXEL(i+1u),COHSM_TEXEL(i+2u),COHSM_TEXEL(i+3u),\n"
    "(word&15u)<<5);\n"
    "}\n"
    "\n\nuint cohsm_line_word(const cohsm_line l,uint i)\n"
    "{\n"
    "bool odd=(i&4u)!=0u;\n"
    "return cohsm_pick(cohsm_if((i&8u)!=0u,cohsm_if(odd,l.d,l.c),cohsm_if(odd,l.b,l.a)),i);\n"
    "}\n"
    "\n\nuint cohsm_bits(const cohsm_line l,uint bit,uint count)\n"
    "{\n"
    "bit+=l.bit;\n"
    "uint at=bit>>5,shift=bit&31u,x=cohsm_line_word(l,at)>>shift;\n"
    "if(shift+count>32u)x|=cohsm_line_word(l,at+1u)<<(32u-shift);\n"
    "return cohsm_if(count>0u,x&(0xffffffffu>>(32u-count)),0u);\n"
    "}\n"
    "\n\nuint cohsm_segment(const cohsm_line l,uint head,uvec2 marks,uint view)\n"
    "{\n"
    "uint k=(head>>8)&15u,bucket=view>>k,low=view&((1u<<k)-1u);\n"
    "uint at=bucket>0u?cohsm_after_zero(marks,bucket-1u):0u,j=at-bucket;\n"
    "while(at<64u&&((cohsm_if(at<32u,marks.x,marks.y)>>(at&31u))&1u)!=0u&&\n"
    "cohsm_bits(l,80u+j*k,k)<=low){\n"
    "at++;\n"
    "j++;\n"
    "}\n"
    "return j-1u;\n"
    "}\n"
    "\n\n\nuint cohsm_escapes(const cohsm_line l,uint codes,uint bits,uint count)\n"
    "{\n"
    "uint step=32u/bits,one=(0xffffffffu>>(32u-step*bits))/((1u<<bits)-1u);\n"
    "uint high=one<<(bits-1u),rank=0u;\n"
    "for(uint i=0u;i<count;i+=step){\n"
    "uint x=cohsm_bits(l,codes+i*bits,min(step,count-i)*bits);\n"
    "rank+=cohsm_popcount(((x&~high)+one)&x&high);\n"
    "}\n"
    "return rank;\n"
    "}\n"
    "\n\nuint cohsm_segment_depth(const cohsm_maps m,const cohsm_line l,uint head,uvec2 marks,uint j)\n"
    "{\n"
    "uint n=cohsm_popcount(marks.x)+cohsm_popcount(marks.y);\n"
    "uint k=(head>>8)&15u,bits=(head>>12)&15u,base=head&255u,codes=80u+n*k;\n"
    "bool palette=bits>9u;\n"
    "if(palette)bits-=9u;\n"
    "uint code=cohsm_bits(l,codes+j*bits,bits),ones=(1u<<bits)-1u;\n"
    "uint values=codes+n*bits,rank=0u,depth=base+code;\n"
    "bool exact=code==ones,infinite=code+1u==ones&&!palette;\n"
    "if(exact)rank=cohsm_escapes(l,codes,max(bits,1u),min(j,64u));\n"
    "values+=cohsm_if(exact,cohsm_if(palette,8u*base,0u)+16u*rank,8u*code);\n"
    "if(exact||palette)depth=cohsm_bits(l,values,cohsm_if(exact,16u,8u));\n"
    "uint grid=cohsm_grid_depth(m,depth);\n"
    "grid=infinite?65535u:grid;\n"
    "return exact?depth:grid;\n"
    "}\n"
    "\n\nuvec2 cohsm_find_block(const cohsm_maps m,uint list,uint count,uint view)\n"
    "{\n"
    "uint from=2u*list+4u;\n"
    "uint low=from>>3,high=(from+count+6u)>>3;\n"
    "uvec2 found=uvec2(0u);\n"
    "while(low<high){\n"
    "uint middle=(low+high)>>1,i=8u*middle-from;\n"
    "uvec4 t=COHSM_TEXEL(m.base+middle),even=t&0xffffu,odd=t>>16;\n"
    "uvec4 number=i+uvec4(0u,2u,4u,6u),top=uvec4(count-1u),asked=uvec4(view);\n"
    "even=(even+1u)*uvec4(lessThan(number,top))*uvec4(lessThanEqual(even,asked));\n"
    "odd=(odd+1u)*uvec4(lessThan(number+1u,top))*uvec4(lessThanEqual(odd,asked));\n"
    "uvec4 last=max(even,odd),ones=min(even,1u)+min(odd,1u);\n"
    "uint first=max(max(last.x,last.y),max(last.z,last.w));\n"
    "if(first>0u){\n"
    "found=uvec2((8u*middle<from?0u:i)+ones.x+ones.y+ones.z+ones.w,first-1u);\n"
    "low=middle+1u;\n"
    "}else\n"
    "high=middle;\n"
    "}\n"
    "return found;\n"
    "}\n"
    "\n\nuint cohsm_list_depth(const cohsm_maps m,uint list,uint view)\n"
    "{\n"
    "uvec4 t=COHSM_TEXEL(m.base+(list>>2));\n"
    "uint first=cohsm_pick(t,list),count=cohsm_pick(t,list+1u);\n"
    "if((list&3u)==3u)count=COHSM_TEXEL(m.base+(list>>2)+1u).x;\n"
    "uint tail=count>>16;\n"
    "count&=0xffffu;\n"
    "uvec2 block=cohsm_find_block(m,list,count,view);\n"
    "uint line=cohsm_if(block.x+1u<count,16u*(first+block.x),\n"
    "16u*(first-(tail>>4))+(tail&15u));\n"
    "cohsm_line l=cohsm_fetch_line(m,m.lines_at+line);\n"
    "uint at=l.bit>>5,head=cohsm_line_word(l,at);\n"
    "uvec2 marks=cohsm_marks(head,cohsm_line_word(l,at+1u),cohsm_line_word(l,at+2u));\n",
    "return cohsm_segment_depth(m,l,head,marks,cohsm_segment(l,head,marks,view-block.y));\n"
    "}\n"
    "\n\n\n\nuint cohsm_byte(uvec4 t,uint i){return(cohsm_pick(t,i>>2)>>((i&3u)<<3))&255u;}\n"
    "\n\nuint cohsm_half_word(const cohsm_maps m,uint word,uint i)\n"
    "{\n"
    "return(cohsm_word(m,word+(i>>1))>>((i&1u)<<4))&0xffffu;\n"
    "}\n"
    "\n\nuint cohsm_high_bits(uvec4 s,uvec4 t)\n"
    "{\n"
    "s&=0x80808080u;\n"
    "t&=0x80808080u;\n"
    "return(s.x>>7)|(s.y>>6)|(s.z>>5)|(s.w>>4)|(t.x>>3)|(t.y>>2)|(t.z>>1)|t.w;\n"
    "}\n"
    "\n\n\nuint cohsm_bytes_up_to(uvec4 s,uvec4 t,uint v)\n"
    "{\n"
    "uvec4 all=uvec4(v*0x01010101u),least=all|0x80808080u;\n"
    "uvec4 x=least-(s&0x7f7f7f7fu),y=least-(t&0x7f7f7f7fu);\n"
    "return cohsm_high_bits((all&~s)|(~(all^s)&x),(all&~t)|(~(all^t)&y));\n"
    "}\n"
    "\n\nuint cohsm_bytes_exact(uvec4 s,uvec4 t)\n"
    "{\n"
    "s^=0xfefefefeu;\n"
    "t^=0xfefefefeu;\n"
    "uvec4 x=(s&0x7f7f7f7fu)+0x7f7f7f7fu,y=(t&0x7f7f7f7fu)+0x7f7f7f7fu;\n"
    "return cohsm_high_bits(~(x|s),~(y|t));\n"
    "}\n"
    "\n\nuint cohsm_bytes_before(uint count)\n"
    "{\n"
    "count=min(count,32u);\n"
    "uint more=0x01010101u&((1u<<((count&3u)<<3))-1u);\n"
    "return((0x01010101u+more)<<(count>>2))-0x01010101u;\n"
    "}\n"
    "\n\n\nuvec2 cohsm_tray_at(const cohsm_maps m,uint pixel,uint place)\n"
    "{\n"
    "uint pixels=m.pixel_end-m.pixel_begin,bucket=place>>8;\n"
    "uint tray=cohsm_half_word(m,m.trays_at,bucket*pixels+pixel),first=tray&0x3fffu;\n"
    "uint line=cohsm_word(m,m.bases_at+bucket*((pixels+255u)>>8)+(pixel>>8));\n"
    "uint split=tray>>14,part=(place&255u)>>(8u-split);\n"
    "uint byte=cohsm_if(split>0u,(first+part)<<6,first<<1);\n"
    "return uvec2(m.base+(m.lines_at>>2)+(line<<2)+(byte>>4),byte&15u);\n"
    "}\n"
    "\n\n\n\n\nuint cohsm_tray_exact(uint texel,uvec4 a,uvec4 b,uint count,uint codes,uint byte,uint view)\n"
    "{\n"
    "uvec4 c=COHSM_TEXEL(texel+2u),d=COHSM_TEXEL(texel+3u);\n"
    "uint low=cohsm_bytes_exact(a,b)&(cohsm_bytes_before(byte)^cohsm_bytes_before(codes));\n"
    "uint high=cohsm_bytes_exact(c,d);\n"
    "high&=cohsm_bytes_before(max(byte,32u)-32u)^cohsm_bytes_before(max(codes,32u)-32u);\n"
    "uint at=codes+count+1u+2u*(cohsm_popcount(low)+cohsm_popcount(high));\n"
    "at=cohsm_if(count==31u,64u*cohsm_byte(a,1u)+2u*(view&31u),at);\n"
    "return(cohsm_pick(COHSM_TEXEL(texel+(at>>4)),at>>2)>>((at&2u)<<3))&0xffffu;\n"
    "}\n"
    "\n\n\n\nuint cohsm_tray_depth(const cohsm_maps m,uint pixel,uint place)\n"
    "{\n"
    "uvec2 tray=cohsm_tray_at(m,pixel,place);\n"
    "uvec4 a=COHSM_TEXEL(tray.x),b=COHSM_TEXEL(tray.x+1u);\n"
    "uint view=place&255u,count=cohsm_byte(a,tray.y),firsts=tray.y+1u,codes=firsts+count;\n"
    "uint up_to=cohsm_bytes_up_to(a,b,view)&(cohsm_bytes_before(codes)^cohsm_bytes_before(firsts));\n"
    "uint byte=codes+cohsm_popcount(up_to);\n"
    "if(codes>32u){\n"
    "uvec4 c=COHSM_TEXEL(tray.x+2u);\n"
    "byte+=cohsm_popcount(cohsm_bytes_up_to(c,c,view)&cohsm_bytes_before(codes-32u));\n"
    "}\n"
    "uint code=cohsm_byte(COHSM_TEXEL(tray.x+(byte>>4)),byte),depth=cohsm_grid_depth(m,code);\n"
    "if(code==254u)depth=cohsm_tray_exact(tray.x,a,b,count,codes,byte,view);\n"
    "return depth;\n"
    "}\n"
    "\n\n\n\nuint cohsm_listed_depth(const cohsm_maps m,uint pixel,uint place)\n"
    "{\n"
    "uint entry=cohsm_word(m,m.lookup_at+(place>>16)*(m.pixel_end-m.pixel_begin)+pixel);\n"
    "uint depth=entry&0xffffu;\n"
    "if((entry&0x80000000u)==0u)depth=cohsm_list_depth(m,m.directories_at+entry,place&0xffffu);\n"
    "return depth;\n"
    "}\n"
    "\n\n\nuint cohsm_stored_depth(const cohsm_maps m,uint pixel,uint place)\n"
    "{\n"
    "uint depth=0u;\n"
    "if(COHSM_FAST(m))depth=cohsm_tray_depth(m,pixel,place);\n"
    "if(!COHSM_FAST(m))depth=cohsm_listed_depth(m,pixel,place);\n"
    "return depth;\n"
    "}\n"
    "\n\n\nuvec4 cohsm_stored_depths(const cohsm_maps m,uvec4 pixels,uint place)\n"
    "{\n"
    "uvec4 depths=uvec4(0u);\n"
    "if(COHSM_FAST(m))\n"
    "depths=uvec4(cohsm_tray_depth(m,pixels.x,place),cohsm_tray_depth(m,pixels.y,place),\n"
    "cohsm_tray_depth(m,pixels.z,place),cohsm_tray_depth(m,pixels.w,place));\n"
    "if(!COHSM_FAST(m))\n"
    "for(int i=0;i<4;i++){\n"
    "depths=uvec4(depths.yzw,cohsm_listed_depth(m,pixels.x,place));\n"
    "pixels=pixels.yzwx;\n"
    "}\n"
    "return depths;\n"
    "}\n", 0
};

static const struct { char facts[24];
    char s0[3553]; char end; } glbk__csm_files_lib_cohsm_math_glsl GLBK__TIGHT = {
    "lib/cohsm_math.glsl\0" "" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\n#define COHSM_PI 3.14159265\n"
    "#define COHSM_BELOW_1 0.99999994\n"
    "#define COHSM_HUGE 3.402823466e38\n"
    "\n\n\nfloat cohsm_if(bool c,float a,float b){return c?a:b;}\n"
    "vec2 cohsm_if(bool c,vec2 a,vec2 b){return c?a:b;}\n"
    "vec3 cohsm_if(bool c,vec3 a,vec3 b){return c?a:b;}\n"
    "vec4 cohsm_if(bool c,vec4 a,vec4 b){return c?a:b;}\n"
    "int cohsm_if(bool c,int a,int b){return c?a:b;}\n"
    "uint cohsm_if(bool c,uint a,uint b){return c?a:b;}\n"
    "uvec2 cohsm_if(bool c,uvec2 a,uvec2 b){return c?a:b;}\n"
    "uvec4 cohsm_if(bool c,uvec4 a,uvec4 b){return c?a:b;}\n"
    "\nbool cohsm_finite(float x){return(floatBitsToUint(x)&0x7f800000u)!=0x7f800000u;}\n"
    "bool cohsm_finite3(vec3 v){return cohsm_finite(v.x)&&cohsm_finite(v.y)&&cohsm_finite(v.z);}\n"
    "float cohsm_clamp_unit(float u){return cohsm_if(u>.0,min(u,COHSM_BELOW_1),.0);}\n"
    "float cohsm_safe_sqrt(float x){return cohsm_if(x>.0,sqrt(x),.0);}\n"
    "\n\nfloat cohsm_copysign(float x,float s)\n"
    "{\n"
    "return uintBitsToFloat((floatBitsToUint(x)&0x7fffffffu)|(floatBitsToUint(s)&0x80000000u));\n"
    "}\n"
    "\n\nvec2 cohsm_sincos(float x)\n"
    "{\n"
    "float t=clamp(x,-8192.,8192.);\n"
    "int k=int(t*.636619772+(t<.0?-.5:.5));\n"
    "float q=float(k);\n"
    "float r=((t-q*1.5703125)-q*4.837512969970703125e-4)-q*7.5497899548918822e-8;\n"
    "float z=r*r;\n"
    "float s=r+r*z*(-.1666665494+z*(.008332178146+z*-.0001951729898));\n"
    "float c=(1.-.5*z)+z*z*(.04166664687+z*(-.001388736752+z*2.443845159e-5));\n"
    "vec2 v=cohsm_if((k&1)!=0,vec2(c,s),vec2(s,c));\n"
    "return vec2(cohsm_if((k&2)!=0,-v.x,v.x),cohsm_if(((k+1)&2)!=0,-v.y,v.y));\n"
    "}\n"
    "\n\nfloat cohsm_atan2(float y,float x)\n"
    "{\n"
    "float ax=abs(x),ay=abs(y),hi=max(ax,ay),lo=min(ax,ay);\n"
    "float a=cohsm_if(lo==hi&&hi>.0,1.,lo/(hi>.0?hi:1.));\n"
    "bool steep=a>.414213562;\n"
    "float t=cohsm_if(steep,(a-1.)/(a+1.),a),z=t*t;\n"
    "float p=t+t*z*(-.3333295525+z*(.1997792608+z*(-.1387984996+z*.08060308882)));\n"
    "p=cohsm_if(steep,p+.785398163,p);\n"
    "p=cohsm_if(ay>ax,1.57079633-p,p);\n"
    "p=cohsm_if((floatBitsToUint(x)>>31)!=0u,3.14159265-p,p);\n"
    "return cohsm_copysign(p,y);\n"
    "}\n"
    "\n\nfloat cohsm_exp(float x)\n"
    "{\n"
    "float t=clamp(x,-88.,88.);\n"
    "float k=floor(t*1.44269504+.5);\n"
    "float r=(t-k*.693145752)-k*1.42860677e-6;\n"
    "float p=1.+(r+r*r*(.500000008+r*(.166666669+r*(.0416662701+r*(.00833326438+\n"
    "r*.00139460621)))));\n"
    "return cohsm_if(t<-87.,.0,p*uintBitsToFloat(uint(int(k)+127)<<23));\n"
    "}\n"
    "\n\n\nfloat cohsm_log(float x)\n"
    "{\n"
    "uint bits=floatBitsToUint(x);\n"
    "int e=int(bits>>23)-127;\n"
    "float m=uintBitsToFloat((bits&0x007fffffu)|0x3f800000u);\n"
    "if(m>1.41421356){\n"
    "m*=.5;\n"
    "e+=1;\n"
    "}\n"
    "float s=(m-1.)/(m+1.),z=s*s;\n"
    "float p=2.*(s+s*z*(.333333328+z*(.200001676+z*(.142686543+z*.117910756))));\n"
    "return float(e)*.693145752+(p+float(e)*1.42860677e-6);\n"
    "}\n"
    "\n\nfloat cohsm_pow(float x,float y)\n"
    "{\n"
    "if(y==.0)return 1.;\n"
    "if(!(x>1.18e-38))return y>.0?.0:COHSM_HUGE;\n"
    "float t=y*cohsm_log(x);\n"
    "return t>88.?COHSM_HUGE:cohsm_exp(t);\n"
    "}\n"
    "\n\nvec3 cohsm_normalize(vec3 v)\n"
    "{\n"
    "float m=max(max(abs(v.x),abs(v.y)),abs(v.z));\n"
    "if(!(m>.0))return vec3(.0);\n"
    "if(m<1e-30){\n"
    "v*=1e30;\n"
    "m*=1e30;\n"
    "}\n"
    "v/=m;\n"
    "return v/sqrt(dot(v,v));\n"
    "}\n"
    "\n\nvoid cohsm_basis(vec3 n,out vec3 t,out vec3 b)\n"
    "{\n"
    "float s=n.z>=.0?1.:-1.,a=-1./(s+n.z),c=n.x*n.y*a;\n"
    "t=vec3(1.+s*n.x*n.x*a,s*c,-s*n.x);\n"
    "b=vec3(c,s+n.y*n.y*a,-n.y);\n"
    "}\n"
    "\n\nvec2 cohsm_concentric(vec2 uv)\n"
    "{\n"
    "float a=2.*uv.x-1.,b=2.*uv.y-1.,r,phi;\n"
    "if(abs(a)>abs(b)){\n"
    "r=a;\n"
    "phi=.785398163*(b/a);\n"
    "}else{\n"
    "r=b;\n"
    "phi=cohsm_if(b==.0,.0,1.57079633-.785398163*(a/b));\n"
    "}\n"
    "return r*cohsm_sincos(phi).yx;\n"
    "}\n"
    "\n\nvec2 cohsm_disc_square(vec2 p)\n"
    "{\n"
    "float r=sqrt(p.x*p.x+p.y*p.y),a,b;\n"
    "if(abs(p.x)>abs(p.y)){\n"
    "a=p.x>.0?r:-r;\n"
    "b=a*(4./COHSM_PI)*cohsm_atan2(p.y/p.x,1.);\n"
    "}else{\n"
    "b=p.y>.0?r:-r;\n"
    "a=r>.0?b*(4./COHSM_PI)*cohsm_atan2(p.x/p.y,1.):.0;\n"
    "}\n"
    "return vec2(cohsm_clamp_unit(.5*(a+1.)),cohsm_clamp_unit(.5*(b+1.)));\n"
    "}\n", 0
};

static const struct { char facts[34];
    char s0[904]; char end; } glbk__glsl_lib_cohsm_octa_glsl GLBK__TIGHT = {
    "lib/cohsm_octa.glsl\0" "cohsm_math" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\nfloat cohsm_acos(float x)\n"
    "{\n"
    "float a=min(abs(x),1.),h=.5*(1.-a);\n"
    "bool far=a>.5;\n"
    "float s=cohsm_if(far,sqrt(h),a),z=cohsm_if(far,h,a*a);\n"
    "float p=s+s*z*(.1666675393+z*(.07495241769+z*(.04547709903+z*(.02414760004+\n"
    "z*.04221856856))));\n"
    "p=cohsm_if(far,2.*p,1.57079633-p);\n"
    "return cohsm_if(x<.0,3.14159265-p,p);\n"
    "}\n"
    "\n\n\nvec3 cohsm_octa_direction(vec2 uv)\n"
    "{\n"
    "float a=2.*uv.x-1.,b=2.*uv.y-1.,x=abs(a),z=abs(b);\n"
    "float d=1.-(x+z),r=1.-abs(d),f=r*sqrt(2.-r*r);\n"
    "vec2 sc=cohsm_sincos(cohsm_if(r>.0,((z-x)/r+1.)*.785398163,.0));\n"
    "return vec3(cohsm_if(a<.0,-f*sc.y,f*sc.y),cohsm_if(d<.0,r*r-1.,1.-r*r),\n"
    "cohsm_if(b<.0,-f*sc.x,f*sc.x));\n"
    "}\n"
    "\n\nvec2 cohsm_octa_square(vec3 n)\n"
    "{\n"
    "float r=sqrt((n.x*n.x+n.z*n.z)/(1.+abs(n.y)));\n"
    "float b=cohsm_atan2(abs(n.z),abs(n.x))*.636619772*r,a=r-b,t=a;\n"
    "if(n.y<.0){\n"
    "a=1.-b;\n"
    "b=1.-t;\n"
    "}\n"
    "a=clamp(a,.0,1.);\n"
    "b=clamp(b,.0,1.);\n"
    "return .5*vec2(cohsm_if(n.x<.0,1.-a,1.+a),cohsm_if(n.z<.0,1.-b,1.+b));\n"
    "}\n", 0
};

static const struct { char facts[26];
    char s0[1174]; char end; } glbk__glsl_lib_cohsm_random_glsl GLBK__TIGHT = {
    "lib/cohsm_random.glsl\0" "" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\nuint cohsm_hash(uint x)\n"
    "{\n"
    "uint state=x*747796405u+2891336453u;\n"
    "uint word=((state>>((state>>28)+4u))^state)*277803737u;\n"
    "return(word>>22)^word;\n"
    "}\n"
    "\n\nuint cohsm_hash_combine(uint a,uint b){return cohsm_hash(a+0x9e3779b9u*cohsm_hash(b));}\n"
    "\n\nfloat cohsm_to_unit(uint bits){return float(bits>>8)*(1./16777216.);}\n"
    "\n\nfloat cohsm_random(uint seed,uint stream,uint i)\n"
    "{\n"
    "return cohsm_to_unit(cohsm_hash_combine(cohsm_hash_combine(seed,stream),i));\n"
    "}\n"
    "\n\nuint cohsm_reverse_bits(uint x)\n"
    "{\n"
    "x=(x>>16)|(x<<16);\n"
    "x=((x>>8)&0x00ff00ffu)|((x&0x00ff00ffu)<<8);\n"
    "x=((x>>4)&0x0f0f0f0fu)|((x&0x0f0f0f0fu)<<4);\n"
    "x=((x>>2)&0x33333333u)|((x&0x33333333u)<<2);\n"
    "return((x>>1)&0x55555555u)|((x&0x55555555u)<<1);\n"
    "}\n"
    "\n\nuint cohsm_owen(uint x,uint seed)\n"
    "{\n"
    "x=cohsm_reverse_bits(x)+seed;\n"
    "x^=x*0x6c50b47cu;\n"
    "x^=x*0xb82f1e52u;\n"
    "x^=x*0xc7afe638u;\n"
    "x^=x*0x8d22f6e6u;\n"
    "return cohsm_reverse_bits(x);\n"
    "}\n"
    "\n\nvec2 cohsm_sobol2(uint i,uint seed)\n"
    "{\n"
    "uint y=0u,d=0x80000000u;\n"
    "i=cohsm_owen(i,cohsm_hash(seed));\n"
    "uint x=cohsm_reverse_bits(i);\n"
    "for(uint k=i;k!=0u;k>>=1){\n"
    "if((k&1u)!=0u)y^=d;\n"
    "d^=d>>1;\n"
    "}\n"
    "return vec2(cohsm_to_unit(cohsm_owen(x,cohsm_hash_combine(seed,1u))),\n"
    "cohsm_to_unit(cohsm_owen(y,cohsm_hash_combine(seed,2u))));\n"
    "}\n", 0
};

static const struct { char facts[74];
    char s0[3975]; char s1[3997]; char s2[3942];
    char s3[1020]; char end; } glbk__glsl_lib_cohsm_visible_glsl GLBK__TIGHT = {
    "lib/cohsm_visible.glsl\0" "cohsm_math cohsm_octa cohsm_random cohsm_lookup" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\n\n\n\n\n#define COHSM_LIGHT_DIRECTION 0\n"
    "#define COHSM_LIGHT_POSITION 1\n"
    "#define COHSM_LIGHT_PARAMETER 2\n"
    "#define COHSM_LIGHT_INDEX 3\n"
    "#define COHSM_FILTER_NEAREST 0\n"
    "#define COHSM_FILTER_PCF 1\n"
    "#define COHSM_FILTER_ROULETTE 2\n"
    "#ifdef COHSM_ONE_LIGHT\n"
    "#define COHSM_LIGHT_OF(q) COHSM_ONE_LIGHT\n"
    "#else\n"
    "#define COHSM_LIGHT_OF(q) q.light\n"
    "#endif\n"
    "#ifdef COHSM_ONE_FILTER\n"
    "#define COHSM_FILTER_OF(q) COHSM_ONE_FILTER\n"
    "#else\n"
    "#define COHSM_FILTER_OF(q) q.filtering\n"
    "#endif\n"
    "#define COHSM_REFUSED (-1.0)\n"
    "#define COHSM_NO_PIXEL 0xffffffffu\n"
    "\nstruct cohsm_query{\n"
    "int light;\n"
    "int filtering;\n"
    "float bias;\n"
    "uint seed;\n"
    "uint id;\n"
    "};\n"
    "\n\ncohsm_query cohsm_ask(int light,int filtering,float bias)\n"
    "{\n"
    "return cohsm_query(light,filtering,bias,0u,0u);\n"
    "}\n"
    "\n\n\n\nvec3 cohsm_affine(const cohsm_maps m,float s,float t,float r)\n"
    "{\n"
    "vec3 plane=(cohsm_floats(m,33u)+cohsm_floats(m,36u)*s)+cohsm_floats(m,39u)*t;\n"
    "return plane+cohsm_floats(m,42u)*r;\n"
    "}\n"
    "\n\nvec3 cohsm_map_parameter(const cohsm_maps m,vec3 s)\n"
    "{\n"
    "if(COHSM_DOMAIN_OF(m)==COHSM_DOMAIN_OCTAHEDRAL)return cohsm_octa_direction(s.xy);\n"
    "if(COHSM_DOMAIN_OF(m)==COHSM_DOMAIN_LATLONG||COHSM_DOMAIN_OF(m)==COHSM_DOMAIN_SPHERE){\n"
    "vec2 around=cohsm_sincos((s.x-.5)*6.28318531);\n"
    "if(COHSM_DOMAIN_OF(m)==COHSM_DOMAIN_LATLONG){\n"
    "vec2 down=cohsm_sincos(s.y*3.14159265);\n"
    "return vec3(down.x*around.y,down.y,down.x*around.x);\n"
    "}\n"
    "float y=1.-2.*s.y,ring=cohsm_if(y>=1.||y<=-1.,.0,sqrt(1.-y*y));\n"
    "vec3 u=cohsm_floats(m,36u);\n"
    "return cohsm_floats(m,33u)+vec3(ring*around.y,y,ring*around.x)*sqrt(dot(u,u));\n"
    "}\n"
    "if(COHSM_DOMAIN_OF(m)==COHSM_DOMAIN_DISC){\n"
    "vec2 p=cohsm_concentric(s.xy);\n"
    "return cohsm_affine(m,p.x,p.y,.0);\n"
    "}\n"
    "return cohsm_affine(m,s.x,s.y,s.z);\n"
    "}\n"
    "\n\nuint cohsm_cell(const cohsm_maps m,uvec3 c){return c.x+m.side.x*(c.y+m.side.y*c.z);}\n"
    "\n\nuvec3 cohsm_cell_split(const cohsm_maps m,uint cell)\n"
    "{\n"
    "return uvec3(cell%m.side.x,cell/m.side.x%m.side.y,cell/(m.side.x*m.side.y));\n"
    "}\n"
    "\n\nvec3 cohsm_cell_location(const cohsm_maps m,uvec3 c)\n"
    "{\n"
    "if(COHSM_DOMAIN_OF(m)>=COHSM_DOMAIN_TABLE)\n"
    "return cohsm_floats(m,m.locations_at+4u*cohsm_cell(m,c));\n"
    "return cohsm_map_parameter(m,(vec3(c)+.5)/vec3(m.side));\n"
    "}\n"
    "\n\nvoid cohsm_axes(const cohsm_maps m,uvec3 c,out vec3 right,out vec3 up,out vec3 back)\n"
    "{\n"
    "back=cohsm_cell_location(m,c);\n"
    "if(COHSM_ORIENTATION_OF(m)==COHSM_ORIENTATION_POLAR&&COHSM_DOMAIN_OF(m)==COHSM_DOMAIN_LATLONG){\n"
    "vec2 around=cohsm_sincos(((float(c.x)+.5)/float(m.side.x)-.5)*6.28318531);\n"
    "vec2 down=cohsm_sincos((float(c.y)+.5)/float(m.side.y)*3.14159265);\n"
    "right=vec3(-around.x,.0,around.y);\n"
    "up=vec3(-down.y*around.y,down.x,-down.y*around.x);\n"
    "return;\n"
    "}\n"
    "if(COHSM_ORIENTATION_OF(m)==COHSM_ORIENTATION_POLAR){\n"
    "float h=sqrt(back.x*back.x+back.z*back.z);\n"
    "right=cohsm_if(h>1e-6,vec3(-back.z/h,.0,back.x/h),vec3(.0,.0,1.));\n"
    "up=cross(right,back);\n"
    "return;\n"
    "}\n"
    "float s=COHSM_ORIENTATION_OF(m)==COHSM_ORIENTATION_MINIMAL||back.y>=.0?1.:-1.;\n"
    "if(abs(s+back.y)<1e-6){\n"
    "right=vec3(1.,.0,.0);\n"
    "up=vec3(.0,.0,1.);\n"
    "return;\n"
    "}\n"
    "float a=-1./(s+back.y);\n"
    "right=vec3(1.+s*back.x*back.x*a,-s*back.x,s*back.x*back.z*a);\n"
    "up=vec3(back.x*back.z*a,-back.z,s+back.z*back.z*a);\n"
    "}\n"
    "\n\nvec3 cohsm_used(const cohsm_maps m,vec3 v,float rest)\n"
    "{\n"
    "return vec3(cohsm_if(m.dimensions>0u,v.x,rest),\n"
    "cohsm_if(m.dimensions>1u,v.y,rest),\n"
    "cohsm_if(m.dimensions>2u,v.z,rest));\n"
    "}\n"
    "\n\nvec3 cohsm_domain_position(const cohsm_maps m,vec3 light,int kind)\n"
    "{\n"
    "vec3 u=light,top=vec3(m.side);\n"
    "if(kind==COHSM_LIGHT_DIRECTION||kind==COHSM_LIGHT_POSITION){\n"
    "if(COHSM_DOMAIN_OF(m)==COHSM_DOMAIN_LATLONG){\n"
    "u.x=.5+cohsm_atan2(light.z,light.x)*.159154943;\n"
    "u.y=cohsm_acos(light.y/sqrt(dot(light,light)))*.318309886;\n"
    "}else\n"
    "u.xy=cohsm_octa_square(cohsm_normalize(light));\n"
    "}\n"
    "u=clamp(u*top,vec3(.0),top);\n"
    "return cohsm_used(m,u,.0)-.5;\n"
    "}\n"
    "\n\n\nuvec3 cohsm_wrap(const cohsm_maps m,ivec3 c)\n"
    "{\n"
    "ivec3 n=ivec3(m.side);\n"
    "if(COHSM_DOMAIN_OF(m)==COHSM_DOMAIN_LATLONG||COHSM_DOMAIN_OF(m)==COHSM_DOMAIN_SPHERE){\n"
    "if(c.y<0||c.y>=n.y)c.x+=n.x/2;\n"
    "if(c.x<0)c.x+=n.x;\n"
    "if(c.x>=n.x)c.x-=n.x;\n"
    "if(c.x>=n.x)c.x-=n.x;\n"
    "}else if(COHSM_DOMAIN_OF(m)==COHSM_DOMAIN_OCTAHEDRAL){\n"
    "if(c.x<0||c.x>=n.x)c.y=n.y-1-c.y;\n",
    "else if(c.y<0||c.y>=n.y)c.x=n.x-1-c.x;\n"
    "}\n"
    "return uvec3(clamp(c,ivec3(0),n-1));\n"
    "}\n"
    "\n\nuint cohsm_place(const cohsm_maps m,uvec3 c)\n"
    "{\n"
    "bool theta=COHSM_ORDER_OF(m)==COHSM_ORDER_ZIGZAG_THETA;\n"
    "bool zigzag=theta||COHSM_ORDER_OF(m)==COHSM_ORDER_ZIGZAG;\n"
    "uvec2 n=cohsm_if(theta,m.side.yx,m.side.xy),p=cohsm_if(theta,c.yx,c.xy);\n"
    "uint line=cohsm_if((c.z&1u)!=0u,n.y-1u-p.y,p.y)+n.y*c.z;\n"
    "uint along=line*n.x+cohsm_if((line&1u)!=0u,n.x-1u-p.x,p.x),cell=cohsm_cell(m,c);\n"
    "uint place=zigzag?along:cell;\n"
    "if(COHSM_ORDER_OF(m)==COHSM_ORDER_HILBERT){\n"
    "bool halves=m.map_count<=65536u;\n"
    "uint word=cohsm_word(m,m.order_at+cohsm_if(halves,cell>>1,cell));\n"
    "place=cohsm_if(halves,(word>>(16u*(cell&1u)))&0xffffu,word);\n"
    "}\n"
    "return place;\n"
    "}\n"
    "\n\n\n\n\nvec3 cohsm_face_coordinates(vec3 q,out uint face)\n"
    "{\n"
    "vec3 a=abs(q);\n"
    "bool x=a.x>=max(a.y,a.z),y=a.y>=a.z;\n"
    "vec3 f=cohsm_if(x,q,cohsm_if(y,q.yzx,q.zxy));\n"
    "face=cohsm_if(x,0u,cohsm_if(y,2u,4u))+uint(f.x<.0);\n"
    "return vec3(abs(f.x),f.yz);\n"
    "}\n"
    "\n\n\nvec3 cohsm_see(const cohsm_maps m,uvec3 c,vec3 p,float bias,out uint face)\n"
    "{\n"
    "float size=float(m.map_size),middle=.5*size;\n"
    "face=0u;\n"
    "if(!COHSM_POSITIONAL(m)){\n"
    "vec3 right,up,back;\n"
    "cohsm_axes(m,c,right,up,back);\n"
    "return vec3(dot(p,right)*middle+middle,dot(p,up)*middle+middle,\n"
    "(.5-.5*dot(p,back)-bias/size)*65533.);\n"
    "}\n"
    "vec3 q=p-(cohsm_cell_location(m,c)-m.center)*(1./m.radius);\n"
    "vec3 f=cohsm_face_coordinates(q,face);\n"
    "float depth=f.x*(1.-2.*bias/size)*(m.radius/m.depth_far)*65533.;\n"
    "return vec3(f.yz/f.x*middle+middle,depth);\n"
    "}\n"
    "\n\nint cohsm_compared_depth(float depth)\n"
    "{\n"
    "int whole=cohsm_if(depth<65535.,int(depth),65535);\n"
    "return depth>=.0?whole:-1;\n"
    "}\n"
    "\n\nuint cohsm_pixel(const cohsm_maps m,vec2 at)\n"
    "{\n"
    "float top=float(m.map_size);\n"
    "if(COHSM_POSITIONAL(m)){\n"
    "at.x=cohsm_if(at.x<.0,.0,cohsm_if(at.x>=top,top-.5,at.x));\n"
    "at.y=cohsm_if(at.y<.0,.0,cohsm_if(at.y>=top,top-.5,at.y));\n"
    "}\n"
    "uint p=uint(at.y)*m.map_size+uint(at.x),pixel=p-m.pixel_begin;\n"
    "bvec4 there=bvec4(at.x>=.0,at.x<top,at.y>=.0,at.y<top);\n"
    "bool kept=all(bvec3(all(there),p>=m.pixel_begin,p<m.pixel_end));\n"
    "return kept?pixel:COHSM_NO_PIXEL;\n"
    "}\n"
    "\n\n\n\nfloat cohsm_pcf_map(const cohsm_maps m,uvec3 c,vec3 p,float bias)\n"
    "{\n"
    "uint face;\n"
    "vec3 seen=cohsm_see(m,c,p,bias,face);\n"
    "if(!(abs(seen.x)<1e6&&abs(seen.y)<1e6))return .0;\n"
    "uint place=cohsm_place(m,c)+face*m.map_count;\n"
    "int depth=cohsm_compared_depth(seen.z);\n"
    "if(depth<0)return .0;\n"
    "vec2 low=floor(seen.xy-.5),f=seen.xy-.5-low,g=1.-f,at=low+.5;\n"
    "uvec4 pixels=uvec4(cohsm_pixel(m,at),cohsm_pixel(m,at+vec2(1.,.0)),\n"
    "cohsm_pixel(m,at+vec2(.0,1.)),cohsm_pixel(m,at+1.));\n"
    "bvec4 beside=equal(pixels,uvec4(COHSM_NO_PIXEL));\n"
    "uvec4 stored=cohsm_stored_depths(m,pixels*uvec4(not(beside)),place)|(65535u*uvec4(beside));\n"
    "vec4 dark=vec4(greaterThan(ivec4(depth),ivec4(stored)));\n"
    "return((g.x*g.y*dark.x+f.x*g.y*dark.y)+g.x*f.y*dark.z)+f.x*f.y*dark.w;\n"
    "}\n"
    "\n\nfloat cohsm_pcf(const cohsm_maps m,vec3 at,vec3 p,float bias)\n"
    "{\n"
    "int corners=1<<int(m.dimensions);\n"
    "vec3 low=floor(at),f=at-low;\n"
    "float dark=.0;\n"
    "for(int i=0;i<corners;i++){\n"
    "ivec3 step=ivec3(i&1,(i>>1)&1,i>>2);\n"
    "float weight=cohsm_if(step.x!=0,f.x,1.-f.x);\n"
    "ivec3 c=ivec3(low)+step;\n"
    "if(m.dimensions>1u)weight*=cohsm_if(step.y!=0,f.y,1.-f.y);\n"
    "else c.y=0;\n"
    "if(m.dimensions>2u)weight*=cohsm_if(step.z!=0,f.z,1.-f.z);\n"
    "else c.z=0;\n"
    "if(weight>.0)dark+=weight*cohsm_pcf_map(m,cohsm_wrap(m,c),p,bias);\n"
    "}\n"
    "return dark;\n"
    "}\n"
    "\n\n\n\nvec3 cohsm_dop_axis(int i)\n"
    "{\n"
    "if(i<3)return vec3(i==0,i==1,i==2);\n"
    "if(i<9){\n"
    "float s=(i&1)!=0?1.:-1.;\n"
    "return cohsm_if(i<5,vec3(1.,s,.0),cohsm_if(i<7,vec3(1.,.0,s),vec3(.0,1.,s)));\n"
    "}\n"
    "return vec3(i==12?-1.:1.,i==11?-1.:1.,i==10?-1.:1.);\n"
    "}\n"
    "\n\nvec2 cohsm_dop(const cohsm_maps m,int i,vec3 axis)\n"
    "{\n"
    "uint at=45u+2u*uint(i);\n"
    "uvec2 extent=uvec2(cohsm_word(m,at),cohsm_word(m,at+1u));\n"
    "return(uintBitsToFloat(extent)-dot(axis,m.center))/m.radius;\n"
    "}\n"
    "\n\n\nint cohsm_hull(const cohsm_maps m,vec3 p,vec3 light)\n"
    "{\n"
    "float enter=.0,leave=1.;\n"
    "bool inside=true,between=true;\n"
    "for(int i=0;i<13;i++){\n"
    "vec3 a=cohsm_dop_axis(i);\n"
    "vec2 extent=cohsm_dop(m,i,a);\n"
    "float to=dot(a,light),from=dot(a,p),step=to-from;\n"
    "inside=inside&&to>=extent.x&&to<=extent.y;\n",
    "if(step==.0){\n"
    "between=between&&from>=extent.x&&from<=extent.y;\n"
    "continue;\n"
    "}\n"
    "vec2 t=(extent-from)/step;\n"
    "enter=max(enter,min(t.x,t.y));\n"
    "leave=min(leave,max(t.x,t.y));\n"
    "}\n"
    "return cohsm_if(inside,2,between&&enter<=leave?1:0);\n"
    "}\n"
    "\n\n\n\nbool cohsm_usable(vec3 light)\n"
    "{\n"
    "float square=dot(light,light);\n"
    "return square>.0&&square<COHSM_HUGE;\n"
    "}\n"
    "\n\nfloat cohsm_jitter(const cohsm_query q,uint dimension)\n"
    "{\n"
    "return COHSM_FILTER_OF(q)==COHSM_FILTER_ROULETTE?cohsm_random(q.seed,q.id,dimension):.5;\n"
    "}\n"
    "\n\n\nfloat cohsm_visible_unit(const cohsm_maps m,const cohsm_query q,vec3 p,vec3 light)\n"
    "{\n"
    "if(COHSM_LIGHT_OF(q)==COHSM_LIGHT_PARAMETER)\n"
    "light=vec3(light.x,cohsm_used(m,light,.0).yz);\n"
    "if(COHSM_LIGHT_OF(q)!=COHSM_LIGHT_INDEX&&!cohsm_finite3(light))return 1.;\n"
    "if(COHSM_LIGHT_OF(q)==COHSM_LIGHT_POSITION){\n"
    "int hull=cohsm_hull(m,p,light);\n"
    "if(hull!=1)return hull==2?COHSM_REFUSED:1.;\n"
    "light-=p;\n"
    "}\n"
    "if(!cohsm_finite3(p))return 1.;\n"
    "if(COHSM_LIGHT_OF(q)<COHSM_LIGHT_PARAMETER&&!cohsm_usable(light))return 1.;\n"
    "vec3 at=COHSM_LIGHT_OF(q)==COHSM_LIGHT_INDEX?vec3(.0)\n"
    ":cohsm_domain_position(m,light,COHSM_LIGHT_OF(q));\n"
    "uvec3 c;\n"
    "if(COHSM_LIGHT_OF(q)==COHSM_LIGHT_INDEX){\n"
    "if(floatBitsToUint(light.x)>=m.map_count)return 1.;\n"
    "c=cohsm_cell_split(m,floatBitsToUint(light.x));\n"
    "}else{\n"
    "vec3 jitter=cohsm_used(m,vec3(cohsm_jitter(q,0u),cohsm_jitter(q,1u),cohsm_jitter(q,2u)),.5);\n"
    "c=cohsm_wrap(m,ivec3(floor(at+jitter)));\n"
    "}\n"
    "if(COHSM_FILTER_OF(q)==COHSM_FILTER_PCF){\n"
    "float dark=COHSM_LIGHT_OF(q)==COHSM_LIGHT_INDEX?cohsm_pcf_map(m,c,p,q.bias)\n"
    ":cohsm_pcf(m,at,p,q.bias);\n"
    "return cohsm_if(dark>=.999999,.0,1.-dark);\n"
    "}\n"
    "uint face;\n"
    "vec3 seen=cohsm_see(m,c,p,q.bias,face);\n"
    "if(COHSM_FILTER_OF(q)==COHSM_FILTER_ROULETTE)\n"
    "seen.xy+=vec2(cohsm_jitter(q,3u)-.5,cohsm_jitter(q,4u)-.5);\n"
    "int depth=cohsm_compared_depth(seen.z);\n"
    "uint pixel=depth<0?COHSM_NO_PIXEL:cohsm_pixel(m,seen.xy);\n"
    "if(pixel==COHSM_NO_PIXEL)return 1.;\n"
    "return depth>int(cohsm_stored_depth(m,pixel,cohsm_place(m,c)+face*m.map_count))?.0:1.;\n"
    "}\n"
    "\n\nfloat cohsm_visible(const cohsm_maps m,const cohsm_query q,vec3 point,vec3 light)\n"
    "{\n"
    "float scale=1./m.radius;\n"
    "if(COHSM_LIGHT_OF(q)==COHSM_LIGHT_POSITION)light=(light-m.center)*scale;\n"
    "return cohsm_visible_unit(m,q,(point-m.center)*scale,light);\n"
    "}\n"
    "\n\n\n\n\n\n\n\n#ifndef COHSM_INSTANCE\n"
    "#define COHSM_INSTANCE(table, i, k) COHSM_TEXEL((table) + 5u * (i) + (k))\n"
    "#endif\n"
    "\n\n\n\n\nbool cohsm_misses(vec4 sphere,vec2 cone,const cohsm_query q,vec3 point,vec3 light)\n"
    "{\n"
    "vec3 p=point-sphere.xyz;\n"
    "float reach=sphere.w,slope=.0,size,along,t,wide;\n"
    "bool segment=COHSM_LIGHT_OF(q)==COHSM_LIGHT_POSITION;\n"
    "if(segment)light-=point;\n"
    "else{\n"
    "slope=cone.x*cohsm_if(COHSM_FILTER_OF(q)==COHSM_FILTER_NEAREST,.5,1.)+2e-3;\n"
    "if(slope>=1.)return false;\n"
    "slope*=1.+.558*slope*slope;\n"
    "reach=cone.y;\n"
    "}\n"
    "reach+=1e-5*dot(abs(point),vec3(1.));\n"
    "size=dot(light,light);\n"
    "along=-dot(p,light)*inversesqrt(size);\n"
    "t=cohsm_if(segment,min(along,sqrt(size)),along);\n"
    "wide=reach*(1.+.5*slope*slope)+along*slope;\n"
    "return along<-reach||.999997*dot(p,p)+t*(t-2.*along)>wide*wide;\n"
    "}\n"
    "\n\ncohsm_maps cohsm_instance_maps(uint table,uint i)\n"
    "{\n"
    "uint base=COHSM_INSTANCE(table,i,3u).x;\n"
    "#ifdef COHSM_HEADER\n"
    "return cohsm_unpack(base,COHSM_HEADER(i,1u),COHSM_HEADER(i,2u),COHSM_HEADER(i,3u),\n"
    "COHSM_HEADER(i,4u),COHSM_HEADER(i,5u),COHSM_HEADER(i,6u),COHSM_HEADER(i,7u));\n"
    "#else\n"
    "return cohsm_open(base);\n"
    "#endif\n"
    "}\n"
    "\n\nfloat cohsm_visible_instance(uint table,uint i,cohsm_query q,vec3 point,vec3 light)\n"
    "{\n"
    "vec4 x=uintBitsToFloat(COHSM_INSTANCE(table,i,0u)),y=uintBitsToFloat(COHSM_INSTANCE(table,i,1u));\n"
    "vec4 z=uintBitsToFloat(COHSM_INSTANCE(table,i,2u));\n"
    "cohsm_maps m=cohsm_instance_maps(table,i);\n"
    "float scale=1./m.radius;\n"
    "point=vec3(dot(x.xyz,point)+x.w,dot(y.xyz,point)+y.w,dot(z.xyz,point)+z.w);\n"
    "if(COHSM_LIGHT_OF(q)<COHSM_LIGHT_PARAMETER){\n"
    "light=vec3(dot(x.xyz,light),dot(y.xyz,light),dot(z.xyz,light));\n"
    "if(COHSM_LIGHT_OF(q)==COHSM_LIGHT_POSITION)\n"
    "light=(light+vec3(x.w,y.w,z.w)-m.center)*scale;\n"
    "}\n"
    "q.seed+=0x9e3779b9u*i;\n"
    "return cohsm_visible_unit(m,q,(point-m.center)*scale,light);\n"
    "}\n",
    "\n\nfloat cohsm_instance_note(uint table,uint i){return uintBitsToFloat(COHSM_INSTANCE(table,i,3u).y);}\n"
    "\n\nbool cohsm_misses_instance(uint table,uint i,const cohsm_query q,vec3 point,vec3 light)\n"
    "{\n"
    "if(COHSM_LIGHT_OF(q)>=COHSM_LIGHT_PARAMETER)return false;\n"
    "vec4 sphere=uintBitsToFloat(COHSM_INSTANCE(table,i,4u));\n"
    "vec2 cone=vec2(.0);\n"
    "if(COHSM_LIGHT_OF(q)==COHSM_LIGHT_DIRECTION)cone=uintBitsToFloat(COHSM_INSTANCE(table,i,3u).zw);\n"
    "return cohsm_misses(sphere,cone,q,point,light);\n"
    "}\n"
    "\n\n\n\n\nfloat cohsm_visible_scene(uint table,uint count,uint entity,const cohsm_query q,vec3 point,vec3 light)\n"
    "{\n"
    "float visible=1.;\n"
    "uint self=entity-1u;\n"
    "uint i=0u,instance=0u;\n"
    "while(visible>.0){\n"
    "for(;i<count;i++){\n"
    "instance=cohsm_if(self>=count||i>self,i,cohsm_if(i==0u,self,i-1u));\n"
    "#ifdef COHSM_ONE_INSTANCE\n"
    "break;\n"
    "#endif\n"
    "if(!cohsm_misses_instance(table,instance,q,point,light))break;\n"
    "}\n"
    "if(i>=count)break;\n"
    "float one=cohsm_visible_instance(table,instance,q,point,light);\n"
    "visible=cohsm_if(one<.0,COHSM_REFUSED,visible*one);\n"
    "i++;\n"
    "}\n"
    "return visible;\n"
    "}\n", 0
};

static const struct { char facts[42];
    char s0[419]; char end; } glbk__glsl_lib_csm_access_glsl GLBK__TIGHT = {
    "lib/csm_access.glsl\0" "table csm_bindings" "\0" "" "\0"
    "" "\0" "",
    "\n\n#define COHSM_TEXEL(i) texelFetch(glbk_csm_blocks, glbk_table_at(i), 0)\n"
    "#define COHSM_LIGHT_TEXEL(i) texelFetch(glbk_csm_lights, glbk_table_at(i), 0)\n"
    "#define COHSM_LOBE(i) COHSM_LIGHT_TEXEL(i)\n"
    "#ifndef COHSM_LOBES\n"
    "#define COHSM_LOBES 1\n"
    "#endif\n"
    "\n#ifdef CSM_ASK\n"
    "#define COHSM_ONE_LIGHT CSM_ASK\n"
    "#endif\n"
    "#ifdef CSM_FILTER\n"
    "#define COHSM_ONE_FILTER CSM_FILTER\n"
    "#endif\n"
    "#ifdef CSM_SHAPE\n"
    "#define COHSM_ONE_SHAPE CSM_SHAPE\n"
    "#endif\n", 0
};

static const struct { char facts[26];
    char s0[646]; char end; } glbk__glsl_lib_csm_bindings_glsl GLBK__TIGHT = {
    "lib/csm_bindings.glsl\0" "" "\0" "" "\0"
    "" "\0" "",
    "\nuniform usampler2DArray glbk_csm_blocks,glbk_csm_lights,glbk_csm_instances,\n"
    "glbk_csm_questions;\n"
    "uniform usampler2D glbk_csm_place,glbk_csm_normal;\n"
    "uniform glbk_color_sampler glbk_csm_sum;\n"
    "uniform usampler2D glbk_csm_layer0,glbk_csm_layer1,glbk_csm_layer2,glbk_csm_opened;\n"
    "#if __VERSION__ >= 430\n"
    "layout(std430,binding=1)readonly buffer glbk_csm_asked_storage{uvec4 glbk_csm_asked[];};\n"
    "layout(std430,binding=2)writeonly buffer glbk_csm_answers_storage{float glbk_csm_answers[];};\n"
    "layout(std430,binding=3)restrict buffer glbk_csm_records_storage{uvec4 glbk_csm_records[];};\n"
    "layout(rgba32f,binding=0)restrict uniform image2D glbk_csm_total;\n"
    "#endif\n", 0
};

static const struct { char facts[47];
    char s0[2482]; char end; } glbk__glsl_lib_csm_compress_glsl GLBK__TIGHT = {
    "lib/csm_compress.glsl\0" "csm_bindings csm_peel" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\nstruct csm_open{\n"
    "uint lo,\n"
    "hi;\n"
    "bool fresh;\n"
    "uint next;\n"
    "};\n"
    "\n\n\nstruct csm_ended{\n"
    "uint count;\n"
    "uvec4 records[3];\n"
    "};\n"
    "\n\nvoid csm_end(inout csm_ended ended,uint record)\n"
    "{\n"
    "uint i=ended.count&3u;\n"
    "uvec4 r=record*uvec4(equal(uvec4(i),uvec4(0u,1u,2u,3u)));\n"
    "if(ended.count<4u)ended.records[0]+=r;\n"
    "else if(ended.count<8u)ended.records[1]+=r;\n"
    "else ended.records[2]+=r;\n"
    "ended.count++;\n"
    "}\n"
    "\n\nuint csm_depth16(uint bits)\n"
    "{\n"
    "float z=uintBitsToFloat(bits);\n"
    "return z<=1.?uint(clamp(z*65533.,.0,65533.)):65535u;\n"
    "}\n"
    "\n\nuint csm_leave(ivec2 pixel,uint view)\n"
    "{\n"
    "vec2 p=(vec2(pixel)+.5)/float(glbk_csm_peel.side)*2.-1.;\n"
    "if(glbk_csm_peel.positional==0u){\n"
    "float square=1.-p.x*p.x-p.y*p.y;\n"
    "return csm_depth16(floatBitsToUint(.5+.5*sqrt(square>.0?square:.0)));\n"
    "}\n"
    "vec4 e=glbk_csm_peel.eyes[view];\n"
    "float a=p.x*p.x+p.y*p.y+1.,b=e.x*p.x+e.y*p.y+e.z;\n"
    "float c=e.x*e.x+e.y*e.y+e.z*e.z-1.,disc=b*b-a*c;\n"
    "if(!(disc>.0))return 0u;\n"
    "return csm_depth16(floatBitsToUint(clamp((sqrt(disc)-b)/a*e.w,.0,1.)));\n"
    "}\n"
    "\n\nuvec2 csm_interval(ivec2 at,ivec2 pixel,uint view)\n"
    "{\n"
    "uint z1=csm_depth16(texelFetch(glbk_csm_layer0,at,0).x),upper;\n"
    "if(z1==65535u)return uvec2(glbk_csm_peel.self_only!=0u?0u:65535u,65535u);\n"
    "if(glbk_csm_peel.far_layer!=0u){\n"
    "upper=csm_depth16(texelFetch(glbk_csm_layer2,at,0).x);\n"
    "if(upper==65535u&&glbk_csm_peel.sphere==0u)return uvec2(z1,65535u);\n"
    "if(upper==65535u){\n"
    "upper=csm_depth16(texelFetch(glbk_csm_layer1,at,0).x);\n"
    "upper=max(csm_leave(pixel,view),upper==65535u?z1:upper)+1u;\n"
    "}\n"
    "}else{\n"
    "upper=csm_depth16(texelFetch(glbk_csm_layer1,at,0).x);\n"
    "float thickness=glbk_csm_peel.open_thickness;\n"
    "if(glbk_csm_peel.positional!=0u)thickness*=float(z1);\n"
    "if(upper==65535u)upper=z1+1u+uint(thickness);\n"
    "}\n"
    "return uvec2(z1,upper>z1?min(upper-1u,65534u):z1);\n"
    "}\n"
    "\n\ncsm_ended csm_compress(ivec2 pixel,inout csm_open o)\n"
    "{\n"
    "uint side=glbk_csm_peel.side,across=glbk_csm_peel.tiles_across,top=glbk_csm_peel.depth_top;\n"
    "csm_ended ended=csm_ended(0u,uvec4[3](uvec4(0u),uvec4(0u),uvec4(0u)));\n"
    "for(;o.next<glbk_csm_peel.view_count&&ended.count<11u;o.next++){\n"
    "uvec2 z=csm_interval(pixel+ivec2(uvec2(o.next%across,o.next/across)*side),pixel,o.next);\n"
    "uint lo=(z.x*top+65534u)/65535u,hi=((z.y+1u)*top-1u)/65535u;\n"
    "uint both_lo=max(o.lo,lo),both_hi=min(o.hi,hi);\n"
    "bool fresh=false;\n"
    "if(both_lo>both_hi){\n"
    "if(!o.fresh)csm_end(ended,o.lo|(o.hi<<8)|(o.next<<17));\n"
    "both_lo=lo;\n"
    "both_hi=hi;\n"
    "if(lo>hi){\n"
    "csm_end(ended,((z.x+z.y)/2u)|(1u<<16)|((o.next+1u)<<17));\n"
    "both_lo=0u;\n"
    "both_hi=top;\n"
    "fresh=true;\n"
    "}\n"
    "}\n"
    "o.lo=both_lo;\n"
    "o.hi=both_hi;\n"
    "o.fresh=fresh;\n"
    "}\n"
    "return ended;\n"
    "}\n", 0
};

static const struct { char facts[37];
    char s0[251]; char end; } glbk__glsl_lib_csm_frame_glsl GLBK__TIGHT = {
    "lib/csm_frame.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_csm_frame",
    "\nlayout(std140)uniform glbk_csm_frame_block{\n"
    "uint light_texel,pattern_texel,sample_count,sampling,seed,roulette_seed,frame,\n"
    "first,end,plane_count,width,height;\n"
    "float bias,offset;\n"
    "uint adds;\n"
    "float frame_share;\n"
    "vec4 eye,own,planes[8];\n"
    "}glbk_csm_frame;\n", 0
};

static const struct { char facts[47];
    char s0[498]; char end; } glbk__glsl_lib_csm_instances_glsl GLBK__TIGHT = {
    "lib/csm_instances.glsl\0" "csm_access csm_scene" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n#ifdef CSM_INSTANCES\n"
    "#define COHSM_INSTANCE(table, i, k) glbk_csm_scene.instances[12u * min(i, uint(CSM_INSTANCES) - 1u) + k]\n"
    "#define COHSM_HEADER(i, k) COHSM_INSTANCE(0u, i, 4u + k)\n"
    "#if CSM_INSTANCES == 1\n"
    "#define COHSM_ONE_INSTANCE\n"
    "#endif\n"
    "#else\n"
    "\nuvec4 csm_instance(uint i,uint k)\n"
    "{\n"
    "if(glbk_csm_scene.in_block!=0u)return glbk_csm_scene.instances[12u*min(i,15u)+k];\n"
    "return texelFetch(glbk_csm_instances,glbk_table_at(5u*i+k),0);\n"
    "}\n"
    "#define COHSM_INSTANCE(table, i, k) csm_instance(i, k)\n"
    "#endif\n", 0
};

static const struct { char facts[56];
    char s0[265]; char end; } glbk__glsl_lib_csm_pattern_glsl GLBK__TIGHT = {
    "lib/csm_pattern.glsl\0" "csm_access cohsm_math csm_frame" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n#ifdef CSM_PATTERNS\n"
    "\nvec2 csm_pattern(uint at)\n"
    "{\n"
    "uvec4 t=COHSM_LIGHT_TEXEL(glbk_csm_frame.pattern_texel+(at>>1));\n"
    "return uintBitsToFloat(cohsm_if((at&1u)!=0u,t.zw,t.xy));\n"
    "}\n"
    "#define COHSM_PATTERN(j, k) csm_pattern((j) * glbk_csm_frame.sample_count + (k))\n"
    "#endif\n", 0
};

static const struct { char facts[35];
    char s0[225]; char end; } glbk__glsl_lib_csm_peel_glsl GLBK__TIGHT = {
    "lib/csm_peel.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_csm_peel",
    "\nlayout(std140)uniform glbk_csm_peel_block{\n"
    "mat4 view;\n"
    "float clip_per_pixel,depth_scale,open_thickness;\n"
    "uint depth_top,side,tiles_across,view_count,far_layer,positional,self_only,\n"
    "sphere,pad0;\n"
    "vec4 eyes[64];\n"
    "}glbk_csm_peel;\n", 0
};

static const struct { char facts[37];
    char s0[116]; char end; } glbk__glsl_lib_csm_scene_glsl GLBK__TIGHT = {
    "lib/csm_scene.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_csm_scene",
    "\nlayout(std140)uniform glbk_csm_scene_block{\n"
    "uint count,in_block,pad0,pad1;\n"
    "uvec4 instances[192];\n"
    "}glbk_csm_scene;\n", 0
};

static const struct { char facts[85];
    char s0[2281]; char end; } glbk__glsl_lib_csm_shade_glsl GLBK__TIGHT = {
    "lib/csm_shade.glsl\0" "csm_pattern csm_instances cohsm_visible cohsm_estimate gbuffer" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\n#if !defined(CSM_SHAPE) || !defined(CSM_ASK) || !defined(CSM_FILTER)\n"
    "#error \"csm_shade: CSM_SHAPE, CSM_ASK, CSM_FILTER\"\n"
    "#endif\n"
    "\n\n\nbool csm_behind(glbk_point p,vec3 direction,float range)\n"
    "{\n"
    "for(uint i=0u;i<glbk_csm_frame.plane_count;i++){\n"
    "vec4 plane=glbk_csm_frame.planes[i];\n"
    "float height=dot(plane.xyz,p.position)-plane.w,end=height+range*dot(plane.xyz,direction);\n"
    "if(i+1u!=p.plane&&(height>.0?end<.0:end>.0))return true;\n"
    "}\n"
    "return false;\n"
    "}\n"
    "\n\n\nvec4 csm_shade(glbk_point p,uint pixel)\n"
    "{\n"
    "const uint table=0u;\n"
    "const int ask=CSM_ASK;\n"
    "uint count=glbk_csm_scene.count,samples=glbk_csm_frame.sample_count;\n"
    "cohsm_light light=cohsm_light_open(glbk_csm_frame.light_texel);\n"
    "light.shape=uint(CSM_SHAPE);\n"
    "light.own=glbk_csm_frame.own;\n"
    "cohsm_material material=cohsm_material(p.kind,p.diffuse,p.specular,p.exponent,p.metallic,\n"
    "p.roughness,p.lobe,p.lobe_count);\n"
    "vec3 view=cohsm_normalize(glbk_csm_frame.eye.xyz-p.position);\n"
    "cohsm_surface surface=cohsm_surface_at(material,p.normal,p.tangent,view);\n"
    "cohsm_estimator e=cohsm_estimator_at(surface,light,p.position,int(glbk_csm_frame.sampling),samples,\n"
    "glbk_csm_frame.seed,glbk_csm_frame.frame);\n"
    "vec4 sum=vec4(.0);\n"
    "if(!e.reachable)return sum;\n"
    "\nbool local=ask==COHSM_LIGHT_PARAMETER||(ask==COHSM_LIGHT_INDEX&&light.shape>COHSM_SHAPE_SUN);\n"
    "float moved=.0;\n"
    "if(local&&count>0u)\n"
    "moved=glbk_csm_frame.offset*2./float(cohsm_instance_maps(table,0u).map_size);\n"
    "else if(p.entity-1u<count)\n"
    "moved=cohsm_instance_note(table,p.entity-1u);\n"
    "for(uint k=glbk_csm_frame.first;k<glbk_csm_frame.end;k++){\n"
    "cohsm_emission found;\n"
    "vec3 weight=cohsm_estimate(e,cohsm_numbers(e,pixel,k),found);\n"
    "if(!(weight.x>.0||weight.y>.0||weight.z>.0))continue;\n"
    "if(!(dot(found.direction,p.geometric)>.0))continue;\n"
    "if(csm_behind(p,found.direction,found.range))continue;\n"
    "vec3 from=p.position+p.geometric*(local?moved*found.range:moved);\n"
    "vec3 to=ask==COHSM_LIGHT_DIRECTION?found.direction\n"
    ":ask==COHSM_LIGHT_POSITION?p.position+found.direction*found.range\n"
    ":ask==COHSM_LIGHT_PARAMETER?found.coords:vec3(.0);\n"
    "cohsm_query q=cohsm_query(ask,CSM_FILTER,glbk_csm_frame.bias,glbk_csm_frame.roulette_seed,\n"
    "pixel*samples+k);\n"
    "float visible=cohsm_visible_scene(table,count,p.entity,q,from,to);\n"
    "if(visible<.0)sum.a+=1.;\n"
    "else sum.rgb+=weight*visible;\n"
    "}\n"
    "return vec4(sum.rgb*(1./float(samples)),sum.a);\n"
    "}\n", 0
};

static const struct { char facts[52];
    char s0[165]; char end; } glbk__glsl_lib_csm_visible_glsl GLBK__TIGHT = {
    "lib/csm_visible.glsl\0" "csm_instances cohsm_visible" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\nfloat csm_visible(uint entity,const cohsm_query query,vec3 point,vec3 light)\n"
    "{\n"
    "return cohsm_visible_scene(0u,glbk_csm_scene.count,entity,query,point,light);\n"
    "}\n", 0
};

static const struct { char facts[39];
    char s0[550]; char end; } glbk__glsl_prog_csm_compress_comp GLBK__TIGHT = {
    "prog/csm_compress.comp\0" "csm_compress" "\0" "" "\0"
    "" "\0" "",
    "\n\n\nlayout(local_size_x=8,local_size_y=8)in;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_GlobalInvocationID.xy);\n"
    "uint side=glbk_csm_peel.side,i=4u*(uint(at.y)*side+uint(at.x));\n"
    "if(uint(at.x)>=side||uint(at.y)>=side)return;\n"
    "uvec4 s=glbk_csm_records[i];\n"
    "csm_open o=csm_open(s.x&255u,(s.x>>8)&255u,(s.x>>16)!=0u,s.y);\n"
    "csm_ended ended=csm_compress(at,o);\n"
    "glbk_csm_records[i]=uvec4(o.lo|(o.hi<<8)|(o.fresh?1u<<16:0u),o.next,ended.count,0u);\n"
    "glbk_csm_records[i+1u]=ended.records[0];\n"
    "glbk_csm_records[i+2u]=ended.records[1];\n"
    "glbk_csm_records[i+3u]=ended.records[2];\n"
    "}\n", 0
};

static const struct { char facts[39];
    char s0[502]; char end; } glbk__glsl_prog_csm_compress_frag GLBK__TIGHT = {
    "prog/csm_compress.frag\0" "csm_compress" "\0" "" "\0"
    "" "\0" "",
    "\n\n\nlayout(location=0)out uvec4 open_now;\n"
    "layout(location=1)out uvec4 records0;\n"
    "layout(location=2)out uvec4 records1;\n"
    "layout(location=3)out uvec4 records2;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_FragCoord.xy);\n"
    "uvec4 s=texelFetch(glbk_csm_opened,at,0);\n"
    "csm_open o=csm_open(s.x&255u,(s.x>>8)&255u,(s.x>>16)!=0u,s.y);\n"
    "csm_ended ended=csm_compress(at,o);\n"
    "open_now=uvec4(o.lo|(o.hi<<8)|(o.fresh?1u<<16:0u),o.next,ended.count,0u);\n"
    "records0=ended.records[0];\n"
    "records1=ended.records[1];\n"
    "records2=ended.records[2];\n"
    "}\n", 0
};

static const struct { char facts[109];
    char s0[412]; char end; } glbk__glsl_prog_csm_peel_frag GLBK__TIGHT = {
    "prog/csm_peel.frag\0" "csm_bindings mesh_fragment" "\0" "csm_peel.vert" "\0"
    "CSM_FIRST=1 GLBK_PLACE | CSM_FIRST=0 GLBK_PLACE" "\0" "",
    "\n\n\n\n\n#ifndef CSM_FIRST\n"
    "#define CSM_FIRST 1\n"
    "#endif\n"
    "#if !defined(GL_ES) && __VERSION__ < 420\n"
    "invariant\n"
    "#endif\n"
    "in float csm_depth;\n"
    "layout(location=0)out uint result;\n"
    "\nvoid main()\n"
    "{\n"
    "float depth=clamp(csm_depth,.0,1.);\n"
    "if(glbk_is_hole())discard;\n"
    "#if CSM_FIRST == 0\n"
    "if(depth<=uintBitsToFloat(texelFetch(glbk_csm_layer1,ivec2(gl_FragCoord.xy),0).x))discard;\n"
    "#endif\n"
    "result=floatBitsToUint(depth);\n"
    "gl_FragDepth=depth;\n"
    "}\n", 0
};

static const struct { char facts[66];
    char s0[309]; char end; } glbk__glsl_prog_csm_peel_vert GLBK__TIGHT = {
    "prog/csm_peel.vert\0" "csm_bindings mesh_vertex csm_peel" "\0" "" "\0"
    "GLBK_PLACE" "\0" "",
    "\n\n\n\ninvariant gl_Position;\n"
    "invariant out float csm_depth;\n"
    "\nvoid main()\n"
    "{\n"
    "vec4 p=glbk_csm_peel.view*vec4(glbk_vertex_place(),1.);\n"
    "float w=glbk_csm_peel.depth_scale>.0?p.w:1.;\n"
    "csm_depth=glbk_csm_peel.depth_scale>.0?w*glbk_csm_peel.depth_scale:p.z;\n"
    "gl_Position=vec4(p.xy*glbk_csm_peel.clip_per_pixel-w,.0,w);\n"
    "}\n", 0
};

static const struct { char facts[408];
    char s0[430]; char end; } glbk__glsl_prog_csm_query_comp GLBK__TIGHT = {
    "prog/csm_query.comp\0" "csm_visible csm_frame" "\0" "" "\0"
    "CSM_ASK=0 CSM_FILTER=0 COHSM_ONE_DOMAIN=1 COHSM_ONE_LAYOUT=1 CSM_INSTANCES=1 | CSM_ASK=1 CSM_FILTER=2 | CSM_ASK=2 CSM_FILTER=1 | CSM_ASK=0 CSM_FILTER=0 COHSM_ONE_DOMAIN=1 COHSM_ONE_LAYOUT=2 CSM_INSTANCES=1 | CSM_ASK=0 CSM_FILTER=1 COHSM_ONE_DOMAIN=1 COHSM_ONE_LAYOUT=1 CSM_INSTANCES=1 | CSM_ASK=0 CSM_FILTER=1 COHSM_ONE_DOMAIN=1 COHSM_ONE_LAYOUT=2 CSM_INSTANCES=1" "\0" "",
    "\n\n\n\n\n\n\nlayout(local_size_x=64)in;\n"
    "\nvoid main()\n"
    "{\n"
    "uint i=gl_GlobalInvocationID.y*65536u+gl_GlobalInvocationID.x;\n"
    "if(i>=glbk_csm_frame.end)return;\n"
    "uvec4 point=glbk_csm_asked[2u*i],light=glbk_csm_asked[2u*i+1u];\n"
    "uint seed=glbk_csm_frame.roulette_seed;\n"
    "cohsm_query q=cohsm_query(CSM_ASK,CSM_FILTER,glbk_csm_frame.bias,seed,light.w);\n"
    "glbk_csm_answers[i]=csm_visible(point.w,q,uintBitsToFloat(point.xyz),uintBitsToFloat(light.xyz));\n"
    "}\n", 0
};

static const struct { char facts[408];
    char s0[566]; char end; } glbk__glsl_prog_csm_query_frag GLBK__TIGHT = {
    "prog/csm_query.frag\0" "csm_visible csm_frame" "\0" "" "\0"
    "CSM_ASK=0 CSM_FILTER=0 COHSM_ONE_DOMAIN=1 COHSM_ONE_LAYOUT=1 CSM_INSTANCES=1 | CSM_ASK=1 CSM_FILTER=2 | CSM_ASK=2 CSM_FILTER=1 | CSM_ASK=0 CSM_FILTER=0 COHSM_ONE_DOMAIN=1 COHSM_ONE_LAYOUT=2 CSM_INSTANCES=1 | CSM_ASK=0 CSM_FILTER=1 COHSM_ONE_DOMAIN=1 COHSM_ONE_LAYOUT=1 CSM_INSTANCES=1 | CSM_ASK=0 CSM_FILTER=1 COHSM_ONE_DOMAIN=1 COHSM_ONE_LAYOUT=2 CSM_INSTANCES=1" "\0" "",
    "\n\n\n\n\n\n\n\n\nlayout(location=0)out uvec4 result;\n"
    "\nvoid main()\n"
    "{\n"
    "uint i=uint(gl_FragCoord.y)*1024u+uint(gl_FragCoord.x);\n"
    "result=uvec4(0u);\n"
    "if(i>=glbk_csm_frame.end)return;\n"
    "uvec4 point=texelFetch(glbk_csm_questions,glbk_table_at(2u*i),0);\n"
    "uvec4 light=texelFetch(glbk_csm_questions,glbk_table_at(2u*i+1u),0);\n"
    "uint seed=glbk_csm_frame.roulette_seed;\n"
    "cohsm_query q=cohsm_query(CSM_ASK,CSM_FILTER,glbk_csm_frame.bias,seed,light.w);\n"
    "float visible=csm_visible(point.w,q,uintBitsToFloat(point.xyz),uintBitsToFloat(light.xyz));\n"
    "result=uvec4(floatBitsToUint(visible),0u,0u,0u);\n"
    "}\n", 0
};

static const struct { char facts[56];
    char s0[424]; char end; } glbk__glsl_prog_csm_resolve_frag GLBK__TIGHT = {
    "prog/csm_resolve.frag\0" "csm_bindings picture csm_frame" "\0" "" "\0"
    "" "\0" "",
    "\n\n\nlayout(location=0)out vec4 result;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=glbk_picture_at();\n"
    "vec4 sum=glbk_unpack(texelFetch(glbk_csm_sum,at,0));\n"
    "vec3 p=vec3(.0);\n"
    "bool seen=true;\n"
    "if(glbk_picture_asks()){\n"
    "p=uintBitsToFloat(texelFetch(glbk_csm_place,at,0).xyz);\n"
    "seen=(texelFetch(glbk_csm_normal,at,0).w&0xffu)!=0u;\n"
    "}\n"
    "glbk_picture_show(seen,p);\n"
    "result=vec4(glbk_csm_frame.frame_share>.0?sum.rgb*glbk_csm_frame.frame_share:vec3(.0),1.);\n"
    "}\n", 0
};

static const struct { char facts[187];
    char s0[410]; char end; } glbk__glsl_prog_csm_shade_comp GLBK__TIGHT = {
    "prog/csm_shade.comp\0" "csm_shade" "\0" "" "\0"
    "CSM_SHAPE=1 CSM_ASK=0 CSM_FILTER=0 COHSM_ONE_DOMAIN=1 COHSM_ONE_LAYOUT=2 CSM_INSTANCES=1 | CSM_SHAPE=6 CSM_ASK=2 CSM_FILTER=2 COHSM_LOBES=8 CSM_PATTERNS=1" "\0" "",
    "\n\n\n\nlayout(local_size_x=8,local_size_y=8)in;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_GlobalInvocationID.xy);\n"
    "uint pixel=uint(at.y)*glbk_csm_frame.width+uint(at.x);\n"
    "glbk_point p;\n"
    "if(uint(at.x)>=glbk_csm_frame.width||uint(at.y)>=glbk_csm_frame.height)return;\n"
    "vec4 sum=glbk_csm_frame.adds!=0u?imageLoad(glbk_csm_total,at):vec4(.0);\n"
    "if(glbk_read_point(at,p))sum+=csm_shade(p,pixel);\n"
    "imageStore(glbk_csm_total,at,sum);\n"
    "}\n", 0
};

static const struct { char facts[187];
    char s0[307]; char end; } glbk__glsl_prog_csm_shade_frag GLBK__TIGHT = {
    "prog/csm_shade.frag\0" "csm_shade" "\0" "" "\0"
    "CSM_SHAPE=1 CSM_ASK=0 CSM_FILTER=0 COHSM_ONE_DOMAIN=1 COHSM_ONE_LAYOUT=2 CSM_INSTANCES=1 | CSM_SHAPE=6 CSM_ASK=2 CSM_FILTER=2 COHSM_LOBES=8 CSM_PATTERNS=1" "\0" "",
    "\n\n\n\n\nlayout(location=0)out glbk_color result;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_FragCoord.xy);\n"
    "vec4 sum=glbk_csm_frame.adds!=0u?glbk_unpack(texelFetch(glbk_csm_sum,at,0)):vec4(.0);\n"
    "glbk_point p;\n"
    "if(glbk_read_point(at,p))sum+=csm_shade(p,uint(at.y)*glbk_csm_frame.width+uint(at.x));\n"
    "result=glbk_pack(sum);\n"
    "}\n", 0
};

static const glbk_file glbk__csm_files[] = {
    { (const char *)&glbk__glsl_lib_cohsm_brdf_glsl },
    { (const char *)&glbk__glsl_lib_cohsm_emission_glsl },
    { (const char *)&glbk__glsl_lib_cohsm_estimate_glsl },
    { (const char *)&glbk__glsl_lib_cohsm_light_glsl },
    { (const char *)&glbk__glsl_lib_cohsm_lookup_glsl },
    { (const char *)&glbk__csm_files_lib_cohsm_math_glsl },
    { (const char *)&glbk__glsl_lib_cohsm_octa_glsl },
    { (const char *)&glbk__glsl_lib_cohsm_random_glsl },
    { (const char *)&glbk__glsl_lib_cohsm_visible_glsl },
    { (const char *)&glbk__glsl_lib_csm_access_glsl },
    { (const char *)&glbk__glsl_lib_csm_bindings_glsl },
    { (const char *)&glbk__glsl_lib_csm_compress_glsl },
    { (const char *)&glbk__glsl_lib_csm_frame_glsl },
    { (const char *)&glbk__glsl_lib_csm_instances_glsl },
    { (const char *)&glbk__glsl_lib_csm_pattern_glsl },
    { (const char *)&glbk__glsl_lib_csm_peel_glsl },
    { (const char *)&glbk__glsl_lib_csm_scene_glsl },
    { (const char *)&glbk__glsl_lib_csm_shade_glsl },
    { (const char *)&glbk__glsl_lib_csm_visible_glsl },
    { (const char *)&glbk__glsl_prog_csm_compress_comp },
    { (const char *)&glbk__glsl_prog_csm_compress_frag },
    { (const char *)&glbk__glsl_prog_csm_peel_frag },
    { (const char *)&glbk__glsl_prog_csm_peel_vert },
    { (const char *)&glbk__glsl_prog_csm_query_comp },
    { (const char *)&glbk__glsl_prog_csm_query_frag },
    { (const char *)&glbk__glsl_prog_csm_resolve_frag },
    { (const char *)&glbk__glsl_prog_csm_shade_comp },
    { (const char *)&glbk__glsl_prog_csm_shade_frag }
};


/* ==== src/gl_csm/part.h ==== */

/* ---- csm: this header's GLSL, textures and blocks, by which programs find them ---- */

GLBK__PART_CODE(csm, CSM)

/* ==== src/gl_csm/blocks.h ==== */

/* ---- csm: blocks and instances ---- */

enum {
    GLBK__CSM_RECORD = 5,                   /* texels of an instance */
    GLBK__CSM_MAGIC = 0x4d534344,
    GLBK__CSM_FAST_MAGIC = 0x46534344,      /* of what cohsm_fast_data returns */
    GLBK__CSM_FORMAT = 1
};

/* Words of a block's header, of which docs/csm-format.md has all. */
enum {
    GLBK__CSM_WORD_MAGIC = 0, GLBK__CSM_WORD_FORMAT = 1,
    GLBK__CSM_WORD_COUNT = 2,               /* how many words the block has */
    GLBK__CSM_WORD_KEPT = 4,                /* texel 1: glbk__csm_head has the words from here on */
    GLBK__CSM_WORD_DOMAIN = 4, GLBK__CSM_WORD_ORDER = 6, GLBK__CSM_WORD_ORIENTATION = 7,
    GLBK__CSM_WORD_SIDE = 8,                /* three, of the domain */
    GLBK__CSM_WORD_MAP_SIDE = 13, GLBK__CSM_WORD_SELF_ONLY = 17,
    GLBK__CSM_WORD_SECTIONS = 20,           /* five lengths: of order, locations, the last three sections */
    GLBK__CSM_WORD_SPHERE = 27,             /* four floats: centre and radius */
    GLBK__CSM_HEADER = 96                   /* words of the header */
};

/* Returns a word of a block's header. */
static uint32_t glbk__csm_word(const glbk_csm_block *b, uint32_t word)
{
    uint32_t value;
    memcpy(&value, (const char *)b->data + 4 * word, sizeof value);
    return value;
}

/* Finds the words at which the three last sections of a fast block begin and, in at[3], the last one ends. */
static void glbk__csm_sections(const glbk_csm_block *b, uint64_t at[4])
{
    const uint32_t order = glbk__csm_word(b, GLBK__CSM_WORD_SECTIONS),
                   locations = glbk__csm_word(b, GLBK__CSM_WORD_SECTIONS + 1);
    uint32_t k;
    at[0] = ((uint64_t)GLBK__CSM_HEADER + order + locations + 15) / 16 * 16;
    for (k = 0; k < 3; k++) at[k + 1] = at[k] + glbk__csm_word(b, GLBK__CSM_WORD_SECTIONS + 2 + k);
}

/* Checks magic, format and length of block i, as docs/csm-format.md has them, in the host's byte order: that
   of GL. */
static glbk_result glbk__csm_check_block(const glbk_context *ctx, const glbk_csm_block *b, size_t i)
{
    static const char function[] = "glbk_csm_maps_create";
    uint64_t sections[4];
    uint32_t magic, words, format;
    if (!b->data)
        return glbk__refuse_element(ctx, GLBK_ERR_ARGUMENT, function, "blocks", i, ".data", "is NULL");
    if (b->bytes < 400 || b->bytes % 16)
        return glbk__refuse_element_value(ctx, GLBK_ERR_FORMAT, function, "blocks", i, ".bytes",
                                          (double)b->bytes, "what cohsm_data says: a multiple of 16, >= 400");
    magic = glbk__csm_word(b, GLBK__CSM_WORD_MAGIC);
    words = glbk__csm_word(b, GLBK__CSM_WORD_COUNT);
    format = glbk__csm_word(b, GLBK__CSM_WORD_FORMAT);
    if (magic != GLBK__CSM_MAGIC && magic != GLBK__CSM_FAST_MAGIC)
        return glbk__refuse_element(ctx, GLBK_ERR_FORMAT, function, "blocks", i, ".data",
                                    "begin with other bytes than a block of csm.h");
    if (words != b->bytes / 4)
        return glbk__refuse_element_value(ctx, GLBK_ERR_FORMAT, function, "blocks", i, ".bytes",
                                          (double)b->bytes, "four times the length that its header names");
    if (format != GLBK__CSM_FORMAT)
        return glbk__refuse_element_value(ctx, GLBK_ERR_VERSION, function, "blocks", i, "'s version",
                                          (double)format, "1");
    if (magic == GLBK__CSM_MAGIC) return GLBK_OK;
    glbk__csm_sections(b, sections);
    if (sections[3] > words)
        return glbk__refuse_element_value(ctx, GLBK_ERR_FORMAT, function, "blocks", i,
                                          "'s sections end at word", (double)sections[3],
                                          "the length that its header names, or less");
    return GLBK_OK;
}

enum {
    GLBK__CSM_NEAR = 16,            /* instances that the uniform block has room for */
    GLBK__CSM_NEAR_TEXELS = 12      /* of each: its record and texels 1 to 7 of its block */
};

/* What instances need to know of their block: the texel at which it begins, and texels 1 to 7 of it. */
typedef struct glbk__csm_head { uint32_t start, words[28]; } glbk__csm_head;

/* Appends a define with a number below 20, unless it is 0. */
static void glbk__csm_define(glbk__sink *sink, const char *name, uint32_t value)
{
    char digit = (char)('0' + value % 10);
    if (!value) return;
    glbk__append_text(sink, name);
    if (value > 9) glbk__append_text(sink, "1");
    glbk__append(sink, &digit, 1);
}

/* Writes the defines by which a program for these blocks alone is compiled, and a number for them: domain,
   order, orientation and layout if all blocks have the same, and how many instances stand in the uniform
   block, if they fit. */
static void glbk__csm_write_defines(const glbk_csm_block *blocks, size_t count, glbk_csm_maps *out)
{
    enum { OF_DOMAIN, OF_ORDER, OF_ORIENTATION, KINDS };
    static const uint32_t word[KINDS] = { GLBK__CSM_WORD_DOMAIN, GLBK__CSM_WORD_ORDER,
                                          GLBK__CSM_WORD_ORIENTATION };
    static const uint32_t count_of[KINDS] = { COHSM_DOMAIN_COUNT, COHSM_ORDER_COUNT,
                                              COHSM_ORIENTATION_COUNT };
    uint32_t kind[KINDS] = { 0, 0, 0 }, layout, layouts = 0, k;
    glbk__sink sink = { NULL, 0, 0 };
    size_t i;
    for (i = 0; i < count; i++) {
        layouts |= glbk__csm_word(&blocks[i], GLBK__CSM_WORD_MAGIC) == GLBK__CSM_FAST_MAGIC ? 2u : 1u;
        for (k = 0; k < KINDS; k++) {
            const uint32_t value = glbk__csm_word(&blocks[i], word[k]);
            kind[k] = value < count_of[k] && (i == 0 || kind[k] == value) ? value : 0;
        }
    }
    if (count <= GLBK__CSM_NEAR && out->capacity <= GLBK__CSM_NEAR)
        out->near_count = out->capacity <= 1 ? 1 : GLBK__CSM_NEAR;
    sink.out = out->defines;
    sink.bytes = sizeof out->defines;
    glbk__csm_define(&sink, " COHSM_ONE_DOMAIN=", kind[OF_DOMAIN]);
    glbk__csm_define(&sink, " COHSM_ONE_ORDER=", kind[OF_ORDER]);
    glbk__csm_define(&sink, " COHSM_ONE_ORIENTATION=", kind[OF_ORIENTATION]);
    layout = layouts < 3 ? layouts : 0;
    glbk__csm_define(&sink, " COHSM_ONE_LAYOUT=", layout);
    glbk__csm_define(&sink, " CSM_INSTANCES=", out->near_count);
    out->key = (((layout * 16 + kind[OF_DOMAIN]) * 8 + kind[OF_ORDER]) * 4 + kind[OF_ORIENTATION]) * 4;
    out->key += out->near_count > 1 ? 2 : out->near_count;
}

/* Checks the blocks and finds where each begins, in texels; *texels receives how many there are in all. */
static glbk_result glbk__csm_line_up(const glbk_context *ctx, const glbk_csm_block *blocks, size_t count,
                                     uint32_t *starts, size_t *texels)
{
    static const char function[] = "glbk_csm_maps_create";
    glbk_result result = count ? glbk__require(ctx, function, "blocks", blocks) : GLBK_OK;
    size_t i;

    if (result == GLBK_OK && count) result = glbk__require(ctx, function, "starts", starts);
    *texels = 0;
    for (i = 0; i < count && result == GLBK_OK; i++) {
        result = glbk__csm_check_block(ctx, &blocks[i], i);
        if (result != GLBK_OK) return result;
        if (blocks[i].bytes / 16 > ((size_t)1 << 28) - *texels)
            return glbk__refuse_element_value(ctx, GLBK_ERR_LIMIT, function, "blocks", i, ".bytes",
                                              (double)blocks[i].bytes, "4 GB at most with those before");
        starts[i] = (uint32_t)*texels;
        *texels += blocks[i].bytes / 16;
        *texels += (size_t)-(ptrdiff_t)*texels & 3u;    /* so that no line of 64 bytes straddles two rows */
    }
    return result;
}

/* Keeps the headers of all blocks, in the order of their places. */
static glbk_result glbk__csm_keep_heads(glbk_context *ctx, const glbk_csm_block *blocks, size_t count,
                                        const uint32_t *starts, glbk_csm_maps *out)
{
    glbk_csm__allocator memory = glbk_csm__memory(ctx);
    glbk__csm_head *heads = (glbk__csm_head *)glbk_csm__alloc_array(&memory, count, sizeof *heads);
    size_t i;
    if (!heads) return GLBK_ERR_ALLOC;
    for (i = 0; i < count; i++) {
        heads[i].start = starts[i];
        memcpy(heads[i].words, (const char *)blocks[i].data + 4 * GLBK__CSM_WORD_KEPT,
               sizeof heads[i].words);
    }
    out->heads = heads;
    out->block_count = (uint32_t)count;
    return GLBK_OK;
}

/* Uploads a block. The lines of a fast block are bytes, and its last section half words: GLSL reads both from
   words, the lowest bits first, whatever the byte order of the host. */
static glbk_result glbk__csm_upload(glbk_context *ctx, const glbk_csm_maps *maps, uint32_t start,
                                    const glbk_csm_block *b)
{
    uint32_t words[4096];
    uint64_t sections[4];
    size_t at, n = 0, i;
    glbk_result result = GLBK_OK;

    if (glbk__csm_word(b, GLBK__CSM_WORD_MAGIC) == GLBK__CSM_MAGIC)
        return glbk__table_update(ctx, &maps->blocks, start, b->bytes / 16, b->data);
    glbk__csm_sections(b, sections);
    for (at = 0; at < b->bytes / 4 && result == GLBK_OK; at += n) {
        n = b->bytes / 4 - at < 4096 ? b->bytes / 4 - at : 4096;
        memcpy(words, (const char *)b->data + 4 * at, 4 * n);
        for (i = 0; i < n; i++) {
            unsigned char bytes[4];
            uint16_t halves[2];
            memcpy(bytes, words + i, sizeof bytes);
            memcpy(halves, words + i, sizeof halves);
            if (at + i >= sections[2]) words[i] = halves[0] | (uint32_t)halves[1] << 16;
            else if (at + i >= sections[0] && at + i < sections[1])
                words[i] = bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
                           (uint32_t)bytes[3] << 24;
        }
        result = glbk__table_update(ctx, &maps->blocks, start + at / 4, n / 4, words);
    }
    return result;
}

GLBK_DEF glbk_result glbk_csm_maps_create(glbk_context *ctx, const glbk_csm_block *blocks, size_t count,
                                          uint32_t capacity, uint32_t *starts, glbk_csm_maps *out)
{
    const uint32_t most = ((uint32_t)1 << 28) / GLBK__CSM_RECORD;
    size_t texels, i;
    glbk_result result;

    if (out) memset(out, 0, sizeof *out);
    result = glbk__require(ctx, __func__, "out", out);
    if (result == GLBK_OK) result = glbk__csm_line_up(ctx, blocks, count, starts, &texels);
    if (result != GLBK_OK) return result;
    if (capacity > most)
        return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, __func__, "capacity", capacity, 0, most);
    out->texel_count = (uint32_t)texels;
    out->capacity = capacity;
    glbk__csm_write_defines(blocks, count, out);
    if (count) result = glbk__csm_keep_heads(ctx, blocks, count, starts, out);
    if (result == GLBK_OK)
        result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, texels + 1, &out->blocks);
    if (result == GLBK_OK && !out->near_count)
        result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, GLBK__CSM_RECORD * (size_t)capacity + 1,
                                    &out->instances);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_csm_scene), NULL, &out->scene);
    for (i = 0; i < count && result == GLBK_OK; i++)
        result = glbk__csm_upload(ctx, out, starts[i], &blocks[i]);
    if (result == GLBK_OK) result = glbk__leave_created(ctx, glbk_csm_maps_place(ctx, out, NULL, 0));
    if (result != GLBK_OK) glbk_csm_maps_free(ctx, out);
    return result;
}

/* Returns what is kept of the block that begins at a texel, or of the last one that begins before. */
static const glbk__csm_head *glbk__csm_find_head(const glbk_csm_maps *maps, uint32_t start)
{
    const glbk__csm_head *heads = (const glbk__csm_head *)maps->heads;
    uint32_t low = 0, high = maps->block_count, middle;
    while (low + 1 < high) {
        middle = low + (high - low) / 2;
        if (heads[middle].start <= start) low = middle;
        else high = middle;
    }
    return heads + low;
}

/* Returns a word of a block's header, from texel 1 on. */
static uint32_t glbk__csm_head_word(const glbk__csm_head *head, uint32_t word)
{
    return head->words[word - GLBK__CSM_WORD_KEPT];
}

static float glbk__csm_head_float(const glbk__csm_head *head, uint32_t word)
{
    const uint32_t bits = glbk__csm_head_word(head, word);
    float f;
    memcpy(&f, &bits, sizeof f);
    return f;
}

/* Returns the angle that a cell of a domain of directions covers, in radians: no direction is farther from
   that of the map which answers for it, and none farther than half of it where the nearest map answers. 4
   says that no sphere bounds what the maps shadow. */
static float glbk__csm_cell_angle(const glbk__csm_head *head)
{
    const float side = (float)glbk__csm_head_word(head, GLBK__CSM_WORD_SIDE);
    const float a = 6.2832f / side, b = 3.1416f / (float)glbk__csm_head_word(head, GLBK__CSM_WORD_SIDE + 1);
    if (glbk__csm_head_word(head, GLBK__CSM_WORD_SELF_ONLY) & 1u) return 4.0f;
    /* A step in the octahedral square turns a direction by at most 6.2 times its length. */
    if (glbk__csm_head_word(head, GLBK__CSM_WORD_DOMAIN) == COHSM_DOMAIN_OCTAHEDRAL)
        return 6.2f * 1.4143f / side;
    return sqrtf(a * a + b * b);
}

/* Writes the five texels of an instance: world to object, where its block begins and its offset, and what
   cohsm_misses_instance is told of the sphere that holds all that shadows. No hull reaches beyond 1.14 radii;
   a map of a direction reaches to its corners' pixels. */
static void glbk__csm_record(const glbk__csm_head *head, const glbk_csm_instance *instance, uint32_t *words)
{
    const float *transform = glbk_csm__m4_or_identity(instance->transform);
    const float map_side = (float)glbk__csm_head_word(head, GLBK__CSM_WORD_MAP_SIDE);
    float inverse[16], f[20], radius = glbk__csm_head_float(head, GLBK__CSM_WORD_SPHERE + 3), slack;
    glbk_csm__v3 center;
    uint32_t r, c;
    center.x = glbk__csm_head_float(head, GLBK__CSM_WORD_SPHERE);
    center.y = glbk__csm_head_float(head, GLBK__CSM_WORD_SPHERE + 1);
    center.z = glbk__csm_head_float(head, GLBK__CSM_WORD_SPHERE + 2);
    center = glbk_csm__m4_point(transform, center);
    slack = 1e-5f * (fabsf(center.x) + fabsf(center.y) + fabsf(center.z));
    radius *= glbk_csm__v3_length(glbk_csm__v3_load(transform));
    glbk_csm__m4_affine_inverse(inverse, transform);
    for (r = 0; r < 3; r++)
        for (c = 0; c < 4; c++) f[4 * r + c] = inverse[4 * c + r];
    f[13] = instance->offset;
    f[14] = glbk__csm_cell_angle(head);
    f[15] = (1.001f + 2.83f / map_side) * radius + slack;
    glbk_csm__v3_store(f + 16, center);
    f[19] = 1.14f * radius + slack;
    f[12] = 0;
    memcpy(words, f, sizeof f);
    words[12] = instance->start;
}

/* Writes instances and the headers of their blocks into the uniform block. */
static void glbk__csm_place_near(const glbk_csm_maps *maps, const glbk_csm_instance *instances,
                                 uint32_t count, glbk_csm_scene *scene)
{
    uint32_t i;
    for (i = 0; i < count; i++) {
        uint32_t *to = scene->instances + 4 * GLBK__CSM_NEAR_TEXELS * i;
        const glbk__csm_head *head = glbk__csm_find_head(maps, instances[i].start);
        glbk__csm_record(head, &instances[i], to);
        memcpy(to + 4 * GLBK__CSM_RECORD, head->words, sizeof head->words);
    }
}

/* Uploads all instances to their table, at once. */
static glbk_result glbk__csm_place_many(glbk_context *ctx, const glbk_csm_maps *maps,
                                        const glbk_csm_instance *instances, uint32_t count)
{
    glbk_csm__allocator memory = glbk_csm__memory(ctx);
    uint32_t *words = (uint32_t *)glbk_csm__alloc_array(&memory, count, 4 * 4 * GLBK__CSM_RECORD), i;
    glbk_result result;
    if (!words) return GLBK_ERR_ALLOC;
    for (i = 0; i < count; i++)
        glbk__csm_record(glbk__csm_find_head(maps, instances[i].start), &instances[i],
                         words + 4 * GLBK__CSM_RECORD * (size_t)i);
    result = glbk__table_update(ctx, &maps->instances, 0, GLBK__CSM_RECORD * (size_t)count, words);
    glbk_csm__free(&memory, words);
    return result;
}

/* Checks what glbk_csm_maps_place is given. */
static glbk_result glbk__csm_check_instances(const glbk_context *ctx, const glbk_csm_maps *maps,
                                             const glbk_csm_instance *instances, uint32_t count)
{
    static const char function[] = "glbk_csm_maps_place";
    const glbk_result bad = GLBK_ERR_INPUT;
    glbk_result result = glbk__require_created(ctx, function, "maps", maps ? &maps->blocks.name : NULL);
    float inverse[16], scale;
    uint32_t i;

    if (result == GLBK_OK && count) result = glbk__require(ctx, function, "instances", instances);
    if (result != GLBK_OK) return result;
    if (count > maps->capacity)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "count", count, 0, maps->capacity);
    for (i = 0; i < count; i++) {
        const float *m = glbk_csm__m4_or_identity(instances[i].transform);
        if (instances[i].start >= maps->texel_count)
            return glbk__refuse_element_value(ctx, bad, function, "instances", i, ".start",
                                              instances[i].start, "one that glbk_csm_maps_create wrote");
        if (!glbk_csm__m4_is_rigid_uniform(m, &scale) || !glbk_csm__m4_affine_inverse(inverse, m))
            return glbk__refuse_element(ctx, bad, function, "instances", i, ".transform",
                                        "is not a rotation, one scale > 0 and a translation");
    }
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_csm_maps_place(glbk_context *ctx, glbk_csm_maps *maps,
                                         const glbk_csm_instance *instances, uint32_t count)
{
    glbk_csm_scene scene;
    glbk_result result;

    result = glbk__csm_check_instances(ctx, maps, instances, count);
    if (result != GLBK_OK) return result;
    memset(&scene, 0, sizeof scene);
    if (maps->near_count) glbk__csm_place_near(maps, instances, count, &scene);
    else if (count) result = glbk__csm_place_many(ctx, maps, instances, count);
    if (result != GLBK_OK) return result;
    maps->count = count;
    scene.count = count;
    scene.in_block = maps->near_count != 0;
    return glbk_buffer_update(ctx, &maps->scene, 0, sizeof scene, &scene);
}

GLBK_DEF void glbk_csm_bind(glbk_context *ctx, const glbk_csm_maps *maps, const glbk_offset *offset)
{
    const glbk_offset at = glbk__offset(offset);
    if (!maps) return;
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_csm_blocks, &maps->blocks);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_csm_instances,
                      maps->instances.name ? &maps->instances : &maps->blocks);
    glbk_bind_block(ctx, at.block + GLBK_SLOT_glbk_csm_scene, &maps->scene);
}

GLBK_DEF void glbk_csm_maps_free(glbk_context *ctx, glbk_csm_maps *maps)
{
    glbk_csm__allocator memory;
    if (!maps) return;
    glbk_texture_free(ctx, &maps->blocks);
    glbk_texture_free(ctx, &maps->instances);
    glbk_buffer_free(ctx, &maps->scene);
    if (maps->heads) {
        memory = glbk_csm__memory(ctx);
        glbk_csm__free(&memory, maps->heads);
    }
    memset(maps, 0, sizeof *maps);
}

/* ==== src/gl_csm/programs.h ==== */

/* ---- csm: programs that are kept ---- */

/* Returns the place of a key in the cache: where it is kept, else a free one, else that of the program that
   was used longest ago, which is freed. Returns NULL if all were used in this frame, since the same programs
   would be compiled again and again. */
static glbk_program *glbk__csm_keep_program(glbk_context *ctx, glbk_csm_programs *cache, uint32_t key,
                                            uint32_t *at)
{
    uint32_t i, oldest = 0;
    for (i = 0; i < cache->count && cache->keys[i] != key; i++)
        if (cache->frame - cache->used[i] > cache->frame - cache->used[oldest]) oldest = i;
    if (i == GLBK_CSM_MAX_PROGRAMS) {
        if (cache->used[oldest] == cache->frame) return NULL;
        i = oldest;
        glbk_program_free(ctx, &cache->list[i]);
        cache->keys[i] = UINT32_MAX;        /* no key, in case that its successor does not compile */
    }
    *at = i;
    return &cache->list[i];
}

/* Finds or compiles a program of a cache, for a public function. texts are the defines of this use, which
   those of the maps follow, and GLSL of the user's before the main, or NULL. Programs named csm_shade read
   the G-buffer. */
static glbk_result glbk__csm_program(glbk_context *ctx, const char *function, glbk_csm_programs *cache,
                                     uint32_t key, const char *name,
                                     const char *const texts[2], const glbk_csm_maps *maps,
                                     glbk_program **out)
{
    char all[208] = { 0 };
    const char *own[2];
    glbk__sink sink = { NULL, 0, 0 };
    glbk_result result;
    uint32_t i;

    key = key << 13 | maps->key;
    *out = glbk__csm_keep_program(ctx, cache, key, &i);
    if (!*out)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function,
                                  "the number of programs that the uses of one frame need",
                                  GLBK_CSM_MAX_PROGRAMS + 1, 0, GLBK_CSM_MAX_PROGRAMS);
    cache->used[i] = cache->frame;
    if ((*out)->name) return GLBK_OK;
    own[0] = NULL;
    own[1] = texts[1];
    sink.out = all;
    sink.bytes = sizeof all;
    glbk__append_text(&sink, texts[0]);
    glbk__append_text(&sink, maps->defines);
    result = glbk__gbuffer_program_with(ctx, glbk_csm_part(), name, all, own, *out);
    if (result != GLBK_OK) return result;
    cache->keys[i] = key;
    if (i == cache->count) cache->count++;
    return GLBK_OK;
}

static void glbk__csm_programs_free(glbk_context *ctx, glbk_csm_programs *cache)
{
    uint32_t i;
    for (i = 0; i < cache->count; i++) glbk_program_free(ctx, &cache->list[i]);
    cache->count = 0;
}

/* ==== src/gl_csm/questions.h ==== */

/* ---- csm: questions in bulk ---- */

/* Finds or compiles the program for the questions that were uploaded and these maps. */
static glbk_result glbk__csm_ask_program(glbk_context *ctx, glbk_csm_asker *asker, const glbk_csm_maps *maps,
                                         glbk_program **out)
{
    char defines[] = "CSM_ASK=0 CSM_FILTER=0";
    const char *texts[2];
    uint32_t question = asker->question - 1;
    texts[0] = defines;
    texts[1] = NULL;
    asker->programs.frame++;
    defines[8] = (char)('0' + question / 3);
    defines[21] = (char)('0' + question % 3);
    return glbk__csm_program(ctx, "glbk_csm_ask_run", &asker->programs, question,
                             asker->asked.name ? "csm_query.comp" : "csm_query.frag", texts, maps, out);
}

GLBK_DEF glbk_result glbk_csm_asker_create(glbk_context *ctx, uint32_t capacity, glbk_csm_asker *out)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result;

    if (out) memset(out, 0, sizeof *out);
    result = glbk__require(ctx, __func__, "out", out);
    if (result != GLBK_OK) return result;
    if (!capacity || capacity > (uint32_t)1 << 22)
        return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, __func__, "capacity", capacity, 1, 4194304);
    memset(&texture, 0, sizeof texture);
    memset(&target, 0, sizeof target);
    out->capacity = capacity;
    result = glbk_buffer_create(ctx, sizeof(glbk_csm_frame), NULL, &out->frame);
    if (result == GLBK_OK && ctx->compute && 32 * (size_t)capacity <= ctx->max_storage) {
        result = glbk_buffer_create(ctx, 32 * (size_t)capacity, NULL, &out->asked);
        if (result == GLBK_OK) result = glbk_buffer_create(ctx, 4 * (size_t)capacity, NULL, &out->answered);
    } else if (result == GLBK_OK) {
        result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, NULL, 2 * (size_t)capacity, &out->questions);
        texture.format = GLBK_FORMAT_R32UI;
        texture.width = 1024;
        texture.height = (capacity + 1023) / 1024;
        if (result == GLBK_OK) result = glbk_texture_create(ctx, &texture, &out->answers);
        target.color[0] = &out->answers;
        if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &out->target);
    }
    if (result != GLBK_OK) glbk_csm_asker_free(ctx, out);
    return result;
}

/* Checks what glbk_csm_ask_upload is given. */
static glbk_result glbk__csm_check_query(const glbk_context *ctx, const glbk_csm_asker *asker,
                                         const cohsm_query *q)
{
    static const char function[] = "glbk_csm_ask_upload";
    const glbk_result bad = GLBK_ERR_ARGUMENT;
    glbk_result result = glbk__require_created(ctx, function, "asker", asker ? &asker->frame.name : NULL);
    size_t least, stride;

    if (result == GLBK_OK) result = glbk__require(ctx, function, "query", q);
    if (result == GLBK_OK) result = glbk__require(ctx, function, "query.positions", q->positions);
    if (result == GLBK_OK) result = glbk__require(ctx, function, "query.lights", q->lights);
    if (result != GLBK_OK) return result;
    least = q->light_kind == COHSM_LIGHT_INDEX ? 4 : 12;
    stride = q->light_stride;
    if (!q->count || q->count > asker->capacity)
        return glbk__refuse_range(ctx, q->count ? GLBK_ERR_LIMIT : bad, function, "query.count",
                                  (double)q->count, 1, asker->capacity);
    if (q->position_stride % 4 || (q->position_stride && q->position_stride < 12))
        return glbk__refuse_value(ctx, bad, function, "query.position_stride", (double)q->position_stride,
                                  "0 or a multiple of 4, >= 12");
    if ((unsigned)q->light_kind >= COHSM_LIGHT_COUNT)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "query.light_kind", (double)q->light_kind,
                                  "a COHSM_LIGHT_...");
    if (stride % 4 || (stride && stride < least) || (!stride && q->light_kind == COHSM_LIGHT_PARAMETER))
        return glbk__refuse_value(ctx, bad, function, "query.light_stride", (double)stride,
                                  q->light_kind == COHSM_LIGHT_PARAMETER
                                      ? "a multiple of 4, >= 12"
                                      : "0 or a multiple of 4, >= a light");
    if ((unsigned)q->filter >= COHSM_FILTER_COUNT)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "query.filter", (double)q->filter,
                                  "a COHSM_FILTER_...");
    if (!glbk_csm__finite(q->bias))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "query.bias", (double)q->bias, "finite");
    return GLBK_OK;
}

/* Returns a bias with its default resolved, as csm.h has it: 0 is a pixel, a negative one none. */
static float glbk__csm_bias(float bias) { return bias > 0 ? bias : bias < 0 ? 0.0f : 1.0f; }

/* Writes eight words for each question: the point as 3 floats and its instance; the light as 3 floats or a
   cell, and a number for roulette. */
static void glbk__csm_write_questions(const cohsm_query *q, uint32_t *words)
{
    const size_t bytes = q->light_kind == COHSM_LIGHT_INDEX ? 4 : 12,
                 step = q->light_stride ? q->light_stride : bytes;
    const size_t stride = q->position_stride ? q->position_stride : 12;
    size_t i;
    memset(words, 0, 32 * q->count);
    for (i = 0; i < q->count; i++, words += 8) {
        memcpy(words, (const char *)q->positions + i * stride, 12);
        words[3] = q->entities ? q->entities[i] : 0;
        memcpy(words + 4, (const char *)q->lights + (q->one_light ? 0 : i * step), bytes);
        words[7] = (uint32_t)i;
    }
}

GLBK_DEF glbk_result glbk_csm_ask_upload(glbk_context *ctx, glbk_csm_asker *asker, const cohsm_query *q)
{
    glbk_csm__allocator memory;
    glbk_csm_frame frame;
    glbk_result result;
    uint32_t *words;

    result = glbk__csm_check_query(ctx, asker, q);
    if (result != GLBK_OK) return result;
    memory = glbk_csm__memory(ctx);
    words = (uint32_t *)glbk_csm__alloc_array(&memory, q->count, 32);
    if (!words) return GLBK_ERR_ALLOC;
    glbk__csm_write_questions(q, words);
    asker->question = 1 + 3 * (uint32_t)q->light_kind + (uint32_t)q->filter;
    memset(&frame, 0, sizeof frame);
    frame.end = (uint32_t)q->count;
    frame.roulette_seed = q->seed;
    frame.bias = glbk__csm_bias(q->bias);
    result = glbk_buffer_update(ctx, &asker->frame, 0, sizeof frame, &frame);
    if (result == GLBK_OK)
        result = asker->asked.name ? glbk_buffer_update(ctx, &asker->asked, 0, 32 * q->count, words)
                                   : glbk__table_update(ctx, &asker->questions, 0, 2 * q->count, words);
    glbk_csm__free(&memory, words);
    return result;
}

GLBK_DEF glbk_result glbk_csm_ask_run(glbk_context *ctx, glbk_csm_asker *asker, const glbk_csm_maps *maps,
                                      uint32_t count)
{
    glbk_pass pass;
    glbk_program *program;
    glbk_result result;
    uint32_t groups = (count + 63) / 64;

    result = glbk__require_created(ctx, __func__, "asker", asker ? &asker->frame.name : NULL);
    if (result == GLBK_OK)
        result = glbk__require_created(ctx, __func__, "maps", maps ? &maps->blocks.name : NULL);
    if (result != GLBK_OK) return result;
    if (!count || count > asker->capacity)
        return glbk__refuse_range(ctx, count ? GLBK_ERR_LIMIT : GLBK_ERR_ARGUMENT, __func__, "count", count,
                                  1, asker->capacity);
    if (!asker->question) return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "asker", "has no questions yet");
    result = glbk__csm_ask_program(ctx, asker, maps, &program);
    if (result != GLBK_OK) return result;
    memset(&pass, 0, sizeof pass);
    if (!asker->asked.name) {
        pass.target = &asker->target;
        pass.viewport[2] = 1024;
        pass.viewport[3] = (int32_t)((count + 1023) / 1024);
        result = glbk_begin(ctx, &pass, program);
        if (result != GLBK_OK) return result;
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_questions, &asker->questions);
    }
    glbk_csm_bind(ctx, maps, NULL);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_csm_frame, &asker->frame);
    if (!asker->asked.name) {
        glbk_draw_screen(ctx);
        return GLBK_OK;
    }
    glbk_bind_storage(ctx, GLBK_SLOT_glbk_csm_asked, &asker->asked);
    glbk_bind_storage(ctx, GLBK_SLOT_glbk_csm_answers, &asker->answered);
    return glbk_dispatch(ctx, program, groups < 1024 ? groups : 1024, (groups + 1023) / 1024, 1);
}

GLBK_DEF glbk_result glbk_csm_ask_read(glbk_context *ctx, glbk_csm_asker *asker, uint32_t count,
                                       float *visible)
{
    uint32_t row[4 * 1024], done, n, i;
    glbk_result result = glbk__require_created(ctx, __func__, "asker", asker ? &asker->frame.name : NULL);

    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "visible", visible);
    if (result != GLBK_OK) return result;
    if (!count || count > asker->capacity)
        return glbk__refuse_range(ctx, count ? GLBK_ERR_LIMIT : GLBK_ERR_ARGUMENT, __func__, "count", count,
                                  1, asker->capacity);
    if (asker->asked.name) return glbk_buffer_read(ctx, &asker->answered, 0, 4 * (size_t)count, visible);
    for (done = 0; done < count && result == GLBK_OK; done += n) {
        n = count - done < 1024 ? count - done : 1024;
        result = glbk_target_read(ctx, &asker->target, 0, 0, done / 1024, n, 1, row);
        for (i = 0; i < n && result == GLBK_OK; i++) memcpy(visible + done + i, row + 4 * i, 4);
    }
    return result;
}

GLBK_DEF void glbk_csm_asker_free(glbk_context *ctx, glbk_csm_asker *asker)
{
    if (!asker) return;
    glbk__csm_programs_free(ctx, &asker->programs);
    glbk_target_free(ctx, &asker->target);
    glbk_texture_free(ctx, &asker->questions);
    glbk_texture_free(ctx, &asker->answers);
    glbk_buffer_free(ctx, &asker->frame);
    glbk_buffer_free(ctx, &asker->asked);
    glbk_buffer_free(ctx, &asker->answered);
    memset(asker, 0, sizeof *asker);
}

/* ==== src/gl_csm/lights.h ==== */

/* ---- csm: lights: what lightsampling.h's descs may say here ---- */

/* A light stands in a table as ten texels, then its texels of L, running sums and triangles
   (docs/gpu-layouts.md). */
enum { GLBK__CSM_LIGHT_HEAD = 10, GLBK__CSM_TEXTURED = 1, GLBK__CSM_ORTHOGONAL = 2, GLBK__CSM_LINEAR = 4,
       GLBK__CSM_ROUND = 8, GLBK__CSM_ROUND_SURFACE = 16, GLBK__CSM_OWN_EMISSION = 32 };

#define GLBK__PI 3.14159265358979324

/* Returns 1 if a light is an environment, as it is by default. */
static int glbk__csm_is_sky(const lsamp_light_desc *d)
{
    return d->kind == LSAMP_LIGHT_DEFAULT || d->kind == LSAMP_LIGHT_ENVIRONMENT;
}

/* Says how a refusal of a light is logged: to whom, by which public function, and where the light stands:
   "ARRAY[INDEX]", or "ARRAY" alone if the index is GLBK__NO_INDEX. */
typedef struct glbk__csm_logger {
    const glbk_context *ctx;
    const char         *function;
    const char         *array;
    size_t              index;
} glbk__csm_logger;

static glbk__csm_logger glbk__csm_logger_make(const glbk_context *ctx, const char *function,
                                              const char *array, size_t index)
{
    glbk__csm_logger log;
    log.ctx = ctx;
    log.function = function;
    log.array = array;
    log.index = index;
    return log;
}

/* Logs why a member is refused (".texels"), and returns 0. */
static int glbk__csm_refuse(const glbk__csm_logger *log, const char *member, const char *text)
{
    (void)glbk__refuse_element(log->ctx, GLBK_ERR_DESC, log->function, log->array, log->index, member, text);
    return 0;
}

/* Returns 1 if a number is in its range, else logs it and returns 0; wanted is the range in words. */
static int glbk__csm_in(const glbk__csm_logger *log, const char *member, double value, double low,
                        double high, const char *wanted)
{
    if (value >= low && value <= high) return 1;
    (void)glbk__refuse_element_value(log->ctx, GLBK_ERR_DESC, log->function, log->array, log->index, member,
                                     value, wanted);
    return 0;
}

/* Does what glbk__csm_in does, for three numbers. */
static int glbk__csm_in3(const glbk__csm_logger *log, const char *member, const float *v, double low,
                         double high, const char *wanted)
{
    return glbk__csm_in(log, member, (double)v[0], low, high, wanted) &&
           glbk__csm_in(log, member, (double)v[1], low, high, wanted) &&
           glbk__csm_in(log, member, (double)v[2], low, high, wanted);
}

/* Returns 1 if a vector is unit, as the field says: a length of 0.97 to 1.03. Else logs the length under the
   name of a member and returns 0. */
static int glbk__csm_unit(const glbk__csm_logger *log, const char *member, const float *v)
{
    const glbk_csm__v3 n = glbk_csm__v3_load(v);
    if (glbk_csm__is_unit2(glbk_csm__v3_dot(n, n))) return 1;
    return glbk__csm_in(log, member, (double)glbk_csm__v3_length(n), 1, 1, "0.97..1.03");
}

/* Returns 1 if the GPU knows lights of this kind, else logs it and returns 0. own: GLSL of the user's stands
   for functions. */
static int glbk__csm_kind_valid(const glbk__csm_logger *log, lsamp_light_kind kind, int own)
{
    if (kind == LSAMP_LIGHT_CALLBACK && !own)
        return glbk__csm_refuse(log, ".kind", "is a callback, without own");
    return glbk__csm_in(log, ".kind", (double)kind, 0, LSAMP_LIGHT_COUNT - 1, "a LSAMP_LIGHT_...");
}

/* ---- csm: meshes that emit ---- */

/* Returns how many corners triangles have; glbk__csm_corner_index returns the vertex of one of them. */
static size_t glbk__csm_corner_count(const lsamp_mesh *m)
{
    return m->indices || m->indices16 ? m->index_count : m->vertex_count;
}

static uint32_t glbk__csm_corner_index(const lsamp_mesh *m, size_t i)
{
    return m->indices ? m->indices[i] : m->indices16 ? m->indices16[i] : (uint32_t)i;
}

static glbk_csm__v3 glbk__csm_corner(const lsamp_mesh *m, size_t i)
{
    float p[3];
    memcpy(p,
           (const char *)m->positions +
               (m->vertex_stride ? m->vertex_stride : 12) * glbk__csm_corner_index(m, i),
           sizeof p);
    return glbk_csm__v3_load(p);
}

/* Logs what a member of the mesh is, and returns the result. */
static glbk_result glbk__csm_refuse_mesh(const glbk__csm_logger *log, glbk_result result, const char *member,
                                         const char *text)
{
    return glbk__refuse_element(log->ctx, result, log->function, log->array, log->index, member, text);
}

/* Logs that a number of the mesh is out of its range, and returns the result. */
static glbk_result glbk__csm_refuse_number(const glbk__csm_logger *log, glbk_result result,
                                           const char *member, size_t value, const char *wanted)
{
    return glbk__refuse_element_value(log->ctx, result, log->function, log->array, log->index, member,
                                      (double)value, wanted);
}

/* Checks that a mesh can emit. */
static glbk_result glbk__csm_check_mesh(const glbk__csm_logger *log, const lsamp_mesh *m)
{
    const glbk_result bad = GLBK_ERR_ARGUMENT;
    char field[GLBK__ELEMENT_ROOM];
    size_t i, count;
    if (!m) return glbk__csm_refuse_mesh(log, GLBK_ERR_DESC, ".mesh", "is NULL");
    if (!m->positions) return glbk__csm_refuse_mesh(log, bad, ".mesh->positions", "is NULL");
    if (!m->vertex_count) return glbk__csm_refuse_mesh(log, bad, ".mesh->vertex_count", "is 0");
    if (m->indices && m->indices16)
        return glbk__csm_refuse_mesh(log, bad, ".mesh->indices", "and indices16 are given; one must be NULL");
    if (m->vertex_stride % 4 || (m->vertex_stride && m->vertex_stride < 12))
        return glbk__csm_refuse_number(log, bad, ".mesh->vertex_stride", m->vertex_stride,
                                       "0 or a multiple of 4, >= 12");
    count = glbk__csm_corner_count(m);
    if (!count || count % 3)
        return glbk__csm_refuse_number(log, bad, ".mesh's corners", count, "a multiple of 3, above 0");
    if (count / 3 >= (size_t)1 << 26)
        return glbk__csm_refuse_number(log, GLBK_ERR_LIMIT, ".mesh's corners", count, "below 3 * 2^26");
    for (i = 0; (m->indices || m->indices16) && i < count; i++) {
        if (glbk__csm_corner_index(m, i) < m->vertex_count) continue;
        glbk__name_element(field, log->array, log->index, ".mesh");
        return glbk__refuse_index(log->ctx, GLBK_ERR_INPUT, log->function, field, i,
                                  glbk__csm_corner_index(m, i), m->vertex_count);
    }
    return GLBK_OK;
}

/* ---- csm: what a light may be ---- */

/* Returns 1 if the texture of a light is right for its kind, else logs why not and returns 0. So do
   glbk__csm_shape_valid, of its shape, and glbk__csm_light_valid, of all of it. */
static int glbk__csm_texels_valid(const glbk__csm_logger *log, const lsamp_light_desc *d)
{
    const int hard = d->kind == LSAMP_LIGHT_SUN || d->kind == LSAMP_LIGHT_POINT ||
                     d->kind == LSAMP_LIGHT_SPOT || d->kind == LSAMP_LIGHT_MESH;
    if (!d->texels && (d->width || d->height || d->frame_count > 1))
        return glbk__csm_refuse(log, ".texels", "is NULL, but there are a size or frames");
    if (!d->texels) return 1;
    if (hard) return glbk__csm_refuse(log, ".texels", "are not for this kind of light");
    return glbk__csm_in(log, ".width", d->width, 1, 65536, "1..65536") &&
           glbk__csm_in(log, ".height", d->height, 1, d->kind == LSAMP_LIGHT_LINE ? 1 : 65536,
                        d->kind == LSAMP_LIGHT_LINE ? "1" : "1..65536") &&
           glbk__csm_in(log, ".frame_count", d->frame_count, 0, 16777216, "0..2^24");
}

static int glbk__csm_shape_valid(const glbk__csm_logger *log, const lsamp_light_desc *d)
{
    static const char lengths[] = "1e-18..1e18", places[] = "-1e18..1e18";
    static const char direction[] = ".direction: its length";
    const double least = (double)1e-18f, big = (double)1e18f;
    float area;

    switch (d->kind) {
    case LSAMP_LIGHT_SUN: return glbk__csm_unit(log, direction, d->direction);
    case LSAMP_LIGHT_POINT: return 1;
    case LSAMP_LIGHT_SPOT:
        return glbk__csm_unit(log, direction, d->direction) &&
               glbk__csm_in(log, ".cone_half_angle", (double)d->cone_half_angle, (double)5e-7f,
                            (double)3.14159274f, "5e-7..pi");
    case LSAMP_LIGHT_LINE:
        if (d->u[0] == 0 && d->u[1] == 0 && d->u[2] == 0) return glbk__csm_refuse(log, ".u", "is 0 0 0");
        return glbk__csm_in3(log, ".u", d->u, -big, big, places) &&
               glbk__csm_in(log, ".radius", (double)d->radius, least, big, lengths);
    case LSAMP_LIGHT_RECTANGLE:
        if (!glbk__csm_in3(log, ".u", d->u, -big, big, places) ||
            !glbk__csm_in3(log, ".v", d->v, -big, big, places))
            return 0;
        area = glbk_csm__v3_length(glbk_csm__v3_cross(glbk_csm__v3_load(d->u), glbk_csm__v3_load(d->v)));
        if (area > 0 && glbk_csm__finite(area)) return 1;
        return glbk__csm_in(log, "'s area, of u and v,", (double)area, -1, -1, "above 0 and finite");
    case LSAMP_LIGHT_DISC:
        return glbk__csm_unit(log, direction, d->direction) &&
               glbk__csm_in(log, ".radius", (double)d->radius, least, big, lengths);
    case LSAMP_LIGHT_SPHERE: return glbk__csm_in(log, ".radius", (double)d->radius, least, big, lengths);
    case LSAMP_LIGHT_CALLBACK:
    case LSAMP_LIGHT_MESH: return 1;
    case LSAMP_LIGHT_SURFACE:
        if (!d->surface || !d->surface->points)
            return glbk__csm_refuse(log, ".surface", "is NULL, or has no points");
        return glbk__csm_in(log, ".surface->width", d->surface->width, 2, 4096, "2..4096") &&
               glbk__csm_in(log, ".surface->height", d->surface->height, 2, 4096, "2..4096");
    default:
        return glbk__csm_in(log, ".cosine_power", (double)d->cosine_power, 0, 0, "0");
    }
}

static int glbk__csm_light_valid(const glbk__csm_logger *log, const lsamp_light_desc *d, int own)
{
    static const struct { uint16_t at, count; float low, high; char member[20], wanted[12]; } numbers[] = {
        { offsetof(lsamp_light_desc, radiance), 3, 0, 1e30f, ".radiance", "0..1e30" },
        { offsetof(lsamp_light_desc, cosine_power), 1, 0, 1e5f, ".cosine_power", "0..100000" },
        { offsetof(lsamp_light_desc, rotation), 1, -1000, 1000, ".rotation", "-1000..1000" },
        { offsetof(lsamp_light_desc, time), 1, -1e9f, 1e9f, ".time", "-1e9..1e9" },
        { offsetof(lsamp_light_desc, frames_per_second), 1, 0, 1e6f, ".frames_per_second", "0..1e6" },
        { offsetof(lsamp_light_desc, position), 3, -1e18f, 1e18f, ".position", "-1e18..1e18" }
    };
    uint32_t i, k;

    if (d->emission_fn && (!own || (d->kind >= LSAMP_LIGHT_SUN && d->kind <= LSAMP_LIGHT_SPOT)))
        return glbk__csm_refuse(log, ".emission_fn", "is set without own, or for a sun, point or spot");
    if (!glbk__csm_kind_valid(log, d->kind, own) ||
        !glbk__csm_in(log, ".filter", (double)d->filter, 0, LSAMP_TEXELS_COUNT - 1, "a LSAMP_TEXELS_..."))
        return 0;
    for (i = 0; i < sizeof numbers / sizeof *numbers; i++)
        for (k = 0; k < numbers[i].count; k++) {
            float value;
            memcpy(&value, (const char *)d + numbers[i].at + 4 * k, 4);
            if (!glbk__csm_in(log, numbers[i].member, (double)value, (double)numbers[i].low,
                              (double)numbers[i].high, numbers[i].wanted))
                return 0;
        }
    return glbk__csm_texels_valid(log, d) && glbk__csm_shape_valid(log, d);
}

/* Checks a light and its mesh, whose faults are not those of the desc, and counts the light's texels. */
static glbk_result glbk__csm_count_texels(const glbk__csm_logger *log, const lsamp_light_desc *d, int own,
                                          size_t *texels)
{
    const int has_mesh = d->kind == LSAMP_LIGHT_MESH;
    const glbk_result result = !glbk__csm_light_valid(log, d, own) ? GLBK_ERR_DESC
                               : has_mesh                     ? glbk__csm_check_mesh(log, d->mesh)
                                                              : GLBK_OK;
    if (result != GLBK_OK) return result;
    if (d->texels && (double)d->width * d->height > 134217728)
        return glbk__refuse_element_value(log->ctx, GLBK_ERR_LIMIT, log->function, log->array, log->index,
                                          ".width * height", (double)d->width * d->height, "2^27 at most");
    *texels = GLBK__CSM_LIGHT_HEAD;
    if (has_mesh) *texels += glbk__csm_corner_count(d->mesh);
    else if (d->texels) *texels += 2 * (size_t)d->width * d->height + d->height;
    else if (glbk__csm_is_sky(d)) *texels += 3;
    if (d->kind == LSAMP_LIGHT_SURFACE) *texels += (size_t)d->surface->width * d->surface->height;
    return GLBK_OK;
}

GLBK_DEF size_t glbk_csm_light_texels(const lsamp_light_desc *d)
{
    glbk_context none;
    glbk__csm_logger log;
    size_t texels = 0;
    memset(&none, 0, sizeof none);
    log = glbk__csm_logger_make(&none, __func__, "desc", GLBK__NO_INDEX);
    return d && glbk__csm_count_texels(&log, d, 1, &texels) == GLBK_OK ? texels : 0;
}

/* ==== src/gl_csm/light_tables.h ==== */

/* ---- csm: lights as they stand in a table ---- */

/* Writes a texel of four floats. */
static void glbk__csm_put(uint32_t *words, uint32_t texel, glbk_csm__v3 v, float w)
{
    float f[4];
    glbk_csm__v3_store(f, v);
    f[3] = w;
    memcpy(words + 4 * (size_t)texel, f, sizeof f);
}

/* Makes running sums, divided by the total, of `count` weights that stand in w of the texels at `sums`, and
   writes for each fraction i / count of the total where a search for it begins and ends. Returns the sum of
   the weights. */
static double glbk__csm_sums(uint32_t *sums, uint32_t count, double total)
{
    double sum = 0;
    float before, after = 0, weight;
    uint32_t i, lo = 0;

    for (i = 0; i < count; i++) {
        memcpy(&weight, sums + 4 * (size_t)i + 3, 4);
        sum += (double)weight;
        before = after;
        after = total > 0 ? i + 1 < count ? (float)(sum / total) : 1.0f : 0.0f;
        memcpy(sums + 4 * (size_t)i, &before, 4);
        memcpy(sums + 4 * (size_t)i + 1, &after, 4);
    }
    for (i = 0; i < count; i++) {
        memcpy(&after, sums + 4 * (size_t)lo + 1, 4);
        while (lo + 1 < count && (double)after <= (double)i / count) {
            lo++;
            memcpy(&after, sums + 4 * (size_t)lo + 1, 4);
        }
        sums[4 * (size_t)i + 2] = lo;
        sums[4 * (size_t)i + 3] = count;
        if (i) sums[4 * (size_t)i - 1] = lo + 1;
    }
    return sum;
}

/* The two frames of a video between which desc->time lies, as lightsampling.h has them. */
typedef struct glbk__csm_film {
    const float *first;
    const float *second;
    float        blend;             /* share of the second, 0..1 */
} glbk__csm_film;

static glbk__csm_film glbk__csm_film_of(const lsamp_light_desc *d)
{
    const uint32_t frames = d->frame_count ? d->frame_count : 1;
    const size_t count = 3 * (size_t)d->width * d->height;
    double t = (double)d->time * (d->frames_per_second > 0 ? (double)d->frames_per_second : 30.0);
    glbk__csm_film film;
    uint32_t at;

    if (d->loop) t -= floor(t / frames) * frames;
    t = t > 0 ? t : 0;
    if (!d->loop && t > frames - 1.0) t = frames - 1.0;
    at = t < frames ? (uint32_t)t : 0;
    film.blend = t < frames ? (float)(t - at) : 0;
    film.first = d->texels + at * count;
    film.second = d->texels + (at + 1) % frames * count;
    return film;
}

/* Returns number i of the frame that is blended of the two; what is not finite or negative counts as 0. */
static float glbk__csm_film_at(const glbk__csm_film *film, size_t i)
{
    float a = film->first[i], b = film->blend > 0 ? film->second[i] : 0;
    a = glbk_csm__finite(a) && a > 0 ? a : 0;
    b = glbk_csm__finite(b) && b > 0 ? b : 0;
    return a * (1 - film->blend) + b * film->blend;
}

/* Returns the density of samples of texel x, y of those that stand in a table, but for a factor that all have
   in common: tint times the mean of L over the texel. Where L is linear between centres, that mean is
   (a + 6 b + c) / 8 along each coordinate, as in lightsampling.h. */
static float glbk__csm_density(const uint32_t *texels, uint32_t flags, const uint32_t side[2], uint32_t x,
                               uint32_t y, glbk_csm__v3 tint)
{
    static const float weights[2][3] = { { 0, 1, 0 }, { 0.125f, 0.75f, 0.125f } };
    const float *weight = weights[(flags & GLBK__CSM_LINEAR) != 0];
    const uint32_t w = side[0];
    float sum = 0, rgb[3];
    uint32_t i, j, column, row;

    for (j = 0; j < 3; j++)
        for (i = 0; i < 3; i++) {
            column = x + i ? x + i - 1 : flags & GLBK__CSM_ROUND ? w - 1 : 0;
            if (column == w) column = flags & GLBK__CSM_ROUND ? 0 : x;
            row = y + j ? y + j - 1 : 0;
            if (row == side[1]) row = y;
            memcpy(rgb, texels + 4 * ((size_t)row * w + column), sizeof rgb);
            sum += glbk_csm__v3_dot(glbk_csm__v3_load(rgb), tint) * weight[i] * weight[j];
        }
    return sum;
}

/* Writes the texels of L, with their densities in w, and the running sums of each row and of all rows. */
static void glbk__csm_texture(const lsamp_light_desc *d, uint32_t flags, uint32_t *words, uint32_t w,
                              uint32_t h)
{
    const uint32_t side[2] = { w, h };
    const glbk__csm_film none = { NULL, NULL, 0 }, film = d->texels ? glbk__csm_film_of(d) : none;
    uint32_t *texels = words + 4 * GLBK__CSM_LIGHT_HEAD, *rows = texels + 4 * (size_t)w * h;
    uint32_t *row, x, y;
    float top = d->radiance[0] > d->radiance[1] ? d->radiance[0] : d->radiance[1], value;
    glbk_csm__v3 tint = glbk_csm__v3_make(1, 1, 1);
    double total = 0, sum, weight;
    size_t i;

    top = top > d->radiance[2] ? top : d->radiance[2];
    if (top > 0) tint = glbk_csm__v3_make(d->radiance[0] / top, d->radiance[1] / top, d->radiance[2] / top);
    tint = glbk_csm__v3_scale(tint, 1.0f / 3.0f);
    for (i = 0; i < 3 * (size_t)w * h; i++) {
        value = d->texels ? glbk__csm_film_at(&film, i) : 1;
        memcpy(texels + i / 3 * 4 + i % 3, &value, 4);
    }
    for (y = 0; y < h; y++) {
        row = rows + 4 * ((size_t)h + (size_t)y * w);
        sum = 0;
        for (x = 0; x < w; x++) {
            value = glbk__csm_density(texels, flags, side, x, y, tint);
            memcpy(texels + 4 * ((size_t)y * w + x) + 3, &value, 4);
            memcpy(row + 4 * (size_t)x + 3, &value, 4);
            sum += (double)value;
        }
        glbk__csm_sums(row, w, sum);
        /* The weight of a row of the sky is its solid angle, cos a - cos b, here without a loss of digits. */
        weight = glbk__csm_is_sky(d)
                     ? 2 * sin(GLBK__PI * (2.0 * y + 1) / (2.0 * h)) * sin(GLBK__PI / (2.0 * h))
                     : 1;
        value = (float)(sum * weight);
        memcpy(rows + 4 * (size_t)y + 3, &value, 4);
        total += (double)value;
    }
    glbk__csm_sums(rows, h, total);
    if (!(total > 0)) return;                   /* a black light: all densities are 0 already */
    weight = glbk__csm_is_sky(d) ? w / (2 * GLBK__PI * total) : (double)w * h / total;
    for (i = 0; i < (size_t)w * h; i++) {
        memcpy(&value, texels + 4 * i + 3, 4);
        value *= (float)weight;
        memcpy(texels + 4 * i + 3, &value, 4);
    }
}

/* Writes the corners of all triangles, and the share of all area up to the end of each. Returns the area.
   Triangles that are not finite or have no area get no share. */
static float glbk__csm_triangles(const lsamp_mesh *m, uint32_t *texels)
{
    const uint32_t count = (uint32_t)(glbk__csm_corner_count(m) / 3);
    double total = 0, sum = 0;
    uint32_t i, pass;

    for (pass = 0; pass < 2; pass++)
        for (i = 0; i < count; i++) {
            glbk_csm__v3 a = glbk__csm_corner(m, 3 * (size_t)i), b = glbk__csm_corner(m, 3 * (size_t)i + 1);
            glbk_csm__v3 c = glbk__csm_corner(m, 3 * (size_t)i + 2);
            glbk_csm__v3 twice = glbk_csm__v3_cross(glbk_csm__v3_sub(b, a), glbk_csm__v3_sub(c, a));
            double area = 0.5 * (double)glbk_csm__v3_length(twice);
            if (!(area > 0 && area < 1e30)) area = 0;
            if (!pass) {
                total += area;
                continue;
            }
            sum += area;
            glbk__csm_put(texels, 3 * i, a, (float)(sum / total));
            glbk__csm_put(texels, 3 * i + 1, b, 0);
            glbk__csm_put(texels, 3 * i + 2, c, 0);
        }
    return (float)total;
}

/* Writes the points of a surface. */
static void glbk__csm_surface(const lsamp_surface *s, uint32_t *texels)
{
    uint32_t i;
    for (i = 0; i < s->width * s->height; i++)
        glbk__csm_put(texels, i, glbk_csm__v3_load(s->points + 3 * (size_t)i), 0);
}

/* What follows the first two texels of a light, as docs/gpu-layouts.md says. */
typedef struct glbk__csm_light_head {
    float position[3], radius;
    float n[3], lx;
    float ex[3], ly;
    float ey[3], area;
    float radiance[3], cos_cone;
    float none[3], turn;
    float u[3], cosine_power;
    float v[4];
} glbk__csm_light_head;

/* Writes what the shape of a light says to its head, and returns whether it is a rectangle with right
   angles. */
static int glbk__csm_shape_write(const lsamp_light_desc *d, glbk__csm_light_head *out)
{
    const glbk_csm__v3 u = glbk_csm__v3_load(d->u), v = glbk_csm__v3_load(d->v);
    glbk_csm__v3 n = glbk_csm__v3_load(d->direction), x = glbk_csm__v3_make(0, 0, 0), y = x;
    float uv, area = 1;

    if (d->kind == LSAMP_LIGHT_LINE) n = u;
    if (d->kind == LSAMP_LIGHT_RECTANGLE) n = glbk_csm__v3_cross(u, v);
    uv = glbk_csm__v3_length(n);
    n = glbk_csm__v3_normalize(n);
    out->lx = glbk_csm__v3_length(u);
    out->ly = glbk_csm__v3_length(v);
    if (d->kind == LSAMP_LIGHT_DISC) glbk_csm__v3_basis(n, &x, &y);
    if (d->kind == LSAMP_LIGHT_DISC || d->kind == LSAMP_LIGHT_SPHERE)
        area = (d->kind == LSAMP_LIGHT_DISC ? 1 : 4) * (float)GLBK__PI * d->radius * d->radius;
    if (d->kind == LSAMP_LIGHT_RECTANGLE) {
        area = uv;
        x = glbk_csm__v3_scale(glbk_csm__v3_cross(v, n), 1.0f / area);
        y = glbk_csm__v3_scale(glbk_csm__v3_cross(n, u), 1.0f / area);
    }
    glbk_csm__v3_store(out->n, n);
    glbk_csm__v3_store(out->ex, x);
    glbk_csm__v3_store(out->ey, y);
    out->area = area;
    uv = glbk_csm__v3_dot(u, v);
    return d->kind == LSAMP_LIGHT_RECTANGLE && (uv < 0 ? -uv : uv) <= 1e-5f * area;
}

/* Writes a light that is valid. */
static glbk_result glbk__csm_light_write(const glbk__csm_logger *log, const lsamp_light_desc *d,
                                         uint32_t *words)
{
    const int sky = glbk__csm_is_sky(d);
    const uint32_t w = d->texels ? d->width : 1, h = d->texels ? d->height : 1;
    glbk__csm_light_head head;
    uint32_t flags;

    memset(&head, 0, sizeof head);
    flags = glbk__csm_shape_write(d, &head) ? GLBK__CSM_ORTHOGONAL : 0;
    if (d->filter == LSAMP_TEXELS_LINEAR) flags |= GLBK__CSM_LINEAR;
    if (sky || d->kind == LSAMP_LIGHT_SPHERE) flags |= GLBK__CSM_ROUND;
    if (d->emission_fn) flags |= GLBK__CSM_OWN_EMISSION;
    if (d->texels || sky) flags |= GLBK__CSM_TEXTURED;
    words[4] = words[6] = GLBK__CSM_LIGHT_HEAD;
    words[5] = GLBK__CSM_LIGHT_HEAD + w * h;
    words[7] = 0;
    if (d->kind == LSAMP_LIGHT_SURFACE) {
        if (d->surface->round) flags |= GLBK__CSM_ROUND | GLBK__CSM_ROUND_SURFACE;
        if (d->texels) words[6] = words[5] + w * h + h;
        words[7] = d->surface->width | d->surface->height << 16;
        glbk__csm_surface(d->surface, words + 4 * (size_t)words[6]);
    }
    if (flags & GLBK__CSM_TEXTURED) glbk__csm_texture(d, flags, words, w, h);
    if (d->kind == LSAMP_LIGHT_MESH) {
        head.area = glbk__csm_triangles(d->mesh, words + 4 * GLBK__CSM_LIGHT_HEAD);
        words[7] = (uint32_t)(glbk__csm_corner_count(d->mesh) / 3);
    }
    if (!(head.area > 0)) {
        (void)glbk__csm_refuse(log, ".mesh", "has no area");
        return GLBK_ERR_INPUT;
    }
    words[0] = sky ? (uint32_t)LSAMP_LIGHT_ENVIRONMENT : (uint32_t)d->kind;
    words[1] = w;
    words[2] = h;
    words[3] = flags;
    memcpy(head.position, d->position, sizeof head.position);
    memcpy(head.radiance, d->radiance, sizeof head.radiance);
    memcpy(head.u, d->u, sizeof head.u);
    memcpy(head.v, d->v, sizeof d->v);
    head.radius = d->radius;
    head.cos_cone = (float)cos((double)d->cone_half_angle);
    head.turn = (float)((double)d->rotation / (2 * GLBK__PI));
    head.cosine_power = d->cosine_power;
    memcpy(words + 8, &head, sizeof head);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_csm_light_write(const lsamp_light_desc *d, uint32_t *words)
{
    glbk_context none;
    glbk__csm_logger log;
    size_t texels;
    glbk_result result;
    if (!d) return GLBK_ERR_ARGUMENT;
    memset(&none, 0, sizeof none);
    none.system.log = d->system.log;
    none.system.user = d->system.user;
    if (!words) return glbk__require(&none, __func__, "words", words);
    log = glbk__csm_logger_make(&none, __func__, "desc", GLBK__NO_INDEX);
    result = glbk__csm_count_texels(&log, d, 1, &texels);
    return result == GLBK_OK ? glbk__csm_light_write(&log, d, words) : result;
}

/* Writes two texels for each lobe. */
static void glbk__csm_write_lobes(const glbk_csm_lights_desc *d, uint32_t *words)
{
    uint32_t i;
    for (i = 0; i < d->lobe_count; i++) {
        glbk__csm_put(words, 2 * i, glbk_csm__v3_load(d->lobes[i].axis), d->lobes[i].exponent);
        glbk__csm_put(words, 2 * i + 1, glbk_csm__v3_load(d->lobes[i].scale), 0);
    }
}

/* Checks what glbk_csm_lights_create is given, except the lights themselves. */
static glbk_result glbk__csm_check_lights(const glbk_context *ctx, const glbk_csm_lights_desc *d,
                                          const uint32_t *starts)
{
    static const char function[] = "glbk_csm_lights_create";
    glbk_result result = glbk__require(ctx, function, "desc", d);
    if (result == GLBK_OK && d->light_count) result = glbk__require(ctx, function, "starts", starts);
    if (result != GLBK_OK) return result;
    if (d->light_count && !d->lights)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, "desc.lights", "is NULL");
    if (d->lobe_count && !d->lobes)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, "desc.lobes", "is NULL");
    if (d->lobe_count > (uint32_t)1 << 20)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "desc.lobe_count", d->lobe_count, 0, 1048576);
    if ((d->patterns != NULL) != (d->pattern_length != 0) || d->pattern_length > 65536)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.pattern_length", d->pattern_length,
                                  "1..65536 with patterns, 0 without");
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_csm_lights_create(glbk_context *ctx, const glbk_csm_lights_desc *d,
                                            uint32_t *starts, glbk_csm_lights *out)
{
    glbk_csm__allocator memory;
    glbk__csm_logger log;
    size_t texels, one, patterns;
    uint32_t i, *words;
    glbk_result result;

    if (out) memset(out, 0, sizeof *out);
    result = glbk__require(ctx, __func__, "out", out);
    if (result == GLBK_OK) result = glbk__csm_check_lights(ctx, d, starts);
    if (result != GLBK_OK) return result;
    log = glbk__csm_logger_make(ctx, __func__, "desc.lights", 0);
    texels = 2 * (size_t)d->lobe_count;
    patterns = 128 * (size_t)d->pattern_length;
    for (i = 0; i < d->light_count; i++) {
        log.index = i;
        result = glbk__csm_count_texels(&log, &d->lights[i], d->own, &one);
        if (result != GLBK_OK) return result;
        starts[i] = (uint32_t)texels;
        texels += one;
        if (texels > (size_t)1 << 28)
            return glbk__refuse_element_value(ctx, GLBK_ERR_LIMIT, __func__, "desc.lights", i,
                                              " and those before: their texels", (double)texels,
                                              "at most 2^28");
    }
    out->lobe_count = d->lobe_count;
    out->own = d->own;
    out->patterns_at = (uint32_t)texels;
    out->pattern_length = d->pattern_length;
    texels += patterns + 1;
    memory = glbk_csm__memory(ctx);
    words = (uint32_t *)glbk_csm__alloc_array(&memory, texels, 16);
    if (!words) result = GLBK_ERR_ALLOC;
    else {
        memset(words, 0, texels * 16);
        glbk__csm_write_lobes(d, words);
        for (i = 0; i < d->light_count && result == GLBK_OK; i++) {
            log.index = i;
            result = glbk__csm_light_write(&log, &d->lights[i], words + 4 * (size_t)starts[i]);
        }
        if (patterns) memcpy(words + 4 * (size_t)out->patterns_at, d->patterns, patterns * 16);
    }
    if (result == GLBK_OK)
        result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, words, texels, &out->texels);
    glbk_csm__free(&memory, words);
    if (result != GLBK_OK) memset(out, 0, sizeof *out);
    return result;
}

GLBK_DEF glbk_result glbk_csm_lights_update(glbk_context *ctx, glbk_csm_lights *lights, uint32_t start,
                                            const lsamp_light_desc *desc)
{
    glbk_csm__allocator memory;
    glbk__csm_logger log;
    size_t texels;
    uint32_t *words;
    glbk_result result;

    result = glbk__require_created(ctx, __func__, "lights", lights ? &lights->texels.name : NULL);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "desc", desc);
    if (result != GLBK_OK) return result;
    log = glbk__csm_logger_make(ctx, __func__, "desc", GLBK__NO_INDEX);
    result = glbk__csm_count_texels(&log, desc, lights->own, &texels);
    if (result != GLBK_OK) return result;
    if (start < 2 * lights->lobe_count || start > lights->patterns_at || texels > lights->patterns_at - start)
        return glbk__refuse_value(ctx, GLBK_ERR_ARGUMENT, __func__, "start", start,
                                  "that of a light with as many texels");
    memory = glbk_csm__memory(ctx);
    words = (uint32_t *)glbk_csm__alloc_array(&memory, texels, 16);
    if (!words) return GLBK_ERR_ALLOC;
    result = glbk__csm_light_write(&log, desc, words);
    if (result == GLBK_OK) result = glbk__table_update(ctx, &lights->texels, start, texels, words);
    glbk_csm__free(&memory, words);
    return result;
}

GLBK_DEF void glbk_csm_lights_free(glbk_context *ctx, glbk_csm_lights *lights)
{
    if (!lights) return;
    glbk_texture_free(ctx, &lights->texels);
    memset(lights, 0, sizeof *lights);
}

/* ==== src/gl_csm/renderer.h ==== */

/* ---- csm: the renderer: samples of lights, summed over frames ---- */

/* Returns the kind of a light with the default resolved. */
static uint32_t glbk__csm_shape_of(const glbk_csm_use *u)
{
    return u->kind == LSAMP_LIGHT_DEFAULT ? (uint32_t)LSAMP_LIGHT_ENVIRONMENT : (uint32_t)u->kind;
}

/* Finds or compiles the program for a combination of shape, ask, filter and defines of maps. */
static glbk_result glbk__csm_shade_program(glbk_context *ctx, const char *function, glbk_csm_renderer *r,
                                           const glbk_csm_use *use, uint32_t filter, glbk_program **out)
{
    char defines[] = "CSM_ASK=0 CSM_FILTER=0 COHSM_LOBES=1 CSM_SHAPE=10 CSM_PATTERNS COHSM_OWN_LIGHT";
    const char *texts[2];
    uint32_t shape = glbk__csm_shape_of(use), ask = (uint32_t)use->ask;
    texts[0] = defines;
    texts[1] = r->light;
    defines[8] = (char)('0' + ask);
    defines[21] = (char)('0' + filter);
    defines[35] = (char)('0' + r->lobe_count);
    defines[48] = (char)('0' + shape % 10);
    if (shape < 10) {
        defines[47] = defines[48];
        defines[48] = ' ';
    }
    if (!r->patterns) memset(defines + 50, ' ', 12);
    if (!r->light) defines[62] = 0;
    return glbk__csm_program(ctx, function, &r->shade, shape * 16 + ask * 4 + filter,
                             r->compute ? "csm_shade.comp" : "csm_shade.frag", texts, use->maps, out);
}

GLBK_DEF glbk_result glbk_csm_renderer_create(glbk_context *ctx, const glbk_csm_renderer_desc *d,
                                              glbk_csm_renderer *out)
{
    glbk_result result;

    if (out) memset(out, 0, sizeof *out);
    result = glbk__require(ctx, __func__, "out", out);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "desc", d);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "desc.width", d->width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "desc.height", d->height);
    if (result != GLBK_OK) return result;
    if (d->lobe_count > LSAMP_MAX_LOBES)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, __func__, "desc.lobe_count", d->lobe_count, 0,
                                 LSAMP_MAX_LOBES);
    out->width = d->width;
    out->height = d->height;
    out->compute = ctx->compute;
    out->lobe_count = d->lobe_count ? d->lobe_count : 1;
    out->patterns = d->patterns != 0;
    out->light = d->light;
    result = glbk__gbuffer_program(ctx, glbk_csm_part(), "csm_resolve.frag", NULL, &out->resolve);
    if (result == GLBK_OK)
        result = glbk__sums_create(ctx, out->compute, d->width, d->height, out->sums, out->targets);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_csm_frame), NULL, &out->frame);
    if (result != GLBK_OK) glbk_csm_renderer_free(ctx, out);
    return result;
}

GLBK_DEF glbk_result glbk_csm_renderer_resize(glbk_context *ctx, glbk_csm_renderer *r, uint32_t width,
                                              uint32_t height)
{
    glbk_result result =
        glbk__require_created(ctx, __func__, "renderer", r ? &r->targets[0].name : NULL);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "width", width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "height", height);
    if (result != GLBK_OK) return result;
    glbk__sums_free(ctx, r->sums, r->targets);
    glbk_csm_reset(r);
    r->width = width;
    r->height = height;
    result = glbk__sums_create(ctx, r->compute, width, height, r->sums, r->targets);
    if (result != GLBK_OK) glbk_csm_renderer_free(ctx, r);
    return result;
}

GLBK_DEF void glbk_csm_renderer_free(glbk_context *ctx, glbk_csm_renderer *r)
{
    if (!r) return;
    glbk__csm_programs_free(ctx, &r->shade);
    glbk_program_free(ctx, &r->resolve);
    glbk__sums_free(ctx, r->sums, r->targets);
    glbk_buffer_free(ctx, &r->frame);
    memset(r, 0, sizeof *r);
}

/* Checks light i of a frame. */
static glbk_result glbk__csm_check_use(const glbk_context *ctx, const char *function,
                                       const glbk_csm_renderer *r, const glbk_csm_frame_desc *d, size_t i)
{
    const glbk_csm_use *u = &d->uses[i];
    const glbk__csm_logger log = glbk__csm_logger_make(ctx, function, "desc.uses", i);
    if (!u->maps || !u->maps->blocks.name) {
        (void)glbk__csm_refuse(&log, ".maps", u->maps ? "was not created" : "is NULL");
        return GLBK_ERR_DESC;
    }
    if (!glbk__csm_in(&log, ".ask", (double)u->ask, 0, COHSM_LIGHT_COUNT - 1, "a COHSM_LIGHT_...") ||
        !glbk__csm_kind_valid(&log, u->kind, r->light != NULL) ||
        !glbk__csm_in(&log, ".sample_count", u->sample_count, 1, 65536, "1..65536") ||
        !glbk__csm_in(&log, ".start", u->start, 2.0 * d->lights->lobe_count, d->lights->patterns_at - 1.0,
                      "one that glbk_csm_lights_create wrote"))
        return GLBK_ERR_DESC;
    if (r->patterns && !glbk__csm_in(&log, ".sample_count", u->sample_count, d->lights->pattern_length,
                                     d->lights->pattern_length, "the length of the patterns"))
        return GLBK_ERR_MISMATCH;
    return GLBK_OK;
}

/* Checks the desc of a frame. */
static glbk_result glbk__csm_check_frame(const glbk_context *ctx, const char *function,
                                         const glbk_csm_renderer *r, const glbk_csm_frame_desc *d)
{
    const glbk__csm_logger log = glbk__csm_logger_make(ctx, function, "desc", GLBK__NO_INDEX);
    glbk__csm_logger planes = glbk__csm_logger_make(ctx, function, "desc.planes", 0);
    glbk_result result = glbk__require_created(ctx, function, "renderer", r ? &r->targets[0].name : NULL);
    uint32_t i;

    if (result == GLBK_OK) result = glbk__require(ctx, function, "desc", d);
    if (result != GLBK_OK) return result;
    if (!d->lights || !d->lights->texels.name) {
        (void)glbk__csm_refuse(&log, ".lights", d->lights ? "was not created" : "is NULL");
        return GLBK_ERR_DESC;
    }
    if (d->lights->own && !r->light)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, "desc.lights",
                            "were made with own, but the renderer without light, the GLSL for them");
    if ((d->use_count && !d->uses && !glbk__csm_refuse(&log, ".uses", "is NULL")) ||
        !glbk__csm_in(&log, ".plane_count", d->plane_count, 0, GLBK_CSM_MAX_PLANES, "0..8") ||
        !glbk__csm_in(&log, ".sampling", (double)d->sampling, 0, LSAMP_SAMPLING_COUNT - 1,
                      "a LSAMP_SAMPLING_...") ||
        !glbk__csm_in(&log, ".filter", (double)d->filter, 0, COHSM_FILTER_COUNT - 1, "a COHSM_FILTER_...") ||
        !glbk__csm_in(&log, ".bias", (double)d->bias, -1e39, 1e39, "finite") ||
        !glbk__csm_in(&log, ".offset", (double)d->offset, 0, 1e39, "0 or more, and finite"))
        return GLBK_ERR_DESC;
    for (i = 0; i < d->plane_count; i++) {
        planes.index = i;
        if (!glbk__csm_unit(&planes, "'s normal: its length", d->planes[i]) ||
            !glbk__csm_in(&planes, "[3]", (double)d->planes[i][3], -1e39, 1e39, "finite"))
            return GLBK_ERR_DESC;
    }
    if (r->frame_count == UINT32_MAX)
        return glbk__refuse(ctx, GLBK_ERR_LIMIT, function, "renderer", "has 2^32 - 1 frames, which are all");
    for (i = 0; i < d->use_count && result == GLBK_OK; i++)
        result = glbk__csm_check_use(ctx, function, r, d, i);
    return result;
}

/* Adds samples frame->first .. end - 1 of one light to the sum. */
static glbk_result glbk__csm_shade_pass(glbk_context *ctx, glbk_csm_renderer *r, const glbk_gbuffer *gbuffer,
                                        const glbk_csm_use *use, const glbk_csm_lights *lights,
                                        const glbk_csm_frame *frame, glbk_program *program)
{
    glbk_pass pass;
    glbk_result result = glbk__put_block(ctx, GLBK_SLOT_glbk_csm_frame, &r->frame, frame);

    if (result != GLBK_OK) return result;
    memset(&pass, 0, sizeof pass);
    pass.target = &r->targets[!r->now];
    if (!r->compute) result = glbk_begin(ctx, &pass, program);
    if (result != GLBK_OK) return result;
    glbk_csm_bind(ctx, use->maps, NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_lights, &lights->texels);
    result = glbk_gbuffer_bind(ctx, gbuffer, NULL);
    if (result != GLBK_OK) return result;
    r->passes = 1;
    if (r->compute) {
        glbk_bind_image(ctx, GLBK_SLOT_glbk_csm_total, &r->sums[0]);
        return glbk_dispatch(ctx, program, (r->width + 7) / 8, (r->height + 7) / 8, 1);
    }
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_sum, &r->sums[r->now]);
    glbk_draw_screen(ctx);
    r->now = !r->now;
    return GLBK_OK;
}

/* Checks a frame, and compiles what it needs. */
static glbk_result glbk__csm_prepare(glbk_context *ctx, const char *function, glbk_csm_renderer *r,
                                     const glbk_csm_frame_desc *d)
{
    glbk_result result = glbk__csm_check_frame(ctx, function, r, d);
    glbk_program *program;
    uint32_t i;

    if (result != GLBK_OK) return result;
    r->shade.frame++;
    for (i = 0; i < d->use_count && result == GLBK_OK; i++)
        result = glbk__csm_shade_program(ctx, function, r, &d->uses[i], (uint32_t)d->filter, &program);
    return result;
}

GLBK_DEF glbk_result glbk_csm_prepare(glbk_context *ctx, glbk_csm_renderer *r, const glbk_csm_frame_desc *d)
{
    return glbk__csm_prepare(ctx, __func__, r, d);
}

/* Checks that renderer and G-buffer were created, and that they have one size. */
static glbk_result glbk__csm_check_gbuffer(const glbk_context *ctx, const char *function,
                                           const glbk_csm_renderer *r, const glbk_gbuffer *g)
{
    const glbk_result result =
        glbk__require_created(ctx, function, "renderer", r ? &r->targets[0].name : NULL);
    return result == GLBK_OK ? glbk__require_gbuffer(ctx, function, g, r->width, r->height) : result;
}

GLBK_DEF glbk_result glbk_csm_render(glbk_context *ctx, glbk_csm_renderer *r, const glbk_gbuffer *gbuffer,
                                     const glbk_csm_frame_desc *d)
{
    glbk_csm_frame frame;
    glbk_program *program;
    glbk_result result = glbk__csm_check_gbuffer(ctx, __func__, r, gbuffer);
    uint32_t i, from, step;

    if (result == GLBK_OK) result = glbk__csm_prepare(ctx, __func__, r, d);
    if (result != GLBK_OK) return result;
    memset(&frame, 0, sizeof frame);
    step = d->samples_per_pass ? d->samples_per_pass : 64;
    memcpy(frame.eye, d->eye, sizeof d->eye);
    memcpy(frame.planes, d->planes, sizeof d->planes);
    frame.bias = glbk__csm_bias(d->bias);
    frame.offset = d->offset;
    frame.pattern_texel = d->lights->patterns_at;
    frame.plane_count = d->plane_count;
    frame.width = r->width;
    frame.height = r->height;
    frame.frame = d->frame;
    frame.sampling = (uint32_t)d->sampling;
    for (i = 0; i < d->use_count && result == GLBK_OK; i++) {
        const glbk_csm_use *u = &d->uses[i];
        result = glbk__csm_shade_program(ctx, __func__, r, u, (uint32_t)d->filter, &program);
        frame.light_texel = u->start;
        memcpy(frame.own, u->own, sizeof u->own);
        frame.sample_count = u->sample_count;
        frame.seed = u->seed;
        frame.roulette_seed = u->seed * 0x9e3779b9u + d->frame * 0x85ebca6bu;
        for (from = 0; from < u->sample_count && result == GLBK_OK; from = frame.end) {
            frame.first = from;
            frame.end = u->sample_count - from < step ? u->sample_count : from + step;
            frame.adds = r->passes != 0;
            result = glbk__csm_shade_pass(ctx, r, gbuffer, u, d->lights, &frame, program);
        }
    }
    if (result == GLBK_OK) r->frame_count++;
    return result;
}

GLBK_DEF void glbk_csm_reset(glbk_csm_renderer *r)
{
    if (r) r->frame_count = r->passes = 0;
}

GLBK_DEF glbk_result glbk_csm_resolve(glbk_context *ctx, glbk_csm_renderer *r, const glbk_gbuffer *gbuffer,
                                      const glbk_pass *pass, const glbk_picture *picture)
{
    const int asks = picture && (picture->keep_empty || picture->world_to_clip);
    glbk_csm_frame frame;
    glbk_result result = glbk__require_created(ctx, __func__, "renderer", r ? &r->resolve.name : NULL);
    uint32_t i;

    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "pass", pass);
    if (result == GLBK_OK && asks && !gbuffer)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "gbuffer",
                            "is NULL, but picture asks what is seen");
    if (result == GLBK_OK && gbuffer) result = glbk__csm_check_gbuffer(ctx, __func__, r, gbuffer);
    if (result != GLBK_OK) return result;
    memset(&frame, 0, sizeof frame);
    frame.frame_share = r->passes ? 1.0f / (float)r->frame_count : 0.0f;
    result = glbk__begin_picture(ctx, __func__, pass, picture, r->width, r->height, &r->resolve);
    if (result == GLBK_OK) result = glbk__put_block(ctx, GLBK_SLOT_glbk_csm_frame, &r->frame, &frame);
    if (result != GLBK_OK) return result;
    for (i = 0; i < 2; i++)
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_place + i, asks ? &gbuffer->words[i] : NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_sum, &r->sums[r->now]);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_csm_read(glbk_context *ctx, glbk_csm_renderer *r, float *rgba)
{
    glbk_result result = glbk__require_created(ctx, __func__, "renderer", r ? &r->targets[0].name : NULL);
    size_t i, count;
    float scale;

    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "rgba", rgba);
    if (result != GLBK_OK) return result;
    if (!r->frame_count) return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "renderer", "has no frame yet");
    count = 4 * (size_t)r->width * r->height;
    if (!r->passes) {
        memset(rgba, 0, count * sizeof *rgba);
        return GLBK_OK;
    }
    result = glbk_target_read(ctx, &r->targets[r->now], 0, 0, 0, r->width, r->height, rgba);
    scale = 1.0f / (float)r->frame_count;
    for (i = 0; i < count && result == GLBK_OK; i++) rgba[i] *= scale;
    return result;
}

/* ==== src/gl_csm/building.h ==== */

/* ---- csm: building: layers drawn, and compressed to segments for csm.h ---- */

enum {
    GLBK__CSM_ATLAS = 1024,         /* pixels a side at most */
    GLBK__CSM_CHUNK = 65536         /* views after which csm.h's lists begin anew */
};

/* Returns the greatest value of the grid of depths. */
static uint32_t glbk__csm_top(const glbk_csm_builder *b)
{
    return (1u << b->depth_bits) - 1u;
}

/* Makes the atlas of each layer. */
static glbk_result glbk__csm_create_layers(glbk_context *ctx, glbk_csm_builder *b)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result;
    uint32_t i;

    memset(&texture, 0, sizeof texture);
    texture.format = GLBK_FORMAT_DEPTH32F;
    texture.width = texture.height = b->tiles * b->map_side;
    result = glbk_texture_create(ctx, &texture, &b->depth);
    texture.format = GLBK_FORMAT_R32UI;
    for (i = 0; i < b->layer_count && result == GLBK_OK; i++) {
        memset(&target, 0, sizeof target);
        result = glbk_texture_create(ctx, &texture, &b->layers[i]);
        target.color[0] = &b->layers[i];
        target.depth = &b->depth;
        if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &b->layer_targets[i]);
    }
    return result;
}

/* Makes what open segments and records go to: on the core path two textures of open segments, each drawn from
   the other, on the compute path one buffer. */
static glbk_result glbk__csm_create_records(glbk_context *ctx, glbk_csm_builder *b)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result = GLBK_OK;
    size_t pixels = (size_t)b->map_side * b->map_side;
    int i, k;

    if (b->compute) return glbk_buffer_create(ctx, 64 * pixels, NULL, &b->storage);
    memset(&texture, 0, sizeof texture);
    texture.format = GLBK_FORMAT_RGBA32UI;
    texture.width = texture.height = b->map_side;
    for (i = 0; i < 3 && result == GLBK_OK; i++) result = glbk_texture_create(ctx, &texture, &b->records[i]);
    for (i = 0; i < 2 && result == GLBK_OK; i++) {
        memset(&target, 0, sizeof target);
        result = glbk_texture_create(ctx, &texture, &b->opened[i]);
        target.color[0] = &b->opened[i];
        for (k = 0; k < 3; k++) target.color[k + 1] = &b->records[k];
        if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &b->targets[i]);
    }
    return result;
}

/* Begins the open segment of every pixel anew: it may have all values of the grid, and has no view yet. */
static void glbk__csm_open_all(glbk_csm_builder *b)
{
    size_t pixels = (size_t)b->map_side * b->map_side, i;
    memset(b->words, 0, 64 * pixels);
    for (i = 0; i < pixels; i++) {
        b->words[16 * i] = glbk__csm_top(b) << 8 | 65536u;
        b->firsts[i] = b->next_view;
    }
}

/* Uploads the open segments, with the cursor of each at the batch's first view. words has 16 a pixel, of
   which the first 4 are its open segment. */
static glbk_result glbk__csm_write_state(glbk_context *ctx, glbk_csm_builder *b)
{
    const glbk_box whole = { 0, 0, 0, 0, b->map_side, b->map_side, 1 };
    size_t pixels = (size_t)b->map_side * b->map_side, i;
    for (i = 0; i < pixels; i++) b->words[16 * i + 1] = b->words[16 * i + 2] = 0;
    if (b->compute) return glbk_buffer_update(ctx, &b->storage, 0, 64 * pixels, b->words);
    for (i = 1; i < pixels; i++) memmove(b->words + 4 * i, b->words + 16 * i, 16);
    return glbk_texture_update(ctx, &b->opened[b->now], &whole, b->words);
}

/* Reads open segments and records back, 16 words a pixel on either path. */
static glbk_result glbk__csm_read_state(glbk_context *ctx, glbk_csm_builder *b)
{
    uint32_t m = b->map_side, k;
    size_t pixels = (size_t)m * m, i;
    uint32_t *planes = b->words + 16 * pixels;
    glbk_result result = GLBK_OK;

    if (b->compute) return glbk_buffer_read(ctx, &b->storage, 0, 64 * pixels, b->words);
    for (k = 0; k < 4 && result == GLBK_OK; k++) {
        result = glbk_target_read(ctx, &b->targets[b->now], k, 0, 0, m, m, planes);
        for (i = 0; i < pixels && result == GLBK_OK; i++)
            memcpy(b->words + 16 * i + 4 * k, planes + 4 * i, 16);
    }
    return result;
}

/* Keeps a segment of a pixel, which ends before view `end`; returns 0 if there is no memory. */
static int glbk__csm_keep(glbk_context *ctx, glbk_csm_builder *b, uint32_t pixel, uint32_t record,
                          uint32_t end)
{
    cohsm_segment *s;
    if (b->segment_count == b->segment_room) {
        glbk_csm__allocator memory = glbk_csm__memory(ctx);
        size_t room = 2 * b->segment_room + 65536;
        s = (cohsm_segment *)glbk_csm__alloc_array(&memory, room, sizeof *s);
        if (!s) return 0;
        if (b->segment_count) memcpy(s, b->segments, b->segment_count * sizeof *s);
        glbk_csm__free(&memory, b->segments);
        b->segments = s;
        b->segment_room = room;
    }
    s = &b->segments[b->segment_count++];
    s->first = b->firsts[pixel];
    s->pixel = pixel;
    s->value = record & 0x1ffffu;
    b->firsts[pixel] = end;
    return 1;
}

/* Returns whether a domain is of positions, whose views are perspective. */
static int glbk__csm_is_positional(const cohsm_domain *d)
{
    const int directional = d->kind == COHSM_DOMAIN_DEFAULT || d->kind == COHSM_DOMAIN_LATLONG ||
                            d->kind == COHSM_DOMAIN_OCTAHEDRAL;
    if (d->kind == COHSM_DOMAIN_TABLE || d->kind == COHSM_DOMAIN_LIST)
        return d->locations && d->locations[3] != 0;
    return !directional;
}

/* Checks the desc of the maps that a builder is for, and takes over what it needs of it. */
static glbk_result glbk__csm_take_maps(const glbk_context *ctx, const cohsm_desc *d, glbk_csm_builder *out)
{
    static const char function[] = "glbk_csm_builder_create";
    const glbk_result bad = GLBK_ERR_DESC;
    out->map_side = d->map_side ? d->map_side : 128;
    out->depth_bits = d->depth_bits ? d->depth_bits : 8;
    out->open_thickness = d->open_thickness > 0 ? d->open_thickness : 8.0f;
    out->layer_count = d->layers == COHSM_LAYERS_Z1Z3_FAR || d->layers == COHSM_LAYERS_Z1Z3_SPHERE ? 3 : 2;
    out->sphere = d->layers == COHSM_LAYERS_Z1Z3_SPHERE;
    memcpy(out->center, d->center, sizeof out->center);
    out->radius = d->radius;
    out->positional = glbk__csm_is_positional(&d->domain);
    out->self_only = d->self_only;
    if (out->map_side < 4 || out->map_side > 1024)
        return glbk__refuse_range(ctx, bad, function, "desc.maps->map_side", out->map_side, 4, 1024);
    if (out->sphere && !(d->radius > 0 && glbk_csm__finite(d->radius)))
        return glbk__refuse_value(ctx, bad, function, "desc.maps->radius", (double)d->radius,
                                  "above 0 with COHSM_LAYERS_Z1Z3_SPHERE");
    if ((unsigned)d->layers >= COHSM_LAYERS_COUNT)
        return glbk__refuse_value(ctx, bad, function, "desc.maps->layers", (double)d->layers,
                                  "a COHSM_LAYERS_...");
    if (out->depth_bits < 4 || out->depth_bits > 8)
        return glbk__refuse_value(ctx, bad, function, "desc.maps->depth_bits", d->depth_bits, "0 or 4..8");
    if (!(d->open_thickness >= 0) || !glbk_csm__finite(d->open_thickness))
        return glbk__refuse_value(ctx, bad, function, "desc.maps->open_thickness", (double)d->open_thickness,
                                  "0 or more, and finite");
    return GLBK_OK;
}

/* Checks the desc of a builder, and takes over what it says. */
static glbk_result glbk__csm_take_builder(const glbk_context *ctx, const glbk_csm_builder_desc *d,
                                          glbk_csm_builder *out, glbk_attributes *attributes)
{
    static const char function[] = "glbk_csm_builder_create";
    const glbk_result bad = GLBK_ERR_DESC;
    glbk_result result = glbk__require(ctx, function, "desc", d);
    cohsm_desc defaults;

    if (result != GLBK_OK) return result;
    memset(&defaults, 0, sizeof defaults);
    if (!d->view_fn) return glbk__refuse(ctx, bad, function, "desc.view_fn", "is NULL");
    if (!d->draw_fn) return glbk__refuse(ctx, bad, function, "desc.draw_fn", "is NULL");
    out->view_fn = d->view_fn;
    out->draw_fn = d->draw_fn;
    out->user = d->user;
    result = glbk__take_attributes(ctx, function, &d->attributes, attributes);
    if (result == GLBK_OK) result = glbk__csm_take_maps(ctx, d->maps ? d->maps : &defaults, out);
    if (result != GLBK_OK) memset(out, 0, sizeof *out);
    return result;
}

GLBK_DEF glbk_result glbk_csm_builder_create(glbk_context *ctx, const glbk_csm_builder_desc *d,
                                             glbk_csm_builder *out)
{
    glbk_csm__allocator memory;
    glbk_attributes attributes;
    size_t pixels;
    glbk_result result;

    if (out) memset(out, 0, sizeof *out);
    result = glbk__require(ctx, __func__, "out", out);
    if (result == GLBK_OK) result = glbk__csm_take_builder(ctx, d, out, &attributes);
    if (result != GLBK_OK) return result;
    pixels = (size_t)out->map_side * out->map_side;
    out->compute = ctx->compute && 64 * pixels <= ctx->max_storage;
    for (out->tiles = 8; out->tiles * out->map_side > GLBK__CSM_ATLAS; out->tiles /= 2) {}
    out->batch = out->tiles * out->tiles;       /* a power of two: batches end where csm.h's lists do */
    memory = glbk_csm__memory(ctx);
    out->words = (uint32_t *)glbk_csm__alloc_array(&memory, pixels, 80);
    out->firsts = (uint32_t *)glbk_csm__alloc_array(&memory, pixels, 4);
    result = out->words && out->firsts ? GLBK_OK : GLBK_ERR_ALLOC;
    if (result == GLBK_OK)
        result = glbk__drawing_program(ctx, glbk_csm_part(), "csm_peel.frag", &attributes,
                                       "CSM_FIRST=1 GLBK_PLACE", &out->first_layer);
    if (result == GLBK_OK)
        result = glbk__drawing_program(ctx, glbk_csm_part(), "csm_peel.frag", &attributes,
                                       "CSM_FIRST=0 GLBK_PLACE", &out->next_layer);
    if (result == GLBK_OK)
        result = glbk__program_create(ctx, glbk_csm_part(),
                                      out->compute ? "csm_compress.comp" : "csm_compress.frag", NULL,
                                      &out->compress);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_csm_peel), NULL, &out->block);
    if (result == GLBK_OK) result = glbk__csm_create_layers(ctx, out);
    if (result == GLBK_OK) result = glbk__csm_create_records(ctx, out);
    if (result == GLBK_OK) glbk__csm_open_all(out);
    else glbk_csm_builder_free(ctx, out);
    return result;
}

GLBK_DEF void glbk_csm_builder_free(glbk_context *ctx, glbk_csm_builder *b)
{
    int i;
    if (!b) return;
    glbk_program_free(ctx, &b->first_layer);
    glbk_program_free(ctx, &b->next_layer);
    glbk_program_free(ctx, &b->compress);
    for (i = 0; i < 3; i++) {
        glbk_target_free(ctx, &b->layer_targets[i]);
        glbk_texture_free(ctx, &b->layers[i]);
        glbk_texture_free(ctx, &b->records[i]);
    }
    for (i = 0; i < 2; i++) {
        glbk_target_free(ctx, &b->targets[i]);
        glbk_texture_free(ctx, &b->opened[i]);
    }
    glbk_texture_free(ctx, &b->depth);
    glbk_buffer_free(ctx, &b->block);
    glbk_buffer_free(ctx, &b->storage);
    if (ctx) {
        glbk_csm__allocator memory = glbk_csm__memory(ctx);
        glbk_csm__free(&memory, b->words);
        glbk_csm__free(&memory, b->firsts);
        glbk_csm__free(&memory, b->segments);
    }
    memset(b, 0, sizeof *b);
}

/* Fills the uniform block of a batch, all but the camera. */
static void glbk__csm_fill_block(const glbk_csm_builder *b, uint32_t views, glbk_csm_peel *out)
{
    const float m = (float)b->map_side;
    memset(out, 0, sizeof *out);
    out->clip_per_pixel = 2.0f / m;
    out->open_thickness = b->open_thickness * (b->positional ? 2.0f : 65536.0f) / m;
    out->depth_top = glbk__csm_top(b);
    out->side = b->map_side;
    out->tiles_across = b->tiles;
    out->view_count = views;
    out->far_layer = b->layer_count == 3;
    out->positional = b->positional != 0;
    out->self_only = b->self_only != 0;
    out->sphere = b->sphere != 0;
}

/* Notes where a view of positions stands, in radii about the sphere and along the axes of its face, whose
   number is 2 axis, + 1 if it looks along the negative axis; and how deep a radius is. */
static void glbk__csm_note_eye(glbk_csm_builder *b, const cohsm_view *view, uint32_t i)
{
    static const uint8_t next[3] = { 1, 2, 0 };
    uint32_t k, axis = (view->face >> 1) % 3;
    float *e = b->eyes[i];
    for (k = 0; k < 3; k++) {
        axis = next[axis];
        e[k] = (view->location[axis] - b->center[axis]) / b->radius;
    }
    if (view->face & 1) e[2] = -e[2];
    e[3] = b->radius * view->depth_scale;
}

GLBK_DEF glbk_result glbk_csm_builder_draw(glbk_context *ctx, glbk_csm_builder *b, uint32_t from,
                                           uint32_t count)
{
    static const float none[4] = { 1073741824.0f, 0, 0, 0 };    /* the bits of 2.0 as a number */
    glbk_csm_peel block;
    glbk_pass pass;
    cohsm_view view;
    glbk_result result;
    uint32_t layer, i, m;

    result = glbk__require_created(ctx, __func__, "builder", b ? &b->block.name : NULL);
    if (result != GLBK_OK) return result;
    if (!count || count > b->batch)
        return glbk__refuse_range(ctx, count ? GLBK_ERR_LIMIT : GLBK_ERR_ARGUMENT, __func__, "count", count,
                                  1, b->batch);
    m = b->map_side;
    glbk__csm_fill_block(b, count, &block);
    memset(&pass, 0, sizeof pass);
    pass.depth = GLBK_DEPTH_LESS;
    for (layer = 0; layer < b->layer_count; layer++) {
        pass.target = &b->layer_targets[layer];
        for (i = 0; i < count; i++) {
            b->view_fn(b->user, from + i, &view);
            if (b->sphere && b->positional && !layer) glbk__csm_note_eye(b, &view, i);
            memcpy(block.view, view.matrix, sizeof block.view);
            block.depth_scale = view.depth_scale;
            result = glbk__put_block(ctx, GLBK_SLOT_glbk_csm_peel, &b->block, &block);
            if (result != GLBK_OK) return result;
            pass.viewport[0] = (int32_t)(i % b->tiles * m);
            pass.viewport[1] = (int32_t)(i / b->tiles * m);
            pass.viewport[2] = pass.viewport[3] = (int32_t)m;
            result = glbk_begin(ctx, &pass, layer ? &b->next_layer : &b->first_layer);
            if (result != GLBK_OK) return result;
            if (!i) {
                glbk_clear(ctx, pass.target, 0, none);
                glbk_clear_depth(ctx, 1);
            }
            if (layer) glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_layer1, &b->layers[layer - 1]);
            b->draw_fn(b->user, ctx);
        }
    }
    b->drawn = count;
    b->drawn_from = from;
    return GLBK_OK;
}

/* Runs the shader once; it goes on with each pixel until the batch or the room for records ends. */
static glbk_result glbk__csm_run_compress(glbk_context *ctx, glbk_csm_builder *b)
{
    glbk_pass pass;
    glbk_result result;
    uint32_t i, groups = (b->map_side + 7) / 8;

    memset(&pass, 0, sizeof pass);
    pass.target = &b->targets[!b->now];
    if (!b->compute) {
        result = glbk_begin(ctx, &pass, &b->compress);
        if (result != GLBK_OK) return result;
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_opened, &b->opened[b->now]);
    }
    glbk_bind_block(ctx, GLBK_SLOT_glbk_csm_peel, &b->block);
    for (i = 0; i < 3; i++)         /* where there are two layers, the third is not read */
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_csm_layer0 + i, &b->layers[i]);
    b->passes++;
    if (b->compute) {
        glbk_bind_storage(ctx, GLBK_SLOT_glbk_csm_records, &b->storage);
        return glbk_dispatch(ctx, &b->compress, groups, groups, 1);
    }
    glbk_draw_screen(ctx);
    b->now = !b->now;
    return GLBK_OK;
}

/* Keeps the segments that a run has ended. *left receives how many pixels are not through yet. */
static glbk_result glbk__csm_take_records(glbk_context *ctx, glbk_csm_builder *b, size_t *left)
{
    uint32_t pixels = b->map_side * b->map_side, p, i;
    glbk_result result = glbk__csm_read_state(ctx, b);

    *left = 0;
    for (p = 0; p < pixels && result == GLBK_OK; p++) {
        const uint32_t *w = b->words + 16 * (size_t)p;
        for (i = 0; i < w[2] && i < 12; i++)
            if (!glbk__csm_keep(ctx, b, p, w[4 + i], b->next_view + (w[4 + i] >> 17))) return GLBK_ERR_ALLOC;
        *left += w[1] < b->drawn;
    }
    return result;
}

/* Ends all open segments, as lists of csm.h do after 65,536 views. */
static glbk_result glbk__csm_end_all(glbk_context *ctx, glbk_csm_builder *b)
{
    uint32_t pixels = b->map_side * b->map_side, p;
    for (p = 0; p < pixels; p++)
        if (b->firsts[p] != b->next_view &&
            !glbk__csm_keep(ctx, b, p, b->words[16 * (size_t)p] & 0xffffu, b->next_view))
            return GLBK_ERR_ALLOC;
    glbk__csm_open_all(b);
    return GLBK_OK;
}

/* Checks that the views that were drawn last are the next to be compressed. */
static glbk_result glbk__csm_check_batch(const glbk_context *ctx, const glbk_csm_builder *b)
{
    static const char function[] = "glbk_csm_builder_compress";
    const glbk_result bad = GLBK_ERR_ORDER;
    if (!b->drawn)
        return glbk__refuse(ctx, bad, function, "builder", "has drawn no view since the last compression");
    if (b->drawn_from != b->next_view)
        return glbk__refuse_range(ctx, bad, function, "the first view drawn", b->drawn_from, b->next_view,
                                  b->next_view);
    if (b->next_view % GLBK__CSM_CHUNK + b->drawn > GLBK__CSM_CHUNK)
        return glbk__refuse_value(ctx, bad, function, "the end of the views drawn",
                                  (double)b->next_view + b->drawn, "at most the next multiple of 65536");
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_csm_builder_compress(glbk_context *ctx, glbk_csm_builder *b)
{
    glbk_csm_peel block;
    glbk_result result;
    size_t left = 1;

    result = glbk__require_created(ctx, __func__, "builder", b ? &b->block.name : NULL);
    if (result == GLBK_OK) result = glbk__csm_check_batch(ctx, b);
    if (result != GLBK_OK) return result;
    glbk__csm_fill_block(b, b->drawn, &block);
    memcpy(block.eyes, b->eyes, sizeof b->eyes);
    result = glbk_buffer_update(ctx, &b->block, 0, sizeof block, &block);
    if (result == GLBK_OK) result = glbk__csm_write_state(ctx, b);
    while (left && result == GLBK_OK) {
        result = glbk__csm_run_compress(ctx, b);
        if (result == GLBK_OK) result = glbk__csm_take_records(ctx, b, &left);
    }
    if (result != GLBK_OK) return result;
    b->next_view += b->drawn;
    b->drawn = 0;
    return b->next_view % GLBK__CSM_CHUNK == 0 ? glbk__csm_end_all(ctx, b) : GLBK_OK;
}

GLBK_DEF glbk_result glbk_csm_builder_end(glbk_context *ctx, glbk_csm_builder *b)
{
    const glbk_result result = glbk__require_created(ctx, __func__, "builder", b ? &b->block.name : NULL);

    if (result != GLBK_OK) return result;
    if (!b->next_view)
        return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "builder", "has compressed no view yet");
    return glbk__csm_end_all(ctx, b);
}

/* ==== src/gl_csm/end.h ==== */

#endif /* GL_CSM_IMPLEMENTATION */

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
