/* log_test - the line that a failed call writes, 16-bit indices, unit vectors, matrices of zeros. */

#include "shadowfield.h"

#include "util.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

typedef struct notes { char line[256]; int count; } notes;

static void note(void *user, const char *message)
{
    notes *n = (notes *)user;
    snprintf(n->line, sizeof n->line, "%s", message);
    n->count++;
}

/* The call failed so, and wrote this line, once. */
static void said(notes *n, sfield_result result, sfield_result expected, const char *line)
{
    assert_int_equal(result, expected);
    assert_string_equal(n->line, line);
    assert_int_equal(n->count, 1);
    memset(n, 0, sizeof *n);
}

static sfield_desc tiny(notes *n)
{
    sfield_desc d = small_desc(SFIELD_BASIS_SH);
    d.system.log = note;
    d.system.user = n;
    return d;
}

static void a_desc_says_which_field_has_which_value(void **state)
{
    notes n = { "", 0 };
    model m = model_box(1, 1, 1);
    const sfield_mesh mesh = mesh_of(&m);
    sfield_desc d = tiny(&n);
    sfield_emitter e;
    sfield_field *f;
    (void)state;
    d.bands = 9;
    said(&n, sfield_build(&d, &mesh, &f, NULL), SFIELD_ERR_DESC, "sfield_build: desc.bands is 9; it must be 0..8");
    d.bands = 0;
    d.cube_side = 12;
    said(&n, sfield_build(&d, &mesh, &f, NULL), SFIELD_ERR_DESC,
         "sfield_build: desc.cube_side is 12; it must be 0, 4, 8, 16, 32 or 64");
    d.cube_side = 0;
    d.keep = -0.5f;
    said(&n, sfield_build(&d, &mesh, &f, NULL), SFIELD_ERR_DESC, "sfield_build: desc.keep is -0.5; it must be 0..1");
    d.keep = 0;
    d.frame_count = 2;
    said(&n, sfield_build(&d, &mesh, &f, NULL), SFIELD_ERR_DESC,
         "sfield_build: desc.frame_count is 2; it must be 0..256 for sources, else 0 or 1");
    d.frame_count = 0;
    said(&n, sfield_build(&d, NULL, &f, NULL), SFIELD_ERR_ARGUMENT, "sfield_build: mesh is NULL");
    memset(&e, 0, sizeof e);
    e.radius = 1;
    e.cone_half_angle = -1;
    said(&n, sfield_build_emitter(&d, &e, &f, NULL), SFIELD_ERR_DESC,
         "sfield_build_emitter: emitter.cone_half_angle is -1; it must be 0..pi");
    e.cone_half_angle = 0;
    e.normal[1] = 0.9f;
    said(&n, sfield_build_emitter(&d, &e, &f, NULL), SFIELD_ERR_DESC,
         "sfield_build_emitter: emitter.normal is not unit");
    model_free(&m);
}

