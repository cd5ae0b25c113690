/* envshadow_gl.c - the technique envshadow on OpenGL: lights of envlights.h, matrices of envshadow.h, maps and
   shading by gl_envshadow.h, for the G-buffer that the CPU rendered. */
#include "envshadow_parts.h"
#include "../../gl_backend/gl_envshadow.h"

#include <stdlib.h>
#include <string.h>

/* A caster's buffers; those of casters with the same mesh are the first one's. */
typedef struct caster { uint32_t vertex_array, buffers[2], same_as; int32_t indices; } caster;

struct es_gl {
    glbk_context       *gl;
    glbk_envsh_maps     maps;
    glbk_gbuffer        seen;
    glbk_envsh_renderer renderer;
    caster             *casters;
    uint32_t            count;
    const es_state     *state;
    float              *picture;     /* rgba */
};

static int gl_failed(glbk_result result, char *error)
{
    snprintf(error, EX_ERROR_SIZE, "envshadow on GL: %s", glbk_result_text(result));
    return -1;
}

/* ---- casters ---- */

static void upload(es_gl *g, caster *c, const envsh_mesh *mesh)
{
    const glbk_functions *gl = &g->gl->gl;
    if (!c->vertex_array) {
        gl->GenVertexArrays(1, &c->vertex_array);
        gl->GenBuffers(2, c->buffers);
    }
    gl->BindVertexArray(c->vertex_array);
    gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, c->buffers[0]);
    gl->BufferData(GLBK_GL_ARRAY_BUFFER, (ptrdiff_t)(12 * mesh->vertex_count), mesh->positions, GLBK_GL_STATIC_DRAW);
    gl->BindBuffer(GLBK_GL_ELEMENT_ARRAY_BUFFER, c->buffers[1]);
    gl->BufferData(GLBK_GL_ELEMENT_ARRAY_BUFFER, (ptrdiff_t)(4 * mesh->index_count), mesh->indices,
                   GLBK_GL_STATIC_DRAW);
    gl->EnableVertexAttribArray(0);
    gl->VertexAttribPointer(0, 3, GLBK_GL_FLOAT, 0, 0, NULL);
    gl->BindVertexArray(0);
    c->indices = (int32_t)mesh->index_count;
}

static int upload_all(es_state *s, int only_moving, char *error)
{
    es_gl *g = s->gl;
    for (uint32_t i = 0; i < g->count; i++) {
        caster *c = &g->casters[i];
        const envsh_mesh *mesh = &s->casters[i].mesh;
        if (only_moving && !s->casters[i].moves)
            continue;
        if (mesh->index_count > INT32_MAX)
            return es_refuse("a mesh has too many triangles for GL", error);
        for (c->same_as = 0; s->casters[c->same_as].mesh.positions != mesh->positions; c->same_as++) {}
        if (c->same_as == i)
            upload(g, c, mesh);
    }
    return 0;
}

int es_gl_update(es_state *s, char *error) { return upload_all(s, 1, error); }

static glbk_result draw(void *user, glbk_context *gl, glbk_envsh_maps *maps, uint32_t instances)
{
    const es_gl *g = user;
    glbk_result result = GLBK_OK;
    for (uint32_t i = 0; i < g->count && result == GLBK_OK; i++) {
        const caster *c = &g->casters[g->casters[i].same_as];
        result = glbk_envsh_cast(gl, maps, g->state->casters[i].transform);
        gl->gl.BindVertexArray(c->vertex_array);
        gl->gl.DrawElementsInstanced(GLBK_GL_TRIANGLES, c->indices, GLBK_GL_UNSIGNED_INT, NULL, (int32_t)instances);
    }
    return result;
}

/* ---- G-buffer ---- */

