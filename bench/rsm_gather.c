/* rsm_gather.c - bounced light by `render --technique rsm` under one spot light: time of full, interpolated and
   denoised pictures of 512 x 512, their difference from the full one, and the error of small pictures against the
   reference without indirect visibility (128 x 128, indirect light alone); then what is slower and nearer to it. The
   programs themselves are run, as users would. */
#define _POSIX_C_SOURCE 200809L
#include "bench.h"
#include "gl.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

typedef struct run {
    const bn_options *options;
    char              program[1024], folder[64], common[2048], output[4096];
    double            noise;                    /* of the reference */
} run;

/* Runs render; its line of JSON into output. */
static int render(run *r, const char *technique, const char *picture, const char *more)
{
    char command[4096];
    FILE *pipe;
    size_t length;
    snprintf(command, sizeof command, "'%s' --technique %s %s %s --threads %d --out %s/%s.pfm --json -", r->program,
             technique, r->common, more, r->options->threads, r->folder, picture);
    pipe = popen(command, "r");
    if (!pipe)
        return bn_failed(r->program, "cannot be run");
    length = fread(r->output, 1, sizeof r->output - 1, pipe);
    r->output[length] = 0;
    return pclose(pipe) == 0 ? 0 : bn_failed(command, "failed");
}

static double number(const run *r, const char *name)
{
    char key[64];
    const char *at;
    snprintf(key, sizeof key, "\"%s\": ", name);
    at = strstr(r->output, key);
    return at ? strtod(at + strlen(key), NULL) : HUGE_VAL;
}

/* relative_rmse of `compare`: pixels that are 0 in both count in neither sum. */
static double compare(const run *r, const char *a_name, const char *b_name)
{
    char path[128], message[EX_ERROR_SIZE];
    ex_image a, b;
    double square = 0, sum = 0, count = 0;
    snprintf(path, sizeof path, "%s/%s.pfm", r->folder, a_name);
    if (ex_image_read_pfm(&a, path, message) != 0)
        return HUGE_VAL;
    snprintf(path, sizeof path, "%s/%s.pfm", r->folder, b_name);
    if (ex_image_read_pfm(&b, path, message) != 0) {
        ex_image_free(&a);
        return HUGE_VAL;
    }
    for (size_t i = 0; i < 3 * (size_t)a.width * a.height; i += 3) {
        int lit = 0;
        for (size_t k = i; k < i + 3; k++) {
            double d = (double)a.rgb[k] - (double)b.rgb[k];
            square += d * d;
            sum += (double)b.rgb[k];
            lit |= fabsf(a.rgb[k]) > 0 || fabsf(b.rgb[k]) > 0;
        }
        count += 3 * lit;
    }
    ex_image_free(&a);
    ex_image_free(&b);
    return sum > 0 ? sqrt(square * count) / sum : HUGE_VAL;
}

/* A spot for a scene: over the Cornell box's floor; elsewhere a lamp beside the camera. */
static int find_light(const char *scene, char *light, size_t size)
{
    char error[EX_ERROR_SIZE];
    ex_scene s;
    float d[3], length = 0;
    if (strcmp(scene, "builtin:cornell") == 0) {
        snprintf(light, size, "spot:0.278,0.54,0.1,0,-0.8,0.6,70,2");
        return 0;
    }
    if ((strncmp(scene, "builtin:", 8) == 0 ? ex_scene_builtin(&s, scene + 8, 0, error)
                                            : ex_scene_load(&s, scene, error)) != 0)
        return bn_failed(scene, error);
    if (!s.has_camera)
        ex_scene_default_camera(&s, 512, 512);
    for (int k = 0; k < 3; k++) {
        d[k] = s.camera.target[k] - s.camera.eye[k];
        length += d[k] * d[k];
    }
    length = sqrtf(length);
    snprintf(light, size, "spot:%g,%g,%g,%g,%g,%g,70", (double)(s.camera.eye[0] - 0.1f * d[2]), (double)s.camera.eye[1],
             (double)(s.camera.eye[2] + 0.1f * d[0]), (double)(d[0] / length), (double)(d[1] / length),
             (double)(d[2] / length));
    ex_scene_free(&s);
    return 0;
}

typedef struct row { const char *backend, *path, *mode, *settings; uint32_t samples; int small; } row;

/* Three frames, since the first one compiles shaders and touches memory; the middle time and the last picture count.
   small: times of 128 x 128 too, and one frame. */
