/* errors_test - bad input: a specific error with outputs untouched; the same bytes from all vector units. */

#define GIFILT_STATIC
#define GIFILTER_IMPLEMENTATION
#include "gifilter.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include "picture.h"
#include "util.h"

enum { SIDE = 16 };

static float positions[3 * SIDE * SIDE], normals[3 * SIDE * SIDE], result[3 * SIDE * SIDE], other[3 * SIDE * SIDE];
static gifilt_points points;

static int setup(void **state)
{
    int i;
    (void)state;
    for (i = 0; i < SIDE * SIDE; i++) {
        set3(positions + 3 * i, i % SIDE * 0.1 - 0.8, i / SIDE * 0.1 - 0.8, 1);
        set3(normals + 3 * i, 0, 0, 1);
    }
    points = points_of(positions, normals, SIDE * SIDE);
    return 0;
}

static void sizes_of_pictures_have_limits(void **state)
{
    gifilt_filter *filter;
    gifilt_system system;
    ledger l;
    (void)state;
    assert_int_equal(create(0, 4, NULL, &filter), GIFILT_ERR_DESC);
    assert_int_equal(create(4, 0, NULL, &filter), GIFILT_ERR_DESC);
    assert_int_equal(create(4, 4, NULL, NULL), GIFILT_ERR_ARGUMENT);
    assert_int_equal(create(100000, 4, NULL, &filter), GIFILT_ERR_DESC);
    assert_int_equal(create(65537, 1, NULL, &filter), GIFILT_ERR_DESC);
    assert_int_equal(create(1, 65537, NULL, &filter), GIFILT_ERR_DESC);
    assert_int_equal(create(65536, 1, NULL, &filter), GIFILT_OK);
    gifilt_free(filter);
    assert_int_equal(create(1, 65536, NULL, &filter), GIFILT_OK);
    gifilt_free(filter);
    system = ledger_system(&l);
    system.allocator.free_fn = NULL;             /* both functions or none */
    assert_int_equal(create(4, 4, &system, &filter), GIFILT_ERR_DESC);
    gifilt_free(NULL);
    gifilt_reset(NULL);
    assert_string_equal(gifilt_result_text(GIFILT_OK), "ok");
    assert_string_equal(gifilt_result_text(GIFILT_RESULT_COUNT), "unknown result");
    assert_string_equal(gifilt_result_text((gifilt_result)99), "unknown result");
}

static void frames_out_of_range_write_nothing(void **state)
{
    static const float huge[16] = { INFINITY };
    gifilt_filter *filter, *asked;
    gifilt_points p = points;
    gifilt_frame f;
    size_t i;
    (void)state;
    memset(&f, 0, sizeof f);
    assert_int_equal(create(SIDE, SIDE, NULL, &filter), GIFILT_OK);
    asked = filter;
#define SMOOTHED(expected, change) \
    do { gifilt_frame d = f; change; \
         memset(result, 0x5a, sizeof result); memcpy(other, result, sizeof result); \
         assert_int_equal(gifilt_apply(asked, &d, &p, positions, result), expected); \
         if ((expected) != GIFILT_OK) assert_memory_equal(result, other, sizeof result); } while (0)
    SMOOTHED(GIFILT_OK, d.passes = 6);
    SMOOTHED(GIFILT_OK, d.passes = -1);
    SMOOTHED(GIFILT_ERR_DESC, d.passes = 7);
    SMOOTHED(GIFILT_ERR_DESC, d.rows = GIFILT_ROWS_COUNT);
    SMOOTHED(GIFILT_OK, d.history = 1000);
    SMOOTHED(GIFILT_ERR_DESC, d.history = 1001);
    SMOOTHED(GIFILT_OK, d.normal_cosine = 0.99f);
    SMOOTHED(GIFILT_ERR_DESC, d.normal_cosine = 1);
    SMOOTHED(GIFILT_ERR_DESC, d.normal_cosine = -0.1f);
    SMOOTHED(GIFILT_OK, d.plane_slope = 1e6f);
    SMOOTHED(GIFILT_ERR_DESC, d.plane_slope = 1.1e6f);
    SMOOTHED(GIFILT_ERR_DESC, d.plane_slope = -1);
    SMOOTHED(GIFILT_ERR_DESC, d.plane_slope = NAN);
    SMOOTHED(GIFILT_ERR_DESC, d.world_to_clip = huge);
    for (i = 0; i < 3; i++) {                    /* a count too small, strides that overlap or are no floats */
        p = points;
        if (i == 0) p.count = 3;
        if (i == 1) p.position_stride = 8;
        if (i == 2) p.normal_stride = 14;
        SMOOTHED(i ? GIFILT_ERR_ARGUMENT : GIFILT_ERR_MISMATCH, d.passes = 0);
    }
    p = points;
    p.normals = NULL;
    SMOOTHED(GIFILT_ERR_ARGUMENT, d.passes = 0);
    p = points;
    asked = NULL;
    SMOOTHED(GIFILT_ERR_ARGUMENT, d.passes = 0);
    assert_int_equal(gifilt_apply(filter, &f, NULL, positions, result), GIFILT_ERR_ARGUMENT);
    assert_int_equal(gifilt_apply(filter, &f, &p, NULL, result), GIFILT_ERR_ARGUMENT);
    assert_int_equal(gifilt_apply(filter, &f, &p, positions, NULL), GIFILT_ERR_ARGUMENT);
    gifilt_free(filter);
}

static char said[300];

static void keep(void *user, const char *message)
{
    ++*(int *)user;
    assert_true(strlen(message) < sizeof said);
    strcpy(said, message);
}

static void a_refused_frame_says_why_and_changes_nothing(void **state)
{
    static float unit[3 * SIDE * SIDE], light[3 * SIDE * SIDE];
    float matrix[16] = { 1.25f, 0, 0, 0, 0, 1.25f, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1 };
    gifilt_system system;
    gifilt_filter *filter;
    gifilt_points p = points;
    gifilt_frame f;
    int lines = 0, i;
    (void)state;
    memset(&system, 0, sizeof system);
    memset(&f, 0, sizeof f);
    system.log = keep;
    system.user = &lines;
    assert_int_equal(create(0, 4, &system, &filter), GIFILT_ERR_DESC);
    assert_string_equal(said, "gifilt_create: desc.width is 0; it must be 1..65536");
    assert_int_equal(create(SIDE, SIDE, &system, &filter), GIFILT_OK);
    f.world_to_clip = matrix;
    for (i = 0; i < 3 * SIDE * SIDE; i++) light[i] = 1;
    assert_int_equal(gifilt_apply(filter, &f, &p, light, result), GIFILT_OK);
    assert_int_equal(lines, 1);
    f.plane_slope = -2;
    assert_int_equal(gifilt_apply(filter, &f, &p, light, result), GIFILT_ERR_DESC);
    assert_string_equal(said, "gifilt_apply: frame.plane_slope is -2; it must be 0..1e6");
    f.plane_slope = 0;
    /* 0.97 to 1.03, none and not finite pass; the first other one is named, and nothing is written or remembered */
    memcpy(unit, normals, sizeof unit);
    unit[2] = 0.971f;
    unit[5] = 1.029f;
    unit[8] = 0;
    unit[11] = NAN;
    p.normals = unit;
    assert_int_equal(gifilt_apply(filter, &f, &p, light, result), GIFILT_OK);
    unit[3 * 77 + 2] = 0.5f;
    unit[3 * 90 + 2] = 2;
    memset(result, 0x5a, sizeof result);
    memcpy(other, result, sizeof result);
    for (i = 0; i < 3 * SIDE * SIDE; i++) light[i] = 100;
    assert_int_equal(gifilt_apply(filter, &f, &p, light, result), GIFILT_ERR_INPUT);
    assert_string_equal(said,
                        "gifilt_apply: points.normals[77] has the length 0.5; it must be 1 (0.97..1.03), or 0");
    assert_memory_equal(result, other, sizeof result);
    for (i = 0; i < 3 * SIDE * SIDE; i++) light[i] = 1;
    assert_int_equal(gifilt_apply(filter, NULL, &points, light, result), GIFILT_OK);
    for (i = 0; i < 3 * SIDE * SIDE; i++) assert_true(result[i] == 1);
    assert_int_equal(lines, 3);
    gifilt_free(filter);
}

