/* export.c - bake model: a scene as a .glb file: meshes, objects, base colours and emission, without textures. So that
   the built-in scenes can be baked into, and opened elsewhere. */
#include "bake.h"
#include "glb.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const rd_key bk_model_keys[] = {
    { "time", RD_NUMBER, NULL, 0, 1e6, "0", "seconds, of a built-in scene that moves" },
    { NULL, RD_WORD, NULL, 0, 0, NULL, NULL }
};

typedef struct writer {
    bk_text  bin, views, accessors, meshes, nodes, roots, materials;
    uint32_t view_count, mesh_count, node_count;
} writer;

/* Little-endian words of floats or integers, as an accessor; returns its number. */
static uint32_t add_accessor(writer *w, const void *words, size_t count, int components, const char *more)
{
    static const char *const types[] = { "", "SCALAR", "VEC2", "VEC3" };
    const size_t total = count * (size_t)components, at = w->bin.size;
    const char *comma = w->view_count ? "," : "";
    for (size_t i = 0; i < total; i++) {
        uint32_t word;
        uint8_t bytes[4];
        memcpy(&word, (const char *)words + 4 * i, 4);
        for (int k = 0; k < 4; k++)
            bytes[k] = (uint8_t)(word >> (8 * k));
        bk_text_bytes(&w->bin, bytes, 4);
    }
    bk_text_add(&w->views, "%s{\"buffer\":0,\"byteOffset\":%llu,\"byteLength\":%llu}", comma, (unsigned long long)at,
                (unsigned long long)(4 * total));
    bk_text_add(&w->accessors, "%s{\"bufferView\":%u,\"componentType\":%d,\"count\":%llu,\"type\":\"%s\"%s}", comma,
                (unsigned)w->view_count, components == 1 ? 5125 : 5126, (unsigned long long)count, types[components],
                more);
    return w->view_count++;
}

static uint32_t add_positions(writer *w, const ex_mesh *m)
{
    char more[200];
    float low[3] = { HUGE_VALF, HUGE_VALF, HUGE_VALF }, high[3] = { -HUGE_VALF, -HUGE_VALF, -HUGE_VALF };
    for (size_t i = 0; i < 3 * (size_t)m->vertex_count; i++) {
        low[i % 3] = fminf(low[i % 3], m->positions[i]);
        high[i % 3] = fmaxf(high[i % 3], m->positions[i]);
    }
    snprintf(more, sizeof more, ",\"min\":[%.9g,%.9g,%.9g],\"max\":[%.9g,%.9g,%.9g]", (double)low[0], (double)low[1],
             (double)low[2], (double)high[0], (double)high[1], (double)high[2]);
    return add_accessor(w, m->positions, m->vertex_count, 3, more);
}

/* One primitive a material, all with the same vertices. */
static int add_mesh(writer *w, const ex_scene *scene, const ex_mesh *m)
{
    const uint32_t positions = add_positions(w, m), normals = add_accessor(w, m->normals, m->vertex_count, 3, "");
    uint32_t *index = malloc(3 * (size_t)m->triangle_count * sizeof *index + 1);
    int count = 0;
    if (!index)
        return -1;
    bk_text_add(&w->meshes, "%s{\"primitives\":[", w->mesh_count++ ? "," : "");
    for (uint32_t material = 0; material < scene->material_count; material++) {
        size_t n = 0;
        for (size_t t = 0; t < m->triangle_count; t++)
            if (m->materials[t] == material) {
                memcpy(index + n, m->indices + 3 * t, 12);
                n += 3;
            }
        if (n)
            bk_text_add(&w->meshes, "%s{\"attributes\":{\"POSITION\":%u,\"NORMAL\":%u},\"indices\":%u,\"material\":%u}",
                        count++ ? "," : "", (unsigned)positions, (unsigned)normals,
                        (unsigned)add_accessor(w, index, n, 1, ""), (unsigned)material);
    }
    bk_text_add(&w->meshes, "]}");
    free(index);
    return 0;
}

static void add_materials(writer *w, const ex_scene *s)
{
    for (uint32_t i = 0; i < s->material_count; i++) {
        const ex_material *m = &s->materials[i];
        const float *e = m->emission, most = fmaxf(fmaxf(e[0], fmaxf(e[1], e[2])), 1e-30f);
        bk_text_add(&w->materials,
                    "%s{\"pbrMetallicRoughness\":{\"baseColorFactor\":[%.6g,%.6g,%.6g,1],\"metallicFactor\":%.6g,"
                    "\"roughnessFactor\":%.6g}%s", i ? "," : "", (double)m->base_color[0], (double)m->base_color[1],
                    (double)m->base_color[2], (double)m->metallic, (double)m->roughness,
                    m->double_sided ? ",\"doubleSided\":true" : "");
        if (most > 1e-29f)
            bk_text_add(&w->materials, ",\"emissiveFactor\":[%.6g,%.6g,%.6g],\"extensions\":"
                        "{\"KHR_materials_emissive_strength\":{\"emissiveStrength\":%.6g}}", (double)(e[0] / most),
                        (double)(e[1] / most), (double)(e[2] / most), (double)most);
        bk_text_add(&w->materials, "}");
    }
}

