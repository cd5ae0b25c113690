/* ---- wavelets: this header's GLSL, textures and block, by which programs find them ---- */

GLBK__LISTS_CODE(haar, HAAR)
GLBK__PART_DATA(haar)

GLBK__DEF const glbk_part *glbk__wavelets(void) { return &glbk__haar_part; }
