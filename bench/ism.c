/* ism.c - figures of ism.h: pictures beside the one-bounce reference, choice of VPLs, visibility, flicker.

   Two kinds of reference: `render --technique reference`, which is a path tracer, for whole pictures; and, where one
   part of the method is to be judged alone, many VPLs with exact visibility by Embree, which has no noise of
   its own. */
#define _POSIX_C_SOURCE 200809L
#include "ism_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void bn_ism_close(bn_scene *s)
{
    im_rsms_free(&s->rsms);
    im_mesh_free(&s->mesh);
    bn_rays_free(s->rays);
    bn_model_free(&s->flat);
    ex_gbuffer_free(&s->gbuffer);
    ex_scene_free(&s->scene);
    free(s->emitters);
    memset(s, 0, sizeof *s);
}

int bn_ism_light(bn_scene *s, const bn_options *options, uint32_t rsm, uint32_t light_points)
{
    char error[EX_ERROR_SIZE];
    double start = ex_seconds();
    im_rsms_free(&s->rsms);
    if (im_lamps_build(&s->rsms, &s->job, light_points, 1, error) != 0 ||
        im_rsms_render(&s->rsms, NULL, &s->job, rsm, error) != 0)
        return bn_failed(s->name, error);
    s->rsm_ms = 1000 * (ex_seconds() - start);
    (void)options;
    return 0;
}

int bn_ism_open(bn_scene *s, const bn_options *options, const char *path, uint32_t width, uint32_t height, uint32_t rsm,
                      uint32_t light_points)
{
    char error[EX_ERROR_SIZE];
    int result;
    memset(s, 0, sizeof *s);
    s->name = path;
    result = strncmp(path, "builtin:", 8) == 0 ? ex_scene_builtin(&s->scene, path + 8, 0, error)
                                               : ex_scene_load(&s->scene, path, error);
    if (result == 0 && !s->scene.has_camera)
        ex_scene_default_camera(&s->scene, width, height);
    if (result == 0)
        result = ex_gbuffer_render(&s->gbuffer, &s->scene, width, height, 1, options->threads, error);
    s->job.scene = &s->scene;
    if (result == 0)
        result = ex_scene_bounds(&s->scene, s->job.center, &s->job.radius);
    if (result == 0)
        result = im_mesh_build(&s->mesh, &s->job, error);
    if (result == 0)
        result = rd_emitters_build(&s->scene, &s->emitters, &s->job.emitter_count);
    if (result != 0) {
        bn_ism_close(s);
        return bn_failed(path, error);
    }
    s->job.gbuffer = &s->gbuffer;
    s->job.emitters = s->emitters;
    s->job.threads = options->threads;
    s->job.pool = options->pool;
    im_view(&s->view, &s->job);
    if (bn_ism_light(s, options, rsm, light_points) == 0)
        return 0;
    bn_ism_close(s);
    return -1;
}

/* Embree over the mesh that ism.h sees. */
static int open_rays(bn_scene *s, const bn_options *options)
{
    size_t vertices = s->mesh.mesh.vertex_count, indices = s->mesh.mesh.index_count;
    s->flat.positions = malloc(3 * vertices * sizeof(float));
    s->flat.indices = malloc(indices * sizeof(uint32_t));
    if (!s->flat.positions || !s->flat.indices)
        return bn_failed(s->name, "out of memory");
    memcpy(s->flat.positions, s->mesh.positions, 3 * vertices * sizeof(float));
    memcpy(s->flat.indices, s->mesh.indices, indices * sizeof(uint32_t));
    s->flat.vertices = vertices;
    s->flat.triangles = indices / 3;
    s->rays = bn_rays_create(&s->flat, options->threads);
    return s->rays ? 0 : bn_failed(s->name, "needs Embree: apt-get install libembree-dev");
}

const char *bn_ism_simd(void)
{
    return strncmp(bn_simd(), "avx", 3) == 0 ? "avx2" : "none";
}

/* ---- exact visibility of the same VPLs ---- */

typedef struct exact {
    const bn_scene *scene;
    const ism_vpl *vpls;
    float epsilon;
    const ism_near_point *near_points;
} exact;

