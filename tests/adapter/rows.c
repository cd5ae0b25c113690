/* rows.c - rows of docs/conformance.md that any renderer can be put to, through the functions of tests/kit/adapter.h:
   closed forms of visibility, of direct light and of light that is thrown back once. Nothing of Dapple is included.
   Link it with a file that defines these functions, or include it before them as the two tests of this folder do.
   What is finer than a twentieth of an occluder is not asked, so that maps and meshes answer as rays do. */
#include "adapter.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include "conformance.h"

#define ROW_PI 3.14159265358979323846

/* ---- scenes ---- */

enum { ROOM = 16384 };
static float row_positions[3 * ROOM], row_albedos[ROOM];
static uint32_t row_indices[3 * ROOM];
static adapter_scene row_scene;

static uint32_t row_vertex(double x, double y, double z)
{
    float *p = row_positions + 3 * row_scene.vertex_count;
    assert_true(row_scene.vertex_count < ROOM);
    p[0] = (float)x;
    p[1] = (float)y;
    p[2] = (float)z;
    return (uint32_t)row_scene.vertex_count++;
}

static void row_triangle(uint32_t a, uint32_t b, uint32_t c, double albedo)
{
    uint32_t *i = row_indices + 3 * row_scene.triangle_count;
    assert_true(row_scene.triangle_count < ROOM);
    i[0] = a;
    i[1] = b;
    i[2] = c;
    row_albedos[row_scene.triangle_count++] = (float)albedo;
}

static void row_clear(void)
{
    memset(&row_scene, 0, sizeof row_scene);
    row_scene.positions = row_positions;
    row_scene.indices = row_indices;
    row_scene.albedos = row_albedos;
}

/* A parallelogram from a corner along two edges. */
static void row_quad(const double corner[3], const double u[3], const double v[3], double albedo)
{
    uint32_t k, at[4];
    for (k = 0; k < 4; k++) {
        const double s = k == 1 || k == 2, t = k >= 2;
        at[k] = row_vertex(corner[0] + s * u[0] + t * v[0], corner[1] + s * u[1] + t * v[1],
                           corner[2] + s * u[2] + t * v[2]);
    }
    row_triangle(at[0], at[1], at[2], albedo);
    row_triangle(at[0], at[2], at[3], albedo);
}

/* A rectangle of constant y. */
static void row_plate(double x0, double x1, double y, double z0, double z1, double albedo)
{
    const double corner[3] = { x0, y, z0 }, u[3] = { x1 - x0, 0, 0 }, v[3] = { 0, 0, z1 - z0 };
    row_quad(corner, u, v, albedo);
}

static void row_box(const double lo[3], const double hi[3], double albedo)
{
    int axis, side;
    for (axis = 0; axis < 3; axis++)
        for (side = 0; side < 2; side++) {
            double corner[3] = { lo[0], lo[1], lo[2] }, u[3] = { 0, 0, 0 }, v[3] = { 0, 0, 0 };
            const int a = (axis + 1) % 3, b = (axis + 2) % 3;
            corner[axis] = side ? hi[axis] : lo[axis];
            u[a] = hi[a] - lo[a];
            v[b] = hi[b] - lo[b];
            row_quad(corner, u, v, albedo);
        }
}

/* A sphere about the origin, its corners on a true one: `across` meridians, half as many rings. */
static void row_sphere(int across, double radius, double albedo)
{
    const int down = across / 2;
    const uint32_t first = (uint32_t)row_scene.vertex_count;
    int x, y;
    for (y = 0; y <= down; y++)
        for (x = 0; x < across; x++) {
            const double t = ROW_PI * y / down, f = 2 * ROW_PI * x / across;
            row_vertex(radius * sin(t) * cos(f), radius * cos(t), radius * sin(t) * sin(f));
        }
    for (y = 0; y < down; y++)
        for (x = 0; x < across; x++) {
            const uint32_t a = first + (uint32_t)(y * across + x),
                           b = first + (uint32_t)(y * across + (x + 1) % across);
            if (y) row_triangle(a, b, a + (uint32_t)across, albedo);
            if (y + 1 < down) row_triangle(b, b + (uint32_t)across, a + (uint32_t)across, albedo);
        }
}

