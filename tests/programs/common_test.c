/* common_test.c - examples/common: threads, images, skies, scenes by code. */
#define _POSIX_C_SOURCE 200809L
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
#include <unistd.h>

#define assert_near(a, b, tolerance) assert_true(fabs((double)(a) - (double)(b)) <= (tolerance))

static const double pi = 3.14159265358979323846;

/* ---- files in a folder of our own ---- */

static char folder[64], path_buffer[128];

static const char *in_folder(const char *name)
{
    snprintf(path_buffer, sizeof path_buffer, "%s/%s", folder, name);
    return path_buffer;
}

static int make_folder(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/dapple_common_XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    static const char *const names[] = {"a.pfm", "a.png", "a.hdr"};
    (void)state;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) unlink(in_folder(names[i]));
    return rmdir(folder);
}

static void write_bytes(const char *name, const void *bytes, size_t count)
{
    FILE *file = fopen(in_folder(name), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, count, file), count);
    assert_int_equal(fclose(file), 0);
}

static void check_error(const char *error)
{
    assert_true(strlen(error) > 0 && strlen(error) < EX_ERROR_SIZE);
    assert_null(strchr(error, '\n'));
}

/* ---- threads ---- */

typedef struct tally { int *visits; ex_pool *pool; } tally;

static void visit_once(void *context, size_t i) { ((tally *)context)->visits[i]++; }

static void visit_nested(void *context, size_t i)
{
    tally *t = (tally *)context, inner = {t->visits + 100 * i, NULL};
    ex_pool_run(t->pool, 100, visit_once, &inner);
}

static void pool_runs_every_index_once(void **state)
{
    (void)state;
    for (int threads = 0; threads <= 5; threads++) {
        ex_pool *pool = ex_pool_create(threads);
        assert_non_null(pool);
        assert_true(ex_pool_threads(pool) >= 1);
        if (threads > 0) assert_true(ex_pool_threads(pool) <= threads);
        for (size_t count = 0; count <= 20000; count = 7 * count + 1) {
            tally t = {(int *)calloc(count + 1, sizeof(int)), pool};
            ex_pool_run(pool, count, visit_once, &t);
            for (size_t i = 0; i < count; i++) assert_int_equal(t.visits[i], 1);
            assert_int_equal(t.visits[count], 0);
            free(t.visits);
        }
        tally nested = {(int *)calloc(10000, sizeof(int)), pool};
        ex_pool_run(pool, 100, visit_nested, &nested);
        for (int i = 0; i < 10000; i++) assert_int_equal(nested.visits[i], 1);
        free(nested.visits);
        ex_pool_free(pool);
    }
    tally alone = {(int *)calloc(10, sizeof(int)), NULL};
    ex_pool_run(NULL, 10, visit_once, &alone);
    for (int i = 0; i < 10; i++) assert_int_equal(alone.visits[i], 1);
    free(alone.visits);
    ex_pool_free(NULL);
}

static void seconds_run_forward(void **state)
{
    (void)state;
    double before = ex_seconds();
    assert_true(ex_seconds() >= before);
    assert_int_equal(ex_progress("test", 0.5f), 0);
}

/* ---- images ---- */

static void pfm_round_trip_keeps_bits(void **state)
{
    char error[EX_ERROR_SIZE];
    ex_image a, b;
    (void)state;
    assert_int_equal(ex_image_alloc(&a, 5, 3), 0);
    for (int i = 0; i < 45; i++) a.rgb[i] = (float)i * 1.7f - 9;
    a.rgb[3] = INFINITY;
    a.rgb[4] = 1e-42f;
    assert_int_equal(ex_image_write(&a, in_folder("a.pfm"), 3, error), 0);
    assert_int_equal(ex_image_read_pfm(&b, in_folder("a.pfm"), error), 0);
    assert_int_equal(b.width, 5);
    assert_int_equal(b.height, 3);
    assert_memory_equal(a.rgb, b.rgb, 45 * sizeof(float));
    ex_image_free(&a);
    ex_image_free(&b);
}

