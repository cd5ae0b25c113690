/* gl_arguments_test - gl_backend/arguments_test for glbk_sfield: every argument and every field of a desc wrong in one
   place at a time, every kind of field that OpenGL does not have, and what the log says of them. */
#define _POSIX_C_SOURCE 200809L
#include "shadowfield.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl_backend/gl_wavelets.h"

#include "gl_test.h"
#include "gl_wrong.h"
#include "util.h"

enum { SIDE = 4, BANDS = 2 };

static const float unit[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };

/* What hides and what shines; the desc of a scene of both. */
typedef struct stage {
    sfield_field           *field[2];
    sfield_algebra         *algebra;
    glbk_sfield_scene_desc  desc;
} stage;

static stage s;

static sfield_desc tiny_desc(void)
{
    sfield_desc d;
    memset(&d, 0, sizeof d);
    d.bands = BANDS;
    d.cube_side = 4;
    d.shell_count = 2;
    d.position_side = 2;
    return d;
}

static void set_stage(void)
{
    static float radiance[3 * 12];
    model box = model_box(1, 0.5, 0.7);
    sfield_mesh mesh = mesh_of(&box);
    sfield_desc d = tiny_desc();
    int i;
    memset(&s, 0, sizeof s);
    for (i = 0; i < 36; i++) radiance[i] = 1;
    assert_int_equal(sfield_build(&d, &mesh, &s.field[0], NULL), SFIELD_OK);
    assert_int_equal(sfield_build_emissive(&d, &mesh, radiance, &s.field[1], NULL), SFIELD_OK);
    assert_int_equal(sfield_algebra_create(BANDS, NULL, &s.algebra), SFIELD_OK);
    s.desc.algebra = s.algebra;
    s.desc.fields = (const sfield_field *const *)s.field;
    s.desc.field_count = 2;
    s.desc.entity_capacity = 3;
    model_free(&box);
}

static void free_stage(void)
{
    sfield_free(s.field[0]);
    sfield_free(s.field[1]);
    sfield_algebra_free(s.algebra);
}

/* The line is all of it: function, field, value, range. */
#define LOGGED(t, text, call, expected)                 \
    do {                                                \
        (t)->log[0] = 0;                                \
        assert_int_equal(call, expected);               \
        assert_string_equal((t)->log, text);            \
    } while (0)

static void scenes_refuse_bad_arguments(void **state)
{
    GL_TEST(t, state)
    glbk_context *gl = &t->gl;
    glbk_sfield_scene_desc *d = &s.desc;
    glbk_sfield_scene w;

    set_stage();
    REFUSED(glbk_sfield_scene_create(NULL, d, &w));
    LOGGED(t, "glbk_sfield_scene_create: out is NULL", glbk_sfield_scene_create(gl, d, NULL), GLBK_ERR_ARGUMENT);
    MAKES(w, glbk_sfield_scene_create(gl, NULL, &w));
    DESC_WRONG(w, d->algebra, NULL, glbk_sfield_scene_create(gl, d, &w));
    assert_string_equal(t->log, "glbk_sfield_scene_create: desc.algebra is NULL");
    DESC_WRONG(w, d->fields, NULL, glbk_sfield_scene_create(gl, d, &w));
    DESC_WRONG(w, s.field[1], NULL, glbk_sfield_scene_create(gl, d, &w));
    assert_string_equal(t->log, "glbk_sfield_scene_create: desc.fields[1] is NULL");
    DESC_WRONG(w, d->entity_capacity, 0, glbk_sfield_scene_create(gl, d, &w));
    DESC_WRONG(w, d->entity_capacity, 65536, glbk_sfield_scene_create(gl, d, &w));
    assert_string_equal(t->log, "glbk_sfield_scene_create: desc.entity_capacity is 65536; it must be 1..65535");
    DESC_WRONG(w, d->reach, -1, glbk_sfield_scene_create(gl, d, &w));
    DESC_WRONG(w, d->reach, 2e6f, glbk_sfield_scene_create(gl, d, &w));
    DESC_WRONG(w, d->reach, NAN, glbk_sfield_scene_create(gl, d, &w));
    assert_glbk(t, glbk_sfield_scene_create(gl, d, &w));
    assert_int_equal(w.field_count, 2);
    assert_true((uintptr_t)w.fields[0].field < (uintptr_t)w.fields[1].field);
    assert_int_equal(w.fields[0].source, w.fields[0].field == s.field[1]);
    assert_int_equal(w.fields[1].source, w.fields[1].field == s.field[1]);
    assert_true(w.fields[0].start != w.fields[1].start);
    glbk_sfield_scene_free(gl, NULL);
    glbk_sfield_bind(gl, NULL, NULL);
    glbk_sfield_bind(NULL, &w, NULL);
    glbk_sfield_scene_free(gl, &w);
    glbk_sfield_scene_free(gl, &w);
    free_stage();
}

