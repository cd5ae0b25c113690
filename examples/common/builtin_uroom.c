/* builtin_uroom.c - a room in the shape of a U, after Fig. 10 of the paper on view-adaptive imperfect shadow maps:
   a spot light stands in one leg, the camera in the other. All that the camera sees is lit by what passes round the
   corner. Few of the places that the lamp lights are seen from there, which is what importance from both sides is for.
   Metres. */
#include "internal.h"

static const float half_x = 4, back = -3.6f, front = 3.6f, height = 2.8f, corner = -1.4f;

/* A rectangle with a vertex every quarter of a metre. */
static void add_wall(ex_builder *b, v3 p, v3 u, v3 v, uint32_t material)
{
    ex_build_panel(b, p, u, v, (uint32_t)(4 * v3_length(u) + 0.5f), (uint32_t)(4 * v3_length(v) + 0.5f), material);
}

static void add_room(ex_builder *b)
{
    uint32_t plaster = ex_build_material(b, 0.76f, 0.74f, 0.70f), boards = ex_build_material(b, 0.50f, 0.36f, 0.24f);
    uint32_t rust = ex_build_material(b, 0.68f, 0.30f, 0.16f), sage = ex_build_material(b, 0.36f, 0.46f, 0.36f);
    uint32_t divider = ex_build_material(b, 0.72f, 0.70f, 0.66f), skirting = ex_build_material(b, 0.82f, 0.81f, 0.79f);
    v3 x = v3_make(2 * half_x, 0, 0), y = v3_make(0, height, 0), z = v3_make(0, 0, front - back);
    v3 minus_x = v3_scale(x, -1), minus_z = v3_scale(z, -1);
    add_wall(b, v3_make(-half_x, 0, front), x, minus_z, boards);
    add_wall(b, v3_make(-half_x, height, back), x, z, plaster);
    add_wall(b, v3_make(-half_x, 0, back), x, y, plaster);
    add_wall(b, v3_make(half_x, 0, front), minus_x, y, plaster);
    add_wall(b, v3_make(-half_x, 0, front), minus_z, y, rust);
    add_wall(b, v3_make(half_x, 0, back), z, y, sage);
    ex_build_object(b, "room", ex_build_finish(b));
    ex_build_block(b, v3_make(-0.15f, -0.02f, corner), v3_make(0.15f, height + 0.02f, front + 0.02f), 0.012f, divider);
    ex_build_object(b, "divider", ex_build_finish(b));
    const float h = 0.11f, d = 0.018f;
    ex_build_block(b, v3_make(0.15f, 0, corner), v3_make(0.15f + d, h, front), 0.004f, skirting);
    ex_build_block(b, v3_make(half_x - d, 0, back), v3_make(half_x, h, front), 0.004f, skirting);
    ex_build_block(b, v3_make(-half_x, 0, back), v3_make(half_x, h, back + d), 0.004f, skirting);
    ex_build_block(b, v3_make(-half_x, 0, back), v3_make(-half_x + d, h, front), 0.004f, skirting);
    ex_build_block(b, v3_make(-0.15f - d, 0, corner), v3_make(-0.15f, h, front), 0.004f, skirting);
    ex_build_object(b, "skirting", ex_build_finish(b));
}

/* A round table: foot, stem and top turned in one piece. */
static void add_table(ex_builder *b)
{
    static const float profile[][2] = {{0, 0}, {0.27f, 0}, {0.29f, 0.012f}, {0.28f, 0.03f}, {0.12f, 0.055f},
        {0.05f, 0.10f}, {0.035f, 0.20f}, {0.045f, 0.34f}, {0.035f, 0.52f}, {0.06f, 0.66f}, {0.14f, 0.695f},
        {0.14f, 0.70f}, {0.52f, 0.70f}, {0.535f, 0.71f}, {0.535f, 0.725f}, {0.52f, 0.735f}, {0, 0.735f}};
    uint32_t wood = ex_build_material(b, 0.34f, 0.17f, 0.085f);
    ex_build_lathe(b, profile[0], sizeof profile / sizeof *profile, 72, 0.6f, wood);
    ex_object *object = ex_build_object(b, "table", ex_build_finish(b));
    if (object) ex_place(object->transform, v3_make(1.55f, 0, -1.35f), 0, 1);
}

static void add_vase(ex_builder *b)
{
    static const float profile[][2] = {{0, 0}, {0.055f, 0}, {0.06f, 0.006f}, {0.085f, 0.06f}, {0.10f, 0.12f},
        {0.092f, 0.18f}, {0.06f, 0.235f}, {0.038f, 0.28f}, {0.036f, 0.31f}, {0.05f, 0.345f}, {0.046f, 0.345f},
        {0.031f, 0.31f}, {0.032f, 0.28f}, {0, 0.24f}};
    uint32_t glaze = ex_build_material(b, 0.16f, 0.30f, 0.42f);
    ex_build_lathe(b, profile[0], sizeof profile / sizeof *profile, 64, 0.9f, glaze);
    ex_object *object = ex_build_object(b, "vase", ex_build_finish(b));
    if (object) ex_place(object->transform, v3_make(1.62f, 0.735f, -1.30f), 0, 1);
}

static void add_stool(ex_builder *b)
{
    uint32_t wood = ex_build_material(b, 0.62f, 0.46f, 0.28f);
    ex_build_block(b, v3_make(-0.19f, 0.42f, -0.19f), v3_make(0.19f, 0.46f, 0.19f), 0.01f, wood);
    ex_mark legs = ex_build_mark(b);
    ex_build_block(b, v3_make(0.125f, 0, 0.125f), v3_make(0.165f, 0.425f, 0.165f), 0.005f, wood);
    ex_build_ring(b, legs, 4);
    ex_mark rails = ex_build_mark(b);
    ex_build_block(b, v3_make(-0.13f, 0.17f, 0.132f), v3_make(0.13f, 0.20f, 0.158f), 0.004f, wood);
    ex_build_ring(b, rails, 4);
    uint32_t mesh = ex_build_finish(b);
    static const float places[3][4] = {{2.35f, -1.05f, 0.35f, 0}, {1.25f, -0.55f, 1.1f, 0}, {-2.6f, -2.3f, 0.7f, 0}};
    for (int i = 0; i < 3; i++) {
        ex_object *object = ex_build_object(b, "stool", mesh);
        if (object) ex_place(object->transform, v3_make(places[i][0], 0, places[i][1]), places[i][2], 1);
    }
}

static void add_shelf(ex_builder *b)
{
    static const float books[][3] = {{0.04f, 0.24f, 0}, {0.03f, 0.21f, 1}, {0.05f, 0.27f, 2}, {0.025f, 0.20f, 0},
        {0.045f, 0.25f, 1}, {0.035f, 0.23f, 2}, {0.03f, 0.26f, 0}, {0.05f, 0.22f, 1}};
    enum { BOOKS = sizeof books / sizeof *books };
    const float x0 = 3.68f, x1 = 3.97f, z0 = -2.6f, z1 = -1.2f;
    uint32_t wood = ex_build_material(b, 0.42f, 0.26f, 0.14f), cover[3];
    cover[0] = ex_build_material(b, 0.44f, 0.08f, 0.07f);
    cover[1] = ex_build_material(b, 0.10f, 0.20f, 0.32f);
    cover[2] = ex_build_material(b, 0.62f, 0.52f, 0.30f);
    ex_build_block(b, v3_make(x0, 0, z0), v3_make(x1, 1.9f, z0 + 0.03f), 0.003f, wood);
    ex_build_block(b, v3_make(x0, 0, z1 - 0.03f), v3_make(x1, 1.9f, z1), 0.003f, wood);
    for (int level = 0; level < 6; level++) {
        float y = 0.10f + 0.35f * (float)level, z = z0 + 0.05f;
        ex_build_block(b, v3_make(x0, y, z0 + 0.03f), v3_make(x1, y + 0.025f, z1 - 0.03f), 0.003f, wood);
        for (int i = level; level < 5 && z < z1 - 0.12f - 0.2f * (float)(level % 3); i++) {
            const float *book = books[i * 3 % BOOKS];
            ex_build_block(b, v3_make(x0 + 0.04f, y + 0.025f, z), v3_make(x0 + 0.22f, y + 0.025f + book[1],
                           z + book[0]), 0.003f, cover[(int)book[2]]);
            z += book[0] + 0.002f;
        }
    }
    ex_build_object(b, "shelf", ex_build_finish(b));
}

void ex_build_uroom(ex_builder *b)
{
    add_room(b);
    add_table(b);
    add_vase(b);
    add_stool(b);
    add_shelf(b);
    ex_light *lamp = ex_build_light(b, EX_LIGHT_SPOT);
    if (!lamp) return;
    /* The cone ends where the back wall begins to be seen by the camera. */
    v3_store(lamp->position, v3_make(-2.6f, 2.4f, 2.6f));
    v3_store(lamp->direction, v3_unit(v3_make(-0.40f, -0.30f, -1)));
    lamp->cos_half_angle = cosf(38 * EX_PI / 180);
    v3_store(lamp->value, v3_make(60, 54, 45));
    ex_build_camera(b, v3_make(2.2f, 1.6f, 3.2f), v3_make(1.95f, 1.05f, -1.6f), 50);
}
