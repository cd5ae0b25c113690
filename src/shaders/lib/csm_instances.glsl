// csm_instances - few instances of a scene, from the block that glbk_csm_bind binds.
// uses: csm_access
#ifdef CSM_INSTANCES                // 1 or 16: no more instances than that, in the uniform block with their headers
#define COHSM_INSTANCE(table, i, k) glbk_csm_scene.instances[11u * min(i, uint(CSM_INSTANCES) - 1u) + k]
#define COHSM_HEADER(i, k) COHSM_INSTANCE(0u, i, 3u + k)
#endif
