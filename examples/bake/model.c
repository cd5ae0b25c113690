/* model.c - see model.h */
#include "model.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- opening ---- */

/* Numbers of the objects that stand for primitives and materials in the JSON. */
static int find_values(bk_model *m, const char *path, char *error)
{
    bk_json *j = &m->glb.json;
    uint32_t mesh_count = 0, count, *meshes = bk_json_items(j, bk_json_member(j, 0, "meshes"), &mesh_count);
    uint32_t at = 0;
    m->primitive_values = calloc((size_t)m->primitives.count + 1, sizeof *m->primitive_values);
    m->materials = bk_json_items(j, m->glb.list_value[BK_MATERIALS], &m->material_count);
    m->users = calloc((size_t)m->material_count + 1, sizeof *m->users);
    for (uint32_t i = 0; i < mesh_count && meshes && m->primitive_values; i++) {
        uint32_t *list = bk_json_items(j, bk_json_member(j, meshes[i], "primitives"), &count);
        for (uint32_t k = 0; k < count && list; k++, at++)
            if (at < m->primitives.count && m->primitives.list[at].mesh == i)
                m->primitive_values[at] = list[k];
        free(list);
    }
    free(meshes);
    if (!m->primitive_values || !m->materials || !m->users)
        return bk_fail(error, "out of memory", "");
    for (uint32_t i = 0; i < m->primitives.count; i++) {
        const bk_primitive *p = &m->primitives.list[i];
        const uint32_t value = m->primitive_values[i];
        if (at != m->primitives.count || !value || !bk_json_member(j, value, "attributes") || j->escaped)
            return bk_fail(error, path, ": its meshes cannot be told apart");
        if (p->material >= 0 && (uint32_t)p->material < m->material_count)
            m->users[p->material]++;
    }
    return 0;
}

int bk_model_open(bk_model *m, const char *path, bk_into into, uint32_t image_side, char *error)
{
    uint8_t *wanted = NULL;
    int result = -1;
    memset(m, 0, sizeof *m);
    if (bk_glb_open(&m->glb, path, error) == 0 && ex_scene_load(&m->scene, path, error) == 0 &&
        bk_primitives_read(&m->primitives, path, error) == 0 && find_values(m, path, error) == 0) {
        wanted = calloc((size_t)m->scene.mesh_count + 1, 1);
        for (uint32_t i = 0; i < m->scene.object_count && wanted; i++)
            wanted[m->scene.objects[i].mesh] = 1;
        result = wanted ? bk_receivers_make(&m->receivers, &m->primitives, wanted, m->scene.mesh_count, into,
                                            image_side, error)
                        : bk_fail(error, "out of memory", "");
    }
    free(wanted);
    if (result != 0)
        bk_model_close(m);
    return result;
}

void bk_model_close(bk_model *m)
{
    bk_receivers_free(&m->receivers);
    bk_primitives_free(&m->primitives);
    bk_glb_free(&m->glb);
    ex_scene_free(&m->scene);
    free(m->primitive_values);
    free(m->materials);
    free(m->users);
    free(m->members.bytes);
    free(m->extras.bytes);
    bk_files_free(m);
    memset(m, 0, sizeof *m);
}

float bk_model_lowest(const bk_model *m)
{
    float low = HUGE_VALF;
    for (uint32_t i = 0; i < m->scene.object_count; i++) {
        const float *t = m->scene.objects[i].transform;
        const ex_mesh *mesh = &m->scene.meshes[m->scene.objects[i].mesh];
        for (size_t v = 0; v < mesh->vertex_count; v++) {
            const float *p = mesh->positions + 3 * v;
            low = fminf(low, t[1] * p[0] + t[5] * p[1] + t[9] * p[2] + t[13]);
        }
    }
    return low;
}

void bk_unit_or(float *v, const float *otherwise)
{
    const float length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int k = 0; k < 3; k++)
        v[k] = length > 1e-12f ? v[k] / length : otherwise[k];
}

/* ---- attributes ---- */

/* Gives an accessor to all primitives of a sheet. */
static void set_attribute(bk_model *m, const bk_sheet *s, const char *name, uint32_t accessor)
{
    char number[16];
    snprintf(number, sizeof number, "%u", (unsigned)accessor);
    for (uint32_t i = 0; i < s->primitive_count; i++)
        bk_glb_set(&m->glb, bk_json_member(&m->glb.json, m->primitive_values[s->primitives[i]], "attributes"), name,
                   number);
}

