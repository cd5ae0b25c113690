/* ---- maps: the atlas and its views ---- */

#define ENVSH__CELL 8u              /* texels a side of a cell, whose least and greatest depth are kept */
#define ENVSH__NOTHING 1.0f         /* the depth of a texel without a caster */

struct envsh_maps {
    envsh__allocator allocator;
    envsh_system system;
    float        told, span;        /* the next steps go from the fraction told to told + span */
    uint32_t     map_side, guard, capacity, channels;
    uint32_t     across, down, pages;   /* tiles side by side, rows of tiles on a page, pages */
    uint32_t     cells;             /* cells a side of a tile */
    int          no_depth;
    envsh_rows       rows;
    envsh_clip_depth clip_depth;
    int          phase;             /* 0: no frame was begun; 1: it is being drawn; 2: it can be shaded with
                                       */
    uint32_t     count;             /* lights of the last envsh_maps_begin */
    envsh_view  *views;
    float       *depth;
    float       *bounds;            /* least and greatest depth of each cell, cells x cells x 2 a tile */
    size_t       bytes;             /* of all memory of the maps */
};

/* Runs count tasks, by the caller's parallel_for if there is one. */
static void envsh__for_each(const envsh_system *s, size_t count, envsh_task task, void *context)
{
    size_t i;
    if (s->parallel_for && count > 1) s->parallel_for(s->user, count, task, context);
    else
        for (i = 0; i < count; i++) task(context, i);
}

/* Tells the caller's progress that `part` of the next steps is done, and returns whether the caller cancels.
   */
static int envsh__tell_progress(const envsh_maps *m, float part)
{
    return m->system.progress && m->system.progress(m->system.user, m->told + m->span * part) != 0;
}

/* Runs count tasks in 16 steps, between which the caller may cancel; in one step if there is no progress. */
static envsh_result envsh__run_steps(const envsh_maps *m, size_t count, envsh_task task, void *context)
{
    size_t step, steps = m->system.progress ? 16 : 1;
    envsh__batch batch;
    batch.task = task;
    batch.context = context;
    batch.first = 0;
    for (step = 0; step < steps; step++) {
        size_t next = count / steps * (step + 1) + count % steps * (step + 1) / steps;
        if (envsh__tell_progress(m, (float)step / (float)steps)) return ENVSH_ERR_CANCELLED;
        envsh__for_each(&m->system, next - batch.first, envsh__batch_task, &batch);
        batch.first = next;
    }
    return envsh__tell_progress(m, 1.0f) ? ENVSH_ERR_CANCELLED : ENVSH_OK;
}

/* Fills in the defaults of a desc, and checks its fields. */
static envsh_result envsh__check_maps_desc(envsh_maps_desc *d, const envsh__logger *log)
{
    const envsh_result bad = ENVSH_ERR_DESC;
    if (!d->map_side) d->map_side = 256;
    if (!d->guard) d->guard = 4;
    if (!d->max_side) d->max_side = d->map_side > 8192 ? d->map_side : 8192;
    if (d->map_side < 16 || d->map_side > 4096)
        return envsh__refuse(log, "desc.map_side", d->map_side, "0 (= 256) or 16..4096", bad);
    if (d->guard > d->map_side / 4)
        return envsh__refuse(log, "desc.guard", d->guard, "0 (= 4) or 1..map_side / 4", bad);
    if (d->max_side < d->map_side || d->max_side > 32768)
        return envsh__refuse(log, "desc.max_side", d->max_side, "0 (= 8192) or map_side..32768", bad);
    if ((unsigned)d->rows >= ENVSH_ROWS_COUNT)
        return envsh__refuse(log, "desc.rows", d->rows, "one of envsh_rows", bad);
    if ((unsigned)d->clip_depth >= ENVSH_CLIP_DEPTH_COUNT)
        return envsh__refuse(log, "desc.clip_depth", d->clip_depth, "one of envsh_clip_depth", bad);
    if (!envsh__allocator_valid(d->system.allocator.alloc_fn, d->system.allocator.free_fn))
        return envsh__refuse_text(log, "desc.system.allocator", "has one of its two functions", bad);
    return ENVSH_OK;
}

/* Lays tiles out side by side on pages that are as square as may be and at most max_side wide and high. */
static void envsh__lay_out_tiles(envsh_maps *m, uint32_t max_side)
{
    uint32_t slots = (m->capacity + m->channels - 1) / m->channels, most = max_side / m->map_side, side = 1;
    while (side < most && side * side < slots) side++;
    m->across = slots < side ? slots : side;
    m->down = m->across ? (slots + m->across - 1) / m->across : 0;
    m->down = m->down < most ? m->down : most;
    m->pages = m->across ? (slots + m->across * m->down - 1) / (m->across * m->down) : 0;
}

