/* csm.h without its parts x86 and pack: see lean_program.h. */
#include "lean_program.h"
