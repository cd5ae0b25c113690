/* errors_test - every refusal of lightsampling.h that a log can hear: the result, nothing written, and one line that
   names function, field, value and range. */

#include "lightsampling.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

static int lines;
static char last[300];
static uint64_t memory[8192];
static float texels[3 * 16];
static float corners[12] = { 0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 1 };
static uint32_t wide[6] = { 0, 1, 2, 0, 2, 3 };
static uint16_t narrow[6] = { 0, 1, 2, 0, 2, 3 };

static void keep(void *user, const char *message)
{
    assert_ptr_equal(user, &lines);
    assert_null(strchr(message, '\n'));
    assert_true(strlen(message) < sizeof last);
    lines++;
    strcpy(last, message);
}

static void said(lsamp_result result, lsamp_result expected, const char *text)
{
    assert_int_equal(result, expected);
    assert_string_equal(last, text);
    assert_int_equal(lines, 1);
    lines = 0;
    last[0] = 0;
}

static lsamp_light_desc light_of(lsamp_light_kind kind)
{
    lsamp_light_desc d;
    memset(&d, 0, sizeof d);
    d.kind = kind;
    d.radiance[0] = d.radiance[1] = d.radiance[2] = 1;
    d.direction[1] = -1;
    d.u[0] = d.v[2] = 1;
    d.radius = d.cone_half_angle = 0.5f;
    d.system.log = keep;
    d.system.user = &lines;
    return d;
}

/* The light is refused so, and lsamp_light_bytes says 0 without a word. */
static void refuses_so(const lsamp_light_desc *d, lsamp_result expected, const char *text)
{
    lsamp_light *light = NULL;
    uint64_t bad = 9;
    assert_int_equal(lsamp_light_bytes(d), 0);
    assert_int_equal(lines, 0);
    said(lsamp_light_init(d, memory, sizeof memory, &light, &bad), expected, text);
    assert_null(light);
    assert_int_equal(bad, 9);
}

static void refuses(const lsamp_light_desc *d, const char *text) { refuses_so(d, LSAMP_ERR_DESC, text); }

#define REFUSES(of, change, text)               \
    do {                                        \
        lsamp_light_desc d = light_of(of);      \
        change;                                 \
        refuses(&d, "lsamp_light_init: " text); \
    } while (0)

static void emission(void *user, float time, const float x[3], const float direction[3], float rgb[3])
{
    (void)user;
    (void)time;
    (void)x;
    (void)direction;
    rgb[0] = rgb[1] = rgb[2] = 1;
}

static void a_field_of_any_light_is_named(void **state)
{
    (void)state;
    REFUSES(LSAMP_LIGHT_COUNT, (void)0, "desc.kind is 12; it must be a LSAMP_LIGHT_...");
    REFUSES(LSAMP_LIGHT_SUN, d.radiance[2] = -1, "desc.radiance is -1; it must be 0..1e30");
    REFUSES(LSAMP_LIGHT_SUN, d.radiance[2] = 1.1e30f, "desc.radiance is 1.1e30; it must be 0..1e30");
    REFUSES(LSAMP_LIGHT_SUN, d.time = 2e9f, "desc.time is 2000000000; it must be -1e9..1e9");
    REFUSES(LSAMP_LIGHT_DISC, d.cosine_power = -0.5f, "desc.cosine_power is -0.5; it must be 0..100000");
    REFUSES(LSAMP_LIGHT_DISC, d.rotation = 1001, "desc.rotation is 1001; it must be -1000..1000");
    REFUSES(LSAMP_LIGHT_DISC, d.frames_per_second = -1, "desc.frames_per_second is -1; it must be 0..1000000");
    REFUSES(LSAMP_LIGHT_DISC, d.width = 4, "desc.width is 4; it must be 0 without texels");
    REFUSES(LSAMP_LIGHT_DISC, d.height = 4, "desc.height is 4; it must be 0 without texels");
    REFUSES(LSAMP_LIGHT_DISC, d.frame_count = 2, "desc.frame_count is 2; it must be 0 or 1 without texels");
    REFUSES(LSAMP_LIGHT_DISC, d.texels = texels, "desc.width is 0; it must be 1..65536 with texels");
    REFUSES(LSAMP_LIGHT_DISC, d.texels = texels; d.width = 4, "desc.height is 0; it must be 1..65536 with texels");
    REFUSES(LSAMP_LIGHT_DISC, d.texels = texels; d.width = d.height = 4; d.frame_count = 1u << 25,
            "desc.frame_count is 33554432; it must be 0 or 1..2^24");
    REFUSES(LSAMP_LIGHT_LINE, d.texels = texels; d.width = d.height = 4, "desc.height is 4; it must be 1 for a line");
    REFUSES(LSAMP_LIGHT_POINT, d.position[1] = 1e19f, "desc.position is 1e19; it must be -1e18..1e18");
}

