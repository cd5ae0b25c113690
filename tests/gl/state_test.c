/* GL's state before and after every public call of gl_backend.h, from GL's defaults and from a hostile state; and what
   is drawn from the hostile state is the same. The list of values is this file's own, not that of glbk_state. */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#define GL_BACKEND_IMPLEMENTATION
#include "gl_backend.h"

#include "gl/gl_test.h"

/* ---- the list: X(who has it, name, number of values). B = both, D = OpenGL, C = compute, K = clip control ---- */

#define CAPS(X)                                                                                                     \
    X(B, BLEND, 0x0BE2) X(B, CULL_FACE, 0x0B44) X(B, DEPTH_TEST, 0x0B71) X(B, DITHER, 0x0BD0)                       \
    X(B, POLYGON_OFFSET_FILL, 0x8037) X(B, SAMPLE_ALPHA_TO_COVERAGE, 0x809E) X(B, SAMPLE_COVERAGE, 0x80A0)          \
    X(B, SCISSOR_TEST, 0x0C11) X(B, STENCIL_TEST, 0x0B90) X(B, RASTERIZER_DISCARD, 0x8C89)                          \
    X(R, PRIMITIVE_RESTART_FIXED_INDEX, 0x8D69) X(D, PRIMITIVE_RESTART, 0x8F9D) X(D, COLOR_LOGIC_OP, 0x0BF2)        \
    X(D, DEPTH_CLAMP, 0x864F) X(D, FRAMEBUFFER_SRGB, 0x8DB9) X(D, MULTISAMPLE, 0x809D) X(D, SAMPLE_MASK, 0x8E51)    \
    X(D, SAMPLE_ALPHA_TO_ONE, 0x809F) X(D, PROGRAM_POINT_SIZE, 0x8642) X(D, TEXTURE_CUBE_MAP_SEAMLESS, 0x884F)      \
    X(D, CLIP_DISTANCE0, 0x3000) X(D, CLIP_DISTANCE1, 0x3001) X(D, CLIP_DISTANCE7, 0x3007)                          \
    X(D, POLYGON_SMOOTH, 0x0B41) X(D, LINE_SMOOTH, 0x0B20) X(D, POLYGON_OFFSET_LINE, 0x2A02)                        \
    X(D, POLYGON_OFFSET_POINT, 0x2A01)

