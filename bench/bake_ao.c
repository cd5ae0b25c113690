/* bake_ao.c - `bake ao` by maps of csm.h and by Embree's rays, the program itself, run as a user would: seconds of the
   processor of the whole process, reading and writing too, by turns in one run; and the mean error of the vertices'
   colours against brute force: 4,096 rays about the normal of each of some vertices, cosine-weighted, their
   directions its own. Models: bunny, dragon, kitchen, and 1,000 stones. */
#define _POSIX_C_SOURCE 200809L
#include "bench.h"
#include "stones.h"
#include "../examples/bake/bake.h"
#include "../examples/bake/receive.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { ENGINES = 3, STEPS = 5, GRID = 64, LEAST_GRID = 8, SIDES = 4 };

#define MOST_SECONDS 20.0            /* of all runs of a row and its like; at least one each */

static const char *const engines[ENGINES] = { "csm", "embree", "auto" };
static const char *const steps[STEPS] = { "read_s", "build_s", "try_s", "ask_s", "write_s" };

typedef struct files { char folder[64], model[96], out[96], report[96]; } files;

typedef struct figures { double cpu, step[STEPS], receivers, error, worst; char taken[16]; } figures;

typedef struct truth {               /* of some vertices, spread over all that triangles use */
    ex_scene      scene;
    bk_primitives primitives;
    bn_rays      *rays;
    uint32_t     *primitive, *vertex;
    double       *open;              /* share of the hemisphere that is, weighted by the cosine */
    float        *extent;            /* half the diagonal of each mesh */
    size_t        count;
} truth;

/* ---- brute force ---- */

