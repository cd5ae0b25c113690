/* gl_shade_test - the renderer of gl_csm.h sample by sample against lsamp_sample: every shape of light, every
   BRDF, every way of sampling, patterns, progressive frames. Nothing is in the way here: csm/gl_twin_test asks about
   visibility. */
#define _POSIX_C_SOURCE 200809L
#include "csm.h"
#include "lightsampling.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend/gl_csm.h"

#define CONFORM_BACKEND "gl"
#include "conformance.h"
#include "gl_test.h"
#include "util.h"

enum { SIDE = 24, POINTS = SIDE * SIDE, SAMPLES = 48 };

static glbk_pixel pixels[POINTS];
static lsamp_material materials[POINTS];
static float positions[POINTS][3], normals[POINTS][3], tangents[POINTS][3], views[POINTS][3];
static float directions[POINTS * SAMPLES][3], distances[POINTS * SAMPLES], weights[POINTS * SAMPLES][3];
static float expected[POINTS][3], picture[POINTS][4];

static const float eye[3] = { 0.3f, 2.5f, 3.0f };
static const lsamp_lobe lobes[2] = { { { -1, -1, 0.95f }, 12, { 0.3f, 0.2f, 0.1f } },
                                     { { -0.6f, -0.9f, 0.3f }, 3, { 0.1f, 0.1f, 0.3f } } };

static void make_points(void)
{
    uint64_t seed = 3;
    uint32_t i, k;
    memset(pixels, 0, sizeof pixels);
    memset(materials, 0, sizeof materials);
    for (i = 0; i < POINTS; i++) {
        glbk_pixel *p = &pixels[i];
        lsamp_material *m = &materials[i];
        float length = 0;
        for (k = 0; k < 3; k++) positions[i][k] = (float)rnd_in(&seed, -1, 1);
        rnd_direction(&seed, normals[i]);
        rnd_direction(&seed, tangents[i]);
        if (normals[i][1] < 0)
            for (k = 0; k < 3; k++) normals[i][k] = -normals[i][k];
        for (k = 0; k < 3; k++) views[i][k] = eye[k] - positions[i][k];
        for (k = 0; k < 3; k++) length += views[i][k] * views[i][k];
        for (k = 0; k < 3; k++) views[i][k] /= sqrtf(length);
        m->kind = (lsamp_material_kind)(LSAMP_MATERIAL_LAMBERT + i % 4);
        /* the G-buffer keeps tangents of Lafortune materials only; one along the normal counts as none */
        if (m->kind != LSAMP_MATERIAL_LAFORTUNE) memcpy(tangents[i], normals[i], 12);
        for (k = 0; k < 3; k++) m->diffuse[k] = (float)rnd_in(&seed, 0.1, 0.6);
        for (k = 0; k < 3; k++) m->specular[k] = (float)rnd_in(&seed, 0.1, 0.4);
        m->exponent = (float)rnd_in(&seed, 0, 60);
        m->metallic = (float)rnd(&seed);
        m->roughness = (float)rnd_in(&seed, 0.2, 1);
        m->lobes = lobes;
        m->lobe_count = 2;
        memcpy(p->position, positions[i], 12);
        memcpy(p->normal, normals[i], 12);
        memcpy(p->tangent, tangents[i], 12);
        memcpy(p->geometric_normal, normals[i], 12);
        p->material = *m;
    }
}

/* ---- lights ---- */

static float texels[16 * 8 * 3];

static const float triangles[2][9] = { { -1, 3, 0, 1, 3, -1, 0.5f, 3, 1 }, { 1, 3, -1, -1, 3, 0, 0, 2.6f, -1.5f } };

