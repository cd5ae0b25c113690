/* rsm_pass_test - the passes of glbk_rsm by themselves: closed forms on maps that GL drew (T25, T30, T40 of
   docs/conformance.md), bad arguments, GL errors put into every call, no memory, a hostile state, a lost context. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend.h"

#define CONFORM_BACKEND "gl"
#include "conformance.h"
#include "gl/gl_test.h"
#include "gl/gl_fake.h"

#define PI 3.14159265358979

enum { SIDE = 8, PIXELS = SIDE * SIDE, MOST = 3100 };

/* Triangles of one colour. */
typedef struct body { float corners[3 * MOST]; uint32_t count, array; glbk_buffer buffer; float albedo; } body;

static body b;
static float answers[4 * PIXELS];

static void body_begin(float albedo)
{
    memset(&b, 0, sizeof b);
    b.albedo = albedo;
}

static void corner(double x, double y, double z)
{
    assert_true(b.count < MOST);
    b.corners[3 * b.count] = (float)x;
    b.corners[3 * b.count + 1] = (float)y;
    b.corners[3 * b.count++ + 2] = (float)z;
}

static void quad(const double o[3], const double u[3], const double v[3])
{
    static const int s[6] = { 0, 1, 1, 0, 1, 0 }, r[6] = { 0, 0, 1, 0, 1, 1 };
    int i;
    for (i = 0; i < 6; i++)
        corner(o[0] + s[i] * u[0] + r[i] * v[0], o[1] + s[i] * u[1] + r[i] * v[1], o[2] + s[i] * u[2] + r[i] * v[2]);
}

static void body_end(gl_test *t)
{
    const glbk_functions *gl = &t->gl.gl;
    assert_glbk(t, glbk_buffer_create(&t->gl, 12 * (size_t)b.count, b.corners, &b.buffer));
    gl->GenVertexArrays(1, &b.array);
    gl->BindVertexArray(b.array);
    gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, b.buffer.name);
    gl->EnableVertexAttribArray(0);
    gl->VertexAttribPointer(0, 3, GLBK_GL_FLOAT, 0, 0, NULL);
    gl->BindVertexArray(0);
    gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, 0);
}

static void body_free(gl_test *t)
{
    t->gl.gl.DeleteVertexArrays(1, &b.array);
    glbk_buffer_destroy(&t->gl, &b.buffer);
}

static void draw(void *user, glbk_context *ctx, glbk_rsm_renderer *r)
{
    glbk_rsm_surface s = { { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 0, 0, 0 }, 0, NULL, 0 };
    (void)user;
    s.albedo[0] = s.albedo[1] = s.albedo[2] = b.albedo;
    if (glbk_rsm_object(ctx, r, &s) != GLBK_OK) return;
    ctx->gl.BindVertexArray(b.array);
    ctx->gl.DrawArrays(GLBK_GL_TRIANGLES, 0, (int32_t)b.count);
}

static glbk_rsm_lamp lamp_of(glbk_rsm_kind kind, float value)
{
    glbk_rsm_lamp l;
    memset(&l, 0, sizeof l);
    l.kind = kind;
    l.direction[1] = kind == GLBK_RSM_SUN ? 1.0f : -1.0f;
    l.value[0] = l.value[1] = l.value[2] = value;
    l.radius = 1.25f;
    l.cone_angle = 1;
    return l;
}

static glbk_rsm_renderer renderer_of(gl_test *t)
{
    glbk_rsm_renderer r;
    glbk_rsm_renderer_desc d = { SIDE, SIDE, 1, 1 };
    assert_glbk(t, glbk_rsm_renderer_create(&t->gl, &d, &r));
    return r;
}

/* All pixels are one receiver. */
static void look_at(gl_test *t, glbk_rsm_renderer *r, double x, double y, double z, double nx, double ny, double nz)
{
    static glbk_rsm_pixel pixels[PIXELS];
    int i;
    for (i = 0; i < PIXELS; i++) {
        glbk_rsm_pixel p = { { 0, 0, 0 }, { 0, 0, 0 }, { 1, 1, 1 }, 1 };
        p.position[0] = (float)x, p.position[1] = (float)y, p.position[2] = (float)z;
        p.normal[0] = (float)nx, p.normal[1] = (float)ny, p.normal[2] = (float)nz;
        pixels[i] = p;
    }
    assert_glbk(t, glbk_rsm_gbuffer_upload(&t->gl, r, 0, SIDE, pixels));
}

