/* gl_backend.h when GL fails: functions that are missing, memory that runs out, contexts that are old, lost or not
   there, names that leak. */
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
#include "gl_fake.h"

/* ---- a loader that withholds, replaces and counts ---- */

typedef struct loader {
    ex_gl      *context;
    const char *missing;            /* no such function */
    const char *version;            /* instead of GL_VERSION; "" = no context */
    const char *extensions;         /* instead of the driver's, a letter each */
    int         nameless;           /* no GL_RENDERER */
    uint32_t    limit;              /* that glGetIntegerv answers by most */
    int32_t     most;
} loader;

static loader l;                     /* one for all: GL hands its functions no pointer of ours */

static const uint8_t *(GLBK_CALL *real_get_string)(uint32_t name);

static const uint8_t *GLBK_CALL fake_get_string(uint32_t name)
{
    if (name == 0x1F02 && l.version) return l.version[0] ? (const uint8_t *)l.version : NULL;
    if (name == 0x1F01 && l.nameless) return NULL;
    return real_get_string(name);
}

static void (GLBK_CALL *real_get_integers)(uint32_t name, int32_t *out);
static const uint8_t *(GLBK_CALL *real_get_stringi)(uint32_t name, uint32_t index);

static void GLBK_CALL fake_get_integers(uint32_t name, int32_t *out)
{
    real_get_integers(name, out);
    if (name == l.limit) *out = l.most;
    if (name == 0x821D /* NUM_EXTENSIONS */ && l.extensions) *out = (int32_t)strlen(l.extensions);
}

/* One extension a letter. */
static const uint8_t *GLBK_CALL fake_get_stringi(uint32_t name, uint32_t index)
{
    const char *text = NULL;
    if (name != 0x1F03 || !l.extensions) return real_get_stringi(name, index);
    switch (l.extensions[index]) {
    case 't': text = "GL_EXT_color_buffer_float"; break;
    case 'b': text = "GL_EXT_float_blend"; break;
    case 'l': text = "GL_OES_texture_float_linear"; break;
    case 'c': text = "GL_ARB_clip_control"; break;
    default: break;                 /* a driver that loses count */
    }
    return (const uint8_t *)text;
}

static glbk_proc_fn load(const char *name, void *user)
{
    glbk_proc_fn proc = gl_get_proc()(name, l.context);
    (void)user;
    if (l.missing && strcmp(name, l.missing) == 0) return NULL;
    if (strcmp(name, "glGetIntegerv") == 0) {
        memcpy(&real_get_integers, &proc, sizeof proc);
        return (glbk_proc_fn)fake_get_integers;
    }
    if (strcmp(name, "glGetStringi") == 0) {
        memcpy(&real_get_stringi, &proc, sizeof proc);
        return (glbk_proc_fn)fake_get_stringi;
    }
    if (strcmp(name, "glGetString") != 0) return proc;
    memcpy(&real_get_string, &proc, sizeof proc);
    return (glbk_proc_fn)fake_get_string;
}

static glbk_desc desc_of(gl_test *t)
{
    glbk_desc desc = { 0 };
    memset(&l, 0, sizeof l);
    l.context = t->context;
    desc.get_proc_fn = load;
    desc.system.log = gl_log;
    desc.system.user = t->log;
    return desc;
}

static void every_function_missing_once_is_named(void **state)
{
    GL_TEST(t, state)
    glbk_desc desc = desc_of(t);
    const char *name = glbk__function_names;
    char whole[64];
    size_t i, refused = 0;

    for (i = 0; i < sizeof glbk__function_groups; i++, name += strlen(name) + 1) {
        const int group = glbk__function_groups[i];
        glbk_context ctx;
        glbk_result result;
        snprintf(whole, sizeof whole, "gl%s", strcmp(name, "Barrier") == 0 ? "MemoryBarrier" : name);
        l.missing = whole;
        if (t->gl.es && group == GLBK__GROUP_CLIP) l.missing = "glClipControlEXT";
        result = glbk_init(&ctx, &desc);
        if (group == GLBK__GROUP_CORE || group == (t->gl.es ? GLBK__GROUP_ES : GLBK__GROUP_DESK) ||
            (group == GLBK__GROUP_TARGETS && !t->gl.es)) {
            assert_int_equal(result, GLBK_ERR_FUNCTION);
            assert_non_null(strstr(t->log, l.missing));
            assert_null(ctx.renderer);
            refused++;
        } else {
            assert_int_equal(result, GLBK_OK);      /* the core path works without */
            if (group == GLBK__GROUP_COMPUTE) assert_int_equal(ctx.compute, 0);
            if (group == GLBK__GROUP_CLIP) assert_int_equal(ctx.clip_control, 0);
            if (group == GLBK__GROUP_TARGETS) assert_int_equal(ctx.each_target, 0);
            if (group == GLBK__GROUP_TARGETS || group == GLBK__GROUP_BLENDS) assert_int_equal(ctx.each_blend, 0);
            if (group == GLBK__GROUP_CLAMP) assert_int_equal(ctx.offset_clamp, 0);
        }
        glbk_free(&ctx);
    }
    l.missing = NULL;
    assert_true(refused > 80);
}

