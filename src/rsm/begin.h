/* ==== implementation ==================================================================================== */

#if defined(RSM_IMPLEMENTATION) && !defined(RSM_IMPLEMENTED)

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The name of this file, by which it includes itself (see kernels_begin.h). Define RSM_FILE if you renamed
   it. */
#ifndef RSM_FILE
#define RSM_FILE "rsm.h"
#endif
#define RSM__FILE RSM_FILE

#ifdef RSM_NO_SIMD
#define RSM__NO_SIMD
#endif
