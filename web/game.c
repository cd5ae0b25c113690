/* game.c - the page "game", see stage.h: a chess set whose pieces and lamps the user drags. shadowfield.h computes a
   field of each kind of piece once; gl_shadowfield.h then shades the board and all pieces wherever they stand, without
   looking at a triangle again. */
#include "../gl_backend/gl_shadowfield.h"
#include "stage.h"
#include "../examples/common/internal.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_BANDS = 6, COEFS = MOST_BANDS * MOST_BANDS, PIECES = 32, KINDS = 6, LAMPS = 2, ENTITIES = PIECES + LAMPS };
enum { LAMP_LIGHT, SKY_LIGHT, LAMP_COUNT, BANDS, POSITION_SIDE, SHELLS, REACH };    /* knobs */

static const float lamp_radius = 0.1f, lamp_height = 0.25f, grip = 0.03f, cell = 0.005f;
static const float sky_tint[3] = { 0.75f, 0.87f, 1 };
static const float game_time = 7.99f;                   /* seconds; ten moves have been played */

static struct game {
    pg_model             model;         /* objects: the board, pieces, the table */
    sfield_algebra      *algebra;
    sfield_field        *kinds[KINDS], *lamp;
    uint32_t             bands, position_side, shells;  /* of the fields; 0: they are not built */
    float                reach;                         /* of the scene on the GPU */
    glbk_sfield_scene    scene;
    glbk_sfield_renderer renderer;
    glbk_program         light;
} game;

/* ---- fields, once ---- */

/* The board's mesh is the scene's first, pieces follow. */
static const ex_mesh *mesh_of(int kind) { return &game.model.scene.meshes[1 + kind]; }

/* The first vertex of the cell that vertex i lies in, by a table of as many slots as a power of two above twice the
   vertices; slots hold a vertex + 1, or 0. */
static uint32_t first_in_cell(const ex_mesh *from, uint32_t i, uint32_t *slots, uint32_t slot_count)
{
    const float *p = from->positions + 3 * (size_t)i;
    int at[3];
    uint32_t slot = 0;
    for (int axis = 0; axis < 3; axis++) {
        at[axis] = (int)floorf(p[axis] / cell);
        slot = slot * 73856093u + (uint32_t)at[axis];
    }
    for (slot *= 2654435769u, slot >>= 8;; slot++) {
        uint32_t *taken = &slots[slot & (slot_count - 1)];
        const float *q = from->positions + 3 * (size_t)(*taken ? *taken - 1 : i);
        int same = 1;
        for (int axis = 0; axis < 3; axis++) same &= (int)floorf(q[axis] / cell) == at[axis];
        if (!*taken) *taken = i + 1;
        if (same) return *taken - 1;
    }
}

/* The triangles of a piece on a grid of cells: those with corners in three of them, each corner the first vertex of its
   cell. Small details cast no shadow that the fields could tell, and time grows with triangles. indices has room for
   all; their number is written to count. */
static int simplify(const ex_mesh *from, uint32_t *indices, size_t *count)
{
    uint32_t slot_count = 1;
    uint32_t *cells = malloc(from->vertex_count * sizeof *cells), *slots;
    while (slot_count < 2 * from->vertex_count) slot_count *= 2;
    slots = calloc(slot_count, sizeof *slots);
    for (uint32_t i = 0; cells && slots && i < from->vertex_count; i++)
        cells[i] = first_in_cell(from, i, slots, slot_count);
    *count = 0;
    for (uint32_t t = 0; cells && slots && t < from->triangle_count; t++) {
        const uint32_t *c = from->indices + 3 * (size_t)t, i = cells[c[0]], j = cells[c[1]], k = cells[c[2]];
        if (i == j || j == k || k == i) continue;
        indices[(*count)++] = i;
        indices[(*count)++] = j;
        indices[(*count)++] = k;
    }
    free(cells);
    free(slots);
    return cells && slots ? 0 : -1;
}

static int build_kind(int kind)
{
    const ex_mesh *from = mesh_of(kind);
    uint32_t *indices = malloc(3 * from->triangle_count * sizeof *indices);
    sfield_mesh mesh = { from->positions, from->vertex_count, 0, indices, 0, NULL, NULL, NULL };
    sfield_desc desc;
    int failed = !indices;
    memset(&desc, 0, sizeof desc);
    desc.bands = game.bands;
    desc.cube_side = 16;
    desc.position_side = game.position_side;
    desc.shell_count = game.shells;
    desc.outer = 3;                             /* further off a piece is too small for the bands, and costs time */
    failed = failed || simplify(from, indices, &mesh.index_count) != 0 ||
             sfield_build(&desc, &mesh, &game.kinds[kind], NULL) != SFIELD_OK;
    free(indices);
    return failed ? -1 : 0;
}

/* The board has no field, since a slab that everything stands on is near to all points: it is laid into the table, 2.5
   millimetres high, and throws hardly a shadow. */
static void lay_in(ex_scene *scene)
{
    ex_object *table = &scene->objects[scene->object_count - 1];
    table->transform[13] += 0.0155f;
}

static void free_fields(void)
{
    for (int kind = 0; kind < KINDS; kind++) {
        sfield_free(game.kinds[kind]);
        game.kinds[kind] = NULL;
    }
    sfield_free(game.lamp);
    sfield_algebra_free(game.algebra);
    game.lamp = NULL;
    game.algebra = NULL;
    game.bands = 0;
}

/* Fields of all kinds and of a lamp. Their numbers are set. */
static int build_fields(char *error)
{
    sfield_emitter lamp;
    sfield_desc desc;
    int failed;
    memset(&lamp, 0, sizeof lamp);
    memset(&desc, 0, sizeof desc);
    desc.bands = game.bands;
    lamp.kind = SFIELD_EMITTER_SPHERE;
    lamp.radius = lamp_radius;
    lamp.radiance[0] = lamp.radiance[1] = lamp.radiance[2] = 1;
    failed = sfield_algebra_create(game.bands, NULL, &game.algebra) != SFIELD_OK ||
             sfield_build_emitter(&desc, &lamp, &game.lamp, NULL) != SFIELD_OK;
    for (int kind = 0; kind < KINDS && !failed; kind++) failed = build_kind(kind) != 0;
    if (!failed) return 0;
    free_fields();
    return ex_fail(error, "the fields cannot be built");
}

static int build(char *error)
{
    ex_scene scene;
    if (ex_scene_builtin(&scene, "chess", 0, error) != 0) return -1;
    if (ex_scene_set_time(&scene, game_time, error) != 0) {
        ex_scene_free(&scene);
        return -1;
    }
    lay_in(&scene);
    return pg_model_take(&game.model, &scene, 1, error);
}

static void place_handles(pg_stage *stage)
{
    const float reach = 0.30f, low[3] = { -reach, 0, -reach }, high[3] = { reach, 0.4f, reach };
    if (stage->handle_count) return;            /* a context that comes back finds them where they were */
    memcpy(stage->box[0], low, sizeof low);
    memcpy(stage->box[1], high, sizeof high);
    for (int i = 0; i < LAMPS; i++) {
        static const float at[LAMPS][2] = { { -0.05f, -0.1f }, { 0.27f, -0.05f } };
        static const float color[LAMPS][3] = { { 1, 0.95f, 0.85f }, { 0.4f, 0.22f, 0.1f } };
        pg_handle lamp = { { at[i][0], lamp_height, at[i][1] }, 0.05f, PG_TRACK_PLANE, { 0, 0, 0 } };
        memcpy(lamp.color, color[i], sizeof lamp.color);
        stage->handles[i] = lamp;
    }
    for (int i = 0; i < PIECES; i++) {
        const float *at = game.model.scene.objects[1 + i].transform + 12;
        const pg_handle piece = { { at[0], grip, at[2] }, 0.022f, PG_TRACK_PLANE, { 0, 0, 0 } };
        stage->handles[LAMPS + i] = piece;
    }
    stage->handle_count = LAMPS + PIECES;
}

/* ---- on the GPU ---- */

/* Light times colour. What rings below zero is cut off. */
static const char light_text[] =
    "uniform glbk_color_sampler glbk_user0;\n"
    "layout(location = 0) out glbk_color light;\n"
    "void main()\n"
    "{\n"
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
    "    glbk_point p;\n"
    "    vec3 seen = vec3(0.0);\n"
    "    if (glbk_read_point(at, p)) seen = p.diffuse * max(glbk_unpack(texelFetch(glbk_user0, at, 0)).rgb, 0.0);\n"
    "    light = glbk_pack(vec4(seen, 1.0));\n"
    "}\n";

int pg_scene_create(pg_stage *stage, char *error)
{
    glbk_source source;
    glbk_result result;
    memset(&source, 0, sizeof source);
    source.fragment = light_text;
    source.uses = "gbuffer";
    source.parts[0] = glbk_gbuffer_part();
    if (!game.model.scene.object_count && build(error) != 0) return -1;
    place_handles(stage);
    if (pg_model_upload(&game.model, stage->gl, error) != 0) return -1;
    result = glbk_program_compile(stage->gl, &source, &game.light);
    return result == GLBK_OK ? 0 : pg_failed("the set", result, error);
}

/* Fields as the knobs say, here and on the GPU, unless they are as they were. */
static int make_fields(pg_stage *stage, const float knobs[PG_KNOBS], char *error)
{
    const uint32_t bands = (uint32_t)knobs[BANDS], side = (uint32_t)knobs[POSITION_SIDE], shells = (uint32_t)knobs[SHELLS];
    const sfield_field *fields[KINDS + 1];
    glbk_sfield_scene_desc desc;
    glbk_result result;
    const int same = game.bands == bands && game.position_side == side && game.shells == shells;
    memset(&desc, 0, sizeof desc);
    if (same && game.scene.table.name && game.reach == knobs[REACH]) return 0;
    glbk_sfield_scene_free(stage->gl, &game.scene);
    if (!same) {
        glbk_sfield_renderer_free(stage->gl, &game.renderer);       /* which has a program for so many bands */
        free_fields();
        game.bands = bands;
        game.position_side = side;
        game.shells = shells;
        if (build_fields(error) != 0) return -1;
    }
    for (int i = 0; i < KINDS; i++) fields[i] = game.kinds[i];
    fields[KINDS] = game.lamp;
    desc.algebra = game.algebra;
    desc.fields = fields;
    desc.field_count = KINDS + 1;
    desc.entity_capacity = ENTITIES;
    desc.reach = knobs[REACH];
    result = glbk_sfield_scene_create(stage->gl, &desc, &game.scene);
    game.reach = knobs[REACH];
    return result == GLBK_OK ? 0 : pg_failed("the set", result, error);
}

void pg_scene_free(pg_stage *stage)
{
    glbk_sfield_scene_free(stage->gl, &game.scene);
    glbk_sfield_renderer_free(stage->gl, &game.renderer);
    glbk_program_free(stage->gl, &game.light);
    pg_model_release(&game.model, stage->gl);
}

const pg_model *pg_scene_model(void) { return &game.model; }

static glbk_result fit(pg_stage *stage)
{
    glbk_sfield_renderer_desc desc;
    if (game.renderer.width == stage->width && game.renderer.height == stage->height) return GLBK_OK;
    if (game.renderer.width)
        return glbk_sfield_renderer_resize(stage->gl, &game.renderer, stage->width, stage->height);
    memset(&desc, 0, sizeof desc);
    desc.width = stage->width;
    desc.height = stage->height;
    desc.algebra = game.algebra;
    return glbk_sfield_renderer_create(stage->gl, &desc, &game.renderer);
}

/* ---- a frame ---- */

/* Pieces are entities, lamps follow; the board and the table are none. */
static glbk_result place(pg_stage *stage, const float knobs[PG_KNOBS])
{
    sfield_entity entities[ENTITIES];
    const int lamps = (int)knobs[LAMP_COUNT];
    memset(entities, 0, sizeof entities);
    for (int i = 0; i < PIECES; i++) {
        ex_object *object = &game.model.scene.objects[1 + i];
        const float *at = stage->handles[LAMPS + i].position;
        object->transform[12] = at[0];
        object->transform[14] = at[2];
        entities[i].occlusion = game.kinds[object->mesh - 1];
        memcpy(entities[i].transform, object->transform, sizeof object->transform);
    }
    for (int i = 0; i < lamps && i < LAMPS; i++) {
        const pg_handle *lamp = &stage->handles[i];
        sfield_entity *e = &entities[PIECES + i];
        ex_identity(e->transform);
        e->source = game.lamp;
        for (int k = 0; k < 3; k++) {
            e->transform[12 + k] = lamp->position[k];
            e->tint[k] = knobs[LAMP_LIGHT] * lamp->color[k];
        }
    }
    return glbk_sfield_scene_entities(stage->gl, &game.scene, entities, (size_t)(PIECES + lamps));
}

/* What a sky of light 1 sends from a height -1..1, before its tint: more from above, and nothing from below the table. */
static float sky_at(float height) { return height > 0 ? 1 + 0.6f * height : 0; }

/* The sky's coefficients, of light 1 and without its tint. */
static void project_sky(float coefs[COEFS])
{
    enum { SIDE = 16, TEXELS = 6 * SIDE * SIDE };
    float texels[TEXELS], direction[3];
    for (uint32_t i = 0; i < TEXELS; i++) {
        sfield_cube_texel(SIDE, i, direction);
        texels[i] = sky_at(direction[1]);
    }
    sfield_sh_project(game.bands, SIDE, texels, 1, coefs);
}

static glbk_result set_sky(pg_stage *stage, float light)
{
    float one[COEFS], coefs[3 * COEFS];
    const uint32_t count = game.bands * game.bands;
    project_sky(one);
    for (uint32_t k = 0; k < 3; k++) {
        for (uint32_t i = 0; i < count; i++) coefs[count * k + i] = light * sky_tint[k] * one[i];
        stage->backdrop[k] = 0.5f * light * sky_tint[k] + 0.01f;
    }
    return glbk_sfield_scene_sky(stage->gl, &game.scene, light > 0 ? coefs : NULL);
}

static glbk_result draw(pg_stage *stage)
{
    return pg_stage_draw(stage, &game.model, NULL, 1);
}

int pg_scene_light(pg_stage *stage, const float knobs[PG_KNOBS], float time, char *error)
{
    glbk_context *gl = stage->gl;
    glbk_pass pass;
    glbk_result result;
    (void)time;
    memset(&pass, 0, sizeof pass);
    pass.target = &stage->light_target;
    stage->exposure = 1;
    if (make_fields(stage, knobs, error) != 0) return -1;
    result = fit(stage);
    if (result == GLBK_OK) result = place(stage, knobs);
    if (result == GLBK_OK) result = set_sky(stage, knobs[SKY_LIGHT]);
    if (result == GLBK_OK) result = draw(stage);
    if (result == GLBK_OK) result = glbk_sfield_shade(gl, &game.renderer, &stage->seen, &game.scene, NULL, 0);
    if (result == GLBK_OK) result = glbk_begin(gl, &pass, &game.light);
    if (result == GLBK_OK) result = glbk_gbuffer_bind(gl, &stage->seen, NULL);
    if (result != GLBK_OK) return pg_failed("the light", result, error);
    glbk_bind_texture(gl, GLBK_SLOT_glbk_user0, &game.renderer.light);
    glbk_draw_screen(gl);
    return 0;
}

int pg_scene_lights(const pg_stage *stage, const float knobs[PG_KNOBS], pg_lights *out, char *error)
{
    enum { WIDTH = 64, HEIGHT = 32 };
    memset(out, 0, sizeof *out);
    out->count = (uint32_t)knobs[LAMP_COUNT];
    for (uint32_t i = 0; i < out->count; i++) {
        out->lights[i].kind = EX_LIGHT_SPHERE;
        out->lights[i].radius = lamp_radius;
        for (int k = 0; k < 3; k++) {
            out->lights[i].position[k] = stage->handles[i].position[k];
            out->lights[i].value[k] = knobs[LAMP_LIGHT] * stage->handles[i].color[k];
        }
    }
    out->sky.rgb = malloc(3 * WIDTH * HEIGHT * sizeof *out->sky.rgb);
    if (!out->sky.rgb) return ex_fail(error, "out of memory");
    out->sky.width = WIDTH;
    out->sky.height = HEIGHT;
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++)
        for (uint32_t k = 0; k < 3; k++)
            out->sky.rgb[3 * i + k] = knobs[SKY_LIGHT] * sky_tint[k] *
                                      sky_at(cosf(EX_PI * ((float)(i / WIDTH) + 0.5f) / HEIGHT));
    return 0;
}
