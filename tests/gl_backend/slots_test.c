/* slots_test - several parts in one program: an offset for each keeps their textures and uniform blocks apart, and
   where they meet, compiling says which names do, or glbk_set_slots, of a program that the user linked. With two small
   parts of the test's own. */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl_backend/gl_csm.h"
#include "gl_backend/gl_rsm.h"

#include "gl_test.h"

/* Each part has a texture at slot 3 and a block at slot 2. */
#define ONE_TEXT \
    "uniform sampler2D glbk_one_map;\n" \
    "layout(std140) uniform glbk_one_values_block { vec4 scale; } glbk_one_values;\n" \
    "float one() { return texelFetch(glbk_one_map, ivec2(0), 0).r * glbk_one_values.scale.x; }\n\0"
#define TWO_TEXT \
    "uniform sampler2D glbk_two_map;\n" \
    "layout(std140) uniform glbk_two_values_block { vec4 scale; } glbk_two_values;\n" \
    "float two() { return texelFetch(glbk_two_map, ivec2(0), 0).r * glbk_two_values.scale.x; }\n\0"
static const glbk_file one_files[] = { { "lib/one.glsl\0\0\0\0\0" ONE_TEXT } };
static const glbk_file two_files[] = { { "lib/two.glsl\0\0\0\0\0" TWO_TEXT } };
static const glbk_part part_one = { "one", one_files, 1, "3 glbk_one_map\0\0" "2 glbk_one_values_block\0\0\0" };
static const glbk_part part_two = { "two", two_files, 1, "3 glbk_two_map\0\0" "2 glbk_two_values_block\0\0\0" };

static const char both[] = "layout(location = 0) out vec4 color;\n"
                           "void main() { color = vec4(one(), two(), 0.0, 1.0); }\n";

static glbk_source source_of(const char *text, const glbk_part *first, const glbk_part *second)
{
    glbk_source s;
    memset(&s, 0, sizeof s);
    s.fragment = text;
    s.uses = first && second ? "one two" : first ? "one" : "";
    s.parts[0] = first;
    s.parts[3] = second;            /* NULLs between are left out */
    return s;
}

typedef struct things { glbk_texture maps[2]; glbk_buffer values[2]; gl_canvas screen; } things;

static things make_things(gl_test *t)
{
    static const uint8_t red[2][4] = { { 51, 0, 0, 0 }, { 102, 0, 0, 0 } };
    static const float scales[2][4] = { { 1, 0, 0, 0 }, { 2, 0, 0, 0 } };
    things x;
    int i;
    memset(&x, 0, sizeof x);
    x.screen = gl_canvas_make(t, GLBK_FORMAT_RGBA8, 1, 1, 0);
    for (i = 0; i < 2; i++) {
        glbk_texture_desc d;
        memset(&d, 0, sizeof d);
        d.format = GLBK_FORMAT_RGBA8;
        d.width = d.height = 1;
        d.data = red[i];
        assert_glbk(t, glbk_texture_create(&t->gl, &d, &x.maps[i]));
        assert_glbk(t, glbk_buffer_create(&t->gl, sizeof scales[i], scales[i], &x.values[i]));
    }
    return x;
}

static void free_things(gl_test *t, things *x)
{
    int i;
    for (i = 0; i < 2; i++) {
        glbk_texture_free(&t->gl, &x->maps[i]);
        glbk_buffer_free(&t->gl, &x->values[i]);
    }
    gl_canvas_free(t, &x->screen);
}

/* Draws with what stands at the slots, and compares: 51 * 1 and 102 * 2 of 255. */
static void shows_both(gl_test *t, things *x, glbk_program *program, uint32_t name, glbk_offset second)
{
    glbk_pass pass;
    float rgba[4];
    memset(&pass, 0, sizeof pass);
    pass.target = &x->screen.target;
    assert_glbk(t, glbk_begin(&t->gl, &pass, program));
    if (!program) t->gl.gl.UseProgram(name);
    glbk_bind_texture(&t->gl, 3, &x->maps[0]);
    glbk_bind_block(&t->gl, 2, &x->values[0]);
    glbk_bind_texture(&t->gl, second.unit + 3, &x->maps[1]);
    glbk_bind_block(&t->gl, second.block + 2, &x->values[1]);
    glbk_draw_screen(&t->gl);
    assert_glbk(t, glbk_target_read(&t->gl, &x->screen.target, 0, 0, 0, 1, 1, rgba));
    assert_float_equal(255 * rgba[0], 51, 0.25);
    assert_float_equal(255 * rgba[1], 204, 0.25);
}

