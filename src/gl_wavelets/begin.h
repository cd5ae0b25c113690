/* ---- end of the declarations ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_WAVELETS_H */

/* ==== implementation ==================================================================================== */

#if defined(GL_WAVELETS_IMPLEMENTATION) && !defined(GL_WAVELETS_IMPLEMENTED)
#define GL_WAVELETS_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>
