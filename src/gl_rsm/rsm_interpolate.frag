// Draws the pixels that the grid suffices for; the others stay pending. In the first pass all are pending.
// uses: rsm_grid
// with: screen.vert
layout(location = 0) out glbk_color result;

bool rsm_node(ivec2 at, out rsm_receiver s, out vec4 node)
{
    node = glbk_unpack(texelFetch(glbk_rsm_coarse, rsm_node_number(at, int(glbk_rsm_frame.step)), 0));
    return rsm_read(at, s);
}

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy), size = rsm_picture_side(), number;
    int step = int(glbk_rsm_frame.step);
    vec4 sum = vec4(0.0, 0.0, 0.0, RSM_PENDING);
    rsm_receiver r;
    bool seen = rsm_read(at, r);
    if (glbk_rsm_frame.adds != 0u) sum = glbk_unpack(texelFetch(glbk_rsm_sum, at, 0));
    else if (!seen) sum.w = RSM_NONE;
    if (seen && rsm_is_node(at, step, size, number)) {      // evaluated light replaces interpolated light
        vec4 node = glbk_unpack(texelFetch(glbk_rsm_coarse, number, 0));
        if (node.w < 0.0) sum = vec4(node.xyz, RSM_EVALUATED);
    }
    vec3 value;
    if (sum.w == RSM_PENDING && rsm_interpolate(at, step, size, r, value))
        sum = vec4(value, RSM_INTERPOLATED);
    result = glbk_pack(sum);
}
