/* ---- structured: structured importance sampling ---- */

/* Agarwal, Ramamoorthi, Belongie and Jensen, "Structured importance sampling of environment maps", SIGGRAPH
   2003. Thresholds i sigma, i = 5 .. 0, cut the map into layers. From the brightest layer down, each
   connected region of energy L and solid angle w gets N L min(w, w0)^(1/4) / (L_all w0^(1/4)) samples. w0 is
   0.01 sr: across more than that, visibility is as good as uncorrelated, so that a larger size counts no
   more. Samples that the region holds from brighter layers count among its samples; the others are spread by
   Hochbaum and Shmoys' farthest-first traversal. A texel belongs to the nearest sample of the innermost
   region that got samples of its own. */
#define ENVLT__LAYERS 6u
#define ENVLT__BLOCK 8u             /* texels a side of a block, by which distances are skipped */
#define ENVLT__FROZEN 0x80u         /* bit of a texel's layer: its sample does not change any more */
#define ENVLT__SAMPLE 0x40u         /* bit of a texel's layer: the texel is a sample itself */

typedef struct envlt__block {
    float    center[3], radius;             /* the cone that holds the directions of its texels */
    float    skip;                          /* a sample whose cosine to the centre is this or less changes no
                                               texel of the block */
    float    worst;                         /* the least cosine of a candidate to its sample */
    uint32_t worst_texel;
    uint32_t face;
    uint32_t x0, y0, x1, y1;
} envlt__block;

typedef struct envlt__structured {
    const envlt__grid *g;
    float        *best;                     /* cosine to the nearest sample of the region at hand */
    uint32_t     *label, *owner, *queue;    /* owner is the region that a texel is in */
    uint8_t      *layer;
    uint32_t     *sample;                   /* the texel of each sample */
    uint32_t      count, wanted, region;
    envlt__block *blocks;
    uint32_t      block_count, blocks_wide, blocks_high;
} envlt__structured;

/* Divides the grid into blocks and finds the cone of each. */
static void envlt__make_blocks(envlt__structured *s)
{
    const envlt__grid *g = s->g;
    uint32_t b, x, y;
    for (b = 0; b < s->block_count; b++) {
        envlt__block *k = &s->blocks[b];
        envlt__v3 sum = envlt__v3_make(0, 0, 0);
        float least = 1.0f, c;
        k->face = b / (s->blocks_wide * s->blocks_high);
        k->x0 = b % s->blocks_wide * ENVLT__BLOCK;
        k->y0 = b / s->blocks_wide % s->blocks_high * ENVLT__BLOCK;
        k->x1 = k->x0 + ENVLT__BLOCK < g->width ? k->x0 + ENVLT__BLOCK : g->width;
        k->y1 = k->y0 + ENVLT__BLOCK < g->height ? k->y0 + ENVLT__BLOCK : g->height;
        for (y = k->y0; y < k->y1; y++)
            for (x = k->x0; x < k->x1; x++) {
                size_t t = ((size_t)k->face * g->height + y) * g->width + x;
                sum = envlt__v3_add(sum, envlt__v3_make(g->dx[t], g->dy[t], g->dz[t]));
            }
        sum = envlt__v3_normalize(sum);
        envlt__v3_store(k->center, sum);
        for (y = k->y0; y < k->y1; y++)
            for (x = k->x0; x < k->x1; x++) {
                size_t t = ((size_t)k->face * g->height + y) * g->width + x;
                c = sum.x * g->dx[t] + sum.y * g->dy[t] + sum.z * g->dz[t];
                if (c < least) least = c;
            }
        k->radius = envlt__acos(least) + 1e-3f;
    }
}

/* Compares the sample with every texel of the block, then finds which candidate is farthest from its sample,
   and how far away a further sample has no effect. A texel that is a sample itself, or no candidate, has best
   = 2. */
