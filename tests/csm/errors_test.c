/* errors_test - bad input: a specific error with outputs untouched, or finite
 * results. */

#include "csm.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "util.h"

#define NOT_A_NUMBER NAN
#define INF INFINITY

static model ball;
static cohsm_mesh ball_mesh;
static cohsm_maps *good;                /* lat-long 6 x 6, M 16 */
static char untouched_byte;
#define UNTOUCHED ((void *)&untouched_byte)

static int setup(void **state)
{
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 6, 16);
    (void)state;
    ball = model_sphere(10, 6, 0.1);
    ball_mesh = mesh_of(&ball);
    return cohsm_build(&d, &ball_mesh, &good, NULL) == COHSM_OK ? 0 : -1;
}

static int teardown(void **state)
{
    (void)state;
    cohsm_free(good);
    model_free(&ball);
    return 0;
}

/* Builds; on failure nothing may be written, on success the block must verify and open again. */
static cohsm_result try_build(const cohsm_desc *desc, const cohsm_mesh *mesh, cohsm_stats *stats)
{
    cohsm_desc d;
    cohsm_maps *maps = (cohsm_maps *)UNTOUCHED, *again;
    cohsm_stats s, before;
    cohsm_report report;
    cohsm_result r;
    ledger l;
    memset(&s, 0x31, sizeof s);
    before = s;
    if (desc) d = *desc;
    else memset(&d, 0, sizeof d);
    if (!d.system.allocator.alloc_fn && !d.system.allocator.free_fn) d.system.allocator = ledger_allocator(&l);
    else memset(&l, 0, sizeof l);
    r = cohsm_build(&d, mesh, &maps, &s);
    if (r != COHSM_OK) {
        assert_ptr_equal(maps, UNTOUCHED);
        assert_memory_equal(&s, &before, sizeof s);
    } else {
        size_t size;
        const void *data = cohsm_data(maps, &size);
        void *bytes = malloc(size);
        assert_non_null(data);
        assert_non_null(bytes);
        assert_int_equal(cohsm_write(maps, bytes, size), COHSM_OK);
        assert_int_equal(cohsm_open(bytes, size, NULL, &again), COHSM_OK);
        free(bytes);
        assert_int_equal(cohsm_verify(maps, NULL, mesh, &report), COHSM_OK);
        assert_int_equal(report.wrong, 0);
        cohsm_free(again);
        cohsm_free(maps);
        if (stats) *stats = s;
    }
    if (l.live) fail_msg("result %d, %lu allocations left", (int)r, (unsigned long)l.live);
    return r;
}

/* The same desc for the builder of views. */
static cohsm_result try_create(const cohsm_desc *desc)
{
    cohsm_builder *b = (cohsm_builder *)UNTOUCHED;
    cohsm_desc d = *desc;
    cohsm_result r;
    if (d.radius == 0.0f) d.radius = 1.2f;
    r = cohsm_builder_create(&d, &b);
    if (r == COHSM_OK) cohsm_builder_free(b);
    else if ((void *)b != UNTOUCHED) fail_msg("cohsm_builder_create: result %d, but out is touched", (int)r);
    return r;
}

static void refused_so(const cohsm_desc *d, cohsm_result expected, int line)
{
    cohsm_result r = try_build(d, &ball_mesh, NULL), c = try_create(d);
    uint32_t side = 7, size = 9;
    if (r != expected || c != expected) fail_msg("line %d: build %d, builder %d", line, (int)r, (int)c);
    r = cohsm_budget(d, &ball_mesh, 100000, &side, &size);      /* chooses side and map_side itself */
    if (r != COHSM_OK && (side != 7 || size != 9)) fail_msg("line %d: cohsm_budget touches its outputs", line);
}

static void refused(const cohsm_desc *d, int line) { refused_so(d, COHSM_ERR_DESC, line); }

static void accepted(const cohsm_desc *d, int line)
{
    cohsm_result r = try_build(d, &ball_mesh, NULL), c = try_create(d);
    if (r != COHSM_OK || c != COHSM_OK) fail_msg("line %d: build %d, builder %d", line, (int)r, (int)c);
}

#define REFUSED(change) do { cohsm_desc d = base; change; refused(&d, __LINE__); } while (0)
#define ACCEPTED(change) do { cohsm_desc d = base; change; accepted(&d, __LINE__); } while (0)

static void descs_out_of_range_are_refused(void **state)
{
    cohsm_desc base = desc_of(COHSM_DOMAIN_LATLONG, 3, 8);
    const float odd[3] = { NOT_A_NUMBER, INF, -INF };
    int i, c;
    (void)state;
    REFUSED(d.map_side = 3);
    REFUSED(d.map_side = 1);
    REFUSED(d.map_side = 1025);
    REFUSED(d.map_side = UINT32_MAX);
    REFUSED(d.depth_bits = 3);
    REFUSED(d.depth_bits = 9);
    REFUSED(d.domain.side[0] = 4097);
    REFUSED(d.domain.side[1] = UINT32_MAX);
    REFUSED(d.domain.side[2] = 2);
    REFUSED(d.domain.kind = COHSM_DOMAIN_COUNT);
    REFUSED(d.domain.kind = (cohsm_domain_kind)1000);
    REFUSED(d.layers = COHSM_LAYERS_COUNT);
    REFUSED(d.order = COHSM_ORDER_COUNT);
    REFUSED(d.orientation = COHSM_ORIENTATION_COUNT);
    REFUSED(d.radius = -1);
    for (i = 0; i < 3; i++) {
        REFUSED(d.radius = odd[i]);
        for (c = 0; c < 3; c++) REFUSED(d.center[c] = odd[i]; d.radius = 2);
    }
    REFUSED(d.radius = 1e-20f);
    REFUSED(d.radius = 1e-42f);
    REFUSED(d.pixel_begin = 5);
    REFUSED(d.pixel_begin = 5; d.pixel_end = 5);
    REFUSED(d.pixel_begin = 6; d.pixel_end = 5);
    REFUSED(d.pixel_end = 65);
    REFUSED(d.system.allocator.alloc_fn = ledger_alloc);
    REFUSED(d.system.allocator.free_fn = ledger_free);
    REFUSED(d.domain.kind = COHSM_DOMAIN_OCTAHEDRAL; d.domain.side[1] = 4);
    REFUSED(d.domain.kind = COHSM_DOMAIN_LINE);
    ACCEPTED(d.domain.side[0] = d.domain.side[1] = 1);
    ACCEPTED(d.domain.side[0] = 1; d.domain.side[1] = 7);
    ACCEPTED(d.map_side = 4);
    ACCEPTED(d.map_side = 13);
    ACCEPTED(d.self_only = -5);
    ACCEPTED(d.pixel_begin = 63; d.pixel_end = 64);
    ACCEPTED(d.radius = 2; d.center[0] = 0.1f);
    ACCEPTED(d.domain.kind = COHSM_DOMAIN_DEFAULT);
    REFUSED(d.open_thickness = -1);
    for (i = 0; i < 3; i++) {
        if (i != 1) REFUSED(d.open_thickness = odd[i]);
        ACCEPTED(d.orientation = (cohsm_orientation)(1 + i));
    }
    ACCEPTED(d.open_thickness = INF);                           /* no more than the map is wide */
}

