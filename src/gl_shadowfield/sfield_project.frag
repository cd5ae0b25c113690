// Projects a cube on four functions of the basis: sums its texels times the integrals of these over each. A
// column is a group of four, with all groups of one channel before those of the next; a row is an eye. The
// twin is sfield_sh_project.
// uses: table sfield_bindings
// with: screen.vert
// sets: SFIELD_SOURCE=0 | SFIELD_SOURCE=1
layout(location = 0) out uvec4 coefs;

// Returns the integrals of four functions of the basis over a texel.
vec4 sfield_basis_at(uint i) { return uintBitsToFloat(texelFetch(glbk_sfield_basis, glbk_table_at(i), 0)); }

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    int side = int(glbk_sfield_views.side);
    uint group = uint(at.x) % glbk_sfield_views.groups, channel = uint(at.x) / glbk_sfield_views.groups;
    uint cell = group * uint(6 * side * side);
    vec4 sum = vec4(0.0);
#if SFIELD_SOURCE
    int width = 6 * side;
#else
    int width = 6 * side / 4;
#endif
    for (int y = 0; y < side; y++)
        for (int x = 0; x < width; x++) {
            vec4 v = uintBitsToFloat(texelFetch(glbk_sfield_cube, ivec2(x, at.y * side + y), 0));
#if SFIELD_SOURCE
            float a = channel == 0u ? v.x : channel == 1u ? v.y : v.z;
            if (a != 0.0) sum += a * sfield_basis_at(cell);
            cell++;
#else
            if (v != vec4(0.0)) {
                sum += v.x * sfield_basis_at(cell);
                sum += v.y * sfield_basis_at(cell + 1u);
                sum += v.z * sfield_basis_at(cell + 2u);
                sum += v.w * sfield_basis_at(cell + 3u);
            }
            cell += 4u;
#endif
        }
    coefs = floatBitsToUint(sum);
}
