/* gl_fault_test - ism on a GL that fails and in a GL whose state is hostile: every error that GL may report comes out
   as a result and leaves no object behind; uploads and reads leave state as it was; pictures do not depend on it. */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend/gl_ism.h"

#include "gl_test.h"
#include "gl_fake.h"
#include "gl_state.h"
#include "gl_util.h"

enum { SIDE = 8, POINTS = 64 };

/* A lamp at the ceiling, a table below it, and a floor. */
typedef struct scene {
    glbk_ism_maps      maps;
    glbk_ism_choice    choice;
    glbk_ism_spread    spread;
    glbk_ism_bounces   bounced;                 /* on OpenGL 3.3, where VPLs have no windows therefore */
    glbk_texture       lit;                     /* a source of 2 x 2 texels */
    glbk_gbuffer       seen;
    glbk_ism_renderer  renderer;
    ism_surfel         surfels[POINTS];
    glbk_pixel         pixels[SIDE * SIDE];
    float              light[4 * SIDE * SIDE];
    float              atlas[64 * 64];
} scene;

static const float table[12] = { -0.5f, 1, -0.5f, 0.5f, 1, -0.5f, -0.5f, 1, 0.5f, 0.5f, 1, 0.5f };
static const uint32_t triangles[6] = { 0, 1, 2, 1, 3, 2 };
static const ism_vpl lamp = { { 0, 2, 0 }, { 0, -1, 0 }, { 1, 2, 3 }, { 0, -1, 0 }, 1, 0, 0.1f, 0, 0, 0, 0, 1, 0 };
static const ism_near_point near_point = { { 0.1f, 2, 0 }, 0.1f, { 0, -1, 0 }, 1, { 1, 2, 3 }, 0 };
/* Place, normal and flux of 2 x 2 texels of the ceiling, three of which have none. */
static const float lit[3][16] = { { 0, 2, 0 }, { 0, -1, 0, 0, 0, -1, 0, 0, 0, -1, 0, 0, 0, -1, 0, 0 },
                                  { 1, 2, 3, 0.01f } };
static const ism_info info = { .center = { 0, 1, 0 }, .radius = 2 };

static void prepare(scene *s)
{
    int i;
    memset(s, 0, sizeof *s);
    for (i = 0; i < POINTS; i++) {
        ism_surfel *p = &s->surfels[i];
        p->triangle = (uint32_t)i % 2;
        p->barycentric[0] = 0.1f + 0.8f * (float)(i % 8) / 8;
        p->barycentric[1] = (1 - p->barycentric[0]) * (0.1f + 0.8f * (float)(i / 8) / 8);
        p->area = 2.0f / POINTS;
    }
    for (i = 0; i < SIDE * SIDE; i++) {
        s->pixels[i].position[0] = 0.5f * (float)(i % SIDE) - 1.75f;
        s->pixels[i].position[2] = 0.5f * (float)(i / SIDE) - 1.75f;
        s->pixels[i].normal[1] = 1;
    }
}

static int keeps_hits(void) { return gl_this_way() && gl_this_way()->bit == GL_CORE33; }

static glbk_result make(gl_test *t, scene *s)
{
    ism_mesh mesh = { table, 4, 0, triangles, 6, NULL, NULL, NULL, NULL, NULL };
    const glbk_gbuffer_desc size = { SIDE, SIDE, { 0, 0, 0, 0, NULL, NULL }, NULL };
    const glbk_ism_choice_desc two = { 2, 2, 1, 0 };
    ism_desc d;
    glbk_texture_desc source;
    glbk_result result = GLBK_OK;
    memset(&d, 0, sizeof d);
    d.vpl_count = d.lazy_frames = 1;
    d.surfel_count = POINTS;
    d.near_point_count = 1;
    d.keep_hits = keeps_hits();
    memset(&source, 0, sizeof source);
    source.format = GLBK_FORMAT_RGBA32UI;
    source.width = source.height = 2;
    source.layers = 3;
    source.data = lit;
    GL_THEN_SAME(t, result, glbk_ism_maps_create(&t->gl, &d, &s->maps));
    GL_THEN_SAME(t, result, glbk_texture_create(&t->gl, &source, &s->lit));
    GL_THEN_SAME(t, result, glbk_ism_choice_create(&t->gl, &s->maps, &two, &s->choice));
    GL_THEN_SAME(t, result, glbk_ism_spread_create(&t->gl, &s->maps, &s->spread));
    if (d.keep_hits) GL_THEN_SAME(t, result, glbk_ism_bounces_create(&t->gl, &s->maps, 2, &s->bounced));
    GL_THEN_SAME(t, result, glbk_ism_renderer_create(&t->gl, &(glbk_ism_renderer_desc){ SIDE, SIDE }, &s->renderer));
    GL_THEN_SAME(t, result, glbk_ism_mesh_upload(&t->gl, &s->maps, &mesh));
    GL_THEN_SAME(t, result, glbk_ism_mesh_move(&t->gl, &s->maps, table, 0));
    GL_THEN_SAME(t, result, glbk_ism_surfels_upload(&t->gl, &s->maps, 0, s->surfels, POINTS));
    GL_THEN_SAME(t, result, glbk_ism_vpls_upload(&t->gl, &s->maps, &lamp, 1, &info));
    GL_THEN_SAME(t, result, glbk_ism_near_points_upload(&t->gl, &s->maps, &near_point, 1));
    GL_THEN_SAME(t, result, glbk_gbuffer_create(&t->gl, &size, &s->seen));
    GL_THEN_SAME(t, result, glbk_gbuffer_upload(&t->gl, &s->seen, 0, SIDE, s->pixels));
    return result;
}

static glbk_result draw(gl_test *t, scene *s)
{
    glbk_result result = GLBK_OK;
    GL_THEN_SAVED(t, result, glbk_ism_draw(&t->gl, &s->maps, 0));
    GL_THEN_SAVED(t, result, glbk_ism_shade(&t->gl, &s->renderer, &s->seen, &s->maps, NULL, 0));
    return result;
}

/* The light of the VPL that is chosen from the texels, which is the lamp's but for the near points, with surfels that
   are scattered here. */
static glbk_result draw_chosen(gl_test *t, scene *s)
{
    glbk_result result = GLBK_OK;
    GL_THEN_SAVED(t, result, glbk_ism_choose(&t->gl, &s->choice, &s->maps, &s->lit, &s->seen, 0));
    GL_THEN_SAVED(t, result, glbk_ism_scatter(&t->gl, &s->spread, &s->maps, &s->seen, 0));
    if (result == GLBK_OK) result = draw(t, s);
    if (keeps_hits()) GL_THEN_SAVED(t, result, glbk_ism_bounce(&t->gl, &s->bounced, &s->maps));
    return result;
}

static glbk_result look(gl_test *t, scene *s)
{
    glbk_result result = GLBK_OK;
    GL_THEN_SAME(t, result, gl_read_atlas(&t->gl, &s->maps, s->atlas));
    GL_THEN_SAME(t, result, glbk_ism_read(&t->gl, &s->renderer, s->light));
    return result;
}

static void destroy(gl_test *t, scene *s)
{
    GL_SAME(t, glbk_ism_renderer_free(&t->gl, &s->renderer));
    GL_SAME(t, glbk_gbuffer_free(&t->gl, &s->seen));
    GL_SAME(t, glbk_ism_choice_free(&t->gl, &s->choice));
    GL_SAME(t, glbk_ism_spread_free(&t->gl, &s->spread));
    GL_SAME(t, glbk_ism_bounces_free(&t->gl, &s->bounced));
    GL_SAME(t, glbk_texture_free(&t->gl, &s->lit));
    GL_SAME(t, glbk_ism_maps_free(&t->gl, &s->maps));
}

/* ---- errors put into GL's mouth ---- */

static void every_error_comes_out(void **state)
{
    GL_TEST(t, state)
    static scene s;
    glbk_result result = GLBK_ERR_GL;
    int failures = 0;
    t->gl.check = 1;
    fake_begin_blind(t, 0x0505);
    for (fake.at = 1; result != GLBK_OK; fake.at++) {
        prepare(&s);
        fake.calls = 0;
        result = make(t, &s);
        if (result == GLBK_OK) result = draw_chosen(t, &s);
        if (result == GLBK_OK) result = look(t, &s);
        destroy(t, &s);
        assert_int_equal(fake.live, 0);
        if (result == GLBK_OK) break;
        assert_true(result == GLBK_ERR_GL_MEMORY || result == GLBK_ERR_PENDING);
        failures++;
        assert_true(fake.at < 700);
    }
    t->gl.gl = fake.real;
    assert_true(failures > 60);
}

