/* builtin_atrium.c - a court between two storeys of arcades, a million triangles, with cloth that hangs in it and
   moves in the wind. The stone is detail, not subdivision: fluted shafts, leaves of capitals, balusters, dentils,
   ashlar, tiles. Metres; the court is 18 x 9 of bays of 3, round it galleries 3 wide. */
#include "internal.h"

enum { BAYS_X = 6, BAYS_Z = 3, BANNERS = 5, SAILS = 2 };

static const float bay = 3, court_x = 9, court_z = 4.5f, wall_x = 12, wall_z = 7.5f;
static const float spring = 3.0f, arch_radius = 1.28f, arch_top = 4.6f, upper = 5.0f, upper_scale = 0.8f;
static const float upper_lift = 4.4f;            /* what an upper arch is above a lower one */

typedef struct atrium_look {
    uint32_t stone, trim, ashlar[3], tile[2], plaster, wood, roof, metal;
} atrium_look;

/* ---- the column: 3 metres with its capital ---- */

enum { SHAFT_ROWS = 16 };

static v3 shaft_point(const void *context, float u, float row)       /* the first and the last row close it */
{
    const float flutes = 20;
    float v = ex_clamp((row * (SHAFT_ROWS + 2) - 1) / SHAFT_ROWS, 0, 1);
    float swell = 0.215f - 0.035f * v - 0.006f * (2 * v - 1) * (2 * v - 1), angle = -2 * EX_PI * u;
    float fade = ex_smooth(0, 0.05f, v) * ex_smooth(0, 0.05f, 1 - v), groove = sinf(0.5f * flutes * angle);
    float r = swell * (1 - 0.085f * fade * sqrtf(fabsf(groove)) * fabsf(groove));
    (void)context;
    if (row <= 0 || row >= 1) r = 0;
    return v3_make(r * cosf(angle), 0.345f + 2.175f * v, r * sinf(angle));
}

typedef struct leaf { float foot, height, radius, curl, width; } leaf;

/* An acanthus leaf, a lens in section: it climbs the bell, then its tip bends out and down. u runs round it. */
static v3 leaf_point(const void *context, float u, float v)
{
    const leaf *l = (const leaf *)context;
    float a = 2 * EX_PI * u, lobes = 1 + 0.16f * sinf(19 * v), bend = ex_smooth(0.45f, 1, v);
    float half = 0.5f * l->width * lobes * powf(fmaxf(sinf(EX_PI * (0.16f + 0.84f * v)), 0), 0.6f);
    float out = l->radius + 0.02f + 0.03f * v + l->curl * bend * bend;
    float y = l->foot + l->height * (v - 0.32f * bend * bend * v);
    float side = half * cosf(a), thick = (0.012f + 0.010f * (1 - v)) * sinf(a);
    float rib = 0.016f * cosf(a) * cosf(a) - 0.012f;
    return v3_make(out + thick * (1 - bend) - rib, y + thick * bend, side);
}

static void add_volute(ex_builder *b, uint32_t material)
{
    enum { POINTS = 26 };
    v3 path[POINTS];
    float radii[POINTS];
    for (int i = 0; i < POINTS; i++) {
        float s = (float)i / (POINTS - 1), angle = 0.6f + 9.5f * s, r = 0.085f * (1 - 0.80f * s);
        v3 p = v3_make(0.315f - r * cosf(angle), 2.865f + r * sinf(angle) - 0.01f, 0);
        path[i] = i == 0 ? v3_make(0.20f, 2.74f, 0) : p;
        radii[i] = 0.026f * (1 - 0.4f * s);
    }
    ex_build_tube(b, path, radii, POINTS, 8, material);
    ex_build_ball(b, v3_make(0.315f, 2.855f, 0), v3_make(0.03f, 0.03f, 0.045f), 10, material);
}

