// csm_shade - returns direct light at one point: samples of one light, with their visibility in one scene.
// One pass adds samples first .. end - 1 of one light; glbk_csm_render loops over lights and ranges.
//
// CSM_SHAPE, CSM_ASK and CSM_FILTER are the light's shape, what the maps are asked by and the filter, as
// constants: each program holds the code for one combination, which is a fraction of all.
// uses: csm_pattern csm_instances cohsm_visible cohsm_estimate gbuffer
#if !defined(CSM_SHAPE) || !defined(CSM_ASK) || !defined(CSM_FILTER)
#error "csm_shade: CSM_SHAPE, CSM_ASK, CSM_FILTER"
#endif

// Returns whether a sample lies behind a receiver without maps, an infinite plane, other than the one that
// the point is on.
bool csm_behind(glbk_point p, vec3 direction, float range)
{
    for (uint i = 0u; i < glbk_csm_frame.plane_count; i++) {
        vec4 plane = glbk_csm_frame.planes[i];
        float height = dot(plane.xyz, p.position) - plane.w, end = height + range * dot(plane.xyz, direction);
        if (i + 1u != p.plane && (height > 0.0 ? end < 0.0 : end > 0.0)) return true;
    }
    return false;
}

// Returns the sum of this pass: light in rgb, and in a the samples that were refused, since their light lies
// inside a hull.
vec4 csm_shade(glbk_point p, uint pixel)
{
    const uint table = 0u;
    const int ask = CSM_ASK;
    uint count = glbk_csm_scene.count, samples = glbk_csm_frame.sample_count;
    cohsm_light light = cohsm_light_open(glbk_csm_frame.light_texel);
    light.shape = uint(CSM_SHAPE);
    light.own = glbk_csm_frame.own;
    cohsm_material material = cohsm_material(p.kind, p.diffuse, p.specular, p.exponent, p.metallic,
                                             p.roughness, p.lobe, p.lobe_count);
    vec3 view = cohsm_normalize(glbk_csm_frame.eye.xyz - p.position);
    cohsm_surface surface = cohsm_surface_at(material, p.normal, p.tangent, view);
    cohsm_estimator e = cohsm_estimator_at(surface, light, p.position, int(glbk_csm_frame.sampling), samples,
                                           glbk_csm_frame.seed, glbk_csm_frame.frame);
    vec4 sum = vec4(0.0);
    if (!e.reachable) return sum;

    bool local = ask == COHSM_LIGHT_PARAMETER || (ask == COHSM_LIGHT_INDEX && light.shape > COHSM_SHAPE_SUN);
    float moved = 0.0;                  // how far the receiver moves off its surface
    if (local && count > 0u)
        moved = glbk_csm_frame.offset * 2.0 / float(cohsm_instance_maps(table, 0u).map_size);
    else if (p.entity - 1u < count)     // not of entity 0, which is none
        moved = cohsm_instance_note(table, p.entity - 1u);
    for (uint k = glbk_csm_frame.first; k < glbk_csm_frame.end; k++) {
        cohsm_emission found;
        vec3 weight = cohsm_estimate(e, cohsm_numbers(e, pixel, k), found);
        if (!(weight.x > 0.0 || weight.y > 0.0 || weight.z > 0.0)) continue;
        if (!(dot(found.direction, p.geometric) > 0.0)) continue;
        if (csm_behind(p, found.direction, found.range)) continue;
        vec3 from = p.position + p.geometric * (local ? moved * found.range : moved);
        vec3 to = ask == COHSM_LIGHT_DIRECTION ? found.direction
                : ask == COHSM_LIGHT_POSITION ? p.position + found.direction * found.range
                : ask == COHSM_LIGHT_PARAMETER ? found.coords : vec3(0.0);
        cohsm_query q = cohsm_query(ask, CSM_FILTER, glbk_csm_frame.bias, glbk_csm_frame.roulette_seed,
                                    pixel * samples + k);
        float visible = cohsm_visible_scene(table, count, p.entity, q, from, to);
        if (visible < 0.0) sum.a += 1.0;
        else sum.rgb += weight * visible;
    }
    return vec4(sum.rgb * (1.0 / float(samples)), sum.a);
}
