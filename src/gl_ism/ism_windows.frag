// Draws the windows of the VPLs' tiles, which hold the receivers of ism_sights.frag that look at the VPL. A side stays
// where it was in the frame before if it lies no more than two 64ths farther out than it must. Of each VPL: its
// place; the window, in seven bits more its face, in the last bit whether the window is too wide for a rim.
// uses: ism_map ism_choice
// with: screen.vert
// sets: ISM_PROJECTION=1 | ISM_PROJECTION=2
layout(location = 0) out uvec4 result;

vec4 ism_drawn(ivec2 at, int k) { return ISM_FLOATS(glbk_ism_drawn, ivec3(at, k)); }

void main()
{
    ivec2 at = ISM_HERE;
    vec4 facing = ism_drawn(at, 1), across, down;
    vec3 place = ism_drawn(at, 0).xyz;
    uint face = (uint(ism_drawn(at, 2).w) & 127u) << 24, side = glbk_ism_frame.tile_side, window = 0u;
    uvec4 before = texelFetch(glbk_ism_windows, at, 0);
    vec2 lo = vec2(1.0), hi = vec2(0.0), uv;
    mat3 basis = ism_basis_of(facing.xyz);
    for (int i = 0; i < 512; i++) {
        vec4 p = ISM_FLOATS(glbk_ism_sights, ivec3(i & 63, i >> 6, 0));
        vec3 n = ISM_FLOATS(glbk_ism_sights, ivec3(i & 63, i >> 6, 1)).xyz;
        vec3 d = p.xyz - place, l = d * basis;
        bool before_it = ism_map_coordinates(ism_projection_of(1.0), 1.0, l / length(l), uv);
        if (before_it && p.w > 0.0 && dot(n, d) < 0.0) {
            lo = min(lo, uv);
            hi = max(hi, uv);
        }
    }
    vec2 pad = (hi - lo) * 0.015625;
    uvec4 need = uvec4(clamp(64.0 * vec4(lo - pad, hi + pad), 0.0, 63.0));
    need.zw = 63u - need.zw;
    uvec4 was = ism_cut(before.w);
    vec3 moved = place - uintBitsToFloat(before.xyz);
    bool known = ISM_C.windows == 2u && (before.w & 0x7f000000u) == face;
    known = known && dot(moved, moved) <= facing.w * facing.w;
    uvec4 kept = uvec4(lessThanEqual(was, need)) * uvec4(greaterThanEqual(was + 2u, need));
    if (known) need += (was - need) * kept;
    if (lo.x <= hi.x) window = need.x | need.y << 6 | need.z << 12 | need.w << 18;
    ism_axes(window, side, glbk_ism_frame.window_rim, across, down);
    if (min(across.x, down.x) >= float(side)) face |= 0x80000000u;
    result = uvec4(floatBitsToUint(place), window | face);
}
