/* ---- end of the declarations ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_ISM_H */

/* ==== implementation ==================================================================================== */

#if defined(GL_ISM_IMPLEMENTATION) && !defined(GL_ISM_IMPLEMENTED)
#define GL_ISM_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>
