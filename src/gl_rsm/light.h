/* ---- rsm: light: direct, gathered and interpolated ---- */

/* Returns which of the three pictures is neither a nor b. */
static uint32_t glbk__rsm_other(uint32_t a, uint32_t b)
{
    uint32_t i = 0;
    while (i == a || i == b) i++;
    return i;
}

GLBK_DEF glbk_result glbk_rsm_direct(glbk_context *ctx, glbk_rsm_renderer *r, const glbk_gbuffer *gbuffer,
                                     const glbk_rsm_map *const *maps, uint32_t count,
                                     const rsm_direct_desc *desc)
{
    uint32_t now = GLBK__RSM_NONE, next, i;
    rsm_direct_desc d;
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__rsm_gbuffer_check(ctx, __func__, r, gbuffer);
    if (result == GLBK_OK) result = glbk__rsm_maps_check(ctx, __func__, r, maps, count);
    if (result == GLBK_OK) result = glbk__rsm_direct_check(ctx, desc, &d);
    if (result != GLBK_OK) return result;
    memset(&r->values, 0, sizeof r->values);
    r->values.taps = d.tap_side;
    r->values.bias = d.bias;
    r->values.slope_bias = d.slope_bias;
    r->direct = GLBK__RSM_NONE;
    for (i = 0; i < count; i++) {
        next = glbk__rsm_other(r->bounce, now);
        r->values.adds = i > 0;
        result = glbk__rsm_begin(ctx, r, GLBK__RSM_DIRECT, &r->targets[next], r->width, r->height);
        if (result != GLBK_OK) return result;
        glbk__rsm_bind_all(ctx, r, gbuffer, maps[i]);
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_sum, &r->sums[now < 3 ? now : glbk__rsm_other(next, next)]);
        glbk_draw_screen(ctx);
        now = next;
    }
    r->direct = now;
    return GLBK_OK;
}

/* Does all steps of running sums along x, in all faces of a map: the first step by program `from`, the others
   by the program after that. *at gets the number of the target that holds the sums. */
static glbk_result glbk__rsm_scan(glbk_context *ctx, glbk_rsm_renderer *r, glbk_rsm_map *map, int from,
                                  uint32_t height, glbk_target targets[2][6], int *at)
{
    uint32_t stride, face;
    int next = 0;
    for (stride = 1; stride < map->side; stride *= 8) {
        for (face = 0; face < map->face_count; face++) {
            glbk_result result;
            r->values.face = face;
            r->values.stride = stride;
            result = glbk__rsm_begin(ctx, r, stride == 1 ? from : from + 1, &targets[next][face], map->side,
                                     height);
            if (result != GLBK_OK) return result;
            glbk__rsm_bind_map(ctx, map, NULL);
            if (stride == 1 && from == GLBK__RSM_SCAN) glbk_bind_texture(ctx, GLBK_SLOT_glbk_rsm_sums, NULL);
            glbk_draw_screen(ctx);
        }
        *at = next;
        next = 1 - next;
    }
    return GLBK_OK;
}

/* Makes running sums by compute, with a group for each row of all faces, then with a group for each face. */
static glbk_result glbk__rsm_do_sum(glbk_context *ctx, glbk_rsm_renderer *r, glbk_rsm_map *map)
{
    int rows;
    map->sums_at = map->rows_at = 0;
    for (rows = 0; rows < 2; rows++) {
        glbk_result result = glbk__rsm_ready(ctx, r, GLBK__RSM_DO_SCAN + rows);
        if (result != GLBK_OK) return result;
        glbk__rsm_bind_map(ctx, map, NULL);
        glbk_bind_image(ctx, GLBK_SLOT_glbk_rsm_running, rows ? &map->rows[0] : &map->sums[0]);
        result = glbk_dispatch(ctx, &r->programs[GLBK__RSM_DO_SCAN + rows], rows ? 1 : map->side,
                               map->face_count, 1);
        if (result != GLBK_OK) return result;
    }
    map->summed = 1;
    return GLBK_OK;
}

/* Makes the running sums of a map, unless the map has them. */
static glbk_result glbk__rsm_sum(glbk_context *ctx, glbk_rsm_renderer *r, glbk_rsm_map *map)
{
    glbk_result result;
    if (map->summed) return GLBK_OK;
    if (r->compute) return glbk__rsm_do_sum(ctx, r, map);
    result = glbk__rsm_scan(ctx, r, map, GLBK__RSM_SCAN, map->side, map->sum_targets, &map->sums_at);
    if (result == GLBK_OK)
        result = glbk__rsm_scan(ctx, r, map, GLBK__RSM_SCAN_ROWS, 1, map->row_targets, &map->rows_at);
    map->summed = result == GLBK_OK;
    return result;
}