static void an_offset_keeps_two_parts_apart(void **state)
{
    GL_TEST(t, state)
    static const glbk_offset seconds[] = { { 1, 1 }, { 16, 8 }, { GLBK_MAX_UNITS - 4, GLBK_MAX_BLOCKS - 3 } };
    things x = make_things(t);
    size_t i;
    for (i = 0; i < sizeof seconds / sizeof seconds[0]; i++) {
        glbk_source s = source_of(both, &part_one, &part_two);
        glbk_program program;
        s.offsets[3] = seconds[i];
        assert_glbk(t, glbk_program_compile(&t->gl, &s, &program));
        shows_both(t, &x, &program, 0, seconds[i]);
        glbk_program_free(&t->gl, &program);
    }
    free_things(t, &x);
}

static void parts_that_meet_are_named(void **state)
{
    GL_TEST(t, state)
    glbk_source s = source_of(both, &part_one, &part_two);
    glbk_program program;
    char wanted[200];

    memset(&program, 0xA5, sizeof program);
    assert_int_equal(glbk_program_compile(&t->gl, &s, &program), GLBK_ERR_MISMATCH);
    assert_int_equal(program.name, 0);
    assert_string_equal(t->log, "glbk_program_compile: glbk_one_map and glbk_two_map both have texture unit 3: give "
                                "one part an offset");
    s.offsets[3].unit = 4;
    assert_int_equal(glbk_program_compile(&t->gl, &s, &program), GLBK_ERR_MISMATCH);
    assert_string_equal(t->log, "glbk_program_compile: glbk_one_values_block and glbk_two_values_block both have the "
                                "binding of uniform blocks 2: give one part an offset");
    s.offsets[3].block = GLBK_MAX_BLOCKS - 2;
    assert_int_equal(glbk_program_compile(&t->gl, &s, &program), GLBK_ERR_LIMIT);
    snprintf(wanted, sizeof wanted, "glbk_program_compile: glbk_two_values_block is %d; it must be 0..%d",
             (int)GLBK_MAX_BLOCKS, (int)GLBK_MAX_BLOCKS - 1);
    assert_string_equal(t->log, wanted);
    s.offsets[3].unit = UINT32_MAX;         /* not a small number again by overflow */
    assert_int_equal(glbk_program_compile(&t->gl, &s, &program), GLBK_ERR_LIMIT);
    s.offsets[3].unit = 0;

    /* What a program does not declare is in nobody's way. */
    s.fragment = "layout(location = 0) out vec4 color;\nvoid main() { color = vec4(one()); }\n";
    s.uses = "one";
    s.offsets[3].block = 0;
    assert_glbk(t, glbk_program_compile(&t->gl, &s, &program));
    glbk_program_free(&t->gl, &program);
    /* Nor is a sampler of the user's, unless it stands where a part was moved to. */
    s.fragment = "uniform sampler2D glbk_user0;\nlayout(location = 0) out vec4 color;\n"
                 "void main() { color = vec4(one()) + texelFetch(glbk_user0, ivec2(0), 0); }\n";
    assert_glbk(t, glbk_program_compile(&t->gl, &s, &program));
    glbk_program_free(&t->gl, &program);
    s.offsets[0].unit = GLBK_SLOT_glbk_user0 - 3;
    assert_int_equal(glbk_program_compile(&t->gl, &s, &program), GLBK_ERR_MISMATCH);
    assert_non_null(strstr(t->log, "glbk_user0 and glbk_one_map both have texture unit 12"));
}

