/* log_test - each call of csm.h that is given a system says in its log why it refuses: one line with function, field,
   value and range; one that succeeds says nothing. */

#include "csm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "util.h"

static int lines;
static char last[300];
static model ball;
static cohsm_mesh ball_mesh;
static cohsm_maps *good;                /* 6 x 6 directions, 16 x 16 pixels */

static void keep(void *user, const char *message)
{
    assert_ptr_equal(user, &lines);
    assert_null(strchr(message, '\n'));
    assert_true(strlen(message) < sizeof last);
    lines++;
    strcpy(last, message);
}

static cohsm_system listening(void)
{
    cohsm_system s;
    memset(&s, 0, sizeof s);
    s.log = keep;
    s.user = &lines;
    return s;
}

static void *no_memory(size_t bytes, void *user)
{
    (void)bytes;
    (void)user;
    return NULL;
}

static void no_free(void *memory, void *user)
{
    (void)memory;
    (void)user;
}

static cohsm_system starving(void)
{
    cohsm_system s = listening();
    s.allocator.alloc_fn = no_memory;
    s.allocator.free_fn = no_free;
    return s;
}

static cohsm_system halved(void)
{
    cohsm_system s = listening();
    s.allocator.free_fn = no_free;
    return s;
}

static void said(cohsm_result result, cohsm_result expected, const char *text)
{
    assert_int_equal(result, expected);
    assert_string_equal(last, text);
    assert_int_equal(lines, 1);
    lines = 0;
    last[0] = 0;
}

static cohsm_desc small(void)
{
    cohsm_desc d = desc_of(COHSM_DOMAIN_LATLONG, 6, 16);
    d.system = listening();
    return d;
}

static int setup(void **state)
{
    cohsm_desc d = small();
    (void)state;
    ball = model_sphere(10, 6, 0.1);
    ball_mesh = mesh_of(&ball);
    return cohsm_build(&d, &ball_mesh, &good, NULL) == COHSM_OK && lines == 0 ? 0 : -1;
}

static int teardown(void **state)
{
    (void)state;
    cohsm_free(good);
    model_free(&ball);
    return 0;
}

#define BUILD(change, result, text)                                                     \
    do {                                                                                \
        cohsm_desc d = small();                                                         \
        cohsm_maps *maps;                                                               \
        change;                                                                         \
        said(cohsm_build(&d, &ball_mesh, &maps, NULL), result, "cohsm_build: " text);   \
    } while (0)
#define DESC(change, text) BUILD(change, COHSM_ERR_DESC, text)

static void a_desc_names_field_value_and_range(void **state)
{
    (void)state;
    DESC(d.system = halved(), "desc.system.allocator has one function of the two");
    DESC(d.domain.kind = COHSM_DOMAIN_COUNT, "desc.domain.kind is 10; it must be a COHSM_DOMAIN_...");
    DESC(d.layers = COHSM_LAYERS_COUNT, "desc.layers is 4; it must be a COHSM_LAYERS_...");
    DESC(d.order = COHSM_ORDER_COUNT, "desc.order is 5; it must be a COHSM_ORDER_...");
    DESC(d.orientation = COHSM_ORIENTATION_COUNT, "desc.orientation is 4; it must be a COHSM_ORIENTATION_...");
    DESC(d.open_thickness = -1, "desc.open_thickness is -1; it must be 0 or more");
    DESC(d.map_side = 3, "desc.map_side is 3; it must be 0, or 4..1024");
    DESC(d.depth_bits = 9, "desc.depth_bits is 9; it must be 0, or 4..8");
    DESC(d.radius = -1, "desc.radius is -1; it must be 0 or more, and finite");
    DESC(d.radius = 1e19f, "desc.radius is 1e19; it must be above 1e-18, below 1e18");
    DESC(d.center[1] = HUGE_VALF, "desc.center is infinity; it must be finite");
    DESC(d.radius = 0.01f,
         "desc.radius is 0.01; it must be so large that the sphere about center holds the mesh");
    DESC(d.pixel_end = 257, "desc.pixel_end is 257; it must be above pixel_begin, and map_side^2 or less");
}

