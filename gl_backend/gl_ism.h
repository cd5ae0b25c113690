/* gl_ism.h - v0.9.0 - imperfect shadow maps on OpenGL 3.3, OpenGL ES 3.0 and WebGL 2 - MIT-0 OR Unlicense

   What it does

   The header draws the imperfect shadow maps of all VPLs from surfels, fills their holes, and sums the light
   of the VPLs with visibility. Shaders of your own do so by one call, ism_light(). Or complete passes light a
   G-buffer, with interleaved sampling and its blur. Descs, settings and lists are the structs of ism.h, of
   which this header needs the declarations alone.

   What it does not do

   - It needs gl_backend.h beside it, which makes the context object, textures and targets, and whose
     conventions, errors and rules about GL's state hold here; gl_programs.h, which makes programs;
     and gl_gbuffer.h, whose G-buffer is lit.
   - Skies' VPLs come from ism.h. VPLs, near points and the windows of tiles are chosen by ism.h or, from maps
     on the GPU, by glbk_ism_choose; surfels are scattered by ism.h or by glbk_ism_scatter.

   Quick start

       #define GL_BACKEND_IMPLEMENTATION
       #define GL_PROGRAMS_IMPLEMENTATION
       #define GL_GBUFFER_IMPLEMENTATION
       #define GL_ISM_IMPLEMENTATION
       #include "gl_backend/gl_ism.h"
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
               "    color = ism_light(place, up, up, 0u, 1u);\n"
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
           source.parts[0] = glbk_ism_part();               // the GLSL of this header
           source.uses = "ism_light";
           source.defines = "ISM_PROJECTION=1";
           source.fragment = fragment;
           result = glbk_program_compile(&gl, &source, &program);
           printf("%s\n", glbk_result_text(result));
           glbk_program_free(&gl, &program);
           glbk_free(&gl);
           return result != GLBK_OK;
       }

   The whole frame, with a window: examples/10_ism_gl_minimal.c, and examples/10b_rsm_ism_gl_minimal.c by
   complete passes.

   A frame, after ism_choose and ism_scatter

       glbk_ism_surfels_upload(gl, &maps, phase, surfels, m);       // of ism_phase_surfels; at first all
       glbk_ism_vpls_upload(gl, &maps, vpls, n, &info);             // of ism_vpls and ism_get_info
       glbk_ism_near_points_upload(gl, &maps, points, count);       // of ism_near_points
       glbk_ism_mesh_move(gl, &maps, positions, 0);                 // if vertices moved
       glbk_ism_draw(gl, &maps, 0);
       glbk_gbuffer_begin(gl, &seen, world_to_clip, eye); ...       // what the camera sees: gl_gbuffer.h
       glbk_ism_shade(gl, &renderer, &seen, &maps, NULL, 0);
       glbk_ism_resolve(gl, &renderer, &seen, &pass, NULL);

   With a source in textures, such as glbk_rsm_map.texels, two calls take the place of the first three and of
   ism_choose and ism_scatter, nothing is read back, and the mesh may have been moved on the GPU:

       glbk_ism_choose(gl, &choice, &maps, &map.texels, &seen, index);
       glbk_ism_scatter(gl, &spread, &maps, &seen, index);

   In shaders of your own

   These functions of lib/ism_light.glsl can be called after glbk_ism_bind:

       vec4 ism_light(vec3 p, vec3 n, vec3 ng, uint first, uint set_count);
       float ism_visible(uint v, ism_vpl l, vec3 p, vec3 ng, float bias);   // 1 lit, 0 not
       ism_vpl ism_read_vpl(uint v);                                        // l of ism_visible

   ism_light returns in rgb the irradiance of a point by VPLs first, first + set_count, ..., times set_count,
   in W/m^2 (0u and 1u: all VPLs), and in a the irradiance, mean of the channels, that ism_shading.near_mode
   took off. p is in world space; n and ng are unit, n for shading and ng the surface's own.

   How it works, and conventions

   ism.h chooses the VPLs (ism_choose), unless glbk_ism_choose does, and scatters surfels over the mesh
   (ism_scatter), unless glbk_ism_scatter does. From these lists the maps are drawn here and the pixels of a
   G-buffer are lit: surfels are drawn as discs with the depth test, pull and push fill the holes between
   them, and each pixel sums the light of its VPLs with visibility, interleaved with its neighbours and
   blurred afterwards. If ctx->compute is set, each of these steps is one dispatch in shared memory. A surfel
   is a triangle and barycentric coordinates in it, so geometry that moves needs nothing but new positions.

   Descs, settings and lists are the structs of ism.h with the same defaults, and results are those of ism.h
   up to the rounding of floats. One desc serves ism_create and glbk_ism_maps_create: lists of another one are
   GLBK_ERR_MISMATCH.

   A vector that is said to be unit may have a length of 0.97 to 1.03 and is used as it is, so interpolated
   normals must be normalised before they come; any other length in a list of VPLs is GLBK_ERR_INPUT.

   From the paper to the code

   The paper is that of ism.h: Ritschel et al., "Making Imperfect Shadow Maps View-Adaptive", 2011. A line has
   the function in GLSL, its twin in ism.h, and the rows of docs/conformance.md that test both.

     section 3.3  points drawn into maps         ism_place_surfel   ism__draw_points    T48 T50
     section 3.3  pull and push                  ism_pull           ism__pull           T49
     section 3.3  depths of texels in holes      ism_filled         ism__fill           T49
     section 3.2  importance by flux             ism_weight         ism__add_shares     T41
     section 4    importance by few receivers    ism_effect         ism__estimate_effect  T41
     section 4.2  receivers near the texel       ism_effect         ism__to_pixel       T41
     section 4    flux over N and probability    glbk_ism_choose    ism__make_vpl       T41
     section 4.1  prefix sums, VPL i at i / N    ism_search         ism__draw_vpl       T15 T16
     section 5.1  solid angle from one receiver  ism_solid_angle    ism__seen_by_view   T48
     section 5.2  solid angle from eight         ism_solid_angle    ism__seen_by_view   T48
     section 5.3  phases of surfels              glbk_ism_draw      ism_phase_surfels   T57
     section 5    surfels on triangles           ism_point          ism__points_of      T48
     section 6.1  maps of equal flux, of lobes   ism_map_direction  ism_map_direction   T46 T47
     section 6.2  subsets of VPLs                ism_light          ism__shade_pixel    -
     section 6.2  blur along surfaces            ism_smooth         ism__smooth_pixel   -
     section 6.4  dithered opacity               ism_dither         ism__dither         T58
     section 6.5  blur of the BRSM               ism_blurred        ism__blur_task      T41
     section 6.5  VPLs between texels            ism_inter_texel    ism__inter_texel    T55
     -            light close to a VPL           ism_patch_kernel   ism__patch_kernel   T42 T43 T44
     -            near points                    ism_gather         ism_near_points     T44
     -            how far they reach             ism_reach_of       ism__reach_of       -
     -            windows                        ism_zoom_axis      ism_zoom            -
     -            the next bounce                ism_cell_weight    ism_bounce          T45

   Configuration

     GL_ISM_IMPLEMENTATION   compiles the code, in one source file; the implementations of
                             gl_backend.h, gl_programs.h and gl_gbuffer.h may be compiled in another

   Layouts: docs/gpu-layouts.md.   The technique: docs/ism.md.   State: docs/gl-state.md.
   Licence: end of file. */
/* These includes stand outside the guard, since an implementation may be asked for when the file is included
   for the second time. ism.h lies above this folder; its implementation is not needed. */
#include "gl_programs.h"
#include "gl_gbuffer.h"
#include "../ism.h"

#ifndef GL_ISM_H
#define GL_ISM_H

#if GLBK_VERSION != 900
#error "gl_ism.h and gl_backend.h are of different versions"
#endif
#if defined(GLBK_STATIC) && !defined(GL_ISM_IMPLEMENTATION)
#error "GLBK_STATIC makes all functions private: GL_ISM_IMPLEMENTATION belongs into the same file"
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ==== src/gl_ism/api_page_one.h ==== */

/* ---- page one: the maps of all VPLs, drawn from ism.h's lists, for a shader of yours ---- */

typedef struct glbk_ism_maps glbk_ism_maps;             /* the maps of all VPLs: see "objects" below */
typedef struct glbk_ism_renderer glbk_ism_renderer;     /* the light of a picture: see there, too */

GLBK_DEF glbk_result glbk_ism_maps_create(glbk_context *ctx, const ism_desc *desc, glbk_ism_maps *out);
/* Makes room for the maps of all VPLs, which glbk_ism_maps_free takes back. out->compute says whether they
   are drawn by compute: if ctx->compute is set, unless the surfels of a VPL, rounded up to lazy_frames
   phases, are more than 65,536.
   desc     the desc of the ism_create whose lists are drawn; NULL = all defaults. vpl_count, surfel_count,
            tile_side, projection, lazy_frames, splat_scale, near_point_count, window_rim, keep_hits and
            no_fill count. With keep_hits the core path draws, and 4 bytes for each texel are added.
            The other fields, also its system, say how ism.h chooses the lists and play no part here
   out      zeroed on errors
   Memory   on the GPU: 26 bytes for each texel of the atlas, by compute 20, and 16 for each surfel. 1024 VPLs
            with 64 x 64 texels and 8192 surfels take 109 (84) + 134 MB
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL. GLBK_ERR_DESC: a field is out of range. GLBK_ERR_LIMIT: the
            atlas is wider than ctx->max_side. Those of programs, textures and targets */

GLBK_DEF glbk_result glbk_ism_mesh_upload(glbk_context *ctx, glbk_ism_maps *maps, const ism_mesh *mesh);
/* Sets the mesh that casts shadows. Surfels stay on triangles of the same numbers; those on triangles that
   are gone are not drawn. Before a mesh with other numbers set NULL: all phases must be given anew then.
   mesh     NULL = nothing casts shadows; its albedos are for glbk_ism_bounce, with desc.keep_hits. Its
            opacities are not checked here, as ism_build checks them
   Errors   GLBK_ERR_ARGUMENT: maps is NULL or was not created, or arrays, counts or strides do not fit.
            GLBK_ERR_INPUT: an index reaches beyond vertex_count. GLBK_ERR_LIMIT, GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_ism_surfels_upload(glbk_context *ctx, glbk_ism_maps *maps, uint32_t phase,
                                             const ism_surfel *surfels, size_t count);
/* Sets the surfels of one phase, of all VPLs, as ism_phase_surfels writes them.
   phase    below lazy_frames. A frame changes the phase index % lazy_frames alone. All of them are needed in
            the first frame, where the mesh has lost triangles, and with vary_surfels and unstable
   surfels  VPL by VPL
   count    surfels of the phase, as ism_phase_surfels counts them: desc.vpl_count x maps->phase_surfel_count
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, maps were not created, or there is no such phase.
            GLBK_ERR_MISMATCH: count is another, since ism_create and glbk_ism_maps_create were given
            different descs */

GLBK_DEF glbk_result glbk_ism_vpls_upload(glbk_context *ctx, glbk_ism_maps *maps, const ism_vpl *vpls,
                                          uint32_t count, const ism_info *info);
/* Sets the VPLs of a frame. They have no near points until glbk_ism_near_points_upload.
   vpls     as ism_vpls has them; area, source, texel and jumped play no part
   count    at most desc.vpl_count; 0 = no light
   info     what ism_get_info writes of the ism_maps whose VPLs these are, after ism_scatter. The maps of
            directional VPLs show the sphere of info->center and info->radius. surfel_count, tile_side and
            lazy_frames must be those of maps->desc; in a struct of your own, for VPLs of your own, they may
            be 0
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or maps were not created. GLBK_ERR_INPUT: a VPL that
            ism_set_vpls refuses, a negative edge or reach, a window that leaves nothing of a side, or a
            radius of 0 beside a directional VPL. GLBK_ERR_LIMIT: count is above desc.vpl_count.
            GLBK_ERR_MISMATCH: info is of an ism_create with another desc. GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_ism_draw(glbk_context *ctx, glbk_ism_maps *maps, uint32_t surfels_per_pass);
/* Draws the maps of all VPLs, to maps->atlas: depths, as bits of floats, tile by tile. The core path takes a
   draw for each phase, or for each surfels_per_pass of it, and then up to five passes over the atlas. The
   compute path takes two dispatches. If ctx->max_point_side is below tile_side, the core path draws
   rectangles instead of points.
   surfels_per_pass   most surfels of a draw on the core path; 0 = 2^20. Give fewer if the driver stops draws
                      that take long
   Errors             GLBK_ERR_ARGUMENT: maps is NULL or was not created. GLBK_ERR_ORDER: the surfels of a
                      phase were not given yet. GLBK_ERR_LOST */

GLBK_DEF glbk_result glbk_ism_bind(glbk_context *ctx, const glbk_ism_maps *maps, const ism_shading *shading,
                                   const glbk_offset *offset);
/* Binds textures and uniform blocks for a program of your own, which is in use (glbk_begin). The program has
   ism_light among its library files, and among its defines ISM_NEAR, the number of a near_mode (0 and 6 are
   ISM_NEAR_GATHER), and ISM_PROJECTION, the number of maps->desc.projection.
   shading  NULL = all defaults; only bias, clamp and no_maps count, but all fields are checked, and
            visible_fn and near_visible_fn must be NULL
   offset   the offset that the part ism has in the program; NULL = none
   Errors   GLBK_ERR_ARGUMENT: maps is NULL or was not created. GLBK_ERR_DESC: a field of the shading is out
            of range, or a function is not NULL */

GLBK_DEF void glbk_ism_maps_free(glbk_context *ctx, glbk_ism_maps *maps);
/* Frees what glbk_ism_maps_create made, and zeroes the struct. NULL and zeroed maps are allowed. */

/* ==== src/gl_ism/api.h ==== */

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

/* ==== src/gl_ism/api_choice.h ==== */

#ifndef GLBK_ISM_WITHOUT_CHOICE
/* ---- VPLs chosen on the GPU, from maps that lie there: nothing is read back ---- */

#define GLBK_ISM_SUM_LEVELS 3u          /* levels of running sums, in blocks of 32 each */

typedef struct glbk_ism_choice_desc {   /* zero it, then set what you care about */
    uint32_t width;                     /* texels in a row of the source, 1..32768; must be set */
    uint32_t height;                    /* rows of a face; must be set. All faces have 32768 at most */
    uint32_t face_count;                /* such as the 6 of a cube map; 0 = 1 */
    int      scattered;                 /* not 0: neighbours in a face are no neighbours in space, so VPLs lie
                                           on texels, not between them */
} glbk_ism_choice_desc;

typedef struct glbk_ism_sheet {         /* numbers that a pass draws and later ones read; zeroed = none */
    glbk_texture texture;
    glbk_target  target;                /* of texture */
} glbk_ism_sheet;

typedef struct glbk_ism_choice {        /* what glbk_ism_choose needs; read only; zeroed = none */
    glbk_ism_choice_desc desc;          /* with its defaults */
    uint32_t       table;               /* GL's name of the table of VPLs that is drawn to */
    glbk_target    table_target;        /* of the table */
    glbk_ism_sheet boxes[3];            /* boxes about receivers: 1024 about 64 each, 32, and one about all; a
                                           layer for the lower corners, one for the upper ones */
    glbk_ism_sheet effects;             /* how much each texel of the source adds to the picture, face above
                                           face; R32UI, bits of floats */
    glbk_ism_sheet importances;         /* flux times effect, and flux; RG32UI, bits of floats, as sums */
    glbk_ism_sheet row_sums[GLBK_ISM_SUM_LEVELS];       /* running sums along rows: of each block of 32
                                                           texels, of each block of 32 blocks, of all of
                                                           these */
    glbk_ism_sheet column_sums[GLBK_ISM_SUM_LEVELS];    /* the same of whole rows, one texel wide */
    glbk_ism_sheet drawn;               /* VPLs, 256 a row: place and area; normal; flux */
    glbk_ism_sheet sights[2];           /* receivers that windows hold: pixels; places, normals */
    glbk_ism_sheet windows[2];          /* of tiles, 256 a row, in this frame and the one before */
    uint32_t       near_point_count;    /* near points that are drawn; 0 = none */
    glbk_ism_sheet near_points;         /* as they are drawn, 256 a row, like VPLs */
    glbk_ism_sheet near_sheets[2];      /* edges, reaches, VPLs, places on a curve; which one is when */
    uint32_t       turn;                /* frames that had windows; 0 = none yet. Odd: windows[1] is newer */
    glbk_buffer    block;               /* the uniform block */
    glbk_program   programs[13];        /* draw importances, running sums, VPLs and the table; effects, and
                                           boxes the first time and later; windows, and sights the same; near
                                           points' edges and the like, order and table */
} glbk_ism_choice;

GLBK_DEF glbk_result glbk_ism_choice_create(glbk_context *ctx, const glbk_ism_maps *maps,
                                            const glbk_ism_choice_desc *desc, glbk_ism_choice *out);
/* Makes what chooses the VPLs of maps, which must outlive it; glbk_ism_choice_free takes it back.
   maps     whose desc says how VPLs are chosen: vpl_count, importance, view_grid_side, blur_radius,
            flux_share, no_inter_texel, unstable, seed, window_rim, near_point_count and keep_hits count.
            There are near points unless vpl_count is 8 or less, or they and the VPLs are more than 2^20
            texels of the table
   out      zeroed on errors
   Memory   on the GPU: 20.5 bytes for each texel of the source (by flux 16.5), 80 for each VPL, 68
            for each near point, and 82 KB
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or maps were not created. GLBK_ERR_DESC: a field is out of
            range, also of maps->desc. GLBK_ERR_LIMIT: width, or the rows of all faces, are above
            ctx->max_side or 32768. Those of programs, textures and targets */

GLBK_DEF glbk_result glbk_ism_choose(glbk_context *ctx, glbk_ism_choice *choice, glbk_ism_maps *maps,
                                     const glbk_texture *texels, const glbk_gbuffer *seen, uint32_t index);
/* Chooses the VPLs of a frame as ism_choose does among surfaces, by passes of fragments, in place of
   glbk_ism_vpls_upload. Nothing is read back, and the CPU waits for nothing. All vpl_count VPLs are in use;
   those of a black source are black.
   maps     those of glbk_ism_choice_create. Near points are drawn with the VPLs; those of a texel without an
            area have one by how densely VPLs lie. Tiles have windows (ism_zoom) by what seen shows, as after
            ism_scatter
   texels   the source: RGBA32UI layers, three for each face, with the bits of floats: place; unit normal;
            flux of the channels in W, and area in m^2 (what ism_source says of them). glbk_rsm_map.texels are
            such. A texel whose flux is not 0..1e30, whose place is not finite or whose normal is not unit is
            never chosen
   seen     what the camera sees: the receivers, and the matrix that says which of them lie near a texel and
            how far VPLs may move between texels. If the G-buffer has no matrix (has_clip is 0), receivers
            are looked for everywhere alike, and VPLs may move as far as if all was seen from afar. May be
            NULL with ISM_IMPORTANCE_FLUX; tiles have no windows then
   index    number of the frame; counts if maps->desc.unstable is set
   Cost     for each texel of the source 35 texels read by flux; else besides view_grid_side^2 receivers, and
            three texels for each that its blur reaches, 169 by default. Each VPL looks at all others, and for
            its window at 512 receivers, which are found among all pixels; each near point looks at all VPLs
            and at 1023 others
   Errors   GLBK_ERR_ARGUMENT: a pointer that must be given is NULL, or an object was not created.
            GLBK_ERR_MISMATCH: maps are not those that the choice was made for, or texels have another size,
            format or number of layers. GLBK_ERR_LOST */

GLBK_DEF void glbk_ism_choice_free(glbk_context *ctx, glbk_ism_choice *choice);
/* Frees what glbk_ism_choice_create made, and zeroes the struct. NULL and a zeroed choice are allowed. */
#endif

/* ==== src/gl_ism/api_scatter.h ==== */

#ifndef GLBK_ISM_WITHOUT_CHOICE
/* ---- surfels scattered on the GPU: with glbk_ism_choose, nothing of a frame comes from the CPU ---- */

typedef struct glbk_ism_spread {        /* what glbk_ism_scatter needs; read only; zeroed = none */
    uint32_t table;                     /* GL's name of the table of VPLs of the maps it was made for */
    uint32_t width, height;             /* of the picture that it has room for; 0 = none yet */
    uint32_t triangle_count;            /* of the mesh that it has room for; 0 = none yet */
    uint32_t cluster_count;             /* clusters are successive triangles that are taken together */
    uint32_t triangles_per_cluster;     /* of each cluster but the last */
    uint32_t batch;                     /* VPLs whose shares are computed at a time */
    glbk_ism_sheet seen;                /* 1 for each pixel that is a receiver; R32UI, bits of floats */
    glbk_ism_sheet seen_sums[5];        /* running sums of these, in blocks of 32, of 32 blocks, ... */
    glbk_ism_sheet receivers;           /* places of receivers, one after the other; RGBA32UI */
    glbk_ism_sheet sizes;               /* of triangles: area and solid angle; RG32UI */
    glbk_ism_sheet masses;              /* of clusters, the same; the target draws `clusters`, too */
    glbk_texture   clusters;            /* where clusters lie and how they face, three layers of RGBA32UI */
    glbk_ism_sheet totals[3];           /* sums of masses, in blocks of 32, of 32 blocks, of all */
    glbk_ism_sheet effects;             /* of clusters on the maps of a batch of VPLs; R32UI */
    glbk_ism_sheet effect_totals[3];    /* sums of effects */
    glbk_ism_sheet shares;              /* of the surfels of VPLs that clusters have; R32UI */
    glbk_ism_sheet share_sums[3];       /* running sums of shares */
    glbk_ism_sheet counts;              /* surfels of each VPL; R32UI, whole numbers */
    glbk_ism_sheet gone;                /* 1 for each surfel whose triangle is gone, in the rows of a layer
                                           that are drawn next; R8UI */
    glbk_target    surfel_target;       /* of a layer of the maps' tables of surfels */
    glbk_buffer    block;               /* the uniform block */
    glbk_program   programs[10];        /* draw sizes, masses, shares, sums, counts, surfels and which are
                                           gone, then seen and receivers, then effects */
} glbk_ism_spread;

GLBK_DEF glbk_result glbk_ism_spread_create(glbk_context *ctx, const glbk_ism_maps *maps,
                                            glbk_ism_spread *out);
/* Makes what scatters the surfels of maps, which must outlive it; glbk_ism_spread_free takes it back. What
   depends on the mesh and on the picture is made by glbk_ism_scatter.
   maps     whose desc says how surfels are scattered: surfel_count, spread, lazy_frames, area_share,
            unstable, vary_surfels, window_rim and seed count
   out      zeroed on errors
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or maps were not created. GLBK_ERR_DESC: maps->desc.spread
            or area_share is out of range. Those of programs, textures and targets */

GLBK_DEF glbk_result glbk_ism_scatter(glbk_context *ctx, glbk_ism_spread *spread, glbk_ism_maps *maps,
                                      const glbk_gbuffer *seen, uint32_t index);
/* Scatters the surfels of a frame as ism_scatter does for the same random numbers, by passes of fragments, in
   place of glbk_ism_surfels_upload: the surfels of phase index % lazy_frames, and at first, or with unstable
   or vary_surfels, those of all phases. If the mesh has lost triangles, surfels that lay on them are
   scattered anew in all phases, and the others stay; new triangles get theirs phase by phase. Sums are of
   floats where ism_scatter has doubles, so a surfel beside the step of a sum may lie on a neighbouring
   triangle. Nothing is read back, and the CPU waits for nothing. Triangles and vertices are those that the
   maps have there.
   maps     those of glbk_ism_spread_create, with a mesh that has no mask, whose holes the GPU does not know,
            and with VPLs: glbk_ism_choose or glbk_ism_vpls_upload. Without triangles nothing is done
   seen     what the camera sees: the receivers. May be NULL with ISM_SPREAD_AREA
   index    number of the frame
   Memory   on the GPU: 8 bytes for each triangle, 56 for each of at most 32,768 clusters, 24.2 for each
            pixel, 26 MB at most for the shares of a batch of VPLs, and 1 MB
   Cost     for each triangle 8 receivers, with ISM_SPREAD_VIEW_1 one; for each VPL, by ISM_SPREAD_PAIR, every
            cluster; for each surfel 16 texels and half the triangles of a cluster
   Errors   GLBK_ERR_ARGUMENT: a pointer that must be given is NULL, or an object was not created.
            GLBK_ERR_MISMATCH: maps are not those that the spread was made for, or their mesh has a mask.
            GLBK_ERR_LIMIT: the picture has more than 2^24 pixels, or there are so many of them, or of
            triangles, that 1024 in a row are more rows than ctx->max_side. GLBK_ERR_ALLOC, GLBK_ERR_LOST */

GLBK_DEF void glbk_ism_spread_free(glbk_context *ctx, glbk_ism_spread *spread);
/* Frees what glbk_ism_spread_create and glbk_ism_scatter made, and zeroes the struct. NULL and a zeroed
   spread are allowed. */
#endif

/* ==== src/gl_ism/api_bounce.h ==== */

#ifndef GLBK_ISM_WITHOUT_CHOICE
/* ---- the next bounce on the GPU, from the maps (imperfect reflective shadow maps) ---- */

typedef struct glbk_ism_bounces {       /* what VPLs shine on, as a source; read only; zeroed = none */
    uint32_t     table;                 /* GL's name of the table of VPLs of the maps it was made for */
    uint32_t     side;                  /* cells a side of a VPL's tile */
    glbk_texture texels;                /* of glbk_ism_choose: side x side texels in the row of each VPL */
    glbk_target  target;                /* of texels */
    glbk_program program;
} glbk_ism_bounces;

GLBK_DEF glbk_result glbk_ism_bounces_create(glbk_context *ctx, const glbk_ism_maps *maps, uint32_t side,
                                             glbk_ism_bounces *out);
/* Makes room for the next bounce of the VPLs of maps, which must outlive it; glbk_ism_bounces_free takes it
   back.
   maps     made with desc.keep_hits. glbk_ism_mesh_upload gives them the albedos of the mesh
   side     a power of two, desc.tile_side at most: a VPL's tile is taken in side x side cells, each of which
            makes a texel of the next source
   out      zeroed on errors
   Memory   on the GPU: 48 bytes for each texel
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, maps were not created, or side is another.
            GLBK_ERR_MISMATCH: maps were made without desc.keep_hits. GLBK_ERR_LIMIT: side x side or
            vpl_count is above ctx->max_side. Those of programs, textures and targets */

GLBK_DEF glbk_result glbk_ism_bounce(glbk_context *ctx, glbk_ism_bounces *bounces, const glbk_ism_maps *maps);
/* Draws what the maps show into bounces->texels, a pass of fragments, as ism_bounce writes it: where light of
   the VPLs hits a triangle, with its normal towards the VPL, and the flux that the triangle's albedo
   leaves of it. glbk_ism_choose then chooses VPLs of the next bounce from these texels, for other maps, with
   a glbk_ism_choice_desc of width side x side, height desc.vpl_count and `scattered`.
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or an object was not created. GLBK_ERR_MISMATCH: maps are
            not those that the bounces were made for. GLBK_ERR_ORDER: the maps were never drawn, or not since
            the mesh has lost triangles. GLBK_ERR_LOST */

GLBK_DEF void glbk_ism_bounces_free(glbk_context *ctx, glbk_ism_bounces *bounces);
/* Frees what glbk_ism_bounces_create made, and zeroes the struct. NULL and zeroed bounces are allowed. */
#endif

/* ==== src/gl_ism/bindings.h ==== */

/* ---- what the GLSL declares; see "bindings" in gl_programs.h ---- */

#define GLBK_ISM_TABLES(X)                                                                              \
    X(usampler2DArray, glbk_ism_vpls, 0)        /* VPLs and near points: docs/gpu-layouts.md */         \
    X(usampler2DArray, glbk_ism_surfels, 1)     /* triangle, barycentric coordinates, area */           \
    X(sampler2DArray, glbk_ism_albedos, 1)      /* of triangles */                                      \
    X(usampler2DArray, glbk_ism_triangles, 2)   /* of each three indices, opacity */                    \
    X(sampler2DArray, glbk_ism_positions, 3)    /* of vertices */

#define GLBK_ISM_PICTURES(X)                                                                            \
    X(usampler2D, glbk_ism_atlas, 4)            /* depths, floats as bits */                            \
    X(glbk_color_sampler, glbk_ism_planes, 5)   /* plane and depth of a texel's nearest surfel */       \
    X(usampler2D, glbk_ism_below, 6)            /* kept texels, or the level below */                   \
    X(usampler2D, glbk_ism_hits, 7)             /* triangle of a texel's nearest surfel */              \
    X(glbk_color_sampler, glbk_ism_light, 7)    /* irradiance; 8 to 11 are the G-buffer's */            \
    X(usampler2D, glbk_ism_pull1, 12)           /* levels of pull, whose slots are neighbours */        \
    X(usampler2D, glbk_ism_pull2, 13)                                                                   \
    X(usampler2D, glbk_ism_pull3, 14)

/* Of programs that choose VPLs, which read neither tables nor maps. */
#define GLBK_ISM_CHOICE_TEXTURES(X)                                                                     \
    X(usampler2DArray, glbk_ism_texels, 0)      /* layers 3 face + 0 place, 1 normal, 2 flux */         \
    X(usampler2DArray, glbk_ism_near, 0)        /* near points: place, normal, flux */                  \
    X(usampler2D, glbk_ism_near_order, 1)       /* which near point has a place in their order */       \
    X(usampler2D, glbk_ism_near_facts, 2)       /* of near points: edge, reach, VPL, place on a curve */ \
    X(usampler2DArray, glbk_ism_drawn, 1)       /* VPLs: place, normal, flux */                         \
    X(usampler2DArray, glbk_ism_box, 1)         /* of the receivers: lower and upper corner */          \
    X(usampler2D, glbk_ism_effects, 1)          /* of texels on the picture */                          \
    X(usampler2D, glbk_ism_summed, 1)           /* values of running sums */                            \
    X(usampler2D, glbk_ism_importances, 1)      /* flux times effect, flux */                           \
    X(usampler2D, glbk_ism_row_sums0, 2)        /* running sums of importances along rows */            \
    X(usampler2D, glbk_ism_row_sums1, 3)        /* and of their blocks of 32 */                         \
    X(usampler2D, glbk_ism_row_sums2, 4)        /* and of blocks of these */                            \
    X(usampler2D, glbk_ism_column_sums0, 5)     /* the same of whole rows */                            \
    X(usampler2D, glbk_ism_column_sums1, 6)                                                             \
    X(usampler2D, glbk_ism_column_sums2, 7)                                                             \
    X(usampler2DArray, glbk_ism_sights, 12)     /* receivers that lie farthest out */                   \
    X(usampler2D, glbk_ism_windows, 13)         /* of VPLs: place; window and face */

/* Of programs that scatter surfels. */
#define GLBK_ISM_SPREAD_TEXTURES(X)                                                                     \
    X(usampler2D, glbk_ism_values, 1)           /* sequences that are summed up */                      \
    X(usampler2DArray, glbk_ism_clusters, 1)    /* of triangles: place; squares of normals */           \
    X(usampler2D, glbk_ism_shares, 1)           /* of the surfels of VPLs that clusters have */         \
    X(usampler2D, glbk_ism_gone, 2)             /* which surfels' triangles are gone */                 \
    X(usampler2D, glbk_ism_runs0, 4)            /* running sums in blocks of 32, */                     \
    X(usampler2D, glbk_ism_runs1, 5)            /* of 32 blocks, and so on: of shares, */               \
    X(usampler2D, glbk_ism_runs2, 6)            /* or of receivers, which have five levels */           \
    X(usampler2D, glbk_ism_runs3, 7)                                                                    \
    X(usampler2D, glbk_ism_effect_totals, 4)    /* sums of what VPLs see of clusters */                 \
    X(usampler2D, glbk_ism_totals, 7)           /* area and solid angle of all triangles */             \
    X(usampler2D, glbk_ism_runs4, 12)                                                                   \
    X(usampler2D, glbk_ism_counts, 12)          /* surfels of each VPL */                               \
    X(usampler2D, glbk_ism_receivers, 13)       /* places of receivers */                               \
    X(usampler2D, glbk_ism_masses, 13)          /* of clusters: area and solid angle */                 \
    X(usampler2D, glbk_ism_sizes, 14)           /* of triangles: area and solid angle */

#define GLBK_ISM_TEXTURES(X)                                                                            \
    GLBK_ISM_TABLES(X) GLBK_ISM_PICTURES(X) GLBK_ISM_CHOICE_TEXTURES(X) GLBK_ISM_SPREAD_TEXTURES(X)

#define GLBK_ISM_COUNT_MEMBERS(X)                                                                       \
    X(uint, vpl_count, 1)           /* VPLs in use */                                                   \
    X(uint, tile_side, 1)           /* texels a side of a VPL's tile */                                 \
    X(uint, tiles_across, 1)        /* tiles a side of the atlas */                                     \
    X(uint, surfel_count, 1)        /* surfels of a VPL, in all phases */                               \
    X(uint, vpl_capacity, 1)        /* VPLs that there is room for */                                   \
    X(uint, phase_surfel_count, 1)  /* surfels of a VPL in one phase */                                 \
    X(uint, fill_levels, 1)         /* levels of pull and push; 0 = holes stay */                       \
    X(uint, triangle_count, 1)

#define GLBK_ISM_MESH_MEMBERS(X)                                                                        \
    X(vec4, sphere, 1)              /* about the mesh: centre, radius */                                \
    X(float, splat_scale, 1)        /* area of a disc over that of its surfel */                        \
    X(uint, window_rim, 1)          /* texels a side of a tile outside of its window */                 \
    X(uint, near_point_count, 1)    /* near points in use */                                            \
    X(uint, first_sphere, 1)        /* where in glbk_ism_vpls spheres of near points begin */           \
    X(uint, first_near_point, 1)    /* where in glbk_ism_vpls near points begin */                      \
    X(uint, first_surfel, 1)        /* of a draw of rectangles: the surfel of instance 0 */             \
    X(uint, bounce_side, 1)         /* cells a side of a tile that glbk_ism_bounce reads */             \
    X(uint, unused0, 1)

#define GLBK_ISM_FRAME_MEMBERS(X) GLBK_ISM_COUNT_MEMBERS(X) GLBK_ISM_MESH_MEMBERS(X)

#define GLBK_ISM_VIEW_MEMBERS(X)                                                                        \
    X(uint, width, 1)               /* of the picture, in pixels */                                     \
    X(uint, height, 1)              /* of the picture, in pixels */                                     \
    X(uint, interleave, 1)          /* pixels a side that share the VPLs */                             \
    X(uint, no_maps, 1)             /* not 0: nothing casts shadows */                                  \
    X(float, bias, 1)               /* as in ism_shading, with its default */                           \
    X(float, clamp_at, 1)           /* ism_shading.clamp, with its default */                           \
    X(uint, first_row, 1)           /* the first row of pixels of a dispatch */                         \
    X(uint, unused0, 1)

#define GLBK_ISM_CHOOSING_MEMBERS(X)                                                                    \
    X(mat4, world_to_clip, 1)       /* of the camera; 0 = unknown */                                    \
    X(uint, width, 1)               /* texels in a row of the source */                                 \
    X(uint, face_height, 1)         /* rows of a face */                                                \
    X(uint, vpl_count, 1)           /* VPLs that are chosen */                                          \
    X(uint, inter_texel, 1)         /* not 0: VPLs lie between texels */                                \
    X(float, shift, 1)              /* added to the places of VPLs in the sums of rows */               \
    X(uint, shift_bits, 1)          /* the same in a row, as a fraction of 2^32 */                      \
    X(uint, columns, 1)             /* of running sums: not 0 = along columns */                        \
    X(uint, pace, 1)                /* of running sums: values from one that counts to the next */      \
    X(uint, value_count, 1)         /* of running sums: values in a row or column */                    \
    X(uint, first_column, 1)        /* of running sums along columns: where they are read */            \
    X(uint, view_width, 1)          /* of the picture, in pixels */                                     \
    X(uint, view_height, 1)         /* of the picture, in pixels */                                     \
    X(uint, grid_side, 1)           /* ism_desc.view_grid_side */                                       \
    X(uint, guided, 1)              /* not 0: half of the receivers lie near the texel's own place */   \
    X(uint, by_effect, 1)           /* not 0: effects count; 0: flux alone */                           \
    X(uint, by_mean, 1)             /* not 0: effects are means; 0: roots of mean squares */            \
    X(uint, blur_radius, 1)         /* of effects, in texels */                                         \
    X(uint, seed, 1)                /* of receivers */                                                  \
    X(float, flux_factor, 1)        /* what makes ism_desc.flux_share of a factor of fluxes */          \
    X(uint, windows, 1)             /* 0 = none; 1 = new ones; 2 = those of the last frame stay */      \
    X(uint, near_point_count, 1)    /* near points that are drawn; 0 = none */                          \
    X(uint, first_sphere, 1)        /* where in glbk_ism_vpls their spheres begin */                    \
    X(uint, first_near_point, 1)    /* where they begin themselves; 0 while VPLs are drawn */           \
    X(uint, unused0, 1)

