// Draws about which share of the maps of VPLs the clusters of triangles fill: their cosine-weighted solid angles,
// in the map of a sky's VPL their projected areas, times the zoom of the tile's window. A sequence a VPL.
// uses: cohsm_math ism_access ism_fold
// with: screen.vert
layout(location = 0) out uint result;

struct ism_cluster {
    float area, radius2;
    vec3  at, squares, mixed;       // squares and mixed: the mean of n n^T
};

ism_cluster ism_read_cluster(uint c)
{
    ivec3 at = ivec3(ism_fold(c, ISM_S.cluster_count, 0u), 0);
    vec4 place = ISM_FLOATS(glbk_ism_clusters, at);
    vec3 squares = ISM_FLOATS(glbk_ism_clusters, at + ivec3(0, 0, 1)).xyz;
    vec3 mixed = ISM_FLOATS(glbk_ism_clusters, at + ivec3(0, 0, 2)).xyz;
    return ism_cluster(ISM_FLOATS(glbk_ism_masses, at.xy).x, place.w, place.xyz, squares, mixed);
}

// Returns the mean square of n . l over the normals of a cluster.
float ism_facing2(ism_cluster c, vec3 l)
{
    return max(dot(c.squares, l * l) + 2.0 * dot(c.mixed, l.yzx * l.zxy), 0.0);
}

float ism_cluster_effect(ism_cluster c, ism_vpl v)
{
    if (!(c.area > 0.0)) return 0.0;
    if (v.sky) return c.area * sqrt(ism_facing2(c, v.normal));
    vec3 l = c.at - v.position;
    float away2 = dot(l, l), wide = 0.16 * c.area, d2 = away2 + c.radius2 + wide;
    float along = dot(l, v.normal) + sqrt(c.radius2);
    float facing2 = ism_facing2(c, l) + c.radius2 + wide;       // close clusters are seen from all sides
    float effect = c.area * sqrt(facing2) * (along / (d2 * d2));
    if (!(along > 0.0)) effect = 0.0;
    if (!(away2 > 0.0)) effect = 1.0;
    return effect;
}

// Returns how many times longer the range within r of u is in the tile than in the square.
float ism_box_zoom(vec4 axis, float u, float r)
{
    float size = float(ISM_F.tile_side), rim = float(ISM_F.window_rim);
    float low = max(u - r, 0.0), high = min(u + r, 1.0), from = low, to = high;
    if (axis.x < size) {
        from = ism_zoom_axis(axis, size, rim, low) / size;
        to = ism_zoom_axis(axis, size, rim, high) / size;
    }
    return (to - from) / (high - low);
}

// Returns about how many times more texels a cluster has than in a map that shows the square evenly. Clusters
// behind the horizon, which may have a part before the horizon, count as on the horizon.
float ism_cluster_zoom(ism_cluster c, ism_vpl v)
{
    vec3 origin = v.position, at;
    float d = ISM_F.sphere.w, r = sqrt(c.radius2);
    vec2 uv;
    bool seen;
    if (v.sky) origin = ISM_F.sphere.xyz;
    at = c.at - origin;
    if (!v.sky) {
        float below = dot(v.basis[2], at);
        d = length(at);
        if (0.05 * d > below) at += v.basis[2] * (0.05 * d - below);
    }
    at = at * v.basis;
    if (v.sky) {
        uv = 0.5 * at.xy / d + 0.5;
        seen = fract(uv) == uv;         // within 0..1, 1 left out
    } else {
        seen = ism_map_coordinates(ism_projection_of(v.exponent), v.exponent, at / length(at), uv);
    }
    r = max(0.5 * r / d, 0.01);         // a radian is about half the square
    float zoom = ism_box_zoom(v.grid.across, uv.x, r) * ism_box_zoom(v.grid.down, uv.y, r);
    return cohsm_if(seen, zoom, 1.0);
}

void main()
{
    uint count = ISM_S.cluster_count;
    uvec2 place = ism_unfold(count);
    uint v = ISM_S.first_vpl + place.y;
    float effect = 0.0;
    if (place.x < count && v < ISM_F.vpl_count) {
        ism_cluster c = ism_read_cluster(place.x);
        ism_vpl l = ism_read_vpl(v);
        effect = ism_cluster_effect(c, l);
        if (effect > 0.0 && l.window != 0u) effect *= ism_cluster_zoom(c, l);
        if (!cohsm_finite(effect)) effect = 0.0;
    }
    result = floatBitsToUint(effect);
}
