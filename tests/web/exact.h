/* exact.h - what a page would show if its light were exact: the path tracer of `render` has the same scene, camera and
   lights, and its picture goes through the page's own backdrop, exposure and dots. For native.c and native_scene.c,
   linked with the parts of `render` that the path tracer is made of. */
#ifndef TESTS_WEB_EXACT_H
#define TESTS_WEB_EXACT_H

#include "../../examples/render/technique.h"
#include "../../web/stage.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EXACT_AA = 4 };              /* EXACT_AA * EXACT_AA points of a pixel */

typedef struct exact {
    ex_scene    scene;              /* the page's arrays, with camera, lights and sky of its own */
    ex_gbuffer  seen;
    ex_image    light;
    rd_emitter *emitters;
    rd_settings settings;
    rd_job      job;
    void       *state;
} exact;

/* The camera that pg_stage_look has set, without its shift within the pixel. */
static void exact_camera(const pg_camera *from, ex_camera *out)
{
    const float *n = from->unclip;
    memset(out, 0, sizeof *out);
    memcpy(out->eye, from->eye, sizeof out->eye);
    memcpy(out->target, n + 12, sizeof out->target);
    out->up[1] = 1;
    out->fovy = 2 * atanf(sqrtf(n[4] * n[4] + n[5] * n[5] + n[6] * n[6]));
}

static int exact_setting(exact *e, const char *key, const char *value, char *error)
{
    char pair[64];
    snprintf(pair, sizeof pair, "%s=%s", key, value);
    return rd_settings_add(&e->settings, pair, error);
}

static int exact_open(exact *e, const pg_stage *stage, const pg_model *model, const pg_lights *lights, char *error)
{
    e->scene = model->scene;
    e->scene.lights = (ex_light *)(uintptr_t)lights->lights;
    e->scene.light_count = lights->count;
    e->scene.sky = lights->sky;
    e->scene.has_camera = 1;
    e->scene.animated = 0;
    exact_camera(&stage->camera, &e->scene.camera);
    e->settings.common = rd_common_keys;
    e->settings.own = rd_reference.keys;
    if (exact_setting(e, "bounces", lights->bounces ? "1" : "0", error) != 0 ||
        exact_setting(e, "only", lights->bounces ? "all" : "direct", error) != 0 ||
        exact_setting(e, "materials", lights->full ? "full" : "diffuse", error) != 0 ||
        ex_gbuffer_render(&e->seen, &e->scene, stage->width, stage->height, EXACT_AA, 0, error) != 0)
        return -1;
    if (rd_emitters_build(&e->scene, &e->emitters, &e->job.emitter_count) != 0 ||
        ex_image_alloc(&e->light, e->seen.width, e->seen.height) != 0)
        return pg_failed("the path tracer", GLBK_ERR_ALLOC, error);
    e->job.scene = &e->scene;
    e->job.gbuffer = &e->seen;
    e->job.emitters = e->emitters;
    memcpy(e->job.center, model->center, sizeof e->job.center);
    e->job.radius = model->radius;
    e->job.settings = &e->settings;
    e->job.aa = EXACT_AA;
    e->job.frames = e->job.seed = 1;
    e->job.pool = ex_pool_create(0);
    e->job.threads = e->job.pool ? ex_pool_threads(e->job.pool) : 1;
    return e->job.pool ? rd_reference.open(&e->state, &e->job, error) : pg_failed("threads", GLBK_ERR_ALLOC, error);
}

static void exact_close(exact *e)
{
    rd_reference.close(e->state);
    ex_pool_free(e->job.pool);
    ex_gbuffer_free(&e->seen);
    ex_image_free(&e->light);
    free(e->emitters);
}

/* What lies behind the scene at a point of the window, -1..1, as stage.c's shader has it. */
static void exact_behind(const pg_stage *stage, float x, float y, float out[3])
{
    const float *n = stage->camera.unclip;
    float d[3], length = 0;
    for (int k = 0; k < 3; k++) {
        d[k] = n[k] * x + n[4 + k] * y + n[12 + k] - stage->camera.eye[k];
        length += d[k] * d[k];
    }
    for (int k = 0; k < 3; k++) out[k] = stage->backdrop[k] * (0.9f + 0.25f * d[1] / sqrtf(length));
}

/* How far the ground has become the backdrop at a point of it. */
static float exact_end(const pg_stage *stage, const float position[3])
{
    float d = 0, t;
    for (int k = 0; k < 3; k++) d += (position[k] - stage->ground[k]) * (position[k] - stage->ground[k]);
    t = fminf(fmaxf((sqrtf(d) / stage->ground[3] - 0.35f) / 0.65f, 0), 1);
    return t * t * (3 - 2 * t);
}

/* Means of each pixel's points, rows from below, r, g, b, a. */
static void exact_mix(const exact *e, const pg_stage *stage, float *rgba)
{
    const uint32_t wide = e->seen.width, high = e->seen.height;
    for (uint32_t y = 0; y < high; y++)
        for (uint32_t x = 0; x < wide; x++) {
            const size_t i = (size_t)y * wide + x;
            const ex_pixel *p = &e->seen.pixels[i];
            float *to = rgba + 4 * ((size_t)(stage->height - 1 - y / EXACT_AA) * stage->width + x / EXACT_AA);
            float behind[3], end = 1;
            exact_behind(stage, (2 * (float)x + 1) / (float)wide - 1, 1 - (2 * (float)y + 1) / (float)high, behind);
            if (p->object != UINT32_MAX)
                end = e->scene.objects[p->object].receiver_only ? exact_end(stage, p->position) : 0;
            for (size_t k = 0; k < 3; k++)
                to[k] += (e->light.rgb[3 * i + k] * (1 - end) + behind[k] * end) / (EXACT_AA * EXACT_AA);
            to[3] = 1;
        }
}

/* Puts the exact picture, of so many paths a pixel, in the place of the mean that the stage has, and shows it. The
   frame before has set exposure and backdrop. */
static int exact_show(pg_stage *stage, const pg_model *model, const pg_view *view, const pg_lights *lights,
                      uint32_t paths, char *error)
{
    const glbk_box all = { 0, 0, 0, 0, stage->width, stage->height, 0 };
    float *rgba = calloc(4 * (size_t)stage->width * stage->height, sizeof *rgba);
    glbk_result result = GLBK_OK;
    exact e;
    int failed;
    if (!rgba) return pg_failed("the path tracer", GLBK_ERR_ALLOC, error);
    memset(&e, 0, sizeof e);
    stage->no_mean = 1;
    pg_stage_look(stage, model, view, 0);
    failed = exact_open(&e, stage, model, lights, error) != 0;
    e.job.samples = (paths + EXACT_AA * EXACT_AA - 1) / (EXACT_AA * EXACT_AA);
    failed = failed || rd_reference.frame(e.state, &e.job, &e.light, error) != 0;
    if (!failed) {
        exact_mix(&e, stage, rgba);
        result = pg_stage_draw(stage, model, NULL, 0);          /* what hides the dots of handles */
        if (result == GLBK_OK) result = glbk_texture_update(stage->gl, &stage->sum[stage->now], &all, rgba);
        if (result == GLBK_OK) result = pg_stage_show(stage);
    }
    exact_close(&e);
    free(rgba);
    if (failed) return -1;
    return result == GLBK_OK ? 0 : pg_failed("the exact picture", result, error);
}

#endif