#define INTEGERS(X)                                                                                                 \
    X(B, ACTIVE_TEXTURE, 0x84E0, 1) X(B, CURRENT_PROGRAM, 0x8B8D, 1) X(B, VERTEX_ARRAY_BINDING, 0x85B5, 1)          \
    X(B, DRAW_FRAMEBUFFER_BINDING, 0x8CA6, 1) X(B, READ_FRAMEBUFFER_BINDING, 0x8CAA, 1)                             \
    X(B, RENDERBUFFER_BINDING, 0x8CA7, 1) X(B, ARRAY_BUFFER_BINDING, 0x8894, 1)                                     \
    X(B, ELEMENT_ARRAY_BUFFER_BINDING, 0x8895, 1) X(B, UNIFORM_BUFFER_BINDING, 0x8A28, 1)                           \
    X(B, COPY_READ_BUFFER, 0x8F36, 1) X(B, COPY_WRITE_BUFFER, 0x8F37, 1)                                            \
    X(B, TRANSFORM_FEEDBACK_BUFFER_BINDING, 0x8C8F, 1) X(C, SHADER_STORAGE_BUFFER_BINDING, 0x90D3, 1)               \
    X(B, PIXEL_UNPACK_BUFFER_BINDING, 0x88EF, 1) X(B, PIXEL_PACK_BUFFER_BINDING, 0x88ED, 1)                         \
    X(B, VIEWPORT, 0x0BA2, 4) X(B, SCISSOR_BOX, 0x0C10, 4) X(B, DEPTH_WRITEMASK, 0x0B72, 1)                         \
    X(B, COLOR_WRITEMASK, 0x0C23, 4) X(B, DEPTH_FUNC, 0x0B74, 1) X(B, CULL_FACE_MODE, 0x0B45, 1)                    \
    X(B, FRONT_FACE, 0x0B46, 1) X(B, BLEND_SRC_RGB, 0x80C9, 1) X(B, BLEND_DST_RGB, 0x80C8, 1)                       \
    X(B, BLEND_SRC_ALPHA, 0x80CB, 1) X(B, BLEND_DST_ALPHA, 0x80CA, 1) X(B, BLEND_EQUATION_RGB, 0x8009, 1)           \
    X(B, BLEND_EQUATION_ALPHA, 0x883D, 1) X(B, STENCIL_FUNC, 0x0B92, 1) X(B, STENCIL_REF, 0x0B97, 1)                \
    X(B, STENCIL_VALUE_MASK, 0x0B93, 1) X(B, STENCIL_WRITEMASK, 0x0B98, 1) X(B, STENCIL_FAIL, 0x0B94, 1)            \
    X(B, STENCIL_PASS_DEPTH_FAIL, 0x0B95, 1) X(B, STENCIL_PASS_DEPTH_PASS, 0x0B96, 1)                               \
    X(B, STENCIL_BACK_FUNC, 0x8800, 1) X(B, STENCIL_BACK_WRITEMASK, 0x8CA5, 1)                                      \
    X(B, UNPACK_ALIGNMENT, 0x0CF5, 1) X(B, UNPACK_ROW_LENGTH, 0x0CF2, 1) X(B, UNPACK_SKIP_ROWS, 0x0CF3, 1)          \
    X(B, UNPACK_SKIP_PIXELS, 0x0CF4, 1) X(B, UNPACK_IMAGE_HEIGHT, 0x806E, 1) X(B, UNPACK_SKIP_IMAGES, 0x806D, 1)    \
    X(D, UNPACK_SWAP_BYTES, 0x0CF0, 1) X(D, UNPACK_LSB_FIRST, 0x0CF1, 1) X(B, PACK_ALIGNMENT, 0x0D05, 1)            \
    X(B, PACK_ROW_LENGTH, 0x0D02, 1) X(B, PACK_SKIP_ROWS, 0x0D03, 1) X(B, PACK_SKIP_PIXELS, 0x0D04, 1)              \
    X(D, PACK_SWAP_BYTES, 0x0D00, 1) X(D, PACK_LSB_FIRST, 0x0D01, 1) X(D, PACK_IMAGE_HEIGHT, 0x806C, 1)             \
    X(D, PACK_SKIP_IMAGES, 0x806B, 1) X(D, POLYGON_MODE, 0x0B40, 2) X(D, LOGIC_OP_MODE, 0x0BF0, 1)                  \
    X(D, PRIMITIVE_RESTART_INDEX, 0x8F9E, 1) X(D, PROVOKING_VERTEX, 0x8E4F, 1) X(D, CLAMP_READ_COLOR, 0x891C, 1)    \
    X(K, CLIP_ORIGIN, 0x935C, 1) X(K, CLIP_DEPTH_MODE, 0x935D, 1) X(B, SAMPLE_COVERAGE_INVERT, 0x80AB, 1)           \
    X(B, DRAW_BUFFER0, 0x8825, 1) X(B, READ_BUFFER, 0x0C02, 1)

#define FLOATS(X)                                                                                                   \
    X(B, BLEND_COLOR, 0x8005, 4) X(B, COLOR_CLEAR_VALUE, 0x0C22, 4) X(B, DEPTH_CLEAR_VALUE, 0x0B73, 1)              \
    X(B, DEPTH_RANGE, 0x0B70, 2) X(B, LINE_WIDTH, 0x0B21, 1) X(B, POLYGON_OFFSET_FACTOR, 0x8038, 1)                 \
    X(B, POLYGON_OFFSET_UNITS, 0x2A00, 1) X(B, SAMPLE_COVERAGE_VALUE, 0x80AA, 1) X(D, POINT_SIZE, 0x0B11, 1)

enum { MOST = 500, UNITS = 20, BINDINGS = 10 };

typedef struct value { const char *name; int index; double number; } value;
typedef struct snapshot { value values[MOST]; int count; } snapshot;

