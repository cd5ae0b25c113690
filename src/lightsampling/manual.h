/* lightsampling.h - v1.0.0 - direct light by sampling: lights, materials, the estimator - MIT-0 OR Unlicense

   What it does

   Estimates the direct light of one lamp or sky at arrays of points: it draws directions towards the light,
   weighs each of them with material and light, and sums up those that are visible. You say which samples are
   visible, in a plain array of floats: from csm.h's maps, from rays (Embree, your own tracer), or from any
   shadow map. The method is that of section 5 of Ritschel, Grosch, Kautz and Mueller, "Interactive
   Illumination with Coherent Shadow Maps", EGSR 2007.

   What it does not do

   - It does not find out what blocks light, and it renders nothing: points, normals, directions to the eye
     and visibility are yours.
   - Light comes straight from the lamp; nothing bounces.
   - It opens no files, allocates no memory and starts no threads.

   Quick start

   Write the define in exactly one source file; include the header alone everywhere else.

       #define LIGHTSAMPLING_IMPLEMENTATION
       #include "lightsampling.h"
       #include <stdio.h>

       enum { SAMPLES = 256 };

       int main(void)
       {
           // a square lamp over a white point; a big card hides the half of it with x < 0
           static float directions[3 * SAMPLES], distances[SAMPLES], weights[3 * SAMPLES], visible[SAMPLES];
           static double memory[512];
           const float at[3] = { 0, 0, 0 }, up[3] = { 0, 1, 0 };
           static lsamp_light_desc lamp;                                  // static: all zero, the defaults
           static lsamp_material white;
           static lsamp_points points;
           static lsamp_sample_desc desc;
           lsamp_samples samples = { directions, distances, NULL, weights };
           lsamp_light *light;
           float open[3] = { 0, 0, 0 }, half[3] = { 0, 0, 0 };
           int i;

           lamp.kind = LSAMP_LIGHT_RECTANGLE;
           lamp.position[0] = lamp.position[2] = -1;                   // corner and edges; it shines down
           lamp.position[1] = 2;
           lamp.u[0] = lamp.v[2] = 2;
           lamp.radiance[0] = lamp.radiance[1] = lamp.radiance[2] = 1;
           white.diffuse[0] = white.diffuse[1] = white.diffuse[2] = 1;
           desc.sample_count = SAMPLES;
           points.count = 1;
           points.positions = at;
           points.normals = up;
           points.materials = &white;
           if (lsamp_light_init(&lamp, memory, sizeof memory, &light, NULL) != LSAMP_OK) return 1;
           if (lsamp_sample(&desc, light, &points, &samples, NULL) != LSAMP_OK) return 1;
           for (i = 0; i < SAMPLES; i++) visible[i] = directions[3 * i] >= 0 ? 1.0f : 0.0f;     // your answer
           lsamp_accumulate(1, SAMPLES, weights, NULL, open, 0);
           lsamp_accumulate(1, SAMPLES, weights, visible, half, 0);
           printf("radiance %.3f, half hidden %.3f\n", (double)open[0], (double)half[0]);
           return !(open[0] > 0.23f && open[0] < 0.25f && half[0] > 0.11f && half[0] < 0.13f);
       }

   Conventions

   Coordinates are right-handed; directions have unit length and point from the surface to the light or the
   eye; distances are in the scene's units, angles in radians, radiance in W/(sr m^2). A vector that is called
   unit may have a length from 0.97 to 1.03 and is used as it is; any other length is an error. The poles of
   skies, of latitude-longitude maps and of `rotation` are +Y and -Y: turn a scene whose up is Z before it
   comes here.

     light      a shape A that emits (section 5), its light function L, and how points of it are drawn, P_L
     coords     a light's own coordinates x in [0, 1)^d; equal ranges of them cover equal areas of the light
     domain     D of section 4: the directions or positions that visibility maps for a light must be made for
     material   a BRDF f with its parameters at one point, and how directions are drawn from it, P_f
     sample     one direction towards a light with its weight f L cos / (pdf S), for S samples a point
     pattern    points in the unit square from which all samples of one pixel take their random numbers
                (section 5.1)

   How it works

   L(x, wo) = integral of f(x, wo, w) L_in(x, w) V(x, w) cos(theta) dw, in three steps that arrays of points
   share:

       lsamp_sample      for each point S directions towards one light, each with its weight f L cos / (pdf S)
       visible           yours: one float a sample, 1 lit, 0 hidden; a sample of weight 0 needs none
       lsamp_accumulate  adds weight x visibility up

   Several lights are several calls. Calls on the same light may run on several threads at once.

   From the paper to the code

     section 5     the direct lighting equation      lsamp_sample, lsamp_accumulate           T10, T20, T23
     section 5     A, a light's shape (figure 12)    lsamp_light_kind, lsamp__shape_point     T43, T73
     section 5     A as a table, linearly filtered   lsamp_surface, lsamp__surface_point      T43, T73
     section 5     L, texels, and frames over time   lsamp_light_desc, lsamp__emitter_frame   T18, T22
     section 5     L, linear filtering (figure 12)   lsamp_texels, lsamp__texel_at            T43
     section 5     emitters that are not Lambertian  lsamp__emit                              T43
     section 4, 5  D, where maps look from           lsamp_light_domain                       -
                                                     lsamp_surface_locations                  -
     section 5.1   the mean of f L V cos / p         lsamp__estimate                          T10, T73
     section 5.1   P_L, the inverse of a CDF         lsamp__emitter_cdf, lsamp__invert_sums   T11, T12, T15
     section 5     a material for each pixel         lsamp_points (materials)                 -
     section 5.1   P_f, lobes by Russian roulette    lsamp_brdf_sample, lsamp__brdf_draw      T10, T21
     section 5.1   256 patterns, one for a pixel     lsamp_patterns_build, lsamp__random_numbers  -
     section 5.1   sky: diffuse by P_L, specular by  lsamp_sampling, lsamp__estimator_init    T10
                   P_f; local lights by P_L
     section 5.2   the mean of frames (figure 11)    lsamp_progressive_add                    T16

   The last column names the rows of docs/conformance.md that test a line; a - says that there is none.
   tests/lightsampling holds patterns to what makes them stratified and to an integral, and samples of points
   with materials of their own to golden bytes. Visibility V and the rest of the paper are csm.h's.
   docs/lightsampling.md says where the code departs from the paper, and why.

   Configuration

     LIGHTSAMPLING_IMPLEMENTATION   in one source file: compiles the code
     LSAMP_STATIC                   beside it: a private copy for this file, all functions static
     LSAMP_DEF                      everywhere: your own linkage instead

   Memory, errors, threads, determinism

   Nothing here allocates: lights, patterns and sums live in memory that you own. Every function that can fail
   returns an lsamp_result; if the result is not LSAMP_OK, outputs are untouched. The log of a desc says why a
   call failed, unless the desc is NULL; calls without a desc say at their declarations that they have no log.
   There are no globals: any number of threads may sample the same light; sums of frames belong to one thread
   at a time. A point's samples depend on its own inputs and pixel only, and are the same bits on every
   compiler and processor (not with x87 arithmetic, nor with clang's -ffast-math).

   What is supported: docs/lightsampling.md.   History: CHANGELOG.md.   Licence: end of this file. */
#ifndef LIGHTSAMPLING_H
#define LIGHTSAMPLING_H

#define LSAMP_VERSION 10000 /* major * 10000 + minor * 100 + patch */

#if !defined(__cplusplus) && !defined(_MSC_VER) && (!defined(__STDC_VERSION__) || __STDC_VERSION__ < 199901L)
#error "lightsampling.h needs C99 or C++11"
#endif
#if defined(LSAMP_STATIC) && !defined(LIGHTSAMPLING_IMPLEMENTATION)
#error "LSAMP_STATIC makes all functions private: LIGHTSAMPLING_IMPLEMENTATION belongs into the same file"
#endif

#include <stddef.h>
#include <stdint.h>

#ifndef LSAMP_DEF
#ifdef LSAMP_STATIC
#define LSAMP_DEF static inline
#else
#define LSAMP_DEF extern
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

