/* unit bytes: little-endian values in byte arrays, whatever the host's order and alignment */

static inline void P_put_u16(uint8_t *p, uint32_t v)
{
    p[0] = (uint8_t)(v & 255u);
    p[1] = (uint8_t)(v >> 8 & 255u);
}

static inline void P_put_u32(uint8_t *p, uint32_t v)
{
    P_put_u16(p, v & 0xffffu);
    P_put_u16(p + 2, v >> 16);
}

static inline void P_put_u64(uint8_t *p, uint64_t v)
{
    P_put_u32(p, (uint32_t)(v & 0xffffffffu));
    P_put_u32(p + 4, (uint32_t)(v >> 32));
}

static inline void P_put_f32(uint8_t *p, float v)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    P_put_u32(p, bits);
}

static inline uint16_t P_get_u16(const uint8_t *p) { return (uint16_t)(p[0] | p[1] << 8); }

static inline uint32_t P_get_u32(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static inline uint64_t P_get_u64(const uint8_t *p)
{
    return (uint64_t)P_get_u32(p) | (uint64_t)P_get_u32(p + 4) << 32;
}

static inline float P_get_f32(const uint8_t *p)
{
    uint32_t bits = P_get_u32(p);
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static inline int P_host_is_little_endian(void)
{
    uint16_t one = 1;
    uint8_t first;
    memcpy(&first, &one, 1);
    return first == 1;
}
