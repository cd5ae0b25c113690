/* ---- end of the declarations ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_BACKEND_H */

/* ==== implementation ==================================================================================== */

#if defined(GL_BACKEND_IMPLEMENTATION) && !defined(GL_BACKEND_IMPLEMENTED)
#define GL_BACKEND_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>
