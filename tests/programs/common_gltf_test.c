/* common_gltf_test.c - examples/common: glTF files of every form, and hostile ones, written here as JSON. */
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

static void put_floats(const float *values, size_t count) { put(values, count * sizeof *values); }

/* A unit square in the plane z = 0 that faces +Z: four corners, then 16-, 8- and 32-bit indices. */
static void put_square(void)
{
    static const float corners[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    static const uint16_t shorts[6] = {0, 1, 2, 0, 2, 3};
    static const uint8_t chars[8] = {0, 1, 2, 0, 2, 3, 0, 0}, strip[4] = {0, 1, 3, 2};
    static const uint32_t ints[6] = {0, 1, 2, 0, 2, 3};
    byte_count = 0;
    put_floats(corners, 12);                 /* at 0 */
    put(shorts, sizeof shorts);              /* at 48 */
    put(chars, sizeof chars);                /* at 60 */
    put(ints, sizeof ints);                  /* at 68 */
    put(strip, sizeof strip);                /* at 92 */
}

#define VIEWS "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48,\"byteLength\":12}," \
    "{\"buffer\":0,\"byteOffset\":60,\"byteLength\":8},{\"buffer\":0,\"byteOffset\":68,\"byteLength\":24}," \
    "{\"buffer\":0,\"byteOffset\":92,\"byteLength\":4}],"
#define POSITIONS "{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"}"
#define SCALARS(view, type, count) \
    "{\"bufferView\":" view ",\"componentType\":" type ",\"count\":" count ",\"type\":\"SCALAR\"}"
#define SHORTS SCALARS("1", "5123", "6")
#define ACCESSORS "\"accessors\":[" POSITIONS "," SHORTS "," SCALARS("2", "5121", "6") "," \
    SCALARS("3", "5125", "6") "," SCALARS("4", "5121", "4") "],"
#define MESH(rest) "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}" rest "}]}]"
#define NODE ",\"nodes\":[{\"mesh\":0,\"name\":\"square\"}],\"scenes\":[{\"nodes\":[0]}]"

static double area_and_normal(const ex_mesh *mesh)
{
    double area = 0;
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        const float *p[3];
        for (uint32_t k = 0; k < 3; k++) {
            p[k] = mesh->positions + 3 * mesh->indices[3 * t + k];
            assert_near(mesh->normals[3 * mesh->indices[3 * t + k] + 2], 1, 1e-6);
        }
        area += 0.5 * (double)((p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]));
    }
    return area;
}

static void gltf_geometry_comes_in_every_form(void **state)
{
    static const char *const meshes[] = {MESH(",\"indices\":1"), MESH(",\"indices\":2"), MESH(",\"indices\":3"),
                                         MESH(",\"indices\":4,\"mode\":5"), MESH(",\"mode\":6")};
    char error[EX_ERROR_SIZE], json[2048];
    ex_scene scene;
    (void)state;
    skip_without_parser();
    for (size_t i = 0; i < sizeof meshes / sizeof *meshes; i++) {
        put_square();
        snprintf(json, sizeof json, "%s%s%s%s", VIEWS, ACCESSORS, meshes[i], NODE);
        assert_int_equal(load_json(&scene, error, json), 0);
        assert_int_equal(scene.mesh_count, 1);
        assert_int_equal(ex_scene_triangles(&scene), 2);
        assert_string_equal(scene.objects[0].name, "square");
        assert_near(area_and_normal(&scene.meshes[0]), 1, 1e-6);
        assert_near(scene.materials[scene.meshes[0].materials[0]].base_color[0], 1, 0);
        assert_false(scene.has_camera);
        ex_scene_free(&scene);
    }
    put_square();                            /* points and lines are no surface */
    assert_int_equal(load_json(&scene, error, VIEWS ACCESSORS MESH(",\"mode\":1") NODE), -1);
}

