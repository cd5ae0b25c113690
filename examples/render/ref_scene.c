/* ref_scene.c - see ref_scene.h */
#include "ref_scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifndef DAPPLE_EMBREE
#define DAPPLE_EMBREE 0
#endif

#if DAPPLE_EMBREE == 0

const char *rf_scene_version(void) { return NULL; }
void rf_scene_free(rf_scene *scene) { (void)scene; }

rf_scene *rf_scene_create(const ex_scene *scene, int threads, char *error)
{
    (void)scene, (void)threads;
    snprintf(error, EX_ERROR_SIZE, "needs Embree: apt-get install libembree-dev");
    return NULL;
}

void rf_scene_memory(const rf_scene *scene, uint64_t *now, uint64_t *peak)
{
    (void)scene;
    *now = *peak = 0;
}

int rf_scene_trace(const rf_scene *scene, rf_v3 origin, rf_v3 direction, double near_distance, rf_hit *hit)
{
    (void)scene, (void)origin, (void)direction, (void)near_distance, (void)hit;
    return 0;
}

int rf_scene_blocked(const rf_scene *scene, rf_v3 origin, rf_v3 direction, double length)
{
    (void)scene, (void)origin, (void)direction, (void)length;
    return 0;
}

#else

#if DAPPLE_EMBREE == 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

typedef struct rf_object {
    const ex_scene  *scene;
    const ex_object *source;
    const ex_mesh   *mesh;
    const float     *vertices;  /* world space, owned by Embree */
    rf_v3            normal_x, normal_y, normal_z;      /* columns of the matrix that transforms normals */
    int              mirrored; /* the transform turns the triangles' winding round */
} rf_object;

struct rf_scene {
    RTCDevice  device;
    RTCScene   scene;
    rf_object *objects;        /* geometry i is object i */
    long long  bytes, peak;
};

const char *rf_scene_version(void) { return "Embree " RTC_VERSION_STRING; }

/* Embree calls this from its own threads. */
static bool count_bytes(void *user, ssize_t bytes, bool post)
{
    rf_scene *scene = user;
    long long now = __atomic_add_fetch(&scene->bytes, bytes, __ATOMIC_RELAXED);
    long long peak = __atomic_load_n(&scene->peak, __ATOMIC_RELAXED);
    (void)post;
    while (now > peak && !__atomic_compare_exchange_n(&scene->peak, &peak, now, 1, __ATOMIC_RELAXED, __ATOMIC_RELAXED))
        continue;
    return true;
}

void rf_scene_memory(const rf_scene *scene, uint64_t *now, uint64_t *peak)
{
    *now = (uint64_t)scene->bytes;
    *peak = (uint64_t)scene->peak;
}

/* ---- surfaces ---- */

static rf_v3 corner(const rf_object *object, uint32_t triangle, int k)
{
    return rf_load(object->vertices + 3 * (size_t)object->mesh->indices[3 * (size_t)triangle + (size_t)k]);
}

static rf_v3 shading_normal(const rf_object *object, uint32_t triangle, double u, double v)
{
    const uint32_t *index = object->mesh->indices + 3 * (size_t)triangle;
    rf_v3 n = rf_scale(rf_load(object->mesh->normals + 3 * (size_t)index[0]), 1 - u - v);
    n = rf_mad(n, rf_load(object->mesh->normals + 3 * (size_t)index[1]), u);
    n = rf_mad(n, rf_load(object->mesh->normals + 3 * (size_t)index[2]), v);
    return rf_unit(rf_from_frame(object->normal_x, object->normal_y, object->normal_z, n));
}

static const ex_material *material_of(const rf_object *object, uint32_t triangle)
{
    return &object->scene->materials[ex_object_material(object->scene, object->source, triangle)];
}

/* Base colour at a point of a triangle; 0 in a hole of its alpha mask. */
static int surface_color(const rf_object *object, uint32_t triangle, double u, double v, rf_v3 *base)
{
    float weights[3], color[3];
    int solid;
    weights[0] = (float)(1 - u - v);
    weights[1] = (float)u;
    weights[2] = (float)v;
    solid = ex_surface_color(object->scene, object->source, triangle, weights, color);
    *base = rf_load(color);
    return solid;
}

/* Lets rays through the holes of alpha masks. Only single rays are traced here: N is 1. */
static void filter_holes(const struct RTCFilterFunctionNArguments *args)
{
    const rf_object *object = args->geometryUserPtr;
    const struct RTCHit *hit = (const struct RTCHit *)(const void *)args->hit;
    rf_v3 unused;
    if (args->N == 1 && material_of(object, hit->primID)->alpha_cutoff > 0 &&
        !surface_color(object, hit->primID, (double)hit->u, (double)hit->v, &unused))
        args->valid[0] = 0;
}

/* ---- building ---- */

/* Cofactors of the upper 3 x 3: the inverse transpose times the determinant, whose sign is taken out again. */
static void set_normal_matrix(rf_object *object, const float *m)
{
    rf_v3 x = rf_load(m), y = rf_load(m + 4), z = rf_load(m + 8);
    double sign;
    object->mirrored = rf_dot(x, rf_cross(y, z)) < 0;
    sign = object->mirrored ? -1 : 1;
    object->normal_x = rf_scale(rf_cross(y, z), sign);
    object->normal_y = rf_scale(rf_cross(z, x), sign);
    object->normal_z = rf_scale(rf_cross(x, y), sign);
}

static int has_holes(const rf_object *object)
{
    for (uint32_t i = 0; i < object->mesh->triangle_count; i++)
        if (material_of(object, i)->alpha_cutoff > 0)
            return 1;
    return 0;
}

