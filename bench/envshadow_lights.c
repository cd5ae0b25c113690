/* envshadow_lights.c - what k lights of each method cost and are worth. Rows of scene "none" are unshadowed: irradiance
   on 128 normals against the sum over all texels. The others are pictures by `render --technique envshadow` beside the
   reference, the programs being run as users would. */
#define _POSIX_C_SOURCE 200809L
#include "envlights.h"
#include "bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { NORMALS = 128 };

static const char *const method_names[] = { "structured", "median", "variance", "cdf" };

typedef struct files { char folder[64], reference[96], picture[96]; } files;

/* ---- unshadowed ---- */

typedef struct probe { double normal[NORMALS][3], exact[NORMALS], energy[3]; } probe;

static double clamped_cosine(const double *n, const double *d)
{
    double c = n[0] * d[0] + n[1] * d[1] + n[2] * d[2];
    return c > 0 ? c : 0;
}

static double luminance(const float *rgb)
{
    return 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2];
}

static void probe_map(probe *p, const ex_sky *sky)
{
    memset(p, 0, sizeof *p);
    for (int i = 0; i < NORMALS; i++) {         /* a spiral over the sphere */
        double z = 1 - (2 * i + 1.0) / NORMALS, r = sqrt(1 - z * z), a = 2.39996322972865 * i;
        p->normal[i][0] = r * cos(a);
        p->normal[i][1] = z;
        p->normal[i][2] = r * sin(a);
    }
    for (uint32_t y = 0; y < sky->height; y++) {
        double omega = envlt_texel_solid_angle(ENVLT_PROJECTION_LATLONG, sky->width, sky->height, 0, y);
        for (uint32_t x = 0; x < sky->width; x++) {
            const float *rgb = sky->rgb + 3 * ((size_t)y * sky->width + x);
            float f[3];
            double d[3];
            envlt_texel_direction(ENVLT_PROJECTION_LATLONG, sky->width, sky->height, 0,
                                  (float)x + 0.5f, (float)y + 0.5f, f);
            for (int c = 0; c < 3; c++) {
                d[c] = (double)f[c];
                p->energy[c] += omega * (double)rgb[c];
            }
            for (int i = 0; i < NORMALS; i++)
                p->exact[i] += omega * luminance(rgb) * clamped_cosine(p->normal[i], d);
        }
    }
}

static double probe_error(const probe *p, const envlt_light *lights, uint32_t count)
{
    double square = 0, mean = 0;
    for (int i = 0; i < NORMALS; i++) {
        double sum = 0;
        for (uint32_t k = 0; k < count; k++) {
            const float *f = lights[k].direction;
            double d[3] = { (double)f[0], (double)f[1], (double)f[2] };
            sum += luminance(lights[k].irradiance) * clamped_cosine(p->normal[i], d);
        }
        square += (sum - p->exact[i]) * (sum - p->exact[i]) / NORMALS;
        mean += p->exact[i] / NORMALS;
    }
    return sqrt(square) / mean;
}

static int build_row(const bn_options *options, const char *map_name, const ex_sky *sky, const probe *p, int method,
                     uint32_t k)
{
    envlt_map map = { ENVLT_PROJECTION_LATLONG, sky->width, sky->height, sky->rgb, 0 };
    envlt_desc desc;
    double best = HUGE_VAL, energy = 0;
    memset(&desc, 0, sizeof desc);
    desc.light_count = k;
    desc.method = (envlt_method)(ENVLT_METHOD_STRUCTURED + method);
    for (int run = 0; run < 5; run++) {
        envlt_lights *lights;
        envlt_stats stats;
        uint32_t count;
        const envlt_light *list;
        double start = ex_seconds(), ms;
        if (envlt_create(&desc, &map, &lights, &stats) != ENVLT_OK)
            return bn_failed("envshadow_lights", "out of memory");
        ms = 1000 * (ex_seconds() - start);
        best = ms < best ? ms : best;
        list = envlt_get_lights(lights, &count);
        if (run == 4) {
            for (int c = 0; c < 3; c++)
                energy = fmax(energy, fabs(stats.energy[c] / p->energy[c] - 1));
            bn_begin(options, "envshadow_lights", 1, "none");
            bn_text("map", map_name);
            bn_integer("map_width", sky->width);
            bn_text("scene", "none");
            bn_integer("k", k);
            bn_integer("lights", count);
            bn_text("method", method_names[method]);
            bn_number("ms", best);
            bn_number("energy_error", energy);
            bn_number("rmse_vs_reference", probe_error(p, list, count));
            bn_number("ssim", HUGE_VAL);
            bn_end(options);
        }
        envlt_free(lights);
    }
    return 0;
}

/* ---- shadowed ---- */

static double number_in(const char *text, const char *name)
{
    char key[64];
    const char *at;
    snprintf(key, sizeof key, "\"%s\": ", name);
    at = strstr(text, key);
    return at ? strtod(at + strlen(key), NULL) : HUGE_VAL;
}

/* Runs a program beside this one; its output goes into text. */
static int run(const bn_options *options, const char *arguments, char *text, size_t size)
{
    const char *slash = strrchr(options->program, '/');
    char command[4096];
    FILE *pipe;
    size_t length;
    snprintf(command, sizeof command, "%.*s%s", slash ? (int)(slash + 1 - options->program) : 0, options->program,
             arguments);
    pipe = popen(command, "r");
    if (!pipe)
        return -1;
    length = fread(text, 1, size - 1, pipe);
    text[length] = 0;
    return pclose(pipe) == 0 ? 0 : -1;
}

