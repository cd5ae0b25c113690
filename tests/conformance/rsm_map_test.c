/* rsm_map_test - maps of rsm.h: flux a texel, positions, colours, formats (rows T30 to T35, T37 of
 * docs/conformance.md). */

#include "rsm.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>
#include "conformance.h"
#include "unit/rsm_util.h"

/* Flux through all texels of a lamp in a closed box of albedo 1. */
static double incident_of(rsm_light_kind kind, double angle, uint32_t size)
{
    static const float box[] = { -2, -2, -2, 4, 0, 0, 0, 4, 0, -2, -2, 2,  4, 0, 0, 0, 4, 0,
                                 -2, -2, -2, 0, 4, 0, 0, 0, 4, 2,  -2, -2, 0, 4, 0, 0, 0, 4,
                                 -2, -2, -2, 4, 0, 0, 0, 0, 4, -2, 2,  -2, 4, 0, 0, 0, 0, 4 };
    model m = model_quads(box, 6);
    rsm_mesh mesh = mesh_of(&m, 1);
    rsm_desc d;
    rsm_stats stats;
    rsm_map *map;
    memset(&d, 0, sizeof d);
    d.light.kind = kind;
    set3(d.light.position, 0.1, -0.2, 0.3);
    set3(d.light.direction, 0.48, -0.8, 0.36);
    set3(d.light.value, 1, 1, 1);
    d.light.cone_angle = (float)(angle * PI / 180);
    d.size = size;
    map = map_of(&d, &mesh, 1, &stats);
    assert_non_null(map);
    assert_int_equal(stats.bad_texels, 0);
    rsm_map_free(map);
    model_free(&m);
    return fabs(stats.incident[0] - stats.reflected[0]) > 1e-5 * stats.incident[0] ? -1 : stats.incident[0];
}

static void flux_of_lamps(void **state)
{
    (void)state;
    /* Gauss points and float texels: 1e-6 each, of one sign at worst */
    CONFORM("T30", "flux of a square spot of 90 degrees, 256 x 256", 2.094395,
            incident_of(RSM_LIGHT_SQUARE_SPOT, 90, 256), 2e-5);
    CONFORM("T30", "the same, 4 x 4", 2.094395, incident_of(RSM_LIGHT_SQUARE_SPOT, 90, 4), 2e-5);
    /* 64 points a texel on the rim: 1/16 of a rim texel, of 256 pi of them at random */
    CONFORM("T30", "flux of a cone of half angle 30 degrees", 0.841787, incident_of(RSM_LIGHT_SPOT, 60, 256), 2e-4);
    CONFORM("T30", "flux of a cone of half angle 100 degrees: a cube", 2 * PI * (1 - cos(100 * PI / 180)),
            incident_of(RSM_LIGHT_SPOT, 200, 128), 1e-3);
    CONFORM("T30", "flux of a point light of intensity 1", 4 * PI, incident_of(RSM_LIGHT_POINT, 0, 64), 1e-4);
    /* the cosine has a kink in texels that its plane cuts */
    CONFORM("T30", "flux of a patch of intensity 1 along its normal", PI, incident_of(RSM_LIGHT_PATCH, 0, 64), 1e-3);
}

static void no_cosine_in_flux(void **state)
{
    model m = model_disc(512, 1);
    const double tilt = PI / 3;
    float t[16] = { 0 };
    rsm_desc d = sun_desc(3, 1.2, 512);
    rsm_mesh mesh = mesh_of(&m, 0.4);
    rsm_stats stats;
    rsm_map *map;
    (void)state;
    t[0] = t[15] = 1;                            /* turned by 60 degrees about x */
    t[5] = t[10] = (float)cos(tilt);
    t[6] = (float)sin(tilt);
    t[9] = -(float)sin(tilt);
    mesh.transform = t;
    map = map_of(&d, &mesh, 1, &stats);
    assert_non_null(map);
    /* area of an ellipse in texels: about 1 texel in 1000 at the rim is decided by its centre */
    CONFORM("T31", "flux from a disc tilted by 60 degrees / (rho E0 projected area)", 1,
            stats.reflected[0] / (0.4 * 3 * PI * cos(tilt)), 1e-3);
    rsm_map_free(map);
    model_free(&m);
}