static int add_object(rf_scene *scene, const ex_scene *source, uint32_t index)
{
    rf_object *object = &scene->objects[index];
    const float *m = source->objects[index].transform;
    const ex_mesh *mesh = &source->meshes[source->objects[index].mesh];
    RTCGeometry geometry = rtcNewGeometry(scene->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *vertices;
    uint32_t *indices;
    object->scene = source;
    object->source = &source->objects[index];
    object->mesh = mesh;
    set_normal_matrix(object, m);
    vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                       mesh->vertex_count);
    indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t),
                                      mesh->triangle_count);
    if (vertices && indices) {
        for (size_t i = 0; i < mesh->vertex_count; i++) {
            const float *p = mesh->positions + 3 * i;
            for (size_t k = 0; k < 3; k++)
                vertices[3 * i + k] = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
        }
        memcpy(indices, mesh->indices, 3 * sizeof(uint32_t) * mesh->triangle_count);
        object->vertices = vertices;
        rtcSetGeometryUserData(geometry, object);
        if (has_holes(object)) {
            rtcSetGeometryIntersectFilterFunction(geometry, filter_holes);
            rtcSetGeometryOccludedFilterFunction(geometry, filter_holes);
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene->scene, geometry, index);
    }
    rtcReleaseGeometry(geometry);
    return vertices && indices ? 0 : -1;
}

rf_scene *rf_scene_create(const ex_scene *source, int threads, char *error)
{
    rf_scene *scene = calloc(1, sizeof *scene);
    char config[40];
    int failed = 1;
    snprintf(config, sizeof config, "threads=%d", threads);
    if (scene && (scene->device = rtcNewDevice(config)) != NULL) {
        rtcSetDeviceMemoryMonitorFunction(scene->device, count_bytes, scene);
        scene->objects = calloc(source->object_count + (size_t)1, sizeof *scene->objects);
        scene->scene = rtcNewScene(scene->device);
        failed = !scene->objects || !scene->scene;
        if (!failed)
            rtcSetSceneFlags(scene->scene, RTC_SCENE_FLAG_ROBUST);
        for (uint32_t i = 0; !failed && i < source->object_count; i++)
            if (source->meshes[source->objects[i].mesh].triangle_count)
                failed = add_object(scene, source, i) != 0;
        if (!failed)
            rtcCommitScene(scene->scene);
        failed |= rtcGetDeviceError(scene->device) != RTC_ERROR_NONE;
    }
    if (failed) {
        snprintf(error, EX_ERROR_SIZE, "Embree cannot build the scene (out of memory)");
        rf_scene_free(scene);
        return NULL;
    }
    return scene;
}

void rf_scene_free(rf_scene *scene)
{
    if (!scene)
        return;
    if (scene->scene)
        rtcReleaseScene(scene->scene);
    if (scene->device)
        rtcReleaseDevice(scene->device);
    free(scene->objects);
    free(scene);
}

/* ---- rays ---- */

static void set_ray(struct RTCRay *ray, rf_v3 origin, rf_v3 direction, double near_distance, double far_distance)
{
    memset(ray, 0, sizeof *ray);
    ray->org_x = (float)origin.x;
    ray->org_y = (float)origin.y;
    ray->org_z = (float)origin.z;
    ray->dir_x = (float)direction.x;
    ray->dir_y = (float)direction.y;
    ray->dir_z = (float)direction.z;
    ray->tnear = (float)near_distance;
    ray->tfar = (float)far_distance;       /* HUGE_VAL becomes infinity */
    ray->mask = ~0u;
}

static void fill_hit(const rf_object *object, uint32_t triangle, double u, double v, rf_v3 direction, rf_hit *hit)
{
    const ex_material *material = material_of(object, triangle);
    rf_v3 a = corner(object, triangle, 0), ab = rf_sub(corner(object, triangle, 1), a);
    rf_v3 ac = rf_sub(corner(object, triangle, 2), a);
    int front;
    hit->position = rf_mad(rf_mad(a, ab, u), ac, v);
    hit->geometric = rf_unit(rf_scale(rf_cross(ab, ac), object->mirrored ? -1 : 1));
    front = rf_dot(hit->geometric, direction) < 0;
    if (!front)
        hit->geometric = rf_scale(hit->geometric, -1);
    hit->normal = shading_normal(object, triangle, u, v);
    if (rf_dot(hit->normal, hit->geometric) < 0)
        hit->normal = rf_scale(hit->normal, -1);
    surface_color(object, triangle, u, v, &hit->base);
    hit->emission = front || material->double_sided ? rf_load(material->emission) : rf_make(0, 0, 0);
    hit->metallic = (double)material->metallic;
    hit->roughness = (double)material->roughness;
}

int rf_scene_trace(const rf_scene *scene, rf_v3 origin, rf_v3 direction, double near_distance, rf_hit *hit)
{
    struct RTCRayHit query;
    set_ray(&query.ray, origin, direction, near_distance, HUGE_VAL);
    query.hit.geomID = query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if DAPPLE_EMBREE == 4
    rtcIntersect1(scene->scene, &query, NULL);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene->scene, &context, &query);
#endif
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID)
        return 0;
    hit->distance = (double)query.ray.tfar;
    fill_hit(&scene->objects[query.hit.geomID], query.hit.primID, (double)query.hit.u, (double)query.hit.v, direction,
             hit);
    return 1;
}

int rf_scene_blocked(const rf_scene *scene, rf_v3 origin, rf_v3 direction, double length)
{
    struct RTCRay ray;
    set_ray(&ray, origin, direction, 0, length);
#if DAPPLE_EMBREE == 4
    rtcOccluded1(scene->scene, &ray, NULL);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene->scene, &context, &ray);
#endif
    return ray.tfar < 0;
}

#endif
