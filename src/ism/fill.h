/* ---- fill: pull and push (paper 3.3), after Marroquim et al. 2007 ---- */

/* Which of the four quadrants about a texel something at (dx, dy) lies in; each owns one half axis. */
static uint32_t ism__quadrant(int dx, int dy)
{
    return dx > 0 && dy >= 0 ? 1u : dx <= 0 && dy > 0 ? 2u : dx < 0 ? 4u : 8u;
}

/* Which of eight sectors about a texel, of 45 degrees each about the axes and diagonals. */
static uint32_t ism__sector(int dx, int dy)
{
    int ax = dx < 0 ? -dx : dx, ay = dy < 0 ? -dy : dy;
    if (12 * ay < 5 * ax) return dx > 0 ? 1u : 16u;                         /* tan 22.5 = 5 / 12 */
    if (12 * ax < 5 * ay) return dy > 0 ? 4u : 64u;
    return dx > 0 ? (dy > 0 ? 2u : 128u) : dy > 0 ? 8u : 32u;
}

static uint32_t ism__turn(uint32_t sectors, uint32_t by)
{
    return (sectors << by | sectors >> (8u - by)) & 255u;
}

/* Is a texel with something in these sectors about it surrounded? All that lies on one side of a line touches
   five of them at most. Those beyond the tile's border count where the border has something on both sides of
   the texel: in the sector along it or, of what is close, the next one. */
static int ism__surrounded(uint32_t found, uint32_t close, uint32_t beyond)
{
    uint32_t along = (ism__turn(beyond, 1) | ism__turn(beyond, 7)) & ~beyond, open;
    if (((found | ism__turn(close, 1) | ism__turn(close, 7)) & along) == along) found |= beyond;
    open = ~found & 255u;
    return (open & ism__turn(open, 1) & ism__turn(open, 2)) == 0;
}

/* A texel with nearer surfels in all four quadrants about it, whose planes pass before it, is a hole between
   them through which something hidden is seen: it is emptied, for pull and push to close. Marked by
   UINT32_MAX first, so that no hole depends on another. */
static void ism__open_holes(ism__tile *tile)
{
    int size = (int)tile->size, x, y;
    int dx, dy;
    size_t i, count = (size_t)tile->size * tile->size;
    for (y = 0; y < size; y++)
        for (x = 0; x < size; x++) {
            size_t c = (size_t)(y * size + x);
            float depth = tile->depth[c];
            uint32_t found = 0;
            if (!(depth < ISM_FAR)) continue;
            for (dy = -ISM__HOLE; dy <= ISM__HOLE; dy++)
                for (dx = -ISM__HOLE; dx <= ISM__HOLE; dx++) {
                    size_t n = (size_t)((y + dy) * size + x + dx);
                    float t;
                    if (x + dx < 0 || y + dy < 0 || x + dx >= size || y + dy >= size) {
                        found |= ism__quadrant(dx, dy);
                        continue;
                    }
                    if ((dx == 0 && dy == 0) || !(tile->depth[n] < 0.9f * depth)) continue;
                    t = ism__plane_depth(tile, tile->texels[n].g, c);
                    if (t > 0.5f * tile->depth[n] && t < 0.95f * depth) found |= ism__quadrant(dx, dy);
                }
            if (found == 15u) tile->texels[c].triangle = UINT32_MAX;
        }
    for (i = 0; i < count; i++)
        if (tile->texels[i].triangle == UINT32_MAX) tile->depth[i] = ISM_FAR;
}

/* Pull: each cell of a coarser level keeps 1 + the index of one texel of its four cells, the nearest to its
   middle. */
static void ism__pull(const ism__tile *tile, uint32_t *pyramid, uint32_t levels)
{
    uint32_t size = tile->size, level, x;
    uint32_t y, k;
    size_t offset = 0, below = 0;
    for (level = 1; level <= levels; level++) {
        uint32_t half = size >> level;
        for (y = 0; y < half; y++)
            for (x = 0; x < half; x++) {
                uint32_t best = 0, least = UINT32_MAX, mx = (2u * x + 1u) << level,
                         my = (2u * y + 1u) << level;
                for (k = 0; k < 4u; k++) {
                    uint32_t cx = 2u * x + (k & 1u), cy = 2u * y + (k >> 1), at;
                    uint32_t px, py, d;
                    if (level == 1)
                        at = tile->depth[(size_t)cy * size + cx] < ISM_FAR ? cy * size + cx + 1u : 0;
                    else at = pyramid[below + (size_t)cy * 2u * half + cx];
                    if (!at) continue;
                    px = 2u * ((at - 1u) % size) + 1u;
                    py = 2u * ((at - 1u) / size) + 1u;
                    d = (px - mx) * (px - mx) + (py - my) * (py - my);
                    if (d < least) {
                        least = d;
                        best = at;
                    }
                }
                pyramid[offset + (size_t)y * half + x] = best;
            }
        below = offset;
        offset += (size_t)half * half;
    }
}

/* The depth that an empty texel takes from the two surfels nearest to it: the first one's depth, or its
   plane's at this texel, whichever would have foretold the second one better. No depth is ever mixed with
   another. */
static float ism__push(const ism__tile *tile, size_t i, size_t first, size_t second)
{
    const float *g = tile->texels[first].g;
    float t = ism__plane_depth(tile, g, i), there = ism__plane_depth(tile, g, second);
    float own = tile->depth[first], next = tile->depth[second];
    if (fabsf(own - next) <= fabsf(there - next)) return own;
    return t > 0.5f * own && t < 2.0f * own ? t : own;
}

/* What is known of an empty texel's surroundings while coarser and coarser levels are read. */
typedef struct ism__search {
    ism__texel *first, *second;     /* the two nearest surfels' texels, or NULL */
    int         least, next;        /* their squared distances in texels */
    uint32_t    found, beyond;      /* sectors in which something lies, and those beyond the tile's border */
} ism__search;

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

/* Push: an empty texel looks at the 3 x 3 cells about it, level by level, and takes the nearest surfel once
   it is surrounded: outside of a silhouette the far side is empty, and stays so. Nothing leaves the tile. */
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
        to->filled = 1;     /* set aside: a finite depth would say that the texel is not empty */
        tile->filled++;
    }
}