/* What zeros stand for, and in which dimensions a table lies; a builder says so without a view. */
static void zeros_of_a_domain_are_its_defaults(void **state)
{
    static const struct { cohsm_domain_kind kind; uint32_t side[3], views; } cases[] = {
        { COHSM_DOMAIN_DEFAULT, { 0, 0, 0 }, 128 * 128 },  { COHSM_DOMAIN_LATLONG, { 5, 0, 0 }, 5 * 128 },
        { COHSM_DOMAIN_OCTAHEDRAL, { 0, 0, 1 }, 128 * 128 }, { COHSM_DOMAIN_LINE, { 0, 1, 1 }, 6 * 128 },
        { COHSM_DOMAIN_VOLUME, { 2, 0, 3 }, 6 * 2 * 32 * 3 }, { COHSM_DOMAIN_TABLE, { 6, 0, 0 }, 6 },
        { COHSM_DOMAIN_TABLE, { 3, 2, 0 }, 6 },            { COHSM_DOMAIN_TABLE, { 1, 2, 3 }, 6 },
        { COHSM_DOMAIN_TABLE, { 0, 6, 1 }, 6 },
    };
    const float where[6][4] = { { 0, 1, 0, 0 },  { 1, 0, 0, 0 },  { 0, 0, 5, 0 },
                                { -1, 0, 0, 0 }, { 0, -1, 0, 0 }, { 1, 1, 0, 0 } };
    size_t i;
    (void)state;
    for (i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        cohsm_desc d = desc_of(cases[i].kind, 1, 4);
        cohsm_builder *b;
        place_domain(&d, -1, 2, -1, 2);
        memcpy(d.domain.side, cases[i].side, sizeof d.domain.side);
        if (cases[i].kind == COHSM_DOMAIN_TABLE) {
            d.domain.locations = where[0];
            d.domain.location_count = 6;
        }
        d.radius = 1;
        d.orientation = (cohsm_orientation)(i % COHSM_ORIENTATION_COUNT);
        assert_int_equal(cohsm_builder_create(&d, &b), COHSM_OK);
        if (cohsm_builder_view_count(b) != cases[i].views)
            fail_msg("case %lu: %lu views", (unsigned long)i, (unsigned long)cohsm_builder_view_count(b));
        cohsm_builder_free(b);
    }
}

static void domains_of_no_extent_or_not_finite_are_refused(void **state)
{
    static const cohsm_domain_kind kinds[5] = { COHSM_DOMAIN_LINE, COHSM_DOMAIN_RECTANGLE, COHSM_DOMAIN_DISC,
                                                COHSM_DOMAIN_SPHERE, COHSM_DOMAIN_VOLUME };
    const float odd[5] = { NOT_A_NUMBER, INF, -INF, 1e38f, -3e38f };
    int k, i, c;
    (void)state;
    for (k = 0; k < 5; k++) {
        cohsm_desc base = desc_of(kinds[k], 2, 8);
        place_domain(&base, -1, 2, -1, 2);
        ACCEPTED(d.map_side = 8);
        REFUSED(memset(d.domain.u, 0, sizeof d.domain.u));
        if (kinds[k] != COHSM_DOMAIN_LINE && kinds[k] != COHSM_DOMAIN_SPHERE) {
            REFUSED(memset(d.domain.v, 0, sizeof d.domain.v));
            REFUSED(memcpy(d.domain.v, d.domain.u, sizeof d.domain.v));
        }
        if (kinds[k] == COHSM_DOMAIN_VOLUME) REFUSED(memcpy(d.domain.w, d.domain.u, sizeof d.domain.w));
        for (i = 0; i < 5; i++)
            for (c = 0; c < 3; c++) {
                REFUSED(d.domain.origin[c] = odd[i]);
                if (i < 3) REFUSED(d.domain.u[c] = odd[i]);
                if (i < 3) REFUSED(d.domain.v[c] = odd[i]);
                if (i < 3) REFUSED(d.domain.w[c] = odd[i]);
            }
        ACCEPTED(place_domain(&d, 0, 0, 0, 0.01f));             /* inside the object */
        ACCEPTED(place_domain(&d, 0, 1, 0, 0.5f));              /* on its surface */
        ACCEPTED(place_domain(&d, 1e6f, 1e6f, 0, 1e3f));        /* far away */
        ACCEPTED(place_domain(&d, 2, 2, 2, 1e-6f));             /* tiny */
    }
}