static uint32_t build_column(ex_builder *b, const atrium_look *look)
{
    static const float foot[][2] = {{0, 0.14f}, {0.30f, 0.14f}, {0.315f, 0.16f}, {0.315f, 0.185f}, {0.30f, 0.205f},
        {0.265f, 0.215f}, {0.255f, 0.235f}, {0.26f, 0.255f}, {0.28f, 0.265f}, {0.287f, 0.285f}, {0.28f, 0.305f},
        {0.25f, 0.315f}, {0.235f, 0.34f}, {0.215f, 0.36f}, {0, 0.37f}};
    static const float bell[][2] = {{0, 2.50f}, {0.20f, 2.50f}, {0.215f, 2.515f}, {0.205f, 2.53f}, {0.185f, 2.55f},
        {0.185f, 2.70f}, {0.20f, 2.82f}, {0.25f, 2.90f}, {0.26f, 2.92f}, {0, 2.92f}};
    static const leaf low = {2.53f, 0.22f, 0.180f, 0.085f, 0.145f}, high = {2.55f, 0.34f, 0.165f, 0.10f, 0.13f};
    const int closed = EX_WRAP | EX_TIP_LOW | EX_TIP_HIGH;
    float m[16];
    uint32_t stone = look->stone;
    ex_build_block(b, v3_make(-0.32f, 0, -0.32f), v3_make(0.32f, 0.14f, 0.32f), 0.012f, stone);
    ex_build_lathe(b, foot[0], sizeof foot / sizeof *foot, 48, 0.9f, stone);
    ex_build_surface(b, shaft_point, NULL, 100, SHAFT_ROWS + 2, closed, stone);
    ex_build_lathe(b, bell[0], sizeof bell / sizeof *bell, 40, 0.9f, stone);
    ex_mark mark = ex_build_mark(b);
    ex_build_surface(b, leaf_point, &low, 10, 14, closed, stone);
    ex_build_ring(b, mark, 8);
    mark = ex_build_mark(b);
    ex_build_surface(b, leaf_point, &high, 10, 14, closed, stone);
    ex_place(m, v3_make(0, 0, 0), EX_PI / 8, 1);
    ex_build_transform(b, mark, m);
    ex_build_ring(b, mark, 8);
    mark = ex_build_mark(b);
    add_volute(b, stone);
    ex_place(m, v3_make(0, 0, 0), EX_PI / 4, 1);
    ex_build_transform(b, mark, m);
    ex_build_ring(b, mark, 4);
    ex_build_block(b, v3_make(-0.29f, 2.92f, -0.29f), v3_make(0.29f, 2.96f, 0.29f), 0.008f, stone);
    ex_build_block(b, v3_make(-0.32f, 2.96f, -0.32f), v3_make(0.32f, spring, 0.32f), 0.010f, stone);
    return ex_build_finish(b);
}

/* ---- the arch of a bay: wall above it, voussoirs, mouldings; in x, y, 0.44 thick ---- */

enum { ARCH_STEPS = 40 };

static void arch_curve(int i, float *x, float *y)            /* -1 and ARCH_STEPS + 1 are the ends of the bay */
{
    float angle = EX_PI * (1 - ex_clamp((float)i, 0, ARCH_STEPS) / ARCH_STEPS);
    *x = i < 0 ? -bay / 2 : i > ARCH_STEPS ? bay / 2 : arch_radius * cosf(angle);
    *y = i <= 0 || i >= ARCH_STEPS ? spring : spring + arch_radius * sinf(angle);
}

static void add_arch_wall(ex_builder *b, uint32_t stone)
{
    const float z = 0.22f;
    for (int i = -1; i <= ARCH_STEPS; i++) {
        float x0, y0, x1, y1;
        arch_curve(i, &x0, &y0);
        arch_curve(i + 1, &x1, &y1);
        v3 p = v3_make(x0, y0, z), q = v3_make(x1, y1, z), r = v3_make(x1, arch_top, z), s = v3_make(x0, arch_top, z);
        v3 back = v3_make(0, 0, -2 * z);
        ex_build_quad(b, p, q, r, s, stone);
        ex_build_quad(b, v3_add(q, back), v3_add(p, back), v3_add(s, back), v3_add(r, back), stone);
        ex_build_quad(b, v3_add(p, back), v3_add(q, back), q, p, stone);
        ex_build_quad(b, s, r, v3_add(r, back), v3_add(s, back), stone);
        if (i == -1) ex_build_quad(b, v3_add(p, back), p, s, v3_add(s, back), stone);
        if (i == ARCH_STEPS) ex_build_quad(b, q, v3_add(q, back), v3_add(r, back), r, stone);
    }
}

