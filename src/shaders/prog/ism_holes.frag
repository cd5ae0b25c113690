// 1 where a texel keeps its surfel, 0 where it is empty or where surfels in all four quadrants about it pass before it.
// uses: ism_fill
// with: screen.vert
// sets: ISM_PROJECTION=1 | ISM_PROJECTION=4
layout(location = 0) out uint result;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    int size = int(glbk_ism_frame.maps.y);
    ivec2 local = at & (size - 1);
    vec4 c = ism_surfel_at(at);
    uint found = 0u, v = ism_tile_of(at);
    result = 0u;
    if (!(c.w < ISM_FAR) || v >= glbk_ism_frame.maps.x) return;
    result = 1u;
    if (glbk_ism_frame.points.z == 0u) return;
    float kind = ism_kind(v);
    vec3 w = ism_texel_direction(kind, local);
    for (int dy = -ISM_HOLE; dy <= ISM_HOLE; dy++)
        for (int dx = -ISM_HOLE; dx <= ISM_HOLE; dx++) {
            ivec2 d = ivec2(dx, dy), there = local + d;
            if (any(lessThan(there, ivec2(0))) || any(greaterThanEqual(there, ivec2(size)))) {
                found |= ism_quadrant(d);
                continue;
            }
            vec4 n = ism_surfel_at(at + d);
            if (!(n.w < 0.9 * c.w)) continue;
            float t = ism_plane_depth(kind < 0.0, n.xyz, w);
            if (t > 0.5 * n.w && t < 0.95 * c.w) found |= ism_quadrant(d);
        }
    if (found == 15u) result = 0u;
}
