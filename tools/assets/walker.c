/* walker - a .glb on stdout: a figure of 16 joints and one skinned mesh, which walks round a circle of 1 metre in 6.6
   seconds and breathes by a morph target; below it a floor, behind it two walls. Faces +Z, metres, stands on y = 0.
   Written by make (build/walker.glb) and make assets. The skin is the surface of smoothly joined round cones, one or
   more a joint, found on a grid; so weights are known from the distances to them. */
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

typedef struct vec { double x, y, z; } vec;

static vec make(double x, double y, double z) { vec r = { x, y, z }; return r; }
static vec add(vec a, vec b) { return make(a.x + b.x, a.y + b.y, a.z + b.z); }
static vec mad(vec a, vec b, double s) { return make(a.x + b.x * s, a.y + b.y * s, a.z + b.z * s); }
static double dot(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static vec cross(vec a, vec b) { return make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x); }
static vec unit(vec a) { double n = sqrt(dot(a, a)); return n > 0 ? make(a.x / n, a.y / n, a.z / n) : make(0, 1, 0); }

static void fail(const char *what)
{
    fprintf(stderr, "walker: %s\n", what);
    exit(1);
}

static void *grown(void *array, size_t count, size_t size)      /* room for one more, by powers of two */
{
    if (count & (count - 1)) return array;
    array = realloc(array, (count ? 2 * count : 1) * size);
    if (!array) fail("out of memory");
    return array;
}

/* ---- the figure: joints, round cones ---- */

enum { HIPS, SPINE, CHEST, HEAD, UPPER_ARM, FOREARM, HAND, UPPER_ARM_R, FOREARM_R, HAND_R, THIGH, SHIN, FOOT, THIGH_R,
       SHIN_R, FOOT_R, JOINTS };
enum { SKIN, HAIR, SHIRT, TROUSERS, SHOES, MATERIALS };

static const double arm_angle = 0.87, upper_arm = 0.28, forearm = 0.25, thigh_length = 0.42, shin_length = 0.41;
static const int parents[JOINTS] = { -1, HIPS, SPINE, CHEST, CHEST, UPPER_ARM, FOREARM, CHEST, UPPER_ARM_R, FOREARM_R,
                                     HIPS, THIGH, SHIN, HIPS, THIGH_R, SHIN_R };
static const char *const names[JOINTS] = { "hips", "spine", "chest", "head", "upper arm", "forearm", "hand",
                                           "upper arm r", "forearm r", "hand r", "thigh", "shin", "foot", "thigh r",
                                           "shin r", "foot r" };
static vec joints[JOINTS];               /* where they are while the skin is bound: arms half lifted */

typedef struct cone { vec from, to; double r, s; int joint, material; } cone;     /* radii at from and to */
static cone cones[64];
static int cone_count;

static void add_cone(int joint, int material, vec from, vec to, double r, double s)
{
    cone c;
    c.from = from; c.to = to; c.r = r; c.s = s; c.joint = joint; c.material = material;
    cones[cone_count++] = c;
}

static void build_arm(int first, double side)
{
    const vec way = make(side * sin(arm_angle), -cos(arm_angle), 0);
    vec wrist, knuckles;
    joints[first] = make(0.165 * side, 1.40, -0.01);
    joints[first + 1] = mad(joints[first], way, upper_arm);
    joints[first + 2] = wrist = mad(joints[first + 1], way, forearm);
    knuckles = mad(wrist, way, 0.08);
    add_cone(first, SHIRT, joints[first], joints[first + 1], 0.056, 0.042);
    add_cone(first + 1, SHIRT, joints[first + 1], mad(wrist, way, -0.03), 0.041, 0.033);
    add_cone(first + 2, SKIN, mad(wrist, way, -0.01), wrist, 0.024, 0.024);
    add_cone(first + 2, SKIN, mad(wrist, way, 0.03), knuckles, 0.028, 0.030);
    add_cone(first + 2, SKIN, knuckles, mad(knuckles, way, 0.085), 0.026, 0.014);
    add_cone(first + 2, SKIN, add(mad(wrist, way, 0.03), make(0, 0, 0.030)),
             add(mad(wrist, way, 0.085), make(0, 0, 0.052)), 0.015, 0.012);                /* thumb */
}

