/* ---- interpolation: pictures by grids of samples (section 4) ---- */

typedef struct rsm__grid {
    const rsm_points       *points;
    const rsm_interpolation *desc;
    float    *out;
    uint8_t  *state;               /* of each pixel, see below */
    uint32_t *list;                /* the pixels that are evaluated next */
    uint32_t  width, height, step; /* pixels; step is that of this level's grid */
    int       lossy;               /* not 0: the light that bounds take off is summed */
    rsm__suit_kernel suit;
    float    *reach2;              /* of each sample the squared distance of its nearest light */
    float     limits[3];           /* the least cosine, the largest slope^2 and distance^2 of a sample that
                                      suits a pixel */
} rsm__grid;

/* The states of a pixel. States that are still pending have bit 0 set, and no other state has, so that eight
   pixels of a cell can be asked at a time. */
enum {
    RSM__NONE = 0,                 /* no receiver */
    RSM__BAD = 2,                  /* no receiver, since it is not finite */
    RSM__PENDING = 1,              /* a receiver without a result as yet */
    RSM__WANTED = 3,               /* the same, to be evaluated as a corner of a cell */
    RSM__INTERPOLATED = 4,
    RSM__REPLACED = 6,             /* interpolated, and to be evaluated as a corner of a cell */
    RSM__EVALUATED = 8
};

/* Writes the grid lines on both sides of a coordinate. Lines lie at the multiples of step, a power of two,
   and at the picture's last pixel. */
static inline void rsm__grid_lines(uint32_t at, uint32_t step, uint32_t size, uint32_t line[2])
{
    line[0] = at & ~(step - 1u);
    line[1] = line[0] + step < size ? line[0] + step : size - 1;
}

/* Returns where a coordinate lies between two lines, 0..1. */
static inline float rsm__grid_share(uint32_t at, const uint32_t line[2])
{
    return line[1] > line[0] ? (float)(at - line[0]) / (float)(line[1] - line[0]) : 0.0f;
}

enum { RSM__ALL_SUIT = 4 };        /* in place of the number of the missing sample, if all four suit */

typedef struct rsm__cell {
    uint32_t column[2], row[2];    /* of its corners */
    float    samples[4][6];        /* positions and normals of the corners */
    float    rgb[4][3];            /* light at the corners */
    float    limits[4][3];         /* those of rsm__grid, for each corner */
    int      there;                /* bits of the corners that were evaluated */
    int      agree[5];             /* agree[k]: the corners without corner k are alike; agree[4]: all are */
} rsm__cell;

/* Returns whether all corners but the missing one were evaluated and are alike in brightness. */
static inline int rsm__corners_agree(int there, const float mean[4], int missing, float contrast)
{
    float low = RSM_FAR, high = 0.0f, sum = 0.0f;
    int k;
    if ((there | (missing < 4 ? 1 << missing : 0)) != 15) return 0;
    for (k = 0; k < 4; k++) {
        if (k == missing) continue;
        low = mean[k] < low ? mean[k] : low;
        high = mean[k] > high ? mean[k] : high;
        sum += mean[k];
    }
    return !(contrast >= 0.0f && high - low > contrast * sum / (missing < 4 ? 3.0f : 4.0f));
}

