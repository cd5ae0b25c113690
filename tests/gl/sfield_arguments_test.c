/* sfield_arguments_test - arguments_test for glbk_sfield: every argument, every field of a desc and every number in a
   file's header, wrong in one place at a time. */
#define _POSIX_C_SOURCE 200809L
#include "shadowfield.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl_backend.h"

#include "gl/gl_test.h"
#include "gl/gl_wrong.h"
#include "unit/sfield_util.h"

enum { SIDE = 4, BANDS = 2, MOST_TERMS = 200, MOST_BYTES = 60000 };

static const float unit[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };

/* What hides and what shines, as files; the desc of a scene of both. */
typedef struct stage {
    uint8_t           bytes[2][MOST_BYTES];
    glbk_sfield_file  files[2];
    uint32_t          terms[MOST_TERMS];
    float             factors[MOST_TERMS];
    glbk_sfield_desc  desc;
} stage;

static stage s;

static void set_stage(void)
{
    static float radiance[3 * 12];
    model box = model_box(1, 0.5, 0.7);
    sfield_mesh mesh = mesh_of(&box);
    sfield_algebra *algebra;
    sfield_field *field[2];
    sfield_desc d;
    int i;
    memset(&s, 0, sizeof s);
    memset(&d, 0, sizeof d);
    d.bands = BANDS;
    d.cube_side = 4;
    d.shells = 2;
    d.position_side = 2;
    for (i = 0; i < 36; i++) radiance[i] = 1;
    assert_int_equal(sfield_build(&d, &mesh, &field[0], NULL), SFIELD_OK);
    assert_int_equal(sfield_build_emissive(&d, &mesh, radiance, &field[1], NULL), SFIELD_OK);
    for (i = 0; i < 2; i++) {
        s.files[i].data = s.bytes[i];
        s.files[i].size = sfield_size(field[i]);
        assert_true(s.files[i].size + 4 <= MOST_BYTES);
        assert_int_equal(sfield_write(field[i], s.bytes[i], s.files[i].size), SFIELD_OK);
        sfield_free(field[i]);
    }
    assert_int_equal(sfield_algebra_create(BANDS, NULL, &algebra), SFIELD_OK);
    assert_true(sfield_sh_terms(algebra, NULL, NULL) <= MOST_TERMS);
    s.desc.bands = BANDS;
    s.desc.files = s.files;
    s.desc.file_count = 2;
    s.desc.terms = s.terms;
    s.desc.factors = s.factors;
    s.desc.term_count = (uint32_t)sfield_sh_terms(algebra, s.terms, s.factors);
    if (!s.desc.term_count) s.desc.term_count = 1, s.factors[0] = 1;        /* few bands have none but the plain ones */
    s.desc.capacity = 3;
    sfield_algebra_free(algebra);
    model_free(&box);
}

static void scenes(void **state)
{
    GL_TEST(t, state)
    glbk_context *gl = &t->gl;
    glbk_sfield_desc *d = &s.desc;
    glbk_sfield_field fields[2];
    glbk_sfield_world w;

    set_stage();
    REFUSED(glbk_sfield_create(NULL, d, fields, &w));
    REFUSED(glbk_sfield_create(gl, d, fields, NULL));
    MAKES(w, glbk_sfield_create(gl, NULL, fields, &w));
    MAKES(w, glbk_sfield_create(gl, d, NULL, &w));
    WRONG(w, d->bands, 0, glbk_sfield_create(gl, d, fields, &w));
    WRONG(w, d->bands, 9, glbk_sfield_create(gl, d, fields, &w));
    WRONG(w, d->files, NULL, glbk_sfield_create(gl, d, fields, &w));
    WRONG(w, d->capacity, 0, glbk_sfield_create(gl, d, fields, &w));
    WRONG(w, d->capacity, 65536, glbk_sfield_create(gl, d, fields, &w));
    WRONG(w, d->terms, NULL, glbk_sfield_create(gl, d, fields, &w));
    WRONG(w, d->factors, NULL, glbk_sfield_create(gl, d, fields, &w));
    WRONG(w, d->term_count, 1000001, glbk_sfield_create(gl, d, fields, &w));
    WRONG(w, d->reach, -1, glbk_sfield_create(gl, d, fields, &w));
    WRONG(w, d->reach, 2e6f, glbk_sfield_create(gl, d, fields, &w));
    WRONG(w, s.terms[0], 4, glbk_sfield_create(gl, d, fields, &w));             /* coefficients 0 .. 3 */
    WRONG(w, s.terms[0], 4 << 8, glbk_sfield_create(gl, d, fields, &w));
    WRONG(w, s.terms[0], 4 << 16, glbk_sfield_create(gl, d, fields, &w));
    assert_glbk(t, glbk_sfield_create(gl, d, fields, &w));
    assert_false(fields[0].source);
    assert_true(fields[1].source && fields[1].start > fields[0].start);
    glbk_sfield_destroy(gl, NULL);
    glbk_sfield_bind(gl, NULL);
    glbk_sfield_bind(NULL, &w);
    glbk_sfield_destroy(gl, &w);
}