static void build_leg(int first, double side)
{
    const double x = 0.095 * side;
    joints[first] = make(x, 0.92, 0);
    joints[first + 1] = make(x, 0.92 - thigh_length, 0);
    joints[first + 2] = make(x, 0.92 - thigh_length - shin_length, 0);
    add_cone(first, TROUSERS, make(x, 0.88, 0), joints[first + 1], 0.093, 0.060);
    add_cone(first + 1, TROUSERS, joints[first + 1], make(x, 0.36, -0.015), 0.058, 0.058);
    add_cone(first + 1, TROUSERS, make(x, 0.36, -0.015), make(x, 0.12, -0.01), 0.058, 0.052);
    add_cone(first + 2, SHOES, make(x, 0.055, -0.03), make(x, 0.048, 0.06), 0.050, 0.046);
    add_cone(first + 2, SHOES, make(x, 0.046, 0.04), make(x + 0.012 * side, 0.032, 0.14), 0.044, 0.032);
}

static void build_figure(void)
{
    joints[HIPS] = make(0, 0.95, 0);
    joints[SPINE] = make(0, 1.07, 0);
    joints[CHEST] = make(0, 1.22, 0);
    joints[HEAD] = make(0, 1.50, 0);
    add_cone(HIPS, TROUSERS, make(-0.065, 0.95, 0), make(0.065, 0.95, 0), 0.110, 0.110);
    add_cone(SPINE, SHIRT, make(-0.05, 1.00, 0), make(-0.06, 1.20, 0), 0.102, 0.104);
    add_cone(SPINE, SHIRT, make(0.05, 1.00, 0), make(0.06, 1.20, 0), 0.102, 0.104);
    add_cone(CHEST, SHIRT, make(-0.06, 1.20, 0), make(-0.085, 1.33, 0), 0.104, 0.098);
    add_cone(CHEST, SHIRT, make(0.06, 1.20, 0), make(0.085, 1.33, 0), 0.104, 0.098);
    add_cone(CHEST, SHIRT, make(-0.145, 1.395, -0.01), make(0.145, 1.395, -0.01), 0.058, 0.058);
    add_cone(CHEST, SHIRT, make(0, 1.38, -0.01), make(0, 1.45, -0.01), 0.070, 0.058);
    add_cone(HEAD, SKIN, make(0, 1.46, -0.008), make(0, 1.56, 0.005), 0.050, 0.050);
    add_cone(HEAD, SKIN, make(0, 1.605, 0.035), make(0, 1.665, 0.008), 0.060, 0.094);
    add_cone(HEAD, SKIN, make(0, 1.66, -0.018), make(0, 1.67, -0.02), 0.094, 0.094);
    add_cone(HEAD, SKIN, make(0, 1.65, 0.100), make(0, 1.625, 0.112), 0.010, 0.015);      /* nose */
    build_arm(UPPER_ARM, 1);
    build_arm(UPPER_ARM_R, -1);
    build_leg(THIGH, 1);
    build_leg(THIGH_R, -1);
}

static double cone_distance(const cone *c, vec p)
{
    const vec axis = mad(c->to, c->from, -1), way = mad(p, c->from, -1);
    double t = dot(way, axis) / fmax(dot(axis, axis), 1e-12);
    vec off;
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    off = mad(way, axis, -t);
    return sqrt(dot(off, off)) - (c->r + (c->s - c->r) * t);
}

/* Below 0 inside; where two cones are equally near, the surface is rounded. */
static double distance_at(vec p)
{
    const double round = 0.035;
    double least = 1e9;
    for (int i = 0; i < cone_count; i++) {
        const double d = cone_distance(&cones[i], p), h = fmax(round - fabs(least - d), 0) / round;
        least = fmin(least, d) - h * h * round / 4;
    }
    return least;
}

static vec gradient_at(vec p)
{
    const double e = 1e-4;
    return unit(make(distance_at(mad(p, make(1, 0, 0), e)) - distance_at(mad(p, make(1, 0, 0), -e)),
                     distance_at(mad(p, make(0, 1, 0), e)) - distance_at(mad(p, make(0, 1, 0), -e)),
                     distance_at(mad(p, make(0, 0, 1), e)) - distance_at(mad(p, make(0, 0, 1), -e))));
}

/* ---- its surface: a vertex for each cell of a grid that it crosses, a quad for each edge ---- */

enum { ACROSS = 96, UP = 128, DEEP = 34 };
static const double cell = 0.0145;

