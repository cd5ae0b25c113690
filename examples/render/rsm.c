/* rsm.c - the technique "rsm": direct light by shadow maps and one bounce by reflective shadow maps, through rsm.h;
   gifilter.h makes few samples smooth (mode=denoised).

   Each frame: lights of the scene become lights of rsm.h (rsm_lights.c: one for a sun, spot or point, several for an
   area light, an emissive mesh or a sky), a map of each is rasterised, then all pixels are shaded. */
#include "rsm_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- the header's memory, counted; it is called from one thread ---- */

typedef struct block { size_t size, unused; } block;       /* keeps what follows aligned to 16 */

static void *take(size_t size, void *user)
{
    rs_memory *memory = user;
    block *b = malloc(sizeof *b + size);
    if (!b)
        return NULL;
    b->size = size;
    memory->now += size;
    if (memory->now > memory->peak)
        memory->peak = memory->now;
    return b + 1;
}

static void give(void *data, void *user)
{
    rs_memory *memory = user;
    block *b = (block *)data - 1;
    memory->now -= b->size;
    free(b);
}

/* ---- state ---- */

int rs_fail(char *error, const char *what, rsm_result result)
{
    snprintf(error, EX_ERROR_SIZE, "rsm: %s: %s", what, rsm_result_text(result));
    return -1;
}

static void free_maps(rs_state *state)
{
    for (size_t i = 0; i < state->map_count; i++)
        rsm_map_free(state->maps[i]);
    free(state->maps);
    state->maps = NULL;
    state->map_count = 0;
}

static void close_rsm(void *opaque)
{
    rs_state *state = opaque;
    if (!state)
        return;
    rs_gl_close(state);
    free_maps(state);
    gifilt_free(state->filter);
    free(state->positions);
    free(state->normals);
    free(state->light);
    free(state->bounce);
    free(state);
}

/* ---- maps ---- */

typedef struct surface { const ex_scene *scene; const ex_object *object; } surface;

static void surface_color(void *user, const rsm_mesh *mesh, uint32_t triangle, const float weights[3], float albedo[3])
{
    const surface *s = user;
    (void)mesh;
    ex_surface_color(s->scene, s->object, triangle, weights, albedo);
}

static int is_there(void *user, uint32_t triangle, const float weights[3])
{
    const surface *s = user;
    float albedo[3];
    return ex_surface_color(s->scene, s->object, triangle, weights, albedo);
}

/* The scene's objects as meshes of rsm.h. *surfaces is what their callbacks see. */
static rsm_mesh *convert_scene(const ex_scene *scene, surface **surfaces)
{
    rsm_mesh *meshes = calloc(scene->object_count + (size_t)1, sizeof *meshes);
    int holes = 0;
    *surfaces = calloc(scene->object_count + (size_t)1, sizeof **surfaces);
    if (!meshes || !*surfaces) {
        free(meshes);
        free(*surfaces);
        return NULL;
    }
    for (uint32_t i = 0; i < scene->material_count; i++)
        holes |= scene->materials[i].alpha_cutoff > 0;
    for (uint32_t i = 0; i < scene->object_count; i++) {
        const ex_object *object = &scene->objects[i];
        const ex_mesh *mesh = &scene->meshes[object->mesh];
        rsm_mesh *m = &meshes[i];
        (*surfaces)[i].scene = scene;
        (*surfaces)[i].object = object;
        m->positions = mesh->positions;
        m->vertex_count = mesh->vertex_count;
        m->indices = mesh->indices;
        m->index_count = 3 * (size_t)mesh->triangle_count;
        m->transform = object->transform;
        m->surface_fn = surface_color;
        m->user = &(*surfaces)[i];
        m->mask_fn = holes ? is_there : NULL;
        m->tap_side = scene->texture_count ? 4 : 1;
        m->version = 1;                         /* textures and materials stay as they are while the program runs */
    }
    return meshes;
}

uint32_t rs_map_side(const rs_state *state, const rsm_light *light)
{
    uint32_t side = light->kind == RSM_LIGHT_PATCH ? state->size / 4
                    : light->kind == RSM_LIGHT_POINT || (light->kind == RSM_LIGHT_SPOT && light->cone_half_angle > 1)
                        ? state->size / 2
                        : state->size;
    return side < 4 ? 4 : side;
}

