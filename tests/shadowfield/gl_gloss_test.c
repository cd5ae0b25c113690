/* gl_gloss_test - glTF's metal-rough BRDF on GL beside closed forms, as gloss_test has it on the CPU. Behind
   occluders gl_twin_test compares GL with the CPU, and gl_compute_test compute with the core path. */
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
#define CONFORM_BACKEND "gl"
#include "conformance.h"

enum { VIEWS = 24, KINDS = 4, PIXELS = VIEWS * KINDS };

typedef struct answer { float light[PIXELS][4], gloss[PIXELS][4]; } answer;

/* The cosine between the normal +y and the eye of a column. */
static double cosine_of(int column) { return (column + 0.5) / VIEWS; }

/* Pixels at the origin would all see the eye from one side, so each lies where it sees the eye at its own angle. Rows:
   metal of roughness 1, a dielectric mirror, red metal of roughness 0.5, a diffuse surface. */
static void fill(glbk_pixel *pixels, const float *eye)
{
    static const float color[KINDS][3] = { { 1, 1, 1 }, { 0, 0, 0 }, { 0.9f, 0.2f, 0.1f }, { 1, 1, 1 } };
    static const float metallic[KINDS] = { 1, 0, 1, 0 }, roughness[KINDS] = { 1, 0, 0.5f, 0 };
    memset(pixels, 0, PIXELS * sizeof *pixels);
    for (int i = 0; i < PIXELS; i++) {
        const double c = cosine_of(i % VIEWS), turn = 0.7 * i;
        glbk_pixel *p = &pixels[i];
        p->position[0] = eye[0] - (float)(sqrt(1 - c * c) * cos(turn));
        p->position[1] = eye[1] - (float)c;
        p->position[2] = eye[2] - (float)(sqrt(1 - c * c) * sin(turn));
        p->normal[1] = 1;
        p->material.kind = i / VIEWS < 3 ? LSAMP_MATERIAL_METAL_ROUGH : LSAMP_MATERIAL_LAMBERT;
        memcpy(p->material.diffuse, color[i / VIEWS], sizeof color[0]);
        p->material.metallic = metallic[i / VIEWS];
        p->material.roughness = roughness[i / VIEWS];
    }
}

/* Shades the pixels under a sky of 1, of which two bands see as much as any. */
static void shade(gl_test *t, answer *out)
{
    enum { BANDS = 2 };
    static const float eye[3] = { 3, 2, 1 }, white[3] = { 1, 1, 1 };
    static glbk_pixel pixels[PIXELS];
    float sky[3 * 64], *brdf = (float *)malloc(sfield_sh_brdf(BANDS, NULL, NULL) * sizeof(float));
    glbk_sfield_scene_desc scene_desc;
    glbk_sfield_renderer_desc renderer_desc;
    sfield_scene_desc cpu_desc;
    glbk_gbuffer_desc buffer_desc;
    glbk_sfield_scene scene;
    glbk_sfield_renderer renderer;
    glbk_gbuffer buffer;
    sfield_algebra *algebra;
    sfield_scene *cpu;
    memset(&scene_desc, 0, sizeof scene_desc);
    memset(&renderer_desc, 0, sizeof renderer_desc);
    memset(&cpu_desc, 0, sizeof cpu_desc);
    memset(&buffer_desc, 0, sizeof buffer_desc);
    cpu_desc.bands = BANDS;
    assert_int_equal(sfield_scene_create(&cpu_desc, &cpu), SFIELD_OK);
    assert_int_equal(sfield_scene_environment(cpu, white, 1, 1, NULL), SFIELD_OK);
    assert_int_equal(sfield_scene_sky(cpu, sky), SFIELD_OK);
    assert_int_equal(sfield_algebra_create(BANDS, NULL, &algebra), SFIELD_OK);
    assert_true(sfield_sh_brdf(BANDS, NULL, brdf) > 0);
    scene_desc.algebra = renderer_desc.algebra = algebra;
    scene_desc.entity_capacity = 1;
    scene_desc.brdf = brdf;
    renderer_desc.width = buffer_desc.width = VIEWS;
    renderer_desc.height = buffer_desc.height = KINDS;
    renderer_desc.materials = 1;
    assert_glbk(t, glbk_sfield_scene_create(&t->gl, &scene_desc, &scene));
    assert_glbk(t, glbk_sfield_scene_sky(&t->gl, &scene, sky));
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &buffer_desc, &buffer));
    assert_glbk(t, glbk_sfield_renderer_create(&t->gl, &renderer_desc, &renderer));
    fill(pixels, eye);
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, &buffer, 0, KINDS, pixels));
    assert_glbk(t, glbk_sfield_shade(&t->gl, &renderer, &buffer, &scene, eye, 0));
    assert_glbk(t, glbk_sfield_read(&t->gl, &renderer, out->light[0], out->gloss[0]));
    glbk_sfield_renderer_free(&t->gl, &renderer);
    glbk_gbuffer_free(&t->gl, &buffer);
    glbk_sfield_scene_free(&t->gl, &scene);
    sfield_algebra_free(algebra);
    sfield_scene_free(cpu);
    free(brdf);
}

