/* rows.h - tests of rows T43, T50, T61, T62, T66 to T70 and T73 of docs/conformance.md that both sides are put to, in
   the same words: csm.h's queries by tests/csm/query_rows_test.c, glbk_csm_ask_... by tests/csm/gl_rows_test.c. Include
   csm.h, cmocka.h, conformance.h and csm/util.h before and define ROW_TEST(state), the first line of a test; then
   define the functions rows_... below. */
#ifndef CSM_ROWS_H
#define CSM_ROWS_H

#include "making.h"

/* As cohsm_visible, cohsm_visible_scene (of instances of one object's maps) and cohsm_free. */
static void rows_visible(const cohsm_maps *maps, const cohsm_query *q, float *v, size_t *refused);
static void rows_scene(const cohsm_instance *instances, uint32_t count, const cohsm_query *q, float *v,
                       size_t *refused);
static void rows_free(cohsm_maps *maps);

/* Every view by face * N + cell, from a builder with the same desc. */
static cohsm_view *views_of(const cohsm_desc *desc, const cohsm_maps *maps)
{
    cohsm_desc d = *desc;
    cohsm_info info;
    cohsm_builder *b;
    cohsm_view *out, v;
    uint32_t i, c, n;
    float at[4];

    cohsm_get_info(maps, &info);
    memcpy(d.center, info.center, sizeof d.center);
    d.radius = info.radius;
    d.orientation = info.orientation;
    d.order = COHSM_ORDER_SCANLINE;     /* view i is cell i then */
    assert_int_equal(cohsm_builder_create(&d, &b), COHSM_OK);
    n = cohsm_builder_view_count(b);
    assert_int_equal(n, info.view_count);
    out = (cohsm_view *)malloc(n * sizeof *out);
    assert_non_null(out);
    for (i = 0; i < n; i++) {
        assert_int_equal(cohsm_builder_view(b, i, &v), COHSM_OK);
        c = i % info.map_count;
        assert_int_equal(cohsm_location(maps, c, at), COHSM_OK);
        assert_memory_equal(at, v.location, 16);
        out[i] = v;
    }
    cohsm_builder_free(b);
    return out;
}

static void matrix_inverse(const float *m, double *r)       /* of the upper 3 x 4 of an orthographic view */
{
    double a[9], det;
    int i, j;
    for (i = 0; i < 3; i++)
        for (j = 0; j < 3; j++) a[3 * i + j] = (double)m[4 * j + i];
    det = a[0] * (a[4] * a[8] - a[5] * a[7]) - a[1] * (a[3] * a[8] - a[5] * a[6]) + a[2] * (a[3] * a[7] - a[4] * a[6]);
    for (i = 0; i < 3; i++)
        for (j = 0; j < 3; j++) {
            int p = (j + 1) % 3, q = (j + 2) % 3, s = (i + 1) % 3, t = (i + 2) % 3;
            r[3 * i + j] = (a[3 * p + s] * a[3 * q + t] - a[3 * p + t] * a[3 * q + s]) / det;
        }
}

static void unproject(const cohsm_view *v, double x, double y, double z, double *out)
{
    double r[9], b[3];
    int i, j;
    matrix_inverse(v->matrix, r);
    b[0] = x - (double)v->matrix[12];
    b[1] = y - (double)v->matrix[13];
    b[2] = z - (double)v->matrix[14];
    for (i = 0; i < 3; i++)
        for (out[i] = 0, j = 0; j < 3; j++) out[i] += r[3 * i + j] * b[j];
}

/* ---- T61 ---- */

