/* gl_build_test - maps built on the GPU: what is peeled stands by csm.h's own verifier, and segments found by the
   shaders give the bytes that csm.h builds from the same layers. */
#define _POSIX_C_SOURCE 200809L
#include "csm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend/gl_csm.h"

#define CONFORM_BACKEND "gl"
#include "conformance.h"
#include "gl_test.h"
#include "util.h"

typedef struct object { cohsm_builder *views; uint32_t vertex_array, buffers[2]; int32_t indices; } object;

static void view_of(void *user, uint32_t index, cohsm_view *out)
{
    assert_int_equal(cohsm_builder_view(((object *)user)->views, index, out), COHSM_OK);
}

static void draw(void *user, glbk_context *gl)
{
    object *o = user;
    gl->gl.BindVertexArray(o->vertex_array);
    gl->gl.DrawElements(GLBK_GL_TRIANGLES, o->indices, GLBK_GL_UNSIGNED_INT, NULL);
}

static void upload(glbk_context *gl, const cohsm_mesh *m, object *o)
{
    gl->gl.GenVertexArrays(1, &o->vertex_array);
    gl->gl.GenBuffers(2, o->buffers);
    gl->gl.BindVertexArray(o->vertex_array);
    gl->gl.BindBuffer(GLBK_GL_ARRAY_BUFFER, o->buffers[0]);
    gl->gl.BufferData(GLBK_GL_ARRAY_BUFFER, (ptrdiff_t)(12 * m->vertex_count), m->positions, GLBK_GL_STATIC_DRAW);
    gl->gl.BindBuffer(GLBK_GL_ELEMENT_ARRAY_BUFFER, o->buffers[1]);
    gl->gl.BufferData(GLBK_GL_ELEMENT_ARRAY_BUFFER, (ptrdiff_t)(4 * m->index_count), m->indices, GLBK_GL_STATIC_DRAW);
    gl->gl.EnableVertexAttribArray(0);
    gl->gl.VertexAttribPointer(0, 3, GLBK_GL_FLOAT, 0, 0, NULL);
    gl->gl.BindVertexArray(0);
    o->indices = (int32_t)m->index_count;
}

static void release(glbk_context *gl, object *o)
{
    gl->gl.DeleteVertexArrays(1, &o->vertex_array);
    gl->gl.DeleteBuffers(2, o->buffers);
}

/* The depths of one layer of a view that was drawn, the one with this number in its batch. */
static void read_layer(gl_test *t, glbk_csm_builder *b, uint32_t number, uint32_t layer, float *depths)
{
    const uint32_t m = b->map_side, x = number % b->tiles * m, y = number / b->tiles * m;
    uint32_t *words = malloc((size_t)m * m * 16), i;
    assert_non_null(words);
    assert_glbk(t, glbk_target_read(&t->gl, &b->layer_targets[layer], 0, x, y, m, m, words));
    for (i = 0; i < m * m; i++) memcpy(&depths[i], &words[4 * i], 4);
    free(words);
}

/* The same drawn layers once through csm.h alone, once through the shaders; wrong: share of entries that csm.h's own
   rasteriser contradicts, along edges. */