/* x picks a triangle by area, as lib/cohsm_light.glsl does. */
static void mesh_point(void *user, float time, const float x[3], float position[3], float normal[3], float *area)
{
    double areas[2], n[2][3];
    int i, k;
    float root = sqrtf(x[1]), c = root * x[2];
    const float *t;
    (void)user;
    (void)time;
    for (i = 0; i < 2; i++) {
        double a[3], b[3];
        for (k = 0; k < 3; k++) {
            a[k] = (double)triangles[i][3 + k] - (double)triangles[i][k];
            b[k] = (double)triangles[i][6 + k] - (double)triangles[i][k];
        }
        for (k = 0; k < 3; k++) n[i][k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
        areas[i] = 0.5 * sqrt(n[i][0] * n[i][0] + n[i][1] * n[i][1] + n[i][2] * n[i][2]);
    }
    i = (double)x[0] >= areas[0] / (areas[0] + areas[1]);
    t = triangles[i];
    for (k = 0; k < 3; k++) {
        position[k] = t[k] * (1 - root) + t[3 + k] * (root * (1 - x[2])) + t[6 + k] * c;
        normal[k] = (float)(n[i][k] / (2 * areas[i]));
    }
    *area = (float)(areas[0] + areas[1]);
}

/* A bent strip of 4 x 3 points over the receivers, which emits downwards. */
static const float strip[4 * 3 * 3] = {
    -1, 2.4f, 1.2f,  -1, 2.7f, 0.7f,  -1, 2.2f, 0,  -1, 2.6f, -1,
    0, 2.2f, 1,  0, 2.3f, 0.6f,  0.1f, 2.9f, 0,  0, 2.1f, -1,
    0.9f, 2.6f, 1,  1, 2, 0.8f,  1.2f, 2.4f, 0,  1, 2.5f, -0.9f
};
static const lsamp_surface bent = { 4, 3, strip, 0 };

/* textured: 0 no, 1 constant within texels, 2 linear between their centres */
static lsamp_light_desc describe(lsamp_light_kind shape, int textured)
{
    static const float place[3] = { 0.2f, 2.2f, -0.4f }, down[3] = { 0.6f, -0.8f, 0 };
    lsamp_light_desc d;
    uint64_t seed = 7;
    int i;
    memset(&d, 0, sizeof d);
    d.kind = shape;
    memcpy(d.position, place, 12);
    memcpy(d.direction, down, 12);
    if (shape == LSAMP_LIGHT_SUN) d.direction[1] = 0.8f;
    if (shape == LSAMP_LIGHT_ENVIRONMENT) memset(d.position, 0, 12);
    d.u[0] = 0.9f;
    d.u[2] = 0.3f;
    d.v[0] = -0.2f;
    d.v[2] = 0.6f;
    d.radius = 0.5f;
    d.cone_half_angle = 0.7f;
    d.radiance[0] = 2;
    d.radiance[1] = 1.5f;
    d.radiance[2] = 1;
    if (shape != LSAMP_LIGHT_ENVIRONMENT && shape != LSAMP_LIGHT_CALLBACK) d.cosine_power = textured ? 2 : 0;
    d.rotation = shape == LSAMP_LIGHT_ENVIRONMENT ? 1 : 0;
    if (shape == LSAMP_LIGHT_CALLBACK) d.shape_fn = mesh_point;
    if (shape == LSAMP_LIGHT_SURFACE) d.surface = &bent;
    d.filter = textured == 2 ? LSAMP_TEXELS_LINEAR : LSAMP_TEXELS_NEAREST;
    for (i = 0; i < 16 * 8 * 3; i++) texels[i] = rnd(&seed) < 0.2 ? 0 : (float)rnd_in(&seed, 0, 4);
    texels[50] = -1;                        /* counts as 0 */
    if (textured && shape != LSAMP_LIGHT_SUN && shape != LSAMP_LIGHT_POINT && shape != LSAMP_LIGHT_SPOT &&
        shape != LSAMP_LIGHT_CALLBACK) {
        d.texels = texels;
        d.width = 16;
        d.height = shape == LSAMP_LIGHT_LINE ? 1 : 8;
    }
    return d;
}

/* The same light for GL, which has the two triangles as a mesh. */
static lsamp_light_desc describe_gl(const lsamp_light_desc *d)
{
    static const lsamp_mesh mesh = { triangles[0], 6, 0, NULL, 0, NULL };
    lsamp_light_desc g = *d;
    if (d->kind != LSAMP_LIGHT_CALLBACK) return g;
    g.kind = LSAMP_LIGHT_MESH;
    g.shape_fn = NULL;
    g.mesh = &mesh;
    return g;
}

/* ---- both renderers ---- */

static void shade_by_csm(const lsamp_light_desc *light, lsamp_sampling sampling, uint32_t frame,
                         const float *patterns)
{
    size_t size = lsamp_light_bytes(light);
    void *memory = malloc(size + 1);
    lsamp_light *emitter;
    lsamp_sample_desc desc;
    lsamp_points points;
    lsamp_samples out = { directions[0], distances, NULL, weights[0] };

    assert_int_equal(lsamp_light_init(light, memory, size, &emitter, NULL), LSAMP_OK);
    memset(&desc, 0, sizeof desc);
    memset(&points, 0, sizeof points);
    desc.sample_count = SAMPLES;
    desc.sampling = sampling;
    desc.seed = 21;
    desc.frame = frame;
    desc.patterns = patterns;
    points.count = POINTS;
    points.positions = positions[0];
    points.normals = normals[0];
    points.to_eye = views[0];
    points.tangents = tangents[0];
    points.materials = materials;
    points.material_stride = sizeof materials[0];
    assert_int_equal(lsamp_sample(&desc, emitter, &points, &out, NULL), LSAMP_OK);
    assert_int_equal(lsamp_accumulate(POINTS, SAMPLES, weights[0], NULL, expected[0], 0), LSAMP_OK);
    free(memory);
}

typedef struct rig { glbk_csm_renderer renderer; glbk_gbuffer seen; glbk_csm_maps maps; } rig;

static void open_rig(gl_test *t, int patterns, rig *r)
{
    const glbk_gbuffer_desc seen = { SIDE, SIDE, { 0, 0, 0, 0, NULL, NULL }, NULL };
    glbk_csm_renderer_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.width = desc.height = SIDE;
    desc.lobe_count = 2;
    desc.patterns = patterns;
    assert_glbk(t, glbk_csm_renderer_create(&t->gl, &desc, &r->renderer));
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &seen, &r->seen));
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, &r->seen, 0, SIDE, pixels));
    assert_glbk(t, glbk_csm_maps_create(&t->gl, NULL, 0, 1, NULL, &r->maps));
}

static void close_rig(gl_test *t, rig *r)
{
    glbk_csm_renderer_free(&t->gl, &r->renderer);
    glbk_gbuffer_free(&t->gl, &r->seen);
    glbk_csm_maps_free(&t->gl, &r->maps);
}

static glbk_csm_lights lights_of(gl_test *t, const lsamp_light_desc *descs, uint32_t count, const float *patterns,
                                 uint32_t *starts)
{
    glbk_csm_lights_desc all;
    glbk_csm_lights lights;

    memset(&all, 0, sizeof all);
    all.lights = descs;
    all.light_count = count;
    all.lobes = lobes;
    all.lobe_count = 2;
    all.patterns = patterns;
    all.pattern_length = patterns ? SAMPLES : 0;
    assert_glbk(t, glbk_csm_lights_create(&t->gl, &all, starts, &lights));
    return lights;
}

static glbk_csm_use use_of(const rig *r, uint32_t start, lsamp_light_kind shape)
{
    glbk_csm_use use;
    memset(&use, 0, sizeof use);
    use.start = start;
    use.kind = shape;
    use.maps = &r->maps;
    use.sample_count = SAMPLES;
    use.seed = 21;
    return use;
}

static glbk_csm_frame_desc frame_of(const glbk_csm_lights *lights, const glbk_csm_use *use)
{
    glbk_csm_frame_desc f;
    memset(&f, 0, sizeof f);
    f.lights = lights;
    f.uses = use;
    f.use_count = 1;
    memcpy(f.eye, eye, sizeof eye);
    f.frame = 5;
    f.samples_per_pass = 20;                /* more than one pass, the last one shorter */
    return f;
}

static void shade_by_gl(gl_test *t, rig *r, const lsamp_light_desc *light, lsamp_sampling sampling, uint32_t frame,
                        const float *patterns)
{
    lsamp_light_desc desc = describe_gl(light);
    uint32_t start;
    glbk_csm_lights lights = lights_of(t, &desc, 1, patterns, &start);
    glbk_csm_use use = use_of(r, start, desc.kind);
    glbk_csm_frame_desc f = frame_of(&lights, &use);
    f.sampling = sampling;
    f.frame = frame;
    assert_glbk(t, glbk_csm_render(&t->gl, &r->renderer, &r->seen, &f));
    assert_glbk(t, glbk_csm_read(&t->gl, &r->renderer, picture[0]));
    glbk_csm_lights_free(&t->gl, &lights);
}