/* A call, its result and the one line that it writes. */
#define SAYS(call, expected, line)                                                                                     \
    do {                                                                                                               \
        lines = 0;                                                                                                     \
        assert_int_equal(call, expected);                                                                              \
        assert_string_equal(said, line);                                                                               \
        assert_int_equal(lines, 1);                                                                                    \
    } while (0)

static void *no_memory(size_t bytes, void *user)
{
    (void)bytes;
    (void)user;
    return NULL;
}
static void give_back(void *memory, void *user)
{
    (void)user;
    free(memory);
}

static void every_refusal_says_one_line(void **state)
{
    float matrix[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, NAN };
    gifilt_system system;
    gifilt_filter *filter;
    gifilt_points p = points;
    gifilt_desc desc;
    gifilt_frame f;
    int lines = 0;
    (void)state;
    memset(&system, 0, sizeof system);
    memset(&desc, 0, sizeof desc);
    memset(&f, 0, sizeof f);
    system.log = keep;
    system.user = &lines;
    SAYS(create(4, 70000, &system, &filter), GIFILT_ERR_DESC,
         "gifilt_create: desc.height is 70000; it must be 1..65536");
    desc.system = system;
    desc.width = desc.height = SIDE;
    SAYS(gifilt_create(&desc, NULL), GIFILT_ERR_ARGUMENT, "gifilt_create: out is NULL");
    desc.system.allocator.alloc_fn = no_memory;
    SAYS(gifilt_create(&desc, &filter), GIFILT_ERR_DESC,
         "gifilt_create: desc.system.allocator has one function of two");
    desc.system.allocator.free_fn = give_back;
    SAYS(gifilt_create(&desc, &filter), GIFILT_ERR_ALLOC, "gifilt_create: desc.system.allocator returned no memory");
    assert_int_equal(create(SIDE, SIDE, &system, &filter), GIFILT_OK);
    SAYS(gifilt_apply(filter, &f, &p, NULL, result), GIFILT_ERR_ARGUMENT, "gifilt_apply: light is NULL");
    SAYS(gifilt_apply(filter, &f, &p, positions, NULL), GIFILT_ERR_ARGUMENT, "gifilt_apply: out is NULL");
    SAYS(gifilt_apply(filter, &f, NULL, positions, result), GIFILT_ERR_ARGUMENT, "gifilt_apply: points is NULL");
    p.normal_stride = 13;
    SAYS(gifilt_apply(filter, &f, &p, positions, result), GIFILT_ERR_ARGUMENT,
         "gifilt_apply: points.normal_stride is 13; it must be 0 or a multiple of 4, at least 12");
    p = points;
    p.count = 7;
    SAYS(gifilt_apply(filter, &f, &p, positions, result), GIFILT_ERR_MISMATCH,
         "gifilt_apply: points.count is 7; it must be the filter's width x height");
    p = points;
    f.history = 1001;
    SAYS(gifilt_apply(filter, &f, &p, positions, result), GIFILT_ERR_DESC,
         "gifilt_apply: frame.history is 1001; it must be 0..1000");
    f.history = 0;
    f.passes = 7;
    SAYS(gifilt_apply(filter, &f, &p, positions, result), GIFILT_ERR_DESC,
         "gifilt_apply: frame.passes is 7; it must be at most 6");
    f.passes = 0;
    f.normal_cosine = 1;
    SAYS(gifilt_apply(filter, &f, &p, positions, result), GIFILT_ERR_DESC,
         "gifilt_apply: frame.normal_cosine is 1; it must be 0 or more, below 1");
    f.normal_cosine = 0;
    f.rows = GIFILT_ROWS_COUNT;
    SAYS(gifilt_apply(filter, &f, &p, positions, result), GIFILT_ERR_DESC,
         "gifilt_apply: frame.rows is 3; it must be a value of gifilt_rows");
    f.rows = GIFILT_ROWS_DEFAULT;
    f.world_to_clip = matrix;
    SAYS(gifilt_apply(filter, &f, &p, positions, result), GIFILT_ERR_DESC,
         "gifilt_apply: frame.world_to_clip[15] is not a number; it must be finite");
    gifilt_free(filter);
}

/* ---- threads ---- */

static void backwards(void *user, size_t count, gifilt_task task, void *context)
{
    ++*(int *)user;
    while (count-- > 0) task(context, count);
}

