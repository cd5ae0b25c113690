/* builtin_plant.c - a leafy pot plant: arching stems with alternate leaves round a clay pot. The leaves are single
   sheets, double-sided, which is what makes it a hard case; pot and stems are closed. Metres. */
#include "internal.h"

enum { STEMS = 24, STEM_POINTS = 14, LEAVES_PER_STEM = 8, LEAF_ALONG = 12, LEAF_ACROSS = 6 };

typedef struct plant_look { uint32_t clay, soil, stem, leaf[3]; } plant_look;

static void add_pot(ex_builder *b, const plant_look *look)
{
    /* Up the outside, over the rim, down the inside to the soil. */
    static const float profile[][2] = {{0, 0}, {0.100f, 0}, {0.106f, 0.004f}, {0.112f, 0.030f}, {0.138f, 0.185f},
        {0.140f, 0.190f}, {0.152f, 0.192f}, {0.156f, 0.198f}, {0.158f, 0.232f}, {0.154f, 0.238f}, {0.144f, 0.238f},
        {0.140f, 0.232f}, {0.136f, 0.215f}, {0, 0.215f}};
    uint32_t first = b->mesh.triangle_count;
    ex_build_lathe(b, profile[0], sizeof profile / sizeof *profile, 64, 0.6f, look->clay);
    for (uint32_t t = first; t < b->mesh.triangle_count; t++) {
        const uint32_t *index = b->mesh.indices + 3 * (size_t)t;
        int soil = 1;
        for (int k = 0; k < 3; k++) soil &= b->mesh.positions[3 * (size_t)index[k] + 1] == 0.215f;
        if (soil) b->mesh.materials[t] = look->soil;
    }
}

/* A leaf from `base` along `along`, sinking under its own weight, folded along its midrib. */
static void add_leaf(ex_builder *b, v3 base, v3 along, float length, float width, uint32_t material)
{
    v3 side = v3_unit(v3_cross(along, v3_make(0, 1, 0)));
    v3 middle = base, direction = along;
    uint32_t first = b->mesh.vertex_count;
    for (int i = 0; i <= LEAF_ALONG; i++) {
        float s = (float)i / LEAF_ALONG;
        v3 up = v3_unit(v3_cross(side, direction));
        /* Ovate outline: a short stalk, widest at a third, drawn out to a tip. */
        float t = ex_clamp((s - 0.08f) / 0.92f, 0, 1);
        float half = 0.0003f + 0.0037f * (1 - s) + 0.5f * width * 2.6f * powf(t, 0.75f) * powf(1 - t, 1.15f);
        for (int k = 0; k <= LEAF_ACROSS; k++) {
            float across = 2 * (float)k / LEAF_ACROSS - 1, fold = 0.30f * fabsf(across) - 0.16f * across * across;
            float wave = 0.05f * sinf(9 * s + 2 * across) * across * across;
            v3 p = v3_mad(middle, side, across * half);
            ex_build_vertex(b, v3_mad(p, up, half * (fold + wave)), v3_make(0, 0, 0));
        }
        middle = v3_mad(middle, direction, length / LEAF_ALONG);
        direction = v3_unit(v3_mad(direction, v3_make(0, -1, 0), 0.11f));
    }
    for (uint32_t i = 0; i < LEAF_ALONG; i++)
        for (uint32_t k = 0; k < LEAF_ACROSS; k++) {
            uint32_t a = first + i * (LEAF_ACROSS + 1) + k, c = a + LEAF_ACROSS + 1;
            ex_build_triangle(b, a, a + 1, c + 1, material);
            ex_build_triangle(b, a, c + 1, c, material);
        }
}

/* A stem that rises from the soil and bows outwards; leaves turn round it by the golden angle. */
static void add_stem(ex_builder *b, const plant_look *look, int number, uint32_t *seed)
{
    const float golden = 2.3999632f;
    float turn = golden * (float)number, spread = sqrtf(((float)number + 0.5f) / STEMS);
    float height = 0.50f - 0.20f * spread + 0.10f * ex_random(seed), lean = 0.05f + 0.75f * spread;
    v3 outwards = v3_make(cosf(turn), 0, sinf(turn)), path[STEM_POINTS];
    float radii[STEM_POINTS];
    v3 p = v3_add(v3_scale(outwards, 0.085f * spread), v3_make(0, 0.205f, 0));
    v3 direction = v3_unit(v3_mad(v3_make(0, 1, 0), outwards, 0.6f * lean));
    for (int i = 0; i < STEM_POINTS; i++) {
        float s = (float)i / (STEM_POINTS - 1);
        path[i] = p;
        radii[i] = 0.0052f * (1 - 0.65f * s);
        p = v3_mad(p, direction, height / (STEM_POINTS - 1));
        direction = v3_unit(v3_mad(direction, v3_mad(outwards, v3_make(0, -1, 0), 0.35f), 0.11f * lean));
    }
    ex_build_tube(b, path, radii, STEM_POINTS, 8, look->stem);
    for (int k = 0; k < LEAVES_PER_STEM; k++) {
        float s = 0.22f + 0.77f * (float)k / (LEAVES_PER_STEM - 1), at = s * (STEM_POINTS - 1);
        int i = (int)at;
        v3 base = v3_mad(v3_scale(path[i], 1 - (at - (float)i)), path[i + 1], at - (float)i);
        v3 stem = v3_unit(v3_sub(path[i + 1], path[i]));
        float angle = turn + golden * (float)(k + 1) + 0.5f * ex_random(seed);
        v3 around = v3_make(cosf(angle), 0.25f + 0.3f * ex_random(seed), sinf(angle));
        int tip = k + 1 == LEAVES_PER_STEM;
        v3 along = v3_unit(v3_add(v3_scale(around, tip ? 0.35f : 1), v3_scale(stem, tip ? 1.0f : 0.45f)));
        float length = (0.165f + 0.06f * ex_random(seed)) * (1.15f - 0.45f * s);
        uint32_t material = look->leaf[(int)(3 * ex_random(seed))];
        add_leaf(b, base, along, length, 0.44f * length, material);
    }
}

uint32_t ex_build_plant_mesh(ex_builder *b)
{
    plant_look look;
    uint32_t seed = 20260;
    look.clay = ex_build_material(b, 0.46f, 0.20f, 0.115f);
    look.soil = ex_build_material(b, 0.060f, 0.042f, 0.030f);
    look.stem = ex_build_material(b, 0.16f, 0.22f, 0.07f);
    look.leaf[0] = ex_build_material(b, 0.10f, 0.26f, 0.06f);
    look.leaf[1] = ex_build_material(b, 0.14f, 0.33f, 0.08f);
    look.leaf[2] = ex_build_material(b, 0.20f, 0.38f, 0.10f);
    for (int i = 0; i < 3 && !b->failed; i++) b->scene->materials[look.leaf[i]].double_sided = 1;
    add_pot(b, &look);
    for (int i = 0; i < STEMS; i++) add_stem(b, &look, i, &seed);
    return ex_build_finish(b);
}

void ex_build_plant(ex_builder *b)
{
    ex_build_object(b, "plant", ex_build_plant_mesh(b));
}
