/* ---- trays: made from a block ---- */

/* A column is a group of pixels through the buckets of one chunk. Its lists are read in step, bucket by
   bucket, and each bucket's trays are placed in lines of their own. */

enum {
    COHSM__LARGE_LINES = 16 * COHSM__GROUP,     /* room for split trays: 8 lines each, and 8 of depths */
    COHSM__LINE_STEPS = COHSM__LINE_BYTES / 2,
    COHSM__SHARED_LINES = 2 * COHSM__GROUP,     /* lines that 14 bits of steps reach, in which trays of less
                                                   than a line can begin */
    COHSM__NO_TRAY = 0xffff
};

/* A list that is being read: the decoded segments of one of its blocks. */
typedef struct cohsm__cursor {
    const uint32_t *directory;
    uint32_t block, count;              /* the number of the block, and of its segments */
    uint32_t at;                        /* the segment that was read last */
    uint32_t first[COHSM__MARKS + 1];   /* first views within the chunk; the last one is the block's end */
    uint16_t depth[COHSM__MARKS];
} cohsm__cursor;

/* The segments of one pixel in a bucket of views. */
typedef struct cohsm__pieces {
    uint32_t count;
    uint8_t  first[COHSM__BUCKET], code[COHSM__BUCKET];
    uint16_t depth[COHSM__BUCKET];
} cohsm__pieces;

typedef struct cohsm__tray_work {       /* what is needed for one column at a time */
    cohsm__cursor cursor[COHSM__GROUP];
    cohsm__pieces pieces;
    uint8_t       tiny[COHSM__GROUP][COHSM__LINE_BYTES];   /* trays of less than a line */
    uint8_t       large[COHSM__LARGE_LINES][COHSM__LINE_BYTES];
    uint16_t      steps[COHSM__GROUP];  /* the length of each tray in steps of 2 bytes; 0: it is split */
    uint16_t      line[COHSM__GROUP];   /* of a split tray: the number of its first line in `large` */
    uint16_t      split[COHSM__GROUP];  /* of a split tray: it has 2^split parts */
    uint16_t      same[COHSM__GROUP];   /* the pixel whose tray stands for this pixel too, if both have one
                                           segment and the same code; else the pixel itself */
    uint16_t      place[COHSM__GROUP];  /* where the tray begins, in steps from the bucket's first line */
    uint32_t      large_lines;
} cohsm__tray_work;

/* ---- reading lists ---- */

static void cohsm__cursor_decode(cohsm__cursor *c, const cohsm_maps *m, uint32_t views)
{
    const uint32_t *d = c->directory, *block = cohsm__block_at(d, m->lines, c->block);
    const uint32_t begin = c->block ? cohsm__block_first(d, c->block) : 0u, head = block[0];
    const uint64_t marks = cohsm__marks(block);
    const cohsm__fields f = cohsm__block_fields(block, cohsm__popcount(marks));
    const uint32_t ones = (1u << f.bits) - 1u;
    uint32_t j, at, bucket = 0;
    uint32_t exact = f.exact_at, code;

    for (j = 0, at = 0; j < f.n; at++) {
        if (!(marks >> at & 1u)) bucket++;
        else {
            c->first[j] = begin + (bucket << f.k | cohsm__bits(block, COHSM__LOW_AT + j * f.k, f.k));
            j++;
        }
    }
    for (j = 0; j < f.n; j++) {
        code = cohsm__bits(block, f.codes_at + j * f.bits, f.bits);
        if (code == ones) {
            c->depth[j] = (uint16_t)cohsm__bits(block, exact, 16);
            exact += 16;
        } else if (f.palette) c->depth[j] = m->depth_of[cohsm__bits(block, f.palette_at + 8u * code, 8)];
        else c->depth[j] = code + 1u == ones ? (uint16_t)COHSM__INFINITE : m->depth_of[(head & 255u) + code];
    }
    c->count = f.n;
    c->at = 0;
    c->first[f.n] = c->block + 1u < cohsm__block_count(d) ? cohsm__block_first(d, c->block + 1u) : views;
}

static void cohsm__cursor_start(cohsm__cursor *c, const cohsm_maps *m, uint32_t entry, uint32_t views)
{
    memset(c, 0, sizeof *c);
    if (!(entry & COHSM__CONSTANT)) {
        c->directory = m->directories + entry;
        cohsm__cursor_decode(c, m, views);
        return;
    }
    c->count = 1;
    c->depth[0] = (uint16_t)entry;
    c->first[1] = views;
}

