/* draw_test - what an eye sees of a mesh, drawn sixteen triangles at a time by every kind of vectors there is, beside
   one that takes a triangle and a sample after the other; the same for rays out of the mesh. Meshes are nasty:
   slivers, flat and doubled triangles, vertices that are no numbers, counts on both sides of 16. All bits are equal. */
#define SFIELD_STATIC
#define SHADOWFIELD_IMPLEMENTATION
#include "shadowfield.h"
#include "util.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

enum { WIDTH = SFIELD__MOST_WIDTH, CELLS = 6 * 16 * 16 };

/* ---- one triangle and one sample at a time ---- */

typedef struct twin {
    uint8_t  hit[6 * WIDTH * WIDTH];
    float    depth[6 * WIDTH * WIDTH];
    uint32_t owner[6 * WIDTH * WIDTH];      /* the triangle + 1; topmost bit: its dark side */
    uint32_t width;
} twin;

static twin one_by_one;

static float least(float a, float b, float c) { return a < b ? (a < c ? a : c) : b < c ? b : c; }
static float largest(float a, float b, float c) { return a > b ? (a > c ? a : c) : b > c ? b : c; }

static int box_of(const float x[3], const float y[3], uint32_t width, int box[4])
{
    const float most = (float)width - 1;
    const float x0 = fmaxf(least(x[0], x[1], x[2]) - 0.01f, 0), y0 = fmaxf(least(y[0], y[1], y[2]) - 0.01f, 0);
    const float x1 = fminf(largest(x[0], x[1], x[2]) + 0.01f, most);
    const float y1 = fminf(largest(y[0], y[1], y[2]) + 0.01f, most);
    if (!(x0 <= x1 && y0 <= y1)) return 0;
    box[0] = (int)ceilf(x0);
    box[1] = (int)ceilf(y0);
    box[2] = (int)x1;
    box[3] = (int)y1;
    return box[0] <= box[2] && box[1] <= box[3];
}

/* The samples of row y that lie inside all edges. */
static int span_of(float edge[3][3], float half, int y, const int box[4], int *x0, int *x1)
{
    const float t = ((float)y + 0.5f) / half - 1;
    float low = (float)box[0], high = (float)box[2];
    int i;
    for (i = 0; i < 3; i++) {
        const float c = edge[i][1] * t + edge[i][2];
        if (edge[i][0] == 0) {
            if (c < 0) return 0;
        } else {
            const float inverse = 1 / edge[i][0], x = (1 - c * inverse) * half - 0.5f;
            if (edge[i][0] > 0) low = x > low ? x : low;
            else high = x < high ? x : high;
        }
    }
    if (!(low <= high)) return 0;
    *x0 = (int)ceilf(low);
    *x1 = (int)high;
    return *x0 <= *x1;
}

static void draw_on_face(twin *w, float q[3][3], uint32_t face, const int box[4], uint32_t owner)
{
    const float half = 0.5f * (float)w->width;
    float edge[3][3], sum[3], det, far;
    int i, k, x, y, x0, x1;
    for (i = 0; i < 3; i++)
        for (k = 0; k < 3; k++)
            edge[i][k] = q[i][(k + 1) % 3] * q[(i + 1) % 3][(k + 2) % 3] -
                         q[i][(k + 2) % 3] * q[(i + 1) % 3][(k + 1) % 3];
    det = q[2][0] * edge[0][0] + q[2][1] * edge[0][1] + q[2][2] * edge[0][2];
    if (det == 0) return;
    for (i = 0; i < 9 && det < 0; i++) edge[i / 3][i % 3] = -edge[i / 3][i % 3];
    for (k = 0; k < 3; k++) sum[k] = edge[0][k] + edge[1][k] + edge[2][k];
    far = det > 0 ? det : -1.00001f * det;
    for (y = box[1]; y <= box[3]; y++) {
        if (!span_of(edge, half, y, box, &x0, &x1)) continue;
        for (x = x0; x <= x1; x++) {
            const size_t at = ((size_t)face * w->width + (size_t)y) * w->width + (size_t)x;
            const float close = (sum[0] * (((float)x + 0.5f) / half - 1) + sum[1] * (((float)y + 0.5f) / half - 1) +
                                 sum[2]) / far;
            w->hit[at] = 1;
            if (!(close > w->depth[at])) continue;
            w->depth[at] = close;
            w->owner[at] = owner | (det < 0 ? 0x80000000u : 0);
        }
    }
}

/* On its face alone where all corners lie on one; otherwise on each whose pyramid it may touch. */
static void draw_one(twin *w, float p[3][3], uint32_t owner)
{
    const float half = 0.5f * (float)w->width;
    const uint32_t first = sfield__face_of(p[0]);
    int alone = first == sfield__face_of(p[1]) && first == sfield__face_of(p[2]);
    uint32_t face, i;
    for (i = 0; i < 3; i++)
        alone = alone && (p[i][first / 2] > 0 || p[i][first / 2] < 0);
    for (face = 0; face < 6; face++) {
        float q[3][3], x[3], y[3];
        int box[4] = { 0, 0, (int)w->width - 1, (int)w->width - 1 }, out[4] = { 0, 0, 0, 0 }, before = 0;
        for (i = 0; i < 3; i++) {
            sfield__to_face(face, p[i], q[i]);
            out[0] += q[i][0] > q[i][2];
            out[1] += -q[i][0] > q[i][2];
            out[2] += q[i][1] > q[i][2];
            out[3] += -q[i][1] > q[i][2];
            before += q[i][2] > 0;
            x[i] = alone ? q[i][0] * (half / q[i][2]) + half - 0.5f : q[i][0] / q[i][2] * half + (half - 0.5f);
            y[i] = alone ? q[i][1] * (half / q[i][2]) + half - 0.5f : q[i][1] / q[i][2] * half + (half - 0.5f);
        }
        if (alone ? face != first : out[0] == 3 || out[1] == 3 || out[2] == 3 || out[3] == 3 || before == 0) continue;
        if (before == 3 && !box_of(x, y, w->width, box)) continue;
        draw_on_face(w, q, face, box, owner);
    }
}

/* Fills texels from every triangle in its order. */
static void see_one_by_one(const sfield__build *b, const sfield__view *v, const float *eye, float *texel)
{
    const uint32_t n = b->h.cube_side, s = v->scale, width = v->width;
    twin *w = &one_by_one;
    uint32_t i, k, c, x, y;
    size_t t;
    memset(w, 0, sizeof *w);
    memset(texel, 0, b->h.channels * b->cells * sizeof *texel);
    w->width = width;
    for (t = 0; t < b->triangles; t++) {
        float p[3][3];
        for (k = 0; k < 3; k++)
            for (c = 0; c < 3; c++) p[k][c] = b->position[3 * (size_t)b->index[3 * t + k] + c] - eye[c];
        draw_one(w, p, b->original[t] + 1);
    }
    for (i = 0; i < 6; i++)
        for (y = 0; y < width; y++)
            for (x = 0; x < width; x++) {
                const size_t at = ((size_t)i * width + y) * width + x;
                float *to = texel + sfield__texel_number(n, i, x / s, y / s);
                const uint32_t owner = w->owner[at];
                if (!v->depth) *to += w->hit[at];               /* whole numbers, divided below */
                for (c = 0; v->depth && c < 3 && owner && owner >> 31 == 0; c++)
                    to[c * b->cells] += b->radiance[3 * (size_t)(owner - 1) + c] / (float)(s * s);
            }
    for (i = 0; i < b->cells && !v->depth; i++) texel[i] /= (float)(s * s);
}

/* ---- nasty meshes ---- */

static void corner(model *m, size_t i, float x, float y, float z)
{
    m->p[3 * i] = x;
    m->p[3 * i + 1] = y;
    m->p[3 * i + 2] = z;
}

/* Triangles without a shared vertex: slivers, flat ones, copies in both windings, small ones, one with a vertex at the
   middle, corners on the planes where faces of the cube meet, no numbers. */
static model nasty(uint32_t triangles, uint64_t seed)
{
    model m = model_soup(triangles, 0.3, seed);
    uint32_t t, k;
    for (t = 0; t < triangles; t++) {
        float *p = m.p + 9 * t;
        switch (rnd_below(&seed, 10)) {
        case 0:                                                 /* a sliver */
            for (k = 0; k < 3; k++) p[6 + k] = p[k] + (p[3 + k] - p[k]) * 0.5f + rnd_in(&seed, -1e-6, 1e-6);
            break;
        case 1:                                                 /* a line */
            for (k = 0; k < 3; k++) p[6 + k] = 2 * p[3 + k] - p[k];
            break;
        case 2:                                                 /* the triangle before, from the other side */
            for (k = 0; t && k < 3; k++) memcpy(p + 3 * k, p - 3 - 3 * (int)k, 3 * sizeof *p);
            break;
        case 3:                                                 /* the same again */
            if (t) memcpy(p, p - 9, 9 * sizeof *p);
            break;
        case 4:                                                 /* a speck */
            for (k = 3; k < 9; k++) p[k] = p[k % 3] + rnd_in(&seed, -0.004, 0.004);
            break;
        case 5:                                                 /* corners where faces meet */
            for (k = 0; k < 3; k++) corner(&m, 3 * t + k, k == 1 ? 0.5f : -0.5f, k == 2 ? 0.5f : -0.5f, 0.5f);
            break;
        case 6:
            p[rnd_below(&seed, 9)] = rnd_below(&seed, 2) ? (float)NAN : (float)INFINITY;
            break;
        case 7:                                                 /* along an axis */
            p[4] = p[1], p[3] = p[0], p[8] = p[2];
            break;
        case 8: corner(&m, 3 * t + rnd_below(&seed, 3), 0, 0, 0); break;
        default:                                /* an edge along samples, corners on others, seen from the middle */
            for (k = 0; k < 3; k++) {
                const uint32_t x = rnd_below(&seed, 64), y = rnd_below(&seed, 64);
                const float z = rnd_in(&seed, 0.1, 0.9), s = ((float)x + 0.5f) / 32 - 1;
                corner(&m, 3 * t + k, k == 1 ? p[0] / p[2] * z : z * s, z * (((float)y + 0.5f) / 32 - 1), z);
            }
            break;
        }
    }
    corner(&m, 0, 0.9f, 0.1f, 0.2f);                            /* one at least can be used */
    corner(&m, 1, -0.3f, 0.8f, 0.1f);
    corner(&m, 2, -0.2f, -0.1f, 0.7f);
    return m;
}

typedef struct scene {
    sfield__build b;
    model         m;
    float        *radiance;
} scene;

static void open_scene(scene *s, sfield__what what, uint32_t side, model m, uint64_t seed)
{
    const sfield__kind kind = what == SFIELD__EMISSIVE ? SFIELD__KIND_SOURCE : SFIELD__KIND_OCCLUSION;
    const sfield_mesh mesh = mesh_of(&m);
    sfield_desc d;
    size_t i;
    memset(&d, 0, sizeof d);
    d.cube_side = side;
    d.radius = 2;
    s->m = m;
    assert_int_equal(sfield__read_desc(&s->b, &d, kind, "draw_test"), SFIELD_OK);
    s->b.what = what;
    assert_int_equal(sfield__take_mesh(&s->b, &mesh), SFIELD_OK);
    assert_int_equal(sfield__prepare_build(&s->b), SFIELD_OK);
    s->radiance = (float *)malloc(m.indices * sizeof(float));
    assert_non_null(s->radiance);
    for (i = 0; i < m.indices; i++) s->radiance[i] = rnd_in(&seed, 0, 9);
    s->b.radiance = s->radiance;
}

static void close_scene(scene *s)
{
    sfield__release_build(&s->b);
    model_free(&s->m);
    free(s->radiance);
}

