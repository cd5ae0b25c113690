/* builtin_chess.c - 32 pieces, instances of six meshes in two colours, on a board on a table; the opening position at
   time 0, from which an Italian game is played, taken back and played again. Metres; a square is 55 mm, the king 95 mm
   high, as in tournament sets. */
#include "internal.h"

enum { SIDES = 48 };

static const float square = 0.055f;

/* Profiles (radius, height) in millimetres. Every piece stands on the same turned foot, scaled to it. */
static const float foot[][2] = {{0, 0}, {17.5f, 0}, {18.5f, 1}, {18.5f, 4.5f}, {17.8f, 5.6f}, {16, 6.4f},
    {15.4f, 7.4f}, {15.4f, 9}, {14, 10.6f}, {12, 12.6f}};
static const float pawn[][2] = {{9.0f, 16}, {7.0f, 22}, {6.2f, 28}, {6.6f, 31}, {10.2f, 32.4f}, {10.6f, 33.4f},
    {10.2f, 34.4f}, {6.6f, 35.6f}, {8.6f, 37.2f}, {10.0f, 39.6f}, {10.6f, 42.6f}, {10.2f, 45.6f}, {8.8f, 48.2f},
    {6.6f, 50.2f}, {3.6f, 51.6f}, {0, 52}};
static const float rook[][2] = {{10.6f, 16}, {9.6f, 24}, {9.0f, 34}, {9.4f, 40}, {11.8f, 42}, {12.4f, 43.4f},
    {12.4f, 44.6f}, {12.0f, 45.6f}, {13.4f, 47.6f}, {13.8f, 56.4f}, {13.2f, 57.2f}, {10.4f, 57.2f},
    {9.8f, 56.6f}, {9.4f, 51.4f}, {8.8f, 51}, {0, 51}};
static const float bishop[][2] = {{9.4f, 16}, {7.4f, 26}, {6.4f, 38}, {6.8f, 43}, {11.4f, 44.6f},
    {11.8f, 45.6f}, {11.4f, 46.6f}, {7.6f, 48}, {7.2f, 49.6f}, {9.4f, 52.6f}, {10.2f, 56.6f}, {9.6f, 61},
    {7.8f, 65}, {5.4f, 68.4f}, {3.2f, 70.6f}, {3.0f, 71.4f}, {3.8f, 73}, {3.4f, 75}, {1.8f, 76.2f}, {0, 76.5f}};
static const float queen[][2] = {{10.4f, 16}, {8.2f, 28}, {7.0f, 44}, {7.4f, 51}, {12.6f, 52.8f}, {13.0f, 54},
    {12.6f, 55.2f}, {8.4f, 57}, {8.6f, 60}, {10.4f, 68}, {12.8f, 75}, {12.6f, 76.4f}, {11.0f, 76.8f},
    {9.4f, 75.6f}, {7.6f, 77.6f}, {4.4f, 79.6f}, {3.2f, 80.4f}, {3.6f, 82}, {3.2f, 83.8f}, {1.8f, 84.8f},
    {0, 85.2f}};
static const float king[][2] = {{10.8f, 16}, {8.6f, 28}, {7.4f, 46}, {7.8f, 54}, {13.0f, 56}, {13.4f, 57.2f},
    {13.0f, 58.4f}, {8.8f, 60.2f}, {9.0f, 63}, {10.6f, 71}, {12.4f, 78}, {12.0f, 79.2f}, {8.6f, 80.8f},
    {4.0f, 82.2f}, {2.6f, 83}, {0, 83.2f}};
static const float knight[][2] = {{12.0f, 14}, {11.8f, 15.4f}, {11.0f, 16.2f}, {0, 16.4f}};

typedef struct piece_shape { const float (*body)[2]; uint32_t points; float foot_scale; } piece_shape;
#define SHAPE(body, scale) {body, sizeof body / sizeof *body, scale}
enum { PAWN, ROOK, KNIGHT, BISHOP, QUEEN, KING, KINDS };
static const piece_shape shapes[KINDS] = {
    SHAPE(pawn, 0.86f), SHAPE(rook, 0.96f), SHAPE(knight, 0.96f), SHAPE(bishop, 0.96f), SHAPE(queen, 1.04f),
    SHAPE(king, 1.08f)};

