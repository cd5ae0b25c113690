/* common_scenes_test.c - examples/common: the shapes of the mesh builder, and the larger built-in scenes. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "internal.h"
#include <stdlib.h>
#include <string.h>

#define assert_near(a, b, tolerance) assert_true(fabs((double)(a) - (double)(b)) <= (tolerance))

static const double pi = 3.14159265358979323846;

/* ---- closed or not: welded by position, each edge must be passed as often one way as the other ---- */

typedef struct edge { float p[2][3]; int direction; } edge;

static int compare_points(const float *p, const float *q)
{
    for (int k = 0; k < 3; k++)
        if (p[k] != q[k]) return p[k] < q[k] ? -1 : 1;
    return 0;
}

static int compare_edges(const void *a, const void *b)
{
    const edge *x = (const edge *)a, *y = (const edge *)b;
    int first = compare_points(x->p[0], y->p[0]);
    return first ? first : compare_points(x->p[1], y->p[1]);
}

typedef struct edge_counts { size_t open, shared; } edge_counts;   /* shared: by more than two triangles */

static edge_counts count_edges(const ex_mesh *mesh)
{
    size_t count = 0;
    edge_counts result = {0, 0};
    edge *edges = (edge *)malloc(3 * (size_t)mesh->triangle_count * sizeof *edges);
    assert_non_null(edges);
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (size_t k = 0; k < 3; k++) {
            const float *p = mesh->positions + 3 * (size_t)mesh->indices[3 * t + k];
            const float *q = mesh->positions + 3 * (size_t)mesh->indices[3 * t + (k + 1) % 3];
            int turned = compare_points(q, p) < 0;
            memcpy(edges[count].p[0], turned ? q : p, 12);
            memcpy(edges[count].p[1], turned ? p : q, 12);
            edges[count++].direction = turned ? -1 : 1;
        }
    qsort(edges, count, sizeof *edges, compare_edges);
    for (size_t i = 0, next; i < count; i = next) {
        int balance = 0;
        for (next = i; next < count && compare_edges(&edges[i], &edges[next]) == 0; next++)
            balance += edges[next].direction;
        result.open += balance != 0;
        result.shared += next - i > 2;
    }
    free(edges);
    return result;
}

static double volume_of(const ex_mesh *mesh)
{
    double sum = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const float *p[3];
        for (size_t k = 0; k < 3; k++) p[k] = mesh->positions + 3 * (size_t)mesh->indices[3 * t + k];
        for (int k = 0; k < 3; k++) {
            int l = (k + 1) % 3, m = (k + 2) % 3;
            double cross = (double)p[1][l] * (double)p[2][m] - (double)p[1][m] * (double)p[2][l];
            sum += (double)p[0][k] * cross / 6;
        }
    }
    return sum;
}

/* ---- pieces: what hangs together, welded by position ---- */

typedef struct welded { const float *p; uint32_t vertex; } welded;

static int compare_corners(const void *a, const void *b)
{
    return compare_points(((const welded *)a)->p, ((const welded *)b)->p);
}

static uint32_t root_of(uint32_t *parent, uint32_t i)
{
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

/* Pieces whose volume, seen from their first vertex, is not positive. */
static size_t pieces_inside_out(const ex_mesh *mesh)
{
    size_t n = mesh->vertex_count, bad = 0;
    welded *corners = (welded *)malloc(n * sizeof *corners);
    uint32_t *parent = (uint32_t *)malloc(n * sizeof *parent);
    double *volume = (double *)calloc(n, sizeof *volume);
    assert_true(corners && parent && volume);
    for (uint32_t i = 0; i < n; i++) {
        corners[i].p = mesh->positions + 3 * (size_t)i;
        parent[corners[i].vertex = i] = i;
    }
    qsort(corners, n, sizeof *corners, compare_corners);
    for (size_t i = 1; i < n; i++)
        if (compare_corners(&corners[i - 1], &corners[i]) == 0)
            parent[root_of(parent, corners[i].vertex)] = root_of(parent, corners[i - 1].vertex);
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (size_t k = 1; k < 3; k++)
            parent[root_of(parent, mesh->indices[3 * t + k])] = root_of(parent, mesh->indices[3 * t]);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        uint32_t piece = root_of(parent, mesh->indices[3 * t]);
        v3 p[3], origin = v3_load(mesh->positions + 3 * (size_t)piece);
        for (size_t k = 0; k < 3; k++)
            p[k] = v3_sub(v3_load(mesh->positions + 3 * (size_t)mesh->indices[3 * t + k]), origin);
        volume[piece] += (double)v3_dot(p[0], v3_cross(p[1], p[2]));
    }
    for (uint32_t i = 0; i < n; i++) bad += root_of(parent, i) == i && !(volume[i] > 0);
    free(corners);
    free(parent);
    free(volume);
    return bad;
}

