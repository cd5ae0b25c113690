/* attributes_test - all calls that draw the user's meshes take a glbk_attributes: what is drawn from attributes that
   lie elsewhere is what the usual locations give, to the last bit, and locations that cannot be are refused by name.
   gbuffer_test has the same of the G-buffer itself. Functions of the user's that bend vertices, colour pixels and leave
   some out do the same in every pass. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend/gl_csm.h"
#include "gl_backend/gl_envshadow.h"
#include "gl_backend/gl_rsm.h"
#include "gl_backend/gl_shadowfield.h"

#include "gl_test.h"

/* ---- two triangles that lean: the normals are not theirs, and the colours differ ---- */

typedef struct vertex { float position[3], normal[3], uv[2], radiance[3]; } vertex;

static const vertex corners[6] = {
    { { -0.6f, -0.5f, 0.1f }, { 0, 0.6f, 0.8f }, { 0.1f, 0.2f }, { 1, 2, 3 } },
    { { 0.7f, -0.4f, -0.2f }, { 0, 0.6f, 0.8f }, { 0.9f, 0.1f }, { 1, 2, 3 } },
    { { 0.1f, 0.6f, 0.3f }, { 0, 0.6f, 0.8f }, { 0.5f, 0.8f }, { 1, 2, 3 } },
    { { -0.5f, 0.4f, 0.5f }, { 0.6f, 0, 0.8f }, { 0.2f, 0.9f }, { 5, 4, 0.5f } },
    { { 0.2f, -0.3f, 0.4f }, { 0.6f, 0, 0.8f }, { 0.6f, 0.3f }, { 5, 4, 0.5f } },
    { { 0.5f, 0.5f, 0.6f }, { 0.6f, 0, 0.8f }, { 0.8f, 0.7f }, { 5, 4, 0.5f } }
};

/* Where position, normal, texture coordinates and radiance of a shape are; below 0: the array lacks it. */
typedef struct places { int32_t at[4]; } places;

static const places usual = { { 0, 1, 2, -1 } }, moved = { { 12, 0, 5, -1 } }, bare = { { 3, -1, -1, -1 } };

typedef struct shape { uint32_t array, buffer; const glbk_texture *color; glbk_result drawn; } shape;

static shape make_shape_of(gl_test *t, const places *where, const vertex *six)
{
    static const int32_t sizes[4] = { 3, 3, 2, 3 };
    const glbk_functions *gl = &t->gl.gl;
    size_t offset = 0;
    shape s;
    int i;
    memset(&s, 0, sizeof s);
    gl->GenVertexArrays(1, &s.array);
    gl->GenBuffers(1, &s.buffer);
    gl->BindVertexArray(s.array);
    gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, s.buffer);
    gl->BufferData(GLBK_GL_ARRAY_BUFFER, 6 * sizeof *six, six, GLBK_GL_STATIC_DRAW);
    for (i = 0; i < 4; i++) {
        const int32_t at = where->at[i];
        if (at >= 0) gl->EnableVertexAttribArray((uint32_t)at);
        if (at >= 0)
            gl->VertexAttribPointer((uint32_t)at, sizes[i], GLBK_GL_FLOAT, 0, sizeof *corners, (const void *)offset);
        offset += 4 * (size_t)sizes[i];
    }
    gl->BindVertexArray(0);
    gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, 0);
    return s;
}

static shape make_shape(gl_test *t, const places *where) { return make_shape_of(t, where, corners); }

static void free_shape(gl_test *t, shape *s)
{
    t->gl.gl.DeleteVertexArrays(1, &s->array);
    t->gl.gl.DeleteBuffers(1, &s->buffer);
}

static void draw_instances(glbk_context *gl, const shape *s, uint32_t instances)
{
    const int32_t lift = gl->gl.GetUniformLocation(gl->program, "lift");     /* of bend, below; -1 in other programs */
    gl->gl.Uniform1f(lift, 0.125f);
    gl->gl.BindVertexArray(s->array);
    gl->gl.DrawArraysInstanced(GLBK_GL_TRIANGLES, 0, 6, (int32_t)instances);
}

/* ---- rsm: position, normal and texture coordinates ---- */

