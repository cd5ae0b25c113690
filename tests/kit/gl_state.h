/* gl_state.h - GL's state as a list of over 150 values (ES 3.0) or 250 (OpenGL), a renderer that leaves all of them as
   nobody expects, and calls watched for what they change. Include cmocka.h, gl_backend.h and gl_test.h before.

       gl_state_watch(t, 1);                            // from here on the macros compare
       gl_hostile_make(t, &h), gl_hostile_set(t, &h);   // or in GL's default state
       GL_SAME(t, assert_glbk(t, glbk_texture_create(&t->gl, &d, &texture)));       // leaves all as it was
       GL_SAVED(t, assert_glbk(t, glbk_begin(&t->gl, &pass, &program)));            // between save and restore
       gl_hostile_free(t, &h);

   The list is these tests' own, not that of glbk_state. Between gl_count_begin and gl_count_end what is GL_SAVED, a
   pass, may ask GL for nothing. */
#ifndef GL_STATE_H
#define GL_STATE_H

#include "gl_count.h"

/* ---- the list: X(who has it, name, number of values). B = both, D = OpenGL, C = compute, K = clip control, R = fixed
        restart, O = clamp of the polygon offset ---- */

#define GL_STATE_CAPS(X)                                                                                            \
    X(B, BLEND, 0x0BE2) X(B, CULL_FACE, 0x0B44) X(B, DEPTH_TEST, 0x0B71) X(B, DITHER, 0x0BD0)                       \
    X(B, POLYGON_OFFSET_FILL, 0x8037) X(B, SAMPLE_ALPHA_TO_COVERAGE, 0x809E) X(B, SAMPLE_COVERAGE, 0x80A0)          \
    X(B, SCISSOR_TEST, 0x0C11) X(B, STENCIL_TEST, 0x0B90) X(B, RASTERIZER_DISCARD, 0x8C89)                          \
    X(R, PRIMITIVE_RESTART_FIXED_INDEX, 0x8D69) X(D, PRIMITIVE_RESTART, 0x8F9D) X(D, COLOR_LOGIC_OP, 0x0BF2)        \
    X(D, DEPTH_CLAMP, 0x864F) X(D, FRAMEBUFFER_SRGB, 0x8DB9) X(D, MULTISAMPLE, 0x809D) X(D, SAMPLE_MASK, 0x8E51)    \
    X(D, SAMPLE_ALPHA_TO_ONE, 0x809F) X(D, PROGRAM_POINT_SIZE, 0x8642) X(D, TEXTURE_CUBE_MAP_SEAMLESS, 0x884F)      \
    X(D, CLIP_DISTANCE0, 0x3000) X(D, CLIP_DISTANCE1, 0x3001) X(D, CLIP_DISTANCE7, 0x3007)                          \
    X(D, POLYGON_SMOOTH, 0x0B41) X(D, LINE_SMOOTH, 0x0B20) X(D, POLYGON_OFFSET_LINE, 0x2A02)                        \
    X(D, POLYGON_OFFSET_POINT, 0x2A01)

#define GL_STATE_INTEGERS(X)                                                                                        \
    X(B, ACTIVE_TEXTURE, 0x84E0, 1) X(B, CURRENT_PROGRAM, 0x8B8D, 1) X(B, VERTEX_ARRAY_BINDING, 0x85B5, 1)          \
    X(B, DRAW_FRAMEBUFFER_BINDING, 0x8CA6, 1) X(B, READ_FRAMEBUFFER_BINDING, 0x8CAA, 1)                             \
    X(B, RENDERBUFFER_BINDING, 0x8CA7, 1) X(B, ARRAY_BUFFER_BINDING, 0x8894, 1)                                     \
    X(B, ELEMENT_ARRAY_BUFFER_BINDING, 0x8895, 1) X(B, UNIFORM_BUFFER_BINDING, 0x8A28, 1)                           \
    X(B, COPY_READ_BUFFER, 0x8F36, 1) X(B, COPY_WRITE_BUFFER, 0x8F37, 1)                                            \
    X(B, TRANSFORM_FEEDBACK_BUFFER_BINDING, 0x8C8F, 1) X(C, SHADER_STORAGE_BUFFER_BINDING, 0x90D3, 1)               \
    X(C, DISPATCH_INDIRECT_BUFFER_BINDING, 0x90EF, 1)                                                               \
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