/* Functions that gl_backend.h does not load. */
typedef struct more {
    uint8_t (GLBK_CALL *IsEnabledi)(uint32_t, uint32_t);
    void (GLBK_CALL *StencilFunc)(uint32_t, int32_t, uint32_t);
    void (GLBK_CALL *StencilOp)(uint32_t, uint32_t, uint32_t);
    void (GLBK_CALL *StencilMask)(uint32_t);
    void (GLBK_CALL *LogicOp)(uint32_t);
    void (GLBK_CALL *PrimitiveRestartIndex)(uint32_t);
    void (GLBK_CALL *SampleCoverage)(float, uint8_t);
    void (GLBK_CALL *BlendColor)(float, float, float, float);
    void (GLBK_CALL *ClearColor)(float, float, float, float);
    void (GLBK_CALL *LineWidth)(float);
    void (GLBK_CALL *ProvokingVertex)(uint32_t);
    void (GLBK_CALL *GenSamplers)(int32_t, uint32_t *);
    void (GLBK_CALL *DeleteSamplers)(int32_t, const uint32_t *);
    void (GLBK_CALL *SamplerParameteri)(uint32_t, uint32_t, int32_t);
} more;

static more extra;

static void load_more(gl_test *t)
{
    glbk_proc proc;
#define LOAD(name) proc = ex_gl_get_proc("gl" #name, t->context), memcpy(&extra.name, &proc, sizeof proc)
    LOAD(IsEnabledi); LOAD(StencilFunc); LOAD(StencilOp); LOAD(StencilMask); LOAD(LogicOp);
    LOAD(PrimitiveRestartIndex); LOAD(SampleCoverage); LOAD(BlendColor); LOAD(ClearColor); LOAD(LineWidth);
    LOAD(ProvokingVertex); LOAD(GenSamplers); LOAD(DeleteSamplers); LOAD(SamplerParameteri);
#undef LOAD
}

static int is_there(const glbk_context *gl, char who)
{
    switch (who) {
    case 'D': return !gl->es;
    case 'C': return gl->compute;
    case 'K': return gl->clip_control;
    case 'R': return gl->es || gl->version >= 430;
    default: return 1;
    }
}

static void add(snapshot *s, const char *name, int index, double number)
{
    assert_true(s->count < MOST);
    s->values[s->count].name = name;
    s->values[s->count].index = index;
    s->values[s->count++].number = number;
}

static void read_units(const glbk_context *gl, snapshot *s)
{
    static const struct { const char *name; uint32_t what; } bindings[] = {
        { "TEXTURE_BINDING_2D", 0x8069 }, { "TEXTURE_BINDING_2D_ARRAY", 0x8C1D }, { "TEXTURE_BINDING_3D", 0x806A },
        { "TEXTURE_BINDING_CUBE_MAP", 0x8514 }, { "SAMPLER_BINDING", 0x8919 }
    };
    int32_t active, name;
    uint32_t i;
    size_t k;
    gl->gl.GetIntegerv(0x84E0, &active);
    for (i = 0; i < UNITS; i++) {
        gl->gl.ActiveTexture(GLBK_GL_TEXTURE0 + i);
        for (k = 0; k < sizeof bindings / sizeof bindings[0]; k++) {
            gl->gl.GetIntegerv(bindings[k].what, &name);
            add(s, bindings[k].name, (int)i, name);
        }
    }
    gl->gl.ActiveTexture((uint32_t)active);
}

static void read_buffers(const glbk_context *gl, snapshot *s)
{
    static const struct { const char *name[3]; uint32_t what; char who; } kinds[] = {
        { { "UNIFORM_BUFFER", "UNIFORM_BUFFER_START", "UNIFORM_BUFFER_SIZE" }, 0x8A28, 'B' },
        { { "SHADER_STORAGE_BUFFER", "SHADER_STORAGE_BUFFER_START", "SHADER_STORAGE_BUFFER_SIZE" }, 0x90D3, 'C' }
    };
    size_t k;
    uint32_t i;
    for (k = 0; k < 2; k++)
        for (i = 0; i < (k ? 8u : BINDINGS) && is_there(gl, kinds[k].who); i++) {
            int32_t name;
            int64_t start, size;
            gl->gl.GetIntegeri_v(kinds[k].what, i, &name);
            gl->gl.GetInteger64i_v(kinds[k].what + 1, i, &start);
            gl->gl.GetInteger64i_v(kinds[k].what + 2, i, &size);
            add(s, kinds[k].name[0], (int)i, name);
            add(s, kinds[k].name[1], (int)i, (double)start);
            add(s, kinds[k].name[2], (int)i, (double)size);
        }
}

