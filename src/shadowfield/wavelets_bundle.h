/* ---- wavelets: sixteen points at a time ---- */

static size_t sfield__carve_bundle(sfield__bundle *b, uint8_t *memory, uint32_t rays, uint32_t side)
{
    const size_t strands = (rays < SFIELD__STRANDS ? rays : (uint32_t)SFIELD__STRANDS) + 1;
    const size_t plane = 16 * (size_t)side * side, lists = strands * SFIELD__STRAND_LISTS;
    if (memory) {
        b->t = (float *)(void *)memory;
        b->w = b->t + plane;
        b->list = (sfield__listing *)(void *)(b->w + plane);
        b->strand = (sfield__strand *)(void *)(b->list + lists);
        b->trial = b->strand + strands;
        b->used = (uint16_t *)(void *)(b->trial + strands);
        b->marks = (uint8_t *)(b->used + SFIELD__MARKS);
        memset(b->marks, 0, SFIELD__MARKS);
    }
    return (2 * plane * sizeof(float) + 2 * strands * sizeof(sfield__strand) +
            lists * sizeof(sfield__listing) + 3 * SFIELD__MARKS + 63) /
           64 * 64;
}

/* Puts the rays of a point among those of the bundle, from near to far. Returns 0 if they have another order,
   or are too many. */
static int sfield__weave_rays(sfield__bundle *b, const sfield__point *p, uint32_t rays, const float *x,
                         uint32_t lane, uint64_t *hidden)
{
    uint32_t i, j, at = 0, count = b->strands;
    memcpy(b->trial, b->strand, count * sizeof *b->trial);
    for (i = 0; i < rays; i++) {
        const sfield__ray *r = &p->ray[i];
        if (r->light < 0 && sfield__is_hidden(p, i, x)) {
            ++*hidden;
            continue;
        }
        for (j = 0; j < count && (b->trial[j].item != r->item || b->trial[j].light != r->light);) j++;
        if (j < at) return 0;
        if (j == count) {
            if (count == SFIELD__STRANDS) return 0;
            j = at;
            memmove(b->trial + j + 1, b->trial + j, (count++ - j) * sizeof *b->trial);
            b->trial[j].item = r->item;
            b->trial[j].light = r->light;
            b->trial[j].lanes = 0;
        }
        b->trial[j].lanes |= 1u << lane;
        b->trial[j].d2[lane] = r->d2;
        at = j + 1;
    }
    b->strands = count;
    memcpy(b->strand, b->trial, count * sizeof *b->trial);
    return 1;
}

/* Takes what is kept at a sample for one more lane. */
static void sfield__take_list(sfield__strand *strand, const sfield_field *f, size_t sample, uint32_t lane,
                              float weight)
{
    sfield__listing *l = strand->list, *end = l + strand->count;
    while (l < end && l->sample != sample) l++;
    if (l == end) {
        memset(l->weight, 0, sizeof l->weight);
        l->sample = sample;
        l->e = f->entry + (size_t)f->offset[sample] * f->h.stride;
        l->end = f->entry + (size_t)f->offset[sample + 1] * f->h.stride;
        strand->count++;
    }
    l->weight[lane] += weight;
}

/* Takes the samples around the lanes' places. Those of occluders fade over the last quarter of their
   reach. */
static void sfield__take_lists(sfield__strand *strand, const sfield__item *it, const sfield__tile *tile,
                               int simd)
{
    const int which = strand->light >= 0;
    const sfield_field *f = which ? it->e.source : it->e.occlusion;
    float local[48];
    sfield__place at;
    sfield__lists lists;
    uint32_t l, k;
    strand->count = 0;
    sfield__move_to_local(it, which, tile->p, local, simd);
    sfield__locate16(f, local, &at, simd);
    for (l = 0; l < SFIELD__LANES; l++) {
        float factor = 1;
        if (!(strand->lanes >> l & 1)) continue;
        sfield__find_lists(f, &at, (int)l, which ? it->e.time : 0.0f, &lists);
        if (!which) factor = 4 * (1 - sqrtf(strand->d2[l]) / it->reach);
        factor = factor < 1 ? factor : 1.0f;
        for (k = 0; k < lists.count; k++)
            sfield__take_list(strand, f, lists.sample[k], l, lists.weight[k] * factor);
    }
}

