/* ---- slots: which unit or binding each texture and block of a program has ---- */

GLBK__DEF glbk_offset glbk__offset(const glbk_offset *offset)
{
    const glbk_offset none = { 0, 0 };
    return offset ? *offset : none;
}

static const glbk_slot glbk__user_slots[] = {
    { "glbk_user0", GLBK_SLOT_glbk_user0 }, { "glbk_user1", GLBK_SLOT_glbk_user1 },
    { "glbk_user2", GLBK_SLOT_glbk_user2 }, { "glbk_user3", GLBK_SLOT_glbk_user3 }, { NULL, 0 }
};

/* Which name of the parts' lists has a unit or a binding, of those that a program declares. */
typedef struct glbk__holders {
    const char *units[GLBK_MAX_UNITS], *blocks[GLBK_MAX_BLOCKS];
    const char *function;           /* that looks */
} glbk__holders;

static int glbk__declares(const glbk_context *ctx, uint32_t gl_program, const char *name, int is_block)
{
    return is_block ? ctx->gl.GetUniformBlockIndex(gl_program, name) != 0xFFFFFFFFu
                    : ctx->gl.GetUniformLocation(gl_program, name) >= 0;
}

/* "FUNCTION: A and B both have texture unit 3: give one part an offset". */
static glbk_result glbk__refuse_place(const glbk_context *ctx, const glbk__holders *h, const char *first,
                                      const char *second, uint32_t place, int is_block)
{
    glbk__message m;
    m.used = 0;
    glbk__message_text(&m, "and ");
    glbk__message_text(&m, second);
    glbk__message_text(&m,
                       is_block ? " both have the binding of uniform blocks " : " both have texture unit ");
    glbk__message_count(&m, place);
    glbk__message_text(&m, ": give one part an offset");
    return glbk__refuse(ctx, GLBK_ERR_MISMATCH, h->function, first, m.text);
}

/* The names of one list take their places; first: by how much these are moved. */
static glbk_result glbk__take_places(const glbk_context *ctx, uint32_t gl_program, const glbk_slot *s,
                                     uint32_t first, int is_block, glbk__holders *h)
{
    const uint32_t count = is_block ? ctx->block_count : ctx->unit_count;
    const char **holders = is_block ? h->blocks : h->units;
    for (; s->name; s++) {
        if (!glbk__declares(ctx, gl_program, s->name, is_block)) continue;
        if (first >= count || s->slot >= count - first)
            return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, h->function, s->name, (double)first + s->slot, 0,
                                      (double)count - 1);
        if (holders[first + s->slot])
            return glbk__refuse_place(ctx, h, holders[first + s->slot], s->name,
                                      (is_block ? ctx->first_block : ctx->first_unit) + first + s->slot,
                                      is_block);
        holders[first + s->slot] = s->name;
    }
    return GLBK_OK;
}

static glbk_result glbk__take_part(const glbk_context *ctx, uint32_t gl_program, const glbk_part *part,
                                   const glbk_offset *offset, glbk__holders *h)
{
    glbk_result result = glbk__take_places(ctx, gl_program, part->textures, offset ? offset->unit : 0, 0, h);
    return result == GLBK_OK
               ? glbk__take_places(ctx, gl_program, part->blocks, offset ? offset->block : 0, 1, h)
               : result;
}

/* Whether all that a linked program declares of its parts and the base has a place of its own. */
static glbk_result glbk__check_places(const glbk_context *ctx, const char *function,
                                      const glbk_program *program)
{
    glbk__holders h;
    glbk_result result;
    uint32_t i;
    memset(&h, 0, sizeof h);
    h.function = function;
    result = glbk__take_part(ctx, program->name, glbk_base_part(), NULL, &h);
    if (result == GLBK_OK) result = glbk__take_places(ctx, program->name, glbk__user_slots, 0, 0, &h);
    for (i = 0; i < GLBK_MAX_PARTS && result == GLBK_OK; i++)
        if (program->parts[i] && program->parts[i] != glbk_base_part())
            result = glbk__take_part(ctx, program->name, program->parts[i], &program->offsets[i], &h);
    return result;
}

static void glbk__set_units(const glbk_context *ctx, const glbk_slot *s, uint32_t first, uint32_t gl_program)
{
    for (; s->name; s++) {
        int32_t location = ctx->gl.GetUniformLocation(gl_program, s->name);
        if (location >= 0) ctx->gl.Uniform1i(location, (int32_t)(ctx->first_unit + first + s->slot));
    }
}

static void glbk__set_part_slots(const glbk_context *ctx, const glbk_part *part, const glbk_offset *offset,
                                 uint32_t gl_program)
{
    const uint32_t first = ctx->first_block + (offset ? offset->block : 0);
    const glbk_slot *s;
    glbk__set_units(ctx, part->textures, offset ? offset->unit : 0, gl_program);
    for (s = part->blocks; s->name; s++) {
        uint32_t index = ctx->gl.GetUniformBlockIndex(gl_program, s->name);
        if (index != 0xFFFFFFFFu) ctx->gl.UniformBlockBinding(gl_program, index, first + s->slot);
    }
}

/* The base's, and those of a user's own samplers, which have slots behind the library's. */
static void glbk__set_base_slots(const glbk_context *ctx, uint32_t gl_program)
{
    glbk__set_part_slots(ctx, glbk_base_part(), NULL, gl_program);
    glbk__set_units(ctx, glbk__user_slots, 0, gl_program);
}

/* Uniforms can be set in the program in use alone before OpenGL 4.1: another one is put back. If it was to be
   deleted once it is no longer in use, GL has done so by now, and none is in use. */
GLBK_DEF glbk_result glbk_set_slots(glbk_context *ctx, const glbk_part *part, const glbk_offset *offset,
                                    uint32_t gl_program)
{
    glbk__holders h;
    glbk_result result = GLBK_OK;
    uint32_t used;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (ctx->lost) return GLBK_ERR_LOST;
    if (!gl_program) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "gl_program", "is 0");
    memset(&h, 0, sizeof h);
    h.function = __func__;
    if (part) result = glbk__take_part(ctx, gl_program, part, offset, &h);
    if (result != GLBK_OK) return result;
    used = glbk__get_integer(ctx, 0x8B8D /* CURRENT_PROGRAM */);
    if (used != gl_program) ctx->gl.UseProgram(gl_program);
    glbk__set_base_slots(ctx, gl_program);
    if (part) glbk__set_part_slots(ctx, part, offset, gl_program);
    if (used != gl_program) ctx->gl.UseProgram(ctx->gl.IsProgram(used) ? used : 0);
    return GLBK_OK;
}

GLBK_DEF void glbk_program_use(glbk_context *ctx, glbk_program *program)
{
    uint32_t i;
    if (!ctx || ctx->lost || !program) return;
    ctx->gl.UseProgram(program->name);
    if (program->slots_set) return;
    program->slots_set = 1;
    glbk__set_base_slots(ctx, program->name);
    for (i = 0; i < GLBK_MAX_PARTS; i++)
        if (program->parts[i])
            glbk__set_part_slots(ctx, program->parts[i], &program->offsets[i], program->name);
}
