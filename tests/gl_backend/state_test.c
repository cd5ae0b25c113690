/* GL's state before and after every public call of gl_backend.h, from GL's defaults and from a hostile state; and what
   is drawn from the hostile state is the same. gl_state.h has the list; tests of techniques use it for their calls. */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#define GL_BACKEND_IMPLEMENTATION
#define GL_PROGRAMS_IMPLEMENTATION
#include "gl_backend/gl_programs.h"

#include "gl_test.h"
#include "gl_state.h"

/* ---- every public call ---- */

enum { SIDE = 16 };
typedef struct picture { float pixels[4][4 * SIDE * SIDE]; uint32_t words[1500]; } picture;

static void one_pass(gl_test *t, const glbk_pass *pass, glbk_program *program, const glbk_texture *source,
                     const glbk_buffer *block)
{
    static const float grey[4] = { 0.25f, 0.5f, 0.75f, 1 };
    assert_glbk(t, glbk_begin(&t->gl, pass, program));
    glbk_clear(&t->gl, pass->target, 0, grey);
    if (pass->depth) glbk_clear_depth(&t->gl, 1);
    if (!program) return;
    glbk_bind_texture(&t->gl, GLBK_SLOT_glbk_source, source);
    glbk_bind_block(&t->gl, 2, block);
    if (t->gl.compute) {
        glbk_bind_storage(&t->gl, 2, block);
        glbk_bind_image(&t->gl, 3, source);
    }
    glbk_draw_screen(&t->gl);
}

