/* ---- build: from a mesh ---- */

/* The views of a trial, by face and cell, from which the next trial takes them in another order. */
typedef struct cohsm__shelf { uint16_t *z; int filled; } cohsm__shelf;
#define COHSM__SHELF_BYTES ((size_t)1 << 25)        /* larger trials draw their views for each order */

/* The views of a batch that are drawn together. */
typedef struct cohsm__group { uint32_t view[COHSM__ABREAST], count; } cohsm__group;

/* A batch of a Hilbert curve is eight columns of eight views, or 16 with threads: for each task a column. */
enum { COHSM__COLUMNS = (int)COHSM__BATCH / (int)COHSM__ABREAST };

typedef struct cohsm__job {
    cohsm_builder *builder;
    const cohsm__soup *soup;
    const cohsm__shelf *shelf;          /* NULL: none */
    cohsm__column *columns;             /* NULL: every view is drawn alone */
    uint32_t column_count;
    void *memory;                       /* where the columns lie, on whole cache lines */
    int simd;
    cohsm__camera cameras[COHSM__BATCH];
    cohsm__group groups[COHSM__BATCH];  /* no more than column_count of views that are drawn together */
    uint32_t group_count;
} cohsm__job;

/* Returns the shelf's place for a view of the batch, or NULL. */
static uint16_t *cohsm__on_shelf(const cohsm__job *job, uint32_t i)
{
    const cohsm_builder *b = job->builder;
    const uint32_t view = b->batch_begin + i, cell = b->cells[view % b->head.map_count];
    const size_t at = (size_t)(view / b->head.map_count) * b->head.map_count + cell;
    return job->shelf ? job->shelf->z + at * b->batch_size : NULL;
}

static cohsm__target cohsm__batch_target(const cohsm_builder *b, uint32_t i)
{
    const uint32_t m = b->head.map_side;
    cohsm__target target;
    target.z = b->batch + (size_t)i * b->batch_size;
    target.keep = b->keep;
    target.size = (int)m;
    target.row_begin = (int)(b->desc.pixel_begin / m);
    target.row_end = (int)((b->desc.pixel_end + m - 1u) / m);
    return target;
}

static void cohsm__raster_task(void *context, size_t index)
{
    const cohsm__job *job = (const cohsm__job *)context;
    const cohsm_builder *b = job->builder;
    const cohsm__group *group = job->groups + index;
    cohsm__camera cameras[COHSM__ABREAST];
    cohsm__target targets[COHSM__ABREAST];
    uint32_t i, p;

    for (i = 0; i < group->count; i++) {
        targets[i] = cohsm__batch_target(b, group->view[i]);
        cameras[i] = job->cameras[group->view[i]];
    }
    if (job->shelf && job->shelf->filled) {
        for (i = 0; i < group->count; i++)
            memcpy(targets[i].z, cohsm__on_shelf(job, group->view[i]), b->batch_size * sizeof *b->batch);
        return;
    }
    if (!job->columns) cohsm__raster_view(targets, cameras, job->soup, job->simd);
    else cohsm__raster_column(targets, cameras, group->count, job->soup, job->simd, job->columns + index);
    for (i = 0; i < group->count; i++) {
        if (b->desc.layers == COHSM_LAYERS_Z1Z3_SPHERE)
            for (p = b->desc.pixel_begin; p < b->desc.pixel_end; p++)
                targets[i].z[4 * (size_t)p + 3] = cohsm__leave_depth(cameras + i, b->head.map_side, p);
        if (job->shelf)
            memcpy(cohsm__on_shelf(job, group->view[i]), targets[i].z, b->batch_size * sizeof *b->batch);
    }
}

/* Says whether views are drawn together where they can be: those of directions, without masks. */
static int cohsm__draws_columns(const cohsm_builder *b, const cohsm__soup *soup)
{
    return !b->head.positional && !soup->masked;
}

/* Finds the group that a view of the batch joins, or makes one for it. Views of one axis to the right are
   together, as long as there is room for others to be apart. */
