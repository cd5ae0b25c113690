/* gl_twin_test - envshadow.h's light on OpenGL: shadow maps beside those of its own rasteriser, the GLSL beside its C
   twin, clusters, pages, channels, closed forms, users' shaders, errors and state. */
#define _POSIX_C_SOURCE 200809L
#include "envlights.h"
#include "envshadow.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend/gl_envshadow.h"

#define CONFORM_BACKEND "gl"
#include "conformance.h"
#include "gl_test.h"
#include "gl_fake.h"
#include "gl_state.h"
#include "util.h"

enum { WIDE = 32, HIGH = 24, POINTS = WIDE * HIGH };

static const float identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };

/* Boxes, a leaning plate, and a ground far beyond the bounds that the maps are fitted to. */
static soup things;

static void make_things(void)
{
    static const double g[3] = { -50, 0, -50 }, gu[3] = { 0, 0, 100 }, gv[3] = { 100, 0, 0 };
    static const double p[3] = { -1, 0.2, 1 }, pu[3] = { 1.2, 0.5, 0 }, pv[3] = { 0, 1.1, 0.7 };
    uint64_t seed = 3;
    int i, c;
    things.vertices = 0;
    for (i = 0; i < 9; i++) {
        double low[3], high[3];
        for (c = 0; c < 3; c++) {
            low[c] = 2.6 * rnd(&seed) - 1.5;
            high[c] = low[c] + 0.1 + 0.4 * rnd(&seed);
        }
        low[1] = 0.02 + 0.3 * fabs(low[1]);
        high[1] = low[1] + 0.5;
        soup_box(&things, low, high);
    }
    soup_quad(&things, p, pu, pv);
    soup_quad(&things, g, gu, gv);
}

static const envsh_bounds bounds = { { -1.6f, 0, -1.6f }, { 1.6f, 1.3f, 1.8f } };

/* Lights and matrices, the header's own maps, and a vertex array. */
typedef struct rig {
    envlt_lights      *lights;
    const envlt_light *list;
    envsh_maps        *layout, *maps;
    const envsh_view  *views;
    uint32_t           count, size, vertex_array, buffer;
} rig;

static void upload_soup(gl_test *t, const soup *s, uint32_t *vertex_array, uint32_t *buffer)
{
    t->gl.gl.GenVertexArrays(1, vertex_array);
    t->gl.gl.GenBuffers(1, buffer);
    t->gl.gl.BindVertexArray(*vertex_array);
    t->gl.gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, *buffer);
    t->gl.gl.BufferData(GLBK_GL_ARRAY_BUFFER, (ptrdiff_t)(12 * s->vertices), s->p, GLBK_GL_STATIC_DRAW);
    t->gl.gl.EnableVertexAttribArray(0);
    t->gl.gl.VertexAttribPointer(0, 3, GLBK_GL_FLOAT, 0, 0, NULL);
    t->gl.gl.BindVertexArray(0);
}

static rig make_rig(gl_test *t, sky_fn fn, uint32_t k, uint32_t size)
{
    envlt_desc d = desc_of(ENVLT_METHOD_VARIANCE, k);
    envsh_maps_desc md;
    sky s = sky_alloc(ENVLT_PROJECTION_LATLONG, 64, 32);
    envsh_mesh mesh;
    rig r;
    memset(&r, 0, sizeof r);
    memset(&md, 0, sizeof md);
    sky_fill(&s, fn);
    assert_int_equal(envlt_create(&d, &s.map, &r.lights, NULL), ENVLT_OK);
    sky_free(&s);
    r.list = envlt_get_lights(r.lights, &r.count);
    r.size = md.map_side = size;
    assert_int_equal(envsh_maps_create(&md, r.count, &r.maps), ENVSH_OK);
    md.no_depth = 1;
    assert_int_equal(envsh_maps_create(&md, r.count, &r.layout), ENVSH_OK);
    assert_int_equal(envsh_maps_begin(r.layout, AS_LIGHTS(r.list, r.count), bounds), ENVSH_OK);
    assert_int_equal(envsh_maps_begin(r.maps, AS_LIGHTS(r.list, r.count), bounds), ENVSH_OK);
    r.views = envsh_views(r.layout, NULL);
    make_things();
    mesh = soup_mesh(&things);
    assert_int_equal(envsh_maps_draw(r.maps, &mesh, NULL), ENVSH_OK);
    assert_int_equal(envsh_maps_end(r.maps), ENVSH_OK);
    upload_soup(t, &things, &r.vertex_array, &r.buffer);
    return r;
}

static void free_rig(gl_test *t, rig *r)
{
    envsh_maps_free(r->maps);
    envsh_maps_free(r->layout);
    envlt_free(r->lights);
    t->gl.gl.DeleteVertexArrays(1, &r->vertex_array);
    t->gl.gl.DeleteBuffers(1, &r->buffer);
}

static glbk_result draw_things(void *user, glbk_context *ctx, glbk_envsh_maps *maps, uint32_t instances)
{
    const rig *r = (const rig *)user;
    glbk_result result = glbk_envsh_cast(ctx, maps, NULL);
    ctx->gl.BindVertexArray(r->vertex_array);
    ctx->gl.DrawArraysInstanced(GLBK_GL_TRIANGLES, 0, (int32_t)things.vertices, (int32_t)instances);
    return result;
}

static glbk_envsh_maps make_maps(gl_test *t, uint32_t capacity, uint32_t size, int rgba)
{
    glbk_envsh_maps_desc d;
    glbk_envsh_maps m;
    memset(&d, 0, sizeof d);
    d.capacity = capacity;
    d.maps = &(envsh_maps_desc){ .map_side = size, .rgba = rgba };
    assert_glbk(t, glbk_envsh_maps_create(&t->gl, &d, &m));
    return m;
}

static void render_maps(gl_test *t, glbk_envsh_maps *m, rig *r)
{
    assert_glbk(t, glbk_envsh_maps_render(&t->gl, m, r->views, r->count, draw_things, r));
}

/* A program of ours that uses the library's functions, over a COLOR target; the draw reads back. */
typedef struct tool { glbk_program program; gl_canvas canvas; glbk_buffer block; } tool;

static tool make_tool(gl_test *t, const char *text, const char *uses, const char *defines, uint32_t wide, uint32_t high)
{
    tool x;
    glbk_source source;
    memset(&source, 0, sizeof source);
    source.fragment = text;
    source.parts[0] = glbk_envsh_part();
    source.uses = uses;
    source.defines = defines;
    assert_glbk(t, glbk_program_compile(&t->gl, &source, &x.program));
    x.canvas = gl_canvas_make(t, GLBK_FORMAT_COLOR, wide, high, 0);
    assert_glbk(t, glbk_buffer_create(&t->gl, sizeof(glbk_envsh_object), NULL, &x.block));
    return x;
}

static void run_tool(gl_test *t, tool *x, glbk_envsh_maps *m, const envsh_query *q, uint32_t light, float *out)
{
    glbk_envsh_object object;
    glbk_pass pass;
    memset(&object, 0, sizeof object);
    memset(&pass, 0, sizeof pass);
    object.first_light = light;
    pass.target = &x->canvas.target;
    assert_glbk(t, glbk_buffer_update(&t->gl, &x->block, 0, sizeof object, &object));
    assert_glbk(t, glbk_begin(&t->gl, &pass, &x->program));
    assert_glbk(t, glbk_envsh_bind(&t->gl, m, q, NULL));
    glbk_bind_block(&t->gl, GLBK_SLOT_glbk_envsh_object, &x->block);
    glbk_draw_screen(&t->gl);
    assert_glbk(t, glbk_target_read(&t->gl, &x->canvas.target, 0, 0, 0, pass.target->width, pass.target->height, out));
}

static void free_tool(gl_test *t, tool *x)
{
    glbk_program_free(&t->gl, &x->program);
    glbk_buffer_free(&t->gl, &x->block);
    gl_canvas_free(t, &x->canvas);
}

static const envsh_query plain = { ENVSH_FILTER_PLAIN, 0, 0, 1, 0, 0, 0 };
static const char tile_text[] =
    "layout(location = 0) out glbk_color result;\n"
    "void main()\n"
    "{\n"
    "    uint light = glbk_envsh_object.first_light;\n"
    "    result = glbk_pack(vec4(envsh_stored(light, ENVSH_TEXEL(8u * light + 6u).w, ivec2(gl_FragCoord.xy))));\n"
    "}\n";

/* One light's tile as the GPU has it. */
static void read_tile(gl_test *t, tool *x, glbk_envsh_maps *m, uint32_t light, float *depth)
{
    static float rgba[4 * 352 * 352];
    size_t i;
    run_tool(t, x, m, &plain, light, rgba);
    for (i = 0; i < (size_t)m->map_side * m->map_side; i++) depth[i] = rgba[4 * i];
}

