/* gltf.c - a glTF file becomes an ex_scene. The parser (gltf.h) lets everything through, so that all checks stand here:
   indices, types, strides and sizes of accessors, the shape of the node graph, non-finite numbers. What is broken as a
   whole is an error; single bad vertices and triangles, which real models have, are left out and counted. */
#include "rig.h"
#include <stdlib.h>
#include <string.h>

#if !defined(DAPPLE_HAVE_TINYGLTF) || !DAPPLE_HAVE_TINYGLTF

int ex_gltf_load(ex_scene *scene, const char *path, char *error)
{
    (void)scene;
    return ex_fail(error, "%s: built without a glTF parser (Debian: libtinygltf-dev)", path);
}

#else

#define MOST_INTENSITY 1e12          /* as of --light: products with it stay far from the largest float */
#define MOST_TRIANGLES  100000000u   /* of all meshes, and of all nodes: small files can name one array often */
#define MOST_LIGHTS     1000u        /* nodes with a light: techniques draw maps for each */
#define MOST_OBJECTS    100000u      /* nodes with a mesh: techniques spend a millisecond and more on each */

typedef struct image_means { double srgb[3], plain[3]; int has[2]; } image_means;

typedef struct loader {
    const gltf_file *file;
    ex_scene        *scene;
    ex_builder       builder;
    const char      *path;
    char            *error;
    uint64_t         placed;     /* triangles of the nodes so far */
    image_means     *means;      /* of each image */
    ex_source       *sources;    /* of each vertex of the mesh being built, where the file moves any */
    size_t           source_room;
} loader;

/* ---- accessors ---- */

static size_t component_size(int type)
{
    return type == 5120 || type == 5121 ? 1 : type == 5122 || type == 5123 ? 2 : type == 5125 || type == 5126 ? 4 : 0;
}

static uint32_t read_bits(const uint8_t *p, size_t size)     /* files are little-endian */
{
    uint32_t bits = 0;
    for (size_t i = 0; i < size; i++) bits |= (uint32_t)p[i] << (8 * i);
    return bits;
}

static uint32_t sparse_index(const gltf_sparse *sparse, size_t i)
{
    size_t size = component_size(sparse->index_type);
    return read_bits(sparse->indices + i * size, size);
}

/* size: bytes of an element. */
static const char *sparse_problem(const gltf_accessor *a, size_t size)
{
    const gltf_sparse *s = &a->sparse;
    if (s->index_type != 5121 && s->index_type != 5123 && s->index_type != 5125)
        return "has sparse indices that are not unsigned integers";
    if (s->count > a->count) return "has an impossible sparse count";
    if (!s->indices || s->index_bytes / component_size(s->index_type) < s->count)
        return "has sparse indices beyond their buffer";
    if (!s->values || s->value_bytes / size < s->count) return "has sparse values beyond their buffer";
    for (size_t i = 0; i < s->count; i++) {
        if (sparse_index(s, i) >= a->count) return "has a sparse index beyond its count";
        if (i && sparse_index(s, i) <= sparse_index(s, i - 1)) return "has sparse indices that do not ascend";
    }
    return NULL;
}

const gltf_accessor *ex_gltf_accessor(const gltf_file *file, int index, int components, const char *what,
                                      const char *path, char *error)
{
    if (index < 0 || (size_t)index >= file->accessor_count) {
        ex_fail(error, "%s: %s: accessor %d does not exist", path, what, index);
        return NULL;
    }
    const gltf_accessor *a = &file->accessors[index];
    size_t size = component_size(a->component_type) * (size_t)components, stride = a->stride ? a->stride : size;
    const char *problem = NULL;
    if (!a->data && !a->sparse.count) problem = "has no data";
    else if (size == 0 || a->components != components) problem = "has the wrong type";
    else if (stride < size) problem = "has a stride below its element size";
    else if (a->count == 0 || a->count > 0x7fffffff) problem = "has an impossible count";
    else if (a->data && (a->bytes < size || (a->bytes - size) / stride < a->count - 1))
        problem = "reaches beyond its buffer";
    else if (a->sparse.count) problem = sparse_problem(a, size);
    if (!problem) return a;
    ex_fail(error, "%s: %s: accessor %d %s", path, what, index, problem);
    return NULL;
}

