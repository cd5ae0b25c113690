// Draws VPLs from the importances (paper 4.1): VPL i where the running sum of all rows reaches (i + 0.5) / N of
// the whole, in its row by a golden ratio sequence. One whose importances are all 0 is black. Three pictures,
// 256 VPLs a row: place and area; normal, 0 0 0 of black ones, and how far the VPL may move before it has jumped;
// flux and face. Near points are drawn by the same program; their area is at least their texel's.
// uses: ism_search ism_hash ism_inter_texel
// with: screen.vert
layout(location = 0) out uvec4 place;
layout(location = 1) out uvec4 facing;
layout(location = 2) out uvec4 power;

void main()
{
    ivec2 at = ISM_HERE, texel, end = textureSize(glbk_ism_row_sums2, 0) - 1;
    uint i = uint(at.y) * 256u + uint(at.x), n = ISM_C.vpl_count;
    int width = int(ISM_C.width), height = end.y + 1;
    uvec4 totals = texelFetch(glbk_ism_column_sums2, textureSize(glbk_ism_column_sums2, 0) - 1, 0);
    float least = ism_least(totals), total = ism_weight(totals, least);
    place = facing = power = uvec4(0u);
    if (i >= n || !(total > 0.0)) return;
    float y = fract((float(i) + 0.5) / float(n) + ISM_C.shift) * total;
    texel.y = ism_search(glbk_ism_column_sums0, glbk_ism_column_sums1, glbk_ism_column_sums2, least,
                         ivec2(0), ivec2(0, 1), height, y);
    float row = ism_weight(texelFetch(glbk_ism_row_sums2, ivec2(end.x, texel.y), 0), least);
    float x = ism_to_unit(i * 2654435769u + ISM_C.shift_bits) * row;
    texel.x = ism_search(glbk_ism_row_sums0, glbk_ism_row_sums1, glbk_ism_row_sums2, least,
                         ivec2(0, texel.y), ivec2(1, 0), width, x);
    float weight = ism_weight(texelFetch(glbk_ism_importances, texel, 0), least);
    vec2 fraction = min(vec2(x / weight, y / row), vec2(0.99999994));
    float scale = total / (float(n) * weight), spacing = 0.0;       // 1 over N and the probability
    ism_pvpl p = ism_read_pvpl(texel);
    if (ISM_C.inter_texel != 0u) spacing = ism_inter_texel(texel, fraction, p.position, p.normal);
    p.normal = normalize(p.normal);
    float area = p.area * scale;
    if (ISM_C.first_near_point != 0u) area = max(area, p.area);
    if (!cohsm_finite(area) || area < 0.0) area = 0.0;
    place = floatBitsToUint(vec4(p.position, area));
    facing = floatBitsToUint(vec4(p.normal, spacing));
    power = floatBitsToUint(vec4(min(p.flux * scale, vec3(1e30)), texel.y / int(ISM_C.face_height)));
}
