/* unit gl_memory, needs mem: the allocator of a glbk_context (gl_backend.h) */

static inline P_allocator P_memory(const glbk_context *ctx)
{
    const glbk_allocator *a = &ctx->system.allocator;
    return P_allocator_make(a->alloc_fn, a->free_fn, a->user);
}
