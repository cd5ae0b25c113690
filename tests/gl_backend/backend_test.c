/* gl_backend.h on every driver: programs, textures, tables, buffers, targets, passes. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#define GL_BACKEND_IMPLEMENTATION
#define GL_PROGRAMS_IMPLEMENTATION
#include "gl_backend/gl_csm.h"
#include "gl_backend/gl_wavelets.h"
#include "gl_backend/gl_envshadow.h"
#include "gl_backend/gl_rsm.h"
#include "gl_backend/gl_ism.h"

#include "gl_test.h"

static const glbk_part *part_at(uint32_t i)
{
    const glbk_part *const parts[7] = { glbk__base(), glbk_csm_part(), glbk_sfield_part(), glbk_envsh_part(),
                                        glbk_rsm_part(), glbk_ism_part(), glbk__wavelets() };
    return parts[i];
}
enum { PART_COUNT = 7 };

static uint32_t hash(uint32_t x)
{
    x = (x ^ x >> 16) * 0x7feb352du;
    x = (x ^ x >> 15) * 0x846ca68bu;
    return x ^ x >> 16;
}

/* ---- programs ---- */

/* A program declares the uniform blocks that its text names and no others: browsers refuse to draw while one has no
   buffer, as the contexts of these tests do (gl_watch.c). */
static void blocks_are_those_named(void **state)
{
    GL_TEST(t, state)
    static const char *const texts[] = {
        "layout(location = 0) out glbk_color result;\nvoid main() { result = glbk_pack(vec4(glbk_csm_scene_unread)); }\n",
        "layout(location = 0) out glbk_color result;\n"
        "void main() { result = glbk_pack(vec4(glbk_csm_scene.count) * 0.5); }\n"
    };
    gl_canvas canvas = gl_canvas_make(t, GLBK_FORMAT_COLOR, 4, 4, 0);
    int k;
    for (k = 0; k < 2; k++) {
        const float three[4] = { 3, 3, 3, 3 };
        float scene[sizeof(glbk_csm_scene) / sizeof(float)] = { 0 }, out[64];
        int32_t active = -1;
        glbk_source source = { 0 };
        glbk_program program;
        glbk_buffer buffer;
        glbk_pass pass = { 0 };
        uint32_t six = 6;

        source.fragment = texts[k];
        source.parts[0] = glbk_csm_part();
        source.uses = "csm_bindings";
        source.defines = "glbk_csm_scene_unread=3.0";
        assert_glbk(t, glbk_program_compile(&t->gl, &source, &program));
        t->gl.gl.GetProgramiv(program.name, 0x8A36 /* ACTIVE_UNIFORM_BLOCKS */, &active);
        assert_int_equal(active, k);
        memcpy(scene, &six, 4), memcpy(scene + 1, &six, 4), memcpy(scene + 2, &six, 4), memcpy(scene + 3, &six, 4);
        assert_glbk(t, glbk_buffer_create(&t->gl, sizeof scene, scene, &buffer));
        pass.target = &canvas.target;
        assert_glbk(t, glbk_begin(&t->gl, &pass, &program));
        glbk_draw_screen(&t->gl);
        assert_int_equal(ex_gl_errors(t->context, NULL), k);        /* the second needs a buffer */
        if (k) glbk_bind_block(&t->gl, GLBK_SLOT_glbk_csm_scene, &buffer);
        glbk_draw_screen(&t->gl);
        assert_int_equal(ex_gl_errors(t->context, NULL), k);
        assert_glbk(t, glbk_target_read(&t->gl, &canvas.target, 0, 0, 0, 4, 4, out));
        assert_memory_equal(out, three, sizeof three);
        glbk_buffer_free(&t->gl, &buffer);
        glbk_program_free(&t->gl, &program);
    }
    t->expected_errors = 1;
    gl_canvas_free(t, &canvas);
}

/* Every program of the library with every set of its defines compiles and links on the driver. */
static uint32_t link_programs(gl_test *t, const glbk_part *part)
{
    uint32_t i, built = 0;
    for (i = 0; i < part->file_count; i++) {
        const char *s = glbk__file_fact(&part->files[i], GLBK__FILE_SETS), *name = part->files[i].name + 5;
        if (strncmp(part->files[i].name, "prog/", 5) != 0 || strstr(name, ".vert")) continue;
        if (strstr(name, ".comp") && !t->gl.compute) continue;
        for (; s; s = strchr(s, '|'), s = s ? s + 1 : NULL) {
            char defines[256];
            glbk_program program;
            glbk_result result;
            snprintf(defines, sizeof defines, "%.*s", (int)strcspn(s, "|"), s);
            /* Those of the techniques read the G-buffer by files of gl_gbuffer.h's part, wavelets the tables of
               gl_shadowfield.h. */
            if (part == glbk__base()) result = glbk__program_create(&t->gl, part, name, defines, &program);
            else result = glbk__gbuffer_program_above(&t->gl, part, glbk__sfield_reader(), name, defines, &program);
            assert_glbk(t, result);
            glbk_program_use(&t->gl, &program);
            t->gl.gl.UseProgram(0);
            glbk_program_free(&t->gl, &program);
            built++;
        }
    }
    return built;
}

static void every_program_links(void **state)
{
    GL_TEST(t, state)
    uint32_t i;
    assert_int_equal(link_programs(t, part_at(0)), 2);
    if (!(gl_this_way()->bit & GL_USUAL)) return;       /* the other ways have the same compiler as these */
    for (i = 1; i < PART_COUNT; i++) assert_true(link_programs(t, part_at(i)) > 2);
}

static void errors_name_file_and_line(void **state)
{
    GL_TEST(t, state)
    glbk_program p;
    glbk_source s = { 0 };

    t->expected_errors = ~0u;       /* the driver repeats its words as messages */
    s.fragment = "layout(location = 0) out vec4 c;\nvoid main()\n{\n    c = nonsense;\n}\n";
    s.uses = "table";
    assert_int_equal(glbk_program_compile(&t->gl, &s, &p), GLBK_ERR_COMPILE);
    assert_int_equal(p.name, 0);
    assert_non_null(strstr(t->log, "3 your text"));
    assert_non_null(strstr(t->log, "2 lib/table.glsl"));
    assert_non_null(strstr(t->log, "3004"));
    assert_non_null(strstr(t->log, "nonsense"));

    s.vertex = "out vec2 two_kinds;\nvoid main() { two_kinds = vec2(0.0); gl_Position = vec4(0.0); }\n";
    s.fragment = "in vec3 two_kinds;\nlayout(location = 0) out vec4 c;\nvoid main() { c = vec4(two_kinds, 1.0); }\n";
    assert_int_equal(glbk_program_compile(&t->gl, &s, &p), GLBK_ERR_LINK);
    assert_int_equal(p.name, 0);
    assert_non_null(strstr(t->log, "two_kinds"));
    s.uses = "table no_such_file";
    assert_int_equal(glbk_program_compile(&t->gl, &s, &p), GLBK_ERR_NAME);
    assert_string_equal(t->log, "glbk_program_compile: the library file no_such_file is in none of the parts");
    s.uses = NULL;
    s.defines = "1BAD";
    assert_int_equal(glbk_program_compile(&t->gl, &s, &p), GLBK_ERR_NAME);
    assert_string_equal(t->log, "glbk_program_compile: defines do not parse: 1BAD");
    s.defines = NULL;
    s.compute = s.fragment;
    assert_int_equal(glbk_program_compile(&t->gl, &s, &p), GLBK_ERR_DESC);
    assert_string_equal(t->log, "glbk_program_compile: source.fragment is given, and so is source.compute: a program "
                                "has one of them");
    s.fragment = NULL;
    if (!t->gl.compute) {
        assert_int_equal(glbk_program_compile(&t->gl, &s, &p), GLBK_ERR_FEATURE);
        assert_string_equal(t->log, "glbk_program_compile: source.compute needs OpenGL 4.3");
    }
    s.compute = NULL;
    assert_int_equal(glbk_program_compile(&t->gl, &s, &p), GLBK_ERR_DESC);
    assert_string_equal(t->log, "glbk_program_compile: source.fragment is NULL, and so is source.compute");
    assert_int_equal(glbk__program_create(&t->gl, NULL, "nothing.frag", NULL, &p), GLBK_ERR_NAME);
    assert_int_equal(glbk__program_create(&t->gl, NULL, "screen.vert", NULL, &p), GLBK_ERR_NAME);
    assert_int_equal(glbk__program_create(&t->gl, NULL, NULL, NULL, &p), GLBK_ERR_ARGUMENT);
}