/* Loads the samples at the corners of a cell. Returns 0 if no pixel can be interpolated from them. */
static inline int rsm__cell_load(const rsm__grid *g, rsm__cell *cell)
{
    const rsm_points *p = g->points;
    size_t at[4];
    float mean[4];
    int k, any = 0;
    cell->there = 0;
    for (k = 0; k < 4; k++) {
        at[k] = (size_t)cell->row[k >> 1] * g->width + cell->column[k & 1];
        mean[k] = 0.0f;
        if (g->state[at[k]] != RSM__EVALUATED) continue;
        mean[k] = rsm__mean3(g->out + 3 * at[k]);
        cell->there |= 1 << k;
    }
    for (k = 0; k <= RSM__ALL_SUIT; k++)
        any |= cell->agree[k] = rsm__corners_agree(cell->there, mean, k, g->desc->contrast);
    for (k = 0; k < 4 && any; k++) {
        rsm__v3_store(cell->samples[k], rsm__vector_at(p->positions, p->position_stride, at[k]));
        rsm__v3_store(cell->samples[k] + 3, rsm__vector_at(p->normals, p->normal_stride, at[k]));
        memcpy(cell->rgb[k], g->out + 3 * at[k], 12);
        memcpy(cell->limits[k], g->limits, sizeof g->limits);
        if (g->desc->light_share > 0.0f &&
            g->reach2[at[k]] * g->desc->light_share * g->desc->light_share < cell->limits[k][2])
            cell->limits[k][2] = g->reach2[at[k]] * g->desc->light_share * g->desc->light_share;
    }
    return any;
}

/* Writes the bilinear value at (u, v) of a cell. A missing sample counts as the sum of its neighbours less
   the one across, which makes the four a plane. The paper normalises the other weights in its place, which
   pulls the result towards these three, by 6 % at a crease (T39). */
static inline void rsm__cell_value(const rsm__cell *cell, int missing, float u, float v, float *out)
{
    float w[4];
    int c;
    w[0] = (1.0f - v) * (1.0f - u);
    w[1] = (1.0f - v) * u;
    w[2] = v * (1.0f - u);
    w[3] = v * u;
    if (missing < 4) {
        w[missing ^ 1] += w[missing];
        w[missing ^ 2] += w[missing];
        w[missing ^ 3] -= w[missing];
        w[missing] = 0.0f;
    }
    for (c = 0; c < 3; c++) {
        float x =
            w[0] * cell->rgb[0][c] + w[1] * cell->rgb[1][c] + w[2] * cell->rgb[2][c] + w[3] * cell->rgb[3][c];
        out[c] = x > 0.0f ? x : 0.0f;
    }
}

/* Interpolates those pixels of a tile for which three of the cell's samples suit, or all four: the rule of
   section 4. */
static inline void rsm__tile_interpolate(rsm__grid *g, const rsm__cell *cell, rsm__tile *t, size_t count)
{
    size_t i, end = (count + 7) & ~(size_t)7;
    int k;
    for (i = count; i < end; i++) t->px[i] = t->py[i] = t->pz[i] = t->nx[i] = t->ny[i] = t->nz[i] = 0.0f;
    memset(t->good, 0, end * sizeof *t->good);
    for (k = 0; k < 4; k++)
        if (cell->there >> k & 1) g->suit(t, end, cell->samples[k], cell->limits[k], 1 << k);
    for (i = 0; i < count; i++) {
        static const int8_t missing_of[16] = { -1, -1, -1, -1, -1, -1, -1, 3,
                                               -1, -1, -1, 2,  -1, 1,  0,  RSM__ALL_SUIT };
        size_t at = (size_t)t->y[i] * g->width + t->x[i];
        int missing = missing_of[t->good[i]];
        if (missing < 0 || !cell->agree[missing]) continue;
        rsm__cell_value(cell, missing, rsm__grid_share(t->x[i], cell->column),
                        rsm__grid_share(t->y[i], cell->row), g->out + 3 * at);
        g->state[at] = RSM__INTERPOLATED;
    }
}

/* Returns whether a cell has a pixel without a result. */
static inline int rsm__cell_pending(const rsm__grid *g, uint32_t left, uint32_t top, uint32_t right,
                                 uint32_t bottom)
{
    const uint64_t bits = 0x0101010101010101u;
    uint32_t x, y;
    for (y = top; y < bottom; y++) {
        const uint8_t *s = g->state + (size_t)y * g->width;
        for (x = left; x < right;) {
            uint64_t some = 0;
            if (right - x >= 8) memcpy(&some, s + x, 8);
            else if (right - x >= 4) memcpy(&some, s + x, 4);
            else some = s[x];
            if (some & bits) return 1;
            x += right - x >= 8 ? 8 : right - x >= 4 ? 4 : 1;
        }
    }
    return 0;
}

