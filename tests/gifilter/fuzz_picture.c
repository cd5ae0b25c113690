/* fuzz_picture - libFuzzer target: frames of any places, normals and light through gifilter.h. What comes out is finite
   where a pixel shows something, and 0 where it shows nothing. The last bytes choose odd services (kit/odd.h), by which
   the same comes out. */

#define GIFILT_STATIC
#define GIFILTER_IMPLEMENTATION
#include "gifilter.h"
#include "input.h"
#include "odd.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { MOST = 24 };

/* Mostly small numbers; now and then any bits at all. */
static float take_value(input *in)
{
    uint32_t kind = take(in), bits = 0, k;
    float x;
    if (kind < 240) return (float)(int32_t)(kind - 120u) / 16.0f;
    for (k = 0; k < 4; k++) bits |= take(in) << 8 * k;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static void take_all(input *in, float *values, size_t count)
{
    size_t i;
    for (i = 0; i < count; i++) values[i] = take_value(in);
}

/* Unit where it can be: others are refused, of which one in a picture is enough. */
static void make_unit(float *normals, size_t count)
{
    size_t i, k;
    for (i = 0; i < count; i++) {
        float *n = normals + 3 * i, length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (k = 0; k < 3 && length > 1e-3f && length < 1e9f; k++) n[k] /= length;
    }
}

static void check(const float *normals, const float *out, size_t count)
{
    size_t i, k;
    for (i = 0; i < count; i++) {
        const float *n = normals + 3 * i;
        for (k = 0; k < 3; k++) {
            if (!(fabsf(out[3 * i + k]) <= 3.402823466e38f)) abort();
            if (n[0] == 0 && n[1] == 0 && n[2] == 0 && out[3 * i + k] != 0) abort();
        }
    }
}

static void run(input *in, const gifilt_system *system, odd *o)
{
    float positions[3 * MOST * MOST], normals[3 * MOST * MOST], light[3 * MOST * MOST], motion[2 * MOST * MOST];
    float matrix[16];
    gifilt_result result;
    gifilt_desc size_of;
    gifilt_filter *filter;
    gifilt_points points;
    uint32_t width, height, frame, i;
    width = 1 + take(in) % MOST;
    height = 1 + take(in) % MOST;
    memset(&points, 0, sizeof points);
    points.count = width * height;
    points.positions = positions;
    points.normals = normals;
    memset(&size_of, 0, sizeof size_of);
    size_of.width = width;
    size_of.height = height;
    size_of.system = *system;
    ODD_TRY(o, result, gifilt_create(&size_of, &filter));
    if (result != GIFILT_OK) return;
    for (frame = 0; frame < 3; frame++) {
        uint32_t what = take(in);
        gifilt_frame d;
        memset(&d, 0, sizeof d);
        d.passes = (int)(take(in) % 9u) - 1;    /* 7 is refused */
        d.history = take(in) % 12u;
        d.normal_cosine = fabsf(take_value(in));
        d.plane_slope = fabsf(take_value(in));
        take_all(in, matrix, 16);
        take_all(in, positions, 3 * points.count);
        take_all(in, normals, 3 * points.count);
        if (!(what & 8u)) make_unit(normals, points.count);
        take_all(in, light, 3 * points.count);
        take_all(in, motion, 2 * points.count);
        for (i = 0; i < 3 * points.count; i++)
            if (!(fabsf(light[i]) <= 1e18f)) light[i] = 1;        /* sums of larger ones may overflow */
        if (what & 1u) d.world_to_clip = matrix;
        if (what & 2u) d.motion = motion;
        if (what & 4u) gifilt_reset(filter);
        ODD_TRY(o, result, gifilt_apply(filter, &d, &points, light, light));
        if (result == GIFILT_OK) check(normals, light, points.count);
        odd_keep_result(o, (int)result);
        odd_keep(o, light, 3 * points.count * sizeof *light);
    }
    gifilt_free(filter);
    odd_done(o);
}

static void run_by(input *in, odd *o, int is_odd)
{
    gifilt_system system;
    memset(&system, 0, sizeof system);
    if (is_odd) ODD_SYSTEM(&system, o);
    run(in, &system, o);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    odd o;
    if (odd_changes(run_by, data, size, &o) && !o.failures) ODD_ABORT("odd services change the picture");
    return 0;
}