/* The library's own, which begin with slot 0 each. */
static void two_techniques_meet(void **state)
{
    GL_TEST(t, state)
    glbk_source s;
    glbk_program program;
    memset(&s, 0, sizeof s);
    s.fragment = "layout(location = 0) out glbk_color color;\n"
                 "void main()\n{\n"
                 "    vec3 p = vec3(gl_FragCoord.xy, 1.0), n = vec3(0.0, 0.0, 1.0);\n"
                 "    cohsm_query ask = cohsm_ask(COHSM_LIGHT_DIRECTION, COHSM_FILTER_NEAREST, 1.0);\n"
                 "    vec3 light = rsm_gather_list(rsm_bound(), p, n, 0u, 4u, false, 0.0);\n"
                 "    color = glbk_pack(vec4(light * csm_visible(0u, ask, p, n), 1.0));\n"
                 "}\n";
    s.uses = "csm_visible rsm_gather";
    s.parts[0] = glbk_csm_part();
    s.parts[1] = glbk_rsm_part();
    assert_int_equal(glbk_program_compile(&t->gl, &s, &program), GLBK_ERR_MISMATCH);
    assert_non_null(strstr(t->log, "glbk_csm_"));
    assert_non_null(strstr(t->log, "glbk_rsm_"));
    s.offsets[1].unit = GLBK_UNITS;
    s.offsets[1].block = GLBK_BLOCKS;
    assert_glbk(t, glbk_program_compile(&t->gl, &s, &program));
    glbk_program_free(&t->gl, &program);
}

static uint32_t link_text(gl_test *t, const char *vertex, const char *fragment)
{
    const glbk_functions *gl = &t->gl.gl;
    const char *texts[2];
    const uint32_t types[2] = { 0x8B31, 0x8B30 };
    uint32_t program = gl->CreateProgram();
    int32_t linked = 0;
    int i;
    texts[0] = vertex;
    texts[1] = fragment;
    for (i = 0; i < 2; i++) {
        uint32_t shader = gl->CreateShader(types[i]);
        gl->ShaderSource(shader, 1, &texts[i], NULL);
        gl->CompileShader(shader);
        gl->AttachShader(program, shader);
        gl->DeleteShader(shader);
    }
    gl->LinkProgram(program);
    gl->GetProgramiv(program, 0x8B82 /* LINK_STATUS */, &linked);
    assert_true(linked);
    return program;
}

/* Links a text that uses two parts as a renderer of its own does. */
static uint32_t link_parts(gl_test *t, const char *text, const char *uses, const glbk_part *first,
                           const glbk_part *second)
{
    static char vertex[20000], fragment[200000];
    const glbk_dialect dialect = t->gl.es ? GLBK_GLSL_300_ES : GLBK_GLSL_DEFAULT;
    glbk_shader shader;
    memset(&shader, 0, sizeof shader);
    shader.name = "prog/screen.vert";
    assert_in_range(glbk_write_glsl(dialect, 0, &shader, vertex, sizeof vertex), 1, sizeof vertex);
    shader.name = NULL;
    shader.text = text;
    shader.uses = uses;
    shader.parts[0] = first;
    shader.parts[1] = second;
    assert_in_range(glbk_write_glsl(dialect, !t->gl.float_targets, &shader, fragment, sizeof fragment), 1,
                    sizeof fragment);
    return link_text(t, vertex, fragment);
}

/* A program that the user linked takes one part after the other, while another program is in use. */
static void set_slots_takes_an_offset(void **state)
{
    GL_TEST(t, state)
    const glbk_offset second = { 20, 9 }, far = { 0, GLBK_MAX_BLOCKS };
    things x = make_things(t);
    uint32_t program = link_parts(t, both, "one two", &part_one, &part_two);
    assert_glbk(t, glbk_set_slots(&t->gl, &part_one, NULL, program));
    assert_glbk(t, glbk_set_slots(&t->gl, &part_two, &second, program));
    assert_int_equal(glbk_set_slots(&t->gl, &part_two, &far, program), GLBK_ERR_LIMIT);
    assert_non_null(strstr(t->log, "glbk_set_slots: glbk_two_values_block is 18"));
    shows_both(t, &x, NULL, program, second);
    t->gl.gl.UseProgram(0);
    t->gl.gl.DeleteProgram(program);
    free_things(t, &x);
}

