/* simd_kernels - every function on lanes, in one kernel that simd_test.c and bytes.c compile for several instruction
   sets: P_SET, P_WIDTH and P_LANE_COUNT are defined by who includes this. */

#include "src/shared/simd_begin.h"
#include "src/shared/simd_x86.h"
#include "src/shared/simd_plain.h"
#include "src/shared/simd_lanes3.h"
#include "src/shared/simd_strided.h"
#include "src/shared/simd_ints.h"
#if P_LANE_COUNT == 16
#include "src/shared/simd_order.h"
#endif

/* What the kernel writes, planes of as many floats as there are lanes. */
#ifndef SIMD_PLANES
#define SIMD_PLANES
#define SIMD_BITS 0xf0002d5bu
enum {
    SIMD_ADD, SIMD_SUB, SIMD_MUL, SIMD_DIV, SIMD_MAX, SIMD_MIN, SIMD_SQRT, SIMD_ABS, SIMD_NEGATE, SIMD_GREATER,
    SIMD_AT_LEAST, SIMD_DIFFER, SIMD_SELECT, SIMD_KEEP, SIMD_AND, SIMD_OR, SIMD_TRUNCATE, SIMD_INTS, SIMD_DOT,
    SIMD_PACKED,                /* three planes: x, y, x - 0.25 of each lane */
    SIMD_SHORTS = SIMD_PACKED + 3, SIMD_GATHER, SIMD_OF_BITS, SIMD_EQUAL,       /* see simd_other */
    SIMD_PLANE_COUNT
};
/* Likewise of whole numbers. */
enum {
    SIMD_INTS_MUL, SIMD_INTS_MIN, SIMD_INTS_MAX, SIMD_INTS_GREATER, SIMD_INTS_EQUAL, SIMD_INTS_SELECT, SIMD_INTS_SHIFT,
    SIMD_INTS_ADD, SIMD_INTS_SUB, SIMD_INTS_AND, SIMD_INTS_XOR, SIMD_INTS_JOIN, SIMD_INTS_CROSS, SIMD_INTS_GATHER,
    SIMD_INTS_COUNT
};
#endif

#define simd_compute P_NAME_IN_SET(simd_compute, P_SET)
#define simd_muladd P_NAME_IN_SET(simd_muladd, P_SET)
#define simd_other P_NAME_IN_SET(simd_other, P_SET)
#define simd_bits P_NAME_IN_SET(simd_bits, P_SET)
#define simd_integers P_NAME_IN_SET(simd_integers, P_SET)
#define simd_append P_NAME_IN_SET(simd_append, P_SET)
#define simd_words P_NAME_IN_SET(simd_words, P_SET)
#define simd_unpack P_NAME_IN_SET(simd_unpack, P_SET)
#define simd_order P_NAME_IN_SET(simd_order, P_SET)
#define simd_plane P_NAME_IN_SET(simd_plane, P_SET)

static inline P_IN_KERNEL void simd_plane(float *out, int plane, P_lanes a)
{
    P_lanes_store(out + plane * P_LANE_COUNT, a);
}

/* What follows from the number l of a lane: the short -32767 + 4000 l; a of lane (5 l + 3) modulo the lanes; 1 where
   SIMD_BITS has bit l; 1 where (5 l + 3) modulo the lanes is 3. */
static inline P_IN_KERNEL void simd_other(const float *a, float *out)
{
    const P_lanes one = P_lanes_all(1.0f);
    int16_t shorts[P_LANE_COUNT];
    int32_t at[P_LANE_COUNT];
    int l;
    for (l = 0; l < P_LANE_COUNT; l++) {
        shorts[l] = (int16_t)(4000 * l - 32767);
        at[l] = (5 * l + 3) % P_LANE_COUNT;
    }
    simd_plane(out, SIMD_SHORTS, P_lanes_of_shorts(shorts));
    simd_plane(out, SIMD_GATHER, P_lanes_gather(a, P_ints_load(at)));
    simd_plane(out, SIMD_OF_BITS, P_lanes_keep(P_mask_of_bits(SIMD_BITS), one));
    simd_plane(out, SIMD_EQUAL, P_lanes_keep(P_ints_equal(P_ints_load(at), P_ints_all(3)), one));
}

