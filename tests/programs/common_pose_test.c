/* common_pose_test.c - examples/common: skins, morph targets and animations of glTF files, by files written here whose
   vertices at a time are known, and by hostile ones. */
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

#include "gltf_json.h"

/* ---- accessors, as they are put ---- */

static char views[4000], accessors[4000];
static int accessor_count;

static void begin(void)
{
    byte_count = 0;
    accessor_count = 0;
    views[0] = accessors[0] = 0;
}

/* kind: "SCALAR", or with ",\"normalized\":true" behind its quote. Returns the accessor's number. */
static int add(int component, const char *kind, int count, const void *data, size_t size)
{
    char text[200];
    while (byte_count % 4) put("", 1);
    snprintf(text, sizeof text, "%s{\"buffer\":0,\"byteOffset\":%d,\"byteLength\":%d}", accessor_count ? "," : "",
             (int)byte_count, (int)size);
    strcat(views, text);
    snprintf(text, sizeof text, "%s{\"bufferView\":%d,\"componentType\":%d,\"count\":%d,\"type\":%s}",
             accessor_count ? "," : "", accessor_count, component, count, kind);
    strcat(accessors, text);
    put(data, size);
    return accessor_count++;
}

static int add_floats(const char *kind, int count, const float *values, size_t floats)
{
    return add(5126, kind, count, values, floats * sizeof *values);
}

static char json[16000];

/* The file of all accessors and the rest; the scene is loaded with its animation. */
static int load_with(ex_scene *scene, char *error, int animation, const char *rest, ...)
{
    va_list list;
    int at = snprintf(json, sizeof json, "\"bufferViews\":[%s],\"accessors\":[%s],", views, accessors);
    va_start(list, rest);
    at += vsnprintf(json + at, sizeof json - (size_t)at, rest, list);
    va_end(list);
    assert_true(at < (int)sizeof json);
    ex_animation = animation;
    int result = load_json(scene, error, json);
    ex_animation = -1;
    return result;
}

static void assert_point(const float *p, double x, double y, double z)
{
    if (fabs((double)p[0] - x) > 1e-5 || fabs((double)p[1] - y) > 1e-5 || fabs((double)p[2] - z) > 1e-5)
        fail_msg("%g %g %g, expected %g %g %g", (double)p[0], (double)p[1], (double)p[2], x, y, z);
}

static void assert_vertex(const ex_scene *scene, int mesh, int vertex, double x, double y, double z)
{
    assert_true((uint32_t)mesh < scene->mesh_count && (uint32_t)vertex < scene->meshes[mesh].vertex_count);
    assert_point(scene->meshes[mesh].positions + 3 * vertex, x, y, z);
}

static void at_time(ex_scene *scene, float time)
{
    char error[EX_ERROR_SIZE] = "";
    if (ex_scene_set_time(scene, time, error) != 0) fail_msg("%s", error);
}

/* ---- a ribbon of six vertices with two bones ---- */

static const float ribbon[18] = {-0.5f, 0, 0, 0.5f, 0, 0, -0.5f, 1, 0, 0.5f, 1, 0, -0.5f, 2, 0, 0.5f, 2, 0};
static const float ribbon_normals[18] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0};
static const uint16_t ribbon_indices[12] = {0, 1, 2, 2, 1, 3, 2, 3, 4, 4, 3, 5};    /* vertices in order */
static const uint8_t byte_joints[24] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
static const float weights[24] = {1, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0, 0.5f, 0.5f, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
static const float inverse_bind[32] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1,
                                       1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1};
static const float two_times[2] = {0, 1};
static const float quarter_turn[8] = {0, 0, 0, 1, 0, 0, 0.70710678f, 0.70710678f};

typedef struct column { int positions, normals, indices, joints, weights, binds, times, turn; } column;

static column put_column(void)
{
    column c;
    begin();
    c.positions = add_floats("\"VEC3\"", 6, ribbon, 18);
    c.normals = add_floats("\"VEC3\"", 6, ribbon_normals, 18);
    c.indices = add(5123, "\"SCALAR\"", 12, ribbon_indices, sizeof ribbon_indices);
    c.joints = add(5121, "\"VEC4\"", 6, byte_joints, sizeof byte_joints);
    c.weights = add_floats("\"VEC4\"", 6, weights, 24);
    c.binds = add_floats("\"MAT4\"", 2, inverse_bind, 32);
    c.times = add_floats("\"SCALAR\"", 2, two_times, 2);
    c.turn = add_floats("\"VEC4\"", 2, quarter_turn, 8);
    return c;
}

/* Node 0 shows the ribbon and is far away, which its skin ignores; nodes 1 and 2 are the bones, 2 turns in a second. */
#define COLUMN_MESH "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":%d,\"NORMAL\":%d,\"JOINTS_0\":%d," \
    "\"WEIGHTS_0\":%d},\"indices\":%d}]}],"
#define COLUMN_NODES "\"scenes\":[{\"nodes\":[0,1]}],\"nodes\":[{\"mesh\":0,\"skin\":0,\"translation\":[100,7,3]," \
    "\"scale\":[3,3,3]},{\"children\":[2]},{\"translation\":[0,1,0]}],"
#define COLUMN_SKIN "\"skins\":[{\"joints\":[1,2],\"inverseBindMatrices\":%d}],"
#define COLUMN_TURN "\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":2,\"path\":\"rotation\"}}]," \
    "\"samplers\":[{\"input\":%d,\"output\":%d}]}]"

