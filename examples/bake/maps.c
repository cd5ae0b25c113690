/* maps.c - see model.h: light maps of any brightness, as RGBE in a PNG, or as .hdr and .exr files beside the model. */
#include "model.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- pixels ---- */

/* Radiance's shared exponent: (r, g, b) is the nearest byte times 2^(e - 136), and black where e is 0. */
static void to_rgbe(const float *rgb, uint8_t *out)
{
    const float most = fmaxf(rgb[0], fmaxf(rgb[1], rgb[2]));
    int exponent;
    float scale;
    memset(out, 0, 4);
    if (!(most > 1e-32f))
        return;
    frexpf(fminf(most, 1e38f), &exponent);
    scale = ldexpf(1, 8 - exponent);
    for (int k = 0; k < 3; k++)
        out[k] = (uint8_t)fminf(fmaxf(rgb[k], 0) * scale + 0.5f, 255);
    out[3] = (uint8_t)(exponent + 128);
}

void *bk_image_rgbe(const float *rgb, uint32_t side, size_t *size)
{
    const size_t count = (size_t)side * side;
    uint8_t *pixels = malloc(4 * count + 1);
    void *png;
    if (!pixels)
        return NULL;
    for (size_t i = 0; i < count; i++)
        to_rgbe(rgb + 3 * i, pixels + 4 * i);
    png = ex_png_encode(side, side, 4, 8, pixels, size);
    free(pixels);
    return png;
}

/* ---- .hdr ---- */

/* How many bytes from `at` on are equal, at most 127. */
static uint32_t run_at(const uint8_t *row, uint32_t width, uint32_t at)
{
    uint32_t n = 1;
    while (at + n < width && n < 127 && row[at + n] == row[at])
        n++;
    return n;
}

/* One channel of a row: runs of at least four, and what is between them as it is. */
static uint8_t *pack_channel(const uint8_t *row, uint32_t width, uint8_t *to)
{
    for (uint32_t at = 0; at < width;) {
        uint32_t n = run_at(row, width, at), other = 0;
        if (n >= 4) {
            *to++ = (uint8_t)(128 + n);
            *to++ = row[at];
            at += n;
            continue;
        }
        while (at + other < width && other < 128 && run_at(row, width, at + other) < 4)
            other++;
        *to++ = (uint8_t)other;
        memcpy(to, row + at, other);
        to += other;
        at += other;
    }
    return to;
}

/* Radiance's format, whose rows of run lengths are at least 8 and at most 32,767 texels wide: sides are 16 to 8192. */
void *bk_image_hdr(const float *rgb, uint32_t side, size_t *size)
{
    const size_t row_room = 4 + 4 * ((size_t)side + side / 64 + 8);
    uint8_t *bytes = malloc(128 + row_room * side), *row = malloc(4 * (size_t)side), *to = bytes;
    if (!bytes || !row) {
        free(bytes);
        free(row);
        return NULL;
    }
    to += sprintf((char *)bytes, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %u +X %u\n", (unsigned)side, (unsigned)side);
    for (uint32_t y = 0; y < side; y++) {
        for (uint32_t x = 0; x < side; x++) {
            uint8_t texel[4];
            to_rgbe(rgb + 3 * ((size_t)y * side + x), texel);
            for (uint32_t k = 0; k < 4; k++)
                row[(size_t)k * side + x] = texel[k];
        }
        *to++ = 2;
        *to++ = 2;
        *to++ = (uint8_t)(side >> 8);
        *to++ = (uint8_t)side;
        for (uint32_t k = 0; k < 4; k++)
            to = pack_channel(row + (size_t)k * side, side, to);
    }
    free(row);
    *size = (size_t)(to - bytes);
    return bytes;
}

/* ---- .exr ---- */

/* The nearest number of 16 bits, even ones at ties; what is too large becomes the largest, 65504. */
static uint32_t to_half(float x)
{
    uint32_t bits, sign, rest;
    int exponent;
    memcpy(&bits, &x, sizeof bits);
    sign = bits >> 16 & 0x8000;
    exponent = (int)(bits >> 23 & 255) - 112;
    bits &= 0x7fffff;
    if (exponent >= 31 || (exponent == 30 && bits >= 0x7ff000))
        return sign | 0x7bff;
    if (exponent < -10)
        return sign;
    if (exponent <= 0) {                     /* no leading 1: multiples of 2^-24 */
        const uint32_t shift = (uint32_t)(14 - exponent);
        bits |= 0x800000;
        rest = bits & ((1u << shift) - 1);
        bits >>= shift;
        return sign | (bits + (rest > 1u << (shift - 1) || (rest == 1u << (shift - 1) && (bits & 1))));
    }
    rest = bits & 0x1fff;
    bits = (uint32_t)exponent << 10 | bits >> 13;
    return sign | (bits + (rest > 0x1000 || (rest == 0x1000 && (bits & 1))));
}

static uint8_t *put(uint8_t *to, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++)
        *to++ = (uint8_t)(value >> 8 * i);
    return to;
}

