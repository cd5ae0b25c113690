/* builtin_knot.c - a trefoil: a tube round the (2, 3) torus knot, closed, 49,920 triangles, turning slowly. */
#include "internal.h"

enum { ALONG = 520, AROUND = 48 };

/* The knot's curve c(t) and its first two derivatives; q = 2 + cos 3t is the distance from the
   axis, here Z: the knot stands. */
static void knot_curve(float t, v3 *c, v3 *d1, v3 *d2)
{
    float q = 2 + cosf(3 * t), q1 = -3 * sinf(3 * t), q2 = -9 * cosf(3 * t), cs = cosf(2 * t), sn = sinf(2 * t);
    *c = v3_make(q * cs, q * sn, sinf(3 * t));
    *d1 = v3_make(q1 * cs - 2 * q * sn, q1 * sn + 2 * q * cs, 3 * cosf(3 * t));
    *d2 = v3_make(q2 * cs - 4 * q1 * sn - 4 * q * cs, q2 * sn + 4 * q1 * cs - 4 * q * sn, -9 * sinf(3 * t));
}

void ex_build_knot(ex_builder *b)
{
    const float radius = 0.46f, scale = 1 / 3.46f;           /* fits the unit sphere */
    uint32_t clay = ex_build_material(b, 0.62f, 0.42f, 0.30f);
    for (uint32_t i = 0; i < ALONG; i++) {
        v3 c, d1, d2;
        knot_curve(2 * EX_PI * (float)i / ALONG, &c, &d1, &d2);
        /* Frenet frame: the curvature is nowhere zero and the frame is as periodic as the curve, so the tube closes. */
        v3 tangent = v3_unit(d1), binormal = v3_unit(v3_cross(d1, d2)), normal = v3_cross(binormal, tangent);
        for (uint32_t k = 0; k < AROUND; k++) {
            float a = 2 * EX_PI * (float)k / AROUND;
            v3 n = v3_add(v3_scale(normal, cosf(a)), v3_scale(binormal, sinf(a)));
            ex_build_vertex(b, v3_scale(v3_mad(c, n, radius), scale), n);
        }
    }
    for (uint32_t i = 0; i < ALONG; i++)
        for (uint32_t k = 0; k < AROUND; k++) {
            uint32_t here = i * AROUND, there = (i + 1) % ALONG * AROUND, next = (k + 1) % AROUND;
            ex_build_triangle(b, here + k, here + next, there + next, clay);
            ex_build_triangle(b, here + k, there + next, there + k, clay);
        }
    ex_build_object(b, "knot", ex_build_finish(b));
}

int ex_pose_knot(ex_scene *scene, float time)
{
    ex_place(scene->objects[0].transform, v3_make(0, 0, 0), time * EX_PI / 6, 1);
    return 0;
}