static void envlt__update_block(const envlt__structured *s, envlt__block *k, uint32_t id)
{
    const envlt__grid *g = s->g;
    uint32_t at = s->sample[id], y;
    float cx = g->dx[at];
    float cy = g->dy[at];
    float cz = g->dz[at];
    float farthest = 2.0f;
    float reach;
    k->worst = 2.0f;
    for (y = k->y0; y < k->y1; y++) {
        size_t row = ((size_t)k->face * g->height + y) * g->width, t;
        for (t = row + k->x0; t < row + k->x1; t++) {
            float d = cx * g->dx[t] + cy * g->dy[t] + cz * g->dz[t], best = s->best[t];
            if (d > best) {
                s->best[t] = best = d;
                s->label[t] = id;
            }
            if (best < farthest) farthest = best;
            if (best < k->worst && g->lum[t] > 0.0f) {
                k->worst = best;
                k->worst_texel = (uint32_t)t;
            }
        }
    }
    reach = (farthest > 1.0f ? 0.0f : envlt__acos(farthest)) + k->radius;
    k->skip = farthest > 1.5f ? 2.0f : reach < 3.14f ? envlt__cos(reach) - 1e-5f : -2.0f;
}

/* Updates all blocks in which the new sample may be the nearest of some texel. */
static void envlt__add_sample(envlt__structured *s, uint32_t id)
{
    const envlt__grid *g = s->g;
    uint32_t at = s->sample[id], b;
    for (b = 0; b < s->block_count; b++) {
        envlt__block *k = &s->blocks[b];
        if (g->dx[at] * k->center[0] + g->dy[at] * k->center[1] + g->dz[at] * k->center[2] > k->skip)
            envlt__update_block(s, k, id);
    }
}

/* Returns whether the region has an earlier sample within two degrees. Samples of brighter layers that crowd
   together count as one outside their own region: else each of the hundred samples of a sun would be compared
   with the whole sky. */
static int envlt__has_twin(const envlt__structured *s, uint32_t id)
{
    const envlt__grid *g = s->g;
    uint32_t a = s->sample[id], b, i;
    for (i = 0; i < id; i++) {
        b = s->sample[i];
        if (s->owner[b] != s->region) continue;
        if (g->dx[a] * g->dx[b] + g->dy[a] * g->dy[b] + g->dz[a] * g->dz[b] > 0.99939f) return 1;
    }
    return 0;
}

/* Spreads fresh samples, farthest first, over the region whose texels are queue[0..size), or over all texels
   if size is 0. brightest is where the first sample goes if there is none yet. */
static void envlt__spread_samples(envlt__structured *s, uint32_t size, uint32_t brightest, uint32_t fresh)
{
    uint32_t i, b;
    uint32_t n = size ? size : (uint32_t)s->g->count;
    uint32_t before = s->count;
    uint32_t last = before + fresh;
    for (b = 0; b < s->block_count; b++) s->blocks[b].skip = size ? 2.0f : -2.0f;
    for (b = 0; b < s->block_count; b++) s->blocks[b].worst = 2.0f;
    for (i = 0; i < n; i++) {
        uint32_t t = size ? s->queue[i] : i, row = t / s->g->width;
        uint32_t y = row % s->g->height / ENVLT__BLOCK, face = row / s->g->height;
        if (s->layer[t] & ENVLT__FROZEN) continue;
        s->best[t] = -2.0f;
        if (size)
            s->blocks[(face * s->blocks_high + y) * s->blocks_wide +
                      t % s->g->width / ENVLT__BLOCK].skip = -2.0f;
    }
    for (i = 0; i < before; i++)
        if (s->owner[s->sample[i]] == s->region && !envlt__has_twin(s, i)) envlt__add_sample(s, i);
    while (s->count < last) {
        uint32_t at = brightest;
        float worst = 2.0f;
        for (b = 0; b < s->block_count; b++)
            if (s->blocks[b].worst < worst) {
                worst = s->blocks[b].worst;
                at = s->blocks[b].worst_texel;
            }
        if (worst > 1.5f && (s->count > before || s->layer[at] & ENVLT__FROZEN)) break;
        s->sample[s->count] = at;
        s->layer[at] |= ENVLT__SAMPLE;
        s->best[at] = 2.0f;
        s->label[at] = s->count;
        envlt__add_sample(s, s->count++);
    }
    for (i = 0; i < n; i++) {
        s->layer[size ? s->queue[i] : i] |= ENVLT__FROZEN;
        s->best[size ? s->queue[i] : i] = 2.0f;
    }
}

/* Fills the queue with the connected region of texels in this layer or above round the seed, and returns its
   size. */
