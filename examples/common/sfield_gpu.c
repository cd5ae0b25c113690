/* sfield_gpu.c - shadowfield.h asks for what is seen from its sample points, gl_backend.h answers. */
#include "sfield_gpu.h"

#include <stdlib.h>
#include <string.h>

typedef struct asked { ex_sfield_gpu *g; glbk_sfield_builder builder; } asked;

static int see(void *user, const sfield_views *v)
{
    asked *a = user;
    a->g->result = glbk_sfield_builder_see(a->g->gl, &a->builder, v->center, v->radius, v->count, v->eyes, v->values);
    return a->g->result != GLBK_OK;
}

/* bands^2 floats for each texel; NULL for wavelets, or without memory. */
static float *basis_of(uint32_t bands, uint32_t side)
{
    const size_t texels = 6 * (size_t)side * side, n = (size_t)bands * bands;
    float *basis = bands ? malloc(texels * n * sizeof *basis) : NULL;
    for (size_t i = 0; basis && i < texels; i++)
        if (sfield_cube_basis(bands, side, (uint32_t)i, basis + i * n) != SFIELD_OK) {
            free(basis);
            return NULL;
        }
    return basis;
}

sfield_result ex_sfield_build(ex_sfield_gpu *g, const sfield_desc *desc, const sfield_mesh *mesh, const float *radiance,
                              sfield_field **out, sfield_stats *stats)
{
    const int haar = desc->basis == SFIELD_BASIS_HAAR;
    glbk_sfield_builder_desc d;
    sfield_result result;
    float *basis;
    asked a;
    memset(&d, 0, sizeof d);
    memset(&a, 0, sizeof a);
    a.g = g;
    d.cube_side = desc->cube_side ? desc->cube_side : haar ? 32 : 16;
    d.bands = haar ? 0 : desc->bands ? desc->bands : 4;
    d.basis = basis = basis_of(d.bands, d.cube_side);
    d.source = radiance != NULL;
    d.positions = mesh->positions;
    d.vertex_count = mesh->vertex_count;
    d.vertex_stride = mesh->vertex_stride;
    d.indices = mesh->indices;
    d.index_count = mesh->index_count;
    d.radiance = radiance;
    g->result = d.bands && !basis ? GLBK_ERR_ALLOC : glbk_sfield_builder_create(g->gl, &d, &a.builder);
    free(basis);
    result = SFIELD_ERR_CANCELLED;
    if (g->result == GLBK_OK)
        result = sfield_build_views(desc, radiance != NULL, mesh, see, &a, out, stats);
    glbk_sfield_builder_destroy(g->gl, &a.builder);
    return result;
}