static vec *vertices, *normals;
static size_t vertex_count;
static uint32_t *triangles[MATERIALS];       /* three corners each */
static size_t corner_count[MATERIALS];
static double *values;
static int *vertex_of;

static size_t grid(int i, int j, int k) { return ((size_t)k * (UP + 1) + (size_t)j) * (ACROSS + 1) + (size_t)i; }
static vec grid_point(int i, int j, int k)
{
    return make((i - ACROSS / 2) * cell, (j - 1) * cell - 0.004, (k - DEEP / 2 + 3) * cell);
}

static void add_vertex(int i, int j, int k)
{
    vec p = make(0, 0, 0);
    int crossings = 0;
    for (int e = 0; e < 12; e++) {           /* edges of the cell: along axis e / 4 from one of four corners */
        const int axis = e / 4, a = e & 1, b = e >> 1 & 1;
        const int from[3] = { axis == 0 ? 0 : a, axis == 1 ? 0 : axis == 0 ? a : b, axis == 2 ? 0 : b };
        const int to[3] = { from[0] + (axis == 0), from[1] + (axis == 1), from[2] + (axis == 2) };
        const double v = values[grid(i + from[0], j + from[1], k + from[2])];
        const double w = values[grid(i + to[0], j + to[1], k + to[2])];
        vec q, r;
        if ((v < 0) == (w < 0)) continue;
        q = grid_point(i + from[0], j + from[1], k + from[2]);
        r = grid_point(i + to[0], j + to[1], k + to[2]);
        p = add(p, mad(q, mad(r, q, -1), v / (v - w)));
        crossings++;
    }
    if (!crossings) return;
    p = make(p.x / crossings, p.y / crossings, p.z / crossings);
    for (int step = 0; step < 2; step++) p = mad(p, gradient_at(p), -distance_at(p));
    vertices = (vec *)grown(vertices, vertex_count, sizeof *vertices);
    normals = (vec *)grown(normals, vertex_count, sizeof *normals);
    normals[vertex_count] = gradient_at(p);
    vertex_of[grid(i, j, k)] = (int)vertex_count;
    vertices[vertex_count++] = p;
}

/* Of the cone that is nearest; hair grows on the head's back and top. */
static int material_at(vec p)
{
    double least = 1e9;
    int material = 0;
    for (int i = 0; i < cone_count; i++) {
        const double d = cone_distance(&cones[i], p);
        if (d < least) { least = d; material = cones[i].material; }
    }
    return p.y > 1.56 && p.z < 0.055 + 0.6 * (p.y - 1.70) + 0.25 * fabs(p.x) ? HAIR : material;
}

static void add_triangle(int a, int b, int c)
{
    const vec p = vertices[a], q = vertices[b], r = vertices[c], sum = add(add(p, q), r);
    const int m = material_at(make(sum.x / 3, sum.y / 3, sum.z / 3)), corner[3] = { a, b, c };
    for (int k = 0; k < 3; k++) {
        triangles[m] = (uint32_t *)grown(triangles[m], corner_count[m], sizeof **triangles);
        triangles[m][corner_count[m]++] = (uint32_t)corner[k];
    }
}

/* The four cells round an edge of the grid along an axis; the front is where the distance grows to. */
static void add_quad(const int at[3], int axis)
{
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    int end[3] = { at[0], at[1], at[2] }, quad[4], swap;
    end[axis]++;
    const double low = values[grid(at[0], at[1], at[2])], high = values[grid(end[0], end[1], end[2])];
    if ((low < 0) == (high < 0) || at[u] == 0 || at[v] == 0) return;
    for (int k = 0; k < 4; k++) {
        int c[3] = { at[0], at[1], at[2] };
        c[u] -= k == 0 || k == 3;
        c[v] -= k < 2;
        quad[k] = vertex_of[grid(c[0], c[1], c[2])];
    }
    if (high < 0) { swap = quad[1]; quad[1] = quad[3]; quad[3] = swap; }
    add_triangle(quad[0], quad[1], quad[2]);
    add_triangle(quad[0], quad[2], quad[3]);
}

