// Finds holes and does all levels of pull, and push, in one pass. A group has a whole tile in shared memory,
// or of larger tiles 32 x 32 texels and 16 more at each side, eight of which may keep surfels. Each
// invocation has 16 of these 64 x 64 texels.
// uses: ism_holes ism_push
// sets: ISM_PROJECTION=1 | ISM_PROJECTION=4
layout(local_size_x = 256) in;
#define ISM_SIDE 64

shared float ism_depths[ISM_SIDE * ISM_SIDE];       // of surfels that are kept, else ISM_FAR
shared uint ism_cells[1024 + 256 + 64];             // of the levels, one after the other
ivec2 ism_origin;                                   // of those texels, in the atlas

// Returns the place of a cell among those of all levels.
uint ism_cell(int level, ivec2 cell)
{
    uint wide = uint(ISM_SIDE >> level), first = level == 1 ? 0u : level == 2 ? 1024u : 1280u;
    return first + uint(cell.y) * wide + uint(cell.x);
}

// Returns texel i of the group.
ivec2 ism_texel(uint i) { return ivec2(i % uint(ISM_SIDE), i / uint(ISM_SIDE)); }

float ism_depth(ivec2 at)
{
    ivec2 texel = at - ism_origin;
    return ism_depths[texel.y * ISM_SIDE + texel.x];
}

int ism_pulled(int level, ivec2 cell)
{
    return int(ism_cells[ism_cell(level, cell - (ism_origin >> level))]);
}

// Returns 1 + the index of a part's texel, or 0 if the part has none. Of level 0, returns 1 if the texel
// keeps its surfel.
uint ism_part(int level, ivec2 cell)
{
    if (level == 0) return ism_depths[cell.y * ISM_SIDE + cell.x] < ISM_FAR ? 1u : 0u;
    return ism_cells[ism_cell(level, cell)];
}

void main()
{
    int size = int(ISM_F.tile_side), levels = int(ISM_F.fill_levels);
    int block = size > ISM_SIDE ? 32 : size, margin = size > ISM_SIDE ? 16 : 0;
    ivec2 begin = ivec2(gl_WorkGroupID.xy) * block, tile = begin - (begin & (size - 1));
    uint v = ism_tile_of(begin), holes = 0u, thread = gl_LocalInvocationIndex;
    bool used = v < ISM_F.vpl_count;
    ism_grid grid = ism_read_grid(used ? v : 0u);
    ism_origin = begin - margin;
    for (uint i = thread; i < uint(ISM_SIDE * ISM_SIDE); i += 256u) {
        ivec2 at = ism_origin + ism_texel(i), local = at - tile;
        bool inside = used && clamp(local, 0, size - 1) == local;
        ism_depths[i] = inside ? ism_plane_at(at).w : ISM_FAR;
    }
    barrier();
    for (uint k = 0u; k < 16u && levels != 0; k++) {
        ivec2 texel = ism_texel(thread + 256u * k);
        float depth = ism_depth(ism_origin + texel);
        bool near_by = clamp(texel, margin / 2, ISM_SIDE - 1 - margin / 2) == texel;
        if (near_by && depth < ISM_FAR && ism_hole(grid, ism_origin + texel, depth)) holes |= 1u << k;
    }
    barrier();
    for (uint k = 0u; k < 16u; k++)
        if ((holes >> k & 1u) != 0u) ism_depths[thread + 256u * k] = ISM_FAR;
    for (int level = 1; level <= levels; level++) {
        int wide = ISM_SIDE >> level;
        barrier();
        for (int i = int(thread); i < wide * wide; i += 256) {
            ivec2 cell = ivec2(i % wide, i / wide);
            uvec4 parts;
            for (int k = 0; k < 4; k++) parts[k] = ism_part(level - 1, 2 * cell + ivec2(k & 1, k >> 1));
            ism_cells[ism_cell(level, cell)] = ism_pull(level, cell + ((ism_origin - tile) >> level), parts);
        }
    }
    barrier();
    for (uint i = thread; i < uint(block * block); i += 256u) {
        ivec2 at = begin + ivec2(i % uint(block), i / uint(block)), from;
        float depth = ism_depth(at);
        if (used && levels != 0 && !(depth < ISM_FAR)) depth = ism_filled(grid, at, from);
        imageStore(glbk_ism_atlas_out, at, uvec4(floatBitsToUint(depth), 0u, 0u, 0u));
    }
}
