// Draws pixel lights of one map into the list: with ALL=1 every texel in turn, otherwise texels in proportion
// to their flux.
// uses: rsm_gather
// with: screen.vert
// sets: ALL=0 | ALL=1
#ifndef ALL
#define ALL 0
#endif
layout(location = 0) out uvec4 rsm_out_place;
layout(location = 1) out uvec4 rsm_out_normal;
layout(location = 2) out uvec4 rsm_out_flux;
layout(location = 3) out uvec4 rsm_out_gloss;

void main()
{
    uint e = uint(gl_FragCoord.y) * 1024u + uint(gl_FragCoord.x), room = glbk_rsm_frame.set_room;
    uint sets = glbk_rsm_frame.interleave * glbk_rsm_frame.interleave, set = e / room, at = e % room;
    uint seed = glbk_rsm_frame.seed, n = glbk_rsm_frame.light_count, from = glbk_rsm_frame.first_light;
    if (set >= sets || at < from || at >= glbk_rsm_frame.end_light) discard;
    // Runs of neighbours go to all sets, each run in another order.
    uint run = glbk_rsm_frame.first_run + at - from;
    uint i = run * sets + (set + sets - rsm_hash_combine(seed, run) % sets) % sets;
    rsm_light l = rsm_bound();
    ivec3 t = ivec3(0);
    float weight = 1.0;
    bool lit = i < n;
#if ALL
    uint size = uint(l.side);
    if (lit) t = ivec3(i % size, i / size % size, i / (size * size));
#else
    if (lit) lit = rsm_pick_texel(l, i, n, seed, t, weight);
#endif
    vec4 flux = uintBitsToFloat(RSM_TEXEL(t, 2)), place = uintBitsToFloat(RSM_TEXEL(t, 0));
    uvec4 normal = RSM_TEXEL(t, 1);
    // Black surfaces shine, too.
    bool glossy = normal.w != 0u && normal.w <= glbk_rsm_frame.material_count;
    lit = lit && (rsm_mean3(flux.xyz) > 0.0 || glossy);
    if (!lit) normal = uvec4(0u);           // it faces nobody, so it is no receiver's nearest light
    float scale = lit ? weight * glbk_rsm_frame.set_count : 0.0;
    place.xyz -= glbk_rsm_frame.offset * uintBitsToFloat(normal.xyz);
    place.w = rsm_bound_of(flux.w * weight, glbk_rsm_frame.clamp_at, glbk_rsm_frame.near_limit);
    rsm_out_place = floatBitsToUint(place);
#if ALL
    float field = glbk_rsm_frame.near_field, last = field * field * flux.w;
#else
    float last = lit && glbk_rsm_frame.picked > 0.0 ? 1.0 / weight : 0.0;
#endif
    rsm_out_normal = uvec4(normal.xyz, floatBitsToUint(last));
    rsm_out_flux = uvec4(floatBitsToUint(flux.xyz * scale), uint(t.x) | uint(t.y) << 12 | uint(t.z) << 24);
    rsm_out_gloss = uvec4(0u);
    if (lit && glossy)
        rsm_out_gloss = uvec4(floatBitsToUint(rsm_incident(l, t.z, t.xy) * l.value * scale), normal.w);
}
