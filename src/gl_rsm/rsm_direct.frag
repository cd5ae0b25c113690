// Adds the direct light of the bound map to the picture.
// uses: rsm_direct rsm_screen
// with: screen.vert
layout(location = 0) out glbk_color result;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 sum = vec4(0.0);
    rsm_receiver r;
    if (glbk_rsm_frame.adds != 0u) sum = glbk_unpack(texelFetch(glbk_rsm_sum, at, 0));
    if (rsm_read(at, r)) {
        int taps = int(glbk_rsm_frame.taps);
        sum += vec4(rsm_direct(rsm_bound(), r.position, r.normal, taps, glbk_rsm_frame.bias,
                               glbk_rsm_frame.slope_bias), 1.0);
    }
    result = glbk_pack(sum);
}
