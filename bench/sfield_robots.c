/* sfield_robots.c - the paper's robots: three walking machines of one body and one leg in three sizes on a deck, each
   with a spot light, and three bullets that shine. All move, 26,000 vertices as in the paper, harmonics of 4 bands:
   frames a second with all moving, to the outermost shell and to 2.5 r. Parts are bones: each is an entity whose points
   it does not hide, and its bounding sphere overlaps its neighbours'. Errors are those of what parts hide from each
   other's points, against rays: the share of a cosine-weighted hemisphere that is open, by how near the nearest other
   part's centre is. */
#include "sfield_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* An entity of no fields that stands at the origin, not tinted. */
static const sfield_entity upright = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };

enum { ROBOTS = 3, PARTS = 3 * ROBOTS, BULLETS = ROBOTS, OBJECTS = PARTS + BULLETS + 1, MESHES = 4 };
enum { BODY, LEG, BULLET, DECK, ENTITIES = PARTS + BULLETS + ROBOTS, RAYS = 1024, NEARNESS = 3 };

/* Vertices of each mesh: 26,000 in all, of which the deck, which only receives, has 8,000. */
static const size_t vertex_counts[MESHES] = { 2600, 1650, 100, 8000 };
static const float lamp_radius = 0.08f, lift = 1e-3f;

/* Up to how many radii of another part its centre is away. */
static const float edges[NEARNESS + 1] = { 0, 1, 2, HUGE_VALF };

typedef struct robots {
    ex_scene       scene;
    sfield_scene  *field_scene;
    sfield_field  *occlusion[MESHES], *self[MESHES], *bullet, *spot;
    sfield_entity  entities[ENTITIES];
    bn_points      points[MESHES];
    sfield_points  sets[OBJECTS];
    float         *rgb, *ambient;
    size_t         bytes, vertices;
    double         build_seconds;
} robots;

static int build_mesh(robots *r, const sfield_desc *d, uint32_t m)
{
    const ex_mesh *mesh = &r->scene.meshes[m];
    const sfield_mesh input = { mesh->positions, mesh->vertex_count, 0, mesh->indices,
                                3 * (size_t)mesh->triangle_count, NULL, NULL, NULL };
    bn_points *p = &r->points[m];
    sfield_points receivers;
    if (bn_points_spread(p, mesh, vertex_counts[m]) != 0)
        return -1;
    if (m == DECK)
        return 0;
    memset(&receivers, 0, sizeof receivers);
    receivers.count = p->count;
    receivers.positions = p->positions;
    receivers.normals = p->normals;
    if (sfield_build(d, &input, &r->occlusion[m], NULL) != SFIELD_OK ||
        sfield_build_self(d, &input, &receivers, lift, &r->self[m], NULL) != SFIELD_OK)
        return -1;
    r->bytes += sfield_bytes(r->occlusion[m]) + sfield_bytes(r->self[m]);
    return 0;
}

/* Bullets shine all round; a spot is a small disc that shines into its cone. Both are brighter by their tint. */
static int build(robots *r, const bn_options *options)
{
    const ex_light *lamp = &r->scene.lights[0];
    sfield_desc d = bn_sfield_desc(options);
    sfield_emitter e;
    double start = ex_seconds();
    d.position_side = options->full ? 16 : 8;
    for (uint32_t m = 0; m < MESHES; m++)
        if (build_mesh(r, &d, m) != 0)
            return -1;
    memset(&e, 0, sizeof e);
    e.radius = 0.06f;
    e.radiance[0] = 420, e.radiance[1] = 260, e.radiance[2] = 90;
    if (sfield_build_emitter(&d, &e, &r->bullet, NULL) != SFIELD_OK)
        return -1;
    e.kind = SFIELD_EMITTER_DISC;
    e.radius = lamp_radius;
    e.normal[2] = 1;
    e.cone_half_angle = acosf(lamp->cos_half_angle);
    for (int k = 0; k < 3; k++)
        e.radiance[k] = lamp->value[k] / (3.14159265f * lamp_radius * lamp_radius);
    if (sfield_build_emitter(&d, &e, &r->spot, NULL) != SFIELD_OK)
        return -1;
    r->bytes += sfield_bytes(r->bullet) + sfield_bytes(r->spot);
    r->build_seconds = ex_seconds() - start;
    return 0;
}

