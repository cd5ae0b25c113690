// ism_search - finds the cell in which a number falls by the running sums of ism_scan.frag: inverts a CDF.
// uses: ism_choice
// Sums have two channels, flux times effect and flux. An importance, and a sum of some, is the first and
// `least` times the second, so that no texel is forgotten; least is known when all is summed up.
float ism_weight(uvec4 sums, float least)
{
    vec2 s = uintBitsToFloat(sums.xy);
    return s.x + least * s.y;
}

// Returns that factor, by the totals of both channels: choice by flux alone has the share that the block
// tells of. Without effects it is all.
float ism_least(uvec4 totals)
{
    vec2 s = uintBitsToFloat(totals.xy);
    float least = 1.0;
    if (s.x > 0.0 && s.y > 0.0) least = s.x / s.y * ISM_C.flux_factor;
    return least;
}

// Returns the least i of the block that begins at `first` whose running sum is above x, and takes from x what
// lies before it. Sums stand at base + i * along; there are `count` of them in all. x is kept below the
// block's total, which rounding of the level above may have passed by, so a cell without weight is never
// found.
int ism_search_block(usampler2D sums, float least, ivec2 base, ivec2 along, int first, int count,
                     inout float x)
{
    int lo = first, hi = min(first + 32, count) - 1;
    float before = 0.0;
    x = min(x, 0.99999994 * ism_weight(texelFetch(sums, base + along * hi, 0), least));
    for (int k = 0; k < 5; k++) {
        int middle = (lo + hi) >> 1;
        float sum = ism_weight(texelFetch(sums, base + along * middle, 0), least);
        bool past = lo < hi && !(sum > x);
        if (past) {
            lo = middle + 1;
            before = sum;
        }
        if (!past) hi = max(middle, lo);
    }
    x -= before;
    return lo;
}

// Returns the cell of `count` in a row or column into which x falls, x below the total, and makes x the rest
// within the cell. The three levels are those of the row, or of the column.
int ism_search(usampler2D sums0, usampler2D sums1, usampler2D sums2, float least, ivec2 base, ivec2 along,
               int count, inout float x)
{
    int blocks = (count + 31) >> 5;
    int k = ism_search_block(sums2, least, base, along, 0, (blocks + 31) >> 5, x);
    k = ism_search_block(sums1, least, base, along, 32 * k, blocks, x);
    return ism_search_block(sums0, least, base, along, 32 * k, count, x);
}