static void exact_visibility(void *user, const float *p, const float *n, const uint32_t *list, size_t count, float *lit)
{
    const exact *e = user;
    float from[64][3], to[64][3];
    for (size_t i = 0; i < count; i++)       /* ism.h asks for 64 at most */
        for (int k = 0; k < 3; k++) {
            const ism_vpl *v = &e->vpls[list[i]];
            from[i][k] = p[k] + e->epsilon * n[k];
            to[i][k] = v->directional ? from[i][k] + 100 * e->scene->job.radius * v->position[k]
                                      : v->position[k] + e->epsilon * v->normal[k];
        }
    bn_rays_segments(e->scene->rays, from[0], to[0], count, lit);
}

static void exact_near(void *user, const float *p, const float *n, const uint32_t *list, size_t count, float *lit)
{
    const exact *e = user;
    float from[64][3], to[64][3];
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            const ism_near_point *at = &e->near_points[list[i]];
            from[i][k] = p[k] + e->epsilon * n[k];
            to[i][k] = at->position[k] + e->epsilon * at->normal[k];
        }
    bn_rays_segments(e->scene->rays, from[0], to[0], count, lit);
}

ism_desc bn_ism_desc(const bn_options *options, uint32_t vpls, uint32_t points)
{
    ism_desc d;
    memset(&d, 0, sizeof d);
    d.vpl_count = vpls;
    d.surfel_count = points;
    d.system.parallel_for = ex_pool_run;
    d.system.user = options->pool;
    return d;
}

ism_frame bn_ism_frame(const bn_scene *s)
{
    ism_frame f = { &s->mesh.mesh, s->rsms.sources, s->rsms.count, &s->view, 0 };
    return f;
}

/* Share of pairs of pixel and VPL that face each other whose visibility is not Embree's; also weighted by the light
   that the pair carries. */
typedef struct visibility_error { double share, weighted, false_shadow, lit; } visibility_error;

static int measure_visibility(const bn_scene *s, const ism_maps *maps, float bias, visibility_error *out)
{
    size_t count, pixels = (size_t)s->gbuffer.width * s->gbuffer.height, pairs = 0;
    const ism_vpl *vpls = ism_vpls(maps, &count);
    double wrong = 0, weight = 0, wrong_weight = 0, dark = 0, lit = 0;
    exact e = { s, vpls, 2e-5f * s->job.radius, NULL };
    ism_points one = { 0 };
    one.count = 1;
    for (size_t i = 0; i < pixels; i += 7) {
        const ex_pixel *px = &s->gbuffer.pixels[i];
        if (px->object == UINT32_MAX)
            continue;
        for (uint32_t v = (uint32_t)(i % 16); v < count; v += 16) {
            float d[3], d2 = 0, a = 0, b = 0, truth, guess;
            double carried;
            for (int k = 0; k < 3; k++) {
                d[k] = vpls[v].position[k] - px->position[k];
                d2 += d[k] * d[k];
                a += d[k] * px->geometric[k];
                b -= d[k] * vpls[v].normal[k];
            }
            if (!(a > 0 && b > 0 && d2 > 0))
                continue;
            exact_visibility(&e, px->position, px->geometric, &v, 1, &truth);
            one.positions = px->position;
            one.normals = px->geometric;
            if (ism_visible(maps, v, &one, bias, &guess) != ISM_OK)
                return bn_failed(s->name, "ism_visible");
            carried = (double)(a * b) / ((double)d2 * (double)d2 + 1e-4) * (double)vpls[v].flux[1];
            weight += carried;
            lit += (double)truth;
            pairs++;
            if (truth > guess || truth < guess) {
                wrong++;
                wrong_weight += carried;
                dark += (double)(truth > guess);
            }
        }
    }
    out->share = pairs ? wrong / (double)pairs : 0;
    out->weighted = weight > 0 ? wrong_weight / weight : 0;
    out->false_shadow = pairs ? dark / (double)pairs : 0;
    out->lit = pairs ? lit / (double)pairs : 0;
    return 0;
}

static int build_maps(const bn_scene *s, const ism_desc *d, ism_maps **maps)
{
    ism_frame frame = bn_ism_frame(s);
    ism_result result = ism_create(d, maps);
    if (result == ISM_OK) {
        result = ism_choose(*maps, &frame);
        if (result == ISM_OK)
            result = ism_build(*maps, &frame);
        if (result != ISM_OK)
            ism_free(*maps);
    }
    return result == ISM_OK ? 0 : bn_failed(s->name, ism_result_text(result));
}