/* The mesh by 16-bit indices: the same maps and the same light; and an index beyond its vertices is an error. */
static void indices_of_16_bits_are_taken(void **state)
{
    GL_TEST(t, state)
    static const uint16_t short_triangles[6] = { 0, 1, 2, 1, 3, 2 }, wrong[6] = { 0, 1, 2, 1, 4, 2 };
    static scene s[2];
    ism_mesh mesh = { table, 4, 0, NULL, 6, short_triangles, NULL, NULL, NULL, NULL };
    double sum = 0;
    int i;
    for (i = 0; i < 2; i++) {
        prepare(&s[i]);
        assert_glbk(t, make(t, &s[i]));
        if (i) assert_glbk(t, glbk_ism_mesh_upload(&t->gl, &s[i].maps, NULL));
        if (i) assert_glbk(t, glbk_ism_mesh_upload(&t->gl, &s[i].maps, &mesh));
        if (i) assert_glbk(t, glbk_ism_surfels_upload(&t->gl, &s[i].maps, 0, s[i].surfels, POINTS));
        assert_glbk(t, draw(t, &s[i]));
        assert_glbk(t, look(t, &s[i]));
    }
    assert_memory_equal(s[0].atlas, s[1].atlas, sizeof s[0].atlas);
    assert_memory_equal(s[0].light, s[1].light, sizeof s[0].light);
    for (i = 0; i < 4 * SIDE * SIDE; i++) sum += (double)s[1].light[i];
    assert_true(sum > 0);
    mesh.indices16 = wrong;
    assert_int_equal(glbk_ism_mesh_upload(&t->gl, &s[1].maps, &mesh), GLBK_ERR_INPUT);
    assert_non_null(strstr(t->log, "index 1 of triangle 1"));
    for (i = 0; i < 2; i++) destroy(t, &s[i]);
}

static void draw_atlas(gl_test *t, scene *s)
{
    assert_glbk(t, glbk_ism_draw(&t->gl, &s->maps, 0));
    assert_glbk(t, gl_read_atlas(&t->gl, &s->maps, s->atlas));
}

/* After an upload that fails the mesh is the old one, or the new one, but no mixture: neither of errors of GL nor of
   memory that is missing. */
static void a_failed_upload_leaves_a_whole_mesh(void **state)
{
    GL_TEST(t, state)
    static const float high[12] = { -0.4f, 1.5f, -0.4f, 0.4f, 1.5f, -0.4f, -0.4f, 1.5f, 0.4f, 0.4f, 1.5f, 0.4f };
    static const uint32_t other[6] = { 0, 3, 1, 0, 2, 3 };
    static float atlas[2][64 * 64];
    static scene s;
    const ism_mesh old = { table, 4, 0, triangles, 6, NULL, NULL, NULL, NULL, NULL };
    ism_mesh mesh = { high, 4, 0, other, 6, NULL, NULL, NULL, NULL, NULL };
    glbk_result result;
    int failures[2] = { 0, 0 }, way, n;
    t->gl.check = 1;
    t->gl.system.allocator.alloc_fn = fake_alloc;
    t->gl.system.allocator.free_fn = fake_free;
    fake_memory.left = 1000000;
    prepare(&s);
    assert_glbk(t, make(t, &s));
    for (n = 0; n < 2; n++) {
        assert_glbk(t, glbk_ism_mesh_upload(&t->gl, &s.maps, n ? &mesh : &old));
        draw_atlas(t, &s);
        memcpy(atlas[n], s.atlas, sizeof s.atlas);
    }
    assert_memory_not_equal(atlas[0], atlas[1], sizeof atlas[0]);
    for (way = 0; way < 2; way++)
        for (n = 0, result = GLBK_ERR_ALLOC; result != GLBK_OK; n++) {
            assert_glbk(t, glbk_ism_mesh_upload(&t->gl, &s.maps, &old));
            fake_begin(t, 0x0505);
            fake.at = way ? 0 : n + 1;
            if (way) fake_memory.left = n;
            result = glbk_ism_mesh_upload(&t->gl, &s.maps, &mesh);
            t->gl.gl = fake.real;
            assert_int_equal(fake.live, 0);             /* as many tables as before */
            fake_memory.left = 1000000;
            draw_atlas(t, &s);
            failures[way] += result != GLBK_OK;
            if (result != GLBK_OK && !memcmp(s.atlas, atlas[0], sizeof s.atlas)) continue;
            assert_memory_equal(s.atlas, atlas[1], sizeof s.atlas);
        }
    printf("%d and %d failures\n", failures[0], failures[1]);
    assert_true(failures[0] > 2 && failures[1] > 1);
    destroy(t, &s);
    assert_int_equal(fake_memory.live, 0);
}