static void versions_are_read(void **state)
{
    GL_TEST(t, state)
    static const struct { const char *text; int desk, es; } cases[] = {
        { "3.2.0 NVIDIA 390.1", 320, 0 }, { "2.1 Mesa 22", 210, 0 }, { "OpenGL ES 2.0 Mesa 22.3.6", 0, 200 },
        { "OpenGL ES-CM 1.1", 0, 110 }, { "", 0, 0 }, { "nonsense", 0, 0 }, { "99999999999.1", 0, 0 }
    };
    glbk_desc desc = desc_of(t);
    glbk_context ctx;
    size_t i;

    for (i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        l.version = cases[i].text;
        assert_int_equal(glbk_init(&ctx, &desc), cases[i].text[0] ? GLBK_ERR_OLD_CONTEXT : GLBK_ERR_CONTEXT);
        assert_non_null(strstr(t->log, cases[i].text[0] ? cases[i].text : "glbk_init: no GL context is current"));
        t->log[0] = 0;
    }
    l.version = t->gl.es ? "OpenGL ES 3.0 (WebGL 2.0 (OpenGL ES 3.0 Chromium))" : "3.3 (Core Profile) Mesa";
    assert_int_equal(glbk_init(&ctx, &desc), GLBK_OK);
    assert_int_equal(ctx.version, t->gl.es ? 300 : 330);
    assert_int_equal(ctx.es, t->gl.es);
    assert_int_equal(ctx.webgl, t->gl.es);
    assert_int_equal(ctx.compute, 0);               /* although the loader has the functions */
    glbk_free(&ctx);
    l.version = NULL;
    desc.core_only = 1;
    assert_int_equal(glbk_init(&ctx, &desc), GLBK_OK);
    assert_int_equal(ctx.compute, 0);
    glbk_free(&ctx);
    if (gl_this_way()->bit == GL_CORE45) assert_int_equal(t->gl.compute, 1);
    if (gl_this_way()->bit == GL_CORE33) assert_int_equal(t->gl.version, 330);
    if (t->gl.es) {         /* Mesa is told to give this very version; other drivers give the latest one they have */
        const uint32_t asked = gl_this_way()->bit == GL_ES32 ? 320 : 300;
        assert_true(t->gl.version == asked || (t->gl.version > asked && !gl_is_mesa(t)));
    }
}