enum { RSM_SIDE = 16, RSM_TEXELS = RSM_SIDE * RSM_SIDE };

static void draw_lit(void *user, glbk_context *gl, glbk_rsm_renderer *r)
{
    shape *s = (shape *)user;
    glbk_surface surface;
    memset(&surface, 0, sizeof surface);
    surface.material.diffuse[0] = surface.material.diffuse[1] = surface.material.diffuse[2] = 1;
    surface.color_map = s->color;
    s->drawn = glbk_rsm_object(gl, r, &surface, 0);
    draw_instances(gl, s, 1);
}

static void draw_map(gl_test *t, const glbk_attributes *attributes, shape *s, rsm_texel *texels)
{
    glbk_rsm_renderer_desc d;
    glbk_rsm_renderer r;
    glbk_rsm_map map;
    rsm_light sun;
    memset(&d, 0, sizeof d);
    memset(&sun, 0, sizeof sun);
    d.width = d.height = 4;
    d.attributes = *attributes;
    sun.kind = RSM_LIGHT_SUN;
    sun.direction[2] = 1;
    sun.value[0] = sun.value[1] = sun.value[2] = 1;
    sun.radius = 1.25f;
    assert_glbk(t, glbk_rsm_renderer_create(&t->gl, &d, &r));
    assert_glbk(t, glbk_rsm_map_create(&t->gl, &sun, RSM_SIDE, &map));
    assert_glbk(t, glbk_rsm_map_draw(&t->gl, &r, &map, draw_lit, s));
    assert_glbk(t, s->drawn);
    assert_glbk(t, glbk_rsm_map_read(&t->gl, &map, 0, texels));
    glbk_rsm_map_free(&t->gl, &map);
    glbk_rsm_renderer_free(&t->gl, &r);
}

static void maps_of_lights_have_normals_and_colours_from_elsewhere(void **state)
{
    GL_TEST(t, state)
    static rsm_texel first[RSM_TEXELS], second[RSM_TEXELS], plain[RSM_TEXELS];
    static const uint8_t colors[16] = { 255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 9, 99, 9, 255 };
    const glbk_attributes none = { 0, 0, 0, 0, NULL, NULL }, at_moved = { 12, 0, 5, 7, NULL, NULL };
    const glbk_attributes at_bare = { 3, -1, -1, -1, NULL, NULL };
    shape s = make_shape(t, &usual), m = make_shape(t, &moved), b = make_shape(t, &bare);
    const glbk_texture_desc d = { GLBK_FORMAT_RGBA8, 2, 2, 0, 0, GLBK_SAMPLING_DEFAULT, 0, colors };
    glbk_texture color;
    int i, hit = 0;
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &color));
    s.color = m.color = b.color = &color;
    draw_map(t, &none, &s, first);
    draw_map(t, &at_moved, &m, second);
    draw_map(t, &at_bare, &b, plain);           /* normals of the triangles, and the colour at 0, 0 */
    assert_memory_equal(first, second, sizeof first);
    for (i = 0; i < RSM_TEXELS; i++) hit += memcmp(&first[i], &plain[i], sizeof *first) != 0;
    assert_true(hit > RSM_TEXELS / 10);         /* where the shape is */
    glbk_texture_free(&t->gl, &color);
    free_shape(t, &s);
    free_shape(t, &m);
    free_shape(t, &b);
}

/* ---- csm: the position ---- */

typedef struct built { shape *s; cohsm_builder *views; } built;

static void view_of(void *user, uint32_t index, cohsm_view *out)
{
    assert_int_equal(cohsm_builder_view(((built *)user)->views, index, out), COHSM_OK);
}

static void draw_layer(void *user, glbk_context *gl) { draw_instances(gl, ((built *)user)->s, 1); }

static cohsm_maps *build(gl_test *t, const glbk_attributes *attributes, shape *s)
{
    cohsm_desc d;
    glbk_csm_builder_desc gpu_desc;
    glbk_csm_builder gpu;
    cohsm_maps *maps;
    built b;
    uint32_t count;
    memset(&d, 0, sizeof d);
    memset(&gpu_desc, 0, sizeof gpu_desc);
    d.domain.side[0] = d.domain.side[1] = 4;
    d.map_side = 16;
    d.radius = 1.2f;
    b.s = s;
    assert_int_equal(cohsm_builder_create(&d, &b.views), COHSM_OK);
    gpu_desc.maps = &d;
    gpu_desc.view_fn = view_of;
    gpu_desc.draw_fn = draw_layer;
    gpu_desc.user = &b;
    gpu_desc.attributes = *attributes;
    assert_glbk(t, glbk_csm_builder_create(&t->gl, &gpu_desc, &gpu));
    count = cohsm_builder_view_count(b.views);
    assert_true(count <= gpu.batch);
    assert_glbk(t, glbk_csm_builder_draw(&t->gl, &gpu, 0, count));
    assert_glbk(t, glbk_csm_builder_compress(&t->gl, &gpu));
    assert_glbk(t, glbk_csm_builder_end(&t->gl, &gpu));
    assert_int_equal(cohsm_builder_import(b.views, gpu.segments, gpu.segment_count), COHSM_OK);
    assert_int_equal(cohsm_builder_finish(b.views, &maps, NULL), COHSM_OK);
    glbk_csm_builder_free(&t->gl, &gpu);
    cohsm_builder_free(b.views);
    return maps;
}

static void builders_of_maps_find_positions_elsewhere(void **state)
{
    GL_TEST(t, state)
    const glbk_attributes none = { 0, 0, 0, 0, NULL, NULL }, at_moved = { 12, 0, 5, 7, NULL, NULL };
    const glbk_attributes wrong = { 0, 12, 5, 7, NULL, NULL };
    shape s = make_shape(t, &usual), m = make_shape(t, &moved);
    cohsm_maps *first = build(t, &none, &s), *second = build(t, &at_moved, &m), *third = build(t, &wrong, &m);
    size_t bytes, other, off;
    const void *data = cohsm_data(first, &bytes), *found = cohsm_data(second, &other);
    const void *normals = cohsm_data(third, &off);
    assert_int_equal(bytes, other);
    assert_memory_equal(data, found, bytes);
    assert_true(bytes != off || memcmp(data, normals, bytes) != 0);     /* normals taken for positions are seen */
    cohsm_free(first);
    cohsm_free(second);
    cohsm_free(third);
    free_shape(t, &s);
    free_shape(t, &m);
}

/* ---- envshadow: the position ---- */

enum { ENVSH_SIDE = 64, ENVSH_TEXELS = ENVSH_SIDE * ENVSH_SIDE };

static glbk_result cast(void *user, glbk_context *gl, glbk_envsh_maps *maps, uint32_t instances)
{
    const glbk_result result = glbk_envsh_cast(gl, maps, NULL);
    draw_instances(gl, (const shape *)user, instances);
    return result;
}

/* Depths of the one tile, by four channels, since depth textures cannot be read in ES. */
static void draw_tile(gl_test *t, const glbk_attributes *attributes, shape *s, uint32_t *words)
{
    static const float direction[3] = { 0.48f, 0.6f, 0.64f }, irradiance[3] = { 1, 1, 1 };
    const envsh_bounds bounds = { { -1, -1, -1 }, { 1, 1, 1 } };
    envsh_maps_desc layout;
    glbk_envsh_maps_desc d;
    glbk_envsh_maps maps;
    envsh_maps *views;
    envsh_lights lights;
    const envsh_view *list;
    uint32_t count;
    memset(&layout, 0, sizeof layout);
    memset(&d, 0, sizeof d);
    memset(&lights, 0, sizeof lights);
    lights.count = 1;
    lights.directions = direction;
    lights.irradiances = irradiance;
    layout.map_side = ENVSH_SIDE;
    layout.rgba = layout.no_depth = 1;
    d.capacity = 1;
    d.maps = &layout;
    d.attributes = *attributes;
    assert_int_equal(envsh_maps_create(&layout, 1, &views), ENVSH_OK);
    assert_int_equal(envsh_maps_begin(views, &lights, bounds), ENVSH_OK);
    list = envsh_views(views, &count);
    assert_glbk(t, glbk_envsh_maps_create(&t->gl, &d, &maps));
    assert_glbk(t, glbk_envsh_maps_render(&t->gl, &maps, list, count, cast, s));
    assert_glbk(t, glbk_target_read(&t->gl, &maps.atlas_target, 0, 0, 0, ENVSH_SIDE, ENVSH_SIDE, words));
    glbk_envsh_maps_free(&t->gl, &maps);
    envsh_maps_free(views);
}

