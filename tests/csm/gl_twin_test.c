/* gl_twin_test - the GLSL of cohsm_*.glsl against its C twins in csm.h: a million visibility queries over all domains,
   orders, frames, filters and kinds of light, scenes of instances, and samples of every light on every material. */
#define _POSIX_C_SOURCE 200809L
#include "csm.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend/gl_csm.h"

#include "gl_test.h"
#include "util.h"
#include "making.h"

#ifdef __EMSCRIPTEN__                   /* a browser's software renderer takes ten times as long */
enum { COUNT = 2048, CLOUD = 37 };
#else
enum { COUNT = 16384, CLOUD = 37 };
#endif

typedef struct question { float point[3]; uint32_t entity; float light[3]; uint32_t id; } question;

static question questions[COUNT];
static float    answers[COUNT], expected[COUNT];

typedef struct tally { size_t asked, wrong, lighter, slightly, dark, refused; double worst; } tally;

/* What floats do at a boundary (of a pixel, a map, a stored depth) is counted; PCF may differ in its sixth digit. */
static void compare_answers(tally *sum)
{
    size_t i;
    for (i = 0; i < COUNT; i++) {
        double off = fabs((double)answers[i] - (double)expected[i]);
        if (!(off < 1e-4)) {
            sum->wrong++;
            sum->lighter += answers[i] > expected[i];
            sum->slightly += off < 0.01;
        } else if (off > sum->worst) sum->worst = off;
        sum->dark += expected[i] < 0.5f && expected[i] >= 0;
        sum->refused += expected[i] < 0;
    }
    sum->asked += COUNT;
}

static void make_questions(const cohsm_info *info, const float *center, float radius, cohsm_light_kind light,
                           uint32_t bodies, uint64_t *seed)
{
    uint32_t i, k;
    for (i = 0; i < COUNT; i++) {
        question *q = &questions[i];
        for (k = 0; k < 3; k++) q->point[k] = center[k] + radius * (float)rnd_in(seed, -1.1, 1.1);
        q->entity = rnd_below(seed, bodies + 1) < bodies ? 1 + rnd_below(seed, bodies) : 0;
        q->id = i;
        rnd_direction(seed, q->light);
        if (light == COHSM_LIGHT_POSITION)
            for (k = 0; k < 3; k++) q->light[k] = center[k] + 3 * radius * (float)rnd(seed) * q->light[k];
        if (light == COHSM_LIGHT_PARAMETER)
            for (k = 0; k < 3; k++) q->light[k] = (float)rnd(seed);
        if (light == COHSM_LIGHT_INDEX) {
            uint32_t cell = rnd_below(seed, info->map_count);
            memcpy(q->light, &cell, 4);
        }
        if (i % 1000 == 7) q->point[i % 3] = i % 2000 == 7 ? HUGE_VALF : 1e30f;       /* odd ones among them */
        if (i % 1000 == 13 && light != COHSM_LIGHT_INDEX) q->light[i % 3] = i % 2000 == 13 ? 0.0f : -HUGE_VALF;
    }
}

/* Both sides answer; bodies is 1 and the transform the upright for a single object. */
static void ask_both(gl_test *t, glbk_csm_asker *asker, const glbk_csm_maps *maps, const cohsm_instance *bodies,
                     uint32_t count, cohsm_light_kind light, cohsm_filter filter, float bias, tally *sum)
{
    cohsm_query c = { 0 };
    uint32_t entities[COUNT], i;

    for (i = 0; i < COUNT; i++) entities[i] = questions[i].entity;
    c.positions = questions[0].point;
    c.position_stride = sizeof(question);
    c.count = COUNT;
    c.lights = questions[0].light;
    c.light_stride = sizeof(question);
    c.light_kind = light;
    c.filter = filter;
    c.bias = bias > 0 ? bias : -1;
    c.seed = 11;
    c.entities = entities;
    assert_glbk(t, glbk_csm_ask_upload(&t->gl, asker, &c));
    assert_glbk(t, glbk_csm_ask_run(&t->gl, asker, maps, COUNT));
    assert_glbk(t, glbk_csm_ask_read(&t->gl, asker, COUNT, answers));
    assert_int_equal(cohsm_visible_scene(bodies, count, &c, expected, NULL), COHSM_OK);
    compare_answers(sum);
}

static const float upright[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };

static cohsm_maps *build_maps(const cohsm_desc *d)
{
    model m = model_torus(24, 12, 1.0, 0.4);
    cohsm_mesh mesh = mesh_of(&m);
    cohsm_maps *maps = NULL;
    assert_int_equal(cohsm_build(d, &mesh, &maps, NULL), COHSM_OK);
    model_free(&m);
    return maps;
}