static void lists_and_tables_that_cannot_be_are_refused(void **state)
{
    float where[6][4] = { { 0, 1, 0, 0 },  { 1, 0, 0, 0 },  { 0, 0, 5, 0 },
                          { -1, 0, 0, 0 }, { 0, -1, 0, 0 }, { 1e-30f, 0, 0, 0 } };
    const float odd[3] = { NOT_A_NUMBER, INF, -INF };
    int kind, i, c;
    (void)state;
    for (kind = COHSM_DOMAIN_TABLE; kind <= COHSM_DOMAIN_LIST; kind++) {
        cohsm_desc base = desc_of((cohsm_domain_kind)kind, 0, 8);
        base.domain.side[0] = kind == COHSM_DOMAIN_TABLE ? 3 : 0;
        base.domain.side[1] = kind == COHSM_DOMAIN_TABLE ? 2 : 0;
        base.domain.locations = where[0];
        base.domain.location_count = 6;
        ACCEPTED(d.order = COHSM_ORDER_ZIGZAG);
        ACCEPTED(d.order = COHSM_ORDER_DEFAULT);
        REFUSED(d.domain.locations = NULL);
        REFUSED(d.domain.location_count = 0);
        REFUSED(d.domain.location_count = SIZE_MAX);
        REFUSED(d.domain.location_count = (1u << 24) + 1u);
        if (kind == COHSM_DOMAIN_TABLE) {
            REFUSED(d.domain.location_count = 5);
            REFUSED(d.domain.side[0] = UINT32_MAX);
            REFUSED(d.domain.side[0] = d.domain.side[1] = d.domain.side[2] = 65536);
        }
        for (i = 0; i < 3; i++)
            for (c = 0; c < 4; c++) {
                float keep = where[4][c];
                where[4][c] = odd[i];
                refused_so(&base, COHSM_ERR_INPUT, __LINE__);
                where[4][c] = keep;
            }
        where[2][3] = 1;                                        /* w mixed */
        refused_so(&base, COHSM_ERR_INPUT, __LINE__);
        where[2][3] = 0.5f;
        refused_so(&base, COHSM_ERR_INPUT, __LINE__);
        where[2][3] = 0;
        memset(where[3], 0, 16);                                /* no direction */
        refused_so(&base, COHSM_ERR_INPUT, __LINE__);
        where[3][0] = -1;
    }
}

static void keep_message(void *user, const char *message)
{
    char *last = (char *)user;
    assert_int_equal(last[0], 0);                               /* at most once a call */
    snprintf(last, 256, "%s", message);
}

static void messages_name_field_value_and_range(void **state)
{
    char last[256] = "";
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 3, 8), e;
    cohsm_mesh m = ball_mesh;
    uint32_t index[6] = { 0, 1, 2, 0, 9999, 1 };
    (void)state;
    d.system.log = keep_message;
    d.system.user = last;
#define SAYS(desc, mesh, result, text) do { last[0] = 0; \
        assert_int_equal(try_build(&(desc), &(mesh), NULL), result); \
        assert_string_equal(last, text); } while (0)
    e = d; e.map_side = 3;
    SAYS(e, m, COHSM_ERR_DESC, "cohsm_build: desc.map_side is 3; it must be 0, or 4..1024");
    e = d; e.depth_bits = 9;
    SAYS(e, m, COHSM_ERR_DESC, "cohsm_build: desc.depth_bits is 9; it must be 0, or 4..8");
    e = d; e.open_thickness = -0.5f;
    SAYS(e, m, COHSM_ERR_DESC, "cohsm_build: desc.open_thickness is -0.5; it must be 0 or more");
    m.indices = index; m.index_count = 6; m.vertex_count = 80;
    SAYS(d, m, COHSM_ERR_INPUT, "cohsm_build: mesh: index 1 of triangle 1 is 9999, but the mesh has 80 vertices");
    m.index_count = 5;
    SAYS(d, m, COHSM_ERR_ARGUMENT, "cohsm_build: mesh.index_count is 5; it must be a multiple of 3, above 0");
    m = ball_mesh; m.vertex_stride = 13;
    SAYS(d, m, COHSM_ERR_ARGUMENT,
         "cohsm_build: mesh.vertex_stride is 13; it must be 0, or 12 or more and a multiple of 4");
    last[0] = 0;                                                /* what succeeds says nothing */
    assert_int_equal(try_build(&d, &ball_mesh, NULL), COHSM_OK);
    assert_string_equal(last, "");
}

static void short_indices_build_the_same_bytes(void **state)
{
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 4, 8);
    cohsm_mesh m = ball_mesh;
    uint16_t *short_index = (uint16_t *)malloc(ball_mesh.index_count * 2);
    cohsm_maps *maps[2];
    const void *bytes[2];
    size_t size[2], i;
    (void)state;
    assert_non_null(short_index);
    for (i = 0; i < ball_mesh.index_count; i++) short_index[i] = (uint16_t)ball_mesh.indices[i];
    assert_int_equal(cohsm_build(&d, &ball_mesh, &maps[0], NULL), COHSM_OK);
    m.indices16 = short_index;
    assert_int_equal(try_build(&d, &m, NULL), COHSM_ERR_ARGUMENT);      /* both */
    m.indices = NULL;
    assert_int_equal(cohsm_build(&d, &m, &maps[1], NULL), COHSM_OK);
    for (i = 0; i < 2; i++) bytes[i] = cohsm_data(maps[i], &size[i]);
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(bytes[0], bytes[1], size[0]);
    short_index[4] = 60000;
    assert_int_equal(try_build(&d, &m, NULL), COHSM_ERR_INPUT);
    for (i = 0; i < 2; i++) cohsm_free(maps[i]);
    free(short_index);
}

