/* ---- trays: the fast layout ---- */

/* Maps in the fast layout keep, beside the block, a tray for each pixel and bucket of 256 views: the depths
   of the pixel over these views, within one line of 64 bytes, so that a question reads a pointer and one line
   and decodes nothing. Three tables, in the order of their size, which follow a copy of the block's first
   sections in one run of bytes, so that a GPU gets all of it at once:

     lines   64 bytes each, 64-byte aligned: trays
     at      16 bits for each bucket and pixel, the pixel running fastest. Bits 14 and 15: split, the tray
             stands in 2^split lines of its own, one for each 256 >> split views. Bits 0..13: where it begins,
             counted from the line `base` in steps of 2 bytes (split 0) or of lines
     base    32 bits for each bucket and group of 256 pixels: the number of a line

   A tray, or the line of a part of a split tray, is

     1 byte         n, at most 31
     n bytes        the first views of all its segments but the first, rising, counted from the bucket's first
                    view
     n + 1 bytes    codes of the segments: the depth on the block's grid, 2^depth_bits - 1 for infinite, or
                    COHSM__EXACT_CODE
     2 bytes each   the exact depths, low byte first, in the order of their codes

   so that its length is even, and n and the number of exact depths are together at most 31. Segment j holds a
   view if j of the n first views are not above it.

   Depths that do not fit into a line even if a tray is split in eight have n = 31 and codes that are all
   exact, for which no line has room: the byte after n says how many lines further on the 16-bit depths of
   these 32 views stand, low bytes first. So every list can be kept. */

enum {
    COHSM__LINE_BYTES = 64,
    COHSM__BUCKET_BITS = 8,             /* of views */
    COHSM__BUCKET = 1 << COHSM__BUCKET_BITS,
    COHSM__GROUP_BITS = 8,              /* of pixels */
    COHSM__GROUP = 1 << COHSM__GROUP_BITS,
    COHSM__SPLITS = 3,                  /* a bucket's lines at most: 2^3 */
    COHSM__SPREAD_VIEWS = COHSM__BUCKET >> COHSM__SPLITS,
    COHSM__TRAY_FIRSTS = 31,            /* first views and exact depths that a line has room for */
    COHSM__EXACT_CODE = 254
};

/* Returns the tray that holds a view or, of a split tray, the line of its part. */
static inline const uint8_t *cohsm__tray_at(const cohsm_maps *m, uint32_t pixel, uint32_t place)
{
    const cohsm__trays *c = &m->trays;
    const size_t bucket = place >> COHSM__BUCKET_BITS;
    const uint32_t at = c->at[bucket * m->range + pixel], split = at >> 14;
    const uint32_t part = (place & (COHSM__BUCKET - 1u)) >> (COHSM__BUCKET_BITS - split);
    const size_t line = c->base[bucket * c->groups + (pixel >> COHSM__GROUP_BITS)];
    return c->lines + COHSM__LINE_BYTES * (line + part) + ((at & 0x3fffu) << (split ? 6 : 1));
}

static inline uint32_t cohsm__tray_half(const uint8_t *p) { return p[0] | (uint32_t)p[1] << 8; }

/* Says whether a line only tells where the depths of its views stand one by one. */
static inline int cohsm__tray_is_spread(const uint8_t *line)
{
    return line[0] == COHSM__TRAY_FIRSTS && line[COHSM__LINE_BYTES - 1] == COHSM__EXACT_CODE;
}

/* Returns the depth of a view whose code, number j of the codes, is COHSM__EXACT_CODE. */
static uint32_t cohsm__tray_exact(const uint8_t *tray, uint32_t j, uint32_t view)
{
    uint32_t n = tray[0], exact = 0, i;
    if (n == COHSM__TRAY_FIRSTS) {
        tray += COHSM__LINE_BYTES * (size_t)tray[1];
        return cohsm__tray_half(tray + 2u * (view % COHSM__SPREAD_VIEWS));
    }
    for (i = 0; i < j; i++) exact += tray[1u + n + i] == COHSM__EXACT_CODE;
    return cohsm__tray_half(tray + 2u + 2u * n + 2u * exact);
}

/* Returns the 16-bit depth of a view in its tray. */
static inline uint32_t cohsm__tray_depth(const cohsm_maps *m, const uint8_t *tray, uint32_t place)
{
    uint32_t n = tray[0], view = place & (COHSM__BUCKET - 1u);
    uint32_t j = 0, i, code;

    for (i = 1; i <= n; i++) j += tray[i] <= view;
    code = tray[1u + n + j];
    return code == COHSM__EXACT_CODE ? cohsm__tray_exact(tray, j, view) : m->depth_of[code];
}
