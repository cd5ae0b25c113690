// ism_fold - sequences of numbers that lie in pictures, the running sums of such sequences, and the cell of a
// sequence into which a number falls.
// uses: ism_floats
#define ISM_S glbk_ism_scattering       // short, since 40 places name it

// Returns where number i of sequence `row` lies, if sequences have `count` numbers each: 1024 in a row of
// texels, and sequence below sequence.
ivec2 ism_fold(uint i, uint count, uint row)
{
    return ivec2(i & 1023u, row * ((count + 1023u) >> 10) + (i >> 10));
}

// Returns which number of which sequence, as x and y, the texel that is drawn holds: the inverse of ism_fold.
uvec2 ism_unfold(uint count)
{
    uint height = (count + 1023u) >> 10, row = uint(gl_FragCoord.y / float(height));
    return uvec2((uint(gl_FragCoord.y) - row * height) * 1024u + uint(gl_FragCoord.x), row);
}

float ism_folded(usampler2D from, uint i, uint count, uint row)
{
    return ISM_FLOATS(from, ism_fold(i, count, row)).x;
}

vec2 ism_folded2(usampler2D from, uint i, uint count)
{
    return ISM_FLOATS(from, ism_fold(i, count, 0u)).xy;
}

// Returns how many blocks of 32 a number of values has.
uint ism_blocks(uint count) { return (count + 31u) >> 5; }

// Returns the least i of a block of 32 whose running sum is above x, and takes from x what lies before it. x
// is kept below the block's sum, which rounding of the level above may have passed by, so that a cell without
// width is never found.
uint ism_find_in_block(usampler2D sums, uint row, uint block, uint count, inout float x)
{
    uint lo = 32u * block, hi = min(lo + 32u, count) - 1u;
    float before = 0.0;
    x = min(x, 0.99999994 * ism_folded(sums, hi, count, row));
    for (int k = 0; k < 5; k++) {
        uint middle = (lo + hi) >> 1;
        float sum = ism_folded(sums, middle, count, row);
        bool past = lo < hi && !(sum > x);
        if (past) {
            lo = middle + 1u;
            before = sum;
        }
        if (!past) hi = max(middle, lo);
    }
    x -= before;
    return lo;
}
