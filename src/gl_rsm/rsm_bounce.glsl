// rsm_bounce - computes bounced light of receivers of the G-buffer.
// uses: rsm_screen rsm_gather rsm_sampling

// Returns cosine and sine of the rotation of a pixel's pattern.
vec2 rsm_turn(ivec2 at)
{
    uint noise = glbk_rsm_frame.noise_side;
    if (noise == 0u) return vec2(1.0, 0.0);
    float angle = 2.0 * RSM_PI * texelFetch(glbk_rsm_noise, ivec2(uvec2(at) % noise), 0).x;
    return vec2(cos(angle), sin(angle));
}

// Returns the light of lights from .. to - 1 of the bound list.
vec3 rsm_listed(rsm_light l, rsm_receiver r, uint from, uint to)
{
    return rsm_gather_list(l, r.position, r.normal, from, to, glbk_rsm_frame.material_count != 0u,
                           glbk_rsm_frame.mixed);
}

// Returns the light of points first, first + step, ... of the bound pattern about the receiver.
vec3 rsm_about(rsm_light l, rsm_receiver r, vec2 turn, uint first, uint step, uint count)
{
    return rsm_gather_about(l, r.position, r.normal, rsm_bound_sampling(), turn, first, step, count);
}

// Returns the bounced light of pixel `at`, from the bound list, map and pattern.
vec3 rsm_bounce(rsm_receiver r, ivec2 at)
{
    uint k = glbk_rsm_frame.interleave, set = rsm_set(at), base = set * glbk_rsm_frame.set_room;
    uint from = glbk_rsm_frame.first_light, to = glbk_rsm_frame.end_light, count = glbk_rsm_frame.point_count;
    rsm_light l = rsm_bound();
    vec3 sum = vec3(0.0);
    if (to > from) sum = rsm_listed(l, r, base + from, base + to);
    if (count > 0u) sum += rsm_about(l, r, rsm_turn(at), set, k * k, count);
    return sum / RSM_PI;
}
