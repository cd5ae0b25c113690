/* gl_csm.c - csm on OpenGL: visibility queries, pictures and builds a second, on the core path and, where the context
   has 4.3, on the compute path. Times are the GPU's own, by timer queries, or round glFinish on software drivers; of
   builds what reads back is wall time. */
#define _POSIX_C_SOURCE 200809L
#include "bench.h"
#include "gl.h"
#include "../gl_backend/gl_csm.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void begin(const bn_options *options, const bn_gl *r, const char *bench)
{
    bn_begin(options, bench, options->threads, "none");
    bn_text("gl_renderer", r->gl.renderer);
    bn_text("path", r->gl.compute ? "compute" : "core");
    bn_text("clock", r->timer.by_query ? "query" : "finish");
}

static void random_direction(uint64_t *seed, float *d)
{
    float z = bn_random_in(seed, -1, 1), phi = bn_random_in(seed, 0, 6.2831853f), r = sqrtf(1 - z * z);
    d[0] = r * cosf(phi);
    d[1] = z;
    d[2] = r * sinf(phi);
}

static cohsm_maps *build_maps(const bn_options *options, const bn_model *model, uint32_t side, uint32_t m)
{
    cohsm_desc desc = bn_desc(options);
    cohsm_mesh mesh = bn_model_mesh(model);
    cohsm_maps *maps = NULL;
    desc.domain.side[0] = desc.domain.side[1] = side;
    desc.map_side = m;
    desc.layout = COHSM_LAYOUT_FAST;
    if (cohsm_build(&desc, &mesh, &maps, NULL) != COHSM_OK)
        bn_failed(model->name, "building failed");
    return maps;
}

static int upload(bn_gl *r, const cohsm_maps *maps, int fast, glbk_csm_maps *out)
{
    glbk_csm_block block;
    glbk_csm_instance one = { 0, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, 0 };
    glbk_result result;
    block.data = fast ? cohsm_fast_data(maps, &block.bytes) : cohsm_data(maps, &block.bytes);
    result = glbk_csm_maps_create(&r->gl, &block, 1, 1, &one.start, out);
    if (result == GLBK_OK)
        result = glbk_csm_maps_place(&r->gl, out, &one, 1);
    return result == GLBK_OK ? 0 : bn_gl_failed(result);
}

/* ---- queries ---- */

/* A picture with one sample a pixel; with --full as many as keep the GPU of a data centre at work. */
enum { WIDTH = 1024, HEIGHT = 256, FULL_HEIGHT = 4096 };

/* Points on the surface, a little off it; directions at random, or one for all. */
static void make_questions(const bn_model *model, int coherent, size_t count, float *items)
{
    uint64_t seed = 1;
    float common[3];
    random_direction(&seed, common);
    for (size_t i = 0; i < count; i++) {
        const uint32_t *t = model->indices + 3 * (size_t)(bn_random(&seed) % (uint32_t)model->triangles);
        float a = bn_random_in(&seed, 0, 1), b = bn_random_in(&seed, 0, 1), *q = items + 6 * i;
        if (a + b > 1) {
            a = 1 - a;
            b = 1 - b;
        }
        for (size_t k = 0; k < 3; k++)
            q[k] = model->positions[3 * (size_t)t[0] + k] * (1 - a - b) + model->positions[3 * (size_t)t[1] + k] * a +
                   model->positions[3 * (size_t)t[2] + k] * b;
        random_direction(&seed, q + 3);
        if (coherent)
            memcpy(q + 3, common, sizeof common);
    }
}

static double time_queries(bn_gl *r, glbk_csm_asker *asker, const glbk_csm_maps *maps, uint32_t count,
                           glbk_result *result)
{
    double best = HUGE_VAL, since;
    for (int run = 0; *result == GLBK_OK && bn_gl_goes_on(&r->gl, run, 3, &since); run++) {
        double t;
        ex_gl_timer_start(&r->timer);
        *result = glbk_csm_ask_run(&r->gl, asker, maps, count);
        t = ex_gl_timer_stop(&r->timer);
        if (run > 0 && t < best)                /* the first one compiles */
            best = t;
    }
    return best;
}

/* Reads the answers back and compares them with csm.h's own. Returns the mean of the differences, which rounding leaves
   about 0, or a negative number where either cannot be had. */