static void pfm_stores_rows_from_the_bottom_up(void **state)
{
    static const uint8_t big_endian[] = "PF\n1 2\n1.0\n" "\x3f\x80\0\0" "\x40\0\0\0" "\x40\x40\0\0"
        "\0\0\0\0\0\0\0\0\0\0\0\0";
    char error[EX_ERROR_SIZE];
    ex_image image;
    (void)state;
    write_bytes("a.pfm", big_endian, sizeof big_endian - 1);
    assert_int_equal(ex_image_read_pfm(&image, in_folder("a.pfm"), error), 0);
    assert_true(image.rgb[0] == 0 && image.rgb[3] == 1 && image.rgb[4] == 2 && image.rgb[5] == 3);
    ex_image_free(&image);
}

static void broken_pfm_is_refused(void **state)
{
    static const char *const texts[] = {"", "PF", "PF\n1 1\n-1.0\n123", "Pf\n1 1\n-1.0\n1234", "PF\n0 1\n-1.0\n",
        "PF\n1 1\n0\n123456789012",
                                        "PF\n999999999 999999999\n-1.0\n", "PF\n-1 1\n-1.0\n123456789012",
                                            "PF\n1 1\nnan\n123456789012"};
    char error[EX_ERROR_SIZE];
    ex_image image;
    (void)state;
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        write_bytes("a.pfm", texts[i], strlen(texts[i]));
        assert_int_equal(ex_image_read_pfm(&image, in_folder("a.pfm"), error), -1);
        check_error(error);
        assert_null(image.rgb);
    }
    assert_int_equal(ex_image_read_pfm(&image, in_folder("missing.pfm"), error), -1);
}

static void png_is_written_and_bad_names_are_refused(void **state)
{
    char error[EX_ERROR_SIZE];
    uint8_t head[24];
    ex_image image;
    (void)state;
    assert_int_equal(ex_image_alloc(&image, 70, 400), 0);       /* more than one stored block */
    for (int i = 0; i < 70 * 400 * 3; i++) image.rgb[i] = (float)(i % 101) / 100;
    image.rgb[0] = NAN;
    image.rgb[1] = -INFINITY;
    assert_int_equal(ex_image_write(&image, in_folder("a.png"), 0, error), 0);
    FILE *file = fopen(in_folder("a.png"), "rb");
    assert_non_null(file);
    assert_int_equal(fread(head, 1, 24, file), 24);
    fclose(file);
    assert_memory_equal(head, "\x89PNG\r\n\x1a\n", 8);
    assert_true(head[19] == 70 && head[22] == 1 && head[23] == 144);
    assert_int_equal(ex_image_write(&image, in_folder("a.jpg"), 0, error), -1);
    check_error(error);
    assert_int_equal(ex_image_write(&image, "/nonexistent/a.png", 0, error), -1);
    assert_int_equal(ex_image_write(&image, "/nonexistent/a.pfm", 0, error), -1);
    ex_image_free(&image);
    assert_int_equal(ex_image_write(&image, in_folder("a.png"), 0, error), -1);
    assert_int_equal(ex_image_alloc(&image, 0, 4), -1);
    assert_int_equal(ex_image_alloc(&image, 1u << 20, 1u << 20), -1);
}

static void automatic_exposure_brings_the_98th_percentile_to_0_9(void **state)
{
    ex_image image;
    (void)state;
    assert_int_equal(ex_image_alloc(&image, 100, 2), 0);
    assert_near(ex_image_auto_ev(&image), 0, 0);
    for (int i = 0; i < 101; i++)            /* 99 pixels stay black and do not count */
        for (int k = 0; k < 3; k++) image.rgb[3 * i + k] = (float)(i + 1);
    assert_near(pow(2, (double)ex_image_auto_ev(&image)) * 99, 0.9, 1e-5);
    ex_image_free(&image);
}

/* ---- skies ---- */

static void sky_directions_follow_the_convention(void **state)
{
    static const float expected[5][5] = {{4, 2, 1, 0, 0}, {6, 2, 0, 0, 1}, {2, 2, 0, 0, -1}, {0, 2, -1, 0, 0}, {3, 0, 0,
        1, 0}};
    float d[3];
    (void)state;
    for (int i = 0; i < 5; i++) {            /* +X in the centre, +Z right of it, +Y above row 0 */
        ex_sky_texel_direction(8, 4, expected[i][0], expected[i][1], d);
        for (int k = 0; k < 3; k++) assert_near(d[k], expected[i][2 + k], 1e-6);
    }
}

