/* gl_scatter_test - surfels that glbk_ism_scatter scatters: counts of triangles in closed form, solid angles and shares
   against formulas of their own, and against ism_scatter for the same random numbers, every surfel equal but where
   the step of a sum lies within rounding, and those counted; a frame that asks GL for nothing. */
#define _POSIX_C_SOURCE 200809L
#include "ism.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend/gl_ism.h"

#define CONFORM_BACKEND "gl"
#include "conformance.h"
#include "gl_test.h"
#include "gl_count.h"
#include "gl_says.h"
#include "util.h"
#include "gl_util.h"

enum { WIDTH = 48, HEIGHT = 40, PIXELS = WIDTH * HEIGHT, VPLS = 24, MOST = 120000 };

/* A scene: a wavy sheet of triangles of many sizes above receivers, some pixels without any, and VPLs below. */
typedef struct scene {
    float      positions[9 * MOST];
    float      places[3 * PIXELS], normals[3 * PIXELS];
    float      vpl_places[3 * VPLS], vpl_normals[3 * VPLS], fluxes[3 * VPLS];
    ism_mesh   mesh;
    ism_points view;
    ism_source source;
} scene;

static scene *scene_make(uint32_t triangles)
{
    static scene s;         /* large */
    uint32_t seed = 5, i;
    int k;
    assert_true(triangles <= MOST);
    memset(&s, 0, sizeof s);
    for (i = 0; i < triangles; i++) {
        const float size = (0.2f + util_unit(&seed)) / sqrtf((float)triangles);
        const float x = util_unit(&seed), z = util_unit(&seed), y = 1 + 0.2f * sinf(9 * x) * cosf(7 * z);
        for (k = 0; k < 9; k++)
            s.positions[9 * (size_t)i + (size_t)k] =
                (k % 3 == 0 ? x : k % 3 == 1 ? y : z) + size * (util_unit(&seed) - 0.5f);
        if (i % 11 == 3) memcpy(s.positions + 9 * (size_t)i + 3, s.positions + 9 * (size_t)i, 12);      /* no area */
    }
    for (i = 0; i < PIXELS; i++) {
        s.places[3 * i] = (float)(i % WIDTH) / WIDTH;
        s.places[3 * i + 1] = 0.05f * util_unit(&seed);
        s.places[3 * i + 2] = (float)(i / WIDTH) / HEIGHT;
        s.normals[3 * i + 1] = i % 5 == 0 ? 0.0f : 1.0f;
    }
    for (i = 0; i < VPLS; i++) {
        s.vpl_places[3 * i] = util_unit(&seed);
        s.vpl_places[3 * i + 1] = 0.1f + 0.5f * util_unit(&seed);
        s.vpl_places[3 * i + 2] = util_unit(&seed);
        s.vpl_normals[3 * i + 1] = 1;
        for (k = 0; k < 3; k++) s.fluxes[3 * i + (size_t)k] = i % 3 ? 1.0f : 8.0f;
    }
    s.mesh.positions = s.positions;
    s.mesh.vertex_count = 3 * (size_t)triangles;
    s.view.count = PIXELS;
    s.view.width = WIDTH;
    s.view.positions = s.places;
    s.view.normals = s.normals;
    s.source.width = VPLS;
    s.source.height = 1;
    s.source.positions = s.vpl_places;
    s.source.normals = s.vpl_normals;
    s.source.fluxes = s.fluxes;
    s.source.scattered = 1;
    return &s;
}

static ism_desc small(ism_spread spread)
{
    ism_desc d;
    memset(&d, 0, sizeof d);
    d.vpl_count = VPLS;
    d.surfel_count = 500;       /* the phases of 63 each leave some without a surfel */
    d.tile_side = 16;
    d.near_point_count = -1;
    d.spread = spread;
    d.importance = ISM_IMPORTANCE_FLUX;
    return d;
}

/* The maps of both sides with the same VPLs, and what scatters on the GPU. */
typedef struct both {
    ism_desc        desc;
    ism_maps       *cpu;
    ism_frame       frame;
    glbk_ism_maps   maps;
    glbk_ism_spread spread;
    glbk_gbuffer    seen;
} both;

