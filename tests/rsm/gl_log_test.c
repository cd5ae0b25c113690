/* gl_log_test - what gl_rsm.h says when a call fails: one line that names the function, the field or element, its value
   and its range. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend/gl_rsm.h"

#include "gl_test.h"
#include "gl_says.h"

enum { SIDE = 4 };

static rsm_light sun(void)
{
    rsm_light l;
    memset(&l, 0, sizeof l);
    l.direction[1] = 1;
    l.value[0] = 1;
    l.radius = 2;
    return l;
}

/* A map, renderers with room for all and for nothing, G-buffers of their size and of two others. */
typedef struct stage {
    glbk_rsm_map      map, no_map;
    glbk_rsm_renderer full, bare, none;
    glbk_gbuffer      seen, wide, high, nothing;
} stage;

static stage s;

static void draw_nothing(void *user, glbk_context *ctx, glbk_rsm_renderer *r)
{
    (void)user;
    (void)ctx;
    (void)r;
}

static void open_stage(gl_test *t)
{
    const rsm_light l = sun();
    const glbk_rsm_renderer_desc full = { SIDE, SIDE, 1, 1, 0, { 0, 0, 0, 0, NULL, NULL } };
    const glbk_rsm_renderer_desc bare = { SIDE, SIDE, 0, 0, 0, { 0, 0, 0, 0, NULL, NULL } };
    glbk_gbuffer_desc d = { SIDE, SIDE, { 0, 0, 0, 0, NULL, NULL }, NULL };
    memset(&s, 0, sizeof s);
    assert_glbk(t, glbk_rsm_map_create(&t->gl, &l, 4, &s.map));
    assert_glbk(t, glbk_rsm_renderer_create(&t->gl, &full, &s.full));
    assert_glbk(t, glbk_rsm_renderer_create(&t->gl, &bare, &s.bare));
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &d, &s.seen));
    d.width = 2 * SIDE;
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &d, &s.wide));
    d.width = SIDE;
    d.height = 2 * SIDE;
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &d, &s.high));
    assert_glbk(t, glbk_rsm_map_draw(&t->gl, &s.full, &s.map, draw_nothing, NULL));
    gl_listen(t);
}

static void close_stage(gl_test *t)
{
    glbk_rsm_map_free(&t->gl, &s.map);
    glbk_rsm_renderer_free(&t->gl, &s.full);
    glbk_rsm_renderer_free(&t->gl, &s.bare);
    glbk_gbuffer_free(&t->gl, &s.seen);
    glbk_gbuffer_free(&t->gl, &s.wide);
    glbk_gbuffer_free(&t->gl, &s.high);
}

/* ---- maps and lights ---- */

