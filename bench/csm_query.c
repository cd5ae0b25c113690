/* csm_query.c - queries a second and their errors beside Embree's occlusion rays, on the same points and directions in
   the same run: area-weighted random points, 1e-4 of the bounding radius off the surface. "random" is one direction of
   the hemisphere for each point; "coherent" is points in Morton order, of which 1024 neighbours share a direction and
   those that face away from it are left out: they ask by that direction, by the number of its map, or from vertices
   that lie 32 bytes apart. */
#include "bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 128, GROUP = 1024, CHUNK = 16384, REPEATS = 5, STRIDE = 32 };

#define MOST_SECONDS 3.0         /* of repeats */

typedef struct rays {            /* and the exact answers */
    float  *points, *directions, *lit;
    size_t *groups;              /* coherent: where each group of one direction begins; groups[group_count] = count */
    size_t  count, group_count;
} rays;

/* ---- random points ---- */

static double random_unit(uint64_t *state)       /* xorshift64*, 53 bits */
{
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return (double)(*state * 0x2545f4914f6cdd1du >> 11) / 9007199254740992.0;
}

typedef struct sample { float p[3], n[3]; uint32_t key, number; } sample;

static uint32_t morton(const bn_model *model, const float *p)
{
    uint32_t key = 0;
    for (int k = 0; k < 3; k++) {
        float x = (p[k] - model->low[k]) / fmaxf(model->high[k] - model->low[k], 1e-30f);
        uint32_t cell = x > 0 ? x < 1 ? (uint32_t)(x * 1023) : 1023 : 0;
        for (int bit = 0; bit < 10; bit++)
            key |= (cell >> bit & 1) << (3 * bit + k);
    }
    return key;
}

static int by_key(const void *a, const void *b)
{
    const sample *x = a, *y = b;
    if (x->key != y->key)
        return x->key < y->key ? -1 : 1;
    return x->number < y->number ? -1 : x->number > y->number;
}

static void corners(const bn_model *model, size_t triangle, const float *v[3])
{
    for (size_t i = 0; i < 3; i++)
        v[i] = model->positions + 3 * (size_t)model->indices[3 * triangle + i];
}

/* Twice the area; n is its normal, not yet of unit length. */
static double normal_of(const float *v[3], double n[3])
{
    for (int k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        n[k] = ((double)v[1][i] - (double)v[0][i]) * ((double)v[2][j] - (double)v[0][j]) -
               ((double)v[1][j] - (double)v[0][j]) * ((double)v[2][i] - (double)v[0][i]);
    }
    return sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
}

static float radius_of(const bn_model *model)
{
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        double d = (double)model->high[k] - (double)model->low[k];
        sum += d * d;
    }
    return (float)(0.5 * sqrt(sum));
}

static sample *make_samples(const bn_model *model, size_t count)
{
    double *sums = malloc((model->triangles + 1) * sizeof *sums);
    sample *samples = malloc((count + 1) * sizeof *samples);
    float off = 1e-4f * radius_of(model);
    uint64_t state = 0x9e3779b97f4a7c15u;
    if (!sums || !samples) {
        free(sums);
        free(samples);
        return NULL;
    }
    sums[0] = 0;
    for (size_t i = 0; i < model->triangles; i++) {
        const float *v[3];
        double n[3];
        corners(model, i, v);
        sums[i + 1] = sums[i] + normal_of(v, n);
    }
    for (size_t i = 0; i < count; i++) {
        double x = random_unit(&state) * sums[model->triangles], n[3], length, a, b;
        size_t low = 0, high = model->triangles - 1;
        const float *v[3];
        while (low < high) {
            size_t middle = (low + high) / 2;
            if (sums[middle + 1] > x)
                high = middle;
            else
                low = middle + 1;
        }
        corners(model, low, v);
        length = normal_of(v, n);
        a = 1 - sqrt(random_unit(&state));
        b = (1 - a) * random_unit(&state);
        for (int k = 0; k < 3; k++) {
            samples[i].n[k] = (float)(length > 0 ? n[k] / length : 0);
            samples[i].p[k] = (float)((double)v[0][k] + a * ((double)v[1][k] - (double)v[0][k]) +
                                      b * ((double)v[2][k] - (double)v[0][k])) + off * samples[i].n[k];
        }
        samples[i].key = morton(model, samples[i].p);
        samples[i].number = (uint32_t)i;
    }
    free(sums);
    return samples;
}

static void sphere_direction(uint64_t *state, float d[3])
{
    double z = 1 - 2 * random_unit(state), phi = 6.283185307179586 * random_unit(state), r = sqrt(1 - z * z);
    d[0] = (float)(r * cos(phi));
    d[1] = (float)(r * sin(phi));
    d[2] = (float)z;
}