/* A roll round the arch's edge: u runs round the roll, v along the half circle. */
static v3 roll_point(const void *context, float u, float v)
{
    const float *at = (const float *)context;                /* radius, z, thickness */
    float angle = EX_PI * v, turn = -2 * EX_PI * u, thick = v > 0 && v < 1 ? at[2] : 0, r = at[0] + thick * cosf(turn);
    return v3_make(r * cosf(angle), spring + r * sinf(angle), at[1] + thick * sinf(turn));
}

static uint32_t build_arch(ex_builder *b, const atrium_look *look)
{
    static const float rolls[4][3] = {{1.33f, 0.225f, 0.028f}, {1.47f, 0.225f, 0.036f}, {1.33f, -0.225f, 0.028f},
        {1.47f, -0.225f, 0.036f}};
    enum { STONES = 15 };
    const int closed = EX_WRAP | EX_TIP_LOW | EX_TIP_HIGH;
    add_arch_wall(b, look->plaster);
    for (int i = 0; i < STONES; i++) {
        float gap = 0.006f, a = EX_PI * (float)i / STONES + gap, c = EX_PI * (float)(i + 1) / STONES - gap;
        int key = i == STONES / 2;
        float in = arch_radius - (key ? 0.05f : 0.015f), out = arch_radius + (key ? 0.26f : 0.17f);
        float z = key ? 0.27f : 0.235f;
        const float wedge[4][2] = {{in * cosf(a), spring + in * sinf(a)}, {out * cosf(a), spring + out * sinf(a)},
            {out * cosf(c), spring + out * sinf(c)}, {in * cosf(c), spring + in * sinf(c)}};
        ex_build_prism(b, wedge, 4, -z, z, 0.009f, look->trim);
    }
    for (int i = 0; i < 4; i++) ex_build_surface(b, roll_point, rolls[i], 8, ARCH_STEPS, closed, look->trim);
    for (int side = -1; side <= 1; side += 2) {              /* a boss in each spandrel */
        float m[16] = {1, 0, 0, 0, 0, 0, (float)side, 0, 0, (float)-side, 0, 0, 1.24f, 4.30f, 0.22f * (float)side, 1};
        static const float rose[][2] = {{0, -0.01f}, {0.16f, -0.01f}, {0.17f, 0.01f}, {0.16f, 0.025f}, {0.13f, 0.02f},
            {0.11f, 0.012f}, {0.08f, 0.03f}, {0.04f, 0.05f}, {0, 0.055f}};
        for (int x = -1; x <= 1; x += 2) {
            ex_mark mark = ex_build_mark(b);
            ex_build_lathe(b, rose[0], sizeof rose / sizeof *rose, 20, 0.9f, look->trim);
            m[12] = 1.24f * (float)x;
            ex_build_transform(b, mark, m);
        }
    }
    return ex_build_finish(b);
}

/* ---- the balustrade of a bay, along x ---- */

