/* shadowfield_gl.c - the technique shadowfield on OpenGL: fields go up when they change; each frame all points to
   shade, vertices and pixels of flat receivers alike, become pixels of a G-buffer, which gl_backend.h shades. */
#include "shadowfield_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 512, ROWS = 8, BLOCK = WIDTH * ROWS };

struct sf_gl {
    glbk_context         *gl;
    const sfield_field  **fields;               /* those that went up, and what they are called there */
    glbk_sfield_field    *uploaded;
    size_t                field_count;
    glbk_sfield_world     world;
    glbk_sfield_renderer  renderer;
    glbk_sfield_entity   *entities;
    sfield_rotation      *rotations;
    sfield_algebra       *algebra;
    uint32_t             *terms;                /* of the product */
    float                *factors;
    uint32_t              bands;
    int                   gloss;
    float                *light, *shine;        /* rgba */
};

static int gl_failed(const sf_gl *g, const char *what, glbk_result result, char *error)
{
    snprintf(error, EX_ERROR_SIZE, "shadowfield on GL: %s: %s %.120s", what, glbk_result_text(result), g->gl->log);
    return -1;
}

static int out_of_memory(char *error)
{
    snprintf(error, EX_ERROR_SIZE, "shadowfield: out of memory");
    return -1;
}

static const glbk_sfield_field *find_field(const sf_gl *g, const sfield_field *field)
{
    for (size_t i = 0; i < g->field_count; i++)
        if (field && g->fields[i] == field)
            return &g->uploaded[i];
    return NULL;
}

/* Files in memory, the terms of the product, and up with them. */
static int upload(sf_gl *g, size_t entity_count, float reach, char *error)
{
    size_t terms = sfield_sh_terms(g->algebra, NULL, NULL);
    glbk_sfield_file *files = calloc(g->field_count + 1, sizeof *files);
    void **data = calloc(g->field_count + 1, sizeof *data);
    uint32_t *term = g->terms = malloc((terms + 1) * sizeof *term);
    float *factor = g->factors = malloc((terms + 1) * sizeof *factor);
    glbk_sfield_desc d;
    int failed = !files || !data || !term || !factor;
    memset(&d, 0, sizeof d);
    for (size_t i = 0; i < g->field_count && !failed; i++) {
        files[i].size = sfield_size(g->fields[i]);
        files[i].data = data[i] = malloc(files[i].size);
        failed = !data[i] || sfield_write(g->fields[i], data[i], files[i].size) != SFIELD_OK;
    }
    if (failed) {
        out_of_memory(error);
    } else {
        glbk_result r;
        d.bands = g->bands;
        d.files = files;
        d.file_count = (uint32_t)g->field_count;
        d.terms = term;
        d.factors = factor;
        d.term_count = (uint32_t)sfield_sh_terms(g->algebra, term, factor);
        d.capacity = (uint32_t)entity_count;
        d.reach = reach;
        r = glbk_sfield_create(g->gl, &d, g->uploaded, &g->world);
        failed = r != GLBK_OK ? gl_failed(g, "fields", r, error) : 0;
    }
    for (size_t i = 0; data && i < g->field_count; i++)
        free(data[i]);
    free(data);
    free(files);
    return failed ? -1 : 0;
}

static void drop_fields(sf_gl *g)
{
    glbk_sfield_destroy(g->gl, &g->world);
    free((void *)(size_t)g->fields);
    free(g->uploaded);
    free(g->terms);
    free(g->factors);
    g->fields = NULL;
    g->uploaded = NULL;
    g->terms = NULL;
    g->factors = NULL;
    g->field_count = 0;
}