static void sky_lookup_returns_the_texel_at_its_centre(void **state)
{
    float rgb[3 * 8 * 4], d[3], got[3];
    ex_sky sky = {8, 4, rgb, 0};
    (void)state;
    for (int i = 0; i < 3 * 8 * 4; i++) rgb[i] = (float)i;
    for (uint32_t y = 0; y < 4; y++)
        for (uint32_t x = 0; x < 8; x++) {
            ex_sky_texel_direction(8, 4, (float)x + 0.5f, (float)y + 0.5f, d);
            ex_sky_radiance(&sky, d, got);
            for (uint32_t k = 0; k < 3; k++) assert_near(got[k], rgb[3 * (8 * y + x) + k], 2e-4);
        }
    /* Turned by 90 degrees about +Y, what was seen along +Z is seen along +X. */
    float z[3] = {0, 0, 1}, x[3] = {1, 0, 0}, before[3];
    ex_sky_radiance(&sky, z, before);
    sky.rotation = (float)(pi / 2);
    ex_sky_radiance(&sky, x, got);
    for (int k = 0; k < 3; k++) assert_near(got[k], before[k], 1e-4);
    sky.width = 0;
    ex_sky_radiance(&sky, x, got);
    assert_true(got[0] == 0);
}

/* Irradiance on the ground by exact solid angles of the rows. */
static double ground_irradiance(const ex_sky *sky, int channel)
{
    double sum = 0;
    for (uint32_t y = 0; y < sky->height / 2; y++) {
        double a = cos(pi * y / sky->height), b = cos(pi * (y + 1) / sky->height);
        for (uint32_t x = 0; x < sky->width; x++)
            sum += (double)sky->rgb[3 * (y * (size_t)sky->width + x) + (size_t)channel] * (a * a - b * b);
    }
    return sum * pi / sky->width;
}

static void built_in_skies_have_their_energy(void **state)
{
    char error[EX_ERROR_SIZE];
    ex_sky sky;
    (void)state;
    for (int i = 0; ex_sky_names()[i]; i++) {
        assert_int_equal(ex_sky_builtin(&sky, ex_sky_names()[i], error), 0);
        for (size_t k = 0; k < 3 * (size_t)sky.width * sky.height; k++)
            assert_true(sky.rgb[k] >= 0 && isfinite(sky.rgb[k]));
        double e = ground_irradiance(&sky, 1);
        if (strcmp(ex_sky_names()[i], "uniform") == 0) assert_near(e, pi, 1e-4);
        if (strcmp(ex_sky_names()[i], "overcast") == 0) assert_near(e, 7 * pi / 9, 1e-3);
        assert_true(e > 0.5 && e < 5);
        ex_sky_free(&sky);
    }
    assert_int_equal(ex_sky_builtin(&sky, "nonsense", error), -1);
    check_error(error);
    assert_int_equal(ex_sky_load(&sky, in_folder("missing.hdr"), error), -1);
    check_error(error);
    assert_null(sky.rgb);
}

