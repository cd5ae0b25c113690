/* bounces_test - one interreflection between bodies: row bounce of docs/conformance.md, patches that face each other
   against their form factor, a lamp over two walls against sums over both, and what stands between them. */
#include "shadowfield.h"
#include "util.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include "conformance.h"

enum { CUTS = 8 };

/* A square of sides 2 a about the origin, cut into 2 x 8 x 8 triangles, counter-clockwise from +y. */
static model model_plate(double a)
{
    model m = model_alloc((CUTS + 1) * (CUTS + 1), 2 * CUTS * CUTS);
    uint32_t *i = m.i, x, z;
    for (z = 0; z <= CUTS; z++)
        for (x = 0; x <= CUTS; x++) {
            m.p[3 * (z * (CUTS + 1) + x)] = (float)(a * (2.0 * x / CUTS - 1));
            m.p[3 * (z * (CUTS + 1) + x) + 2] = (float)(a * (2.0 * z / CUTS - 1));
        }
    for (z = 0; z < CUTS; z++)
        for (x = 0; x < CUTS; x++) {
            const uint32_t k = z * (CUTS + 1) + x, below = k + CUTS + 1;
            *i++ = k; *i++ = below; *i++ = k + 1;
            *i++ = k + 1; *i++ = below; *i++ = below + 1;
        }
    return m;
}

static float *albedo_of(const model *m, float r, float g, float b)
{
    float *albedo = (float *)malloc(m->indices * sizeof *albedo);
    size_t i;
    if (!albedo) abort();
    for (i = 0; i < m->indices; i++) albedo[i] = i % 3 == 0 ? r : i % 3 == 1 ? g : b;
    return albedo;
}

static sfield_desc desc_of_bounce(void)
{
    sfield_desc d;
    memset(&d, 0, sizeof d);
    d.shell_count = 8;
    d.position_side = 7;
    return d;
}

static sfield_bounce *bounce_of(const model *m, float r, float g, float b, uint32_t patches)
{
    const sfield_desc d = desc_of_bounce();
    sfield_mesh mesh = mesh_of(m);
    float *albedo = albedo_of(m, r, g, b);
    sfield_bounce *bounce = NULL;
    assert_int_equal(sfield_bounce_create(&d, &mesh, albedo, patches, &bounce), SFIELD_OK);
    free(albedo);
    return bounce;
}

/* Of a point that faces the middle of a square of sides 2 a, h away. */
static double form_factor(double a, double h)
{
    const double x = a / h, w = sqrt(1 + x * x);
    return 4 * (2 * x / w * atan(x / w)) / (2 * PI);
}

/* All light comes from before the point, so that the second band says what arrives. */
static void facing_patches_exchange_light_by_their_form_factor(void **state)
{
    static const double at[3] = { 0.7, 1, 2 };
    static const char *const names[3] = { "irradiance from a lit square of sides 1, 0.7 away", "1 away", "2 away" };
    model m = model_plate(0.5);
    sfield_bounce *bounce = bounce_of(&m, 0.8f, 0.4f, 0, 9);
    sfield_points points;
    float *rgb;
    size_t i;
    int k;
    (void)state;
    sfield_bounce_points(bounce, &points);
    assert_int_equal(points.count, 36);
    rgb = (float *)malloc(3 * points.count * sizeof *rgb);
    assert_non_null(rgb);
    for (i = 0; i < 3 * points.count; i++) rgb[i] = 1;
    for (i = 0; i < points.count; i++) {
        assert_true(points.normals[3 * i + 1] == 1 && points.positions[3 * i + 1] == 0);
        assert_true(fabsf(points.positions[3 * i]) < 0.5f && fabsf(points.positions[3 * i + 2]) < 0.5f);
    }
    assert_int_equal(sfield_bounce_update(bounce, rgb), SFIELD_OK);
    for (k = 0; k < 3; k++) {
        const double exact = 0.8 * PI * form_factor(0.5, at[k]);
        float p[3] = { 0, (float)at[k], 0 }, c[48];
        assert_int_equal(sfield_query(sfield_bounce_source(bounce), 1, p, 0, c), SFIELD_OK);
        /* views of 128 samples a side: the square's edges are off by up to one of some 30 */
        CONFORM("bounce", names[k], exact, -(double)c[1] / 0.48860251, 0.06 * exact);
        assert_true(fabsf(c[17] - 0.5f * c[1]) < 0.01f * fabsf(c[1]) && fabsf(c[33]) < 1e-5f);
    }
    free(rgb);
    sfield_bounce_free(bounce);
    model_free(&m);
}