#define GL_STATE_FLOATS(X)                                                                                          \
    X(B, BLEND_COLOR, 0x8005, 4) X(B, COLOR_CLEAR_VALUE, 0x0C22, 4) X(B, DEPTH_CLEAR_VALUE, 0x0B73, 1)              \
    X(B, DEPTH_RANGE, 0x0B70, 2) X(B, LINE_WIDTH, 0x0B21, 1) X(B, POLYGON_OFFSET_FACTOR, 0x8038, 1)                 \
    X(B, POLYGON_OFFSET_UNITS, 0x2A00, 1) X(B, SAMPLE_COVERAGE_VALUE, 0x80AA, 1) X(D, POINT_SIZE, 0x0B11, 1)        \
    X(O, POLYGON_OFFSET_CLAMP, 0x8E1B, 1)

enum { GL_STATE_MOST = 600, GL_STATE_UNITS = 20, GL_STATE_BINDINGS = 10 };

typedef struct gl_value { const char *name; int index; double number; } gl_value;
typedef struct gl_snapshot { gl_value values[GL_STATE_MOST]; int count; } gl_snapshot;

/* Functions that gl_backend.h does not load. */
typedef struct gl_more {
    void (GLBK_CALL *StencilFunc)(uint32_t, int32_t, uint32_t);
    void (GLBK_CALL *StencilOp)(uint32_t, uint32_t, uint32_t);
    void (GLBK_CALL *StencilMask)(uint32_t);
    void (GLBK_CALL *LogicOp)(uint32_t);
    void (GLBK_CALL *PrimitiveRestartIndex)(uint32_t);
    void (GLBK_CALL *SampleCoverage)(float, uint8_t);
    void (GLBK_CALL *BlendColor)(float, float, float, float);
    void (GLBK_CALL *ClearColor)(float, float, float, float);
    void (GLBK_CALL *ProvokingVertex)(uint32_t);
    void (GLBK_CALL *GenSamplers)(int32_t, uint32_t *);
    void (GLBK_CALL *DeleteSamplers)(int32_t, const uint32_t *);
    void (GLBK_CALL *SamplerParameteri)(uint32_t, uint32_t, int32_t);
    void (GLBK_CALL *ClipControl)(uint32_t, uint32_t);
    void (GLBK_CALL *PolygonOffsetClamp)(float, float, float);
    void (GLBK_CALL *BlendFuncSeparatei)(uint32_t, uint32_t, uint32_t, uint32_t, uint32_t);
    void (GLBK_CALL *BlendEquationSeparatei)(uint32_t, uint32_t, uint32_t);
    int clip_control, offset_clamp;
} gl_more;

static gl_more gl_extra;

static inline int gl_state_extension(const glbk_context *gl, const char *name)
{
    int32_t count = 0, i;
    gl->gl.GetIntegerv(0x821D /* NUM_EXTENSIONS */, &count);
    for (i = 0; i < count; i++)
        if (strcmp((const char *)gl->gl.GetStringi(0x1F03, (uint32_t)i), name) == 0) return 1;
    return 0;
}

static inline void gl_state_load(gl_test *t)
{
    glbk_proc_fn proc;
#define LOAD(name) proc = ex_gl_get_proc("gl" #name, t->context), memcpy(&gl_extra.name, &proc, sizeof proc)
    LOAD(StencilFunc); LOAD(StencilOp); LOAD(StencilMask); LOAD(LogicOp); LOAD(PrimitiveRestartIndex);
    LOAD(SampleCoverage); LOAD(BlendColor); LOAD(ClearColor); LOAD(ProvokingVertex); LOAD(GenSamplers);
    LOAD(DeleteSamplers); LOAD(SamplerParameteri); LOAD(PolygonOffsetClamp); LOAD(BlendFuncSeparatei);
    LOAD(BlendEquationSeparatei);
#undef LOAD
    proc = ex_gl_get_proc(t->gl.es ? "glClipControlEXT" : "glClipControl", t->context);
    memcpy(&gl_extra.ClipControl, &proc, sizeof proc);
    gl_extra.clip_control = gl_extra.ClipControl &&
                            gl_state_extension(&t->gl, t->gl.es ? "GL_EXT_clip_control" : "GL_ARB_clip_control");
    gl_extra.offset_clamp = !t->gl.es && gl_state_extension(&t->gl, "GL_ARB_polygon_offset_clamp");
}

