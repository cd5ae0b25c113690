/* core.c - the lines of bytes.c without what the core of ism.h has none of: near points, points by what a VPL sees,
   windows, interleaved shading, filled holes, VPLs between texels. The whole header prints the same.
   tests/scripts/core.sh */

#define BYTES_CORE 1
#include "bytes.c"
