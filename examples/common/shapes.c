/* shapes.c - shapes for the mesh builder beyond boxes, lathes and tubes. */
#include "internal.h"

ex_mark ex_build_mark(const ex_builder *b)
{
    ex_mark mark = {b->mesh.vertex_count, b->mesh.triangle_count};
    return mark;
}

void ex_build_transform(ex_builder *b, ex_mark since, const float m[16])
{
    ex_mesh *mesh = &b->mesh;
    for (size_t i = since.vertex; i < mesh->vertex_count && !b->failed; i++) {
        float *p = mesh->positions + 3 * i, *n = mesh->normals + 3 * i;
        v3 turned = ex_transform_normal(m, v3_load(n));
        v3_store(p, ex_transform_point(m, v3_load(p)));
        v3_store(n, v3_unit_or(turned, v3_make(0, 0, 0)));
    }
    if (ex_determinant(m) >= 0) return;
    for (size_t t = since.triangle; t < mesh->triangle_count && !b->failed; t++) {
        uint32_t *index = mesh->indices + 3 * t, swap = index[1];
        index[1] = index[2];
        index[2] = swap;
    }
    /* Cofactors turn normals with the old winding. */
    for (size_t i = since.vertex; i < mesh->vertex_count && !b->failed; i++)
        v3_store(mesh->normals + 3 * i, v3_scale(v3_load(mesh->normals + 3 * i), -1));
}

void ex_build_copy(ex_builder *b, ex_mark since, ex_mark until, const float m[16])
{
    ex_mark here = ex_build_mark(b);
    for (size_t i = since.vertex; i < until.vertex && !b->failed; i++) {
        v3 p = v3_load(b->mesh.positions + 3 * i), n = v3_load(b->mesh.normals + 3 * i);
        ex_build_vertex(b, p, n);
    }
    for (size_t t = since.triangle; t < until.triangle && !b->failed; t++) {
        const uint32_t *index = b->mesh.indices + 3 * t;
        uint32_t offset = here.vertex - since.vertex;
        ex_build_triangle(b, index[0] + offset, index[1] + offset, index[2] + offset, b->mesh.materials[t]);
    }
    ex_build_transform(b, here, m);
}

void ex_build_surface(ex_builder *b, ex_surface fn, const void *context, uint32_t across, uint32_t along, int flags,
                      uint32_t material)
{
    uint32_t columns = flags & EX_WRAP ? across : across + 1, previous = 0;
    for (uint32_t j = 0; j <= along; j++) {
        int tip = (j == 0 && flags & EX_TIP_LOW) || (j == along && flags & EX_TIP_HIGH);
        uint32_t first = b->mesh.vertex_count;
        for (uint32_t i = 0; i < (tip ? 1 : columns); i++)
            ex_build_vertex(b, fn(context, (float)i / (float)across, (float)j / (float)along), v3_make(0, 0, 0));
        for (uint32_t i = 0; j > 0 && i < across; i++) {
            uint32_t next = (i + 1) % columns;
            int from_tip = j == 1 && flags & EX_TIP_LOW;
            uint32_t low = previous + (from_tip ? 0 : i), low_next = previous + (from_tip ? 0 : next);
            uint32_t high = first + (tip ? 0 : i), high_next = first + (tip ? 0 : next);
            if (low != low_next) ex_build_triangle(b, low, low_next, tip ? high : high_next, material);
            if (high != high_next) ex_build_triangle(b, low, high_next, high, material);
        }
        previous = first;
    }
}

void ex_build_panel(ex_builder *b, v3 corner, v3 u, v3 v, uint32_t across, uint32_t along, uint32_t material)
{
    uint32_t first = b->mesh.vertex_count;
    v3 n = v3_unit(v3_cross(u, v));
    for (uint32_t j = 0; j <= along; j++)
        for (uint32_t i = 0; i <= across; i++)
            ex_build_vertex(b, v3_mad(v3_mad(corner, u, (float)i / (float)across), v, (float)j / (float)along), n);
    for (uint32_t j = 0; j < along; j++)
        for (uint32_t i = 0; i < across; i++) {
            uint32_t p = first + j * (across + 1) + i, q = p + across + 1;
            ex_build_triangle(b, p, p + 1, q + 1, material);
            ex_build_triangle(b, p, q + 1, q, material);
        }
}

static v3 ball_point(const void *context, float u, float v)
{
    float theta = EX_PI * v, phi = -2 * EX_PI * u, r = sinf(theta);
    (void)context;
    return v3_make(r * cosf(phi), -cosf(theta), r * sinf(phi));
}

void ex_build_ball(ex_builder *b, v3 center, v3 radii, uint32_t sides, uint32_t material)
{
    float m[16];
    ex_mark mark = ex_build_mark(b);
    ex_build_surface(b, ball_point, NULL, sides, sides / 2, EX_WRAP | EX_TIP_LOW | EX_TIP_HIGH, material);
    for (uint32_t i = mark.vertex; i < b->mesh.vertex_count && !b->failed; i++)
        v3_store(b->mesh.normals + 3 * (size_t)i, v3_unit(v3_load(b->mesh.positions + 3 * (size_t)i)));
    ex_identity(m);
    m[0] = radii.x;
    m[5] = radii.y;
    m[10] = radii.z;
    v3_store(m + 12, center);
    ex_build_transform(b, mark, m);
}

