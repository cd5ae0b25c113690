/* ---- ism: surfels scattered on the GPU ---- */

enum { GLBK__ISM_CLUSTERS = 32768,          /* the most clusters that there are, as in ism.h */
       GLBK__ISM_BATCH = 1 << 21,           /* shares that are computed at a time, about */
       GLBK__ISM_LAYER = 1 << 20 };         /* texels of a layer of a table */

enum { GLBK__ISM_MEASURE, GLBK__ISM_GATHER, GLBK__ISM_SHARE, GLBK__ISM_RUN, GLBK__ISM_COUNT,
       GLBK__ISM_SCATTER, GLBK__ISM_GONE, GLBK__ISM_SEE, GLBK__ISM_LIST, GLBK__ISM_PAIRS,
       GLBK__ISM_SPREAD_PROGRAMS };

/* Makes a sheet of `rows` sequences of `count` numbers, as ism_fold.glsl has them. */
static void glbk__ism_make_fold(glbk__ism_making *k, glbk_format format, uint32_t count, uint32_t rows,
                                glbk_ism_sheet *out)
{
    glbk__ism_make_sheet(k, format, count < 1024 ? count : 1024, (count + 1023) / 1024 * rows, out);
}

/* Makes sums of sequences: with `running`, of every number of a block of 32, else of blocks alone. */
static void glbk__ism_make_levels(glbk__ism_making *k, uint32_t count, uint32_t rows, int running,
                                  glbk_ism_sheet *sheets, uint32_t levels)
{
    const glbk_format format = running ? GLBK_FORMAT_R32UI : GLBK_FORMAT_RG32UI;
    uint32_t i;
    for (i = 0; i < levels; i++) {
        if (i || !running) count = glbk__ism_blocks(count);
        glbk__ism_make_fold(k, format, count, rows, &sheets[i]);
    }
}

/* Returns from how many receivers triangles are looked at; 0: surfels are spread by area. */
static uint32_t glbk__ism_views(const ism_desc *d)
{
    if (d->spread == ISM_SPREAD_AREA) return 0;
    return d->spread == ISM_SPREAD_VIEW_1 ? 1 : 8;
}

static int glbk__ism_by_pair(const ism_desc *d)
{
    return d->spread == ISM_SPREAD_DEFAULT || d->spread == ISM_SPREAD_PAIR;
}

static glbk_result glbk__ism_create_spread(glbk_context *ctx, const glbk_ism_maps *m, glbk_ism_spread *s)
{
    char defines[] = "ISM_PROJECTION=1";
    glbk__ism_making k = glbk__ism_begin_making(ctx);
    defines[15] = (char)('0' + (int)m->desc.projection);
    k.defines = defines;
    /* Each pass chooses the layer. */
    glbk__ism_make_target(&k, NULL, m->compute ? &m->surfels : m->phase_surfels, 1, &s->surfel_target);
    glbk__ism_make_fold(&k, GLBK_FORMAT_R32UI, m->desc.vpl_count, 1, &s->counts);
    glbk__ism_make_sheet(&k, GLBK_FORMAT_R8UI, 1024, 1024, &s->gone);       /* of a layer's texels */
    glbk__ism_make_block(&k, sizeof(glbk_ism_scattering), &s->block);
    glbk__ism_make_passes(&k, "ism_sizes.frag\0ism_clusters.frag\0ism_shares.frag\0ism_run.frag\0"
                          "ism_counts.frag\0ism_points.frag\0ism_gone.frag\0", s->programs);
    if (glbk__ism_views(&m->desc))
        glbk__ism_make_passes(&k, "ism_seen.frag\0ism_receivers.frag\0", &s->programs[GLBK__ISM_SEE]);
    if (glbk__ism_by_pair(&m->desc))
        glbk__ism_make_program(&k, "ism_pairs.frag", &s->programs[GLBK__ISM_PAIRS]);
    s->table = m->vpls.name;
    return k.result;
}

