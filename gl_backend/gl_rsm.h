/* gl_rsm.h - v0.9.0 - reflective shadow maps on OpenGL 3.3, OpenGL ES 3.0 and WebGL 2 - MIT-0 OR Unlicense

   What it does

   The header draws reflective shadow maps by calls of yours, or takes those of rsm.h, picks their pixel
   lights, and gathers the light that bounces once. Shaders of your own do so by two calls, rsm_direct() and
   rsm_gather_about(). Or complete passes light a G-buffer, with screen-space interpolation and a filter over
   frames. Lights, descs and settings are the structs of rsm.h and gifilter.h, of which this header needs the
   declarations alone.

   What it does not do

   - It needs gl_backend.h beside it, which makes the context object, textures and targets, and whose
     conventions, errors and rules about GL's state hold here; gl_programs.h, which makes programs;
     and gl_gbuffer.h, whose G-buffer is lit.
   - Bounced light has no shadows of its own: that of gl_ism.h has.

   Quick start

       #define GL_BACKEND_IMPLEMENTATION
       #define GL_PROGRAMS_IMPLEMENTATION
       #define GL_GBUFFER_IMPLEMENTATION
       #define GL_RSM_IMPLEMENTATION
       #include "gl_backend/gl_rsm.h"
       #include <stdio.h>
       #include <string.h>

       // With GLFW: return glfwGetProcAddress(name);  with EGL: return eglGetProcAddress(name);
       static glbk_proc_fn get_proc(const char *name, void *user)
       {
           (void)name; (void)user;
           return NULL;                                     // no GL here: glbk_init says so below
       }

       int main(void)
       {
           static const char fragment[] =                   // your shader, which calls the library's function
               "out vec4 color;\n"
               "void main()\n"
               "{\n"
               "    vec3 place = vec3(gl_FragCoord.xy, 0.0), up = vec3(0.0, 1.0, 0.0);\n"
               "    color = vec4(rsm_direct(rsm_bound(), place, up, 4, 1.0, 1.0), 1.0);\n"
               "}\n";
           glbk_context gl;
           glbk_program program;
           glbk_desc desc;
           glbk_source source;
           glbk_result result;

           memset(&desc, 0, sizeof desc);
           desc.get_proc_fn = get_proc;                        // a context is current
           result = glbk_init(&gl, &desc);
           if (result != GLBK_OK) {
               printf("no GL: %s\n", glbk_result_text(result));
               return result != GLBK_ERR_FUNCTION;
           }
           memset(&source, 0, sizeof source);
           source.parts[0] = glbk_rsm_part();               // the GLSL of this header
           source.uses = "rsm_direct";
           source.defines = NULL;
           source.fragment = fragment;
           result = glbk_program_compile(&gl, &source, &program);
           printf("%s\n", glbk_result_text(result));
           glbk_program_free(&gl, &program);
           glbk_free(&gl);
           return result != GLBK_OK;
       }

   The whole frame, with a window: examples/07_rsm_gl_minimal.c.

   A frame by complete passes

       glbk_rsm_map_draw(gl, &r, &map, draw, user);               // or glbk_rsm_map_import, _upload
       glbk_gbuffer_begin(gl, &seen, world_to_clip, eye); ...     // what the camera sees: gl_gbuffer.h
       glbk_rsm_direct(gl, &r, &seen, maps, n, &direct);          // direct light, shadowed by the same maps
       glbk_rsm_gather(gl, &r, &seen, maps, n, &gather);          // bounced light; or glbk_rsm_interpolate
       glbk_rsm_denoise(gl, &r, &seen, &frame, NULL);             // if few samples were taken
       glbk_rsm_resolve(gl, &r, &seen, &pass, NULL, 1, 1);

   In shaders of your own

   These functions of lib/rsm_direct.glsl, lib/rsm_gather.glsl and lib/rsm_sampling.glsl can be called after
   glbk_rsm_bind:

       rsm_light rsm_bound();                      // the light whose map is bound
       rsm_sampling rsm_bound_sampling();          // how glbk_rsm_gather took points last
       vec3 rsm_direct(rsm_light l, vec3 p, vec3 n, int taps, float bias, float slope_bias);
       vec3 rsm_gather_list(rsm_light l, vec3 p, vec3 n, uint from, uint to, bool glossy, float mixed);
       vec3 rsm_gather_about(rsm_light l, vec3 p, vec3 n, rsm_sampling s, vec2 turn, uint first, uint step,
                             uint count);

   p is in world space, n is unit. rsm_direct returns irradiance, W/m^2. The other two return pi times bounced
   irradiance. rsm_gather_list goes through lights from .. to - 1 of the list: all of them are
   glbk_rsm_frame.first_light to end_light, glossy being glbk_rsm_frame.material_count != 0u and mixed
   glbk_rsm_frame.mixed. rsm_gather_about goes through count points first, first + step, ... of the bound
   pattern about p; turn is cosine and sine of a rotation.

   Conventions

   Lights, descs and their defaults are those of rsm.h, those of the filter are gifilter.h's: the same struct
   gives the same light here and there. A field that GL cannot honour is GLBK_ERR_DESC, and the log names the
   field: desc.system and desc.add have to be zero, rsm_interpolation.mask and gifilt_frame.motion NULL. Maps
   come from the CPU (rsm_map_texels, as they are), or they are drawn here through a callback of yours. Pixel
   lights are picked by flux, from running sums that are made here, too.

   A vector that is said to be unit may have a length of 0.97 to 1.03 and is used as it is, so interpolated
   normals must be normalised before they come; directions of lights may have any length.

   Images are RGBA32UI, bits of floats, so that everything works without EXT_color_buffer_float.

   From the paper to the code

   The paper is that of rsm.h: Dachsbacher and Stamminger, "Reflective Shadow Maps", I3D 2005. A line has the
   function in GLSL or the call, its twin in rsm.h, and the rows of docs/conformance.md that test both.

     section 3.1  what a texel stores                   glbk_rsm_map_draw     rsm_rasterize       T34 T35
     section 3.2  flux through a texel                  rsm_incident          rsm_fill            T30 T31 T33
     section 3.2  lights move below their surface       rsm_gather_about      rsm_gather          T38
     eq. (1)      irradiance from one texel             rsm_gather_list       rsm_gather_list     T25 T28 T40
     eq. (2)      the sum over texels                   glbk_rsm_gather       rsm_gather          T32 T44
     section 3.3  a receiver's projection into the map  rsm_to_face           rsm_map_project     -
     eq. (3)      samples about the projection          rsm_gather_about      rsm_gather          T26 T27 T36
     section 4    interpolation between alike samples   glbk_rsm_interpolate  rsm_interpolate     T39
     section 4    direct light by the same map          glbk_rsm_direct       rsm_direct          T29
     figure 6     ambient occlusion as a factor         glbk_rsm_gather       rsm_points          -
     section 6    textures are averaged over a texel    glbk_rsm_object       rsm_mesh            -
     section 7    lamps all round, and area lights      glbk_rsm_map_create   rsm_map_create      T37
     section 7    reflectors that are not diffuse       rsm_gloss             rsm_material        -
     -            near texels are surfaces              rsm_texel_form        rsm_gather          T42

   Configuration

     GL_RSM_IMPLEMENTATION   compiles the code, in one source file; the implementations of
                             gl_backend.h, gl_programs.h and gl_gbuffer.h may be compiled in another

   Layouts: docs/gpu-layouts.md.   The technique: docs/rsm.md.   State: docs/gl-state.md.
   Licence: end of file. */
/* These includes stand outside the guard, since an implementation may be asked for when the file is included
   for the second time. rsm.h and gifilter.h lie above this folder; their implementations are not needed. */
#include "gl_programs.h"
#include "gl_gbuffer.h"
#include "../rsm.h"
#include "../gifilter.h"

#ifndef GL_RSM_H
#define GL_RSM_H

#if GLBK_VERSION != 900
#error "gl_rsm.h and gl_backend.h are of different versions"
#endif
#if defined(GLBK_STATIC) && !defined(GL_RSM_IMPLEMENTATION)
#error "GLBK_STATIC makes all functions private: GL_RSM_IMPLEMENTATION belongs into the same file"
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ==== src/gl_rsm/api_page_one.h ==== */

/* ---- page one: lamps that shine on a scene, and the light that bounces off the scene once ---- */

typedef struct glbk_rsm_map glbk_rsm_map;           /* the map of a light: see "objects" below */
typedef struct glbk_rsm_renderer glbk_rsm_renderer; /* the light of a picture: see there, too */
struct glbk_rsm_renderer_desc;      /* how large the picture is: below */

GLBK_DEF glbk_result glbk_rsm_renderer_create(glbk_context *ctx, const struct glbk_rsm_renderer_desc *desc,
                                              glbk_rsm_renderer *out);
/* Makes a renderer for pictures of one size, which glbk_rsm_renderer_free takes back. If ctx->compute is set,
   the renderer gathers and filters by compute.
   out      zeroed on errors
   Memory   on the GPU: 4 MB, and for each pixel 48 bytes, with interpolate 13 more, with denoise 96 more
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: a field is out of range, or a location is
            used twice. GLBK_ERR_LIMIT: width or height is above ctx->max_side. Those of textures and
            targets */

GLBK_DEF glbk_result glbk_rsm_map_create(glbk_context *ctx, const rsm_light *light, uint32_t side,
                                         glbk_rsm_map *out);
/* Makes an empty map of a light, which glbk_rsm_map_free takes back.
   light    as rsm_map_create takes it
   side     texels a side of each face, 4..4096; 0 = 512, of maps with several faces 256
   out      zeroed on errors
   Memory   on the GPU: 60 bytes for each texel
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or side is out of range. GLBK_ERR_DESC: a light that
            rsm_map_create refuses, or an up beyond 1e9. GLBK_ERR_LIMIT, and those of textures and targets */

typedef void (*glbk_rsm_draw_fn)(void *user, glbk_context *ctx, glbk_rsm_renderer *renderer);
/* Draws your scene: for each object the function calls glbk_rsm_object, binds its vertex array and draws.
   Attributes are where glbk_rsm_renderer_desc.attributes says; one that the array has not enabled must be
   zero. Where the normal is zero, the triangle's own counts. */

GLBK_DEF glbk_result glbk_rsm_map_draw(glbk_context *ctx, glbk_rsm_renderer *renderer, glbk_rsm_map *map,
                                       glbk_rsm_draw_fn draw_fn, void *user);
/* Draws a map: place, normal and flux of what its light shines on. Both sides of triangles are drawn, with
   normals turned to the light.
   draw_fn  draws your scene; it is called once for each face, and user is given to it
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or an object was not created. GLBK_ERR_LOST. The first error
            of glbk_rsm_object, and those of glbk_program_compile at first use */

GLBK_DEF glbk_result glbk_rsm_gather(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                     const glbk_gbuffer *gbuffer, glbk_rsm_map *const *maps,
                                     uint32_t map_count, const rsm_gather_desc *desc);
/* Computes the bounced light of each pixel by all maps, from the samples that rsm_gather takes for the same
   desc. This light replaces the bounced light that the renderer has.
   gbuffer  the points that are lit; NULL = no pixels: only the list of lights by flux is made, for shaders of
            your own (glbk_rsm_bind)
   maps     that were drawn or uploaded; map_count at least 1. Running sums of their flux are made if they are
            needed
   desc     NULL = all defaults: every texel is a light. Noise, materials and patterns about the receiver need
            the tables of this desc (glbk_rsm_tables_upload). A program of your own needs RSM_SURFACES=1 among
            its defines for near_field
   Cost     grows with pixels and samples, in passes of lights_per_pass lights
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, map_count is 0, or an object was not created. GLBK_ERR_DESC:
            a field is out of range, or GL cannot honour it. GLBK_ERR_MISMATCH: glbk_rsm_tables_upload was not
            given this desc last, or the G-buffer has another size. Those of glbk_program_compile at first
            use */

GLBK_DEF glbk_result glbk_rsm_object(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                     const glbk_surface *surface, uint32_t material);
/* Sets the surface of the next object that a glbk_rsm_draw_fn draws. Only such a function may call it. The
   first error of such calls is also what glbk_rsm_map_draw returns.
   surface   as for glbk_gbuffer_object. A map takes its transform, its diffuse colour (of metal-rough ones
             times 1 - metallic), color_map, alpha and alpha_cutoff; alpha is that of the colour map at full
             size. Sample the colour map with GLBK_SAMPLING_MIPMAPS, so that flux is filtered (section 6)
   material  number of a Phong lobe of rsm_gather_desc.materials that its texels have, from 1; 0 = none
   Errors    GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_ORDER: the call does not come from a
             glbk_rsm_draw_fn */

GLBK_DEF glbk_result glbk_rsm_direct(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                     const glbk_gbuffer *gbuffer, const glbk_rsm_map *const *maps,
                                     uint32_t map_count, const rsm_direct_desc *desc);
/* Computes the direct light of each pixel: that of the lights of all maps, each shadowed by its own map. This
   light replaces the direct light that the renderer has.
   gbuffer    the points that are lit, of the renderer's size, as in all calls that follow
   maps       that were drawn or uploaded; map_count at least 1, one pass for each
   desc       as rsm_direct takes it; NULL = all defaults
   Errors     GLBK_ERR_ARGUMENT: a pointer is NULL, map_count is 0, or an object was not created.
              GLBK_ERR_DESC: a field is out of range, or GL cannot honour it. GLBK_ERR_MISMATCH: the G-buffer
              has another size. Those of glbk_program_compile at first use */

GLBK_DEF glbk_result glbk_rsm_resolve(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                      const glbk_gbuffer *gbuffer, const glbk_pass *pass,
                                      const glbk_picture *picture, int direct, int bounced);
/* Draws irradiance x albedo / pi, which is linear radiance, to the pass's target. The albedo is the
   G-buffer's diffuse colour, of metal-rough surfaces times 1 - metallic.
   pass      where the picture is drawn and how it is blended; its viewport says where in the target
   picture   whether empty pixels and depths are drawn, see glbk_picture; NULL = every pixel, without depths
   direct    not 0: direct light is shown. Light that was not computed is 0
   bounced   not 0: bounced light is shown
   Errors    GLBK_ERR_ARGUMENT: a pointer is NULL, or an object was not created. GLBK_ERR_MISMATCH: the
             G-buffer has another size. Those of glbk_begin */

/* ---- structs of page one ---- */

typedef struct glbk_rsm_renderer_desc { /* zero it, then set what you care about */
    uint32_t width;                     /* pixels of the picture, 1 to ctx->max_side; both must be set */
    uint32_t height;
    int      interpolate;               /* not 0: makes room for glbk_rsm_interpolate */
    int      denoise;                   /* not 0: makes room for glbk_rsm_denoise */
    uint32_t lights_per_pass;           /* pixel lights that one pass adds up, at most 32768; 0 = 4096. Give
                                           fewer if the driver stops passes that take long */
    glbk_attributes attributes;         /* of meshes that are drawn into maps: position, normal and uv count.
                                           All zero = 0, 1, 2 */
} glbk_rsm_renderer_desc;

/* ==== src/gl_rsm/api.h ==== */

/* ---- maps ---- */

GLBK_DEF glbk_result glbk_rsm_map_place(glbk_context *ctx, glbk_rsm_map *map, const rsm_light *light);
/* Sets another light, or another place of the same one, for a map that was made. The map must be drawn or
   uploaded anew.
   light    needs as many faces as the map has
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the map was not created. GLBK_ERR_DESC: rsm_map_create
            refuses the light. GLBK_ERR_MISMATCH: the light needs another number of faces */

GLBK_DEF glbk_result glbk_rsm_map_upload(glbk_context *ctx, glbk_rsm_map *map, const rsm_texel *texels);
/* Sets all texels of a map.
   texels   rsm_map_texels of a map of the same light and side: face_count x side x side
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the map was not created. GLBK_ERR_ALLOC */

typedef enum glbk_rsm_color {
    GLBK_RSM_COLOR_DEFAULT,                 /* = GLBK_RSM_COLOR_ALBEDO */
    GLBK_RSM_COLOR_ALBEDO,                  /* linear reflectance: the map's light multiplies it */
    GLBK_RSM_COLOR_FLUX,                    /* W that leave the surface through the texel, as in rsm_texel */
    GLBK_RSM_COLOR_COUNT
} glbk_rsm_color;

typedef struct glbk_rsm_layer {             /* a texture of yours, or a part of it */
    const glbk_texture *texture;            /* NULL = not given. For one that this library has not made, zero
                                               a glbk_texture and set name, width and height; of an array set
                                               layers, of a cube gl_target = GLBK_GL_TEXTURE_CUBE_MAP */
    uint32_t            layer;              /* of an array; else 0 */
} glbk_rsm_layer;

/* A face as your renderer drew it. Textures are either all 2D, or all arrays, or all cubes; not multisampled
   and complete (without mipmaps their filter is GL_NEAREST or GL_LINEAR), and one of depths has no comparison
   mode. 2D textures and layers were drawn as the light sees the face: by the matrix of rsm_map_matrix, or by
   one of yours that looks the same way through the same window. Cubes are asked by directions in world space
   from light.position, as GL draws and shaders read them, so one cube serves all faces of a map. */
typedef struct glbk_rsm_import {
    glbk_rsm_layer      depth;              /* what a depth buffer holds, drawn between near_depth and
                                               far_depth of the map's light; of cubes,
                                               along the axis of the cube's face. depth
                                               or positions is required; with both, depth
                                               only says what is seen */
    glbk_clip_depth     clip_depth;         /* how depths are stored: REVERSED is 1 near .. 0 far, the other
                                               two are 0 near .. 1 far */
    glbk_rsm_layer      positions;          /* floats x, y, z; a 0 in the fourth channel: nothing is seen */
    float               to_world[16];       /* the space of positions and normals to world, a rotation and
                                               translation. All zero = identity */
    glbk_rsm_layer      normals;            /* required, of lengths 0.5..1.5, else nothing is seen; towards
                                               the side that sends light */
    glbk_normal_packing normal_packing;
    glbk_rsm_layer      colors;             /* linear; an sRGB texture is fine */
    glbk_rsm_color      color_kind;         /* what colours are */
    float               color[3];           /* multiplies colors, or counts alone, up to 1e12. All 0 = 1 */
    glbk_rsm_layer      materials;          /* unsigned integers, red: numbers of Phong lobes, as material */
    uint32_t            material;           /* as for glbk_rsm_object; materials replaces it */
    uint32_t            left;               /* where the face begins in 2D textures and layers, in texels, so
                                               that it may be a tile of an atlas */
    uint32_t            bottom;
} glbk_rsm_import;                          /* zero it, then set what you care about */

GLBK_DEF glbk_result glbk_rsm_map_import(glbk_context *ctx, glbk_rsm_renderer *renderer, glbk_rsm_map *map,
                                         uint32_t face, const glbk_rsm_import *import);
/* Fills one face of a map from textures of your own in one pass, as rsm_fill does from arrays. A texel with a
   value that is not finite, or a negative colour, is empty.
   face     below face_count. A map is whole after a call for each
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, an object was not created, or there is no such face.
            GLBK_ERR_DESC: a field is out of range, what is required is missing, textures are of several
            kinds, or there is a cube and the light is a sun. GLBK_ERR_MISMATCH: a cube has not the map's
            side, or a texture ends before the face does. Those of glbk_program_compile at first use */

GLBK_DEF glbk_result glbk_rsm_map_read(glbk_context *ctx, const glbk_rsm_map *map, uint32_t face,
                                       rsm_texel *texels);
/* Reads a face back to the CPU, and waits for the GPU meanwhile. So ism.h can choose VPLs from a map that was
   drawn here.
   face     below face_count
   texels   gets side x side of them, as rsm_map_texels has them
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, the map was not created, or there is no such face.
            GLBK_ERR_ALLOC, GLBK_ERR_LOST */

GLBK_DEF glbk_result glbk_rsm_map_stats(glbk_context *ctx, glbk_rsm_renderer *renderer, glbk_rsm_map *map,
                                        int count, rsm_stats *stats);
/* Counts what rsm_finish counts of a map, in one pass, and reads what was counted.
   count    not 0: counts the map as it is now; nothing waits for that. 0: reads the last count alone, which
            may be of an earlier frame
   stats    receives what was counted, and the call waits for the GPU; NULL = nothing is read. Incident and
            reflected light are sums of floats along rows, of doubles over rows. bad_texels and
            skipped_triangles are 0, since the GPU drops both without a word
   Memory   on the GPU, from the first call on: 48 bytes for each row of texels
   Errors   GLBK_ERR_ARGUMENT: ctx is NULL, or an object was not created. GLBK_ERR_ORDER: count is 0, and
            nothing was counted yet. GLBK_ERR_ALLOC, GLBK_ERR_LOST, those of textures and targets, and those
            of glbk_program_compile at first use */

GLBK_DEF void glbk_rsm_map_free(glbk_context *ctx, glbk_rsm_map *map);
/* Frees what glbk_rsm_map_create made, and zeroes the struct. NULL and a zeroed map are allowed. */

/* ---- the renderer ---- */

GLBK_DEF glbk_result glbk_rsm_renderer_resize(glbk_context *ctx, glbk_rsm_renderer *renderer, uint32_t width,
                                              uint32_t height);
/* Gives the renderer another size, without what it had drawn. Its programs stay, whereas a new renderer would
   compile them anew; so call it when a window has changed its size, with glbk_gbuffer_resize. Its textures
   are new ones.
   Errors   GLBK_ERR_ARGUMENT: the renderer is NULL or was not created. GLBK_ERR_DESC, GLBK_ERR_LIMIT: as for
            glbk_rsm_renderer_create; a renderer that was created with interpolate, and whose member compute
            is set, is refused more than ctx->max_storage / 4 pixels, too. After these it is as it was, after
            those of textures, targets and buffers it is freed and zeroed */

GLBK_DEF void glbk_rsm_renderer_free(glbk_context *ctx, glbk_rsm_renderer *renderer);
/* Frees what glbk_rsm_renderer_create made, and zeroes the struct. NULL and a zeroed renderer are allowed. */

GLBK_DEF glbk_result glbk_rsm_read(glbk_context *ctx, glbk_rsm_renderer *renderer, int bounced, float *rgba);
/* Reads irradiance, W/m^2, back to the CPU, and waits for the GPU meanwhile.
   bounced   not 0: bounced light; 0: direct light
   rgba      gets 4 floats for each pixel, row 0 of the G-buffer first. The last of four says of bounced
             light, before glbk_rsm_denoise: 2 interpolated, above 2 evaluated, 0 nothing is seen
   Errors    GLBK_ERR_ARGUMENT: a pointer is NULL, or the renderer was not created. GLBK_ERR_ORDER: there is
             no such light yet */

/* ---- fewer samples: tables, interpolation, a filter ---- */

GLBK_DEF uint32_t glbk_rsm_point_count(const rsm_gather_desc *desc);
/* Returns how many points the pattern of a desc needs, which is 0 with RSM_PATTERN_FLUX, with a sample_count
   of 0 and for NULL. */

GLBK_DEF glbk_result glbk_rsm_tables_upload(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                            const rsm_gather_desc *desc, const float *points);
/* Sets the tables that glbk_rsm_gather and glbk_rsm_interpolate need for a desc: its noise, its materials,
   and the points of its pattern, all three anew. A desc without any of them needs no call. Otherwise call
   again whenever they change, or pattern, sample_count, interleave, r_min, paper_weights or seed do.
   desc     with at most 1024 materials and a noise_side of at most 1024; NULL = all defaults, which need no
            tables
   points   3 floats each, of rsm_pattern_build(pattern, glbk_rsm_point_count(desc), r_min, paper_weights,
            seed, ..) for the desc; for RSM_PATTERN_MIXED, of RSM_PATTERN_LOG_RADIAL with r_min 1 / 192. NULL
            if the count is 0
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or points are given to a pattern that needs none.
            GLBK_ERR_DESC: a field is out of range. GLBK_ERR_INPUT: a material or noise is out of range.
            GLBK_ERR_LIMIT: a table is too large. GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_rsm_interpolate(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                          const glbk_gbuffer *gbuffer, glbk_rsm_map *const *maps,
                                          uint32_t map_count, const rsm_gather_desc *desc,
                                          const rsm_interpolation *interpolation);
/* Computes bounced light as rsm_interpolate does. First a picture of low resolution is lit, then the pixels
   between its samples are interpolated where three of four samples suit, then finer grids follow, at last
   single pixels. Each step works only where a mask in alpha, or by compute a list, says that pixels are left,
   so nothing is read back from the GPU.
   desc            NULL = all defaults; noise and interleave must be off
   interpolation   NULL = all defaults; its mask must be NULL
   Errors          those of glbk_rsm_gather. GLBK_ERR_MISMATCH: also if the renderer was made without
                   desc.interpolate */

GLBK_DEF glbk_result glbk_rsm_denoise(glbk_context *ctx, glbk_rsm_renderer *renderer,
                                      const glbk_gbuffer *gbuffer, const gifilt_frame *frame,
                                      const glbk_texture *motion);
/* Filters bounced light over frames and neighbours, as gifilt_apply does. Call it once in a frame, after the
   light was gathered. Places and normals of the G-buffer are kept for the next frame.
   frame    NULL = all defaults; its motion must be NULL. Without world_to_clip and motion no pixel is found
            again in the last frame
   motion   where each pixel's surface was in the last frame, in pixels, in r and g; NULL = surfaces that
            moved are new
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or an object was not created. GLBK_ERR_DESC: a field is out
            of range. GLBK_ERR_MISMATCH: the G-buffer has another size, or the renderer was made without
            desc.denoise. GLBK_ERR_ORDER: no light was gathered, or the light was filtered already */

GLBK_DEF void glbk_rsm_reset(glbk_rsm_renderer *renderer);
/* Forgets all frames, so that glbk_rsm_denoise begins anew: for a cut, where no surface of the last frame is
   seen again. NULL is allowed. */

/* ---- shaders of your own ---- */

GLBK_DEF const glbk_part *glbk_rsm_part(void);
/* Returns the GLSL of this header, for programs of your own that use its library files: see
   glbk_source.parts. */

GLBK_DEF void glbk_rsm_bind(glbk_context *ctx, const glbk_rsm_renderer *renderer, const glbk_rsm_map *map,
                            const glbk_offset *offset);
/* Binds textures and uniform blocks for a program of your own, which is in use (glbk_begin) and has
   rsm_direct, rsm_gather or rsm_bounce among its library files. rsm_screen and rsm_bounce read the G-buffer,
   too: they need glbk_gbuffer_bind, and glbk_gbuffer_part() among the parts.
   renderer  its list of lights, as the last glbk_rsm_gather left it, and its tables; NULL = none. By flux,
             without interleave, the list holds the samples of one map after the other: of all maps if they
             are lights_per_pass or fewer, otherwise their last ones. A renderer of 1 x 1 pixels and no
             G-buffer suffice if you want the list alone
   map       its texels and light; NULL = none
   offset    the offset that the part rsm has in the program; NULL = none */

/* ==== src/gl_rsm/bindings.h ==== */

/* ---- what the GLSL declares; see "bindings" in gl_programs.h ---- */

#define GLBK_RSM_MAP_TEXTURES(X)                                                                        \
    X(usampler2DArray, glbk_rsm_texels, 0)      /* layers 3 face + 0 place, 1 normal, 2 flux */         \
    X(usampler2DArray, glbk_rsm_sums, 1)        /* running sums of flux along rows */                   \
    X(usampler2DArray, glbk_rsm_rows, 2)        /* running sums of whole rows */                        \
    X(usampler2DArray, glbk_rsm_lights, 3)      /* the list of pixel lights */                          \
    X(sampler2D, glbk_rsm_pattern, 4)                                                                   \
    X(sampler2D, glbk_rsm_noise, 5)                                                                     \
    X(sampler2D, glbk_rsm_materials, 6)

#define GLBK_RSM_PICTURES(X)                                                                            \
    X(glbk_color_sampler, glbk_rsm_sum, 7)      /* light so far; 8 to 11 are the G-buffer's */          \
    X(glbk_color_sampler, glbk_rsm_states, 12)  /* the picture while it is interpolated */              \
    X(glbk_color_sampler, glbk_rsm_coarse, 13)  /* a grid of samples */                                 \
    X(glbk_color_sampler, glbk_rsm_history, 14)                                                         \
    X(usampler2DArray, glbk_rsm_before, 15)     /* place and normal of the last frame */                \
    X(sampler2D, glbk_rsm_motion, 1)            /* in programs that read no map */                      \
    X(sampler2D, glbk_rsm_albedo_map, 2)        /* in programs that read no map */

/* What an import reads, in programs that read nothing else: 2D textures, layers of arrays, or cubes. */
#define GLBK_RSM_IMPORT_TEXTURES(X)                                                                     \
    X(sampler2D, glbk_rsm_depth_in, 3)                                                                  \
    X(sampler2D, glbk_rsm_place_in, 4)                                                                  \
    X(sampler2D, glbk_rsm_normal_in, 5)                                                                 \
    X(sampler2D, glbk_rsm_color_in, 6)                                                                  \
    X(usampler2D, glbk_rsm_material_in, 7)                                                              \
    X(sampler2DArray, glbk_rsm_depth_array, 3)                                                          \
    X(sampler2DArray, glbk_rsm_place_array, 4)                                                          \
    X(sampler2DArray, glbk_rsm_normal_array, 5)                                                         \
    X(sampler2DArray, glbk_rsm_color_array, 6)                                                          \
    X(usampler2DArray, glbk_rsm_material_array, 7)                                                      \
    X(samplerCube, glbk_rsm_depth_cube, 3)                                                              \
    X(samplerCube, glbk_rsm_place_cube, 4)                                                              \
    X(samplerCube, glbk_rsm_normal_cube, 5)                                                             \
    X(samplerCube, glbk_rsm_color_cube, 6)                                                              \
    X(highp usamplerCube, glbk_rsm_material_cube, 7)    /* ES has no precision for its kind */

#define GLBK_RSM_TEXTURES(X) GLBK_RSM_MAP_TEXTURES(X) GLBK_RSM_PICTURES(X) GLBK_RSM_IMPORT_TEXTURES(X)

#define GLBK_RSM_LIGHT_AXES_MEMBERS(X)                                                                  \
    X(vec4, position, 1)            /* w is 1; w of the next four is 0 */                               \
    X(vec4, right, 1)               /* axis x of face 0 */                                              \
    X(vec4, up, 1)                  /* axis y of face 0 */                                              \
    X(vec4, axis, 1)                /* axis z of face 0, along which light travels */                   \
    X(vec4, value, 1)               /* as in rsm_light */

#define GLBK_RSM_LIGHT_SHAPE_MEMBERS(X)                                                                 \
    X(float, extent, 1)             /* half a side of the map (sun), or the tangent */          \
    X(float, cos_half, 1)           /* cosine of half the cone */                                       \
    X(uint, side, 1)                /* texels a side of a face */                                       \
    X(uint, face_count, 1)                                                                              \
    X(uint, kind, 1)                /* rsm_light_kind */                                                \
    X(uint, unused0, 1)                                                                                 \
    X(uint, unused1, 1)                                                                                 \
    X(uint, unused2, 1)

#define GLBK_RSM_LIGHT_MEMBERS(X) GLBK_RSM_LIGHT_AXES_MEMBERS(X) GLBK_RSM_LIGHT_SHAPE_MEMBERS(X)