static glbk_rsm_gather_desc by_flux(uint32_t samples)
{
    glbk_rsm_gather_desc d;
    memset(&d, 0, sizeof d);
    d.pattern = GLBK_RSM_PATTERN_FLUX;
    d.samples = samples;
    return d;
}

/* Disc of radius 1, rho E0 = 1, receiver 1 above: exactly a half. */
static void one_over_pi(void **state)
{
    GL_TEST(t, state)
    glbk_rsm_lamp lamp = lamp_of(GLBK_RSM_SUN, 2);
    glbk_rsm_renderer r = renderer_of(t);
    glbk_rsm_map map, *maps[1];
    glbk_rsm_gather_desc d = by_flux(0);
    double sum = 0;
    int k;
    body_begin(0.5f);
    for (k = 0; k < 1024; k++) {
        corner(0, 0, 0);
        corner(cos(2 * PI * (k + 1) / 1024), 0, sin(2 * PI * (k + 1) / 1024));
        corner(cos(2 * PI * k / 1024), 0, sin(2 * PI * k / 1024));
    }
    body_end(t);
    assert_glbk(t, glbk_rsm_map_create(&t->gl, &lamp, 512, &map));
    maps[0] = &map;
    assert_glbk(t, glbk_rsm_map_draw(&t->gl, &r, &map, draw, NULL));
    look_at(t, &r, 0, 1, 0, 0, -1, 0);
    d.lights_per_pass = 65536;
    assert_glbk(t, glbk_rsm_gather(&t->gl, &r, maps, 1, &d, NULL));
    assert_glbk(t, glbk_rsm_read(&t->gl, &r, 1, answers));
    /* the rim of the disc in texels: 1e-4 of its area */
    CONFORM("T25", "irradiance over a disc / (rho E0), every texel", 0.5, answers[0], 4e-4);
    for (k = 0; k < 8; k++) {
        d = by_flux(4000);
        d.seed = (uint32_t)k;
        assert_glbk(t, glbk_rsm_gather(&t->gl, &r, maps, 1, &d, NULL));
        assert_glbk(t, glbk_rsm_read(&t->gl, &r, 1, answers));
        sum += (double)answers[4 * (PIXELS - 1)] / 8;
    }
    CONFORM("T25", "irradiance over a disc / (rho E0), 4000 samples, flux", 0.5, sum, 0.004);
    look_at(t, &r, 0, 0, 0, 0, 0, 0);       /* nothing is seen: no light */
    assert_glbk(t, glbk_rsm_gather(&t->gl, &r, maps, 1, &d, NULL));
    assert_glbk(t, glbk_rsm_read(&t->gl, &r, 1, answers));
    for (k = 0; k < 4 * PIXELS; k++) assert_true(!(fabsf(answers[k]) > 0));
    glbk_rsm_map_destroy(&t->gl, &map);
    glbk_rsm_renderer_destroy(&t->gl, &r);
    body_free(t);
}

/* Flux of a map whose light stands in a white box. */
static double flux_of(gl_test *t, glbk_rsm_renderer *r, glbk_rsm_kind kind, double degrees, uint32_t size)
{
    static float texels[12 * 256 * 256];
    glbk_rsm_lamp lamp = lamp_of(kind, 1);
    glbk_rsm_map map;
    double sum = 0;
    uint32_t f, i;
    lamp.cone_angle = degrees > 0 ? (float)(degrees * PI / 180) : 1;
    assert_glbk(t, glbk_rsm_map_create(&t->gl, &lamp, size, &map));
    assert_glbk(t, glbk_rsm_map_draw(&t->gl, r, &map, draw, NULL));
    for (f = 0; f < map.faces; f++) {
        assert_glbk(t, glbk_rsm_map_read(&t->gl, &map, f, texels));
        for (i = 0; i < size * size; i++) sum += (double)texels[12 * i + 8];
    }
    glbk_rsm_map_destroy(&t->gl, &map);
    return sum;
}

