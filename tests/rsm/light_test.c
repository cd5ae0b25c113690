/* light_test - maps of rsm.h and their direct light beside brute force in double: a ray through every texel, exact
   solid angles, taps of the shadow test as areas of overlap. Nothing of rsm.h's own arithmetic is used. */

#include "rsm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "util.h"

enum { SIZE = 12, TRIANGLES = 40, RECEIVERS = 300 };

typedef struct vec { double x, y, z; } vec;

static vec v3(double x, double y, double z) { vec v = { x, y, z }; return v; }
static vec load(const float *p) { return v3((double)p[0], (double)p[1], (double)p[2]); }
static vec along(vec a, vec b, double s) { return v3(a.x + b.x * s, a.y + b.y * s, a.z + b.z * s); }
static vec minus(vec a, vec b) { return along(a, b, -1); }
static double dot(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static vec cross(vec a, vec b) { return v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x); }
static vec unit(vec a) { return along(v3(0, 0, 0), a, 1 / sqrt(dot(a, a))); }
static vec times(vec a, double s) { return along(v3(0, 0, 0), a, s); }

static uint32_t state_of_random;

static double any(void)                          /* -1..1 */
{
    state_of_random = state_of_random * 1664525u + 1013904223u;
    return (double)(state_of_random >> 8) / 8388608.0 - 1;
}

/* Function arguments are evaluated in any order: one number after the other here. */
static vec any3(double x, double y, double z)
{
    vec v;
    v.x = x * any();
    v.y = y * any();
    v.z = z * any();
    return v;
}

static void store(float *p, vec v) { set3(p, v.x, v.y, v.z); }

static int near_to(double a, double b, double relative) { return fabs(a - b) <= relative * (fabs(b) + 1e-6); }

/* ---- the lamps, and the frames that rsm.h's contract gives their faces ---- */

enum { SUN, SPOT, WIDE, SQUARE, BULB, PATCH, LAMPS };

static rsm_desc lamp(int which)
{
    static const rsm_light_kind kinds[LAMPS] = { RSM_LIGHT_DEFAULT, RSM_LIGHT_SPOT, RSM_LIGHT_SPOT,
                                                 RSM_LIGHT_SQUARE_SPOT, RSM_LIGHT_POINT, RSM_LIGHT_PATCH };
    static const float angles[LAMPS] = { 0, 1.1f, 3.5f, 1.3f, 0, 0 };
    rsm_desc d;
    memset(&d, 0, sizeof d);
    d.light.kind = kinds[which];
    d.light.cone_half_angle = 0.5f * (angles[which]);
    d.light.radius = 2.5f;
    d.side = SIZE;
    set3(d.light.position, 0.2, which == SUN ? -0.1 : 2.5, -0.3);
    set3(d.light.direction, 0.36, which == SUN ? 0.8 : -0.8, 0.48);
    set3(d.light.value, 3, 2, 5);
    if (which % 2) set3(d.light.up, 0.1, 0.2, 1);
    return d;
}

typedef struct frame { vec at, right, up, axis; double extent; uint32_t faces; int sun; } frame;

static frame frame_of(const rsm_desc *d, int which)
{
    frame f;
    vec up = load(d->light.up);
    memset(&f, 0, sizeof f);
    f.at = load(d->light.position);
    f.sun = which == SUN;
    f.axis = which == BULB ? v3(0, 0, -1) : unit(load(d->light.direction));
    if (f.sun) f.axis = times(f.axis, -1);
    if (!(dot(up, up) > 0) || which == BULB) up = fabs(f.axis.y) < 0.9 ? v3(0, 1, 0) : v3(0, 0, 1);
    f.right = unit(cross(f.axis, up));
    f.up = cross(f.right, f.axis);
    f.faces = which == WIDE || which == BULB ? 6 : which == PATCH ? 5 : 1;
    f.extent = f.sun ? (double)d->light.radius : f.faces > 1 ? 1 : tan((double)d->light.cone_half_angle);
    return f;
}