static uint32_t build_balustrade(ex_builder *b, const atrium_look *look)
{
    static const float profile[][2] = {{0, 0.12f}, {0.055f, 0.12f}, {0.058f, 0.15f}, {0.05f, 0.165f}, {0.03f, 0.18f},
        {0.036f, 0.20f}, {0.058f, 0.26f}, {0.066f, 0.31f}, {0.062f, 0.37f}, {0.045f, 0.45f}, {0.03f, 0.53f},
        {0.026f, 0.60f}, {0.03f, 0.635f}, {0.046f, 0.65f}, {0.046f, 0.665f}, {0.032f, 0.68f}, {0.036f, 0.70f},
        {0.055f, 0.715f}, {0.055f, 0.76f}, {0, 0.76f}};
    enum { BALUSTERS = 11 };
    ex_mark mark = ex_build_mark(b), until;
    float m[16];
    ex_build_lathe(b, profile[0], sizeof profile / sizeof *profile, 18, 0.9f, look->trim);
    until = ex_build_mark(b);
    for (int i = 0; i < BALUSTERS; i++) {
        ex_place(m, v3_make(0.22f * (float)(i - BALUSTERS / 2), 0, 0), 0, 1);
        if (i != BALUSTERS / 2) ex_build_copy(b, mark, until, m);
    }
    ex_build_block(b, v3_make(-1.3f, 0, -0.11f), v3_make(1.3f, 0.12f, 0.11f), 0.012f, look->trim);
    ex_build_block(b, v3_make(-1.3f, 0.76f, -0.10f), v3_make(1.3f, 0.84f, 0.10f), 0.010f, look->trim);
    ex_build_block(b, v3_make(-1.3f, 0.84f, -0.14f), v3_make(1.3f, 0.90f, 0.14f), 0.014f, look->trim);
    return ex_build_finish(b);
}

/* ---- cornices: courses and dentils, along x for one bay ---- */

static uint32_t build_cornice(ex_builder *b, const atrium_look *look)
{
    static const float courses[][3] = {{4.60f, 4.68f, 0.26f}, {4.80f, 4.88f, 0.34f}, {4.88f, 4.95f, 0.42f},
        {4.95f, 5.00f, 0.46f}};
    ex_build_block(b, v3_make(-bay / 2, 4.60f, -0.24f), v3_make(bay / 2, 4.99f, 0.24f), 0.004f, look->stone);
    for (int i = 0; i < 4; i++)
        ex_build_block(b, v3_make(-bay / 2, courses[i][0], 0.05f), v3_make(bay / 2, courses[i][1], courses[i][2]),
                       0.01f, look->trim);
    for (int i = 0; i < 20; i++) {
        float x = -bay / 2 + 0.15f * ((float)i + 0.5f);
        ex_build_block(b, v3_make(x - 0.04f, 4.69f, 0.2f), v3_make(x + 0.04f, 4.795f, 0.33f), 0.006f, look->trim);
    }
    return ex_build_finish(b);
}

/* ---- a bay's vault: two barrels that cross, seen from below ---- */

static v3 vault_point(const void *context, float u, float v)
{
    float x = bay * (u - 0.5f), z = bay * (v - 0.5f), r = 0.5f * bay;
    float h = sqrtf(fmaxf(r * r - fminf(x * x, z * z), 0));
    (void)context;
    return v3_make(x, spring + h, z);
}

static uint32_t build_vault(ex_builder *b, const atrium_look *look)
{
    ex_build_surface(b, vault_point, NULL, 24, 24, 0, look->plaster);
    return ex_build_finish(b);
}

/* ---- a door in the outer wall, in x, y, facing +Z ---- */

static uint32_t build_door(ex_builder *b, const atrium_look *look)
{
    ex_build_block(b, v3_make(-0.78f, 0, -0.02f), v3_make(-0.58f, 2.3f, 0.10f), 0.014f, look->trim);
    ex_build_block(b, v3_make(0.58f, 0, -0.02f), v3_make(0.78f, 2.3f, 0.10f), 0.014f, look->trim);
    ex_build_block(b, v3_make(-0.84f, 2.3f, -0.02f), v3_make(0.84f, 2.52f, 0.13f), 0.014f, look->trim);
    ex_build_block(b, v3_make(-0.92f, 2.52f, -0.02f), v3_make(0.92f, 2.60f, 0.20f), 0.014f, look->trim);
    for (int leaf_side = 0; leaf_side < 2; leaf_side++) {
        float x = leaf_side ? 0.005f : -0.575f;
        ex_build_block(b, v3_make(x, 0.01f, -0.01f), v3_make(x + 0.57f, 2.29f, 0.035f), 0.005f, look->wood);
        for (int panel = 0; panel < 3; panel++) {
            float y = 0.12f + 0.72f * (float)panel;
            ex_build_block(b, v3_make(x + 0.08f, y, 0), v3_make(x + 0.49f, y + 0.6f, 0.055f), 0.02f, look->wood);
        }
        ex_build_ball(b, v3_make(leaf_side ? 0.05f : -0.05f, 1.05f, 0.06f), v3_make(0.022f, 0.022f, 0.03f), 14,
                      look->metal);
    }
    return ex_build_finish(b);
}