static double mean_difference(bn_gl *r, glbk_csm_asker *asker, const cohsm_query *query, const cohsm_maps *built)
{
    cohsm_instance one = { NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 } };
    const size_t count = query->count;
    float *visible = malloc(2 * count * sizeof *visible), *wanted = visible ? visible + count : NULL;
    double sum = 0;
    int ok = visible && glbk_csm_ask_read(&r->gl, asker, (uint32_t)count, visible) == GLBK_OK;
    one.maps = built;
    ok = ok && cohsm_visible_scene(&one, 1, query, wanted, NULL) == COHSM_OK;
    for (size_t i = 0; i < count && ok; i++)
        sum += fabs((double)visible[i] - (double)wanted[i]);
    free(visible);
    return ok ? sum / (double)count : -1;
}

/* What a row of queries is about. */
typedef struct asking {
    const bn_model *model;
    cohsm_info      info;
    int             fast;               /* the layout */
    size_t          bytes;              /* of the maps on the GPU */
    const cohsm_maps *built;
    cohsm_query     query;
    float          *items;              /* six a query: point and direction */
} asking;

/* Measures queries with one filter, at random or for one direction, and prints their row. */
static glbk_result measure_row(const bn_options *options, bn_gl *r, asking *a, glbk_csm_asker *asker,
                               const glbk_csm_maps *maps, int coherent)
{
    static const char *const filters[] = { "nearest", "pcf", "roulette" };
    const size_t count = a->query.count;
    double seconds, difference;
    glbk_result result;

    make_questions(a->model, coherent, count, a->items);
    result = glbk_csm_ask_upload(&r->gl, asker, &a->query);
    seconds = time_queries(r, asker, maps, (uint32_t)count, &result);
    if (result != GLBK_OK)
        return result;
    difference = mean_difference(r, asker, &a->query, a->built);
    if (difference < 0 || difference > 1e-3) {
        bn_failed("gl_csm_query", "the GPU's answers are not csm.h's");
        return GLBK_ERR_MISMATCH;
    }
    begin(options, r, "gl_csm_query");
    bn_text("model", a->model->name);
    bn_text("layout", a->fast ? "fast" : "compact");
    bn_integer("bytes", a->bytes);
    bn_text("mode", coherent ? "coherent" : "random");
    bn_text("filter", filters[a->query.filter]);
    bn_integer("map_count", a->info.map_count);
    bn_integer("map_side", a->info.map_side);
    bn_integer("width", WIDTH);
    bn_integer("height", count / WIDTH);
    bn_integer("samples", 1);
    bn_number("frame_ms", 1e3 * seconds);
    bn_number("msamples_s", (double)count / seconds * 1e-6);
    bn_number("mean_difference", difference);
    bn_end(options);
    return GLBK_OK;
}

static glbk_result measure_layout(const bn_options *options, bn_gl *r, asking *a)
{
    glbk_csm_asker asker;
    glbk_csm_maps maps;
    glbk_result result;

    memset(&asker, 0, sizeof asker);
    if (upload(r, a->built, a->fast, &maps) != 0)
        return GLBK_ERR_GL;
    (void)(a->fast ? cohsm_fast_data(a->built, &a->bytes) : cohsm_data(a->built, &a->bytes));
    result = glbk_csm_asker_create(&r->gl, (uint32_t)a->query.count, &asker);
    for (int i = 0; i < 6 && result == GLBK_OK; i++) {
        a->query.filter = (cohsm_filter)(i / 2);
        result = measure_row(options, r, a, &asker, &maps, i % 2);
    }
    glbk_csm_asker_free(&r->gl, &asker);
    glbk_csm_maps_free(&r->gl, &maps);
    return result;
}