/* What a context can do follows from its version and the names of its extensions alone. */
static void features_are_read(void **state)
{
    GL_TEST(t, state)
    static const struct { const char *version, *extensions; int has[4]; } desk[] = {
        { "3.3.0", "", { 1, 1, 1, 0 } }, { "3.3.0", "xc", { 1, 1, 1, 1 } }, { "4.5.0", "", { 1, 1, 1, 1 } }
    }, es[] = {
        { "OpenGL ES 3.0", "", { 0, 0, 0, 0 } }, { "OpenGL ES 3.0", "b", { 0, 0, 0, 0 } },
        { "OpenGL ES 3.0", "t", { 1, 0, 0, 0 } },
        { "OpenGL ES 3.1", "xtbl", { 1, 1, 1, 0 } }, { "OpenGL ES 3.2", "", { 1, 1, 0, 0 } },
        { "OpenGL ES 3.2", "lc", { 1, 1, 1, 0 } }
    };
    glbk_desc desc = desc_of(t);
    glbk_context ctx;
    size_t i;

    for (i = 0; i < (t->gl.es ? sizeof es / sizeof es[0] : sizeof desk / sizeof desk[0]); i++) {
        l.version = t->gl.es ? es[i].version : desk[i].version;
        l.extensions = t->gl.es ? es[i].extensions : desk[i].extensions;
        assert_int_equal(glbk_init(&ctx, &desc), GLBK_OK);
        const int *wanted = t->gl.es ? es[i].has : desk[i].has;
        if (ctx.float_targets != wanted[0] || ctx.float_blend != wanted[1] || ctx.float_linear != wanted[2] ||
            ctx.clip_control != wanted[3])
            fail_msg("%s with \"%s\": targets %d, blend %d, linear %d, clip %d", l.version, l.extensions,
                     ctx.float_targets, ctx.float_blend, ctx.float_linear, ctx.clip_control);
        glbk_free(&ctx);
    }
    desc = desc_of(t);
    l.nameless = 1;
    l.limit = 0x8824;               /* MAX_DRAW_BUFFERS */
    l.most = 32;
    assert_int_equal(glbk_init(&ctx, &desc), GLBK_OK);
    assert_string_equal(ctx.renderer, "");
    assert_int_equal(ctx.max_targets, 8);           /* as many as glbk_state has room for */
    glbk_free(&ctx);
    l.limit = 0x8B4D;               /* MAX_COMBINED_TEXTURE_IMAGE_UNITS */
    l.most = 20;
    desc.first_unit = 4;
    assert_int_equal(glbk_init(&ctx, &desc), GLBK_OK);
    glbk_free(&ctx);
    desc.first_unit = 5;
    assert_int_equal(glbk_init(&ctx, &desc), GLBK_ERR_LIMIT);
    assert_string_equal(t->log, "glbk_init: desc.first_unit is 5; it must be 0..4");
    desc.first_unit = 0xffffffffu;  /* with 16 more, 15 */
    assert_int_equal(glbk_init(&ctx, &desc), GLBK_ERR_LIMIT);
    desc.first_unit = 0;
    l.limit = 0x8A2F;               /* MAX_UNIFORM_BUFFER_BINDINGS */
    desc.first_block = 12;
    assert_int_equal(glbk_init(&ctx, &desc), GLBK_OK);
    glbk_free(&ctx);
    desc.first_block = 13;
    assert_int_equal(glbk_init(&ctx, &desc), GLBK_ERR_LIMIT);
    assert_string_equal(t->log, "glbk_init: desc.first_block is 13; it must be 0..12");
    desc.first_block = 0xffffffffu;
    assert_int_equal(glbk_init(&ctx, &desc), GLBK_ERR_LIMIT);
}

static uint32_t GLBK_CALL unsupported(uint32_t target)
{
    (void)target;
    return 0x8CDD;
}

/* A combination of formats that a driver refuses: its number in the log, no framebuffer left, the bound one again. */
static void targets_that_a_driver_refuses_leave_nothing(void **state)
{
    GL_TEST(t, state)
    gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_RGBA8, 4, 4, 0);
    glbk_target_desc d = { { &c.color }, { 0 }, NULL, 0, 0 };
    glbk_target target;
    int32_t bound = -1;
    t->gl.gl.BindFramebuffer(GLBK_GL_DRAW_FRAMEBUFFER, c.target.name);
    fake_begin(t, 0);
    t->gl.gl.CheckFramebufferStatus = unsupported;
    memset(&target, 0xA5, sizeof target);
    assert_int_equal(glbk_target_create(&t->gl, &d, &target), GLBK_ERR_TARGET);
    assert_non_null(strstr(t->log, "framebuffer status 0x8cdd"));
    assert_true(!target.name && !target.width && !target.count);
    assert_int_equal(fake.live, 0);
    t->gl.gl = fake.real;
    t->gl.gl.GetIntegerv(0x8CA6 /* DRAW_FRAMEBUFFER_BINDING */, &bound);
    assert_int_equal(bound, c.target.name);
    gl_canvas_free(t, &c);
}

static void *no_memory(size_t bytes, void *user);

