// sfield_access - defines what sfield_field asks of a program, by the textures that glbk_sfield_bind binds.
// uses: table sfield_bindings
#define SFIELD_TEXEL(i) texelFetch(glbk_sfield_table, glbk_table_at(i), 0)
#define SFIELD_MOVING(i) texelFetch(glbk_sfield_moving, glbk_table_at(i), 0)
#ifndef SFIELD_BANDS
#define SFIELD_BANDS 4
#endif
#ifndef SFIELD_GLOSS
#define SFIELD_GLOSS 0              // 1: Phong's lobe; 2: the metal-rough BRDF, too
#endif
#ifndef SFIELD_EXP
#define SFIELD_EXP 0                // 1: occlusion fields hold logarithms
#endif
#ifndef SFIELD_GRAZING
#define SFIELD_GRAZING 0
#endif