static uint8_t *put_attribute(uint8_t *to, const char *name, const char *type, const void *data, size_t size)
{
    memcpy(to, name, strlen(name) + 1);
    to += strlen(name) + 1;
    memcpy(to, type, strlen(type) + 1);
    to += strlen(type) + 1;
    to = put(to, size, 4);
    memcpy(to, data, size);
    return to + size;
}

/* OpenEXR's head for rows from the top down without compression: channels B, G, R, then the window. */
static uint8_t *put_head(uint8_t *to, uint32_t side, int half)
{
    uint8_t channels[64], *c = channels, window[16], *w = put(window, 0, 8), zero[8] = { 0 }, one[4];
    for (int k = 0; k < 3; k++) {
        *c++ = (uint8_t)"BGR"[k];
        *c++ = 0;
        c = put(c, half ? 1 : 2, 4);         /* HALF or FLOAT */
        c = put(c, 0, 4);                    /* not a channel that eyes see evenly; reserved */
        c = put(c, 1, 4);
        c = put(c, 1, 4);
    }
    *c++ = 0;
    w = put(w, side - 1, 4);
    put(w, side - 1, 4);
    put(one, 0x3f800000, 4);
    to = put(to, 20000630, 4);
    to = put(to, 2, 4);
    to = put_attribute(to, "channels", "chlist", channels, (size_t)(c - channels));
    to = put_attribute(to, "compression", "compression", zero, 1);
    to = put_attribute(to, "dataWindow", "box2i", window, 16);
    to = put_attribute(to, "displayWindow", "box2i", window, 16);
    to = put_attribute(to, "lineOrder", "lineOrder", zero, 1);
    to = put_attribute(to, "pixelAspectRatio", "float", one, 4);
    to = put_attribute(to, "screenWindowCenter", "v2f", zero, 8);
    to = put_attribute(to, "screenWindowWidth", "float", one, 4);
    *to++ = 0;
    return to;
}

void *bk_image_exr(const float *rgb, uint32_t side, int half, size_t *size)
{
    const size_t row = 3 * (size_t)side * (half ? 2 : 4);
    uint8_t *bytes = malloc(512 + side * (16 + row)), *to = bytes;
    if (!bytes)
        return NULL;
    to = put_head(to, side, half);
    {
        const uint64_t first = (uint64_t)(to - bytes) + 8 * (uint64_t)side;
        for (uint32_t y = 0; y < side; y++)
            to = put(to, first + y * (8 + (uint64_t)row), 8);
    }
    for (uint32_t y = 0; y < side; y++) {
        to = put(to, y, 4);
        to = put(to, row, 4);
        for (uint32_t k = 3; k-- > 0;)
            for (uint32_t x = 0; x < side; x++) {
                const float value = rgb[3 * ((size_t)y * side + x) + k];
                uint32_t word;
                memcpy(&word, &value, sizeof word);
                to = half ? put(to, to_half(value), 2) : put(to, word, 4);
            }
    }
    *size = (size_t)(to - bytes);
    return bytes;
}

/* ---- files beside the model ---- */

struct bk_file { char *path; void *data; size_t size; int is_new; };

static const char *base_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* The name of a file as a URI has it, every byte but letters, digits and -._~ as %XX. Room: 3 times as long, and 1. */
static void to_uri(const char *name, char *out)
{
    for (; *name; name++)
        if ((*name >= 'a' && *name <= 'z') || (*name >= 'A' && *name <= 'Z') || (*name >= '0' && *name <= '9') ||
            strchr("-._~", *name))
            *out++ = *name;
        else out += sprintf(out, "%%%02X", (unsigned)(unsigned char)*name);
    *out = 0;
}