/* A 2 x 1 map in flat RGBE: (1, 0.5, 0) and black. */
static void hdr_files_load(void **state)
{
    static const char text[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x40\0\x81\0\0\0\0";
    char error[EX_ERROR_SIZE];
    ex_sky sky;
    (void)state;
    write_bytes("a.hdr", text, sizeof text - 1);
    int result = ex_sky_load(&sky, in_folder("a.hdr"), error);
    if (result != 0 && strstr(error, "without stb")) skip();
    assert_int_equal(result, 0);
    assert_int_equal(sky.width, 2);
    assert_near(sky.rgb[0], 1, 1e-6);
    assert_near(sky.rgb[1], 0.5, 1e-6);
    assert_near(sky.rgb[5], 0, 0);
    ex_sky_free(&sky);
    write_bytes("a.hdr", text, 40);
    assert_int_equal(ex_sky_load(&sky, in_folder("a.hdr"), error), -1);
    check_error(error);
}

/* Rows of run lengths: a whole file of two rows is read. With any byte missing at its end it is refused, and so are
   runs of no texel, runs beyond the row, and a size that would take more than the limit. */
static void damaged_hdr_files_are_refused(void **state)
{
    static const char head[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 8\n";
    static const char row[] = "\2\2\0\10" "\210\100" "\210\40" "\4\1\2\3\4\204\5" "\210\201";
    static const char *const broken[] = { "\2\2\0\10\0\0\0\0\0\0",
                                          "\2\2\0\10\211\100\210\40\210\5\210\201",
                                          "\2\2\0\11\210\100\210\40\210\5\210\201" };
    static const char *const sizes[] = { "-Y 100000 +X 100000", "-Y 0 +X 8", "-Y 8 -X 8", "-Y 4096 +X 8192" };
    char text[200], error[EX_ERROR_SIZE];
    size_t length = sizeof head - 1, all = length + 2 * (sizeof row - 1);
    ex_sky sky;
    (void)state;
    memcpy(text, head, length);
    memcpy(text + length, row, sizeof row - 1);
    memcpy(text + length + sizeof row - 1, row, sizeof row - 1);
    write_bytes("a.hdr", text, all);
    if (ex_sky_load(&sky, in_folder("a.hdr"), error) != 0 && strstr(error, "without stb")) skip();
    assert_int_equal(sky.height, 2);
    assert_near(sky.rgb[3 * 8], 0.5, 1e-6);
    assert_near(sky.rgb[3 * 10 + 2], 3 / 128.0, 1e-6);
    ex_sky_free(&sky);
    for (size_t cut = length - 3; cut < all; cut++) {
        write_bytes("a.hdr", text, cut);
        assert_int_equal(ex_sky_load(&sky, in_folder("a.hdr"), error), -1);
        check_error(error);
        assert_null(sky.rgb);
    }
    for (size_t i = 0; i < sizeof broken / sizeof *broken; i++) {
        memcpy(text + length, broken[i], 10);
        write_bytes("a.hdr", text, all);
        assert_int_equal(ex_sky_load(&sky, in_folder("a.hdr"), error), -1);
        assert_non_null(strstr(error, "damaged"));
    }
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        int count = snprintf(text, sizeof text, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n%s\n", sizes[i]);
        write_bytes("a.hdr", text, (size_t)count);
        assert_int_equal(ex_sky_load(&sky, in_folder("a.hdr"), error), -1);
        assert_non_null(strstr(error, i == 0 || i == 3 ? "--limit-memory" : "no line -Y"));
    }
}

/* ---- scenes by code ---- */

typedef struct edge { float p[2][3]; int direction; } edge;

static int compare_edges(const void *a, const void *b)
{
    const edge *x = (const edge *)a, *y = (const edge *)b;
    for (int k = 0; k < 6; k++)
        if (x->p[k / 3][k % 3] != y->p[k / 3][k % 3]) return x->p[k / 3][k % 3] < y->p[k / 3][k % 3] ? -1 : 1;
    return 0;
}

static int point_less(const float *p, const float *q)
{
    for (int k = 0; k < 3; k++)
        if (p[k] != q[k]) return p[k] < q[k];
    return 0;
}

/* Open edges of the triangles with single-sided materials, or of all; welded by position, each edge must be passed as
   often one way as the other. */
static size_t open_edges(const ex_scene *scene, const ex_mesh *mesh, int all)
{
    size_t count = 0, open = 0;
    edge *edges = (edge *)malloc(3 * (size_t)mesh->triangle_count * sizeof *edges);
    for (uint32_t t = 0; t < mesh->triangle_count; t++)
        for (uint32_t k = 0; (all || !scene->materials[mesh->materials[t]].double_sided) && k < 3; k++) {
            const float *p = mesh->positions + 3 * mesh->indices[3 * t + k];
            const float *q = mesh->positions + 3 * mesh->indices[3 * t + (k + 1) % 3];
            int turned = point_less(q, p);
            memcpy(edges[count].p[0], turned ? q : p, 12);
            memcpy(edges[count].p[1], turned ? p : q, 12);
            edges[count++].direction = turned ? -1 : 1;
        }
    qsort(edges, count, sizeof *edges, compare_edges);
    for (size_t i = 0, next; i < count; i = next) {
        int balance = 0;
        for (next = i; next < count && compare_edges(&edges[i], &edges[next]) == 0; next++)
            balance += edges[next].direction;
        open += balance != 0 || next - i != 2;
    }
    free(edges);
    return open;
}

static void cross_of(const ex_mesh *mesh, uint32_t t, double n[3], const float *corner[3])
{
    double u[3], v[3];
    for (int k = 0; k < 3; k++) corner[k] = mesh->positions + 3 * mesh->indices[3 * t + (uint32_t)k];
    for (int k = 0; k < 3; k++) {
        u[k] = (double)corner[1][k] - (double)corner[0][k];
        v[k] = (double)corner[2][k] - (double)corner[0][k];
    }
    for (int k = 0; k < 3; k++) n[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
}

static double volume_of(const ex_mesh *mesh)
{
    double sum = 0, n[3];
    const float *c[3];
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        cross_of(mesh, t, n, c);
        for (int k = 0; k < 3; k++) sum += n[k] * (double)c[0][k] / 6;
    }
    return sum;
}

/* Indices in range, finite positions, unit normals that do not contradict the winding. A mesh that deforms cannot split
   its vertices where a crease forms for a moment: there, one corner in three hundred may. */
static void check_mesh(const ex_scene *scene, const ex_mesh *mesh)
{
    size_t contrary = 0;
    assert_true(mesh->triangle_count > 0);
    for (uint32_t i = 0; i < 3 * mesh->vertex_count; i++) assert_true(isfinite(mesh->positions[i]));
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        const float *n = mesh->normals + 3 * i;
        assert_near(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1, 1e-5);
    }
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        double n[3];
        const float *c[3];
        assert_true(mesh->materials[t] < scene->material_count);
        for (uint32_t k = 0; k < 3; k++) assert_true(mesh->indices[3 * t + k] < mesh->vertex_count);
        cross_of(mesh, t, n, c);
        for (uint32_t k = 0; k < 3; k++) {
            const float *normal = mesh->normals + 3 * mesh->indices[3 * t + k];
            contrary += n[0] * (double)normal[0] + n[1] * (double)normal[1] + n[2] * (double)normal[2] <= 0;
        }
    }
    if (contrary > (mesh->deforms ? mesh->triangle_count / 100 : 0))
        fail_msg("%u of %u corners contradict", (unsigned)contrary, (unsigned)mesh->triangle_count * 3);
}

