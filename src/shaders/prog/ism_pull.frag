// A cell of 2^ISM_LEVEL texels a side: 1 + the index in its tile of one texel of its four parts, the nearest to its middle.
// uses: ism_access
// with: screen.vert
// sets: ISM_LEVEL=1 | ISM_LEVEL=2 | ISM_LEVEL=3
#ifndef ISM_LEVEL
#define ISM_LEVEL 1
#endif
layout(location = 0) out uint result;

void main()
{
    ivec2 cell = ivec2(gl_FragCoord.xy), local;
    int size = int(glbk_ism_frame.maps.y), half_size = size >> ISM_LEVEL, least = 0x7fffffff;
    local = cell & (half_size - 1);
    ivec2 middle = (2 * local + 1) << ISM_LEVEL;
    result = 0u;
    for (int k = 0; k < 4; k++) {
        ivec2 part = ivec2(k & 1, k >> 1);
        int at = int(texelFetch(glbk_ism_below, 2 * cell + part, 0).x);
#if ISM_LEVEL == 1
        part += 2 * local;
        if (at != 0) at = part.y * size + part.x + 1;
#endif
        if (at == 0) continue;
        ivec2 d = 2 * ivec2((at - 1) % size, (at - 1) / size) + 1 - middle;
        if (d.x * d.x + d.y * d.y < least) {
            least = d.x * d.x + d.y * d.y;
            result = uint(at);
        }
    }
}
