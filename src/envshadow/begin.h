/* ==== implementation ==================================================================================== */

#if defined(ENVSHADOW_IMPLEMENTATION) && !defined(ENVSHADOW_IMPLEMENTED)
#define ENVSHADOW_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>