static void read_state(const glbk_context *gl, snapshot *s)
{
    int32_t n[4];
    float f[4];
    int i;

    s->count = 0;
#define CAP(who, name, what) if (is_there(gl, *#who)) add(s, #name, 0, gl->gl.IsEnabled(what));
    CAPS(CAP)
#undef CAP
#define INTEGER(who, name, what, count)                                         \
    if (is_there(gl, *#who)) {                                                  \
        gl->gl.GetIntegerv(what, n);                                            \
        for (i = 0; i < (count); i++) add(s, #name, i, n[i]);                   \
    }
    INTEGERS(INTEGER)
#undef INTEGER
#define FLOAT(who, name, what, count)                                           \
    if (is_there(gl, *#who)) {                                                  \
        gl->gl.GetFloatv(what, f);                                              \
        for (i = 0; i < (count); i++) add(s, #name, i, (double)f[i]);           \
    }
    FLOATS(FLOAT)
#undef FLOAT
    for (i = 0; i < 8 && !gl->es; i++) {
        uint8_t mask[4];
        int k;
        gl->gl.GetBooleani_v(0x0C23, (uint32_t)i, mask);
        for (k = 0; k < 4; k++) add(s, "COLOR_WRITEMASK of a target", 4 * i + k, mask[k]);
        add(s, "BLEND of a target", i, extra.IsEnabledi(0x0BE2, (uint32_t)i));
    }
    read_units(gl, s);
    read_buffers(gl, s);
}

static void assert_same(const snapshot *a, const snapshot *b, const char *call)
{
    int i, wrong = 0;
    assert_int_equal(a->count, b->count);
    for (i = 0; i < a->count; i++)
        if (a->values[i].number != b->values[i].number) {
            printf("%s changed %s[%d]: %g -> %g\n", call, a->values[i].name, a->values[i].index, a->values[i].number,
                   b->values[i].number);
            wrong++;
        }
    assert_int_equal(wrong, 0);
}

/* ---- a renderer that leaves everything as nobody expects it ---- */

typedef struct hostile {
    glbk_texture texture, array, cover;
    glbk_target  target;
    glbk_buffer  buffer, pixels;
    glbk_program program;
    uint32_t     samplers[2], vertex_array;
} hostile;

static void make_hostile_objects(gl_test *t, hostile *h)
{
    glbk_texture_desc d = { 0 };
    glbk_target_desc targets = { 0 };
    memset(h, 0, sizeof *h);
    d.format = GLBK_FORMAT_RGBA8;
    d.width = d.height = 32;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &h->texture));
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &h->cover));
    d.layers = 2;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &h->array));
    targets.color[0] = &h->cover;
    assert_glbk(t, glbk_target_create(&t->gl, &targets, &h->target));
    assert_glbk(t, glbk_buffer_create(&t->gl, 4096, NULL, &h->buffer));
    assert_glbk(t, glbk_buffer_create(&t->gl, 4096, NULL, &h->pixels));
    assert_glbk(t, glbk_program_create(&t->gl, "copy.frag", "TO_COLOR=1", &h->program));
    extra.GenSamplers(2, h->samplers);
    extra.SamplerParameteri(h->samplers[0], 0x2802, 0x2901);    /* repeats, where our textures clamp */
    t->gl.gl.GenVertexArrays(1, &h->vertex_array);
}