static void both_make(gl_test *t, const scene *s, const ism_desc *d, both *b)
{
    memset(b, 0, sizeof *b);
    b->desc = *d;
    b->frame.mesh = &s->mesh;
    b->frame.points = &s->view;
    b->frame.sources = &s->source;
    b->frame.source_count = 1;
    assert_int_equal(ism_create(d, &b->cpu), ISM_OK);
    gl_see(&t->gl, WIDTH, HEIGHT, s->places, s->normals, NULL, &b->seen);
    assert_glbk(t, glbk_ism_maps_create(&t->gl, d, &b->maps));
    assert_glbk(t, glbk_ism_mesh_upload(&t->gl, &b->maps, &s->mesh));
    assert_glbk(t, glbk_ism_spread_create(&t->gl, &b->maps, &b->spread));
}

static void both_scatter(gl_test *t, both *b, uint32_t index)
{
    const ism_vpl *v;
    ism_info info;
    size_t n;
    b->frame.index = index;
    assert_int_equal(ism_choose(b->cpu, &b->frame), ISM_OK);
    assert_int_equal(ism_scatter(b->cpu, &b->frame), ISM_OK);
    v = ism_vpls(b->cpu, &n);
    ism_get_info(b->cpu, &info);
    assert_glbk(t, glbk_ism_vpls_upload(&t->gl, &b->maps, v, (uint32_t)n, &info));
    assert_glbk(t, glbk_ism_scatter(&t->gl, &b->spread, &b->maps, &b->seen, index));
}

static void both_free(gl_test *t, both *b)
{
    glbk_ism_spread_free(&t->gl, &b->spread);
    glbk_ism_spread_free(&t->gl, &b->spread);
    glbk_ism_maps_free(&t->gl, &b->maps);
    glbk_gbuffer_free(&t->gl, &b->seen);
    ism_free(b->cpu);
}

/* The surfels of a phase, as ism_phase_surfels lists them. */
static ism_surfel *read_phase(gl_test *t, const both *b, uint32_t phase, size_t *count)
{
    const glbk_ism_maps *m = &b->maps;
    const size_t first = m->compute ? (size_t)phase * m->phase_surfel_count * VPLS : 0;
    const size_t n = (size_t)m->phase_surfel_count * VPLS, rows = (first + n + 1023) / 1024;
    uint32_t *words = (uint32_t *)malloc(16 * 1024 * rows);
    ism_surfel *out = (ism_surfel *)malloc(n * sizeof *out);
    glbk_target_desc of;
    glbk_target target;
    assert_non_null(words);
    assert_non_null(out);
    assert_true(rows <= 1024);
    memset(&of, 0, sizeof of);
    of.color[0] = m->compute ? &m->surfels : &m->phase_surfels[phase];
    assert_glbk(t, glbk_target_create(&t->gl, &of, &target));
    assert_glbk(t, glbk_target_read(&t->gl, &target, 0, 0, 0, 1024, (uint32_t)rows, words));
    glbk_target_free(&t->gl, &target);
    memcpy(out, words + 4 * first, n * sizeof *out);
    free(words);
    *count = n;
    return out;
}

/* ---- closed form ---- */

/* The surfels of the only triangle: 12,000 places, whose mean is the centroid but for 3 sigma of independent ones. */
static void triangle_is_sampled_evenly(const ism_surfel *surfels, size_t n)
{
    double mean[2] = { 0, 0 }, quarter = 0, outside = 0;
    size_t i;
    for (i = 0; i < n; i++) {
        const double a = (double)surfels[i].barycentric[0], c = (double)surfels[i].barycentric[1];
        outside += !(a >= 0 && c >= 0 && a + c <= 1);
        mean[0] += a / (double)n;
        mean[1] += c / (double)n;
        quarter += (a + c < 0.5) / (double)n;
    }
    CONFORM("T51", "samples outside the triangle, on the GPU", 0, outside, 0);
    CONFORM("T51", "centroid, first coordinate, on the GPU", 1.0 / 3, mean[0], 0.0065);
    CONFORM("T51", "centroid, second coordinate, on the GPU", 1.0 / 3, mean[1], 0.0065);
    CONFORM("T51", "share of a quarter of the triangle, on the GPU", 0.25, quarter, 0.012);
}