static void a_bias_of_zero_is_one_pixel(void **state)
{
    enum { N = 400 };
    static float p[3 * N], l[3 * N], v[3][N];
    static const float bias[3] = { 0, 1, -1 };
    cohsm_query q = { 0 };
    uint64_t seed = 5;
    int i, k, differ = 0;
    (void)state;
    for (i = 0; i < 3 * N; i++) {
        p[i] = (float)rnd_in(&seed, -1, 1);
        l[i] = (float)rnd_in(&seed, -1, 1);
    }
    q.positions = p;
    q.lights = l;
    q.count = N;
    for (k = 0; k < 3; k++) {
        q.bias = bias[k];
        assert_int_equal(cohsm_visible(good, &q, v[k], NULL), COHSM_OK);
    }
    assert_memory_equal(v[0], v[1], sizeof v[0]);
    for (i = 0; i < N; i++) differ += v[1][i] != v[2][i];
    assert_true(differ > 0);                                    /* below 0: none */
}

static void meshes_that_cannot_be_used_are_refused(void **state)
{
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 3, 8);
    cohsm_mesh m;
    uint32_t bad_index[3] = { 0, 1, 62 };
    float flat[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };
    uint32_t tri[3] = { 0, 1, 2 };
    size_t i;
    (void)state;
    assert_int_equal(try_build(&d, NULL, NULL), COHSM_ERR_ARGUMENT);
    m = ball_mesh; m.positions = NULL;
    assert_int_equal(try_build(&d, &m, NULL), COHSM_ERR_ARGUMENT);
    m = ball_mesh; m.vertex_count = 0;
    assert_int_equal(try_build(&d, &m, NULL), COHSM_ERR_ARGUMENT);
    m = ball_mesh; m.vertex_stride = 8;
    assert_int_equal(try_build(&d, &m, NULL), COHSM_ERR_ARGUMENT);
    m = ball_mesh; m.vertex_stride = 13;
    assert_int_equal(try_build(&d, &m, NULL), COHSM_ERR_ARGUMENT);
    m = ball_mesh; m.index_count = 0;
    assert_int_equal(try_build(&d, &m, NULL), COHSM_ERR_ARGUMENT);
    m = ball_mesh; m.index_count = 4;
    assert_int_equal(try_build(&d, &m, NULL), COHSM_ERR_ARGUMENT);
    m = ball_mesh; m.indices = NULL; m.vertex_count = 8;
    assert_int_equal(try_build(&d, &m, NULL), COHSM_ERR_ARGUMENT);
    m = ball_mesh; m.vertex_count = (size_t)UINT32_MAX;
    assert_int_equal(try_build(&d, &m, NULL), COHSM_ERR_LIMIT);
    m = ball_mesh; m.index_count = (size_t)UINT32_MAX;
    assert_int_equal(try_build(&d, &m, NULL), COHSM_ERR_LIMIT);
    bad_index[2] = (uint32_t)ball.vertices;
    m = ball_mesh; m.indices = bad_index; m.index_count = 3;
    assert_int_equal(try_build(&d, &m, NULL), COHSM_ERR_INPUT);
    bad_index[2] = UINT32_MAX;
    assert_int_equal(try_build(&d, &m, NULL), COHSM_ERR_INPUT);
    /* no usable triangle: two corners equal, not finite, too small or too large to scale */
    memset(&m, 0, sizeof m);
    m.positions = flat; m.vertex_count = 3; m.indices = tri; m.index_count = 3;
    tri[2] = 1;
    assert_int_equal(try_build(&d, &m, NULL), COHSM_ERR_INPUT);
    tri[2] = 2;
    flat[4] = NOT_A_NUMBER;
    assert_int_equal(try_build(&d, &m, NULL), COHSM_ERR_INPUT);
    flat[4] = -INF;
    assert_int_equal(try_build(&d, &m, NULL), COHSM_ERR_INPUT);
    flat[4] = 0;
    for (i = 0; i < 9; i++) flat[i] *= 1e-42f;
    assert_int_equal(try_build(&d, &m, NULL), COHSM_ERR_INPUT);
    for (i = 0; i < 9; i++) flat[i] = i == 3 || i == 7 ? 3e38f : 0;
    assert_int_equal(try_build(&d, &m, NULL), COHSM_ERR_INPUT);
    d.radius = 0.5f;                                            /* the sphere is too small */
    assert_int_equal(try_build(&d, &ball_mesh, NULL), COHSM_ERR_DESC);
}

static void meshes_with_faults_are_used_and_counted(void **state)
{
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 5, 16);
    model soup = model_soup(30, 0.5, 7), big, sliver;
    cohsm_mesh m = mesh_of(&soup);
    cohsm_stats s;
    float *wide;
    uint32_t *index = (uint32_t *)malloc(4 * (90 + 12));
    size_t i, c;
    (void)state;
    assert_non_null(index);
    memcpy(index, soup.i, 360);
    /* doubled faces in either winding, by other indices, a face of no width, one not finite */
    index[90] = 0; index[91] = 1; index[92] = 2;
    index[93] = 2; index[94] = 1; index[95] = 0;
    index[96] = 5; index[97] = 5; index[98] = 6;
    index[99] = 9; index[100] = 10; index[101] = 11;
    soup.p[27] = NOT_A_NUMBER;                                  /* vertex 9: the face 9 10 11 twice */
    m.indices = index;
    m.index_count = 102;
    assert_int_equal(try_build(&d, &m, &s), COHSM_OK);
    assert_int_equal(s.triangles, 29);
    assert_int_equal(s.duplicate_triangles, 2);
    assert_int_equal(s.skipped_triangles, 3);
    assert_true(s.open_entries > 0);
    soup.p[27] = 0;
    free(index);
    /* odd strides, no indices, more bytes between vertices */
    wide = (float *)calloc(90 * 7 + 1, 4);
    assert_non_null(wide);
    for (i = 0; i < 90; i++)
        for (c = 0; c < 3; c++) wide[7 * i + c] = soup.p[3 * i + c];
    m = mesh_of(&soup);
    m.positions = wide;
    m.vertex_stride = 28;
    m.indices = NULL;
    m.index_count = 12345;
    assert_int_equal(try_build(&d, &m, &s), COHSM_OK);
    assert_int_equal(s.triangles, 30);
    free(wide);
    /* far from the origin, huge, tiny, flat, a sliver, a single triangle seen edge on */
    big = model_sphere(10, 6, 0);
    for (i = 0; i < 3 * big.vertices; i++) big.p[i] = big.p[i] * 1e15f + 3e15f;
    m = mesh_of(&big);
    assert_int_equal(try_build(&d, &m, &s), COHSM_OK);
    for (i = 0; i < 3 * big.vertices; i++) big.p[i] = (big.p[i] - 3e15f) * 1e-31f;
    assert_int_equal(try_build(&d, &m, &s), COHSM_OK);
    sliver = model_alloc(4, 2);
    for (i = 0; i < 12; i++) sliver.p[i] = i % 3 == 0 ? (float)i : i % 3 == 1 ? 1e-7f * (float)(i % 2) : 0;
    for (i = 0; i < 6; i++) sliver.i[i] = (uint32_t)(i < 3 ? i : i - 2);
    m = mesh_of(&sliver);
    assert_int_equal(try_build(&d, &m, &s), COHSM_OK);
    for (i = 0; i < 12; i++) sliver.p[i] = 1 + (float)(i % 5) * FLT_EPSILON;
    (void)try_build(&d, &m, &s);                                /* corners one rounding apart */
    model_free(&sliver);
    model_free(&big);
    model_free(&soup);
}

