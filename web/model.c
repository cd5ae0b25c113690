/* model.c - see stage.h: a model on the GPU, and as one mesh for those who build of it. */
#include "stage.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FLOATS = 12 };      /* position, normal, texture coordinates, tangent and its handedness */

static int no_memory(char *error)
{
    snprintf(error, EX_ERROR_SIZE, "out of memory");
    return -1;
}

/* The ground ends where the stage shows the backdrop in its place. Of much larger triangles a rasterizer may get the depths
   wrong: SwiftShader hid a chess board below a table that was 142 metres wide and lay 2.5 mm lower. */
static void end_ground(const pg_model *model, const ex_object *ground)
{
    const ex_mesh *mesh = &model->scene.meshes[ground->mesh];
    const float half = PG_GROUND_END * model->radius;
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        for (int k = 0; k < 3; k += 2) {
            const float middle = model->center[k] - ground->transform[12 + k];      /* grounds are moved, not turned */
            float *p = &mesh->positions[3 * (size_t)i + (size_t)k];
            *p = fminf(fmaxf(*p, middle - half), middle + half);
        }
}

/* Whether the scene has a ground, and how high it lies. */
static int find_ground(pg_model *model)
{
    const ex_scene *scene = &model->scene;
    for (uint32_t i = 0; i < scene->object_count; i++) {
        const float *m = scene->objects[i].transform, *p = scene->meshes[scene->objects[i].mesh].positions;
        if (!scene->objects[i].receiver_only) continue;
        model->ground = m[1] * p[0] + m[5] * p[1] + m[9] * p[2] + m[13];
        end_ground(model, &scene->objects[i]);
        return 1;
    }
    return 0;
}

int pg_model_take(pg_model *model, ex_scene *scene, int with_ground, char *error)
{
    memset(model, 0, sizeof *model);
    model->scene = *scene;
    memset(scene, 0, sizeof *scene);
    if (ex_scene_bounds(&model->scene, model->center, &model->radius) != 0) {
        snprintf(error, EX_ERROR_SIZE, "there is no surface in it");
        ex_scene_free(&model->scene);
        return -1;
    }
    model->ground = model->center[1] - 10 * model->radius;
    if (find_ground(model) || !with_ground) return 0;
    if (ex_scene_add_ground(&model->scene) == 0 && find_ground(model)) return 0;
    ex_scene_free(&model->scene);
    return no_memory(error);
}

/* ---- to the GPU ---- */

static int upload_texture(glbk_context *gl, const ex_texture *from, glbk_format format, glbk_texture *out)
{
    glbk_texture_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.format = format;
    desc.width = from->width;
    desc.height = from->height;
    desc.sampling = GLBK_SAMPLING_MIPMAPS;
    desc.repeat = 1;
    desc.data = from->rgba;
    return glbk_texture_create(gl, &desc, out) == GLBK_OK ? 0 : -1;
}

/* Tangents: which way the first texture coordinate grows at each vertex, the mean over its triangles. */
static void add_tangents(const ex_mesh *mesh, float *vertices)
{
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *c = mesh->indices + 3 * (size_t)t;
        float *v[3], e[2][5], area, along[3];
        for (int k = 0; k < 3; k++) v[k] = vertices + (size_t)FLOATS * c[k];
        for (int k = 0; k < 5; k++) {
            const int at = k < 3 ? k : k + 3;       /* x, y, z, and the two texture coordinates */
            e[0][k] = v[1][at] - v[0][at];
            e[1][k] = v[2][at] - v[0][at];
        }
        area = e[0][3] * e[1][4] - e[1][3] * e[0][4];
        for (int k = 0; k < 3; k++) along[k] = (e[0][k] * e[1][4] - e[1][k] * e[0][4]) * (area < 0 ? -1.0f : 1.0f);
        for (int corner = 0; corner < 3; corner++) {
            for (int k = 0; k < 3; k++) v[corner][8 + k] += along[k];
            v[corner][11] = area < 0 ? -1.0f : 1.0f;
        }
    }
}

