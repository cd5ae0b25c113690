/* sky.c - the page "sky", see stage.h: washing that flaps on its line under a sky that the user turns. envlights.h
   makes lights of the sky, envshadow.h fits a shadow map to each, gl_envshadow.h draws the maps anew in each frame and
   lights the picture by all of them. */
#include "../envlights.h"
#include "../gl_backend/gl_envshadow.h"
#include "stage.h"
#include "../examples/common/internal.h"

#include <stdlib.h>
#include <string.h>

enum { LIGHTS = 128, WASHING = 4 };
enum { TURN, EXPOSURE, COUNT, FILTER, SHOW_SKY, MAP_SIDE, BIAS, RADIUS, EXTENT, METHOD, SPLIT_SUN, HEMISPHERE };    /* knobs */

static struct sky {
    pg_model            model;
    envlt_lights       *lights;
    envlt_desc          asked;          /* how they were made; without a count: they were not */
    float              *texels;         /* of the sky */
    uint32_t            width, height;
    uint32_t            side;           /* texels of a map; 0: there are none */
    envsh_maps         *layout;
    glbk_envsh_maps     maps;
    glbk_envsh_renderer renderer;
} sky;

/* ---- the washing ---- */

typedef struct wash { float x0, x1, z, length, folds, wind, phase, dye[3]; } wash;
static const float line_height = 1.9f;
static const wash washing[WASHING] = {
    { -1.55f, -0.45f, 0.28f, 1.25f, 4, 0.55f, 0.4f, { 0.80f, 0.78f, 0.73f } },
    { -0.20f, 0.50f, 0.28f, 0.80f, 2, 0.45f, 2.6f, { 0.62f, 0.12f, 0.09f } },
    { 0.75f, 1.55f, 0.28f, 1.05f, 3, 0.50f, 4.1f, { 0.76f, 0.58f, 0.24f } },
    { -0.90f, 0.70f, -0.38f, 1.35f, 5, 0.50f, 5.3f, { 0.28f, 0.42f, 0.62f } }
};

static void hang(ex_builder *b, uint32_t number, float time)
{
    const wash *w = &washing[number];
    const ex_drape d = { v3_make(w->x0, line_height, w->z), v3_make(w->x1, line_height, w->z), w->length, 0.03f,
                         w->folds, w->wind, w->phase };
    ex_build_drape(b, &d, time, (uint32_t)(40 * (w->x1 - w->x0)), (uint32_t)(30 * w->length), number);
}

static int pose(float time)
{
    for (uint32_t i = 0; i < WASHING; i++) {        /* its meshes and materials are the scene's first */
        ex_builder b = ex_build_begin(&sky.model.scene);
        hang(&b, i, time);
        if (ex_build_replace(&b, i) != 0) return -1;
    }
    return 0;
}

static void add_posts(ex_builder *b)
{
    const uint32_t wood = ex_build_material(b, 0.36f, 0.24f, 0.14f), rope = ex_build_material(b, 0.60f, 0.55f, 0.45f);
    for (int side = -1; side <= 1; side += 2) {
        const float x = 1.85f * (float)side, z = (side < 0 ? 0.28f : -0.38f);
        const float y = line_height + 0.004f;
        const v3 line[4] = { v3_make(-1.86f, y, z), v3_make(-1.85f, y, z), v3_make(1.85f, y, z), v3_make(1.86f, y, z) };
        static const float radii[4] = { 0.006f, 0.006f, 0.006f, 0.006f };
        ex_build_block(b, v3_make(x - 0.045f, 0, -0.09f), v3_make(x + 0.045f, 2.02f, 0), 0.008f, wood);
        ex_build_block(b, v3_make(x - 0.03f, 1.86f, -0.46f), v3_make(x + 0.03f, 1.93f, 0.36f), 0.006f, wood);
        ex_build_tube(b, line, radii, 4, 8, rope);
    }
    ex_build_object(b, "posts", ex_build_finish(b));
}

static void add_basket(ex_builder *b)
{
    static const float profile[][2] = { { 0, 0 }, { 0.20f, 0 }, { 0.27f, 0.28f }, { 0.28f, 0.30f }, { 0.26f, 0.30f },
                                        { 0.19f, 0.03f }, { 0, 0.02f } };
    const uint32_t wicker = ex_build_material(b, 0.52f, 0.36f, 0.18f);
    ex_object *object;
    ex_build_lathe(b, profile[0], sizeof profile / sizeof *profile, 48, 0.9f, wicker);
    object = ex_build_object(b, "basket", ex_build_finish(b));
    if (object) ex_place(object->transform, v3_make(1.05f, 0, 0.95f), 0, 1);
}

static int build(char *error)
{
    ex_scene scene;
    ex_builder b;
    memset(&scene, 0, sizeof scene);
    b = ex_build_begin(&scene);
    for (int i = 0; i < WASHING; i++) {
        const float *dye = washing[i].dye;
        const uint32_t cloth = ex_build_material(&b, dye[0], dye[1], dye[2]);
        if (!b.failed) scene.materials[cloth].double_sided = 1;
    }
    for (uint32_t i = 0; i < WASHING; i++) {
        hang(&b, i, 0);
        ex_build_object(&b, "cloth", ex_build_finish(&b));
    }
    add_posts(&b);
    add_basket(&b);
    ex_mesh_free(&b.mesh);
    if (b.failed) {
        ex_scene_free(&scene);
        return ex_fail(error, "out of memory");
    }
    for (uint32_t i = 0; i < WASHING; i++) scene.meshes[i].deforms = 1;
    return pg_model_take(&sky.model, &scene, 1, error);
}

/* ---- the sky's lights ---- */

static int make_lights(const float knobs[PG_KNOBS], char *error)
{
    envlt_map map;
    envlt_desc desc;
    memset(&map, 0, sizeof map);
    memset(&desc, 0, sizeof desc);
    desc.light_count = (uint32_t)knobs[COUNT];
    desc.method = (envlt_method)knobs[METHOD];
    desc.split_sun = knobs[SPLIT_SUN] > 0;
    desc.hemisphere = knobs[HEMISPHERE] > 0;
    if (memcmp(&desc, &sky.asked, sizeof desc) == 0) return 0;
    map.projection = ENVLT_PROJECTION_LATLONG;
    map.width = sky.width;
    map.height = sky.height;
    map.rgb = sky.texels;
    envlt_free(sky.lights);
    sky.lights = NULL;
    memset(&sky.asked, 0, sizeof sky.asked);
    if (envlt_create(&desc, &map, &sky.lights, NULL) != ENVLT_OK) return ex_fail(error, "the sky: no lights");
    memcpy(&sky.asked, &desc, sizeof desc);
    return 0;
}

/* Fits a map to each light as the sky stands now. */
static int place_lights(float turn, char *error)
{
    static envlt_light turned[LIGHTS];
    envsh_bounds bounds = { { 1e30f, 1e30f, 1e30f }, { -1e30f, -1e30f, -1e30f } };
    const ex_scene *scene = &sky.model.scene;
    envsh_lights all;
    float rotation[16];
    uint32_t count;
    const envlt_light *lights = envlt_get_lights(sky.lights, &count);
    ex_place(rotation, v3_make(0, 0, 0), turn, 1);
    memcpy(turned, lights, count * sizeof *turned);
    if (envlt_rotate(turned, count, rotation) != ENVLT_OK) return ex_fail(error, "the sky cannot be turned");
    for (uint32_t i = 0; i < scene->object_count; i++) {
        const ex_mesh *mesh = &scene->meshes[scene->objects[i].mesh];
        const size_t corners = 3 * (size_t)mesh->triangle_count;
        const envsh_mesh caster = { mesh->positions, mesh->vertex_count, 0, mesh->indices, corners, NULL, NULL, NULL };
        envsh_bounds one;
        if (scene->objects[i].receiver_only) continue;
        one = envsh_bounds_of(&caster, 1, scene->objects[i].transform);
        for (int k = 0; k < 3; k++) {
            bounds.low[k] = fminf(bounds.low[k], one.low[k]);
            bounds.high[k] = fmaxf(bounds.high[k], one.high[k]);
        }
    }
    all.count = count;
    all.directions = turned->direction;
    all.irradiances = turned->irradiance;
    all.axes_u = turned->axis_u;
    all.axes_v = turned->axis_v;
    all.stride = sizeof *turned;
    return envsh_maps_begin(sky.layout, &all, bounds) == ENVSH_OK ? 0 : ex_fail(error, "the maps' matrices");
}

/* ---- on the GPU ---- */

static int load_sky(pg_stage *stage, char *error)
{
    ex_sky map;
    int result;
    free(sky.texels);
    sky.texels = NULL;
    memset(&sky.asked, 0, sizeof sky.asked);
    if (ex_sky_builtin(&map, "sky", error) != 0) return -1;
    result = pg_stage_sky(stage, &map, &sky.texels, &sky.width, &sky.height, error);
    ex_sky_free(&map);
    return result;
}

int pg_scene_create(pg_stage *stage, char *error)
{
    if (!sky.model.scene.object_count && build(error) != 0) return -1;
    return load_sky(stage, error) != 0 ? -1 : pg_model_upload(&sky.model, stage->gl, error);
}

/* Shadow maps of so many texels a side, unless they are as they were. */
static glbk_result make_maps(pg_stage *stage, uint32_t side)
{
    envsh_maps_desc layout;
    const glbk_envsh_maps_desc desc = { LIGHTS, &layout, { 0, 0, 0, 0, NULL, NULL } };
    glbk_result result;
    if (sky.side == side) return GLBK_OK;
    memset(&layout, 0, sizeof layout);
    layout.map_side = side;
    layout.no_depth = 1;                /* the GPU has it */
    envsh_maps_free(sky.layout);
    glbk_envsh_maps_free(stage->gl, &sky.maps);
    sky.layout = NULL;
    sky.side = 0;
    if (envsh_maps_create(&layout, LIGHTS, &sky.layout) != ENVSH_OK) return GLBK_ERR_ALLOC;
    result = glbk_envsh_maps_create(stage->gl, &desc, &sky.maps);
    if (result == GLBK_OK) sky.side = side;
    return result;
}

void pg_scene_free(pg_stage *stage)
{
    glbk_envsh_maps_free(stage->gl, &sky.maps);
    sky.side = 0;
    glbk_envsh_renderer_free(stage->gl, &sky.renderer);
    pg_model_release(&sky.model, stage->gl);
}

const pg_model *pg_scene_model(void) { return &sky.model; }

static glbk_result fit(pg_stage *stage)
{
    const glbk_envsh_renderer_desc size = { stage->width, stage->height };
    if (sky.renderer.width == stage->width && sky.renderer.height == stage->height) return GLBK_OK;
    if (sky.renderer.width)
        return glbk_envsh_renderer_resize(stage->gl, &sky.renderer, stage->width, stage->height);
    return glbk_envsh_renderer_create(stage->gl, &size, &sky.renderer);
}

/* ---- a frame ---- */

static glbk_result set_caster(void *user, glbk_context *gl, const glbk_surface *surface)
{
    return glbk_envsh_cast(gl, (glbk_envsh_maps *)user, surface->transform);
}

static glbk_result draw_casters(void *user, glbk_context *gl, glbk_envsh_maps *maps, uint32_t instances)
{
    const pg_draw draw = { NULL, set_caster, maps, instances, 1, 0 };
    (void)user;
    return pg_model_draw(&sky.model, gl, &draw);
}

int pg_scene_light(pg_stage *stage, const float knobs[PG_KNOBS], float time, char *error)
{
    glbk_context *gl = stage->gl;
    glbk_envsh_frame frame;
    envsh_query query;
    glbk_pass pass;
    glbk_result result;
    memset(&frame, 0, sizeof frame);
    memset(&query, 0, sizeof query);
    memset(&pass, 0, sizeof pass);
    stage->sky_turn = knobs[TURN] * EX_PI / 180;
    stage->exposure = 0.9f * knobs[EXPOSURE] / stage->sky_light;
    stage->show_sky = knobs[SHOW_SKY] > 0;
    if (pose(time) != 0) return ex_fail(error, "out of memory");
    result = make_maps(stage, (uint32_t)knobs[MAP_SIDE]);
    if (result != GLBK_OK) return pg_failed("the shadow maps", result, error);
    if (pg_model_update(&sky.model, gl, error) != 0 || make_lights(knobs, error) != 0 ||
        place_lights(stage->sky_turn, error) != 0)
        return -1;
    frame.views = envsh_views(sky.layout, &frame.view_count);
    frame.draw_fn = draw_casters;
    frame.query = &query;
    query.filter = (envsh_filter)knobs[FILTER];
    query.tap_count = 8;
    query.radius = query.filter == ENVSH_FILTER_SMOOTH ? fminf(knobs[RADIUS], 8) : knobs[RADIUS];
    query.bias = knobs[BIAS] > 0 ? knobs[BIAS] : -1;            /* 0 would be the default, like that of the next */
    query.extent_scale = knobs[EXTENT] > 0 ? knobs[EXTENT] : -1;
    query.seed = stage->frames;
    pass.target = &stage->light_target;
    result = fit(stage);
    if (result == GLBK_OK) result = pg_stage_draw(stage, &sky.model, NULL, 0);
    if (result == GLBK_OK) result = glbk_envsh_illuminate(gl, &sky.renderer, &stage->seen, &sky.maps, &frame);
    if (result == GLBK_OK) result = glbk_envsh_resolve(gl, &sky.renderer, &stage->seen, &pass, NULL);
    return result == GLBK_OK ? 0 : pg_failed("the light", result, error);
}

int pg_scene_lights(const pg_stage *stage, const float knobs[PG_KNOBS], pg_lights *out, char *error)
{
    (void)knobs;
    memset(out, 0, sizeof *out);
    return pg_lights_sky(out, "builtin:sky", stage->sky_turn, error);
}
