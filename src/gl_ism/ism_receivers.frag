// Draws the list of receivers: place i is that of the i-th pixel of the G-buffer that is one.
// uses: cohsm_math ism_fold gbuffer
// with: screen.vert
layout(location = 0) out uvec4 result;

void main()
{
    uint width = ISM_S.view_width, n0 = width * ISM_S.view_height;
    uint n1 = ism_blocks(n0), n2 = ism_blocks(n1), n3 = ism_blocks(n2), n4 = ism_blocks(n3);
    uint i = ism_unfold(n0).x;
    float x = float(i) + 0.5, all = ism_folded(glbk_ism_runs4, n4 - 1u, n4, 0u);
    result = uvec4(0u);
    if (!(x < all)) return;
    uint k = ism_find_in_block(glbk_ism_runs4, 0u, 0u, n4, x);
    k = ism_find_in_block(glbk_ism_runs3, 0u, k, n3, x);
    k = ism_find_in_block(glbk_ism_runs2, 0u, k, n2, x);
    k = ism_find_in_block(glbk_ism_runs1, 0u, k, n1, x);
    k = ism_find_in_block(glbk_ism_runs0, 0u, k, n0, x);
    glbk_point p;
    uint row = k / width;
    bool seen = glbk_read_point(ivec2(k - row * width, row), p);
    result = floatBitsToUint(vec4(p.position, cohsm_if(seen, 1.0, 0.0)));
}
