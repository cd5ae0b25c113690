/* ---- sfield: this header's GLSL, textures and blocks, by which programs find them ---- */

GLBK__PART_CODE(sfield, SFIELD)

/* The part as the programs of gl_wavelets.h use it has only the files that read fields. */
static const glbk_file glbk__sfield_reads[] = {
    { (const char *)&glbk__glsl_lib_sfield_bindings_glsl },
    { (const char *)&glbk__glsl_lib_sfield_contents_glsl },
    { (const char *)&glbk__glsl_lib_sfield_field_glsl }
};
static const glbk_part glbk__sfield_reads_part = {
    "sfield", glbk__sfield_reads, sizeof glbk__sfield_reads / sizeof glbk__sfield_reads[0],
    glbk__sfield_slots
};

GLBK__DEF const glbk_part *glbk__sfield_reader(void) { return &glbk__sfield_reads_part; }