static void builders_out_of_order_or_without_layers_are_refused(void **state)
{
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 2, 4);
    cohsm_builder *b = (cohsm_builder *)UNTOUCHED;
    cohsm_maps *maps = (cohsm_maps *)UNTOUCHED;
    cohsm_view v;
    float z[16], w[16];
    int i, layers;
    (void)state;
    assert_int_equal(cohsm_builder_create(NULL, &b), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_builder_create(&d, NULL), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_builder_create(&d, &b), COHSM_ERR_DESC);             /* a radius is required */
    assert_ptr_equal(b, UNTOUCHED);
    d.radius = 1;
    for (layers = 1; layers <= 2; layers++) {
        d.layers = (cohsm_layers)layers;
        assert_int_equal(cohsm_builder_create(&d, &b), COHSM_OK);
        assert_int_equal(cohsm_builder_view_count(b), 4);
        assert_int_equal(cohsm_builder_view(b, 4, &v), COHSM_ERR_ARGUMENT);
        assert_int_equal(cohsm_builder_view(b, 0, NULL), COHSM_ERR_ARGUMENT);
        for (i = 0; i < 16; i++) z[i] = 0.1f * (float)(i % 7);
        memcpy(w, z, sizeof w);
        assert_int_equal(cohsm_builder_add(b, 0, NULL, z, z), COHSM_ERR_ARGUMENT);
        assert_int_equal(cohsm_builder_add(b, 0, z, NULL, z), COHSM_ERR_ARGUMENT);
        if (layers == 2) assert_int_equal(cohsm_builder_add(b, 0, z, z, NULL), COHSM_ERR_ARGUMENT);
        assert_int_equal(cohsm_builder_add(b, 1, z, z, z), COHSM_ERR_ORDER);
        assert_int_equal(cohsm_builder_finish(b, &maps, NULL), COHSM_ERR_ORDER);
        w[7] = NOT_A_NUMBER;
        assert_int_equal(cohsm_builder_add(b, 0, w, z, z), COHSM_ERR_INPUT);
        assert_int_equal(cohsm_builder_add(b, 0, z, w, z), COHSM_ERR_INPUT);
        w[7] = z[7] - 0.01f;
        assert_int_equal(cohsm_builder_add(b, 0, z, w, z), COHSM_ERR_INPUT);    /* z2 before z1 */
        if (layers == 2) assert_int_equal(cohsm_builder_add(b, 0, z, z, w), COHSM_ERR_INPUT);
        w[7] = INF;
        w[3] = z[3];
        assert_int_equal(cohsm_builder_add(b, 0, z, w, w), COHSM_OK);           /* the view may be given again */
        assert_int_equal(cohsm_builder_add(b, 0, z, z, z), COHSM_ERR_ORDER);
        w[0] = -INF;
        assert_int_equal(cohsm_builder_add(b, 1, w, z, z) == COHSM_OK, w[7] <= z[7]);
        w[7] = z[7];
        w[0] = -3;
        for (i = cohsm_builder_finish(b, &maps, NULL) == COHSM_ERR_ORDER; i < 4; i++) {
            cohsm_result r = cohsm_builder_add(b, (uint32_t)i, z, z, z);
            assert_int_equal(r, COHSM_OK);
        }
        assert_int_equal(cohsm_builder_add(b, 4, z, z, z), COHSM_ERR_ORDER);
        assert_int_equal(cohsm_builder_finish(b, NULL, NULL), COHSM_ERR_ARGUMENT);
        assert_ptr_equal(maps, UNTOUCHED);
        assert_int_equal(cohsm_builder_finish(b, &maps, NULL), COHSM_OK);
        cohsm_free(maps);
        maps = (cohsm_maps *)UNTOUCHED;
        assert_int_equal(cohsm_builder_finish(b, &maps, NULL), COHSM_ERR_ORDER);
        assert_int_equal(cohsm_builder_add(b, 4, z, z, z), COHSM_ERR_ORDER);
        assert_ptr_equal(maps, UNTOUCHED);
        cohsm_builder_free(b);
        b = (cohsm_builder *)UNTOUCHED;
    }
    cohsm_builder_free(NULL);
    assert_int_equal(cohsm_builder_view_count(NULL), 0);
    assert_int_equal(cohsm_builder_view(NULL, 0, &v), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_builder_add(NULL, 0, z, z, z), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_builder_finish(NULL, &maps, NULL), COHSM_ERR_ARGUMENT);
}

