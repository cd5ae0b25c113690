/* csm_scalar.c - csm.h once more, without intrinsics, so that both kinds of query run in one program. */
#ifndef COHSM_NO_SIMD                  /* config=scalar defines it too */
#define COHSM_NO_SIMD
#endif
#define COHSM_STATIC
#define CSM_IMPLEMENTATION
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-function"     /* static, and only queries are wanted */
#endif
#include "bench.h"

cohsm_result bn_scalar_open(bn_scalar *scalar, const void *block, size_t size, cohsm_layout layout)
{
    return cohsm_open_as(block, size, layout, 0, NULL, &scalar->maps);
}

cohsm_result bn_scalar_visible(const bn_scalar *scalar, const cohsm_query *query, float *visible)
{
    return cohsm_visible(scalar->maps, query, visible, NULL);
}

void bn_scalar_free(bn_scalar *scalar)
{
    cohsm_free(scalar->maps);
    scalar->maps = NULL;
}
