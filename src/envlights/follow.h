/* ---- follow: the next map, or another k, with strata that stay ---- */

typedef struct envlt__follow {
    envlt_lights      *l;
    const envlt__grid *g;
    uint32_t *label;                /* the stratum of each texel of the grid */
    uint32_t *partner;              /* the stratum that each stratum would merge with */
    double   *cost, *gain;          /* the importance that merging a stratum adds, and that splitting it takes
                                       away */
    uint8_t  *touched;              /* not 0: this stratum was changed in this round */
    uint32_t *queue;                /* queue and seen are scratch of the search for the sun; NULL without
                                       split_sun */
    uint8_t  *seen;
    envlt_light *before;            /* the lights as they were */
    uint32_t  changed;              /* lights with a new id */
} envlt__follow;

/* Returns the greatest eigenvalue of a stratum's scatter and writes its eigenvector, found by multiplying a
   vector with the matrix 24 times. */
static double envlt__main_axis(const envlt__sums *s, envlt__v3 *axis)
{
    static const int at[3][3] = { { 0, 1, 2 }, { 1, 3, 4 }, { 2, 4, 5 } };
    double c[3][3], v[3] = { 1.0, 0.9, 0.8 }, length = 0.0;
    int i, j, step;
    for (i = 0; i < 3; i++)
        for (j = 0; j < 3; j++) c[i][j] = s->s[at[i][j]] - s->m[i] * s->m[j] / s->w;
    for (step = 0; step < 24; step++) {
        double u[3];
        for (i = 0; i < 3; i++) u[i] = c[i][0] * v[0] + c[i][1] * v[1] + c[i][2] * v[2];
        length = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
        if (!(length > 0.0)) break;
        for (i = 0; i < 3; i++) v[i] = u[i] / length;
    }
    *axis = envlt__v3_make((float)v[0], (float)v[1], (float)v[2]);
    return length;
}

/* A plane that cuts a stratum in two: through the stratum's mean, across its main axis. */
typedef struct envlt__plane { envlt__v3 axis; double mean; } envlt__plane;

static envlt__plane envlt__plane_across(const envlt__sums *s)
{
    envlt__plane p;
    envlt__main_axis(s, &p.axis);
    p.mean = (s->m[0] * (double)p.axis.x + s->m[1] * (double)p.axis.y + s->m[2] * (double)p.axis.z) / s->w;
    return p;
}

/* Returns whether texel t lies on the far side of the plane. */
static int envlt__is_beyond(const envlt__grid *g, const envlt__plane *p, uint32_t t)
{
    return (double)(g->dx[t] * p->axis.x) + (double)(g->dy[t] * p->axis.y) +
           (double)(g->dz[t] * p->axis.z) > p->mean;
}

/* Returns whether both sides of a stratum's cut have energy. The scatter does not tell: by rounding, even a
   single lit texel may have some. */
static int envlt__is_divisible(const envlt__follow *f, uint32_t which)
{
    envlt__plane p = envlt__plane_across(&f->l->sums[which]);
    uint32_t j, sides = 0;
    for (j = f->l->start[which]; j < f->l->start[which + 1] && sides != 3; j++)
        if (f->g->lum[f->l->order[j]] > 0.0f) sides |= envlt__is_beyond(f->g, &p, f->l->order[j]) ? 2u : 1u;
    return sides == 3;
}

/* Returns energy times the fourth root of the scatter per energy, the importance that envlt__best_cut ranks
   by. */
static double envlt__stratum_rank(double w, double scatter) { return sqrt(sqrt(w * w * w * scatter)); }

/* Finds for each stratum the importance that cutting it takes away, and the importance that merging it with
   its best partner adds, by Ward's criterion. The sun is neither cut nor merged. */
