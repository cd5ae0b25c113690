/* setup.c - see setup.h */
#include "setup.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *builtin_name(const char *text)
{
    return strncmp(text, "builtin:", 8) == 0 ? text + 8 : NULL;
}

static int out_of_memory(char *error)
{
    snprintf(error, EX_ERROR_SIZE, "out of memory");
    return -1;
}

static int add_light(ex_scene *scene, const ex_light *light)
{
    ex_light *grown = realloc(scene->lights, (scene->light_count + (size_t)1) * sizeof *grown);
    if (!grown)
        return -1;
    scene->lights = grown;
    scene->lights[scene->light_count++] = *light;
    return 0;
}

/* --light. Spot and point without a value: I = pi d^2, which is E = pi at the scene's centre. */
static int add_lights(ex_scene *scene, const rd_job *job, const rd_args *args, char *error)
{
    for (uint32_t i = 0; i < args->light_count; i++) {
        ex_light light = args->lights[i].light;
        if (!args->lights[i].has_value) {
            float squared = 0;
            for (int k = 0; k < 3; k++) {
                float d = light.position[k] - job->center[k];
                squared += d * d;
            }
            for (int k = 0; k < 3; k++)
                light.value[k] = 3.14159265f * squared;
        }
        if (add_light(scene, &light) != 0)
            return out_of_memory(error);
    }
    return 0;
}

/* The setting `lamp_count`: on a circle that the scene's sphere does not reach, above its middle. */
static void place_lamps(ex_scene *scene, const rd_job *job, float time)
{
    for (uint32_t i = 0; i < job->ring_count; i++) {
        const float angle = 6.28318531f * ((float)i / (float)job->ring_count + time / 8), *ring = job->ring;
        float *at = scene->lights[scene->light_count - job->ring_count + i].position;
        at[0] = ring[0] + 1.3f * ring[3] * cosf(angle);
        at[1] = ring[1] + 0.9f * ring[3];
        at[2] = ring[2] + 1.3f * ring[3] * sinf(angle);
    }
}

/* ---- the setting `sun_turn` ---- */

static int find_sun(ex_scene *scene, rd_job *job, const rd_args *args, char *error)
{
    uint32_t i = 0;
    job->sun_turn = rd_setting_number(&args->settings, "sun_turn");
    if (!(job->sun_turn < 0 || job->sun_turn > 0))
        return 0;
    while (i < scene->light_count && scene->lights[i].kind != EX_LIGHT_SUN)
        i++;
    if (i == scene->light_count) {
        snprintf(error, EX_ERROR_SIZE, "sun_turn: the scene has no sun; --light sun:0.48,0.8,0.36 is one");
        return -1;
    }
    job->sun_number = i;
    job->sun = scene->lights[i];
    scene->animated = 1;
    return 0;
}

/* As seen from 45 degrees north, where +X is east and +Z south: about the pole, which stands half way up the sky in
   the north, from east over south to west. Below the horizon the sun is dark. */
static void place_sun(ex_scene *scene, const rd_job *job, float time)
{
    const double angle = job->sun_turn * (double)time / 180 * 3.14159265358979323846, c = cos(angle), s = -sin(angle);
    const double pole[3] = { 0, 0.70710678118654752, -0.70710678118654752 };
    const float *d = job->sun.direction;
    ex_light *sun = &scene->lights[job->sun_number];
    double on = 0, crossed[3];
    if (!(job->sun_turn < 0 || job->sun_turn > 0))
        return;
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        on += pole[k] * (double)d[k];
        crossed[k] = pole[i] * (double)d[j] - pole[j] * (double)d[i];
    }
    *sun = job->sun;
    for (int k = 0; k < 3; k++)
        sun->direction[k] = (float)(c * (double)d[k] + s * crossed[k] + (1 - c) * on * pole[k]);
    if (!(sun->direction[1] > 0))
        memset(sun->value, 0, sizeof sun->value);
}

/* Together they give the scene's middle about pi. */
static int add_lamps(ex_scene *scene, rd_job *job, const rd_args *args, char *error)
{
    static const float colors[2][3] = { { 1.25f, 1, 0.75f }, { 0.75f, 1, 1.25f } };
    uint32_t count = (uint32_t)rd_setting_integer(&args->settings, "lamp_count");
    ex_light lamp;
    memset(&lamp, 0, sizeof lamp);
    lamp.kind = EX_LIGHT_SPHERE;
    lamp.radius = 0.1f * job->radius;
    memcpy(job->ring, job->center, sizeof job->center);
    job->ring[3] = job->radius;
    job->ring_count = count;
    for (uint32_t i = 0; i < count; i++) {
        for (int k = 0; k < 3; k++)
            lamp.value[k] = colors[i & 1][k] * 250 / (float)count;
        if (add_light(scene, &lamp) != 0)
            return out_of_memory(error);
    }
    scene->animated = scene->animated || count;
    return 0;
}

