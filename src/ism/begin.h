/* ==== implementation ================================================================================== */

#if defined(ISM_IMPLEMENTATION) && !defined(ISM_IMPLEMENTED)

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* This file includes itself by this name, to compile its kernels once more for AVX2 and for AVX-512. If you
   renamed the file, define ISM_FILE. */
#ifndef ISM_FILE
#define ISM_FILE "ism.h"
#endif
#define ISM__FILE ISM_FILE

#ifdef ISM_NO_SIMD
#define ISM__NO_SIMD
#endif
