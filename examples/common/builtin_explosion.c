/* builtin_explosion.c - a video as a lamp: a ball of fire whose picture changes from frame to frame, between crates,
   barrels and pillars, and pieces that fly out of it. The picture is one of eight colours for each of the ball's
   triangles, the eight last materials here; the ball also grows and rises. Metres; a blast takes 2.4 seconds. */
#include "internal.h"

enum { FIRE, CHUNKS = 9, LEVELS = 8, BALL_SIDES = 40, CRATE = 0, BAND, RUST, STONE, GROUND, FIRST_LEVEL };

static const float period = 2.4f;
static const v3 blast = {0, 0.75f, 0};

/* Embers to white heat, W/(sr m^2). The first is smoke. */
static const float heat[LEVELS][3] = {{0, 0, 0}, {0.6f, 0.10f, 0.01f}, {2.2f, 0.50f, 0.05f}, {6, 1.8f, 0.25f},
    {13, 5, 0.9f}, {24, 12, 3}, {40, 25, 9}, {62, 48, 24}};

static float moment(float time)                          /* 0..1 through the blast; time 0 is well into it */
{
    float t = time / period + 0.20f;
    return t - floorf(t);
}

static v3 fire_point(const void *context, float u, float v)
{
    float theta = EX_PI * v, phi = -2 * EX_PI * u;
    v3 d = v3_make(sinf(theta) * cosf(phi), -cosf(theta), sinf(theta) * sinf(phi));
    float lumps = 0.10f * sinf(5 * d.x + 3 * d.y) * sinf(4 * d.z - 2);
    (void)context;
    return v3_scale(d, 1 + lumps + 0.05f * sinf(11 * d.y + 7 * d.x) * sinf(9 * d.z));
}

/* How hot a place of the ball is: cells that roll upwards, all cooling down. */
static float heat_at(v3 d, float time)
{
    float t = moment(time), x = d.x, y = d.y - 1.6f * t, z = d.z, sum = 0, gain = 1;
    for (int octave = 0; octave < 3; octave++) {
        float k = 2.6f * powf(1.9f, (float)octave), w = 2.5f * t * (1 + (float)octave);
        sum += gain * sinf(k * x + 1.3f * sinf(k * z + w) + 0.7f) * sinf(k * y + 1.1f * sinf(k * x - w)) *
               cosf(k * z + 0.9f * sinf(k * y + 2));
        gain *= 0.6f;
    }
    return 7.6f * expf(-1.5f * t) + 2.6f * sum * (0.4f + 1.2f * t) - 1.6f * t;
}

static void pose_fire(ex_scene *scene, float time)
{
    ex_mesh *mesh = &scene->meshes[FIRE];
    float t = moment(time);
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        v3 sum = v3_make(0, 0, 0);
        for (size_t k = 0; k < 3; k++)
            sum = v3_add(sum, v3_load(mesh->positions + 3 * (size_t)mesh->indices[3 * i + k]));
        mesh->materials[i] = FIRST_LEVEL + (uint32_t)ex_clamp(heat_at(v3_unit(sum), time), 0, LEVELS - 1);
    }
    float size = 0.16f + 0.62f * (1 - expf(-5 * t));
    ex_place(scene->objects[FIRE].transform, v3_add(blast, v3_make(0, 0.9f * t, 0)), 0.4f * t, size);
}

/* Pieces are thrown out, turn over, and fall to the ground, where they lie until the next blast. */
static void pose_chunk(ex_object *object, int number, float time)
{
    float t = moment(time) * period, angle = 2.399963f * (float)number, rise = 3.0f + 0.45f * (float)(number % 4);
    float land = (rise + sqrtf(rise * rise + 19.62f * (blast.y - 0.06f))) / 9.81f, fly = fminf(t, land);
    float out = 0.55f + (1.1f + 0.28f * (float)(number % 5)) * fly, spin = (2 + (float)(number % 3)) * fly;
    float c = cosf(spin), s = sinf(spin), tilt[16] = {1, 0, 0, 0, 0, c, s, 0, 0, -s, c, 0, 0, 0, 0, 1}, m[16];
    float y = blast.y + rise * fly - 4.905f * fly * fly;
    v3 at = v3_make(out * cosf(angle), fmaxf(y, 0.06f), out * sinf(angle));
    ex_place(m, at, angle, 0.55f + 0.1f * (float)(number % 6));
    ex_multiply(object->transform, m, tilt);
}

int ex_pose_explosion(ex_scene *scene, float time)
{
    pose_fire(scene, time);
    for (int i = 0; i < CHUNKS; i++) pose_chunk(&scene->objects[1 + i], i, time);
    return 0;
}

/* ---- what stands there ---- */

static uint32_t build_crate(ex_builder *b)
{
    ex_build_block(b, v3_make(-0.30f, 0.02f, -0.30f), v3_make(0.30f, 0.62f, 0.30f), 0.005f, CRATE);
    ex_mark mark = ex_build_mark(b);
    ex_build_block(b, v3_make(-0.32f, 0, 0.28f), v3_make(0.32f, 0.08f, 0.325f), 0.008f, BAND);
    ex_build_block(b, v3_make(-0.32f, 0.56f, 0.28f), v3_make(0.32f, 0.64f, 0.325f), 0.008f, BAND);
    ex_build_block(b, v3_make(-0.325f, 0.07f, 0.285f), v3_make(-0.25f, 0.57f, 0.33f), 0.008f, BAND);
    ex_build_block(b, v3_make(0.25f, 0.07f, 0.285f), v3_make(0.325f, 0.57f, 0.33f), 0.008f, BAND);
    ex_build_block(b, v3_make(-0.05f, 0.07f, 0.29f), v3_make(0.05f, 0.57f, 0.315f), 0.006f, BAND);
    ex_build_ring(b, mark, 4);
    return ex_build_finish(b);
}

