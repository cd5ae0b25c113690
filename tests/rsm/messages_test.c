/* messages_test - a call of rsm.h that fails says why in the caller's log: the function, the field or element, its
   value and its range, in one line; one that succeeds says nothing. Normals that are not unit, indices beyond the
   vertices, 16-bit indices. */

#include "rsm.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>
#include "util.h"

static int lines;
static char last[300];

static void keep(void *user, const char *message)
{
    assert_ptr_equal(user, &lines);
    assert_null(strchr(message, '\n'));
    assert_true(strlen(message) < sizeof last);
    lines++;
    strcpy(last, message);
}

static rsm_system listening(void)
{
    rsm_system s;
    memset(&s, 0, sizeof s);
    s.log = keep;
    s.user = &lines;
    lines = 0;
    last[0] = 0;
    return s;
}

#define SAYS(call, expected, text)                                                                           \
    do {                                                                                                     \
        lines = 0;                                                                                           \
        assert_int_equal(call, expected);                                                                    \
        assert_int_equal(lines, 1);                                                                          \
        assert_string_equal(last, text);                                                                     \
    } while (0)

static void a_desc_names_field_value_and_range(void **state)
{
    rsm_desc d = sun_desc(1, 1, 8), good;
    rsm_map *map = NULL;
    float matrix[16];
    char needed[128];
    (void)state;
    d.system = listening();
    good = d;
    d.side = 3;
    SAYS(rsm_map_create(&d, &map), RSM_ERR_DESC, "rsm_map_create: desc.side is 3; it must be 0 or 4..4096");
    d = good;
    d.light.value[1] = -2.5f;
    SAYS(rsm_map_create(&d, &map), RSM_ERR_DESC, "rsm_map_create: light.value is -2.5; it must be 0..1e12");
    d = good;
    d.light.kind = RSM_LIGHT_SPOT;
    d.light.cone_half_angle = 4;
    SAYS(rsm_map_create(&d, &map), RSM_ERR_DESC,
         "rsm_map_create: light.cone_half_angle is 4; it must be above 0.0005, at most 3.14");
    d = good;
    set3(d.light.direction, 0, 0, 0);
    SAYS(rsm_map_create(&d, &map), RSM_ERR_DESC,
         "rsm_map_create: the length of light.direction is 0; it must be above 0");
    SAYS(rsm_map_init(&good, NULL, 0, &map), RSM_ERR_ARGUMENT, "rsm_map_init: memory is NULL");
    snprintf(needed, sizeof needed, "rsm_map_init: memory_bytes is 8; it must be at least %lu, rsm_map_bytes(desc)",
             (unsigned long)rsm_map_bytes(&good));
    SAYS(rsm_map_init(&good, &d, 8, &map), RSM_ERR_MEMORY, needed);
    assert_null(map);
    lines = 0;
    assert_int_equal(rsm_map_create(&good, &map), RSM_OK);
    assert_int_equal(lines, 0);
    SAYS(rsm_map_matrix(map, 1, matrix), RSM_ERR_ARGUMENT,
         "rsm_map_matrix: face is 1; it must be below 1, the number of faces");
    rsm_map_free(map);
}

