/* crowd_test - scenes of many bodies and lamps: what the hierarchy of occluders leaves out, and which lamps lie behind
   all occluders without being asked one by one, changes no bit of light and no count, wherever bodies stand and
   whatever their size. */
#define SFIELD_STATIC
#define SHADOWFIELD_IMPLEMENTATION
#include "shadowfield.h"
#include "util.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

enum { MOST = 300, POINTS = 70, FRAMES = 3, ALL = 65535 };

typedef struct kind {               /* of scenes, with their fields */
    const char         *name;
    sfield_basis        basis;
    sfield_product_mode product;
    int                 logarithm;
    sfield_field       *body, *lamp;
} kind;

static kind kinds[] = {
    { "harmonics", SFIELD_BASIS_SH, SFIELD_PRODUCT_TRIPLE, 0, NULL, NULL },
    { "logarithms", SFIELD_BASIS_SH, SFIELD_PRODUCT_EXP, 1, NULL, NULL },
    { "texels", SFIELD_BASIS_HAAR, SFIELD_PRODUCT_TEXELS, 0, NULL, NULL },
};
enum { KINDS = sizeof kinds / sizeof *kinds };

static int make_fields(void **state)
{
    int i;
    (void)state;
    for (i = 0; i < KINDS; i++) {
        model m = model_box(0.5, 0.3, 0.4);
        sfield_mesh mesh = mesh_of(&m);
        sfield_desc d = small_desc(kinds[i].basis);
        sfield_emitter e;
        memset(&e, 0, sizeof e);
        e.radius = 0.2f;
        e.radiance[0] = 20;
        e.radiance[1] = 10;
        d.logarithm = kinds[i].logarithm;
        assert_int_equal(sfield_build(&d, &mesh, &kinds[i].body, NULL), SFIELD_OK);
        d.logarithm = 0;
        assert_int_equal(sfield_build_emitter(&d, &e, &kinds[i].lamp, NULL), SFIELD_OK);
        model_free(&m);
    }
    return 0;
}

static int free_fields(void **state)
{
    int i;
    (void)state;
    for (i = 0; i < KINDS; i++) {
        sfield_free(kinds[i].body);
        sfield_free(kinds[i].lamp);
    }
    return 0;
}

/* Takes the hierarchy of a scene away: all occluders come one after the other, as they stand in the list. */
static void look_at_all(sfield_scene *s)
{
    uint32_t i;
    s->tree.levels = 0;
    for (i = 0; i < s->occluder_count; i++) s->tree.order[i] = s->occluder[i];
}

/* Bodies, and lamps for every eighth of them, in a box that is `wide`: some stand where another one does, some are
   tiny or huge, one in five is turned, and some shine as well. Mirrored: every other one stands as far to the left as
   the one before it to the right. */
static void scatter(uint64_t *seed, const kind *k, uint32_t count, double wide, int mirrored, sfield_entity *e)
{
    uint32_t i, axis;
    for (i = 0; i < count; i++, e++) {
        const double how = rnd(seed), scale = how < 0.05 ? 1e-12 : how < 0.1 ? 30 : exp(rnd(seed) * 3 - 2);
        const int turned = rnd(seed) < 0.2;
        double at[3];
        memset(e, 0, sizeof *e);
        for (axis = 0; axis < 3; axis++) {
            at[axis] = (rnd(seed) - 0.5) * wide;
            e->tint[axis] = 1;
        }
        matrix_of(e->transform, 1, 2, -1, turned ? rnd(seed) : 0, scale, at[0], at[1], at[2]);
        if (i % 7 == 3) memcpy(e->transform + 12, (e - 2)->transform + 12, 3 * sizeof(float));
        if (mirrored && i % 2) {
            memcpy(e->transform, (e - 1)->transform, sizeof e->transform);
            e->transform[12] = -e->transform[12];
        }
        if (i % 8 != 5) e->occlusion = k->body;
        if (i % 8 == 5 || i % 16 == 2) e->source = k->lamp;
    }
}

typedef struct crowd { uint64_t seed; uint32_t count; double wide; int mirrored, lazy; } crowd;

/* Shades points on no entity and on one, with a lazy cache or none, while bodies move; results and counts. all: with
   every body looked at. */