static void envlt__rate_strata(envlt__follow *f)
{
    const envlt_lights *l = f->l;
    uint32_t i, j, first = l->has_sun ? 1 : 0;
    envlt__v3 axis;
    for (i = 0; i < l->count; i++) {
        const envlt__sums *a = &l->sums[i];
        f->touched[i] = i < first;
        f->cost[i] = 1e300;
        f->partner[i] = i;
        /* Cutting an even spread in two leaves a quarter of the scatter along the axis. */
        f->gain[i] = a->texels > 1.5 && a->w > 0.0 && i >= first && envlt__is_divisible(f, i)
                   ? 0.75 * envlt__main_axis(a, &axis) : 0.0;
        f->gain[i] = envlt__stratum_rank(a->w, f->gain[i]);
        for (j = first; j < l->count && i >= first; j++) {
            const envlt__sums *b = &l->sums[j];
            double dx, dy, dz, ward;
            if (j == i) continue;
            if (!(a->w > 0.0) || !(b->w > 0.0)) {
                ward = 0.0;
                dx = a->o[0] / (a->omega + 1e-300) - b->o[0] / (b->omega + 1e-300);
                dy = a->o[1] / (a->omega + 1e-300) - b->o[1] / (b->omega + 1e-300);
                dz = a->o[2] / (a->omega + 1e-300) - b->o[2] / (b->omega + 1e-300);
                ward = 1e-30 * (dx * dx + dy * dy + dz * dz);
            } else {
                dx = a->m[0] / a->w - b->m[0] / b->w;
                dy = a->m[1] / a->w - b->m[1] / b->w;
                dz = a->m[2] / a->w - b->m[2] / b->w;
                ward = envlt__stratum_rank(a->w + b->w,
                                           a->w * b->w / (a->w + b->w) * (dx * dx + dy * dy + dz * dz));
            }
            if (ward < f->cost[i]) {
                f->cost[i] = ward;
                f->partner[i] = j;
            }
        }
    }
}

/* Returns the stratum that gains most by a cut, or ENVLT_NO_LIGHT. */
static uint32_t envlt__pick_split(const envlt__follow *f)
{
    uint32_t i, best = ENVLT_NO_LIGHT;
    for (i = 0; i < f->l->count; i++)
        if (!f->touched[i] && f->gain[i] > 0.0 && (best == ENVLT_NO_LIGHT || f->gain[i] > f->gain[best]))
            best = i;
    return best;
}

/* Returns the stratum that loses least by a merge with its partner, or ENVLT_NO_LIGHT. */
static uint32_t envlt__pick_merge(const envlt__follow *f)
{
    uint32_t i, best = ENVLT_NO_LIGHT;
    for (i = 0; i < f->l->count; i++)
        if (!f->touched[i] && f->partner[i] != i && !f->touched[f->partner[i]] &&
            (best == ENVLT_NO_LIGHT || f->cost[i] < f->cost[best])) best = i;
    return best;
}

/* Gives the texels of a stratum that lie beyond its mean along its main axis to stratum `other`. */
static void envlt__split_stratum(envlt__follow *f, uint32_t which, uint32_t other)
{
    envlt__plane p = envlt__plane_across(&f->l->sums[which]);
    uint32_t j;
    for (j = f->l->start[which]; j < f->l->start[which + 1]; j++)
        if (envlt__is_beyond(f->g, &p, f->l->order[j])) f->label[f->l->order[j]] = other;
    f->touched[which] = 1;
}

/* Gives the texels of the fainter stratum of the pair to the brighter one, and returns the number of the
   fainter, which is free then. */
static uint32_t envlt__merge_strata(envlt__follow *f, uint32_t a)
{
    envlt_lights *l = f->l;
    uint32_t b = f->partner[a], keep = l->sums[a].w >= l->sums[b].w ? a : b, gone = keep == a ? b : a, j;
    for (j = l->start[gone]; j < l->start[gone + 1]; j++) f->label[l->order[j]] = keep;
    f->touched[a] = f->touched[b] = 1;
    return gone;
}

/* Moves a light and its texels from one number to another. */
static void envlt__move_label(envlt__follow *f, uint32_t from, uint32_t to)
{
    envlt_lights *l = f->l;
    size_t t;
    for (t = 0; t < f->g->count; t++)
        if (f->label[t] == from) f->label[t] = to;
    l->list[to] = l->list[from];
}

/* Makes sums and lists of texels of the labels. */
static void envlt__sum_strata(envlt__follow *f)
{
    envlt__accumulate_sums(f->g, f->label, f->l->sums, f->l->count);
    envlt__sort_strata(f->l, f->g, f->label);
}

