/* ao.c - bake ao: ambient occlusion and bent normals into a .glb file, whose other bytes stay. */
#include "ask.h"
#include "model.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

const rd_key bk_ao_keys[] = {
    { "into", RD_WORD, "auto|vertex|texture", 0, 0, "auto", "COLOR_0, or images; auto: images where UVs do not overlap" },
    { "bent", RD_WORD, "0|1", 0, 0, "0", "1: bent normals too, as _BENT_NORMAL or extras.bentNormalTexture" },
    { "side", RD_INTEGER, NULL, 4, 256, "32", "side x side directions of the sphere" },
    { "map_side", RD_INTEGER, NULL, 4, 1024, "128", "csm: pixels a side of a map" },
    { "engine", RD_WORD, "auto|csm|embree", 0, 0, "auto", "the same as --engine" },
    { "distance", RD_NUMBER, "0", 1e-9, 1e9, "0", "embree: what is further away does not shade; 0: everything does" },
    { "ground", RD_NUMBER, "none|auto", -1e9, 1e9, "none", "height of a plane that shades from below; auto: lowest point" },
    { "instances", RD_WORD, "mean|self", 0, 0, "mean", "of a mesh's objects: their mean, or what it hides from itself" },
    { "colors", RD_WORD, "multiply|replace", 0, 0, "multiply", "COLOR_0 that is there already" },
    { "bits", RD_WORD, "8|16", 0, 0, "8", "of a colour's or a pixel's channel" },
    { "image_side", RD_INTEGER, NULL, 16, 8192, "1024", "texels a side of an image" },
    { "dilate", RD_INTEGER, NULL, 0, 64, "8", "texels that charts grow by, against seams" },
    { "denoise", RD_INTEGER, NULL, 0, 6, "0", "passes of gifilter.h's filter over an image" },
    { "parts", RD_INTEGER, NULL, 0, 256, "0", "parts kept on the way, not of a shard; 0: about one a minute" },
    { NULL, RD_WORD, NULL, 0, 0, NULL, NULL }
};

enum { READ, TRY, BUILD, ASK, WRITE, STEPS };

typedef struct ao {
    const bk_args *args;
    bk_model   model;
    bk_ask    *ask;                  /* opened when something is computed */
    ex_pool   *pool;
    size_t     unit;                 /* 1, or 4 with bent normals */
    double     step[STEPS], since;   /* seconds of the processor, all threads together; the last step ended at since */
    double     apart;                /* maps from rays in the mean, as try_out has found; -1: not tried */
} ao;

static void end_step(ao *b, int step)
{
    const double now = (double)clock() / CLOCKS_PER_SEC;
    b->step[step] += now - b->since;
    b->since = now;
}

/* Sums of points first.. of a call of bk_ask_all: of the cosines, of the visible ones, and of visible directions. */
typedef struct sums { double *all, *seen; float *bent; } sums;

static void take(void *user, const bk_answer *a)
{
    sums *s = user;
    for (size_t i = 0; i < a->count; i++) {
        const uint32_t p = a->points[i];
        const float lit = a->cosines[i] * a->visible[i];
        s->all[p] += (double)a->cosines[i];
        s->seen[p] += (double)lit;
        for (int k = 0; s->bent && k < 3; k++)
            s->bent[3 * (size_t)p + (size_t)k] += lit * a->direction[k];
    }
}

/* Occlusion of one receiver. */
static int compute_one(ao *b, bk_ask *ask, size_t i, double *value, char *error)
{
    const bk_receivers *r = &b->model.receivers;
    double all = 0, seen = 0;
    sums sum = { &all, &seen, NULL };
    uint32_t sheet = 0;
    while (r->sheets[sheet].first + r->sheets[sheet].count <= i)
        sheet++;
    if (bk_ask_all(ask, r->sheets[sheet].mesh, r->positions, r->normals, i, i + 1, take, &sum, error) != 0)
        return -1;
    *value = all > 0 ? seen / all : 1;
    return 0;
}