static cohsm__group *cohsm__group_of(cohsm__job *job, const cohsm__camera *cam)
{
    cohsm__group *space = NULL;
    uint32_t g, k;
    for (g = 0; job->columns && g < job->group_count; g++) {
        if (job->groups[g].count == COHSM__ABREAST) continue;
        if (!space) space = job->groups + g;
        for (k = 0; k < job->groups[g].count; k++)
            if (cohsm__right_is_same(job->cameras + job->groups[g].view[k], cam)) return job->groups + g;
    }
    if (space && job->group_count == job->column_count) return space;
    job->groups[job->group_count].count = 0;
    return job->groups + job->group_count++;
}

/* Adds a view to a group, behind one of the same axis to the right if there is one. */
static void cohsm__group_add(const cohsm__job *job, cohsm__group *group, uint32_t view)
{
    const cohsm__camera *cam = job->cameras + view;
    uint32_t at = group->count, k;
    while (at && !cohsm__right_is_same(job->cameras + group->view[at - 1u], cam)) at--;
    if (!at) at = group->count;
    for (k = group->count++; k > at; k--) group->view[k] = group->view[k - 1u];
    group->view[at] = view;
}

/* Sets up the cameras of the batch, and groups them. */
static void cohsm__group_views(cohsm__job *job)
{
    const cohsm_builder *b = job->builder;
    uint32_t i, view;

    for (i = 0, job->group_count = 0; i < b->batch_count; i++) {
        view = b->batch_begin + i;
        job->cameras[i] = cohsm__camera_of(&b->head, b->locations, b->angles,
                                           b->cells[view % b->head.map_count], view / b->head.map_count);
        cohsm__group_add(job, cohsm__group_of(job, job->cameras + i), i);
    }
}

static size_t cohsm__column_bytes(const cohsm__job *job)
{
    return job->column_count * sizeof *job->columns + COHSM__LINE_BYTES;
}

/* Makes ready to draw batches; shelf: NULL = none. Returns 0 if memory runs out, when nothing has begun. */
static int cohsm__job_begin(cohsm__job *job, cohsm_builder *b, const cohsm__soup *soup,
                            const cohsm__shelf *shelf)
{
    memset(job, 0, sizeof *job);
    job->builder = b;
    job->soup = soup;
    job->shelf = shelf;
    job->simd = cohsm__simd();
    if (!cohsm__draws_columns(b, soup)) return 1;
    job->column_count = (uint32_t)COHSM__COLUMNS / (b->desc.system.parallel_for ? 1u : 2u);
    job->memory = cohsm__heap_alloc(&b->heap, cohsm__column_bytes(job), 1);
    if (!job->memory) return 0;
    /* Kernels compute with whole vectors, also of entries that nothing was written to, and leave these out
       later. */
    memset(job->memory, 0, cohsm__column_bytes(job));
    job->columns = (cohsm__column *)(void *)(
        (char *)job->memory + (0u - (uintptr_t)job->memory) % COHSM__LINE_BYTES);
    return 1;
}

static void cohsm__job_end(cohsm__job *job)
{
    cohsm__heap_free(&job->builder->heap, job->memory, cohsm__column_bytes(job), 1);
}

/* Draws the views of the batch. */
static void cohsm__draw_batch(cohsm__job *job)
{
    cohsm__group_views(job);
    cohsm__run_tasks(&job->builder->desc.system, job->group_count, cohsm__raster_task, job);
}

/* Draws and compresses all views. A shelf that is not NULL receives them, or gives them if it is filled. */
static cohsm_result cohsm__build_views(cohsm_builder *b, const cohsm__soup *soup, const cohsm__shelf *shelf)
{
    cohsm__job job;
    cohsm_result result = COHSM_OK;

    if (!cohsm__job_begin(&job, b, soup, shelf)) return COHSM_ERR_ALLOC;
    while (result == COHSM_OK && b->next_view < b->head.view_count) {
        if (b->desc.system.progress &&
            b->desc.system.progress(b->desc.system.user, (float)b->next_view / (float)b->head.view_count)) {
            result = COHSM_ERR_CANCELLED;
            break;
        }
        b->batch_count = cohsm__min_u32(b->batch_views, b->head.view_count - b->next_view);
        cohsm__draw_batch(&job);
        result = cohsm__close_batch(b);
    }
    cohsm__job_end(&job);
    return result;
}