static int measure_queries(const bn_options *options, bn_gl *r, const bn_model *model, const cohsm_maps *built)
{
    const size_t count = (size_t)WIDTH * (options->full ? FULL_HEIGHT : HEIGHT);
    uint32_t *entities = malloc(count * sizeof *entities);
    glbk_result result = GLBK_OK;
    asking a;

    memset(&a, 0, sizeof a);
    a.items = malloc(6 * count * sizeof *a.items);
    if (!a.items || !entities) {
        free(a.items);
        free(entities);
        return bn_failed("gl_csm_query", "out of memory");
    }
    for (size_t i = 0; i < count; i++)
        entities[i] = 1;
    a.model = model;
    a.built = built;
    cohsm_get_info(built, &a.info);
    a.query.count = count;
    a.query.positions = a.items;
    a.query.lights = a.items + 3;
    a.query.position_stride = a.query.light_stride = 6 * sizeof *a.items;
    a.query.entities = entities;
    a.query.seed = 1;
    for (a.fast = 0; a.fast < 2 && result == GLBK_OK; a.fast++)
        result = measure_layout(options, r, &a);
    if (result != GLBK_OK)
        bn_gl_failed(result);
    free(a.items);
    free(entities);
    return result == GLBK_OK ? 0 : -1;
}

/* ---- pictures: random points and normals for pixels, so that no cache is flattered ---- */

static int fill_gbuffer(bn_gl *r, glbk_gbuffer *seen, const bn_model *model)
{
    glbk_pixel *row = calloc(seen->width, sizeof *row);
    glbk_result result = row ? GLBK_OK : GLBK_ERR_ALLOC;
    uint64_t seed = 2;
    for (uint32_t y = 0; y < seen->height && result == GLBK_OK; y++) {
        for (uint32_t x = 0; x < seen->width; x++) {
            glbk_pixel *p = &row[x];
            const uint32_t *t = model->indices + 3 * (size_t)(bn_random(&seed) % (uint32_t)model->triangles);
            p->material.kind = LSAMP_MATERIAL_PHONG;
            p->entity = 1;
            p->material.exponent = 20;
            for (size_t k = 0; k < 3; k++) {
                p->position[k] = model->positions[3 * (size_t)t[0] + k];
                p->material.diffuse[k] = 0.8f;
                p->material.specular[k] = 0.2f;
            }
            random_direction(&seed, p->normal);
            memcpy(p->geometric_normal, p->normal, sizeof p->normal);
        }
        result = glbk_gbuffer_upload(&r->gl, seen, y, 1, row);
    }
    free(row);
    return result == GLBK_OK ? 0 : bn_gl_failed(result);
}

static int measure_render(const bn_options *options, bn_gl *r, const bn_model *model, const cohsm_maps *built)
{
    uint32_t samples[] = { 16, 64 }, wide = options->full ? 1024 : 256, high = options->full ? 768 : 192, start;
    ex_sky sky = { 0, 0, NULL, 0 };
    char error[EX_ERROR_SIZE];
    glbk_csm_maps maps;
    glbk_csm_lights lights;
    lsamp_light_desc light;
    glbk_csm_lights_desc all;
    glbk_csm_renderer renderer;
    glbk_csm_renderer_desc desc;
    glbk_gbuffer seen;
    glbk_gbuffer_desc sizes;
    cohsm_info info;
    glbk_result result = GLBK_OK;
    memset(&light, 0, sizeof light);
    memset(&all, 0, sizeof all);
    memset(&desc, 0, sizeof desc);
    memset(&sizes, 0, sizeof sizes);
    memset(&seen, 0, sizeof seen);
    if (ex_sky_builtin(&sky, "sky", error) != 0)
        return bn_failed("builtin:sky", error);
    light.kind = LSAMP_LIGHT_ENVIRONMENT;
    light.radiance[0] = light.radiance[1] = light.radiance[2] = 1;
    light.texels = sky.rgb;
    light.width = sky.width;
    light.height = sky.height;
    all.lights = &light;
    all.light_count = 1;
    desc.width = sizes.width = wide;
    desc.height = sizes.height = high;
    cohsm_get_info(built, &info);
    memset(&lights, 0, sizeof lights);
    memset(&renderer, 0, sizeof renderer);
    if (upload(r, built, 0, &maps) != 0 ||
        (result = glbk_csm_lights_create(&r->gl, &all, &start, &lights)) != GLBK_OK ||
        (result = glbk_csm_renderer_create(&r->gl, &desc, &renderer)) != GLBK_OK ||
        (result = glbk_gbuffer_create(&r->gl, &sizes, &seen)) != GLBK_OK || fill_gbuffer(r, &seen, model) != 0)
        result = GLBK_ERR_GL;
    for (int i = 0; i < 2 && result == GLBK_OK; i++) {
        glbk_csm_use use = { 0, LSAMP_LIGHT_ENVIRONMENT, NULL, COHSM_LIGHT_DIRECTION, 0, 0, { 0, 0, 0, 0 } };
        glbk_csm_frame_desc frame;
        double best = HUGE_VAL, since;
        memset(&frame, 0, sizeof frame);
        use.start = start;
        use.maps = &maps;
        use.sample_count = samples[i];
        frame.lights = &lights;
        frame.uses = &use;
        frame.use_count = 1;
        frame.eye[1] = 100;
        frame.bias = 1;
        for (int run = 0; result == GLBK_OK && bn_gl_goes_on(&r->gl, run, 4, &since); run++) {
            double t;
            frame.frame = (uint32_t)run;
            ex_gl_timer_start(&r->timer);
            result = glbk_csm_render(&r->gl, &renderer, &seen, &frame);
            t = ex_gl_timer_stop(&r->timer);
            if (run > 0 && t < best)
                best = t;
        }
        if (result != GLBK_OK)
            break;
        begin(options, r, "gl_csm_render");
        bn_text("model", model->name);
        bn_integer("width", wide);
        bn_integer("height", high);
        bn_integer("samples", samples[i]);
        bn_integer("map_count", info.map_count);
        bn_integer("map_side", info.map_side);
        bn_number("frame_ms", 1e3 * best);
        bn_number("msamples_s", (double)wide * high * samples[i] / best * 1e-6);
        bn_end(options);
    }
    if (result != GLBK_OK)
        bn_gl_failed(result);
    glbk_csm_renderer_free(&r->gl, &renderer);
    glbk_gbuffer_free(&r->gl, &seen);
    glbk_csm_lights_free(&r->gl, &lights);
    glbk_csm_maps_free(&r->gl, &maps);
    ex_sky_free(&sky);
    return result == GLBK_OK ? 0 : -1;
}

