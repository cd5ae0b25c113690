/* gl_rows_test - rows of docs/conformance.md by cohsm_light_kind: those of tests/csm/rows.h, on the core path. */
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

#define CONFORM_BACKEND "gl"
#include "conformance.h"
#include "gl_test.h"
#include "util.h"

static gl_test *now;                    /* of the test that runs */

#define ROW_TEST(state) GL_TEST(test_, state) now = test_;
#include "rows.h"

enum { MOST = 1 << 18, INSTANCES = 2 };

/* Made when they are first asked for. */
static glbk_csm_asker asker;
static struct { const cohsm_maps *of; glbk_csm_maps maps; uint32_t start; } uploaded;

static void forget_maps(void)
{
    glbk_csm_maps_free(&now->gl, &uploaded.maps);
    memset(&uploaded, 0, sizeof uploaded);
}

static int end_tests(void **state)
{
    gl_test *t = (gl_test *)*state;
    if (t->context) {
        forget_maps();
        glbk_csm_asker_free(&t->gl, &asker);
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
        block.data = cohsm_data(instances[0].maps, &block.bytes);
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
    const size_t size = q->light_kind == COHSM_LIGHT_INDEX ? 4 : 12;
    cohsm_query g = *q;
    size_t i;
    assert_true(q->count <= MOST && !q->entities);
    if (!asker.capacity) assert_glbk(now, glbk_csm_asker_create(&now->gl, MOST, &asker));
    place(instances, count);
    if (!g.light_stride) g.light_stride = size;
    assert_glbk(now, glbk_csm_ask_upload(&now->gl, &asker, &g));
    assert_glbk(now, glbk_csm_ask_run(&now->gl, &asker, &uploaded.maps, (uint32_t)g.count));
    assert_glbk(now, glbk_csm_ask_read(&now->gl, &asker, (uint32_t)g.count, v));
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