#define GLBK_ISM_SCATTERING_MEMBERS(X)                                                                  \
    X(uint, triangle_count, 1)      /* of the mesh */                                                   \
    X(uint, cluster_count, 1)       /* clusters of triangles */                                         \
    X(uint, cluster_size, 1)        /* triangles of a cluster */                                        \
    X(uint, first_vpl, 1)           /* of the batch */                                                  \
    X(uint, batch, 1)               /* VPLs that are worked on */                                       \
    X(uint, vpl_capacity, 1)        /* VPLs that there is room for */                                   \
    X(uint, view_width, 1)          /* of the picture, in pixels */                                     \
    X(uint, view_height, 1)         /* of the picture, in pixels */                                     \
    X(uint, views, 1)               /* receivers of a triangle; 0 = by area */                          \
    X(uint, pair, 1)                /* not 0: what a VPL sees of a cluster counts */                    \
    X(uint, seed, 1)                /* of receivers */                                                  \
    X(uint, key, 1)                 /* of surfels */                                                    \
    X(uint, surfel_count, 1)        /* of each VPL, in all phases */                                    \
    X(uint, phase_surfel_count, 1)  /* of each VPL in one phase */                                      \
    X(uint, lazy_frames, 1)         /* phases */                                                        \
    X(uint, phase, 1)               /* that is drawn */                                                 \
    X(uint, first_texel, 1)         /* number of the layer's first texel among a phase's surfels */     \
    X(uint, value_count, 1)         /* of a sequence that is summed up */                               \
    X(uint, pace, 1)                /* values from one that counts to the next */                       \
    X(uint, vary_surfels, 1)        /* not 0: dark VPLs have fewer surfels */                           \
    X(float, area_share, 1)         /* ism_desc.area_share, with its default */                         \
    X(uint, frame, 1)               /* its number */                                                    \
    X(uint, keep, 1)                /* not 0: surfels stay whose triangles are there */                 \
    X(uint, layer, 1)               /* of the table of surfels, that is drawn */

#define GLBK_ISM_BLOCKS(X)                                                                              \
    X(glbk_ism_frame, 0, GLBK_ISM_FRAME_MEMBERS)                                                        \
    X(glbk_ism_view, 1, GLBK_ISM_VIEW_MEMBERS)                                                          \
    X(glbk_ism_choosing, 2, GLBK_ISM_CHOOSING_MEMBERS)                                                  \
    X(glbk_ism_scattering, 3, GLBK_ISM_SCATTERING_MEMBERS)

#define GLBK_ISM_STORAGE(X)
#define GLBK_ISM_IMAGES(X)                                                                              \
    X(writeonly, rgba32f, image2D, glbk_ism_planes_out, 0)      /* glbk_ism_planes */                   \
    X(writeonly, r32ui, uimage2D, glbk_ism_atlas_out, 1)        /* glbk_ism_atlas */                    \
    X(writeonly, rgba32f, image2D, glbk_ism_light_out, 2)       /* before the blur, or after it */

GLBK__PART(ISM)

/* ==== src/gl_ism/begin.h ==== */

/* ---- end of the declarations ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_ISM_H */

/* ==== implementation ==================================================================================== */

#if defined(GL_ISM_IMPLEMENTATION) && !defined(GL_ISM_IMPLEMENTED)
#define GL_ISM_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ==== src/shared/mem.h ==== */

/* unit mem: checked sizes, and the caller's allocator with malloc and free as its default */

typedef struct glbk_ism__allocator {
    void *(*alloc_fn)(size_t size, void *user);
    void (*free_fn)(void *memory, void *user);
    void *user;
} glbk_ism__allocator;

static inline void *glbk_ism__default_alloc(size_t size, void *user)
{
    (void)user;
    return malloc(size);
}

static inline void glbk_ism__default_free(void *memory, void *user)
{
    (void)user;
    free(memory);
}

/* Writes a * b and returns 1; returns 0, with *out untouched, if the product does not fit. */
static inline int glbk_ism__mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b) return 0;
    *out = a * b;
    return 1;
}

/* Returns 1 if so many bytes may lie between elements of floats that are `standard` bytes large: 0, which
   stands for `standard`, or a multiple of 4 with which elements do not overlap. */
static inline int glbk_ism__stride_valid(size_t stride, size_t standard)
{
    return stride == 0 || (stride >= standard && stride % 4 == 0);
}

static inline glbk_ism__allocator glbk_ism__allocator_make(void *(*alloc_fn)(size_t, void *),
                                           void (*free_fn)(void *, void *), void *user)
{
    glbk_ism__allocator a;
    a.alloc_fn = alloc_fn && free_fn ? alloc_fn : glbk_ism__default_alloc;
    a.free_fn = alloc_fn && free_fn ? free_fn : glbk_ism__default_free;
    a.user = user;
    return a;
}

/* Returns NULL if there is no memory, and also if the size is 0, so that a caller has one thing to test. */
static inline void *glbk_ism__alloc(const glbk_ism__allocator *a, size_t size)
{
    return size ? a->alloc_fn(size, a->user) : NULL;
}

static inline void *glbk_ism__alloc_array(const glbk_ism__allocator *a, size_t count, size_t item_size)
{
    size_t size;
    return glbk_ism__mul_size(count, item_size, &size) ? glbk_ism__alloc(a, size) : NULL;
}

static inline void glbk_ism__free(const glbk_ism__allocator *a, void *memory)
{
    if (memory) a->free_fn(memory, a->user);
}

/* ==== src/shared/unit.h ==== */

/* unit unit: which vectors count as unit, the same in every header (src/README.md, "Unit vectors") */

/* The squares of the least and the greatest length that count as 1: an 8-bit normal map makes such
   vectors. */
#define GLBK_ISM__UNIT_LEAST2 0.9409f       /* 0.97^2 */
#define GLBK_ISM__UNIT_MOST2 1.0609f        /* 1.03^2 */

/* Says whether a vector is unit, by the square of its length. If that is not a number, the vector is not. */
static inline int glbk_ism__is_unit2(float length2)
{
    return length2 >= GLBK_ISM__UNIT_LEAST2 && length2 <= GLBK_ISM__UNIT_MOST2;
}

/* ==== src/shared/rng.h ==== */

/* unit rng: hashes and random numbers, the same on every machine */

/* Returns a hash by the output function of O'Neill's PCG: Jarzynski and Olano, "Hash functions for GPU
   rendering", JCGT 9(3), 2020. */
static inline uint32_t glbk_ism__hash32(uint32_t x)
{
    uint32_t state = x * 747796405u + 2891336453u;
    uint32_t word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return word >> 22 ^ word;
}

static inline uint32_t glbk_ism__hash_combine(uint32_t a, uint32_t b)
{
    return glbk_ism__hash32(a + 0x9e3779b9u * glbk_ism__hash32(b));
}

/* Returns the upper 24 bits as a number in [0, 1). Every such value is a float; the largest is 1 - 2^-24. */
static inline float glbk_ism__to_unit(uint32_t bits) { return (float)(bits >> 8) * (1.0f / 16777216.0f); }

/* ==== src/shared/gl_memory.h ==== */

/* unit gl_memory, needs mem: the allocator of a glbk_context (gl_backend.h) */

static inline glbk_ism__allocator glbk_ism__memory(const glbk_context *ctx)
{
    const glbk_allocator *a = &ctx->system.allocator;
    return glbk_ism__allocator_make(a->alloc_fn, a->free_fn, a->user);
}

/* ==== GLSL of src/gl_ism ==== */


