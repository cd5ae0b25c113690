// Makes running sums of the rows of a map, or (ROWS=1) of the last sums of its rows. A group has a row in
// shared memory. The steps are those of rsm_scan.frag, of eight values each, so that both ways pick the same
// texels. The mean's factor 1 / 3 is multiplied where rsm_scan.frag does so, since compilers make one
// operation of product and sum.
// uses: rsm_pick
// sets: ROWS=0 | ROWS=1
#ifndef ROWS
#define ROWS 0
#endif
layout(local_size_x = 256) in;
shared float rsm_row[2][4096];

void main()
{
    int size = int(glbk_rsm_light.side), now = 0;
    ivec3 at = ivec3(gl_LocalInvocationIndex, gl_WorkGroupID.xy);
    for (int x = at.x; x < size; x += 256)
#if ROWS
        rsm_row[0][x] = RSM_ROW_SUM(ivec3(size - 1, x, at.z));
#else
    {
        vec3 flux = uintBitsToFloat(RSM_TEXEL(ivec3(x, at.yz), 2).xyz);
        rsm_row[0][x] = flux.x + flux.y + flux.z;
    }
#endif
    float scale = ROWS == 0 ? 1.0 / 3.0 : 1.0;
    for (int stride = 1; stride < size; stride *= 8, now = 1 - now) {
        barrier();
        for (int x = at.x; x < size; x += 256) {
            float sum = 0.0;
            for (int k = 0; k < 8 && x - k * stride >= 0; k++) sum += rsm_row[now][x - k * stride] * scale;
            rsm_row[1 - now][x] = sum;
        }
        scale = 1.0;
    }
    for (int x = at.x; x < size; x += 256)          // this invocation reads its own sums
        imageStore(glbk_rsm_running, ivec3(x, at.yz), uvec4(floatBitsToUint(rsm_row[now][x])));
}
