/* gl_util.h - what the tests of glbk_rsm that know rsm.h share: its descs and meshes on the GPU. Include rsm.h,
   gl_backend/gl_rsm.h, gl_test.h and rsm/util.h before. */
#ifndef RSM_GL_H
#define RSM_GL_H

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
    const uint32_t n = glbk_rsm_point_count(d);
    const rsm_pattern pattern = d->pattern == RSM_PATTERN_MIXED ? RSM_PATTERN_LOG_RADIAL : d->pattern;
    assert_glbk(t, glbk_rsm_tables_upload(&t->gl, r, d, n ? pattern_of(pattern, n, d) : NULL));
}

/* A G-buffer of that size. */
UNUSED_OK glbk_gbuffer gbuffer_of(gl_test *t, uint32_t width, uint32_t height)
{
    glbk_gbuffer seen;
    glbk_gbuffer_desc d;
    memset(&d, 0, sizeof d);
    d.width = width;
    d.height = height;
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &d, &seen));
    return seen;
}

/* Meshes without strides, drawn by scene_draw into maps. */
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
        glbk_buffer_free(&t->gl, &s->vertices[i]);
        glbk_buffer_free(&t->gl, &s->indices[i]);
    }
}

UNUSED_OK void scene_draw(void *user, glbk_context *ctx, glbk_rsm_renderer *r)
{
    const scene *s = (const scene *)user;
    size_t i;
    for (i = 0; i < s->count; i++) {
        const rsm_mesh *m = &s->meshes[i];
        glbk_surface surface;
        memset(&surface, 0, sizeof surface);
        if (m->transform) memcpy(surface.transform, m->transform, sizeof surface.transform);
        memcpy(surface.material.diffuse, m->albedo, sizeof surface.material.diffuse);
        surface.color_map = s->albedo_map;
        assert_int_equal(glbk_rsm_object(ctx, r, &surface, m->material), GLBK_OK);
        ctx->gl.BindVertexArray(s->arrays[i]);
        ctx->gl.DrawElements(GLBK_GL_TRIANGLES, (int32_t)m->index_count, GLBK_GL_UNSIGNED_INT, NULL);
    }
}

#endif
