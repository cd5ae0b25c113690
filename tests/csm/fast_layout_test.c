/* fast_layout_test - the fast layout answers as the compact one does, bit for bit: every domain, order, kind of light,
   filter, instruction set, on shards, scenes and merged maps, and on blocks whose segments do not fit into trays.
   Memory is as documented; what fails leaves nothing behind. */

#define COHSM_STATIC
#define CSM_IMPLEMENTATION
#include "csm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <cmocka.h>
#include "util.h"

enum { POINTS = 700 };

/* ---- two layouts of one block ---- */

static cohsm_maps *opened(const cohsm_maps *maps, cohsm_layout layout, size_t bytes, const cohsm_system *system)
{
    cohsm_maps *out = NULL;
    size_t size = 0;
    const void *data = cohsm_data(maps, &size);
    void *file = malloc(size);
    if (!file) abort();
    assert_non_null(data);
    assert_int_equal(cohsm_write(maps, file, size), COHSM_OK);
    assert_int_equal(cohsm_open_as(file, size, layout, bytes, system, &out), COHSM_OK);
    free(file);
    return out;
}

static void same_depths(const cohsm_maps *a, const cohsm_maps *b)
{
    uint32_t i, pixels;
    uint16_t *x, *y;
    cohsm_info info;
    cohsm_get_info(a, &info);
    pixels = info.pixel_end - info.pixel_begin;
    x = (uint16_t *)malloc(2 * (size_t)pixels);
    y = (uint16_t *)malloc(2 * (size_t)pixels);
    if (!x || !y) abort();
    for (i = 0; i < info.view_count; i++) {
        assert_int_equal(cohsm_depths(a, i, x), COHSM_OK);
        assert_int_equal(cohsm_depths(b, i, y), COHSM_OK);
        assert_memory_equal(x, y, 2 * (size_t)pixels);
    }
    free(x);
    free(y);
}

typedef struct questions { float p[POINTS][5], l[POINTS][3]; uint32_t entity[POINTS]; } questions;

static void fill(questions *q, const cohsm_info *info, cohsm_light_kind kind, uint64_t *seed)
{
    int i, k;
    for (i = 0; i < POINTS; i++) {
        q->entity[i] = rnd_below(seed, 4);
        for (k = 0; k < 3; k++) {
            q->p[i][k] = info->center[k] + info->radius * (float)rnd_in(seed, -1.1, 1.1);
            q->l[i][k] = (float)rnd_in(seed, -1, 1);
            if (kind == COHSM_LIGHT_POSITION) q->l[i][k] = info->center[k] + 4 * info->radius * q->l[i][k];
            if (kind == COHSM_LIGHT_PARAMETER) q->l[i][k] = 0.5f * q->l[i][k] + 0.5f;
        }
        if (kind == COHSM_LIGHT_INDEX) {
            uint32_t index = rnd_below(seed, info->map_count + 1);
            memcpy(q->l[i], &index, 4);
        }
        if (i % 97 == 96) q->p[i][i % 3] = i % 2 ? NAN : 1e30f;
        if (i % 89 == 88) memset(q->l[i], 0, 12);
    }
}

/* All instruction sets; returns how many answers were dark. */
static size_t same_answers(cohsm_maps *a, cohsm_maps *b, const cohsm_query *q)
{
    float x[POINTS], y[POINTS];
    size_t rx = 0, ry = 0, dark = 0, i;
    cohsm_result r;
    int simd;
    r = cohsm_visible(a, q, x, &rx);
    for (simd = cohsm__simd(); simd >= 0; simd--) {
        b->simd = simd;
        memset(y, 0xa5, sizeof y);
        assert_int_equal(cohsm_visible(b, q, y, &ry), r);
        if (r != COHSM_OK) continue;
        assert_memory_equal(x, y, q->count * sizeof *x);
        assert_int_equal(rx, ry);
    }
    b->simd = cohsm__simd();
    for (i = 0; r == COHSM_OK && i < q->count; i++) dark += x[i] < 1.0f;
    return dark;
}