static void load_builtin(ex_scene *scene, const char *name)
{
    char error[EX_ERROR_SIZE];
    assert_int_equal(ex_scene_builtin(scene, name, 0, error), 0);
    assert_int_equal(scene->skipped_triangles, 0);
}

static void every_built_in_scene_is_sound(void **state)
{
    char error[EX_ERROR_SIZE];
    ex_scene scene;
    (void)state;
    for (int i = 0; ex_scene_names()[i]; i++) {
        load_builtin(&scene, ex_scene_names()[i]);
        for (uint32_t m = 0; m < scene.mesh_count; m++) check_mesh(&scene, &scene.meshes[m]);
        for (uint32_t o = 0; o < scene.object_count; o++) {
            assert_true(scene.objects[o].mesh < scene.mesh_count);
            assert_true(strlen(scene.objects[o].name) > 0);
        }
        for (uint32_t m = 0; m < scene.material_count; m++)
            for (int k = 0; k < 3; k++) {
                float c = scene.materials[m].base_color[k];
                assert_true(c > 0 && c < 0.9f);
            }
        ex_scene_free(&scene);
    }
    assert_int_equal(ex_scene_builtin(&scene, "nonsense", 0, error), -1);
    check_error(error);
    assert_int_equal(scene.mesh_count, 0);
}