GLBK_DEF glbk_result glbk_ism_spread_create(glbk_context *ctx, const glbk_ism_maps *m, glbk_ism_spread *out)
{
    static const char fields[] =
        "maps->desc.spread\0" "a value of ism_spread\0"
        "maps->desc.area_share\0" "0..1\0";
    static const glbk__ism_range ranges[] = {
        { 0, ISM_SPREAD_COUNT - 1 }, { 0, 1 }
    };
    double values[2];
    glbk_result result = glbk__enter_create(ctx, __func__, out, sizeof *out);
    if (result == GLBK_OK) result = glbk__ism_check_maps(ctx, __func__, m);
    if (result != GLBK_OK) return result;
    values[0] = (double)m->desc.spread;
    values[1] = (double)m->desc.area_share;
    result = glbk__ism_in_range(ctx, __func__, fields, ranges, values);
    if (result != GLBK_OK) return result;
    result = glbk__ism_create_spread(ctx, m, out);
    if (result != GLBK_OK) glbk_ism_spread_free(ctx, out);
    return result;
}

static void glbk__ism_free_view(glbk_context *ctx, glbk_ism_spread *s)
{
    glbk__ism_free_sheets(ctx, &s->seen, 1);
    glbk__ism_free_sheets(ctx, s->seen_sums, 5);
    glbk__ism_free_sheets(ctx, &s->receivers, 1);
    s->width = s->height = 0;
}

/* Makes room for the receivers of a picture, if it has not the size of the last one. */
static glbk_result glbk__ism_hold_view(glbk_context *ctx, glbk_ism_spread *s, const glbk_gbuffer *seen)
{
    const double pixels = (double)seen->width * seen->height;
    const uint32_t count = (uint32_t)pixels;
    glbk__ism_making k = glbk__ism_begin_making(ctx);
    if (s->width == seen->width && s->height == seen->height) return GLBK_OK;
    glbk__ism_free_view(ctx, s);
    if (pixels > 16777216)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, "glbk_ism_scatter", "the pixels of seen", pixels, 1,
                                  16777216);
    glbk__ism_make_fold(&k, GLBK_FORMAT_R32UI, count, 1, &s->seen);
    glbk__ism_make_levels(&k, count, 1, 1, s->seen_sums, 5);
    glbk__ism_make_fold(&k, GLBK_FORMAT_RGBA32UI, count, 1, &s->receivers);
    if (k.result != GLBK_OK) {
        glbk__ism_free_view(ctx, s);
        return k.result;
    }
    s->width = seen->width;
    s->height = seen->height;
    return GLBK_OK;
}

static void glbk__ism_free_triangles(glbk_context *ctx, glbk_ism_spread *s)
{
    glbk__ism_free_sheets(ctx, &s->sizes, 1);
    glbk__ism_free_sheets(ctx, &s->masses, 1);
    glbk_texture_free(ctx, &s->clusters);
    glbk__ism_free_sheets(ctx, s->totals, 3);
    glbk__ism_free_sheets(ctx, &s->effects, 1);
    glbk__ism_free_sheets(ctx, s->effect_totals, 3);
    glbk__ism_free_sheets(ctx, &s->shares, 1);
    glbk__ism_free_sheets(ctx, s->share_sums, 3);
    s->triangle_count = 0;
}

/* Makes the pictures of clusters and the target that draws them together. */
static void glbk__ism_make_clusters(glbk__ism_making *k, glbk_ism_spread *s)
{
    const uint32_t count = s->cluster_count;
    const uint32_t width = count < 1024 ? count : 1024, height = (count + 1023) / 1024;
    glbk__ism_make_layers(k, GLBK_FORMAT_RG32UI, width, height, 0, &s->masses.texture);
    glbk__ism_make_layers(k, GLBK_FORMAT_RGBA32UI, width, height, 3, &s->clusters);
    glbk__ism_make_target(k, &s->masses.texture, &s->clusters, 3, &s->masses.target);
}

