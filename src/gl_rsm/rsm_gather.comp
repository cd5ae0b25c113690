// Does the work of rsm_gather.frag as a compute shader: sums stay in registers, and lights and points, which
// all of a group take, come through shared memory. In mode 0 a group has 8 x 8 pixels of one set, in 1 nodes
// of a list (NODES=1; otherwise nothing asks how near lights are, which spares a tenth of the work), in 2
// pixels of a list.
// uses: rsm_chunk rsm_bounce rsm_lists
// sets: NODES=0 | NODES=1 | NODES=0 RSM_SURFACES=1 | NODES=1 RSM_SURFACES=1
#ifndef NODES
#define NODES 0
#endif
layout(local_size_x = 64) in;
shared bool rsm_awake;

// Returns rsm_bounce for each pixel of a group. Pixels that are not awake only help to fetch.
vec3 rsm_bounce_together(rsm_receiver r, ivec2 at, uint set, bool awake)
{
    uint i = gl_LocalInvocationIndex, sets = glbk_rsm_frame.interleave * glbk_rsm_frame.interleave;
    uint listed = glbk_rsm_frame.end_light;
    int kinds = glbk_rsm_frame.material_count != 0u ? 4 : 3;
    rsm_light l = rsm_bound();
    vec2 turn = rsm_turn(at);
    vec3 sum = vec3(0.0);
    for (uint from = glbk_rsm_frame.first_light; from < listed; from += RSM_CHUNK) {
        barrier();
        if (from + i < listed)
            for (int k = 0; k < kinds; k++)
                RSM_LIGHT(i, k) = RSM_LISTED(set * glbk_rsm_frame.set_room + from + i, k);
        barrier();
        if (awake) sum += rsm_listed(l, r, 0u, min(RSM_CHUNK, listed - from));
    }
    for (uint from = 0u; from < glbk_rsm_frame.point_count; from += 4u * RSM_CHUNK) {
        uint count = min(4u * RSM_CHUNK, glbk_rsm_frame.point_count - from);
        barrier();
        for (uint k = i; k < count; k += RSM_CHUNK)
            rsm_chunk[k].xyz = floatBitsToUint(RSM_PATTERN(set + (from + k) * sets));
        barrier();
        if (awake) sum += rsm_about(l, r, turn, 0u, 1u, count);
    }
    return sum / RSM_PI;
}

void main()
{
    uint k = glbk_rsm_frame.interleave, i = gl_LocalInvocationIndex, set = gl_WorkGroupID.z;
    ivec2 at, size = rsm_picture_side();
    bool inside, first = glbk_rsm_frame.adds == 0u;
    vec4 sum = vec4(0.0);
    rsm_receiver r;
    if (glbk_rsm_frame.mode == 0u) {
        at = ivec2((gl_WorkGroupID.xy * 8u + uvec2(i & 7u, i >> 3)) * k + uvec2(set % k, set / k));
        inside = all(lessThan(at, size));
    } else {
        inside = rsm_item(glbk_rsm_frame.list_read, at);
    }
    bool awake = rsm_read(inside ? at : ivec2(0), r) && inside;
#if NODES
    ivec2 number = rsm_node_number(at, int(glbk_rsm_frame.fine_step));
    if (awake && !first) {
        sum = imageLoad(glbk_rsm_nodes, number);
        rsm_near = 1.0 / rsm_node_distance2(sum.w);
    }
#else
    if (awake && !first) sum = imageLoad(glbk_rsm_picture, at);
#endif
    if (i == 0u) rsm_awake = false;
    barrier();
    if (awake) rsm_awake = true;
    barrier();
    if (rsm_awake) {
        vec3 light = rsm_bounce_together(r, at, set, awake);
#if NODES
        sum = vec4(sum.xyz + light, rsm_node_alpha(1.0 / max(rsm_near, 1e-30)));
#else
        sum = vec4(sum.xyz + light * r.open, RSM_FRESH);
#endif
    }
    if (!inside || (!awake && !first)) return;
    if (!awake) sum = vec4(0.0);
#if NODES
    imageStore(glbk_rsm_nodes, number, sum);
    sum = vec4(sum.xyz * r.open, RSM_EVALUATED);
#endif
    imageStore(glbk_rsm_picture, at, sum);
}
