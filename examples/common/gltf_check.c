/* gltf_check.c - looks at the text of a glTF file before a parser does, which would recurse as deep as the file
   says and keep some hundred bytes for every value that it finds there. */
#include "internal.h"
#include "gltf.h"
#include <stdlib.h>
#include <string.h>

enum {
    MOST_DEPTH = 200,           /* glTF's own arrays and objects reach 8 deep; extras are anybody's */
    VALUE_BYTES = 256,          /* what tinygltf keeps of a number or string at most, */
    OBJECT_BYTES = 1200         /* and of an object, a node or an accessor for instance */
};

size_t ex_memory_limit = 1000000000;

static uint32_t word_at(const uint8_t *p)
{
    return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

/* The JSON of a .glb or .gltf file; NULL: a .glb without it. */
static const uint8_t *find_json(const uint8_t *data, size_t size, int binary, size_t *length)
{
    *length = size;
    if (!binary) return data;
    if (size < 20 || memcmp(data, "glTF", 4) != 0 || word_at(data + 16) != 0x4e4f534au) return NULL;
    *length = word_at(data + 12);
    return *length <= size - 20 ? data + 20 : NULL;
}

/* Returns the bytes that a parser may need for the values, and the greatest depth of arrays and objects. */
static double weigh(const uint8_t *text, size_t length, int *deepest)
{
    double bytes = 0;
    int depth = 0, quoted = 0;
    *deepest = 0;
    for (size_t i = 0; i < length; i++) {
        uint8_t c = text[i];
        if (quoted) {
            if (c == '\\') i++;
            else if (c == '"') quoted = 0;
            continue;
        }
        if (c == '"') quoted = 1;
        if (c == ',' || c == '[') bytes += VALUE_BYTES;
        if (c == '{') bytes += OBJECT_BYTES;
        if ((c == '[' || c == '{') && ++depth > *deepest) *deepest = depth;
        if (c == ']' || c == '}') depth--;
    }
    return bytes;
}

int ex_gltf_check(const char *path, char *error)
{
    size_t size, length, name = strlen(path);
    uint8_t *data = (uint8_t *)ex_file_read(path, &size, error);
    const uint8_t *json;
    double bytes;
    int deepest, result = 0;
    if (!data) return -1;
    json = find_json(data, size, name > 4 && strcmp(path + name - 4, ".glb") == 0, &length);
    if (!json) result = ex_fail(error, "%s: not a .glb file, or a damaged one", path);
    else {
        bytes = weigh(json, length, &deepest) + 3 * (double)size;
        if (deepest > MOST_DEPTH)
            result = ex_fail(error, "%s: its JSON is %d arrays and objects deep, %d are the most", path, deepest,
                             MOST_DEPTH);
        else if (bytes > (double)ex_memory_limit)
            result = ex_fail(error, "%s: its JSON may take %.0f MB, more than %.0f: --limit-memory", path, bytes * 1e-6,
                             (double)ex_memory_limit * 1e-6);
    }
    free(data);
    return result;
}