static int load_column(ex_scene *scene, char *error, const column *c)
{
    return load_with(scene, error, 0, COLUMN_MESH COLUMN_NODES COLUMN_SKIN COLUMN_TURN, c->positions, c->normals,
                     c->joints, c->weights, c->indices, c->binds, c->times, c->turn);
}

/* Upright at 0; at 1 s the upper half lies along -X, and the ring between the bones is halfway. */
static void check_column(ex_scene *scene)
{
    assert_true(scene->animated);
    assert_true(scene->meshes[0].deforms);
    for (int k = 0; k < 6; k++)
        assert_vertex(scene, 0, k, (double)ribbon[3 * k], (double)ribbon[3 * k + 1], 0);
    at_time(scene, 1);
    for (int k = 0; k < 2; k++) {
        double x = k ? 0.5 : -0.5;
        assert_vertex(scene, 0, k, x, 0, 0);
        assert_vertex(scene, 0, 2 + k, x / 2, 1 + x / 2, 0);
        assert_vertex(scene, 0, 4 + k, -1, 1 + x, 0);
        assert_point(scene->meshes[0].normals + 3 * k, 0, 0, 1);
        assert_point(scene->meshes[0].normals + 3 * (2 + k), 0, 0, 1);
        assert_point(scene->meshes[0].normals + 3 * (4 + k), 0, 1, 0);
    }
    for (int k = 0; k < 16; k++) assert_near(scene->objects[0].transform[k], k % 5 == 0, 0);
    for (int k = 0; k < 6; k++) assert_int_equal(scene->meshes[0].parts[k], k > 3);      /* equal weights: the first */
}

static void a_column_of_two_bones_bends_by_90_degrees(void **state)
{
    char error[EX_ERROR_SIZE];
    ex_scene scene;
    (void)state;
    skip_without_parser();
    const column c = put_column();
    if (load_column(&scene, error, &c) != 0) fail_msg("%s", error);
    assert_int_equal(scene.mesh_count, 1);
    assert_int_equal(scene.object_count, 1);
    check_column(&scene);
    at_time(&scene, 0.5f);                   /* half of 90 degrees */
    const double s = sqrt(0.5);
    assert_vertex(&scene, 0, 5, 0.5 * s - s, 1 + 0.5 * s + s, 0);
    ex_scene_free(&scene);
}

/* Joints as bytes or shorts; weights as floats, as bytes and shorts that stand for 0 to 1, and unnormalised. */
static void joints_and_weights_come_in_every_form(void **state)
{
    static const int weight_types[5] = {5126, 5121, 5123, 5121, 5126};
    char error[EX_ERROR_SIZE];
    (void)state;
    skip_without_parser();
    for (int form = 0; form < 10; form++) {
        ex_scene scene;
        uint16_t joints[24], shorts[24];
        uint8_t chars[24];
        float threefold[24];
        column c = put_column();
        for (int k = 0; k < 24; k++) {
            joints[k] = byte_joints[k];
            if (!(weights[k] > 0)) joints[k] = form == 1 ? 77 : 0;           /* without weight it may say anything */
            chars[k] = (uint8_t)(255 * weights[k]);
            shorts[k] = (uint16_t)(65535 * weights[k]);
            threefold[k] = 3 * weights[k];
        }
        const void *const data[5] = {weights, chars, shorts, chars, threefold};
        const size_t sizes[5] = {sizeof weights, sizeof chars, sizeof shorts, sizeof chars, sizeof threefold};
        if (form % 2) c.joints = add(5123, "\"VEC4\"", 6, joints, sizeof joints);
        const char *kind = form / 2 == 1 || form / 2 == 2 ? "\"VEC4\",\"normalized\":true" : "\"VEC4\"";
        c.weights = add(weight_types[form / 2], kind, 6, data[form / 2], sizes[form / 2]);
        if (load_column(&scene, error, &c) != 0) fail_msg("form %d: %s", form, error);
        check_column(&scene);
        ex_scene_free(&scene);
    }
}

/* A second set of four: half of the last ring stays with the first bone. */
static void a_vertex_may_have_eight_joints(void **state)
{
    static const uint8_t joints[24] = {0};
    static const float more[24] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1};
    char error[EX_ERROR_SIZE];
    ex_scene scene;
    (void)state;
    skip_without_parser();
    const column c = put_column();
    const int second = add(5121, "\"VEC4\"", 6, joints, sizeof joints), share = add_floats("\"VEC4\"", 6, more, 24);
    if (load_with(&scene, error, 0,
                  "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":%d,\"JOINTS_0\":%d,\"WEIGHTS_0\":%d,"
                  "\"JOINTS_1\":%d,\"WEIGHTS_1\":%d,\"NORMAL\":%d},\"indices\":%d}]}],"
                  COLUMN_NODES COLUMN_SKIN COLUMN_TURN, c.positions, c.joints, c.weights, second, share, c.normals,
                  c.indices, c.binds, c.times, c.turn) != 0)
        fail_msg("%s", error);
    at_time(&scene, 1);
    assert_vertex(&scene, 0, 4, (-0.5 - 1) / 2, (2 + 0.5) / 2, 0);
    assert_vertex(&scene, 0, 5, (0.5 - 1) / 2, (2 + 1.5) / 2, 0);
    ex_scene_free(&scene);
}

/* Without inverse bind matrices the vertices are the bones' own: the second bone's lie one higher. A file without an
   animation is posed once, and is rigid then. */