/* ---- builds ---- */

typedef struct object { cohsm_builder *views; uint32_t vertex_array, buffers[2]; int32_t indices; } object;

static void view_of(void *user, uint32_t index, cohsm_view *out)
{
    cohsm_builder_view(((object *)user)->views, index, out);
}

static void draw(void *user, glbk_context *gl)
{
    object *o = user;
    gl->gl.BindVertexArray(o->vertex_array);
    gl->gl.DrawElements(GLBK_GL_TRIANGLES, o->indices, GLBK_GL_UNSIGNED_INT, NULL);
}

static void upload_object(glbk_context *gl, const bn_model *model, object *o)
{
    gl->gl.GenVertexArrays(1, &o->vertex_array);
    gl->gl.GenBuffers(2, o->buffers);
    gl->gl.BindVertexArray(o->vertex_array);
    gl->gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, o->buffers[0]);
    gl->gl.BufferData(GLBK_GL_ARRAY_BUFFER, (ptrdiff_t)(12 * model->vertices), model->positions, GLBK_GL_STATIC_DRAW);
    gl->gl.BindBuffer(GLBK_GL_ELEMENT_ARRAY_BUFFER, o->buffers[1]);
    gl->gl.BufferData(GLBK_GL_ELEMENT_ARRAY_BUFFER, (ptrdiff_t)(12 * model->triangles), model->indices,
                      GLBK_GL_STATIC_DRAW);
    gl->gl.EnableVertexAttribArray(0);
    gl->gl.VertexAttribPointer(0, 3, GLBK_GL_FLOAT, 0, 0, NULL);
    o->indices = (int32_t)(3 * model->triangles);
}

