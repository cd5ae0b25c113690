/* sfield_wavelet.c - the paper's spaceships: two ships move in wavelets over robots and a deck, under a sky and a lamp;
   73,000 vertices. Frames a second and errors at several budgets of wavelets, with both ways of the product, with and
   without a lazy cache while only the lamp moves. By default fields are small and every 16th vertex is shaded, frames a
   second being those of all of them; --full takes the paper's fields and every vertex, for an hour. */
#include "sfield_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* An entity of no fields that stands at the origin, not tinted. */
static const sfield_entity upright = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };

enum { VERTICES = 73000, ROBOT_VERTICES = 8000, ROBOT_PARTS = 9, SHIPS = 2, SETS = 2, BUDGETS = 4 };

/* Share of the 6 x 32 x 32 coefficients that is kept; the first is the truth. */
static const float budgets[BUDGETS] = { 1, 0.04f, 0.01f, 0.0025f };

typedef struct ships {
    ex_scene      scene;
    ex_sky        sky;
    bn_model      robots;
    bn_points     points[SETS];         /* of the robots, in their place, and of the deck */
    sfield_field *ship, *lamp, *self;
    sfield_scene *field_scene;
    sfield_cache *cache[SETS];
    sfield_points sets[SETS];
    float        *rgb, *truth;
    size_t        vertices, bytes;
    double        seconds;
} ships;

static sfield_mesh mesh_of(const ex_mesh *m)
{
    sfield_mesh mesh = { m->positions, m->vertex_count, 0, m->indices, 3 * (size_t)m->triangle_count,
                         NULL, NULL, NULL };
    return mesh;
}

static int take_points(ships *s, int full)
{
    const ex_object *deck = &s->scene.objects[ROBOT_PARTS + SHIPS];
    size_t part = full ? 1 : 16;
    ex_mesh robots;
    memset(&robots, 0, sizeof robots);
    if (bn_model_flatten(&s->robots, &s->scene, ROBOT_PARTS) != 0)
        return -1;
    robots.positions = s->robots.positions;
    robots.indices = s->robots.indices;
    robots.vertex_count = (uint32_t)s->robots.vertices;
    robots.triangle_count = (uint32_t)s->robots.triangles;
    if (bn_points_spread(&s->points[0], &robots, ROBOT_VERTICES / part) != 0 ||
        bn_points_spread(&s->points[1], &s->scene.meshes[deck->mesh], (VERTICES - ROBOT_VERTICES) / part) != 0)
        return -1;
    for (int i = 0; i < SETS; i++)
        s->vertices += s->points[i].count;
    s->rgb = malloc(3 * s->vertices * sizeof *s->rgb);
    s->truth = malloc(3 * s->vertices * sizeof *s->truth);
    return s->rgb && s->truth ? 0 : -1;
}

static void free_fields(ships *s)
{
    sfield_free(s->ship);
    sfield_free(s->lamp);
    sfield_free(s->self);
    s->ship = s->lamp = s->self = NULL;
}

static int build(ships *s, const bn_options *options, float keep)
{
    sfield_desc d = bn_sfield_desc(options);
    sfield_points receivers;
    sfield_mesh ship = mesh_of(&s->scene.meshes[s->scene.objects[ROBOT_PARTS].mesh]), robots;
    sfield_emitter lamp;
    double start = ex_seconds();
    memset(&robots, 0, sizeof robots);
    robots.positions = s->robots.positions;
    robots.vertex_count = s->robots.vertices;
    robots.indices = s->robots.indices;
    robots.index_count = 3 * s->robots.triangles;
    memset(&lamp, 0, sizeof lamp);
    lamp.radius = 0.3f;
    lamp.radiance[0] = 30;
    lamp.radiance[1] = 24;
    lamp.radiance[2] = 15;
    d.basis = SFIELD_BASIS_HAAR;
    d.shell_count = options->full ? 32 : 8;
    d.position_side = options->full ? 32 : 5;
    d.keep = keep;
    memset(&receivers, 0, sizeof receivers);
    receivers.count = s->points[0].count;
    receivers.positions = s->points[0].positions;
    receivers.normals = s->points[0].normals;
    free_fields(s);
    if (sfield_build(&d, &ship, &s->ship, NULL) != SFIELD_OK ||
        sfield_build_emitter(&d, &lamp, &s->lamp, NULL) != SFIELD_OK ||
        sfield_build_self(&d, &robots, &receivers, 2e-3f, &s->self, NULL) != SFIELD_OK)
        return -1;
    s->bytes = sfield_bytes(s->ship) + sfield_bytes(s->lamp) + sfield_bytes(s->self);
    s->seconds = ex_seconds() - start;
    return 0;
}

static void close_scene(ships *s)
{
    for (int i = 0; i < SETS; i++) {
        sfield_cache_free(s->cache[i]);
        s->cache[i] = NULL;
    }
    sfield_scene_free(s->field_scene);
    s->field_scene = NULL;
}

