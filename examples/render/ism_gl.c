/* ism_gl.c - the technique ism on OpenGL: VPLs and surfels that ism.h chose go to gl_ism.h, which draws the maps and
   shades the G-buffer. */
#include "ism_parts.h"

#include <stdlib.h>
#include <string.h>

struct im_gl {
    glbk_context      *gl;
    glbk_ism_renderer  renderer;
    glbk_ism_maps     *maps;             /* one a level */
    int               *stale;            /* 1: the mesh has moved since */
    int                count;
    ism_surfel        *points;           /* of one phase */
};

static int failed(const char *what, glbk_result result, char *error)
{
    snprintf(error, EX_ERROR_SIZE, "ism on GL: %s: %s", what, glbk_result_text(result));
    return -1;
}

glbk_ism_maps *im_gl_maps(im_gl *g, int level) { return &g->maps[level]; }
glbk_ism_renderer *im_gl_renderer(im_gl *g) { return &g->renderer; }

void im_gl_close(im_gl *g)
{
    if (!g)
        return;
    for (int i = 0; g->maps && i < g->count; i++)
        glbk_ism_maps_free(g->gl, &g->maps[i]);
    glbk_ism_renderer_free(g->gl, &g->renderer);
    free(g->maps);
    free(g->stale);
    free(g->points);
    free(g);
}

im_gl *im_gl_open(const rd_job *job, int levels, char *error)
{
    im_gl *g = calloc(1, sizeof *g);
    glbk_result result;
    if (g) {
        g->gl = job->gl;
        g->count = levels;
        g->maps = calloc((size_t)levels, sizeof *g->maps);
        g->stale = calloc((size_t)levels, sizeof *g->stale);
    }
    if (!g || !g->maps || !g->stale) {
        im_gl_close(g);
        im_out_of_memory(error);
        return NULL;
    }
    result = glbk_ism_renderer_create(g->gl, job->gbuffer->width, job->gbuffer->height, &g->renderer);
    if (result == GLBK_OK)
        return g;
    failed("G-buffer", result, error);
    im_gl_close(g);
    return NULL;
}

void im_gl_moved(im_gl *g)
{
    for (int i = 0; i < g->count; i++)
        g->stale[i] = 1;
}

int im_gl_view(im_gl *g, const ism_points *view, char *error)
{
    glbk_ism_receivers r = { view->positions, view->normals, view->geometric_normals, view->albedos,
                             view->position_stride };
    glbk_result result = glbk_ism_gbuffer_upload(g->gl, &g->renderer, &r);
    return result == GLBK_OK ? 0 : failed("G-buffer", result, error);
}

/* ---- maps ---- */

static glbk_result send_mesh(im_gl *g, int level, const ism_mesh *mesh, int fresh)
{
    glbk_ism_maps *m = &g->maps[level];
    int moved = g->stale[level];
    g->stale[level] = 0;
    if (fresh || m->vertices != mesh->vertex_count || 3 * (size_t)m->triangles != mesh->index_count)
        return glbk_ism_mesh_upload(g->gl, m, mesh);
    return moved && m->triangles ? glbk_ism_mesh_move(g->gl, m, mesh->positions, mesh->vertex_stride) : GLBK_OK;
}

/* The phase that this frame renewed, or all where all were. */
static glbk_result send_points(im_gl *g, int level, const ism_maps *maps, uint32_t index)
{
    glbk_ism_maps *m = &g->maps[level];
    uint64_t all = m->desc.lazy == 64 ? ~(uint64_t)0 : ((uint64_t)1 << m->desc.lazy) - 1;
    glbk_result result = GLBK_OK;
    ism_info info;
    ism_get_info(maps, &info);
    for (uint32_t phase = 0; phase < m->desc.lazy && result == GLBK_OK; phase++) {
        size_t count = (size_t)m->desc.vpl_count * m->each;
        if (m->phases == all && info.stats.renewed < info.stats.surfels && phase != index % m->desc.lazy)
            continue;
        if (ism_phase_surfels(maps, phase, g->points, count, &count) != ISM_OK)
            return GLBK_ERR_ARGUMENT;
        result = glbk_ism_phase(g->gl, m, phase, g->points);
    }
    return result;
}