#define GLBK_RSM_LIST_MEMBERS(X)                                                                        \
    X(uint, interleave, 1)          /* pixels a side that share the samples */                          \
    X(uint, point_count, 1)         /* points about the receiver */                                     \
    X(uint, noise_side, 1)          /* texels a side of the noise; 0 = none */                          \
    X(uint, material_count, 1)                                                                          \
    X(uint, first_light, 1)         /* the first light of the list */                                   \
    X(uint, end_light, 1)           /* 1 + the last light of the list */                                \
    X(uint, set_room, 1)            /* lights of a set that the list has room for */                    \
    X(uint, adds, 1)                /* not 0: light is added to the sum; 0: the sum begins here */

#define GLBK_RSM_PICK_MEMBERS(X)                                                                        \
    X(uint, seed, 1)                /* of random numbers */                                             \
    X(uint, light_count, 1)         /* lights that are picked from a map */                             \
    X(uint, first_run, 1)           /* number of the first light that a pass picks for each set */      \
    X(uint, taps, 1)                /* texels a side of the filter of direct light */                   \
    X(uint, width, 1)               /* of the picture, in pixels */                                     \
    X(uint, height, 1)              /* of the picture, in pixels */                                     \
    X(uint, face, 1)                /* of running sums: the face */                                     \
    X(uint, stride, 1)              /* of running sums: texels between the values of a step */

#define GLBK_RSM_GRID_MEMBERS(X)                                                                        \
    X(uint, mode, 1)                /* what is lit: 0 pixels, 1 nodes of a grid, 2 pending pixels */    \
    X(uint, step, 1)                /* pixels from node to node, or from tap to tap of a filter */      \
    X(uint, coarse_step, 1)         /* of the grid before; 0 = there is none */                         \
    X(uint, next_step, 1)           /* of the grid after this; 0 = there is none */                     \
    X(uint, fine_step, 1)           /* compute: of the finest grid */                                   \
    X(uint, list_read, 1)           /* compute: the list that is read */                                \
    X(uint, list_pending, 1)        /* compute: the list of pixels that stay pending */                 \
    X(uint, list_wanted, 1)         /* compute: the list of nodes that are wanted */

#define GLBK_RSM_SHOW_MEMBERS(X)                                                                        \
    X(uint, motion, 1)              /* what finds history: 0 nothing, 1 a matrix, 2 a texture */        \
    X(uint, rows_top_first, 1)      /* not 0: the top row of the picture is row 0 */                    \
    X(uint, shows_direct, 1)        /* not 0: a resolve shows direct light */                           \
    X(uint, shows_bounced, 1)       /* not 0: a resolve shows bounced light */

#define GLBK_RSM_SAMPLING_MEMBERS(X)                                                                    \
    X(float, r_max, 1)              /* as in rsm_gather_desc */                                         \
    X(float, offset, 1)             /* as in rsm_gather_desc */                                         \
    X(float, clamp_at, 1)           /* rsm_gather_desc.clamp */                                         \
    X(float, near_limit, 1)         /* as in rsm_gather_desc */                                         \
    X(float, near_field, 1)         /* as in rsm_gather_desc */                                         \
    X(float, set_count, 1)          /* sets of pixels: interleave^2 */                                  \
    X(float, mixed, 1)              /* scale of RSM_PATTERN_MIXED; 0 = another pattern */               \
    X(float, picked, 1)             /* lights that RSM_PATTERN_MIXED picks by flux */

#define GLBK_RSM_TEST_MEMBERS(X)                                                                        \
    X(float, bias, 1)               /* as in rsm_direct_desc */                                         \
    X(float, slope_bias, 1)         /* as in rsm_direct_desc */                                         \
    X(float, reach, 1)              /* as in rsm_interpolation */                                       \
    X(float, contrast, 1)           /* as in rsm_interpolation */                                       \
    X(float, normal_cosine, 1)      /* as in rsm_interpolation or gifilt_frame */                       \
    X(float, plane_slope, 1)        /* as in rsm_interpolation or gifilt_frame */                       \
    X(float, most_distance, 1)      /* rsm_interpolation.distance */                                    \
    X(float, history, 1)            /* as in gifilt_frame */

#define GLBK_RSM_FRAME_MEMBERS(X)                                                                       \
    GLBK_RSM_LIST_MEMBERS(X)                                                                            \
    GLBK_RSM_PICK_MEMBERS(X)                                                                            \
    GLBK_RSM_GRID_MEMBERS(X)                                                                            \
    GLBK_RSM_SHOW_MEMBERS(X)                                                                            \
    GLBK_RSM_SAMPLING_MEMBERS(X)                                                                        \
    GLBK_RSM_TEST_MEMBERS(X)

#define GLBK_RSM_OBJECT_MEMBERS(X)                                                                      \
    X(mat4, transform, 1)           /* object to world */                                               \
    X(mat4, clip, 1)                /* world to clip space of a face, or of the last frame */           \
    X(vec4, albedo, 1)              /* w is not used */                                                 \
    X(vec4, eye, 1)                 /* where the map is seen from; w = 0: a direction */

#define GLBK_RSM_SURFACE_MEMBERS(X)                                                                     \
    X(float, near_depth, 1)         /* least depth of the map */                                        \
    X(float, depth_scale, 1)        /* 1 / the map's range of depths */                                 \
    X(float, alpha_cutoff, 1)       /* less opaque texels are holes */                                  \
    X(uint, material, 1)            /* number of a Phong lobe, from 1; 0 = none */                      \
    X(uint, has_map, 1)             /* not 0: glbk_rsm_albedo_map is a factor of the albedo */          \
    X(uint, face, 1)                /* the face that is drawn */                                        \
    X(uint, unused0, 1)                                                                                 \
    X(uint, unused1, 1)

#define GLBK_RSM_DRAWN_MEMBERS(X) GLBK_RSM_OBJECT_MEMBERS(X) GLBK_RSM_SURFACE_MEMBERS(X)

/* One face that is imported. */
#define GLBK_RSM_IMPORTED_MEMBERS(X)                                                                    \
    X(mat4, to_world, 1)            /* the space of positions and normals to world */                   \
    X(vec4, color, 1)               /* a factor of colours; w is not used */                            \
    X(float, near_depth, 1)         /* of the map's light, like far_depth */                            \
    X(float, far_depth, 1)                                                                              \
    X(uint, face, 1)                                                                                    \
    X(uint, given, 1)               /* bits of rsm_import.frag: what there is */                        \
    X(uint, normal_packing, 1)      /* glbk_normal_packing */                                           \
    X(uint, material, 1)            /* number of a Phong lobe, from 1; 0 = none */                      \
    X(uint, left, 1)                /* texels of the textures from the left, and from the bottom, */    \
    X(uint, bottom, 1)              /* at which the face begins */                                      \
    X(uint, depth_layer, 1)         /* of arrays, like the others */                                    \
    X(uint, place_layer, 1)                                                                             \
    X(uint, normal_layer, 1)                                                                            \
    X(uint, color_layer, 1)                                                                             \
    X(uint, material_layer, 1)                                                                          \
    X(uint, unused0, 1)                                                                                 \
    X(uint, unused1, 1)                                                                                 \
    X(uint, unused2, 1)

#define GLBK_RSM_BLOCKS(X)                                                                              \
    X(glbk_rsm_light, 0, GLBK_RSM_LIGHT_MEMBERS)                                                        \
    X(glbk_rsm_frame, 1, GLBK_RSM_FRAME_MEMBERS)                                                        \
    X(glbk_rsm_drawn, 2, GLBK_RSM_DRAWN_MEMBERS)                                                        \
    X(glbk_rsm_imported, 2, GLBK_RSM_IMPORTED_MEMBERS)

#define GLBK_RSM_STORAGE(X)                                                                             \
    X(coherent, uint, glbk_rsm_counts, 0)   /* four of each list: groups in x, y, z; pixels */          \
    X(readonly, uint, glbk_rsm_items, 1)    /* a list: x | y << 16 */                                   \
    X(writeonly, uint, glbk_rsm_left, 2)    /* the list of pixels that stay pending */                  \
    X(writeonly, uint, glbk_rsm_wanted, 3)  /* the list of nodes that are wanted */                     \
    X(coherent, uint, glbk_rsm_marks, 4)    /* a bit for each node of the finest grid */

#define GLBK_RSM_IMAGES(X)                                                                              \
    X(restrict, rgba32f, image2D, glbk_rsm_picture, 0)                                                  \
    X(restrict, rgba32f, image2D, glbk_rsm_nodes, 1)    /* of the finest grid and all before it */      \
    X(restrict writeonly, r32ui, uimage2DArray, glbk_rsm_running, 2)

GLBK__PART(RSM)

/* ==== src/gl_rsm/api_objects.h ==== */

/* ---- objects: read only ---- */

struct glbk_rsm_map {                   /* the map of a light; read only; zeroed = none */
    uint32_t       side;                /* texels a side of a face */
    uint32_t       face_count;          /* 1, 5 or 6 */
    rsm_light      light;               /* with its defaults */
    glbk_rsm_light block;               /* the light as shaders know it */
    glbk_buffer    buffer;              /* the block on the GPU */
    glbk_texture   texels;              /* three layers for each face: see glbk_rsm_texels */
    glbk_texture   depth;               /* the depth buffer that a face is drawn with */
    glbk_texture   sums[2];             /* running sums along rows: one is read while the other is drawn */
    glbk_texture   rows[2];             /* running sums of rows, in the same way */
    glbk_target    face_targets[6];     /* of texels */
    glbk_target    sum_targets[2][6];   /* of sums */
    glbk_target    row_targets[2][6];   /* of rows */
    glbk_texture   stats;               /* of glbk_rsm_map_stats, made when it is first called */
    glbk_target    stats_target;        /* of stats */
    int            summed;              /* not 0: the sums are those of the texels */
    int            sums_at;             /* which of sums holds them */
    int            rows_at;             /* which of rows holds them */
};

#define GLBK_RSM_PROGRAM_COUNT 28u

struct glbk_rsm_renderer {              /* the light of a picture; read only; zeroed = none */
    glbk_program    programs[GLBK_RSM_PROGRAM_COUNT];   /* compiled when they are first needed */
    glbk_texture    sums[3];            /* pictures: direct light, bounced light, and one to draw to */
    glbk_texture    grids[3];           /* grids of interpolation; by compute one */
    glbk_texture    history[2];         /* light that the filter remembers */
    glbk_texture    kept[2];            /* places and normals of that light */
    glbk_texture    lights;             /* the list of pixel lights */
    glbk_target     targets[3];         /* of sums */
    glbk_target     grid_targets[3];    /* of grids */
    glbk_target     history_targets[2]; /* of history and kept */
    glbk_target     lights_target;      /* of lights */
    glbk_texture    pattern;            /* the points of glbk_rsm_tables_upload */
    glbk_texture    noise;              /* the noise of the same call */
    glbk_texture    materials;          /* the materials of the same call */
    rsm_gather_desc tables;             /* the desc of that call, without its pointers */
    uint32_t        point_count;        /* points of the pattern */
    uint32_t        noise_side;         /* texels a side of the noise; 0 = none */
    uint32_t        material_count;     /* materials of the table */
    glbk_buffer     frame;              /* the uniform block of passes */
    glbk_buffer     object;             /* the uniform block of objects that are drawn */
    glbk_buffer     imported;           /* the uniform block of imports */
    glbk_rsm_frame  values;             /* what frame holds, or will hold */
    glbk_rsm_drawn  drawn;              /* what object holds, or will hold */
    float           before[16];         /* world to clip space of the last frame */
    uint32_t        width;              /* pixels */
    uint32_t        height;
    uint32_t        lights_per_pass;    /* as in the desc, with its default */
    glbk_attributes attributes;         /* the same */
    uint32_t        direct;             /* which of sums holds direct light; 9 = none */
    uint32_t        bounce;             /* which of sums holds bounced light; 3 and 4 = history; 9 = none */
    uint32_t        remembers;          /* 1 + which history is the newest; 0 = none */
    int             has_before;         /* not 0: before is set */
    int             drawing;            /* not 0: within a glbk_rsm_draw_fn */
    int             filtered;           /* not 0: bounced light was filtered */
    glbk_result     failed;             /* the first error of glbk_rsm_object while drawing */
    int             compute;            /* not 0: gathering and filtering are done by compute */
    glbk_buffer     counts;             /* by compute, with interpolate: lengths of the lists */
    glbk_buffer     pending[2];         /* lists of pixels that stay pending */
    glbk_buffer     wanted;             /* the list of nodes that are wanted */
    glbk_buffer     marks;              /* a bit for each node that was ever wanted */
};

/* ==== src/gl_rsm/begin.h ==== */

/* ---- end of the declarations ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_RSM_H */

/* ==== implementation ==================================================================================== */

#if defined(GL_RSM_IMPLEMENTATION) && !defined(GL_RSM_IMPLEMENTED)
#define GL_RSM_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ==== src/shared/mem.h ==== */

/* unit mem: checked sizes, and the caller's allocator with malloc and free as its default */

typedef struct glbk_rsm__allocator {
    void *(*alloc_fn)(size_t size, void *user);
    void (*free_fn)(void *memory, void *user);
    void *user;
} glbk_rsm__allocator;

static inline void *glbk_rsm__default_alloc(size_t size, void *user)
{
    (void)user;
    return malloc(size);
}

static inline void glbk_rsm__default_free(void *memory, void *user)
{
    (void)user;
    free(memory);
}

/* Writes a * b and returns 1; returns 0, with *out untouched, if the product does not fit. */
static inline int glbk_rsm__mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b) return 0;
    *out = a * b;
    return 1;
}

static inline glbk_rsm__allocator glbk_rsm__allocator_make(void *(*alloc_fn)(size_t, void *),
                                           void (*free_fn)(void *, void *), void *user)
{
    glbk_rsm__allocator a;
    a.alloc_fn = alloc_fn && free_fn ? alloc_fn : glbk_rsm__default_alloc;
    a.free_fn = alloc_fn && free_fn ? free_fn : glbk_rsm__default_free;
    a.user = user;
    return a;
}

/* Returns NULL if there is no memory, and also if the size is 0, so that a caller has one thing to test. */
static inline void *glbk_rsm__alloc(const glbk_rsm__allocator *a, size_t size)
{
    return size ? a->alloc_fn(size, a->user) : NULL;
}

static inline void *glbk_rsm__alloc_array(const glbk_rsm__allocator *a, size_t count, size_t item_size)
{
    size_t size;
    return glbk_rsm__mul_size(count, item_size, &size) ? glbk_rsm__alloc(a, size) : NULL;
}

static inline void glbk_rsm__free(const glbk_rsm__allocator *a, void *memory)
{
    if (memory) a->free_fn(memory, a->user);
}

/* ==== src/shared/v3.h ==== */

/* unit v3: three floats */

/* tcc 0.9.27 stores a returned struct of 12 bytes as 16, over the caller's next variable. */
typedef struct glbk_rsm__v3 {
    float x, y, z;
#ifdef __TINYC__
    float unused;
#endif
} glbk_rsm__v3;

static inline glbk_rsm__v3 glbk_rsm__v3_make(float x, float y, float z)
{
    glbk_rsm__v3 v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}

static inline glbk_rsm__v3 glbk_rsm__v3_load(const float *p) { return glbk_rsm__v3_make(p[0], p[1], p[2]); }
static inline void glbk_rsm__v3_store(float *p, glbk_rsm__v3 v) { p[0] = v.x; p[1] = v.y; p[2] = v.z; }

static inline glbk_rsm__v3 glbk_rsm__v3_scale(glbk_rsm__v3 a, float s)
{
    return glbk_rsm__v3_make(a.x * s, a.y * s, a.z * s);
}

