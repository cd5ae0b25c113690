/* csm_gl.c - the technique csm on OpenGL: the maps that csm.h built, its lights and the G-buffer go to gl_backend.h,
   which draws the same samples as the CPU does. */
#include "csm_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct cs_gl {
    glbk_context      *gl;
    glbk_csm_renderer  renderer;
    glbk_csm_lights    lights;
    glbk_csm_use      *uses;             /* one a light of the state */
    glbk_csm_maps     *maps;             /* of the directions, then of each light's own casters */
    size_t             map_count;
    float             *picture;          /* rgba */
};

static int gl_failed(cs_gl *g, const char *what, glbk_result result, char *error)
{
    snprintf(error, EX_ERROR_SIZE, "csm on GL: %s: %s %.120s", what, glbk_result_text(result), g->gl->log);
    return -1;
}

/* ---- maps ---- */

static int upload_casters(cs_gl *g, const cs_casters *c, glbk_csm_maps *out, char *error)
{
    glbk_csm_block *blocks = calloc(c->map_count + 1, sizeof *blocks);
    glbk_csm_instance *instances = calloc(c->count + 1, sizeof *instances);
    uint32_t *starts = calloc(c->map_count + 1, sizeof *starts);
    glbk_result result = GLBK_OK;
    int failed = !blocks || !instances || !starts;
    for (size_t i = 0; i < c->map_count && !failed; i++)
        blocks[i].data = cohsm_data(c->maps[i], &blocks[i].size);
    if (!failed)
        result = glbk_csm_maps_create(g->gl, blocks, c->map_count, (uint32_t)c->count, starts, out);
    for (size_t i = 0; i < c->count && !failed; i++) {
        size_t k = 0;
        while (c->maps[k] != c->instances[i].maps)
            k++;
        instances[i].start = starts[k];
        memcpy(instances[i].transform, c->instances[i].transform, sizeof instances[i].transform);
        instances[i].offset = c->offsets[i];
    }
    if (!failed && result == GLBK_OK)
        result = glbk_csm_maps_place(g->gl, out, instances, (uint32_t)c->count);
    free(blocks);
    free(instances);
    free(starts);
    return failed ? cs_out_of_memory(error) : result == GLBK_OK ? 0 : gl_failed(g, "maps", result, error);
}

static int upload_maps(cs_gl *g, const cs_state *state, char *error)
{
    g->maps = calloc(state->light_count + 1, sizeof *g->maps);
    if (!g->maps)
        return cs_out_of_memory(error);
    g->map_count = state->light_count + 1;
    if (state->directions.maps && upload_casters(g, &state->directions, &g->maps[0], error) != 0)
        return -1;
    for (size_t i = 0; i < state->light_count; i++)
        if (state->lights[i].casters == &state->lights[i].own &&
            upload_casters(g, &state->lights[i].own, &g->maps[i + 1], error) != 0)
            return -1;
    return 0;
}

/* ---- lights ---- */

static int describe_light(const cs_light *light, glbk_csm_light_desc *out, float **triangles, char *error)
{
    const cohsm_emitter_desc *d = &light->desc;
    memset(out, 0, sizeof *out);
    out->shape = (glbk_csm_shape)d->shape;
    memcpy(out->position, d->position, sizeof out->position);
    memcpy(out->direction, d->direction, sizeof out->direction);
    memcpy(out->u, d->u, sizeof out->u);
    memcpy(out->v, d->v, sizeof out->v);
    memcpy(out->radiance, d->radiance, sizeof out->radiance);
    out->radius = d->radius;
    out->cone_angle = d->cone_angle;
    out->rotation = d->rotation;
    out->texels = d->texels;
    out->width = d->width;
    out->height = d->height;
    if (light->wide_spot) {
        out->shape = GLBK_CSM_SHAPE_SPOT;
        memcpy(out->direction, light->wide_spot->direction, sizeof out->direction);
        out->cone_angle = 2 * acosf(light->wide_spot->cos_half_angle);
    }
    *triangles = NULL;
    if (!light->is_mesh)
        return 0;
    out->triangle_count = (uint32_t)cohsm_emitter_triangles(light->emitter, NULL);
    out->triangles = *triangles = malloc(9 * (size_t)out->triangle_count * sizeof **triangles);
    if (!*triangles)
        return cs_out_of_memory(error);
    cohsm_emitter_triangles(light->emitter, *triangles);
    return 0;
}

