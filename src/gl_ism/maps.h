/* ---- ism: maps: their tables, pictures and programs ---- */

/* Makes objects one after the other. After the first error no more are made. */
typedef struct glbk__ism_making {
    glbk_context *ctx;
    glbk_result   result;           /* of all that were made so far */
    const char   *defines;          /* of programs; NULL = none */
} glbk__ism_making;

static glbk__ism_making glbk__ism_begin_making(glbk_context *ctx)
{
    glbk__ism_making k;
    k.ctx = ctx;
    k.result = GLBK_OK;
    k.defines = NULL;
    return k;
}

/* Makes a program, which may read a G-buffer. */
static void glbk__ism_make_program(glbk__ism_making *k, const char *name, glbk_program *out)
{
    if (k->result == GLBK_OK)
        k->result = glbk__gbuffer_program(k->ctx, glbk_ism_part(), name, k->defines, out);
}

/* Makes a picture of a format and its target. */
static void glbk__ism_make_canvas(glbk__ism_making *k, glbk_format format, uint32_t width, uint32_t height,
                                  const glbk_texture *depth, glbk_texture *texture, glbk_target *target)
{
    if (k->result == GLBK_OK)
        k->result = glbk__canvas(k->ctx, format, width, height, depth, texture, target);
}

static void glbk__ism_make_table(glbk__ism_making *k, glbk_format format, const void *texels, size_t count,
                                 glbk_texture *out)
{
    if (k->result == GLBK_OK) k->result = glbk__table_create(k->ctx, format, texels, count, out);
}

static void glbk__ism_make_block(glbk__ism_making *k, size_t bytes, glbk_buffer *out)
{
    if (k->result == GLBK_OK) k->result = glbk_buffer_create(k->ctx, bytes, NULL, out);
}

/* Makes the picture of the triangles that surfels lie on, and draws it together with the planes. */
static void glbk__ism_make_hits(glbk__ism_making *k, glbk_ism_maps *m)
{
    glbk_texture_desc d;
    glbk_target_desc t;
    memset(&d, 0, sizeof d);
    memset(&t, 0, sizeof t);
    d.format = GLBK_FORMAT_R32UI;
    d.width = d.height = m->side;
    t.color[0] = &m->planes;
    t.color[1] = &m->hits;
    t.depth = &m->depth;
    if (k->result != GLBK_OK) return;
    glbk_target_free(k->ctx, &m->plane_target);
    k->result = glbk_texture_create(k->ctx, &d, &m->hits);
    if (k->result == GLBK_OK) k->result = glbk__target_create(k->ctx, &t, &m->plane_target);
}

/* Makes the pictures that both paths draw to: the planes of surfels, and the atlas. */
static void glbk__ism_make_canvases(glbk__ism_making *k, glbk_ism_maps *m)
{
    glbk_texture_desc d;
    memset(&d, 0, sizeof d);
    d.format = GLBK_FORMAT_DEPTH32F;
    d.width = d.height = m->side;
    if (!m->compute && k->result == GLBK_OK) k->result = glbk_texture_create(k->ctx, &d, &m->depth);
    glbk__ism_make_canvas(k, GLBK_FORMAT_COLOR, m->side, m->side, m->compute ? NULL : &m->depth, &m->planes,
                          &m->plane_target);
    if (m->desc.keep_hits) glbk__ism_make_hits(k, m);
    glbk__ism_make_canvas(k, GLBK_FORMAT_R32UI, m->side, m->side, NULL, &m->atlas, &m->atlas_target);
}

/* Makes pictures and programs that take the core path from surfels to the atlas: kept texels, levels of pull,
   push. */
static void glbk__ism_make_fill(glbk__ism_making *k, glbk_ism_maps *m)
{
    const char *projection = k->defines;
    char defines[] = "ISM_LEVEL=1";
    const uint32_t side = m->side;
    uint32_t i;
    glbk__ism_make_canvas(k, GLBK_FORMAT_R8UI, side, side, NULL, &m->kept, &m->kept_target);
    glbk__ism_make_program(k, "ism_holes.frag", &m->holes);
    glbk__ism_make_program(k, "ism_push.frag", &m->push);
    k->defines = defines;
    for (i = 0; i < GLBK_ISM_LEVELS; i++) {
        const uint32_t coarse = side >> (i + 1);
        glbk__ism_make_canvas(k, GLBK_FORMAT_R32UI, coarse, coarse, NULL, &m->pull[i], &m->pull_target[i]);
        defines[10] = (char)('1' + (int)i);
        glbk__ism_make_program(k, "ism_pull.frag", &m->pull_program[i]);
    }
    k->defines = projection;
}