static void rays_free(rays *r)
{
    free(r->points);
    free(r->directions);
    free(r->lit);
    free(r->groups);
    memset(r, 0, sizeof *r);
}

static int rays_alloc(rays *r, size_t count)
{
    memset(r, 0, sizeof *r);
    r->points = malloc(3 * count * sizeof *r->points);
    r->directions = malloc(3 * count * sizeof *r->directions);
    r->lit = malloc(count * sizeof *r->lit);
    r->groups = calloc(count / GROUP + 2, sizeof *r->groups);
    if (r->points && r->directions && r->lit && r->groups)
        return 0;
    rays_free(r);
    return bn_failed("csm_query", "out of memory");
}

static void add_ray(rays *r, const sample *s, const float *d)
{
    memcpy(r->points + 3 * r->count, s->p, sizeof s->p);
    memcpy(r->directions + 3 * r->count, d, sizeof s->p);
    r->count++;
}

static float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void make_random(rays *r, const sample *samples, size_t count)
{
    uint64_t state = 0xd1b54a32d192ed03u;
    for (size_t i = 0; i < count; i++) {
        float d[3];
        sphere_direction(&state, d);
        if (dot(d, samples[i].n) < 0) {
            d[0] = -d[0], d[1] = -d[1], d[2] = -d[2];
        }
        add_ray(r, &samples[i], d);
    }
}

static void make_coherent(rays *r, sample *samples, size_t count)
{
    uint64_t state = 0xaef17502108ef2d9u;
    qsort(samples, count, sizeof *samples, by_key);
    for (size_t first = 0; first < count; first += GROUP) {
        float d[3];
        sphere_direction(&state, d);
        for (size_t i = first; i < first + GROUP && i < count; i++)
            if (dot(samples[i].n, d) > 0)
                add_ray(r, &samples[i], d);
        if (r->count > r->groups[r->group_count])
            r->groups[++r->group_count] = r->count;
    }
}

/* ---- one measurement ---- */

typedef struct work {
    const rays      *rays;
    const bn_rays   *tracer;     /* NULL: maps */
    bn_ray_mode      mode;
    const cohsm_maps *maps;
    const bn_scalar *scalar;     /* NULL: maps */
    cohsm_filter     filter;
    float            bias;
    int              one_light;
    float           *lit;
    int              failed;
    const uint32_t  *maps_asked; /* coherent: the number of each group's map, or NULL: directions */
    const float     *vertices;   /* STRIDE bytes apart, or NULL: packed */
} work;

static void query(work *w, size_t first, size_t count, int one_light, const uint32_t *map)
{
    cohsm_query q = { 0 };
    cohsm_result result;
    q.positions = w->rays->points + 3 * first;
    q.lights = w->rays->directions + 3 * first;
    q.count = count;
    q.one_light = one_light;
    if (w->vertices) {
        q.positions = w->vertices + STRIDE / 4 * first;
        q.position_stride = STRIDE;
    }
    if (map) {
        q.lights = map;
        q.light_kind = COHSM_LIGHT_INDEX;
    }
    q.filter = w->filter;
    q.bias = w->bias > 0 ? w->bias : -1;
    q.seed = (uint32_t)first;
    result = w->scalar ? bn_scalar_visible(w->scalar, &q, w->lit + first)
                       : cohsm_visible(w->maps, &q, w->lit + first, NULL);
    if (result != COHSM_OK)
        w->failed = 1;
}

static void do_chunk(void *context, size_t index)
{
    work *w = context;
    size_t first = index * CHUNK, count = w->rays->count - first < CHUNK ? w->rays->count - first : CHUNK;
    if (w->tracer)
        w->failed |= !bn_rays_trace(w->tracer, w->mode, w->rays->group_count > 0, w->rays->points + 3 * first,
                                    w->rays->directions + 3 * first, count, w->lit + first);
    else
        query(w, first, count, 0, NULL);
}

static void do_group(void *context, size_t index)
{
    work *w = context;
    query(w, w->rays->groups[index], w->rays->groups[index + 1] - w->rays->groups[index], 1,
          w->maps_asked ? w->maps_asked + index : NULL);
}

/* Million rays or queries a second, the best of some runs. */
static double speed(work *w, ex_pool *pool)
{
    size_t tasks = w->one_light ? w->rays->group_count : (w->rays->count + CHUNK - 1) / CHUNK;
    double best = HUGE_VAL, begin = ex_seconds();
    for (int i = 0; i < REPEATS && !w->failed && (i == 0 || ex_seconds() - begin < MOST_SECONDS); i++) {
        double start = ex_seconds();
        ex_pool_run(pool, tasks, w->one_light ? do_group : do_chunk, w);
        start = ex_seconds() - start;
        best = start < best ? start : best;
    }
    return w->failed ? -1 : (double)w->rays->count / best * 1e-6;
}