static inline int gl_state_has(const glbk_context *gl, char who)
{
    switch (who) {
    case 'D': return !gl->es;
    case 'C': return gl->compute;
    case 'K': return gl_extra.clip_control;
    case 'O': return gl_extra.offset_clamp;
    case 'R': return gl->es ? !gl->webgl : gl->version >= 430;
    default: return 1;
    }
}

/* 1: colour masks and blending for each target; 2: blend functions, too. */
static inline int gl_state_targets(const glbk_context *gl)
{
    return gl->es ? gl->version >= 320 ? 2 : 0 : gl->version >= 400 ? 2 : 1;
}

static inline void gl_state_add(gl_snapshot *s, const char *name, int index, double number)
{
    assert_true(s->count < GL_STATE_MOST);
    s->values[s->count].name = name;
    s->values[s->count].index = index;
    s->values[s->count++].number = number;
}

static inline void gl_state_units(const glbk_context *gl, gl_snapshot *s)
{
    static const struct { const char *name; uint32_t what; } bindings[] = {
        { "TEXTURE_BINDING_2D", 0x8069 }, { "TEXTURE_BINDING_2D_ARRAY", 0x8C1D }, { "TEXTURE_BINDING_3D", 0x806A },
        { "TEXTURE_BINDING_CUBE_MAP", 0x8514 }, { "SAMPLER_BINDING", 0x8919 }
    };
    int32_t active, name;
    uint32_t i;
    size_t k;
    gl->gl.GetIntegerv(0x84E0, &active);
    for (i = 0; i < GL_STATE_UNITS; i++) {
        gl->gl.ActiveTexture(GLBK_GL_TEXTURE0 + i);
        for (k = 0; k < sizeof bindings / sizeof bindings[0]; k++) {
            gl->gl.GetIntegerv(bindings[k].what, &name);
            gl_state_add(s, bindings[k].name, (int)i, name);
        }
    }
    gl->gl.ActiveTexture((uint32_t)active);
}

static inline void gl_state_buffers(const glbk_context *gl, gl_snapshot *s)
{
    static const struct { const char *name[3]; uint32_t what; char who; } kinds[] = {
        { { "UNIFORM_BUFFER", "UNIFORM_BUFFER_START", "UNIFORM_BUFFER_SIZE" }, 0x8A28, 'B' },
        { { "SHADER_STORAGE_BUFFER", "SHADER_STORAGE_BUFFER_START", "SHADER_STORAGE_BUFFER_SIZE" }, 0x90D3, 'C' }
    };
    size_t k;
    uint32_t i;
    for (k = 0; k < 2; k++)
        for (i = 0; i < (k ? 8u : GL_STATE_BINDINGS) && gl_state_has(gl, kinds[k].who); i++) {
            int32_t name;
            int64_t start, size;
            gl->gl.GetIntegeri_v(kinds[k].what, i, &name);
            gl->gl.GetInteger64i_v(kinds[k].what + 1, i, &start);
            gl->gl.GetInteger64i_v(kinds[k].what + 2, i, &size);
            gl_state_add(s, kinds[k].name[0], (int)i, name);
            gl_state_add(s, kinds[k].name[1], (int)i, (double)start);
            gl_state_add(s, kinds[k].name[2], (int)i, (double)size);
        }
}

static inline void gl_state_images(const glbk_context *gl, gl_snapshot *s)
{
    static const struct { const char *name; uint32_t what; } parts[] = {
        { "IMAGE_BINDING_NAME", 0x8F3A }, { "IMAGE_BINDING_LEVEL", 0x8F3B }, { "IMAGE_BINDING_LAYERED", 0x8F3C },
        { "IMAGE_BINDING_LAYER", 0x8F3D }, { "IMAGE_BINDING_ACCESS", 0x8F3E }, { "IMAGE_BINDING_FORMAT", 0x906E }
    };
    uint32_t i;
    size_t k;
    for (i = 0; i < 8 && gl_state_has(gl, 'C'); i++)
        for (k = 0; k < sizeof parts / sizeof parts[0]; k++) {
            int32_t value;
            gl->gl.GetIntegeri_v(parts[k].what, i, &value);
            gl_state_add(s, parts[k].name, (int)i, value);
        }
}