static void bad_descs_of_a_context_are_refused(void **state)
{
    GL_TEST(t, state)
    glbk_desc desc = desc_of(t);
    glbk_context ctx;

    assert_int_equal(glbk_init(NULL, &desc), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_init(&ctx, NULL), GLBK_ERR_ARGUMENT);
    desc.system.allocator.alloc_fn = no_memory;
    assert_int_equal(glbk_init(&ctx, &desc), GLBK_ERR_DESC);
    assert_string_equal(t->log, "glbk_init: desc.system.allocator has one of its two functions");
    desc.system.allocator.alloc_fn = NULL;
    desc.get_proc_fn = NULL;
    assert_int_equal(glbk_init(&ctx, &desc), GLBK_ERR_DESC);
    assert_string_equal(t->log, "glbk_init: desc.get_proc_fn is NULL");
    desc = desc_of(t);
    l.missing = "glGetError";
    desc.system.log = NULL;                         /* nobody is told */
    t->log[0] = 0;
    assert_int_equal(glbk_init(&ctx, &desc), GLBK_ERR_FUNCTION);
    assert_string_equal(t->log, "");
}

/* ---- errors put into GL's mouth; names counted ---- */

/* One object of each kind; made in order, the first failure is returned. */
typedef struct things {
    glbk_texture texture, table;
    glbk_buffer  buffer;
    glbk_target  target;
    glbk_program program, compiled;
} things;

static glbk_result make(gl_test *t, things *x)
{
    static const uint32_t words[3000];
    glbk_texture_desc d = { 0 };
    glbk_target_desc targets = { 0 };
    glbk_source s = { 0 };
    glbk_result result;

    memset(x, 0, sizeof *x);
    d.format = GLBK_FORMAT_RGBA8;
    d.width = d.height = 16;
    d.sampling = GLBK_SAMPLING_MIPMAPS;
    targets.color[0] = &x->texture;
    s.fragment = "layout(location = 0) out vec4 c;\nvoid main() { c = vec4(1.0); }\n";
    result = glbk_texture_create(&t->gl, &d, &x->texture);
    if (result == GLBK_OK) result = glbk__table_create(&t->gl, GLBK_FORMAT_R32UI, words, 3000, &x->table);
    if (result == GLBK_OK) result = glbk__table_update(&t->gl, &x->table, 100, 2000, words);
    if (result == GLBK_OK) result = glbk_buffer_create(&t->gl, sizeof words, words, &x->buffer);
    if (result == GLBK_OK) result = glbk_buffer_update(&t->gl, &x->buffer, 4, 400, words);
    if (result == GLBK_OK) result = glbk_target_create(&t->gl, &targets, &x->target);
    if (result == GLBK_OK) result = glbk__program_create(&t->gl, NULL, "copy.frag", "TO_COLOR=1", &x->program);
    if (result == GLBK_OK) result = glbk_program_compile(&t->gl, &s, &x->compiled);
    return result;
}

static void destroy(glbk_context *gl, things *x)
{
    glbk_program_free(gl, &x->compiled);
    glbk_program_free(gl, &x->program);
    glbk_target_free(gl, &x->target);
    glbk_buffer_free(gl, &x->buffer);
    glbk_texture_free(gl, &x->table);
    glbk_texture_free(gl, &x->texture);
}

/* The n-th time that glGetError is asked it says error; n = 1, 2, ... until all is made without. */
static int fail_everywhere(gl_test *t, uint32_t error, glbk_result first_call, glbk_result later)
{
    things x;
    int seen[2] = { 0, 0 };
    glbk_result result;

    t->gl.check = 1;
    fake_begin(t, 0);
    fake.error = error;
    for (fake.at = 1;; fake.at++) {
        fake.calls = 0;
        t->log[0] = 0;
        result = make(t, &x);
        if (t->gl.lost) {
            assert_int_equal(result, GLBK_ERR_LOST);
            t->gl.lost = 0;         /* in truth it is not */
        }
        destroy(&t->gl, &x);
        if (result == GLBK_ERR_LOST) fake.live = 0;     /* names of a lost context are not deleted */
        assert_int_equal(fake.live, 0);
        if (result == GLBK_OK) break;
        assert_true(result == first_call || result == later);
        seen[result == later]++;
        if (result != GLBK_ERR_LOST) assert_true(t->log[0]);
        assert_true(fake.at < 200);
    }
    t->gl.gl = fake.real;
    assert_true(seen[1] >= 8);
    if (first_call != later) assert_true(seen[0] >= 8);
    return fake.at;
}

static void out_of_memory_is_returned_wherever_it_comes(void **state)
{
    GL_TEST(t, state)
    fail_everywhere(t, 0x0505, GLBK_ERR_PENDING, GLBK_ERR_GL_MEMORY);
}