/* Eyes far and near, within the mesh, on its vertices and on the axes. */
static void eye_of(const scene *s, uint64_t *seed, uint32_t i, float eye[3])
{
    const double far = i % 4 == 0 ? 8 : i % 4 == 1 ? 2 : 0.4;
    uint32_t k, at = rnd_below(seed, (uint32_t)s->m.vertices);
    for (k = 0; k < 3; k++) eye[k] = rnd_in(seed, -far, far);
    if (i % 4 == 3) memcpy(eye, s->b.position + 3 * (size_t)at, 3 * sizeof *eye);
    if (i % 8 == 6) eye[i % 3] = 0;
    if (i == 0) memset(eye, 0, 3 * sizeof *eye);
}

static void compare_views(scene *s, uint64_t seed, uint32_t eyes, uint32_t *drawn)
{
    static float expected[3 * CELLS];
    const size_t bytes = s->b.h.channels * s->b.cells * sizeof(float);
    sfield__view *v = &s->b.view[0];
    uint32_t i, k;
    for (i = 0; i < eyes; i++) {
        float eye[3];
        int simd;
        eye_of(s, &seed, i, eye);
        for (simd = 0; simd <= sfield__simd_level(); simd++) {
            s->b.simd = simd;
            sfield__view_from(&s->b, v, eye);
            if (!simd) see_one_by_one(&s->b, v, eye, expected);
            for (k = 0; k < bytes / sizeof(float); k++) {
                if (!(v->texel[k] == expected[k]))
                    fail_msg("eye %u, kind of vectors %d, texel %u: %.9g, one by one %.9g", (unsigned)i, simd,
                             (unsigned)k, (double)v->texel[k], (double)expected[k]);
                *drawn += !simd && v->texel[k] > 0;
            }
        }
    }
}

static void sixteen_triangles_cover_what_each_covers(void **state)
{
    static const uint32_t counts[] = { 1, 2, 15, 16, 17, 31, 33, 64, 257 }, sides[] = { 4, 8, 16 };
    uint32_t i, k, drawn = 0;
    (void)state;
    for (i = 0; i < sizeof counts / sizeof *counts; i++)
        for (k = 0; k < 3; k++) {
            scene s;
            open_scene(&s, SFIELD__MESH, sides[k], nasty(counts[i], 31 * i + k), i);
            compare_views(&s, 7 * i + k, counts[i] < 200 ? 8 : 16, &drawn);
            close_scene(&s);
        }
    assert_true(drawn > 10000);
}

static void the_nearest_of_sixteen_shines(void **state)
{
    static const uint32_t counts[] = { 1, 16, 35, 150 };
    uint32_t i, drawn = 0;
    (void)state;
    for (i = 0; i < sizeof counts / sizeof *counts; i++) {
        scene s;
        open_scene(&s, SFIELD__EMISSIVE, i & 1 ? 8 : 16, nasty(counts[i], 77 + i), i);
        compare_views(&s, i, 12, &drawn);
        close_scene(&s);
    }
    assert_true(drawn > 5000);
}

/* All triangles lie over one another: the first shines, in whatever order they are drawn. */
static void of_equal_triangles_the_first_shines(void **state)
{
    uint32_t k, t, drawn = 0;
    (void)state;
    for (k = 0; k < 2; k++) {
        scene s;
        model m = model_soup(40, 0, 1);
        for (t = 0; t < 40; t++) {                              /* over several faces: these wait for others */
            const float z = k ? 0.5f : 0.05f;
            corner(&m, 3 * t, -0.4f, -0.3f, z);
            corner(&m, 3 * t + 1, 0.4f, -0.3f, t % 5 ? z : 2 * z);
            corner(&m, 3 * t + 2, 0, 0.4f, z);
        }
        open_scene(&s, SFIELD__EMISSIVE, 8, m, 3);
        compare_views(&s, k, 12, &drawn);
        close_scene(&s);
    }
    assert_true(drawn > 150);
}

