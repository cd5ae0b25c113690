/* ---- gbuffer: this header's GLSL, textures and blocks, by which programs find them ---- */

GLBK__PART_CODE(gbuffer, GBUFFER)

/* The part as the techniques' own programs use it has only the files that read and those of pictures,
   so that a linker leaves out those that draw and import. */
static const glbk_file glbk__gbuffer_reads[] = {
    { (const char *)&glbk__glsl_lib_gbuffer_glsl },
    { (const char *)&glbk__glsl_lib_gbuffer_bindings_glsl },
    { (const char *)&glbk__glsl_lib_gbuffer_pack_glsl },
    { (const char *)&glbk__glsl_lib_picture_glsl },
    { (const char *)&glbk__glsl_lib_shown_glsl }
};
static const glbk_part glbk__gbuffer_reader = {
    "gbuffer", glbk__gbuffer_reads, sizeof glbk__gbuffer_reads / sizeof glbk__gbuffer_reads[0],
    glbk__gbuffer_slots
};
