/* ---- atlas: the tiles of all VPLs ---- */

typedef struct ism__atlas_work {
    ism_maps       *m;
    const ism_mesh *mesh;
    uint32_t        lanes;
    ism__splat      kernels;
} ism__atlas_work;

/* Returns the memory in which a lane draws tiles: texels, depths, directions, the pyramid of pull and push,
   and counts. */
static size_t ism__lane_bytes(uint32_t size)
{
    size_t texels = (size_t)size * size;
    return texels * sizeof(ism__texel) + texels * 4u * sizeof(float) + texels * sizeof(uint16_t) + 64u;
}

/* Writes the directions of a tile's texel centres: all x, then all y, then all z. */
static void ism__tile_directions(const ism__tile *tile, float *out)
{
    size_t texels = (size_t)tile->size * tile->size, k;
    uint32_t x, y;
    for (y = 0; y < tile->size; y++)
        for (x = 0; x < tile->size; x++, out++) {
            float uv[2], w[3];
            uv[0] = ((float)x + 0.5f) / (float)tile->size;
            uv[1] = ((float)y + 0.5f) / (float)tile->size;
            if (tile->window) {
                uv[0] = ism__from_tile(&tile->window->u, uv[0]);
                uv[1] = ism__from_tile(&tile->window->v, uv[1]);
            }
            if (tile->vpl->directional) {
                w[0] = 2.0f * uv[0] - 1.0f;
                w[1] = 2.0f * uv[1] - 1.0f;
                w[2] = 1.0f;
            } else {
                ism_map_direction(tile->projection, tile->vpl->exponent, uv, w);
            }
            for (k = 0; k < 3u; k++) out[k * texels] = w[k];
        }
}

/* Begins a tile, in the lane's memory. Directions are those that all tiles share, unless this tile's texels
   look elsewhere: then they are computed. */
static void ism__begin_tile(ism__tile *tile, const ism__atlas_work *w, uint32_t v, char *scratch)
{
    ism_maps *m = w->m;
    size_t texels = (size_t)m->desc.tile_side * m->desc.tile_side, i;
    const float *directions = (const float *)m->directions.data;
    float *own;
    memset(tile, 0, sizeof *tile);
    tile->m = m;
    tile->mesh = w->mesh;
    tile->vpl = &m->vpls[v];
    tile->axes = ism__vpl_axes(m, tile->vpl);
    tile->projection = ism__projection_of(m, tile->vpl);
    tile->size = m->desc.tile_side;
    tile->window = (const ism__window *)m->windows.data + v;
    tile->texels = (ism__texel *)(void *)scratch;
    tile->depth = (float *)(void *)(scratch + texels * sizeof(ism__texel));
    own = tile->depth + texels;
    if (tile->window->u.on || tile->window->v.on || tile->vpl->directional ||
        tile->projection == ISM_PROJECTION_LOBE) {
        ism__tile_directions(tile, own);
        directions = own;
    }
    tile->x = directions;
    tile->y = directions + texels;
    tile->z = directions + 2u * texels;
    for (i = 0; i < texels; i++) {
        tile->depth[i] = ISM_FAR;
        tile->texels[i].triangle = 0;
    }
    tile->texels_per_unit = ism__texels_per_unit(tile);
}

/* Copies a tile into the atlas. */
static void ism__end_tile(const ism__tile *tile, ism_maps *m, uint32_t v)
{
    size_t column = v % m->tiles, row = v / m->tiles, x, y;
    for (y = 0; y < tile->size; y++)
        for (x = 0; x < tile->size; x++) {
            const ism__texel *from = &tile->texels[y * tile->size + x];
            float depth = tile->depth[y * tile->size + x];
            size_t to = (row * tile->size + y) * m->side + column * tile->size + x;
            int full = depth < ISM_FAR, filled = !full && !m->desc.no_fill && from->filled;
            ((float *)m->atlas.data)[to] = full ? depth : filled ? from->g[0] : ISM_FAR;
            if (m->hits.data) ((uint32_t *)m->hits.data)[to] = full || filled ? from->triangle : UINT32_MAX;
        }
}

/* Empties the tiles that no VPL has, as far as VPLs of the frame before, or the allocator, left something
   there. */
