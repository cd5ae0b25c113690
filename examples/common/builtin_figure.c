/* builtin_figure.c - a woman in a long dress, standing, 107,000 triangles. She shifts her weight, looks about and lifts
   a hand; the skirt follows. Everything is made anew for each time by sweeping sections along curves. Metres
       faces +Z. */
#include "internal.h"

enum { BODY, DRESS, MATERIAL_SKIN = 0, MATERIAL_HAIR, MATERIAL_DRESS, MATERIAL_TRIM, MATERIAL_SHOE };

static const int closed = EX_WRAP | EX_TIP_LOW | EX_TIP_HIGH;

typedef struct pose {
    float time, sway, turn, lift;    /* weight to one side; of the head; of the right arm */
    v3    hip, chest, neck, head;
} pose;

static pose pose_at(float time)
{
    pose p;
    p.time = time;
    p.sway = sinf(1.3f * time);
    p.turn = 0.12f + 0.38f * sinf(0.8f * time);
    p.lift = 0.5f - 0.5f * cosf(1.1f * time);
    p.hip = v3_make(0.030f + 0.028f * p.sway, 1.0f, 0);
    p.chest = v3_make(0.010f - 0.012f * p.sway, 1.30f + 0.004f * sinf(2.1f * time), 0.005f);
    p.neck = v3_make(-0.002f - 0.006f * p.sway, 1.47f, -0.012f);
    p.head = v3_make(-0.004f - 0.002f * p.sway, 1.615f, 0.012f);
    return p;
}

/* ---- sweeping a section along a curve ---- */

typedef struct station { v3 at; float wide, deep; } station;         /* half axes, along side and across it */
typedef struct loft { const station *stations; int count; v3 side; float wrinkle; } loft;

