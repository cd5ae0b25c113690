// csm_visible - is a point lit in the scene that glbk_csm_bind bound: for your own shader.
// uses: csm_instances cohsm_visible

// self: the instance that the point lies on, or COHSM_NO_SELF. light: see cohsm_visible.glsl.
float csm_visible(uint self, cohsm_query query, vec3 point, vec3 light)
{
    return cohsm_visible_scene(0u, glbk_csm_scene.table.y, self, query, point, light);
}
