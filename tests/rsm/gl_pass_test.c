/* gl_pass_test - the passes of glbk_rsm by themselves: bad arguments, GL errors put into every call, no memory, a
   hostile state, a lost context. */
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

#include "gl_backend/gl_rsm.h"

#include "gl_test.h"
#include "gl_fake.h"
#include "gl_state.h"

enum { SIDE = 8, PIXELS = SIDE * SIDE };

/* Three walls of a room, of albedo 0.7. */
typedef struct body { uint32_t array; glbk_buffer buffer; } body;

static body b;
static float answers[4 * PIXELS];
static glbk_gbuffer seen;       /* by the renderers of a test */

static void small_room(gl_test *t)
{
    static const float u[6] = { -1, 1, 1, -1, 1, -1 }, v[6] = { -1, -1, 1, -1, 1, 1 };
    float corners[3 * 18];
    const glbk_functions *gl = &t->gl.gl;
    int i;
    for (i = 0; i < 18; i++) {
        corners[3 * i + i / 6] = -1;
        corners[3 * i + (i / 6 + 1) % 3] = u[i % 6];
        corners[3 * i + (i / 6 + 2) % 3] = v[i % 6];
    }
    assert_glbk(t, glbk_buffer_create(&t->gl, sizeof corners, corners, &b.buffer));
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
    glbk_buffer_free(&t->gl, &b.buffer);
}

static glbk_surface grey(void)
{
    glbk_surface s;
    memset(&s, 0, sizeof s);
    s.material.diffuse[0] = s.material.diffuse[1] = s.material.diffuse[2] = 0.7f;
    return s;
}

static void draw(void *user, glbk_context *ctx, glbk_rsm_renderer *r)
{
    const glbk_surface s = grey();
    (void)user;
    if (glbk_rsm_object(ctx, r, &s, 0) != GLBK_OK) return;
    ctx->gl.BindVertexArray(b.array);
    ctx->gl.DrawArrays(GLBK_GL_TRIANGLES, 0, 18);
}

static rsm_light lamp_of(rsm_light_kind kind, float value)
{
    rsm_light l;
    memset(&l, 0, sizeof l);
    l.kind = kind;
    l.direction[1] = kind == RSM_LIGHT_SUN ? 1.0f : -1.0f;
    l.value[0] = l.value[1] = l.value[2] = value;
    l.radius = 1.25f;
    l.cone_half_angle = 0.5f;
    return l;
}

static void look(gl_test *t)
{
    glbk_gbuffer_desc d;
    memset(&d, 0, sizeof d);
    d.width = d.height = SIDE;
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &d, &seen));
}

static glbk_rsm_renderer renderer_of(gl_test *t)
{
    glbk_rsm_renderer r;
    glbk_rsm_renderer_desc d = { SIDE, SIDE, 1, 1, 0, { 0, 0, 0, 0, NULL, NULL } };
    assert_glbk(t, glbk_rsm_renderer_create(&t->gl, &d, &r));
    return r;
}

static rsm_gather_desc by_flux(uint32_t samples)
{
    rsm_gather_desc d;
    memset(&d, 0, sizeof d);
    d.pattern = RSM_PATTERN_FLUX;
    d.sample_count = samples;
    return d;
}

/* ---- errors ---- */

static void bad_arguments_are_refused(void **state)
{
    GL_TEST(t, state)
    rsm_light good = lamp_of(RSM_LIGHT_SUN, 1), bad;
    glbk_rsm_renderer r = renderer_of(t);
    glbk_rsm_renderer_desc none = { 0, 4, 0, 0, 0, { 0, 0, 0, 0, NULL, NULL } };
    glbk_rsm_map map, *maps[2] = { &map, NULL };
    rsm_gather_desc d = by_flux(10);
    rsm_interpolation grid = { 3, 0, 0, 0, 0, 0, 0, NULL };
    rsm_direct_desc direct;
    rsm_texel texel;
    glbk_pass pass;
    float point[3] = { 0, 0, 0 };
    int i;
    memset(&direct, 0, sizeof direct);
    direct.tap_side = 16;
    look(t);
    memset(&pass, 0, sizeof pass);
    for (i = 0; i < 9; i++) {
        bad = good;
        if (i == 0) bad.radius = -1;
        if (i == 1) bad.direction[1] = 0;
        if (i == 2) bad.value[2] = -1;
        if (i == 3) bad.position[0] = NAN;
        if (i == 4) bad.kind = RSM_LIGHT_COUNT;
        if (i == 5) bad.kind = RSM_LIGHT_SPOT, bad.cone_half_angle = 3.5f;
        if (i == 6) bad.near_depth = 2, bad.far_depth = 1;
        if (i == 7) bad.kind = RSM_LIGHT_SQUARE_SPOT, bad.cone_half_angle = 1.25f;
        if (i == 8) bad.up[1] = INFINITY;
        assert_int_equal(glbk_rsm_map_create(&t->gl, &bad, 16, &map), GLBK_ERR_DESC);
        assert_int_equal(map.texels.name, 0);
    }
    assert_int_equal(glbk_rsm_map_create(&t->gl, &good, 3, &map), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_map_create(&t->gl, &good, 4097, &map), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_map_create(&t->gl, NULL, 16, &map), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_map_draw(&t->gl, &r, &map, draw, NULL), GLBK_ERR_ARGUMENT);       /* no map yet */
    assert_int_equal(glbk_rsm_map_upload(&t->gl, &map, &texel), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_gather(&t->gl, &r, &seen, maps, 1, &d), GLBK_ERR_ARGUMENT);
    assert_glbk(t, glbk_rsm_map_create(&t->gl, &good, 16, &map));
    bad.kind = RSM_LIGHT_POINT;
    bad.up[1] = 0;
    assert_int_equal(glbk_rsm_map_place(&t->gl, &map, &bad), GLBK_ERR_MISMATCH);                /* six faces */
    assert_int_equal(glbk_rsm_map_read(&t->gl, &map, 1, &texel), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_gather(&t->gl, &r, &seen, maps, 2, &d), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_interpolate(&t->gl, &r, &seen, maps, 1, &d, &grid), GLBK_ERR_DESC);
    d.interleave = 3;
    assert_int_equal(glbk_rsm_gather(&t->gl, &r, &seen, maps, 1, &d), GLBK_ERR_DESC);
    d.interleave = 2, grid.step = 8;
    assert_int_equal(glbk_rsm_interpolate(&t->gl, &r, &seen, maps, 1, &d, &grid), GLBK_ERR_DESC);      /* not both */
    d.interleave = 0, d.pattern = RSM_PATTERN_POISSON;
    assert_int_equal(glbk_rsm_gather(&t->gl, &r, &seen, maps, 1, &d), GLBK_ERR_MISMATCH);              /* no points */
    assert_int_equal(glbk_rsm_tables_upload(&t->gl, &r, &d, NULL), GLBK_ERR_ARGUMENT);
    d = by_flux(10);
    assert_int_equal(glbk_rsm_tables_upload(&t->gl, &r, &d, point), GLBK_ERR_ARGUMENT);
    d.clamp = NAN;
    assert_int_equal(glbk_rsm_gather(&t->gl, &r, &seen, maps, 1, &d), GLBK_ERR_DESC);
    assert_int_equal(glbk_rsm_direct(&t->gl, &r, &seen, (const glbk_rsm_map *const *)maps, 1, &direct), GLBK_ERR_DESC);
    assert_int_equal(glbk_rsm_denoise(&t->gl, &r, &seen, NULL, NULL), GLBK_ERR_ORDER);      /* nothing gathered */
    assert_int_equal(glbk_rsm_read(&t->gl, &r, 1, answers), GLBK_ERR_ORDER);
    assert_int_equal(glbk_rsm_resolve(&t->gl, &r, &seen, NULL, NULL, 1, 1), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_resolve(NULL, &r, &seen, &pass, NULL, 1, 1), GLBK_ERR_ARGUMENT);
    glbk_rsm_map_free(&t->gl, &map);
    glbk_rsm_map_free(&t->gl, &map);
    glbk_rsm_map_free(&t->gl, NULL);
    glbk_rsm_renderer_free(&t->gl, &r);
    glbk_rsm_renderer_free(&t->gl, &r);
    glbk_gbuffer_free(&t->gl, &seen);
    assert_int_equal(glbk_rsm_renderer_create(&t->gl, &none, &r), GLBK_ERR_DESC);
}

/* ---- faults: the n-th time that glGetError is asked it has something to say ---- */

/* A pattern, blue noise and lobes of zeros. */
static rsm_gather_desc with_tables(void)
{
    static const float noise[16];
    static const rsm_material materials[2];
    rsm_gather_desc d = by_flux(32);
    d.pattern = RSM_PATTERN_LOG_RADIAL;
    d.noise = noise;
    d.noise_side = 4;
    d.materials = materials;
    d.material_count = 2;
    return d;
}

static const float points[3 * 32];
static const rsm_texel texels[16 * 5];

static glbk_result make(gl_test *t, glbk_rsm_map *map, glbk_rsm_renderer *r)
{
    const rsm_gather_desc tables = with_tables();
    rsm_light lamp = lamp_of(RSM_LIGHT_PATCH, 1);
    glbk_rsm_renderer_desc d = { SIDE, SIDE, 1, 1, 0, { 0, 0, 0, 0, NULL, NULL } };
    glbk_result result = GLBK_OK;
    rsm_texel back[16];
    memset(r, 0, sizeof *r);
    GL_THEN_SAME(t, result, glbk_rsm_map_create(&t->gl, &lamp, 4, map));
    GL_THEN_SAME(t, result, glbk_rsm_renderer_create(&t->gl, &d, r));
    GL_THEN_SAME(t, result, glbk_rsm_tables_upload(&t->gl, r, &tables, points));
    GL_THEN_SAME(t, result, glbk_rsm_map_upload(&t->gl, map, texels));
    GL_THEN_SAME(t, result, glbk_rsm_map_read(&t->gl, map, 0, back));
    return result;
}

static glbk_result draw_seen(gl_test *t, const float view[16], const float eye[3])
{
    const glbk_surface s = grey();
    glbk_result result = glbk_gbuffer_begin(&t->gl, &seen, view, eye);
    if (result == GLBK_OK) result = glbk_gbuffer_object(&t->gl, &seen, &s);
    if (result != GLBK_OK) return result;
    t->gl.gl.BindVertexArray(b.array);
    t->gl.gl.DrawArrays(GLBK_GL_TRIANGLES, 0, 18);
    return GLBK_OK;
}

/* A whole frame with every pass. */
static glbk_result frame(gl_test *t, glbk_rsm_map *map, glbk_rsm_renderer *r, const glbk_target *target)
{
    static const float view[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0.1f, 0, 0, 0, 0, 1 }, eye[3] = { 0, 3, 0 };
    rsm_gather_desc d = by_flux(20);
    const rsm_interpolation grid = { 4, 0, 0, 0, 0, 0, 0, NULL };
    gifilt_frame filter;
    glbk_pass pass;
    glbk_result result = GLBK_OK;
    memset(&filter, 0, sizeof filter);
    memset(&pass, 0, sizeof pass);
    filter.world_to_clip = view;
    pass.target = target;
    GL_THEN_SAME(t, result, glbk_rsm_tables_upload(&t->gl, r, NULL, NULL));
    GL_THEN_SAVED(t, result, glbk_rsm_map_draw(&t->gl, r, map, draw, NULL));
    GL_THEN_SAVED(t, result, draw_seen(t, view, eye));
    GL_THEN_SAVED(t, result, glbk_rsm_direct(&t->gl, r, &seen, (const glbk_rsm_map *const *)&map, 1, NULL));
    GL_THEN_SAVED(t, result, glbk_rsm_interpolate(&t->gl, r, &seen, &map, 1, &d, &grid));
    GL_THEN_SAVED(t, result, glbk_rsm_denoise(&t->gl, r, &seen, &filter, NULL));
    GL_THEN_SAVED(t, result, glbk_rsm_resolve(&t->gl, r, &seen, &pass, NULL, 1, 1));
    GL_THEN_SAME(t, result, glbk_rsm_read(&t->gl, r, 1, answers));
    return result;
}

static void an_error_of_gl_comes_out_of_every_call(void **state)
{
    GL_TEST(t, state)
    glbk_rsm_map map;
    glbk_rsm_renderer r;
    glbk_result result;
    gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_RGBA8, SIDE, SIDE, 0);
    int failed = 0;
    small_room(t);
    t->gl.check = 1;
    fake_begin(t, 0x0505);
    for (fake.at = 1;; fake.at++) {
        fake.calls = 0;
        result = make(t, &map, &r);
        if (result == GLBK_OK) break;
        assert_true(result == GLBK_ERR_PENDING || result == GLBK_ERR_GL_MEMORY);
        glbk_rsm_renderer_free(&t->gl, &r);
        glbk_rsm_map_free(&t->gl, &map);
        assert_int_equal(fake.live, 0);
        failed++;
    }
    assert_true(failed > 100);
    fake.at = 0;
    look(t);
    assert_glbk(t, frame(t, &map, &r, &c.target));      /* compiles all programs */
    t->gl.check = 0;
    gl_count_begin(&t->gl);
    assert_glbk(t, frame(t, &map, &r, &c.target));      /* passes do not make a driver or a browser answer */
    gl_count_end(&t->gl);
    t->gl.check = 1;
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
    glbk_rsm_renderer_free(&t->gl, &r);
    glbk_rsm_map_free(&t->gl, &map);
    glbk_gbuffer_free(&t->gl, &seen);
    assert_int_equal(fake.live, 0);
    t->gl.gl = fake.real;
    gl_canvas_free(t, &c);
    body_free(t);
}

static void *no_memory(size_t size, void *user) { return (void)size, (void)user, (void *)NULL; }
static void release(void *memory, void *user) { (void)user, free(memory); }

