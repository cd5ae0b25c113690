/* rsm_gl.c - the technique "rsm" on OpenGL: the scene's meshes as vertex arrays, its textures with mipmaps; maps are
   drawn, light is gathered on the GPU, and the two pictures of irradiance are read back. */
#include "rsm_parts.h"
#include "../../gl_backend/gl_rsm.h"

#include <stdlib.h>
#include <string.h>

typedef struct run { uint32_t material, first, count; } run;       /* indices of one material */

typedef struct shape {
    uint32_t    array;
    glbk_buffer positions, uvs, indices;
    run        *runs;
    size_t      run_count;
} shape;

typedef struct rs_gl {
    glbk_context     *gl;
    glbk_rsm_renderer renderer;
    glbk_gbuffer      seen;
    shape            *shapes;           /* one a mesh */
    uint32_t          shape_count;
    glbk_texture     *textures;
    uint32_t          texture_count;
    glbk_rsm_map     *maps;
    glbk_rsm_map    **pointers;
    size_t            map_count, lamp_count;    /* the rest are rings of the ground */
    const ex_scene   *scene;            /* while it is drawn */
    float            *picture;          /* rgba */
    uint32_t          frame;
} rs_gl;

static int gl_failed(const char *what, glbk_result result, char *error)
{
    snprintf(error, EX_ERROR_SIZE, "rsm on GL: %s: %s", what, glbk_result_text(result));
    return -1;
}

static int no_memory(char *error)
{
    snprintf(error, EX_ERROR_SIZE, "out of memory");
    return -1;
}

/* ---- meshes ---- */

static void free_shape(rs_gl *g, shape *s)
{
    if (s->array)
        g->gl->gl.DeleteVertexArrays(1, &s->array);
    glbk_buffer_free(g->gl, &s->positions);
    glbk_buffer_free(g->gl, &s->uvs);
    glbk_buffer_free(g->gl, &s->indices);
    free(s->runs);
    memset(s, 0, sizeof *s);
}

/* Indices sorted by material, each material's in their order. */
static int sort_indices(const ex_scene *scene, const ex_mesh *mesh, shape *s, uint32_t *sorted)
{
    uint32_t *starts = calloc(scene->material_count + (size_t)1, sizeof *starts), at = 0;
    s->runs = calloc(scene->material_count + (size_t)1, sizeof *s->runs);
    if (!starts || !s->runs) {
        free(starts);
        return -1;
    }
    for (uint32_t i = 0; i < mesh->triangle_count; i++)
        starts[mesh->materials[i]]++;
    for (uint32_t m = 0; m < scene->material_count; m++) {
        uint32_t count = starts[m];
        starts[m] = at;
        if (!count)
            continue;
        s->runs[s->run_count].material = m;
        s->runs[s->run_count].first = 3 * at;
        s->runs[s->run_count++].count = 3 * count;
        at += count;
    }
    for (uint32_t i = 0; i < mesh->triangle_count; i++)
        memcpy(sorted + 3 * (size_t)starts[mesh->materials[i]]++, mesh->indices + 3 * (size_t)i, 3 * sizeof *sorted);
    free(starts);
    return 0;
}

static int upload_shape(rs_gl *g, const ex_scene *scene, const ex_mesh *mesh, shape *s, char *error)
{
    const glbk_functions *gl = &g->gl->gl;
    uint32_t *sorted = malloc(3 * sizeof *sorted * ((size_t)mesh->triangle_count + 1));
    glbk_result result = GLBK_OK;
    int sorted_ok = sorted && sort_indices(scene, mesh, s, sorted) == 0;
    if (sorted_ok && mesh->triangle_count) {
        result = glbk_buffer_create(g->gl, 12 * (size_t)mesh->vertex_count, mesh->positions, &s->positions);
        if (result == GLBK_OK && mesh->uvs)
            result = glbk_buffer_create(g->gl, 8 * (size_t)mesh->vertex_count, mesh->uvs, &s->uvs);
        if (result == GLBK_OK)
            result = glbk_indices_create(g->gl, 12 * (size_t)mesh->triangle_count, sorted, &s->indices);
    }
    free(sorted);
    if (!sorted_ok)
        return no_memory(error);
    if (result != GLBK_OK)
        return gl_failed("a mesh", result, error);
    if (!mesh->triangle_count)
        return 0;
    gl->GenVertexArrays(1, &s->array);
    gl->BindVertexArray(s->array);
    gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, s->positions.name);
    gl->EnableVertexAttribArray(0);
    gl->VertexAttribPointer(0, 3, GLBK_GL_FLOAT, 0, 0, NULL);
    if (mesh->uvs) {
        gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, s->uvs.name);
        gl->EnableVertexAttribArray(2);
        gl->VertexAttribPointer(2, 2, GLBK_GL_FLOAT, 0, 0, NULL);
    }
    gl->BindBuffer(GLBK_GL_ELEMENT_ARRAY_BUFFER, s->indices.name);
    gl->BindVertexArray(0);
    return 0;
}

/* Rigid meshes once, others for each frame. */
static int upload_shapes(rs_gl *g, const ex_scene *scene, char *error)
{
    for (uint32_t i = 0; i < scene->mesh_count; i++) {
        if (g->frame && !scene->meshes[i].deforms)
            continue;
        free_shape(g, &g->shapes[i]);
        if (upload_shape(g, scene, &scene->meshes[i], &g->shapes[i], error) != 0)
            return -1;
    }
    return 0;
}

static int upload_textures(rs_gl *g, const ex_scene *scene, char *error)
{
    for (uint32_t i = 0; i < scene->texture_count; i++) {
        glbk_texture_desc d;
        glbk_result result;
        memset(&d, 0, sizeof d);
        d.format = GLBK_FORMAT_SRGB8_A8;
        d.width = scene->textures[i].width;
        d.height = scene->textures[i].height;
        d.sampling = GLBK_SAMPLING_MIPMAPS;
        d.repeat = 1;
        d.data = scene->textures[i].rgba;
        result = glbk_texture_create(g->gl, &d, &g->textures[i]);
        if (result != GLBK_OK)
            return gl_failed("a texture", result, error);
    }
    return 0;
}

/* ---- drawing ---- */

static void draw_run(rs_gl *g, const ex_object *object, const shape *s, const run *r)
{
    const ex_material *m = &g->scene->materials[object->material ? object->material - 1 : r->material];
    glbk_surface surface;
    memset(&surface, 0, sizeof surface);
    memcpy(surface.transform, object->transform, sizeof surface.transform);
    memcpy(surface.material.diffuse, m->base_color, sizeof surface.material.diffuse);
    if (m->base_texture >= 0 && s->uvs.name) {
        surface.color_map = &g->textures[m->base_texture];
        surface.alpha_cutoff = m->alpha_cutoff;
    }
    if (glbk_rsm_object(g->gl, &g->renderer, &surface, 0) != GLBK_OK)      /* glbk_rsm_map_draw says so */
        return;
    g->gl->gl.DrawElements(GLBK_GL_TRIANGLES, (int32_t)r->count, GLBK_GL_UNSIGNED_INT,
                           (const void *)(4 * (uintptr_t)r->first));
}

static void draw_scene(void *user, glbk_context *ctx, glbk_rsm_renderer *renderer)
{
    rs_gl *g = user;
    (void)renderer;
    for (uint32_t i = 0; i < g->scene->object_count; i++) {
        const ex_object *object = &g->scene->objects[i];
        const shape *s = &g->shapes[object->mesh];
        ctx->gl.BindVertexArray(s->array);
        for (size_t k = 0; k < s->run_count; k++)
            draw_run(g, object, s, &s->runs[k]);
    }
}

static void free_maps(rs_gl *g)
{
    for (size_t i = 0; i < g->map_count; i++)
        glbk_rsm_map_free(g->gl, &g->maps[i]);
    free(g->maps);
    free(g->pointers);
    g->maps = NULL;
    g->pointers = NULL;
    g->map_count = 0;
}

/* Maps stay from frame to frame while the lights stay as many and of a kind. The last ones are of rings. */
static int make_maps(rs_state *state, const rsm_light *lights, size_t count, size_t rings, char *error)
{
    rs_gl *g = state->gl;
    glbk_result result = count == g->map_count && count - rings == g->lamp_count ? GLBK_OK : GLBK_ERR_ARGUMENT;
    for (size_t i = 0; i < count && result == GLBK_OK; i++)
        result = glbk_rsm_map_place(g->gl, &g->maps[i], &lights[i]);
    if (result == GLBK_OK)
        return 0;
    free_maps(g);
    g->maps = calloc(count + 1, sizeof *g->maps);
    g->pointers = calloc(count + 1, sizeof(glbk_rsm_map *));
    if (!g->maps || !g->pointers)
        return no_memory(error);
    state->gl_bytes = (state->mode == RS_INTERPOLATED ? 129u : state->mode == RS_DENOISED ? 212u : 116u) *
                          (uint64_t)state->pixels + (4u << 20);
    for (result = GLBK_OK; g->map_count < count && result == GLBK_OK; g->map_count++) {
        glbk_rsm_map *map = g->pointers[g->map_count] = &g->maps[g->map_count];
        uint32_t side = g->map_count < count - rings ? rs_map_side(state, &lights[g->map_count]) : RD_RING_SIDE;
        result = glbk_rsm_map_create(g->gl, &lights[g->map_count], side, map);
        state->gl_bytes += 60 * (uint64_t)map->side * map->side * map->face_count;
    }
    g->lamp_count = count - rings;
    return result == GLBK_OK ? 0 : gl_failed("a map", result, error);
}

static int upload_ring(rs_state *state, const rd_ring *ring, glbk_rsm_map *to, char *error)
{
    rsm_map *map;
    glbk_result result;
    if (rs_ring_map(ring, &state->system, &map, error) != 0)
        return -1;
    result = glbk_rsm_map_upload(state->gl->gl, to, rsm_map_texels(map));
    rsm_map_free(map);
    return result == GLBK_OK ? 0 : gl_failed("a map of the ground", result, error);
}

/* Lights, then rings as lights: what the maps are of. */
static int list_lights(rsm_light **lights, size_t *count, rd_ring **rings, size_t *ring_count, const rs_state *state,
                       const rd_job *job, char *error)
{
    rsm_light *grown;
    if (rs_lights_build(lights, count, job, state->points, error) != 0 ||
        (state->indirect && rs_rings_build(rings, ring_count, job, *lights, *count, error) != 0))
        return -1;
    grown = realloc(*lights, (*count + *ring_count + 1) * sizeof *grown);
    if (!grown)
        return no_memory(error);
    for (size_t i = 0; i < *ring_count; i++)
        grown[(*count)++] = rs_ring_light(&(*rings)[i]);
    *lights = grown;
    return 0;
}

static int draw_maps(rs_state *state, const rd_job *job, char *error)
{
    rs_gl *g = state->gl;
    rsm_light *lights = NULL;
    rd_ring *rings = NULL;
    size_t count = 0, ring_count = 0;
    int failed = list_lights(&lights, &count, &rings, &ring_count, state, job, error) != 0 ||
                 make_maps(state, lights, count, ring_count, error) != 0;
    g->scene = job->scene;
    for (size_t i = 0; i < ring_count && !failed; i++)
        failed = upload_ring(state, &rings[i], &g->maps[g->lamp_count + i], error) != 0;
    rd_rings_free(rings, ring_count);
    free(lights);
    for (size_t i = 0; i < g->lamp_count && !failed; i++) {
        glbk_result result = glbk_rsm_map_draw(g->gl, &g->renderer, &g->maps[i], draw_scene, g);
        failed = result != GLBK_OK && gl_failed("drawing a map", result, error) != 0;
    }
    return failed ? -1 : 0;
}

/* ---- shading ---- */

static int upload_pixels(rs_state *state, const rd_job *job, char *error)
{
    rs_gl *g = state->gl;
    uint32_t width = job->gbuffer->width;
    glbk_pixel *row = calloc(width, sizeof *row);
    glbk_result result = GLBK_OK;
    if (!row)
        return no_memory(error);
    for (uint32_t y = 0; y < job->gbuffer->height && result == GLBK_OK; y++) {
        for (uint32_t x = 0; x < width; x++) {
            size_t at = (size_t)y * width + x;
            memcpy(row[x].position, state->positions + 3 * at, sizeof row[x].position);
            memcpy(row[x].normal, state->normals + 3 * at, sizeof row[x].normal);
            memcpy(row[x].material.diffuse, job->gbuffer->pixels[at].albedo, sizeof row[x].material.diffuse);
        }
        result = glbk_gbuffer_upload(g->gl, &g->seen, y, 1, row);
    }
    free(row);
    return result == GLBK_OK ? 0 : gl_failed("G-buffer", result, error);
}

/* What rsm_gather is given, without its threads: they are of the CPU alone. */
static rsm_gather_desc gather_desc(const rs_state *state)
{
    rsm_gather_desc d = state->gather;
    memset(&d.system, 0, sizeof d.system);
    return d;
}

/* The pattern of this frame's seed, as rsm_gather makes it. */
static int upload_tables(rs_state *state, char *error)
{
    const rsm_gather_desc d = gather_desc(state);
    const uint32_t n = glbk_rsm_point_count(&d);
    float *points = NULL;
    glbk_result uploaded;
    if (n) {
        int mixed = d.pattern == RSM_PATTERN_MIXED;
        rsm_result result;
        points = malloc(3 * sizeof *points * n);
        if (!points)
            return no_memory(error);
        result = rsm_pattern_build(mixed ? RSM_PATTERN_LOG_RADIAL : d.pattern, n, mixed ? 1.0f / 192 : d.r_min,
                                   d.paper_weights, d.seed, points);
        if (result != RSM_OK) {
            free(points);
            return rs_fail(error, "the pattern", result);
        }
    }
    uploaded = glbk_rsm_tables_upload(state->gl->gl, &state->gl->renderer, &d, points);
    free(points);
    return uploaded == GLBK_OK ? 0 : gl_failed("the pattern", uploaded, error);
}

static glbk_result gather(rs_state *state)
{
    rs_gl *g = state->gl;
    const rsm_gather_desc d = gather_desc(state);
    if (state->mode != RS_INTERPOLATED)
        return glbk_rsm_gather(g->gl, &g->renderer, &g->seen, g->pointers, (uint32_t)g->map_count, &d);
    return glbk_rsm_interpolate(g->gl, &g->renderer, &g->seen, g->pointers, (uint32_t)g->map_count, &d,
                                &state->interpolation);
}

static glbk_result denoise(rs_state *state, const rd_job *job)
{
    gifilt_frame d;
    float matrix[16];
    memset(&d, 0, sizeof d);
    rs_view_projection(&job->scene->camera, (float)job->gbuffer->width / (float)job->gbuffer->height, matrix);
    d.world_to_clip = matrix;
    d.rows = GIFILT_ROWS_TOP_FIRST;
    d.passes = state->passes ? (int)state->passes : -1;
    d.history = state->history;
    return glbk_rsm_denoise(state->gl->gl, &state->gl->renderer, &state->gl->seen, &d, NULL);
}

static glbk_result read_light(rs_state *state, int bounced, float *to)
{
    rs_gl *g = state->gl;
    glbk_result result = glbk_rsm_read(g->gl, &g->renderer, bounced, g->picture);
    if (result != GLBK_OK)
        return result;
    if (bounced)
        state->stats.evaluated = 0;
    for (size_t i = 0; i < state->pixels; i++) {
        memcpy(to + 3 * i, g->picture + 4 * i, 3 * sizeof *to);
        if (bounced)
            state->stats.evaluated += g->picture[4 * i + 3] > (state->mode == RS_DENOISED ? 0.5f : 2.5f);
    }
    return GLBK_OK;
}