/* A mesh made ready for rendering: its triangles and its k-DOP. The sphere goes into the desc. */
typedef struct cohsm__model { cohsm__soup soup; float dop[2 * COHSM__DOP_AXES]; } cohsm__model;

/* Fits the sphere, unless the desc has one, and the k-DOP. Returns COHSM_ERR_MISMATCH, which its callers turn
   into what they say, if the mesh reaches out of the sphere of the desc. */
static cohsm_result cohsm__model_bound(cohsm__model *model, cohsm_desc *d, const cohsm__points *points,
                                       const cohsm__logger *log)
{
    const int is_given = d->radius > 0.0f;

    if (!is_given) cohsm__fit_sphere(points, d->center, &d->radius);
    else if (!cohsm__sphere_holds(points, d->center, d->radius)) return COHSM_ERR_MISMATCH;
    if (!cohsm__radius_usable(d->radius)) {
        cohsm__log_value(log, is_given ? "desc.radius" : "the radius of mesh", (double)d->radius,
                         "above 1e-18, below 1e18");
        return is_given ? COHSM_ERR_DESC : COHSM_ERR_INPUT;
    }
    cohsm__dop_of_points(model->dop, points);
    return COHSM_OK;
}

static cohsm_result cohsm__model_make(cohsm__model *model, cohsm_desc *d, const cohsm_mesh *mesh,
                                      cohsm__counted_heap *heap, cohsm_stats *stats, const cohsm__logger *log)
{
    size_t count;
    uint8_t *used;
    cohsm__points points;
    cohsm_result result = cohsm__check_mesh(mesh, log);

    if (result != COHSM_OK) return result;
    count = cohsm__triangle_count(mesh);
    used = (uint8_t *)cohsm__heap_alloc(heap, count, 1);
    if (!used) return cohsm__log_result(log, COHSM_ERR_ALLOC);
    result = cohsm__select_triangles(mesh, used, heap, stats);
    if (result == COHSM_ERR_INPUT) cohsm__log_text(log, "mesh", "has no triangle that can be used");
    if (result == COHSM_OK) {
        result = COHSM_ERR_ALLOC;
        if (cohsm__points_make(&points, mesh, used, stats->triangles, heap))
            result = cohsm__model_bound(model, d, &points, log);
        cohsm__points_free(&points, heap);
    }
    if (result == COHSM_OK &&
        !cohsm__soup_make(&model->soup, mesh, used, stats->triangles, d->center, d->radius, heap))
        result = COHSM_ERR_ALLOC;
    cohsm__heap_free(heap, used, count, 1);
    return cohsm__log_result(log, result);
}

static cohsm_result cohsm__build_model(const cohsm_desc *d, const cohsm__model *model,
                                       cohsm__counted_heap *heap, cohsm_maps **out, cohsm_stats *stats)
{
    cohsm_builder *b;
    cohsm_result result = cohsm__builder_make(d, heap, &b);

    if (result != COHSM_OK) return result;
    memcpy(b->head.dop, model->dop, sizeof model->dop);
    result = cohsm__build_views(b, &model->soup, NULL);
    if (result == COHSM_OK) result = cohsm__finish_maps(b, out, stats);
    cohsm__drop_builder(b, heap);
    return result;
}

/* Counts the segments of a build. */
static cohsm_result cohsm__count_segments(const cohsm_desc *d, const cohsm__model *model,
                                          const cohsm__shelf *shelf, cohsm__counted_heap *heap,
                                          double *segments)
{
    cohsm_builder *b;
    cohsm_result result = cohsm__builder_make(d, heap, &b);
    int i;

    if (result != COHSM_OK) return result;
    b->counting = 1;
    result = cohsm__build_views(b, &model->soup, shelf);
    for (i = 0, *segments = 0.0; i < COHSM__RANGES; i++) *segments += (double)b->ranges[i].segments;
    cohsm__drop_builder(b, heap);
    return result;
}

