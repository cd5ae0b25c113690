/* ---- query: one tile through the way that suits it ---- */

/* Answers for a tile whose samples have one light: each pixel is decoded once. */
static void cohsm__run_one_light(cohsm__tile *t, const cohsm__kernels *kernels)
{
    cohsm__stream s;
    uint32_t cell;

    if (!cohsm__cell_of_light(t->maps, t->light_kind, cohsm__tile_light(t, 0), t->cell[0], &cell)) return;
    cohsm__stream_make(&s, t->maps, cell, t->query->bias, &t->work.kept);
    s.count = t->count;
    s.x = t->point[0];
    s.y = t->point[1];
    s.z = t->point[2];
    s.key = (int32_t *)t->pixel;
    s.depth = t->depth;
    s.list = t->place;
    kernels->one_light(&s, t->visible);
}

#ifndef COHSM_WITHOUT_SIMD
/* Does what cohsm__pcf does for the whole tile; sums are taken in the same order. */
static void cohsm__run_pcf(cohsm__tile *t, const cohsm__kernels *kernels)
{
    float (*const weight)[COHSM__TILE] = t->work.fractions.weight, dark[COHSM__TILE], map[COHSM__TILE];
    uint32_t corner, pixel;
    size_t i;

    memset(dark, 0, sizeof dark);
    kernels->cells(t);
    for (corner = 0; corner < 4; corner++) {
        kernels->project(t, corner);
        memset(map, 0, sizeof map);
        for (pixel = 0; pixel < 4; pixel++) {
            for (i = 0; i < t->count; i++) t->visible[i] = 1.0f;
            kernels->corner(t, pixel);
            kernels->search(t);
            for (i = 0; i < t->count; i++)
                map[i] += (pixel & 1u ? weight[2][i] : 1.0f - weight[2][i]) *
                          (pixel >> 1 ? weight[3][i] : 1.0f - weight[3][i]) * (1.0f - t->visible[i]);
        }
        for (i = 0; i < t->count; i++)
            dark[i] += (corner & 1u ? weight[0][i] : 1.0f - weight[0][i]) *
                       (corner >> 1 ? weight[1][i] : 1.0f - weight[1][i]) * map[i];
    }
    for (i = 0; i < t->count; i++) t->visible[i] = cohsm__lit_from_dark(dark[i]);
}
#endif

/* Answers for a tile in steps; returns 0 if the samples are of a kind that is treated one by one. */
static int cohsm__answer_in_steps(cohsm__tile *t, const cohsm__kernels *kernels)
{
    const cohsm_maps *m = t->maps;
    int shared = t->one_light && t->query->filter == COHSM_FILTER_NEAREST;
    size_t i;

#ifdef COHSM_WITHOUT_SIMD
    if (t->query->filter == COHSM_FILTER_PCF) return 0;
#endif
    if (!shared && (t->light_kind != COHSM_LIGHT_DIRECTION || m->head.domain != COHSM_DOMAIN_LATLONG))
        return 0;
    for (i = t->count; i % COHSM__STEP; i++) {      /* the last step is filled up with points of no use */
        t->point[0][i] = t->point[1][i] = t->point[2][i] = 0.0f;
        t->id[i] = 0;
    }
    for (i = t->one_light ? 0 : t->count; !shared && (i < t->count || i % COHSM__STEP); i++) {
        t->light[0][i] = t->light[0][0];
        t->light[1][i] = t->light[1][0];
        t->light[2][i] = t->light[2][0];
    }
#ifndef COHSM_WITHOUT_SIMD
    if (t->query->filter == COHSM_FILTER_PCF) {
        cohsm__run_pcf(t, kernels);
        return 1;
    }
#endif
    if (shared) cohsm__run_one_light(t, kernels);
    else {
        kernels->address(t);
        kernels->search(t);
    }
    return 1;
}

/* Turns a tile's lights from positions into directions, for which the same maps answer. A sample with
   nothing between it and its light gets a direction of length 0, which counts as lit; one that is to be
   refused, since the light lies inside the hull, also a bit. */
static void cohsm__aim_tile(cohsm__tile *t, uint32_t *refused)
{
    const cohsm__v3 first = cohsm__tile_light(t, 0);
    size_t i;

    for (i = 0; i < t->count; i++) {
        const cohsm__v3 l = t->one_light ? first : cohsm__tile_light(t, i), p = cohsm__tile_point(t, i);
        cohsm__v3 to = cohsm__v3_make(0.0f, 0.0f, 0.0f);
        if (cohsm__v3_finite(l)) {
            if (cohsm__light_refused(t->maps, l)) refused[i / 32] |= 1u << i % 32;
            else if (cohsm__hull_between(t->maps, p, l)) to = cohsm__v3_sub(l, p);
        }
        t->light[0][i] = to.x;
        t->light[1][i] = to.y;
        t->light[2][i] = to.z;
    }
    t->light_kind = COHSM_LIGHT_DIRECTION;
    t->one_light = 0;
}

static void cohsm__answer(cohsm__tile *t)
{
    const cohsm__kernels kernels = cohsm__choose_kernels(t->maps->simd);
    size_t i;
    for (i = 0; i < t->count; i++) t->visible[i] = 1.0f;
    if (cohsm__answer_in_steps(t, &kernels)) return;
    for (i = 0; i < t->count; i++) {
        t->pixel[i] = COHSM__NO_PIXEL;
        t->place[i] = 0;
        t->depth[i] = 0;
        cohsm__address(t, i);
    }
    if (t->query->filter != COHSM_FILTER_PCF) kernels.search(t);
}

static void cohsm__run_tile(cohsm__tile *t)
{
    uint32_t refused[COHSM__TILE / 32];
    size_t i;

    if (t->query->light_kind != COHSM_LIGHT_POSITION) {
        cohsm__answer(t);
        return;
    }
    memset(refused, 0, sizeof refused);
    cohsm__aim_tile(t, refused);
    cohsm__answer(t);
    for (i = 0; i < t->count; i++)
        if (refused[i / 32] >> i % 32 & 1u) t->visible[i] = COHSM_REFUSED;
    t->light_kind = COHSM_LIGHT_POSITION;
    t->one_light = t->query->one_light;
}
