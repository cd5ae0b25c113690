/* scene_rows_test - scenes of shadowfield.h: rows T76, T78 to T80 of docs/conformance.md, closed forms of a sphere
   under a uniform sky, the product modes against one another, the lazy cache against fresh results, threads against
   none. */
#define SFIELD_STATIC
#define SHADOWFIELD_IMPLEMENTATION
#include "shadowfield.h"
#include "util.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include "conformance.h"

/* An entity of no fields that stands at the origin, not tinted. */
static const sfield_entity upright = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };

static sfield_field *ball[3], *ball_log, *lamp[3], *blob[3];        /* by basis: 1 harmonics, 2 wavelets */
static const float sky_one[3] = { 1, 1, 1 };

static sfield_field *make_field(const model *m, sfield_basis basis, int logarithm)
{
    sfield_mesh mesh = mesh_of(m);
    sfield_field *f = NULL;
    sfield_desc d;
    memset(&d, 0, sizeof d);
    d.basis = basis;
    d.shell_count = 12;
    d.position_side = 7;
    d.cube_side = 16;
    d.keep = 0.1f;
    d.outer = 12;
    d.logarithm = logarithm;
    assert_int_equal(sfield_build(&d, &mesh, &f, NULL), SFIELD_OK);
    return f;
}

static int make_fields(void **state)
{
    model m = model_sphere(32, 16, 1), s = model_soup(16, 0.6, 77);
    sfield_emitter e;
    sfield_desc d;
    int b;
    (void)state;
    memset(&e, 0, sizeof e);
    memset(&d, 0, sizeof d);
    e.radius = 1;
    e.radiance[0] = 1;
    e.radiance[1] = 0.5f;
    e.radiance[2] = 0.25f;
    d.shell_count = 12;
    d.position_side = 7;
    d.cube_side = 16;
    d.keep = 0.1f;
    d.outer = 12;
    for (b = 1; b < 3; b++) {
        d.basis = (sfield_basis)b;
        ball[b] = make_field(&m, (sfield_basis)b, 0);
        blob[b] = make_field(&s, (sfield_basis)b, 0);
        assert_int_equal(sfield_build_emitter(&d, &e, &lamp[b], NULL), SFIELD_OK);
    }
    ball_log = make_field(&m, SFIELD_BASIS_SH, 1);
    model_free(&m);
    model_free(&s);
    return 0;
}

static int free_fields(void **state)
{
    int b;
    (void)state;
    for (b = 1; b < 3; b++) {
        sfield_free(ball[b]);
        sfield_free(blob[b]);
        sfield_free(lamp[b]);
    }
    sfield_free(ball_log);
    return 0;
}

static sfield_scene *scene_of(sfield_basis basis, sfield_product_mode product)
{
    sfield_scene_desc d;
    sfield_scene *s = NULL;
    memset(&d, 0, sizeof d);
    d.basis = basis;
    d.product = product;
    d.cube_side = 16;
    assert_int_equal(sfield_scene_create(&d, &s), SFIELD_OK);
    return s;
}

static sfield_entity at(sfield_field *occlusion, sfield_field *source, double x, double y, double z)
{
    sfield_entity e = upright;
    e.occlusion = occlusion;
    e.source = source;
    e.transform[12] = (float)x;
    e.transform[13] = (float)y;
    e.transform[14] = (float)z;
    return e;
}

/* One point at the origin that looks up. */
static void shade_up(sfield_scene *s, float *rgb, sfield_scene_stats *stats)
{
    static const float p[3] = { 0, 0, 0 }, up[3] = { 0, 1, 0 };
    sfield_points set;
    memset(&set, 0, sizeof set);
    set.count = 1;
    set.positions = p;
    set.normals = up;
    set.entity = 0;
    set.rgb = rgb;
    assert_int_equal(sfield_shade(s, &set, 1, stats), SFIELD_OK);
}

static void a_sphere_hides_its_share_of_a_uniform_sky(void **state)
{
    static const double heights[3] = { 1.5, 2, 4 };
    int b, i;
    (void)state;
    for (b = 1; b < 3; b++)
        for (i = -1; i < 3; i++) {
            sfield_scene *s = scene_of((sfield_basis)b, SFIELD_PRODUCT_DEFAULT);
            sfield_entity e = at(ball[b], NULL, 0, i < 0 ? 2 : heights[i], 0);
            double exact = i < 0 ? 1 : 1 - 1 / (heights[i] * heights[i]);
            float rgb[3];
            sfield_scene_entities(s, &e, i >= 0);
            sfield_scene_environment(s, sky_one, 1, 1, NULL);
            shade_up(s, rgb, NULL);
            print_message("basis %d, sphere at %g: %.4f, exactly %.4f\n", b, i < 0 ? 0 : heights[i], (double)rgb[0],
                          exact);
            assert_true(fabs((double)rgb[0] - exact) < (i < 0 ? 0.002 : b == 1 ? 0.03 : 0.02));
            assert_true(rgb[0] == rgb[1] && rgb[1] == rgb[2]);
            sfield_scene_free(s);
        }
}

/* Lamp in the middle of two balls above the point: only the nearer one hides it. */
static void t78_only_a_nearer_ball_hides_the_lamp(void **state)
{
    int b;
    (void)state;
    for (b = 1; b < 3; b++) {
        sfield_scene *s = scene_of((sfield_basis)b, SFIELD_PRODUCT_DEFAULT);
        sfield_entity e[3];
        float lit[3], both[3], near[3], far[3], swapped[3];
        e[0] = at(NULL, lamp[b], 0, 8, 0);
        sfield_scene_entities(s, e, 1);
        shade_up(s, lit, NULL);
        e[1] = at(ball[b], NULL, 0, 11, 0);
        sfield_scene_entities(s, e, 2);
        shade_up(s, far, NULL);
        e[2] = at(ball[b], NULL, 0, 4, 0);
        sfield_scene_entities(s, e, 3);
        shade_up(s, both, NULL);
        sfield_scene_entities(s, e + 1, 0);
        e[1] = e[2];
        sfield_scene_entities(s, e, 2);
        shade_up(s, near, NULL);
        e[1] = at(ball[b], NULL, 0, 4, 0);                            /* the list in another order */
        e[2] = e[0];
        e[0] = at(ball[b], NULL, 0, 11, 0);
        sfield_scene_entities(s, e, 3);
        shade_up(s, swapped, NULL);
        CONFORM("T78", b == 1 ? "light before a far ball by light alone, harmonics" : "wavelets", 1, far[0] / lit[0],
                0);
        CONFORM("T78", b == 1 ? "light between two balls by behind the near one, harmonics" : "two balls, wavelets", 1,
                both[0] / near[0], 0);
        assert_true(swapped[0] == both[0]);
        assert_true(near[0] < 0.85f * lit[0] && (b == 1 || near[0] < 0.05f * lit[0]));
        assert_true(fabs((double)lit[0] * 64 - 1) < (b == 1 ? 0.2 : 0.05));
        sfield_scene_free(s);
    }
}

/* The order is decided point by point inside a tile: 16 points, for half of which the light is nearer. */
static void t78_the_order_is_decided_inside_a_tile(void **state)
{
    sfield_scene *s = scene_of(SFIELD_BASIS_SH, SFIELD_PRODUCT_TRIPLE);
    sfield_entity e[3];
    float p[48], n[48], all[48], one[3];
    sfield_points set;
    int i;
    (void)state;
    e[0] = at(NULL, lamp[1], 3, 4, 0);
    e[1] = at(ball[1], NULL, -3, 4, 0);
    e[2] = at(ball[1], NULL, 0, 3, 3);
    sfield_scene_entities(s, e, 3);
    sfield_scene_environment(s, sky_one, 1, 1, NULL);
    memset(&set, 0, sizeof set);
    for (i = 0; i < 16; i++) {
        p[3 * i] = (float)(i - 7.5) * 0.4f;
        p[3 * i + 1] = p[3 * i + 2] = 0;
        n[3 * i] = n[3 * i + 2] = 0;
        n[3 * i + 1] = 1;
    }
    set.count = 16;
    set.positions = p;
    set.normals = n;
    set.entity = 0;
    set.rgb = all;
    assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
    for (i = 0; i < 16; i++) {
        set.count = 1;
        set.positions = p + 3 * i;
        set.rgb = one;
        assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
        assert_true(fabsf(one[0] - all[3 * i]) < 2e-3f);              /* occluders may commute: truncation only */
    }
    sfield_scene_free(s);
}