static void same_scene(const cohsm_maps *a, const cohsm_maps *b, const cohsm_query *q)
{
    cohsm_instance s[2][3];
    float x[POINTS], y[POINTS];
    int i, k;
    memset(s, 0, sizeof s);
    for (i = 0; i < 3; i++)
        for (k = 0; k < 2; k++) {
            float *t = s[k][i].transform;
            s[k][i].maps = k ? b : a;
            t[0] = t[5] = t[10] = 1.0f - 0.25f * (float)i;
            t[12] = 0.5f * (float)i;
            t[15] = 1.0f;
        }
    if (cohsm_visible_scene(s[0], 3, q, x, NULL) != COHSM_OK) return;
    assert_int_equal(cohsm_visible_scene(s[1], 3, q, y, NULL), COHSM_OK);
    assert_memory_equal(x, y, q->count * sizeof *x);
}

/* Every kind of light and filter, points and lights packed and interleaved; returns how many answers were dark. */
static size_t same_everywhere(cohsm_maps *a, cohsm_maps *b)
{
    static questions data;
    static float packed[POINTS][3];
    uint64_t seed = 77;
    size_t dark = 0;
    cohsm_info info;
    int kind, filter, way, i;

    cohsm_get_info(a, &info);
    assert_int_equal(info.layout, COHSM_LAYOUT_COMPACT);
    assert_int_equal(info.fast_bytes, 0);
    cohsm_get_info(b, &info);
    assert_int_equal(info.layout, COHSM_LAYOUT_FAST);
    assert_true(info.fast_bytes > 0);
    same_depths(a, b);
    for (kind = COHSM_LIGHT_DIRECTION; kind < COHSM_LIGHT_COUNT; kind++)
        for (filter = 0; filter < COHSM_FILTER_COUNT; filter++)
            for (way = 0; way < 4; way++) {
                cohsm_query q;
                memset(&q, 0, sizeof q);
                fill(&data, &info, (cohsm_light_kind)kind, &seed);
                for (i = 0; i < POINTS; i++) memcpy(packed[i], data.p[i], 12);
                q.positions = way & 1 ? data.p[0] : packed[0];
                q.position_stride = way & 1 ? sizeof data.p[0] : 0;
                q.lights = data.l;
                q.light_stride = 12;
                q.count = POINTS - (size_t)way;
                q.one_light = way >> 1;
                q.light_kind = (cohsm_light_kind)kind;
                q.filter = (cohsm_filter)filter;
                q.seed = 5;
                q.entities = data.entity;
                dark += same_answers(a, b, &q);
                same_scene(a, b, &q);
            }
    return dark;
}

static size_t compare(const cohsm_desc *d, const cohsm_mesh *mesh)
{
    cohsm_maps *a = NULL, *b;
    size_t dark;
    assert_int_equal(cohsm_build(d, mesh, &a, NULL), COHSM_OK);
    b = opened(a, COHSM_LAYOUT_FAST, 0, NULL);
    dark = same_everywhere(a, b);
    cohsm_free(a);
    cohsm_free(b);
    return dark;
}

/* ---- meshes ---- */

static void every_domain_order_and_orientation_answers_alike(void **state)
{
    model torus = model_torus(24, 12, 0.7, 0.25), soup = model_soup(120, 0.2, 9);
    size_t i;
    (void)state;
    for (i = 0; i < sizeof csm_kinds / sizeof *csm_kinds; i++) {
        cohsm_mesh mesh = mesh_of(i % 2 ? &torus : &soup);
        cohsm_desc d = desc_of(csm_kinds[i].domain, csm_kinds[i].side, 24);
        d.order = csm_kinds[i].order;
        d.orientation = csm_kinds[i].orientation;
        d.layers = i % 2 ? (cohsm_layers)(1 + i % 3) : COHSM_LAYERS_Z1Z2;
        d.depth_bits = 4 + (uint32_t)(i % 5);
        d.self_only = i % 4 == 3;
        place_domain(&d, -1, 1.75f, -1, 2);
        assert_true(compare(&d, &mesh) > 100);
    }
    model_free(&torus);
    model_free(&soup);
}

