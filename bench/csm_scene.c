/* csm_scene.c - queries of a scene of many instances: trees that stand in a square field, at random turns and sizes,
   with points among them and segments or rays that meet the spheres of about ten of 1,024. What a query costs, and how
   many spheres its segment meets. */
#include "bench.h"
#include "gl.h"
#include "gl_backend/gl_csm.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COUNT = 65536, TRUTH = 1024, REPEATS = 5, MOST = 1024 };

typedef struct forest {
    cohsm_maps     *maps;
    cohsm_info      info;
    cohsm_instance *trees;
    uint32_t        count;
    float           side;                   /* of the field */
    float          *points, *lights, *visible;      /* lights: places, then directions */
    uint32_t       *entities;               /* an instance for 64 points each, which they are said to lie on */
} forest;

static void plant(forest *f, uint32_t count)
{
    uint64_t seed = 5;
    f->count = count;
    f->side = 85.0f * f->info.radius * sqrtf((float)count / 1024.0f);
    for (uint32_t i = 0; i < count; i++) {
        float *m = f->trees[i].transform, turn = bn_random_in(&seed, 0, 6.28f), size = bn_random_in(&seed, 0.7f, 1.3f);
        memset(m, 0, sizeof f->trees[i].transform);
        f->trees[i].maps = f->maps;
        m[0] = m[10] = size * cosf(turn);
        m[2] = -size * sinf(turn);
        m[8] = -m[2];
        m[5] = size;
        m[12] = bn_random_in(&seed, 0, f->side);
        m[14] = bn_random_in(&seed, 0, f->side);
        m[15] = 1;
    }
    for (size_t i = 0; i < COUNT; i++) {
        float *p = f->points + 3 * i, *to = f->lights + 3 * i, *d = to + 3 * (size_t)COUNT;
        float turn = bn_random_in(&seed, 0, 6.28f);
        f->entities[i] = 1 + (uint32_t)(i / 64) % count;
        p[0] = bn_random_in(&seed, 0, f->side);
        p[1] = bn_random_in(&seed, -0.9f, 0.9f) * f->info.radius;
        p[2] = bn_random_in(&seed, 0, f->side);
        to[0] = bn_random_in(&seed, 0, f->side);
        to[1] = bn_random_in(&seed, 1.2f, 1.6f) * f->info.radius;
        to[2] = bn_random_in(&seed, 0, f->side);
        d[0] = cosf(turn);
        d[1] = bn_random_in(&seed, 0, 0.015f);
        d[2] = sinf(turn);
    }
}

/* Spheres of instances that the rays or segments of some queries meet, for each of these. */
static double count_met(const forest *f, cohsm_light_kind kind)
{
    size_t met = 0;
    for (size_t i = 0; i < TRUTH; i++) {
        const float *p = f->points + 3 * i, *l = f->lights + 3 * i;
        for (uint32_t k = 0; k < f->count; k++) {
            const float *m = f->trees[k].transform, *c = f->info.center;
            double v2 = 0, d2 = 0, along = 0, t, r = (double)f->info.radius * (double)m[5];
            for (size_t j = 0; j < 3; j++) {
                double middle = (double)m[j] * (double)c[0] + (double)m[4 + j] * (double)c[1] +
                                (double)m[8 + j] * (double)c[2] + (double)m[12 + j];
                double v = middle - (double)p[j];
                double d = (double)(kind == COHSM_LIGHT_POSITION ? l[j] - p[j] : l[3 * (size_t)COUNT + j]);
                v2 += v * v;
                d2 += d * d;
                along += v * d;
            }
            t = fmax(along / d2, 0);
            if (kind == COHSM_LIGHT_POSITION)
                t = fmin(t, 1);
            met += v2 - 2 * t * along + t * t * d2 < r * r;
        }
    }
    return (double)met / TRUTH;
}

static cohsm_query query_of(const forest *f, cohsm_light_kind kind)
{
    cohsm_query q;
    memset(&q, 0, sizeof q);
    q.count = COUNT;
    q.positions = f->points;
    q.lights = kind == COHSM_LIGHT_POSITION ? f->lights : f->lights + 3 * (size_t)COUNT;
    q.light_kind = kind;
    return q;
}

enum { POSITIONS, DIRECTIONS, OF_ENTITIES, ONE_DIRECTION, WAYS };

static int measure(const bn_options *options, forest *f, const char *model, int way)
{
    static const char *const lights[WAYS] = { "positions", "directions", "directions, entities", "one direction" };
    const cohsm_light_kind kind = way == POSITIONS ? COHSM_LIGHT_POSITION : COHSM_LIGHT_DIRECTION;
    cohsm_query q = query_of(f, kind);
    double best = HUGE_VAL, dark = 0;
    q.one_light = way == ONE_DIRECTION;
    q.entities = way == OF_ENTITIES ? f->entities : NULL;
    for (int i = 0; i < REPEATS; i++) {
        double start = ex_seconds();
        if (cohsm_visible_scene(f->trees, f->count, &q, f->visible, NULL) != COHSM_OK)
            return bn_failed("csm_scene", "a query failed");
        best = fmin(best, ex_seconds() - start);
    }
    for (size_t i = 0; i < COUNT; i++)
        dark += f->visible[i] == 0;
    bn_begin(options, "csm_scene", 1, bn_simd());
    bn_text("model", model);
    bn_integer("instances", f->count);
    bn_text("light", lights[way]);
    bn_number("spheres_met", q.one_light ? HUGE_VAL : count_met(f, kind));
    bn_number("ns", 1e9 * best / COUNT);
    bn_number("dark", dark / COUNT);
    bn_end(options);
    return 0;
}

