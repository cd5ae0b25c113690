/* gl_rows_test - rows of docs/conformance.md by the passes of glbk_rsm: those of tests/rsm/rows.h, albedo
   (T33) and the places of texels (T34) of maps that GL drew. Patterns and statistics are rsm.h's alone. */
#define _POSIX_C_SOURCE 200809L
#include "rsm.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend/gl_rsm.h"

#define CONFORM_BACKEND "gl"
#include "conformance.h"
#include "gl_test.h"
#include "util.h"
#include "gl_util.h"

static gl_test *now;                    /* of the test that runs */
static glbk_rsm_renderer seen_by;       /* of its receivers, made when they are first asked for */
static glbk_gbuffer sight;              /* they */

#define ROW_TEST(state) GL_TEST(test_, state) now = test_;
#define ROW_POISSONS 2                  /* slow to build */
#include "rows.h"

static int end_tests(void **state)
{
    gl_test *t = (gl_test *)*state;
    if (t->context) {
        glbk_rsm_renderer_free(&t->gl, &seen_by);
        glbk_gbuffer_free(&t->gl, &sight);
    }
    return gl_teardown(state);
}

/* ---- the rows by GL ---- */

struct lit { glbk_rsm_map map; };

static lit *lit_new(const rsm_light *light, uint32_t size)
{
    lit *l = (lit *)calloc(1, sizeof *l);
    assert_non_null(l);
    assert_glbk(now, glbk_rsm_map_create(&now->gl, light, size, &l->map));
    return l;
}

static void use_renderer(uint32_t width, uint32_t height)
{
    glbk_rsm_renderer_desc d = { 0, 0, 1, 0, 0, { 0, 0, 0, 0, NULL, NULL } };
    if (seen_by.width == width && seen_by.height == height) return;
    glbk_rsm_renderer_free(&now->gl, &seen_by);
    glbk_gbuffer_free(&now->gl, &sight);
    sight = gbuffer_of(now, width, height);
    d.width = width;
    d.height = height;
    assert_glbk(now, glbk_rsm_renderer_create(&now->gl, &d, &seen_by));
}

static lit *draw_lit(const rsm_desc *desc, const rsm_mesh *meshes, size_t count, const glbk_texture *albedo_map)
{
    lit *l = lit_new(&desc->light, desc->side);
    scene s;
    scene_make(now, &s, meshes, count);
    s.albedo_map = albedo_map;
    if (!seen_by.width) use_renderer(8, 8);
    assert_glbk(now, glbk_rsm_map_draw(&now->gl, &seen_by, &l->map, scene_draw, &s));
    scene_free(now, &s);
    return l;
}

static lit *lit_of(const rsm_desc *desc, const rsm_mesh *meshes, size_t count)
{
    return draw_lit(desc, meshes, count, NULL);
}

static lit *lit_list(const rsm_texel *lights, uint32_t side)
{
    rsm_desc d = sun_desc(1, 1, side);
    lit *l = lit_new(&d.light, side);
    assert_glbk(now, glbk_rsm_map_upload(&now->gl, &l->map, lights));
    return l;
}

static void lit_free(lit *l)
{
    glbk_rsm_map_free(&now->gl, &l->map);
    free(l);
}

/* Of one face; free it. */
static rsm_texel *texels_of(lit *l, uint32_t face)
{
    rsm_texel *texels = (rsm_texel *)malloc((size_t)l->map.side * l->map.side * sizeof *texels);
    assert_non_null(texels);
    assert_glbk(now, glbk_rsm_map_read(&now->gl, &l->map, face, texels));
    return texels;
}

static double lit_flux(lit *l)
{
    double sum = 0;
    size_t i;
    uint32_t f;
    for (f = 0; f < l->map.face_count; f++) {
        rsm_texel *texels = texels_of(l, f);
        for (i = 0; i < (size_t)l->map.side * l->map.side; i++) sum += (double)texels[i].flux[0];
        free(texels);
    }
    return sum;
}

/* Receivers into the G-buffer: up to 64 in an 8 x 8 picture, or one of their own size. */
static void look(const rsm_points *points)
{
    const uint32_t width = points->count > 64 ? points->width : 8, side = points->count > 64 ? 0 : 8;
    const uint32_t height = side ? side : (uint32_t)(points->count / width);
    glbk_pixel *pixels = (glbk_pixel *)calloc((size_t)width * height, sizeof *pixels);
    size_t i;
    assert_non_null(pixels);
    for (i = 0; i < points->count; i++) {
        memcpy(pixels[i].position, points->positions + 3 * i, 12);
        memcpy(pixels[i].normal, points->normals + 3 * i, 12);
    }
    use_renderer(width, height);
    assert_glbk(now, glbk_gbuffer_upload(&now->gl, &sight, 0, height, pixels));
    free(pixels);
}

