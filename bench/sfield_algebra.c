/* sfield_algebra.c - products, rotations and dot products of spherical harmonics a second, on one core, beside plain
   loops in the same run: one vector at a time over the non-zero tensor (i >= j, both halves of the symmetry used) and
   over the blocks of a rotation. 256 vectors, so that everything stays in the first cache levels. */
#define SFIELD_STATIC
#define SHADOWFIELD_IMPLEMENTATION
#include "shadowfield.h"
#include "sfield_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { VECTORS = 256 };

typedef struct plain_entry { uint32_t i, j; float c; } plain_entry;

typedef struct tables {
    sfield_algebra *algebra;
    sfield_rotation rotation;
    plain_entry    *entry;
    uint32_t        first[SFIELD_MAX_COEFS + 1];
    float          *a, *b, *out;                 /* planes, and one vector after the other: the same numbers will do */
} tables;

typedef void (*operation)(const tables *t);

/* C_ijk = 0 left out; i = j counts half, so that a_i b_j + a_j b_i serves both. */
static int make_entries(tables *t)
{
    uint32_t n = t->algebra->coefs, i, j, k, used = 0;
    t->entry = malloc((size_t)n * n * (n + 1) / 2 * sizeof *t->entry);
    if (!t->entry)
        return -1;
    for (k = 0; k < n; k++) {
        t->first[k] = used;
        for (i = 0; i < n; i++)
            for (j = 0; j <= i; j++) {
                float a[SFIELD_MAX_COEFS] = { 0 }, b[SFIELD_MAX_COEFS] = { 0 }, c[SFIELD_MAX_COEFS];
                a[i] = b[j] = 1;
                sfield_sh_product(t->algebra, 1, a, b, c, 1);
                if (fabsf(c[k]) < 1e-6f)
                    continue;
                t->entry[used].i = i;
                t->entry[used].j = j;
                t->entry[used++].c = i == j ? 0.5f * c[k] : c[k];
            }
    }
    t->first[n] = used;
    return 0;
}

static void plain_product(const tables *t)
{
    uint32_t n = t->algebra->coefs, v, k, e;
    for (v = 0; v < VECTORS; v++) {
        const float *a = t->a + v * n, *b = t->b + v * n;
        for (k = 0; k < n; k++) {
            float sum = 0;
            for (e = t->first[k]; e < t->first[k + 1]; e++) {
                const plain_entry *p = &t->entry[e];
                sum += p->c * (a[p->i] * b[p->j] + a[p->j] * b[p->i]);
            }
            t->out[v * n + k] = sum;
        }
    }
}

static void plain_rotate(const tables *t)
{
    uint32_t n = t->algebra->coefs, v, l, x, y;
    for (v = 0; v < VECTORS; v++) {
        const float *m = t->rotation.block;
        for (l = 0; l < t->algebra->bands; l++) {
            const float *in = t->a + v * n + l * l;
            float *out = t->out + v * n + l * l;
            for (y = 0; y < 2 * l + 1; y++) {
                float sum = 0;
                for (x = 0; x < 2 * l + 1; x++)
                    sum += *m++ * in[x];
                out[y] = sum;
            }
        }
    }
}

static void plain_dot(const tables *t)
{
    uint32_t n = t->algebra->coefs, v, k;
    for (v = 0; v < VECTORS; v++) {
        float sum = 0;
        for (k = 0; k < n; k++)
            sum += t->a[v * n + k] * t->b[v * n + k];
        t->out[v] = sum;
    }
}

static void fast_product(const tables *t)
{
    sfield_sh_product(t->algebra, VECTORS, t->a, t->b, t->out, VECTORS);
}

static void fast_rotate(const tables *t)
{
    for (uint32_t i = 0; i < VECTORS; i += SFIELD__LANES)
        sfield__rotate16(&t->rotation, t->a + i, t->out + i, VECTORS, 0, t->algebra->simd);
}

static void fast_dot(const tables *t)
{
    sfield_sh_dot(t->algebra->bands, VECTORS, t->a, t->b, t->out, VECTORS);
}

/* Millions a second: the best of several short runs, since other programs may run beside. */
static double speed(operation run, const tables *t)
{
    double best = 0;
    for (int round = 0; round < 8; round++) {
        double start = ex_seconds(), spent;
        uint64_t done = 0;
        do {
            for (int i = 0; i < 16; i++)
                run(t);
            done += 16 * VECTORS;
            spent = ex_seconds() - start;
        } while (spent < 0.03);
        if ((double)done / spent > best)
            best = (double)done / spent;
    }
    return best * 1e-6;
}

static void report(const bn_options *options, const char *op, uint32_t bands, int simd, double mops, double baseline)
{
    static const char *const names[] = { "none", "avx2", "avx512" };
    bn_begin(options, "sfield_algebra", 1, names[simd]);
    bn_text("op", op);
    bn_integer("bands", bands);
    bn_number("mops", mops);
    bn_number("baseline_mops", baseline);
    bn_number("ratio", mops / baseline);
    bn_end(options);
}

static int one(const bn_options *options, uint32_t bands)
{
    static const struct { const char *op; operation fast, plain;
    } ops[] = { { "product", fast_product, plain_product },
                { "rotate", fast_rotate, plain_rotate },
                { "dot", fast_dot, plain_dot } };
    static const float turn[16] = { 0.36f, 0.48f, -0.8f, 0, -0.8f, 0.6f, 0, 0, 0.48f, 0.64f, 0.6f, 0, 0, 0, 0, 1 };
    tables t;
    int result = -1;
    size_t n = SFIELD_MAX_COEFS * VECTORS;
    memset(&t, 0, sizeof t);
    t.a = malloc(3 * n * sizeof *t.a);
    if (t.a && sfield_algebra_create(bands, NULL, &t.algebra) == SFIELD_OK && make_entries(&t) == 0 &&
        sfield_sh_rotation(t.algebra, turn, &t.rotation) == SFIELD_OK) {
        int best = t.algebra->simd;
        t.b = t.a + n;
        t.out = t.b + n;
        for (size_t i = 0; i < 2 * n; i++)
            t.a[i] = (float)(i * 2654435761u % 1000u) * 0.002f - 1;
        for (size_t i = 0; i < 3; i++) {
            double plain = speed(ops[i].plain, &t);
            for (t.algebra->simd = 0; t.algebra->simd <= best; t.algebra->simd++)
                report(options, ops[i].op, bands, t.algebra->simd, speed(ops[i].fast, &t), plain);
            t.algebra->simd = best;
        }
        result = 0;
    }
    free(t.entry);
    free(t.a);
    sfield_algebra_free(t.algebra);
    return result == 0 ? 0 : bn_failed("sfield_algebra", "out of memory");
}

int bn_sfield_algebra(const bn_options *options)
{
    for (uint32_t bands = options->full ? 2 : 3; bands <= (options->full ? 8u : 5u); bands++)
        if (one(options, bands) != 0)
            return -1;
    return 0;
}

const char *bn_sfield_simd(void)
{
    static const char *const names[] = { "none", "avx2", "avx512" };
    return names[sfield__simd_level()];
}
