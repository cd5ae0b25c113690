/* gl_envshadow.c - envshadow on OpenGL: shadow maps and light of k lights in clusters of c, each round glFinish, by
   compute and by fragments, and what the cost model makes of such times. The model stands in the built-in sky, drawn at
   the paper's 421 x 711 pixels. */
#define _POSIX_C_SOURCE 200809L
#include "envlights.h"
#include "envshadow.h"
#include "bench.h"
#include "gl.h"
#include "../gl_backend/gl_envshadow.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAP_SIZE = 256, MOST_LIGHTS = 192 };

typedef struct rig {
    bn_gl               g;
    glbk_envsh_renderer renderer;
    glbk_gbuffer seen;
    envsh_maps         *layout;
    const envsh_view   *views;
    uint32_t            count, vertex_array, buffers[2];
    const bn_model     *model;
    float low[3], high[3]; /* of the model; a ground far wider than it is high counts near its middle */
} rig;

typedef struct times { double shadow_ms, light_ms; } times;

static void close_rig(rig *r)
{
    if (r->g.gl.renderer) {
        glbk_envsh_renderer_free(&r->g.gl, &r->renderer);
        glbk_gbuffer_free(&r->g.gl, &r->seen);
        r->g.gl.gl.DeleteVertexArrays(1, &r->vertex_array);
        r->g.gl.gl.DeleteBuffers(2, r->buffers);
    }
    envsh_maps_free(r->layout);
    bn_gl_close(&r->g);
}

/* ---- what a frame needs ---- */

static int make_views(rig *r, uint32_t k)
{
    ex_sky sky = { 0, 0, NULL, 0 };
    char error[EX_ERROR_SIZE];
    envlt_map map;
    envlt_desc desc;
    envsh_maps_desc layout;
    envlt_lights *lights = NULL;
    const envlt_light *list;
    envsh_lights all;
    envsh_bounds bounds;
    envlt_result made;
    envsh_result result;
    if (ex_sky_builtin(&sky, "sky", error) != 0)
        return bn_failed("builtin:sky", error);
    memset(&map, 0, sizeof map);
    memset(&desc, 0, sizeof desc);
    memset(&layout, 0, sizeof layout);
    map.width = sky.width;
    map.height = sky.height;
    map.rgb = sky.rgb;
    desc.light_count = k;
    layout.map_side = MAP_SIZE;
    layout.no_depth = 1;
    memcpy(bounds.low, r->low, sizeof bounds.low);
    memcpy(bounds.high, r->high, sizeof bounds.high);
    envsh_maps_free(r->layout);
    r->layout = NULL;
    made = envlt_create(&desc, &map, &lights, NULL);
    ex_sky_free(&sky);
    if (made != ENVLT_OK)
        return bn_failed("lights", envlt_result_text(made));
    list = envlt_get_lights(lights, &all.count);
    all.directions = list->direction;
    all.irradiances = list->irradiance;
    all.axes_u = list->axis_u;
    all.axes_v = list->axis_v;
    all.stride = sizeof *list;
    r->count = all.count;
    result = envsh_maps_create(&layout, r->count, &r->layout);
    if (result == ENVSH_OK)
        result = envsh_maps_begin(r->layout, &all, bounds);
    r->views = envsh_views(r->layout, NULL);
    envlt_free(lights);
    return result == ENVSH_OK ? 0 : bn_failed("shadow maps", envsh_result_text(result));
}

static void upload_model(rig *r)
{
    const glbk_functions *gl = &r->g.gl.gl;
    const bn_model *m = r->model;
    float tall = m->high[1] - m->low[1];
    for (int k = 0; k < 3; k++) {
        float middle = 0.5f * (m->low[k] + m->high[k]), half = 0.5f * (m->high[k] - m->low[k]);
        half = half > 8 * tall ? 0.5f * tall : half;
        r->low[k] = middle - half;
        r->high[k] = middle + half;
    }
    gl->GenVertexArrays(1, &r->vertex_array);
    gl->GenBuffers(2, r->buffers);
    gl->BindVertexArray(r->vertex_array);
    gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, r->buffers[0]);
    gl->BufferData(GLBK_GL_ARRAY_BUFFER, (ptrdiff_t)(12 * m->vertices), m->positions, GLBK_GL_STATIC_DRAW);
    gl->BindBuffer(GLBK_GL_ELEMENT_ARRAY_BUFFER, r->buffers[1]);
    gl->BufferData(GLBK_GL_ELEMENT_ARRAY_BUFFER, (ptrdiff_t)(12 * m->triangles), m->indices, GLBK_GL_STATIC_DRAW);
    gl->EnableVertexAttribArray(0);
    gl->VertexAttribPointer(0, 3, GLBK_GL_FLOAT, 0, 0, NULL);
    gl->BindVertexArray(0);
}

