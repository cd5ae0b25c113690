/* gl_fake.h - GL that fails on demand and counts the names that live: glGetError has something to say the n-th time
   that it is asked, no shader or program is to be had; programs that are names only, for tests that make objects a
   thousand times, and draws by them that draw nothing; an allocator that gives out. Include gl_test.h before. */
#ifndef GL_FAKE_H
#define GL_FAKE_H

static struct {
    glbk_functions real;
    uint32_t error;                 /* what the call number `at` of glGetError says */
    int      at, calls, live, deletes;
    int      no_shader, no_program;
    int      hollow;                /* shaders and programs are never the driver's */
    uint32_t names;
} fake;

static inline uint32_t GLBK_CALL fake_get_error(void)
{
    uint32_t error = fake.real.GetError();
    return ++fake.calls == fake.at ? fake.error : error;
}

#define FAKE_NAMES(kind)                                                                \
    static inline void GLBK_CALL fake_gen_##kind(int32_t count, uint32_t *names)        \
    {                                                                                   \
        fake.real.Gen##kind(count, names);                                              \
        fake.live += count;                                                             \
    }                                                                                   \
    static inline void GLBK_CALL fake_delete_##kind(int32_t count, const uint32_t *names) \
    {                                                                                   \
        fake.real.Delete##kind(count, names);                                           \
        fake.live -= count;                                                             \
        fake.deletes += count;                                                          \
    }
FAKE_NAMES(Textures)
FAKE_NAMES(Framebuffers)
FAKE_NAMES(Buffers)
FAKE_NAMES(VertexArrays)

static inline uint32_t GLBK_CALL fake_create_shader(uint32_t type)
{
    if (fake.no_shader) return 0;
    fake.live++;
    return fake.hollow ? ++fake.names : fake.real.CreateShader(type);
}

static inline uint32_t GLBK_CALL fake_create_program(void)
{
    if (fake.no_program) return 0;
    fake.live++;
    return fake.hollow ? ++fake.names : fake.real.CreateProgram();
}

static inline void GLBK_CALL fake_delete_shader(uint32_t name)
{
    fake.live--;
    fake.deletes++;
    if (!fake.hollow) fake.real.DeleteShader(name);
}

static inline void GLBK_CALL fake_delete_program(uint32_t name)
{
    fake.live--;
    fake.deletes++;
    if (!fake.hollow) fake.real.DeleteProgram(name);
}

/* Until t->gl.gl = fake.real. */
static inline void fake_begin(gl_test *t, uint32_t error)
{
    glbk_functions *gl = &t->gl.gl;
    memset(&fake, 0, sizeof fake);
    fake.real = *gl;
    fake.error = error;
    gl->GetError = fake_get_error;
    gl->GenTextures = fake_gen_Textures;
    gl->DeleteTextures = fake_delete_Textures;
    gl->GenFramebuffers = fake_gen_Framebuffers;
    gl->DeleteFramebuffers = fake_delete_Framebuffers;
    gl->GenBuffers = fake_gen_Buffers;
    gl->DeleteBuffers = fake_delete_Buffers;
    gl->GenVertexArrays = fake_gen_VertexArrays;
    gl->DeleteVertexArrays = fake_delete_VertexArrays;
    gl->CreateShader = fake_create_shader;
    gl->CreateProgram = fake_create_program;
    gl->DeleteShader = fake_delete_shader;
    gl->DeleteProgram = fake_delete_program;
}

static inline void GLBK_CALL fake_source(uint32_t shader, int32_t count, const char *const *texts,
                                         const int32_t *lengths)
{
    (void)shader, (void)count, (void)texts, (void)lengths;
}

static inline void GLBK_CALL fake_name(uint32_t name) { (void)name; }
static inline void GLBK_CALL fake_two_names(uint32_t program, uint32_t shader) { (void)program, (void)shader; }

static inline void GLBK_CALL fake_outputs(uint32_t program, int32_t count, const char *const *names, uint32_t mode)
{
    (void)program, (void)count, (void)names, (void)mode;
}

static inline void GLBK_CALL fake_works(uint32_t name, uint32_t what, int32_t *out)
{
    (void)name, (void)what;
    *out = 1;
}

