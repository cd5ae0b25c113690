/* filter.c - the page "filter", see stage.h: the Cornell box by a spot lamp, whose bounced light has a few samples a pixel.
   Left of a line the picture has it as gl_rsm.h gathered it, right of the line as glbk_rsm_denoise, which is gifilter.h's
   filter, has made it smooth. Each frame is shown by itself. */
#include "../gl_backend/gl_rsm.h"
#include "stage.h"
#include "../examples/common/internal.h"

#include <stdlib.h>
#include <string.h>

#ifdef __EMSCRIPTEN__
#include <emscripten.h>
#else
#define EMSCRIPTEN_KEEPALIVE
#endif

enum { SIDE = 64, INTERLEAVE = 8 };
enum { LAMP, AIM };                                     /* handles */
enum { SPLIT, SAMPLES, HISTORY, PASSES, COSINE, SLOPE, EXPOSURE, BOUNCED_ALONE };       /* knobs */

static struct filter {
    pg_model          model;
    pg_stage         *stage;
    glbk_rsm_map      map;
    glbk_rsm_renderer rsm;
    glbk_texture      noisy;
    glbk_target       noisy_target;
    glbk_program      split;
    gifilt_frame      settings;         /* of the last frame, without its camera */
    uint32_t          samples;          /* the same, a pixel */
    rsm_light         spot;             /* the same */
    uint32_t          index;            /* of the frame */
} filter;

/* The noisy picture left of the line, which is white, over the smooth one. */
static const char split_text[] = "uniform glbk_color_sampler glbk_user0;\n"
                                 "uniform vec4 line;\n"     /* x: where it is, in pixels; w: how bright */
                                 "layout(location = 0) out glbk_color color;\n"
                                 "void main()\n"
                                 "{\n"
                                 "    float right = gl_FragCoord.x - line.x;\n"
                                 "    if (right > 1.0) discard;\n"
                                 "    color = texelFetch(glbk_user0, ivec2(gl_FragCoord.xy), 0);\n"
                                 "    if (right > -1.0) color = glbk_pack(vec4(line.www, 1.0));\n"
                                 "}\n";

static rsm_light lamp(const pg_stage *stage, float time)
{
    rsm_light spot;
    const float *at = stage->handles[LAMP].position, *to = stage->handles[AIM].position;
    memset(&spot, 0, sizeof spot);
    spot.kind = RSM_LIGHT_SPOT;
    memcpy(spot.position, at, sizeof spot.position);
    for (int k = 0; k < 3; k++) spot.direction[k] = to[k] - at[k];
    spot.direction[0] += 0.12f * sinf(1.5f * time);
    spot.value[0] = 3;
    spot.value[1] = 2.8f;
    spot.value[2] = 2.5f;
    spot.cone_half_angle = 0.6f;
    spot.near_depth = 0.01f;
    spot.far_depth = 2;
    return spot;
}

static void place_handles(pg_stage *stage)
{
    static const pg_handle lamp_handle = { { 0.30f, 0.36f, 0.12f }, 0.05f, PG_TRACK_PLANE, { 1, 0.93f, 0.7f } };
    static const pg_handle aim_handle = { { 0.40f, 0.548f, 0.30f }, 0.06f, PG_TRACK_WALLS, { 0.55f, 0.75f, 1 } };
    const float high[3] = { 0.549f, 0.548f, 0.559f };
    if (stage->handle_count) return;            /* a context that comes back finds them where they were */
    memcpy(stage->box[1], high, sizeof high);
    stage->handles[LAMP] = lamp_handle;
    stage->handles[AIM] = aim_handle;
    stage->handle_count = 2;
}

int pg_scene_create(pg_stage *stage, char *error)
{
    rsm_light spot;
    glbk_result result;
    filter.stage = stage;
    filter.index = 0;
    stage->no_mean = 1;
    place_handles(stage);
    spot = lamp(stage, 0);
    if (!filter.model.scene.object_count) {
        ex_scene scene;
        if (ex_scene_builtin(&scene, "cornell", 0, error) != 0) return -1;
        /* The box's own lamp is off. */
        for (uint32_t i = 0; i < scene.material_count; i++)
            memset(scene.materials[i].emission, 0, sizeof scene.materials[i].emission);
        if (pg_model_take(&filter.model, &scene, 0, error) != 0) return -1;
    }
    if (pg_model_upload(&filter.model, stage->gl, error) != 0) return -1;
    result = glbk_rsm_map_create(stage->gl, &spot, SIDE, &filter.map);
    if (result == GLBK_OK) result = pg_stage_compile(stage, split_text, &filter.split);
    return result == GLBK_OK ? 0 : pg_failed("the box", result, error);
}

static void free_sized(pg_stage *stage)
{
    glbk_target_free(stage->gl, &filter.noisy_target);
    glbk_texture_free(stage->gl, &filter.noisy);
}

void pg_scene_free(pg_stage *stage)
{
    free_sized(stage);
    glbk_rsm_renderer_free(stage->gl, &filter.rsm);
    glbk_program_free(stage->gl, &filter.split);
    glbk_rsm_map_free(stage->gl, &filter.map);
    pg_model_release(&filter.model, stage->gl);
}

const pg_model *pg_scene_model(void) { return &filter.model; }

static glbk_result fit(pg_stage *stage)
{
    glbk_rsm_renderer_desc size;
    glbk_result result;
    if (filter.rsm.width == stage->width && filter.rsm.height == stage->height && filter.noisy_target.name)
        return GLBK_OK;
    free_sized(stage);
    memset(&size, 0, sizeof size);
    size.width = stage->width;
    size.height = stage->height;
    size.denoise = 1;
    if (filter.rsm.width) result = glbk_rsm_renderer_resize(stage->gl, &filter.rsm, stage->width, stage->height);
    else result = glbk_rsm_renderer_create(stage->gl, &size, &filter.rsm);
    return result == GLBK_OK ? pg_stage_target(stage, &filter.noisy, &filter.noisy_target) : result;
}

/* ---- a frame ---- */

static glbk_result set_lit(void *user, glbk_context *gl, const glbk_surface *surface)
{
    return glbk_rsm_object(gl, (glbk_rsm_renderer *)user, surface, 0);
}

static void draw_lit(void *user, glbk_context *gl, glbk_rsm_renderer *renderer)
{
    const pg_draw draw = { NULL, set_lit, renderer, 0, 0, 0 };
    (void)user;
    pg_model_draw(&filter.model, gl, &draw);    /* glbk_rsm_map_draw returns its errors */
}

/* Bounced light of `samples` texels a pixel, which neighbours do not share; 0: of every texel, without noise. */
static glbk_result gather(pg_stage *stage, uint32_t samples)
{
    glbk_rsm_map *map = &filter.map;
    rsm_gather_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.near_limit = 1;
    if (samples) {
        desc.pattern = RSM_PATTERN_FLUX;
        desc.sample_count = samples * INTERLEAVE * INTERLEAVE;
        desc.interleave = INTERLEAVE;
        desc.seed = filter.index++;
    }
    return glbk_rsm_gather(stage->gl, &filter.rsm, &stage->seen, &map, 1, &desc);
}

static glbk_result smooth(pg_stage *stage)
{
    gifilt_frame frame = filter.settings;
    frame.world_to_clip = stage->camera.clip;
    return glbk_rsm_denoise(stage->gl, &filter.rsm, &stage->seen, &frame, NULL);
}

static glbk_result resolve(pg_stage *stage, const glbk_target *target, int direct)
{
    glbk_pass pass;
    memset(&pass, 0, sizeof pass);
    pass.target = target;
    return glbk_rsm_resolve(stage->gl, &filter.rsm, &stage->seen, &pass, NULL, direct, 1);
}

static glbk_result draw_split(pg_stage *stage, float share)
{
    const glbk_functions *f = &stage->gl->gl;
    const float line[4] = { share * (float)stage->width, 0, 0, 1 / stage->exposure };
    glbk_pass pass;
    glbk_result result;
    memset(&pass, 0, sizeof pass);
    pass.target = &stage->light_target;
    result = glbk_begin(stage->gl, &pass, &filter.split);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(stage->gl, GLBK_SLOT_glbk_user0, &filter.noisy);
    f->Uniform4fv(f->GetUniformLocation(filter.split.name, "line"), 1, line);
    glbk_draw_screen(stage->gl);
    return GLBK_OK;
}

static void set(const float knobs[PG_KNOBS])
{
    filter.samples = (uint32_t)knobs[SAMPLES];
    filter.settings.history = (uint32_t)knobs[HISTORY];
    filter.settings.passes = knobs[PASSES] > 0 ? (int)knobs[PASSES] : -1;       /* 0 would be the default */
    filter.settings.normal_cosine = knobs[COSINE];
    filter.settings.plane_slope = knobs[SLOPE];
}

int pg_scene_light(pg_stage *stage, const float knobs[PG_KNOBS], float time, char *error)
{
    const glbk_rsm_map *map = &filter.map;
    const rsm_light spot = lamp(stage, time);
    const int direct = knobs[BOUNCED_ALONE] > 0 ? 0 : 1;
    glbk_context *gl = stage->gl;
    glbk_result result = fit(stage);
    stage->exposure = 1.2f * knobs[EXPOSURE];
    set(knobs);
    filter.spot = spot;
    if (result == GLBK_OK) result = glbk_rsm_map_place(gl, &filter.map, &spot);
    if (result == GLBK_OK) result = glbk_rsm_map_draw(gl, &filter.rsm, &filter.map, draw_lit, NULL);
    if (result == GLBK_OK) result = pg_stage_draw(stage, &filter.model, NULL, 0);
    if (result == GLBK_OK && direct) result = glbk_rsm_direct(gl, &filter.rsm, &stage->seen, &map, 1, NULL);
    if (result == GLBK_OK) result = gather(stage, filter.samples);
    if (result == GLBK_OK) result = resolve(stage, &filter.noisy_target, direct);
    if (result == GLBK_OK) result = smooth(stage);
    if (result == GLBK_OK) result = resolve(stage, &stage->light_target, direct);
    if (result == GLBK_OK) result = draw_split(stage, knobs[SPLIT]);
    return result == GLBK_OK ? 0 : pg_failed("the light", result, error);
}

/* ---- its error ---- */

/* The root of the mean square of a - b over all pixels that show something, over the mean of b. */
static float apart(const float *a, const float *b, size_t pixels)
{
    double square = 0, sum = 0, count = 0;
    for (size_t i = 0; i < pixels; i++) {
        if (b[4 * i + 3] < 1) continue;
        for (size_t k = 0; k < 3; k++) {
            const double exact = (double)b[4 * i + k], d = (double)a[4 * i + k] - exact;
            square += d * d;
            sum += exact;
            count++;
        }
    }
    return sum > 0 ? (float)(sqrt(square / count) / (sum / count)) : 0;
}

void         pg_filter_again(void);
const float *pg_filter_measure(void);

/* Noise and history begin anew: the same frames come again, for pictures that are compared. */
EMSCRIPTEN_KEEPALIVE void pg_filter_again(void)
{
    filter.index = 0;
    glbk_rsm_reset(&filter.rsm);
}

/* Relative error of the noisy and of the smooth light of one frame more, as the last one was: against the bounced light of
   every texel of the map. Two floats, negative where that fails. */
EMSCRIPTEN_KEEPALIVE const float *pg_filter_measure(void)
{
    static float out[2];
    pg_stage *stage = filter.stage;
    const size_t pixels = (size_t)stage->width * stage->height;
    float *light = malloc(3 * 4 * pixels * sizeof *light), *part[3];
    glbk_result result = light ? gather(stage, filter.samples) : GLBK_ERR_ALLOC;
    for (size_t i = 0; i < 3 && light; i++) part[i] = light + 4 * i * pixels;
    if (result == GLBK_OK) result = glbk_rsm_read(stage->gl, &filter.rsm, 1, part[0]);
    if (result == GLBK_OK) result = smooth(stage);
    if (result == GLBK_OK) result = glbk_rsm_read(stage->gl, &filter.rsm, 1, part[1]);
    if (result == GLBK_OK) result = gather(stage, 0);
    if (result == GLBK_OK) result = glbk_rsm_read(stage->gl, &filter.rsm, 1, part[2]);
    for (int i = 0; i < 2; i++) out[i] = result == GLBK_OK ? apart(part[i], part[2], pixels) : -1;
    free(light);
    return out;
}

int pg_scene_lights(const pg_stage *stage, const float knobs[PG_KNOBS], pg_lights *out, char *error)
{
    const rsm_light *spot = &filter.spot;
    (void)stage;
    if (knobs[BOUNCED_ALONE] > 0) return ex_fail(error, "a path tracer has bounced light with direct light only");
    pg_lights_spot(out, spot->position, spot->direction, spot->cone_half_angle, spot->value);
    out->bounces = 1;
    return 0;
}
