/* ---- pack: the entropy-coded file ---- */

/* The packed file consists of

     4 words       "DCSP"; the format; the bytes of the file; the number of segments in the longest list
     the header of the plain block, and its locations, as they stand there
     the lists, coded; or, if the fourth word is 0, the rest of the plain block as it is

   The order table is left out, since it follows from the header. A list is coded as the first views of its
   segments, their depths, and the number of segments in each block. Everything else in the list follows from
   these, because blocks are written in one way only (see cohsm__plan_block). Every decision is a bit, coded
   with the adaptive probability of its context; contexts are made from the lists of the pixels to the left,
   above, and above to either side. The bits go through a range coder (Martin, "Range encoding", 1979). */

enum {
    COHSM__PACK_FORMAT = 1,
    COHSM__PACK_HEADER = 16,            /* bytes */
    COHSM__PACK_MULTIPLE = 64           /* of the file's size: the most memory that opening asks for */
};

typedef uint16_t cohsm__prob;           /* of a 1, in 1/65536 */

/* An encoder or a decoder. Both run the same lines of code, so that they cannot differ: each step takes the
   bit to encode, which a decoder ignores, and returns the bit that was encoded or decoded. */
typedef struct cohsm__coder {
    uint8_t       *out;                 /* NULL: decoding */
    const uint8_t *in;
    size_t         at, size;
    uint32_t       low, range, code;
    int            full;                /* the encoder ran out of room */
} cohsm__coder;

static void cohsm__coder_byte(cohsm__coder *c)
{
    if (c->out) {
        if (c->at < c->size) c->out[c->at++] = (uint8_t)(c->low >> 24);
        else c->full = 1;
        c->low <<= 8;
    } else c->code = c->code << 8 | (c->at < c->size ? c->in[c->at++] : 0u);    /* zeros beyond the end */
    c->range <<= 8;
}

static void cohsm__coder_start(cohsm__coder *c, uint8_t *out, const uint8_t *in, size_t size)
{
    int i;
    memset(c, 0, sizeof *c);
    c->out = out;
    c->in = in;
    c->size = size;
    for (i = 0; !out && i < 4; i++) cohsm__coder_byte(c);
    c->range = 0xffffffffu;
}

/* Codes a 1, to which the upper part of the range belongs; the lower part, which is `zero` long, belongs to a
   0. */
static void cohsm__coder_one(cohsm__coder *c, uint32_t zero)
{
    size_t i = c->at;
    c->range -= zero;
    if (!c->out) {
        c->code -= zero;
        return;
    }
    c->low += zero;
    if (c->low < zero)
        while (i && ++c->out[--i] == 0) {}          /* carry */
}

/* Codes a bit by an adaptive probability, which stays within 31..65505 of 65536, so that neither part of the
   range is ever empty. */
static inline uint32_t cohsm__code_bit(cohsm__coder *c, cohsm__prob *p, uint32_t bit)
{
    uint32_t zero = (c->range >> 12) * (4096u - (*p >> 4));
    if (!c->out) bit = c->code >= zero;
    if (bit) {
        cohsm__coder_one(c, zero);
        *p = (cohsm__prob)(*p + ((65536u - *p) >> 5));
    } else {
        c->range = zero;
        *p = (cohsm__prob)(*p - (*p >> 5));
    }
    while (c->range < 1u << 24) cohsm__coder_byte(c);
    return bit;
}

/* Codes a number of so many bits, high bits first. Each sequence of bits that went before has a probability
   of its own. */
static uint32_t cohsm__code_tree(cohsm__coder *c, cohsm__prob *p, uint32_t bits, uint32_t value)
{
    uint32_t node = 1;
    while (bits--) node = node << 1 | cohsm__code_bit(c, p + node, value >> bits & 1u);
    for (bits = 1; bits <= node >> 1; bits <<= 1) {}
    return node - bits;
}

/* Codes bits that are 0 or 1 with equal probability. */
static uint32_t cohsm__code_raw(cohsm__coder *c, uint32_t bits, uint32_t value)
{
    uint32_t out = 0, bit;
    while (bits--) {
        c->range >>= 1;
        bit = c->out ? value >> bits & 1u : c->code >= c->range;
        if (bit) {
            c->range <<= 1;
            cohsm__coder_one(c, c->range >> 1);
        }
        while (c->range < 1u << 24) cohsm__coder_byte(c);
        out = out << 1 | bit;
    }
    return out;
}

/* Returns the number of bits of x: 0 for 0, 1 for 1, 2 for 2 and 3, 3 for 4 to 7, ... */
static uint32_t cohsm__bit_length(uint32_t x)
{
    x |= x >> 1;
    x |= x >> 2;
    x |= x >> 4;
    x |= x >> 8;
    return cohsm__popcount(x | x >> 16);
}

enum { COHSM__NUMBER = 64 };                    /* probabilities that cohsm__code_number needs */

/* Codes a number below 2^31: the count of its bits, then the bits below the leading one, of which only the
   first has a probability. */
static uint32_t cohsm__code_number(cohsm__coder *c, cohsm__prob *p, uint32_t value)
{
    uint32_t bits = cohsm__code_tree(c, p, 5, cohsm__bit_length(value)), low;
    if (bits < 2) return bits;
    low = cohsm__code_bit(c, p + 32 + bits, value >> (bits - 2u) & 1u) << (bits - 2u);
    if (bits > 2) low |= cohsm__code_raw(c, bits - 2u, value);
    return 1u << (bits - 1u) | low;
}