static void no_clamp(void **state)
{
    model m = model_disc(64, 1);
    rsm_mesh mesh = mesh_of(&m, 0.5);
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 0);
    double e[2];
    int i;
    (void)state;
    for (i = 0; i < 2; i++) {
        rsm_desc d = sun_desc(i ? 1000 : 1, 1.2, 64);
        rsm_map *map = map_of(&d, &mesh, 1, NULL);
        assert_non_null(map);
        e[i] = gather_at(map, &g, 0, 1, 0, 0, -1, 0);
        rsm_map_free(map);
    }
    model_free(&m);
    CONFORM("T32", "result for 1000 times the light / 1000", 1, e[1] / e[0] / 1000, 1e-5);    /* rounding of sums */
}

static void linear_albedo(void **state)
{
    static float normal[3 * 256], albedo[3 * 256], depth[256];
    static uint8_t srgb[4 * 256];
    rsm_desc d = sun_desc(1, 1, 16);
    rsm_buffers b;
    rsm_map *map;
    rsm_stats stats;
    int i, k;
    (void)state;
    for (i = 0; i < 256; i++) {
        set3(normal + 3 * i, 0, 1, 0);
        set3(albedo + 3 * i, 0.5, 0.5, 0.5);
        depth[i] = 0.5f;
        srgb[4 * i] = srgb[4 * i + 1] = srgb[4 * i + 2] = 188;
    }
    for (k = 0; k < 2; k++) {
        memset(&b, 0, sizeof b);
        b.normals = normal;
        b.depth = depth;
        if (k) b.albedo_srgb = srgb;
        else b.albedo = albedo;
        assert_int_equal(rsm_map_create(&d, &map), RSM_OK);
        assert_int_equal(rsm_fill(map, 0, &b), RSM_OK);
        assert_int_equal(rsm_finish(map, &stats), RSM_OK);
        if (k == 0)
            CONFORM("T33", "flux of linear albedo 0.5 / flux through the map", 0.5, stats.reflected[0] / 4, 1e-6);
        /* 188 is the 8-bit code nearest to 0.5: 0.50289 */
        else CONFORM("T33", "the same from 8-bit sRGB 188", 0.502886, stats.reflected[0] / 4, 1e-5);
        rsm_map_free(map);
    }
}

/* m^-1 by Gauss-Jordan, in double. */
static void invert(const float m[16], double inv[16])
{
    double a[4][8];
    int r, s, q;
    for (r = 0; r < 4; r++)
        for (s = 0; s < 8; s++) a[r][s] = s < 4 ? (double)m[4 * s + r] : (double)(s - 4 == r);
    for (r = 0; r < 4; r++) {
        int pivot = r;
        double p;
        for (s = r; s < 4; s++)
            if (fabs(a[s][r]) > fabs(a[pivot][r])) pivot = s;
        for (s = 0; s < 8; s++) {
            p = a[r][s];
            a[r][s] = a[pivot][s];
            a[pivot][s] = p;
        }
        for (p = a[r][r], s = 0; s < 8; s++) a[r][s] /= p;
        for (q = 0; q < 4; q++)
            for (p = a[q][r], s = 0; s < 8 && q != r; s++) a[q][s] -= p * a[r][s];
    }
    for (r = 0; r < 16; r++) inv[r] = a[r % 4][4 + r / 4];
}

/* What a depth buffer holds where clip (x, y) shows the plane n.p = offset: by the matrix alone. */
static double plane_depth(const double inv[16], const double n[3], double offset, double x, double y, int zero_to_one)
{
    double lo = 0, hi = 1;
    int q, r;
    for (q = 0; q < 60; q++) {
        double p[4], t = 0.5 * (lo + hi);
        for (r = 0; r < 4; r++)
            p[r] = inv[r] * x + inv[4 + r] * y + inv[8 + r] * (zero_to_one ? t : 2 * t - 1) + inv[12 + r];
        if ((n[0] * p[0] + n[1] * p[1] + n[2] * p[2]) / p[3] > offset) lo = t;
        else hi = t;
    }
    return lo;
}

/* Positions rebuilt from a renderer's depth, all clip conventions, and back to their texel. */
static void texel_centres(void **state)
{
    enum { N = 64 };
    static float depth[N * N], normal[3 * N * N];
    static const rsm_light_kind kinds[] = { RSM_LIGHT_SUN, RSM_LIGHT_SPOT, RSM_LIGHT_POINT };
    const double n[3] = { 0.36, 0.48, 0.8 }, offset = 0.1;
    double worst = 0, inv[16];
    uint32_t wrong = 0, seen = 0, k, i, j;
    int clip;
    (void)state;
    for (k = 0; k < 6; k++) {
        rsm_desc d = sun_desc(1, 2, N);
        rsm_map *map;
        rsm_buffers b;
        float m[16];
        uint32_t c = k / 2 == 2 ? 4 : 0;         /* of the cube, the face that looks down */
        clip = (int)(k % 2);
        d.light.kind = kinds[k / 2];
        set3(d.light.position, 0.3, 3, 0.2);
        d.light.cone_angle = 1.2f;
        d.light.near_depth = 0.5f;
        d.light.far_depth = 20;
        set3(d.light.direction, 0, k / 2 == 0 ? 1 : -1, 0);
        d.clip_zero_to_one = d.y_down = clip;
        assert_int_equal(rsm_map_create(&d, &map), RSM_OK);
        assert_int_equal(rsm_map_matrix(map, c, m), RSM_OK);
        invert(m, inv);
        memset(&b, 0, sizeof b);
        for (j = 0; j < N; j++) /* row 0 of the buffer is the top where clip y points down: clip y = -1 */
            for (i = 0; i < N; i++) {
                depth[j * N + i] =
                    (float)plane_depth(inv, n, offset, (i + 0.5) * 2 / N - 1, (j + 0.5) * 2 / N - 1, clip);
                set3(normal + 3 * (j * N + i), n[0], n[1], n[2]);
            }
        b.depth = depth;
        b.normals = normal;
        assert_int_equal(rsm_fill(map, c, &b), RSM_OK);
        assert_int_equal(rsm_finish(map, NULL), RSM_OK);
        for (j = 0; j < N; j++)
            for (i = 0; i < N; i++) {
                const rsm_texel *t = rsm_map_texels(map) + ((size_t)c * N + j) * N + i;
                float uv[2], z;
                uint32_t face;
                double off;
                if (t->depth < 0.51f || t->depth > 5) continue; /* before the near plane; too far for its floats */
                off = fabs(n[0] * (double)t->position[0] + n[1] * (double)t->position[1] +
                           n[2] * (double)t->position[2] - offset);
                worst = off > worst ? off : worst;
                assert_int_equal(rsm_map_project(map, t->position, &face, uv, &z), RSM_OK);
                wrong += face != c || (uint32_t)(uv[0] * (float)N) != i || (uint32_t)(uv[1] * (float)N) != j;
                seen++;
            }
        rsm_map_free(map);
    }
    assert_true(seen > 2 * N * N);
    /* a float of a depth buffer that holds 0.5..20: 6e-8 of 1, times 60 at depth 5, and as much again in
       our arithmetic */
    CONFORM_MAX("T34", "largest distance from the plane of positions made from depth", 1e-5, worst);
    CONFORM_MAX("T34", "texel centres that map back to another texel", 0, wrong);
}

static void no_floating_texels(void **state)
{
    static const float planes[] = { -1, 0, -1, 1, 0, 0, 0, 0, 2,  0, 1, -1, 1, 0, 0, 0, 0, 2 };
    static rsm_texel lights[1000];
    model m = model_quads(planes, 2);
    rsm_mesh mesh = mesh_of(&m, 0.5);
    rsm_desc d = sun_desc(1, 1.3, 128);
    rsm_map *map = map_of(&d, &mesh, 1, NULL);
    size_t count, i;
    double worst = 0;
    (void)state;
    assert_non_null(map);
    assert_int_equal(rsm_pixel_lights((const rsm_map *const *)&map, 1, 1000, 3, lights, 1000, &count), RSM_OK);
    assert_int_equal(count, 1000);
    for (i = 0; i < count; i++) {
        double y = (double)lights[i].position[1], off = y < 0.5 ? fabs(y) : fabs(y - 1);
        worst = off > worst ? off : worst;
    }
    CONFORM_MAX("T35", "largest distance of 1000 samples from both of two planes", 1e-4, worst);
    rsm_map_free(map);
    model_free(&m);
}

/* m v of a quarter turn about an axis. */
static void turn_vector(int axis, int turns, const double v[3], double out[3])
{
    const double c = turns == 0 ? 1 : turns == 2 ? -1 : 0, s = turns == 1 ? 1 : turns == 3 ? -1 : 0;
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    out[axis] = v[axis];
    out[a] = c * v[a] - s * v[b];
    out[b] = s * v[a] + c * v[b];
}

/* A room with a lamp and a receiver, turned about each axis. */
static void cubes_turn(void **state)
{
    static const float room[] = { -1, -1, -1, 2, 0, 0, 0, 0, 2, -1, 1,  -1, 2, 0, 0, 0, 0, 2,
                                  -1, -1, -1, 0, 2, 0, 0, 0, 2, 1,  -1, -1, 0, 2, 0, 0, 0, 2,
                                  -1, -1, -1, 2, 0, 0, 0, 2, 0, -1, -1, 1,  2, 0, 0, 0, 2, 0 };
    static const double lamp[3] = { 0.2, 0.3, -0.1 }, eye[3] = { -0.5, -0.2, 0.4 }, normal[3] = { 0.6, 0, 0.8 };
    static const rsm_pattern patterns[] = { RSM_PATTERN_FLUX, RSM_PATTERN_FLUX, RSM_PATTERN_LOG_RADIAL };
    model m = model_quads(room, 6);
    double low[3] = { 1e9, 1e9, 1e9 }, high[3] = { 0, 0, 0 };
    int i, j, k;
    (void)state;
    for (i = 0; i < 12; i++) {
        rsm_mesh mesh = mesh_of(&m, 0.5);
        rsm_desc d;
        rsm_map *map;
        float t[16] = { 0 };
        double w[3][3];
        for (j = 0; j < 3; j++) {
            double unit[3] = { 0, 0, 0 };
            unit[j] = 1;
            turn_vector(i / 4, i % 4, unit, w[0]);
            set3(t + 4 * j, w[0][0], w[0][1], w[0][2]);
        }
        t[15] = 1;
        mesh.transform = t;
        turn_vector(i / 4, i % 4, lamp, w[0]);
        turn_vector(i / 4, i % 4, eye, w[1]);
        turn_vector(i / 4, i % 4, normal, w[2]);
        memset(&d, 0, sizeof d);
        d.light.kind = RSM_LIGHT_POINT;
        set3(d.light.position, w[0][0], w[0][1], w[0][2]);
        set3(d.light.value, 1, 1, 1);
        d.size = 64;
        map = map_of(&d, &mesh, 1, NULL);
        assert_non_null(map);
        for (k = 0; k < 3; k++) {
            rsm_gather_desc g = gather_desc(patterns[k], k ? 4096 : 0);
            double e = gather_at(map, &g, w[1][0], w[1][1], w[1][2], w[2][0], w[2][1], w[2][2]);
            low[k] = e < low[k] ? e : low[k];
            high[k] = e > high[k] ? e : high[k];
        }
        rsm_map_free(map);
    }
    CONFORM("T37", "largest / smallest result over 12 quarter turns, every texel", 1, high[0] / low[0], 1e-4);
    /* other texels each time: the spread of 4096 samples */
    CONFORM("T37", "the same, 4096 samples by flux", 1, high[1] / low[1], 0.02);
    CONFORM("T37", "the same, 4096 samples log-radial", 1, high[2] / low[2], 0.05);
    model_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flux_of_lamps),     cmocka_unit_test(no_cosine_in_flux),  cmocka_unit_test(no_clamp),
        cmocka_unit_test(linear_albedo),     cmocka_unit_test(texel_centres),      cmocka_unit_test(no_floating_texels),
        cmocka_unit_test(cubes_turn),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
