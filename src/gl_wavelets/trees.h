/* ---- wavelets: fields as trees ---- */

enum { GLBK__HAAR_SQUARES = 1365 };     /* of a face of 64 x 64 texels: 1 + 4 + 16 + ... */

/* A face of a sample while its tree is made. The squares of all levels are numbered one after the other, so
   that the quarters of square k are squares 4 k + 1 to 4 k + 4. */
typedef struct glbk__haar_tree {
    uint32_t side, channels, squares;   /* squares: of all levels */
    float    scale;                     /* of the sample */
    float    coef[3][4096];             /* 0 between two faces */
    float    mean[3][4 * GLBK__HAAR_SQUARES + 1];
    uint8_t  mark[GLBK__HAAR_SQUARES];          /* 1: wavelets lie in the square or in its quarters */
} glbk__haar_tree;

/* The lists of a file of wavelets. */
typedef struct glbk__haar_lists {
    const uint8_t *offsets, *scales, *entries;
    uint32_t       samples, words;      /* words of an entry */
} glbk__haar_lists;

static glbk__haar_lists glbk__haar_lists_of(const uint8_t *bytes, const glbk__sfield_view *v)
{
    glbk__haar_lists l;
    l.offsets = bytes + v->scales;
    l.samples = v->samples;
    l.scales = l.offsets + 4 * ((size_t)v->samples + 1);
    l.entries = l.scales + 4 * (size_t)v->samples;
    l.words = v->stride;
    return l;
}

/* Returns the bytes of entry i. glbk__haar_face moves *end past those entries of a sample whose number is
   below `texels`: there the entries of the next face begin. */
static const uint8_t *glbk__haar_entry(const glbk__haar_lists *l, size_t i)
{
    return l->entries + 4 * i * l->words;
}

static void glbk__haar_face(const glbk__haar_lists *l, uint32_t sample, uint32_t texels, size_t *end)
{
    const size_t last = glbk_haar__get_u32(l->offsets + 4 * ((size_t)sample + 1));
    while (*end < last && glbk_haar__get_u32(glbk__haar_entry(l, *end)) >> 16 < texels) (*end)++;
}

/* Marks the squares of a face's entries and all above these. Returns how many nodes the tree has but the
   root. */
static uint32_t glbk__haar_mark(glbk__haar_tree *t, const glbk__haar_lists *l, size_t from, size_t end)
{
    const uint32_t in_face = t->side * t->side - 1;
    uint32_t nodes = 0;
    memset(t->mark, 0, t->squares);
    for (; from < end; from++) {
        uint32_t k = glbk_haar__get_u32(glbk__haar_entry(l, from)) >> 16 & in_face;
        if (!k) continue;
        for (k = (k - 1) / 3; k && !t->mark[k]; k = (k - 1) / 4) {
            t->mark[k] = 1;
            nodes++;
        }
    }
    return nodes;
}

/* Writes the coefficients of a face's entries, or zeros in their places. */
static void glbk__haar_scatter(glbk__haar_tree *t, const glbk__haar_lists *l, size_t from, size_t end,
                               float scale)
{
    const uint32_t in_face = t->side * t->side - 1;
    for (; from < end; from++) {
        const uint8_t *e = glbk__haar_entry(l, from);
        const uint32_t first = glbk_haar__get_u32(e), at = first >> 16 & in_face;
        uint32_t value[3], c;
        value[0] = first;
        value[1] = l->words > 1 ? glbk_haar__get_u32(e + 4) >> 16 : 0;
        value[2] = l->words > 1 ? glbk_haar__get_u32(e + 4) : 0;
        for (c = 0; c < t->channels; c++)
            t->coef[c][at] = scale * ((float)(int32_t)((value[c] & 0xffffu) ^ 0x8000u) - 32768.0f);
    }
}