static void cohsm__cursor_step(cohsm__cursor *c, const cohsm_maps *m, uint32_t views)
{
    if (++c->at < c->count) return;
    c->block++;
    cohsm__cursor_decode(c, m, views);
}

/* Reads the segments of the views from begin up to end, which is not beyond the chunk. */
static void cohsm__cursor_read(cohsm__cursor *c, const cohsm_maps *m, uint32_t begin, uint32_t end,
                               uint32_t views, cohsm__pieces *pieces)
{
    uint32_t n = 0;

    if (c->first[c->at + 1u] <= begin) cohsm__cursor_step(c, m, views);
    for (;;) {
        const uint16_t depth = c->depth[c->at];
        if (!n || pieces->depth[n - 1u] != depth) {
            pieces->first[n] = (uint8_t)(n ? c->first[c->at] - begin : 0u);
            pieces->depth[n++] = depth;
        }
        if (c->first[c->at + 1u] >= end) break;
        cohsm__cursor_step(c, m, views);
    }
    pieces->count = n;
}

/* ---- trays of a bucket ---- */

static void cohsm__pieces_codes(const cohsm_maps *m, cohsm__pieces *pieces)
{
    const uint32_t top = (1u << m->head.depth_bits) - 1u;
    uint32_t i, code;

    for (i = 0; i < pieces->count; i++) {
        code = (pieces->depth[i] * top + 65534u) / 65535u;
        if (m->depth_of[code] != pieces->depth[i]) code = COHSM__EXACT_CODE;
        pieces->code[i] = (uint8_t)code;
    }
}

/* Returns how many first views and exact depths a tray of the segments from..to - 1 needs. */
static uint32_t cohsm__pieces_load(const cohsm__pieces *pieces, uint32_t from, uint32_t to)
{
    uint32_t load = to - from - 1u, i;
    for (i = from; i < to; i++) load += pieces->code[i] == COHSM__EXACT_CODE;
    return load;
}

/* Writes the segments from..to - 1 as a tray, and returns its bytes. */
static uint32_t cohsm__tray_write(const cohsm__pieces *pieces, uint32_t from, uint32_t to, uint8_t *tray)
{
    uint32_t n = to - from - 1u, i;
    uint8_t *exact = tray + 2u + 2u * n;

    tray[0] = (uint8_t)n;
    for (i = 0; i < n; i++) tray[1u + i] = pieces->first[from + 1u + i];
    for (i = from; i < to; i++) {
        tray[1u + n + i - from] = pieces->code[i];
        if (pieces->code[i] != COHSM__EXACT_CODE) continue;
        *exact++ = (uint8_t)(pieces->depth[i] & 255u);
        *exact++ = (uint8_t)(pieces->depth[i] >> 8);
    }
    return (uint32_t)(exact - tray);
}

/* Finds the segments *from..*to - 1 that lie in a part, one of 2^split of a bucket: the last segment that
   begins at or before the part, and those that begin within it. */
static void cohsm__pieces_part(const cohsm__pieces *pieces, uint32_t split, uint32_t part, uint32_t *from,
                               uint32_t *to)
{
    const uint32_t views = (uint32_t)COHSM__BUCKET >> split, begin = part * views;

    for (*from = 0; *from + 1u < pieces->count && pieces->first[*from + 1u] <= begin; ++*from) continue;
    for (*to = *from + 1u; *to < pieces->count && pieces->first[*to] < begin + views; ++*to) continue;
}

/* Returns the least split by which every part fits into a line; COHSM__SPLITS if none does. */
static uint32_t cohsm__pieces_split(const cohsm__pieces *pieces)
{
    uint32_t split, part, from, to;

    for (split = 1; split < COHSM__SPLITS; split++) {
        for (part = 0; part < 1u << split; part++) {
            cohsm__pieces_part(pieces, split, part, &from, &to);
            if (cohsm__pieces_load(pieces, from, to) > COHSM__TRAY_FIRSTS) break;
        }
        if (part == 1u << split) break;
    }
    return split;
}

