/* ---- pack: lists cut into blocks again ---- */

/* Returns how many of the segments fit into a block without a palette, as cohsm__plan_take would find if each
   segment had only the value that was stored. */
static uint32_t cohsm__count_fitting(const cohsm__segment *s, uint32_t count, uint32_t grid, uint32_t views)
{
    uint32_t n, least = grid, most = 0, exact = 0;
    uint32_t k = 0, bits = 2, span;

    for (n = 0; n < count && n < COHSM__MARKS; n++) {
        span = cohsm__segment_end(s, n, count, views) - s[0].first;
        if (s[n].exact) exact++;
        else if (s[n].lo < grid) {
            least = cohsm__min_u32(least, s[n].lo);
            most = cohsm__max_u32(most, s[n].lo);
        }
        while (n + 1u + ((span - 1u) >> k) > COHSM__MARKS) k++;
        while (least < most && (1u << bits) - 2u < most - least + 1u) bits++;
        if (COHSM__LOW_AT + (n + 1u) * (k + bits) + 16u * exact > COHSM__BLOCK_BITS) break;
    }
    return n;
}

/* Codes how many segments each block takes. They may be more than cohsm__count_fitting finds by their values,
   since the builder went by intervals, in which it could choose the values. */
static uint32_t cohsm__code_blocks(cohsm__packer *p)
{
    const cohsm__strip *t = &p->strip[COHSM__SELF];
    uint32_t i, n, blocks, left;

    for (i = 0, blocks = 0; i < t->count; i += p->taken[blocks++]) {
        left = t->count - i;
        n = cohsm__count_fitting(t->s + i, left, p->grid.top, p->views);
        left = cohsm__min_u32(left, COHSM__MARKS);
        if (n < left)
            n += cohsm__code_tree(&p->c, p->m->more + 64 * (n / 4u), 6, p->c.out ? p->taken[blocks] - n : 0);
        p->taken[blocks] = (uint8_t)cohsm__min_u32(n, left);
    }
    return blocks;
}

/* Makes the plan of a block of exactly n segments, as cohsm__plan_block would; `last` says that it is a tail.
   Returns 0 if they do not fit. */
static int cohsm__plan_exactly(cohsm__plan *plan, const cohsm__segment *s, uint32_t n,
                               const cohsm__grid *grid, uint32_t end, int last)
{
    cohsm__plan other;

    cohsm__plan_start(plan);
    for (; plan->n + 1u < n; plan->n++) {
        const cohsm__segment *t = &s[plan->n];
        if (t->exact) plan->exact++;
        else if (t->lo < grid->top) {
            plan->least_hi = cohsm__min_u32(plan->least_hi, t->hi);
            plan->greatest_lo = cohsm__max_u32(plan->greatest_lo, t->lo);
        }
    }
    if (!cohsm__plan_take(plan, s, grid, end)) return 0;
    other = *plan;
    if (last && !plan->palette && cohsm__plan_palette(&other, s, grid) && other.size < plan->size)
        *plan = other;
    return 1;
}

/* Writes the decoded list as the builder would keep it, see cohsm__write_list. Returns 0 if no builder wrote
   this. */
static int cohsm__strip_write(const cohsm__packer *p, uint32_t blocks)
{
    const cohsm__segment *s = p->strip[COHSM__SELF].s;
    uint32_t count = p->strip[COHSM__SELF].count, i, n, end;
    uint32_t *block = p->list + (blocks + 1u) / 2u;
    cohsm__plan plan;

    if (blocks > cohsm__blocks_bound(count)) return 0;
    memset(p->list, 0, 4 * cohsm__list_bound(count));
    p->list[0] = blocks;
    for (i = 0; i < blocks; i++, s += n, count -= n, block += COHSM__BLOCK_WORDS) {
        n = p->taken[i];
        end = cohsm__segment_end(s, n - 1u, count, p->views);
        if (!cohsm__plan_exactly(&plan, s, n, &p->grid, end, n == count)) return 0;
        if (i) cohsm__put_bits(p->list, 16u * i, 16, s[0].first);
        cohsm__write_block(block, s, &plan, &p->grid);
    }
    return 1;
}

/* Lays the decoded list where it belongs. Returns 0 if there is no room, or if no builder wrote this list. */
static int cohsm__strip_lay(const cohsm__packer *p, const cohsm__header *h, uint32_t blocks, cohsm__layout *l,
                            uint32_t *entry)
{
    const cohsm__segment *s = p->strip[COHSM__SELF].s;
    cohsm__layout dry = *l;

    if (p->strip[COHSM__SELF].count == 1) {
        *entry = COHSM__CONSTANT | (s->exact ? s->lo : cohsm__grid_depth(s->lo, p->grid.top));
        return 1;
    }
    if (!cohsm__strip_write(p, blocks)) return 0;
    dry.directories = dry.lines = NULL;
    cohsm__lay_raw(&dry, entry, p->list);
    if (dry.directory_words > h->directory_words || dry.line_count > h->line_words / COHSM__BLOCK_WORDS)
        return 0;
    cohsm__lay_raw(l, entry, p->list);
    return 1;
}

/* Moves the strips of the neighbours on by one pixel; the strip of the pixel at hand can be written again. */
static void cohsm__slide_strips(cohsm__packer *p)
{
    cohsm__strip *t = p->strip, spare = t[COHSM__UP_LEFT];
    t[COHSM__UP_LEFT] = t[COHSM__UP];
    t[COHSM__UP] = t[COHSM__UP_RIGHT];
    t[COHSM__UP_RIGHT] = t[COHSM__LEFT];
    t[COHSM__LEFT] = t[COHSM__SELF];
    t[COHSM__SELF] = spare;
}

/* Reads the strips around a pixel of the range; index is that of its lookup entry. Within a row all but the
   upper right strip are there already. */
static void cohsm__look_around(cohsm__packer *p, const cohsm__header *h, uint32_t pixel, size_t index,
                               const cohsm__lists *l)
{
    uint32_t m = h->map_side, x = (h->pixel_begin + pixel) % m;
    cohsm__strip *t = p->strip;

    cohsm__slide_strips(p);
    cohsm__strip_clear(&t[COHSM__SELF]);
    if (x == 0 || pixel == 0) {
        cohsm__strip_clear(&t[COHSM__LEFT]);
        cohsm__strip_clear(&t[COHSM__UP_LEFT]);
        if (pixel >= m) cohsm__strip_read(p, &t[COHSM__UP], l, index - m, NULL);
        else cohsm__strip_clear(&t[COHSM__UP]);
    }
    if (x + 1 < m && pixel + 1 >= m) cohsm__strip_read(p, &t[COHSM__UP_RIGHT], l, index + 1u - m, NULL);
    else cohsm__strip_clear(&t[COHSM__UP_RIGHT]);
}
