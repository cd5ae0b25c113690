// Writes 1 where anything hides, or the radiance of the nearest triangle, which emits on one side.
// uses: sfield_bindings mesh_fragment
// with: sfield_see.vert
// sets: SFIELD_SOURCE=0 GLBK_PLACE | SFIELD_SOURCE=1 GLBK_PLACE
#if SFIELD_SOURCE
flat in vec3 sfield_radiance;
in float sfield_depth;
#endif
layout(location = 0) out uvec4 seen;

void main()
{
    if (glbk_is_hole()) discard;
#if SFIELD_SOURCE
    seen = uvec4(floatBitsToUint(gl_FrontFacing ? sfield_radiance : vec3(0.0)), 0u);
    // A back lies a little behind a front in the same place, so that sheets may shine on both sides.
    gl_FragDepth = clamp(gl_FrontFacing ? sfield_depth : 1.0001 * sfield_depth, 0.0, 1.0);
#else
    seen = uvec4(1u);
#endif
}