static uint32_t envlt__flood_region(envlt__structured *s, uint32_t seed, uint32_t layer, double *energy,
                                    double *omega, uint32_t *samples, uint32_t *brightest)
{
    uint32_t head = 0, tail = 0, next[4], i;
    float most = -1.0f;
    *energy = *omega = 0.0;
    *samples = 0;
    s->queue[tail++] = seed;
    s->owner[seed] = s->region;
    while (head < tail) {
        uint32_t t = s->queue[head++];
        *energy += envlt__texel_weight(s->g, t);
        *omega += (double)s->g->omega[t];
        *samples += (s->layer[t] & ENVLT__SAMPLE) != 0;
        if (s->g->lum[t] > most && !(s->layer[t] & ENVLT__FROZEN)) {
            most = s->g->lum[t];
            *brightest = t;
        }
        envlt__neighbours(s->g, t, next);
        for (i = 0; i < 4; i++)
            if ((s->layer[next[i]] & 15u) >= layer && s->owner[next[i]] != s->region) {
                s->owner[next[i]] = s->region;
                s->queue[tail++] = next[i];
            }
    }
    return tail;
}

/* Sorts texels into layers by luminance, and writes the solid angle of all of them. */
static void envlt__make_layers(envlt__structured *s, double *all_omega)
{
    const envlt__grid *g = s->g;
    double mean, variance = 0.0, omega = 0.0, sigma;
    size_t t;
    for (t = 0; t < g->count; t++) omega += (double)g->omega[t];
    mean = omega > 0.0 ? g->total / omega : 0.0;
    for (t = 0; t < g->count; t++) {
        double d = (double)g->lum[t] - mean;
        variance += d * d * (double)g->omega[t];
    }
    sigma = omega > 0.0 ? sqrt(variance / omega) : 0.0;
    for (t = 0; t < g->count; t++) {
        uint32_t i = 0;
        while (i + 1 < ENVLT__LAYERS && sigma > 0.0 && (double)g->lum[t] >= (i + 1) * sigma) i++;
        s->layer[t] = (uint8_t)i;
        s->owner[t] = 0;
        s->label[t] = ENVLT_NO_LIGHT;
        s->best[t] = 2.0f;
    }
    *all_omega = omega;
}

/* Returns the importance of a region, by which samples are shared out: see the head of this part. */
static double envlt__importance(double energy, double omega)
{
    return energy * sqrt(sqrt(omega < 0.01 ? omega : 0.01));
}

/* Places all samples: layer by layer from the brightest down, then what is left of them over the whole map.
   */
static void envlt__run_structured(envlt__structured *s)
{
    const envlt__grid *g = s->g;
    double all, energy, omega;
    uint32_t layer, samples;
    uint32_t brightest = 0;
    uint32_t size, fresh;
    size_t t, first = 0;

    envlt__make_layers(s, &omega);
    envlt__make_blocks(s);
    all = envlt__importance(g->total, omega);
    for (layer = ENVLT__LAYERS - 1; layer > 0; layer--) {
        uint32_t oldest = s->region + 1;
        for (t = 0; t < g->count; t++) {
            double share;
            if ((s->layer[t] & 15u) < layer || s->owner[t] >= oldest) continue;
            s->region++;
            size = envlt__flood_region(s, (uint32_t)t, layer, &energy, &omega, &samples, &brightest);
            share = (double)s->wanted * envlt__importance(energy, omega) / all + 0.5;
            fresh = share > samples + 1.0 ? (uint32_t)share - samples : 0;
            if (fresh > s->wanted - s->count) fresh = s->wanted - s->count;
            if (fresh && !(s->layer[brightest] & ENVLT__FROZEN))
                envlt__spread_samples(s, size, brightest, fresh);
        }
    }
    s->region++;
    for (t = 0; t < g->count; t++) {
        if (!(g->omega[t] > 0.0f)) s->layer[t] |= ENVLT__FROZEN;
        else if (!(s->layer[t] & ENVLT__FROZEN) &&
                 (s->layer[first] & ENVLT__FROZEN || g->lum[t] > g->lum[first]))
            first = t;
        s->owner[t] = s->region;
    }
    envlt__spread_samples(s, 0, (uint32_t)first, s->wanted - s->count);
}

/* Returns the first texel of the row of averages that holds row y of the grid, faces counted through. */
static size_t envlt__coarse_row(const envlt__grid *g, const envlt__grid *coarse, uint32_t factor, uint32_t y)
{
    return ((size_t)(y / g->height) * coarse->height + y % g->height / factor) * coarse->width;
}