/* By threads - 1. Of tinybvh, -1 where it is not built in; agreement: the share of its answers that are Embree's. */
typedef struct peer { double mrays[2]; const char *mode[2]; double tinybvh[2], agreement; } peer;

static double agreement(const rays *r, const float *lit)
{
    size_t alike = 0;
    for (size_t i = 0; i < r->count; i++)
        alike += (lit[i] >= 0.5f) == (r->lit[i] > 0);
    return (double)alike / (double)r->count;
}

static void measure_peer(peer *p, const bn_rays *tracer, const rays *r, ex_pool *const pools[2], float *scratch)
{
    for (int t = 0; t < 2; t++) {
        p->mrays[t] = p->tinybvh[t] = -1;
        p->mode[t] = NULL;
        for (int mode = 0; tracer && pools[t] && mode < BN_RAY_MODES; mode++) {
            work w = { r, tracer, (bn_ray_mode)mode, NULL, NULL, COHSM_FILTER_NEAREST, 0, 0, scratch, 0, NULL, NULL };
            double s = speed(&w, pools[t]);
            if (s > p->mrays[t]) {
                p->mrays[t] = s;
                p->mode[t] = bn_rays_mode_name((bn_ray_mode)mode);
            }
        }
        if (tracer && pools[t] && bn_rays_peer_version()) {
            work w = { r, tracer, BN_RAY_TINYBVH, NULL, NULL, COHSM_FILTER_NEAREST, 0, 0, scratch, 0, NULL, NULL };
            p->tinybvh[t] = speed(&w, pools[t]);
            p->agreement = agreement(r, scratch);
        }
    }
}

/* ---- rows ---- */

/* What is built. The first kind has all rows, the others have the plain ones. */
typedef struct kind { uint32_t map_side; cohsm_layers layers; const char *name; } kind;

typedef struct table {           /* by layout */
    const kind *kind;
    cohsm_maps *maps[2];
    bn_scalar   scalar[2];
    cohsm_info  info[2];
} table;

static const cohsm_layout layouts[2] = { COHSM_LAYOUT_COMPACT, COHSM_LAYOUT_FAST };

static void table_free(table *t)
{
    for (int i = 0; i < 2; i++) {
        cohsm_free(t->maps[i]);
        bn_scalar_free(&t->scalar[i]);
    }
}

static int table_build(table *t, const bn_options *options, const bn_model *model, const kind *k)
{
    cohsm_desc desc = bn_desc(options);
    cohsm_mesh mesh = bn_model_mesh(model);
    cohsm_result result;
    size_t size = 0;
    const void *data = NULL;
    memset(t, 0, sizeof *t);
    t->kind = k;
    desc.domain.side[0] = desc.domain.side[1] = SIDE;
    desc.map_side = k->map_side;
    desc.layers = k->layers;
    result = cohsm_build(&desc, &mesh, &t->maps[0], NULL);
    ex_progress(NULL, 1);
    if (result == COHSM_OK) {
        data = cohsm_data(t->maps[0], &size);
        result = cohsm_open_as(data, size, COHSM_LAYOUT_FAST, 0, NULL, &t->maps[1]);
    }
    for (int i = 0; i < 2 && result == COHSM_OK; i++) {
        cohsm_get_info(t->maps[i], &t->info[i]);
        result = bn_scalar_open(&t->scalar[i], data, size, layouts[i]);
    }
    if (result == COHSM_OK)
        return 0;
    table_free(t);
    return bn_failed(model->name, cohsm_result_text(result));
}

typedef struct subject {         /* what all rows of a model share */
    const bn_options *options;
    const bn_model   *model;
    const rays       *rays[2];   /* random, coherent */
    peer              peers[2];
    int               has_peer;
    ex_pool          *pools[2];
    float            *lit;
} subject;

static void print_errors(const subject *s, const rays *r)
{
    size_t shadow = 0, light = 0;
    for (size_t i = 0; i < r->count; i++) {
        int lit = s->lit[i] >= 0.5f;
        shadow += !lit && r->lit[i] > 0;
        light += lit && !(r->lit[i] > 0);
    }
    bn_number("agreement", s->has_peer ? agreement(r, s->lit) : HUGE_VAL);
    bn_number("false_shadow", s->has_peer ? (double)shadow / (double)r->count : HUGE_VAL);
    bn_number("false_light", s->has_peer ? (double)light / (double)r->count : HUGE_VAL);
}