/* ---- shadow maps ---- */

/* Texels of a tile that differ by more than rounding; counts those that something covers. A GPU's depths come from
   corners in floats, here up to thirty ranges away, and grow where a triangle is seen from its edge: a hundredth of a
   texel's depth, and in proportion on coarser grids of corners. */
static size_t compare_tile(const envsh_info *atlas, const envsh_view *v, const float *depth, float coarse,
                           size_t *covered)
{
    uint32_t n = atlas->map_side, x, y;
    size_t wrong = 0;
    for (y = 0; y < n; y++)
        for (x = 0; x < n; x++) {
            float wanted = atlas->depth[((size_t)v->page * atlas->height + v->y + y) * atlas->width + v->x + x];
            float seen = depth[n * y + x];
            if (x < 4 || y < 4 || x >= n - 4 || y >= n - 4) assert_true(seen == 1.0f);      /* the guard */
            wrong += fabsf(wanted - seen) > 1e-4f * coarse;
            *covered += wanted < 1.0f;
        }
    return wrong;
}

static void tiles_are_those_of_the_rasteriser(void **state)
{
    GL_TEST(t, state)
    static const struct { uint32_t lights, size, pages; int rgba; } ways[] = { { 24, 96, 1, 0 }, { 24, 96, 1, 1 },
                                                                               { 6, 352, 2, 0 }, { 17, 352, 2, 1 } };
    static float depth[352 * 352];
    const float coarse = 256.0f / (float)gl_corner_grid(t);
    uint32_t max_size = t->gl.max_side, i;
    size_t way;
    for (way = 0; way < 4; way++) {
        rig r = make_rig(t, sunny, ways[way].lights, ways[way].size);
        size_t covered = 0, wrong = 0, all = (size_t)r.count * r.size * r.size;
        envsh_info atlas;
        glbk_envsh_maps m;
        tool reader;
        envsh_get_info(r.maps, &atlas);
        t->gl.max_side = 1024;              /* four large tiles a page */
        m = make_maps(t, r.count, r.size, ways[way].rgba);
        t->gl.max_side = max_size;
        assert_int_equal(m.page_count, ways[way].pages);
        reader =
            make_tool(t, tile_text, "envsh_access", ways[way].rgba ? "ENVSH_RGBA=1" : "ENVSH_RGBA=0", r.size, r.size);
        render_maps(t, &m, &r);
        for (i = 0; i < r.count; i++) {
            read_tile(t, &reader, &m, i, depth);
            wrong += compare_tile(&atlas, &envsh_views(r.maps, NULL)[i], depth, coarse, &covered);
        }
        printf("%u tiles%s: %zu of %zu texels covered, %zu differ\n", (unsigned)r.count,
               ways[way].rgba ? " in rgba" : "", covered, all, wrong);
        assert_true(covered > all / 4 && covered < all - all / 10);
        assert_true((double)wrong < (double)covered / 500 * (double)coarse);     /* edges */
        free_tool(t, &reader);
        glbk_envsh_maps_free(&t->gl, &m);
        free_rig(t, &r);
    }
}

/* ---- the GLSL and its twin ---- */

static const char ask_text[] =
    "uniform highp usampler2DArray asked;\n"
    "layout(location = 0) out glbk_color result;\n"
    "void main()\n"
    "{\n"
    "    uint index = uint(gl_FragCoord.y) * 32u + uint(gl_FragCoord.x);\n"
    "    vec3 p = uintBitsToFloat(texelFetch(asked, glbk_table_at(2u * index), 0).xyz);\n"
    "    vec3 n = uintBitsToFloat(texelFetch(asked, glbk_table_at(2u * index + 1u), 0).xyz);\n"
    "    result = glbk_pack(vec4(envsh_visible(envsh_bound_query(), glbk_envsh_object.first_light, p, n, index)));\n"
    "}\n";

typedef struct asked { float point[4], normal[4]; } asked;

/* Points on the things' triangles and about them. */
static void make_points(asked *a)
{
    uint64_t seed = 17;
    size_t i, c;
    for (i = 0; i < POINTS; i++) {
        const float *v = things.p + 9 * (size_t)(rnd(&seed) * (double)(things.vertices / 3 - 2));
        double s = rnd(&seed), w = rnd(&seed) * (1 - s), d[3];
        rnd_direction(&seed, d);
        memset(&a[i], 0, sizeof a[i]);
        for (c = 0; c < 3; c++) {
            a[i].point[c] = (float)((double)v[c] * (1 - s - w) + (double)v[3 + c] * s + (double)v[6 + c] * w);
            if (i % 3 == 0) a[i].point[c] = (float)(3.6 * rnd(&seed) - 1.8);
            a[i].normal[c] = (float)d[c];
        }
    }
}

static void visibility_is_the_twins(void **state)
{
    GL_TEST(t, state)
    static const envsh_query questions[] = {
        { ENVSH_FILTER_PLAIN, 0, 0, 1, 0, 1, 0 },        { ENVSH_FILTER_SMOOTH, 0, 2.5f, 1, 0, 1, 0 },
        { ENVSH_FILTER_PCF, 16, 3, 0.5f, 0, 5, 0 },      { ENVSH_FILTER_PENUMBRA, 16, 12, 1, 1, 9, 0 },
        { ENVSH_FILTER_PENUMBRA, 64, 40, -1, 2.5f, 2, 0 }
    };
    static asked points[POINTS];
    static float seen[4 * POINTS], depth[96 * 96];
    rig r = make_rig(t, studio, 12, 96);
    glbk_envsh_maps m = make_maps(t, r.count, 96, 1);
    glbk_texture table;
    tool reader = make_tool(t, tile_text, "envsh_access", "ENVSH_RGBA=1", 96, 96);
    size_t q, i, total = 0, dark = 0, between = 0, wrong = 0;
    uint32_t light;
    double worst = 0;

    make_points(points);
    assert_glbk(t, glbk__table_create(&t->gl, GLBK_FORMAT_RGBA32UI, points, 2 * POINTS, &table));
    render_maps(t, &m, &r);
    for (q = 0; q < sizeof questions / sizeof questions[0]; q++) {
        char defines[] = "ENVSH_RGBA=1 ENVSH_FILTER=0";
        const envsh_query query = questions[q];
        tool ask;
        defines[26] = (char)('0' + (int)questions[q].filter);
        ask = make_tool(t, ask_text, "envsh_light", defines, WIDE, HIGH);
        t->gl.gl.UseProgram(ask.program.name);
        t->gl.gl.Uniform1i(t->gl.gl.GetUniformLocation(ask.program.name, "asked"), 15);
        t->gl.gl.ActiveTexture(GLBK_GL_TEXTURE0 + 15);
        t->gl.gl.BindTexture(table.gl_target, table.name);
        for (light = 0; light < r.count; light++) {
            read_tile(t, &reader, &m, light, depth);
            run_tool(t, &ask, &m, &questions[q], light, seen);
            for (i = 0; i < POINTS; i++) {
                const envsh_tile tile = { &r.views[light], depth, 4 * 96, 4, 96 };
                float wanted = envsh_visibility_twin(&tile, &query, points[i].point, points[i].normal, (uint32_t)i);
                double off = fabs((double)wanted - (double)seen[4 * i]);
                if (off > 1e-4) wrong++;
                else if (off > worst) worst = off;
                dark += wanted == 0;
                between += wanted > 0 && wanted < 1;
            }
            total += POINTS;
        }
        free_tool(t, &ask);
    }
    printf("%zu questions: %zu dark, %zu between, %zu differ, worst of the rest %.1e\n", total, dark, between, wrong,
           worst);
    assert_true(dark > total / 10 && between > total / 50);
    assert_true(wrong < total / 1000);      /* at the borders of texels and depths */
    glbk_texture_free(&t->gl, &table);
    free_tool(t, &reader);
    glbk_envsh_maps_free(&t->gl, &m);
    free_rig(t, &r);
}

/* ---- light ---- */

/* What is lit, and where the light is summed. */
typedef struct lit_view { glbk_gbuffer seen; glbk_envsh_renderer r; } lit_view;

static lit_view make_view(gl_test *t, glbk_context *ctx, uint32_t wide, uint32_t high)
{
    glbk_gbuffer_desc d;
    lit_view v;
    memset(&d, 0, sizeof d);
    d.width = wide;
    d.height = high;
    assert_glbk(t, glbk_gbuffer_create(ctx, &d, &v.seen));
    assert_glbk(t, glbk_envsh_renderer_create(ctx, &(glbk_envsh_renderer_desc){ wide, high }, &v.r));
    return v;
}