static uint32_t build_barrel(ex_builder *b)
{
    static const float profile[][2] = {{0, 0.02f}, {0.26f, 0.02f}, {0.27f, 0}, {0.285f, 0}, {0.29f, 0.02f},
        {0.28f, 0.04f}, {0.28f, 0.26f}, {0.295f, 0.275f}, {0.295f, 0.295f}, {0.28f, 0.31f}, {0.28f, 0.53f},
        {0.295f, 0.545f}, {0.295f, 0.565f}, {0.28f, 0.58f}, {0.28f, 0.80f}, {0.29f, 0.82f}, {0.285f, 0.84f},
        {0.27f, 0.84f}, {0.26f, 0.815f}, {0, 0.815f}};
    ex_build_lathe(b, profile[0], sizeof profile / sizeof *profile, 48, 0.5f, RUST);
    return ex_build_finish(b);
}

static uint32_t build_pillar(ex_builder *b)
{
    static const float shaft[][2] = {{0, 0.20f}, {0.27f, 0.20f}, {0.28f, 0.24f}, {0.25f, 0.28f}, {0.225f, 0.33f},
        {0.21f, 1.2f}, {0.19f, 2.1f}, {0.22f, 2.16f}, {0.26f, 2.22f}, {0.26f, 2.27f}, {0, 2.27f}};
    ex_build_block(b, v3_make(-0.32f, 0, -0.32f), v3_make(0.32f, 0.20f, 0.32f), 0.02f, STONE);
    ex_build_lathe(b, shaft[0], sizeof shaft / sizeof *shaft, 40, 0.5f, STONE);
    ex_build_block(b, v3_make(-0.30f, 2.27f, -0.30f), v3_make(0.30f, 2.40f, 0.30f), 0.02f, STONE);
    return ex_build_finish(b);
}

static uint32_t build_chunk(ex_builder *b)
{
    static const float outline[][2] = {{-0.14f, -0.08f}, {0.02f, -0.13f}, {0.15f, -0.05f}, {0.11f, 0.09f},
        {-0.04f, 0.13f}};
    ex_build_prism(b, outline, 5, -0.07f, 0.08f, 0.03f, STONE);
    return ex_build_finish(b);
}

typedef struct stand { float x, y, z, yaw; } stand;

static void place_all(ex_builder *b, const char *name, uint32_t mesh, const stand *stands, int count)
{
    for (int i = 0; i < count; i++) {
        ex_object *object = ex_build_object(b, name, mesh);
        if (object) ex_place(object->transform, v3_make(stands[i].x, stands[i].y, stands[i].z), stands[i].yaw, 1);
    }
}

void ex_build_explosion(ex_builder *b)
{
    static const float colors[][3] = {{0.50f, 0.35f, 0.20f}, {0.34f, 0.22f, 0.12f}, {0.42f, 0.16f, 0.10f},
        {0.62f, 0.60f, 0.56f}, {0.44f, 0.42f, 0.39f}};
    static const stand crates[] = {{-1.75f, 0, 0.55f, 0.3f}, {-1.70f, 0.645f, 0.50f, 0.75f}, {-2.45f, 0, 0.15f, 1.1f},
        {1.35f, 0, 1.35f, 0.55f}, {2.65f, 0, -1.0f, 0.2f}};
    static const stand barrels[] = {{1.85f, 0, -0.15f, 0}, {2.10f, 0, 0.55f, 1}, {-0.75f, 0, 1.75f, 2},
        {-1.05f, 0, -1.45f, 0}};
    static const stand pillars[] = {{-2.6f, 0, -2.2f, 0}, {0.2f, 0, -2.5f, 0}, {2.9f, 0, -2.3f, 0}};
    for (int i = 0; i < FIRST_LEVEL; i++) ex_build_material(b, colors[i][0], colors[i][1], colors[i][2]);
    for (int i = 0; i < LEVELS; i++) {
        uint32_t level = ex_build_material(b, 0.10f, 0.08f, 0.07f);
        if (!b->failed) v3_store(b->scene->materials[level].emission, v3_load(heat[i]));
    }
    ex_build_surface(b, fire_point, NULL, BALL_SIDES, BALL_SIDES / 2, EX_WRAP | EX_TIP_LOW | EX_TIP_HIGH, FIRST_LEVEL);
    uint32_t fire = ex_build_finish(b);
    if (!b->failed) b->scene->meshes[fire].deforms = 1;
    ex_build_object(b, "fire", fire);
    uint32_t chunk = build_chunk(b);
    for (int i = 0; i < CHUNKS; i++) ex_build_object(b, "piece", chunk);
    place_all(b, "crate", build_crate(b), crates, sizeof crates / sizeof *crates);
    place_all(b, "barrel", build_barrel(b), barrels, sizeof barrels / sizeof *barrels);
    place_all(b, "pillar", build_pillar(b), pillars, sizeof pillars / sizeof *pillars);
    ex_build_panel(b, v3_make(-12, 0, 12), v3_make(24, 0, 0), v3_make(0, 0, -24), 96, 96, GROUND);
    ex_object *ground = ex_build_object(b, "ground", ex_build_finish(b));
    if (ground) ground->receiver_only = 1;
    ex_build_camera(b, v3_make(1.7f, 2.9f, 6.2f), v3_make(0, 0.75f, 0), 42);
}
