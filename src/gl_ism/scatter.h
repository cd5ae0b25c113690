/* ---- ism: surfels scattered on the GPU ---- */

enum { GLBK__ISM_CLUSTERS = 32768,          /* the most clusters that there are, as in ism.h */
       GLBK__ISM_BATCH = 1 << 21,           /* shares that are computed at a time, about */
       GLBK__ISM_LAYER = 1 << 20 };         /* texels of a layer of a table */

/* Makes a sheet of `rows` sequences of `count` numbers, as ism_fold.glsl has them. */
static glbk_result glbk__ism_create_sheet(glbk_context *ctx, glbk_format format, uint32_t count,
                                          uint32_t rows, glbk_ism_sheet *out)
{
    const uint32_t width = count < 1024 ? count : 1024, height = (count + 1023) / 1024 * rows;
    return glbk__canvas(ctx, format, width, height, NULL, &out->texture, &out->target);
}

static void glbk__ism_free_sheets(glbk_context *ctx, glbk_ism_sheet *sheets, uint32_t count)
{
    uint32_t k;
    for (k = 0; k < count; k++) {
        glbk_target_free(ctx, &sheets[k].target);
        glbk_texture_free(ctx, &sheets[k].texture);
    }
}

/* Makes sums of sequences: with `running`, of every number of a block of 32, else of blocks alone. */
static glbk_result glbk__ism_create_levels(glbk_context *ctx, uint32_t count, uint32_t rows, int running,
                                           glbk_ism_sheet *sheets, uint32_t levels)
{
    const glbk_format format = running ? GLBK_FORMAT_R32UI : GLBK_FORMAT_RG32UI;
    glbk_result result = GLBK_OK;
    uint32_t k;
    for (k = 0; k < levels && result == GLBK_OK; k++) {
        if (k || !running) count = glbk__ism_blocks(count);
        result = glbk__ism_create_sheet(ctx, format, count, rows, &sheets[k]);
    }
    return result;
}

/* Makes a target of the tables of surfels, whose layer each pass chooses. */
static glbk_result glbk__ism_create_surfel_target(glbk_context *ctx, const glbk_ism_maps *m,
                                                  glbk_ism_spread *s)
{
    glbk_target_desc t;
    memset(&t, 0, sizeof t);
    t.color[0] = m->compute ? &m->surfels : m->phase_surfels;
    return glbk__target_create(ctx, &t, &s->surfel_target);
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
    const glbk_part *part = glbk_ism_part();
    char defines[] = "ISM_PROJECTION=1";
    glbk_result result = glbk__ism_create_surfel_target(ctx, m, s);
    defines[15] = (char)('0' + (int)m->desc.projection);
    if (result == GLBK_OK)
        result = glbk__ism_create_sheet(ctx, GLBK_FORMAT_R32UI, m->desc.vpl_count, 1, &s->counts);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_ism_scattering), NULL, &s->block);
    if (result == GLBK_OK && glbk__ism_views(&m->desc)) {
        result = glbk__gbuffer_program(ctx, part, "ism_seen.frag", NULL, &s->see);
        if (result == GLBK_OK)
            result = glbk__gbuffer_program(ctx, part, "ism_receivers.frag", NULL, &s->list);
    }
    if (result == GLBK_OK) result = glbk__program_create(ctx, part, "ism_sizes.frag", NULL, &s->measure);
    if (result == GLBK_OK) result = glbk__program_create(ctx, part, "ism_clusters.frag", NULL, &s->gather);
    if (result == GLBK_OK && glbk__ism_by_pair(&m->desc))
        result = glbk__program_create(ctx, part, "ism_pairs.frag", defines, &s->weigh);
    if (result == GLBK_OK) result = glbk__program_create(ctx, part, "ism_shares.frag", NULL, &s->share);
    if (result == GLBK_OK) result = glbk__program_create(ctx, part, "ism_run.frag", NULL, &s->run);
    if (result == GLBK_OK) result = glbk__program_create(ctx, part, "ism_counts.frag", defines, &s->count);
    if (result == GLBK_OK) result = glbk__program_create(ctx, part, "ism_points.frag", NULL, &s->scatter);
    s->table = m->vpls.name;
    return result;
}

