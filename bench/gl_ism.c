/* gl_ism.c - ism on OpenGL: how long each stage of a frame takes, and how far the light is from ism.h's own. VPLs and
   points are chosen on the CPU. Wall time round glFinish: timer queries of software drivers are wrong. */
#define _POSIX_C_SOURCE 200809L
#include "ism_scene.h"
#include "gl.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FRAMES = 3 };

typedef struct times { double choose, scatter, draw, shade; } times;

/* One frame; the first sends all points, the others an eighth. */
static int run_frame(const bn_options *options, const bn_scene *s, im_gl *gl, const ism_desc *d, ism_maps *maps,
                     const ism_frame *frame, const ism_shading *shading, float *light, times *out)
{
    char error[EX_ERROR_SIZE];
    double lost, start = ex_seconds();
    ism_result result = ism_choose(maps, frame);
    (void)options;
    out->choose = 1000 * (ex_seconds() - start);
    start = ex_seconds();
    if (result == ISM_OK)
        result = ism_scatter(maps, frame);
    out->scatter = 1000 * (ex_seconds() - start);
    if (result != ISM_OK)
        return bn_failed(s->name, ism_result_text(result));
    start = ex_seconds();
    if (im_gl_view(gl, &s->view, error) != 0 || im_gl_draw(gl, 0, d, maps, frame, 0, error) != 0)
        return bn_failed(s->name, error);
    out->draw = 1000 * (ex_seconds() - start);
    start = ex_seconds();
    if (im_gl_shade(gl, 0, shading, light, &lost, error) != 0)
        return bn_failed(s->name, error);
    out->shade = 1000 * (ex_seconds() - start);
    return 0;
}

/* Relative RMSE of the GL's light against ism.h's maps and shading of the same VPLs and points. */
static int compare_with_cpu(const bn_scene *s, ism_maps *maps, const ism_frame *frame, const ism_shading *shading,
                            const float *light, size_t count, double *error)
{
    float *cpu = malloc(count * sizeof *cpu);
    double square = 0, sum = 0;
    ism_result result = cpu ? ism_build(maps, frame) : ISM_ERR_ALLOC;
    if (result == ISM_OK)
        result = ism_shade(maps, &s->view, shading, cpu, NULL);
    for (size_t i = 0; i < count && result == ISM_OK; i++) {
        square += ((double)light[i] - (double)cpu[i]) * ((double)light[i] - (double)cpu[i]);
        sum += (double)cpu[i];
    }
    free(cpu);
    *error = sqrt(square / (double)count) / (sum / (double)count);
    return result == ISM_OK ? 0 : bn_failed(s->name, ism_result_text(result));
}

static int measure(const bn_options *options, const bn_scene *s, glbk_context *gl, uint32_t points)
{
    size_t count = 3 * (size_t)s->gbuffer.width * s->gbuffer.height;
    char error[EX_ERROR_SIZE];
    ism_shading shading = ism_shading_default();
    rd_job job = s->job;
    ism_frame frame = { &s->mesh.mesh, s->rsms.sources, s->rsms.count, &s->view, 0 };
    ism_desc d;
    ism_maps *maps = NULL;
    im_gl *engine;
    times t = { 0, 0, 0, 0 };
    double off = HUGE_VAL;
    float *light = malloc(count * sizeof *light);
    int result;
    memset(&d, 0, sizeof d);
    d.vpl_count = 1024;
    d.points = points;
    d.tile_size = 64;
    d.projection = ISM_PROJECTION_COSINE;
    d.lazy = 8;
    d.splat_scale = 1.0f;
    d.parallel_for = ex_pool_run;
    d.parallel_user = options->pool;
    shading.pattern = 4;
    job.gl = gl;
    engine = im_gl_open(&job, 1, error);
    result = !light || !engine ? bn_failed(s->name, light ? error : "out of memory") : 0;
    if (result == 0 && ism_create(&d, &maps) != ISM_OK)
        result = bn_failed(s->name, "out of memory");
    for (frame.index = 0; frame.index < FRAMES && result == 0; frame.index++)
        result = run_frame(options, s, engine, &d, maps, &frame, &shading, light, &t);
    frame.index--;
    if (result == 0)
        result = compare_with_cpu(s, maps, &frame, &shading, light, count, &off);
    if (result == 0) {
        bn_begin(options, "gl_ism", options->threads, "none");
        bn_text("gl_renderer", gl->renderer);
        bn_text("scene", s->name);
        bn_integer("triangles", s->mesh.mesh.index_count / 3);
        bn_integer("width", s->gbuffer.width);
        bn_integer("height", s->gbuffer.height);
        bn_integer("vpls", d.vpl_count);
        bn_integer("points", d.points);
        bn_integer("pattern", shading.pattern);
        bn_number("rsm_ms", s->rsm_ms);
        bn_number("choose_ms", t.choose);
        bn_number("scatter_ms", t.scatter);
        bn_number("draw_ms", t.draw);
        bn_number("shade_ms", t.shade);
        bn_number("frame_ms", t.choose + t.scatter + t.draw + t.shade);
        bn_number("rmse_vs_cpu", off);
        bn_end(options);
    }
    im_gl_close(engine);
    ism_free(maps);
    free(light);
    return result;
}

static int measure_scene(const bn_options *options, glbk_context *gl, const char *scene, uint32_t rsm)
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
        result = measure_scene(options, &g.gl, options->model, 128);
    else if (result == 0 && (result = measure_scene(options, &g.gl, "builtin:cornell", 128)) == 0)
        result = measure_scene(options, &g.gl, "builtin:atrium", 128);
    bn_gl_close(&g);
    return result;
}