/* ---- the fountain ---- */

static uint32_t build_fountain(ex_builder *b, const atrium_look *look)
{
    static const float basin[][2] = {{0, 0}, {1.62f, 0}, {1.62f, 0.10f}, {1.55f, 0.14f}, {1.42f, 0.18f}, {1.40f, 0.30f},
        {1.47f, 0.40f}, {1.58f, 0.44f}, {1.62f, 0.48f}, {1.60f, 0.53f}, {1.52f, 0.55f}, {1.36f, 0.55f}, {1.30f, 0.52f},
        {1.28f, 0.44f}, {0, 0.42f}};
    static const float stem[][2] = {{0, 0.40f}, {0.34f, 0.40f}, {0.36f, 0.52f}, {0.26f, 0.58f}, {0.17f, 0.66f},
        {0.15f, 0.80f}, {0.19f, 0.95f}, {0.15f, 1.06f}, {0.20f, 1.12f}, {0.45f, 1.18f}, {0.68f, 1.29f}, {0.73f, 1.36f},
        {0.72f, 1.39f}, {0.66f, 1.38f}, {0.45f, 1.30f}, {0.16f, 1.27f}, {0.10f, 1.32f}, {0.09f, 1.46f}, {0.13f, 1.55f},
        {0.10f, 1.60f}, {0.30f, 1.66f}, {0.38f, 1.74f}, {0.37f, 1.76f}, {0.28f, 1.72f}, {0.08f, 1.70f}, {0.06f, 1.80f},
        {0.10f, 1.87f}, {0.09f, 1.94f}, {0.04f, 2.02f}, {0, 2.05f}};
    ex_build_lathe(b, basin[0], sizeof basin / sizeof *basin, 128, 0.8f, look->trim);
    ex_build_lathe(b, stem[0], sizeof stem / sizeof *stem, 96, 0.8f, look->trim);
    ex_mark mark = ex_build_mark(b);
    for (int i = -1; i <= 1; i++)                            /* gadroons on the basin's wall */
        ex_build_ball(b, v3_make(1.42f, 0.25f, 0.12f * (float)i), v3_make(0.035f, 0.11f, 0.045f), 12, look->trim);
    ex_build_ring(b, mark, 24);
    return ex_build_finish(b);
}

/* ---- floors, walls, roof: one mesh each, as they are not repeated ---- */

/* Tiles over a rectangle; not in the court where `hollow`. */
static void add_floor(ex_builder *b, const atrium_look *look, float y, int hollow)
{
    const float size = 0.3f;
    int nx = (int)(2 * wall_x / size + 0.5f), nz = (int)(2 * wall_z / size + 0.5f);
    for (int j = 0; j < nz; j++)
        for (int i = 0; i < nx; i++) {
            float x = -wall_x + size * (float)i, z = -wall_z + size * (float)j;
            int inside = fabsf(x + size / 2) < court_x && fabsf(z + size / 2) < court_z;
            if (inside && hollow) continue;
            ex_build_tile(b, v3_make(x, y, z), size, size, 0.005f, 0.004f, look->tile[(i / (1 + inside) + j /
                          (1 + inside)) % 2]);
        }
}

/* Courses of cut stone, every second one moved by half a block. A wall along +X seen from +Z, then turned. */
static void add_ashlar(ex_builder *b, const atrium_look *look, float length, float yaw, v3 position)
{
    const float wide = 0.6f, high = 0.3f, top = 9.3f;
    uint32_t seed = 7 + (uint32_t)(length * 10);
    ex_mark mark = ex_build_mark(b);
    float stand[16] = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1}, m[16];
    for (int row = 0; row < (int)(top / high + 0.5f); row++)
        for (float x = row % 2 ? -wide / 2 : 0; x < length - 0.01f; x += wide) {
            float from = fmaxf(x, 0), to = fminf(x + wide, length);
            ex_build_tile(b, v3_make(from, 0, -high * (float)(row + 1)), to - from, high, 0.008f, 0.006f,
                          look->ashlar[(int)(3 * ex_random(&seed))]);
        }
    ex_build_transform(b, mark, stand);                      /* the floor's +Y becomes +Z, its -Z becomes +Y */
    ex_place(m, position, yaw, 1);
    ex_build_transform(b, mark, m);
}

