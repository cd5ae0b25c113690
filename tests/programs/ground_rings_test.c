/* ground_rings_test - the ground beyond the pictures of suns, which rsm and ism of render take light from: all of its
   flux, no more, by closed forms. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "../../examples/render/ground.h"

#define RADIUS 2.0f
#define SIDE 2.5               /* half side of what a picture shows */
#define ALBEDO 0.5             /* of ex_scene_add_ground */

/* A knot with or without ground; the test's own sphere. */
static void open_scene(ex_scene *scene, rd_job *job, int with_ground)
{
    char error[EX_ERROR_SIZE];
    float radius;
    memset(job, 0, sizeof *job);
    assert_int_equal(ex_scene_builtin(scene, "knot", 0, error), 0);
    assert_int_equal(ex_scene_bounds(scene, job->center, &radius), 0);
    if (with_ground)
        assert_int_equal(ex_scene_add_ground(scene), 0);
    job->radius = RADIUS;
    job->scene = scene;
}

/* A sun in the plane of x and y; its picture is a square about a point of the ground. */
static rd_cover sun_at(const rd_job *job, double ground, double angle, const float irradiance[3])
{
    const double axes[2][3] = { { cos(angle), -sin(angle), 0 }, { 0, 0, 1 } };
    rd_cover cover;
    memset(&cover, 0, sizeof cover);
    for (int i = 0; i < 4; i++) {
        double *plane = cover.planes[cover.plane_count++], sign = i & 1 ? -1 : 1;
        for (int k = 0; k < 3; k++)
            plane[k] = sign * axes[i / 2][k];
        plane[3] = SIDE - plane[0] * (double)job->center[0] - plane[1] * ground - plane[2] * (double)job->center[2];
    }
    memcpy(cover.irradiance, irradiance, sizeof cover.irradiance);
    return cover;
}

static double ground_height(const ex_scene *scene)
{
    return (double)scene->objects[scene->object_count - 1].transform[13];
}

static double half_of_ground(const ex_scene *scene)
{
    const ex_mesh *mesh = &scene->meshes[scene->objects[scene->object_count - 1].mesh];
    return fabs((double)mesh->positions[0]);
}

typedef struct sums { double flux[3], area, dark; } sums;      /* dark: area without flux */

static sums sum_rings(const rd_ring *rings, size_t count)
{
    sums s = { { 0, 0, 0 }, 0, 0 };
    for (size_t r = 0; r < count; r++) {
        double texel = 2.0 * (double)rings[r].half / RD_RING_SIDE;
        for (size_t i = 0; i < (size_t)RD_RING_SIDE * RD_RING_SIDE; i++) {
            double flux = 0;
            for (size_t k = 0; k < 3; k++) {
                s.flux[k] += (double)rings[r].radiosity[3 * i + k] * texel * texel;
                flux += (double)rings[r].radiosity[3 * i + k];
            }
            s.area += (double)rings[r].areas[i];
            s.dark += flux > 0 ? 0 : (double)rings[r].areas[i];
        }
    }
    return s;
}

static void near_to(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance * fabs(expected)))
        fail_msg("%.9g, not %.9g", value, expected);
}

static void rings_have_all_flux_of_the_ground(void **state)
{
    static const float first[3] = { 1, 2, 0 }, second[3] = { 0.25f, 0, 3 };
    const double tilt = 1.2;
    ex_scene scene;
    rd_job job;
    rd_cover covers[2];
    rd_ring *rings;
    size_t count;
    double ground, half, upright, tilted;
    (void)state;
    open_scene(&scene, &job, 1);
    half = half_of_ground(&scene);
    ground = ground_height(&scene);
    covers[0] = sun_at(&job, ground, 0, first);
    covers[1] = sun_at(&job, ground, tilt, second);
    assert_int_equal(rd_rings_build(&rings, &count, &job, covers, 2), 0);
    assert_true(count >= 2 && (double)rings[count - 1].half >= half && (double)rings[count - 2].half < half);
    sums s = sum_rings(rings, count);
    upright = 4 * half * half - 4 * SIDE * SIDE;
    tilted = 4 * half * half - 4 * SIDE * SIDE / cos(tilt);
    near_to(s.area, 4 * half * half, 1e-5);
    near_to(s.flux[0], ALBEDO * (1 * upright + 0.25 * tilted), 1e-5);
    near_to(s.flux[1], ALBEDO * 2 * upright, 1e-5);
    near_to(s.flux[2], ALBEDO * 3 * tilted, 1e-5);
    rd_rings_free(rings, count);
    ex_scene_free(&scene);
}

