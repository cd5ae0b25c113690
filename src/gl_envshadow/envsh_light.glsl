// envsh_light - light of all directions with its shadows, for your own shader: what glbk_envsh_bind bound.
// uses: envsh_access envsh_disc envsh_visible
envsh_query envsh_bound_query()
{
    vec4 values = glbk_envsh_query.values;
    return envsh_query(values.x, values.y, values.z, glbk_envsh_query.numbers.x, glbk_envsh_query.numbers.y,
                       int(glbk_envsh_scene.tiles.x), int(glbk_envsh_scene.range.y));
}

// Irradiance, W/m^2: times albedo / pi it is the radiance of a diffuse surface. index: another for each pixel.
vec3 envsh_light(vec3 p, vec3 n, vec3 flat_n, uint index)
{
    return envsh_irradiance(envsh_bound_query(), 0u, glbk_envsh_scene.range.x, p, n, flat_n, index);
}