static int picture_row(const bn_options *options, const files *f, const char *scene, const char *sky, const char *name,
                       const char *size, int method, uint32_t k, int samples)
{
    char arguments[2048], figures[4096], compared[1024];
    snprintf(arguments, sizeof arguments, "render --technique envshadow --scene '%s' --env '%s' --size %s --samples %d "
             "--threads %d --set light_count=%u --set method=%s --out '%s' --json -", scene, sky, size, samples,
             options->threads, (unsigned)k, method_names[method], f->picture);
    if (run(options, arguments, figures, sizeof figures) != 0)
        return bn_failed(scene, "render failed");
    snprintf(arguments, sizeof arguments, "compare '%s' '%s'", f->picture, f->reference);
    if (run(options, arguments, compared, sizeof compared) != 0)
        return bn_failed(scene, "compare failed");
    bn_begin(options, "envshadow_lights", options->threads, "none");
    bn_text("map", name);
    bn_text("scene", scene);
    bn_integer("k", k);
    bn_integer("lights", (uint64_t)number_in(figures, "lights"));
    bn_text("method", method_names[method]);
    bn_text("filter", samples > 1 ? "penumbra" : "plain");
    bn_number("ms", number_in(figures, "lights_ms"));
    bn_number("shadow_ms", number_in(figures, "shadow_ms"));
    bn_number("light_ms", number_in(figures, "light_ms"));
    bn_number("energy_error", HUGE_VAL);
    bn_number("rmse_vs_reference", number_in(compared, "relative_rmse"));
    bn_number("ssim", number_in(compared, "ssim"));
    bn_end(options);
    return 0;
}

static int pictures(const bn_options *options, const files *f, const char *scene, const char *sky, const char *name)
{
    static const uint32_t counts[] = { 16, 64, 128, 192, 256, 300, 512, 1024, 2048 };
    const char *size = options->full ? "320x240" : "128x96";
    char arguments[2048], text[4096];
    snprintf(arguments, sizeof arguments, "render --technique reference --scene '%s' --env '%s' --size %s --samples %d "
             "--threads %d --out '%s'", scene, sky, size, options->full ? 4096 : 1024, options->threads, f->reference);
    if (run(options, arguments, text, sizeof text) != 0)
        return bn_failed(scene, "the reference failed");
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++)
        for (int method = 0; method < 4; method++)
            for (int filtered = 0; filtered < 2; filtered++) {
                if (counts[i] > 512 && !options->full)
                    continue;
                if (picture_row(options, f, scene, sky, name, size, method, counts[i], filtered ? 16 : 1) != 0)
                    return -1;
            }
    return 0;
}

static const char *last_part(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static int measure(const bn_options *options, const files *f, const char *scene, const char *name)
{
    static probe p;
    char error[EX_ERROR_SIZE];
    ex_sky sky;
    int result = strncmp(name, "builtin:", 8) == 0 ? ex_sky_builtin(&sky, name + 8, error)
                                                   : ex_sky_load(&sky, name, error);
    if (result != 0)
        return bn_failed(name, error);
    probe_map(&p, &sky);
    for (uint32_t k = 16; k <= 2048 && result == 0; k = k == 256 ? 300 : k == 300 ? 512 : 2 * k)
        for (int method = 0; method < 4 && result == 0; method++)
            result = build_row(options, last_part(name), &sky, &p, method, k);
    ex_sky_free(&sky);
    return result == 0 && f ? pictures(options, f, scene, name, last_part(name)) : result;
}

int bn_envshadow_lights(const bn_options *options)
{
    static const char *const made[] = { "builtin:sky", "builtin:studio" };
    static const char *const measured[][2] = { { "venice_sunset_1k.hdr", "sunset.hdr" },
                                               { "studio_small_03_1k.hdr", "studio.hdr" } };
    char path[1024], teapot[1024];
    const char *scene = options->model ? options->model : bn_asset(options, "teapot.glb", NULL, teapot);
    files f;
    int with_pictures = bn_rays_version() != 0, result = 0;
    if (!with_pictures)
        bn_failed("envshadow_lights", "unshadowed rows only: the reference needs Embree (libembree-dev)");
    if (!scene)
        scene = "builtin:knot";
    snprintf(f.folder, sizeof f.folder, "/tmp/dapple-bench-XXXXXX");
    if (!mkdtemp(f.folder))
        return bn_failed("/tmp", "no room for temporary files");
    snprintf(f.reference, sizeof f.reference, "%s/reference.pfm", f.folder);
    snprintf(f.picture, sizeof f.picture, "%s/envshadow.pfm", f.folder);
    for (int i = 0; i < 2 && result == 0; i++)
        result = measure(options, with_pictures ? &f : NULL, scene, made[i]);
    for (int i = 0; i < 2 && result == 0; i++)
        if (bn_asset(options, measured[i][0], measured[i][1], path))
            result = measure(options, with_pictures ? &f : NULL, scene, path);
    remove(f.reference);
    remove(f.picture);
    rmdir(f.folder);
    return result;
}