static void a_bad_mesh_names_index_and_triangle(void **state)
{
    static const float corners[] = { 0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 1 };
    uint32_t wide[6] = { 0, 1, 2, 0, 4, 3 };
    uint16_t narrow[6] = { 0, 1, 2, 0, 2, 70 };
    const float unending[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, INFINITY, 0, 1 };
    rsm_desc d = sun_desc(1, 1, 8);
    rsm_mesh mesh, two[2];
    rsm_map *map;
    (void)state;
    d.system = listening();
    assert_int_equal(rsm_map_create(&d, &map), RSM_OK);
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = corners;
    mesh.vertex_count = 4;
    mesh.indices = wide;
    mesh.index_count = 6;
    two[0] = two[1] = mesh;
    two[0].index_count = 3;
    SAYS(rsm_rasterize(map, two, 2), RSM_ERR_INPUT,
         "rsm_rasterize: meshes[1]: index 1 of triangle 1 is 4, but the mesh has 4 vertices");
    mesh.indices16 = narrow;
    SAYS(rsm_rasterize(map, &mesh, 1), RSM_ERR_ARGUMENT, "rsm_rasterize: meshes[0].indices16 is set beside indices");
    mesh.indices = NULL;
    SAYS(rsm_rasterize(map, &mesh, 1), RSM_ERR_INPUT,
         "rsm_rasterize: meshes[0]: index 2 of triangle 1 is 70, but the mesh has 4 vertices");
    mesh.index_count = 5;
    SAYS(rsm_rasterize(map, &mesh, 1), RSM_ERR_ARGUMENT,
         "rsm_rasterize: meshes[0].index_count is 5; it must be a multiple of 3");
    mesh.index_count = 3;
    mesh.tap_side = 17;
    SAYS(rsm_rasterize(map, &mesh, 1), RSM_ERR_INPUT, "rsm_rasterize: meshes[0].tap_side is 17; it must be 0..16");
    mesh.tap_side = 0;
    mesh.albedo[1] = -1;
    SAYS(rsm_rasterize(map, &mesh, 1), RSM_ERR_INPUT, "rsm_rasterize: meshes[0].albedo is -1; it must be 0..1e6");
    mesh.albedo[1] = 0;
    mesh.transform = unending;
    SAYS(rsm_rasterize(map, &mesh, 1), RSM_ERR_INPUT,
         "rsm_rasterize: meshes[0].transform is infinity; it must be finite");
    mesh.transform = NULL;
    mesh.vertex_stride = 14;
    SAYS(rsm_rasterize(map, &mesh, 1), RSM_ERR_ARGUMENT,
         "rsm_rasterize: meshes[0].vertex_stride is 14; it must be 0 or a multiple of 4 from 12 on");
    mesh.vertex_stride = 0;
    mesh.positions = NULL;
    SAYS(rsm_rasterize(map, &mesh, 1), RSM_ERR_ARGUMENT, "rsm_rasterize: meshes[0].positions is NULL");
    SAYS(rsm_rasterize(map, NULL, 1), RSM_ERR_ARGUMENT, "rsm_rasterize: meshes is NULL");
    assert_int_equal(rsm_finish(map, NULL), RSM_OK);
    SAYS(rsm_finish(map, NULL), RSM_ERR_ORDER, "rsm_finish: map is finished already");
    SAYS(rsm_rasterize(map, &mesh, 1), RSM_ERR_ORDER, "rsm_rasterize: map is finished");
    rsm_map_free(map);
}

static void indices_of_16_bits_draw_the_same(void **state)
{
    static const float corners[] = { -1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1 };
    static const uint32_t wide[6] = { 0, 2, 1, 0, 3, 2 };
    static const uint16_t narrow[6] = { 0, 2, 1, 0, 3, 2 };
    rsm_desc d = sun_desc(1, 1.5, 16);
    rsm_stats stats[2];
    rsm_mesh mesh;
    rsm_map *map[2];
    int k;
    (void)state;
    for (k = 0; k < 2; k++) {
        memset(&mesh, 0, sizeof mesh);
        mesh.positions = corners;
        mesh.vertex_count = 4;
        mesh.indices = k ? NULL : wide;
        mesh.indices16 = k ? narrow : NULL;
        mesh.index_count = 6;
        set3(mesh.albedo, 0.5, 0.5, 0.5);
        map[k] = map_of(&d, &mesh, 1, &stats[k]);
        assert_non_null(map[k]);
    }
    assert_true(stats[0].lit_texels > 50);
    assert_memory_equal(rsm_map_texels(map[0]), rsm_map_texels(map[1]), 256 * sizeof(rsm_texel));
    rsm_map_free(map[0]);
    rsm_map_free(map[1]);
}