/* A disc about the origin, y = 0, whose sectors from half a turn on have another albedo. */
static void row_disc(double radius, double albedo, double other)
{
    enum { SECTORS = 96 };
    const uint32_t middle = row_vertex(0, 0, 0);
    int k;
    for (k = 0; k < SECTORS; k++)
        row_vertex(radius * cos(2 * ROW_PI * k / SECTORS), 0, radius * sin(2 * ROW_PI * k / SECTORS));
    for (k = 0; k < SECTORS; k++)
        row_triangle(middle, middle + 1 + (uint32_t)((k + 1) % SECTORS), middle + 1 + (uint32_t)k,
                     k < SECTORS / 2 ? albedo : other);
}

/* ---- asking ---- */

static void row_open(void)
{
    if (adapter_open(&row_scene)) return;
    print_message("skip: %s does not take this scene\n", adapter_name());
    skip();
}

static void row_close_and_skip(const char *what)
{
    adapter_close();
    print_message("skip: %s does not answer %s\n", adapter_name(), what);
    skip();
}

static void row_see(const float *from, const float *ends, int at_infinity, size_t count, float *visible)
{
    if (!adapter_visible(from, ends, at_infinity, count, visible)) row_close_and_skip("visibility");
}

/* Irradiance of one point, red. */
static double row_light(const adapter_light *light, int bounced, double x, double y, double z, double nx, double ny,
                        double nz)
{
    const float p[3] = { (float)x, (float)y, (float)z }, n[3] = { (float)nx, (float)ny, (float)nz };
    float e[3] = { -1, -1, -1 };
    if (!(bounced ? adapter_bounced : adapter_direct)(light, p, n, 1, e))
        row_close_and_skip(bounced ? "bounced light of this kind" : "direct light of this kind");
    return (double)e[0];
}

static adapter_light row_lamp(adapter_light_kind kind, double value)
{
    adapter_light l;
    memset(&l, 0, sizeof l);
    l.kind = kind;
    l.value[0] = l.value[1] = l.value[2] = (float)value;
    return l;
}

static adapter_light row_sun(double x, double y, double z, double value)
{
    adapter_light l = row_lamp(ADAPTER_SUN, value);
    const double length = sqrt(x * x + y * y + z * z);
    l.direction[0] = (float)(x / length);
    l.direction[1] = (float)(y / length);
    l.direction[2] = (float)(z / length);
    return l;
}

/* ---- helpers with an answer of their own ---- */

static uint32_t row_state;
static double row_random(void)
{
    row_state = row_state * 1664525u + 1013904223u;
    return (double)(row_state >> 8) / 16777216.0;
}

static void row_direction(double d[3])
{
    const double y = 2 * row_random() - 1, f = 2 * ROW_PI * row_random(), r = sqrt(1 - y * y);
    d[0] = r * cos(f);
    d[1] = y;
    d[2] = r * sin(f);
}

/* Direction i of n that cover the sphere evenly. */
static void row_spiral(int i, int n, float d[3])
{
    const double y = 1 - (2 * i + 1.0) / n, r = sqrt(1 - y * y), f = 2.39996322972865332 * i;
    d[0] = (float)(r * cos(f));
    d[1] = (float)y;
    d[2] = (float)(r * sin(f));
}

/* Lambert: the irradiance at the origin, whose normal is +Y, by a polygon of radiance 1 all above the horizon. */
static double row_lambert(const double (*corner)[3], int count)
{
    double sum = 0;
    int k;
    for (k = 0; k < count; k++) {
        const double *a = corner[k], *b = corner[(k + 1) % count];
        const double c[3] = { a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0] };
        const double s = sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
        sum += atan2(s, a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) * c[1] / s;
    }
    return fabs(sum) / 2;
}

/* The same by a rectangle of constant y. */
static double row_lambert_plate(double x0, double x1, double y, double z0, double z1)
{
    const double corner[4][3] = { { x0, y, z0 }, { x1, y, z0 }, { x1, y, z1 }, { x0, y, z1 } };
    return row_lambert(corner, 4);
}

/* ---- visibility ---- */

enum { MANY = 500, DIRECTIONS = 4000 };