/* Radiance is finite and not negative from here on, for every technique alike. */
static void scale_sky(ex_sky *sky, float scale)
{
    size_t values = 3 * (size_t)sky->width * sky->height;
    for (size_t i = 0; i < values; i++) {
        float value = sky->rgb[i] * scale;
        sky->rgb[i] = value > 0 && value < 1e30f ? value : 0;
    }
}

static int wants_sun(const rd_technique *technique)        /* "nothing given" of rsm and ism */
{
    return strcmp(technique->name, "rsm") == 0 || strcmp(technique->name, "ism") == 0;
}

/* --env, or the light of a scene that brings none and was given none. */
static int add_sky(ex_scene *scene, const rd_args *args, int has_light, char *error)
{
    const char *env = args->env ? args->env : has_light ? NULL : "builtin:sky";
    ex_sky sky;
    int result;
    if (!args->env && !has_light && wants_sun(args->technique)) {
        const ex_light sun = { EX_LIGHT_SUN, { 0, 0, 0 }, { 0.48f, 0.8f, 0.36f }, { 0, 0, 0 }, { 0, 0, 0 }, 0, 0,
                               { 3.14159265f, 3.14159265f, 3.14159265f } };
        return add_light(scene, &sun) ? out_of_memory(error) : 0;
    }
    if (env) {
        result = builtin_name(env) ? ex_sky_builtin(&sky, builtin_name(env), error) : ex_sky_load(&sky, env, error);
        if (result != 0)
            return -1;
        ex_sky_free(&scene->sky);
        scene->sky = sky;
    }
    scene->sky.rotation += (float)(rd_setting_number(&args->settings, "env_rotation") / 180 * 3.14159265358979323846);
    scale_sky(&scene->sky, (float)rd_setting_number(&args->settings, "env_scale"));
    return 0;
}

/* Bounds and emitters. */
static int measure(const ex_scene *scene, rd_job *job, rd_emitter **emitters, char *error)
{
    if (ex_scene_bounds(scene, job->center, &job->radius) != 0 || !(job->radius > 0)) {
        snprintf(error, EX_ERROR_SIZE, "%.120s: the scene is empty", scene->name);
        return -1;
    }
    free(*emitters);
    *emitters = NULL;
    if (rd_emitters_build(scene, emitters, &job->emitter_count) != 0)
        return out_of_memory(error);
    job->emitters = *emitters;
    return 0;
}

/* ---- emitters=removed ---- */

static int is_dark(const ex_scene *scene, uint32_t material)
{
    const float *e = scene->materials[material].emission;
    return !(e[0] > 0 || e[1] > 0 || e[2] > 0);
}

/* Only vertices that a triangle has: the others would still count among the scene's bounds. */
static int drop_unused_vertices(ex_mesh *mesh)
{
    size_t corners = 3 * (size_t)mesh->triangle_count;
    uint32_t *place = calloc(mesh->vertex_count + (size_t)1, sizeof *place), used = 0;     /* 1 + the new number */
    if (!place)
        return -1;
    for (size_t i = 0; i < corners; i++)
        place[mesh->indices[i]] = 1;
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        if (!place[i])
            continue;
        memmove(mesh->positions + 3 * (size_t)used, mesh->positions + 3 * i, 3 * sizeof(float));
        memmove(mesh->normals + 3 * (size_t)used, mesh->normals + 3 * i, 3 * sizeof(float));
        if (mesh->uvs)
            memmove(mesh->uvs + 2 * (size_t)used, mesh->uvs + 2 * i, 2 * sizeof(float));
        place[i] = ++used;
    }
    for (size_t i = 0; i < corners; i++)
        mesh->indices[i] = place[mesh->indices[i]] - 1;
    mesh->vertex_count = used;
    free(place);
    return 0;
}