/* Texts of results lie one behind the other: none is taken for its neighbour, nor for what comes behind the last. */
static void each_result_has_its_text(void **state)
{
    int i, k;
    (void)state;
    assert_string_equal(glbk_result_text(GLBK_OK), "ok");
    for (i = 0; i < GLBK_RESULT_COUNT; i++)
        for (k = 0; k <= i; k++)
            assert_int_equal(!strcmp(glbk_result_text((glbk_result)i), glbk_result_text((glbk_result)k)), i == k);
    assert_string_equal(glbk_result_text(GLBK_RESULT_COUNT), "unknown result");
    assert_string_equal(glbk_result_text((glbk_result)99), "unknown result");
    assert_string_not_equal(glbk_result_text((glbk_result)(GLBK_RESULT_COUNT - 1)), "unknown result");
}

/* Every embedded file is found by its name, and only whole names are. */
static void files_are_found(void **state)
{
    static const char *const wrong[] = { NULL, "", "lib/", "table", "lib/table.glsl ", "lib/table.gls",
                                         "Lib/table.glsl",
                                         "csm_access", "lib/csm_acces.glsl" };
    uint32_t k, i;
    (void)state;
    for (k = 0; k < PART_COUNT; k++) {
        const glbk_file *files = part_at(k)->files;
        assert_true(part_at(k)->file_count >= 5);
        for (i = 0; i < part_at(k)->file_count; i++) {
            assert_ptr_equal(glbk_find_file(part_at(k), files[i].name), &files[i]);
            assert_true((glbk_find_file(NULL, files[i].name) == &files[i]) == (k == 0));
        }
        assert_non_null(glbk_find_file(part_at(k), "lib/table.glsl"));        /* the base's, for all */
        assert_non_null(strstr(glbk_file_text(glbk_find_file(part_at(k), "lib/table.glsl")), "ivec3 glbk_table_at("));
        assert_null(glbk_file_text(NULL));
        for (i = 0; i < sizeof wrong / sizeof wrong[0]; i++) assert_null(glbk_find_file(part_at(k), wrong[i]));
    }
}

static size_t write_glsl(glbk_dialect dialect, int float_bits, const char *uses, const char *defines, const char *name,
                         const char *text, char *out, size_t size)
{
    glbk_shader shader = { uses, defines, name, text, { NULL } };
    return glbk_write_glsl(dialect, float_bits, &shader, out, size);
}

static void written_glsl_is_whole(void **state)
{
    static const char *const versions[GLBK_GLSL_COUNT] = { "#version 330 core\n", "#version 330 core\n",
                                                           "#version 300 es\n", "#version 430 core\n" };
    enum { ROOM = 1 << 16 };
    static char text[ROOM], cut[ROOM];
    const char *defines = "FILTER=1 FAST SCALE=-2.5", *mine = "void mine() { }\n";
    size_t size = 0, i;
    int d, bits;
    (void)state;
    for (d = 0; d < GLBK_GLSL_COUNT; d++)
        for (bits = 0; bits < 2; bits++) {
            glbk_dialect dialect = (glbk_dialect)d;
            const char *prelude, *table;
            size = write_glsl(dialect, bits, "table", defines, "copy.frag", mine, NULL, 0);
            assert_int_equal(size, 0);              /* a bare name of a program is none of a file */
            size = write_glsl(dialect, bits, "table", defines, "prog/copy.frag", mine, NULL, 0);
            assert_in_range(size, 500, ROOM);
            memset(text, '#', sizeof text);
            assert_int_equal(write_glsl(dialect, bits, "table", defines, "prog/copy.frag", mine, text, ROOM),
                             size);
            assert_int_equal(strlen(text), size - 1);
            assert_int_equal(text[size], '#');
            assert_memory_equal(text, versions[d], strlen(versions[d]));
            assert_non_null(strstr(text, bits ? "#define GLBK_FLOAT_BITS 1\n" : "#define GLBK_FLOAT_BITS 0\n"));
            assert_non_null(strstr(text, "#define FILTER 1\n#define FAST 1\n#define SCALE -2.5\n"));
            /* the prelude, what was asked for, what came as text, the program */
            prelude = strstr(text, "#line 1001 1\n");
            table = strstr(text, "glbk_table_at");
            assert_true(prelude && table && prelude < table && table < strstr(text, "void main()"));
            assert_true(strstr(text, mine) > table && strstr(text, mine) < strstr(text, "void main()"));
        }
    for (i = 0; i <= size; i += i < 40 || i + 3 > size ? 1 : 37) {      /* cut to any size, and ended there */
        memset(cut, '#', sizeof cut);
        assert_int_equal(write_glsl(GLBK_GLSL_430, 1, "table", defines, "prog/copy.frag", mine, cut, i), size);
        if (i) assert_int_equal(strlen(cut), i - 1);
        if (i) assert_memory_equal(cut, text, i - 1);
        assert_int_equal(cut[i], '#');
    }
    assert_int_equal(write_glsl(GLBK_GLSL_330, 0, "no_such", NULL, NULL, NULL, text, ROOM), 0);
    assert_int_equal(write_glsl(GLBK_GLSL_330, 0, NULL, NULL, "prog/no_such.frag", NULL, text, ROOM), 0);
    assert_int_equal(write_glsl(GLBK_GLSL_330, 0, NULL, "1BAD", NULL, NULL, text, ROOM), 0);
    assert_int_equal(write_glsl(GLBK_GLSL_330, 0, NULL, "A=1;", NULL, NULL, text, ROOM), 0);
    assert_int_equal(write_glsl(GLBK_GLSL_330, 0, NULL, "A\n#error", NULL, NULL, text, ROOM), 0);
    assert_int_equal(write_glsl(GLBK_GLSL_COUNT, 0, NULL, NULL, NULL, NULL, text, ROOM), 0);
    assert_int_equal(write_glsl(GLBK_GLSL_330, 0, NULL, NULL, NULL, NULL, NULL, ROOM), 0);
    assert_int_equal(glbk_write_glsl(GLBK_GLSL_330, 0, NULL, text, ROOM), 0);
    assert_true(write_glsl(GLBK_GLSL_330, 0, NULL, NULL, NULL, NULL, text, ROOM) > 1);    /* the prelude alone */
}