/* Words of a file's header, at their bytes: magic, version, size, kind, basis, logarithms, bands, shells, side, frames,
   channels, samples, bytes of a sample, radius. */
static void headers_of_files(void **state)
{
    GL_TEST(t, state)
    static const struct { int at; uint32_t value; } words[] = {
        { 0, 1 }, { 4, 2 }, { 8, 1 }, { 16, 2 }, { 20, 2 }, { 24, 1 }, { 28, 3 }, { 36, 1 }, { 36, 65 }, { 40, 1 },
        { 40, 65 }, { 48, 0 }, { 48, 257 }, { 56, 2 }, { 60, 1 }, { 64, 16 }, { 84, 0 }, { 84, 0xbf800000u }
    };
    glbk_context *gl = &t->gl;
    glbk_sfield_field fields[2];
    glbk_sfield_world w;
    size_t i;
    uint32_t kept;

    set_stage();
    for (i = 0; i < sizeof words / sizeof words[0]; i++) {
        uint8_t *at = s.bytes[1] + words[i].at;
        int k;
        memcpy(&kept, at, 4);
        for (k = 0; k < 4; k++) at[k] = (uint8_t)(words[i].value >> 8 * k);
        memset(fields, 0xA5, sizeof fields);
        MAKES(w, glbk_sfield_create(gl, &s.desc, fields, &w));
        gl_is_zero(fields, sizeof fields);
        memcpy(at, &kept, 4);
    }
    WRONG(w, s.files[1].data, NULL, glbk_sfield_create(gl, &s.desc, fields, &w));
    WRONG(w, s.files[1].size, 127, glbk_sfield_create(gl, &s.desc, fields, &w));
    if (sizeof(size_t) > 4)
        WRONG(w, s.files[1].size, (size_t)0x1000000 << 8, glbk_sfield_create(gl, &s.desc, fields, &w));
    s.files[1].size += 4;                       /* the header says so, too; the samples do not */
    s.bytes[1][8] = (uint8_t)s.files[1].size;
    s.bytes[1][9] = (uint8_t)(s.files[1].size >> 8);
    MAKES(w, glbk_sfield_create(gl, &s.desc, fields, &w));
}

