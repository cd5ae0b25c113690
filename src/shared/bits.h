/* unit bits: counting and finding bits */

/* Returns how many bits of x are set. */
static inline uint32_t P_popcount(uint64_t x)
{
    x -= x >> 1 & 0x5555555555555555u;
    x = (x & 0x3333333333333333u) + (x >> 2 & 0x3333333333333333u);
    x = (x + (x >> 4)) & 0x0f0f0f0f0f0f0f0fu;
    return (uint32_t)(x * 0x0101010101010101u >> 56);
}

/* Returns eight bytes: each is 1 if the same byte of `bytes`, which lies in 0..127, is at least x, otherwise
   0. */
static inline uint64_t P_bytes_from(uint64_t bytes, uint32_t x)
{
    const uint64_t ones = 0x0101010101010101u, tops = 0x8080808080808080u;
    return (((bytes | tops) - x * ones) & tops) >> 7;
}

/* Returns the position of the set bit that has this number, counted from 0, among the set bits of x; 64 if x
   has fewer. The counts of bits up to each byte give the byte, those up to each bit of that byte the
   position. */
static inline uint32_t P_select_bit(uint64_t x, uint32_t number)
{
    const uint64_t ones = 0x0101010101010101u;
    uint64_t upto;
    uint32_t at;

    number = number < 127 ? number + 1u : 127u;
    upto = x - (x >> 1 & 0x5555555555555555u);
    upto = (upto & 0x3333333333333333u) + (upto >> 2 & 0x3333333333333333u);
    upto = ((upto + (upto >> 4)) & 0x0f0f0f0f0f0f0f0fu) * ones;
    at = 64u - 8u * (uint32_t)(P_bytes_from(upto, number) * ones >> 56);
    if (at == 64) return 64;
    number -= (uint32_t)(upto << 8 >> at) & 255u;
    /* The eight bits of that byte are spread over eight bytes, and counted up to each. */
    upto = (((x >> at & 255u) * ones & 0x8040201008040201u) + 0x7f7f7f7f7f7f7f7fu) >> 7 & ones;
    return at + 8u - (uint32_t)(P_bytes_from(upto * ones, number) * ones >> 56);
}
