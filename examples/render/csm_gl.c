/* csm_gl.c - the technique csm on OpenGL: the maps that csm.h built, its lights and the G-buffer go to gl_csm.h, which
   draws the same samples as the CPU does. */
#include "csm_parts.h"
#include "../../gl_backend/gl_csm.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct cs_gl {
    glbk_context      *gl;
    glbk_csm_renderer  renderer;
    glbk_gbuffer       seen;
    glbk_csm_lights    lights;
    glbk_csm_use      *uses;             /* one a light of the state */
    glbk_csm_maps     *maps;             /* of the directions, then of each light's own casters */
    size_t             map_count;
    float             *picture;          /* rgba */
};

static int gl_failed(const char *what, glbk_result result, char *error)
{
    snprintf(error, EX_ERROR_SIZE, "csm on GL: %s: %s", what, glbk_result_text(result));
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
    for (size_t i = 0; i < c->map_count && !failed; i++) {
        blocks[i].data = cohsm_fast_data(c->maps[i], &blocks[i].bytes);
        if (!blocks[i].data)            /* layout=compact, or trays of 4 GB */
            blocks[i].data = cohsm_data(c->maps[i], &blocks[i].bytes);
    }
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
    return failed ? cs_out_of_memory(error) : result == GLBK_OK ? 0 : gl_failed("maps", result, error);
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

/* The light as the CPU has it. Cones above 180 degrees, which lightsampling.h refuses, are drawn by GL, and meshes are
   given in the pieces that the emitter samples: corners, which the caller frees. */
static int describe_light(const cs_light *light, lsamp_light_desc *out, lsamp_mesh *mesh, float **corners, char *error)
{
    *out = light->desc;
    *corners = NULL;
    if (light->wide_spot) {
        out->kind = LSAMP_LIGHT_SPOT;
        memcpy(out->direction, light->wide_spot->direction, sizeof out->direction);
        out->cone_half_angle = acosf(light->wide_spot->cos_half_angle);
    }
    if (!light->is_mesh)
        return 0;
    memset(mesh, 0, sizeof *mesh);
    mesh->vertex_count = 3 * lsamp_light_triangles(light->emitter, NULL);
    mesh->positions = *corners = malloc(3 * mesh->vertex_count * sizeof **corners);
    if (!*corners)
        return cs_out_of_memory(error);
    lsamp_light_triangles(light->emitter, *corners);
    out->mesh = mesh;
    return 0;
}

static int upload_lights(cs_gl *g, const cs_state *state, const rd_job *job, char *error)
{
    size_t n = state->light_count;
    lsamp_light_desc *lights = calloc(n + 1, sizeof *lights);
    lsamp_mesh *meshes = calloc(n + 1, sizeof *meshes);
    float **corners = calloc(n + 1, sizeof *corners);
    uint32_t *starts = calloc(n + 1, sizeof *starts);
    glbk_csm_lights_desc desc;
    int result = lights && meshes && corners && starts ? 0 : cs_out_of_memory(error);
    memset(&desc, 0, sizeof desc);
    desc.lights = lights;
    desc.light_count = (uint32_t)n;
    g->uses = calloc(n + 1, sizeof *g->uses);
    if (result == 0 && !g->uses)
        result = cs_out_of_memory(error);
    for (size_t i = 0; i < n && result == 0; i++)
        result = describe_light(&state->lights[i], &lights[i], &meshes[i], &corners[i], error);
    if (result == 0) {
        glbk_result made = glbk_csm_lights_create(g->gl, &desc, starts, &g->lights);
        if (made != GLBK_OK)
            result = gl_failed("lights", made, error);
    }
    for (uint32_t i = 0; i < n && result == 0; i++) {
        const cs_light *light = &state->lights[i];
        uint32_t samples = light->is_delta ? 1 : (uint32_t)(job->samples / state->area_count);
        g->uses[i].start = starts[i];
        g->uses[i].kind = lights[i].kind;
        g->uses[i].maps = &g->maps[light->casters == &light->own ? i + 1 : 0];
        g->uses[i].ask = light->ask;
        g->uses[i].sample_count = samples ? samples : 1;
        g->uses[i].seed = i;
    }
    for (size_t i = 0; corners && i < n; i++)
        free(corners[i]);
    free(corners);
    free(meshes);
    free(lights);
    free(starts);
    return result;
}

/* ---- G-buffer ---- */

/* Instances by object: those of casters that stand for single objects. Where all are one, the number is not needed. */
static const uint32_t *instance_numbers(const cs_state *state)
{
    if (state->directions.maps)
        return state->directions.entity;
    for (size_t i = 0; i < state->light_count; i++)
        if (state->lights[i].at_infinity)
            return state->lights[i].casters->entity;
    return state->light_count ? state->lights[0].casters->entity : NULL;
}

static void describe_pixel(const cs_state *state, const ex_pixel *p, const uint32_t *entity, glbk_pixel *out)
{
    memset(out, 0, sizeof *out);
    if (p->object == UINT32_MAX)
        return;
    memcpy(out->position, p->position, sizeof out->position);
    memcpy(out->normal, p->normal, sizeof out->normal);
    memcpy(out->geometric_normal, p->geometric, sizeof out->geometric_normal);
    out->material.kind = state->full ? LSAMP_MATERIAL_METAL_ROUGH : LSAMP_MATERIAL_LAMBERT;
    for (int k = 0; k < 3; k++)
        out->material.diffuse[k] = fminf(p->albedo[k], 1);
    out->material.metallic = p->metallic;
    out->material.roughness = p->roughness;
    out->entity = entity ? entity[p->object] : 0;
    for (uint32_t i = 0; i < state->plane_count; i++)
        if (state->planes[i].object == p->object)
            out->plane = i + 1;
}

static int upload_gbuffer(cs_gl *g, const cs_state *state, const rd_job *job, char *error)
{
    const ex_gbuffer *b = job->gbuffer;
    const uint32_t *entity = instance_numbers(state);
    glbk_pixel *row = malloc(b->width * sizeof *row);
    glbk_csm_renderer_desc desc;
    glbk_gbuffer_desc seen;
    glbk_result result;
    memset(&desc, 0, sizeof desc);
    memset(&seen, 0, sizeof seen);
    desc.width = seen.width = b->width;
    desc.height = seen.height = b->height;
    result = glbk_csm_renderer_create(g->gl, &desc, &g->renderer);
    if (result == GLBK_OK)
        result = glbk_gbuffer_create(g->gl, &seen, &g->seen);
    g->picture = malloc(4 * (size_t)b->width * b->height * sizeof *g->picture);
    for (uint32_t y = 0; row && y < b->height && result == GLBK_OK; y++) {
        for (uint32_t x = 0; x < b->width; x++)
            describe_pixel(state, &b->pixels[(size_t)y * b->width + x], entity, &row[x]);
        result = glbk_gbuffer_upload(g->gl, &g->seen, y, 1, row);
    }
    free(row);
    if (!row || !g->picture)
        return cs_out_of_memory(error);
    return result == GLBK_OK ? 0 : gl_failed("renderer", result, error);
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
    desc.filter = state->options.filter;
    desc.bias = state->options.bias > 0 ? state->options.bias : -1;
    desc.offset = state->options.offset;
    desc.frame = job->seed;
    glbk_csm_reset(&g->renderer);
    result = glbk_csm_render(g->gl, &g->renderer, &g->seen, &desc);
    if (result == GLBK_OK)
        result = glbk_csm_read(g->gl, &g->renderer, g->picture);
    if (result != GLBK_OK)
        return gl_failed("shading", result, error);
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
    glbk_csm_renderer_free(g->gl, &g->renderer);
    glbk_gbuffer_free(g->gl, &g->seen);
    glbk_csm_lights_free(g->gl, &g->lights);
    for (size_t i = 0; i < g->map_count; i++)
        glbk_csm_maps_free(g->gl, &g->maps[i]);
    free(g->maps);
    free(g->uses);
    free(g->picture);
    free(g);
    state->gl = NULL;
}