static void add_walls(ex_builder *b, const atrium_look *look)
{
    add_ashlar(b, look, 2 * wall_x, 0, v3_make(-wall_x, 0, -wall_z));
    add_ashlar(b, look, 2 * wall_x, EX_PI, v3_make(wall_x, 0, wall_z));
    add_ashlar(b, look, 2 * wall_z, EX_PI / 2, v3_make(-wall_x, 0, wall_z));
    add_ashlar(b, look, 2 * wall_z, -EX_PI / 2, v3_make(wall_x, 0, -wall_z));
}

/* What stands behind the ashlar, which is a sheet: a shadow map sees the sun on the outer face of a wall half a metre
   thick, not on the joints of the stones within. */
static void add_outer_walls(ex_builder *b, const atrium_look *look)
{
    const float gap = 0.12f, thick = 0.5f, top = 10.5f;
    for (int side = -1; side <= 1; side += 2) {
        float s = (float)side, x0 = s * (wall_x + gap), x1 = x0 + s * thick, z0 = s * (wall_z + gap);
        float z1 = z0 + s * thick;
        float x = wall_x + gap + thick, z = wall_z + gap;
        ex_build_block(b, v3_make(fminf(x0, x1), -0.2f, -z), v3_make(fmaxf(x0, x1), top, z), 0.01f, look->plaster);
        ex_build_block(b, v3_make(-x, -0.2f, fminf(z0, z1)), v3_make(x, top, fmaxf(z0, z1)), 0.01f, look->plaster);
    }
}

/* Rows of round tiles that rise from the court's edge to the outer wall; the four sides meet on the diagonals. */
typedef struct roof { float edge, depth, across; } roof;

static v3 roof_point(const void *context, float u, float v)
{
    const roof *r = (const roof *)context;
    float out = r->depth * v, half = r->edge + out, step = v * 12 - floorf(v * 12 - 0.001f);
    float x = (2 * u - 1) * half, wave = fabsf(sinf(EX_PI * x / 0.2f));
    return v3_make(x, 9.42f + 0.32f * out + 0.05f * wave - 0.02f * step, -(r->across + out));
}

static void add_roof(ex_builder *b, const atrium_look *look)
{
    const float over = 0.55f, depth = wall_x - court_x + over;
    for (int side = 0; side < 4; side++) {
        int along_x = side % 2 == 0;
        roof r = {(along_x ? court_x : court_z) - over, depth, (along_x ? court_z : court_x) - over};
        ex_mark mark = ex_build_mark(b);
        float m[16];
        ex_build_surface(b, roof_point, &r, along_x ? 600 : 330, 12, 0, look->roof);
        ex_place(m, v3_make(0, 0, 0), EX_PI / 2 * (float)side, 1);
        ex_build_transform(b, mark, m);
    }
}

/* ---- putting it together ---- */

static void place(ex_builder *b, const char *name, uint32_t mesh, v3 position, float yaw, float scale)
{
    ex_object *object = ex_build_object(b, name, mesh);
    if (object) ex_place(object->transform, position, yaw, scale);
}

/* Bay k of the court's rim, counted round it: its middle, and the turn that has +Z look into the court. */
static float rim_bay(int k, v3 *middle)
{
    int side = k < BAYS_X ? 0 : k < BAYS_X + BAYS_Z ? 1 : k < 2 * BAYS_X + BAYS_Z ? 2 : 3;
    static const int starts[4] = {0, BAYS_X, BAYS_X + BAYS_Z, 2 * BAYS_X + BAYS_Z};
    float along = bay * ((float)(k - starts[side]) + 0.5f);
    *middle = side == 0   ? v3_make(along - court_x, 0, -court_z)
              : side == 1 ? v3_make(court_x, 0, along - court_z)
              : side == 2 ? v3_make(court_x - along, 0, court_z)
                          : v3_make(-court_x, 0, court_z - along);
    return -EX_PI / 2 * (float)side;
}