static const gltf_accessor *get_accessor(const loader *l, int index, int components, const char *what)
{
    return ex_gltf_accessor(l->file, index, components, what, l->path, l->error);
}

static const uint8_t *element(const gltf_accessor *a, size_t i, int component)
{
    static const uint8_t nothing[4] = {0, 0, 0, 0};
    size_t size = component_size(a->component_type), whole = size * (size_t)a->components;
    size_t low = 0, high = a->sparse.count;
    while (low < high) {                     /* the first sparse index that is not below i */
        size_t middle = low + (high - low) / 2;
        if (sparse_index(&a->sparse, middle) < i) low = middle + 1;
        else high = middle;
    }
    if (low < a->sparse.count && sparse_index(&a->sparse, low) == i)
        return a->sparse.values + low * whole + size * (size_t)component;
    return a->data ? a->data + i * (a->stride ? a->stride : whole) + size * (size_t)component : nothing;
}

uint32_t ex_gltf_uint(const gltf_accessor *a, size_t i)
{
    return read_bits(element(a, i, 0), component_size(a->component_type));
}

/* Integers by glTF's normalisation, or plain where the file says so (KHR_mesh_quantization). */
float ex_gltf_float(const gltf_accessor *a, size_t i, int component)
{
    uint32_t bits = read_bits(element(a, i, component), component_size(a->component_type));
    float value = 0;
    switch (a->component_type) {
    case 5120: value = (float)(int8_t)bits; return a->normalized ? fmaxf(value / 127, -1) : value;
    case 5121: value = (float)bits; return a->normalized ? value / 255 : value;
    case 5122: value = (float)(int16_t)bits; return a->normalized ? fmaxf(value / 32767, -1) : value;
    case 5123: value = (float)bits; return a->normalized ? value / 65535 : value;
    case 5125: return (float)bits;
    default: memcpy(&value, &bits, sizeof value); return value;
    }
}

/* ---- meshes ---- */

typedef struct primitive {
    const gltf_accessor *positions, *normals, *uvs, *indices;
    uint32_t  material, number;  /* number: of the primitive in the file */
    uint32_t *remap;             /* vertex of the file -> vertex of the mesh; UINT32_MAX not yet, BAD never */
} primitive;

#define UNSEEN UINT32_MAX
#define BAD    (UINT32_MAX - 1)

static uint32_t corner_index(const primitive *p, size_t i)
{
    return p->indices ? ex_gltf_uint(p->indices, i) : (uint32_t)i;
}

static v3 read_v3(const gltf_accessor *a, size_t i)
{
    return v3_make(ex_gltf_float(a, i, 0), ex_gltf_float(a, i, 1), ex_gltf_float(a, i, 2));
}

/* Where vertex `index` of the mesh lies in the file: skins and morph targets are read when the mesh is complete. */
static void note_source(loader *l, const primitive *p, uint32_t i, uint32_t index)
{
    if (!l->scene->rig || l->builder.failed) return;
    if (index >= l->source_room) {
        size_t bigger = index ? 2 * (size_t)index : 1024;
        ex_source *sources = (ex_source *)realloc(l->sources, bigger * sizeof *sources);
        if (!sources) { l->builder.failed = 1; return; }
        l->sources = sources;
        l->source_room = bigger;
    }
    l->sources[index].primitive = p->number;
    l->sources[index].vertex = i;
}

/* Adds vertex i with the given or its own normal; zero normals are made by the builder. */
static uint32_t add_vertex(loader *l, const primitive *p, uint32_t i, const v3 *normal)
{
    v3 n = v3_make(0, 0, 0), zero = n;
    if (normal) n = *normal;
    else if (p->normals) n = v3_unit_or(read_v3(p->normals, i), zero);
    uint32_t index = ex_build_vertex(&l->builder, read_v3(p->positions, i), n);
    note_source(l, p, i, index);
    for (int k = 0; p->uvs && !l->builder.failed && k < 2; k++) {
        float uv = ex_gltf_float(p->uvs, i, k);
        l->builder.mesh.uvs[2 * (size_t)index + (size_t)k] = fabsf(uv) < 1e6f ? uv : 0;
    }
    return index;
}

