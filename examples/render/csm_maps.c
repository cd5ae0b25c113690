/* csm_maps.c - shadow casters of the technique csm: which meshes get maps, and where they stand. */
#include "csm_parts.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NO_OBJECT UINT32_MAX
#define MOST_OBJECTS 256         /* objects=auto: scenes of more are cheaper to ask as one rigid object */

int cs_out_of_memory(char *error)
{
    snprintf(error, EX_ERROR_SIZE, "csm: out of memory");
    return -1;
}

int cs_failed(const char *what, cohsm_result result, char *error)
{
    snprintf(error, EX_ERROR_SIZE, "csm: %.120s: %s", what, cohsm_result_text(result));
    return -1;
}

int cs_refused(uint64_t samples, char *error)
{
    snprintf(error, EX_ERROR_SIZE,
             "csm: %llu light samples lie inside the hull of an object; light_maps=local treats them",
             (unsigned long long)samples);
    return -1;
}

/* ---- memory ---- */

enum { MEMORY_HEAD = 16 };       /* holds the size and keeps the alignment of malloc */

static void *counted_alloc(size_t size, void *user)
{
    cs_memory *memory = user;
    char *block = size <= SIZE_MAX - MEMORY_HEAD ? malloc(size + MEMORY_HEAD) : NULL;
    if (!block)
        return NULL;
    memcpy(block, &size, sizeof size);
    pthread_mutex_lock(&memory->lock);
    memory->now += size;
    if (memory->peak < memory->now)
        memory->peak = memory->now;
    pthread_mutex_unlock(&memory->lock);
    return block + MEMORY_HEAD;
}

static void counted_free(void *pointer, void *user)
{
    cs_memory *memory = user;
    char *block = (char *)pointer - MEMORY_HEAD;
    size_t size;
    memcpy(&size, block, sizeof size);
    pthread_mutex_lock(&memory->lock);
    memory->now -= size;
    pthread_mutex_unlock(&memory->lock);
    free(block);
}

void cs_memory_init(cs_memory *memory)
{
    memset(memory, 0, sizeof *memory);
    pthread_mutex_init(&memory->lock, NULL);
}

cohsm_allocator cs_memory_allocator(cs_memory *memory)
{
    cohsm_allocator allocator = { counted_alloc, counted_free, memory };
    return allocator;
}

/* ---- transforms and meshes ---- */

static const float identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };

/* Rotation, one scale and translation, as cohsm_visible_scene wants it; anything else gets maps of its own. */
static int is_similarity(const float *m, float *scale)
{
    float length[3], volume;
    for (int i = 0; i < 3; i++) {
        const float *c = m + 4 * i, *d = m + 4 * ((i + 1) % 3);
        length[i] = sqrtf(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
        *scale = sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        if (fabsf(c[0] * d[0] + c[1] * d[1] + c[2] * d[2]) > 5e-5f * length[i] * *scale)
            return 0;
    }
    *scale = (length[0] + length[1] + length[2]) / 3;
    for (int i = 0; i < 3; i++)
        if (!(fabsf(length[i] - *scale) < 5e-5f * *scale))
            return 0;
    volume = m[0] * (m[5] * m[10] - m[6] * m[9]) - m[4] * (m[1] * m[10] - m[2] * m[9]) +
             m[8] * (m[1] * m[6] - m[2] * m[5]);
    return volume > 0;
}

static void soup_free(cs_soup *s)
{
    free(s->positions);
    free(s->indices);
}

/* Room for what was counted. */
static int soup_alloc(cs_soup *s, size_t vertices, size_t triangles, char *error)
{
    memset(s, 0, sizeof *s);
    if (vertices > UINT32_MAX) {
        snprintf(error, EX_ERROR_SIZE, "csm: the scene has too many vertices");
        return -1;
    }
    s->positions = malloc((3 * vertices + 1) * sizeof *s->positions);
    s->indices = malloc((3 * triangles + 1) * sizeof *s->indices);
    if (s->positions && s->indices)
        return 0;
    soup_free(s);
    return cs_out_of_memory(error);
}

/* All casters in world space; of the object `dark` what does not emit. */
static int whole_scene(cs_soup *s, const ex_scene *scene, uint32_t dark, char *error)
{
    size_t vertices = 0, triangles = 0;
    for (uint32_t i = 0; i < scene->object_count; i++)
        if (!scene->objects[i].receiver_only)
            cs_soup_count(scene, &scene->objects[i], &vertices, &triangles);
    if (soup_alloc(s, vertices, triangles, error) != 0)
        return -1;
    for (uint32_t i = 0; i < scene->object_count; i++)
        if (!scene->objects[i].receiver_only)
            cs_soup_add(s, scene, &scene->objects[i], scene->objects[i].transform, i == dark);
    return 0;
}

/* ---- building ---- */

static char progress_label[] = "csm maps";

static int build(cohsm_maps **out, cs_state *state, const rd_job *job, const cohsm_domain *domain, uint32_t map_side,
                 const cohsm_mesh *mesh, const char *name, char *error)
{
    cohsm_desc desc;
    cohsm_result result;
    memset(&desc, 0, sizeof desc);
    desc.domain = *domain;
    desc.map_side = map_side;
    desc.layers = state->options.layers;
    desc.order = state->options.order;
    desc.orientation = state->options.orientation;
    desc.depth_bits = state->options.depth_bits;
    desc.open_thickness = state->options.open_thickness;
    desc.layout = state->options.layout;
    desc.system.allocator = cs_memory_allocator(&state->memory);
    ex_pool_label(job->pool, progress_label);
    desc.system.parallel_for = ex_pool_run;
    desc.system.progress = ex_pool_progress;
    desc.system.user = job->pool;
    result = cohsm_build(&desc, mesh, out, NULL);
    ex_progress(NULL, 1);
    return result == COHSM_OK ? 0 : cs_failed(name, result, error);
}

static cohsm_mesh mesh_of(const ex_mesh *mesh)
{
    cohsm_mesh m = { mesh->positions, mesh->vertex_count, 0, mesh->indices, 3 * (size_t)mesh->triangle_count,
                     NULL, NULL, NULL };
    return m;
}

static cohsm_mesh mesh_of_soup(const cs_soup *s)
{
    cohsm_mesh m = { s->positions, s->vertices, 0, s->indices, 3 * s->triangles, NULL, NULL, NULL };
    return m;
}

static int allocate(cs_casters *c, const ex_scene *scene, char *error)
{
    size_t n = scene->object_count + (size_t)1;
    memset(c, 0, sizeof *c);
    c->instances = calloc(n, sizeof *c->instances);
    c->offsets = calloc(n, sizeof *c->offsets);
    c->reach = calloc(n, sizeof *c->reach);
    c->maps = calloc(n, sizeof(cohsm_maps *));
    c->entity = calloc(n, sizeof *c->entity);
    if (!c->instances || !c->offsets || !c->reach || !c->maps || !c->entity)
        return cs_out_of_memory(error);
    return 0;
}

/* Where an instance stands, and how far its maps reach: pcf reads the pixel beside and the cell beside, which in
   LATLONG is sqrt(5) pi / side away; a map of one direction is asked for that one. */
static void place_instance(cs_casters *c, size_t number, const float *m, float scale, const cs_options *options)
{
    cohsm_instance *instance = &c->instances[number];
    cs_reach *reach = &c->reach[number];
    cohsm_info info;
    float angle;
    cohsm_get_info(instance->maps, &info);
    memcpy(instance->transform, m, sizeof instance->transform);
    c->offsets[number] = info.positional ? 0 : options->offset * scale * 2 * info.radius / (float)info.map_side;
    for (int k = 0; k < 3; k++)
        reach->center[k] = m[k] * info.center[0] + m[4 + k] * info.center[1] + m[8 + k] * info.center[2] + m[12 + k];
    angle = info.domain == COHSM_DOMAIN_LIST ? 0 : 7.1f / (float)info.side[0];
    reach->radius = scale * info.radius * (1 + 4 / (float)info.map_side);
    reach->slack = (angle < 1.5f ? sinf(angle) : 1) + 1e-4f;
}

static void add_instance(cs_casters *c, const cohsm_maps *maps, const float *transform, float scale,
                         const cs_options *options)
{
    c->instances[c->count].maps = maps;
    place_instance(c, c->count++, transform, scale, options);
}

/* Everything that casts shadows as one object; it gets the maps *maps. */
static void add_whole(cs_casters *c, const ex_scene *scene, cohsm_maps *maps, const cs_options *options)
{
    c->maps[c->map_count++] = maps;
    add_instance(c, maps, identity, 1, options);
    for (uint32_t i = 0; i < scene->object_count; i++)
        if (!scene->objects[i].receiver_only)
            c->entity[i] = 1;
}

static int build_whole(cs_casters *c, cs_state *state, const rd_job *job, const cohsm_domain *domain,
                       uint32_t map_side, uint32_t dark, char *error)
{
    cohsm_mesh mesh;
    cohsm_maps *maps;
    cs_soup s;
    int result;
    if (whole_scene(&s, job->scene, dark, error) != 0)
        return -1;
    mesh = mesh_of_soup(&s);
    result = s.triangles ? build(&maps, state, job, domain, map_side, &mesh, job->scene->name, error) : 0;
    if (result == 0 && s.triangles)
        add_whole(c, job->scene, maps, &state->options);
    soup_free(&s);
    return result;
}

/* The direction as an object sees it that stands in the world by a similarity. */
static void to_object(const float *m, const float *direction, float *out)
{
    float length;
    for (int i = 0; i < 3; i++)
        out[i] = m[4 * i] * direction[0] + m[4 * i + 1] * direction[1] + m[4 * i + 2] * direction[2];
    length = sqrtf(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
    for (int i = 0; i < 3; i++)
        out[i] /= length;
}

/* Maps that an earlier object got for the same mesh and, with a sun, for the same direction in its space. */
static const cohsm_maps *find_maps(const cs_casters *c, const ex_scene *scene, uint32_t object, const float *location)
{
    for (uint32_t i = 0; i < object; i++) {
        const cohsm_maps *maps;
        float scale, d[4];
        if (scene->objects[i].mesh != scene->objects[object].mesh || !c->entity[i] ||
            (scene->objects[i].material != scene->objects[object].material &&
             (cs_has_holes(scene, &scene->objects[i]) || cs_has_holes(scene, &scene->objects[object]))) ||
            !is_similarity(scene->objects[i].transform, &scale))
            continue;
        maps = c->instances[c->entity[i] - 1].maps;
        if (!location || (cohsm_location(maps, 0, d) == COHSM_OK &&
                          fabsf(d[0] - location[0]) + fabsf(d[1] - location[1]) + fabsf(d[2] - location[2]) < 1e-6f))
            return maps;
    }
    return NULL;
}

static int build_object(cs_casters *c, cs_state *state, const rd_job *job, uint32_t object, const float *direction,
                        char *error)
{
    const ex_scene *scene = job->scene;
    const ex_object *o = &scene->objects[object];
    const ex_mesh *source = &scene->meshes[o->mesh];
    float scale = 1, location[4] = { 0, 0, 0, 0 };
    int similar = is_similarity(o->transform, &scale), result = 0;
    const cohsm_maps *maps;
    cohsm_domain domain;
    if (direction)
        to_object(similar ? o->transform : identity, direction, location);
    maps = similar ? find_maps(c, scene, object, direction ? location : NULL) : NULL;
    if (!maps) {
        cs_masked masked = { scene, o };
        cohsm_mesh mesh = mesh_of(source);
        cohsm_maps *made = NULL;
        cs_soup moved = { NULL, NULL, NULL, 0, 0 };
        memset(&domain, 0, sizeof domain);
        domain.side[0] = domain.side[1] = state->options.side;
        if (direction) {
            domain.kind = COHSM_DOMAIN_LIST;
            domain.locations = location;
            domain.location_count = 1;
        }
        if (similar && cs_has_holes(scene, o)) {
            mesh.mask_fn = cs_is_there;
            mesh.user = &masked;
        }
        if (!similar) {
            size_t vertices = 0, triangles = 0;
            cs_soup_count(scene, o, &vertices, &triangles);
            if (soup_alloc(&moved, vertices, triangles, error) != 0)
                return -1;
            cs_soup_add(&moved, scene, o, o->transform, 0);
            mesh = mesh_of_soup(&moved);
        }
        result = build(&made, state, job, &domain, direction ? state->options.hard_size : state->options.map_side,
                       &mesh, o->name, error);
        soup_free(&moved);
        if (result != 0)
            return -1;
        maps = c->maps[c->map_count++] = made;
    }
    add_instance(c, maps, similar ? o->transform : identity, similar ? scale : 1, &state->options);
    c->entity[object] = (uint32_t)c->count;
    c->movable &= similar && !source->deforms;
    return 0;
}

int cs_casters_build(cs_casters *c, cs_state *state, const rd_job *job, const float *direction, char *error)
{
    const ex_scene *scene = job->scene;
    if (allocate(c, scene, error) != 0)
        return -1;
    if (state->options.whole > 0 || (state->options.whole < 0 && scene->object_count > MOST_OBJECTS)) {
        cohsm_domain domain;
        float location[4] = { 0, 0, 0, 0 };
        memset(&domain, 0, sizeof domain);
        domain.side[0] = domain.side[1] = state->options.side;
        if (direction) {
            memcpy(location, direction, 3 * sizeof *direction);
            domain.kind = COHSM_DOMAIN_LIST;
            domain.locations = location;
            domain.location_count = 1;
        }
        return build_whole(c, state, job, &domain, direction ? state->options.hard_size : state->options.map_side,
                           NO_OBJECT, error);
    }
    c->movable = !direction;
    for (uint32_t i = 0; i < scene->object_count; i++)
        if (!scene->objects[i].receiver_only && scene->meshes[scene->objects[i].mesh].triangle_count &&
            build_object(c, state, job, i, direction, error) != 0)
            return -1;
    return 0;
}

int cs_casters_move(cs_casters *c, const cs_state *state, const ex_scene *scene)
{
    float scale;
    for (uint32_t i = 0; c->movable && i < scene->object_count; i++)
        if (c->entity[i]) {
            c->movable = is_similarity(scene->objects[i].transform, &scale);
            if (c->movable)
                place_instance(c, c->entity[i] - 1, scene->objects[i].transform, scale, &state->options);
        }
    return c->movable;
}

int cs_casters_build_local(cs_casters *c, cs_state *state, const rd_job *job, const cohsm_domain *domain,
                           const cs_light *light, char *error)
{
    uint32_t dark = light->is_mesh && !state->options.emitters_cast ? light->object : NO_OBJECT;
    if (allocate(c, job->scene, error) != 0)
        return -1;
    return build_whole(c, state, job, domain, light->map_side, dark, error);
}

/* ---- receivers ---- */

/* 1 and the plane that all vertices of an object lie in. */
static int is_flat(const ex_mesh *mesh, const float *m, cs_plane *plane)
{
    double corner[3][3], a[3], b[3], n[3], length;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            const float *p = mesh->positions + 3 * (size_t)mesh->indices[i];
            corner[i][k] = (double)(m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k]);
        }
    for (int k = 0; k < 3; k++) {
        a[k] = corner[1][k] - corner[0][k];
        b[k] = corner[2][k] - corner[0][k];
    }
    for (int k = 0; k < 3; k++)
        n[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
    length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (!(length > 0))
        return 0;
    for (int k = 0; k < 3; k++)
        plane->normal[k] = (float)(n[k] / length);
    plane->distance = (float)((n[0] * corner[0][0] + n[1] * corner[0][1] + n[2] * corner[0][2]) / length);
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        const float *p = mesh->positions + 3 * (size_t)i;
        float height = -plane->distance;
        for (int k = 0; k < 3; k++)
            height += plane->normal[k] * (m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k]);
        if (fabsf(height) > 1e-5f * (float)sqrt(length))
            return 0;
    }
    return 1;
}