static void gltf_nodes_place_objects_lights_and_camera(void **state)
{
    static const char json[] = VIEWS ACCESSORS MESH(",\"indices\":1") ","
        "\"extensionsUsed\":[\"KHR_lights_punctual\"],\"extensions\":{\"KHR_lights_punctual\":{\"lights\":["
        "{\"type\":\"directional\",\"intensity\":3,\"color\":[1,0.5,0]},{\"type\":\"point\",\"intensity\":2},"
        "{\"type\":\"spot\",\"intensity\":4,\"spot\":{\"outerConeAngle\":0.5}}]}},"
        "\"cameras\":[{\"type\":\"orthographic\",\"orthographic\":{\"xmag\":1,\"ymag\":1,\"zfar\":9,\"znear\":1}},"
        "{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.7,\"znear\":0.1}}],"
        "\"nodes\":[{\"translation\":[1,2,3],\"scale\":[2,2,2],\"children\":[1,2,3]},"
        "{\"mesh\":0,\"rotation\":[0,0.70710678,0,0.70710678]},{\"mesh\":0,"
        "\"matrix\":[-1,0,0,0, 0,1,0,0, 0,0,1,0, 5,0,0,1]},"
        "{\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}},\"camera\":0},"
        "{\"extensions\":{\"KHR_lights_punctual\":{\"light\":1}},\"translation\":[0,7,0],\"camera\":1},"
        "{\"extensions\":{\"KHR_lights_punctual\":{\"light\":2}},\"rotation\":[-0.70710678,0,0,0.70710678]}],"
        "\"scenes\":[{\"nodes\":[0,4,5]}]";
    char error[EX_ERROR_SIZE];
    ex_scene scene;
    (void)state;
    skip_without_parser();
    put_square();
    assert_int_equal(load_json(&scene, error, json), 0);
    assert_int_equal(scene.object_count, 2);
    assert_int_equal(scene.mesh_count, 1);
    /* Object 0: a quarter turn about +Y takes +X to -Z; then twice as large, then moved. */
    const float *m = scene.objects[0].transform;
    assert_near(m[2], -2, 1e-6);
    assert_near(m[8], 2, 1e-6);
    assert_near(m[13], 2, 1e-6);
    assert_near(scene.objects[1].transform[0], -2, 1e-6);
    assert_near(scene.objects[1].transform[12], 11, 1e-6);
    assert_int_equal(scene.light_count, 3);
    assert_int_equal(scene.lights[0].kind, EX_LIGHT_SUN);
    assert_near(scene.lights[0].direction[2], 1, 1e-6);         /* it shines along -Z: the sun stands at +Z */
    assert_near(scene.lights[0].value[1], 1.5, 1e-6);
    assert_int_equal(scene.lights[1].kind, EX_LIGHT_POINT);
    assert_near(scene.lights[1].position[1], 7, 1e-6);
    assert_int_equal(scene.lights[2].kind, EX_LIGHT_SPOT);
    assert_near(scene.lights[2].direction[1], -1, 1e-6);
    assert_near(scene.lights[2].cos_half_angle, cos(0.5), 1e-6);
    assert_true(scene.has_camera);           /* the first perspective one */
    assert_near(scene.camera.fovy, 0.7, 1e-6);
    assert_near(scene.camera.eye[1], 7, 1e-6);
    assert_near(scene.camera.target[2], -1, 1e-6);
    ex_scene_free(&scene);
}

/* A 2 x 1 PNG, RGBA: opaque sRGB (188, 0, 0), then transparent white. */
static const char png_uri[] = "data:image/png;base64,"
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAYAAAD0In+KAAAAD0lEQVR4nGPYw8DwHwgYABPbBLlr1BJyAAAAAElFTkSuQmCC";