static void free_view(glbk_context *ctx, lit_view *v)
{
    glbk_gbuffer_free(ctx, &v->seen);
    glbk_envsh_renderer_free(ctx, &v->r);
}

static lit_view make_renderer(gl_test *t, const asked *points)
{
    static glbk_pixel pixels[POINTS];
    lit_view v = make_view(t, &t->gl, WIDE, HIGH);
    size_t i;
    for (i = 0; i < POINTS; i++) {
        memset(&pixels[i], 0, sizeof pixels[i]);
        memcpy(pixels[i].position, points[i].point, 12);
        if (i % 7) memcpy(pixels[i].normal, points[i].normal, 12);
        pixels[i].material.diffuse[0] = pixels[i].material.diffuse[1] = pixels[i].material.diffuse[2] = 0.5f;
    }
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, &v.seen, 0, 4, pixels));
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, &v.seen, 4, HIGH - 4, pixels + 4 * WIDE));
    return v;
}

static glbk_envsh_frame frame_of(rig *r, uint32_t count, const envsh_query *query)
{
    glbk_envsh_frame f;
    f.views = r->views;
    f.view_count = count;
    f.draw_fn = draw_things;
    f.user = r;
    f.query = query;
    return f;
}

static envsh_query adding(envsh_query q)
{
    q.add = 1;
    return q;
}

static const envsh_query soft = { ENVSH_FILTER_PENUMBRA, 16, 12, 1, 1, 9, 0 };

static void illuminate(gl_test *t, lit_view *to, glbk_envsh_maps *m, rig *r, float *out)
{
    const glbk_envsh_frame frame = frame_of(r, r->count, &soft);
    assert_glbk(t, glbk_envsh_illuminate(&t->gl, &to->r, &to->seen, m, &frame));
    assert_glbk(t, glbk_envsh_read(&t->gl, &to->r, out));
}

/* Algorithms 1 and 2, channels, lights a pass: one picture; and it is envsh_shade's. */
static void clusters_make_the_same_light(void **state)
{
    GL_TEST(t, state)
    static asked points[POINTS];
    static float all[4 * POINTS], part[4 * POINTS], wanted[3 * POINTS];
    rig r = make_rig(t, sunny, 24, 64);
    lit_view to;
    const envsh_query more = adding(soft);
    envsh_query query = { 0 };
    envsh_points places = { 0 };
    double square = 0, mean = 0;
    size_t i, c;
    int way;

    make_points(points);
    to = make_renderer(t, points);
    places.positions = points[0].point;
    places.normals = points[0].normal;
    places.position_stride = places.normal_stride = sizeof points[0];
    places.count = POINTS;
    query.seed = soft.seed;
    assert_int_equal(envsh_shade(r.maps, &query, &places, wanted), ENVSH_OK);
    for (way = 0; way < 4; way++) {
        glbk_envsh_maps m = make_maps(t, way == 0 ? r.count : way == 1 ? 5 : 9, 64, way == 2);
        if (way == 3) {                     /* the maps of the first nine, three a pass, then all again */
            assert_glbk(t, glbk_envsh_maps_render(&t->gl, &m, r.views, 9, draw_things, &r));
            assert_glbk(t, glbk_envsh_shade(&t->gl, &to.r, &to.seen, &m, &soft, 3));
            assert_glbk(t, glbk_envsh_maps_render(&t->gl, &m, r.views + 9, 9, draw_things, &r));
            assert_glbk(t, glbk_envsh_shade(&t->gl, &to.r, &to.seen, &m, &more, 4));
            assert_glbk(t, glbk_envsh_maps_render(&t->gl, &m, r.views + 18, 6, draw_things, &r));
            assert_glbk(t, glbk_envsh_shade(&t->gl, &to.r, &to.seen, &m, &more, 6));
            assert_glbk(t, glbk_envsh_read(&t->gl, &to.r, part));
        } else {
            illuminate(t, &to, &m, &r, way ? part : all);
        }
        for (i = 0; way && i < 4 * POINTS; i++) CLOSE(part[i], all[i], 2e-6 * (1 + fabs((double)all[i])));
        glbk_envsh_maps_free(&t->gl, &m);
    }
    for (i = 0; i < POINTS; i++)
        for (c = 0; c < 3; c++) {
            double w = i % 7 ? (double)wanted[3 * i + c] : 0, off = w - (double)all[4 * i + c];
            square += off * off;
            mean += w;
        }
    square = sqrt(square / (3 * POINTS)) / (mean / (3 * POINTS));
    printf("light: relative rmse %.1e of envsh_shade\n", square);
    assert_true(mean > POINTS && square < 2e-3 * 256 / gl_corner_grid(t));
    free_view(&t->gl, &to);
    free_rig(t, &r);
}

/* T23: an even sky gives pi in the open, nothing under a roof that nothing passes. */
static void open_ground_is_lit_and_a_roof_dark(void **state)
{
    GL_TEST(t, state)
    static asked points[POINTS];
    static float seen[4 * POINTS];
    static const double a[3] = { -40, 1.2, -40 }, u[3] = { 80, 0, 0 }, v[3] = { 0, 0, 80 };
    rig r = make_rig(t, even, 128, 64);
    glbk_envsh_maps m = make_maps(t, r.count, 64, 0);
    lit_view to;
    size_t i;
    int roofed;
    for (i = 0; i < POINTS; i++) {
        memset(&points[i], 0, sizeof points[i]);
        points[i].point[0] = (float)(i % WIDE) / 16 - 1;
        points[i].point[1] = 0.4f;
        points[i].point[2] = (float)(i / WIDE) / 12 - 1;
        points[i].normal[1] = 1;
    }
    to = make_renderer(t, points);
    for (roofed = 0; roofed < 2; roofed++) {
        things.vertices = 0;
        if (roofed) soup_quad(&things, a, u, v);
        t->gl.gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, r.buffer);
        t->gl.gl.BufferData(GLBK_GL_ARRAY_BUFFER, (ptrdiff_t)(12 * things.vertices), things.p, GLBK_GL_STATIC_DRAW);
        illuminate(t, &to, &m, &r, seen);
        for (i = 0; i < POINTS; i++)
            if (i % 7) assert_true(seen[4 * i] == seen[4]);
        if (roofed) CONFORM_MAX("T23", "irradiance under an infinite roof", 0, seen[4]);
        /* A light of radius a stands for cosines that are smaller by a^2 / 4 on average: 0.8 % at 128. */
        else CONFORM("T23", "irradiance under a uniform sky, 128 lights", PI, seen[4], 0.01 * PI);
    }
    assert_true(seen[0] == 0);              /* nothing is seen there */
    free_view(&t->gl, &to);
    glbk_envsh_maps_free(&t->gl, &m);
    free_rig(t, &r);
}

/* Points inside a box with walls of 16 texels see nothing of a sun of 2,000 W/(sr m^2). */
static void a_sealed_box_is_dark(void **state)
{
    GL_TEST(t, state)
    static asked points[POINTS];
    static float seen[4 * POINTS];
    static const double outer[2][3] = { { -1.5, 0, -1.5 }, { 1.5, 1.2, 1.6 } };
    static const double inner[2][3] = { { -1.1, 0.4, -1.1 }, { 1.1, 0.8, 1.2 } };
    rig r = make_rig(t, sunny, 64, 128);
    glbk_envsh_maps m = make_maps(t, r.count, 128, 0);
    lit_view to;
    double sum = 0;
    uint64_t seed = 5;
    size_t i, c;
    for (i = 0; i < POINTS; i++) {
        double d[3];
        rnd_direction(&seed, d);
        for (c = 0; c < 3; c++) {
            points[i].point[c] = (float)(inner[0][c] + (inner[1][c] - inner[0][c]) * rnd(&seed));
            points[i].normal[c] = (float)d[c];
        }
    }
    to = make_renderer(t, points);
    things.vertices = 0;
    soup_box(&things, outer[0], outer[1]);
    soup_box(&things, inner[0], inner[1]);
    t->gl.gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, r.buffer);
    t->gl.gl.BufferData(GLBK_GL_ARRAY_BUFFER, (ptrdiff_t)(12 * things.vertices), things.p, GLBK_GL_STATIC_DRAW);
    illuminate(t, &to, &m, &r, seen);
    for (i = 0; i < 4 * POINTS; i++) sum += (double)seen[i];
    CONFORM_MAX("image", "sealed box, mean light inside, penumbra", 0, sum / POINTS);
    free_view(&t->gl, &to);
    glbk_envsh_maps_free(&t->gl, &m);
    free_rig(t, &r);
}