static const struct { char facts[24];
    char s0[3553]; char end; } glbk__ism_files_lib_cohsm_math_glsl GLBK__TIGHT = {
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

static const struct { char facts[58];
    char s0[1975]; char end; } glbk__glsl_lib_ism_access_glsl GLBK__TIGHT = {
    "lib/ism_access.glsl\0" "table ism_map ism_floats ism_frame" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n#define ISM_F glbk_ism_frame\n"
    "#define ISM_TEXEL(i) ISM_FLOATS(glbk_ism_vpls, glbk_table_at(i))\n"
    "\nstruct ism_grid{\n"
    "float exponent;\n"
    "vec4 across,down;\n"
    "};\n"
    "\nstruct ism_vpl{\n"
    "vec3 position;\n"
    "vec3 normal;\n"
    "vec3 flux;\n"
    "vec3 axis;\n"
    "float exponent;\n"
    "float edge;\n"
    "float reach;\n"
    "bool sky;\n"
    "uint window;\n"
    "ism_grid grid;\n"
    "mat3 basis;\n"
    "};\n"
    "\n\nism_grid ism_grid_of(float exponent,uint window)\n"
    "{\n"
    "ism_grid g;\n"
    "g.exponent=exponent;\n"
    "ism_axes(window,ISM_F.tile_side,ISM_F.window_rim,g.across,g.down);\n"
    "return g;\n"
    "}\n"
    "\n\nism_vpl ism_read_vpl(uint v)\n"
    "{\n"
    "ism_vpl l;\n"
    "vec4 a=ISM_TEXEL(4u*v),b=ISM_TEXEL(4u*v+1u);\n"
    "vec4 c=ISM_TEXEL(4u*v+2u),d=ISM_TEXEL(4u*v+3u);\n"
    "l.position=a.xyz;\n"
    "l.sky=a.w<.0;\n"
    "l.exponent=l.sky?1.:a.w;\n"
    "l.normal=b.xyz;\n"
    "l.edge=b.w;\n"
    "l.flux=c.xyz;\n"
    "l.reach=ISM_F.near_point_count>0u?c.w:.0;\n"
    "l.axis=l.exponent!=1.?d.xyz:l.normal;\n"
    "l.window=uint(d.w);\n"
    "l.grid=ism_grid_of(a.w,l.window);\n"
    "bool about_axis=ism_projection_of(l.exponent)==ISM_PROJECTION_LOBE&&!l.sky;\n"
    "l.basis=ism_basis_of(about_axis?l.axis:l.normal);\n"
    "return l;\n"
    "}\n"
    "\n\nivec2 ism_tile_at(uint v)\n"
    "{\n"
    "uint tiles=ISM_F.tiles_across;\n"
    "uint row=uint((float(v)+.5)/float(tiles));\n"
    "return ivec2(v-row*tiles,row)*int(ISM_F.tile_side);\n"
    "}\n"
    "\n\nuint ism_tile_of(ivec2 at)\n"
    "{\n"
    "ivec2 tile=at/int(ISM_F.tile_side);\n"
    "return uint(tile.y)*ISM_F.tiles_across+uint(tile.x);\n"
    "}\n"
    "\n\nvec2 ism_to_tile(ism_grid g,vec2 uv)\n"
    "{\n"
    "float size=float(ISM_F.tile_side),rim=float(ISM_F.window_rim);\n"
    "return vec2(ism_zoom_axis(g.across,size,rim,uv.x),ism_zoom_axis(g.down,size,rim,uv.y));\n"
    "}\n"
    "\n\nvec2 ism_from_tile(ism_grid g,vec2 at)\n"
    "{\n"
    "float size=float(ISM_F.tile_side),rim=float(ISM_F.window_rim);\n"
    "return vec2(ism_unzoom_axis(g.across,size,rim,at.x),ism_unzoom_axis(g.down,size,rim,at.y));\n"
    "}\n"
    "\n\nism_grid ism_read_grid(uint v)\n"
    "{\n"
    "return ism_grid_of(ISM_TEXEL(4u*v).w,uint(ISM_TEXEL(4u*v+3u).w));\n"
    "}\n"
    "\n\n\nvec3 ism_texel_direction(ism_grid g,ivec2 texel)\n"
    "{\n"
    "vec2 uv=ism_from_tile(g,vec2(texel)+.5);\n"
    "if(g.exponent<.0)return vec3(2.*uv-1.,1.);\n"
    "return ism_map_direction(ism_projection_of(g.exponent),g.exponent,uv);\n"
    "}\n", 0
};

static const struct { char facts[26];
    char s0[1401]; char end; } glbk__glsl_lib_ism_bindings_glsl GLBK__TIGHT = {
    "lib/ism_bindings.glsl\0" "" "\0" "" "\0"
    "" "\0" "",
    "\nuniform usampler2DArray glbk_ism_vpls,glbk_ism_surfels;\n"
    "uniform sampler2DArray glbk_ism_albedos;\n"
    "uniform usampler2DArray glbk_ism_triangles;\n"
    "uniform sampler2DArray glbk_ism_positions;\n"
    "uniform usampler2D glbk_ism_atlas;\n"
    "uniform glbk_color_sampler glbk_ism_planes;\n"
    "uniform usampler2D glbk_ism_below,glbk_ism_hits;\n"
    "uniform glbk_color_sampler glbk_ism_light;\n"
    "uniform usampler2D glbk_ism_pull1,glbk_ism_pull2,glbk_ism_pull3;\n"
    "uniform usampler2DArray glbk_ism_texels,glbk_ism_near;\n"
    "uniform usampler2D glbk_ism_near_order,glbk_ism_near_facts;\n"
    "uniform usampler2DArray glbk_ism_drawn,glbk_ism_box;\n"
    "uniform usampler2D glbk_ism_effects,glbk_ism_summed,glbk_ism_importances,\n"
    "glbk_ism_row_sums0,glbk_ism_row_sums1,glbk_ism_row_sums2,glbk_ism_column_sums0,\n"
    "glbk_ism_column_sums1,glbk_ism_column_sums2;\n"
    "uniform usampler2DArray glbk_ism_sights;\n"
    "uniform usampler2D glbk_ism_windows,glbk_ism_values;\n"
    "uniform usampler2DArray glbk_ism_clusters;\n"
    "uniform usampler2D glbk_ism_shares,glbk_ism_gone,glbk_ism_runs0,glbk_ism_runs1,\n"
    "glbk_ism_runs2,glbk_ism_runs3,glbk_ism_effect_totals,glbk_ism_totals,\n"
    "glbk_ism_runs4,glbk_ism_counts,glbk_ism_receivers,glbk_ism_masses,glbk_ism_sizes;\n"
    "#if __VERSION__ >= 430\n"
    "layout(rgba32f,binding=0)writeonly uniform image2D glbk_ism_planes_out;\n"
    "layout(r32ui,binding=1)writeonly uniform uimage2D glbk_ism_atlas_out;\n"
    "layout(rgba32f,binding=2)writeonly uniform image2D glbk_ism_light_out;\n"
    "#endif\n", 0
};

static const struct { char facts[33];
    char s0[751]; char end; } glbk__glsl_lib_ism_blur_glsl GLBK__TIGHT = {
    "lib/ism_blur.glsl\0" "ism_gbuffer" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\nbool ism_neighbour(ivec2 at,out ism_receiver r,out vec4 light);\n"
    "\n\nvec4 ism_smooth(ivec2 at,ism_receiver c)\n"
    "{\n"
    "int r=int(glbk_ism_view.interleave)/2;\n"
    "vec4 sum=vec4(.0);\n"
    "float weights=.0;\n"
    "for(int j=-r;j<=r;j++)\n"
    "for(int i=-r;i<=r;i++){\n"
    "ism_receiver o;\n"
    "vec4 light;\n"
    "if(!ism_neighbour(at+ivec2(i,j),o,light))continue;\n"
    "vec3 d=o.p-c.p;\n"
    "float facing=max(dot(c.n,o.n),.0),off=abs(dot(c.n,d))+abs(dot(o.n,d));\n"
    "float weight=(abs(i)==r?.5:1.)*(abs(j)==r?.5:1.)*facing*facing;\n"
    "if(off>.0)weight*=max(1.-off/sqrt(dot(d,d)),.0);\n"
    "sum+=weight*light;\n"
    "weights+=weight;\n"
    "}\n"
    "return weights>.0?sum/weights:sum;\n"
    "}\n"
    "\n\nvec4 ism_finished(ivec2 at,ism_receiver c)\n"
    "{\n"
    "if(glbk_ism_view.interleave>1u)return ism_smooth(at,c);\n"
    "return glbk_unpack(texelFetch(glbk_ism_light,at,0));\n"
    "}\n", 0
};

static const struct { char facts[47];
    char s0[90]; char end; } glbk__glsl_lib_ism_choice_glsl GLBK__TIGHT = {
    "lib/ism_choice.glsl\0" "ism_floats ism_choosing" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n#define ISM_C glbk_ism_choosing\n"
    "ivec2 ism_cell_of(uint i){return ivec2(i&255u,i>>8);}\n", 0
};

static const struct { char facts[43];
    char s0[367]; char end; } glbk__glsl_lib_ism_choosing_glsl GLBK__TIGHT = {
    "lib/ism_choosing.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_ism_choosing",
    "\nlayout(std140)uniform glbk_ism_choosing_block{\n"
    "mat4 world_to_clip;\n"
    "uint width,face_height,vpl_count,inter_texel;\n"
    "float shift;\n"
    "uint shift_bits,columns,pace,value_count,first_column,view_width,view_height,\n"
    "grid_side,guided,by_effect,by_mean,blur_radius,seed;\n"
    "float flux_factor;\n"
    "uint windows,near_point_count,first_sphere,first_near_point,unused0;\n"
    "}glbk_ism_choosing;\n", 0
};

static const struct { char facts[43];
    char s0[364]; char end; } glbk__glsl_lib_ism_corners_glsl GLBK__TIGHT = {
    "lib/ism_corners.glsl\0" "table ism_bindings" "\0" "" "\0"
    "" "\0" "",
    "\n\nstruct ism_corners{vec3 a,b,c;};\n"
    "\nvec3 ism_vertex(uint i){return texelFetch(glbk_ism_positions,glbk_table_at(i),0).xyz;}\n"
    "\nism_corners ism_read_corners(uint t)\n"
    "{\n"
    "uvec3 i=texelFetch(glbk_ism_triangles,glbk_table_at(t),0).xyz;\n"
    "return ism_corners(ism_vertex(i.x),ism_vertex(i.y),ism_vertex(i.z));\n"
    "}\n"
    "\n\nvec3 ism_normal2(ism_corners p){return cross(p.b-p.a,p.c-p.a);}\n", 0
};

static const struct { char facts[35];
    char s0[251]; char end; } glbk__glsl_lib_ism_densities_glsl GLBK__TIGHT = {
    "lib/ism_densities.glsl\0" "ism_fold" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\nfloat ism_density(vec2 sizes)\n"
    "{\n"
    "vec2 all=ISM_FLOATS(glbk_ism_totals,ivec2(0)).xy;\n"
    "float by_area=1.,by_solid=.0;\n"
    "if(all.y>.0){\n"
    "by_area=ISM_S.area_share;\n"
    "by_solid=(1.-by_area)/all.y;\n"
    "}\n"
    "return sizes.x*(by_area/max(all.x,1e-37))+sizes.y*by_solid;\n"
    "}\n", 0
};

static const struct { char facts[32];
    char s0[3447]; char end; } glbk__glsl_lib_ism_disc_glsl GLBK__TIGHT = {
    "lib/ism_disc.glsl\0" "ism_access" "\0" "" "\0"
    "" "\0" "",
    "\n\n#define ISM_DEEPEST 1.84467429e19\n"
    "\nstruct ism_surfel{\n"
    "vec3 at;\n"
    "vec3 g;\n"
    "float radius2;\n"
    "float depth;\n"
    "vec2 uv;\n"
    "vec4 cut1,cut2;\n"
    "\nivec4 box;\n"
    "};\n"
    "\n\n\nbool ism_place_surfel(ism_vpl l,vec3 p,vec3 normal,float area,inout ism_surfel s)\n"
    "{\n"
    "mat3 basis=l.basis;\n"
    "vec3 n=normal*basis;\n"
    "s.radius2=area*(1./COHSM_PI);\n"
    "if(l.sky){\n"
    "vec3 o=(p-ISM_F.sphere.xyz)*basis;\n"
    "float r=ISM_F.sphere.w,slope=abs(n.z)>.05?1./n.z:.0;\n"
    "s.depth=o.z+r;\n"
    "s.uv=.5*o.xy/r+.5;\n"
    "s.at=vec3(o.xy,s.depth);\n"
    "s.g=vec3(-n.xy*slope*r,s.depth+dot(n.xy,o.xy)*slope);\n"
    "return fract(s.uv)==s.uv;\n"
    "}\n"
    "vec3 o=(p-l.position)*basis;\n"
    "float d2=dot(o,o),along=dot(n,o);\n"
    "s.depth=sqrt(d2);\n"
    "s.at=o;\n"
    "s.g=o/d2;\n"
    "if(!(d2>1e-30)||!(o.z>1e-3*s.depth))return false;\n"
    "\n\nbool lobe=ism_projection_of(l.exponent)==ISM_PROJECTION_LOBE;\n"
    "if(lobe&&!(abs(dot(basis*o,l.normal))>1e-3*s.depth))return false;\n"
    "s.radius2=min(s.radius2,(along>.0&&s.cut1.w<-1.?.04:1.)*d2);\n"
    "if(abs(along)>1e-3*s.depth)s.g=n/along;\n"
    "if(!ism_map_coordinates(ism_projection_of(l.exponent),l.exponent,o/s.depth,s.uv))return false;\n"
    "\n\nif(s.cut1.w<-1.){\n"
    "float away=1.+sqrt(s.radius2)/s.depth;\n"
    "s.at*=away;\n"
    "s.g/=away;\n"
    "s.radius2*=away*away;\n"
    "s.depth*=away;\n"
    "}\n"
    "return true;\n"
    "}\n"
    "\n\n\nfloat ism_texels_per_unit(ism_vpl l)\n"
    "{\n"
    "float size=float(ISM_F.tile_side);\n"
    "uint p=ism_projection_of(l.exponent);\n"
    "if(l.sky)return .5*size/ISM_F.sphere.w;\n"
    "if(p==ISM_PROJECTION_PARABOLOID)return .5*size;\n"
    "return .9*size*(p==ISM_PROJECTION_LOBE?sqrt(.5*(l.exponent+1.)):1.);\n"
    "}\n"
    "\n\n\nbool ism_dither(uvec2 tile,float opacity)\n"
    "{\n"
    "uint i=(tile.y&1u)*2u+(tile.x&1u);\n"
    "return opacity>(i==0u?.125:i==1u?.625:i==2u?.875:.375);\n"
    "}\n"
    "\n\nvec3 ism_corner(uint vertex){return texelFetch(glbk_ism_positions,glbk_table_at(vertex),0).xyz;}\n"
    "\n\nbool ism_box_surfel(ism_vpl l,inout ism_surfel s)\n"
    "{\n"
    "int size=int(ISM_F.tile_side);\n"
    "float most=float(size),reach=sqrt(s.radius2)*ism_texels_per_unit(l)/(l.sky?1.:s.depth);\n"
    "if(!(reach>.0))return false;\n"
    "reach=min(reach,most);\n"
    "if(l.window==0u){\n"
    "s.box=ivec4(max(s.uv*most-reach,.0),min(ivec2(s.uv*most+reach),size-1));\n"
    "}else{\n"
    "vec2 first=ism_to_tile(l.grid,s.uv-reach/most);\n"
    "vec2 last=ism_to_tile(l.grid,s.uv+reach/most);\n"
    "s.box=ivec4(max(first,.0),min(ivec2(last),size-1));\n"
    "}\n"
    "return true;\n"
    "}\n"
    "\n\n\nbool ism_surfel_of(uint index,uint v,ism_vpl l,out ism_surfel s)\n"
    "{\n"
    "uvec4 surfel=texelFetch(glbk_ism_surfels,glbk_table_at(index),0);\n"
    "float share=uintBitsToFloat(surfel.w);\n"
    "if(!(share>.0)||surfel.x>=ISM_F.triangle_count)return false;\n"
    "uvec4 t=texelFetch(glbk_ism_triangles,glbk_table_at(surfel.x),0);\n"
    "uvec2 tile=uvec2(v%ISM_F.tiles_across,v/ISM_F.tiles_across);\n"
    "if(!ism_dither(tile,uintBitsToFloat(t.w)))return false;\n"
    "vec3 p=ism_corner(t.x),e1=ism_corner(t.y)-p,e2=ism_corner(t.z)-p,n=cross(e1,e2);\n"
    "float length2=dot(n,n),size=sqrt(length2);\n"
    "if(!(length2>.0)||!cohsm_finite(length2))return false;\n"
    "vec2 b=uintBitsToFloat(surfel.yz);\n"
    "float area=ISM_F.splat_scale*share*.5*size;\n"
    "p+=e1*b.x+e2*b.y;\n"
    "s.cut1=s.cut2=vec4(-2.);\n"
    "if(share<1.){\n"
    "s.cut1=vec4((cross(e2,n)/length2)*l.basis,b.x);\n"
    "s.cut2=vec4((cross(n,e1)/length2)*l.basis,b.y);\n"
    "area*=6.;\n"
    "}\n"
    "return ism_place_surfel(l,p,n/size,area,s)&&ism_box_surfel(l,s);\n"
    "}\n"
    "\n\n\nfloat ism_meet(bool sky,ism_surfel s,vec3 w,float limit)\n"
    "{\n"
    "float t=ism_plane_depth(sky,s.g,w);\n"
    "if(!(t>.0&&t<=min(limit,ISM_DEEPEST)))return ISM_FAR;\n"
    "vec3 d=(sky?vec3(w.xy*ISM_F.sphere.w,t):w*t)-s.at;\n"
    "if(!(dot(d,d)<=s.radius2))return ISM_FAR;\n"
    "vec2 b=vec2(s.cut1.w+dot(d,s.cut1.xyz),s.cut2.w+dot(d,s.cut2.xyz));\n"
    "return s.cut1.w>-1.&&!(min(b.x,b.y)>=-1e-4&&b.x+b.y<=1.0001)?ISM_FAR:t;\n"
    "}\n", 0
};

static const struct { char facts[32];
    char s0[1143]; char end; } glbk__glsl_lib_ism_fill_glsl GLBK__TIGHT = {
    "lib/ism_fill.glsl\0" "ism_access" "\0" "" "\0"
    "" "\0" "",
    "\n\n#define ISM_HOLE 2\n"
    "\n\nvec4 ism_plane_at(ivec2 at){return glbk_unpack(texelFetch(glbk_ism_planes,at,0));}\n"
    "\n\n\nuint ism_quadrant(ivec2 d)\n"
    "{\n"
    "return d.x>0&&d.y>=0?1u:d.x<=0&&d.y>0?2u:d.x<0?4u:8u;\n"
    "}\n"
    "\n\n\nuint ism_sector(ivec2 d)\n"
    "{\n"
    "ivec2 a=abs(d);\n"
    "if(12*a.y<5*a.x)return d.x>0?1u:16u;\n"
    "if(12*a.x<5*a.y)return d.y>0?4u:64u;\n"
    "return d.x>0?(d.y>0?2u:128u):d.y>0?8u:32u;\n"
    "}\n"
    "\n\nuint ism_turn(uint sectors,int by){return(sectors<<by|sectors>>(8-by))&255u;}\n"
    "\n\n\n\nbool ism_surrounded(uint found,uint close,uint beyond)\n"
    "{\n"
    "uint along=(ism_turn(beyond,1)|ism_turn(beyond,7))&~beyond;\n"
    "if(((found|ism_turn(close,1)|ism_turn(close,7))&along)==along)found|=beyond;\n"
    "uint open=~found&255u;\n"
    "return(open&ism_turn(open,1)&ism_turn(open,2))==0u;\n"
    "}\n"
    "\n\n\n\n\nuint ism_pull(int level,ivec2 cell,uvec4 parts)\n"
    "{\n"
    "int size=int(ISM_F.tile_side),least=0x7fffffff;\n"
    "ivec2 middle=(2*cell+1)<<level;\n"
    "uint result=0u;\n"
    "for(int k=0;k<4;k++){\n"
    "ivec2 texel=2*cell+ivec2(k&1,k>>1);\n"
    "int at=int(parts[k]);\n"
    "if(at==0)continue;\n"
    "if(level==1)at=texel.y*size+texel.x+1;\n"
    "ivec2 d=2*ivec2((at-1)%size,(at-1)/size)+1-middle;\n"
    "if(d.x*d.x+d.y*d.y<least){\n"
    "least=d.x*d.x+d.y*d.y;\n"
    "result=uint(at);\n"
    "}\n"
    "}\n"
    "return result;\n"
    "}\n", 0
};

static const struct { char facts[36];
    char s0[107]; char end; } glbk__glsl_lib_ism_floats_glsl GLBK__TIGHT = {
    "lib/ism_floats.glsl\0" "ism_bindings" "\0" "" "\0"
    "" "\0" "",
    "\n\n#define ISM_FLOATS(t, at) uintBitsToFloat(texelFetch(t, at, 0))\n"
    "#define ISM_HERE ivec2(gl_FragCoord.xy)\n", 0
};

static const struct { char facts[47];
    char s0[1013]; char end; } glbk__glsl_lib_ism_fold_glsl GLBK__TIGHT = {
    "lib/ism_fold.glsl\0" "ism_floats ism_scattering" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n#define ISM_S glbk_ism_scattering\n"
    "\n\n\nivec2 ism_fold(uint i,uint count,uint row)\n"
    "{\n"
    "return ivec2(i&1023u,row*((count+1023u)>>10)+(i>>10));\n"
    "}\n"
    "\n\nuvec2 ism_unfold(uint count)\n"
    "{\n"
    "uint height=(count+1023u)>>10,row=uint(gl_FragCoord.y/float(height));\n"
    "return uvec2((uint(gl_FragCoord.y)-row*height)*1024u+uint(gl_FragCoord.x),row);\n"
    "}\n"
    "\nfloat ism_folded(usampler2D from,uint i,uint count,uint row)\n"
    "{\n"
    "return ISM_FLOATS(from,ism_fold(i,count,row)).x;\n"
    "}\n"
    "\nvec2 ism_folded2(usampler2D from,uint i,uint count)\n"
    "{\n"
    "return ISM_FLOATS(from,ism_fold(i,count,0u)).xy;\n"
    "}\n"
    "\n\nuint ism_blocks(uint count){return(count+31u)>>5;}\n"
    "\n\n\n\nuint ism_find_in_block(usampler2D sums,uint row,uint block,uint count,inout float x)\n"
    "{\n"
    "uint lo=32u*block,hi=min(lo+32u,count)-1u;\n"
    "float before=.0;\n"
    "x=min(x,.99999994*ism_folded(sums,hi,count,row));\n"
    "for(int k=0;k<5;k++){\n"
    "uint middle=(lo+hi)>>1;\n"
    "float sum=ism_folded(sums,middle,count,row);\n"
    "bool past=lo<hi&&!(sum>x);\n"
    "if(past){\n"
    "lo=middle+1u;\n"
    "before=sum;\n"
    "}\n"
    "if(!past)hi=max(middle,lo);\n"
    "}\n"
    "x-=before;\n"
    "return lo;\n"
    "}\n", 0
};

static const struct { char facts[37];
    char s0[305]; char end; } glbk__glsl_lib_ism_frame_glsl GLBK__TIGHT = {
    "lib/ism_frame.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_ism_frame",
    "\nlayout(std140)uniform glbk_ism_frame_block{\n"
    "uint vpl_count,tile_side,tiles_across,surfel_count,vpl_capacity,\n"
    "phase_surfel_count,fill_levels,triangle_count;\n"
    "vec4 sphere;\n"
    "float splat_scale;\n"
    "uint window_rim,near_point_count,first_sphere,first_near_point,first_surfel,\n"
    "bounce_side,unused0;\n"
    "}glbk_ism_frame;\n", 0
};

static const struct { char facts[65];
    char s0[317]; char end; } glbk__glsl_lib_ism_gbuffer_glsl GLBK__TIGHT = {
    "lib/ism_gbuffer.glsl\0" "cohsm_math ism_bindings gbuffer ism_view" "\0" "" "\0"
    "" "\0" "",
    "\n\nstruct ism_receiver{\n"
    "vec3 p;\n"
    "vec3 n,ng;\n"
    "};\n"
    "\n\nivec2 ism_picture_side(){return ivec2(glbk_ism_view.width,glbk_ism_view.height);}\n"
    "\n\n\nbool ism_read_receiver(ivec2 at,out ism_receiver r)\n"
    "{\n"
    "glbk_point p;\n"
    "bool seen=glbk_read_point(at,p);\n"
    "r.p=p.position;\n"
    "r.n=p.normal;\n"
    "r.ng=p.geometric;\n"
    "return seen&&cohsm_finite3(r.p);\n"
    "}\n", 0
};

static const struct { char facts[22];
    char s0[303]; char end; } glbk__glsl_lib_ism_hash_glsl GLBK__TIGHT = {
    "lib/ism_hash.glsl\0" "" "\0" "" "\0"
    "" "\0" "",
    "\n\nuint ism_hash32(uint x)\n"
    "{\n"
    "uint state=x*747796405u+2891336453u;\n"
    "uint word=((state>>((state>>28)+4u))^state)*277803737u;\n"
    "return word>>22^word;\n"
    "}\n"
    "\nuint ism_hash_combine(uint a,uint b){return ism_hash32(a+0x9e3779b9u*ism_hash32(b));}\n"
    "\n\nfloat ism_to_unit(uint bits){return float(bits>>8)*(1./16777216.);}\n", 0
};

static const struct { char facts[31];
    char s0[575]; char end; } glbk__glsl_lib_ism_holes_glsl GLBK__TIGHT = {
    "lib/ism_holes.glsl\0" "ism_fill" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\nfloat ism_depth(ivec2 at);\n"
    "\n\n\nbool ism_hole(ism_grid grid,ivec2 at,float c)\n"
    "{\n"
    "int size=int(ISM_F.tile_side);\n"
    "ivec2 local=at&(size-1);\n"
    "vec3 w=ism_texel_direction(grid,local);\n"
    "uint found=0u;\n"
    "for(int dy=-ISM_HOLE;dy<=ISM_HOLE;dy++)\n"
    "for(int dx=-ISM_HOLE;dx<=ISM_HOLE;dx++){\n"
    "ivec2 d=ivec2(dx,dy),there=local+d;\n"
    "if(clamp(there,0,size-1)!=there){\n"
    "found|=ism_quadrant(d);\n"
    "continue;\n"
    "}\n"
    "float depth=ism_depth(at+d);\n"
    "if(!(depth<.9*c))continue;\n"
    "float t=ism_plane_depth(grid.exponent<.0,ism_plane_at(at+d).xyz,w);\n"
    "if(t>.5*depth&&t<.95*c)found|=ism_quadrant(d);\n"
    "}\n"
    "return found==15u;\n"
    "}\n", 0
};

static const struct { char facts[37];
    char s0[1278]; char end; } glbk__glsl_lib_ism_inter_texel_glsl GLBK__TIGHT = {
    "lib/ism_inter_texel.glsl\0" "ism_pvpl" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\n\nfloat ism_inter_texel(ivec2 texel,vec2 fraction,inout vec3 position,inout vec3 normal)\n"
    "{\n"
    "vec2 s=fraction-.5,from,to;\n"
    "vec3 p0=position,n0=normal,sum=vec3(.0),mixed=vec3(.0),offsets[4],normals[4];\n"
    "float weights=.0,shares[4],behind=.0,spacing=.0;\n"
    "int height=int(ISM_C.face_height),face=texel.y/height;\n"
    "ivec2 lowest=ivec2(0,face*height);\n"
    "ivec2 highest=lowest+ivec2(int(ISM_C.width),height)-1;\n"
    "ivec2 beside=1-2*ivec2(lessThan(s,vec2(.0)));\n"
    "bool known=ism_to_clip(p0,from);\n"
    "for(int k=0;k<4;k++){\n"
    "ivec2 pick=ivec2(k&1,k>>1),at=texel+pick*beside,kept=clamp(at,lowest,highest);\n"
    "vec2 share=mix(1.-abs(s),abs(s),vec2(pick));\n"
    "float w=share.x*share.y;\n"
    "ism_pvpl q=ism_read_pvpl(kept);\n"
    "vec3 d=q.position-p0;\n"
    "bool used=at==kept&&q.luminance>.0;\n"
    "if(k>0)used=used&&dot(n0,q.normal)>.9&&abs(dot(n0,d))<=.1*length(d);\n"
    "if(k>0&&known&&ism_to_clip(q.position,to))w*=cohsm_exp(-50.*dot(to-from,to-from));\n"
    "if(!used){\n"
    "w=.0;\n"
    "d=vec3(.0);\n"
    "q.normal=vec3(.0);\n"
    "}\n"
    "spacing=max(spacing,length(d));\n"
    "sum+=w*d;\n"
    "mixed+=w*q.normal;\n"
    "weights+=w;\n"
    "offsets[k]=d;\n"
    "normals[k]=q.normal;\n"
    "shares[k]=w;\n"
    "}\n"
    "if(weights>.0){\n"
    "normal=normalize(mixed);\n"
    "sum/=weights;\n"
    "for(int k=0;k<4;k++)\n"
    "behind+=shares[k]/weights*dot(normals[k],offsets[k]-sum)*dot(normals[k],normal);\n"
    "position=p0+sum+max(behind,.0)*normal;\n"
    "}\n"
    "return spacing;\n"
    "}\n", 0
};

static const struct { char facts[42];
    char s0[3992]; char s1[3662]; char end; } glbk__glsl_lib_ism_light_glsl GLBK__TIGHT = {
    "lib/ism_light.glsl\0" "ism_access ism_view" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\n\n\n#ifndef ISM_NEAR\n"
    "#define ISM_NEAR 6\n"
    "#elif ISM_NEAR == 0\n"
    "#undef ISM_NEAR\n"
    "#define ISM_NEAR 6\n"
    "#endif\n"
    "#define ISM_GRAZING 1e-4\n"
    "\n\nfloat ism_luminance(vec3 f){return(f.x+f.y+f.z)*(1./3.);}\n"
    "\n\n\n\n#ifdef GLBK_OWN_VISIBLE\n"
    "float glbk_visible(uint vpl,vec3 position,vec3 geometric_normal);\n"
    "float ism_visible(uint v,ism_vpl l,vec3 p,vec3 ng,float bias){return glbk_visible(v,p,ng);}\n"
    "#else\n"
    "float ism_visible(uint v,ism_vpl l,vec3 p,vec3 ng,float bias)\n"
    "{\n"
    "mat3 basis=l.basis;\n"
    "int size=int(ISM_F.tile_side);\n"
    "ivec2 tile=ism_tile_at(v),texel;\n"
    "vec3 n=ng*basis;\n"
    "if(l.sky){\n"
    "vec3 o=(p-ISM_F.sphere.xyz)*basis;\n"
    "float r=ISM_F.sphere.w,depth=o.z+r;\n"
    "vec2 uv=.5*o.xy/r+.5;\n"
    "if(!(n.z<-ISM_GRAZING))return .0;\n"
    "if(fract(uv)!=uv)return 1.;\n"
    "texel=min(ivec2(ism_to_tile(l.grid,uv)),size-1);\n"
    "vec2 d=(2.*ism_from_tile(l.grid,vec2(texel)+.5)-1.)*r-o.xy;\n"
    "if(abs(n.z)>.1)depth-=dot(n.xy,d)/n.z;\n"
    "return depth-bias*r<=ISM_FLOATS(glbk_ism_atlas,tile+texel).x?1.:.0;\n"
    "}\n"
    "vec3 o=(p-l.position)*basis;\n"
    "float d=sqrt(dot(o,o));\n"
    "vec2 uv;\n"
    "if(!(o.z>.0)||!(d>.0))return 1.;\n"
    "if(!(dot(n,o)<-ISM_GRAZING*d))return .0;\n"
    "if(!ism_map_coordinates(ism_projection_of(l.exponent),l.exponent,o/d,uv))return 1.;\n"
    "texel=min(ivec2(ism_to_tile(l.grid,uv)),size-1);\n"
    "float t=ISM_FLOATS(glbk_ism_atlas,tile+texel).x;\n"
    "if(d*(1.-bias)<=t&&t>=2.*d)return 1.;\n"
    "float along=dot(n,ism_texel_direction(l.grid,texel));\n"
    "along=along!=.0?dot(n,o)/along:d;\n"
    "if(along>.5*d&&along<2.*d)d=along;\n"
    "return d*(1.-bias)<=t?1.:.0;\n"
    "}\n"
    "#endif\n"
    "\n\nfloat ism_edge(vec3 n,vec3 a,vec3 b)\n"
    "{\n"
    "vec3 c=cross(b,a);\n"
    "float size=sqrt(dot(c,c));\n"
    "return size>.0?cohsm_atan2(size,dot(a,b))*(dot(n,c)/size):.0;\n"
    "}\n"
    "\n\n\n\nfloat ism_form_factor(vec3 n,vec3 d,vec3 x,vec3 y,out float share)\n"
    "{\n"
    "vec3 leave=d,come=d,area=vec3(.0);\n"
    "float sum=.0;\n"
    "bool cut=false;\n"
    "for(int i=0;i<4;i++){\n"
    "vec3 a=d+(i==0||i==3?-x:x)+(i<2?-y:y);\n"
    "vec3 b=d+(i<2?x:-x)+(i==0||i==3?-y:y);\n"
    "float ha=dot(n,a),hb=dot(n,b);\n"
    "if(!(ha>.0)&&!(hb>.0))continue;\n"
    "if((ha>.0)!=(hb>.0)){\n"
    "vec3 at=a+(b-a)*(ha/(ha-hb));\n"
    "cut=true;\n"
    "if(ha>.0)b=leave=at;\n"
    "else a=come=at;\n"
    "}\n"
    "sum+=ism_edge(n,a,b);\n"
    "area+=cross(a-d,b-d);\n"
    "}\n"
    "if(cut){\n"
    "sum+=ism_edge(n,leave,come);\n"
    "area+=cross(leave-d,come-d);\n"
    "}\n"
    "share=sqrt(dot(area,area))/(8.*sqrt(dot(x,x)*dot(y,y)));\n"
    "return sum*.159154943;\n"
    "}\n"
    "\n\n\nfloat ism_patch_kernel(mat3 basis,float edge,vec3 d,vec3 n,float point,out float square)\n"
    "{\n"
    "float share,form=ism_form_factor(n,d,basis[0]*(.5*edge),basis[1]*(.5*edge),share);\n"
    "float facing=-2.*dot(n,basis[2]);\n"
    "square=form=form>.0&&share>.0?form*COHSM_PI/(edge*edge*share):.0;\n"
    "if(!(facing>.0)||!(form>point))return form;\n"
    "return form+min(facing,1.)*(point-form);\n"
    "}\n"
    "\n\nfloat ism_sphere_kernel(vec3 d,vec3 normal,vec3 n,float edge)\n"
    "{\n"
    "float r2=edge*edge*(1./COHSM_PI),d2=dot(d,d),sum=.0;\n"
    "float least=d2>r2?sqrt(1.-r2/d2):-1.;\n"
    "mat3 basis=ism_basis_of(cohsm_normalize(d));\n"
    "for(int k=0;k<16;k++){\n"
    "float cosine=1.-(1.-least)*(float(k)+.5)*(1./16.);\n"
    "float sine=sqrt(1.-cosine*cosine);\n"
    "vec2 sc=cohsm_sincos(2.39996323*float(k));\n"
    "vec3 w=basis*vec3(sine*sc.y,sine*sc.x,cosine);\n"
    "float a=dot(n,w),b=-dot(normal,w);\n"
    "if(a>.0&&b>.0)sum+=a*b;\n"
    "}\n"
    "return sum*(1./16.)*2.*(1.-least)/r2;\n"
    "}\n"
    "\n\nfloat ism_nearness(float d2,float reach)\n"
    "{\n"
    "float r2=reach*reach,h=2.*(r2-d2);\n"
    "return!(h>.0)?.0:h<r2?h/r2:1.;\n"
    "}\n"
    "\n\n\nfloat ism_kernel(ism_vpl l,vec3 p,vec3 n,float most,out float plain)\n"
    "{\n"
    "if(l.sky)return plain=max(dot(l.position,n)*COHSM_PI,.0);\n"
    "vec3 d=l.position-p;\n"
    "float d2=dot(d,d),a=dot(n,d),b=-dot(l.normal,d),area=l.edge*l.edge;\n"
    "plain=a>.0&&b>.0?a*b/(d2*d2+1e-37):.0;\n"
    "if(l.exponent!=1.){\n"
    "float c=-dot(l.axis,d)/sqrt(d2);\n"
    "plain=.0;\n"
    "if(c>.0&&a>.0)\n"
    "plain=.5*(l.exponent+1.)*cohsm_pow(c,l.exponent)*a/(sqrt(d2)*d2);\n"
    "area=.0;\n"
    "}\n"
    "if(!(plain>.0))return .0;\n"
    "#if ISM_NEAR == 1\n"
    "if(!(area>.0&&d2<9.*area))return plain;\n"
    "float point=plain;\n"
    "return ism_patch_kernel(l.basis,l.edge,d,n,point,plain);\n"
    "#elif ISM_NEAR == 6\n"
    "float share=1.-ism_nearness(d2,l.reach),k=plain,point=plain;\n"
    "if(!(share>.0))return plain=.0;\n"
    "if(area>.0&&d2<9.*area)k=ism_patch_kernel(l.basis,l.edge,d,n,point,plain);\n"
    "plain*=share;\n"
    "return k*share;\n"
    "#elif ISM_NEAR == 2\n",
    "return area>.0&&d2<16.*area?ism_sphere_kernel(d,l.normal,n,l.edge):plain;\n"
    "#elif ISM_NEAR == 3\n"
    "return min(plain,most);\n"
    "#else\n"
    "return plain;\n"
    "#endif\n"
    "}\n"
    "\n\n\nvoid ism_add(inout vec4 sum,uint v,ism_vpl l,vec3 p,vec3 n,vec3 ng,float most)\n"
    "{\n"
    "float plain,k=ism_kernel(l,p,n,most,plain),power=ism_luminance(l.flux);\n"
    "#if ISM_NEAR == 4\n"
    "if(k*power>most)k=most/power;\n"
    "#endif\n"
    "if(!(k>.0))return;\n"
    "if(glbk_ism_view.no_maps==0u)k*=ism_visible(v,l,p,ng,glbk_ism_view.bias);\n"
    "sum.xyz+=k*l.flux;\n"
    "if(k>.0)sum.w+=max(plain-k,.0)*power;\n"
    "}\n"
    "\n\nfloat ism_unshadowed(ism_vpl l,vec3 p,vec3 n)\n"
    "{\n"
    "float plain;\n"
    "return ism_kernel(l,p,n,.0,plain)*ism_luminance(l.flux);\n"
    "}\n"
    "\n\nuint ism_used(uint first,uint set_count)\n"
    "{\n"
    "uint count=ISM_F.vpl_count;\n"
    "return first<count?(count-first-1u)/set_count+1u:0u;\n"
    "}\n"
    "\n\n\nvec4 ism_scaled(vec4 sum,uint set_count){return sum*(float(set_count)/COHSM_PI);}\n"
    "\n\n\nstruct ism_near_point{\n"
    "vec3 position,normal,flux;\n"
    "float edge;\n"
    "float reach;\n"
    "uint vpl;\n"
    "};\n"
    "\n\nism_near_point ism_read_near(uint i)\n"
    "{\n"
    "uint at=ISM_F.first_near_point+3u*i;\n"
    "vec4 a=ISM_TEXEL(at),b=ISM_TEXEL(at+1u),c=ISM_TEXEL(at+2u);\n"
    "return ism_near_point(a.xyz,b.xyz,c.xyz,a.w,b.w,uint(c.w));\n"
    "}\n"
    "\n\n\n\nfloat ism_near_visible(ism_near_point q,vec3 p,vec3 n,vec3 ng,float bias)\n"
    "{\n"
    "#ifdef GLBK_OWN_VISIBLE\n"
    "return glbk_visible(q.vpl,p,ng);\n"
    "#else\n"
    "ism_vpl l=ism_read_vpl(q.vpl);\n"
    "vec3 way=l.position-q.position,d=p-q.position,at=p;\n"
    "float open=1.-clamp(-2.*dot(n,q.normal),.0,1.),lit=1.;\n"
    "if(!(dot(l.basis[2],p-l.position)>.0))return open;\n"
    "bool movable=open>.0&&dot(d,d)<dot(way,way)&&dot(l.basis[2],d)>.0;\n"
    "\nwhile(!(ism_visible(q.vpl,l,at,ng,bias)>.0)){\n"
    "if(!movable)return .0;\n"
    "movable=false;\n"
    "at=p+way;\n"
    "lit=open;\n"
    "}\n"
    "return lit;\n"
    "#endif\n"
    "}\n"
    "\n\nfloat ism_near_weight(const ism_near_point q,vec3 p,vec3 n)\n"
    "{\n"
    "vec3 d=q.position-p;\n"
    "return dot(n,d)>.0&&dot(q.normal,d)<.0?ism_nearness(dot(d,d),q.reach):.0;\n"
    "}\n"
    "\n\n\nfloat ism_near_kernel(ism_near_point q,vec3 p,vec3 n,out float plain)\n"
    "{\n"
    "vec3 d=q.position-p;\n"
    "float d2=dot(d,d),h=ism_near_weight(q,p,n);\n"
    "plain=.0;\n"
    "if(!(h>.0))return .0;\n"
    "float point=dot(n,d)*-dot(q.normal,d)/(d2*d2+1e-37),k=point;\n"
    "plain=point;\n"
    "if(d2<9.*q.edge*q.edge)k=ism_patch_kernel(ism_basis_of(q.normal),q.edge,d,n,point,plain);\n"
    "plain*=h;\n"
    "return k*h;\n"
    "}\n"
    "\n\nbool ism_near_counts(uint i,vec3 p,vec3 n){return ism_near_weight(ism_read_near(i),p,n)>.0;}\n"
    "\n\n\nuint ism_near_block(uint i,uint count,vec3 p)\n"
    "{\n"
    "for(;i<count;i+=64u){\n"
    "vec4 sphere=ISM_TEXEL(ISM_F.first_sphere+i/64u);\n"
    "vec3 d=sphere.xyz-p;\n"
    "if(dot(d,d)<sphere.w*sphere.w)break;\n"
    "}\n"
    "return i;\n"
    "}\n"
    "\n\n\n\n\nvec4 ism_gather(vec3 p,vec3 n,vec3 ng)\n"
    "{\n"
    "uint count=ISM_F.near_point_count,i=ism_near_block(0u,count,p);\n"
    "vec4 sum=vec4(.0);\n"
    "while(i<count){\n"
    "uvec4 found=uvec4(0u);\n"
    "uint have=0u;\n"
    "while(i<count&&have<4u){\n"
    "if(ism_near_counts(i,p,n))found[have++]=i;\n"
    "i++;\n"
    "if((i&63u)==0u)i=ism_near_block(i,count,p);\n"
    "}\n"
    "for(uint k=0u;k<have;k++){\n"
    "ism_near_point q=ism_read_near(found[k]);\n"
    "float plain,bright=ism_near_kernel(q,p,n,plain);\n"
    "if(!(bright>.0))continue;\n"
    "float lit=1.;\n"
    "if(glbk_ism_view.no_maps==0u)lit=ism_near_visible(q,p,n,ng,glbk_ism_view.bias);\n"
    "sum+=lit*vec4(bright*q.flux,max(plain-bright,.0)*ism_luminance(q.flux));\n"
    "}\n"
    "}\n"
    "return ism_scaled(sum,1u);\n"
    "}\n"
    "\n\n\nvec4 ism_light(vec3 p,vec3 n,vec3 ng,uint first,uint set_count)\n"
    "{\n"
    "uint count=ISM_F.vpl_count;\n"
    "float most=glbk_ism_view.clamp_at;\n"
    "vec4 sum=vec4(.0);\n"
    "#if ISM_NEAR == 4\n"
    "uint used=ism_used(first,set_count);\n"
    "float all=.0;\n"
    "for(uint v=first;v<count;v+=set_count)all+=ism_unshadowed(ism_read_vpl(v),p,n);\n"
    "most*=used>0u?all/float(used):.0;\n"
    "#endif\n"
    "for(uint v=first;v<count;v+=set_count)ism_add(sum,v,ism_read_vpl(v),p,n,ng,most);\n"
    "#if ISM_NEAR == 6\n"
    "return ism_scaled(sum,set_count)+ism_gather(p,n,ng);\n"
    "#else\n"
    "return ism_scaled(sum,set_count);\n"
    "#endif\n"
    "}\n", 0
};

static const struct { char facts[31];
    char s0[3187]; char end; } glbk__glsl_lib_ism_map_glsl GLBK__TIGHT = {
    "lib/ism_map.glsl\0" "cohsm_math" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n#define ISM_PROJECTION_COSINE 1u\n"
    "#define ISM_PROJECTION_PARABOLOID 2u\n"
    "#define ISM_PROJECTION_OCTAHEDRAL 3u\n"
    "#define ISM_PROJECTION_LOBE 4u\n"
    "#define ISM_FAR 1e30\n"
    "\n\n#ifndef ISM_PROJECTION\n"
    "#define ISM_PROJECTION 1\n"
    "#elif ISM_PROJECTION == 0\n"
    "#undef ISM_PROJECTION\n"
    "#define ISM_PROJECTION 1\n"
    "#endif\n"
    "\n\nuint ism_projection_of(float exponent)\n"
    "{\n"
    "#if ISM_PROJECTION == 4\n"
    "return exponent==1.?ISM_PROJECTION_COSINE:ISM_PROJECTION_LOBE;\n"
    "#else\n"
    "return uint(ISM_PROJECTION);\n"
    "#endif\n"
    "}\n"
    "\n\nfloat ism_power_gap(float x,float y)\n"
    "{\n"
    "if(!(x>1.18e-38))return 1.;\n"
    "float t=y*cohsm_log(min(x,1.));\n"
    "if(t<-.35)return 1.-cohsm_exp(t);\n"
    "return-t*(1.+t*(.5+t*(.166666667+t*(.0416666667+t*(.00833333333+\n"
    "t*(.00138888889+t*.000198412698))))));\n"
    "}\n"
    "\n\nvec3 ism_map_direction(uint projection,float exponent,vec2 uv)\n"
    "{\n"
    "vec2 ab=2.*uv-1.;\n"
    "if(projection==ISM_PROJECTION_PARABOLOID){\n"
    "float r2=dot(ab,ab);\n"
    "return vec3(2.*ab,1.-r2)/(1.+r2);\n"
    "}\n"
    "if(projection==ISM_PROJECTION_OCTAHEDRAL){\n"
    "vec2 p=.5*vec2(ab.x+ab.y,ab.x-ab.y);\n"
    "return cohsm_normalize(vec3(p,1.-abs(p.x)-abs(p.y)));\n"
    "}\n"
    "float e=projection==ISM_PROJECTION_LOBE?exponent:1.,r=max(abs(ab.x),abs(ab.y));\n"
    "float s=max(1.-r*r,.0),z=e==1.?sqrt(s):cohsm_pow(s,1./(e+1.));\n"
    "float sine=e==1.?r:sqrt(ism_power_gap(s,2./(e+1.)));\n"
    "return vec3(cohsm_concentric(uv)*(r>1e-12?sine/r:1.),z);\n"
    "}\n"
    "\n\n\nbool ism_map_coordinates(uint projection,float exponent,vec3 w,out vec2 uv)\n"
    "{\n"
    "vec2 ab;\n"
    "uv=vec2(.0);\n"
    "if(!(w.z>.0))return false;\n"
    "if(projection==ISM_PROJECTION_PARABOLOID){\n"
    "ab=w.xy/(1.+w.z);\n"
    "}else if(projection==ISM_PROJECTION_OCTAHEDRAL){\n"
    "ab=vec2(w.x+w.y,w.x-w.y)/(abs(w.x)+abs(w.y)+w.z);\n"
    "}else{\n"
    "float e=projection==ISM_PROJECTION_LOBE?exponent:1.;\n"
    "if(e!=1.){\n"
    "float sine=sqrt(dot(w.xy,w.xy));\n"
    "w.xy*=sine>1e-12?sqrt(ism_power_gap(w.z,e+1.))/sine:1.;\n"
    "}\n"
    "uv=cohsm_disc_square(w.xy);\n"
    "return true;\n"
    "}\n"
    "uv=clamp(.5*ab+.5,.0,1.);\n"
    "return true;\n"
    "}\n"
    "\n\n\n\nvec4 ism_axis(uvec2 cut,uint size,uint rim)\n"
    "{\n"
    "uint rest=cut.x+cut.y;\n"
    "if(!(rest*size>rim*64u)||rest>=64u)return vec4(float(size),1./float(size),1.,1.);\n"
    "\n\nfloat a=floor((float(2u*rim*cut.x+rest)+.5)/float(2u*rest)),most=float(rim);\n"
    "if(cut.x!=0u&&a==.0)a=1.;\n"
    "if(cut.y!=0u&&a==most)a=most-1.;\n"
    "vec3 share=vec3(cut.x,64u-rest,cut.y)/(64.*max(vec3(a,float(size-rim),most-a),1.));\n"
    "return vec4(a,a>.0?share.x:1.,share.y,a<most?share.z:1.);\n"
    "}\n"
    "\n\n\nfloat ism_zoom_axis(vec4 axis,float size,float rim,float u)\n"
    "{\n"
    "float low=axis.x*axis.y,high=1.-(rim-axis.x)*axis.w;\n"
    "vec3 part=u<low?vec3(.0,u,axis.y):vec3(axis.x,u-low,axis.z);\n"
    "if(!(u<low)&&!(u<high))part=vec3(size,u-1.,axis.w);\n"
    "return clamp(part.x+part.y/part.z,.0,size);\n"
    "}\n"
    "\n\nfloat ism_unzoom_axis(vec4 axis,float size,float rim,float x)\n"
    "{\n"
    "float u=x<axis.x?x*axis.y:x<axis.x+size-rim?axis.x*axis.y+(x-axis.x)*axis.z\n"
    ":1.-(size-x)*axis.w;\n"
    "return clamp(u,.0,1.);\n"
    "}\n"
    "\n\nuvec4 ism_cut(uint window){return uvec4(window,window>>6,window>>12,window>>18)&63u;}\n"
    "\n\nvoid ism_axes(uint window,uint size,uint rim,out vec4 across,out vec4 down)\n"
    "{\n"
    "uvec4 cut=ism_cut(window);\n"
    "across=ism_axis(cut.xz,size,rim);\n"
    "down=ism_axis(cut.yw,size,rim);\n"
    "}\n"
    "\n\nmat3 ism_basis_of(vec3 z)\n"
    "{\n"
    "vec3 x,y;\n"
    "cohsm_basis(z,x,y);\n"
    "return mat3(x,y,z);\n"
    "}\n"
    "\n\n\nfloat ism_plane_depth(bool sky,vec3 g,vec3 w)\n"
    "{\n"
    "float s=dot(g,w);\n"
    "if(sky)return max(s,.0);\n"
    "return s>1e-20?1./s:.0;\n"
    "}\n", 0
};

static const struct { char facts[36];
    char s0[215]; char end; } glbk__glsl_lib_ism_pulled_glsl GLBK__TIGHT = {
    "lib/ism_pulled.glsl\0" "ism_bindings" "\0" "" "\0"
    "" "\0" "",
    "\n\nint ism_pulled(int level,ivec2 cell)\n"
    "{\n"
    "if(level==1)return int(texelFetch(glbk_ism_pull1,cell,0).x);\n"
    "if(level==2)return int(texelFetch(glbk_ism_pull2,cell,0).x);\n"
    "return int(texelFetch(glbk_ism_pull3,cell,0).x);\n"
    "}\n", 0
};

static const struct { char facts[30];
    char s0[1825]; char end; } glbk__glsl_lib_ism_push_glsl GLBK__TIGHT = {
    "lib/ism_push.glsl\0" "ism_fill" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\nint ism_pulled(int level,ivec2 cell);\n"
    "\nstruct ism_near{\n"
    "int first,second;\n"
    "int least,next;\n"
    "uint found;\n"
    "uint close;\n"
    "uint beyond;\n"
    "};\n"
    "\n\nvoid ism_look(int level,ivec2 at,inout ism_near n)\n"
    "{\n"
    "int size=int(ISM_F.tile_side),half_size=size>>level;\n"
    "ivec2 local=at&(size-1),cell=local>>level,origin=(at>>level)-cell;\n"
    "for(int y=cell.y-1;y<=cell.y+1;y++)\n"
    "for(int x=cell.x-1;x<=cell.x+1;x++){\n"
    "if(x<0||y<0||x>=half_size||y>=half_size){\n"
    "n.beyond|=ism_sector(ivec2(x,y)-cell);\n"
    "continue;\n"
    "}\n"
    "int there=ism_pulled(level,origin+ivec2(x,y));\n"
    "if(there==0)continue;\n"
    "ivec2 d=ivec2((there-1)%size,(there-1)/size)-local;\n"
    "int d2=d.x*d.x+d.y*d.y;\n"
    "n.found|=ism_sector(d);\n"
    "if(n.first==0||d2<n.least){\n"
    "if(n.first!=0&&n.first!=there){\n"
    "n.second=n.first;\n"
    "n.next=n.least;\n"
    "}\n"
    "n.first=there;\n"
    "n.least=d2;\n"
    "}else if(n.first!=there&&(n.second==0||d2<n.next)){\n"
    "n.second=there;\n"
    "n.next=d2;\n"
    "}\n"
    "}\n"
    "if(level==1)n.close=n.found;\n"
    "}\n"
    "\n\n\nfloat ism_push(ism_grid grid,ivec2 local,ivec2 first,ivec2 second,ivec2 origin)\n"
    "{\n"
    "vec4 a=ism_plane_at(origin+first),b=ism_plane_at(origin+second);\n"
    "float t=ism_plane_depth(grid.exponent<.0,a.xyz,ism_texel_direction(grid,local));\n"
    "float there=ism_plane_depth(grid.exponent<.0,a.xyz,ism_texel_direction(grid,second));\n"
    "if(abs(a.w-b.w)<=abs(there-b.w))return a.w;\n"
    "return t>.5*a.w&&t<2.*a.w?t:a.w;\n"
    "}\n"
    "\n\n\nfloat ism_filled(ism_grid grid,ivec2 at,out ivec2 from)\n"
    "{\n"
    "int size=int(ISM_F.tile_side);\n"
    "ivec2 local=at&(size-1);\n"
    "from=at;\n"
    "ism_near n=ism_near(0,0,0,0,0u,0u,0u);\n"
    "for(int level=1;level<=int(ISM_F.fill_levels);level++){\n"
    "if(n.second!=0&&ism_surrounded(n.found,n.close,n.beyond))break;\n"
    "ism_look(level,at,n);\n"
    "}\n"
    "if(n.second==0||!ism_surrounded(n.found,n.close,n.beyond))return ISM_FAR;\n"
    "ivec2 first=ivec2((n.first-1)%size,(n.first-1)/size);\n"
    "from=at-local+first;\n"
    "return ism_push(grid,local,first,ivec2((n.second-1)%size,(n.second-1)/size),at-local);\n"
    "}\n", 0
};

static const struct { char facts[43];
    char s0[910]; char end; } glbk__glsl_lib_ism_pvpl_glsl GLBK__TIGHT = {
    "lib/ism_pvpl.glsl\0" "cohsm_math ism_choice" "\0" "" "\0"
    "" "\0" "",
    "\n\nstruct ism_pvpl{\n"
    "vec3 position,normal,flux;\n"
    "float area;\n"
    "float luminance;\n"
    "};\n"
    "\n\n\n\nism_pvpl ism_read_pvpl(ivec2 at)\n"
    "{\n"
    "int side=int(ISM_C.face_height),face=at.y/side;\n"
    "ivec3 to=ivec3(at.x,at.y-face*side,3*face);\n"
    "vec4 place=ISM_FLOATS(glbk_ism_texels,to);\n"
    "vec4 normal=ISM_FLOATS(glbk_ism_texels,to+ivec3(0,0,1));\n"
    "vec4 flux=ISM_FLOATS(glbk_ism_texels,to+ivec3(0,0,2));\n"
    "float length2=dot(normal.xyz,normal.xyz);\n"
    "bool usable=cohsm_finite3(place.xyz)&&cohsm_finite3(normal.xyz)&&cohsm_finite3(flux.xyz);\n"
    "usable=usable&&clamp(length2,.9409,1.0609)==length2&&clamp(flux.xyz,.0,1e30)==flux.xyz;\n"
    "float luminance=.0;\n"
    "if(usable)luminance=(flux.x+flux.y+flux.z)*(1./3.);\n"
    "return ism_pvpl(place.xyz,normal.xyz,flux.xyz,flux.w,luminance);\n"
    "}\n"
    "\n\nbool ism_to_clip(vec3 p,out vec2 at)\n"
    "{\n"
    "vec4 c=ISM_C.world_to_clip*vec4(p,1.);\n"
    "bool known=abs(c.w)>1e-20;\n"
    "at=vec2(.0);\n"
    "if(known)at=c.xy/c.w;\n"
    "return known&&abs(at.x)<8.&&abs(at.y)<8.;\n"
    "}\n", 0
};

static const struct { char facts[33];
    char s0[609]; char end; } glbk__glsl_lib_ism_reach_glsl GLBK__TIGHT = {
    "lib/ism_reach.glsl\0" "ism_choice" "\0" "" "\0"
    "" "\0" "",
    "\n\n\nvec4 ism_drawn(uint v,int k){return ISM_FLOATS(glbk_ism_drawn,ivec3(ism_cell_of(v),k));}\n"
    "\n\n\nfloat ism_reach_of(vec3 p,vec3 n,out uint nearest,out vec3 low,out vec3 high)\n"
    "{\n"
    "vec4 a=vec4(1e30),b=a;\n"
    "float best=1e30;\n"
    "nearest=0u;\n"
    "low=high=ism_drawn(0u,0).xyz;\n"
    "for(uint i=0u;i<ISM_C.vpl_count;i++){\n"
    "vec3 at=ism_drawn(i,0).xyz,d=at-p;\n"
    "float d2=dot(d,d),cosine=dot(n,ism_drawn(i,1).xyz);\n"
    "low=min(low,at);\n"
    "high=max(high,at);\n"
    "b=clamp(vec4(d2),vec4(a.w,b.xyz),b);\n"
    "a=vec4(min(d2,a.x),clamp(vec3(d2),a.xyz,a.yzw));\n"
    "if(!(cosine>.5))d2*=cosine>.0?4.:16.;\n"
    "if(d2<best)nearest=i;\n"
    "best=min(best,d2);\n"
    "}\n"
    "return 2.*sqrt(b.w);\n"
    "}\n", 0
};

static const struct { char facts[47];
    char s0[328]; char end; } glbk__glsl_lib_ism_scattering_glsl GLBK__TIGHT = {
    "lib/ism_scattering.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_ism_scattering",
    "\nlayout(std140)uniform glbk_ism_scattering_block{\n"
    "uint triangle_count,cluster_count,cluster_size,first_vpl,batch,vpl_capacity,\n"
    "view_width,view_height,views,pair,seed,key,surfel_count,phase_surfel_count,\n"
    "lazy_frames,phase,first_texel,value_count,pace,vary_surfels;\n"
    "float area_share;\n"
    "uint frame,keep,layer;\n"
    "}glbk_ism_scattering;\n", 0
};

static const struct { char facts[34];
    char s0[1076]; char end; } glbk__glsl_lib_ism_search_glsl GLBK__TIGHT = {
    "lib/ism_search.glsl\0" "ism_choice" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\nfloat ism_weight(uvec4 sums,float least)\n"
    "{\n"
    "vec2 s=uintBitsToFloat(sums.xy);\n"
    "return s.x+least*s.y;\n"
    "}\n"
    "\n\n\nfloat ism_least(uvec4 totals)\n"
    "{\n"
    "vec2 s=uintBitsToFloat(totals.xy);\n"
    "float least=1.;\n"
    "if(s.x>.0&&s.y>.0)least=s.x/s.y*ISM_C.flux_factor;\n"
    "return least;\n"
    "}\n"
    "\n\n\n\n\nint ism_search_block(usampler2D sums,float least,ivec2 base,ivec2 along,int first,int count,\n"
    "inout float x)\n"
    "{\n"
    "int lo=first,hi=min(first+32,count)-1;\n"
    "float before=.0;\n"
    "x=min(x,.99999994*ism_weight(texelFetch(sums,base+along*hi,0),least));\n"
    "for(int k=0;k<5;k++){\n"
    "int middle=(lo+hi)>>1;\n"
    "float sum=ism_weight(texelFetch(sums,base+along*middle,0),least);\n"
    "bool past=lo<hi&&!(sum>x);\n"
    "if(past){\n"
    "lo=middle+1;\n"
    "before=sum;\n"
    "}\n"
    "if(!past)hi=max(middle,lo);\n"
    "}\n"
    "x-=before;\n"
    "return lo;\n"
    "}\n"
    "\n\n\nint ism_search(usampler2D sums0,usampler2D sums1,usampler2D sums2,float least,ivec2 base,ivec2 along,\n"
    "int count,inout float x)\n"
    "{\n"
    "int blocks=(count+31)>>5;\n"
    "int k=ism_search_block(sums2,least,base,along,0,(blocks+31)>>5,x);\n"
    "k=ism_search_block(sums1,least,base,along,32*k,blocks,x);\n"
    "return ism_search_block(sums0,least,base,along,32*k,count,x);\n"
    "}\n", 0
};

static const struct { char facts[35];
    char s0[144]; char end; } glbk__glsl_lib_ism_view_glsl GLBK__TIGHT = {
    "lib/ism_view.glsl\0" "" "\0" "" "\0"
    "" "\0" "glbk_ism_view",
    "\nlayout(std140)uniform glbk_ism_view_block{\n"
    "uint width,height,interleave,no_maps;\n"
    "float bias,clamp_at;\n"
    "uint first_row,unused0;\n"
    "}glbk_ism_view;\n", 0
};

static const struct { char facts[31];
    char s0[1200]; char end; } glbk__glsl_prog_ism_blur_comp GLBK__TIGHT = {
    "prog/ism_blur.comp\0" "ism_blur" "\0" "" "\0"
    "" "\0" "",
    "\n\n\nlayout(local_size_x=16,local_size_y=16)in;\n"
    "#define ISM_TILE 24\n"
    "\nshared vec3 ism_places[ISM_TILE*ISM_TILE],ism_normals[ISM_TILE*ISM_TILE];\n"
    "shared vec4 ism_lights[ISM_TILE*ISM_TILE];\n"
    "\n\nivec2 ism_corner(){return ivec2(gl_WorkGroupID.xy)*16-int(glbk_ism_view.interleave)/2;}\n"
    "\nbool ism_neighbour(ivec2 at,out ism_receiver r,out vec4 light)\n"
    "{\n"
    "ivec2 texel=at-ism_corner();\n"
    "int i=texel.y*ISM_TILE+texel.x;\n"
    "r.p=ism_places[i];\n"
    "r.n=r.ng=ism_normals[i];\n"
    "light=ism_lights[i];\n"
    "return r.n!=vec3(.0);\n"
    "}\n"
    "\n\nvoid ism_load(int wide)\n"
    "{\n"
    "for(int i=int(gl_LocalInvocationIndex);i<wide*wide;i+=256){\n"
    "ivec2 texel=ivec2(i%wide,i/wide),at=ism_corner()+texel;\n"
    "int to=texel.y*ISM_TILE+texel.x;\n"
    "ism_receiver r;\n"
    "ism_normals[to]=vec3(.0);\n"
    "if(clamp(at,ivec2(0),ism_picture_side()-1)!=at)continue;\n"
    "if(!ism_read_receiver(at,r))continue;\n"
    "ism_places[to]=r.p;\n"
    "ism_normals[to]=r.n;\n"
    "ism_lights[to]=texelFetch(glbk_ism_light,at,0);\n"
    "}\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_GlobalInvocationID.xy);\n"
    "int side=int(glbk_ism_view.interleave);\n"
    "ism_receiver c;\n"
    "if(side>1)ism_load(16+side/2*2);\n"
    "barrier();\n"
    "if(any(greaterThanEqual(at,ism_picture_side())))return;\n"
    "imageStore(glbk_ism_light_out,at,ism_read_receiver(at,c)?ism_finished(at,c):vec4(.0));\n"
    "}\n", 0
};

static const struct { char facts[31];
    char s0[423]; char end; } glbk__glsl_prog_ism_blur_frag GLBK__TIGHT = {
    "prog/ism_blur.frag\0" "ism_blur" "\0" "" "\0"
    "" "\0" "",
    "\n\n\nlayout(location=0)out glbk_color result;\n"
    "\nbool ism_neighbour(ivec2 at,out ism_receiver r,out vec4 light)\n"
    "{\n"
    "bool inside=clamp(at,ivec2(0),ism_picture_side()-1)==at;\n"
    "if(!inside||!ism_read_receiver(at,r))return false;\n"
    "light=glbk_unpack(texelFetch(glbk_ism_light,at,0));\n"
    "return true;\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ivec2(gl_FragCoord.xy);\n"
    "ism_receiver c;\n"
    "result=glbk_pack(ism_read_receiver(at,c)?ism_finished(at,c):vec4(.0));\n"
    "}\n", 0
};

static const struct { char facts[91];
    char s0[1762]; char end; } glbk__glsl_prog_ism_bounce_frag GLBK__TIGHT = {
    "prog/ism_bounce.frag\0" "ism_push ism_pulled ism_corners" "\0" "" "\0"
    "ISM_PROJECTION=1 | ISM_PROJECTION=2" "\0" "",
    "\n\n\n\n\nlayout(location=0)out uvec4 place;\n"
    "layout(location=1)out uvec4 facing;\n"
    "layout(location=2)out uvec4 power;\n"
    "\nvec3 ism_beside(ism_vpl l,ivec2 texel,float x,float y)\n"
    "{\n"
    "vec2 uv=(vec2(texel)+.5+vec2(x,y))/float(ISM_F.tile_side);\n"
    "return ism_map_direction(uint(ISM_PROJECTION),l.exponent,uv);\n"
    "}\n"
    "\n\n\nfloat ism_cell_weight(ism_vpl l,ivec2 texel)\n"
    "{\n"
    "float weight=1.;\n"
    "#if ISM_PROJECTION == 2 || ISM_PROJECTION == 3\n"
    "vec3 d=ism_beside(l,texel,-.25,-.25);\n"
    "vec3 n=cross(ism_beside(l,texel,.25,.25)-d,\n"
    "ism_beside(l,texel,-.25,.25)-ism_beside(l,texel,.25,-.25));\n"
    "weight=.0;\n"
    "if(d.z>.0)weight=length(n)*cohsm_pow(d.z,l.exponent);\n"
    "#endif\n"
    "return weight;\n"
    "}\n"
    "\n\nivec2 ism_cell_texel(int cell,int side,int step){return ivec2(cell%side,cell/side)*step+step/2;}\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ISM_HERE;\n"
    "int side=int(ISM_F.bounce_side),step=int(ISM_F.tile_side)/side;\n"
    "place=facing=power=uvec4(0u);\n"
    "uint v=uint(at.y);\n"
    "if(v>=ISM_F.vpl_count)return;\n"
    "facing.y=0x3f800000u;\n"
    "ism_vpl l=ism_read_vpl(v);\n"
    "ivec2 texel=ism_cell_texel(at.x,side,step),to=ism_tile_at(v)+texel,from=to;\n"
    "float sum=.0,share=ism_cell_weight(l,texel);\n"
    "for(int k=0;k<side*side;k++)sum+=ism_cell_weight(l,ism_cell_texel(k,side,step));\n"
    "bool hit=texelFetch(glbk_ism_below,to,0).x!=0u;\n"
    "if(!hit)hit=ism_filled(l.grid,to,from)<ISM_FAR;\n"
    "vec3 w=ism_texel_direction(l.grid,texel);\n"
    "if(l.sky||!hit||!(w.z>.0))return;\n"
    "uint t=texelFetch(glbk_ism_hits,from,0).x;\n"
    "vec3 n=ism_normal2(ism_read_corners(t)),d=l.basis*w;\n"
    "float size=length(n);\n"
    "if(!(size>.0)||!cohsm_finite(size))return;\n"
    "if(dot(n,d)>.0)size=-size;\n"
    "d=l.position+d*ISM_FLOATS(glbk_ism_atlas,to).x;\n"
    "l.flux*=share/sum*texelFetch(glbk_ism_albedos,glbk_table_at(t),0).xyz;\n"
    "place=floatBitsToUint(vec4(d,.0));\n"
    "facing=floatBitsToUint(vec4(n/size,.0));\n"
    "power=floatBitsToUint(vec4(l.flux,.0));\n"
    "}\n", 0
};

static const struct { char facts[60];
    char s0[1572]; char end; } glbk__glsl_prog_ism_choose_frag GLBK__TIGHT = {
    "prog/ism_choose.frag\0" "ism_search ism_hash ism_inter_texel" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\nlayout(location=0)out uvec4 place;\n"
    "layout(location=1)out uvec4 facing;\n"
    "layout(location=2)out uvec4 power;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ISM_HERE,texel,end=textureSize(glbk_ism_row_sums2,0)-1;\n"
    "uint i=uint(at.y)*256u+uint(at.x),n=ISM_C.vpl_count;\n"
    "int width=int(ISM_C.width),height=end.y+1;\n"
    "uvec4 totals=texelFetch(glbk_ism_column_sums2,textureSize(glbk_ism_column_sums2,0)-1,0);\n"
    "float least=ism_least(totals),total=ism_weight(totals,least);\n"
    "place=facing=power=uvec4(0u);\n"
    "if(i>=n||!(total>.0))return;\n"
    "float y=fract((float(i)+.5)/float(n)+ISM_C.shift)*total;\n"
    "texel.y=ism_search(glbk_ism_column_sums0,glbk_ism_column_sums1,glbk_ism_column_sums2,least,\n"
    "ivec2(0),ivec2(0,1),height,y);\n"
    "float row=ism_weight(texelFetch(glbk_ism_row_sums2,ivec2(end.x,texel.y),0),least);\n"
    "float x=ism_to_unit(i*2654435769u+ISM_C.shift_bits)*row;\n"
    "texel.x=ism_search(glbk_ism_row_sums0,glbk_ism_row_sums1,glbk_ism_row_sums2,least,\n"
    "ivec2(0,texel.y),ivec2(1,0),width,x);\n"
    "float weight=ism_weight(texelFetch(glbk_ism_importances,texel,0),least);\n"
    "vec2 fraction=min(vec2(x/weight,y/row),vec2(.99999994));\n"
    "float scale=total/(float(n)*weight),spacing=.0;\n"
    "ism_pvpl p=ism_read_pvpl(texel);\n"
    "if(ISM_C.inter_texel!=0u)spacing=ism_inter_texel(texel,fraction,p.position,p.normal);\n"
    "p.normal=normalize(p.normal);\n"
    "float area=p.area*scale;\n"
    "if(ISM_C.first_near_point!=0u)area=max(area,p.area);\n"
    "if(!cohsm_finite(area)||area<.0)area=.0;\n"
    "place=floatBitsToUint(vec4(p.position,area));\n"
    "facing=floatBitsToUint(vec4(p.normal,spacing));\n"
    "power=floatBitsToUint(vec4(min(p.flux*scale,vec3(1e30)),texel.y/int(ISM_C.face_height)));\n"
    "}\n", 0
};

static const struct { char facts[47];
    char s0[1085]; char end; } glbk__glsl_prog_ism_clusters_frag GLBK__TIGHT = {
    "prog/ism_clusters.frag\0" "ism_corners ism_fold" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\nlayout(location=0)out uvec2 masses;\n"
    "layout(location=1)out uvec4 place;\n"
    "layout(location=2)out uvec4 squares;\n"
    "layout(location=3)out uvec4 mixed;\n"
    "\nvoid main()\n"
    "{\n"
    "uint count=ISM_S.cluster_count,size=ISM_S.cluster_size;\n"
    "uint triangles=ISM_S.triangle_count;\n"
    "uint c=ism_unfold(count).x,end=min((c+1u)*size,triangles);\n"
    "vec2 sums=vec2(.0);\n"
    "vec3 from=vec3(.0),at=vec3(.0),nn=vec3(.0),other=vec3(.0);\n"
    "float square=.0;\n"
    "for(uint t=c*size;c<count&&t<end;t++){\n"
    "vec2 sizes=ism_folded2(glbk_ism_sizes,t,triangles);\n"
    "if(sizes.x>.0){\n"
    "ism_corners p=ism_read_corners(t);\n"
    "vec3 n=ism_normal2(p)*(.5/sizes.x);\n"
    "if(!(sums.x>.0))from=p.a;\n"
    "p.a-=from;\n"
    "p.b-=from;\n"
    "p.c-=from;\n"
    "vec3 g=(p.a+p.b+p.c)*(1./3.);\n"
    "sums+=sizes;\n"
    "at+=sizes.x*g;\n"
    "square+=sizes.x*(9.*dot(g,g)+dot(p.a,p.a)+dot(p.b,p.b)+dot(p.c,p.c))*(1./12.);\n"
    "nn+=sizes.x*n*n;\n"
    "other+=sizes.x*n.yzx*n.zxy;\n"
    "}\n"
    "}\n"
    "float one=.0;\n"
    "if(sums.x>.0)one=1./sums.x;\n"
    "at*=one;\n"
    "square=max(square*one-dot(at,at),.0);\n"
    "masses=floatBitsToUint(sums);\n"
    "place=floatBitsToUint(vec4(from+at,square));\n"
    "squares=floatBitsToUint(vec4(nn*one,.0));\n"
    "mixed=floatBitsToUint(vec4(other*one,.0));\n"
    "}\n", 0
};

static const struct { char facts[44];
    char s0[488]; char end; } glbk__glsl_prog_ism_counts_frag GLBK__TIGHT = {
    "prog/ism_counts.frag\0" "ism_access ism_fold" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\nlayout(location=0)out uint result;\n"
    "\nfloat ism_luminance_of(uint v)\n"
    "{\n"
    "vec3 flux=ISM_TEXEL(4u*v+2u).xyz;\n"
    "return(flux.x+flux.y+flux.z)*(1./3.);\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "uint count=ISM_F.vpl_count,n=ISM_S.surfel_count;\n"
    "uint v=ism_unfold(ISM_F.vpl_capacity).x;\n"
    "float mean=.0;\n"
    "result=n;\n"
    "if(ISM_S.vary_surfels==0u||v>=count)return;\n"
    "for(uint i=0u;i<count;i++)mean+=ism_luminance_of(i);\n"
    "mean/=float(count);\n"
    "float flux=ism_luminance_of(v);\n"
    "if(flux<.5*mean)result=n/2u;\n"
    "if(flux<.25*mean)result=n/4u;\n"
    "}\n", 0
};

static const struct { char facts[33];
    char s0[1288]; char end; } glbk__glsl_prog_ism_edges_frag GLBK__TIGHT = {
    "prog/ism_edges.frag\0" "ism_reach" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\nlayout(location=0)out uvec4 result;\n"
    "\nfloat ism_edge(uint v,vec3 p,vec3 n,float area)\n"
    "{\n"
    "vec4 near2=vec4(1e30);\n"
    "for(uint i=0u;i<ISM_C.vpl_count;i++){\n"
    "vec4 other=ism_drawn(i,0);\n"
    "vec3 d=other.xyz-p;\n"
    "float d2=dot(d,d);\n"
    "bool beside=i!=v&&d2<near2.w&&dot(n,ism_drawn(i,1).xyz)>=.5;\n"
    "if(beside&&!(d2>.0))area+=other.w;\n"
    "if(beside&&d2>.0)near2=vec4(min(d2,near2.x),clamp(vec3(d2),near2.xyz,near2.yzw));\n"
    "}\n"
    "float most=.0;\n"
    "if(near2.w<1e30)most=3.14159265*near2.w;\n"
    "if(!(area>.0))area=.25*most;\n"
    "else if(most>.0)area=min(area,2.*most);\n"
    "return sqrt(area);\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "uint at=uint(gl_FragCoord.y)*1024u+uint(gl_FragCoord.x),v=at>>2,part=at&3u;\n"
    "vec4 place=ism_drawn(v,0),normal=ism_drawn(v,1),texel;\n"
    "bool black=dot(normal.xyz,normal.xyz)==.0;\n"
    "if(black)normal.z=1.;\n"
    "if(part==0u)texel=vec4(place.xyz,1.);\n"
    "else if(part==2u)texel=vec4(ism_drawn(v,2).xyz,.0);\n"
    "else texel=vec4(normal.xyz,.0);\n"
    "uint nearest;\n"
    "vec3 low,high;\n"
    "bool reaches=part==2u&&!black&&ISM_C.near_point_count>0u;\n"
    "if(reaches)texel.w=ism_reach_of(place.xyz,normal.xyz,nearest,low,high);\n"
    "if(part==1u&&!black)texel.w=ism_edge(v,place.xyz,normal.xyz,place.w);\n"
    "if(part==3u&&ISM_C.windows!=0u){\n"
    "uint window=texelFetch(glbk_ism_windows,ism_cell_of(v),0).w;\n"
    "if(window>>31==0u)texel.w=float(window&0xffffffu);\n"
    "}\n"
    "result=floatBitsToUint(texel);\n"
    "}\n", 0
};

static const struct { char facts[50];
    char s0[2465]; char end; } glbk__glsl_prog_ism_effect_frag GLBK__TIGHT = {
    "prog/ism_effect.frag\0" "ism_pvpl ism_hash gbuffer" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\nlayout(location=0)out uint result;\n"
    "\n\n\nfloat ism_unit_flux_light(vec3 q,vec3 n,vec3 p,vec3 pn,float extent2)\n"
    "{\n"
    "vec3 d=q-p;\n"
    "float d2=dot(d,d)+1e-4*extent2+1e-30;\n"
    "float a=max(dot(pn,d),.0),b=max(-dot(n,d),.0);\n"
    "return a*b/(d2*d2);\n"
    "}\n"
    "\n\nint ism_cell(float u,float count){return int(clamp(u*count,.0,count-1.));}\n"
    "\nfloat ism_effect(ism_pvpl q,uint i,uint seed)\n"
    "{\n"
    "uint grid=ISM_C.grid_side,count=grid*grid,rank=0u;\n"
    "vec2 side=vec2(float(ISM_C.view_width),float(ISM_C.view_height)),clip;\n"
    "float r0=.05*max(side.x,side.y),reach=side.x+side.y,sum=.0;\n"
    "uint turn=ism_hash_combine(seed,i*256u+255u);\n"
    "float even=1./(side.x*side.y),share=float(count/2u)/float(count);\n"
    "bool known=ism_to_clip(q.position,clip);\n"
    "bool guided=ISM_C.guided!=0u&&known&&side.y>1.&&count>1u&&r0>=1.&&reach>r0;\n"
    "vec2 centre=(.5*clip+.5)*side;\n"
    "float inner=1./(1.+2.*cohsm_log(reach/r0));\n"
    "float norm=inner/(3.14159265*r0*r0);\n"
    "vec3 lo=ISM_FLOATS(glbk_ism_box,ivec3(0,0,0)).xyz;\n"
    "vec3 hi=ISM_FLOATS(glbk_ism_box,ivec3(0,0,1)).xyz;\n"
    "float extent2=.0;\n"
    "if(lo.x<=hi.x)extent2=dot(hi-lo,hi-lo);\n"
    "for(uint k=0u;k<count;k++){\n"
    "uint hash=ism_hash_combine(seed,i*256u+k),column=k%grid,row=k/grid;\n"
    "float u=(float(column)+ism_to_unit(hash))/float(grid);\n"
    "float v=(float(row)+ism_to_unit(ism_hash32(hash)))/float(grid),density=even;\n"
    "vec2 at=vec2(u,v)*side;\n"
    "if(guided&&((column+row)&1u)!=0u){\n"
    "if((grid&1u)!=0u){\n"
    "u=(float(rank)+ism_to_unit(hash))/float(count/2u);\n"
    "v=ism_to_unit(turn+rank*2654435769u);\n"
    "rank+=1u;\n"
    "}\n"
    "float within=r0*sqrt(u/inner);\n"
    "float beyond=r0*cohsm_exp((u-inner)/(1.-inner)*cohsm_log(reach/r0));\n"
    "at=centre+cohsm_if(u<inner,within,beyond)*cohsm_sincos(6.28318531*v).yx;\n"
    "}\n"
    "vec2 off=at-centre;\n"
    "float r2=dot(off,off);\n"
    "if(guided)density=(1.-share)*even+share*norm*min(1.,r0*r0/max(r2,1e-20));\n"
    "bool inside=at.x>=.0&&at.y>=.0&&at.x<side.x&&at.y<side.y;\n"
    "glbk_point p;\n"
    "ivec2 pixel=ivec2(ism_cell(at.x/side.x,side.x),ism_cell(at.y/side.y,side.y));\n"
    "bool seen=glbk_read_point(pixel,p);\n"
    "if(inside&&seen&&cohsm_finite3(p.position)&&dot(p.normal,p.normal)>.25){\n"
    "float e=ism_unit_flux_light(q.position,q.normal,p.position,p.normal,extent2);\n"
    "if(ISM_C.by_mean==0u)e*=e;\n"
    "sum+=e*(even/density);\n"
    "}\n"
    "}\n"
    "return sum/float(count);\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ISM_HERE;\n"
    "ism_pvpl q=ism_read_pvpl(at);\n"
    "int height=int(ISM_C.face_height),face=at.y/height;\n"
    "uint i=uint(at.y-face*height)*ISM_C.width+uint(at.x);\n"
    "float effect=.0;\n"
    "if(q.luminance>.0)effect=ism_effect(q,i,ism_hash_combine(ISM_C.seed,uint(face)));\n"
    "result=floatBitsToUint(effect);\n"
    "}\n", 0
};

static const struct { char facts[69];
    char s0[774]; char end; } glbk__glsl_prog_ism_extent_frag GLBK__TIGHT = {
    "prog/ism_extent.frag\0" "cohsm_math ism_choice gbuffer" "\0" "" "\0"
    "FROM=0 | FROM=1" "\0" "",
    "\n\n\n\n\n#ifndef FROM\n"
    "#define FROM 0\n"
    "#endif\n"
    "layout(location=0)out uvec4 lower;\n"
    "layout(location=1)out uvec4 upper;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ISM_HERE;\n"
    "vec3 lo=vec3(1e30),hi=vec3(-1e30);\n"
    "#if FROM == 0\n"
    "uint count=ISM_C.view_width*ISM_C.view_height,pace=count/65536u+1u;\n"
    "for(uint k=0u;k<64u;k++){\n"
    "uint i=(uint(at.y)*32u+uint(at.x)+1024u*k)*pace;\n"
    "uint j=min(i,count-1u);\n"
    "glbk_point p;\n"
    "bool seen=glbk_read_point(ivec2(j%ISM_C.view_width,j/ISM_C.view_width),p);\n"
    "if(seen&&i<count&&cohsm_finite3(p.position)){\n"
    "lo=min(lo,p.position);\n"
    "hi=max(hi,p.position);\n"
    "}\n"
    "}\n"
    "#else\n"
    "for(int k=0;k<32;k++){\n"
    "lo=min(lo,ISM_FLOATS(glbk_ism_box,ivec3(k,at.x,0)).xyz);\n"
    "hi=max(hi,ISM_FLOATS(glbk_ism_box,ivec3(k,at.x,1)).xyz);\n"
    "}\n"
    "#endif\n"
    "lower=uvec4(floatBitsToUint(lo),0u);\n"
    "upper=uvec4(floatBitsToUint(hi),0u);\n"
    "}\n", 0
};

static const struct { char facts[76];
    char s0[2299]; char end; } glbk__glsl_prog_ism_fill_comp GLBK__TIGHT = {
    "prog/ism_fill.comp\0" "ism_holes ism_push" "\0" "" "\0"
    "ISM_PROJECTION=1 | ISM_PROJECTION=4" "\0" "",
    "\n\n\n\n\nlayout(local_size_x=256)in;\n"
    "#define ISM_SIDE 64\n"
    "\nshared float ism_depths[ISM_SIDE*ISM_SIDE];\n"
    "shared uint ism_cells[1024+256+64];\n"
    "ivec2 ism_origin;\n"
    "\n\nuint ism_cell(int level,ivec2 cell)\n"
    "{\n"
    "uint wide=uint(ISM_SIDE>>level),first=level==1?0u:level==2?1024u:1280u;\n"
    "return first+uint(cell.y)*wide+uint(cell.x);\n"
    "}\n"
    "\n\nivec2 ism_texel(uint i){return ivec2(i%uint(ISM_SIDE),i/uint(ISM_SIDE));}\n"
    "\nfloat ism_depth(ivec2 at)\n"
    "{\n"
    "ivec2 texel=at-ism_origin;\n"
    "return ism_depths[texel.y*ISM_SIDE+texel.x];\n"
    "}\n"
    "\nint ism_pulled(int level,ivec2 cell)\n"
    "{\n"
    "return int(ism_cells[ism_cell(level,cell-(ism_origin>>level))]);\n"
    "}\n"
    "\n\n\nuint ism_part(int level,ivec2 cell)\n"
    "{\n"
    "if(level==0)return ism_depths[cell.y*ISM_SIDE+cell.x]<ISM_FAR?1u:0u;\n"
    "return ism_cells[ism_cell(level,cell)];\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "int size=int(ISM_F.tile_side),levels=int(ISM_F.fill_levels);\n"
    "int block=size>ISM_SIDE?32:size,margin=size>ISM_SIDE?16:0;\n"
    "ivec2 begin=ivec2(gl_WorkGroupID.xy)*block,tile=begin-(begin&(size-1));\n"
    "uint v=ism_tile_of(begin),holes=0u,thread=gl_LocalInvocationIndex;\n"
    "bool used=v<ISM_F.vpl_count;\n"
    "ism_grid grid=ism_read_grid(used?v:0u);\n"
    "ism_origin=begin-margin;\n"
    "for(uint i=thread;i<uint(ISM_SIDE*ISM_SIDE);i+=256u){\n"
    "ivec2 at=ism_origin+ism_texel(i),local=at-tile;\n"
    "bool inside=used&&clamp(local,0,size-1)==local;\n"
    "ism_depths[i]=inside?ism_plane_at(at).w:ISM_FAR;\n"
    "}\n"
    "barrier();\n"
    "for(uint k=0u;k<16u&&levels!=0;k++){\n"
    "ivec2 texel=ism_texel(thread+256u*k);\n"
    "float depth=ism_depth(ism_origin+texel);\n"
    "bool near_by=clamp(texel,margin/2,ISM_SIDE-1-margin/2)==texel;\n"
    "if(near_by&&depth<ISM_FAR&&ism_hole(grid,ism_origin+texel,depth))holes|=1u<<k;\n"
    "}\n"
    "barrier();\n"
    "for(uint k=0u;k<16u;k++)\n"
    "if((holes>>k&1u)!=0u)ism_depths[thread+256u*k]=ISM_FAR;\n"
    "for(int level=1;level<=levels;level++){\n"
    "int wide=ISM_SIDE>>level;\n"
    "barrier();\n"
    "for(int i=int(thread);i<wide*wide;i+=256){\n"
    "ivec2 cell=ivec2(i%wide,i/wide);\n"
    "uvec4 parts;\n"
    "for(int k=0;k<4;k++)parts[k]=ism_part(level-1,2*cell+ivec2(k&1,k>>1));\n"
    "ism_cells[ism_cell(level,cell)]=ism_pull(level,cell+((ism_origin-tile)>>level),parts);\n"
    "}\n"
    "}\n"
    "barrier();\n"
    "for(uint i=thread;i<uint(block*block);i+=256u){\n"
    "ivec2 at=begin+ivec2(i%uint(block),i/uint(block)),from;\n"
    "float depth=ism_depth(at);\n"
    "if(used&&levels!=0&&!(depth<ISM_FAR))depth=ism_filled(grid,at,from);\n"
    "imageStore(glbk_ism_atlas_out,at,uvec4(floatBitsToUint(depth),0u,0u,0u));\n"
    "}\n"
    "}\n", 0
};

static const struct { char facts[50];
    char s0[208]; char end; } glbk__glsl_prog_ism_gone_frag GLBK__TIGHT = {
    "prog/ism_gone.frag\0" "ism_bindings ism_scattering" "\0" "" "\0"
    "" "\0" "",
    "\n\n\nlayout(location=0)out uint result;\n"
    "\nvoid main()\n"
    "{\n"
    "uvec4 surfel=texelFetch(glbk_ism_surfels,ivec3(gl_FragCoord.xy,glbk_ism_scattering.layer),0);\n"
    "result=surfel.x<glbk_ism_scattering.triangle_count?0u:1u;\n"
    "}\n", 0
};

static const struct { char facts[68];
    char s0[314]; char end; } glbk__glsl_prog_ism_holes_frag GLBK__TIGHT = {
    "prog/ism_holes.frag\0" "ism_holes" "\0" "" "\0"
    "ISM_PROJECTION=1 | ISM_PROJECTION=4" "\0" "",
    "\n\n\n\nlayout(location=0)out uint result;\n"
    "\nfloat ism_depth(ivec2 at){return ism_plane_at(at).w;}\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ISM_HERE;\n"
    "uint v=ism_tile_of(at);\n"
    "float depth=ism_depth(at);\n"
    "result=0u;\n"
    "if(!(depth<ISM_FAR)||v>=ISM_F.vpl_count)return;\n"
    "result=ISM_F.fill_levels!=0u&&ism_hole(ism_read_grid(v),at,depth)?0u:1u;\n"
    "}\n", 0
};

static const struct { char facts[32];
    char s0[830]; char end; } glbk__glsl_prog_ism_near_frag GLBK__TIGHT = {
    "prog/ism_near.frag\0" "ism_reach" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\nlayout(location=0)out uvec4 result;\n"
    "\n\nuvec3 ism_spread_bits(uvec3 x)\n"
    "{\n"
    "x=(x|x<<16)&0x030000ffu;\n"
    "x=(x|x<<8)&0x0300f00fu;\n"
    "x=(x|x<<4)&0x030c30c3u;\n"
    "return(x|x<<2)&0x09249249u;\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "uint nearest;\n"
    "vec3 low,high;\n"
    "vec4 place=ISM_FLOATS(glbk_ism_near,ivec3(gl_FragCoord.xy,0));\n"
    "vec3 n=ISM_FLOATS(glbk_ism_near,ivec3(gl_FragCoord.xy,1)).xyz;\n"
    "float reach=ism_reach_of(place.xyz,n,nearest,low,high),disc=3.14159265*reach*reach,area=place.w;\n"
    "float count=float(ISM_C.near_point_count)/float(ISM_C.vpl_count);\n"
    "if(!(area>.0))area=disc/(32.*count);\n"
    "if(dot(n,n)==.0)reach=.0;\n"
    "high-=low;\n"
    "vec3 at=(place.xyz-low)/max(max(high.x,max(high.y,high.z)),1e-30);\n"
    "uvec3 bits=ism_spread_bits(uvec3(clamp(at*1024.,.0,1023.)));\n"
    "result=uvec4(floatBitsToUint(vec3(sqrt(min(area,.125*disc)),reach,float(nearest))),\n"
    "bits.x|bits.y<<1|bits.z<<2);\n"
    "}\n", 0
};

static const struct { char facts[46];
    char s0[92]; char end; } glbk__glsl_prog_ism_near_sort_frag GLBK__TIGHT = {
    "prog/ism_near_sort.frag\0" "" "\0" "ism_near_sort.vert" "\0"
    "" "\0" "",
    "\n\nflat in uint ism_from;\n"
    "layout(location=0)out uint result;\n"
    "\nvoid main(){result=ism_from;}\n", 0
};

static const struct { char facts[38];
    char s0[466]; char end; } glbk__glsl_prog_ism_near_sort_vert GLBK__TIGHT = {
    "prog/ism_near_sort.vert\0" "ism_choice" "\0" "" "\0"
    "" "\0" "",
    "\n\n\nflat out uint ism_from;\n"
    "\nvoid main()\n"
    "{\n"
    "uint i=uint(gl_VertexID),count=ISM_C.near_point_count,first=i&~1023u,rank=first;\n"
    "uint own=texelFetch(glbk_ism_near_facts,ism_cell_of(i),0).w;\n"
    "for(uint k=first;k<min(first+1024u,count);k++){\n"
    "uint key=texelFetch(glbk_ism_near_facts,ism_cell_of(k),0).w;\n"
    "if(key<own||(key==own&&k<i))rank++;\n"
    "}\n"
    "ism_from=i;\n"
    "vec2 size=vec2(256u,(count+255u)>>8);\n"
    "gl_Position=vec4((vec2(ism_cell_of(rank))+.5)/size*2.-1.,.0,1.);\n"
    "gl_PointSize=1.;\n"
    "}\n", 0
};

static const struct { char facts[39];
    char s0[1033]; char end; } glbk__glsl_prog_ism_near_table_frag GLBK__TIGHT = {
    "prog/ism_near_table.frag\0" "ism_choice" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\nlayout(location=0)out uvec4 result;\n"
    "\n\nvec4 ism_sorted(uint i,uint k)\n"
    "{\n"
    "ivec2 at=ism_cell_of(texelFetch(glbk_ism_near_order,ism_cell_of(i),0).x);\n"
    "vec4 facts=ISM_FLOATS(glbk_ism_near_facts,at);\n"
    "return vec4(ISM_FLOATS(glbk_ism_near,ivec3(at,k)).xyz,k==0u?facts.x:k==1u?facts.y:facts.z);\n"
    "}\n"
    "\nvec4 ism_sphere(uint first,uint end)\n"
    "{\n"
    "vec3 low=ism_sorted(first,0u).xyz,high=low;\n"
    "for(uint i=first;i<end;i++){\n"
    "low=min(low,ism_sorted(i,0u).xyz);\n"
    "high=max(high,ism_sorted(i,0u).xyz);\n"
    "}\n"
    "vec4 sphere=vec4(.5*(low+high),.0);\n"
    "for(uint i=first;i<end;i++)\n"
    "sphere.w=max(sphere.w,distance(ism_sorted(i,0u).xyz,sphere.xyz)+ism_sorted(i,1u).w);\n"
    "return sphere;\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "uint count=ISM_C.near_point_count,at=(uint(gl_FragCoord.y)<<10)+uint(gl_FragCoord.x);\n"
    "uint i=at-ISM_C.first_near_point,block=64u*(at-ISM_C.first_sphere);\n"
    "vec4 texel;\n"
    "if(at>=ISM_C.first_near_point&&i<3u*count)texel=ism_sorted(i/3u,i%3u);\n"
    "else if(at>=ISM_C.first_sphere&&block<count)texel=ism_sphere(block,min(block+64u,count));\n"
    "else discard;\n"
    "result=floatBitsToUint(texel);\n"
    "}\n", 0
};

static const struct { char facts[54];
    char s0[2292]; char end; } glbk__glsl_prog_ism_pairs_frag GLBK__TIGHT = {
    "prog/ism_pairs.frag\0" "cohsm_math ism_access ism_fold" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\nlayout(location=0)out uint result;\n"
    "\nstruct ism_cluster{\n"
    "float area,radius2;\n"
    "vec3 at,squares,mixed;\n"
    "};\n"
    "\nism_cluster ism_read_cluster(uint c)\n"
    "{\n"
    "ivec3 at=ivec3(ism_fold(c,ISM_S.cluster_count,0u),0);\n"
    "vec4 place=ISM_FLOATS(glbk_ism_clusters,at);\n"
    "vec3 squares=ISM_FLOATS(glbk_ism_clusters,at+ivec3(0,0,1)).xyz;\n"
    "vec3 mixed=ISM_FLOATS(glbk_ism_clusters,at+ivec3(0,0,2)).xyz;\n"
    "return ism_cluster(ISM_FLOATS(glbk_ism_masses,at.xy).x,place.w,place.xyz,squares,mixed);\n"
    "}\n"
    "\n\nfloat ism_facing2(ism_cluster c,vec3 l)\n"
    "{\n"
    "return max(dot(c.squares,l*l)+2.*dot(c.mixed,l.yzx*l.zxy),.0);\n"
    "}\n"
    "\nfloat ism_cluster_effect(ism_cluster c,ism_vpl v)\n"
    "{\n"
    "if(!(c.area>.0))return .0;\n"
    "if(v.sky)return c.area*sqrt(ism_facing2(c,v.normal));\n"
    "vec3 l=c.at-v.position;\n"
    "float away2=dot(l,l),wide=.16*c.area,d2=away2+c.radius2+wide;\n"
    "float along=dot(l,v.normal)+sqrt(c.radius2);\n"
    "float facing2=ism_facing2(c,l)+c.radius2+wide;\n"
    "float effect=c.area*sqrt(facing2)*(along/(d2*d2));\n"
    "if(!(along>.0))effect=.0;\n"
    "if(!(away2>.0))effect=1.;\n"
    "return effect;\n"
    "}\n"
    "\n\nfloat ism_box_zoom(vec4 axis,float u,float r)\n"
    "{\n"
    "float size=float(ISM_F.tile_side),rim=float(ISM_F.window_rim);\n"
    "float low=max(u-r,.0),high=min(u+r,1.),from=low,to=high;\n"
    "if(axis.x<size){\n"
    "from=ism_zoom_axis(axis,size,rim,low)/size;\n"
    "to=ism_zoom_axis(axis,size,rim,high)/size;\n"
    "}\n"
    "return(to-from)/(high-low);\n"
    "}\n"
    "\n\n\nfloat ism_cluster_zoom(ism_cluster c,ism_vpl v)\n"
    "{\n"
    "vec3 origin=v.position,at;\n"
    "float d=ISM_F.sphere.w,r=sqrt(c.radius2);\n"
    "vec2 uv;\n"
    "bool seen;\n"
    "if(v.sky)origin=ISM_F.sphere.xyz;\n"
    "at=c.at-origin;\n"
    "if(!v.sky){\n"
    "float below=dot(v.basis[2],at);\n"
    "d=length(at);\n"
    "if(.05*d>below)at+=v.basis[2]*(.05*d-below);\n"
    "}\n"
    "at=at*v.basis;\n"
    "if(v.sky){\n"
    "uv=.5*at.xy/d+.5;\n"
    "seen=fract(uv)==uv;\n"
    "}else{\n"
    "seen=ism_map_coordinates(ism_projection_of(v.exponent),v.exponent,at/length(at),uv);\n"
    "}\n"
    "r=max(.5*r/d,.01);\n"
    "float zoom=ism_box_zoom(v.grid.across,uv.x,r)*ism_box_zoom(v.grid.down,uv.y,r);\n"
    "return cohsm_if(seen,zoom,1.);\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "uint count=ISM_S.cluster_count;\n"
    "uvec2 place=ism_unfold(count);\n"
    "uint v=ISM_S.first_vpl+place.y;\n"
    "float effect=.0;\n"
    "if(place.x<count&&v<ISM_F.vpl_count){\n"
    "ism_cluster c=ism_read_cluster(place.x);\n"
    "ism_vpl l=ism_read_vpl(v);\n"
    "effect=ism_cluster_effect(c,l);\n"
    "if(effect>.0&&l.window!=0u)effect*=ism_cluster_zoom(c,l);\n"
    "if(!cohsm_finite(effect))effect=.0;\n"
    "}\n"
    "result=floatBitsToUint(effect);\n"
    "}\n", 0
};

static const struct { char facts[47];
    char s0[2127]; char end; } glbk__glsl_prog_ism_points_frag GLBK__TIGHT = {
    "prog/ism_points.frag\0" "ism_densities ism_hash" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\nlayout(location=0)out uvec4 result;\n"
    "\n\n\nvec2 ism_triangle_map(float u,float v)\n"
    "{\n"
    "vec2 b=vec2(u-.5*v,.5*v);\n"
    "if(v>u)b=vec2(.5*u,v-.5*u);\n"
    "return floor(b*65535.)*(1./65535.);\n"
    "}\n"
    "\nfloat ism_triangle_density(uint t)\n"
    "{\n"
    "return ism_density(ism_folded2(glbk_ism_sizes,t,ISM_S.triangle_count));\n"
    "}\n"
    "\n\n\nuint ism_choose_triangle(uint c,float share,inout float x)\n"
    "{\n"
    "uint first=c*ISM_S.cluster_size,chosen=first;\n"
    "uint end=min(first+ISM_S.cluster_size,ISM_S.triangle_count);\n"
    "float all=ism_density(ism_folded2(glbk_ism_masses,c,ISM_S.cluster_count)),sum=.0,width=.0;\n"
    "x=x/share*all;\n"
    "for(uint t=first;t<end&&!(sum>x);t++){\n"
    "float density=ism_triangle_density(t);\n"
    "sum+=density;\n"
    "if(density>.0){\n"
    "chosen=t;\n"
    "width=density;\n"
    "}\n"
    "}\n"
    "x=width/all;\n"
    "return chosen;\n"
    "}\n"
    "\n\n\nuvec4 ism_point(uint v,uint row,uint at,uint n)\n"
    "{\n"
    "uint count=ISM_S.cluster_count,n1=ism_blocks(count),n2=ism_blocks(n1);\n"
    "uint key=ism_hash_combine(ISM_S.key,0x9000u+v);\n"
    "float all=ism_folded(glbk_ism_runs2,n2-1u,n2,row);\n"
    "float x=(float(at)+ism_to_unit(ism_hash_combine(key,at)))/float(n);\n"
    "if(ISM_S.keep!=0u)\n"
    "x=ism_to_unit(ism_hash_combine(ism_hash_combine(key,ISM_S.frame),at));\n"
    "x*=all;\n"
    "if(!(all>.0))return uvec4(0u);\n"
    "uint c=ism_find_in_block(glbk_ism_runs2,row,0u,n2,x);\n"
    "c=ism_find_in_block(glbk_ism_runs1,row,c,n1,x);\n"
    "c=ism_find_in_block(glbk_ism_runs0,row,c,count,x);\n"
    "float share=ism_folded(glbk_ism_shares,c,count,row);\n"
    "uint t=ism_choose_triangle(c,share,x);\n"
    "float probability=share/all*x;\n"
    "uint r=key+at*3242174889u,s=ism_hash32(key)+at*2447445413u;\n"
    "vec2 b=ism_triangle_map(ism_to_unit(r),ism_to_unit(s));\n"
    "float area=.0;\n"
    "if(probability>.0)area=1./(float(n)*probability);\n"
    "return uvec4(t,floatBitsToUint(vec3(b,area)));\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "uint i=ISM_S.first_texel+(uint(gl_FragCoord.y)<<10)+uint(gl_FragCoord.x);\n"
    "uint each=ISM_S.phase_surfel_count,v=i/each,row=v-ISM_S.first_vpl;\n"
    "uint at=(i-v*each)*ISM_S.lazy_frames+ISM_S.phase;\n"
    "if(v<ISM_S.first_vpl||row>=ISM_S.batch)discard;\n"
    "if(ISM_S.keep!=0u&&texelFetch(glbk_ism_gone,ISM_HERE,0).x==0u)discard;\n"
    "uint n=texelFetch(glbk_ism_counts,ism_fold(v,ISM_S.vpl_capacity,0u),0).x;\n"
    "result=uvec4(0u);\n"
    "if(at<n)result=ism_point(v,row*ISM_S.pair,at,n);\n"
    "}\n", 0
};

static const struct { char facts[70];
    char s0[297]; char end; } glbk__glsl_prog_ism_pull_frag GLBK__TIGHT = {
    "prog/ism_pull.frag\0" "ism_fill" "\0" "" "\0"
    "ISM_LEVEL=1 | ISM_LEVEL=2 | ISM_LEVEL=3" "\0" "",
    "\n\n\n\n#ifndef ISM_LEVEL\n"
    "#define ISM_LEVEL 1\n"
    "#endif\n"
    "layout(location=0)out uint result;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 cell=ISM_HERE;\n"
    "uvec4 parts;\n"
    "for(int k=0;k<4;k++)parts[k]=texelFetch(glbk_ism_below,2*cell+ivec2(k&1,k>>1),0).x;\n"
    "result=ism_pull(ISM_LEVEL,cell&((int(ISM_F.tile_side)>>ISM_LEVEL)-1),parts);\n"
    "}\n", 0
};

static const struct { char facts[77];
    char s0[335]; char end; } glbk__glsl_prog_ism_push_frag GLBK__TIGHT = {
    "prog/ism_push.frag\0" "ism_push ism_pulled" "\0" "" "\0"
    "ISM_PROJECTION=1 | ISM_PROJECTION=4" "\0" "",
    "\n\n\n\nlayout(location=0)out uint result;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ISM_HERE,from;\n"
    "uint v=ism_tile_of(at);\n"
    "float depth=ISM_FAR;\n"
    "bool fills=ISM_F.fill_levels!=0u&&v<ISM_F.vpl_count;\n"
    "if(texelFetch(glbk_ism_below,at,0).x!=0u)depth=ism_plane_at(at).w;\n"
    "else if(fills)depth=ism_filled(ism_read_grid(v),at,from);\n"
    "result=floatBitsToUint(depth);\n"
    "}\n", 0
};

static const struct { char facts[55];
    char s0[707]; char end; } glbk__glsl_prog_ism_receivers_frag GLBK__TIGHT = {
    "prog/ism_receivers.frag\0" "cohsm_math ism_fold gbuffer" "\0" "" "\0"
    "" "\0" "",
    "\n\n\nlayout(location=0)out uvec4 result;\n"
    "\nvoid main()\n"
    "{\n"
    "uint width=ISM_S.view_width,n0=width*ISM_S.view_height;\n"
    "uint n1=ism_blocks(n0),n2=ism_blocks(n1),n3=ism_blocks(n2),n4=ism_blocks(n3);\n"
    "uint i=ism_unfold(n0).x;\n"
    "float x=float(i)+.5,all=ism_folded(glbk_ism_runs4,n4-1u,n4,0u);\n"
    "result=uvec4(0u);\n"
    "if(!(x<all))return;\n"
    "uint k=ism_find_in_block(glbk_ism_runs4,0u,0u,n4,x);\n"
    "k=ism_find_in_block(glbk_ism_runs3,0u,k,n3,x);\n"
    "k=ism_find_in_block(glbk_ism_runs2,0u,k,n2,x);\n"
    "k=ism_find_in_block(glbk_ism_runs1,0u,k,n1,x);\n"
    "k=ism_find_in_block(glbk_ism_runs0,0u,k,n0,x);\n"
    "glbk_point p;\n"
    "uint row=k/width;\n"
    "bool seen=glbk_read_point(ivec2(k-row*width,row),p);\n"
    "result=floatBitsToUint(vec4(p.position,cohsm_if(seen,1.,.0)));\n"
    "}\n", 0
};

static const struct { char facts[54];
    char s0[304]; char end; } glbk__glsl_prog_ism_resolve_frag GLBK__TIGHT = {
    "prog/ism_resolve.frag\0" "ism_bindings gbuffer picture" "\0" "" "\0"
    "" "\0" "",
    "\n\n\nlayout(location=0)out vec4 result;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=glbk_picture_at();\n"
    "glbk_point p;\n"
    "bool seen=glbk_read_point(at,p);\n"
    "glbk_picture_show(seen,p.position);\n"
    "vec3 albedo=seen?p.diffuse*(1.-p.metallic):vec3(.0);\n"
    "result=vec4(glbk_unpack(texelFetch(glbk_ism_light,at,0)).xyz*albedo*.318309886,1.);\n"
    "}\n", 0
};

static const struct { char facts[30];
    char s0[479]; char end; } glbk__glsl_prog_ism_run_frag GLBK__TIGHT = {
    "prog/ism_run.frag\0" "ism_fold" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\nlayout(location=0)out uvec2 result;\n"
    "\nvoid main()\n"
    "{\n"
    "uint pace=ISM_S.pace,count=ISM_S.value_count,own=ism_blocks(count);\n"
    "if(pace!=0u)own=(count+pace-1u)/pace;\n"
    "uvec2 place=ism_unfold(own);\n"
    "uint k=32u*place.x,end=min(k+32u,count);\n"
    "if(pace!=0u){\n"
    "k=place.x-(place.x&31u);\n"
    "end=min(place.x+1u,own);\n"
    "}\n"
    "vec2 sum=vec2(.0);\n"
    "for(;k<end;k++){\n"
    "uint i=pace==0u?k:min(pace*k+pace-1u,count-1u);\n"
    "sum+=ISM_FLOATS(glbk_ism_values,ism_fold(i,count,place.y)).xy;\n"
    "}\n"
    "result=floatBitsToUint(sum);\n"
    "}\n", 0
};

static const struct { char facts[33];
    char s0[429]; char end; } glbk__glsl_prog_ism_scan_frag GLBK__TIGHT = {
    "prog/ism_scan.frag\0" "ism_choice" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\n\nlayout(location=0)out uvec2 result;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ISM_HERE,along=ivec2(1,0);\n"
    "if(ISM_C.columns!=0u)along=ivec2(0,1);\n"
    "int i=at.x*along.x+at.y*along.y;\n"
    "int pace=int(ISM_C.pace),last=int(ISM_C.value_count)-1;\n"
    "ivec2 base=at-along*i+ivec2(int(ISM_C.first_column),0);\n"
    "vec2 sum=vec2(.0);\n"
    "for(int k=i-(i&31);k<=i;k++)\n"
    "sum+=ISM_FLOATS(glbk_ism_summed,base+along*min(pace*k+pace-1,last)).xy;\n"
    "result=floatBitsToUint(sum);\n"
    "}\n", 0
};

static const struct { char facts[50];
    char s0[343]; char end; } glbk__glsl_prog_ism_seen_frag GLBK__TIGHT = {
    "prog/ism_seen.frag\0" "cohsm_math ism_fold gbuffer" "\0" "" "\0"
    "" "\0" "",
    "\n\n\nlayout(location=0)out uint result;\n"
    "\nvoid main()\n"
    "{\n"
    "uint width=ISM_S.view_width,count=width*ISM_S.view_height;\n"
    "uint i=ism_unfold(count).x,j=min(i,count-1u),row=j/width;\n"
    "glbk_point p;\n"
    "bool seen=glbk_read_point(ivec2(j-row*width,row),p);\n"
    "seen=seen&&i<count&&cohsm_finite3(p.position)&&dot(p.normal,p.normal)>.25;\n"
    "result=seen?0x3f800000u:0u;\n"
    "}\n", 0
};

static const struct { char facts[188];
    char s0[1351]; char end; } glbk__glsl_prog_ism_shade_comp GLBK__TIGHT = {
    "prog/ism_shade.comp\0" "ism_gbuffer ism_light" "\0" "" "\0"
    "ISM_PROJECTION=1 ISM_NEAR=1 | ISM_PROJECTION=2 ISM_NEAR=2 | ISM_PROJECTION=3 ISM_NEAR=3 | ISM_PROJECTION=4 ISM_NEAR=4 | ISM_NEAR=5 | ISM_NEAR=6" "\0" "",
    "\n\n\n\n\nlayout(local_size_x=16,local_size_y=16)in;\n"
    "#define ISM_ROUND 64u\n"
    "\nshared ism_vpl ism_read[ISM_ROUND];\n"
    "\n\nuint ism_round(uint first,uint set_count,uint used,uint from)\n"
    "{\n"
    "uint k=gl_LocalInvocationIndex,count=min(used-from,ISM_ROUND);\n"
    "barrier();\n"
    "if(k<count)ism_read[k]=ism_read_vpl(first+(from+k)*set_count);\n"
    "barrier();\n"
    "return count;\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "uint side=glbk_ism_view.interleave,set_count=side*side,first=gl_WorkGroupID.z;\n"
    "uint used=ism_used(first,set_count);\n"
    "ivec2 at=ivec2(gl_GlobalInvocationID.xy*side+uvec2(first%side,first/side));\n"
    "at.y+=int(glbk_ism_view.first_row);\n"
    "bool inside=all(lessThan(at,ism_picture_side()));\n"
    "float most=glbk_ism_view.clamp_at;\n"
    "vec4 sum=vec4(.0);\n"
    "ism_receiver r;\n"
    "bool lit=inside&&ism_read_receiver(at,r);\n"
    "#if ISM_NEAR == 4\n"
    "float all_of_them=.0;\n"
    "for(uint from=0u;from<used;from+=ISM_ROUND){\n"
    "uint count=ism_round(first,set_count,used,from);\n"
    "for(uint k=0u;k<count&&lit;k++)all_of_them+=ism_unshadowed(ism_read[k],r.p,r.n);\n"
    "}\n"
    "most*=used>0u?all_of_them/float(used):.0;\n"
    "#endif\n"
    "for(uint from=0u;from<used;from+=ISM_ROUND){\n"
    "uint count=ism_round(first,set_count,used,from);\n"
    "for(uint k=0u;k<count&&lit;k++)\n"
    "ism_add(sum,first+(from+k)*set_count,ism_read[k],r.p,r.n,r.ng,most);\n"
    "}\n"
    "sum=ism_scaled(sum,set_count);\n"
    "#if ISM_NEAR == 6\n"
    "if(lit)sum+=ism_gather(r.p,r.n,r.ng);\n"
    "#endif\n"
    "if(inside)imageStore(glbk_ism_light_out,at,sum);\n"
    "}\n", 0
};

static const struct { char facts[188];
    char s0[299]; char end; } glbk__glsl_prog_ism_shade_frag GLBK__TIGHT = {
    "prog/ism_shade.frag\0" "ism_gbuffer ism_light" "\0" "" "\0"
    "ISM_PROJECTION=1 ISM_NEAR=1 | ISM_PROJECTION=2 ISM_NEAR=2 | ISM_PROJECTION=3 ISM_NEAR=3 | ISM_PROJECTION=4 ISM_NEAR=4 | ISM_NEAR=5 | ISM_NEAR=6" "\0" "",
    "\n\n\n\n\n\nlayout(location=0)out glbk_color result;\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ISM_HERE;\n"
    "uint side=glbk_ism_view.interleave;\n"
    "uvec2 place=uvec2(at)%side;\n"
    "ism_receiver r;\n"
    "vec4 light=vec4(.0);\n"
    "if(ism_read_receiver(at,r))light=ism_light(r.p,r.n,r.ng,place.y*side+place.x,side*side);\n"
    "result=glbk_pack(light);\n"
    "}\n", 0
};

static const struct { char facts[38];
    char s0[553]; char end; } glbk__glsl_prog_ism_shares_frag GLBK__TIGHT = {
    "prog/ism_shares.frag\0" "ism_densities" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\nlayout(location=0)out uint result;\n"
    "\nvoid main()\n"
    "{\n"
    "uint count=ISM_S.cluster_count;\n"
    "uvec2 place=ism_unfold(count);\n"
    "float share=.0;\n"
    "if(place.x<count){\n"
    "float p=ism_density(ism_folded2(glbk_ism_masses,place.x,count)),q=p;\n"
    "ivec2 end=textureSize(glbk_ism_runs4,0)-1;\n"
    "if(ISM_S.pair!=0u&&ISM_FLOATS(glbk_ism_runs4,end).x>.0){\n"
    "float all=ISM_FLOATS(glbk_ism_effect_totals,ivec2(0,int(place.y))).x;\n"
    "float effect=ism_folded(glbk_ism_values,place.x,count,place.y);\n"
    "if(all>.0)q=effect/all;\n"
    "}\n"
    "if(p>.0)share=sqrt(p*q)+.05*(p+q);\n"
    "}\n"
    "result=floatBitsToUint(share);\n"
    "}\n", 0
};

static const struct { char facts[56];
    char s0[1521]; char end; } glbk__glsl_prog_ism_sights_frag GLBK__TIGHT = {
    "prog/ism_sights.frag\0" "ism_pvpl gbuffer" "\0" "" "\0"
    "FROM=0 | FROM=1" "\0" "",
    "\n\n\n\n\n\n#ifndef FROM\n"
    "#define FROM 0\n"
    "#endif\n"
    "layout(location=0)out uvec4 first;\n"
    "layout(location=1)out uvec4 second;\n"
    "\n\nvec4 ism_reach(vec3 p,float z)\n"
    "{\n"
    "return p.x*vec4(-1.,1.,-1.,1.)+.9*(p.y*vec4(-1.,-1.,1.,1.))+1.1*z;\n"
    "}\n"
    "\n\nvoid ism_keep(uint pixel,vec4 reach,inout uvec4 best,inout vec4 most)\n"
    "{\n"
    "bvec4 better=greaterThan(reach,most);\n"
    "best+=(uvec4(pixel)-best)*uvec4(better);\n"
    "most=max(reach,most);\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ISM_HERE,side=ivec2(ISM_C.view_width,ISM_C.view_height);\n"
    "glbk_point p;\n"
    "first=second=uvec4(0u);\n"
    "#if FROM == 0\n"
    "int rows=side.y<8?1:8;\n"
    "ivec2 blocks=ivec2(64/rows,rows),block=ivec2(at.x%blocks.x,at.x/blocks.x);\n"
    "ivec2 from=side*block/blocks,to=side*(block+1)/blocks;\n"
    "vec4 most0=vec4(-3e38),most1=most0;\n"
    "int y=from.y+(to.y-from.y)*at.y/32,end=from.y+(to.y-from.y)*(at.y+1)/32;\n"
    "for(;y<end;y++)\n"
    "for(int x=from.x;x<to.x;x++){\n"
    "bool seen=glbk_read_point(ivec2(x,y),p);\n"
    "if(seen&&cohsm_finite3(p.position)&&dot(p.normal,p.normal)>.25){\n"
    "uint pixel=uint(y*side.x+x)+1u;\n"
    "ism_keep(pixel,ism_reach(p.position,-p.position.z),first,most0);\n"
    "ism_keep(pixel,ism_reach(p.position,p.position.z),second,most1);\n"
    "}\n"
    "}\n"
    "#else\n"
    "float most=-3e38;\n"
    "for(int k=0;k<32;k++){\n"
    "int pixel=int(texelFetch(glbk_ism_sights,ivec3(at.x,k,at.y>>2),0)[at.y&3])-1,i=max(pixel,0);\n"
    "bool seen=glbk_read_point(ivec2(i%side.x,i/side.x),p);\n"
    "float reach=ism_reach(p.position,p.position.z*(at.y<4?-1.:1.))[at.y&3];\n"
    "if(seen&&pixel>=0&&reach>most){\n"
    "most=reach;\n"
    "first=floatBitsToUint(vec4(p.position,1.));\n"
    "second=floatBitsToUint(vec4(p.geometric,.0));\n"
    "}\n"
    "}\n"
    "#endif\n"
    "}\n", 0
};

static const struct { char facts[64];
    char s0[1619]; char end; } glbk__glsl_prog_ism_sizes_frag GLBK__TIGHT = {
    "prog/ism_sizes.frag\0" "cohsm_math ism_corners ism_fold ism_hash" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\nlayout(location=0)out uvec2 result;\n"
    "\n\nuint ism_multiply_high(uint a,uint b)\n"
    "{\n"
    "uint a0=a&0xffffu,a1=a>>16,b0=b&0xffffu,b1=b>>16;\n"
    "uint middle=a1*b0+(a0*b0>>16),rest=a0*b1+(middle&0xffffu);\n"
    "return a1*b1+(middle>>16)+(rest>>16);\n"
    "}\n"
    "\n\nfloat ism_solid_angle(vec3 a,vec3 b,vec3 c)\n"
    "{\n"
    "float la=length(a),lb=length(b),lc=length(c);\n"
    "float top=abs(dot(a,cross(b,c)));\n"
    "float below=la*lb*lc+dot(a,b)*lc+dot(a,c)*lb+dot(b,c)*la;\n"
    "float omega=.0;\n"
    "if(top>.0&&cohsm_finite(top)&&cohsm_finite(below))omega=max(2.*cohsm_atan2(top,below),.0);\n"
    "return omega;\n"
    "}\n"
    "\n\n\nfloat ism_solid_angle_from(vec3 eye,ism_corners p,vec3 normal2,float area2)\n"
    "{\n"
    "vec3 a=p.a-eye;\n"
    "float d2=dot(a,a),omega=.5*abs(dot(normal2,a))/(d2*sqrt(d2));\n"
    "if(!(.01*d2>area2))omega=ism_solid_angle(a,p.b-eye,p.c-eye);\n"
    "return omega;\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "uint count=ISM_S.triangle_count,views=ISM_S.views;\n"
    "uint t=ism_unfold(count).x;\n"
    "result=uvec2(0u);\n"
    "if(t>=count)return;\n"
    "ism_corners p=ism_read_corners(t);\n"
    "vec3 normal2=ism_normal2(p);\n"
    "float area2=length(normal2),solid=.0;\n"
    "if(!(area2>.0)||!cohsm_finite(area2))return;\n"
    "uint pixels=ISM_S.view_width*ISM_S.view_height,valid=0u;\n"
    "if(views>0u){\n"
    "ivec2 end=textureSize(glbk_ism_runs4,0)-1;\n"
    "valid=uint(ISM_FLOATS(glbk_ism_runs4,end).x);\n"
    "}\n"
    "uint key=ism_hash_combine(ISM_S.seed,0x7000u+cohsm_if(views==1u,0u,t));\n"
    "for(uint k=0u;k<views&&valid>0u;k++){\n"
    "uint i=ism_multiply_high(ism_hash_combine(key,k),valid);\n"
    "vec3 eye=ISM_FLOATS(glbk_ism_receivers,ism_fold(i,pixels,0u)).xyz;\n"
    "solid+=ism_solid_angle_from(eye,p,normal2,area2);\n"
    "}\n"
    "if(views>0u)solid/=float(views);\n"
    "if(!cohsm_finite(solid))solid=.0;\n"
    "result=floatBitsToUint(vec2(.5*area2,solid));\n"
    "}\n", 0
};

static const struct { char facts[67];
    char s0[3993]; char s1[306]; char end; } glbk__glsl_prog_ism_splat_comp GLBK__TIGHT = {
    "prog/ism_splat.comp\0" "ism_disc" "\0" "" "\0"
    "ISM_PROJECTION=1 | ISM_PROJECTION=4" "\0" "",
    "\n\n\n\n\n\nlayout(local_size_x=512)in;\n"
    "#define ISM_THREADS 512u\n"
    "#define ISM_SIDE 64\n"
    "#define ISM_WIDE 64\n"
    "#define ISM_LIST 112u\n"
    "#define ISM_HOPE 0x80000000u\n"
    "\nshared uint ism_depths[ISM_SIDE*ISM_SIDE];\n"
    "shared uint ism_owners[ISM_SIDE*ISM_SIDE/2];\n"
    "shared vec4 ism_list[4u*ISM_LIST];\n"
    "shared uint ism_numbers[ISM_LIST],ism_listed;\n"
    "shared uint ism_boxes[ISM_LIST];\n"
    "\nuint ism_v;\n"
    "ism_vpl ism_l;\n"
    "ivec4 ism_part;\n"
    "uint ism_hopes[4];\n"
    "\n\n\nbool ism_find(uint i,out ism_surfel s)\n"
    "{\n"
    "uint each=ISM_F.phase_surfel_count;\n"
    "uint index=(i/each*ISM_F.vpl_capacity+ism_v)*each+i%each;\n"
    "if(!ism_surfel_of(index,ism_v,ism_l,s))return false;\n"
    "s.box=ivec4(max(s.box.xy,ism_part.xy),min(s.box.zw,ism_part.zw));\n"
    "return s.box.x<=s.box.z&&s.box.y<=s.box.w;\n"
    "}\n"
    "\n\nuint ism_owner(uint texel){return ism_owners[texel>>1]>>(16u*(texel&1u))&0xffffu;}\n"
    "\n\nvoid ism_own(uint texel,uint surfel)\n"
    "{\n"
    "uint shift=16u*(texel&1u),was=ism_owners[texel>>1];\n"
    "while((was>>shift&0xffffu)>surfel){\n"
    "uint now=atomicCompSwap(ism_owners[texel>>1],was,(was&~(0xffffu<<shift))|surfel<<shift);\n"
    "if(now==was)break;\n"
    "was=now;\n"
    "}\n"
    "}\n"
    "\n\n\nbool ism_draw(int turn,uint i,ism_surfel s,ivec2 from,ivec2 pace)\n"
    "{\n"
    "ivec2 at=s.box.xy+from;\n"
    "bool nearest=false;\n"
    "while(at.x<=s.box.z&&at.y<=s.box.w){\n"
    "uint texel=uint((at.y-ism_part.y)*ISM_SIDE+at.x-ism_part.x),depth=ism_depths[texel];\n"
    "float t=ism_meet(ism_l.sky,s,ism_texel_direction(ism_l.grid,at),uintBitsToFloat(depth));\n"
    "if(t<ISM_FAR){\n"
    "uint bits=floatBitsToUint(t);\n"
    "if(turn==0)nearest=atomicMin(ism_depths[texel],bits)>=bits||nearest;\n"
    "else if(depth==bits)ism_own(texel,i);\n"
    "}\n"
    "at.x+=pace.x;\n"
    "if(at.x>s.box.z)at=ivec2(s.box.x+from.x,at.y+pace.y);\n"
    "}\n"
    "return nearest;\n"
    "}\n"
    "\n\nuint ism_pack(ivec4 box)\n"
    "{\n"
    "uvec4 b=uvec4(box-ism_part.xyxy);\n"
    "return b.x|b.y<<8|b.z<<16|b.w<<24;\n"
    "}\n"
    "\n\nism_surfel ism_unlist(uint k)\n"
    "{\n"
    "vec4 a=ism_list[4u*k],b=ism_list[4u*k+1u];\n"
    "uint box=ism_boxes[k];\n"
    "ivec4 texels=ivec4(box&63u,box>>8&63u,box>>16&63u,box>>24&63u)+ism_part.xyxy;\n"
    "return ism_surfel(a.xyz,b.xyz,a.w,.0,vec2(.0),ism_list[4u*k+2u],ism_list[4u*k+3u],\n"
    "texels);\n"
    "}\n"
    "\n\n\nbool ism_draw_list(int turn,uint i,ism_surfel s,bool waits)\n"
    "{\n"
    "uint thread=gl_LocalInvocationIndex,count;\n"
    "ivec2 mine=ivec2(thread&7u,thread/8u&3u);\n"
    "bool nearest=false;\n"
    "do{\n"
    "uint k=waits?atomicAdd(ism_listed,1u):ISM_LIST;\n"
    "bool listed=k<ISM_LIST;\n"
    "if(listed){\n"
    "ism_list[4u*k]=vec4(s.at,s.radius2);\n"
    "ism_list[4u*k+1u]=vec4(s.g,.0);\n"
    "ism_list[4u*k+2u]=s.cut1;\n"
    "ism_list[4u*k+3u]=s.cut2;\n"
    "ism_boxes[k]=ism_pack(s.box);\n"
    "ism_numbers[k]=i;\n"
    "}\n"
    "waits=waits&&!listed;\n"
    "barrier();\n"
    "count=ism_listed;\n"
    "for(uint d=thread/32u;d<min(count,ISM_LIST);d+=ISM_THREADS/32u)\n"
    "if(ism_draw(turn,ism_numbers[d],ism_unlist(d),mine,ivec2(8,4)))\n"
    "atomicOr(ism_boxes[d],ISM_HOPE);\n"
    "barrier();\n"
    "if(thread==0u)ism_listed=0u;\n"
    "if(listed&&(ism_boxes[k]&ISM_HOPE)!=0u)nearest=true;\n"
    "barrier();\n"
    "}while(count>ISM_LIST);\n"
    "return nearest;\n"
    "}\n"
    "\n\n\nvoid ism_draw_all(int turn,uint count)\n"
    "{\n"
    "for(uint start=0u;start<count;start+=ISM_THREADS){\n"
    "uint i=start+gl_LocalInvocationIndex,lap=start/ISM_THREADS;\n"
    "uint word=lap>>5,bit=1u<<(lap&31u);\n"
    "ism_surfel s;\n"
    "bool there=i<count&&(turn==0||(ism_hopes[word]&bit)!=0u)&&ism_find(i,s);\n"
    "ivec2 wide=there?s.box.zw-s.box.xy+1:ivec2(0);\n"
    "bool waits=wide.x*wide.y>ISM_WIDE;\n"
    "bool nearest=there&&!waits&&ism_draw(turn,i,s,ivec2(0),ivec2(1));\n"
    "if(ism_draw_list(turn,i,s,waits)||nearest)ism_hopes[word]|=bit;\n"
    "}\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "uint thread=gl_LocalInvocationIndex,count;\n"
    "int side=min(int(ISM_F.tile_side),ISM_SIDE);\n"
    "ivec2 begin=ivec2(gl_WorkGroupID.xy)*side;\n"
    "ism_surfel s;\n"
    "ism_hopes=uint[4](0u,0u,0u,0u);\n"
    "ism_v=ism_tile_of(begin);\n"
    "ism_part=(begin-ism_tile_at(ism_v)).xyxy+ivec4(0,0,side-1,side-1);\n"
    "count=ISM_F.triangle_count!=0u?ISM_F.surfel_count:0u;\n"
    "if(ism_v>=ISM_F.vpl_count)count=0u;\n"
    "ism_l=ism_read_vpl(min(ism_v,ISM_F.vpl_capacity-1u));\n"
    "for(uint i=thread;i<uint(ISM_SIDE*ISM_SIDE);i+=ISM_THREADS){\n"
    "ism_depths[i]=floatBitsToUint(ISM_FAR);\n"
    "ism_owners[i>>1]=0xffffffffu;\n"
    "}\n"
    "if(thread==0u)ism_listed=0u;\n"
    "barrier();\n"
    "for(int turn=0;turn<2;turn++)ism_draw_all(turn,count);\n"
    "for(uint i=thread;i<uint(ISM_SIDE*ISM_SIDE);i+=ISM_THREADS){\n",
    "ivec2 texel=ivec2(i%uint(ISM_SIDE),i/uint(ISM_SIDE));\n"
    "vec4 surfel=vec4(.0,.0,.0,ISM_FAR);\n"
    "if(max(texel.x,texel.y)>=side)continue;\n"
    "if(ism_depths[i]!=floatBitsToUint(ISM_FAR)&&ism_find(ism_owner(i),s))\n"
    "surfel=vec4(s.g,uintBitsToFloat(ism_depths[i]));\n"
    "imageStore(glbk_ism_planes_out,begin+texel,surfel);\n"
    "}\n"
    "}\n", 0
};

static const struct { char facts[127];
    char s0[777]; char end; } glbk__glsl_prog_ism_splat_frag GLBK__TIGHT = {
    "prog/ism_splat.frag\0" "ism_disc" "\0" "ism_splat.vert" "\0"
    "ISM_PROJECTION=1 ISM_QUADS=0 ISM_HITS=0 | ISM_PROJECTION=4 ISM_QUADS=1 ISM_HITS=1" "\0" "",
    "\n\n\n\nflat in vec4 ism_at;\n"
    "flat in vec4 ism_plane;\n"
    "flat in vec4 ism_across;\n"
    "flat in vec4 ism_down;\n"
    "flat in ivec4 ism_box;\n"
    "flat in vec4 ism_cut1;\n"
    "flat in vec4 ism_cut2;\n"
    "layout(location=0)out glbk_color result;\n"
    "#if ISM_HITS\n"
    "flat in uint ism_triangle;\n"
    "layout(location=1)out uint hit;\n"
    "#endif\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ISM_HERE;\n"
    "if(clamp(at,ism_box.xy,ism_box.zw)!=at)discard;\n"
    "ism_surfel s=ism_surfel(ism_at.xyz,ism_plane.xyz,ism_at.w,.0,vec2(.0),ism_cut1,ism_cut2,\n"
    "ism_box);\n"
    "ism_grid grid=ism_grid(ism_plane.w,ism_across,ism_down);\n"
    "vec3 w=ism_texel_direction(grid,at&(int(ISM_F.tile_side)-1));\n"
    "float t=ism_meet(ism_plane.w<.0,s,w,ISM_FAR);\n"
    "if(!(t<ISM_FAR))discard;\n"
    "result=glbk_pack(vec4(ism_plane.xyz,t));\n"
    "#if ISM_HITS\n"
    "hit=ism_triangle;\n"
    "#endif\n"
    "gl_FragDepth=t*5.421010862427522e-20;\n"
    "}\n", 0
};

static const struct { char facts[32];
    char s0[1346]; char end; } glbk__glsl_prog_ism_splat_vert GLBK__TIGHT = {
    "prog/ism_splat.vert\0" "ism_disc" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n#ifndef ISM_QUADS\n"
    "#define ISM_QUADS 0\n"
    "#endif\n"
    "#ifndef ISM_HITS\n"
    "#define ISM_HITS 0\n"
    "#endif\n"
    "flat out vec4 ism_at;\n"
    "flat out vec4 ism_plane;\n"
    "flat out vec4 ism_across;\n"
    "flat out vec4 ism_down;\n"
    "flat out ivec4 ism_box;\n"
    "flat out vec4 ism_cut1;\n"
    "flat out vec4 ism_cut2;\n"
    "#if ISM_HITS\n"
    "flat out uint ism_triangle;\n"
    "#endif\n"
    "\nvoid main()\n"
    "{\n"
    "#if ISM_QUADS\n"
    "uint index=uint(gl_InstanceID)+ISM_F.first_surfel;\n"
    "#else\n"
    "uint index=uint(gl_VertexID);\n"
    "gl_PointSize=1.;\n"
    "#endif\n"
    "uint v=index/ISM_F.phase_surfel_count;\n"
    "ism_surfel s;\n"
    "gl_Position=vec4(2.,2.,2.,1.);\n"
    "ism_at=vec4(.0);\n"
    "ism_plane=vec4(.0);\n"
    "ism_across=ism_down=vec4(.0);\n"
    "ism_box=ivec4(0);\n"
    "ism_cut1=ism_cut2=vec4(.0);\n"
    "#if ISM_HITS\n"
    "ism_triangle=texelFetch(glbk_ism_surfels,glbk_table_at(index),0).x;\n"
    "#endif\n"
    "if(v>=ISM_F.vpl_count)return;\n"
    "ism_vpl l=ism_read_vpl(v);\n"
    "if(!ism_surfel_of(index,v,l,s))return;\n"
    "ism_at=vec4(s.at,s.radius2);\n"
    "ism_plane=vec4(s.g,l.grid.exponent);\n"
    "ism_across=l.grid.across;\n"
    "ism_down=l.grid.down;\n"
    "ism_cut1=s.cut1;\n"
    "ism_cut2=s.cut2;\n"
    "ism_box=s.box+ism_tile_at(v).xyxy;\n"
    "#if ISM_QUADS\n"
    "vec2 at=vec2((gl_VertexID&1)!=0?ism_box.z+1:ism_box.x,\n"
    "(gl_VertexID&2)!=0?ism_box.w+1:ism_box.y);\n"
    "#else\n"
    "vec2 at=.5*vec2(ism_box.xy+ism_box.zw+1);\n"
    "ivec2 wide=s.box.zw-s.box.xy;\n"
    "gl_PointSize=float(max(wide.x,wide.y)+1);\n"
    "#endif\n"
    "uint side=ISM_F.tile_side*ISM_F.tiles_across;\n"
    "gl_Position=vec4(at/float(side)*2.-1.,.0,1.);\n"
    "}\n", 0
};

static const struct { char facts[32];
    char s0[1087]; char end; } glbk__glsl_prog_ism_weigh_frag GLBK__TIGHT = {
    "prog/ism_weigh.frag\0" "ism_pvpl" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n\n\nlayout(location=0)out uvec2 result;\n"
    "\nfloat ism_effect_at(ivec2 at){return ISM_FLOATS(glbk_ism_effects,at).x;}\n"
    "\nfloat ism_blurred(ivec2 at,ism_pvpl q)\n"
    "{\n"
    "int radius=int(ISM_C.blur_radius),height=int(ISM_C.face_height);\n"
    "ivec2 lowest=ivec2(0,at.y/height*height);\n"
    "ivec2 highest=lowest+ivec2(int(ISM_C.width),height)-1;\n"
    "ivec2 from=max(at-radius,lowest),to=min(at+radius,highest);\n"
    "float sum=.0,weights=.0;\n"
    "for(int y=from.y;y<=to.y;y++)\n"
    "for(int x=from.x;x<=to.x;x++){\n"
    "ism_pvpl o=ism_read_pvpl(ivec2(x,y));\n"
    "vec3 d=o.position-q.position;\n"
    "float weight=dot(q.normal,o.normal);\n"
    "if(o.luminance>.0&&weight>.5&&abs(dot(q.normal,d))<=.3*length(d)){\n"
    "sum+=weight*ism_effect_at(ivec2(x,y));\n"
    "weights+=weight;\n"
    "}\n"
    "}\n"
    "float mean=ism_effect_at(at);\n"
    "if(weights>.0)mean=sum/weights;\n"
    "return mean;\n"
    "}\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ISM_HERE;\n"
    "ism_pvpl q=ism_read_pvpl(at);\n"
    "float effect=.0;\n"
    "if(ISM_C.by_effect!=0u&&q.luminance>.0){\n"
    "if(ISM_C.blur_radius==0u)effect=ism_effect_at(at);\n"
    "else effect=ism_blurred(at,q);\n"
    "if(ISM_C.by_mean==0u)effect=sqrt(effect);\n"
    "}\n"
    "result=floatBitsToUint(vec2(q.luminance*effect,q.luminance));\n"
    "}\n", 0
};

static const struct { char facts[89];
    char s0[1380]; char end; } glbk__glsl_prog_ism_windows_frag GLBK__TIGHT = {
    "prog/ism_windows.frag\0" "ism_map ism_choice ism_frame" "\0" "" "\0"
    "ISM_PROJECTION=1 | ISM_PROJECTION=2" "\0" "",
    "\n\n\n\n\n\nlayout(location=0)out uvec4 result;\n"
    "\nvec4 ism_drawn(ivec2 at,int k){return ISM_FLOATS(glbk_ism_drawn,ivec3(at,k));}\n"
    "\nvoid main()\n"
    "{\n"
    "ivec2 at=ISM_HERE;\n"
    "vec4 facing=ism_drawn(at,1),across,down;\n"
    "vec3 place=ism_drawn(at,0).xyz;\n"
    "uint face=(uint(ism_drawn(at,2).w)&127u)<<24,side=glbk_ism_frame.tile_side,window=0u;\n"
    "uvec4 before=texelFetch(glbk_ism_windows,at,0);\n"
    "vec2 lo=vec2(1.),hi=vec2(.0),uv;\n"
    "mat3 basis=ism_basis_of(facing.xyz);\n"
    "for(int i=0;i<512;i++){\n"
    "vec4 p=ISM_FLOATS(glbk_ism_sights,ivec3(i&63,i>>6,0));\n"
    "vec3 n=ISM_FLOATS(glbk_ism_sights,ivec3(i&63,i>>6,1)).xyz;\n"
    "vec3 d=p.xyz-place,l=d*basis;\n"
    "bool before_it=ism_map_coordinates(ism_projection_of(1.),1.,l/length(l),uv);\n"
    "if(before_it&&p.w>.0&&dot(n,d)<.0){\n"
    "lo=min(lo,uv);\n"
    "hi=max(hi,uv);\n"
    "}\n"
    "}\n"
    "vec2 pad=(hi-lo)*.015625;\n"
    "uvec4 need=uvec4(clamp(64.*vec4(lo-pad,hi+pad),.0,63.));\n"
    "need.zw=63u-need.zw;\n"
    "uvec4 was=ism_cut(before.w);\n"
    "vec3 moved=place-uintBitsToFloat(before.xyz);\n"
    "bool known=ISM_C.windows==2u&&(before.w&0x7f000000u)==face;\n"
    "known=known&&dot(moved,moved)<=facing.w*facing.w;\n"
    "uvec4 kept=uvec4(lessThanEqual(was,need))*uvec4(greaterThanEqual(was+2u,need));\n"
    "if(known)need+=(was-need)*kept;\n"
    "if(lo.x<=hi.x)window=need.x|need.y<<6|need.z<<12|need.w<<18;\n"
    "ism_axes(window,side,glbk_ism_frame.window_rim,across,down);\n"
    "if(min(across.x,down.x)>=float(side))face|=0x80000000u;\n"
    "result=uvec4(floatBitsToUint(place),window|face);\n"
    "}\n", 0
};

static const glbk_file glbk__ism_files[] = {
    { (const char *)&glbk__ism_files_lib_cohsm_math_glsl },
    { (const char *)&glbk__glsl_lib_ism_access_glsl },
    { (const char *)&glbk__glsl_lib_ism_bindings_glsl },
    { (const char *)&glbk__glsl_lib_ism_blur_glsl },
    { (const char *)&glbk__glsl_lib_ism_choice_glsl },
    { (const char *)&glbk__glsl_lib_ism_choosing_glsl },
    { (const char *)&glbk__glsl_lib_ism_corners_glsl },
    { (const char *)&glbk__glsl_lib_ism_densities_glsl },
    { (const char *)&glbk__glsl_lib_ism_disc_glsl },
    { (const char *)&glbk__glsl_lib_ism_fill_glsl },
    { (const char *)&glbk__glsl_lib_ism_floats_glsl },
    { (const char *)&glbk__glsl_lib_ism_fold_glsl },
    { (const char *)&glbk__glsl_lib_ism_frame_glsl },
    { (const char *)&glbk__glsl_lib_ism_gbuffer_glsl },
    { (const char *)&glbk__glsl_lib_ism_hash_glsl },
    { (const char *)&glbk__glsl_lib_ism_holes_glsl },
    { (const char *)&glbk__glsl_lib_ism_inter_texel_glsl },
    { (const char *)&glbk__glsl_lib_ism_light_glsl },
    { (const char *)&glbk__glsl_lib_ism_map_glsl },
    { (const char *)&glbk__glsl_lib_ism_pulled_glsl },
    { (const char *)&glbk__glsl_lib_ism_push_glsl },
    { (const char *)&glbk__glsl_lib_ism_pvpl_glsl },
    { (const char *)&glbk__glsl_lib_ism_reach_glsl },
    { (const char *)&glbk__glsl_lib_ism_scattering_glsl },
    { (const char *)&glbk__glsl_lib_ism_search_glsl },
    { (const char *)&glbk__glsl_lib_ism_view_glsl },
    { (const char *)&glbk__glsl_prog_ism_blur_comp },
    { (const char *)&glbk__glsl_prog_ism_blur_frag },
    { (const char *)&glbk__glsl_prog_ism_bounce_frag },
    { (const char *)&glbk__glsl_prog_ism_choose_frag },
    { (const char *)&glbk__glsl_prog_ism_clusters_frag },
    { (const char *)&glbk__glsl_prog_ism_counts_frag },
    { (const char *)&glbk__glsl_prog_ism_edges_frag },
    { (const char *)&glbk__glsl_prog_ism_effect_frag },
    { (const char *)&glbk__glsl_prog_ism_extent_frag },
    { (const char *)&glbk__glsl_prog_ism_fill_comp },
    { (const char *)&glbk__glsl_prog_ism_gone_frag },
    { (const char *)&glbk__glsl_prog_ism_holes_frag },
    { (const char *)&glbk__glsl_prog_ism_near_frag },
    { (const char *)&glbk__glsl_prog_ism_near_sort_frag },
    { (const char *)&glbk__glsl_prog_ism_near_sort_vert },
    { (const char *)&glbk__glsl_prog_ism_near_table_frag },
    { (const char *)&glbk__glsl_prog_ism_pairs_frag },
    { (const char *)&glbk__glsl_prog_ism_points_frag },
    { (const char *)&glbk__glsl_prog_ism_pull_frag },
    { (const char *)&glbk__glsl_prog_ism_push_frag },
    { (const char *)&glbk__glsl_prog_ism_receivers_frag },
    { (const char *)&glbk__glsl_prog_ism_resolve_frag },
    { (const char *)&glbk__glsl_prog_ism_run_frag },
    { (const char *)&glbk__glsl_prog_ism_scan_frag },
    { (const char *)&glbk__glsl_prog_ism_seen_frag },
    { (const char *)&glbk__glsl_prog_ism_shade_comp },
    { (const char *)&glbk__glsl_prog_ism_shade_frag },
    { (const char *)&glbk__glsl_prog_ism_shares_frag },
    { (const char *)&glbk__glsl_prog_ism_sights_frag },
    { (const char *)&glbk__glsl_prog_ism_sizes_frag },
    { (const char *)&glbk__glsl_prog_ism_splat_comp },
    { (const char *)&glbk__glsl_prog_ism_splat_frag },
    { (const char *)&glbk__glsl_prog_ism_splat_vert },
    { (const char *)&glbk__glsl_prog_ism_weigh_frag },
    { (const char *)&glbk__glsl_prog_ism_windows_frag }
};


/* ==== src/gl_ism/part.h ==== */

/* ---- ism: this header's GLSL, textures and blocks, by which programs find them ---- */

GLBK__PART_CODE(ism, ISM)

/* ==== src/gl_ism/arguments.h ==== */

/* ---- ism: arguments: checked as ism.h checks them, with its defaults ---- */

typedef struct glbk__ism_range { double low, high; } glbk__ism_range;     /* of the values of a field but 0 */

/* Logs the first field that is out of its range. fields: of each its name and its range in words, each ended
   by 0; an empty string follows the last. (Pointers to them would take more bytes than the strings.) */
static glbk_result glbk__ism_in_range(const glbk_context *ctx, const char *function, const char *fields,
                                      const glbk__ism_range *r, const double *values)
{
    for (; *fields; r++, values++) {
        const char *wanted = fields + strlen(fields) + 1;
        if (!(*values >= r->low && *values <= r->high) && !(*values >= 0 && *values <= 0))
            return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, fields, *values, wanted);
        fields = wanted + strlen(wanted) + 1;
    }
    return GLBK_OK;
}

