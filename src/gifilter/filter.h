/* ---- filter: frames ---- */

/* Returns how many floats a row takes: the picture's width and a margin, but no multiple of 64, for rows that
   far apart push each other out of the cache. */
static inline size_t gifilt__row_floats(uint32_t width)
{
    size_t spacing = (size_t)width + GIFILT__MARGIN;
    return spacing + (spacing % 64u ? 0u : 16u);
}

/* Allocates the filter's memory, whose size the caller checked: two pictures, with a margin before the first
   row and after the last one, where lanes reach beyond it. If this fails, the caller frees what there is. */
static inline gifilt_result gifilt__take_memory(gifilt_filter *f, size_t floats, const gifilt__allocator *a)
{
    f->memory[0] = (float *)gifilt__alloc_array(a, floats, sizeof(float));
    f->memory[1] = (float *)gifilt__alloc_array(a, floats, sizeof(float));
    f->wrong_rows = (uint8_t *)gifilt__alloc_array(a, f->height, 1);
    if (!f->memory[0] || !f->memory[1] || !f->wrong_rows) return GIFILT_ERR_ALLOC;
    memset(f->memory[0], 0, floats * sizeof(float));
    memset(f->memory[1], 0, floats * sizeof(float));
    f->history = f->memory[0] + GIFILT__MARGIN;
    f->next = f->memory[1] + GIFILT__MARGIN;
    return GIFILT_OK;
}

GIFILT_DEF gifilt_result gifilt_create(const gifilt_desc *desc, gifilt_filter **out)
{
    gifilt__logger log = gifilt__logger_of(desc ? &desc->system : NULL, "gifilt_create");
    gifilt__allocator a;
    gifilt_filter *f;
    size_t floats;
    if (!desc) return GIFILT_ERR_ARGUMENT;
    if (!out) return gifilt__refuse(&log, GIFILT_ERR_ARGUMENT, "out", "is NULL");
    if (!gifilt__check_range(&log, "desc.width", desc->width, 1, 65536, "1..65536")) return GIFILT_ERR_DESC;
    if (!gifilt__check_range(&log, "desc.height", desc->height, 1, 65536, "1..65536")) return GIFILT_ERR_DESC;
    if (!gifilt__system_valid(&log, &desc->system)) return GIFILT_ERR_DESC;
    if (!gifilt__mul_size(gifilt__row_floats(desc->width) * GIFILT__PLANES, desc->height, &floats) ||
        !gifilt__add_size(floats, 2 * GIFILT__MARGIN, &floats) || floats > SIZE_MAX / sizeof(float)) {
        gifilt__log_value(&log, "desc.width x desc.height", (double)desc->width * (double)desc->height,
                          "less: the filter's memory does not fit a size_t");
        return GIFILT_ERR_LIMIT;
    }
    a = gifilt__allocator_of(&desc->system);
    f = (gifilt_filter *)gifilt__alloc(&a, sizeof *f);
    if (!f) return gifilt__refuse(&log, GIFILT_ERR_ALLOC, "desc.system.allocator", "returned no memory");
    memset(f, 0, sizeof *f);
    f->system = desc->system;
    f->width = desc->width;
    f->height = desc->height;
    f->spacing = gifilt__row_floats(desc->width);
    if (gifilt__take_memory(f, floats, &a) != GIFILT_OK) {
        gifilt_free(f);
        return gifilt__refuse(&log, GIFILT_ERR_ALLOC, "desc.system.allocator", "returned no memory");
    }
    *out = f;
    return GIFILT_OK;
}

GIFILT_DEF void gifilt_free(gifilt_filter *filter)
{
    gifilt__allocator a;
    if (!filter) return;
    a = gifilt__allocator_of(&filter->system);
    gifilt__free(&a, filter->wrong_rows);
    gifilt__free(&a, filter->memory[1]);
    gifilt__free(&a, filter->memory[0]);
    gifilt__free(&a, filter);
}

GIFILT_DEF void gifilt_reset(gifilt_filter *filter)
{
    size_t y;
    if (!filter) return;
    for (y = 0; y < filter->height; y++)
        memset(filter->history + (y * GIFILT__PLANES + GIFILT__FRAMES) * filter->spacing, 0,
               filter->width * sizeof *filter->history);
    filter->has_matrix = 0;
}

/* Writes a row that no pass has filtered: three floats a pixel, from three rows of floats. */
static inline void gifilt__pack(const gifilt__filter_run *r, size_t y)
{
    size_t x, c, width = r->filter->width;
    for (x = 0; x < width; x++)
        for (c = 0; c < 3; c++)
            r->out[3 * (y * width + x) + c] = r->in[y * r->in_row + c * r->filter->spacing + x];
}

/* Filters the rows of one task. They are neighbours, so that the rows above were mostly fetched by the same
   thread. */
static inline void gifilt__filter_band(void *context, size_t band)
{
    const gifilt__filter_run *r = (const gifilt__filter_run *)context;
    size_t y, end = (band + 1) * GIFILT__TASK_ROWS;
    for (y = band * GIFILT__TASK_ROWS; y < end && y < r->filter->height; y++) r->row(r, y);
}

static inline void gifilt__filter_rows(gifilt__filter_run *r, gifilt__filter_row row)
{
    r->row = row;
    gifilt__run(&r->filter->system, (r->filter->height + GIFILT__TASK_ROWS - 1) / GIFILT__TASK_ROWS,
                gifilt__filter_band, r);
}

/* Takes the passes from f->next to out. Passes between the first and the last write over the last frame,
   which nothing asks for any more: over its positions and its normals in turn. */