/* Shades the woven lanes of a tile: each by its own entities, all face by face. */
static void sfield__run_bundle(sfield__bundle *b, const sfield_points *set, const sfield__tile *tile,
                               uint32_t lanes)
{
    const sfield_scene *s = b->s;
    uint32_t i, l, face;
    if (set->self) {
        memmove(b->strand + 1, b->strand, b->strands++ * sizeof *b->strand);
        b->strand[0].light = -2;
        b->strand[0].count = 0;
    }
    for (i = 0; i < b->strands; i++) {
        sfield__strand *strand = &b->strand[i];
        strand->list = b->list + (size_t)i * SFIELD__STRAND_LISTS;
        if (strand->light >= -1) sfield__take_lists(strand, &s->item[strand->item], tile, s->simd);
        for (l = 0; strand->light < -1 && l < SFIELD__LANES; l++)
            if (lanes >> l & 1) sfield__take_list(strand, set->self, tile->first + l, l, 1);
    }
    memcpy(b->n, tile->n, sizeof b->n);
    memset(b->rgb, 0, sizeof b->rgb);
    memset(b->open, 0, sizeof b->open);
    b->ambient = set->ambient != NULL;
    for (face = 0; face < 6; face++) SFIELD__CALL_BEST(sfield__face_shade, s->simd, (b, set->self, face));
    for (l = 0; l < SFIELD__LANES; l++) {
        const size_t at = tile->first + l;
        if (!(lanes >> l & 1)) continue;
        for (i = 0; i < 3 && set->rgb; i++) set->rgb[3 * at + i] = b->rgb[16 * i + l] * 0.318309886f;
        if (set->ambient) set->ambient[at] = b->open[l] * 0.318309886f;
    }
}

/* Shades as many lanes together as have one order of their entities. One or two lanes go by themselves. */
static void sfield__shade_bundle(sfield__point *p, sfield__bundle *b, size_t first, uint32_t lanes,
                                 uint64_t *hash)
{
    const sfield_points *set = p->set;
    const uint32_t lights = sfield__lights_of(p->s, set, p->s->has_sky || p->s->has_sun);
    sfield__tile tile;
    uint32_t l, k, i, left = (1u << lanes) - 1;
    memset(&tile, 0, sizeof tile);
    tile.s = p->s;
    tile.set = set;
    tile.first = first;
    tile.lanes = lanes;
    sfield__load_lanes(&tile);
    while (left) {
        const sfield_scene_stats before = p->stats;
        uint32_t taken = 0, count = 0;
        b->strands = 0;
        for (l = 0; l < lanes; l++) {
            const sfield_scene_stats then = p->stats;
            uint64_t hidden = 0;
            float x[3], n[3];
            if (!(left & tile.in_view & 1u << l)) continue;
            for (k = 0; k < 3; k++) {
                x[k] = tile.p[16 * k + l];
                n[k] = tile.n[16 * k + l];
            }
            if (sfield__weave_rays(b, p, sfield__find_rays(p, x, n), x, l, &hidden)) {
                taken |= 1u << l;
                count++;
                p->stats.culled_hidden += hidden;
            } else if (!taken) {                /* more than a bundle takes */
                taken = 1u << l;
                break;
            } else p->stats = then;
        }
        if (count < SFIELD__FEWEST) {
            p->stats = before;
            taken = taken ? taken : left;
            for (l = 0; l < lanes; l++)
                if (taken >> l & 1) sfield__shade_point(p, first + l, hash);
        } else {
            p->stats.points += count;
            p->stats.lights += (uint64_t)count * lights;
            for (i = 0; i < b->strands; i++)
                for (l = 0; b->strand[i].light < 0 && l < lanes; l++)
                    p->stats.products += b->strand[i].lanes >> l & 1;
            sfield__run_bundle(b, set, &tile, taken);
        }
        left &= ~taken;
    }
}

/* Returns whether a set can be shaded in bundles: texels are multiplied, no cache keeps anything, and no
   entity is turned that hides, shines or has a visibility of its own. */
static int sfield__can_bundle(const sfield_scene *s, const sfield_points *set)
{
    uint32_t i;
    if (set->cache || s->desc.product == SFIELD_PRODUCT_SPARSE) return 0;
    if (set->self && set->entity && s->item[set->entity - 1].map) return 0;
#ifndef SFIELD_WITHOUT_ROOMS
    if (sfield__has_home(s, set)) return 0;
#endif
    for (i = 0; i < s->item_count; i++)
        if (s->item[i].map && (s->item[i].e.occlusion || s->item[i].e.source)) return 0;
    return 1;
}
