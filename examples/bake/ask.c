/* ask.c - see ask.h. With csm.h, a mesh has maps of its own space, which all its objects share that are turned, moved
   and scaled evenly; another object, mirrored or sheared, has maps of its own in the world's space. The directions are
   the centres of the maps' cells, so that a point's own object answers without rounding the direction; other objects
   round it to their nearest map. */
#include "ask.h"
#include "../render/csm_parts.h"


#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Map pixels, as docs/bake.md has measured: a plane does not shadow itself by more than 0.003, and the corner of two
   sheets is dark on either side. Rays raise a point by OFFSET of its object's size. */
#define THICKNESS 2.0f
#define BIAS 0.5f
#define RAISE 0.25f
#define OFFSET 1e-4f

enum { GROUP = 512 };

typedef struct caster {              /* what has maps */
    uint32_t    mesh, object;        /* object: one that has them */
    int         shared;              /* by all even placements of the mesh; else it is in world space */
    cohsm_maps *maps;
    float       center[3], radius;   /* in its own space */
} caster;

typedef struct placed {              /* each object of the scene */
    uint32_t caster;
    float    matrix[16], inverse[12], scale;     /* the caster's space to the world's, columns; and back */
    float    center[3], radius;                  /* in the world */
    float    offset;                             /* in the caster's space: rays begin so far above the surface */
} placed;

struct bk_ask {
    bk_ask_desc desc;
    bk_engine   engine;
    const ex_scene *scene;
    ex_pool    *pool;
    caster     *casters;
    placed     *placed;
    uint32_t    caster_count;
    float      *directions;          /* side x side of them */
    uint32_t    direction_count;
    bk_rays    *rays;
};

typedef struct run {                 /* of bk_ask_all */
    bk_ask  *ask;
    uint32_t mesh;
    const float *positions, *normals;
    size_t   from, to;
    bk_take  take;
    void    *user;
    int      failed;                 /* a cohsm_result, or -1: out of memory */
} run;

typedef struct group {               /* points of one group, in the space of a caster */
    size_t   count, first;
    float    points[3 * GROUP], normals[3 * GROUP], center[3], radius;
    uint32_t facing[GROUP], number[GROUP], some[GROUP];
    float    cosines[GROUP], own[GROUP], visible[GROUP], answer[GROUP];
    float    asked[3 * GROUP], world[3 * GROUP], moved[3 * GROUP];
    size_t   facing_count;
} group;

/* ---- placement ---- */

static float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void point_to(const float *m, const float *p, float *out)
{
    for (int k = 0; k < 3; k++)
        out[k] = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
}

static void back(const placed *o, const float *p, float *out)
{
    for (int k = 0; k < 3; k++)
        out[k] = dot(o->inverse + 3 * k, p) + o->inverse[9 + k];
}

/* Is it a rotation with one scale? */
static int is_even(const float *m)
{
    const float xx = dot(m, m), limit = 2e-3f * xx;
    const float x[3] = { m[1] * m[6] - m[2] * m[5], m[2] * m[4] - m[0] * m[6], m[0] * m[5] - m[1] * m[4] };
    return fabsf(dot(m + 4, m + 4) - xx) < limit && fabsf(dot(m + 8, m + 8) - xx) < limit &&
           fabsf(dot(m, m + 4)) < limit && fabsf(dot(m, m + 8)) < limit && fabsf(dot(m + 4, m + 8)) < limit &&
           dot(x, m + 8) > 0;
}

typedef struct ball { float center[3], radius; } ball;

/* About a mesh's box. */
static ball ball_of(const ex_mesh *mesh)
{
    ball out = { { 0, 0, 0 }, 0 };
    for (size_t k = 0; k < 3; k++) {
        float low = HUGE_VALF, high = -HUGE_VALF;
        for (size_t i = 0; i < mesh->vertex_count; i++) {
            low = fminf(low, mesh->positions[3 * i + k]);
            high = fmaxf(high, mesh->positions[3 * i + k]);
        }
        out.center[k] = high > low ? 0.5f * (low + high) : low < HUGE_VALF ? low : 0;
        out.radius += high > low ? (high - low) * (high - low) : 0;
    }
    out.radius = 0.5f * sqrtf(out.radius);
    return out;
}

