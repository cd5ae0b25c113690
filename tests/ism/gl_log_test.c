/* gl_log_test - what gl_ism.h says when a call fails: one line that names the function, the field or element, its value
   and its range; and lists of an ism_create with another desc, which are refused. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "ism.h"
#include "gl_backend/gl_ism.h"

#include "gl_test.h"
#include "gl_says.h"

enum { SIDE = 4 };

static const float corners[12] = { -1, 1, -1, 1, 1, -1, -1, 1, 1, 1, 1, 1 };
static const uint32_t triangles[6] = { 0, 1, 2, 1, 3, 2 };
static const ism_surfel surfels[2 * 16];

/* Two VPLs of 8 x 8 texels and 16 surfels in two phases, two near points each. */
static ism_desc sizes(void)
{
    ism_desc d;
    memset(&d, 0, sizeof d);
    d.vpl_count = d.lazy_frames = 2;
    d.surfel_count = 16;
    d.tile_side = 8;
    d.near_point_count = 2;
    return d;
}

static glbk_ism_maps make_maps(gl_test *t)
{
    const ism_desc d = sizes();
    glbk_ism_maps m;
    assert_glbk(t, glbk_ism_maps_create(&t->gl, &d, &m));
    return m;
}

/* ---- lists of another desc ---- */

/* What ism.h chose with a desc, for maps of sizes(): the surfels of phase 0, and the VPLs. */
static void send(gl_test *t, glbk_ism_maps *m, const ism_desc *d, glbk_result surfels_wanted, const char *surfels_text,
                 glbk_result vpls_wanted, const char *vpls_text)
{
    static const float place[3] = { 0, 3, 0 }, down[3] = { 0, -1, 0 }, flux[3] = { 1, 1, 1 };
    static const float seen[3] = { 0, 0, 0 }, up[3] = { 0, 1, 0 };
    static ism_surfel list[1024];
    const ism_mesh mesh = { corners, 4, 0, triangles, 6, NULL, NULL, NULL, NULL, NULL };
    ism_source source;
    ism_points view;
    ism_frame frame;
    ism_maps *maps;
    ism_info info;
    const ism_vpl *vpls;
    size_t count;
    memset(&source, 0, sizeof source);
    memset(&view, 0, sizeof view);
    memset(&frame, 0, sizeof frame);
    source.width = source.height = 1;
    source.scattered = 1;
    source.positions = place;
    source.normals = down;
    source.fluxes = flux;
    view.count = 1;
    view.positions = seen;
    view.normals = up;
    frame.mesh = &mesh;
    frame.sources = &source;
    frame.source_count = 1;
    frame.points = &view;
    assert_int_equal(ism_create(d, &maps), ISM_OK);
    assert_int_equal(ism_choose(maps, &frame), ISM_OK);
    assert_int_equal(ism_scatter(maps, &frame), ISM_OK);
    assert_int_equal(ism_phase_surfels(maps, 0, list, 1024, &count), ISM_OK);
    if (surfels_text) SAYS(glbk_ism_surfels_upload(&t->gl, m, 0, list, count), surfels_wanted, surfels_text);
    else assert_glbk(t, glbk_ism_surfels_upload(&t->gl, m, 0, list, count));
    vpls = ism_vpls(maps, &count);
    ism_get_info(maps, &info);
    if (vpls_text) SAYS(glbk_ism_vpls_upload(&t->gl, m, vpls, 1, &info), vpls_wanted, vpls_text);
    else assert_glbk(t, glbk_ism_vpls_upload(&t->gl, m, vpls, 1, &info));
    ism_free(maps);
}

