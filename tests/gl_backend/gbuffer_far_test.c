/* gbuffer_far_test - a square so far from the origin that most neighbouring pixels have one and the same place: the
   surface's own normal, which is that of differences, is the vertices' there, on the side that is seen; without these
   it is none, and never not a number. */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend/gl_csm.h"
#include "gl_backend/gl_gbuffer.h"

#include "gl_test.h"

enum { SIDE = 64, PIXELS = SIDE * SIDE };

#define FAR_AWAY 134217728.0f       /* 2^27: floats are 16 apart there, pixels 1 */

static const float eye[3] = { FAR_AWAY + 32, 32, 100 };

typedef struct square { uint32_t array, buffer; } square;

/* In the plane z = 0, 64 a side; normals away from the eye, or none. */
static square make_square(gl_test *t, int normals)
{
    const float back = normals ? -1.0f : 0.0f;
    const float v[4][6] = { { 0, 0, 0, 0, 0, back }, { 64, 0, 0, 0, 0, back },
                            { 0, 64, 0, 0, 0, back }, { 64, 64, 0, 0, 0, back } };
    const glbk_functions *gl = &t->gl.gl;
    square s;
    gl->GenVertexArrays(1, &s.array);
    gl->GenBuffers(1, &s.buffer);
    gl->BindVertexArray(s.array);
    gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, s.buffer);
    gl->BufferData(GLBK_GL_ARRAY_BUFFER, sizeof v, v, GLBK_GL_STATIC_DRAW);
    gl->EnableVertexAttribArray(0);
    gl->VertexAttribPointer(0, 3, GLBK_GL_FLOAT, 0, sizeof v[0], NULL);
    gl->EnableVertexAttribArray(1);
    gl->VertexAttribPointer(1, 3, GLBK_GL_FLOAT, 0, sizeof v[0], (const void *)(3 * sizeof(float)));
    gl->BindVertexArray(0);
    gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, 0);
    return s;
}

static void free_square(gl_test *t, square *s)
{
    t->gl.gl.DeleteVertexArrays(1, &s->array);
    t->gl.gl.DeleteBuffers(1, &s->buffer);
}

static void draw_square(glbk_context *ctx, const square *s)
{
    ctx->gl.BindVertexArray(s->array);
    ctx->gl.DrawArrays(GLBK_GL_TRIANGLE_STRIP, 0, 4);
}

static void set_matrices(float *world, float *clip)
{
    memset(world, 0, 16 * sizeof *world);
    memset(clip, 0, 16 * sizeof *clip);
    world[0] = world[5] = world[10] = world[15] = clip[15] = 1;
    world[12] = FAR_AWAY;
    clip[0] = clip[5] = 1 / 32.0f;
    clip[12] = -(FAR_AWAY / 32 + 1);                    /* exact, as all that is added to it */
    clip[13] = -1;
}

/* Words x to z of an image of a G-buffer: +z, or where there are no normals and no differences zero. Returns how many
   are zero. */
static int check_normals(gl_test *t, const glbk_target *target, uint32_t image, int normals)
{
    static float seen[PIXELS][4];
    int i, zero = 0;
    assert_glbk(t, glbk_target_read(&t->gl, target, image, 0, 0, SIDE, SIDE, seen[0]));
    for (i = 0; i < PIXELS; i++) {
        if (!normals && seen[i][2] == 0) zero++;
        else assert_true(seen[i][2] == 1);
        assert_true(seen[i][0] == 0 && seen[i][1] == 0);
    }
    return zero;
}

static void far_normals_are_the_vertices_or_none(void **state)
{
    GL_TEST(t, state)
    glbk_gbuffer_desc size = { SIDE, SIDE, { 0, 0, 0, 0, NULL, NULL }, NULL };
    glbk_gbuffer g;
    glbk_surface d;
    float clip[16];
    static uint32_t words[PIXELS][4];
    int normals, i, zero;
    memset(&d, 0, sizeof d);
    set_matrices(d.transform, clip);
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &size, &g));
    for (normals = 0; normals < 2; normals++) {
        square s = make_square(t, normals);
        assert_glbk(t, glbk_gbuffer_begin(&t->gl, &g, clip, eye));
        assert_glbk(t, glbk_gbuffer_object(&t->gl, &g, &d));
        draw_square(&t->gl, &s);
        zero = check_normals(t, &g.target, 1, normals);
        if (!normals) assert_true(zero > PIXELS / 2);
        assert_glbk(t, glbk_target_read(&t->gl, &g.target, 2, 0, 0, SIDE, SIDE, words[0]));
        for (i = 0; i < PIXELS; i++) {                  /* the surface's own, packed; 0xffffffff: none */
            zero -= words[i][3] == 0xffffffffu;
            assert_true(words[i][3] == 0x7fff7fffu || words[i][3] == 0xffffffffu);
        }
        assert_int_equal(zero, 0);
        free_square(t, &s);
    }
    glbk_gbuffer_free(&t->gl, &g);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = { gl_unit_test(far_normals_are_the_vertices_or_none) };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_USUAL);
}
