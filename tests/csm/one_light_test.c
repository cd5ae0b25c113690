/* one_light_test - points that have one light get the answers of points that have a light each, bit for bit: every
   domain, order, kind of light, filter, layers, layout, instruction set, stride and place in a batch, on shards and in
   scenes; and nothing behind the last point is read. */

#define COHSM_STATIC
#define CSM_IMPLEMENTATION
#include "csm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "util.h"
#include "making.h"

enum { MOST = 2100 };                   /* two streams and a part */

typedef struct totals { size_t asked, dark, lit, refused; } totals;

/* A light of the kind; one in eight has no map, or no direction. */
static void pick_light(void *light, cohsm_light_kind kind, const cohsm_info *info, uint64_t *seed)
{
    static const float odd[8] = { (float)NAN, (float)INFINITY, -1e30f, 3e38f, -0.25f, 1.25f, 1.0f, 0.0f };
    const int strange = rnd_below(seed, 8) == 0;
    uint32_t index = strange ? info->map_count + rnd_below(seed, 2) : rnd_below(seed, info->map_count);
    float v[3];
    int k;
    rnd_direction(seed, v);
    for (k = 0; k < 3; k++) {
        if (kind == COHSM_LIGHT_POSITION) v[k] = info->center[k] + 2 * info->radius * v[k];
        if (kind == COHSM_LIGHT_PARAMETER) v[k] = (float)rnd(seed);
    }
    if (strange) v[rnd_below(seed, 3)] = odd[rnd_below(seed, 8)];
    if (kind == COHSM_LIGHT_DIRECTION && rnd_below(seed, 16) == 0) memset(v, 0, sizeof v);
    if (kind == COHSM_LIGHT_INDEX) memcpy(light, &index, 4);
    else memcpy(light, v, sizeof v);
}

/* Points about the sphere that stand where cube maps see them on all faces; some far off, some not finite. Each is
   `stride` bytes after the one before, and memory ends behind the last. */
static float *make_points(size_t count, size_t stride, const cohsm_info *info, uint64_t *seed)
{
    static const float odd[6] = { (float)NAN, (float)INFINITY, -1e30f, 3e38f, -0.0f, 1e-42f };
    char *memory = (char *)malloc((count - 1) * stride + 12);
    size_t i;
    int k;
    if (!memory) abort();
    memset(memory, 0xff, (count - 1) * stride + 12);
    for (i = 0; i < count; i++) {
        float p[3];
        const double wide = i % 5 ? 1.1 : 3;
        for (k = 0; k < 3; k++) p[k] = info->center[k] + info->radius * (float)rnd_in(seed, -wide, wide);
        if (i % 31 == 30) p[rnd_below(seed, 3)] = odd[i / 31 % 6];
        if (i % 37 == 36) p[0] = p[1];
        memcpy(memory + i * stride, p, sizeof p);
    }
    return (float *)(void *)memory;
}

/* Asks with one light, and with the same light for each point. */
static void compare(cohsm_maps *maps, cohsm_query q, totals *sum)
{
    static float one[MOST], each[MOST], lights[MOST][3];
    cohsm_instance at[3];
    size_t i, refused[2] = { 0, 0 };
    int simd, k;
    for (i = 0; i < q.count; i++) memcpy(lights[i], q.lights, q.light_kind == COHSM_LIGHT_INDEX ? 4 : 12);
    for (simd = cohsm__simd(); simd >= 0; simd--) {
        cohsm_query single = q;
        maps->simd = simd;
        single.one_light = 1;
        q.lights = lights;
        q.light_stride = 12;
        memset(one, 0x5a, sizeof one);
        assert_int_equal(cohsm_visible(maps, &q, each, &refused[0]), COHSM_OK);
        assert_int_equal(cohsm_visible(maps, &single, one, &refused[1]), COHSM_OK);
        assert_memory_equal(one, each, q.count * sizeof *one);
        assert_int_equal(refused[0], refused[1]);
        for (k = 0; k < 3; k++) {
            at[k].maps = maps;
            identity(at[k].transform);
            at[k].transform[0] = at[k].transform[5] = at[k].transform[10] = k == 1 ? 0.5f : 1.0f;
            at[k].transform[12] = k == 2 ? 0.75f : 0.0f;
        }
        assert_int_equal(cohsm_visible_scene(at + 1, 2, &q, each, NULL), COHSM_OK);
        assert_int_equal(cohsm_visible_scene(at + 1, 2, &single, one, NULL), COHSM_OK);
        assert_memory_equal(one, each, q.count * sizeof *one);
        q.lights = single.lights;
    }
    maps->simd = cohsm__simd();
    q.one_light = 1;
    sum->asked += q.count;
    assert_int_equal(cohsm_visible(maps, &q, one, NULL), COHSM_OK);
    for (i = 0; i < q.count; i++) {
        sum->dark += one[i] == 0.0f;
        sum->lit += one[i] == 1.0f;
        sum->refused += one[i] == COHSM_REFUSED;
    }
}