static void bones_without_inverse_bind_carry_what_lies_about_them(void **state)
{
    char error[EX_ERROR_SIZE];
    ex_scene scene;
    (void)state;
    skip_without_parser();
    const column c = put_column();
    if (load_with(&scene, error, 0, COLUMN_MESH COLUMN_NODES "\"skins\":[{\"joints\":[1,2]}]", c.positions, c.normals,
                  c.joints, c.weights, c.indices) != 0)
        fail_msg("%s", error);
    assert_vertex(&scene, 0, 1, 0.5, 0, 0);
    assert_vertex(&scene, 0, 3, 0.5, 1.5, 0);
    assert_vertex(&scene, 0, 5, 0.5, 3, 0);
    assert_false(scene.animated || scene.meshes[0].deforms || scene.rig);
    ex_scene_free(&scene);
}

/* Without it, as baking wants it, vertices are the file's and stand where the node says. */
static void who_asks_for_no_animation_gets_the_files_vertices(void **state)
{
    char error[EX_ERROR_SIZE];
    ex_scene scene;
    (void)state;
    skip_without_parser();
    const column c = put_column();
    assert_int_equal(load_with(&scene, error, -1, COLUMN_MESH COLUMN_NODES COLUMN_SKIN COLUMN_TURN, c.positions,
                               c.normals, c.joints, c.weights, c.indices, c.binds, c.times, c.turn), 0);
    assert_false(scene.animated || scene.meshes[0].deforms);
    assert_near(scene.objects[0].transform[12], 100, 0);
    assert_memory_equal(scene.meshes[0].positions + 12, ribbon + 12, 24);
    ex_scene_free(&scene);
}

/* One mesh with a skin at one node, and rigid at another: each has its own. */
static void nodes_that_share_a_mesh_move_apart(void **state)
{
    char error[EX_ERROR_SIZE];
    ex_scene scene;
    (void)state;
    skip_without_parser();
    const column c = put_column();
    if (load_with(&scene, error, 0, COLUMN_MESH COLUMN_SKIN COLUMN_TURN
                  ",\"scenes\":[{\"nodes\":[0,1,3,4]}],\"nodes\":[{\"mesh\":0,\"skin\":0},{\"children\":[2]},"
                  "{\"translation\":[0,1,0]},{\"mesh\":0,\"translation\":[5,0,0]},{\"mesh\":0,\"skin\":0}]", c.positions,
                  c.normals, c.joints, c.weights, c.indices, c.binds, c.times, c.turn) != 0)
        fail_msg("%s", error);
    assert_int_equal(scene.object_count, 3);
    assert_int_equal(scene.mesh_count, 3);
    at_time(&scene, 1);
    assert_int_equal(scene.objects[1].mesh, 0);
    assert_false(scene.meshes[0].deforms);
    assert_vertex(&scene, 0, 5, 0.5, 2, 0);
    assert_near(scene.objects[1].transform[12], 5, 0);
    for (int k = 0; k < 3; k += 2) {
        assert_true(scene.meshes[scene.objects[k].mesh].deforms);
        assert_vertex(&scene, (int)scene.objects[k].mesh, 5, -1, 1.5, 0);
    }
    assert_int_not_equal(scene.objects[0].mesh, scene.objects[2].mesh);
    ex_scene_free(&scene);
}

/* ---- morph targets ---- */

/* A square in z = 0 without normals; the first target lifts one edge by 2, the second moves all by 4 along X. */
#define SQUARE_MESH "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"targets\":[" \
    "{\"POSITION\":2},{\"POSITION\":3}]}]%s}],\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0%s}]"

static void put_square(void)
{
    static const float corners[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    static const float lift[12] = {0, 0, 0, 0, 0, 2, 0, 0, 2, 0, 0, 0};
    static const float shift[12] = {4, 0, 0, 4, 0, 0, 4, 0, 0, 4, 0, 0};
    static const uint16_t indices[6] = {0, 1, 2, 0, 2, 3};
    begin();
    add_floats("\"VEC3\"", 4, corners, 12);
    add(5123, "\"SCALAR\"", 6, indices, sizeof indices);
    add_floats("\"VEC3\"", 4, lift, 12);
    add_floats("\"VEC3\"", 4, shift, 12);
}

static void a_morph_weight_moves_by_its_share(void **state)
{
    static const char *const where[3][2] = {
        {"", ""}, {",\"weights\":[0.25,0]", ""},
        {",\"weights\":[0.25,0]", ",\"weights\":[0.5,0.5],\"translation\":[0,3,0]"}};
    static const double expected[3][3] = {{0, 0, 0}, {0, 0.5, 0}, {2, 1, 3}};    /* along X, at the edge, of the node */
    char error[EX_ERROR_SIZE];
    (void)state;
    skip_without_parser();
    for (int i = 0; i < 3; i++) {
        ex_scene scene;
        put_square();
        if (load_with(&scene, error, 0, SQUARE_MESH, where[i][0], where[i][1]) != 0) fail_msg("%s", error);
        assert_vertex(&scene, 0, 0, expected[i][0], 0, 0);
        assert_vertex(&scene, 0, 1, 1 + expected[i][0], 0, expected[i][1]);
        assert_near(scene.objects[0].transform[13], expected[i][2], 0);
        /* No normals in the file: those of the triangles, wherever they are. The first slopes along X. */
        const double slope = expected[i][1], length = sqrt(1 + slope * slope);
        assert_point(scene.meshes[0].normals, -slope / length, 0, 1 / length);
        ex_scene_free(&scene);
    }
}

/* Two of four corners named by 8-, 16- or 32-bit numbers, the others 0, or those of an array below. */
static void sparse_targets_move_what_they_name(void **state)
{
    static const float two[6] = {0, 0, 2, 0, 0, 4}, below[12] = {8, 0, 0, 8, 0, 0, 8, 0, 0, 8, 0, 0};
    static const uint8_t chars[2] = {1, 3};
    static const uint16_t shorts[2] = {1, 3};
    static const uint32_t longs[2] = {1, 3};
    static const void *const data[3] = {chars, shorts, longs};
    static const int types[3] = {5121, 5123, 5125};
    char error[EX_ERROR_SIZE], text[300];
    (void)state;
    skip_without_parser();
    for (int form = 0; form < 6; form++) {
        ex_scene scene;
        put_square();
        add(types[form % 3], "\"SCALAR\"", 2, data[form % 3], (size_t)2 << form % 3);       /* view 4 */
        add_floats("\"VEC3\"", 2, two, 6);
        add_floats("\"VEC3\"", 4, below, 12);
        snprintf(text, sizeof text, ",{%s\"componentType\":5126,\"count\":4,\"type\":\"VEC3\",\"sparse\":{\"count\":2,"
                 "\"indices\":{\"bufferView\":4,\"componentType\":%d},\"values\":{\"bufferView\":5}}}",
                 form < 3 ? "" : "\"bufferView\":6,", types[form % 3]);
        strcat(accessors, text);                                                            /* accessor 7 */
        if (load_with(&scene, error, 0,
                      "\"meshes\":[{\"weights\":[0.5],\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"targets\":[{\"POSITION\":7}]}]}],\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}]"
                      ) != 0)
            fail_msg("%s", error);
        assert_vertex(&scene, 0, 0, form < 3 ? 0 : 4, 0, 0);     /* triangles 0 1 2, 0 2 3, each with its own corners */
        assert_vertex(&scene, 0, 1, 1, 0, 1);
        assert_vertex(&scene, 0, 2, form < 3 ? 1 : 5, 1, 0);
        assert_vertex(&scene, 0, 5, 0, 1, 2);
        ex_scene_free(&scene);
    }
}

static void sparse_accessors_that_cannot_be_are_refused(void **state)
{
    static const char *const faults[6][2] = {
        { "\"count\":5,\"indices\":{\"bufferView\":1,\"componentType\":5121},\"values\":{\"bufferView\":0}", "sparse count"},
        { "\"count\":2,\"indices\":{\"bufferView\":1,\"componentType\":5122},\"values\":{\"bufferView\":0}", "not unsigned"},
        { "\"count\":2,\"indices\":{\"bufferView\":9,\"componentType\":5121},\"values\":{\"bufferView\":0}", "indices beyond"},
        { "\"count\":2,\"indices\":{\"bufferView\":4,\"componentType\":5121},\"values\":{\"bufferView\":0,\"byteOffset\":25}",
         "values beyond"},
        { "\"count\":2,\"indices\":{\"bufferView\":4,\"componentType\":5121},\"values\":{\"bufferView\":0}", "beyond its count"},
        { "\"count\":2,\"indices\":{\"bufferView\":5,\"componentType\":5121},\"values\":{\"bufferView\":0}", "not ascend"}};
    static const uint8_t high[2] = {1, 4}, down[2] = {2, 1};
    char error[EX_ERROR_SIZE], text[400];
    (void)state;
    skip_without_parser();
    for (int i = 0; i < 6; i++) {
        ex_scene scene;
        put_square();
        add(5121, "\"SCALAR\"", 2, high, sizeof high);           /* view 4 */
        add(5121, "\"SCALAR\"", 2, down, sizeof down);
        snprintf(text, sizeof text, ",{\"componentType\":5126,\"count\":4,\"type\":\"VEC3\",\"sparse\":{%s}}",
                 faults[i][0]);
        strcat(accessors, text);                                 /* accessor 6 */
        assert_int_equal(load_with(&scene, error, 0,
                                   "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":6}}]}],"
                                   "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}]"), -1);
        if (!strstr(error, faults[i][1]) || !strstr(error, "POSITION: accessor 6")) fail_msg("%s", error);
    }
}

/* Normals of a file move by the targets' differences, and are unit again; then skins turn them. */
static void morph_targets_come_before_skins(void **state)
{
    static const float up[18] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0};
    static const float tilt[18] = {0, 1, -1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0};
    char error[EX_ERROR_SIZE];
    ex_scene scene;
    (void)state;
    skip_without_parser();
    const column c = put_column();
    const int deltas = add_floats("\"VEC3\"", 6, up, 18), normals = add_floats("\"VEC3\"", 6, tilt, 18);
    if (load_with(&scene, error, 0,
                  "\"meshes\":[{\"weights\":[1],\"primitives\":[{\"attributes\":{\"POSITION\":%d,\"NORMAL\":%d,"
                  "\"JOINTS_0\":%d,\"WEIGHTS_0\":%d},\"indices\":%d,\"targets\":[{\"POSITION\":%d,\"NORMAL\":%d}]}]}],"
                  COLUMN_NODES COLUMN_SKIN COLUMN_TURN, c.positions, c.normals, c.joints, c.weights, c.indices, deltas,
                  normals, c.binds, c.times, c.turn) != 0)
        fail_msg("%s", error);
    const double s = sqrt(0.5);
    assert_vertex(&scene, 0, 5, 1.5, 2, 0);
    assert_point(scene.meshes[0].normals, 0, 1, 0);
    assert_point(scene.meshes[0].normals + 15, s, s, 0);
    at_time(&scene, 1);
    assert_vertex(&scene, 0, 5, -1, 2.5, 0);
    assert_point(scene.meshes[0].normals + 15, -s, s, 0);
    ex_scene_free(&scene);
}

/* ---- tracks ---- */