/* Makes what holds the shares of a batch of VPLs; without pairs of VPL and cluster all VPLs have the same. */
static void glbk__ism_make_shares(glbk__ism_making *k, const glbk_ism_maps *m, glbk_ism_spread *s)
{
    const int pair = glbk__ism_by_pair(&m->desc);
    const uint32_t count = s->cluster_count, height = (count + 1023) / 1024, most = 2048 / height;
    uint32_t batch = (uint32_t)GLBK__ISM_BATCH / count, rows;
    if (batch > most) batch = most;
    if (batch > m->desc.vpl_count) batch = m->desc.vpl_count;
    rows = pair ? batch : 1;
    s->batch = pair ? batch : m->desc.vpl_count;
    if (pair) {
        glbk__ism_make_fold(k, GLBK_FORMAT_R32UI, count, rows, &s->effects);
        glbk__ism_make_levels(k, count, rows, 0, s->effect_totals, 3);
    }
    glbk__ism_make_fold(k, GLBK_FORMAT_R32UI, count, rows, &s->shares);
    glbk__ism_make_levels(k, count, rows, 1, s->share_sums, 3);
}

/* Makes room for the triangles of a mesh, if it has not as many as the last one. */
static glbk_result glbk__ism_hold_triangles(glbk_context *ctx, const glbk_ism_maps *m, glbk_ism_spread *s)
{
    const uint32_t count = m->triangle_count;
    glbk__ism_making k = glbk__ism_begin_making(ctx);
    if (s->triangle_count == count) return GLBK_OK;
    glbk__ism_free_triangles(ctx, s);
    s->triangles_per_cluster = count / (uint32_t)GLBK__ISM_CLUSTERS + 1;
    s->cluster_count = (count + s->triangles_per_cluster - 1) / s->triangles_per_cluster;
    glbk__ism_make_fold(&k, GLBK_FORMAT_RG32UI, count, 1, &s->sizes);
    glbk__ism_make_clusters(&k, s);
    glbk__ism_make_levels(&k, s->cluster_count, 1, 0, s->totals, 3);
    glbk__ism_make_shares(&k, m, s);
    if (k.result == GLBK_OK) s->triangle_count = count;
    else glbk__ism_free_triangles(ctx, s);
    return k.result;
}

/* What a frame is scattered with. After the first error nothing is drawn. */
typedef struct glbk__ism_spreading {
    glbk_context       *ctx;
    glbk_ism_maps      *maps;
    glbk_ism_spread    *spread;
    glbk_ism_scattering block;      /* the values of the uniform block */
    uint32_t            fewer;      /* not 0: triangles are gone, and other phases' surfels stay */
    glbk_result         result;     /* of all passes so far */
} glbk__ism_spreading;

/* Begins a pass by a program, with the block as it is. */
static void glbk__ism_begin(glbk__ism_spreading *j, const glbk_pass *pass, int program)
{
    if (j->result == GLBK_OK) j->result = glbk_begin(j->ctx, pass, &j->spread->programs[program]);
    if (j->result == GLBK_OK)
        j->result = glbk__put_block(j->ctx, GLBK_SLOT_glbk_ism_scattering, &j->spread->block, &j->block);
}

/* Begins a pass that draws a sheet by a program, which reads what is bound next. */
static void glbk__ism_begin_sheet(glbk__ism_spreading *j, const glbk_ism_sheet *sheet, int program)
{
    glbk_pass pass;
    memset(&pass, 0, sizeof pass);
    pass.target = &sheet->target;
    glbk__ism_begin(j, &pass, program);
}

static void glbk__ism_finish_sheet(const glbk__ism_spreading *j)
{
    if (j->result == GLBK_OK) glbk_draw_screen(j->ctx);
}

static void glbk__ism_bind_sheet(const glbk__ism_spreading *j, uint32_t slot, const glbk_ism_sheet *sheet)
{
    glbk_bind_texture(j->ctx, slot, &sheet->texture);
}

/* Binds successive levels of sums to successive slots. */
static void glbk__ism_bind_sums(const glbk__ism_spreading *j, uint32_t slot, const glbk_ism_sheet *sums,
                                uint32_t count)
{
    uint32_t k;
    for (k = 0; k < count; k++) glbk__ism_bind_sheet(j, slot + k, &sums[k]);
}