static void build_surface(void)
{
    const size_t count = (size_t)(ACROSS + 1) * (UP + 1) * (DEEP + 1);
    values = (double *)malloc(count * sizeof *values);
    vertex_of = (int *)calloc(count, sizeof *vertex_of);
    if (!values || !vertex_of) fail("out of memory");
    for (int k = 0; k <= DEEP; k++)
        for (int j = 0; j <= UP; j++)
            for (int i = 0; i <= ACROSS; i++) values[grid(i, j, k)] = distance_at(grid_point(i, j, k));
    for (int k = 0; k < DEEP; k++)
        for (int j = 0; j < UP; j++)
            for (int i = 0; i < ACROSS; i++) add_vertex(i, j, k);
    for (int k = 0; k < DEEP; k++)
        for (int j = 0; j < UP; j++)
            for (int i = 0; i < ACROSS; i++) {
                const int at[3] = { i, j, k };
                for (int axis = 0; axis < 3; axis++) add_quad(at, axis);
            }
}

/* ---- weights and the morph target ---- */

/* Joints whose cones are within a few centimetres of the nearest one share a vertex: four at most, in 255ths. */
static void weigh(vec p, uint8_t joint[4], uint8_t weight[4])
{
    const double blend = 0.06;
    double nearest[JOINTS], least = 1e9, sum = 0, share[4];
    int given = 0;
    for (int j = 0; j < JOINTS; j++) nearest[j] = 1e9;
    for (int i = 0; i < cone_count; i++) {
        const double d = cone_distance(&cones[i], p);
        nearest[cones[i].joint] = fmin(nearest[cones[i].joint], d);
        least = fmin(least, d);
    }
    for (int k = 0; k < 4; k++) {
        int best = 0;
        for (int j = 1; j < JOINTS; j++)
            if (nearest[j] < nearest[best]) best = j;
        share[k] = pow(fmax(1 - (nearest[best] - least) / blend, 0), 2);
        sum += share[k];
        joint[k] = (uint8_t)(share[k] > 0 ? best : 0);
        nearest[best] = 1e9;
    }
    for (int k = 3; k >= 0; k--) {
        weight[k] = (uint8_t)(k ? floor(255 * share[k] / sum + 0.5) : 255 - given);
        given += weight[k];
        if (weight[k] == 0) joint[k] = 0;
    }
}

/* A deep breath lifts the chest's front by two centimetres. */
static vec breath(size_t i)
{
    const vec p = vertices[i];
    const double up = (p.y - 1.27) / 0.11, side = p.x / 0.13;
    return p.z > 0 && fabs(p.x) < 0.2 ? make(0, 0.006 * exp(-up * up - side * side),
                                             0.022 * exp(-up * up - side * side) * fmin(p.z / 0.05, 1)) : make(0, 0, 0);
}

/* Sums of the triangles' normals, weighted by area, of the surface moved by the target or not. */
static vec *face_normals(int moved)
{
    vec *sums = (vec *)calloc(vertex_count, sizeof *sums);
    if (!sums) fail("out of memory");
    for (int m = 0; m < MATERIALS; m++)
        for (size_t t = 0; t < corner_count[m]; t += 3) {
            const uint32_t *corner = triangles[m] + t;
            vec p[3], n;
            for (int k = 0; k < 3; k++)
                p[k] = moved ? add(vertices[corner[k]], breath(corner[k])) : vertices[corner[k]];
            n = cross(mad(p[1], p[0], -1), mad(p[2], p[0], -1));
            for (int k = 0; k < 3; k++) sums[corner[k]] = add(sums[corner[k]], n);
        }
    for (size_t i = 0; i < vertex_count; i++) sums[i] = unit(sums[i]);
    return sums;
}

/* ---- the file ---- */

static uint8_t *bytes;
static size_t byte_count;
static char json[65536], views[8192], accessors[16384], channels[8192], samplers[8192];
static int accessor_count, channel_count;

static void put_bytes(const void *data, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        bytes = (uint8_t *)grown(bytes, byte_count, 1);
        bytes[byte_count++] = ((const uint8_t *)data)[i];
    }
}

static void append(char *text, size_t room, const char *format, ...)
{
    const size_t at = strlen(text);
    va_list list;
    va_start(list, format);
    if (vsnprintf(text + at, room - at, format, list) >= (int)(room - at)) fail("a text is too long");
    va_end(list);
}

