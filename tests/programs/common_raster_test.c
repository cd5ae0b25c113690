/* common_raster_test.c - examples/common: the rasteriser of primary visibility against exact answers. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "common.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define assert_near(a, b, tolerance) assert_true(fabs((double)(a) - (double)(b)) <= (tolerance))

/* A scene of one object over arrays of the caller; nothing in it is freed. */
typedef struct small_scene {
    ex_scene    scene;
    ex_mesh     mesh;
    ex_object   object;
    ex_material material;
    uint32_t    materials[8192];
    float       normals[3 * 8192];
} small_scene;

static void set_up(small_scene *s, float *positions, uint32_t vertices, uint32_t *indices, uint32_t triangles)
{
    memset(s, 0, sizeof *s);
    s->mesh.positions = positions;
    s->mesh.normals = s->normals;
    s->mesh.indices = indices;
    s->mesh.materials = s->materials;
    s->mesh.vertex_count = vertices;
    s->mesh.triangle_count = triangles;
    for (uint32_t i = 0; i < vertices; i++) s->normals[3 * i + 2] = 1;
    for (int k = 0; k < 3; k++) s->material.base_color[k] = 0.5f;
    s->material.base_texture = -1;
    for (int i = 0; i < 16; i += 5) s->object.transform[i] = 1;
    s->scene.meshes = &s->mesh;
    s->scene.mesh_count = 1;
    s->scene.objects = &s->object;
    s->scene.object_count = 1;
    s->scene.materials = &s->material;
    s->scene.material_count = 1;
    s->scene.camera.up[1] = 1;
    s->scene.camera.target[2] = -1;
    s->scene.camera.fovy = 1.5707964f;
}

static void render(ex_gbuffer *out, const ex_scene *scene, uint32_t width, uint32_t height, uint32_t aa, int threads)
{
    char error[EX_ERROR_SIZE];
    assert_int_equal(ex_gbuffer_render(out, scene, width, height, aa, threads, error), 0);
    assert_int_equal(out->width, width * aa);
    assert_int_equal(out->height, height * aa);
}

static float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* What holds for every pixel that shows a surface. */
static void check_pixel(const ex_pixel *p, const ex_camera *camera)
{
    float to_eye[3], length;
    for (int k = 0; k < 3; k++) to_eye[k] = camera->eye[k] - p->position[k];
    length = sqrtf(dot(to_eye, to_eye));
    assert_near(dot(p->normal, p->normal), 1, 1e-5);
    assert_near(dot(p->geometric, p->geometric), 1, 1e-5);
    assert_near(dot(p->view, to_eye), length, 1e-5 * (double)length);
    assert_true(dot(p->normal, p->view) > 0);
    assert_true(dot(p->geometric, p->view) >= 0);
    assert_true(dot(p->normal, p->geometric) > -1e-3f);
}

static void raster_inside_a_box_hits_its_walls(void **state)
{
    /* Faces of [-1, 1]^3, seen from within: most triangles reach behind the eye. */
    float corners[24];
    uint32_t indices[36] = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4,
        5, 7, 4, 7, 6};
    static const float targets[4][3] = {{0.3f, 0.2f, -1}, {-1, -0.4f, 0.3f}, {0.1f, 1, 0.05f}, {0, -1, 0}};
    small_scene *s = (small_scene *)malloc(sizeof *s);
    (void)state;
    for (int i = 0; i < 24; i++) corners[i] = (i / 3) >> (i % 3) & 1 ? 1.0f : -1.0f;
    set_up(s, corners, 8, indices, 12);
    for (int view = 0; view < 4; view++) {
        ex_gbuffer g;
        float eye[3] = {0.1f, -0.2f, 0.15f};
        memcpy(s->scene.camera.eye, eye, sizeof eye);
        memcpy(s->scene.camera.target, targets[view], sizeof eye);
        render(&g, &s->scene, 97, 61, 1, 2);
        for (size_t i = 0; i < 97 * 61; i++) {
            const ex_pixel *p = &g.pixels[i];
            assert_int_equal(p->object, 0);
            check_pixel(p, &s->scene.camera);
            float largest = 0;
            int wall = 0;
            for (int k = 0; k < 3; k++)
                if (fabsf(p->position[k]) > largest) { largest = fabsf(p->position[k]); wall = k; }
            assert_near(largest, 1, 2e-6);
            if (fabsf(fabsf(p->position[(wall + 1) % 3]) - 1) > 1e-4f
                && fabsf(fabsf(p->position[(wall + 2) % 3]) - 1) > 1e-4f)
                assert_near(p->geometric[wall], -p->position[wall], 1e-5);        /* inwards */
        }
        ex_gbuffer_free(&g);
    }
    free(s);
}