/* Sums up sequences of `count` values, level by level: running sums, or only those of blocks. */
static void glbk__ism_sum(glbk__ism_spreading *j, const glbk_ism_sheet *values, uint32_t count, int running,
                          const glbk_ism_sheet *sums, uint32_t levels)
{
    glbk_ism_scattering *b = &j->block;
    uint32_t k;
    b->value_count = count;
    b->pace = running != 0;
    for (k = 0; k < levels; k++) {
        glbk__ism_begin_sheet(j, &sums[k], GLBK__ISM_RUN);
        glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_values, values);
        glbk__ism_finish_sheet(j);
        values = &sums[k];
        if (k || !running) b->value_count = glbk__ism_blocks(b->value_count);
        if (running) b->pace = 32;
    }
}

/* Lists the receivers of the picture, whose G-buffer the caller has checked. */
static void glbk__ism_list_receivers(glbk__ism_spreading *j, const glbk_gbuffer *seen)
{
    glbk_ism_spread *s = j->spread;
    glbk__ism_begin_sheet(j, &s->seen, GLBK__ISM_SEE);
    (void)glbk_gbuffer_bind(j->ctx, seen, NULL);
    glbk__ism_finish_sheet(j);
    glbk__ism_sum(j, &s->seen, seen->width * seen->height, 1, s->seen_sums, 5);
    glbk__ism_begin_sheet(j, &s->receivers, GLBK__ISM_LIST);
    (void)glbk_gbuffer_bind(j->ctx, seen, NULL);
    glbk__ism_bind_sums(j, GLBK_SLOT_glbk_ism_runs0, s->seen_sums, 4);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_runs4, &s->seen_sums[4]);
    glbk__ism_finish_sheet(j);
}

/* Measures triangles, and clusters of them. */
static void glbk__ism_measure(glbk__ism_spreading *j)
{
    glbk_ism_spread *s = j->spread;
    glbk__ism_begin_sheet(j, &s->sizes, GLBK__ISM_MEASURE);
    glbk_bind_texture(j->ctx, GLBK_SLOT_glbk_ism_triangles, &j->maps->triangle_table);
    glbk_bind_texture(j->ctx, GLBK_SLOT_glbk_ism_positions, &j->maps->positions);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_receivers, &s->receivers);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_runs4, &s->seen_sums[4]);
    glbk__ism_finish_sheet(j);
    glbk__ism_begin_sheet(j, &s->masses, GLBK__ISM_GATHER);     /* reads triangles and positions, too */
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_sizes, &s->sizes);
    glbk__ism_finish_sheet(j);
    glbk__ism_sum(j, &s->masses, s->cluster_count, 0, s->totals, 3);
}

/* Draws the effects of clusters on the VPLs of a batch, and their sums. */
static void glbk__ism_weigh_pairs(glbk__ism_spreading *j)
{
    glbk_ism_spread *s = j->spread;
    glbk__ism_begin_sheet(j, &s->effects, GLBK__ISM_PAIRS);
    glbk_bind_texture(j->ctx, GLBK_SLOT_glbk_ism_vpls, &j->maps->vpls);
    glbk_bind_block(j->ctx, GLBK_SLOT_glbk_ism_frame, &j->maps->frame);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_masses, &s->masses);
    glbk_bind_texture(j->ctx, GLBK_SLOT_glbk_ism_clusters, &s->clusters);
    glbk__ism_finish_sheet(j);
    glbk__ism_sum(j, &s->effects, s->cluster_count, 0, s->effect_totals, 3);
}

/* Draws the shares that clusters have of the surfels of a batch, and their running sums. */
static void glbk__ism_share(glbk__ism_spreading *j)
{
    glbk_ism_spread *s = j->spread;
    if (j->block.pair) glbk__ism_weigh_pairs(j);
    glbk__ism_begin_sheet(j, &s->shares, GLBK__ISM_SHARE);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_masses, &s->masses);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_totals, &s->totals[2]);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_values, &s->effects);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_effect_totals, &s->effect_totals[2]);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_runs4, &s->seen_sums[4]);
    glbk__ism_finish_sheet(j);
    glbk__ism_sum(j, &s->shares, s->cluster_count, 1, s->share_sums, 3);
}

/* Binds what surfels are drawn from. */
static void glbk__ism_bind_shares(const glbk__ism_spreading *j)
{
    const glbk_ism_spread *s = j->spread;
    glbk__ism_bind_sums(j, GLBK_SLOT_glbk_ism_runs0, s->share_sums, 3);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_shares, &s->shares);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_totals, &s->totals[2]);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_counts, &s->counts);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_masses, &s->masses);
    glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_sizes, &s->sizes);
}