typedef struct glbk__rsm_run {      /* a call of glbk_rsm_gather or glbk_rsm_interpolate */
    glbk_context        *ctx;
    glbk_rsm_renderer   *r;
    const glbk_gbuffer  *gbuffer;   /* NULL: only the list is made */
    glbk_rsm_map *const *maps;
    uint32_t             count;     /* number of maps */
    uint32_t             sets;      /* sets of pixels that have lights and points of their own */
    uint32_t             by_flux;   /* lights of a map that are picked by flux */
    uint32_t             about;     /* points of the pattern about the receiver */
    uint32_t             room;      /* lights of a set that the list holds */
    uint32_t             seed;
    int                  mixed;     /* not 0: RSM_PATTERN_MIXED */
    int                  all;       /* not 0: every texel is a light */
    int                  apart;     /* not 0: each map has a list of its own */
    int                  listed;    /* not 0: the list holds all lights */
    int                  begun;     /* not 0: the picture holds light */
    glbk_texture        *pictures;  /* the pictures in which light adds up */
    glbk_target         *targets;   /* of the pictures */
    uint32_t             width;     /* of the pictures */
    uint32_t             height;
    uint32_t             now;       /* the picture that holds the light */
    uint32_t             kept;      /* a picture that must stay */
    const glbk_texture  *states;    /* the state of each pixel while light is interpolated */
    const glbk_texture  *coarse;    /* the grid before */
    const glbk_buffer   *items;     /* compute: the pixels; NULL = all */
} glbk__rsm_run;

/* Picks lights of a map, from number `first` on, into places from .. to - 1 of each set of the list. */
static glbk_result glbk__rsm_pick(glbk__rsm_run *g, const glbk_rsm_map *map, uint32_t lights, uint32_t first,
                                  uint32_t from, uint32_t to)
{
    glbk_rsm_renderer *r = g->r;
    glbk_result result;
    uint32_t last = (g->sets - 1) * r->values.set_room + to, rows = (last + 1023) / 1024;
    r->values.first_light = from;
    r->values.end_light = to;
    r->values.seed = g->seed;
    r->values.light_count = lights;
    r->values.first_run = first;
    result = glbk__rsm_begin(g->ctx, r, g->all ? GLBK__RSM_PICK_ALL : GLBK__RSM_PICK, &r->lights_target, 1024,
                             rows);
    if (result != GLBK_OK) return result;
    glbk__rsm_bind_map(g->ctx, map, NULL);
    glbk_draw_screen(g->ctx);
    return GLBK_OK;
}

/* Runs as many groups as an earlier dispatch has counted: x, y, z of list `list` in r->counts. */
static glbk_result glbk__rsm_dispatch(glbk_context *ctx, const glbk_rsm_renderer *r, glbk_program *program,
                                      uint32_t list)
{
    if (ctx->lost) return GLBK_ERR_LOST;
    glbk_program_use(ctx, program);
    ctx->gl.BindBuffer(GLBK_GL_DISPATCH_INDIRECT_BUFFER, r->counts.name);
    ctx->gl.DispatchComputeIndirect((ptrdiff_t)16 * (ptrdiff_t)list);
    ctx->gl.Barrier(GLBK_GL_ALL_BARRIER_BITS);
    return GLBK_OK;
}

/* Does the work of glbk__rsm_add by compute, in place: on all pixels of the picture, or on those of a
   list. */
