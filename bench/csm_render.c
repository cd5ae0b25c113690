/* csm_render.c - pictures by `render --technique csm` beside those of the reference: the programs themselves are run,
   as users would. 4096 samples a pixel in both, maps of 128 x 128 directions with 256 x 256 pixels. */
#define _POSIX_C_SOURCE 200809L
#include "bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct files { char folder[64], reference[96], picture[96], json[96]; } files;

typedef struct difference { double rmse, inside; size_t lit, edges; } difference;

static double relative(double square, double sum, size_t pixels)
{
    return sqrt(square * 3 * (double)pixels) / sum;         /* sqrt(square / n) / (sum / n), n = 3 pixels */
}

/* rmse: the relative_rmse of `compare`. Under a sky nothing that is seen is black: a pixel that is so in one picture
   alone has an edge through its middle, which rasteriser and ray decide differently (the far edge of the bunny's
   floor); inside leaves out such pixels, which are counted. */
static int compare(const char *a_path, const char *b_path, difference *d)
{
    ex_image a, b;
    char message[EX_ERROR_SIZE];
    double square[2] = { 0, 0 }, sum[2] = { 0, 0 };         /* of all, of edges */
    memset(d, 0, sizeof *d);
    if (ex_image_read_pfm(&a, a_path, message) != 0)
        return bn_failed(a_path, message);
    if (ex_image_read_pfm(&b, b_path, message) != 0) {
        ex_image_free(&a);
        return bn_failed(b_path, message);
    }
    for (size_t i = 0; i < (size_t)a.width * a.height; i++) {
        const float *p = a.rgb + 3 * i, *q = b.rgb + 3 * i;
        int p_lit = p[0] + p[1] + p[2] > 0, q_lit = q[0] + q[1] + q[2] > 0, edge = p_lit != q_lit;
        d->lit += p_lit || q_lit;
        d->edges += (size_t)edge;
        for (int k = 0; k < 3; k++) {
            double e = (double)p[k] - (double)q[k];
            for (int of = 0; of <= edge; of++) {
                square[of] += e * e;
                sum[of] += (double)q[k];
            }
        }
    }
    d->rmse = relative(square[0], sum[0], d->lit);
    d->inside = relative(square[0] - square[1], sum[0] - sum[1], d->lit - d->edges);
    ex_image_free(&a);
    ex_image_free(&b);
    return 0;
}

static int measure(const bn_options *options, const char *program, const files *f, const char *scene, const char *sky,
                   const char *size, const char *filter)
{
    char threads[16], set_filter[32];
    const char *slash = strrchr(sky, '/');
    double noise;
    difference d;
    snprintf(threads, sizeof threads, "%d", options->threads);
    snprintf(set_filter, sizeof set_filter, "filter=%s", filter);
    {
        const char *const reference[] = { program, "--technique", "reference", "--scene", scene, "--env", sky, "--size",
            size, "--samples", "4096", "--threads", threads, "--out", f->reference, "--json", f->json, NULL };
        const char *const csm[] = { program, "--technique", "csm", "--scene", scene, "--env", sky, "--size",
            size, "--samples", "4096", "--threads", threads, "--out", f->picture, "--json", f->json,
            "--set", "side=128", "--set", "map_side=256", "--set", set_filter, NULL };
        if (bn_start(program, reference, NULL) != 0)
            return bn_failed(program, "the reference failed");
        noise = bn_read_number(f->json, "noise");
        if (bn_start(program, csm, NULL) != 0)
            return bn_failed(program, "csm failed");
    }
    if (compare(f->picture, f->reference, &d) != 0)
        return -1;
    bn_begin(options, "csm_render", options->threads, bn_simd());
    bn_text("model", scene);
    bn_text("env", slash ? slash + 1 : sky);
    bn_text("size", size);
    bn_integer("samples", 4096);
    bn_text("filter", filter);
    bn_integer("side", 128);
    bn_integer("map_side", 256);
    bn_number("msamples_s", (double)(d.lit - d.edges) * 4096 / bn_read_number(f->json, "frame_ms") * 1e-3);
    bn_number("rmse_vs_reference", d.rmse);
    bn_number("inside_rmse", d.inside);
    bn_integer("edge_pixels", d.edges);
    bn_number("reference_noise", noise);
    bn_number("precompute_ms", bn_read_number(f->json, "precompute_ms"));
    bn_number("frame_ms", bn_read_number(f->json, "frame_ms"));
    bn_number("memory_bytes", bn_read_number(f->json, "memory_bytes"));
    bn_end(options);
    return 0;
}

static int make_files(files *f)
{
    snprintf(f->folder, sizeof f->folder, "/tmp/dapple-bench-XXXXXX");
    if (!mkdtemp(f->folder))
        return bn_failed("/tmp", "no room for temporary files");
    snprintf(f->reference, sizeof f->reference, "%s/reference.pfm", f->folder);
    snprintf(f->picture, sizeof f->picture, "%s/csm.pfm", f->folder);
    snprintf(f->json, sizeof f->json, "%s/figures.json", f->folder);
    return 0;
}

static void remove_files(const files *f)
{
    remove(f->reference);
    remove(f->picture);
    remove(f->json);
    rmdir(f->folder);
}

int bn_csm_render(const bn_options *options)
{
    char program[1024], path[2][1024], sky_path[1024];
    const char *skies[2] = { "builtin:sky", NULL }, *scenes[3];
    const char *size = options->full ? "640x360" : "128x96";
    size_t count = 0;
    files f;
    int result = 0;
    bn_program(options, "render", program);
    if (!bn_rays_version())
        return bn_failed("csm_render", "the reference needs Embree: apt-get install libembree-dev");
    for (size_t i = 0; i < 2 && !options->model; i++)
        if (bn_asset(options, i ? "dragon.glb" : "bunny.glb", NULL, path[count])) {
            scenes[count] = path[count];
            count++;
        }
    scenes[count++] = options->model ? options->model : "builtin:plant";
    skies[1] = bn_asset(options, "venice_sunset_1k.hdr", "sunset.hdr", sky_path);
    if (make_files(&f) != 0)
        return -1;
    for (size_t i = 0; i < count && result == 0; i++)
        for (int sky = 0; sky < 2 && skies[sky] && result == 0; sky++)
            result = measure(options, program, &f, scenes[i], skies[sky], size,
                             options->full ? "pcf" : "roulette");
    remove_files(&f);
    return result;
}
