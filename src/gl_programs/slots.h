/* ---- slots: which unit or binding each texture and block of a program has ---- */

enum {
    GLBK__ACTIVE_UNIFORMS = 0x8B86, GLBK__CURRENT_PROGRAM = 0x8B8D, GLBK__ACTIVE_UNIFORM_BLOCKS = 0x8A36,
    GLBK__UNIFORM_BLOCK_BINDING = 0x8A3F, GLBK__SHADER_STORAGE_BLOCK = 0x92E6,
    GLBK__MAX_COMBINED_TEXTURE_IMAGE_UNITS = 0x8B4D, GLBK__MAX_UNIFORM_BUFFER_BINDINGS = 0x8A2F
};
#define GLBK__INVALID_INDEX 0xFFFFFFFFu

GLBK__DEF glbk_offset glbk__offset(const glbk_offset *offset)
{
    const glbk_offset none = { 0, 0 };
    return offset ? *offset : none;
}

/* The list of a user's own samplers: GLBK_SLOT_glbk_user0 to GLBK_SLOT_glbk_user3. */
static const char glbk__user_slots[] = "12 glbk_user0\0" "13 glbk_user1\0" "14 glbk_user2\0"
                                       "15 glbk_user3\0";

/* ---- places: which name has which unit or binding ---- */

/* The kinds of places. Slots of units and blocks count from the context's first ones on and move with a
   part's offset; GLSL says the numbers of the others. */
enum { GLBK__PLACE_UNIT, GLBK__PLACE_BLOCK, GLBK__PLACE_STORAGE, GLBK__PLACE_IMAGE, GLBK__PLACE_COUNT };

/* Returns a part's list of the slots of one kind of places. */
static const char *glbk__slots_of(const glbk_part *part, int kind)
{
    const char *s = part->slots;
    for (; kind; kind--, s++)
        while (*s) s += strlen(s) + 1;
    return s;
}

/* Moves *list, of strings such as "3 glbk_csm_maps", behind its first string, and writes the slot that this
   one has. Returns the name in it, NULL at the end of the list. */
static const char *glbk__next_slot(const char **list, uint32_t *slot)
{
    const char *s = *list;
    if (!*s) return NULL;
    for (*slot = 0; *s != ' '; s++) *slot = 10 * *slot + (uint32_t)(*s - '0');
    *list = s + strlen(s) + 1;
    return s + 1;
}

/* The names that hold the places of a program, of those that it declares. */
typedef struct glbk__holders {
    const char *names[GLBK__PLACE_COUNT][GLBK_MAX_UNITS];
    const char *function;           /* the public function that looks */
    uint32_t    gl_program;
} glbk__holders;

static uint32_t glbk__place_count(const glbk_context *ctx, int kind)
{
    if (kind == GLBK__PLACE_UNIT) return ctx->unit_count;
    return kind == GLBK__PLACE_BLOCK ? ctx->block_count : GLBK_BLOCKS;
}

/* Returns the number that GL knows the first place of a kind by. */
static uint32_t glbk__first_place(const glbk_context *ctx, int kind)
{
    if (kind == GLBK__PLACE_UNIT) return ctx->first_unit;
    return kind == GLBK__PLACE_BLOCK ? ctx->first_block : 0;
}

static int glbk__declares(const glbk_context *ctx, uint32_t gl_program, const char *name, int kind)
{
    if (kind == GLBK__PLACE_BLOCK)
        return ctx->gl.GetUniformBlockIndex(gl_program, name) != GLBK__INVALID_INDEX;
    if (kind == GLBK__PLACE_STORAGE)
        return ctx->gl.GetProgramResourceIndex(gl_program, GLBK__SHADER_STORAGE_BLOCK, name) !=
               GLBK__INVALID_INDEX;
    return ctx->gl.GetUniformLocation(gl_program, name) >= 0;
}

