/* picture.h - a picture for tests of gifilter.h: planes at two depths with bumps, holes, places that are none and light
   that is none; and ways to move before it. */
#ifndef GIFILTER_PICTURE_H
#define GIFILTER_PICTURE_H

#include <math.h>
#include <string.h>
/* The picture's own sums and quotients are the same by every compiler too. */
#include "src/shared/fp_begin.h"

enum { PICTURE_W = 150, PICTURE_H = 21, PICTURE = PICTURE_W * PICTURE_H };

/* 0..1, of three numbers. */
static float picture_random(uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t h = (a * 0x9e3779b1u ^ b * 0x85ebca77u) + c * 0xc2b2ae3du;
    h ^= h >> 15;
    h *= 0x2c1b3c6du;
    h ^= h >> 12;
    h *= 0x297a2d39u;
    h ^= h >> 15;
    return (float)(h >> 8) / 16777216.0f;
}

static void picture_make(float *places, float *facing, float *light)
{
    static const float bumps[4][3] = { { 0, 0, 1 }, { 0.28f, 0, 0.96f }, { 0.15f, 0.1f, 0.98f }, { 0, 0.8f, 0.6f } };
    uint32_t i;
    for (i = 0; i < PICTURE; i++) {
        uint32_t x = i % PICTURE_W, y = i / PICTURE_W;
        float *p = places + 3 * i, *n = facing + 3 * i;
        p[0] = ((float)x + 0.5f) / PICTURE_W * 2 - 1;
        p[1] = 1 - ((float)y + 0.5f) / PICTURE_H * 2;
        p[2] = x > 90 ? 0.4f : 0.01f * picture_random(1, 1, i);
        memcpy(n, bumps[(uint32_t)(3 * picture_random(1, 2, i))], sizeof bumps[0]);
        if (x % 40 == 7) memcpy(n, bumps[3], sizeof bumps[3]);
        if (x > 120 && y < 4) memset(n, 0, sizeof bumps[0]);
        light[3 * i] = light[3 * i + 1] = picture_random(1, 3, i);
        light[3 * i + 2] = i == 77 ? NAN : picture_random(1, 4, i);
    }
    places[3 * 160] = 2e9f;
    facing[3 * 500 + 1] = NAN;
}

/* What a frame is filtered with. way: 0 a camera that stands still, 1 that turns a little, 2 that comes so near that
   neighbours were not neighbours, 3 motion without rule. */
static void picture_frame(int way, uint32_t frame, float matrix[16], float *motion, gifilt_frame *d)
{
    static const float still[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    float f = way ? (float)frame : 0;
    uint32_t i;
    memcpy(matrix, still, sizeof still);
    matrix[0] = matrix[5] = way == 2 ? 1 + 0.8f * f : 1 + 0.0008f * f;
    matrix[12] = 0.0063f * f;
    matrix[13] = 0.021f * f;
    for (i = 0; way == 3 && i < 2 * PICTURE; i++)
        motion[i] =
            (float)(i % 2 ? i / 2 / PICTURE_W : i / 2 % PICTURE_W) + 4 * picture_random(frame, 5, i) - 2;
    memset(d, 0, sizeof *d);
    d->world_to_clip = matrix;
    d->rows = GIFILT_ROWS_TOP_FIRST;
    d->motion = way == 3 ? motion : NULL;
    d->passes = frame ? (int)frame : -1;
}

#include "src/shared/fp_end.h"
#endif
