/* kernels_test - ism.h's kernels give the same bits in every instruction set that this machine has, and project as
   ism_map_coordinates does. */

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#define ISM_STATIC
#define ISM_IMPLEMENTATION
#include "ism.h"

enum { SIDE = 16, TEXELS = SIDE * SIDE, CLUSTERS = 43 };

static float uniform(uint32_t *state, float low, float high)
{
    *state = *state * 1664525u + 1013904223u;
    return low + (high - low) * (float)(*state >> 8) / 16777216.0f;
}

/* A tile of one VPL at the origin that looks along +z, or of a sky. */
typedef struct canvas {
    struct ism_maps maps;
    ism_vpl vpl;
    ism__window window;
    float directions[3][TEXELS], depth[TEXELS];
    ism__texel texels[TEXELS];
    ism__tile tile;
} canvas;

static void open_canvas(canvas *c, ism_projection projection, int sky, int windows)
{
    size_t i;
    memset(c, 0, sizeof *c);
    c->maps.desc.tile_side = SIDE;
    c->maps.desc.splat_scale = 1;
    c->maps.desc.projection = projection;
    c->maps.radius = 4;
    c->vpl.normal[2] = c->vpl.axis[2] = 1;
    c->vpl.axis[0] = projection == ISM_PROJECTION_LOBE ? 0.6f : 0;
    c->vpl.axis[2] = projection == ISM_PROJECTION_LOBE ? 0.8f : 1;
    c->vpl.exponent = projection == ISM_PROJECTION_LOBE ? 5.0f : 1.0f;
    c->vpl.directional = sky;
    if (windows) ism__set_window(20u | 10u << 6 | 16u << 12 | 30u << 18, SIDE, 4, &c->window);
    c->tile.m = &c->maps;
    c->tile.vpl = &c->vpl;
    c->tile.axes = ism__vpl_axes(&c->maps, &c->vpl);
    c->tile.projection = ism__projection_of(&c->maps, &c->vpl);
    c->tile.size = SIDE;
    c->tile.window = &c->window;
    c->tile.depth = c->depth;
    c->tile.texels = c->texels;
    c->tile.texels_per_unit = ism__texels_per_unit(&c->tile);
    ism__tile_directions(&c->tile, c->directions[0]);
    c->tile.x = c->directions[0];
    c->tile.y = c->directions[1];
    c->tile.z = c->directions[2];
    for (i = 0; i < TEXELS; i++) c->depth[i] = ISM_FAR;
}

/* Triangles on all sides of the VPL. Every fifth has no area, every seventh lies where the VPL is, every eleventh is
   not finite; half of the points stand for less than their triangle. */
static void make_points(ism__discs *s, uint32_t count, uint32_t *seed)
{
    uint32_t i, k, j;
    memset(s, 0, sizeof *s);
    s->count = count;
    for (i = 0; i < count; i++) {
        float middle[3];
        for (k = 0; k < 3; k++) middle[k] = i % 7 ? uniform(seed, -3, 3) : 0.0f;
        for (j = 0; j < 3; j++)
            for (k = 0; k < 3; k++) s->corners[j][k][i] = middle[k] + (i % 5 ? uniform(seed, -1, 1) : 0.0f);
        if (i % 11 == 10) s->corners[0][0][i] = ism__from_bits(0x7f800000u);
        s->weight[i] = i & 1u ? 0.25f : uniform(seed, 1, 3);
        s->b1[i] = uniform(seed, 0, 0.5f);
        s->b2[i] = uniform(seed, 0, 0.5f);
        s->triangle[i] = i + 1;
    }
}

typedef struct kernel_set { ism__splat splat; ism__cluster_kernel weigh; ism__triangle_kernel solid; } kernel_set;

/* The sets of this machine; set 0 is plain. */
static size_t list_sets(kernel_set sets[3])
{
    size_t count = 1;
    sets[0].splat.place = ism__place_discs_plain;
    sets[0].splat.draw = ism__draw_discs_plain;
    sets[0].weigh = ism__weigh_clusters_plain;
    sets[0].solid = ism__mean_solid_angle_plain;
#if ISM__SIMD_SETS
    if (ism__simd_level()) {
        sets[count].splat.place = ism__place_discs_avx2;
        sets[count].splat.draw = ism__draw_discs_avx2;
        sets[count].weigh = ism__weigh_clusters_avx2;
        sets[count++].solid = ism__mean_solid_angle_avx2;
    }
    if (ism__simd_level() == 2) {
        sets[count] = sets[1];
        sets[count].splat.place = ism__place_discs_avx512;
        sets[count++].weigh = ism__weigh_clusters_avx512;
    }
#endif
    return count;
}