/* ---- shapes ---- */

static ex_mesh *finish_shape(ex_builder *b)
{
    uint32_t mesh = ex_build_finish(b);
    assert_false(b->failed);
    return &b->scene->meshes[mesh];
}

static void shapes_are_closed_and_have_their_volume(void **state)
{
    static const float square[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    ex_scene scene;
    ex_builder b;
    (void)state;
    memset(&scene, 0, sizeof scene);
    b = ex_build_begin(&scene);
    ex_build_block(&b, v3_make(1, 2, 3), v3_make(3, 5, 7), 0.25f, 0);
    ex_mesh *mesh = finish_shape(&b);
    assert_int_equal(mesh->triangle_count, 44);
    assert_int_equal(count_edges(mesh).open, 0);
    /* Along each edge a prism of half a bevel squared is cut off; at a corner three of them share 2/3 bevel^3. */
    double cut = 4 * (2 + 3 + 4) * 0.5 * 0.25 * 0.25, overlap = volume_of(mesh) - (24 - cut);
    assert_near(overlap / 8, 0.25 * 0.25 * 0.25 * 2 / 3, 1e-4);
    ex_build_ball(&b, v3_make(1, 2, 3), v3_make(1, 2, 3), 128, 0);
    mesh = finish_shape(&b);
    assert_int_equal(count_edges(mesh).open, 0);
    assert_near(volume_of(mesh) / (4 * pi / 3 * 6), 0.9992, 0.0008);
    ex_build_prism(&b, square, 4, -1, 1, 0, 0);
    mesh = finish_shape(&b);
    assert_int_equal(count_edges(mesh).open, 0);
    assert_near(volume_of(mesh), 8, 1e-6);
    ex_build_prism(&b, square, 4, -1, 1, 0.1f, 0);
    mesh = finish_shape(&b);
    assert_int_equal(count_edges(mesh).open, 0);
    assert_true(volume_of(mesh) < 8 && volume_of(mesh) > 7.4);
    ex_scene_free(&scene);
}

static void transforms_keep_the_outside_outside(void **state)
{
    ex_scene scene;
    ex_builder b;
    float m[16];
    (void)state;
    memset(&scene, 0, sizeof scene);
    b = ex_build_begin(&scene);
    ex_build_block(&b, v3_make(-1, -1, -1), v3_make(1, 1, 1), 0.1f, 0);
    ex_mark first = {0, 0};
    ex_identity(m);
    m[0] = -2;                                   /* mirrored */
    m[12] = 5;
    ex_mark until = ex_build_mark(&b);
    double before = 8 - 4 * 6 * 0.5 * 0.01 + 8 * 0.001 * 2 / 3;
    ex_build_copy(&b, first, until, m);
    ex_mesh *mesh = finish_shape(&b);
    assert_int_equal(count_edges(mesh).open, 0);
    assert_near(volume_of(mesh), 3 * before, 1e-4);
    for (size_t t = 0; t < mesh->triangle_count; t++) {          /* flat faces: normals are the winding's */
        v3 p[3];
        for (size_t k = 0; k < 3; k++) p[k] = v3_load(mesh->positions + 3 * (size_t)mesh->indices[3 * t + k]);
        v3 n = v3_unit(v3_cross(v3_sub(p[1], p[0]), v3_sub(p[2], p[0])));
        assert_near(v3_dot(n, v3_load(mesh->normals + 3 * (size_t)mesh->indices[3 * t])), 1, 1e-5);
    }
    ex_build_block(&b, v3_make(2, 0, -1), v3_make(3, 1, 1), 0.1f, 0);
    ex_build_ring(&b, first, 4);
    mesh = finish_shape(&b);
    assert_int_equal(mesh->triangle_count, 4 * 44);
    double reach[4] = {0, 0, 0, 0};              /* +x, -x, +z, -z */
    for (size_t i = 0; i < mesh->vertex_count; i++)
        for (size_t k = 0; k < 4; k++)
            reach[k] = fmax(reach[k], (k % 2 ? -1 : 1) * (double)mesh->positions[3 * i + 2 * (k / 2)]);
    for (int k = 0; k < 4; k++) assert_near(reach[k], 3, 1e-5);
    ex_scene_free(&scene);
}

/* ---- scenes ---- */

static void load(ex_scene *scene, const char *name, float time)
{
    char error[EX_ERROR_SIZE];
    assert_int_equal(ex_scene_builtin(scene, name, time, error), 0);
}

static const ex_object *object_called(const ex_scene *scene, const char *name)
{
    for (uint32_t i = 0; i < scene->object_count; i++)
        if (strcmp(scene->objects[i].name, name) == 0) return &scene->objects[i];
    fail_msg("no object is called %s", name);
    return NULL;
}

typedef struct expected {
    const char *name;
    uint64_t    least, most;     /* triangles */
    float       radius_low, radius_high;
    uint32_t    lights;
    int         animated, camera;
} expected;

static const expected scenes[] = {
    {"uroom", 10000, 30000, 5, 6, 1, 0, 1},
    {"corridor", 10000, 40000, 6, 8, 1, 0, 1},
    {"atrium", 1000000, 1200000, 13, 18, 1, 1, 1},
    {"cloth", 80000, 110000, 2, 3, 0, 1, 1},
    {"figure", 106500, 107500, 0.9f, 1.1f, 0, 1, 1},
    {"robots", 20000, 30000, 3, 7, 3, 1, 1},
    {"spaceships", 100000, 120000, 3, 6, 0, 1, 1},
    {"explosion", 30000, 40000, 3, 5, 0, 1, 1},
};

enum { SCENES = sizeof scenes / sizeof *scenes };

static void scenes_have_their_size(void **state)
{
    (void)state;
    for (int i = 0; i < SCENES; i++) {
        ex_scene scene;
        float center[3], radius;
        load(&scene, scenes[i].name, 0);
        uint64_t triangles = ex_scene_triangles(&scene);
        if (triangles < scenes[i].least || triangles > scenes[i].most)
            fail_msg("%s has %lu triangles", scenes[i].name, (unsigned long)triangles);
        assert_int_equal(ex_scene_bounds(&scene, center, &radius), 0);
        if (!(radius > scenes[i].radius_low && radius < scenes[i].radius_high))
            fail_msg("%s has radius %g", scenes[i].name, (double)radius);
        assert_int_equal(scene.light_count, scenes[i].lights);
        assert_int_equal(scene.animated, scenes[i].animated);
        assert_int_equal(scene.has_camera, scenes[i].camera);
        ex_scene_free(&scene);
    }
}

static size_t degenerate_triangles(const ex_mesh *mesh)
{
    size_t bad = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        v3 p[3];
        for (size_t k = 0; k < 3; k++) p[k] = v3_load(mesh->positions + 3 * (size_t)mesh->indices[3 * t + k]);
        v3 u = v3_sub(p[1], p[0]), v = v3_sub(p[2], p[0]);
        float longest = fmaxf(v3_length(u), fmaxf(v3_length(v), v3_length(v3_sub(p[2], p[1]))));
        bad += !(v3_length(v3_cross(u, v)) > 1e-5f * longest * longest);
    }
    return bad;
}

