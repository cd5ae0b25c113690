/* ---- shared lights: those that all receivers take ---- */

/* Returns texel number i of a map in an order of tiles: 32 x 32 texels, which are a run, in tiles of 8 x 8,
   which are a block. So the lights of runs and blocks lie close together, and few of these are near a
   receiver. Returns (size_t)-1 for a place of a tile that lies outside the map. */
static inline size_t rsm__tiled_texel(const rsm_map *map, size_t i)
{
    size_t tiles = (map->side + 31u) / 32u, tile = i / 1024u, face = tile / (tiles * tiles);
    size_t x = tile % tiles * 32u + (i >> 6 & 3u) * 8u + (i & 7u);
    size_t y = tile / tiles % tiles * 32u + (i >> 8 & 3u) * 8u + (i >> 3 & 7u);
    return x < map->side && y < map->side ? (face * map->side + y) * map->side + x : (size_t)-1;
}

/* Returns whether a texel gives light: it has diffuse flux, or a lobe, which black texels may have too. For
   visible_fn black texels have no number. */
static inline int rsm__gives_light(const rsm__gather *g, const rsm_texel *t)
{
    return rsm__mean3(t->flux) > 0.0f ||
           (!g->desc.visible_fn && t->material != 0 && t->material <= g->desc.material_count &&
            t->depth < RSM_FAR);
}

/* Makes room for the number of each lane. Returns 0 if there is no memory. */
static inline int rsm__make_numbers(rsm__source *s, size_t lanes, const rsm__allocator *a)
{
    s->numbers = (uint32_t *)rsm__alloc_array(a, lanes, sizeof *s->numbers);
    if (s->numbers) memset(s->numbers, 0, lanes * sizeof *s->numbers);
    return s->numbers != NULL;
}

/* Returns how many texels of a map give light. */
static inline size_t rsm__count_texels(const rsm__gather *g, const rsm_map *map)
{
    size_t at, texels = rsm__texel_count(map), count = 0;
    if (!g->desc.materials || g->desc.visible_fn) return (size_t)map->stats.lit_texels;
    for (at = 0; at < texels; at++) count += (size_t)rsm__gives_light(g, map->texels + at);
    return count;
}

/* Packs the pixel lights of a map that all receivers share into blocks, set by set, each set padded to whole
   blocks. */
static inline rsm_result rsm__pack_map(rsm__gather *g, rsm__source *s, const rsm__allocator *a)
{
    const rsm_map *map = s->map;
    size_t texels = rsm__texel_count(map);
    size_t count = g->desc.sample_count ? g->shared : rsm__count_texels(g, map);
    size_t per_set = (count + g->sets - 1) / g->sets, i, at = 0;
    size_t placed = 0, lanes;
    int nearby = g->desc.near_field > 0.0f && g->desc.sample_count == 0;
    int tiled = nearby && g->sets == 1 && !g->desc.visible_fn; /* numbers count texels row by row */
    if (tiled) texels = (size_t)map->faces * ((map->side + 31u) / 32u) * ((map->side + 31u) / 32u) * 1024u;
    s->set_blocks = (per_set + RSM__BLOCK - 1) / RSM__BLOCK;
    s->set_lights = per_set;
    s->set_lanes = (per_set + RSM__LANES - 1) / RSM__LANES * RSM__LANES;
    lanes = s->set_blocks * g->sets * RSM__BLOCK;
    if (count == 0) return RSM_OK;
    s->blocks = (rsm__block *)rsm__alloc_array(a, s->set_blocks * g->sets, sizeof *s->blocks);
    if (g->desc.materials) s->gloss = (rsm__gloss *)rsm__alloc_array(a, lanes, sizeof *s->gloss);
    if (!s->blocks || (g->desc.materials && !s->gloss)) return RSM_ERR_ALLOC;
    for (i = 0; i < lanes; i++) rsm__lane_clear(s->blocks + i / RSM__BLOCK, i % RSM__BLOCK);
    if (s->gloss) memset(s->gloss, 0, lanes * sizeof *s->gloss);
    if (g->desc.visible_fn && !rsm__make_numbers(s, lanes, a)) return RSM_ERR_ALLOC;
    for (i = 0; i < (g->desc.sample_count ? count : texels); i++) {
        size_t set, lane;
        float weight = 1.0f;
        if (g->desc.sample_count) {
            if (!rsm__pick_texel(map, (uint32_t)i, (uint32_t)count, g->desc.seed, &at, &weight)) continue;
        } else {
            at = tiled ? rsm__tiled_texel(map, i) : i;
            if (at == (size_t)-1 || !rsm__gives_light(g, map->texels + at)) continue;
        }
        set = rsm__hash_combine(g->desc.seed, (uint32_t)(placed / g->sets));
        set = (placed + set) % g->sets; /* each run of `sets` neighbours is dealt out to all sets, in an order
                                           of its own */
        lane = set * s->set_blocks * RSM__BLOCK + placed / g->sets;
        rsm__lane_set(&g->desc, s->blocks + lane / RSM__BLOCK, lane % RSM__BLOCK, map->texels + at, weight,
                      (float)g->sets);
        if (g->centred) {
            rsm__block *k = s->blocks + lane / RSM__BLOCK;
            size_t row = at / map->side;
            rsm__v3 place = rsm__mixed_place(map, (uint32_t)(row / map->side), (uint32_t)(at % map->side),
                                             (uint32_t)(row % map->side));
            k->lx[lane % RSM__BLOCK] = place.x;
            k->ly[lane % RSM__BLOCK] = place.y;
            k->lz[lane % RSM__BLOCK] = place.z;
            k->density[lane % RSM__BLOCK] = 1.0f / weight;
        }
        if (s->gloss) rsm__gloss_set(&g->desc, map, s->gloss + lane, at, weight * (float)g->sets);
        if (nearby) rsm__lane_near(&g->desc, map, s->blocks + lane / RSM__BLOCK, lane % RSM__BLOCK, at);
        if (s->numbers) s->numbers[lane] = (uint32_t)(g->numbered + placed);
        placed++;
    }
    g->numbered += placed;
    return nearby ? rsm__find_reaches(g, s, a) : RSM_OK;
}