/* Each kind of field that OpenGL does not have, in the second place. */
static void fields_of_other_kinds_are_refused(void **state)
{
    GL_TEST(t, state)
    static const char *const why[] = {
        "is one of wavelets, which glbk_sfield_haar_upload takes", "has other bands than desc.algebra",
        "is one of logarithms, as others are not", "is a shard: sfield_merge first",
        "is neither an occlusion nor a source field"
    };
    const float at[3] = { 1, 0, 0 };
    model box = model_box(1, 0.5, 0.7);
    sfield_mesh mesh = mesh_of(&box);
    glbk_sfield_scene w;
    sfield_field *fields[2];
    char line[200];
    int i;

    set_stage();
    fields[0] = s.field[0];
    s.desc.fields = (const sfield_field *const *)fields;
    for (i = 0; i < 5; i++) {
        sfield_desc d = tiny_desc();
        if (i == 0) d.basis = SFIELD_BASIS_HAAR, d.bands = 0;
        if (i == 1) d.bands = 3;
        d.logarithm = i == 2;
        if (i == 3) d.shard_end = 1;
        assert_int_equal(i == 4 ? sfield_build_self(&d, &mesh, AT(at, at, 1), 0.01f, &fields[1], NULL)
                                : sfield_build(&d, &mesh, &fields[1], NULL),
                         SFIELD_OK);
        snprintf(line, sizeof line, "glbk_sfield_scene_create: desc.fields[1] %s", why[i]);
        memset(&w, 0xA5, sizeof w);
        LOGGED(t, line, glbk_sfield_scene_create(&t->gl, &s.desc, &w), GLBK_ERR_MISMATCH);
        gl_is_zero(&w, sizeof w);
        sfield_free(fields[1]);
    }
    free_stage();
    model_free(&box);
}

#define INPUT_BAD(field, value, call) BAD_IS(GLBK_ERR_INPUT, field, value, call)
#define PLACES(gl, w, e) glbk_sfield_scene_entities(gl, w, e, 1)