/* Returns whether x is a power of two, or 0. */
static int glbk__ism_power_of_two(uint32_t x) { return (x & (x - 1)) == 0; }

/* Checks the fields that count here as ism_create does. */
static glbk_result glbk__ism_check_desc(const glbk_context *ctx, const char *function, const ism_desc *d)
{
    static const char fields[] =
        "desc.vpl_count\0" "0 or 1..16384\0"
        "desc.surfel_count\0" "0 or 8..65536\0"
        "desc.tile_side\0" "0 or a power of two, 8..256\0"
        "desc.projection\0" "a value of ism_projection\0"
        "desc.lazy_frames\0" "0 or 1..64\0"
        "desc.splat_scale\0" "0..16\0"
        "desc.near_point_count\0" "64 at most\0";
    static const glbk__ism_range ranges[] = {
        { 1, 16384 }, { 8, 65536 }, { 8, 256 }, { 0, ISM_PROJECTION_COUNT - 1 }, { 1, 64 }, { 0, 16 },
        { -2147483648.0, 64 }
    };
    const uint32_t side = d->tile_side ? d->tile_side : 64;
    double values[7];
    glbk_result result;
    if (!glbk__ism_power_of_two(d->tile_side))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.tile_side", d->tile_side,
                                  "0 or a power of two, 8..256");
    values[0] = d->vpl_count;
    values[1] = d->surfel_count;
    values[2] = d->tile_side;
    values[3] = (double)d->projection;
    values[4] = d->lazy_frames;
    values[5] = (double)d->splat_scale;
    values[6] = d->near_point_count;
    result = glbk__ism_in_range(ctx, function, fields, ranges, values);
    if (result != GLBK_OK || d->window_rim <= 0) return result;
    if (d->window_rim >= 2 && (uint32_t)d->window_rim <= side / 2) return GLBK_OK;
    return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "desc.window_rim", d->window_rim,
                              "negative, 0 or 2..tile_side / 2");
}

