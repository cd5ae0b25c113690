// Adds up the light of all texels of a point's cube: a pixel of the picture is a point of the batch.
// uses: sfield_haar
// with: screen.vert
layout(location = 0) out glbk_color light;

void main()
{
    uint side = glbk_haar_batch.side, columns = 2u * glbk_haar_batch.columns;
    uvec2 at = uvec2(gl_FragCoord.xy) - uvec2(glbk_haar_batch.left, glbk_haar_batch.bottom);
    uint point = at.y * glbk_haar_batch.width + at.x;
    ivec2 size = ivec2(6u * (side / 4u), side / 2u), first = ivec2(point % columns, point / columns) * size;
    vec4 sum = vec4(0.0);
    for (int y = 0; y < size.y; y++)
        for (int x = 0; x < size.x; x++)
            sum += uintBitsToFloat(texelFetch(glbk_haar_sums, first + ivec2(x, y), 0));
    light = glbk_pack(sum * (1.0 / 3.14159265));
}