static glbk_result glbk__rsm_do_add(glbk__rsm_run *g, const glbk_rsm_map *map)
{
    glbk_rsm_renderer *r = g->r;
    int which = r->values.mode == 1 ? GLBK__RSM_DO_NODES : GLBK__RSM_DO_GATHER;
    glbk_program *program;
    uint32_t side = 8 * r->values.interleave;            /* pixels of a set lie `interleave` apart */
    glbk_result result;
    if (r->values.near_field > 0.0f) which += GLBK__RSM_DO_GATHER_SURFACES - GLBK__RSM_DO_GATHER;
    program = &r->programs[which];
    result = glbk__rsm_ready(g->ctx, r, which);
    if (result != GLBK_OK) return result;
    glbk__rsm_bind_all(g->ctx, r, g->gbuffer, map);
    glbk_bind_image(g->ctx, GLBK_SLOT_glbk_rsm_picture, &r->sums[g->now]);
    g->begun = 1;
    if (!g->items)
        return glbk_dispatch(g->ctx, program, (r->width + side - 1) / side, (r->height + side - 1) / side,
                             g->sets);
    glbk_bind_image(g->ctx, GLBK_SLOT_glbk_rsm_nodes, &r->grids[0]);
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_counts, &r->counts);
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_items, g->items);
    return glbk__rsm_dispatch(g->ctx, r, program, r->values.list_read);
}

/* Adds the first `listed` lights of each set and the points about the receiver to the picture. */
static glbk_result glbk__rsm_add(glbk__rsm_run *g, const glbk_rsm_map *map, uint32_t listed, uint32_t about)
{
    glbk_rsm_renderer *r = g->r;
    uint32_t next = glbk__rsm_other(g->kept, g->now);
    const glbk_texture *spare;
    const float side = (float)map->side, faces = map->face_count == 1 ? 1.0f : 0.5236f;
    glbk_result result;
    r->values.first_light = 0;
    r->values.end_light = listed;
    r->values.adds = (uint32_t)g->begun;
    r->values.point_count = about / g->sets;
    r->values.mixed = g->mixed ? (float)g->about * 0.02764f * faces / (side * side) : 0.0f;
    if (!g->gbuffer) return glbk__put_block(g->ctx, GLBK_SLOT_glbk_rsm_frame, &r->frame, &r->values);
    if (r->compute) return glbk__rsm_do_add(g, map);
    result = glbk__rsm_begin(g->ctx, r,
                             r->values.near_field > 0.0f ? GLBK__RSM_GATHER_SURFACES : GLBK__RSM_GATHER,
                             &g->targets[next], g->width, g->height);
    if (result != GLBK_OK) return result;
    glbk__rsm_bind_all(g->ctx, r, g->gbuffer, map);
    /* Every slot gets something of the right kind: software drivers compile a shader anew for each
       combination. */
    spare = &g->pictures[g->now < 3 ? g->now : glbk__rsm_other(next, next)];
    glbk_bind_texture(g->ctx, GLBK_SLOT_glbk_rsm_sum, spare);
    glbk_bind_texture(g->ctx, GLBK_SLOT_glbk_rsm_states, g->states ? g->states : spare);
    glbk_bind_texture(g->ctx, GLBK_SLOT_glbk_rsm_coarse, g->coarse ? g->coarse : spare);
    glbk_draw_screen(g->ctx);
    g->now = next;
    g->begun = 1;
    return GLBK_OK;
}

/* Adds the light of all maps to the pixels that r->values.mode names. The list takes as many lights as it has
   room for, and is made only once if it holds all of them. */
static glbk_result glbk__rsm_evaluate(glbk__rsm_run *g)
{
    uint32_t m, at = 0, flushed = 0;
    glbk_result result = GLBK_OK;
    g->begun = 0;
    for (m = 0; m < g->count && result == GLBK_OK; m++) {
        const glbk_rsm_map *map = g->maps[m];
        uint32_t lights = g->all ? map->side * map->side * map->face_count : g->by_flux;
        uint32_t left = lights / g->sets + (lights % g->sets != 0), first = 0;
        while (left && result == GLBK_OK) {
            uint32_t take = left < g->room - at ? left : g->room - at;
            if (!g->listed) result = glbk__rsm_pick(g, map, lights, first, at, at + take);
            at += take;
            first += take;
            left -= take;
            if (at < g->room || result != GLBK_OK || (g->about && !left)) continue;
            result = glbk__rsm_add(g, map, at, 0);
            at = 0;
            flushed++;
        }
        if ((g->about || (g->apart && at)) && result == GLBK_OK) {
            result = glbk__rsm_add(g, map, at, g->about);
            at = 0;
            flushed++;
        }
    }
    if (at && result == GLBK_OK) {
        result = glbk__rsm_add(g, g->maps[0], at, 0);
        flushed++;
    }
    g->listed = flushed == 1;
    return result;
}

/* Runs a compute shader of interpolation over all pixels, nodes or pending pixels. list points to the number
   of the list that tells how many groups run; if list is NULL, x by y groups run. */
