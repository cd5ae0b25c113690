/* builtin_robots.c - three walking machines of one body and one leg, in three sizes, on a deck. Each carries a spot
   light and fires bullets that shine. All parts are rigid. With two ships above them: the scene spaceships. Metres. */
#include "internal.h"

enum { ROBOTS = 3, PARTS = 3 * ROBOTS, SHIPS = 2, STEEL = 0, PAINT, DARK, GLASS, GLOW };

static const float leg_length = 1.40f, foot_front = 0.34f, foot_back = -0.24f, hip = 0.36f;
static const v3 lamp_at = {0, 0.34f, 0.93f}, muzzle = {0.74f, 0.55f, 1.08f};

/* ---- matrices ---- */

static void turn_x(float m[16], float angle)             /* by the right-hand rule: +Y goes towards +Z */
{
    ex_identity(m);
    m[5] = m[10] = cosf(angle);
    m[6] = sinf(angle);
    m[9] = -m[6];
}

static void add_turned(ex_builder *b, ex_mark since, float pitch, v3 position)
{
    float m[16];
    turn_x(m, pitch);
    v3_store(m + 12, position);
    ex_build_transform(b, since, m);
}

/* A turned part, from a lathe's +Y to +Z. */
static void add_barrel(ex_builder *b, const float (*profile)[2], uint32_t points, v3 position, uint32_t material)
{
    ex_mark mark = ex_build_mark(b);
    ex_build_lathe(b, profile[0], points, 28, 0.6f, material);
    add_turned(b, mark, EX_PI / 2, position);
}

/* ---- parts ---- */

/* The hull is its side view pushed out sideways: x, y of the outline are z, y here. */
static void add_plate(ex_builder *b, const float (*outline)[2], uint32_t points, float from, float to, float bevel,
                      uint32_t material)
{
    static const float sideways[16] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1};
    ex_mark mark = ex_build_mark(b);
    ex_build_prism(b, outline, points, from, to, bevel, material);
    ex_build_transform(b, mark, sideways);
}

