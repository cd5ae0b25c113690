/* input.h - numbers from the bytes that a fuzzer gives. Behind the last byte all are 0. */
#ifndef DAPPLE_INPUT_H
#define DAPPLE_INPUT_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

typedef struct input { const uint8_t *data; size_t size, at; } input;

static inline input input_of(const uint8_t *data, size_t size)
{
    input in;
    in.data = data;
    in.size = size;
    in.at = 0;
    return in;
}

static inline uint32_t take(input *in) { return in->at < in->size ? in->data[in->at++] : 0u; }

/* Mostly in -1..1, seldom any bits at all. */
static inline float take_float(input *in)
{
    uint32_t a = take(in), b = take(in);
    if (a == 255) {
        uint32_t bits = b << 24 | take(in) << 16 | take(in) << 8 | take(in);
        float f;
        memcpy(&f, &bits, sizeof f);
        return f;
    }
    return (float)((int)(a << 8 | b) - 32640) / 32640.0f;
}

#endif