static void a_field_of_one_kind_of_light_is_named(void **state)
{
    (void)state;
    REFUSES(LSAMP_LIGHT_ENVIRONMENT, d.cosine_power = 2, "desc.cosine_power is 2; it must be 0 for an environment");
    REFUSES(LSAMP_LIGHT_SUN, d.direction[1] = 0.5f, "the length of desc.direction is 0.5; it must be 1 (0.97..1.03)");
    REFUSES(LSAMP_LIGHT_SPOT, d.direction[1] = 0, "the length of desc.direction is 0; it must be 1 (0.97..1.03)");
    REFUSES(LSAMP_LIGHT_SPOT, d.cone_half_angle = 2, "desc.cone_half_angle is 2; it must be 5e-7..pi / 2");
    REFUSES(LSAMP_LIGHT_POINT, d.texels = texels; d.width = d.height = 4,
            "desc.texels is set: sun, point and spot have none");
    REFUSES(LSAMP_LIGHT_SUN, d.emission_fn = emission, "desc.emission_fn is set: sun, point and spot have none");
    REFUSES(LSAMP_LIGHT_LINE, d.u[0] = 0, "desc.u has no length");
    REFUSES(LSAMP_LIGHT_LINE, d.u[1] = 2e18f, "desc.u is 2e18; it must be -1e18..1e18");
    REFUSES(LSAMP_LIGHT_LINE, d.radius = 0, "desc.radius is 0; it must be 1e-18..1e18");
    REFUSES(LSAMP_LIGHT_RECTANGLE, d.v[0] = 1; d.v[2] = 0, "desc.u and desc.v span no area");
    REFUSES(LSAMP_LIGHT_RECTANGLE, d.v[0] = -2e18f, "desc.v is -2e18; it must be -1e18..1e18");
    REFUSES(LSAMP_LIGHT_DISC, d.direction[0] = 1, "the length of desc.direction is 1.41421; it must be 1 (0.97..1.03)");
    REFUSES(LSAMP_LIGHT_SPHERE, d.radius = -1, "desc.radius is -1; it must be 1e-18..1e18");
    REFUSES(LSAMP_LIGHT_CALLBACK, (void)0, "desc.shape_fn is NULL");
}

static void a_surface_and_a_filter_are_named(void **state)
{
    static const float points[12] = { 0 };
    lsamp_surface s = { 2, 2, points, 0 };
    (void)state;
    REFUSES(LSAMP_LIGHT_SUN, d.filter = LSAMP_TEXELS_COUNT, "desc.filter is 2; it must be a LSAMP_TEXELS_...");
    REFUSES(LSAMP_LIGHT_SURFACE, (void)0, "desc.surface is NULL");
    s.points = NULL;
    REFUSES(LSAMP_LIGHT_SURFACE, d.surface = &s, "desc.surface->points is NULL");
    s.points = points;
    s.width = 1;
    REFUSES(LSAMP_LIGHT_SURFACE, d.surface = &s, "desc.surface->width is 1; it must be 2..4096");
    s.width = 2;
    s.height = 4097;
    REFUSES(LSAMP_LIGHT_SURFACE, d.surface = &s, "desc.surface->height is 4097; it must be 2..4096");
}