int rs_gl_frame(rs_state *state, const rd_job *job, char *error)
{
    rs_gl *g = state->gl;
    rsm_direct_desc shadow = state->shadow;
    glbk_result result = GLBK_OK;
    double times[4];
    if (upload_shapes(g, job->scene, error) != 0 || upload_pixels(state, job, error) != 0 ||
        upload_tables(state, error) != 0)
        return -1;
    g->frame++;
    times[0] = ex_seconds();
    if (draw_maps(state, job, error) != 0)
        return -1;
    g->gl->gl.Finish();
    times[1] = ex_seconds();
    memset(&shadow.system, 0, sizeof shadow.system);
    shadow.add = 0;
    if (state->direct && g->lamp_count) {
        result = glbk_rsm_direct(g->gl, &g->renderer, &g->seen, (const glbk_rsm_map *const *)g->pointers,
                                 (uint32_t)g->lamp_count, &shadow);
        if (result == GLBK_OK)
            result = read_light(state, 0, state->light);
    }
    times[2] = ex_seconds();
    if (result == GLBK_OK && state->indirect && g->map_count) {
        result = gather(state);
        if (result == GLBK_OK && state->mode == RS_DENOISED)
            result = denoise(state, job);
        g->gl->gl.Finish();
        times[3] = ex_seconds();
        state->gather_ms = 1000 * (times[3] - times[2]);
        if (result == GLBK_OK)
            result = read_light(state, 1, state->bounce);
    }
    if (result != GLBK_OK)
        return gl_failed("shading", result, error);
    state->maps_ms = 1000 * (times[1] - times[0]);
    state->direct_ms = 1000 * (times[2] - times[1]);
    return 0;
}

/* ---- opening ---- */

int rs_gl_open(rs_state *state, const rd_job *job, char *error)
{
    rs_gl *g = state->gl = calloc(1, sizeof *g);
    glbk_rsm_renderer_desc desc;
    glbk_gbuffer_desc size;
    glbk_result result;
    if (!g)
        return no_memory(error);
    g->gl = job->gl;
    memset(&desc, 0, sizeof desc);
    desc.width = job->gbuffer->width;
    desc.height = job->gbuffer->height;
    desc.interpolate = state->mode == RS_INTERPOLATED;
    desc.denoise = state->mode == RS_DENOISED;
    memset(&size, 0, sizeof size);
    size.width = desc.width;
    size.height = desc.height;
    result = glbk_rsm_renderer_create(g->gl, &desc, &g->renderer);
    if (result == GLBK_OK)
        result = glbk_gbuffer_create(g->gl, &size, &g->seen);
    if (result != GLBK_OK)
        return gl_failed("renderer", result, error);
    g->shapes = calloc(job->scene->mesh_count + (size_t)1, sizeof *g->shapes);
    g->textures = calloc(job->scene->texture_count + (size_t)1, sizeof *g->textures);
    g->picture = malloc(4 * sizeof *g->picture * desc.width * desc.height);
    if (!g->shapes || !g->textures || !g->picture)
        return no_memory(error);
    g->shape_count = job->scene->mesh_count;
    g->texture_count = job->scene->texture_count;
    return upload_textures(g, job->scene, error);
}

size_t rs_gl_maps(const rs_state *state) { return state->gl ? state->gl->map_count : 0; }

void rs_gl_close(rs_state *state)
{
    rs_gl *g = state->gl;
    if (!g)
        return;
    free_maps(g);
    for (uint32_t i = 0; i < g->shape_count; i++)
        free_shape(g, &g->shapes[i]);
    for (uint32_t i = 0; i < g->texture_count; i++)
        glbk_texture_free(g->gl, &g->textures[i]);
    glbk_rsm_renderer_free(g->gl, &g->renderer);
    glbk_gbuffer_free(g->gl, &g->seen);
    free(g->shapes);
    free(g->textures);
    free(g->picture);
    free(g);
    state->gl = NULL;
}