static void add_rim(ex_builder *b, const atrium_look *look)
{
    uint32_t column = build_column(b, look), arch = build_arch(b, look), cornice = build_cornice(b, look);
    uint32_t balustrade = build_balustrade(b, look), door = build_door(b, look);
    for (int k = 0; k < 2 * (BAYS_X + BAYS_Z); k++) {
        v3 middle, up = v3_make(0, upper, 0), lift = v3_make(0, upper_lift, 0);
        float yaw = rim_bay(k, &middle);
        v3 left = v3_make(-0.5f * bay * cosf(yaw), 0, 0.5f * bay * sinf(yaw)), corner = v3_add(middle, left);
        v3 outwards = v3_make(-sinf(yaw), 0, -cosf(yaw)), wall = v3_mad(middle, outwards, bay);
        place(b, "column", column, corner, 0, 1);
        place(b, "upper column", column, v3_add(corner, up), 0, upper_scale);
        place(b, "arch", arch, middle, yaw, 1);
        place(b, "upper arch", arch, v3_add(middle, lift), yaw, 1);
        place(b, "cornice", cornice, middle, yaw, 1);
        place(b, "upper cornice", cornice, v3_add(middle, lift), yaw, 1);
        place(b, "balustrade", balustrade, v3_add(middle, up), yaw, 1);
        place(b, "door", door, k % 3 == 1 ? v3_add(wall, up) : wall, yaw, 1);
    }
}

static void add_galleries(ex_builder *b, const atrium_look *look)
{
    uint32_t vault = build_vault(b, look);
    for (int j = 0; j < BAYS_Z + 2; j++)
        for (int i = 0; i < BAYS_X + 2; i++) {
            if (i > 0 && i <= BAYS_X && j > 0 && j <= BAYS_Z) continue;
            v3 middle = v3_make(bay * ((float)i - 0.5f) - court_x, 0, bay * ((float)j - 0.5f) - court_z);
            place(b, "vault", vault, middle, 0, 1);
            place(b, "upper vault", vault, v3_add(middle, v3_make(0, upper_lift, 0)), 0, 1);
        }
    add_floor(b, look, 0, 0);
    ex_build_object(b, "floor", ex_build_finish(b));
    add_floor(b, look, upper, 1);
    ex_build_object(b, "upper floor", ex_build_finish(b));
    add_walls(b, look);
    add_outer_walls(b, look);
    ex_build_object(b, "walls", ex_build_finish(b));
    add_roof(b, look);
    ex_build_object(b, "roof", ex_build_finish(b));
}

static void add_furniture(ex_builder *b, const atrium_look *look)
{
    place(b, "fountain", build_fountain(b, look), v3_make(1.5f, 0, -0.4f), 0, 1);
    uint32_t plant = ex_build_plant_mesh(b);
    static const float pots[3][2] = {{-4.6f, -3.2f}, {4.9f, -3.3f}, {5.3f, 3.2f}};
    for (int i = 0; i < 3; i++) place(b, "plant", plant, v3_make(pots[i][0], 0, pots[i][1]), 1.7f * (float)i, 2.4f);
}

/* ---- cloth ---- */

static uint32_t first_cloth_mesh(const ex_scene *scene) { return scene->objects[0].mesh; }   /* cloth is built first */

/* A sail across the court: it sags between its two ends and billows. */
typedef struct sail { float x, time, phase; } sail;

static v3 sail_point(const void *context, float u, float v)
{
    const sail *s = (const sail *)context;
    float across = 2 * u - 1, along = 2 * v - 1, t = s->time, p = s->phase;
    float free = (1 - along * along), edge = 1 - 0.16f * free * free;
    float billow = 0.22f * sinf(1.1f * t + p + 2.2f * along) + 0.09f * sinf(2.7f * t + 3 * along + 2.4f * across + p) +
                   0.03f * sinf(5.3f * t + 9 * along - 4 * across);
    float pleat = 0.05f * cosf(11 * across) * (1 - free) + 0.03f * cosf(7 * across + along);
    float y = 8.25f - 1.35f * free + free * billow + pleat + 0.10f * across * across * free;
    return v3_make(s->x + 1.15f * across * edge + 0.08f * free * sinf(0.9f * t + p), y, 4.28f * along);
}

