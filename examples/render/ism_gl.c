/* ism_gl.c - the technique ism on OpenGL: VPLs and surfels that ism.h chose go to gl_ism.h, which draws the maps and
   shades the G-buffer. */
#include "ism_parts.h"

#include <stdlib.h>
#include <string.h>

struct im_gl {
    glbk_context      *gl;
    glbk_gbuffer       seen;
    glbk_ism_renderer  renderer;
    glbk_ism_maps     *maps;             /* one a level */
    int               *stale;            /* 1: the mesh has moved since */
    int                count;
    ism_surfel        *surfels;          /* of one phase */
    const ex_gbuffer  *pixels;           /* that were uploaded last, for their albedos */
    float             *texels;           /* four floats of each pixel */
};

static int failed(const char *what, glbk_result result, char *error)
{
    snprintf(error, EX_ERROR_SIZE, "ism on GL: %s: %s", what, glbk_result_text(result));
    return -1;
}

glbk_ism_maps *im_gl_maps(im_gl *g, int level) { return &g->maps[level]; }
glbk_ism_renderer *im_gl_renderer(im_gl *g) { return &g->renderer; }
glbk_gbuffer *im_gl_gbuffer(im_gl *g) { return &g->seen; }

void im_gl_close(im_gl *g)
{
    if (!g)
        return;
    for (int i = 0; g->maps && i < g->count; i++)
        glbk_ism_maps_free(g->gl, &g->maps[i]);
    glbk_ism_renderer_free(g->gl, &g->renderer);
    glbk_gbuffer_free(g->gl, &g->seen);
    free(g->maps);
    free(g->stale);
    free(g->surfels);
    free(g->texels);
    free(g);
}

