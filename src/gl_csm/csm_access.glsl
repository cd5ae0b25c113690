// csm_access - defines what the files cohsm_* ask of a program, by the textures that glbk_csm_bind binds.
// uses: table csm_bindings
#define COHSM_TEXEL(i) texelFetch(glbk_csm_blocks, glbk_table_at(i), 0)
#define COHSM_LIGHT_TEXEL(i) texelFetch(glbk_csm_lights, glbk_table_at(i), 0)
#define COHSM_LOBE(i) COHSM_LIGHT_TEXEL(i)
#ifndef COHSM_LOBES
#define COHSM_LOBES 1
#endif
// What the programs csm_* have as constants.
#ifdef CSM_ASK
#define COHSM_ONE_LIGHT CSM_ASK
#endif
#ifdef CSM_FILTER
#define COHSM_ONE_FILTER CSM_FILTER
#endif
#ifdef CSM_SHAPE
#define COHSM_ONE_SHAPE CSM_SHAPE
#endif