enum { TRIES = 256, TRY_SIDE = 8 };

/* Occlusion of up to TRIES receivers, of fewer where many objects share a mesh: how many, or -1. */
static int sample(ao *b, bk_ask *ask, double *values, char *error)
{
    const size_t count = b->model.receivers.count, objects = b->model.scene.object_count;
    size_t tries = objects <= 64 ? TRIES : objects < 1024 ? TRIES * 64 / objects : 16;
    tries = tries < count ? tries : count;
    for (size_t i = 0; i < tries; i++)
        if (compute_one(b, ask, (size_t)((double)count * ((double)i + 0.5) / (double)tries), &values[i], error) != 0)
            return -1;
    return (int)tries;
}

/* Which way promises to be faster: of rays that are open with TRY_SIDE x TRY_SIDE directions, by what they answer. */
static bk_engine foresee(const ao *b, const bk_ask *rays, uint32_t side, const double *values, int count, char *error)
{
    const bk_receivers *r = &b->model.receivers;
    size_t *points = calloc((size_t)b->model.scene.mesh_count + 1, sizeof *points);
    bk_engine engine = BK_ENGINE_AUTO;
    double open = 0;
    for (uint32_t i = 0; i < r->sheet_count && points; i++)
        points[r->sheets[i].mesh] += r->sheets[i].count;
    for (int i = 0; i < count; i++)
        open += values[i] / count;
    if (points)
        engine = bk_ask_cheaper(rays, side, points, open);
    else bk_fail(error, "out of memory", "");
    free(points);
    return engine;
}

/* Where maps promise to be faster, both are tried out: if they differ by more than 0.016 in the mean, which is about
   0.01 with 1,024 directions, as they do where things are thinner than a pixel of a map, rays are taken. They become
   b->ask then, as do maps of no more directions than were tried; else it stays NULL. */
static int try_out(ao *b, const bk_ask_desc *desc, char *error)
{
    double by_rays[TRIES], by_maps[TRIES];
    bk_engine engine = BK_ENGINE_AUTO;
    bk_ask_desc d = *desc;
    bk_ask *rays = NULL, *maps = NULL;
    int count = -1, result;
    d.engine = BK_ENGINE_EMBREE;
    d.side = desc->side < TRY_SIDE ? desc->side : TRY_SIDE;
    if (bk_ask_open(&rays, &d, &b->model.scene, b->pool, error) == 0)
        count = sample(b, rays, by_rays, error);
    if (count >= 0)
        engine = foresee(b, rays, desc->side, by_rays, count, error);
    result = engine == BK_ENGINE_AUTO ? -1 : 0;
    if (engine == BK_ENGINE_CSM) {
        d.engine = BK_ENGINE_CSM;
        result = bk_ask_open(&maps, &d, &b->model.scene, b->pool, error);
        if (result == 0)
            result = sample(b, maps, by_maps, error) < 0 ? -1 : 0;
        b->apart = 0;
        for (int i = 0; i < count && result == 0; i++)
            b->apart += fabs(by_rays[i] - by_maps[i]) / count;
        if (b->apart > 0.016)
            engine = BK_ENGINE_EMBREE;
    }
    if (result == 0 && engine == BK_ENGINE_EMBREE) {
        result = bk_ask_turn(rays, desc->side, error);
        b->ask = rays;
        rays = NULL;
    } else if (result == 0 && d.side == desc->side) {
        b->ask = maps;
        maps = NULL;
    }
    bk_ask_close(rays);
    bk_ask_close(maps);
    return result;
}