/* Of several sides, vectors or locations the one at fault is named. */
static void a_domain_names_the_field_at_fault(void **state)
{
    static const float mixed[8] = { 0, 1, 0, 0, 1, 0, 0, 1 }, half[8] = { 0, 1, 0, 0.5f, 1, 0, 0, 0.5f };
    static const float still[8] = { 0, 1, 0, 0, 0, 0, 0, 0 };
    float endless[8] = { 0, 1, 0, 1, 0, 0, 0, 1 };
    (void)state;
    endless[5] = HUGE_VALF;
    DESC(d.domain.side[0] = 5000, "desc.domain.side[0] is 5000; it must be 0, or 1..4096");
    DESC(d.domain.side[1] = 4097, "desc.domain.side[1] is 4097; it must be 0, or 1..4096");
    DESC(d.domain.side[2] = 3, "desc.domain.side[2] is 3; it must be 0 or 1: the kind has fewer dimensions");
    DESC(d.domain.kind = COHSM_DOMAIN_VOLUME; d.domain.side[0] = d.domain.side[1] = d.domain.side[2] = 4096,
         "desc.domain.side[2] is 4096; it must be less: sides may make 2^24 cells together");
    DESC(d.domain.kind = COHSM_DOMAIN_OCTAHEDRAL; d.domain.side[1] = 16,
         "desc.domain.side[1] is 16; it must be side[0]: an octahedral domain is a square");
    DESC(d.domain.kind = COHSM_DOMAIN_TABLE; d.domain.location_count = 3,
         "desc.domain.location_count is 3; it must be the product of side");
    DESC(d.domain.kind = COHSM_DOMAIN_LIST, "desc.domain.location_count is 0; it must be 1..2^24");
    DESC(d.domain.kind = COHSM_DOMAIN_LIST; d.domain.location_count = 2, "desc.domain.locations is NULL");
    BUILD(d.domain.kind = COHSM_DOMAIN_LIST; d.domain.location_count = 2; d.domain.locations = mixed, COHSM_ERR_INPUT,
          "desc.domain.locations[1] has the w 1; it must be 0 for all or 1 for all");
    BUILD(d.domain.kind = COHSM_DOMAIN_LIST; d.domain.location_count = 2; d.domain.locations = half, COHSM_ERR_INPUT,
          "desc.domain.locations[0] has the w 0.5; it must be 0 for all or 1 for all");
    BUILD(d.domain.kind = COHSM_DOMAIN_LIST; d.domain.location_count = 2; d.domain.locations = still, COHSM_ERR_INPUT,
          "desc.domain.locations[1] has the length 0; it must be more: with w = 0 it is a direction");
    BUILD(d.domain.kind = COHSM_DOMAIN_LIST; d.domain.location_count = 2; d.domain.locations = endless, COHSM_ERR_INPUT,
          "desc.domain.locations[1] has the y infinity; it must be finite");
    DESC(d.domain.kind = COHSM_DOMAIN_RECTANGLE, "desc.domain.u has no length");
    DESC(d.domain.kind = COHSM_DOMAIN_RECTANGLE; d.domain.u[0] = d.domain.v[0] = 1,
         "desc.domain.u and v span no area");
    DESC(d.domain.kind = COHSM_DOMAIN_VOLUME; d.domain.u[0] = d.domain.v[1] = 1,
         "desc.domain.u and v and w span no volume");
    DESC(d.domain.kind = COHSM_DOMAIN_DISC; d.domain.u[0] = d.domain.v[1] = 1; d.domain.origin[2] = endless[5],
         "desc.domain.origin is infinity; it must be finite");
    DESC(d.domain.kind = COHSM_DOMAIN_DISC; d.domain.u[1] = endless[5],
         "desc.domain.u is infinity; it must be finite");
    DESC(d.domain.kind = COHSM_DOMAIN_DISC; d.domain.u[0] = 1; d.domain.v[0] = -endless[5],
         "desc.domain.v is -infinity; it must be finite");
    DESC(d.domain.kind = COHSM_DOMAIN_DISC; d.domain.u[0] = d.domain.v[1] = 1; d.domain.w[2] = endless[5],
         "desc.domain.w is infinity; it must be finite");
}