/* Every second tile full or empty; what is asked of one stays when all the others change. */
static const char checker_vertex[] =
    "layout(location = 0) in vec3 at;\n"
    "uniform float job_light, job_flip;\n"
    "void glbk_vertex(out vec3 position, out vec3 normal, out vec2 uv, out vec4 tangent)\n"
    "{\n"
    "    uint light = glbk_envsh_object.first_light + glbk_envsh_object.light_step * uint(gl_InstanceID);\n"
    "    bool full = ((light & 1u) == 1u) != (job_flip > 0.0 && light != uint(job_light));\n"
    "    position = full ? at : vec3(0.0);\n"
    "    normal = vec3(0.0);\n"
    "    uv = vec2(0.0);\n"
    "    tangent = vec4(0.0);\n"
    "}\n";

typedef struct checker { const rig *r; float light, flip; } checker;

static glbk_result draw_checker(void *user, glbk_context *ctx, glbk_envsh_maps *maps, uint32_t instances)
{
    const checker *c = (const checker *)user;
    const glbk_result result = glbk_envsh_cast(ctx, maps, NULL);
    ctx->gl.Uniform1f(ctx->gl.GetUniformLocation(ctx->program, "job_light"), c->light);
    ctx->gl.Uniform1f(ctx->gl.GetUniformLocation(ctx->program, "job_flip"), c->flip);
    ctx->gl.BindVertexArray(c->r->vertex_array);
    ctx->gl.DrawArraysInstanced(GLBK_GL_TRIANGLES, 0, (int32_t)things.vertices, (int32_t)instances);
    return result;
}

static void tiles_do_not_bleed(void **state)
{
    GL_TEST(t, state)
    static const envsh_query wide = { ENVSH_FILTER_PCF, 16, 30, 1, 0, 1, 0 };
    static const double low[3] = { -40, -40, -40 }, high[3] = { 40, 40, 40 };
    static asked points[POINTS];
    static float seen[2][4 * POINTS];
    rig r = make_rig(t, even, 9, 64);
    checker c = { NULL, 0, 0 };
    double changed = 0;
    size_t dark = 0, i;
    uint32_t light;
    int rgba, flip;
    make_points(points);
    things.vertices = 0;
    soup_box(&things, low, high);
    t->gl.gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, r.buffer);
    t->gl.gl.BufferData(GLBK_GL_ARRAY_BUFFER, (ptrdiff_t)(12 * things.vertices), things.p, GLBK_GL_STATIC_DRAW);
    c.r = &r;
    for (rgba = 0; rgba < 2; rgba++) {
        const envsh_maps_desc layout = { .map_side = 64, .rgba = rgba };
        const glbk_envsh_maps_desc d = { r.count, &layout, { 0, 0, 0, 0, checker_vertex, NULL } };
        glbk_envsh_maps m;
        glbk_texture table;
        tool ask = make_tool(t, ask_text, "envsh_light",
                             rgba ? "ENVSH_RGBA=1 ENVSH_FILTER=3" : "ENVSH_RGBA=0 ENVSH_FILTER=3", WIDE, HIGH);
        assert_glbk(t, glbk_envsh_maps_create(&t->gl, &d, &m));
        assert_glbk(t, glbk__table_create(&t->gl, GLBK_FORMAT_RGBA32UI, points, 2 * POINTS, &table));
        t->gl.gl.UseProgram(ask.program.name);
        t->gl.gl.Uniform1i(t->gl.gl.GetUniformLocation(ask.program.name, "asked"), 15);
        for (light = 0; light < r.count; light++) {
            for (flip = 0; flip < 2; flip++) {
                c.light = (float)light;
                c.flip = (float)flip;
                assert_glbk(t, glbk_envsh_maps_render(&t->gl, &m, r.views, r.count, draw_checker, &c));
                t->gl.gl.ActiveTexture(GLBK_GL_TEXTURE0 + 15);
                t->gl.gl.BindTexture(table.gl_target, table.name);
                run_tool(t, &ask, &m, &wide, light, seen[flip]);
            }
            for (i = 0; i < 4 * POINTS; i++) {
                changed += fabs((double)seen[0][i] - (double)seen[1][i]);
                dark += seen[0][i] < 0.5f && (light & 1);
            }
        }
        glbk_texture_free(&t->gl, &table);
        glbk_envsh_maps_free(&t->gl, &m);
        free_tool(t, &ask);
    }
    assert_true(dark > POINTS);
    CONFORM_MAX("T24", "answers in a tile that change when its neighbours are rewritten", 0, changed);
    free_rig(t, &r);
}

/* ---- compute ---- */

enum { FILTERS = ENVSH_FILTER_COUNT - 1, PICTURE_WIDE = 77, PICTURE_HIGH = 53, PICTURE = PICTURE_WIDE * PICTURE_HIGH };

static const envsh_query questions_of_filters[] = { { ENVSH_FILTER_PLAIN, 0, 0, 1, 0, 1, 0 },
                                                            { ENVSH_FILTER_SMOOTH, 0, 2.5f, 1, 0, 1, 0 },
                                                            { ENVSH_FILTER_PCF, 16, 3, 0.5f, 0, 5, 0 },
                                                            { ENVSH_FILTER_PENUMBRA, 16, 6, 1, 1, 9, 0 } };

/* Two pieces of ground as seen from above, below a thick roof and beside it, where it casts no shadow itself; the last
   rows bend up into a wall, some pixels see nothing, eight columns not at all. Two renderers have it. */
static void make_picture(gl_test *t, glbk_context *core, const rig *r, lit_view out[2])
{
    static glbk_pixel pixels[PICTURE];
    static const double low[3] = { -1.6, 0.15, -1.6 }, high[3] = { 0, 0.9, 1.8 };
    uint32_t i;
    memset(pixels, 0, sizeof pixels);
    for (i = 0; i < PICTURE; i++) {
        glbk_pixel *p = &pixels[i];
        double x = i % PICTURE_WIDE, y = i / PICTURE_WIDE, wall = y > 40 ? (y - 40) / 12 : 0;
        double n[3] = { 0.1 * sin(x), cos(1.5 * wall), -sin(1.5 * wall) }, length = sqrt(1 + 0.01 * sin(x) * sin(x));
        p->position[0] = (float)(x / PICTURE_WIDE - (x < 32 ? 0.9 : -0.4));
        p->position[1] = (float)(wall * wall);
        p->position[2] = (float)(y / PICTURE_HIGH - 0.5);
        p->normal[0] = (float)(n[0] / length);
        p->normal[1] = (float)(n[1] / length);
        p->normal[2] = (float)(n[2] / length);
        p->geometric_normal[1] = (float)n[1];
        p->geometric_normal[2] = (float)n[2];
        if (i % 11 == 3 || x >= 69) memset(p->normal, 0, sizeof p->normal);     /* nothing is seen */
    }
    things.vertices = 0;
    soup_box(&things, low, high);
    t->gl.gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, r->buffer);
    t->gl.gl.BufferData(GLBK_GL_ARRAY_BUFFER, (ptrdiff_t)(12 * things.vertices), things.p, GLBK_GL_STATIC_DRAW);
    *core = t->gl;
    core->compute = 0;
    for (i = 0; i < 2; i++) {
        out[i] = make_view(t, i ? core : &t->gl, PICTURE_WIDE, PICTURE_HIGH);
        assert_int_equal(out[i].r.compute, !i);
        assert_glbk(t, glbk_gbuffer_upload(&t->gl, &out[i].seen, 0, PICTURE_HIGH, pixels));
    }
}

/* Every filter, one and four maps a texel; 150 lights in one go, in passes that do not end with a chunk of 64, in
   clusters that go on from a sum. The sums differ by their order alone. */