static void flux_of_lamps(void **state)
{
    GL_TEST(t, state)
    static const double lo[3] = { -3, -4, -5 }, hi[3] = { 3, 4, 5 };
    static const double u[3] = { 6, 0, 0 }, v[3] = { 0, 8, 0 }, w[3] = { 0, 0, 10 };
    static const double mu[3] = { -6, 0, 0 }, mv[3] = { 0, -8, 0 }, mw[3] = { 0, 0, -10 };
    glbk_rsm_renderer r = renderer_of(t);
    body_begin(1);
    quad(lo, u, v), quad(lo, v, w), quad(lo, w, u), quad(hi, mu, mv), quad(hi, mv, mw), quad(hi, mw, mu);
    body_end(t);
    /* tolerances as on the CPU: tests/conformance/rsm_map_test.c */
    CONFORM("T30", "flux of a square spot of 90 degrees, 256 x 256", 2.094395,
            flux_of(t, &r, GLBK_RSM_SQUARE_SPOT, 90, 256), 2e-5);
    CONFORM("T30", "the same, 4 x 4", 2.094395, flux_of(t, &r, GLBK_RSM_SQUARE_SPOT, 90, 4), 2e-5);
    CONFORM("T30", "flux of a cone of half angle 30 degrees", 0.841787, flux_of(t, &r, GLBK_RSM_SPOT, 60, 256), 2e-4);
    CONFORM("T30", "flux of a cone of half angle 100 degrees: a cube", 2 * PI * (1 - cos(100 * PI / 180)),
            flux_of(t, &r, GLBK_RSM_SPOT, 200, 128), 1e-3);
    CONFORM("T30", "flux of a point light of intensity 1", 4 * PI, flux_of(t, &r, GLBK_RSM_POINT, 0, 64), 1e-4);
    CONFORM("T30", "flux of a patch of intensity 1 along its normal", PI, flux_of(t, &r, GLBK_RSM_PATCH, 0, 64), 1e-3);
    glbk_rsm_renderer_destroy(&t->gl, &r);
    body_free(t);
}

/* An endless plane sees none of its own light. */
static void no_light_of_its_own(void **state)
{
    GL_TEST(t, state)
    static const double o[3] = { -50, 0.5, -50 }, u[3] = { 100, 0, 0 }, v[3] = { 0, 0, 100 };
    glbk_rsm_lamp lamp = lamp_of(GLBK_RSM_SUN, 1);
    glbk_rsm_renderer r = renderer_of(t);
    glbk_rsm_map map, *maps[1];
    glbk_rsm_gather_desc d = by_flux(500);
    double most = 0;
    int i;
    body_begin(1);
    quad(o, v, u);
    body_end(t);
    lamp.radius = 4;
    lamp.direction[0] = 0.6f, lamp.direction[1] = 0.8f;
    assert_glbk(t, glbk_rsm_map_create(&t->gl, &lamp, 64, &map));
    maps[0] = &map;
    assert_glbk(t, glbk_rsm_map_draw(&t->gl, &r, &map, draw, NULL));
    look_at(t, &r, 0.1, 0.5, 0.23, 0, 1, 0);
    assert_glbk(t, glbk_rsm_gather(&t->gl, &r, maps, 1, &d, NULL));
    assert_glbk(t, glbk_rsm_read(&t->gl, &r, 1, answers));
    for (i = 0; i < PIXELS; i++) most = fmax(most, (double)answers[4 * i]);
    CONFORM("T40", "most light of an endless plane on itself, drawn by GL", 0, most, 0);
    glbk_rsm_map_destroy(&t->gl, &map);
    glbk_rsm_renderer_destroy(&t->gl, &r);
    body_free(t);
}

/* ---- errors ---- */