static int upload_lights(cs_gl *g, const cs_state *state, const rd_job *job, char *error)
{
    size_t n = state->light_count;
    glbk_csm_light_desc *lights = calloc(n + 1, sizeof *lights);
    float **triangles = calloc(n + 1, sizeof *triangles);
    uint32_t *starts = calloc(n + 1, sizeof *starts);
    glbk_csm_lights_desc desc;
    int result = lights && triangles && starts ? 0 : cs_out_of_memory(error);
    memset(&desc, 0, sizeof desc);
    desc.lights = lights;
    desc.light_count = (uint32_t)n;
    g->uses = calloc(n + 1, sizeof *g->uses);
    if (result == 0 && !g->uses)
        result = cs_out_of_memory(error);
    for (size_t i = 0; i < n && result == 0; i++)
        result = describe_light(&state->lights[i], &lights[i], &triangles[i], error);
    if (result == 0) {
        glbk_result made = glbk_csm_lights_create(g->gl, &desc, starts, &g->lights);
        if (made != GLBK_OK)
            result = gl_failed(g, "lights", made, error);
    }
    for (uint32_t i = 0; i < n && result == 0; i++) {
        const cs_light *light = &state->lights[i];
        uint32_t samples = light->is_delta ? 1 : (uint32_t)(job->samples / state->area_count);
        g->uses[i].start = starts[i];
        g->uses[i].shape = lights[i].shape;
        g->uses[i].maps = &g->maps[light->casters == &light->own ? i + 1 : 0];
        g->uses[i].ask = (glbk_csm_ask)light->ask;
        g->uses[i].samples = samples ? samples : 1;
        g->uses[i].seed = i;
    }
    for (size_t i = 0; triangles && i < n; i++)
        free(triangles[i]);
    free(triangles);
    free(lights);
    free(starts);
    return result;
}

/* ---- G-buffer ---- */

/* Instances by object: those of casters that stand for single objects. Where all are one, the number is not needed. */
static const uint32_t *instance_numbers(const cs_state *state)
{
    if (state->directions.maps)
        return state->directions.self;
    for (size_t i = 0; i < state->light_count; i++)
        if (state->lights[i].at_infinity)
            return state->lights[i].casters->self;
    return state->light_count ? state->lights[0].casters->self : NULL;
}

static void describe_pixel(const cs_state *state, const ex_pixel *p, const uint32_t *self, glbk_csm_pixel *out)
{
    memset(out, 0, sizeof *out);
    if (p->object == UINT32_MAX)
        return;
    memcpy(out->position, p->position, sizeof out->position);
    memcpy(out->normal, p->normal, sizeof out->normal);
    memcpy(out->geometric, p->geometric, sizeof out->geometric);
    out->surface.brdf = state->full ? GLBK_CSM_BRDF_METAL_ROUGH : GLBK_CSM_BRDF_LAMBERT;
    for (int k = 0; k < 3; k++)
        out->surface.diffuse[k] = fminf(p->albedo[k], 1);
    out->surface.metallic = p->metallic;
    out->surface.roughness = p->roughness;
    out->surface.self = self ? self[p->object] : GLBK_CSM_NO_SELF;
    for (uint32_t i = 0; i < state->plane_count; i++)
        if (state->planes[i].object == p->object)
            out->surface.plane = i + 1;
}

static int upload_gbuffer(cs_gl *g, const cs_state *state, const rd_job *job, char *error)
{
    const ex_gbuffer *b = job->gbuffer;
    const uint32_t *self = instance_numbers(state);
    glbk_csm_pixel *row = malloc(b->width * sizeof *row);
    glbk_csm_renderer_desc desc;
    glbk_result result;
    memset(&desc, 0, sizeof desc);
    desc.width = b->width;
    desc.height = b->height;
    result = glbk_csm_renderer_create(g->gl, &desc, &g->renderer);
    g->picture = malloc(4 * (size_t)b->width * b->height * sizeof *g->picture);
    for (uint32_t y = 0; row && y < b->height && result == GLBK_OK; y++) {
        for (uint32_t x = 0; x < b->width; x++)
            describe_pixel(state, &b->pixels[(size_t)y * b->width + x], self, &row[x]);
        result = glbk_csm_gbuffer_upload(g->gl, &g->renderer, y, 1, row);
    }
    free(row);
    if (!row || !g->picture)
        return cs_out_of_memory(error);
    return result == GLBK_OK ? 0 : gl_failed(g, "renderer", result, error);
}

/* ---- the technique ---- */

int cs_gl_open(cs_state *state, const rd_job *job, char *error)
{
    cs_gl *g = state->gl = calloc(1, sizeof *g);
    if (!g)
        return cs_out_of_memory(error);
    g->gl = job->gl;
    if (state->plane_count > GLBK_CSM_MAX_PLANES) {
        snprintf(error, EX_ERROR_SIZE, "csm on GL: more than %u receivers without maps", GLBK_CSM_MAX_PLANES);
        return -1;
    }
    return upload_maps(g, state, error) != 0 || upload_lights(g, state, job, error) != 0 ||
                   upload_gbuffer(g, state, job, error) != 0
               ? -1
               : 0;
}

int cs_gl_frame(cs_state *state, const rd_job *job, ex_image *out, char *error)
{
    cs_gl *g = state->gl;
    glbk_csm_frame_desc desc;
    glbk_result result;
    float refused = 0;
    memset(&desc, 0, sizeof desc);
    desc.lights = &g->lights;
    desc.uses = g->uses;
    desc.use_count = (uint32_t)state->light_count;
    memcpy(desc.eye, job->scene->camera.eye, sizeof desc.eye);
    desc.plane_count = (uint32_t)state->plane_count;
    for (size_t i = 0; i < state->plane_count; i++) {
        memcpy(desc.planes[i], state->planes[i].normal, 3 * sizeof(float));
        desc.planes[i][3] = state->planes[i].distance;
    }
    desc.filter = (glbk_csm_filter)state->options.filter;
    desc.bias = state->options.bias;
    desc.offset = state->options.offset;
    desc.number = job->seed;
    glbk_csm_reset(&g->renderer);
    result = glbk_csm_render(g->gl, &g->renderer, &desc);
    if (result == GLBK_OK)
        result = glbk_csm_read(g->gl, &g->renderer, g->picture);
    if (result != GLBK_OK)
        return gl_failed(g, "shading", result, error);
    for (size_t i = 0; i < (size_t)out->width * out->height; i++) {
        memcpy(out->rgb + 3 * i, g->picture + 4 * i, 3 * sizeof(float));
        refused += g->picture[4 * i + 3];
    }
    return refused > 0 ? cs_refused((uint64_t)refused, error) : 0;
}

void cs_gl_close(cs_state *state)
{
    cs_gl *g = state->gl;
    if (!g)
        return;
    glbk_csm_renderer_destroy(g->gl, &g->renderer);
    glbk_csm_lights_destroy(g->gl, &g->lights);
    for (size_t i = 0; i < g->map_count; i++)
        glbk_csm_maps_destroy(g->gl, &g->maps[i]);
    free(g->maps);
    free(g->uses);
    free(g->picture);
    free(g);
    state->gl = NULL;
}