static void gltf_materials_and_textures_are_read(void **state)
{
    char error[EX_ERROR_SIZE], json[4096];
    ex_scene scene;
    static const float uvs[8] = {0.25f, 0.5f, 0.75f, 0.5f, 0.75f, 0.5f, 0.25f, 0.5f};
    (void)state;
    skip_without_parser();
    put_square();
    put_floats(uvs, 8);                      /* at 96 */
    snprintf(json, sizeof json,
             "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":96,\"byteLength\":32}],"
             "\"accessors\":[" POSITIONS ",{\"bufferView\":1,\"componentType\":5126,\"count\":4,\"type\":\"VEC2\"}],"
             "\"images\":[{\"uri\":\"%s\"}],\"textures\":[{\"source\":0}],"
             "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,1,1,0.8],"
             "\"baseColorTexture\":{\"index\":0},"
             "\"metallicFactor\":0.25,\"roughnessFactor\":0.75},\"alphaMode\":\"MASK\",\"alphaCutoff\":0.4,"
             "\"doubleSided\":true,"
             "\"emissiveFactor\":[1,0.5,0],\"emissiveTexture\":{\"index\":0},"
             "\"extensions\":{\"KHR_materials_emissive_strength\":{\"emissiveStrength\":6}}}],"
             "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1},\"mode\":6,"
             "\"material\":0}]}]" NODE,
             png_uri);
    assert_int_equal(load_json(&scene, error, json), 0);
    const ex_material *m = &scene.materials[0];
    assert_near(m->emission[0], 6 * (0.50289 + 1) / 2, 1e-3);      /* times the mean of its texture */
    assert_near(m->emission[1], 3 * 0.5, 1e-6);
    assert_near(m->emission[2], 0, 0);
    assert_near(m->alpha_cutoff, 0.5, 1e-6);          /* 0.4 of a constant alpha of 0.8 */
    assert_near(m->metallic, 0.25, 1e-6);
    assert_near(m->roughness, 0.75, 1e-6);
    assert_int_equal(m->double_sided, 1);
    assert_true(ex_scene_has_emitters(&scene));
    assert_int_equal(scene.texture_count, 1);
    assert_int_equal(scene.textures[0].width, 2);
    assert_int_equal(scene.textures[0].rgba[0], 188);
    const float left[3] = {1, 0, 0}, right[3] = {0, 1, 0};
    float albedo[3];
    assert_int_equal(ex_surface_color(&scene, &scene.objects[0], 0, left, albedo), 1);
    assert_near(albedo[0], 0.5 * 0.5029, 1e-4);       /* factor times 188 made linear */
    assert_near(albedo[1], 0, 1e-6);
    assert_int_equal(ex_surface_color(&scene, &scene.objects[0], 0, right, albedo), 0);
    ex_scene_free(&scene);
}

/* Maps of normals and roughness are read by those alone who ask, with the texture coordinates that they name. */
static void gltf_normal_and_rough_maps_are_read_where_they_are_wanted(void **state)
{
    static const float first[8] = {0, 0, 0, 0, 0, 0, 0, 0};
    static const float second[8] = {0.25f, 0.5f, 0.75f, 0.5f, 0.75f, 0.5f, 0.25f, 0.5f};
    char error[EX_ERROR_SIZE], json[4096];
    ex_scene scene;
    (void)state;
    skip_without_parser();
    put_square();
    put_floats(first, 8);                    /* at 96 */
    put_floats(second, 8);
    snprintf(json, sizeof json,
             "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":96,\"byteLength\":32},"
             "{\"buffer\":0,\"byteOffset\":128,\"byteLength\":32}],"
             "\"accessors\":[" POSITIONS ",{\"bufferView\":1,\"componentType\":5126,\"count\":4,\"type\":\"VEC2\"},"
             "{\"bufferView\":2,\"componentType\":5126,\"count\":4,\"type\":\"VEC2\"}],"
             "\"images\":[{\"uri\":\"%s\"}],\"textures\":[{\"source\":0}],"
             "\"materials\":[{\"normalTexture\":{\"index\":0,\"texCoord\":1}},"
             "{\"pbrMetallicRoughness\":{\"metallicRoughnessTexture\":{\"index\":0,\"texCoord\":1}}},"
             "{\"normalTexture\":{\"index\":0,\"texCoord\":1},"
             "\"pbrMetallicRoughness\":{\"metallicRoughnessTexture\":{\"index\":0}}}],"
             "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1,\"TEXCOORD_1\":2},\"mode\":6,"
             "\"material\":0}]}]" NODE,
             png_uri);
    assert_int_equal(load_json(&scene, error, json), 0);
    assert_int_equal(scene.materials[0].normal_texture, -1);
    assert_int_equal(scene.materials[1].rough_texture, -1);
    assert_null(scene.meshes[0].uvs);
    ex_scene_free(&scene);
    ex_normal_maps = 1;
    assert_int_equal(ex_scene_load(&scene, file_name, error), 0);
    ex_normal_maps = 0;
    assert_int_equal(scene.materials[0].normal_texture, 0);
    assert_int_equal(scene.materials[0].base_texture, -1);
    assert_int_equal(scene.materials[1].rough_texture, 0);
    assert_int_equal(scene.materials[2].normal_texture, 0);
    assert_int_equal(scene.materials[2].rough_texture, -1);        /* by other coordinates than the normals */
    assert_int_equal(scene.textures[0].rgba[0], 188);
    assert_near(scene.meshes[0].uvs[0], 0.25, 0);
    ex_scene_free(&scene);
}