/* A wavy, irregular grid of n x n cells in [-1, 1]^2 at z about -1, with shared or with separate vertices. */
static void make_grid(int n, float *positions, uint32_t *indices)
{
    uint32_t random = 7;
    for (int i = 0; i <= n; i++)
        for (int k = 0; k <= n; k++) {
            float *p = positions + 3 * (i * (n + 1) + k), jitter[3];
            int border = i == 0 || k == 0 || i == n || k == n;
            for (int c = 0; c < 3; c++) {
                random = random * 1664525u + 1013904223u;
                jitter[c] = border && c < 2 ? 0 : ((float)(random >> 8) / 16777216.0f - 0.5f) * 0.8f / (float)n;
            }
            p[0] = 2 * (float)k / (float)n - 1 + jitter[0];
            p[1] = 2 * (float)i / (float)n - 1 + jitter[1];
            p[2] = -1 + 0.3f * jitter[2];
        }
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++) {
            uint32_t a = (uint32_t)(i * (n + 1) + k), b = a + (uint32_t)n + 1, *to = indices + 6 * (i * n + k);
            to[0] = a; to[1] = a + 1; to[2] = b + 1;
            to[3] = a; to[4] = b + 1; to[5] = b;
        }
}

static void raster_has_no_cracks(void **state)
{
    enum { N = 60 };
    static float positions[3 * (N + 1) * (N + 1)];
    static uint32_t indices[6 * N * N];
    small_scene *s = (small_scene *)malloc(sizeof *s);
    (void)state;
    make_grid(N, positions, indices);
    set_up(s, positions, (N + 1) * (N + 1), indices, 2 * N * N);
    for (int view = 0; view < 6; view++) {
        ex_gbuffer g;
        s->scene.camera.eye[0] = 0.1f * (float)view - 0.3f;
        s->scene.camera.eye[1] = 0.37f - 0.11f * (float)view;
        s->scene.camera.eye[2] = -0.8f + 0.07f * (float)view;
        memcpy(s->scene.camera.target, s->scene.camera.eye, 12);
        s->scene.camera.target[2] -= 1;
        s->scene.camera.target[0] += 0.01f * (float)view;
        s->scene.camera.fovy = 0.8f;
        render(&g, &s->scene, 300, 280, 1, 2);
        for (size_t i = 0; i < 300 * 280; i++) {
            assert_int_equal(g.pixels[i].object, 0);
            check_pixel(&g.pixels[i], &s->scene.camera);
        }
        ex_gbuffer_free(&g);
    }
    free(s);
}

/* Two triangles whose common edge runs exactly through pixel centres, drawn one by one: each pixel belongs to one. */
static void raster_gives_shared_edges_to_one_side(void **state)
{
    float corners[12] = {-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1};
    uint32_t halves[2][2][3] = {{{0, 1, 2}, {0, 2, 3}}, {{1, 2, 3}, {1, 3, 0}}};
    small_scene *s = (small_scene *)malloc(sizeof *s);
    (void)state;
    for (int diagonal = 0; diagonal < 2; diagonal++)
        for (uint32_t size = 4; size <= 64; size *= 2) {
            uint8_t hits[64 * 64] = {0};
            for (int half = 0; half < 2; half++) {
                ex_gbuffer g;
                set_up(s, corners, 4, halves[diagonal][half], 1);
                render(&g, &s->scene, size, size, 1, 1);
                for (size_t i = 0; i < size * size; i++) hits[i] = (uint8_t)(hits[i] + (g.pixels[i].object == 0));
                ex_gbuffer_free(&g);
            }
            for (size_t i = 0; i < size * size; i++) assert_int_equal(hits[i], 1);
        }
    free(s);
}

static void raster_is_the_same_on_any_number_of_threads(void **state)
{
    char error[EX_ERROR_SIZE];
    ex_scene scene;
    ex_gbuffer one, more;
    (void)state;
    assert_int_equal(ex_scene_builtin(&scene, "plant", 0, error), 0);
    ex_scene_default_camera(&scene, 160, 90);
    render(&one, &scene, 160, 90, 2, 1);
    size_t count = (size_t)one.width * one.height, seen = 0;
    for (size_t i = 0; i < count; i++)
        if (one.pixels[i].object != UINT32_MAX) { check_pixel(&one.pixels[i], &scene.camera); seen++; }
    assert_true(seen > count / 20);
    for (int threads = 2; threads <= 5; threads++) {
        render(&more, &scene, 160, 90, 2, threads);
        assert_memory_equal(one.pixels, more.pixels, count * sizeof *one.pixels);
        ex_gbuffer_free(&more);
    }
    ex_gbuffer_free(&one);
    ex_scene_free(&scene);
}

