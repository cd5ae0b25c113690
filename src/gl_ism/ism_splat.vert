// Places a surfel as a disc in the tile of its VPL: as a point as large as the texels that the disc may
// touch, or with ISM_QUADS as a rectangle of these, with an instance for each surfel.
// uses: ism_disc
#ifndef ISM_QUADS
#define ISM_QUADS 0
#endif
#ifndef ISM_HITS
#define ISM_HITS 0
#endif
flat out vec4 ism_at;       // xyz: the disc's middle in the tile's space; w: its squared radius
flat out vec4 ism_plane;    // xyz: the disc's plane; w: the exponent of the tile's grid
flat out vec4 ism_across;   // the axes of the grid
flat out vec4 ism_down;
flat out ivec4 ism_box;     // the first and the last texel of the atlas that the disc may touch
flat out vec4 ism_cut1;
flat out vec4 ism_cut2;
#if ISM_HITS
flat out uint ism_triangle;     // for ism_bounce.frag
#endif

void main()
{
#if ISM_QUADS
    uint index = uint(gl_InstanceID) + ISM_F.first_surfel;
#else
    uint index = uint(gl_VertexID);
    gl_PointSize = 1.0;
#endif
    uint v = index / ISM_F.phase_surfel_count;       // the surfels of one phase are bound
    ism_surfel s;
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    ism_at = vec4(0.0);
    ism_plane = vec4(0.0);
    ism_across = ism_down = vec4(0.0);
    ism_box = ivec4(0);
    ism_cut1 = ism_cut2 = vec4(0.0);
#if ISM_HITS
    ism_triangle = texelFetch(glbk_ism_surfels, glbk_table_at(index), 0).x;
#endif
    if (v >= ISM_F.vpl_count) return;
    ism_vpl l = ism_read_vpl(v);
    if (!ism_surfel_of(index, v, l, s)) return;
    ism_at = vec4(s.at, s.radius2);
    ism_plane = vec4(s.g, l.grid.exponent);
    ism_across = l.grid.across;
    ism_down = l.grid.down;
    ism_cut1 = s.cut1;
    ism_cut2 = s.cut2;
    ism_box = s.box + ism_tile_at(v).xyxy;
#if ISM_QUADS
    vec2 at = vec2((gl_VertexID & 1) != 0 ? ism_box.z + 1 : ism_box.x,
                   (gl_VertexID & 2) != 0 ? ism_box.w + 1 : ism_box.y);
#else
    vec2 at = 0.5 * vec2(ism_box.xy + ism_box.zw + 1);
    ivec2 wide = s.box.zw - s.box.xy;
    gl_PointSize = float(max(wide.x, wide.y) + 1);
#endif
    uint side = ISM_F.tile_side * ISM_F.tiles_across;
    gl_Position = vec4(at / float(side) * 2.0 - 1.0, 0.0, 1.0);
}