static inline void gl_state_read(const glbk_context *gl, gl_snapshot *s)
{
    int32_t n[4];
    float f[4];
    int i;

    s->count = 0;
#define CAP(who, name, what) if (gl_state_has(gl, *#who)) gl_state_add(s, #name, 0, gl->gl.IsEnabled(what));
    GL_STATE_CAPS(CAP)
#undef CAP
#define INTEGER(who, name, what, count)                                         \
    if (gl_state_has(gl, *#who)) {                                                  \
        gl->gl.GetIntegerv(what, n);                                            \
        for (i = 0; i < (count); i++) gl_state_add(s, #name, i, n[i]);                   \
    }
    GL_STATE_INTEGERS(INTEGER)
#undef INTEGER
#define FLOAT(who, name, what, count)                                           \
    if (gl_state_has(gl, *#who)) {                                                  \
        gl->gl.GetFloatv(what, f);                                              \
        for (i = 0; i < (count); i++) gl_state_add(s, #name, i, (double)f[i]);           \
    }
    GL_STATE_FLOATS(FLOAT)
#undef FLOAT
    for (i = 0; i < (int)gl->max_targets && gl_state_targets(gl); i++) {
        static const uint32_t blends[6] = { 0x80C9, 0x80C8, 0x80CB, 0x80CA, 0x8009, 0x883D };
        uint8_t mask[4];
        int k;
        gl->gl.GetBooleani_v(0x0C23, (uint32_t)i, mask);
        for (k = 0; k < 4; k++) gl_state_add(s, "COLOR_WRITEMASK of a target", 4 * i + k, mask[k]);
        gl_state_add(s, "BLEND of a target", i, gl->gl.IsEnabledi(0x0BE2, (uint32_t)i));
        for (k = 0; k < 6 && gl_state_targets(gl) == 2; k++) {
            gl->gl.GetIntegeri_v(blends[k], (uint32_t)i, n);
            gl_state_add(s, "BLEND_SRC_RGB ... BLEND_EQUATION_ALPHA of a target", 6 * i + k, n[0]);
        }
    }
    gl_state_units(gl, s);
    gl_state_buffers(gl, s);
    gl_state_images(gl, s);
}

static inline void gl_state_assert_same(const gl_snapshot *a, const gl_snapshot *b, const char *call)
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

typedef struct gl_hostile {
    glbk_texture texture, array, cover, shadow, shadows;    /* the last two: of a kind that no sampler here is of */
    glbk_target  target;
    glbk_buffer  buffer, indices, pixels;
    glbk_program program;
    uint32_t     samplers[2], vertex_array;
} gl_hostile;

static inline void gl_hostile_make(gl_test *t, gl_hostile *h)
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
    d.format = GLBK_FORMAT_DEPTH24;
    d.sampling = GLBK_SAMPLING_COMPARE;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &h->shadows));
    d.layers = 0;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &h->shadow));
    targets.color[0] = &h->cover;
    assert_glbk(t, glbk_target_create(&t->gl, &targets, &h->target));
    assert_glbk(t, glbk_buffer_create(&t->gl, 4096, NULL, &h->buffer));
    assert_glbk(t, glbk_indices_create(&t->gl, 4096, NULL, &h->indices));
    assert_glbk(t, glbk_buffer_create(&t->gl, 4096, NULL, &h->pixels));
    assert_glbk(t, glbk__program_create(&t->gl, NULL, "copy.frag", "TO_COLOR=1", &h->program));
    gl_extra.GenSamplers(2, h->samplers);
    gl_extra.SamplerParameteri(h->samplers[0], 0x2802, 0x2901);    /* repeats, where our textures clamp */
    gl_extra.SamplerParameteri(h->samplers[0], 0x884C, 0x884E);     /* COMPARE_MODE, COMPARE_REF_TO_TEXTURE */
    gl_extra.SamplerParameteri(h->samplers[1], 0x884C, 0x884E);
    t->gl.gl.GenVertexArrays(1, &h->vertex_array);
}

