/* ---- linking: programs of the library, and programs of a user's text ---- */

enum {
    GLBK__FRAGMENT_SHADER = 0x8B30, GLBK__VERTEX_SHADER = 0x8B31, GLBK__COMPUTE_SHADER = 0x91B9,
    GLBK__COMPILE_STATUS = 0x8B81, GLBK__LINK_STATUS = 0x8B82, GLBK__INFO_LOG_LENGTH = 0x8B84
};

/* One stage of a program, before it is compiled. */
typedef struct glbk__stage {
    uint32_t    type;
    glbk_shader shader;             /* has a name or a text, one of them */
} glbk__stage;

/* Appends which number of the driver's messages is which file. */
static void glbk__append_files(glbk__sink *sink, const glbk_shader *shader)
{
    const glbk_file *main_file;
    glbk__list list;
    uint32_t i;

    (void)glbk__gather_all(&list, shader, &main_file);      /* all are there: the text was compiled */
    glbk__append_text(sink, "files: 0 defines");
    for (i = 0; i <= list.count; i++) {
        glbk__append_text(sink, ", ");
        glbk__append_number(sink, i + 1);
        glbk__append_text(sink, " ");
        glbk__append_text(sink, i < list.count ? list.file[i]->name
                                : shader->name ? shader->name
                                               : "your text");
    }
    if (shader->name && shader->text) {
        glbk__append_text(sink, ", ");
        glbk__append_number(sink, list.count + 2);
        glbk__append_text(sink, " your text");
    }
    glbk__append_text(sink, "\n");
}

/* Logs the driver's words on a shader, after the list of its files, or on a program: shader is NULL then. */
static void glbk__log_driver(const glbk_context *ctx, uint32_t object, const glbk_shader *shader)
{
    glbk_prog__allocator memory = glbk_prog__memory(ctx);
    glbk__sink sink = { NULL, 0, 0 };
    int32_t length = 0;

    if (!ctx->system.log) return;
    if (shader) ctx->gl.GetShaderiv(object, GLBK__INFO_LOG_LENGTH, &length);
    else ctx->gl.GetProgramiv(object, GLBK__INFO_LOG_LENGTH, &length);
    if (length < 0) length = 0;
    if (shader) glbk__append_files(&sink, shader);
    sink.bytes = sink.used + (size_t)length + 2;
    sink.out = (char *)glbk_prog__alloc(&memory, sink.bytes);
    if (!sink.out) {
        ctx->system.log(ctx->system.user, "no memory for the driver's words");
        return;
    }
    sink.used = 0;
    if (shader) glbk__append_files(&sink, shader);
    memset(sink.out + sink.used, 0, sink.bytes - sink.used);
    if (shader) ctx->gl.GetShaderInfoLog(object, length + 1, NULL, sink.out + sink.used);
    else ctx->gl.GetProgramInfoLog(object, length + 1, NULL, sink.out + sink.used);
    sink.used = strlen(sink.out);
    while (sink.used && sink.out[sink.used - 1] == '\n') sink.out[--sink.used] = 0;
    ctx->system.log(ctx->system.user, sink.used ? sink.out : "the driver says nothing");
    glbk_prog__free(&memory, sink.out);
}

/* Logs why a stage has no text: "FUNCTION: the library file NAME is unknown", or defines that do not parse.
 */
static glbk_result glbk__refuse_shader(const glbk_context *ctx, const glbk_shader *shader)
{
    static const char function[] = "glbk_program_compile";
    const glbk_file *main_file;
    glbk__list list;
    char line[GLBK__LINE_ROOM];
    glbk__sink sink;
    glbk__begin_line(&sink, line);
    if (glbk__gather_all(&list, shader, &main_file)) {
        glbk__append_text(&sink, "do not parse: ");
        glbk__append_text(&sink, shader->defines);
        return glbk__refuse(ctx, GLBK_ERR_NAME, function, "defines", line);
    }
    if (!list.unknown)
        return glbk__refuse_range(ctx, GLBK_ERR_NAME, function, "the number of library files",
                                  (double)GLBK__MAX_FILES + 1, 0, GLBK__MAX_FILES);
    glbk__append(&sink, list.unknown, list.unknown_length);
    glbk__append_text(&sink, " is in none of the parts");
    return glbk__refuse(ctx, GLBK_ERR_NAME, function, "the library file", line);
}