static inline float glbk_rsm__v3_dot(glbk_rsm__v3 a, glbk_rsm__v3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline float glbk_rsm__v3_length(glbk_rsm__v3 a)
{
    return sqrtf(glbk_rsm__v3_dot(a, a));
}

static inline glbk_rsm__v3 glbk_rsm__v3_cross(glbk_rsm__v3 a, glbk_rsm__v3 b)
{
    return glbk_rsm__v3_make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

/* Returns a with length 1. The largest component scales the others first, so that neither tiny nor huge
   vectors leave the range of floats. The zero vector stays zero. */
static inline glbk_rsm__v3 glbk_rsm__v3_normalize(glbk_rsm__v3 a)
{
    float x = fabsf(a.x), y = fabsf(a.y), z = fabsf(a.z), m = x > y ? x : y;
    m = m > z ? m : z;
    if (!(m > 0.0f)) return glbk_rsm__v3_make(0.0f, 0.0f, 0.0f);
    if (m < 1e-30f) {
        a = glbk_rsm__v3_scale(a, 1e30f);
        m *= 1e30f;
    }
    a = glbk_rsm__v3_make(a.x / m, a.y / m, a.z / m);
    m = glbk_rsm__v3_length(a);
    return glbk_rsm__v3_make(a.x / m, a.y / m, a.z / m);
}

/* ==== src/shared/gl_memory.h ==== */

/* unit gl_memory, needs mem: the allocator of a glbk_context (gl_backend.h) */

static inline glbk_rsm__allocator glbk_rsm__memory(const glbk_context *ctx)
{
    const glbk_allocator *a = &ctx->system.allocator;
    return glbk_rsm__allocator_make(a->alloc_fn, a->free_fn, a->user);
}

/* ==== src/shared/message.h ==== */

/* unit message: one line for the caller's log that says why a call failed */

/* GLBK_RSM__COLD stands before functions that are needed only by calls that fail: compilers make these functions
   small, and take branches to them for unlikely. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define GLBK_RSM__COLD __attribute__((cold))
#else
#define GLBK_RSM__COLD
#endif

typedef struct glbk_rsm__message { char text[256]; size_t used; } glbk_rsm__message;

/* Appends a text; what does not fit is cut off. */
static inline GLBK_RSM__COLD void glbk_rsm__message_text(glbk_rsm__message *m, const char *s)
{
    while (*s && m->used + 1 < sizeof m->text) m->text[m->used++] = *s++;
    m->text[m->used] = 0;
}

static inline GLBK_RSM__COLD void glbk_rsm__message_count(glbk_rsm__message *m, uint64_t value)
{
    char digits[24];
    size_t at = sizeof digits - 1;
    digits[at] = 0;
    do digits[--at] = (char)('0' + (int)(value % 10));
    while ((value /= 10) != 0);
    glbk_rsm__message_text(m, digits + at);
}

/* Writes six significant digits without the zeros at their end. Returns how many digits are left and writes
   *exponent, the power of ten of the first one. value is finite and above 0. */
static inline GLBK_RSM__COLD int glbk_rsm__message_digits(double value, char digits[8], int *exponent)
{
    uint32_t whole;
    int count = 6, i;

    for (*exponent = 5; value >= 999999.5; value /= 10.0) ++*exponent;
    for (; value < 99999.95; value *= 10.0) --*exponent;
    whole = (uint32_t)(value + 0.5);
    if (whole > 999999) {
        whole = 100000;
        ++*exponent;
    }
    for (; count > 1 && whole % 10 == 0; count--) whole /= 10;
    for (i = count; i > 0; whole /= 10) digits[--i] = (char)('0' + (int)(whole % 10));
    digits[count] = 0;
    return count;
}

/* Appends a number, in the same way in every locale: whole numbers below 2^53 with all their digits, others
   with six, as in 0.25, -3, 1.5e-7. */
static inline GLBK_RSM__COLD void glbk_rsm__message_number(glbk_rsm__message *m, double value)
{
    char digits[8], first[2] = { 0, 0 };
    int exponent, count, i;

    if (value != value) {
        glbk_rsm__message_text(m, "not a number");
        return;
    }
    if (value < 0.0) glbk_rsm__message_text(m, "-");
    if (value < 0.0) value = -value;
    if (!(value > 0.0) || value > 1.7976931348623157e308) {
        glbk_rsm__message_text(m, value > 0.0 ? "infinity" : "0");
        return;
    }
    if (value < 9007199254740992.0 && value - (double)(uint64_t)value <= 0.0) {
        glbk_rsm__message_count(m, (uint64_t)value);
        return;
    }
    count = glbk_rsm__message_digits(value, digits, &exponent);
    first[0] = digits[0];
    if (exponent < -4 || exponent > 9) {
        glbk_rsm__message_text(m, first);
        if (count > 1) glbk_rsm__message_text(m, ".");
        glbk_rsm__message_text(m, digits + 1);
        glbk_rsm__message_text(m, exponent < 0 ? "e-" : "e");
        glbk_rsm__message_count(m, (uint64_t)(exponent < 0 ? -exponent : exponent));
        return;
    }
    if (exponent < 0) glbk_rsm__message_text(m, "0.");
    for (i = exponent; i < -1; i++) glbk_rsm__message_text(m, "0");
    for (i = 0; i < count; i++) {
        if (exponent >= 0 && i == exponent + 1) glbk_rsm__message_text(m, ".");
        first[0] = digits[i];
        glbk_rsm__message_text(m, first);
    }
    for (i = count; i <= exponent; i++) glbk_rsm__message_text(m, "0");
}

/* ==== GLSL of src/gl_rsm ==== */


static const struct { char facts[44];
    char s0[647]; char end; } glbk__glsl_lib_rsm_access_glsl GLBK__TIGHT = {
    "lib/rsm_access.glsl\0" "rsm_bindings rsm_map" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n#define RSM_TEXEL(t, k) texelFetch(glbk_rsm_texels, ivec3((t).xy, 3 * (t).z + (k)), 0)\n"
    "\n#define RSM_ROW_SUM(t) uintBitsToFloat(texelFetch(glbk_rsm_sums, t, 0).x)\n"
    "#define RSM_ROWS_SUM(y, face) uintBitsToFloat(texelFetch(glbk_rsm_rows, ivec3(y, 0, face), 0).x)\n"
    "\n\n#define RSM_LISTED(i, k) texelFetch(glbk_rsm_lights, ivec3(int((i) & 1023u), int((i) >> 10), k), 0)\n"
    "#define RSM_PATTERN(i) texelFetch(glbk_rsm_pattern, ivec2(int((i) & 1023u), int((i) >> 10)), 0).xyz\n"
    "#ifndef RSM_LIGHT\n"
    "#define RSM_LIGHT(i, k) RSM_LISTED(i, k)\n"
    "#define RSM_POINT_AT(i) RSM_PATTERN(i)\n"
    "#endif\n"
    "#define RSM_MATERIAL(i) texelFetch(glbk_rsm_materials, ivec2(int(i), 0), 0)\n", 0
};

static const struct { char facts[26];
    char s0[1462]; char end; } glbk__glsl_lib_rsm_bindings_glsl GLBK__TIGHT = {
    "lib/rsm_bindings.glsl\0" "" "\0" "" "\0"
    "" "\0" "",
    "\nuniform usampler2DArray glbk_rsm_texels,glbk_rsm_sums,glbk_rsm_rows,glbk_rsm_lights;\n"
    "uniform sampler2D glbk_rsm_pattern,glbk_rsm_noise,glbk_rsm_materials;\n"
    "uniform glbk_color_sampler glbk_rsm_sum,glbk_rsm_states,glbk_rsm_coarse,\n"
    "glbk_rsm_history;\n"
    "uniform usampler2DArray glbk_rsm_before;\n"
    "uniform sampler2D glbk_rsm_motion,glbk_rsm_albedo_map,glbk_rsm_depth_in,\n"
    "glbk_rsm_place_in,glbk_rsm_normal_in,glbk_rsm_color_in;\n"
    "uniform usampler2D glbk_rsm_material_in;\n"
    "uniform sampler2DArray glbk_rsm_depth_array,glbk_rsm_place_array,glbk_rsm_normal_array,\n"
    "glbk_rsm_color_array;\n"
    "uniform usampler2DArray glbk_rsm_material_array;\n"
    "uniform samplerCube glbk_rsm_depth_cube,glbk_rsm_place_cube,glbk_rsm_normal_cube,\n"
    "glbk_rsm_color_cube;\n"
    "uniform highp usamplerCube glbk_rsm_material_cube;\n"
    "#if __VERSION__ >= 430\n"
    "layout(std430,binding=0)coherent buffer glbk_rsm_counts_storage{uint glbk_rsm_counts[];};\n"
    "layout(std430,binding=1)readonly buffer glbk_rsm_items_storage{uint glbk_rsm_items[];};\n"
    "layout(std430,binding=2)writeonly buffer glbk_rsm_left_storage{uint glbk_rsm_left[];};\n"
    "layout(std430,binding=3)writeonly buffer glbk_rsm_wanted_storage{uint glbk_rsm_wanted[];};\n"
    "layout(std430,binding=4)coherent buffer glbk_rsm_marks_storage{uint glbk_rsm_marks[];};\n"
    "layout(rgba32f,binding=0)restrict uniform image2D glbk_rsm_picture;\n"
    "layout(rgba32f,binding=1)restrict uniform image2D glbk_rsm_nodes;\n"
    "layout(r32ui,binding=2)restrict writeonly uniform uimage2DArray glbk_rsm_running;\n"
    "#endif\n", 0
};

static const struct { char facts[58];
    char s0[980]; char end; } glbk__glsl_lib_rsm_bounce_glsl GLBK__TIGHT = {
    "lib/rsm_bounce.glsl\0" "rsm_screen rsm_gather rsm_sampling" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\nvec2 rsm_turn(ivec2 at)\n"
    "{\n"
    "uint noise=glbk_rsm_frame.noise_side;\n"
    "if(noise==0u)return vec2(1.,.0);\n"
    "float angle=2.*RSM_PI*texelFetch(glbk_rsm_noise,ivec2(uvec2(at)%noise),0).x;\n"
    "return vec2(cos(angle),sin(angle));\n"
    "}\n"
    "\n\nvec3 rsm_listed(rsm_light l,rsm_receiver r,uint from,uint to)\n"
    "{\n"
    "return rsm_gather_list(l,r.position,r.normal,from,to,glbk_rsm_frame.material_count!=0u,\n"
    "glbk_rsm_frame.mixed);\n"
    "}\n"
    "\n\nvec3 rsm_about(rsm_light l,rsm_receiver r,vec2 turn,uint first,uint step,uint count)\n"
    "{\n"
    "return rsm_gather_about(l,r.position,r.normal,rsm_bound_sampling(),turn,first,step,count);\n"
    "}\n"
    "\n\nvec3 rsm_bounce(rsm_receiver r,ivec2 at)\n"
    "{\n"
    "uint k=glbk_rsm_frame.interleave,set=rsm_set(at),base=set*glbk_rsm_frame.set_room;\n"
    "uint from=glbk_rsm_frame.first_light,to=glbk_rsm_frame.end_light,count=glbk_rsm_frame.point_count;\n"
    "rsm_light l=rsm_bound();\n"
    "vec3 sum=vec3(.0);\n"
    "if(to>from)sum=rsm_listed(l,r,base+from,base+to);\n"
    "if(count>0u)sum+=rsm_about(l,r,rsm_turn(at),set,k*k,count);\n"
    "return sum/RSM_PI;\n"
    "}\n", 0
};

static const struct { char facts[40];
    char s0[396]; char end; } glbk__glsl_lib_rsm_bound_glsl GLBK__TIGHT = {
    "lib/rsm_bound.glsl\0" "rsm_map rsm_light" "\0" "" "\0"
    "" "\0" "",
    "\n\nrsm_light rsm_bound()\n"
    "{\n"
    "rsm_light l;\n"
    "l.position=glbk_rsm_light.position.xyz;\n"
    "l.right=glbk_rsm_light.right.xyz;\n"
    "l.up=glbk_rsm_light.up.xyz;\n"
    "l.axis=glbk_rsm_light.axis.xyz;\n"
    "l.value=glbk_rsm_light.value.xyz;\n"
    "l.extent=glbk_rsm_light.extent;\n"
    "l.cos_half=glbk_rsm_light.cos_half;\n"
    "l.side=float(glbk_rsm_light.side);\n"
    "l.faces=int(glbk_rsm_light.face_count);\n"
    "l.kind=int(glbk_rsm_light.kind);\n"
    "return l;\n"
    "}\n", 0
};

static const struct { char facts[23];
    char s0[183]; char end; } glbk__glsl_lib_rsm_chunk_glsl GLBK__TIGHT = {
    "lib/rsm_chunk.glsl\0" "" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n#define RSM_CHUNK 64u\n"
    "shared uvec4 rsm_chunk[4u*RSM_CHUNK];\n"
    "#define RSM_LIGHT(i, k) rsm_chunk[RSM_CHUNK * uint(k) + (i)]\n"
    "#define RSM_POINT_AT(i) uintBitsToFloat(rsm_chunk[i].xyz)\n", 0
};

static const struct { char facts[44];
    char s0[1638]; char end; } glbk__glsl_lib_rsm_direct_glsl GLBK__TIGHT = {
    "lib/rsm_direct.glsl\0" "rsm_access rsm_bound" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\nfloat rsm_unshadowed(rsm_light l,vec3 p,vec3 n)\n"
    "{\n"
    "vec3 to=rsm_to_light(l,p),d=p-l.position;\n"
    "float d2=dot(d,d),cosine=dot(n,to),along=-dot(l.axis,to);\n"
    "if(!(cosine>.0))return .0;\n"
    "if(l.kind==RSM_SUN)return cosine;\n"
    "if(!(d2>.0))return .0;\n"
    "if(l.kind==RSM_SPOT&&!(along>=l.cos_half))return .0;\n"
    "if(l.kind==RSM_SQUARE_SPOT){\n"
    "vec3 q=rsm_to_face(l,0,p);\n"
    "if(!(q.z>.0&&abs(q.x)<=1.&&abs(q.y)<=1.))return .0;\n"
    "}\n"
    "if(l.kind==RSM_PATCH)cosine*=max(along,.0);\n"
    "return cosine/d2;\n"
    "}\n"
    "\n\n\n\nfloat rsm_pcf(rsm_light l,vec3 p,float cosine,int taps,float bias,float slope_bias)\n"
    "{\n"
    "int face=rsm_face_of_direction(l,p-l.position),size=int(l.side);\n"
    "if(face>=l.faces)return .0;\n"
    "vec3 q=rsm_to_face(l,face,p);\n"
    "if(l.kind!=RSM_SUN&&!(q.z>.0))return .0;\n"
    "if(!(abs(q.x)<=1.&&abs(q.y)<=1.))return l.kind==RSM_SUN?1.:.0;\n"
    "float texel=2./l.side*l.extent*(l.kind==RSM_SUN?1.:q.z);\n"
    "float slope=cosine<1.?min(sqrt(1.-cosine*cosine)/max(cosine,.1),10.):.0;\n"
    "float reach=q.z-texel*(bias+slope_bias*slope*.7072*float(taps));\n"
    "vec2 first=(q.xy*.5+.5)*l.side-.5*float(taps-1),f=first-floor(first);\n"
    "float sum=.0,total=.0;\n"
    "for(int j=0;j<taps;j++)\n"
    "for(int i=0;i<taps;i++){\n"
    "vec2 w=vec2(i==0?1.-f.x:i==taps-1?f.x:1.,\n"
    "j==0?1.-f.y:j==taps-1?f.y:1.);\n"
    "float weight=taps==1?1.:w.x*w.y;\n"
    "ivec3 t=ivec3(clamp(ivec2(floor(first))+ivec2(i,j),ivec2(0),ivec2(size-1)),face);\n"
    "total+=weight;\n"
    "if(reach<=uintBitsToFloat(RSM_TEXEL(t,0).w))sum+=weight;\n"
    "}\n"
    "return total>.0?sum/total:.0;\n"
    "}\n"
    "\n\n\nvec3 rsm_direct(rsm_light l,vec3 p,vec3 n,int taps,float bias,float slope_bias)\n"
    "{\n"
    "float light=rsm_unshadowed(l,p,n);\n"
    "if(light>.0)light*=rsm_pcf(l,p,dot(n,rsm_to_light(l,p)),taps,bias,slope_bias);\n"
    "return light*l.value;\n"
    "}\n", 0
};

static const struct { char facts[37];
    char s0[188]; char end; } glbk__glsl_lib_rsm_drawn_glsl GLBK__TIGHT = {
    "lib/rsm_drawn.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_rsm_drawn",
    "\nlayout(std140)uniform glbk_rsm_drawn_block{\n"
    "mat4 transform,clip;\n"
    "vec4 albedo,eye;\n"
    "float near_depth,depth_scale,alpha_cutoff;\n"
    "uint material,has_map,face,unused0,unused1;\n"
    "}glbk_rsm_drawn;\n", 0
};

static const struct { char facts[37];
    char s0[494]; char end; } glbk__glsl_lib_rsm_frame_glsl GLBK__TIGHT = {
    "lib/rsm_frame.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_rsm_frame",
    "\nlayout(std140)uniform glbk_rsm_frame_block{\n"
    "uint interleave,point_count,noise_side,material_count,first_light,end_light,\n"
    "set_room,adds,seed,light_count,first_run,taps,width,height,face,stride,mode,\n"
    "step,coarse_step,next_step,fine_step,list_read,list_pending,list_wanted,motion,\n"
    "rows_top_first,shows_direct,shows_bounced;\n"
    "float r_max,offset,clamp_at,near_limit,near_field,set_count,mixed,picked,bias,\n"
    "slope_bias,reach,contrast,normal_cosine,plane_slope,most_distance,history;\n"
    "}glbk_rsm_frame;\n", 0
};

static const struct { char facts[32];
    char s0[3982]; char s1[3241]; char end; } glbk__glsl_lib_rsm_gather_glsl GLBK__TIGHT = {
    "lib/rsm_gather.glsl\0" "rsm_pick" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n#ifndef RSM_SURFACES\n"
    "#define RSM_SURFACES 0\n"
    "#endif\n"
    "\n\nfloat rsm_near=.0;\n"
    "\nstruct rsm_sampling{\n"
    "float r_max;\n"
    "float offset;\n"
    "float clamp_at;\n"
    "float near_limit;\n"
    "float near_field;\n"
    "float set_count;\n"
    "float mixed;\n"
    "float picked;\n"
    "bool glossy;\n"
    "};\n"
    "\nstruct rsm_centre{\n"
    "vec3 at;\n"
    "vec3 right,up;\n"
    "};\n"
    "\n\n\nfloat rsm_form(vec3 p,vec3 n,vec3 light,vec3 light_normal,float bound)\n"
    "{\n"
    "vec3 d=light-p,most=max(abs(p),abs(light));\n"
    "float rounding=4e-7*max(max(most.x,most.y),most.z),inverse=1./max(dot(d,d),1e-18);\n"
    "float receives=max(dot(n,d)-rounding,.0),emits=max(-dot(light_normal,d)-rounding,.0);\n"
    "float form=(receives*inverse)*(emits*inverse);\n"
    "if(form*dot(d,d)>1e-3)rsm_near=max(rsm_near,inverse);\n"
    "return min(form,bound);\n"
    "}\n"
    "\n#if RSM_SURFACES\n"
    "\n\n\nvoid rsm_texel_sides(rsm_light l,int face,vec3 p,vec3 n,out vec3 side,out vec3 other)\n"
    "{\n"
    "vec3 a,d;\n"
    "float scale=l.extent/l.side;\n"
    "rsm_face_axes(l,face,side,other,a);\n"
    "d=a;\n"
    "if(l.kind!=RSM_SUN){\n"
    "float depth=dot(p-l.position,a);\n"
    "d=(p-l.position)/depth;\n"
    "scale*=depth;\n"
    "}\n"
    "float facing=dot(d,n),least=.05*length(d),\n"
    "bounded=max(abs(facing),least)*(facing<.0?-1.:1.);\n"
    "vec3 along=d-n*facing;\n"
    "vec2 off=vec2(dot(side,n),dot(other,n)),stretched=off/bounded;\n"
    "if(abs(facing)<least)\n"
    "stretched+=vec2(dot(side,along),dot(other,along))*\n"
    "((1.-abs(facing)/least)/dot(along,along));\n"
    "side=(side-n*off.x-along*stretched.x)*scale;\n"
    "other=(other-n*off.y-along*stretched.y)*scale;\n"
    "}\n"
    "\n\nfloat rsm_edge(vec3 n,vec3 a,vec3 b)\n"
    "{\n"
    "vec3 c=cross(b-a,a);\n"
    "float size=length(c);\n"
    "return size>.0?atan(size,dot(a,b))*(dot(n,c)/size):.0;\n"
    "}\n"
    "\n\n\nfloat rsm_clipped_edge(vec3 n,vec3 a,vec3 b,inout vec3 leave,inout vec3 come)\n"
    "{\n"
    "float ha=dot(n,a),hb=dot(n,b);\n"
    "if(!(ha>.0)&&!(hb>.0))return .0;\n"
    "if(!(ha>.0&&hb>.0)){\n"
    "vec3 at=a+(b-a)*(ha/(ha-hb));\n"
    "if(ha>.0)b=leave=at;\n"
    "else a=come=at;\n"
    "}\n"
    "return rsm_edge(n,a,b);\n"
    "}\n"
    "\n\n\n\n\nfloat rsm_form_of(vec3 n,vec3 c,vec3 u,vec3 v)\n"
    "{\n"
    "vec3 p=c-u-v,q=c+u-v,r=c+u+v,s=c-u+v;\n"
    "vec3 leave=c,come=c;\n"
    "float sum=rsm_clipped_edge(n,p,q,leave,come)+rsm_clipped_edge(n,q,r,leave,come);\n"
    "sum+=rsm_clipped_edge(n,r,s,leave,come)+rsm_clipped_edge(n,s,p,leave,come);\n"
    "return .5*abs(sum+rsm_edge(n,leave,come));\n"
    "}\n"
    "#endif\n"
    "\n\n\n\n\nfloat rsm_texel_form(rsm_light l,vec3 p,vec3 n,int face,vec3 light,vec3 light_normal,float bound,\n"
    "float near2)\n"
    "{\n"
    "float form=rsm_form(p,n,light,light_normal,bound);\n"
    "#if RSM_SURFACES\n"
    "vec3 d=light-p,most=max(abs(p),abs(light)),u,v;\n"
    "float height=-dot(light_normal,d),d2=dot(d,d),facing=-2.*dot(n,light_normal);\n"
    "if(!(d2<near2))return form;\n"
    "if(!(height>4e-7*max(max(most.x,most.y),most.z)))return .0;\n"
    "rsm_texel_sides(l,face,light,light_normal,u,v);\n"
    "float area=4.*length(cross(u,v)),point=max(dot(n,d)/d2,.0)*(height/d2);\n"
    "form=area>.0?rsm_form_of(n,d,u,v)/area:.0;\n"
    "if(form>point&&facing>.0&&4.*height*height<area)\n"
    "form+=min(facing,1.)*(1.-2.*height/sqrt(area))*(point-form);\n"
    "form=min(form,bound);\n"
    "#endif\n"
    "return form;\n"
    "}\n"
    "\n\n\nvec3 rsm_gloss(rsm_light l,vec3 p,vec3 light,vec3 light_normal,float form,vec3 incident,vec4 material)\n"
    "{\n"
    "vec3 to=rsm_to_light(l,light),mirror=2.*dot(light_normal,to)*light_normal-to,d=p-light;\n"
    "float c=dot(mirror,d)/max(sqrt(dot(d,d)),1e-9);\n"
    "if(!(c>.0))return vec3(.0);\n"
    "return incident*material.xyz*(.5*(material.w+2.)*pow(min(c,1.),material.w))*form;\n"
    "}\n"
    "\n\nfloat rsm_bound_of(float area,float limit_clamp,float near_limit)\n"
    "{\n"
    "float bound=limit_clamp>.0?limit_clamp:3.0e38;\n"
    "return near_limit>.0&&area>.0?min(bound,near_limit*RSM_PI/area):bound;\n"
    "}\n"
    "\n\nvec3 rsm_mixed_place(rsm_light l,ivec3 t)\n"
    "{\n"
    "vec2 q=vec2(rsm_texel_centre(l,t.x),rsm_texel_centre(l,t.y));\n"
    "vec3 r,u,a;\n"
    "if(l.faces==1)return vec3(q*.5+.5,.0);\n"
    "rsm_face_axes(l,t.z,r,u,a);\n"
    "return rsm_normalize(a+r*q.x+u*q.y)*.5;\n"
    "}\n"
    "\n\n\nrsm_centre rsm_centre_of(rsm_light l,vec3 p,bool inside)\n"
    "{\n"
    "rsm_centre centre=rsm_centre(vec3(.0),vec3(.0),vec3(.0));\n"
    "if(l.faces!=1){\n"
    "vec3 c=rsm_normalize(p-l.position);\n"
    "if(!(dot(c,c)>.25))c=l.axis;\n"
    "float s=c.z>=.0?1.:-1.,a=-1./(s+c.z),b=c.x*c.y*a;\n"
    "centre.right=vec3(1.+s*c.x*c.x*a,s*b,-s*c.x);\n"
    "centre.up=vec3(b,s+c.y*c.y*a,-c.y);\n"
    "centre.at=c;\n"
    "return centre;\n"
    "}\n"
    "vec3 q=rsm_to_face(l,0,p);\n",
    "if(l.kind!=RSM_SUN&&!(q.z>.0))q=vec3(.0);\n"
    "q=vec3(q.xy*.5+.5,.0);\n"
    "centre.at=inside?vec3(clamp(q.xy,.02,.98),.0):q;\n"
    "return centre;\n"
    "}\n"
    "\n\n\n\nbool rsm_place_sample(rsm_light l,float r_max,rsm_centre centre,vec3 point,vec2 turn,out ivec3 t,\n"
    "out float weight)\n"
    "{\n"
    "vec2 q=vec2(point.x*turn.x-point.y*turn.y,point.x*turn.y+point.y*turn.x);\n"
    "int size=int(l.side);\n"
    "t=ivec3(0);\n"
    "weight=.0;\n"
    "if(l.faces==1){\n"
    "float r=r_max;\n"
    "if(!(r>.0)){\n"
    "float len=length(q);\n"
    "vec2 d=len>.0?q/len:vec2(.0),room;\n"
    "room.x=abs(d.x)>1e-9?(d.x>.0?1.-centre.at.x:centre.at.x)/abs(d.x):4.;\n"
    "room.y=abs(d.y)>1e-9?(d.y>.0?1.-centre.at.y:centre.at.y)/abs(d.y):4.;\n"
    "r=min(room.x,room.y);\n"
    "}\n"
    "weight=point.z*r*r*l.side*l.side;\n"
    "q=(centre.at.xy+r*q)*l.side;\n"
    "if(!(r_max>.0))q=clamp(q,vec2(.0),vec2(l.side-.5));\n"
    "if(any(lessThan(q,vec2(.0)))||any(greaterThanEqual(q,vec2(l.side))))return false;\n"
    "t=ivec3(ivec2(q),0);\n"
    "return true;\n"
    "}\n"
    "float r=r_max>.0&&r_max<1.?r_max:1.;\n"
    "q*=r;\n"
    "float s=dot(q,q),k=2.*sqrt(max(1.-s,.0));\n"
    "vec3 d=centre.at*(1.-2.*s)+centre.right*(q.x*k)+centre.up*(q.y*k),a,fr,fu;\n"
    "t.z=rsm_face_of_direction(l,d);\n"
    "if(t.z>=l.faces)return false;\n"
    "rsm_face_axes(l,t.z,fr,fu,a);\n"
    "q=vec2(dot(d,fr),dot(d,fu))/dot(d,a);\n"
    "t.xy=min(ivec2((q*.5+.5)*l.side),ivec2(size-1));\n"
    "q=vec2(rsm_texel_centre(l,t.x),rsm_texel_centre(l,t.y));\n"
    "s=1.+dot(q,q);\n"
    "weight=point.z*r*r*l.side*l.side*s*sqrt(s);\n"
    "return true;\n"
    "}\n"
    "\n\n\nvec3 rsm_gather_list(rsm_light l,vec3 p,vec3 n,uint from,uint to,bool glossy,float mixed)\n"
    "{\n"
    "vec3 sum=vec3(.0),centre=vec3(.0);\n"
    "if(mixed>.0)centre=rsm_centre_of(l,p,true).at*(l.faces==1?1.:.5);\n"
    "for(uint i=from;i<to;i++){\n"
    "vec4 a=uintBitsToFloat(RSM_LIGHT(i,0)),b=uintBitsToFloat(RSM_LIGHT(i,1));\n"
    "uvec4 c=RSM_LIGHT(i,2);\n"
    "float w=1.,near2=mixed>.0?.0:b.w;\n"
    "float form=rsm_texel_form(l,p,n,int(c.w>>24),a.xyz,b.xyz,a.w,near2);\n"
    "if(mixed>.0){\n"
    "ivec3 t=ivec3(c.w&4095u,(c.w>>12)&4095u,c.w>>24);\n"
    "vec3 d=rsm_mixed_place(l,t)-centre;\n"
    "w=(dot(d,d)+2.7127e-5)*b.w;\n"
    "w=w/(w+mixed);\n"
    "}\n"
    "vec3 light=uintBitsToFloat(c.xyz)*form;\n"
    "if(glossy){\n"
    "uvec4 g=RSM_LIGHT(i,3);\n"
    "if(g.w!=0u)\n"
    "light+=rsm_gloss(l,p,a.xyz,b.xyz,form,uintBitsToFloat(g.xyz),RSM_MATERIAL(g.w-1u));\n"
    "}\n"
    "sum+=light*w;\n"
    "}\n"
    "return sum;\n"
    "}\n"
    "\n\n\nvec3 rsm_gather_about(rsm_light l,vec3 p,vec3 n,rsm_sampling s,vec2 turn,uint first,uint step,\n"
    "uint count)\n"
    "{\n"
    "vec3 sum=vec3(.0);\n"
    "rsm_centre centre=rsm_centre_of(l,p,!(s.r_max>.0));\n"
    "float total=s.picked>.0?rsm_total(l):.0;\n"
    "for(uint i=0u;i<count;i++){\n"
    "ivec3 t;\n"
    "float weight;\n"
    "if(!rsm_place_sample(l,s.r_max,centre,RSM_POINT_AT(first+i*step),turn,t,weight))continue;\n"
    "vec4 flux=uintBitsToFloat(RSM_TEXEL(t,2));\n"
    "float mean=rsm_mean3(flux.xyz);\n"
    "if(!(mean>.0)&&!s.glossy)continue;\n"
    "if(total>.0){\n"
    "vec3 d=rsm_mixed_place(l,t)-centre.at*(l.faces==1?1.:.5);\n"
    "weight*=s.mixed/((dot(d,d)+2.7127e-5)*s.picked*mean/total+s.mixed);\n"
    "}\n"
    "vec3 light=uintBitsToFloat(RSM_TEXEL(t,0).xyz);\n"
    "uvec4 b=RSM_TEXEL(t,1);\n"
    "vec3 light_normal=uintBitsToFloat(b.xyz);\n"
    "light-=s.offset*light_normal;\n"
    "float bound=rsm_bound_of(flux.w*weight,s.clamp_at,s.near_limit);\n"
    "float near2=s.near_field*s.near_field*flux.w;\n"
    "float form=rsm_texel_form(l,p,n,t.z,light,light_normal,bound,near2);\n"
    "vec3 e=flux.xyz*form;\n"
    "if(s.glossy&&b.w!=0u)\n"
    "e+=rsm_gloss(l,p,light,light_normal,form,rsm_incident(l,t.z,t.xy)*l.value,\n"
    "RSM_MATERIAL(b.w-1u));\n"
    "sum+=e*(weight*s.set_count);\n"
    "}\n"
    "return sum;\n"
    "}\n", 0
};

static const struct { char facts[32];
    char s0[1792]; char end; } glbk__glsl_lib_rsm_grid_glsl GLBK__TIGHT = {
    "lib/rsm_grid.glsl\0" "rsm_screen" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\nbool rsm_node(ivec2 at,out rsm_receiver s,out vec4 node);\n"
    "\n\n\nvoid rsm_grid_lines(int at,int step,int size,out ivec2 line,out float share)\n"
    "{\n"
    "line=ivec2(at/step*step,min((at/step+1)*step,size-1));\n"
    "share=line.y>line.x?float(at-line.x)/float(line.y-line.x):.0;\n"
    "}\n"
    "\n\n\nbool rsm_suits(rsm_receiver p,rsm_receiver s,float reach2)\n"
    "{\n"
    "vec3 d=s.position-p.position;\n"
    "float len=length(d),plane=max(abs(dot(d,p.normal)),abs(dot(d,s.normal)));\n"
    "float most=glbk_rsm_frame.most_distance;\n"
    "if(dot(s.normal,p.normal)<glbk_rsm_frame.normal_cosine)return false;\n"
    "if(plane>glbk_rsm_frame.plane_slope*len)return false;\n"
    "return(!(most>.0)||len<=most)&&dot(d,d)<=reach2;\n"
    "}\n"
    "\n\n\nbool rsm_interpolate(ivec2 at,int step,ivec2 size,rsm_receiver p,out vec3 result)\n"
    "{\n"
    "ivec2 lx,ly;\n"
    "vec2 f;\n"
    "vec3 value[4];\n"
    "float low=3.0e38,high=.0,sum=.0;\n"
    "float reach=glbk_rsm_frame.reach,contrast=glbk_rsm_frame.contrast;\n"
    "int good=0,missing=-1;\n"
    "rsm_grid_lines(at.x,step,size.x,lx,f.x);\n"
    "rsm_grid_lines(at.y,step,size.y,ly,f.y);\n"
    "for(int k=0;k<4;k++){\n"
    "bool right=(k&1)!=0,upper=(k&2)!=0;\n"
    "ivec2 line=ivec2(right?lx.y:lx.x,upper?ly.y:ly.x);\n"
    "rsm_receiver s;\n"
    "vec4 node;\n"
    "bool seen=rsm_node(line,s,node);\n"
    "value[k]=node.xyz;\n"
    "float reach2=reach>.0?rsm_node_distance2(node.w)*reach*reach:3.0e38;\n"
    "if(node.w>=.0||!seen||!rsm_suits(p,s,reach2)){\n"
    "missing=k;\n"
    "continue;\n"
    "}\n"
    "float mean=rsm_mean3(node.xyz);\n"
    "low=min(low,mean);\n"
    "high=max(high,mean);\n"
    "sum+=mean;\n"
    "good++;\n"
    "}\n"
    "result=vec3(.0);\n"
    "if(good<3||(contrast>=.0&&high-low>contrast*sum/float(good)))return false;\n"
    "if(missing==0)value[0]=value[1]+value[2]-value[3];\n"
    "if(missing==1)value[1]=value[0]+value[3]-value[2];\n"
    "if(missing==2)value[2]=value[3]+value[0]-value[1];\n"
    "if(missing==3)value[3]=value[2]+value[1]-value[0];\n"
    "result=max(mix(mix(value[0],value[1],f.x),mix(value[2],value[3],f.x),f.y),vec3(.0));\n"
    "return true;\n"
    "}\n", 0
};

static const struct { char facts[43];
    char s0[266]; char end; } glbk__glsl_lib_rsm_imported_glsl GLBK__TIGHT = {
    "lib/rsm_imported.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_rsm_imported",
    "\nlayout(std140)uniform glbk_rsm_imported_block{\n"
    "mat4 to_world;\n"
    "vec4 color;\n"
    "float near_depth,far_depth;\n"
    "uint face,given,normal_packing,material,left,bottom,depth_layer,place_layer,\n"
    "normal_layer,color_layer,material_layer,unused0,unused1,unused2;\n"
    "}glbk_rsm_imported;\n", 0
};

static const struct { char facts[37];
    char s0[172]; char end; } glbk__glsl_lib_rsm_light_glsl GLBK__TIGHT = {
    "lib/rsm_light.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_rsm_light",
    "\nlayout(std140)uniform glbk_rsm_light_block{\n"
    "vec4 position,right,up,axis,value;\n"
    "float extent,cos_half;\n"
    "uint side,face_count,kind,unused0,unused1,unused2;\n"
    "}glbk_rsm_light;\n", 0
};

static const struct { char facts[33];
    char s0[2126]; char end; } glbk__glsl_lib_rsm_lists_glsl GLBK__TIGHT = {
    "lib/rsm_lists.glsl\0" "rsm_screen" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n#ifndef RSM_GROUP\n"
    "#define RSM_GROUP 64\n"
    "#endif\n"
    "shared uint rsm_pending[RSM_GROUP],rsm_wanted[4*RSM_GROUP];\n"
    "shared uint rsm_pending_count,rsm_wanted_count,rsm_pending_at,rsm_wanted_at;\n"
    "\n\nuint rsm_pack_pixel(ivec2 at){return uint(at.x)|uint(at.y)<<16;}\n"
    "\nivec2 rsm_unpack_pixel(uint item){return ivec2(item&65535u,item>>16);}\n"
    "\n\n\nbool rsm_item(uint list,out ivec2 at)\n"
    "{\n"
    "uint i=64u*(gl_WorkGroupID.y*gl_NumWorkGroups.x+gl_WorkGroupID.x)+gl_LocalInvocationIndex;\n"
    "bool inside=i<glbk_rsm_counts[4u*list+3u];\n"
    "at=ivec2(0);\n"
    "if(inside)at=rsm_unpack_pixel(glbk_rsm_items[i]);\n"
    "return inside;\n"
    "}\n"
    "\n\nvoid rsm_begin_lists()\n"
    "{\n"
    "if(gl_LocalInvocationIndex==0u)rsm_pending_count=rsm_wanted_count=0u;\n"
    "barrier();\n"
    "}\n"
    "\n\nvoid rsm_add_pending(ivec2 at){rsm_pending[atomicAdd(rsm_pending_count,1u)]=rsm_pack_pixel(at);}\n"
    "\n\nvoid rsm_add_wanted(ivec2 at){rsm_wanted[atomicAdd(rsm_wanted_count,1u)]=rsm_pack_pixel(at);}\n"
    "\n\nuint rsm_mark(ivec2 number,ivec2 last){return uint(number.y*(last.x+1)+number.x);}\n"
    "\n\nvoid rsm_want(ivec2 at)\n"
    "{\n"
    "int fine=int(glbk_rsm_frame.fine_step);\n"
    "ivec2 number=rsm_node_number(at,fine),last=rsm_node_number(rsm_picture_side()-1,fine);\n"
    "uint i=rsm_mark(number,last),bit=1u<<(i&31u);\n"
    "if((glbk_rsm_marks[i>>5]&bit)!=0u||(atomicOr(glbk_rsm_marks[i>>5],bit)&bit)!=0u)return;\n"
    "rsm_receiver r;\n"
    "if(rsm_read(at,r)&&texelFetch(glbk_rsm_coarse,number,0).w>=.0)rsm_add_wanted(at);\n"
    "}\n"
    "\n\n\n\nuint rsm_room(uint list,uint count)\n"
    "{\n"
    "uint at=atomicAdd(glbk_rsm_counts[4u*list+3u],count);\n"
    "uint before=(at+63u)/64u,groups=(at+count+63u)/64u;\n"
    "if(groups>before){\n"
    "if(before<1024u)atomicMax(glbk_rsm_counts[4u*list],min(groups,1024u));\n"
    "atomicMax(glbk_rsm_counts[4u*list+1u],(groups+1023u)/1024u);\n"
    "}\n"
    "return at;\n"
    "}\n"
    "\n\nvoid rsm_end_lists(uint pending_list,uint wanted_list)\n"
    "{\n"
    "uint i=gl_LocalInvocationIndex;\n"
    "barrier();\n"
    "if(i==0u&&rsm_pending_count>0u)rsm_pending_at=rsm_room(pending_list,rsm_pending_count);\n"
    "if(i==0u&&rsm_wanted_count>0u)rsm_wanted_at=rsm_room(wanted_list,rsm_wanted_count);\n"
    "barrier();\n"
    "if(i<rsm_pending_count)glbk_rsm_left[rsm_pending_at+i]=rsm_pending[i];\n"
    "for(;i<rsm_wanted_count;i+=uint(RSM_GROUP))glbk_rsm_wanted[rsm_wanted_at+i]=rsm_wanted[i];\n"
    "}\n", 0
};

static const struct { char facts[21];
    char s0[3006]; char end; } glbk__glsl_lib_rsm_map_glsl GLBK__TIGHT = {
    "lib/rsm_map.glsl\0" "" "\0" "" "\0"
    "" "\0" "",
    "\nconst int RSM_SUN=1;\n"
    "const int RSM_SPOT=2;\n"
    "const int RSM_SQUARE_SPOT=3;\n"
    "const int RSM_POINT=4;\n"
    "const int RSM_PATCH=5;\n"
    "const float RSM_PI=3.14159265;\n"
    "\nstruct rsm_light{\n"
    "vec3 position;\n"
    "vec3 right,up,axis;\n"
    "vec3 value;\n"
    "float extent;\n"
    "float cos_half;\n"
    "float side;\n"
    "int faces,kind;\n"
    "};\n"
    "\n\nvec3 rsm_normalize(vec3 v)\n"
    "{\n"
    "float d=dot(v,v);\n"
    "return d>.0?v/sqrt(d):vec3(.0);\n"
    "}\n"
    "\n\nvoid rsm_face_axes(rsm_light l,int face,out vec3 r,out vec3 u,out vec3 a)\n"
    "{\n"
    "r=l.right;\n"
    "u=l.up;\n"
    "a=l.axis;\n"
    "if(face==1){r=-l.axis;a=l.right;}\n"
    "else if(face==2){r=l.axis;a=-l.right;}\n"
    "else if(face==3){u=-l.axis;a=l.up;}\n"
    "else if(face==4){u=l.axis;a=-l.up;}\n"
    "else if(face==5){r=-l.right;a=-l.axis;}\n"
    "}\n"
    "\n\nvec3 rsm_to_face(rsm_light l,int face,vec3 p)\n"
    "{\n"
    "vec3 r,u,a,q=p-l.position;\n"
    "rsm_face_axes(l,face,r,u,a);\n"
    "float z=dot(q,a);\n"
    "return vec3(vec2(dot(q,r),dot(q,u))/(l.kind==RSM_SUN?l.extent:l.extent*z),z);\n"
    "}\n"
    "\n\nint rsm_cube_face(vec3 d)\n"
    "{\n"
    "vec3 a=abs(d);\n"
    "if(a.z>=a.x&&a.z>=a.y)return d.z>=.0?0:5;\n"
    "if(a.x>=a.y)return d.x>=.0?1:2;\n"
    "return d.y>=.0?3:4;\n"
    "}\n"
    "\n\nint rsm_face_of_direction(rsm_light l,vec3 d)\n"
    "{\n"
    "return l.faces==1?0:rsm_cube_face(vec3(dot(d,l.right),dot(d,l.up),dot(d,l.axis)));\n"
    "}\n"
    "\n\nfloat rsm_texel_centre(rsm_light l,int i){return(float(i)+.5)*2./l.side-1.;}\n"
    "\n\nvec3 rsm_to_light(rsm_light l,vec3 p){return l.kind==RSM_SUN?-l.axis:rsm_normalize(l.position-p);}\n"
    "\n\n\nfloat rsm_solid_angle(rsm_light l,vec3 r,vec3 u,vec3 a,vec2 q,float h)\n"
    "{\n"
    "float sum=.0;\n"
    "int n=h<.05?2:4;\n"
    "for(int j=0;j<n;j++)\n"
    "for(int i=0;i<n;i++){\n"
    "ivec2 k=ivec2(i,j);\n"
    "vec2 sign=vec2(greaterThanEqual(k*2,ivec2(n)))*2.-1.;\n"
    "bvec2 outer=equal(k%3,ivec2(0));\n"
    "vec2 node=n==2?vec2(.577350269):mix(vec2(.339981044),vec2(.861136312),vec2(outer));\n"
    "vec2 weight=n==2?vec2(.5):mix(vec2(.326072577),vec2(.173927423),vec2(outer));\n"
    "vec2 s=q+h*sign*node;\n"
    "float c=1./(1.+dot(s,s)),f=c*sqrt(c);\n"
    "if(l.kind==RSM_PATCH)f*=max(dot(l.axis,a+r*s.x+u*s.y)*sqrt(c),.0);\n"
    "sum+=f*weight.x*weight.y;\n"
    "}\n"
    "return sum*4.*h*h;\n"
    "}\n"
    "\n\nbool rsm_in_cone(rsm_light l,vec3 r,vec3 u,vec3 a,vec2 q)\n"
    "{\n"
    "vec3 d=a+r*q.x+u*q.y;\n"
    "return dot(l.axis,d)>=l.cos_half*length(d);\n"
    "}\n"
    "\n\nfloat rsm_incident(rsm_light l,int face,ivec2 t)\n"
    "{\n"
    "float h=l.extent/l.side;\n"
    "if(l.kind==RSM_SUN)return 4.*h*h;\n"
    "vec3 r,u,a;\n"
    "rsm_face_axes(l,face,r,u,a);\n"
    "vec2 q=vec2(rsm_texel_centre(l,t.x),rsm_texel_centre(l,t.y))*l.extent;\n"
    "float flux=rsm_solid_angle(l,r,u,a,q,h);\n"
    "if(l.kind!=RSM_SPOT)return flux;\n"
    "int corners=0,covered=0;\n"
    "for(int k=0;k<4;k++)\n"
    "corners+=int(\n"
    "rsm_in_cone(l,r,u,a,q+h*vec2((k&1)!=0?1.:-1.,(k&2)!=0?1.:-1.)));\n"
    "if(corners==4)return flux;\n"
    "if(corners==0&&!rsm_in_cone(l,r,u,a,q))return .0;\n"
    "for(int k=0;k<64;k++)\n"
    "covered+=int(rsm_in_cone(l,r,u,a,q+h*(vec2(float(k&7),float(k>>3))-3.5)*.25));\n"
    "return flux*float(covered)*(1./64.);\n"
    "}\n"
    "\n\n\nfloat rsm_area(rsm_light l,int face,vec3 p,vec3 n)\n"
    "{\n"
    "vec3 r,u,a,to=rsm_to_light(l,p);\n"
    "rsm_face_axes(l,face,r,u,a);\n"
    "float side=2.*l.extent/l.side*(l.kind==RSM_SUN?1.:dot(p-l.position,a));\n"
    "return side*side*(l.kind==RSM_SUN?1.:abs(dot(a,to)))/max(abs(dot(n,to)),.05);\n"
    "}\n"
    "\n\nfloat rsm_mean3(vec3 v){return(v.x+v.y+v.z)*(1./3.);}\n", 0
};

static const struct { char facts[42];
    char s0[1447]; char end; } glbk__glsl_lib_rsm_pick_glsl GLBK__TIGHT = {
    "lib/rsm_pick.glsl\0" "rsm_access rsm_bound" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\nuint rsm_hash32(uint x)\n"
    "{\n"
    "uint state=x*747796405u+2891336453u;\n"
    "uint word=((state>>((state>>28)+4u))^state)*277803737u;\n"
    "return(word>>22)^word;\n"
    "}\n"
    "\nuint rsm_hash_combine(uint a,uint b){return rsm_hash32(a+0x9e3779b9u*rsm_hash32(b));}\n"
    "float rsm_to_unit(uint bits){return float(bits>>8)*(1./16777216.);}\n"
    "float rsm_random(uint seed,uint stream,uint i)\n"
    "{\n"
    "return rsm_to_unit(rsm_hash_combine(rsm_hash_combine(seed,stream),i));\n"
    "}\n"
    "\n\nfloat rsm_total(rsm_light l)\n"
    "{\n"
    "float total=.0;\n"
    "for(int f=0;f<l.faces;f++)total+=RSM_ROWS_SUM(int(l.side)-1,f);\n"
    "return total;\n"
    "}\n"
    "\n\n\nbool rsm_pick_texel(rsm_light l,uint i,uint n,uint seed,out ivec3 t,out float weight)\n"
    "{\n"
    "float total=rsm_total(l),u=fract(rsm_to_unit(i*2654435769u)+rsm_random(seed,5u,0u));\n"
    "float x=min((float(i)+rsm_random(seed,6u,0u))/float(n),.99999994)*total;\n"
    "int size=int(l.side),low=0,high=size-1;\n"
    "t=ivec3(0);\n"
    "weight=.0;\n"
    "if(!(total>.0))return false;\n"
    "for(int f=0;f+1<l.faces;f++){\n"
    "float sum=RSM_ROWS_SUM(size-1,f);\n"
    "if(t.z!=f||x<sum)continue;\n"
    "x-=sum;\n"
    "t.z=f+1;\n"
    "}\n"
    "while(low<high){\n"
    "int middle=(low+high)/2;\n"
    "if(RSM_ROWS_SUM(middle,t.z)>x)high=middle;\n"
    "else low=middle+1;\n"
    "}\n"
    "t.y=low;\n"
    "x=min(u,.99999994)*RSM_ROW_SUM(ivec3(size-1,t.yz));\n"
    "low=0;\n"
    "high=size-1;\n"
    "while(low<high){\n"
    "int middle=(low+high)/2;\n"
    "if(RSM_ROW_SUM(ivec3(middle,t.yz))>x)high=middle;\n"
    "else low=middle+1;\n"
    "}\n"
    "t.x=low;\n"
    "float flux=rsm_mean3(uintBitsToFloat(RSM_TEXEL(t,2).xyz));\n"
    "if(!(flux>.0))return false;\n"
    "weight=total/(float(n)*flux);\n"
    "return true;\n"
    "}\n", 0
};

static const struct { char facts[46];
    char s0[389]; char end; } glbk__glsl_lib_rsm_sampling_glsl GLBK__TIGHT = {
    "lib/rsm_sampling.glsl\0" "rsm_gather rsm_frame" "\0" "" "\0"
    "" "\0" "",
    "\n\nrsm_sampling rsm_bound_sampling()\n"
    "{\n"
    "rsm_sampling s;\n"
    "s.r_max=glbk_rsm_frame.r_max;\n"
    "s.offset=glbk_rsm_frame.offset;\n"
    "s.clamp_at=glbk_rsm_frame.clamp_at;\n"
    "s.near_limit=glbk_rsm_frame.near_limit;\n"
    "s.near_field=glbk_rsm_frame.near_field;\n"
    "s.set_count=glbk_rsm_frame.set_count;\n"
    "s.mixed=glbk_rsm_frame.mixed;\n"
    "s.picked=glbk_rsm_frame.picked;\n"
    "s.glossy=glbk_rsm_frame.material_count!=0u;\n"
    "return s;\n"
    "}\n", 0
};

static const struct { char facts[52];
    char s0[1503]; char end; } glbk__glsl_lib_rsm_screen_glsl GLBK__TIGHT = {
    "lib/rsm_screen.glsl\0" "rsm_access gbuffer rsm_frame" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n#define RSM_NONE 0.0\n"
    "#define RSM_PENDING 1.0\n"
    "#define RSM_INTERPOLATED 2.0\n"
    "#define RSM_EVALUATED 3.0\n"
    "#define RSM_FRESH 4.0\n"
    "\n\n\n#define RSM_NODE_SCALE 1152921504606846976.0\n"
    "\n\nbool rsm_node_fresh(float alpha){return alpha<-1.;}\n"
    "\n\nfloat rsm_node_distance2(float alpha)\n"
    "{\n"
    "return rsm_node_fresh(alpha)?-alpha/RSM_NODE_SCALE:-alpha*RSM_NODE_SCALE;\n"
    "}\n"
    "\n\nfloat rsm_node_alpha(float distance2)\n"
    "{\n"
    "return-clamp(distance2,4./RSM_NODE_SCALE,.25*RSM_NODE_SCALE)*RSM_NODE_SCALE;\n"
    "}\n"
    "\n\nfloat rsm_node_aged(float alpha)\n"
    "{\n"
    "return rsm_node_fresh(alpha)?alpha/RSM_NODE_SCALE/RSM_NODE_SCALE:alpha;\n"
    "}\n"
    "\nstruct rsm_receiver{\n"
    "vec3 position,normal;\n"
    "float open;\n"
    "};\n"
    "\n\nivec2 rsm_picture_side(){return ivec2(glbk_rsm_frame.width,glbk_rsm_frame.height);}\n"
    "\n\nbool rsm_read(ivec2 at,out rsm_receiver r)\n"
    "{\n"
    "glbk_point p;\n"
    "bool seen=glbk_read_point(at,p);\n"
    "r.position=p.position;\n"
    "r.normal=p.normal;\n"
    "r.open=1.-p.occlusion;\n"
    "return seen;\n"
    "}\n"
    "\n\nuint rsm_set(ivec2 at)\n"
    "{\n"
    "uint k=glbk_rsm_frame.interleave;\n"
    "return uint(at.x)%k+k*(uint(at.y)%k);\n"
    "}\n"
    "\n\nivec2 rsm_node_number(ivec2 at,int step){return(at+step-1)/step;}\n"
    "\n\nbool rsm_is_node(ivec2 at,int step,ivec2 size,out ivec2 number)\n"
    "{\n"
    "number=rsm_node_number(at,step);\n"
    "return(at.x%step==0||at.x==size.x-1)&&(at.y%step==0||at.y==size.y-1);\n"
    "}\n"
    "\n\n\nfloat rsm_alike(vec3 p,vec3 n,vec3 q,vec3 m)\n"
    "{\n"
    "vec3 d=q-p;\n"
    "float cosine=glbk_rsm_frame.normal_cosine,slope=glbk_rsm_frame.plane_slope;\n"
    "float off=dot(n,d),a=clamp((dot(n,m)-cosine)/(1.-cosine),.0,1.);\n"
    "return a*max(1.-off*off/(slope*slope*dot(d,d)+1e-12),.0);\n"
    "}\n", 0
};

static const struct { char facts[34];
    char s0[600]; char end; } glbk__glsl_lib_rsm_smooth_glsl GLBK__TIGHT = {
    "lib/rsm_smooth.glsl\0" "rsm_screen" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\nbool rsm_neighbour(ivec2 at,ivec2 off,out rsm_receiver s,out vec3 light);\n"
    "\n\nvec4 rsm_smooth(ivec2 at,rsm_receiver r,vec4 sum)\n"
    "{\n"
    "vec3 light=sum.xyz*4.,most=vec3(.0);\n"
    "float total=4.;\n"
    "for(int j=-1;j<=1;j++)\n"
    "for(int i=-1;i<=1;i++){\n"
    "rsm_receiver s;\n"
    "vec3 other;\n"
    "if((i==0&&j==0)||!rsm_neighbour(at,ivec2(i,j),s,other))continue;\n"
    "float weight=rsm_alike(r.position,r.normal,s.position,s.normal);\n"
    "weight*=i!=0&&j!=0?1.:2.;\n"
    "light+=weight*other;\n"
    "total+=weight;\n"
    "most=max(most,other);\n"
    "}\n"
    "light/=total;\n"
    "if(total<8.)light=mix(light,min(light,most),vec3(greaterThan(most,vec3(.0))));\n"
    "return vec4(light,sum.w);\n"
    "}\n", 0
};

static const struct { char facts[33];
    char s0[571]; char end; } glbk__glsl_prog_rsm_begin_comp GLBK__TIGHT = {
    "prog/rsm_begin.comp\0" "rsm_lists" "\0" "" "\0"
    "" "\0" "",
    "\n\n\nlayout(local_size_x=8,local_size_y=8)in;\n"
    "\nvoid main()\n"
    "{\n"
    "int fine=int(glbk_rsm_frame.fine_step);\n"
    "ivec2 number=ivec2(gl_GlobalInvocationID.xy),size=rsm_picture_side(),first;\n"
    "ivec2 last=rsm_node_number(size-1,fine),at=min(number*fine,size-1);\n"
    "rsm_receiver r;\n"
    "rsm_begin_lists();\n"
    "if(all(lessThanEqual(number,last))){\n"
    "uint i=rsm_mark(number,last);\n"
    "if((i&31u)==0u)glbk_rsm_marks[i>>5]=0u;\n"
    "imageStore(glbk_rsm_nodes,number,vec4(.0));\n"
    "if(rsm_is_node(at,int(glbk_rsm_frame.step),size,first)&&rsm_read(at,r))rsm_add_wanted(at);\n"
    "}\n"
    "rsm_end_lists(0u,glbk_rsm_frame.list_wanted);\n"
    "}\n", 0
};

static const struct { char facts[46];
    char s0[396]; char end; } glbk__glsl_prog_rsm_direct_frag GLBK__TIGHT = {
    "prog/rsm_direct.frag\0" "rsm_direct rsm_screen" "\0" "" "\0"
    "" "\0" "",
    "\n\n\nlayout(location=0)out glbk_color result;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_FragCoord.xy);\n"
    "vec4 sum=vec4(.0);\n"
    "rsm_receiver r;\n"
    "if(glbk_rsm_frame.adds!=0u)sum=glbk_unpack(texelFetch(glbk_rsm_sum,at,0));\n"
    "if(rsm_read(at,r)){\n"
    "int taps=int(glbk_rsm_frame.taps);\n"
    "sum+=vec4(rsm_direct(rsm_bound(),r.position,r.normal,taps,glbk_rsm_frame.bias,\n"
    "glbk_rsm_frame.slope_bias),1.);\n"
    "}\n"
    "result=glbk_pack(sum);\n"
    "}\n", 0
};

static const struct { char facts[82];
    char s0[1440]; char end; } glbk__glsl_prog_rsm_fill_frag GLBK__TIGHT = {
    "prog/rsm_fill.frag\0" "rsm_bindings rsm_bound mesh_fragment rsm_drawn" "\0" "rsm_fill.vert" "\0"
    "" "\0" "",
    "\n\n\nin vec3 rsm_place,rsm_facing;\n"
    "in vec2 rsm_uv;\n"
    "layout(location=0)out uvec4 rsm_out_place;\n"
    "layout(location=1)out uvec4 rsm_out_normal;\n"
    "layout(location=2)out uvec4 rsm_out_flux;\n"
    "\nvoid main()\n"
    "{\n"
    "vec4 color=vec4(glbk_rsm_drawn.albedo.xyz,1.);\n"
    "vec4 eye=glbk_rsm_drawn.eye;\n"
    "vec3 view=eye.w>.0?eye.xyz-rsm_place:eye.xyz;\n"
    "vec3 flat_normal=rsm_normalize(cross(dFdx(rsm_place),dFdy(rsm_place)));\n"
    "\nif(dot(flat_normal,flat_normal)==.0)flat_normal=rsm_normalize(rsm_facing);\n"
    "if(dot(flat_normal,view)<.0)flat_normal=-flat_normal;\n"
    "vec3 n=dot(rsm_facing,rsm_facing)>.0?rsm_normalize(rsm_facing):flat_normal;\n"
    "if(dot(n,flat_normal)<.0)n=-n;\n"
    "if(glbk_rsm_drawn.has_map!=0u){\n"
    "color.xyz*=texture(glbk_rsm_albedo_map,rsm_uv).xyz;\n"
    "color.w=textureLod(glbk_rsm_albedo_map,rsm_uv,.0).w;\n"
    "}\n"
    "bool there=glbk_fragment(rsm_uv,color);\n"
    "if(!there||color.w<glbk_rsm_drawn.alpha_cutoff)discard;\n"
    "rsm_light l=rsm_bound();\n"
    "int face=int(glbk_rsm_drawn.face);\n"
    "vec3 r,u,a,flux=rsm_incident(l,face,ivec2(gl_FragCoord.xy))*l.value*color.xyz;\n"
    "\nif(any(greaterThan(floatBitsToUint(flux)&0x7fffffffu,uvec3(0x5d5e0b6bu))))flux=vec3(.0);\n"
    "rsm_face_axes(l,face,r,u,a);\n"
    "float depth=dot(rsm_place-l.position,a);\n"
    "gl_FragDepth=clamp((depth-glbk_rsm_drawn.near_depth)*glbk_rsm_drawn.depth_scale,.0,1.);\n"
    "rsm_out_place=floatBitsToUint(vec4(rsm_place,depth));\n"
    "rsm_out_normal=uvec4(floatBitsToUint(n),glbk_rsm_drawn.material);\n"
    "rsm_out_flux=floatBitsToUint(vec4(flux,rsm_area(l,face,rsm_place,n)));\n"
    "}\n", 0
};

static const struct { char facts[57];
    char s0[392]; char end; } glbk__glsl_prog_rsm_fill_vert GLBK__TIGHT = {
    "prog/rsm_fill.vert\0" "rsm_bindings mesh_vertex rsm_drawn" "\0" "" "\0"
    "" "\0" "",
    "\n\nout vec3 rsm_place,rsm_facing;\n"
    "out vec2 rsm_uv;\n"
    "\nvoid main()\n"
    "{\n"
    "vec3 position,normal;\n"
    "vec2 uv;\n"
    "vec4 tangent;\n"
    "glbk_vertex(position,normal,uv,tangent);\n"
    "mat3 m=mat3(glbk_rsm_drawn.transform);\n"
    "rsm_place=(glbk_rsm_drawn.transform*vec4(position,1.)).xyz;\n"
    "rsm_facing=mat3(cross(m[1],m[2]),cross(m[2],m[0]),cross(m[0],m[1]))*normal;\n"
    "rsm_uv=uv;\n"
    "gl_Position=glbk_rsm_drawn.clip*vec4(rsm_place,1.);\n"
    "}\n", 0
};

static const struct { char facts[122];
    char s0[2148]; char end; } glbk__glsl_prog_rsm_gather_comp GLBK__TIGHT = {
    "prog/rsm_gather.comp\0" "rsm_chunk rsm_bounce rsm_lists" "\0" "" "\0"
    "NODES=0 | NODES=1 | NODES=0 RSM_SURFACES=1 | NODES=1 RSM_SURFACES=1" "\0" "",
    "\n\n\n\n\n\n#ifndef NODES\n"
    "#define NODES 0\n"
    "#endif\n"
    "layout(local_size_x=64)in;\n"
    "shared bool rsm_awake;\n"
    "\n\nvec3 rsm_bounce_together(rsm_receiver r,ivec2 at,uint set,bool awake)\n"
    "{\n"
    "uint i=gl_LocalInvocationIndex,sets=glbk_rsm_frame.interleave*glbk_rsm_frame.interleave;\n"
    "uint listed=glbk_rsm_frame.end_light;\n"
    "int kinds=glbk_rsm_frame.material_count!=0u?4:3;\n"
    "rsm_light l=rsm_bound();\n"
    "vec2 turn=rsm_turn(at);\n"
    "vec3 sum=vec3(.0);\n"
    "for(uint from=glbk_rsm_frame.first_light;from<listed;from+=RSM_CHUNK){\n"
    "barrier();\n"
    "if(from+i<listed)\n"
    "for(int k=0;k<kinds;k++)\n"
    "RSM_LIGHT(i,k)=RSM_LISTED(set*glbk_rsm_frame.set_room+from+i,k);\n"
    "barrier();\n"
    "if(awake)sum+=rsm_listed(l,r,0u,min(RSM_CHUNK,listed-from));\n"
    "}\n"
    "for(uint from=0u;from<glbk_rsm_frame.point_count;from+=4u*RSM_CHUNK){\n"
    "uint count=min(4u*RSM_CHUNK,glbk_rsm_frame.point_count-from);\n"
    "barrier();\n"
    "for(uint k=i;k<count;k+=RSM_CHUNK)\n"
    "rsm_chunk[k].xyz=floatBitsToUint(RSM_PATTERN(set+(from+k)*sets));\n"
    "barrier();\n"
    "if(awake)sum+=rsm_about(l,r,turn,0u,1u,count);\n"
    "}\n"
    "return sum/RSM_PI;\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "uint k=glbk_rsm_frame.interleave,i=gl_LocalInvocationIndex,set=gl_WorkGroupID.z;\n"
    "ivec2 at,size=rsm_picture_side();\n"
    "bool inside,first=glbk_rsm_frame.adds==0u;\n"
    "vec4 sum=vec4(.0);\n"
    "rsm_receiver r;\n"
    "if(glbk_rsm_frame.mode==0u){\n"
    "at=ivec2((gl_WorkGroupID.xy*8u+uvec2(i&7u,i>>3))*k+uvec2(set%k,set/k));\n"
    "inside=all(lessThan(at,size));\n"
    "}else{\n"
    "inside=rsm_item(glbk_rsm_frame.list_read,at);\n"
    "}\n"
    "bool awake=rsm_read(inside?at:ivec2(0),r)&&inside;\n"
    "#if NODES\n"
    "ivec2 number=rsm_node_number(at,int(glbk_rsm_frame.fine_step));\n"
    "if(awake&&!first){\n"
    "sum=imageLoad(glbk_rsm_nodes,number);\n"
    "rsm_near=1./rsm_node_distance2(sum.w);\n"
    "}\n"
    "#else\n"
    "if(awake&&!first)sum=imageLoad(glbk_rsm_picture,at);\n"
    "#endif\n"
    "if(i==0u)rsm_awake=false;\n"
    "barrier();\n"
    "if(awake)rsm_awake=true;\n"
    "barrier();\n"
    "if(rsm_awake){\n"
    "vec3 light=rsm_bounce_together(r,at,set,awake);\n"
    "#if NODES\n"
    "sum=vec4(sum.xyz+light,rsm_node_alpha(1./max(rsm_near,1e-30)));\n"
    "#else\n"
    "sum=vec4(sum.xyz+light*r.open,RSM_FRESH);\n"
    "#endif\n"
    "}\n"
    "if(!inside||(!awake&&!first))return;\n"
    "if(!awake)sum=vec4(.0);\n"
    "#if NODES\n"
    "imageStore(glbk_rsm_nodes,number,sum);\n"
    "sum=vec4(sum.xyz*r.open,RSM_EVALUATED);\n"
    "#endif\n"
    "imageStore(glbk_rsm_picture,at,sum);\n"
    "}\n", 0
};

static const struct { char facts[66];
    char s0[1427]; char end; } glbk__glsl_prog_rsm_gather_frag GLBK__TIGHT = {
    "prog/rsm_gather.frag\0" "rsm_bounce" "\0" "" "\0"
    "RSM_SURFACES=0 | RSM_SURFACES=1" "\0" "",
    "\n\n\n\n\nlayout(location=0)out glbk_color result;\n"
    "\n\n\nbool rsm_wanted(ivec2 at,int step,ivec2 size)\n"
    "{\n"
    "ivec2 off=at%step;\n"
    "ivec2 from=ivec2(off.x==0?max(at.x-step,0):at.x-off.x,\n"
    "off.y==0?max(at.y-step,0):at.y-off.y);\n"
    "ivec2 to=min(ivec2(off.x==0?at.x+step-1:at.x,off.y==0?at.y+step-1:at.y),size-1);\n"
    "for(int y=from.y;y<=to.y;y++)\n"
    "for(int x=from.x;x<=to.x;x++)\n"
    "if(glbk_unpack(texelFetch(glbk_rsm_states,ivec2(x,y),0)).w==RSM_PENDING)return true;\n"
    "return false;\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 here=ivec2(gl_FragCoord.xy),at=here,size=rsm_picture_side(),number;\n"
    "int step=int(glbk_rsm_frame.step),coarse=int(glbk_rsm_frame.coarse_step);\n"
    "uint mode=glbk_rsm_frame.mode;\n"
    "bool first=glbk_rsm_frame.adds==0u;\n"
    "vec4 sum=first&&mode!=2u?vec4(.0):glbk_unpack(texelFetch(glbk_rsm_sum,here,0));\n"
    "rsm_receiver r;\n"
    "if(mode==1u)at=min(at*step,size-1);\n"
    "bool seen=rsm_read(at,r),evaluate=seen;\n"
    "if(!first){\n"
    "evaluate=mode==1u?rsm_node_fresh(sum.w):sum.w==RSM_FRESH;\n"
    "}else if(mode==1u&&coarse>0){\n"
    "if(rsm_is_node(at,coarse,size,number))sum=glbk_unpack(texelFetch(glbk_rsm_coarse,number,0));\n"
    "sum.w=rsm_node_aged(sum.w);\n"
    "evaluate=seen&&sum.w==RSM_NONE&&rsm_wanted(at,step,size);\n"
    "}else if(mode==2u){\n"
    "evaluate=sum.w==RSM_PENDING;\n"
    "sum.xyz*=evaluate?.0:r.open;\n"
    "}\n"
    "if(evaluate){\n"
    "if(mode==1u&&!first)rsm_near=1./rsm_node_distance2(sum.w);\n"
    "sum.xyz+=rsm_bounce(r,at)*(mode==1u?1.:r.open);\n"
    "sum.w=mode==1u?rsm_node_alpha(1./max(rsm_near,1e-30)):RSM_FRESH;\n"
    "}\n"
    "result=glbk_pack(sum);\n"
    "}\n", 0
};

static const struct { char facts[84];
    char s0[3994]; char s1[454]; char end; } glbk__glsl_prog_rsm_import_frag GLBK__TIGHT = {
    "prog/rsm_import.frag\0" "rsm_bindings rsm_imported rsm_bound" "\0" "" "\0"
    "KIND=0 | KIND=1 | KIND=2" "\0" "",
    "\n\n\n\n#ifndef KIND\n"
    "#define KIND 0\n"
    "#endif\n"
    "layout(location=0)out uvec4 rsm_out_place;\n"
    "layout(location=1)out uvec4 rsm_out_normal;\n"
    "layout(location=2)out uvec4 rsm_out_flux;\n"
    "\n\nconst uint has_depth=1u,has_places=2u,has_colors=4u,has_materials=8u;\n"
    "const uint reversed=16u,colors_are_flux=32u;\n"
    "\n\nconst uint packed_unit=2u,packed_octahedral=3u,packed_octahedral_unit=4u;\n"
    "\nivec2 rsm_at;\n"
    "vec3 rsm_toward;\n"
    "\n#if KIND == 0\n"
    "#define RSM_IN_2D(name) texelFetch(name, rsm_at, 0)\n"
    "#define RSM_DEPTH_IN RSM_IN_2D(glbk_rsm_depth_in)\n"
    "#define RSM_PLACE_IN RSM_IN_2D(glbk_rsm_place_in)\n"
    "#define RSM_NORMAL_IN RSM_IN_2D(glbk_rsm_normal_in)\n"
    "#define RSM_COLOR_IN RSM_IN_2D(glbk_rsm_color_in)\n"
    "#define RSM_MATERIAL_IN RSM_IN_2D(glbk_rsm_material_in)\n"
    "#elif KIND == 1\n"
    "#define RSM_IN_ARRAY(name, layer) texelFetch(name, ivec3(rsm_at, int(layer)), 0)\n"
    "#define RSM_DEPTH_IN RSM_IN_ARRAY(glbk_rsm_depth_array, glbk_rsm_imported.depth_layer)\n"
    "#define RSM_PLACE_IN RSM_IN_ARRAY(glbk_rsm_place_array, glbk_rsm_imported.place_layer)\n"
    "#define RSM_NORMAL_IN RSM_IN_ARRAY(glbk_rsm_normal_array, glbk_rsm_imported.normal_layer)\n"
    "#define RSM_COLOR_IN RSM_IN_ARRAY(glbk_rsm_color_array, glbk_rsm_imported.color_layer)\n"
    "#define RSM_MATERIAL_IN RSM_IN_ARRAY(glbk_rsm_material_array, glbk_rsm_imported.material_layer)\n"
    "#else\n"
    "#define RSM_IN_CUBE(name) textureLod(name, rsm_toward, 0.0)\n"
    "#define RSM_DEPTH_IN RSM_IN_CUBE(glbk_rsm_depth_cube)\n"
    "#define RSM_PLACE_IN RSM_IN_CUBE(glbk_rsm_place_cube)\n"
    "#define RSM_NORMAL_IN RSM_IN_CUBE(glbk_rsm_normal_cube)\n"
    "#define RSM_COLOR_IN RSM_IN_CUBE(glbk_rsm_color_cube)\n"
    "#define RSM_MATERIAL_IN RSM_IN_CUBE(glbk_rsm_material_cube)\n"
    "#endif\n"
    "\nbool has(uint what){return(glbk_rsm_imported.given&what)!=0u;}\n"
    "\n\nfloat depth_of(rsm_light l,float stored)\n"
    "{\n"
    "float n=glbk_rsm_imported.near_depth,f=glbk_rsm_imported.far_depth,range=f-n;\n"
    "if(has(reversed))return l.kind==RSM_SUN?f-stored*range:n*f/(n+stored*range);\n"
    "return l.kind==RSM_SUN?n+stored*range:n*f/(f-stored*range);\n"
    "}\n"
    "\n\n\nvec3 centre_of_texel(vec3 d,float side)\n"
    "{\n"
    "vec3 a=abs(d);\n"
    "float m=max(max(a.x,a.y),a.z);\n"
    "vec3 c=(floor((d/m*.5+.5)*side)+.5)*2./side-1.;\n"
    "vec3 along=a.x>=a.y&&a.x>=a.z?vec3(1.,.0,.0)\n"
    ":a.y>=a.z?vec3(.0,1.,.0):vec3(.0,.0,1.);\n"
    "return mix(c,sign(d),along);\n"
    "}\n"
    "\n\nvec3 unit_of_square(vec2 p)\n"
    "{\n"
    "float z=1.-abs(p.x)-abs(p.y),t=max(-z,.0);\n"
    "return rsm_normalize(vec3(p.x+(p.x>=.0?-t:t),p.y+(p.y>=.0?-t:t),z));\n"
    "}\n"
    "\n\nvec3 normal_of(vec3 v)\n"
    "{\n"
    "uint packing=glbk_rsm_imported.normal_packing;\n"
    "if(packing==packed_unit||packing==packed_octahedral_unit)v=v*2.-1.;\n"
    "if(packing>=packed_octahedral)v=unit_of_square(v.xy);\n"
    "float d=dot(v,v);\n"
    "if(!(d>.25&&d<2.25))return vec3(.0);\n"
    "return rsm_normalize(mat3(glbk_rsm_imported.to_world)*v);\n"
    "}\n"
    "\n\n\nbool within(vec3 v,float low,float high)\n"
    "{\n"
    "uvec3 size=floatBitsToUint(v)&0x7fffffffu;\n"
    "return all(lessThan(size,uvec3(0x7f800000u)))&&all(greaterThanEqual(v,vec3(low)))&&\n"
    "all(lessThanEqual(v,vec3(high)));\n"
    "}\n"
    "\n\nbool find_place(rsm_light l,out vec3 place)\n"
    "{\n"
    "place=vec3(.0);\n"
    "float stored=has(has_depth)?RSM_DEPTH_IN.x:.5;\n"
    "bool seen=has(reversed)?stored>.0:stored<1.;\n"
    "if(!seen)return false;\n"
    "if(has(has_places)){\n"
    "vec4 p=RSM_PLACE_IN;\n"
    "place=(glbk_rsm_imported.to_world*vec4(p.xyz,1.)).xyz;\n"
    "return p.w!=.0;\n"
    "}\n"
    "float z=depth_of(l,stored);\n"
    "vec3 r,u,a;\n"
    "rsm_face_axes(l,int(glbk_rsm_imported.face),r,u,a);\n"
    "place=l.position+(l.kind==RSM_SUN?rsm_toward+a*(z-1.):rsm_toward*z);\n"
    "return true;\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "rsm_light l=rsm_bound();\n"
    "int face=int(glbk_rsm_imported.face);\n"
    "ivec2 t=ivec2(gl_FragCoord.xy);\n"
    "vec2 q=vec2(rsm_texel_centre(l,t.x),rsm_texel_centre(l,t.y))*l.extent;\n"
    "vec3 r,u,a,place;\n"
    "rsm_face_axes(l,face,r,u,a);\n"
    "rsm_at=t+ivec2(int(glbk_rsm_imported.left),int(glbk_rsm_imported.bottom));\n"
    "rsm_toward=a+r*q.x+u*q.y;\n"
    "#if KIND == 2\n"
    "rsm_toward=centre_of_texel(rsm_toward,l.side);\n"
    "#endif\n"
    "rsm_out_place=uvec4(0u,0u,0u,floatBitsToUint(3.0e38));\n"
    "rsm_out_normal=rsm_out_flux=uvec4(0u);\n"
    "bool seen=find_place(l,place);\n"
    "vec3 n=normal_of(RSM_NORMAL_IN.xyz);\n"
    "if(!seen||!(dot(n,n)>.5)||!within(place,-1e9,1e9))return;\n"
    "vec3 color=glbk_rsm_imported.color.xyz,flux;\n",
    "if(has(has_colors))color*=RSM_COLOR_IN.xyz;\n"
    "flux=has(colors_are_flux)?color:rsm_incident(l,face,t)*l.value*color;\n"
    "if(!within(color,.0,3.0e38)||!within(flux,.0,1e18))return;\n"
    "uint material=glbk_rsm_imported.material;\n"
    "if(has(has_materials))material=RSM_MATERIAL_IN.x;\n"
    "rsm_out_place=floatBitsToUint(vec4(place,dot(place-l.position,a)));\n"
    "rsm_out_normal=uvec4(floatBitsToUint(n),material);\n"
    "rsm_out_flux=floatBitsToUint(vec4(flux,rsm_area(l,face,place,n)));\n"
    "}\n", 0
};

static const struct { char facts[76];
    char s0[2107]; char end; } glbk__glsl_prog_rsm_interpolate_comp GLBK__TIGHT = {
    "prog/rsm_interpolate.comp\0" "rsm_lists rsm_grid" "\0" "" "\0"
    "RSM_GROUP=256 | RSM_GROUP=64" "\0" "",
    "\n\n\n\n\nlayout(local_size_x=RSM_GROUP)in;\n"
    "\n#if RSM_GROUP == 256\n"
    "\nconst int SIDE=9;\n"
    "shared vec4 rsm_places[SIDE*SIDE];\n"
    "shared vec4 rsm_lights[SIDE*SIDE];\n"
    "shared vec3 rsm_normals[SIDE*SIDE];\n"
    "\n\nvoid rsm_load_nodes(int step,int fine,ivec2 size)\n"
    "{\n"
    "int i=int(gl_LocalInvocationIndex);\n"
    "ivec2 node=ivec2(i%SIDE,i/SIDE);\n"
    "if(all(lessThanEqual(node,ivec2(15/step+1)))){\n"
    "ivec2 at=min((ivec2(gl_WorkGroupID.xy*16u)/step+node)*step,size-1);\n"
    "rsm_receiver r;\n"
    "rsm_places[i].w=rsm_read(at,r)?1.:.0;\n"
    "rsm_places[i].xyz=r.position;\n"
    "rsm_normals[i]=r.normal;\n"
    "rsm_lights[i]=texelFetch(glbk_rsm_coarse,rsm_node_number(at,fine),0);\n"
    "}\n"
    "barrier();\n"
    "}\n"
    "\nbool rsm_node(ivec2 at,out rsm_receiver s,out vec4 node)\n"
    "{\n"
    "int step=int(glbk_rsm_frame.step);\n"
    "ivec2 number=rsm_node_number(at,step)-ivec2(gl_WorkGroupID.xy*16u)/step;\n"
    "int i=number.y*SIDE+number.x;\n"
    "node=rsm_lights[i];\n"
    "s=rsm_receiver(rsm_places[i].xyz,rsm_normals[i],1.);\n"
    "return rsm_places[i].w>.0;\n"
    "}\n"
    "#else\n"
    "bool rsm_node(ivec2 at,out rsm_receiver s,out vec4 node)\n"
    "{\n"
    "node=texelFetch(glbk_rsm_coarse,rsm_node_number(at,int(glbk_rsm_frame.fine_step)),0);\n"
    "return rsm_read(at,s);\n"
    "}\n"
    "#endif\n"
    "\nvoid main()\n"
    "{\n"
    "int step=int(glbk_rsm_frame.step),next=int(glbk_rsm_frame.next_step);\n"
    "ivec2 at,size=rsm_picture_side(),number;\n"
    "ivec2 lx,ly;\n"
    "rsm_receiver r;\n"
    "vec3 value;\n"
    "float share;\n"
    "rsm_begin_lists();\n"
    "#if RSM_GROUP == 256\n"
    "at=ivec2(gl_WorkGroupID.xy*16u)+ivec2(gl_LocalInvocationIndex&15u,gl_LocalInvocationIndex>>4);\n"
    "bool inside=all(lessThan(at,size));\n"
    "rsm_load_nodes(step,int(glbk_rsm_frame.fine_step),size);\n"
    "#else\n"
    "bool inside=rsm_item(glbk_rsm_frame.list_read,at);\n"
    "#endif\n"
    "if(inside&&!rsm_read(at,r)){\n"
    "imageStore(glbk_rsm_picture,at,vec4(.0,.0,.0,RSM_NONE));\n"
    "}else if(inside&&!rsm_is_node(at,step,size,number)){\n"
    "if(rsm_interpolate(at,step,size,r,value)){\n"
    "imageStore(glbk_rsm_picture,at,vec4(value*r.open,RSM_INTERPOLATED));\n"
    "}else{\n"
    "rsm_add_pending(at);\n"
    "if(next>0){\n"
    "rsm_grid_lines(at.x,next,size.x,lx,share);\n"
    "rsm_grid_lines(at.y,next,size.y,ly,share);\n"
    "for(int k=0;k<4;k++)\n"
    "rsm_want(ivec2((k&1)!=0?lx.y:lx.x,(k&2)!=0?ly.y:ly.x));\n"
    "}\n"
    "}\n"
    "}\n"
    "rsm_end_lists(glbk_rsm_frame.list_pending,glbk_rsm_frame.list_wanted);\n"
    "}\n", 0
};

static const struct { char facts[38];
    char s0[809]; char end; } glbk__glsl_prog_rsm_interpolate_frag GLBK__TIGHT = {
    "prog/rsm_interpolate.frag\0" "rsm_grid" "\0" "" "\0"
    "" "\0" "",
    "\n\n\nlayout(location=0)out glbk_color result;\n"
    "\nbool rsm_node(ivec2 at,out rsm_receiver s,out vec4 node)\n"
    "{\n"
    "node=glbk_unpack(texelFetch(glbk_rsm_coarse,rsm_node_number(at,int(glbk_rsm_frame.step)),0));\n"
    "return rsm_read(at,s);\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_FragCoord.xy),size=rsm_picture_side(),number;\n"
    "int step=int(glbk_rsm_frame.step);\n"
    "vec4 sum=vec4(.0,.0,.0,RSM_PENDING);\n"
    "rsm_receiver r;\n"
    "bool seen=rsm_read(at,r);\n"
    "if(glbk_rsm_frame.adds!=0u)sum=glbk_unpack(texelFetch(glbk_rsm_sum,at,0));\n"
    "else if(!seen)sum.w=RSM_NONE;\n"
    "if(seen&&rsm_is_node(at,step,size,number)){\n"
    "vec4 node=glbk_unpack(texelFetch(glbk_rsm_coarse,number,0));\n"
    "if(node.w<.0)sum=vec4(node.xyz,RSM_EVALUATED);\n"
    "}\n"
    "vec3 value;\n"
    "if(sum.w==RSM_PENDING&&rsm_interpolate(at,step,size,r,value))\n"
    "sum=vec4(value,RSM_INTERPOLATED);\n"
    "result=glbk_pack(sum);\n"
    "}\n", 0
};

static const struct { char facts[56];
    char s0[1776]; char end; } glbk__glsl_prog_rsm_pick_frag GLBK__TIGHT = {
    "prog/rsm_pick.frag\0" "rsm_gather rsm_frame" "\0" "" "\0"
    "ALL=0 | ALL=1" "\0" "",
    "\n\n\n\n\n#ifndef ALL\n"
    "#define ALL 0\n"
    "#endif\n"
    "layout(location=0)out uvec4 rsm_out_place;\n"
    "layout(location=1)out uvec4 rsm_out_normal;\n"
    "layout(location=2)out uvec4 rsm_out_flux;\n"
    "layout(location=3)out uvec4 rsm_out_gloss;\n"
    "\nvoid main()\n"
    "{\n"
    "uint e=uint(gl_FragCoord.y)*1024u+uint(gl_FragCoord.x),room=glbk_rsm_frame.set_room;\n"
    "uint sets=glbk_rsm_frame.interleave*glbk_rsm_frame.interleave,set=e/room,at=e%room;\n"
    "uint seed=glbk_rsm_frame.seed,n=glbk_rsm_frame.light_count,from=glbk_rsm_frame.first_light;\n"
    "if(set>=sets||at<from||at>=glbk_rsm_frame.end_light)discard;\n"
    "\nuint run=glbk_rsm_frame.first_run+at-from;\n"
    "uint i=run*sets+(set+sets-rsm_hash_combine(seed,run)%sets)%sets;\n"
    "rsm_light l=rsm_bound();\n"
    "ivec3 t=ivec3(0);\n"
    "float weight=1.;\n"
    "bool lit=i<n;\n"
    "#if ALL\n"
    "uint size=uint(l.side);\n"
    "if(lit)t=ivec3(i%size,i/size%size,i/(size*size));\n"
    "#else\n"
    "if(lit)lit=rsm_pick_texel(l,i,n,seed,t,weight);\n"
    "#endif\n"
    "vec4 flux=uintBitsToFloat(RSM_TEXEL(t,2)),place=uintBitsToFloat(RSM_TEXEL(t,0));\n"
    "uvec4 normal=RSM_TEXEL(t,1);\n"
    "\nbool glossy=normal.w!=0u&&normal.w<=glbk_rsm_frame.material_count;\n"
    "lit=lit&&(rsm_mean3(flux.xyz)>.0||glossy);\n"
    "if(!lit)normal=uvec4(0u);\n"
    "float scale=lit?weight*glbk_rsm_frame.set_count:.0;\n"
    "place.xyz-=glbk_rsm_frame.offset*uintBitsToFloat(normal.xyz);\n"
    "place.w=rsm_bound_of(flux.w*weight,glbk_rsm_frame.clamp_at,glbk_rsm_frame.near_limit);\n"
    "rsm_out_place=floatBitsToUint(place);\n"
    "#if ALL\n"
    "float field=glbk_rsm_frame.near_field,last=field*field*flux.w;\n"
    "#else\n"
    "float last=lit&&glbk_rsm_frame.picked>.0?1./weight:.0;\n"
    "#endif\n"
    "rsm_out_normal=uvec4(normal.xyz,floatBitsToUint(last));\n"
    "rsm_out_flux=uvec4(floatBitsToUint(flux.xyz*scale),uint(t.x)|uint(t.y)<<12|uint(t.z)<<24);\n"
    "rsm_out_gloss=uvec4(0u);\n"
    "if(lit&&glossy)\n"
    "rsm_out_gloss=uvec4(floatBitsToUint(rsm_incident(l,t.z,t.xy)*l.value*scale),normal.w);\n"
    "}\n", 0
};

static const struct { char facts[45];
    char s0[2067]; char end; } glbk__glsl_prog_rsm_recall_frag GLBK__TIGHT = {
    "prog/rsm_recall.frag\0" "rsm_screen rsm_drawn" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\nlayout(location=0)out glbk_color result;\n"
    "layout(location=1)out uvec4 rsm_out_place;\n"
    "layout(location=2)out uvec4 rsm_out_normal;\n"
    "\n\nbool rsm_reproject(ivec2 at,vec3 p,vec2 size,out vec2 q)\n"
    "{\n"
    "q=vec2(.0);\n"
    "if(glbk_rsm_frame.motion==2u){\n"
    "q=texelFetch(glbk_rsm_motion,at,0).xy;\n"
    "}else if(glbk_rsm_frame.motion==1u){\n"
    "vec4 c=glbk_rsm_drawn.clip*vec4(p,1.);\n"
    "if(!(c.w>.0))return false;\n"
    "q=(vec2(c.x,glbk_rsm_frame.rows_top_first!=0u?-c.y:c.y)/c.w*.5+.5)*size;\n"
    "}else{\n"
    "return false;\n"
    "}\n"
    "return all(lessThan(abs(q),vec2(1e6)));\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_FragCoord.xy),size=rsm_picture_side();\n"
    "float most=glbk_rsm_frame.history;\n"
    "vec4 now=glbk_unpack(texelFetch(glbk_rsm_sum,at,0));\n"
    "bool moved=glbk_rsm_frame.motion==2u;\n"
    "vec2 q;\n"
    "rsm_receiver r,s;\n"
    "bool seen=rsm_read(at,r);\n"
    "rsm_out_place=uvec4(floatBitsToUint(r.position),0u);\n"
    "rsm_out_normal=uvec4(floatBitsToUint(r.normal),0u);\n"
    "if(!seen){\n"
    "result=glbk_pack(vec4(.0));\n"
    "return;\n"
    "}\n"
    "now.w=1.;\n"
    "if(most>1.&&rsm_reproject(at,r.position,vec2(size),q)){\n"
    "\nivec2 other=ivec2(at.x+1<size.x?at.x+1:max(at.x-1,0),at.y);\n"
    "rsm_read(other,s);\n"
    "vec3 d=s.position-r.position;\n"
    "float reach=dot(d,d)<1e18?16.*dot(d,d)+1e-12:1e-12,total=.0;\n"
    "vec2 centre=floor(q),\n"
    "place=mix(q-.5,centre,lessThan(abs(q-.5-centre),vec2(1./64.)));\n"
    "vec2 from=floor(place),f=place-from;\n"
    "vec4 old=vec4(.0);\n"
    "for(int k=0;k<4;k++){\n"
    "ivec2 there=ivec2(from)+ivec2(k&1,k>>1);\n"
    "float weight=((k&1)!=0?f.x:1.-f.x)*((k&2)!=0?f.y:1.-f.y);\n"
    "if(any(lessThan(there,ivec2(0)))||any(greaterThanEqual(there,size)))continue;\n"
    "vec4 history=glbk_unpack(texelFetch(glbk_rsm_history,there,0));\n"
    "if(!(history.w>.0))continue;\n"
    "s.position=uintBitsToFloat(texelFetch(glbk_rsm_before,ivec3(there,0),0).xyz);\n"
    "s.normal=uintBitsToFloat(texelFetch(glbk_rsm_before,ivec3(there,1),0).xyz);\n"
    "d=s.position-r.position;\n"
    "if(!moved&&dot(d,d)>reach)continue;\n"
    "weight*=moved?(dot(r.normal,s.normal)>.5?1.:.0)\n"
    ":rsm_alike(r.position,r.normal,s.position,s.normal);\n"
    "total+=weight;\n"
    "old+=weight*history;\n"
    "}\n"
    "if(total>.01){\n"
    "old/=total;\n"
    "now.w=min(old.w+1.,most);\n"
    "now.xyz=mix(old.xyz,now.xyz,1./now.w);\n"
    "}\n"
    "}\n"
    "result=glbk_pack(now);\n"
    "}\n", 0
};

static const struct { char facts[62];
    char s0[428]; char end; } glbk__glsl_prog_rsm_resolve_frag GLBK__TIGHT = {
    "prog/rsm_resolve.frag\0" "rsm_access gbuffer picture rsm_frame" "\0" "" "\0"
    "" "\0" "",
    "\n\n\nlayout(location=0)out vec4 result;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=glbk_picture_at();\n"
    "vec3 light=vec3(.0);\n"
    "glbk_point p;\n"
    "bool seen=glbk_read_point(at,p);\n"
    "glbk_picture_show(seen,p.position);\n"
    "if(glbk_rsm_frame.shows_direct!=0u)light+=glbk_unpack(texelFetch(glbk_rsm_sum,at,0)).xyz;\n"
    "if(glbk_rsm_frame.shows_bounced!=0u)light+=glbk_unpack(texelFetch(glbk_rsm_states,at,0)).xyz;\n"
    "result=vec4(p.diffuse*(1.-p.metallic)*light/RSM_PI,1.);\n"
    "}\n", 0
};

static const struct { char facts[46];
    char s0[780]; char end; } glbk__glsl_prog_rsm_scan_comp GLBK__TIGHT = {
    "prog/rsm_scan.comp\0" "rsm_pick" "\0" "" "\0"
    "ROWS=0 | ROWS=1" "\0" "",
    "\n\n\n\n\n\n#ifndef ROWS\n"
    "#define ROWS 0\n"
    "#endif\n"
    "layout(local_size_x=256)in;\n"
    "shared float rsm_row[2][4096];\n"
    "\nvoid main()\n"
    "{\n"
    "int size=int(glbk_rsm_light.side),now=0;\n"
    "ivec3 at=ivec3(gl_LocalInvocationIndex,gl_WorkGroupID.xy);\n"
    "for(int x=at.x;x<size;x+=256)\n"
    "#if ROWS\n"
    "rsm_row[0][x]=RSM_ROW_SUM(ivec3(size-1,x,at.z));\n"
    "#else\n"
    "{\n"
    "vec3 flux=uintBitsToFloat(RSM_TEXEL(ivec3(x,at.yz),2).xyz);\n"
    "rsm_row[0][x]=flux.x+flux.y+flux.z;\n"
    "}\n"
    "#endif\n"
    "float scale=ROWS==0?1./3.:1.;\n"
    "for(int stride=1;stride<size;stride*=8,now=1-now){\n"
    "barrier();\n"
    "for(int x=at.x;x<size;x+=256){\n"
    "float sum=.0;\n"
    "for(int k=0;k<8&&x-k*stride>=0;k++)sum+=rsm_row[now][x-k*stride]*scale;\n"
    "rsm_row[1-now][x]=sum;\n"
    "}\n"
    "scale=1.;\n"
    "}\n"
    "for(int x=at.x;x<size;x+=256)\n"
    "imageStore(glbk_rsm_running,ivec3(x,at.yz),uvec4(floatBitsToUint(rsm_row[now][x])));\n"
    "}\n", 0
};

static const struct { char facts[74];
    char s0[520]; char end; } glbk__glsl_prog_rsm_scan_frag GLBK__TIGHT = {
    "prog/rsm_scan.frag\0" "rsm_pick rsm_frame" "\0" "" "\0"
    "FROM=0 | FROM=1 | FROM=2 | FROM=3" "\0" "",
    "\n\n\n\n\n#ifndef FROM\n"
    "#define FROM 0\n"
    "#endif\n"
    "layout(location=0)out uint result;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec3 at=ivec3(ivec2(gl_FragCoord.xy),int(glbk_rsm_frame.face));\n"
    "int stride=int(glbk_rsm_frame.stride);\n"
    "float sum=.0;\n"
    "for(int k=0;k<8&&at.x>=0;k++,at.x-=stride){\n"
    "#if FROM == 0\n"
    "sum+=rsm_mean3(uintBitsToFloat(RSM_TEXEL(at,2).xyz));\n"
    "#elif FROM == 1\n"
    "sum+=RSM_ROW_SUM(at);\n"
    "#elif FROM == 2\n"
    "sum+=RSM_ROW_SUM(ivec3(textureSize(glbk_rsm_sums,0).x-1,at.x,at.z));\n"
    "#else\n"
    "sum+=RSM_ROWS_SUM(at.x,at.z);\n"
    "#endif\n"
    "}\n"
    "result=floatBitsToUint(sum);\n"
    "}\n", 0
};

static const struct { char facts[35];
    char s0[1398]; char end; } glbk__glsl_prog_rsm_smooth_comp GLBK__TIGHT = {
    "prog/rsm_smooth.comp\0" "rsm_smooth" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\nlayout(local_size_x=16,local_size_y=16)in;\n"
    "const int SIDE=18;\n"
    "shared vec4 rsm_places[SIDE*SIDE];\n"
    "shared vec4 rsm_lights[SIDE*SIDE];\n"
    "shared vec3 rsm_normals[SIDE*SIDE];\n"
    "\n\nint rsm_here(ivec2 off)\n"
    "{\n"
    "ivec2 at=ivec2(gl_LocalInvocationID.xy)+1+off;\n"
    "return at.y*SIDE+at.x;\n"
    "}\n"
    "\nbool rsm_neighbour(ivec2 at,ivec2 off,out rsm_receiver s,out vec3 light)\n"
    "{\n"
    "int i=rsm_here(off);\n"
    "s=rsm_receiver(rsm_places[i].xyz,rsm_normals[i],1.);\n"
    "light=rsm_lights[i].xyz;\n"
    "return rsm_places[i].w>.0;\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "int step=int(glbk_rsm_frame.step),layer=int(gl_WorkGroupID.z);\n"
    "ivec2 size=rsm_picture_side(),tile=ivec2(gl_WorkGroupID.xy)*16;\n"
    "ivec2 from=ivec2(layer%step,layer/step);\n"
    "ivec2 at=(tile+ivec2(gl_LocalInvocationID.xy))*step+from;\n"
    "for(int i=int(gl_LocalInvocationIndex);i<SIDE*SIDE;i+=256){\n"
    "ivec2 there=(tile+ivec2(i%SIDE,i/SIDE)-1)*step+from;\n"
    "rsm_receiver r=rsm_receiver(vec3(.0),vec3(.0),.0);\n"
    "bool seen=all(greaterThanEqual(there,ivec2(0)))&&all(lessThan(there,size));\n"
    "if(seen)seen=rsm_read(there,r);\n"
    "rsm_places[i]=vec4(r.position,seen?1.:.0);\n"
    "rsm_normals[i]=r.normal;\n"
    "rsm_lights[i]=seen?texelFetch(glbk_rsm_sum,there,0):vec4(.0);\n"
    "}\n"
    "barrier();\n"
    "if(any(greaterThanEqual(at,size)))return;\n"
    "int here=rsm_here(ivec2(0));\n"
    "rsm_receiver r=rsm_receiver(rsm_places[here].xyz,rsm_normals[here],1.);\n"
    "vec4 sum=vec4(.0);\n"
    "if(rsm_places[here].w>.0)sum=rsm_smooth(at,r,rsm_lights[here]);\n"
    "imageStore(glbk_rsm_picture,at,sum);\n"
    "}\n", 0
};

static const struct { char facts[35];
    char s0[592]; char end; } glbk__glsl_prog_rsm_smooth_frag GLBK__TIGHT = {
    "prog/rsm_smooth.frag\0" "rsm_smooth" "\0" "" "\0"
    "" "\0" "",
    "\n\n\nlayout(location=0)out glbk_color result;\n"
    "\nbool rsm_neighbour(ivec2 at,ivec2 off,out rsm_receiver s,out vec3 light)\n"
    "{\n"
    "ivec2 there=at+off*int(glbk_rsm_frame.step),size=rsm_picture_side();\n"
    "bool inside=all(greaterThanEqual(there,ivec2(0)))&&all(lessThan(there,size));\n"
    "light=vec3(.0);\n"
    "if(!inside||!rsm_read(there,s))return false;\n"
    "light=glbk_unpack(texelFetch(glbk_rsm_sum,there,0)).xyz;\n"
    "return true;\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_FragCoord.xy);\n"
    "rsm_receiver r;\n"
    "vec4 sum=vec4(.0);\n"
    "if(rsm_read(at,r))sum=rsm_smooth(at,r,glbk_unpack(texelFetch(glbk_rsm_sum,at,0)));\n"
    "result=glbk_pack(sum);\n"
    "}\n", 0
};

static const struct { char facts[57];
    char s0[531]; char end; } glbk__glsl_prog_rsm_stats_frag GLBK__TIGHT = {
    "prog/rsm_stats.frag\0" "rsm_bindings rsm_access rsm_bound" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\nlayout(location=0)out uvec4 result;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_FragCoord.xy);\n"
    "int face=at.y/3,what=at.y-3*face,size=int(glbk_rsm_light.side);\n"
    "rsm_light l=rsm_bound();\n"
    "uint lit=0u;\n"
    "vec3 sum=vec3(.0);\n"
    "for(int i=0;i<size;i++){\n"
    "ivec3 t=ivec3(i,at.x,face);\n"
    "vec3 flux=uintBitsToFloat(RSM_TEXEL(t,2).xyz);\n"
    "lit+=rsm_mean3(flux)>.0?1u:0u;\n"
    "if(what==0||!(uintBitsToFloat(RSM_TEXEL(t,0).w)<3.0e38))continue;\n"
    "sum+=what==1?rsm_incident(l,face,t.xy)*l.value:flux;\n"
    "}\n"
    "result=what==0?uvec4(lit,0u,0u,0u):uvec4(floatBitsToUint(sum),0u);\n"
    "}\n", 0
};

static const glbk_file glbk__rsm_files[] = {
    { (const char *)&glbk__glsl_lib_rsm_access_glsl },
    { (const char *)&glbk__glsl_lib_rsm_bindings_glsl },
    { (const char *)&glbk__glsl_lib_rsm_bounce_glsl },
    { (const char *)&glbk__glsl_lib_rsm_bound_glsl },
    { (const char *)&glbk__glsl_lib_rsm_chunk_glsl },
    { (const char *)&glbk__glsl_lib_rsm_direct_glsl },
    { (const char *)&glbk__glsl_lib_rsm_drawn_glsl },
    { (const char *)&glbk__glsl_lib_rsm_frame_glsl },
    { (const char *)&glbk__glsl_lib_rsm_gather_glsl },
    { (const char *)&glbk__glsl_lib_rsm_grid_glsl },
    { (const char *)&glbk__glsl_lib_rsm_imported_glsl },
    { (const char *)&glbk__glsl_lib_rsm_light_glsl },
    { (const char *)&glbk__glsl_lib_rsm_lists_glsl },
    { (const char *)&glbk__glsl_lib_rsm_map_glsl },
    { (const char *)&glbk__glsl_lib_rsm_pick_glsl },
    { (const char *)&glbk__glsl_lib_rsm_sampling_glsl },
    { (const char *)&glbk__glsl_lib_rsm_screen_glsl },
    { (const char *)&glbk__glsl_lib_rsm_smooth_glsl },
    { (const char *)&glbk__glsl_prog_rsm_begin_comp },
    { (const char *)&glbk__glsl_prog_rsm_direct_frag },
    { (const char *)&glbk__glsl_prog_rsm_fill_frag },
    { (const char *)&glbk__glsl_prog_rsm_fill_vert },
    { (const char *)&glbk__glsl_prog_rsm_gather_comp },
    { (const char *)&glbk__glsl_prog_rsm_gather_frag },
    { (const char *)&glbk__glsl_prog_rsm_import_frag },
    { (const char *)&glbk__glsl_prog_rsm_interpolate_comp },
    { (const char *)&glbk__glsl_prog_rsm_interpolate_frag },
    { (const char *)&glbk__glsl_prog_rsm_pick_frag },
    { (const char *)&glbk__glsl_prog_rsm_recall_frag },
    { (const char *)&glbk__glsl_prog_rsm_resolve_frag },
    { (const char *)&glbk__glsl_prog_rsm_scan_comp },
    { (const char *)&glbk__glsl_prog_rsm_scan_frag },
    { (const char *)&glbk__glsl_prog_rsm_smooth_comp },
    { (const char *)&glbk__glsl_prog_rsm_smooth_frag },
    { (const char *)&glbk__glsl_prog_rsm_stats_frag }
};


/* ==== src/gl_rsm/part.h ==== */

/* ---- rsm: this header's GLSL, textures and blocks, by which programs find them ---- */

GLBK__PART_CODE(rsm, RSM)

/* ==== src/gl_rsm/arguments.h ==== */

/* ---- rsm: arguments: checked as rsm.h and gifilter.h check them, with their defaults ---- */

enum {
    GLBK__RSM_LIST = 1024 * 64,     /* pixel lights that the list has room for */
    GLBK__RSM_TABLE = 1024,         /* the most materials, and texels a side of the noise */
    GLBK__RSM_NONE = 9,             /* the number of no picture */
    GLBK__RSM_FAR_BITS = 0x7f61b1e6 /* the bits of RSM_FAR */
};

typedef struct glbk__rsm_range {    /* a field, its value and its range */
    const char *field;
    double      value, low, high;
} glbk__rsm_range;

/* Logs the first field that is out of its range. A field that is not a number is out of any range. */
static glbk_result glbk__rsm_in_range(const glbk_context *ctx, const char *function,
                                      const glbk__rsm_range *fields, size_t count)
{
    size_t i;
    for (i = 0; i < count; i++) {
        const glbk__rsm_range *f = &fields[i];
        if (f->value >= f->low && f->value <= f->high) continue;
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, f->field, f->value, f->low, f->high);
    }
    return GLBK_OK;
}

