/* gl_gbuffer_test - what the renderer's users do besides uploads: shade a drawn G-buffer, use csm_visible in a shader
   of their own, bring a G-buffer of their own, resolve to a target. */
#define _POSIX_C_SOURCE 200809L
#include "csm.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend/gl_csm.h"

#include "gl_test.h"
#include "util.h"

enum { SIDE = 16 };

static const float identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };

/* A square in the plane z = 0 that fills the picture, seen from +z; with normals, texture coordinates, tangents. */
static uint32_t make_square(glbk_context *gl, uint32_t *buffer)
{
    static const float v[4][12] = { { -1, -1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 1 }, { 1, -1, 0, 0, 0, 1, 1, 0, 1, 0, 0, 1 },
                                    { -1, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 1 }, { 1, 1, 0, 0, 0, 1, 1, 1, 1, 0, 0, 1 } };
    static const int32_t sizes[4] = { 3, 3, 2, 4 };
    uint32_t name, i;
    size_t at = 0;
    gl->gl.GenVertexArrays(1, &name);
    gl->gl.GenBuffers(1, buffer);
    gl->gl.BindVertexArray(name);
    gl->gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, *buffer);
    gl->gl.BufferData(GLBK_GL_ARRAY_BUFFER, sizeof v, v, GLBK_GL_STATIC_DRAW);
    for (i = 0; i < 4; i++) {
        gl->gl.EnableVertexAttribArray(i);
        gl->gl.VertexAttribPointer(i, sizes[i], GLBK_GL_FLOAT, 0, sizeof v[0], (const void *)at);
        at += 4 * (size_t)sizes[i];
    }
    gl->gl.BindVertexArray(0);
    return name;
}

/* One sun straight ahead: radiance of a Lambert square is E rho cos / pi. */
static void render_sun(gl_test *t, glbk_csm_renderer *r, const glbk_gbuffer *seen, const glbk_csm_maps *maps)
{
    lsamp_light_desc sun;
    glbk_csm_lights_desc all;
    glbk_csm_lights lights;
    glbk_csm_frame_desc f;
    glbk_csm_use use;
    uint32_t start;
    memset(&sun, 0, sizeof sun);
    memset(&all, 0, sizeof all);
    memset(&f, 0, sizeof f);
    memset(&use, 0, sizeof use);
    sun.kind = LSAMP_LIGHT_SUN;
    sun.direction[2] = 1;
    sun.radiance[0] = sun.radiance[1] = sun.radiance[2] = 3.14159265f;
    all.lights = &sun;
    all.light_count = 1;
    assert_glbk(t, glbk_csm_lights_create(&t->gl, &all, &start, &lights));
    use.start = start;
    use.kind = sun.kind;
    use.maps = maps;
    use.sample_count = 1;
    f.lights = &lights;
    f.uses = &use;
    f.use_count = 1;
    f.eye[2] = 3;
    f.bias = 1;
    assert_glbk(t, glbk_csm_render(&t->gl, r, seen, &f));
    glbk_csm_lights_free(&t->gl, &lights);
}

