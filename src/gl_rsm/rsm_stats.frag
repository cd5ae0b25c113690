// Counts a row of a map's texels in each pixel: x is the row, y is 3 face + 0 for the number of texels with
// flux, 1 for the light that falls on texels with a surface, 2 for the light that leaves them.
// uses: rsm_bindings rsm_access rsm_bound
// with: screen.vert
layout(location = 0) out uvec4 result;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    int face = at.y / 3, what = at.y - 3 * face, size = int(glbk_rsm_light.side);
    rsm_light l = rsm_bound();
    uint lit = 0u;
    vec3 sum = vec3(0.0);
    for (int i = 0; i < size; i++) {
        ivec3 t = ivec3(i, at.x, face);
        vec3 flux = uintBitsToFloat(RSM_TEXEL(t, 2).xyz);
        lit += rsm_mean3(flux) > 0.0 ? 1u : 0u;
        if (what == 0 || !(uintBitsToFloat(RSM_TEXEL(t, 0).w) < 3.0e38)) continue;
        sum += what == 1 ? rsm_incident(l, face, t.xy) * l.value : flux;
    }
    result = what == 0 ? uvec4(lit, 0u, 0u, 0u) : uvec4(floatBitsToUint(sum), 0u);
}