/* Puts defaults in place of zeros, and zeros in place of negative numbers that say none, and takes the system
   away. */
static void glbk__ism_resolve(ism_desc *d)
{
    memset(&d->system, 0, sizeof d->system);
    if (!d->vpl_count) d->vpl_count = 1024;
    if (!d->surfel_count) d->surfel_count = 8192;
    if (!d->tile_side) d->tile_side = 64;
    if (d->projection == ISM_PROJECTION_DEFAULT) d->projection = ISM_PROJECTION_COSINE;
    if (!d->lazy_frames) d->lazy_frames = 8;
    if (!d->near_point_count) d->near_point_count = 16;
    if (d->near_point_count < 0) d->near_point_count = 0;
    if (!d->window_rim) d->window_rim = d->tile_side < 16 ? 2 : (int32_t)(d->tile_side / 8);
    if (d->window_rim < 0) d->window_rim = 0;
    if (!(d->splat_scale > 0)) d->splat_scale = 0.8f;
}

/* Checks a shading as ism_shade does, and writes the shading with its defaults. */
static glbk_result glbk__ism_check_shading(const glbk_context *ctx, const char *function,
                                           const ism_shading *shading, ism_shading *out)
{
    static const char fields[] =
        "shading.near_mode\0" "a value of ism_near\0"
        "shading.bias\0" "below 1\0"
        "shading.clamp\0" "0 or above 0\0";
    static const glbk__ism_range ranges[] = {
        { 0, ISM_NEAR_COUNT - 1 }, { -3.5e38, 0.99999999 }, { 0, 3e38 }
    };
    double values[3];
    glbk_result result;
    memset(out, 0, sizeof *out);
    if (shading) *out = *shading;
    if (out->interleave > 8 || !glbk__ism_power_of_two(out->interleave))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, "shading.interleave", out->interleave,
                                  "0, 1, 2, 4 or 8");
    values[0] = (double)out->near_mode;
    values[1] = (double)out->bias;
    values[2] = (double)out->clamp;
    result = glbk__ism_in_range(ctx, function, fields, ranges, values);
    if (result != GLBK_OK) return result;
    if (out->visible_fn || out->near_visible_fn)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function,
                            out->visible_fn ? "shading.visible_fn" : "shading.near_visible_fn",
                            "is not NULL: on GL it is GLSL, glbk_ism_renderer_see");
    if (!out->interleave) out->interleave = 1;
    if (out->near_mode == ISM_NEAR_DEFAULT) out->near_mode = ISM_NEAR_GATHER;
    if (!(out->clamp > 0)) out->clamp = 1.0f;
    if (!(out->bias > 0)) out->bias = out->bias < 0 ? 0.0f : 0.02f;
    return GLBK_OK;
}