static void t61_a_hole_lets_light_through_at_any_distance(void **state)
{
    static const double far[5] = { 0.5, 1, 2, 3, 4 };
    float from[10][3], up[10][3], v[10];
    int k;
    (void)state;
    row_clear();
    row_plate(-2, 2, 0, -2, -0.5, 0);
    row_plate(-2, 2, 0, 0.5, 2, 0);
    row_plate(-2, -0.5, 0, -0.5, 0.5, 0);
    row_plate(0.5, 2, 0, -0.5, 0.5, 0);
    row_open();
    for (k = 0; k < 10; k++) {
        from[k][0] = k < 5 ? 0.1f : 1.25f;
        from[k][1] = (float)-far[k % 5];
        from[k][2] = 0.15f;
        up[k][0] = up[k][2] = 0;
        up[k][1] = 1;
    }
    row_see(from[0], up[0], 1, 10, v);
    adapter_close();
    for (k = 1; k < 5; k++) {
        v[0] = fminf(v[0], v[k]);
        v[5] = fmaxf(v[5], v[5 + k]);
    }
    CONFORM_MIN("T61", "least visibility through a hole, half a side to 4 away", 0.5, v[0]);
    CONFORM_MAX("T61", "most visibility beside it", 0.5, v[5]);
}

static int row_lit_in_line(double point, double light)
{
    static float from[MANY][3], to[MANY][3], v[MANY];
    int k, i, lit = 0;
    row_state = 67;
    for (k = 0; k < MANY; k++) {
        double d[3];
        row_direction(d);
        for (i = 0; i < 3; i++) {
            from[k][i] = (float)(point * d[i]);
            to[k][i] = (float)(light * d[i]);
        }
    }
    row_see(from[0], to[0], 0, MANY, v);
    for (k = 0; k < MANY; k++) lit += v[k] >= 0.5f;
    return lit;
}

static void t67_an_occluder_beyond_the_light_hides_nothing(void **state)
{
    int lit[3];
    (void)state;
    row_clear();
    row_sphere(24, 1, 0);
    row_open();
    lit[0] = row_lit_in_line(6, 4);
    lit[1] = row_lit_in_line(4, 6);
    lit[2] = row_lit_in_line(5, -5);
    adapter_close();
    CONFORM("T67", "lit of 500: point, light, sphere", MANY, lit[0], 0);
    CONFORM("T67", "lit of 500: light, point, sphere", MANY, lit[1], 0);
    CONFORM("T67", "lit of 500: point, sphere, light", 0, lit[2], 0);
}

/* Segments about a sphere that keep a twentieth of its radius off its silhouette at least, and end outside of it. */
static void t67_segments_are_hidden_where_they_cross_a_sphere(void **state)
{
    static float from[MANY][3], to[MANY][3], v[MANY];
    static int crosses[MANY];
    int k, i, count = 0, through = 0, hidden = 0, lit = 0;
    (void)state;
    row_clear();
    row_sphere(24, 1, 0);
    row_open();
    row_state = 68;
    while (count < MANY) {
        double a[3], b[3], aa = 0, ab = 0, bb = 0, t, d2;
        row_direction(a);
        row_direction(b);
        for (i = 0; i < 3; i++) {
            a[i] *= 2 + (double)(count % 3);
            b[i] *= 3;
            aa += a[i] * a[i];
            ab += a[i] * (b[i] - a[i]);
            bb += (b[i] - a[i]) * (b[i] - a[i]);
        }
        t = fmin(1, fmax(0, -ab / bb));
        d2 = aa + 2 * t * ab + t * t * bb;
        if (fabs(sqrt(d2) - 1) < 0.1) continue;
        crosses[count] = d2 < 1;
        for (i = 0; i < 3; i++) {
            from[count][i] = (float)a[i];
            to[count][i] = (float)b[i];
        }
        count++;
    }
    row_see(from[0], to[0], 0, MANY, v);
    adapter_close();
    for (k = 0; k < MANY; k++) {
        through += crosses[k];
        hidden += crosses[k] && v[k] < 0.5f;
        lit += !crosses[k] && v[k] >= 0.5f;
    }
    assert_true(through > MANY / 10 && through < MANY / 2);
    CONFORM("T67", "share hidden of segments that cross a sphere", 1, (double)hidden / through, 0);
    CONFORM("T67", "share lit of those that pass it", 1, (double)lit / (MANY - through), 0);
}

