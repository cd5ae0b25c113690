/* sums_test - bounced light of rsm.h beside brute force in double: samples of every pattern placed one by one,
   pixel lights summed one by one, section 4's grids pixel by pixel, clusters cut one by one. */

#define RSM_STATIC
#define RSM_IMPLEMENTATION
#include "rsm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "util.h"

enum { SIZE = 16, WIDE = 8, HIGH = 6, PIXELS = WIDE * HIGH };

/* Of rsm.h, only its random numbers are used here: rsm__random, rsm__to_unit, rsm__hash_combine. */

static uint32_t state_of_random;

static double any(void)                          /* -1..1 */
{
    state_of_random = state_of_random * 1664525u + 1013904223u;
    return (double)(state_of_random >> 8) / 8388608.0 - 1;
}

static double dot3(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void unit3(double *v)
{
    double l = sqrt(dot3(v, v));
    int k;
    for (k = 0; k < 3; k++) v[k] /= l;
}

static double flux_of(const rsm_texel *t) { return ((double)t->flux[0] + (double)t->flux[1] + (double)t->flux[2]) / 3; }

/* ---- three maps of a room with a box, and receivers in it ---- */

enum { SUN, CUBE, HALF, MAPS };

static rsm_map *maps[MAPS];
static float positions[3 * PIXELS], normals[3 * PIXELS], got[3 * PIXELS];
static rsm_points points;

static int setup(void **state)
{
    static const float room[] = { -2, 0, -2, 0,  0, 4,  4,     0,    0,     -2, 0, -2,   4,    0, 0,
                                  0,  3, 0,  -2, 0, -2, 0,     3,    0,     0,  0, 4,    2,    0, -2,
                                  0,  0, 4,  0,  3, 0,  -0.4f, 0.8f, -0.2f, 0,  0, 0.7f, 0.9f, 0, 0.1f };
    model m = model_quads(room, 5);
    rsm_mesh mesh = mesh_of(&m, 0.5);
    int k, i;
    (void)state;
    set3(mesh.albedo, 0.5, 0.25, 0.75);
    mesh.material = 2;
    for (k = 0; k < MAPS; k++) {
        rsm_desc d = sun_desc(2, 2.6, SIZE);
        set3(d.light.direction, 0.36, 0.8, 0.48);
        set3(d.light.position, 0.1, 0.9, 0.2);
        if (k != SUN) {
            d.light.kind = k == CUBE ? RSM_LIGHT_POINT : RSM_LIGHT_PATCH;
            set3(d.light.position, 0.3, 2.4, -0.2);
            set3(d.light.direction, 0, -1, 0);
            d.side = SIZE / 2;
        }
        maps[k] = map_of(&d, &mesh, 1, NULL);
    }
    state_of_random = 11;
    for (i = 0; i < PIXELS; i++) {
        double n[3];
        n[0] = any() + 0.3;
        n[1] = any() - 0.5;
        n[2] = any() + 0.4;
        unit3(n);
        for (k = 0; k < 3; k++) positions[3 * i + k] = (float)(k == 1 ? 1.5 + 0.5 * any() : 1.1 * any());
        set3(normals + 3 * i, n[0], n[1], n[2]);
    }
    points = points_of(positions, normals, PIXELS, WIDE);
    model_free(&m);
    return maps[0] && maps[1] && maps[2] ? 0 : -1;
}

static int teardown(void **state)
{
    int k;
    (void)state;
    for (k = 0; k < MAPS; k++) rsm_map_free(maps[k]);
    return 0;
}

static size_t texels_of(const rsm_map *map)
{
    return (size_t)map_faces(map) * map_side(map) * map_side(map);
}

static double total_of(const rsm_map *map)
{
    double sum = 0;
    size_t i;
    for (i = 0; i < texels_of(map); i++) sum += flux_of(rsm_map_texels(map) + i);
    return sum;
}

/* ---- what one pixel light does ---- */

static void cross3(const double *a, const double *b, double *out)
{
    int c;
    for (c = 0; c < 3; c++) out[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
}

/* Where the ray under (u, v) of a face, -1..1, meets the plane of a texel: three planes by Cramer's rule. */
static void hit(const rsm_map *map, uint32_t face, const rsm_texel *t, double u, double v, double out[3])
{
    double rows[3][3], right[3], minor[3], det;
    float m[16];
    int c, k;
    assert_int_equal(rsm_map_matrix(map, face, m), RSM_OK);
    for (k = 0; k < 2; k++) {
        const double at = k ? v : u;
        for (c = 0; c < 3; c++) rows[k][c] = (double)m[4 * c + k] - at * (double)m[4 * c + 3];
        right[k] = at * (double)m[15] - (double)m[12 + k];
    }
    for (right[2] = 0, c = 0; c < 3; c++) {
        rows[2][c] = (double)t->normal[c];
        right[2] += rows[2][c] * (double)t->position[c];
    }
    cross3(rows[1], rows[2], minor);
    det = dot3(rows[0], minor);
    for (c = 0; c < 3; c++) out[c] = right[0] * minor[c] / det;
    for (k = 1; k < 3; k++) {
        cross3(rows[(k + 1) % 3], rows[(k + 2) % 3], minor);
        for (c = 0; c < 3; c++) out[c] += right[k] * minor[c] / det;
    }
}

/* Half the sides of the surface under a texel, moved back by the offset: by differences, a thousandth of it wide. */
static void sides_of(const rsm_map *map, const rsm_texel *t, double offset, double side[2][3])
{
    const uint32_t size = map_side(map),
                   face = (uint32_t)((size_t)(t - rsm_map_texels(map)) / ((size_t)size * size));
    const double h = 1e-3 / size;
    rsm_texel moved = *t;
    float m[16];
    double a[3], b[3], clip[4];
    int k, c;
    for (c = 0; c < 3; c++) moved.position[c] = (float)((double)t->position[c] - offset * (double)t->normal[c]);
    assert_int_equal(rsm_map_matrix(map, face, m), RSM_OK);
    for (k = 0; k < 4; k++)
        for (clip[k] = (double)m[12 + k], c = 0; c < 3; c++)
            clip[k] += (double)m[4 * c + k] * (double)moved.position[c];
    for (k = 0; k < 2; k++) {
        hit(map, face, &moved, clip[0] / clip[3] + (k ? 0 : h), clip[1] / clip[3] + (k ? h : 0), a);
        hit(map, face, &moved, clip[0] / clip[3] - (k ? 0 : h), clip[1] / clip[3] - (k ? h : 0), b);
        for (c = 0; c < 3; c++) side[k][c] = 500 * (a[c] - b[c]);
    }
}

/* The mean of cos cos / d^2 over the surface under a texel at d, its part above the horizon of n: Lambert's sum over
   the edges of the polygon that the horizon leaves. */
static double surface_form(const rsm_map *map, const rsm_texel *t, double offset, const double *d, const double *n)
{
    double side[2][3], q[4][3], p[8][3], area[3], sum = 0, size, point, height = 0, facing = 0;
    int k, c, count = 0;
    sides_of(map, t, offset, side);
    for (k = 0; k < 4; k++)
        for (c = 0; c < 3; c++) q[k][c] = d[c] + (k % 3 ? 1 : -1) * side[0][c] + (k > 1 ? 1 : -1) * side[1][c];
    for (k = 0; k < 4; k++) {
        const double *a = q[k], *b = q[(k + 1) % 4], ha = dot3(a, n), hb = dot3(b, n);
        if (ha > 0) memcpy(p[count++], a, sizeof p[0]);
        if ((ha > 0) == (hb > 0)) continue;
        for (c = 0; c < 3; c++) p[count][c] = a[c] + (b[c] - a[c]) * ha / (ha - hb);
        count++;
    }
    for (k = 0; k < count; k++) {
        double edge[3], length;
        cross3(p[k], p[(k + 1) % count], edge);
        length = sqrt(dot3(edge, edge));
        if (length > 0) sum += atan2(length, dot3(p[k], p[(k + 1) % count])) * dot3(edge, n) / length;
    }
    cross3(side[0], side[1], area);
    size = 4 * sqrt(dot3(area, area));
    sum = 0.5 * fabs(sum) / size;
    for (c = 0; c < 3; c++) {
        height -= d[c] * (double)t->normal[c];
        facing -= 2 * n[c] * (double)t->normal[c];
    }
    point = fmax(0, dot3(d, n)) * height / pow(dot3(d, d), 2);
    if (sum > point && facing > 0 && height < 0.5 * sqrt(size)) /* no more than a point, by degrees */
        sum -= fmin(1, facing) * (1 - 2 * height / sqrt(size)) * (sum - point);
    return sum;
}

typedef struct sums { double rgb[3], full, lost, nearest2; int sure, near; } sums;

/* weight: texels that it stands for; share: what is left of its light beside another way to sample it; surface: where
   it is near, it is the surface under the texel. */
static void add_light(sums *s, const rsm_gather_desc *g, const rsm_map *map, const rsm_texel *t, size_t pixel,
                      double weight, double share, int surface)
{
    double d[3], x[3], n[3], m[3], d2, cr, ce, form, cap = 1e30, bounded;
    int c, near = 0;
    for (c = 0; c < 3; c++) {
        x[c] = (double)positions[3 * pixel + (size_t)c];
        n[c] = (double)normals[3 * pixel + (size_t)c];
        m[c] = (double)t->normal[c];
        d[c] = (double)t->position[c] - (double)g->offset * m[c] - x[c];
    }
    d2 = dot3(d, d);
    cr = dot3(d, n);
    ce = -dot3(d, m);
    if (surface && g->near_field > 0) {
        const double near2 = (double)g->near_field * (double)g->near_field * (double)t->area;
        near = d2 < near2;
        s->sure &= fabs(d2 - near2) > 1e-5 * near2;
    }
    if (!(ce > 0 && (near || cr > 0))) return;
    form = near ? surface_form(map, t, (double)g->offset, d, n) : cr * ce / (d2 * d2);
    s->near += near && form > 0;
    if (g->clamp > 0) cap = (double)g->clamp;
    if (g->near_limit > 0 && t->area > 0) cap = fmin(cap, (double)g->near_limit * PI / ((double)t->area * weight));
    bounded = fmin(form, cap);
    for (c = 0; c < 3; c++) s->rgb[c] += (double)t->flux[c] * weight * share * bounded;
    s->full += 3 * flux_of(t) * weight * share * form;
    s->lost += 3 * flux_of(t) * weight * share * (form - bounded);
    if (cr * ce / d2 > 1e-3 && cr > 0 && flux_of(t) > 0) s->nearest2 = fmin(s->nearest2, d2);
    if (!g->materials || t->material == 0 || t->material > g->material_count) return;
    {                                            /* the room's albedo is known, so is the light on the texel */
        static const double albedo[3] = { 0.5, 0.25, 0.75 };
        const rsm_material *lobe = &g->materials[t->material - 1];
        double l[3] = { 0.36, 0.8, 0.48 }, mirror[3], cm;
        for (c = 0; c < 3 && map != maps[SUN]; c++)
            l[c] = (c == 0 ? 0.3 : c == 1 ? 2.4 : -0.2) - (double)t->position[c];
        unit3(l);
        for (c = 0; c < 3; c++) mirror[c] = 2 * dot3(m, l) * m[c] - l[c];
        cm = -dot3(mirror, d) / sqrt(d2);
        if (!(cm > 0)) return;
        for (c = 0; c < 3; c++)
            s->rgb[c] += (double)t->flux[c] / albedo[c] * weight * share * PI * (double)lobe->specular[c] *
                         ((double)lobe->exponent + 2) / (2 * PI) * bounded * pow(cm, (double)lobe->exponent);
    }
}

/* A sky dome or a lost vertex a thousand kilometres off has positions that are rounded to centimetres. Surfaces here
   light each other all the same. */
static void far_lights_take_no_light_from_near_ones(void **state)
{
    enum { N = 4 };
    const float at[3] = { 0.3f, 0.05f, 0.2f }, down[3] = { 0, -1, 0 };
    float places[3 * N * N], up[3 * N * N], albedo[3 * N * N], e[3];
    rsm_texel lights[2];
    rsm_points receiver = points_of(at, down, 1, 0);
    rsm_gather_desc g;
    rsm_buffers b;
    rsm_desc d = sun_desc(1, 1, N);
    const rsm_map *list[1];
    rsm_map *map;
    double expected = 0;
    int i, k;
    (void)state;
    memset(&b, 0, sizeof b);
    b.positions = places;
    b.normals = up;
    b.albedo = albedo;
    for (i = 0; i < N * N; i++) {
        set3(places + 3 * i, i % N * 0.5 - 0.75, 0, i / N * 0.5 - 0.75);
        set3(up + 3 * i, 0, 1, 0);
        set3(albedo + 3 * i, 0.5, 0.5, 0.5);
    }
    set3(places, 0, -1e6, 0);                    /* a black one */
    set3(albedo, 0, 0, 0);
    assert_int_equal(rsm_map_create(&d, &map), RSM_OK);
    assert_int_equal(rsm_fill(map, 0, &b), RSM_OK);
    assert_int_equal(rsm_finish(map, NULL), RSM_OK);
    for (i = 1; i < N * N; i++) {
        double dx = (double)places[3 * i] - (double)at[0], dz = (double)places[3 * i + 2] - (double)at[2], d2;
        d2 = dx * dx + dz * dz + (double)at[1] * (double)at[1];
        expected += (double)rsm_map_texels(map)[i].flux[0] * (double)at[1] * (double)at[1] / (d2 * d2) / PI;
    }
    list[0] = map;
    for (k = 0; k < 2; k++) {
        memset(&g, 0, sizeof g);
        g.sample_count = k ? 64 : 0;
        assert_int_equal(rsm_gather(list, 1, &g, &receiver, e, NULL), RSM_OK);
        if (k == 0 && fabs((double)e[0] - expected) > 1e-4 * expected)
            fail_msg("map: %g, not %g", (double)e[0], expected);
        assert_true((double)e[0] > 0.5 * expected);
    }
    lights[0] = rsm_map_texels(map)[5];
    lights[1] = lights[0];
    set3(lights[1].position, 1e6, 0, 0);
    memset(&g, 0, sizeof g);
    for (k = 1; k <= 2; k++) {
        float one[3];
        assert_int_equal(rsm_gather_list(lights, (size_t)k, &g, &receiver, e, NULL), RSM_OK);
        if (k == 1) memcpy(one, e, sizeof one);
        assert_true(one[0] > 0);
        assert_memory_equal(one, e, sizeof one);
    }
    rsm_map_free(map);
}

/* ---- by flux ---- */

static const rsm_texel *pick(const rsm_map *map, uint32_t i, uint32_t n, uint32_t seed, double *weight, size_t *place,
                             int *sure)
{
    const uint32_t side = map_side(map), rows = side * map_faces(map);
    const rsm_texel *t = rsm_map_texels(map);
    double v = ((double)i + (double)rsm__random(seed, 6, 0)) / n * total_of(map), row_sum = 0, before = 0, u, at = 0;
    uint32_t row, x;
    for (row = 0; row < rows; row++, before += row_sum) {
        for (row_sum = 0, x = 0; x < side; x++) row_sum += flux_of(t + row * side + x);
        if (v < before + row_sum) break;
    }
    u = (double)rsm__to_unit(i * 2654435769u) + (double)rsm__random(seed, 5, 0);
    u = (u - floor(u)) * row_sum;
    *sure &= fabs(v - before) > 1e-5 * row_sum && fabs(v - before - row_sum) > 1e-5 * row_sum;
    for (x = 0; x < side; x++) {
        double f = flux_of(t + row * side + x);
        at += f;
        if (f > 0) *sure &= fabs(u - at) > 1e-5 * row_sum;
        if (u < at) break;
    }
    *place = (size_t)row * side + x;
    *weight = total_of(map) / (n * flux_of(t + *place));
    return t + *place;
}

static void lights_are_picked_by_flux(void **state)
{
    static rsm_texel list[300];
    size_t count, place, known = 0;
    uint32_t i;
    int k;
    (void)state;
    for (k = 0; k < MAPS; k++) {
        assert_int_equal(rsm_pixel_lights((const rsm_map *const *)&maps[k], 1, 300, 5, list, 300, &count), RSM_OK);
        assert_int_equal(count, 300);
        for (i = 0; i < 300; i++) {
            double weight;
            int sure = 1, c;
            const rsm_texel *t = pick(maps[k], i, 300, 5, &weight, &place, &sure);
            if (!sure) continue;
            known++;
            assert_memory_equal(t->position, list[i].position, 12);
            assert_true(fabs((double)list[i].area / ((double)t->area * weight) - 1) < 1e-6);
            for (c = 0; c < 3; c++)
                assert_true(fabs((double)list[i].flux[c] / ((double)t->flux[c] * weight) - 1) < 1e-6);
        }
    }
    assert_true(known > 800);
    for (k = 0; k < 2; k++) { /* two maps: one after the other; too little room: nothing is written */
        memset(list, 0x55, sizeof list);
        assert_int_equal(rsm_pixel_lights((const rsm_map *const *)maps, 2, 100, 5, list, k ? 200 : 199, &count),
                         k ? RSM_OK : RSM_ERR_MEMORY);
        assert_int_equal(count, 200);
        if (!k) assert_int_equal(list[0].material, 0x55555555);
    }
}

/* ---- about the receiver ---- */

/* Balance of the two ways of MIXED at a texel: by flux n1 P, about the receiver B / q. */
static double share_by_flux(const rsm_map *map, const rsm_gather_desc *g, uint32_t by_flux, uint32_t centred,
                            size_t place, size_t pixel)
{
    const uint32_t side = map_side(map);
    const size_t face = place / ((size_t)side * side), row = place / side % side, column = place % side;
    const double r_min = 1.0 / 192, density = 1 / (2 * PI * (log(192) + 0.5));
    double at[3] = { 0, 0, 0 }, middle[3] = { 0, 0, 0 }, q = r_min * r_min, b, a;
    int c;
    (void)g;
    if (map_faces(map) == 1) {
        float uv[2], depth;
        uint32_t f;
        assert_int_equal(rsm_map_project(map, positions + 3 * pixel, &f, uv, &depth), RSM_OK);
        at[0] = ((double)column + 0.5) / side;
        at[1] = ((double)row + 0.5) / side;
        for (c = 0; c < 2; c++) middle[c] = fmin(0.98, fmax(0.02, (double)uv[c]));
        b = centred * density / ((double)side * side);
    } else {                                     /* on the sphere of diameter 1; frames by the matrix */
        static const double lamp[3] = { 0.3, 2.4, -0.2 };
        float m[16];
        assert_int_equal(rsm_map_matrix(map, (uint32_t)face, m), RSM_OK);
        for (c = 0; c < 3; c++) {
            double u = ((double)column + 0.5) * 2 / side - 1, v = ((double)row + 0.5) * 2 / side - 1;
            at[c] = (double)m[4 * c] * u + (double)m[4 * c + 1] * v + (double)m[4 * c + 3];
            middle[c] = (double)positions[3 * pixel + (size_t)c] - lamp[c];
        }
        unit3(at);
        unit3(middle);
        for (c = 0; c < 3; c++) {
            at[c] *= 0.5;
            middle[c] *= 0.5;
        }
        b = centred * density * PI / 6 / ((double)side * side);
    }
    for (c = 0; c < 3; c++) q += (at[c] - middle[c]) * (at[c] - middle[c]);
    a = by_flux * flux_of(rsm_map_texels(map) + place) / total_of(map);
    return a / (a + b / q);
}

/* A sample of a flat map: x, y in units of the side about the centre, to the border where r_max is 0. */
static int place_flat(const rsm_map *map, double r_max, size_t pixel, double x, double y, double *weight, size_t *place,
                      int *sure)
{
    const double side = map_side(map);
    double r = r_max, cx, cy;
    float uv[2], depth;
    uint32_t face;
    assert_int_equal(rsm_map_project(map, positions + 3 * pixel, &face, uv, &depth), RSM_OK);
    cx = (double)uv[0];
    cy = (double)uv[1];
    if (!(r > 0)) {
        double l = hypot(x, y);
        cx = fmin(0.98, fmax(0.02, cx));
        cy = fmin(0.98, fmax(0.02, cy));
        r = fmin(x > 0 ? (1 - cx) / (x / l) : cx / (-x / l), y > 0 ? (1 - cy) / (y / l) : cy / (-y / l));
    }
    x = (cx + r * x) * side;
    y = (cy + r * y) * side;
    *weight *= r * r * side * side;
    if (fabs(x - floor(x + 0.5)) < 1e-4 || fabs(y - floor(y + 0.5)) < 1e-4) *sure = 0;
    if (x < 0 || y < 0 || x >= side || y >= side) return 0;
    *place = (size_t)y * (size_t)side + (size_t)x;
    return 1;
}

/* Of a cube: the disc is the sphere about the receiver's direction, of equal area. */
static int place_round(const rsm_map *map, double r_max, size_t pixel, double x, double y, double *weight,
                       size_t *place, int *sure)
{
    const double side = map_side(map);
    double r = r_max > 0 && r_max < 1 ? r_max : 1, z[3], d[3], height, q, u = 0, v = 0, w = 0;
    float m[16];
    uint32_t face, k;
    rsm__v3 b1, b2;
    for (k = 0; k < 3; k++) z[k] = (double)positions[3 * pixel + k] - (k == 0 ? 0.3 : k == 1 ? 2.4 : -0.2);
    unit3(z);
    rsm__v3_basis(rsm__v3_make((float)z[0], (float)z[1], (float)z[2]), &b1, &b2);
    x *= r;
    y *= r;
    height = 1 - 2 * (x * x + y * y);
    q = 2 * sqrt(fmax(0, 1 - x * x - y * y));
    d[0] = z[0] * height + q * (x * (double)b1.x + y * (double)b2.x);
    d[1] = z[1] * height + q * (x * (double)b1.y + y * (double)b2.y);
    d[2] = z[2] * height + q * (x * (double)b1.z + y * (double)b2.z);
    for (face = 0; face < map_faces(map); face++) {
        assert_int_equal(rsm_map_matrix(map, face, m), RSM_OK);
        w = (double)m[3] * d[0] + (double)m[7] * d[1] + (double)m[11] * d[2];
        u = ((double)m[0] * d[0] + (double)m[4] * d[1] + (double)m[8] * d[2]) / w;
        v = ((double)m[1] * d[0] + (double)m[5] * d[1] + (double)m[9] * d[2]) / w;
        if (w > 0 && fabs(u) <= 1.00001 && fabs(v) <= 1.00001) break;
    }
    if (face == map_faces(map)) return 0;
    u = (u * 0.5 + 0.5) * side;
    v = (v * 0.5 + 0.5) * side;
    if (fabs(u - floor(u + 0.5)) < 1e-4 || fabs(v - floor(v + 0.5)) < 1e-4) *sure = 0;
    *place = ((size_t)face * (size_t)side + (size_t)v) * (size_t)side + (size_t)u;
    u = (floor(u) + 0.5) * 2 / side - 1;
    v = (floor(v) + 0.5) * 2 / side - 1;
    /* density: weight / pi of a sphere of 4 pi r^2; a texel's solid angle is 4 / side^2 / (1 + u^2 + v^2)^1.5 */
    *weight *= 4 * r * r / (4 / (side * side) / pow(1 + u * u + v * v, 1.5));
    return 1;
}

static void gather_brute(const rsm_map *const *list, size_t list_count, const rsm_gather_desc *g, size_t pixel, sums *s)
{
    const uint32_t k = g->interleave ? g->interleave : 1, sets = k * k,
                   set = (uint32_t)(pixel % WIDE % k + k * (pixel / WIDE % k));
    const int mixed = g->pattern == RSM_PATTERN_MIXED;
    const uint32_t about = g->pattern == RSM_PATTERN_FLUX ? 0 : mixed ? 3 * g->sample_count / 5 : g->sample_count;
    const uint32_t by_flux = g->sample_count - about, centred = (about + sets - 1) / sets * sets;
    static float pattern[3 * 1024];
    double turn = 0;
    size_t m, place = 0;
    uint32_t i, placed;
    memset(s, 0, sizeof *s);
    s->sure = 1;
    s->nearest2 = 1e30;
    if (g->noise)
        turn = 2 * PI * (double)g->noise[pixel / WIDE % g->noise_side * g->noise_side + pixel % WIDE % g->noise_side];
    if (centred)
        assert_int_equal(rsm_pattern_build(mixed ? RSM_PATTERN_LOG_RADIAL : g->pattern, centred,
                                           mixed ? 1.0f / 192.0f : g->r_min, g->paper_weights, g->seed, pattern),
                         RSM_OK);
    for (m = 0; m < list_count; m++) {
        const rsm_map *map = list[m];
        const uint32_t all = (uint32_t)texels_of(map);
        for (i = 0, placed = 0; i < (g->sample_count ? by_flux : all); i++) {
            double weight = 1, share = 1;
            const rsm_texel *t = g->sample_count ? pick(map, i, by_flux, g->seed, &weight, &place, &s->sure)
                                            : rsm_map_texels(map) + (place = i);
            if (!(flux_of(t) > 0)) continue;
            if ((placed + rsm__hash_combine(g->seed, placed / sets)) % sets == set) {
                if (mixed && centred) share = share_by_flux(map, g, by_flux, centred, place, pixel);
                add_light(s, g, map, t, pixel, weight, share * sets, g->sample_count == 0);
            }
            placed++;
        }
        for (i = set; i < centred; i += sets) {
            double x = (double)pattern[3 * i], y = (double)pattern[3 * i + 1], weight = (double)pattern[3 * i + 2],
                   share = 1;
            double a = x * cos(turn) - y * sin(turn), b = x * sin(turn) + y * cos(turn);
            int there = map_faces(map) == 1
                ? place_flat(map, mixed ? 0 : (double)g->r_max, pixel, a, b, &weight, &place, &s->sure)
                : place_round(map, mixed ? 0 : (double)g->r_max, pixel, a, b, &weight, &place, &s->sure);
            if (!there) continue;
            if (mixed) share = 1 - share_by_flux(map, g, by_flux, centred, place, pixel);
            add_light(s, g, map, rsm_map_texels(map) + place, pixel, weight * share, sets, 1);
        }
    }
}

/* Share of the flux of texels whose centres lie farther than r_max from the receiver's place. */
static double outside_brute(const rsm_map *map, double r_max, size_t pixel)
{
    const uint32_t side = map_side(map);
    double outside = 0;
    size_t i;
    for (i = 0; i < texels_of(map); i++) {
        double u = ((double)(i % side) + 0.5) / side, v = ((double)(i / side % side) + 0.5) / side, far2 = 0;
        const rsm_texel *t = rsm_map_texels(map) + i;
        int c;
        if (map_faces(map) == 1) {
            float uv[2], depth;
            uint32_t face;
            assert_int_equal(rsm_map_project(map, positions + 3 * pixel, &face, uv, &depth), RSM_OK);
            far2 = pow(u - (double)uv[0], 2) + pow(v - (double)uv[1], 2);
        } else {
            double a[3], b[3];
            for (c = 0; c < 3; c++) {
                double lamp = c == 0 ? 0.3 : c == 1 ? 2.4 : -0.2;
                a[c] = (double)t->position[c] - lamp;
                b[c] = (double)positions[3 * pixel + (size_t)c] - lamp;
            }
            unit3(a);
            unit3(b);
            far2 = 0.5 * (1 - dot3(a, b));       /* sin^2 of half the angle */
        }
        if (far2 > r_max * r_max) outside += flux_of(t);
    }
    return outside / total_of(map);
}

static void compare(const rsm_map *const *list, size_t count, const rsm_gather_desc *g, const char *what)
{
    static float open[PIXELS];
    rsm_gather_stats stats;
    rsm_points p = points;
    double full = 0, lost = 0, outside = 0, near = 0;
    size_t i, m, sure = 0, padded = (g->sample_count + 7) / 8 * 8;
    int c;
    for (i = 0; i < PIXELS; i++) {
        open[i] = (float)i / 30 - 0.1f;     /* below 0 and above 1 too */
        for (c = 0; c < 3; c++) got[3 * i + (size_t)c] = 0.25f;
    }
    p.open = open;
    assert_int_equal(rsm_gather(list, count, g, &p, got, &stats), RSM_OK);
    for (i = 0; i < PIXELS; i++) {
        double factor = fmin(1, fmax(0, (double)open[i]));
        sums s;
        gather_brute(list, count, g, i, &s);
        full += s.full;
        lost += s.lost;
        near += s.near;
        for (m = 0; m < count && g->r_max > 0; m++) outside += outside_brute(list[m], (double)g->r_max, i);
        if (!s.sure) continue;
        sure++;
        for (c = 0; c < 3; c++) {
            double expected = s.rgb[c] / PI * factor + (g->add ? 0.25 : 0);
            if (fabs((double)got[3 * i + (size_t)c] - expected) > 1e-4 * (expected + 1e-3))
                fail_msg("%s, pixel %d: %g, not %g", what, (int)i, (double)got[3 * i + (size_t)c], expected);
        }
    }
    if ((near > 0) != (g->near_field > 0 && (g->pattern != RSM_PATTERN_FLUX || !g->sample_count)))
        fail_msg("%s: %g near texels", what, near);
    if (sure < PIXELS / 3) fail_msg("%s: only %d pixels are sure", what, (int)sure);
    assert_int_equal(stats.evaluated, PIXELS);
    assert_int_equal(stats.bad_points, 0);
    if (g->pattern != RSM_PATTERN_MIXED && g->sample_count && g->interleave < 2)
        assert_int_equal(stats.pairs, PIXELS * count * (g->pattern == RSM_PATTERN_FLUX ? padded : g->sample_count));
    if (g->clamp > 0 || g->near_limit > 0) {
        if (!(lost > 0)) fail_msg("%s: nothing is lost", what);
        if (sure == PIXELS) assert_true(fabs(stats.clamped_share - lost / full) < 1e-5);
    } else assert_true(!(stats.clamped_share > 0));
    if (g->r_max > 0 && g->pattern != RSM_PATTERN_FLUX && g->pattern != RSM_PATTERN_MIXED)
        assert_true(fabs(stats.outside_share - outside / (double)(PIXELS * count)) < 1e-3);
    else assert_true(!(stats.outside_share > 0));
}

static void every_pattern_sums_its_samples(void **state)
{
    static const rsm_material lobes[2] = { { { 0, 0, 0 }, 3 }, { { 0.5f, 0.25f, 0.125f }, 6 } };
    static const float noise[6 * 6] = { 0, 0.1f, 0.7f, 0.3f, 0.9f, 0.5f, 0.2f, 1, 0.6f, 0.8f, 0.05f, 0.35f };
    int p, k, way;
    char what[80];
    (void)state;
    for (p = RSM_PATTERN_FLUX; p < RSM_PATTERN_COUNT; p++)
        for (k = 0; k < MAPS; k++)
            for (way = 0; way < 12; way++) {
                rsm_gather_desc g = gather_desc((rsm_pattern)p, 60);
                snprintf(what, sizeof what, "pattern %d, map %d, way %d", p, k, way);
                g.seed = (uint32_t)way;
                if (way == 1) g.offset = 0.05f;
                if (way == 2) g.near_limit = 0.05f;
                if (way == 3) g.clamp = 0.3f;
                if (way == 4) g.r_max = 0.4f;
                if (way == 5) { g.noise = noise; g.noise_side = 6; }
                if (way == 6) { g.interleave = 2; g.near_limit = 0.05f; }
                if (way == 7) { g.materials = lobes; g.material_count = 2; g.near_limit = 0.05f; }
                if (way == 8) { g.add = 1; g.r_min = 0.2f; g.paper_weights = 1; }
                if (way > 8) g.near_field = 12;
                if (way == 10) { g.near_limit = 0.05f; g.offset = 0.05f; g.interleave = 2; }
                if (way == 11) { g.materials = lobes; g.material_count = 2; g.clamp = 0.3f; }
                compare((const rsm_map *const *)&maps[k], 1, &g, what);
            }
}

static void every_texel_of_several_maps_is_gathered(void **state)
{
    static const rsm_material lobe = { { 1, 1, 1 }, 2 };
    static const rsm_material lobes[2] = { { { 0, 0, 0 }, 3 }, { { 0.5f, 0.25f, 0.125f }, 6 } };
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 0);
    int i;
    (void)state;
    compare((const rsm_map *const *)maps, MAPS, &g, "every texel");
    g.interleave = 4;
    g.clamp = 0.3f;
    compare((const rsm_map *const *)maps, MAPS, &g, "every texel of 16 sets");
    for (i = 0; i < 3; i++) { /* nearer than 4, 12 and 32 sides */
        g.near_field = i == 0 ? 4 : i == 1 ? 12 : 32;
        compare((const rsm_map *const *)maps, MAPS, &g, "every texel of 16 sets, near ones as surfaces");
        g.interleave = 0;
        compare((const rsm_map *const *)maps, MAPS, &g, "every texel, near ones as surfaces");
        g.materials = lobes;
        g.material_count = 2;
        compare((const rsm_map *const *)maps, MAPS, &g, "the same with a lobe");
        g.materials = NULL;
        g.material_count = 0;
        g.interleave = 4;
    }
    g.near_field = 0;
    g.clamp = 0;
    g.interleave = 0;
    g.materials = &lobe;
    g.material_count = 1;                        /* the room's is the second: diffuse then */
    compare((const rsm_map *const *)maps, 2, &g, "a material that is not there");
    g.pattern = RSM_PATTERN_MIXED;
    g.materials = NULL;
    g.material_count = 0;
    g.sample_count = 100;
    g.interleave = 2;
    compare((const rsm_map *const *)maps, 2, &g, "mixed, four sets, two maps");
    g.sample_count = 1;                               /* too few to mix: by flux */
    g.interleave = 0;
    g.pattern = RSM_PATTERN_FLUX;
    assert_int_equal(rsm_gather((const rsm_map *const *)maps, 1, &g, &points, got, NULL), RSM_OK);
    {
        float other[3 * PIXELS];
        g.pattern = RSM_PATTERN_MIXED;
        assert_int_equal(rsm_gather((const rsm_map *const *)maps, 1, &g, &points, other, NULL), RSM_OK);
        assert_memory_equal(got, other, sizeof got);
    }
}

/* Sides of the surface under texels of all maps: by rays, and their area is the texel's; those that light grazes have
   no more than that. */
static void texels_have_their_sides(void **state)
{
    static const float slope[] = { -1, -2, -1, 2, 80, 0, 0, 0, 2 };
    model m = model_quads(slope, 1);
    rsm_mesh mesh = mesh_of(&m, 0.5);
    rsm_desc d = sun_desc(1, 1, SIZE);
    rsm_map *grazed;
    size_t i, known = 0;
    int k, j, c;
    (void)state;
    set3(d.light.position, 0, 38, 0);
    d.light.near_depth = -100;
    d.light.far_depth = 100;
    grazed = map_of(&d, &mesh, 1, NULL);
    assert_non_null(grazed);
    for (k = 0; k < MAPS + 1; k++) {
        const rsm_map *map = k < MAPS ? maps[k] : grazed;
        const size_t face = (size_t)map_side(map) * map_side(map);
        for (i = 0; i < texels_of(map); i++) {
            const rsm_texel *t = rsm_map_texels(map) + i;
            const rsm__v3 n = rsm__v3_load(t->normal);
            rsm__v3 side[2];
            double exact[2][3], area;
            if (!(flux_of(t) > 0)) continue;
            rsm__texel_sides(map, (uint32_t)(i / face), rsm__v3_load(t->position), n, side);
            area = 4 * (double)rsm__v3_length(rsm__v3_cross(side[0], side[1]));
            assert_true(fabs(area / (double)t->area - 1) < 1e-4);
            sides_of(map, t, 0, exact);
            for (j = 0; j < 2; j++) {
                double got_side[3], off = 0, length = sqrt(dot3(exact[j], exact[j]));
                assert_true(fabs((double)rsm__v3_dot(side[j], n)) < 1e-5 * length);
                for (c = 0; c < 3; c++) {
                    got_side[c] = (double)(c == 0 ? side[j].x : c == 1 ? side[j].y : side[j].z);
                    off += pow(got_side[c] - exact[j][c], 2);
                }
                if (k < MAPS) assert_true(sqrt(off) < 1e-4 * length);
                else assert_true(dot3(got_side, got_side) < 1.001 * dot3(exact[j], exact[j]));
            }
            known++;
        }
    }
    assert_true(known > 500);
    rsm_map_free(grazed);
    model_free(&m);
}

/* Lists and rows: few lights of interleaved sets go to eight pixels together. Unusable lights are left out. */
static void lists_are_summed_in_rows(void **state)
{
    static rsm_texel list[77];
    static const uint32_t some[5] = { 40, 3, 17, 9, 8 };
    const float odd[3] = { rsm__from_bits(0x7fc00000u), rsm__from_bits(0x7f800000u), -1 };
    uint32_t k, n;
    size_t i, count;
    int c, indexed;
    (void)state;
    assert_int_equal(rsm_pixel_lights((const rsm_map *const *)maps, 1, 77, 1, list, 77, &count), RSM_OK);
    for (i = 0; i < 3; i++) list[10 * i + 1].flux[i] = odd[i];
    set3(list[31].flux, 1e18, 1e18, 2e18);
    list[5].position[1] = odd[0];
    list[6].normal[2] = odd[1];
    for (k = 1; k <= 8; k *= 2)
        for (n = 1; n < 78; n += 19)
            for (indexed = 0; indexed < 3; indexed++) {
                const size_t wide = indexed == 2 ? PIXELS : WIDE;        /* 2: points, no picture: no sets */
                rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 0);
                rsm_points p = points;
                rsm_gather_stats stats;
                g.interleave = k;
                g.near_limit = 0.4f;
                g.near_field = 32;               /* lights of a list are points */
                if (indexed == 2) p.width = 0;
                if (indexed == 2 && k > 1) {
                    assert_int_equal(rsm_gather_list(list, n, &g, &p, got, &stats), RSM_ERR_DESC);
                    continue;
                }
                if (indexed == 1) {
                    p.indices = some;
                    p.index_count = 5;
                }
                for (i = 0; i < 3 * PIXELS; i++) got[i] = 7;
                positions[3 * 17] = odd[0];      /* and a receiver that cannot be used, and one that is none */
                memset(normals + 3 * 40, 0, 12);
                assert_int_equal(rsm_gather_list(list, n, &g, &p, got, &stats), RSM_OK);
                positions[3 * 17] = 0.5f;
                assert_int_equal(stats.bad_points, 1);
                assert_int_equal(stats.evaluated, indexed == 1 ? 3 : PIXELS - 2);
                for (i = 0; i < PIXELS; i++) {
                    const size_t set = i % wide % k + k * (i / wide % k);
                    sums s;
                    size_t l;
                    int asked = indexed != 1;
                    for (l = 0; l < 5; l++) asked |= some[l] == i;
                    memset(&s, 0, sizeof s);
                    for (l = set; l < n && i != 17 && i != 40; l += (size_t)k * k)
                        if (l % 10 != 1 || l > 31)
                            if (l != 5 && l != 6) add_light(&s, &g, maps[0], list + l, i, 1, (double)k * k, 0);
                    for (c = 0; c < 3; c++) {
                        double expected = asked ? s.rgb[c] / PI : 7;
                        if (!(fabs((double)got[3 * i + (size_t)c] - expected) < 1e-5 * (1 + expected)))
                            fail_msg("%d sets, %d lights, pixel %d: %g, not %g", (int)(k * k), (int)n, (int)i,
                                     (double)got[3 * i + (size_t)c], expected);
                    }
                }
                set3(normals + 3 * 40, 0.6, -0.8, 0);
            }
}

