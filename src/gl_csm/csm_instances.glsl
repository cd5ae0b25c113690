// csm_instances - reads instances of a scene from what glbk_csm_bind binds: up to 16 are in the block, more
// in a table.
// uses: csm_access
// If CSM_INSTANCES is defined, as 1 or 16, there are no more instances than that, and they stand in the
// uniform block with their headers.
#ifdef CSM_INSTANCES
#define COHSM_INSTANCE(table, i, k) glbk_csm_scene.instances[12u * min(i, uint(CSM_INSTANCES) - 1u) + k]
#define COHSM_HEADER(i, k) COHSM_INSTANCE(0u, i, 4u + k)
#if CSM_INSTANCES == 1
#define COHSM_ONE_INSTANCE      // tests of spheres are not worth it
#endif
#else
// Returns texel k of the record of instance i.
uvec4 csm_instance(uint i, uint k)
{
    if (glbk_csm_scene.in_block != 0u) return glbk_csm_scene.instances[12u * min(i, 15u) + k];
    return texelFetch(glbk_csm_instances, glbk_table_at(5u * i + k), 0);
}
#define COHSM_INSTANCE(table, i, k) csm_instance(i, k)
#endif
