/* rsm.h - v1.0.0 - reflective shadow maps: one bounce of light from the texels of a shadow map - MIT-0 OR Unlicense

   What it does

   A shadow map that stores position, normal and reflected flux knows every surface that one bounce of its
   light can come from. After Dachsbacher and Stamminger, "Reflective Shadow Maps", I3D 2005: this header
   fills such maps from your renderer's buffers or from triangles, picks pixel lights from them, and gathers
   their light at points, per pixel with interpolation, or per vertex. Flux, weights and units are exact where
   the paper was not; docs/rsm.md says where.

   What it does not do

   - Nothing stands in the way of bounced light: surfaces behind others are lit too, as in the paper. An
     occlusion factor for each point (ambient occlusion) is taken as input; ism.h has real shadows.
   - One bounce only. No rendering of pictures, no threads of its own, no file access.

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

   Right-handed; matrices are column-major float[16]; distances in your units, angles in radians. Irradiance
   W/m^2, intensity W/sr, flux W. Linear colours: three floats.

     map        what one light sees: 1 face, or the faces of a cube: 5 about a patch's normal, 6 about a point
     texel      one pixel of a face, row by row, row 0 at the bottom (v = 0); also a pixel light: flux leaves
                it along its normal as from a diffuse surface, I = flux / pi cos
     receiver   a point that is lit by pixel lights; irradiance is written, so multiply by albedo / pi
     pattern    where a receiver takes its samples: texels about its own projection, or texels chosen by flux

   How it works

     rsm_map_create -> rsm_fill (your buffers) or rsm_rasterize (triangles), each face -> rsm_finish
       -> rsm_direct         direct light of receivers by the same map
       -> rsm_gather         bounced light of any receivers
       -> rsm_interpolate    the same for a picture: a coarse grid, refined where it does not do
       -> rsm_pixel_lights, rsm_cluster -> rsm_gather_list: one list of lights for all

   gifilter.h makes pictures from few samples smooth, over frames and over neighbours.

   A map takes 56 bytes a texel (48 of them rsm_texel), a list of lights 48 bytes each, a gather 60 bytes a
   light in scratch (88 with materials), interpolation 11 bytes a pixel. The knobs, and what each trades:

     samples    fewer: banding (list and unrotated patterns) or noise (noise, interleave), and bright dots
                where surfaces meet; 0, the default, takes every texel
     pattern    FLUX is fastest; MIXED has the least error where the light near a corner matters
     offset     pixel lights move below their surface: tames corners, darkens them too
     near_limit the same by a bound on each light; what is lost is counted
     near_field near texels are surfaces, not points: corners without spots, a tenth to a quarter more time
     side       fewer texels: blurred sources, spotted corners

   From the paper to the code

     section 3.1  what a texel stores                      rsm_texel, rsm_map_texels            T34, T35
     eq. (1)      irradiance from one texel, over pi here  rsm_gather, rsm_gather_list          T25, T28, T40
     section 3.2  flux through a texel, times albedo       rsm_rasterize, rsm_fill, rsm_finish  T30, T31, T33
     section 3.2  lights move below their surface          rsm_gather_desc                      T38
     eq. (2)      the sum over texels                      rsm_gather                           T32, T42, T44
     eq. (3)      samples about the projection             rsm_pattern_build, rsm_pattern       T26, T27, T36
     figure 4     their weights                            rsm_pattern_build                    T26
     section 4    interpolation where samples look alike   rsm_interpolate                      T39
     section 5    direct light by the same map             rsm_direct                           T29
     section 5    textures are averaged over a texel       rsm_mesh
     section 7    lamps all round, and area lights         rsm_light_kind                       T37, T43
     section 7    reflectors that are not diffuse          rsm_material

   docs/rsm.md says where the code departs from the paper, and why.

   Configuration

     RSM_IMPLEMENTATION   in one source file: compiles the code
     RSM_STATIC           beside it: a private copy for this file, all functions static
     RSM_DEF              everywhere: your own linkage instead
     RSM_NO_SIMD          with the implementation: portable code only (results are the same to the bit)
     RSM_FILE             with the implementation: this file's name, if it is not "rsm.h". The file includes
                          itself for AVX2 and AVX-512; where it cannot, it does without them

   Memory, errors, threads, determinism

   All memory comes from the allocator of the rsm_system, called from the thread that called us. Every function that
   can fail returns an rsm_result; where it is not RSM_OK, outputs are untouched (where a contract does not
   say otherwise) and nothing leaks. No globals: finished maps may be used from any number of threads; a map
   being filled belongs to one at a time. Same input, same bytes, on every compiler, processor, byte order and
   thread count (not with x87 arithmetic, nor with clang's -ffast-math).

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