static void raster_keeps_the_sides_of_emission_and_mirrored_objects(void **state)
{
    float corners[9] = {-9, -9, -1, 9, -9, -1, 0, 9, -1};
    uint32_t indices[3] = {0, 1, 2};
    small_scene *s = (small_scene *)malloc(sizeof *s);
    (void)state;
    /* Front seen from +Z; mirrored by x, the winding turns but the front stays; seen from behind, one-sided is dark. */
    for (int test = 0; test < 8; test++) {
        int mirrored = test & 1, behind = test >> 1 & 1, both = test >> 2 & 1;
        ex_gbuffer g;
        set_up(s, corners, 3, indices, 1);
        s->material.emission[1] = 2;
        s->material.double_sided = both;
        if (mirrored) s->object.transform[0] = -1;
        if (behind) { s->scene.camera.eye[2] = -2; s->scene.camera.target[2] = 0; }
        render(&g, &s->scene, 3, 3, 1, 1);
        const ex_pixel *p = &g.pixels[4];
        assert_int_equal(p->object, 0);
        check_pixel(p, &s->scene.camera);
        assert_near(p->normal[2], behind ? -1 : 1, 1e-6);
        assert_near(p->geometric[2], behind ? -1 : 1, 1e-6);
        assert_near(p->emission[1], behind && !both ? 0 : 2, 0);
        assert_near(p->position[2], -1, 1e-6);
        assert_near(p->albedo[0], 0.5, 0);
        ex_gbuffer_free(&g);
    }
    free(s);
}

static void raster_cuts_holes_of_alpha_masks(void **state)
{
    float corners[12] = {-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1}, uvs[8] = {0, 1, 1, 1, 1, 0, 0, 0};
    uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    uint8_t texels[16] = {255, 0, 0, 255,  0, 255, 0, 255,  0, 0, 255, 255,  255, 255, 255, 0};
    ex_texture texture = {2, 2, texels};
    small_scene *s = (small_scene *)malloc(sizeof *s);
    ex_gbuffer g;
    (void)state;
    set_up(s, corners, 4, indices, 2);
    s->mesh.uvs = uvs;
    s->scene.textures = &texture;
    s->scene.texture_count = 1;
    s->material.base_texture = 0;
    s->material.alpha_cutoff = 0.5f;
    render(&g, &s->scene, 2, 2, 1, 1);       /* pixel centres are texel centres: u right, v down */
    assert_near(g.pixels[0].albedo[0], 0.5, 1e-6);
    assert_near(g.pixels[0].albedo[1], 0, 1e-6);
    assert_near(g.pixels[1].albedo[1], 0.5, 1e-6);
    assert_near(g.pixels[2].albedo[2], 0.5, 1e-6);
    assert_int_equal(g.pixels[3].object, UINT32_MAX);
    ex_gbuffer_free(&g);
    free(s);
}

/* Pictures from within and from far away, wide and narrow, down to one pixel. */
static void raster_by_clusters_is_the_same(void **state)
{
    static const char *const names[2] = {"cornell", "plant"};
    char error[EX_ERROR_SIZE];
    (void)state;
    for (int s = 0; s < 2; s++) {
        ex_scene scene;
        ex_clusters *clusters;
        float center[3], radius;
        size_t seen = 0;
        assert_int_equal(ex_scene_builtin(&scene, names[s], 0, error), 0);
        assert_int_equal(ex_scene_bounds(&scene, center, &radius), 0);
        clusters = ex_clusters_build(&scene);
        assert_non_null(clusters);
        for (int i = 0; i < 60; i++) {
            ex_gbuffer a, b;
            uint32_t side = 1u << (i % 7);
            float far = i % 3 == 0 ? 1000 : i % 3 == 1 ? 0.4f : 2;
            for (int k = 0; k < 3; k++) {
                scene.camera.eye[k] = center[k] + radius * far * sinf((float)(7 * i + 3 * k));
                scene.camera.target[k] = center[k] + 0.3f * radius * cosf((float)(5 * i + k));
            }
            scene.camera.fovy = i % 3 == 0 ? 0.002f : i % 2 ? 1.57f : 0.3f;
            assert_int_equal(ex_gbuffer_render(&a, &scene, side, side, 1, 1, error), 0);
            assert_int_equal(ex_gbuffer_render_clusters(&b, &scene, clusters, side, side, 2, error), 0);
            assert_memory_equal(a.pixels, b.pixels, side * side * sizeof *a.pixels);
            for (uint32_t k = 0; k < side * side; k++) seen += a.pixels[k].object != UINT32_MAX;
            ex_gbuffer_free(&a);
            ex_gbuffer_free(&b);
        }
        assert_true(seen > 10000);
        ex_clusters_free(clusters);
        ex_scene_free(&scene);
    }
    ex_clusters_free(NULL);
}