static void t76_turning_everything_changes_nothing(void **state)
{
    int b;
    uint64_t seed = 3;
    (void)state;
    for (b = 1; b < 3; b++) {
        sfield_scene *s = scene_of((sfield_basis)b, SFIELD_PRODUCT_DEFAULT);
        sfield_entity e[3], r[3];
        sfield_points set;
        float p[30], n[30], q[30], m[30], before[30], after[30], turned[16];
        double worst = 0;
        int i, k;
        matrix_of(turned, 1, 2, -0.5, 1.1, 1, 0, 0, 0);
        e[0] = at(blob[b], NULL, 1, 3, 0);
        e[1] = at(blob[b], NULL, -2, 1, 1);
        e[2] = at(NULL, lamp[b], 2, 6, 1);
        if (b == 1) matrix_of(e[1].transform, 1, 1, 0, 2, 1.5, -2, 1, 1);
        for (i = 0; i < 3; i++) {                                     /* R times each transform */
            int row, col;
            r[i] = e[i];
            for (row = 0; row < 3; row++)
                for (col = 0; col < 4; col++) {
                    double x = 0;
                    for (k = 0; k < 3; k++) x += (double)turned[4 * k + row] * (double)e[i].transform[4 * col + k];
                    r[i].transform[4 * col + row] = (float)x;
                }
        }
        for (i = 0; i < 10; i++) {
            double d[3], to[3];
            rnd_direction(&seed, d);
            turn(turned, d, to);
            for (k = 0; k < 3; k++) {
                n[3 * i + k] = (float)d[k];
                m[3 * i + k] = (float)to[k];
                p[3 * i + k] = (float)(d[k] = rnd(&seed) - 0.5);
            }
            turn(turned, d, to);
            for (k = 0; k < 3; k++) q[3 * i + k] = (float)to[k];
        }
        memset(&set, 0, sizeof set);
        set.count = 10;
        set.positions = p;
        set.normals = n;
        set.entity = 0;
        set.rgb = before;
        sfield_scene_environment(s, sky_one, 1, 1, NULL);
        assert_int_equal(sfield_scene_entities(s, e, 3), SFIELD_OK);
        assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
        set.positions = q;
        set.normals = m;
        set.rgb = after;
        assert_int_equal(sfield_scene_entities(s, r, 3), SFIELD_OK);
        assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
        for (i = 0; i < 30; i++) worst = fmax(worst, fabs((double)after[i] - (double)before[i]));
        CONFORM_MAX("T76", b == 1 ? "all turned, shading differs, harmonics" : "wavelets, the cube resampled",
                    b == 1 ? 1e-4 : 0.04, worst);
        sfield_scene_free(s);
    }
}

static void t79_a_cache_follows_what_moves(void **state)
{
    int b, round;
    (void)state;
    for (b = 1; b < 3; b++) {
        sfield_scene *s = scene_of((sfield_basis)b, SFIELD_PRODUCT_DEFAULT);
        sfield_entity e[4];
        sfield_points set;
        sfield_scene_stats stats;
        float p[3 * 40], n[3 * 40], lazy[3 * 40], fresh[3 * 40], plain[3 * 40];
        uint64_t seed = 4;
        double worst = 0;
        int i;
        for (i = 0; i < 120; i++) {
            p[i] = rnd_in(&seed, -1, 1);
            n[i] = i % 3 == 1;
        }
        e[0] = at(ball[b], NULL, 1, 3, 0);
        e[1] = at(blob[b], NULL, -2, 2, 1);
        e[2] = at(NULL, lamp[b], 3, 6, 1);
        e[3] = at(NULL, lamp[b], -3, 5, -4);
        memset(&set, 0, sizeof set);
        set.count = 40;
        set.positions = p;
        set.normals = n;
        set.entity = 0;
        sfield_scene_environment(s, sky_one, 1, 1, NULL);
        sfield_scene_entities(s, e, 4);
        assert_int_equal(sfield_cache_create(s, 40, 3, &set.cache), SFIELD_OK);
        for (round = 0; round < 6; round++) {
            sfield_cache *kept = set.cache;
            set.rgb = lazy;
            assert_int_equal(sfield_shade(s, &set, 1, &stats), SFIELD_OK);
            if (round == 0 || round == 3) assert_true(stats.reused == 0 && stats.products > 0);
            if (round == 1) assert_true(stats.reused == 120 && stats.products == 0);
            if (round == 2) assert_true(stats.reused > 60);           /* a light moved: most of it is still true */
            assert_int_equal(sfield_cache_create(s, 40, 3, &set.cache), SFIELD_OK);
            set.rgb = fresh;
            assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
            sfield_cache_free(set.cache);
            assert_memory_equal(lazy, fresh, sizeof lazy);
            set.cache = NULL;
            set.rgb = plain;
            assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
            for (i = 0; i < 120; i++) worst = fmax(worst, fabs((double)plain[i] - (double)lazy[i]));
            set.cache = kept;
            if (round == 1) e[2].transform[12] += 0.05f;
            if (round == 2) e[0].transform[13] += 1e-4f;              /* T79: by eps */
            if (round == 3) e[3].tint[1] = 3;
            if (round == 4) e[3].transform[14] = -9;
            sfield_scene_entities(s, e, 4);
        }
        CONFORM_MAX("T79", b == 1 ? "cached against no cache, harmonics" : "against no cache, wavelets",
                    b == 1 ? 1e-3 : 0.05, worst); /* 16 bits; 256 wavelets */
        sfield_cache_free(set.cache);
        sfield_scene_free(s);
    }
}

/* What the cache gave for a set, and what a fresh one gives; the greatest difference, and *most, of the latter. */
static double stale_by(sfield_scene *s, sfield_points *set, size_t count, float *most)
{
    float lazy[3 * 40], fresh[3 * 40];
    sfield_cache *kept = set->cache;
    double worst = 0;
    size_t i;
    set->rgb = lazy;
    assert_int_equal(sfield_shade(s, set, 1, NULL), SFIELD_OK);
    assert_int_equal(sfield_cache_create(s, count, 3, &set->cache), SFIELD_OK);
    set->rgb = fresh;
    assert_int_equal(sfield_shade(s, set, 1, NULL), SFIELD_OK);
    sfield_cache_free(set->cache);
    set->cache = kept;
    for (i = 0; i < 3 * count; i++) {
        worst = fmax(worst, fabs((double)lazy[i] - (double)fresh[i]));
        *most = fmaxf(*most, fresh[i]);
    }
    return worst;
}

/* A body that moves drops the T of lights behind it alone, and nothing where it is out of reach or below the horizon
   (paper 4.2). What is kept equals what a fresh cache computes, to the bit. */