/* Light of the receivers; nothing where none is. marks: as the mask of rsm_interpolation, or NULL. */
static void read_light(const rsm_points *points, int bounced, float *e, uint8_t *marks)
{
    const size_t count = (size_t)seen_by.width * seen_by.height;
    float *rgba = (float *)malloc(4 * count * sizeof *rgba);
    size_t i;
    assert_non_null(rgba);
    assert_glbk(now, glbk_rsm_read(&now->gl, &seen_by, bounced, rgba));
    for (i = 0; i < points->count; i++) {
        memcpy(e + 3 * i, rgba + 4 * i, 12);
        if (marks) marks[i] = rgba[4 * i + 3] > 2.5f ? 2 : rgba[4 * i + 3] > 1.5f ? 1 : 0;
    }
    for (i = 4 * points->count; i < 4 * count; i++) assert_true(!(fabsf(rgba[i]) > 0));
    free(rgba);
}

/* how: interpolated, or NULL. */
static void gather(lit *l, const rsm_gather_desc *d, const rsm_interpolation *how, const rsm_points *points, float *e,
                   uint8_t *marks)
{
    glbk_rsm_map *maps[1];
    maps[0] = &l->map;
    look(points);
    seen_by.lights_per_pass = d->sample_count ? 4096 : 32768;        /* every texel of 512 x 512 */
    upload_tables(now, &seen_by, d);
    if (how) assert_glbk(now, glbk_rsm_interpolate(&now->gl, &seen_by, &sight, maps, 1, d, how));
    else assert_glbk(now, glbk_rsm_gather(&now->gl, &seen_by, &sight, maps, 1, d));
    read_light(points, 1, e, marks);
}

static void lit_gather(lit *l, const rsm_gather_desc *g, const rsm_points *points, float *e)
{
    gather(l, g, NULL, points, e, NULL);
}

static double lit_interpolate(lit *l, const rsm_gather_desc *g, const rsm_interpolation *in,
                              const rsm_points *points, float *e)
{
    rsm_interpolation how = *in;
    size_t i, marked = 0;
    how.mask = NULL;
    gather(l, g, &how, points, e, in->mask);
    for (i = 0; i < points->count; i++) marked += in->mask[i] == 2;
    return (double)marked / (double)points->count;
}

static void lit_direct(lit *l, const rsm_points *points, float *e)
{
    const glbk_rsm_map *maps[1];
    const rsm_direct_desc d = direct_desc();
    maps[0] = &l->map;
    look(points);
    assert_glbk(now, glbk_rsm_direct(&now->gl, &seen_by, &sight, maps, 1, &d));
    read_light(points, 0, e, NULL);
}

/* The list of pixel lights that the last gathering left. */
static const char places_main[] =
    "layout(location = 0) out glbk_color result;\n"
    "void main() { result = glbk_pack(uintBitsToFloat(RSM_LIGHT(uint(gl_FragCoord.x), 0))); }\n";

static void lit_places(lit *l, uint32_t samples, float *p)
{
    const rsm_gather_desc g = gather_desc(RSM_PATTERN_FLUX, samples);
    const float point[3] = { 0, 1, 0 };
    float e[3], *rgba = (float *)malloc(4 * samples * sizeof *rgba);
    const rsm_points points = points_of(point, point, 1, 0);
    gl_canvas canvas = gl_canvas_make(now, GLBK_FORMAT_COLOR, samples, 1, 0);
    glbk_program program;
    glbk_source source;
    glbk_pass pass;
    size_t i;
    assert_non_null(rgba);
    lit_gather(l, &g, &points, e);
    memset(&source, 0, sizeof source);
    memset(&pass, 0, sizeof pass);
    source.fragment = places_main;
    source.parts[0] = glbk_rsm_part();
    source.uses = "rsm_access";
    pass.target = &canvas.target;
    assert_glbk(now, glbk_program_compile(&now->gl, &source, &program));
    assert_glbk(now, glbk_begin(&now->gl, &pass, &program));
    glbk_rsm_bind(&now->gl, &seen_by, &l->map, NULL);
    glbk_draw_screen(&now->gl);
    assert_glbk(now, glbk_target_read(&now->gl, &canvas.target, 0, 0, 0, samples, 1, rgba));
    for (i = 0; i < samples; i++) memcpy(p + 3 * i, rgba + 4 * i, 12);
    glbk_program_free(&now->gl, &program);
    gl_canvas_free(now, &canvas);
    free(rgba);
}

/* ---- maps that GL drew ---- */

