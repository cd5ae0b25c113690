/* views_test - fields whose cubes the caller saw: equal to those of sfield_build_callback and _emitter from the
   same texels; windows, logarithms, frames, spheres, and what is refused. */
#include "shadowfield.h"
#include "util.h"
#include "use.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

enum { SIDE = 8, CELLS = 6 * SIDE * SIDE };

typedef struct viewer { uint32_t bands, channels, calls, stop_at; float bad; size_t most, seen; } viewer;

/* One value over all of a texel, another in each octant of eyes and in each frame. */
static float shown(uint32_t texel, uint32_t channel, float time, const float *eye)
{
    uint32_t at = texel * 7 + channel * 3 + (time > 0) + (eye[0] > 0) + 2u * (eye[1] > 0) + 4u * (eye[2] > 0);
    return (float)(at % 5) / 4;
}

static void show(void *user, float time, const float position[3], const float direction[3], float rgb[3])
{
    uint32_t c;
    for (c = 0; c < ((const viewer *)user)->channels; c++)
        rgb[c] = shown(sfield_cube_find(SIDE, direction), c, time, position);
}

static float table[CELLS][9];           /* of 3 bands */

static int fill_basis(void **state)
{
    uint32_t t;
    (void)state;
    for (t = 0; t < CELLS; t++)
        if (sfield_cube_basis(3, SIDE, t, table[t]) != SFIELD_OK) return -1;
    return 0;
}

static int see(void *user, const sfield_views *views)
{
    viewer *v = (viewer *)user;
    uint32_t n = v->bands * v->bands, c, t, k;
    float *out = views->values;
    size_t i;
    if (++v->calls == v->stop_at) return 1;
    v->most = views->count > v->most ? views->count : v->most;
    v->seen += views->count;
    for (i = 0; i < views->count; i++)
        for (c = 0; c < v->channels; c++, out += n ? n : CELLS)
            for (t = 0; t < CELLS; t++) {
                float a = shown(t, c, views->time, views->eyes + 3 * i);
                if (!n) {
                    out[t] = v->bad != 0 && t == 5 ? v->bad : a;
                    continue;
                }
                for (k = 0; k < n; k++) out[k] += a * table[t][k];
            }
    return 0;
}

static sfield_desc desc_within(sfield_basis basis)
{
    sfield_desc d = small_desc(basis);
    d.shell_count = 2;
    d.position_side = 2;
    d.inner = 0.2f;
    d.outer = 0.9f;                     /* where every texel is asked */
    d.radius = 2;
    d.bands = basis == SFIELD_BASIS_HAAR ? 0 : 3;
    return d;
}

static void views_build_what_directions_build(void **state)
{
    const float p[12] = { 0.3f, 0.9f, -0.2f, -1, -0.3f, 0.2f, 0.01f, 1.7f, 0.4f, -0.8f, -0.8f, 0.8f };
    int i;
    (void)state;
    for (i = 0; i < 6; i++) {           /* harmonics, logarithms with a window, wavelets; the same of sources */
        const int source = i >= 3, haar = i % 3 == 2;
        sfield_desc d = desc_within(haar ? SFIELD_BASIS_HAAR : SFIELD_BASIS_SH);
        sfield_field *f, *g;
        sfield_emitter e;
        sfield_stats stats;
        float a[3 * 4 * CELLS], b[3 * 4 * CELLS];
        viewer v;
        size_t k;
        if (i == 0) d.position_side = 7;            /* 294 points: more than one call a shell */
        if (i % 3 == 1) d.window = 0.1f;
        if (i == 1) d.logarithm = 1;
        if (source) d.frame_count = 2;
        memset(&v, 0, sizeof v);
        v.bands = d.bands;
        v.channels = source ? 3 : 1;
        memset(&e, 0, sizeof e);
        e.kind = SFIELD_EMITTER_CALLBACK;
        e.view_fn = show;
        e.user = &v;
        assert_int_equal(
            source ? sfield_build_emitter(&d, &e, &f, NULL) : sfield_build_callback(&d, show, &v, &f, NULL), SFIELD_OK);
        assert_int_equal(sfield_build_views(&d, source, NULL, see, &v, &g, &stats), SFIELD_OK);
        assert_int_equal(v.most, i ? 24 : 256);
        assert_int_equal(v.seen, i ? (source ? 96 : 48) : 588);
        assert_int_equal(stats.triangles, 0);
        assert_int_equal(sfield_bytes(f), sfield_bytes(g));
        assert_int_equal(sfield_query(f, 4, p, 0.05f, a), SFIELD_OK);
        assert_int_equal(sfield_query(g, 4, p, 0.05f, b), SFIELD_OK);
        for (k = 0; k < 4u * v.channels * (haar ? CELLS : 9u); k++)
            assert_true(fabsf(a[k] - b[k]) < (haar ? 1e-30f : 2e-2f / 255));
        if (haar) {                     /* the same texels, so the same bytes */
            uint8_t *bytes = (uint8_t *)malloc(2 * sfield_bytes(f));
            assert_non_null(bytes);
            assert_int_equal(sfield_write(f, bytes, sfield_bytes(f)), SFIELD_OK);
            assert_int_equal(sfield_write(g, bytes + sfield_bytes(f), sfield_bytes(g)), SFIELD_OK);
            assert_memory_equal(bytes, bytes + sfield_bytes(f), sfield_bytes(f));
            free(bytes);
        }
        assert_true(use_field(g));
        sfield_free(f);
        sfield_free(g);
    }
}