static void compute_is_the_core_path(void **state)
{
    GL_TEST(t, state)
    static float seen[2][4 * PICTURE];
    lit_view to[2];
    glbk_context core;
    rig r;
    double worst = 0;
    size_t lit = 0, differ = 0;
    int rgba, filter, way, i, k;
    if (!t->gl.compute) return;
    r = make_rig(t, sunny, 150, 64);
    assert_true(r.count > 128);
    make_picture(t, &core, &r, to);
    for (rgba = 0; rgba < 2; rgba++)
        for (way = 0; way < 3; way++) {
            glbk_envsh_maps m = make_maps(t, way == 2 ? 70 : r.count, 64, rgba);
            for (filter = 0; filter < FILTERS; filter++) {
                const envsh_query *q = &questions_of_filters[filter];
                const glbk_envsh_frame frame = frame_of(&r, r.count, q);
                if (way < 2) render_maps(t, &m, &r);
                for (k = 0; k < 2; k++) {
                    glbk_context *ctx = k ? &core : &t->gl;
                    if (way < 2) assert_glbk(t, glbk_envsh_shade(ctx, &to[k].r, &to[k].seen, &m, q, way ? 37 : 0));
                    else assert_glbk(t, glbk_envsh_illuminate(ctx, &to[k].r, &to[k].seen, &m, &frame));
                    assert_glbk(t, glbk_envsh_read(ctx, &to[k].r, seen[k]));
                }
                for (i = 0; i < 4 * PICTURE; i++) {
                    double off = fabs((double)seen[0][i] - (double)seen[1][i]), scale = fabs((double)seen[1][i]);
                    differ += off > 0;
                    lit += scale > 0;
                    if (off > worst * scale) worst = off / scale;
                    assert_true(scale > 0 || !(off > 0));
                }
            }
            glbk_envsh_maps_free(&t->gl, &m);
        }
    printf("compute beside fragments: %zu of %zu lit values differ, worst %.1e\n", differ, lit, worst);
    assert_true(lit > PICTURE && worst <= 2e-6);
    for (i = 0; i < 2; i++) free_view(&t->gl, &to[i]);
    free_rig(t, &r);
}

/* What is known of a group of 8 x 8 pixels is what envsh_visible answers for each. x: lights known to be lit, y: dark,
   z: to be asked for, of those that the ground faces; w: pixels that disagree. */
static const char group_text[] =
    "layout(local_size_x = 1) in;\n"
    "void main()\n"
    "{\n"
    "    ivec2 from = 8 * ivec2(gl_WorkGroupID.xy), to = min(from + 8, textureSize(glbk_gbuffer_place, 0));\n"
    "    envsh_group g = envsh_group(vec3(3e38), vec3(-3e38), vec3(3e38), vec3(-3e38), vec3(3e38), vec3(-3e38));\n"
    "    envsh_query q = envsh_bound_query();\n"
    "    vec4 counts = vec4(0.0);\n"
    "    for (uint round_of = 0u; round_of < 2u; round_of++)\n"
    "        for (int y = from.y; y < to.y; y++)\n"
    "            for (int x = from.x; x < to.x; x++) {\n"
    "                glbk_point point;\n"
    "                if (!glbk_read_point(ivec2(x, y), point)) continue;\n"
    "                vec3 p = point.position, n = point.normal, f = point.geometric;\n"
    "                if (round_of == 0u)\n"
    "                    g = envsh_group(min(g.low, p), max(g.high, p), min(g.n_low, n), max(g.n_high, n),\n"
    "                                    min(g.flat_low, f), max(g.flat_high, f));\n"
    "                for (uint i = 0u; round_of == 1u && i < glbk_envsh_scene.light_count; i++) {\n"
    "                    int known = envsh_group_visible(q, g, i);\n"
    "                    if (known < 0) continue;\n"
    "                    float wanted = dot(f, envsh_direction(i)) > 0.0 ? float(known) : 0.0;\n"
    "                    float seen = envsh_visible(q, i, p, f, uint(y * 77 + x));\n"
    "                    if (dot(n, envsh_direction(i)) > 0.0 && seen != wanted) counts.w += 1.0;\n"
    "                }\n"
    "            }\n"
    "    for (uint i = 0u; i < glbk_envsh_scene.light_count && g.low.x < 3e38; i++) {\n"
    "        int known = envsh_group_visible(q, g, i);\n"
    "        bool under = envsh_all_under(g.flat_low, g.flat_high, envsh_direction(i));\n"
    "        if (!under) counts[known > 0 ? 0 : known == 0 ? 1 : 2] += 1.0;\n"
    "    }\n"
    "    imageStore(glbk_envsh_total, ivec2(gl_WorkGroupID.xy), counts);\n"
    "}\n";

static void groups_know_what_their_pixels_see(void **state)
{
    GL_TEST(t, state)
    enum { ACROSS = (PICTURE_WIDE + 7) / 8, DOWN = (PICTURE_HIGH + 7) / 8 };
    static float counts[4 * ACROSS * DOWN];
    lit_view to[2];
    glbk_envsh_maps m;
    glbk_context core;
    gl_canvas canvas;
    rig r;
    int filter, i, c;
    if (!t->gl.compute) return;
    r = make_rig(t, sunny, 40, 128);
    make_picture(t, &core, &r, to);
    m = make_maps(t, r.count, 128, 1);
    render_maps(t, &m, &r);
    canvas = gl_canvas_make(t, GLBK_FORMAT_COLOR, ACROSS, DOWN, 0);
    for (filter = 0; filter < FILTERS; filter++) {
        char defines[] = "ENVSH_RGBA=1 ENVSH_FILTER=0";
        double sums[4] = { 0, 0, 0, 0 };
        glbk_source source;
        glbk_program program;
        memset(&source, 0, sizeof source);
        defines[26] = (char)('1' + filter);
        source.compute = group_text;
        source.parts[0] = glbk_envsh_part();
        source.parts[1] = glbk_gbuffer_part();
        source.uses = "envsh_light envsh_group gbuffer";
        source.defines = defines;
        assert_glbk(t, glbk_program_compile(&t->gl, &source, &program));
        assert_glbk(t, glbk_envsh_bind(&t->gl, &m, &questions_of_filters[filter], NULL));
        assert_glbk(t, glbk_gbuffer_bind(&t->gl, &to[0].seen, NULL));
        glbk_bind_image(&t->gl, GLBK_SLOT_glbk_envsh_total, &canvas.color);
        assert_glbk(t, glbk_dispatch(&t->gl, &program, ACROSS, DOWN, 1));
        assert_glbk(t, glbk_target_read(&t->gl, &canvas.target, 0, 0, 0, ACROSS, DOWN, counts));
        for (i = 0; i < ACROSS * DOWN; i++)
            for (c = 0; c < 4; c++) sums[c] += (double)counts[4 * i + c];
        printf("filter %d: groups know of %.0f lights that they are lit, of %.0f that they are dark, not of %.0f\n",
               filter, sums[0], sums[1], sums[2]);
        assert_true(sums[0] > 50 && sums[1] > 10 && sums[2] > 100 && sums[3] == 0);
        glbk_program_free(&t->gl, &program);
    }
    gl_canvas_free(t, &canvas);
    glbk_envsh_maps_free(&t->gl, &m);
    for (i = 0; i < 2; i++) free_view(&t->gl, &to[i]);
    free_rig(t, &r);
}

/* ---- users' shaders, the drawn G-buffer ---- */

static const char leaf_vertex[] =
    "layout(location = 0) in vec3 at;\n"
    "out vec3 place;\n"
    "void glbk_vertex(out vec3 position, out vec3 normal, out vec2 uv, out vec4 tangent)\n"
    "{\n"
    "    position = place = at;\n"
    "    normal = vec3(0.0);\n"
    "    uv = vec2(0.0);\n"
    "    tangent = vec4(0.0);\n"
    "}\n";
static const char leaf_fragment[] =
    "in vec3 place;\n"
    "bool glbk_fragment(vec2 uv, inout vec4 color) { return place.x <= 0.0; }\n";

