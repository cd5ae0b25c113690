// Peels depths: of each pixel the nearest surface behind the layer before is left. Depths are the bits of
// floats; above 1 there is no surface.
// uses: csm_bindings mesh_fragment
// with: csm_peel.vert
// sets: CSM_FIRST=1 GLBK_PLACE | CSM_FIRST=0 GLBK_PLACE
#ifndef CSM_FIRST
#define CSM_FIRST 1
#endif
#if !defined(GL_ES) && __VERSION__ < 420      // since 4.20 and in ES only outputs are declared invariant
invariant
#endif
in float csm_depth;
layout(location = 0) out uint result;

void main()
{
    float depth = clamp(csm_depth, 0.0, 1.0);
    if (glbk_is_hole()) discard;
#if CSM_FIRST == 0
    if (depth <= uintBitsToFloat(texelFetch(glbk_csm_layer1, ivec2(gl_FragCoord.xy), 0).x)) discard;
#endif
    result = floatBitsToUint(depth);
    gl_FragDepth = depth;
}
