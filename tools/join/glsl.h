/* glsl - the GLSL of a GL header: its files beside the C parts, the declarations made from the header's lists of
   bindings, and the table of all of them. */

#ifndef JOIN_GLSL_H
#define JOIN_GLSL_H

#include "text.h"

/* Everything as C strings. FOLDER holds the files, of which those of WITHOUT are left out, separated by blanks (NULL:
   none); SHARED holds those library files that NAMES lists, separated by blanks and without .glsl; OWN is the text of
   the header's parts, where the lists stand (GLBK_part_TEXTURES and so on); TABLE is the name of the array that is
   written last. */
void put_glsl(text *out, const char *folder, const char *shared, const char *names, const char *without,
              const text *own, const char *table);

#endif