static void entities_refuse_bad_arguments(void **state)
{
    GL_TEST(t, state)
    glbk_context *gl = &t->gl;
    glbk_sfield_scene w, none = { 0 };
    sfield_entity e[4];
    sfield_desc d = tiny_desc();
    sfield_field *stranger;
    model box = model_box(1, 1, 1);
    sfield_mesh mesh = mesh_of(&box);
    size_t i;
    int k;

    set_stage();
    memset(e, 0, sizeof e);
    assert_int_equal(sfield_build(&d, &mesh, &stranger, NULL), SFIELD_OK);
    assert_glbk(t, glbk_sfield_scene_create(gl, &s.desc, &w));
    e->occlusion = s.field[0];
    e->source = s.field[1];
    assert_glbk(t, PLACES(gl, &w, e));          /* a transform of zeros is the identity */
    memcpy(e->transform, unit, sizeof unit);
    assert_glbk(t, glbk_sfield_scene_entities(gl, &w, e, 3));
    REFUSED(PLACES(NULL, &w, e));
    LOGGED(t, "glbk_sfield_scene_entities: scene is NULL", PLACES(gl, NULL, e), GLBK_ERR_ARGUMENT);
    REFUSED(glbk_sfield_scene_entities(gl, &none, NULL, 0));
    REFUSED(PLACES(gl, &w, NULL));
    LOGGED(t, "glbk_sfield_scene_entities: count is 4; it must be 0..3", glbk_sfield_scene_entities(gl, &w, e, 4),
           GLBK_ERR_LIMIT);
    for (k = 0; k < 3; k++) {
        INPUT_BAD(e->tint[k], 2e18f, PLACES(gl, &w, e));
        INPUT_BAD(e->tint[k], -2e18f, PLACES(gl, &w, e));
        assert_string_equal(t->log, "glbk_sfield_scene_entities: entities[0].tint is -2e18; it must be -1e18..1e18");
    }
    INPUT_BAD(e->time, INFINITY, PLACES(gl, &w, e));
    assert_string_equal(t->log, "glbk_sfield_scene_entities: entities[0].time is infinity; it must be finite");
    BAD_IS(GLBK_ERR_MISMATCH, e->occlusion, s.field[1], PLACES(gl, &w, e));     /* one for the other */
    BAD_IS(GLBK_ERR_MISMATCH, e->source, s.field[0], PLACES(gl, &w, e));
    assert_string_equal(t->log, "glbk_sfield_scene_entities: entities[0].source is none of the scene's source fields");
    BAD_IS(GLBK_ERR_MISMATCH, e->source, stranger, PLACES(gl, &w, e));
    BAD_IS(GLBK_ERR_MISMATCH, e->occlusion, stranger, PLACES(gl, &w, e));
    assert_string_equal(t->log,
                        "glbk_sfield_scene_entities: entities[0].occlusion is none of the scene's occlusion fields");
    for (i = 0; i < wrong_transform_count; i++) {
        memcpy(e->transform, unit, sizeof unit);
        wrong_transform(i, e->transform);
        LOGGED(t, "glbk_sfield_scene_entities: entities[0].transform is no rotation with one scale above 0 and a "
                  "translation", PLACES(gl, &w, e), GLBK_ERR_INPUT);
    }
    assert_int_equal(w.entity_count, 3);        /* nothing has changed */
    assert_int_equal(w.light_count, 1);
    /* Turned about each axis, by a half or a quarter. */
    for (i = 0; i < 6; i++) {
        static const int turn[6][9] = { { 1, 0, 0, 0, -1, 0, 0, 0, -1 }, { -1, 0, 0, 0, 1, 0, 0, 0, -1 },
                                        { -1, 0, 0, 0, -1, 0, 0, 0, 1 }, { 1, 0, 0, 0, 0, 1, 0, -1, 0 },
                                        { 0, 0, -1, 0, 1, 0, 1, 0, 0 }, { 0, 1, 0, -1, 0, 0, 0, 0, 1 } };
        for (k = 0; k < 9; k++) e->transform[4 * (k / 3) + k % 3] = (float)turn[i][k];
        assert_glbk(t, PLACES(gl, &w, e));
    }
    assert_glbk(t, glbk_sfield_scene_sky(gl, &w, NULL));
    REFUSED(glbk_sfield_scene_sky(NULL, &w, NULL));
    REFUSED(glbk_sfield_scene_sky(gl, NULL, NULL));
    REFUSED(glbk_sfield_scene_sky(gl, &none, NULL));
    assert_string_equal(t->log, "glbk_sfield_scene_sky: scene was not created");
    glbk_sfield_scene_free(gl, &w);
    sfield_free(stranger);
    free_stage();
    model_free(&box);
}

/* A G-buffer in which every pixel is seen from above, not drawn. */
static glbk_gbuffer gbuffer_of(gl_test *t, uint32_t width, uint32_t height)
{
    glbk_pixel *pixels = (glbk_pixel *)calloc((size_t)width * height, sizeof *pixels);
    glbk_gbuffer_desc d;
    glbk_gbuffer g;
    uint32_t i;
    assert_non_null(pixels);
    memset(&d, 0, sizeof d);
    d.width = width;
    d.height = height;
    for (i = 0; i < width * height; i++) pixels[i].normal[2] = 1;
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &d, &g));
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, &g, 0, height, pixels));
    free(pixels);
    return g;
}