static void no_triangle_is_degenerate(void **state)
{
    (void)state;
    for (int i = 0; i < SCENES; i++)
        for (int step = 0; step < 1 + 2 * scenes[i].animated; step++) {
            ex_scene scene;
            load(&scene, scenes[i].name, 1.37f * (float)step);
            for (uint32_t m = 0; m < scene.mesh_count; m++) {
                const ex_mesh *mesh = &scene.meshes[m];
                size_t bad = degenerate_triangles(mesh);
                if (bad)
                    fail_msg("%s, mesh %u: %lu degenerate", scenes[i].name, (unsigned)m, (unsigned long)bad);
                for (size_t k = 0; k < 3 * (size_t)mesh->vertex_count; k++)
                    assert_true(isfinite(mesh->positions[k]) && isfinite(mesh->normals[k]));
            }
            ex_scene_free(&scene);
        }
}

static void solid_parts_are_closed_and_face_outwards(void **state)
{
    static const char *const solids[][2] = {
        {"uroom", "divider"}, {"uroom", "skirting"}, {"uroom", "table"}, {"uroom", "vase"}, {"uroom", "stool"},
        {"uroom", "shelf"}, {"corridor", "bay left"}, {"corridor", "beam"}, {"corridor", "pedestal"},
        {"corridor", "statue"}, {"atrium", "column"}, {"atrium", "arch"}, {"atrium", "cornice"},
        {"atrium", "balustrade"}, {"atrium", "door"}, {"atrium", "fountain"}, {"cloth", "post"}, {"cloth", "peg"},
        {"cloth", "lines"}, {"cloth", "basket"}, {"robots", "body"}, {"robots", "left leg"}, {"robots", "bullet"},
        {"spaceships", "ship"}, {"explosion", "fire"}, {"explosion", "piece"}, {"explosion", "crate"},
        {"explosion", "barrel"},
        {"explosion", "pillar"}};
    (void)state;
    for (size_t i = 0; i < sizeof solids / sizeof *solids; i++) {
        ex_scene scene;
        load(&scene, solids[i][0], 0);
        const ex_mesh *mesh = &scene.meshes[object_called(&scene, solids[i][1])->mesh];
        if (count_edges(mesh).open) fail_msg("%s of %s is open", solids[i][1], solids[i][0]);
        if (pieces_inside_out(mesh)) fail_msg("%s of %s is inside out", solids[i][1], solids[i][0]);
        ex_scene_free(&scene);
    }
}

