// ism_reach - how far near points reach, by the VPLs about them.
// uses: ism_choice

vec4 ism_drawn(uint v, int k) { return ISM_FLOATS(glbk_ism_drawn, ivec3(ism_cell_of(v), k)); }

// Returns twice the distance from p to the eighth of the VPLs about it, and finds the box of all VPLs and the
// nearest one, in whose choice alone VPLs with other normals count as farther.
float ism_reach_of(vec3 p, vec3 n, out uint nearest, out vec3 low, out vec3 high)
{
    vec4 a = vec4(1e30), b = a;                     // the least squared distances, in their order
    float best = 1e30;
    nearest = 0u;
    low = high = ism_drawn(0u, 0).xyz;
    for (uint i = 0u; i < ISM_C.vpl_count; i++) {
        vec3 at = ism_drawn(i, 0).xyz, d = at - p;
        float d2 = dot(d, d), cosine = dot(n, ism_drawn(i, 1).xyz);
        low = min(low, at);
        high = max(high, at);
        b = clamp(vec4(d2), vec4(a.w, b.xyz), b);
        a = vec4(min(d2, a.x), clamp(vec3(d2), a.xyz, a.yzw));
        if (!(cosine > 0.5)) d2 *= cosine > 0.0 ? 4.0 : 16.0;
        if (d2 < best) nearest = i;
        best = min(best, d2);
    }
    return 2.0 * sqrt(b.w);
}
