/* gl_compute_test - the compute path of ism beside the core path, in one context: the same surfels, texels and light,
   of tiles of every size, of several rounds of wide discs, of classes with more VPLs than a round reads, of
   pictures that no group divides. Points, VPLs and pixels are random numbers. */
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

#define GL_ISM_IMPLEMENTATION
#include "gl_backend/gl_ism.h"
#include "ism.h"

#include "gl_test.h"
#include "gl_count.h"
#include "gl_util.h"

enum { TRIANGLES = 300 };

/* The same on both paths: 0 core, 1 compute. */
typedef struct pair {
    glbk_context  gl[2];
    glbk_ism_maps maps[2];
    char          log[GL_LOG];
} pair;

static uint32_t seed;

static float unit(void)
{
    seed = seed * 1664525u + 1013904223u;
    return (float)(seed >> 8) / 16777216.0f;
}

static float between(float lo, float hi) { return lo + (hi - lo) * unit(); }

static void pair_open(gl_test *t, pair *p)
{
    glbk_desc d;
    memset(p, 0, sizeof *p);
    memset(&d, 0, sizeof d);
    d.get_proc_fn = gl_get_proc();
    d.user = t->context;
    d.system.log = gl_log;
    d.system.user = p->log;
    for (int i = 0; i < 2; i++) {
        d.core_only = !i;
        assert_glbk(t, glbk_init(&p->gl[i], &d));
        assert_int_equal(p->gl[i].compute, i);
    }
    seed = 7;
}

static void pair_close(pair *p)
{
    for (int i = 0; i < 2; i++) {
        glbk_ism_maps_free(&p->gl[i], &p->maps[i]);
        glbk_free(&p->gl[i]);
    }
}

/* ---- maps ---- */

/* Triangles of half a metre in a room of four; every sixth of another opacity. */
static void send_mesh(gl_test *t, pair *p)
{
    static float corners[9 * TRIANGLES], opacities[TRIANGLES];
    const ism_mesh mesh = { corners, 3 * TRIANGLES, 0, NULL, 3 * TRIANGLES, NULL, opacities, NULL, NULL, NULL };
    for (int i = 0; i < TRIANGLES; i++) {
        float *c = corners + 9 * i;
        for (int k = 0; k < 3; k++) c[k] = between(-2, 2);
        for (int k = 3; k < 9; k++) c[k] = c[k % 3] + between(-0.5f, 0.5f);
        opacities[i] = i % 6 ? 1.0f : 0.5f;
    }
    for (int i = 0; i < 2; i++) assert_glbk(t, glbk_ism_mesh_upload(&p->gl[i], &p->maps[i], &mesh));
}

/* Of the maps that are made; what is 0 is ism.h's default. */
static ism_desc sizes(uint32_t vpls, uint32_t surfels, uint32_t side, ism_projection projection, uint32_t phases)
{
    ism_desc d;
    memset(&d, 0, sizeof d);
    d.vpl_count = vpls;
    d.surfel_count = surfels;
    d.tile_side = side;
    d.projection = projection;
    d.lazy_frames = phases;
    return d;
}

/* All phases; one of 16 surfels stands for its whole triangle. */
static void send_surfels(gl_test *t, pair *p, uint32_t surfels)
{
    const glbk_ism_maps *m = &p->maps[0];
    const size_t count = (size_t)m->desc.vpl_count * m->phase_surfel_count;
    ism_surfel *list = (ism_surfel *)malloc(count * sizeof *list);
    assert_non_null(list);
    for (uint32_t phase = 0; phase < m->desc.lazy_frames; phase++) {
        for (size_t i = 0; i < count; i++) {
            ism_surfel *s = &list[i];
            s->barycentric[0] = unit();
            s->area = i % 16 ? between(0.1f, 1) * TRIANGLES / (float)surfels : 1.0f;
            s->barycentric[1] = (1 - s->barycentric[0]) * unit();
            s->triangle = (uint32_t)(unit() * TRIANGLES);
        }
        for (int i = 0; i < 2; i++) assert_glbk(t, glbk_ism_surfels_upload(&p->gl[i], &p->maps[i], phase, list, count));
    }
    free(list);
}