/* What else a scene refuses, each with its value. */
static void a_scene_says_what_it_refuses(void **state)
{
    static const float long_way[3] = { 0, 2, 0 }, up[3] = { 0, 1, 0 }, minus[3] = { 1, -1, 1 };
    notes n = { "", 0 };
    sfield_scene_desc desc;
    sfield_scene *scene;
    sfield_entity entity;
    sfield_cache *cache;
    sfield_points points;
    uint32_t number[3];
    size_t count;
    float out[12];
    (void)state;
    memset(&desc, 0, sizeof desc);
    memset(&entity, 0, sizeof entity);
    memset(&points, 0, sizeof points);
    desc.bands = 2;
    desc.system.log = note;
    desc.system.user = &n;
    assert_int_equal(sfield_scene_create(&desc, &scene), SFIELD_OK);
    entity.time = NAN;
    said(&n, sfield_scene_entities(scene, &entity, 1), SFIELD_ERR_INPUT,
         "sfield_scene_entities: entities[0] has a time that is not finite");
    said(&n, sfield_scene_environment(scene, up, 1, 0, NULL), SFIELD_ERR_ARGUMENT,
         "sfield_scene_environment: height is 0; it must be 1..65536");
    said(&n, sfield_scene_environment(scene, up, 65537, 1, NULL), SFIELD_ERR_ARGUMENT,
         "sfield_scene_environment: width is 65537; it must be 1..65536");
    said(&n, sfield_scene_turn(scene, NULL), SFIELD_ERR_ARGUMENT, "sfield_scene_turn: to_world is NULL");
    said(&n, sfield_scene_sun(scene, long_way, up), SFIELD_ERR_INPUT,
         "sfield_scene_sun: the length of direction is 2; it must be 1 (0.97..1.03)");
    said(&n, sfield_scene_sun(scene, up, minus), SFIELD_ERR_INPUT,
         "sfield_scene_sun: irradiance[1] is -1; it must be 0..1e18");
    said(&n, sfield_scene_sky(scene, NULL), SFIELD_ERR_ARGUMENT, "sfield_scene_sky: coefs is NULL");
    said(&n, sfield_cache_create(scene, 1, 1, NULL), SFIELD_ERR_ARGUMENT, "sfield_cache_create: out is NULL");
    said(&n, sfield_cache_create(scene, 0, 1, &cache), SFIELD_ERR_ARGUMENT,
         "sfield_cache_create: point_count is 0; it must be 1..2^31 - 1");
    said(&n, sfield_cache_create(scene, 1, 65537, &cache), SFIELD_ERR_ARGUMENT,
         "sfield_cache_create: light_count is 65537; it must be 1..65536");
    said(&n, sfield_sparse(&points, 1, &desc.system, number, &count, NULL, out), SFIELD_ERR_ARGUMENT,
         "sfield_sparse: sources is NULL");
    sfield_scene_free(scene);
}

static void a_bad_mesh_says_which_index_of_which_triangle(void **state)
{
    static const float p[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };
    static const uint16_t two[6] = { 0, 1, 2, 2, 7, 0 };
    notes n = { "", 0 };
    sfield_desc d = tiny(&n);
    sfield_mesh mesh = { p, 3, 0, NULL, 6, two, NULL, NULL };
    sfield_field *f;
    (void)state;
    said(&n, sfield_build(&d, &mesh, &f, NULL), SFIELD_ERR_INPUT,
         "sfield_build: mesh: index 1 of triangle 1 is 7, but the mesh has 3 vertices");
    mesh.index_count = 5;
    said(&n, sfield_build(&d, &mesh, &f, NULL), SFIELD_ERR_ARGUMENT,
         "sfield_build: mesh.index_count is 5; it must be a multiple of 3, > 0");
    mesh.index_count = 3;
    mesh.vertex_stride = 13;
    said(&n, sfield_build(&d, &mesh, &f, NULL), SFIELD_ERR_ARGUMENT,
         "sfield_build: mesh.vertex_stride is 13; it must be 0, or a multiple of 4 of at least 12");
}

static void indices_of_16_bits_build_the_same_bytes(void **state)
{
    model m = model_box(1, 2, 1);
    sfield_mesh mesh = mesh_of(&m);
    notes n = { "", 0 };
    const sfield_desc d = tiny(&n);
    uint16_t indices[36];
    uint8_t *bytes[2];
    size_t size = 0, i;
    int k;
    (void)state;
    assert_int_equal(mesh.index_count, 36);
    for (i = 0; i < 36; i++) indices[i] = (uint16_t)mesh.indices[i];
    for (k = 0; k < 2; k++) {
        sfield_field *f;
        if (k) mesh.indices = NULL, mesh.indices16 = indices;
        assert_int_equal(sfield_build(&d, &mesh, &f, NULL), SFIELD_OK);
        size = sfield_bytes(f);
        bytes[k] = (uint8_t *)malloc(size);
        assert_int_equal(sfield_write(f, bytes[k], size), SFIELD_OK);
        sfield_free(f);
    }
    assert_memory_equal(bytes[0], bytes[1], size);
    mesh.indices = m.i;
    said(&n, sfield_build(&d, &mesh, &(sfield_field *){ NULL }, NULL), SFIELD_ERR_ARGUMENT,
         "sfield_build: mesh has indices and indices16");
    free(bytes[0]);
    free(bytes[1]);
    model_free(&m);
}