/* A desc of gather, of direct light or of interpolation may be NULL, or have no log. */
static void without_a_log_of_its_own_a_call_tells_the_map_s(void **state)
{
    float position[3] = { 0, 1, 0 }, normal[3] = { 0, 2, 0 }, e[3];
    rsm_points points = points_of(position, normal, 1, 0);
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 0);
    rsm_direct_desc direct = direct_desc();
    rsm_desc d = sun_desc(1, 1, 8);
    const rsm_map *maps[1] = { NULL };
    rsm_map *map = NULL;
    (void)state;
    d.system = listening();
    assert_int_equal(rsm_map_create(&d, &map), RSM_OK);
    maps[0] = map;
    SAYS(rsm_gather(maps, 1, NULL, &points, e, NULL), RSM_ERR_ORDER,
         "rsm_gather: maps[0] is not finished: rsm_finish must come first");
    SAYS(rsm_direct(map, NULL, &points, e), RSM_ERR_ORDER,
         "rsm_direct: map is not finished: rsm_finish must come first");
    assert_int_equal(rsm_finish(map, NULL), RSM_OK);
    SAYS(rsm_gather(maps, 1, &g, &points, e, NULL), RSM_ERR_INPUT,
         "rsm_gather: points.normals[0] has the length 2; it must be 1 (0.97..1.03), or 0");
    SAYS(rsm_direct(map, &direct, &points, e), RSM_ERR_INPUT,
         "rsm_direct: points.normals[0] has the length 2; it must be 1 (0.97..1.03), or 0");
    SAYS(rsm_interpolate(maps, 1, NULL, NULL, &points, e, NULL), RSM_ERR_INPUT,
         "rsm_interpolate: points.normals[0] has the length 2; it must be 1 (0.97..1.03), or 0");
    rsm_map_free(map);
    lines = 0;
    assert_int_equal(rsm_gather(NULL, 1, NULL, &points, e, NULL), RSM_ERR_ARGUMENT);
    assert_int_equal(lines, 0);                     /* nobody is there to tell */
}

static void normals_are_unit_or_none(void **state)
{
    static const float lengths[8] = { 1, 0.971f, 1.029f, 0, NAN, 0.969f, 1.031f, 0.5f };
    float positions[24] = { 0 }, normals[24] = { 0 }, e[24], kept[24];
    model disc = model_disc(16, 1);
    rsm_mesh mesh = mesh_of(&disc, 0.5);
    rsm_desc d = sun_desc(1, 1, 8);
    rsm_map *map = map_of(&d, &mesh, 1, NULL);
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 0);
    rsm_direct_desc direct = direct_desc();
    rsm_points points = points_of(positions, normals, 5, 0);
    rsm_texel light;
    int i;
    (void)state;
    assert_non_null(map);
    for (i = 0; i < 8; i++) {
        positions[3 * i + 1] = 1;
        normals[3 * i + 1] = -lengths[i];
    }
    g.system = direct.system = listening();
    assert_int_equal(rsm_gather((const rsm_map *const *)&map, 1, &g, &points, e, NULL), RSM_OK);
    assert_true(e[0] > 0 && e[3] > 0 && e[6] > 0 && e[9] == 0 && e[12] == 0);
    assert_int_equal(rsm_direct(map, &direct, &points, e), RSM_OK);
    assert_int_equal(lines, 0);
    points.positions = positions + 15;
    points.normals = normals + 15;
    points.count = 1;
    memset(e, 0x5a, sizeof e);
    memcpy(kept, e, sizeof e);
    SAYS(rsm_gather((const rsm_map *const *)&map, 1, &g, &points, e, NULL), RSM_ERR_INPUT,
         "rsm_gather: points.normals[0] has the length 0.969; it must be 1 (0.97..1.03), or 0");
    SAYS(rsm_direct(map, &direct, &points, e), RSM_ERR_INPUT,
         "rsm_direct: points.normals[0] has the length 0.969; it must be 1 (0.97..1.03), or 0");
    points.positions = positions;
    points.normals = normals;
    points.count = 8;
    normals[16] = -1;
    SAYS(rsm_gather((const rsm_map *const *)&map, 1, &g, &points, e, NULL), RSM_ERR_INPUT,
         "rsm_gather: points.normals[6] has the length 1.031; it must be 1 (0.97..1.03), or 0");
    assert_memory_equal(e, kept, sizeof e);
    memset(&light, 0, sizeof light);
    light.normal[0] = 2;
    SAYS(rsm_gather_list(&light, 1, &g, &points, e, NULL), RSM_ERR_INPUT,
         "rsm_gather_list: lights.normal[0] has the length 2; it must be 1 (0.97..1.03), or 0");
    rsm_map_free(map);
    model_free(&disc);
}