/* extra: "" or members that follow, "\"normalized\":true" for instance. */
static int add_accessor(int component, const char *type, size_t count, const void *data, size_t size, const char *extra)
{
    while (byte_count % 4) put_bytes("", 1);
    append(views, sizeof views, "%s{\"buffer\":0,\"byteOffset\":%lu,\"byteLength\":%lu}", accessor_count ? "," : "",
           (unsigned long)byte_count, (unsigned long)size);
    append(accessors, sizeof accessors, "%s{\"bufferView\":%d,\"componentType\":%d,\"count\":%lu,\"type\":\"%s\"%s}",
           accessor_count ? "," : "", accessor_count, component, (unsigned long)count, type, extra);
    put_bytes(data, size);
    return accessor_count++;
}

static int add_floats(const char *type, size_t count, const float *data, size_t floats)
{
    return add_accessor(5126, type, count, data, floats * sizeof *data, "");
}

/* With the bounds that the format wants of positions and of times. */
static int add_bounded(const char *type, size_t count, const float *data, size_t wide)
{
    char extra[400] = "";
    for (int high = 0; high < 2; high++) {
        append(extra, sizeof extra, ",\"%s\":[", high ? "max" : "min");
        for (size_t k = 0; k < wide; k++) {
            float bound = data[k];
            for (size_t i = 0; i < count; i++) {
                const float value = data[i * wide + k];
                bound = high ? fmaxf(bound, value) : fminf(bound, value);
            }
            append(extra, sizeof extra, "%s%.9g", k ? "," : "", (double)bound);
        }
        append(extra, sizeof extra, "]");
    }
    return add_accessor(5126, type, count, data, count * wide * sizeof *data, extra);
}

static int add_vectors(const vec *list, size_t count, int bounded)
{
    float *data = (float *)malloc((3 * count + 1) * sizeof *data);
    int result;
    if (!data) fail("out of memory");
    for (size_t i = 0; i < count; i++) {
        data[3 * i] = (float)list[i].x;
        data[3 * i + 1] = (float)list[i].y;
        data[3 * i + 2] = (float)list[i].z;
    }
    result = bounded ? add_bounded("VEC3", count, data, 3) : add_floats("VEC3", count, data, 3 * count);
    free(data);
    return result;
}

static void add_body(void)
{
    uint8_t *which = (uint8_t *)malloc(4 * vertex_count), *share = (uint8_t *)malloc(4 * vertex_count);
    vec *deltas = (vec *)malloc(vertex_count * sizeof *deltas), *before = face_normals(0), *after = face_normals(1);
    int part[6];
    if (!which || !share || !deltas) fail("out of memory");
    for (size_t i = 0; i < vertex_count; i++) {
        weigh(vertices[i], which + 4 * i, share + 4 * i);
        deltas[i] = breath(i);
        after[i] = mad(after[i], before[i], -1);
    }
    part[0] = add_vectors(vertices, vertex_count, 1);
    part[1] = add_vectors(normals, vertex_count, 0);
    part[2] = add_accessor(5121, "VEC4", vertex_count, which, 4 * vertex_count, "");
    part[3] = add_accessor(5121, "VEC4", vertex_count, share, 4 * vertex_count, ",\"normalized\":true");
    part[4] = add_vectors(deltas, vertex_count, 1);
    part[5] = add_vectors(after, vertex_count, 0);
    append(json, sizeof json, "{\"name\":\"walker\",\"weights\":[0],\"extras\":{\"targetNames\":[\"breath\"]},"
           "\"primitives\":[");
    for (int m = 0; m < MATERIALS; m++)
        append(json, sizeof json, "%s{\"attributes\":{\"POSITION\":%d,\"NORMAL\":%d,\"JOINTS_0\":%d,\"WEIGHTS_0\":%d},"
               "\"targets\":[{\"POSITION\":%d,\"NORMAL\":%d}],\"indices\":%d,\"material\":%d}", m ? "," : "", part[0], part[1],
               part[2], part[3], part[4], part[5], add_accessor(5125, "SCALAR", corner_count[m], triangles[m],
               corner_count[m] * sizeof **triangles, ""), m);
    append(json, sizeof json, "]}");
    free(which);
    free(share);
    free(deltas);
    free(before);
    free(after);
}