int cs_planes_build(cs_plane **planes, size_t *count, const ex_scene *scene, char *error)
{
    *count = 0;
    *planes = calloc(scene->object_count + (size_t)1, sizeof **planes);
    if (!*planes)
        return cs_out_of_memory(error);
    for (uint32_t i = 0; i < scene->object_count; i++) {
        const ex_mesh *mesh = &scene->meshes[scene->objects[i].mesh];
        if (scene->objects[i].receiver_only && mesh->triangle_count &&
            is_flat(mesh, scene->objects[i].transform, &(*planes)[*count]))
            (*planes)[(*count)++].object = i;
    }
    return 0;
}

/* ---- maps that are there already ---- */

/* By way of a single map, the smallest there is. */
int cs_casters_sphere(const rd_job *job, float sphere[4], char *error)
{
    static const float up[4] = { 0, 1, 0, 0 };
    cohsm_desc desc;
    cohsm_mesh mesh;
    cohsm_info info;
    cohsm_maps *maps;
    cohsm_result result;
    cs_soup s;
    if (whole_scene(&s, job->scene, NO_OBJECT, error) != 0)
        return -1;
    memset(&desc, 0, sizeof desc);
    memset(sphere, 0, 4 * sizeof *sphere);
    desc.domain.kind = COHSM_DOMAIN_LIST;
    desc.domain.locations = up;
    desc.domain.location_count = 1;
    desc.map_side = 4;
    mesh = mesh_of_soup(&s);
    result = s.triangles ? cohsm_build(&desc, &mesh, &maps, NULL) : COHSM_ERR_INPUT;
    soup_free(&s);
    if (result == COHSM_ERR_INPUT)               /* nothing casts a shadow */
        return 0;
    if (result != COHSM_OK)
        return cs_failed(job->scene->name, result, error);
    cohsm_get_info(maps, &info);
    memcpy(sphere, info.center, sizeof info.center);
    sphere[3] = info.radius;
    cohsm_free(maps);
    return 0;
}

int cs_casters_of(cs_casters *c, const cs_state *state, const rd_job *job, cohsm_maps *maps, char *error)
{
    if (allocate(c, job->scene, error) != 0)
        return -1;
    add_whole(c, job->scene, maps, &state->options);
    c->borrowed = 1;
    return 0;
}

void cs_casters_free(cs_casters *c)
{
    for (size_t i = 0; i < c->map_count && !c->borrowed; i++)
        cohsm_free(c->maps[i]);
    free(c->instances);
    free(c->offsets);
    free(c->reach);
    free(c->maps);
    free(c->entity);
    memset(c, 0, sizeof *c);
}
