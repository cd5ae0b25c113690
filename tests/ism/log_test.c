/* log_test.c - what ism.h says when a call fails, and what it takes: 16-bit indices, vectors that are nearly unit,
   progress that never falls. */
#include "ism.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "util.h"

enum { W = 16, H = 8 };

typedef struct notes { char line[256]; int lines; float told; int falls, calls; } notes;
typedef struct world {
    ism_mesh mesh;
    ism_source source;
    ism_points view;
    ism_frame frame;
    ism_desc desc;
    ism_maps *maps;
} world;

static soup box;
static grid eye, lit;

static void note(void *user, const char *message)
{
    notes *n = (notes *)user;
    n->lines++;
    snprintf(n->line, sizeof n->line, "%s", message);
}

static int follow(void *user, float fraction)
{
    notes *n = (notes *)user;
    n->falls += fraction < n->told || fraction < 0 || fraction > 1;
    n->told = fraction;
    n->calls++;
    return 0;
}

static void open_world(world *w, notes *n)
{
    const float lo[3] = { -1, 0.5f, -1 }, hi[3] = { 0, 1, 1 }, a[3] = { -2, 0, -2 }, u[3] = { 4, 0, 0 };
    const float v[3] = { 0, 0, 4 }, up[3] = { 0, 1, 0 }, b[3] = { -2, 2, -2 }, down[3] = { 0, -1, 0 };
    memset(w, 0, sizeof *w);
    memset(n, 0, sizeof *n);
    box.triangles = 0;
    soup_box(&box, lo, hi, 1, 2);
    grid_fill(&lit, 8, 8, a, u, v, up, 0.1f);
    grid_fill(&eye, W, H, b, u, v, down, 0);
    w->mesh = soup_mesh(&box);
    w->source = grid_source(&lit);
    w->view = grid_view(&eye);
    w->frame.mesh = &w->mesh;
    w->frame.sources = &w->source;
    w->frame.source_count = 1;
    w->frame.points = &w->view;
    w->desc.vpl_count = 16;
    w->desc.surfel_count = 64;
    w->desc.tile_side = 16;
    w->desc.system.log = note;
    w->desc.system.user = n;
    assert_int_equal(ism_create(&w->desc, &w->maps), ISM_OK);
}

#define SAYS(call, result, text)                                                                                       \
    do {                                                                                                               \
        n.lines = 0;                                                                                                   \
        assert_int_equal(call, result);                                                                                \
        assert_string_equal(n.line, text);                                                                             \
        assert_int_equal(n.lines, 1);                                                                                  \
    } while (0)
#define DESC(change, text)                                                                                             \
    do {                                                                                                               \
        ism_desc d = w.desc;                                                                                           \
        ism_maps *none;                                                                                                \
        change;                                                                                                        \
        SAYS(ism_create(&d, &none), ISM_ERR_DESC, text);                                                               \
    } while (0)

static void a_desc_field_is_named_with_its_range(void **state)
{
    world w;
    notes n;
    (void)state;
    open_world(&w, &n);
    DESC(d.vpl_count = 16385, "ism_create: desc.vpl_count is 16385; it must be 0 or 1..16384");
    DESC(d.surfel_count = 7, "ism_create: desc.surfel_count is 7; it must be 0 or 8..65536");
    DESC(d.tile_side = 48, "ism_create: desc.tile_side is 48; it must be 0 or a power of two, 8..256");
    DESC(d.spread = ISM_SPREAD_COUNT, "ism_create: desc.spread is 5; it must be a value of ism_spread");
    DESC(d.area_share = 1.5f, "ism_create: desc.area_share is 1.5; it must be 0..1");
    DESC(d.splat_scale = (float)(HUGE_VAL - HUGE_VAL),
         "ism_create: desc.splat_scale is not a number; it must be 0..16");
    DESC(d.blur_radius = 17, "ism_create: desc.blur_radius is 17; it must be 16 at most");
    DESC(d.window_rim = 1, "ism_create: desc.window_rim is 1; it must be negative, 0 or 2..tile_side / 2");
    DESC(d.system.allocator.free_fn = ledger_free, "ism_create: desc.system.allocator has one function of two");
    ism_free(w.maps);
}

