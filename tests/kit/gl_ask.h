/* gl_ask.h - functions of the shader library asked by a program of one's own, for many points at once. Include
   cmocka.h, gl_backend.h and gl_test.h before.

       gl_ask(t, NULL, GL_ASK("    r.x = cohsm_exp(layer(0).x);\n"), "cohsm_math", NULL, NULL, NULL, in, 1, count,
              1, out);

   The text sees layer(k), four numbers of its point, and group, which four numbers of its result r are wanted. */
#ifndef GL_ASK_H
#define GL_ASK_H

#define GL_ASK(text)                                                                                           \
    "uniform highp usampler2DArray mine;\n"                                                                    \
    "layout(location = 0) out glbk_color result;\n"                                                            \
    "ivec3 at;\n"                                                                                              \
    "vec4 layer(int k) { return uintBitsToFloat(texelFetch(mine, ivec3(at.xy, k), 0)); }\n"                    \
    "void main()\n{\n    int height = textureSize(mine, 0).y, group = int(gl_FragCoord.y) / height;\n"         \
    "    vec4 r = vec4(0.0);\n    at = ivec3(gl_FragCoord.xy, 0);\n    at.y -= group * height;\n"                \
    text "    result = glbk_pack(r);\n}\n"

/* in: for each layer 4 numbers a point, out: for each group 4 numbers a point. bind: what the library needs, or
   NULL. */
static inline void gl_ask(gl_test *t, const glbk_part *part, const char *fragment, const char *uses,
                          const char *defines,
                          void (*bind)(gl_test *t, const void *user), const void *user, const float *in,
                          uint32_t layers, size_t count, uint32_t groups, float *out)
{
    enum { UNIT = 15, LINE = 1024 };            /* a unit behind those of the library */
    const uint32_t width = count < LINE ? (uint32_t)count : LINE, height = (uint32_t)((count + width - 1) / width);
    const size_t size = 4 * (size_t)width * height;
    float *data = (float *)calloc(size * (layers + groups + 1), sizeof *data);
    gl_canvas canvas = gl_canvas_make(t, GLBK_FORMAT_COLOR, width, height * groups, 0);
    glbk_texture_desc td;
    glbk_texture mine;
    glbk_buffer zeros;                          /* for blocks that the functions asked do not read */
    glbk_program program;
    glbk_source source;
    glbk_pass pass;
    uint32_t k;
    assert_non_null(data);
    for (k = 0; k < layers; k++) memcpy(data + k * size, in + 4 * k * count, 16 * count);
    memset(&td, 0, sizeof td);
    memset(&source, 0, sizeof source);
    memset(&pass, 0, sizeof pass);
    td.format = GLBK_FORMAT_RGBA32UI;
    td.width = width;
    td.height = height;
    td.layers = layers > 1 ? layers : 2;        /* an array even so */
    td.data = data;
    source.fragment = fragment;
    source.parts[0] = part;
    source.uses = uses;
    source.defines = defines;
    pass.target = &canvas.target;
    assert_glbk(t, glbk_texture_create(&t->gl, &td, &mine));
    assert_glbk(t, glbk_program_compile(&t->gl, &source, &program));
    assert_glbk(t, glbk_begin(&t->gl, &pass, &program));
    assert_glbk(t, glbk_buffer_create(&t->gl, 16384, NULL, &zeros));
    for (k = 0; k < 4; k++) glbk_bind_block(&t->gl, k, &zeros);
    if (bind) bind(t, user);
    t->gl.gl.Uniform1i(t->gl.gl.GetUniformLocation(program.name, "mine"), UNIT);
    glbk_bind_texture(&t->gl, UNIT, &mine);
    glbk_draw_screen(&t->gl);
    assert_glbk(t, glbk_target_read(&t->gl, &canvas.target, 0, 0, 0, width, height * groups, data));
    for (k = 0; k < groups; k++) memcpy(out + 4 * k * count, data + k * size, 16 * count);
    glbk_program_free(&t->gl, &program);
    glbk_texture_free(&t->gl, &mine);
    glbk_buffer_free(&t->gl, &zeros);
    gl_canvas_free(t, &canvas);
    free(data);
}

#endif
