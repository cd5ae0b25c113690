/* rsm_gl.h - what the tests of glbk_rsm that know rsm.h share: its descs and meshes on the GPU. Include rsm.h,
   gl_backend.h, gl/gl_test.h and unit/rsm_util.h before. */
#ifndef RSM_GL_H
#define RSM_GL_H

UNUSED_OK glbk_rsm_lamp gl_lamp(const rsm_light *l)
{
    glbk_rsm_lamp out;
    assert_int_equal(sizeof out, sizeof *l);        /* field by field */
    memcpy(&out, l, sizeof out);
    return out;
}

/* The same desc on both sides. */
UNUSED_OK glbk_rsm_gather_desc gl_desc(const rsm_gather_desc *d)
{
    glbk_rsm_gather_desc g;
    memset(&g, 0, sizeof g);
    g.pattern = d->pattern == RSM_PATTERN_FLUX    ? GLBK_RSM_PATTERN_FLUX
                : d->pattern == RSM_PATTERN_MIXED ? GLBK_RSM_PATTERN_MIXED
                                                  : GLBK_RSM_PATTERN_ABOUT;
    g.samples = d->samples;
    g.r_max = d->r_max;
    g.offset = d->offset;
    g.clamp = d->clamp;
    g.near_limit = d->near_limit;
    g.near_field = d->near_field;
    g.seed = d->seed;
    g.interleave = d->interleave;
    return g;
}

/* rsm_pattern_build; Poisson patterns, which are slow to build, are kept. */
UNUSED_OK const float *pattern_of(rsm_pattern p, uint32_t n, const rsm_gather_desc *d)
{
    static float points[3 * 8192], kept[2][3 * 4096];
    static uint32_t counts[2];
    const int keep = p == RSM_PATTERN_POISSON && d->seed < 2 && n <= 4096;
    float *to = keep ? kept[d->seed] : points;
    assert_true(n <= 8192);
    if (keep && counts[d->seed] == n) return to;
    assert_int_equal(rsm_pattern_build(p, n, d->pattern == RSM_PATTERN_MIXED ? 1.0f / 192 : 0, d->paper_weights,
                                       d->seed, to), RSM_OK);
    if (keep) counts[d->seed] = n;
    return to;
}

/* What the desc names, on the GPU. */
UNUSED_OK void upload_tables(gl_test *t, glbk_rsm_renderer *r, const rsm_gather_desc *d)
{
    glbk_rsm_tables tables;
    uint32_t sets = d->interleave ? d->interleave * d->interleave : 1, n = d->samples;
    memset(&tables, 0, sizeof tables);
    if (d->pattern == RSM_PATTERN_MIXED) n = 3 * n / 5;
    n = (n + sets - 1) / sets * sets;
    if (d->pattern > RSM_PATTERN_FLUX && n) {
        tables.points = pattern_of(d->pattern == RSM_PATTERN_MIXED ? RSM_PATTERN_LOG_RADIAL : d->pattern, n, d);
        tables.point_count = n;
    }
    tables.noise = d->noise;
    tables.noise_side = d->noise ? d->noise_side : 0;
    tables.materials = (const float *)(const void *)d->materials;
    tables.material_count = d->material_count;
    assert_glbk(t, glbk_rsm_tables_upload(&t->gl, r, &tables));
}

/* Meshes without strides, drawn by scene_draw into maps and G-buffers. */
enum { SCENE_MESHES = 2 };

typedef struct scene {
    const rsm_mesh     *meshes;
    const glbk_texture *albedo_map;     /* of all, or NULL */
    size_t              count;
    glbk_buffer         vertices[SCENE_MESHES], indices[SCENE_MESHES];
    uint32_t            arrays[SCENE_MESHES];
} scene;

UNUSED_OK void scene_make(gl_test *t, scene *s, const rsm_mesh *meshes, size_t count)
{
    const glbk_functions *gl = &t->gl.gl;
    size_t i;
    assert_true(count <= SCENE_MESHES);
    memset(s, 0, sizeof *s);
    s->meshes = meshes;
    s->count = count;
    gl->GenVertexArrays((int32_t)count, s->arrays);
    for (i = 0; i < count; i++) {
        const rsm_mesh *m = &meshes[i];
        assert_glbk(t, glbk_buffer_create(&t->gl, m->vertex_count * 12, m->positions, &s->vertices[i]));
        assert_glbk(t, glbk_indices_create(&t->gl, m->index_count * 4, m->indices, &s->indices[i]));
        gl->BindVertexArray(s->arrays[i]);
        gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, s->vertices[i].name);
        gl->EnableVertexAttribArray(0);
        gl->VertexAttribPointer(0, 3, GLBK_GL_FLOAT, 0, 0, NULL);
        gl->BindBuffer(GLBK_GL_ELEMENT_ARRAY_BUFFER, s->indices[i].name);
    }
    gl->BindVertexArray(0);
    gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, 0);
}

UNUSED_OK void scene_free(gl_test *t, scene *s)
{
    size_t i;
    t->gl.gl.DeleteVertexArrays((int32_t)s->count, s->arrays);
    for (i = 0; i < s->count; i++) {
        glbk_buffer_destroy(&t->gl, &s->vertices[i]);
        glbk_buffer_destroy(&t->gl, &s->indices[i]);
    }
}

UNUSED_OK void scene_draw(void *user, glbk_context *ctx, glbk_rsm_renderer *r)
{
    const scene *s = (const scene *)user;
    size_t i;
    for (i = 0; i < s->count; i++) {
        const rsm_mesh *m = &s->meshes[i];
        glbk_rsm_surface surface = { { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 0, 0, 0 }, 0, NULL, 0 };
        if (m->transform) memcpy(surface.transform, m->transform, sizeof surface.transform);
        memcpy(surface.albedo, m->albedo, sizeof surface.albedo);
        surface.material = m->material;
        surface.albedo_map = s->albedo_map;
        assert_int_equal(glbk_rsm_object(ctx, r, &surface), GLBK_OK);
        ctx->gl.BindVertexArray(s->arrays[i]);
        ctx->gl.DrawElements(GLBK_GL_TRIANGLES, (int32_t)m->index_count, GLBK_GL_UNSIGNED_INT, NULL);
    }
}

#endif