/* Asks about points and directions around two boxes; turned: by a quarter of a turn about y, four times as large. */
static void row_ask_boxes(int turned, float *v)
{
    static const double lo[2][3] = { { -1, -0.2, -0.5 }, { 0.3, 0.4, 0 } },
                        hi[2][3] = { { 1, 0.2, 0.5 }, { 0.9, 1.1, 0.4 } };
    static float from[DIRECTIONS][3], to[DIRECTIONS][3];
    size_t k;
    int i;
    row_clear();
    for (i = 0; i < 2; i++) row_box(lo[i], hi[i], 0);
    for (k = 0; turned && k < row_scene.vertex_count; k++) {
        float *p = row_positions + 3 * k, x = p[0];
        p[0] = 4 * p[2];
        p[1] *= 4;
        p[2] = -4 * x;
    }
    row_open();
    row_state = 66;
    for (k = 0; k < DIRECTIONS; k++) {
        double a[3], d[3];
        row_direction(a);
        row_direction(d);
        for (i = 0; i < 3; i++) {
            const int c = turned ? 2 - i : i;
            const double sign = turned && i == 2 ? -1 : 1;
            from[k][i] = (float)(sign * (turned ? 4 : 1) * 1.6 * a[c]);
            to[k][i] = (float)(sign * d[c]);
        }
    }
    row_see(from[0], to[0], 1, DIRECTIONS, v);
    adapter_close();
}

static void t66_scene_and_light_turned_together_change_nothing(void **state)
{
    static float before[DIRECTIONS], after[DIRECTIONS];
    int k, dark = 0, changed = 0;
    (void)state;
    row_ask_boxes(0, before);
    row_ask_boxes(1, after);
    for (k = 0; k < DIRECTIONS; k++) {
        dark += before[k] < 0.5f;
        changed += (before[k] < 0.5f) != (after[k] < 0.5f);
    }
    assert_true(dark > DIRECTIONS / 50);
    /* what lies on a silhouette is decided by rounding */
    CONFORM_MAX("T66", "share of answers that a quarter turn and a scale of 4 change", 0.002,
                (double)changed / DIRECTIONS);
}

/* Share of the directions about a point in which nothing lies. */
static double row_share(double x, double y, double z)
{
    static float from[DIRECTIONS][3], d[DIRECTIONS][3], v[DIRECTIONS];
    double sum = 0;
    int k;
    for (k = 0; k < DIRECTIONS; k++) {
        from[k][0] = (float)x;
        from[k][1] = (float)y;
        from[k][2] = (float)z;
        row_spiral(k, DIRECTIONS, d[k]);
    }
    row_see(from[0], d[0], 1, DIRECTIONS, v);
    for (k = 0; k < DIRECTIONS; k++) sum += (double)v[k];
    return sum / DIRECTIONS;
}

static void t72_a_sphere_hides_its_solid_angle(void **state)
{
    enum { POINTS = 8 };
    static const double distance[3] = { 1.25, 2, 4 };
    static const char *const words[3] = { "percent hidden 1.25 r away", "percent hidden 2 r away",
                                          "percent hidden 4 r away" };
    double share[3];
    int k, i;
    (void)state;
    row_clear();
    row_sphere(48, 1, 0);
    row_open();
    row_state = 72;
    for (k = 0; k < 3; k++)
        for (share[k] = 0, i = 0; i < POINTS; i++) {    /* directions more or less on the rim average out */
            double p[3];
            row_direction(p);
            share[k] += row_share(distance[k] * p[0], distance[k] * p[1], distance[k] * p[2]) / POINTS;
        }
    adapter_close();
    for (k = 0; k < 3; k++) {
        const double exact = 50 * (1 - sqrt(1 - 1 / (distance[k] * distance[k])));
        CONFORM("T72", words[k], exact, 100 * (1 - share[k]), 0.03 * exact);      /* maps and meshes */
    }
}

static void a_plate_hides_its_solid_angle_and_a_box_all(void **state)
{
    static const double lo[3] = { -1, -1, -1 }, hi[3] = { 1, 1, 1 };
    double plate, most = 0;
    int k;
    (void)state;
    row_clear();
    row_plate(-1, 1, 0, -1, 1, 0);
    row_open();
    plate = row_share(0, 0.5, 0);
    adapter_close();
    row_clear();
    row_box(lo, hi, 0);
    row_open();
    row_state = 3;
    for (k = 0; k < 4; k++) most = fmax(most, row_share(row_random() - 0.5, row_random() - 0.5, row_random() - 0.5));
    adapter_close();
    /* 4 asin(1 / (1 + h^2)) of 4 pi, for the half angle of a square of side 2 seen from h = 0.5 above its middle */
    CONFORM("furnace", "share of directions free 0.5 above a plate of side 2", 1 - asin(1 / 1.25) / ROW_PI,
            plate, 0.01);
    CONFORM("furnace", "share of directions free in a sealed box, the most of 4 points", 0, most, 0);
}

/* ---- direct light ---- */

