/* envshadow.c - the technique "envshadow": the sky as k directional lights (envlights.h), each with a shadow map of its
   own, rendered anew for every frame by the software rasteriser of envshadow.h. Suns are further lights. Light that
   has a place (spots, points, area lights, emissive meshes) is not what it does. */
#include "envshadow_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

int es_failed(const char *what, const char *why, char *error)
{
    snprintf(error, EX_ERROR_SIZE, "envshadow: %.120s: %s", what, why);
    return -1;
}

int es_refuse(const char *why, char *error)
{
    snprintf(error, EX_ERROR_SIZE, "envshadow: %.200s", why);
    return -1;
}

enum { MEMORY_HEAD = 16 };       /* holds the size and keeps the alignment of malloc */

static void *counted_alloc(size_t size, void *user)
{
    es_memory *memory = user;
    char *block = size <= SIZE_MAX - MEMORY_HEAD ? malloc(size + MEMORY_HEAD) : NULL;
    if (!block)
        return NULL;
    memcpy(block, &size, sizeof size);
    memory->now += size;
    if (memory->peak < memory->now)
        memory->peak = memory->now;
    return block + MEMORY_HEAD;
}

static void counted_free(void *pointer, void *user)
{
    es_memory *memory = user;
    char *block = (char *)pointer - MEMORY_HEAD;
    size_t size;
    memcpy(&size, block, sizeof size);
    memory->now -= size;
    free(block);
}

/* ---- lights ---- */

static const char method_words[] = "structured|median|variance|cdf", filter_words[] = "auto|plain|smooth|pcf|penumbra";

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

static int check_lights(const rd_job *job, char *error)
{
    for (uint32_t i = 0; i < job->scene->light_count; i++)
        if (job->scene->lights[i].kind != EX_LIGHT_SUN)
            return es_refuse("treats skies and suns; spots, points and area lights have a place", error);
    if (job->emitter_count)
        return es_refuse("emissive meshes are not treated (--set emitters=0 leaves them out)", error);
    if (!job->scene->sky.width && !job->scene->light_count)
        return es_refuse("no sky and no sun", error);
    return 0;
}

/* About +Y by the right-hand rule, as ex_sky has it. */
static void make_rotation(float angle, float m[16])
{
    memset(m, 0, 16 * sizeof *m);
    m[0] = m[10] = cosf(angle);
    m[8] = sinf(angle);
    m[2] = -m[8];
    m[5] = m[15] = 1;
}

static void add_suns(es_state *s, const ex_scene *scene)
{
    s->count = s->sky_count;
    for (uint32_t i = 0; i < scene->light_count; i++) {
        envlt_light *light = &s->lights[s->count++];
        memset(light, 0, sizeof *light);
        memcpy(light->direction, scene->lights[i].direction, sizeof light->direction);
        memcpy(light->irradiance, scene->lights[i].value, sizeof light->irradiance);
        light->flags = ENVLT_LIGHT_SUN;
        light->id = UINT32_MAX - 1 - i;
    }
}

static int build_lights(es_state *s, const rd_job *job, char *error)
{
    const ex_sky *sky = &job->scene->sky;
    envlt_map map = { ENVLT_PROJECTION_LATLONG, sky->width, sky->height, sky->rgb, 0 };
    envlt_desc desc;
    envlt_result result;
    memset(&desc, 0, sizeof desc);
    desc.light_count = (uint32_t)rd_setting_integer(job->settings, "light_count");
    desc.method = (envlt_method)(ENVLT_METHOD_STRUCTURED +
                                 place_of(method_words, rd_setting_text(job->settings, "method")));
    desc.split_sun = rd_setting_integer(job->settings, "split_sun");
    desc.hemisphere = rd_setting_integer(job->settings, "hemisphere");
    desc.system.allocator.alloc_fn = counted_alloc;
    desc.system.allocator.free_fn = counted_free;
    desc.system.allocator.user = &s->memory;
    if (sky->width) {
        double start = ex_seconds();
        result = envlt_create(&desc, &map, &s->sky, &s->stats);
        if (result != ENVLT_OK)
            return es_failed("lights", envlt_result_text(result), error);
        envlt_get_lights(s->sky, &s->sky_count);
        s->lights_ms = 1000 * (ex_seconds() - start);
        if (rd_setting_integer(job->settings, "residual")) {
            result = envlt_residual_sh(s->sky, &map, s->residual);
            if (result != ENVLT_OK)
                return es_failed("residual", envlt_result_text(result), error);
            s->has_residual = 1;
        }
    }
    s->lights = calloc((size_t)s->sky_count + job->scene->light_count + 1, sizeof *s->lights);
    return s->lights ? 0 : es_refuse("out of memory", error);
}

static int take_lights(es_state *s, const rd_job *job, char *error)
{
    float rotation[16];
    envlt_result result = ENVLT_OK;
    if (s->sky && rd_setting_integer(job->settings, "jitter"))
        result = envlt_jitter(s->sky, job->seed, 0, s->lights);
    else if (s->sky_count)
        memcpy(s->lights, envlt_get_lights(s->sky, NULL), s->sky_count * sizeof *s->lights);
    make_rotation(job->scene->sky.rotation, rotation);
    if (result == ENVLT_OK)
        result = envlt_rotate(s->lights, s->sky_count, rotation);
    add_suns(s, job->scene);
    return result == ENVLT_OK ? 0 : es_failed("lights", envlt_result_text(result), error);
}

/* As envshadow.h takes them. */
static envsh_lights all_lights(const es_state *s)
{
    const envlt_light *first = s->lights;
    envsh_lights lights = { s->count, first->direction, first->irradiance, first->axis_u, first->axis_v,
                            sizeof *first };
    return lights;
}

/* ---- shading ---- */

/* For as many pixels as the picture has now: the viewer's changes. */
static int allocate_pixels(es_state *s, const rd_job *job, char *error)
{
    size_t pixels = (size_t)job->gbuffer->width * job->gbuffer->height;
    if (s->points && s->pixels == pixels)
        return 0;
    free(s->points);
    free(s->sum);
    s->sum = NULL;
    s->pixels = pixels;
    s->points = malloc(12 * (pixels + 1) * sizeof *s->points);
    if (!s->points)
        return es_refuse("out of memory", error);
    s->normals = s->points + 3 * pixels;
    s->geometric = s->normals + 3 * pixels;
    s->irradiance = s->geometric + 3 * pixels;
    s->receivers.positions = s->points;
    s->receivers.normals = s->normals;
    s->receivers.geometric_normals = s->geometric;
    s->receivers.count = pixels;
    if (rd_setting_integer(job->settings, "jitter") && !job->scene->animated) {
        s->sum = calloc(3 * pixels + 1, sizeof *s->sum);
        if (!s->sum)
            return es_refuse("out of memory", error);
    }
    return 0;
}

/* Pixels keep their places, so that both back ends turn their taps alike. */
static void gather(es_state *s, const ex_gbuffer *g)
{
    for (size_t i = 0; i < s->pixels; i++) {
        const ex_pixel *p = &g->pixels[i];
        int seen = p->object != UINT32_MAX;
        for (size_t k = 0; k < 3; k++) {
            s->points[3 * i + k] = seen ? p->position[k] : 0;
            s->normals[3 * i + k] = seen ? p->normal[k] : 0;
            s->geometric[3 * i + k] = seen ? p->geometric[k] : 0;
        }
    }
}

/* What the lights leave out of the unshadowed light, dimmed as the lights' light is. */
static void add_residual(const es_state *s, const float *normal, float *e)
{
    float open[3] = { 0, 0, 0 }, rest[3], n[3], shade[3];
    for (uint32_t i = 0; i < s->sky_count; i++) {
        const envlt_light *l = &s->lights[i];
        float cosine = normal[0] * l->direction[0] + normal[1] * l->direction[1] + normal[2] * l->direction[2];
        for (int k = 0; k < 3 && cosine > 0; k++)
            open[k] += cosine * l->irradiance[k];
    }
    memcpy(n, normal, sizeof n);
    envlt_sh_irradiance(s->residual, n, rest);
    for (int k = 0; k < 3; k++) {
        shade[k] = open[k] > 0 ? fminf(e[k] / open[k], 1) : 0;
        e[k] = fmaxf(e[k] + shade[k] * rest[k], 0);
    }
}

static void write_pixels(es_state *s, const rd_job *job, ex_image *out)
{
    double share = 1.0 / ((double)job->frame + 1);
    for (size_t i = 0; i < s->pixels; i++) {
        const ex_pixel *p = &job->gbuffer->pixels[i];
        float *e = s->irradiance + 3 * i;
        if (p->object == UINT32_MAX)
            continue;
        if (s->has_residual)
            add_residual(s, s->normals + 3 * i, e);
        for (size_t k = 0; k < 3; k++) {
            double radiance = (double)(fminf(p->albedo[k], 1) * e[k]) * 0.318309886;
            if (s->sum)
                radiance = (s->sum[3 * i + k] += radiance) * share;
            out->rgb[3 * i + k] = (float)radiance;
        }
    }
}