#define ANIMATED(interpolation, path) \
    ",\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"" path "\"}}],\"samplers\":[{\"input\":4,\"output\":5,\"interpolation\":\"" interpolation "\"}]}]"

typedef struct moving { const char *rest; int keys, width; float times[4], values[20]; } moving;

/* The square with a track at its node; values of `width` floats, 1 for a scalar. */
static void load_moving(ex_scene *scene, const moving *m, int values)
{
    static const char *const kinds[5] = {"", "\"SCALAR\"", "", "\"VEC3\"", "\"VEC4\""};
    char error[EX_ERROR_SIZE];
    put_square();
    add_floats("\"SCALAR\"", m->keys, m->times, (size_t)m->keys);
    add_floats(kinds[m->width], values, m->values, (size_t)(values * m->width));
    if (load_with(scene, error, 0, SQUARE_MESH "%s", "", "", m->rest) != 0) fail_msg("%s", error);
    assert_true(scene->animated);
}

static double x_at(ex_scene *scene, float time)
{
    at_time(scene, time);
    return (double)scene->objects[0].transform[12];
}

static void linear_and_step_tracks_pass_through_their_keys(void **state)
{
    static const moving linear = {ANIMATED("LINEAR", "translation"), 3, 3, {1, 2, 4}, {1, 0, 0, 3, 0, 0, 7, 0, 0}};
    static const moving step = {ANIMATED("STEP", "translation"), 3, 3, {1, 2, 4}, {1, 0, 0, 3, 0, 0, 7, 0, 0}};
    static const float times[9] = {0, 1, 1.25f, 1.999f, 2, 3, 3.999f, 4, 5.5f};
    static const double lines[9] = {1, 1, 1.5, 2.998, 3, 5, 6.998, 7, 2}, steps[9] = {1, 1, 1, 1, 3, 3, 3, 7, 1};
    ex_scene scene;
    (void)state;
    skip_without_parser();
    load_moving(&scene, &linear, 3);
    for (int i = 0; i < 9; i++) assert_near(x_at(&scene, times[i]), lines[i], 1e-5);  /* 5.5 s are 1.5 of the next */
    ex_scene_free(&scene);
    load_moving(&scene, &step, 3);
    for (int i = 0; i < 9; i++) assert_near(x_at(&scene, times[i]), steps[i], 0);
    ex_scene_free(&scene);
}

/* Key: tangent in, value, tangent out. Zero tangents: smooth steps; others add seconds times tangent / 8 halfway. */
static void cubic_splines_have_their_tangents(void **state)
{
    static const moving flat = {ANIMATED("CUBICSPLINE", "translation"), 2, 3, {0, 2},
                                {9, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 5, 0, 0, 9, 0, 0}};
    static const moving steep = {ANIMATED("CUBICSPLINE", "translation"), 2, 3, {0, 2},
                                 {9, 0, 0, 1, 0, 0, 4, 0, 0, -8, 0, 0, 5, 0, 0, 9, 0, 0}};
    ex_scene scene;
    (void)state;
    skip_without_parser();
    load_moving(&scene, &flat, 6);
    assert_near(x_at(&scene, 0), 1, 0);
    assert_near(x_at(&scene, 1), 3, 1e-6);                                   /* halfway: the mean */
    assert_near(x_at(&scene, 0.5f), 1 + 4 * (3.0 / 16 - 2.0 / 64), 1e-6);
    assert_near(x_at(&scene, 2), 5, 0);
    ex_scene_free(&scene);
    load_moving(&scene, &steep, 6);
    assert_near(x_at(&scene, 1), 3 + 2 * (4.0 + 8.0) / 8, 1e-6);
    ex_scene_free(&scene);
}

/* Halfway of 90 degrees is 45, also where the file writes the second rotation with the other sign. */
static void rotations_take_the_shorter_arc(void **state)
{
    static const moving turns[2] = {
        {ANIMATED("LINEAR", "rotation"), 2, 4, {0, 1}, {0, 0, 0, 1, 0, 0, 0.70710678f, 0.70710678f}},
        {ANIMATED("LINEAR", "rotation"), 2, 4, {0, 1}, {0, 0, 0, 2, 0, 0, -0.70710678f, -0.70710678f}}};
    static const double parts[5] = {0, 0.25, 0.5, 2.0 / 3, 1};
    ex_scene scene;
    (void)state;
    skip_without_parser();
    for (int i = 0; i < 2; i++) {
        load_moving(&scene, &turns[i], 2);
        for (int k = 0; k < 5; k++) {
            at_time(&scene, (float)parts[k]);
            assert_near(scene.objects[0].transform[0], cos(parts[k] * 1.5707963267949), 1e-6);
            assert_near(scene.objects[0].transform[1], sin(parts[k] * 1.5707963267949), 1e-6);
        }
        ex_scene_free(&scene);
    }
}

/* Scale 0 hides an object: it becomes a speck, never a matrix of zeros. Two targets' weights share an accessor. */
static void scales_and_weights_are_played(void **state)
{
    static const moving shrinks = {ANIMATED("LINEAR", "scale"), 2, 3, {0, 1}, {2, 2, 2, 0, 0, 0}};
    static const moving morphs = {ANIMATED("LINEAR", "weights"), 2, 1, {0, 1}, {0, 1, 1, 0}};
    static const moving spline = {ANIMATED("CUBICSPLINE", "weights"), 2, 1, {0, 1},
                                  {0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0}};
    ex_scene scene;
    (void)state;
    skip_without_parser();
    load_moving(&scene, &shrinks, 2);
    at_time(&scene, 0.5f);
    assert_near(scene.objects[0].transform[0], 1, 1e-6);
    at_time(&scene, 1);
    for (int k = 0; k < 3; k++) assert_near(scene.objects[0].transform[5 * k], 1e-6, 1e-12);
    ex_scene_free(&scene);
    for (int i = 0; i < 2; i++) {
        load_moving(&scene, i ? &spline : &morphs, i ? 12 : 4);
        assert_true(scene.meshes[0].deforms);
        at_time(&scene, 0);
        assert_vertex(&scene, 0, 1, 5, 0, 0);
        at_time(&scene, 0.5f);
        assert_vertex(&scene, 0, 1, 3, 0, 1);
        at_time(&scene, 1);
        assert_vertex(&scene, 0, 1, 1, 0, 2);
        ex_scene_free(&scene);
    }
}