/* Adds the pending pixels of a row to the tile, which has room for all of the row, and returns the new count.
   Every pixel is written, and a pending one moves the end on: a branch would be mispredicted, since which
   pixels are pending follows no pattern. */
static inline size_t rsm__tile_add(const rsm__grid *g, rsm__tile *t, size_t count, uint32_t left,
                                   uint32_t right, uint32_t y)
{
    const rsm_points *p = g->points;
    size_t first = (size_t)y * g->width + left, ps = rsm__stride_or(p->position_stride, 12),
           ns = rsm__stride_or(p->normal_stride, 12);
    const float *position = rsm__element_at(p->positions, ps, first);
    const float *normal = rsm__element_at(p->normals, ns, first);
    const uint8_t *state = g->state + first;
    uint32_t x;
    for (x = left; x < right; x++) {
        t->px[count] = position[0];
        t->py[count] = position[1];
        t->pz[count] = position[2];
        t->nx[count] = normal[0];
        t->ny[count] = normal[1];
        t->nz[count] = normal[2];
        t->x[count] = x;
        t->y[count] = y;
        count += *state++ == RSM__PENDING;
        position = rsm__element_at(position, ps, 1);
        normal = rsm__element_at(normal, ns, 1);
    }
    return count;
}

/* Interpolates the pending pixels of a cell, a tile of them at a time. */
static inline void rsm__interpolate_cell(rsm__grid *g, rsm__tile *tile, uint32_t left, uint32_t top,
                                         uint32_t right, uint32_t bottom)
{
    rsm__cell cell;
    uint32_t y;
    size_t count = 0;
    rsm__grid_lines(left, g->step, g->width, cell.column);
    rsm__grid_lines(top, g->step, g->height, cell.row);
    if (!rsm__cell_load(g, &cell)) return;
    for (y = top; y < bottom; y++) {
        if (count + (right - left) > RSM__TILE) {
            rsm__tile_interpolate(g, &cell, tile, count);
            count = 0;
        }
        count = rsm__tile_add(g, tile, count, left, right, y);
    }
    rsm__tile_interpolate(g, &cell, tile, count);
}

/* Interpolates a row of cells. Corners are looked at only if a cell has pending pixels, since another thread
   may be writing the state of others. */
static inline void rsm__interpolate_cells(void *context, size_t number)
{
    rsm__grid *g = (rsm__grid *)context;
    uint32_t x, top = (uint32_t)number * g->step,
                bottom = g->height - top < g->step ? g->height : top + g->step;
    rsm__tile tile;
    for (x = 0; x < g->width; x += g->step) {
        uint32_t right = g->width - x < g->step ? g->width : x + g->step;
        if (rsm__cell_pending(g, x, top, right, bottom))
            rsm__interpolate_cell(g, &tile, x, top, right, bottom);
        if (right == g->width) break;
    }
}

/* Marks the corners of the cell at (x, y) as wanted, unless they were evaluated before. A pixel that an
   earlier level interpolated is wanted too: an evaluated value replaces the interpolated one. */
static inline void rsm__want_corners(rsm__grid *g, uint32_t x, uint32_t y)
{
    uint32_t column[2], row[2], k;
    rsm__grid_lines(x, g->step, g->width, column);
    rsm__grid_lines(y, g->step, g->height, row);
    for (k = 0; k < 4; k++) {
        uint8_t *s = g->state + (size_t)row[k >> 1] * g->width + column[k & 1];
        if (*s == RSM__PENDING) *s = RSM__WANTED;
        else if (*s == RSM__INTERPOLATED) *s = RSM__REPLACED;
    }
}

/* Returns the grid line after `at`, or size if there is none. */
static inline uint32_t rsm__next_line(const rsm__grid *g, uint32_t at, uint32_t size)
{
    return at + g->step < size ? at + g->step : at + 1 < size ? size - 1 : size;
}