/* Layers are sewn on along lines where three sheets meet, at every time. */
static void cloth_is_no_manifold(void **state)
{
    (void)state;
    for (int step = 0; step < 3; step++) {
        ex_scene scene;
        uint32_t sewn = 0;
        load(&scene, "cloth", 0.9f * (float)step);
        for (uint32_t m = 0; m < scene.mesh_count; m++)
            if (scene.meshes[m].deforms) sewn += count_edges(&scene.meshes[m]).shared >= 30;
        assert_int_equal(sewn, 2);
        ex_scene_free(&scene);
    }
}

/* Threads down a drape keep their length, whatever the wind does. */
static void drapes_do_not_stretch(void **state)
{
    const ex_drape drape = {v3_make(0, 2, 0), v3_make(1, 2, 0), 1.5f, 0, 3, 0.6f, 1};
    (void)state;
    for (int step = 0; step < 4; step++) {
        ex_scene scene;
        memset(&scene, 0, sizeof scene);
        ex_builder b = ex_build_begin(&scene);
        ex_build_drape(&b, &drape, 0.7f * (float)step, 10, 200, 0);
        const ex_mesh *mesh = finish_shape(&b);
        for (size_t i = 0; i <= 10; i++) {
            double length = 0;
            for (size_t j = 0; j < 200; j++) {
                const float *p = mesh->positions + 3 * (i * 201 + j);
                length += (double)v3_length(v3_sub(v3_load(p + 3), v3_load(p)));
            }
            assert_near(length, 1.5, 0.03);
        }
        ex_scene_free(&scene);
    }
}

