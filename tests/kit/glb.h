/* glb.h - .glb files of grids for tests of bake, and what such a file says, read without the code that is tested. */
#ifndef TEST_GLB_H
#define TEST_GLB_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { GLB_ROOM = 1 << 22 };

typedef struct glb_writer {              /* zero it; then grids, then glb_save */
    uint8_t *bytes;
    size_t   size;
    char     views[65536], accessors[65536], meshes[65536];
    int      view_count, accessor_count, mesh_count, primitive_count;
} glb_writer;

static inline int glb_add(glb_writer *w, const void *data, size_t bytes, int type, int count, const char *kind)
{
    char item[400];
    if (!w->bytes) w->bytes = (uint8_t *)calloc(GLB_ROOM, 1);
    assert_non_null(w->bytes);
    assert_true(w->size + bytes + 4 < GLB_ROOM);
    memcpy(w->bytes + w->size, data, bytes);
    snprintf(item, sizeof item, "%s{\"buffer\":0,\"byteOffset\":%d,\"byteLength\":%d}", w->view_count ? "," : "",
             (int)w->size, (int)bytes);
    strcat(w->views, item);
    snprintf(item, sizeof item, "%s{\"bufferView\":%d,\"componentType\":%d,\"count\":%d,\"type\":\"%s\"%s}",
             w->accessor_count ? "," : "", w->view_count++, type, count, kind,
             strcmp(kind, "VEC3") == 0 ? ",\"min\":[-9,-9,-9],\"max\":[9,9,9]" : "");
    strcat(w->accessors, item);
    w->size = (w->size + bytes + 3) & ~(size_t)3;
    return w->accessor_count++;
}

/* A primitive: a grid of n x n quads from a corner along u and v, which faces u x v; `same` begins no new mesh. uv:
   NULL, or the corner and the size of its square in TEXCOORD_0; more: further members, as ",\"material\":0". */
static inline void glb_grid(glb_writer *w, int same, const float *o, const float *u, const float *v, int n,
                            const float *uv, const char *more)
{
    const int count = (n + 1) * (n + 1);
    float *p = (float *)calloc(8 * (size_t)count, 4), *normal = p + 3 * count, *t = p + 6 * count, length = 0, face[3];
    uint32_t *index = (uint32_t *)calloc(6 * (size_t)n * (size_t)n, 4), *to = index;
    char attributes[200], item[600];
    assert_true(p && index);
    for (int k = 0; k < 3; k++) {
        face[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
        length += face[k] * face[k];
    }
    for (int i = 0; i < count; i++) {
        const float x = (float)(i / (n + 1)) / (float)n, y = (float)(i % (n + 1)) / (float)n;
        for (int k = 0; k < 3; k++) {
            p[3 * i + k] = o[k] + x * u[k] + y * v[k];
            normal[3 * i + k] = face[k] / sqrtf(length);
        }
        t[2 * i] = uv ? uv[0] + x * uv[2] : 0;
        t[2 * i + 1] = uv ? uv[1] + y * uv[2] : 0;
    }
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++) {
            const uint32_t a = (uint32_t)(i * (n + 1) + k), b = a + (uint32_t)n + 1,
                           quad[6] = { a, b, a + 1, a + 1, b, b + 1 };
            memcpy(to, quad, sizeof quad);
            to += 6;
        }
    snprintf(attributes, sizeof attributes, "\"POSITION\":%d,\"NORMAL\":%d",
             glb_add(w, p, 12 * (size_t)count, 5126, count, "VEC3"),
             glb_add(w, normal, 12 * (size_t)count, 5126, count, "VEC3"));
    if (uv)
        snprintf(attributes + strlen(attributes), 60, ",\"TEXCOORD_0\":%d",
                 glb_add(w, t, 8 * (size_t)count, 5126, count, "VEC2"));
    snprintf(item, sizeof item, "%s{\"attributes\":{%s},\"indices\":%d%s}",
             same && w->mesh_count ? "," : w->mesh_count ? "]},{\"primitives\":[" : "{\"primitives\":[", attributes,
             glb_add(w, index, 24 * (size_t)n * (size_t)n, 5125, 6 * n * n, "SCALAR"), more);
    strcat(w->meshes, item);
    w->mesh_count += !same || !w->mesh_count;
    free(p);
    free(index);
}