static uint32_t faces_of(const rsm_light *light)
{
    if (light->kind == RSM_LIGHT_PATCH)
        return 5;
    return light->kind == RSM_LIGHT_POINT || (light->kind == RSM_LIGHT_SPOT && light->cone_half_angle > 1) ? 6 : 1;
}

/* Says whether the maps of the last frame can take this frame's lights: as many, each with as many texels. */
static int are_reusable(const rs_state *state, const rsm_light *lights, size_t count)
{
    int same = state->keep && state->maps && state->lamp_count == count;
    for (size_t i = 0; i < count && same; i++) {
        rsm_info info;
        rsm_get_info(state->maps[i], &info);
        same = info.side == rs_map_side(state, &lights[i]) && info.face_count == faces_of(&lights[i]);
    }
    return same;
}

/* Draws the map of one light of the last frame anew if it would change. */
static int renew_map(rs_state *state, size_t i, const rsm_light *light, const rsm_mesh *meshes, size_t mesh_count,
                     char *error)
{
    rsm_stats stats;
    int kept = 0;
    rsm_result result = rsm_redraw(state->maps[i], light, meshes, mesh_count, &kept, &stats);
    if (result != RSM_OK)
        return rs_fail(error, "drawing a map", result);
    state->kept_count += (size_t)kept;
    state->lit_texels += stats.lit_texels;
    state->bad_texels += stats.bad_texels;
    return 0;
}

static int build_map(rs_state *state, const rsm_light *light, const rsm_mesh *meshes, size_t mesh_count, char *error)
{
    rsm_desc desc;
    rsm_result result;
    memset(&desc, 0, sizeof desc);
    desc.light = *light;
    desc.side = rs_map_side(state, light);
    desc.system = state->system;
    result = rsm_map_create(&desc, &state->maps[state->map_count]);
    if (result != RSM_OK)
        return rs_fail(error, "a map", result);
    return renew_map(state, state->map_count++, light, meshes, mesh_count, error);
}

static int build_maps(rs_state *state, const rd_job *job, char *error)
{
    rsm_light *lights = NULL;
    surface *surfaces = NULL;
    rsm_mesh *meshes = convert_scene(job->scene, &surfaces);
    rd_ring *rings = NULL;
    size_t count = 0, ring_count = 0;
    int result = -1;
    state->lit_texels = state->bad_texels = state->kept_count = 0;
    if (!meshes) {
        snprintf(error, EX_ERROR_SIZE, "out of memory");
        return -1;
    }
    if (rs_lights_build(&lights, &count, job, state->points, error) == 0 &&
        (!state->indirect || rs_rings_build(&rings, &ring_count, job, lights, count, error) == 0)) {
        const int reused = are_reusable(state, lights, count);
        rsm_map **maps = calloc(count + ring_count + 1, sizeof(rsm_map *));
        result = maps ? 0 : -1;
        if (reused && maps) {
            memcpy(maps, state->maps, count * sizeof *maps);
            memset(state->maps, 0, count * sizeof *maps);       /* of the old ones, only rings are freed */
        }
        free_maps(state);
        state->maps = maps;
        state->map_count = reused && maps ? count : 0;
        for (size_t i = 0; i < count && result == 0; i++)
            result = reused ? renew_map(state, i, &lights[i], meshes, job->scene->object_count, error)
                            : build_map(state, &lights[i], meshes, job->scene->object_count, error);
        state->lamp_count = state->map_count;
        for (size_t i = 0; i < ring_count && result == 0; i++) {
            result = rs_ring_map(&rings[i], &state->system, &state->maps[state->map_count], error);
            state->map_count += result == 0;
        }
    }
    rd_rings_free(rings, ring_count);
    free(lights);
    free(surfaces);
    free(meshes);
    return result;
}

/* ---- shading ---- */