static void a_mesh_that_cannot_shine_says_why(void **state)
{
    lsamp_mesh m, good;
    lsamp_light *light = NULL;
    lsamp_light_desc d = light_of(LSAMP_LIGHT_MESH);
    (void)state;
    memset(&good, 0, sizeof good);
    good.positions = corners;
    good.vertex_count = 4;
    good.indices = wide;
    good.index_count = 6;
    refuses(&d, "lsamp_light_init: desc.mesh is NULL");
    d.mesh = &m;
#define MESH(change, result, text)                                      \
    do {                                                                \
        m = good;                                                       \
        change;                                                         \
        refuses_so(&d, result, "lsamp_light_init: desc.mesh" text);     \
    } while (0)
    MESH(m.positions = NULL, LSAMP_ERR_ARGUMENT, ".positions is NULL");
    MESH(m.indices16 = narrow, LSAMP_ERR_ARGUMENT, ".indices16 is set beside indices");
    MESH(m.vertex_count = 0, LSAMP_ERR_ARGUMENT, ".vertex_count is 0; it must be 1..2^31 - 1");
    MESH(m.vertex_count = 0x80000000u, LSAMP_ERR_LIMIT, ".vertex_count is 2147483648; it must be 1..2^31 - 1");
    MESH(m.vertex_stride = 10, LSAMP_ERR_ARGUMENT,
         ".vertex_stride is 10; it must be 0 or a multiple of 4 from 12 on");
    MESH(m.index_count = 5, LSAMP_ERR_ARGUMENT, ".index_count is 5; it must be a multiple of 3, 3..2^31 - 1");
    MESH(m.index_count = 0x80000001u, LSAMP_ERR_LIMIT,
         ".index_count is 2147483649; it must be a multiple of 3, 3..2^31 - 1");
    MESH(m.indices = NULL, LSAMP_ERR_ARGUMENT, ".vertex_count is 4; it must be a multiple of 3, 3..2^31 - 1");
    MESH(m.vertex_count = 3, LSAMP_ERR_INPUT, ": index 2 of triangle 1 is 3, but the mesh has 3 vertices");
    m = good;
    d.texels = texels;
    d.width = d.height = 4;
    refuses(&d, "lsamp_light_init: desc.texels is set: a mesh has none");
    d = light_of(LSAMP_LIGHT_MESH);
    d.mesh = &m;
    d.place_count = (1u << 24) + 1;
    refuses(&d, "lsamp_light_init: desc.place_count is 16777217; it must be 0 or 1..2^24");
    d.place_count = 4;
    d.radius = -1;
    refuses(&d, "lsamp_light_init: desc.radius is -1; it must be 0..1e18");
    d.radius = 0;
    m.index_count = 3;
    wide[2] = 1;
    said(lsamp_light_init(&d, memory, sizeof memory, &light, NULL), LSAMP_ERR_INPUT,
         "lsamp_light_init: desc.mesh has no area");
    wide[2] = 2;
    assert_null(light);
}

static void memory_and_pointers_are_named(void **state)
{
    lsamp_light_desc d = light_of(LSAMP_LIGHT_DISC);
    lsamp_light *light = NULL;
    char too_small[128];
    (void)state;
    snprintf(too_small, sizeof too_small,
             "lsamp_light_init: memory_bytes is 8; it must be at least %lu, lsamp_light_bytes(desc)",
             (unsigned long)lsamp_light_bytes(&d));
    assert_int_equal(lsamp_light_init(NULL, memory, sizeof memory, &light, NULL), LSAMP_ERR_ARGUMENT);
    said(lsamp_light_init(&d, NULL, 0, &light, NULL), LSAMP_ERR_ARGUMENT, "lsamp_light_init: memory is NULL");
    said(lsamp_light_init(&d, memory, sizeof memory, NULL, NULL), LSAMP_ERR_ARGUMENT, "lsamp_light_init: out is NULL");
    said(lsamp_light_init(&d, memory, 8, &light, NULL), LSAMP_ERR_MEMORY, too_small);
    said(lsamp_light_init(&d, (char *)memory + 4, sizeof memory - 4, &light, NULL), LSAMP_ERR_MEMORY,
         "lsamp_light_init: memory is not aligned to 8 bytes");
    assert_null(light);
}