/* Patches of radiance 1 add up to the body that shines with a radiance of 1. */
static void patches_add_up_to_the_whole(void **state)
{
    model m = model_soup(60, 0.5, 9);
    const sfield_desc d = desc_of_bounce();
    sfield_mesh mesh = mesh_of(&m);
    sfield_bounce *bounce = bounce_of(&m, 1, 1, 1, 13);
    sfield_points points;
    sfield_field *whole;
    float *ones = albedo_of(&m, 1, 1, 1), *rgb, p[3 * 40], a[40 * 48], b[40 * 48];
    double worst = 0, most = 0, dir[3];
    uint64_t seed = 4;
    size_t i, k;
    (void)state;
    sfield_bounce_points(bounce, &points);
    assert_int_equal(points.count, 52);
    rgb = (float *)malloc(3 * points.count * sizeof *rgb);
    assert_non_null(rgb);
    for (i = 0; i < 3 * points.count; i++) rgb[i] = 1;
    assert_int_equal(sfield_bounce_update(bounce, rgb), SFIELD_OK);
    assert_int_equal(sfield_build_emissive(&d, &mesh, ones, &whole, NULL), SFIELD_OK);
    for (i = 0; i < 40; i++) {
        rnd_direction(&seed, dir);
        for (k = 0; k < 3; k++) p[3 * i + k] = (float)(dir[k] * (1.2 + 0.1 * (double)i));
    }
    assert_int_equal(sfield_query(whole, 40, p, 0, a), SFIELD_OK);
    assert_int_equal(sfield_query(sfield_bounce_source(bounce), 40, p, 0, b), SFIELD_OK);
    for (i = 0; i < 40 * 48; i++) {
        worst = fmax(worst, fabs((double)a[i] - (double)b[i]));
        most = fmax(most, fabs((double)a[i]));
    }
    CONFORM_MAX("bounce", "13 patches off the whole body, by its largest coefficient", 0.02, worst / most); /* 8 bits */
    sfield_free(whole);
    sfield_bounce_free(bounce);
    free(ones);
    free(rgb);
    model_free(&m);
}

/* A corner of two walls under a lamp: sums over the floor say what it sends to a point of the wall. */
static double floor_to_wall(const double *lamp, double flux, double albedo, const double *p)
{
    enum { N = 200 };
    double sum = 0;
    int i, j, k;
    for (i = 0; i < N; i++)
        for (j = 0; j < N; j++) {
            const double q[3] = { -1 + (2 * i + 1.0) / N, 0, -1 + (2 * j + 1.0) / N };
            double d[3], e[3], dd = 0, ee = 0;
            for (k = 0; k < 3; k++) {
                d[k] = lamp[k] - q[k], dd += d[k] * d[k];
                e[k] = p[k] - q[k], ee += e[k] * e[k];
            }
            sum += flux * d[1] / (dd * sqrt(dd)) * albedo / PI * e[1] * -e[0] / (ee * ee) * 4 / (N * N);
        }
    return sum;
}

/* Entities: the floor, the wall's point belongs to none; the lamp; what may stand between the floor and the wall. */
static void lit_floor(sfield_bounce *bounce, const sfield_field *plate, const sfield_field *lamp,
                      const sfield_field *between, float *rgb)
{
    static const float place[3] = { -1.3f, 0.5f, 0.2f }, right[3] = { 1, 0, 0 };
    const sfield_entity upright = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };
    sfield_entity e[3] = { upright, upright, upright };
    sfield_points floor_points, wall;
    sfield_scene *s = NULL;
    float *lit, direct[3];
    int k;
    sfield_bounce_points(bounce, &floor_points);
    lit = (float *)malloc(3 * floor_points.count * sizeof *lit);
    assert_non_null(lit);
    assert_int_equal(sfield_scene_create(NULL, &s), SFIELD_OK);
    e[0].occlusion = plate;
    e[1].source = lamp;
    e[1].transform[13] = 2;
    e[1].transform[12] = 0.3f;
    e[2].occlusion = between;
    e[2].transform[12] = -1.15f;
    e[2].transform[13] = 0.3f;
    assert_int_equal(sfield_scene_entities(s, e, 3), SFIELD_OK);
    floor_points.entity = 1;
    floor_points.rgb = lit;
    assert_int_equal(sfield_shade(s, &floor_points, 1, NULL), SFIELD_OK);
    assert_int_equal(sfield_bounce_update(bounce, lit), SFIELD_OK);
    memset(&wall, 0, sizeof wall);
    wall.count = 1;
    wall.positions = place;
    wall.normals = right;
    wall.rgb = direct;
    assert_int_equal(sfield_shade(s, &wall, 1, NULL), SFIELD_OK);
    e[0].source = sfield_bounce_source(bounce);
    assert_int_equal(sfield_scene_entities(s, e, 3), SFIELD_OK);
    wall.rgb = rgb;
    assert_int_equal(sfield_shade(s, &wall, 1, NULL), SFIELD_OK);
    for (k = 0; k < 3; k++) rgb[k] -= direct[k];
    sfield_scene_free(s);
    free(lit);
}