static int read_pixels(rs_state *state, const rd_job *job, char *error)
{
    size_t count = (size_t)job->gbuffer->width * job->gbuffer->height;
    if (!state->positions || state->pixels != count) {
        free(state->positions);
        free(state->normals);
        free(state->light);
        free(state->bounce);
        state->positions = malloc(3 * count * sizeof(float));
        state->normals = malloc(3 * count * sizeof(float));
        state->light = malloc(3 * count * sizeof(float));
        state->bounce = malloc(3 * count * sizeof(float));
        state->pixels = count;
        state->bytes = 4 * 3 * count * sizeof(float);
    }
    if (!state->positions || !state->normals || !state->light || !state->bounce) {
        snprintf(error, EX_ERROR_SIZE, "out of memory");
        return -1;
    }
    for (size_t i = 0; i < count; i++) {
        const ex_pixel *p = &job->gbuffer->pixels[i];
        for (size_t k = 0; k < 3; k++) {
            state->positions[3 * i + k] = p->object == UINT32_MAX ? 0 : p->position[k];
            state->normals[3 * i + k] = p->object == UINT32_MAX ? 0 : p->normal[k];
        }
    }
    memset(state->light, 0, 3 * count * sizeof(float));
    memset(state->bounce, 0, 3 * count * sizeof(float));
    return 0;
}

/* Column-major; rows of the picture run from the top down. */
void rs_view_projection(const ex_camera *c, float aspect, float m[16])
{
    float back[3], right[3], up[3], length = 0, f = 1 / tanf(0.5f * c->fovy);
    for (int k = 0; k < 3; k++)
        back[k] = c->eye[k] - c->target[k];
    for (int k = 0; k < 3; k++)
        right[k] = c->up[(k + 1) % 3] * back[(k + 2) % 3] - c->up[(k + 2) % 3] * back[(k + 1) % 3];
    length = sqrtf(back[0] * back[0] + back[1] * back[1] + back[2] * back[2]);
    for (int k = 0; k < 3; k++)
        back[k] /= length;
    length = sqrtf(right[0] * right[0] + right[1] * right[1] + right[2] * right[2]);
    for (int k = 0; k < 3; k++)
        right[k] /= length > 0 ? length : 1;
    for (int k = 0; k < 3; k++)
        up[k] = back[(k + 1) % 3] * right[(k + 2) % 3] - back[(k + 2) % 3] * right[(k + 1) % 3];
    memset(m, 0, 16 * sizeof *m);
    for (int k = 0; k < 3; k++) {
        m[4 * k] = f / aspect * right[k];
        m[4 * k + 1] = f * up[k];
        m[4 * k + 2] = m[4 * k + 3] = -back[k];
        m[12] -= m[4 * k] * c->eye[k];
        m[13] -= m[4 * k + 1] * c->eye[k];
        m[14] -= m[4 * k + 2] * c->eye[k];
    }
    m[15] = m[14];
}

/* The frames so far and neighbours, of what a frame has gathered from few samples. Memory is all that may fail. */
static gifilt_result filter(rs_state *state, const rd_job *job, const rsm_points *points)
{
    gifilt_points pixels = { 0 };
    gifilt_desc size = { 0 };
    gifilt_frame frame = { 0 };
    gifilt_result result = GIFILT_OK;
    float matrix[16];
    size.system.allocator.alloc_fn = state->system.allocator.alloc_fn;
    size.system.allocator.free_fn = state->system.allocator.free_fn;
    size.system.allocator.user = state->system.allocator.user;
    size.system.parallel_for = state->system.parallel_for;
    size.system.log = state->system.log;
    size.system.user = state->system.user;
    size.width = job->gbuffer->width;
    size.height = job->gbuffer->height;
    rs_view_projection(&job->scene->camera, (float)job->gbuffer->width / (float)job->gbuffer->height, matrix);
    frame.world_to_clip = matrix;
    frame.rows = GIFILT_ROWS_TOP_FIRST;
    frame.passes = state->passes ? (int)state->passes : -1;
    frame.history = state->history;
    pixels.count = points->count;
    pixels.positions = points->positions;
    pixels.position_stride = points->position_stride;
    pixels.normals = points->normals;
    pixels.normal_stride = points->normal_stride;
    if (!state->filter)
        result = gifilt_create(&size, &state->filter);
    return result == GIFILT_OK ? gifilt_apply(state->filter, &frame, &pixels, state->bounce, state->bounce) : result;
}

