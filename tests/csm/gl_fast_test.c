/* gl_fast_test - GL answers by the fast layout what it answers by the compact one, bit for bit: every domain, order,
   kind of light and filter, scenes of both layouts, trays that are split, spread and full of exact depths. */
#define _POSIX_C_SOURCE 200809L
#include "csm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend/gl_csm.h"

#include "gl_test.h"
#include "util.h"

enum { COUNT = 1024, MOST = 4 };

typedef struct pair { glbk_csm_maps compact, fast; } pair;

typedef struct question { float point[3], light[3]; } question;

static const float identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };

/* Bit i of `fast` says which data of block i is uploaded. */
static void upload(gl_test *t, cohsm_maps *const *maps, uint32_t count, unsigned fast, glbk_csm_maps *out)
{
    glbk_csm_block blocks[MOST];
    glbk_csm_instance instances[MOST];
    uint32_t starts[MOST], i;
    for (i = 0; i < count; i++) {
        blocks[i].data = fast >> i & 1 ? cohsm_fast_data(maps[i], &blocks[i].bytes)
                                       : cohsm_data(maps[i], &blocks[i].bytes);
        assert_non_null(blocks[i].data);
    }
    assert_glbk(t, glbk_csm_maps_create(&t->gl, blocks, count, count, starts, out));
    for (i = 0; i < count; i++) {
        instances[i].start = starts[i];
        instances[i].offset = 0;
        memcpy(instances[i].transform, identity, sizeof identity);
        instances[i].transform[12] = 0.75f * (float)i;
    }
    assert_glbk(t, glbk_csm_maps_place(&t->gl, out, instances, count));
}

static pair upload_both(gl_test *t, cohsm_maps *const *maps, uint32_t count, unsigned fast)
{
    pair p;
    upload(t, maps, count, 0, &p.compact);
    upload(t, maps, count, fast, &p.fast);
    return p;
}

static void free_both(gl_test *t, pair *p)
{
    glbk_csm_maps_free(&t->gl, &p->compact);
    glbk_csm_maps_free(&t->gl, &p->fast);
}

/* Compiled once for all maps of both layouts. */
static glbk_csm_maps general(const glbk_csm_maps *maps)
{
    glbk_csm_maps out = *maps;
    out.defines[0] = 0;
    out.key = 0;
    return out;
}

/* Returns how many answers were dark. */
static unsigned ask_both(gl_test *t, glbk_csm_asker *asker, const pair *p, const cohsm_query *q)
{
    static float a[COUNT], b[COUNT];
    unsigned dark = 0;
    size_t i;
    memset(b, 0xa5, sizeof b);
    assert_glbk(t, glbk_csm_ask_upload(&t->gl, asker, q));
    assert_glbk(t, glbk_csm_ask_run(&t->gl, asker, &p->compact, COUNT));
    assert_glbk(t, glbk_csm_ask_read(&t->gl, asker, COUNT, a));
    assert_glbk(t, glbk_csm_ask_run(&t->gl, asker, &p->fast, COUNT));
    assert_glbk(t, glbk_csm_ask_read(&t->gl, asker, COUNT, b));
    for (i = 0; i < COUNT; i++) dark += a[i] >= 0 && a[i] < 0.5f;
    assert_memory_equal(a, b, sizeof a);
    return dark;
}

static cohsm_query fill(question *questions, const cohsm_info *info, int light, int filter, uint64_t *seed)
{
    cohsm_query q;
    uint32_t i, k;
    memset(&q, 0, sizeof q);
    for (i = 0; i < COUNT; i++) {
        rnd_direction(seed, questions[i].light);
        for (k = 0; k < 3; k++) {
            float *l = &questions[i].light[k];
            questions[i].point[k] = info->center[k] + info->radius * (float)rnd_in(seed, -0.9, 0.9);
            if (light == COHSM_LIGHT_POSITION) *l = info->center[k] + 4 * info->radius * *l;
            if (light == COHSM_LIGHT_PARAMETER) *l = (float)rnd(seed);
        }
        if (light == COHSM_LIGHT_INDEX) {
            uint32_t cell = rnd_below(seed, info->map_count);
            memcpy(questions[i].light, &cell, 4);
        }
    }
    q.positions = questions[0].point;
    q.lights = questions[0].light;
    q.position_stride = q.light_stride = sizeof *questions;
    q.count = COUNT;
    q.light_kind = (cohsm_light_kind)light;
    q.filter = (cohsm_filter)filter;
    q.seed = 3;
    return q;
}

/* All kinds of light and filters that the maps allow, each by programs for both layouts, or one filter by programs for
   one layout alone; own_filter -1: none. Returns how many answers were dark. */
static unsigned same_answers(gl_test *t, glbk_csm_asker *asker, cohsm_maps *maps, int own_filter)
{
    static question questions[COUNT];
    pair own = upload_both(t, &maps, 1, 1), any;
    uint64_t seed = 7;
    unsigned dark = 0;
    cohsm_info info;
    int light, filter;

    cohsm_get_info(maps, &info);
    any.compact = general(&own.compact);
    any.fast = general(&own.fast);
    assert_non_null(strstr(own.compact.defines, "COHSM_ONE_LAYOUT=1"));
    assert_non_null(strstr(own.fast.defines, "COHSM_ONE_LAYOUT=2"));
    for (light = info.positional ? 2 : 0; light < 4; light++)
        for (filter = 0; filter < 3; filter++) {
            cohsm_query q = fill(questions, &info, light, filter, &seed);
            int is_own = filter == own_filter && light == (info.positional ? 2 : 0);
            dark += ask_both(t, asker, is_own ? &own : &any, &q);
        }
    free_both(t, &own);
    return dark;
}

