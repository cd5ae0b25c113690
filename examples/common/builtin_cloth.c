/* builtin_cloth.c - hanging cloth that moves in the wind, by formula: any time can be asked for. */
#include "internal.h"

/* Each thread down the cloth keeps its length: it is walked from its top, leaning with the wind by an angle that
   travels down it as a wave. Folds start at the top edge and widen. */
void ex_build_drape(ex_builder *b, const ex_drape *d, float time, uint32_t across, uint32_t along, uint32_t material)
{
    v3 edge = v3_sub(d->to, d->from), side = v3_unit(edge), out = v3_cross(side, v3_make(0, 1, 0));
    uint32_t first = b->mesh.vertex_count;
    float step = d->length / (float)along;
    for (uint32_t i = 0; i <= across; i++) {
        float u = (float)i / (float)across, fold = 2 * EX_PI * d->folds * u + d->phase;
        v3 p = v3_mad(d->from, edge, u);
        for (uint32_t j = 0; j <= along; j++) {
            float s = (float)j / (float)along, t = time, w = d->wind * (0.15f + 0.85f * s);
            float gust = 0.6f + 0.4f * sinf(0.7f * t + d->phase);
            float lean = w * (0.35f * gust + 0.55f * sinf(5.2f * s - 2.9f * t + 1.6f * u + d->phase) * gust +
                              0.22f * sinf(9.5f * s - 5.1f * t - 3.1f * u + 2 * d->phase));
            float sway = 0.25f * w * sinf(2.2f * s - 1.3f * t + d->phase);
            float depth = d->fold_depth * (0.5f + s) * sinf(fold + 0.7f * sinf(1.7f * t + 3 * s) * s);
            ex_build_vertex(b, v3_mad(p, out, depth), v3_make(0, 0, 0));
            p = v3_mad(p, v3_make(0, -1, 0), step * cosf(lean) * cosf(sway));
            p = v3_mad(v3_mad(p, out, step * sinf(lean)), side, step * sinf(sway) * cosf(lean));
        }
    }
    for (uint32_t i = 0; i < across; i++)
        for (uint32_t j = 0; j < along; j++) {
            uint32_t a = first + i * (along + 1) + j, c = a + along + 1;
            ex_build_triangle(b, a, a + 1, c + 1, material);
            ex_build_triangle(b, a, c + 1, c, material);
        }
}

/* Another sheet of the same thickness sewn along row `row` of a drape: it shares the vertices of the seam, so that
   three sheets or two meet there and the mesh is no manifold. It stands off by `lift` radians. */
static void add_layer(ex_builder *b, const ex_drape *d, uint32_t base, uint32_t across, uint32_t base_along,
                      uint32_t row, float length, float lift, float time, uint32_t material)
{
    enum { ALONG = 14 };
    v3 side = v3_unit(v3_sub(d->to, d->from)), out = v3_cross(side, v3_make(0, 1, 0));
    uint32_t previous[2] = {0, 0};
    for (uint32_t i = 0; i <= across && !b->failed; i++) {
        uint32_t seam = base + i * (base_along + 1) + row, first = b->mesh.vertex_count;
        float u = (float)i / (float)across, turn = 2 * EX_PI * (2 * d->folds + 1) * u + d->phase;
        v3 p = v3_load(b->mesh.positions + 3 * (size_t)seam);
        for (uint32_t j = 1; j <= ALONG; j++) {
            float s = (float)j / ALONG, ripple = sinf(turn + 2 * s - 1.1f * time) * s;
            float wave = 0.35f * d->wind * sinf(6 * s - 2.9f * time + 3 * u);
            float lean = lift * (1 - 0.7f * s) + 0.05f / length * ripple + wave;
            p = v3_mad(p, v3_make(0, -1, 0), length / ALONG * cosf(lean));
            p = v3_mad(p, out, length / ALONG * sinf(lean));
            ex_build_vertex(b, v3_mad(p, side, 0.012f * cosf(turn) * s), v3_make(0, 0, 0));
        }
        for (uint32_t j = 0; i > 0 && j < ALONG; j++) {
            uint32_t a = j ? previous[1] + j - 1 : previous[0], c = j ? first + j - 1 : seam;
            ex_build_triangle(b, a, previous[1] + j, first + j, material);
            ex_build_triangle(b, a, first + j, c, material);
        }
        previous[0] = seam;
        previous[1] = first;
    }
}

/* ---- the scene: a washing line ---- */

typedef struct wash { float x0, x1, z, length, folds, wind, phase; uint32_t along; float layers[4][3]; } wash;
/* layers: share of the way down where it is sewn on, length, lift */

static const float line_height = 2.0f;
static const wash washing[] = {
    {-1.78f, -0.42f, 0.34f, 1.40f, 4, 0.55f, 0.4f, 112, {{0, 0, 0}}},
    {-0.18f, 0.50f, 0.34f, 0.82f, 2, 0.45f, 2.6f, 64, {{0, 0.70f, -0.35f}}},
    {0.78f, 1.72f, 0.34f, 1.22f, 5, 0.50f, 4.1f, 96, {{0.34f, 0.24f, 0.7f},
     {0.60f, 0.24f, 0.7f}, {0.86f, 0.24f, 0.7f}}},
    {-1.30f, 0.62f, -0.34f, 1.58f, 6, 0.50f, 5.3f, 120, {{0, 0, 0}}},
    {0.95f, 1.40f, -0.34f, 0.62f, 2, 0.60f, 1.2f, 48, {{0.98f, 0.10f, 0.2f}}}};