/* A sample at the edge of a texel or a lobe may fall to the other side: a pixel then differs by a sample's weight. All
   others agree to what float pow and sums keep. */
static void expect_equal(const char *what, double frames)
{
    double sum[2] = { 0, 0 };
    size_t i, off = 0;
    int k;
    for (i = 0; i < POINTS; i++) {
        int wrong = 0;
        for (k = 0; k < 3; k++) {
            double a = (double)picture[i][k], b = (double)expected[i][k] / frames;
            if (!(fabs(a - b) <= 1e-3 * b + 1e-5)) wrong = 1;
            sum[0] += a;
            sum[1] += b;
        }
        off += (size_t)wrong;
    }
    if (!(off <= POINTS / 50) || !(fabs(sum[0] / sum[1] - 1) < 1e-3) || !(sum[1] > 1))
        fail_msg("%s: %zu of %d pixels differ, sums %g and %g", what, off, POINTS, sum[0], sum[1]);
}

static void lights_agree(gl_test *t, const lsamp_light_kind *shapes, int count)
{
    static const char *const names[] = { "both", "light", "brdf", "paper" };
    rig r;
    int i, textured, sampling;
    make_points();
    open_rig(t, 0, &r);
    for (i = 0; i < count; i++)
        for (textured = 0; textured < 3; textured++)
            for (sampling = 0; sampling < (textured == 2 ? 1 : 4); sampling++) {
                lsamp_light_desc d = describe(shapes[i], textured);
                char what[64];
                snprintf(what, sizeof what, "shape %d, textured %d, sampling %s", (int)shapes[i], textured,
                         names[sampling]);
                memset(expected, 0, sizeof expected);
                shade_by_csm(&d, (lsamp_sampling)sampling, 5, NULL);
                glbk_csm_reset(&r.renderer);
                shade_by_gl(t, &r, &d, (lsamp_sampling)sampling, 5, NULL);
                expect_equal(what, 1);
            }
    close_rig(t, &r);
}

static void each_light_agrees(void **state)
{
    GL_TEST(t, state)
    static const lsamp_light_kind all[] = { LSAMP_LIGHT_RECTANGLE, LSAMP_LIGHT_DISC, LSAMP_LIGHT_ENVIRONMENT,
                                            LSAMP_LIGHT_SUN, LSAMP_LIGHT_POINT, LSAMP_LIGHT_SPOT,
                                            LSAMP_LIGHT_SPHERE, LSAMP_LIGHT_LINE, LSAMP_LIGHT_CALLBACK,
                                            LSAMP_LIGHT_SURFACE };
    lights_agree(t, all, 10);
}

/* ---- lights by GLSL of the user's ---- */

/* A saddle over the receivers that emits downwards, own[0] high; its light depends on place and direction. */
static const char saddle_glsl[] =
    "void glbk_light_point(vec4 own, vec3 x, out vec3 position, out vec3 normal, out float area)\n"
    "{\n"
    "    position = vec3(2.0 * x.x - 1.0, 2.0 + own.x * x.x * x.y, 2.0 * x.y - 1.0);\n"
    "    normal = vec3(2.0 * own.x * x.y, -4.0, 2.0 * own.x * x.x);\n"
    "    area = length(normal);\n"
    "}\n"
    "vec3 glbk_light_emission(vec4 own, vec3 x, vec3 direction)\n"
    "{\n"
    "    return vec3(0.5 + x.x + x.z, own.y, max(-direction.y, 0.0) - 0.2);\n"
    "}\n";

static void saddle(void *user, float time, const float x[3], float position[3], float normal[3], float *area)
{
    const float *own = (const float *)user;
    (void)time;
    position[0] = 2 * x[0] - 1;
    position[1] = 2 + own[0] * x[0] * x[1];
    position[2] = 2 * x[1] - 1;
    normal[0] = 2 * own[0] * x[1];
    normal[1] = -4;
    normal[2] = 2 * own[0] * x[0];
    *area = sqrtf(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
}

static void saddle_shines(void *user, float time, const float x[3], const float direction[3], float rgb[3])
{
    const float *own = (const float *)user;
    (void)time;
    rgb[0] = 0.5f + x[0] + x[2];
    rgb[1] = own[1];
    rgb[2] = (direction[1] < 0 ? -direction[1] : 0) - 0.2f;
}

/* Shape and emission in GLSL give the samples that functions which compute the same give on the CPU; the shape can have
   texels, and other shapes can have the emission. */
static void lights_by_glsl_of_your_own_agree_with_functions(void **state)
{
    GL_TEST(t, state)
    static const lsamp_light_kind kinds[4] = { LSAMP_LIGHT_CALLBACK, LSAMP_LIGHT_RECTANGLE, LSAMP_LIGHT_ENVIRONMENT,
                                               LSAMP_LIGHT_SURFACE };
    const glbk_gbuffer_desc seen = { SIDE, SIDE, { 0, 0, 0, 0, NULL, NULL }, NULL };
    static float own[4] = { 0.7f, 1.5f, 0, 0 };
    glbk_csm_renderer_desc desc;
    glbk_csm_lights_desc all;
    glbk_csm_lights lights;
    glbk_csm_frame_desc f;
    glbk_csm_use use;
    rig r, plain;
    uint32_t start;
    int i, k;

    if (gl_this_way()->bit != GL_CORE33 && gl_this_way()->bit != GL_WEBGL2) return;
    make_points();
    memset(&desc, 0, sizeof desc);
    desc.width = desc.height = SIDE;
    desc.lobe_count = 2;
    desc.light = saddle_glsl;
    assert_glbk(t, glbk_csm_renderer_create(&t->gl, &desc, &r.renderer));
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &seen, &r.seen));
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, &r.seen, 0, SIDE, pixels));
    assert_glbk(t, glbk_csm_maps_create(&t->gl, NULL, 0, 1, NULL, &r.maps));
    memset(&all, 0, sizeof all);
    all.light_count = 1;
    all.lobes = lobes;
    all.lobe_count = 2;
    for (i = 0; i < 4; i++)
        for (k = 0; k < 2; k++) {
            lsamp_light_desc d = describe(kinds[i], 0);
            d.shape_fn = saddle;
            d.emission_fn = k || kinds[i] != LSAMP_LIGHT_CALLBACK ? saddle_shines : NULL;
            d.user = own;
            if (k && kinds[i] == LSAMP_LIGHT_CALLBACK) {
                d.texels = texels;
                d.width = 16;
                d.height = 8;
                d.filter = LSAMP_TEXELS_LINEAR;
            }
            own[0] = k ? 0.2f : 0.7f;
            memset(expected, 0, sizeof expected);
            shade_by_csm(&d, LSAMP_SAMPLING_DEFAULT, 5, NULL);
            all.lights = &d;
            all.own = 0;
            assert_int_equal(glbk_csm_lights_create(&t->gl, &all, &start, &lights), GLBK_ERR_DESC);
            all.own = 1;
            assert_glbk(t, glbk_csm_lights_create(&t->gl, &all, &start, &lights));
            glbk_csm_reset(&r.renderer);
            use = use_of(&r, start, kinds[i]);
            memcpy(use.own, own, sizeof own);
            f = frame_of(&lights, &use);
            assert_glbk(t, glbk_csm_render(&t->gl, &r.renderer, &r.seen, &f));
            assert_glbk(t, glbk_csm_read(&t->gl, &r.renderer, picture[0]));
            expect_equal(i == 0 ? "shape by GLSL" : "emission by GLSL", 1);
            if (i == 0 && k == 0) {             /* without the text there is nothing to draw them by */
                open_rig(t, 0, &plain);
                assert_int_equal(glbk_csm_render(&t->gl, &plain.renderer, &plain.seen, &f), GLBK_ERR_MISMATCH);
                close_rig(t, &plain);
            }
            glbk_csm_lights_free(&t->gl, &lights);
        }
    close_rig(t, &r);
    t->expected_errors = ~0u;                   /* drivers say that the text is no GLSL */
    desc.light = "void glbk_light_point() { nothing }\n";
    assert_glbk(t, glbk_csm_renderer_create(&t->gl, &desc, &r.renderer));
    all.own = 0;
    {
        lsamp_light_desc d = describe(LSAMP_LIGHT_SUN, 0);
        all.lights = &d;
        assert_glbk(t, glbk_csm_lights_create(&t->gl, &all, &start, &lights));
    }
    assert_glbk(t, glbk_csm_maps_create(&t->gl, NULL, 0, 1, NULL, &r.maps));
    use = use_of(&r, start, LSAMP_LIGHT_SUN);
    f = frame_of(&lights, &use);
    assert_int_equal(glbk_csm_prepare(&t->gl, &r.renderer, &f), GLBK_ERR_COMPILE);
    glbk_csm_lights_free(&t->gl, &lights);
    glbk_csm_maps_free(&t->gl, &r.maps);
    glbk_csm_renderer_free(&t->gl, &r.renderer);
}