static void closed_meshes_are_closed_and_face_outwards(void **state)
{
    static const char *const closed[] = {"short block", "tall block", "knot", "board", "pawn", "rook", "knight",
        "bishop",
                                         "queen", "king"};
    int seen = 0;
    (void)state;
    for (int i = 0; ex_scene_names()[i]; i++) {
        ex_scene scene;
        load_builtin(&scene, ex_scene_names()[i]);
        for (uint32_t o = 0; o < scene.object_count; o++)
            for (size_t k = 0; k < sizeof closed / sizeof *closed; k++)
                if (strstr(scene.objects[o].name, closed[k])) {
                    const ex_mesh *mesh = &scene.meshes[scene.objects[o].mesh];
                    if (open_edges(&scene, mesh, 1)) fail_msg("%s is open", scene.objects[o].name);
                    assert_true(volume_of(mesh) > 0);
                    seen++;
                }
        ex_scene_free(&scene);
    }
    assert_int_equal(seen, 2 + 1 + 1 + 32);
}

static void knot_is_a_tube_of_the_right_volume(void **state)
{
    ex_scene scene;
    double length = 0, s = 1 / 3.46, previous[3] = {3 * s, 0, 0};
    float center[3], radius;
    (void)state;
    load_builtin(&scene, "knot");
    assert_int_equal(ex_scene_triangles(&scene), 49920);
    for (int i = 1; i <= 100000; i++) {
        double t = 2 * pi * i / 100000, q = s * (2 + cos(3 * t)), p[3] = {q * cos(2 * t), q * sin(2 * t),
            s * sin(3 * t)};
        length += sqrt(pow(p[0] - previous[0], 2) + pow(p[1] - previous[1], 2) + pow(p[2] - previous[2], 2));
        memcpy(previous, p, sizeof p);
    }
    double exact = pi * pow(0.46 * s, 2) * length;      /* Pappus; 48 sides enclose 0.3 % less */
    assert_near(volume_of(&scene.meshes[0]) / exact, 0.997, 0.002);
    assert_int_equal(ex_scene_bounds(&scene, center, &radius), 0);
    assert_true(radius > 0.9f && radius < 1.15f);
    ex_scene_free(&scene);
    char error[EX_ERROR_SIZE];
    assert_int_equal(ex_scene_builtin(&scene, "knot", 3, error), 0);        /* three seconds later: a quarter turn */
    assert_true(scene.animated);
    assert_near(scene.objects[0].transform[0], 0, 1e-6);
    assert_near(scene.objects[0].transform[8], 1, 1e-6);
    ex_scene_free(&scene);
}

static void cornell_box_has_the_measured_size(void **state)
{
    ex_scene scene;
    float low[3] = {1, 1, 1}, high[3] = {-1, -1, -1};
    (void)state;
    load_builtin(&scene, "cornell");
    for (uint32_t m = 0; m < scene.mesh_count; m++)
        for (uint32_t i = 0; i < 3 * scene.meshes[m].vertex_count; i++) {
            float p = scene.meshes[m].positions[i];
            low[i % 3] = fminf(low[i % 3], p);
            high[i % 3] = fmaxf(high[i % 3], p);
        }
    for (int k = 0; k < 3; k++) assert_near(low[k], 0, 0);
    assert_near(high[0], 0.5560, 1e-6);
    assert_near(high[1], 0.5488, 1e-6);
    assert_near(high[2], 0.5592, 1e-6);
    assert_true(ex_scene_has_emitters(&scene) && scene.has_camera);
    const ex_mesh *lamp = &scene.meshes[scene.objects[scene.object_count - 1].mesh];
    double n[3], area = 0;
    const float *c[3];
    for (uint32_t t = 0; t < 2; t++) {
        cross_of(lamp, t, n, c);
        area -= 0.5 * n[1];                  /* it faces down */
    }
    assert_near(area, 0.130 * 0.105, 1e-8);
    ex_scene_free(&scene);
}

static void plant_opens_only_at_its_leaves(void **state)
{
    ex_scene scene;
    (void)state;
    load_builtin(&scene, "plant");
    assert_true(ex_scene_triangles(&scene) > 10000 && ex_scene_triangles(&scene) < 60000);
    assert_int_equal(open_edges(&scene, &scene.meshes[0], 0), 0);
    assert_true(open_edges(&scene, &scene.meshes[0], 1) > 1000);
    ex_scene_free(&scene);
}