/* Passes do not make a driver or a browser answer. */
static void a_frame_asks_gl_nothing(void **state)
{
    GL_TEST(t, state)
    static scene s;
    prepare(&s);
    assert_glbk(t, make(t, &s));
    assert_glbk(t, draw_chosen(t, &s));     /* compiles */
    gl_count_begin(&t->gl);
    assert_glbk(t, draw_chosen(t, &s));
    gl_count_end(&t->gl);
    destroy(t, &s);
}

static void failed_allocations_leave_nothing(void **state)
{
    GL_TEST(t, state)
    static scene s;
    glbk_result result = GLBK_ERR_ALLOC;
    int given;
    t->gl.system.allocator.alloc_fn = fake_alloc;
    t->gl.system.allocator.free_fn = fake_free;
    fake_begin_blind(t, 0);
    for (given = 0; result != GLBK_OK; given++) {
        prepare(&s);
        fake_memory.left = given;
        result = make(t, &s);
        if (result == GLBK_OK) result = draw_chosen(t, &s);
        if (result == GLBK_OK) result = look(t, &s);
        destroy(t, &s);
        assert_int_equal(fake.live, 0);
        assert_int_equal(fake_memory.live, 0);
        assert_true(result == GLBK_OK || result == GLBK_ERR_ALLOC);
    }
    t->gl.gl = fake.real;
    assert_true(given > 10);
}

static void a_lost_context_comes_out(void **state)
{
    GL_TEST(t, state)
    static scene s;
    static glbk_functions none;
    glbk_context ctx;
    prepare(&s);
    assert_glbk(t, make(t, &s));
    ctx = t->gl;
    t->gl.gl = none;                    /* from here on a call of GL would crash */
    glbk_abandon(&t->gl);
    assert_int_equal(draw(t, &s), GLBK_ERR_LOST);
    assert_int_equal(draw_chosen(t, &s), GLBK_ERR_LOST);
    assert_int_equal(look(t, &s), GLBK_ERR_LOST);
    assert_int_equal(glbk_ism_bind(&t->gl, &s.maps, NULL, NULL), GLBK_ERR_LOST);
    {
        scene copy = s;
        assert_int_equal(make(t, &copy), GLBK_ERR_LOST);
    }
    {
        scene copy = s;
        destroy(t, &copy);
    }
    t->gl = ctx;
    destroy(t, &s);
}

/* ---- state ---- */

static void light_is_the_same_from_a_hostile_state(void **state)
{
    GL_TEST(t, state)
    static scene clean, odd;
    gl_hostile h;
    size_t i, dark = 0, chosen;
    gl_state_watch(t, 1);
    gl_hostile_make(t, &h);
    for (chosen = 0; chosen < 2; chosen++) {
        glbk_result (*const draw_either)(gl_test *, scene *) = chosen ? draw_chosen : draw;
        prepare(&clean);
        prepare(&odd);
        assert_glbk(t, make(t, &clean));
        assert_glbk(t, draw_either(t, &clean));
        assert_glbk(t, look(t, &clean));
        for (dark = i = 0; i < SIDE * SIDE; i++) dark += clean.light[4 * i] == 0;
        assert_true(dark > 8 && dark < SIDE * SIDE / 2);    /* the table's shadow */
        gl_hostile_set(t, &h);
        assert_glbk(t, make(t, &odd));
        assert_glbk(t, draw_either(t, &odd));
        assert_glbk(t, look(t, &odd));
        GL_SAVED(t, assert_glbk(t, glbk_ism_bind(&t->gl, &odd.maps, NULL, NULL)));
        assert_memory_equal(clean.atlas, odd.atlas, sizeof odd.atlas);
        assert_memory_equal(clean.light, odd.light, sizeof odd.light);
        destroy(t, &clean);
        destroy(t, &odd);
    }
    gl_hostile_free(t, &h);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(light_is_the_same_from_a_hostile_state),
        gl_unit_test(a_lost_context_comes_out),
        gl_unit_test(failed_allocations_leave_nothing),
        gl_unit_test(a_frame_asks_gl_nothing),
        gl_unit_test(every_error_comes_out),
        gl_unit_test(a_failed_upload_leaves_a_whole_mesh),
        gl_unit_test(indices_of_16_bits_are_taken)
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE45 | GL_CORE33 | GL_ES30_BARE);
}
