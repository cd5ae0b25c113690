/* alloc_test - every allocation of shadowfield.h fails, once and from then on: an error, nothing leaks, outputs
   are untouched. */
#include "shadowfield.h"
#include "util.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* An entity of no fields that stands at the origin, not tinted. */
static const sfield_entity upright = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };

static model soup;
static sfield_field *field[3];
static uint8_t *bytes;
static size_t byte_count;

/* One way through the header with an allocator; SFIELD_OK or what failed. */
static sfield_result run(int which, sfield_allocator *a)
{
    static const float p[12] = { 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 1 }, n[12] = { 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0 };
    sfield_mesh mesh = mesh_of(&soup);
    sfield_desc d = small_desc(which & 1 ? SFIELD_BASIS_HAAR : SFIELD_BASIS_SH);
    sfield_system system = { 0 };
    sfield_emitter light;
    sfield_field *f = (sfield_field *)(void *)bytes, *untouched = f;
    sfield_result r = SFIELD_OK;
    d.system.allocator = system.allocator = *a;
    d.shell_count = 2;
    d.position_side = 2;
    d.cube_side = 4;
    memset(&light, 0, sizeof light);
    light.radius = 1;
    light.radiance[0] = 1;
    if (which < 2) r = sfield_build(&d, &mesh, &f, NULL);
    else if (which < 4) r = sfield_build_emitter(&d, &light, &f, NULL);
    else if (which < 6) r = sfield_build_self(&d, &mesh, AT(p, n, 4), 0.01f, &f, NULL);
    else if (which == 6) {
        d.logarithm = 1;
        r = sfield_build(&d, &mesh, &f, NULL);
    } else if (which == 7) {
        r = sfield_open(bytes, byte_count, &system, &f);
        if (r == SFIELD_OK) {
            const sfield_field *part = f;
            sfield_field *whole = NULL;
            r = sfield_merge(&part, 1, &system, &whole);
            sfield_free(whole);
            if (r != SFIELD_OK) {
                sfield_free(f);
                f = untouched;
            }
        }
    } else if (which == 8) {
        double out[16];
        float c[32] = { 1 };
        r = sfield_sh_product_n(4, 2, c, &system, out);
    } else if (which == 9) {
        sfield_algebra *t;
        float c[16] = { 3 };
        r = sfield_algebra_create(4, &system, &t);
        if (r != SFIELD_OK) return r;
        r = sfield_sh_log(t, c, c);
        sfield_algebra_free(t);
    } else if (which == 10) {
        uint32_t chosen[4], sources[12];
        float w[12];
        size_t count;
        r = sfield_sparse(AT(p, n, 4), 0.5f, &system, chosen, &count, sources, w);
    } else if (which >= 13) {
        d = small_desc(which == 13 ? SFIELD_BASIS_SH : SFIELD_BASIS_HAAR);
        d.system.allocator = *a;
        d.shard_end = 2;
        r = sfield_build(&d, &mesh, &f, NULL);
        if (r == SFIELD_OK) sfield_free(f);
        else assert_ptr_equal(f, untouched);
    } else {
        sfield_scene_desc sd;
        sfield_scene *s;
        sfield_entity e[2];
        sfield_points set;
        float rgb[12], sky[3] = { 1, 1, 1 };
        memset(&sd, 0, sizeof sd);
        memset(&set, 0, sizeof set);
        sd.basis = which == 11 ? SFIELD_BASIS_SH : SFIELD_BASIS_HAAR;
        sd.cube_side = 8;
        sd.system.allocator = *a;
        r = sfield_scene_create(&sd, &s);
        if (r != SFIELD_OK) return r;
        e[0] = upright;
        e[0].occlusion = field[which - 10];
        e[1] = e[0];
        matrix_of(e[1].transform, 1, 1, 1, 1, 1, 3, 0, 0);
        r = sfield_scene_entities(s, e, 2);
        if (r == SFIELD_OK) r = sfield_scene_environment(s, sky, 1, 1, NULL);
        set.count = 4;
        set.positions = p;
        set.normals = n;
        set.entity = 0;
        set.rgb = rgb;
        if (r == SFIELD_OK) r = sfield_cache_create(s, 4, 1, &set.cache);
        if (r == SFIELD_OK) r = sfield_shade(s, &set, 1, NULL);
        sfield_cache_free(set.cache);
        sfield_scene_free(s);
        return r;
    }
    if (r == SFIELD_OK && which < 8) sfield_free(f);
    else if (which < 8) assert_ptr_equal(f, untouched);
    return r;
}

