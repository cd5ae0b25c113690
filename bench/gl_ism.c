/* gl_ism.c - ism on OpenGL: how long each stage of a frame takes, on the core path and, where the context has 4.3, on
   the compute path beside it, and how far the light is from ism.h's own. VPLs and points are chosen on the CPU; beside
   that, what the GPU takes to choose as many VPLs from the first source and to scatter an eighth of the points. Stages
   with uploads and reading back by wall time round glFinish; passes alone by the GPU's own, on software drivers round
   glFinish. */
#define _POSIX_C_SOURCE 200809L
#include "ism_scene.h"
#include "gl.h"
#include "../gl_backend/gl_ism.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FRAMES = 3, PATHS = 2, ROUNDS = 5 };

/* ms; choose and scatter are the GPU's; off: relative RMSE against the CPU */
typedef struct times { double draw, shade, maps, light, choose, scatter, off; } times;

typedef struct setup {
    const bn_options *options;
    const bn_scene   *scene;
    bn_gl            *gl;
    glbk_context      core;              /* the same GL without compute */
    int               paths;             /* 1: core alone */
    ism_desc          desc;
    ism_shading       shading;
    ism_maps         *maps;
    im_gl            *engines[PATHS];    /* core, compute */
    float            *light[PATHS], *cpu;
    double            choose, scatter;   /* ms */
    times             t[PATHS];
} setup;

static glbk_context *context_of(setup *u, int path) { return path ? &u->gl->gl : &u->core; }

static void close_setup(setup *u)
{
    for (int i = 0; i < PATHS; i++) {
        im_gl_close(u->engines[i]);
        free(u->light[i]);
    }
    free(u->cpu);
    ism_free(u->maps);
    glbk_free(&u->core);
}

static int open_setup(setup *u, uint32_t points)
{
    const size_t size = 3 * sizeof(float) * u->scene->gbuffer.width * u->scene->gbuffer.height;
    char error[EX_ERROR_SIZE];
    glbk_desc gl;
    memset(&gl, 0, sizeof gl);
    gl.get_proc_fn = ex_gl_get_proc;
    gl.user = u->gl->context;
    gl.core_only = 1;
    u->paths = u->gl->gl.compute ? 2 : 1;
    u->desc.vpl_count = 1024;
    u->desc.surfel_count = points;
    u->desc.tile_side = 64;
    u->desc.projection = ISM_PROJECTION_COSINE;
    u->desc.lazy_frames = 8;
    u->desc.splat_scale = 0.8f;
    u->desc.system.parallel_for = ex_pool_run;
    u->desc.system.user = u->options->pool;
    memset(&u->shading, 0, sizeof u->shading);
    u->shading.clamp = 1;
    u->shading.bias = 0.02f;
    u->shading.interleave = 4;
    u->cpu = malloc(size);
    if (!u->cpu || ism_create(&u->desc, &u->maps) != ISM_OK || glbk_init(&u->core, &gl) != GLBK_OK)
        return bn_failed(u->scene->name, "out of memory, or no OpenGL");
    for (int i = 0; i < u->paths; i++) {
        rd_job job = u->scene->job;
        job.gl = context_of(u, i);
        u->engines[i] = im_gl_open(&job, 1, error);
        u->light[i] = malloc(size);
        if (!u->engines[i] || !u->light[i])
            return bn_failed(u->scene->name, u->engines[i] ? "out of memory" : error);
    }
    return 0;
}

/* One frame; the first sends all points, the others an eighth. */
static int run_frame(setup *u, const ism_frame *frame)
{
    char error[EX_ERROR_SIZE];
    double lost, start = ex_seconds();
    ism_result result = ism_choose(u->maps, frame);
    u->choose = 1000 * (ex_seconds() - start);
    start = ex_seconds();
    if (result == ISM_OK)
        result = ism_scatter(u->maps, frame);
    u->scatter = 1000 * (ex_seconds() - start);
    if (result != ISM_OK)
        return bn_failed(u->scene->name, ism_result_text(result));
    for (int i = 0; i < u->paths; i++) {
        im_gl *gl = u->engines[i];
        start = ex_seconds();
        if (im_gl_view(gl, &u->scene->gbuffer, error) != 0 ||
            im_gl_draw(gl, 0, &u->desc, u->maps, frame, 0, error) != 0)
            return bn_failed(u->scene->name, error);
        u->t[i].draw = 1000 * (ex_seconds() - start);
        start = ex_seconds();
        if (im_gl_shade(gl, 0, &u->shading, u->light[i], &lost, error) != 0)
            return bn_failed(u->scene->name, error);
        u->t[i].shade = 1000 * (ex_seconds() - start);
    }
    return 0;
}

