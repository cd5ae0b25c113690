/* ism_rows_test - rows of docs/conformance.md by the GL back end: pull and push (T49), a blocker between two squares
   (T50), the sealed box, equal frames (T57). ism.h chooses and scatters, as it does for a renderer. */
#define _POSIX_C_SOURCE 200809L
#include "ism.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define GL_BACKEND_IMPLEMENTATION
#include "gl_backend.h"

#define CONFORM_BACKEND "gl"
#include "conformance.h"
#include "gl/gl_test.h"
#include "unit/ism_util.h"

static soup mesh;

/* ---- a frame: VPLs and points of ism.h, maps and light by GL ---- */

typedef struct engine { ism_maps *cpu; glbk_ism_maps maps; glbk_ism_renderer renderer; ism_desc desc; } engine;

static void engine_open(gl_test *t, engine *e, const ism_desc *desc, uint32_t width, uint32_t height)
{
    glbk_ism_desc d;
    memset(&d, 0, sizeof d);
    e->desc = *desc;
    e->desc.lazy = 8;
    d.vpl_count = desc->vpl_count;
    d.points = desc->points;
    d.tile_size = desc->tile_size;
    assert_int_equal(ism_create(&e->desc, &e->cpu), ISM_OK);
    assert_glbk(t, glbk_ism_maps_create(&t->gl, &d, &e->maps));
    assert_glbk(t, glbk_ism_renderer_create(&t->gl, width, height, &e->renderer));
}

static void engine_close(gl_test *t, engine *e)
{
    glbk_ism_renderer_destroy(&t->gl, &e->renderer);
    glbk_ism_maps_destroy(&t->gl, &e->maps);
    ism_destroy(e->cpu);
}

/* The VPLs that e->cpu has; points where the frame has a mesh. */
static void engine_render(gl_test *t, engine *e, const ism_frame *frame, float *irradiance)
{
    glbk_ism_receivers from = { frame->view->positions, frame->view->normals, NULL, NULL, 0 };
    glbk_ism_shading shading = { 1, 0, 1, 0.02f, 0, 1 };
    glbk_ism_mesh to;
    size_t count, i;
    const ism_vpl *vpls = ism_vpls(e->cpu, &count);
    glbk_ism_vpl *list = (glbk_ism_vpl *)calloc(count, sizeof *list);
    shading.no_maps = !frame->mesh;
    assert_non_null(list);
    for (i = 0; i < count; i++) {
        memcpy(list[i].position, vpls[i].position, 12);
        memcpy(list[i].normal, vpls[i].normal, 12);
        memcpy(list[i].flux, vpls[i].flux, 12);
        memcpy(list[i].axis, vpls[i].axis, 12);
        list[i].exponent = vpls[i].exponent;
        list[i].side = vpls[i].side;
    }
    assert_glbk(t, glbk_ism_vpls_upload(&t->gl, &e->maps, list, (uint32_t)count, NULL, 0));
    free(list);
    if (frame->mesh) {
        ism_point *points = (ism_point *)malloc((size_t)e->desc.vpl_count * e->maps.each * sizeof *points);
        uint32_t phase;
        assert_non_null(points);
        memset(&to, 0, sizeof to);
        to.positions = frame->mesh->positions;
        to.vertex_count = frame->mesh->vertex_count;
        assert_int_equal(ism_scatter(e->cpu, frame), ISM_OK);
        assert_glbk(t, glbk_ism_mesh_upload(&t->gl, &e->maps, &to));
        for (phase = 0; phase < 8; phase++) {
            assert_int_equal(ism_phase_points(e->cpu, phase, points, (size_t)e->desc.vpl_count * e->maps.each, &count),
                             ISM_OK);
            assert_glbk(t, glbk_ism_phase(&t->gl, &e->maps, phase, points));
        }
        free(points);
        assert_glbk(t, glbk_ism_draw(&t->gl, &e->maps));
    }
    assert_glbk(t, glbk_ism_gbuffer_upload(&t->gl, &e->renderer, &from));
    assert_glbk(t, glbk_ism_shade(&t->gl, &e->renderer, &e->maps, &shading));
    assert_glbk(t, glbk_ism_read_light(&t->gl, &e->renderer, irradiance));
}

/* ---- T49 ---- */