/* Logs "FUNCTION: ARRAY[INDEX]FIELD is VALUE; it must be WANTED". field: "" or ".NAME". */
static glbk_result glbk__rsm_refuse_element(const glbk_context *ctx, glbk_result result, const char *function,
                                            const char *array, size_t index, const char *field, double value,
                                            const char *wanted)
{
    glbk_rsm__message name;
    name.used = 0;
    glbk_rsm__message_text(&name, array);
    glbk_rsm__message_text(&name, "[");
    glbk_rsm__message_count(&name, index);
    glbk_rsm__message_text(&name, "]");
    glbk_rsm__message_text(&name, field);
    return glbk__refuse_value(ctx, result, function, name.text, value, wanted);
}

/* Checks that a desc has no system, since on GL the context's system gives memory and gets messages. */
static glbk_result glbk__rsm_no_system(const glbk_context *ctx, const char *function, const rsm_system *s)
{
    if (!s->allocator.alloc_fn && !s->allocator.free_fn && !s->allocator.user && !s->parallel_for &&
        !s->progress && !s->log && !s->user)
        return GLBK_OK;
    return glbk__refuse(ctx, GLBK_ERR_DESC, function, "desc.system",
                        "is not zero: on GL the context's counts");
}

/* Checks that three floats are at most 1e9 large. */
static glbk_result glbk__rsm_small_check(const glbk_context *ctx, const char *function, const char *field,
                                         const float *v)
{
    size_t i;
    for (i = 0; i < 3; i++)
        if (!(fabsf(v[i]) <= 1e9f))
            return glbk__rsm_refuse_element(ctx, GLBK_ERR_DESC, function, field, i, "", (double)v[i],
                                            "-1e9..1e9");
    return GLBK_OK;
}