/* Forward, right, left, up, down, back. */
static frame face_of(const frame *f, uint32_t face)
{
    frame o = *f;
    if (face == 1) { o.right = times(f->axis, -1); o.axis = f->right; }
    if (face == 2) { o.right = f->axis; o.axis = times(f->right, -1); }
    if (face == 3) { o.up = times(f->axis, -1); o.axis = f->up; }
    if (face == 4) { o.up = f->axis; o.axis = times(f->up, -1); }
    if (face == 5) { o.right = times(f->right, -1); o.axis = times(f->axis, -1); }
    return o;
}

/* x, y in -1..1 on the face, depth. */
static vec on_face(const frame *f, vec p)
{
    vec q = minus(p, f->at);
    double z = dot(q, f->axis), s = f->extent * (f->sun ? 1 : z);
    return v3(dot(q, f->right) / s, dot(q, f->up) / s, z);
}

static uint32_t face_seen(const frame *f, vec p)
{
    vec q = minus(p, f->at);
    double c[6];
    uint32_t k, best = 0;
    if (f->faces == 1) return 0;
    c[0] = dot(q, f->axis);
    c[1] = dot(q, f->right);
    c[3] = dot(q, f->up);
    c[2] = -c[1];
    c[4] = -c[3];
    c[5] = -c[0];
    for (k = 1; k < 6; k++)
        if (c[k] > c[best]) best = k;
    return best;
}

static vec towards(const frame *f, vec p) { return f->sun ? times(f->axis, -1) : unit(minus(f->at, p)); }

/* ---- light through a texel ---- */

static double corner_angle(double x, double y) { return atan(x * y / sqrt(1 + x * x + y * y)); }

static double through(const rsm_desc *d, int which, const frame *whole, const frame *f, int i, int j)
{
    double h = f->extent / SIZE, x = (i + 0.5) * 2 * h - f->extent, y = (j + 0.5) * 2 * h - f->extent, sum;
    double half = cos((double)d->light.cone_half_angle);
    int s, t, inside = 0;
    if (f->sun) return 4 * h * h;
    sum = corner_angle(x + h, y + h) - corner_angle(x - h, y + h) - corner_angle(x + h, y - h) +
          corner_angle(x - h, y - h);
    if (which == PATCH)
        for (sum = 0, t = 0; t < 32; t++)
            for (s = 0; s < 32; s++) {
                vec w =
                    along(along(f->axis, f->right, x + h * ((s + 0.5) / 16 - 1)), f->up, y + h * ((t + 0.5) / 16 - 1));
                double c = dot(w, whole->axis);
                sum += c > 0 ? c * 4 * h * h / 1024 / pow(dot(w, w), 2) : 0;
            }
    if (which != SPOT && which != WIDE) return sum;
    for (t = 0; t < 8; t++)
        for (s = 0; s < 8; s++) {
            vec w = along(along(f->axis, f->right, x + h * (s - 3.5) / 4), f->up, y + h * (t - 3.5) / 4);
            inside += dot(unit(w), whole->axis) >= half;
        }
    return sum * inside / 64;
}

/* ---- a soup of triangles in two meshes ---- */

typedef struct corner { float p[3], unused; } corner;

static corner plain_corners[3 * TRIANGLES], turned_corners[TRIANGLES];
static uint32_t turned_indices[3 * TRIANGLES];
static const float turn[16] = { 0.6f, 0, 0.8f, 0, 0, 1.1f, 0, 0, -0.8f, 0, 0.6f, 0, 0.1f, 0.2f, 0.3f, 1 };

static void weights_as_albedo(void *user, const rsm_mesh *m, uint32_t triangle, const float w[3], float albedo[3])
{
    (void)user;
    (void)m;
    (void)triangle;
    memcpy(albedo, w, 12);
}