static void t61_what_is_seen_through_a_hole_is_lit_at_any_distance(void **state)
{
    model m = model_torus(24, 12, 0.7, 0.25);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 10, 32);
    cohsm_maps *maps = build(&d, &m);
    cohsm_view *views = views_of(&d, maps);
    static const double depths[5] = { -3, 0.01, 0.6, 1.5, 40 };
    static float at[5 * 1024][3], v[5 * 1024];
    uint64_t asked = 0, wrong = 0;
    uint16_t out[1024];
    uint32_t i, p, k, n;
    ROW_TEST(state)
    for (i = 0; i < 100; i++) {
        cohsm_query query;
        assert_int_equal(cohsm_depths(maps, i, out), COHSM_OK);
        for (p = 0, n = 0; p < 1024; p++) {
            double o[3], e[3], r[3], hit;
            unproject(&views[i], p % 32 + 0.5, p / 32 + 0.5, 0, o);
            unproject(&views[i], p % 32 + 0.5, p / 32 + 0.5, 1, e);
            for (k = 0; k < 3; k++) r[k] = e[k] - o[k];
            if (ray_hits(&m, o, r, -9, &hit, 1)) continue;
            /* samples whose rays pass within 1/256 pixel of an edge are the rasteriser's to decide */
            if (out[p] != 65535) {
                double near_hit, o2[3];
                int touch = 0, s;
                for (s = 0; s < 8; s++) {
                    unproject(&views[i], p % 32 + 0.5 + 0.01 * cos(s * PI / 4), p / 32 + 0.5 + 0.01 * sin(s * PI / 4),
                              0, o2);
                    touch |= ray_hits(&m, o2, r, -9, &near_hit, 1);
                }
                if (touch) continue;
            }
            for (k = 0; k < 5; k++) {
                double q[3];
                int c;
                unproject(&views[i], p % 32 + 0.5, p / 32 + 0.5, depths[k], q);
                for (c = 0; c < 3; c++) at[n][c] = (float)q[c];
                n++;
            }
        }
        query = query_of(at[0], n, &i, COHSM_LIGHT_INDEX, COHSM_FILTER_NEAREST);
        query.one_light = 1;
        query.bias = -1;
        rows_visible(maps, &query, v, NULL);
        asked += n;
        for (p = 0; p < n; p++) wrong += v[p] != 1.0f;
    }
    print_message("T61: %lu queries behind misses, %lu wrong\n", (unsigned long)asked, (unsigned long)wrong);
    assert_true(asked > 100000);
    CONFORM("T61", "queries behind misses that are not lit, five distances", 0, wrong, 0);
    free(views);
    rows_free(maps);
    model_free(&m);
}

/* ---- T62 ---- */

static void t62_z1z2_lights_nothing_behind_or_inside_the_sphere(void **state)
{
    static const char *const names[4] = { "", "z1z2", "z1z3_sphere", "z1z3_far" };
    model m = model_sphere(40, 20, 0);
    int l;
    ROW_TEST(state)
    /* a flat ellipsoid: much room between z2 and the bounding sphere */
    for (l = 0; l < (int)m.vertices; l++) m.p[3 * l + 1] *= 0.3f;
    for (l = 1; l <= 3; l++) {
        cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 32, 64);
        cohsm_maps *maps;
        float up[3] = { 0, 1, 0 }, v[2][2000], points[2000][3], light[2000][3];
        uint64_t seed = 12;
        uint32_t i, wrong_far = 0, wrong_near = 0, n = 2000;
        cohsm_query q;
        d.layers = (cohsm_layers)l;
        maps = build(&d, &m);
        for (i = 0; i < n; i++) {
            double r = 0.6 * sqrt(rnd(&seed)), a = 2 * PI * rnd(&seed);
            points[i][0] = (float)(r * cos(a));
            points[i][1] = -3.0f;                               /* beyond the sphere, in shadow of straight light */
            points[i][2] = (float)(r * sin(a));
            memcpy(light[i], up, sizeof up);
        }
        q = query_of(points[0], n, light[0], COHSM_LIGHT_DIRECTION, COHSM_FILTER_NEAREST);
        rows_visible(maps, &q, v[0], NULL);
        for (i = 0; i < n; i++) points[i][1] = -0.45f;          /* behind z2 = -0.3, inside the sphere */
        rows_visible(maps, &q, v[1], NULL);
        for (i = 0; i < n; i++) {
            wrong_far += v[0][i] != 0.0f;
            wrong_near += v[1][i] != 0.0f;
        }
        print_message("T62 %s: wrongly lit: object beyond the sphere %.4f, receiver between z2 and the sphere %.4f\n",
                      names[l], wrong_far / 2000.0, wrong_near / 2000.0);
        if (l == COHSM_LAYERS_Z1Z2) {
            CONFORM("T62", "wrongly lit beyond the sphere, z1z2", 0, wrong_far / 2000.0, 0);
            CONFORM("T62", "wrongly lit between z2 and the sphere, z1z2", 0, wrong_near / 2000.0, 0);
        } else if (l == COHSM_LAYERS_Z1Z3_SPHERE) {
            CONFORM("T62", "wrongly lit beyond the sphere, z1z3_sphere", 0, wrong_far / 2000.0, 0);
            CONFORM_NOTE("T62", "wrongly lit between z2 and the sphere, z1z3_sphere", wrong_near / 2000.0);
        } else {
            assert_true(wrong_far > 0);     /* the documented fault */
            CONFORM_NOTE("T62", "wrongly lit beyond the sphere, z1z3_far", wrong_far / 2000.0);
            CONFORM_NOTE("T62", "wrongly lit between z2 and the sphere, z1z3_far", wrong_near / 2000.0);
        }
        rows_free(maps);
    }
    model_free(&m);
}

