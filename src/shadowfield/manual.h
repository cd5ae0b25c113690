/* shadowfield.h - v1.0.0 - shadow fields: soft shadows of moving objects and lights - MIT-0 OR Unlicense

   What it does

   This header gives moving objects soft shadows from moving lights. For each object it records once, at
   sample points on spheres round the object, which directions the object hides (an occlusion field); for each
   light, what arrives from the light there (a source field). At run time any number of instances of the
   fields move, turn and scale evenly. The light that reaches a point is a product of a few field samples,
   with the shadows of local lights, video lights and the environment together. After Zhou, Hu, Lin, Guo and
   Shum, "Precomputed Shadow Fields for Dynamic Scenes", SIGGRAPH 2005. Fields are kept in one of two bases:
   real spherical harmonics (fast, soft) or Haar wavelets (all frequencies, slow).

   What it does not do

   - Objects are rigid. Light bounces from body to body, once a frame, if you ask for it. Points are shaded:
     your vertices, probes or pixels.
   - Four bands of harmonics blur everything finer than about 45 degrees; small lights need wavelets.
   - The header renders no pictures, opens no files and starts no threads.

   Quick start

   In exactly one source file write the define; everywhere else include the header alone.

       #define SHADOWFIELD_IMPLEMENTATION
       #include "shadowfield.h"
       #include <stdio.h>
       #include <string.h>

       int main(void)
       {
           static const float corners[] = { -1, 0, -1,  1, 0, -1,  1, 0, 1,  -1, 0, 1 };    // a square
           static const uint32_t triangles[] = { 0, 2, 1,  0, 3, 2 };
           const float place[6] = { 0, -0.5f, 0,  6, -0.5f, 0 }, up[6] = { 0, 1, 0,  0, 1, 0 };
           const float sky[3] = { 1, 1, 1 };
           float rgb[6] = { 0, 0, 0, 0, 0, 0 };
           sfield_mesh mesh = { corners, 4, 0, triangles, 6, NULL, NULL, NULL };
           sfield_entity square;
           sfield_points points;
           sfield_field *field;
           sfield_scene *scene;

           if (sfield_build(NULL, &mesh, &field, NULL) != SFIELD_OK) return 1;     // 384 KB, within a second
           if (sfield_scene_create(NULL, &scene) != SFIELD_OK) return 1;
           memset(&square, 0, sizeof square);
           square.occlusion = field;                               // square.transform: where it is now
           sfield_scene_entities(scene, &square, 1);
           sfield_scene_environment(scene, sky, 1, 1, NULL);       // radiance 1 from everywhere
           memset(&points, 0, sizeof points);
           points.count = 2;
           points.positions = place;
           points.normals = up;
           points.rgb = rgb;
           sfield_shade(scene, &points, 1, NULL);
           printf("irradiance / pi: %g below the square, %g beside it\n", (double)rgb[0], (double)rgb[3]);
           sfield_scene_free(scene);
           sfield_free(field);
           return !(rgb[0] < 0.7f && rgb[3] > 0.9f);
       }

   Conventions

   Space is right-handed. Matrices are column-major float[16]; a matrix of zeros is the identity. Directions
   point from the surface to the light and are unit: a length of 0.97..1.03 is used as it is, and any other
   but 0 is an error. Distances are in your units, angles in radians, radiance in W/(sr m^2), irradiance in
   W/m^2. All zero is the default of every desc.

     r          the radius of an entity's bounding sphere, whose centre is the centre of the field
     entity     an instance of an occlusion field, of a source field or of both, with its own transform
     shell      one of the concentric spheres; its sample points lie on the grid of a cube, 6 x side x side
     cube       what is seen from a sample point: 6 x N x N texels, faces +X -X +Y -Y +Z -Z as OpenGL orders
                them
     texel      number face N^2 + morton(x, y) of a cube: sfield_cube_texel gives its direction and solid
                angle
     occlusion  alpha: 1 hidden, 0 free. Queries return visibility, 1 - alpha
     bands      n bands of spherical harmonics are n^2 coefficients; coefficient l^2 + l + m belongs to band
                l, and those of band 1 belong to 0.4886 y, 0.4886 z and 0.4886 x
     planes     many vectors of coefficients lie in planes: coefficient k of vector i is v[k * stride + i], so
                that 16 vectors are treated at a time. With stride 1 a single vector is a plain array
     T          of a point and a light: BRDF x cosine x visibility, what of the light counts for the point

   How it works

     once        sfield_build (objects), sfield_build_emitter or _emissive (lights), or sfield_open (files)
     once        sfield_scene_create, sfield_scene_environment
     each frame  sfield_scene_entities, sfield_shade

   A query at distance d finds the two shells around d and interpolates eight samples. The radii of shells
   grow by a factor; weights are linear in the solid angle of the bounding sphere (occlusion) or in (r/d)^2
   (sources). Beyond the last shell both fall as (r/d)^2, as small things do that are seen from afar. To shade
   a point, T starts as BRDF x cosine x self-visibility and is multiplied by the visibility of each entity,
   from near to far. A light adds its dot product with the T that stands when the light is reached; the
   environment is the farthest light.

     harmonics  have coefficients of 8 bits, scaled for each shell, band and order: shells x 6 side^2 x n^2
                bytes (three times as many for lights). With all defaults a box takes 0.6 s and 0.4 MB, a lamp
                3 s and 1.2 MB
     wavelets   are orthonormal on the planar face of a cube; the largest are kept, with 4 bytes each (8 for
                lights). With all defaults a box takes 15 s and 33 MB, a lamp 50 s and 62 MB

   The knobs, and what each trades:

     bands            fewer: faster and softer, and light leaks round objects. Time grows with bands^4
     position_side    fewer: shadows wobble as things move past sample points
     keep             less: noise of 2 x 2 texels in shadows, since fewer wavelets are kept
     cube_side        less: penumbrae in steps, since texels are larger
     keep_inside      0: positions inside a closed mesh see from its surface. Not 0: nothing, which darkens

   From the paper to the code

     section 3.1  an object occlusion field, shell by shell      sfield_build, sfield_build_callback  T72
     section 3.1  a source radiance field                        sfield_build_emitter                 T73
     section 3.1  S_d, the environment, and its rotation         sfield_scene_environment,
                                                                 sfield_scene_turn                    T11 T12
     section 3.1  O_p, what an object hides from its own points  sfield_build_self                    -
     section 3.1  sampling densities by a level of error         sfield_place                         -
     section 3.2  incident radiance, from far to near            sfield_incident                      T78
     section 3.2  spheres of lights and objects do not overlap   sfield_scene_desc (strict)           T80
     section 3.3  concentric shells from 0.2 r to 8 r or 20 r    sfield_desc (inner, outer)           T74
     section 3.3  eight samples of concentric shells             sfield_query                         T74 T75
     section 3.3  16 coefficients of 8 bits                      sfield_sh_project, sfield_build      T77
     section 3.3  area-weighted choice of wavelets               sfield_build                         T81
     section 4    B, the rendering equation                      sfield_shade                         T73
     section 4    the BRDF at the beginning, before occluders    sfield_points (materials, exponents) -
     section 4.1  G_i = sum of C_ijk E_j F_k: triple products    sfield_sh_product, sfield_sh_terms   T5 T6
     section 4.1  the same of wavelets, in sublinear time        sfield_haar_product                  T81
     section 4.1  the double product                             sfield_sh_dot                        T2
     section 4.1  rotations                                      sfield_sh_rotation                   T9 T76
     figure 5     entities from near to far                      sfield_scene_entities, sfield_shade  T78
     section 4.2  points that the viewer does not see            sfield_points (in_view)              -
     section 4.2  culling, with a count for each of its rules    sfield_scene_stats                   -
     section 4.2  lazy occlusion updating                        sfield_cache_create                  T79
     section 5    lights that are videos, by key frames          sfield_desc (frame_count),
                                                                 sfield_entity                        -
     section 6    few vertices shaded, the others interpolated   sfield_sparse, sfield_spread         -
     section 6    radiance from interreflections                 sfield_bounce_create                 -

   T.. are rows of docs/conformance.md. Where there is a -, tests/shadowfield/ has tests without a row.

   Configuration

     SHADOWFIELD_IMPLEMENTATION   in one source file: compiles the code
     SFIELD_STATIC                with the implementation: a private copy, all functions static
     SFIELD_DEF                   everywhere: your own linkage instead
     SFIELD_NO_SIMD               with the implementation: no intrinsics (results equal but for rounding)
     SFIELD_FILE                  with the implementation: this file's name, if it is not "shadowfield.h". The
                                  file includes itself for AVX2 and AVX-512; where it cannot, it does without
                                  them

   In the repository, make join shadowfield.h WITHOUT="build" writes this header without the precomputation,
   for programs that only open files and shade; WITHOUT="all" leaves out all optional parts, wavelets and
   intrinsics among them (src/README.md).

   Memory, errors, threads, determinism

   All memory comes from the system's allocator, called from the thread that called us. Every function that
   can fail returns a sfield_result. If the result is not SFIELD_OK, outputs are untouched and nothing leaks,
   and the system's log is told which argument, field or element has which value, and what it must be; that
   memory ran out the result may tell alone. Fields, algebras and scenes keep allocator, log and user of the
   system that they were made with: these must live as long. A call without such an object has no log.
   There are no globals: any number of threads may read fields and algebras at once. A scene belongs to one
   call at a time, which spreads its work by your parallel_for. Built fields have the same bytes on every
   compiler, processor, byte order and thread count (not with x87 arithmetic, nor with clang's -ffast-math).
   Shading does not depend on the number of threads.

   Cost: docs/measured/shadowfield.md and build/bench sfield_algebra, sfield_chess, sfield_wavelet.
   History: CHANGELOG.md.   Licence: end of this file. */
#ifndef SHADOWFIELD_H
#define SHADOWFIELD_H

#define SFIELD_VERSION 10000 /* major * 10000 + minor * 100 + patch */

#if !defined(__cplusplus) && !defined(_MSC_VER) && (!defined(__STDC_VERSION__) || __STDC_VERSION__ < 199901L)
#error "shadowfield.h needs C99 or C++11: -std=c99"
#endif
#if defined(SFIELD_STATIC) && !defined(SHADOWFIELD_IMPLEMENTATION)
#error "SFIELD_STATIC makes private functions: define SHADOWFIELD_IMPLEMENTATION beside it"
#endif

#include <stddef.h>
#include <stdint.h>

#ifndef SFIELD_DEF
#ifdef SFIELD_STATIC
#define SFIELD_DEF static inline
#else
#define SFIELD_DEF extern
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif
