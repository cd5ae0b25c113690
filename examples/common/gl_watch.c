/* gl_watch.c - errors that drivers let pass and browsers do not: a draw with a uniform block that has no buffer; with a
   sampler on whose unit there is a texture of another kind (of floats, integers, depths that are compared), or the one
   that is drawn to. All blocks that a program declares count (std140), and all samplers that it may read, whether this
   draw reads them or not. */
#include "gl_internal.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct {
    ex_gl *gl;          /* the current context */
    void(GLBK_CALL *DrawArrays)(uint32_t, int32_t, int32_t);
    void(GLBK_CALL *DrawElements)(uint32_t, int32_t, uint32_t, const void *);
    void(GLBK_CALL *DrawArraysInstanced)(uint32_t, int32_t, int32_t, int32_t);
    void(GLBK_CALL *DrawElementsInstanced)(uint32_t, int32_t, uint32_t, const void *, int32_t);
    void(GLBK_CALL *DispatchCompute)(uint32_t, uint32_t, uint32_t);
    void(GLBK_CALL *DispatchComputeIndirect)(ptrdiff_t);
    void(GLBK_CALL *GetIntegerv)(uint32_t, int32_t *);
    void(GLBK_CALL *GetIntegeri_v)(uint32_t, uint32_t, int32_t *);
    void(GLBK_CALL *GetProgramiv)(uint32_t, uint32_t, int32_t *);
    void(GLBK_CALL *GetActiveUniformBlockiv)(uint32_t, uint32_t, uint32_t, int32_t *);
    void(GLBK_CALL *GetActiveUniformBlockName)(uint32_t, uint32_t, int32_t, int32_t *, char *);
    void(GLBK_CALL *GetActiveUniformsiv)(uint32_t, int32_t, const uint32_t *, uint32_t, int32_t *);
    void(GLBK_CALL *GetActiveUniform)(uint32_t, uint32_t, int32_t, int32_t *, int32_t *, uint32_t *, char *);
    int32_t(GLBK_CALL *GetUniformLocation)(uint32_t, const char *);
    void(GLBK_CALL *GetUniformiv)(uint32_t, int32_t, int32_t *);
    void(GLBK_CALL *GetTexParameteriv)(uint32_t, uint32_t, int32_t *);
    void(GLBK_CALL *GetSamplerParameteriv)(uint32_t, uint32_t, int32_t *);
    void(GLBK_CALL *GetFramebufferAttachmentParameteriv)(uint32_t, uint32_t, uint32_t, int32_t *);
    void(GLBK_CALL *ActiveTexture)(uint32_t);
    void(GLBK_CALL *TexImage2D)(uint32_t, int32_t, int32_t, int32_t, int32_t, int32_t, uint32_t, uint32_t,
                                const void *);
    void(GLBK_CALL *TexImage3D)(uint32_t, int32_t, int32_t, int32_t, int32_t, int32_t, int32_t, uint32_t, uint32_t,
                                const void *);
    void(GLBK_CALL *TexStorage2D)(uint32_t, int32_t, uint32_t, int32_t, int32_t);
    void(GLBK_CALL *TexStorage3D)(uint32_t, int32_t, uint32_t, int32_t, int32_t, int32_t);
    void(GLBK_CALL *DeleteTextures)(int32_t, const uint32_t *);
} real;

/* ---- formats of textures: noted when storage is allotted, since ES 3.0 cannot be asked for them ---- */