/* Where a spot hangs, turned from +z to where it points. */
static void place_spot(sfield_entity *e, const ex_light *l)
{
    const float *d = l->direction, side = sqrtf(d[0] * d[0] + d[2] * d[2]);
    float *m = e->transform;
    m[0] = d[2] / side, m[1] = 0, m[2] = -d[0] / side;
    memcpy(m + 8, d, 3 * sizeof *m);
    for (int k = 0; k < 3; k++) {
        m[4 + k] = m[8 + (k + 1) % 3] * m[(k + 2) % 3] - m[8 + (k + 2) % 3] * m[(k + 1) % 3];
        m[12 + k] = l->position[k];
    }
}

static int place(robots *r, float time)
{
    char error[EX_ERROR_SIZE];
    if (ex_scene_set_time(&r->scene, time, error) != 0)
        return -1;
    for (uint32_t i = 0; i < PARTS + BULLETS; i++) {
        r->entities[i] = upright;
        r->entities[i].occlusion = r->occlusion[r->scene.objects[i].mesh];
        r->entities[i].source = i < PARTS ? NULL : r->bullet;
        memcpy(r->entities[i].transform, r->scene.objects[i].transform, sizeof r->entities[i].transform);
    }
    for (int i = 0; i < ROBOTS; i++) {
        sfield_entity *e = &r->entities[PARTS + BULLETS + i];
        *e = upright;
        e->source = r->spot;
        place_spot(e, &r->scene.lights[i]);
    }
    return sfield_scene_entities(r->field_scene, r->entities, ENTITIES) == SFIELD_OK ? 0 : -1;
}

static int make_sets(robots *r)
{
    size_t most = 0;
    for (uint32_t i = 0; i < OBJECTS; i++)
        most += vertex_counts[r->scene.objects[i].mesh];
    r->rgb = malloc(3 * most * sizeof *r->rgb);
    r->ambient = malloc(most * sizeof *r->ambient);
    for (uint32_t i = 0; r->rgb && r->ambient && i < OBJECTS; i++) {
        uint32_t m = r->scene.objects[i].mesh;
        sfield_points *p = &r->sets[i];
        p->count = r->points[m].count;
        p->positions = r->points[m].positions;
        p->normals = r->points[m].normals;
        p->entity = i < PARTS + BULLETS ? i + 1 : 0;
        p->self = r->self[m];
        p->rgb = r->rgb + 3 * r->vertices;
        r->vertices += p->count;
    }
    return r->rgb && r->ambient ? 0 : -1;
}

static int shade(robots *r, float time, sfield_scene_stats *stats)
{
    return place(r, time) == 0 && sfield_shade(r->field_scene, r->sets, OBJECTS, stats) == SFIELD_OK ? 0 : -1;
}

/* ---- against rays ---- */