/* Forth and back, and by a scene of its own: the same bytes. Lights and children go along. */
static void a_time_is_the_same_from_wherever_it_is_reached(void **state)
{
    static const float ahead[6] = {0, 0, 0, 4, 0, 0};
    char error[EX_ERROR_SIZE];
    ex_scene once, often;
    (void)state;
    skip_without_parser();
    for (int i = 0; i < 2; i++) {
        ex_scene *scene = i ? &often : &once;
        const column c = put_column();
        const int walk = add_floats("\"VEC3\"", 2, ahead, 6);
        if (load_with(scene, error, 0, COLUMN_MESH COLUMN_SKIN "\"extensionsUsed\":[\"KHR_lights_punctual\"],"
                      "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"spot\",\"spot\":{}}]}},"
                      "\"scenes\":[{\"nodes\":[0,1]}],\"nodes\":[{\"mesh\":0,\"skin\":0},{\"children\":[2]},{\"translation\":"
                      "[0,1,0],\"children\":[3]},{\"rotation\":[0.70710678,0,0,0.70710678],\"extensions\":"
                      "{\"KHR_lights_punctual\":{\"light\":0}}}],\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":"
                      "{\"node\":2,\"path\":\"rotation\"}},{\"sampler\":1,\"target\":{\"node\":1,\"path\":\"translation\"}}],"
                      "\"samplers\":[{\"input\":%d,\"output\":%d},{\"input\":%d,\"output\":%d}]}]", c.positions, c.normals,
                      c.joints, c.weights, c.indices, c.binds, c.times, c.turn, c.times, walk) != 0)
            fail_msg("%s", error);
    }
    for (int k = 0; k < 7; k++) at_time(&often, 0.3f * (float)k);
    at_time(&often, 0.7f);
    at_time(&once, 0.7f);
    assert_memory_equal(once.meshes[0].positions, often.meshes[0].positions, 72);
    assert_memory_equal(once.meshes[0].normals, often.meshes[0].normals, 72);
    assert_memory_equal(once.lights, often.lights, sizeof *once.lights);
    at_time(&once, 1);                       /* The lamp looked up, and is turned to -X. */
    assert_point(once.lights[0].position, 4, 1, 0);
    assert_point(once.lights[0].direction, -1, 0, 0);
    assert_vertex(&once, 0, 5, 3, 1.5, 0);
    ex_scene_free(&once);
    ex_scene_free(&often);
}

/* ---- hostile files ---- */

/* The column with one thing of it replaced, and what the message has to say. */
typedef struct fault { const char *find, *put, *says; } fault;

