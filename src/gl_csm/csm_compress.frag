// Compresses the maps, one pixel by each fragment; its open segment goes on in the first target.
// uses: csm_compress
// with: screen.vert
layout(location = 0) out uvec4 open_now;
layout(location = 1) out uvec4 records0;
layout(location = 2) out uvec4 records1;
layout(location = 3) out uvec4 records2;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    uvec4 s = texelFetch(glbk_csm_opened, at, 0);
    csm_open o = csm_open(s.x & 255u, (s.x >> 8) & 255u, (s.x >> 16) != 0u, s.y);
    csm_ended ended = csm_compress(at, o);
    open_now = uvec4(o.lo | (o.hi << 8) | (o.fresh ? 1u << 16 : 0u), o.next, ended.count, 0u);
    records0 = ended.records[0];
    records1 = ended.records[1];
    records2 = ended.records[2];
}
