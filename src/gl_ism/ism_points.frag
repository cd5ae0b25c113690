// Draws surfels of some VPLs into a layer of the table of surfels (paper 5): stratified random numbers choose for
// each a cluster by the running sums of shares, a triangle of it, and a place on the triangle.
// uses: ism_densities ism_hash
// with: screen.vert
layout(location = 0) out uvec4 result;

// Returns a place on a triangle by a place in the square; an even density stays even (Heitz 2019: "A
// low-distortion map between triangle and square").
vec2 ism_triangle_map(float u, float v)
{
    vec2 b = vec2(u - 0.5 * v, 0.5 * v);
    if (v > u) b = vec2(0.5 * u, v - 0.5 * u);
    return floor(b * 65535.0) * (1.0 / 65535.0);        // as ism.h keeps it, in 16 bits each
}

float ism_triangle_density(uint t)
{
    return ism_density(ism_folded2(glbk_ism_sizes, t, ISM_S.triangle_count));
}

// Returns a triangle of cluster c by x, which lies within the cluster's share, and makes x the probability with
// which it is chosen in the cluster.
uint ism_choose_triangle(uint c, float share, inout float x)
{
    uint first = c * ISM_S.cluster_size, chosen = first;
    uint end = min(first + ISM_S.cluster_size, ISM_S.triangle_count);
    float all = ism_density(ism_folded2(glbk_ism_masses, c, ISM_S.cluster_count)), sum = 0.0, width = 0.0;
    x = x / share * all;
    for (uint t = first; t < end && !(sum > x); t++) {
        float density = ism_triangle_density(t);
        sum += density;
        if (density > 0.0) {
            chosen = t;
            width = density;
        }
    }
    x = width / all;
    return chosen;
}

// Makes surfel number `at` of n of VPL v. row: of its shares. Of surfels whose triangles are gone, which were
// neighbours in the strata, each is drawn from all triangles.
uvec4 ism_point(uint v, uint row, uint at, uint n)
{
    uint count = ISM_S.cluster_count, n1 = ism_blocks(count), n2 = ism_blocks(n1);
    uint key = ism_hash_combine(ISM_S.key, 0x9000u + v);
    float all = ism_folded(glbk_ism_runs2, n2 - 1u, n2, row);
    float x = (float(at) + ism_to_unit(ism_hash_combine(key, at))) / float(n);
    if (ISM_S.keep != 0u)
        x = ism_to_unit(ism_hash_combine(ism_hash_combine(key, ISM_S.frame), at));
    x *= all;
    if (!(all > 0.0)) return uvec4(0u);
    uint c = ism_find_in_block(glbk_ism_runs2, row, 0u, n2, x);
    c = ism_find_in_block(glbk_ism_runs1, row, c, n1, x);
    c = ism_find_in_block(glbk_ism_runs0, row, c, count, x);
    float share = ism_folded(glbk_ism_shares, c, count, row);
    uint t = ism_choose_triangle(c, share, x);
    float probability = share / all * x;
    uint r = key + at * 3242174889u, s = ism_hash32(key) + at * 2447445413u;
    vec2 b = ism_triangle_map(ism_to_unit(r), ism_to_unit(s));
    float area = 0.0;
    if (probability > 0.0) area = 1.0 / (float(n) * probability);
    return uvec4(t, floatBitsToUint(vec3(b, area)));
}

void main()
{
    uint i = ISM_S.first_texel + (uint(gl_FragCoord.y) << 10) + uint(gl_FragCoord.x);
    uint each = ISM_S.phase_surfel_count, v = i / each, row = v - ISM_S.first_vpl;
    uint at = (i - v * each) * ISM_S.lazy_frames + ISM_S.phase;
    if (v < ISM_S.first_vpl || row >= ISM_S.batch) discard;
    if (ISM_S.keep != 0u && texelFetch(glbk_ism_gone, ISM_HERE, 0).x == 0u) discard;
    uint n = texelFetch(glbk_ism_counts, ism_fold(v, ISM_S.vpl_capacity, 0u), 0).x;
    result = uvec4(0u);
    if (at < n) result = ism_point(v, row * ISM_S.pair, at, n);
}