static void lists_of_another_desc_are_refused(void **state)
{
    GL_TEST(t, state)
    const glbk_result no = GLBK_ERR_MISMATCH;
    glbk_ism_maps m = make_maps(t);
    ism_desc d = sizes();
    gl_listen(t);
    send(t, &m, &d, GLBK_OK, NULL, GLBK_OK, NULL);
    d.vpl_count = 4;                    /* more surfels than the maps have room for */
    send(t, &m, &d, no, "glbk_ism_surfels_upload: count is 32; it must be 16, as glbk_ism_maps_create was told: "
                        "give ism_create the same desc", GLBK_OK, NULL);
    d.vpl_count = 1;                    /* fewer than the maps would read */
    send(t, &m, &d, no, "glbk_ism_surfels_upload: count is 8; it must be 16, as glbk_ism_maps_create was told: "
                        "give ism_create the same desc", GLBK_OK, NULL);
    d.vpl_count = 4;                    /* as many, by chance */
    d.surfel_count = 8;
    send(t, &m, &d, GLBK_OK, NULL, no, "glbk_ism_vpls_upload: info.surfel_count is 8; it must be 16, as "
                                       "glbk_ism_maps_create was told: give ism_create the same desc");
    d = sizes();
    d.tile_side = 16;
    send(t, &m, &d, GLBK_OK, NULL, no, "glbk_ism_vpls_upload: info.tile_side is 16; it must be 8, as "
                                       "glbk_ism_maps_create was told: give ism_create the same desc");
    d = sizes();
    d.vpl_count = 4;
    d.lazy_frames = 4;
    send(t, &m, &d, GLBK_OK, NULL, no, "glbk_ism_vpls_upload: info.lazy_frames is 4; it must be 2, as "
                                       "glbk_ism_maps_create was told: give ism_create the same desc");
    glbk_ism_maps_free(&t->gl, &m);
}

/* ---- lists ---- */

static void a_wrong_vpl_is_named(void **state)
{
    GL_TEST(t, state)
    glbk_context *gl = &t->gl;
    const glbk_result no = GLBK_ERR_INPUT;
    ism_vpl v[2] = { { { 0, 2, 0 }, { 0, -1, 0 }, { 1, 1, 1 }, { 0, -1, 0 }, 1, 0, 0.1f, 0, 0, 0, 0, 0, 0 },
                     { { 0, 2, 0 }, { 0, -1, 0 }, { 1, 1, 1 }, { 0, -1, 0 }, 1, 0, 0.1f, 0, 0, 0, 0, 0, 0 } };
    ism_info info;
    glbk_ism_maps m = make_maps(t), none;
    memset(&info, 0, sizeof info);
    memset(&none, 0, sizeof none);
    gl_listen(t);
    assert_glbk(t, glbk_ism_vpls_upload(gl, &m, v, 2, &info));
#define VPLS(count) glbk_ism_vpls_upload(gl, &m, v, count, &info)
    SAYS(glbk_ism_vpls_upload(gl, NULL, v, 2, &info), GLBK_ERR_ARGUMENT, "glbk_ism_vpls_upload: maps is NULL");
    SAYS(glbk_ism_vpls_upload(gl, &none, v, 2, &info), GLBK_ERR_ARGUMENT,
         "glbk_ism_vpls_upload: maps were not created");
    SAYS(glbk_ism_vpls_upload(gl, &m, NULL, 2, &info), GLBK_ERR_ARGUMENT, "glbk_ism_vpls_upload: vpls is NULL");
    SAYS(glbk_ism_vpls_upload(gl, &m, v, 2, NULL), GLBK_ERR_ARGUMENT, "glbk_ism_vpls_upload: info is NULL");
    SAYS(VPLS(3), GLBK_ERR_LIMIT, "glbk_ism_vpls_upload: count is 3; it must be 0..2");
    SAYS_OF(info.radius, -1, VPLS(2), no,
            "glbk_ism_vpls_upload: info.radius is -1; it must be finite and not negative");
    SAYS_OF(info.center[2], NAN, VPLS(2), no, "glbk_ism_vpls_upload: info.center is not a number; it must be finite");
    SAYS_OF(v[1].directional, 1, VPLS(2), no,
            "glbk_ism_vpls_upload: info.radius is 0; it must be above 0, since there is a directional VPL");
    SAYS_OF(v[1].position[2], INFINITY, VPLS(2), no,
            "glbk_ism_vpls_upload: vpls[1].position[2] is infinity; it must be finite");
    SAYS_OF(v[1].flux[0], -1, VPLS(2), no, "glbk_ism_vpls_upload: vpls[1].flux[0] is -1; it must be 0..1e30");
    SAYS_OF(v[1].normal[1], -2, VPLS(2), no,
            "glbk_ism_vpls_upload: vpls[1].normal's length is 2; it must be 1 (0.97..1.03)");
    SAYS_OF(v[0].axis[1], 0, VPLS(2), no,
            "glbk_ism_vpls_upload: vpls[0].axis's length is 0; it must be 1 (0.97..1.03)");
    SAYS_OF(v[1].exponent, -1, VPLS(2), no, "glbk_ism_vpls_upload: vpls[1].exponent is -1; it must be 0..1e5");
    SAYS_OF(v[1].edge, -0.5f, VPLS(2), no,
            "glbk_ism_vpls_upload: vpls[1].edge is -0.5; it must be finite and not negative");
    SAYS_OF(v[1].reach, NAN, VPLS(2), no,
            "glbk_ism_vpls_upload: vpls[1].reach is not a number; it must be finite and not negative");
    SAYS_OF(v[1].window, 1u << 24, VPLS(2), no,
            "glbk_ism_vpls_upload: vpls[1].window is 16777216; it must be cuts that leave something of each side");
#undef VPLS
    glbk_ism_maps_free(gl, &m);
}