/* In the room; of four one is a lobe, where the maps have lobes, and one a sky's. */
static void send_vpls(gl_test *t, pair *p, uint32_t count)
{
    static ism_vpl list[600];
    static const ism_info info = { .radius = 4 };
    assert_true(count <= 600);
    memset(list, 0, sizeof list);
    for (uint32_t i = 0; i < count; i++) {
        ism_vpl *l = &list[i];
        float n[3], length = 0;
        for (int k = 0; k < 3; k++) {
            n[k] = between(-1, 1);
            length += n[k] * n[k];
            l->position[k] = between(-2, 2);
            l->flux[k] = between(0.1f, 1);
        }
        for (int k = 0; k < 3; k++) l->normal[k] = l->axis[k] = n[k] / sqrtf(length);
        l->exponent = i % 4 == 1 ? between(1, 20) : 1;
        l->edge = i % 3 ? 0.4f : 0;
        l->directional = i % 4 == 2;
        if (i % 3 == 1)             /* cuts below 32; in one axis alone where i is even */
            l->window = i * 2654435761u >> 8 & (i % 2 ? 0x7df7dfu : 0x01f01fu);
        l->reach = l->directional || i % 4 == 1 ? 0 : 1.5f;
        if (l->directional)
            for (int k = 0; k < 3; k++) l->position[k] = -l->normal[k];
    }
    for (int i = 0; i < 2; i++)
        assert_glbk(t, glbk_ism_vpls_upload(&p->gl[i], &p->maps[i], list, count, &info));
}

/* Any number, so that the last sphere has few. */
static void send_near(gl_test *t, pair *p, uint32_t vpls, uint32_t count)
{
    static ism_near_point points[3000];
    assert_true(count <= 3000);
    for (uint32_t i = 0; i < count; i++) {
        ism_near_point *to = &points[i];
        float length = 0;
        for (int k = 0; k < 3; k++) {
            to->position[k] = (float)(i / 64 % 4) - 2 + between(0, 1);
            to->normal[k] = between(-1, 1);
            length += to->normal[k] * to->normal[k];
            to->flux[k] = between(0.01f, 0.1f);
        }
        for (int k = 0; k < 3; k++) to->normal[k] /= sqrtf(length);
        to->edge = i % 3 ? 0.1f : 0;
        to->reach = between(0.8f, 1.6f);
        to->vpl = (float)(i % vpls);
    }
    for (int i = 0; i < 2; i++)
        assert_glbk(t, glbk_ism_near_points_upload(&p->gl[i], &p->maps[i], points, count));
}

static void make_maps(gl_test *t, pair *p, const ism_desc *d, uint32_t vpls)
{
    for (int i = 0; i < 2; i++) {
        glbk_ism_maps_free(&p->gl[i], &p->maps[i]);
        assert_glbk(t, glbk_ism_maps_create(&p->gl[i], d, &p->maps[i]));
        assert_int_equal(p->maps[i].compute, i);
    }
    send_mesh(t, p);
    send_surfels(t, p, d->surfel_count);
    send_vpls(t, p, vpls);
}

/* How many of the words differ. */
static size_t differences(const uint32_t *a, const uint32_t *b, size_t words)
{
    size_t off = 0;
    for (size_t i = 0; i < words; i++) off += a[i] != b[i];
    return off;
}