/* A floor of 6 x 6 metres, a red wall on the left and a white one behind. */
static void add_room(void)
{
    static const double corners[3][4][3] = { { { -3, 0, 3 }, { 3, 0, 3 }, { 3, 0, -2 }, { -3, 0, -2 } },
        { { -2.2, 0, 3 }, { -2.2, 0, -2 }, { -2.2, 3.4, -2 }, { -2.2, 3.4, 3 } },
        { { -2.2, 0, -2 }, { 3, 0, -2 }, { 3, 3.4, -2 }, { -2.2, 3.4, -2 } } };
    static const uint16_t quad[6] = { 0, 1, 2, 0, 2, 3 };
    const int indices = add_accessor(5123, "SCALAR", 6, quad, sizeof quad, "");
    append(json, sizeof json, ",{\"name\":\"room\",\"primitives\":[");
    for (int i = 0; i < 3; i++) {
        vec p[4];
        for (int k = 0; k < 4; k++) p[k] = make(corners[i][k][0], corners[i][k][1], corners[i][k][2]);
        append(json, sizeof json, "%s{\"attributes\":{\"POSITION\":%d},\"indices\":%d,\"material\":%d}", i ? "," : "",
               add_vectors(p, 4, 1), indices, MATERIALS + i);
    }
    append(json, sizeof json, "]}");
}

/* ---- the walk ---- */

enum { CYCLES = 6, KEYS_PER_CYCLE = 16, KEYS = CYCLES * KEYS_PER_CYCLE + 1 };
static const double cycle_seconds = 1.1;

typedef struct turn { double x, y, z, w; } turn;

static turn about(vec axis, double angle)
{
    const vec a = unit(axis);
    turn t;
    t.x = a.x * sin(angle / 2); t.y = a.y * sin(angle / 2); t.z = a.z * sin(angle / 2); t.w = cos(angle / 2);
    return t;
}

static turn after(turn a, turn b)            /* b first */
{
    turn t;
    t.x = a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y;
    t.y = a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x;
    t.z = a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w;
    t.w = a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z;
    return t;
}

static double hip_height(double phase) { return 0.908 - 0.012 * cos(2 * phase); }      /* of the joint HIPS */

/* Half of the time the foot is on the ground and goes back below the body, half of it forwards and lifted. */
static void move_leg(double phase, turn pose[3])
{
    const double stride = 2 * PI / CYCLES, part = phase / (2 * PI) - floor(phase / (2 * PI)), s = 2 * part - 1;
    const double lift = part < 0.5 ? 0.045 * pow(fmax(4 * part - 1, 0), 3)
                                   : 0.045 * (1 - s) + 0.10 * pow(sin(PI * s), 2);
    const double z = part < 0.5 ? stride * (0.25 - part) : -0.25 * stride * cos(PI * s);
    const double y = 0.09 + lift - (hip_height(phase) - 0.03);
    const double far = fmin(sqrt(y * y + z * z), thigh_length + shin_length - 0.001), way = atan2(z, -y);
    const double a = thigh_length, b = shin_length;
    const double thigh = way + acos((a * a + far * far - b * b) / (2 * a * far));
    const double knee = PI - acos((a * a + b * b - far * far) / (2 * a * b));
    const double pitch = part < 0.5 ? 0.5 * pow(fmax(4 * part - 1, 0), 3) : 0.5 * cos(PI * s) * (s < 0.5 ? 1 : 0.6);
    const vec x = make(1, 0, 0);
    pose[0] = about(x, -thigh);
    pose[1] = about(x, knee);
    pose[2] = about(x, thigh - knee + pitch);
}

static void move_arm(double swing, double side, turn pose[3])
{
    const vec forwards = cross(make(side * sin(arm_angle), -cos(arm_angle), 0), make(0, 0, 1));
    pose[0] = after(about(make(1, 0, 0), -0.45 * swing), about(make(0, 0, 1), -side * (arm_angle - 0.13)));
    pose[1] = about(forwards, 0.35 + 0.25 * swing);
    pose[2] = about(forwards, 0.12);
}

static void pose_at(double phase, turn pose[JOINTS])
{
    const vec y = make(0, 1, 0), z = make(0, 0, 1);
    const double sway = cos(phase);          /* 1: the left foot is in front */
    pose[HIPS] = after(about(y, -0.09 * sway), about(z, 0.03 * sin(phase)));
    pose[SPINE] = after(about(y, 0.10 * sway), about(z, -0.03 * sin(phase)));
    pose[CHEST] = after(about(y, 0.12 * sway), about(make(1, 0, 0), 0.03));
    pose[HEAD] = after(about(y, -0.13 * sway + 0.25 * sin(phase / CYCLES)), about(make(1, 0, 0), -0.02));
    move_leg(phase, pose + THIGH);
    move_leg(phase + PI, pose + THIGH_R);
    move_arm(-sway, 1, pose + UPPER_ARM);
    move_arm(sway, -1, pose + UPPER_ARM_R);
}

