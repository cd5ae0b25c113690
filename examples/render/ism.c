/* ism.c - the technique "ism": bounced light from virtual point lights whose shadows are imperfect shadow maps.

   A frame renders reflective shadow maps from the lights, lets ism.h choose VPLs, scatter points and shade, and adds
   direct light: of suns, spots and points by a shadow map, of area lights, emissive meshes and skies by VPLs of
   their own, with imperfect shadow maps too. */
#include "ism_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_BOUNCES 8
#define EMISSION_POINTS 4096
#define EMISSION_SIDE 16
#define BOUNCE_SIDE 8          /* texels a side of each map that become pVPLs of the next bounce */
#define GROUND (MAX_BOUNCES + 1)       /* the level of the ground beyond the pictures, a part of bounce 1 */
#define LEVELS (MAX_BOUNCES + 2)

typedef struct ism_state {
    ism_maps   *maps[LEVELS];            /* [0]: emitted light; [k]: bounce k; [GROUND] */
    size_t      peaks[LEVELS];           /* while they were shaded */
    ism_shading shading;
    im_mesh     mesh;
    im_gl      *gl;                      /* --backend gl */
    int         bounces, direct, indirect, has_ground;
    int         light_rsm;
    uint32_t    rsm, shadow, light_points;
    size_t      direct_bytes;            /* the shadow map of direct light */
    int         keep;
    im_rsms     last;                    /* of the frame before, with keep=1 */
    size_t      rsm_count, kept;         /* pictures of this frame, and how many are those of the one before */
    ism_stats   stats;                   /* of the first bounce, or of emitted light where there is none */
    double      rsm_ms, direct_ms, choose_ms, build_ms, shade_ms;
} ism_state;

/* ---- settings ---- */

static int word_index(const rd_job *job, const char *key, const char *const *words)
{
    int i = 0;
    while (words[i] && !rd_setting_is(job->settings, key, words[i]))
        i++;
    return i;
}

/* The ground's power is many times that of what the pictures show: among their VPLs it would leave none to texels whose
   effect no view sample found. A quarter as many of its own do, for its light is smooth. */
static uint32_t vpls_of(const rd_job *job, int level)
{
    uint32_t vpls = (uint32_t)rd_setting_integer(job->settings, "vpl_count");
    return level == GROUND ? (vpls + 3) / 4 : vpls;
}

static ism_desc make_desc(const rd_job *job, int level, int keep_hits)
{
    static const char *const importances[] = { "flux", "brsm", "guided", "brsm_mean", "guided_mean", NULL };
    static const char *const spreads[] = { "area", "view1", "view8", "pair", NULL };
    static const char *const projections[] = { "cosine", "paraboloid", "octahedral", "lobe", NULL };
    ism_desc d;
    memset(&d, 0, sizeof d);
    d.vpl_count = vpls_of(job, level);
    d.surfel_count = (uint32_t)rd_setting_integer(job->settings, "surfel_count");
    d.tile_side = (uint32_t)rd_setting_integer(job->settings, "tile_side");
    d.importance = (ism_importance)(ISM_IMPORTANCE_FLUX + word_index(job, "importance", importances));
    d.spread = (ism_spread)(ISM_SPREAD_AREA + word_index(job, "spread", spreads));
    d.projection = (ism_projection)(ISM_PROJECTION_COSINE + word_index(job, "projection", projections));
    d.view_grid_side = (uint32_t)rd_setting_integer(job->settings, "view_grid_side");
    d.splat_scale = (float)rd_setting_number(job->settings, "splat_scale");
    d.lazy_frames = (uint32_t)rd_setting_integer(job->settings, "lazy_frames");
    d.unstable = rd_setting_integer(job->settings, "unstable");
    d.no_inter_texel = rd_setting_integer(job->settings, "no_inter_texel");
    d.no_fill = rd_setting_integer(job->settings, "no_fill");
    d.vary_surfels = rd_setting_integer(job->settings, "vary_surfels");
    d.keep_hits = keep_hits;
    d.near_point_count = rd_setting_is(job->settings, "near_mode", "gather")
                       ? (int32_t)rd_setting_integer(job->settings, "near_point_count") : -1;
    d.window_rim = (int32_t)rd_setting_integer(job->settings, "window_rim");
    d.seed = d.unstable ? job->seed : job->seed - job->frame;     /* stable: one seed for all frames */
    d.system.parallel_for = ex_pool_run;
    d.system.user = job->pool;
    d.system.progress = ex_terminal() ? ex_pool_progress : NULL;
    d.system.log = ex_pool_log;
    ex_pool_label(job->pool, "ism");
    return d;
}

/* Pixels a side that share the VPLs: 1, 2, 4 or 8, so that about job->samples remain for each; 4 if not said, which
   costs less than the maps do by far, where 8 would leave spots (docs/measured/ism.md). */
static uint32_t pattern_of(const rd_job *job, uint32_t vpls)
{
    uint32_t pattern = 1;
    if (!job->samples)
        return vpls >= 16 ? 4 : 1;
    while (pattern < 8 && pattern * pattern * job->samples < vpls)
        pattern *= 2;
    return pattern;
}

static ism_shading make_shading(const rd_job *job)
{
    static const char *const rules[] = { "patch", "sphere", "clamp", "mean", "none", "gather", NULL };
    ism_shading s = { 0 };
    s.near_mode = (ism_near)(ISM_NEAR_PATCH + word_index(job, "near_mode", rules));
    s.clamp = (float)rd_setting_number(job->settings, "clamp");
    s.bias = (float)rd_setting_number(job->settings, "bias");
    s.bias = s.bias > 0 ? s.bias : -1;       /* 0 is none here, the default there */
    s.cull = rd_setting_integer(job->settings, "cull");
    s.no_maps = rd_setting_integer(job->settings, "no_maps");
    s.interleave = pattern_of(job, (uint32_t)rd_setting_integer(job->settings, "vpl_count"));
    if (job->gbuffer->height < 2)
        s.interleave = 1;
    return s;
}

/* ---- frames ---- */

static void close_ism(void *state)
{
    ism_state *s = state;
    if (!s)
        return;
    for (int i = 0; i < LEVELS; i++)
        ism_free(s->maps[i]);
    im_gl_close(s->gl);
    im_mesh_free(&s->mesh);
    im_rsms_free(&s->last);
    free(s);
}

static int update_ism(void *state, const rd_job *job, char *error)
{
    ism_state *s = state;
    im_mesh_free(&s->mesh);
    if (s->gl)
        im_gl_moved(s->gl);
    return im_mesh_build(&s->mesh, job, error);
}

static int open_ism(void **state, const rd_job *job, char *error)
{
    ism_state *s;
    if (rd_setting_is(job->settings, "materials", "full")) {
        snprintf(error, EX_ERROR_SIZE, "ism: materials=full: this technique shades diffuse surfaces only");
        return -1;
    }
    s = calloc(1, sizeof *s);
    if (!s)
        return im_out_of_memory(error);
    s->bounces = rd_setting_integer(job->settings, "bounces");
    s->direct = !rd_setting_is(job->settings, "only", "indirect");
    s->indirect = !rd_setting_is(job->settings, "only", "direct") && s->bounces > 0;
    s->rsm = (uint32_t)rd_setting_integer(job->settings, "rsm_side");
    s->shadow = (uint32_t)rd_setting_integer(job->settings, "shadow_map_side");
    s->light_points = (uint32_t)rd_setting_integer(job->settings, "light_point_count");
    s->light_rsm = rd_setting_integer(job->settings, "light_rsm");
    s->keep = rd_setting_integer(job->settings, "keep");
    s->shading = make_shading(job);
    if (job->gl)
        s->gl = im_gl_open(job, LEVELS, error);
    if ((job->gl && !s->gl) || update_ism(s, job, error) != 0) {
        close_ism(s);
        return -1;
    }
    *state = s;
    return 0;
}

/* Maps and light of a level whose VPLs are chosen. On GL ism.h scatters the points alone, or draws its own maps too
   where the next bounce comes from them. */
static int light_level(ism_state *s, const ism_desc *desc, int level, const ism_frame *frame, int shade, float *light,
                       ism_stats *stats, char *error)
{
    ism_maps *maps = s->maps[level];
    ism_result result = ISM_OK;
    double start = ex_seconds(), built;
    if (s->gl && !desc->keep_hits && !s->shading.no_maps)
        result = ism_scatter(maps, frame);
    else if (!s->shading.no_maps || desc->keep_hits)
        result = ism_build(maps, frame);
    if (result == ISM_OK && s->gl && shade &&
        im_gl_draw(s->gl, level, desc, maps, frame, s->shading.no_maps, error) != 0)
        return -1;
    built = ex_seconds();
    if (result == ISM_OK && shade && s->gl) {
        double lost;
        if (im_gl_shade(s->gl, level, &s->shading, light, &lost, error) != 0)
            return -1;
        ism_info info;
        ism_get_info(maps, &info);
        *stats = info.stats;
        stats->lost_energy = lost;
    } else if (result == ISM_OK && shade) {
        result = ism_shade(maps, frame->points, &s->shading, light, stats);
    }
    s->build_ms = 1000 * (built - start);
    s->shade_ms = 1000 * (ex_seconds() - built);
    return result == ISM_OK ? 0 : im_failed("virtual point lights", result, error);
}

/* One set of VPLs, level 0 being emitted light: chosen, built, shaded, added to out. */
static int add_level(ism_state *s, const rd_job *job, int level, const ism_source *sources, size_t count, int shade,
                     ex_image *out, char *error)
{
    size_t floats = 3 * (size_t)job->gbuffer->width * job->gbuffer->height;
    float *light = malloc(floats * sizeof *light);
    ism_desc desc = make_desc(job, level, (level == GROUND ? 1 : level) < s->bounces);
    ism_points view;
    const int sky = count > 0 && sources[count - 1].kind == ISM_SOURCE_DIRECTIONS;
    ism_frame frame = { sky ? &s->mesh.casters : &s->mesh.mesh, sources, count, &view, job->frame };
    ism_stats stats;
    ism_result result = light ? ISM_OK : ISM_ERR_ALLOC;
    double start = ex_seconds();
    int status;
    im_view(&view, job);
    if (result == ISM_OK && !s->maps[level])
        result = ism_create(&desc, &s->maps[level]);
    if (result == ISM_OK)
        result = ism_choose(s->maps[level], &frame);
    s->choose_ms = 1000 * (ex_seconds() - start);
    status = result == ISM_OK ? light_level(s, &desc, level, &frame, shade, light, &stats, error)
                              : im_failed("virtual point lights", result, error);
    if (status == 0 && shade) {
        if (level == 1 || (level == 0 && !s->indirect))
            s->stats = stats;
        if (stats.peak_bytes > s->peaks[level])
            s->peaks[level] = stats.peak_bytes;
        for (size_t i = 0; i < floats; i++)
            out->rgb[i] += light[i];
    }
    free(light);
    return status;
}

/* The source of the next bounce, in one block that arrays[0] holds: positions, normals, fluxes. */
static int bounce_source(const ism_state *s, const rd_job *job, int level, uint32_t side, ism_source *source,
                         char *error)
{
    size_t count = (size_t)vpls_of(job, level) * side * side;
    float *block = malloc(9 * count * sizeof *block);
    ism_result result =
        block ? ism_bounce(s->maps[level], &s->mesh.mesh, side, block, block + 3 * count, block + 6 * count)
              : ISM_ERR_ALLOC;
    memset(source, 0, sizeof *source);
    source->width = (uint32_t)count;
    source->height = 1;
    source->positions = block;
    source->normals = block + 3 * count;
    source->fluxes = block + 6 * count;
    source->scattered = 1;
    if (result == ISM_OK)
        return 0;
    free(block);
    source->positions = NULL;
    return im_failed("the next bounce", result, error);
}

/* Bounces after the first from the imperfect RSMs of the one before. */
static int add_bounces(ism_state *s, const rd_job *job, ex_image *out, char *error)
{
    for (int level = 2; level <= s->bounces; level++) {
        ism_source sources[2];
        size_t count = level == 2 && s->has_ground ? 2 : 1;
        int result = bounce_source(s, job, level - 1, BOUNCE_SIDE, &sources[0], error);
        sources[1].positions = NULL;
        if (result == 0 && count == 2)
            result = bounce_source(s, job, GROUND, BOUNCE_SIDE, &sources[1], error);
        if (result == 0)
            result = add_level(s, job, level, sources, count, 1, out, error);
        free((float *)(size_t)sources[0].positions);
        free((float *)(size_t)sources[1].positions);
        if (result != 0)
            return -1;
    }
    return 0;
}

/* Emitted light: shaded where direct light is wanted. */
static int add_emitted(ism_state *s, const rd_job *job, int shade, int with_sky, int *any, ex_image *out, char *error)
{
    im_rsms emission;
    int result = im_emission_sources(&emission, job, EMISSION_POINTS, with_sky, error);
    *any = result == 0 && emission.count > 0;
    if (*any)
        result = add_level(s, job, 0, emission.sources, emission.count, shade, out, error);
    im_emission_free(&emission);
    return result;
}

/* The first bounce: reflective shadow maps of lights without size and of the sky; light of emissive surfaces from
   reflective shadow maps at light_points places or (light_rsm=0) from the imperfect ones of their VPLs. */
static int add_first(ism_state *s, const rd_job *job, im_rsms *rsms, ex_image *out, char *error)
{
    double start = ex_seconds();
    ism_source *sources, bounced;
    size_t count;
    int result, any = 0;
    if (im_rsms_render(rsms, s->keep ? &s->last : NULL, job, s->rsm, error) != 0)
        return -1;
    s->rsm_count = rsms->count;
    s->kept = rsms->kept;
    memset(&bounced, 0, sizeof bounced);
    if (!s->light_rsm) {
        if (add_emitted(s, job, 0, 0, &any, out, error) != 0)
            return -1;
        if (any && bounce_source(s, job, 0, EMISSION_SIDE, &bounced, error) != 0)
            return -1;
    }
    s->rsm_ms = 1000 * (ex_seconds() - start);
    sources = malloc((rsms->count + 1) * sizeof *sources);
    if (!sources) {
        free((float *)(size_t)bounced.positions);
        return im_out_of_memory(error);
    }
    if (rsms->count)
        memcpy(sources, rsms->sources, rsms->count * sizeof *sources);
    count = rsms->count - rsms->rings;
    if (any)
        sources[count++] = bounced;
    result = add_level(s, job, 1, sources, count, 1, out, error);
    free(sources);
    s->has_ground = rsms->rings > 0;
    if (result == 0 && s->has_ground)
        result = add_level(s, job, GROUND, rsms->sources + rsms->count - rsms->rings, rsms->rings, 1, out, error);
    free((float *)(size_t)bounced.positions);
    return result;
}

static int frame_ism(void *state, const rd_job *job, ex_image *out, char *error)
{
    ism_state *s = state;
    im_rsms rsms;
    rd_job still = *job;
    double start = ex_seconds();
    int result, any;
    if (s->keep)
        still.seed -= job->frame;       /* points on lamps stay where they are */
    result = im_lamps_build(&rsms, &still, s->light_points, s->light_rsm, error);
    if (result == 0 && s->gl)
        result = im_gl_view(s->gl, job->gbuffer, error);
    if (result == 0 && s->indirect)
        result = add_first(s, job, &rsms, out, error);
    start = ex_seconds();
    if (result == 0 && s->direct) {
        result = im_direct(out, &rsms, job, s->shadow, &s->direct_bytes, error);
        if (result == 0)
            result = add_emitted(s, job, 1, 1, &any, out, error);
    }
    s->direct_ms = 1000 * (ex_seconds() - start);
    if (result == 0 && s->indirect)
        result = add_bounces(s, job, out, error);
    im_rsms_free(&s->last);
    if (s->keep && result == 0)
        s->last = rsms;
    else
        im_rsms_free(&rsms);
    return result;
}

static void report_ism(const void *state, rd_report *report)
{
    const ism_state *s = state;
    rd_json *json = report->json;
    report->memory_bytes += s->direct_bytes;
    report->peak_bytes += s->direct_bytes;
    for (int i = 0; i < LEVELS; i++) {
        ism_info info;
        if (!s->maps[i])
            continue;
        ism_get_info(s->maps[i], &info);
        report->memory_bytes += info.stats.bytes;
        report->peak_bytes += info.stats.peak_bytes > s->peaks[i] ? info.stats.peak_bytes : s->peaks[i];
    }
    rd_json_integer(json, "vpls", s->stats.vpls);
    rd_json_integer(json, "surfels", s->stats.surfels);
    rd_json_integer(json, "interleave", s->shading.interleave);
    rd_json_integer(json, "bounces", (uint64_t)(s->indirect ? s->bounces : 0));
    rd_json_integer(json, "maps", s->rsm_count);
    rd_json_integer(json, "kept_maps", s->kept);
    rd_json_integer(json, "renewed", s->stats.renewed);
    rd_json_integer(json, "jumped", s->stats.jumped);
    rd_json_integer(json, "splats", s->stats.splats);
    rd_json_integer(json, "wide_splats", s->stats.wide_splats);
    rd_json_integer(json, "filled", s->stats.filled);
    rd_json_number(json, "lost_energy", s->stats.lost_energy);
    rd_json_number(json, "culled", s->stats.culled);
    rd_json_number(json, "direct_ms", s->direct_ms);
    rd_json_number(json, "rsm_ms", s->rsm_ms);
    rd_json_number(json, "choose_ms", s->choose_ms);
    rd_json_number(json, "build_ms", s->build_ms);
    rd_json_number(json, "shade_ms", s->shade_ms);
}

static const rd_key keys[] = {
    { "bounces", RD_INTEGER, NULL, 0, MAX_BOUNCES, "1", "bounces; 0: direct light only" },
    { "only", RD_WORD, "direct|indirect|all", 0, 0, "all", "the part of the light that is wanted" },
    { "vpl_count", RD_INTEGER, NULL, 1, 16384, "1024", "virtual point lights, of each bounce" },
    { "surfel_count", RD_INTEGER, NULL, 8, 65536, "8192", "surfels in each VPL's map" },
    { "tile_side", RD_WORD, "8|16|32|64|128|256", 0, 0, "64", "texels a side of a VPL's map" },
    { "window_rim", RD_INTEGER, NULL, -1, 128, "0",
      "texels a side of a map for what the picture does not show; 0: an eighth of tile_side, -1: no windows" },
    { "rsm_side", RD_INTEGER, NULL, 8, 2048, "512",
      "texels a side of the reflective shadow maps; half for faces of cubes; light_point_count share them" },
    { "shadow_map_side", RD_INTEGER, NULL, 16, 4096, "1024", "texels a side of the shadow maps of direct light" },
    { "light_point_count", RD_INTEGER, NULL, 1, 1024, "64",
      "RSMs for each area light, the emissive meshes and the sky" },
    { "keep", RD_WORD, "0|1", 0, 0, "0",
      "1: RSMs whose light and casters are as in the last frame are not drawn, and points on lamps stay" },
    { "light_rsm", RD_WORD, "0|1", 0, 0, "1", "0: light of area lights and emissive meshes bounces by imperfect RSMs" },
    { "importance", RD_WORD, "flux|brsm|guided|brsm_mean|guided_mean", 0, 0, "guided", "how VPLs are chosen" },
    { "spread", RD_WORD, "area|view1|view8|pair", 0, 0, "pair", "how surfels are spread over triangles" },
    { "projection", RD_WORD, "cosine|paraboloid|octahedral|lobe", 0, 0, "cosine", "of the maps" },
    { "view_grid_side", RD_INTEGER, NULL, 1, 16, "4", "view samples of a possible VPL: its square" },
    { "near_mode", RD_WORD, "patch|sphere|clamp|mean|none|gather", 0, 0, "gather", "light close to a VPL" },
    { "near_point_count", RD_INTEGER, NULL, 1, 64, "16", "near_mode=gather: points of each VPL" },
    { "clamp", RD_NUMBER, NULL, 1e-6, 1e6, "1",
      "near_mode=clamp: 1/m^2; near_mode=mean: times the mean of a pixel's VPLs" },
    { "bias", RD_NUMBER, NULL, 0, 0.9, "0.02", "share of the distance" },
    { "splat_scale", RD_NUMBER, NULL, 0.01, 16, "0.8", "area of a disc over that of its surfel" },
    { "lazy_frames", RD_INTEGER, NULL, 1, 64, "8", "frames until all surfels are renewed" },
    { "unstable", RD_WORD, "0|1", 0, 0, "0", "1: VPLs and surfels take new random numbers in every frame" },
    { "no_inter_texel", RD_WORD, "0|1", 0, 0, "0", "1: VPLs lie at texel centres, not between them" },
    { "no_fill", RD_WORD, "0|1", 0, 0, "0", "1: holes of maps stay open, without pull and push" },
    { "mask", RD_WORD, "points|share", 0, 0, "points",
      "cut-outs: surfels in holes are none; share: a triangle is drawn for its share of the VPLs" },
    { "vary_surfels", RD_WORD, "0|1", 0, 0, "0", "1: weak VPLs take fewer surfels" },
    { "no_maps", RD_WORD, "0|1", 0, 0, "0", "1: VPLs shine through everything" },
    { "cull", RD_WORD, "0|1", 0, 0, "0", "1: skip VPLs that face away from blocks of pixels" },
    { NULL, RD_WORD, NULL, 0, 0, NULL, NULL }
};

const rd_technique rd_ism = {
    "ism", "one bounce and more from virtual point lights with imperfect shadow maps", NULL, 0, 1, 16384, 0, 0, 0, keys,
    open_ism, update_ism, frame_ism, report_ism, close_ism
};
