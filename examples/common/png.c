/* png.c - 8-bit RGB PNG: compressed by stb_image_write where it was found, else in stored blocks by the few lines here,
   so that a machine with nothing but a compiler still gets pictures out of `make demo`. Only .hdr input needs stb:
   there, and where a .half.png is to be read, this file says so. */
#include "gltf.h"
#include "internal.h"
#include <stdlib.h>
#include <string.h>

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

/* zlib stream of the rows, each of which a filter byte begins. */
static uint8_t *deflate_rows(uint8_t *raw, size_t size, size_t *out_size)
{
    int length = 0;
    uint8_t *out = size < 0x7fffffff ? stbi_zlib_compress(raw, (int)size, &length, 8) : NULL;
    *out_size = (size_t)length;
    return out;
}

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

int ex_stb_read_png16(const char *path, uint32_t *width, uint32_t *height, uint16_t **rgb, char *error)
{
    int w = 0, h = 0, channels = 0;
    if (!stbi_info(path, &w, &h, &channels)) return ex_fail(error, "%s: %s", path, stbi_failure_reason());
    if (channels != 3 || !stbi_is_16_bit(path)) return ex_fail(error, "%s: not a PNG of 3 channels of 16 bits", path);
    if ((double)w * h > 1 << 26) return ex_fail(error, "%s: %d x %d pixels are too many", path, w, h);
    *rgb = stbi_load_16(path, &w, &h, &channels, 3);
    if (!*rgb) return ex_fail(error, "%s: %s", path, stbi_failure_reason());
    *width = (uint32_t)w;
    *height = (uint32_t)h;
    return 0;
}

double ex_picture_bytes(const void *data, size_t size)
{
    int w = 0, h = 0, channels = 0, bytes = (int)(size < 0x7fffffff ? size : 0x7fffffff);
    if (!stbi_info_from_memory((const stbi_uc *)data, bytes, &w, &h, &channels)) return 0;
    return (stbi_is_16_bit_from_memory((const stbi_uc *)data, bytes) ? 8.0 : 4.0) * w * h;
}

#else

/* zlib stream of the rows, each of which a filter byte begins, in stored blocks of at most 65,535 bytes. */
static uint8_t *deflate_rows(uint8_t *raw, size_t raw_size, size_t *size)
{
    size_t blocks = raw_size / 65535 + 1, at = 2;
    uint8_t *out = (uint8_t *)malloc(raw_size + 5 * blocks + 6);
    if (!out) return NULL;
    uint32_t a = 1, b = 0;
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
    *size = at + 4;
    return out;
}

int ex_png_write(const char *path, uint32_t width, uint32_t height, const uint8_t *rgb, char *error)
{
    size_t size;
    void *data = ex_png_encode(width, height, 3, 8, rgb, &size);
    FILE *file = data ? fopen(path, "wb") : NULL;
    if (!file) { free(data); return ex_fail(error, "%s: cannot write", path); }
    int ok = fwrite(data, 1, size, file) == size;
    if (fclose(file) != 0) ok = 0;
    free(data);
    return ok ? 0 : ex_fail(error, "%s: write failed", path);
}

int ex_stb_read_hdr(const char *path, uint32_t *width, uint32_t *height, float **rgb, char *error)
{
    (void)width; (void)height; (void)rgb;
    return ex_fail(error, "%s: built without stb (Debian: libstb-dev), so .hdr skies cannot be read", path);
}

int ex_stb_read_png16(const char *path, uint32_t *width, uint32_t *height, uint16_t **rgb, char *error)
{
    (void)width; (void)height; (void)rgb;
    return ex_fail(error, "%s: built without stb (Debian: libstb-dev), so .half.png pictures cannot be read", path);
}

#endif

/* ---- PNG of 8 or 16 bits in memory ---- */

static uint8_t *put_chunk(uint8_t *to, const char *type, const uint8_t *data, size_t size)
{
    put_u32(to, (uint32_t)size);
    memcpy(to + 4, type, 4);
    if (size) memcpy(to + 8, data, size);
    put_u32(to + 8 + size, ~crc32_of(~0u, to + 4, size + 4));
    return to + size + 12;
}

/* Each row as differences from the row above, after the byte that says so: smooth pictures become small. */
static uint8_t *filter_rows(uint32_t height, size_t row, const uint8_t *pixels)
{
    uint8_t *raw = (uint8_t *)malloc((row + 1) * height + 1);
    for (uint32_t y = 0; raw && y < height; y++) {
        raw[y * (row + 1)] = 2;
        for (size_t i = 0; i < row; i++)
            raw[y * (row + 1) + 1 + i] = (uint8_t)(pixels[y * row + i] - (y ? pixels[(y - 1) * row + i] : 0));
    }
    return raw;
}

void *ex_png_encode(uint32_t width, uint32_t height, uint32_t channels, uint32_t bits, const uint8_t *pixels,
                    size_t *size)
{
    static const uint8_t magic[8] = {137, 'P', 'N', 'G', '\r', '\n', 26, '\n'}, colors[5] = {0, 0, 4, 2, 6};
    uint8_t header[13] = {0, 0, 0, 0, 0, 0, 0, 0, (uint8_t)bits, colors[channels], 0, 0, 0}, *out = NULL, *at;
    size_t row = (size_t)width * channels * bits / 8, length = 0;
    uint8_t *raw = filter_rows(height, row, pixels),
            *data = raw ? deflate_rows(raw, (row + 1) * height, &length) : NULL;
    put_u32(header, width);
    put_u32(header + 4, height);
    if (data && length <= 0x7fffffff) out = (uint8_t *)malloc(length + 8 + 3 * 12 + 13);
    if (out) {
        memcpy(out, magic, 8);
        at = put_chunk(out + 8, "IHDR", header, 13);
        at = put_chunk(at, "IDAT", data, length);
        at = put_chunk(at, "IEND", NULL, 0);
        *size = (size_t)(at - out);
    }
    free(raw);
    free(data);
    return out;
}
