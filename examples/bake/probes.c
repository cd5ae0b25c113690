/* probes.c - bake probes: irradiance and visibility on a grid, or at given points. docs/probes.md describes the files,
   and probes.glsl reads them. */
#include "trace.h"
#include "glb.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const rd_key bk_probes_keys[] = {
    { "grid_x", RD_INTEGER, NULL, 1, 256, "8", "probes along x; --grid 8x4x8 sets all three" },
    { "grid_y", RD_INTEGER, NULL, 1, 256, "4", "along y" },
    { "grid_z", RD_INTEGER, NULL, 1, 256, "8", "along z" },
    { "bounces", RD_INTEGER, NULL, 0, 32, "1", "times that light is thrown back; the same as --bounces" },
    { "samples", RD_INTEGER, NULL, 1, 1048576, "1024", "paths a probe" },
    { "side", RD_INTEGER, NULL, 2, 16, "8", "texels a side of the octahedral map of distances" },
    { "rays", RD_INTEGER, NULL, 1, 1024, "16", "of each of these texels" },
    { "parts", RD_INTEGER, NULL, 0, 256, "0", "parts kept on the way, not of a shard; 0: about one a minute" },
    { NULL, RD_WORD, NULL, 0, 0, NULL, NULL }
};

enum { HARMONICS = 27 };

typedef struct probes {
    const bk_args *args;
    ex_scene  scene;
    bk_trace  trace;
    ex_pool  *pool;
    float    *points;                /* given ones, or NULL */
    uint32_t  grid[3];
    float     origin[3], step[3], far;   /* of the grid; what is further away than far counts as far */
    size_t    count, unit;
    uint32_t  side, rays, samples;
} probes;

typedef struct task { const probes *b; size_t from; float *out; } task;

/* ---- one probe ---- */

/* Radiance in harmonics of order 2, turned into irradiance by pi, 2 pi / 3 and pi / 4. */
static void take(void *user, rf_v3 d, rf_v3 light)
{
    static const double pi = 3.14159265358979323846;
    const double l[3] = { light.x, light.y, light.z };
    const double y[9] = { 0.28209479177387814 * pi,
                          0.4886025119029199 * d.y * (2 * pi / 3),
                          0.4886025119029199 * d.z * (2 * pi / 3),
                          0.4886025119029199 * d.x * (2 * pi / 3),
                          1.0925484305920792 * d.x * d.y * (pi / 4),
                          1.0925484305920792 * d.y * d.z * (pi / 4),
                          0.31539156525252005 * (3 * d.z * d.z - 1) * (pi / 4),
                          1.0925484305920792 * d.x * d.z * (pi / 4),
                          0.5462742152960396 * (d.x * d.x - d.y * d.y) * (pi / 4) };
    double *sum = user;
    for (int j = 0; j < 9; j++)
        for (int k = 0; k < 3; k++)
            sum[3 * j + k] += l[k] * y[j];
}

/* The direction of a point of the octahedral map, both coordinates from -1 to 1. */
static rf_v3 octahedral(double u, double v)
{
    const double z = 1 - fabs(u) - fabs(v), x = z >= 0 ? u : (1 - fabs(v)) * (u >= 0 ? 1 : -1);
    const double y = z >= 0 ? v : (1 - fabs(u)) * (v >= 0 ? 1 : -1);
    return rf_unit(rf_make(x, y, z));
}

/* Mean distance and mean square distance of each texel's rays. */
static void see(const probes *b, rf_v3 p, uint64_t seed, float *out)
{
    uint64_t state = bk_hash(BK_HASH, &seed, sizeof seed) + 1;
    for (uint32_t i = 0; i < b->side * b->side; i++) {
        double sum = 0, squares = 0;
        for (uint32_t k = 0; k < b->rays; k++) {
            const double u = 2 * (i % b->side + bk_random(&state)) / b->side - 1;
            const double v = 2 * (i / b->side + bk_random(&state)) / b->side - 1;
            rf_hit hit;
            double d = (double)b->far;
            if (rf_scene_trace(b->trace.scene, p, octahedral(u, v), 0, &hit))
                d = rf_least(d, hit.distance);
            sum += d;
            squares += d * d;
        }
        out[2 * i] = (float)(sum / b->rays);
        out[2 * i + 1] = (float)(squares / b->rays);
    }
}

static void place(const probes *b, size_t i, float *p)
{
    const size_t at[3] = { i % b->grid[0], i / b->grid[0] % b->grid[1], i / b->grid[0] / b->grid[1] };
    for (int k = 0; k < 3; k++)
        p[k] = b->points ? b->points[3 * i + (size_t)k] : b->origin[k] + b->step[k] * (float)at[k];
}