/* Numbers of GL that gl_backend.h has no name for. */
enum {
    NUMBER_R8I = 0x8231, NUMBER_RG32UI = 0x823C, NUMBER_RGBA32UI = 0x8D70,
    NUMBER_RGBA32I = 0x8D82, NUMBER_RGB8I = 0x8D8F,
    NUMBER_DEPTH_COMPONENT = 0x1902, NUMBER_DEPTH_COMPONENT16 = 0x81A5, NUMBER_DEPTH_COMPONENT32 = 0x81A7,
    NUMBER_DEPTH24_STENCIL8 = 0x88F0, NUMBER_DEPTH_COMPONENT32F = 0x8CAC, NUMBER_DEPTH32F_STENCIL8 = 0x8CAD,
    NUMBER_TEXTURE_BINDING_2D = 0x8069, NUMBER_TEXTURE_3D = 0x806F, NUMBER_TEXTURE_BINDING_3D = 0x806A,
    NUMBER_TEXTURE_BINDING_2D_ARRAY = 0x8C1D, NUMBER_TEXTURE_CUBE_MAP = 0x8513,
    NUMBER_TEXTURE_CUBE_MAP_POSITIVE_X = 0x8515, NUMBER_TEXTURE_CUBE_MAP_NEGATIVE_Z = 0x851A,
    NUMBER_TEXTURE_BINDING_CUBE_MAP = 0x8514, NUMBER_SAMPLER_2D = 0x8B5E, NUMBER_SAMPLER_3D = 0x8B5F,
    NUMBER_SAMPLER_CUBE = 0x8B60, NUMBER_SAMPLER_2D_ARRAY = 0x8DC1, NUMBER_INT_SAMPLER_2D = 0x8DCA,
    NUMBER_INT_SAMPLER_3D = 0x8DCB, NUMBER_INT_SAMPLER_CUBE = 0x8DCC, NUMBER_INT_SAMPLER_2D_ARRAY = 0x8DCF,
    NUMBER_UNSIGNED_INT_SAMPLER_2D = 0x8DD2, NUMBER_UNSIGNED_INT_SAMPLER_3D = 0x8DD3,
    NUMBER_UNSIGNED_INT_SAMPLER_CUBE = 0x8DD4, NUMBER_UNSIGNED_INT_SAMPLER_2D_ARRAY = 0x8DD7,
    NUMBER_SAMPLER_2D_SHADOW = 0x8B62, NUMBER_SAMPLER_CUBE_SHADOW = 0x8DC5, NUMBER_SAMPLER_2D_ARRAY_SHADOW = 0x8DC4
};

typedef enum kind { KIND_FLOAT, KIND_INT, KIND_UINT, KIND_DEPTH, KIND_COMPARED } kind;
static const char *const kind_names[] = { "floats", "integers", "unsigned integers", "depths", "compared depths" };

static struct texture {
    ex_gl   *gl;
    uint32_t name;
    kind     is;
} *textures;
static size_t texture_count, texture_room;

static struct texture *find_texture(uint32_t name)
{
    for (size_t i = 0; i < texture_count; i++)
        if (textures[i].gl == real.gl && textures[i].name == name)
            return &textures[i];
    return NULL;
}

static kind kind_of(uint32_t internal)
{
    if (internal >= NUMBER_R8I && internal <= NUMBER_RG32UI)
        return internal & 1 ? KIND_INT : KIND_UINT;
    if (internal >= NUMBER_RGBA32UI && internal <= NUMBER_RGB8I)
        return internal < NUMBER_RGBA32I ? KIND_UINT : KIND_INT;
    if (internal == NUMBER_DEPTH_COMPONENT ||
        (internal >= NUMBER_DEPTH_COMPONENT16 && internal <= NUMBER_DEPTH_COMPONENT32) ||
        internal == NUMBER_DEPTH24_STENCIL8 || internal == NUMBER_DEPTH_COMPONENT32F ||
        internal == NUMBER_DEPTH32F_STENCIL8)
        return KIND_DEPTH;
    return KIND_FLOAT;
}

/* The query for what is bound to a target; 0 of kinds that nobody here samples. */
static uint32_t binding_of(uint32_t target)
{
    switch (target) {
    case GLBK_GL_TEXTURE_2D: return NUMBER_TEXTURE_BINDING_2D;
    case NUMBER_TEXTURE_3D: return NUMBER_TEXTURE_BINDING_3D;
    case GLBK_GL_TEXTURE_2D_ARRAY: return NUMBER_TEXTURE_BINDING_2D_ARRAY;
    case NUMBER_TEXTURE_CUBE_MAP: return NUMBER_TEXTURE_BINDING_CUBE_MAP;
    default:
        return target >= NUMBER_TEXTURE_CUBE_MAP_POSITIVE_X && target <= NUMBER_TEXTURE_CUBE_MAP_NEGATIVE_Z ?
                   NUMBER_TEXTURE_BINDING_CUBE_MAP : 0;
    }
}

static void note_storage(uint32_t target, uint32_t internal)
{
    struct texture *t;
    int32_t name = 0;
    if (!binding_of(target))
        return;
    real.GetIntegerv(binding_of(target), &name);
    t = find_texture((uint32_t)name);
    if (!t && texture_count == texture_room) {
        size_t room = 2 * texture_room + 64;
        struct texture *more = realloc(textures, room * sizeof *more);
        if (!more)
            return;
        textures = more;
        texture_room = room;
    }
    if (!t)
        t = &textures[texture_count++];
    t->gl = real.gl;
    t->name = (uint32_t)name;
    t->is = kind_of(internal);
}

static void GLBK_CALL tex_image_2d(uint32_t target, int32_t level, int32_t internal, int32_t width, int32_t height,
                                   int32_t border, uint32_t format, uint32_t type, const void *data)
{
    note_storage(target, (uint32_t)internal);
    real.TexImage2D(target, level, internal, width, height, border, format, type, data);
}

static void GLBK_CALL tex_image_3d(uint32_t target, int32_t level, int32_t internal, int32_t width, int32_t height,
                                   int32_t depth, int32_t border, uint32_t format, uint32_t type, const void *data)
{
    note_storage(target, (uint32_t)internal);
    real.TexImage3D(target, level, internal, width, height, depth, border, format, type, data);
}

static void GLBK_CALL tex_storage_2d(uint32_t target, int32_t levels, uint32_t internal, int32_t width, int32_t height)
{
    note_storage(target, internal);
    real.TexStorage2D(target, levels, internal, width, height);
}

static void GLBK_CALL tex_storage_3d(uint32_t target, int32_t levels, uint32_t internal, int32_t width, int32_t height,
                                     int32_t depth)
{
    note_storage(target, internal);
    real.TexStorage3D(target, levels, internal, width, height, depth);
}

static void GLBK_CALL delete_textures(int32_t count, const uint32_t *names)
{
    for (int32_t i = 0; i < count; i++) {
        struct texture *t = find_texture(names[i]);
        if (t)
            *t = textures[--texture_count];
    }
    real.DeleteTextures(count, names);
}

void ex_gl_watch_current(ex_gl *gl) { real.gl = gl; }

void ex_gl_watch_forget(const ex_gl *gl)
{
    for (size_t i = 0; i < texture_count;)
        if (textures[i].gl == gl)
            textures[i] = textures[--texture_count];
        else
            i++;
    if (texture_count)
        return;
    free(textures);
    textures = NULL;
    texture_room = 0;
}

/* ---- before a draw ---- */

static const struct sampler {
    uint32_t type, target;
    kind     reads;
} samplers[] = {
    { NUMBER_SAMPLER_2D, GLBK_GL_TEXTURE_2D, KIND_FLOAT },
    { NUMBER_SAMPLER_3D, NUMBER_TEXTURE_3D, KIND_FLOAT },
    { NUMBER_SAMPLER_CUBE, NUMBER_TEXTURE_CUBE_MAP, KIND_FLOAT },
    { NUMBER_SAMPLER_2D_ARRAY, GLBK_GL_TEXTURE_2D_ARRAY, KIND_FLOAT },
    { NUMBER_INT_SAMPLER_2D, GLBK_GL_TEXTURE_2D, KIND_INT },
    { NUMBER_INT_SAMPLER_3D, NUMBER_TEXTURE_3D, KIND_INT },
    { NUMBER_INT_SAMPLER_CUBE, NUMBER_TEXTURE_CUBE_MAP, KIND_INT },
    { NUMBER_INT_SAMPLER_2D_ARRAY, GLBK_GL_TEXTURE_2D_ARRAY, KIND_INT },
    { NUMBER_UNSIGNED_INT_SAMPLER_2D, GLBK_GL_TEXTURE_2D, KIND_UINT },
    { NUMBER_UNSIGNED_INT_SAMPLER_3D, NUMBER_TEXTURE_3D, KIND_UINT },
    { NUMBER_UNSIGNED_INT_SAMPLER_CUBE, NUMBER_TEXTURE_CUBE_MAP, KIND_UINT },
    { NUMBER_UNSIGNED_INT_SAMPLER_2D_ARRAY, GLBK_GL_TEXTURE_2D_ARRAY, KIND_UINT },
    { NUMBER_SAMPLER_2D_SHADOW, GLBK_GL_TEXTURE_2D, KIND_COMPARED },
    { NUMBER_SAMPLER_CUBE_SHADOW, NUMBER_TEXTURE_CUBE_MAP, KIND_COMPARED },
    { NUMBER_SAMPLER_2D_ARRAY_SHADOW, GLBK_GL_TEXTURE_2D_ARRAY, KIND_COMPARED }
};