static void renderers_refuse_bad_arguments(void **state)
{
    GL_TEST(t, state)
    static float light[4 * SIDE * SIDE];
    const float eye[3] = { 0, 0, 1 };
    glbk_context *gl = &t->gl;
    glbk_sfield_scene w, no_scene = { 0 };
    glbk_sfield_renderer_desc d = { SIDE, SIDE, NULL, 1, 0, 0, 0, 0, 0, 0 };
    glbk_sfield_renderer r, none = { 0 }, dull;
    glbk_gbuffer g = gbuffer_of(t, SIDE, SIDE), wide = gbuffer_of(t, SIDE + 1, SIDE), no_buffer = { 0 };
    sfield_algebra *five;
    char text[8];

    set_stage();
    d.algebra = s.algebra;
    assert_glbk(t, glbk_sfield_scene_create(gl, &s.desc, &w));
    REFUSED(glbk_sfield_renderer_create(NULL, &d, &r));
    LOGGED(t, "glbk_sfield_renderer_create: out is NULL", glbk_sfield_renderer_create(gl, &d, NULL),
           GLBK_ERR_ARGUMENT);
    MAKES(r, glbk_sfield_renderer_create(gl, NULL, &r));
    DESC_WRONG(r, d.width, 0, glbk_sfield_renderer_create(gl, &d, &r));
    DESC_WRONG(r, d.height, 0, glbk_sfield_renderer_create(gl, &d, &r));
    {
        const uint32_t side = gl->max_side;
        gl->max_side = 8;
        WRONG_IS(GLBK_ERR_LIMIT, r, d.width, 9, glbk_sfield_renderer_create(gl, &d, &r));
        assert_string_equal(t->log, "glbk_sfield_renderer_create: desc.width is 9; it must be 1..8");
        WRONG_IS(GLBK_ERR_LIMIT, r, d.height, 9, glbk_sfield_renderer_create(gl, &d, &r));
        assert_string_equal(t->log, "glbk_sfield_renderer_create: desc.height is 9; it must be 1..8");
        gl->max_side = side;
    }
    DESC_WRONG(r, d.self_attribute, 13, glbk_sfield_renderer_create(gl, &d, &r));
    assert_string_equal(t->log, "glbk_sfield_renderer_create: desc.self_attribute is 13; it must be 0..12");
    DESC_WRONG(r, d.algebra, NULL, glbk_sfield_renderer_create(gl, &d, &r));
    assert_glbk(t, glbk_sfield_renderer_create(gl, &d, &r));
    d.gloss = 0;
    assert_glbk(t, glbk_sfield_renderer_create(gl, &d, &dull));
    REFUSED(glbk_sfield_renderer_resize(NULL, &r, SIDE, SIDE));
    REFUSED(glbk_sfield_renderer_resize(gl, NULL, SIDE, SIDE));
    REFUSED(glbk_sfield_renderer_resize(gl, &none, SIDE, SIDE));
    ERROR_IS(GLBK_ERR_DESC, glbk_sfield_renderer_resize(gl, &r, 0, SIDE));
    ERROR_IS(GLBK_ERR_LIMIT, glbk_sfield_renderer_resize(gl, &r, SIDE, gl->max_side + 1));
    assert_glbk(t, glbk_sfield_renderer_resize(gl, &r, SIDE + 1, SIDE));
    assert_glbk(t, glbk_sfield_renderer_resize(gl, &r, SIDE, SIDE));
    assert_glbk(t, glbk_sfield_shade(gl, &r, &g, &w, eye, 1));
    REFUSED(glbk_sfield_shade(NULL, &r, &g, &w, eye, 1));
    LOGGED(t, "glbk_sfield_shade: renderer is NULL", glbk_sfield_shade(gl, NULL, &g, &w, eye, 1), GLBK_ERR_ARGUMENT);
    LOGGED(t, "glbk_sfield_shade: renderer was not created", glbk_sfield_shade(gl, &none, &g, &w, eye, 1),
           GLBK_ERR_ARGUMENT);
    LOGGED(t, "glbk_sfield_shade: gbuffer is NULL", glbk_sfield_shade(gl, &r, NULL, &w, eye, 1), GLBK_ERR_ARGUMENT);
    LOGGED(t, "glbk_sfield_shade: gbuffer was not created", glbk_sfield_shade(gl, &r, &no_buffer, &w, eye, 1),
           GLBK_ERR_ARGUMENT);
    LOGGED(t, "glbk_sfield_shade: scene is NULL", glbk_sfield_shade(gl, &r, &g, NULL, eye, 1), GLBK_ERR_ARGUMENT);
    LOGGED(t, "glbk_sfield_shade: scene was not created", glbk_sfield_shade(gl, &r, &g, &no_scene, eye, 1),
           GLBK_ERR_ARGUMENT);
    REFUSED(glbk_sfield_shade(gl, &r, &g, &w, NULL, 1));
    assert_string_equal(t->log, "glbk_sfield_shade: eye is NULL: lobes need it, and the G-buffer has none");
    LOGGED(t, "glbk_sfield_shade: gbuffer->width is 5; it must be that of the renderer",
           glbk_sfield_shade(gl, &r, &wide, &w, eye, 1), GLBK_ERR_MISMATCH);
    BAD_IS(GLBK_ERR_MISMATCH, w.bands, 3, glbk_sfield_shade(gl, &r, &g, &w, eye, 1));
    assert_string_equal(t->log, "glbk_sfield_shade: scene->bands is 3; it must be that of the renderer");
    assert_glbk(t, glbk_sfield_read(gl, &r, light, light));
    assert_glbk(t, glbk_sfield_read(gl, &r, NULL, NULL));
    assert_glbk(t, glbk_sfield_read(gl, &r, light, NULL));
    assert_float_equal(light[3], 1, 1e-4f);                             /* in the open */
    REFUSED(glbk_sfield_read(NULL, &r, light, NULL));
    REFUSED(glbk_sfield_read(gl, NULL, light, NULL));
    REFUSED(glbk_sfield_read(gl, &none, light, NULL));
    assert_int_equal(glbk_sfield_read(gl, &dull, light, light), GLBK_ERR_MISMATCH);     /* no lobes */
    assert_true(glbk_sfield_write_product(s.algebra, NULL, 0) > sizeof text);
    assert_true(glbk_sfield_write_product(s.algebra, text, sizeof text) > sizeof text);
    assert_int_equal(strlen(text), sizeof text - 1);
    assert_int_equal(glbk_sfield_write_product(NULL, text, sizeof text), 0);
    assert_int_equal(sfield_algebra_create(5, NULL, &five), SFIELD_OK);
    assert_int_equal(glbk_sfield_write_product(five, text, sizeof text), 0);
    sfield_algebra_free(five);
    glbk_sfield_renderer_free(gl, NULL);
    glbk_sfield_renderer_free(gl, &dull);
    glbk_sfield_renderer_free(gl, &r);
    glbk_gbuffer_free(gl, &wide);
    glbk_gbuffer_free(gl, &g);
    glbk_sfield_scene_free(gl, &w);
    free_stage();
}

