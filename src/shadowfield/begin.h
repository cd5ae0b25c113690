#ifdef __cplusplus
}
#endif

#endif /* SHADOWFIELD_H */

/* ==== implementation ==================================================================================== */

#if defined(SHADOWFIELD_IMPLEMENTATION) && !defined(SHADOWFIELD_IMPLEMENTED)

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The name by which this file includes itself (see kernels_begin.h). Define SFIELD_FILE if you renamed it. */
#ifndef SFIELD_FILE
#define SFIELD_FILE "shadowfield.h"
#endif
#define SFIELD__FILE SFIELD_FILE

#ifdef SFIELD_NO_SIMD
#define SFIELD__NO_SIMD
#define SFIELD__COMPILER_VECTORS
#endif
