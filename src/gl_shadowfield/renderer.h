/* ---- sfield: the renderer: light of a scene at the pixels of a G-buffer ---- */

enum { GLBK__SFIELD_TERMS = 200 };      /* leaves room for the 163 of 4 bands */

/* Makes the textures of a size: light, gloss and grazing with their target, and self-visibility. */
static glbk_result glbk__sfield_textures(glbk_context *ctx, glbk_sfield_renderer *r, int gloss, int grazing,
                                         int self)
{
    glbk_texture_desc texture;
    glbk_target_desc target;
    glbk_result result;

    memset(&texture, 0, sizeof texture);
    memset(&target, 0, sizeof target);
    texture.width = r->width;
    texture.height = r->height;
    texture.format = GLBK_FORMAT_COLOR;
    result = glbk_texture_create(ctx, &texture, &r->light);
    target.color[0] = &r->light;
    if (gloss && result == GLBK_OK) {
        result = glbk_texture_create(ctx, &texture, &r->gloss);
        target.color[1] = &r->gloss;
    }
    if (grazing && result == GLBK_OK) {
        result = glbk_texture_create(ctx, &texture, &r->grazing);
        target.color[2] = &r->grazing;
    }
    if (result == GLBK_OK) result = glbk__target_create(ctx, &target, &r->target);
    return result == GLBK_OK && self ? glbk__sfield_self_create(ctx, r) : result;
}

/* Appends "ARRAY[N]". */
static void glbk__sfield_index(glbk__sink *sink, const char *array, uint32_t n)
{
    glbk__append_text(sink, array);
    glbk__append_text(sink, "[");
    glbk__sfield_number(sink, n);
    glbk__append_text(sink, "]");
}

/* Appends "(a[i]*b[j]+a[j]*b[i])", or "(a[i]*b[i])" if i and j are the same. */
static void glbk__sfield_pair(glbk__sink *sink, uint32_t i, uint32_t j)
{
    glbk__sfield_index(sink, "(a", i);
    glbk__sfield_index(sink, "*b", j);
    if (i != j) {
        glbk__sfield_index(sink, "+a", j);
        glbk__sfield_index(sink, "*b", i);
    }
    glbk__append_text(sink, ")");
}

GLBK_DEF size_t glbk_sfield_write_product(const sfield_algebra *algebra, char *out, size_t out_bytes)
{
    static const char head[] =
        "void sfield_product(uvec2 terms, float a[SFIELD_COEFS], float b[SFIELD_COEFS], "
        "out float r[SFIELD_COEFS])\n{\nfloat s=0.0;\n";
    const uint32_t bands = algebra ? glbk__sfield_bands(algebra) : 0;
    uint32_t terms[GLBK__SFIELD_TERMS], k, e, count;
    float factors[GLBK__SFIELD_TERMS];
    glbk__sink sink;

    if (bands < 1 || bands > 4) return 0;
    count = (uint32_t)sfield_sh_terms(algebra, terms, factors);
    sink.out = out;
    sink.bytes = out ? out_bytes : 0;
    sink.used = 0;
    glbk__append_text(&sink, head);
    for (k = 0; k < bands * bands; k++) {
        glbk__sfield_index(&sink, "s+=a", k);
        glbk__sfield_index(&sink, "*b", k);
        glbk__append_text(&sink, ";\n");
        if (!k) continue;
        glbk__sfield_index(&sink, "r", k);
        glbk__append_text(&sink, "=SFIELD_Y00*");
        glbk__sfield_pair(&sink, 0, k);
        for (e = 0; e < count; e++) {
            uint32_t bits;
            if (terms[e] >> 16 != k) continue;
            memcpy(&bits, &factors[e], 4);      /* its bits are the same in every locale */
            glbk__append_text(&sink, "\n+uintBitsToFloat(");
            glbk__sfield_number(&sink, bits);
            glbk__append_text(&sink, "u)*");
            glbk__sfield_pair(&sink, terms[e] & 255u, terms[e] >> 8 & 255u);
        }
        glbk__append_text(&sink, ";\n");
    }
    glbk__append_text(&sink, "r[0]=SFIELD_Y00*s;\n}\n");
    if (sink.bytes) out[sink.used < sink.bytes ? sink.used : sink.bytes - 1] = 0;
    return sink.used + 1;
}

/* Compiles the pass's program with the product written out, which stands after sfield_field and before the
   functions that call it. */