int sf_gl_fields(sf_gl *g, const rd_job *job, const sfield_field *const *fields, size_t field_count,
                 size_t entity_count, char *error)
{
    drop_fields(g);
    g->fields = calloc(field_count + 1, sizeof *g->fields);
    g->uploaded = calloc(field_count + 1, sizeof *g->uploaded);
    if (!g->fields || !g->uploaded)
        return out_of_memory(error);
    for (size_t i = 0; i < field_count; i++)
        if (fields[i])
            g->fields[g->field_count++] = fields[i];
    return upload(g, entity_count, (float)rd_setting_number(job->settings, "reach"), error);
}

sf_gl *sf_gl_open(const rd_job *job, const sfield_field *const *fields, size_t field_count, size_t entity_count,
                  int gloss, char *error)
{
    sf_gl *g = calloc(1, sizeof *g);
    if (!g) {
        out_of_memory(error);
        return NULL;
    }
    g->gl = job->gl;
    g->bands = (uint32_t)rd_setting_integer(job->settings, "bands");
    g->gloss = gloss;
    g->entities = calloc(entity_count, sizeof *g->entities);
    g->rotations = calloc(entity_count, sizeof *g->rotations);
    if (!g->entities || !g->rotations || sfield_algebra_create(g->bands, NULL, &g->algebra) != SFIELD_OK)
        out_of_memory(error);
    else if (sf_gl_fields(g, job, fields, field_count, entity_count, error) == 0)
        return g;
    sf_gl_close(g);
    return NULL;
}

static int place(sf_gl *g, const sfield_scene *scene, const sfield_entity *entities, size_t count, char *error)
{
    float sky[3 * SFIELD_MAX_COEFS];
    glbk_result r;
    for (size_t i = 0; i < count; i++) {
        glbk_sfield_entity *e = &g->entities[i];
        e->occlusion = find_field(g, entities[i].occlusion);
        e->source = find_field(g, entities[i].source);
        memcpy(e->transform, entities[i].transform, sizeof e->transform);
        memcpy(e->tint, entities[i].tint, sizeof e->tint);
        e->time = entities[i].time;
        e->rotation = NULL;
        if (sfield_sh_rotation(g->algebra, e->transform, &g->rotations[i]) == SFIELD_OK && !g->rotations[i].identity)
            e->rotation = g->rotations[i].block;
    }
    r = glbk_sfield_place(g->gl, &g->world, g->entities, (uint32_t)count);
    if (r == GLBK_OK && sfield_scene_sky(scene, sky) == SFIELD_OK)
        r = glbk_sfield_sky(g->gl, &g->world, sky);
    return r == GLBK_OK ? 0 : gl_failed(g, "entities", r, error);
}

/* Room for so many points. */
static int make_room(sf_gl *g, size_t points, char *error)
{
    glbk_sfield_renderer_desc d;
    glbk_result r;
    memset(&d, 0, sizeof d);
    d.width = WIDTH;
    d.height = (uint32_t)((points + BLOCK - 1) / BLOCK * ROWS);
    d.bands = g->bands;
    d.gloss = g->gloss;
    d.terms = g->terms;
    d.factors = g->factors;
    d.term_count = (uint32_t)sfield_sh_terms(g->algebra, NULL, NULL);
    if (d.height <= g->renderer.height)
        return 0;
    glbk_sfield_renderer_destroy(g->gl, &g->renderer);
    r = glbk_sfield_renderer_create(g->gl, &d, &g->renderer);
    free(g->light);
    free(g->shine);
    g->light = malloc(4 * WIDTH * (size_t)d.height * sizeof *g->light);
    g->shine = malloc(4 * WIDTH * (size_t)d.height * sizeof *g->shine);
    if (!g->light || !g->shine)
        return out_of_memory(error);
    return r == GLBK_OK ? 0 : gl_failed(g, "renderer", r, error);
}