/* ---- section 4 ---- */

enum { W = 45, H = 29, N = W * H };

static float at[3 * N], facing[3 * N], exact[3 * N], grid_light[3 * N], expected_light[3 * N];
static double reach2[N];
static uint8_t mask[N], state_of[N];

static int suits(int pixel, int sample, const rsm_interpolation *in)
{
    const float *p = at + 3 * pixel, *n = facing + 3 * pixel, *q = at + 3 * sample, *m = facing + 3 * sample;
    double d2 = 0, off = 0, other = 0, cosine = 0, slope = in->plane_slope > 0 ? (double)in->plane_slope : 0.05;
    double reach = in->light_share < 0 ? 0 : in->light_share > 0 ? (double)in->light_share : 0.25;
    int c;
    for (c = 0; c < 3; c++) {
        double d = (double)q[c] - (double)p[c];
        d2 += d * d;
        off += d * (double)n[c];
        other += d * (double)m[c];
        cosine += (double)n[c] * (double)m[c];
    }
    if (cosine < (in->normal_cosine > 0 ? (double)in->normal_cosine : 0.95)) return 0;
    if (off * off > slope * slope * d2 || other * other > slope * slope * d2) return 0;
    if (in->distance > 0 && d2 > (double)in->distance * (double)in->distance) return 0;
    return !(reach > 0 && d2 > reach2[sample] * reach * reach);
}