/* Every number of samples that a texel's side may have. */
static void samples_are_counted_for_every_side(void **state)
{
    static const uint32_t sides[] = { 4, 8, 16, 32, 64 };
    static uint64_t bits[6 * 512 * 8];
    static uint8_t touched_before[6 * WIDTH];
    uint64_t seed = 4;
    uint32_t i, width, sums = 0;
    (void)state;
    for (i = 0; i < 5; i++)
        for (width = sides[i] < 64 ? 64 : sides[i]; width <= 512 && width <= 64 * sides[i]; width *= 2) {
            scene s;
            sfield__view *v;
            uint32_t k, x, y, f;
            open_scene(&s, SFIELD__MESH, sides[i], nasty(3, i), i);
            v = &s.b.view[0];
            v->width = width;
            v->scale = width / sides[i];
            memset(v->texel, 0, s.b.cells * sizeof(float));
            for (k = 0; k < 6 * width * width / 64; k++) {
                const uint32_t row = k * 64 / width;
                v->bits[k] = row % 3 == 1 ? ~(uint64_t)0 : (uint64_t)rnd_u32(&seed) << 32 | rnd_u32(&seed);
                if (row / v->scale % 7 == 5) v->bits[k] = 0;    /* rows of texels without anything */
                v->touched[row] |= v->bits[k] != 0;
            }
            memcpy(bits, v->bits, (size_t)6 * width * width / 8);
            sfield__count_samples(&s.b, v);
            for (f = 0; f < 6; f++)
                for (k = 0; k < sides[i] * sides[i]; k++) {
                    uint32_t sum = 0;
                    for (y = k / sides[i] * v->scale; y < (k / sides[i] + 1) * v->scale; y++)
                        for (x = k % sides[i] * v->scale; x < (k % sides[i] + 1) * v->scale; x++)
                            sum += (uint32_t)(bits[((f * width + y) * width + x) / 64] >> x % 64 & 1);
                    sums += sum > 0;
                    if (v->texel[sfield__texel_number(sides[i], f, k % sides[i], k / sides[i])] !=
                        (float)sum / (float)(v->scale * v->scale))
                        fail_msg("side %u, width %u: texel %u of face %u", sides[i], width, k, f);
                }
            assert_memory_equal(v->touched, touched_before, sizeof touched_before);     /* all is clear again */
            memset(bits, 0, sizeof bits);
            assert_memory_equal(v->bits, bits, (size_t)6 * width * width / 8);
            close_scene(&s);
        }
    assert_true(sums > 10000);
}

/* ---- rays out of the mesh ---- */

static void cross_one_by_one(const sfield__build *b, const float *eye, sfield__inside_ray *ray)
{
    size_t t;
    int i, k;
    for (t = 0; t < b->triangles; t++) {
        sfield__v3 p[3], n[3], all;
        uint32_t face[3];
        int one_face;
        float det;
        for (k = 0; k < 3; k++) {
            p[k] = sfield__v3_sub(sfield__v3_load(b->position + 3 * (size_t)b->index[3 * t + (size_t)k]),
                                  sfield__v3_load(eye));
            face[k] = sfield__face_of(&p[k].x);
        }
        one_face = face[0] == face[1] && face[0] == face[2];
        for (k = 0; k < 3; k++) n[k] = sfield__v3_cross(p[k], p[(k + 1) % 3]);
        det = sfield__v3_dot(n[0], p[2]);
        if (det == 0) continue;
        for (k = 0; k < 3 && det < 0; k++) n[k] = sfield__v3_scale(n[k], -1);
        all = sfield__v3_add(sfield__v3_add(n[0], n[1]), n[2]);
        for (i = 0; i < SFIELD__INSIDE_RAYS; i++) {
            const sfield__v3 d = sfield__v3_load(ray[i].d);
            if (one_face && face[0] != ray[i].face) continue;
            if (sfield__v3_dot(n[0], d) > 0 && sfield__v3_dot(n[1], d) > 0 && sfield__v3_dot(n[2], d) > 0)
                sfield__add_crossing(&ray[i], fabsf(det) / sfield__v3_dot(all, d), det > 0);
        }
    }
}

