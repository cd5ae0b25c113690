// rsm_bounce - bounced light of receivers of the G-buffer.
// uses: rsm_screen rsm_gather
// Cosine and sine of the rotation of a pixel's pattern.
vec2 rsm_turn(ivec2 at)
{
    uint noise = glbk_rsm_frame.counts.w;
    if (noise == 0u) return vec2(1.0, 0.0);
    float angle = 2.0 * RSM_PI * texelFetch(glbk_rsm_noise, ivec2(uvec2(at) % noise), 0).x;
    return vec2(cos(angle), sin(angle));
}

// Lights from .. to - 1 of the bound list; points first, first + step, ... of the bound pattern about the receiver.
vec3 rsm_listed(rsm_light l, rsm_receiver r, uint from, uint to)
{
    return rsm_gather_list(l, r.position, r.normal, from, to, glbk_rsm_frame.pick.w != 0u, glbk_rsm_frame.pattern.y);
}

vec3 rsm_about(rsm_light l, rsm_receiver r, vec2 turn, uint first, uint step, uint count)
{
    return rsm_gather_about(l, r.position, r.normal, glbk_rsm_frame.pattern.x, turn, first, step, count,
                            glbk_rsm_frame.limits, glbk_rsm_frame.pick.w != 0u, glbk_rsm_frame.pattern.y,
                            glbk_rsm_frame.pattern.z, glbk_rsm_frame.surfaces.x);
}

// Bounced light of pixel `at` from the bound list, map and pattern.
vec3 rsm_bounce(rsm_receiver r, ivec2 at)
{
    uint k = glbk_rsm_frame.counts.y, set = rsm_set(at), base = set * glbk_rsm_frame.range.z;
    rsm_light l = rsm_bound();
    vec3 sum = vec3(0.0);
    if (glbk_rsm_frame.range.y > glbk_rsm_frame.range.x)
        sum = rsm_listed(l, r, base + glbk_rsm_frame.range.x, base + glbk_rsm_frame.range.y);
    if (glbk_rsm_frame.counts.z > 0u) sum += rsm_about(l, r, rsm_turn(at), set, k * k, glbk_rsm_frame.counts.z);
    return sum / RSM_PI;
}
