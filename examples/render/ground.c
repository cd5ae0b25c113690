/* ground.c - see ground.h */
#include "ground.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define GROWTH 6.0             /* of a square beside the one inside it */
#define MOST_RINGS 8
#define MOST_CORNERS 16        /* of a rectangle that is cut along every plane */

typedef struct box { double x0, z0, x1, z1; } box;      /* a rectangle on the ground */

typedef struct cut { double a, b, c; } cut;             /* inside where a x + b z + c >= 0 */

typedef struct cover { cut cuts[RD_COVER_PLANES]; int count; float irradiance[3]; } cover;

/* ---- areas ---- */

static double value_at(const cut *c, const double *p) { return c->a * p[0] + c->b * p[1] + c->c; }

/* The part of a convex polygon on the inner side of a line (Sutherland and Hodgman 1974); returns its corners. */
static int clip(double to[][2], double from[][2], int count, const cut *line)
{
    int kept = 0;
    for (int i = 0; i < count; i++) {
        const double *p = from[i], *q = from[(i + 1) % count];
        double at_p = value_at(line, p), at_q = value_at(line, q);
        if (at_p >= 0) {
            to[kept][0] = p[0];
            to[kept++][1] = p[1];
        }
        if ((at_p >= 0) != (at_q >= 0)) {
            double t = at_p / (at_p - at_q);
            to[kept][0] = p[0] + t * (q[0] - p[0]);
            to[kept++][1] = p[1] + t * (q[1] - p[1]);
        }
    }
    return kept;
}

static double polygon_area(double p[][2], int count)
{
    double twice = 0;
    for (int i = 0; i < count; i++) {
        const double *a = p[i], *b = p[(i + 1) % count];
        twice += (a[0] - p[0][0]) * (b[1] - p[0][1]) - (b[0] - p[0][0]) * (a[1] - p[0][1]);
    }
    return fabs(0.5 * twice);
}

static double box_area(const box *b)
{
    return b->x1 > b->x0 && b->z1 > b->z0 ? (b->x1 - b->x0) * (b->z1 - b->z0) : 0;
}

static box common(const box *a, const box *b)
{
    box out = { fmax(a->x0, b->x0), fmax(a->z0, b->z0), fmin(a->x1, b->x1), fmin(a->z1, b->z1) };
    return out;
}

/* Area of a box inside a cover. Most boxes lie on one side of all lines, or outside one. */
static double covered_area(const box *b, const cover *c)
{
    double corners[2][MOST_CORNERS][2] = { { { b->x0, b->z0 }, { b->x1, b->z0 }, { b->x1, b->z1 }, { b->x0, b->z1 } } };
    int count = 4, now = 0;
    if (!(box_area(b) > 0))
        return 0;
    for (int i = 0; i < c->count; i++) {
        int inside = 0;
        for (int k = 0; k < count; k++)
            inside += value_at(&c->cuts[i], corners[now][k]) >= 0;
        if (!inside)
            return 0;
        if (inside == count)
            continue;
        count = clip(corners[!now], corners[now], count, &c->cuts[i]);
        now = !now;
    }
    return polygon_area(corners[now], count);
}

/* ---- the ground ---- */

typedef struct ground { box all; double height; float albedo[3]; } ground;

static int read_ground(ground *g, const ex_scene *scene, const ex_object *object)
{
    const ex_mesh *mesh = &scene->meshes[object->mesh];
    const float *t = object->transform;
    double low = 1e300, high = -1e300;
    box b = { 1e300, 1e300, -1e300, -1e300 };
    if (!object->receiver_only || !mesh->triangle_count)
        return 0;
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        const float *p = mesh->positions + 3 * i;
        double world[3];
        for (int k = 0; k < 3; k++)
            world[k] = (double)(t[k] * p[0] + t[4 + k] * p[1] + t[8 + k] * p[2] + t[12 + k]);
        b.x0 = fmin(b.x0, world[0]);
        b.x1 = fmax(b.x1, world[0]);
        b.z0 = fmin(b.z0, world[2]);
        b.z1 = fmax(b.z1, world[2]);
        low = fmin(low, world[1]);
        high = fmax(high, world[1]);
    }
    g->all = b;
    g->height = low;
    memcpy(g->albedo, scene->materials[ex_object_material(scene, object, 0)].base_color, sizeof g->albedo);
    return high - low <= 1e-5 * (b.x1 - b.x0 + b.z1 - b.z0);
}

static int find_ground(ground *g, const ex_scene *scene)
{
    for (uint32_t i = 0; i < scene->object_count; i++)
        if (read_ground(g, scene, &scene->objects[i]))
            return 1;
    return 0;
}

int rd_ground_near(const rd_job *job, float corners[4][3])
{
    double x = (double)job->center[0], z = (double)job->center[2], r = (double)job->radius;
    box near_by = { x - r, z - r, x + r, z + r };
    ground g;
    if (!find_ground(&g, job->scene))
        return 0;
    near_by = common(&near_by, &g.all);
    for (int i = 0; i < 4; i++) {
        corners[i][0] = (float)(i == 1 || i == 2 ? near_by.x1 : near_by.x0);
        corners[i][1] = (float)g.height;
        corners[i][2] = (float)(i < 2 ? near_by.z1 : near_by.z0);
    }
    return 1;
}

