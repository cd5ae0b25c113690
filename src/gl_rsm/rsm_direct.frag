// Adds the light of the bound map to the picture.
// uses: rsm_direct rsm_screen
// with: screen.vert
layout(location = 0) out glbk_color result;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 sum = glbk_rsm_frame.range.w != 0u ? glbk_unpack(texelFetch(glbk_rsm_sum, at, 0)) : vec4(0.0);
    rsm_receiver r;
    if (rsm_read(at, r))
        sum += vec4(rsm_direct(rsm_bound(), r.position, r.normal, int(glbk_rsm_frame.counts.x), glbk_rsm_frame.limits.x,
                               glbk_rsm_frame.limits.y), 1.0);
    result = glbk_pack(sum);
}
