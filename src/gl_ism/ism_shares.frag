// Draws each cluster's share of the points of a VPL, a sequence a VPL: the geometric mean of what the picture and
// the VPL see of the cluster, and a little of either alone, so that no cluster is forgotten. Where VPLs do not
// count, or there are no receivers, the picture or the area alone decides. A sequence of shares need not have the sum 1.
// uses: ism_densities
// with: screen.vert
layout(location = 0) out uint result;

void main()
{
    uint count = ISM_S.cluster_count;
    uvec2 place = ism_unfold(count);
    float share = 0.0;
    if (place.x < count) {
        float p = ism_density(ism_folded2(glbk_ism_masses, place.x, count)), q = p;
        ivec2 end = textureSize(glbk_ism_runs4, 0) - 1;
        if (ISM_S.pair != 0u && ISM_FLOATS(glbk_ism_runs4, end).x > 0.0) {
            float all = ISM_FLOATS(glbk_ism_effect_totals, ivec2(0, int(place.y))).x;
            float effect = ism_folded(glbk_ism_values, place.x, count, place.y);
            if (all > 0.0) q = effect / all;
        }
        if (p > 0.0) share = sqrt(p * q) + 0.05 * (p + q);
    }
    result = floatBitsToUint(share);
}
