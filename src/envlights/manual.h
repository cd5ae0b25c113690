/* envlights.h - v1.0.0 - a sky as k directional lights whose energy is the sky's, for any renderer - MIT-0 OR Unlicense

   What it does

   Turns a radiance map of the surroundings into k directional lights, by importance, so that their energy is
   the map's energy; follows a map that changes from frame to frame; moves lights inside their strata; says
   what the lights leave out; and writes them as glTF. Methods: Agarwal, Ramamoorthi, Belongie and Jensen,
   "Structured importance sampling of environment maps", SIGGRAPH 2003; Debevec, "A median cut algorithm for
   light probe sampling", 2005; Viriyothai and Debevec, "Variance minimization light probe sampling", 2009;
   and inversion of the distribution.

   What it does not do

   - Lights are at infinity: no light enters from inside the scene, and all of it sees the same map.
   - No shadows: envshadow.h renders a map for each light, csm.h and any ray tracer take lights too.
   - No rendering of pictures, no file access, no threads.

   Quick start

   In exactly one source file write the define; everywhere else include the header alone.

       #define ENVLIGHTS_IMPLEMENTATION
       #include "envlights.h"
       #include <stdio.h>

       int main(void)
       {
           static float sky[3 * 64 * 32];
           envlt_map map = { ENVLT_PROJECTION_LATLONG, 64, 32, sky, 0 };
           envlt_lights *lights;
           const envlt_light *list;
           uint32_t count;
           float ground = 0;

           for (int i = 0; i < 3 * 64 * 16; i++) sky[i] = 1;    // bright above, black below
           if (envlt_create(NULL, &map, &lights, NULL) != ENVLT_OK) return 1;
           list = envlt_get_lights(lights, &count);
           for (uint32_t i = 0; i < count; i++) ground += list[i].direction[1] * list[i].irradiance[0];
           printf("%u lights, the ground gets %.2f\n", (unsigned)count, (double)ground);      // pi
           envlt_free(lights);
           return !(ground > 3.1f && ground < 3.2f);
       }

   Conventions

   Right-handed, +Y up (in a scene with Z up turn the lights by envlt_rotate); matrices are column-major
   float[16]; directions have unit length and point to the light; angles in radians, radiance in W/(sr m^2),
   irradiance in W/m^2.

     map        the environment: radiance of all directions, latitude-longitude or six cube faces, one float
                RGB a texel
     light      a directional light that stands for a stratum
     stratum    a region of the map, given to one light: radiance x solid angle is summed into it, per channel
     extent     how far the stratum's radiance spreads about the light's direction: an ellipse of two half
                axes

   Latitude-longitude: row 0 is +Y, v = acos(y) / pi from the top, u = 0.5 + atan2(z, x) / (2 pi). Cube: faces
   +X -X +Y -Y +Z -Z one after another, each as OpenGL stores it.

   How it works

   Texels weigh radiance x solid angle, computed exactly. STRUCTURED thresholds the map into six layers,
   shares lights out among connected bright regions by importance L min(w, 0.01 sr)^(1/4) and spreads them by
   farthest-first traversal; MEDIAN_CUT halves energy along the longer side; VARIANCE cuts where the spread
   of directions falls most; CDF inverts the cumulative distribution on a grid of (i + 0.5) / n. Cuts of
   latitude-longitude maps begin at the column of least energy, so that turning the map turns the lights.

   From the paper to the code

     Knuth 2005, 3, importance sampling    envlt_create                  T17 T18 T19 T20 T22
     Knuth 2005, 3, rotation of the map    envlt_rotate                  T21
     Knuth 2005, 3, jitter in a stratum    envlt_jitter                  T15
     Knuth 2005, 6, size of the light      axis_u and axis_v of          envlt_light
     Agarwal 2003, structured sampling     ENVLT_METHOD_STRUCTURED of    envlt_create
     Debevec 2005, median cut              ENVLT_METHOD_MEDIAN_CUT of    envlt_create
     Viriyothai 2009, minimum variance     ENVLT_METHOD_VARIANCE of      envlt_create
     solid angles                          envlt_texel_solid_angle       T11 T12 T13
     sums over large maps                  envlt_create                  T16

   The knobs, and what each trades:

     light_count   fewer lights: shadow edges of single lights; a renderer's time and memory grow with k
     method        VARIANCE has the smallest errors by measurement (docs/measured/envlights.md)
     split_sun     a small bright spot becomes a light of its own, with the sun's extent instead of its
                   surroundings'
     hemisphere    leaves out what is below the horizon, so that no light is spent on it

   Memory: 76 bytes a texel of the map while building (79 with split_sun), 16 kept.

   Configuration

     ENVLIGHTS_IMPLEMENTATION   in one source file: compiles the code
     ENVLT_STATIC               everywhere it is included: a private copy, all functions static
     ENVLT_DEF                  everywhere: your own linkage instead

   Memory, errors, threads, determinism

   All memory comes from the allocator in desc.system, called from the thread that called us. Every function
   that can fail returns an envlt_result; where it is not ENVLT_OK, outputs are untouched and nothing leaks.
   There are no globals; const objects may be read by any number of threads, one that is written belongs to
   one. Lights have the same bytes on every compiler and byte order (not with x87 arithmetic, nor clang's
   -ffast-math).

   Cost: docs/measured/envlights.md, build/bench envshadow_lights. History: CHANGELOG.md. Licence: at the end. */
#ifndef ENVLIGHTS_H
#define ENVLIGHTS_H

#define ENVLT_VERSION 10000 /* major * 10000 + minor * 100 + patch */

#if !defined(__cplusplus) && !defined(_MSC_VER) && (!defined(__STDC_VERSION__) || __STDC_VERSION__ < 199901L)
#error "envlights.h needs C99 or C++11"
#endif
#if defined(ENVLT_STATIC) && !defined(ENVLIGHTS_IMPLEMENTATION)
#error "ENVLT_STATIC makes all functions private: ENVLIGHTS_IMPLEMENTATION belongs into the same file"
#endif

#include <stddef.h>
#include <stdint.h>

#ifndef ENVLT_DEF
#ifdef ENVLT_STATIC
#define ENVLT_DEF static inline
#else
#define ENVLT_DEF extern
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif
