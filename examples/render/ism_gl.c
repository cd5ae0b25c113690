/* ism_gl.c - the technique ism on OpenGL: VPLs and points that ism.h chose go to gl_backend.h, which draws the maps and
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
    ism_point         *points;           /* of one phase */
    glbk_ism_vpl      *vpls;
};

static int failed(im_gl *g, const char *what, glbk_result result, char *error)
{
    snprintf(error, EX_ERROR_SIZE, "ism on GL: %s: %s %.120s", what, glbk_result_text(result), g->gl->log);
    return -1;
}

glbk_ism_maps *im_gl_maps(im_gl *g, int level) { return &g->maps[level]; }
glbk_ism_renderer *im_gl_renderer(im_gl *g) { return &g->renderer; }

void im_gl_close(im_gl *g)
{
    if (!g)
        return;
    for (int i = 0; g->maps && i < g->count; i++)
        glbk_ism_maps_destroy(g->gl, &g->maps[i]);
    glbk_ism_renderer_destroy(g->gl, &g->renderer);
    free(g->maps);
    free(g->stale);
    free(g->points);
    free(g->vpls);
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
    failed(g, "G-buffer", result, error);
    im_gl_close(g);
    return NULL;
}

void im_gl_moved(im_gl *g)
{
    for (int i = 0; i < g->count; i++)
        g->stale[i] = 1;
}

int im_gl_view(im_gl *g, const ism_view *view, char *error)
{
    glbk_ism_receivers r = { view->positions, view->normals, view->geometric, view->albedos, view->stride };
    glbk_result result = glbk_ism_gbuffer_upload(g->gl, &g->renderer, &r);
    return result == GLBK_OK ? 0 : failed(g, "G-buffer", result, error);
}

/* ---- maps ---- */

static glbk_result send_mesh(im_gl *g, int level, const ism_mesh *mesh, int fresh)
{
    glbk_ism_maps *m = &g->maps[level];
    glbk_ism_mesh to = { mesh->positions, mesh->vertex_count, mesh->vertex_stride, mesh->indices, mesh->index_count,
                         mesh->opacities };
    int moved = g->stale[level];
    g->stale[level] = 0;
    if (fresh || m->vertices != mesh->vertex_count || 3 * (size_t)m->triangles != mesh->index_count)
        return glbk_ism_mesh_upload(g->gl, m, &to);
    return moved && m->triangles ? glbk_ism_mesh_move(g->gl, m, mesh->positions, mesh->vertex_stride) : GLBK_OK;
}

/* The phase that this frame renewed, or all where all were. */
static glbk_result send_points(im_gl *g, int level, const ism_maps *maps, uint32_t index)
{
    glbk_ism_maps *m = &g->maps[level];
    uint64_t all = m->desc.lazy == 64 ? ~(uint64_t)0 : ((uint64_t)1 << m->desc.lazy) - 1;
    glbk_result result = GLBK_OK;
    ism_stats stats;
    ism_get_stats(maps, &stats);
    for (uint32_t phase = 0; phase < m->desc.lazy && result == GLBK_OK; phase++) {
        size_t count = (size_t)m->desc.vpl_count * m->each;
        if (m->phases == all && stats.renewed < stats.points && phase != index % m->desc.lazy)
            continue;
        if (ism_phase_points(maps, phase, g->points, count, &count) != ISM_OK)
            return GLBK_ERR_ARGUMENT;
        result = glbk_ism_phase(g->gl, m, phase, g->points);
    }
    return result;
}

static glbk_result send_vpls(im_gl *g, int level, const ism_maps *maps)
{
    size_t count, i;
    const ism_vpl *from = ism_vpls(maps, &count);
    const ism_near_point *points;
    float center[3], radius;
    glbk_result result;
    for (i = 0; i < count; i++) {
        glbk_ism_vpl *to = &g->vpls[i];
        memcpy(to->position, from[i].position, sizeof to->position);
        memcpy(to->normal, from[i].normal, sizeof to->normal);
        memcpy(to->flux, from[i].flux, sizeof to->flux);
        memcpy(to->axis, from[i].axis, sizeof to->axis);
        to->exponent = from[i].exponent;
        to->side = from[i].side;
        to->directional = from[i].directional;
        to->reach = from[i].reach;
        to->window = from[i].window;
    }
    ism_bounds(maps, center, &radius);
    result = glbk_ism_vpls_upload(g->gl, &g->maps[level], g->vpls, (uint32_t)count, center, radius > 0 ? radius : 1);
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
    to.points = d->points;
    to.tile_size = d->tile_size;
    to.projection = (uint32_t)d->projection;
    to.lazy = d->lazy;
    to.splat_scale = d->splat_scale;
    to.no_fill = d->no_fill;
    to.near_points = d->near_points;
    to.window_rim = d->window_rim;
    if (!g->vpls)
        g->vpls = malloc(d->vpl_count * sizeof *g->vpls);
    if (!g->points)
        g->points = malloc(d->vpl_count * (size_t)((d->points + d->lazy - 1) / d->lazy) * sizeof *g->points);
    if (!g->vpls || !g->points)
        return GLBK_ERR_ALLOC;
    return glbk_ism_maps_create(g->gl, &to, &g->maps[level]);
}

int im_gl_draw(im_gl *g, int level, const ism_desc *desc, const ism_maps *maps, const ism_frame *frame, int no_maps,
               char *error)
{
    int fresh = !g->maps[level].points.name;
    ism_stats stats;
    glbk_result result = fresh ? open_level(g, level, desc) : GLBK_OK;
    ism_get_stats(maps, &stats);
    if (result == GLBK_OK)
        result = send_vpls(g, level, maps);
    if (result == GLBK_OK && !no_maps) {
        result = send_mesh(g, level, frame->mesh, fresh);
        if (result == GLBK_OK && stats.points)
            result = send_points(g, level, maps, frame->index);
        if (result == GLBK_OK && !stats.points)
            result = glbk_ism_mesh_upload(g->gl, &g->maps[level], NULL);
        if (result == GLBK_OK)
            result = glbk_ism_draw(g->gl, &g->maps[level]);
        g->gl->gl.Finish();
    }
    return result == GLBK_OK ? 0 : failed(g, "maps", result, error);
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
    s.bias = shading->bias;
    s.no_maps = shading->no_maps;
    result = glbk_ism_shade(g->gl, &g->renderer, &g->maps[level], &s);
    if (result == GLBK_OK)
        result = glbk_ism_read_light(g->gl, &g->renderer, light);
    if (result == GLBK_OK && shading->near_mode != ISM_NEAR_NONE)
        result = read_lost(g, lost);
    return result == GLBK_OK ? 0 : failed(g, "shading", result, error);
}