static void draws_with_maps_and_resolves(void **state)
{
    GL_TEST(t, state)
    static const uint8_t half[4] = { 255, 128, 0, 255 },
                         bump[4] = { 218, 128, 218, 255 }; /* leans by 45 degrees to x */
    static const float eye[3] = { 0, 0, 3 };
    glbk_csm_renderer_desc desc = { SIDE, SIDE, 0, 0, NULL };
    glbk_gbuffer_desc sizes = { SIDE, SIDE, { 0, 0, 0, 0, NULL, NULL }, NULL };
    glbk_gbuffer seen;
    float clip[16];
    glbk_csm_renderer r;
    glbk_csm_maps none;
    glbk_surface d;
    glbk_texture_desc td;
    glbk_texture map, normal_map, out;
    glbk_target_desc targets;
    glbk_target target;
    glbk_pass pass;
    float picture[SIDE * SIDE][4], here[4];
    uint32_t square, buffer;

    memset(&d, 0, sizeof d);
    memset(&td, 0, sizeof td);
    memset(&targets, 0, sizeof targets);
    memset(&pass, 0, sizeof pass);
    square = make_square(&t->gl, &buffer);
    td.format = GLBK_FORMAT_RGBA8;
    td.width = td.height = 1;
    td.data = half;
    assert_glbk(t, glbk_texture_create(&t->gl, &td, &map));
    td.data = bump;
    assert_glbk(t, glbk_texture_create(&t->gl, &td, &normal_map));
    assert_glbk(t, glbk_csm_renderer_create(&t->gl, &desc, &r));
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &sizes, &seen));
    assert_glbk(t, glbk_csm_maps_create(&t->gl, NULL, 0, 1, NULL, &none));
    memcpy(d.transform, identity, sizeof identity);
    memcpy(clip, identity, sizeof identity);
    clip[0] = 0.5f;                                       /* the middle half of the columns */
    d.material.kind = LSAMP_MATERIAL_LAMBERT;
    d.material.diffuse[0] = d.material.diffuse[1] = d.material.diffuse[2] = 0.5f;
    d.color_map = &map;
    assert_glbk(t, glbk_gbuffer_begin(&t->gl, &seen, clip, eye));
    assert_glbk(t, glbk_gbuffer_object(&t->gl, &seen, &d));
    t->gl.gl.BindVertexArray(square);
    t->gl.gl.DrawArrays(GLBK_GL_TRIANGLE_STRIP, 0, 4);
    render_sun(t, &r, &seen, &none);
    assert_glbk(t, glbk_csm_read(&t->gl, &r, picture[0]));
    assert_true(picture[SIDE * 8][0] == 0);                 /* nothing is seen there */
    assert_true(fabsf(picture[SIDE * 8 + 8][0] - 0.5f) < 1e-4f);
    assert_true(fabsf(picture[SIDE * 8 + 8][1] - 0.5f * 128 / 255) < 1e-4f);
    assert_true(picture[SIDE * 8 + 8][2] == 0);

    /* the normal map's cosine, and the mean of two frames */
    d.normal_map = &normal_map;
    assert_glbk(t, glbk_gbuffer_begin(&t->gl, &seen, clip, eye));
    assert_glbk(t, glbk_gbuffer_object(&t->gl, &seen, &d));
    t->gl.gl.BindVertexArray(square);
    t->gl.gl.DrawArrays(GLBK_GL_TRIANGLE_STRIP, 0, 4);
    render_sun(t, &r, &seen, &none);
    td.format = GLBK_FORMAT_RGBA8;
    td.width = td.height = SIDE;
    td.data = NULL;
    assert_glbk(t, glbk_texture_create(&t->gl, &td, &out));
    targets.color[0] = &out;
    assert_glbk(t, glbk_target_create(&t->gl, &targets, &target));
    pass.target = &target;
    assert_glbk(t, glbk_csm_resolve(&t->gl, &r, &seen, &pass, NULL));
    assert_glbk(t, glbk_target_read(&t->gl, &target, 0, 8, 8, 1, 1, here));
    assert_true(fabsf(here[0] - 0.5f * (0.5f + 0.35355f)) < 0.006f);
    glbk_csm_reset(&r);
    assert_glbk(t, glbk_csm_resolve(&t->gl, &r, &seen, &pass, NULL));
    assert_glbk(t, glbk_target_read(&t->gl, &target, 0, 8, 8, 1, 1, here));
    assert_true(here[0] == 0);

    t->gl.gl.DeleteVertexArrays(1, &square);
    t->gl.gl.DeleteBuffers(1, &buffer);
    glbk_target_free(&t->gl, &target);
    glbk_texture_free(&t->gl, &out);
    glbk_texture_free(&t->gl, &map);
    glbk_texture_free(&t->gl, &normal_map);
    glbk_csm_renderer_free(&t->gl, &r);
    glbk_gbuffer_free(&t->gl, &seen);
    glbk_csm_maps_free(&t->gl, &none);
}

/* A plate over the left half of the plane z = 0: maps of its shadow. */
static void make_plate(gl_test *t, glbk_csm_maps *out)
{
    static const double low[3] = { -2, -2, 0.5 }, high[3] = { 0, 2, 0.6 };
    model m = model_box(low, high, 0);
    cohsm_mesh mesh = mesh_of(&m);
    cohsm_desc d = desc_of(COHSM_DOMAIN_OCTAHEDRAL, 16, 64);
    cohsm_maps *maps;
    glbk_csm_block block;
    glbk_csm_instance one;
    assert_int_equal(cohsm_build(&d, &mesh, &maps, NULL), COHSM_OK);
    block.data = cohsm_data(maps, &block.bytes);
    memcpy(one.transform, identity, sizeof identity);
    one.offset = 0;
    assert_glbk(t, glbk_csm_maps_create(&t->gl, &block, 1, 1, &one.start, out));
    assert_glbk(t, glbk_csm_maps_place(&t->gl, out, &one, 1));
    cohsm_free(maps);
    model_free(&m);
}