#define MESH(change, result, text)                                                  \
    do {                                                                            \
        d = small();                                                                \
        m = ball_mesh;                                                              \
        change;                                                                     \
        said(cohsm_build(&d, &m, &maps, NULL), result, "cohsm_build: " text);       \
    } while (0)

static void a_mesh_names_field_value_and_range(void **state)
{
    static const float point[9] = { 1, 1, 1, 1, 1, 1, 1, 1, 1 };
    static const float far_away[9] = { 0, 0, 0, 1e19f, 0, 0, 0, 1e19f, 0 };
    static const uint16_t narrow[3] = { 0, 1, 90 };
    cohsm_desc d;
    cohsm_mesh m;
    cohsm_maps *maps;
    (void)state;
    MESH(m.positions = NULL, COHSM_ERR_ARGUMENT, "mesh.positions is NULL");
    MESH(m.vertex_count = 0, COHSM_ERR_ARGUMENT, "mesh.vertex_count is 0; it must be 1 or more");
    MESH(m.indices16 = narrow, COHSM_ERR_ARGUMENT, "mesh.indices16 is set beside indices");
    MESH(m.vertex_stride = 10, COHSM_ERR_ARGUMENT,
         "mesh.vertex_stride is 10; it must be 0, or 12 or more and a multiple of 4");
    MESH(m.vertex_count = 0x80000000u, COHSM_ERR_LIMIT, "mesh.vertex_count is 2147483648; it must be below 2^31");
    MESH(m.index_count = 0x80000001u, COHSM_ERR_LIMIT, "mesh.index_count is 2147483649; it must be below 2^31");
    MESH(m.index_count = 5, COHSM_ERR_ARGUMENT, "mesh.index_count is 5; it must be a multiple of 3, above 0");
    MESH(m.indices = NULL; m.indices16 = narrow; m.index_count = 3; m.vertex_count = 20, COHSM_ERR_INPUT,
         "mesh: index 2 of triangle 0 is 90, but the mesh has 20 vertices");
    MESH(memset(&m, 0, sizeof m); m.positions = point; m.vertex_count = 3, COHSM_ERR_INPUT,
         "mesh has no triangle that can be used");
    MESH(memset(&m, 0, sizeof m); m.positions = far_away; m.vertex_count = 3, COHSM_ERR_INPUT,
         "the radius of mesh is 7.07114e18; it must be above 1e-18, below 1e18");
    MESH(d.system = starving(), COHSM_ERR_ALLOC, "system.allocator returned no memory");
    d = small();
    said(cohsm_build(&d, NULL, &maps, NULL), COHSM_ERR_ARGUMENT, "cohsm_build: mesh is NULL");
    said(cohsm_build(&d, &ball_mesh, NULL, NULL), COHSM_ERR_ARGUMENT, "cohsm_build: out is NULL");
}

