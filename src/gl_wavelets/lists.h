/* ---- wavelets: fields as lists of coefficients, for compute shaders ----

   A compute shader adds the lists round a point up in shared memory, as the CPU does, where fragment shaders
   have to read each texel from trees by itself. The lists are those of a file of sfield_write, but for the
   number of a coefficient, which becomes its place in shared memory. */

enum { GLBK__HAAR_SHARED = 32 };        /* texels a side that compute shaders have shared memory for */

/* Finds the column and the row of texel i of a face, from its place in Morton order. */
static void glbk__haar_unfold(uint32_t i, uint32_t *x, uint32_t *y)
{
    uint32_t bit;
    for (*x = *y = bit = 0; bit < 6; bit++) {
        *x |= (i >> 2 * bit & 1) << bit;
        *y |= (i >> (2 * bit + 1) & 1) << bit;
    }
}

/* Returns the place of a coefficient in W of prog/sfield_haar_shade.comp: wavelet k of a square stands where
   quarter k of the square begins. */
static uint32_t glbk__haar_place(uint32_t side, uint32_t index)
{
    const uint32_t texels = side * side;
    uint32_t squares = 1, at = index & (texels - 1), x, y;
    if (at) {
        while (4 * squares <= at) squares *= 4;
        at = texels / (4 * squares) * (4 * ((at - squares) / 3) + (at - squares) % 3 + 1);
    }
    glbk__haar_unfold(at, &x, &y);
    return (index / texels * (side + 2) + y + 1) * (side + 2) + x + 1;
}

/* Counts the texels of the entries of a file or, with stages, writes its lists: a texel for each sample to
   one stage, entries to the other. */
static uint64_t glbk__haar_copy(const glbk__haar_tree *t, const glbk__haar_lists *l,
                                glbk__sfield_stage *samples, glbk__sfield_stage *entries)
{
    uint32_t sample, word, *texel, *to = NULL;
    uint64_t count = 0;
    for (sample = 0; sample < l->samples; sample++) {
        const uint32_t first = glbk_haar__get_u32(l->offsets + 4 * (size_t)sample),
                       end = glbk_haar__get_u32(l->offsets + 4 * ((size_t)sample + 1)),
                       words = (end - first) * l->words;
        const uint8_t *from = glbk__haar_entry(l, first);
        count += (words + 3) / 4;
        if (!samples) continue;
        texel = glbk__sfield_texel(samples);
        texel[0] = (uint32_t)(entries->at + entries->count);
        texel[1] = words;
        texel[2] = glbk_haar__get_u32(l->scales + 4 * (size_t)sample);
        for (word = 0; word < words; word++) {
            const uint32_t entry = glbk_haar__get_u32(from + 4 * (size_t)word), index = entry >> 16;
            if (word % 4 == 0) to = glbk__sfield_texel(entries);
            to[word % 4] = entry;
            if (word % l->words) continue;
            to[word % 4] = glbk__haar_place(t->side, index) << 16 | (entry & 0xffffu);
            texel[3] |= 1u << index / (t->side * t->side);
        }
    }
    return count;
}