static void t10_t11_t18_skies_count_by_solid_angle(void **state)
{
    enum { W = 72, H = 36 };
    static float texels[3 * W * H];
    static const float p[3] = { 0, 0, 0 }, up[3] = { 0, 1, 0 };
    adapter_light even = row_lamp(ADAPTER_SKY, 1), map = even;
    double all, cap;
    float rgb[3] = { -1, -1, -1 };
    int k;
    (void)state;
    row_clear();
    row_open();
    all = row_light(&even, 0, 0, 0, 0, 0, 1, 0);
    map.texels = texels;
    map.width = W;
    map.height = H;
    memset(texels, 0, sizeof texels);
    for (k = 0; k < W * H / 6; k++) texels[3 * k] = 1;             /* 30 degrees about +Y, red alone */
    cap = row_light(&map, 0, 0, 0, 0, 0, 1, 0);
    assert_int_equal(adapter_direct(&map, p, up, 1, rgb), 1);
    adapter_close();
    CONFORM("T10", "irradiance under an even sky", ROW_PI, all, 0.01 * ROW_PI);
    CONFORM("T11", "irradiance under a cap of 30 degrees", ROW_PI / 4, cap, 0.01 * ROW_PI / 4);
    CONFORM("T18", "green of a red cap", 0, rgb[1], 0);
}

static void t20_t21_one_texel_lights_from_its_place(void **state)
{
    enum { W = 72, H = 36, ROW = 9 };
    static float texels[3 * W * H];
    adapter_light map = row_lamp(ADAPTER_SKY, 1);
    double s0 = sin(ROW_PI * ROW / H), s1 = sin(ROW_PI * (ROW + 1) / H),
           exact = (s1 * s1 - s0 * s0) / 2 * 2 * ROW_PI / W;
    const double t1 = ROW_PI * 19 / H, about_x = (ROW_PI / H / 2 - sin(2 * t1) / 4) * 2 * sin(ROW_PI / H);
    double measured, seam, middle;
    (void)state;
    row_clear();
    row_open();
    map.texels = texels;
    map.width = W;
    map.height = H;
    memset(texels, 0, sizeof texels);
    texels[3 * (ROW * W + 5)] = 1;
    measured = row_light(&map, 0, 0, 0, 0, 0, 1, 0);
    memset(texels, 0, sizeof texels);
    texels[3 * (18 * W)] = texels[3 * (18 * W + W - 1)] = 1;        /* both sides of the seam, about -X */
    seam = row_light(&map, 0, 0, 0, 0, -1, 0, 0);
    memset(texels, 0, sizeof texels);
    texels[3 * (18 * W + W / 2 - 1)] = texels[3 * (18 * W + W / 2)] = 1;
    middle = row_light(&map, 0, 0, 0, 0, 1, 0, 0);
    adapter_close();
    CONFORM("T20", "irradiance of one texel over its closed form", 1, measured / exact, 0.01);
    CONFORM("T21", "texels beside the seam over those of the middle", 1, seam / middle, 0.01);
    CONFORM("T21", "those of the middle over their closed form", 1, middle / about_x, 0.01);
}

static void t23_plates_take_their_share_of_a_sky(void **state)
{
    static const double lo[3] = { -1, -1, -1 }, hi[3] = { 1, 1, 1 };
    static const double wall[4][3] = { { -0.5, 0.01, -2 }, { -0.5, 2, -2 }, { -0.5, 2, 2 }, { -0.5, 0.01, 2 } };
    static const double corner[3] = { -0.5, 0.01, -2 }, u[3] = { 0, 1.99, 0 }, v[3] = { 0, 0, 4 };
    const adapter_light sky = row_lamp(ADAPTER_SKY, 1);
    double plate, foot, box;
    (void)state;
    row_clear();
    row_plate(-1, 1, 1, -1, 1, 0);
    row_open();
    plate = row_light(&sky, 0, 0, 0, 0, 0, 1, 0);
    adapter_close();
    row_clear();
    row_quad(corner, u, v, 0);
    row_open();
    foot = row_light(&sky, 0, 0, 0, 0, 0, 1, 0);
    adapter_close();
    row_clear();
    row_box(lo, hi, 0);
    row_open();
    box = row_light(&sky, 0, 0.2, -0.3, 0.1, 0, 1, 0);
    adapter_close();
    CONFORM("T23", "irradiance under a plate of side 2, 1 above", ROW_PI - row_lambert_plate(-1, 1, 1, -1, 1),
            plate, 0.06);
    CONFORM("T23", "irradiance beside a wall of 4 x 2, half a unit off", ROW_PI - row_lambert(wall, 4), foot, 0.06);
    CONFORM("T23", "irradiance in a sealed box", 0, box, 0);
}