static int without_a_corner(void *user, uint32_t triangle, const float w[3])
{
    (void)user;
    (void)triangle;
    return w[0] < 0.7f;
}

static void soup(rsm_mesh meshes[2])
{
    int i, c;
    state_of_random = 7;
    memset(meshes, 0, 2 * sizeof *meshes);
    for (i = 0; i < TRIANGLES; i++) {
        vec at = any3(2.2, 1.2, 2.2);
        for (c = 0; c < 3; c++)
            store(plain_corners[3 * i + c].p, along(at, any3(0.9, 0.9, 0.9), 1));
        store(turned_corners[i].p, along(v3(0, -1, 0), any3(2, 1, 2), 1));
        for (c = 0; c < 3; c++) turned_indices[3 * i + c] = (uint32_t)((any() + 1) * 0.4999 * TRIANGLES);
    }
    set3(plain_corners[0].p, -9, -2, -9);        /* and a floor under half of it */
    set3(plain_corners[1].p, 9, -2, -9);
    set3(plain_corners[2].p, -9, -2.5, 9);
    meshes[0].positions = plain_corners[0].p;
    meshes[0].vertex_stride = sizeof(corner);
    meshes[0].vertex_count = 3 * TRIANGLES;
    meshes[0].surface_fn = weights_as_albedo;
    meshes[0].mask_fn = without_a_corner;
    meshes[1].positions = turned_corners[0].p;
    meshes[1].vertex_stride = sizeof(corner);
    meshes[1].vertex_count = TRIANGLES;
    meshes[1].indices = turned_indices;
    meshes[1].index_count = 3 * TRIANGLES;
    meshes[1].transform = turn;
    meshes[1].material = 3;
    set3(meshes[1].albedo, 0.25, 0.5, 0.75);
}

static vec corner_of(int triangle, int k)
{
    vec p;
    if (triangle < TRIANGLES) return load(plain_corners[3 * triangle + k].p);
    p = load(turned_corners[turned_indices[3 * (triangle - TRIANGLES) + k]].p);
    return v3(0.6 * p.x - 0.8 * p.z + 0.1, 1.1 * p.y + 0.2, 0.8 * p.x + 0.6 * p.z + 0.3);
}

typedef struct hit { double t, w[3]; vec p[3], n; int triangle, sure; } hit;

/* The first triangle from from + low way to from + high way; not sure: within a hair of an edge or of another one. */
static hit shoot(vec from, vec way, double low, double high)
{
    hit best;
    int i;
    memset(&best, 0, sizeof best);
    best.t = 1e30;
    best.triangle = -1;
    best.sure = 1;
    for (i = 0; i < 2 * TRIANGLES; i++) {
        vec p[3], e1, e2, n, o, q;
        double det, w[3], t, least;
        int k;
        for (k = 0; k < 3; k++) p[k] = corner_of(i, k);
        e1 = minus(p[1], p[0]);
        e2 = minus(p[2], p[0]);
        n = cross(e1, e2);
        if (!(dot(n, n) > 1e-12)) continue;
        det = -dot(way, n);
        if (!(fabs(det) > 1e-9)) continue;
        o = minus(from, p[0]);
        q = cross(o, way);
        w[1] = dot(e2, q) / det;
        w[2] = -dot(e1, q) / det;
        w[0] = 1 - w[1] - w[2];
        t = dot(o, n) / det;
        least = fmin(w[0], fmin(w[1], w[2]));
        if (t < low || t > high || least < -1e-4) continue;
        if (i < TRIANGLES && w[0] >= 0.7) {
            if (w[0] < 0.7001 && t < best.t) best.sure = 0;
            continue;
        }
        if (t > best.t * (1 + 1e-5)) continue;
        best.sure = fabs(least) > 1e-4 && t < best.t * (1 - 1e-5) && fabs(t - low) > 1e-5 && fabs(w[0] - 0.7) > 1e-4;
        if (least < 0) continue;
        best.t = t;
        memcpy(best.w, w, sizeof w);
        memcpy(best.p, p, sizeof p);
        best.n = unit(n);
        best.triangle = i;
    }
    return best;
}