/* Two points under a disc, to be spoilt. */
typedef struct world {
    lsamp_light *light;
    lsamp_sample_desc desc;
    lsamp_points points;
    lsamp_samples out;
    lsamp_material materials[2];
    lsamp_lobe lobes[2];
    float positions[6], normals[6], tangents[6], directions[24], distances[8], weights[24];
} world;

static void open_world(world *w)
{
    lsamp_light_desc d = light_of(LSAMP_LIGHT_DISC);
    int i;
    memset(w, 0, sizeof *w);
    d.position[1] = 2;
    assert_int_equal(lsamp_light_init(&d, memory, sizeof memory, &w->light, NULL), LSAMP_OK);
    for (i = 0; i < 2; i++) {
        w->normals[3 * i + 1] = w->tangents[3 * i] = 1;
        w->lobes[i].axis[2] = 1;
        w->materials[i].diffuse[0] = 0.5f;
    }
    w->desc.system = d.system;
    w->desc.sample_count = 4;
    w->points.count = 2;
    w->points.positions = w->positions;
    w->points.normals = w->normals;
    w->points.materials = w->materials;
    w->points.material_stride = sizeof(lsamp_material);
    w->out.directions = w->directions;
    w->out.distances = w->distances;
    w->out.weights = w->weights;
}

#define SAMPLE(change, result, text)                                                                        \
    do {                                                                                                    \
        size_t useful = 77;                                                                                 \
        open_world(&w);                                                                                     \
        change;                                                                                             \
        said(lsamp_sample(&w.desc, w.light, &w.points, &w.out, &useful), result, "lsamp_sample: " text);    \
        assert_int_equal(useful, 77);                                                                       \
        assert_true(w.distances[0] == 0);       /* nothing is written */                                    \
    } while (0)

static void arrays_and_strides_of_points_are_named(void **state)
{
    world w;
    (void)state;
    SAMPLE(w.light = NULL, LSAMP_ERR_ARGUMENT, "light is NULL");
    SAMPLE(w.out.directions = NULL, LSAMP_ERR_ARGUMENT, "out.directions is NULL");
    SAMPLE(w.out.distances = NULL, LSAMP_ERR_ARGUMENT, "out.distances is NULL");
    SAMPLE(w.out.weights = NULL, LSAMP_ERR_ARGUMENT, "out.weights is NULL");
    SAMPLE(w.desc.sample_count = 0, LSAMP_ERR_DESC, "desc.sample_count is 0; it must be 1..65536");
    SAMPLE(w.desc.sampling = LSAMP_SAMPLING_COUNT, LSAMP_ERR_DESC,
           "desc.sampling is 4; it must be a LSAMP_SAMPLING_...");
    SAMPLE(w.points.positions = NULL, LSAMP_ERR_ARGUMENT, "points.positions is NULL");
    SAMPLE(w.points.normals = NULL, LSAMP_ERR_ARGUMENT, "points.normals is NULL");
    SAMPLE(w.points.materials = NULL, LSAMP_ERR_ARGUMENT, "points.materials is NULL");
    SAMPLE(w.points.position_stride = 8, LSAMP_ERR_ARGUMENT,
           "points.position_stride is 8; it must be 0 or a multiple of 4 from 12 on");
    SAMPLE(w.points.normal_stride = 13, LSAMP_ERR_ARGUMENT,
           "points.normal_stride is 13; it must be 0 or a multiple of 4 from 12 on");
    SAMPLE(w.points.to_eye_stride = 4, LSAMP_ERR_ARGUMENT,
           "points.to_eye_stride is 4; it must be 0 or a multiple of 4 from 12 on");
    SAMPLE(w.points.tangent_stride = 4, LSAMP_ERR_ARGUMENT,
           "points.tangent_stride is 4; it must be 0 or a multiple of 4 from 12 on");
    SAMPLE(w.points.material_stride = 8, LSAMP_ERR_ARGUMENT,
           "points.material_stride is 8; it must be 0, or sizeof(lsamp_material) or above, a multiple of "
           "sizeof(void *)");
    SAMPLE(w.points.count = SIZE_MAX, LSAMP_ERR_LIMIT,
           "points.count is 1.84467e19; it must be less: out does not fit a size_t");
    open_world(&w);
    said(lsamp_sample(&w.desc, w.light, NULL, &w.out, NULL), LSAMP_ERR_ARGUMENT, "lsamp_sample: points is NULL");
    said(lsamp_sample(&w.desc, w.light, &w.points, NULL, NULL), LSAMP_ERR_ARGUMENT, "lsamp_sample: out is NULL");
}