static inline void gifilt__filter_passes(gifilt__filter_run *r, float *out)
{
    gifilt_filter *f = r->filter;
    const uint32_t passes = r->frame->passes == 0  ? 2u
                            : r->frame->passes < 0 ? 0u
                                                   : (uint32_t)r->frame->passes;
    uint32_t pass;
    r->in = f->next + GIFILT__RGB * f->spacing;
    r->in_row = GIFILT__PLANES * f->spacing;
    r->out = out;
    if (passes == 0) gifilt__filter_rows(r, gifilt__pack);
    for (pass = 0; pass < passes; pass++) {
        r->packed = pass + 1 == passes;
        r->out = r->packed ? out : f->history + (pass % 2 ? 3 * f->spacing : 0);
        r->out_row = r->packed ? 3 * (size_t)f->width : GIFILT__PLANES * f->spacing;
        r->step = 1u << pass;
        gifilt__filter_rows(r, r->smooth);
        r->in = r->out;
    }
}

/* Writes this frame into f->next, mixed with what the last frames knew. Returns 0 if a normal is not unit;
   the frames before are then as they were. */
static inline int gifilt__filter_recall(gifilt__filter_run *r)
{
    const gifilt_filter *f = r->filter;
    const gifilt_frame *d = r->frame;
    size_t y;
    r->history = d->history ? d->history : 8;
    r->recalls = r->history > 1 && (d->motion || (d->world_to_clip && f->has_matrix));
    r->limits[0] = d->normal_cosine > 0.0f ? d->normal_cosine : 0.9f;
    r->limits[1] = 1.0f / (1.0f - r->limits[0]);
    r->limits[2] = d->plane_slope > 0.0f ? d->plane_slope * d->plane_slope : 0.1f * 0.1f;
    gifilt__filter_rows(r, r->accumulate);
    for (y = 0; y < f->height; y++)
        if (f->wrong_rows[y]) return 0;
    return 1;
}

/* Filters one frame, of a run that has its filter, its inputs and its kernels. Returns 0, and changes
   nothing, if a normal is not unit. */
static inline int gifilt__filter_frame(gifilt__filter_run *r, float *out)
{
    gifilt_filter *f = r->filter;
    const gifilt_frame *d = r->frame;
    float *swap;
    if (!gifilt__filter_recall(r)) return 0;
    gifilt__filter_passes(r, out);
    swap = f->history;
    f->history = f->next;
    f->next = swap;
    f->has_matrix = d->world_to_clip != NULL;
    if (d->world_to_clip) memcpy(f->matrix, d->world_to_clip, sizeof f->matrix);
    return 1;
}

static inline int gifilt__frame_valid(const gifilt__logger *log, const gifilt_frame *d)
{
    int i;
    if (!gifilt__check_range(log, "frame.rows", (double)d->rows, 0, GIFILT_ROWS_COUNT - 1,
                             "a value of gifilt_rows"))
        return 0;
    if (!gifilt__check_range(log, "frame.history", d->history, 0, 1000, "0..1000")) return 0;
    if (!gifilt__check_range(log, "frame.passes", d->passes, -1e9, 6, "at most 6")) return 0;
    if (!gifilt__check_range(log, "frame.normal_cosine", (double)d->normal_cosine, 0, 0.99999994,
                             "0 or more, below 1"))
        return 0;
    if (!gifilt__check_range(log, "frame.plane_slope", (double)d->plane_slope, 0, 1e6, "0..1e6")) return 0;
    for (i = 0; i < 16 && d->world_to_clip; i++)
        if (!gifilt__finite(d->world_to_clip[i])) {
            gifilt__log_element(log, "frame.world_to_clip", (uint64_t)i, "is",
                                (double)d->world_to_clip[i], "finite");
            return 0;
        }
    return 1;
}

/* Logs the first normal that is not unit, for a call that returns the result. */
static inline gifilt_result gifilt__refuse_normals(const gifilt__logger *log, const gifilt_points *p)
{
    size_t i, stride = gifilt__stride(p->normal_stride, 12) / 4;
    for (i = 0; i < p->count; i++) {
        gifilt__v3 n = gifilt__v3_load(p->normals + i * stride);
        float length2 = gifilt__v3_dot(n, n);
        if (!(length2 <= GIFILT__MAX_FLOAT) || gifilt__is_unit2(length2)) continue;
        if (n.x == 0.0f && n.y == 0.0f && n.z == 0.0f) continue;
        gifilt__log_element(log, "points.normals", i, "has the length", (double)gifilt__v3_length(n),
                            "1 (0.97..1.03), or 0");
        break;
    }
    return GIFILT_ERR_INPUT;
}

GIFILT_DEF gifilt_result gifilt_apply(gifilt_filter *filter, const gifilt_frame *frame,
                                      const gifilt_points *points, const float *light, float *out)
{
    gifilt__logger log = gifilt__logger_of(filter ? &filter->system : NULL, "gifilt_apply");
    gifilt__filter_run r;
    gifilt_frame none;
    memset(&none, 0, sizeof none);
    memset(&r, 0, sizeof r);
    if (!filter) return GIFILT_ERR_ARGUMENT;
    if (!light || !out) return gifilt__refuse(&log, GIFILT_ERR_ARGUMENT, light ? "out" : "light", "is NULL");
    if (!gifilt__points_valid(&log, points)) return GIFILT_ERR_ARGUMENT;
    if (points->count != (size_t)filter->width * filter->height) {
        gifilt__log_value(&log, "points.count", (double)points->count, "the filter's width x height");
        return GIFILT_ERR_MISMATCH;
    }
    r.frame = frame ? frame : &none;
    if (!gifilt__frame_valid(&log, r.frame)) return GIFILT_ERR_DESC;
    r.filter = filter;
    r.points = points;
    r.in = light;
    gifilt__choose_filter(&r);
    return gifilt__filter_frame(&r, out) ? GIFILT_OK : gifilt__refuse_normals(&log, points);
}