static inline void gl_hostile_caps(const glbk_context *gl)
{
#define CAP(who, name, what)                                                                    \
    if (gl_state_has(gl, *#who)) {                                                                  \
        if (gl->gl.IsEnabled(what)) gl->gl.Disable(what);                                       \
        else gl->gl.Enable(what);                                                               \
    }
    GL_STATE_CAPS(CAP)
#undef CAP
}

static inline void gl_hostile_values(const glbk_context *gl)
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
    if (gl->webgl) gl->gl.DepthRangef(0.3f, 0.9f);              /* knows no other order */
    else if (gl->es) gl->gl.DepthRangef(0.9f, 0.3f);
    else gl->gl.DepthRange((double)0.9f, (double)0.3f);
    gl_extra.StencilFunc(0x0200 /* NEVER */, 3, 0x55);
    gl_extra.StencilOp(0x1E01, 0x1E02, 0x150A);
    gl_extra.StencilMask(0x33);
    gl_extra.SampleCoverage(0.25f, 1);
    gl_extra.BlendColor(0.1f, 0.2f, 0.3f, 0.4f);
    gl_extra.ClearColor(0.5f, 0.6f, 0.7f, 0.8f);
    if (gl_state_has(gl, 'K')) gl_extra.ClipControl(0x8CA2 /* UPPER_LEFT */, 0x935F /* ZERO_TO_ONE */);
    if (gl_state_has(gl, 'O')) gl_extra.PolygonOffsetClamp(3, 100000, 0.5f);
    if (gl_state_targets(gl)) {
        gl->gl.ColorMaski(1, 1, 0, 0, 0);
        gl->gl.Disablei(0x0BE2, 2);
    }
    if (gl_state_targets(gl) == 2) {
        gl_extra.BlendFuncSeparatei(1, 0, 0x0301, 1, 0x0303);
        gl_extra.BlendEquationSeparatei(2, 0x8006, 0x8008);
    }
    if (gl->es) return;
    gl->gl.PolygonMode(0x0408, 0x1B01 /* LINE */);
    gl->gl.PointSize(13);
    gl->gl.ClampColor(0x891C, 1);
    gl_extra.LogicOp(0x1506 /* XOR */);
    gl_extra.PrimitiveRestartIndex(1);
    gl_extra.ProvokingVertex(0x8E4D /* FIRST */);
}

static inline void gl_hostile_bindings(const glbk_context *gl, gl_hostile *h)
{
    uint32_t i;
    for (i = 0; i < GL_STATE_UNITS; i++) {
        gl->gl.ActiveTexture(GLBK_GL_TEXTURE0 + i);
        gl->gl.BindTexture(GLBK_GL_TEXTURE_2D, h->shadow.name);
        gl->gl.BindTexture(GLBK_GL_TEXTURE_2D_ARRAY, h->shadows.name);
        gl->gl.BindSampler(i, h->samplers[i % 2]);
    }
    gl->gl.ActiveTexture(GLBK_GL_TEXTURE0 + 9);
    for (i = 0; i < GL_STATE_BINDINGS; i++)
        gl->gl.BindBufferRange(GLBK_GL_UNIFORM_BUFFER, i, h->buffer.name, 256 * (ptrdiff_t)i, 256);
    for (i = 0; i < 8 && gl->compute; i++)
        gl->gl.BindBufferRange(GLBK_GL_SHADER_STORAGE_BUFFER, i, h->buffer.name, 256 * (ptrdiff_t)i, 512);
    for (i = 0; i < 8 && gl->compute; i++)
        gl->gl.BindImageTexture(i, i % 2 ? h->array.name : h->texture.name, 0, 0, (int32_t)(i % 2), 0x88B8 + i % 3,
                                0x8058 /* RGBA8 */);
    if (gl->compute) gl->gl.BindBuffer(0x90EE /* DISPATCH_INDIRECT_BUFFER */, h->buffer.name);
    gl->gl.BindBufferBase(GLBK_GL_UNIFORM_BUFFER, 1, h->pixels.name);
    gl->gl.BindVertexArray(h->vertex_array);
    gl->gl.BindBuffer(GLBK_GL_ELEMENT_ARRAY_BUFFER, h->indices.name);
    gl->gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, h->buffer.name);
    gl->gl.BindBuffer(GLBK_GL_COPY_WRITE_BUFFER, h->buffer.name);
    gl->gl.BindBuffer(0x88EC /* PIXEL_UNPACK_BUFFER */, h->pixels.name);
    gl->gl.BindBuffer(0x88EB /* PIXEL_PACK_BUFFER */, h->pixels.name);
    gl->gl.BindFramebuffer(GLBK_GL_FRAMEBUFFER, h->target.name);
    gl->gl.ReadBuffer(GLBK_GL_COLOR_ATTACHMENT0);
    gl->gl.UseProgram(h->program.name);
}