static void an_error_of_gl_is_returned_wherever_it_comes(void **state)
{
    GL_TEST(t, state)
    fail_everywhere(t, 0x0502, GLBK_ERR_PENDING, GLBK_ERR_GL);
}

static void without_a_shader_no_program_is_made(void **state)
{
    GL_TEST(t, state)
    things x;
    fake_begin(t, 0);
    fake.no_shader = 1;
    assert_int_equal(make(t, &x), GLBK_ERR_GL);
    destroy(&t->gl, &x);
    assert_int_equal(fake.live, 0);
    fake.no_shader = 0;
    fake.no_program = 1;
    assert_int_equal(make(t, &x), GLBK_ERR_GL);
    destroy(&t->gl, &x);
    assert_int_equal(fake.live, 0);
    t->gl.gl = fake.real;
}

static void *no_memory(size_t size, void *user)
{
    (void)size, (void)user;
    return NULL;
}

static void release(void *memory, void *user)
{
    (void)user;
    free(memory);
}

static void a_failing_allocator_leaves_no_object(void **state)
{
    GL_TEST(t, state)
    things x;
    t->gl.system.allocator.alloc_fn = no_memory;
    t->gl.system.allocator.free_fn = release;
    fake_begin(t, 0);
    assert_int_equal(make(t, &x), GLBK_ERR_ALLOC);
    destroy(&t->gl, &x);
    assert_int_equal(fake.live, 0);
    t->gl.gl = fake.real;
}

/* A texture of terabytes, without help. A driver that takes memory when it is used may make it all the same. */
static void real_out_of_memory_is_returned(void **state)
{
    GL_TEST(t, state)
    glbk_texture_desc d = { 0 };
    glbk_texture texture;
    glbk_result result;
    d.format = GLBK_FORMAT_RGBA32F;
    d.width = d.height = t->gl.max_side;
    d.layers = t->gl.max_layers;
    t->expected_errors = ~0u;
    result = glbk_texture_create(&t->gl, &d, &texture);
    if (result == GLBK_OK) {
        assert_false(gl_is_mesa(t));
        glbk_texture_free(&t->gl, &texture);
        return;
    }
    assert_true(result == GLBK_ERR_GL_MEMORY || result == GLBK_ERR_GL);
    assert_int_equal(texture.name, 0);
    assert_non_null(strstr(t->log, "GL error 0x05"));
}

static void pending_errors_are_not_taken_for_ours(void **state)
{
    GL_TEST(t, state)
    things x;
    t->expected_errors = ~0u;
    t->gl.gl.Enable(0xFFFF);
    assert_int_equal(make(t, &x), GLBK_ERR_PENDING);
    assert_non_null(strstr(t->log, "0x0500"));
    assert_glbk(t, make(t, &x));
    destroy(&t->gl, &x);
    t->gl.gl.Enable(0xFFFF);
    assert_int_equal(glbk_check(&t->gl), GLBK_ERR_GL);
    assert_int_equal(glbk_check(&t->gl), GLBK_OK);
    assert_int_equal(glbk_check(NULL), GLBK_ERR_ARGUMENT);
}