static void entities(void **state)
{
    GL_TEST(t, state)
    static const float rotation[64];
    glbk_context *gl = &t->gl;
    glbk_sfield_field fields[2], beyond;
    glbk_sfield_world w, none = { 0 };
    glbk_sfield_entity e = { 0 };
    size_t i;
    int k;

    set_stage();
    assert_glbk(t, glbk_sfield_create(gl, &s.desc, fields, &w));
    memcpy(e.transform, unit, sizeof unit);
    e.occlusion = &fields[0];
    e.source = &fields[1];
    assert_glbk(t, glbk_sfield_place(gl, &w, &e, 1));
    REFUSED(glbk_sfield_place(NULL, &w, &e, 1));
    REFUSED(glbk_sfield_place(gl, NULL, &e, 1));
    REFUSED(glbk_sfield_place(gl, &none, NULL, 0));
    REFUSED(glbk_sfield_place(gl, &w, &e, 4));
    REFUSED(glbk_sfield_place(gl, &w, NULL, 1));
    for (k = 0; k < 3; k++) {
        BAD(e.tint[k], 2e18f, glbk_sfield_place(gl, &w, &e, 1));
        BAD(e.tint[k], -2e18f, glbk_sfield_place(gl, &w, &e, 1));
    }
    BAD(e.time, INFINITY, glbk_sfield_place(gl, &w, &e, 1));
    BAD(e.occlusion, &fields[1], glbk_sfield_place(gl, &w, &e, 1));     /* one for the other */
    BAD(e.source, &fields[0], glbk_sfield_place(gl, &w, &e, 1));
    beyond = fields[0];
    beyond.start = w.texels;
    BAD(e.occlusion, &beyond, glbk_sfield_place(gl, &w, &e, 1));
    beyond.source = 1;
    BAD(e.source, &beyond, glbk_sfield_place(gl, &w, &e, 1));
    e.rotation = rotation;
    for (i = 0; i < wrong_transform_count; i++) {
        memcpy(e.transform, unit, sizeof unit);
        wrong_transform(i, e.transform);
        REFUSED(glbk_sfield_place(gl, &w, &e, 1));
    }
    /* Turned about each axis, by a half or a quarter, with a rotation and without. */
    for (i = 0; i < 6; i++) {
        static const int turn[6][9] = { { 1, 0, 0, 0, -1, 0, 0, 0, -1 }, { -1, 0, 0, 0, 1, 0, 0, 0, -1 },
                                        { -1, 0, 0, 0, -1, 0, 0, 0, 1 }, { 1, 0, 0, 0, 0, 1, 0, -1, 0 },
                                        { 0, 0, -1, 0, 1, 0, 1, 0, 0 }, { 0, 1, 0, -1, 0, 0, 0, 0, 1 } };
        for (k = 0; k < 9; k++) e.transform[4 * (k / 3) + k % 3] = (float)turn[i][k];
        e.rotation = rotation;
        assert_glbk(t, glbk_sfield_place(gl, &w, &e, 1));
        e.rotation = NULL;
        REFUSED(glbk_sfield_place(gl, &w, &e, 1));
    }
    assert_glbk(t, glbk_sfield_sky(gl, &w, NULL));
    REFUSED(glbk_sfield_sky(NULL, &w, NULL));
    REFUSED(glbk_sfield_sky(gl, NULL, NULL));
    REFUSED(glbk_sfield_sky(gl, &none, NULL));
    glbk_sfield_destroy(gl, &w);
}