/* Compiles all programs that maps need. */
static void glbk__ism_make_programs(glbk__ism_making *k, glbk_ism_maps *m)
{
    char defines[] = "ISM_PROJECTION=1 ISM_QUADS=0 ISM_HITS=0";
    m->quads = !m->compute && k->ctx->max_point_side < (float)m->desc.tile_side;
    defines[15] = (char)('0' + (int)m->desc.projection);
    defines[27] = m->quads ? '1' : '0';
    defines[38] = m->desc.keep_hits ? '1' : '0';
    k->defines = defines;
    glbk__ism_make_program(k, m->compute ? "ism_splat.comp" : "ism_splat.frag", &m->splat);
    if (m->compute) glbk__ism_make_program(k, "ism_fill.comp", &m->fill);
    else glbk__ism_make_fill(k, m);
    k->defines = NULL;
}

/* Returns how many levels pull and push have. The coarsest has at least two cells a side of a tile. */
static uint32_t glbk__ism_levels(const glbk_ism_maps *m)
{
    uint32_t levels = m->desc.no_fill ? 0 : GLBK_ISM_LEVELS;
    while (levels && m->desc.tile_side >> levels < 2) levels--;
    return levels;
}

/* Returns how many texels of the table of VPLs lie before the spheres of the near points. */
static uint32_t glbk__ism_vpl_texels(const glbk_ism_maps *m) { return 4 * m->desc.vpl_count; }

/* Returns how many texels the spheres of the near points have. */
static uint32_t glbk__ism_spheres(const glbk_ism_maps *m)
{
    return (m->desc.vpl_count * (uint32_t)m->desc.near_point_count + 63) / 64;
}

/* Returns the values of the maps' uniform block. */
static glbk_ism_frame glbk__ism_frame_of(const glbk_ism_maps *m)
{
    glbk_ism_frame f;
    memset(&f, 0, sizeof f);
    f.vpl_count = m->vpl_count;
    f.tile_side = m->desc.tile_side;
    f.tiles_across = m->tiles_across;
    f.surfel_count = m->phase_surfel_count * m->desc.lazy_frames;
    f.vpl_capacity = m->desc.vpl_count;
    f.phase_surfel_count = m->phase_surfel_count;
    f.fill_levels = glbk__ism_levels(m);
    f.triangle_count = m->triangle_count;
    memcpy(f.sphere, m->sphere, sizeof f.sphere);
    f.splat_scale = m->desc.splat_scale;
    f.window_rim = (uint32_t)m->desc.window_rim;
    f.near_point_count = m->near_point_count;
    f.first_sphere = glbk__ism_vpl_texels(m);
    f.first_near_point = f.first_sphere + glbk__ism_spheres(m);
    return f;
}

/* Uploads the maps' uniform block. */
static glbk_result glbk__ism_write_frame(glbk_context *ctx, const glbk_ism_maps *m)
{
    const glbk_ism_frame f = glbk__ism_frame_of(m);
    return glbk_buffer_update(ctx, &m->frame, 0, sizeof f, &f);
}

/* Makes the tables of surfels. By compute there is one, since a dispatch reads all phases. On the core path
   each phase has its own: a phase is written while the frame before may still be drawn, and drivers then copy
   the whole texture. */
static void glbk__ism_make_surfels(glbk__ism_making *k, glbk_ism_maps *m)
{
    const size_t count = (size_t)m->desc.vpl_count * m->phase_surfel_count;
    const uint32_t phases = m->desc.lazy_frames;
    uint32_t i;
    if (m->compute) glbk__ism_make_table(k, GLBK_FORMAT_RGBA32UI, NULL, count * phases, &m->surfels);
    for (i = 0; i < phases && !m->compute; i++)
        glbk__ism_make_table(k, GLBK_FORMAT_RGBA32UI, NULL, count, &m->phase_surfels[i]);
}

/* Decides how large the atlas is and how many surfels a phase has. Returns GLBK_ERR_LIMIT if the atlas is too
   large. 16384 VPLs with 65536 surfels each are below 2^31, rounded up to phases too. */