static void upload(gl_test *t, const cohsm_maps *const *maps, uint32_t map_count, const cohsm_instance *bodies,
                   uint32_t count, glbk_csm_maps *out)
{
    glbk_csm_block blocks[KINDS];
    glbk_csm_instance instances[CLOUD];
    uint32_t starts[KINDS], i, k;
    for (i = 0; i < map_count; i++) blocks[i].data = cohsm_data(maps[i], &blocks[i].bytes);
    assert_glbk(t, glbk_csm_maps_create(&t->gl, blocks, map_count, count, starts, out));
    for (i = 0; i < count; i++) {
        for (k = 0; maps[k] != bodies[i].maps; k++) {}
        instances[i].start = starts[k];
        instances[i].offset = 0;
        memcpy(instances[i].transform, bodies[i].transform, sizeof upright);
    }
    assert_glbk(t, glbk_csm_maps_place(&t->gl, out, instances, count));
}

static void queries_of_all_kinds_agree(void **state)
{
    GL_TEST(t, state)
    glbk_csm_asker asker;
    tally sum = { 0, 0, 0, 0, 0, 0, 0 };
    uint64_t seed = 5;
    size_t i;

    assert_glbk(t, glbk_csm_asker_create(&t->gl, COUNT, &asker));
    for (i = 0; i < sizeof csm_kinds / sizeof csm_kinds[0]; i++) {
        cohsm_desc d = desc_of(csm_kinds[i].domain, csm_kinds[i].side, 48);
        cohsm_instance body;
        cohsm_info info;
        glbk_csm_maps maps;
        const cohsm_maps *built;
        int light, filter;

        if (csm_kinds[i].domain > COHSM_DOMAIN_OCTAHEDRAL) place_domain(&d, 1.6f, 0.9f, 0.3f, 0.5f);
        d.order = csm_kinds[i].order;
        d.orientation = csm_kinds[i].orientation;
        d.depth_bits = i % 3 == 1 ? 5 : 8;
        d.map_side = i % 2 ? 48 : 31;
        body.maps = built = build_maps(&d);
        memcpy(body.transform, upright, sizeof upright);
        cohsm_get_info(built, &info);
        upload(t, &built, 1, &body, 1, &maps);
        assert_non_null(strstr(maps.defines, "COHSM_ONE_DOMAIN="));
        assert_non_null(strstr(maps.defines, "CSM_INSTANCES=1"));
        for (light = 0; light < 4; light++)
            for (filter = 0; filter < 3; filter++) {
                if (info.positional && light < 2) continue;
                if (light == COHSM_LIGHT_INDEX && filter == COHSM_FILTER_ROULETTE) continue;
                glbk_csm_maps general = maps;           /* compiled once, not for each kind of maps */
                int own = filter == COHSM_FILTER_NEAREST && light == (info.positional ? 2 : 0);
                general.defines[0] = 0;
                general.key = 0;
                make_questions(&info, info.center, info.radius, (cohsm_light_kind)light, 1, &seed);
                ask_both(t, &asker, own ? &maps : &general, &body, 1, (cohsm_light_kind)light, (cohsm_filter)filter,
                         i % 2 ? 0.0f : 1.0f, &sum);
            }
        glbk_csm_maps_free(&t->gl, &maps);
        cohsm_free(body.maps == built ? (cohsm_maps *)(size_t)built : NULL);
    }
    glbk_csm_asker_free(&t->gl, &asker);
    printf("%zu queries: %zu differ, %zu dark, %zu refused, worst of the rest %.1e\n", sum.asked, sum.wrong, sum.dark,
           sum.refused, sum.worst);
    assert_true(sum.asked >= 61 * (size_t)COUNT);
    assert_true(sum.dark > sum.asked / 10 && sum.refused > sum.asked / 100);       /* or this compares nothing */
    assert_true((double)sum.wrong < 1e-4 * (double)sum.asked);
}

