/* ism_lamps.c - from lights to lamps, and from lamps to reflective shadow maps: G-buffers rendered from them. */
#include "ism_parts.h"
#include "ground.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979

int im_out_of_memory(char *error)
{
    snprintf(error, EX_ERROR_SIZE, "ism: out of memory");
    return -1;
}

int im_failed(const char *what, ism_result result, char *error)
{
    snprintf(error, EX_ERROR_SIZE, "ism: %s: %s", what, ism_result_text(result));
    return -1;
}

static float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void unit(float *a)
{
    float length = sqrtf(dot(a, a));
    for (int k = 0; k < 3; k++)
        a[k] = length > 0 ? a[k] / length : (float)(k == 1);
}

static void cross(float *out, const float *a, const float *b)
{
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* ---- points on area lights ---- */

typedef struct area_points { float *positions, *normals, *fluxes; size_t count; } area_points;

static int grow_points(area_points *p, size_t more)
{
    size_t bytes = 3 * (p->count + more) * sizeof(float);
    float **arrays[3] = { &p->positions, &p->normals, &p->fluxes };
    for (int i = 0; i < 3; i++) {
        float *grown = realloc(*arrays[i], bytes);
        if (!grown)
            return -1;
        *arrays[i] = grown;
    }
    return 0;
}

static void free_points(area_points *p)
{
    free(p->positions);
    free(p->normals);
    free(p->fluxes);
    memset(p, 0, sizeof *p);
}

/* One point of a light at (u, v) of the unit square, and its area. */
static double place(const ex_light *light, double u, double v, float position[3], float normal[3])
{
    double phi = 2 * PI * u, radius = (double)light->radius, length;
    float a[3], b[3];
    switch (light->kind) {
    case EX_LIGHT_RECT:
        cross(normal, light->u, light->v);
        length = sqrt((double)dot(normal, normal));
        for (int k = 0; k < 3; k++)
            position[k] = light->position[k] + (float)u * light->u[k] + (float)v * light->v[k];
        unit(normal);
        return length;
    case EX_LIGHT_SPHERE: {
        double y = 1 - 2 * v, s = sqrt(1 - y * y);
        normal[0] = (float)(s * cos(phi));
        normal[1] = (float)y;
        normal[2] = (float)(s * sin(phi));
        for (int k = 0; k < 3; k++)
            position[k] = light->position[k] + normal[k] * light->radius;
        return 4 * PI * radius * radius;
    }
    default:
        memcpy(a, light->kind == EX_LIGHT_DISC ? light->direction : light->u, sizeof a);
        unit(a);
        b[0] = fabsf(a[1]) < 0.9f ? 0.0f : 1.0f;
        b[1] = 1 - b[0];
        b[2] = 0;
        cross(normal, a, b);
        unit(normal);
        cross(b, a, normal);
        for (int k = 0; k < 3; k++)
            normal[k] = (float)(cos(phi) * (double)normal[k] + sin(phi) * (double)b[k]);
        if (light->kind == EX_LIGHT_LINE) {
            for (int k = 0; k < 3; k++)
                position[k] = light->position[k] + (float)v * light->u[k] + normal[k] * light->radius;
            return 2 * PI * radius * sqrt((double)dot(light->u, light->u));
        }
        for (int k = 0; k < 3; k++)
            position[k] = light->position[k] + normal[k] * light->radius * (float)sqrt(v);
        memcpy(normal, a, sizeof a);
        return PI * radius * radius;
    }
}

static int is_area(const ex_light *light)
{
    return light->kind == EX_LIGHT_SPHERE || light->kind == EX_LIGHT_RECT || light->kind == EX_LIGHT_DISC ||
           light->kind == EX_LIGHT_LINE;
}

static int add_area_light(area_points *p, const ex_light *light, uint32_t count)
{
    if (grow_points(p, count) != 0)
        return -1;
    for (uint32_t i = 0; i < count; i++) {
        double u = (i + 0.5) / count, v = i * 0.6180339887498949 + 0.5;
        float *flux = p->fluxes + 3 * p->count;
        double area = place(light, v - floor(v), u, p->positions + 3 * p->count, p->normals + 3 * p->count);
        for (int k = 0; k < 3; k++)
            flux[k] = (float)(PI * (double)light->value[k] * area / count);
        p->count++;
    }
    return 0;
}

/* Points on all emissive triangles together; a double-sided triangle is two. */
static int add_emitters(area_points *p, const rd_job *job, uint32_t count, char *error)
{
    size_t triangles = 0;
    float *corners = malloc((18 * job->emitter_count + 1) * sizeof *corners);
    float *radiances = malloc((6 * job->emitter_count + 1) * sizeof *radiances);
    ism_mesh mesh = { NULL, 0, 0, NULL, 0, NULL, NULL, NULL, NULL, NULL };
    ism_result result = ISM_ERR_ALLOC;
    if (corners && radiances && grow_points(p, count) == 0) {
        for (size_t i = 0; i < job->emitter_count; i++) {
            const rd_emitter *e = &job->emitters[i];
            const ex_material *material = &job->scene->materials[e->material];
            for (int side = 0; side < (material->double_sided ? 2 : 1); side++, triangles++)
                for (int k = 0; k < 3; k++) {
                    memcpy(corners + 9 * triangles + 3 * k, e->v[side ? 2 - k : k], 3 * sizeof(float));
                    radiances[3 * triangles + (size_t)k] = material->emission[k];
                }
        }
        mesh.positions = corners;
        mesh.vertex_count = 3 * triangles;
        result = ism_emitter_points(&mesh, radiances, count, job->seed, NULL, p->positions + 3 * p->count,
                                    p->normals + 3 * p->count, p->fluxes + 3 * p->count);
        if (result == ISM_OK)
            p->count += count;
    }
    free(corners);
    free(radiances);
    return result == ISM_OK ? 0 : im_failed("emissive meshes", result, error);
}

static int area_points_build(area_points *p, const rd_job *job, uint32_t count, char *error)
{
    memset(p, 0, sizeof *p);
    for (uint32_t i = 0; i < job->scene->light_count; i++)
        if (is_area(&job->scene->lights[i]) && add_area_light(p, &job->scene->lights[i], count) != 0)
            return im_out_of_memory(error);
    return job->emitter_count ? add_emitters(p, job, count, error) : 0;
}

/* ---- lamps ---- */

static im_lamp *add_lamp(im_rsms *r)
{
    im_lamp *grown = realloc(r->lamps, (r->lamp_count + 1) * sizeof *grown);
    if (!grown)
        return NULL;
    r->lamps = grown;
    memset(&grown[r->lamp_count], 0, sizeof *grown);
    grown[r->lamp_count].light = UINT32_MAX;
    grown[r->lamp_count].cos_cone = -1;
    return &grown[r->lamp_count++];
}

static int sky_arrays(const ex_sky *sky, float **directions, float **fluxes)
{
    size_t floats = 3 * (size_t)sky->width * sky->height;
    *directions = malloc(floats * sizeof(float));
    *fluxes = malloc(floats * sizeof(float));
    return *directions && *fluxes &&
           ism_sky_directions(sky->rgb, sky->width, sky->height, sky->rotation, *directions, *fluxes, NULL) == ISM_OK
         ? 0 : -1;
}

/* The header's own choice of directions by flux: as many suns. */
static int add_sky(im_rsms *r, const rd_job *job, uint32_t count, char *error)
{
    const float at[3] = { 0, 0, 0 }, up[3] = { 0, 1, 0 };
    float *directions = NULL, *fluxes = NULL;
    ism_points view = { 1, at, 0, up, 0, NULL, 0, NULL, 0, 0, { 0 }, ISM_ROWS_BOTTOM_FIRST };
    ism_source source = { ISM_SOURCE_DIRECTIONS, job->scene->sky.width, job->scene->sky.height, 0, NULL, 0, NULL, 0,
                          NULL, 0, NULL, 0, NULL, 0 };
    ism_frame frame = { NULL, &source, 1, &view, 0 };
    ism_desc desc = { 0 };
    ism_maps *maps = NULL;
    ism_result result = ISM_ERR_ALLOC;
    desc.vpl_count = count;
    desc.importance = ISM_IMPORTANCE_FLUX;
    desc.seed = job->seed;
    if (sky_arrays(&job->scene->sky, &directions, &fluxes) == 0) {
        source.positions = directions;
        source.fluxes = fluxes;
        result = ism_create(&desc, &maps);
        result = result == ISM_OK ? ism_choose(maps, &frame) : result;
    }
    if (result == ISM_OK) {
        size_t n;
        const ism_vpl *vpls = ism_vpls(maps, &n);
        for (size_t i = 0; i < n; i++) {
            im_lamp *lamp = add_lamp(r);
            if (!lamp) {
                result = ISM_ERR_ALLOC;
                break;
            }
            lamp->kind = IM_FAR;
            memcpy(lamp->position, vpls[i].position, sizeof lamp->position);
            memcpy(lamp->value, vpls[i].flux, sizeof lamp->value);
        }
    }
    ism_free(maps);
    free(directions);
    free(fluxes);
    return result == ISM_OK ? 0 : im_failed("sky", result, error);
}

int im_lamps_build(im_rsms *r, const rd_job *job, uint32_t samples, int areas, char *error)
{
    area_points points;
    memset(r, 0, sizeof *r);
    memset(&points, 0, sizeof points);
    for (uint32_t i = 0; i < job->scene->light_count; i++) {
        const ex_light *light = &job->scene->lights[i];
        im_lamp *lamp;
        if (is_area(light))
            continue;
        lamp = add_lamp(r);
        if (!lamp)
            return im_out_of_memory(error);
        lamp->kind = light->kind == EX_LIGHT_SUN ? IM_FAR : IM_EVEN;
        memcpy(lamp->position, light->kind == EX_LIGHT_SUN ? light->direction : light->position, sizeof lamp->position);
        memcpy(lamp->normal, light->direction, sizeof lamp->normal);
        memcpy(lamp->value, light->value, sizeof lamp->value);
        if (light->kind == EX_LIGHT_SPOT)
            lamp->cos_cone = light->cos_half_angle;
        lamp->light = i;
    }
    if (areas && area_points_build(&points, job, samples, error) != 0) {
        free_points(&points);
        return -1;
    }
    for (size_t i = 0; i < points.count; i++) {
        im_lamp *lamp = add_lamp(r);
        if (!lamp) {
            free_points(&points);
            return im_out_of_memory(error);
        }
        lamp->kind = IM_COSINE;
        memcpy(lamp->position, points.positions + 3 * i, sizeof lamp->position);
        memcpy(lamp->normal, points.normals + 3 * i, sizeof lamp->normal);
        for (int k = 0; k < 3; k++) {
            lamp->value[k] = points.fluxes[3 * i + (size_t)k] / (float)PI;
            lamp->position[k] += 1e-4f * job->radius * lamp->normal[k];
        }
    }
    free_points(&points);
    return job->scene->sky.width ? add_sky(r, job, samples, error) : 0;
}

/* ---- pictures from lamps ---- */

/* Solid angle of the part of the plane z = 1 from the axis to (x, y). */
static double corner_angle(double x, double y) { return atan2(x * y, sqrt(x * x + y * y + 1)); }

/* Pixel of a square picture with half = tan(fovy / 2): solid angle. */
static double pixel_angle(uint32_t x, uint32_t y, uint32_t size, double half)
{
    double step = 2 * half / size, x0 = x * step - half, y0 = y * step - half;
    return corner_angle(x0 + step, y0 + step) - corner_angle(x0, y0 + step) - corner_angle(x0 + step, y0) +
           corner_angle(x0, y0);
}

/* A sun is a lamp a thousand radii away: its rays differ from parallel ones by 0.06 degrees at most. */
#define FAR_AWAY 1000.0f
/* Texels a side of the smallest picture of one of many points on lamps. */
#define LEAST_SIDE 16u

static int render_from(ex_gbuffer *out, const rd_job *job, const ex_clusters *clusters, const float *eye,
                       const float *forward, const float *up, float fovy, uint32_t size, char *error)
{
    ex_scene scene = *job->scene;
    for (int k = 0; k < 3; k++) {
        scene.camera.eye[k] = eye[k];
        /* As far off as a sun: rounding of a far eye's coordinates would turn a shorter step by metres at the scene. */
        scene.camera.target[k] = eye[k] + forward[k] * FAR_AWAY * job->radius;
        scene.camera.up[k] = up[k];
    }
    scene.camera.fovy = fovy;
    return clusters ? ex_gbuffer_render_clusters(out, &scene, clusters, size, size, job->threads, error)
                    : ex_gbuffer_render(out, &scene, size, size, 1, job->threads, error);
}

/* Right and up of such a picture; up along the view: any will do, but the same. */
static void picture_axes(const float *forward, const float *up, float right[3], float upward[3])
{
    const float other[3] = { 0, fabsf(forward[1]) < 0.9f ? 1.0f : 0.0f, fabsf(forward[1]) < 0.9f ? 0.0f : -1.0f };
    cross(right, forward, up);
    if (!(sqrtf(dot(right, right)) > 1e-6f))
        cross(right, forward, other);
    unit(right);
    cross(upward, right, forward);
}

static void far_eye(const im_lamp *lamp, const rd_job *job, float eye[3], float forward[3], float *fovy)
{
    for (int k = 0; k < 3; k++) {
        eye[k] = job->center[k] + lamp->position[k] * FAR_AWAY * job->radius;
        forward[k] = -lamp->position[k];
    }
    *fovy = 2 * asinf(1.01f / FAR_AWAY);
}

/* What one pixel of a lamp's picture reflects: flux = albedo x power that enters the pixel. The cosine of shading
   normals in place of the geometric one, as in every technique; but light leaves the surface that is there: by a
   shading normal a VPL would look through its own bent surface. */
static void texel(const im_lamp *lamp, const float *eye, const ex_pixel *pixel, double angle, float *position,
                  float *normal, float *flux, float *area)
{
    double d[3], distance2 = 0, power, facing = 0, cosine = 0, emission = 1, ratio;
    memset(flux, 0, 3 * sizeof *flux);
    memcpy(position, pixel->position, 3 * sizeof *position);
    memcpy(normal, pixel->geometric, 3 * sizeof *normal);
    *area = 0;
    if (pixel->object == UINT32_MAX) {
        normal[1] = 1;
        return;
    }
    for (int k = 0; k < 3; k++) {
        d[k] = (double)pixel->position[k] - (double)eye[k];
        distance2 += d[k] * d[k];
    }
    for (int k = 0; k < 3; k++) {
        d[k] /= sqrt(distance2);
        facing -= d[k] * (double)pixel->geometric[k];
        cosine -= d[k] * (double)pixel->normal[k];
    }
    if (lamp->kind == IM_COSINE)
        emission = d[0] * (double)lamp->normal[0] + d[1] * (double)lamp->normal[1] + d[2] * (double)lamp->normal[2];
    if (lamp->kind == IM_EVEN &&
        d[0] * (double)lamp->normal[0] + d[1] * (double)lamp->normal[1] + d[2] * (double)lamp->normal[2] <
            (double)lamp->cos_cone)
        emission = 0;
    facing = facing > 0.02 ? facing : 0.02;
    ratio = cosine > 0 ? cosine / facing : 0;
    power = (emission > 0 ? emission : 0) * angle * (ratio < 4 ? ratio : 4);
    if (lamp->kind == IM_FAR)
        power *= distance2;
    *area = (float)(angle * distance2 / facing);
    for (int k = 0; k < 3; k++)
        flux[k] = (float)((double)lamp->value[k] * power * (double)pixel->albedo[k]);
}

static int grow_sources(im_rsms *r)
{
    ism_source *sources = realloc(r->sources, (r->count + 1) * sizeof *sources);
    float **arrays = sources ? realloc(r->arrays, (r->count + 1) * sizeof *arrays) : NULL;
    if (sources)
        r->sources = sources;
    if (arrays)
        r->arrays = arrays;
    return arrays ? 0 : -1;
}

/* A grid of size x size: block is its positions, normals, fluxes and areas, and freed with the rest. */
static void add_source(im_rsms *r, float *block, uint32_t size)
{
    size_t pixels = (size_t)size * size;
    ism_source *source = &r->sources[r->count];
    memset(source, 0, sizeof *source);
    source->width = source->height = size;
    source->positions = block;
    source->normals = block + 3 * pixels;
    source->fluxes = block + 6 * pixels;
    source->areas = block + 9 * pixels;
    r->arrays[r->count++] = block;
}

static int add_picture(im_rsms *r, const rd_job *job, const ex_clusters *clusters, const im_lamp *lamp,
                       const float *eye, const float *forward, const float *up, float fovy, uint32_t size, char *error)
{
    size_t pixels = (size_t)size * size;
    double half = tan(0.5 * (double)fovy);
    ex_gbuffer g;
    float *block = grow_sources(r) == 0 ? malloc(10 * pixels * sizeof *block) : NULL;
    if (!block)
        return im_out_of_memory(error);
    if (render_from(&g, job, clusters, eye, forward, up, fovy, size, error) != 0) {
        free(block);
        return -1;
    }
    for (size_t i = 0; i < pixels; i++)
        texel(lamp, eye, &g.pixels[i], pixel_angle((uint32_t)(i % size), (uint32_t)(i / size), size, half),
              block + 3 * i, block + 3 * (pixels + i), block + 3 * (2 * pixels + i), block + 9 * pixels + i);
    ex_gbuffer_free(&g);
    add_source(r, block, size);
    return 0;
}

/* The faces of a cube whose first one looks along the lamp's normal; one that emits nothing is left out. */
static int add_cube(im_rsms *r, const rd_job *job, const ex_clusters *clusters, const im_lamp *lamp, uint32_t size,
                    char *error)
{
    float axes[3][3] = { { 0, 0, 1 }, { 0, 0, 0 }, { 0, 0, 0 } }, other[3] = { 0, 1, 0 };
    if (lamp->kind == IM_COSINE || lamp->cos_cone > -1)
        memcpy(axes[0], lamp->normal, sizeof axes[0]);
    if (fabsf(axes[0][1]) > 0.9f) {
        other[0] = 1;
        other[1] = 0;
    }
    cross(axes[1], other, axes[0]);
    unit(axes[1]);
    cross(axes[2], axes[0], axes[1]);
    for (int face = 0; face < 6; face++) {
        float forward[3];
        for (int k = 0; k < 3; k++)
            forward[k] = face & 1 ? -axes[face / 2][k] : axes[face / 2][k];
        if (lamp->kind == IM_COSINE && face == 1)
            continue;
        if (add_picture(r, job, clusters, lamp, lamp->position, forward, axes[(face / 2 + 1) % 3], (float)(0.5 * PI),
                        size, error) != 0)
            return -1;
    }
    return 0;
}

/* What a far lamp's picture shows: a pyramid. */
static void cover_of(const im_lamp *lamp, const rd_job *job, rd_cover *cover)
{
    const float up[3] = { 0, 1, 0 };
    float eye[3], forward[3], axes[2][3], fovy;
    double half;
    memset(cover, 0, sizeof *cover);
    far_eye(lamp, job, eye, forward, &fovy);
    half = tan(0.5 * (double)fovy);
    picture_axes(forward, up, axes[0], axes[1]);
    for (int i = 0; i < 4; i++) {
        double *plane = cover->planes[cover->plane_count++], sign = i & 1 ? -1 : 1;
        for (int k = 0; k < 3; k++) {
            plane[k] = half * (double)forward[k] + sign * (double)axes[i / 2][k];
            plane[3] -= plane[k] * (double)eye[k];
        }
    }
    for (int k = 0; k < 3; k++)
        cover->irradiance[k] = lamp->value[k] * fmaxf(lamp->position[1], 0);
}

/* The ground beyond the pictures of suns and sky. */
static int add_ground(im_rsms *r, const rd_job *job, char *error)
{
    rd_cover *covers = malloc((r->lamp_count + 1) * sizeof *covers);
    rd_ring *rings = NULL;
    size_t lamps = 0, count = 0, taken = 0;
    int result = -1;
    for (size_t i = 0; i < r->lamp_count && covers; i++)
        if (r->lamps[i].kind == IM_FAR)
            cover_of(&r->lamps[i], job, &covers[lamps++]);
    if (covers)
        result = rd_rings_build(&rings, &count, job, covers, lamps);
    for (; taken < count && result == 0; taken++) {
        float side = 2 * rings[taken].half / RD_RING_SIDE, *fluxes = rings[taken].radiosity;
        result = grow_sources(r);
        if (result != 0)
            break;
        for (size_t i = 0; i < 3 * (size_t)RD_RING_SIDE * RD_RING_SIDE; i++)
            fluxes[i] *= side * side;
        add_source(r, rings[taken].positions, RD_RING_SIDE);
        r->rings++;
        rings[taken].positions = NULL;
    }
    rd_rings_free(rings, count);
    free(covers);
    return result == 0 ? 0 : im_out_of_memory(error);
}

static int render_lamp(im_rsms *r, const rd_job *job, const ex_clusters *clusters, const im_lamp *lamp, uint32_t size,
                       char *error)
{
    const float up[3] = { 0, 1, 0 };
    if (lamp->kind == IM_FAR) {
        float eye[3], forward[3], fovy;
        far_eye(lamp, job, eye, forward, &fovy);
        return add_picture(r, job, clusters, lamp, eye, forward, up, fovy, size, error);
    }
    if (lamp->kind == IM_EVEN && lamp->cos_cone > 0.5f)         /* a narrow spot: one picture */
        return add_picture(r, job, clusters, lamp, lamp->position, lamp->normal, up, 2 * acosf(lamp->cos_cone), size,
                           error);
    return add_cube(r, job, clusters, lamp, (size + 1) / 2, error);
}

/* ---- pictures that are kept ---- */

static uint64_t add_bytes(uint64_t key, const void *bytes, size_t count)
{
    const unsigned char *from = bytes;
    uint64_t word;
    for (; count >= sizeof word; count -= sizeof word, from += sizeof word) {
        memcpy(&word, from, sizeof word);
        key = (key ^ word) * 0x9e3779b97f4a7c15u;
        key ^= key >> 32;
    }
    for (word = count; count > 0; count--)
        word = word << 8 | *from++;
    key = (key ^ word) * 0x9e3779b97f4a7c15u;
    return key ^ key >> 29;
}

/* What a frame may change of what a lamp sees. Two scenes have the same key once in 2^64. */
static uint64_t scene_key(const rd_job *job, uint32_t size)
{
    const ex_scene *scene = job->scene;
    uint64_t key = add_bytes(size, job->center, sizeof job->center);
    key = add_bytes(key, &job->radius, sizeof job->radius);
    for (uint32_t i = 0; i < scene->mesh_count; i++) {
        const ex_mesh *mesh = &scene->meshes[i];
        key = add_bytes(key, mesh->positions, 3 * sizeof(float) * (size_t)mesh->vertex_count);
        key = add_bytes(key, mesh->normals, 3 * sizeof(float) * (size_t)mesh->vertex_count);
        key = add_bytes(key, mesh->materials, sizeof *mesh->materials * (size_t)mesh->triangle_count);
    }
    for (uint32_t i = 0; i < scene->object_count; i++) {
        key = add_bytes(key, scene->objects[i].transform, sizeof scene->objects[i].transform);
        key = add_bytes(key, &scene->objects[i].material, sizeof scene->objects[i].material);
    }
    for (uint32_t i = 0; i < scene->material_count; i++)
        key = add_bytes(key, scene->materials[i].base_color, sizeof scene->materials[i].base_color);
    return key;
}

/* Takes sources of the frame before. */
static int take_sources(im_rsms *r, im_rsms *last, size_t first, size_t end)
{
    for (size_t i = first; i < end; i++) {
        if (grow_sources(r) != 0)
            return -1;
        r->sources[r->count] = last->sources[i];
        r->arrays[r->count++] = last->arrays[i];
        last->arrays[i] = NULL;
        r->kept++;
    }
    return 0;
}

/* Lights without size have pictures of their own, points on lamps and of the sky share the texels of one. */
static int render_lamps(im_rsms *r, im_rsms *last, const rd_job *job, uint32_t size, int *all_kept, char *error)
{
    ex_clusters *clusters = NULL;
    size_t samples = 0;
    uint32_t part = size;
    int result = 0;
    *all_kept = last && last->lamp_count == r->lamp_count;
    for (size_t i = 0; i < r->lamp_count; i++)
        samples += r->lamps[i].light == UINT32_MAX;
    if (samples > 1)
        part = (uint32_t)((double)size / sqrt((double)samples) + 0.5);
    if (part < LEAST_SIDE)
        part = LEAST_SIDE < size ? LEAST_SIDE : size;
    for (size_t i = 0; i < r->lamp_count && result == 0; i++) {
        const im_lamp lamp = r->lamps[i];
        const int keep = last && i < last->lamp_count && memcmp(&lamp, &last->lamps[i], sizeof lamp) == 0;
        r->first[i] = r->count;
        *all_kept = *all_kept && keep;
        if (!keep && !clusters)
            clusters = ex_clusters_build(job->scene);
        if (keep)
            result = take_sources(r, last, last->first[i], last->first[i + 1]) == 0 ? 0 : im_out_of_memory(error);
        else if (clusters)
            result = render_lamp(r, job, clusters, &lamp, lamp.light == UINT32_MAX ? part : size, error);
        else
            result = im_out_of_memory(error);
    }
    ex_clusters_free(clusters);
    r->first[r->lamp_count] = r->count;
    return result;
}

int im_rsms_render(im_rsms *r, im_rsms *last, const rd_job *job, uint32_t size, char *error)
{
    int all_kept;
    r->key = last ? scene_key(job, size) : 0;      /* nobody asks for it otherwise, and it reads all vertices */
    r->first = malloc((r->lamp_count + 1) * sizeof *r->first);
    if (!r->first)
        return im_out_of_memory(error);
    if (last && (!last->first || last->key != r->key))
        last = NULL;
    if (render_lamps(r, last, job, size, &all_kept, error) != 0)
        return -1;
    if (!all_kept)
        return add_ground(r, job, error);
    r->rings = last->rings;
    return take_sources(r, last, last->count - last->rings, last->count) == 0 ? 0 : im_out_of_memory(error);
}

void im_rsms_free(im_rsms *r)
{
    for (size_t i = 0; i < r->count; i++)
        free(r->arrays[i]);
    free(r->arrays);
    free(r->sources);
    free(r->lamps);
    free(r->first);
    memset(r, 0, sizeof *r);
}

/* ---- direct light ---- */

/* Depth along the axis of one picture, from a point on it that lies `away` from the eye: a sun's depths from its eye
   would be rounded to more than half a texel. */
typedef struct shadow_map {
    float   *depth;
    float    from[3], right[3], up[3], forward[3], away, half;
    uint32_t size;
} shadow_map;

static int shadow_map_build(shadow_map *s, const rd_job *job, const float *eye, const float *from, float away,
                            const float *forward, const float *up, float fovy, uint32_t size, char *error)
{
    ex_gbuffer g;
    if (render_from(&g, job, NULL, eye, forward, up, fovy, size, error) != 0)
        return -1;
    s->size = size;
    s->half = tanf(0.5f * fovy);
    memcpy(s->from, from, sizeof s->from);
    memcpy(s->forward, forward, sizeof s->forward);
    s->away = away;
    picture_axes(forward, up, s->right, s->up);
    s->depth = malloc((size_t)size * size * sizeof *s->depth);
    for (size_t i = 0; s->depth && i < (size_t)size * size; i++) {
        const float *p = g.pixels[i].position;
        float d[3] = { p[0] - from[0], p[1] - from[1], p[2] - from[2] };
        s->depth[i] = g.pixels[i].object == UINT32_MAX ? HUGE_VALF : dot(d, forward);
    }
    ex_gbuffer_free(&g);
    return s->depth ? 0 : im_out_of_memory(error);
}

/* How much nearer than the point, z from the eye on the ray forward + x right + y up, a texel's ray meets the point's
   plane; no more than twelve texels' width: where ray and plane are all but parallel, the surface ends before. */
static float plane_step(const shadow_map *s, const float *n, float z, float x, float y, int i, int j)
{
    float u = (2 * ((float)i + 0.5f) / (float)s->size - 1) * s->half, along = dot(n, s->right);
    float v = (1 - 2 * ((float)j + 0.5f) / (float)s->size) * s->half, upward = dot(n, s->up);
    float step = z * ((u - x) * along + (v - y) * upward) / (dot(n, s->forward) + u * along + v * upward);
    float most = 24 * s->half / (float)s->size * z;
    return step > most ? most : step > -most ? step : step < 0 ? -most : 0;
}

/* Share of 3 x 3 texels that see the point; its own plane carries the depth to the texels. -1: not in this picture. */
static float shadow_map_lit(const shadow_map *s, const float *p, const float *n)
{
    float d[3] = { p[0] - s->from[0], p[1] - s->from[1], p[2] - s->from[2] }, depth = dot(d, s->forward), lit = 0;
    float x, y, u, v, z = s->away + depth, bias = z * s->half / (float)s->size;          /* half a texel */
    int cx, cy, count = 0;
    if (!(z > 0))
        return -1;
    u = dot(d, s->right) / z;
    v = dot(d, s->up) / z;
    x = (u / s->half * 0.5f + 0.5f) * (float)s->size;
    y = (0.5f - v / s->half * 0.5f) * (float)s->size;
    if (!(x >= 0 && y >= 0 && x < (float)s->size && y < (float)s->size))
        return -1;
    cx = (int)x;
    cy = (int)y;
    for (int j = cy - 1; j <= cy + 1; j++)
        for (int i = cx - 1; i <= cx + 1; i++) {
            if (i < 0 || j < 0 || i >= (int)s->size || j >= (int)s->size)
                continue;
            lit += depth - plane_step(s, n, z, u, v, i, j) - bias <= s->depth[(size_t)j * s->size + (size_t)i];
            count++;
        }
    return count ? lit / (float)count : 1;
}

static void add_direct(ex_image *out, const rd_job *job, const im_lamp *lamp, const shadow_map *map)
{
    for (size_t i = 0; i < (size_t)job->gbuffer->width * job->gbuffer->height; i++) {
        const ex_pixel *pixel = &job->gbuffer->pixels[i];
        float d[3], distance2 = 1, cosine, lit;
        if (pixel->object == UINT32_MAX)
            continue;
        for (int k = 0; k < 3; k++)
            d[k] = lamp->kind == IM_FAR ? lamp->position[k] : lamp->position[k] - pixel->position[k];
        if (lamp->kind != IM_FAR)
            distance2 = dot(d, d);
        unit(d);
        cosine = dot(d, pixel->normal);
        if (!(cosine > 0) || !(dot(d, pixel->geometric) > 0) || !(distance2 > 0))
            continue;
        if (lamp->kind == IM_EVEN && -dot(d, lamp->normal) < lamp->cos_cone)
            continue;
        lit = shadow_map_lit(map, pixel->position, pixel->geometric);
        if (lit < 0 && lamp->kind == IM_FAR)
            lit = 1;                            /* ground beyond the scene, where no shadow of it falls */
        for (int k = 0; k < 3 && lit > 0; k++)
            out->rgb[3 * i + (size_t)k] += lit * cosine * lamp->value[k] * pixel->albedo[k] / ((float)PI * distance2);
    }
}

int im_direct(ex_image *out, const im_rsms *r, const rd_job *job, uint32_t size, size_t *map_bytes, char *error)
{
    static const float axes[6][3] = { { 1, 0, 0 }, { -1, 0, 0 }, { 0, 1, 0 }, { 0, -1, 0 }, { 0, 0, 1 }, { 0, 0, -1 } };
    *map_bytes = 0;
    for (size_t i = 0; i < r->lamp_count; i++) {
        const im_lamp *lamp = &r->lamps[i];
        int narrow = lamp->cos_cone > 0.5f, faces = lamp->kind == IM_FAR || narrow ? 1 : 6;
        if (lamp->light == UINT32_MAX)
            continue;
        for (int face = 0; face < faces; face++) {
            float eye[3], forward[3], fovy = (float)(0.5 * PI);
            const float away = lamp->kind == IM_FAR ? FAR_AWAY * job->radius : 0;
            shadow_map map;
            memcpy(eye, lamp->position, sizeof eye);
            memcpy(forward, narrow ? lamp->normal : axes[face], sizeof forward);
            if (narrow)
                fovy = 2 * acosf(lamp->cos_cone);
            if (lamp->kind == IM_FAR)
                far_eye(lamp, job, eye, forward, &fovy);
            if (shadow_map_build(&map, job, eye, lamp->kind == IM_FAR ? job->center : eye, away, forward,
                                 axes[face / 2 == 1 ? 4 : 2], fovy, faces > 1 ? (size + 1) / 2 : size, error) != 0)
                return -1;
            add_direct(out, job, lamp, &map);
            if (*map_bytes < (size_t)map.size * map.size * sizeof *map.depth)
                *map_bytes = (size_t)map.size * map.size * sizeof *map.depth;
            free(map.depth);
        }
    }
    return 0;
}

/* ---- emission as sources ---- */

int im_emission_sources(im_rsms *r, const rd_job *job, uint32_t count, int with_sky, char *error)
{
    area_points points;
    const ex_sky *sky = &job->scene->sky;
    float corners[4][3];
    memset(r, 0, sizeof *r);
    r->sources = calloc(2, sizeof *r->sources);
    r->arrays = calloc(5, sizeof *r->arrays);
    if (!r->sources || !r->arrays)
        return im_out_of_memory(error);
    if (area_points_build(&points, job, count, error) != 0) {
        free_points(&points);
        return -1;
    }
    r->arrays[0] = points.positions;
    r->arrays[1] = points.normals;
    r->arrays[2] = points.fluxes;
    r->sources[0].width = (uint32_t)points.count;
    r->sources[0].height = 1;
    r->sources[0].positions = points.positions;
    r->sources[0].normals = points.normals;
    r->sources[0].fluxes = points.fluxes;
    r->sources[0].scattered = 1;
    r->count = points.count > 0;
    if (!sky->width || !with_sky)
        return 0;
    if (sky_arrays(sky, &r->arrays[3], &r->arrays[4]) != 0)
        return im_out_of_memory(error);
    memset(&r->sources[r->count], 0, sizeof *r->sources);
    r->sources[r->count].kind = ISM_SOURCE_DIRECTIONS;
    r->sources[r->count].width = sky->width;
    r->sources[r->count].height = sky->height;
    r->sources[r->count].positions = r->arrays[3];
    r->sources[r->count].fluxes = r->arrays[4];
    r->count++;
    if (!rd_ground_near(job, corners))
        return 0;
    for (size_t i = 0; i < (size_t)sky->width * sky->height; i++)      /* the ground hides what is below the horizon */
        if (r->arrays[3][3 * i + 1] < 0)
            memset(r->arrays[4] + 3 * i, 0, 3 * sizeof(float));
    return 0;
}

void im_emission_free(im_rsms *r)
{
    for (int i = 0; i < 5 && r->arrays; i++)     /* five arrays, not one a source */
        free(r->arrays[i]);
    free(r->arrays);
    free(r->sources);
    memset(r, 0, sizeof *r);
}