static void set_hostile_caps(const glbk_context *gl)
{
#define CAP(who, name, what)                                                                    \
    if (is_there(gl, *#who)) {                                                                  \
        if (gl->gl.IsEnabled(what)) gl->gl.Disable(what);                                       \
        else gl->gl.Enable(what);                                                               \
    }
    CAPS(CAP)
#undef CAP
}

static void set_hostile_values(const glbk_context *gl)
{
    static const uint32_t store[] = { 0x0CF5, 0x0CF2, 0x0CF3, 0x0CF4, 0x806E, 0x806D, 0x0D05, 0x0D02, 0x0D03, 0x0D04,
                                      0x0CF0, 0x0CF1, 0x0D00, 0x0D01, 0x806C, 0x806B };
    size_t i;
    for (i = 0; i < (gl->es ? 10u : 16u); i++)
        gl->gl.PixelStorei(store[i], store[i] == 0x0CF5 || store[i] == 0x0D05 ? 8 : i >= 10 && i < 14 ? 1 : 7 + (int)i);
    gl->gl.Viewport(3, 5, 7, 11);
    gl->gl.Scissor(1, 2, 1, 2);
    gl->gl.ColorMask(0, 1, 0, 1);
    gl->gl.DepthMask(0);
    gl->gl.DepthFunc(0x0200 /* NEVER */);
    gl->gl.CullFace(0x0408 /* FRONT_AND_BACK */);
    gl->gl.FrontFace(0x0900 /* CW */);
    gl->gl.BlendFuncSeparate(0x0307, 0, 0x0306, 1);
    gl->gl.BlendEquationSeparate(0x800B, 0x8007);
    gl->gl.PolygonOffset(3, 100000);
    glbk__depth_range(gl, 0.9f, 0.3f);
    extra.StencilFunc(0x0200 /* NEVER */, 3, 0x55);
    extra.StencilOp(0x1E01, 0x1E02, 0x150A);
    extra.StencilMask(0x33);
    extra.SampleCoverage(0.25f, 1);
    extra.BlendColor(0.1f, 0.2f, 0.3f, 0.4f);
    extra.ClearColor(0.5f, 0.6f, 0.7f, 0.8f);
    if (gl->es) return;
    gl->gl.PolygonMode(0x0408, 0x1B01 /* LINE */);
    gl->gl.PointSize(13);
    gl->gl.ClampColor(0x891C, 1);
    gl->gl.ColorMaski(1, 1, 0, 0, 0);
    gl->gl.Disablei(0x0BE2, 2);
    extra.LogicOp(0x1506 /* XOR */);
    extra.PrimitiveRestartIndex(1);
    extra.ProvokingVertex(0x8E4D /* FIRST */);
    if (gl->clip_control) gl->gl.ClipControl(0x8CA2 /* UPPER_LEFT */, 0x935F /* ZERO_TO_ONE */);
}

static void set_hostile_bindings(const glbk_context *gl, hostile *h)
{
    uint32_t i;
    for (i = 0; i < UNITS; i++) {
        gl->gl.ActiveTexture(GLBK_GL_TEXTURE0 + i);
        gl->gl.BindTexture(GLBK_GL_TEXTURE_2D, i % 3 ? h->texture.name : 0);
        gl->gl.BindTexture(GLBK_GL_TEXTURE_2D_ARRAY, i % 2 ? h->array.name : 0);
        gl->gl.BindSampler(i, h->samplers[i % 2]);
    }
    gl->gl.ActiveTexture(GLBK_GL_TEXTURE0 + 9);
    for (i = 0; i < BINDINGS; i++)
        gl->gl.BindBufferRange(GLBK_GL_UNIFORM_BUFFER, i, h->buffer.name, 256 * (ptrdiff_t)i, 256);
    for (i = 0; i < 8 && gl->compute; i++)
        gl->gl.BindBufferRange(GLBK_GL_SHADER_STORAGE_BUFFER, i, h->buffer.name, 256 * (ptrdiff_t)i, 512);
    gl->gl.BindBufferBase(GLBK_GL_UNIFORM_BUFFER, 1, h->pixels.name);
    gl->gl.BindVertexArray(h->vertex_array);
    gl->gl.BindBuffer(GLBK_GL_ELEMENT_ARRAY_BUFFER, h->buffer.name);
    gl->gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, h->buffer.name);
    gl->gl.BindBuffer(GLBK_GL_COPY_WRITE_BUFFER, h->buffer.name);
    gl->gl.BindBuffer(0x88EC /* PIXEL_UNPACK_BUFFER */, h->pixels.name);
    gl->gl.BindBuffer(0x88EB /* PIXEL_PACK_BUFFER */, h->pixels.name);
    gl->gl.BindFramebuffer(GLBK_GL_FRAMEBUFFER, h->target.name);
    gl->gl.ReadBuffer(GLBK_GL_COLOR_ATTACHMENT0);
    gl->gl.UseProgram(h->program.name);
}