/* Two objects, three instances turned, scaled and moved, receivers that lie on none. */
static void questions_to_scenes_are_answered_as_on_the_cpu(void **state)
{
    GL_TEST(t, state)
    glbk_csm_asker asker;
    glbk_csm_maps maps;
    cohsm_desc a = desc_of(COHSM_DOMAIN_LATLONG, 24, 40), b = desc_of(COHSM_DOMAIN_OCTAHEDRAL, 16, 64);
    cohsm_maps *built[2];
    const cohsm_maps *both[2];
    cohsm_instance bodies[3];
    static const float center[3] = { 0.5f, 0.2f, 0 };
    tally sum = { 0, 0, 0, 0, 0, 0, 0 };
    uint64_t seed = 9;
    uint32_t i;
    int light, filter;
    cohsm_info info;

    both[0] = built[0] = build_maps(&a);
    both[1] = built[1] = build_maps(&b);
    for (i = 0; i < 3; i++) {
        float angle = 0.7f * (float)i, scale = 1.0f + 0.5f * (float)i;
        float m[16] = { 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1 };
        m[0] = m[5] = scale * cosf(angle);
        m[1] = scale * sinf(angle);
        m[4] = -m[1];
        m[10] = scale;
        m[12] = 2.5f * (float)i - 2;
        m[14] = 0.3f * (float)i;
        bodies[i].maps = both[i % 2];
        memcpy(bodies[i].transform, m, sizeof m);
    }
    cohsm_get_info(built[0], &info);
    upload(t, both, 2, bodies, 3, &maps);
    assert_null(strstr(maps.defines, "COHSM_ONE_DOMAIN="));        /* they differ there */
    assert_non_null(strstr(maps.defines, "CSM_INSTANCES=16"));
    assert_glbk(t, glbk_csm_asker_create(&t->gl, COUNT, &asker));
    for (light = 0; light < 2; light++)
        for (filter = 0; filter < 3; filter++) {
            make_questions(&info, center, 4, (cohsm_light_kind)light, 3, &seed);
            ask_both(t, &asker, &maps, bodies, 3, (cohsm_light_kind)light, (cohsm_filter)filter, 1, &sum);
        }
    printf("%zu queries of scenes: %zu differ, %zu dark, %zu refused\n", sum.asked, sum.wrong, sum.dark, sum.refused);
    assert_true(sum.dark > sum.asked / 20 && sum.refused > 0);
    assert_true((double)sum.wrong < 1e-4 * (double)sum.asked);
    glbk_csm_asker_free(&t->gl, &asker);
    glbk_csm_maps_free(&t->gl, &maps);
    cohsm_free(built[0]);
    cohsm_free(built[1]);
}

/* Clouds of instances of six kinds of maps, most of which a ray misses: in the uniform block and in a table. */
static void instances_that_a_ray_misses_change_nothing(void **state)
{
    GL_TEST(t, state)
    static const float center[3] = { 0, 0, 0 };
    cohsm_maps *built[KINDS];
    cohsm_instance bodies[CLOUD];
    glbk_csm_asker asker;
    tally sum = { 0, 0, 0, 0, 0, 0, 0 };
    uint64_t seed = 77;
    cohsm_info info;
    int i, round;

    build_kinds(built);
    place_instances(bodies, CLOUD, built, &seed, 9, 0);
    cohsm_get_info(built[0], &info);
    assert_glbk(t, glbk_csm_asker_create(&t->gl, COUNT, &asker));
    for (round = 0; round < 12; round++) {
        const cohsm_light_kind light = (cohsm_light_kind)(round & 1);
        const uint32_t count = round & 2 ? CLOUD : 13;
        glbk_csm_maps maps;
        upload(t, (const cohsm_maps *const *)built, KINDS, bodies, count, &maps);
        make_questions(&info, center, 10, light, count, &seed);
        ask_both(t, &asker, &maps, bodies, count, light, (cohsm_filter)(round / 4), 1, &sum);
        glbk_csm_maps_free(&t->gl, &maps);
    }
    printf("%zu queries of clouds: %zu differ, %zu of them lighter, %zu by less than 0.01; %zu dark, %zu refused\n",
           sum.asked, sum.wrong, sum.lighter, sum.slightly, sum.dark, sum.refused);
    assert_true(sum.dark > sum.asked / 20 && sum.refused > sum.asked / 1000);
    assert_true((double)sum.wrong < 1e-4 * (double)sum.asked);
    glbk_csm_asker_free(&t->gl, &asker);
    for (i = 0; i < KINDS; i++) cohsm_free(built[i]);
}

/* CRC-32 of docs/csm-format.md over bytes 16 on, into word 3. */
static void mend(uint32_t *words, size_t size)
{
    const uint8_t *bytes = (const uint8_t *)words;
    uint32_t crc = 0xffffffffu;
    size_t i;
    int bit;
    for (i = 16; i < size; i++)
        for (crc ^= bytes[i], bit = 0; bit < 8; bit++) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    words[3] = ~crc;
}