static void elements_of_points_are_named(void **state)
{
    world w;
    (void)state;
    SAMPLE(w.normals[4] = 2, LSAMP_ERR_INPUT,
           "points.normals[1] has the length 2; it must be 1 (0.97..1.03), or 0");
    SAMPLE(w.points.to_eye = w.positions; w.positions[4] = 1.04f; w.positions[1] = 1, LSAMP_ERR_INPUT,
           "points.to_eye[1] has the length 1.04; it must be 1 (0.97..1.03), or 0");
    SAMPLE(w.points.tangents = w.tangents; w.tangents[3] = 0.5f, LSAMP_ERR_INPUT,
           "points.tangents[1] has the length 0.5; it must be 1 (0.97..1.03), or 0");
#define MATERIAL(of, change, text)                                                                      \
    SAMPLE(w.materials[1].kind = of; change, LSAMP_ERR_INPUT, "points.materials[1] " text)
    MATERIAL(LSAMP_MATERIAL_COUNT, (void)0, "has the kind 5; it must be a LSAMP_MATERIAL_...");
    MATERIAL(LSAMP_MATERIAL_LAMBERT, w.materials[1].diffuse[2] = 1.5f, "has the diffuse 1.5; it must be 0..1");
    MATERIAL(LSAMP_MATERIAL_PHONG, w.materials[1].specular[0] = -1, "has the specular -1; it must be 0..1");
    MATERIAL(LSAMP_MATERIAL_PHONG, w.materials[1].exponent = 1e6f, "has the exponent 1000000; it must be 0..100000");
    MATERIAL(LSAMP_MATERIAL_METAL_ROUGH, w.materials[1].metallic = 2, "has the metallic 2; it must be 0..1");
    MATERIAL(LSAMP_MATERIAL_METAL_ROUGH, w.materials[1].roughness = -1, "has the roughness -1; it must be 0..1");
    MATERIAL(LSAMP_MATERIAL_LAFORTUNE, w.materials[1].lobe_count = 9, "has the lobe_count 9; it must be 0..8");
    MATERIAL(LSAMP_MATERIAL_LAFORTUNE, w.materials[1].lobe_count = 2,
             "has no lobes, but the lobe_count 2; it must be 0 then");
#define LOBE(change, text)                                                                              \
    MATERIAL(LSAMP_MATERIAL_LAFORTUNE, w.materials[1].lobes = w.lobes; w.materials[1].lobe_count = 2; change, text)
    LOBE(w.lobes[1].axis[0] = 11, "has a lobe with the axis 11; it must be -10..10");
    LOBE(w.lobes[1].scale[1] = -1, "has a lobe with the scale -1; it must be 0..1e9");
    LOBE(w.lobes[0].exponent = -1, "has a lobe with the exponent -1; it must be 0..100000");
}

