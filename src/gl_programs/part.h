/* ---- part: the base's own GLSL, textures and blocks ---- */

GLBK__LISTS_CODE(base, BASE)
GLBK__PART_DATA(base)

GLBK__DEF const glbk_part *glbk__base(void) { return &glbk__base_part; }
