/* ---- end of the declarations ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_RSM_H */

/* ==== implementation ==================================================================================== */

#if defined(GL_RSM_IMPLEMENTATION) && !defined(GL_RSM_IMPLEMENTED)
#define GL_RSM_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>
