// Draws of near points the edge of the square, the reach, the nearest VPL, and the place on Morton's curve
// through the box of the VPLs. A square has the texel's area, or that which the point stands for if it is
// larger, but no more than an eighth of the disc within its reach.
// uses: ism_reach
// with: screen.vert
layout(location = 0) out uvec4 result;

// Spreads ten bits over thirty, each at every third place.
uvec3 ism_spread_bits(uvec3 x)
{
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

void main()
{
    uint nearest;
    vec3 low, high;
    vec4 place = ISM_FLOATS(glbk_ism_near, ivec3(gl_FragCoord.xy, 0));
    vec3 n = ISM_FLOATS(glbk_ism_near, ivec3(gl_FragCoord.xy, 1)).xyz;
    float reach = ism_reach_of(place.xyz, n, nearest, low, high), disc = 3.14159265 * reach * reach, area = place.w;
    float count = float(ISM_C.near_point_count) / float(ISM_C.vpl_count);
    if (!(area > 0.0)) area = disc / (32.0 * count);
    if (dot(n, n) == 0.0) reach = 0.0;              // a black one
    high -= low;
    vec3 at = (place.xyz - low) / max(max(high.x, max(high.y, high.z)), 1e-30);
    uvec3 bits = ism_spread_bits(uvec3(clamp(at * 1024.0, 0.0, 1023.0)));
    result = uvec4(floatBitsToUint(vec3(sqrt(min(area, 0.125 * disc)), reach, float(nearest))),
                   bits.x | bits.y << 1 | bits.z << 2);
}