static void pointers_counts_and_strides_are_named(void **state)
{
    float out[3 * W * H];
    world w;
    notes n;
    (void)state;
    open_world(&w, &n);
    SAYS(ism_create(&w.desc, NULL), ISM_ERR_ARGUMENT, "ism_create: out is NULL");
    SAYS(ism_render(w.maps, NULL, NULL, out, NULL), ISM_ERR_ARGUMENT, "ism_render: frame is NULL");
    SAYS(ism_render(w.maps, &w.frame, NULL, NULL, NULL), ISM_ERR_ARGUMENT, "ism_render: out is NULL");
    SAYS(ism_build(w.maps, &w.frame), ISM_ERR_ORDER, "ism_build: maps have no VPLs: call ism_choose before");
    SAYS(ism_shade(w.maps, &w.view, NULL, out, NULL), ISM_ERR_ORDER,
         "ism_shade: maps have no VPLs: call ism_choose before");
    w.view.count--;
    SAYS(ism_choose(w.maps, &w.frame), ISM_ERR_ARGUMENT,
         "ism_choose: points.width is 16; it must be 0 or a divisor of points.count");
    w.view.count = 0;
    SAYS(ism_choose(w.maps, &w.frame), ISM_ERR_ARGUMENT, "ism_choose: points.count is 0; it must be 1..2^28");
    w.view.count = W * H;
    w.view.normal_stride = 10;
    SAYS(ism_choose(w.maps, &w.frame), ISM_ERR_ARGUMENT,
         "ism_choose: points.normal_stride is 10; it must be 0 or a multiple of 4, at least 12");
    w.view.normal_stride = 0;
    w.source.fluxes = NULL;
    SAYS(ism_choose(w.maps, &w.frame), ISM_ERR_ARGUMENT, "ism_choose: sources[0].fluxes is NULL");
    w.source.fluxes = lit.f;
    w.source.area_stride = 6;
    SAYS(ism_choose(w.maps, &w.frame), ISM_ERR_ARGUMENT,
         "ism_choose: sources[0].area_stride is 6; it must be a multiple of 4");
    w.source.area_stride = 0;
    w.source.width = 1u << 26;
    SAYS(ism_choose(w.maps, &w.frame), ISM_ERR_LIMIT,
         "ism_choose: sources[0] brings the texels of all to 536870912; it must be 2^26 at most");
    w.source.width = 8;
    w.mesh.vertex_count--;
    SAYS(ism_render(w.maps, &w.frame, NULL, out, NULL), ISM_ERR_ARGUMENT,
         "ism_render: mesh.vertex_count is 143; it must be a multiple of 3");
    ism_free(w.maps);
}

static void a_bad_index_is_named_with_its_triangle(void **state)
{
    static uint32_t wide[3 * 4096];
    static uint16_t narrow[3 * 4096];
    float out[3 * W * H];
    world w;
    notes n;
    size_t i;
    (void)state;
    open_world(&w, &n);
    for (i = 0; i < w.mesh.vertex_count; i++) {
        wide[i] = (uint32_t)i;
        narrow[i] = (uint16_t)i;
    }
    wide[17] = 144;
    narrow[6] = 60000;
    w.mesh.index_count = w.mesh.vertex_count;
    w.mesh.indices = wide;
    SAYS(ism_render(w.maps, &w.frame, NULL, out, NULL), ISM_ERR_INPUT,
         "ism_render: mesh: index 2 of triangle 5 is 144, but the mesh has 144 vertices");
    w.mesh.indices16 = narrow;
    SAYS(ism_render(w.maps, &w.frame, NULL, out, NULL), ISM_ERR_ARGUMENT,
         "ism_render: mesh.indices and mesh.indices16 are both given");
    w.mesh.indices = NULL;
    SAYS(ism_render(w.maps, &w.frame, NULL, out, NULL), ISM_ERR_INPUT,
         "ism_render: mesh: index 0 of triangle 2 is 60000, but the mesh has 144 vertices");
    ism_free(w.maps);
}

static void a_bad_opacity_is_named_with_its_triangle(void **state)
{
    static const float bad[] = { 1.5f, -0.5f, NAN };
    static const char *const lines[] = { "ism_render: mesh.opacities[3] is 1.5; it must be 0..1",
                                         "ism_render: mesh.opacities[3] is -0.5; it must be 0..1",
                                         "ism_render: mesh.opacities[3] is not a number; it must be 0..1" };
    static float opacities[4096];
    float out[3 * W * H];
    world w;
    notes n;
    int i;
    (void)state;
    open_world(&w, &n);
    w.mesh.opacities = opacities;
    for (i = 0; i < 3; i++) {
        opacities[3] = bad[i];
        SAYS(ism_render(w.maps, &w.frame, NULL, out, NULL), ISM_ERR_INPUT, lines[i]);
    }
    opacities[3] = 1;
    assert_int_equal(ism_render(w.maps, &w.frame, NULL, out, NULL), ISM_OK);
    ism_free(w.maps);
}