/* What a renderer with a loader of its own does: its own shader objects from the text, our slots. */
static void written_glsl_runs(void **state)
{
    GL_TEST(t, state)
    static char text[2][1 << 15];
    static const char vertex[] = "void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, "
                                 "gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }\n";
    static const uint32_t types[2] = { GLBK__VERTEX_SHADER, GLBK__FRAGMENT_SHADER };
    const glbk_functions *gl = &t->gl.gl;
    glbk_dialect dialect = t->gl.es ? GLBK_GLSL_300_ES : GLBK_GLSL_330;
    float in[4] = { 0.5f, -3, 1e20f, 7 }, out[4];
    uint32_t program = gl->CreateProgram(), shaders[2], i;
    glbk_program other;
    int32_t used = 0;
    glbk_texture_desc d = { 0 };
    glbk_texture source;
    glbk_pass pass = { 0 };
    gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_COLOR, 1, 1, 0);
    int bits = !t->gl.float_targets;

    assert_in_range(write_glsl(dialect, bits, NULL, NULL, NULL, vertex, text[0], sizeof text[0]), 1,
                    sizeof text[0]);
    assert_in_range(write_glsl(dialect, bits, NULL, NULL, "prog/copy.frag", NULL, text[1], sizeof text[1]), 1,
                    sizeof text[1]);
    for (i = 0; i < 2; i++) {
        const char *lines = text[i];
        int32_t ok = 0;
        shaders[i] = gl->CreateShader(types[i]);
        gl->ShaderSource(shaders[i], 1, &lines, NULL);
        gl->CompileShader(shaders[i]);
        gl->GetShaderiv(shaders[i], 0x8B81, &ok);
        assert_true(ok);
        gl->AttachShader(program, shaders[i]);
        gl->DeleteShader(shaders[i]);
    }
    gl->LinkProgram(program);
    assert_glbk(t, glbk__program_create(&t->gl, NULL, "copy.frag", NULL, &other));
    gl->UseProgram(other.name);
    assert_glbk(t, glbk_set_slots(&t->gl, NULL, NULL, program));          /* not the one in use, which stays so */
    gl->GetIntegerv(0x8B8D /* CURRENT_PROGRAM */, &used);
    assert_int_equal(used, other.name);
    gl->UseProgram(0);
    glbk_program_free(&t->gl, &other);
    d.format = GLBK_FORMAT_COLOR;
    d.width = d.height = 1;
    d.data = in;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &source));
    pass.target = &c.target;
    assert_glbk(t, glbk_begin(&t->gl, &pass, NULL));
    gl->UseProgram(program);
    glbk_bind_texture(&t->gl, GLBK_SLOT_glbk_source, &source);
    glbk_draw_screen(&t->gl);
    assert_glbk(t, glbk_target_read(&t->gl, &c.target, 0, 0, 0, 1, 1, out));
    assert_memory_equal(in, out, sizeof in);
    gl->UseProgram(0);
    gl->DeleteProgram(program);
    glbk_texture_free(&t->gl, &source);
    gl_canvas_free(t, &c);
}

static void transform_feedback_writes(void **state)
{
    GL_TEST(t, state)
    static const char vertex[] = "flat out uint square;\nout vec2 pair;\nvoid main()\n{\n"
                                 "    square = uint(gl_VertexID * gl_VertexID);\n"
                                 "    pair = vec2(float(gl_VertexID) + 0.5, -1.0);\n    gl_Position = vec4(0.0);\n}\n";
    static const char fragment[] = "layout(location = 0) out vec4 c;\nvoid main() { c = vec4(1.0); }\n";
    enum { COUNT = 10 };
    struct { uint32_t square; float pair[2]; } out[COUNT];
    glbk_source s = { 0 };
    glbk_program p;
    glbk_buffer b;
    glbk_pass pass = { 0 };
    uint32_t i;

    s.vertex = vertex;
    s.fragment = fragment;
    s.outputs = " square  pair ";
    assert_glbk(t, glbk_program_compile(&t->gl, &s, &p));
    assert_glbk(t, glbk_buffer_create(&t->gl, sizeof out, NULL, &b));
    {
        gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_RGBA8, 1, 1, 0);
        pass.target = &c.target;
        assert_glbk(t, glbk_begin(&t->gl, &pass, &p));
        t->gl.gl.Enable(GLBK_GL_RASTERIZER_DISCARD);
        t->gl.gl.BindBufferBase(GLBK_GL_TRANSFORM_FEEDBACK_BUFFER, 0, b.name);
        t->gl.gl.BeginTransformFeedback(GLBK_GL_POINTS);
        t->gl.gl.DrawArrays(GLBK_GL_POINTS, 0, COUNT);
        t->gl.gl.EndTransformFeedback();
        t->gl.gl.BindBufferBase(GLBK_GL_TRANSFORM_FEEDBACK_BUFFER, 0, 0);
        gl_canvas_free(t, &c);
    }
    if (t->gl.es) {
        assert_int_equal(glbk_buffer_read(&t->gl, &b, 0, sizeof out, out), GLBK_ERR_FEATURE);
    } else {
        assert_glbk(t, glbk_buffer_read(&t->gl, &b, 0, sizeof out, out));
        for (i = 0; i < COUNT; i++) {
            assert_int_equal(out[i].square, i * i);
            assert_true(out[i].pair[0] == (float)i + 0.5f && out[i].pair[1] == -1.0f);
        }
    }
    s.outputs = "square no_such_output";
    {
        glbk_program bad;
        t->expected_errors = ~0u;
        assert_int_equal(glbk_program_compile(&t->gl, &s, &bad), GLBK_ERR_LINK);
    }
    glbk_buffer_free(&t->gl, &b);
    glbk_program_free(&t->gl, &p);
}

