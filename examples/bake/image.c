/* image.c - see model.h: texels of a sheet become a picture. */
#include "gifilter.h"
#include "model.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* One channel through the filter over neighbours, which stops at edges and at borders of charts. */
static int denoise(const bk_receivers *r, const bk_sheet *s, float *texels, const uint8_t *covered, int passes)
{
    const size_t count = (size_t)s->side * s->side;
    float *data = calloc(9 * count, sizeof *data), *light = data ? data + 6 * count : NULL;
    const gifilt_points points = { count, data, 0, data ? data + 3 * count : NULL, 0 };
    gifilt_frame frame;
    gifilt_desc desc;
    gifilt_filter *filter = NULL;
    gifilt_result result = data ? GIFILT_OK : GIFILT_ERR_ALLOC;
    memset(&frame, 0, sizeof frame);
    memset(&desc, 0, sizeof desc);
    desc.width = desc.height = s->side;
    frame.history = 1;
    frame.passes = passes;
    for (size_t i = 0; i < s->count && data; i++) {
        const size_t at = r->places[s->first + i];
        memcpy(data + 3 * at, r->positions + 3 * (s->first + i), 12);
        memcpy(data + 3 * (count + at), r->normals + 3 * (s->first + i), 12);
    }
    for (size_t i = 0; i < 3 * count && data; i++)
        light[i] = texels[i / 3];
    if (result == GIFILT_OK)
        result = gifilt_create(&desc, &filter);
    if (result == GIFILT_OK)
        result = gifilt_apply(filter, &frame, &points, light, light);
    for (size_t i = 0; i < count && result == GIFILT_OK; i++)
        texels[i] = covered[i] ? light[3 * i] : 0;
    gifilt_free(filter);
    free(data);
    return result == GIFILT_OK ? 0 : -1;
}

/* The mean of the covered texels around one that is not; returns 0 where there is none. */
static int mean_around(const float *texels, const uint8_t *covered, uint32_t side, int channels, uint32_t x, uint32_t y,
                       float *out)
{
    int count = 0;
    for (int k = 0; k < channels; k++)
        out[k] = 0;
    for (uint32_t v = y ? y - 1 : 0; v <= y + 1 && v < side; v++)
        for (uint32_t u = x ? x - 1 : 0; u <= x + 1 && u < side; u++) {
            const size_t at = (size_t)v * side + u;
            if (covered[at] != 1)
                continue;
            for (int k = 0; k < channels; k++)
                out[k] += texels[(size_t)channels * at + (size_t)k];
            count++;
        }
    for (int k = 0; k < channels && count; k++)
        out[k] /= (float)count;
    return count;
}

/* Charts grow by one texel a round. */
static void dilate(float *texels, uint8_t *covered, uint32_t side, int channels, int rounds)
{
    const size_t count = (size_t)side * side;
    for (int round = 0; round < rounds; round++) {
        size_t grown = 0;
        for (uint32_t y = 0; y < side; y++)
            for (uint32_t x = 0; x < side; x++) {
                const size_t at = (size_t)y * side + x;
                if (!covered[at] &&
                    mean_around(texels, covered, side, channels, x, y, texels + (size_t)channels * at)) {
                    covered[at] = 2;
                    grown++;
                }
            }
        for (size_t i = 0; i < count; i++)
            covered[i] = covered[i] != 0;
        if (!grown)
            return;
    }
}

float *bk_image_fill(const bk_receivers *r, const bk_sheet *s, const float *values, int channels,
                     const bk_image_desc *desc)
{
    const size_t count = (size_t)s->side * s->side, n = (size_t)channels;
    float *texels = calloc(n * count + 1, sizeof *texels);
    uint8_t *covered = calloc(count + 1, 1);
    double mean[4] = { 0, 0, 0, 0 };
    int good = texels && covered;
    for (size_t i = 0; i < s->count && good; i++)
        for (size_t k = 0; k < n; k++) {
            texels[n * r->places[s->first + i] + k] = values[n * i + k];
            covered[r->places[s->first + i]] = 1;
            mean[k] += (double)values[n * i + k] / (double)s->count;
        }
    if (good && desc->denoise && channels == 1)
        good = denoise(r, s, texels, covered, desc->denoise) == 0;
    if (good)
        dilate(texels, covered, s->side, channels, desc->dilate);
    for (size_t i = 0; i < n * count && good; i++)
        if (!covered[i / n])
            texels[i] = (float)mean[i % n];
    free(covered);
    if (good)
        return texels;
    free(texels);
    return NULL;
}

void *bk_image_png(const float *values, uint32_t side, int channels, int bits, size_t *size)
{
    const size_t count = (size_t)channels * side * side, bytes = (size_t)bits / 8;
    const float most = bits == 8 ? 255 : 65535;
    uint8_t *pixels = malloc(bytes * count + 1);
    void *png;
    if (!pixels)
        return NULL;
    for (size_t i = 0; i < count; i++) {
        const uint32_t x = (uint32_t)(fminf(fmaxf(values[i], 0), 1) * most + 0.5f);
        for (size_t k = 0; k < bytes; k++)               /* PNG has the high byte first */
            pixels[bytes * i + k] = (uint8_t)(x >> (8 * (bytes - 1 - k)));
    }
    png = ex_png_encode(side, side, (uint32_t)channels, (uint32_t)bits, pixels, size);
    free(pixels);
    return png;
}