/* Blocks changed at random, of which csm.h accepts one in a few: what it accepts, it and GL read alike. */
static void hostile_blocks_are_read_alike(void **state)
{
    GL_TEST(t, state)
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 24, 48);
    cohsm_maps *built = build_maps(&d);
    tally sum = { 0, 0, 0, 0, 0, 0, 0 };
    glbk_csm_asker asker;
    uint64_t seed = 77;
    uint32_t tries, accepted = 0, *copy, at;
    size_t size;
    const void *data = cohsm_data(built, &size);

    copy = (uint32_t *)malloc(size);
    assert_non_null(copy);
    assert_glbk(t, glbk_csm_asker_create(&t->gl, COUNT, &asker));
    for (tries = 0; tries < 4000 && accepted < 50; tries++) {
        cohsm_instance body;
        const cohsm_maps *hostile;
        cohsm_maps *maps;
        glbk_csm_maps uploaded;
        cohsm_info info;
        memcpy(copy, data, size);
        at = 24 + rnd_below(&seed, (uint32_t)(size / 4) - 24);         /* past what names the domain */
        copy[at] ^= 1u << rnd_below(&seed, 32);
        if (tries % 2) copy[at] = rnd_u32(&seed);
        mend(copy, size);
        if (cohsm_open(copy, size, NULL, &maps) != COHSM_OK) continue;
        accepted++;
        body.maps = hostile = maps;
        memcpy(body.transform, upright, sizeof upright);
        cohsm_get_info(maps, &info);
        upload(t, &hostile, 1, &body, 1, &uploaded);
        make_questions(&info, info.center, info.radius, COHSM_LIGHT_DIRECTION, 1, &seed);
        ask_both(t, &asker, &uploaded, &body, 1, COHSM_LIGHT_DIRECTION, COHSM_FILTER_NEAREST, 1, &sum);
        glbk_csm_maps_free(&t->gl, &uploaded);
        cohsm_free(maps);
    }
    printf("%u of %u hostile blocks accepted: %zu queries, %zu differ\n", (unsigned)accepted, (unsigned)tries,
           sum.asked, sum.wrong);
    assert_int_equal(accepted, 50);
    assert_true((double)sum.wrong < 1e-4 * (double)sum.asked);
    free(copy);
    glbk_csm_asker_free(&t->gl, &asker);
    cohsm_free(built);
}

static void refuses_what_is_not_a_block(void **state)
{
    GL_TEST(t, state)
    static uint32_t words[400];
    glbk_csm_block block = { words, sizeof words };
    glbk_csm_maps maps;
    glbk_csm_instance bad = { 0, { 1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, 0 };
    uint32_t start;

    assert_int_equal(glbk_csm_maps_create(&t->gl, &block, 1, 1, &start, &maps), GLBK_ERR_FORMAT);
    words[0] = 0x4d534344;
    words[1] = 2;
    words[2] = 399;
    assert_int_equal(glbk_csm_maps_create(&t->gl, &block, 1, 1, &start, &maps), GLBK_ERR_FORMAT);
    words[2] = 400;
    assert_int_equal(glbk_csm_maps_create(&t->gl, &block, 1, 1, &start, &maps), GLBK_ERR_VERSION);
    words[1] = 1;
    assert_int_equal(glbk_csm_maps_create(&t->gl, NULL, 1, 1, &start, &maps), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_csm_maps_create(&t->gl, NULL, 0, (1u << 28) / 5 + 1, &start, &maps), GLBK_ERR_ARGUMENT);
    assert_int_equal(maps.blocks.name, 0);
    assert_glbk(t, glbk_csm_maps_create(&t->gl, &block, 1, 1, &start, &maps));
    assert_int_equal(glbk_csm_maps_place(&t->gl, &maps, &bad, 1), GLBK_ERR_INPUT);         /* scales unevenly */
    memcpy(bad.transform, upright, sizeof upright);
    assert_int_equal(glbk_csm_maps_place(&t->gl, &maps, &bad, 2), GLBK_ERR_LIMIT);
    bad.start = 100;
    assert_int_equal(glbk_csm_maps_place(&t->gl, &maps, &bad, 1), GLBK_ERR_INPUT);
    glbk_csm_maps_free(&t->gl, &maps);
    glbk_csm_maps_free(&t->gl, &maps);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(refuses_what_is_not_a_block), gl_unit_test(questions_to_scenes_are_answered_as_on_the_cpu),
        gl_unit_test(instances_that_a_ray_misses_change_nothing),
        gl_unit_test(hostile_blocks_are_read_alike), gl_unit_test(queries_of_all_kinds_agree)
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE45 | GL_CORE33 | GL_ES30_BARE);
}