/* Packs a list of pixel lights into blocks, set by set. A light that cannot be used leaves its lane empty. */
static inline rsm_result rsm__pack_list(rsm__gather *g, rsm__source *s, const rsm_texel *lights, size_t count,
                                        const rsm__allocator *a)
{
    size_t i, per_set = (count + g->sets - 1) / g->sets, lanes;
    s->set_blocks = (per_set + RSM__BLOCK - 1) / RSM__BLOCK;
    s->set_lights = per_set;
    s->set_lanes = (per_set + RSM__LANES - 1) / RSM__LANES * RSM__LANES;
    lanes = s->set_blocks * g->sets * RSM__BLOCK;
    if (count == 0) return RSM_OK;
    s->blocks = (rsm__block *)rsm__alloc_array(a, s->set_blocks * g->sets, sizeof *s->blocks);
    if (!s->blocks) return RSM_ERR_ALLOC;
    for (i = 0; i < lanes; i++) rsm__lane_clear(s->blocks + i / RSM__BLOCK, i % RSM__BLOCK);
    if (g->desc.visible_fn && !rsm__make_numbers(s, lanes, a)) return RSM_ERR_ALLOC;
    for (i = 0; i < count; i++) {
        size_t lane = i % g->sets * s->set_blocks * RSM__BLOCK + i / g->sets;
        if (s->numbers) s->numbers[lane] = (uint32_t)i;
        if (rsm__is_usable(rsm__v3_load(lights[i].position)) &&
            rsm__is_usable(rsm__v3_load(lights[i].normal)) && lights[i].flux[0] >= 0.0f &&
            lights[i].flux[1] >= 0.0f && lights[i].flux[2] >= 0.0f &&
            rsm__mean3(lights[i].flux) <= 1e18f)
            rsm__lane_set(&g->desc, s->blocks + lane / RSM__BLOCK, lane % RSM__BLOCK, lights + i, 1.0f,
                          (float)g->sets);
    }
    return RSM_OK;
}

/* Adds the lobes of the lights of block `at`, each times its factor; NULL = 1. */
static inline void rsm__gather_gloss(const rsm__source *s, size_t at, size_t lanes, const float *factors,
                                     const float x[7], rsm__sum *sum)
{
    const rsm__block *block = s->blocks + at;
    size_t k;
    int c;
    for (k = 0; k < lanes; k++) {
        rsm__gloss gloss = s->gloss[at * RSM__BLOCK + k];
        float mean;
        if (!(gloss.scale[0] > 0.0f || gloss.scale[1] > 0.0f || gloss.scale[2] > 0.0f)) continue;
        for (c = 0; c < 3 && factors; c++) gloss.scale[c] *= factors[k];
        mean = s->reaches && rsm__is_near(block, k, x) ? rsm__near_texel_form(s->map, block, k, x) : -1.0f;
        rsm__add_gloss(&gloss, block, k, x, mean, sum);
    }
}

/* Asks visible_fn about those lights of block `at` that could light the receiver, and writes for each lane
   how much the receiver sees of it: 0 for the others. A near texel may reach over the receiver's horizon,
   though its centre lies below. */
