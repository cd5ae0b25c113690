/* rsm.h - v1.0.0 - reflective shadow maps: one bounce of light from a shadow map - MIT-0 OR Unlicense

   What it does

   A shadow map that stores position, normal and reflected flux knows every surface from which light can come
   after one bounce. This header fills such maps from your renderer's buffers or from triangles, takes their
   texels as small lights, and gathers the light of these at points: at pixels, with or without interpolation,
   or at vertices. After Dachsbacher and Stamminger, "Reflective Shadow Maps", I3D 2005. Flux, weights and
   units are exact where the paper's are not; docs/rsm.md says where.

   What it does not do

   - Nothing stands in the way of bounced light by itself: surfaces behind others are lit too, as in the
     paper. What a point sees of each light is asked of a function (visible_fn), such as ism.h and csm.h have,
     or of yours; the share of all light that reaches a point (ambient occlusion) is taken as input, too.
   - Light bounces once. The header renders no pictures, starts no threads and opens no files.

   Quick start

   In exactly one source file write the define; everywhere else include the header alone.

       #define RSM_IMPLEMENTATION
       #include "rsm.h"
       #include <stdio.h>

       int main(void)
       {
           static const float corners[] = { -1, 0, -1,  1, 0, -1,  1, 0, 1,  -1, 0, 1 };   // a floor
           static const uint32_t triangles[] = { 0, 2, 1,  0, 3, 2 };
           const float above[3] = { 0, 1, 0 }, down[3] = { 0, -1, 0 };
           static rsm_desc desc;                            // static: all zero, the defaults
           static rsm_mesh mesh;
           static rsm_points points;
           rsm_map *map;
           float e[3];

           desc.light.direction[1] = 1;                     // the sun stands above
           desc.light.value[0] = desc.light.value[1] = desc.light.value[2] = 1;
           desc.light.radius = 1;                           // and its map covers the floor
           mesh.positions = corners;
           mesh.vertex_count = 4;
           mesh.indices = triangles;
           mesh.index_count = 6;
           mesh.albedo[0] = mesh.albedo[1] = mesh.albedo[2] = 0.5f;
           if (rsm_map_create(&desc, &map) != RSM_OK) return 1;
           if (rsm_rasterize(map, &mesh, 1) != RSM_OK || rsm_finish(map, NULL) != RSM_OK) return 1;
           points.count = 1;
           points.positions = above;
           points.normals = down;
           if (rsm_gather((const rsm_map *const *)&map, 1, NULL, &points, e, NULL) != RSM_OK) return 1;
           printf("irradiance from the floor: %.3f, exact 0.277\n", (double)e[0]);
           rsm_map_free(map);
           return !(e[0] > 0.27f && e[0] < 0.285f);
       }

   Conventions

   Space is right-handed. Matrices are column-major float[16]. Distances are in your units, angles in radians,
   irradiance in W/m^2, intensity in W/sr, flux in W. Colours are linear, three floats r, g, b. A vector that
   is called unit may have a length from 0.97 to 1.03 and is used as it is; any other length is an error, and
   the log names the element.

     map        what one light sees: 1 face, 5 faces of a cube (of a patch), or 6 (of a point)
     texel      one pixel of a face. Texels lie row by row, row 0 at the bottom (v = 0)
     light      a pixel light is a texel that shines: flux leaves the texel about its normal as from a diffuse
                surface, with the intensity flux / pi x cosine
     receiver   a point that is lit by pixel lights. Results are irradiances: multiply by albedo / pi
     pattern    which texels a receiver takes as samples: those about its own projection into the map, or
                texels chosen by flux

   How it works

     rsm_map_create -> rsm_fill (your buffers) or rsm_rasterize (triangles), each face -> rsm_finish
       -> rsm_direct         direct light of receivers by the same map
       -> rsm_gather         bounced light of any receivers
       -> rsm_interpolate    the same for a picture: light at a coarse grid of pixels, mostly interpolated
       -> rsm_pixel_lights, rsm_cluster -> rsm_gather_list: a list of lights for all receivers

   rsm_redraw does the first line for the next frame, and keeps the map if light and meshes are what they
   were. gifilter.h makes pictures from few samples smooth, over frames and over neighbours.

   A map takes 56 bytes a texel (48 of them are rsm_texel), a list 48 bytes a light, a gather 60 bytes a light
   in scratch (88 with materials), interpolation 11 bytes a pixel. The knobs, and what each trades:

     sample_count
                fewer: faster, with bands (lists and patterns that are not turned) or noise (noise,
                interleave), and bright dots where surfaces meet. 0, the default, takes every texel
     pattern    FLUX is fastest; MIXED has the least error where light near a corner matters
     offset     more: corners have fewer bright dots, and are darker than they should be
     near_limit less: the same, by a bound on each light; the light that is lost is counted
     near_field more: near texels are surfaces, not points, so that corners have no dots; nothing to a third
                more time
     side       fewer texels: blurred lights, and more dots in corners

   From the paper to the code

     section 3.1  what a texel stores                      rsm_texel, rsm_map_texels            T34 T35
     section 3.1  the intensity of a texel (figure 2)      rsm_gather_list                      T29
     eq. (1)      irradiance from one texel, over pi here  rsm_gather, rsm_gather_list          T25 T28 T40
     section 3.2  flux through a texel, times albedo       rsm_rasterize, rsm_fill, rsm_finish  T30 T31 T33
     section 3.2  lights move below their surface          rsm_gather_desc (offset)             T38
     eq. (2)      the sum over texels                      rsm_gather                           T32 T42 T44
     section 3.3  bounced light without shadows, or with    rsm_gather_desc (visible_fn)         -
     section 3.3  a receiver's projection into the map     rsm_map_project                      T34
     eq. (3)      samples about the projection             rsm_pattern_build, rsm_pattern       T26 T27 T36
     section 3.3  samples weighted by xi^2, normalised     rsm_gather_desc (paper_weights)      T26
     section 3.3  a Poisson pattern                        rsm_pattern (POISSON)                T25 T26 T36
     figure 4     the pattern and its weights              rsm_pattern_build                    T26
     section 4    interpolation where samples look alike   rsm_interpolate                      T39
     figure 5     which pixels are not interpolated        rsm_interpolate                      T39
     section 4    direct light by the same map             rsm_direct                           T29
     section 5    deferred shading, in passes              in gl_backend/gl_rsm.h               -
     table 1      how many samples are taken (figure 7)    rsm_gather_desc (sample_count)       T25 T27
     section 6    textures are averaged over a texel       rsm_mesh (tap_side)                  -
     figure 6     ambient occlusion as a factor            rsm_points (open)                    -
     section 7    light gathered at vertices               rsm_gather                           T25
     section 7    lamps all round, and area lights         rsm_light_kind                       T30 T37
     section 7    reflectors that are not diffuse          rsm_material                         -

   The last column names the rows of docs/conformance.md that test a line; a - says that there is none. These
   lines are held to sums by hand in tests/rsm (the_callback_gets_the_taps_of_a_texel,
   every_pattern_sums_its_samples).

   docs/rsm.md says where the code departs from the paper, and why.

   Configuration

     RSM_IMPLEMENTATION   in one source file: compiles the code
     RSM_STATIC           beside it: a private copy for this file, all functions static
     RSM_DEF              everywhere: your own linkage instead
     RSM_NO_SIMD          with the implementation: portable code only (results are the same to the bit)
     RSM_FILE             with the implementation: this file's name, if it is not "rsm.h". The file includes
                          itself for AVX2 and AVX-512; where it cannot, it does without them

   Memory, errors, threads, determinism

   All memory comes from the allocator of the rsm_system, called from the thread that called us. Every
   function that can fail returns an rsm_result. If the result is not RSM_OK, outputs are untouched (unless a
   contract says otherwise), nothing leaks, and the system's log is told which field or element is wrong.
   There are no globals: any number of threads may use finished maps at once; a map that is being filled
   belongs to one thread at a time. The same input gives the same bytes on every compiler, processor, byte
   order and thread count (not with x87 arithmetic, nor with clang's -ffast-math).

   Cost: docs/rsm.md and build/bench rsm_gather.   History: CHANGELOG.md.   Licence: end of this file. */
#ifndef RSM_H
#define RSM_H

#define RSM_VERSION 10000 /* major * 10000 + minor * 100 + patch */

#if !defined(__cplusplus) && !defined(_MSC_VER) && (!defined(__STDC_VERSION__) || __STDC_VERSION__ < 199901L)
#error "rsm.h needs C99 or C++11"
#endif
#if defined(RSM_STATIC) && !defined(RSM_IMPLEMENTATION)
#error "RSM_STATIC makes all functions private: RSM_IMPLEMENTATION belongs into the same file"
#endif

#include <stddef.h>
#include <stdint.h>

#ifndef RSM_DEF
#ifdef RSM_STATIC
#define RSM_DEF static inline
#else
#define RSM_DEF extern
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif
