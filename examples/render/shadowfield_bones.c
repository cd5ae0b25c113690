/* shadowfield_bones.c - see shadowfield_parts.h: a mesh that deforms as rigid bodies, its bones, which follow it.

   Pieces of the mesh that hang together, or that a joint of a skin moves, become bones: small ones and those inside of
   others join them, long ones are cut across. Each hides light as its hull does, a closed convex body, and is moved in
   each frame by the rotation, shift and scale that bring its vertices nearest to where they are. */
#include "shadowfield_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { NORMALS = 400, ROWS = 20, COLUMNS = 28, MOST_CUTS = 16 };

static const float slender = 1.25f;     /* longer than so many times as wide: cut */
static const float overlap = 0.02f;     /* of a cut piece's length, by which its hull goes into the next: no slit */
static const float small_share = 0.04f; /* of the mesh's radius: smaller pieces join others that they touch */
static const float thin = 0.02f;        /* of a hull's radius: half as thick as it is at least, if it is of cloth */

/* A set of vertices, and how far it reaches along the normals of a hull. */
typedef struct piece { uint32_t *vertex; size_t count; float center[3], reach[NORMALS], radius; } piece;

static void normal_of(int i, float *n)
{
    float z = 1 - (2 * (float)i + 1) / NORMALS, r = sqrtf(1 - z * z), phi = 2.39996323f * (float)i;
    n[0] = r * cosf(phi), n[1] = z, n[2] = r * sinf(phi);
}

static float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void measure_piece(piece *p, const float *positions)
{
    double sum[3] = { 0, 0, 0 };
    p->radius = 0;
    for (size_t i = 0; i < p->count; i++)
        for (int k = 0; k < 3; k++)
            sum[k] += (double)positions[3 * (size_t)p->vertex[i] + (size_t)k];
    for (int k = 0; k < 3; k++)
        p->center[k] = (float)(sum[k] / (double)(p->count ? p->count : 1));
    for (int j = 0; j < NORMALS; j++) {
        float n[3];
        normal_of(j, n);
        p->reach[j] = 0;
        for (size_t i = 0; i < p->count; i++)
            p->reach[j] = fmaxf(p->reach[j], dot(n, positions + 3 * (size_t)p->vertex[i]) - dot(n, p->center));
        p->radius = fmaxf(p->radius, p->reach[j]);
    }
}

/* How far a point is outside of the hull, at least; negative inside. */
static float outside(const piece *p, const float *at)
{
    const float d[3] = { at[0] - p->center[0], at[1] - p->center[1], at[2] - p->center[2] };
    float most = -HUGE_VALF;
    for (int j = 0; j < NORMALS; j++) {
        float n[3];
        normal_of(j, n);
        most = fmaxf(most, dot(n, d) - p->reach[j]);
    }
    return most;
}

/* ---- symmetric matrices ---- */

/* Jacobi's method: the diagonal of a becomes the eigenvalues, columns of v the eigenvectors. n is 3 or 4. */
static void diagonalise(int n, double a[4][4], double v[4][4])
{
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            v[i][j] = i == j;
    for (int sweep = 0; sweep < 30; sweep++)
        for (int p = 0; p < n; p++)
            for (int q = p + 1; q < n; q++) {
                double theta, t, c, s;
                if (fabs(a[p][q]) < 1e-300)
                    continue;
                theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
                t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1));
                c = 1 / sqrt(t * t + 1), s = t * c;
                for (int k = 0; k < n; k++) {
                    double x = a[k][p], y = a[k][q];
                    a[k][p] = c * x - s * y, a[k][q] = s * x + c * y;
                }
                for (int k = 0; k < n; k++) {
                    double x = a[p][k], y = a[q][k];
                    a[p][k] = c * x - s * y, a[q][k] = s * x + c * y;
                    x = v[k][p], y = v[k][q];
                    v[k][p] = c * x - s * y, v[k][q] = s * x + c * y;
                }
            }
}

static int largest(int n, double a[4][4])
{
    int best = 0;
    for (int i = 1; i < n; i++)
        best = a[i][i] > a[best][best] ? i : best;
    return best;
}

/* ---- pieces ---- */

static uint32_t root_of(uint32_t *parent, uint32_t i)
{
    while (parent[i] != i)
        i = parent[i] = parent[parent[i]];
    return i;
}

typedef struct place_of { float p[3]; uint32_t vertex; } place_of;

