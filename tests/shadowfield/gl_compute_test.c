/* gl_compute_test - the compute programs of sfield against the core path's, which one context has both of: scenes
   of few, some and more entities than a work group lists, of 1 to 8 bands; texels and coefficients of building. */
#define _POSIX_C_SOURCE 200809L
#include "shadowfield.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend/gl_shadowfield.h"

#include "gl_test.h"
#include "util.h"

enum { FIELDS = 4, MOST = 200, WIDTH = 21, HEIGHT = 13, PIXELS = WIDTH * HEIGHT };

/* ---- worlds ---- */

typedef struct world {
    sfield_algebra   *algebra;
    sfield_field     *field[FIELDS];            /* box, soup; lights: ball, the soup that flickers */
    float            *brdf;
    glbk_sfield_scene gl;
} world;

static void open_world(gl_test *t, world *w, uint32_t bands, float reach)
{
    static float radiance[2 * 3 * 100];
    model box = model_box(1, 0.5, 0.7), soup = model_soup(40, 0.5, 3), ball = model_sphere(10, 5, 0.5);
    sfield_mesh of_box = mesh_of(&box), of_soup = mesh_of(&soup), of_ball = mesh_of(&ball);
    glbk_sfield_scene_desc g;
    sfield_desc d;
    int i;
    memset(w, 0, sizeof *w);
    memset(&d, 0, sizeof d);
    memset(&g, 0, sizeof g);
    d.bands = bands;
    d.cube_side = 4;
    d.shell_count = 4;
    d.position_side = 3;
    for (i = 0; i < 2 * 3 * 100; i++) radiance[i] = (float)(1 + i % 7 + i / 300);
    assert_int_equal(sfield_algebra_create(bands, NULL, &w->algebra), SFIELD_OK);
    assert_int_equal(sfield_build(&d, &of_box, &w->field[0], NULL), SFIELD_OK);
    assert_int_equal(sfield_build(&d, &of_soup, &w->field[1], NULL), SFIELD_OK);
    assert_int_equal(sfield_build_emissive(&d, &of_ball, radiance, &w->field[2], NULL), SFIELD_OK);
    d.frame_count = 2;
    d.frames_per_second = 10;
    assert_int_equal(sfield_build_emissive(&d, &of_soup, radiance, &w->field[3], NULL), SFIELD_OK);
    w->brdf = (float *)malloc(sfield_sh_brdf(bands, NULL, NULL) * sizeof(float));
    assert_int_equal(sfield_sh_brdf(bands, NULL, w->brdf), sfield_sh_brdf(bands, NULL, NULL));
    g.brdf = w->brdf;
    g.algebra = w->algebra;
    g.fields = (const sfield_field *const *)w->field;
    g.field_count = FIELDS;
    g.entity_capacity = MOST;
    g.reach = reach;
    assert_glbk(t, glbk_sfield_scene_create(&t->gl, &g, &w->gl));
    model_free(&box);
    model_free(&soup);
    model_free(&ball);
}

static void close_world(gl_test *t, world *w)
{
    int i;
    glbk_sfield_scene_free(&t->gl, &w->gl);
    for (i = 0; i < FIELDS; i++) sfield_free(w->field[i]);
    sfield_algebra_free(w->algebra);
    free(w->brdf);
}

static void turn_at_random(float *m, uint64_t *seed)
{
    double a[3], b[3], c[3], l = 0;
    float scale = rnd_in(seed, 0.2, 0.6);
    int k;
    rnd_direction(seed, a);
    rnd_direction(seed, b);
    for (k = 0; k < 3; k++) c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
    for (k = 0; k < 3; k++) l += c[k] * c[k];
    for (k = 0; k < 3; k++) c[k] /= sqrt(l);
    for (k = 0; k < 3; k++) b[k] = c[(k + 1) % 3] * a[(k + 2) % 3] - c[(k + 2) % 3] * a[(k + 1) % 3];
    for (k = 0; k < 3; k++) {
        m[k] = scale * (float)a[k];
        m[4 + k] = scale * (float)b[k];
        m[8 + k] = scale * (float)c[k];
    }
}

