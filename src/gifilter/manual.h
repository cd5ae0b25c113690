/* gifilter.h - v1.0.0 - noisy pictures of light made smooth over frames and neighbours - MIT-0 OR Unlicense

   What it does

   This header smooths noisy pictures of light, such as bounced light from few samples. It takes one picture
   each frame, with the place and the normal of what every pixel shows. It first adds what the frames before
   knew of the same surfaces (temporal accumulation with reprojection), and then takes means of neighbours on
   the same surface (the a-trous filter of Dammertz, Sewtz, Hanika and Lensch, "Edge-Avoiding A-Trous Wavelet
   Transform for fast Global Illumination Filtering", HPG 2010). The light may come from rsm.h with few
   samples, from ism.h with few lights, or from a path tracer.

   What it does not do

   - Textures would be blurred: give the light (irradiance), and multiply by the albedo afterwards.
   - Motion is not looked for: surfaces are found in the last frame by that frame's matrix, or where you say.
   - The header renders no pictures, starts no threads and opens no files.

   Quick start

   In exactly one source file write the define; everywhere else include the header alone.

       #define GIFILTER_IMPLEMENTATION
       #include "gifilter.h"
       #include <stdio.h>

       enum { W = 64, H = 48, FRAMES = 8 };
       static float positions[3 * W * H], normals[3 * W * H], light[3 * W * H];

       int main(void)
       {
           // The camera looks along -z at a wall, which covers the picture: clip x and y are the world's.
           static const float world_to_clip[16] = { 1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1 };
           static gifilt_desc size;                         // static: all zero, the defaults
           static gifilt_frame settings;
           static gifilt_points points;
           gifilt_filter *filter;
           uint32_t random = 1;
           double before = 0, after = 0;
           int frame, i;

           for (i = 0; i < W * H; i++) {
               positions[3 * i] = ((float)(i % W) + 0.5f) * 2.0f / W - 1.0f;
               positions[3 * i + 1] = ((float)(i / W) + 0.5f) * 2.0f / H - 1.0f;
               normals[3 * i + 2] = 1;
           }
           points.count = W * H;
           points.positions = positions;
           points.normals = normals;
           settings.world_to_clip = world_to_clip;
           size.width = W;
           size.height = H;
           if (gifilt_create(&size, &filter) != GIFILT_OK) return 1;
           for (frame = 0; frame < FRAMES; frame++) {
               before = after = 0;
               for (i = 0; i < 3 * W * H; i++) {             // the light is 1; a sample is 0 to 2
                   random = random * 1664525u + 1013904223u;
                   light[i] = (float)(random >> 8) / 8388608.0f;
                   before += ((double)light[i] - 1) * ((double)light[i] - 1);
               }
               if (gifilt_apply(filter, &settings, &points, light, light) != GIFILT_OK) return 1;
               for (i = 0; i < 3 * W * H; i++) after += ((double)light[i] - 1) * ((double)light[i] - 1);
           }
           printf("variance %.4f, filtered %.4f\n", before / (3 * W * H), after / (3 * W * H));
           gifilt_free(filter);
           return !(after < 0.05 * before);
       }

   Conventions

   Space is right-handed. Matrices are column-major float[16]. Distances are in your units. Colours are
   linear, three floats r, g, b. Pictures lie row by row; gifilt_frame.rows says which row comes first.
   Normals called unit may be 0.97 to 1.03 long and are used as they are; any other length is an error, but
   for 0 0 0 and normals that are not finite, whose pixels show nothing.

   How it works

     gifilt_create -> each frame: gifilt_apply -> ... -> gifilt_free;  after a cut: gifilt_reset

   gifilt_apply, step by step:

     - Each pixel's place is projected by the last frame's matrix, or moved by the pixel's motion. The four
       pixels of the last frame about that point count, with bilinear weights, if they show the same surface:
       not farther away than four of this frame's pixels are wide, not off the plane, with a like normal.
     - The light that those pixels knew is mixed with the new light, which counts as 1 of n frames; n grows
       by 1 each frame, up to the frame's history.
     - Each pass takes the mean of 3 x 3 pixels, which are 1 pixel apart in the first pass, 2 in the second, 4
       in the third. Their weights are 1 2 1 by 1 2 1, times a factor from 0 to 1 that says whether they show
       the same surface.

   A filter takes 80 bytes a pixel and 4 KB a row; gifilt_apply allocates nothing. The knobs, and what each
   trades:

     history    more: less noise, and light that moves lags behind. 8 is mostly enough
     passes     more: less noise, and light is blurred where it falls off beside corners. 1 or 2 are mostly
                enough
     normal_cosine   more: edges and fine shapes stay sharp, and fewer neighbours help
     plane_slope     less: as with more normal_cosine, for neighbours that lie before or behind the surface

   From the paper to the code

     section 2    a kernel with holes, twice as wide in each pass     gifilt__smooth                    -
     section 2.1  weights that stop at edges of normals and depths    gifilt__alike                     -
     -            temporal accumulation with reprojection             gifilt__accumulate                -

   No row of docs/conformance.md belongs to a filter of pictures; tests/gifilter/sums_test.c computes all
   three anew in doubles. The knobs of the first two are passes, normal_cosine and plane_slope in
   gifilt_frame, that of the last one, which the paper does not have, is history.

   Where this departs from the paper

     - The kernel is 3 x 3 (1 2 1), not 5 x 5 (1 4 6 4 1): with two passes every one of 4 x 4 interleaved
       sample sets counts alike, with three of 8 x 8. A larger kernel costs three times as much.
     - Colours are not compared, since noise looks like an edge of light.
     - Weights fall to 0 at a cosine and at a slope off the plane, where the paper has exponentials.
     - A pixel with few neighbours like it is made no brighter than its brightest neighbour
       (docs/gifilter.md).

   Configuration

     GIFILTER_IMPLEMENTATION   in one source file: compiles the code
     GIFILT_STATIC             beside it: a private copy for this file, all functions static
     GIFILT_DEF                everywhere: your own linkage instead
     GIFILT_NO_SIMD            with the implementation: portable code only (results are the same to the bit)
     GIFILT_FILE               with the implementation: this file's name, if it is not "gifilter.h". The file
                               includes itself for AVX2 and AVX-512; where it cannot, it does without them

   Memory, errors, threads, determinism

   All memory comes from the allocator in the system, called from the thread that called us. Every function
   that can fail returns a gifilt_result. If the result is not GIFILT_OK, outputs are untouched, nothing
   leaks, and the system's log gets one line that names the field or element, its value and its range. Only a
   call whose desc or filter is NULL has no log. There are no globals; a filter belongs to one thread at a
   time. The same input gives the same bytes on every compiler, processor, byte order and thread count (not
   with x87 arithmetic, nor with clang's -ffast-math).

   Cost: docs/gifilter.md.   History: CHANGELOG.md.   Licence: end of this file. */
#ifndef GIFILTER_H
#define GIFILTER_H

#define GIFILT_VERSION 10000 /* major * 10000 + minor * 100 + patch */

#if !defined(__cplusplus) && !defined(_MSC_VER) && (!defined(__STDC_VERSION__) || __STDC_VERSION__ < 199901L)
#error "gifilter.h needs C99 or C++11"
#endif
#if defined(GIFILT_STATIC) && !defined(GIFILTER_IMPLEMENTATION)
#error "GIFILT_STATIC makes all functions private: GIFILTER_IMPLEMENTATION belongs into the same file"
#endif

#include <stddef.h>
#include <stdint.h>

#ifndef GIFILT_DEF
#ifdef GIFILT_STATIC
#define GIFILT_DEF static inline
#else
#define GIFILT_DEF extern
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif
