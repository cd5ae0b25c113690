/* shadowfield_gl.c - the technique shadowfield on OpenGL: fields go up when they change; each frame all points to
   shade, vertices and pixels of flat receivers alike, become pixels of a G-buffer, which gl_shadowfield.h shades. */
#include "shadowfield_parts.h"
#include "../../gl_backend/gl_wavelets.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 512, ROWS = 8, BLOCK = WIDTH * ROWS };

struct sf_gl {
    glbk_context         *gl;
    sfield_algebra       *algebra;
    glbk_sfield_scene     scene;
    glbk_gbuffer          gbuffer;
    glbk_sfield_renderer  renderer;             /* of harmonics */
    glbk_sfield_haar      haar;                 /* of wavelets */
    int                   wavelets;
    uint32_t              height;               /* of the G-buffer and of either renderer */
    sf_gloss              gloss;
    float                *light, *shine, *graze;        /* rgba */
    float                *brdf;                 /* of glTF's BRDF: what the scene is given */
};

static int gl_failed(const char *what, glbk_result result, char *error)
{
    snprintf(error, EX_ERROR_SIZE, "shadowfield on GL: %s: %s", what, glbk_result_text(result));
    return -1;
}

static int out_of_memory(char *error)
{
    snprintf(error, EX_ERROR_SIZE, "shadowfield: out of memory");
    return -1;
}

/* Makes the scene of fields of either basis. */
static glbk_result make_scene(sf_gl *g, uint32_t cube_side, const glbk_sfield_scene_desc *d)
{
    glbk_sfield_haar_scene_desc h;
    if (!g->wavelets)
        return glbk_sfield_scene_create(g->gl, d, &g->scene);
    memset(&h, 0, sizeof h);
    h.fields = d->fields;
    h.field_count = d->field_count;
    h.cube_side = cube_side;
    h.entity_capacity = d->entity_capacity;
    h.reach = d->reach;
    return glbk_sfield_haar_upload(g->gl, &h, &g->scene);
}

int sf_gl_fields(sf_gl *g, const rd_job *job, const sfield_field *const *fields, size_t field_count,
                 size_t entity_count, char *error)
{
    const sfield_field **there = malloc((field_count + 1) * sizeof *there);
    glbk_sfield_scene_desc d;
    glbk_result r = GLBK_ERR_ALLOC;
    glbk_sfield_scene_free(g->gl, &g->scene);
    memset(&d, 0, sizeof d);
    d.algebra = g->algebra;
    d.brdf = g->brdf;
    d.fields = there;
    d.entity_capacity = (uint32_t)entity_count;
    d.reach = (float)rd_setting_number(job->settings, "reach");
    for (size_t i = 0; there && i < field_count; i++)
        if (fields[i])
            there[d.field_count++] = fields[i];
    if (there)
        r = make_scene(g, (uint32_t)rd_setting_integer(job->settings, "cube_side"), &d);
    free((void *)(size_t)there);
    return r == GLBK_OK ? 0 : gl_failed("fields", r, error);
}

/* The table of glTF's BRDF. Returns whether there was memory. */
static int make_brdf(sf_gl *g, const rd_job *job)
{
    const uint32_t bands = (uint32_t)rd_setting_integer(job->settings, "bands");
    sfield_system system;
    memset(&system, 0, sizeof system);
    system.parallel_for = ex_pool_run;
    system.user = job->pool;
    g->brdf = malloc(sfield_sh_brdf(bands, NULL, NULL) * sizeof *g->brdf);
    return g->brdf && sfield_sh_brdf(bands, &system, g->brdf) > 0;
}

sf_gl *sf_gl_open(const rd_job *job, const sfield_field *const *fields, size_t field_count, size_t entity_count,
                  sf_gloss gloss, char *error)
{
    sf_gl *g = calloc(1, sizeof *g);
    if (!g) {
        out_of_memory(error);
        return NULL;
    }
    g->gl = job->gl;
    g->gloss = gloss;
    g->wavelets = rd_setting_is(job->settings, "basis", "haar");
    if (sfield_algebra_create((uint32_t)rd_setting_integer(job->settings, "bands"), NULL, &g->algebra) != SFIELD_OK ||
        (gloss == SF_GLTF && !make_brdf(g, job)))
        out_of_memory(error);
    else if (sf_gl_fields(g, job, fields, field_count, entity_count, error) == 0)
        return g;
    sf_gl_close(g);
    return NULL;
}

static int place(sf_gl *g, const sfield_scene *scene, const sfield_entity *entities, size_t count, char *error)
{
    const size_t side = g->scene.cube_side, numbers = side ? 18 * side * side : 3 * SFIELD_MAX_COEFS;
    float *sky = malloc(numbers * sizeof *sky);
    glbk_result r = sky ? glbk_sfield_scene_entities(g->gl, &g->scene, entities, count) : GLBK_ERR_ALLOC;
    if (r == GLBK_OK && sfield_scene_sky(scene, sky) == SFIELD_OK)
        r = side ? glbk_sfield_haar_sky(g->gl, &g->scene, sky) : glbk_sfield_scene_sky(g->gl, &g->scene, sky);
    free(sky);
    return r == GLBK_OK ? 0 : gl_failed("entities", r, error);
}

static glbk_result make_haar(sf_gl *g, uint32_t width, uint32_t height)
{
    glbk_sfield_haar_desc d;
    memset(&d, 0, sizeof d);
    d.width = width;
    d.height = height;
    d.cube_side = g->scene.cube_side;
    d.self = 1;
    d.gloss = g->gloss != SF_DULL;
    return glbk_sfield_haar_create(g->gl, &d, &g->haar);
}

/* Room for so many points. */
static int make_room(sf_gl *g, const rd_job *job, size_t points, char *error)
{
    glbk_sfield_renderer_desc d;
    glbk_gbuffer_desc of;
    glbk_result r;
    memset(&d, 0, sizeof d);
    memset(&of, 0, sizeof of);
    of.width = d.width = WIDTH;
    of.height = d.height = (uint32_t)((points + BLOCK - 1) / BLOCK * ROWS);
    d.algebra = g->algebra;
    d.gloss = g->gloss == SF_PHONG;
    d.materials = d.grazing = g->gloss == SF_GLTF;
    d.self = 1;
    d.logarithms = rd_setting_is(job->settings, "product", "exp");
    if (d.height <= g->height)
        return 0;
    glbk_sfield_renderer_free(g->gl, &g->renderer);
    glbk_sfield_haar_free(g->gl, &g->haar);
    glbk_gbuffer_free(g->gl, &g->gbuffer);
    r = glbk_gbuffer_create(g->gl, &of, &g->gbuffer);
    if (r == GLBK_OK)
        r = g->wavelets ? make_haar(g, d.width, d.height) : glbk_sfield_renderer_create(g->gl, &d, &g->renderer);
    g->height = r == GLBK_OK ? d.height : 0;
    free(g->light);
    free(g->shine);
    free(g->graze);
    g->light = malloc(4 * WIDTH * (size_t)d.height * sizeof *g->light);
    g->shine = malloc(4 * WIDTH * (size_t)d.height * sizeof *g->shine);
    g->graze = malloc(4 * WIDTH * (size_t)d.height * sizeof *g->graze);
    if (!g->light || !g->shine || !g->graze)
        return out_of_memory(error);
    return r == GLBK_OK ? 0 : gl_failed("renderer", r, error);
}

/* Point i of a set, in the world. Returns what its object hides of itself, in `self`, or NULL; without `self` nothing
   is asked. */
static const float *describe(const sfield_points *set, size_t i, const sfield_entity *entities, float *self,
                             glbk_pixel *out)
{
    static const float none[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    const float *m = set->entity ? entities[set->entity - 1].transform : none;
    const float *p = set->positions + 3 * i, *n = set->normals + 3 * i;
    float scale = sqrtf(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
    memset(out, 0, sizeof *out);
    for (int k = 0; k < 3; k++) {
        out->position[k] = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
        out->normal[k] = (m[k] * n[0] + m[4 + k] * n[1] + m[8 + k] * n[2]) / scale;
    }
    out->entity = set->entity;
    if (set->exponents && set->exponents[i] > 0) {
        out->material.kind = LSAMP_MATERIAL_PHONG;
        out->material.exponent = set->exponents[i];
    }
    if (set->materials) {
        const float *values = set->materials + i * set->material_stride / sizeof(float);
        out->material.kind = LSAMP_MATERIAL_METAL_ROUGH;
        memcpy(out->material.diffuse, values, sizeof out->material.diffuse);
        out->material.metallic = values[3];
        out->material.roughness = values[4];
    }
    return set->self && self && sfield_self(set->self, i, 1, self) == SFIELD_OK ? self : NULL;
}

/* Where point i stands: 64 in a row fill 8 x 8 pixels, which the compute path treats together. */
static size_t pixel_of(size_t i)
{
    return i / BLOCK * BLOCK + i / 8 % ROWS * WIDTH + i % BLOCK / 64 * 8 + i % 8;
}

/* Pixels of ROWS rows, and what hides each by its own object. */
typedef struct block {
    glbk_pixel      pixel[BLOCK];
    const float    *self[BLOCK];
    float           coefs[BLOCK][SFIELD_MAX_COEFS];
    glbk_sfield_own own[BLOCK];                         /* of wavelets, in place of self and coefs */
} block;

static glbk_result upload_block(sf_gl *g, const block *b, size_t number)
{
    const uint32_t row = (uint32_t)number * ROWS;
    glbk_result r = glbk_gbuffer_upload(g->gl, &g->gbuffer, row, ROWS, b->pixel);
    if (r != GLBK_OK)
        return r;
    return g->wavelets ? glbk_sfield_haar_self(g->gl, &g->haar, &g->scene, row, ROWS, b->own)
                       : glbk_sfield_self_upload(g->gl, &g->renderer, row, ROWS, b->self);
}

static int upload_points(sf_gl *g, const sfield_entity *entities, const sfield_points *sets, size_t count, char *error)
{
    block *b = calloc(1, sizeof *b);
    glbk_result r = b ? GLBK_OK : GLBK_ERR_ALLOC;
    size_t at = 0;
    for (size_t s = 0; s < count; s++)
        for (size_t i = 0; i < sets[s].count && r == GLBK_OK; i++) {
            size_t pixel = pixel_of(at++ % BLOCK);
            b->self[pixel] = describe(&sets[s], i, entities, g->wavelets ? NULL : b->coefs[pixel], &b->pixel[pixel]);
            b->own[pixel].self = sets[s].self;
            b->own[pixel].point = (uint32_t)i;
            if (at % BLOCK == 0)
                r = upload_block(g, b, at / BLOCK - 1);
        }
    for (; r == GLBK_OK && at < (size_t)WIDTH * g->height; ) {       /* nothing in the rest */
        size_t pixel = pixel_of(at++ % BLOCK);
        memset(&b->pixel[pixel], 0, sizeof b->pixel[pixel]);
        b->self[pixel] = NULL;
        b->own[pixel].self = NULL;
        if (at % BLOCK == 0)
            r = upload_block(g, b, at / BLOCK - 1);
    }
    free(b);
    return r == GLBK_OK ? 0 : gl_failed("points", r, error);
}

int sf_gl_shade(sf_gl *g, const rd_job *job, const sfield_scene *scene, const sfield_entity *entities,
                size_t entity_count, const sfield_points *sets, size_t set_count, char *error)
{
    size_t points = 0, at = 0;
    glbk_result r;
    for (size_t s = 0; s < set_count; s++)
        points += sets[s].count;
    if (place(g, scene, entities, entity_count, error) != 0 || make_room(g, job, points ? points : 1, error) != 0 ||
        upload_points(g, entities, sets, set_count, error) != 0)
        return -1;
    if (g->wavelets)
        r = glbk_sfield_haar_shade(g->gl, &g->haar, &g->gbuffer, &g->scene, job->scene->camera.eye, 0);
    else
        r = glbk_sfield_shade(g->gl, &g->renderer, &g->gbuffer, &g->scene, job->scene->camera.eye, 0);
    if (r == GLBK_OK)
        r = g->wavelets ? glbk_target_read(g->gl, &g->haar.target, 0, 0, 0, WIDTH, g->height, g->light)
                        : glbk_sfield_read(g->gl, &g->renderer, g->light, g->gloss ? g->shine : NULL);
    if (r == GLBK_OK && g->wavelets && g->gloss)
        r = glbk_target_read(g->gl, &g->haar.target, 1, 0, 0, WIDTH, g->height, g->shine);
    if (r == GLBK_OK && g->gloss == SF_GLTF)
        r = glbk_target_read(g->gl, &g->renderer.target, 2, 0, 0, WIDTH, g->renderer.height, g->graze);
    if (r != GLBK_OK)
        return gl_failed("shading", r, error);
    for (size_t s = 0; s < set_count; s++)
        for (size_t i = 0; i < sets[s].count; i++, at++) {
            memcpy(sets[s].rgb + 3 * i, g->light + 4 * pixel_of(at), 3 * sizeof(float));
            if (g->gloss)
                memcpy(sets[s].gloss + 3 * i, g->shine + 4 * pixel_of(at), 3 * sizeof(float));
            if (g->gloss == SF_GLTF && sets[s].grazing)
                memcpy(sets[s].grazing + 3 * i, g->graze + 4 * pixel_of(at), 3 * sizeof(float));
        }
    return 0;
}

void sf_gl_close(sf_gl *g)
{
    if (!g)
        return;
    glbk_sfield_renderer_free(g->gl, &g->renderer);
    glbk_sfield_haar_free(g->gl, &g->haar);
    glbk_gbuffer_free(g->gl, &g->gbuffer);
    glbk_sfield_scene_free(g->gl, &g->scene);
    sfield_algebra_free(g->algebra);
    free(g->light);
    free(g->shine);
    free(g->graze);
    free(g->brdf);
    free(g);
}