/* A VPL's flux is divided by the probability of its choice; also of the brightest texels it stays one that
   ism_set_vpls takes. */
static void chosen_lights_can_be_given_back(void **state)
{
    static ism_vpl own[16];
    const ism_vpl *vpls;
    world w;
    notes n;
    size_t count, i;
    (void)state;
    open_world(&w, &n);
    for (i = 0; i < 3 * 8 * 8; i++) lit.f[i] = i % 7 ? 1e24f : 1e30f;
    assert_int_equal(ism_choose(w.maps, &w.frame), ISM_OK);
    vpls = ism_vpls(w.maps, &count);
    assert_int_equal(count, 16);
    memcpy(own, vpls, sizeof own);
    assert_int_equal(ism_set_vpls(w.maps, own, count), ISM_OK);
    ism_free(w.maps);
}

/* 0.97 to 1.03 is unit; 0 0 0 and what is not finite is left out; the rest is an error that names the element. */
static void vectors_that_are_not_unit_are_named(void **state)
{
    float out[3 * W * H];
    world w;
    notes n;
    ism_info info;
    ism_vpl vpl = util_vpl(0, 0, 0, 0, 1, 0, 1);
    (void)state;
    open_world(&w, &n);
    eye.n[1] = -0.971f;
    eye.n[4] = -1.029f;
    eye.n[7] = 0;
    eye.n[10] = (float)HUGE_VAL;
    lit.n[1] = 1.029f;
    lit.n[4] = 0;
    assert_int_equal(ism_render(w.maps, &w.frame, NULL, out, NULL), ISM_OK);
    assert_true(out[0] > 0 && out[3] > 0 && out[6] <= 0 && out[9] <= 0);
    ism_get_info(w.maps, &info);
    assert_int_equal(info.stats.bad_pvpls, 1);
    eye.n[52] = -1.5f;
    SAYS(ism_render(w.maps, &w.frame, NULL, out, NULL), ISM_ERR_INPUT,
         "ism_render: points.normals[17] has the length 1.5; it must be 1 (0.97..1.03), or 0");
    eye.n[52] = -1;
    w.view.geometric_normals = lit.n;
    lit.n[7] = 0.5f;
    SAYS(ism_shade(w.maps, &w.view, NULL, out, NULL), ISM_ERR_INPUT,
         "ism_shade: points.geometric_normals[2] has the length 0.5; it must be 1 (0.97..1.03), or 0");
    w.view.geometric_normals = NULL;
    SAYS(ism_choose(w.maps, &w.frame), ISM_ERR_INPUT,
         "ism_choose: sources[0].normals[2] has the length 0.5; it must be 1 (0.97..1.03), or 0");
    lit.f[6] = lit.f[7] = lit.f[8] = 0;         /* a black texel is not asked */
    assert_int_equal(ism_choose(w.maps, &w.frame), ISM_OK);
    vpl.axis[1] = 2;
    SAYS(ism_set_vpls(w.maps, &vpl, 1), ISM_ERR_INPUT,
         "ism_set_vpls: vpls[0].axis's length is 2; it must be 1 (0.97..1.03)");
    vpl.axis[1] = 1;
    vpl.normal[1] = 0.5f;
    SAYS(ism_set_vpls(w.maps, &vpl, 1), ISM_ERR_INPUT,
         "ism_set_vpls: vpls[0].normal's length is 0.5; it must be 1 (0.97..1.03)");
    vpl.normal[1] = 1;
    ism_free(w.maps);
}