static void place(placed *o, const float *matrix)
{
    memcpy(o->matrix, matrix, sizeof o->matrix);
    o->scale = sqrtf(dot(matrix, matrix));
    for (int k = 0; k < 3; k++) {
        for (int l = 0; l < 3; l++)
            o->inverse[3 * k + l] = matrix[4 * k + l] / (o->scale * o->scale);
        o->inverse[9 + k] = -dot(o->inverse + 3 * k, matrix + 12);
    }
}

static const float identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };

/* Which caster each object has. */
static int place_all(bk_ask *ask)
{
    const ex_scene *s = ask->scene;
    uint32_t *of_mesh = calloc((size_t)s->mesh_count + 1, sizeof *of_mesh);
    ball *balls = malloc(((size_t)s->mesh_count + 1) * sizeof *balls);
    ask->casters = calloc((size_t)s->object_count + 1, sizeof *ask->casters);
    ask->placed = calloc((size_t)s->object_count + 1, sizeof *ask->placed);
    if (!of_mesh || !balls || !ask->casters || !ask->placed) {
        free(of_mesh);
        free(balls);
        return -1;
    }
    for (uint32_t i = 0; i < s->mesh_count; i++)
        balls[i] = ball_of(&s->meshes[i]);
    for (uint32_t i = 0; i < s->object_count; i++) {
        const ex_object *o = &s->objects[i];
        const int even = is_even(o->transform);
        const float scale = sqrtf(dot(o->transform, o->transform));
        uint32_t number = even ? of_mesh[o->mesh] : 0;
        if (!number) {
            caster *c = &ask->casters[ask->caster_count++];
            number = ask->caster_count;
            c->mesh = o->mesh;
            c->object = i;
            c->shared = even;
            if (even)
                of_mesh[o->mesh] = number;
        }
        ask->placed[i].caster = number - 1;
        place(&ask->placed[i], even ? o->transform : identity);
        ask->placed[i].offset = OFFSET * balls[o->mesh].radius * (even ? 1 : scale);
        ask->placed[i].radius = balls[o->mesh].radius * scale;
        point_to(o->transform, balls[o->mesh].center, ask->placed[i].center);
    }
    free(of_mesh);
    free(balls);
    return 0;
}

/* ---- what is in the way ---- */

static int soup_of(const bk_ask *ask, const uint32_t *objects, uint32_t count, const float *matrix, cs_soup *soup)
{
    size_t vertices = 0, triangles = 0;
    memset(soup, 0, sizeof *soup);
    for (uint32_t i = 0; i < count; i++)
        cs_soup_count(ask->scene, &ask->scene->objects[objects ? objects[i] : i], &vertices, &triangles);
    soup->positions = malloc((3 * vertices + 1) * sizeof *soup->positions);
    soup->indices = malloc((3 * triangles + 1) * sizeof *soup->indices);
    if (!soup->positions || !soup->indices || vertices > UINT32_MAX)
        return -1;
    for (uint32_t i = 0; i < count; i++) {
        const ex_object *o = &ask->scene->objects[objects ? objects[i] : i];
        cs_soup_add(soup, ask->scene, o, matrix ? matrix : o->transform, 0);
    }
    return 0;
}

static void soup_free(cs_soup *soup)
{
    free(soup->positions);
    free(soup->indices);
}

static cohsm_desc desc_of(const bk_ask *ask)
{
    cohsm_desc d;
    memset(&d, 0, sizeof d);
    d.domain.kind = COHSM_DOMAIN_OCTAHEDRAL;
    d.domain.side[0] = d.domain.side[1] = ask->desc.side;
    d.map_side = ask->desc.map_side;
    d.order = COHSM_ORDER_HILBERT;
    d.orientation = COHSM_ORIENTATION_POLAR;
    d.open_thickness = THICKNESS;
    return d;
}

/* Directions are where the maps look from, whether there are maps or not. */
static int find_directions(bk_ask *ask)
{
    cohsm_desc d = desc_of(ask);
    cohsm_builder *builder;
    cohsm_view view;
    d.map_side = 4;
    d.radius = 1;
    if (cohsm_builder_create(&d, &builder) != COHSM_OK)
        return -1;
    ask->direction_count = cohsm_builder_view_count(builder);
    ask->directions = malloc(3 * (size_t)ask->direction_count * sizeof *ask->directions);
    for (uint32_t i = 0; i < ask->direction_count && ask->directions; i++)
        if (cohsm_builder_view(builder, i, &view) == COHSM_OK)
            memcpy(ask->directions + 3 * (size_t)i, view.location, 12);
    cohsm_builder_free(builder);
    return ask->directions ? 0 : -1;
}

