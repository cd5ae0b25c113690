// csm_visible - is a point lit in the scene that glbk_csm_bind bound: for your own shader.
// uses: csm_instances cohsm_visible

// entity: the instance that the point lies on, counted from 1, or 0 for none. light: see cohsm_visible.glsl.
float csm_visible(uint entity, cohsm_query query, vec3 point, vec3 light)
{
    return cohsm_visible_scene(0u, glbk_csm_scene.table.y, entity, query, point, light);
}
