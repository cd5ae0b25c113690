/* unit simd_plain, needs simd_begin: lanes of NEON, WebAssembly and others, or floats one by one */

#if !P_SIMD_X86 && P_WIDTH <= 4

#if P_SIMD_VECTORS
typedef float P_piece __attribute__((vector_size(16)));
typedef int32_t P_piece_ints __attribute__((vector_size(16)));
typedef uint32_t P_piece_words __attribute__((vector_size(16)));
#else
typedef float P_piece;
typedef int32_t P_piece_ints;
typedef uint32_t P_piece_words;
#endif
typedef struct P_lanes { P_piece v[P_LANE_COUNT / P_WIDTH]; } P_lanes;
typedef struct P_lane_ints { P_piece_ints v[P_LANE_COUNT / P_WIDTH]; } P_lane_ints;
/* Lanes of 0 or -1. */
typedef struct P_lane_mask { P_piece_ints v[P_LANE_COUNT / P_WIDTH]; } P_lane_mask;

static inline P_IN_KERNEL P_lanes P_lanes_load(const float *from)
{
    P_lanes a;
    P_EACH(memcpy(&a.v[piece], from + piece * P_WIDTH, sizeof a.v[piece]))
    return a;
}

static inline P_IN_KERNEL void P_lanes_store(float *to, P_lanes a)
{
    P_EACH(memcpy(to + piece * P_WIDTH, &a.v[piece], sizeof a.v[piece]))
}

static inline P_IN_KERNEL P_lanes P_lanes_all(float x)
{
    P_lanes a;
#if P_SIMD_VECTORS
    const P_piece all = { x, x, x, x };
    P_EACH(a.v[piece] = all)
#else
    P_EACH(a.v[piece] = x)
#endif
    return a;
}

/* Comparisons with what is not a number are false, but for differ, which is true. */
static inline P_IN_KERNEL P_lane_mask P_lanes_greater(P_lanes a, P_lanes b)
{
    P_lane_mask m;
#if P_SIMD_VECTORS
    P_EACH(m.v[piece] = a.v[piece] > b.v[piece])
#else
    P_EACH(m.v[piece] = -(a.v[piece] > b.v[piece]))
#endif
    return m;
}

static inline P_IN_KERNEL P_lane_mask P_lanes_at_least(P_lanes a, P_lanes b)
{
    P_lane_mask m;
#if P_SIMD_VECTORS
    P_EACH(m.v[piece] = a.v[piece] >= b.v[piece])
#else
    P_EACH(m.v[piece] = -(a.v[piece] >= b.v[piece]))
#endif
    return m;
}

static inline P_IN_KERNEL P_lane_mask P_lanes_differ(P_lanes a, P_lanes b)
{
    P_lane_mask m;
#if P_SIMD_VECTORS
    P_EACH(m.v[piece] = a.v[piece] != b.v[piece])
#else
    P_EACH(m.v[piece] = -(a.v[piece] != b.v[piece]))
#endif
    return m;
}

/* Returns m ? a : b in each lane. */
static inline P_IN_KERNEL P_lanes P_lanes_select(P_lane_mask m, P_lanes a,
                                                 P_lanes b)
{
#if P_SIMD_VECTORS
    P_EACH(a.v[piece] = (P_piece)((m.v[piece] & (P_piece_ints)a.v[piece]) |
                                  (~m.v[piece] & (P_piece_ints)b.v[piece])))
#else
    P_EACH(a.v[piece] = m.v[piece] ? a.v[piece] : b.v[piece])
#endif
    return a;
}

static inline P_IN_KERNEL P_lanes P_lanes_add(P_lanes a, P_lanes b)
{
    P_EACH(a.v[piece] = a.v[piece] + b.v[piece])
    return a;
}

static inline P_IN_KERNEL P_lanes P_lanes_sub(P_lanes a, P_lanes b)
{
    P_EACH(a.v[piece] = a.v[piece] - b.v[piece])
    return a;
}

static inline P_IN_KERNEL P_lanes P_lanes_mul(P_lanes a, P_lanes b)
{
    P_EACH(a.v[piece] = a.v[piece] * b.v[piece])
    return a;
}

static inline P_IN_KERNEL P_lanes P_lanes_div(P_lanes a, P_lanes b)
{
    P_EACH(a.v[piece] = a.v[piece] / b.v[piece])
    return a;
}