GLBK_DEF glbk_result glbk_ism_spread_create(glbk_context *ctx, const glbk_ism_maps *m, glbk_ism_spread *out)
{
    glbk_result result;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!out) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "out", "is NULL");
    memset(out, 0, sizeof *out);
    result = glbk__ism_check_maps(ctx, __func__, m);
    if (result != GLBK_OK) return result;
    if ((unsigned)m->desc.spread >= ISM_SPREAD_COUNT)
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, __func__, "maps->desc.spread", (double)m->desc.spread,
                                  "a value of ism_spread");
    if (!(m->desc.area_share >= 0 && m->desc.area_share <= 1))
        return glbk__refuse_value(ctx, GLBK_ERR_DESC, __func__, "maps->desc.area_share",
                                  (double)m->desc.area_share, "0..1");
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
    glbk_result result;
    if (s->width == seen->width && s->height == seen->height) return GLBK_OK;
    glbk__ism_free_view(ctx, s);
    if (pixels > 16777216)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, "glbk_ism_scatter", "the pixels of seen", pixels, 1,
                                  16777216);
    result = glbk__ism_create_sheet(ctx, GLBK_FORMAT_R32UI, count, 1, &s->seen);
    if (result == GLBK_OK) result = glbk__ism_create_levels(ctx, count, 1, 1, s->seen_sums, 5);
    if (result == GLBK_OK)
        result = glbk__ism_create_sheet(ctx, GLBK_FORMAT_RGBA32UI, count, 1, &s->receivers);
    if (result != GLBK_OK) {
        glbk__ism_free_view(ctx, s);
        return result;
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
static glbk_result glbk__ism_create_clusters(glbk_context *ctx, glbk_ism_spread *s)
{
    const uint32_t count = s->cluster_count;
    glbk_texture_desc d;
    glbk_target_desc t;
    glbk_result result;
    uint32_t k;
    memset(&d, 0, sizeof d);
    memset(&t, 0, sizeof t);
    d.format = GLBK_FORMAT_RG32UI;
    d.width = count < 1024 ? count : 1024;
    d.height = (count + 1023) / 1024;
    result = glbk_texture_create(ctx, &d, &s->masses.texture);
    d.format = GLBK_FORMAT_RGBA32UI;
    d.layers = 3;
    if (result == GLBK_OK) result = glbk_texture_create(ctx, &d, &s->clusters);
    if (result != GLBK_OK) return result;
    t.color[0] = &s->masses.texture;
    for (k = 0; k < 3; k++) {
        t.color[k + 1] = &s->clusters;
        t.layer[k + 1] = k;
    }
    return glbk__target_create(ctx, &t, &s->masses.target);
}

/* Makes what holds the shares of a batch of VPLs; without pairs of VPL and cluster all VPLs have the same. */
static glbk_result glbk__ism_create_shares(glbk_context *ctx, const glbk_ism_maps *m, glbk_ism_spread *s)
{
    const int pair = glbk__ism_by_pair(&m->desc);
    const uint32_t count = s->cluster_count, height = (count + 1023) / 1024, most = 2048 / height;
    uint32_t batch = (uint32_t)GLBK__ISM_BATCH / count, rows;
    glbk_result result = GLBK_OK;
    if (batch > most) batch = most;
    if (batch > m->desc.vpl_count) batch = m->desc.vpl_count;
    rows = pair ? batch : 1;
    s->batch = pair ? batch : m->desc.vpl_count;
    if (pair) {
        result = glbk__ism_create_sheet(ctx, GLBK_FORMAT_R32UI, count, rows, &s->effects);
        if (result == GLBK_OK) result = glbk__ism_create_levels(ctx, count, rows, 0, s->effect_totals, 3);
    }
    if (result == GLBK_OK) result = glbk__ism_create_sheet(ctx, GLBK_FORMAT_R32UI, count, rows, &s->shares);
    return result == GLBK_OK ? glbk__ism_create_levels(ctx, count, rows, 1, s->share_sums, 3) : result;
}

/* Makes room for the triangles of a mesh, if it has not as many as the last one. */
static glbk_result glbk__ism_hold_triangles(glbk_context *ctx, const glbk_ism_maps *m, glbk_ism_spread *s)
{
    const uint32_t count = m->triangle_count;
    glbk_result result;
    if (s->triangle_count == count) return GLBK_OK;
    glbk__ism_free_triangles(ctx, s);
    s->triangles_per_cluster = count / (uint32_t)GLBK__ISM_CLUSTERS + 1;
    s->cluster_count = (count + s->triangles_per_cluster - 1) / s->triangles_per_cluster;
    result = glbk__ism_create_sheet(ctx, GLBK_FORMAT_RG32UI, count, 1, &s->sizes);
    if (result == GLBK_OK) result = glbk__ism_create_clusters(ctx, s);
    if (result == GLBK_OK) result = glbk__ism_create_levels(ctx, s->cluster_count, 1, 0, s->totals, 3);
    if (result == GLBK_OK) result = glbk__ism_create_shares(ctx, m, s);
    if (result == GLBK_OK) s->triangle_count = count;
    else glbk__ism_free_triangles(ctx, s);
    return result;
}

/* Begins a pass over a whole target by a program that reads what is bound next. */
static glbk_result glbk__ism_begin_spread(glbk_context *ctx, const glbk_ism_spread *s,
                                          const glbk_target *target, glbk_program *program,
                                          const glbk_ism_scattering *b)
{
    glbk_pass pass;
    glbk_result result;
    memset(&pass, 0, sizeof pass);
    pass.target = target;
    result = glbk_begin(ctx, &pass, program);
    return result == GLBK_OK ? glbk__put_block(ctx, GLBK_SLOT_glbk_ism_scattering, &s->block, b) : result;
}

/* Sums up sequences of `count` values, level by level: running sums, or only those of blocks. */
static glbk_result glbk__ism_sum(glbk_context *ctx, glbk_ism_spread *s, glbk_ism_scattering *b,
                                 const glbk_texture *values, uint32_t count, int running,
                                 const glbk_ism_sheet *sums, uint32_t levels)
{
    glbk_result result = GLBK_OK;
    uint32_t k;
    b->value_count = count;
    b->pace = running != 0;
    for (k = 0; k < levels && result == GLBK_OK; k++) {
        result = glbk__ism_begin_spread(ctx, s, &sums[k].target, &s->run, b);
        if (result != GLBK_OK) return result;
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_values, values);
        glbk_draw_screen(ctx);
        values = &sums[k].texture;
        if (k || !running) b->value_count = glbk__ism_blocks(b->value_count);
        if (running) b->pace = 32;
    }
    return result;
}