static void every_call_refuses_null(void **state)
{
    cohsm_info info;
    cohsm_report report;
    cohsm_maps *maps = (cohsm_maps *)UNTOUCHED;
    const cohsm_maps *none[2] = { NULL, NULL };
    float at[4], v = 5;
    uint16_t depths[256];
    uint8_t bytes[64] = { 0 };
    cohsm_query q = { 0 };
    cohsm_desc half;
    size_t size = 99;
    uint32_t side = 1, m = 2;
    (void)state;
    memset(&half.system, 0, sizeof half);
    half.system.allocator.alloc_fn = ledger_alloc;
    cohsm_free(NULL);
    memset(&info, 0x77, sizeof info);
    cohsm_get_info(NULL, &info);
    assert_int_equal(info.map_side, 0x77777777);
    cohsm_get_info(good, NULL);
    assert_null(cohsm_data(NULL, &size));
    assert_non_null(cohsm_data(good, NULL));
    assert_int_equal(cohsm_build(NULL, &ball_mesh, NULL, NULL), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_location(NULL, 0, at), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_location(good, 36, at), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_location(good, 0, NULL), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_depths(NULL, 0, depths), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_depths(good, 36, depths), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_depths(good, 0, NULL), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_write(NULL, bytes, 64), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_write(good, NULL, 64), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_write(good, bytes, 64), COHSM_ERR_MEMORY);
    assert_int_equal(cohsm_open(NULL, 9, NULL, &maps), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_open(bytes, 64, NULL, NULL), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_open(bytes, 64, &half.system, &maps), COHSM_ERR_DESC);
    assert_int_equal(cohsm_open(bytes, 64, NULL, &maps), COHSM_ERR_FORMAT);
    assert_int_equal(cohsm_open(bytes, 0, NULL, &maps), COHSM_ERR_FORMAT);
    assert_int_equal(cohsm_verify(NULL, NULL, &ball_mesh, &report), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_verify(good, NULL, NULL, &report), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_verify(good, NULL, &ball_mesh, NULL), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_verify(good, &half.system, &ball_mesh, &report), COHSM_ERR_DESC);
    assert_int_equal(cohsm_merge(NULL, 1, NULL, &maps), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_merge(none, 2, NULL, &maps), COHSM_ERR_ARGUMENT);
    none[0] = good;
    assert_int_equal(cohsm_merge(none, 0, NULL, &maps), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_merge(none, 2, NULL, &maps), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_merge(none, 1, NULL, NULL), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_merge(none, 1, &half.system, &maps), COHSM_ERR_DESC);
    assert_int_equal(cohsm_visible(NULL, &q, &v, NULL), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_visible(good, NULL, &v, NULL), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_visible_scene(NULL, 0, NULL, &v, NULL), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_budget(NULL, NULL, 1000, &side, &m), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_budget(NULL, &ball_mesh, 1000000, NULL, &m), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_budget(NULL, &ball_mesh, 1000000, &side, NULL), COHSM_ERR_ARGUMENT);
    assert_int_equal(side, 1);
    assert_int_equal(m, 2);
    assert_ptr_equal(maps, UNTOUCHED);
    assert_true(v == 5);
}

static void queries_that_cannot_be_asked_are_refused(void **state)
{
    float p[6] = { 0, 0, 0, 1, 1, 1 }, l[6] = { 0, 1, 0, 1, 0, 0 }, v[2] = { 5, 5 };
    const float odd[3] = { NOT_A_NUMBER, INF, -INF };
    cohsm_query base = { 0 }, q;
    cohsm_instance inst;
    size_t refused_count = 42, i;
    (void)state;
    base.positions = p;
    base.lights = l;
    base.count = 2;
    memset(&inst, 0, sizeof inst);
    inst.maps = good;
    for (i = 0; i < 16; i += 5) inst.transform[i] = 1;
#define ASKED(result, change) do { q = base; change; \
        assert_int_equal(cohsm_visible(good, &q, v, &refused_count), result); \
        assert_int_equal(cohsm_visible_scene(&inst, 1, &q, v, &refused_count), result); \
        assert_true(v[0] == 5 && v[1] == 5 && refused_count == 42); } while (0)
    ASKED(COHSM_ERR_ARGUMENT, q.positions = NULL);
    ASKED(COHSM_ERR_ARGUMENT, q.lights = NULL);
    ASKED(COHSM_ERR_DESC, q.light_kind = COHSM_LIGHT_COUNT);
    ASKED(COHSM_ERR_DESC, q.filter = COHSM_FILTER_COUNT);
    ASKED(COHSM_ERR_ARGUMENT, q.position_stride = 8);
    ASKED(COHSM_ERR_ARGUMENT, q.position_stride = 14);
    ASKED(COHSM_ERR_ARGUMENT, q.light_stride = 8);
    ASKED(COHSM_ERR_ARGUMENT, q.light_stride = 13);
    for (i = 0; i < 3; i++) ASKED(COHSM_ERR_DESC, q.bias = odd[i]);
    assert_int_equal(cohsm_visible(good, &base, NULL, NULL), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_visible_scene(&inst, 1, &base, NULL, NULL), COHSM_ERR_ARGUMENT);
    assert_int_equal(cohsm_visible_scene(NULL, 1, &base, v, NULL), COHSM_ERR_ARGUMENT);
    /* transforms that are not rigid with one scale */
    for (i = 0; i < 12; i++) {
        float t[16];
        memcpy(t, inst.transform, sizeof t);
        switch (i) {
        case 0: t[0] = 2; break;
        case 1: t[4] = 0.5f; break;
        case 2: t[0] = -1; break;
        case 3: t[3] = 1; break;
        case 4: t[15] = 0; break;
        case 5: t[5] = NOT_A_NUMBER; break;
        case 6: t[12] = INF; break;
        case 7: memset(t, 0, sizeof t); t[15] = 1; break;
        case 8: t[0] = t[5] = t[10] = 1e-15f; t[12] = 1e30f; break;     /* its inverse is not finite */
        case 9: t[0] = t[5] = t[10] = 1e30f; break;
        case 10: t[0] = t[5] = t[10] = 1e-40f; break;
        default: t[10] = 0; break;
        }
        {
            cohsm_instance pair[2];
            pair[0] = inst;
            pair[1] = inst;
            memcpy(pair[1].transform, t, sizeof t);
            if (cohsm_visible_scene(pair, 2, &base, v, &refused_count) != COHSM_ERR_INPUT)
                fail_msg("transform %d", (int)i);
            if (!(v[0] == 5 && v[1] == 5 && refused_count == 42)) fail_msg("transform %d: outputs touched", (int)i);
        }
    }
    /* sixteen zeros are the identity */
    {
        cohsm_instance zeros = { 0 };
        float same[2];
        zeros.maps = good;
        assert_int_equal(cohsm_visible_scene(&inst, 1, &base, same, NULL), COHSM_OK);
        assert_int_equal(cohsm_visible_scene(&zeros, 1, &base, v, NULL), COHSM_OK);
        assert_memory_equal(v, same, sizeof same);
        v[0] = v[1] = 5;
    }
    inst.maps = NULL;
    assert_int_equal(cohsm_visible_scene(&inst, 1, &base, v, &refused_count), COHSM_ERR_ARGUMENT);
    /* nothing asked is nothing done */
    memset(&q, 0, sizeof q);
    assert_int_equal(cohsm_visible(good, &q, NULL, &refused_count), COHSM_OK);
    assert_int_equal(refused_count, 0);
    assert_true(v[0] == 5);
    /* an index beyond the maps is not followed: an unknown light, lit */
    {
        uint32_t index[2] = { 36, UINT32_MAX };
        int filter;
        q = base;
        q.lights = index;
        q.light_kind = COHSM_LIGHT_INDEX;
        for (filter = 0; filter < 3; filter++) {
            q.filter = (cohsm_filter)filter;
            assert_int_equal(cohsm_visible(good, &q, v, NULL), COHSM_OK);
            assert_true(v[0] == 1 && v[1] == 1);
        }
    }
}

