/* alloc_test - an allocation that fails, at every site: once, and from then on. No crash, no leak, COHSM_ERR_ALLOC,
   and outputs untouched. The allocator fills what it gives and what it takes back. */

#include "csm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include "util.h"

typedef struct plan {
    cohsm_desc   desc;
    cohsm_mesh   mesh;
    cohsm_maps  *maps, *shard[2];
    void        *file;
    size_t       file_size;
} plan;

static char untouched_byte;
#define UNTOUCHED ((void *)&untouched_byte)

/* Each runs one call with the ledger's allocator and gives back what it made. */
typedef cohsm_result (*action)(plan *p, const cohsm_allocator *a);

static cohsm_result act_build(plan *p, const cohsm_allocator *a)
{
    cohsm_desc d = p->desc;
    cohsm_maps *maps = (cohsm_maps *)UNTOUCHED;
    cohsm_stats s, before;
    cohsm_result r;
    memset(&s, 0x5a, sizeof s);
    before = s;
    d.system.allocator = *a;
    r = cohsm_build(&d, &p->mesh, &maps, &s);
    if (r == COHSM_OK) cohsm_free(maps);
    else {
        assert_ptr_equal(maps, UNTOUCHED);
        assert_memory_equal(&s, &before, sizeof s);
    }
    return r;
}

static cohsm_desc services(const cohsm_allocator *a)
{
    cohsm_desc d;
    memset(&d, 0, sizeof d);
    d.system.allocator = *a;
    return d;
}

static cohsm_result act_verify(plan *p, const cohsm_allocator *a)
{
    cohsm_desc d = services(a);
    cohsm_report report, before;
    cohsm_result r;
    memset(&report, 0x5a, sizeof report);
    before = report;
    r = cohsm_verify(p->maps, &d.system, &p->mesh, &report);
    if (r != COHSM_OK) assert_memory_equal(&report, &before, sizeof report);
    else assert_int_equal(report.wrong, 0);
    return r;
}

static cohsm_result act_merge(plan *p, const cohsm_allocator *a)
{
    cohsm_desc d = services(a);
    cohsm_maps *maps = (cohsm_maps *)UNTOUCHED;
    cohsm_result r = cohsm_merge((const cohsm_maps *const *)p->shard, 2, &d.system, &maps);
    if (r == COHSM_OK) cohsm_free(maps);
    else assert_ptr_equal(maps, UNTOUCHED);
    return r;
}

static cohsm_result act_open(plan *p, const cohsm_allocator *a)
{
    cohsm_desc d = services(a);
    cohsm_maps *maps = (cohsm_maps *)UNTOUCHED;
    cohsm_result r = cohsm_open(p->file, p->file_size, &d.system, &maps);
    if (r == COHSM_OK) cohsm_free(maps);
    else assert_ptr_equal(maps, UNTOUCHED);
    return r;
}

static cohsm_result act_open_fast(plan *p, const cohsm_allocator *a)
{
    cohsm_desc d = services(a);
    cohsm_maps *maps = (cohsm_maps *)UNTOUCHED;
    cohsm_result r = cohsm_open_as(p->file, p->file_size, COHSM_LAYOUT_FAST, 0, &d.system, &maps);
    if (r == COHSM_OK) cohsm_free(maps);
    else assert_ptr_equal(maps, UNTOUCHED);
    return r;
}

static cohsm_result act_pack(plan *p, const cohsm_allocator *a)
{
    cohsm_desc d = services(a);
    void *data = UNTOUCHED;
    size_t size = 4711;
    cohsm_maps *maps = (cohsm_maps *)UNTOUCHED;
    cohsm_result r = cohsm_pack(p->maps, &d.system, &data, &size);
    if (r != COHSM_OK) {
        assert_ptr_equal(data, UNTOUCHED);
        assert_int_equal(size, 4711);
        return r;
    }
    r = cohsm_open(data, size, &d.system, &maps);
    if (r == COHSM_OK) cohsm_free(maps);
    else assert_ptr_equal(maps, UNTOUCHED);
    a->free_fn(data, a->user);
    return r;
}

/* The caller goes on as if nothing had happened: every call must still be safe, and a finished block must be right. */
static cohsm_result act_builder(plan *p, const cohsm_allocator *a)
{
    cohsm_desc d = p->desc;
    cohsm_builder *b = (cohsm_builder *)UNTOUCHED;
    cohsm_maps *maps = (cohsm_maps *)UNTOUCHED;
    cohsm_result r, worst = COHSM_OK;
    float z1[256], z2[256], z3[256];
    uint64_t seed = 4;
    uint32_t i, k, n;

    d.system.allocator = *a;
    d.radius = 1;
    d.map_side = 16;
    d.order = COHSM_ORDER_HILBERT;
    r = cohsm_builder_create(&d, &b);
    if (r != COHSM_OK) {
        assert_ptr_equal(b, UNTOUCHED);
        return r;
    }
    n = cohsm_builder_view_count(b);
    for (i = 0; i < n; i++) {
        for (k = 0; k < 256; k++) {
            z1[k] = (float)rnd(&seed) * 0.5f;
            z2[k] = z1[k] + 0.1f * (float)rnd(&seed);
            z3[k] = z2[k] + 0.1f;
        }
        r = cohsm_builder_add(b, i, z1, z2, z3);
        if (r != COHSM_OK && worst == COHSM_OK) worst = r;
    }
    r = cohsm_builder_finish(b, &maps, NULL);
    if (r == COHSM_OK) {
        /* a lost batch must never end as a block */
        assert_int_equal(worst, COHSM_OK);
        cohsm_free(maps);
    } else assert_ptr_equal(maps, UNTOUCHED);
    cohsm_builder_free(b);
    return worst != COHSM_OK ? worst : r;
}