static glbk_result glbk__ism_lay_out(const glbk_context *ctx, const char *function, glbk_ism_maps *m)
{
    const ism_desc *d = &m->desc;
    for (m->tiles_across = 1; m->tiles_across * m->tiles_across < d->vpl_count; m->tiles_across++) {}
    m->side = m->tiles_across * d->tile_side;
    m->phase_surfel_count = (d->surfel_count + d->lazy_frames - 1) / d->lazy_frames;
    /* ism_splat.comp counts the surfels of a VPL in 16 bits, and keeps no hits. */
    m->compute = ctx->compute && !d->keep_hits && m->phase_surfel_count * d->lazy_frames <= 65536;
    if (m->side <= ctx->max_side) return GLBK_OK;
    return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, function, "the atlas's side, of all VPLs' tiles,",
                              m->side, 8, ctx->max_side);
}

/* Makes all tables, pictures, blocks and programs of maps that are laid out. */
static glbk_result glbk__ism_create_all(glbk_context *ctx, glbk_ism_maps *m)
{
    static const uint32_t nothing[4] = { 0, 0, 0, 0 };
    const size_t vpls = m->desc.vpl_count, near_points = 3 * vpls * (size_t)m->desc.near_point_count;
    const size_t texels = glbk__ism_vpl_texels(m) + glbk__ism_spheres(m) + near_points;
    glbk__ism_making k = glbk__ism_begin_making(ctx);
    glbk__ism_make_surfels(&k, m);
    glbk__ism_make_table(&k, GLBK_FORMAT_RGBA32UI, NULL, texels, &m->vpls);
    glbk__ism_make_table(&k, GLBK_FORMAT_RGBA32UI, nothing, 1, &m->triangle_table);
    glbk__ism_make_table(&k, GLBK_FORMAT_RGBA32F, nothing, 1, &m->positions);
    glbk__ism_make_table(&k, GLBK_FORMAT_RGBA32F, nothing, 1, &m->albedos);
    glbk__ism_make_block(&k, sizeof(glbk_ism_frame), &m->frame);
    glbk__ism_make_block(&k, sizeof(glbk_ism_view), &m->view);
    glbk__ism_make_canvases(&k, m);
    glbk__ism_make_programs(&k, m);
    return k.result == GLBK_OK ? glbk__leave_created(ctx, glbk__ism_write_frame(ctx, m)) : k.result;
}

GLBK_DEF glbk_result glbk_ism_maps_create(glbk_context *ctx, const ism_desc *desc, glbk_ism_maps *out)
{
    glbk_result result = glbk__enter_create(ctx, __func__, out, sizeof *out);
    if (result != GLBK_OK) return result;
    if (desc) out->desc = *desc;
    result = glbk__ism_check_desc(ctx, __func__, &out->desc);
    glbk__ism_resolve(&out->desc);
    if (result == GLBK_OK) result = glbk__ism_lay_out(ctx, __func__, out);
    if (result == GLBK_OK) result = glbk__ism_create_all(ctx, out);
    if (result != GLBK_OK) glbk_ism_maps_free(ctx, out);
    return result;
}

GLBK_DEF void glbk_ism_maps_free(glbk_context *ctx, glbk_ism_maps *m)
{
    uint32_t i;
    if (!m) return;
    for (i = 0; i < GLBK_ISM_LEVELS; i++) {
        glbk_program_free(ctx, &m->pull_program[i]);
        glbk_target_free(ctx, &m->pull_target[i]);
        glbk_texture_free(ctx, &m->pull[i]);
    }
    glbk_program_free(ctx, &m->splat);
    glbk_program_free(ctx, &m->holes);
    glbk_program_free(ctx, &m->push);
    glbk_program_free(ctx, &m->fill);
    glbk_target_free(ctx, &m->plane_target);
    glbk_target_free(ctx, &m->kept_target);
    glbk_target_free(ctx, &m->atlas_target);
    glbk_texture_free(ctx, &m->vpls);
    glbk_texture_free(ctx, &m->surfels);
    for (i = 0; i < 64; i++) glbk_texture_free(ctx, &m->phase_surfels[i]);
    glbk_texture_free(ctx, &m->triangle_table);
    glbk_texture_free(ctx, &m->positions);
    glbk_texture_free(ctx, &m->albedos);
    glbk_texture_free(ctx, &m->planes);
    glbk_texture_free(ctx, &m->hits);
    glbk_texture_free(ctx, &m->depth);
    glbk_texture_free(ctx, &m->kept);
    glbk_texture_free(ctx, &m->atlas);
    glbk_buffer_free(ctx, &m->frame);
    glbk_buffer_free(ctx, &m->view);
    memset(m, 0, sizeof *m);
}