static void shade_frames(const kind *k, const crowd *c, int all, float *rgb, sfield_scene_stats *stats)
{
    const uint32_t count = c->count;
    uint64_t seed = c->seed;
    static const float white[3] = { 1, 1, 1 };
    sfield_scene_desc d;
    sfield_entity e[MOST];
    sfield_points set[2];
    sfield_scene *s;
    float p[3 * POINTS], n[3 * POINTS];
    uint32_t i, axis, frame;
    memset(&d, 0, sizeof d);
    d.basis = k->basis;
    d.product = k->product;
    d.cube_side = 8;
    d.reach = count % 2 ? 1.5f : 0.0f;
    assert_int_equal(sfield_scene_create(&d, &s), SFIELD_OK);
    assert_int_equal(sfield_scene_environment(s, white, 1, 1, NULL), SFIELD_OK);
    scatter(&seed, k, count, c->wide, c->mirrored, e);
    for (i = 0; i < POINTS; i++) {
        double dir[3];
        rnd_direction(&seed, dir);
        for (axis = 0; axis < 3; axis++) {
            const double tile = (double)(i / 16 * 7 % 5) / 5 - 0.4;     /* neighbours lie side by side */
            p[3 * i + axis] = (float)(c->wide * tile + rnd(&seed));
            n[3 * i + axis] = (float)dir[axis];
        }
        if (c->mirrored && k->basis == SFIELD_BASIS_HAAR) p[3 * i] = 0;
        else if (c->mirrored && i % 2) p[3 * i] = -p[3 * i - 3];           /* the middles of tiles are equally far */
    }
    memset(set, 0, sizeof set);
    for (i = 0; i < 2; i++) {
        set[i].count = POINTS;
        set[i].positions = p;
        set[i].normals = n;
        if (c->lazy) assert_int_equal(sfield_cache_create(s, POINTS, 9, &set[i].cache), SFIELD_OK);
    }
    set[1].entity = count < 3 ? count : 3;          /* which hides and shines; of few, one that hides, or none */
    for (frame = 0; frame < FRAMES; frame++) {
        for (i = 0; i < count; i += frame == 1 ? 5 : 1)                 /* the last time all move */
            for (axis = 12; frame && axis < 15; axis++) e[i].transform[axis] += rnd_in(&seed, -0.3, 0.3);
        assert_int_equal(sfield_scene_entities(s, e, count), SFIELD_OK);
        if (all) look_at_all(s);
        for (i = 0; i < 2; i++, rgb += 3 * POINTS) {
            set[i].rgb = rgb;
            assert_int_equal(sfield_shade(s, &set[i], 1, stats), SFIELD_OK);
            if (!c->lazy) {                     /* with all but what the points lie on */
                const uint32_t own = set[i].entity && e[set[i].entity - 1].occlusion ? 1u : 0u;
                assert_int_equal(stats->pairs, POINTS * (s->occluder_count - own));
            }
            stats++;
        }
    }
    for (i = 0; i < 2; i++) sfield_cache_free(set[i].cache);
    sfield_scene_free(s);
}

static void the_hierarchy_changes_no_bit_of_light(void **state)
{
    static const uint32_t counts[] = { 0, 1, 4, 5, 16, 17, 65, 300 };
    static float with[FRAMES * 6 * POINTS], without[FRAMES * 6 * POINTS];
    sfield_scene_stats a[2 * FRAMES], b[2 * FRAMES];
    uint64_t left_out = 0, products = 0, reused = 0;
    size_t c;
    int k, way, i;
    (void)state;
    for (k = 0; k < KINDS; k++)
        for (c = 0; c < sizeof counts / sizeof *counts; c++)
            for (way = 0; way < 4; way++) {
                const crowd now = { 7 + c, counts[c], way & 1 ? 6 : 40, way >> 1, way & 1 };
                shade_frames(&kinds[k], &now, 0, with, a);
                shade_frames(&kinds[k], &now, 1, without, b);
                if (memcmp(with, without, sizeof with) != 0 || memcmp(a, b, sizeof a) != 0)
                    fail_msg("%s, %u bodies, lazy %d, mirrored %d: not as without the hierarchy", kinds[k].name,
                             (unsigned)counts[c], now.lazy, now.mirrored);
                for (i = 0; i < 2 * FRAMES; i++) {
                    left_out += a[i].culled_far;
                    products += a[i].products;
                    reused += a[i].reused;
                }
            }
    assert_true(left_out > 100000 && products > 10000 && reused > 100);
}

/* A scene of bodies whose spheres are set by hand, in any units: what an overflow, an underflow or a radius of 0 makes
   of them. */
