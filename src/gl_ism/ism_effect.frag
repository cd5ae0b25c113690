// Draws the effect of each texel of a source on the picture: what a unit of its flux would add, unshadowed, to a
// jittered grid of receivers, as the mean or the mean square (paper 4.1). Every other sample, as on a
// chessboard, may be guided: its density falls as min(1, (r0 / r)^2) about the texel's own place in the
// picture (4.2). Guided and other samples are weighted by the balance heuristic.
// uses: ism_pvpl ism_hash gbuffer
// with: screen.vert
layout(location = 0) out uint result;

// Returns how much light a unit of flux at q adds to a receiver at p: cos cos / d^2, bounded at distances below
// a hundredth of the picture's extent, whose square is extent2.
float ism_unit_flux_light(vec3 q, vec3 n, vec3 p, vec3 pn, float extent2)
{
    vec3 d = q - p;
    float d2 = dot(d, d) + 1e-4 * extent2 + 1e-30;
    float a = max(dot(pn, d), 0.0), b = max(-dot(n, d), 0.0);
    return a * b / (d2 * d2);
}

// Returns in which of `count` cells of 0..1 u lies.
int ism_cell(float u, float count) { return int(clamp(u * count, 0.0, count - 1.0)); }

float ism_effect(ism_pvpl q, uint i, uint seed)
{
    uint grid = ISM_C.grid_side, count = grid * grid, rank = 0u;
    vec2 side = vec2(float(ISM_C.view_width), float(ISM_C.view_height)), clip;
    float r0 = 0.05 * max(side.x, side.y), reach = side.x + side.y, sum = 0.0;
    uint turn = ism_hash_combine(seed, i * 256u + 255u);
    float even = 1.0 / (side.x * side.y), share = float(count / 2u) / float(count);
    bool known = ism_to_clip(q.position, clip);
    bool guided = ISM_C.guided != 0u && known && side.y > 1.0 && count > 1u && r0 >= 1.0 && reach > r0;
    vec2 centre = (0.5 * clip + 0.5) * side;
    float inner = 1.0 / (1.0 + 2.0 * cohsm_log(reach / r0));        // share of the disc r < r0
    float norm = inner / (3.14159265 * r0 * r0);                    // density inside it
    vec3 lo = ISM_FLOATS(glbk_ism_box, ivec3(0, 0, 0)).xyz;
    vec3 hi = ISM_FLOATS(glbk_ism_box, ivec3(0, 0, 1)).xyz;
    float extent2 = 0.0;
    if (lo.x <= hi.x) extent2 = dot(hi - lo, hi - lo);
    for (uint k = 0u; k < count; k++) {
        uint hash = ism_hash_combine(seed, i * 256u + k), column = k % grid, row = k / grid;
        float u = (float(column) + ism_to_unit(hash)) / float(grid);
        float v = (float(row) + ism_to_unit(ism_hash32(hash))) / float(grid), density = even;
        vec2 at = vec2(u, v) * side;
        if (guided && ((column + row) & 1u) != 0u) {
            if ((grid & 1u) != 0u) {
                u = (float(rank) + ism_to_unit(hash)) / float(count / 2u);
                v = ism_to_unit(turn + rank * 2654435769u);
                rank += 1u;
            }
            float within = r0 * sqrt(u / inner);
            float beyond = r0 * cohsm_exp((u - inner) / (1.0 - inner) * cohsm_log(reach / r0));
            at = centre + cohsm_if(u < inner, within, beyond) * cohsm_sincos(6.28318531 * v).yx;
        }
        vec2 off = at - centre;
        float r2 = dot(off, off);
        if (guided) density = (1.0 - share) * even + share * norm * min(1.0, r0 * r0 / max(r2, 1e-20));
        bool inside = at.x >= 0.0 && at.y >= 0.0 && at.x < side.x && at.y < side.y;
        glbk_point p;
        ivec2 pixel = ivec2(ism_cell(at.x / side.x, side.x), ism_cell(at.y / side.y, side.y));
        bool seen = glbk_read_point(pixel, p);
        if (inside && seen && cohsm_finite3(p.position) && dot(p.normal, p.normal) > 0.25) {
            float e = ism_unit_flux_light(q.position, q.normal, p.position, p.normal, extent2);
            if (ISM_C.by_mean == 0u) e *= e;
            sum += e * (even / density);
        }
    }
    return sum / float(count);
}

void main()
{
    ivec2 at = ISM_HERE;
    ism_pvpl q = ism_read_pvpl(at);
    int height = int(ISM_C.face_height), face = at.y / height;
    uint i = uint(at.y - face * height) * ISM_C.width + uint(at.x);
    float effect = 0.0;
    if (q.luminance > 0.0) effect = ism_effect(q, i, ism_hash_combine(ISM_C.seed, uint(face)));
    result = floatBitsToUint(effect);
}
