/* envshadow.h - v1.0.0 - environment-map shadows: many directional lights with shadow maps - MIT-0 OR Unlicense

   What it does

   Takes directional lights, lays out, fits and (on the CPU) renders one shadow map for each, and shades
   arrays of points with all of them in one pass: hundreds of lights that stand for a sky, as envlights.h
   makes them, or your own. After Knuth and Fuhrmann, "Self-Shadowing of Dynamic Scenes with Environment Maps
   using the GPU", WSCG 2005. Nothing is computed on the geometry beforehand: it may deform, tear, be open or
   intersect itself.

   What it does not do

   - Lights are at infinity: no light enters from inside the scene. envlights.h turns a sky into lights.
   - k shadow maps see k directions. Too few lights show as separate shadow edges; too small maps as jagged
     ones, and walls thinner than the filter's radius and four texels may leak. docs/envshadow.md has pictures
     and figures.
   - No bounced light, no rendering of pictures, no file access, no threads of its own.

   Quick start

   In exactly one source file write the define; everywhere else include the header alone.

       #define ENVSHADOW_IMPLEMENTATION
       #include "envshadow.h"
       #include <math.h>
       #include <stdio.h>

       static const float corners[] = { -1, 1, -1,  1, 1, -1,  1, 1, 1,  -1, 1, 1 };  // above the floor
       static const uint32_t triangles[] = { 0, 2, 1,  0, 3, 2 };

       int main(void)
       {
           static float directions[3 * 64], irradiances[3 * 64];    // a bright sky, as 64 lights
           const float points[] = { 0, 0, 0,  9, 0, 0 }, normals[] = { 0, 1, 0,  0, 1, 0 };
           envsh_lights lights = { 64, directions, irradiances, NULL, NULL, 0 };
           envsh_mesh mesh = { corners, 4, 0, triangles, 6, NULL };
           envsh_points receivers = { 2, points, 0, normals, 0, NULL, 0, 0 };
           envsh_maps *maps;
           float light[6];

           for (int i = 0; i < 64; i++) {
               float y = (i + 0.5f) / 64, r = sqrtf(1 - y * y), *d = directions + 3 * i;
               d[0] = r * cosf(2.4f * i), d[1] = y, d[2] = r * sinf(2.4f * i);
               for (int c = 0; c < 3; c++) irradiances[3 * i + c] = 6.2832f / 64;  // 1 x solid angle
           }
           if (envsh_maps_create(NULL, 64, &maps) != ENVSH_OK) return 1;
           envsh_maps_begin(maps, &lights, envsh_bounds_of(&mesh, 1, NULL));            // each frame
           envsh_maps_draw(maps, &mesh, NULL);
           envsh_maps_end(maps);
           envsh_shade(maps, NULL, &receivers, light);
           printf("under the square %.2f, far from it %.2f\n", (double)light[0], (double)light[3]);
           envsh_maps_free(maps);
           return !(light[0] < 2 && light[3] > 3);
       }

   Conventions

   Right-handed, any axis up; matrices are column-major float[16]; directions have unit length and point from
   the surface to the light; distances in your units, angles in radians, irradiance in W/m^2.

     light      a directional light: direction, irradiance, and extent
     extent     how far what the light stands for spreads about its direction: an ellipse of two half axes,
                which are tangents of angles. A disc such as the sun's: its radius; without extent shadows are
                sharp
     map        a light's shadow map
     tile       the shadow map of one light inside the atlas; four tiles share a texel's RGBA where that is
                asked for
     guard      texels around each tile that are never drawn into, so that filters find "nothing here" and no
                neighbour
     caster     what is drawn into shadow maps; receiver: a point that is shaded
     depth      0 nearest to the light .. 1 farthest caster, linear in distance; 1 or more means nothing there

   How it works

   One orthographic map for each light, fitted to the casters' bounds and snapped to its texels. A receiver is
   moved along its normal by bias x texel x sine and compared with its own plane's depth at each tap, so that
   steep light needs no more bias than flat light.

   From the paper to the code

     3, algorithm 1, all lights at once    envsh_maps_begin envsh_maps_draw envsh_shade       T23
     3, algorithm 2, clusters of c lights  envsh_illuminate
     3, Fig. 2, maps side by side          envsh_get_info envsh_get_views                     T24
     4, Fig. 5, maps in color channels     rgba of envsh_maps_desc                            T24
     3, Fig. 4, smoothing                  ENVSH_FILTER_SMOOTH and ENVSH_FILTER_PCF of        envsh_query
     4, load balancing                     envsh_cost_fit envsh_cost_cluster
     6, size of the light source           ENVSH_FILTER_PENUMBRA of envsh_query, axes_u of    envsh_lights

   The knobs, and what each trades:

     lights        fewer of them: shadow edges of single lights (Fig. 3 of the paper); time and memory grow
                   with k
     map_side      fewer texels: jagged contact shadows, leaks through thin walls; memory grows with its
                   square
     filter        PLAIN is sharp; SMOOTH and PCF blur every edge alike (the paper's); PENUMBRA by the light's
                   extent and the blocker's distance (its future work): the fewest lights for a picture
     radius        of PENUMBRA, texels at most: with too few, shadows of a large sun stay sharp far from their
                   casters
     bias          too little: acne; too much: light under things that touch the ground

   Memory: 4 bytes a texel of map_side^2 x capacity, and a 32nd for the depth bounds of cells.

   Configuration

     ENVSHADOW_IMPLEMENTATION   in one source file: compiles the code
     ENVSH_STATIC               everywhere it is included: a private copy, all functions static
     ENVSH_DEF                  everywhere: your own linkage instead

   Memory, errors, threads, determinism

   All memory comes from the allocator in desc.system, called from the thread that called us. Every function
   that can fail returns an envsh_result; where it is not ENVSH_OK, outputs are untouched and nothing leaks.
   There are no globals; const objects may be read by any number of threads, one that is written belongs to
   one. Maps and shading have the same bytes on every compiler, byte order and thread count (not with x87
   arithmetic, nor clang's -ffast-math).

   Cost: docs/measured/envshadow.md, build/bench gl_envshadow. History: CHANGELOG.md. Licence: at the end. */
#ifndef ENVSHADOW_H
#define ENVSHADOW_H

#define ENVSH_VERSION 10000 /* major * 10000 + minor * 100 + patch */

#if !defined(__cplusplus) && !defined(_MSC_VER) && (!defined(__STDC_VERSION__) || __STDC_VERSION__ < 199901L)
#error "envshadow.h needs C99 or C++11"
#endif
#if defined(ENVSH_STATIC) && !defined(ENVSHADOW_IMPLEMENTATION)
#error "ENVSH_STATIC makes all functions private: ENVSHADOW_IMPLEMENTATION belongs into the same file"
#endif

#include <stddef.h>
#include <stdint.h>

#ifndef ENVSH_DEF
#ifdef ENVSH_STATIC
#define ENVSH_DEF static inline
#else
#define ENVSH_DEF extern
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif
