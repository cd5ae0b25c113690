/* attributes_test - all calls that draw the user's meshes take a glbk_attributes: what is drawn from attributes that
   lie elsewhere is what the usual locations give, to the last bit, and locations that cannot be are refused by name.
   gbuffer_test has the same of the G-buffer itself. */
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

static shape make_shape(gl_test *t, const places *where)
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
    gl->BufferData(GLBK_GL_ARRAY_BUFFER, sizeof corners, corners, GLBK_GL_STATIC_DRAW);
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

static void free_shape(gl_test *t, shape *s)
{
    t->gl.gl.DeleteVertexArrays(1, &s->array);
    t->gl.gl.DeleteBuffers(1, &s->buffer);
}

static void draw_instances(glbk_context *gl, const shape *s, uint32_t instances)
{
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
    const glbk_attributes none = { 0, 0, 0, 0 }, at_moved = { 12, 0, 5, 7 }, at_bare = { 3, -1, -1, -1 };
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

static int add(void *user, uint32_t index, const float *z1, const float *z2, const float *z3)
{
    return cohsm_builder_add((cohsm_builder *)user, index, z1, z2, z3) != COHSM_OK;
}

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
    assert_glbk(t, glbk_csm_builder_replay(&t->gl, &gpu, add, b.views));
    assert_int_equal(cohsm_builder_finish(b.views, &maps, NULL), COHSM_OK);
    glbk_csm_builder_free(&t->gl, &gpu);
    cohsm_builder_free(b.views);
    return maps;
}

static void builders_of_maps_find_positions_elsewhere(void **state)
{
    GL_TEST(t, state)
    const glbk_attributes none = { 0, 0, 0, 0 }, at_moved = { 12, 0, 5, 7 }, wrong = { 0, 12, 5, 7 };
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
    const glbk_attributes none = { 0, 0, 0, 0 }, at_moved = { 12, 0, 5, 7 };
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
    const glbk_attributes none = { 0, 0, 0, 0 }, at_other = { 1, -1, -1, -1 };
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
    const glbk_attributes no_position = { -1, 0, 1, 2 }, far_off = { 3, 16, 1, 2 }, twice = { 3, 4, 3, 2 };
    const glbk_attributes at_1 = { 1, -1, -1, -1 };
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
                                  gl_unit_test(locations_that_cannot_be_are_named) };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_USUAL);
}