static uint32_t build_body(ex_builder *b)
{
    static const float hull[][2] = {{-0.70f, 0.22f}, {0.50f, 0.16f}, {0.86f, 0.42f}, {0.84f, 0.66f}, {0.40f, 1.00f},
        {-0.46f, 1.04f}, {-0.78f, 0.74f}};
    static const float cheek[][2] = {{-0.50f, 0.32f}, {0.36f, 0.28f}, {0.62f, 0.48f}, {0.30f, 0.80f}, {-0.40f, 0.86f}};
    static const float window[][2] = {{0.50f, 0.945f}, {0.46f, 0.90f}, {0.78f, 0.64f}, {0.845f, 0.68f}};
    static const float gun[][2] = {{0, -0.42f}, {0.13f, -0.42f}, {0.16f, -0.36f}, {0.16f, 0.22f}, {0.11f, 0.30f},
        {0.075f, 0.34f}, {0.07f, 0.40f}, {0.07f, 0.86f}, {0.09f, 0.88f}, {0.09f, 1.0f}, {0.06f, 1.0f}, {0.05f, 0.9f},
        {0, 0.9f}};
    static const float lamp[][2] = {{0, -0.10f}, {0.10f, -0.10f}, {0.12f, 0}, {0.135f, 0.05f}, {0.12f, 0.06f},
        {0.10f, 0.02f}, {0, 0.01f}};
    static const float turret[][2] = {{0, 0.98f}, {0.34f, 0.98f}, {0.36f, 1.04f}, {0.33f, 1.10f}, {0.26f, 1.13f},
        {0.25f, 1.22f}, {0.20f, 1.28f}, {0, 1.30f}};
    static const float disc[][2] = {{0, -0.09f}, {0.16f, -0.09f}, {0.18f, -0.07f}, {0.18f, 0.07f}, {0.16f, 0.09f},
        {0.06f, 0.09f}, {0.05f, 0.11f}, {0, 0.11f}};
    const uint32_t sides[2] = {5, 4};
    ex_build_block(b, v3_make(-0.28f, -0.14f, -0.22f), v3_make(0.28f, 0.24f, 0.22f), 0.03f, STEEL);
    add_plate(b, hull, 7, -0.42f, 0.42f, 0.05f, PAINT);
    add_plate(b, cheek, sides[0], 0.38f, 0.54f, 0.04f, STEEL);
    add_plate(b, cheek, sides[0], -0.54f, -0.38f, 0.04f, STEEL);
    add_plate(b, window, sides[1], -0.30f, 0.30f, 0.01f, GLASS);
    ex_build_lathe(b, turret[0], sizeof turret / sizeof *turret, 32, 0.5f, STEEL);
    ex_build_ball(b, v3_make(0, 1.24f, 0.16f), v3_make(0.06f, 0.05f, 0.10f), 20, GLASS);
    for (int s = -1; s <= 1; s += 2) {
        float x = (float)s, m[16] = {0, -x, 0, 0, x, 0, 0, 0, 0, 0, 1, 0, 0.30f * x, 0, 0, 1};
        add_barrel(b, gun, sizeof gun / sizeof *gun, v3_make(0.74f * x, 0.55f, 0.08f), DARK);
        ex_build_block(b, v3_make(0.64f * x - 0.12f, 0.46f, -0.14f), v3_make(0.64f * x + 0.12f, 0.64f, 0.14f), 0.02f,
                       STEEL);
        ex_mark mark = ex_build_mark(b);
        ex_build_lathe(b, disc[0], sizeof disc / sizeof *disc, 28, 0.5f, DARK);
        ex_build_transform(b, mark, m);                  /* the axis turned outwards */
        for (int k = 0; k < 4; k++)                      /* cooling fins behind */
            ex_build_block(b, v3_make(0.22f * x - 0.13f, 0.42f + 0.12f * (float)k, -0.86f),
                           v3_make(0.22f * x + 0.13f, 0.49f + 0.12f * (float)k, -0.66f), 0.012f, DARK);
        const v3 path[4] = {{0.30f * x, 1.00f, -0.40f}, {0.30f * x, 1.01f, -0.40f}, {0.34f * x, 1.60f, -0.52f},
                      {0.34f * x, 1.61f, -0.52f}};
        const float radii[4] = {0.02f, 0.02f, 0.008f, 0.008f};
        ex_build_tube(b, path, radii, 4, 10, DARK);
    }
    add_barrel(b, lamp, sizeof lamp / sizeof *lamp, v3_make(0, 0.34f, 0.84f), STEEL);
    return ex_build_finish(b);
}