static int open_ask(ao *b, char *error)
{
    const rd_settings *s = &b->args->settings;
    const char *ground = rd_setting_text(s, "ground");
    bk_ask_desc d;
    memset(&d, 0, sizeof d);
    d.engine = rd_setting_is(s, "engine", "csm")      ? BK_ENGINE_CSM
               : rd_setting_is(s, "engine", "embree") ? BK_ENGINE_EMBREE
                                                      : BK_ENGINE_AUTO;
    d.side = (uint32_t)rd_setting_integer(s, "side");
    d.map_side = (uint32_t)rd_setting_integer(s, "map_side");
    d.distance = (float)rd_setting_number(s, "distance");
    d.self_only = rd_setting_is(s, "instances", "self");
    d.has_ground = strcmp(ground, "none") != 0;
    if (d.has_ground)
        d.ground = strcmp(ground, "auto") ? (float)rd_setting_number(s, "ground") : bk_model_lowest(&b->model);
    if (d.engine == BK_ENGINE_AUTO && !d.self_only && !(d.distance > 0) && bk_rays_there() &&
        try_out(b, &d, error) != 0)
        return -1;
    end_step(b, TRY);
    if (!b->ask && bk_ask_open(&b->ask, &d, &b->model.scene, b->pool, error) != 0)
        return -1;
    end_step(b, BUILD);
    return 0;
}

/* Points from..to - 1, all of one sheet. */
static int compute_some(ao *b, const bk_sheet *s, size_t from, size_t to, float *out, char *error)
{
    const bk_receivers *r = &b->model.receivers;
    const size_t count = to - from;
    sums sum = { calloc(count, sizeof *sum.all), calloc(count, sizeof *sum.seen),
                 b->unit > 1 ? calloc(3 * count, sizeof *sum.bent) : NULL };
    int result = -1;
    if (!sum.all || !sum.seen || (b->unit > 1 && !sum.bent))
        bk_fail(error, "out of memory", "");
    else result = bk_ask_all(b->ask, s->mesh, r->positions, r->normals, from, to, take, &sum, error);
    for (size_t i = 0; i < count && result == 0; i++) {
        float *to_value = out + i * b->unit;
        to_value[0] = sum.all[i] > 0 ? (float)(sum.seen[i] / sum.all[i]) : 1;
        for (size_t k = 1; k < b->unit; k++)
            to_value[k] = sum.bent[3 * i + k - 1];
        if (b->unit > 1)
            bk_unit_or(to_value + 1, r->normals + 3 * (from + i));
    }
    free(sum.all);
    free(sum.seen);
    free(sum.bent);
    return result;
}

static int compute(void *context, size_t from, size_t to, float *out, char *error)
{
    enum { BLOCK = 1 << 15 };
    static char label[] = "ambient occlusion";
    ao *b = context;
    const bk_receivers *r = &b->model.receivers;
    end_step(b, READ);
    if (!b->ask && open_ask(b, error) != 0)
        return -1;
    for (uint32_t i = 0; i < r->sheet_count; i++) {
        const bk_sheet *s = &r->sheets[i];
        const size_t low = s->first > from ? s->first : from, end = s->first + s->count, high = end < to ? end : to;
        for (size_t at = low; at < high; at += BLOCK) {
            const size_t last = high - at < BLOCK ? high : at + BLOCK;
            if (compute_some(b, s, at, last, out + (at - from) * b->unit, error) != 0)
                return -1;
            ex_progress(label, (float)(last - from) / (float)(to - from));
        }
    }
    end_step(b, ASK);
    return 0;
}

/* What goes into the file, of a sheet: channel 0 multiplies colours, the bent normal stands beside. */
static int write_sheet(ao *b, const bk_sheet *s, const float *values, char *error)
{
    const rd_settings *set = &b->args->settings;
    const int bits = rd_setting_integer(set, "bits");
    float *value = malloc((s->count + 1) * sizeof *value), *bent = NULL;
    int result = value ? 0 : bk_fail(error, "out of memory", "");
    for (size_t i = 0; i < s->count && value; i++)
        value[i] = values[(s->first + i) * b->unit];
    if (result == 0 && b->unit > 1) {
        bent = malloc((3 * s->count + 1) * sizeof *bent);
        for (size_t i = 0; i < s->count && bent; i++)
            memcpy(bent + 3 * i, values + (s->first + i) * b->unit + 1, 12);
        result = bent ? 0 : bk_fail(error, "out of memory", "");
    }
    if (result == 0 && !s->side) {
        bk_model_colors(&b->model, s, value, 1, bits, rd_setting_is(set, "colors", "replace"));
        if (bent)
            bk_model_vectors(&b->model, s, "_BENT_NORMAL", bent);
    } else if (result == 0) {
        const bk_image_desc d = { bits, rd_setting_integer(set, "dilate"), rd_setting_integer(set, "denoise"),
                                  BK_PNG, 0 };
        result = bk_model_image(&b->model, s, "occlusionTexture", value, 1, &d, error);
        if (bent && result == 0)
            result = bk_model_image(&b->model, s, "bentNormalTexture", bent, 3, &d, error);
        if (result == 0)
            result = bk_model_materials(&b->model, s, error);
    }
    free(value);
    free(bent);
    return result;
}