static int line_after(int at_, int step, int size)
{
    return at_ / step * step + step < size ? at_ / step * step + step : size - 1;
}

/* 0 none, 1 pending, 2 interpolated, 3 evaluated */
static void interpolate_brute(const rsm_interpolation *in)
{
    int step = in->step ? (int)in->step : 8, levels = in->level_count ? (int)in->level_count : 6, x, y, k, c;
    double contrast = in->contrast < 0 ? 1e30 : in->contrast > 0 ? (double)in->contrast : 0.25;
    for (; step > 1 && levels > 0; step /= 2, levels--) {
        static uint8_t wanted[N];
        memset(wanted, 0, sizeof wanted);
        for (y = 0; y < H; y++)
            for (x = 0; x < W; x++)
                for (k = 0; k < 4 && state_of[y * W + x] == 1; k++)
                    wanted[(k >> 1 ? line_after(y, step, H) : y / step * step) * W +
                           (k & 1 ? line_after(x, step, W) : x / step * step)] = 1;
        for (k = 0; k < N; k++)
            if (wanted[k] && state_of[k]) {
                state_of[k] = 3;
                memcpy(expected_light + 3 * k, exact + 3 * k, 12);
            }
        for (y = 0; y < H; y++)
            for (x = 0; x < W; x++) {
                int x0 = x / step * step, y0 = y / step * step, x1 = line_after(x, step, W),
                    y1 = line_after(y, step, H);
                int corner[4], good = 0, missing = 4;
                double u = x1 > x0 ? (double)(x - x0) / (x1 - x0) : 0, v = y1 > y0 ? (double)(y - y0) / (y1 - y0) : 0;
                double w[4], low = 1e30, high = 0, sum = 0;
                if (state_of[y * W + x] != 1) continue;
                for (k = 0; k < 4; k++) {
                    corner[k] = (k >> 1 ? y1 : y0) * W + (k & 1 ? x1 : x0);
                    if (state_of[corner[k]] == 3 && suits(y * W + x, corner[k], in)) good++;
                    else missing = k;
                }
                if (good < 3) continue;
                for (k = 0; k < 4; k++) {
                    const float *e = exact + 3 * corner[k];
                    double mean = ((double)e[0] + (double)e[1] + (double)e[2]) / 3;
                    if (k == missing) continue;
                    low = fmin(low, mean);
                    high = fmax(high, mean);
                    sum += mean;
                }
                if (high - low > contrast * sum / good) continue;
                w[0] = (1 - u) * (1 - v);
                w[1] = u * (1 - v);
                w[2] = (1 - u) * v;
                w[3] = u * v;
                if (missing < 4) {
                    w[missing ^ 1] += w[missing];
                    w[missing ^ 2] += w[missing];
                    w[missing ^ 3] -= w[missing];
                    w[missing] = 0;
                }
                for (c = 0; c < 3; c++) {
                    double value = 0;
                    for (k = 0; k < 4; k++) value += w[k] * (double)exact[3 * corner[k] + c];
                    expected_light[3 * (y * W + x) + c] = (float)fmax(0, value);
                }
                state_of[y * W + x] = 2;
            }
    }
    for (k = 0; k < N; k++)
        if (state_of[k] == 1) {
            state_of[k] = 3;
            memcpy(expected_light + 3 * k, exact + 3 * k, 12);
        }
}