/* Does one round of splits or merges towards k lights. A stratum changes at most once a round, since its
   rating is old then. Returns 0 if nothing is left to do. */
static int envlt__change_count(envlt__follow *f, uint32_t k)
{
    envlt_lights *l = f->l;
    uint32_t which, n = l->count, gone_count = 0, i;
    if (n == k) return 0;
    envlt__rate_strata(f);
    if (n < k) {
        while (n < k && (which = envlt__pick_split(f)) != ENVLT_NO_LIGHT) {
            envlt__split_stratum(f, which, n);
            l->list[n++].id = l->next_id++;
            f->changed++;
        }
        if (n == l->count) return 0;
        l->count = n;
    } else {
        while (n - gone_count > k && (which = envlt__pick_merge(f)) != ENVLT_NO_LIGHT) {
            l->sums[envlt__merge_strata(f, which)].texels = -1.0;
            gone_count++;
        }
        if (!gone_count) return 0;
        for (i = 0; i < n; i++) {           /* the last light takes the empty place */
            while (n > i && l->sums[n - 1].texels < 0.0) n--;
            if (i >= n || !(l->sums[i].texels < 0.0)) continue;
            envlt__move_label(f, n - 1, i);
            n--;
        }
        l->count = n;
    }
    envlt__sum_strata(f);
    return 1;
}

/* Splits a stratum and merges a pair, as long as the split gains more than `ratio` times what the merge
   costs, for at most an eighth of the lights. */
static void envlt__rebalance_strata(envlt__follow *f, double ratio)
{
    uint32_t split, merge;
    uint32_t fresh = f->l->count / 8;
    uint32_t done = 0;
    uint32_t i;
    envlt__rate_strata(f);
    /* Strata whose texels the sun has all taken are free for halves of others. */
    for (i = 0; i < f->l->count; i++) {
        if (f->l->start[i] < f->l->start[i + 1]) continue;
        f->touched[i] = 1;
        split = envlt__pick_split(f);
        if (split == ENVLT_NO_LIGHT) break;
        envlt__split_stratum(f, split, i);
        f->l->list[i].id = f->l->next_id++;
        f->changed++;
        done = 1;
    }
    for (; fresh > 0; fresh--) {
        split = envlt__pick_split(f);
        if (split == ENVLT_NO_LIGHT) break;
        f->touched[split] = 1;              /* the stratum to split must not be one of the pair to merge */
        merge = envlt__pick_merge(f);
        if (merge == ENVLT_NO_LIGHT || !(f->gain[split] > ratio * f->cost[merge])) break;
        merge = envlt__merge_strata(f, merge);
        envlt__split_stratum(f, split, merge);
        f->l->list[merge].id = f->l->next_id++;
        f->changed++;
        done = 1;
    }
    if (done) envlt__sum_strata(f);
}

/* Returns the gain of the best split over the cost of the cheapest merge, at least 1. */
static double envlt__measure_unevenness(envlt__follow *f)
{
    uint32_t split, merge;
    envlt__rate_strata(f);
    split = envlt__pick_split(f);
    if (split == ENVLT_NO_LIGHT) return 1.0;
    f->touched[split] = 1;
    merge = envlt__pick_merge(f);
    if (merge == ENVLT_NO_LIGHT || !(f->gain[split] > f->cost[merge])) return 1.0;
    return f->cost[merge] > 1e-6 * f->gain[split] ? f->gain[split] / f->cost[merge] : 1e6;
}

/* Gives each texel of the sun's stratum to the other light that is nearest to the texel. */
static void envlt__leave_sun(envlt__follow *f)
{
    envlt_lights *l = f->l;
    const envlt__grid *g = f->g;
    uint32_t i, j;
    for (j = l->start[0]; j < l->start[1]; j++) {
        uint32_t t = l->order[j], nearest = 1;
        double best = -2.0;
        for (i = 1; i < l->count; i++) {
            const double *m = l->sums[i].w > 0.0 ? l->sums[i].m : l->sums[i].o;
            double c = (m[0] * (double)g->dx[t] + m[1] * (double)g->dy[t] + m[2] * (double)g->dz[t]) /
                       (sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]) + 1e-300);
            if (c > best) {
                best = c;
                nearest = i;
            }
        }
        f->label[t] = nearest;
    }
}