/* Logs "FUNCTION: A and B both have texture unit 3: give one part an offset". place is GL's number. */
static glbk_result glbk__refuse_place(const glbk_context *ctx, const glbk__holders *h, const char *first,
                                      const char *second, uint32_t place, int kind)
{
    static const char texts[][42] = { " both have texture unit ", " both have the binding of uniform blocks ",
                                      " both have storage buffer ", " both have image " };
    char line[GLBK__LINE_ROOM];
    glbk__sink sink;
    glbk__begin_line(&sink, line);
    glbk__append_text(&sink, "and ");
    glbk__append_text(&sink, second);
    glbk__append_text(&sink, texts[kind]);
    glbk__append_number(&sink, place);
    glbk__append_text(&sink, kind < GLBK__PLACE_STORAGE ? ": give one part an offset"
                                                        : ": give each part a program of its own");
    return glbk__refuse(ctx, GLBK_ERR_MISMATCH, h->function, first, line);
}

/* Gives the declared names of one list their places, which are moved by `offset`. */
static glbk_result glbk__take_places(const glbk_context *ctx, const char *list, uint32_t offset, int kind,
                                     glbk__holders *h)
{
    const uint32_t count = glbk__place_count(ctx, kind);
    const char **names = h->names[kind], *name;
    uint32_t slot;
    while ((name = glbk__next_slot(&list, &slot)) != NULL) {
        if (!glbk__declares(ctx, h->gl_program, name, kind)) continue;
        if (offset >= count || slot >= count - offset)
            return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, h->function, name, (double)offset + slot, 0,
                                      (double)count - 1);
        if (names[offset + slot])
            return glbk__refuse_place(ctx, h, names[offset + slot], name,
                                      glbk__first_place(ctx, kind) + offset + slot, kind);
        names[offset + slot] = name;
    }
    return GLBK_OK;
}

static glbk_result glbk__take_part(const glbk_context *ctx, const glbk_part *part, const glbk_offset *offset,
                                   glbk__holders *h)
{
    const glbk_offset at = glbk__offset(offset);
    const int kinds = ctx->compute ? GLBK__PLACE_COUNT : GLBK__PLACE_STORAGE;
    glbk_result result = GLBK_OK;
    int kind;
    for (kind = 0; kind < kinds && result == GLBK_OK; kind++) {
        const uint32_t first = kind == GLBK__PLACE_UNIT ? at.unit : kind == GLBK__PLACE_BLOCK ? at.block : 0;
        result = glbk__take_places(ctx, glbk__slots_of(part, kind), first, kind, h);
    }
    return result;
}

/* Gives the names that every program may declare their places: the base's, and samplers of the user's. */
static glbk_result glbk__take_base(const glbk_context *ctx, const char *function, uint32_t gl_program,
                                   glbk__holders *h)
{
    glbk_result result;
    memset(h, 0, sizeof *h);
    h->function = function;
    h->gl_program = gl_program;
    result = glbk__take_part(ctx, glbk__base(), NULL, h);
    return result == GLBK_OK ? glbk__take_places(ctx, glbk__user_slots, 0, GLBK__PLACE_UNIT, h) : result;
}

/* Refuses a linked program in which two names of its parts and the base have one place. */
static glbk_result glbk__check_places(const glbk_context *ctx, const char *function,
                                      const glbk_program *program)
{
    glbk__holders h;
    glbk_result result = glbk__take_base(ctx, function, program->name, &h);
    uint32_t i;
    for (i = 0; i < GLBK_MAX_PARTS && result == GLBK_OK; i++)
        if (program->parts[i] && program->parts[i] != glbk__base())
            result = glbk__take_part(ctx, program->parts[i], &program->offsets[i], &h);
    return result;
}

/* ---- setting slots ---- */