static rsm_result bounce(rs_state *state, const rd_job *job, const rsm_points *points)
{
    const rsm_map *const *maps = (const rsm_map *const *)state->maps;
    rsm_result result;
    if (state->mode == RS_INTERPOLATED)
        return rsm_interpolate(maps, state->map_count, &state->gather, &state->interpolation, points, state->bounce,
                               &state->stats);
    result = rsm_gather(maps, state->map_count, &state->gather, points, state->bounce, &state->stats);
    if (result != RSM_OK || state->mode == RS_FULL)
        return result;
    return filter(state, job, points) == GIFILT_OK ? RSM_OK : RSM_ERR_ALLOC;
}

static void write_pixels(const rs_state *state, const rd_job *job, ex_image *out)
{
    for (size_t i = 0; i < 3 * (size_t)state->pixels; i++) {
        float e = (state->direct ? state->light[i] : 0) + (state->indirect ? state->bounce[i] : 0);
        out->rgb[i] = job->gbuffer->pixels[i / 3].albedo[i % 3] * e * 0.318309886f;
    }
}

static int frame_rsm(void *opaque, const rd_job *job, ex_image *out, char *error)
{
    rs_state *state = opaque;
    rsm_points points;
    rsm_result result = RSM_OK;
    double start = ex_seconds(), maps_done, direct_done;
    state->system.user = job->pool;
    state->gather.system = state->shadow.system = state->system;
    state->gather.sample_count = job->samples;
    state->gather.seed = job->seed;
    if (job->gl) {
        if (read_pixels(state, job, error) != 0 || rs_gl_frame(state, job, error) != 0)
            return -1;
        write_pixels(state, job, out);
        return 0;
    }
    if (build_maps(state, job, error) != 0 || read_pixels(state, job, error) != 0)
        return -1;
    memset(&points, 0, sizeof points);
    points.count = state->pixels;
    points.positions = state->positions;
    points.normals = state->normals;
    points.width = job->gbuffer->width;
    maps_done = ex_seconds();
    state->shadow.add = 1;
    for (size_t i = 0; i < state->lamp_count && state->direct && result == RSM_OK; i++)
        result = rsm_direct(state->maps[i], &state->shadow, &points, state->light);
    direct_done = ex_seconds();
    if (result == RSM_OK && state->indirect && state->map_count)
        result = bounce(state, job, &points);
    ex_progress(NULL, 1);
    if (result != RSM_OK)
        return rs_fail(error, "shading", result);
    state->maps_ms = 1000 * (maps_done - start);
    state->direct_ms = 1000 * (direct_done - maps_done);
    state->gather_ms = 1000 * (ex_seconds() - direct_done);
    write_pixels(state, job, out);
    return 0;
}

/* All is built anew for each frame; what stays is the filter's history and, if maps are kept, those that would not
   change. */
static int update_rsm(void *state, const rd_job *job, char *error)
{
    (void)state;
    (void)job;
    (void)error;
    return 0;
}

/* ---- opening ---- */

static const char pattern_words[] = "flux|equation3|log_radial|poisson|low_discrepancy|mixed",
                  mode_words[] = "full|interpolated|denoised";

static int place_of(const char *words, const char *word)
{
    int place = 0;
    for (size_t length = strlen(word); *words; place++) {
        size_t next = strcspn(words, "|");
        if (next == length && memcmp(words, word, length) == 0)
            break;
        words += next + (words[next] == '|');
    }
    return place;
}

/* Of a bias, where the header means its default by 0. */
static float none_of_zero(double value) { return value > 0 ? (float)value : -1; }

