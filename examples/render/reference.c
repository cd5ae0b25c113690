/* reference.c - the technique "reference": a path tracer over Embree that starts at the G-buffer's points.

   At every vertex of a path one sample of the lights and one of the BRDF are combined by the balance heuristic
   (Veach 1997, section 9.2). Sun, spot and point lights have no size: at the first vertex, where they need no random
   number, each is evaluated exactly once a pixel; further on they are chosen like the others. */
#include "ref_bsdf.h"
#include "ref_lights.h"
#include "ref_scene.h"

#include <stdlib.h>
#include <string.h>

#define BATCHES 4              /* independently scrambled parts of a pixel's samples; their spread tells the noise */
#define ROULETTE_DEPTH 4       /* bounces before Russian roulette may end a path */
#define MAX_LAYERS 4096        /* surfaces that a ray with indirect_visibility=0 passes; guards against endless loops */

typedef struct reference {
    rf_scene  *scene;
    rf_lights  lights;
    int        has_lights;
    double     epsilon;        /* offset along the geometric normal */
    int        full, bounces, direct, indirect, indirect_visibility;
    struct { double value, variance; } *noise; /* of each pixel of the last frame, mean of the channels */
    size_t     pixels;
    double     sum, sum_variance, count;       /* of them over frames and lit pixels */
    uint32_t   frames;
    int        noise_known;
} reference;

typedef struct rf_surface { rf_v3 position, geometric; rf_bsdf bsdf; } rf_surface;

/* ---- light at one vertex ---- */

static rf_v3 offset(const reference *r, rf_v3 position, rf_v3 geometric)
{
    return rf_mad(position, geometric, r->epsilon);
}

static int is_lit(const reference *r, rf_v3 origin, const rf_light_sample *light)
{
    rf_v3 d;
    double distance;
    if (light->at_infinity)
        return !rf_scene_blocked(r->scene, origin, light->direction, HUGE_VAL);
    d = rf_sub(light->target, origin);
    distance = rf_length(d);
    return !(distance > 0) || !rf_scene_blocked(r->scene, origin, rf_scale(d, 1 / distance), distance);
}

/* Reflected light of one light sample; mixed: weigh it against BRDF sampling. */
static rf_v3 add_light(const reference *r, const rf_surface *s, const rf_light_sample *light, int mixed)
{
    double bsdf_pdf;
    rf_v3 value = rf_mul(rf_bsdf_eval(&s->bsdf, light->direction, &bsdf_pdf), light->value);
    if (rf_is_black(value) || !is_lit(r, offset(r, s->position, s->geometric), light))
        return rf_make(0, 0, 0);
    return rf_scale(value, light->is_delta || !mixed ? 1 / light->pdf : 1 / (light->pdf + bsdf_pdf));
}

/* What a BRDF-sampled ray from `position` with density pdf sees, weighted against sampling the lights. */
static rf_v3 seen_light(const reference *r, rf_v3 position, rf_v3 direction, double pdf, int area_only,
                        const rf_hit *hit)
{
    rf_v3 sum = rf_make(0, 0, 0), radiance;
    double light_pdf;
    for (uint32_t i = 0; i < r->lights.scene->light_count; i++)
        if (rf_lights_hit(&r->lights, i, area_only, position, direction, hit ? hit->distance : HUGE_VAL, &radiance,
                          &light_pdf))
            sum = rf_mad(sum, radiance, pdf / (pdf + light_pdf));
    if (!hit) {
        radiance = rf_lights_sky(&r->lights, area_only, direction, &light_pdf);
        sum = rf_mad(sum, radiance, pdf / (pdf + light_pdf));
    } else if (!rf_is_black(hit->emission)) {
        light_pdf = rf_lights_emitter_pdf(&r->lights, area_only, hit->emission, hit->distance,
                                          -rf_dot(direction, hit->geometric));
        sum = rf_mad(sum, hit->emission, pdf / (pdf + light_pdf));
    }
    return sum;
}

/* ---- paths ---- */

static void surface_of_pixel(const reference *r, const ex_pixel *pixel, rf_surface *s)
{
    s->position = rf_load(pixel->position);
    s->geometric = rf_load(pixel->geometric);
    rf_bsdf_init(&s->bsdf, rf_load(pixel->normal), rf_load(pixel->view), rf_load(pixel->albedo),
                 (double)pixel->metallic, (double)pixel->roughness, r->full);
}

static void surface_of_hit(const reference *r, const rf_hit *hit, rf_v3 direction, rf_surface *s)
{
    s->position = hit->position;
    s->geometric = hit->geometric;
    rf_bsdf_init(&s->bsdf, hit->normal, rf_scale(direction, -1), hit->base, hit->metallic, hit->roughness, r->full);
}

/* indirect_visibility=0: every lit surface along the ray that faces its origin reflects towards it, as in a technique
   that gathers from reflective shadow maps without testing whether something stands between. */
static rf_v3 all_layers(const reference *r, rf_v3 origin, rf_v3 direction, rf_sampler *sampler)
{
    rf_v3 sum = rf_make(0, 0, 0);
    double near_distance = 0;
    rf_hit hit;
    for (int i = 0; i < MAX_LAYERS && rf_scene_trace(r->scene, origin, direction, near_distance, &hit); i++) {
        rf_surface s;
        rf_light_sample light;
        double u[2];
        surface_of_hit(r, &hit, direction, &s);
        rf_sample_2d(sampler, u);
        if (rf_lights_sample(&r->lights, s.position, 0, u, &light)) {
            double unused;
            rf_v3 reflected = rf_bsdf_eval(&s.bsdf, light.direction, &unused);
            if (rf_dot(light.direction, hit.geometric) > 0 && !rf_is_black(reflected))
                sum = rf_add(sum, add_light(r, &s, &light, 0));
        }
        near_distance = hit.distance + r->epsilon;
    }
    return sum;
}

static rf_v3 trace_path(const reference *r, const rf_surface *first, rf_sampler *sampler)
{
    rf_v3 sum = rf_make(0, 0, 0), throughput = rf_make(1, 1, 1);
    rf_surface s = *first;
    for (int depth = 0; depth <= r->bounces; depth++) {
        int wanted = depth ? r->indirect : r->direct, area_only = depth == 0, below, met;
        rf_light_sample light;
        rf_v3 origin = offset(r, s.position, s.geometric), direction, value;
        rf_hit hit;
        double u[2], pdf;
        rf_sample_2d(sampler, u);
        if (wanted && rf_lights_sample(&r->lights, s.position, area_only, u, &light))
            sum = rf_add(sum, rf_mul(throughput, add_light(r, &s, &light, 1)));
        rf_sample_2d(sampler, u);
        if (!rf_bsdf_sample(&s.bsdf, u, &direction, &value, &pdf))
            break;
        throughput = rf_mul(throughput, value);
        if (depth > ROULETTE_DEPTH) {
            double survival = rf_least(rf_max(throughput), 0.95);
            rf_sample_2d(sampler, u);
            if (u[0] >= survival)
                break;
            throughput = rf_scale(throughput, 1 / survival);
        }
        /* Interpolated normals let directions dip below the surface itself, which hides what is there. */
        below = rf_dot(direction, s.geometric) <= 0;
        met = !below && rf_scene_trace(r->scene, origin, direction, 0, &hit);
        if (wanted && !below) {
            rf_v3 seen = seen_light(r, s.position, direction, pdf, area_only, met ? &hit : NULL);
            sum = rf_add(sum, rf_mul(throughput, seen));
        }
        if (depth == 0 && r->bounces == 1 && !r->indirect_visibility) {
            if (below)
                origin = rf_mad(s.position, s.geometric, -r->epsilon);
            return r->indirect ? rf_add(sum, rf_mul(throughput, all_layers(r, origin, direction, sampler))) : sum;
        }
        if (!met)
            break;
        surface_of_hit(r, &hit, direction, &s);
    }
    return sum;
}

static rf_v3 delta_light(const reference *r, const rf_surface *s)
{
    rf_v3 sum = rf_make(0, 0, 0);
    rf_light_sample light;
    for (uint32_t i = 0; r->direct && i < r->lights.scene->light_count; i++)
        if (rf_lights_delta(&r->lights, i, s->position, &light))
            sum = rf_add(sum, add_light(r, s, &light, 0));
    return sum;
}

/* ---- pixels ---- */

typedef struct frame_work {
    reference    *reference;
    const rd_job *job;
    ex_image     *out;
    uint32_t      first_row;
} frame_work;

/* One of the aa * aa parts of a pixel, the `part`th that takes samples from the pixel's sequences. Writes its value and
   adds the mean of every batch. */
static void shade_part(const frame_work *work, size_t index, uint32_t pixel_hash, uint32_t part,
                       rf_v3 batch_sums[BATCHES])
{
    const reference *r = work->reference;
    uint32_t samples = work->job->samples, batches = samples < BATCHES ? samples : BATCHES;
    rf_v3 total = rf_make(0, 0, 0), fixed;
    rf_surface s;
    surface_of_pixel(r, &work->job->gbuffer->pixels[index], &s);
    fixed = delta_light(r, &s);
    for (uint32_t batch = 0; batch < batches; batch++) {
        uint32_t first = (uint32_t)((uint64_t)samples * batch / batches);
        uint32_t count = (uint32_t)((uint64_t)samples * (batch + 1) / batches) - first;
        uint32_t run = rf_hash(work->job->seed * BATCHES + batch + 0x51ed270bu);
        rf_v3 sum = rf_make(0, 0, 0);
        for (uint32_t i = 0; i < count; i++) {
            rf_sampler sampler = { rf_hash(pixel_hash ^ run), part * count + i, 0 };
            sum = rf_add(sum, trace_path(r, &s, &sampler));
        }
        total = rf_add(total, sum);
        batch_sums[batch] = rf_add(batch_sums[batch], rf_mad(fixed, sum, 1.0 / count));
    }
    total = rf_mad(fixed, total, 1.0 / samples);
    work->out->rgb[3 * index] = (float)total.x;
    work->out->rgb[3 * index + 1] = (float)total.y;
    work->out->rgb[3 * index + 2] = (float)total.z;
}

/* The parts of a pixel share its sequences, so that their samples are stratified together. */
static void shade_pixel(const frame_work *work, size_t x, size_t y)
{
    const rd_job *job = work->job;
    reference *r = work->reference;
    size_t aa = job->aa, wide = job->gbuffer->width, pixel = y * (wide / aa) + x;
    uint32_t batches = job->samples < BATCHES ? job->samples : BATCHES, parts = 0;
    rf_v3 sums[BATCHES] = { { 0, 0, 0 } }, mean = { 0, 0, 0 }, spread = { 0, 0, 0 };
    for (size_t i = 0; i < aa * aa; i++) {
        size_t index = (y * aa + i / aa) * wide + x * aa + i % aa;
        if (job->gbuffer->pixels[index].object != UINT32_MAX)
            shade_part(work, index, rf_hash((uint32_t)pixel + 1), parts++, sums);
    }
    for (uint32_t batch = 0; batch < batches; batch++) {
        rf_v3 value = rf_scale(sums[batch], 1.0 / (double)(aa * aa));
        mean = rf_mad(mean, value, 1.0 / batches);
        spread = rf_mad(spread, rf_mul(value, value), 1.0 / batches);
    }
    spread = rf_sub(spread, rf_mul(mean, mean));
    r->noise[pixel].value = rf_mean(mean);
    r->noise[pixel].variance = batches > 1 ? rf_most(rf_mean(spread), 0) / (batches - 1) : 0;
}

static void shade_row(void *context, size_t row)
{
    const frame_work *work = context;
    for (size_t x = 0; x < work->job->gbuffer->width / work->job->aa; x++)
        shade_pixel(work, x, work->first_row + row);
}

/* In order and on one thread, so that the figure is the same for every thread count. Of an animated scene only the last
   frame is written, so that only its noise counts. */
static void gather_noise(reference *r, const rd_job *job)
{
    if (job->scene->animated) {
        r->sum = r->sum_variance = r->count = 0;
        r->frames = 0;
    }
    for (size_t i = 0; i < r->pixels; i++) {
        if (!(r->noise[i].value > 0))
            continue;
        r->sum += r->noise[i].value;
        r->sum_variance += r->noise[i].variance;
        r->count++;
    }
    r->frames++;
}

/* ---- technique ---- */

static void close_reference(void *state)
{
    reference *r = state;
    if (!r)
        return;
    rf_scene_free(r->scene);
    if (r->has_lights)
        rf_lights_free(&r->lights);
    free(r->noise);
    free(r);
}

static int update_reference(void *state, const rd_job *job, char *error)
{
    reference *r = state;
    double extent = (double)job->radius;
    rf_scene_free(r->scene);
    if (r->has_lights)
        rf_lights_free(&r->lights);
    r->has_lights = 0;
    /* far enough to clear the rounding of float positions, near enough to be invisible */
    for (int k = 0; k < 3; k++)
        extent = rf_most(extent, fabs((double)job->center[k]));
    r->epsilon = 2e-5 * extent;
    r->scene = rf_scene_create(job->scene, job->threads, error);
    if (!r->scene || rf_lights_init(&r->lights, job, r->epsilon, error) != 0)
        return -1;
    r->has_lights = 1;
    return 0;
}

static int open_reference(void **state, const rd_job *job, char *error)
{
    reference *r = calloc(1, sizeof *r);
    if (!r) {
        snprintf(error, EX_ERROR_SIZE, "out of memory");
        return -1;
    }
    r->full = rd_setting_is(job->settings, "materials", "full");
    r->direct = !rd_setting_is(job->settings, "only", "indirect");
    r->indirect = !rd_setting_is(job->settings, "only", "direct");
    r->bounces = r->indirect ? rd_setting_integer(job->settings, "bounces") : 0;
    r->indirect_visibility = rd_setting_integer(job->settings, "indirect_visibility");
    r->noise_known = job->samples > 1;
    r->pixels = (size_t)(job->gbuffer->width / job->aa) * (job->gbuffer->height / job->aa);
    r->noise = calloc(r->pixels, sizeof *r->noise);
    if (!r->noise)
        snprintf(error, EX_ERROR_SIZE, "out of memory");
    else if (!r->indirect_visibility && rd_setting_integer(job->settings, "bounces") != 1)
        snprintf(error, EX_ERROR_SIZE, "indirect_visibility=0 is defined for bounces=1 only");
    else if (update_reference(r, job, error) == 0) {
        *state = r;
        return 0;
    }
    close_reference(r);
    return -1;
}

static int frame_reference(void *state, const rd_job *job, ex_image *out, char *error)
{
    reference *r = state;
    const uint32_t rows = job->gbuffer->height / job->aa, steps = 32;
    frame_work work = { r, job, out, 0 };
    (void)error;
    for (uint32_t step = 0; step < steps; step++) {
        uint32_t end = (uint32_t)((uint64_t)rows * (step + 1) / steps);
        char label[] = "reference";
        ex_progress(label, (float)step / (float)steps);
        ex_pool_run(job->pool, end - work.first_row, shade_row, &work);
        work.first_row = end;
    }
    ex_progress(NULL, 1);
    gather_noise(r, job);
    return 0;
}

static void report_reference(const void *state, rd_report *report)
{
    const reference *r = state;
    uint64_t now, peak, own = r->lights.bytes + r->pixels * sizeof *r->noise;
    double count = r->count > 0 ? r->count : 1, mean = r->sum / count;
    double error = sqrt(r->sum_variance / count / (double)r->frames);      /* frames' errors are independent */
    rf_scene_memory(r->scene, &now, &peak);
    report->memory_bytes = now + own;
    report->peak_bytes = peak + own;
    rd_json_number(report->json, "noise", r->noise_known && mean > 0 ? error / mean : HUGE_VAL);
    rd_json_integer(report->json, "bounces", (uint64_t)r->bounces);
    rd_json_text(report->json, "tracer", rf_scene_version());
}

static const rd_key keys[] = {
    { "bounces", RD_INTEGER, NULL, 0, 1000, "0", "diffuse or glossy bounces between the first surface and the light" },
    { "only", RD_WORD, "direct|indirect|all", 0, 0, "all", "the part of the light that is wanted" },
    { "indirect_visibility", RD_WORD, "0|1", 0, 0, "1",
      "0: light of every surface along a ray, hidden or not; bounces=1" },
    { NULL, RD_WORD, NULL, 0, 0, NULL, NULL }
};

const rd_technique rd_reference = {
    "reference", "path tracer on Embree, to compare the others with",
#if defined DAPPLE_EMBREE && DAPPLE_EMBREE > 0
    NULL,
#else
    "needs Embree: apt-get install libembree-dev",
#endif
    1024, 1, 1u << 24, 1, 0, 1, keys, open_reference, update_reference, frame_reference, report_reference,
    close_reference
};