enum { WASHING = sizeof washing / sizeof *washing, LINE_PEGS = 3 };

int ex_pose_cloth(ex_scene *scene, float time)
{
    for (uint32_t i = 0; i < WASHING; i++) {                 /* its meshes and materials are the scene's first */
        const wash *w = &washing[i];
        uint32_t across = (uint32_t)(80 * (w->x1 - w->x0)), seam;
        ex_builder b = ex_build_begin(scene);
        ex_drape d = {v3_make(w->x0, line_height, w->z), v3_make(w->x1, line_height, w->z), w->length, 0.03f, w->folds,
                      w->wind, w->phase};
        ex_build_drape(&b, &d, time, across, w->along, i);
        for (int k = 0; k < 4; k++) {
            seam = (uint32_t)(w->layers[k][0] * (float)w->along);
            if (w->layers[k][1] > 0)
                add_layer(&b, &d, 0, across, w->along, seam, w->layers[k][1], w->layers[k][2], time, i);
        }
        if (ex_build_replace(&b, i) != 0) return -1;
    }
    return 0;
}

static void add_posts(ex_builder *b, uint32_t wood, uint32_t rope)
{
    ex_build_block(b, v3_make(-0.05f, 0, -0.05f), v3_make(0.05f, 2.15f, 0.05f), 0.008f, wood);
    ex_build_block(b, v3_make(-0.035f, 1.96f, -0.42f), v3_make(0.035f, 2.03f, 0.42f), 0.006f, wood);
    uint32_t mesh = ex_build_finish(b);
    for (int side = -1; side <= 1; side += 2) {
        ex_object *object = ex_build_object(b, "post", mesh);
        if (object) object->transform[12] = 2.05f * (float)side;
    }
    for (int side = -1; side <= 1; side += 2) {
        v3 path[4];
        float radii[4] = {0.006f, 0.006f, 0.006f, 0.006f};
        const float x[4] = {-2.06f, -2.05f, 2.05f, 2.06f};
        for (int i = 0; i < 4; i++) path[i] = v3_make(x[i], line_height + 0.004f, 0.34f * (float)side);
        ex_build_tube(b, path, radii, 4, 10, rope);
    }
    ex_build_object(b, "lines", ex_build_finish(b));
}

static void add_pegs(ex_builder *b, uint32_t wood)
{
    ex_build_block(b, v3_make(-0.008f, -0.045f, -0.016f), v3_make(0.008f, 0.04f, 0.016f), 0.003f, wood);
    uint32_t mesh = ex_build_finish(b);
    for (int i = 0; i < WASHING; i++)
        for (int k = 0; k < LINE_PEGS; k++) {
            ex_object *object = ex_build_object(b, "peg", mesh);
            float s = 0.06f + 0.88f * (float)k / (LINE_PEGS - 1);
            if (!object) return;
            v3_store(object->transform + 12, v3_make(ex_mix(washing[i].x0, washing[i].x1, s), line_height,
                                                     washing[i].z));
        }
}

static void add_basket(ex_builder *b, uint32_t wicker)
{
    float profile[40][2];
    uint32_t points = 0;
    profile[points][0] = 0;
    profile[points++][1] = 0;
    for (int i = 0; i <= 24; i++) {                          /* woven rings outside */
        float s = (float)i / 24;
        profile[points][0] = 0.22f + 0.07f * s + (i % 2 ? 0.010f : 0);
        profile[points++][1] = 0.30f * s;
    }
    static const float inside[][2] = {{0.30f, 0.315f}, {0.285f, 0.325f}, {0.27f, 0.315f}, {0.20f, 0.03f}, {0, 0.02f}};
    for (size_t i = 0; i < sizeof inside / sizeof *inside; i++, points++) {
        profile[points][0] = inside[i][0];
        profile[points][1] = inside[i][1];
    }
    ex_build_lathe(b, profile[0], points, 72, 1.2f, wicker);
    ex_object *object = ex_build_object(b, "basket", ex_build_finish(b));
    if (object) ex_place(object->transform, v3_make(1.25f, 0, 0.95f), 0, 1);
}

void ex_build_cloth(ex_builder *b)
{
    static const float dye[WASHING][3] = {{0.78f, 0.76f, 0.72f}, {0.58f, 0.10f, 0.08f}, {0.30f, 0.44f, 0.62f},
        {0.76f, 0.60f, 0.28f}, {0.24f, 0.40f, 0.26f}};
    for (int i = 0; i < WASHING; i++) {
        uint32_t cloth = ex_build_material(b, dye[i][0], dye[i][1], dye[i][2]);
        if (!b->failed) b->scene->materials[cloth].double_sided = 1;
    }
    uint32_t wood = ex_build_material(b, 0.36f, 0.24f, 0.14f), rope = ex_build_material(b, 0.60f, 0.55f, 0.45f);
    uint32_t wicker = ex_build_material(b, 0.52f, 0.36f, 0.18f);
    for (int i = 0; i < WASHING; i++) ex_build_object(b, "cloth", ex_build_finish(b));
    add_posts(b, wood, rope);
    add_pegs(b, wicker);
    add_basket(b, wicker);
    if (b->failed || ex_scene_add_ground(b->scene) != 0) { b->failed = 1; return; }
    ex_build_camera(b, v3_make(1.9f, 1.75f, 5.3f), v3_make(0.0f, 1.02f, 0), 35);
}