/* Bends a profile's corners round: each segment of the drawing becomes several by a Catmull-Rom curve in radius and
   height, clamped between its ends so that it cannot overshoot the axis. */
static uint32_t refine(const float (*in)[2], uint32_t count, float (*out)[2])
{
    enum { STEPS = 3 };
    uint32_t n = 0;
    for (uint32_t i = 0; i + 1 < count; i++)
        for (int step = 0; step < STEPS; step++) {
            const float *a = in[i > 0 ? i - 1 : 0], *b = in[i], *c = in[i + 1], *d = in[i + 2 < count ? i + 2 : i + 1];
            float t = (float)step / STEPS;
            for (int k = 0; k < 2; k++) {
                float curve = b[k] + 0.5f * t * (c[k] - a[k] + t * (2 * a[k] - 5 * b[k] + 4 * c[k] - d[k] +
                                                                    t * (3 * (b[k] - c[k]) + d[k] - a[k])));
                out[n][k] = ex_clamp(curve, fminf(b[k], c[k]), fmaxf(b[k], c[k]));
            }
            if (n == 0 || out[n][0] != out[n - 1][0] || out[n][1] != out[n - 1][1]) n++;       /* clamped twice: once */
        }
    out[n][0] = in[count - 1][0];
    out[n][1] = in[count - 1][1];
    return n + 1;
}

/* A tube through a few drawn points (x forward, y up, radius; millimetres), flattened sideways. Closed by itself. */
static void add_limb(ex_builder *b, const float (*points)[3], uint32_t count, float flatten, float side,
                     uint32_t material)
{
    v3 path[16];
    float radii[16];
    uint32_t first = b->mesh.vertex_count;
    for (uint32_t i = 0; i < count; i++) {
        path[i] = v3_make(0.001f * points[i][0], 0.001f * points[i][1], 0);
        radii[i] = 0.001f * points[i][2];
    }
    ex_build_tube(b, path, radii, count, 32, material);
    for (uint32_t i = first; i < b->mesh.vertex_count && !b->failed; i++) {
        float *p = b->mesh.positions + 3 * (size_t)i, *n = b->mesh.normals + 3 * (size_t)i;
        p[2] = p[2] * flatten + 0.001f * side;
        v3_store(n, v3_make(0, 0, 0));          /* the builder makes them from the faces: radii vary much */
    }
}

/* The knight's horse: neck and head are one bent, flattened tube, with two ears and a mane. */
void ex_build_horse(ex_builder *b, uint32_t material)
{
    static const float neck[][3] = {{-2, 15, 0}, {-2, 15.2f, 11}, {-3.4f, 22, 11}, {-4.8f, 30, 10.6f},
        {-5.2f, 37, 10.2f}, {-4.2f, 44, 9.6f}, {-1.4f, 50.8f, 8.2f}, {3.2f, 54.8f, 7.0f}, {8.6f, 54.8f, 6.3f},
        {12.8f, 51.2f, 6.2f}, {15.6f, 46, 6.0f}, {17.6f, 41.6f, 5.4f}, {18.8f, 39, 4.2f}, {19.2f, 38, 0}};
    static const float ear[][3] = {{-2, 57, 0}, {-1.9f, 57.4f, 2.4f}, {-2.4f, 61, 2.2f}, {-3, 65, 1.2f},
        {-3.3f, 67, 0}};
    static const float mane[][3] = {{-12, 20, 0}, {-12.4f, 21, 3.6f}, {-14.6f, 30, 4.2f}, {-14.4f, 40, 4.2f},
        {-11.6f, 50, 4.2f}, {-6, 58, 4}, {-3, 61, 2.6f}, {-2, 61.6f, 0}};
    add_limb(b, neck, sizeof neck / sizeof *neck, 0.72f, 0, material);
    add_limb(b, mane, sizeof mane / sizeof *mane, 0.55f, 0, material);
    add_limb(b, ear, sizeof ear / sizeof *ear, 0.8f, 3.4f, material);
    add_limb(b, ear, sizeof ear / sizeof *ear, 0.8f, -3.4f, material);
}

