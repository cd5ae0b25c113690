/* ==== implementation ================================================================================== */

#if defined(ISM_IMPLEMENTATION) && !defined(ISM_IMPLEMENTED)
#define ISM_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>

#ifdef ISM_NO_SIMD
#define ISM__NO_SIMD
#endif