static int see_far_too_much(void *user, const sfield_views *views)
{
    size_t i;
    for (i = 0; i < views->count * *(const size_t *)user; i++) views->values[i] = i % 7 ? 90.0f : -90.0f;
    return 0;
}

/* Forty occluders that multiply what is seen by a hundred each leave no number. The cache keeps 0 in its place. */
static void a_cache_keeps_no_infinity(void **state)
{
    static const float up[3] = { 0, 1, 0 }, origin[3] = { 0, 0, 0 }, white[3] = { 1, 1, 1 };
    int haar, i;
    (void)state;
    for (haar = 0; haar < 2; haar++) {
        sfield_desc d = desc_within(haar ? SFIELD_BASIS_HAAR : SFIELD_BASIS_SH);
        size_t size = haar ? CELLS : 9;
        sfield_entity entities[40];
        sfield_scene_desc desc;
        sfield_scene *scene;
        sfield_points points;
        sfield_cache *cache;
        sfield_field *f;
        float rgb[3] = { -1, -1, -1 };
        d.keep = 1;
        assert_int_equal(sfield_build_views(&d, 0, NULL, see_far_too_much, &size, &f, NULL), SFIELD_OK);
        memset(&desc, 0, sizeof desc);
        desc.basis = d.basis;
        desc.bands = d.bands;
        desc.cube_side = SIDE;
        assert_int_equal(sfield_scene_create(&desc, &scene), SFIELD_OK);
        memset(entities, 0, sizeof entities);
        for (i = 0; i < 40; i++) entities[i].occlusion = f;
        assert_int_equal(sfield_scene_entities(scene, entities, 40), SFIELD_OK);
        assert_int_equal(sfield_scene_environment(scene, white, 1, 1, NULL), SFIELD_OK);
        assert_int_equal(sfield_cache_create(scene, 1, 1, &cache), SFIELD_OK);
        memset(&points, 0, sizeof points);
        points.count = 1;
        points.positions = origin;
        points.normals = up;
        points.rgb = rgb;
        assert_int_equal(sfield_shade(scene, &points, 1, NULL), SFIELD_OK);
        assert_false(use_all_finite(rgb, 3));
        points.cache = cache;
        for (i = 0; i < 2; i++) {           /* when T is kept, and when it is recalled */
            assert_int_equal(sfield_shade(scene, &points, 1, NULL), SFIELD_OK);
            assert_true(use_all_finite(rgb, 3));
        }
        sfield_cache_free(cache);
        sfield_scene_free(scene);
        sfield_free(f);
    }
}

static void shine_beyond_floats(void *user, float time, const float position[3], const float direction[3], float rgb[3])
{
    (void)user;
    (void)time;
    (void)position;
    (void)direction;
    rgb[0] = 3e38f;
    rgb[1] = INFINITY;
    rgb[2] = 1;
}