static void rays_meet_sixteen_triangles_as_they_meet_each(void **state)
{
    static const uint32_t counts[] = { 1, 15, 16, 17, 33, 300, 8000 };
    uint64_t seed = 8;
    uint32_t i, k, r, met = 0, full = 0;
    int simd;
    (void)state;
    for (i = 0; i < sizeof counts / sizeof *counts; i++) {
        scene s;
        open_scene(&s, SFIELD__MESH, 8, nasty(counts[i], 5 + i), i);
        for (k = 0; k < 8; k++) {
            sfield__inside_ray expected[SFIELD__INSIDE_RAYS], ray[SFIELD__INSIDE_RAYS];
            float eye[3];
            eye_of(&s, &seed, k, eye);
            memset(expected, 0, sizeof expected);
            sfield__aim_rays(eye, expected);
            cross_one_by_one(&s.b, eye, expected);
            for (simd = 0; simd <= sfield__simd_level(); simd++) {
                memset(ray, 0, sizeof ray);
                sfield__aim_rays(eye, ray);
                s.b.simd = simd;
                sfield__find_crossings16(&s.b, eye, ray);
                for (r = 0; r < SFIELD__INSIDE_RAYS; r++) {
                    assert_int_equal(ray[r].count, expected[r].count);
                    assert_int_equal(ray[r].winding, expected[r].winding);
                    assert_memory_equal(ray[r].at, expected[r].at, sizeof ray[r].at);
                    met += !simd && ray[r].count > 0;
                    full += !simd && ray[r].count == SFIELD__CROSSINGS;
                }
            }
        }
        close_scene(&s);
    }
    assert_true(met > 250 && full > 20);
}

/* ---- whole fields ---- */

static size_t build_with(int simd, sfield__what what, sfield_basis basis, const model *m, const float *radiance,
                         uint8_t **bytes)
{
    const sfield_mesh mesh = mesh_of(m);
    sfield_desc d = small_desc(basis);
    sfield_stats stats;
    sfield_field *f = NULL;
    sfield__build b;
    size_t size;
    d.radius = 0;
    assert_int_equal(sfield__read_desc(&b, &d, what == SFIELD__MESH ? SFIELD__KIND_OCCLUSION : SFIELD__KIND_SOURCE, ""),
                     SFIELD_OK);
    b.what = what;
    b.radiance = radiance;
    b.simd = simd;
    assert_int_equal(sfield__take_mesh(&b, &mesh), SFIELD_OK);
    assert_int_equal(sfield__run_build(&b, &f, &stats), SFIELD_OK);
    sfield__release_build(&b);
    size = sfield_bytes(f);
    *bytes = (uint8_t *)malloc(size);
    assert_non_null(*bytes);
    assert_int_equal(sfield_write(f, *bytes, size), SFIELD_OK);
    sfield_free(f);
    return size;
}

static void fields_have_the_same_bytes_by_all_vectors(void **state)
{
    static float radiance[3 * 200];
    uint64_t seed = 6;
    uint32_t i;
    (void)state;
    for (i = 0; i < 600; i++) radiance[i] = rnd_in(&seed, 0, 5);
    for (i = 0; i < 6; i++) {
        const sfield_basis basis = i & 1 ? SFIELD_BASIS_HAAR : SFIELD_BASIS_SH;
        const sfield__what what = i < 4 ? SFIELD__MESH : SFIELD__EMISSIVE;
        model m = i < 2 ? model_sphere(9, 7, 1) : nasty(150 + i, i);    /* the sphere has an inside */
        uint8_t *plain, *vectors;
        const size_t size = build_with(0, what, basis, &m, radiance, &plain);
        int simd;
        for (simd = 1; simd <= sfield__simd_level(); simd++) {
            assert_int_equal(build_with(simd, what, basis, &m, radiance, &vectors), size);
            assert_memory_equal(vectors, plain, size);
            free(vectors);
        }
        free(plain);
        model_free(&m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sixteen_triangles_cover_what_each_covers),
        cmocka_unit_test(the_nearest_of_sixteen_shines),
        cmocka_unit_test(of_equal_triangles_the_first_shines),
        cmocka_unit_test(samples_are_counted_for_every_side),
        cmocka_unit_test(rays_meet_sixteen_triangles_as_they_meet_each),
        cmocka_unit_test(fields_have_the_same_bytes_by_all_vectors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