/* Finds which surfels in the rows of a layer of their table that a pass draws next have triangles that are
   gone. Other rows stay untouched: with many batches they are most, and the table may end before them. */
static void glbk__ism_find_gone(glbk__ism_spreading *j, const glbk_texture *table, const glbk_pass *next)
{
    glbk_pass pass = *next;
    pass.target = &j->spread->gone.target;
    glbk__ism_begin(j, &pass, GLBK__ISM_GONE);
    glbk_bind_texture(j->ctx, GLBK_SLOT_glbk_ism_surfels, table);
    glbk__ism_finish_sheet(j);
}

/* Draws the surfels of a phase and of a batch of VPLs, into the rows of the table's layers that hold them. If
   triangles are gone, those of a phase whose turn it is not stay, if their triangles are there. */
static void glbk__ism_draw_surfels(glbk__ism_spreading *j, uint32_t phase)
{
    const glbk_ism_maps *m = j->maps;
    glbk_ism_spread *s = j->spread;
    glbk_ism_scattering *b = &j->block;
    const uint32_t layer_size = GLBK__ISM_LAYER, each = m->phase_surfel_count;
    const uint32_t base = m->compute ? phase * each * m->desc.vpl_count : 0;
    const uint32_t begin = base + b->first_vpl * each, end = begin + b->batch * each;
    const glbk_texture *table = m->compute ? &m->surfels : &m->phase_surfels[phase];
    glbk_pass pass;
    uint32_t layer;
    memset(&pass, 0, sizeof pass);
    pass.target = &s->surfel_target;
    for (layer = begin / layer_size; layer * layer_size < end; layer++) {
        const uint32_t start = layer * layer_size, low = begin > start ? begin - start : 0;
        const uint32_t high = end - start < layer_size ? end - start : layer_size;
        pass.viewport[1] = (int32_t)(low / 1024);
        pass.viewport[2] = 1024;
        pass.viewport[3] = (int32_t)((high + 1023) / 1024 - low / 1024);
        b->phase = phase;
        b->first_texel = start - base;
        b->layer = layer;
        b->keep = j->fewer && phase != b->frame % b->lazy_frames;
        if (b->keep) glbk__ism_find_gone(j, table, &pass);
        glbk__ism_begin(j, &pass, GLBK__ISM_SCATTER);
        if (j->result != GLBK_OK) return;
        j->ctx->gl.FramebufferTextureLayer(GLBK_GL_DRAW_FRAMEBUFFER, GLBK_GL_COLOR_ATTACHMENT0, table->name,
                                           0, (int32_t)layer);
        glbk__ism_bind_shares(j);
        glbk__ism_bind_sheet(j, GLBK_SLOT_glbk_ism_gone, &s->gone);
        glbk_draw_screen(j->ctx);
    }
}

/* Sets the values of the block that all passes of a frame have in common. */
static void glbk__ism_set_block(glbk__ism_spreading *j, uint32_t index)
{
    const glbk_ism_maps *m = j->maps;
    const glbk_ism_spread *s = j->spread;
    const ism_desc *d = &m->desc;
    glbk_ism_scattering *b = &j->block;
    memset(b, 0, sizeof *b);
    b->triangle_count = s->triangle_count;
    b->cluster_count = s->cluster_count;
    b->cluster_size = s->triangles_per_cluster;
    b->batch = s->batch;
    b->view_width = s->width;
    b->view_height = s->height;
    b->views = glbk__ism_views(d);
    b->pair = glbk__ism_by_pair(d) != 0;
    b->seed = d->seed;
    b->frame = index;
    b->key = d->unstable ? glbk_ism__hash_combine(d->seed, index) : d->seed;
    b->surfel_count = d->surfel_count;
    b->phase_surfel_count = m->phase_surfel_count;
    b->lazy_frames = d->lazy_frames;
    b->vpl_capacity = d->vpl_count;
    b->vary_surfels = d->vary_surfels != 0;
    b->area_share = d->area_share > 0 ? d->area_share : 0.2f;
}