/* The passes of a frame alone, the paths by turns: the best of five and more. */
static int run_passes(setup *u)
{
    glbk_result result = GLBK_OK;
    double since;
    for (int k = 0; result == GLBK_OK && bn_gl_goes_on(&u->gl->gl, k, ROUNDS * u->paths, &since); k++) {
        int i = k % u->paths;
        glbk_context *gl = context_of(u, i);
        double ms[2];
        ex_gl_timer_start(&u->gl->timer);
        result = glbk_ism_draw(gl, im_gl_maps(u->engines[i], 0), 0);
        ms[0] = 1000 * ex_gl_timer_stop(&u->gl->timer);
        ex_gl_timer_start(&u->gl->timer);
        if (result == GLBK_OK)
            result = glbk_ism_shade(gl, im_gl_renderer(u->engines[i]), im_gl_gbuffer(u->engines[i]),
                                    im_gl_maps(u->engines[i], 0), &u->shading, 0);
        ms[1] = 1000 * ex_gl_timer_stop(&u->gl->timer);
        if (k < u->paths || ms[0] < u->t[i].maps)
            u->t[i].maps = ms[0];
        if (k < u->paths || ms[1] < u->t[i].light)
            u->t[i].light = ms[1];
    }
    return result == GLBK_OK ? 0 : bn_gl_failed(result);
}

/* A source's texels, for the GPU to choose from. */
static glbk_result upload_source(glbk_context *gl, const ism_source *s, glbk_texture *out)
{
    const size_t count = (size_t)s->width * s->height;
    const float *from[3] = { s->positions, s->normals, s->fluxes };
    const size_t strides[3] = { s->position_stride, s->normal_stride, s->flux_stride };
    float *texels = calloc(12 * count, sizeof *texels);
    glbk_texture_desc d;
    glbk_result result;
    memset(&d, 0, sizeof d);
    d.format = GLBK_FORMAT_RGBA32UI;
    d.width = s->width;
    d.height = s->height;
    d.layers = 3;
    d.data = texels;
    if (!texels)
        return GLBK_ERR_ALLOC;
    for (size_t k = 0; k < 3; k++)
        for (size_t i = 0; i < count; i++)
            memcpy(texels + 4 * (k * count + i), (const char *)from[k] + (strides[k] ? strides[k] : 12) * i, 12);
    result = glbk_texture_create(gl, &d, out);
    free(texels);
    return result;
}

/* VPLs and an eighth of the points by the GPU: the best of five and more. Maps have other VPLs afterwards. */
static int run_choice(setup *u, int path)
{
    const ism_source *s = &u->scene->rsms.sources[0];
    const glbk_ism_choice_desc of = { s->width, s->height, 1, s->scattered };
    glbk_context *gl = context_of(u, path);
    glbk_ism_maps *maps = im_gl_maps(u->engines[path], 0);
    const glbk_gbuffer *seen = im_gl_gbuffer(u->engines[path]);
    times *t = &u->t[path];
    glbk_ism_choice choice;
    glbk_ism_spread spread;
    glbk_texture texels;
    glbk_result result = GLBK_OK;
    double since;
    memset(&choice, 0, sizeof choice);
    memset(&spread, 0, sizeof spread);
    memset(&texels, 0, sizeof texels);
    result = upload_source(gl, s, &texels);
    if (result == GLBK_OK)
        result = glbk_ism_choice_create(gl, maps, &of, &choice);
    if (result == GLBK_OK)
        result = glbk_ism_spread_create(gl, maps, &spread);
    for (int k = 0; result == GLBK_OK && bn_gl_goes_on(&u->gl->gl, k, ROUNDS, &since); k++) {
        double ms[2];
        ex_gl_timer_start(&u->gl->timer);
        result = glbk_ism_choose(gl, &choice, maps, &texels, seen, (uint32_t)k);
        ms[0] = 1000 * ex_gl_timer_stop(&u->gl->timer);
        ex_gl_timer_start(&u->gl->timer);
        if (result == GLBK_OK)
            result = glbk_ism_scatter(gl, &spread, maps, seen, (uint32_t)k);
        ms[1] = 1000 * ex_gl_timer_stop(&u->gl->timer);
        if (!k || ms[0] < t->choose)
            t->choose = ms[0];
        if (!k || ms[1] < t->scatter)
            t->scatter = ms[1];
    }
    glbk_ism_choice_free(gl, &choice);
    glbk_ism_spread_free(gl, &spread);
    glbk_texture_free(gl, &texels);
    return result == GLBK_OK ? 0 : bn_gl_failed(result);
}