static void compute_one(void *context, size_t index)
{
    const task *t = context;
    double sum[HARMONICS] = { 0 };
    float p[3], *out = t->out + t->b->unit * index;
    place(t->b, t->from + index, p);
    bk_trace_light(&t->b->trace, rf_load(p), rf_make(0, 0, 0), t->b->samples, t->from + index, take, sum);
    for (int k = 0; k < HARMONICS; k++)
        out[k] = (float)sum[k];
    see(t->b, rf_load(p), t->from + index, out + HARMONICS);
}

static int compute(void *context, size_t from, size_t to, float *out, char *error)
{
    enum { BLOCK = 256 };
    static char label[] = "probes";
    probes *b = context;
    (void)error;
    for (size_t at = from; at < to; at += BLOCK) {
        task t = { b, at, out + b->unit * (at - from) };
        ex_pool_run(b->pool, to - at < BLOCK ? to - at : BLOCK, compute_one, &t);
        ex_progress(label, (float)(at - from) / (float)(to - from));
    }
    ex_progress(label, 1);
    return 0;
}

/* ---- where ---- */

/* Three numbers a line. */
static int read_points(probes *b, const char *path, char *error)
{
    size_t size, room = 0;
    char *text = ex_file_read(path, &size, error), *at, *end;
    char *grown = text ? realloc(text, size + 1) : NULL;
    int result = 0;
    if (!grown) {
        free(text);
        return text ? bk_fail(error, "out of memory", "") : -1;
    }
    grown[size] = 0;
    for (at = grown;; at = end) {
        const float x = strtof(at, &end);
        if (end == at)
            break;
        if (room == b->count) {
            float *more = realloc(b->points, (room = 2 * room + 300) * sizeof *more);
            if (!more) {
                result = bk_fail(error, "out of memory", "");
                break;
            }
            b->points = more;
        }
        if (!(fabsf(x) < 1e9f))
            result = bk_fail(error, "a number is too large in ", path);
        b->points[b->count++] = x;
    }
    at += strspn(at, " \t\r\n");
    if (result == 0 && (*at || !b->count || b->count % 3))
        result = bk_fail(error, "not three numbers a point: ", path);
    b->count /= 3;
    free(grown);
    return result;
}

/* The middles of the cells that the scene's box is cut into. */
static int make_grid(probes *b, char *error)
{
    float low[3] = { HUGE_VALF, HUGE_VALF, HUGE_VALF }, high[3] = { -HUGE_VALF, -HUGE_VALF, -HUGE_VALF }, diagonal = 0;
    for (uint32_t i = 0; i < b->scene.object_count; i++) {
        const ex_object *o = &b->scene.objects[i];
        const ex_mesh *mesh = &b->scene.meshes[o->mesh];
        for (size_t v = 0; v < mesh->vertex_count && !o->receiver_only; v++)
            for (int k = 0; k < 3; k++) {
                const float *m = o->transform, *p = mesh->positions + 3 * v;
                const float x = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
                low[k] = fminf(low[k], x);
                high[k] = fmaxf(high[k], x);
            }
    }
    for (int k = 0; k < 3; k++) {
        static const char *const names[] = { "grid_x", "grid_y", "grid_z" };
        b->grid[k] = (uint32_t)rd_setting_integer(&b->args->settings, names[k]);
        b->step[k] = (high[k] - low[k]) / (float)b->grid[k];
        b->origin[k] = low[k] + 0.5f * b->step[k];
        diagonal += b->points ? (high[k] - low[k]) * (high[k] - low[k]) : 2.25f * b->step[k] * b->step[k];
    }
    b->far = sqrtf(diagonal);
    if (!b->points)
        b->count = (size_t)b->grid[0] * b->grid[1] * b->grid[2];
    return b->far > 0 ? 0 : bk_fail(error, "the scene is empty", "");
}

/* ---- files ---- */

/* The floats, little-endian, in a file whose name has their hash: a .json that is there keeps its own. */
static int write_floats(const probes *b, const float *values, char *name, size_t room, char *error)
{
    const size_t floats = b->count * b->unit;
    uint8_t *bytes = malloc(4 * floats + 1);
    int result;
    if (!bytes)
        return bk_fail(error, "out of memory", "");
    for (size_t i = 0; i < floats; i++) {
        uint32_t word;
        memcpy(&word, &values[i], sizeof word);
        for (size_t k = 0; k < 4; k++)
            bytes[4 * i + k] = (uint8_t)(word >> (8 * k));
    }
    snprintf(name, room, "%s.%08lx.bin", b->args->out,
             (unsigned long)(bk_hash(BK_HASH, bytes, 4 * floats) & 0xffffffffu));
    result = bk_write(name, bytes, 4 * floats, error);
    free(bytes);
    return result;
}