static int measure_forests(const bn_options *options, forest *f, const char *model)
{
    static const uint32_t counts[] = { 1, 16, 256, MOST };
    int result = 0;
    for (size_t i = 0; i < sizeof counts / sizeof counts[0] && result == 0; i++) {
        plant(f, counts[i]);
        for (int way = 0; way < WAYS && result == 0; way++)
            result = measure(options, f, model, way);
    }
    return result;
}

/* ---- the same on OpenGL ---- */

static void write_gl(const bn_options *options, const bn_gl *r, const forest *f, const char *model,
                     cohsm_light_kind kind, double seconds)
{
    bn_begin(options, "gl_csm_scene", options->threads, "none");
    bn_text("gl_renderer", r->gl.renderer);
    bn_text("path", r->gl.compute ? "compute" : "core");
    bn_text("clock", r->timer.by_query ? "query" : "finish");
    bn_text("model", model);
    bn_integer("instances", f->count);
    bn_text("light", kind == COHSM_LIGHT_POSITION ? "positions" : "directions");
    bn_number("spheres_met", count_met(f, kind));
    bn_number("ns", 1e9 * seconds / COUNT);
    bn_end(options);
}

static glbk_result ask(const bn_options *options, bn_gl *r, const forest *f, const char *model,
                       const glbk_csm_maps *maps, glbk_csm_asker *asker)
{
    glbk_result result = GLBK_OK;
    for (int k = 0; k < 2 && result == GLBK_OK; k++) {
        const cohsm_light_kind kind = k ? COHSM_LIGHT_DIRECTION : COHSM_LIGHT_POSITION;
        const cohsm_query q = query_of(f, kind);
        double best = HUGE_VAL, since;
        result = glbk_csm_ask_upload(&r->gl, asker, &q);
        for (int run = 0; result == GLBK_OK && bn_gl_goes_on(&r->gl, run, 3, &since); run++) {
            double t;
            ex_gl_timer_start(&r->timer);
            result = glbk_csm_ask_run(&r->gl, asker, maps, COUNT);
            t = ex_gl_timer_stop(&r->timer);
            if (run > 0)                        /* the first one compiles */
                best = fmin(best, t);
        }
        if (result == GLBK_OK)
            write_gl(options, r, f, model, kind, best);
    }
    return result;
}

static glbk_result place(bn_gl *r, const forest *f, uint32_t start, glbk_csm_maps *maps)
{
    glbk_csm_instance *trees = calloc(f->count, sizeof *trees);
    glbk_result result = GLBK_ERR_ALLOC;
    for (uint32_t i = 0; trees && i < f->count; i++) {
        trees[i].start = start;
        memcpy(trees[i].transform, f->trees[i].transform, sizeof trees[i].transform);
    }
    if (trees)
        result = glbk_csm_maps_place(&r->gl, maps, trees, f->count);
    free(trees);
    return result;
}

static int measure_gl(const bn_options *options, forest *f, const char *model, int core_only)
{
    glbk_csm_block block;
    glbk_csm_maps maps;
    glbk_csm_asker asker;
    glbk_result result;
    uint32_t start;
    bn_gl r;
    if (bn_gl_open(&r, core_only) != 0)
        return -1;
    memset(&asker, 0, sizeof asker);
    block.data = cohsm_fast_data(f->maps, &block.bytes);
    result = glbk_csm_maps_create(&r.gl, &block, 1, MOST, &start, &maps);
    if (result == GLBK_OK)
        result = glbk_csm_asker_create(&r.gl, COUNT, &asker);
    for (uint32_t count = 16; count <= MOST && result == GLBK_OK && r.gl.compute != core_only; count *= 8) {
        plant(f, count);
        result = place(&r, f, start, &maps);
        if (result == GLBK_OK)
            result = ask(options, &r, f, model, &maps, &asker);
    }
    glbk_csm_asker_free(&r.gl, &asker);
    glbk_csm_maps_free(&r.gl, &maps);
    bn_gl_close(&r);
    return result == GLBK_OK ? 0 : bn_gl_failed(result);
}

/* ---- what main.c calls ---- */

static int measure_scene(const bn_options *options, int on_gl)
{
    bn_model model;
    cohsm_desc d = bn_desc(options);
    cohsm_mesh mesh;
    forest f;
    int result;
    memset(&f, 0, sizeof f);
    if (bn_model_load(&model, options->model ? options->model : "builtin:plant") != 0)
        return -1;
    mesh = bn_model_mesh(&model);
    d.domain.kind = COHSM_DOMAIN_LATLONG;
    d.domain.side[0] = 128;
    d.domain.side[1] = 64;
    d.map_side = 128;
    d.layout = COHSM_LAYOUT_FAST;
    f.entities = malloc(COUNT * sizeof *f.entities);
    f.trees = malloc(MOST * sizeof *f.trees);
    f.points = malloc(10 * (size_t)COUNT * sizeof *f.points);
    f.lights = f.points ? f.points + 3 * (size_t)COUNT : NULL;
    f.visible = f.points ? f.points + 9 * (size_t)COUNT : NULL;
    if (!f.trees || !f.points || !f.entities || cohsm_build(&d, &mesh, &f.maps, NULL) != COHSM_OK) {
        result = bn_failed("csm_scene", "out of memory");
    } else {
        cohsm_get_info(f.maps, &f.info);
        result = on_gl ? measure_gl(options, &f, model.name, 1) : measure_forests(options, &f, model.name);
        if (on_gl && result == 0)
            result = measure_gl(options, &f, model.name, 0);
    }
    cohsm_free(f.maps);
    free(f.points);
    free(f.entities);
    free(f.trees);
    bn_model_free(&model);
    return result;
}

int bn_csm_scene(const bn_options *options) { return measure_scene(options, 0); }
int bn_gl_csm_scene(const bn_options *options) { return measure_scene(options, 1); }