static void glbk__set_units(const glbk_context *ctx, const char *list, uint32_t offset, uint32_t gl_program)
{
    const char *name;
    uint32_t slot;
    while ((name = glbk__next_slot(&list, &slot)) != NULL) {
        const int32_t location = ctx->gl.GetUniformLocation(gl_program, name);
        if (location >= 0) ctx->gl.Uniform1i(location, (int32_t)(ctx->first_unit + offset + slot));
    }
}

static void glbk__set_part_slots(const glbk_context *ctx, const glbk_part *part, const glbk_offset *offset,
                                 uint32_t gl_program)
{
    const glbk_offset at = glbk__offset(offset);
    const char *blocks = glbk__slots_of(part, GLBK__PLACE_BLOCK), *name;
    uint32_t slot;
    glbk__set_units(ctx, glbk__slots_of(part, GLBK__PLACE_UNIT), at.unit, gl_program);
    while ((name = glbk__next_slot(&blocks, &slot)) != NULL) {
        const uint32_t index = ctx->gl.GetUniformBlockIndex(gl_program, name);
        if (index != GLBK__INVALID_INDEX)
            ctx->gl.UniformBlockBinding(gl_program, index, ctx->first_block + at.block + slot);
    }
}

/* Gives the base's names and the user's own samplers their slots. */
static void glbk__set_base_slots(const glbk_context *ctx, uint32_t gl_program)
{
    glbk__set_part_slots(ctx, glbk__base(), NULL, gl_program);
    glbk__set_units(ctx, glbk__user_slots, 0, gl_program);
}

/* Gives all names of a program that is in use for the first time their slots: glbk_program.slots_fn. */
static void glbk__set_program_slots(const glbk_context *ctx, const glbk_program *program)
{
    uint32_t i;
    glbk__set_base_slots(ctx, program->name);
    for (i = 0; i < GLBK_MAX_PARTS; i++)
        if (program->parts[i])
            glbk__set_part_slots(ctx, program->parts[i], &program->offsets[i], program->name);
}

/* ---- programs that the user linked ----

   A call of glbk_set_slots knows one part. What was set for other parts, or by the user, is asked of GL. GL's
   default is 0, which might as well have been set; so the first call for a program moves what belongs to
   other parts, by its name, and is still at 0 to the last place that GL has, the waiting place. From then on,
   0 was set. (Where GL has 32 units only, slot 31 is the waiting place, and what meets there is not seen.) */

typedef struct glbk__active {       /* a sampler or uniform block that a program declares, as GL lists it */
    char     name[128];
    int      kind;                  /* GLBK__PLACE_UNIT or _BLOCK */
    uint32_t index;                 /* of the block */
    int32_t  count, location;       /* elements of an array of samplers; the first one's location */
    int32_t  place;                 /* unit of the first element, or binding of the block */
} glbk__active;

/* The first and last type of each of GL's ranges of sampler types. */
static const uint32_t glbk__sampler_types[][2] = {
    { 0x8B5D /* SAMPLER_1D */, 0x8B64 /* SAMPLER_2D_RECT_SHADOW */ },
    { 0x8DC0 /* SAMPLER_1D_ARRAY */, 0x8DC5 /* SAMPLER_CUBE_SHADOW */ },
    { 0x8DC9 /* INT_SAMPLER_1D */, 0x8DD8 /* UNSIGNED_INT_SAMPLER_BUFFER */ },
    { 0x900C /* SAMPLER_CUBE_MAP_ARRAY */, 0x900F /* UNSIGNED_INT_SAMPLER_CUBE_MAP_ARRAY */ },
    { 0x9108 /* SAMPLER_2D_MULTISAMPLE */, 0x910D /* UNSIGNED_INT_SAMPLER_2D_MULTISAMPLE_ARRAY */ }
};

static int glbk__is_sampler(uint32_t type)
{
    size_t i;
    for (i = 0; i < sizeof glbk__sampler_types / sizeof glbk__sampler_types[0]; i++)
        if (type >= glbk__sampler_types[i][0] && type <= glbk__sampler_types[i][1]) return 1;
    return 0;
}