static void texel_is(const rsm_desc *d, int which, const frame *whole, const frame *f, int i, int j, const rsm_texel *t,
                     int *seen)
{
    double x = ((i + 0.5) * 2 / SIZE - 1) * f->extent, y = ((j + 0.5) * 2 / SIZE - 1) * f->extent, incident, slope,
           beam;
    vec side = along(times(f->right, x), f->up, y), p, n, l, off;
    hit h = f->sun ? shoot(along(f->at, side, 1), f->axis, -2.5, 2.5)
                   : shoot(f->at, along(f->axis, side, 1), 0.001, 1000);
    int c;
    if (!h.sure) return;
    if (h.triangle < 0) {
        assert_true(t->depth >= RSM_FAR && !(t->flux[0] > 0));
        return;
    }
    ++*seen;
    p = f->sun ? along(along(f->at, side, 1), f->axis, h.t) : along(f->at, along(f->axis, side, 1), h.t);
    l = towards(f, p);
    n = dot(h.n, l) < 0 ? times(h.n, -1) : h.n;
    incident = through(d, which, whole, f, i, j);
    assert_true(fabs((double)t->depth - h.t) < 1e-5 * (1 + fabs(h.t)));
    off = minus(load(t->position), p);
    assert_true(sqrt(dot(off, off)) < 1e-5 * (1 + fabs(h.t)));
    if (fabs(dot(n, l)) > 1e-4) assert_true(dot(load(t->normal), n) > 0.99999);
    assert_int_equal(t->material, h.triangle < TRIANGLES ? 0 : 3);
    for (c = 0; c < 3; c++) {
        double albedo = h.triangle < TRIANGLES ? h.w[c] : 0.25 * (c + 1);
        if (!near_to((double)t->flux[c], incident * (double)d->light.value[c] * albedo, 1e-3))
            fail_msg("lamp %d, texel %d %d: flux %g, not %g", which, i, j, (double)t->flux[c],
                     incident * (double)d->light.value[c] * albedo);
    }
    slope = fmax(0.05, fabs(dot(n, l)));
    beam = pow(2 * f->extent * (f->sun ? 1 : h.t) / SIZE, 2) * (f->sun ? 1 : fabs(dot(l, f->axis)));
    assert_true(near_to((double)t->area, beam / slope, 2e-3));
}

static void texels_are_where_rays_hit(void **state)
{
    rsm_mesh meshes[2];
    int which;
    (void)state;
    soup(meshes);
    for (which = 0; which < LAMPS; which++) {
        rsm_desc d = lamp(which);
        frame whole = frame_of(&d, which);
        rsm_stats stats;
        rsm_map *map = map_of(&d, meshes, 2, &stats);
        double incident[3] = { 0, 0, 0 }, reflected[3] = { 0, 0, 0 };
        uint64_t lit = 0;
        uint32_t face;
        int i, j, c, seen = 0;
        assert_non_null(map);
        assert_int_equal(map_faces(map), whole.faces);
        assert_int_equal(map_side(map), SIZE);
        for (face = 0; face < whole.faces; face++) {
            frame f = face_of(&whole, face);
            for (j = 0; j < SIZE; j++)
                for (i = 0; i < SIZE; i++) {
                    const rsm_texel *t = rsm_map_texels(map) + ((int)face * SIZE + j) * SIZE + i;
                    texel_is(&d, which, &whole, &f, i, j, t, &seen);
                    lit += t->flux[0] + t->flux[1] + t->flux[2] > 0;
                    for (c = 0; c < 3; c++) {
                        double light = t->depth < RSM_FAR ? through(&d, which, &whole, &f, i, j) : 0;
                        incident[c] += light * (double)d.light.value[c];
                        reflected[c] += (double)t->flux[c];
                    }
                }
        }
        assert_true(seen > SIZE * SIZE / 3);
        assert_true(stats.lit_texels == lit && stats.bad_texels == 0);
        for (c = 0; c < 3; c++) {
            assert_true(near_to(stats.incident[c], incident[c], 1e-4));
            assert_true(near_to(stats.reflected[c], reflected[c], 1e-6));
        }
        rsm_map_free(map);
    }
}

