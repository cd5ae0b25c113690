// Does the work of rsm_interpolate.frag as a compute shader, over every pixel (RSM_GROUP=256), then over
// those of a list. Pixels that the grid suffices for go to the picture, pixels that stay pending into the
// next list, and the nodes of the next grid that pending pixels need into a list of nodes.
// uses: rsm_lists rsm_grid
// sets: RSM_GROUP=256 | RSM_GROUP=64
layout(local_size_x = RSM_GROUP) in;

#if RSM_GROUP == 256
// 16 x 16 pixels have their nodes, at most 9 x 9, in shared memory.
const int SIDE = 9;
shared vec4 rsm_places[SIDE * SIDE];        // place, and 1 if something is seen
shared vec4 rsm_lights[SIDE * SIDE];        // light, and alpha
shared vec3 rsm_normals[SIDE * SIDE];

// Loads the nodes of the group's pixels.
void rsm_load_nodes(int step, int fine, ivec2 size)
{
    int i = int(gl_LocalInvocationIndex);
    ivec2 node = ivec2(i % SIDE, i / SIDE);
    if (all(lessThanEqual(node, ivec2(15 / step + 1)))) {
        ivec2 at = min((ivec2(gl_WorkGroupID.xy * 16u) / step + node) * step, size - 1);
        rsm_receiver r;
        rsm_places[i].w = rsm_read(at, r) ? 1.0 : 0.0;
        rsm_places[i].xyz = r.position;
        rsm_normals[i] = r.normal;
        rsm_lights[i] = texelFetch(glbk_rsm_coarse, rsm_node_number(at, fine), 0);
    }
    barrier();
}

bool rsm_node(ivec2 at, out rsm_receiver s, out vec4 node)
{
    int step = int(glbk_rsm_frame.step);
    ivec2 number = rsm_node_number(at, step) - ivec2(gl_WorkGroupID.xy * 16u) / step;
    int i = number.y * SIDE + number.x;
    node = rsm_lights[i];
    s = rsm_receiver(rsm_places[i].xyz, rsm_normals[i], 1.0);
    return rsm_places[i].w > 0.0;
}
#else
bool rsm_node(ivec2 at, out rsm_receiver s, out vec4 node)
{
    node = texelFetch(glbk_rsm_coarse, rsm_node_number(at, int(glbk_rsm_frame.fine_step)), 0);
    return rsm_read(at, s);
}
#endif

void main()
{
    int step = int(glbk_rsm_frame.step), next = int(glbk_rsm_frame.next_step);
    ivec2 at, size = rsm_picture_side(), number;
    ivec2 lx, ly;
    rsm_receiver r;
    vec3 value;
    float share;
    rsm_begin_lists();
#if RSM_GROUP == 256
    at = ivec2(gl_WorkGroupID.xy * 16u) + ivec2(gl_LocalInvocationIndex & 15u, gl_LocalInvocationIndex >> 4);
    bool inside = all(lessThan(at, size));
    rsm_load_nodes(step, int(glbk_rsm_frame.fine_step), size);
#else
    bool inside = rsm_item(glbk_rsm_frame.list_read, at);
#endif
    if (inside && !rsm_read(at, r)) {
        imageStore(glbk_rsm_picture, at, vec4(0.0, 0.0, 0.0, RSM_NONE));
    } else if (inside && !rsm_is_node(at, step, size, number)) {        // nodes in question were evaluated
        if (rsm_interpolate(at, step, size, r, value)) {
            imageStore(glbk_rsm_picture, at, vec4(value * r.open, RSM_INTERPOLATED));
        } else {
            rsm_add_pending(at);
            if (next > 0) {
                rsm_grid_lines(at.x, next, size.x, lx, share);
                rsm_grid_lines(at.y, next, size.y, ly, share);
                for (int k = 0; k < 4; k++)
                    rsm_want(ivec2((k & 1) != 0 ? lx.y : lx.x, (k & 2) != 0 ? ly.y : ly.x));
            }
        }
    }
    rsm_end_lists(glbk_rsm_frame.list_pending, glbk_rsm_frame.list_wanted);
}