/* Moves the sun's stratum to where the sun is now. While there is no sun, the stratum stays where it was. A
   sun that comes up becomes light 0, and the light that was light 0 becomes the last one. */
static void envlt__follow_sun(envlt__follow *f)
{
    envlt_lights *l = f->l;
    uint32_t k = l->desc.light_count, size = envlt__find_sun(f->g, k, f->queue, f->seen), i;
    if (k < 2) l->has_sun = 0;
    if (!size || (l->has_sun && l->count < 2)) return;
    if (l->has_sun) {
        envlt__leave_sun(f);
    } else {
        size_t t;
        for (t = 0; t < f->g->count; t++)
            if (f->label[t] == 0) f->label[t] = l->count;
        l->list[l->count++] = l->list[0];
        l->list[0].id = l->next_id++;
        l->has_sun = 1;
        f->changed++;
    }
    for (i = 0; i < size; i++) f->label[f->queue[i]] = 0;
}

/* Brings the strata to the new map: labels, the sun, the count, then the balance. */
static void envlt__run_follow(envlt__follow *f, uint32_t k)
{
    envlt_lights *l = f->l;
    uint32_t x = 0;
    size_t t;
    if (!(l->slack > 0.0)) l->slack = envlt__measure_unevenness(f);
    for (t = 0; t < f->g->count; t++, x = x + 1 < f->g->width ? x + 1 : 0)
        f->label[t] = l->strata[envlt__map_texel(f->g, t - x, x)];
    if (l->desc.split_sun) envlt__follow_sun(f);
    envlt__sum_strata(f);
    while (envlt__change_count(f, k)) {}
    envlt__rebalance_strata(f, 2.0 * l->slack);
}

/* Measures the angles between lights of equal id, before and after, weighted by energy. */
static void envlt__measure_moves(const envlt_lights *l, const envlt_light *before, uint32_t count,
                                 envlt_stats *stats)
{
    uint32_t i, j;
    double sum = 0.0, weight = 0.0;
    for (i = 0; i < l->count; i++) {
        const envlt_light *a = &l->list[i];
        float angle;
        double w = (double)envlt__luminance(a->irradiance);
        for (j = 0; j < count && before[j].id != a->id; j++) {}
        if (j == count) continue;
        angle = 2.0f * envlt__asin(0.5f * envlt__v3_length(envlt__v3_sub(envlt__v3_load(a->direction),
                                                                       envlt__v3_load(before[j].direction))));
        if (angle > stats->largest_move) stats->largest_move = angle;
        sum += w * (double)angle;
        weight += w;
    }
    stats->mean_move = weight > 0.0 ? (float)(sum / weight) : 0.0f;
}

/* Builds all lights anew in place, after a map that was black or had too few lit texels for them. */
static envlt_result envlt__rebuild_lights(envlt_lights *l, const envlt_map *map, uint32_t k,
                                          envlt_stats *stats)
{
    envlt_lights *fresh, kept;
    envlt_desc d = l->desc;
    envlt_stats s;
    envlt_result result;
    uint32_t i;
    d.light_count = k;
    result = envlt__make_lights(&d, map, l->texels, &fresh, &s);
    if (result != ENVLT_OK) return result;
    kept = *l;
    *l = *fresh;
    *fresh = kept;
    l->allocator.user = &l->meter;
    fresh->allocator.user = &fresh->meter;
    for (i = 0; i < l->count; i++) l->list[i].id = kept.next_id + i;
    l->next_id = kept.next_id + l->count;
    envlt_free(fresh);
    s.changed = l->count;
    s.peak_bytes += kept.meter.now;         /* both are there at once */
    if (stats) *stats = s;
    return ENVLT_OK;
}

/* Allocates what a follow needs beside the grid, with room for `most` lights. Returns 0 if there is no
   memory; the caller calls envlt__close_follow in any case. */