/* Checks direction, radius and cone of a light. */
static glbk_result glbk__rsm_shape_check(const glbk_context *ctx, const char *function, const rsm_light *l)
{
    const glbk_result bad = GLBK_ERR_DESC;
    const float angle = l->cone_half_angle, most = l->kind == RSM_LIGHT_SPOT ? 3.14f : 1.0f;
    const int spot = l->kind == RSM_LIGHT_SPOT || l->kind == RSM_LIGHT_SQUARE_SPOT;
    const float d2 = l->direction[0] * l->direction[0] + l->direction[1] * l->direction[1] +
                     l->direction[2] * l->direction[2];
    if (l->kind != RSM_LIGHT_POINT && !(d2 > 1e-30f && d2 <= 1e30f))
        return glbk__refuse_value(ctx, bad, function, "the length of light.direction", sqrt((double)d2),
                                  "1e-15..1e15");
    if (l->kind == RSM_LIGHT_SUN && !(l->radius > 0.0f && l->radius <= 1e9f))
        return glbk__refuse_value(ctx, bad, function, "light.radius", (double)l->radius,
                                  "above 0, at most 1e9");
    if (spot && !(angle > 0.5e-3f && angle <= most))
        return glbk__refuse_value(ctx, bad, function, "light.cone_half_angle", (double)angle,
                                  l->kind == RSM_LIGHT_SPOT ? "above 0.0005, at most 3.14"
                                                            : "above 0.0005, at most 1");
    return GLBK_OK;
}

/* Checks a light as rsm.h does, and writes the light with its defaults. */
static glbk_result glbk__rsm_light_check(const glbk_context *ctx, const char *function,
                                         const rsm_light *light, rsm_light *l)
{
    const glbk_result bad = GLBK_ERR_DESC;
    glbk_result result;
    size_t i;
    if (!light) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "light", "is NULL");
    *l = *light;
    if (l->kind == RSM_LIGHT_DEFAULT) l->kind = RSM_LIGHT_SUN;
    if ((unsigned)l->kind >= RSM_LIGHT_COUNT)
        return glbk__refuse_value(ctx, bad, function, "light.kind", (double)l->kind, "one of rsm_light_kind");
    result = glbk__rsm_small_check(ctx, function, "light.position", l->position);
    if (result == GLBK_OK) result = glbk__rsm_small_check(ctx, function, "light.up", l->up);
    for (i = 0; i < 3 && result == GLBK_OK; i++)
        if (!(l->value[i] >= 0.0f && l->value[i] <= 1e12f))
            result = glbk__rsm_refuse_element(ctx, bad, function, "light.value", i, "", (double)l->value[i],
                                              "0..1e12");
    if (result == GLBK_OK) result = glbk__rsm_shape_check(ctx, function, l);
    if (result != GLBK_OK) return result;
    if (!(fabsf(l->near_depth) > 0.0f) && !(fabsf(l->far_depth) > 0.0f)) {
        l->near_depth = l->kind == RSM_LIGHT_SUN ? -l->radius : 1e-3f;
        l->far_depth = l->kind == RSM_LIGHT_SUN ? l->radius : 1e3f;
    }
    if (!(fabsf(l->near_depth) <= 1e9f) || (l->kind != RSM_LIGHT_SUN && !(l->near_depth > 0.0f)))
        return glbk__refuse_value(ctx, bad, function, "light.near_depth", (double)l->near_depth,
                                  l->kind == RSM_LIGHT_SUN ? "-1e9..1e9" : "above 0, at most 1e9");
    if (l->far_depth > l->near_depth && l->far_depth <= 1e9f) return GLBK_OK;
    return glbk__refuse_value(ctx, bad, function, "light.far_depth", (double)l->far_depth,
                              "above near_depth, at most 1e9");
}

/* ---- maps, renderers and G-buffers that a call was given ---- */

/* Checks that a map was created. */
static glbk_result glbk__rsm_map_check(const glbk_context *ctx, const char *function, const glbk_rsm_map *map)
{
    if (map && map->texels.name) return GLBK_OK;
    return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "map", map ? "was not created" : "is NULL");
}

/* Checks that a renderer was created. */
static glbk_result glbk__rsm_renderer_check(const glbk_context *ctx, const char *function,
                                            const glbk_rsm_renderer *r)
{
    if (r && r->frame.name) return GLBK_OK;
    return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "renderer", r ? "was not created" : "is NULL");
}