/* Makes the buffer, or fills the one that is there. */
static int upload_vertices(glbk_context *gl, const ex_mesh *mesh, pg_mesh *out)
{
    size_t bytes = (size_t)mesh->vertex_count * FLOATS * sizeof(float);
    float *vertices = calloc(1, bytes + 1);
    glbk_result result;
    if (!vertices) return -1;
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        float *v = vertices + (size_t)FLOATS * i;
        memcpy(v, mesh->positions + 3 * (size_t)i, 3 * sizeof *v);
        memcpy(v + 3, mesh->normals + 3 * (size_t)i, 3 * sizeof *v);
        v[6] = mesh->uvs ? mesh->uvs[2 * (size_t)i] : 0;
        v[7] = mesh->uvs ? mesh->uvs[2 * (size_t)i + 1] : 0;
    }
    if (mesh->uvs) add_tangents(mesh, vertices);
    if (out->vertices.name) result = glbk_buffer_update(gl, &out->vertices, 0, bytes, vertices);
    else result = glbk_buffer_create(gl, bytes, vertices, &out->vertices);
    free(vertices);
    return result == GLBK_OK ? 0 : -1;
}

static void describe_vertices(glbk_context *gl, pg_mesh *out)
{
    static const int32_t counts[4] = { 3, 3, 2, 4 };
    const glbk_functions *f = &gl->gl;
    uintptr_t at = 0;
    f->GenVertexArrays(1, &out->vertex_array);
    f->BindVertexArray(out->vertex_array);
    f->BindBuffer(GLBK_GL_ARRAY_BUFFER, out->vertices.name);
    f->BindBuffer(GLBK_GL_ELEMENT_ARRAY_BUFFER, out->indices.name);
    for (uint32_t i = 0; i < 4; i++) {
        f->EnableVertexAttribArray(i);
        f->VertexAttribPointer(i, counts[i], GLBK_GL_FLOAT, 0, FLOATS * sizeof(float), (const void *)at);
        at += (uintptr_t)counts[i] * sizeof(float);
    }
    f->BindVertexArray(0);
}

/* Triangles of one material after the other, and where each begins: starts has a place for each material and the
   end. */
static int upload_indices(glbk_context *gl, const ex_scene *scene, const ex_mesh *mesh, pg_mesh *out, uint32_t *starts)
{
    uint32_t *sorted = malloc(3 * (size_t)mesh->triangle_count * sizeof *sorted + 1), *next;
    glbk_result result = GLBK_ERR_ALLOC;
    next = malloc((scene->material_count + 1) * sizeof *next);
    memset(starts, 0, (scene->material_count + 1) * sizeof *starts);
    for (uint32_t t = 0; t < mesh->triangle_count; t++) starts[mesh->materials[t] + 1]++;
    for (uint32_t m = 0; m < scene->material_count; m++) starts[m + 1] += starts[m];
    if (sorted && next) {
        memcpy(next, starts, (scene->material_count + 1) * sizeof *next);
        for (uint32_t t = 0; t < mesh->triangle_count; t++)
            memcpy(sorted + 3 * (size_t)next[mesh->materials[t]]++, mesh->indices + 3 * (size_t)t, 3 * sizeof *sorted);
        result = glbk_indices_create(gl, 3 * (size_t)mesh->triangle_count * sizeof *sorted, sorted, &out->indices);
    }
    free(sorted);
    free(next);
    return result == GLBK_OK ? 0 : -1;
}

/* The parts of all objects that share a mesh. */
static void list_parts(pg_model *model, uint32_t mesh, const uint32_t *starts)
{
    const ex_scene *scene = &model->scene;
    for (uint32_t i = 0; i < scene->object_count; i++) {
        const ex_object *object = &scene->objects[i];
        uint32_t all = scene->meshes[mesh].triangle_count;
        if (object->mesh != mesh) continue;
        for (uint32_t m = 0; m < scene->material_count; m++) {
            pg_part part = { i, m, 3 * starts[m], 3 * (starts[m + 1] - starts[m]) };
            if (object->material && object->material - 1 != m) continue;
            if (object->material) part.first = 0, part.count = 3 * all;
            if (part.count) model->parts[model->part_count++] = part;
        }
    }
}

