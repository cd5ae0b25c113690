/* fold - decides the #if of a text by macros whose values are known, and leaves out what they exclude. */

#ifndef JOIN_FOLD_H
#define JOIN_FOLD_H

#include "text.h"

/* values: "NAME=3 OTHER" separated by blanks; a name without a value is not defined. Replaces the text by one without
   the branches that are not taken and without the #if that nothing depends on any more. */
void fold(text *t, const char *values);

#endif