static void t33_albedo_is_linear(void **state)
{
    ROW_TEST(state)
    static const float square[] = { -2, 0, -2, 4, 0, 0, 0, 0, 4 };
    static const uint8_t srgb[4] = { 188, 188, 188, 255 };
    model m = model_quads(square, 1);
    rsm_mesh mesh = mesh_of(&m, 0.5);
    rsm_desc d = sun_desc(1, 1, 16);            /* a flux of 4 through the map */
    glbk_texture_desc td;
    glbk_texture map;
    lit *l = lit_of(&d, &mesh, 1);
    CONFORM("T33", "flux of linear albedo 0.5 / flux through the map", 0.5, lit_flux(l) / 4, 1e-6);
    lit_free(l);
    memset(&td, 0, sizeof td);
    td.format = GLBK_FORMAT_SRGB8_A8;
    td.width = td.height = 1;
    td.data = srgb;
    assert_glbk(now, glbk_texture_create(&now->gl, &td, &map));
    mesh = mesh_of(&m, 1);
    l = draw_lit(&d, &mesh, 1, &map);
    /* GL decodes: drivers may keep as little as 8 bits of linear light, and llvmpipe does */
    CONFORM("T33", "the same from 8-bit sRGB 188, decoded by GL's sampler", 0.502886, lit_flux(l) / 4, 0.5 / 255);
    lit_free(l);
    glbk_texture_free(&now->gl, &map);
    model_free(&m);
}

/* Of a plane, by three kinds of light; each position seen by rsm.h in the texel that holds it. */
static void t34_texel_centres_map_back_to_their_texel(void **state)
{
    ROW_TEST(state)
    enum { SIZE = 64 };
    static const rsm_light_kind kinds[] = { RSM_LIGHT_SUN, RSM_LIGHT_SPOT, RSM_LIGHT_POINT };
    static const float plane[] = { -5.084f, -0.112f, 2.48f, 6.4f, -4.8f, 0, 3.84f, 5.12f, -4.8f };
    const double n[3] = { 0.36, 0.48, 0.8 }, offset = 0.1;
    model m = model_quads(plane, 1);
    rsm_mesh mesh = mesh_of(&m, 1);
    double worst = 0;
    uint32_t k, f, i, wrong = 0, seen = 0;
    for (k = 0; k < 3; k++) {
        rsm_desc d = sun_desc(1, 2, SIZE);
        rsm_map *map;
        lit *l;
        d.light.kind = kinds[k];
        set3(d.light.position, 0.3, 3, 0.2);
        set3(d.light.direction, 0, k ? -1 : 1, 0);
        d.light.cone_half_angle = 0.6f;
        d.light.near_depth = k ? 0.5f : -20;
        d.light.far_depth = 20;
        assert_int_equal(rsm_map_create(&d, &map), RSM_OK);
        l = lit_of(&d, &mesh, 1);
        for (f = 0; f < l->map.face_count; f++) {
            rsm_texel *texels = texels_of(l, f);
            for (i = 0; i < SIZE * SIZE; i++) {
                const float *p = texels[i].position;
                float uv[2], z;
                uint32_t face;
                if (!(texels[i].depth < RSM_FAR)) continue;
                worst = fmax(worst, fabs(n[0] * (double)p[0] + n[1] * (double)p[1] + n[2] * (double)p[2] - offset));
                assert_int_equal(rsm_map_project(map, p, &face, uv, &z), RSM_OK);
                wrong += face != f || (uint32_t)(uv[0] * (float)SIZE) != i % SIZE ||
                         (uint32_t)(uv[1] * (float)SIZE) != i / SIZE;
                seen++;
            }
            free(texels);
        }
        lit_free(l);
        rsm_map_free(map);
    }
    assert_true(seen > 2 * SIZE * SIZE);
    /* interpolated by the rasteriser, corners 6 away: 24 bits of those */
    CONFORM_MAX("T34", "largest distance from the plane of positions that GL drew", 1e-5, worst);
    CONFORM_MAX("T34", "texel centres that map back to another texel", 0, wrong);
    model_free(&m);
}

/* One context for all, so that programs are compiled once. */
int main(int count, char **arguments)
{
    struct CMUnitTest tests[] = { RSM_ROWS(cmocka_unit_test), cmocka_unit_test(t33_albedo_is_linear),
                                  cmocka_unit_test(t34_texel_centres_map_back_to_their_texel) };
    int result;
    (void)count;
    if (gl_run_ways(arguments, GL_CORE33 | GL_CORE45, &result)) return result;
    if (gl_this_way()->bit == GL_CORE45) unsetenv("CONFORMANCE");      /* the compute path is held to the same rows */
    gl_name_tests(tests, sizeof tests / sizeof tests[0]);
    return cmocka_run_group_tests(tests, gl_setup, end_tests);
}
