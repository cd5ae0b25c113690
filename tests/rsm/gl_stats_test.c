/* gl_stats_test - glbk_rsm_map_stats against what rsm_finish counts of the same texels, for every kind of light, and
   against the closed form of a lamp in a box; counting asks GL for nothing. */
#define _POSIX_C_SOURCE 200809L
#include "rsm.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend/gl_rsm.h"

#include "gl_test.h"
#include "gl_count.h"
#include "gl_state.h"
#include "util.h"
#include "gl_util.h"

enum { SIDE = 32 };

/* A box from -1 to 1; of the open one the last side, z = 1, is left out. */
static const float quads[] = {
    -1, -1, -1, 2, 0, 0, 0, 0, 2,     -1, -1, -1, 2, 0, 0, 0, 2, 0,     -1, -1, -1, 0, 0, 2, 0, 2, 0,
    1, -1, -1, 0, 0, 2, 0, 2, 0,      -1, 1, -1, 2, 0, 0, 0, 0, 2,      -1, -1, 1, 2, 0, 0, 0, 2, 0
};

static rsm_light lamp_of(rsm_light_kind kind)
{
    rsm_light l;
    memset(&l, 0, sizeof l);
    l.kind = kind;
    set3(l.position, 0.1, 0.2, -0.1);
    set3(l.direction, 0.36, -0.8, -0.48);
    set3(l.value, 3, 2, 1);
    l.cone_half_angle = 0.5f;
    l.radius = 2;
    return l;
}

static glbk_rsm_renderer renderer_of(gl_test *t)
{
    glbk_rsm_renderer r;
    glbk_rsm_renderer_desc d;
    memset(&d, 0, sizeof d);
    d.width = d.height = 4;
    assert_glbk(t, glbk_rsm_renderer_create(&t->gl, &d, &r));
    return r;
}

static void statistics_are_those_of_the_same_texels(void **state)
{
    GL_TEST(t, state)
    model box = model_quads(quads, 5);
    rsm_mesh mesh = mesh_of(&box, 0.5);
    glbk_rsm_renderer r = renderer_of(t);
    int kind;
    mesh.albedo[2] = 0;
    for (kind = RSM_LIGHT_SUN; kind < RSM_LIGHT_COUNT; kind++) {
        rsm_desc d;
        rsm_map *map;
        rsm_stats wanted, got, again;
        glbk_rsm_map m;
        int k;
        memset(&d, 0, sizeof d);
        d.light = lamp_of((rsm_light_kind)kind);
        d.side = SIDE;
        assert_int_equal(rsm_map_create(&d, &map), RSM_OK);
        assert_int_equal(rsm_rasterize(map, &mesh, 1), RSM_OK);
        assert_int_equal(rsm_finish(map, &wanted), RSM_OK);
        assert_glbk(t, glbk_rsm_map_create(&t->gl, &d.light, SIDE, &m));
        assert_int_equal(glbk_rsm_map_stats(&t->gl, &r, &m, 0, &got), GLBK_ERR_ORDER);
        assert_string_equal(t->log, "glbk_rsm_map_stats: count is 0, and nothing was counted yet");
        assert_glbk(t, glbk_rsm_map_upload(&t->gl, &m, rsm_map_texels(map)));
        assert_glbk(t, glbk_rsm_map_stats(&t->gl, &r, &m, 1, &got));
        printf("kind %d: %d of %d texels lit, incident %.6f, by the CPU %.6f\n", kind, (int)got.lit_texels,
               (int)wanted.lit_texels, got.incident[0], wanted.incident[0]);
        assert_true(wanted.lit_texels > SIDE * SIDE / 4);
        assert_true(got.lit_texels == wanted.lit_texels && !got.bad_texels && !got.skipped_triangles);
        for (k = 0; k < 3; k++) {
            assert_true(fabs(got.incident[k] - wanted.incident[k]) <= 1e-5 * wanted.incident[k]);
            assert_true(fabs(got.reflected[k] - wanted.reflected[k]) <= 1e-5 * wanted.reflected[k]);
        }
        assert_true(got.reflected[0] > 0 && !(got.reflected[2] > 0));
        gl_count_begin(&t->gl);
        GL_SAVED(t, assert_glbk(t, glbk_rsm_map_stats(&t->gl, &r, &m, 1, NULL)));    /* nothing waits */
        gl_count_end(&t->gl);
        assert_glbk(t, glbk_rsm_map_stats(&t->gl, &r, &m, 0, &again));
        assert_memory_equal(&again, &got, sizeof got);
        glbk_rsm_map_free(&t->gl, &m);
        rsm_map_free(map);
    }
    assert_int_equal(glbk_rsm_map_stats(NULL, &r, NULL, 1, NULL), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_map_stats(&t->gl, &r, NULL, 1, NULL), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_rsm_map_stats(&t->gl, NULL, NULL, 1, NULL), GLBK_ERR_ARGUMENT);
    glbk_rsm_renderer_free(&t->gl, &r);
    model_free(&box);
}

/* All light of a lamp of value v, 4 pi v, falls on a closed box, and half of it leaves. */
static void a_box_gets_all_the_light_of_its_lamp(void **state)
{
    GL_TEST(t, state)
    model box = model_quads(quads, 6);
    rsm_mesh mesh = mesh_of(&box, 0.5);
    glbk_rsm_renderer r = renderer_of(t);
    rsm_light l = lamp_of(RSM_LIGHT_POINT);
    rsm_stats got;
    glbk_rsm_map m;
    scene s;
    int k;
    scene_make(t, &s, &mesh, 1);
    assert_glbk(t, glbk_rsm_map_create(&t->gl, &l, SIDE, &m));
    assert_glbk(t, glbk_rsm_map_draw(&t->gl, &r, &m, scene_draw, &s));
    assert_glbk(t, glbk_rsm_map_stats(&t->gl, &r, &m, 1, &got));
    assert_true(got.lit_texels == 6 * SIDE * SIDE);
    for (k = 0; k < 3; k++) {
        const double all = 4 * PI * (double)l.value[k];
        assert_true(fabs(got.incident[k] - all) < 1e-5 * all && fabs(got.reflected[k] - all / 2) < 1e-5 * all);
    }
    glbk_rsm_map_free(&t->gl, &m);
    glbk_rsm_renderer_free(&t->gl, &r);
    scene_free(t, &s);
    model_free(&box);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = { gl_unit_test(statistics_are_those_of_the_same_texels),
                                  gl_unit_test(a_box_gets_all_the_light_of_its_lamp) };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE45 | GL_CORE33 | GL_ES30_BARE);
}