/* ---- closed forms ---- */

/* A square above the point 0 0 0, own.x high, as GLSL; its emission goes by the square of the cosine, times own.y. */
static const char square_glsl[] =
    "void glbk_light_point(vec4 own, vec3 x, out vec3 position, out vec3 normal, out float area)\n"
    "{\n"
    "    position = vec3(x.x - 0.5, own.x, x.y - 0.5);\n"
    "    normal = vec3(0.0, -1.0, 0.0);\n"
    "    area = 1.0;\n"
    "}\n"
    "vec3 glbk_light_emission(vec4 own, vec3 x, vec3 direction) { return vec3(own.y * direction.y * direction.y); }\n";

/* L of 5 x 4 texels, linear between their centres. */
static double bilinear(const float *t, double x, double y)
{
    double fx = fmin(fmax(5 * x - 0.5, 0), 4), fy = fmin(fmax(4 * y - 0.5, 0), 3);
    int i = fx < 4 ? (int)fx : 3, j = fy < 3 ? (int)fy : 2;
    fx -= i;
    fy -= j;
    return ((double)t[3 * (5 * j + i)] * (1 - fx) + (double)t[3 * (5 * j + i + 1)] * fx) * (1 - fy) +
           ((double)t[3 * (5 * j + 5 + i)] * (1 - fx) + (double)t[3 * (5 * j + 6 + i)] * fx) * fy;
}

/* Irradiance of a unit square at a height, by 400 x 400 points: cosine at both ends over distance^2 is h^2 / r^4. */
static double under_a_square(double height, const float *t, int squared)
{
    double sum = 0;
    int i, j;
    for (j = 0; j < 400; j++)
        for (i = 0; i < 400; i++) {
            double x = (i + 0.5) / 400, y = (j + 0.5) / 400;
            double r2 = height * height + (x - 0.5) * (x - 0.5) + (y - 0.5) * (y - 0.5);
            sum += (t ? bilinear(t, x, y) : 1) * height * height / (r2 * r2) * (squared ? height * height / r2 : 1);
        }
    return sum / (400 * 400);
}

/* Every pixel of the picture is the same point; returns the mean irradiance of 16 frames, seen by Lambert's law. */
static double irradiance_by_gl(gl_test *t, rig *r, const lsamp_light_desc *light, const float *own)
{
    double sum = 0;
    glbk_csm_lights_desc all;
    glbk_csm_lights lights;
    glbk_csm_frame_desc f;
    glbk_csm_use use;
    uint32_t start, i;

    memset(&all, 0, sizeof all);
    all.lights = light;
    all.light_count = 1;
    all.own = 1;
    assert_glbk(t, glbk_csm_lights_create(&t->gl, &all, &start, &lights));
    use = use_of(r, start, light->kind);
    memcpy(use.own, own, sizeof use.own);
    f = frame_of(&lights, &use);
    glbk_csm_reset(&r->renderer);
    for (f.frame = 0; f.frame < 16; f.frame++) assert_glbk(t, glbk_csm_render(&t->gl, &r->renderer, &r->seen, &f));
    assert_glbk(t, glbk_csm_read(&t->gl, &r->renderer, picture[0]));
    for (i = 0; i < POINTS; i++) sum += (double)picture[i][0];
    glbk_csm_lights_free(&t->gl, &lights);
    return sum / POINTS * PI;
}

