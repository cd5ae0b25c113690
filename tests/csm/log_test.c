/* log_test - each call of csm.h that is given a system says in its log why it refuses: one line with function, field,
   value and range; one that succeeds says nothing. */

#define CSM_IMPLEMENTATION
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

#define DESC(change, text)                                                                      \
    do {                                                                                        \
        cohsm_desc d = small();                                                                 \
        cohsm_maps *maps;                                                                       \
        change;                                                                                 \
        said(cohsm_build(&d, &ball_mesh, &maps, NULL), COHSM_ERR_DESC, "cohsm_build: " text);   \
    } while (0)

static void a_desc_names_field_value_and_range(void **state)
{
    (void)state;
    DESC(d.system = halved(), "desc.system.allocator has one function of the two");
    DESC(d.domain.kind = COHSM_DOMAIN_KIND_COUNT, "desc.domain.kind is 10; it must be a COHSM_DOMAIN_...");
    DESC(d.layers = COHSM_LAYERS_COUNT, "desc.layers is 4; it must be a COHSM_LAYERS_...");
    DESC(d.order = COHSM_ORDER_COUNT, "desc.order is 5; it must be a COHSM_ORDER_...");
    DESC(d.orientation = COHSM_ORIENTATION_COUNT, "desc.orientation is 4; it must be a COHSM_ORIENTATION_...");
    DESC(d.open_thickness = -1, "desc.open_thickness is -1; it must be 0 or more");
    DESC(d.map_side = 3, "desc.map_side is 3; it must be 0, or 4..1024");
    DESC(d.depth_bits = 9, "desc.depth_bits is 9; it must be 0, or 4..8");
    DESC(d.domain.side[0] = 5000, "desc.domain.side[0] is 5000; it must be 0, or 1..4096 like the other sides that the "
                                  "kind has, with 2^24 cells or fewer");
    DESC(d.domain.kind = COHSM_DOMAIN_RECTANGLE,
         "desc.domain has a shape without extent, or locations that cannot be used");
    DESC(d.radius = -1, "desc.radius is -1; it must be 0 or more, and it and center finite");
    DESC(d.radius = 0.01f,
         "desc.radius is 0.01; it must be so large that the sphere about center holds the mesh");
    DESC(d.pixel_end = 257, "desc.pixel_end is 257; it must be above pixel_begin, and map_side^2 or less");
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
    MESH(m.indices16 = narrow, COHSM_ERR_ARGUMENT, "mesh has indices and indices16");
    MESH(m.vertex_stride = 10, COHSM_ERR_ARGUMENT,
         "mesh.vertex_stride is 10; it must be 0, or 12 or more and a multiple of 4");
    MESH(m.vertex_count = 0x80000000u, COHSM_ERR_LIMIT, "mesh has 2^31 or more vertices or indices");
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
    cohsm_view view;
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
         "cohsm_builder_view: index is 36; it must be below the number of views");
    said(cohsm_builder_add(b, 0, NULL, far_depth, NULL), COHSM_ERR_ARGUMENT, "cohsm_builder_add: z1 is NULL");
    said(cohsm_builder_add(b, 0, near_depth, NULL, NULL), COHSM_ERR_ARGUMENT, "cohsm_builder_add: z2 is NULL");
    near_depth[7] = 0.5f;
    said(cohsm_builder_add(b, 0, near_depth, far_depth, NULL), COHSM_ERR_INPUT,
         "cohsm_builder_add: z1[7] is 0.5; it must be at most the depth of the next layer there");
    said(cohsm_builder_finish(b, NULL, NULL), COHSM_ERR_ARGUMENT, "cohsm_builder_finish: out is NULL");
    cohsm_builder_free(b);
}

static void files_shards_and_budgets_say_why(void **state)
{
    const cohsm_maps *none[2] = { NULL, NULL };
    cohsm_system deaf = listening(), half = halved(), hungry = starving();
    cohsm_desc d = small();
    cohsm_report report;
    cohsm_maps *maps;
    uint32_t side, map_side;
    size_t bytes, packed_bytes;
    const void *data = cohsm_data(good, &bytes);
    void *packed;
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
    none[0] = NULL;
    said(cohsm_merge(none, 1, &deaf, &maps), COHSM_ERR_ARGUMENT,
         "cohsm_merge: shards[0] is 0; it must be maps, not NULL");
    said(cohsm_verify(NULL, &deaf, &ball_mesh, &report), COHSM_ERR_ARGUMENT, "cohsm_verify: maps is NULL");
    said(cohsm_verify(good, &deaf, NULL, &report), COHSM_ERR_ARGUMENT, "cohsm_verify: mesh is NULL");
    said(cohsm_verify(good, &deaf, &ball_mesh, NULL), COHSM_ERR_ARGUMENT, "cohsm_verify: out is NULL");
    said(cohsm_verify(good, &half, &ball_mesh, &report), COHSM_ERR_DESC,
         "cohsm_verify: system.allocator has one function of the two");
    said(cohsm_verify(good, &hungry, &ball_mesh, &report), COHSM_ERR_ALLOC,
         "cohsm_verify: system.allocator returned no memory");
    said(cohsm_budget(&d, NULL, 1000, &side, &map_side), COHSM_ERR_ARGUMENT, "cohsm_budget: mesh is NULL");
    said(cohsm_budget(&d, &ball_mesh, 1000, NULL, &map_side), COHSM_ERR_ARGUMENT, "cohsm_budget: side is NULL");
    said(cohsm_budget(&d, &ball_mesh, 1000, &side, NULL), COHSM_ERR_ARGUMENT, "cohsm_budget: map_side is NULL");
    said(cohsm_budget(&d, &ball_mesh, 1000, &side, &map_side), COHSM_ERR_LIMIT,
         "cohsm_budget: bytes is 1000; it must be more: not even 64 maps of 16 x 16 pixels fit");
    assert_int_equal(cohsm_open(data, bytes, &deaf, &maps), COHSM_OK);
    cohsm_free(maps);
    assert_int_equal(lines, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_desc_names_field_value_and_range),
        cmocka_unit_test(a_mesh_names_field_value_and_range),
        cmocka_unit_test(a_builder_says_what_it_was_not_given),
        cmocka_unit_test(files_shards_and_budgets_say_why),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