static void a_wrong_light_is_named(void **state)
{
    GL_TEST(t, state)
    glbk_context *gl = &t->gl;
    const glbk_result no = GLBK_ERR_DESC;
    rsm_light l = sun(), spot = sun();
    glbk_rsm_map m;
    gl_listen(t);
    spot.kind = RSM_LIGHT_SPOT;
    spot.cone_half_angle = 0.5f;
#define MAP glbk_rsm_map_create(gl, &l, 4, &m)
#define SPOT glbk_rsm_map_create(gl, &spot, 4, &m)
    SAYS(glbk_rsm_map_create(gl, &l, 4, NULL), GLBK_ERR_ARGUMENT, "glbk_rsm_map_create: out is NULL");
    SAYS(glbk_rsm_map_create(gl, NULL, 4, &m), GLBK_ERR_ARGUMENT, "glbk_rsm_map_create: light is NULL");
    SAYS(glbk_rsm_map_create(gl, &l, 3, &m), GLBK_ERR_ARGUMENT,
         "glbk_rsm_map_create: side is 3; it must be 0 or 4..4096");
    SAYS_OF(l.kind, RSM_LIGHT_COUNT, MAP, no,
            "glbk_rsm_map_create: light.kind is 6; it must be one of rsm_light_kind");
    SAYS_OF(l.position[1], 2e9f, MAP, no, "glbk_rsm_map_create: light.position[1] is 2000000000; it must be -1e9..1e9");
    SAYS_OF(l.up[2], NAN, MAP, no, "glbk_rsm_map_create: light.up[2] is not a number; it must be -1e9..1e9");
    SAYS_OF(l.value[2], -1, MAP, no, "glbk_rsm_map_create: light.value[2] is -1; it must be 0..1e12");
    SAYS_OF(l.direction[1], 0, MAP, no,
            "glbk_rsm_map_create: the length of light.direction is 0; it must be 1e-15..1e15");
    SAYS_OF(l.radius, 0, MAP, no, "glbk_rsm_map_create: light.radius is 0; it must be above 0, at most 1e9");
    SAYS_OF(l.near_depth, -2e9f, MAP, no,
            "glbk_rsm_map_create: light.near_depth is -2000000000; it must be -1e9..1e9");
    SAYS_OF(l.near_depth, 1, MAP, no,
            "glbk_rsm_map_create: light.far_depth is 0; it must be above near_depth, at most 1e9");
    SAYS_OF(spot.cone_half_angle, 4, SPOT, no,
            "glbk_rsm_map_create: light.cone_half_angle is 4; it must be above 0.0005, at most 3.14");
    SAYS_OF(spot.far_depth, -1, SPOT, no,
            "glbk_rsm_map_create: light.near_depth is 0; it must be above 0, at most 1e9");
    spot.kind = RSM_LIGHT_SQUARE_SPOT;
    SAYS_OF(spot.cone_half_angle, 2, SPOT, no,
            "glbk_rsm_map_create: light.cone_half_angle is 2; it must be above 0.0005, at most 1");
#undef MAP
#undef SPOT
}

static void a_wrong_map_is_named(void **state)
{
    GL_TEST(t, state)
    static rsm_texel texels[16];
    glbk_context *gl = &t->gl;
    const glbk_result no = GLBK_ERR_ARGUMENT;
    rsm_light l = sun();
    open_stage(t);
    SAYS(glbk_rsm_map_place(gl, NULL, &l), no, "glbk_rsm_map_place: map is NULL");
    SAYS(glbk_rsm_map_place(gl, &s.no_map, &l), no, "glbk_rsm_map_place: map was not created");
    SAYS_OF(l.kind, RSM_LIGHT_POINT, glbk_rsm_map_place(gl, &s.map, &l), GLBK_ERR_MISMATCH,
            "glbk_rsm_map_place: the number of faces that the light needs is 6; it must be that of the map");
    SAYS(glbk_rsm_map_upload(gl, &s.map, NULL), no, "glbk_rsm_map_upload: texels is NULL");
    SAYS(glbk_rsm_map_upload(gl, NULL, texels), no, "glbk_rsm_map_upload: map is NULL");
    SAYS(glbk_rsm_map_read(gl, &s.map, 0, NULL), no, "glbk_rsm_map_read: texels is NULL");
    SAYS(glbk_rsm_map_read(gl, &s.map, 1, texels), no, "glbk_rsm_map_read: face is 1; it must be 0");
    SAYS(glbk_rsm_map_draw(gl, NULL, &s.map, draw_nothing, NULL), no, "glbk_rsm_map_draw: renderer is NULL");
    SAYS(glbk_rsm_map_draw(gl, &s.none, &s.map, draw_nothing, NULL), no,
         "glbk_rsm_map_draw: renderer was not created");
    SAYS(glbk_rsm_map_draw(gl, &s.full, NULL, draw_nothing, NULL), no, "glbk_rsm_map_draw: map is NULL");
    SAYS(glbk_rsm_map_draw(gl, &s.full, &s.map, NULL, NULL), no, "glbk_rsm_map_draw: draw_fn is NULL");
    {
        glbk_surface surface;
        memset(&surface, 0, sizeof surface);
        SAYS(glbk_rsm_object(gl, &s.full, NULL, 0), no, "glbk_rsm_object: surface is NULL");
        SAYS(glbk_rsm_object(gl, NULL, &surface, 0), no, "glbk_rsm_object: renderer is NULL");
        SAYS(glbk_rsm_object(gl, &s.full, &surface, 0), GLBK_ERR_ORDER,
             "glbk_rsm_object: the call comes from no glbk_rsm_draw_fn");
    }
    close_stage(t);
}