static void ism__blank_tiles(ism_maps *m)
{
    size_t v, size = m->desc.tile_side, x, y;
    for (v = m->vpl_count; v < m->blank_from; v++)
        for (y = 0; y < size; y++)
            for (x = 0; x < size; x++) {
                size_t to = (v / m->tiles * size + y) * m->side + v % m->tiles * size + x;
                ((float *)m->atlas.data)[to] = ISM_FAR;
                if (m->hits.data) ((uint32_t *)m->hits.data)[to] = UINT32_MAX;
            }
    m->blank_from = m->vpl_count;
}

#ifndef ISM_WITHOUT_FILL
/* Returns where pull and push have their levels: after depths and directions. */
static uint32_t *ism__pyramid_of(const ism__tile *tile)
{
    return (uint32_t *)(void *)(tile->depth + (size_t)tile->size * tile->size * 4u);
}
#endif

/* Draws the tiles of every so many-th VPL, one after the other. */
static void ism__lane_task(void *context, size_t lane)
{
    const ism__atlas_work *w = (const ism__atlas_work *)context;
    ism_maps *m = w->m;
    char *scratch = (char *)m->scratch.data + lane * ism__lane_bytes(m->desc.tile_side);
    uint64_t *stats = (uint64_t *)(void *)(scratch + ism__lane_bytes(m->desc.tile_side) - 64u);
    size_t v;
    stats[0] = stats[1] = stats[2] = 0;
    for (v = lane; v < m->vpl_count; v += w->lanes) {
        ism__tile tile;
        ism__begin_tile(&tile, w, (uint32_t)v, scratch);
        if (m->triangles)
            ism__draw_points(&tile, &w->kernels,
                             (const ism__surfel *)m->surfels.data + v * m->desc.surfel_count,
                             ((const uint32_t *)m->counts.data)[2u * v], (uint32_t)v);
#ifndef ISM_WITHOUT_FILL
        if (!m->desc.no_fill) ism__fill(&tile, ism__pyramid_of(&tile));
#endif
        ism__end_tile(&tile, m, (uint32_t)v);
        stats[0] += tile.splats;
        stats[1] += tile.wide;
        stats[2] += tile.filled;
    }
}

static ism_result ism__build(ism_maps *m, const ism__job *job)
{
    ism__atlas_work w;
    ism__job first = *job;
    size_t texels, i;
    ism_result result;
    w.m = m;
    w.mesh = job->frame->mesh;
    w.kernels = ism__choose_splat();
    w.lanes = m->vpl_count < ISM__LANES ? m->vpl_count : ISM__LANES;
    texels = (size_t)m->side * m->side;
    if (!ism__grow(m, &m->atlas, texels, sizeof(float)) ||
        (m->desc.keep_hits && !ism__grow(m, &m->hits, texels, sizeof(uint32_t))) ||
        !ism__grow(m, &m->scratch, ISM__LANES, ism__lane_bytes(m->desc.tile_side)))
        return ism__no_memory(&job->log);
    first.part = ism__part_of(&job->part, 0.0f, 0.5f);
    result = ism__scatter(m, &first);
    if (result != ISM_OK) return result;
    ism__blank_tiles(m);
    if (w.lanes && !ism__run(m, &job->part, 0.5f, 1.0f, w.lanes, ism__lane_task, &w))
        return ISM_ERR_CANCELLED;
    m->stats.splats = m->stats.wide_splats = m->stats.filled = 0;
    for (i = 0; i < w.lanes; i++) {
        const char *end = (const char *)m->scratch.data + (i + 1u) * ism__lane_bytes(m->desc.tile_side);
        const uint64_t *stats = (const uint64_t *)(const void *)(end - 64u);
        m->stats.splats += stats[0];
        m->stats.wide_splats += stats[1];
        m->stats.filled += stats[2];
    }
    m->built = 1;
    return ISM_OK;
}

ISM_DEF ism_result ism_build(ism_maps *m, const ism_frame *f)
{
    ism__job job;
    ism_result result = ism__open_frame(m, f, "ism_build", &job);
    if (result != ISM_OK) return result;
    return m->chosen ? ism__build(m, &job)
                     : ism__too_early(&job.log, "maps", "have no VPLs: call ism_choose before");
}

ISM_DEF const float *ism_atlas(const ism_maps *m, uint32_t *side, uint32_t *tiles_across)
{
    if (!m || !m->built) return NULL;
    if (side) *side = m->side;
    if (tiles_across) *tiles_across = m->tiles;
    return (const float *)m->atlas.data;
}