static glbk_result glbk__rsm_do_lists(glbk__rsm_run *g, int which, uint32_t level, const uint32_t *list,
                                      uint32_t x, uint32_t y)
{
    glbk_rsm_renderer *r = g->r;
    glbk_result result = glbk__rsm_ready(g->ctx, r, which);
    if (result != GLBK_OK) return result;
    glbk__rsm_bind_all(g->ctx, r, g->gbuffer, NULL);
    glbk_bind_texture(g->ctx, GLBK_SLOT_glbk_rsm_coarse, &r->grids[0]);
    glbk_bind_image(g->ctx, GLBK_SLOT_glbk_rsm_picture, &r->sums[g->now]);
    glbk_bind_image(g->ctx, GLBK_SLOT_glbk_rsm_nodes, &r->grids[0]);
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_counts, &r->counts);
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_items, &r->pending[(level + 1) & 1]);
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_left, &r->pending[level & 1]);
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_wanted, &r->wanted);
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_marks, &r->marks);
    return list ? glbk__rsm_dispatch(g->ctx, r, &r->programs[which], *list)
                : glbk_dispatch(g->ctx, &r->programs[which], x, y, 1);
}

/* Begins interpolation by compute: empties the lists, says that no node of r->grids[0] is evaluated, and
   lists the nodes of the first grid. */
static glbk_result glbk__rsm_do_begin(glbk__rsm_run *g, const rsm_interpolation *d)
{
    static const uint32_t empty[4] = { 0, 0, 1, 0 };
    glbk_rsm_renderer *r = g->r;
    uint32_t counts[4 * GLBK__RSM_LISTS], i, fine = d->step, nodes[2];
    for (i = 1; i < d->level_count && fine > 2; i++) fine /= 2;
    for (i = 0; i < GLBK__RSM_LISTS; i++) memcpy(counts + 4 * i, empty, sizeof empty);
    nodes[0] = (r->width - 1 + fine - 1) / fine + 1;
    nodes[1] = (r->height - 1 + fine - 1) / fine + 1;
    r->values.step = d->step;
    r->values.fine_step = fine;
    r->values.list_wanted = 0;
    /* The upload goes through a binding that the pass changes anyway; glbk_buffer_update would ask GL which
       buffer is bound, so as to bind it again. */
    if (g->ctx->lost) return GLBK_ERR_LOST;
    glbk_bind_storage(g->ctx, GLBK_SLOT_glbk_rsm_counts, &r->counts);
    g->ctx->gl.BufferData(GLBK_GL_SHADER_STORAGE_BUFFER, (ptrdiff_t)r->counts.bytes, counts,
                          GLBK_GL_STREAM_DRAW);
    return glbk__rsm_do_lists(g, GLBK__RSM_DO_BEGIN, 0, NULL, (nodes[0] + 7) / 8, (nodes[1] + 7) / 8);
}

/* Does the work of glbk__rsm_grids by compute. List 2 level holds the nodes to evaluate, list 2 level + 1 the
   pixels that stay pending. All grids are in the finest one. The picture gets evaluated and interpolated
   light at once. */
static glbk_result glbk__rsm_do_grids(glbk__rsm_run *g, const rsm_interpolation *d)
{
    glbk_rsm_renderer *r = g->r;
    uint32_t step, level, before = 0;
    glbk_result result;
    g->now = glbk__rsm_other(r->direct, GLBK__RSM_NONE);
    result = glbk__rsm_do_begin(g, d);
    for (step = d->step, level = 0; step > 1 && level < d->level_count && result == GLBK_OK;
         step /= 2, level++) {
        r->values.mode = 1;
        r->values.list_read = 2 * level;
        g->items = &r->wanted;
        result = glbk__rsm_evaluate(g);
        if (result != GLBK_OK) return result;
        r->values.step = step;
        r->values.list_read = before;
        r->values.list_pending = 2 * level + 1;
        r->values.list_wanted = 2 * level + 2;
        r->values.next_step = level + 1 < d->level_count && step > 2 ? step / 2 : 0;
        result = glbk__rsm_do_lists(g, level ? GLBK__RSM_DO_LISTED : GLBK__RSM_DO_INTERPOLATE, level,
                                    level ? &before : NULL, (r->width + 15) / 16, (r->height + 15) / 16);
        before = 2 * level + 1;
    }
    r->values.mode = 2;
    r->values.list_read = before;
    g->items = &r->pending[before >> 1 & 1];
    return result;
}