/* Sizes that were asked for, else those of the issue where a GPU draws, and a small side on software drivers. */
static int measure_build(const bn_options *options, bn_gl *r, const bn_model *model)
{
    const int large = options->full || !ex_gl_is_software(r->gl.renderer);
    const uint32_t side = options->side ? options->side : large ? 128 : 24, m = options->m ? options->m : 128;
    cohsm_desc d = bn_desc(options);
    glbk_csm_builder_desc desc;
    glbk_csm_builder b;
    cohsm_builder *views = NULL;
    cohsm_maps *maps = NULL;
    cohsm_info info;
    object o;
    double raster = 0, compress = 0, pack, t;
    uint32_t n = side * side;
    glbk_result result;
    float square = 0;
    memset(&desc, 0, sizeof desc);
    for (int k = 0; k < 3; k++) {
        d.center[k] = 0.5f * (model->low[k] + model->high[k]);
        square += (model->high[k] - model->low[k]) * (model->high[k] - model->low[k]);
    }
    d.radius = 0.5f * sqrtf(square);
    d.domain.side[0] = d.domain.side[1] = side;
    d.order = COHSM_ORDER_ZIGZAG_THETA;
    d.map_side = m;
    if (cohsm_builder_create(&d, &views) != COHSM_OK)
        return bn_failed("gl_csm_build", "out of memory");
    o.views = views;
    upload_object(&r->gl, model, &o);
    desc.maps = &d;
    desc.view_fn = view_of;
    desc.draw_fn = draw;
    desc.user = &o;
    result = glbk_csm_builder_create(&r->gl, &desc, &b);
    for (uint32_t from = 0; from < n && result == GLBK_OK; from += b.batch) {
        ex_gl_timer_start(&r->timer);
        result = glbk_csm_builder_draw(&r->gl, &b, from, n - from < b.batch ? n - from : b.batch);
        raster += ex_gl_timer_stop(&r->timer);
        t = ex_seconds();
        if (result == GLBK_OK)
            result = glbk_csm_builder_compress(&r->gl, &b);
        compress += ex_seconds() - t;
    }
    t = ex_seconds();
    if (result == GLBK_OK) result = glbk_csm_builder_end(&r->gl, &b);
    if (result == GLBK_OK && (cohsm_builder_import(views, b.segments, b.segment_count) != COHSM_OK ||
                              cohsm_builder_finish(views, &maps, NULL) != COHSM_OK))
        result = GLBK_ERR_ALLOC;
    pack = ex_seconds() - t;
    if (result == GLBK_OK) {
        cohsm_get_info(maps, &info);
        begin(options, r, "gl_csm_build");
        bn_text("model", model->name);
        bn_integer("triangles", model->triangles);
        bn_integer("map_count", n);
        bn_integer("map_side", m);
        bn_number("raster_ms", 1e3 * raster);
        bn_number("compress_ms", 1e3 * compress);
        bn_number("pack_ms", 1e3 * pack);
        bn_integer("segments", info.segment_count);
        bn_integer("bytes", info.bytes);
        bn_end(options);
    } else
        bn_gl_failed(result);
    glbk_csm_builder_free(&r->gl, &b);
    r->gl.gl.DeleteVertexArrays(1, &o.vertex_array);
    r->gl.gl.DeleteBuffers(2, o.buffers);
    cohsm_free(maps);
    cohsm_builder_free(views);
    return result == GLBK_OK ? 0 : -1;
}

/* ---- what main.c calls ---- */

enum { QUERY, RENDER, BUILD };

static int measure_path(const bn_options *options, int what, int core_only, const bn_model *model,
                        const cohsm_maps *maps)
{
    bn_gl r;
    int result;
    if (bn_gl_open(&r, core_only) != 0)
        return -1;
    result = !core_only && !r.gl.compute ? 0
             : what == QUERY             ? measure_queries(options, &r, model, maps)
             : what == RENDER            ? measure_render(options, &r, model, maps)
                                         : measure_build(options, &r, model);
    bn_gl_close(&r);
    return result;
}

static int measure(const bn_options *options, int what)
{
    bn_model models[BN_MOST_MODELS];
    size_t count;
    int result = 0;
    if (bn_models_load(options, models, &count) != 0)
        return -1;
    for (size_t i = 0; i < count; i++) {
        cohsm_maps *maps = NULL;
        if (result == 0 && what != BUILD && !(maps = build_maps(options, &models[i], options->full ? 128 : 64, 128)))
            result = -1;
        for (int core_only = 1; core_only >= 0 && result == 0; core_only--)
            result = measure_path(options, what, core_only, &models[i], maps);
        cohsm_free(maps);
        bn_model_free(&models[i]);
    }
    return result;
}

int bn_gl_csm_query(const bn_options *options) { return measure(options, QUERY); }
int bn_gl_csm_render(const bn_options *options) { return measure(options, RENDER); }
int bn_gl_csm_build(const bn_options *options) { return measure(options, BUILD); }
