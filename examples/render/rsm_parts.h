/* rsm_parts.h - what the files of the technique "rsm" share. */
#ifndef RS_PARTS_H
#define RS_PARTS_H

#include "technique.h"
#include "../../rsm.h"

typedef struct rs_memory { uint64_t now, peak; } rs_memory;

/* The scene's lights as lights of rsm.h: one for each sun, spot and point; `points` for all area lights and emitters
   together, in proportion to their power; `points` directions for a sky. *lights is freed with free(). */
int rs_lights_build(rsm_light **lights, size_t *count, const rd_job *job, uint32_t points, char *error);

#endif