static void a_lit_floor_lights_the_wall_and_what_stands_between_hides_it(void **state)
{
    const double lamp_at[3] = { 0.3, 2, 0 }, place[3] = { -1.3, 0.5, 0.2 };
    model m = model_plate(1), screen = model_box(0.02, 0.5, 1.2);
    const sfield_desc d = desc_of_bounce();
    sfield_mesh mesh = mesh_of(&m), between = mesh_of(&screen);
    sfield_bounce *bounce = bounce_of(&m, 0.75f, 0.25f, 0.5f, 12);
    sfield_field *plate, *screened, *lamp;
    sfield_emitter e;
    float rgb[3], hidden[3];
    double exact;
    (void)state;
    memset(&e, 0, sizeof e);
    e.radius = 0.1f;
    e.radiance[0] = e.radiance[1] = e.radiance[2] = 100;
    assert_int_equal(sfield_build(&d, &mesh, &plate, NULL), SFIELD_OK);
    assert_int_equal(sfield_build(&d, &between, &screened, NULL), SFIELD_OK);
    assert_int_equal(sfield_build_emitter(&d, &e, &lamp, NULL), SFIELD_OK);
    lit_floor(bounce, plate, lamp, NULL, rgb);
    exact = floor_to_wall(lamp_at, 100 * PI * 0.01, 0.75, place) / PI;
    CONFORM("bounce", "from a lamp by way of the floor to the wall", exact, rgb[0], 0.1 * exact);       /* 4 bands */
    assert_true(fabsf(rgb[1] * 3 - rgb[0]) < 0.01f * rgb[0] && fabsf(rgb[2] * 1.5f - rgb[0]) < 0.01f * rgb[0]);
    lit_floor(bounce, plate, lamp, screened, hidden);
    print_message("behind a screen %.4f of %.4f\n", (double)hidden[0], (double)rgb[0]);
    assert_true(hidden[0] < 0.35f * rgb[0]);
    sfield_bounce_free(bounce);
    sfield_free(plate);
    sfield_free(screened);
    sfield_free(lamp);
    model_free(&m);
    model_free(&screen);
}

static char said[256];
static void listen(void *user, const char *message)
{
    (void)user;
    snprintf(said, sizeof said, "%s", message);
}

