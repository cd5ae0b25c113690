/* room.c - the page "room", see stage.h: a spot lamp that the user moves and aims, in a room where a wooden figure
   walks round. gl_rsm.h draws what the lamp sees; by it ism.h chooses virtual point lights, whose imperfect shadow maps
   gl_ism.h draws, for bounced light with shadows. Without these shadows gl_rsm.h gathers bounced light from the map
   itself. */
#include "../gl_backend/gl_ism.h"
#include "../gl_backend/gl_rsm.h"
#include "stage.h"
#include "../examples/common/internal.h"

#include <stdlib.h>
#include <string.h>

enum { WALLS = 5, GRID = 8 };
enum { LAMP, AIM };                                     /* handles */
enum {                                                  /* knobs */
    BOUNCE, EXPOSURE, CONE, VPL_COUNT, SURFEL_COUNT, TILE_SIDE, SPLAT_SCALE, WINDOW_RIM, NEAR_POINT_COUNT, BIAS,
    INTERLEAVE, MAP_SIDE, SAMPLES, NEAR_LIMIT, CLAMP, OFFSET, SLOPE_BIAS, VIEW_GRID
};
enum { NO_BOUNCE, RSM_BOUNCE, ISM_BOUNCE };
enum { HEAD, NECK, CHEST, HIPS, LIMBS, UPPER_ARM = LIMBS, FOREARM = 6, THIGH = 8, SHIN = 10, FOOT = 12, BONES = 14 };

static const float half_x = 2, height = 2.6f, half_z = 2;

static struct room {
    pg_model          model;
    uint32_t          bones;            /* the figure's first object */
    glbk_rsm_map      map;              /* what the lamp sees */
    glbk_rsm_renderer rsm;
    glbk_ism_maps     maps;
    glbk_ism_renderer ism;
    ism_maps         *chosen;           /* ism.h's side of the maps */
    ism_desc          desc;             /* of both; without VPLs: there are none */
    ism_surfel       *surfels;          /* room for those of all VPLs */
    rsm_texel        *texels;           /* room for those of the map */
    int               has_mesh;
    uint32_t          index;            /* of the frame */
    float             points[WALLS * GRID * GRID][3], normals[WALLS * GRID * GRID][3];
} room;

/* ---- what stands in it ---- */

/* A wall, and points on it by which virtual lights are chosen: those that light them count. */
static void add_wall(ex_builder *b, int number, v3 corner, v3 u, v3 v, uint32_t material)
{
    const v3 n = v3_unit(v3_cross(u, v));
    ex_build_panel(b, corner, u, v, 1, 1, material);
    for (int i = 0; i < GRID * GRID; i++) {
        const float x = ((float)(i % GRID) + 0.5f) / GRID, y = ((float)(i / GRID) + 0.5f) / GRID;
        v3_store(room.points[number * GRID * GRID + i], v3_mad(v3_mad(corner, u, x), v, y));
        v3_store(room.normals[number * GRID * GRID + i], n);
    }
}

static void add_walls(ex_builder *b)
{
    const uint32_t white = ex_build_material(b, 0.78f, 0.77f, 0.74f), red = ex_build_material(b, 0.66f, 0.14f, 0.08f);
    const uint32_t blue = ex_build_material(b, 0.12f, 0.30f, 0.60f), floor = ex_build_material(b, 0.62f, 0.55f, 0.46f);
    const v3 x = v3_make(2 * half_x, 0, 0), y = v3_make(0, height, 0), z = v3_make(0, 0, 2 * half_z);
    const v3 back = v3_make(0, 0, -2 * half_z);
    add_wall(b, 0, v3_make(-half_x, 0, half_z), x, back, floor);
    add_wall(b, 1, v3_make(-half_x, height, -half_z), x, z, white);
    add_wall(b, 2, v3_make(-half_x, 0, -half_z), x, y, white);
    add_wall(b, 3, v3_make(-half_x, 0, half_z), back, y, red);
    add_wall(b, 4, v3_make(half_x, 0, -half_z), z, y, blue);
    ex_build_object(b, "room", ex_build_finish(b));
    ex_build_block(b, v3_make(-1.45f, 0, -0.55f), v3_make(-0.55f, 1.35f, -0.45f), 0.01f, white);
    ex_build_object(b, "screen", ex_build_finish(b));
    ex_build_block(b, v3_make(0.95f, 0, -1.35f), v3_make(1.45f, 0.55f, -0.85f), 0.01f, white);
    ex_build_ball(b, v3_make(1.2f, 0.83f, -1.1f), v3_make(0.28f, 0.28f, 0.28f), 32, white);
    ex_build_object(b, "ball", ex_build_finish(b));
}