static void files_and_tables_say_why_they_are_refused(void **state)
{
    notes n = { "", 0 };
    sfield_system system;
    sfield_algebra *t;
    sfield_field *f;
    uint8_t bytes[200] = { 0 };
    double out[64];
    float v[64] = { 0 };
    (void)state;
    memset(&system, 0, sizeof system);
    system.log = note;
    system.user = &n;
    said(&n, sfield_algebra_create(9, &system, &t), SFIELD_ERR_ARGUMENT,
         "sfield_algebra_create: bands is 9; it must be 1..8");
    said(&n, sfield_sh_product_n(2, 33, v, &system, out), SFIELD_ERR_ARGUMENT,
         "sfield_sh_product_n: functions is 33; it must be 1..32");
    said(&n, sfield_open(bytes, sizeof bytes, &system, &f), SFIELD_ERR_FORMAT,
         "sfield_open: data is not a file of shadowfield.h");
    memcpy(bytes, "SFLD\7", 5);
    said(&n, sfield_open(bytes, sizeof bytes, &system, &f), SFIELD_ERR_VERSION,
         "sfield_open: the format of data is 7; it must be 1");
}

/* A box of 1 unit shaded at two points, with a log. */
typedef struct stage { model m; sfield_field *f; sfield_scene *s; notes n; } stage;

static void stage_make(stage *st)
{
    static const float sky[3] = { 1, 1, 1 };
    sfield_mesh mesh;
    sfield_desc d;
    sfield_scene_desc sd;
    memset(st, 0, sizeof *st);
    memset(&sd, 0, sizeof sd);
    st->m = model_box(1, 1, 1);
    mesh = mesh_of(&st->m);
    d = tiny(&st->n);
    sd.system = d.system;
    assert_int_equal(sfield_build(&d, &mesh, &st->f, NULL), SFIELD_OK);
    assert_int_equal(sfield_scene_create(&sd, &st->s), SFIELD_OK);
    assert_int_equal(sfield_scene_environment(st->s, sky, 1, 1, NULL), SFIELD_OK);
}

static void stage_free(stage *st)
{
    sfield_scene_free(st->s);
    sfield_free(st->f);
    model_free(&st->m);
}

static void normals_are_unit_or_zero(void **state)
{
    static const float p[6] = { 3, 0, 0, 0, 3, 0 };
    float normals[6] = { 1, 0, 0, 0, 1.02f, 0 }, rgb[6];
    sfield_points set;
    stage st;
    (void)state;
    stage_make(&st);
    memset(&set, 0, sizeof set);
    set.count = 2;
    set.positions = p;
    set.normals = normals;
    set.rgb = rgb;
    assert_int_equal(sfield_shade(st.s, &set, 1, NULL), SFIELD_OK);
    assert_true(rgb[0] > 0.5f && rgb[3] > 0.5f);
    normals[4] = 0;                             /* no receiver */
    assert_int_equal(sfield_shade(st.s, &set, 1, NULL), SFIELD_OK);
    assert_true(rgb[0] > 0.5f && rgb[3] == 0);
    normals[4] = 0.5f;
    rgb[0] = 7;
    said(&st.n, sfield_shade(st.s, &set, 1, NULL), SFIELD_ERR_INPUT,
         "sfield_shade: points->normals[1] has the length 0.5; it must be 1 (0.97..1.03), or 0");
    assert_true(rgb[0] == 7);                   /* untouched */
    set.entity = 1;
    normals[4] = 1;
    said(&st.n, sfield_shade(st.s, &set, 1, NULL), SFIELD_ERR_INPUT,
         "sfield_shade: points->entity is 1; it must be 0, or 1 for the first entity, ...");
    stage_free(&st);
}

