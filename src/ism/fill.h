/* ---- fill: pull and push (paper 3.3), after Marroquim et al. 2007 ---- */

/* Returns the bit of the quadrant about a texel in which (dx, dy) lies; each quadrant owns one half axis. */
static uint32_t ism__quadrant(int dx, int dy)
{
    return dx > 0 && dy >= 0 ? 1u : dx <= 0 && dy > 0 ? 2u : dx < 0 ? 4u : 8u;
}

/* Returns the bit of the sector about a texel in which (dx, dy) lies. The eight sectors have 45 degrees each,
   with the axes and diagonals in their middles. */
static uint32_t ism__sector(int dx, int dy)
{
    int ax = dx < 0 ? -dx : dx, ay = dy < 0 ? -dy : dy;
    if (12 * ay < 5 * ax) return dx > 0 ? 1u : 16u;                         /* about tan 22.5 */
    if (12 * ax < 5 * ay) return dy > 0 ? 4u : 64u;
    return dx > 0 ? (dy > 0 ? 2u : 128u) : dy > 0 ? 8u : 32u;
}

/* Returns a set of sectors turned by so many sectors. */
static uint32_t ism__rotate_sectors(uint32_t sectors, uint32_t by)
{
    return (sectors << by | sectors >> (8u - by)) & 255u;
}

/* Returns whether a texel is surrounded, given the sectors about it in which surfels were found. What lies on
   one side of a line touches five sectors at most, so a texel is surrounded if no three sectors in a row are
   empty. Sectors beyond the tile's border count as full if there are surfels along the border on both sides
   of the texel: in the sector next to those beyond or, of surfels that are close, one farther. */
static int ism__surrounded(uint32_t found, uint32_t close, uint32_t beyond)
{
    uint32_t along = (ism__rotate_sectors(beyond, 1) | ism__rotate_sectors(beyond, 7)) & ~beyond, open;
    close = ism__rotate_sectors(close, 1) | ism__rotate_sectors(close, 7);
    if (((found | close) & along) == along) found |= beyond;
    open = ~found & 255u;
    return (open & ism__rotate_sectors(open, 1) & ism__rotate_sectors(open, 2)) == 0;
}

/* Returns whether the plane of the nearer surfel at texel n passes before texel c, which is this deep. */
static int ism__passes_before(const ism__tile *tile, size_t n, size_t c, float depth)
{
    float t;
    if (!(tile->depth[n] < 0.9f * depth)) return 0;
    t = ism__plane_depth(tile, tile->texels[n].g, c);
    return t > 0.5f * tile->depth[n] && t < 0.95f * depth;
}

/* Returns in which quadrants about a texel there are nearer surfels whose planes pass before the texel. There
   may be such surfels beyond the tile's border, so what lies there counts. */
static uint32_t ism__quadrants_before(const ism__tile *tile, int x, int y)
{
    int size = (int)tile->size, dx, dy;
    size_t c = (size_t)(y * size + x);
    uint32_t found = 0;
    for (dy = -ISM__HOLE; dy <= ISM__HOLE; dy++)
        for (dx = -ISM__HOLE; dx <= ISM__HOLE; dx++) {
            int outside = x + dx < 0 || y + dy < 0 || x + dx >= size || y + dy >= size;
            if (dx == 0 && dy == 0) continue;
            if (outside || ism__passes_before(tile, (size_t)((y + dy) * size + x + dx), c, tile->depth[c]))
                found |= ism__quadrant(dx, dy);
        }
    return found;
}

/* A texel with nearer surfels in all four quadrants about it, whose planes pass before it, is a hole between
   them through which something hidden is seen: it is emptied, for pull and push to close. Holes are marked by
   UINT32_MAX first, so that none depends on another. */
static void ism__open_holes(ism__tile *tile)
{
    size_t i, size = tile->size, count = size * size;
    for (i = 0; i < count; i++)
        if (tile->depth[i] < ISM_FAR && ism__quadrants_before(tile, (int)(i % size), (int)(i / size)) == 15u)
            tile->texels[i].triangle = UINT32_MAX;
    for (i = 0; i < count; i++)
        if (tile->texels[i].triangle == UINT32_MAX) tile->depth[i] = ISM_FAR;
}

/* Returns 1 + the index of the texel that cell (x, y) of a level holds, or 0 if the cell is empty. Level 0 is
   the tile itself, `below` the cells of another level. */
static uint32_t ism__pulled(const ism__tile *tile, const uint32_t *below, uint32_t level, uint32_t x,
                            uint32_t y)
{
    size_t i = (size_t)y * (tile->size >> level) + x;
    if (level > 0) return below[i];
    return tile->depth[i] < ISM_FAR ? (uint32_t)i + 1u : 0;
}