static void renderers(void **state)
{
    GL_TEST(t, state)
    static glbk_sfield_pixel pixels[SIDE * SIDE];
    static const float steep[BANDS * BANDS] = { 2, -2, 0.5f, -0.5f };
    static float light[4 * SIDE * SIDE];
    const float eye[3] = { 0, 0, 1 };
    glbk_context *gl = &t->gl;
    glbk_sfield_field fields[2];
    glbk_sfield_world w, no_world = { 0 };
    glbk_sfield_renderer_desc d = { SIDE, SIDE, BANDS, 1, NULL, NULL, 0 };
    glbk_sfield_renderer r, none = { 0 }, dull;
    glbk_sfield_draw draw = { 0 };
    char text[8];

    set_stage();
    d.terms = s.terms;
    d.factors = s.factors;
    d.term_count = s.desc.term_count;
    assert_glbk(t, glbk_sfield_create(gl, &s.desc, fields, &w));
    REFUSED(glbk_sfield_renderer_create(NULL, &d, &r));
    REFUSED(glbk_sfield_renderer_create(gl, &d, NULL));
    MAKES(r, glbk_sfield_renderer_create(gl, NULL, &r));
    WRONG(r, d.width, 0, glbk_sfield_renderer_create(gl, &d, &r));
    WRONG(r, d.height, 0, glbk_sfield_renderer_create(gl, &d, &r));
    WRONG(r, d.bands, 0, glbk_sfield_renderer_create(gl, &d, &r));
    WRONG(r, d.bands, 9, glbk_sfield_renderer_create(gl, &d, &r));
    WRONG(r, d.terms, NULL, glbk_sfield_renderer_create(gl, &d, &r));
    WRONG(r, d.factors, NULL, glbk_sfield_renderer_create(gl, &d, &r));
    assert_glbk(t, glbk_sfield_renderer_create(gl, &d, &r));
    d.gloss = 0;
    assert_glbk(t, glbk_sfield_renderer_create(gl, &d, &dull));
    pixels[0].normal[2] = 1;
    pixels[0].self = steep;                     /* 16 bits keep -1.5 .. 1.5: the rest is cut */
    pixels[0].entity = GLBK_SFIELD_NONE;
    assert_glbk(t, glbk_sfield_upload(gl, &r, 0, SIDE, pixels));
    REFUSED(glbk_sfield_upload(NULL, &r, 0, SIDE, pixels));
    REFUSED(glbk_sfield_upload(gl, NULL, 0, SIDE, pixels));
    REFUSED(glbk_sfield_upload(gl, &none, 0, SIDE, pixels));
    REFUSED(glbk_sfield_upload(gl, &r, 0, 0, pixels));
    REFUSED(glbk_sfield_upload(gl, &r, SIDE, 1, pixels));
    REFUSED(glbk_sfield_upload(gl, &r, 1, SIDE, pixels));
    REFUSED(glbk_sfield_upload(gl, &r, 0, SIDE, NULL));
    assert_glbk(t, glbk_sfield_shade(gl, &r, &w, eye, 1));
    REFUSED(glbk_sfield_shade(NULL, &r, &w, eye, 1));
    REFUSED(glbk_sfield_shade(gl, NULL, &w, eye, 1));
    REFUSED(glbk_sfield_shade(gl, &none, &w, eye, 1));
    REFUSED(glbk_sfield_shade(gl, &r, NULL, eye, 1));
    REFUSED(glbk_sfield_shade(gl, &r, &no_world, eye, 1));
    REFUSED(glbk_sfield_shade(gl, &r, &w, NULL, 1));                    /* lobes need an eye */
    BAD(w.bands, 3, glbk_sfield_shade(gl, &r, &w, eye, 1));
    assert_glbk(t, glbk_sfield_read(gl, &r, light, light));
    assert_glbk(t, glbk_sfield_read(gl, &r, NULL, NULL));
    assert_glbk(t, glbk_sfield_read(gl, &r, light, NULL));
    assert_float_equal(light[3], 1.5f / 0.886227f, 1e-4f);              /* in the open, over all of the cosine's */
    REFUSED(glbk_sfield_read(NULL, &r, light, NULL));
    REFUSED(glbk_sfield_read(gl, NULL, light, NULL));
    REFUSED(glbk_sfield_read(gl, &none, light, NULL));
    REFUSED(glbk_sfield_read(gl, &dull, light, light));                 /* no lobes */

    assert_glbk(t, glbk_sfield_gbuffer_begin(gl, &r));
    REFUSED(glbk_sfield_gbuffer_begin(NULL, &r));
    REFUSED(glbk_sfield_gbuffer_begin(gl, NULL));
    REFUSED(glbk_sfield_gbuffer_begin(gl, &none));
    assert_glbk(t, glbk_sfield_gbuffer_object(gl, &r, &draw));
    REFUSED(glbk_sfield_gbuffer_object(NULL, &r, &draw));
    REFUSED(glbk_sfield_gbuffer_object(gl, NULL, &draw));
    REFUSED(glbk_sfield_gbuffer_object(gl, &none, &draw));
    REFUSED(glbk_sfield_gbuffer_object(gl, &r, NULL));
    BAD(draw.exponent, -1, glbk_sfield_gbuffer_object(gl, &r, &draw));
    assert_true(glbk_sfield_write_product(BANDS, s.terms, s.factors, d.term_count, NULL, 0) > sizeof text);
    assert_true(glbk_sfield_write_product(BANDS, s.terms, s.factors, d.term_count, text, sizeof text) > sizeof text);
    assert_int_equal(strlen(text), sizeof text - 1);
    assert_int_equal(glbk_sfield_write_product(0, NULL, NULL, 0, text, sizeof text), 0);
    assert_int_equal(glbk_sfield_write_product(9, NULL, NULL, 0, text, sizeof text), 0);
    assert_int_equal(glbk_sfield_write_product(BANDS, NULL, s.factors, 1, text, sizeof text), 0);
    assert_int_equal(glbk_sfield_write_product(BANDS, s.terms, NULL, 1, text, sizeof text), 0);
    glbk_sfield_renderer_destroy(gl, NULL);
    glbk_sfield_renderer_destroy(gl, &dull);
    glbk_sfield_renderer_destroy(gl, &r);
    glbk_sfield_destroy(gl, &w);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = { gl_unit_test(scenes), gl_unit_test(headers_of_files), gl_unit_test(entities),
                                  gl_unit_test(renderers) };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE45 | GL_ES30_BARE);
}