static void casters_have_positions_elsewhere(void **state)
{
    GL_TEST(t, state)
    static uint32_t first[4 * ENVSH_TEXELS], second[4 * ENVSH_TEXELS];
    const glbk_attributes none = { 0, 0, 0, 0, NULL, NULL }, at_moved = { 12, 0, 5, 7, NULL, NULL };
    shape s = make_shape(t, &usual), m = make_shape(t, &moved);
    int i, cast_on = 0;
    draw_tile(t, &none, &s, first);
    draw_tile(t, &at_moved, &m, second);
    assert_memory_equal(first, second, sizeof first);
    for (i = 0; i < ENVSH_TEXELS; i++) cast_on += first[4 * i] != first[0];     /* the first one is in the guard */
    assert_true(cast_on > 100);
    free_shape(t, &s);
    free_shape(t, &m);
}

/* ---- shadowfield: the position and the radiance ---- */

enum { FIELD_SIDE = 8, FIELD_TEXELS = 6 * FIELD_SIDE * FIELD_SIDE };

static void draw_emitter(void *user, glbk_context *gl, int32_t instances)
{
    draw_instances(gl, (const shape *)user, (uint32_t)instances);
}

static void see(gl_test *t, const glbk_attributes *attributes, uint32_t radiance, shape *s, float *values)
{
    static const float eye_at[3] = { 0.3f, 0.2f, 2.5f };
    sfield_desc field;
    sfield_views views;
    glbk_sfield_builder_desc d;
    glbk_sfield_builder b;
    memset(&field, 0, sizeof field);
    memset(&views, 0, sizeof views);
    memset(&d, 0, sizeof d);
    field.basis = SFIELD_BASIS_HAAR;
    field.cube_side = FIELD_SIDE;
    d.field = &field;
    d.source = 1;
    d.draw_fn = draw_emitter;
    d.user = s;
    d.attributes = *attributes;
    d.radiance_attribute = radiance;
    views.radius = 1;
    views.count = 1;
    views.eyes = eye_at;
    views.values = values;
    assert_glbk(t, glbk_sfield_builder_create(&t->gl, &d, &b));
    assert_glbk(t, glbk_sfield_builder_see(&t->gl, &b, &views));
    glbk_sfield_builder_free(&t->gl, &b);
}

static void sources_have_radiance_elsewhere(void **state)
{
    GL_TEST(t, state)
    static float first[3 * FIELD_TEXELS], second[3 * FIELD_TEXELS];
    const places plain = { { 0, -1, -1, 1 } }, other = { { 1, -1, -1, 15 } };
    const glbk_attributes none = { 0, 0, 0, 0, NULL, NULL }, at_other = { 1, -1, -1, -1, NULL, NULL };
    shape s = make_shape(t, &plain), m = make_shape(t, &other);
    float sum = 0;
    int i;
    see(t, &none, 0, &s, first);
    see(t, &at_other, 15, &m, second);
    assert_memory_equal(first, second, sizeof first);
    for (i = 0; i < 3 * FIELD_TEXELS; i++) sum += first[i];
    assert_true(sum > 10);                      /* some texels see it */
    free_shape(t, &s);
    free_shape(t, &m);
}

/* ---- functions of the user's ---- */

/* Takes the attributes of `moved` and bends them by swaps, halves and one sum, so that C finds the same bits. */
static const char bend[] =
    "layout(location = 12) in vec3 at;\n"
    "layout(location = 0) in vec3 facing;\n"
    "layout(location = 5) in vec2 place;\n"
    "uniform float lift;\n"
    "void glbk_vertex(out vec3 position, out vec3 normal, out vec2 uv, out vec4 tangent)\n"
    "{\n"
    "    position = 0.5 * at.yxz;\n"
    "    position.z += lift;\n"
    "    normal = facing.yxz;\n"
    "    uv = place.yx;\n"
    "    tangent = vec4(0.0);\n"
    "}\n";