static inline void gl_hostile_set(gl_test *t, gl_hostile *h)
{
    gl_hostile_caps(&t->gl);
    gl_hostile_values(&t->gl);
    gl_hostile_bindings(&t->gl, h);
}

static struct { int on; gl_snapshot before, after; glbk_state saved; } gl_watched;

/* Ends watching, too. */
static inline void gl_hostile_free(gl_test *t, gl_hostile *h)
{
    gl_watched.on = 0;
    t->gl.gl.UseProgram(0);
    t->gl.gl.BindBuffer(0x88EC, 0);
    t->gl.gl.BindBuffer(0x88EB, 0);
    t->gl.gl.DeleteVertexArrays(1, &h->vertex_array);
    gl_extra.DeleteSamplers(2, h->samplers);
    glbk_program_free(&t->gl, &h->program);
    glbk_target_free(&t->gl, &h->target);
    glbk_buffer_free(&t->gl, &h->buffer);
    glbk_buffer_free(&t->gl, &h->indices);
    glbk_buffer_free(&t->gl, &h->pixels);
    glbk_texture_free(&t->gl, &h->texture);
    glbk_texture_free(&t->gl, &h->array);
    glbk_texture_free(&t->gl, &h->cover);
    glbk_texture_free(&t->gl, &h->shadow);
    glbk_texture_free(&t->gl, &h->shadows);
}

/* ---- calls that are watched ---- */


static inline void gl_state_watch(gl_test *t, int on)
{
    gl_state_load(t);
    gl_watched.on = on;
}

static inline void gl_watch_begin(gl_test *t, int saves)
{
    if (gl_watched.on) gl_state_read(&t->gl, &gl_watched.before);
    if (gl_watched.on && saves) glbk_state_save(&t->gl, &gl_watched.saved);
    gl_count_reset();
}

static inline void gl_watch_end(gl_test *t, int saves, const char *call)
{
    if (gl_counted.on && saves && gl_counted.asks > gl_counted.allowed)
        fail_msg("%s asks GL %d times", call, gl_counted.asks);
    if (!gl_watched.on) return;
    if (saves) glbk_state_restore(&t->gl, &gl_watched.saved);
    gl_state_read(&t->gl, &gl_watched.after);
    gl_state_assert_same(&gl_watched.before, &gl_watched.after, call);
    assert_int_equal(t->gl.gl.GetError(), 0);
}

/* Does what is given and compares the state before and after. */
#define GL_SAME(t, ...) do { gl_watch_begin(t, 0); __VA_ARGS__; gl_watch_end(t, 0, #__VA_ARGS__); } while (0)
/* The same with glbk_state_save before and glbk_state_restore after a call that may touch state. */
#define GL_SAVED(t, ...) do { gl_watch_begin(t, 1); __VA_ARGS__; gl_watch_end(t, 1, #__VA_ARGS__); } while (0)

/* For a chain of calls that ends at the first failure. */
#define GL_THEN_SAME(t, result, ...) \
    do { if ((result) == GLBK_OK) GL_SAME(t, (result) = (__VA_ARGS__)); } while (0)
#define GL_THEN_SAVED(t, result, ...) \
    do { if ((result) == GLBK_OK) GL_SAVED(t, (result) = (__VA_ARGS__)); } while (0)

#endif