/* A square of side 1 over the origin that shines down, its corner above x, z. */
static adapter_light row_square(double x, double y, double z, double side)
{
    adapter_light l = row_lamp(ADAPTER_RECTANGLE, 1);
    l.position[0] = (float)x;
    l.position[1] = (float)y;
    l.position[2] = (float)z;
    l.u[0] = (float)side;
    l.v[2] = (float)side;
    return l;
}

static void t43_t73_lamps_have_the_irradiance_of_closed_forms(void **state)
{
    adapter_light square = row_square(-0.5, 1, -0.5, 1), large = row_square(-1, 2, -1, 2),
                  corner = row_square(0, 1, 0, 1);
    adapter_light disc = row_lamp(ADAPTER_DISC, 1), ball = row_lamp(ADAPTER_SPHERE, 1), bright = square;
    double e[8];
    (void)state;
    disc.position[1] = ball.position[1] = 2;
    disc.direction[1] = -1;
    disc.radius = 0.5f;
    ball.radius = 1;
    bright.value[0] = 1000;
    row_clear();
    row_open();
    e[0] = row_light(&square, 0, 0, 0, 0, 0, 1, 0);
    e[1] = row_light(&corner, 0, 0, 0, 0, 0, 1, 0);
    e[2] = row_light(&square, 0, 0, 2, 0, 0, -1, 0);
    e[3] = row_light(&disc, 0, 0, 0, 0, 0, 1, 0);
    e[4] = row_light(&ball, 0, 0, 0, 0, 0, 1, 0);
    e[5] = row_light(&ball, 0, 0, 0, 0, 0.6, 0.8, 0);
    e[6] = row_light(&large, 0, 0, 0, 0, 0, 1, 0);
    e[7] = row_light(&bright, 0, 0, 0, 0, 0, 1, 0);
    adapter_close();
    CONFORM("T43", "unit square 1 above its middle", row_lambert_plate(-0.5, 0.5, 1, -0.5, 0.5), e[0], 0.008);
    CONFORM("T43", "unit square 1 above a corner", row_lambert_plate(0, 1, 1, 0, 1), e[1], 0.005);
    CONFORM("T43", "behind the square", 0, e[2], 0);
    CONFORM("irradiance", "disc of radius 0.5, 2 above", ROW_PI / 17, e[3], 0.002);
    CONFORM("T73", "facing a sphere 2 r away", ROW_PI / 4, e[4], 0.008);
    CONFORM("T73", "tilted against it, cosine 0.8", ROW_PI / 5, e[5], 0.007);
    CONFORM("T28", "square and height twice as large, over the first", 1, e[6] / e[0], 0.01);
    CONFORM("T32", "light 1000 times as bright, over 1000 times the first", 1, e[7] / (1000 * e[0]), 1e-5);
}

static void lamps_without_size_are_exact(void **state)
{
    adapter_light sun = row_sun(0.6, 0.8, 0, 2), point = row_lamp(ADAPTER_POINT, 5), spot = row_lamp(ADAPTER_SPOT, 5);
    double e[5];
    (void)state;
    point.position[0] = 3;
    point.position[1] = 4;
    spot.position[0] = 3;
    spot.position[1] = 4;
    spot.direction[0] = -0.6f;
    spot.direction[1] = -0.8f;
    spot.cone_half_angle = 0.3f;
    row_clear();
    row_open();
    e[0] = row_light(&sun, 0, 0, 0, 0, 0, 1, 0);
    e[1] = row_light(&point, 0, 0, 0, 0, 0, 1, 0);
    e[2] = row_light(&spot, 0, 0, 0, 0, 0, 1, 0);
    e[3] = row_light(&spot, 0, 6, 0, 0, 0, 1, 0);
    e[4] = row_light(&point, 0, 3, 2, 0, 0, 1, 0);
    adapter_close();
    CONFORM("irradiance", "sun of E 2, cosine 0.8", 1.6, e[0], 1e-5);
    CONFORM("irradiance", "point light of I 5, 5 away, cosine 0.8", 0.16, e[1], 1e-5);
    CONFORM("irradiance", "spot of I 5, 5 away, cosine 0.8", 0.16, e[2], 1e-5);
    CONFORM("irradiance", "spot, outside of its cone", 0, e[3], 0);
    CONFORM("T29", "point light of I 5, 2 above", 1.25, e[4], 1e-5);
}