/* ---- T66 ---- */

static void transform(const float *m, const float *p, float w, float *out)
{
    int r;
    for (r = 0; r < 3; r++)
        out[r] = (float)((double)m[r] * (double)p[0] + (double)m[4 + r] * (double)p[1] +
                         (double)m[8 + r] * (double)p[2] + (double)m[12 + r] * (double)w);
}

static void t66_object_and_light_moved_together_give_the_same_answers(void **state)
{
    enum { N = 20000 };
    static float p[N][3], l[N][3], q[N][3], k[N][3], v[N], w[N];
    model m = model_sphere(24, 14, 0.25);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 24, 64);
    cohsm_maps *maps = build(&d, &m);
    cohsm_instance inst;
    uint64_t seed = 21;
    int filter, light, round, i, differ;
    double worst = 0;
    uint32_t turned = 0;
    ROW_TEST(state)
    inst.maps = maps;
    for (light = 0; light < 2; light++)
        for (filter = 0; filter < 3; filter++) {
            cohsm_query a, b;
            for (i = 0; i < N; i++) {
                float dir[3];
                int c;
                rnd_direction(&seed, dir);
                rnd_direction(&seed, l[i]);
                for (c = 0; c < 3; c++) {
                    p[i][c] = dir[c] * (float)rnd_in(&seed, 0.3, 1.6);
                    if (light) l[i][c] *= 4.0f;
                }
            }
            a = query_of(p[0], N, l[0], light ? COHSM_LIGHT_POSITION : COHSM_LIGHT_DIRECTION, (cohsm_filter)filter);
            a.seed = 5;
            rows_visible(maps, &a, v, NULL);
            /* quarter turns and a scale of 4: every product is exact, so every bit is the same */
            identity(inst.transform);
            inst.transform[0] = inst.transform[10] = 0;
            inst.transform[2] = -4;
            inst.transform[8] = 4;
            inst.transform[5] = 4;
            for (i = 0; i < N; i++) {
                transform(inst.transform, p[i], 1, q[i]);
                transform(inst.transform, l[i], light ? 1.0f : 0.0f, k[i]);
                if (!light) { k[i][0] /= 4; k[i][1] /= 4; k[i][2] /= 4; }
            }
            b = query_of(q[0], N, k[0], a.light_kind, a.filter);
            b.seed = 5;
            rows_scene(&inst, 1, &b, w, NULL);
            for (i = 0, differ = 0; i < N; i++) differ += v[i] != w[i];
            if (differ) fail_msg("light %d, filter %d: %d of %d differ after a quarter turn", light, filter, differ, N);
            turned += (uint32_t)differ;
            for (round = 0; round < 4; round++) {
                double sum = 0;
                placed(inst.transform, &seed, round == 0 ? 1.0 : rnd_in(&seed, 0.1, 20));
                for (i = 0; i < N; i++) {
                    transform(inst.transform, p[i], 1, q[i]);
                    transform(inst.transform, l[i], light ? 1.0f : 0.0f, k[i]);
                    if (!light) {
                        double len = sqrt((double)k[i][0] * (double)k[i][0] + (double)k[i][1] * (double)k[i][1] +
                                          (double)k[i][2] * (double)k[i][2]);
                        int c;
                        for (c = 0; c < 3; c++) k[i][c] = (float)((double)k[i][c] / len);
                    }
                }
                rows_scene(&inst, 1, &b, w, NULL);
                for (i = 0; i < N; i++) sum += fabs((double)v[i] - (double)w[i]);
                worst = sum / N > worst ? sum / N : worst;
            }
        }
    print_message("T66: quarter turns: 0 of 120000 differ; any rotation and scale: mean difference at most %.6f\n",
                  worst);
    CONFORM("T66", "answers that differ after a quarter turn and a scale of 4, of 120,000", 0, turned, 0);
    /* roundings that cross a pixel, cell or depth border */
    CONFORM_MAX("T66", "mean difference after any rotation and scale", 1e-3, worst);
    rows_free(maps);
    model_free(&m);
}

