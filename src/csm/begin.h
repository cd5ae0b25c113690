/* ==== implementation ==================================================================================== */

#if defined(CSM_IMPLEMENTATION) && !defined(CSM_IMPLEMENTED)

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The name of this file, by which it includes itself (see kernels_begin.h). Define COHSM_FILE if you renamed
   it. */
#ifndef COHSM_FILE
#define COHSM_FILE "csm.h"
#endif
#define COHSM__FILE COHSM_FILE

#ifdef COHSM_NO_SIMD
#define COHSM__NO_SIMD
#define COHSM__COMPILER_VECTORS
#endif