static void t43_surfaces_linear_texels_and_own_glsl_light_as_in_closed_form(void **state)
{
    GL_TEST(t, state)
    static const float corners[12] = { -0.5f, 1, -0.5f,  0.5f, 1, -0.5f,  -0.5f, 1, 0.5f,  0.5f, 1, 0.5f };
    static const float at_1[4] = { 1, 1, 0, 0 }, at_2[4] = { 2, 3, 0, 0 };
    static const lsamp_surface square = { 2, 2, corners, 0 };
    const glbk_gbuffer_desc seen = { SIDE, SIDE, { 0, 0, 0, 0, NULL, NULL }, NULL };
    glbk_csm_renderer_desc desc;
    lsamp_light_desc d;
    float stripes[3 * 5 * 4];
    uint32_t i;
    rig r;

    if (gl_this_way()->bit != GL_CORE33) return;
    memset(pixels, 0, sizeof pixels);
    for (i = 0; i < POINTS; i++) {
        pixels[i].normal[1] = pixels[i].geometric_normal[1] = 1;
        pixels[i].material.kind = LSAMP_MATERIAL_LAMBERT;
        pixels[i].material.diffuse[0] = pixels[i].material.diffuse[1] = pixels[i].material.diffuse[2] = 1;
    }
    for (i = 0; i < 3 * 5 * 4; i++) stripes[i] = i / 3 % 5 == 2 ? 10 : 0;
    memset(&desc, 0, sizeof desc);
    desc.width = desc.height = SIDE;
    desc.light = square_glsl;
    assert_glbk(t, glbk_csm_renderer_create(&t->gl, &desc, &r.renderer));
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &seen, &r.seen));
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, &r.seen, 0, SIDE, pixels));
    assert_glbk(t, glbk_csm_maps_create(&t->gl, NULL, 0, 1, NULL, &r.maps));

    /* 442,368 samples: their standard error is below 0.2 % of the sum wherever a sample counts at most ten times its
       mean, and numbers of (0, 2)-sequences do better */
    memset(&d, 0, sizeof d);
    d.kind = LSAMP_LIGHT_SURFACE;
    d.surface = &square;
    d.radiance[0] = d.radiance[1] = d.radiance[2] = 1;
    CONFORM("T43", "unit square 1 above, as a grid of 2 x 2 points", 0.7522747,
            irradiance_by_gl(t, &r, &d, at_1), 0.002);
    d.texels = stripes;
    d.width = 5;
    d.height = 4;
    d.filter = LSAMP_TEXELS_LINEAR;
    CONFORM("T43", "the same, a bright column of 5 of texels, linear between their centres",
            under_a_square(1, stripes, 0),
            irradiance_by_gl(t, &r, &d, at_1), 0.002 * under_a_square(1, stripes, 0));
    d.filter = LSAMP_TEXELS_NEAREST;        /* 0.6 % brighter, three times the tolerance */
    assert_true(irradiance_by_gl(t, &r, &d, at_1) > 1.004 * under_a_square(1, stripes, 0));
    memset(&d, 0, sizeof d);
    d.kind = LSAMP_LIGHT_CALLBACK;
    d.shape_fn = saddle;                    /* neither is called */
    d.radiance[0] = d.radiance[1] = d.radiance[2] = 1;
    CONFORM("T43", "unit square 1 above, by GLSL of the user's", 0.7522747,
            irradiance_by_gl(t, &r, &d, at_1), 0.002);
    CONFORM("T43", "the same, raised to 2 by a number of the frame", under_a_square(2, NULL, 0),
            irradiance_by_gl(t, &r, &d, at_2), 0.002 * under_a_square(2, NULL, 0));
    d.emission_fn = saddle_shines;
    CONFORM("T43", "unit square 1 above, by GLSL of the user's, emission cos^2", under_a_square(1, NULL, 1),
            irradiance_by_gl(t, &r, &d, at_1), 0.002);
    CONFORM("T43", "the same, raised to 2, three times as bright", 3 * under_a_square(2, NULL, 1),
            irradiance_by_gl(t, &r, &d, at_2), 0.002 * 3 * under_a_square(2, NULL, 1));
    close_rig(t, &r);
}

/* Frames add up; patterns shift after the 256th; a reset begins anew. */
static void frames_and_patterns_agree(void **state)
{
    GL_TEST(t, state)
    size_t size = lsamp_patterns_bytes(SAMPLES);
    float *patterns = malloc(size);
    lsamp_light_desc d = describe(LSAMP_LIGHT_SUN, 0);
    rig r;
    int i, round;
    if (gl_this_way()->bit == GL_CORE33) d = describe(LSAMP_LIGHT_RECTANGLE, 1);    /* compiled there anyway */
    assert_non_null(patterns);
    assert_int_equal(lsamp_patterns_build(SAMPLES, 4, patterns, size), LSAMP_OK);
    make_points();
    open_rig(t, 1, &r);
    for (round = 0; round < 2; round++) {
        memset(expected, 0, sizeof expected);
        glbk_csm_reset(&r.renderer);
        for (i = 0; i < 3; i++) {
            uint32_t frame = (uint32_t)(253 + 2 * i);
            shade_by_csm(&d, LSAMP_SAMPLING_DEFAULT, frame, patterns);
            shade_by_gl(t, &r, &d, LSAMP_SAMPLING_DEFAULT, frame, patterns);
        }
        expect_equal(round ? "frames after a reset" : "frames", 3);
    }
    close_rig(t, &r);
    free(patterns);
}

/* ---- tables of lights ---- */

static const lsamp_light_kind every_shape[] = { LSAMP_LIGHT_ENVIRONMENT, LSAMP_LIGHT_SUN,    LSAMP_LIGHT_POINT,
                                           LSAMP_LIGHT_SPOT,        LSAMP_LIGHT_LINE,   LSAMP_LIGHT_RECTANGLE,
                                           LSAMP_LIGHT_DISC,        LSAMP_LIGHT_SPHERE, LSAMP_LIGHT_CALLBACK };
enum { SHAPES = 9, HEAD = 10, CELLS = 16 * 8 };

static float word(const uint32_t *words, int texel, int component)
{
    float f;
    memcpy(&f, words + 4 * texel + component, 4);
    return f;
}