static inline void rsm__see_block(const rsm__gather *g, const rsm__source *s, size_t at, size_t lanes,
                                  const float x[7], float seen[RSM__BLOCK])
{
    const rsm__block *b = s->blocks + at;
    float visible[RSM__BLOCK];
    uint32_t numbers[RSM__BLOCK];
    size_t lane[RSM__BLOCK], asked = 0, k;
    for (k = 0; k < lanes; k++) {
        float dx = b->px[k] - x[0], dy = b->py[k] - x[1], dz = b->pz[k] - x[2];
        seen[k] = 0.0f;
        if (!(b->nx[k] * dx + b->ny[k] * dy + b->nz[k] * dz < 0.0f)) continue;
        if (!(x[3] * dx + x[4] * dy + x[5] * dz > 0.0f) && !(s->reaches && rsm__is_near(b, k, x))) continue;
        numbers[asked] = s->numbers[at * RSM__BLOCK + k];
        visible[asked] = 0.0f;
        lane[asked++] = k;
    }
    if (asked) g->desc.visible_fn(g->desc.visible_user, x, x + 3, numbers, asked, visible);
    for (k = 0; k < asked; k++)
        seen[lane[k]] = visible[k] > 0.0f ? visible[k] < 1.0f ? visible[k] : 1.0f : 0.0f;
}

/* Gathers from the lights of a source that all receivers share, as visible_fn lets each receiver see them. */
static inline void rsm__gather_seen(const rsm__gather *g, const rsm__source *s, const float x[7],
                                    uint32_t set, rsm__sum *sum)
{
    size_t i, k;
    for (i = 0; i < s->set_blocks; i++) {
        size_t at = set * s->set_blocks + i, left = s->set_lanes - i * RSM__BLOCK;
        size_t lanes = left < RSM__BLOCK ? left : (size_t)RSM__BLOCK;
        rsm__block block = s->blocks[at];
        float seen[RSM__BLOCK];
        rsm__see_block(g, s, at, lanes, x, seen);
        for (k = 0; k < lanes; k++) {
            block.r[k] *= seen[k];
            block.g[k] *= seen[k];
            block.b[k] *= seen[k];
        }
        if (s->reaches && rsm__is_within_reach(s->reaches + at, x))
            rsm__kernel_near(g, s->map, &block, lanes, x, sum);
        else g->kernel(&block, lanes, x, sum);
        if (s->gloss) rsm__gather_gloss(s, at, lanes, seen, x, sum);
    }
}

/* Gathers from the lights of a source that all receivers share: by runs, or block by block if MIXED weighs
   each light for this receiver. */
static inline void rsm__gather_shared(const rsm__gather *g, const rsm__source *s, const float x[7],
                                      uint32_t set, rsm__sum *sum)
{
    const rsm__block *blocks = s->blocks + set * s->set_blocks;
    const rsm__reach *runs = s->reaches ? s->reaches + s->set_blocks * g->sets + set * s->set_runs : NULL;
    rsm__block mixed;
    rsm__v3 frame[2], centre;
    float scale = 0.0f;
    size_t i, k;
    if (s->numbers) {
        rsm__gather_seen(g, s, x, set, sum);
        return;
    }
    centre = rsm__v3_make(0, 0, 0);
    if (g->centred && s->map) {
        centre = rsm__v3_scale(rsm__centre_of(s->map, rsm__v3_make(x[0], x[1], x[2]), 1, frame),
                               s->map->faces == 1 ? 1.0f : 0.5f);
        scale = rsm__mixed_scale(g, s->map);
    }
    for (i = 0; i < s->set_lanes && !(scale > 0.0f); i += RSM__RUN) {
        /* Sums are short, since long ones of floats lose bits where lights are many. */
        size_t lanes = s->set_lanes - i < RSM__RUN ? s->set_lanes - i : (size_t)RSM__RUN;
        if (runs && rsm__is_within_reach(runs + i / RSM__RUN, x))
            rsm__gather_near(g, s, set, i, lanes, x, sum);
        else g->kernel(blocks + i / RSM__BLOCK, lanes, x, sum);
    }
    for (i = 0; i < s->set_blocks && (scale > 0.0f || s->gloss); i++) {
        size_t lanes =
            s->set_lanes - i * RSM__BLOCK < RSM__BLOCK ? s->set_lanes - i * RSM__BLOCK : (size_t)RSM__BLOCK;
        if (scale > 0.0f) {
            mixed = blocks[i];
            for (k = 0; k < lanes; k++) {
                float dx = mixed.lx[k] - centre.x, dy = mixed.ly[k] - centre.y, dz = mixed.lz[k] - centre.z;
                float q = (dx * dx + dy * dy + dz * dz + RSM__MIXED_INNER) * mixed.density[k],
                      w = q / (q + scale);
                mixed.r[k] *= w;
                mixed.g[k] *= w;
                mixed.b[k] *= w;
                mixed.density[k] = w;
            }
            g->kernel(&mixed, lanes, x, sum);
        }
        if (s->gloss)
            rsm__gather_gloss(s, set * s->set_blocks + i, lanes, scale > 0.0f ? mixed.density : NULL, x, sum);
    }
}