/* How many of its radii a part's centre is from a point; parts but the own one, the nearest. */
static float nearest_part(const robots *r, uint32_t own, const float *p)
{
    float least = HUGE_VALF;
    for (uint32_t i = 0; i < PARTS; i++) {
        const float *m = r->entities[i].transform, scale = sqrtf(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
        sfield_info info;
        float sum = 0;
        if (i == own)
            continue;
        sfield_get_info(r->entities[i].occlusion, &info);
        for (int k = 0; k < 3; k++) {
            const float *c = info.center, d = m[k] * c[0] + m[4 + k] * c[1] + m[8 + k] * c[2] + m[12 + k] - p[k];
            sum += d * d;
        }
        least = fminf(least, sqrtf(sum) / (scale * info.radius));
    }
    return least;
}

/* The share of the hemisphere that rays see, weighted by the cosine. */
static float trace(const bn_rays *rays, const float *p, const float *n, float *room)
{
    float *from = room, *to = room + 3 * RAYS, *lit = room + 6 * RAYS, open = 0, all = 0;
    for (int i = 0; i < RAYS; i++) {
        float w[3];
        bn_cap_direction(n, 1, i, RAYS, w);
        for (int k = 0; k < 3; k++) {
            from[3 * i + k] = p[k] + lift * n[k];
            to[3 * i + k] = from[3 * i + k] + 30 * w[k];
        }
    }
    bn_rays_segments(rays, from, to, RAYS, lit);
    for (int i = 0; i < RAYS; i++) {
        float cosine = 0;
        for (int k = 0; k < 3; k++)
            cosine += (to[3 * i + k] - from[3 * i + k]) / 30 * n[k];
        open += lit[i] * cosine;
        all += cosine;
    }
    return open / all;
}

typedef struct errors { bn_error at[NEARNESS]; size_t dark, leaks; } errors;

/* Parts, each in turn, at some of its points; those that nobody can see are left out. */
static int check(robots *r, const bn_options *options, errors *out)
{
    bn_model model = { .positions = NULL };
    bn_rays *rays = bn_model_flatten(&model, &r->scene, PARTS + BULLETS) == 0 ? bn_rays_create(&model, 1) : NULL;
    float *room = malloc(7 * RAYS * sizeof *room);
    const size_t step = options->full ? 1 : 10;
    int result = room ? 0 : -1;
    for (uint32_t o = 0; result == 0 && rays && o < PARTS; o++) {
        sfield_points set = r->sets[o];
        set.rgb = NULL;
        set.ambient = r->ambient;
        if (sfield_shade(r->field_scene, &set, 1, NULL) != SFIELD_OK)
            result = -1;
        for (size_t i = 0; result == 0 && i < set.count; i += step) {
            float p[3], n[3], truth, near_by;
            int k = 0;
            bn_points_world(&r->points[r->scene.objects[o].mesh], i, r->entities[o].transform, p, n);
            truth = trace(rays, p, n, room);
            near_by = nearest_part(r, o, p);
            if (!(truth > 0.02f))
                continue;
            while (k + 1 < NEARNESS && near_by >= edges[k + 1])
                k++;
            bn_error_add(&out->at[k], (double)r->ambient[i], (double)truth);
            out->dark += r->ambient[i] < truth - 0.25f;
            out->leaks += r->ambient[i] > truth + 0.25f;
        }
    }
    bn_rays_free(rays);
    bn_model_free(&model);
    free(room);
    return result;
}

/* ---- frames ---- */

static int by_size(const void *a, const void *b)
{
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

static double absolute(const bn_error *e)
{
    return e->count ? sqrt(e->square / (double)e->count) : (double)NAN;
}

static int measure(robots *r, const bn_options *options, float reach)
{
    enum { FRAMES = 31 };
    double spent[FRAMES];
    sfield_scene_stats stats;
    errors e;
    memset(&e, 0, sizeof e);
    if (shade(r, 1, &stats) != 0 || check(r, options, &e) != 0)
        return -1;
    for (int frame = 0; frame < FRAMES; frame++) {
        double start = ex_seconds();
        if (shade(r, 1 + (float)(frame + 1) / 30, &stats) != 0)
            return -1;
        spent[frame] = ex_seconds() - start;
    }
    qsort(spent, FRAMES, sizeof *spent, by_size);
    bn_begin(options, "sfield_robots", options->threads, bn_sfield_simd());
    bn_integer("vertices", r->vertices);
    bn_integer("entities", PARTS + BULLETS);
    bn_integer("lights", BULLETS + ROBOTS);
    bn_number("reach", (double)reach);
    bn_number("build_seconds", r->build_seconds);
    bn_number("fps", 1 / spent[FRAMES / 2]);
    bn_integer("products", stats.products);
    bn_integer("culled", stats.culled_far + stats.culled_horizon + stats.culled_hidden);
    bn_integer("memory_bytes", r->bytes);
    bn_integer("checked", e.at[0].count + e.at[1].count + e.at[2].count);
    bn_number("rmse_within_1_r", absolute(&e.at[0]));
    bn_number("rmse_within_2_r", absolute(&e.at[1]));
    bn_number("rmse_beyond", absolute(&e.at[2]));
    bn_integer("too_dark", e.dark);
    bn_integer("leaks", e.leaks);
    bn_end(options);
    return 0;
}

static void close_robots(robots *r)
{
    for (int m = 0; m < MESHES; m++) {
        sfield_free(r->occlusion[m]);
        sfield_free(r->self[m]);
        bn_points_free(&r->points[m]);
    }
    sfield_free(r->bullet);
    sfield_free(r->spot);
    ex_scene_free(&r->scene);
    free(r->rgb);
    free(r->ambient);
    free(r);
}

int bn_sfield_robots(const bn_options *options)
{
    static const float reaches[] = { 0, 2.5f };     /* all that fields have; a third of it */
    robots *r = calloc(1, sizeof *r);
    char error[EX_ERROR_SIZE] = "out of memory";
    int result = r ? ex_scene_builtin(&r->scene, "robots", 1, error) : -1;
    if (result == 0)
        result = build(r, options) != 0 || make_sets(r) != 0 ? -1 : 0;
    for (int i = 0; i < 2 && result == 0; i++) {
        sfield_scene_desc d;
        memset(&d, 0, sizeof d);
        d.system.parallel_for = ex_pool_run;
        d.system.user = options->pool;
        d.reach = reaches[i];
        result = sfield_scene_create(&d, &r->field_scene) == SFIELD_OK ? measure(r, options, reaches[i]) : -1;
        sfield_scene_free(r->field_scene);
        r->field_scene = NULL;
    }
    if (r)
        close_robots(r);
    return result == 0 ? 0 : bn_failed("sfield_robots", error[0] ? error : "out of memory");
}
