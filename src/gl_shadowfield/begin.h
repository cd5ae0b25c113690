/* ---- end of the declarations ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_SHADOWFIELD_H */

/* ==== implementation ==================================================================================== */

#if defined(GL_SHADOWFIELD_IMPLEMENTATION) && !defined(GL_SHADOWFIELD_IMPLEMENTED)
#define GL_SHADOWFIELD_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>