static void bad_arguments(void **state)
{
    GL_TEST(t, state)
    glbk_rsm_lamp good = lamp_of(GLBK_RSM_SUN, 1), bad;
    glbk_rsm_renderer r = renderer_of(t);
    glbk_rsm_renderer_desc none = { 0, 4, 0, 0 };
    glbk_rsm_map map, *maps[2] = { &map, NULL };
    glbk_rsm_gather_desc d = by_flux(10);
    glbk_rsm_grid grid = { 3, 0, 0, 0, 0, 0, 0 };
    glbk_rsm_direct_desc direct = { 16, 0, 0 };
    glbk_rsm_denoise_desc denoise;
    glbk_rsm_tables tables;
    glbk_pass pass;
    float m[16] = { 0 }, point[3] = { 0, 0, 0 };
    int i;
    memset(&denoise, 0, sizeof denoise);
    memset(&tables, 0, sizeof tables);
    memset(&pass, 0, sizeof pass);
    for (i = 0; i < 9; i++) {
        bad = good;
        if (i == 0) bad.radius = -1;
        if (i == 1) bad.direction[1] = 2;
        if (i == 2) bad.value[2] = -1;
        if (i == 3) bad.position[0] = NAN;
        if (i == 4) bad.kind = GLBK_RSM_KIND_COUNT;
        if (i == 5) bad.kind = GLBK_RSM_SPOT, bad.cone_angle = 7;
        if (i == 6) bad.near_depth = 2, bad.far_depth = 1;
        if (i == 7) bad.kind = GLBK_RSM_SQUARE_SPOT, bad.cone_angle = 2.5f;
        if (i == 8) bad.up[1] = INFINITY;
        assert_int_equal(glbk_rsm_map_create(&t->gl, &bad, 16, &map), GLBK_ERR_ARGUMENT);
        assert_int_equal(map.texels.name, 0);
    }
    assert_int_equal(glbk_rsm_map_create(&t->gl, &good, 3, &map), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_map_create(&t->gl, &good, 4097, &map), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_map_create(&t->gl, NULL, 16, &map), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_map_draw(&t->gl, &r, &map, draw, NULL), GLBK_ERR_ARGUMENT);       /* no map yet */
    assert_int_equal(glbk_rsm_map_upload(&t->gl, &map, m), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_gather(&t->gl, &r, maps, 1, &d, NULL), GLBK_ERR_ARGUMENT);
    assert_glbk(t, glbk_rsm_map_create(&t->gl, &good, 16, &map));
    bad.kind = GLBK_RSM_POINT;
    bad.up[1] = 0;
    assert_int_equal(glbk_rsm_map_place(&t->gl, &map, &bad), GLBK_ERR_ARGUMENT);                /* six faces */
    assert_int_equal(glbk_rsm_map_read(&t->gl, &map, 1, m), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_gather(&t->gl, &r, maps, 2, &d, NULL), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_gather(&t->gl, &r, maps, 1, &d, &grid), GLBK_ERR_ARGUMENT);
    d.interleave = 3;
    assert_int_equal(glbk_rsm_gather(&t->gl, &r, maps, 1, &d, NULL), GLBK_ERR_ARGUMENT);
    d.interleave = 2, grid.step = 8;
    assert_int_equal(glbk_rsm_gather(&t->gl, &r, maps, 1, &d, &grid), GLBK_ERR_ARGUMENT);       /* not both */
    d.interleave = 0, d.pattern = GLBK_RSM_PATTERN_ABOUT;
    assert_int_equal(glbk_rsm_gather(&t->gl, &r, maps, 1, &d, NULL), GLBK_ERR_ARGUMENT);        /* no points */
    tables.points = point;
    assert_int_equal(glbk_rsm_tables_upload(&t->gl, &r, &tables), GLBK_ERR_ARGUMENT);
    tables.point_count = (1u << 20) + 1;
    assert_int_equal(glbk_rsm_tables_upload(&t->gl, &r, &tables), GLBK_ERR_LIMIT);
    d = by_flux(10), d.clamp = NAN;
    assert_int_equal(glbk_rsm_gather(&t->gl, &r, maps, 1, &d, NULL), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_direct(&t->gl, &r, (const glbk_rsm_map *const *)maps, 1, &direct), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_denoise(&t->gl, &r, &denoise), GLBK_ERR_ARGUMENT);                /* nothing gathered */
    assert_int_equal(glbk_rsm_read(&t->gl, &r, 1, answers), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_gbuffer_draw(&t->gl, &r, m, NULL, draw, NULL), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_resolve(&t->gl, &r, NULL, 1, 1), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_resolve(NULL, &r, &pass, 1, 1), GLBK_ERR_ARGUMENT);
    glbk_rsm_map_destroy(&t->gl, &map);
    glbk_rsm_map_destroy(&t->gl, &map);
    glbk_rsm_map_destroy(&t->gl, NULL);
    glbk_rsm_renderer_destroy(&t->gl, &r);
    glbk_rsm_renderer_destroy(&t->gl, &r);
    assert_int_equal(glbk_rsm_renderer_create(&t->gl, &none, &r), GLBK_ERR_ARGUMENT);
}

