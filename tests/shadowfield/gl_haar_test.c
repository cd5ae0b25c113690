/* gl_haar_test - wavelets on OpenGL: a ball over a point and before a disc of light in closed form, then scenes of
   moved, turned and scaled bodies, lights, a video light, self-visibility and a turned sky against shadowfield.h, point
   by point; lists that take more than a round; arguments, failures of GL and of memory, and a hostile state. */
#define _POSIX_C_SOURCE 200809L
#include "shadowfield.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend/gl_wavelets.h"

#define CONFORM_BACKEND "gl"
#include "conformance.h"
#include "gl_test.h"
#include "gl_state.h"
#include "gl_wrong.h"
#include "util.h"

enum { SIDE = 16, ENTITIES = 24, POINTS = 96, WIDTH = 12 };

typedef enum which { BALL, BOX, SOUP, LAMP, VIDEO, OWN, FIELDS } which;

static sfield_field *field[FIELDS];
static float at_box[3 * POINTS], out_of_box[3 * POINTS];       /* points of the box, and their normals */

static sfield_desc haar_desc(uint32_t shells, uint32_t positions)
{
    sfield_desc d;
    memset(&d, 0, sizeof d);
    d.basis = SFIELD_BASIS_HAAR;
    d.cube_side = SIDE;
    d.shell_count = shells;
    d.position_side = positions;
    d.keep = 0.1f;
    d.outer = 12;
    return d;
}

/* Points on all sides of the box, a little away from its edges. */
static void spread_points(void)
{
    static const float half[3] = { 1, 0.5f, 0.7f };
    uint64_t seed = 4;
    int i, k;
    for (i = 0; i < POINTS; i++) {
        const int axis = i % 3;
        for (k = 0; k < 3; k++) {
            at_box[3 * i + k] = half[k] * rnd_in(&seed, -0.8, 0.8);
            out_of_box[3 * i + k] = 0;
        }
        at_box[3 * i + axis] = i % 2 ? half[axis] : -half[axis];
        out_of_box[3 * i + axis] = i % 2 ? 1.0f : -1.0f;
    }
}

static int make_fields(void **state)
{
    static float radiance[3 * 3 * 200];
    model ball = model_sphere(32, 16, 1), box = model_box(1, 0.5, 0.7), soup = model_soup(20, 0.6, 77);
    model small = model_sphere(10, 5, 0.5);
    sfield_mesh of_ball = mesh_of(&ball), of_box = mesh_of(&box), of_soup = mesh_of(&soup), of_small = mesh_of(&small);
    sfield_desc d = haar_desc(12, 7), coarse = haar_desc(5, 4);
    sfield_emitter e;
    int i, good;
    (void)state;
    memset(&e, 0, sizeof e);
    e.radius = 1;
    e.radiance[0] = 1;
    e.radiance[1] = 0.5f;
    e.radiance[2] = 0.25f;
    for (i = 0; i < 3 * 3 * 200; i++) radiance[i] = (float)(1 + i % 7 + i / 300);
    spread_points();
    good = sfield_build(&d, &of_ball, &field[BALL], NULL) == SFIELD_OK &&
           sfield_build(&coarse, &of_box, &field[BOX], NULL) == SFIELD_OK &&
           sfield_build(&coarse, &of_soup, &field[SOUP], NULL) == SFIELD_OK &&
           sfield_build_self(&coarse, &of_box, AT(at_box, out_of_box, POINTS), 0.01f, &field[OWN], NULL) == SFIELD_OK;
    coarse.frame_count = 3;
    coarse.frames_per_second = 10;
    coarse.loop = 1;
    good = good && sfield_build_emissive(&coarse, &of_small, radiance, &field[VIDEO], NULL) == SFIELD_OK;
    d.radius = 1;
    good = good && sfield_build_emitter(&d, &e, &field[LAMP], NULL) == SFIELD_OK;
    model_free(&ball);
    model_free(&box);
    model_free(&soup);
    model_free(&small);
    return good ? 0 : -1;
}

static int free_fields(void **state)
{
    int i;
    (void)state;
    for (i = 0; i < FIELDS; i++) sfield_free(field[i]);
    return 0;
}

/* ---- a world on both sides ---- */

typedef struct world {
    glbk_sfield_scene gl;
    glbk_gbuffer      gbuffer;
    glbk_sfield_haar  haar;
    sfield_scene     *scene;
    float             position[3 * POINTS], normal[3 * POINTS];
    float             light[4 * POINTS], rgb[3 * POINTS], open[POINTS];
} world;

static glbk_sfield_haar_scene_desc scene_desc(void)
{
    glbk_sfield_haar_scene_desc d;
    memset(&d, 0, sizeof d);
    d.fields = (const sfield_field *const *)field;
    d.field_count = FIELDS;
    d.cube_side = SIDE;
    d.entity_capacity = ENTITIES;
    return d;
}

static void open_glossy_world(gl_test *t, world *w, uint32_t batch, int gloss)
{
    const glbk_sfield_haar_scene_desc d = scene_desc();
    const glbk_sfield_haar_desc h = { WIDTH, POINTS / WIDTH, SIDE, batch, 1, gloss };
    glbk_gbuffer_desc g;
    sfield_scene_desc s;
    memset(w, 0, sizeof *w);
    memset(&g, 0, sizeof g);
    memset(&s, 0, sizeof s);
    g.width = h.width;
    g.height = h.height;
    s.basis = SFIELD_BASIS_HAAR;
    s.cube_side = SIDE;
    assert_glbk(t, glbk_sfield_haar_upload(&t->gl, &d, &w->gl));
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &g, &w->gbuffer));
    assert_glbk(t, glbk_sfield_haar_create(&t->gl, &h, &w->haar));
    assert_int_equal(sfield_scene_create(&s, &w->scene), SFIELD_OK);
}

static void open_world(gl_test *t, world *w, uint32_t batch) { open_glossy_world(t, w, batch, 0); }

static void close_world(gl_test *t, world *w)
{
    glbk_sfield_haar_free(&t->gl, &w->haar);
    glbk_gbuffer_free(&t->gl, &w->gbuffer);
    glbk_sfield_scene_free(&t->gl, &w->gl);
    sfield_scene_free(w->scene);
}

static sfield_entity at(which what, float x, float y, float z)
{
    sfield_entity e;
    int k;
    memset(&e, 0, sizeof e);
    if (what == LAMP || what == VIDEO) e.source = field[what];
    else e.occlusion = field[what];
    for (k = 0; k < 16; k += 5) e.transform[k] = 1;
    for (k = 0; k < 3; k++) e.tint[k] = 1;
    e.transform[12] = x;
    e.transform[13] = y;
    e.transform[14] = z;
    return e;
}

/* sky: a map of 8 x 4, or NULL. */
static void place(gl_test *t, world *w, const sfield_entity *e, size_t count, const float *sky, const float *turned)
{
    static float texels[3 * 6 * SIDE * SIDE];
    static const float down[3] = { 0.6f, 0.8f, 0 }, sun[3] = { 2, 1, 0.5f };
    assert_int_equal(sfield_scene_entities(w->scene, e, count), SFIELD_OK);
    assert_int_equal(sfield_scene_environment(w->scene, sky, 8, 4, turned), SFIELD_OK);
    if (turned) assert_int_equal(sfield_scene_sun(w->scene, down, sun), SFIELD_OK);
    assert_int_equal(sfield_scene_sky(w->scene, texels), SFIELD_OK);
    assert_glbk(t, glbk_sfield_scene_entities(&t->gl, &w->gl, e, count));
    assert_glbk(t, glbk_sfield_haar_sky(&t->gl, &w->gl, sky ? texels : NULL));
}

