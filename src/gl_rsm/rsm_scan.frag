// Draws one step of running sums along x: sums of 8 values that lie `stride` apart. FROM says which values: 0
// the mean flux of the map, 1 sums of the step before, 2 the last sums of rows, 3 sums of these.
// uses: rsm_pick
// with: screen.vert
// sets: FROM=0 | FROM=1 | FROM=2 | FROM=3
#ifndef FROM
#define FROM 0
#endif
layout(location = 0) out uint result;

void main()
{
    ivec3 at = ivec3(ivec2(gl_FragCoord.xy), int(glbk_rsm_frame.face));
    int stride = int(glbk_rsm_frame.stride);
    float sum = 0.0;
    for (int k = 0; k < 8 && at.x >= 0; k++, at.x -= stride) {
#if FROM == 0
        sum += rsm_mean3(uintBitsToFloat(RSM_TEXEL(at, 2).xyz));
#elif FROM == 1
        sum += RSM_ROW_SUM(at);
#elif FROM == 2
        sum += RSM_ROW_SUM(ivec3(textureSize(glbk_rsm_sums, 0).x - 1, at.x, at.z));
#else
        sum += RSM_ROWS_SUM(at.x, at.z);
#endif
    }
    result = floatBitsToUint(sum);
}
