/* glb.c - see glb.h */
#include "glb.h"
#include "bake.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HEADER = 12, CHUNK = 8 };
#define JSON_CHUNK 0x4e4f534au
#define BIN_CHUNK 0x004e4942u

static const char *const list_names[BK_LISTS] = {
    "accessors", "bufferViews", "images", "textures", "materials", "buffers"
};

/* ---- text that grows ---- */

void bk_text_bytes(bk_text *text, const void *bytes, size_t size)
{
    if (text->size + size > text->room) {
        size_t room = 2 * (text->size + size) + 256;
        char *grown = text->failed ? NULL : realloc(text->bytes, room);
        if (!grown) {
            text->failed = 1;
            return;
        }
        text->bytes = grown;
        text->room = room;
    }
    if (size)
        memcpy(text->bytes + text->size, bytes, size);
    text->size += size;
}

static void add_format(bk_text *text, const char *format, va_list values)
{
    char small[512], *line = small;
    va_list again;
    int size;
    va_copy(again, values);
    size = vsnprintf(small, sizeof small, format, values);
    if (size >= (int)sizeof small) {
        line = malloc((size_t)size + 1);
        if (line)
            vsnprintf(line, (size_t)size + 1, format, again);
    }
    va_end(again);
    if (line && size >= 0)
        bk_text_bytes(text, line, (size_t)size);
    else text->failed = 1;
    if (line != small)
        free(line);
}

void bk_text_add(bk_text *text, const char *format, ...)
{
    va_list values;
    va_start(values, format);
    add_format(text, format, values);
    va_end(values);
}

/* ---- reading ---- */