/* What place wrote of the discs whose bits are set: the others hold anything. */
static void assert_same_discs(const ism__discs *a, const ism__discs *b, uint32_t bits)
{
    size_t i, k;
    for (i = 0; i < ISM__DISCS; i++) {
        if (!(bits >> i & 1u)) continue;
        for (k = 0; k < 3; k++) {
            assert_memory_equal(&a->at[k][i], &b->at[k][i], sizeof(float));
            assert_memory_equal(&a->g[k][i], &b->g[k][i], sizeof(float));
            assert_memory_equal(&a->d1[k][i], &b->d1[k][i], sizeof(float));
            assert_memory_equal(&a->d2[k][i], &b->d2[k][i], sizeof(float));
        }
        for (k = 0; k < 4; k++) assert_int_equal(a->box[k][i], b->box[k][i]);
        assert_memory_equal(&a->b1[i], &b->b1[i], sizeof(float));
        assert_memory_equal(&a->b2[i], &b->b2[i], sizeof(float));
        assert_memory_equal(&a->radius2[i], &b->radius2[i], sizeof(float));
    }
}

static void points_become_the_same_texels(void **state)
{
    static canvas one, other;
    kernel_set sets[3];
    size_t count = list_sets(sets), set;
    int projection, sky, windows;
    (void)state;
    for (projection = 1; projection < ISM_PROJECTION_COUNT; projection++)
        for (sky = 0; sky < 2; sky++)
            for (windows = 0; windows < 2; windows++)
                for (set = 0; set < count; set++) {
                    uint32_t seed = 9, points, covered = 0, i;
                    open_canvas(&one, (ism_projection)projection, sky, windows);
                    open_canvas(&other, (ism_projection)projection, sky, windows);
                    for (points = 1; points <= 4 * ISM__DISCS; points++) {
                        ism__discs a, b;
                        uint32_t bits;
                        make_points(&a, points % ISM__DISCS + 1, &seed);
                        b = a;
                        bits = sets[0].splat.place(&one.tile, &a);
                        assert_int_equal(bits >> a.count, 0);
                        assert_int_equal(sets[set].splat.place(&other.tile, &b), bits);
                        assert_same_discs(&a, &b, bits);
                        sets[0].splat.draw(&one.tile, &a, bits);
                        sets[set].splat.draw(&other.tile, &b, bits);
                    }
                    assert_memory_equal(one.depth, other.depth, sizeof one.depth);
                    assert_memory_equal(one.texels, other.texels, sizeof one.texels);
                    assert_true(one.tile.splats == other.tile.splats && one.tile.wide == other.tile.wide);
                    assert_true(sky || one.tile.wide > 0);
                    for (i = 0; i < TEXELS; i++) covered += one.depth[i] < ISM_FAR;
                    assert_true(one.tile.splats > 100 && covered > TEXELS / 4);
                }
}

/* A small disc's box holds the texel where ism_map_coordinates and ism_zoom see its middle. */
static void a_disc_lies_where_its_direction_does(void **state)
{
    static canvas c;
    int projection, windows;
    uint32_t seed = 4, i, tried = 0;
    (void)state;
    for (projection = 1; projection < ISM_PROJECTION_COUNT; projection++)
        for (windows = 0; windows < 2; windows++) {
            open_canvas(&c, (ism_projection)projection, 0, windows);
            for (i = 0; i < 500; i++) {
                ism__discs s;
                ism__v3 p = ism__v3_make(uniform(&seed, -1, 1), uniform(&seed, -1, 1), uniform(&seed, 0.01f, 1));
                float uv[2], direction[3];
                int x, y, k;
                memset(&s, 0, sizeof s);
                s.count = 1;
                s.weight[0] = 1.5f;
                for (k = 0; k < 3; k++) {
                    s.corners[k][0][0] = p.x + (k == 1 ? 1e-4f : 0.0f);
                    s.corners[k][1][0] = p.y + (k == 2 ? 1e-4f : 0.0f);
                    s.corners[k][2][0] = p.z;
                }
                ism__v3_store(direction, ism__v3_normalize(ism__to_local(&c.tile.axes, p)));
                if (!ism_map_coordinates(c.tile.projection, c.vpl.exponent, direction, uv) || direction[2] < 0.01f)
                    continue;
                assert_int_equal(ism__place_discs_plain(&c.tile, &s), 1);
                x = (int)ism__texel_of(ism__to_tile(&c.window.u, uv[0]), SIDE);
                y = (int)ism__texel_of(ism__to_tile(&c.window.v, uv[1]), SIDE);
                assert_true(s.box[0][0] <= x && x <= s.box[1][0] && s.box[2][0] <= y && y <= s.box[3][0]);
                assert_true(s.box[1][0] - s.box[0][0] <= 1 && s.box[3][0] - s.box[2][0] <= 1);
                tried++;
            }
        }
    assert_true(tried > 3000);
}

