// envsh_light - returns the light of all directions with its shadows to your own shader, by what
// glbk_envsh_bind bound.
// uses: envsh_access envsh_disc envsh_visible

// Returns the query that was bound, with its defaults.
envsh_query envsh_bound_query()
{
    envsh_query q;
    q.radius = glbk_envsh_query.radius;
    q.bias = glbk_envsh_query.bias;
    q.extent_scale = glbk_envsh_query.extent_scale;
    q.taps = glbk_envsh_query.taps;
    q.seed = glbk_envsh_query.seed;
    q.side = int(glbk_envsh_scene.map_side);
    q.levels = int(glbk_envsh_scene.level_count);
    return q;
}

// Returns the irradiance of a point by all lights, W/m^2. Times albedo / pi it is the radiance of a diffuse
// surface. n is the shading normal, flat_n the surface's own. index turns the taps: give each pixel another
// one.
vec3 envsh_light(vec3 p, vec3 n, vec3 flat_n, uint index)
{
    return envsh_irradiance(envsh_bound_query(), 0u, glbk_envsh_scene.light_count, p, n, flat_n, index);
}