static int setup(void **state)
{
    sfield_mesh mesh;
    sfield_desc d;
    sfield_field *shard;
    int b;
    (void)state;
    soup = model_soup(5, 0.5, 9);
    mesh = mesh_of(&soup);
    for (b = 1; b < 3; b++) {
        d = small_desc((sfield_basis)b);
        d.shell_count = 2;
        d.position_side = 2;
        assert_int_equal(sfield_build(&d, &mesh, &field[b], NULL), SFIELD_OK);
    }
    d.shard_end = 2;
    assert_int_equal(sfield_build(&d, &mesh, &shard, NULL), SFIELD_OK);
    byte_count = sfield_bytes(shard);
    bytes = (uint8_t *)malloc(byte_count);
    sfield_write(shard, bytes, byte_count);
    sfield_free(shard);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    sfield_free(field[1]);
    sfield_free(field[2]);
    free(bytes);
    model_free(&soup);
    return 0;
}

static void every_allocation_fails(void **state)
{
    size_t failed = 0;
    int which, forever;
    (void)state;
    for (which = 0; which < 15; which++) {
        counting c;
        sfield_allocator a = counting_allocator(&c);
        size_t calls, i;
        memset(&c, 0, sizeof c);
        assert_int_equal(run(which, &a), SFIELD_OK);
        assert_int_equal(c.now, 0);
        calls = c.calls;
        assert_true(calls > 0);
        for (forever = 0; forever < 2; forever++)
            for (i = 1; i <= calls; i++, failed++) {
                memset(&c, 0, sizeof c);
                c.fail_at = i;
                c.forever = forever;
                assert_int_equal(run(which, &a), SFIELD_ERR_ALLOC);
                assert_int_equal(c.now, 0);
            }
    }
    print_message("alloc: %lu failures\n", (unsigned long)failed);
}

static void *filled(size_t size, void *user)
{
    void *p = malloc(size);
    if (p) memset(p, *(int *)user, size);
    return p;
}

static void give_back(void *p, void *user)
{
    (void)user;
    free(p);
}

/* What memory held before is in no block; a shard leaves most of its block out. */
static void blocks_do_not_depend_on_memory(void **state)
{
    sfield_mesh mesh = mesh_of(&soup);
    (void)state;
    for (int which = 0; which < 4; which++) {
        uint8_t *block[2];
        size_t size[2];
        for (int k = 0; k < 2; k++) {
            sfield_desc d = small_desc(which & 1 ? SFIELD_BASIS_HAAR : SFIELD_BASIS_SH);
            sfield_field *f;
            int fill = k ? 0xa5 : 0x3c;
            d.system.allocator.alloc_fn = filled;
            d.system.allocator.free_fn = give_back;
            d.system.allocator.user = &fill;
            if (which >= 2) d.shard_begin = 1, d.shard_end = 2;
            assert_int_equal(sfield_build(&d, &mesh, &f, NULL), SFIELD_OK);
            size[k] = sfield_bytes(f);
            block[k] = (uint8_t *)malloc(size[k]);
            assert_int_equal(sfield_write(f, block[k], size[k]), SFIELD_OK);
            sfield_free(f);
        }
        assert_int_equal(size[0], size[1]);
        assert_memory_equal(block[0], block[1], size[0]);
        free(block[0]);
        free(block[1]);
    }
}

static void peak_is_what_the_allocator_saw(void **state)
{
    sfield_mesh mesh = mesh_of(&soup);
    int b;
    (void)state;
    for (b = 1; b < 3; b++) {
        counting c;
        sfield_desc d = small_desc((sfield_basis)b);
        sfield_stats stats;
        sfield_field *f;
        memset(&c, 0, sizeof c);
        d.system.allocator = counting_allocator(&c);
        assert_int_equal(sfield_build(&d, &mesh, &f, &stats), SFIELD_OK);
        print_message("peak: said %lu, was %lu\n", (unsigned long)stats.peak_bytes, (unsigned long)c.peak);
        assert_true((double)stats.peak_bytes > 0.97 * (double)c.peak &&
                    (double)stats.peak_bytes < 1.03 * (double)c.peak);
        sfield_free(f);
        assert_int_equal(c.now, 0);
    }
}