static int measure(run *r, const char *scene, const char *light, const row *w)
{
    const char *slash = strrchr(scene, '/');
    char more[512], settings[128];
    double error = HUGE_VAL, other = HUGE_VAL, times[2], fraction;
    int full = strcmp(w->mode, "full") == 0, side = w->small ? 128 : 512;
    snprintf(settings, sizeof settings, "%s%s", w->settings,
             !w->path[0] ? "" : strcmp(w->path, "core") == 0 ? " --set compute=0" : " --set compute=1");
    snprintf(more, sizeof more, "--backend %s --frames %d --size %dx%d --samples %u --set mode=%s %s", w->backend,
             w->small ? 1 : 3, side, side, (unsigned)w->samples, w->mode, settings);
    if (render(r, "rsm", w->small ? "small" : full ? "full" : "some", more) != 0)
        return -1;
    times[0] = number(r, "frame_ms");
    times[1] = number(r, "gather_ms");
    fraction = number(r, "evaluated_fraction");
    if (!w->small) {
        other = full ? 0 : compare(r, "some", "full");
        if (strcmp(w->mode, "denoised") == 0) {          /* of one frame: the second and third have other samples */
            snprintf(more, sizeof more, "--backend %s --seed 2 --size 512x512 --samples %u --set mode=denoised %s",
                     w->backend, (unsigned)w->samples, settings);
            if (render(r, "rsm", "some", more) != 0)
                return -1;
            other = compare(r, "some", "full");
        }
        snprintf(more, sizeof more, "--backend %s --frames 3 --size 128x128 --samples %u --set mode=%s %s", w->backend,
                 (unsigned)w->samples, w->mode, w->settings);
        if (bn_rays_version() && render(r, "rsm", "small", more) != 0)
            return -1;
    }
    if (bn_rays_version())
        error = compare(r, "small", "reference");
    bn_begin(r->options, "rsm_gather", r->options->threads, bn_simd());
    bn_text("scene", slash ? slash + 1 : scene);
    bn_text("light", light);
    bn_text("backend", w->backend);
    bn_text("path", w->path);
    bn_text("mode", w->mode);
    bn_text("settings", w->settings);
    bn_integer("width", (uint64_t)side);
    bn_integer("height", (uint64_t)side);
    bn_integer("samples", w->samples);
    bn_number("frame_ms", times[0]);
    bn_number("gather_ms", times[1]);
    bn_number("evaluated_fraction", fraction);
    bn_number("rmse_vs_full", other);
    bn_number("rmse_vs_reference", error);
    bn_number("reference_noise", r->noise);
    bn_end(r->options);
    return 0;
}

/* Whether there is such a path: "", "core" or "compute". */
static int has_path(const char *path)
{
    bn_gl g;
    int has;
    if (!*path)
        return 1;
    if (bn_gl_open(&g, 0) != 0)
        return 0;
    has = strcmp(path, "core") == 0 || g.gl.compute;
    bn_gl_close(&g);
    return has;
}

static int measure_scene(run *r, const char *scene)
{
    static const row rows[] = {
        { "cpu", "", "full", "", 400, 0 },
        { "cpu", "", "interpolated", "", 400, 0 },
        { "cpu", "", "denoised", "", 400, 0 },
        { "cpu", "", "full", "--set pattern=equation3", 400, 0 },
        { "cpu", "", "full", "", 224, 0 },                   /* the paper's work */
        { "cpu", "", "interpolated", "", 224, 0 },
        { "cpu", "", "full", "--set pattern=mixed", 400, 1 },
        { "cpu", "", "full", "--set pattern=mixed --set side=2048", 400, 1 },
        { "cpu", "", "full", "--set pattern=mixed --set near_field=0", 400, 1 },
        { "cpu", "", "full", "--set side=512", 0, 1 },
        { "cpu", "", "full", "--set side=512 --set near_field=0", 0, 1 },
        { "gl", "core", "full", "", 400, 0 },
        { "gl", "compute", "full", "", 400, 0 },
        { "gl", "core", "interpolated", "", 400, 0 },
        { "gl", "compute", "interpolated", "", 400, 0 },
        { "gl", "core", "denoised", "", 400, 0 },
        { "gl", "compute", "denoised", "", 400, 0 },
    };
    char light[256], more[128];
    int result = 0;
    if (find_light(scene, light, sizeof light) != 0)
        return -1;
    snprintf(r->common, sizeof r->common, "--scene '%s' --light %s --set emitters=0 --set only=indirect", scene, light);
    snprintf(more, sizeof more, "--size 128x128 --samples %d --set bounces=1 --set indirect_visibility=0",
             r->options->full ? 32768 : 8192);
    if (bn_rays_version() && render(r, "reference", "reference", more) != 0)
        return -1;
    r->noise = bn_rays_version() ? number(r, "noise") : HUGE_VAL;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0] && result == 0; i++)
        if (has_path(rows[i].path))
            result = measure(r, scene, light, &rows[i]);
    return result;
}

int bn_rsm_gather(const bn_options *options)
{
    static const char *const names[] = { "full.pfm", "some.pfm", "small.pfm", "reference.pfm" };
    const char *slash = strrchr(options->program, '/');
    const char *scenes[3] = { "builtin:cornell", "builtin:atrium", NULL };
    char kitchen[1024], path[128];
    run r;
    int result = 0;
    memset(&r, 0, sizeof r);
    r.options = options;
    snprintf(r.program, sizeof r.program, "%.*srender", slash ? (int)(slash + 1 - options->program) : 0,
             options->program);
    snprintf(r.folder, sizeof r.folder, "/tmp/dapple-bench-XXXXXX");
    if (!mkdtemp(r.folder))
        return bn_failed("/tmp", "no room for temporary files");
    if (options->model) {
        scenes[0] = options->model;
        scenes[1] = NULL;
    } else {
        scenes[2] = bn_asset(options, "kitchen.glb", NULL, kitchen);
    }
    for (size_t i = 0; i < 3 && scenes[i] && result == 0; i++)
        result = measure_scene(&r, scenes[i]);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        snprintf(path, sizeof path, "%s/%s", r.folder, names[i]);
        remove(path);
    }
    rmdir(r.folder);
    return result;
}