static const fault faults[] = {
    {"\"joints\":[1,2]", "\"joints\":[1,9]", "skin 0: joint 1 is node 9"},
    {"\"joints\":[1,2]", "\"joints\":[-1,2]", "skin 0: joint 0 is node -1"},
    {"\"joints\":[1,2]", "\"joints\":[1]", "JOINTS of vertex 2 is 1, skin 0 has 1 joints"},
    {"\"joints\":[1,2]", "\"joints\":[1,2,1]", "inverseBindMatrices: 2 matrices for 3 joints"},
    {"\"skin\":0", "\"skin\":4", "node 0: skin 4 does not exist"},
    {"\"inverseBindMatrices\":5", "\"inverseBindMatrices\":50", "inverseBindMatrices: accessor 50 does not exist"},
    {"\"inverseBindMatrices\":5", "\"inverseBindMatrices\":0", "accessor 0 has the wrong type"},
    {"\"inverseBindMatrices\":5", "\"inverseBindMatrices\":8", "matrix 1 holds nan"},
    {"\"inverseBindMatrices\":5", "\"inverseBindMatrices\":9", "matrix 0 has 0.5 in its last row, not 1"},
    {"\"WEIGHTS_0\":4", "\"WEIGHTS_0\":10", "WEIGHTS_0 has 5 elements, POSITION 6"},
    {"\"WEIGHTS_0\":4", "\"WEIGHTS_0\":11", "WEIGHTS_0 of vertex 4 is -1"},
    {"\"WEIGHTS_0\":4", "\"WEIGHTS_0\":0", "accessor 0 has the wrong type"},
    {",\"WEIGHTS_0\":4", "", "has no WEIGHTS_0"},
    {"\"JOINTS_0\":3,", "", "has no JOINTS_0"},
    {"\"JOINTS_0\":3", "\"JOINTS_0\":4", "JOINTS_0 are of the type 5126"},
    {"\"children\":[2]},{\"translation\":[0,1,0]}", "\"children\":[2]},{\"children\":[1]}", "among its own ancestors"},
    {"{\"children\":[2]},{\"translation\":[0,1,0]}", "{},{\"children\":[2]}", "node 2 is among its own ancestors"},
    {"\"children\":[2]},{\"translation\":[0,1,0]}", "\"children\":[2]},{},{\"children\":[2]}",
     "node 2 has two parents"},
    {"\"children\":[2]", "\"children\":[2,70]", "node 1: child 70 does not exist"},
    {"\"nodes\":[0,1]", "\"nodes\":[0,1,1]", "node 1 is reached twice"},
    {"\"translation\":[0,1,0]", "\"translation\":[0,1e39,0]", "node 2: translation holds 1e+39"},
    {"\"translation\":[0,1,0]", "\"scale\":[1,1,-1e9]", "node 2: scale holds -1e+09"},
    {"{\"children\":[2]},{", "{\"children\":[2],\"scale\":[1e8,1,1]},{\"scale\":[1e8,1,1],",
     "node 2: its matrix in the world holds 1e+16"},
    {"\"translation\":[0,1,0]", "\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,0,1,0,1]", "node 2 has a matrix"},
    {"\"node\":2", "\"node\":3", "a channel's node 3 does not exist"},
    {"\"sampler\":0", "\"sampler\":1", "sampler 1 does not exist"},
    {"\"path\":\"rotation\"", "\"path\":\"scale\"", "sampler 0: output: accessor 7 has the wrong type"},
    {"\"node\":2,\"path\":\"rotation\"", "\"node\":0,\"path\":\"weights\"", "node 0 has no morph targets"},
    {"\"input\":6", "\"input\":12", "input: time 1 is 0, not after 0"},
    {"\"input\":6", "\"input\":13", "input: time 1 is nan"},
    {"\"input\":6", "\"input\":14", "input: time 0 is -1"},
    {"\"input\":6", "\"input\":77", "input: accessor 77 does not exist"},
    {"\"input\":6", "\"input\":15", "output has 2 elements: 3 times want 3"},
    {"\"output\":7", "\"output\":16", "element 1 is inf"},
    {"\"output\":7", "\"output\":17", "the rotation of key 0 has the length 0"},
    {"\"output\":7", "\"output\":7,\"interpolation\":\"CUBICSPLINE\"", "output has 2 elements: 2 times want 6"},
    {"\"output\":7", "\"output\":7,\"interpolation\":\"WILD\"", "interpolation is none of LINEAR"},
    {"\"primitives\":[{", "\"primitives\":[{\"targets\":[{\"POSITION\":99}],", "target 0: POSITION: accessor 99"},
    {"\"primitives\":[{", "\"primitives\":[{\"targets\":[{\"POSITION\":18}],", "POSITION has 5 elements, POSITION 6"},
    {"\"primitives\":[{", "\"primitives\":[{\"targets\":[{\"POSITION\":19}],", "POSITION of vertex 5 is nan"},
    {"\"primitives\":[{", "\"weights\":[1,2],\"primitives\":[{\"targets\":[{\"POSITION\":0}],",
     "mesh 0 has 2 weights for 1 morph targets"},
    {"\"primitives\":[{", "\"weights\":[1e300],\"primitives\":[{\"targets\":[{\"POSITION\":0}],", "weight 0 is 1e+300"},
    {"\"primitives\":[{", "\"weights\":[3e8],\"primitives\":[{\"targets\":[{\"POSITION\":20}],",
     "move vertex 0 to 3e+16"},
    {"\"primitives\":[{", "\"primitives\":[{\"targets\":[{}],\"attributes\":{\"POSITION\":0,\"JOINTS_0\":3,"
     "\"WEIGHTS_0\":4}},{", "has 0 morph targets, another one 1"}};

static void put_faulty_column(void)
{
    const float not_a_number = nanf(""), huge = HUGE_VALF;
    float floats[32];
    static const float same[2] = {0, 0}, early[2] = {-1, 0}, three[3] = {0, 1, 2}, zero[8] = {0, 0, 0, 0, 0, 0, 0, 1};
    put_column();
    memcpy(floats, inverse_bind, sizeof floats);
    floats[20] = not_a_number;
    add_floats("\"MAT4\"", 2, floats, 32);                                   /* 8 */
    memcpy(floats, inverse_bind, sizeof floats);
    floats[15] = 0.5f;
    add_floats("\"MAT4\"", 2, floats, 32);
    add_floats("\"VEC4\"", 5, weights, 20);                                  /* 10 */
    memcpy(floats, weights, sizeof weights);
    floats[16] = -1;
    add_floats("\"VEC4\"", 6, floats, 24);
    add_floats("\"SCALAR\"", 2, same, 2);                                    /* 12 */
    floats[0] = 0;
    floats[1] = not_a_number;
    add_floats("\"SCALAR\"", 2, floats, 2);
    add_floats("\"SCALAR\"", 2, early, 2);                                   /* 14 */
    add_floats("\"SCALAR\"", 3, three, 3);
    memcpy(floats, quarter_turn, sizeof quarter_turn);
    floats[6] = huge;
    add_floats("\"VEC4\"", 2, floats, 8);                                    /* 16 */
    add_floats("\"VEC4\"", 2, zero, 8);
    add_floats("\"VEC3\"", 5, ribbon, 15);                                   /* 18 */
    memcpy(floats, ribbon, sizeof ribbon);
    floats[16] = not_a_number;
    add_floats("\"VEC3\"", 6, floats, 18);
    for (int k = 0; k < 18; k++) floats[k] = 1e8f;
    add_floats("\"VEC3\"", 6, floats, 18);                                   /* 20 */
}