static int write_files(const probes *b, const float *values, char *error)
{
    char name[1100];
    const char *base;
    bk_text text = { NULL, 0, 0, 0 };
    int result;
    if (strlen(b->args->out) > 1000)
        return bk_fail(error, "too long a name", "");
    if (write_floats(b, values, name, sizeof name, error) != 0)
        return -1;
    base = strrchr(name, '/') ? strrchr(name, '/') + 1 : name;
    bk_text_add(&text,
                "{\"probes\":{\"count\":%llu,\"floats\":%llu,\"harmonics\":9,\"side\":%u,\"far\":%.9g,\"bin\":\"%s\"",
                (unsigned long long)b->count, (unsigned long long)b->unit, (unsigned)b->side, (double)b->far, base);
    if (!b->points)
        bk_text_add(&text, ",\"grid\":[%u,%u,%u],\"origin\":[%.9g,%.9g,%.9g],\"step\":[%.9g,%.9g,%.9g]",
                    (unsigned)b->grid[0], (unsigned)b->grid[1], (unsigned)b->grid[2], (double)b->origin[0],
                    (double)b->origin[1], (double)b->origin[2], (double)b->step[0], (double)b->step[1],
                    (double)b->step[2]);
    bk_text_add(&text, ",\"positions\":[");
    for (size_t i = 0; i < b->count; i++) {
        float p[3];
        place(b, i, p);
        bk_text_add(&text, "%s[%.9g,%.9g,%.9g]", i ? "," : "", (double)p[0], (double)p[1], (double)p[2]);
    }
    bk_text_add(&text, "]}}\n");
    result = text.failed ? bk_fail(error, "out of memory", "") : bk_write(b->args->out, text.bytes, text.size, error);
    free(text.bytes);
    return result;
}

static int bake(probes *b, char *error)
{
    const rd_settings *s = &b->args->settings;
    bk_items items;
    float *values;
    int result;
    if ((b->args->points && read_points(b, b->args->points, error) != 0) || make_grid(b, error) != 0 ||
        bk_trace_open(&b->trace, b->args, &b->scene, error) != 0)
        return -1;
    memset(&items, 0, sizeof items);
    b->trace.bounces = rd_setting_integer(s, "bounces");
    b->samples = (uint32_t)rd_setting_integer(s, "samples");
    b->side = (uint32_t)rd_setting_integer(s, "side");
    b->rays = (uint32_t)rd_setting_integer(s, "rays");
    b->unit = HARMONICS + 2 * (size_t)b->side * b->side;
    items.count = b->count;
    items.unit = b->unit;
    items.key = bk_hash_settings(BK_HASH, b->args);
    for (uint32_t i = 0; i < b->scene.mesh_count; i++)
        items.key = bk_hash(items.key, b->scene.meshes[i].positions, 12 * (size_t)b->scene.meshes[i].vertex_count);
    items.key = bk_hash(items.key, b->points, b->points ? 12 * b->count : 0);
    items.seconds = 1e-6 * (double)items.count * (2.0 * b->samples + (double)b->side * b->side * b->rays);
    items.context = b;
    items.compute = compute;
    if (bk_items_run(b->args, &items, &values, error) != 0)
        return -1;
    result = values ? write_files(b, values, error) : 0;
    free(values);
    if (result == 0)
        bk_items_done(b->args, &items);
    return result;
}

int bk_probes_run(const bk_args *args, char *error)
{
    const char *path = args->files[0];
    probes b;
    int result;
    memset(&b, 0, sizeof b);
    b.args = args;
    if (!rf_scene_version())
        return bk_fail(error, "bake probes needs Embree: apt-get install libembree-dev", "");
    if ((strncmp(path, "builtin:", 8) ? ex_scene_load(&b.scene, path, error)
                                      : ex_scene_builtin(&b.scene, path + 8, 0, error)) != 0)
        return -1;
    b.pool = ex_pool_create(args->threads);
    result = b.pool ? bake(&b, error) : bk_fail(error, "no threads", "");
    bk_trace_close(&b.trace);
    ex_pool_free(b.pool);
    ex_scene_free(&b.scene);
    free(b.points);
    return result;
}