/* What lets more than half of the light through is not there; its texture enters as the mean of its red. */
static void gltf_glass_is_left_out(void **state)
{
    static const struct { const char *material; int is_left_out; } cases[] = {
        {"\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":0.6}}", 1},
        {"\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":0.4}}", 0},
        {"\"extensions\":{\"KHR_materials_transmission\":{}}", 0},
        {"\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":\"1\"}}", 0},
        {"\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":-1e300,"
         "\"transmissionTexture\":{\"index\":1e300}}}", 0},
        /* red is 188 and 255: 0.87 of it goes through */
        {"\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":0.6,"
         "\"transmissionTexture\":{\"index\":0}}}", 1},
        {"\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":0.56,"
         "\"transmissionTexture\":{\"index\":0}}}", 0},
        {"\"alphaMode\":\"BLEND\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1,0.4]}", 1},
        {"\"alphaMode\":\"BLEND\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1,0.8]}", 0},
        {"\"alphaMode\":\"BLEND\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1,0.8]},"
         "\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":0.45}}", 1}};
    char error[EX_ERROR_SIZE], json[2048];
    ex_scene scene;
    (void)state;
    skip_without_parser();
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        put_square();
        snprintf(json, sizeof json, "%s%s\"images\":[{\"uri\":\"%s\"}],\"textures\":[{\"source\":0}],"
                 "\"materials\":[{%s}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,"
                 "\"material\":0},{\"attributes\":{\"POSITION\":0},\"indices\":1}]}]" NODE, VIEWS, ACCESSORS, png_uri,
                 cases[i].material);
        if (load_json(&scene, error, json) != 0) fail_msg("%s: %s", cases[i].material, error);
        if (ex_scene_triangles(&scene) != (cases[i].is_left_out ? 2 : 4)) fail_msg("%s", cases[i].material);
        ex_scene_free(&scene);
    }
}

static void gltf_bad_elements_are_skipped_and_counted(void **state)
{
    char error[EX_ERROR_SIZE];
    ex_scene scene;
    (void)state;
    skip_without_parser();
    const float inf = INFINITY, nan = NAN;
    const float corners[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, inf, 0, 0, nan, nan, nan, 0, 1e30f, 0};
    const uint16_t indices[] = {0, 1, 2,  0, 2, 3,  0, 1, 4,  5, 1, 0,  0, 1, 6,  0, 1, 7,  0, 1, 65535,  2, 2, 3,  0,
        1, 1};
    byte_count = 0;
    put_floats(corners, 21);
    put(indices, sizeof indices);
    assert_int_equal(load_json(&scene, error,
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":84},{\"buffer\":0,\"byteOffset\":84,\"byteLength\":54}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":7,\"type\":\"VEC3\"},"
        "{\"bufferView\":1,\"componentType\":5123,\"count\":27,\"type\":\"SCALAR\"}]," MESH(",\"indices\":1") NODE), 0);
    assert_int_equal(ex_scene_triangles(&scene), 2);
    assert_int_equal(scene.skipped_vertices, 3);
    assert_int_equal(scene.skipped_triangles, 7);
    assert_near(area_and_normal(&scene.meshes[0]), 1, 1e-6);
    ex_scene_free(&scene);
}

