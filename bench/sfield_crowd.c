/* sfield_crowd.c - what bodies and lamps cost that lie far from the points: 32 bodies and 4 lamps beside 1,000 bodies
   and 64 lamps, at one density, for as many points on and around sixteen of the bodies, so that points see as many
   bodies in both. Bodies are the pieces of the chess match and stand on a square grid; all of them and all lamps move
   in each frame. The scenes take turns, frame by frame, and each line holds the least processor time of its frames, in
   all threads together: that of placing entities, which is once a frame, and that of shading. */
#include "sfield_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MESHES = 6, SEEN = 16, ON_BODY = 1024, AROUND = 1024, SCENES = 4, MOST_BODIES = 1000, MOST_LAMPS = 64 };

static const uint32_t counts[SCENES][2] = { { 32, 4 }, { 1000, 4 }, { 32, 64 }, { 1000, 64 } };

typedef struct crowd {
    sfield_scene      *scene;
    uint32_t           bodies, lamps, side;         /* the grid's */
    float             *floor;                       /* points around the bodies that have points */
    sfield_points      sets[SEEN + 1];
    sfield_entity      entities[MOST_BODIES + MOST_LAMPS];
    sfield_scene_stats stats;
    double             placed, shaded;              /* least seconds of a frame */
} crowd;

typedef struct match {
    ex_scene       chess;
    sfield_field  *occlusion[MESHES], *self[MESHES], *lamp;
    bn_points      points[MESHES];
    float          pitch, *up, *rgb;                /* bodies stand so far apart */
    crowd          crowds[SCENES];
} match;

/* ---- fields ---- */

static int build_mesh(match *m, const sfield_desc *d, uint32_t i)
{
    const ex_mesh *mesh = &m->chess.meshes[i + 1];  /* the first is the board */
    const sfield_mesh input = { mesh->positions, mesh->vertex_count, 0, mesh->indices,
                                3 * (size_t)mesh->triangle_count, NULL, NULL, NULL };
    sfield_points receivers;
    sfield_info info;
    if (bn_points_spread(&m->points[i], mesh, ON_BODY) != 0)
        return -1;
    memset(&receivers, 0, sizeof receivers);
    receivers.count = m->points[i].count;
    receivers.positions = m->points[i].positions;
    receivers.normals = m->points[i].normals;
    if (sfield_build(d, &input, &m->occlusion[i], NULL) != SFIELD_OK ||
        sfield_build_self(d, &input, &receivers, 2e-4f, &m->self[i], NULL) != SFIELD_OK)
        return -1;
    sfield_get_info(m->occlusion[i], &info);
    m->pitch = fmaxf(m->pitch, 1.3f * info.radius);
    return 0;
}

static int build(match *m, const bn_options *options)
{
    sfield_desc d = bn_sfield_desc(options);
    sfield_emitter e;
    d.position_side = options->full ? 16 : 8;
    for (uint32_t i = 0; i < MESHES; i++)
        if (build_mesh(m, &d, i) != 0)
            return -1;
    memset(&e, 0, sizeof e);
    e.radius = 0.03f;
    e.radiance[0] = e.radiance[1] = e.radiance[2] = 20;
    if (sfield_build_emitter(&d, &e, &m->lamp, NULL) != SFIELD_OK)
        return -1;
    m->rgb = malloc(3 * (size_t)(SEEN * AROUND) * sizeof *m->rgb);
    m->up = calloc(3 * (size_t)(SEEN * AROUND), sizeof *m->up);
    for (int i = 0; m->up && i < SEEN * AROUND; i++)
        m->up[3 * i + 1] = 1;
    return m->rgb && m->up ? 0 : -1;
}

/* ---- scenes ---- */

static void at_origin(sfield_entity *e)
{
    memset(e, 0, sizeof *e);
    for (int k = 0; k < 16; k += 5)
        e->transform[k] = 1;
    e->tint[0] = e->tint[1] = e->tint[2] = 1;
}

/* A piece in its cell, turned about its axis, which sways there. */
static void stand(const match *m, const crowd *c, uint32_t i, float time, sfield_entity *e)
{
    const float turn = 0.3f * (float)i + time, x = (float)(i % c->side), z = (float)(i / c->side);
    at_origin(e);
    e->occlusion = m->occlusion[i % MESHES];
    e->transform[0] = e->transform[10] = cosf(turn);
    e->transform[8] = sinf(turn);
    e->transform[2] = -e->transform[8];
    e->transform[12] = m->pitch * (x + 0.1f * sinf(turn));
    e->transform[14] = m->pitch * (z + 0.1f * cosf(turn));
}

static int place(const match *m, crowd *c, float time)
{
    const uint32_t rows = c->lamps > 4 ? 8 : 2;
    for (uint32_t i = 0; i < c->bodies; i++)
        stand(m, c, i, time, &c->entities[i]);
    for (uint32_t i = 0; i < c->lamps; i++) {
        sfield_entity *e = &c->entities[c->bodies + i];
        const float cell = (float)c->side / (float)rows, turn = time + (float)i;
        at_origin(e);
        e->source = m->lamp;
        e->transform[12] = m->pitch * (cell * ((float)(i % rows) + 0.5f) + 0.3f * cosf(turn));
        e->transform[13] = m->pitch * (1.2f + 0.1f * (float)(i % 7));
        e->transform[14] = m->pitch * (cell * ((float)(i / rows) + 0.5f) + 0.3f * sinf(turn));
    }
    return sfield_scene_entities(c->scene, c->entities, c->bodies + c->lamps) == SFIELD_OK ? 0 : -1;
}