static void a_wrong_near_point_is_named(void **state)
{
    GL_TEST(t, state)
    glbk_context *gl = &t->gl;
    const glbk_result no = GLBK_ERR_INPUT;
    const ism_vpl v = { { 0, 2, 0 }, { 0, -1, 0 }, { 1, 1, 1 }, { 0, -1, 0 }, 1, 0, 0.1f, 0, 0, 0, 0, 0, 0 };
    ism_near_point p[2] = { { { 0, 2, 0 }, 0.1f, { 0, -1, 0 }, 1, { 1, 1, 1 }, 0 },
                            { { 0, 2, 0 }, 0.1f, { 0, -1, 0 }, 1, { 1, 1, 1 }, 0 } };
    const ism_info info = { 0 };
    glbk_ism_maps m = make_maps(t);
    gl_listen(t);
    assert_glbk(t, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
    assert_glbk(t, glbk_ism_near_points_upload(gl, &m, p, 2));
#define NEAR(count) glbk_ism_near_points_upload(gl, &m, p, count)
    SAYS(glbk_ism_near_points_upload(gl, NULL, p, 2), GLBK_ERR_ARGUMENT, "glbk_ism_near_points_upload: maps is NULL");
    SAYS(glbk_ism_near_points_upload(gl, &m, NULL, 2), GLBK_ERR_ARGUMENT,
         "glbk_ism_near_points_upload: points is NULL");
    SAYS(NEAR(5), GLBK_ERR_LIMIT, "glbk_ism_near_points_upload: count is 5; it must be 0..4");
    SAYS_OF(p[1].position[0], NAN, NEAR(2), no,
            "glbk_ism_near_points_upload: points[1].position[0] is not a number; it must be finite");
    SAYS_OF(p[1].normal[1], INFINITY, NEAR(2), no,
            "glbk_ism_near_points_upload: points[1].normal[1] is infinity; it must be finite");
    SAYS_OF(p[1].flux[2], -3, NEAR(2), no, "glbk_ism_near_points_upload: points[1].flux[2] is -3; it must be 0..1e30");
    SAYS_OF(p[1].edge, -1, NEAR(2), no,
            "glbk_ism_near_points_upload: points[1].edge is -1; it must be finite and not negative");
    SAYS_OF(p[1].reach, -1, NEAR(2), no,
            "glbk_ism_near_points_upload: points[1].reach is -1; it must be finite and not negative");
    SAYS_OF(p[1].vpl, 1, NEAR(2), no,
            "glbk_ism_near_points_upload: points[1].vpl is 1; it must be the number of an uploaded VPL");
#undef NEAR
    glbk_ism_maps_free(gl, &m);
}

/* ---- maps and meshes ---- */

static void a_wrong_desc_is_named(void **state)
{
    GL_TEST(t, state)
    glbk_context *gl = &t->gl;
    const glbk_result no = GLBK_ERR_DESC;
    ism_desc d = sizes();
    glbk_ism_maps m;
    gl_listen(t);
#define MAPS glbk_ism_maps_create(gl, &d, &m)
    SAYS(glbk_ism_maps_create(gl, &d, NULL), GLBK_ERR_ARGUMENT, "glbk_ism_maps_create: out is NULL");
    SAYS_OF(d.vpl_count, 16385, MAPS, no, "glbk_ism_maps_create: desc.vpl_count is 16385; it must be 0 or 1..16384");
    SAYS_OF(d.surfel_count, 7, MAPS, no, "glbk_ism_maps_create: desc.surfel_count is 7; it must be 0 or 8..65536");
    SAYS_OF(d.tile_side, 24, MAPS, no,
            "glbk_ism_maps_create: desc.tile_side is 24; it must be 0 or a power of two, 8..256");
    SAYS_OF(d.tile_side, 512, MAPS, no,
            "glbk_ism_maps_create: desc.tile_side is 512; it must be 0 or a power of two, 8..256");
    SAYS_OF(d.projection, ISM_PROJECTION_COUNT, MAPS, no,
            "glbk_ism_maps_create: desc.projection is 5; it must be a value of ism_projection");
    SAYS_OF(d.lazy_frames, 65, MAPS, no, "glbk_ism_maps_create: desc.lazy_frames is 65; it must be 0 or 1..64");
    SAYS_OF(d.splat_scale, 17, MAPS, no, "glbk_ism_maps_create: desc.splat_scale is 17; it must be 0..16");
    SAYS_OF(d.near_point_count, 65, MAPS, no,
            "glbk_ism_maps_create: desc.near_point_count is 65; it must be 64 at most");
    SAYS_OF(d.window_rim, 5, MAPS, no,
            "glbk_ism_maps_create: desc.window_rim is 5; it must be negative, 0 or 2..tile_side / 2");
    gl->max_side = 15;
    SAYS(MAPS, GLBK_ERR_LIMIT, "glbk_ism_maps_create: the atlas's side, of all VPLs' tiles, is 16; it must be 8..15");
#undef MAPS
}

static void a_wrong_mesh_is_named(void **state)
{
    GL_TEST(t, state)
    static const uint16_t short_triangles[6] = { 0, 1, 2, 1, 3, 2 };
    static const uint32_t wrong[6] = { 0, 1, 2, 1, 4, 2 };
    glbk_context *gl = &t->gl;
    const glbk_result no = GLBK_ERR_ARGUMENT;
    ism_mesh mesh = { corners, 4, 0, triangles, 6, NULL, NULL, NULL, NULL, NULL };
    glbk_ism_maps m = make_maps(t);
    gl_listen(t);
#define MESH glbk_ism_mesh_upload(gl, &m, &mesh)
    SAYS(glbk_ism_mesh_move(gl, &m, corners, 0), GLBK_ERR_ORDER,
         "glbk_ism_mesh_move: maps have no mesh: glbk_ism_mesh_upload");
    SAYS(glbk_ism_mesh_upload(gl, NULL, &mesh), no, "glbk_ism_mesh_upload: maps is NULL");
    SAYS_OF(mesh.indices16, short_triangles, MESH, no,
            "glbk_ism_mesh_upload: mesh.indices and mesh.indices16 are both given");
    SAYS_OF(mesh.index_count, 5, MESH, no, "glbk_ism_mesh_upload: mesh.index_count is 5; it must be a multiple of 3");
    SAYS_OF(mesh.indices, NULL, MESH, no, "glbk_ism_mesh_upload: mesh.vertex_count is 4; it must be a multiple of 3");
    SAYS_OF(mesh.positions, NULL, MESH, no, "glbk_ism_mesh_upload: mesh.positions is NULL");
    SAYS_OF(mesh.vertex_stride, 14, MESH, no,
            "glbk_ism_mesh_upload: mesh.vertex_stride is 14; it must be 0 or a multiple of 4, at least 12");
    SAYS_OF(mesh.index_count, 3 * (size_t)0x40000000, MESH, GLBK_ERR_LIMIT,
            "glbk_ism_mesh_upload: mesh.index_count is 3221225472; it must be 2147483647 at most");
    SAYS_OF(mesh.vertex_count, 0x80000000u, MESH, GLBK_ERR_LIMIT,
            "glbk_ism_mesh_upload: mesh.vertex_count is 2147483648; it must be 2147483647 at most");
    SAYS_OF(mesh.indices, wrong, MESH, GLBK_ERR_INPUT,
            "glbk_ism_mesh_upload: mesh: index 1 of triangle 1 is 4, but the mesh has 4 vertices");
#undef MESH
    assert_glbk(t, glbk_ism_mesh_upload(gl, &m, &mesh));
    SAYS(glbk_ism_mesh_move(gl, NULL, corners, 0), no, "glbk_ism_mesh_move: maps is NULL");
    SAYS(glbk_ism_mesh_move(gl, &m, NULL, 0), no, "glbk_ism_mesh_move: positions is NULL");
    SAYS(glbk_ism_mesh_move(gl, &m, corners, 8), no,
         "glbk_ism_mesh_move: stride is 8; it must be 0 or a multiple of 4, at least 12");
    SAYS(glbk_ism_surfels_upload(gl, NULL, 0, surfels, 16), no, "glbk_ism_surfels_upload: maps is NULL");
    SAYS(glbk_ism_surfels_upload(gl, &m, 0, NULL, 16), no, "glbk_ism_surfels_upload: surfels is NULL");
    SAYS(glbk_ism_surfels_upload(gl, &m, 2, surfels, 16), no, "glbk_ism_surfels_upload: phase is 2; it must be 0..1");
    assert_glbk(t, glbk_ism_surfels_upload(gl, &m, 0, surfels, 16));
    SAYS(glbk_ism_draw(gl, &m, 0), GLBK_ERR_ORDER,
         "glbk_ism_draw: the surfels of phase 1 were not given since the mesh has its triangles: "
         "glbk_ism_surfels_upload");
    SAYS(glbk_ism_draw(gl, NULL, 0), no, "glbk_ism_draw: maps is NULL");
    glbk_ism_maps_free(gl, &m);
}

/* ---- pixels ---- */

static void hides(void *user, const float position[3], const float geometric_normal[3], const uint32_t *numbers,
                  size_t count, float *visible)
{
    (void)user;
    (void)position;
    (void)geometric_normal;
    (void)numbers;
    memset(visible, 0, count * sizeof *visible);
}

static void a_wrong_shading_is_named(void **state)
{
    GL_TEST(t, state)
    glbk_context *gl = &t->gl;
    const glbk_result no = GLBK_ERR_DESC;
    const glbk_gbuffer_desc full = { SIDE, SIDE, { 0, 0, 0, 0, NULL, NULL }, NULL };
    const glbk_gbuffer_desc wide = { 2 * SIDE, SIDE, { 0, 0, 0, 0, NULL, NULL }, NULL };
    const glbk_gbuffer_desc high = { SIDE, 2 * SIDE, { 0, 0, 0, 0, NULL, NULL }, NULL };
    const ism_vpl v = { { 0, 2, 0 }, { 0, -1, 0 }, { 1, 1, 1 }, { 0, -1, 0 }, 1, 0, 0.1f, 0, 0, 0, 0, 0, 0 };
    const ism_info info = { 0 };
    glbk_ism_maps m = make_maps(t), none;
    glbk_ism_renderer r, no_r;
    glbk_gbuffer seen, across, up, nothing;
    ism_shading s;
    float rgba[4 * SIDE * SIDE];
    memset(&none, 0, sizeof none);
    memset(&no_r, 0, sizeof no_r);
    memset(&nothing, 0, sizeof nothing);
    memset(&s, 0, sizeof s);
    assert_glbk(t, glbk_ism_renderer_create(gl, &(glbk_ism_renderer_desc){ SIDE, SIDE }, &r));
    assert_glbk(t, glbk_gbuffer_create(gl, &full, &seen));
    assert_glbk(t, glbk_gbuffer_create(gl, &wide, &across));
    assert_glbk(t, glbk_gbuffer_create(gl, &high, &up));
    assert_glbk(t, glbk_ism_vpls_upload(gl, &m, &v, 1, &info));
    gl_listen(t);
#define SHADE glbk_ism_shade(gl, &r, &seen, &m, &s, 0)
    SAYS(SHADE, GLBK_ERR_ORDER, "glbk_ism_shade: maps must be drawn first: glbk_ism_draw");
    assert_glbk(t, glbk_ism_draw(gl, &m, 0));
    SAYS_OF(s.interleave, 3, SHADE, no, "glbk_ism_shade: shading.interleave is 3; it must be 0, 1, 2, 4 or 8");
    SAYS_OF(s.near_mode, ISM_NEAR_COUNT, SHADE, no,
            "glbk_ism_shade: shading.near_mode is 7; it must be a value of ism_near");
    SAYS_OF(s.bias, 1, SHADE, no, "glbk_ism_shade: shading.bias is 1; it must be below 1");
    SAYS_OF(s.clamp, -1, SHADE, no, "glbk_ism_shade: shading.clamp is -1; it must be 0 or above 0");
    SAYS_OF(s.visible_fn, hides, SHADE, no,
            "glbk_ism_shade: shading.visible_fn is not NULL: on GL it is GLSL, glbk_ism_renderer_see");
    SAYS_OF(s.near_visible_fn, hides, SHADE, no,
            "glbk_ism_shade: shading.near_visible_fn is not NULL: on GL it is GLSL, glbk_ism_renderer_see");
    SAYS_OF(s.bias, 1, glbk_ism_bind(gl, &m, &s, NULL), no, "glbk_ism_bind: shading.bias is 1; it must be below 1");
#undef SHADE
    SAYS(glbk_ism_bind(gl, NULL, NULL, NULL), GLBK_ERR_ARGUMENT, "glbk_ism_bind: maps is NULL");
    SAYS(glbk_ism_shade(gl, NULL, &seen, &m, &s, 0), GLBK_ERR_ARGUMENT, "glbk_ism_shade: renderer is NULL");
    SAYS(glbk_ism_shade(gl, &no_r, &seen, &m, &s, 0), GLBK_ERR_ARGUMENT, "glbk_ism_shade: renderer was not created");
    SAYS(glbk_ism_shade(gl, &r, NULL, &m, &s, 0), GLBK_ERR_ARGUMENT, "glbk_ism_shade: gbuffer is NULL");
    SAYS(glbk_ism_shade(gl, &r, &nothing, &m, &s, 0), GLBK_ERR_ARGUMENT, "glbk_ism_shade: gbuffer was not created");
    SAYS(glbk_ism_shade(gl, &r, &seen, &none, &s, 0), GLBK_ERR_ARGUMENT, "glbk_ism_shade: maps were not created");
    SAYS(glbk_ism_shade(gl, &r, &across, &m, &s, 0), GLBK_ERR_MISMATCH,
         "glbk_ism_shade: gbuffer->width is 8; it must be that of the renderer");
    SAYS(glbk_ism_shade(gl, &r, &up, &m, &s, 0), GLBK_ERR_MISMATCH,
         "glbk_ism_shade: gbuffer->height is 8; it must be that of the renderer");
    SAYS(glbk_ism_resolve(gl, &r, &seen, NULL, NULL), GLBK_ERR_ARGUMENT, "glbk_ism_resolve: pass is NULL");
    SAYS(glbk_ism_read(gl, &r, NULL), GLBK_ERR_ARGUMENT, "glbk_ism_read: rgba is NULL");
    SAYS(glbk_ism_read(gl, NULL, rgba), GLBK_ERR_ARGUMENT, "glbk_ism_read: renderer is NULL");
    SAYS(glbk_ism_renderer_create(gl, &(glbk_ism_renderer_desc){ SIDE, SIDE }, NULL), GLBK_ERR_ARGUMENT,
         "glbk_ism_renderer_create: out is NULL");
    SAYS(glbk_ism_renderer_create(gl, NULL, &no_r), GLBK_ERR_ARGUMENT, "glbk_ism_renderer_create: desc is NULL");
    gl->max_side = 8;
    SAYS(glbk_ism_renderer_create(gl, &(glbk_ism_renderer_desc){ 0, SIDE }, &no_r), GLBK_ERR_DESC,
         "glbk_ism_renderer_create: desc.width is 0; it must be 1..8");
    SAYS(glbk_ism_renderer_create(gl, &(glbk_ism_renderer_desc){ SIDE, 9 }, &no_r), GLBK_ERR_LIMIT,
         "glbk_ism_renderer_create: desc.height is 9; it must be 1..8");
    glbk_gbuffer_free(gl, &seen);
    glbk_gbuffer_free(gl, &across);
    glbk_gbuffer_free(gl, &up);
    glbk_ism_renderer_free(gl, &r);
    glbk_ism_maps_free(gl, &m);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(lists_of_another_desc_are_refused),
        gl_unit_test(a_wrong_vpl_is_named),
        gl_unit_test(a_wrong_near_point_is_named),
        gl_unit_test(a_wrong_desc_is_named),
        gl_unit_test(a_wrong_mesh_is_named),
        gl_unit_test(a_wrong_shading_is_named)
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE45 | GL_CORE33);
}
