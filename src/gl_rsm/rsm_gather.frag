// Adds bounced light up, draw by draw: in mode 0 to every pixel, in 1 to nodes of a grid, in 2 to pixels that
// are still pending.
// uses: rsm_bounce
// with: screen.vert
// sets: RSM_SURFACES=0 | RSM_SURFACES=1
layout(location = 0) out glbk_color result;

// Returns whether a pending pixel needs this node. Such a pixel lies between the lines of the grid before and
// after the node.
bool rsm_wanted(ivec2 at, int step, ivec2 size)
{
    ivec2 off = at % step;
    ivec2 from = ivec2(off.x == 0 ? max(at.x - step, 0) : at.x - off.x,
                       off.y == 0 ? max(at.y - step, 0) : at.y - off.y);
    ivec2 to = min(ivec2(off.x == 0 ? at.x + step - 1 : at.x, off.y == 0 ? at.y + step - 1 : at.y), size - 1);
    for (int y = from.y; y <= to.y; y++)
        for (int x = from.x; x <= to.x; x++)
            if (glbk_unpack(texelFetch(glbk_rsm_states, ivec2(x, y), 0)).w == RSM_PENDING) return true;
    return false;
}

void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy), at = here, size = rsm_picture_side(), number;
    int step = int(glbk_rsm_frame.step), coarse = int(glbk_rsm_frame.coarse_step);
    uint mode = glbk_rsm_frame.mode;
    bool first = glbk_rsm_frame.adds == 0u;
    vec4 sum = first && mode != 2u ? vec4(0.0) : glbk_unpack(texelFetch(glbk_rsm_sum, here, 0));
    rsm_receiver r;
    if (mode == 1u) at = min(at * step, size - 1);
    bool seen = rsm_read(at, r), evaluate = seen;
    if (!first) {
        evaluate = mode == 1u ? rsm_node_fresh(sum.w) : sum.w == RSM_FRESH;
    } else if (mode == 1u && coarse > 0) {
        if (rsm_is_node(at, coarse, size, number)) sum = glbk_unpack(texelFetch(glbk_rsm_coarse, number, 0));
        sum.w = rsm_node_aged(sum.w);
        evaluate = seen && sum.w == RSM_NONE && rsm_wanted(at, step, size);
    } else if (mode == 2u) {
        evaluate = sum.w == RSM_PENDING;
        sum.xyz *= evaluate ? 0.0 : r.open;
    }
    if (evaluate) {
        if (mode == 1u && !first) rsm_near = 1.0 / rsm_node_distance2(sum.w);
        sum.xyz += rsm_bounce(r, at) * (mode == 1u ? 1.0 : r.open);
        sum.w = mode == 1u ? rsm_node_alpha(1.0 / max(rsm_near, 1e-30)) : RSM_FRESH;
    }
    result = glbk_pack(sum);
}
