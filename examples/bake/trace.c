/* trace.c - see trace.h */
#include "trace.h"
#include "../render/args.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

double bk_random(uint64_t *state)            /* splitmix64 */
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) * (1.0 / 9007199254740992.0);
}

/* ---- the scene ---- */

/* Like render, without a value a lamp's intensity is pi times its squared distance from the scene's centre. */
static int add_light(bk_trace *t, ex_scene *scene, const char *text, char *error)
{
    rd_light_arg arg;
    ex_light *grown;
    if (rd_light_parse(&arg, text, error) != 0)
        return -1;
    if (!arg.has_value) {
        const rf_v3 away = rf_sub(rf_load(arg.light.position), rf_load(t->center));
        for (int k = 0; k < 3; k++)
            arg.light.value[k] = (float)(PI * rf_dot(away, away));
    }
    grown = realloc(scene->lights, (scene->light_count + (size_t)1) * sizeof *grown);
    if (!grown)
        return bk_fail(error, "out of memory", "");
    scene->lights = grown;
    grown[scene->light_count++] = arg.light;
    return 0;
}

static int add_sky(const bk_args *args, ex_scene *scene, char *error)
{
    const int shines = scene->light_count || scene->sky.width || ex_scene_has_emitters(scene);
    const char *env = args->env ? args->env : shines ? NULL : "builtin:sky";
    ex_sky sky;
    if (!env)
        return 0;
    if ((strncmp(env, "builtin:", 8) ? ex_sky_load(&sky, env, error) : ex_sky_builtin(&sky, env + 8, error)) != 0)
        return -1;
    ex_sky_free(&scene->sky);
    scene->sky = sky;
    return 0;
}

int bk_trace_open(bk_trace *t, const bk_args *args, ex_scene *scene, char *error)
{
    rd_job job;
    memset(t, 0, sizeof *t);
    memset(&job, 0, sizeof job);
    if (ex_scene_bounds(scene, t->center, &t->radius) != 0)
        return bk_fail(error, "the scene is empty", "");
    for (size_t i = 0; i < args->light_count; i++)
        if (add_light(t, scene, args->lights[i], error) != 0)
            return -1;
    if (add_sky(args, scene, error) != 0)
        return -1;
    if (rd_emitters_build(scene, &t->emitters, &job.emitter_count) != 0)
        return bk_fail(error, "out of memory", "");
    t->epsilon = 4e-5 * (double)t->radius;
    job.scene = scene;
    job.emitters = t->emitters;
    memcpy(job.center, t->center, sizeof job.center);
    job.radius = t->radius;
    t->scene = rf_scene_create(scene, args->threads, error);
    if (t->scene && rf_lights_init(&t->lights, &job, t->epsilon, error) == 0)
        return 0;
    rf_scene_free(t->scene);
    free(t->emitters);
    memset(t, 0, sizeof *t);
    return -1;
}

void bk_trace_close(bk_trace *t)
{
    if (t->scene) {
        rf_lights_free(&t->lights);
        rf_scene_free(t->scene);
    }
    free(t->emitters);
    memset(t, 0, sizeof *t);
}

/* ---- paths ---- */

static int is_visible(const bk_trace *t, rf_v3 from, const rf_light_sample *light)
{
    const rf_v3 d = rf_sub(light->target, from);
    const double distance = rf_length(d);
    if (light->at_infinity)
        return !rf_scene_blocked(t->scene, from, light->direction, HUGE_VAL);
    return !(distance > t->epsilon) ||
           !rf_scene_blocked(t->scene, from, rf_scale(d, 1 / distance), distance - t->epsilon);
}

/* One sample of direct light at a point: radiance times solid angle, or irradiance across the direction; 0 behind. */
static int sample_light(const bk_trace *t, rf_v3 p, rf_v3 normal, const double u[2], rf_v3 *direction, rf_v3 *light)
{
    rf_light_sample s;
    if (!rf_lights_sample(&t->lights, p, 0, u, &s) || !(s.pdf > 0) || rf_is_black(s.value))
        return 0;
    if (rf_dot(normal, normal) > 0 && !(rf_dot(normal, s.direction) > 0))
        return 0;
    *direction = s.direction;
    *light = rf_scale(s.value, 1 / s.pdf);
    return is_visible(t, p, &s);
}

static rf_v3 about(rf_v3 n, uint64_t *state)                 /* by the cosine */
{
    const double r = sqrt(bk_random(state)), phi = 2 * PI * bk_random(state);
    rf_v3 x, y;
    rf_frame(n, &x, &y);
    return rf_from_frame(x, y, n, rf_make(r * cos(phi), r * sin(phi), sqrt(rf_most(0, 1 - r * r))));
}

static rf_v3 anywhere(uint64_t *state)
{
    const double z = 2 * bk_random(state) - 1, phi = 2 * PI * bk_random(state), r = sqrt(rf_most(0, 1 - z * z));
    return rf_make(r * cos(phi), r * sin(phi), z);
}

/* Radiance that comes back from a ray's hit after one to all bounces; emission is not in it, lights were sampled. */
static rf_v3 bounced(const bk_trace *t, rf_v3 origin, rf_v3 direction, uint64_t *state)
{
    rf_v3 sum = rf_make(0, 0, 0), through = rf_make(1, 1, 1);
    for (int bounce = 0; bounce < t->bounces; bounce++) {
        rf_hit hit;
        rf_v3 p, to, light;
        double u[2];
        if (!rf_scene_trace(t->scene, origin, direction, t->epsilon, &hit))
            break;
        p = rf_mad(hit.position, hit.geometric, t->epsilon);
        through = rf_mul(through, hit.base);
        u[0] = bk_random(state);
        u[1] = bk_random(state);
        if (sample_light(t, p, hit.normal, u, &to, &light))
            sum = rf_add(sum, rf_mul(through, rf_scale(light, rf_most(rf_dot(hit.normal, to), 0) / PI)));
        origin = p;
        direction = about(hit.normal, state);
    }
    return sum;
}

static double wrapped(double x) { return x < 1 ? x : x - 1; }

void bk_trace_light(const bk_trace *t, rf_v3 p, rf_v3 normal, uint32_t samples, uint64_t seed, bk_take_light take,
                    void *user)
{
    const int half = rf_dot(normal, normal) > 0;
    uint64_t state = bk_hash(BK_HASH, &seed, sizeof seed);
    const double shift[2] = { bk_random(&state), bk_random(&state) };
    for (uint32_t i = 0; i < samples; i++) {         /* Hammersley's points, moved; the rest is random */
        const double u[2] = { wrapped((i + 0.5) / samples + shift[0]), wrapped(rf_to_unit(rf_reverse(i)) + shift[1]) };
        rf_v3 direction, light;
        double cosine;
        if (sample_light(t, p, normal, u, &direction, &light))
            take(user, direction, rf_scale(light, 1.0 / samples));
        if (!t->bounces)
            continue;
        direction = half ? about(normal, &state) : anywhere(&state);
        light = bounced(t, p, direction, &state);
        cosine = half ? rf_most(rf_dot(normal, direction), 1e-6) / PI : 1 / (4 * PI);
        if (!rf_is_black(light))
            take(user, direction, rf_scale(light, 1 / (cosine * samples)));
    }
}
