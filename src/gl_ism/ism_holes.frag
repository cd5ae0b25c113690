// Draws 1 where a texel keeps its surfel, 0 where it is empty or a hole.
// uses: ism_holes
// with: screen.vert
// sets: ISM_PROJECTION=1 | ISM_PROJECTION=4
layout(location = 0) out uint result;

float ism_depth(ivec2 at) { return ism_plane_at(at).w; }

void main()
{
    ivec2 at = ISM_HERE;
    uint v = ism_tile_of(at);
    float depth = ism_depth(at);
    result = 0u;
    if (!(depth < ISM_FAR) || v >= ISM_F.vpl_count) return;
    result = ISM_F.fill_levels != 0u && ism_hole(ism_read_grid(v), at, depth) ? 0u : 1u;
}
