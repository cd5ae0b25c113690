// Draws one pass of the a-trous filter.
// uses: rsm_smooth
// with: screen.vert
layout(location = 0) out glbk_color result;

bool rsm_neighbour(ivec2 at, ivec2 off, out rsm_receiver s, out vec3 light)
{
    ivec2 there = at + off * int(glbk_rsm_frame.step), size = rsm_picture_side();
    bool inside = all(greaterThanEqual(there, ivec2(0))) && all(lessThan(there, size));
    light = vec3(0.0);
    if (!inside || !rsm_read(there, s)) return false;
    light = glbk_unpack(texelFetch(glbk_rsm_sum, there, 0)).xyz;
    return true;
}

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    rsm_receiver r;
    vec4 sum = vec4(0.0);
    if (rsm_read(at, r)) sum = rsm_smooth(at, r, glbk_unpack(texelFetch(glbk_rsm_sum, at, 0)));
    result = glbk_pack(sum);
}