static void set_hostile(gl_test *t, hostile *h)
{
    set_hostile_caps(&t->gl);
    set_hostile_values(&t->gl);
    set_hostile_bindings(&t->gl, h);
}

static void free_hostile(gl_test *t, hostile *h)
{
    t->gl.gl.UseProgram(0);
    t->gl.gl.BindBuffer(0x88EC, 0);
    t->gl.gl.BindBuffer(0x88EB, 0);
    t->gl.gl.DeleteVertexArrays(1, &h->vertex_array);
    extra.DeleteSamplers(2, h->samplers);
    glbk_program_destroy(&t->gl, &h->program);
    glbk_target_destroy(&t->gl, &h->target);
    glbk_buffer_destroy(&t->gl, &h->buffer);
    glbk_buffer_destroy(&t->gl, &h->pixels);
    glbk_texture_destroy(&t->gl, &h->texture);
    glbk_texture_destroy(&t->gl, &h->array);
    glbk_texture_destroy(&t->gl, &h->cover);
}

/* ---- every public call ---- */

enum { SIDE = 16 };
typedef struct picture { float pixels[4][4 * SIDE * SIDE]; uint32_t words[1500]; } picture;

/* Calls f and compares the state before and after. */
#define SAME(f)                                 \
    do {                                        \
        read_state(&t->gl, &before);            \
        f;                                      \
        read_state(&t->gl, &after);             \
        assert_same(&before, &after, #f);       \
        assert_int_equal(t->gl.gl.GetError(), 0); \
    } while (0)
/* The same with glbk_state_save before and glbk_state_restore after a call that may touch state. */
#define SAVED(f)                                \
    SAME({                                      \
        glbk_state_save(&t->gl, &saved);        \
        f;                                      \
        glbk_state_restore(&t->gl, &saved);     \
    })

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
    if (t->gl.compute) glbk_bind_storage(&t->gl, 2, block);
    glbk_draw_screen(&t->gl);
}