/* Lists the pixels that this level evaluates, marks them as evaluated, and returns how many they are: the
   corners of cells with pending pixels, or on the last level, whose step is 1, all pending pixels. */
static inline size_t rsm__list_wanted(rsm__grid *g)
{
    uint32_t x, y;
    size_t found = 0;
    for (y = 0; y < g->height && g->step > 1; y += g->step)
        for (x = 0; x < g->width; x += g->step) {
            uint32_t right = g->width - x < g->step ? g->width : x + g->step,
                     bottom = g->height - y < g->step ? g->height : y + g->step;
            if (rsm__cell_pending(g, x, y, right, bottom)) rsm__want_corners(g, x, y);
        }
    for (y = 0; y < g->height; y = rsm__next_line(g, y, g->height))
        for (x = 0; x < g->width; x = rsm__next_line(g, x, g->width)) {
            size_t at = (size_t)y * g->width + x;
            uint8_t state = g->state[at];
            if (g->step > 1 ? state != RSM__WANTED && state != RSM__REPLACED : state != RSM__PENDING)
                continue;
            g->state[at] = RSM__EVALUATED;
            g->list[found++] = (uint32_t)at;
        }
    return found;
}

/* Checks settings, which may be NULL, and writes them with their defaults to out. */
static inline rsm_result rsm__interpolation_check(const rsm__logger *log, const rsm_interpolation *d,
                                                  rsm_interpolation *out)
{
    const rsm_result bad = RSM_ERR_DESC;
    memset(out, 0, sizeof *out);
    if (d) *out = *d;
    if (out->step == 0) out->step = 8;
    if (out->step < 2 || out->step > 64 || (out->step & (out->step - 1))) {
        rsm__log_value(log, "interpolation.step", out->step, "0 or a power of two, 2..64");
        return bad;
    }
    if (!rsm__check_range(log, "interpolation.level_count", out->level_count, 0, 6, "0..6")) return bad;
    if (!rsm__check_range(log, "interpolation.normal_cosine", (double)out->normal_cosine, -1, 1, "-1..1"))
        return bad;
    if (!rsm__check_range(log, "interpolation.plane_slope", (double)out->plane_slope, 0, 1e6, "0..1e6"))
        return bad;
    if (!rsm__check_range(log, "interpolation.distance", (double)out->distance, 0, 1e9, "0..1e9")) return bad;
    if (!rsm__check_range(log, "interpolation.contrast", (double)out->contrast, -1e6, 1e6, "-1e6..1e6"))
        return bad;
    if (!rsm__check_range(log, "interpolation.light_share", (double)out->light_share, -1e6, 1e6, "-1e6..1e6"))
        return bad;
    if (out->level_count == 0) out->level_count = 6;
    if (!(fabsf(out->normal_cosine) > 0.0f)) out->normal_cosine = 0.95f;
    if (!(out->plane_slope > 0.0f)) out->plane_slope = 0.05f;
    if (!(fabsf(out->contrast) > 0.0f)) out->contrast = 0.25f;
    if (!(fabsf(out->light_share) > 0.0f)) out->light_share = 0.25f;
    return RSM_OK;
}

/* Runs one level: evaluates the grid of g->step (1: every pixel that is left), then interpolates the pixels
   for which samples suit. begin and end are the fractions of the whole call at which this level begins and
   ends. */
