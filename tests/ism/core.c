/* core.c - the lines of bytes.c without near points, which the core of ism.h has none of: the whole header prints the
   same. tests/scripts/core.sh */

#define BYTES_NEAR_POINTS (-1)
#include "bytes.c"