static void t79_a_body_drops_what_lies_behind_it(void **state)
{
    enum { POINTS = 40, LIGHTS = 2, SLOTS = LIGHTS + 1 };
    static const struct { int body, axis; float to; uint64_t reused; } moves[] = {
        { 1, 1, 510, SLOTS * POINTS },      /* out of everybody's reach */
        { 2, 1, -4, SLOTS * POINTS },       /* below the horizon of all */
        { 0, 1, 4.001f, POINTS },           /* before the far lamp and the sky, behind the near lamp */
        { 0, 1, 4.001f, SLOTS * POINTS },   /* nothing */
        { 1, 1, 12, 2 * POINTS },           /* comes in behind both lamps */
        { 1, 1, 12.5f, 2 * POINTS },
        { 0, 1, 4.1f, POINTS },
    };
    int b;
    size_t m, i;
    (void)state;
    for (b = 1; b < 3; b++) {
        sfield_scene *s = scene_of((sfield_basis)b, SFIELD_PRODUCT_DEFAULT);
        sfield_entity e[5];
        sfield_points set;
        sfield_scene_stats stats;
        float p[3 * POINTS], n[3 * POINTS], lazy[3 * POINTS], most = 0;
        uint64_t seed = 4;
        for (i = 0; i < 3 * POINTS; i++) {
            p[i] = (float)rnd_in(&seed, -0.2, 0.2);
            n[i] = i % 3 == 1;
        }
        e[0] = at(ball[b], NULL, 0.5, 4, 0);
        e[1] = at(blob[b], NULL, 0, 500, 0);
        e[2] = at(ball[b], NULL, 1, -3, 0);
        e[3] = at(NULL, lamp[b], 1.4, 1.5, 0);
        e[4] = at(NULL, lamp[b], -1, 8, 0);
        memset(&set, 0, sizeof set);
        set.count = POINTS;
        set.positions = p;
        set.normals = n;
        set.rgb = lazy;
        assert_int_equal(sfield_scene_environment(s, sky_one, 1, 1, NULL), SFIELD_OK);
        assert_int_equal(sfield_scene_entities(s, e, 5), SFIELD_OK);
        assert_int_equal(sfield_cache_create(s, POINTS, SLOTS, &set.cache), SFIELD_OK);
        assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
        for (m = 0; m < sizeof moves / sizeof *moves; m++) {
            e[moves[m].body].transform[12 + moves[m].axis] = moves[m].to;
            set.rgb = lazy;                                           /* stale_by had its own */
            assert_int_equal(sfield_scene_entities(s, e, 5), SFIELD_OK);
            assert_int_equal(sfield_shade(s, &set, 1, &stats), SFIELD_OK);
            if (stats.reused != moves[m].reused)
                fail_msg("basis %d, move %d: %u of %u reused, expected %u", b, (int)m, (unsigned)stats.reused,
                         (unsigned)stats.lights, (unsigned)moves[m].reused);
            assert_true((stats.products > 0) == (moves[m].reused < SLOTS * POINTS));
            assert_true(stale_by(s, &set, POINTS, &most) == 0);
        }
        assert_true(most > 0.3f);
        sfield_cache_free(set.cache);
        sfield_scene_free(s);
    }
}

/* Points that nothing touched get the results of the frame before, whatever is asked for from frame to frame: other
   points, the other result, while a body moves out of reach, and a sky, a lamp and a body that come and go. */
static void t79_what_nothing_touched_is_as_before(void **state)
{
    enum { POINTS = 40 };
    static const float half[3] = { 0.5f, 0.5f, 0.5f };
    int b, frame, i;
    (void)state;
    for (b = 1; b < 3; b++) {
        sfield_scene *s = scene_of((sfield_basis)b, SFIELD_PRODUCT_DEFAULT);
        sfield_entity e[3];
        sfield_points set;
        sfield_scene_stats stats;
        float p[3 * POINTS], n[3 * POINTS], lazy[4][POINTS], fresh[4][POINTS];
        uint8_t visible[POINTS];
        uint64_t seed = 14, repeated = 0;
        for (i = 0; i < 3 * POINTS; i++) {
            p[i] = (float)rnd_in(&seed, -0.2, 0.2);
            n[i] = i % 3 == 1;
        }
        n[3 * 17 + 1] = 0;                                            /* no receiver */
        e[0] = at(ball[b], NULL, 0.5, 4, 0);
        e[1] = at(blob[b], NULL, 0, 500, 0);
        e[2] = at(NULL, lamp[b], 1.4, 1.5, 0);
        memset(&set, 0, sizeof set);
        set.count = POINTS;
        set.positions = p;
        set.normals = n;
        assert_int_equal(sfield_scene_environment(s, sky_one, 1, 1, NULL), SFIELD_OK);
        assert_int_equal(sfield_scene_entities(s, e, 3), SFIELD_OK);
        assert_int_equal(sfield_cache_create(s, POINTS, 3, &set.cache), SFIELD_OK);
        for (frame = 0; frame < 24; frame++) {
            sfield_cache *kept = set.cache;
            size_t bodies = frame == 20 ? 2 : 3;
            for (i = 0; i < POINTS && frame % 5 == 0; i++) visible[i] = (uint8_t)(rnd(&seed) < 0.7);
            e[1].transform[13] = frame == 14 ? 6.0f : 500.0f + (float)(frame / 2);
            e[2].tint[0] = frame < 16 ? 1.0f : 2.0f;
            if (frame == 18) assert_int_equal(sfield_scene_environment(s, half, 1, 1, NULL), SFIELD_OK);
            assert_int_equal(sfield_scene_entities(s, e, bodies), SFIELD_OK);
            set.in_view = frame % 8 < 6 ? visible : NULL;
            set.rgb = frame % 3 ? lazy[0] : NULL;
            set.ambient = frame % 3 != 1 ? lazy[3] : NULL;
            memset(lazy, 0, sizeof lazy);
            memset(fresh, 0, sizeof fresh);
            assert_int_equal(sfield_shade(s, &set, 1, &stats), SFIELD_OK);
            repeated += stats.pairs == 0 && stats.points > 0;         /* no occluder was looked at */
            assert_int_equal(sfield_cache_create(s, POINTS, 3, &set.cache), SFIELD_OK);
            set.rgb = set.rgb ? fresh[0] : NULL;
            set.ambient = set.ambient ? fresh[3] : NULL;
            assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
            sfield_cache_free(set.cache);
            set.cache = kept;
            if (memcmp(lazy, fresh, sizeof lazy) != 0) fail_msg("basis %d, frame %d: not as a fresh cache's", b, frame);
        }
        assert_true(repeated > 2);
        sfield_cache_free(set.cache);
        sfield_scene_free(s);
    }
}

/* Points on an entity that shines and hides nothing: it moves without a new version, as lamps do, but they with it. */
static void t79_points_on_a_lamp_move_with_it(void **state)
{
    int b, round;
    (void)state;
    for (b = 1; b < 3; b++) {
        sfield_scene *s = scene_of((sfield_basis)b, SFIELD_PRODUCT_DEFAULT);
        sfield_entity e[3];
        sfield_points set;
        float p[3 * 40], n[3 * 40], most = 0;
        uint64_t seed = 8;
        double worst = 0;
        int i;
        for (i = 0; i < 120; i++) {
            p[i] = rnd_in(&seed, -0.5, 0.5);
            n[i] = i % 3 == 1;
        }
        e[0] = at(NULL, lamp[b], 0, 0, 0);
        e[1] = at(NULL, lamp[b], 3, 6, 1);
        e[2] = at(ball[b], NULL, 0, 500, 0);                         /* out of everybody's reach */
        memset(&set, 0, sizeof set);
        set.count = 40;
        set.positions = p;
        set.normals = n;
        set.entity = 1;
        assert_int_equal(sfield_scene_environment(s, sky_one, 1, 1, NULL), SFIELD_OK);
        assert_int_equal(sfield_scene_entities(s, e, 3), SFIELD_OK);
        assert_int_equal(sfield_cache_create(s, 40, 3, &set.cache), SFIELD_OK);
        for (round = 0; round < 4; round++) {
            if (round == 1) matrix_of(e[0].transform, 0, 0, 1, PI / 2, 1, 0, 0, 0);
            if (round == 2) e[2].transform[13] = 4;
            if (round == 3) e[0].transform[12] = 1.5f;               /* under the ball */
            assert_int_equal(sfield_scene_entities(s, e, 3), SFIELD_OK);
            worst = fmax(worst, stale_by(s, &set, 40, &most));
        }
        set.entity = 0;
        worst = fmax(worst, stale_by(s, &set, 40, &most));
        assert_true(most > 0.5f);
        CONFORM_MAX("T79", b == 1 ? "points on a moving lamp, harmonics" : "on a moving lamp, wavelets", 0, worst);
        sfield_cache_free(set.cache);
        sfield_scene_free(s);
    }
}

typedef struct arena { size_t used; double memory[1 << 20]; } arena;

static void *arena_alloc(size_t size, void *user)
{
    arena *a = (arena *)user;
    size_t at = a->used;
    a->used += (size + 7) / 8;
    return a->used <= sizeof a->memory / 8 ? a->memory + at : NULL;
}

static void arena_free(void *memory, void *user)
{
    (void)memory;
    (void)user;
}