/* The unit of a sampler of a program. In use, since Emscripten finds places of uniforms in that program alone. */
static int32_t unit_of(gl_test *t, uint32_t program, const char *name)
{
    int32_t unit = -1;
    t->gl.gl.UseProgram(program);
    t->gl.gl.GetUniformiv(program, t->gl.gl.GetUniformLocation(program, name), &unit);
    return unit;
}

static void delete_program(gl_test *t, uint32_t program)
{
    t->gl.gl.UseProgram(0);
    t->gl.gl.DeleteProgram(program);
}

/* Each call knows one part, and finds what the calls before have set. What it refuses it does not change. */
static void set_slots_refuses_parts_that_meet(void **state)
{
    GL_TEST(t, state)
    const glbk_offset second = { 20, 9 }, block_alone = { 20, 0 };
    uint32_t program = link_parts(t, both, "one two", &part_one, &part_two);
    things x = make_things(t);

    assert_glbk(t, glbk_set_slots(&t->gl, &part_one, NULL, program));
    assert_int_equal(glbk_set_slots(&t->gl, &part_two, NULL, program), GLBK_ERR_MISMATCH);
    assert_string_equal(t->log, "glbk_set_slots: glbk_one_map and glbk_two_map both have texture unit 3: give one part "
                                "an offset");
    assert_int_equal(glbk_set_slots(&t->gl, &part_two, &block_alone, program), GLBK_ERR_MISMATCH);
    assert_string_equal(t->log, "glbk_set_slots: glbk_one_values_block and glbk_two_values_block both have the binding "
                                "of uniform blocks 2: give one part an offset");
    assert_int_equal(unit_of(t, program, "glbk_one_map"), 3);
    /* Again, with an offset, and each call once more. */
    assert_glbk(t, glbk_set_slots(&t->gl, &part_two, &second, program));
    assert_glbk(t, glbk_set_slots(&t->gl, &part_one, NULL, program));
    assert_glbk(t, glbk_set_slots(&t->gl, &part_two, &second, program));
    assert_glbk(t, glbk_set_slots(&t->gl, NULL, NULL, program));
    shows_both(t, &x, NULL, program, second);
    assert_int_equal(glbk_set_slots(&t->gl, &part_one, &second, program), GLBK_ERR_MISMATCH);
    delete_program(t, program);
    free_things(t, &x);
}

/* Slot 0 is GL's default as well: before a part's call its names are at 0 and in nobody's way, afterwards they hold
   it. */
static void set_slots_tells_a_unit_0_that_was_set_from_the_default(void **state)
{
    GL_TEST(t, state)
    static const glbk_part first = { "one", one_files, 1, "0 glbk_one_map\0\0" "0 glbk_one_values_block\0\0\0" };
    static const glbk_part second = { "two", two_files, 1, "0 glbk_two_map\0\0" "0 glbk_two_values_block\0\0\0" };
    const glbk_offset units = { 1, 0 }, apart = { 1, 1 };
    int swapped;
    for (swapped = 0; swapped < 2; swapped++) {
        const glbk_part *a = swapped ? &second : &first, *b = swapped ? &first : &second;
        uint32_t program = link_parts(t, both, "one two", &first, &second);
        assert_glbk(t, glbk_set_slots(&t->gl, a, NULL, program));
        assert_glbk(t, glbk_set_slots(&t->gl, NULL, NULL, program));        /* the base alone takes nothing away */
        assert_int_equal(unit_of(t, program, a == &first ? "glbk_one_map" : "glbk_two_map"), 0);
        assert_int_equal(glbk_set_slots(&t->gl, b, NULL, program), GLBK_ERR_MISMATCH);
        assert_non_null(strstr(t->log, " both have texture unit 0"));
        assert_int_equal(glbk_set_slots(&t->gl, b, &units, program), GLBK_ERR_MISMATCH);
        assert_non_null(strstr(t->log, " both have the binding of uniform blocks 0"));
        assert_glbk(t, glbk_set_slots(&t->gl, b, &apart, program));
        assert_glbk(t, glbk_set_slots(&t->gl, a, NULL, program));
        assert_int_equal(unit_of(t, program, a == &first ? "glbk_one_map" : "glbk_two_map"), 0);
        assert_int_equal(unit_of(t, program, a == &first ? "glbk_two_map" : "glbk_one_map"), 1);
        delete_program(t, program);
    }
}