/* Computes the means of the quarters of square k, which has so many texels a side. Returns the greatest. */
static float glbk__haar_quarter(glbk__haar_tree *t, uint32_t k, float side)
{
    float most = 0, scale = 1 / side;
    uint32_t c, q;
    for (c = 0; c < t->channels; c++)
        for (q = 0; q < 4; q++) {
            const float *w = t->coef[c] + 1 + 3 * k, x = q & 1 ? -scale : scale, y = q & 2 ? -scale : scale;
            const float z = q == 0 || q == 3 ? scale : -scale;
            const float mean = t->mean[c][k] + x * w[0] + y * w[1] + z * w[2];
            t->mean[c][4 * k + 1 + q] = mean;
            most = fabsf(mean) > most ? fabsf(mean) : most;
        }
    return most;
}

/* Writes the node of square k, whose quarters' first node is texel `below` of the table. Returns how many
   quarters have a node. */
static uint32_t glbk__haar_node(glbk__haar_tree *t, uint32_t k, float side, uint32_t below,
                                glbk__sfield_stage *s)
{
    const float most = glbk__haar_quarter(t, k, side), scale = most / 32767;
    uint32_t *texel = glbk__sfield_texel(s), *second = texel;
    uint32_t q, c, nodes = 0, mask = 0;
    for (q = 0; q < 4; q++) {
        const uint32_t quarter = 4 * k + 1 + q;
        if (quarter >= t->squares || !t->mark[quarter]) continue;
        mask |= 1u << q;
        nodes++;
    }
    texel[2] = mask << 28 | (mask ? below : 0);     /* past the last of 2^28 texels it has 29 bits */
    memcpy(texel + 3, &scale, 4);
    for (c = 0; c < t->channels; c++) {
        if (c == 1) second = glbk__sfield_texel(s);
        for (q = 0; q < 4; q++) {
            const float x = scale > 0 ? t->mean[c][4 * k + 1 + q] / scale : 0;
            const uint32_t bits = (uint32_t)(int32_t)(x + (x < 0 ? -0.5f : 0.5f)) & 0xffffu;
            second[(c > 1 ? 2 : 0) + q / 2] |= bits << q % 2 * 16;
        }
    }
    return nodes;
}

/* Writes the tree of a face: its root to one stage, all other nodes to the other, level by level. */
static void glbk__haar_plant(glbk__haar_tree *t, glbk__sfield_stage *roots, glbk__sfield_stage *nodes)
{
    const uint32_t step = t->channels > 1 ? 2 : 1;
    uint32_t k, level_end = 1, below = (uint32_t)(nodes->at + nodes->count), c;
    float side = (float)t->side;
    for (c = 0; c < t->channels; c++) t->mean[c][0] = t->coef[c][0] / side;
    for (k = 0; k < t->squares; k++) {
        if (k == level_end) {
            level_end = 4 * level_end + 1;
            side *= 0.5f;
        }
        if (!k || t->mark[k]) below += step * glbk__haar_node(t, k, side, below, k ? nodes : roots);
    }
}

/* Counts the nodes of a file but the roots or, with stages, writes all trees. */
static uint64_t glbk__haar_trees(glbk__haar_tree *t, const glbk__haar_lists *l,
                                 glbk__sfield_stage *roots, glbk__sfield_stage *nodes)
{
    const uint32_t texels = t->side * t->side;
    uint64_t count = 0;
    uint32_t sample, face;
    for (sample = 0; sample < l->samples; sample++) {
        size_t from = glbk_haar__get_u32(l->offsets + 4 * (size_t)sample), end = from;
        for (face = 0; face < 6; face++, from = end) {
            glbk__haar_face(l, sample, (face + 1) * texels, &end);
            count += glbk__haar_mark(t, l, from, end);
            if (!roots) continue;
            glbk__haar_scatter(t, l, from, end, glbk_haar__get_f32(l->scales + 4 * (size_t)sample));
            glbk__haar_plant(t, roots, nodes);
            glbk__haar_scatter(t, l, from, end, 0);
        }
    }
    return count;
}
