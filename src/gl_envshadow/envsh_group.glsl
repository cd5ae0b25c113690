// envsh_group - finds out about a light for all points of a group at once, so that each point asks for few
// lights.
// uses: envsh_visible

struct envsh_group {
    vec3 low, high;                 // bounds of the points,
    vec3 n_low, n_high;             // of their shading normals,
    vec3 flat_low, flat_high;       // and of the surface's own normals
};

// Returns whether all vectors within the bounds point away from d.
bool envsh_all_under(vec3 low, vec3 high, vec3 d) { return dot(max(low * d, high * d), vec3(1.0)) < -1e-5; }

// Returns the greatest half width of the filter's kernel, in texels, for depths up to z.
vec2 envsh_group_reach(envsh_query q, envsh_view v, float z)
{
#if ENVSH_FILTER == 1
    return vec2(0.01);
#elif ENVSH_FILTER == 2
    return vec2(q.radius + 1.01);
#elif ENVSH_FILTER == 3
    return vec2(q.radius + 0.01);
#else       // the half axes grow with the depth; envsh_limit may lengthen one to 0.7
    vec2 a, b;
    envsh_kernel(q, v, z, a, b);
    return abs(a) + abs(b) + 0.71;
#endif
}

// Returns 1 if every point that faces the light is lit, 0 if no light reaches any, -1 if each has to be asked
// for. envsh_visible never answers otherwise for a point: a hundredth of a texel and 1e-6 of the sums stand
// for rounding.
int envsh_group_visible(envsh_query q, envsh_group g, uint light)
{
    vec3 d = envsh_direction(light), center = 0.5 * (g.low + g.high), extent = 0.5 * (g.high - g.low);
    if (envsh_all_under(g.n_low, g.n_high, d) || envsh_all_under(g.flat_low, g.flat_high, d)) return 0;
    envsh_view v = envsh_read_view(light);
    extent += 1.01 * q.bias * max(v.texel.x, v.texel.y);
    if (!all(lessThan(extent, vec3(1e15)))) return -1;
    vec4 middle = vec4(center, 1.0), wide = vec4(extent, 0.0) + 1e-6 * vec4(abs(center) + extent, 1.0);
    vec2 at = vec2(dot(v.row_x, middle), dot(v.row_y, middle));
    vec2 across = vec2(dot(abs(v.row_x), wide), dot(abs(v.row_y), wide));
    float z = dot(v.row_z, middle), deep = dot(abs(v.row_z), wide);
    vec3 n = 0.5 * (g.flat_low + g.flat_high), n_extent = 0.5 * (g.flat_high - g.flat_low);
    vec2 flat_n = abs(vec2(dot(n, v.right), dot(n, v.up)));
    flat_n += vec2(dot(n_extent, abs(v.right)), dot(n_extent, abs(v.up)));
    float cosine = max(dot(n, d) - dot(n_extent, abs(d)), 0.1);
    vec2 reach = envsh_group_reach(q, v, z + deep);
    float slope = 1.001 * dot(flat_n * v.texel, reach + 1.0) / (cosine * v.depth_range);
    return envsh_decide_box(q, v, at, across + reach, z - deep - min(slope, 1.001 * envsh_plane_limit(q, v)),
                            z + deep + slope);
}