/* An occluder that is freed and built anew where it lay, of another shape; another scene; another self-visibility. */
static void t79_bodies_that_change_are_not_taken_from_the_cache(void **state)
{
    static arena a;
    static float p[3 * 40], n[3 * 40];
    sfield_scene *s = scene_of(SFIELD_BASIS_SH, SFIELD_PRODUCT_DEFAULT);
    sfield_scene *other = scene_of(SFIELD_BASIS_SH, SFIELD_PRODUCT_DEFAULT);
    model m[2] = { model_box(1, 1, 1), model_box(1, 0.2, 0.2) };
    sfield_field *f, *before = NULL, *self[2];
    sfield_entity e;
    sfield_points set;
    sfield_desc d = small_desc(SFIELD_BASIS_SH);
    float most = 0;
    double worst = 0;
    int round, i;
    (void)state;
    for (i = 0; i < 120; i++) n[i] = i % 3 == 1;
    memset(&set, 0, sizeof set);
    set.count = 40;
    set.positions = p;
    set.normals = n;
    set.entity = 0;
    d.system.allocator.alloc_fn = arena_alloc;
    d.system.allocator.free_fn = arena_free;
    d.system.allocator.user = &a;
    d.radius = 2;
    sfield_scene_environment(s, sky_one, 1, 1, NULL);
    sfield_scene_environment(other, sky_one, 1, 1, NULL);
    assert_int_equal(sfield_cache_create(s, 40, 3, &set.cache), SFIELD_OK);
    for (round = 0; round < 2; round++) {
        sfield_mesh mesh = mesh_of(&m[round]);
        a.used = 0;
        assert_int_equal(sfield_build(&d, &mesh, &f, NULL), SFIELD_OK);
        assert_true(!before || before == f);
        before = f;
        e = at(f, NULL, 0, 2.2, 0);
        assert_int_equal(sfield_scene_entities(s, &e, 1), SFIELD_OK);
        worst = fmax(worst, stale_by(s, &set, 40, &most));
    }
    e = at(ball[1], NULL, 0, 2.2, 0);
    for (round = 0; round < 2; round++) assert_int_equal(sfield_scene_entities(other, &e, 1), SFIELD_OK);
    worst = fmax(worst, stale_by(other, &set, 40, &most));
    memset(&d, 0, sizeof d);
    for (i = 0; i < 2; i++) {
        sfield_mesh mesh = mesh_of(&m[i]);
        assert_int_equal(sfield_build_self(&d, &mesh, AT(p, n, 40), 0.3f, &self[i], NULL), SFIELD_OK);
    }
    for (i = 0; i < 2; i++) {
        set.self = self[i];
        worst = fmax(worst, stale_by(other, &set, 40, &most));
    }
    assert_true(most > 0.3f);
    CONFORM_MAX("T79", "a field rebuilt where it lay, another scene, another self-visibility", 0, worst);
    for (i = 0; i < 2; i++) {
        sfield_free(self[i]);
        model_free(&m[i]);
    }
    sfield_cache_free(set.cache);
    sfield_scene_free(s);
    sfield_scene_free(other);
}

static void t80_overlaps_are_counted_or_refused(void **state)
{
    sfield_scene_desc d;
    sfield_scene *s = scene_of(SFIELD_BASIS_SH, SFIELD_PRODUCT_DEFAULT), *strict;
    sfield_scene_stats stats;
    sfield_entity e[2];
    float rgb[3];
    int k;
    (void)state;
    e[0] = at(ball[1], NULL, 0, 4, 0);
    e[1] = at(NULL, lamp[1], 0, 5, 0);
    assert_int_equal(sfield_scene_entities(s, e, 2), SFIELD_OK);
    shade_up(s, rgb, &stats);
    CONFORM("T80", "overlaps counted", 1, stats.overlaps, 0);
    for (k = 0; k < 3; k++) assert_true(sfield__finite(rgb[k]));
    memset(&d, 0, sizeof d);
    d.strict = 1;
    assert_int_equal(sfield_scene_create(&d, &strict), SFIELD_OK);
    assert_int_equal(sfield_scene_entities(strict, e, 2), SFIELD_ERR_INPUT);
    e[1].transform[13] = 6.01f;
    assert_int_equal(sfield_scene_entities(strict, e, 2), SFIELD_OK);
    sfield_scene_free(strict);
    sfield_scene_free(s);
}

/* All ways of the product on one scene. */
static void all_ways_of_the_product_agree(void **state)
{
    sfield_scene *s;
    sfield_entity e[3];
    float rgb[4][3];
    (void)state;
    for (int m = 0; m < 4; m++) {
        int b = m < 2 ? 1 : 2;
        sfield_field *f = m == 1 ? ball_log : ball[b];
        s = scene_of((sfield_basis)b, (sfield_product_mode)(SFIELD_PRODUCT_TRIPLE + m));
        e[0] = at(f, NULL, 1, 3, 0);
        e[1] = at(f, NULL, -1, 3.5, 1);
        e[2] = at(NULL, lamp[b], 0, 8, 0);
        assert_int_equal(sfield_scene_entities(s, e, 3), SFIELD_OK);
        sfield_scene_environment(s, sky_one, 1, 1, NULL);
        shade_up(s, rgb[m], NULL);
        print_message("product mode %d: %.5f\n", m + 1, (double)rgb[m][0]);
        matrix_of(e[0].transform, 0, 1, 0, 0.7, 1, 1, 3, 0);
        assert_int_equal(sfield_scene_entities(s, e, 3), m == 3 ? SFIELD_ERR_MISMATCH : SFIELD_OK);
        if (m == 2) {
            float turned[3];
            shade_up(s, turned, NULL);
            assert_true(fabsf(turned[0] - rgb[2][0]) < 0.01f);         /* a sphere, whichever way it is turned */
        }
        sfield_scene_free(s);
    }
    assert_true(fabsf(rgb[0][0] - rgb[1][0]) < 0.06f);
    assert_true(fabsf(rgb[2][0] - rgb[3][0]) < 1e-4f);
    assert_true(fabsf(rgb[0][0] - rgb[2][0]) < 0.06f);
    s = scene_of(SFIELD_BASIS_SH, SFIELD_PRODUCT_EXP);
    e[0].occlusion = ball[1];
    assert_int_equal(sfield_scene_entities(s, e, 1), SFIELD_ERR_MISMATCH);
    sfield_scene_free(s);
}

/* What is only scaled is not rotated: 0.9 / mean(0.9, 0.9, 0.9) misses 1 by rounding. Light is that of a field built
   at that size, in bundles, without tables for a resampling. */
static void scaled_is_not_rotated(void **state)
{
    static const double scales[6] = { 0.9, 1.8, 0.45, 1.7, 0.85, 1 };
    static float p[3 * 32], n[3 * 32], rgb[2][3 * 32];
    uint64_t seed = 6;
    int i, k, sparse;
    (void)state;
    for (i = 0; i < 96; i++) {
        p[i] = i % 3 == 1 ? 0 : rnd_in(&seed, -1, 1);
        n[i] = i % 3 == 1;
    }
    for (sparse = 0; sparse < 2; sparse++) {
        const sfield_product_mode mode = sparse ? SFIELD_PRODUCT_SPARSE : SFIELD_PRODUCT_TEXELS;
        sfield_scene_desc d;
        counting c;
        size_t bytes = 0;
        memset(&c, 0, sizeof c);
        memset(&d, 0, sizeof d);
        d.basis = SFIELD_BASIS_HAAR;
        d.cube_side = 16;
        d.product = mode;
        d.system.allocator = counting_allocator(&c);
        for (i = 0; i < 6; i++) {
            sfield_scene *s;
            sfield_entity e = at(ball[2], NULL, 0.2, 2, 0);
            sfield_points set;
            assert_int_equal(sfield_scene_create(&d, &s), SFIELD_OK);
            memset(&set, 0, sizeof set);
            set.count = 32;
            set.positions = p;
            set.normals = n;
            set.entity = 0;
            sfield_scene_environment(s, sky_one, 1, 1, NULL);
            for (k = 0; k < 2; k++) {           /* the same view, once with everything times a power of two */
                const double scale = scales[i] / (k ? 1 : 4), shift = k ? 1 : 0.25;
                float q[3 * 32];
                uint32_t j;
                matrix_of(e.transform, 0, 1, 0, 0, scale, 0.2 * shift, 2 * shift, 0);
                for (j = 0; j < 96; j++) q[j] = (float)((double)p[j] * shift);
                set.positions = q;
                set.rgb = rgb[k];
                assert_int_equal(sfield_scene_entities(s, &e, 1), SFIELD_OK);
                assert_int_equal(s->item[0].map, 0);
                assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
            }
            assert_memory_equal(rgb[0], rgb[1], sizeof rgb[0]);
            assert_true(rgb[0][0] > 0 && rgb[0][0] < 0.99f);
            if (i) assert_int_equal(c.now, bytes);                    /* no size costs more than another */
            bytes = c.now;
            sfield_scene_free(s);
        }
    }
}