/* Colours, and what some materials take for normals, or roughness and metal. */
static int upload_textures(pg_model *model, glbk_context *gl)
{
    const ex_scene *scene = &model->scene;
    int failed = 0;
    for (uint32_t i = 0; i < scene->material_count && !failed; i++) {
        const ex_material *m = &scene->materials[i];
        const int color = m->base_texture, plain[2] = { m->normal_texture, m->rough_texture };
        if (color >= 0 && !model->textures[color].name)
            failed = upload_texture(gl, &scene->textures[color], GLBK_FORMAT_SRGB8_A8, &model->textures[color]);
        for (int k = 0; k < 2; k++)
            if (plain[k] >= 0 && !model->plain_maps[plain[k]].name)
                failed |= upload_texture(gl, &scene->textures[plain[k]], GLBK_FORMAT_RGBA8, &model->plain_maps[plain[k]]);
    }
    return failed ? -1 : 0;
}

int pg_model_upload(pg_model *model, glbk_context *gl, char *error)
{
    const ex_scene *scene = &model->scene;
    uint32_t *starts = malloc((scene->material_count + 1) * sizeof *starts);
    int failed = !starts;
    model->meshes = calloc(scene->mesh_count + 1u, sizeof *model->meshes);
    model->textures = calloc(scene->texture_count + 1u, sizeof *model->textures);
    model->plain_maps = calloc(scene->texture_count + 1u, sizeof *model->plain_maps);
    model->parts = calloc((size_t)scene->object_count * scene->material_count + 1, sizeof *model->parts);
    failed |= !model->meshes || !model->textures || !model->plain_maps || !model->parts;
    if (!failed) failed = upload_textures(model, gl) != 0;
    for (uint32_t i = 0; i < scene->mesh_count && !failed; i++) {
        pg_mesh *mesh = &model->meshes[i];
        if (!scene->meshes[i].triangle_count) continue;
        failed = upload_vertices(gl, &scene->meshes[i], mesh) != 0 ||
                 upload_indices(gl, scene, &scene->meshes[i], mesh, starts) != 0;
        if (failed) break;
        describe_vertices(gl, mesh);
        list_parts(model, i, starts);
    }
    free(starts);
    return failed ? no_memory(error) : 0;
}

int pg_model_update(pg_model *model, glbk_context *gl, char *error)
{
    for (uint32_t i = 0; i < model->scene.mesh_count; i++)
        if (model->scene.meshes[i].deforms && model->meshes[i].vertices.name &&
            upload_vertices(gl, &model->scene.meshes[i], &model->meshes[i]) != 0)
            return no_memory(error);
    return 0;
}

void pg_model_release(pg_model *model, glbk_context *gl)
{
    for (uint32_t i = 0; model->meshes && i < model->scene.mesh_count; i++) {
        if (model->meshes[i].vertex_array && !gl->lost) gl->gl.DeleteVertexArrays(1, &model->meshes[i].vertex_array);
        glbk_buffer_free(gl, &model->meshes[i].vertices);
        glbk_buffer_free(gl, &model->meshes[i].indices);
    }
    for (uint32_t i = 0; model->textures && i < model->scene.texture_count; i++)
        glbk_texture_free(gl, &model->textures[i]);
    for (uint32_t i = 0; model->plain_maps && i < model->scene.texture_count; i++)
        glbk_texture_free(gl, &model->plain_maps[i]);
    free(model->plain_maps);
    free(model->meshes);
    free(model->textures);
    free(model->parts);
    model->meshes = NULL;
    model->textures = model->plain_maps = NULL;
    model->parts = NULL;
    model->part_count = 0;
}

void pg_model_free(pg_model *model, glbk_context *gl)
{
    pg_model_release(model, gl);
    ex_scene_free(&model->scene);
    memset(model, 0, sizeof *model);
}

/* ---- drawing ---- */

static void multiply(const float a[16], const float b[16], float out[16])
{
    for (int c = 0; c < 4; c++)
        for (int r = 0; r < 4; r++) {
            float sum = 0;
            for (int k = 0; k < 4; k++) sum += a[4 * k + r] * b[4 * c + k];
            out[4 * c + r] = sum;
        }
}