static const places bent_places = { { 12, 0, 5, 1 } };

static void bend_corners(vertex *out)
{
    size_t i;
    for (i = 0; i < 6; i++) {
        const vertex *v = &corners[i];
        out[i] = *v;
        out[i].position[0] = 0.5f * v->position[1];
        out[i].position[1] = 0.5f * v->position[0];
        out[i].position[2] = 0.5f * v->position[2] + 0.125f;
        out[i].normal[0] = v->normal[1];
        out[i].normal[1] = v->normal[0];
        out[i].uv[0] = v->uv[1];
        out[i].uv[1] = v->uv[0];
    }
}

static const char all_there[] = "bool glbk_fragment(vec2 uv, inout vec4 color) { return uv.x < 9.0; }\n";
static const char half_there[] = "bool glbk_fragment(vec2 uv, inout vec4 color) { return uv.x < 0.5; }\n";
static const char none_there[] = "bool glbk_fragment(vec2 uv, inout vec4 color) { return uv.x > 9.0; }\n";
static const char half_bright[] =
    "bool glbk_fragment(vec2 uv, inout vec4 color) { color.rgb *= 0.5; return true; }\n";

enum { MOST_BYTES = 1 << 16, SEEN_SIDE = 32, PASSES = 5 };

/* Draws a shape in one of the passes. Returns how many bytes of what came out are kept. */
static size_t draw_by(gl_test *t, int pass, const glbk_attributes *attributes, shape *s, uint32_t radiance, void *out)
{
    static const float clip[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0.5f, 0, 0, 0, 0, 1 }, eye[3] = { 0, 0, 5 };
    cohsm_maps *maps;
    glbk_gbuffer_desc d;
    glbk_surface surface;
    glbk_gbuffer g;
    size_t bytes = 0;
    memset(out, 0, MOST_BYTES);
    if (pass == 0) draw_map(t, attributes, s, (rsm_texel *)out);
    if (pass == 0) return RSM_TEXELS * sizeof(rsm_texel);
    if (pass == 1) draw_tile(t, attributes, s, (uint32_t *)out);
    if (pass == 1) return 16 * ENVSH_TEXELS;
    if (pass == 2) see(t, attributes, radiance, s, (float *)out);
    if (pass == 2) return 12 * FIELD_TEXELS;
    if (pass == 3) {
        const void *data;
        maps = build(t, attributes, s);
        data = cohsm_data(maps, &bytes);
        assert_true(bytes <= MOST_BYTES);
        memcpy(out, data, bytes);
        cohsm_free(maps);
        return bytes;
    }
    memset(&d, 0, sizeof d);
    memset(&surface, 0, sizeof surface);
    d.width = d.height = SEEN_SIDE;
    d.attributes = *attributes;
    surface.material.diffuse[0] = surface.material.diffuse[1] = surface.material.diffuse[2] = 1;
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &d, &g));
    assert_glbk(t, glbk_gbuffer_begin(&t->gl, &g, clip, eye));
    assert_glbk(t, glbk_gbuffer_object(&t->gl, &g, &surface));
    draw_instances(&t->gl, s, 1);
    assert_true(sizeof(glbk_pixel) * 256 <= MOST_BYTES);
    assert_glbk(t, glbk_gbuffer_read(&t->gl, &g, SEEN_SIDE / 2, 8, (glbk_pixel *)out));
    glbk_gbuffer_free(&t->gl, &g);
    return 8 * SEEN_SIDE * sizeof(glbk_pixel);
}

