/* image.c - float images: PFM by hand, PNG through ex_png_write, half floats in a PNG, exposure. */
#include "internal.h"
#include <stdlib.h>
#include <string.h>

#define MAX_SIDE 32768u

int ex_image_alloc(ex_image *image, uint32_t width, uint32_t height)
{
    memset(image, 0, sizeof *image);
    if (width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE) return -1;
    image->rgb = (float *)calloc((size_t)width * height, 3 * sizeof(float));
    if (!image->rgb) return -1;
    image->width = width;
    image->height = height;
    return 0;
}

void ex_image_free(ex_image *image)
{
    free(image->rgb);
    memset(image, 0, sizeof *image);
}

static int has_suffix(const char *path, const char *suffix)
{
    size_t n = strlen(path), m = strlen(suffix);
    return n > m && strcmp(path + n - m, suffix) == 0;
}

/* Little-endian floats whatever the machine. */
static void put_float(uint8_t *out, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, 4);
    for (int i = 0; i < 4; i++) out[i] = (uint8_t)(bits >> (8 * i));
}

static float get_float(const uint8_t *in, int little)
{
    uint32_t bits = 0;
    for (int i = 0; i < 4; i++) bits |= (uint32_t)in[little ? i : 3 - i] << (8 * i);
    float value;
    memcpy(&value, &bits, 4);
    return value;
}

static int write_pfm(const ex_image *image, const char *path, char *error)
{
    size_t row_floats = 3 * (size_t)image->width;
    uint8_t *row = (uint8_t *)malloc(4 * row_floats);
    FILE *file = row ? fopen(path, "wb") : NULL;
    if (!file) {
        free(row);
        return ex_fail(error, "%s: cannot write", path);
    }
    int ok = fprintf(file, "PF\n%u %u\n-1.0\n", (unsigned)image->width, (unsigned)image->height) > 0;
    for (uint32_t y = image->height; ok && y-- > 0;) {
        const float *from = image->rgb + y * row_floats;
        for (size_t i = 0; i < row_floats; i++) put_float(row + 4 * i, from[i]);
        ok = fwrite(row, 4, row_floats, file) == row_floats;
    }
    free(row);
    if (fclose(file) != 0) ok = 0;
    return ok ? 0 : ex_fail(error, "%s: write failed", path);
}

static uint8_t to_srgb8(float x)
{
    if (!(x > 0)) return 0;              /* catches NaN too */
    if (x >= 1) return 255;
    float s = x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1 / 2.4f) - 0.055f;
    return (uint8_t)(255 * s + 0.5f);
}

static int write_png(const ex_image *image, const char *path, float ev, char *error)
{
    size_t count = 3 * (size_t)image->width * image->height;
    float gain = exp2f(ev);
    uint8_t *bytes = (uint8_t *)malloc(count);
    if (!bytes) return ex_fail(error, "%s: out of memory", path);
    for (size_t i = 0; i < count; i++) bytes[i] = to_srgb8(gain * image->rgb[i]);
    int result = ex_png_write(path, image->width, image->height, bytes, error);
    free(bytes);
    return result;
}

/* The nearest half float, of a value that is not negative: what is less than half of the smallest becomes 0, what is
   too large the largest, and so does not-a-number. */
static uint16_t to_half(float value)
{
    uint32_t bits, exponent, shift;
    if (value < 0) return 0;
    if (!(value < 65504.0f)) return 0x7bff;
    memcpy(&bits, &value, 4);
    exponent = bits >> 23;
    if (exponent < 102) return 0;
    if (exponent >= 113) return (uint16_t)((bits - (112u << 23) + 0xfff + (bits >> 13 & 1)) >> 13);
    shift = 126 - exponent;              /* without the leading one of others: multiples of 2^-24 */
    bits = (bits & 0x7fffff) | 0x800000;
    return (uint16_t)((bits + (1u << (shift - 1)) - 1 + (bits >> shift & 1)) >> shift);
}

static float from_half(uint16_t half)
{
    return half < 0x400 ? ldexpf((float)half, -24)
                        : ldexpf((float)(0x400 | (half & 0x3ff)), (half >> 10) - 25);
}