/* A floor with a ramp, a round pillar, a step, and holes in the picture. */
static void make_picture(void)
{
    int x, y;
    for (y = 0; y < H; y++)
        for (x = 0; x < W; x++) {
            double u = (x + 0.5) / W * 3 - 1.5, v = (y + 0.5) / H * 2 - 1, h = 0.2, nx = 0, nz = 0, l;
            float *p = at + 3 * (y * W + x), *n = facing + 3 * (y * W + x);
            if (u > 0.8) h = 0.6;
            if (u < -0.5) {
                h += 0.4 * (-0.5 - u);
                nx = 0.4;
            }
            if (hypot(u - 0.2, v) < 0.3) {
                h += 0.3 - hypot(u - 0.2, v);
                nx = (u - 0.2) / hypot(u - 0.2, v);
                nz = v / hypot(u - 0.2, v);
            }
            l = sqrt(nx * nx + 1 + nz * nz);
            set3(p, u, h, v);
            set3(n, nx / l, 1 / l, nz / l);
            if (x == 16 && y == 8) set3(n, 0, 0, 0);
            if (x > 30 && x < 34 && y > 20) set3(n, 0, 0, 0);
        }
    at[3 * (3 * W + 11)] = rsm__from_bits(0x7f800000u);
}

static void grids_are_section_four(void **state)
{
    static const float wall[] = { -1.7f, 0, -1.5f, 0, 0, 3, 0, 1, 0,  0.4f, 1.2f, -0.4f, 0.3f, 0, 0, 0, 0, 0.3f };
    static rsm_texel lights[64];
    static float open[N];
    model m = model_quads(wall, 2);
    rsm_mesh mesh = mesh_of(&m, 0.8);
    rsm_desc d = sun_desc(3, 2, 64);
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 64);
    rsm_points p = points_of(at, facing, N, W);
    rsm_map *map;
    size_t count;
    int way, i, c, interpolated = 0;
    (void)state;
    set3(d.light.direction, 0.8, -0.36, 0.48);
    map = map_of(&d, &mesh, 1, NULL);
    assert_non_null(map);
    make_picture();
    assert_int_equal(rsm_gather((const rsm_map *const *)&map, 1, &g, &p, exact, NULL), RSM_OK);
    assert_int_equal(rsm_pixel_lights((const rsm_map *const *)&map, 1, 64, 0, lights, 64, &count), RSM_OK);
    for (i = 0; i < N; i++) {
        size_t l;
        for (reach2[i] = 1e30, l = 0; l < count; l++) {
            double q[3], d2, cr = 0, ce = 0;
            for (c = 0; c < 3; c++) {
                q[c] = (double)lights[l].position[c] - (double)at[3 * i + c];
                cr += q[c] * (double)facing[3 * i + c];
                ce -= q[c] * (double)lights[l].normal[c];
            }
            d2 = dot3(q, q);
            if (cr > 0 && ce > 0 && cr * ce / d2 > 1e-3) reach2[i] = fmin(reach2[i], d2);
        }
        open[i] = (float)(i % 7) * 0.25f - 0.2f;
    }
    for (way = 0; way < 12; way++) {
        rsm_interpolation in;
        rsm_gather_stats stats;
        size_t evaluated = 0;
        memset(&in, 0, sizeof in);
        in.mask = mask;
        if (way == 1) in.step = 4;
        if (way == 2) in.step = 16;
        if (way == 3) in.level_count = 1;
        if (way == 4) in.level_count = 2;
        if (way == 5) in.contrast = -1;
        if (way == 6) in.contrast = 0.02f;
        if (way == 7) in.light_share = -1;
        if (way == 8) in.light_share = 0.6f;
        if (way == 9) in.distance = 0.15f;
        if (way == 10) in.normal_cosine = 0.6f;
        if (way == 11) {
            in.plane_slope = 0.4f; in.step = 64; in.contrast = in.light_share = -1; in.normal_cosine = 0.8f;
        }
        p.open = way % 2 ? open : NULL;
        for (i = 0; i < N; i++) {
            double n2 = 0;
            for (c = 0; c < 3; c++) n2 += (double)facing[3 * i + c] * (double)facing[3 * i + c];
            state_of[i] = n2 > 0 && i != 3 * W + 11;
            memset(expected_light + 3 * i, 0, 12);
        }
        interpolate_brute(&in);
        assert_int_equal(rsm_interpolate((const rsm_map *const *)&map, 1, &g, &in, &p, grid_light, &stats), RSM_OK);
        for (i = 0; i < N; i++) {
            double f = p.open ? fmin(1, fmax(0, (double)open[i])) : 1;
            if (mask[i] != (state_of[i] ? state_of[i] - 1 : 0))
                fail_msg("way %d, pixel %d %d: %d, not %d", way, i % W, i / W, mask[i],
                         state_of[i] ? state_of[i] - 1 : 0);
            evaluated += mask[i] == 2;
            interpolated += mask[i] == 1;
            for (c = 0; c < 3; c++)
                assert_true(fabs((double)grid_light[3 * i + c] - (double)expected_light[3 * i + c] * f) < 1e-5);
        }
        assert_true(stats.evaluated >= evaluated && stats.evaluated <= evaluated + N / 10);
        assert_int_equal(stats.pairs, 64 * stats.evaluated);
        assert_int_equal(stats.bad_points, 1);
    }
    assert_true(interpolated > 3 * N);
    rsm_map_free(map);
    model_free(&m);
}

