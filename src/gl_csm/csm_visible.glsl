// csm_visible - says for your own shader whether a point is lit in the scene that glbk_csm_bind bound.
// uses: csm_instances cohsm_visible

// Returns 1 lit, 0 dark, between them with PCF, or COHSM_REFUSED. entity is the instance that the point lies
// on, counted from 1, or 0 for none. light is what query.light says (cohsm_visible.glsl).
float csm_visible(uint entity, const in cohsm_query query, vec3 point, vec3 light)
{
    return cohsm_visible_scene(0u, glbk_csm_scene.count, entity, query, point, light);
}