static void build_both(gl_test *t, cohsm_desc d, const model *m, double most_wrong)
{
    cohsm_mesh mesh = mesh_of(m);
    cohsm_maps *maps, *by_cpu, *by_gpu;
    cohsm_builder *cpu, *gpu;
    cohsm_info info;
    cohsm_report report;
    glbk_csm_builder_desc desc;
    glbk_csm_builder b;
    object o;
    size_t sizes[2];
    const void *blocks[2];
    float *z;
    uint32_t from, n, i, k, pixels = d.map_side * d.map_side, views;

    assert_int_equal(cohsm_build(&d, &mesh, &maps, NULL), COHSM_OK);    /* fits the sphere */
    cohsm_get_info(maps, &info);
    cohsm_free(maps);
    memcpy(d.center, info.center, sizeof d.center);
    d.radius = info.radius;
    d.order = info.order;
    d.orientation = info.orientation;
    assert_int_equal(cohsm_builder_create(&d, &cpu), COHSM_OK);
    assert_int_equal(cohsm_builder_create(&d, &gpu), COHSM_OK);
    o.views = cpu;
    upload(&t->gl, &mesh, &o);
    memset(&desc, 0, sizeof desc);
    desc.maps = &d;
    desc.view_fn = view_of;
    desc.draw_fn = draw;
    desc.user = &o;
    assert_glbk(t, glbk_csm_builder_create(&t->gl, &desc, &b));
    z = malloc(3 * pixels * sizeof *z);
    assert_non_null(z);
    views = cohsm_builder_view_count(cpu);
    for (from = 0; from < views; from += n) {
        n = views - from < b.batch ? views - from : b.batch;
        assert_glbk(t, glbk_csm_builder_draw(&t->gl, &b, from, n));
        for (i = 0; i < n; i++) {
            for (k = 0; k < (d.layers == COHSM_LAYERS_Z1Z3_FAR || d.layers == COHSM_LAYERS_Z1Z3_SPHERE ? 3u : 2u); k++)
                read_layer(t, &b, i, k, z + k * pixels);
            assert_int_equal(cohsm_builder_add(cpu, from + i, z, z + pixels, z + 2 * pixels), COHSM_OK);
        }
        assert_glbk(t, glbk_csm_builder_compress(&t->gl, &b));
    }
    assert_glbk(t, glbk_csm_builder_end(&t->gl, &b));
    assert_int_equal(cohsm_builder_import(gpu, b.segments, b.segment_count), COHSM_OK);
    assert_int_equal(cohsm_builder_finish(cpu, &by_cpu, NULL), COHSM_OK);
    assert_int_equal(cohsm_builder_finish(gpu, &by_gpu, NULL), COHSM_OK);
    blocks[0] = cohsm_data(by_cpu, &sizes[0]);
    blocks[1] = cohsm_data(by_gpu, &sizes[1]);
    assert_int_equal(sizes[0], sizes[1]);
    assert_memory_equal(blocks[0], blocks[1], sizes[0]);
    assert_int_equal(cohsm_verify(by_gpu, NULL, &mesh, &report), COHSM_OK);
    printf("%u views of %u^2, %zu segments in %u runs: equal bytes; %.4f of the entries off csm.h's own layers\n",
           views, d.map_side, b.segment_count, b.passes, (double)report.wrong / (double)report.entries);
    assert_true((double)report.wrong <= most_wrong * (double)report.entries);
    if (d.layers == COHSM_LAYERS_Z1Z3_SPHERE && gl_this_way()->bit == GL_CORE33)     /* edges differ by a pixel */
        CONFORM_MAX("T59",
                    d.domain.kind == COHSM_DOMAIN_RECTANGLE
                        ? "entries of perspective maps up to the sphere, made on the GPU, off csm.h's layers"
                        : "entries of maps up to the sphere, made on the GPU, off csm.h's layers",
                    0.01, (double)report.wrong / (double)report.entries);
    assert_true(b.segment_count > pixels);
    glbk_csm_builder_free(&t->gl, &b);
    release(&t->gl, &o);
    cohsm_builder_free(cpu);
    cohsm_builder_free(gpu);
    cohsm_free(by_cpu);
    cohsm_free(by_gpu);
    free(z);
}

static void directional_domains_are_built_as_on_the_cpu(void **state)
{
    GL_TEST(t, state)
    model m = model_torus(24, 12, 1.0, 0.4);
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 12, 32);
    d.order = COHSM_ORDER_HILBERT;
    build_both(t, d, &m, 0.01);
    d.layers = COHSM_LAYERS_Z1Z3_FAR;
    d.depth_bits = 5;
    build_both(t, d, &m, 0.01);
    d.self_only = 1;
    build_both(t, d, &m, 0.01);
    d.self_only = 0;
    d.layers = COHSM_LAYERS_Z1Z3_SPHERE;
    build_both(t, d, &m, 0.01);
    d.layers = COHSM_LAYERS_Z1Z2;
    d.map_side = 200;                                   /* tiles of 4 x 4 */
    d.domain.side[0] = d.domain.side[1] = 6;
    build_both(t, d, &m, 0.01);
    model_free(&m);
}

/* Open borders, and a soup whose layers change from view to view: many segments, more than one run a batch. */
static void open_and_busy_meshes_are_built_as_on_the_cpu(void **state)
{
    GL_TEST(t, state)
    model cube = model_cube(1.0, 3), soup = model_soup(60, 0.5, 4);
    cohsm_desc d = desc_of(COHSM_DOMAIN_OCTAHEDRAL, 10, 24);
    d.open_thickness = 3;
    build_both(t, d, &cube, 0.02);
    d.domain.side[0] = d.domain.side[1] = 16;
    d.order = COHSM_ORDER_SCANLINE;
    d.depth_bits = 4;
    build_both(t, d, &soup, 0.02);
    model_free(&cube);
    model_free(&soup);
}

/* More than 65,536 views: the lists begin anew. */
static void lists_begin_anew_after_65536_views(void **state)
{
    GL_TEST(t, state)
    model m;
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 257, 4);
    if (gl_this_way()->bit != GL_CORE45) return;        /* slow, and the same code in the others */
    m = model_cube(1.0, 1);
    d.order = COHSM_ORDER_ZIGZAG;
    build_both(t, d, &m, 0.02);
    model_free(&m);
}

static void positional_domains_are_built_as_on_the_cpu(void **state)
{
    GL_TEST(t, state)
    model m = model_torus(24, 12, 1.0, 0.4);
    cohsm_desc d = desc_of(COHSM_DOMAIN_RECTANGLE, 4, 24);
    place_domain(&d, 0.2f, 1.5f, 0.1f, 0.5f);
    build_both(t, d, &m, 0.01);
    d.layers = COHSM_LAYERS_Z1Z3_SPHERE;
    build_both(t, d, &m, 0.01);
    model_free(&m);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(directional_domains_are_built_as_on_the_cpu),
        gl_unit_test(open_and_busy_meshes_are_built_as_on_the_cpu),
        gl_unit_test(positional_domains_are_built_as_on_the_cpu), gl_unit_test(lists_begin_anew_after_65536_views)
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE45 | GL_CORE33 | GL_ES30_BARE);
}