static void ground_lies_under_the_scene_and_outside_its_bounds(void **state)
{
    ex_scene scene;
    float before[3], after[3], radius, radius_after;
    (void)state;
    load_builtin(&scene, "knot");
    assert_int_equal(ex_scene_bounds(&scene, before, &radius), 0);
    assert_int_equal(ex_scene_add_ground(&scene), 0);
    assert_int_equal(ex_scene_bounds(&scene, after, &radius_after), 0);
    assert_memory_equal(before, after, sizeof before);
    assert_true(radius == radius_after);
    const ex_object *ground = &scene.objects[scene.object_count - 1];
    const ex_mesh *mesh = &scene.meshes[ground->mesh];
    assert_true(ground->receiver_only);
    assert_true(mesh->normals[1] == 1);
    assert_near(scene.materials[mesh->materials[0]].base_color[1], 0.5, 0);
    float lowest = 1;
    for (uint32_t i = 0; i < scene.meshes[0].vertex_count; i++)
        lowest = fminf(lowest, scene.meshes[0].positions[3 * i + 1]);
    assert_near(ground->transform[13], lowest, 1e-6);
    ex_scene_free(&scene);
    memset(&scene, 0, sizeof scene);
    assert_int_equal(ex_scene_add_ground(&scene), -1);
}

static void default_camera_shows_the_sphere_on_85_percent(void **state)
{
    static const uint32_t sizes[3][2] = {{640, 360}, {360, 640}, {300, 300}};
    ex_scene scene;
    float center[3], radius;
    (void)state;
    load_builtin(&scene, "knot");
    assert_int_equal(ex_scene_bounds(&scene, center, &radius), 0);
    for (int i = 0; i < 3; i++) {
        ex_scene_default_camera(&scene, sizes[i][0], sizes[i][1]);
        const ex_camera *camera = &scene.camera;
        double d[3], distance = 0, shorter = sizes[i][0] < sizes[i][1] ? (double)sizes[i][0] / sizes[i][1] : 1;
        for (int k = 0; k < 3; k++) {
            assert_near(camera->target[k], center[k], 1e-6);
            d[k] = (double)camera->eye[k] - (double)center[k];
            distance += d[k] * d[k];
        }
        distance = sqrt(distance);
        assert_near((double)camera->fovy * 180 / pi, 40, 1e-4);
        assert_near(asin(d[1] / distance) * 180 / pi, 20, 1e-3);
        assert_near(atan2(d[0], d[2]) * 180 / pi, 30, 1e-3);
        assert_near(tan(asin((double)radius / distance)) / (shorter * tan(20 * pi / 180)), 0.85, 1e-4);
    }
    ex_scene_free(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pool_runs_every_index_once),
        cmocka_unit_test(seconds_run_forward),
        cmocka_unit_test(pfm_round_trip_keeps_bits),
        cmocka_unit_test(pfm_stores_rows_from_the_bottom_up),
        cmocka_unit_test(broken_pfm_is_refused),
        cmocka_unit_test(png_is_written_and_bad_names_are_refused),
        cmocka_unit_test(automatic_exposure_brings_the_98th_percentile_to_0_9),
        cmocka_unit_test(sky_directions_follow_the_convention),
        cmocka_unit_test(sky_lookup_returns_the_texel_at_its_centre),
        cmocka_unit_test(built_in_skies_have_their_energy),
        cmocka_unit_test(hdr_files_load),
        cmocka_unit_test(damaged_hdr_files_are_refused),
        cmocka_unit_test(every_built_in_scene_is_sound),
        cmocka_unit_test(closed_meshes_are_closed_and_face_outwards),
        cmocka_unit_test(knot_is_a_tube_of_the_right_volume),
        cmocka_unit_test(cornell_box_has_the_measured_size),
        cmocka_unit_test(plant_opens_only_at_its_leaves),
        cmocka_unit_test(ground_lies_under_the_scene_and_outside_its_bounds),
        cmocka_unit_test(default_camera_shows_the_sphere_on_85_percent),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
