// Does the work of ism_shade.frag as a compute shader. A group has 16 x 16 pixels of one class, which lie
// `interleave` apart, and reads each VPL of the class once, into shared memory, 64 at a time.
// uses: ism_gbuffer ism_light
// sets: ISM_PROJECTION=1 ISM_NEAR=1 | ISM_PROJECTION=2 ISM_NEAR=2 | ISM_PROJECTION=3 ISM_NEAR=3
// sets: ISM_PROJECTION=4 ISM_NEAR=4 | ISM_NEAR=5 | ISM_NEAR=6
layout(local_size_x = 16, local_size_y = 16) in;
#define ISM_ROUND 64u

shared ism_vpl ism_read[ISM_ROUND];

// Loads VPLs of the class from number `from` on, and returns how many.
uint ism_round(uint first, uint set_count, uint used, uint from)
{
    uint k = gl_LocalInvocationIndex, count = min(used - from, ISM_ROUND);
    barrier();
    if (k < count) ism_read[k] = ism_read_vpl(first + (from + k) * set_count);
    barrier();
    return count;
}

void main()
{
    uint side = glbk_ism_view.interleave, set_count = side * side, first = gl_WorkGroupID.z;
    uint used = ism_used(first, set_count);
    ivec2 at = ivec2(gl_GlobalInvocationID.xy * side + uvec2(first % side, first / side));
    at.y += int(glbk_ism_view.first_row);
    bool inside = all(lessThan(at, ism_picture_side()));
    float most = glbk_ism_view.clamp_at;
    vec4 sum = vec4(0.0);
    ism_receiver r;
    bool lit = inside && ism_read_receiver(at, r);
#if ISM_NEAR == 4
    float all_of_them = 0.0;
    for (uint from = 0u; from < used; from += ISM_ROUND) {
        uint count = ism_round(first, set_count, used, from);
        for (uint k = 0u; k < count && lit; k++) all_of_them += ism_unshadowed(ism_read[k], r.p, r.n);
    }
    most *= used > 0u ? all_of_them / float(used) : 0.0;
#endif
    for (uint from = 0u; from < used; from += ISM_ROUND) {
        uint count = ism_round(first, set_count, used, from);
        for (uint k = 0u; k < count && lit; k++)
            ism_add(sum, first + (from + k) * set_count, ism_read[k], r.p, r.n, r.ng, most);
    }
    sum = ism_scaled(sum, set_count);
#if ISM_NEAR == 6
    if (lit) sum += ism_gather(r.p, r.n, r.ng);
#endif
    if (inside) imageStore(glbk_ism_light_out, at, sum);
}