/* ---- T67, T68 ---- */

static void t67_an_occluder_beyond_the_light_casts_no_shadow(void **state)
{
    enum { N = 3000 };
    model m = model_sphere(32, 20, 0);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 32, 64);
    cohsm_maps *maps = build(&d, &m);
    static float p[N][3], l[3][N][3], v[N];
    uint64_t seed = 31;
    uint32_t i, k, counts[3] = { 0, 0, 0 };
    ROW_TEST(state)
    for (i = 0; i < N; i++) {
        float dir[3];
        double far = rnd_in(&seed, 3, 8), t = rnd_in(&seed, 1.3, far - 0.1);
        int c;
        rnd_direction(&seed, dir);
        for (c = 0; c < 3; c++) {
            p[i][c] = dir[c] * (float)far + 0.02f;
            l[0][i][c] = dir[c] * (float)t - 0.02f;         /* point, light, sphere */
            l[1][i][c] = dir[c] * (float)(far + t);         /* light, point, sphere */
            l[2][i][c] = -dir[c] * (float)t;                /* point, sphere, light */
        }
    }
    for (k = 0; k < 3; k++) {
        cohsm_query q = query_of(p[0], N, l[k][0], COHSM_LIGHT_POSITION, COHSM_FILTER_NEAREST);
        rows_visible(maps, &q, v, NULL);
        for (i = 0; i < N; i++) counts[k] += v[i] == (k == 2 ? 0.0f : 1.0f);
    }
    print_message(
        "T67: point, light, sphere: %u of 3000 lit; light, point, sphere: %u lit; point, sphere, light: %u dark\n",
        counts[0], counts[1], counts[2]);
    CONFORM("T67", "lit of 3000: point, light, sphere", 3000, counts[0], 0);
    CONFORM("T67", "lit of 3000: light, point, sphere", 3000, counts[1], 0);
    CONFORM("T67", "dark of 3000: point, sphere, light", 3000, counts[2], 0);
    rows_free(maps);
    model_free(&m);
}

/* Lights and points all round a sphere, in no line with its centre: the answer is that of the segment between them,
   known where its distance from the centre is a sixth of the radius away from it. */