static int write_half(const ex_image *image, const char *path, char *error)
{
    size_t count = 3 * (size_t)image->width * image->height, size = 0;
    uint8_t *bytes = (uint8_t *)malloc(2 * count), *png;
    for (size_t i = 0; bytes && i < count; i++) {
        uint16_t half = to_half(image->rgb[i]);
        bytes[2 * i] = (uint8_t)(half >> 8);
        bytes[2 * i + 1] = (uint8_t)half;
    }
    png = bytes ? (uint8_t *)ex_png_encode(image->width, image->height, 3, 16, bytes, &size) : NULL;
    free(bytes);
    FILE *file = png ? fopen(path, "wb") : NULL;
    int ok = file && fwrite(png, 1, size, file) == size;
    if (file && fclose(file) != 0) ok = 0;
    free(png);
    return ok ? 0 : ex_fail(error, "%s: cannot write", path);
}

int ex_image_read_half(ex_image *image, const char *path, char *error)
{
    uint32_t width, height;
    uint16_t *halves;
    memset(image, 0, sizeof *image);
    if (ex_stb_read_png16(path, &width, &height, &halves, error) != 0) return -1;
    if (ex_image_alloc(image, width, height) != 0) {
        free(halves);
        return ex_fail(error, "%s: out of memory", path);
    }
    for (size_t i = 0; i < 3 * (size_t)width * height; i++) {
        if (halves[i] > 0x7bff) {
            ex_image_free(image);
            free(halves);
            return ex_fail(error, "%s: a value is no half float of 0 to 65504", path);
        }
        image->rgb[i] = from_half(halves[i]);
    }
    free(halves);
    return 0;
}

int ex_image_write(const ex_image *image, const char *path, float ev, char *error)
{
    if (!image->rgb || image->width == 0 || image->height == 0) return ex_fail(error, "%s: empty image", path);
    if (has_suffix(path, ".pfm")) return write_pfm(image, path, error);
    if (has_suffix(path, ".half.png")) return write_half(image, path, error);
    if (has_suffix(path, ".png")) return write_png(image, path, ev, error);
    return ex_fail(error, "%s: the name must end in .png or .pfm", path);
}

/* "PF", width, height and scale, each followed by white space, exactly one before the data. */
static int read_pfm_header(FILE *file, unsigned *width, unsigned *height, int *little)
{
    char magic[3], scale_text[32];
    if (fscanf(file, "%2s %9u %9u %31s", magic, width, height, scale_text) != 4) return -1;
    float scale = strtof(scale_text, NULL);
    int space = fgetc(file);
    if (strcmp(magic, "PF") != 0 || !(fabsf(scale) > 0) || (space != '\n' && space != ' ' && space != '\t')) return -1;
    *little = scale < 0;
    return 0;
}

int ex_image_read_pfm(ex_image *image, const char *path, char *error)
{
    unsigned width = 0, height = 0;
    int little = 1, ok = 0;
    memset(image, 0, sizeof *image);
    FILE *file = fopen(path, "rb");
    if (!file) return ex_fail(error, "%s: cannot open", path);
    if (read_pfm_header(file, &width, &height, &little) != 0) {
        fclose(file);
        return ex_fail(error, "%s: not a colour PFM file", path);
    }
    size_t row_floats = 3 * (size_t)width;
    uint8_t *row = NULL;
    if (ex_image_alloc(image, width, height) == 0) row = (uint8_t *)malloc(4 * row_floats);
    if (!row) {
        fclose(file);
        ex_image_free(image);
        return ex_fail(error, "%s: %u x %u pixels are too many or none", path, width, height);
    }
    for (uint32_t y = height; y-- > 0;) {
        ok = fread(row, 4, row_floats, file) == row_floats;
        if (!ok) break;
        for (size_t i = 0; i < row_floats; i++) image->rgb[y * row_floats + i] = get_float(row + 4 * i, little);
    }
    free(row);
    fclose(file);
    if (ok) return 0;
    ex_image_free(image);
    return ex_fail(error, "%s: shorter than its header says", path);
}

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

float ex_image_auto_ev(const ex_image *image)
{
    size_t count = (size_t)image->width * image->height, lit = 0;
    float *luminance = (float *)malloc((count ? count : 1) * sizeof *luminance);
    if (!luminance) return 0;
    for (size_t i = 0; i < count; i++) {
        const float *p = image->rgb + 3 * i;
        float y = 0.2126f * p[0] + 0.7152f * p[1] + 0.0722f * p[2];
        if (y > 0 && isfinite(y)) luminance[lit++] = y;
    }
    float ev = 0;
    if (lit > 0) {
        qsort(luminance, lit, sizeof *luminance, compare_floats);
        ev = log2f(0.9f / luminance[(lit - 1) * 98 / 100]);
    }
    free(luminance);
    return ev;
}