/* A square over the ground of which a mask leaves the left half, lit from straight above; the picture is drawn. */
static void a_mask_of_the_users_lets_light_through_in_a_drawn_picture(void **state)
{
    GL_TEST(t, state)
    static const double a[3] = { -1, 1, -1 }, u[3] = { 2, 0, 0 }, v[3] = { 0, 0, 2 };
    static const double ga[3] = { -1, 0, 1 }, gu[3] = { 2, 0, 0 }, gv[3] = { 0, 0, -2 };
    static const float above_all[3] = { 0, 5, 0 };
    const envsh_bounds box = { { -1, 0, -1 }, { 1, 1, 1 } };
    rig r = make_rig(t, sunny, 1, 64);
    gl_canvas canvas = gl_canvas_make(t, GLBK_FORMAT_RGBA8, WIDE, HIGH, 0);
    int rgba;
    for (rgba = 0; rgba < 2; rgba++) {
        static float seen[4 * POINTS];
        glbk_envsh_maps_desc d;
        glbk_envsh_maps m;
        lit_view to;
        glbk_surface s;
        float clip[16] = { 0 };
        glbk_pass pass;
        envlt_light above;
        uint32_t y, x, array, buffer;
        memset(&d, 0, sizeof d);
        memset(&s, 0, sizeof s);
        memset(&pass, 0, sizeof pass);
        memset(&above, 0, sizeof above);
        d.capacity = 1;
        d.maps = &(envsh_maps_desc){ .map_side = 64, .rgba = rgba };
        d.attributes.vertex = leaf_vertex;
        d.attributes.fragment = leaf_fragment;
        above.direction[1] = 1;
        above.irradiance[0] = above.irradiance[1] = above.irradiance[2] = 3.14159265f;
        assert_glbk(t, glbk_envsh_maps_create(&t->gl, &d, &m));
        to = make_view(t, &t->gl, WIDE, HIGH);
        assert_int_equal(envsh_maps_begin(r.layout, AS_LIGHTS(&above, 1), box), ENVSH_OK);
        things.vertices = 0;
        soup_quad(&things, a, u, v);
        t->gl.gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, r.buffer);
        t->gl.gl.BufferData(GLBK_GL_ARRAY_BUFFER, (ptrdiff_t)(12 * things.vertices), things.p, GLBK_GL_STATIC_DRAW);
        r.count = 1;
        render_maps(t, &m, &r);
        /* The ground as a map from above: x to the right, -z up. */
        things.vertices = 0;
        soup_quad(&things, ga, gu, gv);
        upload_soup(t, &things, &array, &buffer);
        memcpy(s.transform, identity, sizeof identity);
        clip[0] = clip[15] = 1;
        clip[6] = 0.5f;
        clip[9] = -1;
        s.material.diffuse[0] = s.material.diffuse[1] = 0.5f;
        assert_glbk(t, glbk_gbuffer_begin(&t->gl, &to.seen, clip, above_all));
        assert_glbk(t, glbk_gbuffer_object(&t->gl, &to.seen, &s));
        t->gl.gl.BindVertexArray(array);
        t->gl.gl.DrawArrays(GLBK_GL_TRIANGLES, 0, 6);
        pass.target = &canvas.target;
        assert_glbk(t, glbk_envsh_resolve(&t->gl, &to.r, &to.seen, &pass, NULL));
        assert_glbk(t, glbk_target_read(&t->gl, &canvas.target, 0, 0, 0, WIDE, HIGH, seen));
        for (x = 0; x < 4 * POINTS; x += 4) assert_true(seen[x] == 0);      /* no light yet */
        assert_glbk(t, glbk_envsh_shade(&t->gl, &to.r, &to.seen, &m, &plain, 0));
        assert_glbk(t, glbk_envsh_resolve(&t->gl, &to.r, &to.seen, &pass, NULL));
        assert_glbk(t, glbk_target_read(&t->gl, &canvas.target, 0, 0, 0, WIDE, HIGH, seen));
        for (y = 2; y < HIGH - 2; y++)
            for (x = 2; x < WIDE - 2; x++) {
                const float *p = seen + 4 * (y * WIDE + x);
                if (x == WIDE / 2 || x == WIDE / 2 - 1) continue;
                CLOSE(p[0], x < WIDE / 2 ? 0.0 : 0.5, 0.003);
                assert_true(p[2] == 0);
            }
        t->gl.gl.DeleteVertexArrays(1, &array);
        t->gl.gl.DeleteBuffers(1, &buffer);
        free_view(&t->gl, &to);
        glbk_envsh_maps_free(&t->gl, &m);
    }
    gl_canvas_free(t, &canvas);
    free_rig(t, &r);
}

/* ---- errors ---- */

static glbk_result refuse_to_draw(void *user, glbk_context *ctx, glbk_envsh_maps *maps, uint32_t instances)
{
    (void)user, (void)ctx, (void)maps, (void)instances;
    return GLBK_ERR_NAME;
}

static glbk_result cast_nothing(void *user, glbk_context *ctx, glbk_envsh_maps *maps, uint32_t instances)
{
    (void)user, (void)ctx, (void)maps, (void)instances;
    return GLBK_OK;
}

static void bad_arguments_are_named(void **state)
{
    GL_TEST(t, state)
    rig r = make_rig(t, even, 4, 64);
    glbk_envsh_maps_desc d;
    glbk_envsh_maps m;
    lit_view to, small;
    envsh_query q = soft;
    glbk_envsh_maps large;
    glbk_envsh_frame frame;
    static const envsh_maps_desc good = { .map_side = 64, .guard = 4 }, low = { .map_side = 15 },
                                 high = { .map_side = 5000 }, wide = { .map_side = 64, .guard = 17 };
    static const glbk_envsh_maps_desc bad[] = {
        { .capacity = 0, .maps = &good }, { .capacity = 8193, .maps = &good }, { .capacity = 4, .maps = &low },
        { .capacity = 4, .maps = &high }, { .capacity = 4, .maps = &wide }
    };
    size_t i;
    for (i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_int_equal(glbk_envsh_maps_create(&t->gl, &bad[i], &m), GLBK_ERR_DESC);
        assert_int_equal(m.atlas.name, 0);
    }
    d = bad[0];
    d.capacity = 8192;
    d.maps = &(envsh_maps_desc){ .map_side = 4096 };
    assert_int_equal(glbk_envsh_maps_create(&t->gl, &d, &m), GLBK_ERR_LIMIT);
    d.attributes.vertex = "void glbk_vertex(";
    d.attributes.fragment = leaf_fragment;
    d.capacity = 1;
    d.maps = &(envsh_maps_desc){ .map_side = 64 };
    t->expected_errors = ~0u;
    assert_int_equal(glbk_envsh_maps_create(&t->gl, &d, &m), GLBK_ERR_COMPILE);
    assert_non_null(strstr(t->log, "your text"));
    assert_int_equal(glbk_envsh_maps_create(NULL, &d, &m), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_envsh_renderer_create(&t->gl, &(glbk_envsh_renderer_desc){ 0, 4 }, &to.r), GLBK_ERR_DESC);
    m = make_maps(t, 3, 64, 0);
    to = make_view(t, &t->gl, WIDE, HIGH);
    assert_int_equal(glbk_envsh_maps_render(&t->gl, &m, r.views, 4, draw_things, &r), GLBK_ERR_LIMIT);
    assert_int_equal(glbk_envsh_maps_render(&t->gl, &m, r.views, 3, NULL, &r), GLBK_ERR_ARGUMENT);
    assert_int_equal(glbk_envsh_maps_render(&t->gl, &m, r.views, 3, refuse_to_draw, &r),
                     GLBK_ERR_NAME);
    assert_int_equal(m.count, 0);
    assert_glbk(t, glbk_envsh_maps_render(&t->gl, &m, NULL, 0, draw_things, &r));
    q.tap_count = 65;
    assert_int_equal(glbk_envsh_bind(&t->gl, &m, &q, NULL), GLBK_ERR_DESC);
    assert_string_equal(t->log, "glbk_envsh_bind: query.tap_count is 65; it must be 0..64");
    q = soft;
    q.radius = 64.5f;
    assert_int_equal(glbk_envsh_shade(&t->gl, &to.r, &to.seen, &m, &q, 0), GLBK_ERR_DESC);
    q.radius = sqrtf(-1.0f);
    frame = frame_of(&r, 4, &q);
    assert_int_equal(glbk_envsh_illuminate(&t->gl, &to.r, &to.seen, &m, &frame), GLBK_ERR_DESC);
    small = make_view(t, &t->gl, WIDE, HIGH - 1);
    assert_int_equal(glbk_envsh_shade(&t->gl, &to.r, &small.seen, &m, NULL, 0), GLBK_ERR_MISMATCH);
    free_view(&t->gl, &small);
    large = make_maps(t, 3, 128, 0);                        /* the views are of maps of 64 */
    assert_int_equal(glbk_envsh_maps_render(&t->gl, &large, r.views, 3, draw_things, &r), GLBK_ERR_MISMATCH);
    assert_non_null(strstr(t->log, "map_side is 128"));
    glbk_envsh_maps_free(&t->gl, &large);
    memset(&d, 0, sizeof d);
    d.capacity = 3;
    d.maps = &(envsh_maps_desc){ .map_side = 64, .guard = 8 };  /* they are of maps with a guard of 4 */
    assert_glbk(t, glbk_envsh_maps_create(&t->gl, &d, &large));
    assert_int_equal(glbk_envsh_maps_render(&t->gl, &large, r.views, 3, draw_things, &r), GLBK_ERR_MISMATCH);
    assert_string_equal(t->log, "glbk_envsh_maps_render: maps->guard is 8; it must be the guard of the envsh_maps_desc "
                                "that made the views");
    glbk_envsh_maps_free(&t->gl, &large);
    t->gl.check = 1;
    assert_int_equal(glbk_envsh_maps_render(&t->gl, &m, r.views, 3, cast_nothing, &r), GLBK_ERR_ORDER);
    assert_non_null(strstr(t->log, "glbk_envsh_cast"));
    t->gl.check = 0;
    assert_glbk(t, glbk_envsh_maps_render(&t->gl, &m, r.views, 3, cast_nothing, &r));
    glbk_envsh_maps_free(&t->gl, &m);
    glbk_envsh_maps_free(&t->gl, &m);
    glbk_envsh_maps_free(&t->gl, NULL);
    free_view(&t->gl, &to);
    glbk_envsh_renderer_free(NULL, &to.r);
    assert_int_equal(glbk_envsh_shade(&t->gl, &to.r, &to.seen, &m, &soft, 0), GLBK_ERR_ARGUMENT);
    free_rig(t, &r);
}