static void read_settings(rs_state *state, const rd_job *job)
{
    const rd_settings *s = job->settings;
    rsm_gather_desc *g = &state->gather;
    state->mode = (rs_mode)place_of(mode_words, rd_setting_text(s, "mode"));
    state->direct = !rd_setting_is(s, "only", "indirect");
    state->indirect = !rd_setting_is(s, "only", "direct");
    state->size = (uint32_t)rd_setting_integer(s, "side");
    state->points = (uint32_t)rd_setting_integer(s, "light_point_count");
    state->keep = rd_setting_integer(s, "keep") != 0;
    g->pattern = (rsm_pattern)(RSM_PATTERN_FLUX + place_of(pattern_words, rd_setting_text(s, "pattern")));
    g->paper_weights = rd_setting_integer(s, "paper_weights");
    g->r_max = (float)rd_setting_number(s, "r_max");
    g->r_min = (float)rd_setting_number(s, "r_min");
    g->offset = (float)rd_setting_number(s, "offset") * job->radius;
    g->clamp = (float)rd_setting_number(s, "clamp");
    g->near_limit = (float)rd_setting_number(s, "near_limit");
    g->near_field = (float)rd_setting_number(s, "near_field");
    g->interleave = (uint32_t)rd_setting_integer(s, "interleave");
    if (state->mode == RS_DENOISED && rd_setting_is(s, "interleave", "0"))
        g->interleave = 4;
    if (rd_setting_integer(s, "noise")) {
        g->noise = state->noise;
        g->noise_side = 64;
    }
    state->shadow.tap_side = (uint32_t)rd_setting_integer(s, "tap_side");
    state->shadow.bias = none_of_zero(rd_setting_number(s, "bias"));
    state->shadow.slope_bias = none_of_zero(rd_setting_number(s, "slope_bias"));
    state->interpolation.step = (uint32_t)rd_setting_integer(s, "step");
    state->interpolation.level_count = (uint32_t)rd_setting_integer(s, "level_count");
    state->interpolation.contrast = (float)rd_setting_number(s, "contrast");
    state->interpolation.light_share = (float)rd_setting_number(s, "light_share");
    state->passes = (uint32_t)rd_setting_integer(s, "passes");
    state->history = (uint32_t)rd_setting_integer(s, "history");
}

static int open_rsm(void **out, const rd_job *job, char *error)
{
    rs_state *state;
    rsm_result result = RSM_OK;
    if (rd_setting_is(job->settings, "materials", "full")) {
        snprintf(error, EX_ERROR_SIZE, "rsm: materials=full is not treated: surfaces are diffuse");
        return -1;
    }
    state = calloc(1, sizeof *state);
    if (!state) {
        snprintf(error, EX_ERROR_SIZE, "out of memory");
        return -1;
    }
    state->system.allocator.alloc_fn = take;
    state->system.allocator.free_fn = give;
    state->system.allocator.user = &state->memory;
    state->system.parallel_for = ex_pool_run;
    state->system.progress = ex_terminal() ? ex_pool_progress : NULL;
    state->system.log = ex_pool_log;
    state->system.user = job->pool;
    ex_pool_label(job->pool, "rsm");
    read_settings(state, job);
    if (state->mode == RS_INTERPOLATED && (state->gather.noise || state->gather.interleave > 1)) {
        close_rsm(state);
        snprintf(error, EX_ERROR_SIZE, "rsm: mode=interpolated needs samples without noise and interleave");
        return -1;
    }
    if (state->gather.noise)
        result = rsm_blue_noise(64, 1, &state->system, state->noise);
    if (result != RSM_OK) {
        close_rsm(state);
        return rs_fail(error, "blue noise", result);
    }
    if (job->gl && rs_gl_open(state, job, error) != 0) {
        close_rsm(state);
        return -1;
    }
    *out = state;
    return 0;
}

static void report_rsm(const void *opaque, rd_report *report)
{
    const rs_state *state = opaque;
    report->memory_bytes = state->memory.now + state->bytes + state->gl_bytes;
    report->peak_bytes = state->memory.peak;
    rd_json_text(report->json, "mode",
                 state->mode == RS_FULL       ? "full"
                 : state->mode == RS_DENOISED ? "denoised"
                                              : "interpolated");
    rd_json_integer(report->json, "side", state->size);
    rd_json_integer(report->json, "maps", state->map_count + rs_gl_maps(state));
    rd_json_integer(report->json, "kept_maps", state->kept_count);
    rd_json_integer(report->json, "lit_texels", state->lit_texels);
    rd_json_integer(report->json, "bad_texels", state->bad_texels);
    rd_json_integer(report->json, "pairs", state->stats.pairs);
    rd_json_number(report->json, "evaluated_fraction",
                   state->pixels ? (double)state->stats.evaluated / (double)state->pixels : 0);
    rd_json_number(report->json, "clamped_share", state->stats.clamped_share);
    rd_json_number(report->json, "outside_share", state->stats.outside_share);
    rd_json_number(report->json, "maps_ms", state->maps_ms);
    rd_json_number(report->json, "direct_ms", state->direct_ms);
    rd_json_number(report->json, "gather_ms", state->gather_ms);
}