static uint32_t word_at(const uint8_t *p)
{
    return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static int damaged(char *error, const char *path, const char *what)
{
    snprintf(error, EX_ERROR_SIZE, "%.120s: %.120s", path, what);
    return -1;
}

/* Finds the chunks: JSON, then the buffer if there is one, then whatever follows. */
static int find_chunks(bk_glb *g, const char **json, size_t *json_size)
{
    const uint8_t *p = g->data;
    size_t at = HEADER, length;
    if (g->size < HEADER + CHUNK || memcmp(p, "glTF", 4) != 0 || word_at(p + 4) != 2 || word_at(p + 8) > g->size)
        return -1;
    g->size = word_at(p + 8);
    length = g->size < HEADER + CHUNK ? SIZE_MAX : word_at(p + at);
    if (length > g->size - HEADER - CHUNK || word_at(p + at + 4) != JSON_CHUNK)
        return -1;
    *json = (const char *)p + at + CHUNK;
    *json_size = length;
    at += CHUNK + length;
    if (g->size - at >= CHUNK && word_at(p + at + 4) == BIN_CHUNK) {
        length = word_at(p + at);
        if (length > g->size - at - CHUNK)
            return -1;
        g->bin = p + at + CHUNK;
        g->bin_size = length;
        at += CHUNK + length;
    }
    g->rest = p + at;
    g->rest_size = g->size - at;
    return 0;
}

/* The buffer of the file must be the first one, so that more can be added to it. */
static int check_buffer(bk_glb *g, const char *path, char *error)
{
    uint32_t buffers = g->list_value[BK_BUFFERS], first = buffers + 1;
    double bytes;
    if (!buffers || !g->list_count[BK_BUFFERS])
        return g->bin ? damaged(error, path, "it has a buffer that its JSON does not name") : 0;
    if (g->json.values[first].kind != '{')
        return damaged(error, path, "its first buffer is no object");
    if (bk_json_member(&g->json, first, "uri"))
        return damaged(error, path, "its first buffer is another file: nothing can be added to it");
    bytes = bk_json_number(&g->json, bk_json_member(&g->json, first, "byteLength"), -1);
    if (!(bytes >= 0 && bytes <= (double)g->bin_size))
        return damaged(error, path, "its first buffer is longer than the file says");
    return 0;
}

int bk_glb_open(bk_glb *g, const char *path, char *error)
{
    char what[EX_ERROR_SIZE];
    const char *text = NULL;
    size_t length = 0;
    int result = 0;
    memset(g, 0, sizeof *g);
    g->data = ex_file_read(path, &g->size, error);
    if (!g->data)
        return -1;
    if (find_chunks(g, &text, &length) != 0)
        result = damaged(error, path, "not a .glb file of version 2, or a damaged one");
    else if (bk_json_parse(&g->json, text, length, what) != 0)
        result = damaged(error, path, what);
    for (int i = 0; i < BK_LISTS && result == 0; i++) {
        uint32_t value = g->list_value[i] = bk_json_member(&g->json, 0, list_names[i]);
        g->list_count[i] = value ? g->json.values[value].count : 0;
        if (value && g->json.values[value].kind != '[')
            result = damaged(error, path, "a list in its JSON is none");
    }
    if (result == 0)
        result = check_buffer(g, path, error);
    if (result == 0 && g->json.escaped)
        result = damaged(error, path, "a name in its JSON is written with a backslash");
    if (result != 0)
        bk_glb_free(g);
    return result;
}

void bk_glb_free(bk_glb *g)
{
    for (size_t i = 0; i < g->edit_count; i++)
        free(g->edits[i].text);
    for (int i = 0; i < BK_LISTS; i++)
        free(g->lists[i].bytes);
    free(g->edits);
    free(g->added.bytes);
    bk_json_free(&g->json);
    free(g->data);
    memset(g, 0, sizeof *g);
}

/* ---- changing ---- */

void bk_glb_edit(bk_glb *g, size_t at, size_t remove, const char *text)
{
    const size_t n = g->edit_count;
    bk_edit *grown = n & (n - 1) ? g->edits : realloc(g->edits, (n ? 2 * n : 1) * sizeof *grown);
    char *copy = malloc(strlen(text) + 1);
    if (grown)
        g->edits = grown;
    if (!grown || !copy) {
        g->failed = 1;
        free(copy);
        return;
    }
    strcpy(copy, text);
    g->edits[n].at = at;
    g->edits[n].remove = remove;
    g->edits[n].order = n;
    g->edits[n].text = copy;
    g->edit_count = n + 1;
}

void bk_glb_set(bk_glb *g, uint32_t object, const char *name, const char *value)
{
    const uint32_t old = bk_json_member(&g->json, object, name);
    const bk_value *o = &g->json.values[object], *v = &g->json.values[old];
    bk_text text = { NULL, 0, 0, 0 };
    if (old) {
        bk_glb_edit(g, v->begin, v->end - v->begin, value);
        return;
    }
    bk_text_add(&text, "\"%s\":%s%s", name, value, o->count ? "," : "");
    bk_text_bytes(&text, "", 1);
    if (text.failed)
        g->failed = 1;
    else bk_glb_edit(g, o->begin + 1, 0, text.bytes);       /* behind the bracket that opens it */
    free(text.bytes);
}

uint32_t bk_glb_add(bk_glb *g, bk_list list, const char *format, ...)
{
    va_list values;
    if (g->list_count[list])
        bk_text_add(&g->lists[list], ",");
    va_start(values, format);
    add_format(&g->lists[list], format, values);
    va_end(values);
    return g->list_count[list]++;
}

uint32_t bk_glb_view(bk_glb *g, const void *bytes, size_t size, int stride, int target)
{
    static const char zeros[4];
    char more[64] = "";
    size_t at;
    bk_text_bytes(&g->added, zeros, (4 - (g->bin_size + g->added.size) % 4) % 4);
    at = g->bin_size + g->added.size;
    bk_text_bytes(&g->added, bytes, size);
    if (target)
        snprintf(more, sizeof more, ",\"byteStride\":%d,\"target\":%d", stride, target);
    return bk_glb_add(g, BK_VIEWS, "{\"buffer\":0,\"byteOffset\":%llu,\"byteLength\":%llu%s}", (unsigned long long)at,
                      (unsigned long long)size, more);
}

/* ---- writing ---- */

static int by_place(const void *a, const void *b)
{
    const bk_edit *x = a, *y = b;
    if (x->at != y->at)
        return x->at < y->at ? -1 : 1;
    return x->order < y->order ? -1 : 1;
}

/* What was added to lists, and the length of the buffer, as edits. */
static void close_lists(bk_glb *g)
{
    const uint32_t buffers = g->list_value[BK_BUFFERS];
    char number[32];
    snprintf(number, sizeof number, "%llu", (unsigned long long)(g->bin_size + g->added.size));
    if (g->added.size && buffers && g->json.values[buffers].count)
        bk_glb_set(g, buffers + 1, "byteLength", number);
    else if (g->added.size)
        bk_glb_add(g, BK_BUFFERS, "{\"byteLength\":%s}", number);
    for (int i = 0; i < BK_LISTS; i++) {
        bk_text whole = { NULL, 0, 0, 0 };
        if (!g->lists[i].size)
            continue;
        if (!g->list_value[i])
            bk_text_add(&whole, "[");
        bk_text_bytes(&whole, g->lists[i].bytes, g->lists[i].size);
        bk_text_bytes(&whole, "]", 2);
        if (whole.failed || g->lists[i].failed)
            g->failed = 1;
        else if (g->list_value[i])
            bk_glb_edit(g, g->json.values[g->list_value[i]].end - 1, 1, whole.bytes);
        else bk_glb_set(g, 0, list_names[i], whole.bytes);
        free(whole.bytes);
    }
}

static void add_word(bk_text *out, size_t value)
{
    uint8_t bytes[4];
    for (int i = 0; i < 4; i++)
        bytes[i] = (uint8_t)(value >> (8 * i));
    bk_text_bytes(out, bytes, 4);
}

static void pad(bk_text *out, size_t since, char with)
{
    while ((out->size - since) % 4 && !out->failed)
        bk_text_bytes(out, &with, 1);
}

static void put_word(bk_text *out, size_t at, size_t value)
{
    for (size_t i = 0; i < 4 && !out->failed; i++)
        out->bytes[at + i] = (char)(value >> (8 * i));
}

static void add_json(bk_glb *g, bk_text *out)
{
    size_t at = 0, begin;
    const size_t length = g->json.values[0].end;
    if (g->edit_count)
        qsort(g->edits, g->edit_count, sizeof *g->edits, by_place);
    add_word(out, 0);
    add_word(out, JSON_CHUNK);
    begin = out->size;
    for (size_t i = 0; i < g->edit_count; i++) {
        bk_text_bytes(out, g->json.text + at, g->edits[i].at - at);
        bk_text_bytes(out, g->edits[i].text, strlen(g->edits[i].text));
        at = g->edits[i].at + g->edits[i].remove;
    }
    bk_text_bytes(out, g->json.text + at, length - at);
    pad(out, begin, ' ');
    put_word(out, begin - 8, out->size - begin);
}

int bk_glb_bytes(bk_glb *g, void **data, size_t *size, char *error)
{
    bk_text out = { NULL, 0, 0, 0 };
    size_t begin;
    close_lists(g);
    bk_text_bytes(&out, g->data, 8);
    add_word(&out, 0);
    add_json(g, &out);
    if (g->bin_size + g->added.size) {
        add_word(&out, 0);
        add_word(&out, BIN_CHUNK);
        begin = out.size;
        bk_text_bytes(&out, g->bin, g->bin_size);
        bk_text_bytes(&out, g->added.bytes, g->added.size);
        pad(&out, begin, 0);
        put_word(&out, begin - 8, out.size - begin);
    }
    bk_text_bytes(&out, g->rest, g->rest_size);
    put_word(&out, 8, out.size);
    g->failed |= out.failed | g->added.failed;
    if (!g->failed && out.size <= UINT32_MAX) {
        *data = out.bytes;
        *size = out.size;
        return 0;
    }
    snprintf(error, EX_ERROR_SIZE, "%s", g->failed ? "out of memory" : "a .glb file holds 4 GiB, and this is more");
    free(out.bytes);
    return -1;
}