/* Relative RMSE of the GL's light against ism.h's maps and shading of the same VPLs and points. */
static int compare_with_cpu(setup *u, const ism_frame *frame)
{
    const size_t count = 3 * (size_t)u->scene->gbuffer.width * u->scene->gbuffer.height;
    ism_result result = ism_build(u->maps, frame);
    if (result == ISM_OK)
        result = ism_shade(u->maps, &u->scene->view, &u->shading, u->cpu, NULL);
    for (int k = 0; k < u->paths && result == ISM_OK; k++) {
        double square = 0, sum = 0;
        for (size_t i = 0; i < count; i++) {
            double d = (double)u->light[k][i] - (double)u->cpu[i];
            square += d * d;
            sum += (double)u->cpu[i];
        }
        u->t[k].off = sqrt(square / (double)count) / (sum / (double)count);
    }
    return result == ISM_OK ? 0 : bn_failed(u->scene->name, ism_result_text(result));
}

static void write_row(setup *u, int path)
{
    const bn_scene *s = u->scene;
    const times *t = &u->t[path];
    bn_begin(u->options, "gl_ism", u->options->threads, "none");
    bn_text("gl_renderer", u->gl->gl.renderer);
    bn_text("path", path ? "compute" : "core");
    bn_text("clock", u->gl->timer.by_query ? "query" : "finish");
    bn_text("scene", s->name);
    bn_integer("triangles", s->mesh.mesh.index_count / 3);
    bn_integer("width", s->gbuffer.width);
    bn_integer("height", s->gbuffer.height);
    bn_integer("vpl_count", u->desc.vpl_count);
    bn_integer("surfel_count", u->desc.surfel_count);
    bn_integer("interleave", u->shading.interleave);
    bn_number("rsm_ms", s->rsm_ms);
    bn_number("choose_ms", u->choose);
    bn_number("scatter_ms", u->scatter);
    bn_number("draw_ms", t->draw);
    bn_number("shade_ms", t->shade);
    bn_number("frame_ms", u->choose + u->scatter + t->draw + t->shade);
    bn_number("maps_ms", t->maps);
    bn_number("light_ms", t->light);
    bn_number("gpu_choose_ms", t->choose);
    bn_number("gpu_scatter_ms", t->scatter);
    bn_number("rmse_vs_cpu", t->off);
    bn_end(u->options);
}

static int measure(const bn_options *options, const bn_scene *s, bn_gl *gl, uint32_t points)
{
    ism_frame frame = { &s->mesh.mesh, s->rsms.sources, s->rsms.count, &s->view, 0 };
    setup u;
    int result;
    memset(&u, 0, sizeof u);
    u.options = options;
    u.scene = s;
    u.gl = gl;
    result = open_setup(&u, points);
    for (frame.index = 0; frame.index < FRAMES && result == 0; frame.index++)
        result = run_frame(&u, &frame);
    frame.index--;
    if (result == 0)
        result = run_passes(&u);
    if (result == 0)
        result = compare_with_cpu(&u, &frame);
    for (int i = 0; i < u.paths && result == 0; i++)
        result = run_choice(&u, i);
    for (int i = 0; i < u.paths && result == 0; i++)
        write_row(&u, i);
    close_setup(&u);
    return result;
}

static int measure_scene(const bn_options *options, bn_gl *gl, const char *scene, uint32_t rsm)
{
    uint32_t width = options->full ? 1600 : 320, height = options->full ? 800 : 160;
    bn_scene s;
    int result;
    if (bn_ism_open(&s, options, scene, width, height, rsm, 16) != 0)
        return -1;
    result = measure(options, &s, gl, options->full ? 8192 : 2048);
    bn_ism_close(&s);
    return result;
}

int bn_gl_ism(const bn_options *options)
{
    bn_gl g;
    int result = bn_gl_open(&g, 0);
    if (result == 0 && options->model)
        result = measure_scene(options, &g, options->model, 128);
    else if (result == 0 && (result = measure_scene(options, &g, "builtin:cornell", 128)) == 0)
        result = measure_scene(options, &g, "builtin:atrium", 128);
    bn_gl_close(&g);
    return result;
}