static void print_layout(const cohsm_info *info)
{
    int fast = info->layout == COHSM_LAYOUT_FAST;
    size_t bytes = fast ? info->fast_bytes : info->bytes;
    bn_text("layout", fast ? "fast" : "compact");
    bn_integer("table_bytes", bytes);
    bn_number("compression", 2.0 * info->view_count * info->map_side * info->map_side / (double)bytes);
}

/* What a row asks. */
typedef struct question { int fast, coherent, threads, simd; cohsm_filter filter; float bias; int by_index, strided; }
    question;

/* The number of the map that answers for a direction. */
static uint32_t map_of(const cohsm_info *info, const float *d)
{
    const double length = sqrt((double)dot(d, d)), pi = 3.14159265358979323846;
    const double x = (0.5 + atan2((double)d[2], (double)d[0]) / (2 * pi)) * info->side[0];
    const double y = acos((double)d[1] / length) / pi * info->side[1];
    return (uint32_t)fmin(x, info->side[0] - 1.0) + info->side[0] * (uint32_t)fmin(y, info->side[1] - 1.0);
}

/* Prepares the lights and points of a question. -1: out of memory. */
static int prepare(work *w, const cohsm_info *info, const question *q, uint32_t **numbers, float **vertices)
{
    const rays *r = w->rays;
    *numbers = q->by_index ? malloc((r->group_count + 1) * sizeof **numbers) : NULL;
    *vertices = q->strided ? calloc(r->count, STRIDE) : NULL;
    if ((q->by_index && !*numbers) || (q->strided && !*vertices))
        return -1;
    for (size_t i = 0; q->by_index && i < r->group_count; i++)
        (*numbers)[i] = map_of(info, r->directions + 3 * r->groups[i]);
    for (size_t i = 0; q->strided && i < r->count; i++)
        memcpy(*vertices + STRIDE / 4 * i, r->points + 3 * i, 12);
    w->maps_asked = *numbers;
    w->vertices = *vertices;
    return 0;
}

static void print_question(const subject *s, const table *t, const question *q)
{
    static const char *const filters[] = { "nearest", "pcf", "roulette" };
    bn_begin(s->options, "csm_query", q->threads, q->simd ? bn_simd() : "none");
    bn_text("model", s->model->name);
    bn_text("layers", t->kind->name);
    print_layout(&t->info[q->fast]);
    bn_text("mode", q->coherent ? "coherent" : "random");
    bn_text("lights", q->by_index ? "one_index" : q->coherent ? "one_direction" : "directions");
    bn_integer("position_stride", q->strided ? STRIDE : 12);
    bn_text("filter", filters[q->filter]);
    bn_integer("map_count", t->info[q->fast].map_count);
    bn_integer("map_side", t->info[q->fast].map_side);
    bn_number("bias", (double)q->bias);
#if defined(__AVX2__)
    bn_text("flags", "above the baseline of the architecture");
#else
    bn_text("flags", "baseline");
#endif
}

static int print_row(const subject *s, const table *t, question q)
{
    const rays *r = s->rays[q.coherent];
    const peer *p = &s->peers[q.coherent];
    const double peer_speed = p->mrays[q.threads - 1];
    work w = { r, NULL, BN_RAY1, t->maps[q.fast], q.simd ? NULL : &t->scalar[q.fast], q.filter, q.bias, q.coherent,
               s->lit, 0, NULL, NULL };
    double mqueries = -1;
    uint32_t *numbers;
    float *vertices;
    if (prepare(&w, &t->info[q.fast], &q, &numbers, &vertices) == 0)
        mqueries = speed(&w, s->pools[q.threads - 1]);
    free(numbers);
    free(vertices);
    if (mqueries < 0)
        return bn_failed(s->model->name, w.failed ? "a query failed" : "out of memory");
    print_question(s, t, &q);
    bn_number("mqueries_s", mqueries);
    bn_number("embree_mrays_s", peer_speed > 0 ? peer_speed : HUGE_VAL);
    bn_number("ratio", peer_speed > 0 ? mqueries / peer_speed : HUGE_VAL);
    print_errors(s, r);
    bn_text("embree_mode", p->mode[q.threads - 1]);
    bn_text("embree", bn_rays_version());
    if (bn_rays_peer_version()) {
        bn_text("tinybvh", bn_rays_peer_version());
        bn_number("tinybvh_mrays_s", p->tinybvh[q.threads - 1]);
        bn_number("tinybvh_ratio", mqueries / p->tinybvh[q.threads - 1]);
        bn_number("tinybvh_agreement", p->agreement);
    }
    bn_end(s->options);
    return 0;
}

