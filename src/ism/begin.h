/* ==== implementation ================================================================================== */

#if defined(ISM_IMPLEMENTATION) && !defined(ISM_IMPLEMENTED)

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The name of this file, by which it includes itself (see kernels_begin.h). Define ISM_FILE if you renamed
   it. */
#ifndef ISM_FILE
#define ISM_FILE "ism.h"
#endif
#define ISM__FILE ISM_FILE

#ifdef ISM_NO_SIMD
#define ISM__NO_SIMD
#endif