/* Point 1 is spoilt: it is no receiver, and the others are lit as before. */
static void a_point_without_or_with_endless_vectors_is_left_out(void **state)
{
    const float nan = (float)(HUGE_VAL - HUGE_VAL), odd[4] = { 0, nan, HUGE_VALF, -HUGE_VALF };
    world w, whole;
    size_t useful, i, k;
    int array;
    (void)state;
    open_world(&whole);
    assert_int_equal(lsamp_sample(&whole.desc, whole.light, &whole.points, &whole.out, &useful), LSAMP_OK);
    assert_int_equal(useful, 8);
    for (array = 0; array < 4; array++)
        for (i = 0; i < 4; i++) {
            float views[6] = { 0, 1, 0, 0, 1, 0 };
            float *spoilt;
            open_world(&w);
            memset(w.directions, 0x31, sizeof w.directions);
            memset(w.weights, 0x31, sizeof w.weights);
            w.points.to_eye = views;
            w.points.tangents = w.tangents;
            spoilt = array == 0 ? w.positions : array == 1 ? w.normals : array == 2 ? views : w.tangents;
            if (array == 0 && i == 0) continue;         /* a position may be 0 0 0 */
            for (k = 3; k < 6; k++) spoilt[k] = i == 0 || k == 3 + i % 3 ? odd[i] : spoilt[k];
            assert_int_equal(lsamp_sample(&w.desc, w.light, &w.points, &w.out, &useful), LSAMP_OK);
            assert_int_equal(useful, 4);
            assert_int_equal(lines, 0);
            assert_memory_equal(w.weights, whole.weights, 12 * sizeof(float));
            for (k = 12; k < 24; k++) assert_true(w.weights[k] == 0 && w.directions[k] == 0);
        }
}

static void surface(void *user, float time, const float x[3], float position[3], float normal[3], float *area)
{
    (void)user;
    (void)time;
    position[0] = x[0];
    position[1] = normal[0] = normal[2] = 0;
    position[2] = x[1];
    normal[1] = *area = 1;
}

/* A light keeps the system that it was made with. */
static void a_light_says_why_it_has_no_domain(void **state)
{
    lsamp_light_desc d = light_of(LSAMP_LIGHT_CALLBACK);
    lsamp_domain domain;
    lsamp_light *light;
    (void)state;
    memset(&domain, 0x31, sizeof domain);
    d.shape_fn = surface;
    assert_int_equal(lsamp_light_init(&d, memory, sizeof memory, &light, NULL), LSAMP_OK);
    said(lsamp_light_domain(light, &domain), LSAMP_ERR_MISMATCH,
         "lsamp_light_domain: light is a callback or a surface, which has no domain of its own");
    assert_int_equal(domain.location_count, (size_t)0x3131313131313131u);
    said(lsamp_light_domain(light, NULL), LSAMP_ERR_ARGUMENT, "lsamp_light_domain: out is NULL");
}

