/* ---- csm: programs that are kept ---- */

/* Returns the place of a key in the cache: where it is kept, else a free one, else that of the program that
   was used longest ago, which is freed. Returns NULL if all were used in this frame, since the same programs
   would be compiled again and again. */
static glbk_program *glbk__csm_keep_program(glbk_context *ctx, glbk_csm_programs *cache, uint32_t key,
                                            uint32_t *at)
{
    uint32_t i, oldest = 0;
    for (i = 0; i < cache->count && cache->keys[i] != key; i++)
        if (cache->frame - cache->used[i] > cache->frame - cache->used[oldest]) oldest = i;
    if (i == GLBK_CSM_MAX_PROGRAMS) {
        if (cache->used[oldest] == cache->frame) return NULL;
        i = oldest;
        glbk_program_free(ctx, &cache->list[i]);
        cache->keys[i] = UINT32_MAX;        /* no key, in case that its successor does not compile */
    }
    *at = i;
    return &cache->list[i];
}

/* Finds or compiles a program of a cache, for a public function. texts are the defines of this use, which
   those of the maps follow, and GLSL of the user's before the main, or NULL. Programs named csm_shade read
   the G-buffer. */
static glbk_result glbk__csm_program(glbk_context *ctx, const char *function, glbk_csm_programs *cache,
                                     uint32_t key, const char *name,
                                     const char *const texts[2], const glbk_csm_maps *maps,
                                     glbk_program **out)
{
    char all[208] = { 0 };
    const char *own[2];
    glbk__sink sink = { NULL, 0, 0 };
    glbk_result result;
    uint32_t i;

    key = key << 13 | maps->key;
    *out = glbk__csm_keep_program(ctx, cache, key, &i);
    if (!*out)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function,
                                  "the number of programs that the uses of one frame need",
                                  GLBK_CSM_MAX_PROGRAMS + 1, 0, GLBK_CSM_MAX_PROGRAMS);
    cache->used[i] = cache->frame;
    if ((*out)->name) return GLBK_OK;
    own[0] = NULL;
    own[1] = texts[1];
    sink.out = all;
    sink.bytes = sizeof all;
    glbk__append_text(&sink, texts[0]);
    glbk__append_text(&sink, maps->defines);
    result = glbk__gbuffer_program_with(ctx, glbk_csm_part(), name, all, own, *out);
    if (result != GLBK_OK) return result;
    cache->keys[i] = key;
    if (i == cache->count) cache->count++;
    return GLBK_OK;
}

static void glbk__csm_programs_free(glbk_context *ctx, glbk_csm_programs *cache)
{
    uint32_t i;
    for (i = 0; i < cache->count; i++) glbk_program_free(ctx, &cache->list[i]);
    cache->count = 0;
}