/* Evaluates grids of half the step each time, and interpolates between their nodes. The caller evaluates the
   pixels that stay pending. The picture ends in r->sums. */
static glbk_result glbk__rsm_grids(glbk__rsm_run *g, const rsm_interpolation *d)
{
    glbk_rsm_renderer *r = g->r;
    uint32_t step = d->step, levels = d->level_count;
    uint32_t picture = GLBK__RSM_NONE, coarse = GLBK__RSM_NONE, next;
    glbk_result result;
    r->values.normal_cosine = d->normal_cosine;
    r->values.plane_slope = d->plane_slope;
    r->values.most_distance = d->distance;
    r->values.contrast = d->contrast;
    r->values.reach = d->light_share;
    if (r->compute) return glbk__rsm_do_grids(g, d);
    for (; step > 1 && levels > 0; step /= 2, levels--) {
        r->values.mode = 1;
        r->values.coarse_step = coarse < 3 ? r->values.step : 0;
        r->values.step = step;
        g->pictures = r->grids;
        g->targets = r->grid_targets;
        g->width = (r->width - 2 + step) / step + 1;
        g->height = (r->height - 2 + step) / step + 1;
        if (r->width == 1) g->width = 1;
        if (r->height == 1) g->height = 1;
        g->kept = coarse;
        g->now = GLBK__RSM_NONE;
        g->states = picture < 3 ? &r->sums[picture] : NULL;
        g->coarse = coarse < 3 ? &r->grids[coarse] : NULL;
        result = glbk__rsm_evaluate(g);
        if (result != GLBK_OK) return result;
        coarse = g->now;
        next = glbk__rsm_other(r->direct, picture);
        r->values.adds = picture < 3;
        result = glbk__rsm_begin(g->ctx, r, GLBK__RSM_INTERPOLATE, &r->targets[next], r->width, r->height);
        if (result != GLBK_OK) return result;
        glbk__rsm_bind_all(g->ctx, r, g->gbuffer, NULL);
        glbk_bind_texture(g->ctx, GLBK_SLOT_glbk_rsm_sum, picture < 3 ? &r->sums[picture] : NULL);
        glbk_bind_texture(g->ctx, GLBK_SLOT_glbk_rsm_coarse, &r->grids[coarse]);
        glbk_draw_screen(g->ctx);
        picture = next;
    }
    r->values.mode = 2;
    g->now = picture;
    return GLBK_OK;
}

/* Sets how many samples of each kind are taken for a checked desc, and how. */
static void glbk__rsm_run_set(glbk__rsm_run *g, const rsm_gather_desc *d)
{
    glbk_rsm_renderer *r = g->r;
    const int flux = d->pattern == RSM_PATTERN_FLUX;
    g->seed = d->seed;
    g->all = d->sample_count == 0;
    g->mixed = d->pattern == RSM_PATTERN_MIXED && d->sample_count > 1;
    g->apart = g->mixed || d->material_count > 0 || (g->all && d->near_field > 0.0f);
    g->about = glbk_rsm_point_count(d);
    if (!g->all && (flux || d->pattern == RSM_PATTERN_MIXED))
        g->by_flux = d->sample_count - (g->mixed ? 3 * d->sample_count / 5 : 0);
    g->sets = d->interleave * d->interleave;
    g->room = GLBK__RSM_LIST / g->sets < r->lights_per_pass ? GLBK__RSM_LIST / g->sets : r->lights_per_pass;
    memset(&r->values, 0, sizeof r->values);
    r->values.interleave = d->interleave;
    r->values.noise_side = d->noise && g->about ? r->noise_side : 0;
    r->values.set_room = g->room;
    r->values.material_count = d->material_count;
    r->values.width = r->width;
    r->values.height = r->height;
    r->values.r_max = g->mixed ? 0.0f : d->r_max;
    r->values.offset = d->offset;
    r->values.clamp_at = d->clamp;
    r->values.near_limit = d->near_limit;
    r->values.set_count = (float)g->sets;
    r->values.picked = g->mixed ? (float)g->by_flux : 0.0f;
    r->values.near_field = g->all || g->about ? d->near_field : 0.0f;
}

/* Gathers light for a checked desc. how is the interpolation with its defaults; if it is NULL, every pixel is
   evaluated. */