static int visibility_of(const bn_options *options, const char *path, const char *name)
{
    static const struct { ism_spread spread; const char *name; int windows;
    } spreads[] = { { ISM_SPREAD_AREA, "area", 0 },
                    { ISM_SPREAD_VIEW_1, "view1", 0 },
                    { ISM_SPREAD_VIEW_8, "view8", 0 },
                    { ISM_SPREAD_PAIR, "pair", 0 },
                    { ISM_SPREAD_AREA, "area", 1 },
                    { ISM_SPREAD_PAIR, "pair", 1 } };
    bn_scene s;
    if (bn_ism_open(&s, options, path, 160, 90, 512, 64) != 0)
        return -1;
    if (open_rays(&s, options) != 0) {
        bn_ism_close(&s);
        return -1;
    }
    for (size_t i = 0; i < sizeof spreads / sizeof spreads[0]; i++) {
        visibility_error error = { 0, 0, 0, 0 };
        ism_desc d = bn_ism_desc(options, 1024, 8192);
        ism_maps *maps;
        int result;
        d.spread = spreads[i].spread;
        d.window_rim = spreads[i].windows ? 0 : -1;
        if (build_maps(&s, &d, &maps) != 0) {
            bn_ism_close(&s);
            return -1;
        }
        result = measure_visibility(&s, maps, 0.02f, &error);
        ism_free(maps);
        if (result != 0) {
            bn_ism_close(&s);
            return -1;
        }
        bn_begin(options, "ism_visibility", options->threads, bn_ism_simd());
        bn_text("scene", name);
        bn_text("spread", spreads[i].name);
        bn_integer("windows", (uint64_t)spreads[i].windows);
        bn_integer("vpl_count", 1024);
        bn_integer("surfel_count", 8192);
        bn_number("differs", error.share);
        bn_number("differs_weighted", error.weighted);
        bn_number("false_shadow", error.false_shadow);
        bn_number("lit", error.lit);
        bn_end(options);
    }
    bn_ism_close(&s);
    return 0;
}

int bn_ism_visibility(const bn_options *options)
{
    char path[1024];
    if (options->model)
        return visibility_of(options, options->model, options->model);
    if (visibility_of(options, "builtin:corridor", "corridor") != 0)
        return -1;
    return bn_asset(options, "kitchen.glb", NULL, path) ? visibility_of(options, path, "kitchen") : 0;
}

/* ---- pictures beside the path tracer, both by `render` ---- */

typedef struct files { char folder[64], render[1024], compare[1024]; } files;

static int render(const files *f, const char *technique, const char *scene, const char *size, uint32_t samples,
                  const char *more)
{
    char command[3072];
    snprintf(command, sizeof command,
             "'%s' --technique %s --scene '%s' --size %s --samples %u --set only=indirect --set "
             "bounces=1 --out '%s/%s.pfm' --json '%s/%s.json' %s",
             f->render, technique, scene, size, (unsigned)samples, f->folder, technique, f->folder, technique, more);
    return system(command) == 0 ? 0 : bn_failed(scene, technique);
}

static double number(const files *f, const char *technique, const char *name)
{
    char path[128], text[4096], key[64], *at;
    FILE *file;
    size_t length;
    snprintf(path, sizeof path, "%s/%s.json", f->folder, technique);
    file = fopen(path, "rb");
    length = file ? fread(text, 1, sizeof text - 1, file) : 0;
    if (file)
        fclose(file);
    text[length] = 0;
    snprintf(key, sizeof key, "\"%s\": ", name);
    at = strstr(text, key);
    return at ? strtod(at + strlen(key), NULL) : HUGE_VAL;
}

static int downwards(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x < y) - (x > y);
}

static double brightness(const float *p) { return (double)p[0] + (double)p[1] + (double)p[2]; }