/* Lists the receivers of the picture. */
static glbk_result glbk__ism_list_receivers(glbk_context *ctx, glbk_ism_spread *s, const glbk_gbuffer *seen,
                                            glbk_ism_scattering *b)
{
    glbk_result result = glbk__ism_begin_spread(ctx, s, &s->seen.target, &s->see, b);
    uint32_t k;
    if (result != GLBK_OK) return result;
    (void)glbk_gbuffer_bind(ctx, seen, NULL);       /* The caller has checked it. */
    glbk_draw_screen(ctx);
    result = glbk__ism_sum(ctx, s, b, &s->seen.texture, seen->width * seen->height, 1, s->seen_sums, 5);
    if (result == GLBK_OK) result = glbk__ism_begin_spread(ctx, s, &s->receivers.target, &s->list, b);
    if (result != GLBK_OK) return result;
    (void)glbk_gbuffer_bind(ctx, seen, NULL);
    for (k = 0; k < 4; k++)
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_runs0 + k, &s->seen_sums[k].texture);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_runs4, &s->seen_sums[4].texture);
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

/* Measures triangles, and clusters of them. */
static glbk_result glbk__ism_measure(glbk_context *ctx, const glbk_ism_maps *m, glbk_ism_spread *s,
                                     glbk_ism_scattering *b)
{
    glbk_result result = glbk__ism_begin_spread(ctx, s, &s->sizes.target, &s->measure, b);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_triangles, &m->triangle_table);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_positions, &m->positions);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_receivers, &s->receivers.texture);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_runs4, &s->seen_sums[4].texture);
    glbk_draw_screen(ctx);
    result = glbk__ism_begin_spread(ctx, s, &s->masses.target, &s->gather, b);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_triangles, &m->triangle_table);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_positions, &m->positions);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_sizes, &s->sizes.texture);
    glbk_draw_screen(ctx);
    return glbk__ism_sum(ctx, s, b, &s->masses.texture, s->cluster_count, 0, s->totals, 3);
}

