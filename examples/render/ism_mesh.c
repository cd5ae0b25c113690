/* ism_mesh.c - the scene as ism.h takes it: one mesh in world space; and the view of the G-buffer. */
#include "ism_parts.h"
#include "ground.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void im_mesh_free(im_mesh *m)
{
    free(m->positions);
    free(m->indices);
    free(m->albedos);
    free(m->opacities);
    free(m->origins);
    memset(m, 0, sizeof *m);
}

/* Mean colour and, of cut-out materials, the share that is there: at seven points of the triangle. */
static void triangle_color(const ex_scene *scene, const ex_object *object, uint32_t triangle, float albedo[3],
                           float *opacity)
{
    static const float at[7][2] = { { 0.333f, 0.333f }, { 0.06f, 0.47f }, { 0.47f, 0.06f }, { 0.47f, 0.47f },
                                    { 0.8f, 0.1f }, { 0.1f, 0.8f }, { 0.1f, 0.1f } };
    const ex_material *material = &scene->materials[ex_object_material(scene, object, triangle)];
    int count = material->base_texture >= 0 ? 7 : 1;
    float there = 0;
    albedo[0] = albedo[1] = albedo[2] = 0;
    for (int i = 0; i < count; i++) {
        float weights[3] = { 1 - at[i][0] - at[i][1], at[i][0], at[i][1] }, color[3];
        if (!ex_surface_color(scene, object, triangle, weights, color))
            continue;
        there++;
        for (int k = 0; k < 3; k++)
            albedo[k] += color[k];
    }
    for (int k = 0; k < 3; k++)
        albedo[k] /= there > 0 ? there : 1;
    *opacity = material->alpha_cutoff > 0 ? there / (float)count : 1;
}

static int is_there(void *user, uint32_t triangle, const float weights[3])
{
    const im_masked *masked = user;
    const im_origin *from = &masked->origins[triangle];
    float albedo[3];
    return !from->object || ex_surface_color(masked->scene, from->object, from->triangle, weights, albedo);
}

/* How holes of alpha masks are told to ism.h: point by point, or as the share of a triangle that is there. */
static void set_mask(im_mesh *m, const rd_job *job)
{
    if (job->settings && rd_setting_is(job->settings, "mask", "share")) {      /* benchmarks have none */
        m->mesh.opacities = m->opacities;
        return;
    }
    m->mesh.mask_fn = is_there;
    m->mesh.user = &m->masked;
    m->masked.scene = m->masked_casters.scene = job->scene;
    m->masked.origins = m->masked_casters.origins = m->origins;
}

static void add_object(im_mesh *m, const ex_scene *scene, const ex_object *object, size_t vertex, size_t triangle)
{
    const ex_mesh *mesh = &scene->meshes[object->mesh];
    const float *t = object->transform;
    for (size_t i = 0; i < mesh->vertex_count; i++)
        for (size_t k = 0; k < 3; k++) {
            const float *p = mesh->positions + 3 * i;
            m->positions[3 * (vertex + i) + k] = t[k] * p[0] + t[4 + k] * p[1] + t[8 + k] * p[2] + t[12 + k];
        }
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++)
        m->indices[3 * triangle + i] = (uint32_t)vertex + mesh->indices[i];
    for (uint32_t i = 0; i < mesh->triangle_count; i++)
        triangle_color(scene, object, i, m->albedos + 3 * (triangle + i), m->opacities + triangle + i);
    for (uint32_t i = 0; m->origins && i < mesh->triangle_count; i++) {
        m->origins[triangle + i].object = object;
        m->origins[triangle + i].triangle = i;
    }
}

/* Ground, or all but that. */
static void add_objects(im_mesh *m, const ex_scene *scene, int has_ground, int ground)
{
    for (uint32_t i = 0; i < scene->object_count; i++) {
        const ex_object *object = &scene->objects[i];
        const ex_mesh *mesh = &scene->meshes[object->mesh];
        if ((has_ground && object->receiver_only) != ground)
            continue;
        add_object(m, scene, object, m->mesh.vertex_count, m->mesh.index_count / 3);
        m->mesh.vertex_count += mesh->vertex_count;
        m->mesh.index_count += 3 * (size_t)mesh->triangle_count;
    }
}

/* Two triangles that `casters` begins with. Their albedo is not asked for: sky does not bounce by its maps. */
static void add_near_ground(im_mesh *m, float corners[4][3])
{
    static const uint32_t indices[6] = { 0, 1, 2, 0, 2, 3 };
    memcpy(m->positions, corners, 12 * sizeof(float));
    memcpy(m->indices, indices, sizeof indices);
    memset(m->albedos, 0, 6 * sizeof *m->albedos);
    m->opacities[0] = m->opacities[1] = 1;
    m->mesh.vertex_count = 4;
    m->mesh.index_count = 6;
}

