/* light.c - bake light: irradiance of sky, lamps and emissive surfaces, with bounces, into a model. */
#include "model.h"
#include "trace.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const rd_key bk_light_keys[] = {
    { "into", RD_WORD, "auto|vertex|texture", 0, 0, "auto", "COLOR_0, or light maps; auto: maps where UVs allow it" },
    { "bounces", RD_INTEGER, NULL, 0, 32, "1", "times that light is thrown back; the same as --bounces" },
    { "samples", RD_INTEGER, NULL, 1, 1048576, "256", "paths a point" },
    { "directional", RD_WORD, "0|1", 0, 0, "0", "1: radiance too, as harmonics of order 1: _SH0 to _SH3, or four more maps" },
    { "maps", RD_WORD, "png|rgbe|hdr|exr", 0, 0, "png", "light maps: in the file, cut at 1 or with an exponent; beside it" },
    { "ev", RD_NUMBER, "auto", -100, 100, "auto", "colours and maps=png are 2^ev times irradiance over pi, cut at 1" },
    { "colors", RD_WORD, "multiply|replace", 0, 0, "multiply", "COLOR_0 that is there already" },
    { "bits", RD_WORD, "8|16|32", 0, 0, "16", "of a colour's or a pixel's channel; 32 is of maps=exr, which has no 8" },
    { "image_side", RD_INTEGER, NULL, 16, 8192, "512", "texels a side of a light map" },
    { "dilate", RD_INTEGER, NULL, 0, 64, "8", "texels that charts grow by, against seams" },
    { "parts", RD_INTEGER, NULL, 0, 256, "0", "parts kept on the way, not of a shard; 0: about one a minute" },
    { NULL, RD_WORD, NULL, 0, 0, NULL, NULL }
};

enum { UNIT = 15 };                  /* irradiance, and radiance as 4 harmonics of 3 channels */

typedef struct light {
    const bk_args *args;
    bk_model  model;
    bk_trace  trace;
    int       is_open;
    ex_pool  *pool;
    uint32_t  samples;
} light;

typedef struct task { light *b; size_t from; float *out; } task;
typedef struct point { rf_v3 normal; double sum[UNIT]; } point;

static void take(void *user, rf_v3 d, rf_v3 value)
{
    point *p = user;
    const double l[3] = { value.x, value.y, value.z }, cosine = rf_most(rf_dot(p->normal, d), 0);
    const double y[4] = { 0.28209479177387814, 0.4886025119029199 * d.y, 0.4886025119029199 * d.z,
                          0.4886025119029199 * d.x };
    for (int k = 0; k < 3; k++) {
        p->sum[k] += l[k] * cosine;
        for (int j = 0; j < 4; j++)
            p->sum[3 + 3 * j + k] += l[k] * y[j];
    }
}

/* A receiver in the world, as the object of its mesh that comes first in the scene stands. */
static void place(const light *b, size_t i, rf_v3 *position, rf_v3 *normal)
{
    const bk_receivers *r = &b->model.receivers;
    const float *m = NULL, *p = r->positions + 3 * i, *n = r->normals + 3 * i;
    rf_v3 x, y, z;
    uint32_t sheet = 0;
    while (r->sheets[sheet].first + r->sheets[sheet].count <= i)
        sheet++;
    for (uint32_t k = b->model.scene.object_count; k-- > 0;)
        if (b->model.scene.objects[k].mesh == r->sheets[sheet].mesh)
            m = b->model.scene.objects[k].transform;
    x = rf_load(m), y = rf_load(m + 4), z = rf_load(m + 8);
    *position = rf_add(rf_from_frame(x, y, z, rf_load(p)), rf_load(m + 12));
    *normal = rf_unit(rf_from_frame(rf_cross(y, z), rf_cross(z, x), rf_cross(x, y), rf_load(n)));
    if (rf_dot(rf_cross(x, y), z) < 0)
        *normal = rf_scale(*normal, -1);
}