static void add_cloth_objects(ex_builder *b)
{
    for (int i = 0; i < BANNERS + SAILS; i++)
        ex_build_object(b, i < BANNERS ? "banner" : "sail", ex_build_finish(b));
}

int ex_pose_atrium(ex_scene *scene, float time)
{
    static const float banners[BANNERS][2] = {{-4.5f, 0}, {1.5f, 0}, {7.5f, 0}, {-1.5f, 1}, {4.5f, 1}};
    static const float sails[SAILS] = {-3, 3};
    uint32_t mesh = first_cloth_mesh(scene);
    ex_builder b = ex_build_begin(scene);
    for (uint32_t i = 0; i < BANNERS; i++) {
        float z = banners[i][1] > 0 ? court_z - 0.53f : -court_z + 0.53f, side = banners[i][1] > 0 ? -1 : 1;
        ex_drape drape = {v3_make(banners[i][0] - 0.75f * side, upper + 0.92f, z),
                          v3_make(banners[i][0] + 0.75f * side, upper + 0.92f, z), 3.3f, 0.035f, 5, 0.55f,
                          1.9f * (float)i};
        ex_build_drape(&b, &drape, time, 48, 96, i % 3);     /* the cloth's materials are the first ones */
        if (ex_build_replace(&b, mesh + i) != 0) return -1;
    }
    for (uint32_t i = 0; i < SAILS; i++) {
        sail s = {sails[i], time, 2.1f * (float)i};
        ex_build_surface(&b, sail_point, &s, 56, 160, 0, i);
        if (ex_build_replace(&b, mesh + BANNERS + i) != 0) return -1;
    }
    return 0;
}

void ex_build_atrium(ex_builder *b)
{
    atrium_look look;
    static const float dye[3][3] = {{0.52f, 0.07f, 0.06f}, {0.70f, 0.50f, 0.16f}, {0.08f, 0.20f, 0.38f}};
    for (int i = 0; i < 3; i++) {
        uint32_t cloth = ex_build_material(b, dye[i][0], dye[i][1], dye[i][2]);
        if (!b->failed) b->scene->materials[cloth].double_sided = 1;
    }
    look.stone = ex_build_material(b, 0.70f, 0.63f, 0.51f);
    look.trim = ex_build_material(b, 0.77f, 0.72f, 0.62f);
    look.ashlar[0] = ex_build_material(b, 0.64f, 0.55f, 0.42f);
    look.ashlar[1] = ex_build_material(b, 0.68f, 0.59f, 0.46f);
    look.ashlar[2] = ex_build_material(b, 0.60f, 0.52f, 0.41f);
    look.tile[0] = ex_build_material(b, 0.66f, 0.58f, 0.46f);
    look.tile[1] = ex_build_material(b, 0.44f, 0.24f, 0.16f);
    look.plaster = ex_build_material(b, 0.76f, 0.69f, 0.56f);
    look.wood = ex_build_material(b, 0.22f, 0.12f, 0.06f);
    look.roof = ex_build_material(b, 0.52f, 0.24f, 0.14f);
    look.metal = ex_build_material(b, 0.55f, 0.42f, 0.20f);
    add_cloth_objects(b);
    add_rim(b, &look);
    add_galleries(b, &look);
    add_furniture(b, &look);
    ex_light *sun = ex_build_light(b, EX_LIGHT_SUN);
    if (!sun) return;
    v3_store(sun->direction, v3_unit(v3_make(-0.30f, 0.78f, 0.42f)));
    v3_store(sun->value, v3_make(6.0f, 5.4f, 4.4f));
    ex_build_camera(b, v3_make(-8.2f, 2.3f, 2.9f), v3_make(0, 3.2f, -0.6f), 62);
}