/* A plate over x > 0, between the origin and lamps above. */
static void t50_half_a_lamp_is_left_by_a_half_plane(void **state)
{
    static const char *const words[3] = { "share of a square left by a half-plane",
                                          "share of a disc left by a half-plane",
                                          "share of a sphere left by a half-plane" };
    adapter_light lamps[3] = { row_square(-0.5, 2, -0.5, 1), row_lamp(ADAPTER_DISC, 1), row_lamp(ADAPTER_SPHERE, 1) };
    double e[3], hidden[3];
    int k;
    (void)state;
    lamps[1].direction[1] = -1;
    for (k = 1; k < 3; k++) {
        lamps[k].position[1] = 2;
        lamps[k].radius = 0.5f;
    }
    row_clear();
    row_open();
    for (k = 0; k < 3; k++) e[k] = row_light(&lamps[k], 0, 0, 0, 0, 0, 1, 0);
    adapter_close();
    row_plate(0, 1, 1, -1, 1, 0);
    row_open();
    for (k = 0; k < 3; k++) hidden[k] = row_light(&lamps[k], 0, 0, 0, 0, 0, 1, 0);
    adapter_close();
    for (k = 0; k < 3; k++) CONFORM("T50", words[k], 0.5, hidden[k] / e[k], 0.03);     /* an edge a fiftieth off */
}

/* ---- light that is thrown back once ---- */

static void t25_a_disc_throws_back_half_of_what_it_reflects(void **state)
{
    static const char *const words[3] = { "over a disc / (rho E0), its radius above",
                                          "half of the disc is black / (rho E0)",
                                          "disc and height twice as large / (rho E0)" };
    const adapter_light sun = row_sun(0, 1, 0, 2), bright = row_sun(0, 1, 0, 2000);
    double e[4], in_it = -1;
    int k;
    (void)state;
    for (k = 0; k < 3; k++) {
        const double size = k == 2 ? 2 : 1;
        row_clear();
        row_disc(size, 0.5, k == 1 ? 0 : 0.5);
        row_open();
        e[k] = row_light(&sun, 1, 0, size, 0, 0, -1, 0);
        if (k == 0) {
            e[3] = row_light(&bright, 1, 0, 1, 0, 0, -1, 0);
            in_it = row_light(&sun, 1, 0.2, 0, 0.1, 0, 1, 0);
        }
        adapter_close();
    }
    CONFORM("T25", words[0], 0.5, e[0], 0.01);
    CONFORM("T36", words[1], 0.25, e[1], 0.01);
    CONFORM("T28", words[2], 0.5, e[2], 0.01);
    CONFORM("T32", "bounced light of a sun 1000 times as bright, over 1000 times the first", 1,
            e[3] / (1000 * e[0]), 1e-4);
    CONFORM("T40", "light of the disc on itself", 0, in_it, 1e-6);
}

/* A lit square of 0.4 that lies flat, or is tilted against the sun. */
static double row_patch(double tilt, double height)
{
    const adapter_light sun = row_sun(0, 1, 0, 1);
    const double c = cos(tilt), s = sin(tilt), corner[3] = { -0.2 * c, -0.2 * s, -0.2 }, u[3] = { 0.4 * c, 0.4 * s, 0 },
                 v[3] = { 0, 0, 0.4 };
    double e, seen[4][3] = { { 0 } };
    int k;
    for (k = 0; k < 4; k++) {               /* as from a receiver that looks down on it, upside down */
        const double a = k == 1 || k == 2, b = k >= 2;
        seen[k][0] = corner[0] + a * u[0];
        seen[k][1] = height - (corner[1] + a * u[1]);
        seen[k][2] = corner[2] + b * v[2];
    }
    row_clear();
    row_quad(corner, u, v, 0.8);
    row_open();
    e = row_light(&sun, 1, 0, height, 0, 0, -1, 0);
    adapter_close();
    return e / (0.8 * c / ROW_PI * row_lambert((const double (*)[3])seen, 4));
}

static void t29_t31_a_patch_throws_back_its_form_factor(void **state)
{
    double near_by, far, tilted;
    (void)state;
    near_by = row_patch(0, 0.5);
    far = row_patch(0, 3);
    tilted = row_patch(ROW_PI / 3, 1);
    CONFORM("T29", "bounced light half a unit above a lit square of 0.4, over its form factor", 1, near_by, 0.02);
    CONFORM("T29", "the same 3 units above", 1, far, 0.02);
    CONFORM("T31", "of the square tilted by 60 degrees, over its form factor and cosine", 1, tilted, 0.02);
}