static void the_order_of_tasks_changes_nothing(void **state)
{
    static float places[3 * PICTURE], facing[3 * PICTURE], light[3 * PICTURE], out[2][3 * PICTURE], m[16];
    gifilt_points p = points_of(places, facing, PICTURE);
    int way, calls = 0;
    (void)state;
    picture_make(places, facing, light);
    for (way = 0; way < 2; way++) {
        gifilt_system system;
        gifilt_filter *filter;
        gifilt_frame d;
        uint32_t frame;
        memset(&system, 0, sizeof system);
        system.parallel_for = way ? backwards : NULL;
        system.user = &calls;
        assert_int_equal(create(PICTURE_W, PICTURE_H, &system, &filter), GIFILT_OK);
        for (frame = 0; frame < 4; frame++) {
            picture_frame(1, frame, m, NULL, &d);
            assert_int_equal(gifilt_apply(filter, &d, &p, light, out[way]), GIFILT_OK);
        }
        gifilt_free(filter);
    }
    assert_int_equal(calls, 4 + 1 + 1 + 2 + 3);  /* frames, then packing or passes */
    assert_memory_equal(out[0], out[1], sizeof out[0]);
}

/* ---- vector units ---- */

#if GIFILT__SIMD_SETS
typedef struct unit { gifilt__filter_row accumulate, smooth; } unit;

/* Four frames of a filter by one unit: hashes of what each gives. way: 0 a camera that stands still, 1 that turns a
   little, 2 that comes so near that neighbours were not neighbours, 3 motion without rule. */
static void unit_frames(const unit *u, int way, size_t stride, uint32_t hashes[4])
{
    static float places[4 * PICTURE], facing[4 * PICTURE], light[3 * PICTURE], motion[2 * PICTURE], out[3 * PICTURE];
    gifilt_filter *filter;
    gifilt_frame d;
    gifilt_points p;
    uint32_t frame, i, k, recalled = 0;
    picture_make(places, facing, light);
    for (i = PICTURE; stride == 16 && i-- > 0;) {
        memmove(places + 4 * i, places + 3 * i, 12);
        memmove(facing + 4 * i, facing + 3 * i, 12);
    }
    memset(&p, 0, sizeof p);
    p.count = PICTURE;
    p.positions = places;
    p.normals = facing;
    p.position_stride = p.normal_stride = stride;
    assert_int_equal(create(PICTURE_W, PICTURE_H, NULL, &filter), GIFILT_OK);
    for (frame = 0; frame < 4; frame++) {
        float m[16];
        gifilt__filter_run r;
        picture_frame(way, frame, m, motion, &d);
        memset(&r, 0, sizeof r);
        r.filter = filter;
        r.frame = &d;
        r.points = &p;
        r.in = light;
        r.accumulate = u->accumulate;
        r.smooth = u->smooth;
        assert_true(gifilt__filter_frame(&r, out));
        hashes[frame] = 2166136261u;
        for (i = 0; i < 3 * PICTURE; i++) {
            uint32_t bits;
            memcpy(&bits, out + i, sizeof bits);
            hashes[frame] = (hashes[frame] ^ bits) * 16777619u;
        }
        for (i = 0; i < PICTURE_H; i++)
            for (k = 0; k < PICTURE_W; k++)
                recalled += filter->history[(i * GIFILT__PLANES + GIFILT__FRAMES) * filter->spacing + k] > 1.5f;
    }
    assert_true(recalled > PICTURE / 2);
    gifilt_free(filter);
}
#endif

/* The portable code of the filter gives what vectors of 8 and 16 give, to the bit. */
static void vector_units_filter_alike(void **state)
{
#if GIFILT__SIMD_SETS
    static const unit plain = { gifilt__accumulate_plain, gifilt__smooth_plain };
    static const unit avx2 = { gifilt__accumulate_avx2, gifilt__smooth_avx2 };
    static const unit avx512 = { gifilt__accumulate_avx512, gifilt__smooth_avx512 };
    uint32_t expected[4], got[4];
    int way;
    for (way = 0; way < 4; way++) {
        unit_frames(&plain, way, 12, expected);
        unit_frames(&plain, way, 16, got);
        assert_memory_equal(got, expected, sizeof got);
        if (!gifilt__cpu_has_avx2()) continue;
        unit_frames(&avx2, way, 12, got);
        assert_memory_equal(got, expected, sizeof got);
        if (!gifilt__cpu_has_avx512()) continue;
        unit_frames(&avx512, way, 12, got);
        assert_memory_equal(got, expected, sizeof got);
        unit_frames(&avx512, way, 16, got);
        assert_memory_equal(got, expected, sizeof got);
    }
#endif
    (void)state;
}