/* Shades the first `count` points, in the space of an entity; own: with the box's self-visibility. */
static void shade_gl(gl_test *t, world *w, uint32_t count, uint32_t entity, const sfield_entity *e, int own)
{
    static glbk_pixel pixels[POINTS];
    static glbk_sfield_own owns[POINTS];
    static const float even[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    const float *m = entity ? e[entity - 1].transform : even;
    const float scale = sqrtf(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
    uint32_t i, k;
    memset(pixels, 0, sizeof pixels);
    memset(owns, 0, sizeof owns);
    for (i = 0; i < count; i++) {
        const float *p = w->position + 3 * i, *n = w->normal + 3 * i;
        for (k = 0; k < 3; k++) {
            pixels[i].position[k] = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
            pixels[i].normal[k] = (m[k] * n[0] + m[4 + k] * n[1] + m[8 + k] * n[2]) / scale;
        }
        pixels[i].entity = entity;
        owns[i].self = own ? field[OWN] : NULL;
        owns[i].point = i;
    }
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, &w->gbuffer, 0, POINTS / WIDTH, pixels));
    assert_glbk(t, glbk_sfield_haar_self(&t->gl, &w->haar, &w->gl, 0, POINTS / WIDTH, owns));
    assert_glbk(t, glbk_sfield_haar_shade(&t->gl, &w->haar, &w->gbuffer, &w->gl, NULL, 1));
    assert_glbk(t, glbk_target_read(&t->gl, &w->haar.target, 0, 0, 0, WIDTH, POINTS / WIDTH, w->light));
}

static void shade_cpu(world *w, uint32_t entity, int own)
{
    sfield_points set;
    memset(&set, 0, sizeof set);
    set.count = POINTS;
    set.positions = w->position;
    set.normals = w->normal;
    set.entity = entity;
    set.self = own ? field[OWN] : NULL;
    set.rgb = w->rgb;
    set.ambient = w->open;
    assert_int_equal(sfield_shade(w->scene, &set, 1, NULL), SFIELD_OK);
}

/* ---- closed forms ---- */

/* One point at the origin that looks up. */
static float light_at_origin(gl_test *t, world *w, const sfield_entity *e, size_t count, const float *sky)
{
    memset(w->position, 0, 12);
    memset(w->normal, 0, 12);
    w->normal[1] = 1;
    place(t, w, e, count, sky, NULL);
    shade_gl(t, w, 1, 0, e, 0);
    return w->light[0];
}

static void a_ball_hides_the_square_of_its_sine(void **state)
{
    GL_TEST(t, state)
    float white[3 * 32];
    sfield_entity e = at(BALL, 0, 2, 0);
    world w;
    int i;
    for (i = 0; i < 96; i++) white[i] = 1;
    open_world(t, &w, 0);
    assert_true(fabsf(light_at_origin(t, &w, &e, 0, white) - 1) < 2e-3f);
    assert_true(w.light[4] == 0);                                  /* there is one point only */
    /* a cube of 16 texels a side and a tenth of its wavelets: 1 % of the sky */
    CONFORM("wavelets", "share of the sky beside a ball 2 r above", 0.75, light_at_origin(t, &w, &e, 1, white), 0.01);
    assert_true(fabsf(w.light[3] - w.light[0]) < 1e-5f);           /* the open share is that of a sky of 1 */
    matrix_of(e.transform, 1, 2, 3, 0.8, 1, 0, 2, 0);
    CONFORM("wavelets", "the same, the ball turned", 0.75, light_at_origin(t, &w, &e, 1, white), 0.01);
    matrix_of(e.transform, 1, 0, 0, 0, 2, 0, 5, 0);
    CONFORM("wavelets", "beside a ball of twice the size 5 above", 1 - 0.16, light_at_origin(t, &w, &e, 1, white),
            0.01);
    close_world(t, &w);
}

/* A lamp of sine 0.5 overhead, with a ball of sine 0.3 before it: what is left is a ring. */
static void a_ball_before_a_lamp_leaves_a_ring(void **state)
{
    GL_TEST(t, state)
    sfield_entity e[3];
    float lit, ring, all;
    int turned;
    world w;
    open_world(t, &w, 0);
    for (turned = 0; turned < 2; turned++) {
        e[0] = at(LAMP, 0, 4, 0);
        e[1] = at(BALL, 0, 1, 0);
        e[2] = at(BALL, 0, 9, 0);
        matrix_of(e[0].transform, 3, 1, 2, turned ? 1.1 : 0, 2, 0, 4, 0);
        matrix_of(e[1].transform, 1, 1, 2, turned ? 0.7 : 0, 0.3, 0, 1, 0);
        lit = light_at_origin(t, &w, e, 1, NULL);
        CONFORM("wavelets", turned ? "the same, all turned" : "light of a lamp of sine 0.5 overhead", 0.25, lit, 0.005);
        assert_true(fabsf(w.light[1] - 0.5f * lit) < 1e-4f && fabsf(w.light[2] - 0.25f * lit) < 1e-4f);
        ring = light_at_origin(t, &w, e, 2, NULL);
        CONFORM("wavelets", turned ? "the same ring, all turned" : "behind a ball of sine 0.3, which leaves a ring",
                0.16, ring, 0.01);
        all = light_at_origin(t, &w, e, 3, NULL);
        assert_true(fabsf(all - ring) < 1e-6f && w.light[3] > 0.5f);     /* what lies behind hides nothing */
        assert_glbk(t, glbk_sfield_haar_shade(&t->gl, &w.haar, &w.gbuffer, &w.gl, NULL, 0));
        assert_glbk(t, glbk_target_read(&t->gl, &w.haar.target, 0, 0, 0, WIDTH, POINTS / WIDTH, w.light));
        assert_true(w.light[0] == all && w.light[3] == 0);               /* the open share is not wanted */
    }
    close_world(t, &w);
}

/* ---- beside the CPU ---- */

static void random_points(world *w, uint64_t *seed)
{
    int i, k;
    for (i = 0; i < POINTS; i++) {
        double n[3];
        rnd_direction(seed, n);
        for (k = 0; k < 3; k++) {
            w->position[3 * i + k] = rnd_in(seed, -3, 3);
            w->normal[3 * i + k] = (float)n[k];
        }
    }
    memset(w->normal + 3 * 5, 0, 12);           /* no receiver */
}

/* Bodies all round: boxes, soups and balls, every second one turned, of many sizes, some lit by two lights. */
static void random_bodies(sfield_entity *e, uint32_t count, uint64_t *seed)
{
    uint32_t i;
    int k;
    for (i = 0; i < count; i++) {
        static const which kinds[6] = { BALL, BOX, LAMP, SOUP, BOX, VIDEO };
        const which what = kinds[i % 6];
        double axis[3], r[5];
        e[i] = at(what, 0, 0, 0);
        rnd_direction(seed, axis);
        for (k = 0; k < 5; k++) r[k] = rnd(seed);
        matrix_of(e[i].transform, axis[0], axis[1], axis[2], i % 2 ? 3 * r[0] : 0, 0.5 + 0.7 * r[1], 4 * r[2] - 2,
                  4 * r[3] - 2, 4 * r[4] - 2);
        for (k = 0; k < 3; k++) e[i].tint[k] = rnd_in(seed, 0, 2);
        e[i].time = rnd_in(seed, -1, 1);
    }
    if (count > 3) e[3].source = field[LAMP];   /* hides and shines */
}