/* Checks the three corners, then adds the triangle: sharing vertices where the file has normals, with three of its own
   and the face's normal where it has none (the format's rule: flat). */
static void add_triangle(loader *l, const primitive *p, uint32_t corner[3])
{
    v3 q[3];
    for (int k = 0; k < 3; k++) {
        if (corner[k] >= p->positions->count || p->remap[corner[k]] == BAD) { l->scene->skipped_triangles++; return; }
        q[k] = read_v3(p->positions, corner[k]);
    }
    v3 face = v3_cross(v3_sub(q[1], q[0]), v3_sub(q[2], q[0]));
    if (!(v3_length(face) > 0)) {
        /* Too small for float products is not degenerate yet: the unit vectors of the edges decide. */
        v3 zero = v3_make(0, 0, 0);
        face = v3_cross(v3_unit_or(v3_sub(q[1], q[0]), zero), v3_unit_or(v3_sub(q[2], q[0]), zero));
        if (!(v3_length(face) > 0)) { l->scene->skipped_triangles++; return; }
    }
    face = v3_unit(v3_scale(face, 1 / v3_length(face)));
    uint32_t index[3];
    for (int k = 0; k < 3; k++) {
        uint32_t *known = &p->remap[corner[k]];
        if (!p->normals)
            index[k] = add_vertex(l, p, corner[k], &face);
        else
            index[k] = *known = *known == UNSEEN ? add_vertex(l, p, corner[k], NULL) : *known;
    }
    ex_build_triangle(&l->builder, index[0], index[1], index[2], p->material);
}

static void add_triangles(loader *l, const primitive *p, int mode)
{
    size_t count = p->indices ? p->indices->count : p->positions->count;
    size_t triangles = mode == 4 ? count / 3 : count < 3 ? 0 : count - 2;
    for (size_t t = 0; t < triangles && !l->builder.failed; t++) {
        size_t first = mode == 4 ? 3 * t : t;
        size_t at[3] = {first, first + 1, first + 2};
        if (mode == 5 && t % 2 == 1) { at[1] = first + 2; at[2] = first + 1; }      /* strip: every other one turns */
        if (mode == 6) at[0] = 0;                                                  /* fan: round the first */
        uint32_t corner[3] = {corner_index(p, at[0]), corner_index(p, at[1]), corner_index(p, at[2])};
        add_triangle(l, p, corner);
    }
}

static int has_textures(const ex_material *m)
{
    return m->base_texture >= 0 || m->normal_texture >= 0 || m->rough_texture >= 0;
}

/* The set of texture coordinates that a material reads. */
static int uv_set(const loader *l, int material)
{
    const gltf_material *from = &l->file->materials[material];
    const ex_material *to = &l->scene->materials[material];
    return to->base_texture >= 0 ? from->uv_set : to->normal_texture >= 0 ? from->normal_uv_set : from->rough_uv_set;
}

