/* ---- layout: blocks to lines ---- */

/* Gives lists their places. Lists come in order of chunk and pixel, whoever made them, and so always get the
   same places. A dry run with NULL pointers counts, and a second run writes. Tails go where they fit best
   among a few lines that still have room. */

enum { COHSM__OPEN_LINES = 16 };

typedef struct cohsm__layout {
    uint32_t *directories, *lines;      /* NULL: a dry run */
    uint64_t  directory_words, line_count;  /* how many were given out */
    uint64_t  open[COHSM__OPEN_LINES];  /* lines that still have room */
    uint32_t  used[COHSM__OPEN_LINES];  /* words of them that are taken; 0: there is no such line */
} cohsm__layout;

/* Returns a line with room for a tail, near enough to the next list; a new line if there is none. */
static int cohsm__open_line(cohsm__layout *l, uint32_t words)
{
    int i, best = -1, oldest = 0;
    for (i = 0; i < COHSM__OPEN_LINES; i++) {
        if (l->used[i] && l->line_count - l->open[i] > COHSM__FARTHEST_TAIL) l->used[i] = 0;
        if (l->used[i] && l->used[i] + words <= COHSM__BLOCK_WORDS &&
            (best < 0 || l->used[i] > l->used[best]))
            best = i;
    }
    if (best >= 0) return best;
    for (i = 1; i < COHSM__OPEN_LINES; i++)         /* an unused place, else the fullest line gives way */
        if (l->used[oldest] && (!l->used[i] || l->used[i] > l->used[oldest])) oldest = i;
    l->open[oldest] = l->line_count++;
    l->used[oldest] = 0;
    return oldest;
}

/* Lays a list of count blocks: a tail, and before it full blocks. The first views of the blocks are half
   words of firsts, that of block b at firsts_at + b. */
static void cohsm__lay_list(cohsm__layout *l, uint32_t *lookup, uint32_t count, const uint32_t *firsts,
                            uint32_t firsts_at, const uint32_t *full, const uint32_t *tail)
{
    uint32_t words = cohsm__block_words(tail), b, *directory;
    int open = cohsm__open_line(l, words);
    uint64_t base = l->line_count;

    if (l->lines) {
        *lookup = (uint32_t)l->directory_words;
        directory = l->directories + l->directory_words;
        directory[0] = (uint32_t)base;
        directory[1] = count | l->used[open] << 16 | (uint32_t)(base - l->open[open]) << 20;
        for (b = 1; b < count; b++)
            cohsm__put_bits(directory, 16u * (b + 3u), 16, cohsm__half_word(firsts, firsts_at + b));
        memcpy(l->lines + COHSM__BLOCK_WORDS * base, full, 4 * (size_t)COHSM__BLOCK_WORDS * (count - 1u));
        memcpy(l->lines + COHSM__BLOCK_WORDS * l->open[open] + l->used[open], tail, 4 * (size_t)words);
    }
    l->used[open] += words;
    if (l->used[open] + 3u > COHSM__BLOCK_WORDS) l->used[open] = 0;     /* no block is shorter than 3 words */
    l->line_count += count - 1u;
    l->directory_words += 2u + count / 2u;
}

/* Lays a list as cohsm__write_list left it. */
static void cohsm__lay_raw(cohsm__layout *l, uint32_t *lookup, const uint32_t *list)
{
    uint32_t count = list[0] & 0xffffu;
    const uint32_t *full = list + (count + 1u) / 2u;
    cohsm__lay_list(l, lookup, count, list, 0, full, full + COHSM__BLOCK_WORDS * (size_t)(count - 1u));
}