/* The orders and the orientations among which a build chooses. */
typedef struct cohsm__choice {
    cohsm_order       order[2];
    cohsm_orientation orientation[2];
    int               orders, orientations;
    double            segments[2][2][2];    /* by order, orientation, and size: larger trial, smaller */
} cohsm__choice;

/* Returns the desc of a trial whose sides are divided by shrink, at half the map size. */
static cohsm_desc cohsm__small_desc(const cohsm_desc *d, uint32_t shrink, cohsm__step_system *step)
{
    cohsm_desc trial = *d;
    int i;

    cohsm__system_for_step(&trial.system, step, 0.0f, 0.0f);
    for (i = 0; i < 3; i++) trial.domain.side[i] = (d->domain.side[i] + shrink - 1u) / shrink;
    trial.map_side = cohsm__max_u32(d->map_side / 2, 8);
    trial.pixel_begin = 0;
    trial.pixel_end = trial.map_side * trial.map_side;
    return trial;
}

/* Returns how many depths all views of a trial have, or 0 if a shelf for them were too large. */
static size_t cohsm__shelf_depths(const cohsm_desc *d)
{
    const uint32_t faces = cohsm__is_positional(&d->domain) ? 6u : 1u, *s = d->domain.side;
    const uint64_t views = (uint64_t)s[0] * s[1] * s[2] * faces;
    const uint64_t view = (uint64_t)d->map_side * d->map_side * (d->layers == COHSM_LAYERS_Z1Z2 ? 2u : 4u);
    return views * view <= COHSM__SHELF_BYTES / 2 ? (size_t)(views * view) : 0;
}

/* Counts the segments of all orders with one orientation, whose views are drawn once. */
static cohsm_result cohsm__try_orders(const cohsm_desc *d, const cohsm__model *model, cohsm__choice *choice,
                                      int orientation, int size, uint32_t shrink, cohsm__counted_heap *heap)
{
    cohsm__step_system step;
    cohsm_desc trial = cohsm__small_desc(d, shrink, &step);
    cohsm__shelf shelf;
    const size_t depths = choice->orders > 1 ? cohsm__shelf_depths(&trial) : 0;
    cohsm_result result = COHSM_OK;
    int o;

    memset(&shelf, 0, sizeof shelf);
    if (depths) shelf.z = (uint16_t *)cohsm__heap_alloc(heap, depths, sizeof *shelf.z);
    if (depths && !shelf.z) return COHSM_ERR_ALLOC;
    trial.orientation = choice->orientation[orientation];
    for (o = 0; o < choice->orders && result == COHSM_OK; o++) {
        trial.order = choice->order[o];
        result = cohsm__count_segments(&trial, model, shelf.z ? &shelf : NULL, heap,
                                       &choice->segments[o][orientation][size]);
        shelf.filled = 1;
    }
    cohsm__heap_free(heap, shelf.z, depths, sizeof *shelf.z);
    return result;
}

/* Takes the order and the orientation of the fewest segments: those of the larger trial, continued by the
   growth from the smaller one for as many doublings as bring the larger to the full size. */
static void cohsm__take_best(cohsm_desc *d, const cohsm__choice *choice, uint32_t shrink)
{
    double least = 0.0, segments, growth;
    uint32_t k;
    int o, f;

    for (o = 0; o < choice->orders; o++)
        for (f = 0; f < choice->orientations; f++) {
            segments = choice->segments[o][f][0];
            growth = shrink > 1 ? segments / choice->segments[o][f][1] : 1.0;       /* by one doubling */
            for (k = shrink; k > 1; k /= 2) segments *= growth;
            if (least > 0.0 && segments >= least) continue;
            least = segments;
            d->order = choice->order[o];
            d->orientation = choice->orientation[f];
        }
}