/* docs/gpu-layouts.md: ten texels, then 2 w h + h of L, or three a triangle; the area is in 5.w. */
static void lights_take_their_texels(void **state)
{
    static const size_t plain[SHAPES] = { HEAD + 3, HEAD, HEAD, HEAD, HEAD, HEAD, HEAD, HEAD, HEAD + 6 };
    static const size_t textured[SHAPES] = {
        HEAD + 2 * CELLS + 8, HEAD,    HEAD, HEAD, HEAD + 2 * 16 + 1, HEAD + 2 * CELLS + 8, HEAD + 2 * CELLS + 8,
        HEAD + 2 * CELLS + 8, HEAD + 6
    };
    /* |u x v| = |(0.9, 0, 0.3) x (-0.2, 0, 0.6)|; the triangles: 3.5 / 2 and sqrt(4.8) / 2 */
    static const double areas[SHAPES] = {
        1, 1, 1, 1, 1, 0.6, 3.14159265358979 * 0.25, 3.14159265358979, 1.75 + 1.0954451
    };
    static uint32_t words[4 * (HEAD + 2 * CELLS + 8) + 4];
    int i, t;
    (void)state;
    for (i = 0; i < SHAPES; i++)
        for (t = 0; t < 2; t++) {
            lsamp_light_desc d = describe(every_shape[i], t);
            lsamp_light_desc g = describe_gl(&d);
            size_t count = glbk_csm_light_texels(&g), k, same = 0;
            assert_int_equal(count, (t ? textured : plain)[i]);
            memset(words, 0xa5, sizeof words);
            assert_int_equal(glbk_csm_light_write(&g, words), GLBK_OK);
            for (k = 0; k < 4 * count; k++) same += words[k] == 0xa5a5a5a5u;
            assert_int_equal(same, 0);                          /* all of them, and no more */
            assert_true(words[4 * count] == 0xa5a5a5a5u);
            assert_int_equal(words[0], g.kind);
            assert_int_equal(words[1], d.texels ? 16 : 1);
            assert_int_equal(words[4], HEAD);
            assert_true(word(words, 2, 1) == g.position[1] && word(words, 6, 2) == g.radiance[2]);
            if (!(fabs((double)word(words, 5, 3) / areas[i] - 1) < 1e-6))
                fail_msg("shape %d: area %.9g", i, (double)word(words, 5, 3));
            if (d.texels) {     /* sums of the last row run from 0 to 1; the texel that is negative is black */
                int row = HEAD + (int)(d.width * d.height + d.height + d.width * (d.height - 1));
                assert_true(word(words, row, 0) == 0 && word(words, row + 15, 1) == 1);
                for (k = 1; k < 16; k++) assert_true(word(words, row + (int)k, 0) == word(words, row + (int)k - 1, 1));
                assert_true(d.height == 1 || word(words, HEAD + 16, 2) == 0);
                assert_true(word(words, HEAD, 0) == texels[0]);
            }
        }
}

static void shine(void *user, float time, const float x[3], const float direction[3], float rgb[3])
{
    (void)user, (void)time, (void)x, (void)direction;
    rgb[0] = rgb[1] = rgb[2] = 1;
}

static void bad_lights_are_refused(void **state)
{
    static uint32_t words[4 * (HEAD + 6)];
    static const float flat[9] = { 0 };
    int i, way;
    (void)state;
    assert_int_equal(glbk_csm_light_texels(NULL), 0);
    assert_int_equal(glbk_csm_light_write(NULL, words), GLBK_ERR_ARGUMENT);
    for (i = 0; i < SHAPES; i++)
        for (way = 0; way < 23; way++) {
            lsamp_light_desc d = describe(every_shape[i], 0);
            lsamp_light_desc g = describe_gl(&d);
            lsamp_light_kind s = every_shape[i];
            lsamp_mesh none = { NULL, 3, 0, NULL, 0, NULL }, plane = { flat, 3, 0, NULL, 0, NULL };
            const lsamp_surface empty = { 4, 3, NULL, 0 }, thin = { 4, 1, strip, 0 };
            const int textured = s == LSAMP_LIGHT_ENVIRONMENT || s == LSAMP_LIGHT_RECTANGLE || s == LSAMP_LIGHT_DISC ||
                                 s == LSAMP_LIGHT_SPHERE;
            glbk_result code = GLBK_ERR_DESC;
            int refused = 1;
            if (way == 0) g.kind = LSAMP_LIGHT_COUNT;
            if (way == 1) g.radiance[1] = -1;
            if (way == 2) g.radiance[2] = (float)NAN;
            if (way == 3) g.position[0] = 1e30f;
            if (way == 4) g.rotation = (float)INFINITY;
            if (way == 5) g.cosine_power = -1;
            if (way == 6) g.width = 4;                          /* without texels */
            if (way == 7) g.texels = texels;                    /* without a size */
            if (way == 8) g.texels = texels, g.width = 2, g.height = 65537;
            if (way == 9) g.texels = texels, g.width = g.height = 65536;        /* not read: too many */
            if (way == 9 && textured) code = GLBK_ERR_LIMIT;    /* others have no texels, or one row */
            if (way == 10)
                g.direction[0] = 0, refused = s == LSAMP_LIGHT_SUN || s == LSAMP_LIGHT_SPOT || s == LSAMP_LIGHT_DISC;
            if (way == 11)
                g.radius = 0, refused = s == LSAMP_LIGHT_LINE || s == LSAMP_LIGHT_DISC || s == LSAMP_LIGHT_SPHERE;
            if (way == 12) g.cone_half_angle = 0, refused = s == LSAMP_LIGHT_SPOT;
            if (way == 13) memset(g.u, 0, 12), refused = s == LSAMP_LIGHT_LINE || s == LSAMP_LIGHT_RECTANGLE;
            if (way == 14) g.mesh = &none, refused = s == LSAMP_LIGHT_CALLBACK;
            if (way == 16)                                      /* your shader's, where a light has an area */
                g.emission_fn = shine,
                refused = s == LSAMP_LIGHT_SUN || s == LSAMP_LIGHT_SPOT || s == LSAMP_LIGHT_POINT;
            if (way == 17) g.kind = LSAMP_LIGHT_CALLBACK, g.shape_fn = mesh_point, refused = 0;
            if (way == 18) g.frame_count = 2;                         /* without texels */
            if (way == 19) g.filter = LSAMP_TEXELS_COUNT;
            if (way >= 20) g.kind = LSAMP_LIGHT_SURFACE, g.cosine_power = 0;
            if (way == 20) g.surface = NULL;
            if (way == 21) g.surface = &empty;
            if (way == 22) g.surface = &thin;
            if (way == 15) g.cosine_power = 2, refused = s == LSAMP_LIGHT_ENVIRONMENT;
            if ((glbk_csm_light_texels(&g) == 0) != refused) fail_msg("shape %d, way %d", i, way);
            if (way == 14) code = GLBK_ERR_ARGUMENT;            /* a mesh without positions */
            if (refused) assert_int_equal(glbk_csm_light_write(&g, words), code);
            if (!refused) assert_int_equal(glbk_csm_light_write(&g, NULL), GLBK_ERR_ARGUMENT);
            if (!refused && s == LSAMP_LIGHT_CALLBACK && way != 17) {       /* without area: texels, but no light */
                g.mesh = &plane;
                assert_int_equal(glbk_csm_light_write(&g, words), GLBK_ERR_INPUT);
            }
        }
}