/* By area each surfel is one of n equal parts of the whole area: a triangle with a share p has p n surfels, but for
   one at each end, and a surfel stands for the area over n. */
static void surfels_by_area_are_even(void **state)
{
    GL_TEST(t, state)
    static const uint32_t counts[] = { 1, 2, 33, 700, 1500 };
    size_t c, i, j, n;
    for (c = 0; c < sizeof counts / sizeof counts[0]; c++) {
        const uint32_t triangles = counts[c];
        scene *s = scene_make(triangles);
        ism_desc d = small(ISM_SPREAD_AREA);
        double *share = (double *)calloc(triangles, sizeof *share), all = 0, worst = 0, off = 0;
        uint32_t *has = (uint32_t *)calloc(triangles, sizeof *has);
        both b;
        assert_non_null(share);
        assert_non_null(has);
        for (i = 0; i < triangles; i++) {
            /* one shape, 1 + i % 4 times as large as the least, so that areas are known without a root */
            const float size = 1 + (float)(i % 4);
            const float corners[9] = { 0, 0, 0, size, 0, 0, 0, 0, 1 };
            memcpy(s->positions + 9 * i, corners, sizeof corners);
            share[i] = (double)size;
            all += share[i];
        }
        d.lazy_frames = 1;
        both_make(t, s, &d, &b);
        assert_glbk(t, glbk_ism_scatter(&t->gl, &b.spread, &b.maps, NULL, 3));      /* no picture, and no VPLs */
        {
            ism_surfel *surfels = read_phase(t, &b, 0, &n);
            assert_int_equal(n, (size_t)VPLS * d.surfel_count);
            if (triangles == 1) triangle_is_sampled_evenly(surfels, n);
            for (j = 0; j < VPLS; j++) {
                memset(has, 0, triangles * sizeof *has);
                for (i = 0; i < d.surfel_count; i++) {
                    const ism_surfel *p = surfels + j * d.surfel_count + i;
                    assert_true(p->triangle < triangles);
                    assert_true(p->barycentric[0] >= 0 && p->barycentric[1] >= 0 &&
                                p->barycentric[0] + p->barycentric[1] <= 1);
                    has[p->triangle]++;
                    off = fmax(off, fabs((double)p->area * d.surfel_count * share[p->triangle] / all - 1));
                }
                for (i = 0; i < triangles; i++)
                    worst = fmax(worst, fabs(share[i] / all * d.surfel_count - (double)has[i]));
            }
            free(surfels);
        }
        printf("%u triangles: surfels differ from their share by %.4f at most, areas by %.1e\n", triangles, worst, off);
        assert_true(worst < 2.01);
        assert_true(off < 1e-5);
        if (triangles == 1) assert_true(worst == 0);
        both_free(t, &b);
        free(share);
        free(has);
    }
}

/* Every floor of a room of unit side is seen as a sixth of the sphere from the middle: 4 pi / 6 for two triangles
   together, whichever receiver of eight at one place is taken; and a far one as area / d^2. */
