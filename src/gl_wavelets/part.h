/* ---- wavelets: this header's GLSL, textures and block, by which programs find them ---- */

GLBK__PART_CODE(haar, HAAR)