/* Radiance above 1e18 counts as 1e18, so that the sums of a texel are numbers, and the file can be opened. */
static void a_callback_may_shine_as_it_likes(void **state)
{
    int haar;
    (void)state;
    for (haar = 0; haar < 2; haar++) {
        sfield_desc d = desc_within(haar ? SFIELD_BASIS_HAAR : SFIELD_BASIS_SH);
        sfield_emitter e;
        sfield_field *f, *again;
        uint8_t *bytes;
        memset(&e, 0, sizeof e);
        e.kind = SFIELD_EMITTER_CALLBACK;
        e.view_fn = shine_beyond_floats;
        assert_int_equal(sfield_build_emitter(&d, &e, &f, NULL), SFIELD_OK);
        assert_true(use_field(f));
        bytes = (uint8_t *)malloc(sfield_bytes(f));
        assert_non_null(bytes);
        assert_int_equal(sfield_write(f, bytes, sfield_bytes(f)), SFIELD_OK);
        assert_int_equal(sfield_open(bytes, sfield_bytes(f), NULL, &again), SFIELD_OK);
        free(bytes);
        sfield_free(again);
        sfield_free(f);
    }
}

/* The mesh gives its spheres, as in sfield_build. */
static void a_mesh_gives_views_its_spheres(void **state)
{
    model m = model_box(1, 2, 1);
    sfield_mesh mesh = mesh_of(&m);
    sfield_desc d = desc_within(SFIELD_BASIS_SH);
    sfield_field *f, *g;
    sfield_info a, b;
    sfield_stats stats;
    viewer v;
    int k;
    (void)state;
    d.radius = 0;
    for (k = 0; k < 24; k++) m.p[k] += 0.25f;
    memset(&v, 0, sizeof v);
    v.bands = 3;
    v.channels = 1;
    assert_int_equal(sfield_build(&d, &mesh, &f, NULL), SFIELD_OK);
    assert_int_equal(sfield_build_views(&d, 0, &mesh, see, &v, &g, &stats), SFIELD_OK);
    sfield_get_info(f, &a);
    sfield_get_info(g, &b);
    assert_memory_equal(a.center, b.center, sizeof a.center);
    assert_true(a.radius == b.radius && a.inscribed == b.inscribed && b.inscribed > 0.9f);
    assert_int_equal(stats.triangles, 12);
    sfield_free(g);
    v.channels = 3;
    assert_int_equal(sfield_build_views(&d, 1, &mesh, see, &v, &g, NULL), SFIELD_OK);
    sfield_get_info(g, &b);
    assert_true(b.kind == SFIELD_KIND_SOURCE && a.radius == b.radius && b.inscribed == 0);
    sfield_free(f);
    sfield_free(g);
    model_free(&m);
}

/* A cube of half side 1, by rays through the middles of texels. What was asked outside of it after inside
   is counted. */
typedef struct in_box { uint32_t inside, after, wrong; } in_box;

static int sees_box(const float *eye, const double *d)
{
    double from = 0, to = 1e9;
    int k;
    for (k = 0; k < 3; k++) {
        double a = (-1 - (double)eye[k]) / d[k], b = (1 - (double)eye[k]) / d[k];
        from = fmax(from, fmin(a, b));
        to = fmin(to, fmax(a, b));
    }
    return from < to;
}

static int see_box(void *user, const sfield_views *views)
{
    in_box *box = (in_box *)user;
    size_t i;
    uint32_t t, k;
    for (i = 0; i < views->count; i++) {
        const float *e = views->eyes + 3 * i, n = e[0] * e[0] + e[1] * e[1] + e[2] * e[2];
        float eye[3], d[3], most = 0;
        for (k = 0; k < 3; k++) {
            eye[k] = e[k] * views->radius;
            most = fmaxf(most, fabsf(eye[k]));
        }
        if (fabsf(n - 0.16f) > 1e-4f && fabsf(n - 0.48f) > 1e-4f && fabsf(n - 1.44f) > 1e-4f) {      /* on no shell */
            box->after++;
            box->wrong += most < 1 + 0.0005f * views->radius || most > 1 + 0.002f * views->radius;
        } else box->inside += most < 1;
        for (t = 0; t < CELLS; t++) {
            double way[3];
            sfield_cube_texel(SIDE, t, d);
            for (k = 0; k < 3; k++) way[k] = (double)d[k] + 1e-9;
            for (k = 0; sees_box(eye, way) && k < 9; k++) views->values[9 * i + k] += table[t][k];
        }
    }
    return 0;
}