static inline rsm_result rsm__grid_level(rsm__grid *g, rsm__gather *gather, rsm_gather_stats *total,
                                         float begin, float end)
{
    rsm_points points = *g->points;
    rsm_gather_stats stats;
    rsm_result result;
    points.indices = g->list;
    points.index_count = rsm__list_wanted(g);
    points.open = NULL; /* rsm__grid_finish applies it, at full resolution */
    if (points.index_count == 0) return RSM_OK;
    gather->points = &points;
    gather->reach2 = g->step > 1 && g->desc->light_share > 0.0f ? g->reach2 : NULL;
    gather->kernel = rsm__choose_kernel(g->lossy, gather->reach2 != NULL);
    result = rsm__gather_points(gather, &stats, begin, end);
    gather->points = g->points;
    if (result != RSM_OK) return result;
    total->evaluated += stats.evaluated;
    total->pairs += stats.pairs;
    total->clamped_share += stats.clamped_share * (double)stats.evaluated;
    total->outside_share += stats.outside_share * (double)stats.evaluated;
    if (g->step > 1)
        rsm__run_tasks(&gather->desc.system, (g->height + g->step - 1) / g->step, rsm__interpolate_cells, g);
    return RSM_OK;
}

/* Writes the mask, multiplies all pixels by what is open there, and returns the number of bad points. */
static inline uint64_t rsm__grid_finish(rsm__grid *g, uint8_t *mask)
{
    const rsm_points *p = g->points;
    uint64_t bad = 0;
    size_t at, pixels = (size_t)g->width * g->height;
    int c;
    for (at = 0; at < pixels; at++) bad += g->state[at] == RSM__BAD;
    for (at = 0; at < pixels && mask; at++) mask[at] = g->state[at] / RSM__INTERPOLATED;
    for (at = 0; at < pixels && p->open; at++) {
        float f;
        if (g->state[at] < RSM__INTERPOLATED) continue;
        f = *rsm__element_at(p->open, rsm__stride_or(p->open_stride, 4), at);
        f = f > 0.0f ? f < 1.0f ? f : 1.0f : 0.0f;
        for (c = 0; c < 3; c++) g->out[3 * at + (size_t)c] *= f;
    }
    return bad;
}

/* Sets the states of a row before the first level. */
static inline void rsm__grid_start_row(void *context, size_t y)
{
    rsm__grid *g = (rsm__grid *)context;
    size_t at;
    for (at = y * g->width; at < (y + 1) * g->width; at++) {
        rsm__v3 x, n;
        uint64_t bad = 0;
        int lit = rsm__load_receiver(g->points, at, &x, &n, &bad);
        g->state[at] = lit ? RSM__PENDING : bad ? RSM__BAD : RSM__NONE;
        if (!lit) memset(g->out + 3 * at, 0, 3 * sizeof *g->out);
    }
}

/* Runs all levels, from the coarsest grid to single pixels. */
static inline rsm_result rsm__interpolate_all(rsm__grid *g, rsm__gather *gather, uint32_t levels,
                                              rsm_gather_stats *total)
{
    uint32_t level, steps = 0;
    rsm_result result = RSM_OK;
    while (steps < levels && g->step >> steps > 1u) steps++;
    rsm__run_tasks(&gather->desc.system, g->height, rsm__grid_start_row, g);
    for (level = 0; level <= steps && result == RSM_OK; level++, g->step /= 2) {
        float begin = (float)level / (float)(steps + 1u), end = (float)(level + 1u) / (float)(steps + 1u);
        if (level == steps) g->step = 1;
        result = rsm__grid_level(g, gather, total, begin, end);
    }
    return result;
}

/* Checks a call's picture, gather and interpolation, and fills in defaults. */
static inline rsm_result rsm__picture_check(const rsm__logger *log, const rsm_points *points,
                                            const float *out, const rsm_gather_desc *desc,
                                            const rsm_interpolation *interpolation, rsm_gather_desc *gather,
                                            rsm_interpolation *how)
{
    rsm_result result = rsm__points_check(log, points, out);
    if (result != RSM_OK) return result;
    if (points->indices)
        return rsm__refuse(log, RSM_ERR_ARGUMENT, "points.indices", "is not NULL, as it must be here");
    if (points->width == 0 || points->count % points->width != 0 || points->count > 0xffffffffu) {
        rsm__log_value(log, "points.width", points->width,
                       "the pixels in a row, of which points.count is a multiple");
        return RSM_ERR_ARGUMENT;
    }
    result = rsm__gather_check(log, desc, points, gather);
    if (result == RSM_OK) result = rsm__seeing_check(log, gather);
    if (result == RSM_OK) result = rsm__interpolation_check(log, interpolation, how);
    if (result != RSM_OK) return result;
    if (gather->noise) return rsm__refuse(log, RSM_ERR_DESC, "desc.noise", "is not NULL, as it must be here");
    if (!rsm__check_range(log, "desc.interleave", gather->interleave, 1, 1, "0 or 1 here"))
        return RSM_ERR_DESC;
    if (!rsm__check_range(log, "desc.add", gather->add, 0, 0, "0 here")) return RSM_ERR_DESC;
    return RSM_OK;
}