/* Compiles one stage and attaches it. */
static glbk_result glbk__add_stage(glbk_context *ctx, uint32_t program, const glbk__stage *stage)
{
    glbk_dialect dialect = ctx->es                               ? GLBK_GLSL_300_ES
                           : stage->type == GLBK__COMPUTE_SHADER ? GLBK_GLSL_430
                                                                 : GLBK_GLSL_330;
    glbk_prog__allocator memory = glbk_prog__memory(ctx);
    int bits = !ctx->float_targets;
    size_t bytes = glbk_write_glsl(dialect, bits, &stage->shader, NULL, 0);
    char *text;
    uint32_t shader;
    int32_t compiled = 0;

    if (!bytes) return glbk__refuse_shader(ctx, &stage->shader);
    if (bytes > INT32_MAX)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, "glbk_program_compile",
                                  "the bytes of a shader's text", (double)bytes, 1, INT32_MAX);
    text = (char *)glbk_prog__alloc(&memory, bytes);
    if (!text) return GLBK_ERR_ALLOC;
    glbk_write_glsl(dialect, bits, &stage->shader, text, bytes);
    shader = ctx->gl.CreateShader(stage->type);
    if (shader) {
        const char *const texts[1] = { text };
        ctx->gl.ShaderSource(shader, 1, texts, NULL);
        ctx->gl.CompileShader(shader);
        ctx->gl.GetShaderiv(shader, GLBK__COMPILE_STATUS, &compiled);
        if (compiled) {
            ctx->gl.AttachShader(program, shader);
        } else {
            glbk__log_driver(ctx, shader, &stage->shader);
        }
        ctx->gl.DeleteShader(shader);       /* GL keeps it as long as it is attached */
    }
    glbk_prog__free(&memory, text);
    return compiled ? GLBK_OK : shader ? GLBK_ERR_COMPILE : GLBK_ERR_GL;
}

/* Gives GL the names for transform feedback, which it wants as an array. */
static glbk_result glbk__set_outputs(const glbk_context *ctx, uint32_t program, const char *outputs)
{
    char text[512];
    const char *names[16];
    int32_t count = 0;
    size_t length, used = 0;

    for (; (length = glbk__next_word(&outputs)) != 0; outputs += length) {
        if (count == 16 || length + 1 > sizeof text - used)
            return glbk__refuse(ctx, GLBK_ERR_DESC, "glbk_program_compile", "source.outputs",
                                count == 16 ? "has more than 16 names" : "has more than 511 characters");
        names[count++] = text + used;
        memcpy(text + used, outputs, length);
        text[used + length] = 0;
        used += length + 1;
    }
    if (count) ctx->gl.TransformFeedbackVaryings(program, count, names, GLBK_GL_INTERLEAVED_ATTRIBS);
    return GLBK_OK;
}

static glbk_result glbk__link(glbk_context *ctx, const glbk__stage *stages, int count, const char *outputs,
                              glbk_program *out)
{
    glbk_result result = GLBK_OK, errors;
    int32_t linked = 0;
    int i;

    memcpy(out->parts, stages[0].shader.parts, sizeof out->parts);
    out->slots_fn = glbk__set_program_slots;
    out->name = ctx->gl.CreateProgram();
    if (!out->name) result = GLBK_ERR_GL;
    for (i = 0; i < count && result == GLBK_OK; i++)
        result = glbk__add_stage(ctx, out->name, &stages[i]);
    if (result == GLBK_OK) result = glbk__set_outputs(ctx, out->name, outputs);
    if (result == GLBK_OK) {
        ctx->gl.LinkProgram(out->name);
        ctx->gl.GetProgramiv(out->name, GLBK__LINK_STATUS, &linked);
        if (!linked) {
            glbk__log_driver(ctx, out->name, NULL);
            result = GLBK_ERR_LINK;
        }
    }
    errors = glbk__leave(ctx);
    if (errors != GLBK_OK) result = errors;
    if (result != GLBK_OK) glbk_program_free(ctx, out);
    return result;
}

GLBK__DEF glbk_result glbk__program_of_parts(glbk_context *ctx, const glbk_part *part,
                                             const glbk_part *const others[2], const char *name,
                                             const char *defines, const char *const texts[2],
                                             glbk_program *out)
{
    static const char function[] = "glbk__program_create";
    glbk__stage stages[2];
    const glbk_file *file, *vertex;
    char path[64] = "prog/";
    const char *with;
    size_t length;
    glbk_result result;

    result = glbk__enter_create(ctx, function, out, sizeof *out);
    if (result != GLBK_OK) return result;
    if (!name) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "name", "is NULL");
    length = strlen(name);
    if (length < sizeof path - 5) memcpy(path + 5, name, length + 1);
    file = glbk_find_file(part, path);
    if (!file) return glbk__refuse(ctx, GLBK_ERR_NAME, function, name, "is no file of the part");
    memset(stages, 0, sizeof stages);
    stages[0].shader.parts[0] = part;
    if (others) memcpy(stages[0].shader.parts + 1, others, 2 * sizeof *others);
    stages[0].shader.uses = "";
    stages[0].shader.defines = defines;
    stages[1].shader = stages[0].shader;
    stages[0].shader.name = file->name;
    stages[0].shader.text = texts ? texts[1] : NULL;
    if (length > 5 && strcmp(name + length - 5, ".comp") == 0) {
        if (!ctx->compute) return glbk__refuse(ctx, GLBK_ERR_FEATURE, function, name, "needs OpenGL 4.3");
        stages[0].type = GLBK__COMPUTE_SHADER;
        return glbk__link(ctx, stages, 1, "", out);
    }
    with = glbk__file_fact(file, GLBK__FILE_WITH);
    if (!*with && length > 5 && strcmp(name + length - 5, ".frag") == 0) with = "screen.vert";
    strcpy(path + 5, with);
    vertex = glbk_find_file(part, path);
    if (!vertex)
        return glbk__refuse(ctx, GLBK_ERR_NAME, function, name, "is no program: it has no vertex shader");
    stages[0].type = GLBK__FRAGMENT_SHADER;
    stages[1].type = GLBK__VERTEX_SHADER;
    stages[1].shader.name = vertex->name;
    stages[1].shader.text = texts ? texts[0] : NULL;
    return glbk__link(ctx, stages, 2, "", out);
}