static void shards_that_do_not_belong_together_are_refused(void **state)
{
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 4, 8);
    cohsm_maps *a, *b, *c, *other[6], *out = (cohsm_maps *)UNTOUCHED;
    const cohsm_maps *list[3];
    model m = model_sphere(8, 6, 0.3);
    cohsm_mesh mesh = mesh_of(&m);
    int i;
    (void)state;
    d.order = COHSM_ORDER_ZIGZAG;
    d.pixel_end = 20;
    assert_int_equal(cohsm_build(&d, &ball_mesh, &a, NULL), COHSM_OK);
    d.pixel_begin = 20;
    d.pixel_end = 40;
    assert_int_equal(cohsm_build(&d, &ball_mesh, &b, NULL), COHSM_OK);
    d.pixel_begin = 40;
    d.pixel_end = 64;
    assert_int_equal(cohsm_build(&d, &ball_mesh, &c, NULL), COHSM_OK);
    for (i = 0; i < 6; i++) {
        cohsm_desc e = d;
        if (i == 0) e.order = COHSM_ORDER_SCANLINE;
        if (i == 1) e.depth_bits = 7;
        if (i == 2) e.layers = COHSM_LAYERS_Z1Z3_FAR;
        if (i == 3) e.domain.side[0] = 5;
        if (i == 4) e.orientation = COHSM_ORIENTATION_MINIMAL;
        assert_int_equal(cohsm_build(&e, i == 5 ? &mesh : &ball_mesh, &other[i], NULL), COHSM_OK);
        list[0] = a;
        list[1] = b;
        list[2] = other[i];
        assert_int_equal(cohsm_merge(list, 3, NULL, &out), COHSM_ERR_MISMATCH);
        cohsm_free(other[i]);
    }
    list[0] = a; list[1] = c; list[2] = b;
    assert_int_equal(cohsm_merge(list, 3, NULL, &out), COHSM_ERR_MISMATCH);     /* order */
    list[1] = b; list[2] = b;
    assert_int_equal(cohsm_merge(list, 3, NULL, &out), COHSM_ERR_MISMATCH);     /* twice */
    assert_int_equal(cohsm_merge(list, 2, NULL, &out), COHSM_ERR_MISMATCH);     /* the end is missing */
    list[0] = b; list[1] = c;
    assert_int_equal(cohsm_merge(list, 2, NULL, &out), COHSM_ERR_MISMATCH);     /* the beginning */
    assert_ptr_equal(out, UNTOUCHED);
    list[0] = a; list[1] = b; list[2] = c;
    assert_int_equal(cohsm_merge(list, 3, NULL, &out), COHSM_OK);
    cohsm_free(out);
    cohsm_free(a);
    cohsm_free(b);
    cohsm_free(c);
    model_free(&m);
}

static void results_have_texts(void **state)
{
    int i;
    (void)state;
    assert_string_equal(cohsm_result_text(COHSM_OK), "ok");
    for (i = 0; i < COHSM_RESULT_COUNT; i++) {
        assert_non_null(cohsm_result_text((cohsm_result)i));
        assert_string_not_equal(cohsm_result_text((cohsm_result)i), "unknown result");
    }
    assert_string_equal(cohsm_result_text(COHSM_RESULT_COUNT), "unknown result");
    assert_string_equal(cohsm_result_text((cohsm_result)1000), "unknown result");
}