/* Draws the effects of clusters on the VPLs of a batch, and their sums. */
static glbk_result glbk__ism_weigh_pairs(glbk_context *ctx, const glbk_ism_maps *m, glbk_ism_spread *s,
                                         glbk_ism_scattering *b)
{
    const glbk_result result = glbk__ism_begin_spread(ctx, s, &s->effects.target, &s->weigh, b);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_vpls, &m->vpls);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_masses, &s->masses.texture);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_clusters, &s->clusters);
    glbk_draw_screen(ctx);
    return glbk__ism_sum(ctx, s, b, &s->effects.texture, s->cluster_count, 0, s->effect_totals, 3);
}

/* Draws the shares that clusters have of the surfels of a batch, and their running sums. */
static glbk_result glbk__ism_share(glbk_context *ctx, const glbk_ism_maps *m, glbk_ism_spread *s,
                                   glbk_ism_scattering *b)
{
    glbk_result result = b->pair ? glbk__ism_weigh_pairs(ctx, m, s, b) : GLBK_OK;
    if (result == GLBK_OK) result = glbk__ism_begin_spread(ctx, s, &s->shares.target, &s->share, b);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_masses, &s->masses.texture);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_totals, &s->totals[2].texture);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_values, &s->effects.texture);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_effect_totals, &s->effect_totals[2].texture);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_runs4, &s->seen_sums[4].texture);
    glbk_draw_screen(ctx);
    return glbk__ism_sum(ctx, s, b, &s->shares.texture, s->cluster_count, 1, s->share_sums, 3);
}

/* Binds what surfels are drawn from. */
static void glbk__ism_bind_shares(glbk_context *ctx, const glbk_ism_spread *s)
{
    uint32_t k;
    for (k = 0; k < 3; k++)
        glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_runs0 + k, &s->share_sums[k].texture);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_shares, &s->shares.texture);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_totals, &s->totals[2].texture);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_counts, &s->counts.texture);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_masses, &s->masses.texture);
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_sizes, &s->sizes.texture);
}

/* Draws the surfels of a phase and of a batch of VPLs, into the rows of the table's layers that hold them. */
static glbk_result glbk__ism_draw_surfels(glbk_context *ctx, const glbk_ism_maps *m, glbk_ism_spread *s,
                                          glbk_ism_scattering *b, uint32_t phase)
{
    const uint32_t layer_size = GLBK__ISM_LAYER, each = m->phase_surfel_count;
    const uint32_t base = m->compute ? phase * each * m->desc.vpl_count : 0;
    const uint32_t begin = base + b->first_vpl * each, end = begin + b->batch * each;
    const glbk_texture *table = m->compute ? &m->surfels : &m->phase_surfels[phase];
    glbk_pass pass;
    glbk_result result;
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
        result = glbk_begin(ctx, &pass, &s->scatter);
        if (result == GLBK_OK)
            result = glbk__put_block(ctx, GLBK_SLOT_glbk_ism_scattering, &s->block, b);
        if (result != GLBK_OK) return result;
        ctx->gl.FramebufferTextureLayer(GLBK_GL_DRAW_FRAMEBUFFER, GLBK_GL_COLOR_ATTACHMENT0, table->name, 0,
                                        (int32_t)layer);
        glbk__ism_bind_shares(ctx, s);
        glbk_draw_screen(ctx);
    }
    return GLBK_OK;
}