/* Under a sky of 1: roughness 1 has the albedo 1 - v ln((1 + v) / v), a mirror Schlick's F, and all that is not diffuse
   of a metal is coloured by its F0 where the eye is along the normal. The diffuse row gets 1 and no gloss. */
static void albedos_are_closed_forms(void **state)
{
    GL_TEST(t, state)
    static answer a;
    double worst[2] = { 0, 0 }, plain = 0, color = 0;
    shade(t, &a);
    for (int i = 0; i < VIEWS; i++) {
        const double v = cosine_of(i), f = pow(1 - v, 5);
        const float *red = a.gloss[2 * VIEWS + i];
        plain = fmax(plain, fabs((double)a.light[3 * VIEWS + i][0] - 1));
        for (int k = 0; k < 3; k++) plain = fmax(plain, fabs((double)a.gloss[3 * VIEWS + i][k]));
        if (v > 0.97) color = fmax(color, fabs((double)red[1] / (double)red[0] - 0.2 / 0.9));
        if (v < 0.1) continue;                          /* between nodes of the table, 47 angles from 90 degrees on */
        worst[0] = fmax(worst[0], fabs((double)a.gloss[i][0] - (1 - v * log((1 + v) / v))));
        worst[1] = fmax(worst[1], fabs((double)a.gloss[VIEWS + i][1] - (0.04 + 0.96 * f)));
    }
    CONFORM_MAX("gloss", "GL: albedo of metal of roughness 1 beside 1 - v ln((1 + v) / v)", 0.002, worst[0]);
    CONFORM_MAX("gloss", "GL: a dielectric mirror beside Schlick's F", 0.005, worst[1]);
    CONFORM_MAX("gloss", "GL: a diffuse surface among them", 0.0001, plain);
    CONFORM_MAX("gloss", "GL: what a red metal mirrors, green by red", 0.005, color);
}

/* A ball of logarithms straight above hides 1 / d^2 of the cosine-weighted sky, as far as three bands see it; and a
   scene of other fields is refused. */
