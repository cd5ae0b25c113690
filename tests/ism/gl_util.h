/* gl_util.h - what the tests of gl_ism.h share: a G-buffer of arrays, the light of a renderer as ism_shade writes it.
   Include gl_ism.h, cmocka.h and gl_test.h before. */
#ifndef ISM_GL_UTIL_H
#define ISM_GL_UTIL_H

#include <stdlib.h>
#include <string.h>

/* Pixels with packed places, normals and, unless NULL, albedos. */
static inline void gl_see(glbk_context *gl, uint32_t width, uint32_t height, const float *places, const float *normals,
                          const float *albedos, glbk_gbuffer *out)
{
    const size_t count = (size_t)width * height;
    glbk_pixel *pixels = (glbk_pixel *)calloc(count, sizeof *pixels);
    glbk_gbuffer_desc desc;
    size_t i;
    assert_non_null(pixels);
    memset(&desc, 0, sizeof desc);
    desc.width = width;
    desc.height = height;
    for (i = 0; i < count; i++) {
        memcpy(pixels[i].position, places + 3 * i, 12);
        memcpy(pixels[i].normal, normals + 3 * i, 12);
        if (albedos) memcpy(pixels[i].material.diffuse, albedos + 3 * i, 12);
    }
    assert_int_equal(glbk_gbuffer_create(gl, &desc, out), GLBK_OK);
    assert_int_equal(glbk_gbuffer_upload(gl, out, 0, height, pixels), GLBK_OK);
    free(pixels);
}

/* Irradiances as ism_shade writes them, or times albedo / pi; the share that the rule near by took off. */
static inline void gl_light_of(glbk_context *gl, const glbk_ism_renderer *r, const float *albedos, float *light,
                               double *lost)
{
    const size_t count = (size_t)r->width * r->height;
    float *rgba = (float *)malloc(4 * count * sizeof *rgba);
    double off = 0, all = 0;
    size_t i, k;
    assert_non_null(rgba);
    assert_int_equal(glbk_ism_read(gl, r, rgba), GLBK_OK);
    for (i = 0; i < count; i++) {
        const float *e = rgba + 4 * i;
        off += (double)e[3];
        all += (double)(e[0] + e[1] + e[2]) / 3 + (double)e[3];
        for (k = 0; k < 3; k++) light[3 * i + k] = albedos ? e[k] * albedos[3 * i + k] * 0.318309886f : e[k];
    }
    if (lost) *lost = off / all;
    free(rgba);
}

/* The depths of all maps, side x side as ism_atlas has them. */
static inline glbk_result gl_read_atlas(glbk_context *gl, const glbk_ism_maps *m, float *depths)
{
    uint32_t *words = (uint32_t *)malloc(16 * (size_t)m->side * m->side);
    glbk_result result;
    size_t i;
    assert_non_null(words);
    result = glbk_target_read(gl, &m->atlas_target, 0, 0, 0, m->side, m->side, words);
    for (i = 0; i < (size_t)m->side * m->side && result == GLBK_OK; i++) memcpy(depths + i, words + 4 * i, 4);
    free(words);
    return result;
}

#endif