static int open_scene(ships *s, const bn_options *options, sfield_product_mode product)
{
    sfield_scene_desc d;
    size_t first = 0;
    memset(&d, 0, sizeof d);
    d.basis = SFIELD_BASIS_HAAR;
    d.product = product;
    d.system.parallel_for = ex_pool_run;
    d.system.user = options->pool;
    close_scene(s);
    if (sfield_scene_create(&d, &s->field_scene) != SFIELD_OK ||
        sfield_scene_environment(s->field_scene, s->sky.rgb, s->sky.width, s->sky.height, NULL) != SFIELD_OK)
        return -1;
    for (int i = 0; i < SETS; i++) {
        sfield_points *p = &s->sets[i];
        memset(p, 0, sizeof *p);
        p->count = s->points[i].count;
        p->positions = s->points[i].positions;
        p->normals = s->points[i].normals;
        p->entity = 0;
        p->self = i == 0 ? s->self : NULL;
        p->rgb = s->rgb + 3 * first;
        first += p->count;
        if (sfield_cache_create(s->field_scene, p->count, 2, &s->cache[i]) != SFIELD_OK)
            return -1;
    }
    return 0;
}

/* Entities in wavelets are not turned here, since the sparse product cannot: the ships fly straight ahead. */
static int shade(ships *s, float ship_time, float lamp_time, sfield_scene_stats *stats)
{
    sfield_entity e[SHIPS + 1];
    char error[EX_ERROR_SIZE];
    if (ex_scene_set_time(&s->scene, ship_time, error) != 0)
        return -1;
    for (int i = 0; i < SHIPS; i++) {
        const float *m = s->scene.objects[ROBOT_PARTS + i].transform;
        e[i] = upright;
        e[i].occlusion = s->ship;
        for (int k = 0; k < 3; k++) {
            e[i].transform[5 * k] = sqrtf(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
            e[i].transform[12 + k] = m[12 + k];
        }
    }
    e[SHIPS] = upright;
    e[SHIPS].source = s->lamp;
    e[SHIPS].transform[12] = 3 * cosf(0.4f * lamp_time);
    e[SHIPS].transform[13] = 6;
    e[SHIPS].transform[14] = 3 * sinf(0.4f * lamp_time);
    return sfield_scene_entities(s->field_scene, e, SHIPS + 1) == SFIELD_OK &&
           sfield_shade(s->field_scene, s->sets, SETS, stats) == SFIELD_OK ? 0 : -1;
}

static int measure(ships *s, const bn_options *options, int budget, sfield_product_mode product, int lazy)
{
    sfield_scene_stats stats;
    bn_error error = { 0, 0, 0 };
    double best = HUGE_VAL;
    size_t bytes = s->bytes;
    if (open_scene(s, options, product) != 0)
        return -1;
    for (int i = 0; i < SETS && lazy; i++) {
        s->sets[i].cache = s->cache[i];
        bytes += sfield_cache_bytes(s->cache[i]);
    }
    for (int frame = 0; frame < 4; frame++) {
        double start = ex_seconds();
        if (shade(s, lazy ? 0 : (float)frame / 30, (float)frame / 30, &stats) != 0)
            return -1;
        best = frame ? fmin(best, ex_seconds() - start) : best;
    }
    if (shade(s, 0, 0, NULL) != 0)
        return -1;
    if (budget == 0 && product == SFIELD_PRODUCT_TEXELS && !lazy)
        memcpy(s->truth, s->rgb, 3 * s->vertices * sizeof *s->rgb);
    for (size_t i = 0; i < 3 * s->vertices; i++)
        bn_error_add(&error, (double)s->rgb[i], (double)s->truth[i]);
    bn_begin(options, "sfield_wavelet", options->threads, bn_sfield_simd());
    bn_integer("vertices", VERTICES);
    bn_integer("shaded", s->vertices);
    bn_integer("lights", 2);
    bn_number("keep", (double)budgets[budget]);
    bn_text("product", product == SFIELD_PRODUCT_SPARSE ? "sparse" : "texels");
    bn_flag("lazy", lazy);
    bn_number("build_seconds", s->seconds);
    bn_number("fps", (double)s->vertices / VERTICES / best);
    bn_integer("reused", stats.reused);
    bn_integer("memory_bytes", bytes);
    bn_number("rmse_vs_uncompressed", bn_error_relative(&error));
    bn_end(options);
    return 0;
}

int bn_sfield_wavelet(const bn_options *options)
{
    ships s;
    char error[EX_ERROR_SIZE] = "";
    int result;
    memset(&s, 0, sizeof s);
    result = ex_scene_builtin(&s.scene, "spaceships", 0, error) != 0 || ex_sky_builtin(&s.sky, "sky", error) != 0 ||
             take_points(&s, options->full) != 0 ? -1 : 0;
    for (int i = 0; i < BUDGETS && result == 0; i++) {
        result = build(&s, options, budgets[i]);
        for (int way = 0; way < 4 && result == 0; way++)
            result = measure(&s, options, i, way & 1 ? SFIELD_PRODUCT_SPARSE : SFIELD_PRODUCT_TEXELS, way / 2);
    }
    close_scene(&s);
    free_fields(&s);
    for (int i = 0; i < SETS; i++)
        bn_points_free(&s.points[i]);
    bn_model_free(&s.robots);
    ex_sky_free(&s.sky);
    ex_scene_free(&s.scene);
    free(s.rgb);
    free(s.truth);
    return result == 0 ? 0 : bn_failed("sfield_wavelet", error[0] ? error : "out of memory");
}