/* Surfels and atlas of both, bit by bit; texels with a surfel. */
static size_t compare_maps(gl_test *t, pair *p, const char *what)
{
    const uint32_t side = p->maps[0].side;
    const size_t texels = (size_t)side * side;
    uint32_t *surfels[2];
    float *atlas[2];
    size_t surfaces = 0, off[2];
    for (int i = 0; i < 2; i++) {
        surfels[i] = (uint32_t *)malloc(16 * texels);
        atlas[i] = (float *)malloc(4 * texels);
        assert_non_null(surfels[i]);
        assert_non_null(atlas[i]);
        assert_glbk(t, glbk_ism_draw(&p->gl[i], &p->maps[i], 0));
        assert_glbk(t, glbk_target_read(&p->gl[i], &p->maps[i].plane_target, 0, 0, 0, side, side, surfels[i]));
        assert_glbk(t, gl_read_atlas(&p->gl[i], &p->maps[i], atlas[i]));
    }
    for (size_t i = 0; i < texels; i++) surfaces += atlas[1][i] < 1e30f;
    off[0] = differences(surfels[0], surfels[1], 4 * texels);
    off[1] = differences((const uint32_t *)(const void *)atlas[0], (const uint32_t *)(const void *)atlas[1], texels);
    printf("%s: %zu texels, %zu with a surface; words of surfels that differ: %zu, of the atlas: %zu\n", what, texels,
           surfaces, off[0], off[1]);
    for (int i = 0; i < 2; i++) {
        free(surfels[i]);
        free(atlas[i]);
    }
    assert_int_equal(off[0] + off[1], 0);
    return surfaces;
}

static void tiles_of_every_size_agree(void **state)
{
    GL_TEST(t, state)
    pair p;
    pair_open(t, &p);
    for (uint32_t size = 8, projection = 1; size <= 256; size *= 2, projection = projection % 4 + 1) {
        ism_desc d = sizes(5, 700, size, (ism_projection)projection, 3);
        char what[32];
        size_t surfaces;
        make_maps(t, &p, &d, 4);
        snprintf(what, sizeof what, "%u, projection %u", size, projection);
        surfaces = compare_maps(t, &p, what);
        assert_true(surfaces > size * size / 2 && surfaces <= 4 * (size_t)size * size);   /* one tile is empty */
        d.no_fill = 1;
        make_maps(t, &p, &d, 4);
        assert_true(compare_maps(t, &p, "no fill") < surfaces);
    }
    pair_close(&p);
}

/* Holes, pull and push alone, of noise in patches: dense ones have holes, thin ones look for texels far away, across
   the borders of the squares that large tiles are cut into. */
static void noise_is_filled_alike(void **state)
{
    GL_TEST(t, state)
    enum { SIZE = 256 };
    static float surfels[4 * SIZE * SIZE], atlas[2][SIZE * SIZE];
    const ism_desc d = sizes(1, 64, SIZE, ISM_PROJECTION_COSINE, 1);
    size_t i, kept = 0, dropped = 0, filled = 0;
    pair p;
    pair_open(t, &p);
    make_maps(t, &p, &d, 1);
    compare_maps(t, &p, "before noise");
    for (i = 0; i < SIZE * SIZE; i++) {
        const float uv[2] = { ((float)(i % SIZE) + 0.5f) / SIZE, ((float)(i / SIZE) + 0.5f) / SIZE };
        float w[3];
        const float depth = between(1, 4), share = (i / 12 + i / SIZE / 12) % 2 ? 0.03f : 0.6f;
        ism_map_direction(ISM_PROJECTION_COSINE, 1, uv, w);
        for (int k = 0; k < 3; k++) surfels[4 * i + (size_t)k] = w[k] / depth;
        surfels[4 * i + 3] = unit() < share ? depth : 1e30f;
    }
    for (int way = 0; way < 2; way++) {
        assert_glbk(t, glbk_texture_update(&p.gl[way], &p.maps[way].planes, &(glbk_box){ 0, 0, 0, 0, SIZE, SIZE, 1 },
                                           surfels));
        assert_glbk(t, glbk__ism_fill(&p.gl[way], &p.maps[way]));
        assert_glbk(t, gl_read_atlas(&p.gl[way], &p.maps[way], atlas[way]));
    }
    for (i = 0; i < SIZE * SIZE; i++) {
        const float had = surfels[4 * i + 3], has = atlas[1][i];
        if (had < 1e30f) kept += has == had, dropped += has != had;
        else filled += has < 1e30f;
    }
    printf("noise: %zu surfels kept, %zu holes, %zu texels filled\n", kept, dropped, filled);
    assert_true(kept > 1000 && dropped > 1000 && filled > 1000);
    assert_memory_equal(atlas[0], atlas[1], sizeof atlas[0]);
    pair_close(&p);
}

/* Eight rounds of discs that mostly cover more than 64 texels. */
static void discs_of_many_texels_agree(void **state)
{
    GL_TEST(t, state)
    pair p;
    ism_desc d = sizes(2, 8000, 64, ISM_PROJECTION_COSINE, 1);
    d.splat_scale = 16;
    pair_open(t, &p);
    make_maps(t, &p, &d, 2);
    assert_true(compare_maps(t, &p, "wide") > 6000);
    pair_close(&p);
}

static void nothing_to_draw_leaves_empty_maps(void **state)
{
    GL_TEST(t, state)
    pair p;
    const ism_desc d = sizes(3, 64, 16, ISM_PROJECTION_COSINE, 1);
    pair_open(t, &p);
    make_maps(t, &p, &d, 3);
    assert_true(compare_maps(t, &p, "some") > 100);
    send_vpls(t, &p, 0);
    assert_int_equal(compare_maps(t, &p, "no VPLs"), 0);
    send_vpls(t, &p, 3);
    for (int i = 0; i < 2; i++) assert_glbk(t, glbk_ism_mesh_upload(&p.gl[i], &p.maps[i], NULL));
    assert_int_equal(compare_maps(t, &p, "no triangles"), 0);
    pair_close(&p);
}

/* Points are counted in 16 bits: of more, as phases of 63 round 65,536 up to, maps are the core path's. */
static void more_surfels_than_16_bits_take_the_core_path(void **state)
{
    GL_TEST(t, state)
    ism_desc d = sizes(1, 65536, 8, ISM_PROJECTION_COSINE, 64);
    glbk_ism_maps m;
    assert_glbk(t, glbk_ism_maps_create(&t->gl, &d, &m));
    assert_int_equal(m.compute, 1);
    glbk_ism_maps_free(&t->gl, &m);
    d.lazy_frames = 63;
    assert_glbk(t, glbk_ism_maps_create(&t->gl, &d, &m));
    assert_int_equal(m.compute, 0);
    glbk_ism_maps_free(&t->gl, &m);
}

/* ---- light ---- */

enum { WIDTH = 75, HEIGHT = 37, PIXELS = WIDTH * HEIGHT };

typedef struct pictures { glbk_gbuffer seen[2]; glbk_ism_renderer renderer[2]; } pictures;

/* A floor with bumps; every 29th pixel is background. */
static void make_pictures(gl_test *t, pair *p, pictures *made)
{
    static float places[3 * PIXELS], normals[3 * PIXELS];
    for (int i = 0; i < PIXELS; i++) {
        places[3 * i] = 4 * (float)(i % WIDTH) / WIDTH - 2;
        places[3 * i + 1] = between(-0.02f, 0) - 1;
        places[3 * i + 2] = 4 * (float)(i / WIDTH) / HEIGHT - 2;
        normals[3 * i + 1] = i % 29 ? 1.0f : 0.0f;
    }
    for (int i = 0; i < 2; i++) {
        assert_glbk(t, glbk_ism_renderer_create(&p->gl[i], &(glbk_ism_renderer_desc){ WIDTH, HEIGHT },
                                                &made->renderer[i]));
        gl_see(&p->gl[i], WIDTH, HEIGHT, places, normals, NULL, &made->seen[i]);
        assert_int_equal(made->renderer[i].compute, i);
    }
}