static void self_visibility_refuses_bad_arguments(void **state)
{
    GL_TEST(t, state)
    static const float steep[BANDS * BANDS] = { 2, -2, 0.5f, -0.5f }, hidden[BANDS * BANDS] = { 0, 0, 0, 0 };
    static float light[4 * SIDE * SIDE];
    const float *self[SIDE * SIDE] = { steep, hidden };
    const float zeros[16] = { 0 }, eye[3] = { 0, 0, 1 };
    glbk_context *gl = &t->gl;
    glbk_sfield_scene w;
    glbk_sfield_renderer_desc d = { SIDE, SIDE, NULL, 0, 1, 0, 0, 0, 0, 0 };
    glbk_sfield_renderer r, none = { 0 }, without, many;
    glbk_gbuffer g = gbuffer_of(t, SIDE, SIDE), wide = gbuffer_of(t, SIDE + 1, SIDE), no_buffer = { 0 };
    sfield_algebra *five;

    set_stage();
    d.algebra = s.algebra;
    assert_int_equal(sfield_algebra_create(5, NULL, &five), SFIELD_OK);
    assert_glbk(t, glbk_sfield_scene_create(gl, &s.desc, &w));
    assert_glbk(t, glbk_sfield_renderer_create(gl, &d, &r));
    d.self = 0;
    assert_glbk(t, glbk_sfield_renderer_create(gl, &d, &without));
    d.self = 1;
    d.algebra = five;
    assert_glbk(t, glbk_sfield_renderer_create(gl, &d, &many));

    assert_glbk(t, glbk_sfield_self_upload(gl, &r, 0, SIDE, self));
    REFUSED(glbk_sfield_self_upload(NULL, &r, 0, SIDE, self));
    REFUSED(glbk_sfield_self_upload(gl, NULL, 0, SIDE, self));
    REFUSED(glbk_sfield_self_upload(gl, &none, 0, SIDE, self));
    REFUSED(glbk_sfield_self_upload(gl, &r, 0, 0, self));
    REFUSED(glbk_sfield_self_upload(gl, &r, SIDE, 1, self));
    REFUSED(glbk_sfield_self_upload(gl, &r, 1, SIDE, self));
    assert_string_equal(t->log, "glbk_sfield_self_upload: row_count is 4; it must be 1..3");
    REFUSED(glbk_sfield_self_upload(gl, &r, 0, SIDE, NULL));
    LOGGED(t, "glbk_sfield_self_upload: renderer was created without desc.self",
           glbk_sfield_self_upload(gl, &without, 0, SIDE, self), GLBK_ERR_MISMATCH);
    assert_glbk(t, glbk_sfield_shade(gl, &r, &g, &w, NULL, 1));
    assert_glbk(t, glbk_sfield_read(gl, &r, light, NULL));
    assert_float_equal(light[3], 1.5f / 0.886227f, 1e-4f);      /* 16 bits keep -1.5 .. 1.5: the rest is cut */
    assert_float_equal(light[7], 0, 1e-4f);                     /* hidden altogether is not: nothing given */
    assert_float_equal(light[11], 1, 1e-4f);

    REFUSED(glbk_sfield_self_begin(NULL, &r, &g));
    REFUSED(glbk_sfield_self_begin(gl, NULL, &g));
    REFUSED(glbk_sfield_self_begin(gl, &none, &g));
    REFUSED(glbk_sfield_self_begin(gl, &r, NULL));
    REFUSED(glbk_sfield_self_begin(gl, &r, &no_buffer));
    assert_int_equal(glbk_sfield_self_begin(gl, &without, &g), GLBK_ERR_MISMATCH);
    assert_int_equal(glbk_sfield_self_begin(gl, &r, &wide), GLBK_ERR_MISMATCH);
    LOGGED(t, "glbk_sfield_self_begin: gbuffer was not drawn: its depth or matrix is not known",
           glbk_sfield_self_begin(gl, &r, &g), GLBK_ERR_ORDER);
    LOGGED(t, "glbk_sfield_self_object: renderer was not begun: glbk_sfield_self_begin",
           glbk_sfield_self_object(gl, &r, zeros), GLBK_ERR_ORDER);
    assert_glbk(t, glbk_gbuffer_begin(gl, &g, unit, eye));
    LOGGED(t, "glbk_sfield_self_begin: the number of bands is 5; it must be 1..4 to be drawn",
           glbk_sfield_self_begin(gl, &many, &g), GLBK_ERR_LIMIT);
    g.attributes.position = 7;                  /* where the last coefficients are */
    LOGGED(t, "glbk_sfield_self_begin: desc.self_attribute is 4; it must be such that the position is in none of four "
              "attributes from it on",
           glbk_sfield_self_begin(gl, &r, &g), GLBK_ERR_MISMATCH);
    g.attributes.position = 12;
    assert_glbk(t, glbk_sfield_self_begin(gl, &r, &g));
    g.attributes.position = 0;
    assert_glbk(t, glbk_sfield_self_begin(gl, &r, &g));
    assert_glbk(t, glbk_sfield_self_object(gl, &r, zeros));
    REFUSED(glbk_sfield_self_object(NULL, &r, zeros));
    REFUSED(glbk_sfield_self_object(gl, NULL, zeros));
    REFUSED(glbk_sfield_self_object(gl, &none, zeros));
    REFUSED(glbk_sfield_self_object(gl, &r, NULL));
    glbk_sfield_renderer_free(gl, &many);
    glbk_sfield_renderer_free(gl, &without);
    glbk_sfield_renderer_free(gl, &r);
    glbk_gbuffer_free(gl, &wide);
    glbk_gbuffer_free(gl, &g);
    glbk_sfield_scene_free(gl, &w);
    sfield_algebra_free(five);
    free_stage();
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(scenes_refuse_bad_arguments), gl_unit_test(fields_of_other_kinds_are_refused),
        gl_unit_test(entities_refuse_bad_arguments), gl_unit_test(renderers_refuse_bad_arguments),
        gl_unit_test(self_visibility_refuses_bad_arguments)
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE45 | GL_ES30_BARE);
}
