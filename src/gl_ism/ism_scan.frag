// Draws running sums of pairs of floats along rows or columns, each within its block of 32 values. Values are what is
// bound, or the last sum of each block of the level before, which is the block's total: three levels give
// the prefix sums of 32,768 values (paper 4.1). Each sum is added up from the block's beginning on, in the
// same order everywhere, so that sums never fall and all drivers agree.
// uses: ism_choice
// with: screen.vert
layout(location = 0) out uvec2 result;

void main()
{
    ivec2 at = ISM_HERE, along = ivec2(1, 0);
    if (ISM_C.columns != 0u) along = ivec2(0, 1);
    int i = at.x * along.x + at.y * along.y;
    int pace = int(ISM_C.pace), last = int(ISM_C.value_count) - 1;
    ivec2 base = at - along * i + ivec2(int(ISM_C.first_column), 0);
    vec2 sum = vec2(0.0);
    for (int k = i - (i & 31); k <= i; k++)
        sum += ISM_FLOATS(glbk_ism_summed, base + along * min(pace * k + pace - 1, last)).xy;
    result = floatBitsToUint(sum);
}
