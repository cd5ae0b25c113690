/* png.c - 8-bit RGB PNG: compressed by stb_image_write where it was found, else in stored blocks by the few lines here,
   so that a machine with nothing but a compiler still gets pictures out of `make demo`. Only .hdr input needs stb:
   there this file says so. */
#include "gltf.h"
#include "internal.h"
#include <stdlib.h>
#include <string.h>

#if defined(DAPPLE_HAVE_STB) && DAPPLE_HAVE_STB

/* Static copies of both headers: works with Debian's libstb-dev as with the single files, and never meets the copy
   inside tinygltf at link time. */
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-function"      /* decided at the end of the file, so not inside the push */
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wcast-qual"
#pragma GCC diagnostic ignored "-Wdouble-promotion"
#pragma GCC diagnostic ignored "-Wundef"
#endif
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_HDR
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#if defined(__has_include)
#if __has_include(<stb/stb_image.h>)
#define EX_STB_FOLDER 1
#endif
#endif
#ifdef EX_STB_FOLDER
#include <stb/stb_image.h>
#include <stb/stb_image_write.h>
#else
#include <stb_image.h>
#include <stb_image_write.h>
#endif
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

int ex_png_write(const char *path, uint32_t width, uint32_t height, const uint8_t *rgb, char *error)
{
    if (stbi_write_png(path, (int)width, (int)height, 3, rgb, (int)(3 * width))) return 0;
    return ex_fail(error, "%s: cannot write", path);
}

int ex_stb_read_hdr(const char *path, uint32_t *width, uint32_t *height, float **rgb, char *error)
{
    int w = 0, h = 0, channels = 0;
    if (ex_hdr_check(path, error) != 0) return -1;
    float *pixels = stbi_loadf(path, &w, &h, &channels, 3);
    if (!pixels) return ex_fail(error, "%s: %s", path, stbi_failure_reason());
    *width = (uint32_t)w;
    *height = (uint32_t)h;
    *rgb = pixels;                       /* stb allocates with malloc */
    return 0;
}

double ex_picture_bytes(const void *data, size_t size)
{
    int w = 0, h = 0, channels = 0, bytes = (int)(size < 0x7fffffff ? size : 0x7fffffff);
    if (!stbi_info_from_memory((const stbi_uc *)data, bytes, &w, &h, &channels)) return 0;
    return (stbi_is_16_bit_from_memory((const stbi_uc *)data, bytes) ? 8.0 : 4.0) * w * h;
}

#else

static uint32_t crc32_of(uint32_t crc, const uint8_t *bytes, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) crc = (crc >> 1) ^ (0xedb88320u & (0u - (crc & 1)));
    }
    return crc;
}

static void put_u32(uint8_t *out, uint32_t v)
{
    for (int i = 0; i < 4; i++) out[i] = (uint8_t)(v >> (24 - 8 * i));
}

static int put_chunk(FILE *file, const char *type, const uint8_t *data, uint32_t size)
{
    uint8_t head[8], tail[4];
    put_u32(head, size);
    memcpy(head + 4, type, 4);
    put_u32(tail, ~crc32_of(crc32_of(~0u, head + 4, 4), data, size));
    return fwrite(head, 1, 8, file) == 8 && fwrite(data, 1, size, file) == size && fwrite(tail, 1, 4, file) == 4;
}

/* zlib stream of the filter bytes and pixels in stored blocks of at most 65,535 bytes. */
static uint8_t *store_rows(uint32_t width, uint32_t height, const uint8_t *rgb, size_t *size)
{
    size_t row = 1 + 3 * (size_t)width, raw_size = row * height, blocks = raw_size / 65535 + 1, at = 2;
    uint8_t *raw = (uint8_t *)malloc(raw_size), *out = (uint8_t *)malloc(raw_size + 5 * blocks + 6);
    if (!raw || !out) { free(raw); free(out); return NULL; }
    uint32_t a = 1, b = 0;
    for (uint32_t y = 0; y < height; y++) {
        raw[y * row] = 0;
        memcpy(raw + y * row + 1, rgb + y * (row - 1), row - 1);
    }
    for (size_t i = 0; i < raw_size; i++) { a = (a + raw[i]) % 65521; b = (b + a) % 65521; }
    out[0] = 0x78;
    out[1] = 0x01;
    for (size_t i = 0; i < raw_size; i += 65535) {
        uint32_t n = raw_size - i < 65535 ? (uint32_t)(raw_size - i) : 65535u;
        out[at++] = i + n == raw_size;
        out[at++] = (uint8_t)n;
        out[at++] = (uint8_t)(n >> 8);
        out[at++] = (uint8_t)~n;
        out[at++] = (uint8_t)(~n >> 8);
        memcpy(out + at, raw + i, n);
        at += n;
    }
    put_u32(out + at, b << 16 | a);
    free(raw);
    *size = at + 4;
    return out;
}

int ex_png_write(const char *path, uint32_t width, uint32_t height, const uint8_t *rgb, char *error)
{
    static const uint8_t magic[8] = {137, 'P', 'N', 'G', '\r', '\n', 26, '\n'};
    uint8_t header[13] = {0, 0, 0, 0, 0, 0, 0, 0, 8, 2, 0, 0, 0};    /* 8 bits a channel, RGB */
    size_t size = 0;
    uint8_t *data = store_rows(width, height, rgb, &size);
    FILE *file = data && size <= 0x7fffffff ? fopen(path, "wb") : NULL;
    if (!file) { free(data); return ex_fail(error, "%s: cannot write", path); }
    put_u32(header, width);
    put_u32(header + 4, height);
    int ok = fwrite(magic, 1, 8, file) == 8 && put_chunk(file, "IHDR", header, 13) &&
             put_chunk(file, "IDAT", data, (uint32_t)size) && put_chunk(file, "IEND", header, 0);
    if (fclose(file) != 0) ok = 0;
    free(data);
    return ok ? 0 : ex_fail(error, "%s: write failed", path);
}

int ex_stb_read_hdr(const char *path, uint32_t *width, uint32_t *height, float **rgb, char *error)
{
    (void)width; (void)height; (void)rgb;
    return ex_fail(error, "%s: built without stb (Debian: libstb-dev), so .hdr skies cannot be read", path);
}

#endif