/* Finds and checks the arrays of a primitive. Returns 1 ready, 0 nothing to draw in it, -1 error. */
static int open_primitive(loader *l, const gltf_primitive *from, primitive *p)
{
    memset(p, 0, sizeof *p);
    if (from->mode < 4 || from->mode > 6) return 0;
    if (from->positions < 0) return 0;
    p->positions = get_accessor(l, from->positions, 3, "POSITION");
    if (!p->positions) return -1;
    if (from->normals >= 0 && !(p->normals = get_accessor(l, from->normals, 3, "NORMAL"))) return -1;
    if (from->indices >= 0 && !(p->indices = get_accessor(l, from->indices, 1, "indices"))) return -1;
    if (p->normals && p->normals->count < p->positions->count)
        return ex_fail(l->error, "%s: NORMAL has fewer elements than POSITION", l->path);
    if (p->indices && p->indices->component_type != 5121 && p->indices->component_type != 5123 &&
        p->indices->component_type != 5125)
        return ex_fail(l->error, "%s: indices are not unsigned integers", l->path);
    int material = from->material, set = 0;
    if (material >= 0 && (size_t)material >= l->file->material_count)
        return ex_fail(l->error, "%s: material %d does not exist", l->path, material);
    if (material >= 0) set = uv_set(l, material);
    p->material = material >= 0 ? (uint32_t)material : (uint32_t)l->file->material_count;   /* last: the default */
    if (!has_textures(&l->scene->materials[p->material])) return 1;
    if (set < 0 || set > 1 || from->uvs[set] < 0) return 1;
    p->uvs = get_accessor(l, from->uvs[set], 2, "TEXCOORD");
    if (!p->uvs) return -1;
    if (p->uvs->count < p->positions->count)
        return ex_fail(l->error, "%s: TEXCOORD has fewer elements than POSITION", l->path);
    return 1;
}

/* A material whose constant alpha is below its cutoff is one hole. */
static int is_invisible(const loader *l, int material)
{
    return material >= 0 && l->scene->materials[material].alpha_cutoff > 1;
}

static int load_primitive(loader *l, const gltf_primitive *from)
{
    primitive p;
    int ready = open_primitive(l, from, &p);
    if (ready <= 0 || is_invisible(l, from->material)) return ready < 0 ? -1 : 0;
    p.number = (uint32_t)(from - l->file->primitives);
    p.remap = (uint32_t *)malloc(p.positions->count * sizeof *p.remap);
    if (!p.remap) return ex_fail(l->error, "%s: out of memory", l->path);
    for (size_t i = 0; i < p.positions->count; i++) {
        v3 q = read_v3(p.positions, i);
        int fine = fabsf(q.x) < HUGE_COORDINATE && fabsf(q.y) < HUGE_COORDINATE && fabsf(q.z) < HUGE_COORDINATE;
        p.remap[i] = fine ? UNSEEN : BAD;
        l->scene->skipped_vertices += !fine;
    }
    add_triangles(l, &p, from->mode);
    free(p.remap);
    return l->builder.failed ? ex_fail(l->error, "%s: out of memory", l->path) : 0;
}

/* One glTF mesh, all its primitives, becomes one ex_mesh, an empty one where nothing can be drawn: so the numbers of
   the meshes stay those of the file. */
static int load_mesh(loader *l, size_t mesh, size_t *next)
{
    const gltf_file *f = l->file;
    size_t first = *next;
    l->builder.with_uvs = 0;
    for (; *next < f->primitive_count && (size_t)f->primitives[*next].mesh == mesh; (*next)++) {
        int m = f->primitives[*next].material;
        if (m >= 0 && (size_t)m < f->material_count && has_textures(&l->scene->materials[m]))
            l->builder.with_uvs = 1;
    }
    for (size_t i = first; i < *next; i++)
        if (load_primitive(l, &f->primitives[i]) != 0) return -1;
    uint32_t number = ex_build_finish(&l->builder);
    if (l->builder.failed) return ex_fail(l->error, "%s: out of memory", l->path);
    if (!l->scene->rig) return 0;
    return ex_rig_add_shape(l->scene->rig, f, &l->scene->meshes[number], number, l->sources, l->path, l->error);
}

/* ---- materials and textures ---- */

static float to_color(double x) { return x > 0 ? x < 1 ? (float)x : 1.0f : 0.0f; }

