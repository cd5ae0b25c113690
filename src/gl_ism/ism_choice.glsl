// ism_choice - the block of the programs that choose VPLs, by a short name, since 40 places have it.
// uses: ism_bindings
#define ISM_C glbk_ism_choosing