static uint32_t build_leg(ex_builder *b)
{
    static const float knee[][2] = {{0, -0.13f}, {0.10f, -0.13f}, {0.13f, -0.10f}, {0.13f, 0.10f}, {0.10f, 0.13f},
        {0, 0.13f}};
    static const float sideways[16] = {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const v3 bend = {0, -0.52f, 0.30f}, ankle = {0, -1.20f, -0.02f};
    float m[16];
    ex_mark mark = ex_build_mark(b);
    ex_build_block(b, v3_make(-0.10f, -0.62f, -0.14f), v3_make(0.10f, 0.10f, 0.14f), 0.03f, PAINT);
    ex_build_block(b, v3_make(-0.12f, -0.40f, -0.10f), v3_make(0.12f, -0.10f, 0.17f), 0.03f, STEEL);
    add_turned(b, mark, -atan2f(bend.z, -bend.y), v3_make(0, 0, 0));
    mark = ex_build_mark(b);
    ex_build_block(b, v3_make(-0.08f, -0.78f, -0.09f), v3_make(0.08f, 0.06f, 0.09f), 0.02f, STEEL);
    ex_build_block(b, v3_make(-0.095f, -0.55f, -0.02f), v3_make(0.095f, -0.08f, 0.13f), 0.03f, PAINT);
    ex_build_block(b, v3_make(-0.03f, -0.70f, -0.15f), v3_make(0.03f, -0.15f, -0.08f), 0.015f, DARK);
    add_turned(b, mark, atan2f(bend.z - ankle.z, bend.y - ankle.y), bend);
    for (int k = 0; k < 2; k++) {                        /* knee and ankle joints */
        v3 at = k ? ankle : bend;
        mark = ex_build_mark(b);
        ex_build_lathe(b, knee[0], sizeof knee / sizeof *knee, 24, 0.5f, DARK);
        ex_build_transform(b, mark, sideways);
        ex_identity(m);
        m[0] = m[5] = m[10] = k ? 0.8f : 1;
        v3_store(m + 12, at);
        ex_build_transform(b, mark, m);
    }
    ex_build_block(b, v3_make(-0.16f, -leg_length, foot_back), v3_make(0.16f, -1.26f, 0.16f), 0.03f, STEEL);
    for (int k = -1; k <= 1; k += 2)
        ex_build_block(b, v3_make(0.09f * (float)k - 0.065f, -leg_length, 0.10f),
                       v3_make(0.09f * (float)k + 0.065f, -1.30f, foot_front), 0.02f, DARK);
    return ex_build_finish(b);
}

static uint32_t build_bullet(ex_builder *b)
{
    ex_build_ball(b, v3_make(0, 0, 0), v3_make(0.06f, 0.06f, 0.06f), 12, GLOW);
    return ex_build_finish(b);
}

static void add_materials(ex_builder *b)
{
    static const float colors[5][3] = {{0.42f, 0.44f, 0.47f}, {0.62f, 0.30f, 0.12f}, {0.13f, 0.13f, 0.15f},
        {0.06f, 0.12f, 0.16f}, {0.50f, 0.40f, 0.25f}};
    for (int i = 0; i < 5; i++) ex_build_material(b, colors[i][0], colors[i][1], colors[i][2]);
}

static void add_robots(ex_builder *b)
{
    static const char *const names[3] = {"body", "left leg", "right leg"};
    uint32_t body = build_body(b), leg = build_leg(b);
    for (int i = 0; i < PARTS; i++) ex_build_object(b, names[i % 3], i % 3 ? leg : body);
}

/* The deck has the vertices that shading by vertex needs. */
static void add_deck(ex_builder *b, uint32_t across, uint32_t along)
{
    uint32_t deck = ex_build_material(b, 0.46f, 0.46f, 0.44f);
    ex_build_panel(b, v3_make(-10, 0, 7), v3_make(20, 0, 0), v3_make(0, 0, -14), across, along, deck);
    ex_object *object = ex_build_object(b, "deck", ex_build_finish(b));
    if (object) object->receiver_only = 1;
}

/* ---- motion ---- */

typedef struct gait { float x, z, radius, start, speed, scale; } gait;   /* walks round a circle, facing along it */
static const gait gaits[ROBOTS] = {{-2.4f, 1.5f, 1.5f, -1.35f, 0.46f, 1.0f}, {2.2f, 0.7f, 1.3f, -1.95f, -0.42f, 0.82f},
    {1.25f, 1.7f, 0.9f, 2.3f, 0.50f, 0.62f}};

/* Matrix of the body, and by how much its left leg swings forwards. */
static float body_at(int robot, float time, float m[16])
{
    const gait *g = &gaits[robot];
    float angle = g->start + g->speed * time, c = cosf(angle), s = sinf(angle), way = g->speed > 0 ? 1.0f : -1.0f;
    float stride = 0.42f, pace = 2 * EX_PI * fabsf(g->speed) * g->radius / (4 * leg_length * g->scale * sinf(stride));
    float swing = stride * sinf(pace * time + 0.9f + 2.1f * (float)robot), reach = 0;
    for (int side = -1; side <= 1; side += 2)            /* as high as the longer leg asks for */
        for (int end = 0; end < 2; end++)
            reach = fmaxf(reach, leg_length * cosf(swing) + (float)side * (end ? foot_front : foot_back) * sinf(swing));
    v3 at = v3_make(g->x + g->radius * c, g->scale * reach, g->z + g->radius * s);
    ex_place(m, at, atan2f(-way * s, way * c), g->scale);
    return swing;
}

static void pose_robots(ex_object *objects, float time)
{
    for (int i = 0; i < ROBOTS; i++) {
        float body[16], leg[16];
        float swing = body_at(i, time, body);
        for (int k = 0; k < 16; k++) objects[3 * i].transform[k] = body[k];
        for (int side = 0; side < 2; side++) {
            turn_x(leg, side ? swing : -swing);
            leg[12] = side ? -hip : hip;
            ex_multiply(objects[3 * i + 1 + side].transform, body, leg);
        }
    }
}

/* A bullet flies straight on from where the muzzle was when it was fired. */
static v3 bullet_at(int robot, float time)
{
    const float period = 1.0f, speed = 4.5f;
    float m[16], since = time / period + 0.37f * (float)robot + 0.25f;
    since = (since - floorf(since)) * period;
    body_at(robot, time - since, m);
    v3 forwards = v3_unit(ex_transform_vector(m, v3_make(0, -0.04f, 1)));
    return v3_mad(ex_transform_point(m, v3_add(muzzle, v3_make(0, 0, 0.1f))), forwards, speed * since);
}

int ex_pose_robots(ex_scene *scene, float time)
{
    pose_robots(scene->objects, time);
    for (int i = 0; i < ROBOTS; i++) {
        float *body = scene->objects[3 * i].transform;
        ex_light *lamp = &scene->lights[i];
        v3_store(scene->objects[PARTS + i].transform + 12, bullet_at(i, time));
        v3_store(lamp->position, ex_transform_point(body, lamp_at));
        v3_store(lamp->direction, v3_unit(ex_transform_vector(body, v3_make(0, -0.26f, 1))));
    }
    return 0;
}

void ex_build_robots(ex_builder *b)
{
    add_materials(b);
    add_robots(b);
    uint32_t bullet = build_bullet(b);
    for (int i = 0; i < ROBOTS; i++) ex_build_object(b, "bullet", bullet);
    add_deck(b, 80, 56);
    for (int i = 0; i < ROBOTS; i++) {
        ex_light *lamp = ex_build_light(b, EX_LIGHT_SPOT);
        if (!lamp) return;
        lamp->cos_half_angle = cosf(32 * EX_PI / 180);
        v3_store(lamp->value, v3_scale(v3_make(30, 28, 25), gaits[i].scale));
    }
    v3_store(b->scene->materials[GLOW].emission, v3_make(420, 260, 90));
    ex_build_camera(b, v3_make(0.6f, 4.0f, 8.4f), v3_make(0.1f, 0.75f, 0), 40);
}

/* ---- ships ---- */

/* A flattened hull: u round it, v from the tail to the nose along +Z. */
static v3 hull_point(const void *context, float u, float v)
{
    float a = 2 * EX_PI * u, z = 4.4f * v - 2.0f, c = cosf(a), s = sinf(a);
    float body = powf(ex_clamp(v * 6, 0, 1), 0.35f) * powf(ex_clamp((1 - v) * 1.25f, 0, 1), 0.55f);
    float wide = 0.66f * body, high = 0.34f * body * (s < 0 ? 0.75f : 1);
    float across = copysignf(powf(fabsf(c), 0.8f), c), up = copysignf(powf(fabsf(s), 0.8f), s);
    float groove = 1 - 0.03f * ex_smooth(0.85f, 1, fabsf(sinf(16 * EX_PI * v))) * ex_smooth(0.1f, 0.3f, v);
    (void)context;
    if (v <= 0 || v >= 1) return v3_make(0, 0, z);
    return v3_make(wide * groove * across, high * groove * up, z);
}

static uint32_t build_ship(ex_builder *b)
{
    static const float wing[][2] = {{0.30f, -0.95f}, {2.05f, -1.45f}, {2.25f, -1.25f}, {2.15f, -0.55f}, {0.50f, 0.75f}};
    static const float fin[][2] = {{-1.95f, 0.20f}, {-0.70f, 0.24f}, {-1.30f, 0.95f}, {-1.85f, 1.05f}};
    static const float engine[][2] = {{0, -0.70f}, {0.10f, -0.68f}, {0.17f, -0.80f}, {0.21f, -0.78f}, {0.24f, -0.5f},
        {0.26f, -0.1f}, {0.25f, 0.4f}, {0.19f, 0.62f}, {0.13f, 0.70f}, {0.10f, 0.60f}, {0, 0.56f}};
    static const float gun[][2] = {{0, -0.3f}, {0.06f, -0.3f}, {0.06f, 0.3f}, {0.03f, 0.34f}, {0.025f, 0.95f},
        {0, 0.95f}};
    static const float flat[16] = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1};     /* x, y of a drawing to x, z */
    ex_build_surface(b, hull_point, NULL, 64, 72, EX_WRAP | EX_TIP_LOW | EX_TIP_HIGH, PAINT);
    ex_build_ball(b, v3_make(0, 0.24f, 0.75f), v3_make(0.24f, 0.20f, 0.55f), 40, GLASS);
    for (int side = 0; side < 2; side++) {
        float x = side ? -1.0f : 1.0f, mirror[16] = {x, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
        ex_mark mark = ex_build_mark(b);
        ex_build_prism(b, wing, 5, -0.055f, 0.055f, 0.03f, STEEL);
        ex_build_transform(b, mark, flat);
        add_barrel(b, engine, sizeof engine / sizeof *engine, v3_make(0.72f, -0.02f, -1.25f), DARK);
        add_barrel(b, gun, sizeof gun / sizeof *gun, v3_make(2.14f, 0, -0.75f), DARK);
        add_barrel(b, engine, sizeof engine / sizeof *engine, v3_make(1.25f, -0.24f, -0.85f), DARK);
        ex_build_transform(b, mark, mirror);
    }
    add_plate(b, fin, 4, -0.04f, 0.04f, 0.02f, STEEL);
    ex_build_block(b, v3_make(-0.16f, -0.40f, -1.0f), v3_make(0.16f, -0.18f, 0.5f), 0.03f, DARK);
    return ex_build_finish(b);
}

/* The robots stand; the ships drift without turning, as sources and occluders in wavelets may not turn. */
int ex_pose_spaceships(ex_scene *scene, float time)
{
    static const float scales[SHIPS] = {1, 0.72f};
    pose_robots(scene->objects, 0);
    for (int i = 0; i < SHIPS; i++) {
        float t = 0.5f * time + 2.4f * (float)i;
        v3 at = i ? v3_make(1.5f + 1.0f * cosf(t), 3.5f + 0.25f * sinf(1.3f * t), 1.0f + 1.0f * sinf(t))
                  : v3_make(-2.3f + 1.3f * sinf(t), 4.0f + 0.2f * cosf(1.1f * t), 0.2f + 1.2f * cosf(t));
        ex_place(scene->objects[PARTS + i].transform, at, i ? 2.6f : 0.7f, scales[i]);
    }
    return 0;
}

void ex_build_spaceships(ex_builder *b)
{
    add_materials(b);
    add_robots(b);
    uint32_t ship = build_ship(b);
    for (int i = 0; i < SHIPS; i++) ex_build_object(b, i ? "small ship" : "ship", ship);
    add_deck(b, 234, 157);
    ex_build_camera(b, v3_make(0.8f, 5.2f, 10.8f), v3_make(-0.1f, 2.0f, 0), 40);
}