void bk_model_colors(bk_model *m, const bk_sheet *s, const float *values, int channels, int bits, int replace)
{
    const bk_primitive *p = &m->primitives.list[m->primitives.list[s->primitives[0]].owner];
    const size_t count = p->vertex_count, size = (size_t)bits / 8, stride = 4 * size;
    const float most = bits == 8 ? 255 : 65535;
    float *colors = malloc((4 * count + 1) * sizeof *colors);
    uint8_t *bytes = malloc(stride * count + 1);
    if (!colors || !bytes) {
        m->glb.failed = 1;
        free(colors);
        free(bytes);
        return;
    }
    for (size_t i = 0; i < 4 * count; i++)
        colors[i] = p->colors && (!replace || i % 4 == 3) ? p->colors[i] : 1;
    for (size_t i = 0; i < s->count; i++)
        for (size_t k = 0; k < 3; k++)
            colors[4 * (size_t)m->receivers.places[s->first + i] + k] *=
                values[(size_t)channels * i + (channels > 1 ? k : 0)];
    for (size_t i = 0; i < 4 * count; i++) {
        const uint32_t x = (uint32_t)(fminf(fmaxf(colors[i], 0), 1) * most + 0.5f);
        for (size_t k = 0; k < size; k++)
            bytes[size * i + k] = (uint8_t)(x >> (8 * k));
    }
    set_attribute(m, s, "COLOR_0",
                  bk_glb_add(&m->glb, BK_ACCESSORS,
                             "{\"bufferView\":%u,\"componentType\":%d,\"normalized\":true,\"count\":%u,\"type\":\"VEC4\"}",
                             (unsigned)bk_glb_view(&m->glb, bytes, stride * count, (int)stride, 34962),
                             bits == 8 ? 5121 : 5123, (unsigned)count));
    free(colors);
    free(bytes);
}

void bk_model_vectors(bk_model *m, const bk_sheet *s, const char *name, const float *values)
{
    const bk_primitive *p = &m->primitives.list[m->primitives.list[s->primitives[0]].owner];
    const size_t count = p->vertex_count;
    uint8_t *bytes = malloc(12 * count + 1);
    if (!bytes) {
        m->glb.failed = 1;
        return;
    }
    for (size_t i = 0; i < count + s->count; i++) {
        const size_t vertex = i < count ? i : m->receivers.places[s->first + i - count];
        for (size_t k = 0; k < 3; k++) {
            const float x = i < count ? p->normals[3 * vertex + k] : values[3 * (i - count) + k];
            uint32_t word;
            memcpy(&word, &x, sizeof word);
            for (size_t byte = 0; byte < 4; byte++)
                bytes[12 * vertex + 4 * k + byte] = (uint8_t)(word >> (8 * byte));
        }
    }
    set_attribute(m, s, name,
                  bk_glb_add(&m->glb, BK_ACCESSORS,
                             "{\"bufferView\":%u,\"componentType\":5126,\"count\":%u,\"type\":\"VEC3\"}",
                             (unsigned)bk_glb_view(&m->glb, bytes, 12 * count, 12, 34962), (unsigned)count));
    free(bytes);
}

/* ---- images and materials ---- */

int bk_model_image(bk_model *m, const bk_sheet *s, const char *name, const float *values, int channels,
                   const bk_image_desc *desc, char *error)
{
    const size_t floats = (size_t)channels * s->side * s->side;
    float *texels = bk_image_fill(&m->receivers, s, values, channels, desc);
    bk_text *to = channels == 1 ? &m->members : &m->extras;
    size_t size;
    void *png = NULL;
    uint32_t image;
    for (size_t i = 0; i < floats && texels && channels > 1; i++)
        texels[i] = 0.5f * texels[i] + 0.5f;
    if (texels)
        png = bk_image_png(texels, s->side, channels, desc->bits, &size);
    free(texels);
    if (!png)
        return bk_fail(error, "out of memory for an image", "");
    image = bk_glb_add(&m->glb, BK_IMAGES, "{\"bufferView\":%u,\"mimeType\":\"image/png\"}",
                       (unsigned)bk_glb_view(&m->glb, png, size, 0, 0));
    free(png);
    bk_text_add(to, "%s\"%s\":{\"index\":%u%s}", to->size ? "," : "", name,
                (unsigned)bk_glb_add(&m->glb, BK_TEXTURES, "{\"source\":%u}", (unsigned)image),
                s->uv ? ",\"texCoord\":1" : "");
    return 0;
}