static void place_spheres(sfield_scene *s, uint64_t *seed, double unit, float far_away)
{
    uint32_t i, k;
    for (i = 0; i < s->occluder_count; i++) {
        sfield__item *it = &s->item[s->occluder[i]];
        const double how = rnd(seed);
        for (k = 0; k < 3; k++) it->center[0][k] = far_away + (float)(unit * (rnd(seed) - 0.5));
        if (i % 9 == 4) memcpy(it->center[0], s->item[s->occluder[i - 1]].center[0], sizeof it->center[0]);
        it->reach = how < 0.1 ? 0 : (float)(unit * exp(-6 * rnd(seed)));
        it->radius[0] = 0.3f * it->reach;
        it->inscribed = 0.2f * it->reach;
    }
    sfield__free(&s->allocator, s->tree.keys);
    sfield__free(&s->allocator, s->tree.ball);
    assert_true(sfield__make_tree(s));
}

static sfield_scene *scene_of_bodies(uint32_t count)
{
    sfield_scene_desc d;
    sfield_scene *s;
    sfield_entity *e = (sfield_entity *)calloc(count ? count : 1, sizeof *e);
    uint32_t i;
    assert_non_null(e);
    memset(&d, 0, sizeof d);
    assert_int_equal(sfield_scene_create(&d, &s), SFIELD_OK);
    for (i = 0; i < count; i++) e[i].occlusion = i % 8 ? kinds[0].body : NULL;
    assert_int_equal(sfield_scene_entities(s, e, count), SFIELD_OK);
    free(e);
    return s;
}

/* Moves m to where the reach of a body just meets a sphere about m, or just not. */
static void touch(const sfield__item *it, float extent, uint64_t *seed, float *m)
{
    const double far_off = ((double)it->reach + (double)extent) * (1 + 4e-7 * (rnd(seed) - 0.5));
    double dir[3];
    int k;
    rnd_direction(seed, dir);
    for (k = 0; k < 3; k++) m[k] = (float)((double)it->center[0][k] + far_off * dir[k]);
}

/* A walk comes by each occluder at most once, and by all whose reach meets the sphere, as floats have it. Of 9 bodies
   the last along the curve has a sphere for itself, so that roundings alone decide where it is touched. */
static void walks_miss_no_body_in_reach(void **state)
{
    static const double units[] = { 1, 1e-25, 1e18, 1e-6, 1e20, 1e-40, 1e36, 1e-21 };
    static const uint32_t counts[] = { 0, 1, 3, 11, 40, 2000 };
    static uint8_t seen[2000];
    uint64_t seed = 5, walked = 0, looked = 0, touched = 0;
    size_t u, c;
    int q;
    (void)state;
    for (c = 0; c < sizeof counts / sizeof *counts; c++) {
        sfield_scene *s = scene_of_bodies(counts[c]);
        for (u = 0; u < sizeof units / sizeof *units; u++) {
            const float far_away = u == 3 ? 5 : 0;  /* where roundings are as large as distances */
            place_spheres(s, &seed, units[u], far_away);
            for (q = 0; q < 400; q++) {
                const float extent = q % 3 ? (float)(units[u] * rnd(&seed) * 0.1) : 0;
                float m[3];
                sfield__walk w;
                uint32_t i, at;
                for (i = 0; i < 3; i++) m[i] = far_away + (float)(units[u] * (1.4 * rnd(&seed) - 0.7));
                if (q % 2 && s->occluder_count)
                    touch(&s->item[(uint32_t)s->tree.order[s->occluder_count - 1]], extent, &seed, m);
                memset(seen, 0, sizeof seen);
                sfield__start_walk(&w, s, m, extent);
                while ((at = sfield__next_near(&w)) != SFIELD__NONE) {
                    assert_true(at < counts[c] && at % 8 && !seen[at]);
                    seen[at] = 1;
                    walked += u == 0;
                }
                for (i = 0; i < s->occluder_count; i++) {
                    const sfield__item *it = &s->item[s->occluder[i]];
                    const float x = it->center[0][0] - m[0], y = it->center[0][1] - m[1], z = it->center[0][2] - m[2];
                    const float d2 = x * x + y * y + z * z;
                    looked += u == 0;
                    touched += fabsf(sqrtf(d2) - extent - it->reach) <= 1e-6f * it->reach;
                    if (sqrtf(d2) - extent < it->reach || d2 < it->reach * it->reach)
                        assert_true(seen[s->occluder[i]]);
                }
            }
        }
        sfield_scene_free(s);
    }
    print_message("%u of %u bodies came by, in units of 1\n", (unsigned)walked, (unsigned)looked);
    assert_true(walked < looked / 2 && touched > 1000);
}

