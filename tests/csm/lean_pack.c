/* csm.h without its part pack: see lean_program.h. */
#include "lean_program.h"
