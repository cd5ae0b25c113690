/* errors_test - bad input: a specific error with outputs untouched, or finite
   results. */

#define ENVSH_STATIC
#define ENVSHADOW_IMPLEMENTATION
#include "envlights.h"
#include "envshadow.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "util.h"

#define NOT_A_NUMBER envsh__from_bits(0x7fc00000u)
#define INF envsh__from_bits(0x7f800000u)

static char untouched;
#define UNTOUCHED ((void *)&untouched)
static sky day;
static envlt_lights *good;
static const envlt_light *list;
static uint32_t count;
static envsh_maps *maps;
#define ALL AS_LIGHTS(list, count)
static const envsh_bounds box = { { -1, -1, -1 }, { 1, 1, 1 } };

/* ---- the log ---- */

static char logged[300];
static int log_calls;

static void keep(void *user, const char *message)
{
    assert_ptr_equal(user, &log_calls);
    snprintf(logged, sizeof logged, "%s", message);
    log_calls++;
}

static void expect_log(envsh_result result, envsh_result expected, const char *message)
{
    assert_int_equal(result, expected);
    assert_int_equal(log_calls, 1);
    assert_string_equal(logged, message);
    log_calls = 0;
}

/* The call is refused, and says why in exactly one line, which begins with the function's name. */
#define REFUSES(call, why)                                                                                       \
    do {                                                                                                         \
        log_calls = 0;                                                                                           \
        assert_int_equal(call, why);                                                                             \
        assert_int_equal(log_calls, 1);                                                                          \
        assert_int_equal(strncmp(#call, logged, strcspn(#call, "(")), 0);                                        \
    } while (0)

static int setup(void **state)
{
    envsh_maps_desc d;
    (void)state;
    memset(&d, 0, sizeof d);
    d.map_side = 32;
    d.system.log = keep;
    d.system.user = &log_calls;
    day = sky_alloc(ENVLT_PROJECTION_LATLONG, 32, 16);
    sky_fill(&day, sunny);
    if (envlt_create(NULL, &day.map, &good, NULL) != ENVLT_OK) return -1;
    list = envlt_get_lights(good, &count);
    return envsh_maps_create(&d, count, &maps) == ENVSH_OK ? 0 : -1;
}

static int teardown(void **state)
{
    (void)state;
    envsh_maps_free(maps);
    envlt_free(good);
    sky_free(&day);
    return 0;
}

static void expect_maps(envsh_result expected, uint32_t size, uint32_t guard, uint32_t side, uint32_t capacity)
{
    envsh_maps *m = (envsh_maps *)UNTOUCHED;
    envsh_maps_desc d;
    memset(&d, 0, sizeof d);
    d.map_side = size;
    d.guard = guard;
    d.max_side = side;
    assert_int_equal(envsh_maps_create(&d, capacity, &m), expected);
    if (expected == ENVSH_OK) envsh_maps_free(m);
    else assert_ptr_equal(m, UNTOUCHED);
}

static void atlas_is_checked(void **state)
{
    envsh_maps *m;
    envsh_maps_desc d;
    (void)state;
    expect_maps(ENVSH_ERR_DESC, 15, 0, 0, 1);
    expect_maps(ENVSH_ERR_DESC, 4097, 0, 0, 1);
    expect_maps(ENVSH_ERR_DESC, 64, 17, 0, 1);
    expect_maps(ENVSH_ERR_DESC, 64, 0, 63, 1);
    expect_maps(ENVSH_ERR_DESC, 64, 0, 40000, 1);
    expect_maps(ENVSH_ERR_ARGUMENT, 64, 0, 0, ENVSH_MAX_LIGHTS + 1);
    expect_maps(ENVSH_OK, 64, 16, 64, 3);           /* a page each */
    expect_maps(ENVSH_OK, 0, 0, 0, 0);
    assert_int_equal(envsh_maps_create(NULL, 1, NULL), ENVSH_ERR_ARGUMENT);
    memset(&d, 0, sizeof d);
    d.system.allocator.free_fn = ledger_free;
    assert_int_equal(envsh_maps_create(&d, 1, &m), ENVSH_ERR_DESC);
    memset(&d, 0, sizeof d);
    d.no_depth = 1;
    assert_int_equal(envsh_maps_create(&d, count, &m), ENVSH_OK);
    assert_int_equal(envsh_maps_begin(m, ALL, box), ENVSH_OK);
    assert_int_equal(envsh_maps_end(m), ENVSH_ERR_MISMATCH);
    {
        envsh_query q = { 0 };
        envsh_points r = { 0 };
        envsh_mesh nothing = { NULL, 0, 0, NULL, 0, NULL, NULL, NULL };
        envsh_info before, atlas;
        uint32_t n = 7;
        float depth[32 * 32] = { 0 };
        assert_int_equal(envsh_maps_draw(m, &nothing, NULL), ENVSH_ERR_MISMATCH);   /* there are no maps to draw into */
        assert_int_equal(envsh_maps_set(m, 0, depth, 0), ENVSH_ERR_MISMATCH);
        assert_int_equal(envsh_shade(m, &q, &r, NULL), ENVSH_ERR_MISMATCH);
        memset(&atlas, 0x31, sizeof atlas);
        before = atlas;
        envsh_get_info(NULL, &atlas);
        envsh_get_info(m, NULL);
        assert_memory_equal(&atlas, &before, sizeof atlas);
        assert_null(envsh_views(NULL, &n));
        assert_int_equal(n, 0);
        assert_ptr_equal(envsh_views(m, NULL), envsh_views(m, &n));
        assert_int_equal(n, count);
    }
    envsh_maps_free(m);
    envsh_maps_free(NULL);
    assert_int_equal(envsh_maps_end(NULL), ENVSH_ERR_ARGUMENT);
}

static void drawing_is_checked(void **state)
{
    static const float p[] = { 0, 0, 0,  1, 0, 0,  0, 1, 0 };
    static const uint32_t inside[] = { 0, 1, 2 }, outside[] = { 0, 1, 3 };
    float m[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, depth[32 * 32] = { 0 };
    envsh_mesh mesh = { p, 3, 0, inside, 3, NULL, NULL, NULL };
    envlt_light one = list[0];
    envsh_bounds b = box;
    envsh_maps *fresh;
    (void)state;
    assert_int_equal(envsh_maps_create(NULL, 1, &fresh), ENVSH_OK);
    assert_int_equal(envsh_maps_draw(fresh, &mesh, NULL), ENVSH_ERR_ORDER);
    assert_int_equal(envsh_maps_set(fresh, 0, depth, 0), ENVSH_ERR_ORDER);
    assert_int_equal(envsh_maps_end(fresh), ENVSH_ERR_ORDER);
    assert_int_equal(envsh_maps_begin(fresh, AS_LIGHTS(list, 2), box), ENVSH_ERR_LIMIT);
    assert_int_equal(envsh_maps_begin(fresh, AS_LIGHTS(NULL, 1), box), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_maps_begin(NULL, AS_LIGHTS(list, 1), box), ENVSH_ERR_ARGUMENT);
    envsh_maps_free(fresh);
    one.direction[0] = NOT_A_NUMBER;
    REFUSES(envsh_maps_begin(maps, AS_LIGHTS(&one, 1), box), ENVSH_ERR_INPUT);
    one = list[0];
    for (int c = 0; c < 3; c++) one.direction[c] *= 2;
    REFUSES(envsh_maps_begin(maps, AS_LIGHTS(&one, 1), box), ENVSH_ERR_INPUT);
    one = list[0];
    one.irradiance[2] = INF;
    REFUSES(envsh_maps_begin(maps, AS_LIGHTS(&one, 1), box), ENVSH_ERR_INPUT);
    b.high[1] = NOT_A_NUMBER;
    REFUSES(envsh_maps_begin(maps, ALL, b), ENVSH_ERR_INPUT);
    b = box;
    b.low[2] = -1e16f;
    REFUSES(envsh_maps_begin(maps, ALL, b), ENVSH_ERR_INPUT);
    assert_int_equal(envsh_maps_begin(maps, ALL, envsh_bounds_of(NULL, 0, NULL)), ENVSH_OK);   /* empty */
    assert_int_equal(envsh_maps_begin(maps, ALL, box), ENVSH_OK);
    REFUSES(envsh_maps_draw(maps, NULL, NULL), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_maps_draw(NULL, &mesh, NULL), ENVSH_ERR_ARGUMENT);
    for (int i = 3; i < 16; i += 4) {
        m[i] += 1;
        REFUSES(envsh_maps_draw(maps, &mesh, m), ENVSH_ERR_INPUT);
        m[i] -= 1;
    }
    m[12] = INF;
    REFUSES(envsh_maps_draw(maps, &mesh, m), ENVSH_ERR_INPUT);
    mesh.indices = outside;
    REFUSES(envsh_maps_draw(maps, &mesh, NULL), ENVSH_ERR_INPUT);
    mesh.indices = inside;
    mesh.index_count = 2;
    REFUSES(envsh_maps_draw(maps, &mesh, NULL), ENVSH_ERR_ARGUMENT);
    mesh.index_count = 3;
    mesh.vertex_stride = 10;
    REFUSES(envsh_maps_draw(maps, &mesh, NULL), ENVSH_ERR_ARGUMENT);
    mesh.vertex_stride = 14;
    REFUSES(envsh_maps_draw(maps, &mesh, NULL), ENVSH_ERR_ARGUMENT);
    mesh.vertex_stride = SIZE_MAX & ~(size_t)3;
    REFUSES(envsh_maps_draw(maps, &mesh, NULL), ENVSH_ERR_LIMIT);
    mesh.vertex_stride = 0;
    mesh.positions = NULL;
    REFUSES(envsh_maps_draw(maps, &mesh, NULL), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_maps_set(NULL, 0, depth, 0), ENVSH_ERR_ARGUMENT);
    REFUSES(envsh_maps_set(maps, count, depth, 0), ENVSH_ERR_ARGUMENT);
    REFUSES(envsh_maps_set(maps, 0, NULL, 0), ENVSH_ERR_ARGUMENT);
    REFUSES(envsh_maps_set(maps, 0, depth, 64), ENVSH_ERR_ARGUMENT);
    REFUSES(envsh_maps_set(maps, 0, depth, 130), ENVSH_ERR_ARGUMENT);
}

static void lights_are_checked(void **state)
{
    float direction[8] = { 0, 1, 0, 9, 0.6f, 0.8f, 0, 9 }, irradiance[8] = { 1, 1, 1, 9, 1, 1, 1, 9 };
    float u[8] = { 0.1f, 0, 0, 9, 0, 0, 0.1f, 9 }, v[8] = { 0, 0, 0.1f, 9, 0.1f, 0, 0, 9 };
    const envsh_lights two = { 2, direction, irradiance, u, v, 16 };
    envsh_lights l = two;
    (void)state;
    assert_int_equal(envsh_maps_begin(maps, &l, box), ENVSH_OK);
    l.axes_u = l.axes_v = NULL;                     /* lights without extent */
    assert_int_equal(envsh_maps_begin(maps, &l, box), ENVSH_OK);
    assert_true(envsh_views(maps, NULL)->spread[0] == 0);
    l.axes_u = u;                                   /* half of an extent */
    REFUSES(envsh_maps_begin(maps, &l, box), ENVSH_ERR_ARGUMENT);
    l = two;
    l.directions = NULL;
    REFUSES(envsh_maps_begin(maps, &l, box), ENVSH_ERR_ARGUMENT);
    l = two;
    l.irradiances = NULL;
    REFUSES(envsh_maps_begin(maps, &l, box), ENVSH_ERR_ARGUMENT);
    for (size_t stride = 1; stride < 20; stride++) {
        l = two;
        l.count = 1;
        l.stride = stride;
        assert_int_equal(envsh_maps_begin(maps, &l, box), stride % 4 || stride < 12 ? ENVSH_ERR_ARGUMENT : ENVSH_OK);
    }
    l = two;
    direction[4] = 0.7f;                            /* not a unit vector */
    REFUSES(envsh_maps_begin(maps, &l, box), ENVSH_ERR_INPUT);
    direction[4] = 0.6f;
    irradiance[5] = INF;
    REFUSES(envsh_maps_begin(maps, &l, box), ENVSH_ERR_INPUT);
    irradiance[5] = 1;
    v[4] = 1000;
    REFUSES(envsh_maps_begin(maps, &l, box), ENVSH_ERR_INPUT);
    l.count = 1;                                    /* what is beyond the count is not read */
    assert_int_equal(envsh_maps_begin(maps, &l, box), ENVSH_OK);
    assert_int_equal(envsh_maps_begin(maps, NULL, box), ENVSH_OK);      /* no lights at all */
    assert_int_equal(envsh_maps_end(maps), ENVSH_OK);
    assert_string_equal(envsh_result_text((envsh_result)99), "unknown result");
    assert_string_equal(envsh_result_text(ENVSH_OK), "ok");
}

/* A mesh drawn with a transform, by strides, casts the shadow of one that was moved before; so do its bounds. */
static void transforms_move_meshes(void **state)
{
    static const float p[3][4] = { { -0.5f, 0, -0.5f, 9 }, { 0.5f, 0, -0.5f, 9 }, { 0, 0, 0.75f, 9 } };
    static const float turn[16] = { 0, 0, 0.5f, 0, 0, 0.5f, 0, 0, -0.5f, 0, 0, 0, 0.25f, 0.5f, -0.125f, 1 };
    float moved[3][3];
    envsh_mesh mesh = { p[0], 3, 16, NULL, 0, NULL, NULL, NULL }, still = { moved[0], 3, 0, NULL, 0, NULL, NULL, NULL };
    envsh_bounds a, b;
    envsh_info atlas;
    float *depth;
    (void)state;
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < 3; c++)
            moved[i][c] = turn[c] * p[i][0] + turn[4 + c] * p[i][1] + turn[8 + c] * p[i][2] + turn[12 + c];
    a = envsh_bounds_of(&mesh, 1, turn);
    b = envsh_bounds_of(&still, 1, NULL);
    assert_memory_equal(&a, &b, sizeof a);
    assert_true(a.low[1] >= 0.5f && a.high[1] <= 0.5f && a.high[0] > 0.49f);
    mesh.positions = NULL;                          /* nothing there: as if there were no mesh */
    a = envsh_bounds_of(&mesh, 1, turn);
    assert_true(a.low[0] > a.high[0]);
    mesh.positions = p[0];
    assert_int_equal(envsh_maps_begin(maps, ALL, box), ENVSH_OK);
    assert_int_equal(envsh_maps_draw(maps, &still, NULL), ENVSH_OK);
    envsh_get_info(maps, &atlas);
    const size_t texels = (size_t)atlas.width * atlas.height * atlas.page_count;
    depth = (float *)malloc(texels * sizeof *depth);
    assert_non_null(depth);
    memcpy(depth, atlas.depth, texels * sizeof *depth);
    assert_int_equal(envsh_maps_begin(maps, ALL, box), ENVSH_OK);
    assert_int_equal(envsh_maps_draw(maps, &mesh, turn), ENVSH_OK);
    size_t hit = 0, other = 0;
    for (size_t i = 0; i < texels; i++) {
        hit += depth[i] < 1;
        other += (depth[i] < 1) != (atlas.depth[i] < 1) || fabsf(depth[i] - atlas.depth[i]) > 1e-4f;
    }
    printf("texels %.0f, hit %.0f, other %.0f\n", (double)texels, (double)hit, (double)other);
    assert_true(hit > 400 && other <= hit / 100);              /* a texel on an edge, by rounding */
    free(depth);
}

/* Where texels are wider one way than the other, points move by the wider: with 2 a point under an occluder that is 0.4
   above comes out over it (a quarter of a texel where the light is overhead), with 1 it stays below. */
static void points_move_by_the_wider_side(void **state)
{
    static const float sides[3][2] = { { 2, 1 }, { 1, 2 }, { 1, 1 } };
    const float point[3] = { 0, 0, 0 }, up[3] = { 0, 0, 1 };
    float depth[16];
    envsh_query q = { 0 };
    (void)state;
    q.filter = ENVSH_FILTER_PLAIN;
    for (int i = 0; i < 16; i++) depth[i] = 0.5f - 0.4f / 100;
    for (int i = 0; i < 3; i++) {
        envsh_view v;
        memset(&v, 0, sizeof v);
        v.lookup[3] = v.lookup[7] = 2;
        v.lookup[10] = -1.0f / 100;
        v.lookup[11] = 0.5f;
        v.right[0] = v.up[1] = v.direction[2] = 1;
        v.depth_range = 100;
        memcpy(v.texel, sides[i], sizeof v.texel);
        const envsh_tile tile = { &v, depth, 16, 4, 4 };
        assert_true(envsh_visibility_twin(&tile, &q, point, up, 0) == (i < 2 ? 1.0f : 0.0f));
    }
}

static envsh_result draw_fails(void *user, envsh_maps *m)
{
    (void)m;
    return *(envsh_result *)user;
}

/* Triangles of every bad kind, and bounds of every odd size: light stays finite. */
static void bad_geometry_is_harmless(void **state)
{
    static const float big[] = { 0, 1, 1e-30f, 1e10f, 1e38f, -1e38f };
    float p[9], e[3], n[3] = { 0, 1, 0 }, at[3] = { 0, 0, 0 };
    envsh_mesh mesh = { p, 3, 0, NULL, 0, NULL, NULL, NULL };
    envsh_query q = { 0 };
    envsh_points r = { 0 };
    uint64_t seed = 4;
    (void)state;
    r.positions = at;
    r.normals = n;
    r.count = 1;
    for (int i = 0; i < 400; i++) {
        envsh_bounds b = box;
        for (int k = 0; k < 9; k++) {
            double u = rnd(&seed);
            p[k] = u < 0.1 ? NOT_A_NUMBER : u < 0.2 ? INF : u < 0.6 ? big[(int)(6 * rnd(&seed))]
                                                                    : (float)(2 * rnd(&seed) - 1);
        }
        if (i % 3 == 0) b = envsh_bounds_of(&mesh, 1, NULL);
        if (i % 3 == 1) b.low[i % 2] = b.high[i % 2];           /* flat */
        if (i % 7 == 1) b.low[0] = b.low[1] = b.low[2] = b.high[0] = b.high[1] = b.high[2] = 5;
        assert_int_equal(envsh_maps_begin(maps, ALL, b), ENVSH_OK);
        assert_int_equal(envsh_maps_draw(maps, &mesh, NULL), ENVSH_OK);
        assert_int_equal(envsh_maps_end(maps), ENVSH_OK);
        q.filter = (envsh_filter)(i % ENVSH_FILTER_COUNT);
        q.radius = 2;
        at[0] = i % 11 == 0 ? 1e30f : 0;
        assert_int_equal(envsh_shade(maps, &q, &r, e), ENVSH_OK);
        for (int c = 0; c < 3; c++) assert_true(envsh__finite(e[c]) && e[c] >= 0);
    }
    at[1] = NOT_A_NUMBER;
    assert_int_equal(envsh_shade(maps, &q, &r, e), ENVSH_OK);
    assert_true(e[0] <= 0);
    at[1] = 0;
    n[1] = INF;
    assert_int_equal(envsh_shade(maps, &q, &r, e), ENVSH_OK);
    assert_true(envsh__finite(e[0]));
}

/* Under a roof that covers the whole tile it is dark, however far down: the kernel's half axes stay numbers. */
static void far_below_a_roof_it_is_dark(void **state)
{
    static const float roof[] = { -9, 0.5f, -9, 9, 0.5f, -9, 0, 0.5f, 9 };
    static const float depths[] = { 0.25f, 10, 1e6f, 1e15f, 1e30f, 1e37f, 3e38f };
    envlt_light sun = { { 0, 1, 0 }, { 1, 1, 1 }, 0.1f, { 0.3f, 0, 0 }, { 0, 0, 0.2f }, 0, 0 };
    envsh_mesh mesh = { roof, 3, 0, NULL, 0, NULL, NULL, NULL };
    envsh_query q = { 0 };
    envsh_points r = { 0 };
    (void)state;
    assert_int_equal(envsh_maps_begin(maps, AS_LIGHTS(&sun, 1), box), ENVSH_OK);
    assert_int_equal(envsh_maps_draw(maps, &mesh, NULL), ENVSH_OK);
    assert_int_equal(envsh_maps_end(maps), ENVSH_OK);
    for (size_t i = 0; i < sizeof depths / sizeof depths[0]; i++)
        for (int filter = ENVSH_FILTER_PLAIN; filter < ENVSH_FILTER_COUNT; filter++) {
            float p[3] = { 0, -depths[i], 0 }, n[3] = { 0, 1, 0 }, out[3] = { 7, 7, 7 };
            r.positions = p;
            r.normals = n;
            r.count = 1;
            q.radius = 2;
            q.filter = (envsh_filter)filter;
            assert_int_equal(envsh_shade(maps, &q, &r, out), ENVSH_OK);
            assert_true(out[0] >= 0 && out[0] <= 0);
        }
    sun.axis_u[0] = 1e30f;
    assert_int_equal(envsh_maps_begin(maps, AS_LIGHTS(&sun, 1), box), ENVSH_ERR_INPUT);
}

/* ---- progress ---- */

typedef struct watch { int calls, stop_at; float last; } watch;

static int look(void *user, float fraction)
{
    watch *w = user;
    assert_true(fraction >= w->last && fraction <= 1);
    w->last = fraction;
    return w->calls++ == w->stop_at;
}

static envsh_result draw_twice(void *user, envsh_maps *m)
{
    envsh_result result = envsh_maps_draw(m, user, NULL);
    return result == ENVSH_OK ? envsh_maps_draw(m, user, NULL) : result;
}

/* One fraction from 0 to 1 over all clusters; each of its calls may cancel; what follows is as if nothing had been. */
static void every_call_of_progress_may_cancel(void **state)
{
    static const float corners[] = { -0.5f, 0.2f, -0.5f, 0.5f, 0.2f, -0.5f, 0, 0.2f, 0.5f };
    envsh_mesh mesh = { corners, 3, 0, NULL, 0, NULL, NULL, NULL };
    envsh_query q = { 0 };
    envsh_points r = { 0 };
    envsh_maps_desc d;
    envsh_maps *m;
    watch w = { 0, -1, 0 };
    enum { POINTS = 700, LIGHTS = 14 };         /* five clusters of three, the last of two */
    float points[3 * POINTS], normals[3 * POINTS], plain[3 * POINTS], out[3 * POINTS];
    int all;
    (void)state;
    for (int i = 0; i < POINTS; i++) {
        points[3 * i] = (float)(i % 26) / 13 - 1;
        points[3 * i + 1] = normals[3 * i] = normals[3 * i + 2] = 0;
        points[3 * i + 2] = (float)(i / 26) / 13 - 1;
        normals[3 * i + 1] = 1;
    }
    r.positions = points;
    r.normals = normals;
    r.count = POINTS;
    memset(&d, 0, sizeof d);
    d.map_side = 32;
    assert_int_equal(envsh_maps_create(&d, 3, &m), ENVSH_OK);
    assert_int_equal(envsh_illuminate(m, AS_LIGHTS(list, LIGHTS), box, draw_twice, &mesh, &q, &r, plain), ENVSH_OK);
    envsh_maps_free(m);
    d.system.progress = look;
    d.system.user = &w;
    assert_int_equal(envsh_maps_create(&d, 3, &m), ENVSH_OK);
    assert_int_equal(envsh_illuminate(m, AS_LIGHTS(list, LIGHTS), box, draw_twice, &mesh, &q, &r, out), ENVSH_OK);
    assert_memory_equal(out, plain, sizeof out);
    assert_true(w.last >= 1 && w.last <= 1);
    all = w.calls;
    assert_true(count >= LIGHTS && all > 3 * ((LIGHTS + 2) / 3));
    for (int i = 0; i < all; i++) {
        w.calls = 0;
        w.stop_at = i;
        w.last = 0;
        assert_int_equal(envsh_illuminate(m, AS_LIGHTS(list, LIGHTS), box, draw_twice, &mesh, &q, &r, out),
                         ENVSH_ERR_CANCELLED);
        assert_int_equal(w.calls, i + 1);
    }
    w.stop_at = -1;
    w.last = 0;
    assert_int_equal(envsh_illuminate(m, AS_LIGHTS(list, LIGHTS), box, draw_twice, &mesh, &q, &r, out), ENVSH_OK);
    assert_memory_equal(out, plain, sizeof out);
    for (int i = 0; i < 2; i++) {           /* by themselves they go from 0 to 1 */
        w.last = 0;
        assert_int_equal(i ? envsh_shade(m, &q, &r, out) : envsh_visible(m, 0, &q, &r, out), ENVSH_OK);
        assert_true(w.last >= 1 && w.last <= 1);
    }
    w.last = 0;
    assert_int_equal(envsh_maps_draw(m, &mesh, NULL), ENVSH_OK);
    assert_true(w.last >= 1 && w.last <= 1);
    envsh_maps_free(m);
}

/* One line that names function, field or element, value and range. */
static void failed_calls_say_why(void **state)
{
    static const float p[] = { 0, 0, 0,  1, 0, 0,  0, 1, 0 };
    static const uint16_t wrong[] = { 0, 1, 2, 0, 1, 3 };
    const float short_normals[] = { 0, 1, 0,  0, 0.5f, 0 };
    float e[6];
    envsh_mesh mesh = { p, 3, 0, NULL, 6, wrong, NULL, NULL };
    envsh_points r = { 2, p, 0, short_normals, 0, NULL, 0, 0 };
    envsh_query q = { 0 };
    envlt_light light = list[0];
    envsh_maps_desc d;
    envsh_maps *m;
    (void)state;
    memset(&d, 0, sizeof d);
    d.system.log = keep;
    d.system.user = &log_calls;
    d.map_side = 8;
    log_calls = 0;
    expect_log(envsh_maps_create(&d, 1, &m), ENVSH_ERR_DESC,
               "envsh_maps_create: desc.map_side is 8; it must be 0 (= 256) or 16..4096");
    d.map_side = 16;
    d.clip_depth = (envsh_clip_depth)7;
    expect_log(envsh_maps_create(&d, 1, &m), ENVSH_ERR_DESC,
               "envsh_maps_create: desc.clip_depth is 7; it must be one of envsh_clip_depth");
    d.clip_depth = ENVSH_CLIP_DEPTH_DEFAULT;
    expect_log(envsh_maps_create(&d, ENVSH_MAX_LIGHTS + 1, &m), ENVSH_ERR_ARGUMENT,
               "envsh_maps_create: capacity is 8193; it must be 0..8192");
    expect_log(envsh_maps_create(&d, 1, NULL), ENVSH_ERR_ARGUMENT, "envsh_maps_create: out is NULL");
    d.rows = (envsh_rows)-1;
    assert_int_equal(envsh_maps_create(&d, 1, &m), ENVSH_ERR_DESC);
    d.rows = ENVSH_ROWS_DEFAULT;
    log_calls = 0;
    assert_int_equal(envsh_maps_create(&d, 1, &m), ENVSH_OK);
    expect_log(envsh_maps_end(m), ENVSH_ERR_ORDER, "envsh_maps_end: envsh_maps_begin must come first");
    expect_log(envsh_maps_begin(m, AS_LIGHTS(list, 2), box), ENVSH_ERR_LIMIT,
               "envsh_maps_begin: lights.count is 2; it must be at most 1, the capacity of the maps");
    light.axis_v[1] = 2000;
    light.axis_v[0] = light.axis_v[2] = 0;
    expect_log(envsh_maps_begin(m, AS_LIGHTS(&light, 1), box), ENVSH_ERR_INPUT,
               "envsh_maps_begin: lights.axes_v[0] has the length 2000; it must be below 1000");
    assert_int_equal(envsh_maps_begin(m, AS_LIGHTS(list, 1), box), ENVSH_OK);
    expect_log(envsh_maps_draw(m, &mesh, NULL), ENVSH_ERR_INPUT,
               "envsh_maps_draw: mesh: index 2 of triangle 1 is 3, but the mesh has 3 vertices");
    mesh.index_count = 3;
    assert_int_equal(envsh_maps_draw(m, &mesh, NULL), ENVSH_OK);
    assert_int_equal(envsh_maps_end(m), ENVSH_OK);
    expect_log(envsh_shade(m, NULL, &r, e), ENVSH_ERR_INPUT,
               "envsh_shade: points.normals[1] has the length 0.5; it must be 1 (0.97..1.03), or 0");
    r.count = 1;
    r.geometric_normals = short_normals + 3;
    expect_log(envsh_visible(m, 0, NULL, &r, e), ENVSH_ERR_INPUT,
               "envsh_visible: points.geometric_normals[0] has the length 0.5; it must be 1 (0.97..1.03), or 0");
    r.geometric_normals = NULL;
    expect_log(envsh_visible(m, 1, NULL, &r, e), ENVSH_ERR_ARGUMENT,
               "envsh_visible: light is 1; it must be below 1, the count of the last begin");
    expect_log(envsh_visible(m, 0, NULL, &r, NULL), ENVSH_ERR_ARGUMENT, "envsh_visible: visible is NULL");
    expect_log(envsh_shade(m, NULL, &r, NULL), ENVSH_ERR_ARGUMENT, "envsh_shade: irradiance is NULL");
    q.filter = ENVSH_FILTER_SMOOTH;
    q.radius = 0.25f;
    expect_log(envsh_shade(m, &q, &r, e), ENVSH_ERR_DESC,
               "envsh_shade: query.radius is 0.25; it must be 0 (= 2) or 0.5..8 texels");
    envsh_maps_free(m);
}

static size_t left;                     /* allocations that succeed until the next one fails */

static void *some_memory(size_t bytes, void *user)
{
    (void)user;
    if (!left) return NULL;
    left--;
    return malloc(bytes);
}

static void back(void *memory, void *user)
{
    (void)user;
    free(memory);
}

/* Whichever allocation fails, the log says so, once. */
static void missing_memory_is_told(void **state)
{
    envsh_maps_desc d;
    envsh_maps *m = NULL;
    envsh_result result = ENVSH_ERR_ALLOC;
    size_t most;
    (void)state;
    memset(&d, 0, sizeof d);
    d.map_side = 16;
    d.system.log = keep;
    d.system.user = &log_calls;
    d.system.allocator.alloc_fn = some_memory;
    d.system.allocator.free_fn = back;
    for (most = 0; result != ENVSH_OK; most++) {
        log_calls = 0;
        left = most;
        result = envsh_maps_create(&d, 1, &m);
        if (result != ENVSH_OK)
            expect_log(result, ENVSH_ERR_ALLOC, "envsh_maps_create: system.allocator returned no memory");
    }
    assert_int_equal(most, 5);          /* the object, views, depths, cells; then all of them are there */
    envsh_maps_free(m);
}

static envsh_result never(void *user, envsh_maps *m)
{
    (void)user;
    (void)m;
    fail();
    return ENVSH_OK;
}

/* A light that cannot be used is named by its own number, not by that in its cluster, and before any drawing. */
static void clusters_name_the_light(void **state)
{
    static const float directions[9] = { 0, 1, 0,  1, 0, 0,  0, 0.5f, 0 }, ones[9] = { 1, 1, 1, 1, 1, 1, 1, 1, 1 };
    static const float point[3] = { 0, 0, 0 }, up[3] = { 0, 1, 0 };
    envsh_lights lights = { 3, directions, ones, NULL, NULL, 0 };
    envsh_points r = { 1, point, 0, up, 0, NULL, 0, 0 };
    envsh_maps_desc d;
    envsh_maps *m;
    float e[3] = { 7, 7, 7 };
    (void)state;
    memset(&d, 0, sizeof d);
    d.map_side = 16;
    d.system.log = keep;
    d.system.user = &log_calls;
    log_calls = 0;
    assert_int_equal(envsh_maps_create(&d, 1, &m), ENVSH_OK);
    expect_log(envsh_illuminate(m, &lights, box, never, NULL, NULL, &r, e), ENVSH_ERR_INPUT,
               "envsh_illuminate: lights.directions[2] has the length 0.5; it must be 1 (0.97..1.03)");
    assert_true(e[0] == 7 && e[1] == 7 && e[2] == 7);
    envsh_maps_free(m);
}

/* Zero is the default, negative is none; the values that it stands for give the same bytes. */
static void zero_is_the_default(void **state)
{
    static const envsh_query same[][2] = {
        { { ENVSH_FILTER_DEFAULT, 0, 0, 0, 0, 0, 0 }, { ENVSH_FILTER_PENUMBRA, 16, 12, 1, 1, 0, 0 } },
        { { ENVSH_FILTER_PCF, 0, 0, 0, 0, 0, 0 }, { ENVSH_FILTER_PCF, 16, 2, 1, 1, 0, 0 } },
        { { ENVSH_FILTER_SMOOTH, 0, 0, 0, 0, 0, 0 }, { ENVSH_FILTER_SMOOTH, 3, 2, 1, 7, 0, 0 } },
        { { ENVSH_FILTER_PCF, 0, -1, 0, 0, 0, 0 }, { ENVSH_FILTER_PCF, 1, -9, 1, 0, 0, 0 } },
        { { ENVSH_FILTER_PLAIN, 0, 0, 0, 0, 0, 0 }, { ENVSH_FILTER_PLAIN, 4, 9, 1, 1, 3, 0 } },
    };
    enum { POINTS = 500 };
    static float points[3 * POINTS], normals[3 * POINTS], a[POINTS], b[POINTS];
    static const float p[] = { -0.6f, 0.3f, -0.5f,  0.7f, 0.3f, -0.4f,  0.1f, 0.4f, 0.8f };
    envsh_mesh mesh = { p, 3, 0, NULL, 0, NULL, NULL, NULL };
    envsh_points r = { POINTS, points, 0, normals, 0, NULL, 0, 0 };
    envsh_query none = { ENVSH_FILTER_PENUMBRA, 0, 0, -1, -1, 0, 0 };
    int differ = 0;
    (void)state;
    for (int i = 0; i < POINTS; i++) {
        points[3 * i] = (float)(i % 25) / 13 - 1;
        points[3 * i + 2] = (float)(i / 25) / 11 - 1;
        normals[3 * i + 1] = 1;
    }
    assert_int_equal(envsh_maps_begin(maps, ALL, box), ENVSH_OK);
    assert_int_equal(envsh_maps_draw(maps, &mesh, NULL), ENVSH_OK);
    assert_int_equal(envsh_maps_end(maps), ENVSH_OK);
    for (size_t i = 0; i < sizeof same / sizeof same[0]; i++) {
        assert_int_equal(envsh_visible(maps, 0, &same[i][0], &r, a), ENVSH_OK);
        assert_int_equal(envsh_visible(maps, 0, &same[i][1], &r, b), ENVSH_OK);
        assert_memory_equal(a, b, sizeof a);
    }
    assert_int_equal(envsh_visible(maps, 0, NULL, &r, a), ENVSH_OK);
    assert_int_equal(envsh_visible(maps, 0, &none, &r, b), ENVSH_OK);
    for (int i = 0; i < POINTS; i++) differ += a[i] < b[i] || a[i] > b[i];
    assert_true(differ > 0);                /* without bias and extent it is another picture */
    normals[1] = 0;                         /* no receiver */
    assert_int_equal(envsh_visible(maps, 0, NULL, &r, a), ENVSH_OK);
    assert_true(a[0] >= 0 && a[0] <= 0);
}

/* A mesh with 16-bit indices casts the shadow of one with 32-bit indices; a mesh that has both is refused. */
static void indices_of_16_bits_draw_the_same(void **state)
{
    static const float p[] = { -0.6f, 0.3f, -0.5f,  0.7f, 0.3f, -0.4f,  0.1f, 0.4f, 0.8f,  9, 9, 9 };
    static const uint32_t wide[] = { 2, 0, 1 };
    static const uint16_t narrow[] = { 2, 0, 1 };
    envsh_mesh meshes[2] = { { p, 4, 0, wide, 3, NULL, NULL, NULL }, { p, 4, 0, NULL, 3, narrow, NULL, NULL } };
    float *depth;
    size_t texels, drawn = 0;
    envsh_info info;
    (void)state;
    envsh_get_info(maps, &info);
    texels = (size_t)info.width * info.height * info.page_count;
    depth = (float *)malloc(texels * sizeof *depth);
    assert_non_null(depth);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(envsh_maps_begin(maps, ALL, box), ENVSH_OK);
        assert_int_equal(envsh_maps_draw(maps, &meshes[i], NULL), ENVSH_OK);
        if (i == 0) memcpy(depth, info.depth, texels * sizeof *depth);
    }
    assert_memory_equal(depth, info.depth, texels * sizeof *depth);
    for (size_t i = 0; i < texels; i++) drawn += depth[i] < 1;
    assert_true(drawn > 1000);
    meshes[0].indices16 = narrow;
    REFUSES(envsh_maps_draw(maps, &meshes[0], NULL), ENVSH_ERR_ARGUMENT);
    assert_string_equal(logged, "envsh_maps_draw: mesh.indices, mesh.indices16 are both given");
    free(depth);
}

/* A depth buffer that is reversed is turned round, and NaN in it is no caster. */
static void reversed_depths_are_turned_round(void **state)
{
    static float depth[32 * 32], tile[32 * 32];
    envsh_maps_desc d;
    envsh_maps *m;
    envsh_info info;
    (void)state;
    memset(&d, 0, sizeof d);
    d.map_side = 32;
    d.clip_depth = ENVSH_CLIP_DEPTH_REVERSED;
    assert_int_equal(envsh_maps_create(&d, 1, &m), ENVSH_OK);
    envsh_get_info(m, &info);
    for (int i = 0; i < 32 * 32; i++) {
        const int guard = i % 32 < 4 || i % 32 >= 28 || i / 32 < 4 || i / 32 >= 28;
        tile[i] = (float)(i % 97) / 96;
        depth[i] = guard ? 1 : 1 - tile[i];
    }
    tile[32 * 16 + 16] = NOT_A_NUMBER;
    depth[32 * 16 + 16] = 1;
    assert_int_equal(envsh_maps_begin(m, AS_LIGHTS(list, 1), box), ENVSH_OK);
    assert_int_equal(envsh_maps_set(m, 0, tile, 0), ENVSH_OK);
    for (int i = 0; i < 32 * 32; i++) CLOSE(info.depth[i], depth[i], 1e-6);
    envsh_maps_free(m);
}

/* envsh_illuminate checks all that it can before it has anything drawn, and names itself in the log. */
static void clusters_are_checked_before_drawing(void **state)
{
    static const float direction[3] = { 0, 1, 0 }, point[3] = { 0, 0, 0 };
    const envsh_lights light = { 1, direction, direction, NULL, NULL, 0 };
    envsh_points r = { 1, point, 0, direction, 0, NULL, 0, 0 };
    envsh_bounds far_away = box;
    envsh_maps_desc d;
    envsh_maps *m;
    float e[3];
    (void)state;
    memset(&d, 0, sizeof d);
    d.map_side = 16;
    d.system.log = keep;
    d.system.user = &log_calls;
    d.no_depth = 1;
    far_away.high[1] = 1e16f;
    log_calls = 0;
    expect_log(envsh_illuminate(maps, &light, far_away, never, NULL, NULL, &r, e), ENVSH_ERR_INPUT,
               "envsh_illuminate: bounds.high is 1e16; it must be -1e15..1e15");
    expect_log(envsh_illuminate(maps, &light, box, NULL, NULL, NULL, &r, e), ENVSH_ERR_ARGUMENT,
               "envsh_illuminate: draw_fn is NULL");
    expect_log(envsh_illuminate(maps, &light, box, never, NULL, NULL, &r, NULL), ENVSH_ERR_ARGUMENT,
               "envsh_illuminate: irradiance is NULL");
    assert_int_equal(envsh_maps_create(&d, 1, &m), ENVSH_OK);
    expect_log(envsh_illuminate(m, &light, box, never, NULL, NULL, &r, e), ENVSH_ERR_MISMATCH,
               "envsh_illuminate: maps were made with desc.no_depth: they have no texels");
    envsh_maps_free(m);
    d.no_depth = 0;
    assert_int_equal(envsh_maps_create(&d, 0, &m), ENVSH_OK);
    expect_log(envsh_illuminate(m, &light, box, never, NULL, NULL, &r, e), ENVSH_ERR_LIMIT,
               "envsh_illuminate: capacity is 0: no light has room");
    envsh_maps_free(m);
}

static void queries_are_checked(void **state)
{
    float p[3] = { 0, 0, 0 }, n[3] = { 0, 1, 0 }, out[3] = { 7, 7, 7 };
    envsh_query good_query = { 0 }, q;
    envsh_points good_points = { 0 }, r;
    uint32_t sizes[2] = { 1, 0 };
    double ms[2] = { 1, 1 };
    envsh_cost cost;
    (void)state;
    good_points.positions = p;
    good_points.normals = n;
    good_points.count = 1;
    r = good_points;
    assert_int_equal(envsh_maps_begin(maps, ALL, box), ENVSH_OK);
    REFUSES(envsh_shade(maps, &good_query, &r, out), ENVSH_ERR_ORDER);     /* no end yet */
    assert_int_equal(envsh_maps_end(maps), ENVSH_OK);
#define REFUSED(why, change)                                                                                       \
    do {                                                                                                           \
        q = good_query;                                                                                            \
        r = good_points;                                                                                           \
        change;                                                                                                    \
        REFUSES(envsh_shade(maps, &q, &r, out), why);                                                              \
    } while (0)
    REFUSED(ENVSH_ERR_ARGUMENT, r.positions = NULL);
    REFUSED(ENVSH_ERR_ARGUMENT, r.normals = NULL);
    REFUSED(ENVSH_ERR_ARGUMENT, r.position_stride = 8);
    REFUSED(ENVSH_ERR_ARGUMENT, r.normal_stride = 13);
    REFUSED(ENVSH_ERR_ARGUMENT, r.geometric_normal_stride = 4);
    REFUSED(ENVSH_ERR_DESC, q.filter = (envsh_filter)9);
    REFUSED(ENVSH_ERR_DESC, q.tap_count = ENVSH_MAX_TAPS + 1);
    REFUSED(ENVSH_ERR_DESC, q.radius = 65);
    REFUSED(ENVSH_ERR_DESC, q.radius = NOT_A_NUMBER);
    REFUSED(ENVSH_ERR_DESC, q.bias = INF);
    REFUSED(ENVSH_ERR_DESC, q.bias = NOT_A_NUMBER);
    REFUSED(ENVSH_ERR_DESC, q.extent_scale = INF);
    REFUSED(ENVSH_ERR_DESC, q.filter = ENVSH_FILTER_SMOOTH; q.radius = 0.25f);
    REFUSED(ENVSH_ERR_DESC, q.filter = ENVSH_FILTER_PCF; q.radius = 33);
    r = good_points;
    assert_int_equal(envsh_shade(maps, NULL, &r, out), ENVSH_OK);                   /* all defaults */
    out[0] = 7;
    REFUSES(envsh_shade(maps, &good_query, NULL, out), ENVSH_ERR_ARGUMENT);
    assert_int_equal(envsh_shade(NULL, &good_query, &r, out), ENVSH_ERR_ARGUMENT);
    REFUSES(envsh_shade(maps, &good_query, &r, NULL), ENVSH_ERR_ARGUMENT);
    REFUSES(envsh_visible(maps, count, &good_query, &r, out), ENVSH_ERR_ARGUMENT);
    REFUSES(envsh_visible(maps, ENVLT_NO_LIGHT, &good_query, &r, out), ENVSH_ERR_ARGUMENT);
    REFUSES(envsh_illuminate(maps, ALL, box, NULL, NULL, &good_query, &r, out), ENVSH_ERR_ARGUMENT);
    {
        envsh_result says = ENVSH_ERR_INPUT;
        envsh_maps *none;
        const envsh_query *g = &good_query;
        assert_int_equal(envsh_illuminate(NULL, ALL, box, draw_fails, &says, g, &r, out), ENVSH_ERR_ARGUMENT);
        REFUSES(envsh_illuminate(maps, ALL, box, draw_fails, &says, g, NULL, out), ENVSH_ERR_ARGUMENT);
        assert_int_equal(envsh_illuminate(maps, AS_LIGHTS(NULL, count), box, draw_fails, &says, g, &r, out),
                         ENVSH_ERR_ARGUMENT);
        assert_int_equal(envsh_maps_create(NULL, 0, &none), ENVSH_OK);
        assert_int_equal(envsh_illuminate(none, ALL, box, draw_fails, &says, g, &r, out), ENVSH_ERR_LIMIT);
        envsh_maps_free(none);
        assert_int_equal(envsh_illuminate(maps, ALL, box, draw_fails, &says, g, &r, out), ENVSH_ERR_INPUT);
        assert_true(out[0] >= 7 && out[0] <= 7);
        q = good_query;                                         /* the query is looked at before anything is drawn */
        q.bias = INF;
        REFUSES(envsh_illuminate(maps, ALL, box, draw_fails, &says, &q, &r, out), ENVSH_ERR_DESC);
        REFUSES(envsh_illuminate(maps, ALL, box, draw_fails, &says, g, &r, NULL), ENVSH_ERR_ARGUMENT);
        says = ENVSH_OK;
        assert_true(out[0] >= 7 && out[0] <= 7);
        assert_int_equal(envsh_illuminate(maps, AS_LIGHTS(NULL, 0), box, draw_fails, &says, g, &r, out), ENVSH_OK);
        assert_true(out[0] >= 0 && out[0] <= 0);                /* no lights, no light */
        out[0] = 7;
        assert_int_equal(envsh_maps_begin(maps, ALL, box), ENVSH_OK);
        assert_int_equal(envsh_maps_end(maps), ENVSH_OK);
    }
    assert_true(out[0] >= 7 && out[0] <= 7);
    r.count = 0;
    assert_int_equal(envsh_shade(maps, &good_query, &r, NULL), ENVSH_OK);
    assert_int_equal(envsh_cost_fit(8, sizes, ms, 2, &cost), 0);                /* a cluster of 0 */
    assert_int_equal(envsh_cost_fit(8, NULL, ms, 2, &cost), 0);
    sizes[1] = 4;
    ms[0] = (double)NOT_A_NUMBER;
    assert_int_equal(envsh_cost_fit(8, sizes, ms, 2, &cost), 0);
    assert_int_equal(envsh_cost_cluster(NULL, 8, 8), 1);
    assert_int_equal(envsh_cost_fit(8, sizes, NULL, 2, &cost), 0);
    assert_int_equal(envsh_cost_fit(8, sizes, ms, 2, NULL), 0);
    assert_int_equal(envsh_cost_fit(0, sizes, ms, 2, &cost), 0);
    ms[0] = 1e12;
    assert_int_equal(envsh_cost_fit(8, sizes, ms, 2, &cost), 0);
    cost.pass = cost.slot = 1;
    assert_int_equal(envsh_cost_cluster(&cost, 0, 8), 1);
    assert_int_equal(envsh_cost_cluster(&cost, 8, 0), 1);
    {
        const float tile[64] = { 0 };
        const envsh_view *v = envsh_views(maps, NULL);
        q = good_query;
        q.tap_count = 65;
        const envsh_tile good_tile = { v, tile, 32, 4, 8 }, no_view = { NULL, tile, 32, 4, 8 },
                         no_depth = { v, NULL, 32, 4, 8 };
        const float longer[3] = { 0, 1.1f, 0 };
        assert_true(envsh_visibility_twin(NULL, &good_query, p, n, 0) <= 0);
        assert_true(envsh_visibility_twin(&no_view, &good_query, p, n, 0) <= 0);
        assert_true(envsh_visibility_twin(&no_depth, &good_query, p, n, 0) <= 0);
        assert_true(envsh_visibility_twin(&good_tile, &good_query, NULL, n, 0) <= 0);
        assert_true(envsh_visibility_twin(&good_tile, &good_query, p, NULL, 0) <= 0);
        assert_true(envsh_visibility_twin(&good_tile, &good_query, p, longer, 0) <= 0);
        assert_true(envsh_visibility_twin(&good_tile, &q, p, n, 0) <= 0);
    }
}

/* Times by which passes, or lights, would cost less than nothing: the other of the two explains all, by least squares
   of relative errors. */
static void costs_are_not_negative(void **state)
{
    uint32_t sizes[2] = { 1, 192 };
    double ms[2] = { 100, 150 };
    envsh_cost cost;
    (void)state;
    assert_int_equal(envsh_cost_fit(192, sizes, ms, 2, &cost), 1);
    assert_true(cost.pass >= 0 && cost.pass <= 0);
    assert_true(fabs(cost.slot - (1 / 100.0 + 1 / 150.0) / (192 * (1 / 1e4 + 1 / 22500.0))) < 1e-6);
    sizes[0] = 100;
    ms[0] = 220;
    ms[1] = 100;
    assert_int_equal(envsh_cost_fit(192, sizes, ms, 2, &cost), 1);
    assert_true(cost.slot >= 0 && cost.slot <= 0);
    assert_true(fabs(cost.pass - (2 / 220.0 + 1 / 100.0) / (4 / 48400.0 + 1 / 1e4)) < 1e-6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(atlas_is_checked),
        cmocka_unit_test(drawing_is_checked),
        cmocka_unit_test(lights_are_checked),
        cmocka_unit_test(transforms_move_meshes),
        cmocka_unit_test(points_move_by_the_wider_side),
        cmocka_unit_test(bad_geometry_is_harmless),
        cmocka_unit_test(far_below_a_roof_it_is_dark),
        cmocka_unit_test(every_call_of_progress_may_cancel),
        cmocka_unit_test(failed_calls_say_why),
        cmocka_unit_test(missing_memory_is_told),
        cmocka_unit_test(clusters_name_the_light),
        cmocka_unit_test(zero_is_the_default),
        cmocka_unit_test(clusters_are_checked_before_drawing),
        cmocka_unit_test(indices_of_16_bits_draw_the_same),
        cmocka_unit_test(reversed_depths_are_turned_round),
        cmocka_unit_test(queries_are_checked),
        cmocka_unit_test(costs_are_not_negative),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
