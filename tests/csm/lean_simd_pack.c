/* csm.h without its parts simd and pack: see lean_program.h. */
#include "lean_program.h"