static void compute_changes_a_buffer(void **state)
{
    GL_TEST(t, state)
    static const char text[] = "layout(local_size_x = 64) in;\n"
                               "layout(std430, binding = 3) buffer numbers { uint number[]; };\n"
                               "void main()\n{\n    uint i = gl_GlobalInvocationID.x;\n"
                               "    if (i < uint(COUNT)) number[i] = number[i] * 3u + i;\n}\n";
    enum { COUNT = 1000 };
    static uint32_t in[COUNT], out[COUNT];
    glbk_source s = { 0 };
    glbk_program p;
    glbk_buffer b;
    uint32_t i;

    s.compute = text;
    s.defines = "COUNT=1000";
    if (!t->gl.compute) {
        glbk_program none = { 1, 0, { NULL }, { { 0, 0 } } };
        assert_int_equal(glbk_program_compile(&t->gl, &s, &p), GLBK_ERR_FEATURE);
        assert_int_equal(glbk_dispatch(&t->gl, &none, 1, 1, 1), GLBK_ERR_FEATURE);
        return;
    }
    for (i = 0; i < COUNT; i++) in[i] = hash(i);
    assert_glbk(t, glbk_program_compile(&t->gl, &s, &p));
    assert_glbk(t, glbk_buffer_create(&t->gl, sizeof in, in, &b));
    glbk_bind_storage(&t->gl, 3, &b);
    assert_glbk(t, glbk_dispatch(&t->gl, &p, (COUNT + 63) / 64, 1, 1));
    assert_glbk(t, glbk_buffer_read(&t->gl, &b, 0, sizeof out, out));
    for (i = 0; i < COUNT; i++) assert_int_equal(out[i], in[i] * 3 + i);
    glbk_buffer_free(&t->gl, &b);
    glbk_program_free(&t->gl, &p);
}

/* One shader writes how many groups the next one takes; both an image of two layers. */
static void compute_writes_images(void **state)
{
    GL_TEST(t, state)
    static const char fill[] = "layout(local_size_x = 8, local_size_y = 8) in;\n"
                               "layout(rgba32f, binding = 2) uniform image2DArray picture;\n"
                               "layout(std430, binding = 1) buffer groups_block { uint groups[]; };\n"
                               "void main()\n{\n    ivec3 at = ivec3(gl_GlobalInvocationID);\n"
                               "    if (at == ivec3(0)) { groups[1] = 2u; groups[2] = 1u; groups[3] = 1u; }\n"
                               "    imageStore(picture, at, vec4(at, 0.5));\n}\n";
    static const char change[] = "layout(local_size_x = 8, local_size_y = 8) in;\n"
                                 "layout(rgba32f, binding = 2) uniform image2DArray picture;\n"
                                 "void main()\n{\n    ivec3 at = ivec3(gl_GlobalInvocationID.xy, 1);\n"
                                 "    imageStore(picture, at, imageLoad(picture, at) * 2.0);\n}\n";
    enum { SIDE = 16 };
    static float out[4 * SIDE * SIDE];
    glbk_texture_desc d = { 0 };
    glbk_target_desc targets = { 0 };
    glbk_texture picture;
    glbk_target target;
    glbk_buffer groups;
    glbk_program p[2];
    glbk_source s = { 0 };
    int x, y;

    if (!t->gl.compute) {
        glbk_program none = { 1, 0, { NULL }, { { 0, 0 } } };
        assert_int_equal(glbk_dispatch(&t->gl, &none, 1, 1, 2), GLBK_ERR_FEATURE);
        return;
    }
    s.compute = fill;
    assert_glbk(t, glbk_program_compile(&t->gl, &s, &p[0]));
    s.compute = change;
    assert_glbk(t, glbk_program_compile(&t->gl, &s, &p[1]));
    assert_glbk(t, glbk_buffer_create(&t->gl, 16, NULL, &groups));
    d.format = GLBK_FORMAT_RGBA32F;
    d.width = d.height = SIDE;
    d.layers = 2;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &picture));
    targets.color[0] = &picture;
    targets.layer[0] = 1;
    assert_glbk(t, glbk_target_create(&t->gl, &targets, &target));
    glbk_bind_image(&t->gl, 2, &picture);
    glbk_bind_storage(&t->gl, 1, &groups);
    assert_glbk(t, glbk_dispatch(&t->gl, &p[0], SIDE / 8, SIDE / 8, 2));
    glbk_program_use(&t->gl, &p[1]);
    t->gl.gl.BindBuffer(GLBK_GL_DISPATCH_INDIRECT_BUFFER, groups.name);
    t->gl.gl.DispatchComputeIndirect(4);
    t->gl.gl.Barrier(GLBK_GL_ALL_BARRIER_BITS);
    assert_glbk(t, glbk_target_read(&t->gl, &target, 0, 0, 0, SIDE, SIDE, out));
    for (y = 0; y < SIDE; y++)
        for (x = 0; x < SIDE; x++) {
            const float *texel = out + 4 * (y * SIDE + x);
            float twice = y < 8 ? 2.0f : 1.0f;      /* two groups beside each other, not below */
            assert_true(texel[0] == twice * (float)x && texel[1] == twice * (float)y);
            assert_true(texel[2] == twice && texel[3] == 0.5f * twice);
        }
    assert_int_equal(glbk_dispatch(&t->gl, NULL, 1, 1, 1), GLBK_ERR_ARGUMENT);
    glbk_target_free(&t->gl, &target);
    glbk_texture_free(&t->gl, &picture);
    glbk_buffer_free(&t->gl, &groups);
    glbk_program_free(&t->gl, &p[0]);
    glbk_program_free(&t->gl, &p[1]);
}

/* ---- textures, tables, buffers, targets ---- */

static void a_draw_copies_floats_bit_by_bit(void **state)
{
    GL_TEST(t, state)
    enum { W = 37, H = 5 };
    static float in[4 * W * H], out[4 * W * H];
    glbk_texture_desc d = { 0 };
    glbk_texture source;
    glbk_program copy;
    glbk_pass pass = { 0 };
    gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_COLOR, W, H, 0);
    int i;

    for (i = 0; i < 4 * W * H; i++) in[i] = (float)(i * i) * 1.25e-3f - 17.0f;
    d.format = GLBK_FORMAT_COLOR;
    d.width = W;
    d.height = H;
    d.data = in;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &source));
    assert_int_equal(source.format, t->gl.float_targets ? GLBK_FORMAT_RGBA32F : GLBK_FORMAT_RGBA32UI);
    assert_glbk(t, glbk__program_create(&t->gl, NULL, "copy.frag", NULL, &copy));
    pass.target = &c.target;
    assert_glbk(t, glbk_begin(&t->gl, &pass, &copy));
    glbk_bind_texture(&t->gl, GLBK_SLOT_glbk_source, &source);
    glbk_draw_screen(&t->gl);
    assert_glbk(t, glbk_target_read(&t->gl, &c.target, 0, 0, 0, W, H, out));
    assert_memory_equal(in, out, sizeof in);
    assert_glbk(t, glbk_target_read(&t->gl, &c.target, 0, 3, 2, 1, 1, out));
    assert_memory_equal(in + 4 * (2 * W + 3), out, 4 * sizeof *in);
    gl_canvas_free(t, &c);
    glbk_texture_free(&t->gl, &source);
    glbk_program_free(&t->gl, &copy);
}