/* Allocates what the levels need, runs them, and fills in the statistics. */
static inline rsm_result rsm__interpolate_run(rsm__grid *g, rsm__gather *gather, const rsm_map *const *maps,
                                              size_t map_count, rsm_gather_stats *stats)
{
    rsm__allocator a = rsm__allocator_of(&gather->desc.system);
    const size_t count = gather->points->count;
    rsm_gather_stats total;
    rsm_result result;
    memset(&total, 0, sizeof total);
    g->list = (uint32_t *)rsm__alloc_array(&a, count + 1, sizeof *g->list);
    g->state = (uint8_t *)rsm__alloc_array(&a, count + 1, 1);
    g->reach2 = (float *)rsm__alloc_array(&a, count + 1, sizeof *g->reach2);
    result = g->list && g->state && g->reach2 ? rsm__gather_open(gather, maps, map_count, NULL, 0, &a)
                                              : RSM_ERR_ALLOC;
    if (result == RSM_OK) result = rsm__make_tallies(gather, &a); /* all memory is there before levels write
                                                                     */
    if (result == RSM_OK) result = rsm__interpolate_all(g, gather, g->desc->level_count, &total);
    rsm__gather_close(gather, &a);
    if (result == RSM_OK) {
        total.bad_points = rsm__grid_finish(g, g->desc->mask);
        if (total.evaluated) {
            total.clamped_share /= (double)total.evaluated;
            total.outside_share /= (double)total.evaluated;
        }
        if (stats) *stats = total;
    }
    rsm__free(&a, g->reach2);
    rsm__free(&a, g->state);
    rsm__free(&a, g->list);
    return result;
}

RSM_DEF rsm_result rsm_interpolate(const rsm_map *const *maps, size_t map_count, const rsm_gather_desc *desc,
                                   const rsm_interpolation *interpolation, const rsm_points *points,
                                   float *irradiance, rsm_gather_stats *stats)
{
    const rsm_map *first = maps && map_count ? maps[0] : NULL;
    rsm__logger log = rsm__logger_of_map(desc ? &desc->system : NULL, first, "rsm_interpolate");
    rsm__gather gather;
    rsm__grid g;
    rsm_interpolation how;
    rsm_result result = rsm__maps_check(&log, maps, map_count);
    memset(&gather, 0, sizeof gather);
    memset(&g, 0, sizeof g);
    if (result == RSM_OK)
        result = rsm__picture_check(&log, points, irradiance, desc, interpolation, &gather.desc, &how);
    if (result != RSM_OK) return result;
    g.points = gather.points = points;
    g.desc = &how;
    g.out = gather.out = irradiance;
    g.width = points->width;
    g.height = (uint32_t)(points->count / points->width);
    g.step = how.step;
    g.suit = rsm__choose_suit();
    g.limits[0] = how.normal_cosine;
    g.limits[1] = how.plane_slope * how.plane_slope;
    g.limits[2] = how.distance > 0.0f ? how.distance * how.distance : RSM_FAR;
    g.lossy = rsm__loss_wanted(&gather, stats);
    return rsm__gather_logged(&log, rsm__interpolate_run(&g, &gather, maps, map_count, stats));
}