/* Calls without a desc have no log; what they refuse they leave alone. */
static void calls_without_a_log_refuse_as_well(void **state)
{
    const float up[3] = { 0, 1, 0 }, half[3] = { 0, 0.5f, 0 }, u[2] = { 0.5f, 0.5f }, bad[2] = { 1, 0.5f };
    float f[3] = { 7, 7, 7 }, wi[3] = { 7, 7, 7 }, pdf = 7, sums[3] = { 7, 7, 7 }, pattern[4];
    double totals[3] = { 0, 0, 0 };
    lsamp_progressive p;
    lsamp_material m, refused;
    lsamp_domain domain;
    (void)state;
    memset(&m, 0, sizeof m);
    memset(&p, 0, sizeof p);
    p.count = 3;
    refused = m;
    refused.diffuse[0] = -1;
    assert_int_equal(lsamp_brdf_eval(&m, half, NULL, up, up, f, &pdf), LSAMP_ERR_INPUT);
    assert_int_equal(lsamp_brdf_eval(&m, up, half, up, up, f, &pdf), LSAMP_ERR_INPUT);
    assert_int_equal(lsamp_brdf_eval(&m, up, NULL, up, half, f, &pdf), LSAMP_ERR_INPUT);
    assert_int_equal(lsamp_brdf_eval(NULL, up, NULL, up, up, f, &pdf), LSAMP_ERR_ARGUMENT);
    assert_int_equal(lsamp_brdf_eval(&refused, up, NULL, up, up, f, &pdf), LSAMP_ERR_INPUT);
    assert_int_equal(lsamp_brdf_sample(&m, up, NULL, up, bad, wi, f, &pdf), LSAMP_ERR_INPUT);
    assert_int_equal(lsamp_brdf_sample(&refused, up, NULL, up, u, wi, f, &pdf), LSAMP_ERR_INPUT);
    assert_true(f[0] == 7 && wi[0] == 7 && pdf == 7);
    assert_int_equal(lsamp_accumulate(1, 0, f, NULL, sums, 0), LSAMP_ERR_ARGUMENT);
    assert_int_equal(lsamp_accumulate(1, 1, NULL, NULL, sums, 0), LSAMP_ERR_ARGUMENT);
    assert_int_equal(lsamp_accumulate(1, 1, f, NULL, sums, 10), LSAMP_ERR_ARGUMENT);
    assert_int_equal(lsamp_progressive_reset(NULL), LSAMP_ERR_ARGUMENT);
    assert_int_equal(lsamp_progressive_reset(&p), LSAMP_ERR_ARGUMENT);
    p.sums = totals;
    assert_int_equal(lsamp_progressive_reset(&p), LSAMP_OK);
    assert_int_equal(lsamp_progressive_mean(&p, sums), LSAMP_ERR_ORDER);
    assert_int_equal(lsamp_progressive_mean(&p, NULL), LSAMP_ERR_ARGUMENT);
    assert_int_equal(lsamp_progressive_add(&p, NULL), LSAMP_ERR_ARGUMENT);
    p.frame_count = UINT32_MAX;
    assert_int_equal(lsamp_progressive_add(&p, sums), LSAMP_ERR_LIMIT);
    assert_true(totals[0] == 0);
    assert_true(sums[0] == 7);
    assert_int_equal(lsamp_patterns_bytes(0), 0);
    assert_int_equal(lsamp_patterns_bytes(65537), 0);
    assert_int_equal(lsamp_patterns_build(4, 1, NULL, 0), LSAMP_ERR_ARGUMENT);
    assert_int_equal(lsamp_patterns_build(0, 1, pattern, sizeof pattern), LSAMP_ERR_ARGUMENT);
    assert_int_equal(lsamp_patterns_build(4, 1, pattern, sizeof pattern), LSAMP_ERR_MEMORY);
    assert_int_equal(lsamp_light_domain(NULL, &domain), LSAMP_ERR_ARGUMENT);
    assert_int_equal(lsamp_light_triangles(NULL, NULL), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_field_of_any_light_is_named),
        cmocka_unit_test(a_field_of_one_kind_of_light_is_named),
        cmocka_unit_test(a_surface_and_a_filter_are_named),
        cmocka_unit_test(a_mesh_that_cannot_shine_says_why),
        cmocka_unit_test(memory_and_pointers_are_named),
        cmocka_unit_test(arrays_and_strides_of_points_are_named),
        cmocka_unit_test(elements_of_points_are_named),
        cmocka_unit_test(a_point_without_or_with_endless_vectors_is_left_out),
        cmocka_unit_test(a_light_says_why_it_has_no_domain),
        cmocka_unit_test(calls_without_a_log_refuse_as_well),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
