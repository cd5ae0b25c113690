/* envshadow.h - v1.0.0 - many directional lights with shadow maps, such as a sky's - MIT-0 OR Unlicense

   What it does

   Takes directional lights, lays out, fits and (on the CPU) renders one shadow map for each, and shades
   arrays of points with all of them in one pass: hundreds of lights that stand for a sky, as envlights.h
   makes them, or your own. The method is that of Knuth and Fuhrmann, "Self-Shadowing of Dynamic Scenes with
   Environment Maps using the GPU", WSCG 2005. Nothing is computed on the geometry beforehand: the geometry
   may deform, tear, be open or intersect itself.

   What it does not do

   - Lights are infinitely far away: no light comes from a place inside the scene. envlights.h turns a sky
     into lights.
   - k shadow maps see k directions. Too few lights show as separate shadow edges, too small maps as jagged
     edges, and light may leak through walls thinner than the filter's radius and four texels.
     docs/envshadow.md has pictures and figures.
   - It computes no bounced light, renders no pictures, opens no files and starts no threads.

   Quick start

   Write the define in exactly one source file; include the header alone everywhere else.

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
           envsh_mesh mesh = { corners, 4, 0, triangles, 6, NULL, NULL, NULL };
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

   Coordinates are right-handed, and any axis may be up; matrices are column-major float[16]; directions have
   unit length and point from the surface to the light; distances are in your units, angles in radians,
   irradiance in W/m^2. A vector that is called unit may have a length from 0.97 to 1.03 and is used as it is;
   any other length is an error, and the log names the element.

     light      a directional light: direction, irradiance, and extent
     extent     how far a light spreads about its direction, as the sun's disc or a region of the sky does: an
                ellipse, given by two half axes whose lengths are tangents of angles. A light without extent
                casts sharp shadows
     map        a light's shadow map
     atlas      the texture, of one or several pages, that holds the maps of all lights
     tile       the place of one light's map in the atlas; with rgba four tiles lie in the same texels, each
                in a channel of its own
     guard      texels around each tile that are never drawn into, so that filters find no caster there and
                not a neighbouring tile
     caster     geometry that is drawn into shadow maps
     receiver   a point that is shaded
     depth      0 nearest to the light .. 1 farthest caster, linear in distance; 1 or more means no caster

   How it works

   Each light has one orthographic map, which is fitted to the casters' bounds. Sizes go in steps of a
   sixteenth of an octave and corners lie on whole texels, so that small changes of the bounds move no texel
   of a resting light. A receiver is moved along its normal, by bias texels at grazing light and a quarter of
   that at light from straight above. Each tap of a filter then compares the stored depth with the depth of
   the receiver's plane at that tap, so that grazing light needs no larger bias than that. Tiles are divided
   into cells of 8 x 8 texels with the least and greatest depth of each, by which most filters need no texel.

   From the paper to the code

     3, importance sampling                envlights.h                                        -
     3, algorithm 1, all lights at once    envsh_maps_begin envsh_maps_draw envsh_shade       T23
     3, algorithm 2, clusters of c lights  envsh_illuminate                                   -
     3, Fig. 2, maps side by side          envsh__lay_out_tiles envsh_views                   T24
     3, Fig. 3, more lights, softer shadow envsh_maps_desc envsh_shade                        T23
     3, Fig. 4, smoothing                  envsh__filter_smooth                               image
     4, Fig. 5, maps in color channels     rgba of envsh_maps_desc                            T24
     4, percentage closer filtering        envsh__filter_taps                                 T24
     4, load balancing                     envsh_cost_fit envsh_cost_cluster                  -
     6, size of the light source           envsh__filter_penumbra, axes_u of envsh_lights     image

   The last column names the rows of docs/conformance.md that test a line; a - says that there is none. Of
   these, tests/envshadow/maps_rows_test.c holds clusters to the sums of all lights at once, and the cost
   model to its own times.

   The knobs, and what each trades:

     lights        With few lights the shadow edges of single lights can be seen (Fig. 3 of the paper); time
                   and memory grow with k.
     map_side      Fewer texels give jagged contact shadows and leaks through thin walls; memory grows with
                   the square of map_side.
     filter        PLAIN is sharp. SMOOTH and PCF, the paper's, blur every edge alike. PENUMBRA, the paper's
                   future work, blurs by the light's extent and the distance of the occluder, and so needs the
                   fewest lights for a picture.
     radius        PENUMBRA looks no farther than radius texels: with too few, shadows of a large sun stay
                   sharp far from their casters.
     bias          Too little gives acne; too much lets light under things that touch the ground.

   Maps take 4 bytes for each of the map_side^2 texels of each light, and a 32nd of that for the depth bounds
   of cells.

   Configuration

     ENVSHADOW_IMPLEMENTATION   in one source file: compiles the code
     ENVSH_STATIC               beside it: a private copy for this file, all functions static
     ENVSH_DEF                  everywhere: your own linkage instead

   Memory, errors, threads, determinism

   All memory comes from the allocator in desc.system, called from the thread that called us. Every function
   that can fail returns an envsh_result; if the result is not ENVSH_OK, outputs are untouched (unless a
   contract says otherwise), nothing leaks, and desc.system.log is told which field or element is wrong. There
   are no globals: any number of threads may shade with the same maps at once; a call that changes maps needs
   them to itself. Maps and shading have the same bytes on every compiler, byte order and thread count (not
   with x87 arithmetic, nor clang's -ffast-math).

   Cost: docs/measured/envshadow.md, build/bench gl_envshadow.   History: CHANGELOG.md.
   Licence: end of this file. */
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