/* What GL may be off by, beside the light without any occluder: docs/shadowfield.md derives it, for 7 positions a side.
   What is off adds up by chance: a tenth of the bound is far more than was ever seen. */
static double bound_of(uint32_t met) { return met * (1.6e-5 + (7 - 1) * 6e-6); }

static void compare(const char *what, const world *w, uint32_t met)
{
    double worst = 0, most = 0, open = 0, dark = 0;
    int i, k;
    for (i = 0; i < POINTS; i++) {
        for (k = 0; k < 3; k++) {
            worst = fmax(worst, fabs((double)w->light[4 * i + k] - (double)w->rgb[3 * i + k]));
            most = fmax(most, fabs((double)w->rgb[3 * i + k]));
        }
        open = fmax(open, fabs((double)w->light[4 * i + 3] - (double)w->open[i]));
        dark += w->open[i] < 0.8f;
    }
    print_message("%s: off by %.1e of at most %.2g, open by %.1e, bound %.1e; %.0f of %d points in some shadow\n", what,
                  worst, most, open, bound_of(met), dark, POINTS);
    assert_true(most > 0.05 && dark > POINTS / 16);      /* or this compares nothing */
    CONFORM_MAX("wavelets", what, 0.1 * bound_of(met), fmax(worst / most, open));
}

static void scenes_are_shaded_as_on_the_cpu(void **state)
{
    GL_TEST(t, state)
    static float sky[3 * 32];
    static world w;
    sfield_entity e[ENTITIES];
    float turned[16];
    uint64_t seed = 19;
    int i;
    for (i = 0; i < 96; i++) sky[i] = rnd_in(&seed, 0, 2);
    open_world(t, &w, 0);
    random_points(&w, &seed);
    random_bodies(e, 5, &seed);
    place(t, &w, e, 5, sky, NULL);
    shade_gl(t, &w, POINTS, 0, e, 0);
    shade_cpu(&w, 0, 0);
    compare("off shadowfield.h, 5 bodies and a sky", &w, 5);
    assert_true(w.light[4 * 5] == 0 && w.light[4 * 5 + 3] == 0);
    place(t, &w, e, 5, NULL, NULL);
    shade_gl(t, &w, POINTS, 0, e, 0);
    shade_cpu(&w, 0, 0);
    compare("off shadowfield.h, lights alone", &w, 5);
    matrix_of(turned, 1, 2, 2, 0.9, 1, 0, 0, 0);
    random_bodies(e, 9, &seed);
    e[0] = at(BOX, 0, 0, 0);
    matrix_of(e[0].transform, 1, 0, 2, 0.4, 1.5, 0.3, 0, 0.1);
    for (i = 1; i < 9; i++)                     /* lights in a room are shadowfield.h's alone */
        if (e[i].source) e[i].transform[13] += 4;
    place(t, &w, e, 9, sky, turned);
    memcpy(w.position, at_box, sizeof at_box);
    memcpy(w.normal, out_of_box, sizeof out_of_box);
    shade_gl(t, &w, POINTS, 1, e, 1);
    shade_cpu(&w, 1, 1);
    compare("off shadowfield.h, points of a turned box", &w, 10);
    close_world(t, &w);
}

/* 24 entities are more than the 16 places of a list, and a batch of 7 points leaves odd rectangles. */
static void long_lists_take_more_rounds(void **state)
{
    GL_TEST(t, state)
    static float sky[3 * 32], whole[4 * POINTS];
    static world w;
    sfield_entity e[ENTITIES];
    uint64_t seed = 23;
    int i;
    for (i = 0; i < 96; i++) sky[i] = rnd_in(&seed, 0, 2);
    open_world(t, &w, 0);
    assert_true(w.haar.batch == POINTS);
    random_points(&w, &seed);
    random_bodies(e, ENTITIES, &seed);
    place(t, &w, e, ENTITIES, sky, NULL);
    shade_gl(t, &w, POINTS, 0, e, 0);
    shade_cpu(&w, 0, 0);
    compare("off shadowfield.h, 24 bodies in rounds", &w, ENTITIES);
    memcpy(whole, w.light, sizeof whole);
    close_world(t, &w);
    open_world(t, &w, 7);
    seed = 23;
    for (i = 0; i < 96; i++) sky[i] = rnd_in(&seed, 0, 2);
    random_points(&w, &seed);
    place(t, &w, e, ENTITIES, sky, NULL);
    shade_gl(t, &w, POINTS, 0, e, 0);
    assert_memory_equal(whole, w.light, sizeof whole);              /* batches change no bit */
    close_world(t, &w);
}

static void bodies_of_every_side_of_texels(void **state)
{
    GL_TEST(t, state)
    static const uint32_t sides[4] = { 4, 8, 32, 64 };
    model box = model_box(1, 0.5, 0.7);
    sfield_mesh mesh = mesh_of(&box);
    int i;
    for (i = 0; i < 4; i++) {
        sfield_desc d = haar_desc(3, 3);
        glbk_sfield_haar_scene_desc sd = scene_desc();
        const glbk_sfield_haar_desc h = { 4, 1, sides[i], 0, 0, 0 };
        static const float p[12] = { 0, 0, 0, 0.5f, 0.1f, 0, 0, 0.2f, 1, -1, 0, 0 };
        static const float n[12] = { 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0 };
        glbk_pixel pixels[4];
        float light[16], open[4];
        glbk_gbuffer_desc gd;
        sfield_scene_desc cd;
        sfield_entity e = at(BOX, 0.3f, 2, 0);
        sfield_points set;
        sfield_field *f;
        sfield_scene *cpu;
        glbk_sfield_scene s;
        glbk_sfield_haar r;
        glbk_gbuffer g;
        int k;
        d.cube_side = sides[i];
        d.keep = 1;
        assert_int_equal(sfield_build(&d, &mesh, &f, NULL), SFIELD_OK);
        e.occlusion = f;
        matrix_of(e.transform, 0, 1, 2, 0.5 * i, 0.8, 0.3, 2, 0);
        memset(&gd, 0, sizeof gd);
        memset(&cd, 0, sizeof cd);
        memset(pixels, 0, sizeof pixels);
        memset(&set, 0, sizeof set);
        gd.width = 4;
        gd.height = 1;
        cd.basis = SFIELD_BASIS_HAAR;
        cd.cube_side = sd.cube_side = sides[i];
        sd.fields = (const sfield_field *const *)&f;
        sd.field_count = 1;
        for (k = 0; k < 4; k++) {
            memcpy(pixels[k].position, p + 3 * k, 12);
            memcpy(pixels[k].normal, n + 3 * k, 12);
        }
        set.count = 4;
        set.positions = p;
        set.normals = n;
        set.ambient = open;
        assert_int_equal(sfield_scene_create(&cd, &cpu), SFIELD_OK);
        assert_int_equal(sfield_scene_entities(cpu, &e, 1), SFIELD_OK);
        assert_int_equal(sfield_shade(cpu, &set, 1, NULL), SFIELD_OK);
        assert_glbk(t, glbk_sfield_haar_upload(&t->gl, &sd, &s));
        assert_glbk(t, glbk_sfield_scene_entities(&t->gl, &s, &e, 1));
        assert_glbk(t, glbk_gbuffer_create(&t->gl, &gd, &g));
        assert_glbk(t, glbk_gbuffer_upload(&t->gl, &g, 0, 1, pixels));
        assert_glbk(t, glbk_sfield_haar_create(&t->gl, &h, &r));
        assert_glbk(t, glbk_sfield_haar_shade(&t->gl, &r, &g, &s, NULL, 1));
        assert_glbk(t, glbk_target_read(&t->gl, &r.target, 0, 0, 0, 4, 1, light));
        for (k = 0; k < 4; k++) assert_true(fabs((double)light[4 * k + 3] - (double)open[k]) < bound_of(1));
        assert_true(open[0] < 0.9f && light[0] == 0);
        glbk_sfield_haar_free(&t->gl, &r);
        glbk_gbuffer_free(&t->gl, &g);
        glbk_sfield_scene_free(&t->gl, &s);
        sfield_scene_free(cpu);
        sfield_free(f);
    }
    model_free(&box);
}

/* ---- gloss ---- */

static const float eye[3] = { 2, 5, 1 };

/* Shades pixels of other materials, seen from `eye`, into w->light and `shine`. */
static void shade_materials(gl_test *t, world *w, uint32_t count, const lsamp_material *material, float *shine)
{
    static glbk_pixel pixels[POINTS];
    static glbk_sfield_own none[POINTS];
    uint32_t i;
    memset(pixels, 0, sizeof pixels);
    for (i = 0; i < count; i++) {
        memcpy(pixels[i].position, w->position + 3 * i, 12);
        memcpy(pixels[i].normal, w->normal + 3 * i, 12);
        pixels[i].material = material[i];
    }
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, &w->gbuffer, 0, POINTS / WIDTH, pixels));
    assert_glbk(t, glbk_sfield_haar_self(&t->gl, &w->haar, &w->gl, 0, POINTS / WIDTH, none));
    assert_glbk(t, glbk_sfield_haar_shade(&t->gl, &w->haar, &w->gbuffer, &w->gl, eye, 1));
    assert_glbk(t, glbk_target_read(&t->gl, &w->haar.target, 0, 0, 0, WIDTH, POINTS / WIDTH, w->light));
    assert_glbk(t, glbk_target_read(&t->gl, &w->haar.target, 1, 0, 0, WIDTH, POINTS / WIDTH, shine));
}

static lsamp_material phong(float exponent)
{
    lsamp_material m;
    memset(&m, 0, sizeof m);
    m.kind = LSAMP_MATERIAL_PHONG;
    m.exponent = exponent;
    return m;
}

static lsamp_material metal_rough(float red, float metallic, float roughness)
{
    lsamp_material m;
    memset(&m, 0, sizeof m);
    m.kind = LSAMP_MATERIAL_METAL_ROUGH;
    m.diffuse[0] = red;
    m.diffuse[1] = 0.5f * red;
    m.diffuse[2] = 0.25f * red;
    m.metallic = metallic;
    m.roughness = roughness;
    return m;
}

/* Under a sky of 1: metal of roughness 1, whose albedo has a closed form, and Phong's lobe of exponent n along the
   normal behind a ball of that axis, which leaves cos^(n + 2) of the ball's angle. */
static void lobes_have_closed_forms(void **state)
{
    GL_TEST(t, state)
    static const float exponents[3] = { 2, 8, 20 };
    static float white[3 * 32], shine[4 * POINTS];
    static lsamp_material material[POINTS];
    static world w;
    sfield_entity e = at(BALL, 2, 3, 1);
    double worst = 0, lobe = 0;
    int i;
    for (i = 0; i < 96; i++) white[i] = 1;
    open_glossy_world(t, &w, 0, 1);
    for (i = 0; i < POINTS; i++) {              /* on a plane below the eye */
        const double v = 0.1 + 0.9 * i / POINTS, side = sqrt(1 - v * v) / v * 5;
        w.position[3 * i] = eye[0] - (float)(side * cos(0.7 * i));
        w.position[3 * i + 2] = eye[2] - (float)(side * sin(0.7 * i));
        w.normal[3 * i + 1] = 1;
        material[i] = metal_rough(1, 1, 1);
        material[i].diffuse[1] = 0;
    }
    place(t, &w, &e, 0, white, NULL);
    shade_materials(t, &w, POINTS, material, shine);
    for (i = 0; i < POINTS; i++) {
        const double v = 0.1 + 0.9 * i / POINTS;
        worst = fmax(worst, fabs((double)shine[4 * i] - (1 - v * log((1 + v) / v))));
        assert_true(w.light[4 * i] == 0);       /* F0 is 1: nothing is left that is diffuse */
        assert_true(shine[4 * i + 1] < shine[4 * i]);
    }
    CONFORM_MAX("gloss", "GL: wavelets, albedo of metal of roughness 1", 0.005, worst);
    memcpy(w.position, eye, 12);                /* right below the eye, and the ball between */
    w.position[1] = 0;
    e.transform[13] = 3;
    place(t, &w, &e, 1, white, NULL);
    for (i = 0; i < 3; i++) {
        const double s = 1.0 / 3, n = (double)exponents[i], all = pow(1 - s * s, 0.5 * (n + 2));
        material[0] = phong(exponents[i]);
        shade_materials(t, &w, 1, material, shine);
        lobe = fmax(lobe, fabs((double)shine[0] - all) / (0.5 * (n + 2) * pow(1 - s * s, 0.5 * n)));
        assert_true(fabs((double)w.light[0] - (1 - s * s)) < 0.01);
    }
    /* what the square of the ball's sine is off by, as in a_ball_hides_the_square_of_its_sine */
    CONFORM_MAX("gloss", "GL: wavelets, Phong's lobes behind a ball beside cos^(n + 2), as sine^2", 0.015, lobe);
    close_world(t, &w);
}

/* What the CPU makes of one kind of points: all with the same material. */
static void gloss_on_cpu(world *w, const lsamp_material *material, const float *to_eye, float *gloss)
{
    static float values[5 * POINTS], exponents[POINTS];
    const int metal = material[0].kind == LSAMP_MATERIAL_METAL_ROUGH;
    sfield_points set;
    int i;
    memset(&set, 0, sizeof set);
    for (i = 0; i < POINTS; i++) {
        memcpy(values + 5 * i, material[i].diffuse, 12);
        values[5 * i + 3] = material[i].metallic;
        values[5 * i + 4] = material[i].roughness;
        exponents[i] = material[i].exponent;
    }
    set.count = POINTS;
    set.positions = w->position;
    set.normals = w->normal;
    set.rgb = w->rgb;
    set.gloss = gloss;
    set.to_eye = to_eye;
    set.materials = metal ? values : NULL;
    set.material_stride = 20;
    set.exponents = metal ? NULL : exponents;
    set.exponent_stride = 4;
    assert_int_equal(sfield_shade(w->scene, &set, 1, NULL), SFIELD_OK);
}

/* Where the eye looks along the surface, or from below it, (v . h)^2 is lost in roundings of 1 + v . l, on the CPU as
   on the GPU: these points are compared less strictly, and narrow lobes are wider on the GPU there. */