/* Checks that there is a context, and that maps were created. */
static glbk_result glbk__ism_check_maps(const glbk_context *ctx, const char *function, const glbk_ism_maps *m)
{
    if (ctx && m && m->vpls.name) return GLBK_OK;
    return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "maps", m ? "were not created" : "is NULL");
}

/* Checks that there is a context, and that a renderer was created. */
static glbk_result glbk__ism_check_renderer(const glbk_context *ctx, const char *function,
                                            const glbk_ism_renderer *r)
{
    if (ctx && r && r->view.name) return GLBK_OK;
    return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "renderer", r ? "was not created" : "is NULL");
}

/* Checks that a renderer and a G-buffer were created, for pictures of one size. */
static glbk_result glbk__ism_check_gbuffer(const glbk_context *ctx, const char *function,
                                           const glbk_ism_renderer *r, const glbk_gbuffer *g)
{
    const glbk_result result = glbk__ism_check_renderer(ctx, function, r);
    if (result != GLBK_OK) return result;
    if (!g || !g->colors.name)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "gbuffer", g ? "was not created" : "is NULL");
    if (g->width != r->width)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "gbuffer->width", g->width,
                                  "that of the renderer");
    if (g->height == r->height) return GLBK_OK;
    return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "gbuffer->height", g->height,
                              "that of the renderer");
}

/* ---- lists ---- */

/* An element of a list that a call was given. */
typedef struct glbk__ism_element {
    const glbk_context *ctx;
    const char *function;           /* the call */
    const char *list;               /* the parameter */
    size_t      index;
} glbk__ism_element;

/* Ranges of numbers, and then the vectors that must be 0.97..1.03 long. */
enum { GLBK__ISM_FINITE, GLBK__ISM_FLUX, GLBK__ISM_EXPONENT, GLBK__ISM_LENGTH, GLBK__ISM_UNIT };

/* A field of an element: its first byte there, how many floats it has, and what they must be. */
typedef struct glbk__ism_field {
    char          name[11];
    unsigned char at, count, kind;
} glbk__ism_field;

/* Logs of a field (".position") "FUNCTION: LIST[INDEX]FIELD is VALUE; it must be WANTED". component: which
   number of the field is wrong, or GLBK__NO_INDEX if the field is no vector. */
static glbk_result glbk__ism_refuse_field(const glbk__ism_element *e, const char *field, size_t component,
                                          const char *of_field, double value, const char *wanted)
{
    char member[GLBK__ELEMENT_ROOM];
    glbk__name_element(member, field, component, of_field);
    return glbk__refuse_element_value(e->ctx, GLBK_ERR_INPUT, e->function, e->list, e->index, member, value,
                                      wanted);
}

/* Returns whether a float is finite. */
static int glbk__ism_finite(float x) { return x * 0 >= 0 && x * 0 <= 0; }

/* Checks a field of an element. */
static glbk_result glbk__ism_check_field(const glbk__ism_element *e, const glbk__ism_field *f,
                                         const void *element)
{
    static const struct { float low, high; char wanted[24]; } ranges[] = {
        { -3.402823466e38f, 3.402823466e38f, "finite" }, { 0, 1e30f, "0..1e30" }, { 0, 1e5f, "0..1e5" },
        { 0, 3e38f, "finite and not negative" }
    };
    float v[3] = { 0, 0, 0 }, length2;
    size_t k;
    memcpy(v, (const char *)element + f->at, 4 * (size_t)f->count);
    length2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    if (f->kind == GLBK__ISM_UNIT)
        return glbk_ism__is_unit2(length2)
                   ? GLBK_OK
                   : glbk__ism_refuse_field(e, f->name, GLBK__NO_INDEX, "'s length", (double)sqrtf(length2),
                                            "1 (0.97..1.03)");
    for (k = 0; k < f->count; k++)
        if (!(v[k] >= ranges[f->kind].low && v[k] <= ranges[f->kind].high))
            return glbk__ism_refuse_field(e, f->name, f->count > 1 ? k : GLBK__NO_INDEX, "", (double)v[k],
                                          ranges[f->kind].wanted);
    return GLBK_OK;
}

/* Checks fields, the last of which has no floats. */
static glbk_result glbk__ism_check_fields(const glbk__ism_element *e, const glbk__ism_field *f,
                                          const void *element)
{
    glbk_result result = GLBK_OK;
    for (; f->count && result == GLBK_OK; f++) result = glbk__ism_check_field(e, f, element);
    return result;
}

/* Returns whether a window leaves something of each side of the tile. */
static int glbk__ism_window(uint32_t window)
{
    return window < 1u << 24 && (window & 63) + (window >> 12 & 63) <= 63 &&
           (window >> 6 & 63) + (window >> 18 & 63) <= 63;
}

/* Checks element i of a list of VPLs as ism_set_vpls does, and the fields that ism.h computes itself. */
static glbk_result glbk__ism_check_vpl(const glbk_context *ctx, const ism_vpl *v, size_t i)
{
    const glbk__ism_element e = { ctx, "glbk_ism_vpls_upload", "vpls", i };
    static const glbk__ism_field fields[] = {
        { ".position", offsetof(ism_vpl, position), 3, GLBK__ISM_FINITE },
        { ".flux", offsetof(ism_vpl, flux), 3, GLBK__ISM_FLUX },
        { ".normal", offsetof(ism_vpl, normal), 3, GLBK__ISM_UNIT },
        { ".axis", offsetof(ism_vpl, axis), 3, GLBK__ISM_UNIT },
        { ".exponent", offsetof(ism_vpl, exponent), 1, GLBK__ISM_EXPONENT },
        { ".edge", offsetof(ism_vpl, edge), 1, GLBK__ISM_LENGTH },
        { ".reach", offsetof(ism_vpl, reach), 1, GLBK__ISM_LENGTH },
        { "", 0, 0, 0 }
    };
    const glbk_result result = glbk__ism_check_fields(&e, fields, v);
    if (result != GLBK_OK || glbk__ism_window(v->window)) return result;
    return glbk__ism_refuse_field(&e, ".window", GLBK__NO_INDEX, "", (double)v->window,
                                  "cuts that leave something of each side");
}

/* Checks element i of a list of near points. */
static glbk_result glbk__ism_check_near_point(const glbk_context *ctx, const ism_near_point *p, size_t i,
                                              uint32_t vpl_count)
{
    const glbk__ism_element e = { ctx, "glbk_ism_near_points_upload", "points", i };
    static const glbk__ism_field fields[] = {
        { ".position", offsetof(ism_near_point, position), 3, GLBK__ISM_FINITE },
        { ".normal", offsetof(ism_near_point, normal), 3, GLBK__ISM_FINITE },
        { ".flux", offsetof(ism_near_point, flux), 3, GLBK__ISM_FLUX },
        { ".edge", offsetof(ism_near_point, edge), 1, GLBK__ISM_LENGTH },
        { ".reach", offsetof(ism_near_point, reach), 1, GLBK__ISM_LENGTH },
        { "", 0, 0, 0 }
    };
    const glbk_result result = glbk__ism_check_fields(&e, fields, p);
    if (result != GLBK_OK || (p->vpl >= 0 && p->vpl < (float)vpl_count)) return result;
    return glbk__ism_refuse_field(&e, ".vpl", GLBK__NO_INDEX, "", (double)p->vpl,
                                  "the number of an uploaded VPL");
}

/* Logs that a size of lists is another than that of the maps, for which they were made. */
static glbk_result glbk__ism_refuse_size(const glbk_context *ctx, const char *function, const char *field,
                                         size_t value, size_t wanted)
{
    char line[GLBK__LINE_ROOM];
    glbk__sink sink;
    glbk__begin_line(&sink, line);
    glbk__append_number(&sink, wanted);
    glbk__append_text(&sink, ", as glbk_ism_maps_create was told: give ism_create the same desc");
    return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, field, (double)value, line);
}

/* Checks that lists come from an ism_create with the desc of the maps, and that their sphere can be used. */
static glbk_result glbk__ism_check_info(const glbk_context *ctx, const char *function, const ism_desc *d,
                                        const ism_info *info)
{
    int k;
    if (info->surfel_count && info->surfel_count != d->surfel_count)
        return glbk__ism_refuse_size(ctx, function, "info.surfel_count", info->surfel_count, d->surfel_count);
    if (info->tile_side && info->tile_side != d->tile_side)
        return glbk__ism_refuse_size(ctx, function, "info.tile_side", info->tile_side, d->tile_side);
    if (info->lazy_frames && info->lazy_frames != d->lazy_frames)
        return glbk__ism_refuse_size(ctx, function, "info.lazy_frames", info->lazy_frames, d->lazy_frames);
    if (!(info->radius >= 0 && info->radius < 3e38f))
        return glbk__refuse_value(ctx, GLBK_ERR_INPUT, function, "info.radius", (double)info->radius,
                                  "finite and not negative");
    for (k = 0; k < 3; k++)
        if (!glbk__ism_finite(info->center[k]))
            return glbk__refuse_value(ctx, GLBK_ERR_INPUT, function, "info.center", (double)info->center[k],
                                      "finite");
    return GLBK_OK;
}

/* Checks a mesh but for the values of its indices, which are checked while they are read. */
static glbk_result glbk__ism_check_mesh(const glbk_context *ctx, const char *function, const ism_mesh *mesh)
{
    const int indexed = mesh->indices || mesh->indices16;
    const size_t corners = indexed ? mesh->index_count : mesh->vertex_count;
    const char *count = indexed ? "mesh.index_count" : "mesh.vertex_count";
    const glbk_result bad = GLBK_ERR_ARGUMENT;
    if (mesh->indices && mesh->indices16)
        return glbk__refuse(ctx, bad, function, "mesh.indices", "and mesh.indices16 are both given");
    if (corners % 3)
        return glbk__refuse_value(ctx, bad, function, count, (double)corners, "a multiple of 3");
    if (corners && !mesh->positions) return glbk__refuse(ctx, bad, function, "mesh.positions", "is NULL");
    if (!glbk_ism__stride_valid(mesh->vertex_stride, 12))
        return glbk__refuse_value(ctx, bad, function, "mesh.vertex_stride", (double)mesh->vertex_stride,
                                  "0 or a multiple of 4, at least 12");
    if (corners > 0x7fffffff)
        return glbk__refuse_value(ctx, GLBK_ERR_LIMIT, function, count, (double)corners,
                                  "2147483647 at most");
    if (mesh->vertex_count <= 0x7fffffff) return GLBK_OK;
    return glbk__refuse_value(ctx, GLBK_ERR_LIMIT, function, "mesh.vertex_count", (double)mesh->vertex_count,
                              "2147483647 at most");
}

/* ==== src/gl_ism/maps.h ==== */

/* ---- ism: maps: their tables, pictures and programs ---- */

/* Makes objects one after the other. After the first error no more are made. */
typedef struct glbk__ism_making {
    glbk_context *ctx;
    glbk_result   result;           /* of all that were made so far */
    const char   *defines;          /* of programs; NULL = none */
} glbk__ism_making;

static glbk__ism_making glbk__ism_begin_making(glbk_context *ctx)
{
    glbk__ism_making k;
    k.ctx = ctx;
    k.result = GLBK_OK;
    k.defines = NULL;
    return k;
}

/* Makes a program, which may read a G-buffer. */
static void glbk__ism_make_program(glbk__ism_making *k, const char *name, glbk_program *out)
{
    if (k->result == GLBK_OK)
        k->result = glbk__gbuffer_program(k->ctx, glbk_ism_part(), name, k->defines, out);
}

/* Makes a picture of a format and its target. */
static void glbk__ism_make_canvas(glbk__ism_making *k, glbk_format format, uint32_t width, uint32_t height,
                                  const glbk_texture *depth, glbk_texture *texture, glbk_target *target)
{
    if (k->result == GLBK_OK)
        k->result = glbk__canvas(k->ctx, format, width, height, depth, texture, target);
}

static void glbk__ism_make_table(glbk__ism_making *k, glbk_format format, const void *texels, size_t count,
                                 glbk_texture *out)
{
    if (k->result == GLBK_OK) k->result = glbk__table_create(k->ctx, format, texels, count, out);
}

static void glbk__ism_make_block(glbk__ism_making *k, size_t bytes, glbk_buffer *out)
{
    if (k->result == GLBK_OK) k->result = glbk_buffer_create(k->ctx, bytes, NULL, out);
}

/* Makes the picture of the triangles that surfels lie on, and draws it together with the planes. */
static void glbk__ism_make_hits(glbk__ism_making *k, glbk_ism_maps *m)
{
    glbk_texture_desc d;
    glbk_target_desc t;
    memset(&d, 0, sizeof d);
    memset(&t, 0, sizeof t);
    d.format = GLBK_FORMAT_R32UI;
    d.width = d.height = m->side;
    t.color[0] = &m->planes;
    t.color[1] = &m->hits;
    t.depth = &m->depth;
    if (k->result != GLBK_OK) return;
    glbk_target_free(k->ctx, &m->plane_target);
    k->result = glbk_texture_create(k->ctx, &d, &m->hits);
    if (k->result == GLBK_OK) k->result = glbk__target_create(k->ctx, &t, &m->plane_target);
}

/* Makes the pictures that both paths draw to: the planes of surfels, and the atlas. */
static void glbk__ism_make_canvases(glbk__ism_making *k, glbk_ism_maps *m)
{
    glbk_texture_desc d;
    memset(&d, 0, sizeof d);
    d.format = GLBK_FORMAT_DEPTH32F;
    d.width = d.height = m->side;
    if (!m->compute && k->result == GLBK_OK) k->result = glbk_texture_create(k->ctx, &d, &m->depth);
    glbk__ism_make_canvas(k, GLBK_FORMAT_COLOR, m->side, m->side, m->compute ? NULL : &m->depth, &m->planes,
                          &m->plane_target);
    if (m->desc.keep_hits) glbk__ism_make_hits(k, m);
    glbk__ism_make_canvas(k, GLBK_FORMAT_R32UI, m->side, m->side, NULL, &m->atlas, &m->atlas_target);
}

/* Makes pictures and programs that take the core path from surfels to the atlas: kept texels, levels of pull,
   push. */
static void glbk__ism_make_fill(glbk__ism_making *k, glbk_ism_maps *m)
{
    const char *projection = k->defines;
    char defines[] = "ISM_LEVEL=1";
    const uint32_t side = m->side;
    uint32_t i;
    glbk__ism_make_canvas(k, GLBK_FORMAT_R8UI, side, side, NULL, &m->kept, &m->kept_target);
    glbk__ism_make_program(k, "ism_holes.frag", &m->holes);
    glbk__ism_make_program(k, "ism_push.frag", &m->push);
    k->defines = defines;
    for (i = 0; i < GLBK_ISM_LEVELS; i++) {
        const uint32_t coarse = side >> (i + 1);
        glbk__ism_make_canvas(k, GLBK_FORMAT_R32UI, coarse, coarse, NULL, &m->pull[i], &m->pull_target[i]);
        defines[10] = (char)('1' + (int)i);
        glbk__ism_make_program(k, "ism_pull.frag", &m->pull_program[i]);
    }
    k->defines = projection;
}

/* Compiles all programs that maps need. */
static void glbk__ism_make_programs(glbk__ism_making *k, glbk_ism_maps *m)
{
    char defines[] = "ISM_PROJECTION=1 ISM_QUADS=0 ISM_HITS=0";
    m->quads = !m->compute && k->ctx->max_point_side < (float)m->desc.tile_side;
    defines[15] = (char)('0' + (int)m->desc.projection);
    defines[27] = m->quads ? '1' : '0';
    defines[38] = m->desc.keep_hits ? '1' : '0';
    k->defines = defines;
    glbk__ism_make_program(k, m->compute ? "ism_splat.comp" : "ism_splat.frag", &m->splat);
    if (m->compute) glbk__ism_make_program(k, "ism_fill.comp", &m->fill);
    else glbk__ism_make_fill(k, m);
    k->defines = NULL;
}

/* Returns how many levels pull and push have. The coarsest has at least two cells a side of a tile. */
static uint32_t glbk__ism_levels(const glbk_ism_maps *m)
{
    uint32_t levels = m->desc.no_fill ? 0 : GLBK_ISM_LEVELS;
    while (levels && m->desc.tile_side >> levels < 2) levels--;
    return levels;
}

/* Returns how many texels of the table of VPLs lie before the spheres of the near points. */
static uint32_t glbk__ism_vpl_texels(const glbk_ism_maps *m) { return 4 * m->desc.vpl_count; }

/* Returns how many texels the spheres of the near points have. */
static uint32_t glbk__ism_spheres(const glbk_ism_maps *m)
{
    return (m->desc.vpl_count * (uint32_t)m->desc.near_point_count + 63) / 64;
}

/* Returns the values of the maps' uniform block. */
static glbk_ism_frame glbk__ism_frame_of(const glbk_ism_maps *m)
{
    glbk_ism_frame f;
    memset(&f, 0, sizeof f);
    f.vpl_count = m->vpl_count;
    f.tile_side = m->desc.tile_side;
    f.tiles_across = m->tiles_across;
    f.surfel_count = m->phase_surfel_count * m->desc.lazy_frames;
    f.vpl_capacity = m->desc.vpl_count;
    f.phase_surfel_count = m->phase_surfel_count;
    f.fill_levels = glbk__ism_levels(m);
    f.triangle_count = m->triangle_count;
    memcpy(f.sphere, m->sphere, sizeof f.sphere);
    f.splat_scale = m->desc.splat_scale;
    f.window_rim = (uint32_t)m->desc.window_rim;
    f.near_point_count = m->near_point_count;
    f.first_sphere = glbk__ism_vpl_texels(m);
    f.first_near_point = f.first_sphere + glbk__ism_spheres(m);
    return f;
}

/* Uploads the maps' uniform block. */
static glbk_result glbk__ism_write_frame(glbk_context *ctx, const glbk_ism_maps *m)
{
    const glbk_ism_frame f = glbk__ism_frame_of(m);
    return glbk_buffer_update(ctx, &m->frame, 0, sizeof f, &f);
}

/* Makes the tables of surfels. By compute there is one, since a dispatch reads all phases. On the core path
   each phase has its own: a phase is written while the frame before may still be drawn, and drivers then copy
   the whole texture. */
static void glbk__ism_make_surfels(glbk__ism_making *k, glbk_ism_maps *m)
{
    const size_t count = (size_t)m->desc.vpl_count * m->phase_surfel_count;
    const uint32_t phases = m->desc.lazy_frames;
    uint32_t i;
    if (m->compute) glbk__ism_make_table(k, GLBK_FORMAT_RGBA32UI, NULL, count * phases, &m->surfels);
    for (i = 0; i < phases && !m->compute; i++)
        glbk__ism_make_table(k, GLBK_FORMAT_RGBA32UI, NULL, count, &m->phase_surfels[i]);
}

/* Decides how large the atlas is and how many surfels a phase has. Returns GLBK_ERR_LIMIT if the atlas is too
   large. 16384 VPLs with 65536 surfels each are below 2^31, rounded up to phases too. */
static glbk_result glbk__ism_lay_out(const glbk_context *ctx, const char *function, glbk_ism_maps *m)
{
    const ism_desc *d = &m->desc;
    for (m->tiles_across = 1; m->tiles_across * m->tiles_across < d->vpl_count; m->tiles_across++) {}
    m->side = m->tiles_across * d->tile_side;
    m->phase_surfel_count = (d->surfel_count + d->lazy_frames - 1) / d->lazy_frames;
    /* ism_splat.comp counts the surfels of a VPL in 16 bits, and keeps no hits. */
    m->compute = ctx->compute && !d->keep_hits && m->phase_surfel_count * d->lazy_frames <= 65536;
    if (m->side <= ctx->max_side) return GLBK_OK;
    return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "the atlas's side, of all VPLs' tiles,",
                              m->side, 8, ctx->max_side);
}

/* Makes all tables, pictures, blocks and programs of maps that are laid out. */
static glbk_result glbk__ism_create_all(glbk_context *ctx, glbk_ism_maps *m)
{
    static const uint32_t nothing[4] = { 0, 0, 0, 0 };
    const size_t vpls = m->desc.vpl_count, near_points = 3 * vpls * (size_t)m->desc.near_point_count;
    const size_t texels = glbk__ism_vpl_texels(m) + glbk__ism_spheres(m) + near_points;
    glbk__ism_making k = glbk__ism_begin_making(ctx);
    glbk__ism_make_surfels(&k, m);
    glbk__ism_make_table(&k, GLBK_FORMAT_RGBA32UI, NULL, texels, &m->vpls);
    glbk__ism_make_table(&k, GLBK_FORMAT_RGBA32UI, nothing, 1, &m->triangle_table);
    glbk__ism_make_table(&k, GLBK_FORMAT_RGBA32F, nothing, 1, &m->positions);
    glbk__ism_make_table(&k, GLBK_FORMAT_RGBA32F, nothing, 1, &m->albedos);
    glbk__ism_make_block(&k, sizeof(glbk_ism_frame), &m->frame);
    glbk__ism_make_block(&k, sizeof(glbk_ism_view), &m->view);
    glbk__ism_make_canvases(&k, m);
    glbk__ism_make_programs(&k, m);
    return k.result == GLBK_OK ? glbk__leave_created(ctx, glbk__ism_write_frame(ctx, m)) : k.result;
}

GLBK_DEF glbk_result glbk_ism_maps_create(glbk_context *ctx, const ism_desc *desc, glbk_ism_maps *out)
{
    glbk_result result = glbk__enter_create(ctx, __func__, out, sizeof *out);
    if (result != GLBK_OK) return result;
    if (desc) out->desc = *desc;
    result = glbk__ism_check_desc(ctx, __func__, &out->desc);
    glbk__ism_resolve(&out->desc);
    if (result == GLBK_OK) result = glbk__ism_lay_out(ctx, __func__, out);
    if (result == GLBK_OK) result = glbk__ism_create_all(ctx, out);
    if (result != GLBK_OK) glbk_ism_maps_free(ctx, out);
    return result;
}

GLBK_DEF void glbk_ism_maps_free(glbk_context *ctx, glbk_ism_maps *m)
{
    uint32_t i;
    if (!m) return;
    for (i = 0; i < GLBK_ISM_LEVELS; i++) {
        glbk_program_free(ctx, &m->pull_program[i]);
        glbk_target_free(ctx, &m->pull_target[i]);
        glbk_texture_free(ctx, &m->pull[i]);
    }
    glbk_program_free(ctx, &m->splat);
    glbk_program_free(ctx, &m->holes);
    glbk_program_free(ctx, &m->push);
    glbk_program_free(ctx, &m->fill);
    glbk_target_free(ctx, &m->plane_target);
    glbk_target_free(ctx, &m->kept_target);
    glbk_target_free(ctx, &m->atlas_target);
    glbk_texture_free(ctx, &m->vpls);
    glbk_texture_free(ctx, &m->surfels);
    for (i = 0; i < 64; i++) glbk_texture_free(ctx, &m->phase_surfels[i]);
    glbk_texture_free(ctx, &m->triangle_table);
    glbk_texture_free(ctx, &m->positions);
    glbk_texture_free(ctx, &m->albedos);
    glbk_texture_free(ctx, &m->planes);
    glbk_texture_free(ctx, &m->hits);
    glbk_texture_free(ctx, &m->depth);
    glbk_texture_free(ctx, &m->kept);
    glbk_texture_free(ctx, &m->atlas);
    glbk_buffer_free(ctx, &m->frame);
    glbk_buffer_free(ctx, &m->view);
    memset(m, 0, sizeof *m);
}

/* ==== src/gl_ism/uploads.h ==== */

/* ---- ism: meshes, surfels, VPLs and near points from the CPU ---- */

/* Writes count strided triples into a table of four floats each, which is made if there is none yet, or has
   as many; from NULL: 0.5 everywhere. */
static glbk_result glbk__ism_upload(glbk_context *ctx, glbk_texture *table, const float *from, size_t count,
                                   size_t stride)
{
    glbk_ism__allocator memory = glbk_ism__memory(ctx);
    float *texels = (float *)glbk_ism__alloc_array(&memory, count, 16);
    glbk_result result;
    size_t i;
    if (!texels) return GLBK_ERR_ALLOC;
    for (i = 0; i < 4 * count; i++) texels[i] = 0.5f;
    for (i = 0; i < count && from; i++)
        memcpy(texels + 4 * i, (const char *)from + (stride ? stride : 12) * i, 12);
    result = table->name ? glbk__table_update(ctx, table, 0, count, texels)
                         : glbk__table_create(ctx, GLBK_FORMAT_RGBA32F, texels, count, table);
    glbk_ism__free(&memory, texels);
    return result;
}

/* Returns three indices and the bits of the opacity of each triangle, in memory that the caller frees.
   Returns NULL if there is no memory or an index reaches beyond the vertices; *result says which. */
static uint32_t *glbk__ism_triangles(const glbk_context *ctx, const glbk_ism__allocator *memory,
                                     const ism_mesh *mesh, size_t count, glbk_result *result)
{
    uint32_t *words = (uint32_t *)glbk_ism__alloc_array(memory, count, 16);
    float opacity = 1;
    size_t i, corner;
    *result = words ? GLBK_OK : GLBK_ERR_ALLOC;
    for (corner = 0; corner < 3 * count && *result == GLBK_OK; corner++) {
        const uint32_t index = mesh->indices     ? mesh->indices[corner]
                               : mesh->indices16 ? mesh->indices16[corner]
                                                 : (uint32_t)corner;
        words[corner / 3 * 4 + corner % 3] = index;
        if (index >= mesh->vertex_count)
            *result = glbk__refuse_index(ctx, GLBK_ERR_INPUT, "glbk_ism_mesh_upload", "mesh", corner, index,
                                         mesh->vertex_count);
    }
    for (i = 0; i < count && *result == GLBK_OK; i++) {
        if (mesh->opacities) opacity = mesh->opacities[i];
        memcpy(words + 4 * i + 3, &opacity, 4);
    }
    if (words && *result != GLBK_OK) {
        glbk_ism__free(memory, words);
        words = NULL;
    }
    return words;
}

/* Replaces triangles, positions and albedos by those of a mesh that has some, or leaves all as they are. */
static glbk_result glbk__ism_replace_mesh(glbk_context *ctx, glbk_ism_maps *m, const ism_mesh *mesh,
                                          size_t count)
{
    const glbk_ism__allocator memory = glbk_ism__memory(ctx);
    glbk_texture made[3], old, *tables[3];
    glbk_result result;
    int k;
    uint32_t *words = glbk__ism_triangles(ctx, &memory, mesh, count, &result);
    if (!words) return result;
    memset(made, 0, sizeof made);
    result = glbk__table_create(ctx, GLBK_FORMAT_RGBA32UI, words, count, &made[0]);
    glbk_ism__free(&memory, words);
    if (result == GLBK_OK)
        result = glbk__ism_upload(ctx, &made[1], mesh->positions, mesh->vertex_count, mesh->vertex_stride);
    if (result == GLBK_OK && m->desc.keep_hits)
        result = glbk__ism_upload(ctx, &made[2], mesh->albedos, count, 0);
    if (result == GLBK_OK) m->vertex_count = (uint32_t)mesh->vertex_count;
    tables[0] = &m->triangle_table;
    tables[1] = &m->positions;
    tables[2] = &m->albedos;
    for (k = 0; k < 3 && made[k].name; k++) {
        old = *tables[k];
        if (result == GLBK_OK) *tables[k] = made[k];
        glbk_texture_free(ctx, result == GLBK_OK ? &old : &made[k]);
    }
    return result;
}

GLBK_DEF glbk_result glbk_ism_mesh_upload(glbk_context *ctx, glbk_ism_maps *m, const ism_mesh *mesh)
{
    size_t count = 0;
    glbk_result result = glbk__ism_check_maps(ctx, __func__, m);
    if (result == GLBK_OK && mesh) {
        result = glbk__ism_check_mesh(ctx, __func__, mesh);
        count = (mesh->indices || mesh->indices16 ? mesh->index_count : mesh->vertex_count) / 3;
    }
    if (result == GLBK_OK && count) result = glbk__ism_replace_mesh(ctx, m, mesh, count);
    if (result != GLBK_OK) return result;
    if (!count) m->phases = 0;
    m->fewer |= count < m->triangle_count;
    m->outdated |= count < m->triangle_count;
    m->triangle_count = (uint32_t)count;
    m->masked = mesh && mesh->mask_fn != NULL;
    return glbk__leave_created(ctx, glbk__ism_write_frame(ctx, m));
}

GLBK_DEF glbk_result glbk_ism_mesh_move(glbk_context *ctx, glbk_ism_maps *m, const float *positions,
                                        size_t stride)
{
    glbk_result result = glbk__ism_check_maps(ctx, __func__, m);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "positions", positions);
    if (result != GLBK_OK) return result;
    if (!glbk_ism__stride_valid(stride, 12))
        return glbk__refuse_value(ctx, GLBK_ERR_ARGUMENT, __func__, "stride", (double)stride,
                                  "0 or a multiple of 4, at least 12");
    if (!m->triangle_count)
        return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "maps", "have no mesh: glbk_ism_mesh_upload");
    return glbk__ism_upload(ctx, &m->positions, positions, m->vertex_count, stride);
}

GLBK_DEF glbk_result glbk_ism_surfels_upload(glbk_context *ctx, glbk_ism_maps *m, uint32_t phase,
                                             const ism_surfel *surfels, size_t count)
{
    size_t wanted;
    glbk_result result = glbk__ism_check_maps(ctx, __func__, m);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "surfels", surfels);
    if (result != GLBK_OK) return result;
    if (phase >= m->desc.lazy_frames)
        return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, __func__, "phase", phase, 0,
                                  m->desc.lazy_frames - 1.0);
    wanted = (size_t)m->desc.vpl_count * m->phase_surfel_count;
    if (count != wanted) return glbk__ism_refuse_size(ctx, __func__, "count", count, wanted);
    result = m->compute ? glbk__table_update(ctx, &m->surfels, count * phase, count, surfels)
                        : glbk__table_update(ctx, &m->phase_surfels[phase], 0, count, surfels);
    if (result == GLBK_OK) m->phases |= (uint64_t)1 << phase;
    return result;
}

/* Writes the four texels of a VPL, which docs/gpu-layouts.md lists. Maps without a rim have no windows. */
static void glbk__ism_pack_vpl(const glbk_ism_maps *m, const ism_vpl *v, float *to)
{
    memcpy(to, v->position, 12);
    to[3] = v->directional ? -1 : v->exponent;
    memcpy(to + 4, v->normal, 12);
    to[7] = v->edge;
    memcpy(to + 8, v->flux, 12);
    to[11] = v->reach;
    memcpy(to + 12, v->axis, 12);
    to[15] = m->desc.window_rim ? (float)v->window : 0.0f;
}

/* Checks all arguments of glbk_ism_vpls_upload. */
static glbk_result glbk__ism_check_vpls(const glbk_context *ctx, const char *function, const glbk_ism_maps *m,
                                        const ism_vpl *vpls, uint32_t count, const ism_info *info)
{
    glbk_result result = glbk__ism_check_maps(ctx, function, m);
    uint32_t i;
    if (result != GLBK_OK) return result;
    if (count && !vpls) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "vpls", "is NULL");
    if (!info) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "info", "is NULL");
    if (count > m->desc.vpl_count)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "count", count, 0, m->desc.vpl_count);
    result = glbk__ism_check_info(ctx, function, &m->desc, info);
    for (i = 0; i < count && result == GLBK_OK; i++) {
        result = glbk__ism_check_vpl(ctx, &vpls[i], i);
        if (result == GLBK_OK && vpls[i].directional && !(info->radius > 0))
            result = glbk__refuse(ctx, GLBK_ERR_INPUT, function, "info.radius",
                                  "is 0; it must be above 0, since there is a directional VPL");
    }
    return result;
}

GLBK_DEF glbk_result glbk_ism_vpls_upload(glbk_context *ctx, glbk_ism_maps *m, const ism_vpl *vpls,
                                          uint32_t count, const ism_info *info)
{
    glbk_result result = glbk__ism_check_vpls(ctx, __func__, m, vpls, count, info);
    if (result == GLBK_OK && count) {
        const glbk_ism__allocator memory = glbk_ism__memory(ctx);
        float *texels = (float *)glbk_ism__alloc_array(&memory, count, 64);
        uint32_t i;
        if (!texels) return GLBK_ERR_ALLOC;
        for (i = 0; i < count; i++) glbk__ism_pack_vpl(m, &vpls[i], texels + 16 * (size_t)i);
        result = glbk__table_update(ctx, &m->vpls, 0, 4 * (size_t)count, texels);
        glbk_ism__free(&memory, texels);
    }
    if (result != GLBK_OK) return result;
    m->vpl_count = count;
    m->near_point_count = 0;
    memcpy(m->sphere, info->center, sizeof info->center);
    m->sphere[3] = info->radius > 0 ? info->radius : 1;
    return glbk__ism_write_frame(ctx, m);
}