static void free_pictures(pair *p, pictures *made)
{
    for (int i = 0; i < 2; i++) {
        glbk_ism_renderer_free(&p->gl[i], &made->renderer[i]);
        glbk_gbuffer_free(&p->gl[i], &made->seen[i]);
    }
}

/* By the maps of the other path, which are the same. Sums are made in the same order: the pictures differ by nothing.
   Light before the blur and after it. */
static void compare_light(gl_test *t, pair *p, pictures *of, const ism_shading *shading)
{
    static float light[2][2][4 * PIXELS];
    const size_t words = 4 * PIXELS;
    size_t lit = 0, dark = 0, off[2];
    for (int i = 0; i < 2; i++) {
        glbk_ism_renderer *r = &of->renderer[i];
        assert_glbk(t, glbk_ism_shade(&p->gl[i], r, &of->seen[i], &p->maps[!i], shading, 0));
        assert_glbk(t, glbk_target_read(&p->gl[i], &r->light_target, 0, 0, 0, WIDTH, HEIGHT, light[i][0]));
        assert_glbk(t, glbk_target_read(&p->gl[i], &r->result_target, 0, 0, 0, WIDTH, HEIGHT, light[i][1]));
    }
    for (int k = 0; k < 2; k++)
        off[k] = differences((const uint32_t *)(const void *)light[0][k], (const uint32_t *)(const void *)light[1][k],
                             words);
    for (size_t i = 0; i < PIXELS; i++) {
        if (i % 29) lit += light[1][1][4 * i] > 0;
        else dark += light[1][1][4 * i] == 0;
    }
    printf("interleave %u, rule %u: %zu pixels lit; words of the light that differ: %zu, blurred: %zu\n",
           shading->interleave, (unsigned)shading->near_mode, lit, off[0], off[1]);
    assert_int_equal(off[0] + off[1], 0);
    assert_true(lit > PIXELS / 2 && dark == (PIXELS + 28) / 29);
}

static void light_of_both_paths_agrees(void **state)
{
    GL_TEST(t, state)
    pair p;
    pictures of;
    pair_open(t, &p);
    for (uint32_t projection = 1; projection < 5; projection += 3) {
        const ism_desc d = sizes(400, 64, 8, (ism_projection)projection, 1);
        make_maps(t, &p, &d, 397);
        compare_maps(t, &p, "maps for light");
        send_near(t, &p, 397, 2999);
        make_pictures(t, &p, &of);
        for (uint32_t pattern = 1; pattern <= 8; pattern *= 2)
            for (uint32_t near_mode = 1; near_mode < 7; near_mode++) {
                ism_shading s;
                memset(&s, 0, sizeof s);
                s.interleave = pattern;
                s.near_mode = (ism_near)near_mode;
                s.clamp = 0.5f;
                s.no_maps = near_mode == 5;
                if (projection == 1 || pattern == near_mode || near_mode == 6) compare_light(t, &p, &of, &s);
            }
        free_pictures(&p, &of);
    }
    pair_close(&p);
}

/* More classes of pixels than VPLs: what has none is dark. */
static void classes_without_vpls_are_dark(void **state)
{
    GL_TEST(t, state)
    const ism_desc d = sizes(8, 64, 8, ISM_PROJECTION_COSINE, 1);
    static float light[4 * PIXELS];
    ism_shading s;
    pair p;
    pictures of;
    size_t wrong = 0;
    memset(&s, 0, sizeof s);
    s.interleave = 8;
    s.near_mode = ISM_NEAR_PATCH;
    s.no_maps = 1;
    pair_open(t, &p);
    make_maps(t, &p, &d, 5);
    make_pictures(t, &p, &of);
    compare_light(t, &p, &of, &s);
    assert_glbk(t, glbk_target_read(&p.gl[1], &of.renderer[1].light_target, 0, 0, 0, WIDTH, HEIGHT, light));
    for (size_t i = 0; i < PIXELS; i++)
        wrong += (i / WIDTH % 8 * 8 + i % WIDTH % 8 >= 5) && light[4 * i] > 0;
    assert_int_equal(wrong, 0);
    free_pictures(&p, &of);
    pair_close(&p);
}