/* A rotated entity that only receives: what its points hide from each other turns with it, too. Against the same
   points and mesh, rotated by hand, on no entity. */
static void self_visibility_turns_with_what_only_receives(void **state)
{
    enum { N = 24 };
    static float p[2][3 * N], n[2][3 * N], rgb[2][3 * N];
    model m = model_box(1, 0.05, 1);
    sfield_entity e[2];
    sfield_desc d;
    uint64_t seed = 3;
    double worst = 0, least = 9;
    int b, i, k;
    (void)state;
    memset(&d, 0, sizeof d);
    e[0] = at(NULL, NULL, 0.5, 0, 0);
    matrix_of(e[0].transform, 0, 0, 1, PI / 2, 1, 0.5, 0, 0);
    for (i = 0; i < N; i++) {                   /* beside and below the plate, looking up past it */
        double q[3], up[3] = { 0, 1, 0 }, out[3];
        for (k = 0; k < 3; k++) q[k] = k == 1 ? -0.4 : rnd(&seed) * 2 - 1;
        for (k = 0; k < 3; k++) {
            p[0][3 * i + k] = (float)q[k];
            n[0][3 * i + k] = (float)up[k];
        }
        turn(e[0].transform, q, out);
        for (k = 0; k < 3; k++) p[1][3 * i + k] = (float)(out[k] + (k == 0 ? 0.5 : 0));
        turn(e[0].transform, up, out);
        for (k = 0; k < 3; k++) n[1][3 * i + k] = (float)out[k];
    }
    for (b = 1; b < 3; b++) {
        model turned = model_box(0.05, 1, 1);
        sfield_mesh mesh[2];
        sfield_scene *s = scene_of((sfield_basis)b, SFIELD_PRODUCT_DEFAULT);
        sfield_points set;
        mesh[0] = mesh_of(&m);
        mesh[1] = mesh_of(&turned);
        for (k = 0; k < (int)turned.vertices; k++) turned.p[3 * k] += 0.5f;
        d.basis = (sfield_basis)b;
        d.cube_side = 16;
        d.keep = 1;
        sfield_scene_environment(s, sky_one, 1, 1, NULL);
        e[1] = at(NULL, lamp[b], -3, 5, 1);
        assert_int_equal(sfield_scene_entities(s, e, 2), SFIELD_OK);
        for (k = 0; k < 2; k++) {
            sfield_field *self;
            assert_int_equal(sfield_build_self(&d, &mesh[k], AT(p[k], n[k], N),
                                               0.01f, &self, NULL), SFIELD_OK);
            memset(&set, 0, sizeof set);
            set.count = N;
            set.positions = p[k];
            set.normals = n[k];
            set.entity = k ? 0 : 1;
            set.self = self;
            set.rgb = rgb[k];
            assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
            if (b == 2 && k == 0) {
                sfield_scene *sparse = scene_of(SFIELD_BASIS_HAAR, SFIELD_PRODUCT_SPARSE);
                assert_int_equal(sfield_scene_entities(sparse, e, 2), SFIELD_OK);
                assert_int_equal(sfield_shade(sparse, &set, 1, NULL), SFIELD_ERR_MISMATCH);
                set.self = NULL;
                set.rgb = rgb[1];                                     /* written over below */
                assert_int_equal(sfield_shade(sparse, &set, 1, NULL), SFIELD_OK);
                sfield_scene_free(sparse);
            }
            sfield_free(self);
        }
        for (i = 0; i < 3 * N; i += 3) {
            worst = fmax(worst, fabs((double)rgb[0][i] - (double)rgb[1][i]));
            least = fmin(least, (double)rgb[1][i]);
        }
        print_message("self on a receiver, basis %d: off by %.4f, the darkest %.3f\n", b, worst, least);
        assert_true(least < 0.8 && worst < 0.02);                     /* both are resampled or quantised once */
        model_free(&turned);
        sfield_scene_free(s);
    }
    model_free(&m);
}

/* Products are symmetric: incident radiance far to near against T near to far gives the same sum. */
static void incident_radiance_sums_to_what_is_shaded(void **state)
{
    sfield_scene *s = scene_of(SFIELD_BASIS_SH, SFIELD_PRODUCT_TRIPLE);
    sfield_entity e[4];
    float rgb[3], l[48], factors[8], p[3] = { 0, 0, 0 }, up[3] = { 0, 1, 0 };
    double y[16], d[3] = { 0, 1, 0 }, sum;
    sfield_points set;
    uint32_t k, c, b;
    (void)state;
    e[0] = at(blob[1], NULL, 1, 2, 0);
    e[1] = at(NULL, lamp[1], 2, 3, 0);
    e[2] = at(ball[1], NULL, -1, 4, 2);
    e[3] = at(NULL, lamp[1], 0, 9, 0);
    matrix_of(e[3].transform, 1, 0, 1, 1, 2, 0, 9, 0);
    sfield_scene_entities(s, e, 4);
    sfield_scene_environment(s, sky_one, 1, 1, NULL);
    shade_up(s, rgb, NULL);
    memset(&set, 0, sizeof set);
    set.count = 1;
    set.positions = p;
    set.normals = up;
    set.entity = 0;
    assert_int_equal(sfield_incident(s, &set, l), SFIELD_OK);
    sfield_sh_cosine(4, factors);
    sfield_sh_basis(4, d, y);
    for (c = 0; c < 3; c++) {
        for (b = 0, k = 0, sum = 0; b < 4; b++)
            for (; k < (b + 1) * (b + 1); k++) sum += (double)factors[b] * y[k] * (double)l[16 * c + k];
        assert_true(fabs(sum / PI - (double)rgb[c]) < 1e-4);
    }
    sfield_scene_free(s);
}

/* Of all directions: a ball below a floor's horizon hides as much as one above it. */
static void incident_radiance_comes_from_below_too(void **state)
{
    static const float p[3] = { 0, 0, 0 }, normal[2][3] = { { 0, 1, 0 }, { 0, -1, 0 } };
    sfield_scene *s = scene_of(SFIELD_BASIS_SH, SFIELD_PRODUCT_TRIPLE);
    sfield_entity e = at(ball[1], NULL, 0, -3, 0);
    float l[2][48];
    int i;
    (void)state;
    sfield_scene_entities(s, &e, 1);
    sfield_scene_environment(s, sky_one, 1, 1, NULL);
    for (i = 0; i < 2; i++) {
        sfield_points set;
        memset(&set, 0, sizeof set);
        set.count = 1;
        set.positions = p;
        set.normals = normal[i];
        set.entity = 0;
        assert_int_equal(sfield_incident(s, &set, l[i]), SFIELD_OK);
        print_message("normal %g: %.5f of %.5f\n", (double)normal[i][1], (double)l[i][0] / sqrt(4 * PI),
                      1 - blocked(3));
        assert_true(fabs((double)l[i][0] / sqrt(4 * PI) - 1 + blocked(3)) < 0.002);
    }
    assert_memory_equal(l[0], l[1], sizeof l[0]);
    sfield_scene_free(s);
}

