/* primitives.c - see receive.h: the triangles of a .glb file as its accessors hold them. */
#include "receive.h"
#include "bake.h"
#include "../common/gltf.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void bk_primitives_free(bk_primitives *all)
{
    for (uint32_t i = 0; i < all->count; i++) {
        bk_primitive *p = &all->list[i];
        if (p->owner == i) {
            free(p->positions);
            free(p->normals);
            free(p->colors);
            free(p->used);
        }
        free(p->uvs[0]);
        free(p->uvs[1]);
        free(p->indices);
    }
    free(all->list);
    memset(all, 0, sizeof *all);
}

#if defined(DAPPLE_HAVE_TINYGLTF) && DAPPLE_HAVE_TINYGLTF

typedef struct reading {
    bk_primitives *out;
    const gltf_file *file;
    const char *path;
    char *error;
    double bytes;
} reading;

static int fail(char *error, const char *path, const char *what)
{
    snprintf(error, EX_ERROR_SIZE, "%.120s: %.120s", path, what);
    return -1;
}

/* Room for the floats of an accessor; NULL: too many for --limit-memory, or out of memory. */
static float *room_for(reading *r, size_t floats)
{
    float *room = NULL;
    r->bytes += 4.0 * (double)floats;
    if (r->bytes <= (double)ex_memory_limit)
        room = malloc(floats * sizeof *room);
    if (!room)
        fail(r->error, r->path, "its vertices take too much memory: --limit-memory");
    return room;
}

static float *floats_of(reading *r, const gltf_accessor *a, size_t count, int components)
{
    float *out = room_for(r, count * (size_t)components);
    for (size_t i = 0; out && i < count; i++)
        for (int k = 0; k < components; k++) {
            const float x = ex_gltf_float(a, i, k);
            out[i * (size_t)components + (size_t)k] = fabsf(x) < 1e9f ? x : 0;
        }
    return out;
}

/* Three corners a triangle; of strips and fans too. Triangles with a corner that does not exist are left out. */
static int read_indices(reading *r, const gltf_primitive *from, bk_primitive *to)
{
    const gltf_accessor *a = NULL;
    size_t corners = to->vertex_count, triangles;
    if (from->indices >= 0) {
        if (!(a = ex_gltf_accessor(r->file, from->indices, 1, "indices", r->path, r->error)))
            return -1;
        corners = a->count;
    }
    triangles = from->mode == 4 ? corners / 3 : corners < 3 ? 0 : corners - 2;
    to->indices = (uint32_t *)room_for(r, 3 * triangles + 1);
    for (size_t t = 0; to->indices && t < triangles; t++) {
        uint32_t *out = to->indices + 3 * (size_t)to->triangle_count;
        const size_t first = from->mode == 4 ? 3 * t : t;
        const size_t at[3] = { from->mode == 6 ? 0 : first, first + 1 + (from->mode == 5 && t % 2),
                               first + 2 - (from->mode == 5 && t % 2) };
        int fine = 1;
        for (int k = 0; k < 3; k++) {
            out[k] = a ? ex_gltf_uint(a, at[k]) : (uint32_t)at[k];
            fine &= out[k] < to->vertex_count;
        }
        to->triangle_count += (uint32_t)fine;
    }
    return to->indices ? 0 : -1;
}

static const gltf_accessor *attribute_of(reading *r, int index, int components, uint32_t count, const char *what)
{
    const gltf_accessor *a = ex_gltf_accessor(r->file, index, components, what, r->path, r->error);
    if (!a || a->count >= count)
        return a;
    fail(r->error, r->path, "an attribute has fewer elements than POSITION");
    return NULL;
}

static int read_colors(reading *r, int index, bk_primitive *to)
{
    const int components = (size_t)index < r->file->accessor_count ? r->file->accessors[index].components : 4;
    const gltf_accessor *a = attribute_of(r, index, components == 3 ? 3 : 4, to->vertex_count, "COLOR_0");
    float *out = a ? room_for(r, 4 * (size_t)to->vertex_count) : NULL;
    for (size_t i = 0; out && i < to->vertex_count; i++)
        for (int k = 0; k < 4; k++) {
            const float x = k < a->components ? ex_gltf_float(a, i, k) : 1;
            out[4 * i + (size_t)k] = x > 0 ? x < 1 ? x : 1 : 0;
        }
    to->colors = out;
    return out ? 0 : -1;
}

/* Positions, normals (0 where the file has none) and colours, unless an earlier primitive of the mesh has them. */
static int read_vertices(reading *r, const gltf_primitive *from, bk_primitive *to, uint32_t self)
{
    const gltf_accessor *a;
    for (uint32_t i = self; i-- > 0 && self - i <= 64 && r->out->list[i].mesh == to->mesh;)
        if (memcmp(r->out->list[i].accessors, to->accessors, sizeof to->accessors) == 0) {
            const bk_primitive *o = &r->out->list[to->owner = r->out->list[i].owner];
            to->vertex_count = o->vertex_count;
            to->positions = o->positions;
            to->normals = o->normals;
            to->colors = o->colors;
            to->used = o->used;
            return 0;
        }
    if (!(a = ex_gltf_accessor(r->file, from->positions, 3, "POSITION", r->path, r->error)))
        return -1;
    to->vertex_count = (uint32_t)a->count;
    if (!(to->positions = floats_of(r, a, a->count, 3)))
        return -1;
    if (from->normals >= 0) {
        a = attribute_of(r, from->normals, 3, to->vertex_count, "NORMAL");
        to->normals = a ? floats_of(r, a, to->vertex_count, 3) : NULL;
    } else if ((to->normals = room_for(r, 3 * (size_t)to->vertex_count)) != NULL)
        memset(to->normals, 0, 12 * (size_t)to->vertex_count);
    to->used = calloc(to->vertex_count, 1);
    if (!to->normals || !to->used)
        return to->normals ? fail(r->error, r->path, "out of memory") : -1;
    return from->colors >= 0 ? read_colors(r, from->colors, to) : 0;
}