/* All calls; out is what was drawn and read. */
static void every_call(gl_test *t, picture *out)
{
    static float in[4 * SIDE * SIDE];
    static uint32_t words[1500];
    static gl_snapshot before;
    glbk_context other;
    glbk_desc desc = { 0 };
    glbk_texture_desc d = { 0 };
    glbk_texture source, color, depth, table;
    glbk_target_desc targets = { 0 };
    glbk_target target;
    glbk_buffer buffer, indices;
    glbk_program copy, mine, sample;
    glbk_source text = { 0 };
    glbk_pass pass = { 0 };
    gl_canvas bytes;
    int i, depths, blends, culls;

    for (i = 0; i < 4 * SIDE * SIDE; i++) in[i] = (float)i * 0.37f - 40;
    for (i = 0; i < 1500; i++) words[i] = (uint32_t)i * 2654435761u;
    gl_state_read(&t->gl, &before);
    assert_true(before.count >= 60);
    desc.get_proc_fn = gl_get_proc();
    desc.user = t->context;
    GL_SAME(t, assert_int_equal(glbk_init(&other, &desc), GLBK_OK));
    GL_SAME(t, glbk_free(&other));

    d.format = GLBK_FORMAT_COLOR;
    d.width = d.height = SIDE;
    GL_SAME(t, assert_glbk(t, glbk_texture_create(&t->gl, &d, &color)));
    d.data = in;
    GL_SAME(t, assert_glbk(t, glbk_texture_create(&t->gl, &d, &source)));
    GL_SAME(t, assert_glbk(t, glbk_texture_update(&t->gl, &source, &(glbk_box){ 0, 3, 1, 0, 7, 9, 1 }, in)));
    d.data = NULL;
    d.format = GLBK_FORMAT_DEPTH24;
    GL_SAME(t, assert_glbk(t, glbk_texture_create(&t->gl, &d, &depth)));
    GL_SAME(t, assert_glbk(t, glbk__table_create(&t->gl, GLBK_FORMAT_R32UI, words, 1500, &table)));
    GL_SAME(t, assert_glbk(t, glbk__table_update(&t->gl, &table, 3, 1400, words)));
    GL_SAME(t, assert_glbk(t, glbk_buffer_create(&t->gl, sizeof words, words, &buffer)));
    GL_SAME(t, assert_glbk(t, glbk_indices_create(&t->gl, sizeof words, words, &indices)));
    GL_SAME(t, assert_glbk(t, glbk_buffer_update(&t->gl, &indices, 4, 8, words)));
    GL_SAME(t, assert_glbk(t, glbk_buffer_update(&t->gl, &indices, 0, sizeof words, words)));
    GL_SAME(t, assert_glbk(t, glbk_buffer_update(&t->gl, &buffer, 8, 4000, words)));
    if (!t->gl.es) GL_SAME(t, assert_glbk(t, glbk_buffer_read(&t->gl, &buffer, 0, sizeof words, out->words)));
    targets.color[0] = &color;
    targets.depth = &depth;
    GL_SAME(t, assert_glbk(t, glbk_target_create(&t->gl, &targets, &target)));
    GL_SAME(t, assert_glbk(t, glbk__program_create(&t->gl, NULL, "copy.frag", NULL, &copy)));
    text.fragment = "layout(location = 0) out glbk_color c;\n"
                    "void main() { c = glbk_pack(vec4(gl_FragCoord.xyz, gl_FrontFacing ? 1.0 : 0.0)); }\n";
    GL_SAME(t, assert_glbk(t, glbk_program_compile(&t->gl, &text, &mine)));
    text.uses = "base_bindings";
    text.fragment = "layout(location = 0) out glbk_color c;\n"
                    "void main() { c = glbk_pack(glbk_unpack(texture(glbk_source, vec2(1.6, 0.3)))); }\n";
    GL_SAME(t, assert_glbk(t, glbk_program_compile(&t->gl, &text, &sample)));
    bytes = gl_canvas_make(t, GLBK_FORMAT_RGBA8, SIDE, SIDE, 0);

    pass.target = &target;
    GL_SAVED(t, glbk_program_use(&t->gl, &copy));
    GL_SAVED(t, { glbk_program_use(&t->gl, &mine); assert_glbk(t, glbk_set_slots(&t->gl, NULL, NULL, mine.name)); });
    for (depths = 0; depths < GLBK_DEPTH_COUNT; depths++)
        for (blends = 0; blends < (t->gl.float_blend ? GLBK_BLEND_COUNT : 1); blends++)
            for (culls = 0; culls < GLBK_CULL_COUNT; culls++) {
                pass.depth = (glbk_depth)depths;
                pass.blend = (glbk_blend)blends;
                pass.cull = (glbk_cull)culls;
                pass.no_color = depths == 1 && blends == 1;
                pass.offset[1] = culls == 2 ? 1.0f : 0.0f;
                GL_SAVED(t, one_pass(t, &pass, &copy, &source, &buffer));
            }
    memset(&pass, 0, sizeof pass);
    pass.target = &target;
    GL_SAVED(t, one_pass(t, &pass, &copy, &source, &buffer));
    GL_SAME(t, assert_glbk(t, glbk_target_read(&t->gl, &target, 0, 0, 0, SIDE, SIDE, out->pixels[0])));
    pass.depth = GLBK_DEPTH_LESS;
    pass.cull = GLBK_CULL_BACK;
    GL_SAVED(t, one_pass(t, &pass, &mine, &source, &buffer));
    GL_SAME(t, assert_glbk(t, glbk_target_read(&t->gl, &target, 0, 0, 0, SIDE, SIDE, out->pixels[1])));
    GL_SAVED(t, one_pass(t, &pass, &sample, &source, &buffer));
    GL_SAME(t, assert_glbk(t, glbk_target_read(&t->gl, &target, 0, 0, 0, SIDE, SIDE, out->pixels[2])));
    pass.target = &bytes.target;
    pass.depth = GLBK_DEPTH_OFF;
    GL_SAVED(t, one_pass(t, &pass, t->gl.float_targets ? &copy : NULL, &source, &buffer));    /* bits are no colours */
    GL_SAME(t, assert_glbk(t, glbk_target_read(&t->gl, &bytes.target, 0, 0, 0, SIDE, SIDE, out->pixels[3])));
    GL_SAME(t, assert_int_equal(glbk_check(&t->gl), GLBK_OK));

    gl_canvas_free(t, &bytes);
    GL_SAME(t, glbk_program_free(&t->gl, &sample));
    GL_SAME(t, glbk_program_free(&t->gl, &mine));
    GL_SAME(t, glbk_program_free(&t->gl, &copy));
    GL_SAME(t, glbk_target_free(&t->gl, &target));
    GL_SAME(t, glbk_texture_free(&t->gl, &source));
    GL_SAME(t, glbk_texture_free(&t->gl, &table));
    GL_SAME(t, glbk_texture_free(&t->gl, &color));
    GL_SAME(t, glbk_texture_free(&t->gl, &depth));
    GL_SAME(t, glbk_buffer_free(&t->gl, &buffer));
    GL_SAME(t, glbk_buffer_free(&t->gl, &indices));
}