static int build(char *error)
{
    ex_scene scene;
    ex_builder b;
    uint32_t wood, ball;
    memset(&scene, 0, sizeof scene);
    b = ex_build_begin(&scene);
    add_walls(&b);
    wood = ex_build_material(&b, 0.72f, 0.50f, 0.28f);
    ex_build_ball(&b, v3_make(0, 0, 0), v3_make(1, 1, 1), 20, wood);
    ball = ex_build_finish(&b);
    room.bones = scene.object_count;
    for (int i = 0; i < BONES; i++) ex_build_object(&b, "figure", ball);
    ex_mesh_free(&b.mesh);
    if (b.failed) {
        ex_scene_free(&scene);
        return ex_fail(error, "out of memory");
    }
    return pg_model_take(&room.model, &scene, 0, error);
}

/* ---- the figure walks ---- */

/* An egg about the line from one joint to the next. */
static void bone(const float body[16], int number, v3 from, v3 to, float wide, float deep)
{
    float m[16];
    const v3 axis = v3_sub(to, from), up = v3_unit(axis), side = v3_unit(v3_cross(up, v3_make(0, 0.2f, 1)));
    const v3 front = v3_cross(side, up);
    ex_identity(m);
    v3_store(m, v3_scale(side, wide));
    v3_store(m + 4, v3_scale(up, 0.5f * sqrtf(v3_dot(axis, axis)) + 0.35f * (wide + deep)));
    v3_store(m + 8, v3_scale(front, deep));
    v3_store(m + 12, v3_mad(from, axis, 0.5f));
    ex_multiply(room.model.scene.objects[room.bones + (uint32_t)number].transform, body, m);
}

static v3 swing(v3 from, float length, float angle)     /* downwards, forwards by an angle */
{
    return v3_add(from, v3_make(0, -length * cosf(angle), length * sinf(angle)));
}

static void walk(float time)
{
    const float around = 0.55f * time, radius = 0.95f, phase = 5.2f * time, bob = 0.02f * cosf(2 * phase);
    float body[16];
    ex_place(body, v3_make(0.15f + radius * sinf(around), bob, 0.35f + radius * cosf(around)), around + EX_PI / 2, 1);
    bone(body, HEAD, v3_make(0, 1.58f, 0.02f), v3_make(0, 1.68f, 0.03f), 0.085f, 0.10f);
    bone(body, NECK, v3_make(0, 1.44f, 0), v3_make(0, 1.52f, 0.01f), 0.045f, 0.045f);
    bone(body, CHEST, v3_make(0, 1.10f, 0), v3_make(0, 1.38f, 0), 0.165f, 0.105f);
    bone(body, HIPS, v3_make(0, 0.92f, 0), v3_make(0, 1.00f, 0), 0.145f, 0.10f);
    for (int side = 0; side < 2; side++) {
        const float x = side ? -1.0f : 1.0f, s = x * sinf(phase), bend = 0.15f + 0.45f * fmaxf(0, x * cosf(phase));
        const v3 hip = v3_make(0.085f * x, 0.90f, 0), knee = swing(hip, 0.42f, 0.48f * s + 0.12f);
        const v3 ankle = swing(knee, 0.42f, 0.48f * s + 0.12f - bend), shoulder = v3_make(0.205f * x, 1.39f, 0);
        const v3 elbow = swing(shoulder, 0.28f, -0.45f * s), wrist = swing(elbow, 0.27f, -0.45f * s + 0.35f);
        bone(body, THIGH + side, hip, knee, 0.075f, 0.08f);
        bone(body, SHIN + side, knee, ankle, 0.052f, 0.055f);
        bone(body, FOOT + side, v3_add(ankle, v3_make(0, -0.03f, -0.03f)), v3_add(ankle, v3_make(0, -0.05f, 0.13f)),
             0.045f, 0.035f);
        bone(body, UPPER_ARM + side, shoulder, elbow, 0.05f, 0.05f);
        bone(body, FOREARM + side, elbow, wrist, 0.04f, 0.04f);
    }
}

/* ---- on the GPU ---- */

static rsm_light lamp(const pg_stage *stage, float cone_degrees)
{
    rsm_light spot;
    const float *at = stage->handles[LAMP].position, *to = stage->handles[AIM].position;
    memset(&spot, 0, sizeof spot);
    spot.kind = RSM_LIGHT_SPOT;
    for (int k = 0; k < 3; k++) {
        spot.position[k] = at[k];
        spot.direction[k] = to[k] - at[k];
    }
    spot.value[0] = 60;
    spot.value[1] = 56;
    spot.value[2] = 50;
    spot.cone_half_angle = cone_degrees * EX_PI / 180;
    spot.near_depth = 0.05f;
    spot.far_depth = 10;
    return spot;
}

static void place_handles(pg_stage *stage)
{
    static const pg_handle lamp_handle = { { 1.35f, 0.55f, 0.75f }, 0.25f, PG_TRACK_PLANE, { 1, 0.93f, 0.7f } };
    static const pg_handle aim_handle = { { -0.55f, 2.6f, -0.35f }, 0.3f, PG_TRACK_WALLS, { 0.55f, 0.75f, 1 } };
    const float low[3] = { -half_x, 0, -half_z }, high[3] = { half_x, height, half_z };
    if (stage->handle_count) return;            /* a context that comes back finds them where they were */
    memcpy(stage->box[0], low, sizeof low);
    memcpy(stage->box[1], high, sizeof high);
    stage->handles[LAMP] = lamp_handle;
    stage->handles[AIM] = aim_handle;
    stage->handle_count = 2;
}

int pg_scene_create(pg_stage *stage, char *error)
{
    place_handles(stage);
    if (!room.model.scene.object_count && build(error) != 0) return -1;
    return pg_model_upload(&room.model, stage->gl, error);
}

/* What the lamp sees, of so many texels a side. */
static glbk_result make_map(pg_stage *stage, const rsm_light *spot, uint32_t side)
{
    rsm_texel *texels;
    if (room.map.side == side) return GLBK_OK;
    texels = realloc(room.texels, (size_t)side * side * sizeof *texels);
    if (!texels) return GLBK_ERR_ALLOC;
    room.texels = texels;
    glbk_rsm_map_free(stage->gl, &room.map);
    return glbk_rsm_map_create(stage->gl, spot, side, &room.map);
}

/* Imperfect shadow maps as the knobs say, unless they are as they were. */
static glbk_result make_maps(pg_stage *stage, const float knobs[PG_KNOBS])
{
    const uint32_t half = (uint32_t)knobs[TILE_SIDE] / 2;
    ism_surfel *surfels;
    ism_desc desc;
    glbk_result result;
    memset(&desc, 0, sizeof desc);
    desc.vpl_count = (uint32_t)knobs[VPL_COUNT];
    desc.surfel_count = (uint32_t)knobs[SURFEL_COUNT];
    desc.tile_side = (uint32_t)knobs[TILE_SIDE];
    desc.splat_scale = knobs[SPLAT_SCALE];
    desc.view_grid_side = (uint32_t)knobs[VIEW_GRID];
    desc.near_point_count = knobs[NEAR_POINT_COUNT] > 0 ? (int32_t)knobs[NEAR_POINT_COUNT] : -1;    /* 0: the default */
    desc.window_rim = knobs[WINDOW_RIM] < 2 ? -1 : (int32_t)fminf(knobs[WINDOW_RIM], (float)half);
    desc.lazy_frames = 1;
    if (memcmp(&desc, &room.desc, sizeof desc) == 0) return GLBK_OK;
    surfels = realloc(room.surfels, (size_t)desc.vpl_count * desc.surfel_count * sizeof *surfels);
    if (!surfels) return GLBK_ERR_ALLOC;
    room.surfels = surfels;
    ism_free(room.chosen);
    glbk_ism_maps_free(stage->gl, &room.maps);
    room.chosen = NULL;
    room.has_mesh = 0;
    room.index = 0;
    memset(&room.desc, 0, sizeof room.desc);
    if (ism_create(&desc, &room.chosen) != ISM_OK) return GLBK_ERR_ALLOC;
    result = glbk_ism_maps_create(stage->gl, &desc, &room.maps);
    if (result == GLBK_OK) memcpy(&room.desc, &desc, sizeof desc);
    return result;
}

void pg_scene_free(pg_stage *stage)
{
    glbk_rsm_renderer_free(stage->gl, &room.rsm);
    glbk_ism_renderer_free(stage->gl, &room.ism);
    glbk_rsm_map_free(stage->gl, &room.map);
    glbk_ism_maps_free(stage->gl, &room.maps);
    memset(&room.desc, 0, sizeof room.desc);
    pg_model_release(&room.model, stage->gl);
}

const pg_model *pg_scene_model(void) { return &room.model; }

static glbk_result fit(pg_stage *stage)
{
    const uint32_t w = stage->width, h = stage->height;
    const glbk_ism_renderer_desc ism_size = { w, h };
    glbk_rsm_renderer_desc size;
    glbk_result result = GLBK_OK;
    memset(&size, 0, sizeof size);
    size.width = w;
    size.height = h;
    /* Each by itself: the size of one may have failed where the other's did not. */
    if (!room.rsm.width) result = glbk_rsm_renderer_create(stage->gl, &size, &room.rsm);
    else if (room.rsm.width != w || room.rsm.height != h)
        result = glbk_rsm_renderer_resize(stage->gl, &room.rsm, w, h);
    if (result != GLBK_OK) return result;
    if (!room.ism.width) return glbk_ism_renderer_create(stage->gl, &ism_size, &room.ism);
    if (room.ism.width == w && room.ism.height == h) return GLBK_OK;
    return glbk_ism_renderer_resize(stage->gl, &room.ism, w, h);
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
    pg_model_draw(&room.model, gl, &draw);      /* glbk_rsm_map_draw returns its errors */
}

/* Virtual lights, and surfels on what hides them: ism.h's part, from what the lamp sees. */
static glbk_result choose(pg_stage *stage, const ism_mesh *mesh)
{
    const rsm_texel *texels = room.texels;
    ism_source source;
    ism_points view;
    ism_frame frame = { mesh, &source, 1, &view, room.index };
    const glbk_result result = glbk_rsm_map_read(stage->gl, &room.map, 0, room.texels);
    memset(&source, 0, sizeof source);
    memset(&view, 0, sizeof view);
    source.kind = ISM_SOURCE_SURFACE;
    source.width = source.height = room.map.side;
    source.positions = texels->position;
    source.normals = texels->normal;
    source.fluxes = texels->flux;
    source.areas = &texels->area;
    source.position_stride = source.normal_stride = source.flux_stride = source.area_stride = sizeof *texels;
    view.count = WALLS * GRID * GRID;
    view.positions = room.points[0];
    view.normals = room.normals[0];
    if (result != GLBK_OK) return result;
    if (ism_choose(room.chosen, &frame) != ISM_OK) return GLBK_ERR_ALLOC;
    return ism_scatter(room.chosen, &frame) == ISM_OK ? GLBK_OK : GLBK_ERR_ALLOC;
}

static glbk_result draw_maps(glbk_context *gl)
{
    const ism_near_point *points;
    const ism_vpl *vpls;
    ism_info info;
    size_t n;
    glbk_result result;
    n = (size_t)room.desc.vpl_count * room.desc.surfel_count;
    if (ism_phase_surfels(room.chosen, 0, room.surfels, n, &n) != ISM_OK) return GLBK_ERR_ALLOC;
    result = glbk_ism_surfels_upload(gl, &room.maps, 0, room.surfels, n);
    ism_get_info(room.chosen, &info);
    vpls = ism_vpls(room.chosen, &n);
    if (result == GLBK_OK) result = glbk_ism_vpls_upload(gl, &room.maps, vpls, (uint32_t)n, &info);
    points = ism_near_points(room.chosen, &n);
    if (result == GLBK_OK) result = glbk_ism_near_points_upload(gl, &room.maps, points, (uint32_t)n);
    return result == GLBK_OK ? glbk_ism_draw(gl, &room.maps, 0) : result;
}

/* Bounced light with shadows, over what the pass's target has. */
static glbk_result bounce_by_ism(pg_stage *stage, const glbk_pass *pass, const float knobs[PG_KNOBS])
{
    glbk_context *gl = stage->gl;
    ism_shading shading;
    ism_mesh mesh;
    float *positions;
    uint32_t *indices;
    glbk_result result;
    memset(&mesh, 0, sizeof mesh);
    memset(&shading, 0, sizeof shading);
    shading.interleave = (uint32_t)knobs[INTERLEAVE];   /* so many pixels square share the lights; a blur mends that */
    shading.bias = knobs[BIAS] > 0 ? knobs[BIAS] : -1;
    if (pg_model_merge(&room.model, &positions, &mesh.vertex_count, &indices, &mesh.index_count) != 0)
        return GLBK_ERR_ALLOC;
    mesh.positions = positions;
    mesh.indices = indices;
    if (room.has_mesh) result = glbk_ism_mesh_move(gl, &room.maps, positions, 0);
    else result = glbk_ism_mesh_upload(gl, &room.maps, &mesh);
    room.has_mesh = result == GLBK_OK;
    if (result == GLBK_OK) result = choose(stage, &mesh);
    free(positions);
    free(indices);
    if (result == GLBK_OK) result = draw_maps(gl);
    if (result == GLBK_OK) result = glbk_ism_shade(gl, &room.ism, &stage->seen, &room.maps, &shading, 0);
    room.index++;
    return result == GLBK_OK ? glbk_ism_resolve(gl, &room.ism, &stage->seen, pass, NULL) : result;
}

static glbk_result bounce_by_rsm(pg_stage *stage, const float knobs[PG_KNOBS])
{
    glbk_rsm_map *map = &room.map;
    rsm_gather_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.pattern = RSM_PATTERN_FLUX;
    desc.sample_count = (uint32_t)knobs[SAMPLES];
    desc.interleave = (uint32_t)knobs[INTERLEAVE];
    desc.near_limit = knobs[NEAR_LIMIT];
    desc.clamp = knobs[CLAMP];
    desc.offset = knobs[OFFSET];
    desc.seed = stage->frames;
    return glbk_rsm_gather(stage->gl, &room.rsm, &stage->seen, &map, 1, &desc);
}

int pg_scene_light(pg_stage *stage, const float knobs[PG_KNOBS], float time, char *error)
{
    const glbk_rsm_map *map = &room.map;
    const rsm_light spot = lamp(stage, knobs[CONE]);
    const int bounce = (int)knobs[BOUNCE];
    glbk_context *gl = stage->gl;
    rsm_direct_desc direct;
    glbk_pass pass;
    glbk_result result = fit(stage);
    memset(&pass, 0, sizeof pass);
    memset(&direct, 0, sizeof direct);
    direct.slope_bias = knobs[SLOPE_BIAS] > 0 ? knobs[SLOPE_BIAS] : -1;
    pass.target = &stage->light_target;
    stage->exposure = 1.3f * knobs[EXPOSURE];
    walk(time);
    if (result == GLBK_OK) result = make_map(stage, &spot, (uint32_t)knobs[MAP_SIDE]);
    if (result == GLBK_OK && bounce == ISM_BOUNCE) result = make_maps(stage, knobs);
    if (result == GLBK_OK) result = glbk_rsm_map_place(gl, &room.map, &spot);
    if (result == GLBK_OK) result = glbk_rsm_map_draw(gl, &room.rsm, &room.map, draw_lit, NULL);
    if (result == GLBK_OK) result = pg_stage_draw(stage, &room.model, NULL, 0);
    if (result == GLBK_OK) result = glbk_rsm_direct(gl, &room.rsm, &stage->seen, &map, 1, &direct);
    if (result == GLBK_OK && bounce == RSM_BOUNCE) result = bounce_by_rsm(stage, knobs);
    if (result == GLBK_OK)
        result = glbk_rsm_resolve(gl, &room.rsm, &stage->seen, &pass, NULL, 1, bounce == RSM_BOUNCE);
    pass.blend = GLBK_BLEND_ADD;
    if (result == GLBK_OK && bounce == ISM_BOUNCE) result = bounce_by_ism(stage, &pass, knobs);
    return result == GLBK_OK ? 0 : pg_failed("the light", result, error);
}

int pg_scene_lights(const pg_stage *stage, const float knobs[PG_KNOBS], pg_lights *out, char *error)
{
    const rsm_light spot = lamp(stage, knobs[CONE]);
    (void)error;
    pg_lights_spot(out, spot.position, spot.direction, spot.cone_half_angle, spot.value);
    out->bounces = knobs[BOUNCE] > 0;
    return 0;
}