static void solid_angles_are_those_of_a_cube(void **state)
{
    GL_TEST(t, state)
    static const float floor_of[18] = { -0.5f, -0.5f, -0.5f, 0.5f, -0.5f, -0.5f, 0.5f, -0.5f, 0.5f,
                                        -0.5f, -0.5f, -0.5f, 0.5f, -0.5f, 0.5f, -0.5f, -0.5f, 0.5f };
    static const float far_off[9] = { -0.5f, -100, -0.5f, 0.5f, -100, -0.5f, 0.5f, -100, 0.5f };
    static const float octant[9] = { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, line[9] = { 1, 0, 0, 2, 0, 0, 3, 0, 0 };
    static const float up[3] = { 0, 1, 0 };
    enum { N = 5 };
    scene *s = scene_make(N);
    const ism_desc d = small(ISM_SPREAD_VIEW_8);
    uint32_t words[4 * N];
    float sizes[N][2];
    size_t i;
    both b;
    memcpy(s->positions, floor_of, sizeof floor_of);
    memcpy(s->positions + 18, far_off, sizeof far_off);
    memcpy(s->positions + 27, octant, sizeof octant);
    memcpy(s->positions + 36, line, sizeof line);
    for (i = 0; i < PIXELS; i++) {
        memset(s->places + 3 * i, 0, 12);
        memcpy(s->normals + 3 * i, up, sizeof up);
    }
    for (i = 0; i < PIXELS; i += 3) {       /* pixels without a normal are no receivers, wherever they are */
        s->places[3 * i + 1] = 5;
        memset(s->normals + 3 * i, 0, 12);
    }
    both_make(t, s, &d, &b);
    both_scatter(t, &b, 0);
    assert_glbk(t, glbk_target_read(&t->gl, &b.spread.sizes.target, 0, 0, 0, N, 1, words));
    for (i = 0; i < N; i++) memcpy(sizes[i], words + 4 * i, 8);
    for (i = 0; i < 3; i++) assert_true(fabs((double)sizes[i][0] - 0.5) < 1e-6);
    CONFORM("T48", "solid angles of a cube's face from its middle, on the GPU", 4 * 3.14159265358979 / 6,
            (double)(sizes[0][1] + sizes[1][1]), 1e-5);
    CONFORM("T48", "solid angle of a triangle 100 away times 20,000, on the GPU", 1, 2e4 * (double)sizes[2][1], 1e-4);
    CONFORM("T52", "octant triangle, on the GPU", 3.14159265358979 / 2, (double)sizes[3][1], 1e-5);
    CONFORM("T52", "degenerate triangle, on the GPU", 0, (double)(sizes[4][0] + sizes[4][1]), 0);
    both_free(t, &b);
}

/* ---- the twin ---- */

/* Compares a phase with that of ism_scatter: the share of surfels that lie on another triangle. */
static double compare_phase(gl_test *t, both *b, uint32_t phase, double *worst)
{
    size_t n, count, i, off = 0, used = 0;
    ism_surfel *is = read_phase(t, b, phase, &n);
    ism_surfel *wanted = (ism_surfel *)malloc(n * sizeof *wanted);
    assert_non_null(wanted);
    assert_int_equal(ism_phase_surfels(b->cpu, phase, wanted, n, &count), ISM_OK);
    assert_int_equal(count, n);
    for (i = 0; i < n; i++) {
        assert_true((is[i].area > 0) == (wanted[i].area > 0));
        used += wanted[i].area > 0;
        if (!(wanted[i].area > 0)) continue;
        assert_true(fabsf(is[i].barycentric[0] - wanted[i].barycentric[0]) < 4e-5f);
        assert_true(fabsf(is[i].barycentric[1] - wanted[i].barycentric[1]) < 4e-5f);
        if (is[i].triangle != wanted[i].triangle) off++;
        else *worst = fmax(*worst, fabs((double)is[i].area / (double)wanted[i].area - 1));
    }
    assert_true(used > 0);
    free(is);
    free(wanted);
    return (double)off / (double)used;
}

/* What the surfels of a VPL stand for together is the mesh's area. 500 of them leave 1.6 % of noise, 24 VPLs 0.33 %. */
static void surfels_keep_the_area(gl_test *t, const both *b, const scene *s)
{
    static const char *const names[5] = { "", "points by area", "by 1 view sample", "by 8 view samples",
                                          "by view and VPL" };
    double all = 0, sum = 0, *area = (double *)malloc(s->mesh.vertex_count / 3 * sizeof *area);
    char text[80];
    uint32_t phase;
    size_t i, n, k;
    assert_non_null(area);
    for (i = 0; i < s->mesh.vertex_count / 3; i++) {
        const float *p = s->positions + 9 * i;
        double u[3], v[3];
        for (k = 0; k < 3; k++) {
            u[k] = (double)p[3 + k] - (double)p[k];
            v[k] = (double)p[6 + k] - (double)p[k];
        }
        area[i] = 0.5 * sqrt(pow(u[1] * v[2] - u[2] * v[1], 2) + pow(u[2] * v[0] - u[0] * v[2], 2) +
                             pow(u[0] * v[1] - u[1] * v[0], 2));
        all += area[i];
    }
    for (phase = 0; phase < 8; phase++) {
        ism_surfel *is = read_phase(t, b, phase, &n);
        for (i = 0; i < n; i++) sum += (double)is[i].area * area[is[i].triangle] / VPLS;
        free(is);
    }
    snprintf(text, sizeof text, "%s, on the GPU: sum of their areas over the surface", names[b->desc.spread]);
    CONFORM("T53", text, 1, sum / all, 0.01);
    free(area);
}

static void surfels_are_those_of_ism_scatter(void **state)
{
    GL_TEST(t, state)
    static const struct { uint32_t triangles; ism_spread spread; int way; double most; } trials[] = {
        { 700, ISM_SPREAD_AREA, 0, 1e-3 },  { 700, ISM_SPREAD_VIEW_1, 0, 1e-3 }, { 2500, ISM_SPREAD_VIEW_8, 0, 2e-3 },
        { 700, ISM_SPREAD_PAIR, 0, 2e-3 },  { 2500, ISM_SPREAD_PAIR, 1, 4e-3 },  { 700, ISM_SPREAD_PAIR, 2, 2e-3 },
        { 700, ISM_SPREAD_PAIR, 3, 2e-3 },  { 700, ISM_SPREAD_PAIR, 4, 2e-3 },   { 70000, ISM_SPREAD_PAIR, 0, 3e-2 },
    };
    size_t k;
    for (k = 0; k < sizeof trials / sizeof trials[0]; k++) {
        scene *s = scene_make(trials[k].triangles);
        ism_desc d = small(trials[k].spread);
        double off = 0, worst = 0;
        uint32_t index, phase;
        size_t i;
        both b;
        d.seed = (uint32_t)k;
        if (trials[k].way == 1) d.window_rim = -1;
        if (trials[k].way == 2) d.unstable = 1;
        if (trials[k].way == 3) d.vary_surfels = 1;
        if (trials[k].way == 4) d.area_share = 0.9f;
        both_make(t, s, &d, &b);
        both_scatter(t, &b, 5);             /* at first all phases */
        if (k < 4) surfels_keep_the_area(t, &b, s);
        for (phase = 0; phase < 8; phase++) off = fmax(off, compare_phase(t, &b, phase, &worst));
        for (i = 0; i < 9 * (size_t)trials[k].triangles; i += 3) s->positions[i] += 0.2f * s->positions[i + 2];
        assert_glbk(t, glbk_ism_mesh_move(&t->gl, &b.maps, s->positions, 0));
        for (index = 6; index < 8; index++) {
            both_scatter(t, &b, index);     /* then one after the other; the others stay as they were */
            for (phase = 0; phase < 8 && trials[k].way != 3; phase++)
                off = fmax(off, compare_phase(t, &b, phase, &worst));
        }
        printf("%u triangles, spread %d, way %d: %.5f of the surfels lie on another triangle, areas differ by %.1e\n",
               trials[k].triangles, (int)trials[k].spread, trials[k].way, off, worst);
        assert_true(off < trials[k].most);
        assert_true(worst < 2e-3);
        both_free(t, &b);
    }
}

/* A mesh that loses its last 400 triangles, gains 200 and loses 100: the same surfels as ism_scatter's in all phases,
   those that stay to the bit as they were; by area, and by pairs of VPL and cluster. */
static void triangles_that_come_and_go_leave_the_surfels_of_the_others(void **state)
{
    GL_TEST(t, state)
    static const uint32_t counts[] = { 1500, 1100, 1300, 1300, 1200 };
    static const ism_spread spreads[] = { ISM_SPREAD_AREA, ISM_SPREAD_PAIR };
    size_t k, n, i, f;
    for (k = 0; k < 2; k++) {
        scene *s = scene_make(1500);
        const ism_desc d = small(spreads[k]);
        double off = 0, worst = 0;
        size_t stayed = 0, moved = 0, left = 0;
        ism_surfel *was[8] = { NULL };
        uint32_t phase;
        both b;
        both_make(t, s, &d, &b);
        for (f = 0; f < sizeof counts / sizeof counts[0]; f++) {
            const uint32_t index = 3 + (uint32_t)f;
            s->mesh.vertex_count = 3 * (size_t)counts[f];
            assert_glbk(t, glbk_ism_mesh_upload(&t->gl, &b.maps, &s->mesh));
            both_scatter(t, &b, index);
            for (phase = 0; phase < 8; phase++) {
                ism_surfel *is = read_phase(t, &b, phase, &n);
                off = fmax(off, compare_phase(t, &b, phase, &worst));
                for (i = 0; i < n && was[phase] && phase != index % 8; i++) {
                    const int same = !memcmp(&is[i], &was[phase][i], sizeof is[i]);
                    if (was[phase][i].triangle >= counts[f]) left++;
                    else if (same) stayed++;
                    else moved++;
                }
                for (i = 0; i < n; i++) assert_true(is[i].triangle < counts[f]);
                free(was[phase]);
                was[phase] = is;
            }
            assert_glbk(t, glbk_ism_draw(&t->gl, &b.maps, 0));
        }
        printf("spread %d: %.5f of the surfels on another triangle, areas differ by %.1e; %zu stayed, %zu had to go\n",
               (int)d.spread, off, worst, stayed, left);
        CONFORM("T54", k ? "triangles come and go, on the GPU: points of the others that move out of turn, by VPL"
                         : "triangles come and go, on the GPU: points of the others that move out of turn, by area",
                0, (double)moved, 0);
        assert_true(stayed > 20000 && left > 2000);
        assert_true(off < 2e-3);
        assert_true(worst < 2e-3);
        for (phase = 0; phase < 8; phase++) free(was[phase]);
        both_free(t, &b);
    }
}

/* Scattering, by the dearest spread, and drawing ask GL for nothing and send no texels: no glReadPixels, no glGet...,
   no glFinish (gl_choice_test has the rest of a frame). At the first frame, when all phases are due, too. */
static void a_frame_of_surfels_reads_nothing_back(void **state)
{
    GL_TEST(t, state)
    scene *s = scene_make(700);
    const ism_desc d = small(ISM_SPREAD_PAIR);
    uint32_t turn;
    double worst = 0;
    both b;
    both_make(t, s, &d, &b);
    both_scatter(t, &b, 3);                                     /* compiles the programs, and has VPLs uploaded */
    assert_glbk(t, glbk_ism_draw(&t->gl, &b.maps, 0));
    t->gl.check = 0;                                            /* which asks for errors after each call */
    for (turn = 0; turn < 2; turn++) {
        if (turn == 0) {                                        /* all surfels anew */
            t->gl.check = 1;
            assert_glbk(t, glbk_ism_mesh_upload(&t->gl, &b.maps, NULL));
            assert_glbk(t, glbk_ism_mesh_upload(&t->gl, &b.maps, &s->mesh));
            t->gl.check = 0;
        }
        gl_count_begin(&t->gl);
        assert_glbk(t, glbk_ism_scatter(&t->gl, &b.spread, &b.maps, &b.seen, 3 + turn));
        assert_glbk(t, glbk_ism_draw(&t->gl, &b.maps, 0));
        assert_int_equal(gl_counted.asks, 0);
        assert_int_equal(gl_counted.uploads, 0);
        assert_true(gl_counted.draws > 9);
        gl_count_end(&t->gl);
    }
    t->gl.check = 1;
    b.frame.index = 4;
    assert_int_equal(ism_scatter(b.cpu, &b.frame), ISM_OK);
    assert_true(compare_phase(t, &b, 4, &worst) < 2e-3);        /* and it did its work */
    both_free(t, &b);
}

/* Without receivers, and on a mesh without area. */
static void nothing_to_see_or_to_hit(void **state)
{
    GL_TEST(t, state)
    scene *s = scene_make(300);
    const ism_desc d = small(ISM_SPREAD_PAIR);
    double worst = 0;
    ism_surfel *surfels;
    size_t n, i;
    both b;
    memset(s->normals, 0, sizeof s->normals);
    both_make(t, s, &d, &b);
    both_scatter(t, &b, 0);
    assert_true(compare_phase(t, &b, 0, &worst) < 2e-3);
    for (i = 0; i < s->mesh.vertex_count; i++) memcpy(s->positions + 3 * i, s->positions, 12);
    assert_glbk(t, glbk_ism_mesh_upload(&t->gl, &b.maps, &s->mesh));
    assert_glbk(t, glbk_ism_scatter(&t->gl, &b.spread, &b.maps, &b.seen, 0));
    surfels = read_phase(t, &b, 0, &n);
    for (i = 0; i < n; i++) assert_true(!(surfels[i].area > 0));
    free(surfels);
    both_free(t, &b);
}

static int no_holes(void *user, uint32_t triangle, const float *weights)
{
    (void)user, (void)triangle, (void)weights;
    return 1;
}

static void bad_arguments_are_refused(void **state)
{
    GL_TEST(t, state)
    scene *s = scene_make(40);
    ism_desc d = small(ISM_SPREAD_PAIR);
    glbk_ism_spread spread;
    both b, other;
    both_make(t, s, &d, &b);
    both_make(t, s, &d, &other);
    assert_int_equal(glbk_ism_spread_create(NULL, &b.maps, &spread), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_ism_spread_create(&t->gl, &b.maps, NULL), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_ism_spread_create(&t->gl, NULL, &spread), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_ism_scatter(NULL, &b.spread, &b.maps, &b.seen, 0), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_ism_scatter(&t->gl, NULL, &b.maps, &b.seen, 0), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_ism_scatter(&t->gl, &b.spread, NULL, &b.seen, 0), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_ism_scatter(&t->gl, &b.spread, &b.maps, NULL, 0), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_ism_scatter(&t->gl, &b.spread, &other.maps, &b.seen, 0), GLBK_ERR_MISMATCH);
    s->mesh.mask_fn = no_holes;
    assert_glbk(t, glbk_ism_mesh_upload(&t->gl, &b.maps, &s->mesh));
    assert_int_equal(glbk_ism_scatter(&t->gl, &b.spread, &b.maps, &b.seen, 0), GLBK_ERR_MISMATCH);
    s->mesh.mask_fn = NULL;
    assert_glbk(t, glbk_ism_mesh_upload(&t->gl, &b.maps, NULL));
    assert_glbk(t, glbk_ism_scatter(&t->gl, &b.spread, &b.maps, &b.seen, 0));       /* no mesh: nothing to do */
    b.maps.desc.spread = ISM_SPREAD_COUNT;
    assert_int_equal(glbk_ism_spread_create(&t->gl, &b.maps, &spread), GLBK_ERR_DESC);
    b.maps.desc.spread = ISM_SPREAD_PAIR;
    b.maps.desc.area_share = 2;
    assert_int_equal(glbk_ism_spread_create(&t->gl, &b.maps, &spread), GLBK_ERR_DESC);
    glbk_ism_spread_free(&t->gl, NULL);
    both_free(t, &b);
    both_free(t, &other);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(surfels_by_area_are_even),
        gl_unit_test(solid_angles_are_those_of_a_cube),
        gl_unit_test(surfels_are_those_of_ism_scatter),
        gl_unit_test(triangles_that_come_and_go_leave_the_surfels_of_the_others),
        gl_unit_test(a_frame_of_surfels_reads_nothing_back),
        gl_unit_test(nothing_to_see_or_to_hit),
        gl_unit_test(bad_arguments_are_refused)
    };
    (void)count;
    if (gl_this_way() && gl_this_way()->bit != GL_CORE33) unsetenv("CONFORMANCE");     /* each row once */
    GL_TEST_MAIN(values, tests, GL_USUAL);
}