/* Depths outside near_depth..far_depth are not drawn. */
static void depths_end_at_near_and_far(void **state)
{
    static const float stack[] = { -3, 1, -3, 6, 0,  0,  0,  0, 6, -3, 0, -3, 6, 0,
                                   0,  0, 0,  6, -3, -1, -3, 6, 0, 0,  0, 0,  6 };
    static const float ranges[4][3] = { { 1, 9, 2 }, { 2.2f, 9, 3 }, { 3.5f, 9, 4 }, { 0.5f, 1.5f, RSM_FAR } };
    model m = model_quads(stack, 3);
    rsm_mesh mesh = mesh_of(&m, 0.5);
    int i, which;
    (void)state;
    for (which = 0; which < 2; which++)
        for (i = 0; i < 4; i++) {
            rsm_desc d = lamp(which ? SQUARE : SUN);
            rsm_map *map;
            uint32_t k;
            set3(d.light.position, 0, 3, 0);
            set3(d.light.direction, 0, which ? -1 : 1, 0);
            set3(d.light.up, 0, 0, 0);
            d.light.radius = 1;
            d.light.near_depth = ranges[i][0];
            d.light.far_depth = ranges[i][1];
            map = map_of(&d, &mesh, 1, NULL);
            assert_non_null(map);
            for (k = 0; k < SIZE * SIZE; k++)
                assert_true(fabsf(rsm_map_texels(map)[k].depth - ranges[i][2]) <= 1e-5f * ranges[i][2]);
            rsm_map_free(map);
        }
    model_free(&m);
}

/* ---- matrices and projections ---- */

static void points_are_projected(void **state)
{
    static const rsm_clip_depth depths[3] = { RSM_CLIP_DEPTH_DEFAULT, RSM_CLIP_DEPTH_ZERO_TO_ONE,
                                              RSM_CLIP_DEPTH_REVERSED };
    int which, clip, i, down, behind = 0;
    (void)state;
    for (which = 0; which < LAMPS; which++)
        for (clip = 0; clip < 12; clip++) {
            rsm_desc d = lamp(which);
            frame whole = frame_of(&d, which);
            rsm_map *map;
            d.clip_depth = depths[clip % 3];
            down = clip / 3 % 2;
            d.clip_y = down ? RSM_CLIP_Y_DOWN : RSM_CLIP_Y_UP;
            d.rows = clip / 6 ? RSM_ROWS_TOP_FIRST : RSM_ROWS_DEFAULT;  /* where rows are, nothing of the matrix */
            d.light.near_depth = 0.5f;
            d.light.far_depth = 6;
            assert_int_equal(rsm_map_create(&d, &map), RSM_OK);
            state_of_random = 3;
            for (i = 0; i < 60; i++) {
                float p[3], uv[2], depth, m[16];
                uint32_t face, seen, k;
                double c[4], z, stored;
                frame f;
                vec q;
                store(p, any3(3, 3, 3));
                if (i % 8 == 7) store(p, along(along(whole.at, whole.axis, -2), any3(1, 1, 1), 1));
                seen = face_seen(&whole, load(p));
                assert_int_equal(rsm_map_project(map, p, &face, uv, &depth), RSM_OK);
                if (seen >= whole.faces) behind++;       /* a patch: in front of none of its five faces */
                assert_int_equal(face, seen >= whole.faces ? 0 : seen);
                f = face_of(&whole, face);
                q = on_face(&f, load(p));
                assert_true(near_to((double)depth, q.z, 1e-5));
                if (!whole.sun && !(q.z > 0)) {
                    assert_true(depth <= 0 && uv[0] == 0.5f && uv[1] == 0.5f);
                    continue;
                }
                assert_true(seen < whole.faces);
                assert_true(fabs((double)uv[0] - (q.x * 0.5 + 0.5)) < 1e-4 * (1 + fabs(q.x)));
                assert_true(fabs((double)uv[1] - (q.y * 0.5 + 0.5)) < 1e-4 * (1 + fabs(q.y)));
                assert_int_equal(rsm_map_matrix(map, face, m), RSM_OK);
                for (k = 0; k < 4; k++)
                    c[k] = (double)m[k] * (double)p[0] + (double)m[4 + k] * (double)p[1] +
                           (double)m[8 + k] * (double)p[2] + (double)m[12 + k];
                assert_true(near_to(c[3], whole.sun ? 1 : q.z, 1e-5));
                assert_true(fabs(c[0] / c[3] - q.x) < 1e-4 * (1 + fabs(q.x)));
                assert_true(fabs(c[1] / c[3] - (down ? -q.y : q.y)) < 1e-4 * (1 + fabs(q.y)));
                z = whole.sun ? (q.z - 0.5) / 5.5 : 6 * (q.z - 0.5) / (5.5 * q.z);      /* 0 at near, 1 at far */
                stored = clip % 3 == 1 ? z : clip % 3 == 2 ? 1 - z : 2 * z - 1;
                assert_true(fabs(c[2] / c[3] - stored) < 1e-4 * (1 + fabs(stored)));
            }
            rsm_map_free(map);
        }
    assert_true(behind > 0);
}