/* A sampler of the user's own counts once it has a unit, each element of an array by itself. */
static void set_slots_sees_samplers_of_the_users_own(void **state)
{
    GL_TEST(t, state)
    static const char text[] = "uniform sampler2D mine, many[3], glbk_user1;\n"
                               "layout(location = 0) out vec4 color;\n"
                               "void main() { color = vec4(one()) + texelFetch(mine, ivec2(0), 0)\n"
                               "    + texelFetch(many[0], ivec2(0), 0) + texelFetch(many[2], ivec2(0), 0)\n"
                               "    + texelFetch(glbk_user1, ivec2(0), 0); }\n";
    const glbk_functions *gl = &t->gl.gl;
    const glbk_offset on_user1 = { GLBK_SLOT_glbk_user1 - 3, 0 };
    uint32_t program = link_parts(t, text, "one", &part_one, NULL);

    assert_glbk(t, glbk_set_slots(&t->gl, &part_one, NULL, program));
    gl->UseProgram(program);
    gl->Uniform1i(gl->GetUniformLocation(program, "mine"), 3);
    assert_int_equal(glbk_set_slots(&t->gl, &part_one, NULL, program), GLBK_ERR_MISMATCH);
    assert_non_null(strstr(t->log, "mine and glbk_one_map both have texture unit 3"));
    gl->Uniform1i(gl->GetUniformLocation(program, "mine"), 0);
    assert_glbk(t, glbk_set_slots(&t->gl, &part_one, NULL, program));
    gl->Uniform1i(gl->GetUniformLocation(program, "many[2]"), 3);
    assert_int_equal(glbk_set_slots(&t->gl, &part_one, NULL, program), GLBK_ERR_MISMATCH);
    assert_non_null(strstr(t->log, "many[0] and glbk_one_map both have texture unit 3"));
    gl->Uniform1i(gl->GetUniformLocation(program, "many[2]"), 4);
    assert_int_equal(glbk_set_slots(&t->gl, &part_one, &on_user1, program), GLBK_ERR_MISMATCH);
    assert_non_null(strstr(t->log, "glbk_user1 and glbk_one_map both have texture unit 13"));
    delete_program(t, program);
}

/* Two techniques, whose slots begin with 0 each. */
static void set_slots_refuses_two_techniques_that_meet(void **state)
{
    GL_TEST(t, state)
    static const char text[] = "layout(location = 0) out vec4 color;\n"
                               "void main()\n{\n"
                               "    vec3 p = vec3(gl_FragCoord.xy, 1.0), n = vec3(0.0, 0.0, 1.0);\n"
                               "    cohsm_query ask = cohsm_ask(COHSM_LIGHT_DIRECTION, COHSM_FILTER_NEAREST, 1.0);\n"
                               "    vec3 light = rsm_gather_list(rsm_bound(), p, n, 0u, 4u, false, 0.0);\n"
                               "    color = vec4(light * csm_visible(0u, ask, p, n), 1.0);\n"
                               "}\n";
    const glbk_offset behind = { GLBK_UNITS, GLBK_BLOCKS };
    uint32_t program = link_parts(t, text, "csm_visible rsm_gather", glbk_csm_part(), glbk_rsm_part());
    assert_glbk(t, glbk_set_slots(&t->gl, glbk_csm_part(), NULL, program));
    assert_int_equal(glbk_set_slots(&t->gl, glbk_rsm_part(), NULL, program), GLBK_ERR_MISMATCH);
    assert_non_null(strstr(t->log, "glbk_set_slots: glbk_csm_"));
    assert_non_null(strstr(t->log, " and glbk_rsm_"));
    assert_glbk(t, glbk_set_slots(&t->gl, glbk_rsm_part(), &behind, program));
    delete_program(t, program);
}