static void no_memory_and_a_lost_context_come_out(void **state)
{
    GL_TEST(t, state)
    glbk_rsm_map map;
    glbk_rsm_renderer r;
    const rsm_gather_desc tables = with_tables();
    glbk_functions real = t->gl.gl;
    glbk_rsm_map *maps[1] = { &map };
    rsm_gather_desc d = by_flux(20);
    const rsm_interpolation grid = { 4, 0, 0, 0, 0, 0, 0, NULL };
    gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_RGBA8, SIDE, SIDE, 0);
    rsm_texel out[16];
    small_room(t);
    look(t);
    assert_glbk(t, make(t, &map, &r));
    assert_glbk(t, frame(t, &map, &r, &c.target));      /* compiles all programs */
    assert_int_equal(r.compute, t->gl.compute);
    for (int i = 0; i < 2; i++) {       /* a list of all pixels does not fit in a storage buffer */
        const glbk_rsm_renderer_desc way = { SIDE, SIDE, i, 0, 0, { 0, 0, 0, 0, NULL, NULL } };
        const size_t most = t->gl.max_storage;
        glbk_rsm_renderer other;
        t->gl.max_storage = 4 * SIDE * SIDE - 1;
        assert_glbk(t, glbk_rsm_renderer_create(&t->gl, &way, &other));
        t->gl.max_storage = most;
        assert_int_equal(other.compute, t->gl.compute && !i);
        glbk_rsm_renderer_free(&t->gl, &other);
    }
    t->gl.system.allocator.alloc_fn = no_memory;
    t->gl.system.allocator.free_fn = release;
    assert_int_equal(glbk_rsm_map_upload(&t->gl, &map, texels), GLBK_ERR_ALLOC);
    assert_int_equal(glbk_rsm_map_read(&t->gl, &map, 0, out), GLBK_ERR_ALLOC);
    assert_int_equal(glbk_rsm_tables_upload(&t->gl, &r, &tables, points), GLBK_ERR_ALLOC);
    memset(&t->gl.system.allocator, 0, sizeof t->gl.system.allocator);
    assert_glbk(t, glbk_rsm_map_upload(&t->gl, &map, texels));
    t->gl.lost = 1;
    memset(&t->gl.gl, 0, sizeof t->gl.gl);      /* whatever calls GL crashes */
    assert_int_equal(glbk_rsm_map_upload(&t->gl, &map, texels), GLBK_ERR_LOST);
    assert_int_equal(glbk_rsm_map_draw(&t->gl, &r, &map, draw, NULL), GLBK_ERR_LOST);
    assert_int_equal(glbk_rsm_gather(&t->gl, &r, &seen, maps, 1, &d), GLBK_ERR_LOST);
    assert_int_equal(glbk_rsm_interpolate(&t->gl, &r, &seen, maps, 1, &d, &grid), GLBK_ERR_LOST);
    {
        glbk_rsm_map copy = map;
        glbk_rsm_renderer other = r;
        glbk_rsm_map_free(&t->gl, &copy);
        glbk_rsm_renderer_free(&t->gl, &other);
    }
    t->gl.gl = real;
    t->gl.lost = 0;
    glbk_rsm_map_free(&t->gl, &map);
    glbk_rsm_renderer_free(&t->gl, &r);
    gl_canvas_free(t, &c);
    body_free(t);
    glbk_gbuffer_free(&t->gl, &seen);
}

/* ---- state ---- */

static void light_is_the_same_from_a_hostile_state(void **state)
{
    GL_TEST(t, state)
    static float calm[4 * PIXELS];
    glbk_rsm_map map[2];
    glbk_rsm_renderer r[2];
    gl_hostile h;
    gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_RGBA8, SIDE, SIDE, 0);
    double sum = 0;
    int i;
    small_room(t);
    look(t);
    gl_state_watch(t, 1);
    assert_glbk(t, make(t, &map[0], &r[0]));
    assert_glbk(t, frame(t, &map[0], &r[0], &c.target));
    memcpy(calm, answers, sizeof calm);
    for (i = 0; i < PIXELS; i++) sum += (double)calm[4 * i];
    assert_true(sum > 0.1);
    glbk_rsm_reset(&r[0]);                     /* as if it were the first frame again */
    assert_int_equal(r[0].remembers, 0);
    assert_glbk(t, frame(t, &map[0], &r[0], &c.target));
    assert_memory_equal(calm, answers, sizeof calm);
    assert_int_not_equal(r[0].remembers, 0);
    gl_hostile_make(t, &h);
    gl_hostile_set(t, &h);
    assert_glbk(t, make(t, &map[1], &r[1]));
    assert_glbk(t, frame(t, &map[1], &r[1], &c.target));
    assert_memory_equal(calm, answers, sizeof calm);
    for (i = 0; i < 2; i++) {
        GL_SAME(t, glbk_rsm_renderer_free(&t->gl, &r[i]));
        GL_SAME(t, glbk_rsm_map_free(&t->gl, &map[i]));
    }
    gl_hostile_free(t, &h);
    gl_canvas_free(t, &c);
    body_free(t);
    glbk_gbuffer_free(&t->gl, &seen);
}

int main(int count, char **arguments)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(bad_arguments_are_refused),
        gl_unit_test(an_error_of_gl_comes_out_of_every_call),
        gl_unit_test(no_memory_and_a_lost_context_come_out),
        gl_unit_test(light_is_the_same_from_a_hostile_state)
    };
    (void)count;
    GL_TEST_MAIN(arguments, tests, GL_CORE45 | GL_CORE33 | GL_ES30_BARE);
}
