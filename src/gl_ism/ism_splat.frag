// Draws plane and depth of a disc into the texels whose rays meet it.
// uses: ism_disc
// with: ism_splat.vert
// sets: ISM_PROJECTION=1 ISM_QUADS=0 ISM_HITS=0 | ISM_PROJECTION=4 ISM_QUADS=1 ISM_HITS=1
flat in vec4 ism_at;
flat in vec4 ism_plane;
flat in vec4 ism_across;
flat in vec4 ism_down;
flat in ivec4 ism_box;
flat in vec4 ism_cut1;
flat in vec4 ism_cut2;
layout(location = 0) out glbk_color result;
#if ISM_HITS
flat in uint ism_triangle;
layout(location = 1) out uint hit;
#endif

void main()
{
    ivec2 at = ISM_HERE;
    if (clamp(at, ism_box.xy, ism_box.zw) != at) discard;
    ism_surfel s = ism_surfel(ism_at.xyz, ism_plane.xyz, ism_at.w, 0.0, vec2(0.0), ism_cut1, ism_cut2,
                              ism_box);
    ism_grid grid = ism_grid(ism_plane.w, ism_across, ism_down);
    vec3 w = ism_texel_direction(grid, at & (int(ISM_F.tile_side) - 1));
    float t = ism_meet(ism_plane.w < 0.0, s, w, ISM_FAR);
    if (!(t < ISM_FAR)) discard;
    result = glbk_pack(vec4(ism_plane.xyz, t));
#if ISM_HITS
    hit = ism_triangle;
#endif
    gl_FragDepth = t * 5.421010862427522e-20;      // times 2^-64, which keeps every digit of t
}