static void pull_and_push(void **state)
{
    GL_TEST(t, state)
    static float directions[4 * 4096], surfels[4 * 4096], depth[4096];
    glbk_ism_desc d = { 1, 8, 64, 1, 1, 0, 0 };
    glbk_ism_vpl vpl = { { 0, 0, 0 }, { 0, 0, 1 }, { 1, 1, 1 }, { 0, 0, 1 }, 1, 0, 0 };
    glbk_ism_maps m;
    uint32_t seed = 3, trial;
    size_t i;
    int k;
    double constant = 0, plane = 0, between = 0, filled = 0, empty = 0, holes = 0;
    assert_glbk(t, glbk_ism_maps_create(&t->gl, &d, &m));
    assert_glbk(t, glbk_ism_vpls_upload(&t->gl, &m, &vpl, 1, NULL, 0));
    assert_glbk(t, glbk_ism_draw(&t->gl, &m));
    assert_glbk(t, glbk_ism_read(&t->gl, &m, depth));
    for (i = 0; i < 4096; i++) empty += depth[i] < ISM_FAR;
    assert_glbk(t, glbk_target_read(&t->gl, &m.direction_target, 0, 0, 0, 64, 64, directions));
    for (trial = 0; trial < 3; trial++) {
        for (i = 0; i < 4096; i++) {
            const float *w = directions + 4 * i;
            float g[4] = { 0.3f, -0.2f, 0.5f, ISM_FAR };
            if (trial == 0)                 /* constant depth: surfels face the VPL */
                for (k = 0; k < 3; k++) g[k] = 0.5f * w[k];
            if (trial == 2)                 /* two depths, left and right */
                for (k = 0; k < 3; k++) g[k] = w[k] * (i % 64 < 32 ? 1.0f : 0.25f);
            if (util_unit(&seed) < 0.1f && g[0] * w[0] + g[1] * w[1] + g[2] * w[2] >= 0.1f)
                g[3] = 1 / (g[0] * w[0] + g[1] * w[1] + g[2] * w[2]);
            memcpy(surfels + 4 * i, g, sizeof g);
        }
        assert_glbk(t, glbk_texture_update(&t->gl, &m.surfels, 0, 0, 0, 0, 64, 64, 1, surfels));
        assert_glbk(t, glbk__ism_fill(&t->gl, &m));
        assert_glbk(t, glbk_ism_read(&t->gl, &m, depth));
        for (i = 0; i < 4096; i++) {
            const float *w = directions + 4 * i;
            double truth = 1 / (0.3 * (double)w[0] - 0.2 * (double)w[1] + 0.5 * (double)w[2]);
            if (depth[i] >= ISM_FAR) {
                holes += trial == 0;
                continue;
            }
            if (trial == 0) constant = fmax(constant, fabs((double)depth[i] / 2 - 1));
            if (trial == 1 && truth > 0 && truth < 5) {
                plane = fmax(plane, fabs((double)depth[i] / truth - 1));
                filled++;
            }
            if (trial == 2) between += depth[i] > 1.1f && depth[i] < 3.6f;
        }
    }
    glbk_ism_maps_destroy(&t->gl, &m);
    /* facets that face the VPL at one texel are 0.2 % nearer at the next but three */
    CONFORM_MAX("T49", "constant depth from 10 % points, largest relative error", 0.02, constant);
    CONFORM_MAX("T49", "constant depth from 10 % points, share of texels left open", 0.01, holes / 4096);
    CONFORM_MAX("T49", "plane from 10 % points, largest relative error", 0.01, plane);
    assert_true(filled > 3000);
    CONFORM("T49", "two depths: texels with a depth between", 0, between, 0);
    CONFORM("T49", "empty tile: texels with a depth", 0, empty, 0);
}

/* ---- T50, the sealed box ---- */

/* again: whether a second frame differs. */
static double transmitted(gl_test *t, const ism_mesh *m, uint32_t points, double *again)
{
    static grid below;
    static float light[3 * 32 * 32];
    const float a[3] = { 0, 0, 0 }, u[3] = { 1, 0, 0 }, v[3] = { 0, 0, 1 }, up[3] = { 0, 1, 0 };
    ism_view view;
    ism_desc d;
    ism_frame f;
    engine e;
    ism_vpl list[144];
    double sum = 0;
    size_t i;
    grid_fill(&below, 32, 32, a, u, v, up, 0);
    view = grid_view(&below);
    for (i = 0; i < 144; i++) {             /* radiance 1: flux pi A */
        list[i] =
            util_vpl(((float)(i % 12) + 0.5f) / 12, 1, ((float)(i / 12) + 0.5f) / 12, 0, -1, 0, (float)UTIL_PI / 144);
        list[i].area = 1.0f / 144;
    }
    memset(&d, 0, sizeof d);
    d.vpl_count = 144;
    d.points = points;
    d.tile_size = 128;
    d.spread = ISM_SPREAD_AREA;
    memset(&f, 0, sizeof f);
    f.mesh = m;
    f.view = &view;
    engine_open(t, &e, &d, 32, 32);
    assert_int_equal(ism_set_vpls(e.cpu, list, 144), ISM_OK);
    engine_render(t, &e, &f, light);
    if (again) {
        static float now[3 * 32 * 32];
        f.index = 1;
        engine_render(t, &e, &f, now);
        *again = memcmp(light, now, sizeof now) != 0;
    }
    for (i = 0; i < 32 * 32; i++) sum += (double)light[3 * i] / UTIL_PI / (32 * 32);
    engine_close(t, &e);
    return sum;
}