static void a_bad_number_of_a_light_is_named_with_its_value(void **state)
{
    world w;
    notes n;
    ism_vpl two[2];
    (void)state;
    open_world(&w, &n);
    two[0] = two[1] = util_vpl(0, 0, 0, 0, 1, 0, 1);
    two[1].flux[2] = -1;
    SAYS(ism_set_vpls(w.maps, two, 2), ISM_ERR_INPUT, "ism_set_vpls: vpls[1].flux[2] is -1; it must be 0..1e30");
    two[1].flux[2] = 1;
    two[1].position[1] = (float)HUGE_VAL;
    SAYS(ism_set_vpls(w.maps, two, 2), ISM_ERR_INPUT,
         "ism_set_vpls: vpls[1].position[1] is infinity; it must be finite");
    two[1].position[1] = 0;
    two[1].exponent = NAN;
    SAYS(ism_set_vpls(w.maps, two, 2), ISM_ERR_INPUT,
         "ism_set_vpls: vpls[1].exponent is not a number; it must be 0..1e5");
    two[1].exponent = 1;
    two[1].area = -2;
    SAYS(ism_set_vpls(w.maps, two, 2), ISM_ERR_INPUT,
         "ism_set_vpls: vpls[1].area is -2; it must be finite and not negative");
    two[1].area = 0;
    SAYS(ism_set_vpls(w.maps, NULL, 2), ISM_ERR_ARGUMENT, "ism_set_vpls: vpls is NULL");
    SAYS(ism_set_vpls(w.maps, two, 17), ISM_ERR_LIMIT,
         "ism_set_vpls: count is 17; it must be desc.vpl_count at most");
    ism_free(w.maps);
}

static void shading_fields_are_named(void **state)
{
    float out[3 * W * H], visible[W * H];
    ism_shading s = { 0 };
    world w;
    notes n;
    (void)state;
    open_world(&w, &n);
    assert_int_equal(ism_render(w.maps, &w.frame, NULL, out, NULL), ISM_OK);
    s.interleave = 3;
    SAYS(ism_shade(w.maps, &w.view, &s, out, NULL), ISM_ERR_DESC,
         "ism_shade: shading.interleave is 3; it must be 0, 1, 2, 4 or 8");
    s.interleave = 2;
    w.view.width = 0;
    SAYS(ism_shade(w.maps, &w.view, &s, out, NULL), ISM_ERR_DESC,
         "ism_shade: shading.interleave is 2; it must be 0 or 1 where receivers are a list");
    s.interleave = 0;
    s.bias = 1;
    SAYS(ism_shade(w.maps, &w.view, &s, out, NULL), ISM_ERR_DESC, "ism_shade: shading.bias is 1; it must be below 1");
    SAYS(ism_visible(w.maps, 16, &w.view, 0, visible), ISM_ERR_ARGUMENT,
         "ism_visible: vpl is 16; it must be less than there are VPLs");
    SAYS(ism_bounce(w.maps, &w.mesh, 4, out, out, out), ISM_ERR_MISMATCH,
         "ism_bounce: maps have no hits: they were made without desc.keep_hits");
    SAYS(ism_emitter_points(&w.mesh, lit.p, 0, 0, &w.desc.system, out, out, out), ISM_ERR_ARGUMENT,
         "ism_emitter_points: count is 0; it must be above 0");
    SAYS(ism_emitter_points(&w.mesh, lit.p, 4, 0, &w.desc.system, out, NULL, out), ISM_ERR_ARGUMENT,
         "ism_emitter_points: normals is NULL");
    w.desc.system.allocator.free_fn = ledger_free;
    SAYS(ism_emitter_points(&w.mesh, lit.p, 4, 0, &w.desc.system, out, out, out), ISM_ERR_DESC,
         "ism_emitter_points: system.allocator has one function of two");
    ism_free(w.maps);
}

static void sixteen_bit_indices_give_the_same_light(void **state)
{
    static uint32_t wide[3 * 4096];
    static uint16_t narrow[3 * 4096];
    float light[3][3 * W * H];
    world w;
    notes n;
    int way;
    size_t i;
    (void)state;
    for (way = 0; way < 3; way++) {
        open_world(&w, &n);
        for (i = 0; i < w.mesh.vertex_count; i++) {
            wide[i] = (uint32_t)i;
            narrow[i] = (uint16_t)i;
        }
        if (way) w.mesh.index_count = w.mesh.vertex_count;
        if (way == 1) w.mesh.indices = wide;
        if (way == 2) w.mesh.indices16 = narrow;
        assert_int_equal(ism_render(w.maps, &w.frame, NULL, light[way], NULL), ISM_OK);
        ism_free(w.maps);
    }
    assert_true(light[0][0] > 0);
    assert_memory_equal(light[0], light[1], sizeof light[0]);
    assert_memory_equal(light[0], light[2], sizeof light[0]);
    assert_int_equal(n.lines, 0);
}