/* transmission: KHR_materials_transmission, its texture included. */
static void load_material(const loader *l, const gltf_material *from, double transmission, ex_material *to)
{
    double alpha = from->base_color[3], kept = 1 - (double)to_color(transmission);
    for (int k = 0; k < 3; k++) {
        double e = from->emissive[k] * from->emissive_strength;
        to->base_color[k] = to_color(from->base_color[k]);
        to->emission[k] = e > 0 ? e < 1e9 ? (float)e : 1e9f : 0.0f;
    }
    to->metallic = to_color(from->metallic);
    to->roughness = to_color(from->roughness);
    to->double_sided = from->double_sided != 0;
    to->base_texture = to->normal_texture = to->rough_texture = -1;
    if (from->base_image >= 0 && (size_t)from->base_image < l->file->image_count) to->base_texture = from->base_image;
    /* A mesh has one set of texture coordinates here. */
    if (from->normal_image >= 0 && (size_t)from->normal_image < l->file->image_count &&
        (to->base_texture < 0 || from->normal_uv_set == from->uv_set))
        to->normal_texture = from->normal_image;
    if (from->rough_image >= 0 && (size_t)from->rough_image < l->file->image_count &&
        (to->base_texture < 0 || from->rough_uv_set == from->uv_set) &&
        (to->normal_texture < 0 || from->rough_uv_set == from->normal_uv_set))
        to->rough_texture = from->rough_image;
    /* Blending and glass are beyond a visibility buffer: what lets less than half of the light through is taken as
       solid, the rest is not there. The constant alpha multiplies the texture's, so dividing the cutoff by it once
       says the same. */
    double cutoff = from->alpha_mode == 1 ? from->alpha_cutoff : from->alpha_mode == 2 && kept > 0 ? 0.5 / kept : 0;
    if (cutoff > 0) to->alpha_cutoff = alpha > 1e-6 ? (float)(cutoff / alpha) : 2.0f;
    if (kept < 0.5) to->alpha_cutoff = 2;
}

static int load_texture(const loader *l, const gltf_image *from, ex_texture *to)
{
    size_t channel_bytes = from->bits == 16 ? 2 : 1, channels = from->channels > 0 ? (size_t)from->channels : 0;
    if (from->width <= 0 || from->height <= 0 || from->width > 65536 || from->height > 65536 || channels > 4 ||
        channels == 0 || (from->bits != 8 && from->bits != 16))
        return ex_fail(l->error, "%s: an image has an impossible size or format", l->path);
    size_t count = (size_t)from->width * (size_t)from->height;
    if (!from->pixels || from->bytes / (channels * channel_bytes) < count)
        return ex_fail(l->error, "%s: an image has fewer pixels than it says", l->path);
    to->rgba = (uint8_t *)malloc(4 * count);
    if (!to->rgba) return ex_fail(l->error, "%s: out of memory", l->path);
    to->width = (uint32_t)from->width;
    to->height = (uint32_t)from->height;
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < 4; k++) {
            /* 16-bit channels are little-endian here: tinygltf keeps them as the host's. Grey: 1 or 2 channels. */
            size_t channel = k == 3 ? channels - 1 : channels < 3 ? 0 : k;
            const uint8_t *p = from->pixels + (i * channels + channel) * channel_bytes;
            uint16_t wide = 0;
            if (channel_bytes == 2) memcpy(&wide, p, 2);
            to->rgba[4 * i + k] = k == 3 && channels % 2 == 1 ? 255 : channel_bytes == 2 ? (uint8_t)(wide >> 8) : *p;
        }
    return 0;
}

/* Mean of an image's channels as they are stored, or made linear, found once. No such image: 1. */
static int image_mean(loader *l, int image, int is_srgb, double mean[3])
{
    ex_texture texture;
    mean[0] = mean[1] = mean[2] = 1;
    if (image < 0 || (size_t)image >= l->file->image_count) return 0;
    double *kept = is_srgb ? l->means[image].srgb : l->means[image].plain;
    if (!l->means[image].has[is_srgb]) {
        if (load_texture(l, &l->file->images[image], &texture) != 0) return -1;
        size_t count = (size_t)texture.width * texture.height;
        for (size_t t = 0; t < 4 * count; t++) {
            float value = (float)texture.rgba[t] / 255;
            if (t % 4 < 3) kept[t % 4] += (double)(is_srgb ? ex_srgb_to_linear(value) : value) / (double)count;
        }
        free(texture.rgba);
        l->means[image].has[is_srgb] = 1;
    }
    memcpy(mean, kept, 3 * sizeof *mean);
    return 0;
}

/* A lamp's texture enters as its mean, which keeps the energy: light sources here have one radiance a triangle. Glass
   is there or not there as a whole, and its texture's red enters as its mean too. */