/* Point i of a set, in the world. */
static void describe(const sfield_points *set, size_t i, const sfield_entity *entities, float *self,
                     glbk_sfield_pixel *out)
{
    static const float none[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    const float *m = set->entity == SFIELD_NONE ? none : entities[set->entity].transform;
    const float *p = set->positions + 3 * i, *n = set->normals + 3 * i;
    float scale = sqrtf(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
    memset(out, 0, sizeof *out);
    for (int k = 0; k < 3; k++) {
        out->position[k] = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
        out->normal[k] = (m[k] * n[0] + m[4 + k] * n[1] + m[8 + k] * n[2]) / scale;
    }
    out->entity = set->entity;
    out->exponent = set->exponents ? set->exponents[i] : 0;
    if (set->self && sfield_self(set->self, i, 1, self) == SFIELD_OK)
        out->self = self;
}

/* Where point i stands: 64 in a row fill 8 x 8 pixels, which the compute path treats together. */
static size_t pixel_of(size_t i)
{
    return i / BLOCK * BLOCK + i / 8 % ROWS * WIDTH + i % BLOCK / 64 * 8 + i % 8;
}

static int upload_points(sf_gl *g, const sfield_entity *entities, const sfield_points *sets, size_t count, char *error)
{
    glbk_sfield_pixel *block = calloc(BLOCK, sizeof *block);
    float *self = malloc(BLOCK * SFIELD_MAX_COEFS * sizeof *self);
    glbk_result r = GLBK_OK;
    size_t at = 0;
    for (size_t s = 0; block && self && s < count; s++)
        for (size_t i = 0; i < sets[s].count && r == GLBK_OK; i++) {
            size_t pixel = pixel_of(at++ % BLOCK);
            describe(&sets[s], i, entities, self + pixel * SFIELD_MAX_COEFS, &block[pixel]);
            if (at % BLOCK == 0)
                r = glbk_sfield_upload(g->gl, &g->renderer, (uint32_t)(at / BLOCK - 1) * ROWS, ROWS, block);
        }
    for (; block && self && r == GLBK_OK && at < (size_t)WIDTH * g->renderer.height; ) {       /* nothing in the rest */
        memset(&block[pixel_of(at++ % BLOCK)], 0, sizeof *block);
        if (at % BLOCK == 0)
            r = glbk_sfield_upload(g->gl, &g->renderer, (uint32_t)(at / BLOCK - 1) * ROWS, ROWS, block);
    }
    free(block);
    free(self);
    if (!block || !self)
        return out_of_memory(error);
    return r == GLBK_OK ? 0 : gl_failed(g, "points", r, error);
}

int sf_gl_shade(sf_gl *g, const rd_job *job, const sfield_scene *scene, const sfield_entity *entities,
                size_t entity_count, const sfield_points *sets, size_t set_count, char *error)
{
    size_t points = 0, at = 0;
    glbk_result r;
    for (size_t s = 0; s < set_count; s++)
        points += sets[s].count;
    if (place(g, scene, entities, entity_count, error) != 0 || make_room(g, points ? points : 1, error) != 0 ||
        upload_points(g, entities, sets, set_count, error) != 0)
        return -1;
    r = glbk_sfield_shade(g->gl, &g->renderer, &g->world, job->scene->camera.eye, 0);
    if (r == GLBK_OK)
        r = glbk_sfield_read(g->gl, &g->renderer, g->light, g->gloss ? g->shine : NULL);
    if (r != GLBK_OK)
        return gl_failed(g, "shading", r, error);
    for (size_t s = 0; s < set_count; s++)
        for (size_t i = 0; i < sets[s].count; i++, at++) {
            memcpy(sets[s].rgb + 3 * i, g->light + 4 * pixel_of(at), 3 * sizeof(float));
            if (g->gloss)
                memcpy(sets[s].gloss + 3 * i, g->shine + 4 * pixel_of(at), 3 * sizeof(float));
        }
    return 0;
}

void sf_gl_close(sf_gl *g)
{
    if (!g)
        return;
    glbk_sfield_renderer_destroy(g->gl, &g->renderer);
    drop_fields(g);
    sfield_algebra_free(g->algebra);
    free(g->entities);
    free(g->rotations);
    free(g->light);
    free(g->shine);
    free(g);
}