static void every_call_keeps_state(void **state)
{
    GL_TEST(t, state)
    static picture calm, harsh;
    static gl_snapshot defaults, harshly;
    gl_hostile h;
    int i, differ = 0;

    gl_state_watch(t, 1);
    memset(&calm, 0, sizeof calm);
    memset(&harsh, 0, sizeof harsh);
    every_call(t, &calm);
    gl_hostile_make(t, &h);
    gl_state_read(&t->gl, &defaults);
    gl_hostile_set(t, &h);
    gl_state_read(&t->gl, &harshly);
    for (i = 0; i < defaults.count; i++) differ += defaults.values[i].number != harshly.values[i].number;
    assert_true(differ >= 60);                      /* it is hostile */
    every_call(t, &harsh);
    assert_memory_equal(&calm, &harsh, sizeof calm);
    assert_true(calm.pixels[0][8] != calm.pixels[0][12]);   /* and it is a picture */
    assert_true(calm.pixels[1][4 * SIDE + 1] == 1.5f);
    gl_hostile_free(t, &h);
}

static void set_alone(const glbk_context *gl, uint32_t what)
{
    if (gl->gl.IsEnabled(what)) gl->gl.Disable(what);
    else gl->gl.Enable(what);
    gl->gl.Scissor(0, 0, 1, 1);
    if (gl->es) return;
    gl_extra.LogicOp(0x1506 /* XOR */);
    gl_extra.PrimitiveRestartIndex(1);
}

/* What is drawn does not depend on any single switch: each is turned over alone. Finds one that hides behind others. */
static void no_switch_alone_changes_a_pass(void **state)
{
    GL_TEST(t, state)
    static const struct { const char *who; uint32_t what; } switches[] = {
#define CAP(who, name, what) { #who, what },
        GL_STATE_CAPS(CAP)
#undef CAP
    };
    static float wanted[2][4 * SIDE * SIDE], seen[4 * SIDE * SIDE];
    gl_canvas c[2] = { gl_canvas_make(t, GLBK_FORMAT_COLOR, SIDE, SIDE, 1),
                       gl_canvas_make(t, GLBK_FORMAT_RGBA8, SIDE, SIDE, 1) };
    glbk_source text = { 0 };
    glbk_program mine[2];
    glbk_pass pass = { 0 };
    glbk_buffer block;
    size_t i, k;

    gl_state_load(t);
    text.fragment = "layout(location = 0) out glbk_color c;\nvoid main() { c = glbk_pack(gl_FragCoord); }\n";
    assert_glbk(t, glbk_program_compile(&t->gl, &text, &mine[0]));
    text.fragment = "layout(location = 0) out vec4 c;\nvoid main() { c = gl_FragCoord / 20.0; }\n";
    assert_glbk(t, glbk_program_compile(&t->gl, &text, &mine[1]));
    assert_glbk(t, glbk_buffer_create(&t->gl, 64, NULL, &block));
    pass.depth = GLBK_DEPTH_LESS;
    for (k = 0; k < 2; k++) {
        pass.target = &c[k].target;
        one_pass(t, &pass, &mine[k], &c[1 - k].color, &block);
        assert_glbk(t, glbk_target_read(&t->gl, &c[k].target, 0, 0, 0, SIDE, SIDE, wanted[k]));
    }
    for (i = 0; i < sizeof switches / sizeof switches[0]; i++) {
        if (!gl_state_has(&t->gl, switches[i].who[0])) continue;
        for (k = 0; k < 2; k++) {
            set_alone(&t->gl, switches[i].what);
            pass.target = &c[k].target;
            one_pass(t, &pass, &mine[k], &c[1 - k].color, &block);
            assert_glbk(t, glbk_target_read(&t->gl, &c[k].target, 0, 0, 0, SIDE, SIDE, seen));
            assert_memory_equal(wanted[k], seen, sizeof seen);
        }
    }
    glbk_buffer_free(&t->gl, &block);
    t->gl.gl.UseProgram(0);
    for (k = 0; k < 2; k++) {
        glbk_program_free(&t->gl, &mine[k]);
        gl_canvas_free(t, &c[k]);
    }
}