static void skies_and_suns_light_and_turn(void **state)
{
    static float map[3 * 64 * 32];
    static const float sun[3] = { 0, 1, 0 }, strength[3] = { 3, 2, 1 };
    int b, i;
    (void)state;
    for (i = 0; i < 64 * 32; i++) map[3 * i] = i % 64 >= 32 ? 1.0f : 0.0f;      /* red light from +Z */
    for (b = 1; b < 3; b++) {
        sfield_scene *s = scene_of((sfield_basis)b, SFIELD_PRODUCT_DEFAULT);
        float rgb[3], m[16];
        sfield_scene_entities(s, NULL, 0);
        assert_int_equal(sfield_scene_environment(s, map, 64, 32, NULL), SFIELD_OK);
        shade_up(s, rgb, NULL);
        assert_true(fabsf(rgb[0] - 0.5f) < 0.01f && fabsf(rgb[1]) < 1e-4f);
        matrix_of(m, 1, 0, 0, -PI / 2, 1, 0, 0, 0);                   /* +Z comes to +Y */
        assert_int_equal(sfield_scene_turn(s, m), SFIELD_OK);
        shade_up(s, rgb, NULL);
        assert_true(fabsf(rgb[0] - 1) < 0.02f);
        matrix_of(m, 1, 0, 0, PI / 2, 1, 0, 0, 0);
        sfield_scene_turn(s, m);
        shade_up(s, rgb, NULL);
        assert_true(fabsf(rgb[0]) < 0.02f);
        assert_int_equal(sfield_scene_sun(s, sun, strength), SFIELD_OK);
        shade_up(s, rgb, NULL);
        print_message("basis %d: sun above %.4f %.4f of E / pi %.4f %.4f\n", b, (double)rgb[0], (double)rgb[1], 3 / PI,
                      2 / PI);
        assert_true(fabs((double)rgb[1] * PI / 2 - 1) < (b == 1 ? 0.07 : 0.02));
        assert_int_equal(sfield_scene_environment(s, NULL, 0, 0, NULL), SFIELD_OK);
        shade_up(s, rgb, NULL);
        assert_true(rgb[0] == 0 && rgb[1] == 0);
        sfield_scene_free(s);
    }
}

static void a_phong_lobe_reflects_all_of_a_white_sky(void **state)
{
    static const float exponents[3] = { 1, 8, 30 };
    float p[9] = { 0 }, n[9] = { 0, 1, 0, 0, 1, 0, 0, 1, 0 }, rgb[9], gloss[9];
    sfield_scene *s = scene_of(SFIELD_BASIS_SH, SFIELD_PRODUCT_TRIPLE);
    sfield_points set;
    int i;
    (void)state;
    memset(&set, 0, sizeof set);
    set.count = 3;
    set.positions = p;
    set.normals = n;
    set.to_eye = n;
    set.exponents = exponents;
    set.exponent_stride = 4;
    set.entity = 0;
    set.rgb = rgb;
    set.gloss = gloss;
    sfield_scene_entities(s, NULL, 0);
    sfield_scene_environment(s, sky_one, 1, 1, NULL);
    assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
    for (i = 0; i < 3; i++) {                                         /* the lobe is scaled to reflect all of it */
        print_message("Phong, n = %g: %.4f of 1\n", (double)exponents[i], (double)gloss[3 * i]);
        assert_true(fabsf(gloss[3 * i] - 1) < 0.07f && fabsf(rgb[3 * i] - 1) < 1e-3f);
    }
    sfield_scene_free(s);
}

/* A latitude-longitude sky counts by solid angle: its mean is the first coefficient over that of 1. */
static void t11_t12_skies_count_by_solid_angle(void **state)
{
    enum { WIDE = 72, HIGH = 36 };
    static float sky[3 * WIDE * HIGH];
    double share[2];
    (void)state;
    for (int whole = 0; whole < 2; whole++) {
        sfield_scene *s = scene_of(SFIELD_BASIS_SH, SFIELD_PRODUCT_TRIPLE);
        float coefs[3 * 16];
        for (int y = 0; y < HIGH; y++)
            for (int i = 0; i < 3 * WIDE; i++) sky[3 * WIDE * y + i] = whole || y < HIGH / 6 ? 1 : 0;
        assert_int_equal(sfield_scene_environment(s, sky, WIDE, HIGH, NULL), SFIELD_OK);
        assert_int_equal(sfield_scene_sky(s, coefs), SFIELD_OK);
        share[whole] = (double)coefs[0] / sqrt(4 * PI);
        sfield_scene_free(s);
    }
    CONFORM("T11", "share of a cap of 30 degrees in a sky of harmonics", 0.0669873, share[0], 1e-6);
    CONFORM("T12", "share of a uniform sky in a sky of harmonics", 1, share[1], 1e-5);
}

/* A sun of one texel anywhere in a map, coarse or fine, is its radiance times its solid angle; alone, and in a sky. */
static void t12_a_sun_of_one_texel_has_its_flux(void **state)
{
    static const uint32_t sizes[8][2] = { { 8, 4 }, { 36, 18 }, { 64, 32 }, { 100, 700 }, { 1024, 512 }, { 2048, 1024 },
                                          { 8192, 32 }, { 32, 4096 } };
    double worst[2] = { 0, 0 };
    int m, i, k, high;
    (void)state;
    for (high = 0; high < 2; high++) {
        sfield_scene *s = NULL;
        sfield_scene_desc d;
        memset(&d, 0, sizeof d);
        d.cube_side = high ? 32 : 0;
        assert_int_equal(sfield_scene_create(&d, &s), SFIELD_OK);
        for (m = 0; m < 8; m++) {
            const uint32_t wide = sizes[m][0], rows = sizes[m][1];
            float *map = (float *)calloc((size_t)wide * rows, 3 * sizeof *map), coefs[3 * 16];
            uint64_t seed = 12 + (uint64_t)m;
            assert_non_null(map);
            for (i = 0; i < (int)(wide * rows); i++) map[3 * i + 1] = 1;             /* green: with a sky of 1 */
            for (i = 0; i < (m < 4 ? 12 : 4); i++) {
                const uint32_t x = rnd_below(&seed, wide), y = i ? rnd_below(&seed, rows) : rows / 2;
                const double exact = 1e4 * 2 * PI / wide * (cos(PI * y / rows) - cos(PI * (y + 1) / rows));
                float *texel = map + 3 * ((size_t)y * wide + x);
                texel[0] = 1e4f;
                texel[1] = 1e4f + 1;
                assert_int_equal(sfield_scene_environment(s, map, wide, rows, NULL), SFIELD_OK);
                assert_int_equal(sfield_scene_sky(s, coefs), SFIELD_OK);
                texel[0] = 0;
                texel[1] = 1;
                for (k = 0; k < 2; k++) {
                    const double want = exact + k * 4 * PI;
                    worst[k] = fmax(worst[k], fabs((double)coefs[16 * k] * sqrt(4 * PI) / want - 1));
                }
            }
            free(map);
        }
        sfield_scene_free(s);
    }
    CONFORM_MAX("T12", "a sun of one texel in a sky of harmonics, relative", 1e-5, worst[0]);        /* of floats */
    CONFORM_MAX("T12", "a sun of one texel and a sky of 1, relative", 1e-5, worst[1]);
}

/* The lobe lies round the view's mirror image: a lamp there shines into it, one where the eye is does not. */
static void phong_lobe_is_mirrored(void **state)
{
    static const float exponent = 4, p[3] = { 0, 0, 0 }, up[3] = { 0, 1, 0 };
    static const float views[2][3] = { { -0.6f, 0.8f, 0 }, { 0.6f, 0.8f, 0 } };
    sfield_scene *s = scene_of(SFIELD_BASIS_SH, SFIELD_PRODUCT_TRIPLE);
    sfield_entity e = at(NULL, lamp[1], 6, 8, 0);
    float rgb[3], gloss[2][3];
    (void)state;
    assert_int_equal(sfield_scene_entities(s, &e, 1), SFIELD_OK);
    for (int i = 0; i < 2; i++) {
        sfield_points set;
        memset(&set, 0, sizeof set);
        set.count = 1;
        set.positions = p;
        set.normals = up;
        set.entity = 0;
        set.to_eye = views[i];
        set.exponents = &exponent;
        set.rgb = rgb;
        set.gloss = gloss[i];
        assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
    }
    /* L V cos times (n + 2) / 2 cos^n, beside rgb: 3 in the middle of the lobe, 0.02 at cos 73.7 degrees. Four bands
       flatten the peak to 2.2. */
    print_message("lobe at the lamp %.3f of rgb, at the eye %.3f\n", (double)(gloss[0][0] / rgb[0]),
                  (double)(gloss[1][0] / rgb[0]));
    assert_true(gloss[0][0] / rgb[0] > 1.9f && gloss[0][0] / rgb[0] < 3);
    assert_true(fabsf(gloss[1][0] / rgb[0]) < 0.2f);
    sfield_scene_free(s);
}