static glbk_result glbk__rsm_gather(glbk__rsm_run *g, const rsm_gather_desc *d, const rsm_interpolation *how)
{
    glbk_rsm_renderer *r = g->r;
    glbk_result result = GLBK_OK;
    uint32_t i;

    glbk__rsm_run_set(g, d);
    for (i = 0; i < g->count && (g->by_flux || g->mixed) && result == GLBK_OK; i++)
        result = glbk__rsm_sum(g->ctx, r, g->maps[i]);
    if (result != GLBK_OK) return result;
    r->bounce = g->now = GLBK__RSM_NONE;
    r->filtered = 0;
    if (how) result = glbk__rsm_grids(g, how);
    if (result != GLBK_OK) return result;
    g->pictures = r->sums;
    g->targets = r->targets;
    g->kept = r->direct;
    g->width = r->width;
    g->height = r->height;
    g->states = g->coarse = NULL;
    if (r->compute && !how) g->now = glbk__rsm_other(r->direct, GLBK__RSM_NONE);
    result = glbk__rsm_evaluate(g);
    if (result == GLBK_OK && g->gbuffer) r->bounce = g->now;
    return result;
}

/* Checks the arguments that both calls have, and writes the desc with its defaults. */
static glbk_result glbk__rsm_run_check(glbk__rsm_run *g, const char *function, const rsm_gather_desc *desc,
                                       rsm_gather_desc *out)
{
    glbk_result result;
    if (!g->ctx) return GLBK_ERR_ARGUMENT;
    result = g->gbuffer ? glbk__rsm_gbuffer_check(g->ctx, function, g->r, g->gbuffer) : GLBK_OK;
    if (result == GLBK_OK)
        result = glbk__rsm_maps_check(g->ctx, function, g->r, (const glbk_rsm_map *const *)g->maps, g->count);
    if (result == GLBK_OK) result = glbk__rsm_gather_check(g->ctx, function, desc, out);
    return result == GLBK_OK ? glbk__rsm_tables_check(g->ctx, function, g->r, out) : result;
}

/* Begins a run with the arguments that both calls have. */
static void glbk__rsm_run_make(glbk__rsm_run *g, glbk_context *ctx, glbk_rsm_renderer *r,
                               const glbk_gbuffer *gbuffer, glbk_rsm_map *const *maps, uint32_t count)
{
    memset(g, 0, sizeof *g);
    g->ctx = ctx;
    g->r = r;
    g->gbuffer = gbuffer;
    g->maps = maps;
    g->count = count;
}

GLBK_DEF glbk_result glbk_rsm_gather(glbk_context *ctx, glbk_rsm_renderer *r, const glbk_gbuffer *gbuffer,
                                     glbk_rsm_map *const *maps, uint32_t count, const rsm_gather_desc *desc)
{
    glbk__rsm_run g;
    rsm_gather_desc d;
    glbk_result result;

    glbk__rsm_run_make(&g, ctx, r, gbuffer, maps, count);
    result = glbk__rsm_run_check(&g, __func__, desc, &d);
    return result == GLBK_OK ? glbk__rsm_gather(&g, &d, NULL) : result;
}

GLBK_DEF glbk_result glbk_rsm_interpolate(glbk_context *ctx, glbk_rsm_renderer *r,
                                          const glbk_gbuffer *gbuffer, glbk_rsm_map *const *maps,
                                          uint32_t count, const rsm_gather_desc *desc,
                                          const rsm_interpolation *interpolation)
{
    glbk__rsm_run g;
    rsm_gather_desc d;
    rsm_interpolation how;
    glbk_result result;

    glbk__rsm_run_make(&g, ctx, r, gbuffer, maps, count);
    result = ctx ? glbk__rsm_gbuffer_check(ctx, __func__, r, gbuffer) : GLBK_ERR_ARGUMENT;
    if (result == GLBK_OK) result = glbk__rsm_run_check(&g, __func__, desc, &d);
    if (result == GLBK_OK) result = glbk__rsm_interpolation_check(ctx, interpolation, &how);
    if (result != GLBK_OK) return result;
    if (d.noise)
        return glbk__refuse(ctx, GLBK_ERR_DESC, __func__, "desc.noise",
                            "is not NULL: interpolated light has no noise");
    if (d.interleave != 1)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, __func__, "desc.interleave", d.interleave, "0 or 1");
    if (!r->grids[0].name)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "renderer",
                            "was made without desc.interpolate");
    return glbk__rsm_gather(&g, &d, &how);
}