static cohsm_result act_budget(plan *p, const cohsm_allocator *a)
{
    cohsm_desc d = p->desc;
    uint32_t side = 12345, size = 54321;
    cohsm_result r;
    d.system.allocator = *a;
    r = cohsm_budget(&d, &p->mesh, 300000, &side, &size);
    if (r != COHSM_OK) {
        assert_int_equal(side, 12345);
        assert_int_equal(size, 54321);
    }
    return r;
}

static void fail_everywhere(const char *name, action act, plan *p, size_t step)
{
    ledger l;
    cohsm_allocator a = ledger_allocator(&l);
    size_t sites, at;
    int from_then_on;

    assert_int_equal(act(p, &a), COHSM_OK);
    assert_int_equal(l.live, 0);
    sites = l.calls;
    assert_true(sites > 0);
    for (from_then_on = 0; from_then_on < 2; from_then_on++)
        for (at = 1; at <= sites; at += at < 150 ? 1 : step) {
            cohsm_result r;
            a = ledger_allocator(&l);
            l.fail_at = at;
            l.from_then_on = from_then_on;
            r = act(p, &a);
            if (r != COHSM_ERR_ALLOC)
                fail_msg("%s: call %lu of %lu failed: result %d", name, (unsigned long)at, (unsigned long)sites,
                         (int)r);
            if (l.live || l.wrong)
                fail_msg("%s: call %lu of %lu failed: %lu left", name, (unsigned long)at, (unsigned long)sites,
                         (unsigned long)l.live);
        }
    print_message("allocation: %s: %lu sites failed once and from then on\n", name, (unsigned long)sites);
}

static plan made;
static model shape;

static int setup(void **state)
{
    cohsm_desc d;
    (void)state;
    shape = model_sphere(12, 8, 0.2);
    memset(&made, 0, sizeof made);
    made.mesh = mesh_of(&shape);
    made.desc = desc_of(COHSM_DOMAIN_LATLONG, 9, 16);
    if (cohsm_build(&made.desc, &made.mesh, &made.maps, NULL) != COHSM_OK) return -1;
    made.file_size = 0;
    cohsm_data(made.maps, &made.file_size);
    made.file = malloc(made.file_size);
    if (!made.file || cohsm_write(made.maps, made.file, made.file_size) != COHSM_OK) return -1;
    d = made.desc;
    d.order = COHSM_ORDER_ZIGZAG;
    d.pixel_end = 100;
    if (cohsm_build(&d, &made.mesh, &made.shard[0], NULL) != COHSM_OK) return -1;
    d.pixel_begin = 100;
    d.pixel_end = 256;
    return cohsm_build(&d, &made.mesh, &made.shard[1], NULL) == COHSM_OK ? 0 : -1;
}

static int teardown(void **state)
{
    (void)state;
    cohsm_free(made.maps);
    cohsm_free(made.shard[0]);
    cohsm_free(made.shard[1]);
    free(made.file);
    model_free(&shape);
    return 0;
}

static int everything(void *user, uint32_t triangle, const float weights[3])
{
    (void)user;
    (void)triangle;
    return weights[0] >= 0;
}

static void a_build_survives_failing_memory(void **state)
{
    plan p = made;
    int layers;
    (void)state;
    for (layers = 1; layers <= 3; layers++) {
        p.desc.layers = (cohsm_layers)layers;
        p.desc.order = COHSM_ORDER_ZIGZAG;
        fail_everywhere("build", act_build, &p, 1);
    }
    p.desc.layout = COHSM_LAYOUT_FAST;
    fail_everywhere("build in the fast layout", act_build, &p, 1);
    p.desc.layout = COHSM_LAYOUT_COMPACT;
    p.desc.order = COHSM_ORDER_DEFAULT;
    fail_everywhere("build with a trial of orders", act_build, &p, 1);
    p.desc.order = COHSM_ORDER_ZIGZAG;
    p.mesh.mask_fn = everything;
    fail_everywhere("build with a mask", act_build, &p, 1);
}

static void build_of_local_maps_survives(void **state)
{
    plan p = made;
    static const float where[8] = { 0, 2, 0, 1, 1, 2, 0, 1 };
    (void)state;
    p.desc = desc_of(COHSM_DOMAIN_RECTANGLE, 2, 16);
    place_domain(&p.desc, -1, 2, -1, 2);
    fail_everywhere("build of a rectangle", act_build, &p, 1);
    p.desc = desc_of(COHSM_DOMAIN_LIST, 0, 16);
    p.desc.domain.locations = where;
    p.desc.domain.location_count = 2;
    fail_everywhere("build of a list", act_build, &p, 1);
}

static void other_calls_survive(void **state)
{
    (void)state;
    fail_everywhere("verify", act_verify, &made, 1);
    fail_everywhere("merge", act_merge, &made, 1);
    fail_everywhere("open", act_open, &made, 1);
    fail_everywhere("open as fast", act_open_fast, &made, 1);
    fail_everywhere("pack and open", act_pack, &made, 1);
    fail_everywhere("budget", act_budget, &made, 97);
}

static void a_builder_survives_failing_memory(void **state)
{
    plan p = made;
    (void)state;
    fail_everywhere("builder", act_builder, &p, 1);
    p.desc.layout = COHSM_LAYOUT_FAST;
    fail_everywhere("builder, fast layout", act_builder, &p, 1);
    p.desc.layers = COHSM_LAYERS_Z1Z3_SPHERE;
    fail_everywhere("builder, three layers", act_builder, &p, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_build_survives_failing_memory),
        cmocka_unit_test(build_of_local_maps_survives),
        cmocka_unit_test(other_calls_survive),
        cmocka_unit_test(a_builder_survives_failing_memory),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