static void a_wrong_renderer_desc_is_named(void **state)
{
    GL_TEST(t, state)
    glbk_context *gl = &t->gl;
    glbk_rsm_renderer_desc d = { SIDE, SIDE, 0, 0, 0, { 0, 0, 0, 0, NULL, NULL } };
    glbk_rsm_renderer r;
    gl_listen(t);
    gl->max_side = 8;
#define RENDERER glbk_rsm_renderer_create(gl, &d, &r)
    SAYS(glbk_rsm_renderer_create(gl, &d, NULL), GLBK_ERR_ARGUMENT, "glbk_rsm_renderer_create: out is NULL");
    SAYS(glbk_rsm_renderer_create(gl, NULL, &r), GLBK_ERR_ARGUMENT, "glbk_rsm_renderer_create: desc is NULL");
    SAYS_OF(d.width, 0, RENDERER, GLBK_ERR_DESC, "glbk_rsm_renderer_create: desc.width is 0; it must be 1..8");
    SAYS_OF(d.height, 9, RENDERER, GLBK_ERR_LIMIT, "glbk_rsm_renderer_create: desc.height is 9; it must be 1..8");
    SAYS_OF(d.lights_per_pass, 32769, RENDERER, GLBK_ERR_DESC,
            "glbk_rsm_renderer_create: desc.lights_per_pass is 32769; it must be 0..32768");
#undef RENDERER
}

/* ---- light ---- */

