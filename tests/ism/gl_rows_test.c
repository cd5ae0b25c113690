/* gl_rows_test - rows of docs/conformance.md by the GL back end: those of tests/ism/rows.h, pull and push
   (T49), the dither (T58). ism.h chooses and scatters, as it does for a renderer. */
#define _POSIX_C_SOURCE 200809L
#include "ism.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define GL_ISM_IMPLEMENTATION
#include "gl_backend/gl_ism.h"

#define CONFORM_BACKEND "gl"
#include "conformance.h"
#include "gl_test.h"
#include "gl_ask.h"
#include "util.h"
#include "gl_util.h"

static gl_test *now;                /* of the test that runs */

#define ROW_TEST(state) GL_TEST(test_, state) now = test_;
#include "rows.h"

/* ---- functions of the library ---- */

static const char *define_projection(ism_projection p)
{
    static char text[] = "MAP=1u";
    text[4] = (char)('0' + (int)p);
    return text;
}

/* `words` numbers a point, and one more for all, to fours and back. */
static float *fours_of(const float *from, size_t words, size_t count, float last)
{
    float *to = (float *)calloc(4 * count, sizeof *to);
    size_t i;
    assert_non_null(to);
    for (i = 0; i < count; i++) {
        memcpy(to + 4 * i, from + words * i, words * sizeof *to);
        to[4 * i + 3] = last;
    }
    return to;
}

static void row_directions(ism_projection p, float exponent, const float *uv, size_t count, float *d)
{
    float *fours = fours_of(uv, 2, count, exponent);
    size_t i;
    gl_ask(now, glbk_ism_part(), GL_ASK("    r.xyz = ism_map_direction(MAP, layer(0).w, layer(0).xy);\n"), "ism_map",
           define_projection(p), NULL, NULL, fours, 1, count, 1, fours);
    for (i = 0; i < count; i++) memcpy(d + 3 * i, fours + 4 * i, 12);
    free(fours);
}

static void row_coordinates(ism_projection p, float exponent, const float *d, size_t count, float *uv, uint8_t *there)
{
    float *fours = fours_of(d, 3, count, exponent);
    size_t i;
    gl_ask(now, glbk_ism_part(),
           GL_ASK("    r.z = float(ism_map_coordinates(MAP, layer(0).w, layer(0).xyz, r.xy));\n"), "ism_map",
           define_projection(p), NULL, NULL, fours, 1, count, 1, fours);
    for (i = 0; i < count; i++) {
        memcpy(uv + 2 * i, fours + 4 * i, 8);
        there[i] = fours[4 * i + 2] > 0.5f;
    }
    free(fours);
}

/* By centre and half edges, which is how a VPL's square comes. */
static void row_form_factors(const float normal[3], const float *corners, size_t count, float *f)
{
    float *in = (float *)calloc(12 * count, sizeof *in);
    size_t i;
    int k;
    assert_non_null(in);
    for (i = 0; i < count; i++)
        for (k = 0; k < 3; k++) {
            const float *c = corners + 12 * i + k;
            float *to = in + 4 * i + k;
            to[0] = 0.5f * (c[0] + c[6]);
            to[4 * count] = 0.5f * (c[3] - c[0]);
            to[8 * count] = 0.5f * (c[9] - c[0]);
        }
    for (i = 0; i < count; i++)
        for (k = 0; k < 3; k++) in[4 * ((size_t)k * count + i) + 3] = normal[k];
    gl_ask(now, glbk_ism_part(),
           GL_ASK("    vec4 a = layer(0), b = layer(1), c = layer(2);\n"
                  "    r.x = ism_form_factor(vec3(a.w, b.w, c.w), a.xyz, b.xyz, c.xyz, r.y);\n"),
           "ism_light", NULL, NULL, NULL, in, 3, count, 1, in);
    for (i = 0; i < count; i++) f[i] = in[4 * i];
    free(in);
}

/* ---- a frame: VPLs and points of ism.h, maps and light by GL ---- */

struct engine { ism_maps *cpu; glbk_ism_maps maps; glbk_gbuffer seen; glbk_ism_renderer renderer; ism_points view; };