static void a_list_answers_alike(void **state)
{
    static const float where[12] = { 0, 2, 0, 1, 1, 2, 0, 1, 2, 1, 0, 1 };
    model torus = model_torus(24, 12, 0.7, 0.25);
    cohsm_mesh mesh = mesh_of(&torus);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LIST, 0, 20);
    (void)state;
    d.domain.locations = where;
    d.domain.location_count = 3;
    assert_true(compare(&d, &mesh) > 100);
    model_free(&torus);
}

/* More than one chunk of 65,536 views, and a last bucket that is not full. */
static void more_than_a_chunk_answers_alike(void **state)
{
    model box = model_cube(0.6, 1);
    cohsm_mesh mesh = mesh_of(&box);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 258, 8);
    (void)state;
    d.order = COHSM_ORDER_HILBERT;
    d.orientation = COHSM_ORIENTATION_TWO_POLES;
    assert_true(compare(&d, &mesh) > 100);
    model_free(&box);
}

static void shards_and_merged_maps_answer_alike(void **state)
{
    model torus = model_torus(24, 12, 0.7, 0.25);
    cohsm_mesh mesh = mesh_of(&torus);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 24, 24);
    cohsm_maps *whole = NULL, *shard[2], *merged = NULL;
    int i;
    (void)state;
    d.order = COHSM_ORDER_ZIGZAG;
    assert_int_equal(cohsm_build(&d, &mesh, &whole, NULL), COHSM_OK);
    for (i = 0; i < 2; i++) {
        d.pixel_begin = i ? 301 : 0;
        d.pixel_end = i ? 576 : 301;
        assert_true(compare(&d, &mesh) > 100);
        d.layout = COHSM_LAYOUT_FAST;
        assert_int_equal(cohsm_build(&d, &mesh, &shard[i], NULL), COHSM_OK);
        d.layout = COHSM_LAYOUT_COMPACT;
    }
    assert_int_equal(cohsm_merge((const cohsm_maps *const *)shard, 2, NULL, &merged), COHSM_OK);
    assert_true(same_everywhere(whole, merged) > 100);
    for (i = 0; i < 2; i++) cohsm_free(shard[i]);
    cohsm_free(whole);
    cohsm_free(merged);
    model_free(&torus);
}

/* ---- what does not fit ---- */

/* Trays by their splits, and parts whose depths stand one by one. */
static void count_trays(const cohsm_maps *m, size_t *split, size_t *spread)
{
    uint32_t bucket, p, part;
    memset(split, 0, 4 * sizeof *split);
    *spread = 0;
    for (bucket = 0; bucket << 8 < m->head.view_count; bucket++)
        for (p = 0; p < m->range; p++) {
            uint32_t s = m->trays.at[bucket * m->range + p] >> 14u;
            split[s]++;
            for (part = 0; part < 1u << s; part++)
                *spread += s == 3 && cohsm__tray_is_spread(cohsm__tray_at(m, p, bucket << 8 | part << 5));
        }
}

static void what_does_not_fit_into_trays_answers_alike(void **state)
{
    cohsm_maps *a = torture_maps(COHSM_LAYOUT_COMPACT), *b = torture_maps(COHSM_LAYOUT_FAST);
    size_t split[4], spread;
    (void)state;
    count_trays(b, split, &spread);
    print_message("torture: trays whole %lu, in 2 %lu, in 4 %lu, in 8 %lu; %lu parts spread\n", (unsigned long)split[0],
                  (unsigned long)split[1], (unsigned long)split[2], (unsigned long)split[3], (unsigned long)spread);
    assert_true(split[0] > 0 && split[1] > 0 && split[2] > 0 && split[3] > 400 && spread > 400);
    assert_true(same_everywhere(a, b) > 100);
    cohsm_free(a);
    cohsm_free(b);
}

/* ---- memory, files, services ---- */