static void t67_a_light_at_a_place_shadows_along_segments(void **state)
{
    enum { N = 6000 };
    model m = model_sphere(64, 40, 0);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 64, 96);
    cohsm_maps *maps = build(&d, &m);
    static float p[N][3], l[N][3], v[N];
    static double away[N];
    uint64_t seed = 47;
    uint32_t i, asked[2] = { 0, 0 }, right[2] = { 0, 0 };
    int c;
    ROW_TEST(state)
    for (i = 0; i < N; i++) {
        double along = 0, squared = 0, from = 0, share;
        double near = rnd_in(&seed, 1.2, 3), far = rnd_in(&seed, 1.7, 4);
        rnd_direction(&seed, p[i]);
        rnd_direction(&seed, l[i]);
        for (c = 0; c < 3; c++) {
            p[i][c] *= (float)near;
            l[i][c] *= (float)far;
            along -= (double)p[i][c] * (double)(l[i][c] - p[i][c]);
            squared += pow((double)(l[i][c] - p[i][c]), 2);
        }
        share = along / squared < 0 ? 0 : along / squared > 1 ? 1 : along / squared;
        for (c = 0; c < 3; c++) from += pow((double)p[i][c] + share * (double)(l[i][c] - p[i][c]), 2);
        away[i] = sqrt(from);
    }
    {
        cohsm_query q = query_of(p[0], N, l[0], COHSM_LIGHT_POSITION, COHSM_FILTER_NEAREST);
        rows_visible(maps, &q, v, NULL);
    }
    for (i = 0; i < N; i++) {
        if (away[i] < 5.0 / 6) asked[0]++, right[0] += v[i] == 0.0f;
        if (away[i] > 7.0 / 6) asked[1]++, right[1] += v[i] == 1.0f;
    }
    print_message("T67: of segments through the sphere %u of %u dark, of those past it %u of %u lit\n", right[0],
                  asked[0], right[1], asked[1]);
    assert_true(asked[0] > 500 && asked[1] > 500);
    CONFORM("T67", "share dark of segments through a sphere, in no line with its centre", 1,
            (double)right[0] / asked[0], 0);
    CONFORM("T67", "share lit of segments that pass it", 1, (double)right[1] / asked[1], 0);
    rows_free(maps);
    model_free(&m);
}

static void t68_a_light_inside_the_hull_is_refused_and_counted(void **state)
{
    enum { N = 4096 };
    static float p[N][3], l[N][3], v[N];
    model m = model_sphere(32, 20, 0);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 8, 32);
    cohsm_maps *maps = build(&d, &m);
    cohsm_instance inst[2];
    uint64_t seed = 41;
    size_t refused = 99, mine = 0, i;
    int filter, c;
    ROW_TEST(state)
    for (i = 0; i < N; i++) {
        float dir[3];
        double r = rnd_in(&seed, 0, 3);
        rnd_direction(&seed, dir);
        rnd_direction(&seed, p[i]);
        for (c = 0; c < 3; c++) {
            p[i][c] *= 2.0f;
            l[i][c] = dir[c] * (float)r;
        }
        if (r > 0.93 && r < 1.25) l[i][1] += 3;      /* between sphere and k-DOP either answer would do */
    }
    for (filter = 0; filter < 3; filter++) {
        cohsm_query q = query_of(p[0], N, l[0], COHSM_LIGHT_POSITION, (cohsm_filter)filter);
        rows_visible(maps, &q, v, &refused);
        for (i = 0, mine = 0; i < N; i++) {
            double r = sqrt((double)l[i][0] * (double)l[i][0] + (double)l[i][1] * (double)l[i][1] +
                            (double)l[i][2] * (double)l[i][2]);
            assert_int_equal(v[i] == COHSM_REFUSED, r < 1);
            mine += r < 1;
            assert_true(v[i] == COHSM_REFUSED || (v[i] >= 0.0f && v[i] <= 1.0f));
        }
        assert_int_equal(refused, mine);
        assert_true(mine > 500);
        if (filter == COHSM_FILTER_NEAREST)
            CONFORM("T68", "lights refused of those in a sphere, of 4096", mine, refused, 0);
    }
    /* in a scene: inside either hull; refusal is never multiplied away by a later object */
    for (i = 0; i < 2; i++) {
        inst[i].maps = maps;
        identity(inst[i].transform);
        inst[i].transform[13] = i ? 2.5f : 0.0f;
    }
    {
        cohsm_query q = query_of(p[0], N, l[0], COHSM_LIGHT_POSITION, COHSM_FILTER_NEAREST);
        size_t both = 0;
        rows_scene(inst, 2, &q, v, &refused);
        for (i = 0; i < N; i++) both += v[i] == COHSM_REFUSED;
        assert_int_equal(both, refused);
        print_message("T68: %lu of %d refused by one object, %lu by two\n", (unsigned long)mine, N,
                      (unsigned long)refused);
        assert_true(refused >= mine / 2);
    }
    rows_free(maps);
    model_free(&m);
}

/* ---- T69 ---- */

