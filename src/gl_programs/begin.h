/* ---- end of the declarations ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_PROGRAMS_H */

/* ==== implementation ==================================================================================== */

#if defined(GL_PROGRAMS_IMPLEMENTATION) && !defined(GL_PROGRAMS_IMPLEMENTED)
#define GL_PROGRAMS_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>