static glbk_result glbk__sfield_compile(glbk_context *ctx, const sfield_algebra *algebra, const char *defines,
                                        int compute, glbk_program *out)
{
    const char *const names[] = { "lib/sfield_shade.glsl", "lib/sfield_point.glsl",
                                  compute ? "prog/sfield_shade.comp" : "prog/sfield_shade.frag" };
    glbk_sfield__allocator memory = glbk_sfield__memory(ctx);
    size_t product = glbk_sfield_write_product(algebra, NULL, 0);
    glbk_source source;
    glbk__sink sink = { NULL, 0, 0 };
    glbk_result result;
    uint32_t i;

    for (i = 0; i < 3; i++) glbk__append_file(&sink, glbk_find_file(glbk_sfield_part(), names[i]));
    sink.bytes = product + sink.used;
    sink.out = (char *)glbk_sfield__alloc(&memory, sink.bytes);
    if (!sink.out) return GLBK_ERR_ALLOC;
    glbk_sfield_write_product(algebra, sink.out, sink.bytes);
    sink.used = product - 1;
    for (i = 0; i < 3; i++) glbk__append_file(&sink, glbk_find_file(glbk_sfield_part(), names[i]));
    sink.out[sink.used] = 0;
    memset(&source, 0, sizeof source);
    source.parts[0] = glbk_sfield_part();
    source.parts[1] = glbk_gbuffer_part();
    *(compute ? &source.compute : &source.fragment) = sink.out;
    source.uses = compute ? "sfield_list sfield_brdf gbuffer" : "sfield_access sfield_brdf gbuffer";
    source.defines = defines;
    result = glbk_program_compile(ctx, &source, out);
    glbk_sfield__free(&memory, sink.out);
    return result;
}

/* Checks the desc of glbk_sfield_renderer_create. */
static glbk_result glbk__sfield_check_renderer(const glbk_context *ctx, const char *function,
                                               const glbk_sfield_renderer_desc *d)
{
    glbk_result result;
    if (!d) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "desc", "is NULL");
    if (!d->algebra) return glbk__refuse(ctx, GLBK_ERR_DESC, function, "desc.algebra", "is NULL");
    result = glbk__require_side(ctx, function, "desc.width", d->width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, function, "desc.height", d->height);
    if (result != GLBK_OK) return result;
    if (d->grazing && !d->materials)
        return glbk__refuse(ctx, GLBK_ERR_DESC, function, "desc.grazing", "is wanted without desc.materials");
    if (d->self_attribute > 12)
        return glbk__refuse_range(ctx, GLBK_ERR_DESC, function, "desc.self_attribute", d->self_attribute, 0,
                                  12);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_sfield_renderer_create(glbk_context *ctx, const glbk_sfield_renderer_desc *d,
                                                 glbk_sfield_renderer *out)
{
    char defines[] = "SFIELD_BANDS=4 SFIELD_GLOSS=0 SFIELD_SELF=0 SFIELD_GRAZING=0 SFIELD_EXP=0 "
                     "SFIELD_UNROLLED";
    int unrolled;
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!out) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "out", "is NULL");
    memset(out, 0, sizeof *out);
    result = glbk__sfield_check_renderer(ctx, __func__, d);
    if (result != GLBK_OK) return result;
    out->width = d->width;
    out->height = d->height;
    out->bands = glbk__sfield_bands(d->algebra);
    out->compute = ctx->compute;
    unrolled = !d->product_in_table && out->bands < 5;
    if (!unrolled) defines[73] = 0;
    out->materials = d->materials != 0;
    out->logarithms = d->logarithms != 0;
    defines[13] = (char)('0' + out->bands);
    defines[28] = d->materials ? '2' : d->gloss ? '1' : '0';
    defines[42] = d->self ? '1' : '0';
    defines[59] = d->grazing ? '1' : '0';
    defines[72] = d->logarithms ? '1' : '0';
    out->self_attribute = d->self_attribute ? d->self_attribute : 4;
    result = glbk__sfield_textures(ctx, out, d->gloss || d->materials, d->grazing, d->self);
    if (result == GLBK_OK)
        result = unrolled ? glbk__sfield_compile(ctx, d->algebra, defines, out->compute, &out->shade)
                          : glbk__gbuffer_program(ctx, glbk_sfield_part(),
                                                  out->compute ? "sfield_shade.comp" : "sfield_shade.frag",
                                                  defines, &out->shade);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_sfield_frame), NULL, &out->frame);
    if (result == GLBK_OK) result = glbk_buffer_create(ctx, sizeof(glbk_sfield_object), NULL, &out->object);
    if (result != GLBK_OK) glbk_sfield_renderer_free(ctx, out);
    return result;
}

static void glbk__sfield_free_textures(glbk_context *ctx, glbk_sfield_renderer *r)
{
    glbk_target_free(ctx, &r->target);
    glbk_target_free(ctx, &r->self_target);
    glbk_texture_free(ctx, &r->light);
    glbk_texture_free(ctx, &r->gloss);
    glbk_texture_free(ctx, &r->grazing);
    glbk_texture_free(ctx, &r->self);
}