/* The knight's horse and the king's cross: what a lathe cannot do. */
static void add_extras(ex_builder *b, int kind, uint32_t material)
{
    if (kind == KNIGHT) ex_build_horse(b, material);
    if (kind == KING) {
        ex_build_box(b, v3_make(-0.0016f, 0.0820f, -0.0016f), v3_make(0.0016f, 0.0950f, 0.0016f), material);
        ex_build_box(b, v3_make(-0.0048f, 0.0880f, -0.0014f), v3_make(0.0048f, 0.0912f, 0.0014f), material);
    }
}

static uint32_t build_piece(ex_builder *b, int kind, uint32_t material)
{
    enum { FOOT = sizeof foot / sizeof *foot };
    float drawn[FOOT + 24][2], fine[3 * (FOOT + 24) + 1][2];
    const piece_shape *shape = &shapes[kind];
    for (uint32_t i = 0; i < FOOT + shape->points; i++) {
        const float *from = i < FOOT ? foot[i] : shape->body[i - FOOT];
        drawn[i][0] = 0.001f * from[0] * (i < FOOT ? shape->foot_scale : 1);
        drawn[i][1] = 0.001f * from[1];
    }
    uint32_t count = refine((const float (*)[2])drawn, FOOT + shape->points, fine);
    ex_build_lathe(b, fine[0], count, SIDES, 0.7f, material);
    add_extras(b, kind, material);
    return ex_build_finish(b);
}

/* A slab whose six sides are cut at the same 11 lines, so that it is closed without T-junctions; squares on top. */
static void add_board(ex_builder *b, uint32_t light, uint32_t dark, uint32_t frame)
{
    float line[11];
    const float low = -0.018f;
    for (int i = 0; i < 11; i++) line[i] = square * (float)(i - 5);
    line[0] = -4 * square - 0.028f;
    line[10] = -line[0];
    for (int i = 0; i < 10; i++) {
        float a = line[i], c = line[i + 1], e = line[10];
        for (int k = 0; k < 10; k++) {
            float z0 = line[k], z1 = line[k + 1];
            int inside = i > 0 && i < 9 && k > 0 && k < 9;
            uint32_t material = !inside ? frame : (i + k) % 2 ? dark : light;     /* a1 is dark */
            ex_build_quad(b, v3_make(a, 0, z1), v3_make(c, 0, z1), v3_make(c, 0, z0), v3_make(a, 0, z0), material);
            ex_build_quad(b, v3_make(a, low, z0), v3_make(c, low, z0), v3_make(c, low, z1), v3_make(a, low, z1), frame);
        }
        ex_build_quad(b, v3_make(a, low, e), v3_make(c, low, e), v3_make(c, 0, e), v3_make(a, 0, e), frame);
        ex_build_quad(b, v3_make(c, low, -e), v3_make(a, low, -e), v3_make(a, 0, -e), v3_make(c, 0, -e), frame);
        ex_build_quad(b, v3_make(e, low, c), v3_make(e, low, a), v3_make(e, 0, a), v3_make(e, 0, c), frame);
        ex_build_quad(b, v3_make(-e, low, a), v3_make(-e, low, c), v3_make(-e, 0, c), v3_make(-e, 0, a), frame);
    }
    ex_build_object(b, "board", ex_build_finish(b));
}

