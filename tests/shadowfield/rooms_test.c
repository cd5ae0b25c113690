/* rooms_test - lights inside of what hides: row T80 of docs/conformance.md, a lamp in a box-shaped room against the
   closed form, and against the same without the room, to the bit. */
#define SFIELD_STATIC
#define SHADOWFIELD_IMPLEMENTATION
#include "shadowfield.h"
#include "util.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include "conformance.h"

enum { POINTS = 24 };

static const double half[3] = { 2, 1.2, 1.5 };
static const float lamp_at[3] = { 0.4f, 0.5f, -0.3f };
static sfield_field *room[3], *self[3], *table[3], *lamp[3];          /* by basis: 1 harmonics, 2 wavelets */
static float place[3 * POINTS], free_place[3 * POINTS], up[3 * POINTS];       /* on the floor; 0.5 above it */

/* Walls 0.2 thick: a box, and one inside of it that is turned inside out. */
static model model_room(void)
{
    model outer = model_box(half[0] + 0.2, half[1] + 0.2, half[2] + 0.2), inner = model_box(half[0], half[1], half[2]);
    model m = model_alloc(16, 24);
    size_t i;
    memcpy(m.p, outer.p, 24 * sizeof *m.p);
    memcpy(m.p + 24, inner.p, 24 * sizeof *m.p);
    for (i = 0; i < 36; i++) {
        m.i[i] = outer.i[i];
        m.i[36 + i] = 8 + inner.i[i / 3 * 3 + (3 - i % 3) % 3];
    }
    model_free(&outer);
    model_free(&inner);
    return m;
}

static int make_fields(void **state)
{
    model walls = model_room(), block = model_box(0.8, 0.05, 0.8);
    sfield_mesh mesh = mesh_of(&walls), slab = mesh_of(&block);
    sfield_emitter e;
    uint64_t seed = 3;
    int b, i;
    (void)state;
    for (i = 0; i < POINTS; i++) {
        place[3 * i] = rnd_in(&seed, -1.9, 1.9);
        place[3 * i + 1] = (float)-half[1];
        place[3 * i + 2] = rnd_in(&seed, -1.4, 1.4);
        up[3 * i + 1] = 1;
        free_place[3 * i] = 0.8f * place[3 * i];
        free_place[3 * i + 1] = place[3 * i + 1] + 0.5f;
        free_place[3 * i + 2] = 0.8f * place[3 * i + 2];
    }
    memset(&e, 0, sizeof e);
    e.radius = 0.15f;
    for (i = 0; i < 3; i++) e.radiance[i] = (float)(100 >> i);
    for (b = 1; b < 3; b++) {
        sfield_desc d = small_desc((sfield_basis)b);
        d.cube_side = 16;
        d.position_side = 9;
        d.shell_count = 12;
        assert_int_equal(sfield_build(&d, &mesh, &room[b], NULL), SFIELD_OK);
        assert_int_equal(sfield_build(&d, &slab, &table[b], NULL), SFIELD_OK);
        assert_int_equal(sfield_build_self(&d, &mesh, AT(place, up, POINTS), 1e-3f, &self[b], NULL), SFIELD_OK);
        d.outer = 40;
        d.shell_count = 24;
        d.position_side = 3;
        assert_int_equal(sfield_build_emitter(&d, &e, &lamp[b], NULL), SFIELD_OK);
    }
    model_free(&walls);
    model_free(&block);
    return 0;
}

static int free_fields(void **state)
{
    int b;
    (void)state;
    for (b = 1; b < 3; b++) {
        sfield_free(room[b]);
        sfield_free(self[b]);
        sfield_free(table[b]);
        sfield_free(lamp[b]);
    }
    return 0;
}

static sfield_scene *scene_of(int basis)
{
    sfield_scene_desc d;
    sfield_scene *s = NULL;
    memset(&d, 0, sizeof d);
    d.basis = (sfield_basis)basis;
    d.cube_side = 16;
    assert_int_equal(sfield_scene_create(&d, &s), SFIELD_OK);
    return s;
}

static sfield_entity at(const sfield_field *occlusion, const sfield_field *source, const float *where)
{
    sfield_entity e = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };
    e.occlusion = occlusion;
    e.source = source;
    if (where) memcpy(e.transform + 12, where, 12);
    return e;
}

/* on: the entity that the points belong to, whose self-visibility they then have. */
static sfield_scene_stats shade(sfield_scene *s, int basis, const float *where, uint32_t on, sfield_cache *cache,
                                float *rgb)
{
    sfield_scene_stats stats;
    sfield_points set;
    memset(&set, 0, sizeof set);
    set.count = POINTS;
    set.positions = where;
    set.normals = up;
    set.rgb = rgb;
    set.entity = on;
    set.self = on ? self[basis] : NULL;
    set.cache = cache;
    assert_int_equal(sfield_shade(s, &set, 1, &stats), SFIELD_OK);
    return stats;
}