/* The dark area near the scene, where far flux does not hide an error of it. */
static void rings_have_the_area_and_shadow_of_the_inner_square(void **state)
{
    static const float light[3] = { 1, 1, 1 };
    ex_scene scene;
    rd_job job;
    rd_cover cover;
    rd_ring *rings;
    size_t count;
    (void)state;
    open_scene(&scene, &job, 1);
    for (double tilt = 0; tilt < 1.3; tilt += 0.4) {
        double inner, lit, texel;
        cover = sun_at(&job, ground_height(&scene), tilt, light);
        assert_int_equal(rd_rings_build(&rings, &count, &job, &cover, 1), 0);
        inner = 4 * (double)rings[0].half * (double)rings[0].half;
        texel = inner / (RD_RING_SIDE * RD_RING_SIDE);
        sums s = sum_rings(rings, 1);
        lit = inner - 4 * SIDE * SIDE / cos(tilt);
        near_to(s.area, inner, 1e-5);
        near_to(s.flux[0], ALBEDO * lit, 1e-5);
        assert_true(s.dark <= inner - lit && s.dark >= inner - lit - 4 * RD_RING_SIDE * texel);
        rd_rings_free(rings, count);
    }
    ex_scene_free(&scene);
}

static void positions_of_rings_reach_from_corner_to_corner(void **state)
{
    static const float light[3] = { 1, 1, 1 };
    ex_scene scene;
    rd_job job;
    rd_cover cover;
    rd_ring *rings;
    size_t count, last = (size_t)RD_RING_SIDE * RD_RING_SIDE - 1;
    (void)state;
    open_scene(&scene, &job, 1);
    cover = sun_at(&job, ground_height(&scene), 0, light);
    assert_int_equal(rd_rings_build(&rings, &count, &job, &cover, 1), 0);
    for (size_t r = 0; r < count; r++) {
        const float *p = rings[r].positions, end = rings[r].half * (1 - 1.0f / RD_RING_SIDE);
        near_to((double)(p[0] - job.center[0]), (double)-end, 1e-5);
        near_to((double)(p[2] - job.center[2]), (double)end, 1e-5);
        near_to((double)(p[3 * last] - job.center[0]), (double)end, 1e-5);
        near_to((double)(p[3 * last + 2] - job.center[2]), (double)-end, 1e-5);
        for (size_t i = 0; i <= last; i++)
            assert_true((double)p[3 * i + 1] == ground_height(&scene) && rings[r].normals[3 * i + 1] == 1);
    }
    rd_rings_free(rings, count);
    ex_scene_free(&scene);
}

static void no_ground_or_no_light_gives_no_rings(void **state)
{
    static const float light[3] = { 1, 1, 1 }, dark[3] = { 0, 0, 0 };
    ex_scene scene;
    rd_job job;
    rd_cover cover;
    rd_ring *rings;
    size_t count;
    (void)state;
    open_scene(&scene, &job, 0);
    cover = sun_at(&job, 0, 0, light);
    assert_int_equal(rd_rings_build(&rings, &count, &job, &cover, 1), 0);
    assert_true(count == 0);
    rd_rings_free(rings, count);
    ex_scene_free(&scene);
    open_scene(&scene, &job, 1);
    cover = sun_at(&job, 0, 0, dark);
    assert_int_equal(rd_rings_build(&rings, &count, &job, &cover, 1), 0);
    assert_true(count == 0);
    rd_rings_free(rings, count);
    assert_int_equal(rd_rings_build(&rings, &count, &job, NULL, 0), 0);
    assert_true(count == 0);
    rd_rings_free(rings, count);
    ex_scene_free(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rings_have_all_flux_of_the_ground),
        cmocka_unit_test(rings_have_the_area_and_shadow_of_the_inner_square),
        cmocka_unit_test(positions_of_rings_reach_from_corner_to_corner),
        cmocka_unit_test(no_ground_or_no_light_gives_no_rings),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