/* A frame's calls leave the flag to glbk_check, or with desc.check ask for it; what creates or reads always does. */
static void updates_ask_for_errors_only_when_told(void **state)
{
    GL_TEST(t, state)
    const uint32_t zeros[4] = { 0, 0, 0, 0 };
    glbk_texture table;
    glbk_buffer buffer, none;
    glbk_context checked;
    glbk_desc desc;
    assert_glbk(t, glbk__table_create(&t->gl, GLBK_FORMAT_RGBA32UI, zeros, 1, &table));
    assert_glbk(t, glbk_buffer_create(&t->gl, sizeof zeros, zeros, &buffer));
    memset(&desc, 0, sizeof desc);
    desc.get_proc_fn = gl_get_proc();
    desc.user = t->context;
    desc.system.log = gl_log;
    desc.system.user = t->log;
    desc.check = 1;
    assert_glbk(t, glbk_init(&checked, &desc));
    t->expected_errors = ~0u;
    t->gl.gl.Enable(0xFFFF);
    assert_glbk(t, glbk__table_update(&t->gl, &table, 0, 1, zeros));
    assert_glbk(t, glbk_texture_update(&t->gl, &table, &(glbk_box){ 0, 0, 0, 0, 1, 1, 1 }, zeros));
    assert_glbk(t, glbk_buffer_update(&t->gl, &buffer, 0, sizeof zeros, zeros));
    assert_int_equal(glbk_buffer_create(&t->gl, 4, NULL, &none), GLBK_ERR_PENDING);     /* takes it */
    assert_glbk(t, glbk_buffer_create(&t->gl, 4, NULL, &none));
    glbk_buffer_free(&t->gl, &none);
    t->gl.gl.Enable(0xFFFF);
    assert_glbk(t, glbk_buffer_update(&t->gl, &buffer, 0, 4, zeros));
    assert_int_equal(glbk_check(&t->gl), GLBK_ERR_GL);
    assert_non_null(strstr(t->log, "0x0500"));
    t->gl.gl.Enable(0xFFFF);
    assert_int_equal(glbk__table_update(&checked, &table, 0, 1, zeros), GLBK_ERR_PENDING);
    t->gl.gl.Enable(0xFFFF);
    assert_int_equal(glbk_texture_update(&checked, &table, &(glbk_box){ 0, 0, 0, 0, 1, 1, 1 }, zeros),
                     GLBK_ERR_PENDING);
    t->gl.gl.Enable(0xFFFF);
    assert_int_equal(glbk_buffer_update(&checked, &buffer, 0, sizeof zeros, zeros), GLBK_ERR_PENDING);
    assert_glbk(t, glbk_buffer_update(&checked, &buffer, 0, sizeof zeros, zeros));
    glbk_texture_free(&t->gl, &table);
    glbk_buffer_free(&t->gl, &buffer);
    glbk_free(&checked);
}

static uint32_t GLBK_CALL always_error(void) { return 0x0502; }

static void an_error_for_ever_ends(void **state)
{
    GL_TEST(t, state)
    things x;
    glbk_functions real = t->gl.gl;
    t->gl.gl.GetError = always_error;
    assert_int_equal(make(t, &x), GLBK_ERR_PENDING);
    t->gl.gl = real;
}

/* ---- lifetimes ---- */

static void a_thousand_cycles_leave_nothing(void **state)
{
    GL_TEST(t, state)
    things x;
    uint32_t i;
    int before, with;
    glbk_functions real = t->gl.gl;
#ifdef __EMSCRIPTEN__
    const int made = 6;             /* six objects; Emscripten forgets a shader's name as it is deleted */
#else
    const int made = 10;            /* six objects, four shaders of programs */
#endif

    before = gl_names_in_use(t);
    fake_begin(t, 0);
    for (i = 0; i < 1000; i++) {
        /* Programs are slow to make and are the same each time: every 20th round. */
        if (i % 20 == 0) {
            assert_glbk(t, make(t, &x));
            with = gl_names_in_use(t);
            assert_int_equal(with, before + made);  /* the count counts */
        } else {
            static const unsigned char texels[64];
            glbk_texture_desc d = { GLBK_FORMAT_R8UI, 8, 8, 0, 0, GLBK_SAMPLING_DEFAULT, 0, texels };
            glbk_target_desc targets = { { 0 }, { 0 }, NULL, 0, 0 };
            memset(&x, 0, sizeof x);
            targets.color[0] = &x.texture;
            assert_glbk(t, glbk_texture_create(&t->gl, &d, &x.texture));
            assert_glbk(t, glbk_buffer_create(&t->gl, 64, texels, &x.buffer));
            assert_glbk(t, glbk_target_create(&t->gl, &targets, &x.target));
        }
        destroy(&t->gl, &x);
        assert_int_equal(fake.live, 0);
    }
    t->gl.gl = real;
    assert_int_equal(gl_names_in_use(t), before);
}

static void contexts_come_and_go(void **state)
{
    GL_TEST(t, state)
    glbk_desc desc = desc_of(t);
    int i, before = gl_names_in_use(t);
    for (i = 0; i < 1000; i++) {
        glbk_context ctx;
        glbk_pass pass = { 0 };
        assert_int_equal(glbk_init(&ctx, &desc), GLBK_OK);
        pass.viewport[2] = pass.viewport[3] = 1;
        assert_int_equal(glbk_begin(&ctx, &pass, NULL), GLBK_OK);   /* a vertex array is one from its first use on */
        glbk_free(&ctx);
    }
    assert_int_equal(gl_names_in_use(t), before);
}