/* Rings of a prism: a small cap, the full outline twice, a small cap. Each face gets vertices of its own: flat. */
void ex_build_prism(ex_builder *b, const float (*outline)[2], uint32_t points, float low, float high, float bevel,
                    uint32_t material)
{
    const float heights[4] = {low, low + bevel, high - bevel, high};
    float middle[2] = {0, 0}, reach = 1e30f;
    for (uint32_t i = 0; i < points; i++)
        for (int k = 0; k < 2; k++) middle[k] += outline[i][k] / (float)points;
    for (uint32_t i = 0; i < points; i++)
        reach = fminf(reach, hypotf(outline[i][0] - middle[0], outline[i][1] - middle[1]));
    float shrink = 1 - bevel / reach;
    for (int ring = 0; ring + 1 < 4; ring++) {
        if (!(heights[ring + 1] > heights[ring])) continue;
        for (uint32_t i = 0; i < points; i++) {
            const float *p = outline[i], *q = outline[(i + 1) % points];
            v3 corner[4];
            for (int c = 0; c < 4; c++) {
                const float *at = c == 0 || c == 3 ? p : q;
                int level = ring + (c >= 2);
                float s = level == 0 || level == 3 ? shrink : 1;
                corner[c] = v3_make(ex_mix(middle[0], at[0], s), ex_mix(middle[1], at[1], s), heights[level]);
            }
            ex_build_quad(b, corner[0], corner[1], corner[2], corner[3], material);
        }
    }
    for (int cap = 0; cap < 2; cap++) {
        v3 n = v3_make(0, 0, cap ? 1.0f : -1.0f);
        uint32_t center = ex_build_vertex(b, v3_make(middle[0], middle[1], cap ? high : low), n), first = center + 1;
        for (uint32_t i = 0; i < points; i++)
            ex_build_vertex(b, v3_make(ex_mix(middle[0], outline[i][0], shrink),
                                       ex_mix(middle[1], outline[i][1], shrink), cap ? high : low), n);
        for (uint32_t i = 0; i < points; i++) {
            uint32_t next = (i + 1) % points;
            ex_build_triangle(b, center, first + (cap ? i : next), first + (cap ? next : i), material);
        }
    }
}

void ex_build_block(ex_builder *b, v3 low, v3 high, float bevel, uint32_t material)
{
    /* Corner i of the box, moved inwards by the bevel along the two axes that are not `axis`. */
    v3 at[8][3];
    for (int i = 0; i < 8; i++)
        for (int axis = 0; axis < 3; axis++) {
            float x = axis == 0 ? 0 : bevel, y = axis == 1 ? 0 : bevel, z = axis == 2 ? 0 : bevel;
            at[i][axis] = v3_make(i & 1 ? high.x - x : low.x + x, i & 2 ? high.y - y : low.y + y,
                                  i & 4 ? high.z - z : low.z + z);
        }
    for (int axis = 0; axis < 3; axis++) {
        int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, w = 1 << axis;
        for (int side = 0; side < 2; side++) {                     /* faces */
            int o = side ? w : 0;
            int turn[4] = {o, side ? o | u : o | v, o | u | v, side ? o | v : o | u};
            ex_build_quad(b, at[turn[0]][axis], at[turn[1]][axis], at[turn[2]][axis], at[turn[3]][axis], material);
        }
        for (int edge = 0; edge < 4; edge++) {                     /* edges along `axis`: from face u to face v */
            int o = (edge & 1 ? u : 0) | (edge & 2 ? v : 0), outwards = (edge == 0 || edge == 3);
            int fu = (axis + 1) % 3, fv = (axis + 2) % 3;
            v3 p = at[o][fu], q = at[o][fv], r = at[o | w][fv], s = at[o | w][fu];
            if (outwards) ex_build_quad(b, p, q, r, s, material);
            else ex_build_quad(b, p, s, r, q, material);
        }
    }
    for (int i = 0; i < 8; i++) {
        int even = (i == 0 || i == 3 || i == 5 || i == 6);
        v3 p = at[i][0], q = at[i][even ? 2 : 1], r = at[i][even ? 1 : 2];
        v3 n = v3_unit(v3_cross(v3_sub(q, p), v3_sub(r, p)));
        uint32_t first = ex_build_vertex(b, p, n);
        ex_build_vertex(b, q, n);
        ex_build_vertex(b, r, n);
        ex_build_triangle(b, first, first + 1, first + 2, material);
    }
}

void ex_build_tile(ex_builder *b, v3 corner, float wide, float deep, float bevel, float sunk, uint32_t material)
{
    v3 out[4], in[4];
    for (int i = 0; i < 4; i++) {
        int right = i == 1 || i == 2, near = i < 2;
        out[i] = v3_add(corner, v3_make(right ? wide : 0, -sunk, near ? deep : 0));
        in[i] = v3_add(out[i], v3_make(right ? -bevel : bevel, sunk, near ? -bevel : bevel));
    }
    ex_build_quad(b, in[0], in[1], in[2], in[3], material);
    for (int i = 0; i < 4; i++) ex_build_quad(b, out[i], out[(i + 1) % 4], in[(i + 1) % 4], in[i], material);
}

/* Several copies a row: turns the last part by steps of 2 pi / count about +Y. */
void ex_build_ring(ex_builder *b, ex_mark since, uint32_t count)
{
    ex_mark until = ex_build_mark(b);
    for (uint32_t i = 1; i < count; i++) {
        float m[16];
        ex_place(m, v3_make(0, 0, 0), 2 * EX_PI * (float)i / (float)count, 1);
        ex_build_copy(b, since, until, m);
    }
}

float ex_random(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 8) / 16777216.0f;
}