ENVSH_DEF envsh_result envsh_maps_create(const envsh_maps_desc *desc, uint32_t capacity, envsh_maps **out)
{
    const envsh_allocator *own;
    envsh__allocator a;
    envsh__logger logger;
    envsh_maps_desc d;
    envsh_maps *m;
    envsh_result result;
    size_t texels = 0, cells = 0;
    memset(&d, 0, sizeof d);
    if (desc) d = *desc;
    logger = envsh__make_logger(&d.system, "envsh_maps_create");
    if (!out) return envsh__refuse_text(&logger, "out", "is NULL", ENVSH_ERR_ARGUMENT);
    if (capacity > ENVSH_MAX_LIGHTS)
        return envsh__refuse(&logger, "capacity", capacity, "0..8192", ENVSH_ERR_ARGUMENT);
    result = envsh__check_maps_desc(&d, &logger);
    if (result != ENVSH_OK) return result;
    own = &d.system.allocator;
    a = envsh__allocator_make(own->alloc_fn, own->free_fn, own->user);
    m = (envsh_maps *)envsh__alloc(&a, sizeof *m);
    if (!m) return envsh__refuse_text(&logger, "system.allocator", "returned no memory", ENVSH_ERR_ALLOC);
    memset(m, 0, sizeof *m);
    m->allocator = a;
    m->system = d.system;
    m->span = 1.0f;
    m->map_side = d.map_side;
    m->guard = d.guard;
    m->capacity = capacity;
    m->channels = d.rgba ? 4 : 1;
    m->no_depth = d.no_depth;
    m->rows = d.rows;
    m->clip_depth = d.clip_depth;
    m->cells = (d.map_side + ENVSH__CELL - 1) / ENVSH__CELL;
    envsh__lay_out_tiles(m, d.max_side);
    if (!envsh__mul_size((size_t)m->across * m->map_side, (size_t)m->down * m->map_side, &texels) ||
        !envsh__mul_size(texels, (size_t)m->pages * m->channels, &texels) || texels > SIZE_MAX / 16)
        result = envsh__refuse(&logger, "capacity", capacity, "less: size_t cannot count the texels",
                               ENVSH_ERR_LIMIT);
    cells = (size_t)m->cells * m->cells * 2 * capacity;
    if (result == ENVSH_OK && capacity) {
        m->views = (envsh_view *)envsh__alloc_array(&a, capacity, sizeof *m->views);
        if (!m->no_depth) m->depth = (float *)envsh__alloc_array(&a, texels, sizeof *m->depth);
        if (!m->no_depth) m->bounds = (float *)envsh__alloc_array(&a, cells, sizeof *m->bounds);
        if (!m->views || (!m->no_depth && (!m->depth || !m->bounds)))
            result = envsh__refuse_text(&logger, "system.allocator", "returned no memory", ENVSH_ERR_ALLOC);
    }
    m->bytes = sizeof *m + capacity * sizeof *m->views + (m->no_depth ? 0 : 4 * (texels + cells));
    if (result != ENVSH_OK) {
        envsh_maps_free(m);
        return result;
    }
    for (cells = 0; m->depth && cells < texels; cells++) m->depth[cells] = ENVSH__NOTHING;
    *out = m;
    return ENVSH_OK;
}

ENVSH_DEF void envsh_maps_free(envsh_maps *m)
{
    envsh__allocator a;
    if (!m) return;
    a = m->allocator;
    envsh__free(&a, m->bounds);
    envsh__free(&a, m->depth);
    envsh__free(&a, m->views);
    envsh__free(&a, m);
}

ENVSH_DEF void envsh_get_info(const envsh_maps *m, envsh_info *out)
{
    if (!m || !out) return;
    out->width = m->across * m->map_side;
    out->height = m->down * m->map_side;
    out->page_count = m->pages;
    out->channel_count = m->channels;
    out->map_side = m->map_side;
    out->guard = m->guard;
    out->capacity = m->capacity;
    out->depth = m->depth;
    out->bytes = m->bytes;
}

ENVSH_DEF const envsh_view *envsh_views(const envsh_maps *m, uint32_t *count)
{
    if (count) *count = m ? m->count : 0;
    return m ? m->views : NULL;
}

/* Returns the corner texel of a light's tile, and writes how many floats lie from one row to the next. The
   texels of a row lie m->channels floats apart. */
static float *envsh__tile_texels(const envsh_maps *m, uint32_t i, size_t *row)
{
    const envsh_view *v = &m->views[i];
    *row = (size_t)m->across * m->map_side * m->channels;
    return m->depth + ((size_t)v->page * m->down * m->map_side + v->y) * *row + (size_t)v->x * m->channels +
           v->channel;
}