/* Checks that a renderer and a G-buffer were created, for pictures of one size. */
static glbk_result glbk__rsm_gbuffer_check(const glbk_context *ctx, const char *function,
                                           const glbk_rsm_renderer *r, const glbk_gbuffer *gbuffer)
{
    const glbk_result result = glbk__rsm_renderer_check(ctx, function, r);
    if (result != GLBK_OK) return result;
    if (!gbuffer || !gbuffer->colors.name)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "gbuffer",
                            gbuffer ? "was not created" : "is NULL");
    if (gbuffer->width != r->width)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "gbuffer->width", gbuffer->width,
                                  "that of the renderer");
    if (gbuffer->height == r->height) return GLBK_OK;
    return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "gbuffer->height", gbuffer->height,
                              "that of the renderer");
}

/* Checks that a renderer and all maps were created, and that there is a map. */
static glbk_result glbk__rsm_maps_check(const glbk_context *ctx, const char *function,
                                        const glbk_rsm_renderer *r, const glbk_rsm_map *const *maps,
                                        uint32_t count)
{
    const glbk_result result = glbk__rsm_renderer_check(ctx, function, r);
    uint32_t i;
    if (result != GLBK_OK) return result;
    if (!maps) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "maps", "is NULL");
    if (!count)
        return glbk__refuse_value(ctx, GLBK_ERR_ARGUMENT, function, "map_count", 0, "1 at least");
    for (i = 0; i < count; i++) {
        glbk_rsm__message name;
        if (maps[i] && maps[i]->texels.name) continue;
        name.used = 0;
        glbk_rsm__message_text(&name, "maps[");
        glbk_rsm__message_count(&name, i);
        glbk_rsm__message_text(&name, "]");
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, name.text,
                            maps[i] ? "was not created" : "is NULL");
    }
    return GLBK_OK;
}

/* ---- descs of rsm.h and gifilter.h, with their defaults ---- */

/* Checks a desc of direct light as rsm_direct does, and writes the desc with its defaults. */
static glbk_result glbk__rsm_direct_check(const glbk_context *ctx, const rsm_direct_desc *desc,
                                          rsm_direct_desc *out)
{
    static const char function[] = "glbk_rsm_direct";
    glbk_result result;
    memset(out, 0, sizeof *out);
    if (desc) *out = *desc;
    {
        const glbk__rsm_range fields[] = { { "desc.tap_side", (double)out->tap_side, 0, 15 },
                                           { "desc.bias", (double)out->bias, -1e6, 1e6 },
                                           { "desc.slope_bias", (double)out->slope_bias, -1e6, 1e6 } };
        result = glbk__rsm_in_range(ctx, function, fields, sizeof fields / sizeof fields[0]);
    }
    if (result == GLBK_OK) result = glbk__rsm_no_system(ctx, function, &out->system);
    if (result != GLBK_OK) return result;
    if (out->add)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.add", (double)out->add,
                                  "0: give all maps to one call");
    if (!out->tap_side) out->tap_side = 2;
    if (!(fabsf(out->bias) > 0.0f)) out->bias = 0.5f;
    if (!(fabsf(out->slope_bias) > 0.0f)) out->slope_bias = 1.0f;
    if (out->bias < 0.0f) out->bias = 0.0f;
    if (out->slope_bias < 0.0f) out->slope_bias = 0.0f;
    return GLBK_OK;
}

/* Checks a desc of bounced light as rsm_gather does, and writes the desc with its defaults. */
static glbk_result glbk__rsm_gather_check(const glbk_context *ctx, const char *function,
                                          const rsm_gather_desc *desc, rsm_gather_desc *out)
{
    const uint32_t k = desc ? desc->interleave : 0;
    glbk_result result;
    memset(out, 0, sizeof *out);
    if (desc) *out = *desc;
    {
        const glbk__rsm_range fields[] = {
            { "desc.pattern", (double)out->pattern, 0, RSM_PATTERN_COUNT - 1 },
            { "desc.sample_count", (double)out->sample_count, 0,
              out->pattern == RSM_PATTERN_POISSON ? 4096.0 : 1048576.0 },
            { "desc.r_max", (double)out->r_max, 0, 1e3 },
            { "desc.r_min", (double)out->r_min, 0, 0.99999994 },
            { "desc.offset", (double)out->offset, 0, 1e9 },
            { "desc.clamp", (double)out->clamp, 0, (double)1e18f },
            { "desc.near_limit", (double)out->near_limit, 0, 1e6 },
            { "desc.near_field", (double)out->near_field, 0, 32 }
        };
        result = glbk__rsm_in_range(ctx, function, fields, sizeof fields / sizeof fields[0]);
    }
    if (result == GLBK_OK) result = glbk__rsm_no_system(ctx, function, &out->system);
    if (result != GLBK_OK) return result;
    if (k > 8 || (k & (k - 1)))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.interleave", k, "0, 1, 2, 4 or 8");
    if (out->add)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.add", (double)out->add,
                                  "0: give all maps to one call");
    if (out->visible_fn)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, "desc.visible_fn",
                            "is not NULL: a GPU cannot call it; gl_ism.h has shadows of bounced light");
    if (!out->materials && out->material_count)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, "desc.materials",
                            "is NULL, and material_count is not 0");
    if (out->noise && !out->noise_side)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "desc.noise_side", 0, 1, GLBK__RSM_TABLE);
    if (!k) out->interleave = 1;
    if (out->pattern == RSM_PATTERN_DEFAULT) out->pattern = RSM_PATTERN_FLUX;
    if (!(out->r_min > 0.0f)) out->r_min = 1.0f / 32.0f;
    return GLBK_OK;
}

/* Checks interpolation as rsm_interpolate does, and writes the struct with its defaults. */
static glbk_result glbk__rsm_interpolation_check(const glbk_context *ctx, const rsm_interpolation *how,
                                                 rsm_interpolation *out)
{
    static const char function[] = "glbk_rsm_interpolate";
    memset(out, 0, sizeof *out);
    if (how) *out = *how;
    if (!out->step) out->step = 8;
    if (out->step < 2 || out->step > 64 || (out->step & (out->step - 1)))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "interpolation.step", out->step,
                                  "0 or a power of two, 2..64");
    {
        const glbk__rsm_range fields[] = {
            { "interpolation.level_count", (double)out->level_count, 0, 6 },
            { "interpolation.normal_cosine", (double)out->normal_cosine, -1, 1 },
            { "interpolation.plane_slope", (double)out->plane_slope, 0, 1e6 },
            { "interpolation.distance", (double)out->distance, 0, 1e9 },
            { "interpolation.contrast", (double)out->contrast, -1e6, 1e6 },
            { "interpolation.light_share", (double)out->light_share, -1e6, 1e6 }
        };
        const glbk_result result = glbk__rsm_in_range(ctx, function, fields,
                                                      sizeof fields / sizeof fields[0]);
        if (result != GLBK_OK) return result;
    }
    if (out->mask)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, "interpolation.mask",
                            "is not NULL: alpha of glbk_rsm_read says what each pixel is");
    if (!out->level_count) out->level_count = 6;
    if (!(fabsf(out->normal_cosine) > 0.0f)) out->normal_cosine = 0.95f;
    if (!(out->plane_slope > 0.0f)) out->plane_slope = 0.05f;
    if (!(fabsf(out->contrast) > 0.0f)) out->contrast = 0.25f;
    if (!(fabsf(out->light_share) > 0.0f)) out->light_share = 0.25f;
    return GLBK_OK;
}

/* Checks a frame of the filter as gifilt_apply does, and writes the frame with its defaults. */
static glbk_result glbk__rsm_frame_check(const glbk_context *ctx, const gifilt_frame *frame,
                                         gifilt_frame *out)
{
    static const char function[] = "glbk_rsm_denoise";
    size_t i;
    memset(out, 0, sizeof *out);
    if (frame) *out = *frame;
    {
        const glbk__rsm_range fields[] = {
            { "frame.rows", (double)out->rows, 0, GIFILT_ROWS_COUNT - 1 },
            { "frame.history", (double)out->history, 0, 1000 },
            { "frame.passes", (double)out->passes, -1e9, 6 },
            { "frame.normal_cosine", (double)out->normal_cosine, 0, 0.99999994 },
            { "frame.plane_slope", (double)out->plane_slope, 0, 1e6 }
        };
        const glbk_result result = glbk__rsm_in_range(ctx, function, fields,
                                                      sizeof fields / sizeof fields[0]);
        if (result != GLBK_OK) return result;
    }
    for (i = 0; i < 16 && out->world_to_clip; i++)
        if (!(fabsf(out->world_to_clip[i]) <= 3.0e38f))
            return glbk__rsm_refuse_element(ctx, GLBK_ERR_DESC, function, "frame.world_to_clip", i, "",
                                            (double)out->world_to_clip[i], "finite");
    if (out->motion)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, "frame.motion",
                            "is not NULL: on GL motion is a texture");
    if (!out->history) out->history = 8;
    if (!out->passes) out->passes = 2;
    if (out->passes < 0) out->passes = 0;
    if (!(out->normal_cosine > 0.0f)) out->normal_cosine = 0.9f;
    if (!(out->plane_slope > 0.0f)) out->plane_slope = 0.1f;
    return GLBK_OK;
}

/* ---- tables ---- */

GLBK_DEF uint32_t glbk_rsm_point_count(const rsm_gather_desc *d)
{
    uint32_t samples, sets;
    if (!d || !d->sample_count || d->pattern == RSM_PATTERN_DEFAULT || d->pattern == RSM_PATTERN_FLUX)
        return 0;
    sets = d->interleave ? d->interleave * d->interleave : 1;
    samples = d->pattern == RSM_PATTERN_MIXED ? 3 * d->sample_count / 5 : d->sample_count;
    return (samples + sets - 1) / sets * sets;
}

/* Checks noise and materials as rsm_gather does. */
static glbk_result glbk__rsm_values_check(const glbk_context *ctx, const rsm_gather_desc *d)
{
    static const char function[] = "glbk_rsm_tables_upload";
    const uint32_t count = d->materials ? d->material_count : 0, side = d->noise ? d->noise_side : 0;
    uint32_t i;
    if (side > GLBK__RSM_TABLE)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "desc.noise_side", side, 1, GLBK__RSM_TABLE);
    if (count > GLBK__RSM_TABLE)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "desc.material_count", count, 0,
                                  GLBK__RSM_TABLE);
    for (i = 0; i < side * side; i++)
        if (!(d->noise[i] >= 0.0f && d->noise[i] <= 1.0f))
            return glbk__rsm_refuse_element(ctx, GLBK_ERR_INPUT, function, "desc.noise", i, "",
                                            (double)d->noise[i], "0..1");
    for (i = 0; i < count; i++) {
        const rsm_material *m = &d->materials[i];
        int c;
        if (!(m->exponent >= 0.0f && m->exponent <= 1e4f))
            return glbk__rsm_refuse_element(ctx, GLBK_ERR_INPUT, function, "desc.materials", i, ".exponent",
                                            (double)m->exponent, "0..1e4");
        for (c = 0; c < 3; c++)
            if (!(m->specular[c] >= 0.0f && m->specular[c] <= 1.0f))
                return glbk__rsm_refuse_element(ctx, GLBK_ERR_INPUT, function, "desc.materials", i,
                                                ".specular", (double)m->specular[c], "0..1");
    }
    return GLBK_OK;
}

/* Checks that the tables on the GPU are those of a checked desc, as far as the desc needs tables. */
static glbk_result glbk__rsm_tables_check(const glbk_context *ctx, const char *function,
                                          const glbk_rsm_renderer *r, const rsm_gather_desc *d)
{
    const rsm_gather_desc *t = &r->tables;
    const int about = glbk_rsm_point_count(d) > 0;
    const struct {
        int counts;                     /* whether this pattern depends on the field */
        const char *field;
        double value, uploaded;
    } fields[] = {
        { about, "desc.pattern", (double)d->pattern, (double)t->pattern },
        { about, "desc.sample_count", (double)d->sample_count, (double)t->sample_count },
        { about, "desc.interleave", (double)d->interleave, (double)t->interleave },
        { about, "desc.seed", (double)d->seed, (double)t->seed },
        { about && d->pattern == RSM_PATTERN_EQUATION3, "desc.paper_weights", (double)(d->paper_weights != 0),
          (double)(t->paper_weights != 0) },
        { about && d->pattern == RSM_PATTERN_LOG_RADIAL, "desc.r_min", (double)d->r_min, (double)t->r_min },
        { about && d->noise, "desc.noise_side", (double)d->noise_side, (double)r->noise_side },
        { d->materials != NULL, "desc.material_count", (double)d->material_count, (double)r->material_count }
    };
    size_t i;
    for (i = 0; i < sizeof fields / sizeof fields[0]; i++) {
        glbk_rsm__message text;
        if (!fields[i].counts || !(fabs(fields[i].value - fields[i].uploaded) > 0.0)) continue;
        text.used = 0;
        glbk_rsm__message_number(&text, fields[i].uploaded);
        glbk_rsm__message_text(&text, ", which glbk_rsm_tables_upload was given last");
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, fields[i].field, fields[i].value,
                                  text.text);
    }
    return GLBK_OK;
}

/* ==== src/gl_rsm/maps.h ==== */

/* ---- rsm: maps: their images, uploads and readings ---- */

enum {                              /* programs of a renderer */
    GLBK__RSM_FILL,
    GLBK__RSM_SCAN,                 /* the first step of sums along rows; _ON does the next steps */
    GLBK__RSM_SCAN_ON,
    GLBK__RSM_SCAN_ROWS,            /* the first step of sums of rows */
    GLBK__RSM_SCAN_ROWS_ON,
    GLBK__RSM_PICK,
    GLBK__RSM_PICK_ALL,
    GLBK__RSM_IMPORT,               /* from 2D textures; the next two from arrays and from cubes */
    GLBK__RSM_IMPORT_ARRAYS,
    GLBK__RSM_IMPORT_CUBES,
    GLBK__RSM_STATS,
    GLBK__RSM_DIRECT,               /* from here on all but DO_SCAN and DO_SCAN_ROWS read the G-buffer */
    GLBK__RSM_GATHER,
    GLBK__RSM_INTERPOLATE,
    GLBK__RSM_RECALL,
    GLBK__RSM_SMOOTH,
    GLBK__RSM_RESOLVE,
    GLBK__RSM_DO_SCAN,              /* a compute shader, like all that follow but GATHER_SURFACES */
    GLBK__RSM_DO_SCAN_ROWS,
    GLBK__RSM_DO_GATHER,
    GLBK__RSM_DO_NODES,
    GLBK__RSM_GATHER_SURFACES,      /* for near_field, like the next two */
    GLBK__RSM_DO_GATHER_SURFACES,
    GLBK__RSM_DO_NODES_SURFACES,
    GLBK__RSM_DO_BEGIN,
    GLBK__RSM_DO_INTERPOLATE,
    GLBK__RSM_DO_LISTED,
    GLBK__RSM_DO_SMOOTH
};

/* Each program has its file and its defines here. */
static const char *const glbk__rsm_programs[GLBK_RSM_PROGRAM_COUNT][2] = {
    { "rsm_fill.frag", NULL },
    { "rsm_scan.frag", "FROM=0" },
    { "rsm_scan.frag", "FROM=1" },
    { "rsm_scan.frag", "FROM=2" },
    { "rsm_scan.frag", "FROM=3" },
    { "rsm_pick.frag", "ALL=0" },
    { "rsm_pick.frag", "ALL=1" },
    { "rsm_import.frag", "KIND=0" },
    { "rsm_import.frag", "KIND=1" },
    { "rsm_import.frag", "KIND=2" },
    { "rsm_stats.frag", NULL },
    { "rsm_direct.frag", NULL },
    { "rsm_gather.frag", NULL },
    { "rsm_interpolate.frag", NULL },
    { "rsm_recall.frag", NULL },
    { "rsm_smooth.frag", NULL },
    { "rsm_resolve.frag", NULL },
    { "rsm_scan.comp", "ROWS=0" },
    { "rsm_scan.comp", "ROWS=1" },
    { "rsm_gather.comp", "NODES=0" },
    { "rsm_gather.comp", "NODES=1" },
    { "rsm_gather.frag", "RSM_SURFACES=1" },
    { "rsm_gather.comp", "NODES=0 RSM_SURFACES=1" },
    { "rsm_gather.comp", "NODES=1 RSM_SURFACES=1" },
    { "rsm_begin.comp", NULL },
    { "rsm_interpolate.comp", "RSM_GROUP=256" },
    { "rsm_interpolate.comp", "RSM_GROUP=64" },
    { "rsm_smooth.comp", NULL }
};

/* Returns how many faces the map of a light has. */
static uint32_t glbk__rsm_face_count(const rsm_light *l)
{
    if (l->kind == RSM_LIGHT_PATCH) return 5;
    return l->kind == RSM_LIGHT_POINT || (l->kind == RSM_LIGHT_SPOT && l->cone_half_angle > 1.0f) ? 6 : 1;
}

/* Writes a vector, and w as the fourth number. */
static void glbk__rsm_set4(float *out, glbk_rsm__v3 v, float w)
{
    glbk_rsm__v3_store(out, v);
    out[3] = w;
}

/* Fills the block that shaders know the light by, as rsm.h computes its numbers. */
static void glbk__rsm_set_block(glbk_rsm_map *map)
{
    const rsm_light *l = &map->light;
    glbk_rsm__v3 axis = glbk_rsm__v3_make(0, 0, -1), up = glbk_rsm__v3_make(0, 1, 0), right;
    float extent = 1.0f, cos_half = -1.0f;
    if (l->kind != RSM_LIGHT_POINT) {
        axis = glbk_rsm__v3_normalize(glbk_rsm__v3_load(l->direction));
        if (l->kind == RSM_LIGHT_SUN) axis = glbk_rsm__v3_scale(axis, -1);
        up = glbk_rsm__v3_normalize(glbk_rsm__v3_load(l->up));
    }
    if (glbk_rsm__v3_length(glbk_rsm__v3_cross(axis, up)) < 1e-3f)
        up = fabsf(axis.y) < 0.9f ? glbk_rsm__v3_make(0, 1, 0) : glbk_rsm__v3_make(0, 0, 1);
    right = glbk_rsm__v3_normalize(glbk_rsm__v3_cross(axis, up));
    up = glbk_rsm__v3_cross(right, axis);
    if (l->kind == RSM_LIGHT_SUN) extent = l->radius;
    if ((l->kind == RSM_LIGHT_SPOT && map->face_count == 1) || l->kind == RSM_LIGHT_SQUARE_SPOT)
        extent = tanf(l->cone_half_angle);
    if (l->kind == RSM_LIGHT_SPOT) cos_half = cosf(l->cone_half_angle);
    glbk__rsm_set4(map->block.position, glbk_rsm__v3_load(l->position), 1);
    glbk__rsm_set4(map->block.right, right, 0);
    glbk__rsm_set4(map->block.up, up, 0);
    glbk__rsm_set4(map->block.axis, axis, 0);
    glbk__rsm_set4(map->block.value, glbk_rsm__v3_load(l->value), 0);
    map->block.extent = extent;
    map->block.cos_half = cos_half;
    map->block.side = map->side;
    map->block.face_count = map->face_count;
    map->block.kind = (uint32_t)l->kind;
}

/* Finds right, up and axis of a face, as rsm.h does. */
static void glbk__rsm_face_axes(const glbk_rsm_map *map, uint32_t face, glbk_rsm__v3 *r, glbk_rsm__v3 *u,
                                glbk_rsm__v3 *a)
{
    glbk_rsm__v3 right = glbk_rsm__v3_load(map->block.right), up = glbk_rsm__v3_load(map->block.up);
    glbk_rsm__v3 axis = glbk_rsm__v3_load(map->block.axis);
    *r = right;
    *u = up;
    *a = axis;
    switch (face) {
    case 1: *r = glbk_rsm__v3_scale(axis, -1); *a = right; break;
    case 2: *r = axis; *a = glbk_rsm__v3_scale(right, -1); break;
    case 3: *u = glbk_rsm__v3_scale(axis, -1); *a = up; break;
    case 4: *u = axis; *a = glbk_rsm__v3_scale(up, -1); break;
    case 5: *r = glbk_rsm__v3_scale(right, -1); *a = glbk_rsm__v3_scale(axis, -1); break;
    default: break;
    }
}

/* Computes the matrix that a face is drawn with, world to OpenGL's clip space. */
static void glbk__rsm_face_matrix(const glbk_rsm_map *map, uint32_t face, float m[16])
{
    glbk_rsm__v3 r, u, a, p;
    const int perspective = map->light.kind != RSM_LIGHT_SUN;
    const float n = map->light.near_depth, f = map->light.far_depth, s = 1.0f / map->block.extent;
    const float z0 = perspective ? (f + n) / (f - n) : 2.0f / (f - n);
    const float z1 = perspective ? -2.0f * n * f / (f - n) : -2.0f * n / (f - n) - 1.0f;
    int i;
    glbk__rsm_face_axes(map, face, &r, &u, &a);
    p = glbk_rsm__v3_load(map->light.position);
    for (i = 0; i < 3; i++) {
        float axis = i == 0 ? a.x : i == 1 ? a.y : a.z;
        m[4 * i] = s * (i == 0 ? r.x : i == 1 ? r.y : r.z);
        m[4 * i + 1] = s * (i == 0 ? u.x : i == 1 ? u.y : u.z);
        m[4 * i + 2] = z0 * axis;
        m[4 * i + 3] = perspective ? axis : 0.0f;
    }
    m[12] = -s * glbk_rsm__v3_dot(r, p);
    m[13] = -s * glbk_rsm__v3_dot(u, p);
    m[14] = z1 - z0 * glbk_rsm__v3_dot(a, p);
    m[15] = perspective ? -glbk_rsm__v3_dot(a, p) : 1.0f;
}

/* Makes an image, which is an array unless layers is 0. */
static glbk_result glbk__rsm_image(glbk_context *ctx, glbk_format format, uint32_t width, uint32_t height,
                                   uint32_t layers, glbk_texture *out)
{
    glbk_texture_desc d;
    memset(&d, 0, sizeof d);
    d.format = format;
    d.width = width;
    d.height = height;
    d.layers = layers;
    return glbk_texture_create(ctx, &d, out);
}

/* Makes a framebuffer of layers first .. first + count - 1 of an image. */
static glbk_result glbk__rsm_target(glbk_context *ctx, const glbk_texture *texture, uint32_t first,
                                    uint32_t count, const glbk_texture *depth, glbk_target *out)
{
    glbk_target_desc d;
    uint32_t i;
    memset(&d, 0, sizeof d);
    for (i = 0; i < count; i++) {
        d.color[i] = texture;
        d.layer[i] = first + i;
    }
    d.depth = depth;
    return glbk__target_create(ctx, &d, out);
}

/* Makes all images and framebuffers of a map. */
static glbk_result glbk__rsm_map_images(glbk_context *ctx, glbk_rsm_map *map)
{
    uint32_t n = map->side, f, i;
    glbk_result result = glbk__rsm_image(ctx, GLBK_FORMAT_RGBA32UI, n, n, 3 * map->face_count, &map->texels);
    if (result == GLBK_OK) result = glbk__rsm_image(ctx, GLBK_FORMAT_DEPTH32F, n, n, 0, &map->depth);
    for (i = 0; i < 2; i++) {
        if (result == GLBK_OK)
            result = glbk__rsm_image(ctx, GLBK_FORMAT_R32UI, n, n, map->face_count, &map->sums[i]);
        if (result == GLBK_OK)
            result = glbk__rsm_image(ctx, GLBK_FORMAT_R32UI, n, 1, map->face_count, &map->rows[i]);
        for (f = 0; f < map->face_count && result == GLBK_OK; f++) {
            result = glbk__rsm_target(ctx, &map->sums[i], f, 1, NULL, &map->sum_targets[i][f]);
            if (result == GLBK_OK)
                result = glbk__rsm_target(ctx, &map->rows[i], f, 1, NULL, &map->row_targets[i][f]);
        }
    }
    for (f = 0; f < map->face_count && result == GLBK_OK; f++)
        result = glbk__rsm_target(ctx, &map->texels, 3 * f, 3, &map->depth, &map->face_targets[f]);
    return result;
}

GLBK_DEF glbk_result glbk_rsm_map_create(glbk_context *ctx, const rsm_light *light, uint32_t side,
                                         glbk_rsm_map *out)
{
    rsm_light checked;
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!out) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "out", "is NULL");
    memset(out, 0, sizeof *out);
    result = glbk__rsm_light_check(ctx, __func__, light, &checked);
    if (result != GLBK_OK) return result;
    if (side && (side < 4 || side > 4096))
        return glbk__refuse_value(ctx, GLBK_ERR_ARGUMENT, __func__, "side", side, "0 or 4..4096");
    out->light = checked;
    out->face_count = glbk__rsm_face_count(&out->light);
    out->side = side ? side : out->face_count > 1 ? 256 : 512;
    glbk__rsm_set_block(out);
    result = glbk__rsm_map_images(ctx, out);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof out->block, &out->block, &out->buffer);
    if (result != GLBK_OK) glbk_rsm_map_free(ctx, out);
    return result;
}

GLBK_DEF glbk_result glbk_rsm_map_place(glbk_context *ctx, glbk_rsm_map *map, const rsm_light *light)
{
    rsm_light checked;
    glbk_result result;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_map_check(ctx, __func__, map);
    if (result == GLBK_OK) result = glbk__rsm_light_check(ctx, __func__, light, &checked);
    if (result != GLBK_OK) return result;
    if (glbk__rsm_face_count(&checked) != map->face_count)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, __func__,
                                  "the number of faces that the light needs", glbk__rsm_face_count(&checked),
                                  "that of the map");
    map->light = checked;
    map->summed = 0;
    glbk__rsm_set_block(map);
    return glbk_buffer_update(ctx, &map->buffer, 0, sizeof map->block, &map->block);
}

/* Copies layer k of three out of an array of rsm_texel, whose elements have 16 bytes of each layer; if out is
   not 0, copies the layer into the array. */
static void glbk__rsm_copy_layer(unsigned char *texels, unsigned char *layer, size_t count, size_t k, int out)
{
    size_t i;
    for (i = 0; i < count; i++)
        if (out) memcpy(texels + 48 * i + 16 * k, layer + 16 * i, 16);
        else memcpy(layer + 16 * i, texels + 48 * i + 16 * k, 16);
}

GLBK_DEF glbk_result glbk_rsm_map_upload(glbk_context *ctx, glbk_rsm_map *map, const rsm_texel *texels)
{
    glbk_rsm__allocator memory;
    unsigned char *layer;
    size_t count;
    glbk_box box = { 0, 0, 0, 0, 0, 0, 1 };
    uint32_t i;
    glbk_result result = GLBK_OK;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_map_check(ctx, __func__, map);
    if (result != GLBK_OK) return result;
    if (!texels) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "texels", "is NULL");
    memory = glbk_rsm__memory(ctx);
    count = (size_t)map->side * map->side;
    layer = (unsigned char *)glbk_rsm__alloc_array(&memory, count, 64);
    if (!layer) return GLBK_ERR_ALLOC;
    box.width = box.height = map->side;
    for (i = 0; i < 3 * map->face_count && result == GLBK_OK; i++) {
        if (i % 3 == 0) memcpy(layer + 16 * count, texels + count * (i / 3), 48 * count);
        glbk__rsm_copy_layer(layer + 16 * count, layer, count, i % 3, 0);
        box.layer = i;
        result = glbk_texture_update(ctx, &map->texels, &box, layer);
    }
    glbk_rsm__free(&memory, layer);
    map->summed = 0;
    return result;
}

GLBK_DEF glbk_result glbk_rsm_map_read(glbk_context *ctx, const glbk_rsm_map *map, uint32_t face,
                                         rsm_texel *texels)
{
    glbk_rsm__allocator memory;
    unsigned char *layer;
    size_t count;
    uint32_t k;
    glbk_result result = GLBK_OK;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_map_check(ctx, __func__, map);
    if (result != GLBK_OK) return result;
    if (!texels) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "texels", "is NULL");
    if (face >= map->face_count)
        return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, __func__, "face", face, 0, map->face_count - 1.0);
    memory = glbk_rsm__memory(ctx);
    count = (size_t)map->side * map->side;
    layer = (unsigned char *)glbk_rsm__alloc_array(&memory, count, 16);
    if (!layer) return GLBK_ERR_ALLOC;
    for (k = 0; k < 3 && result == GLBK_OK; k++) {
        result = glbk_target_read(ctx, &map->face_targets[face], k, 0, 0, map->side, map->side, layer);
        if (result == GLBK_OK) glbk__rsm_copy_layer((unsigned char *)(void *)texels, layer, count, k, 1);
    }
    glbk_rsm__free(&memory, layer);
    return result;
}

GLBK_DEF void glbk_rsm_map_free(glbk_context *ctx, glbk_rsm_map *map)
{
    uint32_t i, f;
    if (!map) return;
    for (f = 0; f < 6; f++) {
        glbk_target_free(ctx, &map->face_targets[f]);
        for (i = 0; i < 2; i++) {
            glbk_target_free(ctx, &map->sum_targets[i][f]);
            glbk_target_free(ctx, &map->row_targets[i][f]);
        }
    }
    for (i = 0; i < 2; i++) {
        glbk_texture_free(ctx, &map->sums[i]);
        glbk_texture_free(ctx, &map->rows[i]);
    }
    glbk_target_free(ctx, &map->stats_target);
    glbk_texture_free(ctx, &map->stats);
    glbk_texture_free(ctx, &map->texels);
    glbk_texture_free(ctx, &map->depth);
    glbk_buffer_free(ctx, &map->buffer);
    memset(map, 0, sizeof *map);
}

/* ==== src/gl_rsm/renderer.h ==== */

/* ---- rsm: the renderer: pictures, programs and tables that calls of a frame use ---- */

/* Makes pictures of colours, each with its framebuffer. */
static glbk_result glbk__rsm_pictures(glbk_context *ctx, uint32_t count, uint32_t width, uint32_t height,
                                      glbk_texture *textures, glbk_target *targets)
{
    glbk_result result = GLBK_OK;
    uint32_t i;
    for (i = 0; i < count && result == GLBK_OK; i++) {
        result = glbk__rsm_image(ctx, GLBK_FORMAT_COLOR, width, height, 0, &textures[i]);
        if (result == GLBK_OK) result = glbk__rsm_target(ctx, &textures[i], 0, 1, NULL, &targets[i]);
    }
    return result;
}

enum { GLBK__RSM_LISTS = 13 };     /* lists of nodes and of pending pixels for six grids, and one more */

/* Makes the lists of interpolation by compute. */
static glbk_result glbk__rsm_lists(glbk_context *ctx, glbk_rsm_renderer *r)
{
    size_t pixels = (size_t)r->width * r->height, nodes = (size_t)(r->width / 2 + 2) * (r->height / 2 + 2);
    glbk_result result = glbk_buffer_create(ctx, 4 * pixels, NULL, &r->pending[0]);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, 4 * pixels, NULL, &r->pending[1]);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, 4 * nodes, NULL, &r->wanted);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, nodes / 8 + 4, NULL, &r->marks);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, 16 * GLBK__RSM_LISTS, NULL, &r->counts);
    return result;
}

/* Makes history i: the light of each pixel in a frame, with the place and normal that were seen there. */
static glbk_result glbk__rsm_history(glbk_context *ctx, glbk_rsm_renderer *r, uint32_t i)
{
    glbk_target_desc d;
    glbk_result result = glbk__rsm_image(ctx, GLBK_FORMAT_COLOR, r->width, r->height, 0, &r->history[i]);
    if (result == GLBK_OK)
        result = glbk__rsm_image(ctx, GLBK_FORMAT_RGBA32UI, r->width, r->height, 2, &r->kept[i]);
    if (result != GLBK_OK) return result;
    memset(&d, 0, sizeof d);
    d.color[0] = &r->history[i];
    d.color[1] = d.color[2] = &r->kept[i];
    d.layer[2] = 1;
    return glbk_target_create(ctx, &d, &r->history_targets[i]);
}