/* Chooses order and orientation if the desc leaves them open. Each is tried at a quarter and an eighth of
   each side, and its segments are continued by that growth for two more doublings, since zig-zag is ahead of
   Hilbert on few maps and falls behind on many. Below 8 maps a side such growth says little, so that small
   domains are tried at a half, or whole. */
static cohsm_result cohsm__choose_sequence(cohsm_desc *d, const cohsm__model *model,
                                           cohsm__counted_heap *heap)
{
    const uint32_t shrink = d->domain.side[0] >= 32 ? 4 : d->domain.side[0] >= 16 ? 2 : 1;
    const int tabled = cohsm__has_table((uint32_t)d->domain.kind);
    cohsm__choice choice;
    cohsm_result result = COHSM_OK;
    int f;

    memset(&choice, 0, sizeof choice);
    choice.orders = d->order == COHSM_ORDER_DEFAULT && !tabled ? 2 : 1;
    choice.orientations =
        d->orientation == COHSM_ORIENTATION_DEFAULT && !tabled && !cohsm__is_positional(&d->domain) ? 2 : 1;
    if (d->order == COHSM_ORDER_DEFAULT) d->order = COHSM_ORDER_HILBERT;
    if (d->orientation == COHSM_ORIENTATION_DEFAULT) d->orientation = COHSM_ORIENTATION_POLAR;
    if (choice.orders == 1 && choice.orientations == 1) return COHSM_OK;
    choice.order[0] = d->order;
    choice.order[1] = COHSM_ORDER_ZIGZAG_THETA;
    choice.orientation[0] = d->orientation;
    choice.orientation[1] = COHSM_ORIENTATION_TWO_POLES;
    for (f = 0; f < choice.orientations && result == COHSM_OK; f++) {
        result = cohsm__try_orders(d, model, &choice, f, 0, shrink, heap);
        if (result == COHSM_OK && shrink > 1)
            result = cohsm__try_orders(d, model, &choice, f, 1, 2 * shrink, heap);
    }
    if (result == COHSM_OK) cohsm__take_best(d, &choice, shrink);
    return result;
}

/* Does what cohsm_build does, for the public function that the log names. */
static cohsm_result cohsm__build_for(const char *function, const cohsm_desc *desc, const cohsm_mesh *mesh,
                                     cohsm_maps **out, cohsm_stats *stats)
{
    cohsm_desc d;
    cohsm_stats s;
    cohsm__counted_heap heap;
    cohsm__model model;
    cohsm__logger log;
    cohsm_maps *maps = NULL;
    cohsm_result result;

    memset(&d, 0, sizeof d);
    memset(&s, 0, sizeof s);
    memset(&heap, 0, sizeof heap);
    memset(&model, 0, sizeof model);
    if (desc) d = *desc;
    log = cohsm__logger_of(&d.system, function);
    if (!mesh) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "mesh", "is NULL");
    if (!out) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "out", "is NULL");
    result = cohsm__check_desc(&d, &log);
    if (result != COHSM_OK) return result;
    heap.allocator = cohsm__allocator_of(&d.system);
    result = cohsm__model_make(&model, &d, mesh, &heap, &s, &log);
    if (result == COHSM_ERR_MISMATCH)
        result = cohsm__refuse_value(&log, "desc.radius", (double)d.radius,
                                     "so large that the sphere about center holds the mesh");
    if (result == COHSM_OK) {
        result = cohsm__choose_sequence(&d, &model, &heap);
        if (result == COHSM_OK) result = cohsm__build_model(&d, &model, &heap, &maps, &s);
        (void)cohsm__log_build(&log, &d, result);
    }
    cohsm__soup_free(&model.soup, &heap);
    if (result == COHSM_OK) result = cohsm__lay_out_built(&maps, &d, heap.used, &s, &log);
    if (result != COHSM_OK) return result;
    *out = maps;
    if (stats) *stats = s;
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_build(const cohsm_desc *desc, const cohsm_mesh *mesh, cohsm_maps **out,
                                   cohsm_stats *stats)
{
    return cohsm__build_for("cohsm_build", desc, mesh, out, stats);
}