/* What the lamps' pictures show of the ground; lamps below it are left out. */
static size_t cut_covers(cover *out, const rd_cover *covers, size_t count, double height)
{
    size_t used = 0;
    for (size_t i = 0; i < count; i++) {
        const float *e = covers[i].irradiance;
        if (!(e[0] > 0 || e[1] > 0 || e[2] > 0))
            continue;
        out[used].count = covers[i].plane_count;
        memcpy(out[used].irradiance, e, sizeof out[used].irradiance);
        for (int k = 0; k < covers[i].plane_count; k++) {
            const double *plane = covers[i].planes[k];
            out[used].cuts[k].a = plane[0];
            out[used].cuts[k].b = plane[2];
            out[used].cuts[k].c = plane[1] * height + plane[3];
        }
        used++;
    }
    return used;
}

/* ---- rings ---- */

/* One texel: its ground without the square inside (NULL: none), and without what each lamp's picture shows. */
static void light_texel(rd_ring *ring, size_t at, const ground *g, const box *texel, const box *inner,
                        const cover *covers, size_t count)
{
    box whole = common(texel, &g->all), hole = { 0, 0, 0, 0 };
    double all, sum[3] = { 0, 0, 0 };
    if (inner)
        hole = common(&whole, inner);
    all = box_area(&whole) - box_area(&hole);
    if (!(all > 1e-9 * box_area(texel)))
        return;
    for (size_t i = 0; i < count; i++) {
        double lit = all - covered_area(&whole, &covers[i]) + covered_area(&hole, &covers[i]);
        for (int k = 0; k < 3 && lit > 0; k++)
            sum[k] += (double)covers[i].irradiance[k] * lit;
    }
    for (size_t k = 0; k < 3; k++)
        ring->radiosity[3 * at + k] = (float)((double)g->albedo[k] * sum[k] / box_area(texel));
    ring->areas[at] = (float)all;
}

static int build_ring(rd_ring *ring, const rd_job *job, const ground *g, double half, double inner_half,
                      const cover *covers, size_t count)
{
    size_t texels = (size_t)RD_RING_SIDE * RD_RING_SIDE;
    double x = (double)job->center[0], z = (double)job->center[2], step = 2 * half / RD_RING_SIDE;
    box inner = { x - inner_half, z - inner_half, x + inner_half, z + inner_half };
    float *block = calloc(10 * texels, sizeof *block);
    if (!block)
        return -1;
    ring->positions = block;
    ring->normals = block + 3 * texels;
    ring->radiosity = block + 6 * texels;
    ring->areas = block + 9 * texels;
    ring->half = (float)half;
    memcpy(ring->center, job->center, sizeof ring->center);
    ring->center[1] = (float)g->height;
    for (uint32_t v = 0; v < RD_RING_SIDE; v++)
        for (uint32_t u = 0; u < RD_RING_SIDE; u++) {
            size_t at = (size_t)v * RD_RING_SIDE + u;
            box texel = { x - half + u * step, z + half - (v + 1) * step, x - half + (u + 1) * step,
                          z + half - v * step };
            ring->positions[3 * at] = (float)(0.5 * (texel.x0 + texel.x1));
            ring->positions[3 * at + 1] = (float)g->height;
            ring->positions[3 * at + 2] = (float)(0.5 * (texel.z0 + texel.z1));
            ring->normals[3 * at + 1] = 1;
            light_texel(ring, at, g, &texel, inner_half > 0 ? &inner : NULL, covers, count);
        }
    return 0;
}

void rd_rings_free(rd_ring *rings, size_t count)
{
    for (size_t i = 0; i < count; i++)
        free(rings[i].positions);
    free(rings);
}

int rd_rings_build(rd_ring **rings, size_t *count, const rd_job *job, const rd_cover *covers, size_t cover_count)
{
    ground g;
    cover *cuts;
    double reach, half = (double)job->radius, inner = 0;
    *rings = NULL;
    *count = 0;
    if (!cover_count || !find_ground(&g, job->scene))
        return 0;
    cuts = malloc(cover_count * sizeof *cuts);
    *rings = calloc(MOST_RINGS, sizeof **rings);
    if (cuts && *rings)
        cover_count = cut_covers(cuts, covers, cover_count, g.height);
    reach = fmax(fmax((double)job->center[0] - g.all.x0, g.all.x1 - (double)job->center[0]),
                 fmax((double)job->center[2] - g.all.z0, g.all.z1 - (double)job->center[2]));
    while (cuts && *rings && cover_count && inner < reach && *count < MOST_RINGS) {
        half *= GROWTH;
        if (build_ring(&(*rings)[*count], job, &g, half, inner, cuts, cover_count) != 0)
            break;
        inner = half;
        ++*count;
    }
    free(cuts);
    if (cuts && *rings && (!cover_count || inner >= reach || *count == MOST_RINGS))
        return 0;
    rd_rings_free(*rings, *count);
    *rings = NULL;
    *count = 0;
    return -1;
}