/* Programs that are not the driver's have nothing to find by its name. */
static inline uint32_t GLBK_CALL fake_no_block(uint32_t name, const char *text)
{
    (void)name, (void)text;
    return 0xFFFFFFFFu;
}

static inline int32_t GLBK_CALL fake_no_place(uint32_t name, const char *text)
{
    (void)name, (void)text;
    return -1;
}

/* The same; shaders compile and programs link at once, into nothing. They can be made and destroyed, not used. */
static inline void fake_begin_hollow(gl_test *t, uint32_t error)
{
    glbk_functions *gl = &t->gl.gl;
    fake_begin(t, error);
    fake.hollow = 1;
    gl->ShaderSource = fake_source;
    gl->CompileShader = fake_name;
    gl->AttachShader = fake_two_names;
    gl->LinkProgram = fake_name;
    gl->TransformFeedbackVaryings = fake_outputs;
    gl->GetShaderiv = gl->GetProgramiv = fake_works;
    gl->GetUniformBlockIndex = fake_no_block;
    gl->GetUniformLocation = fake_no_place;
}

static inline void GLBK_CALL fake_draw(uint32_t mode, int32_t first, int32_t count)
{
    (void)mode, (void)first, (void)count;
}

static inline void GLBK_CALL fake_draw_many(uint32_t mode, int32_t first, int32_t count, int32_t instances)
{
    (void)mode, (void)first, (void)count, (void)instances;
}

static inline void GLBK_CALL fake_draw_indexed(uint32_t mode, int32_t count, uint32_t type, const void *at)
{
    (void)mode, (void)count, (void)type, (void)at;
}

static inline void GLBK_CALL fake_draw_many_indexed(uint32_t mode, int32_t count, uint32_t type, const void *at,
                                                    int32_t instances)
{
    (void)mode, (void)count, (void)type, (void)at, (void)instances;
}

static inline void GLBK_CALL fake_dispatch(uint32_t x, uint32_t y, uint32_t z) { (void)x, (void)y, (void)z; }
static inline void GLBK_CALL fake_dispatch_at(ptrdiff_t at) { (void)at; }
static inline void GLBK_CALL fake_nothing(void) {}

/* The same; passes may be begun with such programs, and draw nothing: a test that goes through all calls that can
   fail, again and again, need not wait for shaders to be translated. */
static inline void fake_begin_blind(gl_test *t, uint32_t error)
{
    glbk_functions *gl = &t->gl.gl;
    fake_begin_hollow(t, error);
    gl->UseProgram = fake_name;
    gl->DrawArrays = fake_draw;
    gl->DrawArraysInstanced = fake_draw_many;
    gl->DrawElements = fake_draw_indexed;
    gl->DrawElementsInstanced = fake_draw_many_indexed;
    gl->BeginTransformFeedback = fake_name;
    gl->EndTransformFeedback = fake_nothing;
    gl->DispatchCompute = fake_dispatch;
    gl->DispatchComputeIndirect = fake_dispatch_at;
}

/* How many names of every kind GL knows. Mesa goes upwards and begins anew late, Emscripten never: a wide range. */
#ifdef __EMSCRIPTEN__
enum { GL_LAST_NAME = 300000 };
#else
enum { GL_LAST_NAME = 20000 };
#endif
static inline int gl_names_in_use(gl_test *t)
{
    static const char *const asking[] = { "glIsTexture", "glIsBuffer", "glIsFramebuffer", "glIsVertexArray",
                                          "glIsShader", "glIsProgram" };
    int count = 0;
    size_t i;
    for (i = 0; i < sizeof asking / sizeof asking[0]; i++) {
        uint8_t (GLBK_CALL *is)(uint32_t);
        glbk_proc_fn proc = ex_gl_get_proc(asking[i], t->context);
        uint32_t name;
        memcpy(&is, &proc, sizeof proc);
        for (name = 1; name < GL_LAST_NAME; name++) count += is(name) != 0;
    }
    return count;
}

/* An allocator that gives so many blocks and then none. */
static struct { int left, live; } fake_memory;

static inline void *fake_alloc(size_t size, void *user)
{
    void *block = fake_memory.left-- > 0 ? malloc(size) : NULL;
    (void)user;
    fake_memory.live += block != NULL;
    return block;
}

static inline void fake_free(void *block, void *user)
{
    (void)user;
    fake_memory.live -= block != NULL;
    free(block);
}

#endif
