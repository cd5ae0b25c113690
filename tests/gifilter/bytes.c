/* bytes - hashes of pictures that gifilter.h has filtered over frames: the same on every compiler, option and byte
   order. */

#define GIFILTER_IMPLEMENTATION
#include "gifilter.h"

#include <stdio.h>

#include "picture.h"

/* Values, not memory: the same for both byte orders. */
static uint32_t bytes_hash(const float *values, size_t count)
{
    uint32_t h = 2166136261u, bits, k;
    size_t i;
    for (i = 0; i < count; i++) {
        memcpy(&bits, values + i, sizeof bits);
        for (k = 0; k < 4; k++) h = (h ^ (bits >> 8 * k & 255u)) * 16777619u;
    }
    return h;
}

/* 0: written. */
static int bytes_lines(FILE *lines)
{
    static float places[3 * PICTURE], facing[3 * PICTURE], light[3 * PICTURE], motion[2 * PICTURE], out[3 * PICTURE];
    gifilt_points points;
    gifilt_desc size;
    int way;
    picture_make(places, facing, light);
    memset(&points, 0, sizeof points);
    memset(&size, 0, sizeof size);
    size.width = PICTURE_W;
    size.height = PICTURE_H;
    points.count = PICTURE;
    points.positions = places;
    points.normals = facing;
    for (way = 0; way < 4; way++) {
        gifilt_filter *filter;
        gifilt_frame settings;
        float matrix[16];
        uint32_t frame;
        if (gifilt_create(&size, &filter) != GIFILT_OK) return 1;
        for (frame = 0; frame < 4; frame++) {
            picture_frame(way, frame, matrix, motion, &settings);
            if (gifilt_apply(filter, &settings, &points, light, out) != GIFILT_OK) return 1;
            fprintf(lines, "filter %d %u %08x\n", way, (unsigned)frame, (unsigned)bytes_hash(out, 3 * PICTURE));
        }
        gifilt_free(filter);
    }
    return 0;
}

#ifndef GIFILTER_BYTES_NO_MAIN
int main(void) { return bytes_lines(stdout); }
#endif