static void a_ball_of_logarithms_hides_its_share(void **state)
{
    GL_TEST(t, state)
    enum { BANDS = 3, COUNT = 8 };
    sfield_desc field_desc = small_desc(SFIELD_BASIS_SH);
    const sfield_field *fields[2];
    glbk_sfield_scene_desc scene_desc;
    glbk_sfield_renderer_desc d;
    glbk_gbuffer_desc buffer_desc;
    glbk_sfield_scene scene;
    glbk_sfield_renderer renderer;
    glbk_gbuffer buffer;
    glbk_pixel pixels[COUNT];
    sfield_algebra *algebra;
    sfield_entity ball;
    float light[COUNT][4];
    double worst = 0;
    memset(&scene_desc, 0, sizeof scene_desc);
    memset(&d, 0, sizeof d);
    memset(&buffer_desc, 0, sizeof buffer_desc);
    memset(pixels, 0, sizeof pixels);
    memset(&ball, 0, sizeof ball);
    field_desc.bands = BANDS;
    field_desc.cube_side = 32;
    field_desc.shell_count = 16;
    field_desc.inner = 1.1f;
    fields[1] = field_of_sphere(&field_desc);
    field_desc.logarithm = 1;
    fields[0] = field_of_sphere(&field_desc);
    assert_int_equal(sfield_algebra_create(BANDS, NULL, &algebra), SFIELD_OK);
    scene_desc.algebra = d.algebra = algebra;
    scene_desc.entity_capacity = 1;
    scene_desc.field_count = 1;
    scene_desc.fields = fields;
    d.width = buffer_desc.width = COUNT;
    d.height = buffer_desc.height = 1;
    d.logarithms = 1;
    for (int i = 0; i < COUNT; i++) {
        pixels[i].position[1] = -1.5f - 0.5f * (float)i;
        pixels[i].normal[1] = 1;
        pixels[i].material.kind = LSAMP_MATERIAL_LAMBERT;
    }
    ball.occlusion = fields[0];
    assert_glbk(t, glbk_sfield_scene_create(&t->gl, &scene_desc, &scene));
    assert_glbk(t, glbk_sfield_scene_entities(&t->gl, &scene, &ball, 1));
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &buffer_desc, &buffer));
    assert_glbk(t, glbk_sfield_renderer_create(&t->gl, &d, &renderer));
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, &buffer, 0, 1, pixels));
    assert_glbk(t, glbk_sfield_shade(&t->gl, &renderer, &buffer, &scene, NULL, 1));
    assert_glbk(t, glbk_sfield_read(&t->gl, &renderer, light[0], NULL));
    for (int i = 0; i < COUNT; i++) {
        const double distance = 1.5 + 0.5 * i, exactly = 1 - 1 / (distance * distance);
        printf("a ball %.1f r above: open %.4f, exactly %.4f\n", distance, (double)light[i][3], exactly);
        worst = fmax(worst, fabs((double)light[i][3] - exactly));
    }
    CONFORM_MAX("gloss", "GL: open share below a ball of logarithms", 0.05, worst);
    glbk_sfield_scene_free(&t->gl, &scene);
    scene_desc.field_count = 2;
    assert_int_equal(glbk_sfield_scene_create(&t->gl, &scene_desc, &scene), GLBK_ERR_MISMATCH);     /* both kinds */
    scene_desc.field_count = 1;
    scene_desc.fields = fields + 1;
    assert_glbk(t, glbk_sfield_scene_create(&t->gl, &scene_desc, &scene));
    assert_int_equal(glbk_sfield_shade(&t->gl, &renderer, &buffer, &scene, NULL, 1), GLBK_ERR_MISMATCH);
    glbk_sfield_scene_free(&t->gl, &scene);
    glbk_sfield_renderer_free(&t->gl, &renderer);
    glbk_gbuffer_free(&t->gl, &buffer);
    sfield_algebra_free(algebra);
    for (int i = 0; i < 2; i++) sfield_free((sfield_field *)(size_t)fields[i]);
}

/* A renderer of materials refuses a scene without BRDFs, and grazing is of materials alone. */
static void what_lacks_brdfs_is_refused(void **state)
{
    GL_TEST(t, state)
    static const float eye[3] = { 0, 1, 0 };
    glbk_sfield_scene_desc scene_desc;
    glbk_sfield_renderer_desc d;
    glbk_gbuffer_desc buffer_desc;
    glbk_sfield_scene scene;
    glbk_sfield_renderer renderer;
    glbk_gbuffer buffer;
    sfield_algebra *algebra;
    memset(&scene_desc, 0, sizeof scene_desc);
    memset(&d, 0, sizeof d);
    memset(&buffer_desc, 0, sizeof buffer_desc);
    assert_int_equal(sfield_algebra_create(2, NULL, &algebra), SFIELD_OK);
    scene_desc.algebra = d.algebra = algebra;
    scene_desc.entity_capacity = 1;
    d.width = d.height = buffer_desc.width = buffer_desc.height = 4;
    d.grazing = 1;
    assert_int_equal(glbk_sfield_renderer_create(&t->gl, &d, &renderer), GLBK_ERR_DESC);
    d.materials = 1;
    assert_glbk(t, glbk_sfield_renderer_create(&t->gl, &d, &renderer));
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &buffer_desc, &buffer));
    assert_glbk(t, glbk_sfield_scene_create(&t->gl, &scene_desc, &scene));
    assert_int_equal(glbk_sfield_shade(&t->gl, &renderer, &buffer, &scene, eye, 0), GLBK_ERR_MISMATCH);
    assert_int_equal(sfield_sh_brdf(0, NULL, NULL) + sfield_sh_brdf(9, NULL, NULL), 0);
    glbk_sfield_scene_free(&t->gl, &scene);
    glbk_gbuffer_free(&t->gl, &buffer);
    glbk_sfield_renderer_free(&t->gl, &renderer);
    sfield_algebra_free(algebra);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = { gl_unit_test(albedos_are_closed_forms),
                                  gl_unit_test(a_ball_of_logarithms_hides_its_share),
                                  gl_unit_test(what_lacks_brdfs_is_refused) };
    (void)count;
    if (gl_this_way() && gl_this_way()->bit != GL_CORE33) unsetenv("CONFORMANCE");     /* each row once */
    GL_TEST_MAIN(values, tests, GL_USUAL);
}