/* sampler2DShadow: 1 where the reference is at most the depth, equal included. */
static void depths_are_compared(void **state)
{
    GL_TEST(t, state)
    static const float depths[2] = { 0.25f, 0.75f };
    static const float expected[4] = { 0, 1, 1, 1 };        /* references 0.5 and, above, 0.25 */
    gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_COLOR, 2, 2, 0);
    glbk_texture_desc d = { GLBK_FORMAT_DEPTH32F, 2, 1, 0, 0, GLBK_SAMPLING_COMPARE, 0, depths };
    glbk_source s = { 0 };
    glbk_texture texture;
    glbk_program program;
    glbk_pass pass = { 0 };
    float rgba[16];
    int i;
    s.fragment = "uniform highp sampler2DShadow depth;\nlayout(location = 0) out glbk_color r;\n"
                 "void main()\n{\n    float reference = gl_FragCoord.y < 1.0 ? 0.5 : 0.25;\n"
                 "    r = glbk_pack(vec4(texture(depth, vec3(gl_FragCoord.x / 2.0, 0.5, reference))));\n}\n";
    pass.target = &c.target;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &texture));
    assert_glbk(t, glbk_program_compile(&t->gl, &s, &program));
    assert_glbk(t, glbk_begin(&t->gl, &pass, &program));
    t->gl.gl.Uniform1i(t->gl.gl.GetUniformLocation(program.name, "depth"), 3);
    glbk_bind_texture(&t->gl, 3, &texture);
    glbk_draw_screen(&t->gl);
    assert_glbk(t, glbk_target_read(&t->gl, &c.target, 0, 0, 0, 2, 2, rgba));
    for (i = 0; i < 4; i++) assert_float_equal(rgba[4 * i], expected[i], 0);
    glbk_program_free(&t->gl, &program);
    glbk_texture_free(&t->gl, &texture);
    gl_canvas_free(t, &c);
}

/* Slots move with first_unit and first_block of the context. */
static void slots_can_be_moved(void **state)
{
    GL_TEST(t, state)
    glbk_context other;
    glbk_desc desc = { 0 };
    glbk_texture_desc d = { 0 };
    glbk_texture source;
    glbk_program copy;
    glbk_pass pass = { 0 };
    gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_COLOR, 1, 1, 0);
    float in[4] = { 1.5f, -2, 3, 4 }, out[4];
    int32_t unit = -1;

    desc.get_proc_fn = gl_get_proc();
    desc.user = t->context;
    desc.first_unit = 7;
    desc.first_block = 2;
    assert_int_equal(glbk_init(&other, &desc), GLBK_OK);
    d.format = GLBK_FORMAT_COLOR;
    d.width = d.height = 1;
    d.data = in;
    assert_int_equal(glbk_texture_create(&other, &d, &source), GLBK_OK);
    assert_int_equal(glbk__program_create(&other, NULL, "copy.frag", NULL, &copy), GLBK_OK);
    pass.target = &c.target;
    assert_int_equal(glbk_begin(&other, &pass, &copy), GLBK_OK);
    glbk_bind_texture(&other, GLBK_SLOT_glbk_source, &source);
    other.gl.GetIntegerv(0x84E0, &unit);
    assert_int_equal(unit, GLBK_GL_TEXTURE0 + 7);
    glbk_draw_screen(&other);
    assert_int_equal(glbk_target_read(&other, &c.target, 0, 0, 0, 1, 1, out), GLBK_OK);
    assert_memory_equal(in, out, sizeof in);
    glbk_texture_free(&other, &source);
    glbk_program_free(&other, &copy);
    glbk_free(&other);
    gl_canvas_free(t, &c);
    desc.first_unit = 900;
    assert_int_equal(glbk_init(&other, &desc), GLBK_ERR_LIMIT);
    desc.first_unit = 0;
    desc.first_block = 900;
    assert_int_equal(glbk_init(&other, &desc), GLBK_ERR_LIMIT);
}

static const char table_reader[] =
    "uniform highp usampler2DArray words;\n"
    "layout(location = 0) out uvec4 result;\n"
    "uint hash(uint x)\n"
    "{\n"
    "    x = (x ^ x >> 16) * 0x7feb352du;\n"
    "    x = (x ^ x >> 15) * 0x846ca68bu;\n"
    "    return x ^ x >> 16;\n"
    "}\n"
    "void main()\n"
    "{\n"
    "    uint i = hash(uint(gl_FragCoord.x) + 64u * uint(gl_FragCoord.y)) % uint(COUNT);\n"
    "    result = uvec4(i, texelFetch(words, glbk_table_at(i), 0).r, 0u, 1u);\n"
    "}\n";

/* Reads 4,096 random texels of a table on the GPU; the C side knows what they must be. */
static void check_table(gl_test *t, const glbk_texture *table, const uint32_t *words, const char *defines)
{
    enum { SIDE = 64 };
    static uint32_t out[4 * SIDE * SIDE];
    gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_RGBA32UI, SIDE, SIDE, 0);
    glbk_source s = { 0 };
    glbk_program p;
    glbk_pass pass = { 0 };
    uint32_t i;

    s.fragment = table_reader;
    s.uses = "table";
    s.defines = defines;
    assert_glbk(t, glbk_program_compile(&t->gl, &s, &p));
    pass.target = &c.target;
    assert_glbk(t, glbk_begin(&t->gl, &pass, &p));
    glbk_bind_texture(&t->gl, 0, table);
    glbk_draw_screen(&t->gl);
    assert_glbk(t, glbk_target_read(&t->gl, &c.target, 0, 0, 0, SIDE, SIDE, out));
    for (i = 0; i < SIDE * SIDE; i++) assert_int_equal(out[4 * i + 1], words[out[4 * i]]);
    gl_canvas_free(t, &c);
    glbk_program_free(&t->gl, &p);
}

static void tables_hold_and_change(void **state)
{
    GL_TEST(t, state)
    enum { COUNT = 1500000 };       /* more than one layer */
    uint32_t *words = (uint32_t *)malloc(COUNT * sizeof *words), i;
    glbk_texture table;

    assert_non_null(words);
    for (i = 0; i < COUNT; i++) words[i] = hash(i + 77);
    assert_glbk(t, glbk__table_create(&t->gl, GLBK_FORMAT_R32UI, words, COUNT, &table));
    assert_int_equal(table.layers, 2);
    check_table(t, &table, words, "COUNT=1500000");
    for (i = 0; i < 60; i++) {      /* runs of every kind: inside a row, over rows, over the layers' border */
        size_t first = hash(3 * i) % COUNT, count = hash(3 * i + 1) % (i % 3 ? 3000u : 400000u), k;
        if (i == 0) first = (1 << 20) - 700, count = 5000;
        if (count > COUNT - first) count = COUNT - first;
        for (k = 0; k < count; k++) words[first + k] = hash((uint32_t)k ^ i << 24);
        assert_glbk(t, glbk__table_update(&t->gl, &table, first, count, words + first));
    }
    check_table(t, &table, words, "COUNT=1500000");
    assert_int_equal(glbk__table_update(&t->gl, &table, 1 << 21, 1, words), GLBK_ERR_ARGUMENT);
    glbk_texture_free(&t->gl, &table);
    assert_glbk(t, glbk__table_create(&t->gl, GLBK_FORMAT_R32UI, words, 5, &table));
    check_table(t, &table, words, "COUNT=5");
    glbk_texture_free(&t->gl, &table);
    assert_int_equal(glbk__table_create(&t->gl, GLBK_FORMAT_R32UI, NULL, (size_t)t->gl.max_layers << 20 | 1, &table),
                     GLBK_ERR_LIMIT);
    assert_int_equal(glbk__table_create(&t->gl, GLBK_FORMAT_R32UI, NULL, 0, &table), GLBK_ERR_ARGUMENT);
    free(words);
}

