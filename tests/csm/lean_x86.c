/* csm.h without its part x86: see lean_program.h. */
#include "lean_program.h"
