/* csm.h - v1.0.0 - coherent shadow maps: precomputed visibility of rigid objects - MIT-0 OR Unlicense

   What it does

   Renders an object's depth from thousands of directions (or light positions) once, compresses all those
   shadow maps into one small block, and answers "is this point lit from there?" with one cache line a query.
   The method is that of Ritschel, Grosch, Kautz and Mueller, "Interactive Illumination with Coherent Shadow
   Maps", EGSR 2007. lightsampling.h has what a Monte Carlo renderer of direct light needs around visibility:
   lights, materials, sampling.

   What it does not do

   - It does not deform objects. They are rigid; they may move, turn and scale evenly.
   - Its answers are exact for the maps, not for the scene: directions snap to N maps, and points to M x M
     pixels. Shadows of details finer than a pixel (1/128 of the object by default) are lost or widened;
     docs/csm.md has pictures and figures.
   - It computes no bounced light, renders no pictures, opens no files and starts no threads.

   Quick start

   Write the define in exactly one source file; include the header alone everywhere else.

       #define CSM_IMPLEMENTATION
       #include "csm.h"
       #include <stdio.h>

       int main(void)
       {
           static const float corners[] = { -1, 0, -1,  1, 0, -1,  1, 0, 1,  -1, 0, 1 };    // a square
           static const uint32_t triangles[] = { 0, 2, 1,  0, 3, 2 };
           const float point[3] = { 0.0f, -0.5f, 0.0f }, sideways[3] = { 1, 0, 0 }, up[3] = { 0, 1, 0 };
           cohsm_mesh mesh = { corners, 4, 0, triangles, 6, NULL, NULL, NULL };
           static cohsm_query query;                                 // static: all zero, the defaults
           cohsm_maps *maps;
           float lit[2];

           if (cohsm_build(NULL, &mesh, &maps, NULL) != COHSM_OK) return 1;     // 128 x 128 directions
           query.positions = point;
           query.count = 1;
           query.lights = up;                                                   // towards the light
           cohsm_visible(maps, &query, &lit[0], NULL);
           query.lights = sideways;
           cohsm_visible(maps, &query, &lit[1], NULL);
           printf("below the square: light from above %g, from the side %g\n", (double)lit[0],
                  (double)lit[1]);
           cohsm_free(maps);
           return !(lit[0] == 0.0f && lit[1] == 1.0f);
       }

   Real programs ask for thousands of points at once: the searches of a batch overlap, and one light for all
   points (query.one_light) is several times faster still.

   Conventions

   Coordinates are right-handed; matrices are column-major float[16]; distances are in the mesh's units,
   angles in radians. Directions point from the surface to the light: those of a query may have any length
   but 0, and those that cohsm_location writes are unit. The poles of the maps of directions are +Y and -Y:
   turn a scene whose up is Z before it comes here.

     map        the depths of the object along one direction (an orthographic image), or around one position
                (the six faces of a cube)
     domain     the set of those directions or positions: a mapping D of d parameters, each in 0..1
     cell       one of the N samples of the domain; each cell has one map
     view       one rendered image: a map of a direction, or one face of a map of a position. Views are stored
                in a sequence in which neighbours look alike
     layers     z1, z2, z3: the depths of the first, second and third hit of a pixel's ray
     segment    a run of views for which one stored depth separates z1 from the layer behind it
     tray       in the fast layout (COHSM_LAYOUT_FAST) the depths of one pixel over 256 views, within one
                cache line if they fit
     receiver   a point that may be lit, about which a query asks
     semi-local a light at a position outside the object's convex hull, answered by the maps of directions
     hull       the convex hull of the object, kept as a k-DOP (discrete oriented polytope): the solid between
                pairs of parallel planes, here of 13 fixed directions, that encloses the object

   How it works

   A pixel's depth z may be stored as any value in [z1, z2), since the comparison with a receiver on a surface
   comes out the same. For each pixel, the builder walks through the views and keeps one value as long as the
   value fits; this gives the least number of segments. A segment then takes 14 to 16 bits:

     lookup        4 bytes a pixel          directory     2 bytes a line, which has about 30 segments
     lines         64 bytes: where each segment begins (Elias-Fano), and its depth (8-bit grid, range or
                   palette)

   A block takes about 1.9 M^2 s bytes for s segments a pixel. s grows with about N^0.55 and with the object's
   detail: it is 345 for the bunny and 530 for the dragon at N = 128^2, M = 128. The knobs, and what each
   trades:

     side          Fewer directions make smaller blocks, but show as bands in penumbrae and as shadows that
                   jump while a light moves.
     map_side      Fewer pixels make smaller blocks, but jagged and widened contact shadows, and light leaks
                   through things thinner than a pixel. A face of a map of a position spans 90 degrees with M
                   pixels, so that few of them see a small object far from its light: make maps of directions
                   for such an object.
     layers        Z1Z2 is right everywhere. For closed objects, Z1Z3_SPHERE makes the block about half and
                   Z1Z3_FAR about a third as large, but both leak light onto receivers between the second and
                   the third surface, and Z1Z3_FAR also onto receivers behind the object.
     layout        FAST answers random queries 1.2 to 2 times as fast as COMPACT, since it decodes nothing. It
                   keeps trays of about 1.4 times the block's bytes beside the block.
     bias          Too little gives acne at grazing light, too much leaks light in corners. 1 pixel suits most
                   objects.
     filter        NEAREST is fastest, and jagged. PCF is smooth, and 10 times slower for maps of directions.
                   ROULETTE is as fast as NEAREST and has PCF's mean, but shows noise in place of jags.

   From the paper to the code

     section 3, figure 2    N maps of M x M pixels               cohsm_desc, cohsm_get_info           T63
     section 3.1, figure 3  a depth in [z1, z2) answers as z1    cohsm__interval                      T59, T71
     eq. (1), figure 4      segments: one depth for many maps    cohsm__compress_view, cohsm_verify   T59, T60
     section 3.1            z_avg; depths are linear             cohsm__choose_value, cohsm_depths    T59
     section 3.1            third layer, spherical far plane     cohsm_layers, cohsm__leave_depth     T62
     section 3.2, figure 6  project, find segment, compare       cohsm__project_point, cohsm__lit_at  T61, T66
     section 3.2            the search for a segment             cohsm__list_block, cohsm__block_find T59
     section 3.3, figure 5  six faces of a cube in one list      cohsm__face_of, cohsm__address       T70
     section 4              D, where the maps look from          cohsm_domain, cohsm__map_parameter   T73
     section 4.1            from a direction to its map          cohsm__domain_position               T64, T72
     section 4.2            lights at fixed positions            cohsm_light_kind, cohsm__address     T70, T73
     section 4.3, figure 7  lights outside the convex hull       cohsm__light_refused,                T67, T68
                                                                 cohsm__hull_between
     section 4.4            the domain in N even cells           cohsm__cell_location                 T64, T73
     section 4.4, figure 8  scan-line, zig-zag, Hilbert          cohsm__order_cells,                  T65
                                                                 cohsm__place_of_cell
     section 4.5, figure 9  filtering, Russian roulette          cohsm__pcf, cohsm__jitter            T69
     section 4.6, figure 10 several objects, D times T^-1        cohsm_visible_scene,                 T62, T66
                                                                 cohsm__load_tile
     section 4.6            receivers that have no maps          cohsm_visible_scene, entities of     T62
                                                                 cohsm_query
     section 5, visibility  lookup texture and lists             cohsm__lay_list, cohsm__search_tile  T59
     section 5, the rest    the estimator                        in lightsampling.h                   -
     section 6, quality     the bias                             cohsm_query                          T71
     section 6, figure 13   what N and M leave of the truth      cohsm_desc, cohsm_visible            T72,
                                                                                                 furnace
     section 7              adaptive sampling: fewer places      cohsm_places_choose                  T70
     table 1                compression rates                    cohsm_get_info                       T63
     table 2                queries a second                     cohsm_visible, cohsm_layout          -

   The last column names the rows of docs/conformance.md that test a line; a - says that there is none.
   docs/csm.md says where the code departs from the paper, and why.

   Configuration

     CSM_IMPLEMENTATION   in one source file: compiles the code
     COHSM_STATIC         beside it: a private copy for this file, all functions static
     COHSM_DEF            everywhere: your own linkage instead
     COHSM_NO_SIMD        with the implementation: portable code only (results are the same)
     COHSM_FILE           with the implementation: this file's name, if it is not "csm.h". The file includes
                          itself to compile the kernels for AVX2 and AVX-512, and does without these kernels
                          if __has_include does not find it

   In the repository, make join csm.h WITHOUT="build" writes this header without the precomputation, for
   programs that only open files and ask; WITHOUT="all" leaves out all that is optional, such as packed
   files, streams of objects and intrinsics (src/README.md).

   Memory, errors, threads, determinism

   All memory comes from the allocator of cohsm_system, called from the thread that called us. Maps and
   builders keep allocator, log and user of the system that they were made with: these must live as long.
   Every function that can fail returns a cohsm_result; if the result is not COHSM_OK, outputs are untouched
   and nothing leaks. The log says why a call failed, unless the maps, the builder or the desc that hold it
   are NULL. There are no globals: any number of threads may query the same maps; a builder or a stream of
   objects belongs to one thread at a time. Blocks built from the same input have the same bytes on every
   compiler, processor, byte order and thread count (not with x87 arithmetic, nor with clang's -ffast-math).

   Cost: docs/csm.md and build/bench csm_query.   History: CHANGELOG.md.   Licence: end of this file. */
#ifndef CSM_H
#define CSM_H

#define COHSM_VERSION 10000 /* major * 10000 + minor * 100 + patch */

#if !defined(__cplusplus) && !defined(_MSC_VER) && (!defined(__STDC_VERSION__) || __STDC_VERSION__ < 199901L)
#error "csm.h needs C99 or C++11"
#endif
#if defined(COHSM_STATIC) && !defined(CSM_IMPLEMENTATION)
#error "COHSM_STATIC makes all functions private: CSM_IMPLEMENTATION belongs into the same file"
#endif

#include <stddef.h>
#include <stdint.h>

#ifndef COHSM_DEF
#ifdef COHSM_STATIC
#define COHSM_DEF static inline
#else
#define COHSM_DEF extern
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif
