/* builtin_corridor.c - after Fig. 7 of the paper on view-adaptive imperfect shadow maps: a spot light shines on the
   wall at one end of a corridor, the camera watches a statue at the other end, lit by that wall alone. Its shadow needs
   occluder points near the statue, not all along the corridor. Metres; the statue's end is z = 0. */
#include "internal.h"

static const float half = 1.35f, height = 3.0f, length = 12, bay = 3;

static void add_shell(ex_builder *b)
{
    uint32_t plaster = ex_build_material(b, 0.74f, 0.71f, 0.64f), end = ex_build_material(b, 0.80f, 0.76f, 0.68f);
    uint32_t far_end = ex_build_material(b, 0.84f, 0.72f, 0.52f);
    uint32_t bays = (uint32_t)(length / bay);
    v3 up = v3_make(0, height, 0), across = v3_make(2 * half, 0, 0), along = v3_make(0, 0, -length);
    ex_build_panel(b, v3_make(-half, 0, 0), along, up, 16 * bays, 16, plaster);
    ex_build_panel(b, v3_make(half, 0, -length), v3_scale(along, -1), up, 16 * bays, 16, plaster);
    ex_build_panel(b, v3_make(-half, height, -length), across, v3_scale(along, -1), 14, 16 * bays, plaster);
    ex_build_panel(b, v3_make(half, 0, 0), v3_scale(across, -1), up, 14, 16, end);
    ex_build_panel(b, v3_make(-half, 0, -length), across, up, 14, 16, far_end);
    ex_build_object(b, "walls", ex_build_finish(b));
}

/* Square tiles with bevelled edges on two colours of stone. */
static void add_floor(ex_builder *b)
{
    const float size = 0.3f, bevel = 0.006f, deep = 0.004f;
    uint32_t stone[2], nx = (uint32_t)(2 * half / size + 0.5f), nz = (uint32_t)(length / size + 0.5f);
    stone[0] = ex_build_material(b, 0.60f, 0.57f, 0.50f);
    stone[1] = ex_build_material(b, 0.26f, 0.20f, 0.17f);
    for (uint32_t j = 0; j < nz; j++)
        for (uint32_t i = 0; i < nx; i++)
            ex_build_tile(b, v3_make(-half + size * (float)i, 0, -size * (float)(j + 1)), size, size, bevel, deep,
                          stone[(i + j) % 2]);
    ex_build_object(b, "floor", ex_build_finish(b));
}

/* One side of one bay: a pilaster, panelling with a rail, a skirting. At x = 0, facing +X, from z = 0 to -bay. */
static uint32_t build_bay(ex_builder *b, uint32_t stone, uint32_t wood)
{
    static const float steps[][3] = {{0, 0.16f, 0.135f}, {0.16f, 0.21f, 0.115f}, {0.21f, 2.55f, 0.085f},
        {2.55f, 2.60f, 0.105f}, {2.60f, 2.68f, 0.12f}, {2.68f, 2.84f, 0.15f}};
    for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
        float w = 0.12f + steps[i][2] - 0.085f;
        ex_build_block(b, v3_make(-0.01f, steps[i][0], -w), v3_make(steps[i][2], steps[i][1], w), 0.008f, stone);
    }
    for (int k = 0; k < 3; k++)                      /* flutes of the shaft */
        ex_build_block(b, v3_make(0.08f, 0.3f, -0.085f + 0.07f * (float)k), v3_make(0.097f, 2.45f, -0.055f +
                       0.07f * (float)k), 0.006f, stone);
    ex_build_block(b, v3_make(-0.01f, 2.84f, -bay + 0.12f), v3_make(0.09f, 2.92f, -0.12f), 0.01f, stone);
    ex_build_block(b, v3_make(-0.01f, 0, -bay + 0.12f), v3_make(0.03f, 0.14f, -0.12f), 0.006f, wood);
    ex_build_block(b, v3_make(-0.01f, 0.92f, -bay + 0.12f), v3_make(0.04f, 0.98f, -0.12f), 0.008f, wood);
    for (int k = 0; k < 4; k++) {                    /* panels: a frame and a field */
        float z1 = -0.20f - 0.66f * (float)k, z0 = z1 - 0.6f;
        ex_build_block(b, v3_make(-0.01f, 0.20f, z0), v3_make(0.018f, 0.86f, z1), 0.006f, wood);
        ex_build_block(b, v3_make(0, 0.27f, z0 + 0.07f), v3_make(0.030f, 0.79f, z1 - 0.07f), 0.011f, wood);
    }
    return ex_build_finish(b);
}

static void add_bays(ex_builder *b)
{
    uint32_t stone = ex_build_material(b, 0.66f, 0.62f, 0.55f), wood = ex_build_material(b, 0.30f, 0.17f, 0.09f);
    uint32_t mesh = build_bay(b, stone, wood);
    for (int i = 0; i < (int)(length / bay); i++)
        for (int side = 0; side < 2; side++) {
            float z = -bay * (float)i;
            ex_object *object = ex_build_object(b, side ? "bay right" : "bay left", mesh);
            if (object) ex_place(object->transform, v3_make(side ? half : -half, 0, side ? z - bay : z),
                                 side ? EX_PI : 0, 1);
        }
    ex_build_block(b, v3_make(-half, 2.78f, -0.11f), v3_make(half, height + 0.01f, 0.11f), 0.012f, stone);
    uint32_t beam = ex_build_finish(b);
    for (int i = 1; i < (int)(length / bay); i++) {
        ex_object *object = ex_build_object(b, "beam", beam);
        if (object) object->transform[14] = -bay * (float)i;
    }
}

/* A horse's head on a pedestal. */
static void add_statue(ex_builder *b)
{
    static const float pedestal[][2] = {{0, 0}, {0.33f, 0}, {0.33f, 0.09f}, {0.30f, 0.11f}, {0.28f, 0.15f},
        {0.235f, 0.19f}, {0.22f, 0.24f}, {0.215f, 0.60f}, {0.22f, 0.78f}, {0.25f, 0.82f}, {0.26f, 0.85f},
        {0.29f, 0.87f}, {0.29f, 0.93f}, {0, 0.93f}};
    float m[16];
    uint32_t stone = ex_build_material(b, 0.52f, 0.50f, 0.47f), marble = ex_build_material(b, 0.82f, 0.79f, 0.74f);
    ex_build_lathe(b, pedestal[0], sizeof pedestal / sizeof *pedestal, 64, 0.5f, stone);
    ex_object *object = ex_build_object(b, "pedestal", ex_build_finish(b));
    if (object) object->transform[14] = -1.25f;
    ex_build_horse(b, marble);
    ex_mark all = {0, 0};
    ex_place(m, v3_make(0, 0, 0), 0, 17);
    m[13] = -17 * 0.015f;
    ex_build_transform(b, all, m);
    ex_build_block(b, v3_make(-0.24f, -0.05f, -0.16f), v3_make(0.22f, 0.03f, 0.16f), 0.01f, marble);
    object = ex_build_object(b, "statue", ex_build_finish(b));
    if (object) ex_place(object->transform, v3_make(0, 0.98f, -1.25f), EX_PI - 0.45f, 1);
}

void ex_build_corridor(ex_builder *b)
{
    add_shell(b);
    add_floor(b);
    add_bays(b);
    add_statue(b);
    ex_light *lamp = ex_build_light(b, EX_LIGHT_SPOT);
    if (!lamp) return;
    v3_store(lamp->position, v3_make(0, 2.3f, -length + 3.2f));
    v3_store(lamp->direction, v3_unit(v3_make(0, -0.22f, -1)));
    lamp->cos_half_angle = cosf(27 * EX_PI / 180);
    v3_store(lamp->value, v3_make(100, 90, 75));
    ex_build_camera(b, v3_make(0.55f, 1.6f, -4.3f), v3_make(-0.1f, 1.25f, 0), 46);
}