typedef struct draw_context { const es_state *state; double ms; } draw_context;

static envsh_result draw_casters(void *user, envsh_maps *maps)
{
    draw_context *context = user;
    double start = ex_seconds();
    envsh_result result = es_casters_draw(context->state, maps);
    context->ms += 1000 * (ex_seconds() - start);
    return result;
}

static int shade_on_cpu(es_state *s, char *error)
{
    draw_context context = { s, 0 };
    double start = ex_seconds();
    envsh_lights lights = all_lights(s);
    envsh_result result = envsh_illuminate(s->maps, &lights, es_casters_bounds(s), draw_casters, &context, &s->query,
                                           &s->receivers, s->irradiance);
    if (result != ENVSH_OK)
        return es_failed("shading", envsh_result_text(result), error);
    s->maps_ms = context.ms;
    s->shade_ms = 1000 * (ex_seconds() - start) - context.ms;
    return 0;
}

static int shade_on_gl(es_state *s, const rd_job *job, char *error)
{
    envsh_lights lights = all_lights(s);
    envsh_result result = envsh_maps_begin(s->maps, &lights, es_casters_bounds(s));
    return result == ENVSH_OK ? es_gl_frame(s, job, error)
                              : es_failed("matrices", envsh_result_text(result), error);
}

static int frame_envshadow(void *opaque, const rd_job *job, ex_image *out, char *error)
{
    es_state *s = opaque;
    if (allocate_pixels(s, job, error) != 0 || take_lights(s, job, error) != 0)
        return -1;
    gather(s, job->gbuffer);
    s->query.seed = job->seed;
    if ((s->gl ? shade_on_gl(s, job, error) : shade_on_cpu(s, error)) != 0)
        return -1;
    write_pixels(s, job, out);
    return 0;
}

/* ---- opening ---- */

static void read_query(es_state *s, const rd_job *job)
{
    int filter = place_of(filter_words, rd_setting_text(job->settings, "filter"));
    memset(&s->query, 0, sizeof s->query);
    s->query.extent_scale = 1;
    s->query.tap_count = job->samples;
    s->query.filter = filter ? (envsh_filter)(ENVSH_FILTER_PLAIN + filter - 1)
                             : job->samples > 1 ? ENVSH_FILTER_PENUMBRA : ENVSH_FILTER_PLAIN;
    if (!rd_setting_is(job->settings, "radius", "auto"))
        s->query.radius = (float)rd_setting_number(job->settings, "radius");
    else
        s->query.radius = s->query.filter == ENVSH_FILTER_PENUMBRA ? 12 : 2;
    s->query.bias = (float)rd_setting_number(job->settings, "bias");
    if (s->query.radius <= 0)            /* 0 would be the header's default */
        s->query.radius = -1;
    if (s->query.bias <= 0)
        s->query.bias = -1;
}

static int create_maps(es_state *s, const rd_job *job, char *error)
{
    envsh_maps_desc desc;
    envsh_result result;
    uint32_t all = s->sky_count + job->scene->light_count;
    s->choose_cluster = job->gl && rd_setting_is(job->settings, "capacity", "auto");
    s->cluster = s->choose_cluster ? ES_MOST_CHOSEN : (uint32_t)rd_setting_integer(job->settings, "capacity");
    s->cluster = s->cluster && s->cluster < all ? s->cluster : all;
    s->rgba = (uint32_t)rd_setting_integer(job->settings, "rgba");
    memset(&desc, 0, sizeof desc);
    desc.map_side = (uint32_t)rd_setting_integer(job->settings, "map_side");
    desc.rgba = (int)s->rgba;
    desc.no_depth = job->gl != NULL;
    desc.system.allocator.alloc_fn = counted_alloc;
    desc.system.allocator.free_fn = counted_free;
    desc.system.allocator.user = &s->memory;
    desc.system.parallel_for = ex_pool_run;
    desc.system.progress = job->pool && ex_terminal() ? ex_pool_progress : NULL;
    desc.system.log = ex_pool_log;
    desc.system.user = job->pool;
    if (job->pool)
        ex_pool_label(job->pool, "envshadow");
    result = envsh_maps_create(&desc, job->gl ? all : s->cluster, &s->maps);
    if (result != ENVSH_OK)
        return es_failed("atlas", envsh_result_text(result), error);
    envsh_get_info(s->maps, &s->atlas);
    return 0;
}

static void close_envshadow(void *opaque)
{
    es_state *s = opaque;
    if (!s)
        return;
    es_gl_close(s);
    es_casters_free(s);
    envsh_maps_free(s->maps);
    envlt_free(s->sky);
    free(s->lights);
    free(s->points);
    free(s->sum);
    free(s);
}

static int open_envshadow(void **out, const rd_job *job, char *error)
{
    es_state *s;
    if (check_lights(job, error) != 0)
        return -1;
    if (rd_setting_is(job->settings, "materials", "full"))
        return es_refuse("materials=full is not treated", error);
    s = calloc(1, sizeof *s);
    if (!s)
        return es_refuse("out of memory", error);
    if (build_lights(s, job, error) == 0 && create_maps(s, job, error) == 0 &&
        es_casters_build(s, job->scene, job->gl != NULL, error) == 0 && (!job->gl || es_gl_open(s, job, error) == 0)) {
        read_query(s, job);
        *out = s;
        return 0;
    }
    close_envshadow(s);
    return -1;
}

/* Nothing is kept of the geometry but copies. */
static int update_envshadow(void *opaque, const rd_job *job, char *error)
{
    es_state *s = opaque;
    if (check_lights(job, error) != 0 || es_casters_build(s, job->scene, job->gl != NULL, error) != 0)
        return -1;
    return s->gl ? es_gl_update(s, error) : 0;
}

static void report_envshadow(const void *opaque, rd_report *report)
{
    const es_state *s = opaque;
    static const char *const filters[] = { "plain", "smooth", "pcf", "penumbra" };
    report->memory_bytes = s->memory.now;
    report->peak_bytes = s->memory.peak;
    if (s->gl)
        es_gl_report(s, report);
    rd_json_integer(report->json, "lights", s->count);
    rd_json_integer(report->json, "map_side", s->atlas.map_side);
    rd_json_integer(report->json, "capacity", s->cluster);
    rd_json_text(report->json, "filter", filters[s->query.filter - ENVSH_FILTER_PLAIN]);
    rd_json_integer(report->json, "atlas_width", s->atlas.width);
    rd_json_integer(report->json, "atlas_height", s->atlas.height);
    rd_json_integer(report->json, "atlas_pages", s->atlas.page_count);
    rd_json_integer(report->json, "bad_texels", s->stats.bad_texels);
    rd_json_number(report->json, "lights_ms", s->lights_ms);
    rd_json_number(report->json, "shadow_ms", s->maps_ms);
    rd_json_number(report->json, "light_ms", s->shade_ms);
}

static const rd_key keys[] = {
    { "light_count", RD_INTEGER, NULL, 1, 8192, "256", "directional lights that the sky becomes" },
    { "method", RD_WORD, method_words, 0, 0, "variance", "how: structured importance sampling, cuts, inversion" },
    { "map_side", RD_INTEGER, NULL, 16, 4096, "256", "texels a side of a shadow map" },
    { "filter", RD_WORD, filter_words, 0, 0, "auto", "of a map; auto: plain with --samples 1, else penumbra" },
    { "radius", RD_NUMBER, "auto", 0, 64, "auto", "texels: of smooth and pcf (2), at most of penumbra (12)" },
    { "bias", RD_NUMBER, NULL, 0, 100, "1", "along the geometric normal at grazing light, in texels" },
    { "capacity", RD_INTEGER, "auto", 0, 8192, "0", "lights held at once, algorithm 2; 0: all; auto: GL times some" },
    { "rgba", RD_WORD, "0|1", 0, 0, "0", "four maps share a texel's channels" },
    { "split_sun", RD_WORD, "0|1", 0, 0, "0", "a small bright spot becomes a light of its own" },
    { "hemisphere", RD_WORD, "0|1", 0, 0, "0", "only the upper half of the sky" },
    { "residual", RD_WORD, "0|1", 0, 0, "0", "adds what the lights leave out, in spherical harmonics" },
    { "jitter", RD_WORD, "0|1", 0, 0, "0", "directions move inside their strata; --frames are averaged" },
    { NULL, RD_WORD, NULL, 0, 0, NULL, NULL }
};

const rd_technique rd_envshadow = {
    "envshadow", "shadow maps of many lights taken from an environment map", NULL,
    16, 1, ENVSH_MAX_TAPS, 0, 0, 0, keys, open_envshadow, update_envshadow, frame_envshadow, report_envshadow,
    close_envshadow
};