/* Makes what a renderer has of its size, images and lists, and nothing is in them. */
static glbk_result glbk__rsm_renderer_images(glbk_context *ctx, glbk_rsm_renderer *r, int interpolate,
                                             int denoise)
{
    uint32_t w = r->width, h = r->height, i;
    glbk_result result = glbk__rsm_pictures(ctx, 3, w, h, r->sums, r->targets);
    r->direct = r->bounce = GLBK__RSM_NONE;
    r->remembers = 0;
    r->has_before = r->filtered = 0;
    if (result == GLBK_OK && interpolate)
        result = glbk__rsm_pictures(ctx, r->compute ? 1 : 3, w / 2 + 2, h / 2 + 2, r->grids, r->grid_targets);
    if (result == GLBK_OK && interpolate && r->compute) result = glbk__rsm_lists(ctx, r);
    for (i = 0; i < 2 && denoise && result == GLBK_OK; i++) result = glbk__rsm_history(ctx, r, i);
    return result;
}

GLBK_DEF glbk_result glbk_rsm_renderer_create(glbk_context *ctx, const glbk_rsm_renderer_desc *d,
                                              glbk_rsm_renderer *out)
{
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!out) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "out", "is NULL");
    memset(out, 0, sizeof *out);
    if (!d) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "desc", "is NULL");
    result = glbk__require_side(ctx, __func__, "desc.width", d->width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "desc.height", d->height);
    if (result != GLBK_OK) return result;
    if (d->lights_per_pass > GLBK__RSM_LIST / 2)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, __func__, "desc.lights_per_pass", d->lights_per_pass, 0,
                                  GLBK__RSM_LIST / 2);
    result = glbk__take_attributes(ctx, __func__, &d->attributes, &out->attributes);
    if (result != GLBK_OK) {
        memset(out, 0, sizeof *out);
        return result;
    }
    out->width = d->width;
    out->height = d->height;
    out->lights_per_pass = d->lights_per_pass ? d->lights_per_pass : 4096;
    out->compute = ctx->compute && (!d->interpolate || 4 * (size_t)d->width * d->height <= ctx->max_storage);
    result = glbk__rsm_image(ctx, GLBK_FORMAT_RGBA32UI, 1024, GLBK__RSM_LIST / 1024, 4, &out->lights);
    if (result == GLBK_OK) result = glbk__rsm_target(ctx, &out->lights, 0, 4, NULL, &out->lights_target);
    if (result == GLBK_OK) result = glbk__rsm_renderer_images(ctx, out, d->interpolate, d->denoise);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof out->values, NULL, &out->frame);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof out->drawn, NULL, &out->object);
    if (result == GLBK_OK)
        result = glbk_buffer_create(ctx, sizeof(glbk_rsm_imported), NULL, &out->imported);
    if (result != GLBK_OK) glbk_rsm_renderer_free(ctx, out);
    return result;
}

static void glbk__rsm_free_images(glbk_context *ctx, glbk_rsm_renderer *r)
{
    uint32_t i;
    for (i = 0; i < 3; i++) {
        glbk_target_free(ctx, &r->targets[i]);
        glbk_target_free(ctx, &r->grid_targets[i]);
        glbk_texture_free(ctx, &r->sums[i]);
        glbk_texture_free(ctx, &r->grids[i]);
    }
    for (i = 0; i < 2; i++) {
        glbk_target_free(ctx, &r->history_targets[i]);
        glbk_texture_free(ctx, &r->kept[i]);
        glbk_texture_free(ctx, &r->history[i]);
        glbk_buffer_free(ctx, &r->pending[i]);
    }
    glbk_buffer_free(ctx, &r->wanted);
    glbk_buffer_free(ctx, &r->marks);
    glbk_buffer_free(ctx, &r->counts);
}

GLBK_DEF glbk_result glbk_rsm_renderer_resize(glbk_context *ctx, glbk_rsm_renderer *r, uint32_t width,
                                              uint32_t height)
{
    const int interpolate = r && r->grids[0].name, denoise = r && r->history[0].name;
    const double bytes = 4.0 * width * height;
    glbk_result result;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_renderer_check(ctx, __func__, r);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "width", width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "height", height);
    if (result != GLBK_OK) return result;
    if (interpolate && r->compute && bytes > (double)ctx->max_storage)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, __func__, "4 width height", bytes, 4,
                                  (double)ctx->max_storage);
    glbk__rsm_free_images(ctx, r);
    r->width = width;
    r->height = height;
    result = glbk__rsm_renderer_images(ctx, r, interpolate, denoise);
    if (result != GLBK_OK) glbk_rsm_renderer_free(ctx, r);
    return result;
}

GLBK_DEF void glbk_rsm_renderer_free(glbk_context *ctx, glbk_rsm_renderer *r)
{
    uint32_t i;
    if (!r) return;
    for (i = 0; i < GLBK_RSM_PROGRAM_COUNT; i++) glbk_program_free(ctx, &r->programs[i]);
    glbk__rsm_free_images(ctx, r);
    glbk_target_free(ctx, &r->lights_target);
    glbk_texture_free(ctx, &r->lights);
    glbk_texture_free(ctx, &r->pattern);
    glbk_texture_free(ctx, &r->noise);
    glbk_texture_free(ctx, &r->materials);
    glbk_buffer_free(ctx, &r->frame);
    glbk_buffer_free(ctx, &r->object);
    glbk_buffer_free(ctx, &r->imported);
    memset(r, 0, sizeof *r);
}

/* Makes a table, with rows of `width` texels, from count items of n floats. */
static glbk_result glbk__rsm_table(glbk_context *ctx, const float *from, uint32_t count, uint32_t n,
                                   uint32_t width, glbk_texture *out)
{
    glbk_rsm__allocator memory = glbk_rsm__memory(ctx);
    uint32_t rows = (count + width - 1) / width, i;
    glbk_texture_desc d;
    glbk_result result;
    float *texels = (float *)glbk_rsm__alloc_array(&memory, (size_t)width * rows, 16);
    if (!texels) return GLBK_ERR_ALLOC;
    memset(texels, 0, (size_t)width * rows * 16);
    for (i = 0; i < count; i++) memcpy(texels + 4 * (size_t)i, from + n * (size_t)i, n * sizeof *from);
    memset(&d, 0, sizeof d);
    d.format = GLBK_FORMAT_RGBA32F;
    d.width = width;
    d.height = rows;
    d.data = texels;
    result = glbk_texture_create(ctx, &d, out);
    glbk_rsm__free(&memory, texels);
    return result;
}

/* Keeps the desc and the counts that glbk__rsm_tables_check compares. */
static void glbk__rsm_remember_tables(glbk_rsm_renderer *r, const rsm_gather_desc *d)
{
    r->tables = *d;
    r->tables.noise = NULL;
    r->tables.materials = NULL;
    r->point_count = glbk_rsm_point_count(d);
    r->noise_side = d->noise ? d->noise_side : 0;
    r->material_count = d->material_count;
}

GLBK_DEF glbk_result glbk_rsm_tables_upload(glbk_context *ctx, glbk_rsm_renderer *r,
                                            const rsm_gather_desc *desc, const float *points)
{
    rsm_gather_desc d;
    glbk_result result;
    uint32_t count;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_renderer_check(ctx, __func__, r);
    if (result == GLBK_OK) result = glbk__rsm_gather_check(ctx, __func__, desc, &d);
    if (result == GLBK_OK) result = glbk__rsm_values_check(ctx, &d);
    if (result != GLBK_OK) return result;
    count = glbk_rsm_point_count(&d);
    if (count && !points)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "points",
                            "is NULL, and the pattern needs some");
    if (!count && points)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "points",
                            "is not NULL, and the pattern needs none");
    glbk_texture_free(ctx, &r->pattern);
    glbk_texture_free(ctx, &r->noise);
    glbk_texture_free(ctx, &r->materials);
    memset(&r->tables, 0, sizeof r->tables);
    r->point_count = r->noise_side = r->material_count = 0;
    if (count) result = glbk__rsm_table(ctx, points, count, 3, GLBK__RSM_TABLE, &r->pattern);
    if (result == GLBK_OK && d.noise)
        result = glbk__rsm_table(ctx, d.noise, d.noise_side * d.noise_side, 1, d.noise_side, &r->noise);
    if (result == GLBK_OK && d.material_count)
        result = glbk__rsm_table(ctx, d.materials->specular, d.material_count, 4, GLBK__RSM_TABLE,
                                 &r->materials);
    if (result == GLBK_OK) glbk__rsm_remember_tables(r, &d);
    return result;
}

/* Compiles a program, unless that was done before. */
static glbk_result glbk__rsm_program(glbk_context *ctx, glbk_rsm_renderer *r, int which)
{
    const char *const *names = glbk__rsm_programs[which];
    const int blind = which < GLBK__RSM_DIRECT || which == GLBK__RSM_DO_SCAN ||
                      which == GLBK__RSM_DO_SCAN_ROWS;
    if (r->programs[which].name) return GLBK_OK;
    if (which == GLBK__RSM_FILL)
        return glbk__drawing_program(ctx, glbk_rsm_part(), names[0], &r->attributes, "", &r->programs[which]);
    if (blind) return glbk__program_create(ctx, glbk_rsm_part(), names[0], names[1], &r->programs[which]);
    return glbk__gbuffer_program(ctx, glbk_rsm_part(), names[0], names[1], &r->programs[which]);
}

/* Compiles a program and binds r->values as its block. A dispatch then only needs textures, images and
   lists. */
static glbk_result glbk__rsm_ready(glbk_context *ctx, glbk_rsm_renderer *r, int which)
{
    glbk_result result = glbk__rsm_program(ctx, r, which);
    return result == GLBK_OK ? glbk__put_block(ctx, GLBK_SLOT_glbk_rsm_frame, &r->frame, &r->values) : result;
}

/* Begins a pass over width x height pixels of a target. Textures are bound after this call. */
static glbk_result glbk__rsm_begin(glbk_context *ctx, glbk_rsm_renderer *r, int which,
                                   const glbk_target *target, uint32_t width, uint32_t height)
{
    glbk_pass pass;
    glbk_result result = glbk__rsm_ready(ctx, r, which);
    if (result != GLBK_OK) return result;
    memset(&pass, 0, sizeof pass);
    pass.target = target;
    pass.viewport[2] = (int32_t)width;
    pass.viewport[3] = (int32_t)height;
    return glbk_begin(ctx, &pass, &r->programs[which]);
}

/* Binds the block and the textures of a map. */
static void glbk__rsm_bind_map(glbk_context *ctx, const glbk_rsm_map *map, const glbk_offset *offset)
{
    const glbk_offset at = glbk__offset(offset);
    glbk_bind_block(ctx, at.block + GLBK_SLOT_glbk_rsm_light, &map->buffer);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_rsm_texels, &map->texels);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_rsm_sums, &map->sums[map->sums_at]);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_rsm_rows, &map->rows[map->rows_at]);
}

GLBK_DEF void glbk_rsm_bind(glbk_context *ctx, const glbk_rsm_renderer *r, const glbk_rsm_map *map,
                            const glbk_offset *offset)
{
    const glbk_offset at = glbk__offset(offset);
    if (!ctx) return;
    if (map) glbk__rsm_bind_map(ctx, map, offset);
    if (!r) return;
    glbk_bind_block(ctx, at.block + GLBK_SLOT_glbk_rsm_frame, &r->frame);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_rsm_lights, &r->lights);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_rsm_pattern, &r->pattern);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_rsm_noise, &r->noise);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_rsm_materials, &r->materials);
}

/* Binds all that several programs of the library read. Pictures that one of them alone reads come after
   that. */
static void glbk__rsm_bind_all(glbk_context *ctx, const glbk_rsm_renderer *r, const glbk_gbuffer *gbuffer,
                               const glbk_rsm_map *map)
{
    glbk_rsm_bind(ctx, r, map, NULL);
    (void)glbk_gbuffer_bind(ctx, gbuffer, NULL);    /* The callers have checked it. */
}

/* ==== src/gl_rsm/drawing.h ==== */

/* ---- rsm: drawing maps ---- */

/* Sets the block of a surface. A map then has the albedo that lib/gbuffer.glsl reads after
   glbk_gbuffer_object. */
static void glbk__rsm_set_surface(glbk_rsm_drawn *drawn, const glbk_surface *s)
{
    const lsamp_material *m = &s->material;
    const float share = m->kind == LSAMP_MATERIAL_METAL_ROUGH ? 1.0f - m->metallic : 1.0f;
    int i, zero = 1;
    for (i = 0; i < 16; i++) zero = zero && !(fabsf(s->transform[i]) > 0.0f);
    memcpy(drawn->transform, s->transform, sizeof drawn->transform);
    if (zero) drawn->transform[0] = drawn->transform[5] = drawn->transform[10] = drawn->transform[15] = 1.0f;
    for (i = 0; i < 3; i++) drawn->albedo[i] = m->diffuse[i] * share;
    drawn->alpha_cutoff = s->alpha_cutoff / (s->alpha > 0.0f ? s->alpha : 1.0f);
}

GLBK_DEF glbk_result glbk_rsm_object(glbk_context *ctx, glbk_rsm_renderer *r, const glbk_surface *s,
                                     uint32_t material)
{
    glbk_result result;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_renderer_check(ctx, __func__, r);
    if (result != GLBK_OK) return result;
    if (!s) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "surface", "is NULL");
    if (!r->drawing)
        return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "the call", "comes from no glbk_rsm_draw_fn");
    glbk__rsm_set_surface(&r->drawn, s);
    r->drawn.material = material;
    r->drawn.has_map = s->color_map != NULL;
    result = glbk__put_block(ctx, GLBK_SLOT_glbk_rsm_drawn, &r->object, &r->drawn);
    if (result != GLBK_OK) {
        if (r->failed == GLBK_OK) r->failed = result;
        return result;
    }
    if (s->color_map) glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_albedo_map, s->color_map);
    return GLBK_OK;
}

/* Clears a face and lets the user's function draw into it. */
static glbk_result glbk__rsm_fill(glbk_context *ctx, glbk_rsm_renderer *r, const glbk_target *target,
                                  const glbk_rsm_map *map, glbk_rsm_draw_fn draw_fn, void *user)
{
    static const uint32_t empty[4] = { 0, 0, 0, 0 }, place[4] = { 0, 0, 0, GLBK__RSM_FAR_BITS };
    glbk_pass pass;
    glbk_result result = glbk__rsm_program(ctx, r, GLBK__RSM_FILL);
    if (result != GLBK_OK) return result;
    memset(&pass, 0, sizeof pass);
    pass.target = target;
    pass.depth = GLBK_DEPTH_LESS;
    result = glbk_begin(ctx, &pass, &r->programs[GLBK__RSM_FILL]);
    if (result != GLBK_OK) return result;
    ctx->gl.ClearBufferuiv(GLBK_GL_COLOR, 0, place);
    ctx->gl.ClearBufferuiv(GLBK_GL_COLOR, 1, empty);
    ctx->gl.ClearBufferuiv(GLBK_GL_COLOR, 2, empty);
    glbk_clear_depth(ctx, 1);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_rsm_light, &map->buffer);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_albedo_map, NULL);        /* Objects bind theirs. */
    r->drawing = 1;
    r->failed = GLBK_OK;
    draw_fn(user, ctx, r);
    r->drawing = 0;
    return r->failed != GLBK_OK ? r->failed : ctx->lost ? GLBK_ERR_LOST : glbk__leave_frame(ctx);
}

GLBK_DEF glbk_result glbk_rsm_map_draw(glbk_context *ctx, glbk_rsm_renderer *r, glbk_rsm_map *map,
                                       glbk_rsm_draw_fn draw_fn, void *user)
{
    glbk_result result;
    uint32_t face;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_renderer_check(ctx, __func__, r);
    if (result == GLBK_OK) result = glbk__rsm_map_check(ctx, __func__, map);
    if (result != GLBK_OK) return result;
    if (!draw_fn) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "draw_fn", "is NULL");
    memset(&r->drawn, 0, sizeof r->drawn);
    if (map->light.kind == RSM_LIGHT_SUN)
        glbk__rsm_set4(r->drawn.eye, glbk_rsm__v3_scale(glbk_rsm__v3_load(map->block.axis), -1), 0);
    else glbk__rsm_set4(r->drawn.eye, glbk_rsm__v3_load(map->light.position), 1);
    r->drawn.near_depth = map->light.near_depth;
    r->drawn.depth_scale = 1.0f / (map->light.far_depth - map->light.near_depth);
    map->summed = 0;
    for (face = 0; face < map->face_count && result == GLBK_OK; face++) {
        glbk__rsm_face_matrix(map, face, r->drawn.clip);
        r->drawn.face = face;
        result = glbk__rsm_fill(ctx, r, &map->face_targets[face], map, draw_fn, user);
    }
    return result;
}

/* ==== src/gl_rsm/importing.h ==== */

/* ---- rsm: maps from textures of the user's own ---- */

/* Bits of the block's `given`, as rsm_import.frag has them. */
enum {
    GLBK__RSM_HAS_DEPTH = 1, GLBK__RSM_HAS_PLACES = 2, GLBK__RSM_HAS_COLORS = 4, GLBK__RSM_HAS_MATERIALS = 8,
    GLBK__RSM_IS_REVERSED = 16, GLBK__RSM_IS_FLUX = 32
};

enum { GLBK__RSM_LAYERS = 5 };      /* textures of an import */

/* Lists the textures of an import, in the order of their slots. */
static void glbk__rsm_import_layers(const glbk_rsm_import *d, const glbk_rsm_layer *layers[GLBK__RSM_LAYERS])
{
    layers[0] = &d->depth;
    layers[1] = &d->positions;
    layers[2] = &d->normals;
    layers[3] = &d->colors;
    layers[4] = &d->materials;
}

/* Returns of which kind a texture is: 0 2D, 1 an array, 2 a cube, as KIND of rsm_import.frag. */
static int glbk__rsm_import_kind(const glbk_texture *t)
{
    if (t->gl_target == GLBK_GL_TEXTURE_CUBE_MAP) return 2;
    return t->layers ? 1 : 0;
}

/* Checks that a texture of an import has the face that is imported. */
static glbk_result glbk__rsm_import_size_check(const glbk_context *ctx, const glbk_rsm_map *map,
                                               const glbk_rsm_import *d, const char *name,
                                               const glbk_texture *t)
{
    static const char function[] = "glbk_rsm_map_import";
    const glbk_result bad = GLBK_ERR_MISMATCH;
    if (glbk__rsm_import_kind(t) == 2) {
        if (t->width == map->side && t->height == map->side) return GLBK_OK;
        return glbk__refuse(ctx, bad, function, name, "is a cube that has not the side of the map");
    }
    if (t->width < map->side || t->width - map->side < d->left)
        return glbk__refuse(ctx, bad, function, name, "is not as wide as import.left and the map's side");
    if (t->height < map->side || t->height - map->side < d->bottom)
        return glbk__refuse(ctx, bad, function, name, "is not as high as import.bottom and the map's side");
    return GLBK_OK;
}

/* Checks the textures of an import, and finds their kind. */
static glbk_result glbk__rsm_import_textures_check(const glbk_context *ctx, const glbk_rsm_map *map,
                                                   const glbk_rsm_import *d, int *kind)
{
    static const char function[] = "glbk_rsm_map_import";
    static const char *const names[GLBK__RSM_LAYERS] = { "import.depth", "import.positions", "import.normals",
                                                         "import.colors", "import.materials" };
    const glbk_rsm_layer *layers[GLBK__RSM_LAYERS];
    const glbk_result bad = GLBK_ERR_DESC;
    int i;
    glbk__rsm_import_layers(d, layers);
    *kind = d->normals.texture ? glbk__rsm_import_kind(d->normals.texture) : 0;
    for (i = 0; i < GLBK__RSM_LAYERS; i++) {
        const glbk_texture *t = layers[i]->texture;
        glbk_result result;
        if (!t) continue;
        if (!t->name) return glbk__refuse(ctx, bad, function, names[i], "has no name of GL");
        if (glbk__rsm_import_kind(t) != *kind)
            return glbk__refuse(ctx, bad, function, names[i],
                                "and import.normals are not of one kind: 2D, arrays or cubes");
        if (*kind == 2 && map->light.kind == RSM_LIGHT_SUN)
            return glbk__refuse(ctx, bad, function, names[i], "is a cube, and the light is a sun");
        if (layers[i]->layer >= (*kind == 1 ? t->layers : 1u))
            return glbk__refuse_element_value(ctx, bad, function, names[i], GLBK__NO_INDEX, ".layer",
                                              layers[i]->layer, "below the layers of the texture");
        result = glbk__rsm_import_size_check(ctx, map, d, names[i], t);
        if (result != GLBK_OK) return result;
    }
    return GLBK_OK;
}

/* Checks that an import can be done, and finds the kind of its textures. */
static glbk_result glbk__rsm_import_check(const glbk_context *ctx, const glbk_rsm_map *map,
                                          const glbk_rsm_import *d, int *kind)
{
    static const char function[] = "glbk_rsm_map_import";
    const glbk__rsm_range fields[] = {
        { "import.clip_depth", (double)d->clip_depth, 0, GLBK_CLIP_DEPTH_COUNT - 1 },
        { "import.normal_packing", (double)d->normal_packing, 0, GLBK_NORMAL_PACKING_COUNT - 1 },
        { "import.color_kind", (double)d->color_kind, 0, GLBK_RSM_COLOR_COUNT - 1 },
        { "import.color[0]", (double)d->color[0], 0, 1e12 },
        { "import.color[1]", (double)d->color[1], 0, 1e12 },
        { "import.color[2]", (double)d->color[2], 0, 1e12 }
    };
    glbk_result result;
    if (!d->normals.texture) return glbk__refuse(ctx, GLBK_ERR_DESC, function, "import.normals", "is NULL");
    if (!d->depth.texture && !d->positions.texture)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, "import.depth",
                            "and import.positions are NULL; one is needed");
    result = glbk__rsm_in_range(ctx, function, fields, sizeof fields / sizeof fields[0]);
    return result == GLBK_OK ? glbk__rsm_import_textures_check(ctx, map, d, kind) : result;
}

/* Returns what there is, as bits. */
static uint32_t glbk__rsm_import_given(const glbk_rsm_import *d)
{
    uint32_t bits = 0;
    if (d->depth.texture) bits |= GLBK__RSM_HAS_DEPTH;
    if (d->positions.texture) bits |= GLBK__RSM_HAS_PLACES;
    if (d->colors.texture) bits |= GLBK__RSM_HAS_COLORS;
    if (d->materials.texture) bits |= GLBK__RSM_HAS_MATERIALS;
    if (d->clip_depth == GLBK_CLIP_DEPTH_REVERSED) bits |= GLBK__RSM_IS_REVERSED;
    if (d->color_kind == GLBK_RSM_COLOR_FLUX) bits |= GLBK__RSM_IS_FLUX;
    return bits;
}

/* Fills the block of an import. */
static void glbk__rsm_fill_import(const glbk_rsm_map *map, uint32_t face, const glbk_rsm_import *d,
                                  glbk_rsm_imported *out)
{
    int i, any = 0;
    memset(out, 0, sizeof *out);
    for (i = 0; i < 16; i++) any = any || fabsf(d->to_world[i]) > 0.0f;
    memcpy(out->to_world, d->to_world, sizeof d->to_world);
    for (i = 0; i < 16 && !any; i += 5) out->to_world[i] = 1.0f;
    for (i = 0, any = 0; i < 3; i++) any = any || d->color[i] > 0.0f;
    for (i = 0; i < 3; i++) out->color[i] = any ? d->color[i] : 1.0f;
    out->near_depth = map->light.near_depth;
    out->far_depth = map->light.far_depth;
    out->face = face;
    out->given = glbk__rsm_import_given(d);
    out->normal_packing = (uint32_t)d->normal_packing;
    out->material = d->material;
    out->left = d->left;
    out->bottom = d->bottom;
    out->depth_layer = d->depth.layer;
    out->place_layer = d->positions.layer;
    out->normal_layer = d->normals.layer;
    out->color_layer = d->colors.layer;
    out->material_layer = d->materials.layer;
}

/* Binds the textures of an import, whose glbk_texture need not have gl_target; bound == 0: takes cubes away
   again, since glbk_state_restore knows nothing of such bindings. */
static void glbk__rsm_bind_import(glbk_context *ctx, const glbk_rsm_import *d, int kind, int bound)
{
    static const uint32_t targets[3] = { GLBK_GL_TEXTURE_2D, GLBK_GL_TEXTURE_2D_ARRAY,
                                         GLBK_GL_TEXTURE_CUBE_MAP };
    static const uint32_t slots[GLBK__RSM_LAYERS] = { GLBK_SLOT_glbk_rsm_depth_in,
                                                      GLBK_SLOT_glbk_rsm_place_in,
                                                      GLBK_SLOT_glbk_rsm_normal_in,
                                                      GLBK_SLOT_glbk_rsm_color_in,
                                                      GLBK_SLOT_glbk_rsm_material_in };
    const glbk_rsm_layer *layers[GLBK__RSM_LAYERS];
    int i;
    glbk__rsm_import_layers(d, layers);
    for (i = 0; i < GLBK__RSM_LAYERS; i++) {
        glbk_texture t;
        memset(&t, 0, sizeof t);
        if (bound && layers[i]->texture) t = *layers[i]->texture;
        t.gl_target = targets[kind];
        glbk_bind_texture(ctx, slots[i], &t);
        if (!bound) ctx->gl.BindTexture(GLBK_GL_TEXTURE_CUBE_MAP, 0);
    }
}

GLBK_DEF glbk_result glbk_rsm_map_import(glbk_context *ctx, glbk_rsm_renderer *r, glbk_rsm_map *map,
                                         uint32_t face, const glbk_rsm_import *import)
{
    glbk_rsm_imported block;
    glbk_pass pass;
    glbk_result result;
    int kind = 0, which;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_renderer_check(ctx, __func__, r);
    if (result == GLBK_OK) result = glbk__rsm_map_check(ctx, __func__, map);
    if (result != GLBK_OK) return result;
    if (face >= map->face_count)
        return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, __func__, "face", face, 0, map->face_count - 1.0);
    if (!import) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "import", "is NULL");
    result = glbk__rsm_import_check(ctx, map, import, &kind);
    if (result != GLBK_OK) return result;
    which = GLBK__RSM_IMPORT + kind;
    glbk__rsm_fill_import(map, face, import, &block);
    result = glbk__rsm_program(ctx, r, which);
    if (result == GLBK_OK)
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_rsm_imported, &r->imported, &block);
    if (result != GLBK_OK) return result;
    memset(&pass, 0, sizeof pass);
    pass.target = &map->face_targets[face];
    result = glbk_begin(ctx, &pass, &r->programs[which]);
    if (result != GLBK_OK) return result;
    map->summed = 0;
    glbk_bind_block(ctx, GLBK_SLOT_glbk_rsm_light, &map->buffer);
    glbk__rsm_bind_import(ctx, import, kind, 1);
    glbk_draw_screen(ctx);
    if (kind == 2) glbk__rsm_bind_import(ctx, import, kind, 0);
    return ctx->lost ? GLBK_ERR_LOST : glbk__leave_frame(ctx);
}

/* ==== src/gl_rsm/stats.h ==== */

/* ---- rsm: statistics of a map ---- */

/* Makes the image of statistics unless there is one: a pixel for each row of texels and each of three sums,
   as rsm_stats.frag says. */
static glbk_result glbk__rsm_stats_image(glbk_context *ctx, glbk_rsm_map *map)
{
    glbk_result result;
    if (map->stats_target.name) return GLBK_OK;
    glbk_texture_free(ctx, &map->stats);
    result = glbk__rsm_image(ctx, GLBK_FORMAT_RGBA32UI, map->side, 3 * map->face_count, 0, &map->stats);
    if (result == GLBK_OK) result = glbk__rsm_target(ctx, &map->stats, 0, 1, NULL, &map->stats_target);
    if (result != GLBK_OK) glbk_texture_free(ctx, &map->stats);
    return result;
}

/* Draws the statistics of a map. */
static glbk_result glbk__rsm_stats_draw(glbk_context *ctx, glbk_rsm_renderer *r, glbk_rsm_map *map)
{
    glbk_pass pass;
    glbk_result result = glbk__rsm_program(ctx, r, GLBK__RSM_STATS);
    if (result == GLBK_OK) result = glbk__rsm_stats_image(ctx, map);
    if (result != GLBK_OK) return result;
    memset(&pass, 0, sizeof pass);
    pass.target = &map->stats_target;
    result = glbk_begin(ctx, &pass, &r->programs[GLBK__RSM_STATS]);
    if (result != GLBK_OK) return result;
    glbk__rsm_bind_map(ctx, map, NULL);
    glbk_draw_screen(ctx);
    return ctx->lost ? GLBK_ERR_LOST : glbk__leave_frame(ctx);
}

/* Reads the image of statistics, and adds up its rows in their order. */
static glbk_result glbk__rsm_stats_read(glbk_context *ctx, const glbk_rsm_map *map, rsm_stats *out)
{
    const uint32_t height = 3 * map->face_count;
    glbk_rsm__allocator memory = glbk_rsm__memory(ctx);
    uint32_t *words = (uint32_t *)glbk_rsm__alloc_array(&memory, (size_t)map->side * height, 16), x, y, k;
    glbk_result result;
    memset(out, 0, sizeof *out);
    if (!words) return GLBK_ERR_ALLOC;
    result = glbk_target_read(ctx, &map->stats_target, 0, 0, 0, map->side, height, words);
    for (y = 0; y < height && result == GLBK_OK; y++)
        for (x = 0; x < map->side; x++) {
            const uint32_t *from = words + 4 * ((size_t)y * map->side + x);
            float sums[3];
            memcpy(sums, from, sizeof sums);
            if (y % 3 == 0) out->lit_texels += from[0];
            for (k = 0; k < 3 && y % 3 == 1; k++) out->incident[k] += (double)sums[k];
            for (k = 0; k < 3 && y % 3 == 2; k++) out->reflected[k] += (double)sums[k];
        }
    glbk_rsm__free(&memory, words);
    return result;
}

GLBK_DEF glbk_result glbk_rsm_map_stats(glbk_context *ctx, glbk_rsm_renderer *r, glbk_rsm_map *map, int count,
                                        rsm_stats *stats)
{
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_renderer_check(ctx, __func__, r);
    if (result == GLBK_OK) result = glbk__rsm_map_check(ctx, __func__, map);
    if (result != GLBK_OK) return result;
    if (!count && !map->stats_target.name)
        return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "count", "is 0, and nothing was counted yet");
    if (count) result = glbk__rsm_stats_draw(ctx, r, map);
    return result == GLBK_OK && stats ? glbk__rsm_stats_read(ctx, map, stats) : result;
}

/* ==== src/gl_rsm/light.h ==== */

/* ---- rsm: light: direct, gathered and interpolated ---- */

/* Returns which of the three pictures is neither a nor b. */
static uint32_t glbk__rsm_other(uint32_t a, uint32_t b)
{
    uint32_t i = 0;
    while (i == a || i == b) i++;
    return i;
}

