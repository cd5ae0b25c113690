/* envlights.h - v1.0.0 - a sky as k directional lights, for any renderer - MIT-0 OR Unlicense

   What it does

   Turns a radiance map of the surroundings into k directional lights, by importance, so that the lights have
   the energy of the map; follows a map that changes from frame to frame; moves lights inside their strata;
   computes what the lights leave out; and writes the lights as glTF. The lights are those of Knuth and
   Fuhrmann, "Self-Shadowing of Dynamic Scenes with Environment Maps using the GPU", WSCG 2005, whose shadows
   are in envshadow.h. There are four methods: Agarwal, Ramamoorthi, Belongie and Jensen, "Structured
   importance sampling of environment maps", SIGGRAPH 2003, which that paper takes; Debevec, "A median cut
   algorithm for light probe sampling", 2005; Viriyothai and Debevec, "Variance minimization light probe
   sampling", 2009; and inversion of the distribution.

   What it does not do

   - Lights are infinitely far away: no light comes from a place inside the scene, and every point of the
     scene sees the same map.
   - It computes no shadows: envshadow.h renders a shadow map for each light; csm.h and any ray tracer can
     take the lights too.
   - It renders no pictures, opens no files and starts no threads.

   Quick start

   Write the define in exactly one source file; include the header alone everywhere else.

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

   Coordinates are right-handed and +Y is up (turn the lights by envlt_rotate for a scene whose up is Z);
   matrices are column-major float[16]; directions have unit length and point to the light; angles are in
   radians, radiance in W/(sr m^2), irradiance in W/m^2. A vector that is called unit may have a length from
   0.97 to 1.03 and is used as it is; any other length is an error. Directions that this header makes are unit
   within 1e-6.

     map        the environment: radiance of all directions, latitude-longitude or six cube faces, one float
                RGB a texel
     light      a directional light that stands for a stratum
     stratum    a region of the map that one light stands for: the light's irradiance is the sum of
                radiance x solid angle over the stratum, for each channel
     extent     how far the stratum's radiance spreads about the light's direction: an ellipse, given by its
                two half axes

   A latitude-longitude map has +Y in row 0; a direction lies at v = acos(y) / pi from the top and
   u = 0.5 + atan2(z, x) / (2 pi) from the left. A cube map has its faces +X -X +Y -Y +Z -Z one after another,
   each as OpenGL stores it.

   How it works

   The energy of a texel is its luminance x its solid angle, which is computed exactly. STRUCTURED thresholds
   the map into six layers, shares the lights out among the connected bright regions by the importance
   L min(w, 0.01 sr)^(1/4) of a region with energy L and solid angle w, and spreads them within a region by
   farthest-first traversal. MEDIAN_CUT cuts a region across its longer side into two of the same energy.
   VARIANCE cuts a region where the cut lowers the spread of directions most. CDF inverts the cumulative
   distribution at the points (i + 0.5) / n of a grid. Cuts of latitude-longitude maps begin at the column of
   least energy, so that turning the map turns the lights.

   From the paper to the code

     Knuth 2005, 3, Fig. 1, importance     envlt_create                                T17 T18 T19 T20 T22
     Knuth 2005, 3, rotation of the map    envlt_rotate                                T21
     Knuth 2005, 3, jitter in a stratum    envlt_jitter                                T15 irradiance
     Knuth 2005, 6, size of the light      envlt__find_extent; axis_u of envlt_light   -
     Agarwal 2003, structured sampling     envlt__run_structured                       T19 T20 T21
     Debevec 2005, median cut              envlt__run_median                           T19 T20 T21
     Viriyothai 2009, minimum variance     envlt__best_cut                             T19 T20 T21 irradiance
     inversion of the distribution         envlt__run_inversion                        T19 T20 T21
     solid angles                          envlt_texel_solid_angle                     T11 T12 T13
     sums over large maps                  envlt_create                                T16

   The last column names the rows of docs/conformance.md that test a line. A - says that there is none;
   extents are held to a disc's radius by tests/envlights/lights_rows_test.c.

   The knobs, and what each trades:

     light_count   With few lights the shadow edges of single lights can be seen; with many a renderer needs
                   more time and memory.
     method        VARIANCE has the smallest errors by measurement (docs/measured/envlights.md).
     split_sun     A small bright spot becomes a light of its own, with the extent of the spot and not of its
                   surroundings.
     hemisphere    Directions below the horizon are left out, so that no light is spent on them.

   A build takes at most 76 bytes of memory for each texel of the map (79 with split_sun; 45 and 50 by
   MEDIAN_CUT and CDF) and half a kilobyte for each light. It keeps 16 bytes a texel and a quarter of a
   kilobyte a light.

   Configuration

     ENVLIGHTS_IMPLEMENTATION   in one source file: compiles the code
     ENVLT_STATIC               beside it: a private copy for this file, all functions static
     ENVLT_DEF                  everywhere: your own linkage instead

   Memory, errors, threads, determinism

   All memory comes from the allocator in desc.system, called from the thread that called us. Every function
   that can fail returns an envlt_result; if the result is not ENVLT_OK, outputs are untouched, nothing leaks,
   and a call that has a desc or an envlt_lights tells its system.log which field is wrong. There are no
   globals: any number of threads may read the same lights at once; a call that changes them needs them to
   itself. Lights have the same bytes on every compiler and byte order (not with x87 arithmetic, nor clang's
   -ffast-math).

   Cost: docs/measured/envlights.md, build/bench envshadow_lights.   History: CHANGELOG.md.
   Licence: end of this file. */
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