/* ---- faults: the n-th time that glGetError is asked it has something to say ---- */

static glbk_result make(gl_test *t, glbk_rsm_map *map, glbk_rsm_renderer *r)
{
    static const float points[3 * 32], texels[12 * 16 * 5];
    glbk_rsm_lamp lamp = lamp_of(GLBK_RSM_PATCH, 1);
    glbk_rsm_renderer_desc d = { SIDE, SIDE, 1, 1 };
    glbk_rsm_tables tables = { points, 32, points, 4, points, 2 };
    glbk_result result;
    memset(r, 0, sizeof *r);
    result = glbk_rsm_map_create(&t->gl, &lamp, 4, map);
    if (result == GLBK_OK) result = glbk_rsm_renderer_create(&t->gl, &d, r);
    if (result == GLBK_OK) result = glbk_rsm_tables_upload(&t->gl, r, &tables);
    if (result == GLBK_OK) result = glbk_rsm_map_upload(&t->gl, map, texels);
    return result;
}

/* A whole frame with every pass. */
static glbk_result frame(gl_test *t, glbk_rsm_map *map, glbk_rsm_renderer *r, const glbk_target *target)
{
    static const float view[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0.1f, 0, 0, 0, 0, 1 }, eye[3] = { 0, 3, 0 };
    const glbk_rsm_tables tables = { NULL, 0, NULL, 0, NULL, 0 };
    glbk_rsm_gather_desc d = by_flux(20);
    glbk_rsm_grid grid = { 4, 0, 0, 0, 0, 0, 0 };
    glbk_rsm_direct_desc direct = { 2, 0.5f, 1 };
    glbk_rsm_denoise_desc denoise;
    glbk_pass pass;
    glbk_result result;
    memset(&denoise, 0, sizeof denoise);
    memset(&pass, 0, sizeof pass);
    denoise.view_projection = view;
    denoise.passes = 2;
    pass.target = target;
    result = glbk_rsm_tables_upload(&t->gl, r, &tables);
    if (result == GLBK_OK) result = glbk_rsm_map_draw(&t->gl, r, map, draw, NULL);
    if (result == GLBK_OK) result = glbk_rsm_gbuffer_draw(&t->gl, r, view, eye, draw, NULL);
    if (result == GLBK_OK) result = glbk_rsm_direct(&t->gl, r, (const glbk_rsm_map *const *)&map, 1, &direct);
    if (result == GLBK_OK) result = glbk_rsm_gather(&t->gl, r, &map, 1, &d, &grid);
    if (result == GLBK_OK) result = glbk_rsm_denoise(&t->gl, r, &denoise);
    if (result == GLBK_OK) result = glbk_rsm_resolve(&t->gl, r, &pass, 1, 1);
    if (result == GLBK_OK) result = glbk_rsm_read(&t->gl, r, 1, answers);
    return result;
}

static void small_room(gl_test *t)
{
    static const double o[3] = { -1, -1, -1 }, u[3] = { 2, 0, 0 }, v[3] = { 0, 2, 0 }, w[3] = { 0, 0, 2 };
    body_begin(0.7f);
    quad(o, w, u), quad(o, u, v), quad(o, v, w);
    body_end(t);
}