/* What is bent by GLSL is what is drawn when C has bent it, to the last bit, in every pass. */
static void vertices_are_found_by_functions_of_the_users(void **state)
{
    GL_TEST(t, state)
    static unsigned char is[MOST_BYTES], wanted[MOST_BYTES], straight[MOST_BYTES];
    static const places plain_places = { { 0, 1, 2, 15 } };
    static const uint8_t colors[16] = { 255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 9, 99, 9, 255 };
    const glbk_texture_desc d = { GLBK_FORMAT_RGBA8, 2, 2, 0, 0, GLBK_SAMPLING_DEFAULT, 0, colors };
    const glbk_attributes none = { 0, 0, 0, 0, NULL, NULL }, own = { 0, 0, 0, 0, bend, NULL };
    vertex bent[6];
    shape s, c, p;
    glbk_texture color;
    int pass;
    bend_corners(bent);
    s = make_shape(t, &bent_places);
    c = make_shape_of(t, &plain_places, bent);
    p = make_shape(t, &plain_places);
    assert_glbk(t, glbk_texture_create(&t->gl, &d, &color));
    s.color = c.color = p.color = &color;
    for (pass = 0; pass < PASSES; pass++) {
        const size_t bytes = draw_by(t, pass, &own, &s, 1, is);
        assert_int_equal(bytes, draw_by(t, pass, &none, &c, 15, wanted));
        assert_memory_equal(is, wanted, bytes);
        draw_by(t, pass, &none, &p, 15, straight);
        assert_true(memcmp(is, straight, bytes) != 0);
    }
    glbk_texture_free(&t->gl, &color);
    free_shape(t, &s);
    free_shape(t, &c);
    free_shape(t, &p);
}

/* Where all pixels are there the pass is as without a function, where none is, as without a draw; with half of them it
   is neither. */
static void pixels_are_left_out_by_functions_of_the_users(void **state)
{
    GL_TEST(t, state)
    static unsigned char with[4][MOST_BYTES];
    static const places plain_places = { { 0, 1, 2, 15 } };
    static const char *const texts[4] = { NULL, all_there, half_there, none_there };
    static vertex nothing[6];
    shape s = make_shape(t, &plain_places), no = make_shape_of(t, &plain_places, nothing);
    int pass, i;
    for (pass = 0; pass < PASSES; pass++) {
        static unsigned char empty[MOST_BYTES];
        size_t bytes[4], without;
        for (i = 0; i < 4; i++) {
            const glbk_attributes own = { 0, 1, 2, 3, NULL, texts[i] };
            bytes[i] = draw_by(t, pass, &own, &s, 15, with[i]);
        }
        {
            const glbk_attributes plain = { 0, 1, 2, 3, NULL, NULL };
            without = draw_by(t, pass, &plain, &no, 15, empty);
        }
        assert_int_equal(bytes[0], bytes[1]);
        assert_memory_equal(with[0], with[1], bytes[0]);
        assert_int_equal(bytes[3], without);
        assert_memory_equal(with[3], empty, without);
        assert_true(bytes[2] != bytes[0] || memcmp(with[2], with[0], bytes[0]) != 0);
        assert_true(bytes[2] != bytes[3] || memcmp(with[2], with[3], bytes[3]) != 0);
    }
    free_shape(t, &s);
    free_shape(t, &no);
}

/* In a map of a light each texel that is left has texture coordinates of which the function holds, and half the flux if
   it halves the colour. */
static void texels_are_left_and_coloured_as_the_function_says(void **state)
{
    GL_TEST(t, state)
    static rsm_texel all[RSM_TEXELS], half[RSM_TEXELS], dim[RSM_TEXELS];
    glbk_attributes own = { 0, 1, 2, 3, NULL, NULL };
    shape s = make_shape(t, &usual);
    int i, k, kept = 0, left = 0;
    draw_map(t, &own, &s, all);
    own.fragment = half_there;
    draw_map(t, &own, &s, half);
    own.fragment = half_bright;
    draw_map(t, &own, &s, dim);
    for (i = 0; i < RSM_TEXELS; i++) {
        const float *p = all[i].position;
        const vertex *v = all[i].normal[1] > 0.5f ? corners : corners + 3;
        /* of the triangle that is nearest to the light, whose normals tell which it is */
        const float ax = v[1].position[0] - v[0].position[0], ay = v[1].position[1] - v[0].position[1];
        const float bx = v[2].position[0] - v[0].position[0], by = v[2].position[1] - v[0].position[1];
        const float x = p[0] - v[0].position[0], y = p[1] - v[0].position[1], area = ax * by - ay * bx;
        const float a = (x * by - y * bx) / area, b = (ax * y - ay * x) / area;
        const float u = v[0].uv[0] + a * (v[1].uv[0] - v[0].uv[0]) + b * (v[2].uv[0] - v[0].uv[0]);
        if (!(all[i].flux[0] > 0)) continue;
        for (k = 0; k < 3; k++) assert_true(dim[i].flux[k] == 0.5f * all[i].flux[k]);
        assert_memory_equal(dim[i].position, all[i].position, sizeof dim[i].position);
        if (u < 0.499f) {
            assert_memory_equal(&half[i], &all[i], sizeof half[i]);
            kept++;
        } else if (u > 0.501f) {
            assert_true(memcmp(&half[i], &all[i], sizeof half[i]) != 0);    /* empty, or what lies behind */
            left++;
        }
    }
    assert_true(kept > 10 && left > 10);
    free_shape(t, &s);
}

