/* csm.c - the technique "csm": direct light by Monte Carlo whose visibility comes from coherent shadow maps alone:
   csm.h answers, lightsampling.h draws samples of lights and materials and adds them up.

   Sky        maps of all directions, one block of them for each distinct mesh, instanced
   Sun        one map of its direction for each mesh (sun=exact), or the sky's maps (sun=shared: the nearest direction
              is up to half a cell away, so that a hard shadow moves, or blurs with filter=pcf)
   Others     cube maps of places on the light, for the whole scene as one rigid object (light_maps=local), or the
              maps of directions (light_maps=semi), which refuse lights inside an object's hull */
#include "csm_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define BATCH 16384u             /* samples that are drawn and asked at once */

/* ---- shading ---- */

typedef struct scratch {         /* of one worker */
    float    *position, *normal, *view, *radiance;      /* 3 a pixel */
    lsamp_material *material;
    uint32_t *pixel;
    float    *direction, *distance, *coords, *weight;   /* of all samples of a batch */
    float    *visible;
    float    *asked_point, *asked_light, *answer;       /* of those samples that matter */
    cs_near   near;
    uint32_t *asked_entity, *asked_sample;
    void     *memory;
    uint64_t  queries, refused;
    cohsm_result result;
} scratch;

typedef struct frame_work {
    cs_state       *state;
    const rd_job   *job;
    ex_image       *out;
    const uint32_t *lit;         /* pixels that show a surface */
    size_t          lit_count, per_batch, batches, workers;
    scratch        *scratch;
} frame_work;

static int alloc_scratch(scratch *s, size_t pixels, size_t samples)
{
    const size_t floats = 12 * pixels + (3 + 1 + 3 + 3 + 1 + 3 + 3 + 1 + 7) * samples, words = pixels + 3 * samples;
    float *at;
    memset(s, 0, sizeof *s);
    s->memory = malloc(pixels * sizeof *s->material + floats * sizeof *at + words * sizeof *s->pixel);
    if (!s->memory)
        return -1;
    s->material = s->memory;
    at = (float *)(void *)(s->material + pixels);
    s->position = at, at += 3 * pixels;
    s->normal = at, at += 3 * pixels;
    s->view = at, at += 3 * pixels;
    s->radiance = at, at += 3 * pixels;
    s->direction = at, at += 3 * samples;
    s->distance = at, at += samples;
    s->coords = at, at += 3 * samples;
    s->weight = at, at += 3 * samples;
    s->visible = at, at += samples;
    s->asked_point = at, at += 3 * samples;
    s->asked_light = at, at += 3 * samples;
    s->answer = at, at += samples;
    s->near.point = at, at += 3 * samples;
    s->near.light = at, at += 3 * samples;
    s->near.answer = at, at += samples;
    s->pixel = (uint32_t *)(void *)at;
    s->asked_entity = s->pixel + pixels;
    s->asked_sample = s->asked_entity + samples;
    s->near.sample = s->asked_sample + samples;
    return 0;
}

static float dot(const float *a, const float *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void gather_pixels(const frame_work *w, scratch *s, const uint32_t *pixels, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const ex_pixel *p = &w->job->gbuffer->pixels[pixels[i]];
        lsamp_material *m = &s->material[i];
        memcpy(s->position + 3 * i, p->position, sizeof p->position);
        memcpy(s->normal + 3 * i, p->normal, sizeof p->normal);
        memcpy(s->view + 3 * i, p->view, sizeof p->view);
        memset(s->radiance + 3 * i, 0, 3 * sizeof *s->radiance);
        memset(m, 0, sizeof *m);
        m->kind = w->state->full ? LSAMP_MATERIAL_METAL_ROUGH : LSAMP_MATERIAL_LAMBERT;
        for (int k = 0; k < 3; k++)
            m->diffuse[k] = fminf(p->albedo[k], 1);
        m->metallic = p->metallic;
        m->roughness = p->roughness;
        s->pixel[i] = pixels[i];
    }
}