/* The model fills the picture, seen along -z from far away. */
static glbk_result draw_gbuffer(rig *r)
{
    const float *low = r->low, *high = r->high;
    float aspect = (float)r->renderer.width / (float)r->renderer.height, half;
    glbk_surface s;
    glbk_result result;
    float clip[16] = { 0 }, eye[3] = { 0 };
    memset(&s, 0, sizeof s);
    half = 0.5f * fmaxf(high[1] - low[1], (high[0] - low[0]) / aspect);
    clip[0] = 1 / (half * aspect);
    clip[5] = 1 / half;
    clip[10] = -2 / (high[2] - low[2] + half);
    clip[12] = -clip[0] * 0.5f * (low[0] + high[0]);
    clip[13] = -clip[5] * 0.5f * (low[1] + high[1]);
    clip[14] = -clip[10] * 0.5f * (low[2] + high[2]);
    clip[15] = 1;
    eye[2] = high[2] + 1000 * half;
    s.material.diffuse[0] = s.material.diffuse[1] = s.material.diffuse[2] = 1;
    result = glbk_gbuffer_begin(&r->g.gl, &r->seen, clip, eye);
    if (result == GLBK_OK)
        result = glbk_gbuffer_object(&r->g.gl, &r->seen, &s);
    r->g.gl.gl.BindVertexArray(r->vertex_array);
    r->g.gl.gl.DrawElements(GLBK_GL_TRIANGLES, (int32_t)(3 * r->model->triangles), GLBK_GL_UNSIGNED_INT, NULL);
    return result;
}

static glbk_result draw_model(void *user, glbk_context *gl, glbk_envsh_maps *maps, uint32_t instances)
{
    const rig *r = user;
    glbk_result result = glbk_envsh_cast(gl, maps, NULL);
    gl->gl.BindVertexArray(r->vertex_array);
    gl->gl.DrawElementsInstanced(GLBK_GL_TRIANGLES, (int32_t)(3 * r->model->triangles), GLBK_GL_UNSIGNED_INT, NULL,
                                 (int32_t)instances);
    return result;
}

/* ---- a frame in clusters of c ---- */

static glbk_result run_frame(rig *r, glbk_envsh_maps *maps, const envsh_query *query, times *out)
{
    glbk_result result = GLBK_OK;
    envsh_query q = *query;
    out->shadow_ms = out->light_ms = 0;
    for (uint32_t first = 0; first < r->count && result == GLBK_OK; first += maps->capacity) {
        uint32_t n = r->count - first < maps->capacity ? r->count - first : maps->capacity;
        double start = ex_seconds(), middle;
        result = glbk_envsh_maps_render(&r->g.gl, maps, r->views + first, n, draw_model, r);
        r->g.gl.gl.Finish();
        middle = ex_seconds();
        q.add = first != 0;
        if (result == GLBK_OK)
            result = glbk_envsh_shade(&r->g.gl, &r->renderer, &r->seen, maps, &q, 0);
        r->g.gl.gl.Finish();
        out->shadow_ms += 1e3 * (middle - start);
        out->light_ms += 1e3 * (ex_seconds() - middle);
    }
    return result;
}

typedef struct setting { uint32_t c; int filter; times best; } setting;

static glbk_result try_setting(rig *r, setting *s, int is_first)
{
    static const float radii[] = { 0, 2, 2, 12 };
    const envsh_query query = { (envsh_filter)(ENVSH_FILTER_PLAIN + s->filter), 16, radii[s->filter], 1, 1, 1, 0 };
    envsh_maps_desc layout;
    glbk_envsh_maps_desc desc;
    glbk_envsh_maps maps;
    glbk_result result;
    double since;
    memset(&layout, 0, sizeof layout);
    memset(&desc, 0, sizeof desc);
    layout.map_side = MAP_SIZE;
    desc.capacity = s->c;
    desc.maps = &layout;
    result = glbk_envsh_maps_create(&r->g.gl, &desc, &maps);
    for (int run = 0; result == GLBK_OK && bn_gl_goes_on(&r->g.gl, run, 2, &since); run++) {
        times now;
        result = run_frame(r, &maps, &query, &now);
        if (run == 0 || result != GLBK_OK)          /* the first one compiles */
            continue;
        if ((is_first && run == 1) || now.shadow_ms + now.light_ms < s->best.shadow_ms + s->best.light_ms)
            s->best = now;
    }
    glbk_envsh_maps_free(&r->g.gl, &maps);
    return result;
}

static void write_rig(const rig *r)
{
    bn_text("gl_renderer", r->g.gl.renderer);
    bn_text("path", r->g.gl.compute ? "compute" : "core");
    bn_text("model", r->model->name);
}

static void write_row(const bn_options *options, const rig *r, const setting *s)
{
    static const char *const names[] = { "plain", "smooth", "pcf", "penumbra" };
    bn_begin(options, "gl_envshadow", options->threads, "none");
    write_rig(r);
    bn_integer("triangles", r->model->triangles);
    bn_integer("width", r->renderer.width);
    bn_integer("height", r->renderer.height);
    bn_integer("k", r->count);
    bn_integer("c", s->c);
    bn_integer("map_side", MAP_SIZE);
    bn_text("filter", names[s->filter]);
    bn_number("shadow_ms", s->best.shadow_ms);
    bn_number("light_ms", s->best.light_ms);
    bn_number("frames_s", 1e3 / (s->best.shadow_ms + s->best.light_ms));
    bn_end(options);
}