static int load_with_means(loader *l, const gltf_material *from, ex_material *to)
{
    double mean[3] = {1, 1, 1};
    if (from->transmission > 0 && image_mean(l, from->transmission_image, 0, mean) != 0) return -1;
    load_material(l, from, from->transmission * mean[0], to);
    if (!(to->emission[0] + to->emission[1] + to->emission[2] > 0)) return 0;
    if (image_mean(l, from->emissive_image, 1, mean) != 0) return -1;
    for (int k = 0; k < 3; k++) to->emission[k] *= (float)mean[k];
    return 0;
}

static int load_texture_once(const loader *l, int image)
{
    if (image < 0 || l->scene->textures[image].rgba) return 0;
    return load_texture(l, &l->file->images[image], &l->scene->textures[image]);
}

/* All materials of the file, then the default one for primitives that name none. */
static int load_materials(loader *l)
{
    const gltf_file *f = l->file;
    for (size_t i = 0; i <= f->material_count; i++) ex_build_material(&l->builder, 1, 1, 1);
    if (l->builder.failed) return ex_fail(l->error, "%s: out of memory", l->path);
    l->means = (image_means *)calloc(f->image_count + 1, sizeof *l->means);
    if (!l->means) return ex_fail(l->error, "%s: out of memory", l->path);
    for (size_t i = 0; i < f->image_count; i++)
        if (ex_grow(&l->scene->textures, &l->scene->texture_count, sizeof(ex_texture)) != 0)
            return ex_fail(l->error, "%s: out of memory", l->path);
    for (size_t i = 0; i < f->material_count; i++) {
        ex_material *to = &l->scene->materials[i];
        if (load_with_means(l, &f->materials[i], to) != 0) return -1;
        if (load_texture_once(l, to->base_texture) != 0 || load_texture_once(l, to->normal_texture) != 0 ||
            load_texture_once(l, to->rough_texture) != 0)
            return -1;
    }
    return 0;
}

/* Before anything is built. */
static int too_many_triangles(const loader *l)
{
    uint64_t sum = 0;
    for (size_t i = 0; i < l->file->primitive_count; i++) {
        const gltf_primitive *p = &l->file->primitives[i];
        int index = p->indices >= 0 ? p->indices : p->positions;
        if (index >= 0 && (size_t)index < l->file->accessor_count)
            sum += l->file->accessors[index].count / (p->mode == 4 ? 3 : 1);
    }
    return sum > MOST_TRIANGLES;
}

/* ---- nodes ---- */

static void local_matrix(const gltf_node *node, float m[16])
{
    double parts[10];
    memcpy(parts, node->translation, sizeof node->translation);
    memcpy(parts + 3, node->rotation, sizeof node->rotation);
    memcpy(parts + 7, node->scale, sizeof node->scale);
    if (!node->has_matrix) ex_compose(m, parts);
    for (int i = 0; i < 16 && node->has_matrix; i++) m[i] = (float)node->matrix[i];
}

static void load_camera(loader *l, double yfov, const float m[16])
{
    ex_camera *camera = &l->scene->camera;
    v3 back = v3_unit_or(ex_transform_vector(m, v3_make(0, 0, 1)), v3_make(0, 0, 1));
    v3 up = v3_unit(ex_transform_vector(m, v3_make(0, 1, 0))), eye = ex_transform_point(m, v3_make(0, 0, 0));
    if (l->scene->has_camera || !(yfov > 1e-3) || !(yfov < 3.1)) return;
    v3_store(camera->eye, eye);
    v3_store(camera->target, v3_sub(eye, back));
    v3_store(camera->up, up);
    camera->fovy = (float)yfov;
    l->scene->has_camera = 1;
}