static void gltf_hostile_files_are_refused(void **state)
{
#define WITH(positions, indices) VIEWS "\"accessors\":[" positions "," indices "]," MESH(",\"indices\":1") NODE
#define SQUARE VIEWS ACCESSORS MESH(",\"indices\":1")
    static const char *const files[] = {
        "",
        "\"nodes\":[{}]",
        /* accessors: wrong type, component type, count, stride, beyond the buffer, missing, sparse without data */
        WITH("{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC2\"}", SHORTS),
        WITH("{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"MAT4\"}", SHORTS),
        WITH("{\"bufferView\":0,\"componentType\":1234,\"count\":4,\"type\":\"VEC3\"}", SHORTS),
        WITH("{\"bufferView\":0,\"componentType\":5126,\"count\":5,\"type\":\"VEC3\"}", SHORTS),
        WITH("{\"bufferView\":0,\"componentType\":5126,\"count\":4000000000,\"type\":\"VEC3\"}", SHORTS),
        WITH("{\"bufferView\":0,\"componentType\":5126,\"count\":0,\"type\":\"VEC3\"}", SHORTS),
        WITH("{\"bufferView\":0,\"byteOffset\":47,\"componentType\":5126,\"count\":1,\"type\":\"VEC3\"}", SHORTS),
        WITH("{\"bufferView\":0,\"byteOffset\":4000000000,\"componentType\":5126,\"count\":1,\"type\":\"VEC3\"}",
            SHORTS),
        WITH("{\"bufferView\":9,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"}", SHORTS),
        WITH("{\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"}", SHORTS),
        WITH(POSITIONS, "{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"SCALAR\"}"),
        WITH(POSITIONS, "{\"bufferView\":1,\"componentType\":5122,\"count\":6,\"type\":\"SCALAR\"}"),
        WITH(POSITIONS, "{\"bufferView\":1,\"componentType\":5123,\"count\":7,\"type\":\"SCALAR\"}"),
        WITH(POSITIONS, "{\"bufferView\":1,\"componentType\":5123,\"count\":6,\"type\":\"VEC3\"}"),
        VIEWS ACCESSORS MESH(",\"indices\":99") NODE,
        VIEWS ACCESSORS MESH(",\"indices\":1,\"material\":3") NODE,
        VIEWS ACCESSORS "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":77}}]}]" NODE,
        VIEWS ACCESSORS "\"meshes\":[{\"primitives\":[{\"attributes\":{\"NORMAL\":0}}]}]" NODE,
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":480}],\"accessors\":[" POSITIONS "]," MESH("") NODE,
        "\"bufferViews\":[{\"buffer\":0,\"byteOffset\":4294967290,\"byteLength\":48}],"
        "\"accessors\":[" POSITIONS "]," MESH("") NODE,
        "\"bufferViews\":[{\"buffer\":3,\"byteLength\":48}],\"accessors\":[" POSITIONS "]," MESH("") NODE,
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48,\"byteStride\":4}],"
        "\"accessors\":[" POSITIONS "]," MESH("") NODE,
        /* node graphs: a cycle, a node with two parents, itself, unknown nodes and meshes */
        SQUARE ",\"nodes\":[{\"children\":[1]},{\"children\":[0],\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}]",
        SQUARE ",\"nodes\":[{\"children\":[1,1]},{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}]",
        SQUARE ",\"nodes\":[{\"children\":[0],\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}]",
        SQUARE ",\"nodes\":[{\"children\":[5],\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}]",
        SQUARE ",\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0,-3]}]",
        SQUARE ",\"nodes\":[{\"mesh\":8}],\"scenes\":[{\"nodes\":[0]}]",
        SQUARE ",\"nodes\":[{\"mesh\":0,\"scale\":[0,0,0]}],\"scenes\":[{\"nodes\":[0]}]",
        SQUARE ",\"nodes\":[{\"mesh\":0,\"translation\":[1e39,0,0]}],\"scenes\":[{\"nodes\":[0]}]",
        SQUARE ",\"nodes\":[{\"mesh\":0,\"matrix\":[1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1]}],\"scenes\":[{\"nodes\":[0]}]",
        SQUARE NODE ",\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]",
        SQUARE NODE ",\"buffers\":[{\"byteLength\":10,\"uri\":\"missing.bin\"}]",
        SQUARE NODE ",\"images\":[{\"uri\":\"missing.png\"}],\"materials\":[{}"};
    char error[EX_ERROR_SIZE];
    ex_scene scene;
    (void)state;
    skip_without_parser();
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        put_square();
        if (load_json(&scene, error, files[i]) == 0) fail_msg("accepted: %s", files[i]);
    }
    /* A long chain of nodes is no cycle, and must not need a deep stack. */
    static char chain[2500000];
    size_t at = (size_t)snprintf(chain, sizeof chain, "%s,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[", SQUARE);
    for (int i = 0; i < 100000; i++)
        at += (size_t)snprintf(chain + at, sizeof chain - at, "{\"children\":[%d]},", i + 1);
    snprintf(chain + at, sizeof chain - at, "{\"mesh\":0}]");
    put_square();
    assert_int_equal(load_json(&scene, error, chain), 0);
    assert_int_equal(scene.object_count, 1);
    ex_scene_free(&scene);
    assert_int_equal(ex_scene_load(&scene, "/nonexistent.glb", error), -1);
    assert_int_equal(ex_scene_load(&scene, "/nonexistent.gltf", error), -1);
}