/* Rounds over all settings, and the best of each, so that a busy moment does not meet one alone. */
static int measure(const bn_options *options, rig *r, setting *settings, int count)
{
    int rounds = 3;
    glbk_result result = GLBK_OK;
    for (int i = 0; i < rounds * count && result == GLBK_OK; i++)
        result = try_setting(r, &settings[i % count], i < count);
    if (result != GLBK_OK)
        return bn_gl_failed(result);
    for (int i = 0; i < count; i++)
        write_row(options, r, &settings[i]);
    return 0;
}

static double total(const setting *s) { return s->best.shadow_ms + s->best.light_ms; }

/* Times of some sizes give the model, and it picks one of all; that one is measured beside the best of those. */
static int measure_cost(const bn_options *options, rig *r)
{
    enum { SIZES = 6 };
    setting settings[SIZES] = { { 2, 3, { 0, 0 } }, { 4, 3, { 0, 0 } }, { 8, 3, { 0, 0 } }, { 16, 3, { 0, 0 } },
                                { 32, 3, { 0, 0 } }, { 64, 3, { 0, 0 } } };
    setting pair[2];
    uint32_t sizes[SIZES], chosen;
    double ms[SIZES];
    int best = 0;
    envsh_cost cost;
    if (measure(options, r, settings, SIZES) != 0)
        return -1;
    for (int i = 0; i < SIZES; i++) {
        sizes[i] = settings[i].c;
        ms[i] = total(&settings[i]);
        best = ms[i] < ms[best] ? i : best;
    }
    if (!envsh_cost_fit(r->count, sizes, ms, SIZES, &cost))
        return bn_failed("gl_envshadow", "the times do not fit the model");
    chosen = envsh_cost_cluster(&cost, r->count, 64);
    pair[0] = pair[1] = settings[best];
    pair[1].c = chosen;
    if (chosen != pair[0].c && measure(options, r, pair, 2) != 0)
        return -1;
    bn_begin(options, "gl_envshadow_cost", options->threads, "none");
    write_rig(r);
    bn_integer("k", r->count);
    bn_number("pass_ms", cost.pass);
    bn_number("slot_ms", cost.slot);
    bn_integer("chosen_c", chosen);
    bn_number("chosen_ms", total(&pair[1]));
    bn_integer("best_c", pair[0].c);
    bn_number("best_ms", total(&pair[0]));
    bn_number("chosen_over_best", total(&pair[1]) / fmin(total(&pair[0]), total(&pair[1])));
    bn_end(options);
    return 0;
}

/* By compute where the context has it and core_only is 0; computes: was it so? The cost model needs one path. */
static int measure_model(const bn_options *options, const bn_model *model, int with_cost, int core_only, int *computes)
{
    /* The paper's Fig. 7: 64 lights, 8 a pass; 64 smoothed, 4 a pass; 192, 8 a pass. Then all of them at once. */
    setting few[] = { { 8, 0, { 0, 0 } }, { 4, 1, { 0, 0 } }, { 64, 3, { 0, 0 } } };
    setting many[] = { { 8, 0, { 0, 0 } }, { MOST_LIGHTS, 3, { 0, 0 } } };
    glbk_envsh_renderer_desc picture;
    glbk_gbuffer_desc size;
    glbk_result result;
    rig r;
    int status;
    memset(&r, 0, sizeof r);
    memset(&size, 0, sizeof size);
    status = bn_gl_open(&r.g, core_only);
    *computes = status == 0 && r.g.gl.compute;
    r.model = model;
    if (status == 0) {
        upload_model(&r);
        size.width = options->full ? 1920 : 421;
        size.height = options->full ? 1080 : 711;
        result = glbk_gbuffer_create(&r.g.gl, &size, &r.seen);
        picture.width = size.width;
        picture.height = size.height;
        if (result == GLBK_OK)
            result = glbk_envsh_renderer_create(&r.g.gl, &picture, &r.renderer);
        if (result == GLBK_OK)
            result = draw_gbuffer(&r);
        status = result == GLBK_OK ? make_views(&r, 64) : bn_gl_failed(result);
    }
    if (status == 0)
        status = measure(options, &r, few, 3);
    if (status == 0 && with_cost)
        status = measure_cost(options, &r);
    if (status == 0)
        status = make_views(&r, MOST_LIGHTS);
    if (status == 0)
        status = measure(options, &r, many, 2);
    close_rig(&r);
    return status;
}

int bn_gl_envshadow(const bn_options *options)
{
    static const char *const scenes[] = { "builtin:knot", "builtin:figure" };
    int result = 0, computes;
    for (int i = 0; i < 2 && result == 0; i++) {
        bn_model model;
        if (options->model && i)
            break;
        if (bn_model_load(&model, options->model ? options->model : scenes[i]) != 0)
            return -1;
        result = measure_model(options, &model, i == 0, 0, &computes);
        if (computes && result == 0)
            result = measure_model(options, &model, 0, 1, &computes);
        bn_model_free(&model);
    }
    return result;
}