static int read_primitive(reading *r, const gltf_primitive *from, bk_primitive *to, uint32_t self)
{
    to->owner = self;
    to->accessors[0] = from->positions;
    to->accessors[1] = from->normals;
    to->accessors[2] = from->colors;
    to->material = from->material;
    if (from->mode < 4 || from->mode > 6 || from->positions < 0)
        return 0;
    if (read_vertices(r, from, to, self) != 0 || read_indices(r, from, to) != 0)
        return -1;
    for (int k = 0; k < 2; k++)
        if (from->uvs[k] >= 0) {
            const gltf_accessor *a = attribute_of(r, from->uvs[k], 2, to->vertex_count, "TEXCOORD");
            if (!a || !(to->uvs[k] = floats_of(r, a, to->vertex_count, 2)))
                return -1;
        }
    for (size_t i = 0; i < 3 * (size_t)to->triangle_count; i++)
        to->used[to->indices[i]] = 1;
    return 0;
}

/* Adds the normals of a primitive's triangles, by area, to the vertices that have none. */
static void add_normals(bk_primitive *p, float *sums)
{
    for (size_t t = 0; t < p->triangle_count; t++) {
        const uint32_t *index = p->indices + 3 * t;
        const float *a = p->positions + 3 * (size_t)index[0], *b = p->positions + 3 * (size_t)index[1];
        const float *c = p->positions + 3 * (size_t)index[2];
        const float u[3] = { b[0] - a[0], b[1] - a[1], b[2] - a[2] }, v[3] = { c[0] - a[0], c[1] - a[1], c[2] - a[2] };
        for (int k = 0; k < 3; k++) {
            const int l = (k + 1) % 3, m = (k + 2) % 3;
            for (int corner = 0; corner < 3; corner++)
                sums[3 * (size_t)index[corner] + (size_t)k] += u[l] * v[m] - u[m] * v[l];
        }
    }
}

/* Unit normals everywhere: the file's, or else the mean of the triangles', or else up. */
static int finish_normals(bk_primitives *all)
{
    for (uint32_t i = 0; i < all->count; i++) {
        bk_primitive *p = &all->list[i];
        float *sums;
        if (p->owner != i || !p->vertex_count)
            continue;
        if (!(sums = calloc(3 * (size_t)p->vertex_count, sizeof *sums)))
            return -1;
        for (uint32_t k = i; k < all->count && all->list[k].mesh == p->mesh; k++)
            if (all->list[k].owner == i)
                add_normals(&all->list[k], sums);
        for (size_t v = 0; v < p->vertex_count; v++)
            for (int way = 0; way < 2; way++) {
                float *n = p->normals + 3 * v, length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
                if (!(length > 1e-20f) && way == 0)
                    memcpy(n, sums + 3 * v, 12);
                else for (int k = 0; k < 3; k++)
                    n[k] = length > 1e-20f ? n[k] / length : k == 1 ? 1.0f : 0.0f;
            }
        free(sums);
    }
    return 0;
}

static int read_file(void *context, const gltf_file *file, char *error)
{
    reading *r = context;
    bk_primitives *out = r->out;
    r->file = file;
    r->error = error;
    out->list = calloc(file->primitive_count + 1, sizeof *out->list);
    if (!out->list)
        return fail(error, r->path, "out of memory");
    for (size_t i = 0; i < file->primitive_count; i++) {
        bk_primitive *to = &out->list[i];
        to->mesh = (uint32_t)file->primitives[i].mesh;
        to->number = i && to->mesh == to[-1].mesh ? to[-1].number + 1 : 0;
        out->count = (uint32_t)i + 1;
        if (read_primitive(r, &file->primitives[i], to, (uint32_t)i) != 0)
            return -1;
    }
    return finish_normals(out) == 0 ? 0 : fail(error, r->path, "out of memory");
}

int bk_primitives_read(bk_primitives *out, const char *path, char *error)
{
    reading r = { out, NULL, path, error, 0 };
    int result = ex_gltf_check(path, error);
    memset(out, 0, sizeof *out);
    if (result == 0)
        result = ex_gltf_parse(path, read_file, &r, error, EX_ERROR_SIZE);
    if (result != 0)
        bk_primitives_free(out);
    return result;
}

#else

int bk_primitives_read(bk_primitives *out, const char *path, char *error)
{
    memset(out, 0, sizeof *out);
    snprintf(error, EX_ERROR_SIZE, "%.150s: built without a glTF parser (Debian: libtinygltf-dev)", path);
    return -1;
}

#endif