static void a_lost_context_is_called_no_more(void **state)
{
    GL_TEST(t, state)
    things x;
    glbk_pass pass = { 0 };
    glbk_state saved;
    int deletes;

    fail_everywhere(t, 0x0507, GLBK_ERR_LOST, GLBK_ERR_LOST);
    assert_glbk(t, make(t, &x));
    fake_begin(t, 0);
    fake.error = 0x0507;
    fake.at = 1;
    assert_int_equal(glbk_check(&t->gl), GLBK_ERR_LOST);
    deletes = fake.deletes;
    pass.target = &x.target;
    assert_int_equal(glbk_begin(&t->gl, &pass, &x.program), GLBK_ERR_LOST);
    assert_int_equal(glbk_dispatch(&t->gl, &x.program, 1, 1, 1), GLBK_ERR_LOST);
    assert_int_equal(glbk_buffer_update(&t->gl, &x.buffer, 0, 4, "abcd"), GLBK_ERR_LOST);
    assert_int_equal(glbk_check(&t->gl), GLBK_ERR_LOST);
    {
        things y;
        assert_int_equal(make(t, &y), GLBK_ERR_LOST);
        destroy(&t->gl, &y);
    }
    /* None of these calls GL: with an empty table they would crash. */
    memset(&t->gl.gl, 0, sizeof t->gl.gl);
    glbk_state_save(&t->gl, &saved);
    glbk_state_restore(&t->gl, &saved);
    glbk_bind_texture(&t->gl, 0, &x.texture);
    glbk_bind_block(&t->gl, 0, &x.buffer);
    glbk_bind_storage(&t->gl, 0, &x.buffer);
    glbk_bind_image(&t->gl, 0, &x.texture);
    glbk_program_use(&t->gl, &x.program);
    assert_int_equal(glbk_set_slots(&t->gl, NULL, NULL, 1), GLBK_ERR_LOST);
    glbk_clear(&t->gl, &x.target, 0, (const float[4]){ 0, 0, 0, 0 });
    glbk_clear_depth(&t->gl, 1);
    glbk_draw_screen(&t->gl);
    destroy(&t->gl, &x);
    assert_int_equal(fake.deletes, deletes);
    assert_int_equal(x.texture.name, 0);
    glbk_free(&t->gl);
}

static void destroying_is_always_safe(void **state)
{
    GL_TEST(t, state)
    things x, copy;
    assert_glbk(t, make(t, &x));
    copy = x;
    destroy(NULL, &copy);               /* forgets the names */
    memset(&copy, 0, sizeof copy);
    destroy(&t->gl, &copy);
    glbk_texture_free(&t->gl, NULL);
    glbk_buffer_free(&t->gl, NULL);
    glbk_target_free(&t->gl, NULL);
    glbk_program_free(&t->gl, NULL);
    glbk_free(NULL);
    glbk_abandon(NULL);
    destroy(&t->gl, &x);
    destroy(&t->gl, &x);                /* twice */
}

static void without_a_current_context_init_fails_and_freeing_works(void **state)
{
    GL_TEST(t, state)
    glbk_desc desc = desc_of(t);
    glbk_context ctx;
    things x;

#ifdef __EMSCRIPTEN__
    puts("skip: without a context Emscripten's calls of GL end the program");
    skip();
#endif
    assert_glbk(t, make(t, &x));
    assert_int_equal(ex_gl_make_current(t->context, 0), 0);
    /* GLFW's loader itself needs a context. */
    assert_int_equal(glbk_init(&ctx, &desc), gl_this_way()->window ? GLBK_ERR_FUNCTION : GLBK_ERR_CONTEXT);
    ctx = t->gl;
    glbk_abandon(&ctx);
    {
        things copy = x;
        destroy(&ctx, &copy);
    }
    glbk_free(&ctx);
    assert_int_equal(ex_gl_make_current(t->context, 1), 0);
    destroy(&t->gl, &x);
}