static void a_budget_bounds_what_is_built(void **state)
{
    static const size_t bytes[4] = { 30000, 200000, 1000000, 8000000 };
    cohsm_desc d = desc_of(COHSM_DOMAIN_OCTAHEDRAL, 0, 0);
    model m = model_sphere(24, 14, 0.2);
    cohsm_mesh mesh = mesh_of(&m);
    uint32_t side = 0, size = 0, i, last = 0;
    (void)state;
    d.order = COHSM_ORDER_HILBERT;
    for (i = 0; i < 4; i++) {
        cohsm_maps *maps;
        cohsm_info info;
        cohsm_result r = cohsm_budget(&d, &mesh, bytes[i], &side, &size);
        if (i == 0 && r == COHSM_ERR_LIMIT) continue;
        assert_int_equal(r, COHSM_OK);
        assert_true(side >= 8 && size >= 16);
        assert_true(side * size >= last);
        last = side * size;
        if (side > 80 || size > 128) continue;                  /* keeps this test short */
        d.domain.side[0] = d.domain.side[1] = side;
        d.map_side = size;
        assert_int_equal(cohsm_build(&d, &mesh, &maps, NULL), COHSM_OK);
        cohsm_get_info(maps, &info);
        print_message("budget: %lu bytes: side %u, M %u, block %lu\n", (unsigned long)bytes[i], side, size,
                      (unsigned long)info.bytes);
        assert_true(info.bytes <= bytes[i] + bytes[i] / 10);    /* growth is extrapolated */
        cohsm_free(maps);
        d.domain.side[0] = d.domain.side[1] = d.map_side = 0;
    }
    assert_int_equal(cohsm_budget(&d, &mesh, 100, &side, &size), COHSM_ERR_LIMIT);
    model_free(&m);
}

/* What every block of these sizes has besides its segments: order and, for each 65,536 maps, a word a pixel. */
static void a_budget_counts_the_tables_of_many_maps(void **state)
{
    static const size_t bytes[5] = { 400000, 1000000, 3000000, 10000000, 100000000 };
    cohsm_desc d = desc_of(COHSM_DOMAIN_OCTAHEDRAL, 0, 0);
    uint32_t side, size, i;
    (void)state;
    d.order = COHSM_ORDER_HILBERT;
    for (i = 0; i < 5; i++) {
        double maps, tables;
        assert_int_equal(cohsm_budget(&d, &ball_mesh, bytes[i], &side, &size), COHSM_OK);
        maps = (double)side * side;
        tables = maps * (maps > 65536 ? 4 : 2) + 4.0 * size * size * ceil(maps / 65536);
        if (tables > (double)bytes[i]) fail_msg("side %u, M %u: %.0f of %lu bytes", side, size, tables,
                                                (unsigned long)bytes[i]);
    }
}

/* No desc, and more bytes than the largest block that is ever proposed. */
static void a_budget_without_end_stops_at_the_largest_sizes(void **state)
{
    uint32_t side = 0, size = 0;
    (void)state;
    assert_int_equal(cohsm_budget(NULL, &ball_mesh, SIZE_MAX, &side, &size), COHSM_OK);
    if (sizeof(size_t) == 8) {
        assert_int_equal(side, 3072);
        assert_int_equal(size, 1024);
    } else assert_true(side >= 256 && size >= 256);
}

/* Headers alike: only the table of places tells them apart. */
static void shards_of_other_places_do_not_merge(void **state)
{
    static const float places[2][8] = { { 0, 3, 0, 1, 3, 0, 0, 1 }, { 0, 3, 0, 1, -3, 0, 0, 1 } };
    cohsm_desc d = desc_of(COHSM_DOMAIN_LIST, 0, 8);
    cohsm_maps *shard[3], *out = (cohsm_maps *)UNTOUCHED;
    const cohsm_maps *list[2];
    cohsm_info info[2];
    int i;
    (void)state;
    d.radius = 2;
    d.domain.location_count = 2;
    for (i = 0; i < 3; i++) {
        d.domain.locations = places[i == 2];
        d.pixel_begin = i ? 30 : 0;
        d.pixel_end = i ? 64 : 30;
        assert_int_equal(cohsm_build(&d, &ball_mesh, &shard[i], NULL), COHSM_OK);
    }
    cohsm_get_info(shard[1], &info[0]);
    cohsm_get_info(shard[2], &info[1]);
    assert_true(info[0].depth_far == info[1].depth_far && info[0].radius == info[1].radius);
    list[0] = shard[0];
    list[1] = shard[2];
    assert_int_equal(cohsm_merge(list, 2, NULL, &out), COHSM_ERR_MISMATCH);
    assert_ptr_equal(out, UNTOUCHED);
    list[1] = shard[1];
    assert_int_equal(cohsm_merge(list, 2, NULL, &out), COHSM_OK);
    cohsm_free(out);
    for (i = 0; i < 3; i++) cohsm_free(shard[i]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(descs_out_of_range_are_refused), cmocka_unit_test(zeros_of_a_domain_are_its_defaults),
        cmocka_unit_test(domains_of_no_extent_or_not_finite_are_refused),
        cmocka_unit_test(lists_and_tables_that_cannot_be_are_refused),
        cmocka_unit_test(meshes_that_cannot_be_used_are_refused),
        cmocka_unit_test(messages_name_field_value_and_range),
        cmocka_unit_test(short_indices_build_the_same_bytes),
        cmocka_unit_test(a_bias_of_zero_is_one_pixel),
        cmocka_unit_test(meshes_with_faults_are_used_and_counted),
        cmocka_unit_test(builders_out_of_order_or_without_layers_are_refused),
        cmocka_unit_test(every_call_refuses_null),
        cmocka_unit_test(queries_that_cannot_be_asked_are_refused),
        cmocka_unit_test(shards_that_do_not_belong_together_are_refused),
        cmocka_unit_test(results_have_texts),
        cmocka_unit_test(a_budget_counts_the_tables_of_many_maps),
        cmocka_unit_test(a_budget_bounds_what_is_built),
        cmocka_unit_test(a_budget_without_end_stops_at_the_largest_sizes),
        cmocka_unit_test(shards_of_other_places_do_not_merge),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
