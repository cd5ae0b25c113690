/* csm.h without its part simd: see lean_program.h. */
#include "lean_program.h"