GLBK_DEF glbk_result glbk_rsm_direct(glbk_context *ctx, glbk_rsm_renderer *r, const glbk_gbuffer *gbuffer,
                                     const glbk_rsm_map *const *maps, uint32_t count,
                                     const rsm_direct_desc *desc)
{
    uint32_t now = GLBK__RSM_NONE, next, i;
    rsm_direct_desc d;
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_gbuffer_check(ctx, __func__, r, gbuffer);
    if (result == GLBK_OK) result = glbk__rsm_maps_check(ctx, __func__, r, maps, count);
    if (result == GLBK_OK) result = glbk__rsm_direct_check(ctx, desc, &d);
    if (result != GLBK_OK) return result;
    memset(&r->values, 0, sizeof r->values);
    r->values.taps = d.tap_side;
    r->values.bias = d.bias;
    r->values.slope_bias = d.slope_bias;
    r->direct = GLBK__RSM_NONE;
    for (i = 0; i < count; i++) {
        next = glbk__rsm_other(r->bounce, now);
        r->values.adds = i > 0;
        result = glbk__rsm_begin(ctx, r, GLBK__RSM_DIRECT, &r->targets[next], r->width, r->height);
        if (result != GLBK_OK) return result;
        glbk__rsm_bind_all(ctx, r, gbuffer, maps[i]);
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_sum, &r->sums[now < 3 ? now : glbk__rsm_other(next, next)]);
        glbk_draw_screen(ctx);
        now = next;
    }
    r->direct = now;
    return GLBK_OK;
}

/* Does all steps of running sums along x, in all faces of a map: the first step by program `from`, the others
   by the program after that. *at gets the number of the target that holds the sums. */
static glbk_result glbk__rsm_scan(glbk_context *ctx, glbk_rsm_renderer *r, glbk_rsm_map *map, int from,
                                  uint32_t height, glbk_target targets[2][6], int *at)
{
    uint32_t stride, face;
    int next = 0;
    for (stride = 1; stride < map->side; stride *= 8) {
        for (face = 0; face < map->face_count; face++) {
            glbk_result result;
            r->values.face = face;
            r->values.stride = stride;
            result = glbk__rsm_begin(ctx, r, stride == 1 ? from : from + 1, &targets[next][face], map->side,
                                     height);
            if (result != GLBK_OK) return result;
            glbk__rsm_bind_map(ctx, map, NULL);
            if (stride == 1 && from == GLBK__RSM_SCAN) glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_sums, NULL);
            glbk_draw_screen(ctx);
        }
        *at = next;
        next = 1 - next;
    }
    return GLBK_OK;
}

/* Makes running sums by compute, with a group for each row of all faces, then with a group for each face. */
static glbk_result glbk__rsm_do_sum(glbk_context *ctx, glbk_rsm_renderer *r, glbk_rsm_map *map)
{
    int rows;
    map->sums_at = map->rows_at = 0;
    for (rows = 0; rows < 2; rows++) {
        glbk_result result = glbk__rsm_ready(ctx, r, GLBK__RSM_DO_SCAN + rows);
        if (result != GLBK_OK) return result;
        glbk__rsm_bind_map(ctx, map, NULL);
        glbk_bind_image(ctx, GLBK_SLOT_glbk_rsm_running, rows ? &map->rows[0] : &map->sums[0]);
        result = glbk_dispatch(ctx, &r->programs[GLBK__RSM_DO_SCAN + rows], rows ? 1 : map->side,
                               map->face_count, 1);
        if (result != GLBK_OK) return result;
    }
    map->summed = 1;
    return GLBK_OK;
}

/* Makes the running sums of a map, unless the map has them. */
static glbk_result glbk__rsm_sum(glbk_context *ctx, glbk_rsm_renderer *r, glbk_rsm_map *map)
{
    glbk_result result;
    if (map->summed) return GLBK_OK;
    if (r->compute) return glbk__rsm_do_sum(ctx, r, map);
    result = glbk__rsm_scan(ctx, r, map, GLBK__RSM_SCAN, map->side, map->sum_targets, &map->sums_at);
    if (result == GLBK_OK)
        result = glbk__rsm_scan(ctx, r, map, GLBK__RSM_SCAN_ROWS, 1, map->row_targets, &map->rows_at);
    map->summed = result == GLBK_OK;
    return result;
}

typedef struct glbk__rsm_run {      /* a call of glbk_rsm_gather or glbk_rsm_interpolate */
    glbk_context        *ctx;
    glbk_rsm_renderer   *r;
    const glbk_gbuffer  *gbuffer;   /* NULL: only the list is made */
    glbk_rsm_map *const *maps;
    uint32_t             count;     /* number of maps */
    uint32_t             sets;      /* sets of pixels that have lights and points of their own */
    uint32_t             by_flux;   /* lights of a map that are picked by flux */
    uint32_t             about;     /* points of the pattern about the receiver */
    uint32_t             room;      /* lights of a set that the list holds */
    uint32_t             seed;
    int                  mixed;     /* not 0: RSM_PATTERN_MIXED */
    int                  all;       /* not 0: every texel is a light */
    int                  apart;     /* not 0: each map has a list of its own */
    int                  listed;    /* not 0: the list holds all lights */
    int                  begun;     /* not 0: the picture holds light */
    glbk_texture        *pictures;  /* the pictures in which light adds up */
    glbk_target         *targets;   /* of the pictures */
    uint32_t             width;     /* of the pictures */
    uint32_t             height;
    uint32_t             now;       /* the picture that holds the light */
    uint32_t             kept;      /* a picture that must stay */
    const glbk_texture  *states;    /* the state of each pixel while light is interpolated */
    const glbk_texture  *coarse;    /* the grid before */
    const glbk_buffer   *items;     /* compute: the pixels; NULL = all */
} glbk__rsm_run;

/* Picks lights of a map, from number `first` on, into places from .. to - 1 of each set of the list. */
static glbk_result glbk__rsm_pick(glbk__rsm_run *g, const glbk_rsm_map *map, uint32_t lights, uint32_t first,
                                  uint32_t from, uint32_t to)
{
    glbk_rsm_renderer *r = g->r;
    glbk_result result;
    uint32_t last = (g->sets - 1) * r->values.set_room + to, rows = (last + 1023) / 1024;
    r->values.first_light = from;
    r->values.end_light = to;
    r->values.seed = g->seed;
    r->values.light_count = lights;
    r->values.first_run = first;
    result = glbk__rsm_begin(g->ctx, r, g->all ? GLBK__RSM_PICK_ALL : GLBK__RSM_PICK, &r->lights_target, 1024,
                             rows);
    if (result != GLBK_OK) return result;
    glbk__rsm_bind_map(g->ctx, map, NULL);
    glbk_draw_screen(g->ctx);
    return GLBK_OK;
}

/* Runs as many groups as an earlier dispatch has counted: x, y, z of list `list` in r->counts. */
static glbk_result glbk__rsm_dispatch(glbk_context *ctx, const glbk_rsm_renderer *r, glbk_program *program,
                                      uint32_t list)
{
    if (ctx->lost) return GLBK_ERR_LOST;
    glbk_program_use(ctx, program);
    ctx->gl.BindBuffer(GLBK_GL_DISPATCH_INDIRECT_BUFFER, r->counts.name);
    ctx->gl.DispatchComputeIndirect((ptrdiff_t)16 * (ptrdiff_t)list);
    ctx->gl.Barrier(GLBK_GL_ALL_BARRIER_BITS);
    return GLBK_OK;
}

/* Does the work of glbk__rsm_add by compute, in place: on all pixels of the picture, or on those of a
   list. */
static glbk_result glbk__rsm_do_add(glbk__rsm_run *g, const glbk_rsm_map *map)
{
    glbk_rsm_renderer *r = g->r;
    int which = r->values.mode == 1 ? GLBK__RSM_DO_NODES : GLBK__RSM_DO_GATHER;
    glbk_program *program;
    uint32_t side = 8 * r->values.interleave;            /* pixels of a set lie `interleave` apart */
    glbk_result result;
    if (r->values.near_field > 0.0f) which += GLBK__RSM_DO_GATHER_SURFACES - GLBK__RSM_DO_GATHER;
    program = &r->programs[which];
    result = glbk__rsm_ready(g->ctx, r, which);
    if (result != GLBK_OK) return result;
    glbk__rsm_bind_all(g->ctx, r, g->gbuffer, map);
    glbk_bind_image(g->ctx, GLBK_SLOT_glbk_rsm_picture, &r->sums[g->now]);
    g->begun = 1;
    if (!g->items)
        return glbk_dispatch(g->ctx, program, (r->width + side - 1) / side, (r->height + side - 1) / side,
                             g->sets);
    glbk_bind_image(g->ctx, GLBK_SLOT_glbk_rsm_nodes, &r->grids[0]);
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_counts, &r->counts);
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_items, g->items);
    return glbk__rsm_dispatch(g->ctx, r, program, r->values.list_read);
}

/* Adds the first `listed` lights of each set and the points about the receiver to the picture. */
static glbk_result glbk__rsm_add(glbk__rsm_run *g, const glbk_rsm_map *map, uint32_t listed, uint32_t about)
{
    glbk_rsm_renderer *r = g->r;
    uint32_t next = glbk__rsm_other(g->kept, g->now);
    const glbk_texture *spare;
    const float side = (float)map->side, faces = map->face_count == 1 ? 1.0f : 0.5236f;
    glbk_result result;
    r->values.first_light = 0;
    r->values.end_light = listed;
    r->values.adds = (uint32_t)g->begun;
    r->values.point_count = about / g->sets;
    r->values.mixed = g->mixed ? (float)g->about * 0.02764f * faces / (side * side) : 0.0f;
    if (!g->gbuffer) return glbk__put_block(g->ctx, GLBK_SLOT_glbk_rsm_frame, &r->frame, &r->values);
    if (r->compute) return glbk__rsm_do_add(g, map);
    result = glbk__rsm_begin(g->ctx, r,
                             r->values.near_field > 0.0f ? GLBK__RSM_GATHER_SURFACES : GLBK__RSM_GATHER,
                             &g->targets[next], g->width, g->height);
    if (result != GLBK_OK) return result;
    glbk__rsm_bind_all(g->ctx, r, g->gbuffer, map);
    /* Every slot gets something of the right kind: software drivers compile a shader anew for each
       combination. */
    spare = &g->pictures[g->now < 3 ? g->now : glbk__rsm_other(next, next)];
    glbk_bind_texture(g->ctx, GLBK_SLOT_glbk_rsm_sum, spare);
    glbk_bind_texture(g->ctx, GLBK_SLOT_glbk_rsm_states, g->states ? g->states : spare);
    glbk_bind_texture(g->ctx, GLBK_SLOT_glbk_rsm_coarse, g->coarse ? g->coarse : spare);
    glbk_draw_screen(g->ctx);
    g->now = next;
    g->begun = 1;
    return GLBK_OK;
}

/* Adds the light of all maps to the pixels that r->values.mode names. The list takes as many lights as it has
   room for, and is made only once if it holds all of them. */
static glbk_result glbk__rsm_evaluate(glbk__rsm_run *g)
{
    uint32_t m, at = 0, flushed = 0;
    glbk_result result = GLBK_OK;
    g->begun = 0;
    for (m = 0; m < g->count && result == GLBK_OK; m++) {
        const glbk_rsm_map *map = g->maps[m];
        uint32_t lights = g->all ? map->side * map->side * map->face_count : g->by_flux;
        uint32_t left = lights / g->sets + (lights % g->sets != 0), first = 0;
        while (left && result == GLBK_OK) {
            uint32_t take = left < g->room - at ? left : g->room - at;
            if (!g->listed) result = glbk__rsm_pick(g, map, lights, first, at, at + take);
            at += take;
            first += take;
            left -= take;
            if (at < g->room || result != GLBK_OK || (g->about && !left)) continue;
            result = glbk__rsm_add(g, map, at, 0);
            at = 0;
            flushed++;
        }
        if ((g->about || (g->apart && at)) && result == GLBK_OK) {
            result = glbk__rsm_add(g, map, at, g->about);
            at = 0;
            flushed++;
        }
    }
    if (at && result == GLBK_OK) {
        result = glbk__rsm_add(g, g->maps[0], at, 0);
        flushed++;
    }
    g->listed = flushed == 1;
    return result;
}

/* Runs a compute shader of interpolation over all pixels, nodes or pending pixels. list points to the number
   of the list that tells how many groups run; if list is NULL, x by y groups run. */
static glbk_result glbk__rsm_do_lists(glbk__rsm_run *g, int which, uint32_t level, const uint32_t *list,
                                      uint32_t x, uint32_t y)
{
    glbk_rsm_renderer *r = g->r;
    glbk_result result = glbk__rsm_ready(g->ctx, r, which);
    if (result != GLBK_OK) return result;
    glbk__rsm_bind_all(g->ctx, r, g->gbuffer, NULL);
    glbk_bind_texture(g->ctx, GLBK_SLOT_glbk_rsm_coarse, &r->grids[0]);
    glbk_bind_image(g->ctx, GLBK_SLOT_glbk_rsm_picture, &r->sums[g->now]);
    glbk_bind_image(g->ctx, GLBK_SLOT_glbk_rsm_nodes, &r->grids[0]);
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_counts, &r->counts);
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_items, &r->pending[(level + 1) & 1]);
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_left, &r->pending[level & 1]);
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_wanted, &r->wanted);
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_marks, &r->marks);
    return list ? glbk__rsm_dispatch(g->ctx, r, &r->programs[which], *list)
                : glbk_dispatch(g->ctx, &r->programs[which], x, y, 1);
}

/* Begins interpolation by compute: empties the lists, says that no node of r->grids[0] is evaluated, and
   lists the nodes of the first grid. */
static glbk_result glbk__rsm_do_begin(glbk__rsm_run *g, const rsm_interpolation *d)
{
    static const uint32_t empty[4] = { 0, 0, 1, 0 };
    glbk_rsm_renderer *r = g->r;
    uint32_t counts[4 * GLBK__RSM_LISTS], i, fine = d->step, nodes[2];
    for (i = 1; i < d->level_count && fine > 2; i++) fine /= 2;
    for (i = 0; i < GLBK__RSM_LISTS; i++) memcpy(counts + 4 * i, empty, sizeof empty);
    nodes[0] = (r->width - 1 + fine - 1) / fine + 1;
    nodes[1] = (r->height - 1 + fine - 1) / fine + 1;
    r->values.step = d->step;
    r->values.fine_step = fine;
    r->values.list_wanted = 0;
    /* The upload goes through a binding that the pass changes anyway; glbk_buffer_update would ask GL which
       buffer is bound, so as to bind it again. */
    if (g->ctx->lost) return GLBK_ERR_LOST;
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_counts, &r->counts);
    g->ctx->gl.BufferData(GLBK_GL_SHADER_STORAGE_BUFFER, (ptrdiff_t)r->counts.bytes, counts,
                          GLBK_GL_STREAM_DRAW);
    return glbk__rsm_do_lists(g, GLBK__RSM_DO_BEGIN, 0, NULL, (nodes[0] + 7) / 8, (nodes[1] + 7) / 8);
}

/* Does the work of glbk__rsm_grids by compute. List 2 level holds the nodes to evaluate, list 2 level + 1 the
   pixels that stay pending. All grids are in the finest one. The picture gets evaluated and interpolated
   light at once. */
static glbk_result glbk__rsm_do_grids(glbk__rsm_run *g, const rsm_interpolation *d)
{
    glbk_rsm_renderer *r = g->r;
    uint32_t step, level, before = 0;
    glbk_result result;
    g->now = glbk__rsm_other(r->direct, GLBK__RSM_NONE);
    result = glbk__rsm_do_begin(g, d);
    for (step = d->step, level = 0; step > 1 && level < d->level_count && result == GLBK_OK;
         step /= 2, level++) {
        r->values.mode = 1;
        r->values.list_read = 2 * level;
        g->items = &r->wanted;
        result = glbk__rsm_evaluate(g);
        if (result != GLBK_OK) return result;
        r->values.step = step;
        r->values.list_read = before;
        r->values.list_pending = 2 * level + 1;
        r->values.list_wanted = 2 * level + 2;
        r->values.next_step = level + 1 < d->level_count && step > 2 ? step / 2 : 0;
        result = glbk__rsm_do_lists(g, level ? GLBK__RSM_DO_LISTED : GLBK__RSM_DO_INTERPOLATE, level,
                                    level ? &before : NULL, (r->width + 15) / 16, (r->height + 15) / 16);
        before = 2 * level + 1;
    }
    r->values.mode = 2;
    r->values.list_read = before;
    g->items = &r->pending[before >> 1 & 1];
    return result;
}

/* Evaluates grids of half the step each time, and interpolates between their nodes. The caller evaluates the
   pixels that stay pending. The picture ends in r->sums. */
static glbk_result glbk__rsm_grids(glbk__rsm_run *g, const rsm_interpolation *d)
{
    glbk_rsm_renderer *r = g->r;
    uint32_t step = d->step, levels = d->level_count;
    uint32_t picture = GLBK__RSM_NONE, coarse = GLBK__RSM_NONE, next;
    glbk_result result;
    r->values.normal_cosine = d->normal_cosine;
    r->values.plane_slope = d->plane_slope;
    r->values.most_distance = d->distance;
    r->values.contrast = d->contrast;
    r->values.reach = d->light_share;
    if (r->compute) return glbk__rsm_do_grids(g, d);
    for (; step > 1 && levels > 0; step /= 2, levels--) {
        r->values.mode = 1;
        r->values.coarse_step = coarse < 3 ? r->values.step : 0;
        r->values.step = step;
        g->pictures = r->grids;
        g->targets = r->grid_targets;
        g->width = (r->width - 2 + step) / step + 1;
        g->height = (r->height - 2 + step) / step + 1;
        if (r->width == 1) g->width = 1;
        if (r->height == 1) g->height = 1;
        g->kept = coarse;
        g->now = GLBK__RSM_NONE;
        g->states = picture < 3 ? &r->sums[picture] : NULL;
        g->coarse = coarse < 3 ? &r->grids[coarse] : NULL;
        result = glbk__rsm_evaluate(g);
        if (result != GLBK_OK) return result;
        coarse = g->now;
        next = glbk__rsm_other(r->direct, picture);
        r->values.adds = picture < 3;
        result = glbk__rsm_begin(g->ctx, r, GLBK__RSM_INTERPOLATE, &r->targets[next], r->width, r->height);
        if (result != GLBK_OK) return result;
        glbk__rsm_bind_all(g->ctx, r, g->gbuffer, NULL);
        glbk_bind_texture(g->ctx, GLBK_SLOT_glbk_rsm_sum, picture < 3 ? &r->sums[picture] : NULL);
        glbk_bind_texture(g->ctx, GLBK_SLOT_glbk_rsm_coarse, &r->grids[coarse]);
        glbk_draw_screen(g->ctx);
        picture = next;
    }
    r->values.mode = 2;
    g->now = picture;
    return GLBK_OK;
}

/* Sets how many samples of each kind are taken for a checked desc, and how. */
static void glbk__rsm_run_set(glbk__rsm_run *g, const rsm_gather_desc *d)
{
    glbk_rsm_renderer *r = g->r;
    const int flux = d->pattern == RSM_PATTERN_FLUX;
    g->seed = d->seed;
    g->all = d->sample_count == 0;
    g->mixed = d->pattern == RSM_PATTERN_MIXED && d->sample_count > 1;
    g->apart = g->mixed || d->material_count > 0 || (g->all && d->near_field > 0.0f);
    g->about = glbk_rsm_point_count(d);
    if (!g->all && (flux || d->pattern == RSM_PATTERN_MIXED))
        g->by_flux = d->sample_count - (g->mixed ? 3 * d->sample_count / 5 : 0);
    g->sets = d->interleave * d->interleave;
    g->room = GLBK__RSM_LIST / g->sets < r->lights_per_pass ? GLBK__RSM_LIST / g->sets : r->lights_per_pass;
    memset(&r->values, 0, sizeof r->values);
    r->values.interleave = d->interleave;
    r->values.noise_side = d->noise && g->about ? r->noise_side : 0;
    r->values.set_room = g->room;
    r->values.material_count = d->material_count;
    r->values.width = r->width;
    r->values.height = r->height;
    r->values.r_max = g->mixed ? 0.0f : d->r_max;
    r->values.offset = d->offset;
    r->values.clamp_at = d->clamp;
    r->values.near_limit = d->near_limit;
    r->values.set_count = (float)g->sets;
    r->values.picked = g->mixed ? (float)g->by_flux : 0.0f;
    r->values.near_field = g->all || g->about ? d->near_field : 0.0f;
}

/* Gathers light for a checked desc. how is the interpolation with its defaults; if it is NULL, every pixel is
   evaluated. */
static glbk_result glbk__rsm_gather(glbk__rsm_run *g, const rsm_gather_desc *d, const rsm_interpolation *how)
{
    glbk_rsm_renderer *r = g->r;
    glbk_result result = GLBK_OK;
    uint32_t i;

    glbk__rsm_run_set(g, d);
    for (i = 0; i < g->count && (g->by_flux || g->mixed) && result == GLBK_OK; i++)
        result = glbk__rsm_sum(g->ctx, r, g->maps[i]);
    if (result != GLBK_OK) return result;
    r->bounce = g->now = GLBK__RSM_NONE;
    r->filtered = 0;
    if (how) result = glbk__rsm_grids(g, how);
    if (result != GLBK_OK) return result;
    g->pictures = r->sums;
    g->targets = r->targets;
    g->kept = r->direct;
    g->width = r->width;
    g->height = r->height;
    g->states = g->coarse = NULL;
    if (r->compute && !how) g->now = glbk__rsm_other(r->direct, GLBK__RSM_NONE);
    result = glbk__rsm_evaluate(g);
    if (result == GLBK_OK && g->gbuffer) r->bounce = g->now;
    return result;
}

/* Checks the arguments that both calls have, and writes the desc with its defaults. */
static glbk_result glbk__rsm_run_check(glbk__rsm_run *g, const char *function, const rsm_gather_desc *desc,
                                       rsm_gather_desc *out)
{
    glbk_result result;
    if (!g->ctx) return GLBK_ERR_ARGUMENT;
    result = g->gbuffer ? glbk__rsm_gbuffer_check(g->ctx, function, g->r, g->gbuffer) : GLBK_OK;
    if (result == GLBK_OK)
        result = glbk__rsm_maps_check(g->ctx, function, g->r, (const glbk_rsm_map *const *)g->maps, g->count);
    if (result == GLBK_OK) result = glbk__rsm_gather_check(g->ctx, function, desc, out);
    return result == GLBK_OK ? glbk__rsm_tables_check(g->ctx, function, g->r, out) : result;
}

/* Begins a run with the arguments that both calls have. */
static void glbk__rsm_run_make(glbk__rsm_run *g, glbk_context *ctx, glbk_rsm_renderer *r,
                               const glbk_gbuffer *gbuffer, glbk_rsm_map *const *maps, uint32_t count)
{
    memset(g, 0, sizeof *g);
    g->ctx = ctx;
    g->r = r;
    g->gbuffer = gbuffer;
    g->maps = maps;
    g->count = count;
}

GLBK_DEF glbk_result glbk_rsm_gather(glbk_context *ctx, glbk_rsm_renderer *r, const glbk_gbuffer *gbuffer,
                                     glbk_rsm_map *const *maps, uint32_t count, const rsm_gather_desc *desc)
{
    glbk__rsm_run g;
    rsm_gather_desc d;
    glbk_result result;

    glbk__rsm_run_make(&g, ctx, r, gbuffer, maps, count);
    result = glbk__rsm_run_check(&g, __func__, desc, &d);
    return result == GLBK_OK ? glbk__rsm_gather(&g, &d, NULL) : result;
}

GLBK_DEF glbk_result glbk_rsm_interpolate(glbk_context *ctx, glbk_rsm_renderer *r,
                                          const glbk_gbuffer *gbuffer, glbk_rsm_map *const *maps,
                                          uint32_t count, const rsm_gather_desc *desc,
                                          const rsm_interpolation *interpolation)
{
    glbk__rsm_run g;
    rsm_gather_desc d;
    rsm_interpolation how;
    glbk_result result;

    glbk__rsm_run_make(&g, ctx, r, gbuffer, maps, count);
    result = ctx ? glbk__rsm_gbuffer_check(ctx, __func__, r, gbuffer) : GLBK_ERR_ARGUMENT;
    if (result == GLBK_OK) result = glbk__rsm_run_check(&g, __func__, desc, &d);
    if (result == GLBK_OK) result = glbk__rsm_interpolation_check(ctx, interpolation, &how);
    if (result != GLBK_OK) return result;
    if (d.noise)
        return glbk__refuse(ctx, GLBK_ERR_DESC, __func__, "desc.noise",
                            "is not NULL: interpolated light has no noise");
    if (d.interleave != 1)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, __func__, "desc.interleave", d.interleave, "0 or 1");
    if (!r->grids[0].name)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "renderer",
                            "was made without desc.interpolate");
    return glbk__rsm_gather(&g, &d, &how);
}

/* ==== src/gl_rsm/picture.h ==== */

/* ---- rsm: filter and picture ---- */

/* Returns the picture of bounced light, or NULL if there is none. r->bounce counts the sums, then, as 3 and
   4, the histories. */
static const glbk_texture *glbk__rsm_bounced(const glbk_rsm_renderer *r)
{
    return r->bounce < 3 ? &r->sums[r->bounce] : r->bounce < 5 ? &r->history[r->bounce - 3] : NULL;
}

/* Does all passes of the a-trous filter. */
static glbk_result glbk__rsm_smooth(glbk_context *ctx, glbk_rsm_renderer *r, const glbk_gbuffer *gbuffer,
                                    int passes)
{
    uint32_t next;
    int pass;
    for (pass = 0; pass < passes; pass++) {
        glbk_result result;
        uint32_t step = 1u << pass, side = 16 * step;
        next = glbk__rsm_other(r->direct, r->bounce);
        r->values.step = step;
        result = r->compute
                     ? glbk__rsm_ready(ctx, r, GLBK__RSM_DO_SMOOTH)
                     : glbk__rsm_begin(ctx, r, GLBK__RSM_SMOOTH, &r->targets[next], r->width, r->height);
        if (result != GLBK_OK) return result;
        glbk__rsm_bind_all(ctx, r, gbuffer, NULL);
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_sum, glbk__rsm_bounced(r));
        if (r->compute) {
            glbk_bind_image(ctx, GLBK_SLOT_glbk_rsm_picture, &r->sums[next]);
            result = glbk_dispatch(ctx, &r->programs[GLBK__RSM_DO_SMOOTH], (r->width + side - 1) / side,
                                   (r->height + side - 1) / side, step * step);
            if (result != GLBK_OK) return result;
        } else {
            glbk_draw_screen(ctx);
        }
        r->bounce = next;
    }
    return GLBK_OK;
}

/* Checks that there is light which was not filtered yet. */
static glbk_result glbk__rsm_denoise_check(const glbk_context *ctx, const glbk_rsm_renderer *r,
                                           const glbk_gbuffer *gbuffer, const glbk_texture *motion)
{
    static const char function[] = "glbk_rsm_denoise";
    const glbk_result result = glbk__rsm_gbuffer_check(ctx, function, r, gbuffer);
    if (result != GLBK_OK) return result;
    if (!r->history[0].name)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, "renderer", "was made without desc.denoise");
    if (!glbk__rsm_bounced(r))
        return glbk__refuse(ctx, GLBK_ERR_ORDER, function, "bounced light", "was not gathered");
    if (r->filtered)
        return glbk__refuse(ctx, GLBK_ERR_ORDER, function, "bounced light", "was filtered already");
    if (!motion || motion->name) return GLBK_OK;
    return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "motion", "was not created");
}

GLBK_DEF glbk_result glbk_rsm_denoise(glbk_context *ctx, glbk_rsm_renderer *r, const glbk_gbuffer *gbuffer,
                                      const gifilt_frame *frame, const glbk_texture *motion)
{
    uint32_t to;
    gifilt_frame d;
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_denoise_check(ctx, r, gbuffer, motion);
    if (result == GLBK_OK) result = glbk__rsm_frame_check(ctx, frame, &d);
    if (result != GLBK_OK) return result;
    memset(&r->values, 0, sizeof r->values);
    r->values.width = r->width;
    r->values.height = r->height;
    r->values.motion = !r->remembers ? 0u : motion ? 2u : d.world_to_clip && r->has_before ? 1u : 0u;
    r->values.rows_top_first = d.rows == GIFILT_ROWS_TOP_FIRST;
    r->values.history = (float)d.history;
    r->values.normal_cosine = d.normal_cosine;
    r->values.plane_slope = d.plane_slope;
    memcpy(r->drawn.clip, r->before, sizeof r->before);
    result = glbk__put_block(ctx, GLBK_SLOT_glbk_rsm_drawn, &r->object, &r->drawn);
    to = r->remembers == 1 ? 1 : 0;
    if (result == GLBK_OK)
        result = glbk__rsm_begin(ctx, r, GLBK__RSM_RECALL, &r->history_targets[to], r->width, r->height);
    if (result != GLBK_OK) return result;
    glbk__rsm_bind_all(ctx, r, gbuffer, NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_before, &r->kept[1 - to]);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_sum, glbk__rsm_bounced(r));
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_history, &r->history[1 - to]);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_motion, motion);
    glbk_draw_screen(ctx);
    r->bounce = 3 + to;
    r->remembers = 1 + to;
    r->filtered = 1;
    r->has_before = d.world_to_clip != NULL;
    if (d.world_to_clip) memcpy(r->before, d.world_to_clip, sizeof r->before);
    return glbk__rsm_smooth(ctx, r, gbuffer, d.passes);
}

GLBK_DEF void glbk_rsm_reset(glbk_rsm_renderer *r)
{
    if (r) r->remembers = 0;
}

GLBK_DEF glbk_result glbk_rsm_resolve(glbk_context *ctx, glbk_rsm_renderer *r, const glbk_gbuffer *gbuffer,
                                      const glbk_pass *pass, const glbk_picture *picture, int direct,
                                      int bounced)
{
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_gbuffer_check(ctx, __func__, r, gbuffer);
    if (result != GLBK_OK) return result;
    if (!pass) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "pass", "is NULL");
    memset(&r->values, 0, sizeof r->values);
    r->values.shows_direct = direct && r->direct < 3;
    r->values.shows_bounced = bounced && glbk__rsm_bounced(r);
    result = glbk__rsm_program(ctx, r, GLBK__RSM_RESOLVE);
    if (result == GLBK_OK)
        result = glbk__begin_picture(ctx, __func__, pass, picture, r->width, r->height,
                                     &r->programs[GLBK__RSM_RESOLVE]);
    if (result == GLBK_OK) result = glbk__put_block(ctx, GLBK_SLOT_glbk_rsm_frame, &r->frame, &r->values);
    if (result != GLBK_OK) return result;
    glbk__rsm_bind_all(ctx, r, gbuffer, NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_sum, r->direct < 3 ? &r->sums[r->direct] : NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_states, glbk__rsm_bounced(r));
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_rsm_read(glbk_context *ctx, glbk_rsm_renderer *r, int bounced, float *rgba)
{
    const glbk_target *target;
    glbk_result result;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_renderer_check(ctx, __func__, r);
    if (result != GLBK_OK) return result;
    if (!rgba) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "rgba", "is NULL");
    if (bounced)
        target = r->bounce < 3   ? &r->targets[r->bounce]
                 : r->bounce < 5 ? &r->history_targets[r->bounce - 3]
                                 : NULL;
    else target = r->direct < 3 ? &r->targets[r->direct] : NULL;
    if (target) return glbk_target_read(ctx, target, 0, 0, 0, r->width, r->height, rgba);
    return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, bounced ? "bounced light" : "direct light",
                        "is not there yet");
}

/* ==== src/gl_rsm/end.h ==== */

#endif /* GL_RSM_IMPLEMENTATION */

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