/* Computes centre and radius of the sphere beyond which none of the near points reaches, as ism.h does. */
static void glbk__ism_near_sphere(const ism_near_point *points, uint32_t count, float sphere[4])
{
    float low[3], high[3], d2, reach;
    uint32_t i, k;
    memcpy(low, points[0].position, sizeof low);
    memcpy(high, points[0].position, sizeof high);
    for (i = 1; i < count; i++)
        for (k = 0; k < 3; k++) {
            const float x = points[i].position[k];
            low[k] = x < low[k] ? x : low[k];
            high[k] = x > high[k] ? x : high[k];
        }
    for (k = 0; k < 3; k++) sphere[k] = 0.5f * (low[k] + high[k]);
    sphere[3] = 0;
    for (i = 0; i < count; i++) {
        const float *p = points[i].position;
        for (k = 0, d2 = 0; k < 3; k++) d2 += (p[k] - sphere[k]) * (p[k] - sphere[k]);
        reach = sqrtf(d2) + points[i].reach;
        if (reach > sphere[3]) sphere[3] = reach;
    }
}

/* Sends near points as they are, and a sphere about each 64 of them. */
static glbk_result glbk__ism_send_near_points(glbk_context *ctx, glbk_ism_maps *m,
                                              const ism_near_point *points, uint32_t count)
{
    const glbk_ism__allocator memory = glbk_ism__memory(ctx);
    const size_t behind = (size_t)glbk__ism_vpl_texels(m) + glbk__ism_spheres(m);
    const uint32_t blocks = (count + 63) / 64;
    float *spheres = (float *)glbk_ism__alloc_array(&memory, blocks, 16);
    glbk_result result;
    uint32_t i;
    if (!spheres) return GLBK_ERR_ALLOC;
    for (i = 0; i < count; i += 64)
        glbk__ism_near_sphere(points + i, count - i < 64 ? count - i : 64, spheres + i / 16);
    result = glbk__table_update(ctx, &m->vpls, glbk__ism_vpl_texels(m), blocks, spheres);
    glbk_ism__free(&memory, spheres);
    if (result != GLBK_OK) return result;
    return glbk__table_update(ctx, &m->vpls, behind, 3 * (size_t)count, points);
}

GLBK_DEF glbk_result glbk_ism_near_points_upload(glbk_context *ctx, glbk_ism_maps *m,
                                                 const ism_near_point *points, uint32_t count)
{
    glbk_result result;
    uint32_t i;
    result = glbk__ism_check_maps(ctx, __func__, m);
    if (result != GLBK_OK) return result;
    if (count && !points) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "points", "is NULL");
    if (count > m->desc.vpl_count * (uint32_t)m->desc.near_point_count)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, __func__, "count", count, 0,
                                  (double)m->desc.vpl_count * (double)m->desc.near_point_count);
    for (i = 0; i < count && result == GLBK_OK; i++)
        result = glbk__ism_check_near_point(ctx, &points[i], i, m->vpl_count);
    if (result != GLBK_OK) return result;
    if (count) result = glbk__ism_send_near_points(ctx, m, points, count);
    m->near_point_count = result == GLBK_OK ? count : 0;
    return result == GLBK_OK ? glbk__ism_write_frame(ctx, m) : result;
}

/* ==== src/gl_ism/drawing.h ==== */

/* ---- ism: drawing the maps ---- */

/* Binds the textures and the block that surfels are drawn from. */
static void glbk__ism_bind_surfels(glbk_context *ctx, const glbk_ism_maps *m)
{
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_vpls, &m->vpls);
    if (m->compute) glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_surfels, &m->surfels);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_triangles, &m->triangle_table);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_positions, &m->positions);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame);
}

/* Runs ism_splat.comp or ism_fill.comp, with a group for each tile, or for each of the squares of that many
   texels a side that a large tile is cut into. */
static glbk_result glbk__ism_dispatch(glbk_context *ctx, const glbk_ism_maps *m, glbk_program *program,
                                      uint32_t square)
{
    uint32_t groups = m->side / (m->desc.tile_side <= 64 ? m->desc.tile_side : square);
    return glbk_dispatch(ctx, program, groups, groups, 1);
}

/* Draws the surfels of a phase, at most `most` of them in a draw. */
static glbk_result glbk__ism_draw_phase(glbk_context *ctx, glbk_ism_maps *m, uint32_t phase, uint32_t most)
{
    const uint32_t all = m->phase_surfel_count * m->desc.vpl_count;
    glbk_ism_frame f = glbk__ism_frame_of(m);
    glbk_result result = GLBK_OK;
    uint32_t first, count;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_surfels, &m->phase_surfels[phase]);
    for (first = 0; first < all && result == GLBK_OK; first += count) {
        count = all - first < most ? all - first : most;
        if (!m->quads) {
            ctx->gl.DrawArrays(GLBK_GL_POINTS, (int32_t)first, (int32_t)count);
            continue;
        }
        f.first_surfel = first;               /* since instances begin at 0 everywhere */
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame, &f);
        if (result == GLBK_OK) ctx->gl.DrawArraysInstanced(GLBK_GL_TRIANGLE_STRIP, 0, 4, (int32_t)count);
    }
    return result;
}

/* Clears the planes and draws the surfels of all phases. */
static glbk_result glbk__ism_splat(glbk_context *ctx, glbk_ism_maps *m, uint32_t surfels_per_pass)
{
    static const float empty[4] = { 0, 0, 0, 1e30f };
    glbk_pass pass;
    glbk_result result;
    uint32_t phase;
    if (m->compute) {
        glbk__ism_bind_surfels(ctx, m);
        glbk_bind_image(ctx, GLBK_SLOT_glbk_ism_planes_out, &m->planes);
        return glbk__ism_dispatch(ctx, m, &m->splat, 64);
    }
    memset(&pass, 0, sizeof pass);
    pass.target = &m->plane_target;
    pass.depth = GLBK_DEPTH_LESS;
    result = glbk_begin(ctx, &pass, &m->splat);
    if (result != GLBK_OK) return result;
    glbk_clear(ctx, &m->plane_target, 0, empty);
    glbk_clear_depth(ctx, 1);
    if (!m->triangle_count || !m->vpl_count) return GLBK_OK;
    glbk__ism_bind_surfels(ctx, m);
    for (phase = 0; phase < m->desc.lazy_frames && result == GLBK_OK; phase++)
        result = glbk__ism_draw_phase(ctx, m, phase, surfels_per_pass ? surfels_per_pass : 1u << 20);
    return result;
}

/* Binds the textures and the block that holes are found and filled from. */
static void glbk__ism_bind_planes(glbk_context *ctx, const glbk_ism_maps *m)
{
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_vpls, &m->vpls);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_planes, &m->planes);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame);
}

/* Draws a pass over a whole target, which reads the maps and `below`: the kept texels, or the level of pull
   below. */
static glbk_result glbk__ism_pass(glbk_context *ctx, const glbk_ism_maps *m, const glbk_target *target,
                                  glbk_program *program, const glbk_texture *below)
{
    glbk_pass pass;
    glbk_result result;
    uint32_t i;
    memset(&pass, 0, sizeof pass);
    pass.target = target;
    result = glbk_begin(ctx, &pass, program);
    if (result != GLBK_OK) return result;
    if (below) {
        glbk__ism_bind_planes(ctx, m);
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_below, below);
    }
    for (i = 0; target == &m->atlas_target && i < GLBK_ISM_LEVELS; i++)
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_pull1 + i, &m->pull[i]);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

/* Makes the atlas from the surfels that were drawn: finds holes, pulls, pushes. */
static glbk_result glbk__ism_fill(glbk_context *ctx, glbk_ism_maps *m)
{
    uint32_t i, levels = glbk__ism_levels(m);
    glbk_result result;
    if (m->compute) {
        glbk__ism_bind_planes(ctx, m);
        glbk_bind_image(ctx, GLBK_SLOT_glbk_ism_atlas_out, &m->atlas);
        return glbk__ism_dispatch(ctx, m, &m->fill, 32);
    }
    result = glbk__ism_pass(ctx, m, &m->kept_target, &m->holes, &m->planes);
    for (i = 0; i < levels && result == GLBK_OK; i++)
        result = glbk__ism_pass(ctx, m, &m->pull_target[i], &m->pull_program[i],
                                i ? &m->pull[i - 1] : &m->kept);
    return result == GLBK_OK ? glbk__ism_pass(ctx, m, &m->atlas_target, &m->push, &m->kept) : result;
}

/* Checks that the surfels of all phases were given. */
static glbk_result glbk__ism_check_phases(const glbk_context *ctx, const char *function,
                                          const glbk_ism_maps *m)
{
    char line[GLBK__LINE_ROOM];
    glbk__sink sink;
    uint32_t phase = 0;
    while (phase < m->desc.lazy_frames && (m->phases >> phase & 1)) phase++;
    if (phase == m->desc.lazy_frames) return GLBK_OK;
    glbk__begin_line(&sink, line);
    glbk__append_text(&sink, "the surfels of phase ");
    glbk__append_number(&sink, phase);
    return glbk__refuse(ctx, GLBK_ERR_ORDER, function, line,
                        "were not given since the mesh has its triangles: glbk_ism_surfels_upload");
}

GLBK_DEF glbk_result glbk_ism_draw(glbk_context *ctx, glbk_ism_maps *m, uint32_t surfels_per_pass)
{
    glbk_result result = glbk__ism_check_maps(ctx, __func__, m);
    if (result == GLBK_OK && m->triangle_count) result = glbk__ism_check_phases(ctx, __func__, m);
    if (result == GLBK_OK) result = glbk__ism_splat(ctx, m, surfels_per_pass);
    if (result == GLBK_OK) result = glbk__ism_fill(ctx, m);
    if (result != GLBK_OK) return result;
    m->drawn = 1;
    m->outdated = 0;
    return GLBK_OK;
}

/* ==== src/gl_ism/renderer.h ==== */

/* ---- ism: the renderer: light of all VPLs at the pixels of a G-buffer ---- */

/* Returns the values of the uniform block for a shading, which has its defaults. */
static glbk_ism_view glbk__ism_view_of(const ism_shading *s)
{
    glbk_ism_view view;
    memset(&view, 0, sizeof view);
    view.interleave = s->interleave;
    view.no_maps = s->no_maps != 0;
    view.bias = s->bias;
    view.clamp_at = s->clamp;
    return view;
}

/* Binds the textures and the block that shading reads of maps. */
static void glbk__ism_bind_maps(glbk_context *ctx, const glbk_ism_maps *m, const glbk_offset *offset)
{
    const glbk_offset at = glbk__offset(offset);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_ism_vpls, &m->vpls);
    glbk_bind_texture(ctx, at.unit + GLBK_SLOT_glbk_ism_atlas, &m->atlas);
    glbk_bind_block(ctx, at.block + GLBK_SLOT_glbk_ism_frame, &m->frame);
}

GLBK_DEF glbk_result glbk_ism_bind(glbk_context *ctx, const glbk_ism_maps *m, const ism_shading *shading,
                                   const glbk_offset *offset)
{
    ism_shading s;
    glbk_ism_view view;
    glbk_result result = glbk__ism_check_maps(ctx, __func__, m);
    if (result == GLBK_OK) result = glbk__ism_check_shading(ctx, __func__, shading, &s);
    if (result != GLBK_OK) return result;
    view = glbk__ism_view_of(&s);
    result = glbk__put_block(ctx, glbk__offset(offset).block + GLBK_SLOT_glbk_ism_view, &m->view, &view);
    if (result == GLBK_OK) glbk__ism_bind_maps(ctx, m, offset);
    return result;
}

/* Makes the pictures of a renderer, of a size. */
static void glbk__ism_make_pictures(glbk__ism_making *k, glbk_ism_renderer *r, uint32_t width,
                                    uint32_t height)
{
    r->width = width;
    r->height = height;
    glbk__ism_make_canvas(k, GLBK_FORMAT_COLOR, width, height, NULL, &r->light, &r->light_target);
    glbk__ism_make_canvas(k, GLBK_FORMAT_COLOR, width, height, NULL, &r->result, &r->result_target);
}

GLBK_DEF glbk_result glbk_ism_renderer_create(glbk_context *ctx, const glbk_ism_renderer_desc *d,
                                              glbk_ism_renderer *out)
{
    glbk__ism_making k;
    glbk_result result;
    result = glbk__enter_create(ctx, __func__, out, sizeof *out);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "desc", d);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "desc.width", d->width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "desc.height", d->height);
    if (result != GLBK_OK) return result;
    out->compute = ctx->compute;
    k = glbk__ism_begin_making(ctx);
    glbk__ism_make_pictures(&k, out, d->width, d->height);
    glbk__ism_make_block(&k, sizeof(glbk_ism_view), &out->view);
    glbk__ism_make_program(&k, out->compute ? "ism_blur.comp" : "ism_blur.frag", &out->blur);
    glbk__ism_make_program(&k, "ism_resolve.frag", &out->resolve);
    if (k.result != GLBK_OK) glbk_ism_renderer_free(ctx, out);
    return k.result;
}

static void glbk__ism_free_pictures(glbk_context *ctx, glbk_ism_renderer *r)
{
    glbk_target_free(ctx, &r->light_target);
    glbk_target_free(ctx, &r->result_target);
    glbk_texture_free(ctx, &r->light);
    glbk_texture_free(ctx, &r->result);
}

GLBK_DEF glbk_result glbk_ism_renderer_resize(glbk_context *ctx, glbk_ism_renderer *r, uint32_t width,
                                              uint32_t height)
{
    glbk__ism_making k;
    glbk_result result = glbk__require_created(ctx, __func__, "renderer", r ? &r->result_target.name : NULL);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "width", width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "height", height);
    if (result != GLBK_OK) return result;
    glbk__ism_free_pictures(ctx, r);
    k = glbk__ism_begin_making(ctx);
    glbk__ism_make_pictures(&k, r, width, height);
    if (k.result != GLBK_OK) glbk_ism_renderer_free(ctx, r);
    return k.result;
}

static void glbk__ism_free_shade(glbk_context *ctx, glbk_ism_renderer *r)
{
    int projection, near_mode;
    for (projection = 0; projection < ISM_PROJECTION_COUNT; projection++)
        for (near_mode = 0; near_mode < ISM_NEAR_COUNT; near_mode++)
            glbk_program_free(ctx, &r->shade[projection][near_mode]);
}

GLBK_DEF void glbk_ism_renderer_free(glbk_context *ctx, glbk_ism_renderer *r)
{
    if (!r) return;
    glbk__ism_free_pictures(ctx, r);
    glbk__ism_free_shade(ctx, r);
    glbk_buffer_free(ctx, &r->view);
    glbk_program_free(ctx, &r->blur);
    glbk_program_free(ctx, &r->resolve);
    memset(r, 0, sizeof *r);
}

/* The objects that the passes of a glbk_ism_shade read and write. */
typedef struct glbk__ism_job {
    const glbk_ism_renderer *renderer;
    const glbk_gbuffer      *gbuffer;
    const glbk_ism_maps     *maps;
    glbk_program            *program;
    glbk_ism_view            view;
} glbk__ism_job;

GLBK_DEF glbk_result glbk_ism_renderer_see(glbk_context *ctx, glbk_ism_renderer *r,
                                           const glbk_ism_visible *own)
{
    const glbk_result result = glbk__ism_check_renderer(ctx, __func__, r);
    if (result != GLBK_OK) return result;
    glbk__ism_free_shade(ctx, r);
    memset(&r->own, 0, sizeof r->own);
    if (own && own->text) r->own = *own;    /* without a text bind_fn is not called either */
    return GLBK_OK;
}

/* Returns whether a pass is computed. With a function of the user's, fragments are shaded, so that its
   program is in use before it is drawn with. */
static int glbk__ism_by_compute(const glbk_ism_renderer *r, int blur)
{
    return r->compute && (blur || !r->own.text);
}

/* Finds the program of a projection and of a rule near by, and compiles it at first use. */
static glbk_result glbk__ism_shade_program(glbk_context *ctx, glbk_ism_renderer *r, ism_projection projection,
                                           ism_near near_mode, glbk_program **out)
{
    const char *name = glbk__ism_by_compute(r, 0) ? "ism_shade.comp" : "ism_shade.frag";
    char defines[] = "ISM_PROJECTION=1 ISM_NEAR=1 GLBK_OWN_VISIBLE";
    const char *texts[2] = { NULL, NULL };
    *out = &r->shade[projection][near_mode];
    if ((*out)->name) return GLBK_OK;
    defines[15] = (char)('0' + (int)projection);
    defines[26] = (char)('0' + (int)near_mode);
    texts[1] = r->own.text;
    if (!texts[1]) defines[27] = 0;
    return glbk__gbuffer_program_with(ctx, glbk_ism_part(), name, defines, texts, *out);
}

/* Runs the job's program over `rows` rows of pixels from row `first` on. The program reads the G-buffer and
   either the maps or, if blur is not 0, the light. A group of the compute path has 16 x 16 pixels of one
   class, which lie `side` apart. */
static glbk_result glbk__ism_pixels_pass(glbk_context *ctx, const glbk__ism_job *job, int blur, uint32_t side,
                                         uint32_t first, uint32_t rows)
{
    const glbk_ism_renderer *r = job->renderer;
    const uint32_t square = 16 * side;
    const int compute = glbk__ism_by_compute(r, blur);
    glbk_pass pass;
    glbk_result result = GLBK_OK;
    memset(&pass, 0, sizeof pass);
    pass.target = blur ? &r->result_target : &r->light_target;
    pass.viewport[1] = (int32_t)first;
    pass.viewport[2] = (int32_t)r->width;
    pass.viewport[3] = (int32_t)rows;
    if (!compute) result = glbk_begin(ctx, &pass, job->program);
    if (result != GLBK_OK) return result;
    (void)glbk_gbuffer_bind(ctx, job->gbuffer, NULL);       /* The callers have checked it. */
    if (blur) glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_light, &r->light);
    else glbk__ism_bind_maps(ctx, job->maps, NULL);
    if (!blur && r->own.bind_fn) r->own.bind_fn(r->own.user, ctx);
    if (!compute) {
        glbk_draw_screen(ctx);
        return GLBK_OK;
    }
    glbk_bind_image(ctx, GLBK_SLOT_glbk_ism_light_out, blur ? &r->result : &r->light);
    return glbk_dispatch(ctx, job->program, (r->width + square - 1) / square, (rows + square - 1) / square,
                         side * side);
}

/* Lights all pixels by all VPLs. A pass has as many rows as make about `pairs` pairs of a pixel and a VPL, in
   whole squares of the compute path. */
static glbk_result glbk__ism_shade_all(glbk_context *ctx, glbk__ism_job *job, uint32_t pairs)
{
    const glbk_ism_renderer *r = job->renderer;
    const uint32_t side = job->view.interleave, square = 16 * side;
    const uint64_t row = (uint64_t)r->width * (job->maps->vpl_count / (side * side) + 1);
    uint64_t step = (pairs ? pairs : 1u << 28) / row / square * square;
    glbk_result result = GLBK_OK;
    uint32_t first = 0, rows;
    if (step < square) step = square;
    for (; first < r->height && result == GLBK_OK; first += rows) {
        rows = r->height - first < step ? r->height - first : (uint32_t)step;
        job->view.first_row = first;
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_ism_view, &r->view, &job->view);
        if (result == GLBK_OK) result = glbk__ism_pixels_pass(ctx, job, 0, side, first, rows);
    }
    return result;
}

GLBK_DEF glbk_result glbk_ism_shade(glbk_context *ctx, glbk_ism_renderer *r, const glbk_gbuffer *g,
                                    const glbk_ism_maps *m, const ism_shading *shading,
                                    uint32_t pairs_per_pass)
{
    glbk__ism_job job;
    ism_shading s;
    glbk_result result = glbk__ism_check_gbuffer(ctx, __func__, r, g);
    if (result == GLBK_OK) result = glbk__ism_check_maps(ctx, __func__, m);
    if (result == GLBK_OK) result = glbk__ism_check_shading(ctx, __func__, shading, &s);
    if (result != GLBK_OK) return result;
    if (r->own.text) s.no_maps = 0;         /* as ism_shade asks its visible_fn in any case */
    else if (m->vpl_count && !m->drawn && !s.no_maps)
        return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "maps", "must be drawn first: glbk_ism_draw");
    job.renderer = r;
    job.gbuffer = g;
    job.maps = m;
    job.view = glbk__ism_view_of(&s);
    job.view.width = r->width;
    job.view.height = r->height;
    result = glbk__ism_shade_program(ctx, r, m->desc.projection, s.near_mode, &job.program);
    if (result == GLBK_OK) result = glbk__ism_shade_all(ctx, &job, pairs_per_pass);
    if (result != GLBK_OK) return result;
    job.program = &r->blur;
    return glbk__ism_pixels_pass(ctx, &job, 1, 1, 0, r->height);
}

GLBK_DEF glbk_result glbk_ism_resolve(glbk_context *ctx, glbk_ism_renderer *r, const glbk_gbuffer *g,
                                      const glbk_pass *pass, const glbk_picture *picture)
{
    glbk_result result = glbk__ism_check_gbuffer(ctx, __func__, r, g);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "pass", pass);
    if (result != GLBK_OK) return result;
    result = glbk__begin_picture(ctx, __func__, pass, picture, r->width, r->height, &r->resolve);
    if (result != GLBK_OK) return result;
    (void)glbk_gbuffer_bind(ctx, g, NULL);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_light, &r->result);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_ism_read(glbk_context *ctx, const glbk_ism_renderer *r, float *rgba)
{
    glbk_result result = glbk__ism_check_renderer(ctx, __func__, r);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "rgba", rgba);
    if (result != GLBK_OK) return result;
    return glbk_target_read(ctx, &r->result_target, 0, 0, 0, r->width, r->height, rgba);
}

/* ==== src/gl_ism/choice.h ==== */

/* ---- ism: VPLs chosen on the GPU ---- */

enum { GLBK__ISM_BLOCK = 32,        /* values that one block of running sums has */
       GLBK__ISM_ROW = 256,         /* VPLs in a row of glbk_ism_choice.drawn */
       GLBK__ISM_WIDEST = 32768 };  /* values that three levels of blocks sum up */

enum { GLBK__ISM_WEIGH, GLBK__ISM_SCAN, GLBK__ISM_CHOOSE, GLBK__ISM_EDGES, GLBK__ISM_EFFECT, GLBK__ISM_EXTENT,
       GLBK__ISM_WINDOW = GLBK__ISM_EXTENT + 2, GLBK__ISM_SIGHT,
       GLBK__ISM_NEAR = GLBK__ISM_SIGHT + 2, GLBK__ISM_NEAR_SORT, GLBK__ISM_NEAR_TABLE,
       GLBK__ISM_CHOICE_PROGRAMS };

/* Returns whether effects on the picture count in the choice, and not flux alone. */
static uint32_t glbk__ism_by_effect(const ism_desc *d) { return d->importance != ISM_IMPORTANCE_FLUX; }

static uint32_t glbk__ism_blocks(uint32_t count) { return (count + GLBK__ISM_BLOCK - 1) / GLBK__ISM_BLOCK; }

/* Returns how many rows all faces of a source have. */
static uint32_t glbk__ism_source_rows(const glbk_ism_choice_desc *d) { return d->height * d->face_count; }

/* Checks a desc, whose face_count has its default, against the context's limits. */
static glbk_result glbk__ism_check_choice_desc(const glbk_context *ctx, const char *function,
                                               const glbk_ism_choice_desc *d, const ism_desc *maps)
{
    static const char fields[] =
        "maps->desc.importance\0" "a value of ism_importance\0"
        "maps->desc.view_grid_side\0" "0 or 1..16\0"
        "maps->desc.blur_radius\0" "16 at most\0"
        "maps->desc.flux_share\0" "0..1\0";
    static const glbk__ism_range ranges[] = {
        { 0, ISM_IMPORTANCE_COUNT - 1 }, { 1, 16 }, { -2147483648.0, 16 }, { 0, 1 }
    };
    const uint32_t widest = GLBK__ISM_WIDEST;
    double values[4];
    const double most = ctx->max_side < widest ? ctx->max_side : widest;
    if (!d->width || !d->height)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, function, d->width ? "desc.height" : "desc.width", 0,
                                  "1 or more");
    if (d->width > most)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "desc.width", d->width, 1, most);
    if ((double)d->height * d->face_count > most)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "desc.height times desc.face_count",
                                  (double)d->height * d->face_count, 1, most);
    values[0] = (double)maps->importance;
    values[1] = maps->view_grid_side;
    values[2] = maps->blur_radius;
    values[3] = (double)maps->flux_share;
    return glbk__ism_in_range(ctx, function, fields, ranges, values);
}

static void glbk__ism_make_sheet(glbk__ism_making *k, glbk_format format, uint32_t width, uint32_t height,
                                 glbk_ism_sheet *out)
{
    glbk__ism_make_canvas(k, format, width, height, NULL, &out->texture, &out->target);
}

static void glbk__ism_free_sheets(glbk_context *ctx, glbk_ism_sheet *sheets, uint32_t count)
{
    uint32_t k;
    for (k = 0; k < count; k++) {
        glbk_target_free(ctx, &sheets[k].target);
        glbk_texture_free(ctx, &sheets[k].texture);
    }
}

/* Makes programs, whose names stand one after the other, each ended by 0. */
static void glbk__ism_make_passes(glbk__ism_making *k, const char *names, glbk_program *out)
{
    for (; *names; names += strlen(names) + 1) glbk__ism_make_program(k, names, out++);
}

/* Makes one level of running sums after the other. */
static void glbk__ism_make_sums(glbk__ism_making *k, uint32_t width, uint32_t height, int columns,
                                glbk_ism_sheet *sums)
{
    uint32_t i;
    for (i = 0; i < GLBK_ISM_SUM_LEVELS; i++) {
        glbk__ism_make_sheet(k, GLBK_FORMAT_RG32UI, width, height, &sums[i]);
        if (columns) height = glbk__ism_blocks(height);
        else width = glbk__ism_blocks(width);
    }
}

/* Makes a texture of some layers, or with 0 without layers. */
static void glbk__ism_make_layers(glbk__ism_making *k, glbk_format format, uint32_t width, uint32_t height,
                                  uint32_t layers, glbk_texture *out)
{
    glbk_texture_desc d;
    memset(&d, 0, sizeof d);
    d.format = format;
    d.width = width;
    d.height = height;
    d.layers = layers;
    if (k->result == GLBK_OK) k->result = glbk_texture_create(k->ctx, &d, out);
}

/* Makes a target of `first`, which may be NULL, and then of some layers of a texture. */
static void glbk__ism_make_target(glbk__ism_making *k, const glbk_texture *first, const glbk_texture *texture,
                                  uint32_t layers, glbk_target *out)
{
    const uint32_t before = first != NULL;
    glbk_target_desc t;
    uint32_t i;
    memset(&t, 0, sizeof t);
    t.color[0] = first;
    for (i = 0; i < layers; i++) {
        t.color[before + i] = texture;
        t.layer[before + i] = i;
    }
    if (k->result == GLBK_OK) k->result = glbk__target_create(k->ctx, &t, out);
}

/* Makes pictures of four whole numbers a texel that are drawn together. */
static void glbk__ism_make_stack(glbk__ism_making *k, uint32_t width, uint32_t height, uint32_t layers,
                                 glbk_ism_sheet *out)
{
    glbk__ism_make_layers(k, GLBK_FORMAT_RGBA32UI, width, height, layers, &out->texture);
    glbk__ism_make_target(k, NULL, &out->texture, layers, &out->target);
}

/* Returns whether tiles have windows. Those for ism_bounce have none. */
static int glbk__ism_has_windows(const ism_desc *d) { return d->window_rim > 0 && !d->keep_hits; }

/* Makes what windows need. */
static void glbk__ism_make_windows(glbk__ism_making *k, const ism_desc *d, glbk_ism_choice *c)
{
    char defines[] = "ISM_PROJECTION=1";
    const glbk_texture *drawn = &c->drawn.texture;
    uint32_t i;
    if (!glbk__ism_has_windows(d)) return;
    for (i = 0; i < 2; i++) {
        glbk__ism_make_stack(k, 64, i ? 8 : 32, 2, &c->sights[i]);
        glbk__ism_make_sheet(k, GLBK_FORMAT_RGBA32UI, drawn->width, drawn->height, &c->windows[i]);
    }
    defines[15] = (char)('0' + (int)d->projection);
    k->defines = defines;
    glbk__ism_make_program(k, "ism_windows.frag", &c->programs[GLBK__ISM_WINDOW]);
    k->defines = NULL;
    glbk__ism_make_program(k, "ism_sights.frag", &c->programs[GLBK__ISM_SIGHT]);
    k->defines = "FROM=1";
    glbk__ism_make_program(k, "ism_sights.frag", &c->programs[GLBK__ISM_SIGHT + 1]);
    k->defines = NULL;
}

/* Makes what effects on the picture need. By flux alone there is one texel, which nobody reads. */
static void glbk__ism_make_effects(glbk__ism_making *k, uint32_t by_effect, glbk_ism_choice *c)
{
    const uint32_t width = by_effect ? c->desc.width : 1;
    const uint32_t rows = by_effect ? glbk__ism_source_rows(&c->desc) : 1;
    uint32_t i;
    glbk__ism_make_sheet(k, GLBK_FORMAT_R32UI, width, rows, &c->effects);
    if (!by_effect) return;
    for (i = 0; i < 3; i++)
        glbk__ism_make_stack(k, i < 2 ? GLBK__ISM_BLOCK : 1, i < 1 ? GLBK__ISM_BLOCK : 1, 2, &c->boxes[i]);
    glbk__ism_make_passes(k, "ism_effect.frag\0ism_extent.frag\0", &c->programs[GLBK__ISM_EFFECT]);
    k->defines = "FROM=1";
    glbk__ism_make_program(k, "ism_extent.frag", &c->programs[GLBK__ISM_EXTENT + 1]);
    k->defines = NULL;
}

/* Makes what near points need. There are none by 8 VPLs or fewer, since a reach goes by the eighth VPL about
   its point, and where the first layer of the table has no room for them. */
static void glbk__ism_make_near(glbk__ism_making *k, const glbk_ism_maps *m, glbk_ism_choice *c)
{
    const uint32_t vpls = m->desc.vpl_count, count = vpls * (uint32_t)m->desc.near_point_count;
    const uint32_t rows = (count + GLBK__ISM_ROW - 1) / GLBK__ISM_ROW;
    if (!count || vpls <= 8 || glbk__ism_vpl_texels(m) + glbk__ism_spheres(m) + 3 * count > 1 << 20) return;
    c->near_point_count = count;
    glbk__ism_make_stack(k, GLBK__ISM_ROW, rows, 3, &c->near_points);
    glbk__ism_make_sheet(k, GLBK_FORMAT_RGBA32UI, GLBK__ISM_ROW, rows, &c->near_sheets[0]);
    glbk__ism_make_sheet(k, GLBK_FORMAT_R32UI, GLBK__ISM_ROW, rows, &c->near_sheets[1]);
    glbk__ism_make_passes(k, "ism_near.frag\0ism_near_sort.frag\0ism_near_table.frag\0",
                          &c->programs[GLBK__ISM_NEAR]);
}

static glbk_result glbk__ism_create_choice(glbk_context *ctx, const glbk_ism_maps *m, glbk_ism_choice *c)
{
    const uint32_t width = c->desc.width, rows = glbk__ism_source_rows(&c->desc);
    glbk__ism_making k = glbk__ism_begin_making(ctx);
    glbk__ism_make_sheet(&k, GLBK_FORMAT_RG32UI, width, rows, &c->importances);
    glbk__ism_make_sums(&k, width, rows, 0, c->row_sums);
    glbk__ism_make_sums(&k, 1, rows, 1, c->column_sums);
    glbk__ism_make_effects(&k, glbk__ism_by_effect(&m->desc), c);
    glbk__ism_make_stack(&k, GLBK__ISM_ROW, (m->desc.vpl_count + GLBK__ISM_ROW - 1) / GLBK__ISM_ROW, 3,
                         &c->drawn);
    glbk__ism_make_windows(&k, &m->desc, c);
    glbk__ism_make_near(&k, m, c);
    glbk__ism_make_target(&k, NULL, &m->vpls, 1, &c->table_target);
    glbk__ism_make_block(&k, sizeof(glbk_ism_choosing), &c->block);
    glbk__ism_make_passes(&k, "ism_weigh.frag\0ism_scan.frag\0ism_choose.frag\0ism_edges.frag\0",
                          c->programs);
    c->table = m->vpls.name;
    return k.result;
}

GLBK_DEF glbk_result glbk_ism_choice_create(glbk_context *ctx, const glbk_ism_maps *m,
                                            const glbk_ism_choice_desc *desc, glbk_ism_choice *out)
{
    glbk_ism_choice_desc d;
    glbk_result result;
    result = glbk__enter_create(ctx, __func__, out, sizeof *out);
    if (result == GLBK_OK) result = glbk__ism_check_maps(ctx, __func__, m);
    if (result == GLBK_OK) result = glbk__require(ctx, __func__, "desc", desc);
    if (result != GLBK_OK) return result;
    d = *desc;
    if (!d.face_count) d.face_count = 1;
    result = glbk__ism_check_choice_desc(ctx, __func__, &d, &m->desc);
    if (result != GLBK_OK) return result;
    out->desc = d;
    result = glbk__ism_create_choice(ctx, m, out);
    if (result != GLBK_OK) glbk_ism_choice_free(ctx, out);
    return result;
}

/* Sets how effects on the picture are weighed, as ism_choose does. */
static void glbk__ism_weighing_of(const glbk_ism_choice *c, const ism_desc *maps, glbk_ism_choosing *b)
{
    const uint32_t side = c->desc.width < c->desc.height ? c->desc.width : c->desc.height;
    const double share = maps->flux_share > 0 ? (double)maps->flux_share : (double)0.1f;
    uint32_t radius = maps->blur_radius > 0 ? (uint32_t)maps->blur_radius : 0;
    if (!maps->blur_radius) radius = side < 120 ? (uint32_t)(0.05f * (float)side) : 6;
    b->grid_side = maps->view_grid_side ? maps->view_grid_side : 4;
    b->guided = maps->importance != ISM_IMPORTANCE_BRSM && maps->importance != ISM_IMPORTANCE_BRSM_MEAN;
    b->by_mean = maps->importance == ISM_IMPORTANCE_BRSM_MEAN ||
                 maps->importance == ISM_IMPORTANCE_GUIDED_MEAN;
    b->blur_radius = c->desc.scattered ? 0 : radius;
    b->flux_factor = (float)(share / (1.0 - 0.999 * share));
}

/* Sets the values of the block that all passes of a frame have in common. The random numbers are those of
   ism_choose. */
static void glbk__ism_set_choosing(const glbk_ism_choice *c, const ism_desc *maps, const glbk_gbuffer *seen,
                                   uint32_t index, glbk_ism_choosing *b)
{
    const uint32_t key = maps->unstable ? glbk_ism__hash_combine(maps->seed, index) : maps->seed;
    memset(b, 0, sizeof *b);
    if (seen) {
        b->view_width = seen->width;
        b->view_height = seen->height;
    }
    if (seen && glbk__ism_has_windows(maps)) b->windows = c->turn && !maps->unstable ? 2 : 1;
    if (seen && seen->has_clip) memcpy(b->world_to_clip, seen->world_to_clip, sizeof b->world_to_clip);
    b->width = c->desc.width;
    b->face_height = c->desc.height;
    b->vpl_count = maps->vpl_count;
    b->inter_texel = !maps->no_inter_texel && !c->desc.scattered;
    if (maps->unstable) b->shift = glbk_ism__to_unit(glbk_ism__hash_combine(key, 11));
    b->shift_bits = glbk_ism__hash_combine(key, 12);
    b->seed = key;
    b->by_effect = glbk__ism_by_effect(maps);
    b->near_point_count = c->near_point_count;
    if (b->by_effect) glbk__ism_weighing_of(c, maps, b);
}

/* Draws a pass over a whole target by a program that reads what is bound after it has begun. */
static glbk_result glbk__ism_begin_choice(glbk_context *ctx, glbk_ism_choice *c, const glbk_target *target,
                                          int program, const glbk_ism_choosing *block)
{
    glbk_pass pass;
    glbk_result result;
    memset(&pass, 0, sizeof pass);
    pass.target = target;
    if (program == GLBK__ISM_EDGES) {       /* the rows that hold VPLs */
        pass.viewport[2] = 4 * GLBK__ISM_ROW;
        pass.viewport[3] = (int32_t)c->drawn.texture.height;
    }
    result = glbk_begin(ctx, &pass, &c->programs[program]);
    if (result != GLBK_OK) return result;
    return glbk__put_block(ctx, GLBK_SLOT_glbk_ism_choosing, &c->block, block);
}

/* Sums up `count` values a row or column, which stand in `from`, level by level. */
static glbk_result glbk__ism_scan(glbk_context *ctx, glbk_ism_choice *c, glbk_ism_choosing *b,
                                  const glbk_texture *from, uint32_t count, int columns)
{
    const glbk_ism_sheet *sums = columns ? c->column_sums : c->row_sums;
    glbk_result result = GLBK_OK;
    uint32_t k;
    b->columns = columns != 0;
    b->pace = 1;
    b->value_count = count;
    b->first_column = columns ? from->width - 1 : 0;    /* where rows have their totals */
    for (k = 0; k < GLBK_ISM_SUM_LEVELS && result == GLBK_OK; k++) {
        result = glbk__ism_begin_choice(ctx, c, &sums[k].target, GLBK__ISM_SCAN, b);
        if (result != GLBK_OK) return result;
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_summed, from);
        glbk_draw_screen(ctx);
        if (k) b->value_count = glbk__ism_blocks(b->value_count);
        b->pace = GLBK__ISM_BLOCK;
        b->first_column = 0;
        from = &sums[k].texture;
    }
    return result;
}

