/* rsm_maps.c - a frame's map of a sun by rsm.h, 512 x 512: drawn anew as in every frame, kept by rsm_redraw since
   nothing moved, and drawn by it since one object did; by turns, with the mean of each. And a map of leaves, drawn
   whole and with the holes of a mask. */
#define _POSIX_C_SOURCE 200809L
#include "bench.h"
#include "rsm.h"

#include <stdlib.h>
#include <string.h>

enum { TURNS = 5 };

typedef struct surface { const ex_scene *scene; const ex_object *object; } surface;

static void surface_color(void *user, const rsm_mesh *mesh, uint32_t triangle, const float weights[3], float albedo[3])
{
    const surface *s = user;
    (void)mesh;
    ex_surface_color(s->scene, s->object, triangle, weights, albedo);
}

/* The scene's objects as meshes; returns the triangles. */
static uint64_t convert(const ex_scene *scene, surface *surfaces, rsm_mesh *meshes)
{
    uint64_t triangles = 0;
    for (uint32_t i = 0; i < scene->object_count; i++) {
        const ex_object *object = &scene->objects[i];
        const ex_mesh *mesh = &scene->meshes[object->mesh];
        surfaces[i].scene = scene;
        surfaces[i].object = object;
        meshes[i].positions = mesh->positions;
        meshes[i].vertex_count = mesh->vertex_count;
        meshes[i].indices = mesh->indices;
        meshes[i].index_count = 3 * (size_t)mesh->triangle_count;
        meshes[i].transform = object->transform;
        meshes[i].surface_fn = surface_color;
        meshes[i].user = &surfaces[i];
        meshes[i].version = 1;
        triangles += mesh->triangle_count;
    }
    return triangles;
}

static int draw(rsm_map *map, const rsm_mesh *meshes, size_t count)
{
    return rsm_map_restart(map, NULL) == RSM_OK && rsm_rasterize(map, meshes, count) == RSM_OK &&
           rsm_finish(map, NULL) == RSM_OK;
}

/* Seconds of each way, TURNS of each; *same: kept and drawn maps had the same bytes. Returns 0 on failure. */
static int take_turns(rsm_map *map, rsm_map *other, rsm_mesh *meshes, size_t count, double seconds[3], int *same)
{
    float moved[16];
    rsm_info info;
    int kept = 0;
    memcpy(moved, meshes[0].transform, sizeof moved);
    rsm_get_info(map, &info);
    *same = 1;
    if (rsm_redraw(other, NULL, meshes, count, NULL, NULL) != RSM_OK)
        return 0;
    for (int turn = 0; turn < TURNS; turn++) {
        const float *still = meshes[0].transform;
        double start = ex_seconds();
        if (!draw(map, meshes, count))
            return 0;
        seconds[0] += (ex_seconds() - start) / TURNS;
        start = ex_seconds();
        if (rsm_redraw(other, NULL, meshes, count, &kept, NULL) != RSM_OK || !kept)
            return 0;
        seconds[1] += (ex_seconds() - start) / TURNS;
        *same &= memcmp(rsm_map_texels(map), rsm_map_texels(other), info.texel_count * sizeof(rsm_texel)) == 0;
        moved[13] += 0.01f;
        meshes[0].transform = moved;
        start = ex_seconds();
        if (rsm_redraw(other, NULL, meshes, count, &kept, NULL) != RSM_OK || kept)
            return 0;
        seconds[2] += (ex_seconds() - start) / TURNS;
        meshes[0].transform = still;
        if (rsm_redraw(other, NULL, meshes, count, NULL, NULL) != RSM_OK)
            return 0;
    }
    return 1;
}