/* Every format can be made, and rendered to where the context says so. */
static void every_format_is_made_and_drawn_to(void **state)
{
    GL_TEST(t, state)
    int f;
    for (f = GLBK_FORMAT_COLOR; f < GLBK_FORMAT_COUNT; f++) {
        glbk_texture_desc d = { 0 };
        glbk_target_desc targets = { 0 };
        glbk_texture texture;
        glbk_target target;
        glbk_result result;
        uint32_t level;
        d.format = (glbk_format)f;
        d.width = 8;
        d.height = 6;
        d.levels = 3;
        d.layers = f % 2 ? 3 : 0;
        assert_glbk(t, glbk_texture_create(&t->gl, &d, &texture));
        for (level = 0; level < 3; level++) {
            if (glbk__is_depth(texture.format)) targets.depth = &texture;
            else targets.color[0] = &texture;
            targets.layer[0] = targets.depth_layer = d.layers ? 2 : 0;
            targets.level = level;
            result = glbk_target_create(&t->gl, &targets, &target);
            if (glbk__is_float(texture.format) && !t->gl.float_targets)
                assert_int_equal(result, GLBK_ERR_FLOAT_TARGET);
            else
                assert_glbk(t, result);
            glbk_target_free(&t->gl, &target);
        }
        glbk_texture_free(&t->gl, &texture);
    }
}

static void mipmaps_and_filters_are_those_asked_for(void **state)
{
    GL_TEST(t, state)
    static const char text[] = "uniform highp sampler2D image;\nlayout(location = 0) out vec4 c;\n"
                               "void main() { c = textureLod(image, vec2(0.5), float(LEVEL)); }\n";
    unsigned char in[4 * 4 * 4], out[16];
    glbk_texture_desc d = { 0 };
    glbk_texture image;
    glbk_source s = { 0 };
    glbk_program p;
    glbk_pass pass = { 0 };
    gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_RGBA8, 1, 1, 0);
    float rgba[4];
    int i;

    for (i = 0; i < 64; i++) in[i] = (unsigned char)(i < 32 ? 40 : 200);
    d.format = GLBK_FORMAT_RGBA8;
    d.width = d.height = 4;
    d.sampling = GLBK_SAMPLING_MIPMAPS;
    d.data = in;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &image));
    assert_int_equal(image.levels, 3);
    s.fragment = text;
    s.defines = "LEVEL=2";
    assert_glbk(t, glbk_program_compile(&t->gl, &s, &p));
    pass.target = &c.target;
    assert_glbk(t, glbk_begin(&t->gl, &pass, &p));
    glbk_bind_texture(&t->gl, 0, &image);
    glbk_draw_screen(&t->gl);
    t->gl.gl.BindFramebuffer(GLBK_GL_READ_FRAMEBUFFER, c.target.name);
    t->gl.gl.ReadPixels(0, 0, 1, 1, 0x1908, GLBK_GL_UNSIGNED_BYTE, out);
    assert_int_equal(out[0], 120);
    t->gl.gl.BindFramebuffer(GLBK_GL_READ_FRAMEBUFFER, 0);
    assert_glbk(t, glbk_target_read(&t->gl, &c.target, 0, 0, 0, 1, 1, rgba));
    assert_true(rgba[0] > 119.9f / 255 && rgba[0] < 120.1f / 255);
    glbk_texture_free(&t->gl, &image);
    d.format = GLBK_FORMAT_R32F;
    d.sampling = GLBK_SAMPLING_LINEAR;
    d.data = NULL;
    assert_int_equal(glbk_texture_create(&t->gl, &d, &image), t->gl.float_linear ? GLBK_OK : GLBK_ERR_DESC);
    glbk_texture_free(&t->gl, &image);
    glbk_program_free(&t->gl, &p);
    gl_canvas_free(t, &c);
}

static void a_uniform_block_reaches_the_shader(void **state)
{
    GL_TEST(t, state)
    static const char text[] = "layout(std140) uniform mine { vec4 a; uvec4 b; mat4 m; };\n"
                               "layout(location = 0) out glbk_color c;\n"
                               "void main() { c = glbk_pack(m * a + vec4(b)); }\n";
    struct { float a[4]; uint32_t b[4]; float m[16]; } block = { { 1, 2, 3, 4 }, { 10, 20, 30, 40 }, { 0 } };
    float out[4];
    glbk_source s = { 0 };
    glbk_program p;
    glbk_pass pass = { 0 };
    glbk_buffer b;
    gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_COLOR, 1, 1, 0);
    int i;

    for (i = 0; i < 4; i++) block.m[5 * i] = 2;
    block.m[12] = 100;              /* column-major: the translation */
    s.fragment = text;
    assert_glbk(t, glbk_program_compile(&t->gl, &s, &p));
    assert_glbk(t, glbk_buffer_create(&t->gl, sizeof block, NULL, &b));
    assert_glbk(t, glbk_buffer_update(&t->gl, &b, 0, sizeof block, &block));
    assert_int_equal(glbk_buffer_update(&t->gl, &b, 8, sizeof block, &block), GLBK_ERR_ARGUMENT);
    pass.target = &c.target;
    assert_glbk(t, glbk_begin(&t->gl, &pass, &p));
    glbk_bind_block(&t->gl, 0, &b);
    glbk_draw_screen(&t->gl);
    assert_glbk(t, glbk_target_read(&t->gl, &c.target, 0, 0, 0, 1, 1, out));
    assert_true(out[0] == 2 + 400 + 10 && out[1] == 24 && out[2] == 36 && out[3] == 48);
    glbk_buffer_free(&t->gl, &b);
    glbk_program_free(&t->gl, &p);
    gl_canvas_free(t, &c);
}

/* ---- passes ---- */

static const char flat_vertex[] =
    "void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, Z, 1.0); }\n";
static const char flat_fragment[] = "layout(location = 0) out vec4 c;\nvoid main() { c = vec4(V, V, V, A); }\n";

static void draw_flat(gl_test *t, const glbk_pass *pass, const char *defines)
{
    glbk_source s = { 0 };
    glbk_program p;
    s.vertex = flat_vertex;
    s.fragment = flat_fragment;
    s.defines = defines;
    assert_glbk(t, glbk_program_compile(&t->gl, &s, &p));
    assert_glbk(t, glbk_begin(&t->gl, pass, &p));
    glbk_draw_screen(&t->gl);
    t->gl.gl.UseProgram(0);
    glbk_program_free(&t->gl, &p);
}

/* Red of the first pixel of an RGBA8 canvas, 0..255. */
static int red(gl_test *t, const gl_canvas *c)
{
    unsigned char out[4] = { 0, 0, 0, 0 };
    t->gl.gl.BindFramebuffer(GLBK_GL_READ_FRAMEBUFFER, c->target.name);
    t->gl.gl.ReadPixels(0, 0, 1, 1, 0x1908, GLBK_GL_UNSIGNED_BYTE, out);
    t->gl.gl.BindFramebuffer(GLBK_GL_READ_FRAMEBUFFER, 0);
    return out[0];
}

