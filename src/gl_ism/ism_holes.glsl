// ism_holes - finds texels whose surfels are seen through holes between others.
// uses: ism_fill

// The program has this function, which returns the depth of a texel of the atlas.
float ism_depth(ivec2 at);

// Returns whether texel `at` of the atlas, whose depth is c, is a hole: whether planes of surfels in all four
// quadrants about the texel pass before it.
bool ism_hole(ism_grid grid, ivec2 at, float c)
{
    int size = int(ISM_F.tile_side);
    ivec2 local = at & (size - 1);
    vec3 w = ism_texel_direction(grid, local);
    uint found = 0u;
    for (int dy = -ISM_HOLE; dy <= ISM_HOLE; dy++)
        for (int dx = -ISM_HOLE; dx <= ISM_HOLE; dx++) {
            ivec2 d = ivec2(dx, dy), there = local + d;
            if (clamp(there, 0, size - 1) != there) {
                found |= ism_quadrant(d);
                continue;
            }
            float depth = ism_depth(at + d);
            if (!(depth < 0.9 * c)) continue;
            float t = ism_plane_depth(grid.exponent < 0.0, ism_plane_at(at + d).xyz, w);
            if (t > 0.5 * depth && t < 0.95 * c) found |= ism_quadrant(d);
        }
    return found == 15u;
}