/* ---- buffers of the caller's ---- */

static double linear_of(int code)
{
    double s = code / 255.0;
    return s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4);
}

typedef struct pixel { float position[3], normal[3], albedo[3], depth; uint8_t srgb[8]; uint32_t material; } pixel;

static void buffers_are_read(void **state)
{
    enum { N = 16 };
    static pixel pixels[N * N];
    int way, coded, from_depth, i, c;
    (void)state;
    for (i = 0; i < N * N; i++) {
        pixel *p = &pixels[i];
        p->depth = 0.25f + 0.001f * (float)i;
        if (i == 37) p->depth = 1;               /* the far plane is background */
        set3(p->position, 0.01 * i, 0.5, 0.02 * i);
        set3(p->normal, 0, 2, 0.001 * i);
        if (i == 74) set3(p->normal, 0, 0, 0);
        set3(p->albedo, 0.001 * i, 0.002 * i, 0.003 * i);
        for (c = 0; c < 8; c++) p->srgb[c] = (uint8_t)(c < 3 ? (i + 5 * c) % 256 : 99);
        p->material = (uint32_t)i % 5;
    }
    pixels[3].material = UINT32_MAX;             /* means nothing; 0 then */
    for (way = 0; way < 8; way++)
        for (coded = 0; coded < 3; coded++)
            for (from_depth = 0; from_depth < 2; from_depth++) {
                const int reversed = way >= 4, turned = way % 4 == 1 || way % 4 == 2;
                rsm_desc d = lamp(SUN);
                rsm_buffers b;
                rsm_map *map;
                d.clip_y = way & 1 ? RSM_CLIP_Y_DOWN : RSM_CLIP_Y_DEFAULT;
                d.rows = way & 2 ? RSM_ROWS_TOP_FIRST : RSM_ROWS_BOTTOM_FIRST;
                d.clip_depth = reversed ? RSM_CLIP_DEPTH_REVERSED : RSM_CLIP_DEPTH_ZERO_TO_ONE;
                d.side = N;
                for (i = 0; i < N * N && way == 4 && coded == 0 && from_depth == 0; i++)
                    pixels[i].depth = 1 - pixels[i].depth;      /* once, for all that follow */
                memset(&b, 0, sizeof b);
                b.normals = pixels[0].normal;
                b.depth = &pixels[0].depth;
                if (!from_depth) b.positions = pixels[0].position;
                if (coded == 1) b.albedo = pixels[0].albedo;
                if (coded == 2) b.albedo_srgb = pixels[0].srgb;
                b.materials = &pixels[0].material;
                b.position_stride = b.depth_stride = b.normal_stride = b.albedo_stride = b.albedo_srgb_stride =
                    b.material_stride = sizeof(pixel);
                assert_int_equal(rsm_map_create(&d, &map), RSM_OK);
                assert_int_equal(rsm_fill(map, 0, &b), RSM_OK);
                assert_int_equal(rsm_finish(map, NULL), RSM_OK);
                for (i = 0; i < N * N; i++) {
                    int at = turned ? (N - 1 - i / N) * N + i % N : i;
                    const rsm_texel *t = rsm_map_texels(map) + i;
                    const pixel *p = &pixels[at];
                    double length = hypot(2, 0.001 * at), light = 25.0 / (N * N);
                    frame f = frame_of(&d, SUN);
                    if (at == 37 || at == 74) {
                        assert_true(t->depth >= RSM_FAR);
                        continue;
                    }
                    if (from_depth) {
                        double depth = -2.5 + 5 * fabs(reversed - (double)p->depth);
                        assert_true(fabs((double)t->depth - depth) < 1e-5);
                    } else {
                        assert_memory_equal(t->position, p->position, 12);
                        assert_true(fabs((double)t->depth - on_face(&f, load(p->position)).z) < 1e-5);
                    }
                    assert_true(fabs((double)t->normal[1] - 2 / length) < 1e-6);
                    assert_int_equal(t->material, at == 3 ? 0 : at % 5);
                    for (c = 0; c < 3; c++) {
                        double albedo = coded == 0 ? 1
                                      : coded == 1 ? 0.001 * (c + 1) * at : linear_of((at + 5 * c) % 256);
                        assert_true(near_to((double)t->flux[c], light * (double)d.light.value[c] * albedo, 1e-5));
                    }
                }
                rsm_map_free(map);
            }
}

