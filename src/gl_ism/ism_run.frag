// Draws sums along sequences in pictures, in blocks of 32, of one or two channels. Running sums: number i is the sum
// of the values of its block up to i; the values of the first level are all numbers of a sequence, those of each
// level above are the last sums of the blocks below. With a pace of 0, sums of whole blocks alone.
// uses: ism_fold
// with: screen.vert
layout(location = 0) out uvec2 result;

void main()
{
    uint pace = ISM_S.pace, count = ISM_S.value_count, own = ism_blocks(count);
    if (pace != 0u) own = (count + pace - 1u) / pace;
    uvec2 place = ism_unfold(own);
    uint k = 32u * place.x, end = min(k + 32u, count);
    if (pace != 0u) {
        k = place.x - (place.x & 31u);
        end = min(place.x + 1u, own);
    }
    vec2 sum = vec2(0.0);
    for (; k < end; k++) {
        uint i = pace == 0u ? k : min(pace * k + pace - 1u, count - 1u);
        sum += ISM_FLOATS(glbk_ism_values, ism_fold(i, count, place.y)).xy;
    }
    result = floatBitsToUint(sum);
}