/* Is a level of this texture that the sampler may read attached to what is drawn to? */
static int is_drawn_to(const struct sampler *s, int32_t name)
{
    int32_t target = 0, type, attached, level, least = 0, most = 0;
    real.GetIntegerv(0x8CA6 /* DRAW_FRAMEBUFFER_BINDING */, &target);
    if (!target)
        return 0;
    real.GetTexParameteriv(s->target, 0x813C /* BASE_LEVEL */, &least);
    real.GetTexParameteriv(s->target, 0x813D /* MAX_LEVEL */, &most);
    for (uint32_t i = 0; i < 5; i++) {
        const uint32_t at = i < 4 ? GLBK_GL_COLOR_ATTACHMENT0 + i : (uint32_t)GLBK_GL_DEPTH_ATTACHMENT;
        type = attached = level = 0;
        real.GetFramebufferAttachmentParameteriv(GLBK_GL_DRAW_FRAMEBUFFER, at, 0x8CD0 /* OBJECT_TYPE */, &type);
        if (type != 0x1702 /* TEXTURE */)
            continue;
        real.GetFramebufferAttachmentParameteriv(GLBK_GL_DRAW_FRAMEBUFFER, at, 0x8CD1 /* OBJECT_NAME */, &attached);
        real.GetFramebufferAttachmentParameteriv(GLBK_GL_DRAW_FRAMEBUFFER, at, 0x8CD2 /* LEVEL */, &level);
        if (attached == name && level >= least && level <= most)
            return 1;
    }
    return 0;
}

/* A sampler and what is bound on its unit, which is made the active one. Nothing bound suits every sampler. */
static void look_at_unit(const struct sampler *s, const char *name, int32_t unit, int draws)
{
    const struct texture *t;
    int32_t bound = 0, object = 0, mode = 0;
    char text[240];
    kind is;
    real.ActiveTexture(GLBK_GL_TEXTURE0 + (uint32_t)unit);
    real.GetIntegerv(binding_of(s->target), &bound);
    t = find_texture((uint32_t)bound);
    if (!bound || !t)
        return;
    is = t->is;
    if (is == KIND_DEPTH) {
        real.GetIntegerv(0x8919 /* SAMPLER_BINDING */, &object);
        if (object)
            real.GetSamplerParameteriv((uint32_t)object, 0x884C /* COMPARE_MODE */, &mode);
        else
            real.GetTexParameteriv(s->target, 0x884C, &mode);
        if (mode)
            is = KIND_COMPARED;
    }
    if (is != s->reads && (is != KIND_DEPTH || s->reads != KIND_FLOAT)) {
        snprintf(text, sizeof text, "a draw where the sampler %s, of %s, has a texture of %s on its unit %d", name,
                 kind_names[s->reads], kind_names[is], (int)unit);
        ex_gl_note(real.gl, text);
    }
    if (draws && is_drawn_to(s, bound)) {
        snprintf(text, sizeof text, "a draw to the texture that the sampler %s has on its unit %d", name, (int)unit);
        ex_gl_note(real.gl, text);
    }
}

static void look_at_sampler(const struct sampler *s, uint32_t program, uint32_t index, int draws)
{
    char name[100] = "", element[120];
    int32_t size = 0, unit;
    uint32_t type = 0;
    real.GetActiveUniform(program, index, sizeof name, NULL, &size, &type, name);
    for (int32_t k = 0; k < size; k++) {
        if (size > 1)
            snprintf(element, sizeof element, "%.*s[%d]", (int)strcspn(name, "["), name, (int)k);
        else
            snprintf(element, sizeof element, "%s", name);
        unit = 0;
        real.GetUniformiv(program, real.GetUniformLocation(program, element), &unit);
        look_at_unit(s, element, unit, draws);
    }
}

static void look_at_samplers(uint32_t program, int draws)
{
    enum { MOST = 200 };
    uint32_t indices[MOST];
    int32_t types[MOST], count = 0, active = 0;
    real.GetProgramiv(program, 0x8B86 /* ACTIVE_UNIFORMS */, &count);
    if (count > MOST)
        count = MOST;
    if (!count)
        return;
    for (int32_t i = 0; i < count; i++) indices[i] = (uint32_t)i;
    real.GetActiveUniformsiv(program, count, indices, 0x8A37 /* UNIFORM_TYPE */, types);
    real.GetIntegerv(0x84E0 /* ACTIVE_TEXTURE */, &active);
    for (int32_t i = 0; i < count; i++)
        for (size_t k = 0; k < sizeof samplers / sizeof samplers[0]; k++)
            if (samplers[k].type == (uint32_t)types[i])
                look_at_sampler(&samplers[k], program, (uint32_t)i, draws);
    real.ActiveTexture((uint32_t)active);
}