static void a_transform_of_zeros_is_the_identity(void **state)
{
    static const float p[3] = { 0, -1.6f, 0 }, up[3] = { 0, 1, 0 };
    float rgb[2][3];
    sfield_points set;
    sfield_entity e;
    stage st;
    int k;
    (void)state;
    stage_make(&st);
    memset(&set, 0, sizeof set);
    memset(&e, 0, sizeof e);
    set.count = 1;
    set.positions = p;
    set.normals = up;
    e.occlusion = st.f;
    for (k = 0; k < 2; k++) {
        if (k) e.transform[0] = e.transform[5] = e.transform[10] = e.transform[15] = 1;
        set.rgb = rgb[k];
        assert_int_equal(sfield_scene_entities(st.s, &e, 1), SFIELD_OK);
        assert_int_equal(sfield_shade(st.s, &set, 1, NULL), SFIELD_OK);
    }
    assert_true(rgb[0][0] < 0.9f);
    assert_memory_equal(rgb[0], rgb[1], sizeof rgb[0]);
    e.transform[0] = 2;
    said(&st.n, sfield_scene_entities(st.s, &e, 1), SFIELD_ERR_INPUT,
         "sfield_scene_entities: entities[0] has a transform that is no rotation with one scale > 0");
    stage_free(&st);
}

/* A field keeps the log of the system that it was made with. */
static void a_field_says_what_it_refuses(void **state)
{
    const float at[3] = { 2, 0, 0 }, up[3] = { 0, 1, 0 };
    notes n = { "", 0 };
    model m = model_box(1, 1, 1);
    const sfield_mesh mesh = mesh_of(&m);
    sfield_desc d = tiny(&n);
    sfield_field *f, *shard, *opened, *self, *logarithms, *lamp;
    sfield_emitter e;
    sfield_points points;
    float out[3 * 64];
    uint8_t *file;
    size_t size;
    (void)state;
    memset(&e, 0, sizeof e);
    memset(&points, 0, sizeof points);
    e.radius = 1;
    points.count = 1;
    points.positions = at;
    points.normals = up;
    assert_int_equal(sfield_build(&d, &mesh, &f, NULL), SFIELD_OK);
    assert_int_equal(sfield_build_emitter(&d, &e, &lamp, NULL), SFIELD_OK);
    assert_int_equal(sfield_build_self(&d, &mesh, &points, 0, &self, NULL), SFIELD_OK);
    d.shard_end = 1;
    assert_int_equal(sfield_build(&d, &mesh, &shard, NULL), SFIELD_OK);
    d.shard_end = 0;
    d.logarithm = 1;
    assert_int_equal(sfield_build(&d, &mesh, &logarithms, NULL), SFIELD_OK);
    said(&n, sfield_query(f, 1, NULL, 0, out), SFIELD_ERR_ARGUMENT, "sfield_query: positions is NULL");
    said(&n, sfield_query(f, 1, at, 0, NULL), SFIELD_ERR_ARGUMENT, "sfield_query: out is NULL");
    said(&n, sfield_query(self, 1, at, 0, out), SFIELD_ERR_MISMATCH, "sfield_query: field is a self-visibility");
    said(&n, sfield_query(shard, 1, at, 0, out), SFIELD_ERR_MISMATCH,
         "sfield_query: field is a shard: sfield_merge first");
    said(&n, sfield_ambient(lamp, 1, at, out), SFIELD_ERR_MISMATCH,
         "sfield_ambient: field is a source, not an occlusion field");
    said(&n, sfield_ambient(logarithms, 1, at, out), SFIELD_ERR_MISMATCH, "sfield_ambient: field holds logarithms");
    said(&n, sfield_self(f, 0, 1, out), SFIELD_ERR_MISMATCH, "sfield_self: field is not a self-visibility");
    said(&n, sfield_self(self, 0, 1, NULL), SFIELD_ERR_ARGUMENT, "sfield_self: out is NULL");
    said(&n, sfield_self(self, 2, 0, out), SFIELD_ERR_ARGUMENT,
         "sfield_self: first is 2; it must be at most the field's points");
    said(&n, sfield_self(self, 1, 1, out), SFIELD_ERR_ARGUMENT,
         "sfield_self: count is 1; it must be at most the field's points from `first` on");
    said(&n, sfield_write(f, NULL, 0), SFIELD_ERR_ARGUMENT, "sfield_write: memory is NULL");
    said(&n, sfield_write(f, out, 12), SFIELD_ERR_MEMORY,
         "sfield_write: memory_bytes is 12; it must be at least what sfield_bytes returns");
    size = sfield_bytes(f);
    file = (uint8_t *)malloc(size);
    assert_non_null(file);
    assert_int_equal(sfield_write(f, file, size), SFIELD_OK);
    assert_int_equal(sfield_open(file, size, &d.system, &opened), SFIELD_OK);
    said(&n, sfield_query(opened, 1, NULL, 0, out), SFIELD_ERR_ARGUMENT, "sfield_query: positions is NULL");
    said(&n, sfield_merge((const sfield_field *const *)&f, 0, &d.system, &opened), SFIELD_ERR_ARGUMENT,
         "sfield_merge: count is 0; it must be > 0");
    assert_int_equal(n.count, 0);
    free(file);
    sfield_free(f);
    sfield_free(shard);
    sfield_free(opened);
    sfield_free(self);
    sfield_free(logarithms);
    sfield_free(lamp);
    model_free(&m);
}