static int measure(const bn_options *options, const char *name, const ex_scene *scene)
{
    surface *surfaces = calloc(scene->object_count + (size_t)1, sizeof *surfaces);
    rsm_mesh *meshes = calloc(scene->object_count + (size_t)1, sizeof *meshes);
    double seconds[3] = { 0, 0, 0 };
    rsm_map *map = NULL, *other = NULL;
    uint64_t triangles;
    rsm_desc desc;
    int same = 0, done = 0;
    memset(&desc, 0, sizeof desc);
    desc.system.parallel_for = ex_pool_run;
    desc.system.user = options->pool;
    desc.light.direction[0] = 0.48f;
    desc.light.direction[1] = 0.8f;
    desc.light.direction[2] = 0.36f;
    desc.light.value[0] = desc.light.value[1] = desc.light.value[2] = 1;
    if (surfaces && meshes) {
        triangles = convert(scene, surfaces, meshes);
        ex_scene_bounds(scene, desc.light.position, &desc.light.radius);
        done = rsm_map_create(&desc, &map) == RSM_OK && rsm_map_create(&desc, &other) == RSM_OK &&
               take_turns(map, other, meshes, scene->object_count, seconds, &same);
    }
    if (done) {
        bn_begin(options, "rsm_maps", options->threads, bn_simd());
        bn_text("scene", name);
        bn_integer("objects", scene->object_count);
        bn_integer("triangles", triangles);
        bn_number("drawn_ms", 1000 * seconds[0]);
        bn_number("kept_ms", 1000 * seconds[1]);
        bn_number("moved_ms", 1000 * seconds[2]);
        bn_number("kept_over_drawn", seconds[1] / seconds[0]);
        bn_flag("same_bytes", same);
        bn_end(options);
    }
    rsm_map_free(other);
    rsm_map_free(map);
    free(meshes);
    free(surfaces);
    return done ? 0 : bn_failed("rsm_maps", "a map cannot be drawn");
}

int bn_rsm_maps(const bn_options *options)
{
    static const char *const names[] = { "cornell", "atrium" };
    int result = 0;
    for (size_t i = 0; i < 2 && result == 0; i++) {
        char error[EX_ERROR_SIZE];
        ex_scene scene;
        if (ex_scene_builtin(&scene, names[i], 0, error) != 0)
            return bn_failed(names[i], error);
        result = measure(options, names[i], &scene);
        ex_scene_free(&scene);
    }
    return result;
}

/* ---- alpha masks ---- */

/* No built-in scene has a mask, so every second square of eight by eight over each triangle is a hole. */
static int is_there(void *user, uint32_t triangle, const float weights[3])
{
    (void)user;
    (void)triangle;
    return ((int)(8 * weights[0]) + (int)(8 * weights[1])) % 2 == 0;
}

/* Draws the map without masks and with them by turns: seconds of each, and the texels that light falls on. */
static int draw_masks(rsm_map *map, rsm_mesh *meshes, size_t count, double seconds[2], rsm_stats stats[2])
{
    for (int turn = 0; turn < 2 * TURNS; turn++) {
        double start;
        for (size_t i = 0; i < count; i++)
            meshes[i].mask_fn = turn % 2 ? is_there : NULL;
        start = ex_seconds();
        if (rsm_map_restart(map, NULL) != RSM_OK || rsm_rasterize(map, meshes, count) != RSM_OK)
            return 0;
        seconds[turn % 2] += (ex_seconds() - start) / TURNS;
        if (rsm_finish(map, &stats[turn % 2]) != RSM_OK)
            return 0;
    }
    return 1;
}

int bn_rsm_masks(const bn_options *options)
{
    char error[EX_ERROR_SIZE];
    ex_scene scene;
    surface *surfaces;
    rsm_mesh *meshes;
    double seconds[2] = { 0, 0 };
    rsm_stats stats[2];
    rsm_map *map = NULL;
    rsm_desc desc;
    uint64_t triangles = 0;
    int done = 0;
    if (ex_scene_builtin(&scene, "plant", 0, error) != 0)
        return bn_failed("plant", error);
    surfaces = calloc(scene.object_count + (size_t)1, sizeof *surfaces);
    meshes = calloc(scene.object_count + (size_t)1, sizeof *meshes);
    memset(&desc, 0, sizeof desc);
    desc.system.parallel_for = ex_pool_run;
    desc.system.user = options->pool;
    desc.light.direction[0] = 0.48f;
    desc.light.direction[1] = 0.8f;
    desc.light.direction[2] = 0.36f;
    desc.light.value[0] = desc.light.value[1] = desc.light.value[2] = 1;
    if (surfaces && meshes) {
        triangles = convert(&scene, surfaces, meshes);
        ex_scene_bounds(&scene, desc.light.position, &desc.light.radius);
        done = rsm_map_create(&desc, &map) == RSM_OK && draw_masks(map, meshes, scene.object_count, seconds, stats);
    }
    if (done) {
        bn_begin(options, "rsm_masks", options->threads, bn_simd());
        bn_text("scene", "plant");
        bn_integer("triangles", triangles);
        bn_number("whole_ms", 1000 * seconds[0]);
        bn_number("cut_ms", 1000 * seconds[1]);
        bn_number("reflected_cut_over_whole", stats[1].reflected[1] / stats[0].reflected[1]);
        bn_end(options);
    }
    rsm_map_free(map);
    free(meshes);
    free(surfaces);
    ex_scene_free(&scene);
    return done ? 0 : bn_failed("rsm_masks", "a map cannot be drawn");
}