/* Over the pixels below that percentile of b's brightness. */
static int error_below(const float *a, const float *b, size_t pixels, double share, bn_picture_error *out)
{
    double *bright = malloc((pixels + 1) * sizeof *bright), most, all = 0, sum_a = 0, sum_b = 0;
    size_t count = 0, used = 0;
    if (!bright)
        return bn_failed("comparison", "out of memory");
    for (size_t i = 0; i < pixels; i++)
        if (brightness(a + 3 * i) > 0 || brightness(b + 3 * i) > 0)
            bright[count++] = brightness(b + 3 * i);
    qsort(bright, count, sizeof *bright, downwards);
    most = count ? bright[(size_t)((1 - share) * (double)count)] : 0;
    free(bright);
    for (size_t i = 0; i < pixels; i++) {
        if (!(brightness(a + 3 * i) > 0 || brightness(b + 3 * i) > 0) || brightness(b + 3 * i) > most)
            continue;
        used++;
        sum_a += brightness(a + 3 * i);
        sum_b += brightness(b + 3 * i);
        for (int k = 0; k < 3; k++) {
            double d = (double)a[3 * i + (size_t)k] - (double)b[3 * i + (size_t)k];
            all += d * d;
        }
    }
    out->rmse_below = sqrt(all * 3 * (double)used) / sum_b;
    out->ratio_below = sum_a / sum_b;
    return 0;
}

void bn_picture_error_print(const bn_picture_error *e)
{
    bn_number("rmse_vs_reference", e->rmse);
    bn_number("rmse_without_worst_hundredth", e->rmse_99);
    bn_number("rmse_below_99th", e->rmse_below);
    bn_number("mean_below_99th", e->ratio_below);
    bn_number("mean_ratio", e->ratio);
}

int bn_picture_error_of(const float *a, const float *b, size_t pixels, bn_picture_error *out)
{
    double sum_a = 0, sum_b = 0, all = 0, rest = 0, *square = malloc(pixels * sizeof *square);
    size_t count = 0;
    if (!square)
        return bn_failed("comparison", "out of memory");
    if (error_below(a, b, pixels, 0.99, out) != 0) {
        free(square);
        return -1;
    }
    for (size_t i = 0; i < pixels; i++, a += 3, b += 3) {
        double d2 = 0;
        if (!(a[0] > 0 || a[1] > 0 || a[2] > 0 || b[0] > 0 || b[1] > 0 || b[2] > 0))
            continue;
        for (int k = 0; k < 3; k++) {
            d2 += ((double)a[k] - (double)b[k]) * ((double)a[k] - (double)b[k]);
            sum_a += (double)a[k];
            sum_b += (double)b[k];
        }
        square[count++] = d2;
    }
    qsort(square, count, sizeof *square, downwards);
    for (size_t i = 0; i < count; i++) {
        all += square[i];
        rest += i < count / 100 ? 0 : square[i];
    }
    out->rmse = sqrt(all * 3 * (double)count) / sum_b;
    out->rmse_99 = sqrt(rest * 3 * (double)count) / sum_b;
    out->ratio = sum_a / sum_b;
    free(square);
    return 0;
}

static int read_picture(const files *f, const char *technique, ex_image *image)
{
    char path[128], message[EX_ERROR_SIZE];
    snprintf(path, sizeof path, "%s/%s.pfm", f->folder, technique);
    return ex_image_read_pfm(image, path, message) == 0 ? 0 : bn_failed(path, message);
}

static int compare(const files *f, bn_picture_error *e, double *ssim)
{
    char command[2400];
    ex_image a, b;
    int result = read_picture(f, "ism", &a);
    if (result != 0)
        return -1;
    if (read_picture(f, "reference", &b) != 0) {
        ex_image_free(&a);
        return -1;
    }
    result = bn_picture_error_of(a.rgb, b.rgb, (size_t)a.width * a.height, e);
    ex_image_free(&a);
    ex_image_free(&b);
    snprintf(command, sizeof command, "'%s' '%s/ism.pfm' '%s/reference.pfm' > '%s/compare.json'", f->compare, f->folder,
             f->folder, f->folder);
    if (result == 0 && system(command) != 0)
        return bn_failed("comparison", f->compare);
    *ssim = number(f, "compare", "ssim");
    return result;
}

static int picture_of(const bn_options *options, const files *f, const char *scene, const char *name)
{
    bn_picture_error e;
    double ssim;
    if (render(f, "reference", scene, "160x90", options->full ? 32768 : 8192, "") != 0 ||
        render(f, "ism", scene, "160x90", 1024, "") != 0 || compare(f, &e, &ssim) != 0)
        return -1;
    bn_begin(options, "ism", options->threads, bn_ism_simd());
    bn_text("scene", name);
    bn_text("light", "the scene's own");
    bn_text("backend", "cpu");
    bn_number("triangles", number(f, "ism", "triangles"));
    bn_number("vpl_count", number(f, "ism", "vpls"));
    bn_number("surfel_count", number(f, "ism", "surfels"));
    bn_number("rsm_ms", number(f, "ism", "rsm_ms"));
    bn_number("choose_ms", number(f, "ism", "choose_ms"));
    bn_number("build_ms", number(f, "ism", "build_ms"));
    bn_number("shade_ms", number(f, "ism", "shade_ms"));
    bn_number("frame_ms", number(f, "ism", "frame_ms"));
    bn_picture_error_print(&e);
    bn_number("ssim", ssim);
    bn_number("reference_noise", number(f, "reference", "noise"));
    bn_number("lost_energy", number(f, "ism", "lost_energy"));
    bn_end(options);
    return 0;
}

