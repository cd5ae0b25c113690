// Draws the table of VPLs, four texels each, from the pictures of ism_choose.frag, and finds meanwhile the edges
// of the squares that VPLs become for receivers near by. A square has the VPL's area, but reaches no farther
// than its neighbours are. VPLs at one place share a square of their areas' sum. The tiles' windows are added.
// uses: ism_reach
// with: screen.vert
layout(location = 0) out uvec4 result;

float ism_edge(uint v, vec3 p, vec3 n, float area)
{
    vec4 near2 = vec4(1e30);            // the least squared distances to others
    for (uint i = 0u; i < ISM_C.vpl_count; i++) {
        vec4 other = ism_drawn(i, 0);
        vec3 d = other.xyz - p;
        float d2 = dot(d, d);
        bool beside = i != v && d2 < near2.w && dot(n, ism_drawn(i, 1).xyz) >= 0.5;
        if (beside && !(d2 > 0.0)) area += other.w;
        if (beside && d2 > 0.0) near2 = vec4(min(d2, near2.x), clamp(vec3(d2), near2.xyz, near2.yzw));
    }
    float most = 0.0;
    if (near2.w < 1e30) most = 3.14159265 * near2.w;
    if (!(area > 0.0)) area = 0.25 * most;
    else if (most > 0.0) area = min(area, 2.0 * most);
    return sqrt(area);
}

void main()
{
    uint at = uint(gl_FragCoord.y) * 1024u + uint(gl_FragCoord.x), v = at >> 2, part = at & 3u;
    vec4 place = ism_drawn(v, 0), normal = ism_drawn(v, 1), texel;
    bool black = dot(normal.xyz, normal.xyz) == 0.0;
    if (black) normal.z = 1.0;
    if (part == 0u) texel = vec4(place.xyz, 1.0);       // the exponent of diffuse VPLs
    else if (part == 2u) texel = vec4(ism_drawn(v, 2).xyz, 0.0);
    else texel = vec4(normal.xyz, 0.0);
    uint nearest;
    vec3 low, high;
    bool reaches = part == 2u && !black && ISM_C.near_point_count > 0u;
    if (reaches) texel.w = ism_reach_of(place.xyz, normal.xyz, nearest, low, high);
    if (part == 1u && !black) texel.w = ism_edge(v, place.xyz, normal.xyz, place.w);
    if (part == 3u && ISM_C.windows != 0u) {
        uint window = texelFetch(glbk_ism_windows, ism_cell_of(v), 0).w;
        if (window >> 31 == 0u) texel.w = float(window & 0xffffffu);
    }
    result = floatBitsToUint(texel);
}