static float spline(float a, float b, float c, float d, float t)     /* Catmull-Rom */
{
    return b + 0.5f * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

static station station_at(const loft *l, float v)
{
    float x = ex_clamp(v, 0, 1) * (float)(l->count - 1), t;
    int i = (int)x < l->count - 2 ? (int)x : l->count - 2;
    const station *s[4];
    for (int k = 0; k < 4; k++) {
        int at = i + k - 1;
        s[k] = &l->stations[at < 0 ? 0 : at >= l->count ? l->count - 1 : at];
    }
    t = x - (float)i;
    station r = {{spline(s[0]->at.x, s[1]->at.x, s[2]->at.x, s[3]->at.x, t),
                  spline(s[0]->at.y, s[1]->at.y, s[2]->at.y, s[3]->at.y, t),
                  spline(s[0]->at.z, s[1]->at.z, s[2]->at.z, s[3]->at.z, t)},
                 fmaxf(spline(s[0]->wide, s[1]->wide, s[2]->wide, s[3]->wide, t), 0),
                 fmaxf(spline(s[0]->deep, s[1]->deep, s[2]->deep, s[3]->deep, t), 0)};
    return r;
}

static v3 loft_point(const void *context, float u, float v)
{
    const loft *l = (const loft *)context;
    station s = station_at(l, v);
    v3 tangent = v3_unit(v3_sub(station_at(l, v + 0.01f).at, station_at(l, v - 0.01f).at));
    v3 side = v3_unit(v3_mad(l->side, tangent, -v3_dot(l->side, tangent))), front = v3_cross(tangent, side);
    float a = 2 * EX_PI * u, r = 1 + l->wrinkle * sinf(46 * v + 2.5f * sinf(a + 9 * v)) * (0.6f + 0.4f * sinf(2 * a));
    return v3_mad(v3_mad(s.at, side, r * s.wide * cosf(a)), front, r * s.deep * sinf(a));
}

static void add_loft(ex_builder *b, const station *stations, int count, v3 side, float wrinkle, uint32_t around,
                     uint32_t along, int flags, uint32_t material)
{
    loft l = {stations, count, side, wrinkle};
    ex_build_surface(b, loft_point, &l, around, along, flags, material);
}

/* ---- head ---- */

static float bump(float x, float y, float cx, float cy, float width, float height)
{
    float dx = (x - cx) / width, dy = (y - cy) / height;
    return expf(-dx * dx - dy * dy);
}

/* A skull narrowed to the chin; the face is drawn on its front by swellings and hollows. */
static v3 head_shape(v3 d)
{
    v3 p = v3_make(0.074f * d.x, 0.112f * d.y, 0.096f * d.z);
    float low = ex_smooth(0.01f, -0.115f, p.y) , front = ex_smooth(0.05f, 0.6f, d.z);
    p.x *= 1 - 0.36f * low;
    p.z *= d.z > 0 ? 1 - 0.10f * low : 1 - 0.42f * low;
    p.z += 0.010f * low;
    float x = p.x, y = p.y, f = 0;
    f += 0.020f * bump(x, y, 0, -0.030f, 0.011f, 0.014f) + 0.012f * bump(x, y, 0, -0.008f, 0.008f, 0.024f);
    f += 0.005f * bump(x, y, 0, 0.024f, 0.05f, 0.012f);
    f -= 0.011f * (bump(x, y, 0.030f, 0.004f, 0.016f, 0.010f) + bump(x, y, -0.030f, 0.004f, 0.016f, 0.010f));
    f += 0.006f * (bump(x, y, 0.030f, 0.003f, 0.010f, 0.0055f) + bump(x, y, -0.030f, 0.003f, 0.010f, 0.0055f));
    f += 0.004f * (bump(x, y, 0.040f, -0.030f, 0.018f, 0.018f) + bump(x, y, -0.040f, -0.030f, 0.018f, 0.018f));
    f += 0.006f * bump(x, y, 0, -0.056f, 0.020f, 0.0045f) + 0.006f * bump(x, y, 0, -0.066f, 0.017f, 0.005f);
    f -= 0.003f * bump(x, y, 0, -0.061f, 0.022f, 0.002f);
    f += 0.007f * bump(x, y, 0, -0.094f, 0.016f, 0.012f);
    p.z += front * f;
    return p;
}

static v3 ball_direction(float u, float v)
{
    float theta = EX_PI * v, phi = -2 * EX_PI * u;
    return v3_make(sinf(theta) * cosf(phi), -cosf(theta), sinf(theta) * sinf(phi));
}

static v3 turned(const pose *p, v3 q)
{
    float c = cosf(p->turn), s = sinf(p->turn), tilt = 0.05f * p->sway;
    v3 r = v3_make(c * q.x + s * q.z, q.y, c * q.z - s * q.x);
    return v3_add(p->head, v3_make(r.x - tilt * r.y, r.y + tilt * r.x, r.z));
}

static v3 head_point(const void *context, float u, float v)
{
    return turned((const pose *)context, head_shape(ball_direction(u, v)));
}

/* Hair lies on the skull behind a line from the forehead past the temples; in front of it, it is under the skin. */
static v3 hair_point(const void *context, float u, float v)
{
    v3 d = ball_direction(u, v), p = head_shape(d);
    float line = d.z - 0.95f * d.y + 0.22f, grown = ex_smooth(0.10f, -0.14f, line);
    float strands = 0.012f * sinf(38 * (atan2f(d.x, d.y - 0.2f)) + 6 * d.z);
    float scale = 0.90f + grown * (0.225f + strands * ex_smooth(0.3f, -0.2f, line));
    return turned((const pose *)context, v3_scale(p, scale));
}

static void add_head(ex_builder *b, const pose *p)
{
    const station neck[] = {
        {v3_mad(p->chest, v3_make(0, 1, -0.1f), 0.10f), 0.050f, 0.05f},
            {v3_add(p->neck, v3_make(0, -0.03f, 0)), 0.058f, 0.056f},
        {v3_add(p->neck, v3_make(0, 0.02f, 0.002f)), 0.050f, 0.052f},
            {v3_add(p->head, v3_make(0, -0.08f, -0.015f)), 0.047f, 0.052f},
        {v3_add(p->head, v3_make(0, -0.02f, -0.01f)), 0.045f, 0.05f}};
    add_loft(b, neck, 5, v3_make(1, 0, 0), 0, 36, 16, EX_WRAP, MATERIAL_SKIN);
    ex_build_surface(b, head_point, p, 88, 64, closed, MATERIAL_SKIN);
    ex_build_surface(b, hair_point, p, 80, 40, closed, MATERIAL_HAIR);
    v3 bun = turned(p, v3_make(0, 0.030f, -0.128f));
    ex_build_ball(b, bun, v3_make(0.048f, 0.046f, 0.042f), 36, MATERIAL_HAIR);
}

/* ---- arms ---- */

typedef struct arm { v3 shoulder, elbow, wrist, palm; } arm;

static arm arm_at(const pose *p, int right)
{
    float s = right ? -1.0f : 1.0f, lift = right ? p->lift : 0.12f + 0.06f * p->sway, out, fore;
    arm a;
    a.shoulder = v3_add(p->chest, v3_make(0.165f * s, 0.105f + 0.01f * lift, -0.012f));
    out = 0.16f + 0.34f * lift;                              /* of the upper arm, from the body */
    v3 upper = v3_unit(v3_make(s * sinf(out), -cosf(out), -0.10f + 0.35f * lift));
    a.elbow = v3_mad(a.shoulder, upper, 0.285f);
    fore = right ? 0.25f + 1.75f * lift : 0.30f;             /* bend of the elbow, forwards and up */
    v3 lower = v3_unit(v3_make(s * (0.10f - 0.25f * lift * (float)right), -cosf(fore), sinf(fore)));
    a.wrist = v3_mad(a.elbow, lower, 0.245f);
    a.palm = v3_mad(a.wrist, v3_unit(v3_mad(lower, v3_make(0, 0, 1), 0.12f)), 0.075f);
    return a;
}

static void add_hand(ex_builder *b, const arm *a, float s)
{
    v3 along = v3_unit(v3_sub(a->palm, a->wrist)), across = v3_unit(v3_cross(along, v3_make(s, 0.15f, 0.1f)));
    v3 flat = v3_cross(along, across);
    const station palm[] = {{v3_mad(a->wrist, along, -0.03f), 0, 0}, {v3_mad(a->wrist, along, -0.02f), 0.024f, 0.020f},
        {v3_mad(a->wrist, along, 0.01f), 0.026f, 0.017f}, {v3_mad(a->wrist, along, 0.05f), 0.038f, 0.015f},
        {v3_mad(a->wrist, along, 0.085f), 0.037f, 0.012f}, {v3_mad(a->wrist, along, 0.097f), 0, 0}};
    add_loft(b, palm, 6, across, 0, 28, 26, closed, MATERIAL_SKIN);
    for (int finger = 0; finger < 5; finger++) {
        static const float lengths[5] = {0.058f, 0.072f, 0.078f, 0.072f, 0.058f};
        float at = finger == 0 ? 0 : 0.0185f * ((float)finger - 2.5f), thick = finger == 0 ? 0.0095f : 0.0082f;
        v3 root = finger == 0 ? v3_mad(v3_mad(a->wrist, along, 0.03f), across, 0.022f)
                              : v3_mad(v3_mad(a->wrist, along, 0.080f), across, -at), path[9];
        v3 way = finger == 0 ? v3_unit(v3_mad(along, across, 0.75f)) : along;
        float radii[9], step = lengths[finger] / 7;
        for (int i = 0; i < 9; i++) {
            path[i] = root;
            radii[i] = thick * (1 - 0.035f * (float)i) * (i == 7 ? 0.7f : 1);
            root = v3_mad(root, way, i == 0 || i == 7 ? 0.003f : step);
            way = v3_unit(v3_mad(way, flat, 0.075f + 0.02f * (float)finger));
        }
        ex_build_tube(b, path, radii, 9, 16, MATERIAL_SKIN);
    }
}

static void add_sleeve(ex_builder *b, const arm *a, float s)
{
    v3 middle = v3_scale(v3_add(a->shoulder, a->elbow), 0.5f), fore = v3_scale(v3_add(a->elbow, a->wrist), 0.5f);
    v3 down = v3_unit(v3_sub(a->wrist, a->elbow)), drop = v3_make(0, -0.012f, 0);
    const station sleeve[] = {{v3_add(a->shoulder, v3_make(-0.075f * s, -0.03f, 0)), 0.040f, 0.045f},
        {v3_add(a->shoulder, v3_make(-0.03f * s, -0.006f, 0)), 0.062f, 0.066f},
        {v3_mad(a->shoulder, v3_sub(middle, a->shoulder), 0.35f), 0.060f, 0.064f}, {middle, 0.053f, 0.057f},
        {a->elbow, 0.047f, 0.049f}, {fore, 0.046f, 0.046f},
            {v3_add(v3_mad(a->wrist, down, -0.05f), drop), 0.056f, 0.060f},
        {v3_add(v3_mad(a->wrist, down, -0.005f), drop), 0.066f, 0.074f}};
    add_loft(b, sleeve, 8, v3_make(0, 0, 1), 0.045f, 48, 64, EX_WRAP, MATERIAL_DRESS);
    const station cuff[] = {{v3_add(v3_mad(a->wrist, down, -0.022f), drop), 0.0640f, 0.0715f},
        {v3_add(v3_mad(a->wrist, down, -0.003f), drop), 0.0695f, 0.0775f}};
    add_loft(b, cuff, 2, v3_make(0, 0, 1), 0, 56, 4, EX_WRAP, MATERIAL_TRIM);
}

/* ---- dress ---- */

static void add_bodice(ex_builder *b, const pose *p)
{
    float lean = p->neck.x - p->chest.x;         /* taken up over the chest: a slanted section would tilt */
    v3 waist = v3_add(v3_scale(v3_add(p->hip, p->chest), 0.5f), v3_make(0, -0.05f, 0));
    const station bodice[] = {{v3_add(p->hip, v3_make(0, 0.0f, 0)), 0.160f, 0.118f}, {waist, 0.120f, 0.098f},
        {v3_mad(waist, v3_sub(p->chest, waist), 0.5f), 0.138f, 0.112f},
            {v3_add(p->chest, v3_make(0, -0.02f, 0.012f)), 0.160f, 0.128f},
        {v3_add(p->chest, v3_make(0.3f * lean, 0.05f, 0.002f)), 0.168f, 0.112f},
            {v3_add(p->chest, v3_make(0.7f * lean, 0.105f, -0.01f)), 0.166f, 0.088f},
        {v3_add(p->chest, v3_make(lean, 0.137f, -0.014f)), 0.098f, 0.068f},
            {v3_add(p->neck, v3_make(0, 0.000f, 0)), 0.064f, 0.064f}};
    add_loft(b, bodice, 8, v3_make(1, 0, 0), 0.006f, 90, 56, EX_WRAP, MATERIAL_DRESS);
    const station collar[] = {{v3_add(p->neck, v3_make(0, -0.035f, -0.002f)), 0.084f, 0.080f},
        {v3_add(p->neck, v3_make(0, 0.022f, 0.001f)), 0.061f, 0.063f}};
    add_loft(b, collar, 2, v3_make(1, 0, 0), 0, 80, 6, EX_WRAP, MATERIAL_TRIM);
    const station belt[] = {{v3_add(waist, v3_make(0, -0.025f, 0)), 0.127f, 0.105f},
        {v3_add(waist, v3_make(0, 0, 0)), 0.131f, 0.109f},
        {v3_add(waist, v3_make(0, 0.025f, 0)), 0.128f, 0.106f}};
    add_loft(b, belt, 3, v3_make(1, 0, 0), 0, 100, 8, EX_WRAP, MATERIAL_TRIM);
}

typedef struct skirt { const pose *pose; float share, gap; } skirt;   /* of the way to the floor; from the lower one */

/* Rings from the waist down; folds start at the hip and deepen, and lag behind the swaying hip. */
static v3 skirt_point(const void *context, float u, float v)
{
    const skirt *k = (const skirt *)context;
    const pose *p = k->pose;
    float s = k->share * (1 - v), a = 2 * EX_PI * u;
    float hip = 0.034f * sinf(EX_PI * ex_clamp(2.6f * s, 0, 1)), deep = 0.030f * ex_smooth(0.08f, 0.9f, s);
    float lag = sinf(1.3f * p->time - 1.3f * s), stir = 0.12f * sinf(2.3f * p->time + 2 * a) * s;
    float fold = sinf(11 * a + 0.9f * sinf(2 * a + 0.8f) + 0.5f * s + stir) +
                 0.45f * sinf(19 * a + 1.7f + 0.8f * s) + 0.22f * sinf(5 * a + 3 * s + 0.7f * lag);
    float r = ex_mix(0.124f, 0.36f, powf(s, 0.80f)) + hip + deep * fold + k->gap * (1 + 1.5f * s);
    float hem = k->gap > 0 ? 0.05f * s * sinf(9 * a) : 0, y = ex_mix(1.06f, 0.012f, s) - hem;
    float x = ex_mix(p->hip.x, 0, s) + 0.035f * s * lag;
    return v3_make(x + r * cosf(a), y + 0.012f * s * fold, -0.80f * r * sinf(a) * (1 + 0.2f * s) - 0.02f * s);
}

static void add_skirts(ex_builder *b, const pose *p)
{
    const skirt under = {p, 1, 0}, over = {p, 0.46f, 0.009f};
    ex_build_surface(b, skirt_point, &under, 280, 76, EX_WRAP, MATERIAL_DRESS);
    ex_build_surface(b, skirt_point, &over, 180, 34, EX_WRAP, MATERIAL_TRIM);
}

static void add_shoes(ex_builder *b, const pose *p)
{
    for (int side = -1; side <= 1; side += 2)
        ex_build_ball(b, v3_make(0.085f * (float)side + 0.01f * p->sway, 0.028f, 0.17f + 0.05f * (float)side),
                      v3_make(0.040f, 0.030f, 0.12f), 28, MATERIAL_SHOE);
}

int ex_pose_figure(ex_scene *scene, float time)
{
    const pose p = pose_at(time);
    ex_builder b = ex_build_begin(scene);
    add_head(&b, &p);
    for (int right = 0; right < 2; right++) {
        arm a = arm_at(&p, right);
        add_hand(&b, &a, right ? -1.0f : 1.0f);
    }
    add_shoes(&b, &p);
    if (ex_build_replace(&b, BODY) != 0) return -1;
    add_bodice(&b, &p);
    for (int right = 0; right < 2; right++) {
        arm a = arm_at(&p, right);
        add_sleeve(&b, &a, right ? -1.0f : 1.0f);
    }
    add_skirts(&b, &p);
    return ex_build_replace(&b, DRESS);
}

void ex_build_figure(ex_builder *b)
{
    static const float colors[][3] = {{0.62f, 0.41f, 0.31f}, {0.085f, 0.05f, 0.035f}, {0.50f, 0.10f, 0.11f},
        {0.66f, 0.54f, 0.34f}, {0.05f, 0.04f, 0.035f}};
    for (int i = 0; i < 5; i++) {
        uint32_t material = ex_build_material(b, colors[i][0], colors[i][1], colors[i][2]);
        if (!b->failed && (i == MATERIAL_DRESS || i == MATERIAL_TRIM)) b->scene->materials[material].double_sided = 1;
    }
    ex_build_object(b, "body", ex_build_finish(b));
    ex_build_object(b, "dress", ex_build_finish(b));
    uint32_t grey = ex_build_material(b, 0.5f, 0.5f, 0.5f);
    ex_build_quad(b, v3_make(-60, 0, 60), v3_make(60, 0, 60), v3_make(60, 0, -60), v3_make(-60, 0, -60), grey);
    ex_object *ground = ex_build_object(b, "ground", ex_build_finish(b));
    if (ground) ground->receiver_only = 1;
    ex_build_camera(b, v3_make(1.25f, 1.45f, 3.6f), v3_make(0, 0.86f, 0), 30);
}