static void gl_fails_in_every_call(void **state)
{
    GL_TEST(t, state)
    glbk_rsm_map map;
    glbk_rsm_renderer r;
    glbk_result result;
    gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_RGBA8, SIDE, SIDE, 0);
    int failed = 0;
    small_room(t);
    fake_begin(t, 0x0505);
    for (fake.at = 1;; fake.at++) {
        fake.calls = 0;
        result = make(t, &map, &r);
        if (result == GLBK_OK) break;
        assert_true(result == GLBK_ERR_PENDING || result == GLBK_ERR_GL_MEMORY);
        glbk_rsm_renderer_destroy(&t->gl, &r);
        glbk_rsm_map_destroy(&t->gl, &map);
        assert_int_equal(fake.live, 0);
        failed++;
    }
    assert_true(failed > 100);
    fake.at = 0;
    assert_glbk(t, frame(t, &map, &r, &c.target));      /* compiles all programs */
    for (failed = 0, fake.at = 1;; fake.at++) {
        fake.calls = 0;
        result = frame(t, &map, &r, &c.target);
        if (result == GLBK_OK) break;
        assert_true(result == GLBK_ERR_PENDING || result == GLBK_ERR_GL || result == GLBK_ERR_GL_MEMORY);
        failed++;
    }
    printf("%d calls of a frame failed in turn\n", failed);
    assert_true(failed > 30);
    fake.at = 0;
    assert_glbk(t, frame(t, &map, &r, &c.target));
    glbk_rsm_renderer_destroy(&t->gl, &r);
    glbk_rsm_map_destroy(&t->gl, &map);
    assert_int_equal(fake.live, 0);
    t->gl.gl = fake.real;
    gl_canvas_free(t, &c);
    body_free(t);
}

static void *no_memory(size_t size, void *user) { return (void)size, (void)user, (void *)NULL; }
static void release(void *memory, void *user) { (void)user, free(memory); }

static void no_memory_and_no_context(void **state)
{
    GL_TEST(t, state)
    static const float texels[12 * 16 * 5], points[3];
    static const glbk_rsm_pixel pixels[SIDE];
    glbk_rsm_map map;
    glbk_rsm_renderer r;
    glbk_rsm_tables tables = { points, 1, NULL, 0, NULL, 0 };
    glbk_functions real = t->gl.gl;
    float out[12 * 16];
    assert_glbk(t, make(t, &map, &r));
    t->gl.allocator.alloc_fn = no_memory;
    t->gl.allocator.free_fn = release;
    assert_int_equal(glbk_rsm_map_upload(&t->gl, &map, texels), GLBK_ERR_ALLOC);
    assert_int_equal(glbk_rsm_map_read(&t->gl, &map, 0, out), GLBK_ERR_ALLOC);
    assert_int_equal(glbk_rsm_gbuffer_upload(&t->gl, &r, 0, 1, pixels), GLBK_ERR_ALLOC);
    assert_int_equal(glbk_rsm_tables_upload(&t->gl, &r, &tables), GLBK_ERR_ALLOC);
    memset(&t->gl.allocator, 0, sizeof t->gl.allocator);
    assert_glbk(t, glbk_rsm_map_upload(&t->gl, &map, texels));
    t->gl.lost = 1;
    memset(&t->gl.gl, 0, sizeof t->gl.gl);      /* whatever calls GL crashes */
    assert_int_equal(glbk_rsm_map_upload(&t->gl, &map, texels), GLBK_ERR_LOST);
    assert_int_equal(glbk_rsm_map_draw(&t->gl, &r, &map, draw, NULL), GLBK_ERR_LOST);
    {
        glbk_rsm_map copy = map;
        glbk_rsm_renderer other = r;
        glbk_rsm_map_destroy(&t->gl, &copy);
        glbk_rsm_renderer_destroy(&t->gl, &other);
    }
    t->gl.gl = real;
    t->gl.lost = 0;
    glbk_rsm_map_destroy(&t->gl, &map);
    glbk_rsm_renderer_destroy(&t->gl, &r);
}