/* Opacity by dithering (paper of ism.h, section 6.4), as docs/gbuffer.md has it: of each 2 x 2 pixels that a surface
   covers, in a map of a light, a shadow map and the G-buffer, opacities of quarters leave exactly as many. */
static void opacities_are_dithered_by_functions_of_the_users(void **state)
{
    GL_TEST(t, state)
    static unsigned char empty[MOST_BYTES], full[MOST_BYTES], is[MOST_BYTES];
    static const char dither[] = "const float opacity = %.2f;\n"
                                 "bool glbk_fragment(vec2 uv, inout vec4 color)\n"
                                 "{\n"
                                 "    ivec2 p = ivec2(gl_FragCoord.xy) & 1;\n"
                                 "    float least = p.y == 0 ? p.x == 0 ? 0.5 : 2.5 : p.x == 0 ? 3.5 : 1.5;\n"
                                 "    return 4.0 * opacity > least;\n"
                                 "}\n";
    static const struct { int pass, width, height; size_t bytes;
    } kinds[3] = { { 0, RSM_SIDE, RSM_SIDE, sizeof(rsm_texel) },
                   { 1, ENVSH_SIDE, ENVSH_SIDE, 16 },
                   { 4, SEEN_SIDE, 8, sizeof(glbk_pixel) } };
    vertex square[6];
    shape s;
    int kind, level, i, x, y;
    for (i = 0; i < 6; i++) {                       /* of -0.9 to 0.9 */
        square[i] = corners[0];
        square[i].position[0] = i == 1 || i == 2 || i == 4 ? 0.9f : -0.9f;
        square[i].position[1] = i == 2 || i == 4 || i == 5 ? 0.9f : -0.9f;
        square[i].position[2] = 0;
    }
    s = make_shape_of(t, &usual, square);
    for (kind = 0; kind < 3; kind++) {
        const int pass = kinds[kind].pass, width = kinds[kind].width;
        const size_t bytes = kinds[kind].bytes;
        glbk_attributes own = { 0, 1, 2, 3, NULL, none_there };
        draw_by(t, pass, &own, &s, 15, empty);
        own.fragment = all_there;
        draw_by(t, pass, &own, &s, 15, full);
        for (level = 0; level <= 4; level++) {
            char text[sizeof dither + 32];
            int blocks = 0;
            snprintf(text, sizeof text, dither, 0.25 * level);
            own.fragment = text;
            draw_by(t, pass, &own, &s, 15, is);
            for (y = 0; y < kinds[kind].height; y += 2)
                for (x = 0; x < width; x += 2) {
                    int covered = 0, left = 0;
                    for (i = 0; i < 4; i++) {
                        const size_t at = bytes * (size_t)((y + i / 2) * width + x + i % 2);
                        covered += memcmp(full + at, empty + at, bytes) != 0;
                        if (memcmp(is + at, empty + at, bytes) == 0) continue;
                        assert_memory_equal(is + at, full + at, bytes);
                        left++;
                    }
                    if (covered < 4) continue;
                    assert_int_equal(left, level);
                    blocks++;
                }
            assert_true(blocks >= 25);
        }
    }
    free_shape(t, &s);
}