static void an_algebra_says_what_it_refuses(void **state)
{
    static const float shear[16] = { 1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    notes n = { "", 0 };
    float v[16] = { 1 };
    sfield_algebra *t;
    sfield_rotation r;
    sfield_system system;
    (void)state;
    memset(&system, 0, sizeof system);
    system.log = note;
    system.user = &n;
    assert_int_equal(sfield_algebra_create(2, &system, &t), SFIELD_OK);
    said(&n, sfield_sh_product(t, 1, v, NULL, v, 1), SFIELD_ERR_ARGUMENT, "sfield_sh_product: b is NULL");
    said(&n, sfield_sh_product(t, 2, v, v, v, 1), SFIELD_ERR_ARGUMENT,
         "sfield_sh_product: stride is 1; it must be at least count");
    said(&n, sfield_sh_log(t, NULL, v), SFIELD_ERR_ARGUMENT, "sfield_sh_log: visibility is NULL");
    said(&n, sfield_sh_exp(t, 1, v, NULL, 1), SFIELD_ERR_ARGUMENT, "sfield_sh_exp: out is NULL");
    said(&n, sfield_sh_exp(t, 3, v, v, 2), SFIELD_ERR_ARGUMENT,
         "sfield_sh_exp: stride is 2; it must be at least count");
    said(&n, sfield_sh_rotation(t, NULL, &r), SFIELD_ERR_ARGUMENT, "sfield_sh_rotation: matrix is NULL");
    said(&n, sfield_sh_rotation(t, shear, &r), SFIELD_ERR_INPUT,
         "sfield_sh_rotation: matrix is no rotation with one scale > 0");
    assert_int_equal(n.count, 0);
    sfield_algebra_free(t);
}

/* The first entity hides the points below it. A set of zeros names no entity, so that the first one hides the set's
   points, too; counted from 0 it would be the entity that they lie on, which does not hide them. */
static void points_of_no_entity_lie_on_none(void **state)
{
    static const float p[3] = { 0, -1.6f, 0 }, up[3] = { 0, 1, 0 };
    float rgb[2][3];
    sfield_points set;
    sfield_entity e;
    stage st;
    uint32_t k;
    (void)state;
    stage_make(&st);
    memset(&set, 0, sizeof set);
    memset(&e, 0, sizeof e);
    e.occlusion = st.f;
    assert_int_equal(sfield_scene_entities(st.s, &e, 1), SFIELD_OK);
    set.count = 1;
    set.positions = p;
    set.normals = up;
    for (k = 0; k < 2; k++) {
        set.entity = k;
        set.rgb = rgb[k];
        assert_int_equal(sfield_shade(st.s, &set, 1, NULL), SFIELD_OK);
    }
    assert_true(rgb[0][0] < 0.9f);
    assert_true(rgb[1][0] > 0.95f);
    stage_free(&st);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_desc_says_which_field_has_which_value),
        cmocka_unit_test(a_scene_says_what_it_refuses),
        cmocka_unit_test(a_field_says_what_it_refuses),
        cmocka_unit_test(an_algebra_says_what_it_refuses),
        cmocka_unit_test(points_of_no_entity_lie_on_none),
        cmocka_unit_test(a_bad_mesh_says_which_index_of_which_triangle),
        cmocka_unit_test(indices_of_16_bits_build_the_same_bytes),
        cmocka_unit_test(files_and_tables_say_why_they_are_refused),
        cmocka_unit_test(normals_are_unit_or_zero),
        cmocka_unit_test(a_transform_of_zeros_is_the_identity),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