/* Everything that has the picture's size. */
static glbk_result open_picture(im_gl *g, uint32_t width, uint32_t height)
{
    const glbk_ism_renderer_desc size = { width, height };
    glbk_gbuffer_desc desc;
    glbk_result result;
    memset(&desc, 0, sizeof desc);
    desc.width = width;
    desc.height = height;
    g->texels = malloc(4 * (size_t)width * height * sizeof *g->texels);
    if (!g->texels)
        return GLBK_ERR_ALLOC;
    result = glbk_gbuffer_create(g->gl, &desc, &g->seen);
    return result == GLBK_OK ? glbk_ism_renderer_create(g->gl, &size, &g->renderer) : result;
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
    result = open_picture(g, job->gbuffer->width, job->gbuffer->height);
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

int im_gl_view(im_gl *g, const ex_gbuffer *b, char *error)
{
    glbk_pixel *row = calloc(b->width, sizeof *row);
    glbk_result result = row ? GLBK_OK : GLBK_ERR_ALLOC;
    g->pixels = b;
    for (uint32_t y = 0; y < b->height && result == GLBK_OK; y++) {
        for (uint32_t x = 0; x < b->width; x++) {
            const ex_pixel *from = &b->pixels[(size_t)y * b->width + x];
            memcpy(row[x].position, from->position, sizeof row[x].position);
            memcpy(row[x].normal, from->normal, sizeof row[x].normal);
            memcpy(row[x].geometric_normal, from->geometric, sizeof row[x].geometric_normal);
        }
        result = glbk_gbuffer_upload(g->gl, &g->seen, y, 1, row);
    }
    free(row);
    return result == GLBK_OK ? 0 : failed("G-buffer", result, error);
}

/* ---- maps ---- */

static glbk_result send_mesh(im_gl *g, int level, const ism_mesh *mesh, int fresh)
{
    glbk_ism_maps *m = &g->maps[level];
    int moved = g->stale[level];
    g->stale[level] = 0;
    if (fresh || m->vertex_count != mesh->vertex_count || 3 * (size_t)m->triangle_count != mesh->index_count)
        return glbk_ism_mesh_upload(g->gl, m, mesh);
    return moved && m->triangle_count ? glbk_ism_mesh_move(g->gl, m, mesh->positions, mesh->vertex_stride) : GLBK_OK;
}

/* The phase that this frame renewed, or all where others have changed, too. */
static glbk_result send_surfels(im_gl *g, int level, const ism_maps *maps, uint32_t index)
{
    glbk_ism_maps *m = &g->maps[level];
    const uint32_t phases = m->desc.lazy_frames, first = index % phases, each = m->desc.surfel_count;
    const uint64_t due = (uint64_t)m->desc.vpl_count * (each > first ? (each - first - 1) / phases + 1 : 0);
    uint64_t all = phases == 64 ? ~(uint64_t)0 : ((uint64_t)1 << phases) - 1;
    glbk_result result = GLBK_OK;
    ism_info info;
    int whole;
    ism_get_info(maps, &info);
    whole = m->phases != all || m->desc.vary_surfels || info.stats.renewed != due;
    for (uint32_t phase = 0; phase < phases && result == GLBK_OK; phase++) {
        size_t count = (size_t)m->desc.vpl_count * m->phase_surfel_count;
        if (!whole && phase != first)
            continue;
        if (ism_phase_surfels(maps, phase, g->surfels, count, &count) != ISM_OK)
            return GLBK_ERR_ARGUMENT;
        result = glbk_ism_surfels_upload(g->gl, m, phase, g->surfels, count);
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
    if (!(info.radius > 0)) info.radius = 1;        /* without maps nothing was scattered: no sphere is drawn */
    result = glbk_ism_vpls_upload(g->gl, &g->maps[level], from, (uint32_t)count, &info);
    if (result != GLBK_OK)
        return result;
    points = ism_near_points(maps, &count);
    return glbk_ism_near_points_upload(g->gl, &g->maps[level], points, (uint32_t)count);
}

/* Sizes of all levels are equal, for they come from the same settings; but the ground's, opened last, is smaller. */
static glbk_result open_level(im_gl *g, int level, const ism_desc *d)
{
    glbk_ism_maps *m = &g->maps[level];
    glbk_result result = glbk_ism_maps_create(g->gl, d, m);
    if (result == GLBK_OK && !g->surfels)
        g->surfels = malloc((size_t)m->desc.vpl_count * m->phase_surfel_count * sizeof *g->surfels);
    return result == GLBK_OK && !g->surfels ? GLBK_ERR_ALLOC : result;
}

int im_gl_draw(im_gl *g, int level, const ism_desc *desc, const ism_maps *maps, const ism_frame *frame, int no_maps,
               char *error)
{
    int fresh = !g->maps[level].vpls.name;
    ism_info info;
    glbk_result result = fresh ? open_level(g, level, desc) : GLBK_OK;
    ism_get_info(maps, &info);
    if (result == GLBK_OK)
        result = send_vpls(g, level, maps);
    if (result == GLBK_OK && !no_maps) {
        result = send_mesh(g, level, frame->mesh, fresh);
        if (result == GLBK_OK && info.stats.surfels)
            result = send_surfels(g, level, maps, frame->index);
        if (result == GLBK_OK && !info.stats.surfels)
            result = glbk_ism_mesh_upload(g->gl, &g->maps[level], NULL);
        if (result == GLBK_OK)
            result = glbk_ism_draw(g->gl, &g->maps[level], 0);
        g->gl->gl.Finish();
    }
    return result == GLBK_OK ? 0 : failed("maps", result, error);
}

/* Share of the light that the rule near by took off, as ism_shade sums it: before the blur, by the fourth channel. */
static glbk_result read_lost(im_gl *g, double *share)
{
    const uint32_t w = g->renderer.width, h = g->renderer.height;
    const size_t count = (size_t)w * h;
    double lost = 0, kept = 0;
    glbk_result result = glbk_target_read(g->gl, &g->renderer.light_target, 0, 0, 0, w, h, g->texels);
    for (size_t i = 0; i < count && result == GLBK_OK; i++) {
        const float *t = g->texels + 4 * i;
        kept += ((double)t[0] + (double)t[1] + (double)t[2]) / 3;
        lost += (double)t[3];
    }
    *share = lost > 0 ? lost / (lost + kept) : 0;
    return result;
}

/* Irradiances to radiances of the pixels' diffuse colours, as ism_shade does it. */
static glbk_result read_light(im_gl *g, float *light)
{
    const size_t count = (size_t)g->renderer.width * g->renderer.height;
    const glbk_result result = glbk_ism_read(g->gl, &g->renderer, g->texels);
    for (size_t i = 0; i < count && result == GLBK_OK; i++)
        for (size_t k = 0; k < 3; k++) {
            const float albedo = g->pixels->pixels[i].albedo[k];
            light[3 * i + k] = g->texels[4 * i + k] * (albedo > 0 ? albedo * 0.318309886f : 0);
        }
    return result;
}

int im_gl_shade(im_gl *g, int level, const ism_shading *shading, float *light, double *lost, char *error)
{
    glbk_result result = glbk_ism_shade(g->gl, &g->renderer, &g->seen, &g->maps[level], shading, 0);
    *lost = 0;
    if (result == GLBK_OK)
        result = read_light(g, light);
    if (result == GLBK_OK && shading->near_mode != ISM_NEAR_NONE)
        result = read_lost(g, lost);
    return result == GLBK_OK ? 0 : failed("shading", result, error);
}