static void bad_bounces_are_refused_and_nothing_leaks(void **state)
{
    static const float line[9] = { 0, 0, 0, 1, 0, 0, 2, 0, 0 };
    model m = model_plate(1);
    sfield_mesh mesh = mesh_of(&m);
    float *albedo = albedo_of(&m, 0.5f, 0.5f, 0.5f);
    counting c = { 0, 0, 0, 0, 0 };
    sfield_desc d = small_desc(SFIELD_BASIS_SH);
    sfield_bounce *b = NULL;
    sfield_points points;
    sfield_result result = SFIELD_ERR_ALLOC;
    size_t fail;
    (void)state;
    d.system.log = listen;
    assert_int_equal(sfield_bounce_create(&d, NULL, albedo, 0, &b), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_bounce_create(&d, &mesh, NULL, 0, &b), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_bounce_create(&d, &mesh, albedo, 0, NULL), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_bounce_create(&d, &mesh, albedo, 193, &b), SFIELD_ERR_ARGUMENT);
    assert_non_null(strstr(said, "patch_count is 193"));
    albedo[7] = 1.5f;
    assert_int_equal(sfield_bounce_create(&d, &mesh, albedo, 0, &b), SFIELD_ERR_INPUT);
    assert_non_null(strstr(said, "albedo[7]"));
    albedo[7] = 0.5f;
    d.basis = SFIELD_BASIS_HAAR;
    assert_int_equal(sfield_bounce_create(&d, &mesh, albedo, 0, &b), SFIELD_ERR_DESC);
    d.basis = SFIELD_BASIS_SH;
    d.logarithm = 1;
    assert_int_equal(sfield_bounce_create(&d, &mesh, albedo, 0, &b), SFIELD_ERR_DESC);
    d.logarithm = 0;
    m.i[4] = 1000;
    assert_int_equal(sfield_bounce_create(&d, &mesh, albedo, 0, &b), SFIELD_ERR_INPUT);
    m.i[4] = 9;
    mesh.positions = line;
    mesh.indices = NULL;
    mesh.vertex_count = 3;
    assert_int_equal(sfield_bounce_create(&d, &mesh, albedo, 0, &b), SFIELD_ERR_INPUT);
    assert_non_null(strstr(said, "mesh has no triangle with an area"));
    mesh = mesh_of(&m);
    assert_null(b);
    d.system.allocator = counting_allocator(&c);
    for (fail = 1; result != SFIELD_OK; fail++) {
        assert_true(fail < 60);
        c.calls = 0;
        c.fail_at = fail;
        said[0] = 0;
        result = sfield_bounce_create(&d, &mesh, albedo, 7, &b);
        assert_true(result == SFIELD_OK || (result == SFIELD_ERR_ALLOC && c.now == 0 && !b));
        assert_true(result == SFIELD_OK || strstr(said, "desc.system.allocator returned no memory"));
    }
    assert_true(fail > 6);
    assert_int_equal(sfield_bounce_update(NULL, albedo), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_bounce_update(b, NULL), SFIELD_ERR_ARGUMENT);
    sfield_bounce_points(NULL, &points);
    sfield_bounce_points(b, NULL);
    assert_null(sfield_bounce_source(NULL));
    sfield_bounce_free(b);
    sfield_bounce_free(NULL);
    assert_true(c.now == 0);
    free(albedo);
    model_free(&m);
}

/* Two triangles are two patches, however many are asked for; what cannot be used is none, and a vertex of no triangle
   changes nothing, wherever it lies. */
static void few_triangles_are_few_patches(void **state)
{
    model m = model_alloc(6, 3);
    sfield_mesh mesh = mesh_of(&m);
    float albedo[9] = { 1, 1, 1, 0, 0, 0, 1, 1, 1 }, rgb[24], p[3] = { 0, 3, 0 }, c[48];
    sfield_desc d = small_desc(SFIELD_BASIS_SH);
    sfield_bounce *b = NULL;
    sfield_points points;
    uint32_t i;
    (void)state;
    m.p[0] = m.p[7] = m.p[11] = 1;              /* 1 0 0, 0 0 0, 0 1 0 and 0 0 1: two triangles, and one of one point */
    m.p[15] = 1e20f;
    for (i = 0; i < 9; i++) m.i[i] = i < 3 ? i : i < 6 ? (i == 3 ? 0 : i == 4 ? 2 : 3) : 1;
    assert_int_equal(sfield_bounce_create(&d, &mesh, albedo, 24, &b), SFIELD_OK);
    sfield_bounce_points(b, &points);
    assert_int_equal(points.count, 8);
    sfield_query(sfield_bounce_source(b), 1, p, 0, c);
    for (i = 0; i < 48; i++) assert_true(c[i] == 0);                  /* dark, before it gets light */
    for (i = 0; i < 24; i++) rgb[i] = i % 3 == 0 ? NAN : i % 3 == 1 ? INFINITY : -1;
    assert_int_equal(sfield_bounce_update(b, rgb), SFIELD_OK);
    sfield_query(sfield_bounce_source(b), 1, p, 0, c);
    for (i = 0; i < 48; i++) assert_true(c[i] == 0);
    sfield_bounce_free(b);
    model_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(facing_patches_exchange_light_by_their_form_factor),
        cmocka_unit_test(patches_add_up_to_the_whole),
        cmocka_unit_test(a_lit_floor_lights_the_wall_and_what_stands_between_hides_it),
        cmocka_unit_test(bad_bounces_are_refused_and_nothing_leaks),
        cmocka_unit_test(few_triangles_are_few_patches),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