/* Makes a grid of averages over factor x factor texels, fewer at the edges. Returns 0 if there is no memory.
   */
static int envlt__coarsen_grid(const envlt__grid *g, uint32_t factor, envlt__grid *out,
                               const envlt__allocator *a)
{
    uint32_t x, y, left;
    size_t t = 0, i;
    *out = *g;
    out->width = (g->width + factor - 1) / factor;
    out->height = (g->height + factor - 1) / factor;
    out->count = (size_t)out->width * out->height * g->faces;
    out->memory = (float *)envlt__alloc_array(a, out->count, 5 * sizeof(float));
    if (!out->memory) return 0;
    out->lum = out->memory;
    out->omega = out->lum + out->count;
    out->dx = out->omega + out->count;
    out->dy = out->dx + out->count;
    out->dz = out->dy + out->count;
    memset(out->memory, 0, 5 * out->count * sizeof(float));
    for (y = 0; y < g->height * g->faces; y++) {
        i = envlt__coarse_row(g, out, factor, y);
        for (x = 0, left = factor; x < g->width; x++, t++) {
            out->lum[i] += (float)envlt__texel_weight(g, t);
            out->omega[i] += g->omega[t];
            out->dx[i] += g->dx[t];
            out->dy[i] += g->dy[t];
            out->dz[i] += g->dz[t];
            if (--left) continue;
            left = factor;
            i++;
        }
    }
    for (i = 0; i < out->count; i++) {
        envlt__v3 d = envlt__v3_normalize(envlt__v3_make(out->dx[i], out->dy[i], out->dz[i]));
        if (out->omega[i] > 0.0f) out->lum[i] /= out->omega[i];
        out->dx[i] = d.x;
        out->dy[i] = d.y;
        out->dz[i] = d.z;
    }
    return 1;
}

/* Labels texels by structured sampling. A map of more than 2^17 texels is first reduced to averages of about
   half a degree, which is far below the distance of samples. */
static envlt_result envlt__label_structured(const envlt__grid *g, uint32_t k, uint32_t *label,
                                            const envlt__allocator *a)
{
    envlt__structured s;
    envlt__grid coarse;
    envlt_result result = ENVLT_ERR_ALLOC;
    uint32_t factor = 1, x, y, left;
    size_t t = 0;
    while (g->count / factor / factor > 131072u) factor++;
    memset(&s, 0, sizeof s);
    if (!envlt__coarsen_grid(g, factor, &coarse, a)) return result;
    s.g = &coarse;
    s.wanted = k;
    s.blocks_wide = (coarse.width + ENVLT__BLOCK - 1) / ENVLT__BLOCK;
    s.blocks_high = (coarse.height + ENVLT__BLOCK - 1) / ENVLT__BLOCK;
    s.block_count = s.blocks_wide * s.blocks_high * coarse.faces;
    s.best = (float *)envlt__alloc_array(a, coarse.count, sizeof *s.best);
    s.label = (uint32_t *)envlt__alloc_array(a, coarse.count, sizeof *s.label);
    s.owner = (uint32_t *)envlt__alloc_array(a, coarse.count, sizeof *s.owner);
    s.queue = (uint32_t *)envlt__alloc_array(a, coarse.count, sizeof *s.queue);
    s.layer = (uint8_t *)envlt__alloc(a, coarse.count);
    s.sample = (uint32_t *)envlt__alloc_array(a, k, sizeof *s.sample);
    s.blocks = (envlt__block *)envlt__alloc_array(a, s.block_count, sizeof *s.blocks);
    if (s.best && s.label && s.owner && s.queue && s.layer && s.sample && s.blocks) {
        envlt__run_structured(&s);
        for (y = 0; y < g->height * g->faces; y++) {
            const uint32_t *row = s.label + envlt__coarse_row(g, &coarse, factor, y);
            for (x = 0, left = factor; x < g->width; x++) {
                label[t++] = *row;
                if (--left) continue;
                left = factor;
                row++;
            }
        }
        result = ENVLT_OK;
    }
    envlt__free(a, s.blocks);
    envlt__free(a, s.sample);
    envlt__free(a, s.layer);
    envlt__free(a, s.queue);
    envlt__free(a, s.owner);
    envlt__free(a, s.label);
    envlt__free(a, s.best);
    envlt__free(a, coarse.memory);
    return result;
}