static void cross(const float *a, const float *b, float *out)
{
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void unit(float *v)
{
    const float length = sqrtf(dot(v, v));
    for (int k = 0; k < 3; k++)
        v[k] /= length > 0 ? length : 1;
}

/* A vertex as the object stands, and three axes there: the last is its normal. */
static void place(const float *m, const float *p, const float *n, float *at, float axes[3][3])
{
    float cofactor[3][3];
    for (int k = 0; k < 3; k++) {
        cross(m + 4 * ((k + 1) % 3), m + 4 * ((k + 2) % 3), cofactor[k]);
        at[k] = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
    }
    for (int k = 0; k < 3; k++)
        axes[2][k] = n[0] * cofactor[0][k] + n[1] * cofactor[1][k] + n[2] * cofactor[2][k];
    unit(axes[2]);
    for (int k = 0; k < 3 && dot(cofactor[0], m) < 0; k++)
        axes[2][k] = -axes[2][k];
    cross(axes[2], (const float[3]){ fabsf(axes[2][0]) < 0.6f, fabsf(axes[2][0]) >= 0.6f, 0 }, axes[0]);
    unit(axes[0]);
    cross(axes[2], axes[0], axes[1]);
}

/* The share of side x side rays, one in each cell of the disc below the hemisphere, that nothing is in the way of. */
static double trace(const truth *t, const float *from, float axes[3][3], int side, uint64_t *seed)
{
    float points[3 * GRID], directions[3 * GRID], lit[GRID];
    double sum = 0;
    for (int y = 0; y < side; y++) {
        for (int x = 0; x < side; x++) {
            const float share = ((float)y + bn_random_in(seed, 0, 1)) / (float)side, r = sqrtf(share);
            const float turn = 6.2831853f * ((float)x + bn_random_in(seed, 0, 1)) / (float)side;
            const float local[3] = { r * cosf(turn), r * sinf(turn), sqrtf(fmaxf(1 - share, 1e-6f)) };
            for (int k = 0; k < 3; k++) {
                points[3 * x + k] = from[k];
                directions[3 * x + k] = local[0] * axes[0][k] + local[1] * axes[1][k] + local[2] * axes[2][k];
            }
        }
        bn_rays_trace(t->rays, BN_RAY1, 0, points, directions, (size_t)side, lit);
        for (int x = 0; x < side; x++)
            sum += (double)lit[x];
    }
    return sum / (side * side);
}

/* One vertex: the mean of its mesh's objects, which share the rays. */
static void open_at(void *context, size_t i)
{
    truth *t = context;
    const bk_primitive *p = &t->primitives.list[t->primitives.list[t->primitive[i]].owner];
    uint64_t seed = 0x9e3779b97f4a7c15u * (i + 1);
    uint32_t objects = 0;
    int side;
    for (uint32_t k = 0; k < t->scene.object_count; k++)
        objects += t->scene.objects[k].mesh == p->mesh;
    side = (int)ceil(GRID / sqrt(objects));
    side = side < LEAST_GRID ? LEAST_GRID : side;
    for (uint32_t k = 0; k < t->scene.object_count; k++) {
        const float *m = t->scene.objects[k].transform;
        float at[3], axes[3][3];
        const float off = 1e-4f * t->extent[p->mesh] * cbrtf(fabsf(m[0] * (m[5] * m[10] - m[6] * m[9]) -
            m[4] * (m[1] * m[10] - m[2] * m[9]) + m[8] * (m[1] * m[6] - m[2] * m[5])));
        if (t->scene.objects[k].mesh != p->mesh)
            continue;
        place(m, p->positions + 3 * (size_t)t->vertex[i], p->normals + 3 * (size_t)t->vertex[i], at, axes);
        for (int j = 0; j < 3; j++)
            at[j] += off * axes[2][j];
        t->open[i] += trace(t, at, axes, side, &seed) / objects;
    }
}

static void truth_free(truth *t)
{
    ex_scene_free(&t->scene);
    bk_primitives_free(&t->primitives);
    if (t->rays)
        bn_rays_free(t->rays);
    free(t->primitive);
    free(t->vertex);
    free(t->open);
    free(t->extent);
}

static int is_shown(const ex_scene *scene, uint32_t mesh)
{
    for (uint32_t i = 0; i < scene->object_count; i++)
        if (scene->objects[i].mesh == mesh)
            return 1;
    return 0;
}

/* Which vertices: every so many of those that are used. */
static int choose_vertices(truth *t, size_t wanted)
{
    size_t all = 0, at = 0;
    for (int pass = 0; pass < 2; pass++) {
        at = 0;
        for (uint32_t i = 0; i < t->primitives.count; i++) {
            const bk_primitive *p = &t->primitives.list[i];
            for (uint32_t v = 0; p->owner == i && v < p->vertex_count && is_shown(&t->scene, p->mesh); v++) {
                if (!p->used[v])
                    continue;
                if (pass && at * t->count / all != (at + 1) * t->count / all) {
                    t->primitive[at * t->count / all] = i;
                    t->vertex[at * t->count / all] = v;
                }
                at++;
            }
        }
        if (pass)
            continue;
        all = at;
        t->count = all < wanted ? all : wanted;
        t->primitive = calloc(t->count + 1, sizeof *t->primitive);
        t->vertex = calloc(t->count + 1, sizeof *t->vertex);
        t->open = calloc(t->count + 1, sizeof *t->open);
        if (!all || !t->primitive || !t->vertex || !t->open)
            return -1;
    }
    return 0;
}

static int find_extents(truth *t)
{
    t->extent = calloc((size_t)t->scene.mesh_count + 1, sizeof *t->extent);
    for (uint32_t i = 0; i < t->scene.mesh_count && t->extent; i++) {
        const ex_mesh *m = &t->scene.meshes[i];
        float low[3] = { HUGE_VALF, HUGE_VALF, HUGE_VALF }, high[3] = { -HUGE_VALF, -HUGE_VALF, -HUGE_VALF };
        for (size_t v = 0; v < 3 * (size_t)m->vertex_count; v++) {
            low[v % 3] = fminf(low[v % 3], m->positions[v]);
            high[v % 3] = fmaxf(high[v % 3], m->positions[v]);
        }
        for (int k = 0; k < 3; k++)
            high[k] -= low[k];
        t->extent[i] = m->vertex_count ? 0.5f * sqrtf(dot(high, high)) : 0;
    }
    return t->extent ? 0 : -1;
}

static int find_truth(const bn_options *options, const char *path, truth *t, bn_model *flat)
{
    char error[EX_ERROR_SIZE];
    memset(t, 0, sizeof *t);
    if (ex_scene_load(&t->scene, path, error) != 0 || bk_primitives_read(&t->primitives, path, error) != 0) {
        truth_free(t);
        return bn_failed(path, error);
    }
    if (bn_model_flatten(flat, &t->scene, t->scene.object_count) != 0 ||
        choose_vertices(t, options->full ? 4096 : 512) != 0 || find_extents(t) != 0) {
        bn_model_free(flat);
        truth_free(t);
        return bn_failed(path, "out of memory, or no vertices");
    }
    t->rays = bn_rays_create(flat, options->threads);
    if (t->rays)
        ex_pool_run(options->pool, t->count, open_at, t);
    return 0;
}

/* The colours of the file against the truth. */
static int compare(const truth *t, const char *path, figures *f)
{
    bk_primitives baked;
    char error[EX_ERROR_SIZE];
    f->error = t->rays ? 0 : HUGE_VAL;
    f->worst = f->error;
    if (bk_primitives_read(&baked, path, error) != 0)
        return bn_failed(path, error);
    for (size_t i = 0; i < t->count && t->rays; i++) {
        const bk_primitive *p = &baked.list[baked.list[t->primitive[i]].owner];
        const double apart = p->colors ? fabs((double)p->colors[4 * (size_t)t->vertex[i]] - t->open[i]) : 1;
        f->error += apart / (double)t->count;
        f->worst = fmax(f->worst, apart);
    }
    bk_primitives_free(&baked);
    return 0;
}

/* ---- the program ---- */

static int bake(const bn_options *options, const char *program, const files *f, const char *model, const char *engine,
                uint32_t side, figures *best)
{
    char threads[16], set_side[16];
    const char *const arguments[] = { program, "ao", model, "-o", f->out, "--engine", engine, "--threads", threads,
        "--report", f->report, "--set", "into=vertex", "--set", "colors=replace", "--set", "bits=16", "--set", set_side,
        NULL };
    double cpu;
    snprintf(threads, sizeof threads, "%d", options->threads);
    snprintf(set_side, sizeof set_side, "side=%u", (unsigned)side);
    if (bn_start(program, arguments, &cpu) != 0)
        return bn_failed(program, "bake ao failed");
    if (cpu >= best->cpu)
        return 0;
    best->cpu = cpu;
    for (int i = 0; i < STEPS; i++)
        best->step[i] = bn_read_number(f->report, steps[i]);
    best->receivers = bn_read_number(f->report, "receivers");
    bn_read_text(f->report, "engine", best->taken, sizeof best->taken);
    return 0;
}

static void print(const bn_options *options, const char *name, const truth *t, const bn_model *flat, uint32_t side,
                  const figures *all, int engine)
{
    const figures *f = &all[engine];
    bn_begin(options, "bake_ao", options->threads, bn_simd());
    bn_text("model", name);
    bn_text("embree", bn_rays_version());
    bn_integer("objects", t->scene.object_count);
    bn_integer("triangles", flat->triangles);
    bn_number("receivers", f->receivers);
    bn_integer("directions", (uint64_t)side * side);
    bn_text("engine", engines[engine]);
    bn_text("taken", f->taken);
    bn_number("cpu_s", f->cpu);
    for (int i = 0; i < STEPS; i++)
        bn_number(steps[i], f->step[i]);
    bn_number("of_embree", f->cpu / all[1].cpu);
    bn_number("mean_error", f->error);
    bn_number("worst_error", f->worst);
    bn_end(options);
}

static int measure_side(const bn_options *options, const char *program, const files *f, const char *model,
                        const char *name, const truth *t, const bn_model *flat, uint32_t side)
{
    figures best[ENGINES];
    const int count = bn_rays_version() ? ENGINES : 1;
    double spent = 0;
    for (int e = 0; e < ENGINES; e++)
        best[e].cpu = HUGE_VAL;
    for (int round = 0; round < (options->full ? 5 : 3) && spent * (round + 1) <= MOST_SECONDS * round; round++)
        for (int e = 0; e < count; e++) {
            if (bake(options, program, f, model, engines[e], side, &best[e]) != 0 ||
                compare(t, f->out, &best[e]) != 0)
                return -1;
            spent += best[e].cpu;
        }
    for (int e = 0; e < count; e++)
        print(options, name, t, flat, side, best, e);
    return 0;
}

static int measure(const bn_options *options, const char *program, const files *f, const char *model, const char *name)
{
    static const uint32_t sides[SIDES] = { 8, 16, 32, 64 };
    truth t;
    bn_model flat;
    int result = find_truth(options, model, &t, &flat);
    if (result != 0)
        return -1;
    for (int i = 0; i < (options->full ? SIDES : SIDES - 1) && result == 0; i++)
        if (!options->side || i == 0)
            result = measure_side(options, program, f, model, name, &t, &flat,
                                  options->side ? options->side : sides[i]);
    truth_free(&t);
    bn_model_free(&flat);
    return result;
}

/* A scene's .glb: its own file, or what `bake model` makes of a built-in one, or the stones. */
static int measure_scene(const bn_options *options, const char *program, const files *f, const char *scene)
{
    const char *slash = strrchr(scene, '/'), *name = slash ? slash + 1 : scene;
    char short_name[64];
    if (strcmp(scene, "stones") == 0) {
        if (bn_stones_write(f->model) != 0)
            return -1;
        return measure(options, program, f, f->model, "stones");
    }
    if (strncmp(scene, "builtin:", 8) == 0) {
        const char *const arguments[] = { program, "model", scene, "-o", f->model, NULL };
        return bn_start(program, arguments, NULL) != 0 ? bn_failed(program, "bake model failed")
                                                       : measure(options, program, f, f->model, scene + 8);
    }
    snprintf(short_name, sizeof short_name, "%.*s", (int)strcspn(name, "."), name);
    return measure(options, program, f, scene, short_name);
}

int bn_bake_ao(const bn_options *options)
{
    static const char *const assets[3] = { "bunny.glb", "dragon.glb", "kitchen.glb" };
    static const char *const made[3] = { "builtin:knot", "builtin:plant", "builtin:atrium" };
    char program[1024], path[1024];
    files f;
    int result = 0;
    bn_program(options, "bake", program);
    snprintf(f.folder, sizeof f.folder, "/tmp/dapple-bench-XXXXXX");
    if (!mkdtemp(f.folder))
        return bn_failed("/tmp", "no room for temporary files");
    snprintf(f.model, sizeof f.model, "%s/model.glb", f.folder);
    snprintf(f.out, sizeof f.out, "%s/out.glb", f.folder);
    snprintf(f.report, sizeof f.report, "%s/report.json", f.folder);
    if (options->model)
        result = measure_scene(options, program, &f, options->model);
    for (int i = 0; i < 4 && !options->model && result == 0; i++) {
        const char *scene = i == 3 ? "stones" : bn_asset(options, assets[i], NULL, path);
        result = measure_scene(options, program, &f, scene ? scene : made[i]);
    }
    remove(f.model);
    remove(f.out);
    remove(f.report);
    rmdir(f.folder);
    return result;
}