/* "12 bytes a vertex, 52 a triangle, 0.2 MB for each of 16 tasks", the field, and the samples of one shell. */
static void peak_is_what_the_header_says(void **state)
{
    double peak[2], mesh_bytes[2];
    (void)state;
    for (int i = 0; i < 2; i++) {
        model m = model_sphere(i ? 200 : 12, i ? 100 : 6, 1);
        sfield_mesh mesh = mesh_of(&m);
        sfield_desc d = small_desc(SFIELD_BASIS_SH);
        sfield_stats stats;
        sfield_field *f;
        double samples, kept;
        d.cube_side = 0;
        assert_int_equal(sfield_build(&d, &mesh, &f, &stats), SFIELD_OK);
        samples = 6.0 * d.position_side * d.position_side * 16 * sizeof(float);
        kept = (double)sfield_bytes(f);
        peak[i] = (double)stats.peak_bytes - kept - samples;
        mesh_bytes[i] = 12 * (double)mesh.vertex_count + 52 * (double)mesh.index_count / 3;
        print_message("mesh %.0f, field %.0f, samples %.0f, the rest %.0f\n", mesh_bytes[i], kept, samples, peak[i]);
        assert_true(peak[i] > 0.9 * (mesh_bytes[i] + 16 * 2e5) && peak[i] < 1.1 * (mesh_bytes[i] + 16 * 2e5));
        sfield_free(f);
        model_free(&m);
    }
    assert_true(fabs((peak[1] - peak[0]) / (mesh_bytes[1] - mesh_bytes[0]) - 1) < 0.01);
}

typedef struct most { size_t asked; } most;

static void *most_alloc(size_t size, void *user)
{
    most *m = (most *)user;
    m->asked = size > m->asked ? size : m->asked;
    return size < (size_t)1 << 29 ? malloc(size) : NULL;
}

static void most_free(void *memory, void *user)
{
    (void)user;
    free(memory);
}

static void one_by_one(void *user, size_t count, sfield_task task, void *context)
{
    size_t i;
    (void)user;
    for (i = 0; i < count; i++) task(context, i);
}

/* Entities that all hide and shine, for sixteen tasks: 4.4 GB of scratch, more than a size_t of 32 bits can say. */
static void scratch_of_too_many_entities_is_refused(void **state)
{
    enum { MANY = 11000 };
    sfield_entity *e = (sfield_entity *)malloc(MANY * sizeof *e);
    sfield_scene_desc d;
    sfield_emitter light;
    sfield_desc small = small_desc(SFIELD_BASIS_SH);
    sfield_field *lamp;
    sfield_scene *s;
    sfield_points none;
    most m = { 0 };
    int i;
    (void)state;
    assert_non_null(e);
    memset(&d, 0, sizeof d);
    memset(&light, 0, sizeof light);
    memset(&none, 0, sizeof none);
    light.radius = 1;
    small.shell_count = 2;
    small.position_side = 2;
    assert_int_equal(sfield_build_emitter(&small, &light, &lamp, NULL), SFIELD_OK);
    d.system.allocator.alloc_fn = most_alloc;
    d.system.allocator.free_fn = most_free;
    d.system.allocator.user = &m;
    d.system.parallel_for = one_by_one;
    assert_int_equal(sfield_scene_create(&d, &s), SFIELD_OK);
    for (i = 0; i < MANY; i++) {
        e[i] = upright;
        e[i].occlusion = field[1];
        e[i].source = lamp;
    }
    assert_int_equal(sfield_scene_entities(s, e, MANY), SFIELD_OK);
    assert_true(m.asked < 1 << 29);
    assert_int_equal(sfield_shade(s, &none, 1, NULL), SFIELD_ERR_ALLOC);
    if (sizeof(size_t) > 4) assert_true((uint64_t)m.asked > 16 * (uint64_t)MANY * MANY * 2);
    sfield_scene_free(s);
    sfield_free(lamp);
    free(e);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_allocation_fails),
        cmocka_unit_test(blocks_do_not_depend_on_memory),
        cmocka_unit_test(peak_is_what_the_allocator_saw),
        cmocka_unit_test(peak_is_what_the_header_says),
        cmocka_unit_test(scratch_of_too_many_entities_is_refused),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