/* ---- the causes of the error, one taken away after the other ---- */

typedef struct cause {
    const char *name;
    uint32_t    vpls, rsm, light_points;
    enum { BY_MAPS, BY_RAYS, BY_NOTHING } visibility;
    ism_near    near_mode;
} cause;

static int shade_cause(const bn_scene *s, const bn_options *options, const cause *c, float *out, ism_stats *stats)
{
    ism_frame frame = bn_ism_frame(s);
    ism_desc d = bn_ism_desc(options, c->vpls, c->visibility == BY_MAPS ? 8192 : 8);
    ism_shading shading = { 0 };
    exact e = { s, NULL, 2e-5f * s->job.radius, NULL };
    ism_maps *maps;
    ism_result result = ism_create(&d, &maps);
    if (result != ISM_OK)
        return bn_failed(s->name, ism_result_text(result));
    shading.near_mode = c->near_mode;
    shading.no_maps = c->visibility == BY_NOTHING;
    result = ism_choose(maps, &frame);
    if (c->visibility == BY_RAYS) {
        e.vpls = ism_vpls(maps, NULL);
        e.near_points = ism_near_points(maps, NULL);
        shading.visible_fn = exact_visibility;
        shading.near_visible_fn = exact_near;
        shading.visible_user = shading.near_visible_user = &e;
    } else if (result == ISM_OK && c->visibility == BY_MAPS) {
        result = ism_build(maps, &frame);
    }
    if (result == ISM_OK)
        result = ism_shade(maps, &s->view, &shading, out, stats);
    ism_free(maps);
    return result == ISM_OK ? 0 : bn_failed(s->name, ism_result_text(result));
}

static void report_cause(const bn_options *options, const char *scene, const cause *c, const bn_picture_error *e,
                         double noise, double lost)
{
    static const char *const sights[] = { "maps", "rays", "none" }, *const rules[] = {
        "", "patch", "sphere", "clamp", "mean", "none", "gather"
    };
    bn_begin(options, "ism_causes", options->threads, bn_ism_simd());
    bn_text("scene", scene);
    bn_text("cause", c->name);
    bn_text("visibility", sights[c->visibility]);
    bn_text("near_mode", rules[c->near_mode]);
    bn_integer("vpl_count", c->vpls);
    bn_integer("rsm", c->rsm);
    bn_integer("light_point_count", c->light_points);
    bn_picture_error_print(e);
    bn_number("lost_energy", lost);
    bn_number("reference_noise", noise);
    bn_end(options);
}