static void files_do_not_depend_on_the_layout(void **state)
{
    model torus = model_torus(24, 12, 0.7, 0.25);
    cohsm_mesh mesh = mesh_of(&torus);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 24, 24);
    cohsm_maps *a = NULL, *b = NULL;
    cohsm_report report;
    size_t x = 0, y = 0;
    void *pack[2];
    (void)state;
    assert_int_equal(cohsm_build(&d, &mesh, &a, NULL), COHSM_OK);
    d.layout = COHSM_LAYOUT_FAST;
    assert_int_equal(cohsm_build(&d, &mesh, &b, NULL), COHSM_OK);
    cohsm_data(a, &x);
    cohsm_data(b, &y);
    assert_int_equal(x, y);
    assert_memory_equal(cohsm_data(a, NULL), cohsm_data(b, NULL), x);
    assert_int_equal(cohsm_pack(a, NULL, &pack[0], &x), COHSM_OK);
    assert_int_equal(cohsm_pack(b, NULL, &pack[1], &y), COHSM_OK);
    assert_int_equal(x, y);
    assert_memory_equal(pack[0], pack[1], x);
    assert_int_equal(cohsm_verify(b, NULL, &mesh, &report), COHSM_OK);
    assert_int_equal(report.wrong, 0);
    assert_true(report.entries > 0);
    /* verify reads what questions read: the trays */
    memset((uint8_t *)b->trays.memory + 64, 0, b->trays.bytes / 2);
    assert_int_equal(cohsm_verify(b, NULL, &mesh, &report), COHSM_OK);
    assert_true(report.wrong > 0);
    free(pack[0]);
    free(pack[1]);
    cohsm_free(a);
    cohsm_free(b);
    model_free(&torus);
}

static void a_budget_counts_block_and_trays(void **state)
{
    model torus = model_torus(24, 12, 0.7, 0.25);
    cohsm_mesh mesh = mesh_of(&torus);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 24, 24);
    cohsm_maps *a = NULL, *b;
    cohsm_info info, other;
    (void)state;
    d.layout = COHSM_LAYOUT_FAST;
    assert_int_equal(cohsm_build(&d, &mesh, &a, NULL), COHSM_OK);
    cohsm_get_info(a, &info);
    b = opened(a, COHSM_LAYOUT_BUDGET, info.bytes + info.fast_bytes, NULL);
    cohsm_get_info(b, &other);
    assert_int_equal(other.layout, COHSM_LAYOUT_FAST);
    assert_int_equal(other.fast_bytes, info.fast_bytes);
    assert_memory_equal(a->trays.at, b->trays.at, 2 * 3 * 576);
    cohsm_free(b);
    b = opened(a, COHSM_LAYOUT_BUDGET, info.bytes + info.fast_bytes - 1, NULL);
    cohsm_get_info(b, &other);
    assert_int_equal(other.layout, COHSM_LAYOUT_COMPACT);
    cohsm_free(b);
    b = opened(a, COHSM_LAYOUT_BUDGET, 0, NULL);
    cohsm_get_info(b, &other);
    assert_int_equal(other.layout, COHSM_LAYOUT_COMPACT);
    cohsm_free(b);
    cohsm_free(a);
    d.layout = COHSM_LAYOUT_BUDGET;
    d.layout_bytes = info.bytes + info.fast_bytes;
    assert_int_equal(cohsm_build(&d, &mesh, &a, NULL), COHSM_OK);
    cohsm_get_info(a, &other);
    assert_int_equal(other.layout, COHSM_LAYOUT_FAST);
    cohsm_free(a);
    model_free(&torus);
}

