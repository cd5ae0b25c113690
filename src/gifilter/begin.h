/* ==== implementation ==================================================================================== */

#if defined(GIFILTER_IMPLEMENTATION) && !defined(GIFILTER_IMPLEMENTED)

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The name of this file, by which it includes itself (see kernels_begin.h). Define GIFILT_FILE if you renamed
   it. */
#ifndef GIFILT_FILE
#define GIFILT_FILE "gifilter.h"
#endif
#define GIFILT__FILE GIFILT_FILE

#ifdef GIFILT_NO_SIMD
#define GIFILT__NO_SIMD
#endif