/* Two GL contexts of one process, in turn; each has its own table, and the names may be equal. */
static void two_contexts_keep_their_own_functions(void **state)
{
    GL_TEST(t, state)
    char error[EX_ERROR_SIZE];
    ex_gl *second;
    glbk_desc desc = desc_of(t);
    glbk_context other;
    things x, y;
    uint32_t word = 0;

    assert_glbk(t, make(t, &x));
    second = gl_new_context(error);
    if (!second) print_message("%s\n", error);
    assert_non_null(second);
    l.context = second;
    assert_int_equal(glbk_init(&other, &desc), GLBK_OK);
    {
        glbk_context first = t->gl;
        t->gl = other;
        assert_glbk(t, make(t, &y));
        t->gl = first;
    }
    assert_int_equal(ex_gl_make_current(t->context, 1), 0);
    assert_glbk(t, glbk_buffer_update(&t->gl, &x.buffer, 0, 4, "abcd"));
    assert_int_equal(ex_gl_make_current(second, 1), 0);
    if (!other.es) {
        assert_int_equal(glbk_buffer_read(&other, &y.buffer, 0, 4, &word), GLBK_OK);
        assert_int_equal(word, 0);      /* not what the first context's buffer of that name got */
    }
    destroy(&other, &y);
    glbk_free(&other);
    assert_int_equal(ex_gl_errors(second, NULL), 0);
    ex_gl_free(second);
    assert_int_equal(ex_gl_make_current(t->context, 1), 0);
    if (!t->gl.es) {
        assert_glbk(t, glbk_buffer_read(&t->gl, &x.buffer, 0, 4, &word));
        assert_memory_equal(&word, "abcd", 4);
    }
    destroy(&t->gl, &x);
}

/* ---- ES 3.0 without EXT_color_buffer_float ---- */

static void floats_that_cannot_be_rendered_to_are_refused(void **state)
{
    GL_TEST(t, state)
    static const uint16_t halves[4 * 4 * 4] = { 0 };
    int bare = gl_this_way()->bit == GL_ES30_BARE && t->gl.version < 320;       /* 3.2 needs no extension for it */
    glbk_texture_desc d = { 0 };
    glbk_target_desc targets = { 0 };
    glbk_texture texture;
    glbk_target target;

    assert_int_equal(t->gl.float_targets, !bare);
    assert_int_equal(t->gl.float_linear, gl_this_way()->bit != GL_ES30_BARE);
    d.format = GLBK_FORMAT_R32F;
    d.width = d.height = 4;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &texture));      /* to read from it is no problem */
    targets.color[0] = &texture;
    assert_int_equal(glbk_target_create(&t->gl, &targets, &target), bare ? GLBK_ERR_FLOAT_TARGET : GLBK_OK);
    if (bare) assert_non_null(strstr(glbk_result_text(GLBK_ERR_FLOAT_TARGET), "EXT_color_buffer_float"));
    glbk_texture_free(&t->gl, &texture);
    d.format = GLBK_FORMAT_RGBA16F;     /* filterable everywhere, but GL makes mipmaps of what it can render to */
    d.sampling = GLBK_SAMPLING_LINEAR;
    d.data = halves;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &texture));
    glbk_texture_free(&t->gl, &texture);
    d.sampling = GLBK_SAMPLING_MIPMAPS;
    assert_int_equal(glbk_texture_create(&t->gl, &d, &texture), bare ? GLBK_ERR_FLOAT_TARGET : GLBK_OK);
    assert_int_equal(texture.name == 0, bare);
    glbk_target_free(&t->gl, &target);
    glbk_texture_free(&t->gl, &texture);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(every_function_missing_once_is_named), gl_unit_test(versions_are_read),
        gl_unit_test(features_are_read),           gl_unit_test(targets_that_a_driver_refuses_leave_nothing),
        gl_unit_test(bad_descs_of_a_context_are_refused), gl_unit_test(out_of_memory_is_returned_wherever_it_comes),
        gl_unit_test(an_error_of_gl_is_returned_wherever_it_comes), gl_unit_test(without_a_shader_no_program_is_made),
        gl_unit_test(a_failing_allocator_leaves_no_object),             gl_unit_test(real_out_of_memory_is_returned),
        gl_unit_test(pending_errors_are_not_taken_for_ours),
        gl_unit_test(updates_ask_for_errors_only_when_told), gl_unit_test(an_error_for_ever_ends),
        gl_unit_test(a_thousand_cycles_leave_nothing),           gl_unit_test(contexts_come_and_go),
        gl_unit_test(a_lost_context_is_called_no_more),               gl_unit_test(destroying_is_always_safe),
        gl_unit_test(without_a_current_context_init_fails_and_freeing_works),
        gl_unit_test(two_contexts_keep_their_own_functions),
        gl_unit_test(floats_that_cannot_be_rendered_to_are_refused),
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_ALL & ~GL_SOFTPIPE);
}