/* --report: which way was taken, and what each step of it has cost. */
static int report(const ao *b, char *error)
{
    static const char *const names[STEPS] = { "read", "try", "build", "ask", "write" };
    const int side = rd_setting_integer(&b->args->settings, "side");
    char text[768], apart[32] = "null";
    size_t n;
    if (!b->args->report)
        return 0;
    if (b->apart >= 0)
        snprintf(apart, sizeof apart, "%.6f", b->apart);
    n = (size_t)snprintf(text, sizeof text, "{\"engine\": \"%s\", \"receivers\": %lu, \"directions\": %d, "
                         "\"maps_from_rays\": %s, \"threads\": %d",
                         !b->ask ? "none" : bk_ask_engine(b->ask) == BK_ENGINE_CSM ? "csm" : "embree",
                         (unsigned long)b->model.receivers.count, side * side, apart, ex_pool_threads(b->pool));
    for (int i = 0; i < STEPS; i++)
        n += (size_t)snprintf(text + n, sizeof text - n, ", \"%s_s\": %.4f", names[i], b->step[i]);
    n += (size_t)snprintf(text + n, sizeof text - n, "}\n");
    return bk_write(b->args->report, text, n, error);
}

static int bake(ao *b, char *error)
{
    const bk_args *args = b->args;
    bk_items items;
    float *values;
    memset(&items, 0, sizeof items);
    b->unit = rd_setting_is(&args->settings, "bent", "1") ? 4 : 1;
    items.count = b->model.receivers.count;
    items.unit = b->unit;
    items.key = bk_hash_settings(bk_hash(BK_HASH, b->model.glb.data, b->model.glb.size), args);
    items.seconds = 60e-9 * (double)items.count * pow(rd_setting_number(&args->settings, "side"), 2) / 2;
    items.context = b;
    items.compute = compute;
    if (bk_items_run(args, &items, &values, error) != 0)
        return -1;
    if (!values) {
        end_step(b, WRITE);
        return report(b, error);
    }
    for (uint32_t i = 0; i < b->model.receivers.sheet_count; i++)
        if (write_sheet(b, &b->model.receivers.sheets[i], values, error) != 0) {
            free(values);
            return -1;
        }
    free(values);
    if (bk_model_write(&b->model, args->out, error) != 0)
        return -1;
    bk_items_done(args, &items);
    end_step(b, WRITE);
    return report(b, error);
}

int bk_ao_run(const bk_args *args, char *error)
{
    const rd_settings *s = &args->settings;
    const bk_into into = rd_setting_is(s, "into", "vertex")    ? BK_INTO_VERTEX
                         : rd_setting_is(s, "into", "texture") ? BK_INTO_TEXTURE
                                                               : BK_INTO_AUTO;
    ao b;
    int result;
    memset(&b, 0, sizeof b);
    b.args = args;
    b.apart = -1;
    if (bk_model_open(&b.model, args->files[0], into, (uint32_t)rd_setting_integer(s, "image_side"), error) != 0)
        return -1;
    b.pool = ex_pool_create(args->threads);
    result = b.pool ? bake(&b, error) : bk_fail(error, "no threads", "");
    bk_ask_close(b.ask);
    ex_pool_free(b.pool);
    bk_model_close(&b.model);
    return result;
}