/* Draws the first vertices of the things for all instances, and the rest for the first instances alone. */
typedef struct partly {
    const rig *r;
    uint32_t   whole;               /* vertices that all instances have */
    uint32_t   most;                /* instances of the rest */
    uint32_t   calls;
} partly;

static glbk_result draw_partly(void *user, glbk_context *ctx, glbk_envsh_maps *maps, uint32_t instances)
{
    partly *p = (partly *)user;
    const uint32_t few = instances < p->most ? instances : p->most, rest = (uint32_t)things.vertices - p->whole;
    glbk_result result = glbk_envsh_cast(ctx, maps, NULL);
    ctx->gl.BindVertexArray(p->r->vertex_array);
    if (p->whole) ctx->gl.DrawArraysInstanced(GLBK_GL_TRIANGLES, 0, (int32_t)p->whole, (int32_t)instances);
    if (rest && few) ctx->gl.DrawArraysInstanced(GLBK_GL_TRIANGLES, (int32_t)p->whole, (int32_t)rest, (int32_t)few);
    p->calls++;
    return result;
}

/* Most lights would light as if they had no shadows, which looks right enough. desc.check says so, for one map a texel
   and four, however many instances are left out, and where other casters have them all. */
static void a_draw_of_too_few_instances_is_an_error(void **state)
{
    GL_TEST(t, state)
    static const uint32_t counts[] = { 1, 4, 9, 30 };
    uint32_t k, most, whole;
    int rgba;
    rig r = make_rig(t, even, 30, 64);
    for (rgba = 0; rgba < 2; rgba++)
        for (k = 0; k < 4; k++) {
            glbk_envsh_maps m = make_maps(t, 30, 64, rgba);
            const uint32_t tiles = (counts[k] + 3 * (uint32_t)rgba) / (rgba ? 4 : 1);
            const uint32_t instances = t->gl.es ? (tiles + m.across - 1) / m.across : tiles;    /* the most of a call */
            for (whole = 0; whole <= 36; whole += 36)       /* one box is always drawn, or nothing */
                for (most = 1; most <= instances; most += instances / 3 + 1) {
                    partly p = { &r, whole, most, 0 };
                    const int few = most < instances;
                    uint32_t calls;
                    t->gl.check = 0;
                    assert_glbk(t, glbk_envsh_maps_render(&t->gl, &m, r.views, counts[k], draw_partly, &p));
                    calls = p.calls;
                    t->gl.check = 1;
                    t->log[0] = 0;
                    assert_int_equal(glbk_envsh_maps_render(&t->gl, &m, r.views, counts[k], draw_partly, &p),
                                     few ? GLBK_ERR_ORDER : GLBK_OK);
                    assert_string_equal(t->log, few ? "glbk_envsh_maps_render: draw_fn drew fewer instances of a "
                                                      "caster than it was given" : "");
                    assert_int_equal(m.count, few ? 0 : counts[k]);
                    assert_int_equal(p.calls, 3 * calls);   /* the check draws twice */
                }
            assert_glbk(t, glbk_envsh_maps_render(&t->gl, &m, r.views, counts[k], draw_things, &r));
            glbk_envsh_maps_free(&t->gl, &m);
        }
    t->gl.check = 0;
    free_rig(t, &r);
}

/* Of a flat caster some views see nothing but its edge, and their maps stay empty: that is no mistake of draw_fn's, nor
   can be known whether all casters lie beyond the bounds. What is drawn twice is what is drawn once. */
static void empty_maps_are_no_error(void **state)
{
    GL_TEST(t, state)
    static uint32_t texels[2][4 * 24 * 24];
    rig r = make_rig(t, even, 9, 64);
    glbk_envsh_maps m = make_maps(t, 9, 64, 0);
    glbk_target_desc d;
    glbk_target target;
    envsh_view turned[9];
    partly all = { &r, (uint32_t)things.vertices, 0, 0 }, none = { &r, 0, 0, 0 };
    int i, k;
    memcpy(turned, r.views, sizeof turned);
    for (i = 1; i < 9; i += 3)
        for (k = 0; k < 3; k++) turned[i].lookup[k] = turned[i].lookup[4 + k] = 0;      /* no area from here */
    memset(&d, 0, sizeof d);
    d.color[0] = &m.cells;
    assert_glbk(t, glbk_target_create(&t->gl, &d, &target));
    for (t->gl.check = 0; t->gl.check < 2; t->gl.check++) {
        t->log[0] = 0;
        assert_glbk(t, glbk_envsh_maps_render(&t->gl, &m, turned, 9, draw_partly, &all));
        assert_int_equal(m.count, 9);
        assert_glbk(t, glbk_target_read(&t->gl, &target, 0, 0, 0, m.cells.width, m.cells.height, texels[t->gl.check]));
        assert_glbk(t, glbk_envsh_maps_render(&t->gl, &m, r.views, 9, draw_partly, &none));
        assert_string_equal(t->log, "");
    }
    assert_memory_equal(texels[0], texels[1], sizeof texels[0]);
    t->gl.check = 0;
    glbk_target_free(&t->gl, &target);
    glbk_envsh_maps_free(&t->gl, &m);
    free_rig(t, &r);
}

/* GL runs out of memory at the n-th question for errors, n = 1, 2, ...: the error is named, nothing is left. */
static void failures_leave_nothing(void **state)
{
    GL_TEST(t, state)
    rig r = make_rig(t, even, 3, 32);
    const glbk_envsh_frame frame = frame_of(&r, 3, &soft);
    glbk_result result;
    int failed = 0;
    t->gl.check = 1;
    fake_begin_blind(t, 0x0505);
    for (fake.at = 1;; fake.at++) {
        glbk_envsh_maps_desc d;
        glbk_envsh_maps m;
        glbk_gbuffer_desc size;
        lit_view to;
        memset(&d, 0, sizeof d);
        memset(&to, 0, sizeof to);
        memset(&size, 0, sizeof size);
        size.width = size.height = 8;
        d.capacity = 2;
        d.maps = &(envsh_maps_desc){ .map_side = 32, .rgba = 1 };
        fake.calls = 0;
        result = glbk_envsh_maps_create(&t->gl, &d, &m);
        if (result == GLBK_OK) result = glbk_gbuffer_create(&t->gl, &size, &to.seen);
        if (result == GLBK_OK) result = glbk_envsh_renderer_create(&t->gl, &(glbk_envsh_renderer_desc){ 8, 8 }, &to.r);
        if (result == GLBK_OK) result = glbk_envsh_illuminate(&t->gl, &to.r, &to.seen, &m, &frame);
        glbk_envsh_maps_free(&t->gl, &m);
        free_view(&t->gl, &to);
        assert_int_equal(fake.live, 0);
        if (result == GLBK_OK) break;
        assert_true(result == GLBK_ERR_GL_MEMORY || result == GLBK_ERR_PENDING);
        failed++;
    }
    t->gl.gl = fake.real;
    assert_true(failed > 20);
    free_rig(t, &r);
}

/* Every call says so, without a call of GL: with an empty table it would crash. */
/* While cells are made, each level is the texture's only one for a moment. */
static void cells_are_whole_after_a_failure(void **state)
{
    GL_TEST(t, state)
    rig r = make_rig(t, even, 3, 64);
    glbk_envsh_maps m = make_maps(t, 3, 64, 0);
    glbk_result result = GLBK_ERR_GL;
    void (GLBK_CALL *get)(uint32_t, uint32_t, int32_t *);
    glbk_proc_fn proc = ex_gl_get_proc("glGetTexParameteriv", t->context);
    int failed = 0;
    memcpy(&get, &proc, sizeof get);
    assert_true(m.levels > 1);
    t->gl.check = 1;
    fake_begin(t, 0x0505);
    for (fake.at = 1; result != GLBK_OK; fake.at++) {
        int32_t base = -1, last = -1;
        fake.calls = 0;
        result = glbk_envsh_maps_render(&t->gl, &m, r.views, 3, draw_things, &r);
        failed += result != GLBK_OK;
        t->gl.gl.BindTexture(GLBK_GL_TEXTURE_2D_ARRAY, m.cells.name);
        get(GLBK_GL_TEXTURE_2D_ARRAY, 0x813C /* BASE_LEVEL */, &base);
        get(GLBK_GL_TEXTURE_2D_ARRAY, 0x813D /* MAX_LEVEL */, &last);
        assert_int_equal(base, 0);
        assert_int_equal(last, m.levels - 1);
    }
    t->gl.gl = fake.real;
    assert_true(failed > 2);
    glbk_envsh_maps_free(&t->gl, &m);
    free_rig(t, &r);
}