static int build_maps(bk_ask *ask, char *error)
{
    static char label[] = "maps";
    ex_pool_label(ask->pool, label);
    for (uint32_t i = 0; i < ask->caster_count; i++) {
        caster *c = &ask->casters[i];
        cohsm_desc d = desc_of(ask);
        cohsm_info info;
        cs_soup soup;
        cohsm_result result = COHSM_ERR_ALLOC;
        d.system.parallel_for = ex_pool_run;
        d.system.log = ex_pool_log;
        d.system.user = ask->pool;
        if (soup_of(ask, &c->object, 1, c->shared ? identity : NULL, &soup) == 0 && soup.triangles) {
            const cohsm_mesh mesh = { soup.positions, soup.vertices, 0, soup.indices, 3 * soup.triangles,
                                      NULL, NULL, NULL };
            result = cohsm_build(&d, &mesh, &c->maps, NULL);
        } else if (soup.indices) result = COHSM_ERR_INPUT;
        soup_free(&soup);
        if (result == COHSM_ERR_INPUT)           /* nothing in it casts a shadow */
            continue;
        if (result != COHSM_OK)
            return bk_fail(error, "maps: ", cohsm_result_text(result));
        cohsm_get_info(c->maps, &info);
        memcpy(c->center, info.center, sizeof c->center);
        c->radius = info.radius;
        ex_progress(label, (float)(i + 1) / (float)ask->caster_count);
    }
    for (uint32_t i = 0; i < ask->scene->object_count; i++) {
        placed *o = &ask->placed[i];
        point_to(o->matrix, ask->casters[o->caster].center, o->center);
        o->radius = ask->casters[o->caster].radius * o->scale;
    }
    return 0;
}

static int build_rays(bk_ask *ask, char *error)
{
    cs_soup soup;
    if (soup_of(ask, NULL, ask->scene->object_count, NULL, &soup) == 0)
        ask->rays = bk_rays_create(soup.positions, soup.vertices, soup.indices, soup.triangles);
    soup_free(&soup);
    if (ask->rays)
        return 0;
    snprintf(error, EX_ERROR_SIZE, "out of memory for Embree");
    return -1;
}

/* ---- what it costs: nanoseconds of one core, as docs/bake.md has measured ---- */

/* How often a map's disc is covered, on average over all directions, since a triangle is seen with half its area. */
static double depth_of(const ex_mesh *mesh, double radius)
{
    double area = 0;
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i += 3) {
        const float *a = mesh->positions + 3 * (size_t)mesh->indices[i];
        const float *b = mesh->positions + 3 * (size_t)mesh->indices[i + 1];
        const float *c = mesh->positions + 3 * (size_t)mesh->indices[i + 2];
        double square = 0;
        for (int k = 0; k < 3; k++) {
            const int m = (k + 1) % 3, n = (k + 2) % 3;
            const double x = (double)((b[m] - a[m]) * (c[n] - a[n]) - (b[n] - a[n]) * (c[m] - a[m]));
            square += x * x;
        }
        area += 0.5 * sqrt(square);
    }
    return radius > 0 ? area / (2 * 3.14159265 * radius * radius) : 0;
}

/* Of how many other objects the maps must be asked for a group of an object's points, on average over all directions:
   those whose spheres the group's meets on its way. */
static double near_objects(const bk_ask *ask, uint32_t side, uint32_t self, size_t points)
{
    const placed *me = &ask->placed[self];
    const double slack = 3.2 / side + 4.0 / ask->desc.map_side;
    const double radius = (double)me->radius * (points > GROUP ? sqrt((double)GROUP / (double)points) : 1);
    double sum = 0;
    for (uint32_t i = 0; i < ask->scene->object_count; i++) {
        const placed *o = &ask->placed[i];
        const double x = (double)(o->center[0] - me->center[0]), y = (double)(o->center[1] - me->center[1]);
        const double z = (double)(o->center[2] - me->center[2]), distance = sqrt(x * x + y * y + z * z);
        const double sine = distance > 0 ? 1.02 * ((double)o->radius + radius) / distance + slack : 2;
        if (i != self)
            sum += sine < 1 ? 0.5 * (1 - sqrt(1 - sine * sine)) : 0.5;
    }
    return sum;
}

