// Counts samples into texels: the alpha of four neighbours, or the radiance of a texel.
// uses: sfield_bindings
// with: sfield_sum.vert
// sets: SFIELD_SOURCE=0 | SFIELD_SOURCE=1
flat in uint sfield_tile;
layout(location = 0) out uvec4 texels;

void main()
{
    uvec4 place = glbk_sfield_views.places[sfield_tile];
    int width = int(glbk_sfield_views.width), side = int(glbk_sfield_views.side), scale = width / side;
    ivec2 at = ivec2(gl_FragCoord.xy), tile = ivec2(place.zw) * width;
    float share = 1.0 / float(scale * scale);
#if SFIELD_SOURCE
    ivec2 from = tile + (at - ivec2(place.xy) * side) * scale;
    vec3 sum = vec3(0.0);
    for (int y = 0; y < scale; y++)
        for (int x = 0; x < scale; x++)
            sum += uintBitsToFloat(texelFetch(glbk_sfield_seen, from + ivec2(x, y), 0).xyz);
    texels = uvec4(floatBitsToUint(sum * share), 0u);
#else
    ivec2 from = tile + (at - ivec2(int(place.x) * side / 4, int(place.y) * side)) * ivec2(4 * scale, scale);
    uvec4 sum = uvec4(0u);
    for (int y = 0; y < scale; y++)
        for (int x = 0; x < scale; x++) {
            ivec2 p = from + ivec2(x, y), next = ivec2(scale, 0);
            sum.x += texelFetch(glbk_sfield_seen, p, 0).x;
            sum.y += texelFetch(glbk_sfield_seen, p + next, 0).x;
            sum.z += texelFetch(glbk_sfield_seen, p + 2 * next, 0).x;
            sum.w += texelFetch(glbk_sfield_seen, p + 3 * next, 0).x;
        }
    texels = floatBitsToUint(vec4(sum) * share);
#endif
}
