/* csm_cut.c - triangles of the technique csm's casters; where an alpha mask cuts holes, only what is left of them.
   A masked triangle becomes a grid of small ones, about one a texel, of which those stay whose middle is solid: the
   maps then hold the holes, and the border of a hole is off by half a cell at most. */
#include "csm_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_CELLS = 256, MOST_SMALL = 1 << 22 };     /* along an edge; small triangles in one mesh */

static int is_masked(const ex_scene *scene, const ex_object *object, uint32_t triangle)
{
    return scene->materials[ex_object_material(scene, object, triangle)].alpha_cutoff > 0;
}

int cs_has_holes(const ex_scene *scene, const ex_object *object)
{
    const ex_mesh *mesh = &scene->meshes[object->mesh];
    for (uint32_t t = 0; t < mesh->triangle_count; t++)
        if (is_masked(scene, object, t))
            return 1;
    return 0;
}

int cs_is_there(void *masked, uint32_t triangle, const float weights[3])
{
    const cs_masked *m = masked;
    float colour[3];
    return ex_surface_color(m->scene, m->object, triangle, weights, colour);
}

/* Cells along an edge, so that one is a texel or smaller. */
static uint32_t cells_of(const ex_scene *scene, const ex_object *object, uint32_t triangle, double share)
{
    const ex_mesh *mesh = &scene->meshes[object->mesh];
    const ex_material *m = &scene->materials[ex_object_material(scene, object, triangle)];
    const uint32_t *index = mesh->indices + 3 * (size_t)triangle;
    double most = 1;
    if (m->base_texture < 0 || !mesh->uvs)
        return 1;
    for (int i = 0; i < 3; i++) {
        const float *a = mesh->uvs + 2 * (size_t)index[i], *b = mesh->uvs + 2 * (size_t)index[(i + 1) % 3];
        const ex_texture *texture = &scene->textures[m->base_texture];
        most = fmax(most, fabs((double)a[0] - (double)b[0]) * texture->width);
        most = fmax(most, fabs((double)a[1] - (double)b[1]) * texture->height);
    }
    most = ceil(most * share);
    return most < 1 ? 1 : most > MOST_CELLS ? MOST_CELLS : (uint32_t)most;
}

/* Of all cells that masked triangles ask for, the share along an edge that keeps their number within bounds. */
static double share_of(const ex_scene *scene, const ex_object *object)
{
    const ex_mesh *mesh = &scene->meshes[object->mesh];
    double sum = 0;
    for (uint32_t t = 0; t < mesh->triangle_count; t++)
        if (is_masked(scene, object, t)) {
            double n = cells_of(scene, object, t, 1);
            sum += n * n;
        }
    return sum > MOST_SMALL ? sqrt(MOST_SMALL / sum) : 1;
}

void cs_soup_count(const ex_scene *scene, const ex_object *object, size_t *vertices, size_t *triangles)
{
    const ex_mesh *mesh = &scene->meshes[object->mesh];
    double share = share_of(scene, object);
    *vertices += mesh->vertex_count;
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        size_t n = is_masked(scene, object, t) ? cells_of(scene, object, t, share) : 1;
        *triangles += n * n;
        *vertices += n > 1 ? (n + 1) * (n + 2) / 2 : 0;
    }
}

/* Number of the grid's corner i, j: rows along the third corner's weight. */
static uint32_t corner(uint32_t n, uint32_t i, uint32_t j)
{
    return j * (n + 1) - j * (j - 1) / 2 + i;
}

/* Is the small triangle solid whose corners have the weights (i, j) / n, up to a third of a cell? */
static int is_solid(const ex_scene *scene, const ex_object *object, uint32_t triangle, uint32_t n, double i, double j)
{
    float weight[3], colour[3];
    weight[1] = (float)(i / n);
    weight[2] = (float)(j / n);
    weight[0] = 1 - weight[1] - weight[2];
    return ex_surface_color(scene, object, triangle, weight, colour);
}

static void add_triangle(cs_soup *s, uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t *to = s->indices + 3 * s->triangles++;
    to[0] = a;
    to[1] = b;
    to[2] = c;
}

/* The small triangles of one triangle; a grid without a hole is taken back and the triangle kept. */
static void add_cut(cs_soup *s, const ex_scene *scene, const ex_object *object, uint32_t triangle, uint32_t n,
                    const uint32_t *index)
{
    uint32_t base = (uint32_t)s->vertices;
    size_t first = s->triangles;
    float p[3][3], *to = s->positions + 3 * s->vertices;
    memcpy(p[0], s->positions + 3 * (size_t)index[0], sizeof p[0]);
    memcpy(p[1], s->positions + 3 * (size_t)index[1], sizeof p[1]);
    memcpy(p[2], s->positions + 3 * (size_t)index[2], sizeof p[2]);
    for (uint32_t j = 0; j < n; j++)
        for (uint32_t i = 0; i + j < n; i++) {
            if (is_solid(scene, object, triangle, n, i + 1.0 / 3, j + 1.0 / 3))
                add_triangle(s, base + corner(n, i, j), base + corner(n, i + 1, j), base + corner(n, i, j + 1));
            if (i + j + 1 < n && is_solid(scene, object, triangle, n, i + 2.0 / 3, j + 2.0 / 3))
                add_triangle(s, base + corner(n, i + 1, j), base + corner(n, i + 1, j + 1), base + corner(n, i, j + 1));
        }
    if (s->triangles - first == (size_t)n * n) {
        s->triangles = first;
        add_triangle(s, index[0], index[1], index[2]);
        return;
    }
    for (uint32_t j = 0; j <= n; j++)
        for (uint32_t i = 0; i + j <= n; i++)
            for (int k = 0; k < 3; k++)
                *to++ = p[0][k] + (p[1][k] - p[0][k]) * (float)i / (float)n + (p[2][k] - p[0][k]) * (float)j / (float)n;
    s->vertices += (size_t)(n + 1) * (n + 2) / 2;
}

static int is_emissive(const ex_scene *scene, const ex_object *object, uint32_t triangle)
{
    const float *e = scene->materials[ex_object_material(scene, object, triangle)].emission;
    return e[0] > 0 || e[1] > 0 || e[2] > 0;
}

void cs_soup_add(cs_soup *s, const ex_scene *scene, const ex_object *object, const float *m, int dark)
{
    const ex_mesh *mesh = &scene->meshes[object->mesh];
    float *to = s->positions + 3 * s->vertices;
    uint32_t base = (uint32_t)s->vertices;
    double share = share_of(scene, object);
    for (size_t i = 0; i < mesh->vertex_count; i++)
        for (size_t k = 0; k < 3; k++) {
            const float *p = mesh->positions + 3 * i;
            to[3 * i + k] = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
        }
    s->vertices += mesh->vertex_count;
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *from = mesh->indices + 3 * (size_t)t;
        uint32_t index[3] = { from[0] + base, from[1] + base, from[2] + base };
        size_t first = s->triangles;
        if (dark && is_emissive(scene, object, t))
            continue;
        if (is_masked(scene, object, t))
            add_cut(s, scene, object, t, cells_of(scene, object, t, share), index);
        else
            add_triangle(s, index[0], index[1], index[2]);
        for (; s->source && first < s->triangles; first++)
            s->source[first] = t;
    }
}