/* GLSL says the numbers of storage buffers and images, so that no offset helps. */
static void storage_and_images_that_meet_are_named(void **state)
{
    GL_TEST(t, state)
    static const glbk_file files[] = {
        { "lib/one_words.glsl\0\0\0\0\0"
          "layout(std430, binding = 1) buffer glbk_one_words_storage { uint glbk_one_words[]; };\n\0" },
        { "lib/two_words.glsl\0\0\0\0\0"
          "layout(std430, binding = 1) buffer glbk_two_words_storage { uint glbk_two_words[]; };\n\0" },
        { "lib/one_image.glsl\0\0\0\0\0" "layout(r32ui, binding = 2) uniform highp uimage2D glbk_one_image;\n\0" },
        { "lib/two_image.glsl\0\0\0\0\0" "layout(r32ui, binding = 2) uniform highp uimage2D glbk_two_image;\n\0" }
    };
    static const glbk_part one = { "one", files, 4, "\0\0" "1 glbk_one_words_storage\0\0" "2 glbk_one_image\0" };
    static const glbk_part two = { "two", files, 4, "\0\0" "1 glbk_two_words_storage\0\0" "2 glbk_two_image\0" };
    glbk_source s;
    glbk_program program;
    if (!t->gl.compute) return;
    memset(&s, 0, sizeof s);
    s.parts[0] = &one;
    s.parts[1] = &two;
    s.uses = "one_words two_words";
    s.compute = "layout(local_size_x = 1) in;\nvoid main() { glbk_one_words[0] = glbk_two_words[0] + 1u; }\n";
    assert_int_equal(glbk_program_compile(&t->gl, &s, &program), GLBK_ERR_MISMATCH);
    assert_string_equal(t->log, "glbk_program_compile: glbk_one_words_storage and glbk_two_words_storage both have "
                                "storage buffer 1: give each part a program of its own");
    s.uses = "one_image two_image";
    s.compute = "layout(local_size_x = 1) in;\n"
                "void main() { imageStore(glbk_one_image, ivec2(0), imageLoad(glbk_two_image, ivec2(0))); }\n";
    assert_int_equal(glbk_program_compile(&t->gl, &s, &program), GLBK_ERR_MISMATCH);
    assert_string_equal(t->log, "glbk_program_compile: glbk_one_image and glbk_two_image both have image 2: give each "
                                "part a program of its own");
    s.uses = "one_words two_image";
    s.compute = "layout(local_size_x = 1) in;\n"
                "void main() { glbk_one_words[0] = imageLoad(glbk_two_image, ivec2(0)).x; }\n";
    assert_glbk(t, glbk_program_compile(&t->gl, &s, &program));
    glbk_program_free(&t->gl, &program);
}

/* What was bound at units and bindings that only an offset reaches comes back, too. */
static void state_beyond_the_slots_comes_back(void **state)
{
    GL_TEST(t, state)
    static glbk_state saved;
    const uint32_t unit = GLBK_MAX_UNITS - 1, block = GLBK_MAX_BLOCKS - 1;
    things x = make_things(t);
    int32_t texture = 0, buffer = 0;
    glbk_bind_texture(&t->gl, unit, &x.maps[0]);
    glbk_bind_block(&t->gl, block, &x.values[0]);
    glbk_state_save(&t->gl, &saved);
    glbk_bind_texture(&t->gl, unit, &x.maps[1]);
    glbk_bind_block(&t->gl, block, &x.values[1]);
    glbk_state_restore(&t->gl, &saved);
    t->gl.gl.ActiveTexture(GLBK_GL_TEXTURE0 + unit);
    t->gl.gl.GetIntegerv(0x8069 /* TEXTURE_BINDING_2D */, &texture);
    t->gl.gl.GetIntegeri_v(0x8A28 /* UNIFORM_BUFFER_BINDING */, block, &buffer);
    assert_int_equal(texture, x.maps[0].name);
    assert_int_equal(buffer, x.values[0].name);
    free_things(t, &x);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(an_offset_keeps_two_parts_apart), gl_unit_test(parts_that_meet_are_named),
        gl_unit_test(two_techniques_meet),             gl_unit_test(set_slots_takes_an_offset),
        gl_unit_test(set_slots_refuses_parts_that_meet),
        gl_unit_test(set_slots_tells_a_unit_0_that_was_set_from_the_default),
        gl_unit_test(set_slots_sees_samplers_of_the_users_own),
        gl_unit_test(set_slots_refuses_two_techniques_that_meet),
        gl_unit_test(storage_and_images_that_meet_are_named),
        gl_unit_test(state_beyond_the_slots_comes_back)
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_USUAL);
}