/* A lit square, and a black plate half-way that its sun, which stands low, passes. */
static void t50_a_plate_hides_what_a_square_throws_back(void **state)
{
    const adapter_light sun = row_sun(-3, 1, 0, 1);
    double e[3];
    int k;
    (void)state;
    for (k = 0; k < 3; k++) {
        row_clear();
        row_plate(-0.25, 0.25, 0, -0.25, 0.25, 0.8);
        if (k == 1) row_plate(-0.6, 0.6, 0.5, -0.6, 0.6, 0);
        if (k == 2) row_plate(0, 0.6, 0.5, -0.6, 0.6, 0);
        row_open();
        e[k] = row_light(&sun, 1, 0, 1, 0, 0, -1, 0);
        adapter_close();
    }
    assert_true(e[0] > 0);
    CONFORM("T50", "bounced light behind a plate, over that without", 0, e[1] / e[0], 1e-4);
    CONFORM("T50", "behind half a plate", 0.5, e[2] / e[0], 0.03);
}

static void a_box_with_thick_walls_stays_dark(void **state)
{
    static const double outer[2][3] = { { -1, -1, -1 }, { 1, 1, 1 } },
                        inner[2][3] = { { -0.75, -0.75, -0.75 }, { 0.75, 0.75, 0.75 } };
    const adapter_light sun = row_sun(0.5, 0.7, 0.3, 1);
    double direct, bounced;
    (void)state;
    row_clear();
    row_box(outer[0], outer[1], 0.8);
    row_box(inner[0], inner[1], 0.8);
    row_open();
    direct = row_light(&sun, 0, 0.1, 0, -0.1, 0, 1, 0);
    bounced = row_light(&sun, 1, 0.1, 0, -0.1, 0, 1, 0);
    adapter_close();
    CONFORM("irradiance", "sealed box, sun outside: direct light inside", 0, direct, 0);
    CONFORM("irradiance", "sealed box, sun outside: bounced light inside", 0, bounced, 0);
}

/* An integrating sphere: every wall throws back the same, so that every point within gets the same from everywhere. */
static void t45_one_bounce_fills_a_sphere_evenly(void **state)
{
    adapter_light point = row_lamp(ADAPTER_POINT, 4);
    double e[3];
    (void)state;
    row_clear();
    row_sphere(40, 2, 0.5);
    row_open();
    e[0] = row_light(&point, 1, 0, 0, 0, 0, 1, 0);
    e[1] = row_light(&point, 1, 1, 0.2, -0.3, -1, 0, 0);
    e[2] = row_light(&point, 1, -0.4, -1.1, 0.5, 0, -1, 0);
    adapter_close();
    CONFORM("T45", "one bounce in a sphere lit from its middle / (rho E0), there", 1, e[0] / 0.5, 0.03);
    CONFORM("T45", "half way to its wall, seen from there", 1, e[1] / 0.5, 0.03);
    CONFORM("T45", "and towards the wall", 1, e[2] / 0.5, 0.03);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(t61_a_hole_lets_light_through_at_any_distance),
        cmocka_unit_test(t67_an_occluder_beyond_the_light_hides_nothing),
        cmocka_unit_test(t67_segments_are_hidden_where_they_cross_a_sphere),
        cmocka_unit_test(t66_scene_and_light_turned_together_change_nothing),
        cmocka_unit_test(t72_a_sphere_hides_its_solid_angle),
        cmocka_unit_test(a_plate_hides_its_solid_angle_and_a_box_all),
        cmocka_unit_test(t10_t11_t18_skies_count_by_solid_angle),
        cmocka_unit_test(t20_t21_one_texel_lights_from_its_place),
        cmocka_unit_test(t23_plates_take_their_share_of_a_sky),
        cmocka_unit_test(t43_t73_lamps_have_the_irradiance_of_closed_forms),
        cmocka_unit_test(lamps_without_size_are_exact),
        cmocka_unit_test(t50_half_a_lamp_is_left_by_a_half_plane),
        cmocka_unit_test(t25_a_disc_throws_back_half_of_what_it_reflects),
        cmocka_unit_test(t29_t31_a_patch_throws_back_its_form_factor),
        cmocka_unit_test(t50_a_plate_hides_what_a_square_throws_back),
        cmocka_unit_test(a_box_with_thick_walls_stays_dark),
        cmocka_unit_test(t45_one_bounce_fills_a_sphere_evenly),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
