// Begins interpolation: says that no node of the finest grid is evaluated, and lists the nodes of the first
// grid, where something is seen.
// uses: rsm_lists
layout(local_size_x = 8, local_size_y = 8) in;

void main()
{
    int fine = int(glbk_rsm_frame.fine_step);
    ivec2 number = ivec2(gl_GlobalInvocationID.xy), size = rsm_picture_side(), first;
    ivec2 last = rsm_node_number(size - 1, fine), at = min(number * fine, size - 1);
    rsm_receiver r;
    rsm_begin_lists();
    if (all(lessThanEqual(number, last))) {
        uint i = rsm_mark(number, last);
        if ((i & 31u) == 0u) glbk_rsm_marks[i >> 5] = 0u;
        imageStore(glbk_rsm_nodes, number, vec4(0.0));
        if (rsm_is_node(at, int(glbk_rsm_frame.step), size, first) && rsm_read(at, r)) rsm_add_wanted(at);
    }
    rsm_end_lists(0u, glbk_rsm_frame.list_wanted);
}