/* About the floor that is shaded, some below it. Each fourth does not turn; each fifth stands where another does, so
   that distances are the same; a few shine, and a few of these hide. */
static void place(gl_test *t, world *w, uint32_t count, int sky)
{
    static sfield_entity e[MOST];
    float coefs[3 * 64];
    uint64_t seed = 77;
    uint32_t i, k;
    memset(e, 0, sizeof e);
    for (i = 0; i < count; i++) {
        float *m = e[i].transform;
        m[0] = m[5] = m[10] = 0.4f;
        m[15] = 1;
        if (i % 4) turn_at_random(m, &seed);
        m[12] = rnd_in(&seed, -4, 4);
        m[13] = rnd_in(&seed, -1.2, 2.5);
        m[14] = rnd_in(&seed, -3, 3);
        if (i % 5 == 4) memcpy(m + 12, e[i - 2].transform + 12, 12);
        if (i % 7 != 3) e[i].occlusion = w->field[i & 1];
        if (i % 7 == 3 || i % 11 == 6) e[i].source = w->field[2 + (i & 1)];
        for (k = 0; k < 3; k++) e[i].tint[k] = 0.5f + 0.1f * (float)k;
        e[i].time = 0.03f * (float)(i % 5);
    }
    for (k = 0; k < 3 * 64; k++) coefs[k] = rnd_in(&seed, -0.2, 1);
    assert_glbk(t, glbk_sfield_scene_entities(&t->gl, &w->gl, e, count));
    assert_glbk(t, glbk_sfield_scene_sky(&t->gl, &w->gl, sky ? coefs : NULL));
}

/* A floor with steps, so that some work groups' points lie apart; a few of its points belong to entities, have own
   visibility, or are not there: one group sees nothing at all. */
static void fill(gl_test *t, glbk_gbuffer *g, glbk_sfield_renderer *r, uint32_t entities)
{
    static glbk_pixel pixels[PIXELS];
    static const float *own[PIXELS];
    static float self[64];
    uint32_t x, y, k;
    memset(pixels, 0, sizeof pixels);
    for (k = 0; k < 64; k++) self[k] = 0.8f / (float)(1 + k);
    for (y = 0; y < HEIGHT; y++)
        for (x = 0; x < WIDTH; x++) {
            glbk_pixel *p = &pixels[y * WIDTH + x];
            p->position[0] = 0.25f * (float)x - 2.5f;
            p->position[1] = x > 11 && y > 4 ? 0.8f : 0;
            p->position[2] = 0.25f * (float)y - 1.5f;
            p->normal[1] = x < 8 && y > 7 ? 0 : x == 12 ? 0.6f : 1;
            p->normal[0] = x == 12 ? 0.8f : 0;
            p->entity = (x + y) % 9 ? 0 : 1 + (x + 3 * y) % entities;
            own[y * WIDTH + x] = (x + y) % 4 == 1 ? self : NULL;
            p->material.kind = (x + y) % 3 ? LSAMP_MATERIAL_PHONG : LSAMP_MATERIAL_LAMBERT;
            p->material.exponent = (float)((x + y) % 3) * 8;
            p->material.metallic = 0.5f;
            p->material.roughness = 0.05f * (float)x;
            for (k = 0; k < 3; k++) p->material.diffuse[k] = 0.3f * (float)k + 0.1f;
            if ((x + y) % 5 == 0) p->material.kind = LSAMP_MATERIAL_METAL_ROUGH;
        }
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, g, 0, HEIGHT, pixels));
    assert_glbk(t, glbk_sfield_self_upload(&t->gl, r, 0, HEIGHT, own));
}

typedef struct images { float light[PIXELS][4], shine[PIXELS][4], graze[PIXELS][4]; } images;