/* The viewer's size changes. */
static glbk_result fit_renderer(es_gl *g, const ex_gbuffer *b)
{
    const glbk_envsh_renderer_desc size = { b->width, b->height };
    glbk_gbuffer_desc desc;
    glbk_result result;
    float *picture;
    if (g->renderer.width == b->width && g->renderer.height == b->height)
        return GLBK_OK;
    picture = realloc(g->picture, 4 * (size_t)b->width * b->height * sizeof *picture);
    if (!picture)
        return GLBK_ERR_ALLOC;
    g->picture = picture;
    memset(&desc, 0, sizeof desc);
    desc.width = b->width;
    desc.height = b->height;
    glbk_envsh_renderer_free(g->gl, &g->renderer);
    glbk_gbuffer_free(g->gl, &g->seen);
    result = glbk_gbuffer_create(g->gl, &desc, &g->seen);
    return result == GLBK_OK ? glbk_envsh_renderer_create(g->gl, &size, &g->renderer) : result;
}

static glbk_result upload_pixels(es_gl *g, const ex_gbuffer *b)
{
    glbk_pixel *row = calloc(b->width, sizeof *row);
    glbk_result result = row ? fit_renderer(g, b) : GLBK_ERR_ALLOC;
    for (uint32_t y = 0; y < b->height && result == GLBK_OK; y++) {
        for (uint32_t x = 0; x < b->width; x++) {
            const ex_pixel *from = &b->pixels[(size_t)y * b->width + x];
            glbk_pixel *to = &row[x];
            memset(to, 0, sizeof *to);
            if (from->object == UINT32_MAX)
                continue;
            memcpy(to->position, from->position, sizeof to->position);
            memcpy(to->normal, from->normal, sizeof to->normal);
            memcpy(to->geometric_normal, from->geometric, sizeof to->geometric_normal);
        }
        result = glbk_gbuffer_upload(g->gl, &g->seen, y, 1, row);
    }
    free(row);
    return result;
}

/* ---- maps ---- */

/* Makes the maps anew, with room for so many lights at once. */
static glbk_result make_maps(es_state *s, uint32_t capacity)
{
    glbk_envsh_maps_desc desc;
    envsh_maps_desc maps;
    memset(&desc, 0, sizeof desc);
    memset(&maps, 0, sizeof maps);
    s->cluster = capacity;
    desc.capacity = capacity ? capacity : 1;
    desc.maps = &maps;
    maps.map_side = s->atlas.map_side;
    maps.guard = s->atlas.guard;
    maps.rgba = (int)s->rgba;
    glbk_envsh_maps_free(s->gl->gl, &s->gl->maps);
    return glbk_envsh_maps_create(s->gl->gl, &desc, &s->gl->maps);
}

/* glbk_envsh_illuminate, with clocks in between. */
static glbk_result light(es_state *s, const envsh_view *views, uint32_t count)
{
    es_gl *g = s->gl;
    envsh_query query = s->query;
    glbk_result result = GLBK_OK;
    g->renderer.begun = 0;
    s->maps_ms = s->shade_ms = 0;
    for (uint32_t first = 0; first < count && result == GLBK_OK; first += s->cluster) {
        uint32_t n = count - first < s->cluster ? count - first : s->cluster;
        double start = ex_seconds(), middle;
        result = glbk_envsh_maps_render(g->gl, &g->maps, views + first, n, draw, g);
        g->gl->gl.Finish();
        middle = ex_seconds();
        query.add = first != 0;
        if (result == GLBK_OK)
            result = glbk_envsh_shade(g->gl, &g->renderer, &g->seen, &g->maps, &query, 0);
        g->gl->gl.Finish();
        s->maps_ms += 1000 * (middle - start);
        s->shade_ms += 1000 * (ex_seconds() - middle);
    }
    return result;
}

/* capacity=auto: some lights of the first frame, with some capacities, say what a pass and a place in it cost, and by
   that the best capacity of all is taken; but one that was tried, if it was quicker than the best is expected to be. */