GLBK_DEF glbk_result glbk_sfield_renderer_resize(glbk_context *ctx, glbk_sfield_renderer *r, uint32_t width,
                                                 uint32_t height)
{
    const int gloss = r && r->gloss.name, grazing = r && r->grazing.name, self = r && r->self.name;
    glbk_result result = glbk__require_created(ctx, __func__, "renderer", r ? &r->target.name : NULL);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "width", width);
    if (result == GLBK_OK) result = glbk__require_side(ctx, __func__, "height", height);
    if (result != GLBK_OK) return result;
    glbk__sfield_free_textures(ctx, r);
    r->width = width;
    r->height = height;
    result = glbk__sfield_textures(ctx, r, gloss, grazing, self);
    if (result != GLBK_OK) glbk_sfield_renderer_free(ctx, r);
    return result;
}

GLBK_DEF void glbk_sfield_renderer_free(glbk_context *ctx, glbk_sfield_renderer *r)
{
    if (!r) return;
    glbk_program_free(ctx, &r->shade);
    glbk_program_free(ctx, &r->record);
    glbk__sfield_free_textures(ctx, r);
    glbk_buffer_free(ctx, &r->frame);
    glbk_buffer_free(ctx, &r->object);
    memset(r, 0, sizeof *r);
}

GLBK_DEF glbk_result glbk_sfield_shade(glbk_context *ctx, glbk_sfield_renderer *r, const glbk_gbuffer *g,
                                       const glbk_sfield_scene *s, const float eye[3], int open)
{
    glbk_sfield_frame frame;
    glbk_sfield_contents contents;
    glbk_pass pass;
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!r || !r->shade.name)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "renderer", r ? "was not created" : "is NULL");
    result = glbk__sfield_check_scene(ctx, __func__, s);
    if (result == GLBK_OK) result = glbk__sfield_check_gbuffer(ctx, __func__, r->width, r->height, g);
    if (result != GLBK_OK) return result;
    if (!eye && g->has_clip) eye = g->eye;
    if (r->gloss.name && !eye)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "eye",
                            "is NULL: lobes need it, and the G-buffer has none");
    if (s->cube_side) return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "scene", "has wavelets");
    if (s->bands != r->bands)
        return glbk__refuse_value(ctx, GLBK_ERR_MISMATCH, __func__, "scene->bands", s->bands,
                                  "that of the renderer");
    if (r->materials && !s->has_brdf)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "scene",
                            "has no desc.brdf, which the renderer's materials need");
    if (!r->logarithms != !s->logarithms)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "scene",
                            r->logarithms ? "has no logarithms, which desc.logarithms says"
                                          : "has fields of logarithms, without desc.logarithms");
    memset(&frame, 0, sizeof frame);
    memset(&pass, 0, sizeof pass);
    if (eye) memcpy(frame.eye, eye, 12);
    contents = glbk__sfield_contents_of(s, s->sky || open);
    result = glbk__put_block(ctx, GLBK_SLOT_glbk_sfield_frame, &r->frame, &frame);
    if (result == GLBK_OK)
        result = glbk__put_block(ctx, GLBK_SLOT_glbk_sfield_contents, &s->contents, &contents);
    pass.target = &r->target;
    if (result == GLBK_OK && !r->compute) result = glbk_begin(ctx, &pass, &r->shade);
    if (result != GLBK_OK) return result;
    glbk_sfield_bind(ctx, s, NULL);
    result = glbk_gbuffer_bind(ctx, g, NULL);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(ctx, GLBK_SLOT_glbk_sfield_self, &r->self);
    if (r->compute) {
        glbk_bind_image(ctx, GLBK_SLOT_glbk_sfield_light_image, &r->light);
        glbk_bind_image(ctx, GLBK_SLOT_glbk_sfield_gloss_image, &r->gloss);
        glbk_bind_image(ctx, GLBK_SLOT_glbk_sfield_grazing_image, &r->grazing);
        return glbk_dispatch(ctx, &r->shade, (r->width + 7) / 8, (r->height + 7) / 8, 1);
    }
    glbk_draw_screen(ctx);
    return GLBK_OK;
}

GLBK_DEF glbk_result glbk_sfield_read(glbk_context *ctx, glbk_sfield_renderer *r, float *light, float *gloss)
{
    glbk_result result = GLBK_OK;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!r || !r->target.name)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "renderer", r ? "was not created" : "is NULL");
    if (gloss && !r->gloss.name)
        return glbk__refuse(ctx, GLBK_ERR_MISMATCH, __func__, "gloss",
                            "is asked of a renderer without desc.gloss");
    if (light) result = glbk_target_read(ctx, &r->target, 0, 0, 0, r->width, r->height, light);
    if (gloss && result == GLBK_OK)
        result = glbk_target_read(ctx, &r->target, 1, 0, 0, r->width, r->height, gloss);
    return result;
}