/* A third entity, a slab between lamp and floor, hides as it does without a room. */
static void t80_a_lamp_in_a_room_lights_it_as_without_walls(void **state)
{
    static const float under[3] = { 0.3f, 0, -0.2f };
    static const char *const names[3] = { "", "a lamp in a closed room, floor, off the closed form, harmonics",
                                          "the same, wavelets" };
    int b, on, slab;
    (void)state;
    for (b = 1; b < 3; b++)
        for (slab = 0; slab < 2; slab++)
            for (on = 0; on < 2; on++) {
                const float *points = on ? place : free_place;
                sfield_scene *s = scene_of(b), *bare = scene_of(b);
                sfield_scene_stats stats;
                sfield_entity e[3];
                float lit[3 * POINTS], want[3 * POINTS];
                double worst = 0, most = 0;
                int i;
                e[0] = at(room[b], NULL, NULL);
                e[1] = at(NULL, lamp[b], lamp_at);
                e[2] = at(table[b], NULL, under);
                assert_int_equal(sfield_scene_entities(s, e, slab ? 3 : 2), SFIELD_OK);
                stats = shade(s, b, points, on ? 1 : 0, NULL, lit);
                assert_int_equal(stats.rooms, 1);
                assert_int_equal(sfield_scene_entities(bare, e + 1, slab ? 2 : 1), SFIELD_OK);
                stats = shade(bare, b, points, 0, NULL, want);
                assert_int_equal(stats.rooms, 0);
                for (i = 0; i < 3 * POINTS; i++) most = fmax(most, fabs((double)lit[i] / (double)want[i] - 1));
                print_message("basis %d, slab %d, on the room %d: off by %.1e\n", b, slab, on, most);
                for (i = 0; i < POINTS; i++) {
                    double d[3], d2 = 0, exact;
                    int k;
                    for (k = 0; k < 3; k++) d[k] = (double)lamp_at[k] - (double)points[3 * i + k], d2 += d[k] * d[k];
                    exact = 100 * 0.15 * 0.15 / d2 * d[1] / sqrt(d2);
                    worst = fmax(worst, fabs((double)lit[3 * i] - exact) / exact);
                }
                assert_true(most <= (b == 1 ? 0 : 1e-4));             /* wavelets: in bundles or not */
                /* 4 bands; a lamp of one of 16 x 16 texels */
                if (!slab && on) CONFORM_MAX("T80", names[b], 0.2, worst);
                else if (slab) assert_true(worst > 0.5);                /* it hides most of the floor */
                sfield_scene_free(s);
                sfield_scene_free(bare);
            }
}

/* The centre of the room is farther from this point than the lamp is, which would light it through the wall. */
static void a_room_hides_its_lamp_from_outside(void **state)
{
    static const float near_wall[3] = { 1.7f, 0, 0 }, out[3] = { 2.6f, 0.1f, 0.1f }, left[3] = { -1, 0, 0 };
    int b;
    (void)state;
    for (b = 1; b < 3; b++) {
        sfield_scene *s = scene_of(b), *bare = scene_of(b);
        sfield_entity e[2];
        float lit[3], free_of[3];
        sfield_points set;
        memset(&set, 0, sizeof set);
        set.count = 1;
        set.positions = out;
        set.normals = left;
        e[0] = at(room[b], NULL, NULL);
        e[1] = at(NULL, lamp[b], near_wall);
        assert_int_equal(sfield_scene_entities(s, e, 2), SFIELD_OK);
        assert_int_equal(sfield_scene_entities(bare, e + 1, 1), SFIELD_OK);
        set.rgb = lit;
        assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
        set.rgb = free_of;
        assert_int_equal(sfield_shade(bare, &set, 1, NULL), SFIELD_OK);
        print_message("basis %d: %.4f of %.4f goes through the wall\n", b, (double)lit[0], (double)free_of[0]);
        assert_true(fabsf(lit[0]) < 0.15f * free_of[0] && free_of[0] > 1);
        sfield_scene_free(s);
        sfield_scene_free(bare);
    }
}

/* Incident radiance in a room is that without its walls, behind a slab or not: the room's centre is nearer to many
   points than the slab and the lamp are. Outside, little comes through: what four bands cannot take away. */
static void incident_radiance_of_a_lamp_in_a_room_is_that_without_walls(void **state)
{
    static const float under[3] = { 0.3f, 0, -0.2f };
    int slab, inside;
    (void)state;
    for (slab = 0; slab < 2; slab++)
        for (inside = 0; inside < 2; inside++) {
            sfield_scene *s = scene_of(1), *bare = scene_of(1);
            static float in_room[POINTS * 48], want[POINTS * 48], out[3 * POINTS];
            double off = 0, most = 0;
            sfield_points set;
            sfield_entity e[3];
            int i;
            memset(&set, 0, sizeof set);
            for (i = 0; i < 3 * POINTS; i++) out[i] = place[i] * (i % 3 == 1 ? 1.5f : 3);
            set.count = POINTS;
            set.positions = inside ? free_place : out;
            set.normals = up;
            e[0] = at(room[1], NULL, NULL);
            e[1] = at(NULL, lamp[1], lamp_at);
            e[2] = at(table[1], NULL, under);
            assert_int_equal(sfield_scene_entities(s, e, slab ? 3 : 2), SFIELD_OK);
            assert_int_equal(sfield_scene_entities(bare, e + 1, slab ? 2 : 1), SFIELD_OK);
            assert_int_equal(sfield_incident(s, &set, in_room), SFIELD_OK);
            assert_int_equal(sfield_incident(bare, &set, want), SFIELD_OK);
            for (i = 0; i < POINTS * 48; i++) {
                const double d = (double)in_room[i] - (double)(inside ? want[i] : 0);
                off += d * d;
                most += (double)want[i] * (double)want[i];
            }
            print_message("slab %d, inside %d: off by %.2e of itself\n", slab, inside, sqrt(off / most));
            assert_true(most > 1 && sqrt(off / most) < (inside ? 1e-5 : 0.4));
            sfield_scene_free(s);
            sfield_scene_free(bare);
        }
}

