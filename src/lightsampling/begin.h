/* ==== implementation ==================================================================================== */

#if defined(LIGHTSAMPLING_IMPLEMENTATION) && !defined(LIGHTSAMPLING_IMPLEMENTED)
#define LIGHTSAMPLING_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>
