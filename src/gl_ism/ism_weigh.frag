// Draws the importances of all texels of a source: their flux (paper 3.2).
// uses: ism_pvpl
// with: screen.vert
layout(location = 0) out uint result;

void main()
{
    result = floatBitsToUint(ism_read_pvpl(ivec2(gl_FragCoord.xy)).luminance);
}