static glbk_result choose_cluster(es_state *s, const envsh_view *views, uint32_t count)
{
    enum { TRIED = 3 };
    static const uint32_t sizes[TRIED] = { 1, 8, ES_MOST_CHOSEN };
    uint32_t tried[TRIED], few = count < ES_MOST_CHOSEN ? count : ES_MOST_CHOSEN, best = 0, chosen;
    double ms[TRIED];
    envsh_cost cost;
    glbk_result result = GLBK_OK;
    for (uint32_t i = 0; i < TRIED && result == GLBK_OK; i++) {
        tried[i] = sizes[i] < few ? sizes[i] : few;
        result = make_maps(s, tried[i]);
        if (result == GLBK_OK && i == 0)
            result = light(s, views, few);          /* compiles */
        if (result == GLBK_OK)
            result = light(s, views, few);
        ms[i] = s->maps_ms + s->shade_ms;
        best = ms[i] < ms[best] ? i : best;
    }
    s->choose_cluster = 0;
    if (result != GLBK_OK)
        return result;
    chosen = tried[best];
    if (envsh_cost_fit(few, tried, ms, TRIED, &cost)) {
        uint32_t c = envsh_cost_cluster(&cost, count, few);
        double passes = (few + c - 1) / c;
        chosen = passes * (cost.pass + c * cost.slot) < ms[best] ? c : chosen;
    }
    return make_maps(s, chosen);
}

/* ---- the technique ---- */

int es_gl_open(es_state *s, const rd_job *job, char *error)
{
    es_gl *g = s->gl = calloc(1, sizeof *g);
    glbk_result result;
    if (!g)
        return es_refuse("out of memory", error);
    g->gl = job->gl;
    g->state = s;
    g->casters = calloc((size_t)s->caster_count + 1, sizeof *g->casters);
    if (!g->casters)
        return es_refuse("out of memory", error);
    g->count = s->caster_count;
    result = make_maps(s, s->cluster);
    return result == GLBK_OK ? upload_all(s, 0, error) : gl_failed(result, error);
}

int es_gl_frame(es_state *s, const rd_job *job, char *error)
{
    es_gl *g = s->gl;
    uint32_t count;
    const envsh_view *views = envsh_views(s->maps, &count);
    glbk_result result = upload_pixels(g, job->gbuffer);
    if (result == GLBK_OK && s->choose_cluster && count)
        result = choose_cluster(s, views, count);
    if (result == GLBK_OK)
        result = light(s, views, count);
    if (result == GLBK_OK)
        result = glbk_envsh_read(g->gl, &g->renderer, g->picture);
    if (result != GLBK_OK)
        return gl_failed(result, error);
    for (size_t i = 0; i < s->pixels; i++)
        memcpy(s->irradiance + 3 * i, g->picture + 4 * i, 3 * sizeof(float));
    return 0;
}

void es_gl_report(const es_state *s, rd_report *report)
{
    const glbk_envsh_maps *m = &s->gl->maps;
    size_t texels = (size_t)m->atlas.width * m->atlas.height, cells = (size_t)m->cells.width * m->cells.height;
    size_t layer = texels * (m->channel_count == 4 ? 16 : 4) + m->channel_count * (cells + cells / 3) * 8;
    report->memory_bytes += layer * m->page_count + 128 * (size_t)m->capacity;
    report->memory_bytes += m->channel_count == 4 ? 4 * texels : 0;
}

void es_gl_close(es_state *s)
{
    es_gl *g = s->gl;
    if (!g)
        return;
    for (uint32_t i = 0; i < g->count; i++)
        if (g->casters[i].vertex_array) {
            g->gl->gl.DeleteVertexArrays(1, &g->casters[i].vertex_array);
            g->gl->gl.DeleteBuffers(2, g->casters[i].buffers);
        }
    glbk_envsh_maps_free(g->gl, &g->maps);
    glbk_envsh_renderer_free(g->gl, &g->renderer);
    glbk_gbuffer_free(g->gl, &g->seen);
    free(g->casters);
    free(g->picture);
    free(g);
    s->gl = NULL;
}
