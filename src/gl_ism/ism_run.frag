// Draws running sums along sequences in pictures, in blocks of 32: number i is the sum of the values of its
// block up to i. The values of the first level are all numbers of a sequence; those of each level above are the
// last sums of the blocks below.
// uses: ism_fold
// with: screen.vert
layout(location = 0) out uint result;

void main()
{
    uint pace = glbk_ism_scattering.pace, count = glbk_ism_scattering.value_count;
    uint own = (count + pace - 1u) / pace;
    uvec2 place = ism_unfold(ivec2(gl_FragCoord.xy), own);
    uint end = min(place.x, own - 1u);
    float sum = 0.0;
    for (uint k = place.x - (place.x & 31u); k <= end; k++)
        sum += ism_folded(glbk_ism_values, min(pace * k + pace - 1u, count - 1u), count, place.y);
    result = floatBitsToUint(sum);
}