static void a_lost_context_comes_out(void **state)
{
    GL_TEST(t, state)
    static asked points[POINTS];
    static float out[4 * POINTS];
    rig r = make_rig(t, even, 3, 64);
    glbk_envsh_maps m = make_maps(t, 3, 64, 0), other;
    lit_view to, half;
    glbk_envsh_maps_desc d;
    const glbk_envsh_frame frame = frame_of(&r, 3, &soft);
    glbk_context ctx;
    glbk_pass pass;
    gl_canvas c = gl_canvas_make(t, GLBK_FORMAT_COLOR, 4, 4, 0);
    make_points(points);
    to = make_renderer(t, points);
    illuminate(t, &to, &m, &r, out);
    memset(&pass, 0, sizeof pass);
    memset(&d, 0, sizeof d);
    pass.target = &c.target;
    d.capacity = 2;
    d.maps = &(envsh_maps_desc){ .map_side = 32 };
    ctx = t->gl;
    memset(&t->gl.gl, 0, sizeof t->gl.gl);
    glbk_abandon(&t->gl);
    assert_int_equal(glbk_envsh_maps_create(&t->gl, &d, &other), GLBK_ERR_LOST);
    assert_int_equal(other.atlas.name, 0);
    assert_int_equal(glbk_envsh_renderer_create(&t->gl, &(glbk_envsh_renderer_desc){ 8, 8 }, &half.r), GLBK_ERR_LOST);
    assert_int_equal(glbk_envsh_bind(&t->gl, &m, &soft, NULL), GLBK_ERR_LOST);
    assert_int_equal(glbk_envsh_read(&t->gl, &to.r, out), GLBK_ERR_LOST);
    assert_int_equal(glbk_envsh_resolve(&t->gl, &to.r, &to.seen, &pass, NULL), GLBK_ERR_LOST);
    assert_int_equal(glbk_envsh_shade(&t->gl, &to.r, &to.seen, &m, &soft, 0), GLBK_ERR_LOST);
    assert_int_equal(glbk_envsh_illuminate(&t->gl, &to.r, &to.seen, &m, &frame), GLBK_ERR_LOST);
    assert_int_equal(glbk_envsh_maps_render(&t->gl, &m, r.views, 3, draw_things, &r), GLBK_ERR_LOST);
    other = m;
    half = to;
    glbk_envsh_maps_free(&t->gl, &other);
    free_view(&t->gl, &half);
    assert_int_equal(other.atlas.name, 0);
    t->gl = ctx;
    gl_canvas_free(t, &c);
    glbk_envsh_maps_free(&t->gl, &m);
    free_view(&t->gl, &to);
    free_rig(t, &r);
}

/* ---- state ---- */

/* Everything made, used and destroyed; out is the light, resolved is what a screen got. */
static void watched_frame(gl_test *t, rig *r, int rgba, const glbk_target *screen, float out[2][4 * POINTS])
{
    static const float view[16] = { 0.5f, 0, 0, 0, 0, 0, 0.5f, 0, 0, -0.5f, 0, 0, 0, 0, 0, 1 };
    static const float origin[3] = { 0, 0, 0 };
    static asked points[POINTS];
    glbk_envsh_maps_desc d;
    glbk_envsh_maps m;
    lit_view to;
    glbk_surface s;
    glbk_pass pass;
    memset(&d, 0, sizeof d);
    memset(&s, 0, sizeof s);
    memset(&pass, 0, sizeof pass);
    d.capacity = 5;
    d.maps = &(envsh_maps_desc){ .map_side = 64, .rgba = rgba };
    pass.target = screen;
    s.material.diffuse[0] = 1;
    make_points(points);
    GL_SAME(t, assert_glbk(t, glbk_envsh_maps_create(&t->gl, &d, &m)));
    GL_SAME(t, to = make_renderer(t, points));
    gl_count_begin(&t->gl);
    gl_counted.allowed = 11;            /* the table of lights: what is put back */
    GL_SAVED(t, assert_glbk(t, glbk_envsh_maps_render(&t->gl, &m, r->views, 5, draw_things, r)));
    gl_counted.allowed = 0;
    GL_SAVED(t, assert_glbk(t, glbk_envsh_bind(&t->gl, &m, &soft, NULL)));
    gl_count_end(&t->gl);
    GL_SAVED(t, illuminate(t, &to, &m, r, out[0]));     /* compiles */
    GL_SAVED(t, assert_glbk(t, glbk_gbuffer_begin(&t->gl, &to.seen, view, origin)));     /* compiles */
    gl_count_begin(&t->gl);
    GL_SAME(t, assert_glbk(t, glbk_envsh_read(&t->gl, &to.r, out[0])));
    GL_SAVED(t, {
        assert_glbk(t, glbk_gbuffer_begin(&t->gl, &to.seen, view, origin));
        assert_glbk(t, glbk_gbuffer_object(&t->gl, &to.seen, &s));
        t->gl.gl.BindVertexArray(r->vertex_array);
        t->gl.gl.DrawArrays(GLBK_GL_TRIANGLES, 0, (int32_t)things.vertices);
    });
    GL_SAVED(t, assert_glbk(t, glbk_envsh_shade(&t->gl, &to.r, &to.seen, &m, &soft, 0)));
    GL_SAVED(t, assert_glbk(t, glbk_envsh_resolve(&t->gl, &to.r, &to.seen, &pass, NULL)));
    gl_count_end(&t->gl);
    GL_SAME(t, assert_glbk(t, glbk_target_read(&t->gl, screen, 0, 0, 0, WIDE, HIGH, out[1])));
    GL_SAME(t, glbk_envsh_maps_free(&t->gl, &m));
    GL_SAME(t, free_view(&t->gl, &to));
}

static void light_is_the_same_from_a_hostile_state(void **state)
{
    GL_TEST(t, state)
    static float calm[2][2][4 * POINTS], harsh[2][2][4 * POINTS];
    rig r = make_rig(t, sunny, 9, 64);
    gl_canvas screen = gl_canvas_make(t, GLBK_FORMAT_COLOR, WIDE, HIGH, 0);
    gl_hostile h;
    int rgba, i, lit[2] = { 0, 0 };

    gl_state_watch(t, 1);
    for (rgba = 0; rgba < 2; rgba++) watched_frame(t, &r, rgba, &screen.target, calm[rgba]);
    gl_hostile_make(t, &h);
    gl_hostile_set(t, &h);
    for (rgba = 0; rgba < 2; rgba++) watched_frame(t, &r, rgba, &screen.target, harsh[rgba]);
    assert_memory_equal(calm, harsh, sizeof calm);
    for (i = 0; i < 4 * POINTS; i += 4) {
        lit[0] += calm[0][0][i] > 0;
        lit[1] += calm[0][1][i] > 0;
    }
    assert_true(lit[0] > POINTS / 4 && lit[1] > POINTS / 4);
    gl_hostile_free(t, &h);
    gl_canvas_free(t, &screen);
    free_rig(t, &r);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(tiles_are_those_of_the_rasteriser),
        gl_unit_test(visibility_is_the_twins),
        gl_unit_test(clusters_make_the_same_light),
        gl_unit_test(open_ground_is_lit_and_a_roof_dark),
        gl_unit_test(a_sealed_box_is_dark),
        gl_unit_test(tiles_do_not_bleed),
        gl_unit_test(compute_is_the_core_path),
        gl_unit_test(groups_know_what_their_pixels_see),
        gl_unit_test(a_mask_of_the_users_lets_light_through_in_a_drawn_picture),
        gl_unit_test(bad_arguments_are_named),
        gl_unit_test(a_draw_of_too_few_instances_is_an_error), gl_unit_test(empty_maps_are_no_error),
        gl_unit_test(failures_leave_nothing),
        gl_unit_test(a_lost_context_comes_out),
        gl_unit_test(cells_are_whole_after_a_failure),
        gl_unit_test(light_is_the_same_from_a_hostile_state)
    };
    (void)count;
    if (gl_this_way() && gl_this_way()->bit != GL_CORE33) unsetenv("CONFORMANCE");      /* one line a row */
    GL_TEST_MAIN(values, tests, GL_USUAL);
}