/* a and b: a float a lane; a's are not truncated where an int32_t cannot hold them or they are no number. */
P_KERNEL static void simd_compute(const float *a, const float *b, float *out)
{
    const P_lanes x = P_lanes_load(a), y = P_lanes_load(b), one = P_lanes_all(1.0f);
    const P_lane_mask greater = P_lanes_greater(x, y), at_least = P_lanes_at_least(x, y), differ = P_lanes_differ(x, y);
    const P_lanes3 v = P_lanes3_load(a, b, a), w = P_lanes3_sub(v, P_lanes3_all(0.25f, 0.5f, 2.0f));
    P_lanes3 packed = v;
    int32_t ints[P_LANE_COUNT];
    P_lane_ints k = P_lanes_truncate(P_lanes_keep(P_lanes_at_least(P_lanes_all(2147483520.0f), P_lanes_abs(x)), x));
    packed.z = w.x;
    simd_plane(out, SIMD_ADD, P_lanes_add(x, y));
    simd_plane(out, SIMD_SUB, P_lanes_sub(x, y));
    simd_plane(out, SIMD_MUL, P_lanes_mul(x, y));
    simd_plane(out, SIMD_DIV, P_lanes_div(x, y));
    simd_plane(out, SIMD_MAX, P_lanes_max(x, y));
    simd_plane(out, SIMD_MIN, P_lanes_min(x, y));
    simd_plane(out, SIMD_SQRT, P_lanes_sqrt(P_lanes_abs(x)));
    simd_plane(out, SIMD_ABS, P_lanes_abs(x));
    simd_plane(out, SIMD_NEGATE, P_lanes_negate(x));
    simd_plane(out, SIMD_GREATER, P_lanes_keep(greater, one));
    simd_plane(out, SIMD_AT_LEAST, P_lanes_keep(at_least, one));
    simd_plane(out, SIMD_DIFFER, P_lanes_keep(differ, one));
    simd_plane(out, SIMD_SELECT, P_lanes_select(greater, x, y));
    simd_plane(out, SIMD_KEEP, P_lanes_keep(greater, x));
    simd_plane(out, SIMD_AND, P_lanes_keep(P_mask_and(at_least, differ), one));
    simd_plane(out, SIMD_OR, P_lanes_keep(P_mask_or(greater, P_lanes_greater(y, one)), one));
    simd_plane(out, SIMD_TRUNCATE, P_lanes_of_ints(k));
    P_ints_store(ints, P_ints_add(k, P_ints_sub(P_ints_all(7), P_ints_keep(greater, P_ints_all(2)))));
    k = P_ints_load(ints);
    simd_plane(out, SIMD_INTS, P_lanes_of_ints(P_ints_or(k, P_ints_all(1))));
    simd_plane(out, SIMD_DOT, P_lanes3_dot(v, w));
    simd_other(a, out);
    P_lanes3_store_packed(out + SIMD_PACKED * P_LANE_COUNT, packed);
}

P_KERNEL static void simd_muladd(const float *a, const float *b, const float *c, float *out)
{
    P_lanes_store(out, P_lanes_muladd(P_lanes_load(a), P_lanes_load(b), P_lanes_load(c)));
}

/* Bit l: a > b in lane l; bit 31: P_mask_any says so of any. */
P_KERNEL static uint32_t simd_bits(const float *a, const float *b)
{
    const P_lane_mask greater = P_lanes_greater(P_lanes_load(a), P_lanes_load(b));
    return P_mask_bits(greater) | (uint32_t)P_mask_any(greater) << 31;
}