/* Reads number i of GL's lists of uniforms or blocks. Returns 0 for a uniform that is no sampler. */
static int glbk__read_active(const glbk_context *ctx, uint32_t gl_program, int kind, uint32_t i,
                             glbk__active *out)
{
    uint32_t type = 0;
    memset(out, 0, sizeof *out);
    out->kind = kind;
    out->index = i;
    if (kind == GLBK__PLACE_BLOCK) {
        ctx->gl.GetActiveUniformBlockName(gl_program, i, sizeof out->name, NULL, out->name);
        ctx->gl.GetActiveUniformBlockiv(gl_program, i, GLBK__UNIFORM_BLOCK_BINDING, &out->place);
        return 1;
    }
    ctx->gl.GetActiveUniform(gl_program, i, sizeof out->name, NULL, &out->count, &type, out->name);
    if (!glbk__is_sampler(type)) return 0;
    out->location = ctx->gl.GetUniformLocation(gl_program, out->name);
    if (out->location < 0) return 0;        /* its name is longer than the room for it */
    ctx->gl.GetUniformiv(gl_program, out->location, &out->place);
    return 1;
}

static uint32_t glbk__count_active(const glbk_context *ctx, uint32_t gl_program, int kind)
{
    int32_t count = 0;
    ctx->gl.GetProgramiv(
        gl_program, kind == GLBK__PLACE_UNIT ? GLBK__ACTIVE_UNIFORMS : GLBK__ACTIVE_UNIFORM_BLOCKS, &count);
    return count > 0 ? (uint32_t)count : 0;
}

/* Returns whether this call gives the name its place: every name that it declares is among the holders. */
static int glbk__is_held(const glbk__holders *h, const glbk__active *a)
{
    uint32_t i;
    for (i = 0; i < GLBK_MAX_UNITS; i++)
        if (h->names[a->kind][i] && strcmp(h->names[a->kind][i], a->name) == 0) return 1;
    return 0;
}

static int glbk__is_of_a_part(const glbk__active *a) { return strncmp(a->name, "glbk_", 5) == 0; }

/* Returns whether no call of glbk_set_slots has given this call's names their places: there are some, and all
   are at 0. */
static int glbk__is_first_call(const glbk_context *ctx, const glbk__holders *h, int kind)
{
    const uint32_t count = glbk__count_active(ctx, h->gl_program, kind);
    glbk__active a;
    uint32_t i;
    int first_call = 0;
    for (i = 0; i < count; i++) {
        if (!glbk__read_active(ctx, h->gl_program, kind, i, &a) || !glbk__is_held(h, &a)) continue;
        if (a.place) return 0;
        first_call = 1;
    }
    return first_call;
}

static int32_t glbk__waiting_place(const glbk_context *ctx, int kind)
{
    return (int32_t)glbk__get_integer(ctx, kind == GLBK__PLACE_UNIT ? GLBK__MAX_COMBINED_TEXTURE_IMAGE_UNITS
                                                                    : GLBK__MAX_UNIFORM_BUFFER_BINDINGS) - 1;
}

/* Returns the unit of one element of an array of samplers, whose name is NAME[0], or the block's binding. */
static int32_t glbk__place_of(const glbk_context *ctx, const glbk__holders *h, const glbk__active *a,
                              int32_t i)
{
    const size_t length = strlen(a->name);
    char element[GLBK__LINE_ROOM];
    glbk__sink sink;
    int32_t place = 0;
    if (i == 0 || length < 3) return a->place;
    glbk__begin_line(&sink, element);
    glbk__append(&sink, a->name, length - 2);               /* without "0]" */
    glbk__append_number(&sink, (uint64_t)i);
    glbk__append_text(&sink, "]");
    i = ctx->gl.GetUniformLocation(h->gl_program, element);
    if (i >= 0) ctx->gl.GetUniformiv(h->gl_program, i, &place);
    return place;
}

