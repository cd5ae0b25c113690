/* ---- end of the declarations ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_ENVSHADOW_H */

/* ==== implementation ==================================================================================== */

#if defined(GL_ENVSHADOW_IMPLEMENTATION) && !defined(GL_ENVSHADOW_IMPLEMENTED)
#define GL_ENVSHADOW_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>