static void t69_desc(int dims, cohsm_desc *d)
{
    *d = desc_of(dims == 1   ? COHSM_DOMAIN_LINE
                 : dims == 2 ? COHSM_DOMAIN_RECTANGLE
                             : COHSM_DOMAIN_VOLUME,
                 dims == 3 ? 4 : 6, 32);
    place_domain(d, -1, 2, -1, 2);
}

/* Weights sum to 1: what all comparisons agree on is exactly 0 or 1. */
static void t69_agreement_is_exactly_one_or_zero(void **state)
{
    enum { N = 20000 };
    static float p[N][3], l[N][3], v[N];
    model m = model_cube(0.577, 0);
    uint32_t all_bad = 0;
    int k;
    ROW_TEST(state)
    for (k = 0; k < 5; k++) {
        cohsm_desc d;
        cohsm_maps *maps;
        cohsm_query q;
        uint64_t seed = 61;
        uint32_t i, bad = 0;
        if (k < 2) d = desc_of(k ? COHSM_DOMAIN_OCTAHEDRAL : COHSM_DOMAIN_LATLONG, 24, 32);
        else t69_desc(k - 1, &d);
        maps = build(&d, &m);
        for (i = 0; i < N; i++) {
            int c;
            rnd_direction(&seed, l[i]);
            for (c = 0; c < 3; c++) {
                p[i][c] = k < 2 ? l[i][c] * (i & 1 ? 3.0f : -1.2f) : (float)rnd_in(&seed, -0.05, 0.05);
                if (k >= 2) l[i][c] = (float)rnd(&seed);
            }
            if (k >= 2) p[i][1] += i & 1 ? 1.2f : -2.0f; /* before or behind the cube, seen from the light above */
        }
        q = query_of(p[0], N, l[0], k < 2 ? COHSM_LIGHT_DIRECTION : COHSM_LIGHT_PARAMETER, COHSM_FILTER_PCF);
        q.light_stride = 12;
        rows_visible(maps, &q, v, NULL);
        for (i = 0; i < N; i++)
            if (!(v[i] >= 0.0f && v[i] <= 1.0f)) fail_msg("visibility %.9g", (double)v[i]);
        for (i = 0; i < N; i++) bad += i & 1 ? v[i] != 1.0f : v[i] != 0.0f && k < 2;
        print_message("T69 domain %d: %u of %d constant neighbourhoods are not exactly 1 or 0\n", (int)d.domain.kind,
                      bad, N);
        all_bad += bad;
        rows_free(maps);
    }
    CONFORM("T69", "PCF not exactly 0 or 1 where all comparisons agree, of 100,000", 0, all_bad, 0);
    model_free(&m);
}

/* ---- T70 ---- */

static int in_box(const float *p, const double *lo, const double *hi)
{
    int c, inside = 1;
    for (c = 0; c < 3; c++) inside &= (double)p[c] > lo[c] && (double)p[c] < hi[c];
    return inside;
}

/* Inside a wall, where nothing is promised. */
static int in_solid(const float *p, const double *lo, const double *hi, double wall)
{
    double a[3], b[3];
    int c;
    for (c = 0; c < 3; c++) {
        a[c] = lo[c] - wall;
        b[c] = hi[c] + wall;
    }
    return in_box(p, a, b) && !in_box(p, lo, hi);
}