static void clusters_have_the_same_effect(void **state)
{
    static ism__clusters clusters[CLUSTERS / ISM__BUNDLE + 1];
    static canvas c;
    float plain[CLUSTERS + 1], other[CLUSTERS + 1];
    kernel_set sets[3];
    size_t count = list_sets(sets), set, i;
    uint32_t seed = 5, k;
    int projection, kind;
    (void)state;
    for (i = 0; i < CLUSTERS; i++) {
        ism__clusters *to = &clusters[i / ISM__BUNDLE];
        const size_t l = i % ISM__BUNDLE;
        for (k = 0; k < 3; k++) to->at[k][l] = uniform(&seed, -3, 3);
        for (k = 0; k < 3; k++) to->n[k][l] = uniform(&seed, 0.1f, 0.5f);
        to->radius2[l] = uniform(&seed, 0, 0.5f);
        to->area[l] = i % 9 ? uniform(&seed, 0.1f, 2) : 0.0f;
    }
    for (projection = 1; projection < ISM_PROJECTION_COUNT; projection++)
        for (kind = 0; kind < 4; kind++)
            for (set = 0; set < count; set++) {
                ism__spread_work w;
                open_canvas(&c, (ism_projection)projection, kind & 1, kind >> 1);
                c.maps.vpls = &c.vpl;
                c.maps.windows.data = &c.window;
                memset(&w, 0, sizeof w);
                w.m = &c.maps;
                w.clusters = clusters;
                w.cluster_count = CLUSTERS;
                plain[CLUSTERS] = other[CLUSTERS] = -1;      /* behind the last one nothing is written */
                sets[0].weigh(&w, &c.vpl, plain);
                sets[set].weigh(&w, &c.vpl, other);
                assert_memory_equal(plain, other, sizeof plain);
                for (k = 0, i = 0; i < CLUSTERS; i++) k += plain[i] > 0.0f;
                assert_true(k > CLUSTERS / 3 && k < CLUSTERS && other[CLUSTERS] < 0);
            }
}

static void a_triangle_has_the_same_solid_angle(void **state)
{
    kernel_set sets[3];
    size_t count = list_sets(sets), set;
    uint32_t seed = 6, trial, k, i;
    (void)state;
    for (trial = 0; trial < 200; trial++) {
        float views[3][ISM__VIEWS], corners[9], plain, sum = 0;
        const float (*from)[ISM__VIEWS] = (const float (*)[ISM__VIEWS])views;
        ism__v3 p[3], n;
        for (k = 0; k < 3; k++)
            p[k] = ism__v3_make(uniform(&seed, -1, 1), uniform(&seed, -1, 1), uniform(&seed, -1, 1));
        for (i = 0; i < ISM__VIEWS; i++)
            for (k = 0; k < 3; k++) views[k][i] = uniform(&seed, -1, 1) * (i < 4 ? 1.0f : 40.0f);
        n = ism__v3_cross(ism__v3_sub(p[1], p[0]), ism__v3_sub(p[2], p[0]));
        plain = sets[0].solid(p, n, from, ISM__VIEWS);
        for (set = 1; set < count; set++) {
            const float other = sets[set].solid(p, n, from, ISM__VIEWS);
            assert_memory_equal(&plain, &other, sizeof plain);
        }
        for (i = 0; i < ISM__VIEWS; i++) {
            for (k = 0; k < 3; k++)
                ism__v3_store(corners + 3 * k, ism__v3_sub(p[k], ism__v3_make(views[0][i], views[1][i], views[2][i])));
            sum += ism__solid_angle(corners, corners + 3, corners + 6) / (float)ISM__VIEWS;
        }
        assert_true(fabsf(plain - sum) <= 0.02f * sum + 1e-4f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(points_become_the_same_texels),
                                        cmocka_unit_test(a_disc_lies_where_its_direction_does),
                                        cmocka_unit_test(clusters_have_the_same_effect),
                                        cmocka_unit_test(a_triangle_has_the_same_solid_angle) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