static uint32_t height_of(const ism_points *view) { return (uint32_t)view->count / view->width; }

static engine *engine_open(const ism_desc *desc, const ism_points *view)
{
    engine *e = (engine *)calloc(1, sizeof *e);
    assert_non_null(e);
    e->view = *view;
    assert_int_equal(ism_create(desc, &e->cpu), ISM_OK);
    assert_glbk(now, glbk_ism_maps_create(&now->gl, desc, &e->maps));
    assert_glbk(now, glbk_ism_renderer_create(&now->gl, &(glbk_ism_renderer_desc){ view->width, height_of(view) },
                                              &e->renderer));
    gl_see(&now->gl, view->width, height_of(view), view->positions, view->normals, NULL, &e->seen);
    return e;
}

static void engine_close(engine *e)
{
    glbk_ism_renderer_free(&now->gl, &e->renderer);
    glbk_gbuffer_free(&now->gl, &e->seen);
    glbk_ism_maps_free(&now->gl, &e->maps);
    ism_free(e->cpu);
    free(e);
}

static ism_maps *engine_maps(engine *e) { return e->cpu; }

static void send_vpls(engine *e)
{
    size_t count, i;
    const ism_vpl *vpls = ism_vpls(e->cpu, &count);
    ism_vpl *list = (ism_vpl *)calloc(count, sizeof *list);
    ism_info info;
    assert_non_null(list);
    for (i = 0; i < count; i++) {
        list[i] = vpls[i];
        list[i].directional = 0;
        list[i].reach = 0;
    }
    ism_get_info(e->cpu, &info);
    assert_glbk(now, glbk_ism_vpls_upload(&now->gl, &e->maps, list, (uint32_t)count, &info));
    free(list);
}

static void engine_draw(engine *e, const ism_frame *frame)
{
    const size_t room = (size_t)e->maps.desc.vpl_count * e->maps.phase_surfel_count;
    ism_surfel *surfels = (ism_surfel *)malloc(room * sizeof *surfels);
    ism_mesh m;
    size_t count;
    uint32_t phase;
    assert_non_null(surfels);
    memset(&m, 0, sizeof m);
    m.positions = frame->mesh->positions;
    m.vertex_count = frame->mesh->vertex_count;
    m.opacities = frame->mesh->opacities;
    assert_int_equal(ism_scatter(e->cpu, frame), ISM_OK);
    send_vpls(e);
    assert_glbk(now, glbk_ism_mesh_upload(&now->gl, &e->maps, &m));
    for (phase = 0; phase < e->maps.desc.lazy_frames; phase++) {
        assert_int_equal(ism_phase_surfels(e->cpu, phase, surfels, room, &count), ISM_OK);
        assert_int_equal(count, room);
        assert_glbk(now, glbk_ism_surfels_upload(&now->gl, &e->maps, phase, surfels, count));
    }
    free(surfels);
    assert_glbk(now, glbk_ism_draw(&now->gl, &e->maps, 0));
}

static float *engine_atlas(engine *e, uint32_t *side)
{
    float *atlas = (float *)malloc((size_t)e->maps.side * e->maps.side * sizeof *atlas);
    assert_non_null(atlas);
    assert_glbk(now, gl_read_atlas(&now->gl, &e->maps, atlas));
    *side = e->maps.side;
    return atlas;
}

static void engine_shade(engine *e, const ism_shading *shading, float *light, double *lost)
{
    send_vpls(e);
    assert_glbk(now, glbk_ism_shade(&now->gl, &e->renderer, &e->seen, &e->maps, shading, 0));
    gl_light_of(&now->gl, &e->renderer, NULL, light, lost);
}

static void engine_bounce(engine *e, const ism_frame *frame, uint32_t side, float *p, float *n, float *flux)
{
    float *const out[3] = { p, n, flux };
    glbk_ism_bounces b;
    uint32_t *words;
    size_t count, i;
    uint32_t k;
    (void)frame;
    assert_glbk(now, glbk_ism_bounces_create(&now->gl, &e->maps, side, &b));
    assert_glbk(now, glbk_ism_bounce(&now->gl, &b, &e->maps));
    count = (size_t)b.texels.width * b.texels.height;
    words = (uint32_t *)malloc(16 * count);
    assert_non_null(words);
    for (k = 0; k < 3; k++) {
        assert_glbk(now, glbk_target_read(&now->gl, &b.target, k, 0, 0, b.texels.width, b.texels.height, words));
        for (i = 0; i < count; i++) memcpy(out[k] + 3 * i, words + 4 * i, 12);
    }
    free(words);
    glbk_ism_bounces_free(&now->gl, &b);
}

/* ---- T45 once more, by the GPU alone ---- */

/* A source of a list: one row of texels. */
static glbk_texture texels_of(uint32_t count, const float *const lists[3])
{
    float *texels = (float *)calloc(12 * (size_t)count, sizeof *texels);
    glbk_texture_desc d;
    glbk_texture out;
    size_t i, k;
    assert_non_null(texels);
    for (k = 0; k < 3; k++)
        for (i = 0; i < count; i++) memcpy(texels + 4 * (k * count + i), lists[k] + 3 * i, 12);
    memset(&d, 0, sizeof d);
    d.format = GLBK_FORMAT_RGBA32UI;
    d.width = count;
    d.height = 1;
    d.layers = 3;
    d.data = texels;
    assert_glbk(now, glbk_texture_create(&now->gl, &d, &out));
    free(texels);
    return out;
}

/* The closed box of t45_a_closed_furnace_gains_half_of_the_last_bounce. VPLs of the first bounce, surfels, maps, the
   source of the second bounce and its VPLs, surfels and maps are made on the GPU. */
static void a_furnace_on_the_gpu_gains_half_of_the_last_bounce(void **state)
{
    ROW_TEST(state)
    enum { LIT = 2048 };
    static float light[3 * FURNACE_EYES];
    const glbk_ism_choice_desc of[2] = { { LIT, 1, 1, 1 }, { FURNACE_SIDE * FURNACE_SIDE, FURNACE_VPLS, 1, 1 } };
    const glbk_ism_renderer_desc eyes = { FURNACE_EYE, FURNACE_EYE };
    furnace *k = furnace_make(LIT);
    const float *const lists[3] = { k->at, k->n, k->flux };
    glbk_ism_choice choice[2];
    glbk_ism_spread spread[2];
    glbk_ism_bounces bounces;
    glbk_ism_maps maps[2];
    glbk_ism_renderer renderer;
    glbk_texture lit = texels_of(LIT, lists);
    glbk_gbuffer seen;
    double radiance = 1;
    int bounce;
    gl_see(&now->gl, FURNACE_EYE, FURNACE_EYE, eye.p, eye.n, NULL, &seen);
    assert_glbk(now, glbk_ism_renderer_create(&now->gl, &eyes, &renderer));
    for (bounce = 0; bounce < 2; bounce++) {
        assert_glbk(now, glbk_ism_maps_create(&now->gl, &k->desc, &maps[bounce]));
        assert_glbk(now, glbk_ism_mesh_upload(&now->gl, &maps[bounce], &k->mesh));
        assert_glbk(now, glbk_ism_choice_create(&now->gl, &maps[bounce], &of[bounce], &choice[bounce]));
        assert_glbk(now, glbk_ism_spread_create(&now->gl, &maps[bounce], &spread[bounce]));
        assert_glbk(now, glbk_ism_choose(&now->gl, &choice[bounce], &maps[bounce], bounce ? &bounces.texels : &lit,
                                         &seen, 0));
        assert_glbk(now, glbk_ism_scatter(&now->gl, &spread[bounce], &maps[bounce], &seen, 0));
        assert_glbk(now, glbk_ism_draw(&now->gl, &maps[bounce], 0));
        assert_glbk(now, glbk_ism_shade(&now->gl, &renderer, &seen, &maps[bounce], NULL, 0));
        gl_light_of(&now->gl, &renderer, NULL, light, NULL);
        furnace_row(light, bounce + 1, " on the GPU alone", &radiance);
        if (bounce) break;
        assert_glbk(now, glbk_ism_bounces_create(&now->gl, &maps[0], FURNACE_SIDE, &bounces));
        assert_glbk(now, glbk_ism_bounce(&now->gl, &bounces, &maps[0]));
    }
    for (bounce = 0; bounce < 2; bounce++) {
        glbk_ism_choice_free(&now->gl, &choice[bounce]);
        glbk_ism_spread_free(&now->gl, &spread[bounce]);
        glbk_ism_maps_free(&now->gl, &maps[bounce]);
    }
    glbk_ism_bounces_free(&now->gl, &bounces);
    glbk_ism_renderer_free(&now->gl, &renderer);
    glbk_gbuffer_free(&now->gl, &seen);
    glbk_texture_free(&now->gl, &lit);
}