/* Writes the depths of all views of a part one by one. */
static void cohsm__tray_list(const cohsm__pieces *pieces, uint32_t from, uint32_t part, uint8_t *line)
{
    uint32_t begin = part * COHSM__SPREAD_VIEWS, i;

    for (i = 0; i < COHSM__SPREAD_VIEWS; i++) {
        while (from + 1u < pieces->count && pieces->first[from + 1u] <= begin + i) from++;
        line[2u * i] = (uint8_t)(pieces->depth[from] & 255u);
        line[2u * i + 1u] = (uint8_t)(pieces->depth[from] >> 8);
    }
}

/* Writes a tray that does not fit into one line into lines of its own. */
static void cohsm__tray_split(cohsm__tray_work *w, uint32_t p)
{
    const uint32_t split = cohsm__pieces_split(&w->pieces), parts = 1u << split;
    uint32_t part, from, to, spread = parts;
    uint8_t(*lines)[COHSM__LINE_BYTES] = w->large + w->large_lines;

    w->steps[p] = 0;
    w->split[p] = (uint16_t)split;
    w->line[p] = (uint16_t)w->large_lines;
    for (part = 0; part < parts; part++) {
        memset(lines[part], 0, COHSM__LINE_BYTES);
        cohsm__pieces_part(&w->pieces, split, part, &from, &to);
        if (cohsm__pieces_load(&w->pieces, from, to) <= COHSM__TRAY_FIRSTS) {
            cohsm__tray_write(&w->pieces, from, to, lines[part]);
            continue;
        }
        memset(lines[part], COHSM__EXACT_CODE, COHSM__LINE_BYTES);
        lines[part][0] = COHSM__TRAY_FIRSTS;
        lines[part][1] = (uint8_t)(spread - part);
        cohsm__tray_list(&w->pieces, from, part, lines[spread++]);
    }
    w->large_lines += spread;
}

/* Makes the trays of all pixels for the bucket that begins at view `begin` of a chunk of so many views. Where
   they stand is decided later. */
static void cohsm__bucket_trays(cohsm__tray_work *w, const cohsm_maps *m, uint32_t pixels, uint32_t begin,
                                uint32_t views)
{
    const uint32_t end = cohsm__min_u32(begin + COHSM__BUCKET, views);
    uint16_t alone[COHSM__BUCKET];      /* for each code, the first pixel with one segment of this code */
    uint32_t p;

    memset(alone, 0xff, sizeof alone);  /* COHSM__NO_TRAY */
    w->large_lines = 0;
    for (p = 0; p < pixels; p++) {
        cohsm__pieces *pieces = &w->pieces;
        cohsm__cursor_read(&w->cursor[p], m, begin, end, views, pieces);
        cohsm__pieces_codes(m, pieces);
        w->same[p] = (uint16_t)p;
        if (cohsm__pieces_load(pieces, 0, pieces->count) > COHSM__TRAY_FIRSTS) {
            cohsm__tray_split(w, p);
            continue;
        }
        w->steps[p] = (uint16_t)(cohsm__tray_write(pieces, 0, pieces->count, w->tiny[p]) / 2u);
        if (pieces->count > 1 || pieces->code[0] == COHSM__EXACT_CODE) continue;
        if (alone[pieces->code[0]] == COHSM__NO_TRAY) alone[pieces->code[0]] = (uint16_t)p;
        w->same[p] = alone[pieces->code[0]];
    }
}

/* ---- places of trays ---- */

/* Lines that still have room, in a list for each number of steps that are left. */
typedef struct cohsm__room {
    uint64_t some;                      /* bit r: a line has r steps left */
    uint16_t head[COHSM__LINE_STEPS + 1], next[COHSM__SHARED_LINES];
} cohsm__room;

static void cohsm__room_add(cohsm__room *r, uint32_t line, uint32_t left)
{
    if (!left) return;
    r->next[line] = r->some >> left & 1u ? r->head[left] : (uint16_t)COHSM__NO_TRAY;
    r->head[left] = (uint16_t)line;
    r->some |= (uint64_t)1 << left;
}

/* Takes out the line with the least room among those that have at least so many steps left, and writes to
   *left how many it has. Returns the line, or COHSM__NO_TRAY if there is none. */