static int causes_of(const bn_options *options, const files *f, const char *path, const char *name)
{
    enum { W = 80, H = 45 };
    static const cause causes[] = { { "as it is", 1024, 512, 64, BY_MAPS, ISM_NEAR_GATHER },
                                    { "maps", 1024, 512, 64, BY_RAYS, ISM_NEAR_GATHER },
                                    { "near points", 1024, 512, 64, BY_RAYS, ISM_NEAR_PATCH },
                                    { "near field", 1024, 512, 64, BY_RAYS, ISM_NEAR_NONE },
                                    { "number of VPLs", 8192, 512, 64, BY_RAYS, ISM_NEAR_GATHER },
                                    { "RSM texels", 8192, 2048, 64, BY_RAYS, ISM_NEAR_GATHER },
                                    { "points on lamps", 8192, 1024, 256, BY_RAYS, ISM_NEAR_GATHER },
                                    { "no shadows in either", 1024, 512, 64, BY_NOTHING, ISM_NEAR_GATHER } };
    ex_image truth[2] = { { 0, 0, NULL }, { 0, 0, NULL } };
    double noise[2] = { 0, 0 };
    bn_scene s;
    int result = bn_ism_open(&s, options, path, W, H, 512, 64);
    if (result != 0)
        return -1;
    result = open_rays(&s, options);
    for (int i = 0; i < 2 && result == 0; i++) {
        result =
            render(f, "reference", path, "80x45", options->full ? 32768 : 8192, i ? "--set indirect_visibility=0" : "");
        if (result == 0)
            result = read_picture(f, "reference", &truth[i]);
        noise[i] = number(f, "reference", "noise");
    }
    for (size_t i = 0; i < sizeof causes / sizeof causes[0] && result == 0; i++) {
        const cause *c = &causes[i];
        int unshadowed = c->visibility == BY_NOTHING;
        float *out = malloc(3 * W * H * sizeof *out);
        bn_picture_error e = { 0, 0, 0, 0, 0 };
        ism_stats stats;
        result = out ? bn_ism_light(&s, options, c->rsm, c->light_points) : bn_failed(name, "out of memory");
        if (result == 0)
            result = shade_cause(&s, options, c, out, &stats);
        if (result == 0)
            result = bn_picture_error_of(out, truth[unshadowed].rgb, W * H, &e);
        if (result == 0)
            report_cause(options, name, c, &e, noise[unshadowed], stats.lost_energy);
        free(out);
    }
    ex_image_free(&truth[0]);
    ex_image_free(&truth[1]);
    bn_ism_close(&s);
    return result;
}

static int pictures(const bn_options *options, int (*of)(const bn_options *, const files *, const char *, const char *))
{
    const char *slash = strrchr(options->program, '/');
    char path[1024];
    files f;
    int result;
    if (!bn_rays_version())
        return bn_failed("ism", "the reference needs Embree: apt-get install libembree-dev");
    snprintf(f.folder, sizeof f.folder, "/tmp/dapple-bench-XXXXXX");
    if (!mkdtemp(f.folder))
        return bn_failed("/tmp", "no room for temporary files");
    snprintf(f.render, sizeof f.render, "%.*srender", slash ? (int)(slash + 1 - options->program) : 0,
             options->program);
    snprintf(f.compare, sizeof f.compare, "%.*scompare", slash ? (int)(slash + 1 - options->program) : 0,
             options->program);
    if (options->model) {
        result = of(options, &f, options->model, options->model);
    } else {
        result = of(options, &f, "builtin:atrium", "atrium");
        if (result == 0 && bn_asset(options, "kitchen.glb", NULL, path))
            result = of(options, &f, path, "kitchen");
    }
    for (int i = 0; i < 5; i++) {
        static const char *const names[5] = { "ism.pfm", "ism.json", "reference.pfm", "reference.json", 
                                               "compare.json" };
        char name[128];
        snprintf(name, sizeof name, "%s/%s", f.folder, names[i]);
        remove(name);
    }
    remove(f.folder);
    return result;
}

int bn_ism(const bn_options *options)        { return pictures(options, picture_of); }
int bn_ism_causes(const bn_options *options) { return pictures(options, causes_of); }

/* ---- choice of VPLs: the same number of them, exact visibility ---- */

static int shade_exactly(const bn_scene *s, ism_maps *maps, float *out)
{
    exact e = { s, ism_vpls(maps, NULL), 2e-5f * s->job.radius, ism_near_points(maps, NULL) };
    ism_shading shading = { 0 };
    ism_result result;
    shading.visible_fn = exact_visibility;
    shading.near_visible_fn = exact_near;
    shading.visible_user = shading.near_visible_user = &e;
    result = ism_shade(maps, &s->view, &shading, out, NULL);
    return result == ISM_OK ? 0 : bn_failed(s->name, ism_result_text(result));
}

static int chosen_picture(const bn_scene *s, const bn_options *options, uint32_t vpls, ism_importance importance,
                          uint32_t grid, uint32_t seed, float *out)
{
    ism_desc d = bn_ism_desc(options, vpls, 8);
    ism_frame frame = bn_ism_frame(s);
    ism_maps *maps;
    int result;
    d.importance = importance;
    d.view_grid_side = grid;
    d.unstable = 1;
    d.seed = seed;
    if (ism_create(&d, &maps) != ISM_OK)
        return bn_failed(s->name, "out of memory");
    result = ism_choose(maps, &frame) == ISM_OK ? shade_exactly(s, maps, out) : bn_failed(s->name, "ism_choose");
    ism_free(maps);
    return result;
}