/* ---- direct light ---- */

/* Overlap of the texel s..s + 1 with the box of taps - 1 texels about x; one tap: the texel itself. */
static double share_of(int s, double x, int taps)
{
    double half = 0.5 * (taps - 1), low = fmax(s, x - half), high = fmin(s + 1, x + half);
    if (taps == 1) return s == (int)floor(x) ? 1 : 0;
    return high > low ? high - low : 0;
}

static double irradiance(const rsm_desc *d, const rsm_direct_desc *o, int which, const frame *whole, const rsm_map *map,
                         vec p, vec n, int *sure)
{
    uint32_t face = face_seen(whole, p);
    vec l = towards(whole, p), q, r = minus(p, whole->at);
    double cosine = dot(n, l), out = -dot(whole->axis, l), light = cosine, lit = 0, all = 0, texel, slope, bias;
    int s, t, taps = o->tap_side ? (int)o->tap_side : 2;
    frame f;
    if (fabs(cosine) < 1e-5) *sure = 0;
    if (!(cosine > 0)) return 0;
    if (which != SUN) light /= dot(r, r);
    if (which == PATCH) light *= fmax(out, 0);
    if (which == SPOT || which == WIDE) {
        double rim = out - cos((double)d->light.cone_half_angle);
        if (fabs(rim) < 1e-5) *sure = 0;
        if (rim < 0) return 0;
    }
    if (face >= whole->faces) return 0;
    f = face_of(whole, face);
    q = on_face(&f, p);
    if (which != SUN && !(q.z > 0)) return 0;
    if (fabs(fabs(q.x) - 1) < 1e-5 || fabs(fabs(q.y) - 1) < 1e-5) *sure = 0;
    if (fabs(q.x) > 1 || fabs(q.y) > 1) return which == SUN ? light : 0;
    texel = 2 * f.extent / SIZE * (which == SUN ? 1 : q.z);
    slope = fmin(10, sqrt(fmax(0, 1 - cosine * cosine)) / fmax(cosine, 0.1));
    bias = texel * (fmax(0, (double)o->bias) + fmax(0, (double)o->slope_bias) * slope * sqrt(0.5) * taps);
    for (t = -20; t < SIZE + 20; t++)
        for (s = -20; s < SIZE + 20; s++) {
            double share = share_of(s, (q.x * 0.5 + 0.5) * SIZE, taps) * share_of(t, (q.y * 0.5 + 0.5) * SIZE, taps);
            int i = s < 0 ? 0 : s >= SIZE ? SIZE - 1 : s, j = t < 0 ? 0 : t >= SIZE ? SIZE - 1 : t;
            double depth = (double)rsm_map_texels(map)[((int)face * SIZE + j) * SIZE + i].depth;
            if (!(share > 0)) continue;
            if (fabs(q.z - bias - depth) < 2e-4 * (1 + bias)) *sure = 0;
            all += share;
            lit += q.z - bias <= depth ? share : 0;
        }
    return light * lit / all;
}

