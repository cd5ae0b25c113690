/* ---- end of the declarations ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_GBUFFER_H */

/* ==== implementation ==================================================================================== */

#if defined(GL_GBUFFER_IMPLEMENTATION) && !defined(GL_GBUFFER_IMPLEMENTED)
#define GL_GBUFFER_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>