/* FRAMEBUFFER_SRGB is the user's where the framebuffer is, whatever we draw elsewhere meanwhile; a target of ours that
   can encode does, as on ES, which has no switch. */
static void colours_are_encoded_where_asked(void **state)
{
    GL_TEST(t, state)
    gl_canvas theirs = gl_canvas_make(t, GLBK_FORMAT_SRGB8_A8, 4, 4, 0);
    gl_canvas ours = gl_canvas_make(t, GLBK_FORMAT_RGBA8, 4, 4, 0);
    const glbk_target *const targets[3] = { &ours.target, NULL, &theirs.target };
    glbk_source text = { 0 };
    glbk_program half;
    glbk_pass pass = { 0 };
    int on, k;

    text.fragment = "layout(location = 0) out vec4 c;\nvoid main() { c = vec4(0.5); }\n";
    assert_glbk(t, glbk_program_compile(&t->gl, &text, &half));
    pass.viewport[2] = pass.viewport[3] = 4;
    for (on = 0; on < 2; on++) {
        if (!t->gl.es && on) t->gl.gl.Enable(0x8DB9 /* FRAMEBUFFER_SRGB */);
        else if (!t->gl.es) t->gl.gl.Disable(0x8DB9);
        for (k = 0; k < 3; k++) {
            const glbk_target *seen = k ? &theirs.target : &ours.target;
            const float expected = k == 2 || (k == 1 && (on || t->gl.es)) ? 188.0f / 255 : 0.5f;
            float rgba[4];
            pass.target = targets[k];
            t->gl.gl.BindFramebuffer(GLBK_GL_DRAW_FRAMEBUFFER, theirs.target.name);
            assert_glbk(t, glbk_begin(&t->gl, &pass, &half));
            glbk_draw_screen(&t->gl);
            assert_glbk(t, glbk_target_read(&t->gl, seen, 0, 1, 1, 1, 1, rgba));
            assert_true(rgba[0] > expected - 0.005f && rgba[0] < expected + 0.005f);
            if (k < 2 && !t->gl.es) assert_int_equal(t->gl.gl.IsEnabled(0x8DB9), on);
        }
    }
    t->gl.gl.UseProgram(0);
    glbk_program_free(&t->gl, &half);
    gl_canvas_free(t, &theirs);
    gl_canvas_free(t, &ours);
}

/* A program that its owner deleted while it was in use cannot be brought back, which must be no error. */
static void a_program_pending_deletion_is_no_error(void **state)
{
    GL_TEST(t, state)
    gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_RGBA8, 4, 4, 0);
    glbk_program theirs, ours;
    glbk_pass pass = { 0 };
    glbk_state saved;
    int32_t now = -1;

    assert_glbk(t, glbk__program_create(&t->gl, NULL, "copy.frag", "TO_COLOR=1", &theirs));
    assert_glbk(t, glbk__program_create(&t->gl, NULL, "copy.frag", "TO_COLOR=1", &ours));
    t->gl.gl.UseProgram(theirs.name);
    glbk_program_free(&t->gl, &theirs);
    glbk_state_save(&t->gl, &saved);
    pass.target = &c.target;
    assert_glbk(t, glbk_begin(&t->gl, &pass, &ours));
    glbk_state_restore(&t->gl, &saved);
    t->gl.gl.GetIntegerv(0x8B8D, &now);
    assert_int_equal(now, 0);
    assert_int_equal(t->gl.gl.GetError(), 0);
    glbk_program_free(&t->gl, &ours);
    gl_canvas_free(t, &c);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(every_call_keeps_state), gl_unit_test(no_switch_alone_changes_a_pass),
        gl_unit_test(a_program_pending_deletion_is_no_error), gl_unit_test(colours_are_encoded_where_asked),
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_ALL);
}