static void passes_blend_by_their_mode(void **state)
{
    GL_TEST(t, state)
    static const int wanted[GLBK_BLEND_COUNT] = { 102, 153, 51, 102, 76 };
    int mode;
    for (mode = 0; mode < GLBK_BLEND_COUNT; mode++) {
        gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_RGBA8, 2, 2, 0);
        glbk_pass pass = { 0 };
        int got;
        pass.target = &c.target;
        draw_flat(t, &pass, "Z=0.0 V=0.2 A=1.0");
        pass.blend = (glbk_blend)mode;
        draw_flat(t, &pass, "Z=0.0 V=0.4 A=0.5");
        got = red(t, &c);
        assert_in_range(got, wanted[mode] - 1, wanted[mode] + 1);
        gl_canvas_free(t, &c);
    }
}

static void passes_test_depth(void **state)
{
    GL_TEST(t, state)
    /* Drawn at window depth 0.5 first; then at 0.25, 0.5 and 0.75: which are seen. */
    static const int seen[GLBK_DEPTH_COUNT][3] = { { 1, 1, 1 }, { 1, 0, 0 }, { 1, 1, 0 }, { 0, 1, 0 }, { 0, 0, 1 } };
    static const char *const draws[3] = { "Z=-0.5 V=1.0 A=1.0", "Z=0.0 V=1.0 A=1.0", "Z=0.5 V=1.0 A=1.0" };
    static const float black[4] = { 0, 0, 0, 0 };
    int mode, i;
    for (mode = 0; mode < GLBK_DEPTH_COUNT; mode++)
        for (i = 0; i < 3; i++) {
            gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_RGBA8, 2, 2, 1);
            glbk_pass pass = { 0 };
            pass.target = &c.target;
            pass.depth = GLBK_DEPTH_LESS;
            assert_glbk(t, glbk_begin(&t->gl, &pass, NULL));
            glbk_clear(&t->gl, &c.target, 0, black);
            glbk_clear_depth(&t->gl, 1);
            pass.no_color = 1;
            draw_flat(t, &pass, "Z=0.0 V=1.0 A=1.0");
            assert_int_equal(red(t, &c), 0);
            pass.no_color = 0;
            pass.depth = (glbk_depth)mode;
            draw_flat(t, &pass, draws[i]);
            assert_int_equal(red(t, &c), seen[mode][i] ? 255 : 0);
            gl_canvas_free(t, &c);
        }
}

static void passes_cull_offset_and_view(void **state)
{
    GL_TEST(t, state)
    static const float grey[4] = { 0.5f, 0.5f, 0.5f, 0.5f };
    gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_RGBA8, 8, 8, 1);
    glbk_pass pass = { 0 };
    pass.target = &c.target;
    assert_glbk(t, glbk_begin(&t->gl, &pass, NULL));
    glbk_clear(&t->gl, &c.target, 0, grey);
    pass.cull = GLBK_CULL_FRONT;            /* the triangle is counter-clockwise */
    draw_flat(t, &pass, "Z=0.0 V=1.0 A=1.0");
    assert_in_range(red(t, &c), 127, 128);
    pass.cull = GLBK_CULL_OFF;
    pass.viewport[0] = pass.viewport[1] = 4;
    pass.viewport[2] = pass.viewport[3] = 4;
    draw_flat(t, &pass, "Z=0.0 V=1.0 A=1.0");
    assert_in_range(red(t, &c), 127, 128);  /* the first pixel lies outside the viewport */
    memset(pass.viewport, 0, sizeof pass.viewport);
    pass.cull = GLBK_CULL_BACK;
    draw_flat(t, &pass, "Z=0.0 V=1.0 A=1.0");
    assert_int_equal(red(t, &c), 255);

    pass.depth = GLBK_DEPTH_LESS;
    assert_glbk(t, glbk_begin(&t->gl, &pass, NULL));
    glbk_clear_depth(&t->gl, 0.5f);
    pass.offset[1] = 16;                    /* pushes behind what is there */
    draw_flat(t, &pass, "Z=0.0 V=0.0 A=1.0");
    assert_int_equal(red(t, &c), 255);
    pass.offset[1] = -16;
    draw_flat(t, &pass, "Z=0.0 V=0.0 A=1.0");
    assert_int_equal(red(t, &c), 0);
    pass.target = NULL;
    assert_int_equal(glbk_begin(&t->gl, &pass, NULL), GLBK_ERR_DESC);
    assert_string_equal(t->log, "glbk_begin: pass.viewport[2] is 0, and there is no pass.target whose size it could "
                                "be");
    gl_canvas_free(t, &c);
}

static void clears_integers_and_bits(void **state)
{
    GL_TEST(t, state)
    static const glbk_format formats[] = { GLBK_FORMAT_COLOR, GLBK_FORMAT_RGBA8UI, GLBK_FORMAT_R32UI };
    static const float value[4] = { 7, 8.4f, 9, 10 };
    uint32_t words[4];
    float floats[4];
    size_t i;
    for (i = 0; i < 3; i++) {
        gl_canvas c = gl_canvas_make(t, formats[i], 3, 3, 0);
        glbk_pass pass = { 0 };
        pass.target = &c.target;
        assert_glbk(t, glbk_begin(&t->gl, &pass, NULL));
        glbk_clear(&t->gl, &c.target, 0, value);
        if (i == 0) {
            assert_glbk(t, glbk_target_read(&t->gl, &c.target, 0, 1, 1, 1, 1, floats));
            assert_memory_equal(floats, value, sizeof value);
        } else {
            assert_glbk(t, glbk_target_read(&t->gl, &c.target, 0, 1, 1, 1, 1, words));
            assert_int_equal(words[0], 7);
            if (i == 1) assert_int_equal(words[1], 8);
        }
        if (i == 2) {                       /* what no integer holds becomes the nearest, and no number 0 */
            static const float beyond[] = { 1e30f, 4294967296.0f, -3, (float)NAN };
            static const uint32_t expected[] = { 0xffffffffu, 0xffffffffu, 0, 0 };
            size_t k;
            for (k = 0; k < 4; k++) {
                const float all[4] = { beyond[k], beyond[k], beyond[k], beyond[k] };
                glbk_clear(&t->gl, &c.target, 0, all);
                assert_glbk(t, glbk_target_read(&t->gl, &c.target, 0, 1, 1, 1, 1, words));
                assert_true(words[0] == expected[k]);
            }
        }
        gl_canvas_free(t, &c);
    }
}

/* The call fails so, and the log holds these words. */
#define REFUSED(result, call, words)                    \
    do {                                                \
        t->log[0] = 0;                                  \
        assert_int_equal(call, result);                 \
        if (!strstr(t->log, words)) fail_msg("%s", t->log);     \
    } while (0)