/* OUT-HASH.exr for OUT.glb: another picture has another name, so that a model always finds the pictures that it was
   written with. */
static int keep_file(bk_model *m, const char *out, const char *ending, void *data, size_t size, char *uri, char *error)
{
    const size_t length = strlen(out), stem = length > 4 && strcmp(out + length - 4, ".glb") == 0 ? length - 4 : length;
    bk_file *grown = realloc(m->files, (m->file_count + 1) * sizeof *grown);
    char *path = malloc(stem + 32);
    if (grown)
        m->files = grown;
    if (!grown || !path || strlen(base_of(out)) > 250) {
        free(path);
        free(data);
        return bk_fail(error, grown && path ? "a name too long for its light maps: " : "out of memory", base_of(out));
    }
    sprintf(path, "%.*s-%016llx.%s", (int)stem, out, (unsigned long long)bk_hash(BK_HASH, data, size), ending);
    m->files[m->file_count].path = path;
    m->files[m->file_count].data = data;
    m->files[m->file_count].size = size;
    m->files[m->file_count++].is_new = 0;
    to_uri(base_of(path), uri);
    return 0;
}

int bk_files_write(bk_model *m, char *error)
{
    for (size_t i = 0; i < m->file_count; i++) {
        bk_file *f = &m->files[i];
        FILE *there = fopen(f->path, "rb");
        if (there)
            fclose(there);
        if (bk_write(f->path, f->data, f->size, error) != 0) {
            bk_files_remove(m);
            return -1;
        }
        f->is_new = !there;
    }
    return 0;
}

void bk_files_remove(bk_model *m)
{
    for (size_t i = 0; i < m->file_count; i++)
        if (m->files[i].is_new)
            remove(m->files[i].path);
}

void bk_files_free(bk_model *m)
{
    for (size_t i = 0; i < m->file_count; i++) {
        free(m->files[i].path);
        free(m->files[i].data);
    }
    free(m->files);
}

int bk_model_map(bk_model *m, const bk_sheet *s, const char *name, const float *values, const bk_image_desc *desc,
                 const char *out, char *error)
{
    float *texels = bk_image_fill(&m->receivers, s, values, 3, desc);
    char source[900], uri[860];
    size_t size = 0;
    void *data = NULL;
    if (texels)
        data = desc->format == BK_RGBE  ? bk_image_rgbe(texels, s->side, &size)
               : desc->format == BK_HDR ? bk_image_hdr(texels, s->side, &size)
               : desc->format == BK_EXR ? bk_image_exr(texels, s->side, desc->bits == 16, &size)
                                        : bk_image_png(texels, s->side, 3, desc->bits, &size);
    free(texels);
    if (!data)
        return bk_fail(error, "out of memory for an image", "");
    if (desc->format == BK_HDR || desc->format == BK_EXR) {
        if (keep_file(m, out, desc->format == BK_HDR ? "hdr" : "exr", data, size, uri, error) != 0)
            return -1;
        snprintf(source, sizeof source, "\"uri\":\"%s\"", uri);
    } else {
        const uint32_t image = bk_glb_add(&m->glb, BK_IMAGES, "{\"bufferView\":%u,\"mimeType\":\"image/png\"}",
                                          (unsigned)bk_glb_view(&m->glb, data, size, 0, 0));
        free(data);
        snprintf(source, sizeof source, "\"index\":%u",
                 (unsigned)bk_glb_add(&m->glb, BK_TEXTURES, "{\"source\":%u}", (unsigned)image));
    }
    bk_text_add(&m->extras, "%s\"%s\":{%s%s", m->extras.size ? "," : "", name, source, s->uv ? ",\"texCoord\":1" : "");
    if (desc->format == BK_RGBE)
        bk_text_add(&m->extras, ",\"encoding\":\"rgbe\"");
    if (desc->full > 0 && desc->format == BK_PNG)
        bk_text_add(&m->extras, ",\"full\":%.6g", (double)desc->full);
    bk_text_add(&m->extras, "}");
    return 0;
}