static void render_one(gl_test *t, rig *r, const glbk_csm_lights *lights, uint32_t start, lsamp_light_kind shape,
                       float *out)
{
    glbk_csm_use use = use_of(r, start, shape);
    glbk_csm_frame_desc f = frame_of(lights, &use);
    glbk_csm_reset(&r->renderer);
    assert_glbk(t, glbk_csm_render(&t->gl, &r->renderer, &r->seen, &f));
    assert_glbk(t, glbk_csm_read(&t->gl, &r->renderer, out));
}

/* A light that changed gives the picture of a table made anew, bit by bit; its neighbours stay. */
static void updated_lights_are_new_lights(void **state)
{
    GL_TEST(t, state)
    static float fresh[POINTS][4], kept[POINTS][4];
    static const float flat[9] = { 0 };
    static const lsamp_mesh plane = { flat, 3, 0, NULL, 0, NULL };
    lsamp_light_kind shape = gl_this_way()->bit == GL_CORE33 ? LSAMP_LIGHT_RECTANGLE : gl_this_way()->bit == GL_CORE45 ?
                        LSAMP_LIGHT_SPHERE : LSAMP_LIGHT_POINT;      /* compiled there anyway */
    lsamp_light_desc d = describe(shape, 1);
    lsamp_light_desc three[3], changed, bad;
    float other[16 * 8 * 3];
    uint32_t starts[3], i;
    glbk_csm_lights lights, anew;
    rig r;
    make_points();
    open_rig(t, 0, &r);
    for (i = 0; i < 3; i++) {
        three[i] = describe_gl(&d);
        three[i].position[0] += 0.3f * (float)i;
    }
    changed = three[1];
    changed.position[1] = 1.7f;
    changed.radiance[0] = 5;
    changed.radius = 0.3f;
    if (changed.texels) {
        for (i = 0; i < 16 * 8 * 3; i++) other[i] = (float)(i % 5);
        changed.texels = other;
    }
    lights = lights_of(t, three, 3, NULL, starts);
    render_one(t, &r, &lights, starts[1], three[1].kind, fresh[0]);
    render_one(t, &r, &lights, starts[2], three[2].kind, kept[0]);
    assert_glbk(t, glbk_csm_lights_update(&t->gl, &lights, starts[1], &changed));
    render_one(t, &r, &lights, starts[1], changed.kind, picture[0]);
    assert_memory_not_equal(fresh, picture, sizeof picture);
    three[1] = changed;
    anew = lights_of(t, three, 3, NULL, starts);
    render_one(t, &r, &anew, starts[1], changed.kind, fresh[0]);
    assert_memory_equal(fresh, picture, sizeof picture);
    for (i = 0; i < 2; i++) {           /* now with refusals between: nothing changes */
        render_one(t, &r, &lights, starts[2], three[2].kind, picture[0]);
        assert_memory_equal(kept, picture, sizeof picture);
        bad = changed;
        assert_int_equal(glbk_csm_lights_update(NULL, &lights, starts[1], &bad), GLBK_ERR_ARGUMENT);
        assert_int_equal(glbk_csm_lights_update(&t->gl, NULL, starts[1], &bad), GLBK_ERR_ARGUMENT);
        assert_int_equal(glbk_csm_lights_update(&t->gl, &lights, starts[1], NULL), GLBK_ERR_ARGUMENT);
        assert_int_equal(glbk_csm_lights_update(&t->gl, &lights, 3, &bad), GLBK_ERR_ARGUMENT);   /* a lobe's place */
        assert_int_equal(glbk_csm_lights_update(&t->gl, &lights, starts[2] + 1, &bad),
                         GLBK_ERR_ARGUMENT); /* too long */
        bad.radiance[0] = -1;
        assert_int_equal(glbk_csm_lights_update(&t->gl, &lights, starts[1], &bad), GLBK_ERR_DESC);
        bad = changed;
        bad.kind = LSAMP_LIGHT_MESH;
        bad.texels = NULL;
        bad.width = bad.height = 0;
        bad.mesh = &plane;
        assert_int_equal(glbk_csm_lights_update(&t->gl, &lights, starts[0], &bad), GLBK_ERR_INPUT);
    }
    glbk_csm_lights_free(&t->gl, &lights);
    assert_int_equal(glbk_csm_lights_update(&t->gl, &lights, starts[1], &changed), GLBK_ERR_ARGUMENT);
    glbk_csm_lights_free(&t->gl, &anew);
    close_rig(t, &r);
}