static void every_kind_of_maps_answers_alike(void **state)
{
    GL_TEST(t, state)
    glbk_csm_asker asker;
    size_t i;

    assert_glbk(t, glbk_csm_asker_create(&t->gl, COUNT, &asker));
    for (i = 0; i < sizeof csm_kinds / sizeof csm_kinds[0]; i++) {
        model m = i % 2 ? model_torus(24, 12, 1.0, 0.4) : model_soup(160, 0.3, 9);
        cohsm_mesh mesh = mesh_of(&m);
        cohsm_desc d = desc_of(csm_kinds[i].domain, csm_kinds[i].side, i % 2 ? 48 : 31);
        cohsm_maps *maps = NULL;
        d.order = csm_kinds[i].order;
        d.orientation = csm_kinds[i].orientation;
        d.depth_bits = 4 + (uint32_t)(i % 5);
        d.layout = COHSM_LAYOUT_FAST;
        d.pixel_begin = i == 1 ? 301 : 0;
        d.pixel_end = i == 1 ? 2000 : 0;
        if (d.domain.kind > COHSM_DOMAIN_OCTAHEDRAL) place_domain(&d, 1.6f, 0.9f, 0.3f, 0.5f);
        assert_int_equal(cohsm_build(&d, &mesh, &maps, NULL), COHSM_OK);
        assert_true(same_answers(t, &asker, maps, i < 3 ? (int)i : -1) > COUNT / 4);
        cohsm_free(maps);
        model_free(&m);
    }
    glbk_csm_asker_free(&t->gl, &asker);
}

static void what_does_not_fit_into_trays_answers_alike(void **state)
{
    GL_TEST(t, state)
    cohsm_maps *maps = torture_maps(COHSM_LAYOUT_FAST);
    glbk_csm_asker asker;

    assert_glbk(t, glbk_csm_asker_create(&t->gl, COUNT, &asker));
    assert_true(same_answers(t, &asker, maps, COHSM_FILTER_NEAREST) > COUNT);
    glbk_csm_asker_free(&t->gl, &asker);
    cohsm_free(maps);
}

/* Both layouts stand in one scene, whose programs hold the code of both. */
static void scenes_of_both_layouts_answer_alike(void **state)
{
    GL_TEST(t, state)
    static question questions[COUNT];
    cohsm_maps *maps[3];
    uint64_t seed = 19;
    glbk_csm_asker asker;
    cohsm_info info;
    unsigned dark = 0;
    pair p;
    int i, filter;

    for (i = 0; i < 3; i++) {
        model m = model_torus(24, 12, 1.0, 0.4);
        cohsm_mesh mesh = mesh_of(&m);
        cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 20 + 2 * (uint32_t)i, 32);
        d.layout = COHSM_LAYOUT_FAST;
        assert_int_equal(cohsm_build(&d, &mesh, &maps[i], NULL), COHSM_OK);
        model_free(&m);
    }
    p = upload_both(t, maps, 3, 5);
    assert_null(strstr(p.fast.defines, "COHSM_ONE_LAYOUT="));
    cohsm_get_info(maps[0], &info);
    assert_glbk(t, glbk_csm_asker_create(&t->gl, COUNT, &asker));
    for (filter = 0; filter < 3; filter++) {
        cohsm_query q = fill(questions, &info, COHSM_LIGHT_DIRECTION, filter, &seed);
        dark += ask_both(t, &asker, &p, &q);
    }
    assert_true(dark > COUNT / 4);
    glbk_csm_asker_free(&t->gl, &asker);
    free_both(t, &p);
    for (i = 0; i < 3; i++) cohsm_free(maps[i]);
}

static void fast_data_is_there_where_the_layout_is_fast(void **state)
{
    GL_TEST(t, state)
    cohsm_maps *fast = torture_maps(COHSM_LAYOUT_FAST), *compact = torture_maps(COHSM_LAYOUT_COMPACT);
    glbk_csm_maps uploaded;
    glbk_csm_block block;
    cohsm_info info;
    uint32_t *copy, start;
    size_t bytes = 1;

    assert_null(cohsm_fast_data(compact, &bytes));
    assert_int_equal(bytes, 0);
    assert_null(cohsm_fast_data(NULL, NULL));
    cohsm_get_info(fast, &info);
    block.data = cohsm_fast_data(fast, &block.bytes);
    assert_ptr_equal(block.data, cohsm_fast_data(fast, NULL));
    assert_int_equal(block.bytes % 64, 0);
    assert_true(block.bytes <= info.fast_bytes && block.bytes + 192 > info.fast_bytes);
    copy = (uint32_t *)malloc(block.bytes);
    assert_non_null(copy);
    memcpy(copy, block.data, block.bytes);
    block.data = copy;
    copy[24] += 16;                 /* the half words would end behind the block */
    assert_int_equal(glbk_csm_maps_create(&t->gl, &block, 1, 1, &start, &uploaded), GLBK_ERR_FORMAT);
    assert_non_null(strstr(t->log, "blocks[0]'s sections end at word"));
    copy[24] -= 16;
    assert_glbk(t, glbk_csm_maps_create(&t->gl, &block, 1, 1, &start, &uploaded));
    glbk_csm_maps_free(&t->gl, &uploaded);
    free(copy);
    cohsm_free(fast);
    cohsm_free(compact);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = { gl_unit_test(fast_data_is_there_where_the_layout_is_fast),
                                  gl_unit_test(scenes_of_both_layouts_answer_alike),
                                  gl_unit_test(what_does_not_fit_into_trays_answers_alike),
                                  gl_unit_test(every_kind_of_maps_answers_alike) };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE45 | GL_CORE33 | GL_ES30_BARE);
}