/* Draws of a few surfels: more of them, and the same maps. */
static void bounded_draws_make_the_same_maps(void **state)
{
    GL_TEST(t, state)
    const ism_desc d = sizes(40, 60, 8, ISM_PROJECTION_COSINE, 3);      /* 800 surfels a phase */
    static uint32_t surfels[2][4 * 56 * 56];
    const float range = t->gl.max_point_side;
    pair p;
    int i, quads;
    pair_open(t, &p);
    for (quads = 0; quads < 2; quads++) {
        p.gl[0].max_point_side = quads ? 1 : range;
        make_maps(t, &p, &d, 37);
        assert_int_equal(p.maps[0].quads, quads);
        assert_true(p.maps[0].side == 56);
        compare_maps(t, &p, "maps in one draw a phase");
        for (i = 0; i < 2; i++) {
            gl_count_begin(&p.gl[0]);
            assert_glbk(t, glbk_ism_draw(&p.gl[0], &p.maps[0], i ? 300 : 800));
            assert_int_equal(gl_counted.draws, (i ? 9 : 3) + 4);        /* and holes, pull twice, push */
            gl_count_end(&p.gl[0]);
            assert_glbk(t, glbk_target_read(&p.gl[0], &p.maps[0].plane_target, 0, 0, 0, 56, 56, surfels[i]));
        }
        assert_memory_equal(surfels[0], surfels[1], sizeof surfels[0]);
    }
    pair_close(&p);
}

/* Passes of a few rows of pixels: more of them, and the same light. */
static void bounded_passes_make_the_same_light(void **state)
{
    GL_TEST(t, state)
    const ism_desc d = sizes(40, 60, 8, ISM_PROJECTION_COSINE, 3);
    static float light[2][4 * PIXELS];
    ism_shading s;
    pictures of;
    pair p;
    int i, k;
    memset(&s, 0, sizeof s);
    s.near_mode = ISM_NEAR_PATCH;
    pair_open(t, &p);
    make_maps(t, &p, &d, 37);
    compare_maps(t, &p, "maps");
    make_pictures(t, &p, &of);
    for (s.interleave = 1; s.interleave < 4; s.interleave *= 2)
        for (i = 0; i < 2; i++) {
            glbk_ism_renderer *r = &of.renderer[i];
            for (k = 0; k < 2; k++) {
                gl_count_begin(&p.gl[i]);
                assert_glbk(t, glbk_ism_shade(&p.gl[i], r, &of.seen[i], &p.maps[i], &s, k ? 1 : 0));
                if (k)                                                  /* and the blur */
                    assert_int_equal(gl_counted.draws, (HEIGHT + 16 * s.interleave - 1) / (16 * s.interleave) + 1);
                gl_count_end(&p.gl[i]);
                assert_glbk(t, glbk_ism_read(&p.gl[i], r, light[k]));
            }
            assert_memory_equal(light[0], light[1], sizeof light[0]);
        }
    free_pictures(&p, &of);
    pair_close(&p);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(tiles_of_every_size_agree),
        gl_unit_test(discs_of_many_texels_agree),
        gl_unit_test(noise_is_filled_alike),
        gl_unit_test(nothing_to_draw_leaves_empty_maps),
        gl_unit_test(more_surfels_than_16_bits_take_the_core_path),
        gl_unit_test(light_of_both_paths_agrees),
        gl_unit_test(classes_without_vpls_are_dark),
        gl_unit_test(bounded_draws_make_the_same_maps),
        gl_unit_test(bounded_passes_make_the_same_light)
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE45);
}
