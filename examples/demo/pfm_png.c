/* pfm_png.c - one PFM picture as a PNG of 8-bit sRGB: pfm_png IN.pfm OUT.png EV
   Stands alone, so that the demo needs no package; the PNG is not compressed. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint32_t crc_of(uint32_t crc, const uint8_t *data, size_t size)
{
    crc = ~crc;
    for (size_t i = 0; i < size; i++) {
        crc ^= data[i];
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

static void put_be(uint8_t *to, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        to[i] = (uint8_t)(value >> (24 - 8 * i) & 255);
}

/* data has 4 bytes of room for the type in front of it and 4 for the checksum behind. */
static void write_chunk(FILE *file, const char *type, uint8_t *data, size_t size)
{
    uint8_t length[4];
    put_be(length, (uint32_t)size);
    memcpy(data - 4, type, 4);
    put_be(data + size, crc_of(0, data - 4, size + 4));
    fwrite(length, 1, 4, file);
    fwrite(data - 4, 1, size + 8, file);
}

static uint8_t srgb(float linear, float scale)
{
    float x = linear * scale;
    x = x > 0 ? x < 1 ? x : 1 : 0;
    x = x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1 / 2.4f) - 0.055f;
    return (uint8_t)(255 * x + 0.5f);
}

/* zlib data of stored blocks, one for each row. */
static size_t fill_rows(uint8_t *to, const float *rgb, size_t width, size_t height, float scale)
{
    uint32_t a = 1, b = 0;
    uint8_t *at = to;
    *at++ = 0x78, *at++ = 0x01;
    for (size_t y = 0; y < height; y++) {
        size_t size = 3 * width + 1;
        *at++ = y + 1 == height;
        *at++ = (uint8_t)(size & 255), *at++ = (uint8_t)(size >> 8);
        *at++ = (uint8_t)(~size & 255), *at++ = (uint8_t)(~size >> 8 & 255);
        for (size_t i = 0; i < size; i++) {
            at[i] = i ? srgb(rgb[3 * width * (height - 1 - y) + i - 1], scale) : 0;
            a = (a + at[i]) % 65521;
            b = (b + a) % 65521;
        }
        at += size;
    }
    put_be(at, b << 16 | a);
    return (size_t)(at + 4 - to);
}

static float *read_pfm(const char *path, unsigned *width, unsigned *height)
{
    FILE *file = fopen(path, "rb");
    float scale, *rgb = NULL;
    if (file && fscanf(file, "PF %u %u %f", width, height, &scale) == 3 && fgetc(file) == '\n' && *width &&
        *height && *width <= 20000 && *height <= 20000 && scale < 0) {
        size_t values = (size_t)3 * *width * *height;
        rgb = malloc(values * sizeof *rgb);
        if (rgb && fread(rgb, sizeof *rgb, values, file) != values) {
            free(rgb);
            rgb = NULL;
        }
    }
    if (file)
        fclose(file);
    return rgb;
}

static int write_png(const char *path, const float *rgb, unsigned width, unsigned height, float scale)
{
    static const uint8_t signature[8] = { 0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n' };
    uint8_t *memory = malloc((size_t)height * (3 * (size_t)width + 6) + 32), *data = memory ? memory + 4 : NULL;
    FILE *file = memory ? fopen(path, "wb") : NULL;
    if (!file) {
        free(memory);
        return -1;
    }
    fwrite(signature, 1, sizeof signature, file);
    memset(data, 0, 13);
    put_be(data, width);
    put_be(data + 4, height);
    data[8] = 8;                 /* bits */
    data[9] = 2;                 /* RGB */
    write_chunk(file, "IHDR", data, 13);
    write_chunk(file, "IDAT", data, fill_rows(data, rgb, width, height, scale));
    write_chunk(file, "IEND", data, 0);
    free(memory);
    return fclose(file) == 0 ? 0 : -1;
}

int main(int count, char **values)
{
    unsigned width, height;
    float *rgb = count == 4 ? read_pfm(values[1], &width, &height) : NULL;
    int result = rgb ? write_png(values[2], rgb, width, height, powf(2, strtof(values[3], NULL))) : -1;
    free(rgb);
    if (result != 0)
        fprintf(stderr, "pfm_png: usage: pfm_png IN.pfm OUT.png EV, or a file cannot be read or written\n");
    return result != 0;
}