static void maps_are_bound_for_a_shader_of_the_users(void **state)
{
    GL_TEST(t, state)
    static const char text[] =
        "layout(location = 0) out glbk_color result;\n"
        "void main()\n"
        "{\n"
        "    vec3 p = vec3(gl_FragCoord.xy / 8.0 - 1.0, 0.0);\n"
        "    float lit = csm_visible(0u, cohsm_ask(COHSM_LIGHT_DIRECTION, COHSM_FILTER_NEAREST, 1.0), p,\n"
        "                            vec3(0.0, 0.0, 1.0));\n"
        "    result = glbk_pack(vec4(lit));\n"
        "}\n";
    glbk_source source;
    glbk_program program;
    glbk_csm_maps plate;
    glbk_texture_desc td;
    glbk_texture color;
    glbk_target_desc targets;
    glbk_target target;
    glbk_pass pass;
    float picture[SIDE][SIDE][4];

    memset(&source, 0, sizeof source);
    memset(&td, 0, sizeof td);
    memset(&targets, 0, sizeof targets);
    memset(&pass, 0, sizeof pass);
    source.fragment = text;
    source.parts[0] = glbk_csm_part();
    source.uses = "csm_visible";
    assert_glbk(t, glbk_program_compile(&t->gl, &source, &program));
    make_plate(t, &plate);
    td.format = GLBK_FORMAT_COLOR;
    td.width = td.height = SIDE;
    assert_glbk(t, glbk_texture_create(&t->gl, &td, &color));
    targets.color[0] = &color;
    assert_glbk(t, glbk_target_create(&t->gl, &targets, &target));
    pass.target = &target;
    assert_glbk(t, glbk_begin(&t->gl, &pass, &program));
    glbk_csm_bind(&t->gl, &plate, NULL);
    glbk_draw_screen(&t->gl);
    assert_glbk(t, glbk_target_read(&t->gl, &target, 0, 0, 0, SIDE, SIDE, picture[0][0]));
    assert_true(picture[8][2][0] == 0 && picture[8][13][0] == 1);
    glbk_program_free(&t->gl, &program);
    glbk_target_free(&t->gl, &target);
    glbk_texture_free(&t->gl, &color);
    glbk_csm_maps_free(&t->gl, &plate);
}

/* Places and normals in textures of the user's, 8-bit colours: the plate's shadow lies on what was imported. */
static void a_shadow_falls_on_a_gbuffer_of_the_users(void **state)
{
    GL_TEST(t, state)
    static float places[SIDE][SIDE][4], normals[SIDE][SIDE][4];
    static uint8_t colors[SIDE][SIDE][4];
    const glbk_csm_renderer_desc desc = { SIDE, SIDE, 0, 0, NULL };
    const glbk_gbuffer_desc sizes = { SIDE, SIDE, { 0, 0, 0, 0, NULL, NULL }, NULL };
    glbk_texture_desc td;
    glbk_texture mine[3];
    glbk_import import;
    glbk_csm_renderer r;
    glbk_gbuffer seen;
    glbk_csm_maps plate;
    float picture[SIDE][SIDE][4];
    int x, y, i;

    memset(&td, 0, sizeof td);
    memset(&import, 0, sizeof import);
    for (y = 0; y < SIDE; y++)
        for (x = 0; x < SIDE; x++) {
            places[y][x][0] = ((float)x + 0.5f) / 8 - 1;
            places[y][x][1] = ((float)y + 0.5f) / 8 - 1;
            places[y][x][3] = normals[y][x][2] = 1;
            colors[y][x][0] = colors[y][x][3] = 255;
        }
    td.width = td.height = SIDE;
    td.format = GLBK_FORMAT_RGBA32F;
    td.data = places;
    assert_glbk(t, glbk_texture_create(&t->gl, &td, &mine[0]));
    td.data = normals;
    assert_glbk(t, glbk_texture_create(&t->gl, &td, &mine[1]));
    td.format = GLBK_FORMAT_RGBA8;
    td.data = colors;
    assert_glbk(t, glbk_texture_create(&t->gl, &td, &mine[2]));
    import.positions = &mine[0];
    import.normals = &mine[1];
    import.color_map = &mine[2];
    import.eye[2] = 3;
    for (i = 0; i < 3; i++) import.material.diffuse[i] = 0.5f;
    assert_glbk(t, glbk_csm_renderer_create(&t->gl, &desc, &r));
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &sizes, &seen));
    assert_glbk(t, glbk_gbuffer_import(&t->gl, &seen, &import));
    make_plate(t, &plate);
    render_sun(t, &r, &seen, &plate);
    assert_glbk(t, glbk_csm_read(&t->gl, &r, picture[0][0]));
    assert_true(picture[8][2][0] == 0 && fabsf(picture[8][13][0] - 0.5f) < 1e-4f && picture[8][13][1] == 0);
    for (i = 0; i < 3; i++) glbk_texture_free(&t->gl, &mine[i]);
    glbk_csm_renderer_free(&t->gl, &r);
    glbk_gbuffer_free(&t->gl, &seen);
    glbk_csm_maps_free(&t->gl, &plate);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = { gl_unit_test(draws_with_maps_and_resolves),
                                  gl_unit_test(maps_are_bound_for_a_shader_of_the_users),
                                  gl_unit_test(a_shadow_falls_on_a_gbuffer_of_the_users) };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_ALL);
}