int im_mesh_build(im_mesh *m, const rd_job *job, char *error)
{
    const ex_scene *scene = job->scene;
    size_t vertices = 4, triangles = 2;
    float corners[4][3];
    int cutouts = 0, ground = rd_ground_near(job, corners);
    memset(m, 0, sizeof *m);
    for (uint32_t i = 0; i < scene->object_count; i++) {
        vertices += scene->meshes[scene->objects[i].mesh].vertex_count;
        triangles += scene->meshes[scene->objects[i].mesh].triangle_count;
    }
    for (uint32_t i = 0; i < scene->material_count; i++)
        cutouts |= scene->materials[i].alpha_cutoff > 0;
    m->positions = malloc(3 * vertices * sizeof *m->positions);
    m->indices = malloc(3 * triangles * sizeof *m->indices);
    m->albedos = malloc(3 * triangles * sizeof *m->albedos);
    m->opacities = malloc(triangles * sizeof *m->opacities);
    if (cutouts)
        m->origins = calloc(triangles, sizeof *m->origins);
    if (!m->positions || !m->indices || !m->albedos || !m->opacities || (cutouts && !m->origins) ||
        vertices > UINT32_MAX) {
        im_mesh_free(m);
        return im_out_of_memory(error);
    }
    m->mesh.positions = m->positions;
    m->mesh.indices = m->indices;
    m->mesh.albedos = m->albedos;
    if (cutouts)
        set_mask(m, job);
    if (ground)
        add_near_ground(m, corners);
    add_objects(m, scene, ground, 0);
    m->casters = m->mesh;
    m->casters.user = m->mesh.user ? &m->masked_casters : NULL;
    add_objects(m, scene, ground, 1);
    if (ground) {                                /* without the two triangles; their corners stay */
        m->mesh.indices += 6;
        m->mesh.index_count -= 6;
        m->mesh.albedos += 6;
        if (m->mesh.opacities)
            m->mesh.opacities += 2;
        m->masked.origins += m->origins ? 2 : 0;
    }
    return 0;
}

/* World to clip of the scene's camera; depth does not matter to ism.h. */
static void camera_matrix(float m[16], const ex_scene *scene, double aspect)
{
    const ex_camera *c = &scene->camera;
    double back[3], right[3], up[3], length = 0, across = 0, f = 1 / tan(0.5 * (double)c->fovy);
    for (int k = 0; k < 3; k++) {
        back[k] = (double)c->eye[k] - (double)c->target[k];
        length += back[k] * back[k];
    }
    for (int k = 0; k < 3; k++)
        back[k] /= sqrt(length);
    for (int k = 0; k < 3; k++) {
        right[k] = (double)c->up[(k + 1) % 3] * back[(k + 2) % 3] - (double)c->up[(k + 2) % 3] * back[(k + 1) % 3];
        across += right[k] * right[k];
    }
    memset(m, 0, 16 * sizeof *m);
    if (!(across > 1e-12))
        return;                                  /* the matrix of all zeros: unknown */
    for (int k = 0; k < 3; k++)
        right[k] /= sqrt(across);
    for (int k = 0; k < 3; k++)
        up[k] = back[(k + 1) % 3] * right[(k + 2) % 3] - back[(k + 2) % 3] * right[(k + 1) % 3];
    for (int k = 0; k < 3; k++) {
        double eye = (double)c->eye[k];
        m[4 * k] = (float)(right[k] * f / aspect);
        m[4 * k + 1] = (float)(up[k] * f);
        m[4 * k + 2] = m[4 * k + 3] = (float)-back[k];
        m[12] -= (float)(right[k] * f / aspect * eye);
        m[13] -= (float)(up[k] * f * eye);
        m[15] += (float)(back[k] * eye);
    }
    m[14] = m[15] - 0.01f;
}

void im_view(ism_points *out, const rd_job *job)
{
    const ex_pixel *first = job->gbuffer->pixels;
    memset(out, 0, sizeof *out);
    out->positions = first->position;
    out->normals = first->normal;
    out->geometric_normals = first->geometric;
    out->albedos = first->albedo;
    out->position_stride = out->normal_stride = out->geometric_normal_stride = out->albedo_stride = sizeof *first;
    out->width = job->gbuffer->width;
    out->count = (size_t)job->gbuffer->width * job->gbuffer->height;
    camera_matrix(out->world_to_clip, job->scene, (double)job->gbuffer->width / job->gbuffer->height);
    out->rows = ISM_ROWS_TOP_FIRST;
}