static void look_at_blocks(uint32_t program)
{
    int32_t count = 0, i, binding, buffer;
    real.GetProgramiv(program, 0x8A36 /* ACTIVE_UNIFORM_BLOCKS */, &count);
    for (i = 0; i < count; i++) {
        char name[80] = "", text[160];
        binding = buffer = 0;
        real.GetActiveUniformBlockiv(program, (uint32_t)i, 0x8A3F /* UNIFORM_BLOCK_BINDING */, &binding);
        real.GetIntegeri_v(0x8A28 /* UNIFORM_BUFFER_BINDING */, (uint32_t)binding, &buffer);
        if (buffer)
            continue;
        real.GetActiveUniformBlockName(program, (uint32_t)i, sizeof name, NULL, name);
        snprintf(text, sizeof text, "a draw without a buffer for the uniform block %s", name);
        ex_gl_note(real.gl, text);
    }
}

static void look(int draws)
{
    int32_t program = 0;
    real.GetIntegerv(0x8B8D /* CURRENT_PROGRAM */, &program);
    if (!program)
        return;
    look_at_blocks((uint32_t)program);
    look_at_samplers((uint32_t)program, draws);
}

static void GLBK_CALL draw_arrays(uint32_t mode, int32_t first, int32_t count)
{
    look(1);
    real.DrawArrays(mode, first, count);
}

static void GLBK_CALL draw_elements(uint32_t mode, int32_t count, uint32_t type, const void *offset)
{
    look(1);
    real.DrawElements(mode, count, type, offset);
}

static void GLBK_CALL draw_arrays_instanced(uint32_t mode, int32_t first, int32_t count, int32_t instances)
{
    look(1);
    real.DrawArraysInstanced(mode, first, count, instances);
}

static void GLBK_CALL draw_elements_instanced(uint32_t mode, int32_t count, uint32_t type, const void *offset,
                                              int32_t instances)
{
    look(1);
    real.DrawElementsInstanced(mode, count, type, offset, instances);
}

static void GLBK_CALL dispatch(uint32_t x, uint32_t y, uint32_t z)
{
    look(0);
    real.DispatchCompute(x, y, z);
}

static void GLBK_CALL dispatch_indirect(ptrdiff_t offset)
{
    look(0);
    real.DispatchComputeIndirect(offset);
}

#define LOAD(name) \
    if ((other = get("gl" #name)) == NULL) return proc; \
    memcpy(&real.name, &other, sizeof other);

/* The function of that name, or one that looks first and then calls it. */
glbk_proc_fn ex_gl_watch(const char *name, glbk_proc_fn proc, glbk_proc_fn (*get)(const char *))
{
    static const struct { const char *name; void *real; glbk_proc_fn watched; } calls[] = {
        { "glDrawArrays", &real.DrawArrays, (glbk_proc_fn)draw_arrays },
        { "glDrawElements", &real.DrawElements, (glbk_proc_fn)draw_elements },
        { "glDrawArraysInstanced", &real.DrawArraysInstanced, (glbk_proc_fn)draw_arrays_instanced },
        { "glDrawElementsInstanced", &real.DrawElementsInstanced, (glbk_proc_fn)draw_elements_instanced },
        { "glDispatchCompute", &real.DispatchCompute, (glbk_proc_fn)dispatch },
        { "glDispatchComputeIndirect", &real.DispatchComputeIndirect, (glbk_proc_fn)dispatch_indirect },
        { "glTexImage2D", &real.TexImage2D, (glbk_proc_fn)tex_image_2d },
        { "glTexImage3D", &real.TexImage3D, (glbk_proc_fn)tex_image_3d },
        { "glTexStorage2D", &real.TexStorage2D, (glbk_proc_fn)tex_storage_2d },
        { "glTexStorage3D", &real.TexStorage3D, (glbk_proc_fn)tex_storage_3d },
        { "glDeleteTextures", &real.DeleteTextures, (glbk_proc_fn)delete_textures }
    };
    for (size_t i = 0; proc && i < sizeof calls / sizeof calls[0]; i++) {
        glbk_proc_fn other;
        if (strcmp(name, calls[i].name) != 0)
            continue;
        LOAD(GetIntegerv)
        LOAD(GetIntegeri_v)
        LOAD(GetProgramiv)
        LOAD(GetActiveUniformBlockiv)
        LOAD(GetActiveUniformBlockName)
        LOAD(GetActiveUniformsiv)
        LOAD(GetActiveUniform)
        LOAD(GetUniformLocation)
        LOAD(GetUniformiv)
        LOAD(GetTexParameteriv)
        LOAD(GetSamplerParameteriv)
        LOAD(GetFramebufferAttachmentParameteriv)
        LOAD(ActiveTexture)
        memcpy(calls[i].real, &proc, sizeof proc);
        return calls[i].watched;
    }
    return proc;
}