static void compute_one(void *context, size_t index)
{
    const task *t = context;
    const light *b = t->b;
    point p;
    rf_v3 position;
    memset(&p, 0, sizeof p);
    place(b, t->from + index, &position, &p.normal);
    bk_trace_light(&b->trace, rf_mad(position, p.normal, b->trace.epsilon), p.normal, b->samples, t->from + index, take,
                   &p);
    for (int k = 0; k < UNIT; k++)
        t->out[UNIT * index + (size_t)k] = (float)p.sum[k];
}

static int compute(void *context, size_t from, size_t to, float *out, char *error)
{
    enum { BLOCK = 4096 };
    static char label[] = "light";
    light *b = context;
    if (!b->is_open && bk_trace_open(&b->trace, b->args, &b->model.scene, error) != 0)
        return -1;
    b->is_open = 1;
    b->trace.bounces = rd_setting_integer(&b->args->settings, "bounces");
    for (size_t at = from; at < to; at += BLOCK) {
        task t = { b, at, out + UNIT * (at - from) };
        ex_pool_run(b->pool, to - at < BLOCK ? to - at : BLOCK, compute_one, &t);
        ex_progress(label, (float)(at - from) / (float)(to - from));
    }
    ex_progress(label, 1);
    return 0;
}

/* ---- into the file ---- */