static int envlt__open_follow(envlt__follow *f, uint32_t most)
{
    const envlt_lights *l = f->l;
    const size_t texels = l->texels;
    const envlt__allocator *a = &l->allocator;
    f->label = (uint32_t *)envlt__alloc_array(a, texels, sizeof *f->label);
    f->partner = (uint32_t *)envlt__alloc_array(a, most, sizeof *f->partner);
    f->cost = (double *)envlt__alloc_array(a, most, sizeof *f->cost);
    f->gain = (double *)envlt__alloc_array(a, most, sizeof *f->gain);
    f->touched = (uint8_t *)envlt__alloc(a, most);
    f->before = (envlt_light *)envlt__alloc_array(a, l->count, sizeof *f->before);
    if (l->desc.split_sun) {
        f->queue = (uint32_t *)envlt__alloc_array(a, texels, sizeof *f->queue);
        f->seen = (uint8_t *)envlt__alloc(a, texels);
    }
    if (!f->label || !f->partner || !f->cost || !f->gain || !f->touched || !f->before) return 0;
    return !l->desc.split_sun || (f->queue && f->seen);
}

static void envlt__close_follow(envlt__follow *f)
{
    const envlt__allocator *a = &f->l->allocator;
    envlt__free(a, f->seen);
    envlt__free(a, f->queue);
    envlt__free(a, f->before);
    envlt__free(a, f->touched);
    envlt__free(a, f->gain);
    envlt__free(a, f->cost);
    envlt__free(a, f->partner);
    envlt__free(a, f->label);
}

/* Returns whether an earlier map, nearly black, had too few lit texels for k lights, and this map has more.
   */
static int envlt__has_more_texels(const envlt__follow *f, uint32_t k)
{
    const envlt_lights *l = f->l;
    size_t lit;
    uint32_t sun;
    if (!l->lit || k <= l->count) return 0;
    lit = envlt__count_lit(f->g, NULL);
    sun = l->desc.split_sun ? envlt__find_sun(f->g, k, f->queue, f->seen) : 0;
    return lit - sun + (sun ? 1 : 0) > l->lit;
}

ENVLT_DEF envlt_result envlt_follow(envlt_lights *l, const envlt_map *map, uint32_t light_count,
                                    envlt_stats *stats)
{
    envlt__follow f;
    envlt__grid g;
    uint32_t k, asked, old, most;
    envlt__logger logger;
    envlt_result result;
    int anew;

    if (!l) return ENVLT_ERR_ARGUMENT;
    logger = envlt__make_logger(&l->desc.system, "envlt_follow");
    if (light_count > ENVLT_MAX_LIGHTS)
        return envlt__refuse(&logger, "light_count", light_count, "0 (as before) or 1..8192",
                             ENVLT_ERR_ARGUMENT);
    result = envlt__check_same(l, map, &logger);
    if (result != ENVLT_OK) return result;
    k = light_count ? light_count : l->count;
    asked = light_count || (l->count && !l->lit) ? k : l->desc.light_count;
    if (!l->count) return envlt__end_call(&logger, envlt__rebuild_lights(l, map, asked, stats));
    memset(&f, 0, sizeof f);
    memset(&g, 0, sizeof g);
    old = l->count;
    most = (k > old ? k : old) + 1;
    l->meter.peak = l->meter.now;
    f.l = l;
    f.g = &g;
    result = envlt__make_grid(&g, map, l->desc.hemisphere, l->roll, &l->allocator);
    if (!envlt__open_follow(&f, most)) result = ENVLT_ERR_ALLOC;
    anew = result == ENVLT_OK && envlt__has_more_texels(&f, asked);
    if (result == ENVLT_OK && !anew && !envlt__reserve_lights(l, most)) result = ENVLT_ERR_ALLOC;
    if (result == ENVLT_OK && !anew) {
        memcpy(f.before, l->list, old * sizeof *f.before);
        l->desc.light_count = asked;
        envlt__run_follow(&f, k);
        envlt__fill_lights(l, &g, NULL);
        envlt__fill_cdf(l, &g);
        if (stats) {
            envlt__fill_stats(l, &g, stats);
            stats->changed = f.changed;
            envlt__measure_moves(l, f.before, old, stats);
        }
    }
    envlt__close_follow(&f);
    envlt__free(&l->allocator, g.memory);
    if (anew) result = envlt__rebuild_lights(l, map, asked, stats);
    return envlt__end_call(&logger, result);
}