static void a_builder_says_what_it_was_not_given(void **state)
{
    static float near_depth[256], far_depth[256];
    cohsm_desc d = small();
    cohsm_builder *b = NULL;
    cohsm_maps *maps;
    cohsm_view view;
    uint32_t i;
    (void)state;
    said(cohsm_builder_create(&d, NULL), COHSM_ERR_ARGUMENT, "cohsm_builder_create: out is NULL");
    said(cohsm_builder_create(&d, &b), COHSM_ERR_DESC,
         "cohsm_builder_create: desc.radius is 0; it must be above 0, 1e-18..1e18");
    d.radius = 1;
    d.system = starving();
    said(cohsm_builder_create(&d, &b), COHSM_ERR_ALLOC, "cohsm_builder_create: system.allocator returned no memory");
    d.system = listening();
    d.layers = COHSM_LAYERS_Z1Z2;
    assert_int_equal(cohsm_builder_create(&d, &b), COHSM_OK);
    said(cohsm_builder_view(b, 0, NULL), COHSM_ERR_ARGUMENT, "cohsm_builder_view: out is NULL");
    said(cohsm_builder_view(b, 36, &view), COHSM_ERR_ARGUMENT,
         "cohsm_builder_view: index is 36; it must be below 36, the number of views");
    said(cohsm_builder_add(b, 0, NULL, far_depth, NULL), COHSM_ERR_ARGUMENT, "cohsm_builder_add: z1 is NULL");
    said(cohsm_builder_add(b, 0, near_depth, NULL, NULL), COHSM_ERR_ARGUMENT, "cohsm_builder_add: z2 is NULL");
    near_depth[7] = 0.5f;
    said(cohsm_builder_add(b, 0, near_depth, far_depth, NULL), COHSM_ERR_INPUT,
         "cohsm_builder_add: z1[7] is 0.5; it must be at most the depth of the next layer there");
    said(cohsm_builder_finish(b, NULL, NULL), COHSM_ERR_ARGUMENT, "cohsm_builder_finish: out is NULL");
    said(cohsm_builder_add(b, 3, far_depth, far_depth, NULL), COHSM_ERR_ORDER,
         "cohsm_builder_add: index is 3; it must be the number of views that were added before");
    said(cohsm_builder_add(b, 36, far_depth, far_depth, NULL), COHSM_ERR_ORDER,
         "cohsm_builder_add: index is 36; it must be below 36, the number of views");
    said(cohsm_builder_finish(b, &maps, NULL), COHSM_ERR_ORDER,
         "cohsm_builder_finish: the number of views that were added is 0; it must be "
         "cohsm_builder_view_count(builder)");
    for (i = 0; i < 36; i++) assert_int_equal(cohsm_builder_add(b, i, far_depth, far_depth, NULL), COHSM_OK);
    assert_int_equal(cohsm_builder_finish(b, &maps, NULL), COHSM_OK);
    cohsm_free(maps);
    said(cohsm_builder_finish(b, &maps, NULL), COHSM_ERR_ORDER,
         "cohsm_builder_finish: the builder has ended, or failed before");
    said(cohsm_builder_add(b, 0, far_depth, far_depth, NULL), COHSM_ERR_ORDER,
         "cohsm_builder_add: the builder has ended, or failed before");
    cohsm_builder_free(b);
}