static int by_place(const void *a, const void *b) { return memcmp(a, b, 3 * sizeof(float)); }

/* What the joints of a skin move; 0, or -1: out of memory. */
static int find_parts(const ex_mesh *mesh, uint32_t *parent)
{
    uint32_t *first = malloc(65536 * sizeof *first);
    if (!first)
        return -1;
    memset(first, 255, 65536 * sizeof *first);
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        uint32_t *of_part = &first[mesh->parts[i]];
        *of_part = *of_part == UINT32_MAX ? i : *of_part;
        parent[i] = *of_part;
    }
    free(first);
    return 0;
}

/* parent[i]: a vertex of the same piece; triangles and equal positions hang together. -1: out of memory. */
static int find_pieces(const ex_mesh *mesh, uint32_t *parent)
{
    place_of *order = malloc((mesh->vertex_count + (size_t)1) * sizeof *order);
    if (!order)
        return -1;
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        parent[i] = i;
        for (int k = 0; k < 3; k++)
            order[i].p[k] = mesh->positions[3 * (size_t)i + (size_t)k] + 0.0f;
        order[i].vertex = i;
    }
    for (size_t t = 0; t < 3 * (size_t)mesh->triangle_count; t++)
        parent[root_of(parent, mesh->indices[t])] = root_of(parent, mesh->indices[t - t % 3]);
    qsort(order, mesh->vertex_count, sizeof *order, by_place);
    for (uint32_t i = 1; i < mesh->vertex_count; i++)
        if (by_place(&order[i], &order[i - 1]) == 0)
            parent[root_of(parent, order[i].vertex)] = root_of(parent, order[i - 1].vertex);
    free(order);
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        parent[i] = root_of(parent, i);
    return 0;
}

/* Vertices by piece, in one array of which the first piece has the beginning; `number`: of each vertex, its piece.
   Returns how many pieces there are; 0: out of memory. */
static size_t gather_pieces(const ex_mesh *mesh, const uint32_t *parent, uint32_t *number, piece **out)
{
    const size_t count = mesh->vertex_count;
    uint32_t *vertex = malloc((count + 1) * sizeof *vertex);
    size_t pieces = 0, used = 0;
    for (size_t i = 0; i < count; i++)
        if (parent[i] == i)
            number[i] = (uint32_t)pieces++;
    for (size_t i = 0; i < count; i++)
        number[i] = number[parent[i]];
    *out = calloc(pieces + 1, sizeof **out);
    if (!vertex || !*out || !pieces) {
        free(vertex);
        return 0;
    }
    for (size_t i = 0; i < count; i++)
        (*out)[number[i]].count++;
    for (size_t i = 0; i < pieces; i++) {
        (*out)[i].vertex = vertex + used;
        used += (*out)[i].count;
        (*out)[i].count = 0;
    }
    for (size_t i = 0; i < count; i++) {
        piece *p = &(*out)[number[i]];
        p->vertex[p->count++] = (uint32_t)i;
    }
    for (size_t i = 0; i < pieces; i++)
        measure_piece(&(*out)[i], mesh->positions);
    return pieces;
}

static int by_radius(const void *a, const void *b)
{
    const piece *x = a, *y = b;
    return (x->radius < y->radius) - (x->radius > y->radius);
}

/* From the largest on: joins to a piece those whose middle lies in its hull, and small ones that touch it. */
static void join_pieces(const piece *p, size_t count, float radius, uint32_t *parent)
{
    for (size_t i = 1; i < count; i++) {
        size_t best = i;
        float nearest = HUGE_VALF;
        for (size_t j = 0; j < i; j++) {
            const float off = outside(&p[j], p[i].center);
            if (off < nearest && (off <= 0 || (p[i].radius < small_share * radius && off < p[i].radius)))
                nearest = off, best = j;
        }
        if (best != i)
            parent[root_of(parent, p[i].vertex[0])] = root_of(parent, p[best].vertex[0]);
    }
}

/* ---- bones ---- */