/* A room's walls face its inside: what the camera sees is the front of each. */
static void walls_face_the_camera(void **state)
{
    static const char *const rooms[][2] = {{"uroom", "room"}, {"corridor", "walls"}};
    (void)state;
    for (size_t i = 0; i < sizeof rooms / sizeof *rooms; i++) {
        ex_scene scene;
        load(&scene, rooms[i][0], 0);
        const ex_mesh *mesh = &scene.meshes[object_called(&scene, rooms[i][1])->mesh];
        v3 eye = v3_load(scene.camera.eye);
        for (size_t k = 0; k < mesh->vertex_count; k++)
            assert_true(v3_dot(v3_load(mesh->normals + 3 * k), v3_sub(eye, v3_load(mesh->positions + 3 * k))) > 0);
        ex_scene_free(&scene);
    }
}

/* ---- animation ---- */

static int same_bytes(const void *a, const void *b, size_t size) { return size == 0 || memcmp(a, b, size) == 0; }

static int same_mesh(const ex_mesh *a, const ex_mesh *b)
{
    return a->vertex_count == b->vertex_count && a->triangle_count == b->triangle_count && a->deforms == b->deforms &&
           same_bytes(a->positions, b->positions, 12 * (size_t)a->vertex_count) &&
           same_bytes(a->normals, b->normals, 12 * (size_t)a->vertex_count) &&
           same_bytes(a->indices, b->indices, 12 * (size_t)a->triangle_count) &&
           same_bytes(a->materials, b->materials, 4 * (size_t)a->triangle_count);
}

/* Everything that a scene's time may change. */
static int same_scene(const ex_scene *a, const ex_scene *b)
{
    int same = a->mesh_count == b->mesh_count && a->object_count == b->object_count &&
               a->light_count == b->light_count && a->material_count == b->material_count;
    for (uint32_t i = 0; same && i < a->mesh_count; i++) same = same_mesh(&a->meshes[i], &b->meshes[i]);
    return same && same_bytes(a->objects, b->objects, a->object_count * sizeof *a->objects) &&
           same_bytes(a->lights, b->lights, a->light_count * sizeof *a->lights) &&
           same_bytes(a->materials, b->materials, a->material_count * sizeof *a->materials);
}

static void time_moves_what_it_should_and_nothing_else(void **state)
{
    char error[EX_ERROR_SIZE];
    (void)state;
    for (int i = 0; ex_scene_names()[i]; i++) {
        ex_scene first, later, moved;
        load(&first, ex_scene_names()[i], 0);
        load(&later, ex_scene_names()[i], 0.7f);
        load(&moved, ex_scene_names()[i], 2.5f);
        assert_int_equal(ex_scene_set_time(&moved, 0.7f, error), 0);
        assert_true(same_scene(&later, &moved));             /* the same, whatever was before */
        assert_int_equal(same_scene(&first, &later), !first.animated);
        for (uint32_t m = 0; m < first.mesh_count; m++)      /* deforms says which meshes change */
            assert_int_equal(same_mesh(&first.meshes[m], &later.meshes[m]), !first.meshes[m].deforms);
        for (uint32_t o = 0; o < first.object_count; o++)
            assert_int_equal(first.objects[o].mesh, later.objects[o].mesh);
        ex_scene_free(&first);
        ex_scene_free(&later);
        ex_scene_free(&moved);
    }
}

static void what_was_added_stays_when_time_passes(void **state)
{
    char error[EX_ERROR_SIZE];
    (void)state;
    for (int i = 0; ex_scene_names()[i]; i++) {
        ex_scene scene;
        load(&scene, ex_scene_names()[i], 0);
        assert_int_equal(ex_scene_add_ground(&scene), 0);
        ex_object ground = scene.objects[scene.object_count - 1];
        ex_mesh mesh = scene.meshes[ground.mesh];
        assert_int_equal(ex_scene_set_time(&scene, 1.5f, error), 0);
        assert_memory_equal(&ground, &scene.objects[scene.object_count - 1], sizeof ground);
        assert_true(same_mesh(&mesh, &scene.meshes[ground.mesh]));
        ex_scene_free(&scene);
    }
}