static void files_shards_and_budgets_say_why(void **state)
{
    const cohsm_maps *none[2] = { NULL, NULL };
    cohsm_system deaf = listening(), half = halved(), hungry = starving();
    cohsm_desc d = small();
    cohsm_report report;
    cohsm_maps *maps, *part;
    uint32_t side, map_side;
    size_t bytes, packed_bytes, i;
    const void *data = cohsm_data(good, &bytes);
    void *packed;
    model far_ball = model_sphere(10, 6, 0.1);
    cohsm_mesh far_mesh;
    (void)state;
    none[0] = good;
    said(cohsm_open(NULL, 0, &deaf, &maps), COHSM_ERR_ARGUMENT, "cohsm_open: data is NULL");
    said(cohsm_open(data, bytes, &deaf, NULL), COHSM_ERR_ARGUMENT, "cohsm_open: out is NULL");
    said(cohsm_open(data, bytes, &half, &maps), COHSM_ERR_DESC,
         "cohsm_open: system.allocator has one function of the two");
    said(cohsm_open(data, bytes, &hungry, &maps), COHSM_ERR_ALLOC, "cohsm_open: system.allocator returned no memory");
    said(cohsm_pack(NULL, &deaf, &packed, &packed_bytes), COHSM_ERR_ARGUMENT, "cohsm_pack: maps is NULL");
    said(cohsm_pack(good, &deaf, NULL, &packed_bytes), COHSM_ERR_ARGUMENT, "cohsm_pack: data is NULL");
    said(cohsm_pack(good, &deaf, &packed, NULL), COHSM_ERR_ARGUMENT, "cohsm_pack: bytes is NULL");
    said(cohsm_pack(good, &half, &packed, &packed_bytes), COHSM_ERR_DESC,
         "cohsm_pack: system.allocator has one function of the two");
    said(cohsm_pack(good, &hungry, &packed, &packed_bytes), COHSM_ERR_ALLOC,
         "cohsm_pack: system.allocator returned no memory");
    said(cohsm_merge(NULL, 1, &deaf, &maps), COHSM_ERR_ARGUMENT, "cohsm_merge: shards is NULL");
    said(cohsm_merge(none, 0, &deaf, &maps), COHSM_ERR_ARGUMENT, "cohsm_merge: count is 0; it must be 1 or more");
    said(cohsm_merge(none, 1, &deaf, NULL), COHSM_ERR_ARGUMENT, "cohsm_merge: out is NULL");
    said(cohsm_merge(none, 1, &half, &maps), COHSM_ERR_DESC,
         "cohsm_merge: system.allocator has one function of the two");
    said(cohsm_merge(none, 1, &hungry, &maps), COHSM_ERR_ALLOC, "cohsm_merge: system.allocator returned no memory");
    none[1] = good;
    said(cohsm_merge(none, 2, &deaf, &maps), COHSM_ERR_MISMATCH,
         "cohsm_merge: shards[1] begins with pixel 0; it must be where the shard before ends, 0 for the first");
    d.pixel_end = 100;
    assert_int_equal(cohsm_build(&d, &ball_mesh, &part, NULL), COHSM_OK);
    none[0] = part;
    said(cohsm_merge(none, 1, &deaf, &maps), COHSM_ERR_MISMATCH,
         "cohsm_merge: shards[0] ends at pixel 100; it must be map_side^2 for the last");
    cohsm_free(part);
    d = small();
    d.pixel_end = 100;
    d.depth_bits = 7;
    assert_int_equal(cohsm_build(&d, &ball_mesh, &part, NULL), COHSM_OK);
    none[1] = part;
    none[0] = good;
    said(cohsm_merge(none, 2, &deaf, &maps), COHSM_ERR_MISMATCH,
         "cohsm_merge: shards are not all of one desc and mesh");
    cohsm_free(part);
    d = small();
    none[0] = NULL;
    said(cohsm_merge(none, 1, &deaf, &maps), COHSM_ERR_ARGUMENT,
         "cohsm_merge: shards[0] is NULL");
    said(cohsm_verify(NULL, &deaf, &ball_mesh, &report), COHSM_ERR_ARGUMENT, "cohsm_verify: maps is NULL");
    said(cohsm_verify(good, &deaf, NULL, &report), COHSM_ERR_ARGUMENT, "cohsm_verify: mesh is NULL");
    said(cohsm_verify(good, &deaf, &ball_mesh, NULL), COHSM_ERR_ARGUMENT, "cohsm_verify: out is NULL");
    said(cohsm_verify(good, &half, &ball_mesh, &report), COHSM_ERR_DESC,
         "cohsm_verify: system.allocator has one function of the two");
    said(cohsm_verify(good, &hungry, &ball_mesh, &report), COHSM_ERR_ALLOC,
         "cohsm_verify: system.allocator returned no memory");
    for (i = 0; i < far_ball.vertices; i++) far_ball.p[3 * i] += 1;
    far_mesh = mesh_of(&far_ball);
    said(cohsm_verify(good, &deaf, &far_mesh, &report), COHSM_ERR_MISMATCH,
         "cohsm_verify: mesh reaches out of the sphere of the maps");
    model_free(&far_ball);
    said(cohsm_budget(&d, NULL, 1000, &side, &map_side), COHSM_ERR_ARGUMENT, "cohsm_budget: mesh is NULL");
    said(cohsm_budget(&d, &ball_mesh, 1000, NULL, &map_side), COHSM_ERR_ARGUMENT, "cohsm_budget: side is NULL");
    said(cohsm_budget(&d, &ball_mesh, 1000, &side, NULL), COHSM_ERR_ARGUMENT, "cohsm_budget: map_side is NULL");
    said(cohsm_budget(&d, &ball_mesh, 1000, &side, &map_side), COHSM_ERR_LIMIT,
         "cohsm_budget: bytes is 1000; it must be more: not even 64 maps of 16 x 16 pixels fit");
    d.depth_bits = 3;                               /* found by the trial builds, of which nobody needs to know */
    said(cohsm_budget(&d, &ball_mesh, 1000, &side, &map_side), COHSM_ERR_DESC,
         "cohsm_budget: desc.depth_bits is 3; it must be 0, or 4..8");
    d.depth_bits = 0;
    d.domain.kind = COHSM_DOMAIN_LINE;
    said(cohsm_budget(&d, &ball_mesh, 1000, &side, &map_side), COHSM_ERR_DESC,
         "cohsm_budget: desc.domain.kind is 3; it must be LATLONG or OCTAHEDRAL");
    assert_int_equal(cohsm_open(data, bytes, &deaf, &maps), COHSM_OK);
    cohsm_free(maps);
    assert_int_equal(lines, 0);
}

#define QUERY(change, result, text)                                             \
    do {                                                                        \
        memset(&q, 0, sizeof q);                                                \
        q.count = 1;                                                            \
        q.positions = q.lights = point;                                         \
        change;                                                                 \
        said(cohsm_visible(good, &q, &lit, NULL), result, "cohsm_visible: " text);  \
        assert_true(lit == 7);                                                  \
    } while (0)

/* Maps keep the log that they were made with, so that a query, which has no system, is told why it is refused. */
static void a_query_names_field_value_and_range(void **state)
{
    static const float point[4] = { 0, 1, 0, 1 };
    cohsm_desc d = small();
    cohsm_query q;
    cohsm_maps *list;
    float lit = 7;
    (void)state;
    QUERY(q.positions = NULL, COHSM_ERR_ARGUMENT, "query.positions is NULL");
    QUERY(q.lights = NULL, COHSM_ERR_ARGUMENT, "query.lights is NULL");
    QUERY(q.position_stride = 3, COHSM_ERR_ARGUMENT,
          "query.position_stride is 3; it must be 0, or a multiple of 4 with room for one element");
    QUERY(q.light_stride = 8, COHSM_ERR_ARGUMENT,
          "query.light_stride is 8; it must be 0, or a multiple of 4 with room for one element");
    QUERY(q.light_kind = COHSM_LIGHT_COUNT, COHSM_ERR_DESC, "query.light_kind is 4; it must be a COHSM_LIGHT_...");
    QUERY(q.filter = COHSM_FILTER_COUNT, COHSM_ERR_DESC, "query.filter is 3; it must be a COHSM_FILTER_...");
    QUERY(q.bias = HUGE_VALF, COHSM_ERR_DESC, "query.bias is infinity; it must be finite");
    said(cohsm_visible(good, NULL, &lit, NULL), COHSM_ERR_ARGUMENT, "cohsm_visible: query is NULL");
    q.bias = 0;
    said(cohsm_visible(good, &q, NULL, NULL), COHSM_ERR_ARGUMENT, "cohsm_visible: visible is NULL");
    d.domain.kind = COHSM_DOMAIN_LIST;
    d.domain.locations = point;
    d.domain.location_count = 1;
    assert_int_equal(cohsm_build(&d, &ball_mesh, &list, NULL), COHSM_OK);
    q.light_kind = COHSM_LIGHT_PARAMETER;
    said(cohsm_visible(list, &q, &lit, NULL), COHSM_ERR_MISMATCH,
         "cohsm_visible: query.light_kind is 2; it must be COHSM_LIGHT_INDEX: maps of a LIST have no parameters");
    q.light_kind = COHSM_LIGHT_POSITION;
    said(cohsm_visible(list, &q, &lit, NULL), COHSM_ERR_MISMATCH,
         "cohsm_visible: query.light_kind is 1; it must be COHSM_LIGHT_PARAMETER or _INDEX: these are not maps of all "
         "directions");
    cohsm_free(list);
    assert_true(lit == 7);
}