/* Positions inside a mesh are asked again from outside, as many as sfield_build moves. */
static void positions_inside_are_asked_again(void **state)
{
    model m = model_box(1, 1, 1);
    sfield_mesh mesh = mesh_of(&m);
    sfield_desc d = desc_within(SFIELD_BASIS_SH);
    sfield_stats by_mesh, by_views;
    sfield_field *f;
    in_box box;
    (void)state;
    d.radius = 0;
    d.shell_count = 3;
    d.inner = 0.4f;                     /* 0.4, 0.69, 1.2: all of one inside, some of the next */
    d.outer = 1.2f;
    d.position_side = 3;
    assert_int_equal(sfield_build(&d, &mesh, &f, &by_mesh), SFIELD_OK);
    sfield_free(f);
    memset(&box, 0, sizeof box);
    assert_int_equal(sfield_build_views(&d, 0, &mesh, see_box, &box, &f, &by_views), SFIELD_OK);
    sfield_free(f);
    print_message("%u of 162 positions inside, %u asked again\n", box.inside, box.after);
    assert_true(by_mesh.moved > 0 && by_views.moved == by_mesh.moved);
    assert_true(box.inside == by_mesh.moved);
    d.keep_inside = 1;
    memset(&box, 0, sizeof box);
    assert_int_equal(sfield_build_views(&d, 0, &mesh, see_box, &box, &f, &by_views), SFIELD_OK);
    sfield_free(f);
    assert_true(by_views.moved == 0 && box.after == 0 && box.inside == by_mesh.moved);
    model_free(&m);
}

static void bad_arguments_of_views_are_refused(void **state)
{
    sfield_desc d = desc_within(SFIELD_BASIS_HAAR);
    sfield_mesh none;
    sfield_field *f = NULL;
    counting c;
    viewer v;
    float y[64];
    size_t calls, k;
    const float bad[4] = { NAN, INFINITY, -INFINITY, 1e30f };
    (void)state;
    memset(&v, 0, sizeof v);
    memset(&none, 0, sizeof none);
    v.channels = 1;
    assert_int_equal(sfield_build_views(&d, 0, NULL, NULL, &v, &f, NULL), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_build_views(&d, 0, NULL, see, &v, NULL, NULL), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_build_views(NULL, 0, NULL, see, &v, &f, NULL), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_build_views(&d, 0, &none, see, &v, &f, NULL), SFIELD_ERR_ARGUMENT);
    d.radius = 0;
    assert_int_equal(sfield_build_views(&d, 0, NULL, see, &v, &f, NULL), SFIELD_ERR_DESC);
    d.radius = 1;
    d.frame_count = 2;                                               /* occluders do not change */
    assert_int_equal(sfield_build_views(&d, 0, NULL, see, &v, &f, NULL), SFIELD_ERR_DESC);
    d.frame_count = 0;
    d.position_side = 7;
    v.calls = 0;
    v.stop_at = 2;                                              /* within a shell */
    memset(&c, 0, sizeof c);
    d.system.allocator = counting_allocator(&c);
    assert_int_equal(sfield_build_views(&d, 0, NULL, see, &v, &f, NULL), SFIELD_ERR_CANCELLED);
    assert_true(v.calls == 2 && f == NULL && c.now == 0);
    v.stop_at = 0;
    d.position_side = 2;
    for (calls = c.fail_at = 1; ; calls = ++c.fail_at) {        /* every allocation fails once */
        sfield_result r;
        c.calls = 0;
        r = sfield_build_views(&d, 0, NULL, see, &v, &f, NULL);
        if (r == SFIELD_OK) break;
        assert_int_equal(r, SFIELD_ERR_ALLOC);
        assert_true(f == NULL && c.now == 0);
    }
    assert_true(calls > 10);
    sfield_free(f);
    c.fail_at = 0;
    for (k = 0; k < 4; k++) {
        v.bad = bad[k];
        assert_int_equal(sfield_build_views(&d, 0, NULL, see, &v, &f, NULL), SFIELD_OK);
        assert_true(use_field(f));
        sfield_free(f);
    }
    assert_int_equal(sfield_cube_basis(0, 8, 0, y), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_cube_basis(9, 8, 0, y), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_cube_basis(4, 6, 0, y), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_cube_basis(4, 8, CELLS, y), SFIELD_ERR_ARGUMENT);
    assert_int_equal(sfield_cube_basis(4, 8, 0, NULL), SFIELD_ERR_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(views_build_what_directions_build),
        cmocka_unit_test(a_cache_keeps_no_infinity),
        cmocka_unit_test(a_callback_may_shine_as_it_likes),
        cmocka_unit_test(a_mesh_gives_views_its_spheres),
        cmocka_unit_test(positions_inside_are_asked_again),
        cmocka_unit_test(bad_arguments_of_views_are_refused)
    };
    return cmocka_run_group_tests(tests, fill_basis, NULL);
}
