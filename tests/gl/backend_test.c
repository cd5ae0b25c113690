/* gl_backend.h on every driver: programs, textures, tables, buffers, targets, passes. */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#define GL_BACKEND_IMPLEMENTATION
#include "gl_backend.h"

#include "gl/gl_test.h"

/* Every program of the library with every set of its defines compiles and links on the driver. */
static void every_program_links(void **state)
{
    GL_TEST(t, state)
    uint32_t count, i, built = 0;
    const glbk_file *files = glbk_files(&count);
    for (i = 0; i < count; i++) {
        const char *s = files[i].sets, *name = files[i].name + 5;
        if (strncmp(files[i].name, "prog/", 5) != 0 || strstr(name, ".vert")) continue;
        if (strstr(name, ".comp") && !t->gl.compute) continue;
        for (; s; s = strchr(s, '|'), s = s ? s + 1 : NULL) {
            char defines[256];
            glbk_program program;
            snprintf(defines, sizeof defines, "%.*s", (int)strcspn(s, "|"), s);
            assert_glbk(t, glbk_program_create(&t->gl, name, defines, &program));
            glbk_program_use(&t->gl, &program);
            t->gl.gl.UseProgram(0);
            glbk_program_destroy(&t->gl, &program);
            built++;
        }
    }
    assert_true(built >= 2);
}

/* Draws source into a new target of format COLOR and reads it back. */
static void draw_and_read(gl_test *t, glbk_program *program, const glbk_texture *source, uint32_t width,
                          uint32_t height, void *out)
{
    glbk_texture_desc d = { 0 };
    glbk_target_desc targets = { 0 };
    glbk_pass pass = { 0 };
    glbk_texture color;
    glbk_target target;

    d.format = GLBK_FORMAT_COLOR;
    d.width = width;
    d.height = height;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &color));
    targets.color[0] = &color;
    assert_glbk(t, glbk_target_create(&t->gl, &targets, &target));
    pass.target = &target;
    assert_glbk(t, glbk_begin(&t->gl, &pass, program));
    glbk_bind_texture(&t->gl, GLBK_SLOT_glbk_source, source);
    glbk_draw_screen(&t->gl);
    assert_glbk(t, glbk_target_read(&t->gl, &target, 0, 0, 0, width, height, out));
    glbk_target_destroy(&t->gl, &target);
    glbk_texture_destroy(&t->gl, &color);
    t->gl.gl.UseProgram(0);
    glbk_program_destroy(&t->gl, program);
}

static void copies_floats(void **state)
{
    GL_TEST(t, state)
    enum { W = 37, H = 5 };
    static float in[4 * W * H], out[4 * W * H];
    glbk_texture_desc d = { 0 };
    glbk_texture source;
    glbk_program copy;
    int i;

    for (i = 0; i < 4 * W * H; i++) in[i] = (float)(i * i) * 1.25e-3f - 17.0f;
    d.format = GLBK_FORMAT_COLOR;
    d.width = W;
    d.height = H;
    d.data = in;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &source));
    assert_glbk(t, glbk_program_create(&t->gl, "copy.frag", NULL, &copy));
    draw_and_read(t, &copy, &source, W, H, out);
    assert_memory_equal(in, out, sizeof in);
    glbk_texture_destroy(&t->gl, &source);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(every_program_links),
        gl_unit_test(copies_floats),
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_ALL);
}
