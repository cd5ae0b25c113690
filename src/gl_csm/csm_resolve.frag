// Draws the mean of the frames in the sum, as colours.
// uses: csm_bindings picture
// with: screen.vert
layout(location = 0) out vec4 result;

void main()
{
    ivec2 at = glbk_picture_at();
    vec4 sum = glbk_unpack(texelFetch(glbk_csm_sum, at, 0));
    vec3 p = vec3(0.0);
    bool seen = true;
    if (glbk_picture_asks()) {
        p = uintBitsToFloat(texelFetch(glbk_csm_place, at, 0).xyz);
        seen = (texelFetch(glbk_csm_normal, at, 0).w & 0xffu) != 0u;
    }
    glbk_picture_show(seen, p);
    result = vec4(glbk_csm_frame.frame_share > 0.0 ? sum.rgb * glbk_csm_frame.frame_share : vec3(0.0), 1.0);
}