/* Measures the bytes a pixel of a build with this side, whose progress runs from..to. */
static cohsm_result cohsm__try_side(cohsm_desc d, const cohsm_mesh *mesh, uint32_t side, float from, float to,
                                    double *per_pixel)
{
    cohsm__step_system step;
    cohsm_maps *maps;
    cohsm_result result;

    cohsm__system_for_step(&d.system, &step, from, to);
    d.domain.side[0] = d.domain.side[1] = side;
    d.map_side = 64;
    d.pixel_begin = d.pixel_end = 0;
    d.layout = COHSM_LAYOUT_COMPACT;
    result = cohsm__build_for("cohsm_budget", &d, mesh, &maps, NULL);
    if (result != COHSM_OK) return result;
    *per_pixel = (double)(maps->head.lookup_words + maps->head.directory_words + maps->head.line_words) *
                 4.0 / (64 * 64);
    cohsm_free(maps);
    return COHSM_OK;
}

COHSM_DEF cohsm_result cohsm_budget(const cohsm_desc *desc, const cohsm_mesh *mesh, size_t bytes,
                                    uint32_t *side, uint32_t *map_side)
{
    cohsm_desc d;
    double coarse, fine, growth, pixel;
    double error, least = 0.0;
    uint32_t n, m, step, maps;
    cohsm_result result;
    cohsm__logger log;

    memset(&d, 0, sizeof d);
    if (desc) d = *desc;
    log = cohsm__logger_of(&d.system, "cohsm_budget");
    if (!mesh) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "mesh", "is NULL");
    if (!side) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "side", "is NULL");
    if (!map_side) return cohsm__refuse(&log, COHSM_ERR_ARGUMENT, "map_side", "is NULL");
    if (d.domain.kind != COHSM_DOMAIN_DEFAULT && d.domain.kind != COHSM_DOMAIN_LATLONG &&
        d.domain.kind != COHSM_DOMAIN_OCTAHEDRAL)
        return cohsm__refuse_value(&log, "desc.domain.kind", (double)d.domain.kind, "LATLONG or OCTAHEDRAL");
    if (d.order == COHSM_ORDER_DEFAULT) d.order = COHSM_ORDER_HILBERT;
    result = cohsm__try_side(d, mesh, 16, 0.0f, 0.2f, &coarse);
    if (result == COHSM_OK) result = cohsm__try_side(d, mesh, 32, 0.2f, 1.0f, &fine);
    if (result != COHSM_OK) return result;
    growth = fine / coarse > 1.0 ? fine / coarse : 1.0;
    /* Sides are n, and half a doubling on 1.5 n. */
    for (n = 8, pixel = coarse / growth; n <= 2048; n *= 2, pixel *= growth)
        for (step = 2; step <= 3; step++)
            for (m = 16, maps = (n * step / 2u) * (n * step / 2u); m <= 1024; m += 16) {
                double size = pixel * (step == 3 ? 0.5 * (1.0 + growth) : 1.0) * m * m;
                size += 4.0 * (double)COHSM__HEADER_WORDS + (maps > 65536u ? 4.0 : 2.0) * maps;
                /* The lookup of the first chunk is part of pixel; this is that of the other chunks. */
                size += 4.0 * m * m * ((maps - 1u) / 65536u);
                if (size > 0.9 * (double)bytes) break;
                error = 0.0055 * 128.0 / (n * step / 2u) + 0.0185 * sqrt(128.0 / m);
                if (least > 0.0 && error >= least) continue;
                least = error;
                *side = n * step / 2u;
                *map_side = m;
            }
    if (least > 0.0) return COHSM_OK;
    cohsm__log_value(&log, "bytes", (double)bytes, "more: not even 64 maps of 16 x 16 pixels fit");
    return COHSM_ERR_LIMIT;
}