static void receivers_and_settings_are_named(void **state)
{
    static const float p[6] = { 0, 1, 0, 0, 1, 1 }, n[6] = { 0, -1, 0, 0, -1, 0 };
    static const uint32_t far_index[1] = { 2 };
    float e[6];
    model disc = model_disc(16, 1);
    rsm_mesh mesh = mesh_of(&disc, 0.5);
    rsm_desc d = sun_desc(1, 1, 8);
    rsm_map *map = map_of(&d, &mesh, 1, NULL);
    const rsm_map *const *maps = (const rsm_map *const *)&map;
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 0);
    rsm_points points = points_of(p, n, 2, 0);
    rsm_interpolation in;
    (void)state;
    assert_non_null(map);
    g.system = listening();
    points.indices = far_index;
    points.index_count = 1;
    SAYS(rsm_gather(maps, 1, &g, &points, e, NULL), RSM_ERR_INPUT,
         "rsm_gather: points.indices[0] is 2; it must be below points.count");
    points.indices = NULL;
    SAYS(rsm_gather(NULL, 1, &g, &points, e, NULL), RSM_ERR_ARGUMENT, "rsm_gather: maps is NULL");
    SAYS(rsm_gather(maps, 1, &g, &points, NULL, NULL), RSM_ERR_ARGUMENT, "rsm_gather: irradiance is NULL");
    g.near_field = 33;
    SAYS(rsm_gather(maps, 1, &g, &points, e, NULL), RSM_ERR_DESC,
         "rsm_gather: desc.near_field is 33; it must be 0..32");
    g.near_field = 0;
    g.interleave = 2;
    SAYS(rsm_gather(maps, 1, &g, &points, e, NULL), RSM_ERR_DESC,
         "rsm_gather: desc.interleave is 2; it must be 0 or 1 if points.width is 0: one row is no picture");
    g.interleave = 3;
    SAYS(rsm_gather(maps, 1, &g, &points, e, NULL), RSM_ERR_DESC,
         "rsm_gather: desc.interleave is 3; it must be 0, 1, 2, 4 or 8");
    g.interleave = 0;
    memset(&in, 0, sizeof in);
    SAYS(rsm_interpolate(maps, 1, &g, &in, &points, e, NULL), RSM_ERR_ARGUMENT,
         "rsm_interpolate: points.width is 0; it must be the pixels in a row, of which points.count is a multiple");
    points.width = 2;
    in.step = 5;
    SAYS(rsm_interpolate(maps, 1, &g, &in, &points, e, NULL), RSM_ERR_DESC,
         "rsm_interpolate: interpolation.step is 5; it must be 0 or a power of two, 2..64");
    SAYS(rsm_blue_noise(3, 1, &g.system, e), RSM_ERR_ARGUMENT, "rsm_blue_noise: side is 3; it must be 4..64");
    rsm_map_free(map);
    model_free(&disc);
}

