/* ==== implementation ==================================================================================== */

#if defined(ENVLIGHTS_IMPLEMENTATION) && !defined(ENVLIGHTS_IMPLEMENTED)
#define ENVLIGHTS_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>