bk_engine bk_ask_cheaper(const bk_ask *ask, uint32_t side, const size_t *points, double open)
{
    enum { OBJECTS = 64 };
    const ex_scene *s = ask->scene;
    const double directions = (double)side * side, pixels = pow(ask->desc.map_side, 2);
    const uint32_t step = s->object_count / OBJECTS + 1;
    double maps = 0, rays = 0;
    for (uint32_t i = 0; i < s->object_count; i += step) {
        const double questions = (double)points[s->objects[i].mesh] * directions / 2 * step;
        maps += questions * (30 + 20 * near_objects(ask, side, i, points[s->objects[i].mesh]));
        rays += questions * (30 + 200 * open);    /* a ray that meets something ends there */
    }
    for (uint32_t i = 0; i < ask->caster_count; i++) {
        const ex_mesh *m = &s->meshes[ask->casters[i].mesh];
        const placed *o = &ask->placed[ask->casters[i].object];
        const double count = m->triangle_count, radius = (double)(o->radius / (o->scale > 0 ? o->scale : 1));
        maps += 600 * count + directions * (2.7 * count * fmin(1 + 1e-6 * count, 2) +
                                            24 * depth_of(m, radius) * pixels);
        rays += 450 * count;
    }
    return maps < rays ? BK_ENGINE_CSM : BK_ENGINE_EMBREE;
}

int bk_ask_open(bk_ask **out, const bk_ask_desc *desc, const ex_scene *scene, ex_pool *pool, char *error)
{
    const int only_rays = desc->distance > 0, only_maps = desc->self_only;
    bk_ask *ask = calloc(1, sizeof *ask);
    int result = 0;
    *out = NULL;
    if ((only_rays || desc->engine == BK_ENGINE_EMBREE) && !bk_rays_there())
        snprintf(error, EX_ERROR_SIZE, "%s needs Embree: apt-get install libembree-dev",
                 only_rays ? "distance" : "--engine embree"), result = -1;
    else if (only_maps && (only_rays || desc->engine == BK_ENGINE_EMBREE))
        snprintf(error, EX_ERROR_SIZE, "instances=self needs --engine csm and no distance"), result = -1;
    else if (only_rays && desc->engine == BK_ENGINE_CSM)
        snprintf(error, EX_ERROR_SIZE, "distance needs --engine embree: maps hold no distances"), result = -1;
    if (result != 0 || !ask) {
        free(ask);
        return result != 0 ? result : bk_fail(error, "out of memory", "");
    }
    ask->desc = *desc;
    ask->scene = scene;
    ask->pool = pool;
    if (place_all(ask) != 0 || find_directions(ask) != 0)
        result = bk_fail(error, "out of memory", "");
    if (result == 0) {
        ask->engine = only_rays || desc->engine == BK_ENGINE_EMBREE ? BK_ENGINE_EMBREE : BK_ENGINE_CSM;
        result = ask->engine == BK_ENGINE_CSM ? build_maps(ask, error) : build_rays(ask, error);
    }
    if (result == 0)
        *out = ask;
    else bk_ask_close(ask);
    return result;
}

bk_engine bk_ask_engine(const bk_ask *ask) { return ask->engine; }

int bk_ask_turn(bk_ask *ask, uint32_t side, char *error)
{
    free(ask->directions);
    ask->directions = NULL;
    ask->desc.side = side;
    return find_directions(ask) == 0 ? 0 : bk_fail(error, "out of memory", "");
}

void bk_ask_close(bk_ask *ask)
{
    if (!ask)
        return;
    for (uint32_t i = 0; i < ask->caster_count; i++)
        cohsm_free(ask->casters[i].maps);
    bk_rays_free(ask->rays);
    free(ask->casters);
    free(ask->placed);
    free(ask->directions);
    free(ask);
}

/* ---- asking ---- */

