// Does what csm_compress.frag does, as a compute shader. Of each pixel, four uvec4 hold the open segment and
// the records.
// uses: csm_compress
layout(local_size_x = 8, local_size_y = 8) in;

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    uint side = glbk_csm_peel.side, i = 4u * (uint(at.y) * side + uint(at.x));
    if (uint(at.x) >= side || uint(at.y) >= side) return;
    uvec4 s = glbk_csm_records[i];
    csm_open o = csm_open(s.x & 255u, (s.x >> 8) & 255u, (s.x >> 16) != 0u, s.y);
    csm_ended ended = csm_compress(at, o);
    glbk_csm_records[i] = uvec4(o.lo | (o.hi << 8) | (o.fresh ? 1u << 16 : 0u), o.next, ended.count, 0u);
    glbk_csm_records[i + 1u] = ended.records[0];
    glbk_csm_records[i + 2u] = ended.records[1];
    glbk_csm_records[i + 3u] = ended.records[2];
}