/* The longest principal axis of a piece, and how long and wide it is. */
static void axis_of(const piece *p, const float *positions, float *axis, float *from, float *to, float *wide)
{
    double a[4][4] = { { 0 } }, v[4][4];
    int best;
    *wide = 0;
    for (size_t i = 0; i < p->count; i++)
        for (int k = 0; k < 3; k++)
            for (int l = 0; l < 3; l++)
                a[k][l] += (double)(positions[3 * (size_t)p->vertex[i] + (size_t)k] - p->center[k]) *
                           (double)(positions[3 * (size_t)p->vertex[i] + (size_t)l] - p->center[l]);
    diagonalise(3, a, v);
    best = largest(3, a);
    for (int j = 0; j < 3; j++) {
        float low = HUGE_VALF, high = -HUGE_VALF, e[3] = { (float)v[0][j], (float)v[1][j], (float)v[2][j] };
        for (size_t i = 0; i < p->count; i++) {
            float at = dot(e, positions + 3 * (size_t)p->vertex[i]);
            low = fminf(low, at);
            high = fmaxf(high, at);
        }
        if (j == best) {
            memcpy(axis, e, sizeof e);
            *from = low, *to = high;
        } else {
            *wide = fmaxf(*wide, high - low);
        }
    }
}

/* A grid round the middle, drawn onto the planes of the hull. */
static int make_hull(sf_bone *bone, const piece *p)
{
    ex_mesh *mesh = &bone->hull;
    const uint32_t count = (ROWS + 1) * COLUMNS;
    uint32_t *i;
    float thinnest = HUGE_VALF;
    mesh->positions = malloc(3 * (size_t)count * sizeof *mesh->positions);
    mesh->indices = i = malloc(6 * (size_t)ROWS * COLUMNS * sizeof *mesh->indices);
    if (!mesh->positions || !mesh->indices)
        return -1;
    mesh->vertex_count = count;
    mesh->triangle_count = 2 * ROWS * COLUMNS;
    for (uint32_t row = 0; row <= ROWS; row++)
        for (uint32_t column = 0; column < COLUMNS; column++) {
            const float v = 3.14159265f * (float)row / ROWS, u = 6.28318531f * (float)column / COLUMNS;
            const float r = row == 0 || row == ROWS ? 0 : sinf(v), d[3] = { r * cosf(u), cosf(v), r * sinf(u) };
            const uint32_t a = row * COLUMNS + column, b = row * COLUMNS + (column + 1) % COLUMNS;
            float at = HUGE_VALF;
            for (int j = 0; j < NORMALS; j++) {
                float n[3], cosine;
                normal_of(j, n);
                cosine = dot(n, d);
                if (cosine > 0.05f)
                    at = fminf(at, fmaxf(p->reach[j], thin * p->radius) / cosine);
            }
            thinnest = fminf(thinnest, at);
            for (int k = 0; k < 3; k++)
                mesh->positions[3 * (size_t)a + (size_t)k] = p->center[k] + at * d[k];
            if (row == ROWS)
                continue;
            *i++ = a, *i++ = b, *i++ = b + COLUMNS;
            *i++ = a, *i++ = b + COLUMNS, *i++ = a + COLUMNS;
        }
    bone->inner = thinnest / p->radius;
    return 0;
}

/* Bone from vertices of a piece: own ones get its number, the hull reaches a little farther. */
static int add_bone(sf_bones *b, const ex_mesh *mesh, const piece *whole, const float *axis, float from, float to)
{
    const float slack = overlap * (to - from);
    piece part = { .vertex = malloc((whole->count + 1) * sizeof(uint32_t)) };
    sf_bone *bone = &b->bone[b->count];
    int good;
    if (!part.vertex)
        return -1;
    for (size_t i = 0; i < whole->count; i++) {
        const uint32_t v = whole->vertex[i];
        const float at = dot(axis, mesh->positions + 3 * (size_t)v);
        if (at >= from && at <= to)
            b->of_vertex[v] = (uint32_t)b->count;
        if (at >= from - slack && at <= to + slack)
            part.vertex[part.count++] = v;
    }
    if (!part.count) {
        free(part.vertex);
        return 0;
    }
    b->count++;
    measure_piece(&part, mesh->positions);
    bone->vertex = part.vertex;
    bone->vertex_count = part.count;
    bone->rest = malloc(3 * part.count * sizeof *bone->rest);
    good = bone->rest && make_hull(bone, &part) == 0;
    for (size_t i = 0; good && i < part.count; i++)
        memcpy(bone->rest + 3 * i, mesh->positions + 3 * (size_t)part.vertex[i], 3 * sizeof *bone->rest);
    return good ? 0 : -1;
}

