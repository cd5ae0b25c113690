/* gl_watch.c - an error that drivers let pass and browsers do not: a draw with a uniform block that has no buffer. All
   blocks that a program declares count (std140), whether it reads them or not. */
#include "gl_internal.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>

/* The context whose functions were asked for last: what is drawn is drawn by them. */
static struct {
    ex_gl *gl;
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
} real;

static void look_at_blocks(void)
{
    int32_t program = 0, count = 0, i, binding, buffer;
    real.GetIntegerv(0x8B8D /* CURRENT_PROGRAM */, &program);
    if (!program)
        return;
    real.GetProgramiv((uint32_t)program, 0x8A36 /* ACTIVE_UNIFORM_BLOCKS */, &count);
    for (i = 0; i < count; i++) {
        char name[80] = "", text[160];
        binding = buffer = 0;
        real.GetActiveUniformBlockiv((uint32_t)program, (uint32_t)i, 0x8A3F /* UNIFORM_BLOCK_BINDING */, &binding);
        real.GetIntegeri_v(0x8A28 /* UNIFORM_BUFFER_BINDING */, (uint32_t)binding, &buffer);
        if (buffer)
            continue;
        real.GetActiveUniformBlockName((uint32_t)program, (uint32_t)i, sizeof name, NULL, name);
        snprintf(text, sizeof text, "a draw without a buffer for the uniform block %s", name);
        ex_gl_note(real.gl, text);
    }
}

static void GLBK_CALL draw_arrays(uint32_t mode, int32_t first, int32_t count)
{
    look_at_blocks();
    real.DrawArrays(mode, first, count);
}

static void GLBK_CALL draw_elements(uint32_t mode, int32_t count, uint32_t type, const void *offset)
{
    look_at_blocks();
    real.DrawElements(mode, count, type, offset);
}

static void GLBK_CALL draw_arrays_instanced(uint32_t mode, int32_t first, int32_t count, int32_t instances)
{
    look_at_blocks();
    real.DrawArraysInstanced(mode, first, count, instances);
}

static void GLBK_CALL draw_elements_instanced(uint32_t mode, int32_t count, uint32_t type, const void *offset,
                                              int32_t instances)
{
    look_at_blocks();
    real.DrawElementsInstanced(mode, count, type, offset, instances);
}

static void GLBK_CALL dispatch(uint32_t x, uint32_t y, uint32_t z)
{
    look_at_blocks();
    real.DispatchCompute(x, y, z);
}

static void GLBK_CALL dispatch_indirect(ptrdiff_t offset)
{
    look_at_blocks();
    real.DispatchComputeIndirect(offset);
}

#define LOAD(name) \
    if ((other = get("gl" #name)) == NULL) return proc; \
    memcpy(&real.name, &other, sizeof other);

/* The function of that name, or one that looks first and then calls it. */
glbk_proc ex_gl_watch(const char *name, glbk_proc proc, glbk_proc (*get)(const char *), ex_gl *gl)
{
    static const struct { const char *name; void *real; glbk_proc watched; } draws[] = {
        { "glDrawArrays", &real.DrawArrays, (glbk_proc)draw_arrays },
        { "glDrawElements", &real.DrawElements, (glbk_proc)draw_elements },
        { "glDrawArraysInstanced", &real.DrawArraysInstanced, (glbk_proc)draw_arrays_instanced },
        { "glDrawElementsInstanced", &real.DrawElementsInstanced, (glbk_proc)draw_elements_instanced },
        { "glDispatchCompute", &real.DispatchCompute, (glbk_proc)dispatch },
        { "glDispatchComputeIndirect", &real.DispatchComputeIndirect, (glbk_proc)dispatch_indirect }
    };
    for (size_t i = 0; proc && i < sizeof draws / sizeof draws[0]; i++) {
        glbk_proc other;
        if (strcmp(name, draws[i].name) != 0)
            continue;
        LOAD(GetIntegerv)
        LOAD(GetIntegeri_v)
        LOAD(GetProgramiv)
        LOAD(GetActiveUniformBlockiv)
        LOAD(GetActiveUniformBlockName)
        memcpy(draws[i].real, &proc, sizeof proc);
        real.gl = gl;
        return draws[i].watched;
    }
    return proc;
}
