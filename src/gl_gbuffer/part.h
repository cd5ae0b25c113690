/* ---- gbuffer: this header's GLSL, textures and blocks, by which programs find them ---- */

GLBK__PART_CODE(gbuffer, GBUFFER)

/* The part as the techniques' own programs use it has only the files that read and those of pictures,
   so that a linker leaves out those that draw and import. */
#define GLBK__GBUFFER_FILE(name, text, uses) { name "\0" uses "\0\0\0", (const char *)&text }
static const glbk_file glbk__gbuffer_reads[] = {
    GLBK__GBUFFER_FILE("lib/gbuffer.glsl", glbk__glsl_lib_gbuffer_glsl, "gbuffer_bindings gbuffer_pack"),
    GLBK__GBUFFER_FILE("lib/gbuffer_bindings.glsl", glbk__glsl_lib_gbuffer_bindings_glsl, ""),
    GLBK__GBUFFER_FILE("lib/gbuffer_pack.glsl", glbk__glsl_lib_gbuffer_pack_glsl, ""),
    GLBK__GBUFFER_FILE("lib/picture.glsl", glbk__glsl_lib_picture_glsl, "shown"),
    GLBK__GBUFFER_FILE("lib/shown.glsl", glbk__glsl_lib_shown_glsl, "")
};
static const glbk_part glbk__gbuffer_reader = {
    "gbuffer", glbk__gbuffer_reads, sizeof glbk__gbuffer_reads / sizeof glbk__gbuffer_reads[0],
    glbk__gbuffer_units, glbk__gbuffer_bindings, NULL, NULL
};