static void bad_arguments_are_refused_with_a_line(void **state)
{
    GL_TEST(t, state)
    glbk_context *gl = &t->gl;
    glbk_texture_desc d = { 0 };
    glbk_target_desc targets = { 0 };
    glbk_texture a, b;
    glbk_target target;
    glbk_buffer buffer;
    char room[64] = { 0 };

    assert_int_equal(glbk_init(NULL, NULL), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_texture_create(gl, NULL, &a), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_texture_create(gl, &d, NULL), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_texture_create(NULL, &d, &a), GLBK_ERR_ARGUMENT);
    REFUSED(GLBK_ERR_DESC, glbk_texture_create(gl, &d, &a),
            "glbk_texture_create: desc.format is 0; it must be a glbk_format, not NONE");
    d.format = GLBK_FORMAT_R8;
    REFUSED(GLBK_ERR_DESC, glbk_texture_create(gl, &d, &a), "glbk_texture_create: desc.width is 0; it must be 1..");
    d.width = gl->max_side + 1;
    d.height = 1;
    REFUSED(GLBK_ERR_LIMIT, glbk_texture_create(gl, &d, &a), "glbk_texture_create: desc.width is");
    d.width = 4;
    d.layers = gl->max_layers + 1;
    REFUSED(GLBK_ERR_LIMIT, glbk_texture_create(gl, &d, &a), "glbk_texture_create: desc.layers is");
    d.layers = 0;
    d.levels = 4;
    REFUSED(GLBK_ERR_DESC, glbk_texture_create(gl, &d, &a), "glbk_texture_create: desc.levels is 4; it must be 0..3");
    d.levels = 0;
    d.sampling = GLBK_SAMPLING_COUNT;
    REFUSED(GLBK_ERR_DESC, glbk_texture_create(gl, &d, &a),
            "glbk_texture_create: desc.sampling is 5; it must be a glbk_sampling");
    d.sampling = GLBK_SAMPLING_COMPARE;
    REFUSED(GLBK_ERR_DESC, glbk_texture_create(gl, &d, &a),
            "glbk_texture_create: desc.sampling is COMPARE, which only depth formats have");
    d.sampling = GLBK_SAMPLING_LINEAR;
    d.format = GLBK_FORMAT_R32UI;
    REFUSED(GLBK_ERR_DESC, glbk_texture_create(gl, &d, &a),
            "desc.sampling is LINEAR or MIPMAPS, which formats of integers");
    d.sampling = GLBK_SAMPLING_DEFAULT;
    assert_glbk(t, glbk_texture_create(gl, &d, &a));
    REFUSED(GLBK_ERR_ARGUMENT, glbk_texture_update(gl, &a, &(glbk_box){ 0, 3, 0, 0, 2, 1, 1 }, room),
            "glbk_texture_update: box.x + box.width is 5; it must be 0..4");
    REFUSED(GLBK_ERR_ARGUMENT, glbk_texture_update(gl, &a, &(glbk_box){ 0, 0, 1, 0, 4, 1, 1 }, room),
            "glbk_texture_update: box.y + box.height is 2; it must be 0..1");
    REFUSED(GLBK_ERR_ARGUMENT, glbk_texture_update(gl, &a, &(glbk_box){ 1, 0, 0, 0, 1, 1, 1 }, room),
            "glbk_texture_update: box.level is 1; it must be 0");
    REFUSED(GLBK_ERR_ARGUMENT, glbk_texture_update(gl, &a, &(glbk_box){ 0, 0, 0, 1, 1, 1, 1 }, room),
            "glbk_texture_update: box.layer + box.layers is 2; it must be 0..1");
    REFUSED(GLBK_ERR_ARGUMENT, glbk_texture_update(gl, &a, &(glbk_box){ 0, 0, 0, 0, 1, 1, 1 }, NULL),
            "glbk_texture_update: data is NULL");

    REFUSED(GLBK_ERR_DESC, glbk_target_create(gl, &targets, &target), "glbk_target_create: desc has no attachment");
    targets.color[1] = &a;
    REFUSED(GLBK_ERR_DESC, glbk_target_create(gl, &targets, &target),
            "glbk_target_create: desc.color[1] stands behind a gap");
    targets.color[0] = &a;
    d.width = 5;
    assert_glbk(t, glbk_texture_create(gl, &d, &b));
    targets.color[1] = &b;
    REFUSED(GLBK_ERR_MISMATCH, glbk_target_create(gl, &targets, &target),
            "glbk_target_create: desc.color[1] is of another size than those before it");
    targets.color[1] = NULL;
    targets.depth = &a;
    REFUSED(GLBK_ERR_MISMATCH, glbk_target_create(gl, &targets, &target),
            "glbk_target_create: desc.depth is no depth texture");
    assert_int_equal(target.name, 0);
    targets.depth = NULL;
    targets.layer[0] = 1;
    REFUSED(GLBK_ERR_DESC, glbk_target_create(gl, &targets, &target),
            "glbk_target_create: desc.layer is 1; it must be 0");
    targets.layer[0] = 0;
    assert_glbk(t, glbk_target_create(gl, &targets, &target));
    REFUSED(GLBK_ERR_ARGUMENT, glbk_target_read(gl, &target, 1, 0, 0, 1, 1, room),
            "glbk_target_read: attachment is 1; it must be 0");
    REFUSED(GLBK_ERR_ARGUMENT, glbk_target_read(gl, &target, 0, 4, 0, 1, 1, room),
            "glbk_target_read: x + width is 5; it must be 0..4");
    REFUSED(GLBK_ERR_ARGUMENT, glbk_buffer_create(gl, 0, NULL, &buffer),
            "glbk_buffer_create: bytes is 0; it must be 1..");
    assert_int_equal(glbk_buffer_create(gl, SIZE_MAX, NULL, &buffer), GLBK_ERR_LIMIT);
    assert_int_equal(glbk_indices_create(gl, SIZE_MAX, NULL, &buffer), GLBK_ERR_LIMIT);
    assert_int_equal(glbk_begin(gl, NULL, NULL), GLBK_ERR_ARGUMENT);
    glbk_target_free(gl, &target);
    glbk_texture_free(gl, &a);
    glbk_texture_free(gl, &b);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        cmocka_unit_test(each_result_has_its_text), cmocka_unit_test(files_are_found),
        cmocka_unit_test(written_glsl_is_whole), gl_unit_test(depths_are_compared),
        gl_unit_test(written_glsl_runs), gl_unit_test(blocks_are_those_named), gl_unit_test(every_program_links),
        gl_unit_test(errors_name_file_and_line), gl_unit_test(transform_feedback_writes),
        gl_unit_test(compute_changes_a_buffer), gl_unit_test(compute_writes_images),
        gl_unit_test(a_draw_copies_floats_bit_by_bit), gl_unit_test(slots_can_be_moved),
        gl_unit_test(tables_hold_and_change), gl_unit_test(every_format_is_made_and_drawn_to),
        gl_unit_test(mipmaps_and_filters_are_those_asked_for), gl_unit_test(a_uniform_block_reaches_the_shader),
        gl_unit_test(passes_blend_by_their_mode), gl_unit_test(passes_test_depth),
        gl_unit_test(passes_cull_offset_and_view), gl_unit_test(clears_integers_and_bits),
        gl_unit_test(bad_arguments_are_refused_with_a_line)
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_ALL);
}