/* A room with one wall left out at a time: points behind the walls are dark, but for those seen through the opening. */
static void t70_cube_faces_agree_with_ray_casts(void **state)
{
    static const double lo[3] = { -1, -0.8, -1.2 }, hi[3] = { 1.1, 1, 0.9 };
    unsigned open;
    static float points[2500][3], v[2500];
    static uint32_t which[2500];
    static int blocked[2500];
    uint64_t asked = 0, wrong = 0, edge = 0;
    ROW_TEST(state)
    for (open = 0; open <= 7; open++) {
        model m = model_room(lo, hi, 0.15, open < 6 ? 1u << open : 0);
        static const double slo[3] = { 0.3, -0.7, -0.6 }, shi[3] = { 0.6, -0.2, -0.3 };
        model box = model_box(slo, shi, 0), all = model_join(&m, &box);
        float at[3][4] = { { 0.1f, 0.2f, -0.1f, 1 }, { -0.5f, -0.3f, 0.4f, 1 }, { 0.7f, 0.6f, 0.5f, 1 } };
        cohsm_desc d = desc_of(COHSM_DOMAIN_LIST, 0, 64);
        cohsm_maps *maps;
        cohsm_query q;
        uint64_t seed = 71 + open;
        uint32_t i, c, n = 0;
        d.domain.locations = at[0];
        d.domain.location_count = 3;
        d.order = COHSM_ORDER_SCANLINE;
        maps = build(&d, &all);
        for (i = 0; i < 2500; i++) {
            double o[3], r[3], hits[1] = { 2 }, len;
            float p[3];
            int skipped, mixed = 0, s;
            which[n] = i % 3;
            for (c = 0; c < 3; c++) {
                p[c] = (float)rnd_in(&seed, 1.9 * lo[c], 1.9 * hi[c]);
                o[c] = (double)at[which[n]][c];
                r[c] = (double)p[c] - o[c];
            }
            /* nor is anything promised within the bias behind a surface: 1/32 of the distance */
            for (s = 0, skipped = 0; s < 3; s++) {
                float at_bias[3];
                for (c = 0; c < 3; c++) at_bias[c] = (float)(o[c] + r[c] * (1 - 0.02 * s));
                skipped |= in_solid(at_bias, lo, hi, 0.15) || in_box(at_bias, slo, shi);
            }
            if (skipped) continue;
            len = sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
            blocked[n] = ray_hits(&all, o, r, 1e-9, hits, 1) && hits[0] < 1;
            /* within one texel of an edge: a neighbouring ray disagrees, or the point is near the surface itself */
            for (s = 0; s < 81 && !mixed; s++) {
                double t[3], off = (0.9 + s / 27) / 64 * len;
                for (c = 0; c < 3; c++)
                    t[c] = r[c] + off * (c == 0 ? s % 3 - 1 : c == 1 ? s / 3 % 3 - 1 : s / 9 % 3 - 1);
                mixed = (ray_hits(&all, o, t, 1e-9, hits, 1) && hits[0] < 1) != blocked[n];
            }
            if (mixed) edge++;
            else memcpy(points[n++], p, sizeof p);
        }
        q = query_of(points[0], n, which, COHSM_LIGHT_INDEX, COHSM_FILTER_NEAREST);
        rows_visible(maps, &q, v, NULL);
        asked += n;
        for (i = 0; i < n; i++) wrong += (v[i] == 0.0f) != blocked[i];
        rows_free(maps);
        model_free(&m);
        model_free(&box);
        model_free(&all);
    }
    print_message("T70: %lu answers, %lu differ from rays; %lu within a texel of an edge left out\n",
                  (unsigned long)asked, (unsigned long)wrong, (unsigned long)edge);
    assert_true(asked > 12500);
    CONFORM("T70", "answers in a room that differ from rays a texel off every edge", 0, wrong, 0);
}

/* ---- integrals of visibility ---- */

/* Irradiance at p with normal n from a light of radiance 1: the maps are the quadrature's samples. */
static double irradiance(const cohsm_maps *maps, const float *p, const double *n, const double *light_normal,
                         const float *center, double area)
{
    static float points[1600][3], v[1600];
    static uint32_t cells[1600];
    cohsm_info info;
    cohsm_query q;
    double sum = 0;
    uint32_t i, c;
    cohsm_get_info(maps, &info);
    assert_int_equal(info.map_count, 1600);
    for (i = 0; i < 1600; i++) {
        memcpy(points[i], p, sizeof points[i]);
        cells[i] = i;
    }
    q = query_of(points[0], 1600, cells, COHSM_LIGHT_INDEX, COHSM_FILTER_NEAREST);
    rows_visible(maps, &q, v, NULL);
    for (i = 0; i < info.map_count; i++) {
        float at[4];
        double d[3], nl[3], r2 = 0, cp = 0, cl = 0, len = 0;
        assert_int_equal(cohsm_location(maps, i, at), COHSM_OK);
        for (c = 0; c < 3; c++) {
            nl[c] = light_normal ? light_normal[c] : (double)at[c] - (double)center[c];
            len += nl[c] * nl[c];
            d[c] = (double)at[c] - (double)p[c];
            r2 += d[c] * d[c];
            cp += d[c] * n[c];
            cl -= d[c] * nl[c];
        }
        cl /= sqrt(len);
        if (cp <= 0 || cl <= 0) continue;
        if (v[i] > 0.0f) sum += cp * cl / (r2 * r2);
    }
    return sum * area / info.map_count;
}