/* Cuts what is long, in parts of one length. */
static int cut_pieces(sf_bones *b, const ex_mesh *mesh, const piece *p, size_t count)
{
    b->bone = calloc(MOST_CUTS * count + 1, sizeof *b->bone);
    if (!b->bone)
        return -1;
    for (size_t i = 0; i < count; i++) {
        float axis[3] = { 0, 0, 0 }, from = 0, to = 0, wide;
        int cuts;
        axis_of(&p[i], mesh->positions, axis, &from, &to, &wide);
        cuts = (int)fminf(ceilf((to - from) / fmaxf(slender * wide, 1e-6f * (to - from) + 1e-18f)), MOST_CUTS);
        for (int k = 0; k < cuts; k++) {
            const float low = from + (to - from) * (float)k / (float)cuts, slack = 1e-5f * (to - from);
            const float high = from + (to - from) * (float)(k + 1) / (float)cuts;
            if (add_bone(b, mesh, &p[i], axis, k ? low : low - slack, k + 1 < cuts ? high : high + slack) != 0)
                return -1;
        }
    }
    return 0;
}

int sf_bones_build(sf_bones *b, const ex_mesh *mesh)
{
    uint32_t *parent = malloc((mesh->vertex_count + (size_t)1) * sizeof *parent), *vertices = NULL;
    piece *p = NULL, whole = { .count = 0 };
    size_t count;
    int result = -1;
    memset(b, 0, sizeof *b);
    b->piece = malloc((mesh->vertex_count + (size_t)1) * sizeof *b->piece);
    b->of_vertex = malloc((mesh->vertex_count + (size_t)1) * sizeof *b->of_vertex);
    if (!parent || !b->piece || !b->of_vertex || (mesh->parts ? find_parts : find_pieces)(mesh, parent) != 0) {
        free(parent);
        sf_bones_free(b);
        return -1;
    }
    count = gather_pieces(mesh, parent, b->piece, &p);
    if (count) {
        vertices = p[0].vertex;
        whole.vertex = vertices;
        whole.count = mesh->vertex_count;
        measure_piece(&whole, mesh->positions);
        qsort(p, count, sizeof *p, by_radius);
        join_pieces(p, count, whole.radius, parent);
        for (uint32_t i = 0; i < mesh->vertex_count; i++)
            parent[i] = root_of(parent, i);
        free(p);
        free(vertices);
        p = NULL;
        count = gather_pieces(mesh, parent, b->of_vertex, &p);
        vertices = count ? p[0].vertex : NULL;
        result = count ? cut_pieces(b, mesh, p, count) : -1;
    }
    free(p);
    free(vertices);
    free(parent);
    if (result != 0)
        sf_bones_free(b);
    return result;
}

void sf_bones_free(sf_bones *b)
{
    for (size_t i = 0; i < b->count; i++) {
        free(b->bone[i].vertex);
        free(b->bone[i].rest);
        free(b->bone[i].hull.positions);
        free(b->bone[i].hull.indices);
        sfield_free(b->bone[i].occlusion);
        sfield_free(b->bone[i].self);
    }
    free(b->bone);
    free(b->of_vertex);
    free(b->piece);
    free(b->order);
    free(b->first);
    free(b->positions);
    free(b->normals);
    memset(b, 0, sizeof *b);
}

/* ---- points ---- */

int sf_bones_points(sf_bones *b, const sf_surface *s)
{
    const size_t n = s->chosen_count;
    b->order = malloc((n + 1) * sizeof *b->order);
    b->first = calloc(b->count + 2, sizeof *b->first);
    b->positions = malloc((3 * n + 1) * sizeof *b->positions);
    b->normals = malloc((3 * n + 1) * sizeof *b->normals);
    if (!b->order || !b->first || !b->positions || !b->normals)
        return -1;
    for (size_t i = 0; i < n; i++)
        b->first[b->of_vertex[s->corners[3 * (size_t)s->chosen[i]]] + 2]++;
    for (size_t k = 2; k < b->count + 2; k++)
        b->first[k] += b->first[k - 1];
    for (size_t i = 0; i < n; i++)
        b->order[b->first[b->of_vertex[s->corners[3 * (size_t)s->chosen[i]]] + 1]++] = (uint32_t)i;
    return 0;
}

