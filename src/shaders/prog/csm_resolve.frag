// The mean of the frames summed up so far, as colours.
// uses: csm_bindings
// with: screen.vert
layout(location = 0) out vec4 result;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy) - ivec2(glbk_csm_frame.range.xy);
    vec4 sum = glbk_unpack(texelFetch(glbk_csm_sum, at, 0));
    result = vec4(glbk_csm_frame.query.z > 0.0 ? sum.rgb * glbk_csm_frame.query.z : vec3(0.0), 1.0);
}