/* Beyond `reach` radii an occluder is not there; over the last quarter of them it fades in proportion. */
static void reach_is_in_radii(void **state)
{
    static const float reaches[4] = { 0, 3.5f, 6, 4.6f };
    float rgb[4][3], fade;
    sfield_info info;
    sfield_entity e = at(ball[1], NULL, 0, 4, 0);
    (void)state;
    sfield_get_info(ball[1], &info);
    for (int i = 0; i < 4; i++) {
        sfield_scene_desc d;
        sfield_scene *s;
        memset(&d, 0, sizeof d);
        d.basis = SFIELD_BASIS_SH;
        d.reach = reaches[i];
        assert_int_equal(sfield_scene_create(&d, &s), SFIELD_OK);
        sfield_scene_entities(s, &e, 1);
        sfield_scene_environment(s, sky_one, 1, 1, NULL);
        shade_up(s, rgb[i], NULL);
        sfield_scene_free(s);
    }
    assert_true(rgb[0][0] < 0.96f);                                   /* 1 - 1 / 16 */
    assert_true(fabsf(rgb[1][0] - 1) < 1e-3f);
    assert_true(fabsf(rgb[2][0] - rgb[0][0]) < 1e-6f);
    fade = 4 * (1 - 4 / (4.6f * info.radius));
    print_message("fading: %.5f of the shadow, %.5f wanted\n", (double)((1 - rgb[3][0]) / (1 - rgb[0][0])),
                  (double)fade);
    assert_true(fabsf((1 - rgb[3][0]) / (1 - rgb[0][0]) - fade) < 0.02f);
}

static void pairs_that_cannot_matter_are_culled(void **state)
{
    sfield_scene *s = scene_of(SFIELD_BASIS_SH, SFIELD_PRODUCT_TRIPLE);
    sfield_entity e[4];
    sfield_scene_stats stats;
    float rgb[3], one[3];
    (void)state;
    e[0] = at(ball[1], NULL, 0, 3, 0);
    sfield_scene_entities(s, e, 1);
    sfield_scene_environment(s, sky_one, 1, 1, NULL);
    shade_up(s, one, NULL);
    e[1] = at(ball[1], NULL, 0, 20, 0);                               /* too far: 12 r */
    e[2] = at(ball[1], NULL, 1, -3, 0);                               /* below the horizon */
    e[3] = at(blob[1], NULL, 0, 8, 0);                                /* behind the ball */
    sfield_scene_entities(s, e, 4);
    shade_up(s, rgb, &stats);
    assert_true(stats.pairs == 1 * 4 && stats.culled_horizon == 1 && stats.culled_hidden == 1 && stats.culled_far == 1);
    assert_true(stats.products == 1 && rgb[0] == one[0]);
    sfield_scene_free(s);
}

static void reversed(void *user, size_t count, sfield_task task, void *context)
{
    (void)user;
    while (count-- > 0) task(context, count);
}

static void results_are_the_same_in_any_order_of_tasks(void **state)
{
    int b;
    (void)state;
    for (b = 1; b < 3; b++) {
        float p[300], n[300], rgb[2][300], ambient[100];
        uint8_t visible[100];
        uint64_t seed = 5;
        int i, k;
        for (i = 0; i < 300; i++) {
            p[i] = rnd_in(&seed, -2, 2);
            n[i] = i % 3 == 1;
        }
        for (i = 0; i < 100; i++) visible[i] = i % 7 != 0;
        p[30] = NAN;
        for (k = 0; k < 2; k++) {
            sfield_scene_desc d;
            sfield_scene *s;
            sfield_points set;
            sfield_entity e[2];
            memset(&d, 0, sizeof d);
            d.basis = (sfield_basis)b;
            d.cube_side = 16;
            d.system.parallel_for = k ? reversed : NULL;
            assert_int_equal(sfield_scene_create(&d, &s), SFIELD_OK);
            e[0] = at(blob[b], NULL, 0, 2, 0);
            e[1] = at(NULL, lamp[b], 0, 5, 0);
            sfield_scene_entities(s, e, 2);
            memset(&set, 0, sizeof set);
            set.count = 100;
            set.positions = p;
            set.normals = n;
            set.entity = 0;
            set.in_view = visible;
            set.rgb = rgb[k];
            set.ambient = ambient;
            assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
            sfield_scene_free(s);
        }
        assert_memory_equal(rgb[0], rgb[1], sizeof rgb[0]);
        for (i = 0; i < 100; i++) {
            if (i % 7 == 0 || i == 10) assert_true(rgb[0][3 * i] == 0 && ambient[i] == 0);
            else assert_true(ambient[i] > 0.05f && ambient[i] < 1.1f && rgb[0][3 * i] > 0);
        }
    }
}

/* Points of a box in a corner: half of what a face sees of the sky is hidden by nothing, an inner face's all. */
static void self_visibility_darkens_points_inside(void **state)
{
    int b;
    (void)state;
    for (b = 1; b < 3; b++) {
        model m = model_box(1, 1, 1);
        sfield_mesh mesh = mesh_of(&m);
        float p[6] = { 0, 1, 0, 0, 0.5f, 0 }, n[6] = { 0, 1, 0, 0, 1, 0 }, rgb[6];
        sfield_desc d;
        sfield_field *self;
        sfield_scene *s = scene_of((sfield_basis)b, SFIELD_PRODUCT_DEFAULT);
        sfield_entity e = at(NULL, NULL, 5, 5, 5);
        sfield_points set;
        memset(&d, 0, sizeof d);
        d.basis = (sfield_basis)b;
        d.cube_side = 16;
        d.keep = 1;
        d.keep_inside = 1;                                            /* the second point lies inside: dark */
        assert_int_equal(sfield_build_self(&d, &mesh, AT(p, n, 2), 1e-3f, &self, NULL), SFIELD_OK);
        matrix_of(e.transform, 1, 0, 0, b == 1 ? 0.5 : 0, 2, 5, 5, 5);
        sfield_scene_entities(s, &e, 1);
        sfield_scene_environment(s, sky_one, 1, 1, NULL);
        memset(&set, 0, sizeof set);
        set.count = 2;
        set.positions = p;
        set.normals = n;
        set.entity = 1;
        set.self = self;
        set.rgb = rgb;
        assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
        assert_true(fabsf(rgb[0] - 1) < 0.02f && fabsf(rgb[3]) < 0.01f);
        sfield_free(self);
        sfield_scene_free(s);
        model_free(&m);
    }
}

/* ---- points of what shines ---- */

enum { GLOW = 60 };

/* Points of a unit ball, each its own normal, in its space. */
static void points_of_a_ball(sfield_points *set, float p[3 * GLOW])
{
    uint64_t seed = 21;
    int i, k;
    for (i = 0; i < GLOW; i++) {
        double d[3];
        rnd_direction(&seed, d);
        for (k = 0; k < 3; k++) p[3 * i + k] = (float)d[k];
    }
    memset(set, 0, sizeof *set);
    set->count = GLOW;
    set->entity = 1;
    set->positions = set->normals = p;
}

/* A glowing ball, turned and moved, and a lamp, a sphere of radiance 1 at distance d whose sine is 1 / d: rgb against
   what the lamp alone gives, in closed form: max(0, cos) / d^2, harmonics with the bands of the cosine and of the disc
   that the lamp is seen as. Points for which its edge crosses their horizon are left out. */