static void progress_never_falls_within_a_call(void **state)
{
    float out[3 * W * H];
    ism_shading s = { 0 };
    ism_source two[2];
    world w;
    notes n;
    (void)state;
    open_world(&w, &n);
    ism_free(w.maps);
    w.desc.system.progress = follow;
    assert_int_equal(ism_create(&w.desc, &w.maps), ISM_OK);
    two[0] = two[1] = w.source;
    w.frame.sources = two;
    w.frame.source_count = 2;
    s.interleave = 2;
    assert_int_equal(ism_render(w.maps, &w.frame, &s, out, NULL), ISM_OK);
    assert_int_equal(n.falls, 0);
    assert_true(n.calls > 50 && n.told >= 1);
    n.told = 0;
    assert_int_equal(ism_build(w.maps, &w.frame), ISM_OK);
    assert_true(n.falls == 0 && n.told >= 1);
    ism_free(w.maps);
}

/* Memory that runs out after some pieces: the first piece that ism_create or ism_render is refused is told. */
static int pieces;
static void *some_memory(size_t bytes, void *user)
{
    (void)user;
    return pieces-- > 0 ? malloc(bytes) : NULL;
}
static void all_memory(void *memory, void *user)
{
    (void)user;
    free(memory);
}

static void memory_that_runs_out_is_named(void **state)
{
    static const char *const calls[] = { "ism_create", "ism_render" };
    float out[3 * W * H];
    int seen[2] = { 0, 0 }, k;
    world w;
    notes n;
    (void)state;
    open_world(&w, &n);
    ism_free(w.maps);
    w.desc.system.allocator.alloc_fn = some_memory;
    w.desc.system.allocator.free_fn = all_memory;
    for (k = 0; k < 200; k++) {
        ism_result result;
        char text[100];
        int rendered = 0;
        pieces = k;
        n.lines = 0;
        result = ism_create(&w.desc, &w.maps);
        if (result == ISM_OK) {
            rendered = 1;
            result = ism_render(w.maps, &w.frame, NULL, out, NULL);
            ism_free(w.maps);
        }
        if (result == ISM_OK) break;
        assert_int_equal(result, ISM_ERR_ALLOC);
        snprintf(text, sizeof text, "%s: system.allocator returned no memory", calls[rendered]);
        assert_string_equal(n.line, text);
        assert_int_equal(n.lines, 1);
        seen[rendered]++;
    }
    assert_true(k < 200 && seen[0] >= 3 && seen[1] >= 6);
}

static void lists_of_points_name_what_is_wrong(void **state)
{
    size_t count;
    world w;
    notes n;
    (void)state;
    open_world(&w, &n);
    SAYS(ism_surfels(w.maps, 0, NULL, 0, NULL), ISM_ERR_ARGUMENT, "ism_surfels: count is NULL");
    SAYS(ism_surfels(w.maps, 0, NULL, 4, &count), ISM_ERR_ARGUMENT, "ism_surfels: out is NULL");
    SAYS(ism_surfels(w.maps, 16, NULL, 0, &count), ISM_ERR_ARGUMENT,
         "ism_surfels: vpl is 16; it must be below desc.vpl_count");
    SAYS(ism_phase_surfels(w.maps, 8, NULL, 0, &count), ISM_ERR_ARGUMENT,
         "ism_phase_surfels: phase is 8; it must be below desc.lazy_frames");
    SAYS(ism_surfels(w.maps, 0, NULL, 0, &count), ISM_ERR_ORDER,
         "ism_surfels: maps have no surfels: call ism_build before, with a mesh");
    SAYS(ism_phase_surfels(w.maps, 0, NULL, 0, &count), ISM_ERR_ORDER,
         "ism_phase_surfels: maps have no surfels: call ism_build before, with a mesh");
    ism_free(w.maps);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(memory_that_runs_out_is_named),
        cmocka_unit_test(lists_of_points_name_what_is_wrong),
        cmocka_unit_test(a_desc_field_is_named_with_its_range),
        cmocka_unit_test(pointers_counts_and_strides_are_named),
        cmocka_unit_test(a_bad_index_is_named_with_its_triangle),
        cmocka_unit_test(a_bad_opacity_is_named_with_its_triangle),
        cmocka_unit_test(chosen_lights_can_be_given_back),
        cmocka_unit_test(vectors_that_are_not_unit_are_named),
        cmocka_unit_test(a_bad_number_of_a_light_is_named_with_its_value),
        cmocka_unit_test(shading_fields_are_named), cmocka_unit_test(sixteen_bit_indices_give_the_same_light),
        cmocka_unit_test(progress_never_falls_within_a_call),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