/* Of several maps, materials and settings the one that is wrong is named, with its number. */
static void elements_are_named_by_their_numbers(void **state)
{
    static const float p[6] = { 0, 1, 0, 0, 1, 1 }, n[6] = { 0, -1, 0, 0, -1, 0 };
    static const uint32_t one[1] = { 0 };
    const float noise[4] = { 0, 0.5f, 1.5f, 1 };
    rsm_material materials[2];
    float e[6];
    rsm_desc d = sun_desc(1, 1, 8);
    rsm_map *maps[2], *open;
    rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, 0);
    rsm_direct_desc direct = direct_desc();
    rsm_points points = points_of(p, n, 2, 0);
    rsm_texel light;
    size_t count = 7;
    (void)state;
    memset(materials, 0, sizeof materials);
    d.system = listening();
    assert_int_equal(rsm_map_create(&d, &maps[0]), RSM_OK);
    assert_int_equal(rsm_map_create(&d, &open), RSM_OK);
    assert_int_equal(rsm_finish(maps[0], NULL), RSM_OK);
    maps[1] = NULL;
    g.system = direct.system = d.system;
    SAYS(rsm_gather((const rsm_map *const *)maps, 2, &g, &points, e, NULL), RSM_ERR_ARGUMENT,
         "rsm_gather: maps[1] is NULL");
    SAYS(rsm_gather((const rsm_map *const *)maps, 0, &g, &points, e, NULL), RSM_ERR_ARGUMENT,
         "rsm_gather: map_count is 0");
    maps[1] = open;
    SAYS(rsm_gather((const rsm_map *const *)maps, 2, &g, &points, e, NULL), RSM_ERR_ORDER,
         "rsm_gather: maps[1] is not finished: rsm_finish must come first");
    SAYS(rsm_direct(NULL, &direct, &points, e), RSM_ERR_ARGUMENT, "rsm_direct: map is NULL");
    SAYS(rsm_direct(open, &direct, &points, e), RSM_ERR_ORDER,
         "rsm_direct: map is not finished: rsm_finish must come first");
    direct.tap_side = 16;
    SAYS(rsm_direct(maps[0], &direct, &points, e), RSM_ERR_DESC, "rsm_direct: desc.tap_side is 16; it must be 0..15");
    materials[1].exponent = 2e4f;
    g.material_count = 2;
    SAYS(rsm_gather((const rsm_map *const *)maps, 1, &g, &points, e, NULL), RSM_ERR_DESC,
         "rsm_gather: desc.materials is NULL, and material_count is not 0");
    g.materials = materials;
    SAYS(rsm_gather((const rsm_map *const *)maps, 1, &g, &points, e, NULL), RSM_ERR_INPUT,
         "rsm_gather: desc.materials[1] has the exponent 20000; it must be 0..1e4");
    materials[1].exponent = 1;
    materials[0].specular[2] = 1.5f;
    SAYS(rsm_gather((const rsm_map *const *)maps, 1, &g, &points, e, NULL), RSM_ERR_INPUT,
         "rsm_gather: desc.materials[0] has the specular 1.5; it must be 0..1");
    g.materials = NULL;
    g.material_count = 0;
    g.noise = noise;
    g.noise_side = 2;
    SAYS(rsm_gather((const rsm_map *const *)maps, 1, &g, &points, e, NULL), RSM_ERR_INPUT,
         "rsm_gather: desc.noise[2] is 1.5; it must be 0..1");
    points.width = 2;
    g.noise_side = 1;
    SAYS(rsm_interpolate((const rsm_map *const *)maps, 1, &g, NULL, &points, e, NULL), RSM_ERR_DESC,
         "rsm_interpolate: desc.noise is not NULL, as it must be here");
    g.noise = NULL;
    g.interleave = 2;
    SAYS(rsm_interpolate((const rsm_map *const *)maps, 1, &g, NULL, &points, e, NULL), RSM_ERR_DESC,
         "rsm_interpolate: desc.interleave is 2; it must be 0 or 1 here");
    g.interleave = 0;
    g.add = 1;
    SAYS(rsm_interpolate((const rsm_map *const *)maps, 1, &g, NULL, &points, e, NULL), RSM_ERR_DESC,
         "rsm_interpolate: desc.add is 1; it must be 0 here");
    points.indices = one;
    points.index_count = 1;
    SAYS(rsm_interpolate((const rsm_map *const *)maps, 1, &g, NULL, &points, e, NULL), RSM_ERR_ARGUMENT,
         "rsm_interpolate: points.indices is not NULL, as it must be here");
    SAYS(rsm_pixel_lights((const rsm_map *const *)maps, 1, 0, 0, NULL, 0, NULL), RSM_ERR_ARGUMENT,
         "rsm_pixel_lights: count is NULL");
    SAYS(rsm_pixel_lights((const rsm_map *const *)maps, 1, 0, 0, NULL, 4, &count), RSM_ERR_ARGUMENT,
         "rsm_pixel_lights: lights is NULL");
    SAYS(rsm_cluster(&light, 0, 1, &d.system, NULL, &count), RSM_ERR_ARGUMENT, "rsm_cluster: clusters is NULL");
    SAYS(rsm_cluster(&light, 0, 1, &d.system, &light, NULL), RSM_ERR_ARGUMENT, "rsm_cluster: count is NULL");
    assert_int_equal(count, 7);
    rsm_map_free(maps[0]);
    rsm_map_free(open);
}