static uint32_t cohsm__room_take(cohsm__room *r, uint32_t steps, uint32_t *left)
{
    const uint64_t fit = r->some >> steps << steps;
    uint32_t line;

    if (!fit) return COHSM__NO_TRAY;
    *left = cohsm__popcount((fit & (0u - fit)) - 1u);
    line = r->head[*left];
    r->head[*left] = r->next[line];
    if (r->head[*left] == COHSM__NO_TRAY) r->some &= ~((uint64_t)1 << *left);
    return line;
}

/* Returns how many steps a line of a split tray leaves free. */
static uint32_t cohsm__line_left(const uint8_t *line)
{
    const uint32_t n = line[0];
    uint32_t i, used = 1u + n;

    if (cohsm__tray_is_spread(line)) return 0;
    for (i = 0; i <= n; i++) used += line[1u + n + i] == COHSM__EXACT_CODE;
    return COHSM__LINE_STEPS - used;
}

/* Puts the first split trays before all other lines, as long as short trays can begin in their lines, and
   opens what is left in these lines for short trays. Returns the number of these lines. */
static uint32_t cohsm__room_start(cohsm__room *r, const cohsm__tray_work *w, uint32_t pixels)
{
    uint32_t p, part, lines = 0, next;

    r->some = 0;
    for (p = 0; p < pixels; p++) {
        if (w->steps[p]) continue;
        next = w->line[p] + (1u << w->split[p]);
        for (part = 0; part < 1u << w->split[p]; part++) {
            const uint8_t *line = w->large[w->line[p] + part];
            if (cohsm__tray_is_spread(line)) next++;
        }
        if (next > COHSM__GROUP) break;
        for (part = 0; part < 1u << w->split[p]; part++)
            cohsm__room_add(r, w->line[p] + part, cohsm__line_left(w->large[w->line[p] + part]));
        lines = next;
    }
    return lines;
}

/* Places the trays, the longest first, each in the line in which it leaves the least room. Returns how many
   lines the bucket has, and writes to *before how many lines of split trays stand before the others. */
static uint32_t cohsm__bucket_place(cohsm__tray_work *w, uint32_t pixels, uint32_t *before)
{
    uint16_t head[COHSM__LINE_STEPS + 1], next[COHSM__GROUP];
    cohsm__room room;
    uint32_t p, steps;
    uint32_t line, left, fresh;

    *before = fresh = cohsm__room_start(&room, w, pixels);
    memset(head, 0xff, sizeof head);    /* COHSM__NO_TRAY */
    for (p = 0; p < pixels; p++) {
        if (!w->steps[p] || w->same[p] != p) continue;
        next[p] = head[w->steps[p]];
        head[w->steps[p]] = (uint16_t)p;
    }
    for (steps = COHSM__LINE_STEPS; steps > 0; steps--)
        for (p = head[steps]; p != COHSM__NO_TRAY; p = next[p]) {
            line = cohsm__room_take(&room, steps, &left);
            if (line == COHSM__NO_TRAY) {
                line = fresh++;
                left = COHSM__LINE_STEPS;
            }
            w->place[p] = (uint16_t)(COHSM__LINE_STEPS * line + COHSM__LINE_STEPS - left);
            cohsm__room_add(&room, line, left - steps);
        }
    return fresh + w->large_lines - *before;
}

/* Copies the trays to their places, and writes where each begins. `to` is the bucket's first line; all its
   lines are zeroed. */
static void cohsm__bucket_write(const cohsm__tray_work *w, uint32_t pixels, uint32_t before, uint32_t lines,
                                uint8_t *to, uint16_t *at)
{
    const uint32_t behind = lines - w->large_lines;     /* lines between the first and the last split trays */
    uint32_t p, line;

    memcpy(to, w->large, (size_t)before * COHSM__LINE_BYTES);
    memcpy(to + (size_t)(before + behind) * COHSM__LINE_BYTES, w->large[before],
           (size_t)(w->large_lines - before) * COHSM__LINE_BYTES);
    for (p = 0; p < pixels; p++) {
        if (w->steps[p]) {
            if (w->same[p] == p) memcpy(to + 2u * w->place[p], w->tiny[p], 2u * (size_t)w->steps[p]);
            at[p] = w->place[w->same[p]];
            continue;
        }
        line = w->line[p] + (w->line[p] < before ? 0u : behind);
        at[p] = (uint16_t)(line | (uint32_t)w->split[p] << 14);
    }
}