static void faults_are_named_with_their_field_and_value(void **state)
{
    char good[2000], error[EX_ERROR_SIZE];
    ex_scene scene;
    (void)state;
    skip_without_parser();
    snprintf(good, sizeof good, COLUMN_MESH COLUMN_NODES COLUMN_SKIN COLUMN_TURN, 0, 1, 3, 4, 2, 5, 6, 7);
    for (size_t i = 0; i < sizeof faults / sizeof *faults; i++) {
        const char *at = strstr(good, faults[i].find);
        if (!at) fail_msg("fault %d: no %s", (int)i, faults[i].find);
        put_faulty_column();
        if (load_with(&scene, error, 0, "%.*s%s%s", (int)(at - good), good, faults[i].put,
                      at + strlen(faults[i].find)) == 0)
            fail_msg("accepted: %s", faults[i].put);
        if (!strstr(error, faults[i].says)) fail_msg("%s\nsays no '%s'", error, faults[i].says);
    }
    put_faulty_column();
    assert_int_equal(load_with(&scene, error, 1, "%s", good), -1);
    assert_non_null(strstr(error, "animation 1 does not exist, it has 1"));
}

/* Few bytes may name one array often: 330 vertices for 700 targets are refused before memory runs out. */
static void what_names_an_array_often_is_refused(void **state)
{
    enum { VERTICES = 330 };
    static char rest[16000];
    static float positions[3 * VERTICES];
    const size_t before = ex_memory_limit;
    char error[EX_ERROR_SIZE];
    uint32_t random = 1;
    ex_scene scene;
    (void)state;
    skip_without_parser();
    for (int i = 0; i < 3 * VERTICES; i++) {
        random = random * 1664525u + 1013904223u;
        positions[i] = (float)(random >> 8) / 16777216;
    }
    for (int many = 0; many < 2; many++) {
        begin();
        add_floats("\"VEC3\"", VERTICES, positions, 3 * VERTICES);
        int at = snprintf(rest, sizeof rest, "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"meshes\":"
                          "[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"targets\":[{\"POSITION\":0}");
        for (int i = 0; i < (many ? 700 : 1); i++)
            at += snprintf(rest + at, sizeof rest - (size_t)at, ",{\"POSITION\":0}");
        snprintf(rest + at, sizeof rest - (size_t)at, "]}]}]");
        ex_memory_limit = 5000000;
        const int result = load_with(&scene, error, 0, "%s", rest);
        ex_memory_limit = before;
        assert_int_equal(result, many ? -1 : 0);
        if (many) assert_non_null(strstr(error, "morph targets and animations take too much memory: --limit-memory"));
        else ex_scene_free(&scene);
    }
}

/* Every byte of arrays and numbers changed by turns: the file is refused, or all that it moves stays finite. */
static void changed_bytes_are_survived(void **state)
{
    char good[2000], error[EX_ERROR_SIZE];
    uint32_t random = 1, loaded = 0;
    (void)state;
    skip_without_parser();
    snprintf(good, sizeof good, COLUMN_MESH COLUMN_NODES COLUMN_SKIN COLUMN_TURN, 0, 1, 3, 4, 2, 5, 6, 7);
    for (int i = 0; i < 1200; i++) {
        ex_scene scene;
        char changed[2000];
        put_column();
        strcpy(changed, good);
        random = random * 1664525u + 1013904223u;
        if (i % 2) bytes[(random >> 8) % byte_count] ^= (uint8_t)(1u << (random >> 4 & 7));
        else {
            size_t at = (random >> 8) % strlen(changed);
            while (changed[at] < '0' || changed[at] > '9') at = (at + 1) % strlen(changed);
            changed[at] = (char)('0' + (random >> 4) % 10);
        }
        if (load_with(&scene, error, 0, "%s", changed) != 0) continue;
        loaded++;
        for (int k = 0; k < 3; k++) {
            if (ex_scene_set_time(&scene, 0.4f * (float)k, error) != 0)
                assert_non_null(strstr(error, "1e9 is the most"));
            for (uint32_t m = 0; m < scene.mesh_count; m++)
                for (uint32_t v = 0; v < 3 * scene.meshes[m].vertex_count; v++)
                    assert_true(isfinite(scene.meshes[m].positions[v]) && isfinite(scene.meshes[m].normals[v]));
        }
        ex_scene_free(&scene);
    }
    assert_true(loaded > 120 && loaded < 1195);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_column_of_two_bones_bends_by_90_degrees),
        cmocka_unit_test(joints_and_weights_come_in_every_form),
        cmocka_unit_test(a_vertex_may_have_eight_joints),
        cmocka_unit_test(bones_without_inverse_bind_carry_what_lies_about_them),
        cmocka_unit_test(who_asks_for_no_animation_gets_the_files_vertices),
        cmocka_unit_test(nodes_that_share_a_mesh_move_apart),
        cmocka_unit_test(a_morph_weight_moves_by_its_share),
        cmocka_unit_test(sparse_targets_move_what_they_name),
        cmocka_unit_test(sparse_accessors_that_cannot_be_are_refused),
        cmocka_unit_test(morph_targets_come_before_skins),
        cmocka_unit_test(linear_and_step_tracks_pass_through_their_keys),
        cmocka_unit_test(cubic_splines_have_their_tangents),
        cmocka_unit_test(rotations_take_the_shorter_arc),
        cmocka_unit_test(scales_and_weights_are_played),
        cmocka_unit_test(a_time_is_the_same_from_wherever_it_is_reached),
        cmocka_unit_test(faults_are_named_with_their_field_and_value),
        cmocka_unit_test(what_names_an_array_often_is_refused),
        cmocka_unit_test(changed_bytes_are_survived),
    };
    return cmocka_run_group_tests(tests, make_file, remove_file);
}