/* ---- T58 ---- */

/* Of 2 x 2 tiles under a sheet of some opacity, so many see it. */
static void dither_has_five_levels(void **state)
{
    ROW_TEST(state)
    const float a[3] = { -4, 1, -4 }, u[3] = { 8, 0, 0 }, v[3] = { 0, 0, 8 }, up[3] = { 0, 1, 0 };
    float opacities[32];
    ism_mesh m;
    ism_points view;
    ism_frame f;
    ism_desc d;
    ism_vpl list[4];
    double wrong = 0;
    int level, i;
    mesh.triangles = 0;
    soup_quad(&mesh, a, u, v, 4);
    grid_fill(&eye, 1, 1, a, u, v, up, 0);
    view = grid_view(&eye);
    memset(&d, 0, sizeof d);
    d.vpl_count = 4;
    d.surfel_count = 512;
    d.tile_side = 16;
    for (i = 0; i < 4; i++) list[i] = util_vpl(0.1f * (float)i, 0, 0, 0, 1, 0, 1);
    for (level = 0; level <= 4; level++) {
        engine *e = engine_open(&d, &view);
        uint32_t side, x, y, seen[4] = { 0, 0, 0, 0 };
        float *atlas;
        int drawn = 0;
        for (i = 0; i < 32; i++) opacities[i] = 0.25f * (float)level;
        m = soup_mesh(&mesh);
        m.opacities = opacities;
        f = frame_of(&m, &view, 0);
        assert_int_equal(ism_set_vpls(e->cpu, list, 4), ISM_OK);
        engine_draw(e, &f);
        atlas = engine_atlas(e, &side);
        assert_int_equal(side, 32);
        for (y = 0; y < side; y++)
            for (x = 0; x < side; x++) seen[y / 16 * 2 + x / 16] += atlas[y * side + x] < ISM_FAR;
        for (i = 0; i < 4; i++) {
            assert_true(seen[i] == 0 || seen[i] > 200);      /* all of a tile's texels, but a few at the horizon */
            drawn += seen[i] > 0;
        }
        wrong += drawn != level;
        free(atlas);
        engine_close(e);
    }
    CONFORM("T58", "levels of 0, .25, .5, .75, 1 over 2 x 2 pixels that are not exact", 0, wrong, 0);
}

/* ---- T49 ---- */

/* Both ways through windows of every size. */
static void windows_zoom_as_on_the_cpu(void **state)
{
    GL_TEST(t, state)
    enum { COUNT = 4096 };
    static float fours[4 * COUNT], in[4 * COUNT];
    uint32_t seed = 9, i, k;
    for (i = 0; i < COUNT; i++) {
        uint32_t window = 0;
        for (k = 0; k < 2; k++) {
            uint32_t below = (uint32_t)(util_unit(&seed) * 64),
                     above = (uint32_t)(util_unit(&seed) * (float)(64 - below));
            window |= below << 6 * k | above << (6 * k + 12);
        }
        in[4 * i] = util_unit(&seed);
        in[4 * i + 1] = util_unit(&seed);
        in[4 * i + 2] = (float)window;
    }
    in[4] = in[5] = 0;
    in[8] = in[9] = 1;
    memcpy(fours, in, sizeof in);
    gl_ask(t, glbk_ism_part(), GL_ASK("    vec4 x, y;\n"
                     "    vec2 uv = layer(0).xy, at = 64.0 * uv;\n"
                     "    ism_axes(uint(layer(0).z), 64u, 8u, x, y);\n"
                     "    r.xy = vec2(ism_zoom_axis(x, 64.0, 8.0, uv.x), ism_zoom_axis(y, 64.0, 8.0, uv.y));\n"
                     "    r.zw = vec2(ism_unzoom_axis(x, 64.0, 8.0, at.x), ism_unzoom_axis(y, 64.0, 8.0, at.y));\n"),
           "ism_map", NULL, NULL, NULL, fours, 1, COUNT, 1, fours);
    for (i = 0; i < COUNT; i++) {
        float at[4];
        ism_zoom((uint32_t)in[4 * i + 2], 64, 8, in + 4 * i, at);
        ism_unzoom((uint32_t)in[4 * i + 2], 64, 8, in + 4 * i, at + 2);
        for (k = 0; k < 4; k++)
            if (!(fabsf(fours[4 * i + k] * (k < 2 ? 0.015625f : 1.0f) - at[k]) < 2e-5f))
                fail_msg("window %x at %g, %g: %g on GL, %g", (unsigned)in[4 * i + 2], (double)in[4 * i],
                         (double)in[4 * i + 1], (double)fours[4 * i + k], (double)at[k]);
    }
}