/* ---- clusters ---- */

enum { LIGHTS = 300, GROUPS = 23 };

typedef struct group { int count, of[LIGHTS]; double mean[6], spread[6], cost; } group;

static double place_of(const rsm_texel *t, int k) { return (double)(k < 3 ? t->position[k] : t->normal[k - 3]); }

static void measure(group *g, const rsm_texel *lights, double size2)
{
    int i, k;
    g->cost = 0;
    for (k = 0; k < 6; k++) {
        double flux = 0, mean = 0, square = 0;
        for (i = 0; i < g->count; i++) {
            flux += flux_of(lights + g->of[i]);
            mean += flux_of(lights + g->of[i]) * place_of(lights + g->of[i], k);
        }
        g->mean[k] = mean / flux;
        for (i = 0; i < g->count; i++)
            square += flux_of(lights + g->of[i]) * pow(place_of(lights + g->of[i], k) - g->mean[k], 2);
        g->spread[k] = square / flux * (k < 3 ? 1 : 0.25 * size2);
        g->cost += g->spread[k] * flux;
    }
    if (g->count < 2) g->cost = 0;
}

/* The dearest group is cut at the mean of its widest coordinate, until there are enough. */
static void clusters_are_cut_at_means(void **state)
{
    static rsm_texel lights[LIGHTS];
    static group groups[GROUPS];
    rsm_texel clusters[GROUPS];
    size_t count;
    double size2;
    int i, k, c, found = 1;
    (void)state;
    state_of_random = 21;
    for (i = 0; i < LIGHTS; i++) {
        double n[3];
        memset(&lights[i], 0, sizeof lights[i]);
        for (k = 0; k < 3; k++) n[k] = any();
        unit3(n);
        for (k = 0; k < 3; k++) lights[i].position[k] = (float)(k == 2 ? i % 3 + 0.1 * any() : any());
        lights[i].position[1] *= lights[i].position[0];
        set3(lights[i].normal, n[0], n[1], n[2]);
        for (k = 0; k < 2; k++) lights[i].flux[k] = (float)(1 + any());
        lights[i].flux[2] = i % 11 ? 0.5f : 20;
        lights[i].area = (float)i;
        if (i % 50 == 7) set3(lights[i].flux, 0, 0, 0);
        else if (i % 50 == 9) lights[i].position[1] = rsm__from_bits(0x7fc00000u);
        else groups[0].of[groups[0].count++] = i;
    }
    measure(groups, lights, 0);
    size2 = groups[0].spread[0] + groups[0].spread[1] + groups[0].spread[2];
    measure(groups, lights, size2);
    while (found < GROUPS) {
        group *dear = groups, *other = groups + found++;
        int widest = 0, kept = 0;
        for (i = 1; i + 1 < found; i++)
            if (groups[i].cost > dear->cost) dear = groups + i;
        for (k = 1; k < 6; k++)
            if (dear->spread[k] > dear->spread[widest]) widest = k;
        for (i = 0; i < dear->count; i++) {
            if (place_of(lights + dear->of[i], widest) < dear->mean[widest]) dear->of[kept++] = dear->of[i];
            else other->of[other->count++] = dear->of[i];
        }
        dear->count = kept;
        measure(dear, lights, size2);
        measure(other, lights, size2);
    }
    assert_int_equal(rsm_cluster(lights, LIGHTS, GROUPS, NULL, clusters, &count), RSM_OK);
    assert_int_equal(count, GROUPS);
    for (i = 0; i < GROUPS; i++) {
        double flux[3] = { 0, 0, 0 }, area = 0, n[3];
        for (k = 0; k < groups[i].count; k++) {
            for (c = 0; c < 3; c++) flux[c] += (double)lights[groups[i].of[k]].flux[c];
            area += (double)lights[groups[i].of[k]].area;
        }
        for (c = 0; c < 3; c++) n[c] = groups[i].mean[3 + c];
        unit3(n);
        assert_true(fabs((double)clusters[i].area - area) < 1e-3);
        assert_true(clusters[i].depth < 1 && clusters[i].material == 0);
        for (c = 0; c < 3; c++) {
            assert_true(fabs((double)clusters[i].flux[c] - flux[c]) < 1e-3);
            assert_true(fabs((double)clusters[i].position[c] - groups[i].mean[c]) < 1e-5);
            assert_true(fabs((double)clusters[i].normal[c] - n[c]) < 1e-5);
        }
    }
    /* as many as there are, no more; lights at one place cannot be cut */
    assert_int_equal(rsm_cluster(lights, 7, GROUPS, NULL, clusters, &count), RSM_OK);
    assert_int_equal(count, 7);
    for (i = 1; i < 5; i++) lights[i] = lights[0];
    assert_int_equal(rsm_cluster(lights, 5, GROUPS, NULL, clusters, &count), RSM_OK);
    assert_int_equal(count, 1);
    assert_int_equal(rsm_cluster(lights + 7, 1, GROUPS, NULL, clusters, &count), RSM_OK);
    assert_int_equal(count, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(far_lights_take_no_light_from_near_ones),
        cmocka_unit_test(lights_are_picked_by_flux), cmocka_unit_test(every_pattern_sums_its_samples),
        cmocka_unit_test(every_texel_of_several_maps_is_gathered), cmocka_unit_test(texels_have_their_sides),
        cmocka_unit_test(lists_are_summed_in_rows), cmocka_unit_test(grids_are_section_four),
        cmocka_unit_test(clusters_are_cut_at_means),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