/* From where a sun's picture is taken, a thousand radii away, a place is as exact as from near by: on its surface, and
   on the ray of its pixel. */
static void raster_from_far_away_is_exact(void **state)
{
    enum { SIDE = 101 };
    float corners[12];
    uint32_t indices[6] = {0, 1, 3, 0, 3, 2};
    const double away[3] = {0.48, 0.64, 0.6}, right[3] = {0.8, 0, -0.64}, half = 1.2;
    const double width = sqrt(0.8 * 0.8 + 0.64 * 0.64), distance = 1000;
    small_scene *s = (small_scene *)malloc(sizeof *s);
    ex_gbuffer g;
    int shown = 0;
    (void)state;
    for (int i = 0; i < 4; i++) {                       /* z = 0.3 x + 0.2 y */
        corners[3 * i] = i & 1 ? 1 : -1;
        corners[3 * i + 1] = i & 2 ? 1 : -1;
        corners[3 * i + 2] = 0.3f * corners[3 * i] + 0.2f * corners[3 * i + 1];
    }
    set_up(s, corners, 4, indices, 2);
    for (int k = 0; k < 3; k++) {
        s->scene.camera.eye[k] = (float)(distance * away[k]);
        s->scene.camera.target[k] = 0;
    }
    s->scene.camera.fovy = (float)(2 * atan(half / distance));
    render(&g, &s->scene, SIDE, SIDE, 1, 2);
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
            const ex_pixel *p = &g.pixels[SIDE * y + x];
            double across = (2 * (x + 0.5) / SIDE - 1) * half, along = distance, at = 0;
            if (p->object == UINT32_MAX) continue;
            shown++;
            assert_near(p->position[2], 0.3 * (double)p->position[0] + 0.2 * (double)p->position[1], 1e-6);
            for (int k = 0; k < 3; k++) {
                at += (double)p->position[k] * right[k] / width;
                along -= (double)p->position[k] * away[k];
            }
            assert_near(at, across * along / distance, 1e-5);       /* of a pixel of 0.024 */
        }
    assert_true(shown > SIDE * SIDE / 5);
    ex_gbuffer_free(&g);
    free(s);
}

static void raster_refuses_bad_cameras_and_sizes(void **state)
{
    float corners[9] = {-9, -9, -1, 9, -9, -1, 0, 9, -1};
    uint32_t indices[3] = {0, 1, 2};
    char error[EX_ERROR_SIZE];
    small_scene *s = (small_scene *)malloc(sizeof *s);
    ex_gbuffer g;
    (void)state;
    set_up(s, corners, 3, indices, 1);
    assert_int_equal(ex_gbuffer_render(&g, &s->scene, 0, 3, 1, 1, error), -1);
    assert_int_equal(ex_gbuffer_render(&g, &s->scene, 3, 3, 0, 1, error), -1);
    assert_int_equal(ex_gbuffer_render(&g, &s->scene, 30000, 3, 2, 1, error), -1);
    s->scene.camera.fovy = 0;
    assert_int_equal(ex_gbuffer_render(&g, &s->scene, 3, 3, 1, 1, error), -1);
    s->scene.camera.fovy = 1;
    s->scene.camera.eye[0] = NAN;
    assert_int_equal(ex_gbuffer_render(&g, &s->scene, 3, 3, 1, 1, error), -1);
    memcpy(s->scene.camera.eye, s->scene.camera.target, 12);
    assert_int_equal(ex_gbuffer_render(&g, &s->scene, 3, 3, 1, 1, error), -1);
    assert_null(g.pixels);
    s->scene.camera.eye[2] = 0;
    s->scene.camera.up[1] = 0;               /* up along the view is no error: any up will do */
    s->scene.camera.up[2] = 1;
    render(&g, &s->scene, 3, 3, 1, 1);
    assert_int_equal(g.pixels[4].object, 0);
    ex_gbuffer_free(&g);
    s->scene.object_count = 0;               /* nothing to see is no error either */
    render(&g, &s->scene, 3, 3, 1, 1);
    assert_int_equal(g.pixels[4].object, UINT32_MAX);
    ex_gbuffer_free(&g);
    free(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(raster_inside_a_box_hits_its_walls),
        cmocka_unit_test(raster_has_no_cracks),
        cmocka_unit_test(raster_gives_shared_edges_to_one_side),
        cmocka_unit_test(raster_is_the_same_on_any_number_of_threads),
        cmocka_unit_test(raster_keeps_the_sides_of_emission_and_mirrored_objects),
        cmocka_unit_test(raster_cuts_holes_of_alpha_masks),
        cmocka_unit_test(raster_by_clusters_is_the_same),
        cmocka_unit_test(raster_from_far_away_is_exact),
        cmocka_unit_test(raster_refuses_bad_cameras_and_sizes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