static void the_largest_scene_has_a_hierarchy(void **state)
{
    sfield_scene *s = scene_of_bodies(ALL);
    uint64_t seed = 8;
    sfield__walk w;
    uint32_t found = 0;
    const float m[3] = { 0, 0, 0 };
    (void)state;
    place_spheres(s, &seed, 1, 0);
    sfield__start_walk(&w, s, m, 0);
    while (sfield__next_near(&w) != SFIELD__NONE) found++;
    assert_true(s->tree.levels <= sizeof s->tree.level / sizeof *s->tree.level);
    assert_true(found > 0 && found < ALL / 2);
    sfield__start_walk(&w, s, m, 10);
    for (found = 0; sfield__next_near(&w) != SFIELD__NONE;) found++;
    assert_int_equal(found, s->occluder_count);
    sfield_scene_free(s);
}

/* A lamp that is said to lie behind all candidates does so for each lane, by the distances that decide. */
static void lamps_behind_all_are_behind_each(void **state)
{
    static const double units[] = { 1, 1e-25, 1e18, 1e-6, 1e20 };
    sfield_scene *s = scene_of_bodies(40);
    uint8_t *memory = (uint8_t *)malloc((size_t)sfield__carve_tile(NULL, NULL, s->occluder_count, 1, s->coefs, 1));
    uint64_t seed = 6;
    uint32_t lamp = 0, behind = 0, before = 0, i, l;
    sfield_points set;
    sfield__tile t;
    int round;
    (void)state;
    assert_non_null(memory);
    memset(&set, 0, sizeof set);
    memset(&t, 0, sizeof t);
    t.s = s;
    t.set = &set;
    t.lanes = SFIELD__LANES;
    t.lights = s->light_count = 1;
    t.active = 0x7fff;                              /* one lane lies nowhere */
    s->light[0] = lamp;
    (void)sfield__carve_tile(&t, memory, s->occluder_count, 1, s->coefs, 1);
    for (round = 0; round < 5000; round++) {
        const double unit = units[round / 1000], spread = round % 2 ? 0.1 : 1e-4;
        const float far_away = round / 1000 == 3 ? 5 : 0;
        float d2[SFIELD__LANES], middle[3];
        uint32_t nearer = 1;
        if (round % 20 == 0) place_spheres(s, &seed, unit, far_away);
        for (i = 0; i < 3; i++) {
            middle[i] = far_away + (float)(unit * (rnd(&seed) - 0.5));
            s->item[lamp].center[1][i] = far_away + (float)(unit * (rnd(&seed) - 0.5));
            for (l = 0; l < SFIELD__LANES; l++) {
                t.p[16 * i + l] = l < 15 ? middle[i] + (float)(unit * spread * (rnd(&seed) - 0.5)) : 0;
                t.n[16 * i + l] = i == 1;
            }
        }
        sfield__find_candidates(&t);
        if (t.count) {
            sfield__item *it = &s->item[lamp];
            float farthest = 0;
            for (i = 0; i < t.count; i++) farthest = fmaxf(farthest, t.farthest[i]);
            if (round % 4) {                        /* just behind all */
                double dir[3], far_off = (double)farthest + rnd(&seed) * 2.5 * (double)t.extent;
                rnd_direction(&seed, dir);
                for (i = 0; i < 3; i++) it->center[1][i] = (float)((double)t.middle[i] + far_off * dir[i]);
            }
            sfield__measure_distances(t.p, it->center[1], d2);
            for (i = 0; i < t.count; i++) {
                nearer &= t.used[i] ==
                          (t.used[i] & sfield__nearer16(t.d2 + (size_t)i * SFIELD__LANES, d2, s->simd));
            }
            if (sfield__is_behind(&t, 0, farthest)) {
                assert_true(nearer);
                behind++;
                it->e.occlusion = kinds[0].body;    /* it might be a candidate itself */
                assert_false(sfield__is_behind(&t, 0, farthest));
                it->e.occlusion = NULL;
            } else before += !nearer;
        }
    }
    print_message("behind %u times, before some body %u times\n", (unsigned)behind, (unsigned)before);
    assert_true(behind > 20 && before > 20);
    free(memory);
    sfield_scene_free(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_hierarchy_changes_no_bit_of_light),
        cmocka_unit_test(walks_miss_no_body_in_reach),
        cmocka_unit_test(the_largest_scene_has_a_hierarchy),
        cmocka_unit_test(lamps_behind_all_are_behind_each),
    };
    return cmocka_run_group_tests(tests, make_fields, free_fields);
}