/* Draws the box of the receivers, and then the effects of all texels on them. */
static glbk_result glbk__ism_draw_effects(glbk_context *ctx, glbk_ism_choice *c, const glbk_texture *texels,
                                          const glbk_gbuffer *seen, const glbk_ism_choosing *b)
{
    glbk_result result;
    uint32_t k;
    for (k = 0; k < 3; k++) {
        result = glbk__ism_begin_choice(ctx, c, &c->boxes[k].target, GLBK__ISM_EXTENT + (k > 0), b);
        if (result != GLBK_OK) return result;
        if (k) glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_box, &c->boxes[k - 1].texture);
        else (void)glbk_gbuffer_bind(ctx, seen, NULL);      /* The caller has checked it. */
        glbk_draw_screen(ctx);
    }
    result = glbk__ism_begin_choice(ctx, c, &c->effects.target, GLBK__ISM_EFFECT, b);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_texels, texels);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_box, &c->boxes[2].texture);
    (void)glbk_gbuffer_bind(ctx, seen, NULL);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

/* Draws which receivers lie farthest out, and the windows that hold them. */
static glbk_result glbk__ism_draw_windows(glbk_context *ctx, glbk_ism_choice *c, const glbk_ism_maps *m,
                                          const glbk_gbuffer *seen, const glbk_ism_choosing *b)
{
    glbk_result result;
    uint32_t k;
    for (k = 0; k < 2; k++) {
        result = glbk__ism_begin_choice(ctx, c, &c->sights[k].target, GLBK__ISM_SIGHT + (int)k, b);
        if (result != GLBK_OK) return result;
        if (k) glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_sights, &c->sights[0].texture);
        (void)glbk_gbuffer_bind(ctx, seen, NULL);       /* The caller has checked it. */
        glbk_draw_screen(ctx);
    }
    k = ++c->turn & 1;
    result = glbk__ism_begin_choice(ctx, c, &c->windows[k].target, GLBK__ISM_WINDOW, b);
    if (result != GLBK_OK) return result;
    glbk_bind_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_drawn, &c->drawn.texture);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_sights, &c->sights[1].texture);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_windows, &c->windows[!k].texture);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

/* Draws VPLs, or near points, from the sums. */
static glbk_result glbk__ism_draw_samples(glbk_context *ctx, glbk_ism_choice *c, const glbk_target *target,
                                          const glbk_texture *texels, const glbk_ism_choosing *b)
{
    glbk_result result = glbk__ism_begin_choice(ctx, c, target, GLBK__ISM_CHOOSE, b);
    uint32_t k;
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_texels, texels);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_importances, &c->importances.texture);
    for (k = 0; k < GLBK_ISM_SUM_LEVELS; k++) {
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_row_sums0 + k, &c->row_sums[k].texture);
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_column_sums0 + k, &c->column_sums[k].texture);
    }
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

/* Draws the VPLs from the sums, their windows, and then the table of VPLs. */
static glbk_result glbk__ism_draw_choice(glbk_context *ctx, glbk_ism_choice *c, const glbk_ism_maps *m,
                                         const glbk_texture *texels, const glbk_gbuffer *seen,
                                         const glbk_ism_choosing *b)
{
    glbk_result result = glbk__ism_draw_samples(ctx, c, &c->drawn.target, texels, b);
    if (result != GLBK_OK) return result;
    if (b->windows) result = glbk__ism_draw_windows(ctx, c, m, seen, b);
    else c->turn = 0;
    if (result == GLBK_OK) result = glbk__ism_begin_choice(ctx, c, &c->table_target, GLBK__ISM_EDGES, b);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_drawn, &c->drawn.texture);
    /* A sampler that is not read may not be without whole numbers either. */
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_windows,
                      b->windows ? &c->windows[c->turn & 1].texture : &c->importances.texture);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF void glbk_ism_choice_free(glbk_context *ctx, glbk_ism_choice *c)
{
    uint32_t k;
    if (!c) return;
    for (k = 0; k < GLBK__ISM_CHOICE_PROGRAMS; k++) glbk_program_free(ctx, &c->programs[k]);
    glbk__ism_free_sheets(ctx, c->boxes, 3);
    glbk__ism_free_sheets(ctx, &c->effects, 1);
    glbk__ism_free_sheets(ctx, &c->importances, 1);
    glbk__ism_free_sheets(ctx, c->row_sums, GLBK_ISM_SUM_LEVELS);
    glbk__ism_free_sheets(ctx, c->column_sums, GLBK_ISM_SUM_LEVELS);
    glbk__ism_free_sheets(ctx, &c->drawn, 1);
    glbk__ism_free_sheets(ctx, c->sights, 2);
    glbk__ism_free_sheets(ctx, c->windows, 2);
    glbk__ism_free_sheets(ctx, &c->near_points, 1);
    glbk__ism_free_sheets(ctx, c->near_sheets, 2);
    glbk_target_free(ctx, &c->table_target);
    glbk_buffer_free(ctx, &c->block);
    memset(c, 0, sizeof *c);
}

/* ==== src/gl_ism/choose.h ==== */

/* ---- ism: near points, and all that a frame chooses ---- */

/* Draws one pass about near points: their edges and the like, their order, or their part of the table. */
static glbk_result glbk__ism_near_pass(glbk_context *ctx, glbk_ism_choice *c, const glbk_target *target,
                                       int program, const glbk_ism_choosing *b)
{
    const glbk_result result = glbk__ism_begin_choice(ctx, c, target, program, b);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_near, &c->near_points.texture);
    if (program == GLBK__ISM_NEAR) glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_drawn, &c->drawn.texture);
    else glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_near_facts, &c->near_sheets[0].texture);
    if (program == GLBK__ISM_NEAR_SORT) {
        ctx->gl.DrawArrays(GLBK_GL_POINTS, 0, (int32_t)c->near_point_count);
        return GLBK_OK;
    }
    if (program == GLBK__ISM_NEAR_TABLE)
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_near_order, &c->near_sheets[1].texture);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

/* Draws the near points of the VPLs that are chosen, from the same sums, into the table behind them. */
static glbk_result glbk__ism_draw_near(glbk_context *ctx, glbk_ism_choice *c, const glbk_ism_maps *m,
                                       const glbk_texture *texels, glbk_ism_choosing b)
{
    const uint32_t vpls = b.vpl_count;
    glbk_result result;
    int k;
    b.vpl_count = c->near_point_count;
    b.first_sphere = glbk__ism_vpl_texels(m);
    b.first_near_point = b.first_sphere + glbk__ism_spheres(m);
    b.shift_bits = glbk_ism__hash_combine(b.seed, 14);
    if (m->desc.unstable) b.shift = glbk_ism__to_unit(glbk_ism__hash_combine(b.seed, 13));
    result = glbk__ism_draw_samples(ctx, c, &c->near_points.target, texels, &b);
    b.vpl_count = vpls;
    for (k = 0; k < 3 && result == GLBK_OK; k++)
        result = glbk__ism_near_pass(ctx, c, k < 2 ? &c->near_sheets[k].target : &c->table_target,
                                     GLBK__ISM_NEAR + k, &b);
    return result;
}

/* Checks the arguments of glbk_ism_choose. */
static glbk_result glbk__ism_check_choose(const glbk_context *ctx, const char *function,
                                          const glbk_ism_choice *c, const glbk_ism_maps *m,
                                          const glbk_texture *texels)
{
    glbk_result result = glbk__require_created(ctx, function, "choice", c ? &c->block.name : NULL);
    if (result == GLBK_OK) result = glbk__ism_check_maps(ctx, function, m);
    if (result == GLBK_OK)
        result = glbk__require_created(ctx, function, "texels", texels ? &texels->name : NULL);
    if (result != GLBK_OK) return result;
    if (m->vpls.name != c->table)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, "maps",
                            "are not those that the choice was made for");
    if (texels->format != GLBK_FORMAT_RGBA32UI)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, "texels", "are not GLBK_FORMAT_RGBA32UI");
    if (texels->width != c->desc.width)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "texels->width", texels->width,
                                  "that of the choice");
    if (texels->height != c->desc.height)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "texels->height", texels->height,
                                  "that of the choice");
    if (texels->layers == 3 * c->desc.face_count) return GLBK_OK;
    return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, function, "texels->layers", texels->layers,
                              "three for each face of the choice");
}

GLBK_DEF glbk_result glbk_ism_choose(glbk_context *ctx, glbk_ism_choice *c, glbk_ism_maps *m,
                                     const glbk_texture *texels, const glbk_gbuffer *seen, uint32_t index)
{
    glbk_ism_choosing b;
    glbk_result result = glbk__ism_check_choose(ctx, __func__, c, m, texels);
    if (result != GLBK_OK) return result;
    if (seen || glbk__ism_by_effect(&m->desc))
        result = glbk__require_created(ctx, __func__, "seen", seen ? &seen->colors.name : NULL);
    if (result != GLBK_OK) return result;
    glbk__ism_set_choosing(c, &m->desc, seen, index, &b);
    if (b.by_effect) result = glbk__ism_draw_effects(ctx, c, texels, seen, &b);
    if (result != GLBK_OK) return result;
    result = glbk__ism_begin_choice(ctx, c, &c->importances.target, GLBK__ISM_WEIGH, &b);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_texels, texels);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_effects, &c->effects.texture);
    glbk_draw_screen(ctx);
    result = glbk__ism_scan(ctx, c, &b, &c->importances.texture, c->desc.width, 0);
    if (result == GLBK_OK)
        result = glbk__ism_scan(ctx, c, &b, &c->row_sums[GLBK_ISM_SUM_LEVELS - 1].texture,
                                glbk__ism_source_rows(&c->desc), 1);
    if (result == GLBK_OK) result = glbk__ism_draw_choice(ctx, c, m, texels, seen, &b);
    if (result == GLBK_OK && c->near_point_count) result = glbk__ism_draw_near(ctx, c, m, texels, b);
    if (result != GLBK_OK) return result;
    if (m->vpl_count == m->desc.vpl_count && m->near_point_count == c->near_point_count)
        return GLBK_OK;                         /* the block says so */
    m->vpl_count = m->desc.vpl_count;
    m->near_point_count = c->near_point_count;
    return glbk__ism_write_frame(ctx, m);
}

/* ==== src/gl_ism/scatter.h ==== */

/* ---- ism: surfels scattered on the GPU ---- */

enum { GLBK__ISM_CLUSTERS = 32768,          /* the most clusters that there are, as in ism.h */
       GLBK__ISM_BATCH = 1 << 21,           /* shares that are computed at a time, about */
       GLBK__ISM_LAYER = 1 << 20 };         /* texels of a layer of a table */

enum { GLBK__ISM_MEASURE, GLBK__ISM_GATHER, GLBK__ISM_SHARE, GLBK__ISM_RUN, GLBK__ISM_COUNT,
       GLBK__ISM_SCATTER, GLBK__ISM_GONE, GLBK__ISM_SEE, GLBK__ISM_LIST, GLBK__ISM_PAIRS,
       GLBK__ISM_SPREAD_PROGRAMS };

/* Makes a sheet of `rows` sequences of `count` numbers, as ism_fold.glsl has them. */
static void glbk__ism_make_fold(glbk__ism_making *k, glbk_format format, uint32_t count, uint32_t rows,
                                glbk_ism_sheet *out)
{
    glbk__ism_make_sheet(k, format, count < 1024 ? count : 1024, (count + 1023) / 1024 * rows, out);
}

/* Makes sums of sequences: with `running`, of every number of a block of 32, else of blocks alone. */
static void glbk__ism_make_levels(glbk__ism_making *k, uint32_t count, uint32_t rows, int running,
                                  glbk_ism_sheet *sheets, uint32_t levels)
{
    const glbk_format format = running ? GLBK_FORMAT_R32UI : GLBK_FORMAT_RG32UI;
    uint32_t i;
    for (i = 0; i < levels; i++) {
        if (i || !running) count = glbk__ism_blocks(count);
        glbk__ism_make_fold(k, format, count, rows, &sheets[i]);
    }
}

/* Returns from how many receivers triangles are looked at; 0: surfels are spread by area. */
static uint32_t glbk__ism_views(const ism_desc *d)
{
    if (d->spread == ISM_SPREAD_AREA) return 0;
    return d->spread == ISM_SPREAD_VIEW_1 ? 1 : 8;
}

static int glbk__ism_by_pair(const ism_desc *d)
{
    return d->spread == ISM_SPREAD_DEFAULT || d->spread == ISM_SPREAD_PAIR;
}

static glbk_result glbk__ism_create_spread(glbk_context *ctx, const glbk_ism_maps *m, glbk_ism_spread *s)
{
    char defines[] = "ISM_PROJECTION=1";
    glbk__ism_making k = glbk__ism_begin_making(ctx);
    defines[15] = (char)('0' + (int)m->desc.projection);
    k.defines = defines;
    /* Each pass chooses the layer. */
    glbk__ism_make_target(&k, NULL, m->compute ? &m->surfels : m->phase_surfels, 1, &s->surfel_target);
    glbk__ism_make_fold(&k, GLBK_FORMAT_R32UI, m->desc.vpl_count, 1, &s->counts);
    glbk__ism_make_sheet(&k, GLBK_FORMAT_R8UI, 1024, 1024, &s->gone);       /* of a layer's texels */
    glbk__ism_make_block(&k, sizeof(glbk_ism_scattering), &s->block);
    glbk__ism_make_passes(&k, "ism_sizes.frag\0ism_clusters.frag\0ism_shares.frag\0ism_run.frag\0"
                          "ism_counts.frag\0ism_points.frag\0ism_gone.frag\0", s->programs);
    if (glbk__ism_views(&m->desc))
        glbk__ism_make_passes(&k, "ism_seen.frag\0ism_receivers.frag\0", &s->programs[GLBK__ISM_SEE]);
    if (glbk__ism_by_pair(&m->desc))
        glbk__ism_make_program(&k, "ism_pairs.frag", &s->programs[GLBK__ISM_PAIRS]);
    s->table = m->vpls.name;
    return k.result;
}

GLBK_DEF glbk_result glbk_ism_spread_create(glbk_context *ctx, const glbk_ism_maps *m, glbk_ism_spread *out)
{
    static const char fields[] =
        "maps->desc.spread\0" "a value of ism_spread\0"
        "maps->desc.area_share\0" "0..1\0";
    static const glbk__ism_range ranges[] = {
        { 0, ISM_SPREAD_COUNT - 1 }, { 0, 1 }
    };
    double values[2];
    glbk_result result = glbk__enter_create(ctx, __func__, out, sizeof *out);
    if (result == GLBK_OK) result = glbk__ism_check_maps(ctx, __func__, m);
    if (result != GLBK_OK) return result;
    values[0] = (double)m->desc.spread;
    values[1] = (double)m->desc.area_share;
    result = glbk__ism_in_range(ctx, __func__, fields, ranges, values);
    if (result != GLBK_OK) return result;
    result = glbk__ism_create_spread(ctx, m, out);
    if (result != GLBK_OK) glbk_ism_spread_free(ctx, out);
    return result;
}

static void glbk__ism_free_view(glbk_context *ctx, glbk_ism_spread *s)
{
    glbk__ism_free_sheets(ctx, &s->seen, 1);
    glbk__ism_free_sheets(ctx, s->seen_sums, 5);
    glbk__ism_free_sheets(ctx, &s->receivers, 1);
    s->width = s->height = 0;
}

/* Makes room for the receivers of a picture, if it has not the size of the last one. */
static glbk_result glbk__ism_hold_view(glbk_context *ctx, glbk_ism_spread *s, const glbk_gbuffer *seen)
{
    const double pixels = (double)seen->width * seen->height;
    const uint32_t count = (uint32_t)pixels;
    glbk__ism_making k = glbk__ism_begin_making(ctx);
    if (s->width == seen->width && s->height == seen->height) return GLBK_OK;
    glbk__ism_free_view(ctx, s);
    if (pixels > 16777216)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, "glbk_ism_scatter", "the pixels of seen", pixels, 1,
                                  16777216);
    glbk__ism_make_fold(&k, GLBK_FORMAT_R32UI, count, 1, &s->seen);
    glbk__ism_make_levels(&k, count, 1, 1, s->seen_sums, 5);
    glbk__ism_make_fold(&k, GLBK_FORMAT_RGBA32UI, count, 1, &s->receivers);
    if (k.result != GLBK_OK) {
        glbk__ism_free_view(ctx, s);
        return k.result;
    }
    s->width = seen->width;
    s->height = seen->height;
    return GLBK_OK;
}

static void glbk__ism_free_triangles(glbk_context *ctx, glbk_ism_spread *s)
{
    glbk__ism_free_sheets(ctx, &s->sizes, 1);
    glbk__ism_free_sheets(ctx, &s->masses, 1);
    glbk_texture_free(ctx, &s->clusters);
    glbk__ism_free_sheets(ctx, s->totals, 3);
    glbk__ism_free_sheets(ctx, &s->effects, 1);
    glbk__ism_free_sheets(ctx, s->effect_totals, 3);
    glbk__ism_free_sheets(ctx, &s->shares, 1);
    glbk__ism_free_sheets(ctx, s->share_sums, 3);
    s->triangle_count = 0;
}

/* Makes the pictures of clusters and the target that draws them together. */
static void glbk__ism_make_clusters(glbk__ism_making *k, glbk_ism_spread *s)
{
    const uint32_t count = s->cluster_count;
    const uint32_t width = count < 1024 ? count : 1024, height = (count + 1023) / 1024;
    glbk__ism_make_layers(k, GLBK_FORMAT_RG32UI, width, height, 0, &s->masses.texture);
    glbk__ism_make_layers(k, GLBK_FORMAT_RGBA32UI, width, height, 3, &s->clusters);
    glbk__ism_make_target(k, &s->masses.texture, &s->clusters, 3, &s->masses.target);
}

/* Makes what holds the shares of a batch of VPLs; without pairs of VPL and cluster all VPLs have the same. */
static void glbk__ism_make_shares(glbk__ism_making *k, const glbk_ism_maps *m, glbk_ism_spread *s)
{
    const int pair = glbk__ism_by_pair(&m->desc);
    const uint32_t count = s->cluster_count, height = (count + 1023) / 1024, most = 2048 / height;
    uint32_t batch = (uint32_t)GLBK__ISM_BATCH / count, rows;
    if (batch > most) batch = most;
    if (batch > m->desc.vpl_count) batch = m->desc.vpl_count;
    rows = pair ? batch : 1;
    s->batch = pair ? batch : m->desc.vpl_count;
    if (pair) {
        glbk__ism_make_fold(k, GLBK_FORMAT_R32UI, count, rows, &s->effects);
        glbk__ism_make_levels(k, count, rows, 0, s->effect_totals, 3);
    }
    glbk__ism_make_fold(k, GLBK_FORMAT_R32UI, count, rows, &s->shares);
    glbk__ism_make_levels(k, count, rows, 1, s->share_sums, 3);
}

/* Makes room for the triangles of a mesh, if it has not as many as the last one. */
static glbk_result glbk__ism_hold_triangles(glbk_context *ctx, const glbk_ism_maps *m, glbk_ism_spread *s)
{
    const uint32_t count = m->triangle_count;
    glbk__ism_making k = glbk__ism_begin_making(ctx);
    if (s->triangle_count == count) return GLBK_OK;
    glbk__ism_free_triangles(ctx, s);
    s->triangles_per_cluster = count / (uint32_t)GLBK__ISM_CLUSTERS + 1;
    s->cluster_count = (count + s->triangles_per_cluster - 1) / s->triangles_per_cluster;
    glbk__ism_make_fold(&k, GLBK_FORMAT_RG32UI, count, 1, &s->sizes);
    glbk__ism_make_clusters(&k, s);
    glbk__ism_make_levels(&k, s->cluster_count, 1, 0, s->totals, 3);
    glbk__ism_make_shares(&k, m, s);
    if (k.result == GLBK_OK) s->triangle_count = count;
    else glbk__ism_free_triangles(ctx, s);
    return k.result;
}

/* What a frame is scattered with. After the first error nothing is drawn. */
typedef struct glbk__ism_spreading {
    glbk_context       *ctx;
    glbk_ism_maps      *maps;
    glbk_ism_spread    *spread;
    glbk_ism_scattering block;      /* the values of the uniform block */
    uint32_t            fewer;      /* not 0: triangles are gone, and other phases' surfels stay */
    glbk_result         result;     /* of all passes so far */
} glbk__ism_spreading;

/* Begins a pass by a program, with the block as it is. */
static void glbk__ism_begin(glbk__ism_spreading *j, const glbk_pass *pass, int program)
{
    if (j->result == GLBK_OK) j->result = glbk_begin(j->ctx, pass, &j->spread->programs[program]);
    if (j->result == GLBK_OK)
        j->result = glbk__put_block(j->ctx, GLBK_SLOT_glbk_ism_scattering, &j->spread->block, &j->block);
}

/* Begins a pass that draws a sheet by a program, which reads what is bound next. */
static void glbk__ism_begin_sheet(glbk__ism_spreading *j, const glbk_ism_sheet *sheet, int program)
{
    glbk_pass pass;
    memset(&pass, 0, sizeof pass);
    pass.target = &sheet->target;
    glbk__ism_begin(j, &pass, program);
}

static void glbk__ism_finish_sheet(const glbk__ism_spreading *j)
{
    if (j->result == GLBK_OK) glbk_draw_screen(j->ctx);
}

static void glbk__ism_bind_sheet(const glbk__ism_spreading *j, uint32_t slot, const glbk_ism_sheet *sheet)
{
    glbk_bind_texture(j->ctx, slot, &sheet->texture);
}

/* Binds successive levels of sums to successive slots. */
static void glbk__ism_bind_sums(const glbk__ism_spreading *j, uint32_t slot, const glbk_ism_sheet *sums,
                                uint32_t count)
{
    uint32_t k;
    for (k = 0; k < count; k++) glbk__ism_bind_sheet(j, slot + k, &sums[k]);
}

/* Sums up sequences of `count` values, level by level: running sums, or only those of blocks. */
static void glbk__ism_sum(glbk__ism_spreading *j, const glbk_ism_sheet *values, uint32_t count, int running,
                          const glbk_ism_sheet *sums, uint32_t levels)
{
    glbk_ism_scattering *b = &j->block;
    uint32_t k;
    b->value_count = count;
    b->pace = running != 0;
    for (k = 0; k < levels; k++) {
        glbk__ism_begin_sheet(j, &sums[k], GLBK__ISM_RUN);
        glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_values, values);
        glbk__ism_finish_sheet(j);
        values = &sums[k];
        if (k || !running) b->value_count = glbk__ism_blocks(b->value_count);
        if (running) b->pace = 32;
    }
}

/* Lists the receivers of the picture, whose G-buffer the caller has checked. */
static void glbk__ism_list_receivers(glbk__ism_spreading *j, const glbk_gbuffer *seen)
{
    glbk_ism_spread *s = j->spread;
    glbk__ism_begin_sheet(j, &s->seen, GLBK__ISM_SEE);
    (void)glbk_gbuffer_bind(j->ctx, seen, NULL);
    glbk__ism_finish_sheet(j);
    glbk__ism_sum(j, &s->seen, seen->width * seen->height, 1, s->seen_sums, 5);
    glbk__ism_begin_sheet(j, &s->receivers, GLBK__ISM_LIST);
    (void)glbk_gbuffer_bind(j->ctx, seen, NULL);
    glbk__ism_bind_sums(j, GLBK_SLOT_glbk_ism_runs0, s->seen_sums, 4);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_runs4, &s->seen_sums[4]);
    glbk__ism_finish_sheet(j);
}

/* Measures triangles, and clusters of them. */
static void glbk__ism_measure(glbk__ism_spreading *j)
{
    glbk_ism_spread *s = j->spread;
    glbk__ism_begin_sheet(j, &s->sizes, GLBK__ISM_MEASURE);
    glbk_bind_texture(j->ctx, GLBK_SLOT_glbk_ism_triangles, &j->maps->triangle_table);
    glbk_bind_texture(j->ctx, GLBK_SLOT_glbk_ism_positions, &j->maps->positions);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_receivers, &s->receivers);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_runs4, &s->seen_sums[4]);
    glbk__ism_finish_sheet(j);
    glbk__ism_begin_sheet(j, &s->masses, GLBK__ISM_GATHER);     /* reads triangles and positions, too */
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_sizes, &s->sizes);
    glbk__ism_finish_sheet(j);
    glbk__ism_sum(j, &s->masses, s->cluster_count, 0, s->totals, 3);
}

/* Draws the effects of clusters on the VPLs of a batch, and their sums. */
static void glbk__ism_weigh_pairs(glbk__ism_spreading *j)
{
    glbk_ism_spread *s = j->spread;
    glbk__ism_begin_sheet(j, &s->effects, GLBK__ISM_PAIRS);
    glbk_bind_texture(j->ctx, GLBK_SLOT_glbk_ism_vpls, &j->maps->vpls);
    glbk_bind_block(j->ctx, GLBK_SLOT_glbk_ism_frame, &j->maps->frame);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_masses, &s->masses);
    glbk_bind_texture(j->ctx, GLBK_SLOT_glbk_ism_clusters, &s->clusters);
    glbk__ism_finish_sheet(j);
    glbk__ism_sum(j, &s->effects, s->cluster_count, 0, s->effect_totals, 3);
}

/* Draws the shares that clusters have of the surfels of a batch, and their running sums. */
static void glbk__ism_share(glbk__ism_spreading *j)
{
    glbk_ism_spread *s = j->spread;
    if (j->block.pair) glbk__ism_weigh_pairs(j);
    glbk__ism_begin_sheet(j, &s->shares, GLBK__ISM_SHARE);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_masses, &s->masses);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_totals, &s->totals[2]);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_values, &s->effects);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_effect_totals, &s->effect_totals[2]);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_runs4, &s->seen_sums[4]);
    glbk__ism_finish_sheet(j);
    glbk__ism_sum(j, &s->shares, s->cluster_count, 1, s->share_sums, 3);
}

/* Binds what surfels are drawn from. */
static void glbk__ism_bind_shares(const glbk__ism_spreading *j)
{
    const glbk_ism_spread *s = j->spread;
    glbk__ism_bind_sums(j, GLBK_SLOT_glbk_ism_runs0, s->share_sums, 3);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_shares, &s->shares);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_totals, &s->totals[2]);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_counts, &s->counts);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_masses, &s->masses);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_sizes, &s->sizes);
}

/* Finds which surfels in the rows of a layer of their table that a pass draws next have triangles that are
   gone. Other rows stay untouched: with many batches they are most, and the table may end before them. */
static void glbk__ism_find_gone(glbk__ism_spreading *j, const glbk_texture *table, const glbk_pass *next)
{
    glbk_pass pass = *next;
    pass.target = &j->spread->gone.target;
    glbk__ism_begin(j, &pass, GLBK__ISM_GONE);
    glbk_bind_texture(j->ctx, GLBK_SLOT_glbk_ism_surfels, table);
    glbk__ism_finish_sheet(j);
}

/* Draws the surfels of a phase and of a batch of VPLs, into the rows of the table's layers that hold them. If
   triangles are gone, those of a phase whose turn it is not stay, if their triangles are there. */
static void glbk__ism_draw_surfels(glbk__ism_spreading *j, uint32_t phase)
{
    const glbk_ism_maps *m = j->maps;
    glbk_ism_spread *s = j->spread;
    glbk_ism_scattering *b = &j->block;
    const uint32_t layer_size = GLBK__ISM_LAYER, each = m->phase_surfel_count;
    const uint32_t base = m->compute ? phase * each * m->desc.vpl_count : 0;
    const uint32_t begin = base + b->first_vpl * each, end = begin + b->batch * each;
    const glbk_texture *table = m->compute ? &m->surfels : &m->phase_surfels[phase];
    glbk_pass pass;
    uint32_t layer;
    memset(&pass, 0, sizeof pass);
    pass.target = &s->surfel_target;
    for (layer = begin / layer_size; layer * layer_size < end; layer++) {
        const uint32_t start = layer * layer_size, low = begin > start ? begin - start : 0;
        const uint32_t high = end - start < layer_size ? end - start : layer_size;
        pass.viewport[1] = (int32_t)(low / 1024);
        pass.viewport[2] = 1024;
        pass.viewport[3] = (int32_t)((high + 1023) / 1024 - low / 1024);
        b->phase = phase;
        b->first_texel = start - base;
        b->layer = layer;
        b->keep = j->fewer && phase != b->frame % b->lazy_frames;
        if (b->keep) glbk__ism_find_gone(j, table, &pass);
        glbk__ism_begin(j, &pass, GLBK__ISM_SCATTER);
        if (j->result != GLBK_OK) return;
        j->ctx->gl.FramebufferTextureLayer(GLBK_GL_DRAW_FRAMEBUFFER, GLBK_GL_COLOR_ATTACHMENT0, table->name,
                                           0, (int32_t)layer);
        glbk__ism_bind_shares(j);
        glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_gone, &s->gone);
        glbk_draw_screen(j->ctx);
    }
}

/* Sets the values of the block that all passes of a frame have in common. */
static void glbk__ism_set_block(glbk__ism_spreading *j, uint32_t index)
{
    const glbk_ism_maps *m = j->maps;
    const glbk_ism_spread *s = j->spread;
    const ism_desc *d = &m->desc;
    glbk_ism_scattering *b = &j->block;
    memset(b, 0, sizeof *b);
    b->triangle_count = s->triangle_count;
    b->cluster_count = s->cluster_count;
    b->cluster_size = s->triangles_per_cluster;
    b->batch = s->batch;
    b->view_width = s->width;
    b->view_height = s->height;
    b->views = glbk__ism_views(d);
    b->pair = glbk__ism_by_pair(d) != 0;
    b->seed = d->seed;
    b->frame = index;
    b->key = d->unstable ? glbk_ism__hash_combine(d->seed, index) : d->seed;
    b->surfel_count = d->surfel_count;
    b->phase_surfel_count = m->phase_surfel_count;
    b->lazy_frames = d->lazy_frames;
    b->vpl_capacity = d->vpl_count;
    b->vary_surfels = d->vary_surfels != 0;
    b->area_share = d->area_share > 0 ? d->area_share : 0.2f;
}

/* Draws how many surfels VPLs have, and then batch by batch shares and surfels. */
static void glbk__ism_scatter_all(glbk__ism_spreading *j, uint32_t first, uint32_t end)
{
    const uint32_t count = j->maps->desc.vpl_count, batch = j->spread->batch;
    uint32_t vpl, phase;
    glbk__ism_begin_sheet(j, &j->spread->counts, GLBK__ISM_COUNT);
    glbk_bind_texture(j->ctx, GLBK_SLOT_glbk_ism_vpls, &j->maps->vpls);
    glbk_bind_block(j->ctx, GLBK_SLOT_glbk_ism_frame, &j->maps->frame);
    glbk__ism_finish_sheet(j);
    for (vpl = 0; vpl < count && j->result == GLBK_OK; vpl += batch) {
        j->block.first_vpl = vpl;
        j->block.batch = count - vpl < batch ? count - vpl : batch;
        glbk__ism_share(j);
        for (phase = first; phase < end; phase++) glbk__ism_draw_surfels(j, phase);
    }
}

/* Checks the arguments of glbk_ism_scatter. */
static glbk_result glbk__ism_check_scatter(const glbk_context *ctx, const char *function,
                                           const glbk_ism_spread *s, const glbk_ism_maps *m,
                                           const glbk_gbuffer *seen)
{
    glbk_result result = glbk__require_created(ctx, function, "spread", s ? &s->block.name : NULL);
    if (result == GLBK_OK) result = glbk__ism_check_maps(ctx, function, m);
    if (result != GLBK_OK) return result;
    if (m->vpls.name != s->table)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, "maps",
                            "are not those that the spread was made for");
    if (m->masked)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, "the mesh of maps",
                            "has a mask, whose holes only ism_scatter knows");
    if (!glbk__ism_views(&m->desc)) return GLBK_OK;
    return glbk__require_created(ctx, function, "seen", seen ? &seen->colors.name : NULL);
}

GLBK_DEF glbk_result glbk_ism_scatter(glbk_context *ctx, glbk_ism_spread *s, glbk_ism_maps *m,
                                      const glbk_gbuffer *seen, uint32_t index)
{
    glbk__ism_spreading j;
    uint32_t k, first, end;
    int all;
    j.result = glbk__ism_check_scatter(ctx, __func__, s, m, seen);
    if (j.result != GLBK_OK || !m->triangle_count) return j.result;
    all = m->desc.unstable || m->desc.vary_surfels;
    for (k = 0; k < m->desc.lazy_frames; k++) all = all || !(m->phases >> k & 1);
    j.fewer = !all && m->fewer;
    first = all || j.fewer ? 0 : index % m->desc.lazy_frames;
    end = all || j.fewer ? m->desc.lazy_frames : first + 1;
    j.result = glbk__ism_hold_triangles(ctx, m, s);
    if (j.result == GLBK_OK && glbk__ism_views(&m->desc)) j.result = glbk__ism_hold_view(ctx, s, seen);
    if (j.result != GLBK_OK) return j.result;
    j.ctx = ctx;
    j.maps = m;
    j.spread = s;
    glbk__ism_set_block(&j, index);
    if (j.block.views) glbk__ism_list_receivers(&j, seen);
    glbk__ism_measure(&j);
    glbk__ism_scatter_all(&j, first, end);
    if (j.result != GLBK_OK) return j.result;
    for (k = first; k < end; k++) m->phases |= (uint64_t)1 << k;
    m->fewer = 0;
    return GLBK_OK;
}

GLBK_DEF void glbk_ism_spread_free(glbk_context *ctx, glbk_ism_spread *s)
{
    uint32_t k;
    if (!s) return;
    for (k = 0; k < GLBK__ISM_SPREAD_PROGRAMS; k++) glbk_program_free(ctx, &s->programs[k]);
    glbk__ism_free_view(ctx, s);
    glbk__ism_free_triangles(ctx, s);
    glbk__ism_free_sheets(ctx, &s->counts, 1);
    glbk__ism_free_sheets(ctx, &s->gone, 1);
    glbk_target_free(ctx, &s->surfel_target);
    glbk_buffer_free(ctx, &s->block);
    memset(s, 0, sizeof *s);
}

/* ==== src/gl_ism/bounce.h ==== */

/* ---- ism: the next bounce on the GPU ---- */

/* Checks the arguments of glbk_ism_bounces_create. */
static glbk_result glbk__ism_check_bounces(const glbk_context *ctx, const char *function,
                                           const glbk_ism_maps *m, uint32_t side)
{
    const glbk_result result = glbk__ism_check_maps(ctx, function, m);
    double texels = side;
    if (result != GLBK_OK) return result;
    if (!side || !glbk__ism_power_of_two(side) || side > m->desc.tile_side)
        return glbk__refuse_value(ctx, GLBK_ERR_ARGUMENT, function, "side", side,
                                  "a power of two, desc.tile_side at most");
    if (!m->desc.keep_hits)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, "maps", "have no desc.keep_hits");
    texels *= texels;
    if (texels < m->desc.vpl_count) texels = m->desc.vpl_count;
    if (texels <= ctx->max_side) return GLBK_OK;
    return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "side x side, or vpl_count,", texels, 1,
                              ctx->max_side);
}

GLBK_DEF glbk_result glbk_ism_bounces_create(glbk_context *ctx, const glbk_ism_maps *m, uint32_t side,
                                             glbk_ism_bounces *out)
{
    char defines[] = "ISM_PROJECTION=1";
    glbk__ism_making k;
    glbk_result result;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!out) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "out", "is NULL");
    memset(out, 0, sizeof *out);
    result = glbk__ism_check_bounces(ctx, __func__, m, side);
    if (result != GLBK_OK) return result;
    defines[15] = (char)('0' + (int)m->desc.projection);
    out->table = m->vpls.name;
    out->side = side;
    k = glbk__ism_begin_making(ctx);
    k.defines = defines;
    glbk__ism_make_layers(&k, GLBK_FORMAT_RGBA32UI, side * side, m->desc.vpl_count, 3, &out->texels);
    glbk__ism_make_target(&k, NULL, &out->texels, 3, &out->target);
    glbk__ism_make_program(&k, "ism_bounce.frag", &out->program);
    if (k.result != GLBK_OK) glbk_ism_bounces_free(ctx, out);
    return k.result;
}

GLBK_DEF glbk_result glbk_ism_bounce(glbk_context *ctx, glbk_ism_bounces *b, const glbk_ism_maps *m)
{
    glbk_ism_frame f;
    glbk_pass pass;
    glbk_result result;
    uint32_t i;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__require_created(ctx, __func__, "bounces", b ? &b->texels.name : NULL);
    if (result == GLBK_OK) result = glbk__ism_check_maps(ctx, __func__, m);
    if (result != GLBK_OK) return result;
    if (m->vpls.name != b->table)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "maps",
                            "are not those that the bounces were made for");
    if (!m->drawn || m->outdated)           /* texels would name triangles that are gone */
        return glbk__refuse(ctx, GLBK_ERR_ORDER, __func__, "maps", "must be drawn first: glbk_ism_draw");
    f = glbk__ism_frame_of(m);
    f.bounce_side = b->side;
    memset(&pass, 0, sizeof pass);
    pass.target = &b->target;
    result = glbk_begin(ctx, &pass, &b->program);
    if (result == GLBK_OK) result = glbk__put_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame, &f);
    if (result != GLBK_OK) return result;
    glbk__ism_bind_planes(ctx, m);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_below, &m->kept);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_atlas, &m->atlas);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_hits, &m->hits);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_albedos, &m->albedos);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_triangles, &m->triangle_table);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_positions, &m->positions);
    for (i = 0; i < GLBK_ISM_LEVELS; i++)
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_pull1 + i, &m->pull[i]);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF void glbk_ism_bounces_free(glbk_context *ctx, glbk_ism_bounces *b)
{
    if (!b) return;
    glbk_target_free(ctx, &b->target);
    glbk_texture_free(ctx, &b->texels);
    glbk_program_free(ctx, &b->program);
    memset(b, 0, sizeof *b);
}

/* ==== src/gl_ism/end.h ==== */

#endif /* GL_ISM_IMPLEMENTATION */

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