static int is_cut_off(const cs_light *light, const float *direction)
{
    return light->wide_spot && -dot(direction, light->wide_spot->direction) < light->wide_spot->cos_half_angle;
}

static int is_behind_plane(const cs_state *state, const ex_pixel *p, const float *direction, float distance)
{
    for (size_t i = 0; i < state->plane_count; i++) {
        const cs_plane *plane = &state->planes[i];
        float height = dot(plane->normal, p->position) - plane->distance, slope = dot(plane->normal, direction);
        if (plane->object == p->object)
            continue;                /* its geometric normal says as much */
        if (height > 0 ? height + distance * slope < 0 : height + distance * slope > 0)
            return 1;
    }
    return 0;
}

/* How far along its geometric normal a receiver moves, so that it clears the pixels of the map that it is in. */
static float offset_of(const cs_state *state, const cs_light *light, uint32_t entity, float distance)
{
    if (light->ask == COHSM_LIGHT_PARAMETER || (light->ask == COHSM_LIGHT_INDEX && !light->at_infinity))
        return state->options.offset * 2 * distance / (float)light->map_side;
    return entity ? light->casters->offsets[entity - 1] : 0;
}

/* Only samples that carry light and leave on the outer side of the surface need an answer. */
static size_t gather_questions(const frame_work *w, scratch *s, const cs_light *light, const uint32_t *pixels,
                               size_t count, uint32_t samples)
{
    size_t asked = 0;
    for (size_t i = 0; i < count; i++) {
        const ex_pixel *p = &w->job->gbuffer->pixels[pixels[i]];
        uint32_t entity = light->casters->entity[p->object];
        for (size_t k = i * samples; k < (i + 1) * samples; k++) {
            const float *weight = s->weight + 3 * k, *d = s->direction + 3 * k;
            float move;
            s->visible[k] = 0;
            if (!(weight[0] > 0 || weight[1] > 0 || weight[2] > 0) || dot(d, p->geometric) <= 0 ||
                is_cut_off(light, d) || is_behind_plane(w->state, p, d, s->distance[k]))
                continue;
            move = offset_of(w->state, light, entity, s->distance[k]);
            for (int c = 0; c < 3; c++) {
                s->asked_point[3 * asked + (size_t)c] = p->position[c] + move * p->geometric[c];
                s->asked_light[3 * asked + (size_t)c] =
                    light->ask == COHSM_LIGHT_DIRECTION  ? d[c]
                    : light->ask == COHSM_LIGHT_POSITION ? p->position[c] + s->distance[k] * d[c]
                                                         : s->coords[3 * k + (size_t)c];
            }
            s->asked_entity[asked] = entity;
            s->asked_sample[asked++] = (uint32_t)k;
        }
    }
    return asked;
}

static cohsm_result ask(const frame_work *w, scratch *s, const cs_light *light, size_t asked, uint32_t seed)
{
    static const uint32_t first = 0;
    cohsm_query query = { 0 };
    cohsm_result result;
    size_t refused = 0;
    query.positions = s->asked_point;
    query.count = asked;
    query.lights = s->asked_light;
    query.light_stride = 12;
    query.light_kind = light->ask;
    query.filter = w->state->options.filter;
    query.bias = w->state->options.bias > 0 ? w->state->options.bias : -1;
    query.seed = seed;
    query.entities = s->asked_entity;
    if (light->ask == COHSM_LIGHT_INDEX) {
        query.lights = &first;
        query.one_light = 1;
    } else if (light->is_delta) {
        query.one_light = light->ask == COHSM_LIGHT_POSITION || light->at_infinity;
        query.lights = light->at_infinity ? light->sun : s->asked_light;
    }
    result = cs_visible(light->casters, &query, &s->near, s->answer, &refused);
    for (size_t i = 0; result == COHSM_OK && i < asked; i++)
        s->visible[s->asked_sample[i]] = s->answer[i];
    s->queries += asked;
    s->refused += refused;
    return result;
}

static cohsm_result shade_light(const frame_work *w, scratch *s, uint32_t number, size_t batch, const uint32_t *pixels,
                                size_t count)
{
    const cs_light *light = &w->state->lights[number];
    lsamp_sample_desc desc;
    lsamp_points points;
    lsamp_samples out = { s->direction, s->distance, s->coords, s->weight };
    cohsm_result result;
    size_t asked;
    memset(&desc, 0, sizeof desc);
    memset(&points, 0, sizeof points);
    desc.sample_count = light->is_delta ? 1 : (uint32_t)(w->job->samples / w->state->area_count);
    desc.sample_count = desc.sample_count ? desc.sample_count : 1;
    desc.seed = number;
    desc.frame = w->job->seed;       /* frame i has seed + i: it goes on where frame i - 1 stopped */
    points.count = count;
    points.positions = s->position;
    points.normals = s->normal;
    points.to_eye = s->view;
    points.materials = s->material;
    points.material_stride = sizeof *s->material;
    points.pixels = s->pixel;
    result = (cohsm_result)lsamp_sample(&desc, light->emitter, &points, &out, NULL);     /* the same numbers */
    if (result != COHSM_OK)
        return result;
    asked = gather_questions(w, s, light, pixels, count, desc.sample_count);
    result = ask(w, s, light, asked, (uint32_t)batch * 0x9e3779b9u + w->job->seed * 0x85ebca6bu + number);
    if (result != COHSM_OK)
        return result;
    return (cohsm_result)lsamp_accumulate(count, desc.sample_count, s->weight, s->visible, s->radiance, 0);
}

/* Worker i takes batches i, i + workers, ...: what is in a batch does not depend on the number of workers. */
static void shade_batches(void *context, size_t worker)
{
    const frame_work *w = context;
    scratch *s = &w->scratch[worker];
    for (size_t batch = worker; batch < w->batches && s->result == COHSM_OK; batch += w->workers) {
        const uint32_t *pixels = w->lit + batch * w->per_batch;
        size_t left = w->lit_count - batch * w->per_batch, count = left < w->per_batch ? left : w->per_batch;
        gather_pixels(w, s, pixels, count);
        for (uint32_t i = 0; i < w->state->light_count && s->result == COHSM_OK; i++)
            s->result = shade_light(w, s, i, batch, pixels, count);
        for (size_t i = 0; i < count; i++)
            memcpy(w->out->rgb + 3 * (size_t)pixels[i], s->radiance + 3 * i, 3 * sizeof *s->radiance);
        if (worker == 0)
            ex_progress((void *)(size_t)"csm", (float)batch / (float)w->batches);
    }
}

static int shade(frame_work *w, char *error)
{
    cohsm_result result = COHSM_OK;
    ex_pool_run(w->job->pool, w->workers, shade_batches, w);
    ex_progress(NULL, 1);
    for (size_t i = 0; i < w->workers; i++) {
        if (result == COHSM_OK)
            result = w->scratch[i].result;
        w->state->queries += w->scratch[i].queries;
        w->state->refused += w->scratch[i].refused;
    }
    if (result != COHSM_OK)
        return cs_failed("shading", result, error);
    return w->state->refused ? cs_refused(w->state->refused, error) : 0;
}

static int shade_on_cpu(cs_state *state, const rd_job *job, ex_image *out, char *error)
{
    size_t pixels = (size_t)job->gbuffer->width * job->gbuffer->height;
    uint32_t *lit = malloc((pixels + 1) * sizeof *lit);
    frame_work w = { state, job, out, lit, 0, 0, 0, (size_t)job->threads, NULL };
    int result = 0;
    w.per_batch = job->samples < BATCH ? BATCH / job->samples : 1;
    w.scratch = calloc(w.workers, sizeof *w.scratch);
    for (size_t i = 0; lit && i < pixels; i++)
        if (job->gbuffer->pixels[i].object != UINT32_MAX)
            lit[w.lit_count++] = (uint32_t)i;
    w.batches = (w.lit_count + w.per_batch - 1) / w.per_batch;
    for (size_t i = 0; w.scratch && i < w.workers && result == 0; i++)
        result = alloc_scratch(&w.scratch[i], w.per_batch, w.per_batch * job->samples);
    if (!lit || !w.scratch || result != 0)
        result = cs_out_of_memory(error);
    else
        result = shade(&w, error);
    for (size_t i = 0; w.scratch && i < w.workers; i++)
        free(w.scratch[i].memory);
    free(w.scratch);
    free(lit);
    return result;
}

static int frame_csm(void *opaque, const rd_job *job, ex_image *out, char *error)
{
    cs_state *state = opaque;
    return state->gl ? cs_gl_frame(state, job, out, error) : shade_on_cpu(state, job, out, error);
}

/* ---- opening ---- */

static const char layers_words[] = "z1z2|z1z3_sphere|z1z3_far", filter_words[] = "nearest|pcf|roulette",
                  order_words[] = "auto|scanline|zigzag|zigzag_theta|hilbert",
                  orientation_words[] = "auto|polar|minimal|two_poles";

/* Place of a word in a list: 0, 1, ... */
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

static void read_options(cs_options *o, const rd_settings *settings)
{
    o->side = (uint32_t)rd_setting_integer(settings, "side");
    o->map_side = (uint32_t)rd_setting_integer(settings, "map_side");
    o->light_side = (uint32_t)rd_setting_integer(settings, "light_side");
    o->light_map_size = (uint32_t)rd_setting_integer(settings, "light_map_side");
    o->hard_size = (uint32_t)rd_setting_integer(settings, "hard_map_side");
    o->layers = (cohsm_layers)(COHSM_LAYERS_Z1Z2 + place_of(layers_words, rd_setting_text(settings, "layers")));
    o->order = (cohsm_order)(COHSM_ORDER_DEFAULT + place_of(order_words, rd_setting_text(settings, "order")));
    o->orientation = (cohsm_orientation)(COHSM_ORIENTATION_DEFAULT +
                                         place_of(orientation_words, rd_setting_text(settings, "orientation")));
    if (o->order != COHSM_ORDER_DEFAULT && o->orientation == COHSM_ORIENTATION_DEFAULT)
        o->orientation = COHSM_ORIENTATION_POLAR;
    o->depth_bits = (uint32_t)rd_setting_integer(settings, "depth_bits");
    o->open_thickness = (float)rd_setting_number(settings, "open_thickness");
    o->layout = rd_setting_is(settings, "layout", "fast") ? COHSM_LAYOUT_FAST : COHSM_LAYOUT_COMPACT;
    o->filter = (cohsm_filter)(COHSM_FILTER_NEAREST + place_of(filter_words, rd_setting_text(settings, "filter")));
    o->bias = (float)rd_setting_number(settings, "bias");
    o->offset = (float)rd_setting_number(settings, "offset");
    o->semi = rd_setting_is(settings, "light_maps", "semi");
    o->emitters_cast = rd_setting_is(settings, "lamp_shadow", "own");
    o->shared_sun = rd_setting_is(settings, "sun", "shared");
    o->whole = rd_setting_is(settings, "objects", "auto") ? -1 : rd_setting_is(settings, "objects", "whole");
}

static int wants_directions(const cs_state *state, const cs_light *light)
{
    return light->at_infinity ? !light->is_delta || state->options.shared_sun : state->options.semi;
}

