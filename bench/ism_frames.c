/* ism_frames.c - a frame of ism.h by stage, by the processor's time on all threads: the first one, the next of a scene
   that stays, and the next since one object moved a centimetre. */
#define _POSIX_C_SOURCE 200809L
#include "ism_scene.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { W = 320, H = 160, VPLS = 1024, SURFELS = 8192, RSM = 512, LIGHT_POINTS = 64, TURNS = 3 };

/* Milliseconds of the processor. */
typedef struct stages { double mesh, rsm, choose, scatter, draw, shade; } stages;

static double processor_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static double since(double *start)
{
    double now = processor_ms(), ms = now - *start;
    *start = now;
    return ms;
}

/* ism_build scatters what ism_scatter has scattered once more: what it takes alone is the difference. */
static int run_frame(bn_scene *s, const bn_options *options, ism_maps *maps, uint32_t index, float *out, stages *ms)
{
    char error[EX_ERROR_SIZE];
    double start = processor_ms();
    ism_shading shading = { 0 };
    ism_frame frame;
    ism_result result;
    im_mesh_free(&s->mesh);
    if (im_mesh_build(&s->mesh, &s->job, error) != 0)
        return bn_failed(s->name, error);
    ms->mesh = since(&start);
    if (bn_ism_light(s, options, RSM, LIGHT_POINTS) != 0)
        return -1;
    ms->rsm = since(&start);
    frame = bn_ism_frame(s);
    frame.index = index;
    shading.interleave = 4;
    result = ism_choose(maps, &frame);
    ms->choose = since(&start);
    if (result == ISM_OK)
        result = ism_build(maps, &frame);
    ms->draw = since(&start);
    if (result == ISM_OK)
        result = ism_shade(maps, &s->view, &shading, out, NULL);
    ms->shade = since(&start);
    if (result == ISM_OK)
        result = ism_scatter(maps, &frame);
    ms->scatter = since(&start);
    ms->draw -= ms->scatter;
    return result == ISM_OK ? 0 : bn_failed(s->name, ism_result_text(result));
}

static double whole(const stages *s) { return s->mesh + s->rsm + s->choose + s->scatter + s->draw + s->shade; }

static void report(const bn_options *options, const bn_scene *s, const char *what, const stages *ms,
                   const stages *first)
{
    bn_begin(options, "ism_frames", options->threads, bn_ism_simd());
    bn_text("scene", s->name);
    bn_text("frame", what);
    bn_integer("triangles", s->mesh.mesh.index_count / 3);
    bn_integer("objects", s->scene.object_count);
    bn_integer("vpl_count", VPLS);
    bn_integer("surfel_count", SURFELS);
    bn_number("mesh_ms", ms->mesh);
    bn_number("rsm_ms", ms->rsm);
    bn_number("choose_ms", ms->choose);
    bn_number("scatter_ms", ms->scatter);
    bn_number("draw_ms", ms->draw);
    bn_number("shade_ms", ms->shade);
    bn_number("frame_ms", whole(ms));
    bn_number("over_first", whole(ms) / whole(first));
    bn_end(options);
}

int bn_ism_frames(const bn_options *options)
{
    static const char *const names[3] = { "first", "nothing moved", "one object moved" };
    ism_desc desc = bn_ism_desc(options, VPLS, SURFELS);
    float *out = malloc(3 * W * H * sizeof *out);
    const char *scene = options->model ? options->model : "builtin:atrium";
    ism_maps *maps = NULL;
    uint32_t index = 0;
    stages first, ms;
    bn_scene s;
    int result = -1;
    if (!out || ism_create(&desc, &maps) != ISM_OK)
        bn_failed("ism_frames", "out of memory");
    else if (bn_ism_open(&s, options, scene, W, H, RSM, LIGHT_POINTS) == 0) {
        memset(&first, 0, sizeof first);
        memset(&ms, 0, sizeof ms);
        for (int kind = 0; kind < 3; kind++) {
            for (int turn = 0; turn < (kind ? TURNS : 1); turn++) {
                stages now;
                if (kind == 2)
                    s.scene.objects[s.scene.object_count / 2].transform[12] += 0.01f;
                result = run_frame(&s, options, maps, index++, out, &now);
                if (result != 0)
                    break;
                if (turn == 0 || whole(&now) < whole(&ms))
                    ms = now;
            }
            if (result != 0)
                break;
            if (kind == 0)
                first = ms;
            report(options, &s, names[kind], &ms, &first);
        }
        bn_ism_close(&s);
    }
    ism_free(maps);
    free(out);
    return result;
}