static void place_piece(ex_builder *b, const uint32_t meshes[KINDS], uint32_t material, int kind, int file, int white)
{
    static const char *const names[KINDS] = {"pawn", "rook", "knight", "bishop", "queen", "king"};
    char name[32];
    int rank = (white ? 0 : 7) + (kind == PAWN ? (white ? 1 : -1) : 0);
    snprintf(name, sizeof name, "%s %s %c%d", white ? "white" : "black", names[kind], 'a' + file, rank + 1);
    ex_object *object = ex_build_object(b, name, meshes[kind]);
    /* White sits at +Z and plays towards -Z; the horses look at the enemy. */
    v3 position = v3_make(((float)file - 3.5f) * square, 0, (3.5f - (float)rank) * square);
    if (!object) return;
    ex_place(object->transform, position, white ? EX_PI / 2 : -EX_PI / 2, 1);
    object->material = 1 + material;
}

/* ---- the game ---- */

/* Objects stand as ex_build_chess makes them: the board, then for each file of white, and of black, piece and pawn. */
typedef struct chess_move { int white, pawn, file, to_file, to_rank; float lift; } chess_move;
static const chess_move game[] = {
    {1, 1, 4, 4, 3, 0}, {0, 1, 4, 4, 4, 0},                     /* e4 e5 */
    {1, 0, 6, 5, 2, 0.07f}, {0, 0, 1, 2, 5, 0.07f},             /* Nf3 Nc6 */
    {1, 0, 5, 2, 3, 0}, {0, 0, 5, 2, 4, 0},                     /* Bc4 Bc5 */
    {1, 1, 2, 2, 2, 0}, {0, 0, 6, 5, 5, 0.07f},                 /* c3 Nf6 */
    {1, 1, 3, 3, 2, 0}, {0, 1, 3, 3, 5, 0}};                    /* d3 d6 */
enum { MOVES = sizeof game / sizeof *game };

int ex_pose_chess(ex_scene *scene, float time)
{
    const float forth = 0.8f * MOVES, back = 0.25f * forth; /* seconds: a move takes 0.8, all of them back a quarter */
    float t = fmodf(fmaxf(time, 0), forth + back), played = (t < forth ? t / forth : (forth + back - t) / back) * MOVES;
    for (int i = 0; i < MOVES; i++) {
        const chess_move *m = &game[i];
        float *at = scene->objects[1 + (m->white ? 0 : 16) + 2 * m->file + m->pawn].transform + 12;
        int rank = (m->white ? 0 : 7) + (m->pawn ? (m->white ? 1 : -1) : 0);
        float u = ex_smooth(0, 1, played - (float)i);
        at[0] = ((float)m->file - 3.5f + u * (float)(m->to_file - m->file)) * square;
        at[1] = 4 * u * (1 - u) * m->lift;
        at[2] = (3.5f - (float)rank - u * (float)(m->to_rank - rank)) * square;
    }
    return 0;
}

void ex_build_chess(ex_builder *b)
{
    static const int back_rank[8] = {ROOK, KNIGHT, BISHOP, QUEEN, KING, BISHOP, KNIGHT, ROOK};
    uint32_t light = ex_build_material(b, 0.66f, 0.52f, 0.34f), dark = ex_build_material(b, 0.20f, 0.095f, 0.045f);
    uint32_t frame = ex_build_material(b, 0.12f, 0.055f, 0.028f);
    uint32_t white = ex_build_material(b, 0.74f, 0.66f, 0.50f), black = ex_build_material(b, 0.055f, 0.045f, 0.042f);
    add_board(b, light, dark, frame);
    uint32_t meshes[KINDS];
    for (int kind = 0; kind < KINDS; kind++) meshes[kind] = build_piece(b, kind, white);
    for (int side = 1; side >= 0; side--)
        for (int file = 0; file < 8; file++) {
            place_piece(b, meshes, side ? white : black, back_rank[file], file, side);
            place_piece(b, meshes, side ? white : black, PAWN, file, side);
        }
    if (b->failed || ex_scene_add_ground(b->scene) != 0) { b->failed = 1; return; }
    ex_build_camera(b, v3_make(0.34f, 0.36f, 0.56f), v3_make(0.01f, 0, 0.02f), 36);
}
