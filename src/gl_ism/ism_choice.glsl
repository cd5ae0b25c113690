// ism_choice - the block of the programs that choose VPLs, by a short name, since 40 places have it, and
// where the pictures of VPLs and near points, 256 a row, have each.
// uses: ism_floats
#define ISM_C glbk_ism_choosing
ivec2 ism_cell_of(uint i) { return ivec2(i & 255u, i >> 8); }