/* A .glb with a million triangles, its `meshes` and `nodes` as given. */
static int load_million(ex_scene *scene, char *error, const char *json)
{
    enum { TRIANGLES = 1000000, CORNERS = 3 * TRIANGLES, BIN = 72 + CORNERS };
    static const float corners[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    static char text[20000];
    int length = snprintf(text, sizeof text, "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":%d}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,\"byteLength\":36},"
        "{\"buffer\":0,\"byteOffset\":72,\"byteLength\":%d}],\"accessors\":["
        "{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
        "{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
        "{\"bufferView\":2,\"componentType\":5121,\"count\":%d,\"type\":\"SCALAR\"}],%s}", BIN, CORNERS, CORNERS, json);
    char name[sizeof file_name + 4];
    assert_true(length > 0 && length < (int)sizeof text - 4);
    for (; length % 4; length++) text[length] = ' ';
    const uint32_t head[5] = {0x46546c67, 2, 28 + (uint32_t)length + BIN, (uint32_t)length, 0x4e4f534a};
    const uint32_t chunk[2] = {BIN, 0x004e4942};
    snprintf(name, sizeof name, "%.*s.glb", (int)strlen(file_name) - 5, file_name);
    FILE *file = fopen(name, "wb");
    assert_non_null(file);
    fwrite(head, 1, sizeof head, file);
    fwrite(text, 1, (size_t)length, file);
    fwrite(chunk, 1, sizeof chunk, file);
    fwrite(corners, 1, sizeof corners, file);
    for (int i = 0; i < CORNERS; i++) fputc(i % 3, file);
    assert_int_equal(fclose(file), 0);
    int result = ex_scene_load(scene, name, error);
    unlink(name);
    return result;
}