static int build_maps(cs_state *state, cs_light *light, const rd_job *job, char *error)
{
    cohsm_domain domain;
    int found;
    if (wants_directions(state, light)) {
        light->ask = light->at_infinity ? COHSM_LIGHT_DIRECTION : COHSM_LIGHT_POSITION;
        light->casters = &state->directions;
        return 0;
    }
    light->ask = light->is_delta ? COHSM_LIGHT_INDEX : COHSM_LIGHT_PARAMETER;
    light->casters = &light->own;
    light->map_side = light->is_delta ? state->options.hard_size : state->options.light_map_size;
    if (light->at_infinity)
        return cs_casters_build(&light->own, state, job, light->sun, error);
    if (cs_light_domain(light, &state->options, &domain, error) != 0)
        return -1;
    found = cs_baked_places(state, job, &domain, &light->own, error);
    if (found > 0) {
        cohsm_info info;
        cohsm_get_info(light->own.maps[0], &info);
        light->map_side = info.map_side;
    }
    return found ? (found > 0 ? 0 : -1) : cs_casters_build_local(&light->own, state, job, &domain, light, error);
}

/* Lights with their maps, and planes. */
static void free_lights(cs_state *state)
{
    for (size_t i = 0; i < state->light_count; i++)
        cs_light_free(&state->lights[i]);
    free(state->lights);
    free(state->planes);
    state->lights = NULL;
    state->planes = NULL;
    state->light_count = state->area_count = state->plane_count = 0;
}

static void close_csm(void *opaque)
{
    cs_state *state = opaque;
    if (!state)
        return;
    cs_gl_close(state);
    free_lights(state);
    cs_casters_free(&state->directions);
    cs_baked_close(state);
    pthread_mutex_destroy(&state->memory.lock);
    free(state);
}

/* Maps of all directions for those lights that ask for them, from a file or built. */
static int build_directions(cs_state *state, const rd_job *job, char *error)
{
    const int found = cs_baked_directions(state, job, &state->directions, error);
    return found ? (found > 0 ? 0 : -1) : cs_casters_build(&state->directions, state, job, NULL, error);
}

static int build_all(cs_state *state, const rd_job *job, char *error)
{
    int directions = 0;
    if (cs_baked_begin(state, job, error) != 0 || cs_lights_build(state, job, error) != 0 ||
        cs_planes_build(&state->planes, &state->plane_count, job->scene, error) != 0)
        return -1;
    for (size_t i = 0; i < state->light_count; i++)
        directions |= wants_directions(state, &state->lights[i]);
    if (directions && !state->directions.count && build_directions(state, job, error) != 0)
        return -1;
    for (size_t i = 0; i < state->light_count; i++)
        if (build_maps(state, &state->lights[i], job, error) != 0)
            return -1;
    return cs_baked_all_used(state, error);
}

static int open_csm(void **out, const rd_job *job, char *error)
{
    cs_state *state = calloc(1, sizeof *state);
    if (!state)
        return cs_out_of_memory(error);
    cs_memory_init(&state->memory);
    read_options(&state->options, job->settings);
    state->full = rd_setting_is(job->settings, "materials", "full");
    if (cs_baked_open(state, job, error) == 0 && build_all(state, job, error) == 0 &&
        (!job->gl || cs_gl_open(state, job, error) == 0)) {
        *out = state;
        return 0;
    }
    close_csm(state);
    return -1;
}

/* Rigid objects keep their maps of all directions: only the instances move. Maps of one sun's direction and of places
   on lights hold where things are, and are built anew. */
static int update_csm(void *opaque, const rd_job *job, char *error)
{
    cs_state *state = opaque;
    cs_gl_close(state);
    free_lights(state);
    if (!state->directions.count || !cs_casters_move(&state->directions, state, job->scene))
        cs_casters_free(&state->directions);
    return build_all(state, job, error) != 0 || (job->gl && cs_gl_open(state, job, error) != 0) ? -1 : 0;
}

/* ---- figures ---- */

typedef struct totals { uint64_t blocks, maps, segments, bytes, fast_bytes; double raw; } totals;

static void add_totals(totals *t, const cs_casters *c)
{
    for (size_t i = 0; i < c->map_count; i++) {
        cohsm_info info;
        cohsm_get_info(c->maps[i], &info);
        t->blocks++;
        t->maps += info.map_count;
        t->segments += info.segment_count;
        t->bytes += info.bytes;
        t->fast_bytes += info.fast_bytes;
        t->raw += info.ratio * (double)info.bytes;
    }
}

static void report_csm(const void *opaque, rd_report *report)
{
    const cs_state *state = opaque;
    totals t = { 0, 0, 0, 0, 0, 0 };
    uint64_t own = 0;
    add_totals(&t, &state->directions);
    for (size_t i = 0; i < state->light_count; i++) {
        add_totals(&t, &state->lights[i].own);
        own += state->lights[i].bytes;
    }
    report->memory_bytes = state->memory.now + own;
    report->peak_bytes = state->memory.peak;
    rd_json_integer(report->json, "side", state->options.side);
    rd_json_integer(report->json, "map_side", state->options.map_side);
    rd_json_integer(report->json, "blocks", t.blocks);
    rd_json_integer(report->json, "maps", t.maps);
    rd_json_integer(report->json, "segments", t.segments);
    rd_json_integer(report->json, "map_bytes", t.bytes);
    rd_json_integer(report->json, "fast_bytes", t.fast_bytes);
    rd_json_number(report->json, "ratio", t.bytes ? t.raw / (double)t.bytes : 0);
    rd_json_integer(report->json, "lights", state->light_count);
    if (!state->gl)
        rd_json_integer(report->json, "queries", state->queries);
}

static const rd_key keys[] = {
    { "side", RD_INTEGER, NULL, 1, 2048, "128", "maps of directions a side of their domain" },
    { "map_side", RD_INTEGER, NULL, 4, 1024, "128", "pixels a side of each of them" },
    { "layers", RD_WORD, layers_words, 0, 0, "z1z2", "z1z3: smaller, for closed surfaces with nothing else near" },
    { "order", RD_WORD, order_words, 0, 0, "auto", "how maps follow one another; auto: tries them" },
    { "orientation", RD_WORD, orientation_words, 0, 0, "auto",
      "which way is up in a map of a direction; auto: with order=auto by trial, else polar" },
    { "depth_bits", RD_INTEGER, NULL, 4, 8, "8", "of the grid of stored depths" },
    { "open_thickness", RD_NUMBER, NULL, 0, 1024, "0", "pixels that a surface without a back is thick; 0: 8" },
    { "layout", RD_WORD, "compact|fast", 0, 0, "compact", "of maps in memory; fast: trays, of --baked files too" },
    { "filter", RD_WORD, filter_words, 0, 0, "nearest", "of map and pixel; pcf and roulette have the same mean" },
    { "bias", RD_NUMBER, NULL, 0, 100, "1", "towards the light, in map pixels" },
    { "offset", RD_NUMBER, NULL, 0, 100, "0.5", "of receivers along the geometric normal, in map pixels" },
    { "objects", RD_WORD, "auto|each|whole", 0, 0, "auto", "maps of directions for each mesh, or of all as one" },
    { "sun", RD_WORD, "exact|shared", 0, 0, "exact", "a map of its direction, or the nearest of all directions" },
    { "hard_map_side", RD_INTEGER, NULL, 4, 1024, "1024", "pixels a side of the map of a sun, spot or point" },
    { "light_maps", RD_WORD, "local|semi", 0, 0, "local", "cube maps of places on a light, or maps of directions" },
    { "lamp_shadow", RD_WORD, "others|own", 0, 0, "others", "of an emissive mesh: does it also shadow its own light" },
    { "light_side", RD_INTEGER, NULL, 1, 128, "8", "places a side of an area light" },
    { "light_map_side", RD_INTEGER, NULL, 4, 1024, "256", "pixels a side of a cube's face" },
    { NULL, RD_WORD, NULL, 0, 0, NULL, NULL }
};

const rd_technique rd_csm = {
    "csm", "coherent shadow maps: precomputed visibility of rigid objects", NULL,
    256, 1, 65536, 1, 1, 0, keys, open_csm, update_csm, frame_csm, report_csm, close_csm
};