static void a_wrong_desc_of_light_is_named(void **state)
{
    GL_TEST(t, state)
    glbk_context *gl = &t->gl;
    const glbk_result bad = GLBK_ERR_ARGUMENT, no = GLBK_ERR_DESC;
    glbk_rsm_map *maps[2] = { &s.map, NULL }, *unmade[1] = { &s.no_map };
    const glbk_rsm_map *seen[1] = { &s.map };
    static float noise[4] = { 0, 0, 0, 2 };
    rsm_direct_desc d;
    rsm_gather_desc g;
    open_stage(t);
    memset(&d, 0, sizeof d);
    memset(&g, 0, sizeof g);
#define DIRECT glbk_rsm_direct(gl, &s.full, &s.seen, seen, 1, &d)
#define GATHER glbk_rsm_gather(gl, &s.full, &s.seen, maps, 1, &g)
    SAYS_OF(d.tap_side, 16, DIRECT, no, "glbk_rsm_direct: desc.tap_side is 16; it must be 0..15");
    SAYS_OF(d.bias, 2e6f, DIRECT, no, "glbk_rsm_direct: desc.bias is 2000000; it must be -1000000..1000000");
    SAYS_OF(d.slope_bias, NAN, DIRECT, no,
            "glbk_rsm_direct: desc.slope_bias is not a number; it must be -1000000..1000000");
    SAYS_OF(d.add, 1, DIRECT, no, "glbk_rsm_direct: desc.add is 1; it must be 0: give all maps to one call");
    SAYS_OF(d.system.user, &d, DIRECT, no, "glbk_rsm_direct: desc.system is not zero: on GL the context's counts");
    SAYS_OF(g.interleave, 3, GATHER, no, "glbk_rsm_gather: desc.interleave is 3; it must be 0, 1, 2, 4 or 8");
    SAYS_OF(g.near_field, 33, GATHER, no, "glbk_rsm_gather: desc.near_field is 33; it must be 0..32");
    SAYS_OF(g.add, 2, GATHER, no, "glbk_rsm_gather: desc.add is 2; it must be 0: give all maps to one call");
    SAYS_OF(g.material_count, 1, GATHER, no, "glbk_rsm_gather: desc.materials is NULL, and material_count is not 0");
    SAYS_OF(g.noise, noise, GATHER, no, "glbk_rsm_gather: desc.noise_side is 0; it must be 1..1024");
    SAYS(glbk_rsm_gather(gl, &s.full, &s.seen, NULL, 1, &g), bad, "glbk_rsm_gather: maps is NULL");
    SAYS(glbk_rsm_gather(gl, &s.full, &s.seen, maps, 0, &g), bad,
         "glbk_rsm_gather: map_count is 0; it must be 1 at least");
    SAYS(glbk_rsm_gather(gl, &s.full, &s.seen, maps, 2, &g), bad, "glbk_rsm_gather: maps[1] is NULL");
    SAYS(glbk_rsm_gather(gl, &s.full, &s.seen, unmade, 1, &g), bad, "glbk_rsm_gather: maps[0] was not created");
    SAYS(glbk_rsm_gather(gl, &s.none, NULL, maps, 1, &g), bad, "glbk_rsm_gather: renderer was not created");
    SAYS(glbk_rsm_direct(gl, &s.full, NULL, seen, 1, &d), bad, "glbk_rsm_direct: gbuffer is NULL");
    SAYS(glbk_rsm_direct(gl, &s.full, &s.nothing, seen, 1, &d), bad, "glbk_rsm_direct: gbuffer was not created");
    SAYS(glbk_rsm_direct(gl, &s.full, &s.wide, seen, 1, &d), GLBK_ERR_MISMATCH,
         "glbk_rsm_direct: gbuffer->width is 8; it must be that of the renderer");
    SAYS(glbk_rsm_direct(gl, &s.full, &s.high, seen, 1, &d), GLBK_ERR_MISMATCH,
         "glbk_rsm_direct: gbuffer->height is 8; it must be that of the renderer");
#undef DIRECT
#undef GATHER
    close_stage(t);
}

static void nothing_seen(void *user, const float position[3], const float normal[3], const uint32_t *numbers,
                         size_t count, float *visible)
{
    (void)user, (void)position, (void)normal, (void)numbers;
    memset(visible, 0, count * sizeof *visible);
}