static void lobes_are_as_on_the_cpu(void **state)
{
    GL_TEST(t, state)
    static const char *const names[3] = { "GL: wavelets off shadowfield.h, Phong",
                                          "GL: wavelets off shadowfield.h, metal-rough",
                                          "GL: wavelets off shadowfield.h, roughness 0.1 to 0.28" };
    static float sky[3 * 32], shine[4 * POINTS], gloss[3 * POINTS], to_eye[3 * POINTS];
    static lsamp_material material[POINTS];
    static world w;
    sfield_entity e[9];
    uint64_t seed = 31;
    int kind, i, k;
    for (i = 0; i < 96; i++) sky[i] = rnd_in(&seed, 0, 2);
    open_glossy_world(t, &w, 0, 1);
    random_points(&w, &seed);
    random_bodies(e, 9, &seed);
    place(t, &w, e, 9, sky, NULL);
    for (i = 0; i < POINTS; i++) {
        float length = 0;
        for (k = 0; k < 3; k++) {
            to_eye[3 * i + k] = eye[k] - w.position[3 * i + k];
            length += to_eye[3 * i + k] * to_eye[3 * i + k];
        }
        for (k = 0; k < 3; k++) to_eye[3 * i + k] /= sqrtf(length);
    }
    for (kind = 0; kind < 3; kind++) {
        double worst = 0, grazing = 0, most = 0, light = 0, brightest = 0;
        for (i = 0; i < POINTS; i++)
            material[i] = kind == 0 ? phong(rnd_in(&seed, 1, 100))
                                    : metal_rough(rnd_in(&seed, 0, 1), rnd_in(&seed, 0, 1),
                                                  kind == 1 ? rnd_in(&seed, 0.3, 1) : rnd_in(&seed, 0.1, 0.28));
        shade_materials(t, &w, POINTS, material, shine);
        gloss_on_cpu(&w, material, to_eye, gloss);
        for (i = 0; i < 3 * POINTS; i++) {
            const float *n = w.normal + i / 3 * 3, *v = to_eye + i / 3 * 3;
            const int above = n[0] * v[0] + n[1] * v[1] + n[2] * v[2] > 0.12f;
            double *off = above ? &worst : &grazing;
            *off = fmax(*off, fabs((double)shine[4 * (i / 3) + i % 3] - (double)gloss[i]));
            most = fmax(most, fabs((double)gloss[i]));
            light = fmax(light, fabs((double)w.light[4 * (i / 3) + i % 3] - (double)w.rgb[i]));
            brightest = fmax(brightest, fabs((double)w.rgb[i]));
        }
        print_message("%s: %.1e, grazing %.1e of %.2g, light %.1e of %.2g\n", names[kind], worst, grazing, most,
                      light, brightest);
        assert_true(most > 0.5 && brightest > 0.1);
        assert_true(light < 1e-3 * brightest && grazing < (kind < 2 ? 0.02 : 0.3) * most);
        CONFORM_MAX("gloss", names[kind], kind < 2 ? 1e-4 : 0.03, worst / most);
    }
    close_world(t, &w);
}

/* ---- arguments ---- */

#define LOGGED(text, call, expected)                    \
    do {                                                \
        t->log[0] = 0;                                  \
        assert_int_equal(call, expected);               \
        assert_string_equal(t->log, text);              \
    } while (0)

static void scenes_refuse_bad_arguments(void **state)
{
    GL_TEST(t, state)
    glbk_context *gl = &t->gl;
    glbk_sfield_haar_scene_desc desc = scene_desc(), *d = &desc;
    const sfield_field *one[2] = { field[BOX], NULL };
    sfield_desc other = haar_desc(2, 2);
    sfield_entity e = at(BOX, 0, 0, 0);
    model box = model_box(1, 1, 1);
    sfield_mesh mesh = mesh_of(&box);
    sfield_algebra *algebra;
    sfield_field *sh, *small;
    glbk_sfield_scene w, harmonics;
    glbk_sfield_scene_desc plain;
    float coefs[3] = { 0 };

    REFUSED(glbk_sfield_haar_upload(NULL, d, &w));
    REFUSED(glbk_sfield_haar_upload(gl, d, NULL));
    MAKES(w, glbk_sfield_haar_upload(gl, NULL, &w));
    DESC_WRONG(w, d->fields, NULL, glbk_sfield_haar_upload(gl, d, &w));
    DESC_WRONG(w, d->entity_capacity, 0, glbk_sfield_haar_upload(gl, d, &w));
    DESC_WRONG(w, d->entity_capacity, 65536, glbk_sfield_haar_upload(gl, d, &w));
    DESC_WRONG(w, d->reach, NAN, glbk_sfield_haar_upload(gl, d, &w));
    DESC_WRONG(w, d->reach, 2e6f, glbk_sfield_haar_upload(gl, d, &w));
    DESC_WRONG(w, d->cube_side, 2, glbk_sfield_haar_upload(gl, d, &w));
    DESC_WRONG(w, d->cube_side, 12, glbk_sfield_haar_upload(gl, d, &w));
    DESC_WRONG(w, d->cube_side, 128, glbk_sfield_haar_upload(gl, d, &w));
    assert_string_equal(t->log, "glbk_sfield_haar_upload: desc.cube_side is 128; it must be a power of two "
                                "within 4..64, or 0");
    d->fields = one;
    d->field_count = 2;
    LOGGED("glbk_sfield_haar_upload: desc.fields[1] is NULL", glbk_sfield_haar_upload(gl, d, &w),
           GLBK_ERR_DESC);
    other.cube_side = 8;
    assert_int_equal(sfield_build(&other, &mesh, &small, NULL), SFIELD_OK);
    one[1] = small;
    LOGGED("glbk_sfield_haar_upload: desc.fields[1] has another cube_side than desc.cube_side",
           glbk_sfield_haar_upload(gl, d, &w), GLBK_ERR_MISMATCH);
    other.basis = SFIELD_BASIS_SH;
    other.keep = 0;
    other.bands = 1;
    assert_int_equal(sfield_build(&other, &mesh, &sh, NULL), SFIELD_OK);
    one[1] = sh;
    LOGGED("glbk_sfield_haar_upload: desc.fields[1] is one of harmonics, which glbk_sfield_scene_create takes",
           glbk_sfield_haar_upload(gl, d, &w), GLBK_ERR_MISMATCH);
    sfield_free(small);
    other = haar_desc(2, 2);
    other.shard_end = 1;
    assert_int_equal(sfield_build(&other, &mesh, &small, NULL), SFIELD_OK);
    one[1] = small;
    LOGGED("glbk_sfield_haar_upload: desc.fields[1] is a shard: sfield_merge first",
           glbk_sfield_haar_upload(gl, d, &w), GLBK_ERR_MISMATCH);
    d->fields = (const sfield_field *const *)field;
    d->field_count = FIELDS;
    assert_glbk(t, glbk_sfield_haar_upload(gl, d, &w));
    e.occlusion = field[OWN];
    LOGGED("glbk_sfield_scene_entities: entities[0].occlusion is none of the scene's occlusion fields",
           glbk_sfield_scene_entities(gl, &w, &e, 1), GLBK_ERR_MISMATCH);
    e.occlusion = NULL;
    e.source = field[OWN];
    LOGGED("glbk_sfield_scene_entities: entities[0].source is none of the scene's source fields",
           glbk_sfield_scene_entities(gl, &w, &e, 1), GLBK_ERR_MISMATCH);
    LOGGED("glbk_sfield_scene_sky: scene has wavelets", glbk_sfield_scene_sky(gl, &w, NULL), GLBK_ERR_MISMATCH);
    assert_int_equal(sfield_algebra_create(1, NULL, &algebra), SFIELD_OK);
    memset(&plain, 0, sizeof plain);
    plain.algebra = algebra;
    plain.entity_capacity = 1;
    assert_glbk(t, glbk_sfield_scene_create(gl, &plain, &harmonics));
    LOGGED("glbk_sfield_haar_sky: scene has harmonics", glbk_sfield_haar_sky(gl, &harmonics, coefs),
           GLBK_ERR_MISMATCH);
    REFUSED(glbk_sfield_haar_sky(NULL, &w, NULL));
    REFUSED(glbk_sfield_haar_sky(gl, NULL, NULL));
    glbk_sfield_scene_free(gl, &harmonics);
    glbk_sfield_scene_free(gl, &w);
    sfield_algebra_free(algebra);
    sfield_free(sh);
    sfield_free(small);
    model_free(&box);
}

static void renderers_refuse_bad_arguments(void **state)
{
    GL_TEST(t, state)
    glbk_context *gl = &t->gl;
    glbk_sfield_haar_desc desc = { 4, 4, SIDE, 0, 0, 0 }, *d = &desc;
    glbk_sfield_own own[16];
    glbk_sfield_haar h, none;
    glbk_gbuffer_desc size = { 0 };
    glbk_gbuffer g;
    world w;
    open_world(t, &w, 0);
    memset(&none, 0, sizeof none);
    memset(own, 0, sizeof own);
    REFUSED(glbk_sfield_haar_create(NULL, d, &h));
    REFUSED(glbk_sfield_haar_create(gl, d, NULL));
    MAKES(h, glbk_sfield_haar_create(gl, NULL, &h));
    DESC_WRONG(h, d->width, 0, glbk_sfield_haar_create(gl, d, &h));
    WRONG_IS(GLBK_ERR_LIMIT, h, d->height, gl->max_side + 1, glbk_sfield_haar_create(gl, d, &h));
    DESC_WRONG(h, d->cube_side, 3, glbk_sfield_haar_create(gl, d, &h));
    DESC_WRONG(h, d->cube_side, 256, glbk_sfield_haar_create(gl, d, &h));
    assert_glbk(t, glbk_sfield_haar_create(gl, d, &h));
    REFUSED(glbk_sfield_haar_shade(NULL, &h, &w.gbuffer, &w.gl, NULL, 0));
    REFUSED(glbk_sfield_haar_shade(gl, NULL, &w.gbuffer, &w.gl, NULL, 0));
    REFUSED(glbk_sfield_haar_shade(gl, &none, &w.gbuffer, &w.gl, NULL, 0));
    REFUSED(glbk_sfield_haar_shade(gl, &h, NULL, &w.gl, NULL, 0));
    REFUSED(glbk_sfield_haar_shade(gl, &h, &w.gbuffer, NULL, NULL, 0));
    LOGGED("glbk_sfield_haar_shade: gbuffer->width is 12; it must be that of the renderer",
           glbk_sfield_haar_shade(gl, &h, &w.gbuffer, &w.gl, NULL, 0), GLBK_ERR_MISMATCH);
    LOGGED("glbk_sfield_haar_self: haar was created without desc.self",
           glbk_sfield_haar_self(gl, &h, &w.gl, 0, 1, own), GLBK_ERR_MISMATCH);
    glbk_sfield_haar_free(gl, &h);
    d->width = WIDTH;
    d->height = POINTS / WIDTH;
    d->gloss = 1;
    assert_glbk(t, glbk_sfield_haar_create(gl, d, &h));
    LOGGED("glbk_sfield_haar_shade: eye is NULL: lobes need it, and the G-buffer has none",
           glbk_sfield_haar_shade(gl, &h, &w.gbuffer, &w.gl, NULL, 0), GLBK_ERR_ARGUMENT);
    glbk_sfield_haar_free(gl, &h);
    d->width = d->height = 4;
    d->gloss = 0;
    d->cube_side = 8;
    d->self = 1;
    size.width = size.height = 4;
    assert_glbk(t, glbk_gbuffer_create(gl, &size, &g));
    assert_glbk(t, glbk_sfield_haar_create(gl, d, &h));
    LOGGED("glbk_sfield_haar_shade: scene->cube_side is 16; it must be that of the renderer",
           glbk_sfield_haar_shade(gl, &h, &g, &w.gl, NULL, 0), GLBK_ERR_MISMATCH);
    glbk_sfield_haar_free(gl, &h);
    d->cube_side = SIDE;
    assert_glbk(t, glbk_sfield_haar_create(gl, d, &h));
    REFUSED(glbk_sfield_haar_self(NULL, &h, &w.gl, 0, 1, own));
    REFUSED(glbk_sfield_haar_self(gl, &h, &w.gl, 0, 1, NULL));
    REFUSED(glbk_sfield_haar_self(gl, &h, &w.gl, 4, 1, own));
    REFUSED(glbk_sfield_haar_self(gl, &h, &w.gl, 0, 0, own));
    REFUSED(glbk_sfield_haar_self(gl, &h, &w.gl, 2, 3, own));
    own[2].self = field[BOX];
    LOGGED("glbk_sfield_haar_self: own[2].self is none of the scene's self-visibilities",
           glbk_sfield_haar_self(gl, &h, &w.gl, 0, 1, own), GLBK_ERR_MISMATCH);
    own[2].self = field[OWN];
    own[2].point = POINTS;
    LOGGED("glbk_sfield_haar_self: own[2].point is 96; it must be 0..95",
           glbk_sfield_haar_self(gl, &h, &w.gl, 0, 1, own), GLBK_ERR_INPUT);
    own[2].point = POINTS - 1;
    assert_glbk(t, glbk_sfield_haar_self(gl, &h, &w.gl, 0, 1, own));
    glbk_sfield_haar_free(gl, NULL);
    glbk_sfield_haar_free(gl, &h);
    glbk_sfield_haar_free(gl, &h);
    glbk_gbuffer_free(gl, &g);
    close_world(t, &w);
}

/* Lists are for compute shaders, trees for fragment shaders: ctx->compute decides when a scene is made. */
static void scenes_are_for_compute_or_not(void **state)
{
    GL_TEST(t, state)
    const glbk_sfield_haar_scene_desc sd = scene_desc();
    glbk_sfield_scene trees;
    world w;
    open_world(t, &w, 0);
    assert_int_equal(w.haar.compute, t->gl.compute);
    assert_int_equal(w.gl.lists, t->gl.compute);
    if (t->gl.compute) {
        t->gl.compute = 0;
        assert_glbk(t, glbk_sfield_haar_upload(&t->gl, &sd, &trees));
        t->gl.compute = 1;
        LOGGED("glbk_sfield_haar_shade: scene was uploaded with another ctx->compute than the renderer was made with",
               glbk_sfield_haar_shade(&t->gl, &w.haar, &w.gbuffer, &trees, NULL, 0), GLBK_ERR_MISMATCH);
        glbk_sfield_scene_free(&t->gl, &trees);
    }
    close_world(t, &w);
}