static void pull_and_push_fill_holes(void **state)
{
    GL_TEST(t, state)
    static float directions[4 * 4096], surfels[4 * 4096], depth[4096];
    ism_desc d;
    ism_vpl vpl = { { 0, 0, 0 }, { 0, 0, 1 }, { 1, 1, 1 }, { 0, 0, 1 }, 1, 0, 0, 0, 0, 0, 0, 0, 0 };
    const ism_info info = { 0 };
    glbk_ism_maps m;
    uint32_t seed = 3, trial;
    size_t i;
    int k;
    double constant = 0, plane = 0, between = 0, filled = 0, empty = 0, holes = 0, inner = 0;
    memset(&d, 0, sizeof d);
    d.vpl_count = d.lazy_frames = 1;
    d.surfel_count = 8;
    assert_glbk(t, glbk_ism_maps_create(&t->gl, &d, &m));
    assert_glbk(t, glbk_ism_vpls_upload(&t->gl, &m, &vpl, 1, &info));
    assert_glbk(t, glbk_ism_draw(&t->gl, &m, 0));
    assert_glbk(t, gl_read_atlas(&t->gl, &m, depth));
    for (i = 0; i < 4096; i++) empty += depth[i] < ISM_FAR;
    for (i = 0; i < 4096; i++) {
        const float uv[2] = { ((float)(i % 64) + 0.5f) / 64, ((float)(i / 64) + 0.5f) / 64 };
        ism_map_direction(ISM_PROJECTION_COSINE, 1, uv, directions + 4 * i);
    }
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
        assert_glbk(t, glbk_texture_update(&t->gl, &m.planes, &(glbk_box){ 0, 0, 0, 0, 64, 64, 1 }, surfels));
        assert_glbk(t, glbk__ism_fill(&t->gl, &m));
        assert_glbk(t, gl_read_atlas(&t->gl, &m, depth));
        for (i = 0; i < 4096; i++) {
            const float *w = directions + 4 * i;
            double truth = 1 / (0.3 * (double)w[0] - 0.2 * (double)w[1] + 0.5 * (double)w[2]);
            const int x = (int)(i % 64), y = (int)(i / 64), inside = x >= 4 && y >= 4 && x < 60 && y < 60;
            inner += trial == 0 && inside;
            if (depth[i] >= ISM_FAR) {
                holes += trial == 0 && inside;
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
    glbk_ism_maps_free(&t->gl, &m);
    /* exact but for rounding: eight of a float's last places */
    CONFORM_MAX("T49", "constant depth from 10 % points, largest relative error", 1e-6, constant);
    CONFORM_MAX("T49", "constant depth from 10 % points, share of texels left open, four from the border", 0.01,
                holes / inner);
    CONFORM_MAX("T49", "plane from 10 % points, largest relative error", 0.01, plane);
    assert_true(filled > 2900);
    CONFORM("T49", "two depths: texels with a depth between", 0, between, 0);
    CONFORM("T49", "empty tile: texels with a depth", 0, empty, 0);
}

/* What is full on one side of a line, or within a circle, and borders with four of ten texels: as on the CPU. */
static void silhouettes_and_borders_are_filled_as_on_the_cpu(void **state)
{
    GL_TEST(t, state)
    static float surfels[4 * 4096], depth[4096];
    ism_desc d;
    ism_vpl vpl = { { 0, 0, 0 }, { 0, 0, 1 }, { 1, 1, 1 }, { 0, 0, 1 }, 1, 0, 0, 0, 0, 0, 0, 0, 0 };
    const ism_info info = { 0 };
    glbk_ism_maps m;
    double grown[2] = { 0, 0 }, open = 0, count = 0;
    uint32_t seed = 5;
    size_t i;
    int trial, k;
    memset(&d, 0, sizeof d);
    d.vpl_count = d.lazy_frames = 1;
    d.surfel_count = 8;
    assert_glbk(t, glbk_ism_maps_create(&t->gl, &d, &m));
    assert_glbk(t, glbk_ism_vpls_upload(&t->gl, &m, &vpl, 1, &info));
    assert_glbk(t, glbk_ism_draw(&t->gl, &m, 0));
    for (trial = 0; trial < 148; trial++) {     /* the last twenty: borders */
        const double a = 6.283185307179586 * (trial / 2) / 64, c = cos(a), s = sin(a), shift = trial % 7 * 4 - 12;
        const double radius = 6 + trial % 5 * 4;
        for (i = 0; i < 4096; i++) {
            const float uv[2] = { ((float)(i % 64) + 0.5f) / 64, ((float)(i / 64) + 0.5f) / 64 };
            const double x = (double)(i % 64) - 31.5, y = (double)(i / 64) - 31.5;
            float w[3];
            int full = trial % 2 ? x * c + y * s < shift : hypot(x - 4 * c, y - 4 * s) < radius;
            if (trial >= 128) full = util_unit(&seed) < 0.4f;
            ism_map_direction(ISM_PROJECTION_COSINE, 1, uv, w);
            for (k = 0; k < 3; k++) surfels[4 * i + (size_t)k] = 0.5f * w[k];
            surfels[4 * i + 3] = full ? 2 : ISM_FAR;
        }
        assert_glbk(t, glbk_texture_update(&t->gl, &m.planes, &(glbk_box){ 0, 0, 0, 0, 64, 64, 1 }, surfels));
        assert_glbk(t, glbk__ism_fill(&t->gl, &m));
        assert_glbk(t, gl_read_atlas(&t->gl, &m, depth));
        for (i = 0; i < 4096; i++) {
            const int x = (int)(i % 64), y = (int)(i / 64), inside = x > 7 && y > 7 && x < 56 && y < 56;
            if (trial < 128) grown[trial % 2] += inside && !(surfels[4 * i + 3] < ISM_FAR) && depth[i] < ISM_FAR;
            else if (x == 0 || y == 0 || x == 63 || y == 63) {
                count++;
                open += !(depth[i] < ISM_FAR);
            }
        }
    }
    glbk_ism_maps_free(&t->gl, &m);
    CONFORM_MAX("T49", "constant depth from 40 % points, share of the border's texels left open", 0.01, open / count);
    CONFORM("T49", "half a tile full, 64 directions: texels filled beyond, eight from the border", 0, grown[1], 0);
    CONFORM("T49", "circles in an empty tile: texels filled beyond, eight from the border", 0, grown[0], 0);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        ISM_ROWS(gl_unit_test), gl_unit_test(pull_and_push_fill_holes),
        gl_unit_test(silhouettes_and_borders_are_filled_as_on_the_cpu), gl_unit_test(windows_zoom_as_on_the_cpu),
        gl_unit_test(dither_has_five_levels), gl_unit_test(a_furnace_on_the_gpu_gains_half_of_the_last_bounce)
    };
    (void)count;
    if (gl_this_way() && gl_this_way()->bit == GL_CORE45) unsetenv("CONFORMANCE");     /* the page has the core path */
    GL_TEST_MAIN(values, tests, GL_CORE45 | GL_CORE33);
}