/* Objects of meshes with triangles, but for planes that only receive (ground=auto stands for them); number: of each
 * mesh in the file. */
static void add_nodes(writer *w, const ex_scene *s, const uint32_t *number)
{
    for (uint32_t i = 0; i < s->object_count; i++) {
        const float *m = s->objects[i].transform;
        if (!s->meshes[s->objects[i].mesh].triangle_count || s->objects[i].receiver_only)
            continue;
        bk_text_add(&w->nodes, "%s{\"name\":\"%.40s\",\"mesh\":%u,\"matrix\":[", w->node_count ? "," : "",
                    s->objects[i].name, (unsigned)number[s->objects[i].mesh]);
        for (int k = 0; k < 16; k++)
            bk_text_add(&w->nodes, "%s%.9g", k ? "," : "", (double)m[k]);
        bk_text_add(&w->nodes, "]}");
        bk_text_add(&w->roots, "%s%u", w->node_count ? "," : "", (unsigned)w->node_count);
        w->node_count++;
    }
}

static void add_word(bk_text *out, size_t value)
{
    for (int i = 0; i < 4; i++) {
        const uint8_t byte = (uint8_t)(value >> (8 * i));
        bk_text_bytes(out, &byte, 1);
    }
}

/* The whole file. */
static void join(writer *w, bk_text *out)
{
    bk_text json = { NULL, 0, 0, 0 };
    struct { const char *name; const bk_text *items; } lists[] = {
        { "nodes", &w->nodes }, { "meshes", &w->meshes }, { "materials", &w->materials },
        { "accessors", &w->accessors }, { "bufferViews", &w->views } };
    bk_text_add(&json, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"Dapple bake model\"},\"extensionsUsed\":"
                "[\"KHR_materials_emissive_strength\"],\"scene\":0,\"scenes\":[{\"nodes\":[");
    bk_text_bytes(&json, w->roots.bytes, w->roots.size);
    bk_text_add(&json, "]}]");
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++) {
        bk_text_add(&json, ",\"%s\":[", lists[i].name);
        bk_text_bytes(&json, lists[i].items->bytes, lists[i].items->size);
        bk_text_add(&json, "]");
        json.failed |= lists[i].items->failed;
    }
    bk_text_add(&json, ",\"buffers\":[{\"byteLength\":%llu}]}", (unsigned long long)w->bin.size);
    while (json.size % 4 && !json.failed)
        bk_text_add(&json, " ");
    bk_text_add(out, "glTF");
    add_word(out, 2);
    add_word(out, 28 + json.size + w->bin.size);
    add_word(out, json.size);
    bk_text_add(out, "JSON");
    bk_text_bytes(out, json.bytes, json.size);
    add_word(out, w->bin.size);
    bk_text_bytes(out, "BIN", 4);
    bk_text_bytes(out, w->bin.bytes, w->bin.size);
    out->failed |= json.failed | w->bin.failed;
    free(json.bytes);
}

static int write_scene(const ex_scene *scene, const char *path, char *error)
{
    writer w;
    bk_text out = { NULL, 0, 0, 0 };
    uint32_t *number = calloc((size_t)scene->mesh_count + 1, sizeof *number);
    int result = number ? 0 : -1;
    memset(&w, 0, sizeof w);
    for (uint32_t i = 0; i < scene->mesh_count && result == 0; i++)
        if (scene->meshes[i].triangle_count) {
            number[i] = w.mesh_count;
            result = add_mesh(&w, scene, &scene->meshes[i]);
        }
    if (result == 0) {
        add_materials(&w, scene);
        add_nodes(&w, scene, number);
        join(&w, &out);
    }
    if (result != 0 || out.failed)
        result = bk_fail(error, "out of memory", "");
    else result = out.size <= UINT32_MAX ? bk_write(path, out.bytes, out.size, error)
                                         : bk_fail(error, "a .glb file holds 4 GiB, and this is more", "");
    free(number);
    free(w.bin.bytes), free(w.views.bytes), free(w.accessors.bytes), free(w.meshes.bytes), free(w.nodes.bytes);
    free(w.roots.bytes), free(w.materials.bytes), free(out.bytes);
    return result;
}

int bk_model_run(const bk_args *args, char *error)
{
    const char *path = args->files[0];
    ex_scene scene;
    int result = strncmp(path, "builtin:", 8) == 0
                     ? ex_scene_builtin(&scene, path + 8, (float)rd_setting_number(&args->settings, "time"), error)
                     : ex_scene_load(&scene, path, error);
    if (result != 0)
        return -1;
    result = write_scene(&scene, args->out, error);
    ex_scene_free(&scene);
    return result;
}