static void a_scene_names_the_instance(void **state)
{
    static const float point[3] = { 0, 1, 0 };
    cohsm_instance two[2];
    cohsm_query q;
    float lit = 7;
    int i;
    (void)state;
    memset(two, 0, sizeof two);
    memset(&q, 0, sizeof q);
    q.count = 1;
    q.positions = q.lights = point;
    for (i = 0; i < 2; i++) {
        two[i].maps = good;
        two[i].transform[0] = two[i].transform[5] = two[i].transform[10] = two[i].transform[15] = 1;
    }
    two[1].transform[0] = 2;
    said(cohsm_visible_scene(two, 2, &q, &lit, NULL), COHSM_ERR_INPUT,
         "cohsm_visible_scene: instances[1] has a transform of the determinant 2; it must be a rotation, one scale > 0 "
         "and a translation");
    two[1].maps = NULL;
    said(cohsm_visible_scene(two, 2, &q, &lit, NULL), COHSM_ERR_ARGUMENT,
         "cohsm_visible_scene: instances[1] has no maps");
    two[1].maps = good;
    two[0].maps = NULL;                                         /* the log is that of the first maps there are */
    said(cohsm_visible_scene(two, 2, &q, &lit, NULL), COHSM_ERR_ARGUMENT,
         "cohsm_visible_scene: instances[0] has no maps");
    two[0].maps = good;
    said(cohsm_visible_scene(two, UINT32_MAX, &q, &lit, NULL), COHSM_ERR_LIMIT,
         "cohsm_visible_scene: instance_count is 4294967295; it must be below 2^32 - 1");
    assert_int_equal(cohsm_visible_scene(NULL, 2, &q, &lit, NULL), COHSM_ERR_ARGUMENT);         /* no log in reach */
    said(cohsm_visible_scene(two, 1, NULL, &lit, NULL), COHSM_ERR_ARGUMENT, "cohsm_visible_scene: query is NULL");
    said(cohsm_visible_scene(two, 1, &q, NULL, NULL), COHSM_ERR_ARGUMENT, "cohsm_visible_scene: visible is NULL");
    q.filter = COHSM_FILTER_COUNT;
    said(cohsm_visible_scene(two, 1, &q, &lit, NULL), COHSM_ERR_DESC,
         "cohsm_visible_scene: query.filter is 3; it must be a COHSM_FILTER_...");
    assert_true(lit == 7);
}

/* Opened maps keep the log of cohsm_open; files that cannot be opened are told of by it. */
static void files_and_facts_say_why(void **state)
{
    cohsm_system heard = listening();
    cohsm_maps *opened, *untouched = NULL;
    size_t bytes;
    const void *data = cohsm_data(good, &bytes);
    char *copy = (char *)malloc(bytes);
    float place[4];
    uint16_t depths[256];
    (void)state;
    assert_non_null(copy);
    memcpy(copy, data, bytes);
    assert_int_equal(cohsm_open(copy, bytes, &heard, &opened), COHSM_OK);
    said(cohsm_location(opened, 36, place), COHSM_ERR_ARGUMENT,
         "cohsm_location: map is 36; it must be below 36, the number of maps");
    said(cohsm_location(opened, 0, NULL), COHSM_ERR_ARGUMENT, "cohsm_location: out is NULL");
    said(cohsm_depths(opened, 36, depths), COHSM_ERR_ARGUMENT,
         "cohsm_depths: view is 36; it must be below 36, the number of views");
    said(cohsm_depths(opened, 0, NULL), COHSM_ERR_ARGUMENT, "cohsm_depths: out is NULL");
    said(cohsm_write(opened, NULL, bytes), COHSM_ERR_ARGUMENT, "cohsm_write: memory is NULL");
    said(cohsm_write(opened, copy, 10), COHSM_ERR_MEMORY,
         "cohsm_write: memory_bytes is 10; it must be cohsm_info.bytes or more");
    cohsm_free(opened);
    copy[bytes / 2] ^= 1;
    said(cohsm_open(copy, bytes, &heard, &untouched), COHSM_ERR_FORMAT,
         "cohsm_open: data is no file of csm.h, or a damaged one");
    copy[4] = 9;
    said(cohsm_open(copy, bytes, &heard, &untouched), COHSM_ERR_VERSION,
         "cohsm_open: data is a file of an unknown version");
    assert_null(untouched);
    free(copy);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_desc_names_field_value_and_range),
        cmocka_unit_test(a_domain_names_the_field_at_fault),
        cmocka_unit_test(a_mesh_names_field_value_and_range),
        cmocka_unit_test(a_builder_says_what_it_was_not_given),
        cmocka_unit_test(files_shards_and_budgets_say_why),
        cmocka_unit_test(a_query_names_field_value_and_range),
        cmocka_unit_test(a_scene_names_the_instance),
        cmocka_unit_test(files_and_facts_say_why),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