static int by_value(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* The factor on irradiance: of 98 points in a hundred the largest channel stays below 0.9. */
static float scale_of(const light *b, const float *values)
{
    const size_t count = b->model.receivers.count;
    float *most, scale = 0.31830989f;
    if (!rd_setting_is(&b->args->settings, "ev", "auto"))
        return scale * exp2f((float)rd_setting_number(&b->args->settings, "ev"));
    most = malloc((count + 1) * sizeof *most);
    for (size_t i = 0; i < count && most; i++)
        most[i] = fmaxf(values[UNIT * i], fmaxf(values[UNIT * i + 1], values[UNIT * i + 2]));
    if (most)
        qsort(most, count, sizeof *most, by_value);
    if (most && most[count * 98 / 100] > 0)
        scale = 0.9f / most[count * 98 / 100];
    free(most);
    return scale;
}

static int write_vertices(light *b, const bk_sheet *s, const float *values, float scale, float *some)
{
    const rd_settings *set = &b->args->settings;
    const int bits = rd_setting_integer(set, "bits");
    for (int j = 0; j < (rd_setting_is(set, "directional", "1") ? 5 : 1); j++) {
        char name[24] = "_IRRADIANCE";
        for (size_t i = 0; i < s->count; i++)
            memcpy(some + 3 * i, values + UNIT * (s->first + i) + 3 * (size_t)j, 12);
        if (j)
            snprintf(name, sizeof name, "_SH%d", j - 1);
        bk_model_vectors(&b->model, s, name, some);
    }
    for (size_t i = 0; i < 3 * s->count; i++)
        some[i] = values[UNIT * (s->first + i / 3) + i % 3] * scale;
    bk_model_colors(&b->model, s, some, 3, bits > 16 ? 16 : bits, rd_setting_is(set, "colors", "replace"));
    return 0;
}

/* Irradiance, or harmonic j - 1 of radiance; those of order 1 as half their share of the most that harmonic 0 allows,
   above 1/2, so that they are 0 to 1 in every format. */
static float texel_of(const float *value, int j, int k)
{
    const float most = 1.7320508f * value[3 + k];
    if (j < 2)
        return value[3 * j + k];
    return most > 0 ? fminf(fmaxf(0.5f + 0.5f * value[3 * j + k] / most, 0), 1) : 0.5f;
}

static int write_maps(light *b, const bk_sheet *s, const float *values, float scale, float *some, char *error)
{
    const rd_settings *set = &b->args->settings;
    const int directional = rd_setting_is(set, "directional", "1");
    const bk_format format = rd_setting_is(set, "maps", "rgbe")  ? BK_RGBE
                             : rd_setting_is(set, "maps", "hdr") ? BK_HDR
                             : rd_setting_is(set, "maps", "exr") ? BK_EXR
                                                                 : BK_PNG;
    int result = 0;
    for (int j = 0; j < (directional ? 5 : 1) && result == 0; j++) {
        const float times = j > 1 || format != BK_PNG ? 1 : j ? 0.5f * scale : scale;
        const bk_image_desc d = { rd_setting_integer(set, "bits"), rd_setting_integer(set, "dilate"), 0, format,
                                  j > 1 ? 0 : 1 / times };
        char name[40] = "lightMapTexture";
        for (size_t i = 0; i < 3 * s->count; i++) {
            const float x = times * texel_of(values + UNIT * (s->first + i / 3), j, (int)(i % 3));
            some[i] = format == BK_PNG ? fminf(x, 1) : x;
        }
        if (j)
            snprintf(name, sizeof name, "lightMapSH%dTexture", j - 1);
        result = bk_model_map(&b->model, s, name, some, &d, b->args->out, error);
    }
    return result == 0 ? bk_model_materials(&b->model, s, error) : result;
}

static int write_sheet(light *b, const bk_sheet *s, const float *values, float scale, char *error)
{
    float *some = malloc((3 * s->count + 1) * sizeof *some);
    int result = some ? s->side ? write_maps(b, s, values, scale, some, error)
                                : write_vertices(b, s, values, scale, some)
                      : bk_fail(error, "out of memory", "");
    free(some);
    return result;
}

static int bake(light *b, char *error)
{
    bk_items items;
    float *values, scale;
    int result = 0;
    memset(&items, 0, sizeof items);
    b->samples = (uint32_t)rd_setting_integer(&b->args->settings, "samples");
    items.count = b->model.receivers.count;
    items.unit = UNIT;
    items.key = bk_hash_settings(bk_hash(BK_HASH, b->model.glb.data, b->model.glb.size), b->args);
    items.seconds = 2e-6 * (double)items.count * b->samples;
    items.context = b;
    items.compute = compute;
    if (bk_items_run(b->args, &items, &values, error) != 0)
        return -1;
    if (!values)
        return 0;
    scale = scale_of(b, values);
    for (uint32_t i = 0; i < b->model.receivers.sheet_count && result == 0; i++)
        result = write_sheet(b, &b->model.receivers.sheets[i], values, scale, error);
    free(values);
    if (result == 0)
        result = bk_model_write(&b->model, b->args->out, error);
    if (result == 0)
        bk_items_done(b->args, &items);
    return result;
}

int bk_light_run(const bk_args *args, char *error)
{
    const rd_settings *s = &args->settings;
    const bk_into into = rd_setting_is(s, "into", "vertex")    ? BK_INTO_VERTEX
                         : rd_setting_is(s, "into", "texture") ? BK_INTO_TEXTURE
                                                               : BK_INTO_AUTO;
    light b;
    int result;
    memset(&b, 0, sizeof b);
    b.args = args;
    if (!rf_scene_version())
        return bk_fail(error, "bake light needs Embree: apt-get install libembree-dev", "");
    if (rd_setting_is(s, "bits", "32") && !rd_setting_is(s, "maps", "exr"))
        return bk_fail(error, "bits=32 is of maps=exr", "");
    if (rd_setting_is(s, "bits", "8") && rd_setting_is(s, "maps", "exr"))
        return bk_fail(error, "maps=exr has 16 or 32 bits", "");
    if (bk_model_open(&b.model, args->files[0], into, (uint32_t)rd_setting_integer(s, "image_side"), error) != 0)
        return -1;
    b.pool = ex_pool_create(args->threads);
    result = b.pool ? bake(&b, error) : bk_fail(error, "no threads", "");
    bk_trace_close(&b.trace);
    ex_pool_free(b.pool);
    bk_model_close(&b.model);
    return result;
}