/* Returns a b + c. */
static inline P_IN_KERNEL P_lanes P_lanes_muladd(P_lanes a, P_lanes b, P_lanes c)
{
    P_EACH(a.v[piece] = a.v[piece] * b.v[piece] + c.v[piece])
    return a;
}

/* Returns a > b ? a : b, so that b is the answer if one is not a number. */
static inline P_IN_KERNEL P_lanes P_lanes_max(P_lanes a, P_lanes b)
{
    return P_lanes_select(P_lanes_greater(a, b), a, b);
}

/* Returns a < b ? a : b. */
static inline P_IN_KERNEL P_lanes P_lanes_min(P_lanes a, P_lanes b)
{
    return P_lanes_select(P_lanes_greater(b, a), a, b);
}

static inline P_IN_KERNEL P_lanes P_lanes_sqrt(P_lanes a)
{
#if P_SIMD_VECTORS
#if defined(__aarch64__) && !defined(P_NO_SIMD)
    P_EACH(a.v[piece] = (P_piece)vsqrtq_f32((float32x4_t)a.v[piece]))
#elif defined(__wasm_simd128__) && !defined(P_NO_SIMD)
    P_EACH(a.v[piece] = (P_piece)wasm_f32x4_sqrt((v128_t)a.v[piece]))
#else
    int k;
    P_EACH(for (k = 0; k < 4; k++) a.v[piece][k] = sqrtf(a.v[piece][k]))
#endif
#else
    P_EACH(a.v[piece] = sqrtf(a.v[piece]))
#endif
    return a;
}

static inline P_IN_KERNEL P_lanes P_lanes_abs(P_lanes a)
{
#if P_SIMD_VECTORS
    const int32_t b = 0x7fffffff;
    const P_piece_ints bits = { b, b, b, b };
    P_EACH(a.v[piece] = (P_piece)((P_piece_ints)a.v[piece] & bits))
#else
    P_EACH(a.v[piece] = fabsf(a.v[piece]))
#endif
    return a;
}

static inline P_IN_KERNEL P_lanes P_lanes_negate(P_lanes a)
{
    P_EACH(a.v[piece] = -a.v[piece])
    return a;
}

/* Returns m ? a : 0. */
static inline P_IN_KERNEL P_lanes P_lanes_keep(P_lane_mask m, P_lanes a)
{
#if P_SIMD_VECTORS
    P_EACH(a.v[piece] = (P_piece)(m.v[piece] & (P_piece_ints)a.v[piece]))
#else
    P_EACH(a.v[piece] = m.v[piece] ? a.v[piece] : 0.0f)
#endif
    return a;
}

/* Rounds towards 0. An int32_t must be able to hold each float. */
static inline P_IN_KERNEL P_lane_ints P_lanes_truncate(P_lanes a)
{
    P_lane_ints k;
#if P_SIMD_VECTORS
    P_EACH(k.v[piece] = __builtin_convertvector(a.v[piece], P_piece_ints))
#else
    P_EACH(k.v[piece] = (int32_t)a.v[piece])
#endif
    return k;
}

static inline P_IN_KERNEL P_lanes P_lanes_of_ints(P_lane_ints k)
{
    P_lanes a;
#if P_SIMD_VECTORS           /* + 0: of 0 that was truncated from -0.5, gcc 12 makes -0 for NEON */
    P_EACH(a.v[piece] = __builtin_convertvector(k.v[piece], P_piece) + 0.0f)
#else
    P_EACH(a.v[piece] = (float)k.v[piece])
#endif
    return a;
}

static inline P_IN_KERNEL P_lanes P_lanes_of_shorts(const int16_t *from)
{
    P_lanes a;
#if P_SIMD_VECTORS
    P_EACH(
        const int16_t *k = from + piece * P_WIDTH;
        const P_piece four = { (float)k[0], (float)k[1], (float)k[2], (float)k[3] };
        a.v[piece] = four)
#else
    P_EACH(a.v[piece] = (float)from[piece])
#endif
    return a;
}

/* Returns from[k] for each lane's k. */
static inline P_IN_KERNEL P_lanes P_lanes_gather(const float *from, P_lane_ints k)
{
    P_lanes a;
#if P_SIMD_VECTORS
    P_EACH(
        const P_piece_ints at = k.v[piece];
        const P_piece four = { from[at[0]], from[at[1]], from[at[2]], from[at[3]] };
        a.v[piece] = four)
#else
    P_EACH(a.v[piece] = from[k.v[piece]])
#endif
    return a;
}

static inline P_IN_KERNEL P_lane_mask P_mask_and(P_lane_mask m, P_lane_mask n)
{
    P_EACH(m.v[piece] = m.v[piece] & n.v[piece])
    return m;
}

static inline P_IN_KERNEL P_lane_mask P_mask_or(P_lane_mask m, P_lane_mask n)
{
    P_EACH(m.v[piece] = m.v[piece] | n.v[piece])
    return m;
}

/* Returns the mask as bits: bit l is that of lane l. */
static inline P_IN_KERNEL uint32_t P_mask_bits(P_lane_mask m)
{
    uint32_t bits = 0;
#if P_SIMD_VECTORS
    int k;
    P_EACH(for (k = 0; k < 4; k++) bits |= ((uint32_t)m.v[piece][k] & 1u) << (piece * P_WIDTH + k))
#else
    P_EACH(bits |= ((uint32_t)m.v[piece] & 1u) << piece)
#endif
    return bits;
}

static inline P_IN_KERNEL P_lane_mask P_mask_of_bits(uint32_t bits)
{
    P_lane_mask m;
#if P_SIMD_VECTORS
    const P_piece_ints each = { 1, 2, 4, 8 };
    P_EACH(
        const int32_t own = (int32_t)(bits >> piece * P_WIDTH & 15u);
        const P_piece_ints all = { own, own, own, own };
        m.v[piece] = (all & each) == each)
#else
    P_EACH(m.v[piece] = -(int32_t)(bits >> piece & 1u))
#endif
    return m;
}

static inline P_IN_KERNEL int P_mask_any(P_lane_mask m)
{
    int any = 0;
#if P_SIMD_VECTORS
    P_EACH(any |= m.v[piece][0] | m.v[piece][1] | m.v[piece][2] | m.v[piece][3])
#else
    P_EACH(any |= m.v[piece])
#endif
    return any != 0;
}

static inline P_IN_KERNEL P_lane_ints P_ints_load(const int32_t *from)
{
    P_lane_ints k;
    P_EACH(memcpy(&k.v[piece], from + piece * P_WIDTH, sizeof k.v[piece]))
    return k;
}

static inline P_IN_KERNEL void P_ints_store(int32_t *to, P_lane_ints k)
{
    P_EACH(memcpy(to + piece * P_WIDTH, &k.v[piece], sizeof k.v[piece]))
}

static inline P_IN_KERNEL P_lane_ints P_ints_all(int32_t x)
{
    P_lane_ints k;
#if P_SIMD_VECTORS
    const P_piece_ints all = { x, x, x, x };
    P_EACH(k.v[piece] = all)
#else
    P_EACH(k.v[piece] = x)
#endif
    return k;
}

static inline P_IN_KERNEL P_lane_ints P_ints_add(P_lane_ints k, P_lane_ints n)
{
    P_EACH(k.v[piece] = (P_piece_ints)((P_piece_words)k.v[piece] + (P_piece_words)n.v[piece]))
    return k;
}

static inline P_IN_KERNEL P_lane_ints P_ints_sub(P_lane_ints k, P_lane_ints n)
{
    P_EACH(k.v[piece] = (P_piece_ints)((P_piece_words)k.v[piece] - (P_piece_words)n.v[piece]))
    return k;
}

static inline P_IN_KERNEL P_lane_ints P_ints_or(P_lane_ints k, P_lane_ints n)
{
    P_EACH(k.v[piece] = k.v[piece] | n.v[piece])
    return k;
}

/* Returns m ? k : 0. */
static inline P_IN_KERNEL P_lane_ints P_ints_keep(P_lane_mask m, P_lane_ints k)
{
    P_EACH(k.v[piece] = m.v[piece] & k.v[piece])
    return k;
}

static inline P_IN_KERNEL P_lane_mask P_ints_equal(P_lane_ints k, P_lane_ints n)
{
    P_lane_mask m;
#if P_SIMD_VECTORS
    P_EACH(m.v[piece] = k.v[piece] == n.v[piece])
#else
    P_EACH(m.v[piece] = -(k.v[piece] == n.v[piece]))
#endif
    return m;
}

#endif