static void add_channel(int node, const char *path, int input, int output, const char *interpolation)
{
    append(channels, sizeof channels, "%s{\"sampler\":%d,\"target\":{\"node\":%d,\"path\":\"%s\"}}",
           channel_count ? "," : "", channel_count, node, path);
    append(samplers, sizeof samplers, "%s{\"input\":%d,\"output\":%d,\"interpolation\":\"%s\"}",
           channel_count ? "," : "", input, output, interpolation);
    channel_count++;
}

enum { LAP_NODE, PLACE_NODE, FIRST_JOINT, BODY_NODE = FIRST_JOINT + JOINTS, ROOM_NODE, CAMERA_NODE };

static void add_rotations(int times)
{
    static float turns[JOINTS][KEYS][4];
    for (int key = 0; key < KEYS; key++) {
        turn pose[JOINTS];
        pose_at(2 * PI * key / KEYS_PER_CYCLE, pose);
        for (int j = 0; j < JOINTS; j++) {
            turns[j][key][0] = (float)pose[j].x;
            turns[j][key][1] = (float)pose[j].y;
            turns[j][key][2] = (float)pose[j].z;
            turns[j][key][3] = (float)pose[j].w;
        }
    }
    for (int j = 0; j < JOINTS; j++)
        add_channel(FIRST_JOINT + j, "rotation", times, add_floats("VEC4", KEYS, turns[j][0], 4 * KEYS), "LINEAR");
}

static void add_walk(void)
{
    static float times[KEYS], heights[KEYS][3][3], lap[5][4], lap_times[5], breaths[5][3];
    const double rate = 2 * PI / cycle_seconds;          /* of the phase */
    int input, lap_input;
    for (int key = 0; key < KEYS; key++) {
        const double phase = 2 * PI * key / KEYS_PER_CYCLE, slope = 2 * 0.012 * sin(2 * phase) * rate;
        times[key] = (float)(cycle_seconds * key / KEYS_PER_CYCLE);
        heights[key][0][1] = heights[key][2][1] = (float)slope;
        heights[key][1][1] = (float)hip_height(phase);
    }
    for (int key = 0; key < 5; key++) {
        const turn t = about(make(0, 1, 0), -PI / 2 * key);
        lap_times[key] = (float)(cycle_seconds * CYCLES * key / 4);
        lap[key][0] = 0;
        lap[key][1] = (float)t.y;
        lap[key][2] = 0;
        lap[key][3] = (float)t.w;
        breaths[key][1] = (float)(key % 2);
    }
    input = add_bounded("SCALAR", KEYS, times, 1);
    lap_input = add_bounded("SCALAR", 5, lap_times, 1);
    add_rotations(input);
    add_channel(FIRST_JOINT + HIPS, "translation", input, add_floats("VEC3", 3 * KEYS, heights[0][0], 9 * KEYS),
                "CUBICSPLINE");
    add_channel(LAP_NODE, "rotation", lap_input, add_floats("VEC4", 5, lap[0], 20), "LINEAR");
    add_channel(BODY_NODE, "weights", lap_input, add_floats("SCALAR", 15, breaths[0], 15), "CUBICSPLINE");
}

static void add_nodes(void)
{
    /* The camera looks along -Z of its node: turned by yaw about +Y, then down. */
    const turn t = after(about(make(0, 1, 0), 0.62), about(make(1, 0, 0), -0.17));
    append(json, sizeof json, "\"nodes\":[{\"name\":\"lap\",\"children\":[%d]},{\"name\":\"place\","
           "\"translation\":[1,0,0],\"children\":[%d]}", PLACE_NODE, FIRST_JOINT);
    for (int j = 0; j < JOINTS; j++) {
        const vec p = parents[j] < 0 ? joints[j] : mad(joints[j], joints[parents[j]], -1);
        int children = 0;
        append(json, sizeof json, ",{\"name\":\"%s\",\"translation\":[%.9g,%.9g,%.9g]", names[j], p.x, p.y, p.z);
        for (int k = 0; k < JOINTS; k++)
            if (parents[k] == j)
                append(json, sizeof json, "%s%d", children++ ? "," : ",\"children\":[", FIRST_JOINT + k);
        append(json, sizeof json, children ? "]}" : "}");
    }
    append(json, sizeof json, ",{\"name\":\"walker\",\"mesh\":0,\"skin\":0},{\"name\":\"room\",\"mesh\":1},"
           "{\"name\":\"camera\",\"camera\":0,\"translation\":[3.0,1.75,4.2],\"rotation\":[%.9g,%.9g,%.9g,%.9g]}],", t.x, t.y, t.z, t.w);
    append(json, sizeof json, "\"scene\":0,\"scenes\":[{\"nodes\":[%d,%d,%d,%d]}],", LAP_NODE, BODY_NODE,
           ROOM_NODE, CAMERA_NODE);
}