static void a_glowing_ball_lights_not_itself(void **state)
{
    int b, i, k;
    (void)state;
    for (b = 1; b < 3; b++) {
        sfield_scene *s = scene_of((sfield_basis)b, SFIELD_PRODUCT_DEFAULT);
        sfield_entity e[2];
        sfield_points set[2];
        sfield_scene_stats stats;
        float p[3 * GLOW], rgb[3 * GLOW], near[3];
        static const float beside[3] = { 0, 0, 2.5f }, facing[3] = { 0, 0, -1 };
        double worst = 0, most = 0;
        int lit = 0;
        e[0] = at(ball[b], lamp[b], 0, 0, 0);
        e[0].transform[0] = e[0].transform[10] = 0.6f;
        e[0].transform[2] = -(e[0].transform[8] = 0.8f);
        for (k = 0; k < 3; k++) e[0].tint[k] = 420;
        e[1] = at(NULL, lamp[b], 1, 5, 2);
        sfield_scene_entities(s, e, 2);
        points_of_a_ball(&set[0], p);
        set[0].rgb = rgb;
        set[1] = set[0];
        set[1].count = 1;
        set[1].positions = beside;
        set[1].normals = facing;
        set[1].entity = 0;
        set[1].rgb = near;
        assert_int_equal(sfield_shade(s, set, 2, &stats), SFIELD_OK);
        assert_true(stats.lights == GLOW + 2);
        assert_true(near[0] > 20);              /* others see it glow */
        for (i = 0; i < GLOW; i++) {
            double v[3], d2 = 0, height = 0, x[3], sine2, cosine, c, exact;
            x[0] = 0.6 * (double)p[3 * i] + 0.8 * (double)p[3 * i + 2];
            x[1] = (double)p[3 * i + 1];
            x[2] = -0.8 * (double)p[3 * i] + 0.6 * (double)p[3 * i + 2];
            for (k = 0; k < 3; k++) {
                v[k] = (k == 0 ? 1 : k == 1 ? 5 : 2) - x[k];
                d2 += v[k] * v[k];
                height += v[k] * x[k];
            }
            if (fabs(height) < 1) continue;
            sine2 = 1 / d2;
            cosine = sqrt(1 - sine2);
            c = height / sqrt(d2);
            exact = c > 0 ? c * sine2 : 0;
            if (b == 1)
                exact = 2 * (1 - cosine) *
                        (0.25 + 0.5 * c * (1 + cosine) / 2 + 0.3125 * (1.5 * c * c - 0.5) * cosine * (1 + cosine) / 2);
            worst = fmax(worst, fabs((double)rgb[3 * i] - exact));
            most = fmax(most, exact);
            lit += c > 0;
        }
        print_message("basis %d: off by %.2e of %.2e at most, %d points lit\n", b, worst, most, lit);
        assert_true(lit > 10 && most > 0.03 && worst < 1.5e-3);      /* 8 bits a coefficient, texels */
        sfield_scene_free(s);
    }
}

/* All outputs, with the lazy cache as well, are those of the same scene in which it does not glow. */
static void a_glow_changes_nothing_of_its_own(void **state)
{
    static float p[3 * GLOW], out[2][10 * GLOW], coefs[2][48 * GLOW];
    static const float exponent = 9;
    int b, round, glows;
    (void)state;
    for (b = 1; b < 3; b++) {
        sfield_scene *s[2];
        sfield_points set[2];
        sfield_entity e[4];
        e[0] = at(blob[b], NULL, 1, 3, 0);
        e[1] = at(NULL, lamp[b], 2, 6, 1);
        e[2] = at(ball[b], NULL, 0, 0, 0);
        e[3] = at(NULL, lamp[b], -3, 4, -2);
        for (glows = 0; glows < 2; glows++) {
            s[glows] = scene_of((sfield_basis)b, SFIELD_PRODUCT_DEFAULT);
            sfield_scene_environment(s[glows], sky_one, 1, 1, NULL);
            points_of_a_ball(&set[glows], p);
            set[glows].entity = 3;
            set[glows].rgb = out[glows];
            set[glows].ambient = out[glows] + 9 * GLOW;
        }
        for (round = 0; round < 5; round++) {
            sfield_scene_stats stats[2];
            memset(out, 0, sizeof out);
            if (round == 2) e[3].transform[13] = 3.5f;
            for (glows = 0; glows < 2; glows++) {
                sfield_points *q = &set[glows];
                e[2].source = glows ? lamp[b] : NULL;
                e[2].tint[0] = 420;
                sfield_scene_entities(s[glows], e, 4);
                if (round == 1) assert_int_equal(sfield_cache_create(s[glows], GLOW, 4, &q->cache), SFIELD_OK);
                if (round == 4 && b == 1) {     /* a lobe besides */
                    q->to_eye = p;
                    q->exponents = &exponent;
                    q->gloss = out[glows] + 6 * GLOW;
                    assert_int_equal(sfield_incident(s[glows], q, coefs[glows]), SFIELD_OK);
                }
                assert_int_equal(sfield_shade(s[glows], q, 1, &stats[glows]), SFIELD_OK);
            }
            assert_memory_equal(out[0], out[1], sizeof out[0]);
            assert_true(out[0][0] != 0 && stats[0].lights == stats[1].lights && stats[0].reused == stats[1].reused);
            assert_true((round == 2 || round == 3) == (stats[1].reused > 0) || round == 4);
        }
        assert_memory_equal(coefs[0], coefs[1], sizeof coefs[0]);
        for (glows = 0; glows < 2; glows++) {
            sfield_cache_free(set[glows].cache);
            sfield_scene_free(s[glows]);
        }
    }
}

static void light_of_sparse_points_is_spread_to_all(void **state)
{
    enum { N = 400 };
    float p[3 * N], n[3 * N], w[3 * N], rgb[3 * N], out[3 * N];
    uint32_t chosen[N], sources[3 * N], i;
    size_t count;
    (void)state;
    for (i = 0; i < N; i++) {
        p[3 * i] = (float)(i % 20) * 0.05f;
        p[3 * i + 1] = 0;
        p[3 * i + 2] = (float)(i / 20) * 0.05f;
        n[3 * i] = n[3 * i + 2] = 0;
        n[3 * i + 1] = 1;
    }
    assert_int_equal(sfield_sparse(AT(p, n, N), 0.2f, NULL, chosen, &count, sources, w), SFIELD_OK);
    assert_true(count >= 16 && count <= 49);
    for (i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) rgb[3 * i + (uint32_t)k] = p[3 * chosen[i]] + 2 * p[3 * chosen[i] + 2];
    assert_int_equal(sfield_spread(N, sources, w, count, rgb, out), SFIELD_OK);
    for (i = 0; i < N; i++) {
        float sum = w[3 * i] + w[3 * i + 1] + w[3 * i + 2];
        assert_true(fabsf(sum - 1) < 1e-5f);
        assert_true(fabsf(out[3 * i] - p[3 * i] - 2 * p[3 * i + 2]) < 0.45f);
    }
    for (i = 0; i < count; i++) assert_true(fabsf(out[3 * chosen[i]] - rgb[3 * i]) < 1e-3f);
    sources[7] = (uint32_t)count;
    assert_int_equal(sfield_spread(N, sources, w, count, rgb, out), SFIELD_ERR_INPUT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sphere_hides_its_share_of_a_uniform_sky),
        cmocka_unit_test(t76_turning_everything_changes_nothing),
        cmocka_unit_test(t78_only_a_nearer_ball_hides_the_lamp),
        cmocka_unit_test(t78_the_order_is_decided_inside_a_tile),
        cmocka_unit_test(t79_a_cache_follows_what_moves),
        cmocka_unit_test(t79_a_body_drops_what_lies_behind_it),
        cmocka_unit_test(t79_what_nothing_touched_is_as_before),
        cmocka_unit_test(t79_points_on_a_lamp_move_with_it),
        cmocka_unit_test(t79_bodies_that_change_are_not_taken_from_the_cache),
        cmocka_unit_test(t80_overlaps_are_counted_or_refused),
        cmocka_unit_test(all_ways_of_the_product_agree),
        cmocka_unit_test(scaled_is_not_rotated),
        cmocka_unit_test(self_visibility_turns_with_what_only_receives),
        cmocka_unit_test(incident_radiance_sums_to_what_is_shaded),
        cmocka_unit_test(incident_radiance_comes_from_below_too),
        cmocka_unit_test(skies_and_suns_light_and_turn),
        cmocka_unit_test(t11_t12_skies_count_by_solid_angle),
        cmocka_unit_test(t12_a_sun_of_one_texel_has_its_flux),
        cmocka_unit_test(a_phong_lobe_reflects_all_of_a_white_sky),
        cmocka_unit_test(phong_lobe_is_mirrored),
        cmocka_unit_test(reach_is_in_radii),
        cmocka_unit_test(pairs_that_cannot_matter_are_culled),
        cmocka_unit_test(results_are_the_same_in_any_order_of_tasks),
        cmocka_unit_test(self_visibility_darkens_points_inside),
        cmocka_unit_test(a_glowing_ball_lights_not_itself),
        cmocka_unit_test(a_glow_changes_nothing_of_its_own),
        cmocka_unit_test(light_of_sparse_points_is_spread_to_all),
    };
    return cmocka_run_group_tests(tests, make_fields, free_fields);
}
