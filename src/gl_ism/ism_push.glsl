// ism_push - finds depths of texels that kept no surfel.
// uses: ism_fill

// The program has this function, which returns the texel of a cell of the atlas, as ism_pull did.
int ism_pulled(int level, ivec2 cell);

struct ism_near {
    int first, second;          // the nearest two texels that keep their surfels, as 1 + index; 0 = none
    int least, next;            // their squared distances
    uint found;                 // the sectors in which texels were found
    uint close;                 // the sectors in which level 1 has texels
    uint beyond;                // the sectors beyond the tile's border
};

// Looks at the 3 x 3 cells of a level about a texel.
void ism_look(int level, ivec2 at, inout ism_near n)
{
    int size = int(ISM_F.tile_side), half_size = size >> level;
    ivec2 local = at & (size - 1), cell = local >> level, origin = (at >> level) - cell;
    for (int y = cell.y - 1; y <= cell.y + 1; y++)
        for (int x = cell.x - 1; x <= cell.x + 1; x++) {
            if (x < 0 || y < 0 || x >= half_size || y >= half_size) {
                n.beyond |= ism_sector(ivec2(x, y) - cell);
                continue;
            }
            int there = ism_pulled(level, origin + ivec2(x, y));
            if (there == 0) continue;
            ivec2 d = ivec2((there - 1) % size, (there - 1) / size) - local;
            int d2 = d.x * d.x + d.y * d.y;
            n.found |= ism_sector(d);
            if (n.first == 0 || d2 < n.least) {
                if (n.first != 0 && n.first != there) {
                    n.second = n.first;
                    n.next = n.least;
                }
                n.first = there;
                n.least = d2;
            } else if (n.first != there && (n.second == 0 || d2 < n.next)) {
                n.second = there;
                n.next = d2;
            }
        }
    if (level == 1) n.close = n.found;
}

// Returns the depth of the first texel, or the depth of its plane here, whichever would have foretold the
// second texel's depth better. No depths are mixed.
float ism_push(ism_grid grid, ivec2 local, ivec2 first, ivec2 second, ivec2 origin)
{
    vec4 a = ism_plane_at(origin + first), b = ism_plane_at(origin + second);
    float t = ism_plane_depth(grid.exponent < 0.0, a.xyz, ism_texel_direction(grid, local));
    float there = ism_plane_depth(grid.exponent < 0.0, a.xyz, ism_texel_direction(grid, second));
    if (abs(a.w - b.w) <= abs(there - b.w)) return a.w;
    return t > 0.5 * a.w && t < 2.0 * a.w ? t : a.w;
}

// Returns the depth of texel `at` of the atlas, in a tile with that grid, by the nearest two texels that keep
// their surfels, or ISM_FAR unless such texels surround it. from: the nearest of them, in the atlas.
float ism_filled(ism_grid grid, ivec2 at, out ivec2 from)
{
    int size = int(ISM_F.tile_side);
    ivec2 local = at & (size - 1);
    from = at;
    ism_near n = ism_near(0, 0, 0, 0, 0u, 0u, 0u);
    for (int level = 1; level <= int(ISM_F.fill_levels); level++) {
        if (n.second != 0 && ism_surrounded(n.found, n.close, n.beyond)) break;
        ism_look(level, at, n);
    }
    if (n.second == 0 || !ism_surrounded(n.found, n.close, n.beyond)) return ISM_FAR;
    ivec2 first = ivec2((n.first - 1) % size, (n.first - 1) / size);
    from = at - local + first;
    return ism_push(grid, local, first, ivec2((n.second - 1) % size, (n.second - 1) / size), at - local);
}