/* Refuses names of the call whose places GL has given to others. */
static glbk_result glbk__check_active(const glbk_context *ctx, const glbk__holders *h, int kind)
{
    const uint32_t count = glbk__count_active(ctx, h->gl_program, kind);
    const int first_call = glbk__is_first_call(ctx, h, kind);
    const int32_t waiting = glbk__waiting_place(ctx, kind);
    glbk__active a;
    uint32_t i;
    int32_t k;
    for (i = 0; i < count; i++) {
        if (!glbk__read_active(ctx, h->gl_program, kind, i, &a) || glbk__is_held(h, &a)) continue;
        for (k = 0; k < (a.count > 1 ? a.count : 1); k++) {
            const int32_t place = glbk__place_of(ctx, h, &a, k);
            const int64_t slot = (int64_t)place - glbk__first_place(ctx, kind);
            if (place == waiting || (!place && (first_call || !glbk__is_of_a_part(&a)))) continue;
            if (slot >= 0 && slot < glbk__place_count(ctx, kind) && h->names[kind][slot])
                return glbk__refuse_place(ctx, h, a.name, h->names[kind][slot], (uint32_t)place, kind);
        }
    }
    return GLBK_OK;
}

/* Moves what other parts declare and nobody has set to the waiting place. */
static void glbk__let_wait(const glbk_context *ctx, const glbk__holders *h, int kind)
{
    const uint32_t count = glbk__count_active(ctx, h->gl_program, kind);
    const int32_t waiting = glbk__waiting_place(ctx, kind);
    glbk__active a;
    uint32_t i;
    if (!glbk__is_first_call(ctx, h, kind)) return;
    for (i = 0; i < count; i++) {
        if (!glbk__read_active(ctx, h->gl_program, kind, i, &a) || a.place || glbk__is_held(h, &a) ||
            !glbk__is_of_a_part(&a))
            continue;
        if (kind == GLBK__PLACE_UNIT) ctx->gl.Uniform1i(a.location, waiting);
        else ctx->gl.UniformBlockBinding(h->gl_program, a.index, (uint32_t)waiting);
    }
}

/* Uniforms can be set in the program in use alone before OpenGL 4.1, and Emscripten finds the places of
   uniforms, which are read here too, in that program alone: the program that was in use is put back.
   If that one was to be deleted once it is no longer in use, GL has done so by now, and none is in use. */
GLBK_DEF glbk_result glbk_set_slots(glbk_context *ctx, const glbk_part *part, const glbk_offset *offset,
                                    uint32_t gl_program)
{
    glbk__holders h;
    glbk_result result;
    uint32_t used;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (ctx->lost) return GLBK_ERR_LOST;
    if (!gl_program) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "gl_program", "is 0");
    result = glbk__take_base(ctx, __func__, gl_program, &h);
    if (result == GLBK_OK && part && part != glbk__base()) result = glbk__take_part(ctx, part, offset, &h);
    if (result != GLBK_OK) return result;
    used = glbk__get_integer(ctx, GLBK__CURRENT_PROGRAM);
    if (used != gl_program) ctx->gl.UseProgram(gl_program);
    result = glbk__check_active(ctx, &h, GLBK__PLACE_UNIT);
    if (result == GLBK_OK) result = glbk__check_active(ctx, &h, GLBK__PLACE_BLOCK);
    if (result == GLBK_OK) {
        glbk__let_wait(ctx, &h, GLBK__PLACE_UNIT);
        glbk__let_wait(ctx, &h, GLBK__PLACE_BLOCK);
        glbk__set_base_slots(ctx, gl_program);
        if (part) glbk__set_part_slots(ctx, part, offset, gl_program);
    }
    if (used != gl_program) ctx->gl.UseProgram(ctx->gl.IsProgram(used) ? used : 0);
    return result;
}