/* Returns which texel of its four cells a cell of a coarser level keeps: the nearest to its middle. */
static uint32_t ism__pull_cell(const ism__tile *tile, const uint32_t *below, uint32_t level, uint32_t x,
                               uint32_t y)
{
    uint32_t best = 0, least = UINT32_MAX, k;
    uint32_t mx = (2u * x + 1u) << level, my = (2u * y + 1u) << level;
    for (k = 0; k < 4u; k++) {
        uint32_t at = ism__pulled(tile, below, level - 1u, 2u * x + (k & 1u), 2u * y + (k >> 1)), px, py, d;
        if (!at) continue;
        px = 2u * ((at - 1u) % tile->size) + 1u;
        py = 2u * ((at - 1u) / tile->size) + 1u;
        d = (px - mx) * (px - mx) + (py - my) * (py - my);
        if (d >= least) continue;
        least = d;
        best = at;
    }
    return best;
}

/* Pulls: makes the coarser levels, one after the other. */
static void ism__pull(const ism__tile *tile, uint32_t *pyramid, uint32_t levels)
{
    uint32_t level, i, *own = pyramid;
    const uint32_t *below = pyramid;
    for (level = 1; level <= levels; level++) {
        uint32_t side = tile->size >> level;
        for (i = 0; i < side * side; i++) own[i] = ism__pull_cell(tile, below, level, i % side, i / side);
        below = own;
        own += side * side;
    }
}

/* Returns the depth that an empty texel takes from the two surfels nearest to it: the first one's depth, or
   that of the first one's plane at this texel, whichever would have foretold the second one better. No depth
   is ever mixed with another. */
static float ism__push(const ism__tile *tile, size_t i, size_t first, size_t second)
{
    const float *g = tile->texels[first].g;
    float t = ism__plane_depth(tile, g, i), there = ism__plane_depth(tile, g, second);
    float own = tile->depth[first], next = tile->depth[second];
    if (fabsf(own - next) <= fabsf(there - next)) return own;
    return t > 0.5f * own && t < 2.0f * own ? t : own;
}

/* The surroundings of an empty texel, as far as they were read: from finer to coarser levels. */
typedef struct ism__search {
    ism__texel *first, *second;     /* the two nearest surfels' texels, or NULL */
    int         least, next;        /* their squared distances in texels */
    uint32_t    found, beyond;      /* sectors in which there are surfels; those beyond the tile's border */
} ism__search;

/* Takes a surfel's texel into account, at this squared distance. */
static void ism__keep_nearest(ism__search *s, ism__texel *texel, int d)
{
    if (!s->first || d < s->least) {
        if (s->first && s->first != texel) {
            s->second = s->first;
            s->next = s->least;
        }
        s->first = texel;
        s->least = d;
    } else if (s->first != texel && (!s->second || d < s->next)) {
        s->second = texel;
        s->next = d;
    }
}

/* Reads the 3 x 3 cells of one level of the pyramid about texel tx, ty. */
static void ism__search_level(const ism__tile *tile, const uint32_t *cells, uint32_t level, int tx, int ty,
                              ism__search *s)
{
    int half = (int)(tile->size >> level), cx = tx >> level, cy = ty >> level;
    int x, y;
    for (y = cy - 1; y <= cy + 1; y++)
        for (x = cx - 1; x <= cx + 1; x++) {
            uint32_t at;
            int dx, dy;
            if (x < 0 || y < 0 || x >= half || y >= half) {
                s->beyond |= ism__sector(x - cx, y - cy);
                continue;
            }
            at = cells[y * half + x];
            if (!at) continue;
            dx = (int)((at - 1u) % tile->size) - tx;
            dy = (int)((at - 1u) / tile->size) - ty;
            s->found |= ism__sector(dx, dy);
            ism__keep_nearest(s, &tile->texels[at - 1u], dx * dx + dy * dy);
        }
}

/* Closes holes, and pushes: an empty texel looks at the 3 x 3 cells about it, level by level, and takes a
   depth from the nearest surfels once it is surrounded. A texel outside a silhouette never is, and stays
   empty. Nothing is read beyond the tile. */
static void ism__fill(ism__tile *tile, uint32_t *pyramid)
{
    uint32_t size = tile->size, level, levels = 3u;
    size_t i, texels = (size_t)size * size;
    ism__open_holes(tile);
    while (size >> levels < 2u) levels--;
    ism__pull(tile, pyramid, levels);
    for (i = 0; i < texels; i++) {
        ism__texel *to = &tile->texels[i];
        ism__search s = { NULL, NULL, 0, 0, 0, 0 };
        uint32_t close = 0;
        size_t offset = 0;
        if (tile->depth[i] < ISM_FAR) continue;
        to->filled = 0;
        for (level = 1; level <= levels; level++) {
            if (s.second && ism__surrounded(s.found, close, s.beyond)) break;
            ism__search_level(tile, pyramid + offset, level, (int)(i % size), (int)(i / size), &s);
            offset += (size_t)(size >> level) * (size >> level);
            if (level == 1) close = s.found;
        }
        if (!s.second || !ism__surrounded(s.found, close, s.beyond)) continue;
        to->g[0] = ism__push(tile, i, (size_t)(s.first - tile->texels), (size_t)(s.second - tile->texels));
        to->triangle = s.first->triangle;
        to->filled = 1;     /* the tile's own depth stays ISM_FAR: no texel is filled from this one */
        tile->filled++;
    }
}
