/* ---- end of the declarations ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_CSM_H */

/* ==== implementation ==================================================================================== */

#if defined(GL_CSM_IMPLEMENTATION) && !defined(GL_CSM_IMPLEMENTED)
#define GL_CSM_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>