/* Draws how many surfels VPLs have, and then batch by batch shares and surfels. */
static void glbk__ism_scatter_all(glbk__ism_spreading *j, uint32_t first, uint32_t end)
{
    const uint32_t count = j->maps->desc.vpl_count, batch = j->spread->batch;
    uint32_t vpl, phase;
    glbk__ism_begin_sheet(j, &j->spread->counts, GLBK__ISM_COUNT);
    glbk_bind_texture(j->ctx, GLBK_SLOT_glbk_ism_vpls, &j->maps->vpls);
    glbk_bind_block(j->ctx, GLBK_SLOT_glbk_ism_frame, &j->maps->frame);
    glbk__ism_finish_sheet(j);
    for (vpl = 0; vpl < count && j->result == GLBK_OK; vpl += batch) {
        j->block.first_vpl = vpl;
        j->block.batch = count - vpl < batch ? count - vpl : batch;
        glbk__ism_share(j);
        for (phase = first; phase < end; phase++) glbk__ism_draw_surfels(j, phase);
    }
}

/* Checks the arguments of glbk_ism_scatter. */
static glbk_result glbk__ism_check_scatter(const glbk_context *ctx, const char *function,
                                           const glbk_ism_spread *s, const glbk_ism_maps *m,
                                           const glbk_gbuffer *seen)
{
    glbk_result result = glbk__require_created(ctx, function, "spread", s ? &s->block.name : NULL);
    if (result == GLBK_OK) result = glbk__ism_check_maps(ctx, function, m);
    if (result != GLBK_OK) return result;
    if (m->vpls.name != s->table)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, "maps",
                            "are not those that the spread was made for");
    if (m->masked)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, function, "the mesh of maps",
                            "has a mask, whose holes only ism_scatter knows");
    if (!glbk__ism_views(&m->desc)) return GLBK_OK;
    return glbk__require_created(ctx, function, "seen", seen ? &seen->colors.name : NULL);
}

GLBK_DEF glbk_result glbk_ism_scatter(glbk_context *ctx, glbk_ism_spread *s, glbk_ism_maps *m,
                                      const glbk_gbuffer *seen, uint32_t index)
{
    glbk__ism_spreading j;
    uint32_t k, first, end;
    int all;
    j.result = glbk__ism_check_scatter(ctx, __func__, s, m, seen);
    if (j.result != GLBK_OK || !m->triangle_count) return j.result;
    all = m->desc.unstable || m->desc.vary_surfels;
    for (k = 0; k < m->desc.lazy_frames; k++) all = all || !(m->phases >> k & 1);
    j.fewer = !all && m->fewer;
    first = all || j.fewer ? 0 : index % m->desc.lazy_frames;
    end = all || j.fewer ? m->desc.lazy_frames : first + 1;
    j.result = glbk__ism_hold_triangles(ctx, m, s);
    if (j.result == GLBK_OK && glbk__ism_views(&m->desc)) j.result = glbk__ism_hold_view(ctx, s, seen);
    if (j.result != GLBK_OK) return j.result;
    j.ctx = ctx;
    j.maps = m;
    j.spread = s;
    glbk__ism_set_block(&j, index);
    if (j.block.views) glbk__ism_list_receivers(&j, seen);
    glbk__ism_measure(&j);
    glbk__ism_scatter_all(&j, first, end);
    if (j.result != GLBK_OK) return j.result;
    for (k = first; k < end; k++) m->phases |= (uint64_t)1 << k;
    m->fewer = 0;
    return GLBK_OK;
}

GLBK_DEF void glbk_ism_spread_free(glbk_context *ctx, glbk_ism_spread *s)
{
    uint32_t k;
    if (!s) return;
    for (k = 0; k < GLBK__ISM_SPREAD_PROGRAMS; k++) glbk_program_free(ctx, &s->programs[k]);
    glbk__ism_free_view(ctx, s);
    glbk__ism_free_triangles(ctx, s);
    glbk__ism_free_sheets(ctx, &s->counts, 1);
    glbk__ism_free_sheets(ctx, &s->gone, 1);
    glbk_target_free(ctx, &s->surfel_target);
    glbk_buffer_free(ctx, &s->block);
    memset(s, 0, sizeof *s);
}