/* The sky stays outside, and a lamp that leaves the room as well. Caches notice. */
static void a_lamp_that_leaves_the_room_takes_its_light_along(void **state)
{
    static const float outside[3] = { 0.4f, 4, -0.3f }, sky[3] = { 1, 1, 1 };
    int b, i, k;
    (void)state;
    for (b = 1; b < 3; b++) {
        sfield_scene *s = scene_of(b);
        sfield_cache *cache = NULL;
        assert_int_equal(sfield_scene_environment(s, sky, 1, 1, NULL), SFIELD_OK);
        assert_int_equal(sfield_cache_create(s, POINTS, 2, &cache), SFIELD_OK);
        for (i = 0; i < 6; i++) {
            sfield_cache *fresh = NULL;
            float lit[3 * POINTS], want[3 * POINTS], sum = 0;
            sfield_entity e[2];
            sfield_scene_stats stats;
            e[0] = at(room[b], NULL, NULL);
            e[1] = at(NULL, lamp[b], i % 3 == 1 ? outside : lamp_at);
            assert_int_equal(sfield_scene_entities(s, e, 2), SFIELD_OK);
            stats = shade(s, b, place, 1, cache, lit);
            assert_int_equal(stats.rooms, i % 3 != 1);
            assert_int_equal(sfield_cache_create(s, POINTS, 2, &fresh), SFIELD_OK);
            shade(s, b, place, 1, fresh, want);
            assert_memory_equal(lit, want, sizeof lit);
            for (k = 0; k < POINTS; k++) sum += lit[3 * k];
            if (i % 3 == 1) assert_true(fabsf(sum) < 0.02f * POINTS);
            else assert_true(sum > 0.2f * POINTS);
            sfield_cache_free(fresh);
        }
        sfield_cache_free(cache);
        sfield_scene_free(s);
    }
}

/* A body whose sphere holds a lamp, but not its hull, is no room. */
static void what_a_lamp_stands_beside_is_no_room(void **state)
{
    static const float beside[3] = { 0, 0.25f, 0 };
    int b;
    (void)state;
    for (b = 1; b < 3; b++) {
        sfield_scene *s = scene_of(b);
        sfield_scene_stats stats;
        sfield_entity e[2];
        float rgb[3 * POINTS];
        e[0] = at(table[b], NULL, NULL);
        e[1] = at(NULL, lamp[b], beside);
        assert_int_equal(sfield_scene_entities(s, e, 2), SFIELD_OK);
        stats = shade(s, b, place, 0, NULL, rgb);
        assert_true(stats.overlaps == 1 && stats.rooms == 0);
        sfield_scene_free(s);
    }
}

static void rooms_without_memory_keep_the_list(void **state)
{
    counting c = { 0, 0, 0, 0, 0 };
    sfield_scene_desc d;
    sfield_scene *s = NULL;
    sfield_entity e[2];
    sfield_result result = SFIELD_ERR_ALLOC;
    size_t before, fail;
    (void)state;
    memset(&d, 0, sizeof d);
    d.system.allocator = counting_allocator(&c);
    assert_int_equal(sfield_scene_create(&d, &s), SFIELD_OK);
    e[0] = at(room[1], NULL, NULL);
    e[1] = at(NULL, lamp[1], lamp_at);
    before = c.now;
    for (fail = 1; result != SFIELD_OK; fail++) {
        assert_true(fail < 40);
        c.calls = 0;
        c.fail_at = fail;
        result = sfield_scene_entities(s, e, 2);
        if (result == SFIELD_OK) break;
        assert_true(result == SFIELD_ERR_ALLOC && c.now == before);
    }
    assert_true(fail > 5);
    c.fail_at = 0;
    assert_int_equal(s->held_count, 1);
    sfield_scene_free(s);
    assert_true(c.now == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(t80_a_lamp_in_a_room_lights_it_as_without_walls),
        cmocka_unit_test(a_room_hides_its_lamp_from_outside),
        cmocka_unit_test(incident_radiance_of_a_lamp_in_a_room_is_that_without_walls),
        cmocka_unit_test(a_lamp_that_leaves_the_room_takes_its_light_along),
        cmocka_unit_test(what_a_lamp_stands_beside_is_no_room),
        cmocka_unit_test(rooms_without_memory_keep_the_list),
    };
    return cmocka_run_group_tests(tests, make_fields, free_fields);
}