/* A light 2 above the receiver; the object between them is far away (free), or a thin box that covers one
   half (T50). */
static void area_lights_have_the_irradiance_of_closed_forms(void **state)
{
    static const double free_lo[3] = { 5, 0, 5 }, free_hi[3] = { 6, 1, 6 }, half_lo[3] = { 0, 0.95, -4 },
                        half_hi[3] = { 8, 1.0, 4 };
    static const double up[3] = { 0, 1, 0 }, down[3] = { 0, -1, 0 };
    static const char *const names[3] = { "disc", "rectangle", "sphere" };
    int light, blocked;
    ROW_TEST(state)
    for (light = 0; light < 3; light++) {
        double e[2], exact = light == 0 ? PI * 0.25 / (0.25 + 4) : light == 1 ? 0.752275 / 1 : PI * 0.25 / 4;
        double height = light == 1 ? 1 : 2, area = light == 0 ? PI * 0.25 : light == 1 ? 1 : 4 * PI * 0.25;
        for (blocked = 0; blocked < 2; blocked++) {
            model m = blocked ? model_box(half_lo, half_hi, 0) : model_box(free_lo, free_hi, 0);
            cohsm_desc d = desc_of(light == 0   ? COHSM_DOMAIN_DISC
                                   : light == 1 ? COHSM_DOMAIN_RECTANGLE
                                                : COHSM_DOMAIN_SPHERE,
                                   40, 32);
            float p[3] = { 0, 0, 0 };
            cohsm_maps *maps;
            uint32_t i;
            d.domain.origin[1] = (float)height;
            d.domain.u[0] = light == 1 ? 1.0f : 0.5f;
            d.domain.v[2] = light == 1 ? 1.0f : 0.5f;
            if (light == 1) d.domain.origin[0] = d.domain.origin[2] = -0.5f;
            if (light == 1 && blocked)
                for (i = 0; i < 8; i++) m.p[3 * i + 1] -= 0.5f;
            maps = build(&d, &m);
            e[blocked] = irradiance(maps, p, up, light == 2 ? NULL : down, d.domain.origin, area);
            rows_free(maps);
            model_free(&m);
        }
        print_message("irradiance under a %s: %.6f, exact %.6f; half covered: %.6f of it\n", names[light], e[0], exact,
                      e[1] / e[0]);
        CONFORM(light == 0   ? "irradiance"
                : light == 1 ? "T43"
                             : "T73",
                light == 0   ? "disc of radius 0.5, 2 above, by 1600 maps"
                : light == 1 ? "unit square 1 above, by 1600 maps"
                             : "sphere 4 r away, by 1600 maps",
                exact, e[0], 0.005 * exact);
        /* half a cell of 40 columns is 0.0125 */
        CONFORM("T50",
                light == 0   ? "share of a disc left by a half-plane"
                : light == 1 ? "share of a square left by a half-plane"
                             : "share of a sphere left by a half-plane",
                0.5, e[1] / e[0], 0.02);
    }
}

#define CSM_ROWS(X)                                                             \
    X(t61_what_is_seen_through_a_hole_is_lit_at_any_distance)                   \
    X(t62_z1z2_lights_nothing_behind_or_inside_the_sphere)                      \
    X(t66_object_and_light_moved_together_give_the_same_answers)                \
    X(t67_an_occluder_beyond_the_light_casts_no_shadow)                         \
    X(t67_a_light_at_a_place_shadows_along_segments)                            \
    X(t68_a_light_inside_the_hull_is_refused_and_counted)                       \
    X(t69_agreement_is_exactly_one_or_zero)                                     \
    X(t70_cube_faces_agree_with_ray_casts)                                      \
    X(area_lights_have_the_irradiance_of_closed_forms)

#endif