int bn_ism_vpls(const bn_options *options)
{
    enum { W = 64, H = 36, VALUES = 3 * W * H, RUNS = 8 };
    static const char *const names[ISM_IMPORTANCE_COUNT] = { "", "flux", "brsm", "guided", "brsm_mean", "guided_mean" };
    static float truth[VALUES], picture[VALUES];
    double flux_error = 0;
    bn_scene s;
    int result;
    if (bn_ism_open(&s, options, options->model ? options->model : "builtin:uroom", W, H, 128, 16) != 0)
        return -1;
    result = open_rays(&s, options);
    if (result == 0)
        result = chosen_picture(&s, options, options->full ? 16384 : 8192, ISM_IMPORTANCE_GUIDED, 8, 1, truth);
    for (int row = 2; row < 2 * ISM_IMPORTANCE_COUNT && result == 0; row++) {   /* 4 x 4 and 8 x 8 view samples */
        int i = row / 2;
        uint32_t grid = row % 2 ? 8 : 4;
        double error = 0, mean = 0;
        for (uint32_t run = 0; run < RUNS && result == 0; run++) {
            result = chosen_picture(&s, options, 256, (ism_importance)i, grid, 100 + run, picture);
            for (int k = 0; k < VALUES; k++) {
                double d = (double)picture[k] - (double)truth[k];
                error += d * d / (VALUES * RUNS);
                mean += (double)truth[k] / (VALUES * RUNS);
            }
        }
        if (row == 2)
            flux_error = error;
        bn_begin(options, "ism_vpls", options->threads, bn_ism_simd());
        bn_text("scene", s.name);
        bn_text("importance", names[i]);
        bn_integer("vpl_count", 256);
        bn_integer("view_grid_side", grid);
        bn_number("mse", error);
        bn_number("relative_rmse", sqrt(error) / mean);
        bn_number("mse_over_flux", error / flux_error);
        bn_end(options);
    }
    bn_ism_close(&s);
    return result;
}

/* ---- flicker ---- */

/* Mean absolute difference of successive frames over their mean, the scene's lights moving 2 mm a frame. */
static int flicker_of(bn_scene *s, const bn_options *options, int unstable, double *flicker)
{
    size_t values = 3 * s->view.count;
    float *now = calloc(2 * values, sizeof *now), *before = now ? now + values : NULL;
    ism_desc d = bn_ism_desc(options, 512, 2048);
    ism_maps *maps = NULL;
    double change = 0, mean = 0;
    int result = 0;
    d.unstable = unstable;
    if (!now || ism_create(&d, &maps) != ISM_OK)
        result = bn_failed(s->name, "out of memory");
    for (uint32_t i = 0; i < 12 && result == 0; i++) {
        ism_frame frame;
        for (uint32_t k = 0; k < s->scene.light_count; k++)
            s->scene.lights[k].position[0] +=
                i ? 0.002f : -0.002f * 11 * (float)unstable; /* the second run begins there too */
        result = bn_ism_light(s, options, 128, 16);
        frame = bn_ism_frame(s);
        frame.index = i;
        if (result == 0 && ism_render(maps, &frame, NULL, now, NULL) != ISM_OK)
            result = bn_failed(s->name, "ism_render");
        for (size_t k = 0; i && k < values; k++) {
            change += fabs((double)now[k] - (double)before[k]);
            mean += (double)now[k];
        }
        memcpy(before, now, values * sizeof *now);
    }
    ism_free(maps);
    free(now);
    *flicker = mean > 0 ? change / mean : 0;
    return result;
}

int bn_ism_flicker(const bn_options *options)
{
    double flicker[2] = { 0, 0 };
    bn_scene s;
    int result;
    if (bn_ism_open(&s, options, options->model ? options->model : "builtin:uroom", 96, 54, 128, 16) != 0)
        return -1;
    result = flicker_of(&s, options, 0, &flicker[0]);
    if (result == 0)
        result = flicker_of(&s, options, 1, &flicker[1]);
    if (result == 0) {
        bn_begin(options, "ism_flicker", options->threads, bn_ism_simd());
        bn_text("scene", s.name);
        bn_integer("vpl_count", 512);
        bn_integer("surfel_count", 2048);
        bn_number("persistent", flicker[0]);
        bn_number("not_persistent", flicker[1]);
        bn_number("ratio", flicker[0] / flicker[1]);
        bn_end(options);
    }
    bn_ism_close(&s);
    return result;
}
