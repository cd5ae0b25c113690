/* sfield_gpu.h - fields of shadowfield.h whose cubes gl_shadowfield.h draws and projects. */
#ifndef EX_SFIELD_GPU_H
#define EX_SFIELD_GPU_H

#include "gl_backend/gl_shadowfield.h"

typedef struct ex_sfield_gpu { glbk_context *gl; glbk_result result; } ex_sfield_gpu;

/* As sfield_build, or with radiance (of each triangle, one frame) as sfield_build_emissive. g->result is not GLBK_OK
   where OpenGL was the reason of SFIELD_ERR_CANCELLED. */
sfield_result ex_sfield_build(ex_sfield_gpu *g, const sfield_desc *desc, const sfield_mesh *mesh, const float *radiance,
                              sfield_field **out, sfield_stats *stats);

#endif