/* Every kind of light that the maps know, every filter, many strides and counts. Returns what came of NEAREST. */
static totals ask(cohsm_maps *maps, uint64_t *seed)
{
    static const size_t counts[8] = { 1, 7, 8, 9, 33, 1024, 1025, MOST }, strides[5] = { 12, 16, 20, 32, 200 };
    totals sum[COHSM_FILTER_COUNT];
    cohsm_info info;
    int kind, filter, i;
    memset(sum, 0, sizeof sum);
    cohsm_get_info(maps, &info);
    for (kind = 0; kind < COHSM_LIGHT_COUNT; kind++)
        for (filter = 0; filter < COHSM_FILTER_COUNT; filter++)
            for (i = 0; i < (filter == COHSM_FILTER_NEAREST ? 20 : 3); i++) {
                const int directed = kind == COHSM_LIGHT_DIRECTION || kind == COHSM_LIGHT_POSITION;
                const size_t count = counts[(i + 7) % 8], stride = strides[i % 5];
                float light[3] = { 0, 0, 0 }, *points;
                cohsm_query q;
                if (directed && info.domain != COHSM_DOMAIN_LATLONG && info.domain != COHSM_DOMAIN_OCTAHEDRAL) continue;
                if (kind == COHSM_LIGHT_PARAMETER && info.dimensions == 0) continue;
                pick_light(light, (cohsm_light_kind)kind, &info, seed);
                points = make_points(count, stride, &info, seed);
                q = query_of(points, count, light, (cohsm_light_kind)kind, (cohsm_filter)filter);
                q.position_stride = stride == 12 && i % 2 ? 0 : stride;
                q.bias = i % 3 == 2 ? -1.0f : (float)(i % 3);
                q.seed = (uint32_t)i;
                compare(maps, q, &sum[filter]);
                free(points);
            }
    return sum[COHSM_FILTER_NEAREST];
}

static void ask_both_layouts(const cohsm_desc *desc, const model *m, uint64_t *seed)
{
    cohsm_desc d = *desc;
    int layout;
    for (layout = 0; layout < 2; layout++) {
        cohsm_maps *maps;
        totals sum;
        d.layout = layout ? COHSM_LAYOUT_FAST : COHSM_LAYOUT_COMPACT;
        maps = build(&d, m);
        sum = ask(maps, seed);
        assert_true(sum.dark > sum.asked / 100 && sum.lit > sum.asked / 10);
        cohsm_free(maps);
    }
}

static void one_light_answers_as_a_light_for_each_point(void **state)
{
    model torus = model_torus(24, 12, 0.7, 0.25), soup = model_soup(120, 0.2, 9);
    uint64_t seed = 21;
    size_t i;
    (void)state;
    for (i = 0; i < sizeof csm_kinds / sizeof *csm_kinds; i++) {
        cohsm_desc d = desc_of(csm_kinds[i].domain, csm_kinds[i].side, 24);
        d.order = csm_kinds[i].order;
        d.orientation = csm_kinds[i].orientation;
        d.layers = (cohsm_layers)(1 + i % 3);
        d.self_only = i % 4 == 3;
        place_domain(&d, -1, 1.75f, -1, 2);
        ask_both_layouts(&d, i % 2 ? &torus : &soup, &seed);
    }
    model_free(&torus);
    model_free(&soup);
}

static void a_lamp_inside_sees_all_faces(void **state)
{
    static const double low[3] = { -1, -1, -1 }, high[3] = { 1, 1, 1 };
    static const float places[4][4] = { { 0, 0, 0, 1 }, { 0.4f, 0, -0.3f, 1 }, { -0.2f, 0.5f, 0, 1 },
                                        { 0.1f, 0, 0.6f, 1 } };
    model room = model_room(low, high, 0.1, 0), soup = model_soup(80, 0.15, 3), all = model_join(&room, &soup);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LIST, 0, 40);
    uint64_t seed = 22;
    (void)state;
    d.domain.locations = places[0];
    d.domain.location_count = 4;
    ask_both_layouts(&d, &all, &seed);
    d.pixel_begin = 333;                /* shards keep a part of each face */
    d.pixel_end = 1201;
    ask_both_layouts(&d, &all, &seed);
    model_free(&room);
    model_free(&soup);
    model_free(&all);
}

static void a_list_of_directions_and_a_shard_answer_alike(void **state)
{
    static float rays[9][4];
    model soup = model_soup(120, 0.2, 5);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LIST, 0, 20);
    uint64_t seed = 23;
    int i;
    (void)state;
    for (i = 0; i < 9; i++) rnd_direction(&seed, rays[i]);
    d.domain.locations = rays[0];
    d.domain.location_count = 9;
    ask_both_layouts(&d, &soup, &seed);
    d = desc_of(COHSM_DOMAIN_LATLONG, 18, 32);
    d.pixel_begin = 301;
    d.pixel_end = 777;
    ask_both_layouts(&d, &soup, &seed);
    model_free(&soup);
}

/* More pixels than slots: points that share a slot but no pixel. 1024 pixels a side take all bits of a key. */
static void large_maps_answer_alike(void **state)
{
    model soup = model_soup(60, 0.3, 7);
    cohsm_desc d = desc_of(COHSM_DOMAIN_RECTANGLE, 1, 1024);
    uint64_t seed = 24;
    (void)state;
    place_domain(&d, -1, 1.75f, -1, 2);
    ask_both_layouts(&d, &soup, &seed);
    model_free(&soup);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_light_answers_as_a_light_for_each_point),
        cmocka_unit_test(a_lamp_inside_sees_all_faces),
        cmocka_unit_test(a_list_of_directions_and_a_shard_answer_alike),
        cmocka_unit_test(large_maps_answer_alike),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