/* nodes: the array's items; more: further members of the file, as ",\"materials\":[...]". */
static inline void glb_save(glb_writer *w, const char *path, const char *nodes, int node_count, const char *more)
{
    char *json = (char *)calloc(1 << 20, 1);
    uint32_t head[5] = { 0x46546c67, 2, 0, 0, 0x4e4f534a }, chunk[2] = { (uint32_t)w->size, 0x004e4942 };
    FILE *file = fopen(path, "wb");
    size_t n;
    assert_true(json && file);
    n = (size_t)sprintf(json,
                        "{ \"asset\" : {\"version\":\"2.0\", \"extras\":{\"kept\":[1,2.50,\"\\u00e9\"]}},\"scene\":0,"
                        "\"scenes\":[{\"nodes\":[0");
    for (int i = 1; i < node_count; i++) n += (size_t)sprintf(json + n, ",%d", i);
    n += (size_t)sprintf(json + n, "]}],\"nodes\":[%s],\"meshes\":[%s]}],\n \"accessors\":[%s],\"bufferViews\" : [%s ],"
                                   "\"buffers\":[{\"byteLength\":%d}]%s}", nodes, w->meshes, w->accessors, w->views,
                         (int)w->size, more);
    while (n % 4) json[n++] = ' ';
    head[3] = (uint32_t)n;
    head[2] = (uint32_t)(28 + n + w->size);
    assert_int_equal(fwrite(head, 1, 20, file), 20);
    assert_int_equal(fwrite(json, 1, n, file), n);
    assert_int_equal(fwrite(chunk, 1, 8, file), 8);
    assert_int_equal(fwrite(w->bytes, 1, w->size, file), w->size);
    assert_int_equal(fclose(file), 0);
    free(json);
    free(w->bytes);
    memset(w, 0, sizeof *w);
}

typedef struct glb_file { uint8_t *bytes; size_t size, json_size, bin_size; char *json; const uint8_t *bin; } glb_file;

static inline void glb_load(glb_file *f, const char *path)
{
    FILE *file = fopen(path, "rb");
    uint32_t word;
    if (!file) fail_msg("no %s", path);
    f->bytes = (uint8_t *)calloc(2 * GLB_ROOM, 1);
    assert_non_null(f->bytes);
    f->size = fread(f->bytes, 1, 2 * GLB_ROOM, file);
    fclose(file);
    memcpy(&word, f->bytes + 8, 4);
    assert_int_equal(word, f->size);
    memcpy(&word, f->bytes + 12, 4);
    f->json_size = word;
    f->json = (char *)calloc(word + 1, 1);
    assert_non_null(f->json);
    memcpy(f->json, f->bytes + 20, word);
    f->bin = f->bytes + 28 + word;
    memcpy(&word, f->bin - 8, 4);
    f->bin_size = word;
}

static inline void glb_unload(glb_file *f)
{
    free(f->bytes);
    free(f->json);
}

/* Item i of the array behind a name, which must be written `"name":[` but for spaces. */
static inline const char *glb_item(const glb_file *f, const char *name, int i)
{
    char key[40];
    const char *at;
    int depth = 0;
    snprintf(key, sizeof key, "\"%s\"", name);
    at = strstr(f->json, key);
    if (!at) fail_msg("no %s in %s", name, f->json);
    at = strchr(at, '[') + 1;
    for (; i > 0 || depth > 0; at++) {
        depth += *at == '{' || *at == '[';
        depth -= *at == '}' || *at == ']';
        i -= *at == ',' && depth == 0;
        assert_true(*at && depth >= 0);
    }
    return at;
}

static inline int glb_integer(const char *item, const char *name)
{
    char key[40];
    const char *at;
    snprintf(key, sizeof key, "\"%s\":", name);
    at = strstr(item, key);
    if (!at) fail_msg("no %s in %.200s", name, item);
    return atoi(at + strlen(key));
}

/* The bytes of an accessor. */
static inline const uint8_t *glb_data(const glb_file *f, int accessor, int *count)
{
    const char *a = glb_item(f, "accessors", accessor),
               *view = glb_item(f, "bufferViews", glb_integer(a, "bufferView"));
    *count = glb_integer(a, "count");
    return f->bin + glb_integer(view, "byteOffset");
}

#endif