static void tables_of_another_desc_are_named(void **state)
{
    GL_TEST(t, state)
    static float points[3 * 256], noise[4] = { 0, 0, 0, 2 };
    glbk_context *gl = &t->gl;
    const glbk_result input = GLBK_ERR_INPUT, other = GLBK_ERR_MISMATCH;
    glbk_rsm_map *maps[1] = { &s.map };
    rsm_material lobes[2] = { { { 0.5f, 0.5f, 0.5f }, 10 }, { { 0.5f, 0.5f, 0.5f }, 10 } };
    rsm_gather_desc g;
    open_stage(t);
    memset(&g, 0, sizeof g);
    g.pattern = RSM_PATTERN_LOG_RADIAL;
    g.sample_count = 8;
#define TABLES glbk_rsm_tables_upload(gl, &s.full, &g, points)
#define GATHER glbk_rsm_gather(gl, &s.full, &s.seen, maps, 1, &g)
    SAYS(glbk_rsm_tables_upload(gl, &s.full, &g, NULL), GLBK_ERR_ARGUMENT,
         "glbk_rsm_tables_upload: points is NULL, and the pattern needs some");
    SAYS_OF(g.sample_count, 0, TABLES, GLBK_ERR_ARGUMENT,
            "glbk_rsm_tables_upload: points is not NULL, and the pattern needs none");
    SAYS_OF(g.visible_fn, nothing_seen, GATHER, GLBK_ERR_DESC,
            "glbk_rsm_gather: desc.visible_fn is not NULL: a GPU cannot call it; gl_ism.h has shadows of bounced light");
    g.noise = noise;
    SAYS_OF(g.noise_side, 1025, TABLES, GLBK_ERR_LIMIT,
            "glbk_rsm_tables_upload: desc.noise_side is 1025; it must be 1..1024");
    SAYS_OF(g.noise_side, 2, TABLES, input,
            "glbk_rsm_tables_upload: desc.noise[3] is 2; it must be 0..1");
    g.noise = NULL;
    g.materials = lobes;
    SAYS_OF(g.material_count, 1025, TABLES, GLBK_ERR_LIMIT,
            "glbk_rsm_tables_upload: desc.material_count is 1025; it must be 0..1024");
    g.material_count = 2;
    SAYS_OF(lobes[1].exponent, -1, TABLES, input,
            "glbk_rsm_tables_upload: desc.materials[1].exponent is -1; it must be 0..1e4");
    SAYS_OF(lobes[1].specular[2], 1.5f, TABLES, input,
            "glbk_rsm_tables_upload: desc.materials[1].specular is 1.5; it must be 0..1");
    assert_glbk(t, TABLES);
    SAYS_OF(g.pattern, RSM_PATTERN_EQUATION3, GATHER, other,
            "glbk_rsm_gather: desc.pattern is 2; it must be 3, which glbk_rsm_tables_upload was given last");
    SAYS_OF(g.sample_count, 12, GATHER, other,
            "glbk_rsm_gather: desc.sample_count is 12; it must be 8, which glbk_rsm_tables_upload was given last");
    SAYS_OF(g.interleave, 2, GATHER, other,
            "glbk_rsm_gather: desc.interleave is 2; it must be 1, which glbk_rsm_tables_upload was given last");
    SAYS_OF(g.seed, 3, GATHER, other,
            "glbk_rsm_gather: desc.seed is 3; it must be 0, which glbk_rsm_tables_upload was given last");
    SAYS_OF(g.r_min, 0.5f, GATHER, other,
            "glbk_rsm_gather: desc.r_min is 0.5; it must be 0.03125, which glbk_rsm_tables_upload was given last");
    SAYS_OF(g.material_count, 1, GATHER, other,
            "glbk_rsm_gather: desc.material_count is 1; it must be 2, which glbk_rsm_tables_upload was given last");
    g.noise = noise;
    SAYS_OF(g.noise_side, 1, GATHER, other,
            "glbk_rsm_gather: desc.noise_side is 1; it must be 0, which glbk_rsm_tables_upload was given last");
    g.noise = NULL;
    g.pattern = RSM_PATTERN_EQUATION3;
    assert_glbk(t, TABLES);
    SAYS_OF(g.paper_weights, 1, GATHER, other,
            "glbk_rsm_gather: desc.paper_weights is 1; it must be 0, which glbk_rsm_tables_upload was given last");
#undef TABLES
#undef GATHER
    close_stage(t);
}

/* ---- interpolation, filter, picture ---- */