static int print_rows(const subject *s, const table *t, int fast, int is_default)
{
    const question q = { fast, 0, 1, 1, COHSM_FILTER_NEAREST, 1, 0, 0 };
    question ask[7];
    int most = s->pools[1] ? 2 : 1, failed = 0, count = 0;
    for (int i = 0; i < 2 * most; i++) {
        question plain = q;
        plain.coherent = i / most;
        plain.threads = 1 + i % most;
        failed |= print_row(s, t, plain);
    }
    if (!is_default && !s->options->full)
        return failed;
    for (int i = 0; i < 7; i++) ask[i] = q;
    ask[count++].simd = 0;
    ask[count].coherent = 1;
    ask[count++].simd = 0;
    ask[count].coherent = 1;
    ask[count++].by_index = 1;
    ask[count].coherent = 1;
    ask[count++].strided = 1;
    ask[count++].bias = 0;
    ask[count++].filter = COHSM_FILTER_PCF;
    ask[count++].filter = COHSM_FILTER_ROULETTE;
    for (int i = 0; i < count; i++)
        failed |= print_row(s, t, ask[i]);
    return failed;
}

/* The exact answers come from single rays. */
static void answer(const bn_rays *tracer, rays *r, ex_pool *pool)
{
    work w = { r, tracer, BN_RAY1, NULL, NULL, COHSM_FILTER_NEAREST, 0, 0, r->lit, 0, NULL, NULL };
    if (tracer)
        ex_pool_run(pool, (r->count + CHUNK - 1) / CHUNK, do_chunk, &w);
}

static int measure_tables(subject *s)
{
    static const kind kinds[] = { { 128, COHSM_LAYERS_Z1Z2, "z1z2" }, { 256, COHSM_LAYERS_Z1Z2, "z1z2" },
                                  { 128, COHSM_LAYERS_Z1Z3_SPHERE, "z1z3_sphere" },
                                  { 128, COHSM_LAYERS_Z1Z3_FAR, "z1z3_far" } };
    int result = 0;
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds && result == 0; i++) {
        table t;
        if (table_build(&t, s->options, s->model, &kinds[i]) != 0)
            return -1;
        for (int fast = 0; fast < 2 && result == 0; fast++)
            result = print_rows(s, &t, fast, i == 0);
        table_free(&t);
    }
    return result;
}

static int measure_model(const bn_options *options, const bn_model *model, ex_pool *const pools[2])
{
    size_t count = options->full ? 4000000 : 2000000;
    sample *samples = make_samples(model, count);
    bn_rays *tracer = bn_rays_create(model, options->threads);
    rays r[2] = { { NULL, NULL, NULL, NULL, 0, 0 }, { NULL, NULL, NULL, NULL, 0, 0 } };
    subject s;
    int result = -1;
    memset(&s, 0, sizeof s);
    s.options = options;
    s.model = model;
    s.has_peer = tracer != NULL;
    s.lit = malloc(count * sizeof *s.lit);
    if (!samples || !s.lit) {
        bn_failed(model->name, "out of memory");
    } else if (rays_alloc(&r[0], count) == 0 && rays_alloc(&r[1], count) == 0) {
        make_random(&r[0], samples, count);
        make_coherent(&r[1], samples, count);
        for (int i = 0; i < 2; i++) {
            s.rays[i] = &r[i];
            s.pools[i] = pools[i];
        }
        for (int i = 0; i < 2; i++) {
            answer(tracer, &r[i], options->pool);
            measure_peer(&s.peers[i], tracer, &r[i], pools, s.lit);
        }
        result = measure_tables(&s);
    }
    rays_free(&r[0]);
    rays_free(&r[1]);
    free(s.lit);
    bn_rays_free(tracer);
    free(samples);
    return result;
}

int bn_csm_query(const bn_options *options)
{
    bn_model models[BN_MOST_MODELS];
    size_t count;
    ex_pool *pools[2];
    int result = 0;
    if (bn_models_load(options, models, &count) != 0)
        return -1;
    pools[0] = ex_pool_create(1);
    pools[1] = options->threads > 1 ? ex_pool_create(2) : NULL;
    if (!pools[0])
        result = bn_failed("csm_query", "out of memory");
    for (size_t i = 0; i < count; i++) {
        if (result == 0)
            result = measure_model(options, &models[i], pools);
        bn_model_free(&models[i]);
    }
    ex_pool_free(pools[0]);
    ex_pool_free(pools[1]);
    return result;
}
