/* ---- ism: this header's GLSL, textures and blocks, by which programs find them ---- */

GLBK__PART_CODE(ism, ISM)
