/* errors_test - every entry point of shadowfield.h with what it must refuse, and degenerate meshes. */
#include "shadowfield.h"
#include "util.h"
#include "use.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>


static void results_have_texts(void **state)
{
    int i;
    (void)state;
    for (i = 0; i < SFIELD_RESULT_COUNT; i++) assert_true(strlen(sfield_result_text((sfield_result)i)) > 1);
    assert_string_equal(sfield_result_text((sfield_result)99), "unknown result");
}

static void bad_arguments_of_the_algebra_are_refused(void **state)
{
    sfield_algebra *t;
    sfield_rotation r;
    sfield_system half = { 0 };
    float v[64] = { 0 }, m[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, out[64];
    double d[64];
    counting c;
    (void)state;
    memset(&c, 0, sizeof c);
    half.allocator = counting_allocator(&c);
    half.allocator.free_fn = NULL;
    assert_int_equal(sfield_algebra_create(0, NULL, &t), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_algebra_create(9, NULL, &t), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_algebra_create(4, NULL, NULL), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_algebra_create(4, &half, &t), SFIELD_ERR_DESC);
    assert_int_equal(sfield_algebra_create(2, NULL, &t), SFIELD_OK);
    assert_int_equal(sfield_sh_product(NULL, 1, v, v, out, 1), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_sh_product(t, 2, v, v, out, 1), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_sh_product(t, 0, v, v, out, 0), SFIELD_OK);
    assert_int_equal(sfield_sh_dot(9, 1, v, v, out, 1), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_sh_dot(2, 1, NULL, v, out, 1), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_sh_rotation(t, NULL, &r), SFIELD_ERR_ARGUMENT);
    m[0] = 2;
    assert_int_equal(sfield_sh_rotation(t, m, &r), SFIELD_ERR_INPUT);        /* uneven scale */
    m[0] = -1;
    assert_int_equal(sfield_sh_rotation(t, m, &r), SFIELD_ERR_INPUT);        /* mirrors */
    m[0] = NAN;
    assert_int_equal(sfield_sh_rotation(t, m, &r), SFIELD_ERR_INPUT);
    assert_int_equal(sfield_sh_rotate(NULL, 1, v, out, 1), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_sh_product_n(2, 0, v, NULL, d), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_sh_product_n(2, 33, v, NULL, d), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_sh_log(t, NULL, out), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_sh_exp(t, 1, NULL, out, 1), SFIELD_ERR_ARGUMENT);
    assert_true(sfield_sh_window_fit(9, v, 0) == 0 && sfield_sh_window_fit(2, NULL, 0) == 0);
    assert_true(sfield_cube_texel(5, 0, out) == 0 && sfield_cube_texel(8, 6 * 64, out) == 0);
    v[0] = v[1] = v[2] = 0;
    assert_int_equal(sfield_cube_find(8, v), 0);
    assert_int_equal(sfield_sh_project(2, 7, v, 1, out), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_haar_forward(3, v, out), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_haar_inverse(2, v, v), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_haar_product(2, v, v, v), SFIELD_ERR_ARGUMENT);
    sfield_algebra_free(t);
    sfield_algebra_free(NULL);
}

static void bad_descs_are_refused(void **state)
{
    model m = model_box(1, 1, 1);
    sfield_mesh mesh = mesh_of(&m);
    sfield_field *f = NULL;
    int i;
    (void)state;
    for (i = 0; i < 22; i++) {
        sfield_desc d = small_desc(SFIELD_BASIS_SH);
        switch (i) {
        case 0: d.basis = SFIELD_BASIS_COUNT; break;
        case 1: d.bands = 9; break;
        case 2: d.cube_side = 12; break;
        case 3: d.cube_side = 128; break;
        case 4: d.shell_count = 1; break;
        case 5: d.shell_count = 65; break;
        case 6: d.position_side = 1; break;
        case 7: d.position_side = 65; break;
        case 8: d.spacing = SFIELD_SPACING_COUNT; break;
        case 9: d.inner = -1; break;
        case 10: d.outer = 0.5f; break;
        case 11: d.outer = NAN; break;
        case 12: d.keep = 2; break;
        case 13: d.window = -1; break;
        case 14: d.frame_count = 2; break;                                 /* occluders do not change */
        case 15: d.frames_per_second = -1; break;
        case 16: d.radius = -1; break;
        case 17: d.center[1] = INFINITY; break;
        case 18: d.system.allocator.alloc_fn = counting_alloc; break;
        case 19: d.inner = 7.999f; break;
        case 20: d.basis = SFIELD_BASIS_HAAR; d.logarithm = 1; break;
        default: d.outer = 2000; break;
        }
        assert_int_equal(sfield_build(&d, &mesh, &f, NULL), SFIELD_ERR_DESC);
        assert_null(f);
    }
    assert_int_equal(sfield_build(NULL, NULL, &f, NULL), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_build(NULL, &mesh, NULL, NULL), SFIELD_ERR_ARGUMENT);
    model_free(&m);
}

/* A sphere that the mesh sticks out of is refused: horizons and cones of the scene would trust it. */
static void spheres_that_a_mesh_sticks_out_of_are_refused(void **state)
{
    static const struct { float radius, center; sfield_result result; } cases[5] = {
        { 0.25f, 0, SFIELD_ERR_DESC },    { 1.73f, 0, SFIELD_ERR_DESC }, { 1.7321f, 0.01f, SFIELD_ERR_DESC },
        { 1.731f, 0, SFIELD_OK },         { 1.7321f, 0, SFIELD_OK }       /* the corners are sqrt(3) away */
    };
    model m = model_box(1, 1, 1);
    sfield_mesh mesh = mesh_of(&m);
    float radiance[36], normal[3] = { 0, 1, 0 }, point[3] = { 0, 1, 0 };
    sfield_field *f;
    int i;
    (void)state;
    for (i = 0; i < 36; i++) radiance[i] = 1;
    for (i = 0; i < 5; i++) {
        sfield_desc d = small_desc(i & 1 ? SFIELD_BASIS_HAAR : SFIELD_BASIS_SH);
        d.radius = cases[i].radius;
        d.center[0] = cases[i].center;
        f = NULL;
        assert_int_equal(sfield_build(&d, &mesh, &f, NULL), cases[i].result);
        sfield_free(f);
        f = NULL;
        assert_int_equal(sfield_build_emissive(&d, &mesh, radiance, &f, NULL), cases[i].result);
        sfield_free(f);
        f = NULL;
        d.shell_count = d.position_side = 0;
        assert_int_equal(sfield_build_self(&d, &mesh, AT(point, normal, 1), 0.1f, &f, NULL), SFIELD_OK);
        sfield_free(f);
    }
    m.p[0] = 50;                                /* a vertex of no triangle does not count */
    for (i = 0; i < 36; i++) m.i[i] = m.i[i] ? m.i[i] : 1;
    {
        sfield_desc d = small_desc(SFIELD_BASIS_SH);
        d.radius = 1.74f;
        assert_int_equal(sfield_build(&d, &mesh, &f, NULL), SFIELD_OK);
        sfield_free(f);
    }
    model_free(&m);
}

static void bad_emitters_are_refused(void **state)
{
    sfield_desc d = small_desc(SFIELD_BASIS_SH);
    sfield_field *f = NULL;
    int i;
    (void)state;
    for (i = 0; i < 15; i++) {
        sfield_emitter e;
        memset(&e, 0, sizeof e);
        e.radius = 1;
        if (i >= 8) e.kind = i < 11 ? SFIELD_EMITTER_LINE : SFIELD_EMITTER_CYLINDER;
        e.u[1] = i >= 8 ? 1.0f : 0.0f;
        switch (i) {
        case 0: e.kind = SFIELD_EMITTER_COUNT; break;
        case 1: e.radius = 0; break;
        case 2: e.radiance[1] = -1; break;
        case 3: e.kind = SFIELD_EMITTER_DISC; break;                  /* no normal */
        case 4: e.kind = SFIELD_EMITTER_RECTANGLE; break;             /* no area */
        case 5: e.kind = SFIELD_EMITTER_CALLBACK; break;              /* none given */
        case 6: e.cone_half_angle = 4; break;
        case 7: e.normal[0] = 0.5f; break;
        case 8: e.u[1] = 0; break;                                    /* no length */
        case 9: e.u[0] = NAN; break;
        case 10: e.u[2] = 1e18f; break;
        case 11: e.u[1] = 0; break;
        case 12: e.radius = 0; break;                                 /* a line is another kind */
        case 13: e.normal[2] = 0.5f; break;
        default: e.radius = INFINITY; break;
        }
        assert_int_equal(sfield_build_emitter(&d, &e, &f, NULL), SFIELD_ERR_DESC);
    }
    for (i = 0; i < 6 * 15; i++) {            /* a rectangle, a number or that of both sides not one or too large */
        const float odd[5] = { NAN, INFINITY, -INFINITY, 1e30f, -1e38f };
        sfield_emitter e;
        memset(&e, 0, sizeof e);
        e.kind = SFIELD_EMITTER_RECTANGLE;
        e.u[0] = e.v[1] = e.u[2] = 1;
        if (i % 3 != 1) e.u[i / 3 % 3] = odd[i / 9 % 5];
        if (i % 3 != 0) e.v[i / 3 % 3] = odd[i / 9 % 5];
        if (i >= 45) e.u[(i / 3 + 1) % 3] = odd[i / 9 % 5];
        assert_int_equal(sfield_build_emitter(&d, &e, &f, NULL), SFIELD_ERR_DESC);
    }
    assert_int_equal(sfield_build_emitter(&d, NULL, &f, NULL), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_build_callback(NULL, NULL, NULL, &f, NULL), SFIELD_ERR_ARGUMENT);
    assert_null(f);
}

/* Meshes that a loader may bring: refused, or built and then usable. */
static void degenerate_meshes_are_refused_or_usable(void **state)
{
    int i, b;
    (void)state;
    for (b = 1; b < 3; b++)
        for (i = 0; i < 16; i++) {
            model m = model_box(1, 1, 1);
            sfield_mesh mesh = mesh_of(&m);
            sfield_desc d = small_desc((sfield_basis)b);
            sfield_field *f = NULL;
            sfield_stats stats;
            sfield_result r, expected = SFIELD_OK;
            uint32_t skipped = 0;
            int k;
            d.shell_count = 2;
            d.position_side = 2;
            d.cube_side = 4;
            switch (i) {
            case 0: mesh.positions = NULL; expected = SFIELD_ERR_ARGUMENT; break;
            case 1: mesh.index_count = 0; expected = SFIELD_ERR_ARGUMENT; break;
            case 2: mesh.index_count = 4; expected = SFIELD_ERR_ARGUMENT; break;
            case 3: mesh.vertex_stride = 8; expected = SFIELD_ERR_ARGUMENT; break;
            case 4: mesh.vertex_stride = 13; expected = SFIELD_ERR_ARGUMENT; break;
            case 5: m.p[0] = NAN; skipped = 6; break;
            case 6: m.p[0] = INFINITY; skipped = 6; break;
            case 7: m.i[3] = 8; expected = SFIELD_ERR_INPUT; break;
            case 8: m.i[3] = m.i[4]; skipped = 1; break;
            case 9: for (k = 0; k < 24; k++) m.p[k] = 0; expected = SFIELD_ERR_INPUT; break;
            case 10: for (k = 0; k < 24; k++) m.p[k] *= 1e-12f; break;
            case 11: for (k = 0; k < 24; k++) m.p[k] *= 1e12f; break;
            case 12: for (k = 0; k < 24; k += 3) m.p[k] = 0; skipped = 8; break;
            case 13: m.p[0] = 1e30f; skipped = 6; break;
            case 14: mesh.vertex_count = 3; expected = SFIELD_ERR_INPUT; break;
            default: mesh.index_count = 3; break;
            }
            r = sfield_build(&d, &mesh, &f, &stats);
            if (r != expected) fail_msg("mesh %d: %s", i, sfield_result_text(r));
            if (r == SFIELD_OK) {
                if (stats.skipped_triangles != skipped) fail_msg("mesh %d: %u skipped", i, stats.skipped_triangles);
                assert_true(use_field(f));
            } else assert_null(f);
            sfield_free(f);
            model_free(&m);
        }
}

static int stop_at(void *user, float fraction)
{
    float *last = (float *)user;
    if (fraction < *last || fraction > 1) return 2;
    *last = fraction;
    return fraction > 0.4f;
}

static void a_cancelled_build_leaves_nothing(void **state)
{
    model m = model_box(1, 1, 1);
    sfield_mesh mesh = mesh_of(&m);
    int b;
    (void)state;
    for (b = 1; b < 3; b++) {
        sfield_desc d = small_desc((sfield_basis)b);
        sfield_field *f = NULL;
        counting c;
        float last = 0;
        memset(&c, 0, sizeof c);
        d.system.allocator = counting_allocator(&c);
        d.system.progress = stop_at;
        d.system.user = &last;
        assert_int_equal(sfield_build(&d, &mesh, &f, NULL), SFIELD_ERR_CANCELLED);
        assert_true(last > 0.4f && last < 0.9f);
        assert_null(f);
        assert_int_equal(c.now, 0);
    }
    model_free(&m);
}

static void bad_queries_and_files_are_refused(void **state)
{
    model m = model_box(1, 1, 1);
    sfield_mesh mesh = mesh_of(&m);
    sfield_desc d = small_desc(SFIELD_BASIS_SH);
    sfield_field *f, *self;
    float p[3] = { 0, 1, 0 }, n[3] = { 0, 1, 0 }, out[16];
    (void)state;
    assert_int_equal(sfield_build(&d, &mesh, &f, NULL), SFIELD_OK);
    assert_int_equal(sfield_build_self(&d, &mesh, AT(p, n, 0), 0, &self, NULL), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_build_self(&d, &mesh, AT(p, n, 1), -1, &self, NULL), SFIELD_ERR_ARGUMENT);
    n[1] = NAN;
    assert_int_equal(sfield_build_self(&d, &mesh, AT(p, n, 1), 0, &self, NULL), SFIELD_ERR_INPUT);
    n[1] = 0.96f;
    assert_int_equal(sfield_build_self(&d, &mesh, AT(p, n, 1), 0, &self, NULL), SFIELD_ERR_INPUT);
    n[1] = 1;
    assert_int_equal(sfield_build_self(&d, &mesh, AT(p, n, 1), 0, &self, NULL), SFIELD_OK);
    assert_int_equal(sfield_query(NULL, 1, p, 0, out), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_query(self, 1, p, 0, out), SFIELD_ERR_MISMATCH);
    assert_int_equal(sfield_self(f, 0, 1, out), SFIELD_ERR_MISMATCH);
    assert_int_equal(sfield_self(self, 1, 1, out), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_self(self, 0, 1, out), SFIELD_OK);
    assert_int_equal(sfield_ambient(self, 1, p, out), SFIELD_ERR_MISMATCH);
    assert_int_equal(sfield_write(f, NULL, 9), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_open(NULL, 9, NULL, &f), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_bytes(NULL), 0);
    sfield_get_info(NULL, NULL);
    sfield_free(NULL);
    sfield_free(f);
    sfield_free(self);
    model_free(&m);
}

static void bad_arguments_of_scenes_are_refused(void **state)
{
    model m = model_box(1, 1, 1);
    sfield_mesh mesh = mesh_of(&m);
    sfield_desc d = small_desc(SFIELD_BASIS_SH);
    sfield_scene_desc sd;
    sfield_scene *s = NULL;
    sfield_field *f, *haar;
    sfield_entity e = upright;
    sfield_points set;
    sfield_cache *cache;
    float p[3] = { 0, 0, 0 }, n[3] = { 0, 1, 0 }, rgb[48], bad[16] = { 1 }, sky[3] = { NAN, -1, 2 };
    int i;
    (void)state;
    assert_int_equal(sfield_build(&d, &mesh, &f, NULL), SFIELD_OK);
    d.basis = SFIELD_BASIS_HAAR;
    assert_int_equal(sfield_build(&d, &mesh, &haar, NULL), SFIELD_OK);
    for (i = 0; i < 7; i++) {
        memset(&sd, 0, sizeof sd);
        switch (i) {
        case 0: sd.basis = SFIELD_BASIS_COUNT; break;
        case 1: sd.product = SFIELD_PRODUCT_COUNT; break;
        case 2: sd.product = SFIELD_PRODUCT_TEXELS; break;
        case 3: sd.bands = 9; break;
        case 4: sd.cube_side = 9; break;
        case 5: sd.reach = -1; break;
        default: sd.system.allocator.free_fn = counting_free; break;
        }
        assert_int_equal(sfield_scene_create(&sd, &s), SFIELD_ERR_DESC);
    }
    assert_null(s);
    assert_int_equal(sfield_scene_create(NULL, NULL), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_scene_create(NULL, &s), SFIELD_OK);
    e.occlusion = f;
    assert_int_equal(sfield_scene_entities(s, NULL, 1), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_scene_entities(s, &e, 65536), SFIELD_ERR_LIMIT);
    e.source = f;
    assert_int_equal(sfield_scene_entities(s, &e, 1), SFIELD_ERR_MISMATCH);
    e.source = NULL;
    e.occlusion = haar;
    assert_int_equal(sfield_scene_entities(s, &e, 1), SFIELD_ERR_MISMATCH);
    e.occlusion = f;
    e.transform[0] = 3;
    assert_int_equal(sfield_scene_entities(s, &e, 1), SFIELD_ERR_INPUT);
    e.transform[0] = 1;
    e.tint[0] = NAN;
    assert_int_equal(sfield_scene_entities(s, &e, 1), SFIELD_ERR_INPUT);
    e.tint[0] = 1;
    assert_int_equal(sfield_scene_entities(s, &e, 1), SFIELD_OK);
    assert_int_equal(sfield_scene_environment(s, sky, 0, 1, NULL), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_scene_environment(s, sky, 1, 1, bad), SFIELD_ERR_INPUT);
    assert_int_equal(sfield_scene_turn(s, bad), SFIELD_ERR_INPUT);
    assert_int_equal(sfield_scene_sun(s, p, n), SFIELD_ERR_INPUT);
    assert_int_equal(sfield_scene_environment(s, sky, 1, 1, NULL), SFIELD_OK);   /* NaN and negative count as 0 */
    assert_int_equal(sfield_cache_create(s, 0, 1, &cache), SFIELD_ERR_ARGUMENT);
    memset(&set, 0, sizeof set);
    set.count = 1;
    set.positions = p;
    set.normals = n;
    set.entity = 0;
    set.rgb = rgb;
    assert_int_equal(sfield_shade(NULL, &set, 1, NULL), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
    assert_true(rgb[0] == 0 && rgb[1] == 0 && isfinite(rgb[2]));
    set.entity = 2;
    assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_ERR_INPUT);
    set.entity = 1;
    set.self = f;
    assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_ERR_MISMATCH);
    set.self = NULL;
    set.position_stride = 6;
    assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_ERR_ARGUMENT);
    set.position_stride = 0;
    set.gloss = rgb;
    set.exponents = n;
    assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_ERR_ARGUMENT);       /* no views */
    set.exponents = NULL;
    assert_int_equal(sfield_cache_create(s, 2, 1, &set.cache), SFIELD_OK);
    assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_ERR_MISMATCH);          /* of another count */
    assert_true(sfield_cache_bytes(set.cache) > 0);
    sfield_cache_free(set.cache);
    set.cache = NULL;
    assert_int_equal(sfield_incident(s, &set, NULL), SFIELD_ERR_ARGUMENT);
    n[1] = 0;                                                         /* no normal: not shaded */
    assert_int_equal(sfield_shade(s, &set, 1, NULL), SFIELD_OK);
    assert_true(rgb[0] == 0);
    sfield_scene_free(s);
    sfield_scene_free(NULL);
    sfield_cache_free(NULL);
    sfield_free(f);
    sfield_free(haar);
    model_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(results_have_texts),
        cmocka_unit_test(bad_arguments_of_the_algebra_are_refused),
        cmocka_unit_test(bad_descs_are_refused),
        cmocka_unit_test(spheres_that_a_mesh_sticks_out_of_are_refused),
        cmocka_unit_test(bad_emitters_are_refused),
        cmocka_unit_test(degenerate_meshes_are_refused_or_usable),
        cmocka_unit_test(a_cancelled_build_leaves_nothing),
        cmocka_unit_test(bad_queries_and_files_are_refused),
        cmocka_unit_test(bad_arguments_of_scenes_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