uint32_t *sf_bone_triangles(const sf_bones *b, const ex_mesh *mesh, size_t bone, size_t *count)
{
    uint32_t *out = malloc((3 * (size_t)mesh->triangle_count + 1) * sizeof *out);
    *count = 0;
    for (size_t t = 0; out && t < mesh->triangle_count; t++) {
        const uint32_t *i = mesh->indices + 3 * t;
        if (b->of_vertex[i[0]] != bone && b->of_vertex[i[1]] != bone && b->of_vertex[i[2]] != bone)
            continue;
        memcpy(out + *count, i, 3 * sizeof *i);
        *count += 3;
    }
    return out;
}

/* ---- following ---- */

/* The rotation, scale and shift that bring `rest` nearest to the vertices (Horn 1987: the rotation is the quaternion
   with the largest eigenvalue). */
static void fit(sf_bone *bone, const float *positions)
{
    double from[3] = { 0 }, to[3] = { 0 }, s[3][3] = { { 0 } }, a[4][4], v[4][4], q[4], sizes[2] = { 0, 0 }, scale;
    const double n = (double)bone->vertex_count;
    for (size_t i = 0; i < bone->vertex_count; i++)
        for (int k = 0; k < 3; k++) {
            from[k] += (double)bone->rest[3 * i + (size_t)k] / n;
            to[k] += (double)positions[3 * (size_t)bone->vertex[i] + (size_t)k] / n;
        }
    for (size_t i = 0; i < bone->vertex_count; i++)
        for (int k = 0; k < 3; k++) {
            const double x = (double)bone->rest[3 * i + (size_t)k] - from[k];
            const double z = (double)positions[3 * (size_t)bone->vertex[i] + (size_t)k] - to[k];
            sizes[0] += x * x, sizes[1] += z * z;
            for (int l = 0; l < 3; l++)
                s[k][l] += x * ((double)positions[3 * (size_t)bone->vertex[i] + (size_t)l] - to[l]);
        }
    a[0][0] = s[0][0] + s[1][1] + s[2][2];
    for (int k = 0; k < 3; k++) {
        const int l = (k + 1) % 3, m = (k + 2) % 3;
        a[0][k + 1] = a[k + 1][0] = s[l][m] - s[m][l];
        a[k + 1][k + 1] = s[k][k] - s[l][l] - s[m][m];
        a[l + 1][m + 1] = a[m + 1][l + 1] = s[l][m] + s[m][l];
    }
    diagonalise(4, a, v);
    for (int k = 0, best = largest(4, a); k < 4; k++)
        q[k] = v[k][best];
    scale = sizes[0] > 0 ? sqrt(sizes[1] / sizes[0]) : 1;
    memset(bone->transform, 0, sizeof bone->transform);
    for (int k = 0; k < 3; k++) {
        const int l = (k + 1) % 3, m = (k + 2) % 3;
        bone->transform[5 * k] = (float)(scale * (1 - 2 * (q[l + 1] * q[l + 1] + q[m + 1] * q[m + 1])));
        bone->transform[4 * k + l] = (float)(scale * 2 * (q[k + 1] * q[l + 1] + q[0] * q[m + 1]));
        bone->transform[4 * k + m] = (float)(scale * 2 * (q[k + 1] * q[m + 1] - q[0] * q[l + 1]));
    }
    for (int k = 0; k < 3; k++) {
        bone->transform[12 + k] = (float)to[k];
        for (int l = 0; l < 3; l++)
            bone->transform[12 + k] -= bone->transform[4 * l + k] * (float)from[l];
    }
    bone->transform[15] = 1;
}

void sf_bones_follow(sf_bones *b, const ex_mesh *mesh, const sf_surface *s)
{
    for (size_t bone = 0; bone < b->count; bone++) {
        float *m = b->bone[bone].transform, square;
        fit(&b->bone[bone], mesh->positions);
        square = dot(m, m);
        for (size_t i = b->first[bone]; i < b->first[bone + 1]; i++) {
            const float *p = s->chosen_positions + 3 * (size_t)b->order[i];
            const float *n = s->chosen_normals + 3 * (size_t)b->order[i];
            const float from[3] = { p[0] - m[12], p[1] - m[13], p[2] - m[14] };
            for (int k = 0; k < 3; k++) {
                b->positions[3 * i + (size_t)k] = dot(m + 4 * k, from) / square;
                b->normals[3 * i + (size_t)k] = dot(m + 4 * k, n) / sqrtf(square);
            }
        }
    }
}