/* ---- state ---- */

static const uint32_t switches[] = { 0x0BE2 /* blend */, 0x0C11 /* scissor */, 0x0B90 /* stencil */, 0x0B44 /* cull */,
                                     0x0BD0 /* dither */, 0x809E /* alpha to coverage */, 0x8037 /* polygon offset */ };
static const uint32_t values[] = { 0x8CA6, 0x8CAA, 0x8B8D, 0x85B5, 0x84E0, 0x0B74, 0x0B45, 0x0B46,
                                   0x8069, 0x8C1D, 0x8A28, 0x8894, 0x88ED, 0x88EF, 0x0CF5, 0x0D05 };
enum { SWITCHES = sizeof switches / sizeof switches[0], VALUES = sizeof values / sizeof values[0] };

static void read_state(const glbk_functions *gl, int32_t *out)
{
    int i;
    for (i = 0; i < SWITCHES; i++) *out++ = gl->IsEnabled(switches[i]);
    for (i = 0; i < VALUES; i++) gl->GetIntegerv(values[i], out++);
    gl->GetIntegerv(0x0BA2 /* viewport */, out);
}

static void hostile_state(void **state)
{
    GL_TEST(t, state)
    const glbk_functions *gl = &t->gl.gl;
    static float calm[4 * PIXELS];
    int32_t before[SWITCHES + VALUES + 4], after[SWITCHES + VALUES + 4];
    glbk_rsm_map map;
    glbk_rsm_renderer r;
    glbk_state saved;
    gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_RGBA8, SIDE, SIDE, 0);
    double sum = 0;
    int i;
    small_room(t);
    assert_glbk(t, make(t, &map, &r));
    assert_glbk(t, frame(t, &map, &r, &c.target));
    memcpy(calm, answers, sizeof calm);
    for (i = 0; i < PIXELS; i++) sum += (double)calm[4 * i];
    assert_true(sum > 0.1);
    glbk_rsm_forget(&r);
    for (i = 0; i < SWITCHES; i++) gl->Enable(switches[i]);
    gl->Scissor(1, 1, 2, 2);
    gl->DepthFunc(0x0200 /* never */);
    gl->DepthMask(0);
    gl->ColorMask(0, 1, 0, 0);
    gl->CullFace(0x0408 /* front and back */);
    gl->FrontFace(0x0900);
    gl->PolygonOffset(3, 7);
    gl->BlendFuncSeparate(0, 0, 0, 0);
    gl->PixelStorei(0x0CF5, 8);
    gl->PixelStorei(0x0D05, 8);
    gl->Viewport(1, 2, 3, 4);
    gl->ActiveTexture(GLBK_GL_TEXTURE0 + 5);
    gl->BindTexture(GLBK_GL_TEXTURE_2D, c.color.name);
    read_state(gl, before);
    glbk_state_save(&t->gl, &saved);
    assert_glbk(t, frame(t, &map, &r, &c.target));
    glbk_state_restore(&t->gl, &saved);
    read_state(gl, after);
    assert_memory_equal(before, after, sizeof before);
    assert_memory_equal(calm, answers, sizeof calm);
    for (i = 0; i < SWITCHES; i++) gl->Disable(switches[i]);
    gl->ColorMask(1, 1, 1, 1);
    gl->DepthMask(1);
    glbk_rsm_renderer_destroy(&t->gl, &r);
    glbk_rsm_map_destroy(&t->gl, &map);
    gl_canvas_free(t, &c);
    body_free(t);
}

int main(int count, char **arguments)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(one_over_pi),   gl_unit_test(flux_of_lamps),          gl_unit_test(no_light_of_its_own),
        gl_unit_test(bad_arguments), gl_unit_test(gl_fails_in_every_call), gl_unit_test(no_memory_and_no_context),
        gl_unit_test(hostile_state)
    };
    (void)count;
    if (gl_this_way() && gl_this_way()->bit != GL_CORE45) unsetenv("CONFORMANCE");      /* one line a row */
    GL_TEST_MAIN(arguments, tests, GL_CORE45 | GL_ES30_BARE);
}