static glbk_result send_vpls(im_gl *g, int level, const ism_maps *maps)
{
    size_t count;
    const ism_vpl *from = ism_vpls(maps, &count);
    const ism_near_point *points;
    ism_info info;
    glbk_result result;
    ism_get_info(maps, &info);
    result = glbk_ism_vpls_upload(g->gl, &g->maps[level], from, (uint32_t)count, info.center,
                                  info.radius > 0 ? info.radius : 1);
    if (result != GLBK_OK)
        return result;
    points = ism_near_points(maps, &count);
    return glbk_ism_near_upload(g->gl, &g->maps[level], points, (uint32_t)count);
}

/* Sizes of all levels are equal, for they come from the same settings; but the ground's, opened last, is smaller. */
static glbk_result open_level(im_gl *g, int level, const ism_desc *d)
{
    glbk_ism_desc to;
    memset(&to, 0, sizeof to);
    to.vpl_count = d->vpl_count;
    to.points = d->surfel_count;
    to.tile_size = d->tile_side;
    to.projection = (uint32_t)d->projection;
    to.lazy = d->lazy_frames;
    to.splat_scale = d->splat_scale;
    to.no_fill = d->no_fill;
    to.near_points = d->near_point_count > 0 ? (uint32_t)d->near_point_count : 1;
    to.window_rim = d->window_rim > 0 ? (uint32_t)d->window_rim : 0;
    if (!g->points)
        g->points = malloc(d->vpl_count * (size_t)((d->surfel_count + d->lazy_frames - 1) / d->lazy_frames) *
                           sizeof *g->points);
    if (!g->points)
        return GLBK_ERR_ALLOC;
    return glbk_ism_maps_create(g->gl, &to, &g->maps[level]);
}

int im_gl_draw(im_gl *g, int level, const ism_desc *desc, const ism_maps *maps, const ism_frame *frame, int no_maps,
               char *error)
{
    int fresh = !g->maps[level].points.name;
    ism_info info;
    glbk_result result = fresh ? open_level(g, level, desc) : GLBK_OK;
    ism_get_info(maps, &info);
    if (result == GLBK_OK)
        result = send_vpls(g, level, maps);
    if (result == GLBK_OK && !no_maps) {
        result = send_mesh(g, level, frame->mesh, fresh);
        if (result == GLBK_OK && info.stats.surfels)
            result = send_points(g, level, maps, frame->index);
        if (result == GLBK_OK && !info.stats.surfels)
            result = glbk_ism_mesh_upload(g->gl, &g->maps[level], NULL);
        if (result == GLBK_OK)
            result = glbk_ism_draw(g->gl, &g->maps[level]);
        g->gl->gl.Finish();
    }
    return result == GLBK_OK ? 0 : failed("maps", result, error);
}

/* Share of the light that the rule near by took off, as ism_shade sums it: before the blur, by the fourth channel. */
static glbk_result read_lost(im_gl *g, double *share)
{
    const uint32_t w = g->renderer.width, h = g->renderer.height;
    const size_t count = (size_t)w * h;
    float *texels = malloc(4 * count * sizeof *texels);
    double lost = 0, kept = 0;
    glbk_result result =
        texels ? glbk_target_read(g->gl, &g->renderer.light_target, 0, 0, 0, w, h, texels) : GLBK_ERR_ALLOC;
    for (size_t i = 0; i < count && result == GLBK_OK; i++) {
        const float *t = texels + 4 * i;
        kept += ((double)t[0] + (double)t[1] + (double)t[2]) / 3;
        lost += (double)t[3];
    }
    *share = lost > 0 ? lost / (lost + kept) : 0;
    free(texels);
    return result;
}

int im_gl_shade(im_gl *g, int level, const ism_shading *shading, float *light, double *lost, char *error)
{
    glbk_ism_shading s;
    glbk_result result;
    *lost = 0;
    memset(&s, 0, sizeof s);
    s.pattern = shading->pattern;
    s.near_mode = (uint32_t)shading->near_mode;
    s.clamp = shading->clamp;
    s.bias = shading->bias > 0 ? shading->bias : 0;
    s.no_maps = shading->no_maps;
    result = glbk_ism_shade(g->gl, &g->renderer, &g->maps[level], &s);
    if (result == GLBK_OK)
        result = glbk_ism_read_light(g->gl, &g->renderer, light);
    if (result == GLBK_OK && shading->near_mode != ISM_NEAR_NONE)
        result = read_lost(g, lost);
    return result == GLBK_OK ? 0 : failed("shading", result, error);
}