/* Points and normals of the group in the caster's space. */
static void gather(const run *r, const caster *c, group *g)
{
    const float *m = c->shared ? identity : r->ask->scene->objects[c->object].transform;
    const float x[3] = { m[5] * m[10] - m[6] * m[9], m[6] * m[8] - m[4] * m[10], m[4] * m[9] - m[5] * m[8] };
    const float side = dot(m, x) < 0 ? -1.0f : 1.0f;
    float low[3] = { HUGE_VALF, HUGE_VALF, HUGE_VALF }, high[3] = { -HUGE_VALF, -HUGE_VALF, -HUGE_VALF };
    for (size_t i = 0; i < g->count; i++) {
        const float *n = r->normals + 3 * (g->first + i);
        float *to = g->normals + 3 * i, length;
        point_to(m, r->positions + 3 * (g->first + i), g->points + 3 * i);
        for (int k = 0; k < 3; k++) {
            const int a = (k + 1) % 3, b = (k + 2) % 3;
            to[k] = side * ((m[4 + a] * m[8 + b] - m[4 + b] * m[8 + a]) * n[0] +
                            (m[8 + a] * m[b] - m[8 + b] * m[a]) * n[1] + (m[a] * m[4 + b] - m[b] * m[4 + a]) * n[2]);
            low[k] = fminf(low[k], g->points[3 * i + (size_t)k]);
            high[k] = fmaxf(high[k], g->points[3 * i + (size_t)k]);
        }
        length = sqrtf(dot(to, to));
        for (int k = 0; k < 3; k++)
            to[k] = length > 0 ? to[k] / length : n[k];
    }
    for (int k = 0; k < 3; k++)
        g->center[k] = 0.5f * (low[k] + high[k]);
    g->radius = 0.5f * sqrtf((high[0] - low[0]) * (high[0] - low[0]) + (high[1] - low[1]) * (high[1] - low[1]) +
                             (high[2] - low[2]) * (high[2] - low[2]));
}

/* Which points face the direction; they come into `asked`, raised by a share of `raise` that grows with the slant. */
static void face(group *g, const float *direction, float raise)
{
    g->facing_count = 0;
    for (size_t i = 0; i < g->count; i++) {
        const float cosine = dot(g->normals + 3 * i, direction);
        float slant;
        if (!(cosine > 0))
            continue;
        slant = raise * sqrtf(fmaxf(1 - cosine * cosine, 0));
        for (size_t k = 0; k < 3; k++)
            g->asked[3 * g->facing_count + k] = g->points[3 * i + k] + slant * g->normals[3 * i + k];
        g->cosines[g->facing_count] = cosine;
        g->facing[g->facing_count++] = (uint32_t)i;
    }
}

static int ask_maps(const cohsm_maps *maps, const float *points, size_t count, const float *direction, float bias,
                    float *visible)
{
    cohsm_query q;
    memset(&q, 0, sizeof q);
    q.count = count;
    q.positions = points;
    q.lights = direction;
    q.one_light = 1;
    q.bias = bias;
    return (int)cohsm_visible(maps, &q, visible, NULL);
}

/* May the object hide the group's sphere along the direction? Its maps are of other directions, up to slack away. */
static int is_near(const placed *o, const float *center, float radius, const float *direction, float slack)
{
    const float v[3] = { o->center[0] - center[0], o->center[1] - center[1], o->center[2] - center[2] };
    const float along = dot(v, direction), v2 = dot(v, v), reach = (o->radius + radius) * 1.02f + slack * sqrtf(v2);
    return v2 - along * along < reach * reach && along > -reach;
}

/* Takes away what other objects hide from the group's points on object `self`. */
static int ask_others(const bk_ask *ask, uint32_t self, group *g, const float *world)
{
    const placed *me = &ask->placed[self];
    const float slack = 3.2f / (float)ask->desc.side + 4.0f / (float)ask->desc.map_side;
    float center[3];
    int moved = 0, result = 0;
    point_to(me->matrix, g->center, center);
    for (uint32_t i = 0; i < ask->scene->object_count && result == 0; i++) {
        const placed *o = &ask->placed[i];
        float direction[3];
        size_t n = 0;
        if (i == self || !ask->casters[o->caster].maps || !is_near(o, center, g->radius * me->scale, world, slack))
            continue;
        for (size_t k = 0; k < g->facing_count && !moved; k++)
            point_to(me->matrix, g->asked + 3 * k, g->world + 3 * k);
        moved = 1;
        for (size_t k = 0; k < g->facing_count; k++)
            if (g->visible[k] > 0) {
                back(o, g->world + 3 * k, g->moved + 3 * n);
                g->some[n++] = (uint32_t)k;
            }
        for (int k = 0; k < 3; k++)
            direction[k] = dot(o->inverse + 3 * k, world) * o->scale;
        if (n)
            result = ask_maps(ask->casters[o->caster].maps, g->moved, n, direction, -1, g->answer);
        for (size_t k = 0; k < n; k++)
            g->visible[g->some[k]] *= g->answer[k];
    }
    return result;
}

/* A plane hides what is below it: every direction that goes down, within the distance. */
static void ask_ground(const bk_ask *ask, const placed *me, group *g, const float *world)
{
    for (size_t k = 0; k < g->facing_count && world[1] < 0; k++) {
        float p[3];
        point_to(me->matrix, g->asked + 3 * k, p);
        if (!(ask->desc.distance > 0) || p[1] - ask->desc.ground < -world[1] * ask->desc.distance)
            g->visible[k] = 0;
    }
}