/* A fault is the text's own: the log says so. */
static void faults_of_the_users_functions_are_said(void **state)
{
    GL_TEST(t, state)
    static const char wrong[] = "void glbk_vertex(out vec3 position) { position = vec4(0.0); }\n";
    static const char missing[] = "float other() { return 1.0; }\n";
    glbk_csm_builder_desc d;
    glbk_csm_builder b;
    memset(&d, 0, sizeof d);
    d.view_fn = view_of;
    d.draw_fn = draw_layer;
    d.attributes.vertex = wrong;
    t->expected_errors = ~0u;
    assert_int_equal(glbk_csm_builder_create(&t->gl, &d, &b), GLBK_ERR_COMPILE);
    assert_non_null(strstr(t->log, "your text"));
    d.attributes.vertex = missing;
    assert_int_not_equal(glbk_csm_builder_create(&t->gl, &d, &b), GLBK_OK);
}

/* ---- what is refused ---- */

#define REFUSES(call, text)                                                                         \
    do {                                                                                            \
        t->log[0] = 0;                                                                              \
        assert_int_equal(call, GLBK_ERR_DESC);                                                      \
        assert_string_equal(t->log, text);                                                          \
    } while (0)

static void locations_that_cannot_be_are_named(void **state)
{
    GL_TEST(t, state)
    const glbk_attributes no_position = { -1, 0, 1, 2, NULL, NULL }, far_off = { 3, 16, 1, 2, NULL, NULL };
    const glbk_attributes twice = { 3, 4, 3, 2, NULL, NULL };
    const glbk_attributes at_1 = { 1, -1, -1, -1, NULL, NULL };
    glbk_rsm_renderer r;
    glbk_csm_builder c;
    glbk_envsh_maps e;
    glbk_sfield_builder b;
    glbk_rsm_renderer_desc rd;
    glbk_csm_builder_desc cd;
    glbk_envsh_maps_desc ed;
    glbk_sfield_builder_desc bd;
    memset(&rd, 0, sizeof rd);
    memset(&cd, 0, sizeof cd);
    memset(&ed, 0, sizeof ed);
    memset(&bd, 0, sizeof bd);
    rd.width = rd.height = 4;
    rd.attributes = no_position;
    REFUSES(glbk_rsm_renderer_create(&t->gl, &rd, &r),
            "glbk_rsm_renderer_create: desc.attributes.position is -1; it must be 0..15");
    assert_true(r.width == 0 && r.attributes.uv == 0);
    cd.view_fn = view_of;
    cd.draw_fn = draw_layer;
    cd.attributes = far_off;
    REFUSES(glbk_csm_builder_create(&t->gl, &cd, &c),
            "glbk_csm_builder_create: desc.attributes.normal is 16; it must be at most 15");
    ed.capacity = 1;
    ed.attributes = twice;
    REFUSES(glbk_envsh_maps_create(&t->gl, &ed, &e),
            "glbk_envsh_maps_create: desc.attributes.uv is 3; it must be used by no other attribute");
    bd.draw_fn = draw_emitter;
    bd.source = 1;
    bd.attributes = at_1;
    REFUSES(glbk_sfield_builder_create(&t->gl, &bd, &b), "glbk_sfield_builder_create: desc.radiance_attribute is 1; "
            "it must be other than desc.attributes.position");
    bd.radiance_attribute = 16;
    REFUSES(glbk_sfield_builder_create(&t->gl, &bd, &b),
            "glbk_sfield_builder_create: desc.radiance_attribute is 16; it must be 0..15");
    bd.attributes = twice;
    REFUSES(glbk_sfield_builder_create(&t->gl, &bd, &b),
            "glbk_sfield_builder_create: desc.attributes.uv is 3; it must be used by no other attribute");
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = { gl_unit_test(maps_of_lights_have_normals_and_colours_from_elsewhere),
                                  gl_unit_test(builders_of_maps_find_positions_elsewhere),
                                  gl_unit_test(casters_have_positions_elsewhere),
                                  gl_unit_test(sources_have_radiance_elsewhere),
                                  gl_unit_test(vertices_are_found_by_functions_of_the_users),
                                  gl_unit_test(pixels_are_left_out_by_functions_of_the_users),
                                  gl_unit_test(texels_are_left_and_coloured_as_the_function_says),
                                  gl_unit_test(opacities_are_dithered_by_functions_of_the_users),
                                  gl_unit_test(faults_of_the_users_functions_are_said),
                                  gl_unit_test(locations_that_cannot_be_are_named) };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_USUAL);
}