static void shade(gl_test *t, glbk_context *gl, const world *w, uint32_t entities, int gloss, int unrolled,
                  images *out)
{
    static const float eye[3] = { 1, 4, 3 };
    glbk_sfield_renderer_desc d;
    glbk_sfield_renderer r;
    glbk_gbuffer_desc of;
    glbk_gbuffer g;
    memset(&d, 0, sizeof d);
    memset(&of, 0, sizeof of);
    of.width = d.width = WIDTH;
    of.height = d.height = HEIGHT;
    d.self = 1;
    d.algebra = w->algebra;
    d.gloss = gloss == 1;
    d.materials = d.grazing = gloss == 2;
    d.product_in_table = !unrolled;
    assert_glbk(t, glbk_gbuffer_create(gl, &of, &g));
    assert_glbk(t, glbk_sfield_renderer_create(gl, &d, &r));
    assert_int_equal(r.compute, gl->compute);
    fill(t, &g, &r, entities);
    assert_glbk(t, glbk_sfield_shade(gl, &r, &g, &w->gl, eye, 1));
    assert_glbk(t, glbk_sfield_read(gl, &r, out->light[0], gloss ? out->shine[0] : NULL));
    if (gloss == 2) assert_glbk(t, glbk_target_read(gl, &r.target, 2, 0, 0, WIDTH, HEIGHT, out->graze[0]));
    glbk_sfield_renderer_free(gl, &r);
    glbk_gbuffer_free(gl, &g);
}

/* ---- scenes ---- */

typedef struct scene_case { uint32_t bands, entities; float reach; int sky, gloss, unrolled; } scene_case;

/* 128 entities are listed at most: 200 of them that reach far, and shine, are gone through in the table. 8 bands and
   gloss are 1616 rounds of a loop for each occluder, of which software drivers do 65535 and no more. */
static const scene_case cases[] = { { 4, 60, 2.5f, 0, 0, 1 }, { 4, 200, 0, 1, 0, 1 }, { 4, 60, 2.5f, 1, 1, 1 },
                                    { 3, 60, 0, 1, 1, 0 },    { 2, 60, 2.5f, 1, 2, 1 },
                                       { 1, 40, 2.5f, 1, 0, 1 }, { 8, 24, 3, 1, 1, 0 } };

static void scenes_are_lit_as_on_the_core_path(void **state)
{
    GL_TEST(t, state)
    static world w;
    static images of[2];
    glbk_context core = t->gl;
    size_t i;
    int p, k;
    assert_true(t->gl.compute);
    core.compute = 0;
    for (i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const scene_case *c = &cases[i];
        double off = 0, most = 0, dark = 0, seen = 0;
        open_world(t, &w, c->bands, c->reach);
        place(t, &w, c->entities, c->sky);
        shade(t, &t->gl, &w, c->entities, c->gloss, c->unrolled, &of[0]);
        shade(t, &core, &w, c->entities, c->gloss, c->unrolled, &of[1]);
        for (p = 0; p < PIXELS; p++) {
            for (k = 0; k < 4; k++) {
                off = fmax(off, fabs((double)of[0].light[p][k] - (double)of[1].light[p][k]));
                most = fmax(most, fabs((double)of[1].light[p][k]));
                if (!c->gloss) continue;
                off = fmax(off, fabs((double)of[0].shine[p][k] - (double)of[1].shine[p][k]));
                most = fmax(most, fabs((double)of[1].shine[p][k]));
                if (c->gloss > 1) off = fmax(off, fabs((double)of[0].graze[p][k] - (double)of[1].graze[p][k]));
            }
            seen += of[1].light[p][0] != 0;
            dark += of[1].light[p][0] != 0 && of[1].light[p][3] < 0.9f;
        }
        printf("%u bands, %u entities: off the core path by %.1e of %.2g; %.0f of %.0f points in some shadow\n",
               c->bands, c->entities, off, most, dark, seen);
        assert_true(seen > PIXELS / 2 && seen < PIXELS && dark > 20);
        assert_true(off <= 1e-6 * most);
        close_world(t, &w);
    }
}

/* ---- building ---- */