/* An object's text with members added in front, without those of the same names. `without` ends with NULL. */
static void write_object(bk_json *j, uint32_t object, const bk_text *members, const char *const *without, bk_text *out)
{
    const bk_value *o = &j->values[object];
    int first = 1;
    bk_text_add(out, "{");
    bk_text_bytes(out, members->bytes, members->size);
    for (uint32_t key = object + 1; key < o->after; key = j->values[key + 1].after) {
        const bk_value *k = &j->values[key];
        int keep = 1;
        for (int i = 0; without[i]; i++)
            keep &= strlen(without[i]) != k->end - k->begin - 2 ||
                    memcmp(without[i], j->text + k->begin + 1, strlen(without[i]));
        if (!keep)
            continue;
        if (!first || members->size)
            bk_text_add(out, ",");
        first = 0;
        bk_text_bytes(out, j->text + k->begin, j->values[key + 1].end - k->begin);
    }
    bk_text_add(out, "}");
}

/* A material's text with the sheet's images; object 0: a new one. */
static void write_material(bk_model *m, uint32_t object, bk_text *out)
{
    static const char *const images[] = { "occlusionTexture", "extras", NULL };
    static const char *const vectors[] = { "bentNormalTexture", "lightMapTexture",    "lightMapSH0Texture",
                                           "lightMapSH1Texture", "lightMapSH2Texture", "lightMapSH3Texture", NULL };
    bk_json *j = &m->glb.json;
    const uint32_t extras = object ? bk_json_member(j, object, "extras") : 0;
    bk_text members = { NULL, 0, 0, 0 };
    bk_text_bytes(&members, m->members.bytes, m->members.size);
    if (m->extras.size) {
        bk_text_add(&members, "%s\"extras\":", members.size ? "," : "");
        if (extras)
            write_object(j, extras, &m->extras, vectors, &members);
        else {
            bk_text_add(&members, "{");
            bk_text_bytes(&members, m->extras.bytes, m->extras.size);
            bk_text_add(&members, "}");
        }
    }
    if (object)
        write_object(j, object, &members,
                     m->extras.size    ? images
                     : m->members.size ? (const char *const[]){ images[0], NULL }
                                       : images + 2,
                     out);
    else {
        bk_text_add(out, "{");
        bk_text_bytes(out, members.bytes, members.size);
        bk_text_add(out, "}");
    }
    out->failed |= members.failed;
    free(members.bytes);
}

/* The material that primitives of the sheet get which have material `old` (-1: none) now: the file's own object,
   changed, where all that have it are in the sheet; else a new one. */
static int give_material(bk_model *m, const bk_sheet *s, int old, char *error)
{
    const uint32_t object = old >= 0 ? m->materials[old] : 0;
    uint32_t users = 0, number = 0;
    bk_text text = { NULL, 0, 0, 0 };
    char digits[16];
    if (object && m->extras.size) {
        const uint32_t extras = bk_json_member(&m->glb.json, object, "extras");
        if (extras && m->glb.json.values[extras].kind != '{')
            return bk_fail(error, "a material has extras that are no object: nothing can be added to them", "");
    }
    for (uint32_t i = 0; i < s->primitive_count; i++)
        users += m->primitives.list[s->primitives[i]].material == old;
    write_material(m, object, &text);
    bk_text_bytes(&text, "", 1);
    if (text.failed)
        m->glb.failed = 1;
    else if (object && users == m->users[old]) {
        const bk_value *v = &m->glb.json.values[object];
        bk_glb_edit(&m->glb, v->begin, v->end - v->begin, text.bytes);
        free(text.bytes);
        return 0;
    } else number = bk_glb_add(&m->glb, BK_MATERIALS, "%s", text.bytes);
    free(text.bytes);
    snprintf(digits, sizeof digits, "%u", (unsigned)number);
    for (uint32_t i = 0; i < s->primitive_count && !m->glb.failed; i++)
        if (m->primitives.list[s->primitives[i]].material == old)
            bk_glb_set(&m->glb, m->primitive_values[s->primitives[i]], "material", digits);
    return 0;
}

int bk_model_materials(bk_model *m, const bk_sheet *s, char *error)
{
    int result = 0;
    for (uint32_t i = 0; i < s->primitive_count && result == 0; i++) {
        const int material = m->primitives.list[s->primitives[i]].material;
        int seen = 0;
        for (uint32_t k = 0; k < i; k++)
            seen |= m->primitives.list[s->primitives[k]].material == material;
        if (!seen)
            result = give_material(m, s, material, error);
    }
    m->members.size = m->extras.size = 0;
    return result;
}

int bk_model_write(bk_model *m, const char *path, char *error)
{
    void *data;
    size_t size;
    int result = bk_glb_bytes(&m->glb, &data, &size, error);
    if (result != 0)
        return -1;
    result = bk_files_write(m, error);
    if (result == 0 && (result = bk_write(path, data, size, error)) != 0)
        bk_files_remove(m);
    free(data);
    return result;
}