/* KHR_lights_punctual: along -Z of the node; lux as W/m^2, candela as W/sr; the spot's soft inner cone is ignored. */
static int load_light(loader *l, const gltf_light *from, const float m[16])
{
    static const ex_light_kind kinds[3] = {EX_LIGHT_SUN, EX_LIGHT_POINT, EX_LIGHT_SPOT};
    double angle = from->outer_angle;
    if (from->kind < 0 || from->kind > 2 || !(from->intensity > 0)) return 0;
    if (!(from->intensity <= MOST_INTENSITY))
        return ex_fail(l->error, "%s: the intensity of a light is %g, at most 1e12 is taken", l->path, from->intensity);
    if (from->kind == 2 && (!(angle > 0) || !(angle < 1.5709))) return 0;
    if (l->scene->light_count == MOST_LIGHTS)
        return ex_fail(l->error, "%s: more than %u lights", l->path, MOST_LIGHTS);
    if (ex_grow(&l->scene->lights, &l->scene->light_count, sizeof(ex_light)) != 0)
        return ex_fail(l->error, "%s: out of memory", l->path);
    ex_light *light = &l->scene->lights[l->scene->light_count - 1];
    light->kind = kinds[from->kind];
    ex_place_light(light, m);
    light->cos_half_angle = (float)cos(angle);
    for (int k = 0; k < 3; k++) light->value[k] = to_color(from->color[k]) * (float)from->intensity;
    return 0;
}

/* The mesh of a node becomes an object. What a skin moves lies in the world, and the node's transform is ignored. */
static int load_object(loader *l, uint32_t number, const float m[16])
{
    const gltf_node *node = &l->file->nodes[number];
    ex_rig *rig = l->scene->rig;
    const int moves = rig ? ex_rig_moves(rig, l->file, number) : 0;
    float transform[16];
    memcpy(transform, m, sizeof transform);
    if (moves == 2) ex_identity(transform);
    if (rig && l->file->animation_count) ex_transform_speck(transform);      /* it may grow */
    if (!ex_transform_usable(transform)) {
        l->scene->skipped_triangles += l->scene->meshes[node->mesh].triangle_count;
        return 0;
    }
    l->placed += l->scene->meshes[node->mesh].triangle_count;
    if (l->placed > MOST_TRIANGLES)
        return ex_fail(l->error, "%s: its nodes place more than %u triangles", l->path, MOST_TRIANGLES);
    if (l->scene->object_count >= MOST_OBJECTS)
        return ex_fail(l->error, "%s: more than %u of its nodes have meshes", l->path, MOST_OBJECTS);
    ex_object *object = ex_build_object(&l->builder, node->name ? node->name : "", (uint32_t)node->mesh);
    if (!object) return ex_fail(l->error, "%s: out of memory", l->path);
    memcpy(object->transform, transform, sizeof object->transform);
    const uint32_t index = l->scene->object_count - 1;
    if (rig && moves < 2 && ex_rig_add_placed(&rig->objects, &rig->object_count, index, number) != 0)
        return ex_fail(l->error, "%s: out of memory", l->path);
    return moves ? ex_rig_add_body(l->scene, l->file, number, index, l->path, l->error) : 0;
}

static int load_node(loader *l, uint32_t number, const float m[16])
{
    const gltf_file *f = l->file;
    const gltf_node *node = &f->nodes[number];
    ex_rig *rig = l->scene->rig;
    if (node->mesh >= 0 && (size_t)node->mesh >= f->mesh_count)
        return ex_fail(l->error, "%s: mesh %d does not exist", l->path, node->mesh);
    if (node->mesh >= 0 && l->scene->meshes[node->mesh].triangle_count > 0 && load_object(l, number, m) != 0) return -1;
    if (!ex_transform_usable(m)) return 0;
    if (node->camera >= 0 && (size_t)node->camera < f->camera_count) load_camera(l, f->yfovs[node->camera], m);
    if (node->light < 0 || (size_t)node->light >= f->light_count) return 0;
    const uint32_t before = l->scene->light_count;
    int failed = 0;
    if (load_light(l, &f->lights[node->light], m) != 0) return -1;
    if (rig && l->scene->light_count > before)
        failed = ex_rig_add_placed(&rig->lights, &rig->light_count, before, number);
    return failed ? ex_fail(l->error, "%s: out of memory", l->path) : 0;
}