static void cubes_are_those_of_the_core_path(void **state)
{
    GL_TEST(t, state)
    enum { EYES = 14, MOST_TEXELS = 3 * 6 * 32 * 32 };
    static const uint32_t sides[5] = { 4, 8, 16, 32, 16 }, bands[5] = { 1, 3, 4, 5, 8 };
    static const float distance[7] = { 0.3f, 0.9f, 1.2f, 2.7f, 5.4f, 8, 20 };
    static float radiance[300], eye[EYES][3], values[2][2][EYES * MOST_TEXELS];
    model soup = model_soup(100, 0.5, 4);
    const sfield_mesh mesh = mesh_of(&soup);
    uint64_t seed = 9;
    uint32_t i, k, n;
    int source, path;
    assert_true(t->gl.compute);
    for (i = 0; i < 300; i++) radiance[i] = i % 4 ? rnd_in(&seed, 0, 2) : 0;
    for (i = 0; i < EYES; i++) {
        double d[3];
        rnd_direction(&seed, d);
        for (k = 0; k < 3; k++) eye[i][k] = distance[i / 2] * (float)d[k];
    }
    for (n = 0; n < 5; n++)
        for (source = 0; source < 2; source++) {
            const uint32_t cells = 6 * sides[n] * sides[n], coefs = bands[n] * bands[n], channels = source ? 3 : 1;
            float *basis = (float *)malloc((size_t)cells * coefs * sizeof *basis);
            double texels_off = 0, coefs_off = 0, most = 0;
            assert_non_null(basis);
            for (i = 0; i < cells; i++)
                assert_int_equal(sfield_cube_basis(bands[n], sides[n], i, basis + (size_t)i * coefs), SFIELD_OK);
            for (path = 0; path < 4; path++) {          /* texels, coefficients: by compute, on the core path */
                glbk_context gl = t->gl;
                glbk_sfield_builder_desc d;
                glbk_sfield_builder b;
                sfield_desc field;
                sfield_views views;
                memset(&d, 0, sizeof d);
                memset(&field, 0, sizeof field);
                memset(&views, 0, sizeof views);
                field.cube_side = sides[n];
                if (path < 2) field.basis = SFIELD_BASIS_HAAR;
                else field.bands = bands[n];
                d.field = &field;
                d.source = source;
                d.radiance = radiance;
                d.mesh = &mesh;
                views.radius = 1;
                views.count = EYES;
                views.eyes = eye[0];
                views.values = values[path / 2][path % 2];
                gl.compute = path % 2 == 0;
                assert_glbk(t, glbk_sfield_builder_create(&gl, &d, &b));
                assert_int_equal(b.compute, gl.compute);
                assert_glbk(t, glbk_sfield_builder_see(&gl, &b, &views));
                glbk_sfield_builder_free(&gl, &b);
            }
            for (i = 0; i < EYES * channels * cells; i++)
                texels_off = fmax(texels_off, fabs((double)values[0][0][i] - (double)values[0][1][i]));
            for (i = 0; i < EYES * channels * coefs; i++) {
                const float *texel = values[0][0] + (size_t)(i / coefs) * cells;
                double exact = 0;
                for (k = 0; k < cells; k++) exact += (double)texel[k] * (double)basis[(size_t)k * coefs + i % coefs];
                coefs_off = fmax(coefs_off, fabs((double)values[1][0][i] - exact));
                most = fmax(most, fabs(exact));
                if (fabs((double)values[1][1][i] - exact) > 1e-5 * (1 + fabs(exact)))
                    fail_msg("coefficient %u on the core path: %g, not %g", i, (double)values[1][1][i], exact);
            }
            printf("%u^2, %u bands%s: texels off the core path by %.1e, coefficients off exact ones by %.1e of %.2g\n",
                   sides[n], bands[n], source ? ", radiance" : "", texels_off, coefs_off, most);
            assert_true(most > 0.3);
            assert_true(source ? texels_off < 1e-5 : texels_off == 0);      /* up to 4096 floats in a row; counts */
            assert_true(coefs_off <= 2e-6 * most);
            free(basis);
        }
    model_free(&soup);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = { gl_unit_test(scenes_are_lit_as_on_the_core_path),
    gl_unit_test(cubes_are_those_of_the_core_path) };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE45);
}