/* What glbk_sfield_haar_self wrote are places in one scene's table. */
static void self_visibility_is_of_one_scene(void **state)
{
    GL_TEST(t, state)
    static float sky[3 * 6 * SIDE * SIDE], bare[4 * POINTS], whole[4 * POINTS];
    static glbk_sfield_own owns[POINTS];
    static world w;
    const sfield_field *two[2] = { field[BOX], field[OWN] };
    glbk_sfield_haar_scene_desc sd = scene_desc();
    glbk_sfield_scene same, other;
    uint32_t i, differ = 0;
    open_world(t, &w, 0);
    memcpy(w.position, at_box, sizeof at_box);
    for (i = 0; i < 3 * POINTS; i++) w.normal[i] = -out_of_box[i];     /* into the box, which is convex */
    for (i = 0; i < sizeof sky / sizeof sky[0]; i++) sky[i] = 1;
    assert_glbk(t, glbk_sfield_haar_upload(&t->gl, &sd, &same));
    sd.fields = two;
    sd.field_count = 2;
    assert_glbk(t, glbk_sfield_haar_upload(&t->gl, &sd, &other));
    assert_glbk(t, glbk_sfield_haar_sky(&t->gl, &w.gl, sky));
    assert_glbk(t, glbk_sfield_haar_sky(&t->gl, &same, sky));
    assert_glbk(t, glbk_sfield_haar_sky(&t->gl, &other, sky));
    shade_gl(t, &w, POINTS, 0, NULL, 0);
    memcpy(bare, w.light, sizeof bare);
    shade_gl(t, &w, POINTS, 0, NULL, 1);
    memcpy(whole, w.light, sizeof whole);
    for (i = 0; i < POINTS; i++) differ += fabsf(whole[4 * i] - bare[4 * i]) > 1e-4f;
    assert_true(differ > POINTS / 4);           /* or the rest shows nothing */
    assert_glbk(t, glbk_sfield_haar_shade(&t->gl, &w.haar, &w.gbuffer, &same, NULL, 1));
    assert_glbk(t, glbk_target_read(&t->gl, &w.haar.target, 0, 0, 0, WIDTH, POINTS / WIDTH, w.light));
    assert_memory_equal(w.light, whole, sizeof whole);
    LOGGED("glbk_sfield_haar_shade: scene is not the one of glbk_sfield_haar_self",
           glbk_sfield_haar_shade(&t->gl, &w.haar, &w.gbuffer, &other, NULL, 1), GLBK_ERR_MISMATCH);
    memset(owns, 0, sizeof owns);
    for (i = 0; i < WIDTH; i++) {               /* the first row alone, for the other scene */
        owns[i].self = field[OWN];
        owns[i].point = i;
    }
    assert_glbk(t, glbk_sfield_haar_self(&t->gl, &w.haar, &other, 0, 1, owns));
    LOGGED("glbk_sfield_haar_shade: scene is not the one of glbk_sfield_haar_self",
           glbk_sfield_haar_shade(&t->gl, &w.haar, &w.gbuffer, &w.gl, NULL, 1), GLBK_ERR_MISMATCH);
    assert_glbk(t, glbk_sfield_haar_shade(&t->gl, &w.haar, &w.gbuffer, &other, NULL, 1));
    assert_glbk(t, glbk_target_read(&t->gl, &w.haar.target, 0, 0, 0, WIDTH, POINTS / WIDTH, w.light));
    assert_memory_equal(w.light, whole, 4 * WIDTH * sizeof(float));
    assert_memory_equal(w.light + 4 * WIDTH, bare + 4 * WIDTH, sizeof bare - 4 * WIDTH * sizeof(float));
    glbk_sfield_scene_free(&t->gl, &same);
    glbk_sfield_scene_free(&t->gl, &other);
    close_world(t, &w);
}

/* Gives the same memory from the start again whenever `used` is set to 0, and takes nothing back. */
enum { ARENA = 1 << 20 };
static struct { char *bytes; size_t used; } arena;

static void *take_arena(size_t size, void *user)
{
    void *at = arena.bytes + arena.used;
    (void)user;
    if (size > ARENA - arena.used) return NULL;
    arena.used += (size + 63) / 64 * 64;
    return at;
}

static void leave_arena(void *block, void *user) { (void)block, (void)user; }

/* Opens a self-visibility of the box's first points where the one before was. */
static sfield_field *open_again(uint32_t points)
{
    model box = model_box(1, 0.5, 0.7);
    const sfield_mesh of_box = mesh_of(&box);
    const sfield_desc d = haar_desc(5, 4);
    sfield_field *built, *opened;
    sfield_system system;
    size_t bytes;
    void *file;
    memset(&system, 0, sizeof system);
    system.allocator.alloc_fn = take_arena;
    system.allocator.free_fn = leave_arena;
    assert_int_equal(sfield_build_self(&d, &of_box, AT(at_box, out_of_box, points), 0.01f, &built, NULL), SFIELD_OK);
    bytes = sfield_bytes(built);
    file = malloc(bytes);
    assert_non_null(file);
    assert_int_equal(sfield_write(built, file, bytes), SFIELD_OK);
    arena.used = 0;
    assert_int_equal(sfield_open(file, bytes, &system, &opened), SFIELD_OK);
    free(file);
    sfield_free(built);
    model_free(&box);
    return opened;
}

/* A field that is freed and made anew may have the address of the old one, and is another one all the same. */
static void self_visibility_at_an_old_address_is_another(void **state)
{
    GL_TEST(t, state)
    static glbk_sfield_own owns[WIDTH];
    static world w;
    const sfield_field *two[2] = { field[BOX], NULL };
    glbk_sfield_haar_scene_desc sd = scene_desc();
    glbk_sfield_scene old, made;
    uint32_t i;
    arena.bytes = (char *)malloc(ARENA);
    assert_non_null(arena.bytes);
    open_world(t, &w, 0);
    sd.fields = two;
    sd.field_count = 2;
    two[1] = open_again(WIDTH);
    assert_glbk(t, glbk_sfield_haar_upload(&t->gl, &sd, &old));
    memset(owns, 0, sizeof owns);
    for (i = 0; i < WIDTH; i++) {
        owns[i].self = two[1];
        owns[i].point = i;
    }
    assert_glbk(t, glbk_sfield_haar_self(&t->gl, &w.haar, &old, 0, 1, owns));
    glbk_sfield_scene_free(&t->gl, &old);
    assert_ptr_equal(open_again(WIDTH / 2), two[1]);        /* half of the points: the others would be no trees */
    assert_glbk(t, glbk_sfield_haar_upload(&t->gl, &sd, &made));
    LOGGED("glbk_sfield_haar_shade: scene is not the one of glbk_sfield_haar_self",
           glbk_sfield_haar_shade(&t->gl, &w.haar, &w.gbuffer, &made, NULL, 1), GLBK_ERR_MISMATCH);
    glbk_sfield_scene_free(&t->gl, &made);
    close_world(t, &w);
    free(arena.bytes);
}

/* ---- failures put into GL's mouth, and a state turned over ---- */

static uint32_t (GLBK_CALL *real_error)(void);
static int error_at, error_calls, memory_left;

static uint32_t GLBK_CALL lying_error(void)
{
    uint32_t error = real_error();
    return ++error_calls == error_at ? 0x0505 : error;       /* GL_OUT_OF_MEMORY */
}

static void *little_memory(size_t size, void *user)
{
    (void)user;
    return memory_left-- > 0 ? malloc(size) : NULL;
}

static void release(void *memory, void *user)
{
    (void)user;
    free(memory);
}