typedef struct visit { int node; float matrix[16]; } visit;

/* Depth first with a stack of our own, in the file's order, so that the first camera is the first. glTF wants a forest:
   a node that is reached twice is a cycle or a shared child, and both are refused; so none is on the stack twice. */
static int walk(loader *l, visit *stack, uint8_t *reached)
{
    const gltf_file *f = l->file;
    const int *list = f->roots;
    size_t list_count = f->root_count, depth = 0;
    float parent[16], local[16];
    ex_identity(parent);
    for (;;) {
        for (size_t k = list_count; k-- > 0;) {
            if (list[k] < 0 || (size_t)list[k] >= f->node_count)
                return ex_fail(l->error, "%s: node %d does not exist", l->path, list[k]);
            if (reached[list[k]]++)
                return ex_fail(l->error, "%s: node %d is reached twice: not a tree", l->path, list[k]);
            stack[depth].node = list[k];
            memcpy(stack[depth++].matrix, parent, sizeof parent);
        }
        if (depth == 0) return 0;
        const gltf_node *node = &f->nodes[stack[--depth].node];
        local_matrix(node, local);
        ex_multiply(parent, stack[depth].matrix, local);
        if (load_node(l, (uint32_t)stack[depth].node, parent) != 0) return -1;
        list = node->children;
        list_count = node->child_count;
    }
}

static int load_nodes(loader *l)
{
    visit *stack = (visit *)malloc((l->file->node_count + 1) * sizeof *stack);
    uint8_t *reached = (uint8_t *)calloc(l->file->node_count + 1, 1);
    int result = stack && reached ? walk(l, stack, reached) : ex_fail(l->error, "%s: out of memory", l->path);
    free(stack);
    free(reached);
    return result;
}

/* Takes the place that the file gives everything at rest; what no animation moves then stays there for good. */
static int load_rig(loader *l)
{
    ex_scene *scene = l->scene;
    ex_rig *rig = scene->rig;
    if (ex_rig_add_animation(rig, l->file, (uint32_t)ex_animation, l->path, l->error) != 0) return -1;
    if (ex_rig_pose(scene, -1) != 0) return ex_fail(l->error, "%s: %.200s", l->path, rig->problem);
    scene->animated = rig->channel_count > 0;
    if (scene->animated) {
        scene->pose = ex_rig_pose;
        for (uint32_t i = 0; i < rig->body_count; i++) scene->meshes[rig->bodies[i].mesh].deforms = 1;
        return 0;
    }
    ex_rig_free(rig);
    scene->rig = NULL;
    return 0;
}

static int load_file(void *context, const gltf_file *file, char *error)
{
    loader *l = (loader *)context;
    size_t next = 0;
    l->file = file;
    l->error = error;
    if (file->unsupported)
        return ex_fail(error, "%s: needs the extension %s, which is not supported", l->path, file->unsupported);
    if (too_many_triangles(l))
        return ex_fail(error, "%s: its meshes have more than %u triangles", l->path, MOST_TRIANGLES);
    if (load_materials(l) != 0) return -1;
    if (ex_animation >= 0 && ex_rig_wanted(file)) {
        l->scene->rig = ex_rig_begin(file, l->path, error);
        if (!l->scene->rig) return -1;
    }
    for (size_t i = 0; i < file->mesh_count; i++)
        if (load_mesh(l, i, &next) != 0) return -1;
    if (load_nodes(l) != 0) return -1;
    if (l->scene->object_count == 0) return ex_fail(error, "%s: holds no triangle that can be drawn", l->path);
    return l->scene->rig ? load_rig(l) : 0;
}

int ex_gltf_load(ex_scene *scene, const char *path, char *error)
{
    loader l;
    memset(&l, 0, sizeof l);
    l.scene = scene;
    l.builder.scene = scene;
    l.path = path;
    int result = ex_gltf_check(path, error);
    if (result == 0) result = ex_gltf_parse(path, load_file, &l, error, EX_ERROR_SIZE);
    free(l.means);
    free(l.sources);
    ex_mesh_free(&l.builder.mesh);
    return result;
}

#endif