/* ---- frames ---- */

static void noise_falls_with_every_frame(void **state)
{
    /* world x, y in -0.8..0.8 to clip; z plays no part */
    float matrix[16] = { 1.25f, 0, 0, 0, 0, 1.25f, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1 };
    gifilt_filter *filter;
    gifilt_frame f;
    uint64_t seed = 1;
    double spread[2] = { 0, 0 };
    int frame, i;
    (void)state;
    memset(&f, 0, sizeof f);
    f.world_to_clip = matrix;
    f.history = 100;
    f.passes = -1;
    assert_int_equal(create(SIDE, SIDE, NULL, &filter), GIFILT_OK);
    for (frame = 0; frame < 64; frame++) {
        for (i = 0; i < 3 * SIDE * SIDE; i++) {
            seed = seed * 6364136223846793005u + 1442695040888963407u;
            other[i] = (float)(seed >> 40) / 16777216.0f;
        }
        assert_int_equal(gifilt_apply(filter, &f, &points, other, result), GIFILT_OK);
        for (i = 0; i < 3 * SIDE * SIDE && frame % 63 == 0; i++)
            spread[frame / 63] += pow((double)result[i] - 0.5, 2) / (3 * SIDE * SIDE);
    }
    assert_true(fabs(spread[0] - 1.0 / 12) < 0.01);
    /* 64 frames, moved by half a pixel to the texel centres: a little smoother still */
    if (!(spread[1] < 1.5 / 12 / 64)) fail_msg("variance after 64 frames x 12 x 64: %g", spread[1] * 12 * 64);
    gifilt_reset(filter);
    assert_int_equal(gifilt_apply(filter, &f, &points, other, result), GIFILT_OK);
    assert_memory_equal(result, other, sizeof result);
    gifilt_free(filter);
}

/* By motion, which asks no matrix whether there was a frame before: every row of the history is cleared. */
static void a_reset_filter_remembers_no_row(void **state)
{
    static float light[3 * SIDE * SIDE], motion[2 * SIDE * SIDE];
    gifilt_filter *filter;
    gifilt_frame f;
    int frame, i;
    (void)state;
    memset(&f, 0, sizeof f);
    f.motion = motion;
    f.history = 8;
    f.passes = -1;
    for (i = 0; i < SIDE * SIDE; i++) {
        motion[2 * i] = (float)(i % SIDE) + 0.5f;
        motion[2 * i + 1] = (float)(i / SIDE) + 0.5f;
    }
    assert_int_equal(create(SIDE, SIDE, NULL, &filter), GIFILT_OK);
    for (frame = 0; frame < 3; frame++) {
        for (i = 0; i < 3 * SIDE * SIDE; i++) light[i] = (float)(frame + 1);
        if (frame == 2) gifilt_reset(filter);
        assert_int_equal(gifilt_apply(filter, &f, &points, light, result), GIFILT_OK);
        for (i = 0; i < 3 * SIDE * SIDE; i++)
            assert_true(fabsf(result[i] - (frame == 0 ? 1.0f : frame == 1 ? 1.5f : 3.0f)) < 1e-4f);
    }
    gifilt_free(filter);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sizes_of_pictures_have_limits),
        cmocka_unit_test(frames_out_of_range_write_nothing),
        cmocka_unit_test(a_refused_frame_says_why_and_changes_nothing),
        cmocka_unit_test(every_refusal_says_one_line),
        cmocka_unit_test(the_order_of_tasks_changes_nothing),
        cmocka_unit_test(vector_units_filter_alike),
        cmocka_unit_test(noise_falls_with_every_frame),
        cmocka_unit_test(a_reset_filter_remembers_no_row),
    };
    return cmocka_run_group_tests(tests, setup, NULL);
}