static void a_wrong_filter_is_named(void **state)
{
    GL_TEST(t, state)
    static const float noise[1] = { 0 };
    static float matrix[16], rgba[4 * SIDE * SIDE];
    glbk_context *gl = &t->gl;
    const glbk_result no = GLBK_ERR_DESC;
    glbk_rsm_map *maps[1] = { &s.map };
    const glbk_texture unmade = { 0 };
    rsm_gather_desc g;
    rsm_interpolation i;
    gifilt_frame f;
    uint8_t mask = 0;
    open_stage(t);
    memset(&g, 0, sizeof g);
    memset(&i, 0, sizeof i);
    memset(&f, 0, sizeof f);
#define GRID glbk_rsm_interpolate(gl, &s.full, &s.seen, maps, 1, &g, &i)
#define FILTER glbk_rsm_denoise(gl, &s.full, &s.seen, &f, NULL)
    SAYS_OF(i.step, 12, GRID, no,
            "glbk_rsm_interpolate: interpolation.step is 12; it must be 0 or a power of two, 2..64");
    SAYS_OF(i.level_count, 7, GRID, no, "glbk_rsm_interpolate: interpolation.level_count is 7; it must be 0..6");
    SAYS_OF(i.mask, &mask, GRID, no,
            "glbk_rsm_interpolate: interpolation.mask is not NULL: alpha of glbk_rsm_read says what each pixel is");
    g.noise = noise;
    g.noise_side = 1;
    SAYS(GRID, no, "glbk_rsm_interpolate: desc.noise is not NULL: interpolated light has no noise");
    g.noise = NULL;
    SAYS_OF(g.interleave, 2, GRID, no, "glbk_rsm_interpolate: desc.interleave is 2; it must be 0 or 1");
    SAYS(glbk_rsm_interpolate(gl, &s.bare, &s.seen, maps, 1, NULL, NULL), GLBK_ERR_MISMATCH,
         "glbk_rsm_interpolate: renderer was made without desc.interpolate");
    SAYS(FILTER, GLBK_ERR_ORDER, "glbk_rsm_denoise: bounced light was not gathered");
    SAYS(glbk_rsm_read(gl, &s.full, 1, rgba), GLBK_ERR_ORDER, "glbk_rsm_read: bounced light is not there yet");
    SAYS(glbk_rsm_read(gl, &s.full, 0, rgba), GLBK_ERR_ORDER, "glbk_rsm_read: direct light is not there yet");
    assert_glbk(t, glbk_rsm_gather(gl, &s.full, &s.seen, maps, 1, NULL));
    SAYS(glbk_rsm_denoise(gl, &s.bare, &s.seen, &f, NULL), GLBK_ERR_MISMATCH,
         "glbk_rsm_denoise: renderer was made without desc.denoise");
    SAYS(glbk_rsm_denoise(gl, &s.full, &s.seen, &f, &unmade), GLBK_ERR_ARGUMENT,
         "glbk_rsm_denoise: motion was not created");
    SAYS_OF(f.passes, 7, FILTER, no, "glbk_rsm_denoise: frame.passes is 7; it must be -1000000000..6");
    SAYS_OF(f.motion, matrix, FILTER, no, "glbk_rsm_denoise: frame.motion is not NULL: on GL motion is a texture");
    f.world_to_clip = matrix;
    SAYS_OF(matrix[15], INFINITY, FILTER, no,
            "glbk_rsm_denoise: frame.world_to_clip[15] is infinity; it must be finite");
    assert_glbk(t, FILTER);
    SAYS(FILTER, GLBK_ERR_ORDER, "glbk_rsm_denoise: bounced light was filtered already");
#undef GRID
#undef FILTER
    SAYS(glbk_rsm_resolve(gl, &s.full, &s.seen, NULL, NULL, 1, 1), GLBK_ERR_ARGUMENT, "glbk_rsm_resolve: pass is NULL");
    SAYS(glbk_rsm_read(gl, &s.full, 1, NULL), GLBK_ERR_ARGUMENT, "glbk_rsm_read: rgba is NULL");
    SAYS(glbk_rsm_read(gl, NULL, 1, rgba), GLBK_ERR_ARGUMENT, "glbk_rsm_read: renderer is NULL");
    close_stage(t);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(a_wrong_light_is_named),
        gl_unit_test(a_wrong_map_is_named),
        gl_unit_test(a_wrong_renderer_desc_is_named),
        gl_unit_test(a_wrong_desc_of_light_is_named),
        gl_unit_test(tables_of_another_desc_are_named),
        gl_unit_test(a_wrong_filter_is_named)
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE45 | GL_CORE33);
}