/* 0.5 MB a worker beside block, trays and object; what a build reports is what it asked for. */
static void memory_is_as_documented(void **state)
{
    model torus = model_torus(24, 12, 0.7, 0.25);
    cohsm_mesh mesh = mesh_of(&torus);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 48, 64);
    cohsm_maps *a = NULL, *b;
    cohsm_system system;
    cohsm_stats s;
    cohsm_info info;
    team four;
    ledger l;
    int threads;
    (void)state;
    memset(&four, 0, sizeof four);
    four.threads = 4;
    pthread_mutex_init(&four.lock, NULL);
    assert_int_equal(cohsm_build(&d, &mesh, &a, NULL), COHSM_OK);
    for (threads = 0; threads < 2; threads++) {
        memset(&system, 0, sizeof system);
        system.allocator = ledger_allocator(&l);
        system.parallel_for = threads ? team_for : NULL;
        system.user = &four;
        b = opened(a, COHSM_LAYOUT_FAST, 0, &system);
        cohsm_get_info(b, &info);
        assert_true(l.peak <= info.bytes + info.fast_bytes + (threads ? 8u : 1u) * 500000u + 8192);
        assert_true(l.used <= info.bytes + info.fast_bytes + 8192);
        assert_true(same_everywhere(a, b) > 100);
        cohsm_free(b);
        assert_int_equal(l.live, 0);
        d.system = system;
        d.layout = COHSM_LAYOUT_FAST;
        d.order = COHSM_ORDER_ZIGZAG;
        d.system.allocator = ledger_allocator(&l);
        assert_int_equal(cohsm_build(&d, &mesh, &b, &s), COHSM_OK);
        assert_int_equal(s.peak_bytes, l.peak);
        cohsm_free(b);
        assert_int_equal(l.live, 0);
    }
    cohsm_free(a);
    pthread_mutex_destroy(&four.lock);
    model_free(&torus);
}

static int stop_late(void *user, float fraction)
{
    *(float *)user = fraction;
    return fraction > 0.8f;
}

static void trays_can_be_cancelled_and_refused(void **state)
{
    model torus = model_torus(24, 12, 0.7, 0.25);
    cohsm_mesh mesh = mesh_of(&torus);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 24, 64);
    cohsm_maps *a = NULL, *b = NULL;
    cohsm_system system;
    size_t size = 0;
    const void *data;
    ledger l;
    float last = 0;
    (void)state;
    assert_int_equal(cohsm_build(&d, &mesh, &a, NULL), COHSM_OK);
    data = cohsm_data(a, &size);
    memset(&system, 0, sizeof system);
    system.allocator = ledger_allocator(&l);
    system.progress = stop_late;
    system.user = &last;
    if (cohsm__host_is_little_endian()) {
        assert_int_equal(cohsm_open_as(data, size, COHSM_LAYOUT_FAST, 0, &system, &b), COHSM_ERR_CANCELLED);
        assert_true(last > 0.8f && l.live == 0 && !b);
        assert_int_equal(cohsm_open_as(data, size, COHSM_LAYOUT_COUNT, 0, NULL, &b), COHSM_ERR_ARGUMENT);
        assert_int_equal(cohsm_open_as(NULL, size, COHSM_LAYOUT_FAST, 0, NULL, &b), COHSM_ERR_ARGUMENT);
        assert_int_equal(cohsm_open_as(data, size, COHSM_LAYOUT_FAST, 0, NULL, NULL), COHSM_ERR_ARGUMENT);
        assert_int_equal(cohsm_open_as(data, size - 4, COHSM_LAYOUT_FAST, 0, NULL, &b), COHSM_ERR_FORMAT);
    }
    d.layout = COHSM_LAYOUT_COUNT;
    assert_int_equal(cohsm_build(&d, &mesh, &b, NULL), COHSM_ERR_DESC);
    assert_null(b);
    cohsm_free(a);
    model_free(&torus);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_domain_order_and_orientation_answers_alike),
        cmocka_unit_test(a_list_answers_alike),
        cmocka_unit_test(more_than_a_chunk_answers_alike),
        cmocka_unit_test(shards_and_merged_maps_answer_alike),
        cmocka_unit_test(what_does_not_fit_into_trays_answers_alike),
        cmocka_unit_test(files_do_not_depend_on_the_layout),
        cmocka_unit_test(a_budget_counts_block_and_trays),
        cmocka_unit_test(memory_is_as_documented),
        cmocka_unit_test(trays_can_be_cancelled_and_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