static void add_skin(void)
{
    float bind[JOINTS][16];
    memset(bind, 0, sizeof bind);
    for (int j = 0; j < JOINTS; j++) {
        bind[j][0] = bind[j][5] = bind[j][10] = bind[j][15] = 1;
        bind[j][12] = (float)-joints[j].x;
        bind[j][13] = (float)-joints[j].y;
        bind[j][14] = (float)-joints[j].z;
    }
    append(json, sizeof json, "\"skins\":[{\"inverseBindMatrices\":%d,\"skeleton\":%d,\"joints\":[",
           add_floats("MAT4", JOINTS, bind[0], 16 * JOINTS), FIRST_JOINT);
    for (int j = 0; j < JOINTS; j++) append(json, sizeof json, "%s%d", j ? "," : "", FIRST_JOINT + j);
    append(json, sizeof json, "]}],");
}

static void add_materials(void)
{
    static const double colors[MATERIALS + 3][3] = { { 0.60, 0.38, 0.27 }, { 0.07, 0.04, 0.025 }, { 0.72, 0.66, 0.55 },
        { 0.09, 0.13, 0.24 }, { 0.16, 0.08, 0.05 }, { 0.5, 0.5, 0.5 }, { 0.62, 0.12, 0.10 }, { 0.7, 0.7, 0.68 } };
    append(json, sizeof json, "\"materials\":[");
    for (int m = 0; m < MATERIALS + 3; m++)
        append(json, sizeof json, "%s{\"doubleSided\":%s,\"pbrMetallicRoughness\":{\"baseColorFactor\":[%g,%g,%g,1],"
               "\"metallicFactor\":0,\"roughnessFactor\":0.8}}", m ? "," : "", m < MATERIALS ? "false" : "true",
               colors[m][0], colors[m][1], colors[m][2]);
    append(json, sizeof json, "],");
}

static void put_word(uint32_t word)
{
    for (int k = 0; k < 4; k++) putchar((int)(word >> (8 * k) & 255));
}

static void write_file(void)
{
    static char text[131072];
    uint32_t length;
    while (byte_count % 4) put_bytes("", 1);
    append(text, sizeof text, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"Dapple's tools/assets/walker.c\"},%s"
           "\"animations\":[{\"name\":\"walk\",\"channels\":[%s],\"samplers\":[%s]}],\"bufferViews\":[%s],\"accessors\":[%s],"
           "\"buffers\":[{\"byteLength\":%lu}]}", json, channels, samplers, views, accessors, (unsigned long)byte_count);
    while (strlen(text) % 4) append(text, sizeof text, " ");
    length = (uint32_t)strlen(text);
    put_word(0x46546c67);
    put_word(2);
    put_word(28 + length + (uint32_t)byte_count);
    put_word(length);
    put_word(0x4e4f534a);
    fputs(text, stdout);
    put_word((uint32_t)byte_count);
    put_word(0x004e4942);
    if (fwrite(bytes, 1, byte_count, stdout) != byte_count || fflush(stdout) != 0) fail("stdout cannot be written");
}

int main(void)
{
    build_figure();
    build_surface();
    add_nodes();
    append(json, sizeof json, "\"cameras\":[{\"type\":\"perspective\",\"perspective\":"
           "{\"yfov\":0.56,\"znear\":0.1}}],");
    add_materials();
    append(json, sizeof json, "\"meshes\":[");
    add_body();
    add_room();
    append(json, sizeof json, "],");
    add_skin();
    add_walk();
    write_file();
    return 0;
}