/* Returns the values of the block that all passes of a frame have in common. */
static glbk_ism_scattering glbk__ism_scattering_of(const glbk_ism_maps *m, const glbk_ism_spread *s,
                                                   uint32_t index)
{
    const ism_desc *d = &m->desc;
    glbk_ism_scattering b;
    memset(&b, 0, sizeof b);
    b.triangle_count = s->triangle_count;
    b.cluster_count = s->cluster_count;
    b.cluster_size = s->triangles_per_cluster;
    b.batch = s->batch;
    b.view_width = s->width;
    b.view_height = s->height;
    b.views = glbk__ism_views(d);
    b.pair = glbk__ism_by_pair(d) != 0;
    b.seed = d->seed;
    b.key = d->unstable ? glbk_ism__hash_combine(d->seed, index) : d->seed;
    b.surfel_count = d->surfel_count;
    b.phase_surfel_count = m->phase_surfel_count;
    b.lazy_frames = d->lazy_frames;
    b.vpl_capacity = d->vpl_count;
    b.vary_surfels = d->vary_surfels != 0;
    b.area_share = d->area_share > 0 ? d->area_share : 0.2f;
    return b;
}

/* Draws how many surfels VPLs have, and then batch by batch shares and surfels. */
static glbk_result glbk__ism_scatter_all(glbk_context *ctx, glbk_ism_maps *m, glbk_ism_spread *s,
                                         glbk_ism_scattering *b, uint32_t first, uint32_t end)
{
    glbk_result result = glbk__ism_begin_spread(ctx, s, &s->counts.target, &s->count, b);
    uint32_t vpl, phase;
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_ism_vpls, &m->vpls);
    glbk_bind_block(ctx, GLBK_SLOT_glbk_ism_frame, &m->frame);
    glbk_draw_screen(ctx);
    for (vpl = 0; vpl < m->desc.vpl_count && result == GLBK_OK; vpl += s->batch) {
        b->first_vpl = vpl;
        b->batch = m->desc.vpl_count - vpl < s->batch ? m->desc.vpl_count - vpl : s->batch;
        result = glbk__ism_share(ctx, m, s, b);
        for (phase = first; phase < end && result == GLBK_OK; phase++)
            result = glbk__ism_draw_surfels(ctx, m, s, b, phase);
    }
    return result;
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
    glbk_ism_scattering b;
    glbk_result result;
    uint32_t k, first, end;
    int all;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    result = glbk__ism_check_scatter(ctx, __func__, s, m, seen);
    if (result != GLBK_OK || !m->triangle_count) return result;
    all = m->desc.unstable || m->desc.vary_surfels;
    for (k = 0; k < m->desc.lazy_frames; k++) all = all || !(m->phases >> k & 1);
    first = all ? 0 : index % m->desc.lazy_frames;
    end = all ? m->desc.lazy_frames : first + 1;
    result = glbk__ism_hold_triangles(ctx, m, s);
    if (result == GLBK_OK && glbk__ism_views(&m->desc)) result = glbk__ism_hold_view(ctx, s, seen);
    if (result != GLBK_OK) return result;
    b = glbk__ism_scattering_of(m, s, index);
    if (b.views) result = glbk__ism_list_receivers(ctx, s, seen, &b);
    if (result == GLBK_OK) result = glbk__ism_measure(ctx, m, s, &b);
    if (result == GLBK_OK) result = glbk__ism_scatter_all(ctx, m, s, &b, first, end);
    if (result != GLBK_OK) return result;
    for (k = first; k < end; k++) m->phases |= (uint64_t)1 << k;
    return GLBK_OK;
}

GLBK_DEF void glbk_ism_spread_free(glbk_context *ctx, glbk_ism_spread *s)
{
    glbk_program *programs[9];
    uint32_t k;
    if (!s) return;
    programs[0] = &s->see;
    programs[1] = &s->list;
    programs[2] = &s->measure;
    programs[3] = &s->gather;
    programs[4] = &s->weigh;
    programs[5] = &s->share;
    programs[6] = &s->run;
    programs[7] = &s->count;
    programs[8] = &s->scatter;
    for (k = 0; k < 9; k++) glbk_program_free(ctx, programs[k]);
    glbk__ism_free_view(ctx, s);
    glbk__ism_free_triangles(ctx, s);
    glbk__ism_free_sheets(ctx, &s->counts, 1);
    glbk_target_free(ctx, &s->surfel_target);
    glbk_buffer_free(ctx, &s->block);
    memset(s, 0, sizeof *s);
}
