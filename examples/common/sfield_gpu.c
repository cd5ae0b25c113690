/* sfield_gpu.c - shadowfield.h asks for what is seen from its sample points, gl_shadowfield.h answers. */
#include "sfield_gpu.h"

#include <string.h>

typedef struct asked { ex_sfield_gpu *g; glbk_sfield_builder builder; } asked;

static int see(void *user, const sfield_views *v)
{
    asked *a = user;
    a->g->result = glbk_sfield_builder_see(a->g->gl, &a->builder, v);
    return a->g->result != GLBK_OK;
}

sfield_result ex_sfield_build(ex_sfield_gpu *g, const sfield_desc *desc, const sfield_mesh *mesh, const float *radiance,
                              sfield_field **out, sfield_stats *stats)
{
    sfield_result result = SFIELD_ERR_CANCELLED;
    glbk_sfield_builder_desc d;
    asked a;
    memset(&d, 0, sizeof d);
    memset(&a, 0, sizeof a);
    a.g = g;
    d.field = desc;
    d.mesh = mesh;
    d.source = radiance != NULL;
    d.radiance = radiance;
    g->result = glbk_sfield_builder_create(g->gl, &d, &a.builder);
    if (g->result == GLBK_OK)
        result = sfield_build_views(desc, radiance != NULL, mesh, see, &a, out, stats);
    glbk_sfield_builder_free(g->gl, &a.builder);
    return result;
}