/* Points on the floor of a cell, in squares of four by four. */
static void spread(const match *m, uint32_t x, uint32_t z, float *p)
{
    for (uint32_t i = 0; i < AROUND; i++, p += 3) {
        const uint32_t square = i / 16, in_square = i % 16;
        p[0] = m->pitch * ((float)x - 0.5f + ((float)(square % 8 * 4 + in_square % 4) + 0.5f) / 32);
        p[1] = 0;
        p[2] = m->pitch * ((float)z - 0.5f + ((float)(square / 8 * 4 + in_square / 4) + 0.5f) / 32);
    }
}

static int open_crowd(match *m, const bn_options *options, uint32_t which)
{
    crowd *c = &m->crowds[which];
    sfield_scene_desc d;
    memset(&d, 0, sizeof d);
    d.system.parallel_for = ex_pool_run;
    d.system.user = options->pool;
    d.reach = 2.5f;
    c->bodies = counts[which][0];
    c->lamps = counts[which][1];
    c->side = c->bodies > 36 ? 32 : 6;
    c->placed = c->shaded = HUGE_VAL;
    c->floor = malloc(3 * (size_t)(SEEN * AROUND) * sizeof *c->floor);
    if (!c->floor || sfield_scene_create(&d, &c->scene) != SFIELD_OK)
        return -1;
    for (uint32_t i = 0; i < SEEN; i++) {           /* the four by four in the middle, or some spread over all */
        const uint32_t first = c->bodies > 36 ? 4 : 1, step = c->bodies > 36 ? 7 : 1;
        const uint32_t x = first + step * (i % 4), z = first + step * (i / 4);
        const uint32_t body = z * c->side + x;
        sfield_points *p = &c->sets[i];
        p->entity = body + 1;
        p->count = ON_BODY;
        p->positions = m->points[body % MESHES].positions;
        p->normals = m->points[body % MESHES].normals;
        p->self = m->self[body % MESHES];
        p->rgb = m->rgb;
        spread(m, x, z, c->floor + 3 * (size_t)(i * AROUND));
    }
    c->sets[SEEN].count = (size_t)(SEEN * AROUND);
    c->sets[SEEN].positions = c->floor;
    c->sets[SEEN].normals = m->up;
    c->sets[SEEN].rgb = m->rgb;
    return 0;
}

static int frame(const match *m, crowd *c, float time)
{
    const clock_t start = clock();
    clock_t placed;
    if (place(m, c, time) != 0)
        return -1;
    placed = clock();
    for (size_t i = 0; i <= SEEN; i++) {            /* one after the other, since they share their results' memory */
        sfield_scene_stats stats;
        if (sfield_shade(c->scene, &c->sets[i], 1, &stats) != SFIELD_OK)
            return -1;
        if (i == SEEN)
            c->stats = stats;
    }
    c->placed = fmin(c->placed, (double)(placed - start) / CLOCKS_PER_SEC);
    c->shaded = fmin(c->shaded, (double)(clock() - placed) / CLOCKS_PER_SEC);
    return 0;
}

static void report(const bn_options *options, const match *m, const crowd *c)
{
    const sfield_scene_stats *s = &c->stats;
    const crowd *few = &m->crowds[0];
    bn_begin(options, "sfield_crowd", options->threads, bn_sfield_simd());
    bn_integer("entities", c->bodies);
    bn_integer("lights", c->lamps);
    bn_integer("vertices", (uint64_t)(SEEN * (ON_BODY + AROUND)));
    bn_number("seen", (double)(s->pairs - s->culled_far - s->culled_horizon) / (double)s->points);
    bn_number("products", (double)s->products / (double)s->points);
    bn_number("place_cpu_seconds", c->placed);
    bn_number("shade_cpu_seconds", c->shaded);
    bn_number("shade_by_few", c->shaded / few->shaded);
    bn_number("frame_by_few", (c->placed + c->shaded) / (few->placed + few->shaded));
    bn_end(options);
}

int bn_sfield_crowd(const bn_options *options)
{
    match *m = calloc(1, sizeof *m);
    char error[EX_ERROR_SIZE] = "out of memory";
    int result = m ? ex_scene_builtin(&m->chess, "chess", 0, error) : -1;
    if (result == 0)
        result = build(m, options);
    for (uint32_t i = 0; i < SCENES && result == 0; i++)
        result = open_crowd(m, options, i);
    for (int i = 0; i < (options->full ? 40 : 12) && result == 0; i++)
        for (uint32_t k = 0; k < SCENES && result == 0; k++)
            result = frame(m, &m->crowds[k], (float)i / 30);
    for (uint32_t i = 0; i < SCENES && m; i++) {
        if (result == 0)
            report(options, m, &m->crowds[i]);
        sfield_scene_free(m->crowds[i].scene);
        free(m->crowds[i].floor);
    }
    for (int i = 0; i < MESHES && m; i++) {
        sfield_free(m->occlusion[i]);
        sfield_free(m->self[i]);
        bn_points_free(&m->points[i]);
    }
    if (m) {
        sfield_free(m->lamp);
        ex_scene_free(&m->chess);
        free(m->up);
        free(m->rgb);
    }
    free(m);
    return result == 0 ? 0 : bn_failed("sfield_crowd", error[0] ? error : "out of memory");
}