/* glbk_csm_prepare refuses what glbk_csm_render refuses, and compiles what it would; the picture stays the same. */
static void prepared_frames_are_the_same(void **state)
{
    GL_TEST(t, state)
    static float fresh[POINTS][4];
    lsamp_light_desc d = describe(LSAMP_LIGHT_POINT, 0);
    lsamp_light_desc desc = describe_gl(&d);
    uint32_t start;
    glbk_csm_lights lights = lights_of(t, &desc, 1, NULL, &start), none;
    rig r, other;
    glbk_csm_use use;
    glbk_csm_frame_desc f;
    int way;
    make_points();
    open_rig(t, 0, &r);
    memset(&none, 0, sizeof none);
    for (way = 0; way < 9; way++) {
        use = use_of(&r, start, desc.kind);
        f = frame_of(&lights, &use);
        if (way == 0) f.lights = &none;
        if (way == 1) f.lights = NULL;
        if (way == 2) f.uses = NULL;
        if (way == 3) f.plane_count = GLBK_CSM_MAX_PLANES + 1;
        if (way == 4) f.filter = COHSM_FILTER_COUNT;
        if (way == 5) f.bias = (float)NAN;
        if (way == 6) use.maps = NULL;
        if (way == 7) use.sample_count = 65537;
        if (way == 8) use.kind = LSAMP_LIGHT_COUNT;
        assert_int_equal(glbk_csm_prepare(&t->gl, &r.renderer, &f), GLBK_ERR_DESC);
        assert_int_equal(glbk_csm_render(&t->gl, &r.renderer, &r.seen, &f), GLBK_ERR_DESC);
        assert_int_equal(r.renderer.shade.count + r.renderer.frame_count, 0);
    }
    use = use_of(&r, start, desc.kind);
    f = frame_of(&lights, &use);
    assert_int_equal(glbk_csm_prepare(&t->gl, NULL, &f), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_csm_prepare(NULL, &r.renderer, &f), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_csm_prepare(&t->gl, &r.renderer, NULL), GLBK_ERR_ARGUMENT);

    assert_glbk(t, glbk_csm_prepare(&t->gl, &r.renderer, &f));
    assert_int_equal(r.renderer.shade.count, 1);
    assert_int_equal(r.renderer.frame_count, 0);
    assert_int_equal(glbk_csm_read(&t->gl, &r.renderer, picture[0]), GLBK_ERR_ORDER);     /* nothing was drawn */
    assert_glbk(t, glbk_csm_render(&t->gl, &r.renderer, &r.seen, &f));
    assert_int_equal(r.renderer.shade.count, 1);                /* the program was there */
    assert_glbk(t, glbk_csm_read(&t->gl, &r.renderer, picture[0]));
    open_rig(t, 0, &other);
    render_one(t, &other, &lights, start, desc.kind, fresh[0]);
    assert_memory_equal(fresh, picture, sizeof picture);

    glbk_csm_lights_free(&t->gl, &lights);
    close_rig(t, &r);
    close_rig(t, &other);
}

/* A plane is no mesh whose normals a shader would make unit: the frame says it, and any other length is refused. */
static void planes_of_a_frame_are_unit(void **state)
{
    GL_TEST(t, state)
    static const struct { float z, distance; const char *log; } planes[] = {
        { 0.97f, -1, NULL },
        { 1.03f, 0, NULL },
        { 0.96f, 0, "glbk_csm_prepare: desc.planes[1]'s normal: its length is 0.96; it must be 0.97..1.03" },
        { -1.04f, 0, "glbk_csm_prepare: desc.planes[1]'s normal: its length is 1.04; it must be 0.97..1.03" },
        { 0, 0, "glbk_csm_prepare: desc.planes[1]'s normal: its length is 0; it must be 0.97..1.03" },
        { (float)NAN, 0, "glbk_csm_prepare: desc.planes[1]'s normal: its length is not a number; it must be "
                         "0.97..1.03" },
        { 1, (float)INFINITY, "glbk_csm_prepare: desc.planes[1][3] is infinity; it must be finite" },
    };
    lsamp_light_desc d = describe(LSAMP_LIGHT_POINT, 0);
    lsamp_light_desc desc = describe_gl(&d);
    uint32_t start, i;
    glbk_csm_lights lights = lights_of(t, &desc, 1, NULL, &start);
    rig r;
    make_points();
    open_rig(t, 0, &r);
    for (i = 0; i < sizeof planes / sizeof *planes; i++) {
        glbk_csm_use use = use_of(&r, start, desc.kind);
        glbk_csm_frame_desc f = frame_of(&lights, &use);
        f.plane_count = 2;
        f.planes[0][1] = 1;
        f.planes[1][2] = planes[i].z;
        f.planes[1][3] = planes[i].distance;
        t->log[0] = 0;
        assert_int_equal(glbk_csm_prepare(&t->gl, &r.renderer, &f), planes[i].log ? GLBK_ERR_DESC : GLBK_OK);
        if (planes[i].log) assert_string_equal(t->log, planes[i].log);
        f.plane_count = 1;                                      /* the others are not read */
        assert_glbk(t, glbk_csm_prepare(&t->gl, &r.renderer, &f));
    }
    glbk_csm_lights_free(&t->gl, &lights);
    close_rig(t, &r);
}

/* An error of the first light is not lost with the second: such a frame does not count. */
static void errors_of_any_light_are_told(void **state)
{
    GL_TEST(t, state)
    lsamp_light_desc d = describe(LSAMP_LIGHT_POINT, 0);
    lsamp_light_desc two[2];
    uint32_t starts[2];
    glbk_csm_lights lights;
    glbk_csm_use uses[2];
    glbk_csm_frame_desc f;
    rig r;
    make_points();
    open_rig(t, 0, &r);
    two[0] = two[1] = describe_gl(&d);
    lights = lights_of(t, two, 2, NULL, starts);
    uses[0] = use_of(&r, starts[0], two[0].kind);
    uses[1] = use_of(&r, starts[1], two[1].kind);
    f = frame_of(&lights, uses);
    f.use_count = 2;
    assert_glbk(t, glbk_csm_render(&t->gl, &r.renderer, &r.seen, &f));
    t->expected_errors = ~0u;
    t->gl.check = 1;
    t->gl.gl.Enable(0xffff);
    assert_int_equal(glbk_csm_render(&t->gl, &r.renderer, &r.seen, &f), GLBK_ERR_PENDING);
    assert_int_equal(r.renderer.frame_count, 1);
    assert_glbk(t, glbk_csm_render(&t->gl, &r.renderer, &r.seen, &f));
    assert_int_equal(r.renderer.frame_count, 2);
    glbk_csm_lights_free(&t->gl, &lights);
    close_rig(t, &r);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = { gl_unit_test(each_light_agrees),
                                  gl_unit_test(lights_by_glsl_of_your_own_agree_with_functions),
                                  gl_unit_test(t43_surfaces_linear_texels_and_own_glsl_light_as_in_closed_form),
                                  gl_unit_test(frames_and_patterns_agree),
                                  cmocka_unit_test(lights_take_their_texels), cmocka_unit_test(bad_lights_are_refused),
                                  gl_unit_test(updated_lights_are_new_lights),
                                  gl_unit_test(prepared_frames_are_the_same),
                                  gl_unit_test(planes_of_a_frame_are_unit),
                                  gl_unit_test(errors_of_any_light_are_told) };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_USUAL);
}