/* a and b: a number a lane. */
P_KERNEL static void simd_integers(const int32_t *a, const int32_t *b, int32_t *out)
{
    const P_lane_ints x = P_ints_load(a), y = P_ints_load(b), one = P_ints_all(1);
    const P_lane_mask greater = P_ints_greater(x, y);
    P_ints_store(out + SIMD_INTS_MUL * P_LANE_COUNT, P_ints_mul(x, y));
    P_ints_store(out + SIMD_INTS_MIN * P_LANE_COUNT, P_ints_min(x, y));
    P_ints_store(out + SIMD_INTS_MAX * P_LANE_COUNT, P_ints_max(x, y));
    P_ints_store(out + SIMD_INTS_GREATER * P_LANE_COUNT, P_ints_keep(greater, one));
    P_ints_store(out + SIMD_INTS_EQUAL * P_LANE_COUNT, P_ints_keep(P_ints_equal(x, y), one));
    P_ints_store(out + SIMD_INTS_SELECT * P_LANE_COUNT, P_ints_select(greater, x, y));
    P_ints_store(out + SIMD_INTS_SHIFT * P_LANE_COUNT, P_ints_shift_right(x, 5));
    P_ints_store(out + SIMD_INTS_ADD * P_LANE_COUNT, P_ints_add(x, y));
    P_ints_store(out + SIMD_INTS_SUB * P_LANE_COUNT, P_ints_sub(x, y));
    P_ints_store(out + SIMD_INTS_AND * P_LANE_COUNT, P_ints_and(x, y));
    P_ints_store(out + SIMD_INTS_XOR * P_LANE_COUNT, P_ints_xor(x, y));
    P_ints_store(out + SIMD_INTS_JOIN * P_LANE_COUNT, P_ints_join_halves(x, y));
    P_ints_store(out + SIMD_INTS_CROSS * P_LANE_COUNT,
                 P_ints_cross_halves(P_ints_shift_right(x, 2), P_ints_shift_right(y, 2)));
    P_ints_store(out + SIMD_INTS_GATHER * P_LANE_COUNT, P_ints_gather(a, P_ints_and(y, P_ints_all(P_LANE_COUNT - 1))));
}

/* Appends a's lanes where a > b to both lists, which have room for twice the lanes. Returns their count, and the number
   of the first such lane times 256. */
P_KERNEL static uint32_t simd_append(const float *a, const float *b, float *list, int32_t *numbers)
{
    const P_lanes x = P_lanes_load(a);
    const P_lane_mask greater = P_lanes_greater(x, P_lanes_load(b));
    const uint32_t bits = P_mask_bits(greater);
    P_lanes_append(list, greater, x);
    P_ints_append(numbers, greater, P_lanes_truncate(x));
    return P_mask_count(greater) | (bits ? P_first_bit(bits) : 0u) << 8;
}

/* Three numbers: how many bits are set, where bit number is, how many of the first number half words are up to the
   limit. */
P_KERNEL static void simd_words(uint64_t bits, uint32_t number, const uint32_t *words, uint32_t limit, uint32_t out[3])
{
    out[0] = P_bit_count(bits);
    out[1] = P_nth_bit(bits, number);
    out[2] = P_halves_up_to(words, number, limit);
}

/* Unpacks vectors, which lie `stride` bytes apart, doubles and packs them. */
P_KERNEL static void simd_unpack(const float *xyz, size_t stride, float *out)
{
    const P_lanes3 v = stride == 12 ? P_lanes3_load_packed(xyz) : P_lanes3_load_fours(xyz, stride);
    P_lanes3_store_packed(out, P_lanes3_scale(v, P_lanes_all(2.0f)));
}

#if P_LANE_COUNT == 16
/* Unit simd_order, which is of sixteen lanes: five planes, then a[0..63] transposed, its rows 8 floats apart. */
P_KERNEL static void simd_order(const float *a, const uint8_t *bytes, float *out)
{
    P_lanes_store(out, P_lanes_of_bytes(bytes));
    P_lanes_store(out + 16, P_lanes_load_halves(a + 3, a + 21));
    P_lanes_store(out + 32, P_lanes_load_fours(a + 1, 3));
    P_lanes_store(out + 48, P_lanes_swap_ones(P_lanes_load(a)));
    P_lanes_store(out + 64, P_lanes_swap_twos(P_lanes_load(a)));
    P_transpose8(a, 8, out + 80, 8);
}
#endif

#undef P_SET
#undef P_WIDTH
#undef P_LANE_COUNT