/* Rays begin a little above the surface. */
static void ask_rays(const bk_ask *ask, const placed *me, group *g, const float *world)
{
    for (size_t k = 0; k < g->facing_count; k++) {
        const float *n = g->normals + 3 * (size_t)g->facing[k];
        float p[3], moved[3];
        for (int j = 0; j < 3; j++)
            moved[j] = g->asked[3 * k + (size_t)j] + me->offset * n[j];
        point_to(me->matrix, moved, p);
        memcpy(g->world + 3 * k, p, sizeof p);
    }
    bk_rays_trace(ask->rays, g->world, world, 0, g->facing_count, ask->desc.distance, g->visible);
}

/* A direction of the caster's space in the mesh's, as a normal goes the other way: by the transposed matrix. */
static void to_mesh(const run *r, const caster *c, const float *direction, float *out)
{
    const float *m = r->ask->scene->objects[c->object].transform;
    float length;
    if (c->shared) {
        memcpy(out, direction, 12);
        return;
    }
    for (int k = 0; k < 3; k++)
        out[k] = dot(m + 4 * k, direction);
    length = sqrtf(dot(out, out));
    for (int k = 0; k < 3; k++)
        out[k] /= length > 0 ? length : 1;
}

/* One direction, for every object that has these maps. */
static int ask_direction(const run *r, uint32_t number, group *g, const float *direction)
{
    const bk_ask *ask = r->ask;
    const caster *c = &ask->casters[number];
    bk_answer answer;
    face(g, direction, c->maps ? RAISE * 2 * c->radius / (float)ask->desc.map_side : 0);
    for (size_t k = 0; k < g->facing_count; k++) {
        g->number[k] = (uint32_t)(g->first - r->from) + g->facing[k];
        g->own[k] = 1;
    }
    if (c->maps && ask_maps(c->maps, g->asked, g->facing_count, direction, BIAS, g->own) != 0)
        return -1;
    for (uint32_t i = 0; i < ask->scene->object_count && g->facing_count; i++) {
        const placed *me = &ask->placed[i];
        float world[3];
        if (me->caster != number)
            continue;
        for (int k = 0; k < 3; k++)
            world[k] =
                (me->matrix[k] * direction[0] + me->matrix[4 + k] * direction[1] + me->matrix[8 + k] * direction[2]) /
                me->scale;
        memcpy(g->visible, g->own, g->facing_count * sizeof *g->visible);
        if (ask->rays)
            ask_rays(ask, me, g, world);
        else if (!ask->desc.self_only && ask_others(ask, i, g, world) != 0)
            return -1;
        if (ask->desc.has_ground && !ask->desc.self_only)
            ask_ground(ask, me, g, world);
        answer.points = g->number;
        answer.cosines = g->cosines;
        answer.visible = g->visible;
        answer.count = g->facing_count;
        memcpy(answer.world, world, sizeof answer.world);
        to_mesh(r, c, direction, answer.direction);
        r->take(r->user, &answer);
    }
    return 0;
}

static void ask_group(void *context, size_t index)
{
    run *r = context;
    const bk_ask *ask = r->ask;
    group *g = malloc(sizeof *g);
    int result = g ? 0 : -1;
    for (uint32_t c = 0; c < ask->caster_count && result == 0; c++) {
        if (ask->casters[c].mesh != r->mesh)
            continue;
        g->first = r->from + index * GROUP;
        g->count = r->to - g->first < GROUP ? r->to - g->first : GROUP;
        gather(r, &ask->casters[c], g);
        for (uint32_t k = 0; k < ask->direction_count && result == 0; k++)
            result = ask_direction(r, c, g, ask->directions + 3 * (size_t)k);
    }
    free(g);
    if (result != 0)
        __atomic_store_n(&r->failed, 1, __ATOMIC_RELAXED);
}

int bk_ask_all(bk_ask *ask, uint32_t mesh, const float *positions, const float *normals, size_t from, size_t to,
               bk_take take, void *user, char *error)
{
    run r = { ask, mesh, positions, normals, from, to, take, user, 0 };
    ex_pool_run(ask->pool, (to - from + GROUP - 1) / GROUP, ask_group, &r);
    return r.failed ? bk_fail(error, "out of memory", "") : 0;
}