/* All calls; out is what was drawn and read. */
static void every_call(gl_test *t, picture *out)
{
    static float in[4 * SIDE * SIDE];
    static uint32_t words[1500];
    static snapshot before, after;
    glbk_state saved;
    glbk_context other;
    glbk_desc desc = { 0 };
    glbk_texture_desc d = { 0 };
    glbk_texture source, color, depth, table;
    glbk_target_desc targets = { 0 };
    glbk_target target;
    glbk_buffer buffer;
    glbk_program copy, mine, sample;
    glbk_source text = { 0 };
    glbk_pass pass = { 0 };
    gl_canvas bytes;
    int i, depths, blends, culls;

    for (i = 0; i < 4 * SIDE * SIDE; i++) in[i] = (float)i * 0.37f - 40;
    for (i = 0; i < 1500; i++) words[i] = (uint32_t)i * 2654435761u;
    read_state(&t->gl, &before);
    assert_true(before.count >= 60);
    desc.get_proc = gl_get_proc();
    desc.user = t->context;
    SAME(assert_int_equal(glbk_init(&other, &desc), GLBK_OK));
    SAME(glbk_destroy(&other));

    d.format = GLBK_FORMAT_COLOR;
    d.width = d.height = SIDE;
    SAME(assert_glbk(t, glbk_texture_create(&t->gl, &d, &color)));
    d.data = in;
    SAME(assert_glbk(t, glbk_texture_create(&t->gl, &d, &source)));
    SAME(assert_glbk(t, glbk_texture_update(&t->gl, &source, 0, 3, 1, 0, 7, 9, 1, in)));
    d.data = NULL;
    d.format = GLBK_FORMAT_DEPTH24;
    SAME(assert_glbk(t, glbk_texture_create(&t->gl, &d, &depth)));
    SAME(assert_glbk(t, glbk_table_create(&t->gl, GLBK_FORMAT_R32UI, words, 1500, &table)));
    SAME(assert_glbk(t, glbk_table_update(&t->gl, &table, 3, 1400, words)));
    SAME(assert_glbk(t, glbk_buffer_create(&t->gl, sizeof words, words, &buffer)));
    SAME(assert_glbk(t, glbk_buffer_update(&t->gl, &buffer, 8, 4000, words)));
    if (!t->gl.es) SAME(assert_glbk(t, glbk_buffer_read(&t->gl, &buffer, 0, sizeof words, out->words)));
    targets.color[0] = &color;
    targets.depth = &depth;
    SAME(assert_glbk(t, glbk_target_create(&t->gl, &targets, &target)));
    SAME(assert_glbk(t, glbk_program_create(&t->gl, "copy.frag", NULL, &copy)));
    text.fragment = "layout(location = 0) out glbk_color c;\n"
                    "void main() { c = glbk_pack(vec4(gl_FragCoord.xyz, gl_FrontFacing ? 1.0 : 0.0)); }\n";
    SAME(assert_glbk(t, glbk_program_compile(&t->gl, &text, &mine)));
    text.uses = "base_bindings";
    text.fragment = "layout(location = 0) out glbk_color c;\n"
                    "void main() { c = glbk_pack(glbk_unpack(texture(glbk_source, vec2(1.6, 0.3)))); }\n";
    SAME(assert_glbk(t, glbk_program_compile(&t->gl, &text, &sample)));
    bytes = gl_canvas_make(t, GLBK_FORMAT_RGBA8, SIDE, SIDE, 0);

    pass.target = &target;
    SAVED(glbk_program_use(&t->gl, &copy));
    SAVED({ glbk_program_use(&t->gl, &mine); glbk_set_slots(&t->gl, mine.name); });
    for (depths = 0; depths < GLBK_DEPTH_COUNT; depths++)
        for (blends = 0; blends < (t->gl.float_blend ? GLBK_BLEND_COUNT : 1); blends++)
            for (culls = 0; culls < GLBK_CULL_COUNT; culls++) {
                pass.depth = (glbk_depth)depths;
                pass.blend = (glbk_blend)blends;
                pass.cull = (glbk_cull)culls;
                pass.no_color = depths == 1 && blends == 1;
                pass.offset[1] = culls == 2 ? 1.0f : 0.0f;
                SAVED(one_pass(t, &pass, &copy, &source, &buffer));
            }
    memset(&pass, 0, sizeof pass);
    pass.target = &target;
    SAVED(one_pass(t, &pass, &copy, &source, &buffer));
    SAME(assert_glbk(t, glbk_target_read(&t->gl, &target, 0, 0, 0, SIDE, SIDE, out->pixels[0])));
    pass.depth = GLBK_DEPTH_LESS;
    pass.cull = GLBK_CULL_BACK;
    SAVED(one_pass(t, &pass, &mine, &source, &buffer));
    SAME(assert_glbk(t, glbk_target_read(&t->gl, &target, 0, 0, 0, SIDE, SIDE, out->pixels[1])));
    SAVED(one_pass(t, &pass, &sample, &source, &buffer));
    SAME(assert_glbk(t, glbk_target_read(&t->gl, &target, 0, 0, 0, SIDE, SIDE, out->pixels[2])));
    pass.target = &bytes.target;
    pass.depth = GLBK_DEPTH_OFF;
    SAVED(one_pass(t, &pass, t->gl.float_targets ? &copy : NULL, &source, &buffer));    /* bits are no colours */
    SAME(assert_glbk(t, glbk_target_read(&t->gl, &bytes.target, 0, 0, 0, SIDE, SIDE, out->pixels[3])));
    SAME(assert_int_equal(glbk_check(&t->gl), GLBK_OK));

    gl_canvas_free(t, &bytes);
    SAME(glbk_program_destroy(&t->gl, &sample));
    SAME(glbk_program_destroy(&t->gl, &mine));
    SAME(glbk_program_destroy(&t->gl, &copy));
    SAME(glbk_target_destroy(&t->gl, &target));
    SAME(glbk_texture_destroy(&t->gl, &source));
    SAME(glbk_texture_destroy(&t->gl, &table));
    SAME(glbk_texture_destroy(&t->gl, &color));
    SAME(glbk_texture_destroy(&t->gl, &depth));
    SAME(glbk_buffer_destroy(&t->gl, &buffer));
}

