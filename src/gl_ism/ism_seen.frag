// Draws 1 for each pixel of the G-buffer that is a receiver, and 0 for the others, as one sequence of all pixels.
// uses: cohsm_math ism_fold gbuffer
// with: screen.vert
layout(location = 0) out uint result;

void main()
{
    uint width = ISM_S.view_width, count = width * ISM_S.view_height;
    uint i = ism_unfold(count).x, j = min(i, count - 1u), row = j / width;
    glbk_point p;
    bool seen = glbk_read_point(ivec2(j - row * width, row), p);
    seen = seen && i < count && cohsm_finite3(p.position) && dot(p.normal, p.normal) > 0.25;
    result = seen ? 0x3f800000u : 0u;           // as floats
}
