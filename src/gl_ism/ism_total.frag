// Draws the sums of blocks of 32 values of sequences in pictures, of two channels.
// uses: ism_fold
// with: screen.vert
layout(location = 0) out uvec2 result;

void main()
{
    uint count = glbk_ism_scattering.value_count;
    uvec2 place = ism_unfold(ivec2(gl_FragCoord.xy), ism_blocks(count));
    uint end = min(32u * place.x + 32u, count);
    vec2 sum = vec2(0.0);
    for (uint k = 32u * place.x; k < end; k++)
        sum += uintBitsToFloat(texelFetch(glbk_ism_values, ism_fold(k, count, place.y), 0).xy);
    result = floatBitsToUint(sum);
}
