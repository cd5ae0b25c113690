/* ---- part: the base's own GLSL, textures and blocks ---- */

GLBK__PART_CODE(base, BASE)
