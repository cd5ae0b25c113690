/* ism.h - v0.9.0 - imperfect, view-adaptive shadow maps: bounced light with its shadows - MIT-0 OR Unlicense

   What it does

   This header computes bounced light with its shadows. It chooses a thousand virtual point lights (VPLs)
   among lit surface points (the texels of a reflective shadow map, points on lamps, directions of a sky),
   gives each a small hemispherical depth map, drawn from a few thousand surfels scattered over all triangles,
   and lights pixels or any list of points by them. After Ritschel, Eisemann, Ha, Kim and Seidel, "Making
   Imperfect Shadow Maps View-Adaptive", Computer Graphics Forum 30(8), 2011: VPLs are chosen by what they do
   to the picture, and surfels are dense where they shadow what the picture shows. Scene, light and camera may
   all change from frame to frame.

   What it does not do

   - You render direct light and reflective shadow maps, and hand over plain arrays.
   - Each VPL's depth map is coarse (64 x 64 texels from 8,192 surfels): single indirect shadows are blurred
     and leak; the sum over a thousand VPLs is what counts. docs/ism.md has pictures, docs/measured/ism.md
     figures.
   - Surfaces that receive light are diffuse; VPLs are diffuse or cosine-power lobes.
   - The header opens no files and starts no threads.

   Quick start

   In exactly one source file write the define; everywhere else include the header alone.

       #define ISM_IMPLEMENTATION
       #include "ism.h"
       #include <stdio.h>
       #include <string.h>

       int main(void)
       {
           // a lit floor texel of 1 m^2 (flux = albedo x irradiance x area), and two receivers under the
           // ceiling, one of them above a table top
           static const float corners[] = { 1, 1, -1,  3, 1, -1,  3, 1, 1,  1, 1, 1 };
           static const uint32_t triangles[] = { 0, 2, 1,  0, 3, 2 };
           const float at[3] = { 0, 0, 0 }, up[3] = { 0, 1, 0 }, flux[3] = { 1.5f, 1.5f, 1.5f };
           const float positions[6] = { -4, 2, 0,  4, 2, 0 }, down[6] = { 0, -1, 0,  0, -1, 0 };
           ism_desc desc;
           ism_mesh mesh;
           ism_source source;
           ism_points points;
           ism_frame frame;
           float light[6];
           ism_maps *maps;

           memset(&desc, 0, sizeof desc);
           memset(&mesh, 0, sizeof mesh);
           memset(&source, 0, sizeof source);
           memset(&points, 0, sizeof points);
           memset(&frame, 0, sizeof frame);
           desc.vpl_count = 1;
           mesh.positions = corners;
           mesh.vertex_count = 4;
           mesh.indices = triangles;
           mesh.index_count = 6;
           source.width = source.height = 1;
           source.positions = at;
           source.normals = up;
           source.fluxes = flux;
           points.count = 2;
           points.positions = positions;
           points.normals = down;
           frame.mesh = &mesh;
           frame.sources = &source;
           frame.source_count = 1;
           frame.points = &points;
           if (ism_create(&desc, &maps) != ISM_OK) return 1;
           if (ism_render(maps, &frame, NULL, light, NULL) != ISM_OK) return 1;
           printf("open side %g W/m^2, behind the table top %g\n", (double)light[0], (double)light[3]);
           ism_free(maps);
           return !(light[0] > 0.0f && light[3] == 0.0f);
       }

   Conventions

   Space is right-handed. Matrices are column-major float[16]. Directions point from the surface to the light.
   Vectors called unit may be 0.97 to 1.03 long and are used as they are. Distances are in your units (m
   below), angles in radians, radiance in W/(sr m^2), irradiance in W/m^2, flux in W.

     pVPL       a texel of a source, which might become a light: position, normal, reflected flux
     BRSM       bidirectional reflective shadow map: the importances of a source's texels, flux times effect
                on the picture (ism_importance says which effect)
     VPL        a pVPL that was chosen, its flux divided by N and by the probability of the choice
     tile       the depth map of one VPL: tile_side^2 texels of the hemisphere about its normal; the atlas has
                all of them
     surfel     a point of a triangle as an occluder: a disc of the area that the point stands for
     receiver   a point that is lit: a pixel of the view, or an element of any list
     near point a light of a second, finer choice, which takes the place of VPLs that are close to a receiver

   How it works

     sources -> importance -> prefix sums -> VPLs            ism_choose
     mesh    -> solid angles -> prefix sums -> surfels       ism_build (ism_scatter alone makes no maps)
     surfels -> discs in tiles -> pull and push -> atlas     ism_build
     VPLs, atlas, receivers -> light -> blur                 ism_shade

       atlas: ceil(sqrt(N)) tiles a side       tile: the square holds the hemisphere
       +----+----+----+----+                   +---------+  a disc of the unit hemisphere seen from above
       | v0 | v1 | v2 | v3 |                   |  ,---.  |  (COSINE), stretched to fill the square (Shirley
       +----+----+----+----+                   | ( axis) |  and Chiu's concentric map): every texel has the
       | v4 | v5 | ...                         |  `---'  |  same share of the light that leaves a diffuse VPL
       +----+----                              +---------+

   A tile shows the square unevenly: the window, that part of the square in which the picture lies, has all
   texels of the tile but 8 of 64 a side (ism_zoom). Each surfel belongs to one VPL.

   From the paper to the code

     section 3.2          importance by flux, as before the paper       ism__add_shares       T41
     section 3.3          points drawn into the maps of all VPLs        ism__draw_points      T48, T50
     section 3.3          pull and push                                 ism__pull, ism__fill  T49
     section 4, figure 3  bidirectional importance by few receivers     ism__estimate_effect  T41
     section 4            flux over N and probability                   ism__make_vpl         T41
     section 4.1          prefix sums, VPL i at i / N                   ism__draw_vpl         T15, T16
     section 4.2          receivers near the texel's place              ism__to_pixel,
                                                                        ism__estimate_effect  T41
     section 5.1, fig. 6  solid angle of triangles, prefix sums         ism__solid_angle,
                                                                        ism__make_cdf         T52, T53
     section 5.1          a surfel's place in its triangle              ism__triangle_map     T51
     section 5.2          eight receivers for each triangle             ism__seen_by_view     T53
     section 5.3          an eighth of the surfels a frame              ism__points_of,
                                                                        ism_desc              T54, T57
     section 6.1          maps of equal flux, of lobes                  ism_map_direction,
                                                                        ism_map_coordinates   T46, T47
     section 6.2          subsets of VPLs, blur along surfaces          ism__shade_pixel,
                                                                        ism__smooth_pixel     -
     section 6.3          corners of triangles from indexed meshes      ism_mesh, ism__corners -
     section 6.4          dithered opacity                              ism_mesh, ism__dither T58
     section 6.5          blur of the BRSM                              ism__blur_task        T41
     section 6.5          VPLs between texels                           ism__inter_texel      T55
     ISM of 2008          the next bounce, from imperfect RSMs          ism_bounce            T45
     -                    light close to a VPL                          ism__patch_kernel     T42, T43, T44
     -                    VPLs that no pixel of a block can see         ism__cull             T56
     -                    clusters of triangles, seen by a VPL          ism__cluster_effect   -
     -                    windows                                       ism_zoom, ism_unzoom  -
     -                    near points                                   ism_near_points       -

   T.. are rows of docs/conformance.md. Where there is a -, the paper says nothing that a row could expect:
   tests/ism/sums_test.c computes interleaved pictures, clusters and the light of near points anew in doubles,
   window_test.c tests windows, near_test.c the choice of near points.

   docs/ism.md lists where and why the code departs from the paper.

   Knobs, and what each trades

     vpl_count     fewer: blotches where VPLs are near a surface; time and memory are proportional to it
     surfel_count  fewer: shadows of small things blur and vanish; memory 12 bytes each, times vpl_count
     spread        PAIR spends most surfels on what both the picture and the VPL see; the others are those of
                   the papers
     tile_side     smaller: light leaks round corners, contact shadows vanish
     window_rim    less: coarser maps of what the picture does not show; more: coarser maps of what it shows
     interleave    larger: 1 / interleave^2 of the shading time, but for that of near points, and details
                   of indirect shadows blurred over as many pixels
     bias          less: acne; more: light leaks in corners
     lazy_frames   renewing all surfels every frame (1) adapts at once, and flickers

   Configuration

     ISM_IMPLEMENTATION   in one source file: compiles the code
     ISM_STATIC           beside it: a private copy, all functions static
     ISM_DEF              everywhere: your own linkage instead
     ISM_NO_SIMD          with the implementation: portable code only (results are the same to the bit)
     ISM_FILE             with the implementation: this file's name, if it is not "ism.h". The file includes
                          itself for AVX2 and AVX-512; where it cannot, it does without them

   Memory, errors, threads, determinism

   All memory comes from the allocator in desc.system, called from the thread that called us. It grows to the
   largest frame and is kept, in bytes, with less than 8 KB besides:

     12 N surfels + 4 A + 4 A (if keep_hits) + 2444 tile_side^2 + 16 triangles + 768 clusters of triangles +
     832 bundles of clusters + 20 pVPLs + 16 rows of pVPLs + 40 sources + 4 pixels + 244 N + 112.25 N near
     points. A = (ceil(sqrt(N)) tile_side)^2; clusters are all triangles, or equal numbers of them, 32,768
     clusters at most; bundles = 1 + clusters / 16, rounded down.
     1024 VPLs, 8192 surfels, 64^2 texels: 101 + 17 + 12 MB

   While ism_shade runs: 12 pixels + 12 pixels (if interleaved) + 32 for each block of 16 x 16 pixels + 64 N
   more.

   Every function that can fail returns an ism_result. If the result is not ISM_OK, outputs are untouched,
   nothing leaks, and desc.system.log gets a line that says which field or element is wrong; where maps is
   NULL, there is no log. There are no globals. An ism_maps belongs to one thread at a time, but calls that
   take it as const may run together. Results are equal to the bit for the same input, seed and frame index,
   on every compiler, processor and thread count (not with x87 arithmetic, nor with clang's -ffast-math).

   Cost: docs/measured/performance.md and build/bench ism.   History: CHANGELOG.md.
   Licence: end of this file. */
#ifndef ISM_H
#define ISM_H

#define ISM_VERSION 900 /* major * 10000 + minor * 100 + patch */

#if !defined(__cplusplus) && !defined(_MSC_VER) && (!defined(__STDC_VERSION__) || __STDC_VERSION__ < 199901L)
#error "ism.h needs C99 or C++11"
#endif
#if defined(ISM_STATIC) && !defined(ISM_IMPLEMENTATION)
#error "ISM_STATIC makes all functions private: ISM_IMPLEMENTATION belongs into the same file"
#endif

#include <stddef.h>
#include <stdint.h>

#ifndef ISM_DEF
#ifdef ISM_STATIC
#define ISM_DEF static inline
#else
#define ISM_DEF extern
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif
