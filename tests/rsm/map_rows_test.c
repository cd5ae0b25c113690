/* map_rows_test - maps of rsm.h from a renderer's buffers: colours and positions (T33, T34 of docs/conformance.md). */

#include "rsm.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>
#include "conformance.h"
#include "util.h"

static void t33_albedo_is_linear(void **state)
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

/* Positions rebuilt from a renderer's depth, all clip conventions, and back to their texel: row 0 of the buffer is at
   clip y = -1 (OpenGL, Vulkan) or +1 (Direct3D, Metal), whatever the matrix makes of the world. */
static void t34_texel_centres_map_back_to_their_texel(void **state)
{
    enum { N = 64 };
    static float depth[N * N], normal[3 * N * N];
    static const rsm_light_kind kinds[] = { RSM_LIGHT_SUN, RSM_LIGHT_SPOT, RSM_LIGHT_POINT };
    const double n[3] = { 0.36, 0.48, 0.8 }, offset = 0.1;
    double worst = 0, inv[16];
    uint32_t wrong = 0, seen = 0, k, i, j;
    int clip, zero_to_one;
    (void)state;
    for (k = 0; k < 12; k++) {
        rsm_desc d = sun_desc(1, 2, N);
        rsm_map *map;
        rsm_buffers b;
        float m[16];
        uint32_t c = k / 4 == 2 ? 4 : 0;         /* of the cube, the face that looks down */
        clip = (int)(k % 4);
        zero_to_one = clip > 0;
        d.light.kind = kinds[k / 4];
        set3(d.light.position, 0.3, 3, 0.2);
        d.light.cone_half_angle = 0.6f;
        d.light.near_depth = 0.5f;
        d.light.far_depth = 20;
        set3(d.light.direction, 0, k / 4 == 0 ? 1 : -1, 0);
        d.clip_depth = zero_to_one ? RSM_CLIP_DEPTH_ZERO_TO_ONE : RSM_CLIP_DEPTH_MINUS_ONE_TO_ONE;
        d.clip_y = clip & 1 ? RSM_CLIP_Y_DOWN : RSM_CLIP_Y_UP;
        d.rows = clip & 2 ? RSM_ROWS_TOP_FIRST : RSM_ROWS_BOTTOM_FIRST;
        assert_int_equal(rsm_map_create(&d, &map), RSM_OK);
        assert_int_equal(rsm_map_matrix(map, c, m), RSM_OK);
        invert(m, inv);
        memset(&b, 0, sizeof b);
        for (j = 0; j < N; j++)
            for (i = 0; i < N; i++) {
                const double y = (j + 0.5) * 2 / N - 1;
                depth[j * N + i] =
                    (float)plane_depth(inv, n, offset, (i + 0.5) * 2 / N - 1, clip & 2 ? -y : y, zero_to_one);
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

/* Maps are drawn in bands of rows: a floor fills each of them, whatever is left for the last one. */
static void every_row_is_drawn(void **state)
{
    static const uint32_t size[] = { 4, 5, 15, 16, 17, 33, 47 };
    static const float corners[18] = { -9, 0, -9, -9, 0, 9, 9, 0, 9, -9, 0, -9, 9, 0, 9, 9, 0, -9 };
    rsm_mesh floor;
    size_t i;
    (void)state;
    memset(&floor, 0, sizeof floor);
    floor.positions = corners;
    floor.vertex_count = 6;
    set3(floor.albedo, 0.5, 0.5, 0.5);
    for (i = 0; i < sizeof size / sizeof size[0]; i++) {
        rsm_desc d = sun_desc(1, 1, size[i]);
        rsm_stats stats;
        rsm_map *map = map_of(&d, &floor, 1, &stats);
        assert_non_null(map);
        assert_int_equal(stats.lit_texels, size[i] * size[i]);
        assert_true(fabs(stats.reflected[0] / 4 - 0.5) < 1e-5);
        rsm_map_free(map);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(t33_albedo_is_linear), cmocka_unit_test(t34_texel_centres_map_back_to_their_texel),
        cmocka_unit_test(every_row_is_drawn)
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