/* A scene of two fields, and a renderer of 4 x 4 pixels with one point. */
static glbk_result make_all(gl_test *t, glbk_sfield_scene *s, glbk_gbuffer *g, glbk_sfield_haar *h)
{
    static float sky[3 * 6 * SIDE * SIDE];
    const sfield_field *two[2] = { field[BOX], field[OWN] };
    const glbk_sfield_haar_desc d = { 4, 4, SIDE, 0, 1, 0 };
    glbk_sfield_haar_scene_desc sd = scene_desc();
    glbk_sfield_own own[4];
    glbk_gbuffer_desc of;
    glbk_pixel pixels[4];
    sfield_entity e = at(BOX, 0, 1.5f, 0);
    glbk_result result = GLBK_OK;
    uint32_t row;
    size_t i;
    memset(g, 0, sizeof *g);
    memset(h, 0, sizeof *h);
    memset(&of, 0, sizeof of);
    memset(pixels, 0, sizeof pixels);
    memset(own, 0, sizeof own);
    of.width = of.height = 4;
    sd.fields = two;
    sd.field_count = 2;
    pixels[0].normal[1] = 1;
    own[0].self = field[OWN];
    for (i = 0; i < sizeof sky / sizeof sky[0]; i++) sky[i] = 1;
    GL_THEN_SAME(t, result, glbk_sfield_haar_upload(&t->gl, &sd, s));
    GL_THEN_SAME(t, result, glbk_sfield_scene_entities(&t->gl, s, &e, 1));
    GL_THEN_SAME(t, result, glbk_sfield_haar_sky(&t->gl, s, sky));
    GL_THEN_SAME(t, result, glbk_gbuffer_create(&t->gl, &of, g));
    GL_THEN_SAME(t, result, glbk_sfield_haar_create(&t->gl, &d, h));
    for (row = 0; row < 4; row++) GL_THEN_SAME(t, result, glbk_gbuffer_upload(&t->gl, g, row, 1, pixels));
    GL_THEN_SAME(t, result, glbk_sfield_haar_self(&t->gl, h, s, 0, 1, own));
    return result;
}

static void failures_leave_nothing(void **state)
{
    GL_TEST(t, state)
    glbk_sfield_scene s;
    glbk_gbuffer g;
    glbk_sfield_haar h;
    glbk_result result;
    int kind, done = 0;
    t->gl.check = 1;
    real_error = t->gl.gl.GetError;
    for (kind = 0; kind < 2; kind++)
        for (error_at = 1, done = 0; !done; error_at++) {
            error_calls = 0;
            memory_left = error_at - 1;
            if (kind) {
                t->gl.system.allocator.alloc_fn = little_memory;
                t->gl.system.allocator.free_fn = release;
            } else t->gl.gl.GetError = lying_error;
            result = make_all(t, &s, &g, &h);
            t->gl.gl.GetError = real_error;
            memset(&t->gl.system.allocator, 0, sizeof t->gl.system.allocator);
            done = result == GLBK_OK;
            if (!done && kind) assert_int_equal(result, GLBK_ERR_ALLOC);
            if (!done && !kind) assert_true(result == GLBK_ERR_PENDING || result == GLBK_ERR_GL_MEMORY);
            if (!done && !h.light.name) assert_int_equal(h.sum.name + h.self.name + h.block.name + h.cubes.name, 0);
            glbk_sfield_haar_free(&t->gl, &h);
            glbk_gbuffer_free(&t->gl, &g);
            glbk_sfield_scene_free(&t->gl, &s);
            assert_int_equal(s.table.name + h.light.name + h.target.name, 0);
            assert_true(error_at < 400);
        }
}

static void make_and_shade(gl_test *t, float light[64])
{
    glbk_sfield_scene s;
    glbk_gbuffer g;
    glbk_sfield_haar h;
    assert_glbk(t, make_all(t, &s, &g, &h));
    GL_SAVED(t, assert_glbk(t, glbk_sfield_haar_shade(&t->gl, &h, &g, &s, NULL, 1)));
    GL_SAME(t, assert_glbk(t, glbk_target_read(&t->gl, &h.target, 0, 0, 0, 4, 4, light)));
    GL_SAME(t, glbk_sfield_haar_free(&t->gl, &h));
    GL_SAME(t, glbk_gbuffer_free(&t->gl, &g));
    GL_SAME(t, glbk_sfield_scene_free(&t->gl, &s));
}

static void a_hostile_state_changes_nothing(void **state)
{
    GL_TEST(t, state)
    float plain[64], odd[64];
    gl_hostile h;
    gl_state_watch(t, 1);
    gl_count_begin(&t->gl);
    make_and_shade(t, plain);
    gl_count_end(&t->gl);
    assert_true(plain[0] > 0.1f && plain[0] < 0.9f && plain[4] == 0);       /* one point is there */
    gl_hostile_make(t, &h);
    gl_hostile_set(t, &h);
    make_and_shade(t, odd);
    assert_memory_equal(plain, odd, sizeof plain);
    gl_hostile_free(t, &h);
}

static void a_lost_context_is_called_no_more(void **state)
{
    GL_TEST(t, state)
    static glbk_functions none;
    static float sky[3 * 6 * SIDE * SIDE];
    const glbk_sfield_haar_scene_desc sd = scene_desc();
    const glbk_sfield_haar_desc d = { 4, 4, SIDE, 0, 1, 0 };
    glbk_sfield_scene s, s2;
    glbk_gbuffer g;
    glbk_sfield_haar h, h2;
    glbk_sfield_own own[4];
    glbk_context ctx;
    memset(own, 0, sizeof own);
    assert_glbk(t, make_all(t, &s, &g, &h));
    ctx = t->gl;
    t->gl.gl = none;                    /* from here on a call of GL would crash */
    glbk_abandon(&t->gl);
    assert_int_equal(glbk_sfield_haar_upload(&t->gl, &sd, &s2), GLBK_ERR_LOST);
    assert_int_equal(glbk_sfield_haar_create(&t->gl, &d, &h2), GLBK_ERR_LOST);
    assert_int_equal(s2.table.name + h2.light.name, 0);
    assert_int_equal(glbk_sfield_haar_shade(&t->gl, &h, &g, &s, NULL, 0), GLBK_ERR_LOST);
    assert_int_equal(glbk_sfield_haar_sky(&t->gl, &s, sky), GLBK_ERR_LOST);
    assert_int_equal(glbk_sfield_haar_self(&t->gl, &h, &s, 0, 1, own), GLBK_ERR_LOST);
    h2 = h;
    glbk_sfield_haar_free(&t->gl, &h2);
    t->gl = ctx;
    glbk_sfield_haar_free(&t->gl, &h);
    glbk_gbuffer_free(&t->gl, &g);
    glbk_sfield_scene_free(&t->gl, &s);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(a_ball_hides_the_square_of_its_sine), gl_unit_test(a_ball_before_a_lamp_leaves_a_ring),
        gl_unit_test(scenes_are_shaded_as_on_the_cpu), gl_unit_test(long_lists_take_more_rounds),
        gl_unit_test(bodies_of_every_side_of_texels), gl_unit_test(lobes_have_closed_forms),
        gl_unit_test(lobes_are_as_on_the_cpu), gl_unit_test(scenes_refuse_bad_arguments),
        gl_unit_test(renderers_refuse_bad_arguments), gl_unit_test(self_visibility_is_of_one_scene),
        gl_unit_test(self_visibility_at_an_old_address_is_another), gl_unit_test(failures_leave_nothing),
        gl_unit_test(a_hostile_state_changes_nothing), gl_unit_test(a_lost_context_is_called_no_more),
        gl_unit_test(scenes_are_for_compute_or_not)
    };
    struct CMUnitTest lit[7];
    int result;
    (void)count;
    if (gl_run_ways(values, GL_CORE45 | GL_CORE33 | GL_ES30, &result)) return result;
    if (gl_this_way() && gl_this_way()->bit != GL_CORE33) unsetenv("CONFORMANCE");     /* each row once */
    gl_name_tests(tests, sizeof tests / sizeof tests[0]);
    memcpy(lit, tests, sizeof lit);     /* what is refused, and how it fails, is the same on all contexts */
    if (gl_this_way() && (gl_this_way()->bit & (GL_ES30 | GL_WEBGL2)))
        return cmocka_run_group_tests(lit, make_fields, free_fields);
    return cmocka_run_group_tests(tests, make_fields, free_fields);
}