static void describe_surface(const pg_model *model, const pg_part *part, const pg_draw *draw, glbk_surface *out)
{
    const ex_object *object = &model->scene.objects[part->object];
    const ex_material *material = &model->scene.materials[part->material];
    memset(out, 0, sizeof *out);
    if (draw->transform) multiply(draw->transform, object->transform, out->transform);
    else memcpy(out->transform, object->transform, sizeof out->transform);
    out->material.kind = LSAMP_MATERIAL_METAL_ROUGH;
    for (int k = 0; k < 3; k++) out->material.diffuse[k] = fminf(material->base_color[k], 1);
    out->material.metallic = material->metallic;
    out->material.roughness = material->roughness;
    out->alpha_cutoff = material->alpha_cutoff;
    if (material->base_texture >= 0) out->color_map = &model->textures[material->base_texture];
    if (material->rough_texture >= 0) out->gloss_map = &model->plain_maps[material->rough_texture];
    if (material->normal_texture >= 0) out->normal_map = &model->plain_maps[material->normal_texture];
    if (object->receiver_only) out->plane = 1;
    else if (!draw->first_entity) out->entity = 1;
    else if (part->object >= draw->first_entity) out->entity = part->object - draw->first_entity + 1;
}

glbk_result pg_model_draw(const pg_model *model, glbk_context *gl, const pg_draw *draw)
{
    glbk_result result = GLBK_OK;
    for (uint32_t i = 0; i < model->part_count && result == GLBK_OK; i++) {
        const pg_part *part = &model->parts[i];
        const ex_object *object = &model->scene.objects[part->object];
        const void *at = (const void *)(part->first * sizeof(uint32_t));
        glbk_surface surface;
        if (draw->casters && object->receiver_only) continue;
        describe_surface(model, part, draw, &surface);
        result = draw->set(draw->user, gl, &surface);
        gl->gl.BindVertexArray(model->meshes[object->mesh].vertex_array);
        if (draw->instances)
            gl->gl.DrawElementsInstanced(GLBK_GL_TRIANGLES, (int32_t)part->count, GLBK_GL_UNSIGNED_INT, at,
                                         (int32_t)draw->instances);
        else gl->gl.DrawElements(GLBK_GL_TRIANGLES, (int32_t)part->count, GLBK_GL_UNSIGNED_INT, at);
    }
    gl->gl.BindVertexArray(0);
    return result;
}

/* ---- one mesh ---- */

int pg_model_merge(const pg_model *model, float **positions, size_t *vertex_count, uint32_t **indices,
                   size_t *index_count)
{
    const ex_scene *scene = &model->scene;
    size_t vertices = 0, corners = 0, v = 0, c = 0;
    for (uint32_t i = 0; i < scene->object_count; i++) {
        const ex_mesh *mesh = &scene->meshes[scene->objects[i].mesh];
        if (scene->objects[i].receiver_only) continue;
        vertices += mesh->vertex_count;
        corners += 3 * (size_t)mesh->triangle_count;
    }
    *positions = malloc(3 * vertices * sizeof **positions + 1);
    *indices = malloc(corners * sizeof **indices + 1);
    if (!*positions || !*indices) {
        free(*positions);
        free(*indices);
        return -1;
    }
    for (uint32_t i = 0; i < scene->object_count; i++) {
        const ex_object *object = &scene->objects[i];
        const ex_mesh *mesh = &scene->meshes[object->mesh];
        const float *m = object->transform;
        if (object->receiver_only) continue;
        for (size_t k = 0; k < 3 * (size_t)mesh->triangle_count; k++) (*indices)[c++] = (uint32_t)v + mesh->indices[k];
        for (uint32_t k = 0; k < mesh->vertex_count; k++, v++) {
            const float *p = mesh->positions + 3 * (size_t)k;
            for (int r = 0; r < 3; r++)
                (*positions)[3 * v + (size_t)r] = m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r];
        }
    }
    *vertex_count = vertices;
    *index_count = corners;
    return 0;
}