static uint64_t vertices_placed(const ex_scene *scene)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < scene->object_count; i++) sum += scene->meshes[scene->objects[i].mesh].vertex_count;
    return sum;
}

/* The paper's sizes, ground included: about 26,000 and 73,000 vertices. */
static void robots_and_ships_have_the_papers_vertices(void **state)
{
    ex_scene scene;
    (void)state;
    load(&scene, "robots", 0);
    assert_near(vertices_placed(&scene), 26000, 2000);
    ex_scene_free(&scene);
    load(&scene, "spaceships", 0);
    assert_near(vertices_placed(&scene), 73000, 1000);
    ex_scene_free(&scene);
}

/* Of each robot's two legs one stands on the deck, neither sinks into it; nothing rigid is sheared or
   scaled unevenly. */
static void robots_walk_on_the_deck(void **state)
{
    char error[EX_ERROR_SIZE];
    ex_scene scene;
    (void)state;
    load(&scene, "robots", 0);
    for (int step = 0; step < 60; step++) {
        assert_int_equal(ex_scene_set_time(&scene, 0.11f * (float)step, error), 0);
        for (uint32_t robot = 0; robot < 3; robot++) {
            float lowest = 1;
            for (uint32_t leg = 1; leg <= 2; leg++) {
                const ex_object *object = &scene.objects[3 * robot + leg];
                const ex_mesh *mesh = &scene.meshes[object->mesh];
                for (size_t i = 0; i < mesh->vertex_count; i++)
                    lowest = fminf(lowest, ex_transform_point(object->transform, v3_load(mesh->positions + 3 * i)).y);
            }
            assert_true(lowest >= 0 && lowest < 0.03f);
        }
        for (uint32_t i = 0; i < scene.object_count; i++) {
            const float *m = scene.objects[i].transform;
            v3 x = v3_load(m), y = v3_load(m + 4), z = v3_load(m + 8);
            assert_near(v3_length(x), v3_length(y), 1e-5);
            assert_near(v3_length(x), v3_length(z), 1e-5);
            assert_near(v3_dot(x, y), 0, 1e-5);
            assert_near(v3_dot(v3_cross(x, y), z), pow((double)v3_length(x), 3), 1e-5);
        }
    }
    ex_scene_free(&scene);
}

/* The lamps go with the bodies, and nothing of the robot stands before them. */
static void robots_carry_their_lamps(void **state)
{
    char error[EX_ERROR_SIZE];
    ex_scene scene;
    (void)state;
    load(&scene, "robots", 0);
    const ex_mesh *body = &scene.meshes[scene.objects[0].mesh];
    for (int step = 0; step < 5; step++) {
        assert_int_equal(ex_scene_set_time(&scene, 0.6f * (float)step, error), 0);
        for (uint32_t i = 0; i < 3; i++) {
            const ex_light *lamp = &scene.lights[i];
            v3 at = v3_load(lamp->position), out = v3_load(lamp->direction);
            assert_near(v3_length(out), 1, 1e-5);
            for (size_t k = 0; k < body->vertex_count; k++) {
                v3 p = ex_transform_point(scene.objects[3 * i].transform, v3_load(body->positions + 3 * k));
                assert_true(v3_dot(v3_sub(p, at), out) < lamp->cos_half_angle * v3_length(v3_sub(p, at)));
            }
        }
    }
    ex_scene_free(&scene);
}

/* The fire is a video: its triangles keep their places while their radiance changes, hot at first, then ash. */
static void fire_cools_down(void **state)
{
    char error[EX_ERROR_SIZE];
    ex_scene scene;
    double mean[3];
    (void)state;
    load(&scene, "explosion", 0);
    const ex_mesh *fire = &scene.meshes[object_called(&scene, "fire")->mesh];
    for (int step = 0; step < 3; step++) {
        int levels[16] = {0}, different = 0;
        assert_int_equal(ex_scene_set_time(&scene, 0.1f + 0.75f * (float)step, error), 0);
        mean[step] = 0;
        for (uint32_t t = 0; t < fire->triangle_count; t++) {
            assert_true(fire->materials[t] < scene.material_count && fire->materials[t] < 16);
            mean[step] += (double)scene.materials[fire->materials[t]].emission[0] / fire->triangle_count;
            different += levels[fire->materials[t]]++ == 0;
        }
        assert_true(different >= 3);
    }
    assert_true(mean[0] > 2 * mean[1] && mean[1] > 0);
    ex_scene_free(&scene);
}

