// Adds up the light of all texels of a point's cube: a pixel of the picture is a point of the batch.
// uses: sfield_haar gbuffer
// with: screen.vert
// sets: SFIELD_GLOSS=0 | SFIELD_GLOSS=1
#ifndef SFIELD_GLOSS
#define SFIELD_GLOSS 0
#endif
layout(location = 0) out glbk_color light;
#if SFIELD_GLOSS
layout(location = 1) out glbk_color gloss;
#endif

void main()
{
    uint side = glbk_haar_batch.side, columns = 2u * glbk_haar_batch.columns;
    uvec2 at = uvec2(gl_FragCoord.xy) - uvec2(glbk_haar_batch.left, glbk_haar_batch.bottom);
    uint point = at.y * glbk_haar_batch.width + at.x;
    ivec2 size = ivec2(6u * (side / 4u), side / 2u), first = ivec2(point % columns, point / columns) * size;
    vec4 sum = vec4(0.0), scale = vec4(1.0 / 3.14159265);
#if SFIELD_GLOSS
    vec4 glossy = vec4(0.0);
    glbk_point p;
    if (glbk_read_point(ivec2(gl_FragCoord.xy), p) && p.kind == GLBK_METAL_ROUGH)
        scale.xyz = 0.96 - clamp(p.metallic, 0.0, 1.0) * (clamp(p.diffuse, 0.0, 1.0) - 0.04);
#endif
    for (int y = 0; y < size.y; y++)
        for (int x = 0; x < size.x; x++) {
            sum += uintBitsToFloat(texelFetch(glbk_haar_sums, first + ivec2(x, y), 0));
#if SFIELD_GLOSS
            glossy += uintBitsToFloat(texelFetch(glbk_haar_shine, first + ivec2(x, y), 0));
#endif
        }
    light = glbk_pack(sum * scale);
#if SFIELD_GLOSS
    gloss = glbk_pack(glossy);
#endif
}