/* A mesh that deforms goes as a whole where any of it shines: which part does may change with time. */
static int remove_emitters(const ex_scene *scene, ex_mesh *mesh)
{
    uint32_t left = 0;
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        if (!is_dark(scene, mesh->materials[t]))
            continue;
        memmove(mesh->indices + 3 * (size_t)left, mesh->indices + 3 * (size_t)t, 3 * sizeof *mesh->indices);
        mesh->materials[left++] = mesh->materials[t];
    }
    if (left == mesh->triangle_count)
        return 0;
    mesh->triangle_count = mesh->deforms ? 0 : left;
    return drop_unused_vertices(mesh);
}

/* What the setting `emitters` says of emissive surfaces: shine, be dark, or not be there. */
static int treat_emitters(ex_scene *scene, const rd_args *args)
{
    int result = 0;
    if (rd_setting_is(&args->settings, "emitters", "1"))
        return 0;
    for (uint32_t i = 0; i < scene->mesh_count && rd_setting_is(&args->settings, "emitters", "removed"); i++)
        result |= remove_emitters(scene, &scene->meshes[i]);
    for (uint32_t i = 0; i < scene->material_count; i++)
        memset(scene->materials[i].emission, 0, sizeof scene->materials[i].emission);
    return result;
}

/* What the settings `roughness` and `metallic` make of all materials. */
static void treat_materials(ex_scene *scene, const rd_args *args)
{
    for (uint32_t i = 0; i < scene->material_count; i++) {
        if (!rd_setting_is(&args->settings, "roughness", "auto"))
            scene->materials[i].roughness = (float)rd_setting_number(&args->settings, "roughness");
        if (!rd_setting_is(&args->settings, "metallic", "auto"))
            scene->materials[i].metallic = (float)rd_setting_number(&args->settings, "metallic");
    }
}

static int finish(ex_scene *scene, rd_job *job, rd_emitter **emitters, const rd_args *args, char *error)
{
    int has_light, ground;
    if (treat_emitters(scene, args) != 0)
        return out_of_memory(error);
    treat_materials(scene, args);
    if (measure(scene, job, emitters, error) != 0)
        return -1;
    ground = rd_setting_is(&args->settings, "ground", "auto") ? !scene->has_camera && job->emitter_count == 0
                                                              : rd_setting_integer(&args->settings, "ground");
    if (args->has_camera)
        scene->camera = args->camera;
    else if (!scene->has_camera)
        ex_scene_default_camera(scene, args->width, args->height);
    scene->has_camera = 1;
    if (rd_setting_is(&args->settings, "still", "1")) {
        scene->animated = 0;
        scene->pose = NULL;
        ex_scene_keep_figures(scene);
    }
    if (add_lights(scene, job, args, error) != 0 || add_lamps(scene, job, args, error) != 0)
        return -1;
    has_light = scene->light_count > 0 || job->emitter_count > 0 || scene->sky.width > 0;
    if (add_sky(scene, args, has_light, error) != 0 || find_sun(scene, job, args, error) != 0)
        return -1;
    return ground && ex_scene_add_ground(scene) != 0 ? out_of_memory(error) : 0;
}

/* At that time: a built-in scene, or a file with its animation. */
static int load_scene(ex_scene *scene, const rd_args *args, float time, char *error)
{
    const char *builtin = builtin_name(args->scene);
    int result;
    ex_animation = (int)rd_setting_integer(&args->settings, "animation");
    result = builtin ? ex_scene_builtin(scene, builtin, time, error) : ex_scene_load(scene, args->scene, error);
    if (result == 0 && args->figure[0])
        result = ex_scene_add_figures(scene, args->figure, args->figure_at, error);
    if (result == 0 && (!builtin || args->figure[0]))
        result = ex_scene_set_time(scene, time, error);
    ex_animation = -1;
    if (result != 0)
        ex_scene_free(scene);
    return result;
}

int rd_setup(ex_scene *scene, rd_job *job, rd_emitter **emitters, const rd_args *args, float time, char *error)
{
    *emitters = NULL;
    if (load_scene(scene, args, time, error) != 0)
        return -1;
    if (finish(scene, job, emitters, args, error) == 0) {
        job->time = time;
        place_lamps(scene, job, time);
        place_sun(scene, job, time);
        return 0;
    }
    ex_scene_free(scene);
    free(*emitters);
    *emitters = NULL;
    return -1;
}

int rd_move(ex_scene *scene, rd_job *job, rd_emitter **emitters, float time, char *error)
{
    if (ex_scene_set_time(scene, time, error) != 0)
        return -1;
    job->time = time;
    place_lamps(scene, job, time);
    place_sun(scene, job, time);
    return measure(scene, job, emitters, error);
}