/* Each pointer, coordinate and size of the calls about one map. */
static void places_and_sizes_are_named(void **state)
{
    const float inside[3] = { 0, 0, 0 }, unending[3] = { 0, INFINITY, 0 };
    static double memory[4096];
    float uv[2], depth, matrix[16];
    char needed[128];
    model disc = model_disc(16, 1);
    rsm_mesh mesh = mesh_of(&disc, 0.5);
    rsm_desc d = sun_desc(1, 1, 8);
    rsm_light lamp;
    rsm_buffers b;
    rsm_map *map;
    size_t count;
    uint32_t face;
    (void)state;
    d.system = listening();
    d.light.up[1] = NAN;
    SAYS(rsm_map_create(&d, &map), RSM_ERR_DESC,
         "rsm_map_create: light.up is not a number; it must be finite");
    d.light.up[1] = 0;
    d.light.position[0] = 2e9f;
    SAYS(rsm_map_create(&d, &map), RSM_ERR_DESC,
         "rsm_map_create: light.position is 2000000000; it must be -1e9..1e9");
    d.light.position[0] = 0;
    d.light.far_depth = -1;
    d.light.near_depth = 1;
    SAYS(rsm_map_create(&d, &map), RSM_ERR_DESC,
         "rsm_map_create: light.far_depth is -1; it must be above near_depth, at most 1e9");
    d.light.far_depth = d.light.near_depth = 0;
    SAYS(rsm_map_create(&d, NULL), RSM_ERR_ARGUMENT, "rsm_map_create: out is NULL");
    SAYS(rsm_map_init(&d, memory, sizeof memory, NULL), RSM_ERR_ARGUMENT, "rsm_map_init: out is NULL");
    SAYS(rsm_map_init(&d, (char *)memory + 4, sizeof memory - 4, &map), RSM_ERR_MEMORY,
         "rsm_map_init: memory is not 8-byte aligned");
    d.rows = (rsm_rows)9;
    SAYS((int)rsm_map_bytes(&d), 0, "rsm_map_bytes: desc.rows is 9; it must be one of rsm_rows");
    d.rows = RSM_ROWS_DEFAULT;
    assert_int_equal(rsm_map_create(&d, &map), RSM_OK);
    lamp = d.light;
    lamp.kind = RSM_LIGHT_POINT;
    SAYS(rsm_map_restart(map, &lamp), RSM_ERR_LIMIT,
         "rsm_map_restart: the face count of light is 6; it must be at most 1, what the map was made with");
    SAYS(rsm_map_matrix(map, 0, NULL), RSM_ERR_ARGUMENT, "rsm_map_matrix: world_to_clip is NULL");
    SAYS(rsm_map_project(map, NULL, &face, uv, &depth), RSM_ERR_ARGUMENT, "rsm_map_project: point is NULL");
    SAYS(rsm_map_project(map, inside, NULL, uv, &depth), RSM_ERR_ARGUMENT, "rsm_map_project: face is NULL");
    SAYS(rsm_map_project(map, inside, &face, NULL, &depth), RSM_ERR_ARGUMENT, "rsm_map_project: uv is NULL");
    SAYS(rsm_map_project(map, inside, &face, uv, NULL), RSM_ERR_ARGUMENT, "rsm_map_project: depth is NULL");
    SAYS(rsm_map_project(map, unending, &face, uv, &depth), RSM_ERR_INPUT,
         "rsm_map_project: point is infinity; it must be -1e9..1e9");
    memset(&b, 0, sizeof b);
    SAYS(rsm_fill(map, 0, NULL), RSM_ERR_ARGUMENT, "rsm_fill: buffers is NULL");
    SAYS(rsm_fill(map, 0, &b), RSM_ERR_ARGUMENT, "rsm_fill: buffers.normals is NULL");
    b.normals = inside;
    SAYS(rsm_fill(map, 0, &b), RSM_ERR_ARGUMENT, "rsm_fill: buffers.depth is NULL, and so is positions");
    b.depth = inside;
    b.albedo_srgb_stride = 2;
    SAYS(rsm_fill(map, 0, &b), RSM_ERR_ARGUMENT,
         "rsm_fill: buffers.albedo_srgb_stride is 2; it must be 0 or at least 3");
    b.albedo_srgb_stride = 0;
    SAYS(rsm_fill(map, 3, &b), RSM_ERR_ARGUMENT, "rsm_fill: face is 3; it must be below 1, the number of faces");
    assert_int_equal(rsm_rasterize(map, &mesh, 1), RSM_OK);
    assert_int_equal(rsm_finish(map, NULL), RSM_OK);
    SAYS(rsm_fill(map, 0, &b), RSM_ERR_ORDER, "rsm_fill: map is finished");
    lines = 0;
    assert_int_equal(rsm_pixel_lights((const rsm_map *const *)&map, 1, 0, 0, NULL, 0, &count), RSM_ERR_MEMORY);
    snprintf(needed, sizeof needed, "rsm_pixel_lights: capacity is 0; it must be at least %lu, which *count says",
             (unsigned long)count);
    assert_int_equal(lines, 1);
    assert_string_equal(last, needed);
    assert_true(count > 10);
    lines = 0;                              /* without a system in reach nothing can be said */
    assert_int_equal(rsm_map_matrix(NULL, 0, matrix), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_map_project(NULL, inside, &face, uv, &depth), RSM_ERR_ARGUMENT);
    assert_int_equal(rsm_pattern_build(RSM_PATTERN_FLUX, 4, 0, 0, 1, matrix), RSM_ERR_ARGUMENT);
    assert_int_equal(lines, 0);
    rsm_map_free(map);
    model_free(&disc);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_desc_names_field_value_and_range),
        cmocka_unit_test(a_bad_mesh_names_index_and_triangle),
        cmocka_unit_test(indices_of_16_bits_draw_the_same),
        cmocka_unit_test(without_a_log_of_its_own_a_call_tells_the_map_s),
        cmocka_unit_test(normals_are_unit_or_none),
        cmocka_unit_test(receivers_and_settings_are_named),
        cmocka_unit_test(elements_are_named_by_their_numbers),
        cmocka_unit_test(places_and_sizes_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
