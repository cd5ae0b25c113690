/* gbuffer_test - the G-buffer of all techniques (gl_gbuffer.h): what is drawn is what the geometry says, comes back
   from an upload, and is found again by an import from textures in every packing, within bounds that are stated. */
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

#include "gl_backend/gl_gbuffer.h"

#include "gl_test.h"

#include "gl_state.h"
#include "gl_wrong.h"

enum { W = 48, H = 32, PIXELS = W * H };

static const float eye[3] = { 0.5f, 2, 6 };

/* ---- a scene: a floor, and a box that turns a corner to the eye ---- */

typedef struct vertex { float position[3], normal[3], uv[2], tangent[4]; } vertex;
typedef struct shape { uint32_t array, buffer; int32_t count; } shape;

static void put_quad(vertex *v, const float *p, const float *a, const float *b, const float *n)
{
    static const float corner[6][2] = { { 0, 0 }, { 1, 0 }, { 1, 1 }, { 0, 0 }, { 1, 1 }, { 0, 1 } };
    int i, k;
    for (i = 0; i < 6; i++) {
        for (k = 0; k < 3; k++) {
            v[i].position[k] = p[k] + corner[i][0] * a[k] + corner[i][1] * b[k];
            v[i].normal[k] = n[k];
            v[i].tangent[k] = a[k];
        }
        v[i].uv[0] = corner[i][0];
        v[i].uv[1] = corner[i][1];
        v[i].tangent[3] = 1;
    }
}

/* Attributes at the given locations; those below 0 are left out. */
static shape upload_shape(gl_test *t, const vertex *v, int count, const int32_t at[4])
{
    static const int32_t sizes[4] = { 3, 3, 2, 4 };
    const glbk_functions *gl = &t->gl.gl;
    size_t offset = 0;
    shape s;
    int i;
    s.count = count;
    gl->GenVertexArrays(1, &s.array);
    gl->GenBuffers(1, &s.buffer);
    gl->BindVertexArray(s.array);
    gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, s.buffer);
    gl->BufferData(GLBK_GL_ARRAY_BUFFER, (ptrdiff_t)((size_t)count * sizeof *v), v, GLBK_GL_STATIC_DRAW);
    for (i = 0; i < 4; i++) {
        if (at[i] >= 0) {
            gl->EnableVertexAttribArray((uint32_t)at[i]);
            gl->VertexAttribPointer((uint32_t)at[i], sizes[i], GLBK_GL_FLOAT, 0, sizeof *v, (const void *)offset);
        }
        offset += 4 * (size_t)sizes[i];
    }
    gl->BindVertexArray(0);
    gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, 0);
    return s;
}

static shape make_floor(gl_test *t, const int32_t at[4])
{
    static const float p[3] = { -4, 0, 4 }, a[3] = { 8, 0, 0 }, b[3] = { 0, 0, -8 }, n[3] = { 0, 1, 0 };
    vertex v[6];
    put_quad(v, p, a, b, n);
    return upload_shape(t, v, 6, at);
}

/* Two sides of 1.6 by 1.6 and 45 degrees to the eye. */
static shape make_box(gl_test *t, const int32_t at[4])
{
    const float h = 1.1313708f, d = 0.70710678f;
    const float edge[3] = { 0, 0, 1.5f }, up[3] = { 0, 1.6f, 0 }, right[3] = { h, 0, -h }, left[3] = { h, 0, h };
    const float far_left[3] = { -h, 0, 1.5f - h }, n_right[3] = { d, 0, d }, n_left[3] = { -d, 0, d };
    vertex v[12];
    put_quad(v, edge, right, up, n_right);
    put_quad(v + 6, far_left, left, up, n_left);
    return upload_shape(t, v, 12, at);
}

static void free_shape(gl_test *t, shape *s)
{
    t->gl.gl.DeleteVertexArrays(1, &s->array);
    t->gl.gl.DeleteBuffers(1, &s->buffer);
}

/* A camera at the eye that looks along -z, a little down; reversed and 0..1 clip spaces of the same view. */
static void make_view(glbk_clip_depth depth, float clip[16])
{
    const float n = 1, f = 20, pitch = 0.25f, c = cosf(pitch), s = sinf(pitch);
    const float view[16] = { 1, 0, 0, 0, 0, c, s, 0, 0, -s, c, 0, -eye[0], -c * eye[1] + s * eye[2],
                             -s * eye[1] - c * eye[2], 1 };
    float p[16] = { 0 };
    int i, k, j;
    p[0] = 1.4f;
    p[5] = 2.1f;
    p[11] = -1;
    p[10] = depth == GLBK_CLIP_DEPTH_REVERSED ? n / (f - n) : depth == GLBK_CLIP_DEPTH_ZERO_TO_ONE
                                                               ? f / (n - f) : (f + n) / (n - f);
    p[14] = depth == GLBK_CLIP_DEPTH_REVERSED ? f * n / (f - n) : depth == GLBK_CLIP_DEPTH_ZERO_TO_ONE
                                                                   ? f * n / (n - f) : 2 * f * n / (n - f);
    for (i = 0; i < 4; i++)
        for (k = 0; k < 4; k++)
            for (clip[4 * i + k] = 0, j = 0; j < 4; j++) clip[4 * i + k] += p[4 * j + k] * view[4 * i + j];
}

static glbk_gbuffer make_gbuffer(gl_test *t, const glbk_attributes *attributes)
{
    glbk_gbuffer_desc d;
    glbk_gbuffer g;
    memset(&d, 0, sizeof d);
    d.width = W;
    d.height = H;
    if (attributes) d.attributes = *attributes;
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &d, &g));
    return g;
}

static void draw_shape(gl_test *t, glbk_gbuffer *g, const shape *s, const glbk_surface *surface)
{
    assert_glbk(t, glbk_gbuffer_object(&t->gl, g, surface));
    t->gl.gl.BindVertexArray(s->array);
    t->gl.gl.DrawArrays(GLBK_GL_TRIANGLES, 0, s->count);
    t->gl.gl.BindVertexArray(0);
}

static glbk_surface floor_surface(void)
{
    glbk_surface s;
    memset(&s, 0, sizeof s);
    s.material.diffuse[0] = 0.5f;
    s.material.diffuse[1] = 0.25f;
    s.entity = 1;
    s.plane = 3;
    return s;
}

static glbk_surface box_surface(void)
{
    glbk_surface s;
    memset(&s, 0, sizeof s);
    s.material.kind = LSAMP_MATERIAL_PHONG;
    s.material.diffuse[2] = 0.75f;
    s.material.specular[1] = 0.125f;
    s.material.exponent = 20;
    s.entity = 70000;
    s.occlusion = 0.25f;
    return s;
}

static void draw_scene(gl_test *t, glbk_gbuffer *g, const int32_t at[4], glbk_pixel *out)
{
    glbk_surface on_floor = floor_surface(), on_box = box_surface();
    shape ground = make_floor(t, at), box = make_box(t, at);
    float clip[16];
    make_view(GLBK_CLIP_DEPTH_DEFAULT, clip);
    assert_glbk(t, glbk_gbuffer_begin(&t->gl, g, clip, eye));
    draw_shape(t, g, &ground, &on_floor);
    draw_shape(t, g, &box, &on_box);
    assert_glbk(t, glbk_gbuffer_read(&t->gl, g, 0, H, out));
    free_shape(t, &ground);
    free_shape(t, &box);
}

static const int32_t usual[4] = { 0, 1, 2, 3 };

static float apart(const float *a, const float *b)
{
    float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return sqrtf(x * x + y * y + z * z);
}

static int is_seen(const glbk_pixel *p) { return p->normal[0] != 0 || p->normal[1] != 0 || p->normal[2] != 0; }

/* ---- drawing and uploading ---- */

static void what_is_drawn_is_what_the_geometry_says(void **state)
{
    GL_TEST(t, state)
    static glbk_pixel p[PIXELS], back[PIXELS];
    glbk_gbuffer g = make_gbuffer(t, NULL);
    enum { SUBPIXEL_BITS = 0x0D50 };
    int i, on_floor = 0, on_box = 0, empty = 0;
    int32_t bits = 0;
    float clip[16];
    float step = 1e-3f, rounding = 0;
    make_view(GLBK_CLIP_DEPTH_DEFAULT, clip);
    draw_scene(t, &g, usual, p);
    assert_true(g.has_depth && g.has_clip && memcmp(g.world_to_clip, clip, sizeof clip) == 0);
    if (!gl_is_mesa(t)) {       /* a driver may interpolate from the corners of the grid that it moves vertices to */
        t->gl.gl.GetIntegerv(SUBPIXEL_BITS, &bits);
        step = ldexpf(1, -bits);
        rounding = 1e-6f;
    }
    for (i = 0; i < PIXELS; i++) {
        const float *at = p[i].position;
        float ndc[4];
        int k;
        if (!is_seen(&p[i])) {
            assert_int_equal(p[i].entity, 0);
            empty++;
            continue;
        }
        for (k = 0; k < 4; k++) ndc[k] = clip[k] * at[0] + clip[4 + k] * at[1] + clip[8 + k] * at[2] + clip[12 + k];
        assert_true(fabsf((ndc[0] / ndc[3] * 0.5f + 0.5f) * W - (float)(i % W) - 0.5f) < step);
        assert_true(fabsf((ndc[1] / ndc[3] * 0.5f + 0.5f) * H - (float)(i / W) - 0.5f) < step);
        assert_true(apart(p[i].normal, p[i].geometric_normal) < 1e-3f);
        if (p[i].entity == 1) {
            assert_true(fabsf(at[1]) < 1e-4f && fabsf(p[i].normal[1] - 1) <= rounding);
            assert_true(p[i].plane == 3 && p[i].occlusion == 0);
            assert_int_equal(p[i].material.kind, LSAMP_MATERIAL_LAMBERT);
            assert_true(p[i].material.diffuse[0] == 0.5f && p[i].material.diffuse[1] == 0.25f);
            on_floor++;
        } else {
            assert_int_equal(p[i].entity, 70000);
            assert_true(fabsf(at[2] + fabsf(at[0]) - 1.5f) < 1e-4f && p[i].normal[2] > 0.7f);
            assert_true(p[i].material.kind == LSAMP_MATERIAL_PHONG && p[i].material.specular[1] == 0.125f &&
                        p[i].material.exponent == 20 && p[i].material.diffuse[2] == 0.75f);
            assert_true(fabsf(p[i].occlusion - 0.25f) < 1e-5f);
            on_box++;
        }
    }
    assert_true(on_floor > 300 && on_box > 100 && empty > 100);

    assert_glbk(t, glbk_gbuffer_upload(&t->gl, &g, 0, H, p));           /* the same comes back, to the last bit */
    assert_true(!g.has_depth && !g.has_clip);
    assert_glbk(t, glbk_gbuffer_read(&t->gl, &g, 0, H, back));
    for (i = 0; i < PIXELS; i++) {
        assert_true(apart(p[i].geometric_normal, back[i].geometric_normal) < 5e-5f);
        memcpy(back[i].geometric_normal, p[i].geometric_normal, sizeof p[i].geometric_normal);
        assert_memory_equal(&p[i], &back[i], sizeof p[i]);
    }
    memset(p, 0, sizeof p[0] * W);                                      /* rows by themselves */
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, &g, 1, 1, p));
    assert_glbk(t, glbk_gbuffer_read(&t->gl, &g, 0, 3, back));
    for (i = 0; i < W; i++) assert_true(is_seen(&back[i]) && !is_seen(&back[W + i]) && is_seen(&back[2 * W + i]));
    glbk_gbuffer_free(&t->gl, &g);
}

static void a_new_one_is_empty(void **state)
{
    GL_TEST(t, state)
    static glbk_pixel p[PIXELS];
    glbk_gbuffer g = make_gbuffer(t, NULL);
    int i;
    memset(p, 1, sizeof p);
    assert_glbk(t, glbk_gbuffer_read(&t->gl, &g, 0, H, p));
    for (i = 0; i < PIXELS; i++) assert_true(!is_seen(&p[i]) && p[i].entity == 0);
    glbk_gbuffer_free(&t->gl, &g);
    glbk_gbuffer_free(&t->gl, &g);
    glbk_gbuffer_free(NULL, NULL);
}

static void attributes_are_where_the_desc_says(void **state)
{
    GL_TEST(t, state)
    static glbk_pixel p[PIXELS], other[PIXELS];
    static const int32_t moved[4] = { 12, 0, 5, 3 }, bare[4] = { 1, -1, -1, -1 };
    const glbk_attributes at_moved = { 12, 0, 5, 3, NULL, NULL }, at_bare = { 1, -1, -1, -1, NULL, NULL };
    glbk_gbuffer g = make_gbuffer(t, NULL), h = make_gbuffer(t, &at_moved), b = make_gbuffer(t, &at_bare);
    int i;
    draw_scene(t, &g, usual, p);
    draw_scene(t, &h, moved, other);
    assert_memory_equal(p, other, sizeof p);
    draw_scene(t, &b, bare, other);                         /* without normals: those of the triangles */
    for (i = 0; i < PIXELS; i++) {
        assert_true(apart(p[i].position, other[i].position) == 0 && p[i].entity == other[i].entity);
        assert_true(apart(p[i].normal, other[i].normal) < 1e-3f);
    }
    glbk_gbuffer_free(&t->gl, &g);
    glbk_gbuffer_free(&t->gl, &h);
    glbk_gbuffer_free(&t->gl, &b);
}

static void maps_holes_and_lobes_are_drawn(void **state)
{
    GL_TEST(t, state)
    static glbk_pixel p[PIXELS];
    static const uint8_t color[8] = { 255, 128, 0, 255, 255, 255, 255, 0 }, gloss[4] = { 255, 128, 64, 255 },
                         bump[4] = { 218, 128, 218, 255 };      /* leans by 45 degrees to the tangent */
    glbk_texture color_map = gl_texture(t, GLBK_FORMAT_RGBA8, 2, 1, color);
    glbk_texture gloss_map = gl_texture(t, GLBK_FORMAT_RGBA8, 1, 1, gloss);
    glbk_texture normal_map = gl_texture(t, GLBK_FORMAT_RGBA8, 1, 1, bump);
    glbk_gbuffer g = make_gbuffer(t, NULL);
    glbk_surface s;
    shape ground = make_floor(t, usual);
    float clip[16];
    int i, seen = 0, holes = 0;

    memset(&s, 0, sizeof s);
    make_view(GLBK_CLIP_DEPTH_DEFAULT, clip);
    s.material.kind = LSAMP_MATERIAL_METAL_ROUGH;
    s.material.diffuse[0] = s.material.diffuse[1] = s.material.diffuse[2] = 0.5f;
    s.material.metallic = 0.5f;
    s.material.roughness = 0.75f;
    s.alpha_cutoff = 0.5f;
    s.color_map = &color_map;
    s.gloss_map = &gloss_map;
    s.normal_map = &normal_map;
    s.transform[0] = s.transform[5] = s.transform[10] = s.transform[15] = 1;
    s.transform[13] = 0.5f;                                     /* half a unit up */
    assert_glbk(t, glbk_gbuffer_begin(&t->gl, &g, clip, eye));
    draw_shape(t, &g, &ground, &s);
    assert_glbk(t, glbk_gbuffer_read(&t->gl, &g, 0, H, p));
    for (i = 0; i < PIXELS; i++) {
        if (!is_seen(&p[i])) { holes++; continue; }
        seen++;
        assert_true(fabsf(p[i].position[1] - 0.5f) < 1e-4f);
        assert_true(p[i].position[0] < 0.1f);                /* the right half is a hole */
        assert_true(fabsf(p[i].normal[0] - 0.7071f) < 0.01f && fabsf(p[i].normal[1] - 0.7071f) < 0.01f);
        assert_true(fabsf(p[i].material.diffuse[1] - 64 / 255.0f) < 1e-4f && p[i].material.diffuse[2] == 0);
        assert_true(fabsf(p[i].material.metallic - 0.5f * 64 / 255) < 1e-4f);
        assert_true(fabsf(p[i].material.roughness - 0.75f * 128 / 255) < 1e-4f);
        assert_true(p[i].geometric_normal[1] > 0.999f);
    }
    assert_true(seen > 150 && holes > 500);

    memset(&s, 0, sizeof s);
    s.material.kind = LSAMP_MATERIAL_LAFORTUNE;
    s.material.lobe_count = 2;
    s.first_lobe = 5;
    assert_glbk(t, glbk_gbuffer_begin(&t->gl, &g, clip, eye));
    draw_shape(t, &g, &ground, &s);
    assert_glbk(t, glbk_gbuffer_read(&t->gl, &g, 0, 1, p));
    assert_true(p[0].first_lobe == 5 && p[0].material.lobe_count == 2 && p[0].tangent[0] > 0.999f);
    free_shape(t, &ground);
    glbk_texture_free(&t->gl, &color_map);
    glbk_texture_free(&t->gl, &gloss_map);
    glbk_texture_free(&t->gl, &normal_map);
    glbk_gbuffer_free(&t->gl, &g);
}

/* ---- importing ---- */

/* The user's view space: turned about y and moved. */
static const float to_world[16] = { 0.8f, 0, -0.6f, 0, 0, 1, 0, 0, 0.6f, 0, 0.8f, 0, 1, 2, 3, 1 };

static void to_view(const float *v, float w, float *out)
{
    int i;
    for (i = 0; i < 3; i++)
        out[i] = to_world[4 * i] * (v[0] - w) + to_world[4 * i + 1] * (v[1] - 2 * w) +
                 to_world[4 * i + 2] * (v[2] - 3 * w);
}

static void square_of(const float *n, float *out)
{
    float sum = fabsf(n[0]) + fabsf(n[1]) + fabsf(n[2]), x = n[0] / sum, y = n[1] / sum;
    out[0] = n[2] < 0 ? (1 - fabsf(y)) * (x < 0 ? -1.0f : 1.0f) : x;
    out[1] = n[2] < 0 ? (1 - fabsf(x)) * (y < 0 ? -1.0f : 1.0f) : y;
}

/* Normals of the pixels as a texture of that packing holds them; view: in view space. */
static glbk_texture pack_normals(gl_test *t, const glbk_pixel *p, glbk_normal_packing packing, int view)
{
    static float floats[PIXELS][4];
    static uint8_t bytes[PIXELS][4];
    const int unit = packing == GLBK_NORMAL_PACKING_UNIT || packing == GLBK_NORMAL_PACKING_OCTAHEDRAL_UNIT;
    const int square = packing >= GLBK_NORMAL_PACKING_OCTAHEDRAL;
    int i, k;
    memset(floats, 0, sizeof floats);
    for (i = 0; i < PIXELS; i++) {
        float n[3];
        memcpy(n, p[i].normal, sizeof n);
        if (view && is_seen(&p[i])) to_view(p[i].normal, 0, n);
        if (square && is_seen(&p[i])) square_of(n, floats[i]);
        else memcpy(floats[i], n, sizeof n);
        for (k = 0; k < 4; k++)
            bytes[i][k] = is_seen(&p[i]) ? (uint8_t)((floats[i][k] * 0.5f + 0.5f) * 255 + 0.5f) : (uint8_t)0;
    }
    return unit ? gl_texture(t, GLBK_FORMAT_RGBA8, W, H, bytes) : gl_texture(t, GLBK_FORMAT_RGBA32F, W, H, floats);
}

static glbk_texture pack_positions(gl_test *t, const glbk_pixel *p, int view)
{
    static float floats[PIXELS][4];
    int i;
    memset(floats, 0, sizeof floats);
    for (i = 0; i < PIXELS; i++) {
        if (!is_seen(&p[i])) continue;
        memcpy(floats[i], p[i].position, 12);
        if (view) to_view(p[i].position, 1, floats[i]);
        floats[i][3] = 1;
    }
    return gl_texture(t, GLBK_FORMAT_RGBA32F, W, H, floats);
}

static glbk_texture pack_depths(gl_test *t, const glbk_pixel *p, glbk_clip_depth convention)
{
    static float depths[PIXELS];
    const int reversed = convention == GLBK_CLIP_DEPTH_REVERSED, half = convention == GLBK_CLIP_DEPTH_MINUS_ONE_TO_ONE;
    float clip[16];
    int i, k;
    make_view(convention, clip);
    for (i = 0; i < PIXELS; i++) {
        const float *at = p[i].position;
        double z, w;
        depths[i] = reversed ? 0.0f : 1.0f;
        if (!is_seen(&p[i])) continue;
        z = (double)clip[14];
        w = (double)clip[15];
        for (k = 0; k < 3; k++) {
            z += (double)clip[4 * k + 2] * (double)at[k];
            w += (double)clip[4 * k + 3] * (double)at[k];
        }
        depths[i] = (float)(half ? z / w * 0.5 + 0.5 : z / w);
    }
    return gl_texture(t, GLBK_FORMAT_DEPTH32F, W, H, depths);
}

/* What was imported against what had been drawn: as many pixels seen; the rest within the bounds. */
static void compare(gl_test *t, glbk_gbuffer *g, const glbk_pixel *p, float place, float normal)
{
    static glbk_pixel q[PIXELS];
    int i, seen = 0, edges = 0;
    assert_glbk(t, glbk_gbuffer_read(&t->gl, g, 0, H, q));
    for (i = 0; i < PIXELS; i++) {
        assert_int_equal(is_seen(&p[i]), is_seen(&q[i]));
        if (!is_seen(&p[i])) continue;
        seen++;
        assert_true(apart(p[i].position, q[i].position) <= place);
        assert_true(apart(p[i].normal, q[i].normal) <= normal);
        edges += apart(p[i].normal, q[i].geometric_normal) > 0.02f;
    }
    if (edges * 50 >= seen) printf("%d normals of surfaces of %d lie on another face\n", edges, seen);
    assert_true(edges * 50 < seen);                         /* where neighbours lie on another face */
}

static void every_packing_of_normals_is_imported(void **state)
{
    GL_TEST(t, state)
    static glbk_pixel p[PIXELS];
    static const float bounds[GLBK_NORMAL_PACKING_COUNT] = { 1e-6f, 1e-6f, 0.007f, 1e-6f, 0.012f };
    glbk_gbuffer g = make_gbuffer(t, NULL);
    int packing, view;
    draw_scene(t, &g, usual, p);
    for (view = 0; view < 2; view++) {
        glbk_texture places = pack_positions(t, p, view);
        for (packing = 0; packing < GLBK_NORMAL_PACKING_COUNT; packing++) {
            glbk_texture normals = pack_normals(t, p, (glbk_normal_packing)packing, view);
            glbk_import in;
            memset(&in, 0, sizeof in);
            in.positions = &places;
            in.normals = &normals;
            in.normal_packing = (glbk_normal_packing)packing;
            memcpy(in.eye, eye, sizeof eye);
            if (view) memcpy(in.to_world, to_world, sizeof to_world);
            assert_glbk(t, glbk_gbuffer_import(&t->gl, &g, &in));
            assert_true(!g.has_depth && !g.has_clip);
            compare(t, &g, p, view ? 3e-6f : 0.0f, bounds[packing]);
            glbk_texture_free(&t->gl, &normals);
        }
        glbk_texture_free(&t->gl, &places);
    }
    glbk_gbuffer_free(&t->gl, &g);
}

/* Moves what was drawn to the centre of its pixel, along its plane: interpolation is off by a step of the grid of the
   driver, and a depth stands for the centre. */
static void center(glbk_pixel *p)
{
    const double c = cos(0.25), s = sin(0.25);              /* of make_view's pitch */
    int i, k;
    for (i = 0; i < PIXELS; i++) {
        const double x = ((i % W + 0.5) / W * 2 - 1) / 1.4, y = ((i / W + 0.5) / H * 2 - 1) / 2.1;
        const double ray[3] = { x, c * y - s, -s * y - c };
        double up = 0, down = 0;
        for (k = 0; k < 3; k++) {
            up += (double)p[i].geometric_normal[k] * ((double)p[i].position[k] - (double)eye[k]);
            down += (double)p[i].geometric_normal[k] * ray[k];
        }
        for (k = 0; k < 3 && is_seen(&p[i]); k++) p[i].position[k] = (float)((double)eye[k] + up / down * ray[k]);
    }
}

static void every_convention_of_depth_is_imported(void **state)
{
    GL_TEST(t, state)
    static glbk_pixel p[PIXELS];
    glbk_gbuffer g = make_gbuffer(t, NULL);
    int convention, k;
    float usual_clip[16];
    draw_scene(t, &g, usual, p);
    center(p);
    make_view(GLBK_CLIP_DEPTH_DEFAULT, usual_clip);
    for (convention = 1; convention < GLBK_CLIP_DEPTH_COUNT; convention++) {
        glbk_texture depths = pack_depths(t, p, (glbk_clip_depth)convention), normals;
        glbk_import in;
        memset(&in, 0, sizeof in);
        normals = pack_normals(t, p, GLBK_NORMAL_PACKING_FLOAT, 0);
        in.depth = &depths;
        in.normals = &normals;
        in.clip_depth = (glbk_clip_depth)convention;
        make_view(in.clip_depth, in.world_to_clip);
        memcpy(in.eye, eye, sizeof eye);
        assert_glbk(t, glbk_gbuffer_import(&t->gl, &g, &in));
        compare(t, &g, p, 2e-5f, 1e-6f);
        assert_true(g.has_depth && g.has_clip);
        for (k = 0; k < 16; k++) assert_true(fabsf(g.world_to_clip[k] - usual_clip[k]) < 1e-5f);
        glbk_texture_free(&t->gl, &depths);
        glbk_texture_free(&t->gl, &normals);
    }
    glbk_gbuffer_free(&t->gl, &g);
}

/* The depth that a pass finds: a square at a distance, drawn with the depth test into colours of its own. */
static int count_behind(gl_test *t, glbk_gbuffer *g, float z)
{
    static const char vertex_text[] =
        "void main()\n"
        "{\n"
        "    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, AT_Z, 1.0);\n"
        "}\n";
    static const char text[] = "layout(location = 0) out vec4 color;\nvoid main() { color = vec4(1.0); }\n";
    static float seen[PIXELS][4];
    static const float zero[4] = { 0, 0, 0, 0 };
    char defines[40];
    glbk_texture color = gl_texture(t, GLBK_FORMAT_RGBA8, W, H, NULL);
    glbk_target_desc targets;
    glbk_target target;
    glbk_source source;
    glbk_program program;
    glbk_pass pass;
    int i, count = 0;
    memset(&targets, 0, sizeof targets);
    memset(&source, 0, sizeof source);
    memset(&pass, 0, sizeof pass);
    snprintf(defines, sizeof defines, "AT_Z=%.4f", (double)z);
    source.vertex = vertex_text;
    source.fragment = text;
    source.defines = defines;
    assert_glbk(t, glbk_program_compile(&t->gl, &source, &program));
    targets.color[0] = &color;
    targets.depth = &g->depth;
    assert_glbk(t, glbk_target_create(&t->gl, &targets, &target));
    pass.target = &target;
    pass.depth = GLBK_DEPTH_GREATER;
    assert_glbk(t, glbk_begin(&t->gl, &pass, &program));
    t->gl.gl.DepthMask(0);
    glbk_clear(&t->gl, &target, 0, zero);
    glbk_draw_screen(&t->gl);
    assert_glbk(t, glbk_target_read(&t->gl, &target, 0, 0, 0, W, H, seen));
    for (i = 0; i < PIXELS; i++) count += seen[i][0] > 0;
    glbk_target_free(&t->gl, &target);
    glbk_texture_free(&t->gl, &color);
    glbk_program_free(&t->gl, &program);
    return count;
}

static void its_depth_is_that_of_the_import(void **state)
{
    GL_TEST(t, state)
    static glbk_pixel p[PIXELS];
    glbk_gbuffer g = make_gbuffer(t, NULL);
    glbk_texture places, depths, normals;
    glbk_import in;
    int drawn, reversed, by_places;
    draw_scene(t, &g, usual, p);
    drawn = count_behind(t, &g, 0.85f);
    assert_true(drawn > 200 && drawn < PIXELS - 200);
    memset(&in, 0, sizeof in);
    depths = pack_depths(t, p, GLBK_CLIP_DEPTH_REVERSED);
    places = pack_positions(t, p, 0);
    normals = pack_normals(t, p, GLBK_NORMAL_PACKING_FLOAT, 0);
    in.normals = &normals;
    in.depth = &depths;
    in.clip_depth = GLBK_CLIP_DEPTH_REVERSED;
    make_view(in.clip_depth, in.world_to_clip);
    assert_glbk(t, glbk_gbuffer_import(&t->gl, &g, &in));
    reversed = count_behind(t, &g, 0.85f);          /* 0..1 of reversed clip space is another curve */
    assert_true(reversed > 0 && reversed < PIXELS);
    in.depth = NULL;
    in.positions = &places;
    in.clip_depth = GLBK_CLIP_DEPTH_DEFAULT;
    make_view(in.clip_depth, in.world_to_clip);
    assert_glbk(t, glbk_gbuffer_import(&t->gl, &g, &in));
    by_places = count_behind(t, &g, 0.85f);
    assert_true(abs(by_places - drawn) <= 2);
    glbk_texture_free(&t->gl, &places);
    glbk_texture_free(&t->gl, &depths);
    glbk_texture_free(&t->gl, &normals);
    glbk_gbuffer_free(&t->gl, &g);
}

static void a_depth_texture_of_the_users_is_drawn_with_and_left_alone(void **state)
{
    GL_TEST(t, state)
    enum { SUBPIXEL_BITS = 0x0D50 };
    static glbk_pixel p[PIXELS];
    int32_t bits = 0;
    glbk_texture depth = gl_texture(t, GLBK_FORMAT_DEPTH24, W, H, NULL), normals;
    glbk_gbuffer_desc d;
    glbk_gbuffer g;
    glbk_import in;
    int drawn;
    t->gl.gl.GetIntegerv(SUBPIXEL_BITS, &bits);
    if (bits < 8) {
        printf("skip: corners lie on 1/%d of a pixel here; positions of depths are compared more finely\n", 1 << bits);
        glbk_texture_free(&t->gl, &depth);
        skip();
    }
    memset(&d, 0, sizeof d);
    memset(&in, 0, sizeof in);
    d.width = W;
    d.height = H;
    d.depth = &depth;
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &d, &g));
    draw_scene(t, &g, usual, p);
    drawn = count_behind(t, &g, 0.85f);
    normals = pack_normals(t, p, GLBK_NORMAL_PACKING_FLOAT, 0);
    in.normals = &normals;
    in.depth = &depth;                                      /* read while it is not attached */
    make_view(GLBK_CLIP_DEPTH_DEFAULT, in.world_to_clip);
    memcpy(in.eye, eye, sizeof eye);
    assert_glbk(t, glbk_gbuffer_import(&t->gl, &g, &in));
    compare(t, &g, p, 1e-3f, 1e-6f);                        /* 24 bits, near 1, far 20 */
    assert_true(g.has_depth && count_behind(t, &g, 0.85f) == drawn);
    glbk_gbuffer_free(&t->gl, &g);
    assert_true(depth.name != 0 && drawn > 200);
    glbk_texture_free(&t->gl, &depth);
    glbk_texture_free(&t->gl, &normals);
}

static void colours_gloss_openness_and_entities_are_imported(void **state)
{
    GL_TEST(t, state)
    static glbk_pixel p[PIXELS], q[PIXELS];
    static uint8_t color[PIXELS][4], gloss[PIXELS][4], open[PIXELS], entity[PIXELS];
    glbk_gbuffer g = make_gbuffer(t, NULL);
    glbk_texture places, normals, color_map, gloss_map, open_map, entities;
    glbk_import in;
    int i, k;
    draw_scene(t, &g, usual, p);
    for (i = 0; i < PIXELS; i++) {
        for (k = 0; k < 4; k++) {
            color[i][k] = (uint8_t)(i * 7 + k * 50);
            gloss[i][k] = (uint8_t)(i * 3 + k * 90);
        }
        open[i] = (uint8_t)(i * 11);
        entity[i] = (uint8_t)(i % 200);
    }
    memset(&in, 0, sizeof in);
    places = pack_positions(t, p, 0);
    normals = pack_normals(t, p, GLBK_NORMAL_PACKING_FLOAT, 0);
    color_map = gl_texture(t, GLBK_FORMAT_RGBA8, W, H, color);
    gloss_map = gl_texture(t, GLBK_FORMAT_RGBA8, W, H, gloss);
    open_map = gl_texture(t, GLBK_FORMAT_R8, W, H, open);
    entities = gl_texture(t, GLBK_FORMAT_R8UI, W, H, entity);
    in.positions = &places;
    in.normals = in.geometric_normals = &normals;
    in.material.kind = LSAMP_MATERIAL_METAL_ROUGH;
    in.material.diffuse[0] = in.material.diffuse[1] = in.material.diffuse[2] = 0.5f;
    in.material.metallic = in.material.roughness = 1;
    in.color_map = &color_map;
    in.gloss_map = &gloss_map;
    in.open_map = &open_map;
    in.entities = &entities;
    in.plane = 9;
    memcpy(in.eye, eye, sizeof eye);
    assert_glbk(t, glbk_gbuffer_import(&t->gl, &g, &in));
    assert_glbk(t, glbk_gbuffer_read(&t->gl, &g, 0, H, q));
    for (i = 0; i < PIXELS; i++) {
        if (!is_seen(&p[i])) continue;
        for (k = 0; k < 3; k++) assert_true(fabsf(q[i].material.diffuse[k] - (float)color[i][k] / 510) < 1e-6f);
        assert_true(fabsf(q[i].material.metallic - (float)gloss[i][2] / 255) < 1e-6f);
        assert_true(fabsf(q[i].material.roughness - (float)gloss[i][1] / 255) < 1e-6f);
        assert_true(fabsf(q[i].occlusion - 1 + (float)open[i] / 255) < 1e-5f);
        assert_true(q[i].entity == entity[i] && q[i].plane == 9 && apart(q[i].geometric_normal, p[i].normal) < 5e-5f);
    }
    in.color_map = in.gloss_map = in.open_map = in.entities = NULL;     /* and what holds without them */
    in.entity = 77;
    in.occlusion = 0.5f;
    assert_glbk(t, glbk_gbuffer_import(&t->gl, &g, &in));
    assert_glbk(t, glbk_gbuffer_read(&t->gl, &g, 0, 1, q));
    assert_true(q[0].entity == 77 && fabsf(q[0].occlusion - 0.5f) < 1e-5f && q[0].material.diffuse[0] == 0.5f);
    glbk_texture_free(&t->gl, &places);
    glbk_texture_free(&t->gl, &normals);
    glbk_texture_free(&t->gl, &color_map);
    glbk_texture_free(&t->gl, &gloss_map);
    glbk_texture_free(&t->gl, &open_map);
    glbk_texture_free(&t->gl, &entities);
    glbk_gbuffer_free(&t->gl, &g);
}

/* ---- a shader of the user's; errors; state ---- */

static void a_shader_of_the_users_reads_the_gbuffer(void **state)
{
    GL_TEST(t, state)
    static const char text[] =
        "layout(location = 0) out glbk_color result;\n"
        "void main()\n"
        "{\n"
        "    glbk_point p;\n"
        "    bool seen = glbk_read_point(ivec2(gl_FragCoord.xy), p);\n"
        "    result = glbk_pack(seen ? vec4(p.position, float(p.entity) + p.occlusion) : vec4(-1.0));\n"
        "}\n";
    static glbk_pixel p[PIXELS];
    static float picture[PIXELS][4];
    glbk_gbuffer g = make_gbuffer(t, NULL);
    gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_COLOR, W, H, 0);
    glbk_source source;
    glbk_program program;
    glbk_pass pass;
    int i;
    memset(&source, 0, sizeof source);
    memset(&pass, 0, sizeof pass);
    source.fragment = text;
    source.parts[0] = glbk_gbuffer_part();
    source.uses = "gbuffer";
    assert_glbk(t, glbk_program_compile(&t->gl, &source, &program));
    draw_scene(t, &g, usual, p);
    pass.target = &c.target;
    assert_glbk(t, glbk_begin(&t->gl, &pass, &program));
    assert_glbk(t, glbk_gbuffer_bind(&t->gl, &g, NULL));
    glbk_draw_screen(&t->gl);
    assert_glbk(t, glbk_target_read(&t->gl, &c.target, 0, 0, 0, W, H, picture[0]));
    for (i = 0; i < PIXELS; i++) {
        assert_true(is_seen(&p[i]) ? apart(picture[i], p[i].position) == 0 : picture[i][3] == -1);
        if (p[i].entity == 1) assert_true(picture[i][3] == 1);
    }
    glbk_program_free(&t->gl, &program);
    gl_canvas_free(t, &c);
    glbk_gbuffer_free(&t->gl, &g);
}

static void bad_arguments_of_a_gbuffer_are_refused(void **state)
{
    GL_TEST(t, state)
    static glbk_pixel p[PIXELS];
    glbk_gbuffer g = make_gbuffer(t, NULL), none, h;
    glbk_texture places = gl_texture(t, GLBK_FORMAT_RGBA32F, W, H, NULL);
    glbk_texture small = gl_texture(t, GLBK_FORMAT_RGBA32F, W, H - 1, NULL);
    glbk_gbuffer_desc d;
    glbk_surface s = floor_surface();
    glbk_import in;
    float clip[16];
    memset(&none, 0, sizeof none);
    memset(&d, 0, sizeof d);
    make_view(GLBK_CLIP_DEPTH_DEFAULT, clip);
    REFUSED(glbk_gbuffer_create(&t->gl, NULL, &h));
    REFUSED(glbk_gbuffer_create(NULL, &d, &h));
    ERROR_IS(GLBK_ERR_DESC, glbk_gbuffer_create(&t->gl, &d, &h));                           /* no size */
    d.width = W;
    d.height = H;
    REFUSED(glbk_gbuffer_create(&t->gl, &d, NULL));
    d.attributes.position = -1;
    d.attributes.normal = 1;
    ERROR_IS(GLBK_ERR_DESC, glbk_gbuffer_create(&t->gl, &d, &h));
    assert_string_equal(t->log, "glbk_gbuffer_create: desc.attributes.position is -1; it must be 0..15");
    d.attributes.position = 1;
    ERROR_IS(GLBK_ERR_DESC, glbk_gbuffer_create(&t->gl, &d, &h));                           /* one location twice */
    d.attributes.position = 16;
    ERROR_IS(GLBK_ERR_DESC, glbk_gbuffer_create(&t->gl, &d, &h));
    d.attributes.position = d.attributes.normal = 0;
    d.depth = &small;
    ERROR_IS(GLBK_ERR_MISMATCH, glbk_gbuffer_create(&t->gl, &d, &h));
    d.depth = &places;                                                      /* no depth format */
    ERROR_IS(GLBK_ERR_MISMATCH, glbk_gbuffer_create(&t->gl, &d, &h));
    d.depth = NULL;
    d.height = t->gl.max_side + 1;
    ERROR_IS(GLBK_ERR_LIMIT, glbk_gbuffer_create(&t->gl, &d, &h));
    assert_int_equal(h.words[0].name, 0);

    ERROR_IS(GLBK_ERR_ORDER, glbk_gbuffer_object(&t->gl, &g, &s));          /* before begin */
    REFUSED(glbk_gbuffer_begin(&t->gl, &g, NULL, eye));
    REFUSED(glbk_gbuffer_begin(&t->gl, &none, clip, eye));
    REFUSED(glbk_gbuffer_begin(&t->gl, &g, clip, NULL));
    REFUSED(glbk_gbuffer_begin(&t->gl, NULL, clip, eye));
    assert_string_equal(t->log, "glbk_gbuffer_begin: gbuffer is NULL");
    assert_glbk(t, glbk_gbuffer_begin(&t->gl, &g, clip, eye));
    s.plane = 256;
    ERROR_IS(GLBK_ERR_DESC, glbk_gbuffer_object(&t->gl, &g, &s));
    assert_string_equal(t->log, "glbk_gbuffer_object: plane is 256; it must be 0..255");
    s = floor_surface();
    s.occlusion = -0.1f;
    ERROR_IS(GLBK_ERR_DESC, glbk_gbuffer_object(&t->gl, &g, &s));
    s = floor_surface();
    s.material.kind = (lsamp_material_kind)LSAMP_MATERIAL_COUNT;
    ERROR_IS(GLBK_ERR_DESC, glbk_gbuffer_object(&t->gl, &g, &s));
    s = floor_surface();
    s.material.lobe_count = 9;
    ERROR_IS(GLBK_ERR_DESC, glbk_gbuffer_object(&t->gl, &g, &s));

    REFUSED(glbk_gbuffer_upload(&t->gl, &g, 0, H + 1, p));
    REFUSED(glbk_gbuffer_upload(&t->gl, &g, H, 1, p));
    REFUSED(glbk_gbuffer_upload(&t->gl, &g, 0, 1, NULL));
    REFUSED(glbk_gbuffer_read(&t->gl, &g, 0, 0, p));
    REFUSED(glbk_gbuffer_read(&t->gl, &none, 0, 1, p));
    REFUSED(glbk_gbuffer_bind(&t->gl, &none, NULL));

    memset(&in, 0, sizeof in);
    REFUSED(glbk_gbuffer_import(&t->gl, &g, NULL));
    ERROR_IS(GLBK_ERR_DESC, glbk_gbuffer_import(&t->gl, &g, &in));
    in.normals = &places;
    ERROR_IS(GLBK_ERR_DESC, glbk_gbuffer_import(&t->gl, &g, &in));                          /* no places */
    in.depth = &places;
    ERROR_IS(GLBK_ERR_DESC, glbk_gbuffer_import(&t->gl, &g, &in));                          /* no matrix */
    in.world_to_clip[0] = 1;
    ERROR_IS(GLBK_ERR_DESC, glbk_gbuffer_import(&t->gl, &g, &in));                          /* one without an inverse */
    memcpy(in.world_to_clip, clip, sizeof clip);
    in.color_map = &small;
    ERROR_IS(GLBK_ERR_MISMATCH, glbk_gbuffer_import(&t->gl, &g, &in));
    assert_string_equal(t->log, "glbk_gbuffer_import: import.color_map has not the height of the G-buffer");
    in.color_map = NULL;
    in.normal_packing = GLBK_NORMAL_PACKING_COUNT;
    ERROR_IS(GLBK_ERR_DESC, glbk_gbuffer_import(&t->gl, &g, &in));
    in.normal_packing = GLBK_NORMAL_PACKING_DEFAULT;
    in.clip_depth = GLBK_CLIP_DEPTH_COUNT;
    ERROR_IS(GLBK_ERR_DESC, glbk_gbuffer_import(&t->gl, &g, &in));
    glbk_texture_free(&t->gl, &places);
    glbk_texture_free(&t->gl, &small);
    glbk_gbuffer_free(&t->gl, &g);
}

static void state_is_left_or_put_back(void **state)
{
    GL_TEST(t, state)
    static glbk_pixel p[PIXELS];
    static const float matrix[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    glbk_gbuffer_desc d;
    glbk_gbuffer g;
    glbk_surface s = floor_surface();
    glbk_import in;
    glbk_texture places = gl_texture(t, GLBK_FORMAT_RGBA32F, W, H, NULL);
    gl_hostile h;
    memset(&d, 0, sizeof d);
    memset(&in, 0, sizeof in);
    d.width = W;
    d.height = H;
    in.positions = in.normals = &places;
    gl_state_watch(t, 1);
    gl_hostile_make(t, &h);
    gl_hostile_set(t, &h);
    GL_SAME(t, assert_glbk(t, glbk_gbuffer_create(&t->gl, &d, &g)));
    GL_SAME(t, assert_glbk(t, glbk_gbuffer_upload(&t->gl, &g, 0, H, p)));
    GL_SAME(t, assert_glbk(t, glbk_gbuffer_read(&t->gl, &g, 0, H, p)));
    GL_SAVED(t, assert_glbk(t, glbk_gbuffer_begin(&t->gl, &g, matrix, eye)));
    GL_SAVED(t, assert_glbk(t, glbk_gbuffer_object(&t->gl, &g, &s)));
    GL_SAVED(t, assert_glbk(t, glbk_gbuffer_import(&t->gl, &g, &in)));
    GL_SAVED(t, assert_glbk(t, glbk_gbuffer_bind(&t->gl, &g, NULL)));
    GL_SAME(t, glbk_gbuffer_free(&t->gl, &g));
    gl_state_watch(t, 0);
    gl_hostile_free(t, &h);
    glbk_texture_free(&t->gl, &places);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = { gl_unit_test(what_is_drawn_is_what_the_geometry_says),
                                  gl_unit_test(a_new_one_is_empty),
                                  gl_unit_test(attributes_are_where_the_desc_says),
                                  gl_unit_test(maps_holes_and_lobes_are_drawn),
                                  gl_unit_test(every_packing_of_normals_is_imported),
                                  gl_unit_test(every_convention_of_depth_is_imported),
                                  gl_unit_test(its_depth_is_that_of_the_import),
                                  gl_unit_test(a_depth_texture_of_the_users_is_drawn_with_and_left_alone),
                                  gl_unit_test(colours_gloss_openness_and_entities_are_imported),
                                  gl_unit_test(a_shader_of_the_users_reads_the_gbuffer),
                                  gl_unit_test(bad_arguments_of_a_gbuffer_are_refused),
                                  gl_unit_test(state_is_left_or_put_back) };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_USUAL);
}