static const rd_key keys[] = {
    { "only", RD_WORD, "direct|indirect|all", 0, 0, "all", "the part of the light that is wanted" },
    { "mode", RD_WORD, mode_words, 0, 0, "full",
      "each pixel; interpolated from a grid; interleaved sets and a filter" },
    { "side", RD_INTEGER, NULL, 16, 4096, "512",
      "texels a side of a map; cubes half, points of area lights a quarter" },
    { "light_point_count", RD_INTEGER, NULL, 1, 1024, "16",
      "points on all area lights and emitters; directions of a sky" },
    { "keep", RD_WORD, "0|1", 0, 0, "0", "1: maps whose light and casters are as in the last frame are not drawn (cpu)" },
    { "pattern", RD_WORD, pattern_words, 0, 0, "flux", "where samples are taken" },
    { "paper_weights", RD_WORD, "0|1", 0, 0, "0", "1: equation3 weighs samples as the paper does, biased" },
    { "r_max", RD_NUMBER, NULL, 0, 1000, "0", "radius of patterns in sides of the map; 0: up to its border" },
    { "r_min", RD_NUMBER, NULL, 0, 0.99, "0", "inner disc of log_radial, share of the radius; 0: 1/32" },
    { "offset", RD_NUMBER, NULL, 0, 1, "0", "of pixel lights below their surface, in radii of the scene" },
    { "clamp", RD_NUMBER, NULL, 0, 1e18, "0", "bound on cos cos / d^2; 0: none" },
    { "near_limit", RD_NUMBER, NULL, 0, 1e6, "0.3", "bound on a light, in its own radiosity; 0: none" },
    { "near_field", RD_NUMBER, NULL, 0, 32, "3",
      "texels nearer, in their sides, are surfaces, not points (not flux); 0: none" },
    { "noise", RD_WORD, "0|1", 0, 0, "0", "1: patterns turned by blue noise (not flux)" },
    { "interleave", RD_WORD, "0|1|2|4|8", 0, 0, "0", "k x k pixels share the samples; 0: 4 if denoised" },
    { "passes", RD_INTEGER, NULL, 0, 6, "2", "of the filter, denoised" },
    { "history", RD_INTEGER, NULL, 1, 1000, "8", "frames that the filter remembers, denoised" },
    { "step", RD_WORD, "2|4|8|16|32|64", 0, 0, "8", "first grid of interpolation" },
    { "level_count", RD_INTEGER, NULL, 0, 6, "0", "grids of interpolation; 0: all, 1: the paper" },
    { "contrast", RD_NUMBER, NULL, -1, 1e6, "0", "that refines the grid; 0: 0.25, negative: not asked" },
    { "light_share", RD_NUMBER, NULL, -1, 1e6, "0", "of samples, by the nearest light; 0: 0.25, negative: not asked" },
    { "tap_side", RD_INTEGER, NULL, 1, 15, "2", "tap_side x tap_side texels of direct light's shadows" },
    { "bias", RD_NUMBER, NULL, 0, 1000, "0.5", "of direct light, in texels" },
    { "slope_bias", RD_NUMBER, NULL, 0, 1000, "1", "the same, for each unit of slope" },
    { NULL, RD_WORD, NULL, 0, 0, NULL, NULL }
};

const rd_technique rd_rsm = {
    "rsm", "one bounce from reflective shadow maps", NULL,
    400, 0, 1u << 20, 0, 0, 0, keys, open_rsm, update_rsm, frame_rsm, report_rsm, close_rsm
};