static void one_material_overrides_those_of_the_mesh(void **state)
{
    ex_scene scene;
    const float at[3] = {1, 0, 0};
    float white[3], black[3];
    (void)state;
    load(&scene, "chess", 0);
    const ex_object *a = object_called(&scene, "white pawn a2"), *b = object_called(&scene, "black pawn a7");
    assert_int_equal(a->mesh, b->mesh);
    assert_int_equal(scene.mesh_count, 1 + 6 + 1);           /* board, kinds, ground */
    assert_int_equal(ex_surface_color(&scene, a, 0, at, white), 1);
    assert_int_equal(ex_surface_color(&scene, b, 0, at, black), 1);
    assert_near(white[0], 0.74, 1e-6);
    assert_near(black[0], 0.055, 1e-6);
    assert_int_equal(ex_object_material(&scene, a, 0), a->material - 1);
    ex_object plain = *a;
    plain.material = 0;
    assert_int_equal(ex_object_material(&scene, &plain, 5), scene.meshes[a->mesh].materials[5]);
    ex_scene_free(&scene);
}

/* Pieces end on the middle of squares, never two on one, and are back after ten seconds. */
static void the_game_of_chess_is_played(void **state)
{
    const float half[2] = {-0.5f * 0.055f, 0.055f};
    ex_scene scene, first;
    (void)state;
    load(&scene, "chess", 8);                                /* ten moves of 0.8 s */
    load(&first, "chess", 0);
    const float *pawn = object_called(&scene, "white pawn e2")->transform + 12;
    assert_near(pawn[0], -half[0], 1e-5);
    assert_near(pawn[2], -half[0], 1e-5);                    /* e4: the fourth rank from white, who sits at +Z */
    for (uint32_t i = 1; i <= 32; i++) {
        const float *a = scene.objects[i].transform + 12;
        float file = a[0] / half[1] - 0.5f, rank = a[2] / half[1] - 0.5f;
        assert_near(file, roundf(file), 1e-3);
        assert_near(rank, roundf(rank), 1e-3);
        for (uint32_t k = 1; k < i; k++) {
            const float *b = scene.objects[k].transform + 12;
            assert_true(fabsf(a[0] - b[0]) + fabsf(a[2] - b[2]) > 0.05f);
        }
    }
    assert_int_equal(ex_scene_set_time(&scene, 10, NULL), 0);
    for (uint32_t i = 0; i < scene.object_count; i++)
        for (int k = 12; k < 15; k++)
            assert_near(scene.objects[i].transform[k], first.objects[i].transform[k], 1e-4);
    ex_scene_free(&first);
    ex_scene_free(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shapes_are_closed_and_have_their_volume),
        cmocka_unit_test(transforms_keep_the_outside_outside),
        cmocka_unit_test(scenes_have_their_size),
        cmocka_unit_test(no_triangle_is_degenerate),
        cmocka_unit_test(solid_parts_are_closed_and_face_outwards),
        cmocka_unit_test(cloth_is_no_manifold),
        cmocka_unit_test(drapes_do_not_stretch),
        cmocka_unit_test(walls_face_the_camera),
        cmocka_unit_test(time_moves_what_it_should_and_nothing_else),
        cmocka_unit_test(what_was_added_stays_when_time_passes),
        cmocka_unit_test(robots_and_ships_have_the_papers_vertices),
        cmocka_unit_test(robots_walk_on_the_deck),
        cmocka_unit_test(robots_carry_their_lamps),
        cmocka_unit_test(fire_cools_down),
        cmocka_unit_test(the_game_of_chess_is_played),
        cmocka_unit_test(one_material_overrides_those_of_the_mesh),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