/* Few bytes may name one array a hundred times: refused before memory runs out. */
static void gltf_that_multiplies_is_refused(void **state)
{
    static const char part[] = "{\"attributes\":{\"POSITION\":0,\"NORMAL\":1},\"indices\":2}";
    static char json[16000];
    char error[EX_ERROR_SIZE];
    ex_scene scene;
    (void)state;
    skip_without_parser();
    for (int bomb = 0; bomb < 3; bomb++) {               /* none, of nodes, of primitives */
        size_t at = (size_t)snprintf(json, sizeof json, "\"meshes\":[{\"primitives\":[%s", part);
        for (int i = 0; bomb == 2 && i < 100; i++) at += (size_t)snprintf(json + at, sizeof json - at, ",%s", part);
        at += (size_t)snprintf(json + at, sizeof json - at, "]}],\"nodes\":[{\"mesh\":0}");
        for (int i = 0; bomb == 1 && i < 100; i++) at += (size_t)snprintf(json + at, sizeof json - at, ",{\"mesh\":0}");
        snprintf(json + at, sizeof json - at, "]");
        assert_int_equal(load_million(&scene, error, json), bomb ? -1 : 0);
        if (bomb) assert_non_null(strstr(error, bomb == 1 ? "nodes place more" : "meshes have more"));
        else assert_int_equal(ex_scene_triangles(&scene), 1000000);
        ex_scene_free(&scene);
    }
}

/* Binary files cut short, and with one byte changed, must fail or load, never crash. */
static void glb_mutations_are_survived(void **state)
{
    char error[EX_ERROR_SIZE], json[1024];
    uint8_t glb[2048], changed[2048];
    (void)state;
    skip_without_parser();
    put_square();
    int length = snprintf(json, sizeof json, "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":96}],%s}",
        SQUARE NODE);
    while (length % 4) json[length++] = ' ';
    uint32_t head[5] = {0x46546c67, 2, 20 + (uint32_t)length + 8 + 96, (uint32_t)length, 0x4e4f534a}, chunk[2] = {96,
        0x004e4942};
    memcpy(glb, head, 20);
    memcpy(glb + 20, json, (size_t)length);
    memcpy(glb + 20 + length, chunk, 8);
    memcpy(glb + 28 + length, bytes, 96);
    strcpy(file_name + strlen(file_name) - 5, ".glb");
    uint32_t random = 1;
    for (size_t i = 0; i < 3000; i++) {
        ex_scene scene;
        size_t size = i < head[2] ? i : head[2];
        memcpy(changed, glb, sizeof glb);
        random = random * 1664525u + 1013904223u;
        if (i > head[2]) changed[random % head[2]] ^= (uint8_t)(1u << (random >> 24 & 7));
        FILE *file = fopen(file_name, "wb");
        assert_non_null(file);
        fwrite(changed, 1, size, file);
        fclose(file);
        int result = ex_scene_load(&scene, file_name, error);
        if (i == head[2]) assert_int_equal(result, 0);
        if (i < head[2]) assert_int_equal(result, -1);
        if (result == 0) ex_scene_free(&scene);
    }
    unlink(file_name);
    strcpy(file_name + strlen(file_name) - 4, ".gltf");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gltf_geometry_comes_in_every_form),
        cmocka_unit_test(gltf_nodes_place_objects_lights_and_camera),
        cmocka_unit_test(gltf_materials_and_textures_are_read),
        cmocka_unit_test(gltf_normal_and_rough_maps_are_read_where_they_are_wanted),
        cmocka_unit_test(gltf_glass_is_left_out),
        cmocka_unit_test(gltf_bad_elements_are_skipped_and_counted),
        cmocka_unit_test(gltf_hostile_files_are_refused),
        cmocka_unit_test(gltf_that_multiplies_is_refused),
        cmocka_unit_test(glb_mutations_are_survived),
    };
    return cmocka_run_group_tests(tests, make_file, remove_file);
}