GLBK__DEF glbk_result glbk__program_create(glbk_context *ctx, const glbk_part *part, const char *name,
                                           const char *defines, glbk_program *out)
{
    return glbk__program_of_parts(ctx, part, NULL, name, defines, NULL, out);
}

/* Links the program of a user's text, whose parts must not meet. */
static glbk_result glbk__link_source(glbk_context *ctx, const glbk__stage *stages, int count,
                                     const glbk_source *s, glbk_program *out)
{
    glbk_result result = glbk__link(ctx, stages, count, s->outputs && count == 2 ? s->outputs : "", out);
    if (result != GLBK_OK) return result;
    memcpy(out->offsets, s->offsets, sizeof out->offsets);
    result = glbk__check_places(ctx, "glbk_program_compile", out);
    if (result != GLBK_OK) glbk_program_free(ctx, out);
    return result;
}

GLBK_DEF glbk_result glbk_program_compile(glbk_context *ctx, const glbk_source *s, glbk_program *out)
{
    glbk__stage stages[2];
    glbk_result result;

    result = glbk__enter_create(ctx, __func__, out, sizeof *out);
    if (result != GLBK_OK) return result;
    if (!s) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "source", "is NULL");
    if (!s->fragment && !s->compute)
        return glbk__refuse(ctx, GLBK_ERR_DESC, __func__, "source.fragment",
                            "is NULL, and so is source.compute");
    if (s->fragment && s->compute)
        return glbk__refuse(ctx, GLBK_ERR_DESC, __func__, "source.fragment",
                            "is given, and so is source.compute: a program has one of them");
    memset(stages, 0, sizeof stages);
    memcpy(stages[0].shader.parts, s->parts, sizeof s->parts);
    stages[0].shader.uses = s->uses ? s->uses : "";
    stages[0].shader.defines = s->defines;
    stages[1].shader = stages[0].shader;
    if (s->compute) {
        if (!ctx->compute)
            return glbk__refuse(ctx, GLBK_ERR_FEATURE, __func__, "source.compute", "needs OpenGL 4.3");
        stages[0].type = GLBK__COMPUTE_SHADER;
        stages[0].shader.text = s->compute;
        return glbk__link_source(ctx, stages, 1, s, out);
    }
    stages[0].type = GLBK__FRAGMENT_SHADER;
    stages[0].shader.text = s->fragment;
    stages[1].type = GLBK__VERTEX_SHADER;
    stages[1].shader.name = s->vertex ? NULL : "prog/screen.vert";
    if (!s->vertex) stages[1].shader.uses = "";     /* a library file may speak of gl_FragCoord */
    stages[1].shader.text = s->vertex;
    return glbk__link_source(ctx, stages, 2, s, out);
}

GLBK_DEF void glbk_program_free(glbk_context *ctx, glbk_program *program)
{
    if (!program) return;
    if (ctx && !ctx->lost && program->name) ctx->gl.DeleteProgram(program->name);
    memset(program, 0, sizeof *program);
}

GLBK_DEF glbk_result glbk_dispatch(glbk_context *ctx, glbk_program *program, uint32_t x, uint32_t y,
                                   uint32_t z)
{
    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!program || !program->name)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "program", "was not created");
    if (ctx->lost) return GLBK_ERR_LOST;
    if (!ctx->compute)
        return glbk__refuse(ctx, GLBK_ERR_FEATURE, __func__, "ctx", "is older than OpenGL 4.3");
    glbk_program_use(ctx, program);
    ctx->gl.DispatchCompute(x, y, z);
    ctx->gl.Barrier(GLBK_GL_ALL_BARRIER_BITS);
    return GLBK_OK;
}
