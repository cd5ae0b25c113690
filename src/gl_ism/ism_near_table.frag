// Draws near points into the table of VPLs in their order, and before them the sphere about each 64 of them beyond
// which none reaches.
// uses: ism_choice
// with: screen.vert
layout(location = 0) out uvec4 result;

// Reads of the near point with a place in the order: place and edge; normal and reach; flux and VPL.
vec4 ism_sorted(uint i, uint k)
{
    ivec2 at = ism_cell_of(texelFetch(glbk_ism_near_order, ism_cell_of(i), 0).x);
    vec4 facts = ISM_FLOATS(glbk_ism_near_facts, at);
    return vec4(ISM_FLOATS(glbk_ism_near, ivec3(at, k)).xyz, k == 0u ? facts.x : k == 1u ? facts.y : facts.z);
}

vec4 ism_sphere(uint first, uint end)
{
    vec3 low = ism_sorted(first, 0u).xyz, high = low;
    for (uint i = first; i < end; i++) {
        low = min(low, ism_sorted(i, 0u).xyz);
        high = max(high, ism_sorted(i, 0u).xyz);
    }
    vec4 sphere = vec4(0.5 * (low + high), 0.0);
    for (uint i = first; i < end; i++)
        sphere.w = max(sphere.w, distance(ism_sorted(i, 0u).xyz, sphere.xyz) + ism_sorted(i, 1u).w);
    return sphere;
}

void main()
{
    uint count = ISM_C.near_point_count, at = (uint(gl_FragCoord.y) << 10) + uint(gl_FragCoord.x);
    uint i = at - ISM_C.first_near_point, block = 64u * (at - ISM_C.first_sphere);
    vec4 texel;
    if (at >= ISM_C.first_near_point && i < 3u * count) texel = ism_sorted(i / 3u, i % 3u);
    else if (at >= ISM_C.first_sphere && block < count) texel = ism_sphere(block, min(block + 64u, count));
    else discard;
    result = floatBitsToUint(texel);
}
