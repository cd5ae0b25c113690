/* csm_rows_test - rows of docs/conformance.md by glbk_csm_ask: those of tests/conformance/csm_rows.h, on the core
   path. */
#define _POSIX_C_SOURCE 200809L
#include "csm.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend.h"

#define CONFORM_BACKEND "gl"
#include "conformance.h"
#include "gl/gl_test.h"
#include "unit/csm_util.h"

static gl_test *now;                    /* of the test that runs */

#define ROW_TEST(state) GL_TEST(test_, state) now = test_;
#include "conformance/csm_rows.h"

enum { MOST = 1 << 18, INSTANCES = 2 };

/* Made when they are first asked for. */
static glbk_csm_asker asker;
static struct { const cohsm_maps *of; glbk_csm_maps maps; uint32_t start; } uploaded;

static void forget_maps(void)
{
    glbk_csm_maps_destroy(&now->gl, &uploaded.maps);
    memset(&uploaded, 0, sizeof uploaded);
}

static int end_tests(void **state)
{
    gl_test *t = (gl_test *)*state;
    if (t->context) {
        forget_maps();
        glbk_csm_asker_destroy(&t->gl, &asker);
    }
    return gl_teardown(state);
}

static void place(const cohsm_instance *instances, uint32_t count)
{
    glbk_csm_instance placed[INSTANCES];
    uint32_t i;
    assert_true(count <= INSTANCES);
    if (uploaded.of != instances[0].maps) {
        glbk_csm_block block;
        forget_maps();
        block.data = cohsm_data(instances[0].maps, &block.size);
        assert_glbk(now, glbk_csm_maps_create(&now->gl, &block, 1, INSTANCES, &uploaded.start, &uploaded.maps));
        uploaded.of = instances[0].maps;
    }
    for (i = 0; i < count; i++) {
        assert_ptr_equal(instances[i].maps, uploaded.of);
        placed[i].start = uploaded.start;
        placed[i].offset = 0;
        memcpy(placed[i].transform, instances[i].transform, sizeof placed[i].transform);
    }
    assert_glbk(now, glbk_csm_maps_place(&now->gl, &uploaded.maps, placed, count));
}

static void rows_scene(const cohsm_instance *instances, uint32_t count, const cohsm_query *q, float *v, size_t *refused)
{
    static uint32_t items[8 * MOST];
    const size_t stride = q->one_light ? 0 : q->light_stride ? q->light_stride : q->light == COHSM_LIGHT_INDEX ? 4 : 12;
    const size_t size = q->light == COHSM_LIGHT_INDEX ? 4 : 12;
    glbk_csm_questions g;
    size_t i;
    memset(&g, 0, sizeof g);
    assert_true(q->count <= MOST && !q->self);
    if (!asker.capacity) assert_glbk(now, glbk_csm_asker_create(&now->gl, MOST, &asker));
    place(instances, count);
    for (i = 0; i < q->count; i++) {
        uint32_t *item = items + 8 * i;
        memcpy(item, q->points + 3 * i, 12);
        item[3] = GLBK_CSM_NO_SELF;
        memcpy(item + 4, (const char *)q->lights + i * stride, size);
        item[7] = (uint32_t)i;
    }
    g.ask = (glbk_csm_ask)q->light;
    g.filter = (glbk_csm_filter)q->filter;
    g.bias = q->bias;
    g.seed = q->seed;
    g.items = items;
    g.count = (uint32_t)q->count;
    assert_glbk(now, glbk_csm_ask_upload(&now->gl, &asker, &g));
    assert_glbk(now, glbk_csm_ask_run(&now->gl, &asker, &uploaded.maps, g.count));
    assert_glbk(now, glbk_csm_ask_read(&now->gl, &asker, g.count, v));
    if (refused) *refused = 0;
    for (i = 0; refused && i < q->count; i++) *refused += v[i] == COHSM_REFUSED;
}

static void rows_visible(const cohsm_maps *maps, const cohsm_query *q, float *v, size_t *refused)
{
    cohsm_instance one;
    one.maps = maps;
    identity(one.transform);
    rows_scene(&one, 1, q, v, refused);
}

static void rows_free(cohsm_maps *maps)
{
    forget_maps();
    cohsm_free(maps);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
#define ROW(f) cmocka_unit_test_setup_teardown(f, gl_setup, end_tests),
        CSM_ROWS(ROW)
#undef ROW
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE33);
}