static void every_call_keeps_state(void **state)
{
    GL_TEST(t, state)
    static picture calm, harsh;
    static snapshot defaults, harshly;
    hostile h;
    int i, differ = 0;

    load_more(t);
    memset(&calm, 0, sizeof calm);
    memset(&harsh, 0, sizeof harsh);
    every_call(t, &calm);
    make_hostile_objects(t, &h);
    read_state(&t->gl, &defaults);
    set_hostile(t, &h);
    read_state(&t->gl, &harshly);
    for (i = 0; i < defaults.count; i++) differ += defaults.values[i].number != harshly.values[i].number;
    assert_true(differ >= 60);                      /* it is hostile */
    every_call(t, &harsh);
    assert_memory_equal(&calm, &harsh, sizeof calm);
    assert_true(calm.pixels[0][8] != calm.pixels[0][12]);   /* and it is a picture */
    assert_true(calm.pixels[1][4 * SIDE + 1] == 1.5f);
    free_hostile(t, &h);
}

static void set_alone(const glbk_context *gl, uint32_t what)
{
    if (gl->gl.IsEnabled(what)) gl->gl.Disable(what);
    else gl->gl.Enable(what);
    gl->gl.Scissor(0, 0, 1, 1);
    if (gl->es) return;
    extra.LogicOp(0x1506 /* XOR */);
    extra.PrimitiveRestartIndex(1);
}

/* What is drawn does not depend on any single switch: each is turned over alone. Finds one that hides behind others. */
static void no_switch_alone_changes_a_pass(void **state)
{
    GL_TEST(t, state)
    static const struct { const char *who; uint32_t what; } switches[] = {
#define CAP(who, name, what) { #who, what },
        CAPS(CAP)
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

    load_more(t);
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
        if (!is_there(&t->gl, switches[i].who[0])) continue;
        for (k = 0; k < 2; k++) {
            set_alone(&t->gl, switches[i].what);
            pass.target = &c[k].target;
            one_pass(t, &pass, &mine[k], &c[1 - k].color, &block);
            assert_glbk(t, glbk_target_read(&t->gl, &c[k].target, 0, 0, 0, SIDE, SIDE, seen));
            assert_memory_equal(wanted[k], seen, sizeof seen);
        }
    }
    glbk_buffer_destroy(&t->gl, &block);
    t->gl.gl.UseProgram(0);
    for (k = 0; k < 2; k++) {
        glbk_program_destroy(&t->gl, &mine[k]);
        gl_canvas_free(t, &c[k]);
    }
}

/* A program that its owner deleted while it was in use cannot be brought back, which must be no error. */
static void a_program_pending_deletion(void **state)
{
    GL_TEST(t, state)
    gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_RGBA8, 4, 4, 0);
    glbk_program theirs, ours;
    glbk_pass pass = { 0 };
    glbk_state saved;
    int32_t now = -1;

    assert_glbk(t, glbk_program_create(&t->gl, "copy.frag", "TO_COLOR=1", &theirs));
    assert_glbk(t, glbk_program_create(&t->gl, "copy.frag", "TO_COLOR=1", &ours));
    t->gl.gl.UseProgram(theirs.name);
    glbk_program_destroy(&t->gl, &theirs);
    glbk_state_save(&t->gl, &saved);
    pass.target = &c.target;
    assert_glbk(t, glbk_begin(&t->gl, &pass, &ours));
    glbk_state_restore(&t->gl, &saved);
    t->gl.gl.GetIntegerv(0x8B8D, &now);
    assert_int_equal(now, 0);
    assert_int_equal(t->gl.gl.GetError(), 0);
    glbk_program_destroy(&t->gl, &ours);
    gl_canvas_free(t, &c);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(every_call_keeps_state), gl_unit_test(no_switch_alone_changes_a_pass),
        gl_unit_test(a_program_pending_deletion),
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_ALL);
}