static void direct_light_is_filtered_by_area(void **state)
{
    static float p[3 * RECEIVERS], n[3 * RECEIVERS], e[3 * RECEIVERS];
    static uint32_t some[RECEIVERS];
    rsm_points points = points_of(p, n, RECEIVERS, 0);
    rsm_mesh meshes[2];
    int which, taps, i, c;
    (void)state;
    soup(meshes);
    for (i = 0; i < RECEIVERS; i++) {
        vec normal = unit(along(v3(0, 0.7, 0), any3(1, 1, 1), 1));
        if (i % 8 == 0) normal = unit(v3(0.36 + 0.02 * any(), 0.8, 0.48));
        store(p + 3 * i, along(v3(0, -0.5, 0), any3(2.8, 1.8, 2.8), 1));
        store(n + 3 * i, normal);
        some[i] = (uint32_t)(RECEIVERS - 1 - i);
    }
    for (which = 0; which < LAMPS; which++)
        for (taps = 0; taps < 6; taps++) {
            rsm_desc d = lamp(which);
            frame whole = frame_of(&d, which);
            rsm_map *map = map_of(&d, meshes, 2, NULL);
            rsm_direct_desc o = direct_desc();
            int compared = 0, between = 0;
            assert_non_null(map);
            o.tap_side = (uint32_t)taps;
            if (taps == 3) o.slope_bias = -1;    /* none */
            if (taps == 4) o.bias = -1;
            o.add = taps == 5;
            points.indices = taps == 4 ? some : NULL;
            points.index_count = RECEIVERS - 100;
            for (i = 0; i < 3 * RECEIVERS; i++) e[i] = 0.5f;
            assert_int_equal(rsm_direct(map, &o, &points, e), RSM_OK);
            for (i = 0; i < RECEIVERS; i++) {
                int sure = 1, asked = taps != 4 || i >= 100;
                double light = irradiance(&d, &o, which, &whole, map, load(p + 3 * i), load(n + 3 * i), &sure);
                if (!sure) continue;
                compared++;
                between += light > 0;
                for (c = 0; c < 3; c++) {
                    double expected = asked ? light * (double)d.light.value[c] + (o.add ? 0.5 : 0) : 0.5;
                    if (!near_to((double)e[3 * i + c], expected, 1e-3))
                        fail_msg("lamp %d, %d taps, receiver %d: %g, not %g", which, taps, i, (double)e[3 * i + c],
                                 expected);
                }
            }
            assert_true(compared > RECEIVERS / 2 && between > RECEIVERS / 15);
            rsm_map_free(map);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(texels_are_where_rays_hit), cmocka_unit_test(depths_end_at_near_and_far),
        cmocka_unit_test(points_are_projected), cmocka_unit_test(buffers_are_read),
        cmocka_unit_test(direct_light_is_filtered_by_area),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