static void a_blocker_between_two_squares(void **state)
{
    GL_TEST(t, state)
    const float a[3] = { -0.05f, 0.5f, -0.05f }, u[3] = { 1.1f, 0, 0 }, v[3] = { 0, 0, 1.1f };
    const float ha[3] = { -1, 0.5f, -1 }, hu[3] = { 1.5f, 0, 0 }, hv[3] = { 0, 0, 3 };
    double open, full, half, differ;
    ism_mesh m;
    open = transmitted(t, NULL, 8, NULL);
    CONFORM("T50", "two unit squares 1 apart, by VPLs", 0.1998249, open, 5e-4);     /* midpoint sums of 16^2 x 32^2 */
    mesh.triangles = 0;
    soup_quad(&mesh, a, u, v, 8);
    m = soup_mesh(&mesh);
    full = transmitted(t, &m, 4096, &differ);
    mesh.triangles = 0;
    soup_quad(&mesh, ha, hu, hv, 8);
    m = soup_mesh(&mesh);
    half = transmitted(t, &m, 16384, NULL);        /* discs of 1 cm: a silhouette grows by about their radius */
    CONFORM("T50", "full blocker: transmitted", 0, full, 1e-4);
    /* the edge grows by a disc and part of a texel, 0.02 of the width of 1 */
    CONFORM("T50", "half-plane blocker: share transmitted", 0.5, half / open, 0.03);
    CONFORM("T57", "static scene: frames that are not the first one, bit by bit", 0, differ, 0);
}

static void a_sealed_box_stays_dark(void **state)
{
    GL_TEST(t, state)
    static grid roof, inside;
    static float light[3 * 64 * 64];
    const float lo[3] = { -1, 0, -1 }, hi[3] = { 1, 2, 1 }, ilo[3] = { -0.75f, 0.25f, -0.75f },
                ihi[3] = { 0.75f, 1.75f, 0.75f };
    const float glo[3] = { -4, -0.2f, -4 }, gu[3] = { 8, 0, 0 }, gv[3] = { 0, 0, 8 };
    const float a[3] = { -0.75f, 0.25f, -0.75f }, u[3] = { 1.5f, 0, 0 }, v[3] = { 0, 0, 1.5f }, up[3] = { 0, 1, 0 };
    ism_mesh m;
    ism_view view;
    ism_source s;
    ism_frame f;
    ism_desc d;
    engine e;
    double sum = 0, all = 0;
    size_t i;
    mesh.triangles = 0;
    soup_box(&mesh, lo, hi, 1, 8);
    soup_box(&mesh, ilo, ihi, -1, 8);       /* walls as thick as a house's */
    soup_quad(&mesh, glo, gv, gu, 16);
    m = soup_mesh(&mesh);
    grid_fill(&inside, 64, 64, a, u, v, up, 0);
    for (i = 0; i < 64 * 64; i++)           /* receivers on floor and ceiling */
        if (i & 1) {
            inside.p[3 * i + 1] = 1.75f;
            inside.n[3 * i + 1] = -1;
        }
    grid_fill(&roof, 64, 64, glo, gu, gv, up, 1);
    for (i = 0; i < 64 * 64; i++)           /* sun from above on the roof and the ground about the box */
        if (fabsf(roof.p[3 * i]) < 1 && fabsf(roof.p[3 * i + 2]) < 1) roof.p[3 * i + 1] = 2;
    s = grid_source(&roof);
    view = grid_view(&inside);
    memset(&d, 0, sizeof d);
    memset(&f, 0, sizeof f);
    d.vpl_count = 128;
    d.points = 8192;
    f.mesh = &m;
    f.view = &view;
    f.sources = &s;
    f.source_count = 1;
    engine_open(t, &e, &d, 64, 64);
    assert_int_equal(ism_choose(e.cpu, &f), ISM_OK);
    engine_render(t, &e, &f, light);
    for (i = 0; i < 3 * 64 * 64; i++) sum += (double)light[i];
    f.mesh = NULL;
    engine_render(t, &e, &f, light);
    for (i = 0; i < 3 * 64 * 64; i++) all += (double)light[i];
    engine_close(t, &e);
    assert_true(all > 0);
    /* imperfect: within a texel of where walls and ceiling meet, see docs/ism.md, section 3 */
    CONFORM_MAX("irradiance", "sealed box, sun outside: light inside over light through open walls", 0.001, sum / all);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = { gl_unit_test(pull_and_push), gl_unit_test(a_sealed_box_stays_dark),
                                  gl_unit_test(a_blocker_between_two_squares) };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE33);
}
