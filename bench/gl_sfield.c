/* gl_sfield.c - shadow fields on OpenGL: 30,000 points of a chess board under 32 pieces and four lamps, with the
   product written into the program and read from the table, on the core path and,
   where the context has 4.3, on the compute path; time of a frame, and how far the light is from
   shadowfield.h's; 1,024 of the points in wavelets. Wall time round glFinish: timer queries of software drivers
   are wrong. */
#define _POSIX_C_SOURCE 200809L
#include "sfield_scene.h"
#include "gl.h"
#include "gl_backend/gl_wavelets.h"
#include "sfield_gpu.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* An entity of no fields that stands at the origin, not tinted. */
static const sfield_entity upright = { NULL, NULL, { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }, { 1, 1, 1 }, 0 };

enum {
    PIECES = 32,
    LAMPS = 4,
    ENTITIES = PIECES + LAMPS,
    MESHES = 6,
    FIELDS = MESHES + 1,
    FRAMES = 5,
    WIDTH = 256,
    BLOCK = 8 * WIDTH,
    BANDS = 4
};

typedef struct board {
    ex_scene          scene;
    bn_points         points;
    sfield_field     *field[FIELDS];    /* the last shines */
    sfield_algebra   *algebra;
    sfield_scene     *cpu;
    sfield_entity     entity[ENTITIES];
    float            *rgb, *light;
    double            cpu_ms;
    glbk_sfield_scene gl;
} board;

static int build(board *b, const bn_options *options)
{
    sfield_desc d = bn_sfield_desc(options);
    sfield_emitter lamp;
    memset(&lamp, 0, sizeof lamp);
    lamp.radius = 0.03f;
    lamp.radiance[0] = lamp.radiance[1] = lamp.radiance[2] = 50;
    d.shell_count = 8;
    d.position_side = 4;
    for (uint32_t i = 0; i < MESHES; i++) {
        const ex_mesh *mesh = &b->scene.meshes[1 + i];
        const sfield_mesh m = { mesh->positions, mesh->vertex_count, 0, mesh->indices,
                                3 * (size_t)mesh->triangle_count, NULL, NULL, NULL };
        if (sfield_build(&d, &m, &b->field[i], NULL) != SFIELD_OK)
            return -1;
    }
    if (sfield_build_emitter(&d, &lamp, &b->field[MESHES], NULL) != SFIELD_OK ||
        sfield_algebra_create(BANDS, NULL, &b->algebra) != SFIELD_OK ||
        bn_points_spread(&b->points, &b->scene.meshes[0], 30000) != 0)
        return -1;
    b->rgb = malloc(3 * b->points.count * sizeof *b->rgb);
    b->light = malloc(4 * (b->points.count + BLOCK) * sizeof *b->light);
    if (!b->rgb || !b->light)
        return -1;
    return 0;
}

/* The same frame by shadowfield.h. */
static int shade_cpu(board *b, const bn_options *options)
{
    sfield_scene_desc d;
    sfield_points set;
    double start;
    memset(&d, 0, sizeof d);
    memset(&set, 0, sizeof set);
    d.system.parallel_for = ex_pool_run;
    d.system.user = options->pool;
    for (int i = 0; i < ENTITIES; i++) {
        sfield_entity *e = &b->entity[i];
        *e = upright;
        if (i < PIECES) {
            e->occlusion = b->field[b->scene.objects[1 + i].mesh - 1];
            memcpy(e->transform, b->scene.objects[1 + i].transform, sizeof e->transform);
        } else {
            e->source = b->field[MESHES];
            e->transform[12] = 0.26f * cosf(1.6f * (float)i);
            e->transform[13] = 0.25f;
            e->transform[14] = 0.26f * sinf(1.6f * (float)i);
        }
    }
    set.count = b->points.count;
    set.positions = b->points.positions;
    set.normals = b->points.normals;
    set.entity = 0;
    set.rgb = b->rgb;
    if (sfield_scene_create(&d, &b->cpu) != SFIELD_OK ||
        sfield_scene_entities(b->cpu, b->entity, ENTITIES) != SFIELD_OK ||
        sfield_shade(b->cpu, &set, 1, NULL) != SFIELD_OK)
        return -1;
    start = ex_seconds();
    if (sfield_shade(b->cpu, &set, 1, NULL) != SFIELD_OK)
        return -1;
    b->cpu_ms = 1000 * (ex_seconds() - start);
    return 0;
}

static glbk_result upload_fields(board *b, glbk_context *gl)
{
    const glbk_sfield_scene_desc d = { b->algebra, (const sfield_field *const *)b->field, FIELDS, ENTITIES, 0, NULL };
    return glbk_sfield_scene_create(gl, &d, &b->gl);
}

/* Where point i stands: 64 in a row fill 8 x 8 pixels, which the compute path treats together. */
static size_t pixel_of(size_t i)
{
    return i / BLOCK * BLOCK + i / 8 % 8 * WIDTH + i % BLOCK / 64 * 8 + i % 8;
}

static glbk_result upload_points(const board *b, glbk_context *gl, glbk_gbuffer *g)
{
    glbk_pixel *pixels = calloc((size_t)WIDTH * g->height, sizeof *pixels);
    glbk_result result = GLBK_ERR_ALLOC;
    for (size_t i = 0; pixels && i < b->points.count; i++) {
        glbk_pixel *p = &pixels[pixel_of(i)];
        memcpy(p->position, b->points.positions + 3 * i, sizeof p->position);
        memcpy(p->normal, b->points.normals + 3 * i, sizeof p->normal);
    }
    if (pixels)
        result = glbk_gbuffer_upload(gl, g, 0, g->height, pixels);
    free(pixels);
    return result;
}

static glbk_result measure(board *b, const bn_options *options, glbk_context *gl, int unrolled)
{
    glbk_gbuffer g;
    glbk_gbuffer_desc of;
    glbk_sfield_renderer r;
    glbk_sfield_renderer_desc d;
    bn_error error = { 0, 0, 0 };
    double first = 0, best = HUGE_VAL, since;
    glbk_result result;
    memset(&d, 0, sizeof d);
    memset(&r, 0, sizeof r);
    memset(&of, 0, sizeof of);
    of.width = d.width = WIDTH;
    of.height = d.height = (uint32_t)((b->points.count + BLOCK - 1) / BLOCK * 8);
    d.algebra = b->algebra;
    d.product_in_table = !unrolled;
    result = glbk_gbuffer_create(gl, &of, &g);
    if (result == GLBK_OK)
        result = glbk_sfield_renderer_create(gl, &d, &r);
    if (result == GLBK_OK)
        result = upload_points(b, gl, &g);
    for (int frame = 0; result == GLBK_OK && bn_gl_goes_on(gl, frame, FRAMES, &since); frame++) {
        double start = ex_seconds();
        result = glbk_sfield_scene_entities(gl, &b->gl, b->entity, ENTITIES);
        if (result == GLBK_OK)
            result = glbk_sfield_shade(gl, &r, &g, &b->gl, NULL, 0);
        gl->gl.Finish();
        if (frame)
            best = fmin(best, ex_seconds() - start);
        else
            first = ex_seconds() - start;
    }
    if (result == GLBK_OK)
        result = glbk_sfield_read(gl, &r, b->light, NULL);
    for (size_t i = 0; i < b->points.count && result == GLBK_OK; i++)
        for (size_t k = 0; k < 3; k++)
            bn_error_add(&error, (double)b->light[4 * pixel_of(i) + k], (double)b->rgb[3 * i + k]);
    if (result == GLBK_OK) {
        bn_begin(options, "gl_sfield", options->threads, bn_sfield_simd());
        bn_text("gl_renderer", gl->renderer);
        bn_text("path", gl->compute ? "compute" : "core");
        bn_integer("points", b->points.count);
        bn_integer("entities", PIECES);
        bn_integer("lights", LAMPS);
        bn_text("product", unrolled ? "program" : "table");
        bn_number("first_ms", 1000 * first);
        bn_number("frame_ms", 1000 * best);
        bn_number("cpu_ms", b->cpu_ms);
        bn_number("rmse_vs_cpu", bn_error_relative(&error));
        bn_end(options);
    }
    glbk_sfield_renderer_free(gl, &r);
    glbk_gbuffer_free(gl, &g);
    return result;
}

/* ---- wavelets ---- */

enum { SOME = 1024, ROW = 32 };     /* points, and those of a row */

typedef struct wavelets {
    sfield_field     *field[FIELDS];
    sfield_entity     entity[ENTITIES];
    sfield_scene     *cpu;
    glbk_sfield_scene gl;
    glbk_gbuffer      gbuffer;
    glbk_sfield_haar  haar;
    float             rgb[3 * SOME], light[4 * SOME];
    double            cpu_ms, frame_ms;
} wavelets;

static sfield_result build_wavelets(wavelets *w, const board *b, const bn_options *options)
{
    sfield_desc d = bn_sfield_desc(options);
    sfield_emitter lamp;
    sfield_result result = SFIELD_OK;
    memset(&lamp, 0, sizeof lamp);
    lamp.radius = 0.03f;
    lamp.radiance[0] = lamp.radiance[1] = lamp.radiance[2] = 50;
    d.basis = SFIELD_BASIS_HAAR;
    d.cube_side = 16;
    d.shell_count = 8;
    d.position_side = 4;
    d.keep = 0.04f;
    for (uint32_t i = 0; i < MESHES && result == SFIELD_OK; i++) {
        const ex_mesh *mesh = &b->scene.meshes[1 + i];
        const sfield_mesh m = { mesh->positions, mesh->vertex_count, 0, mesh->indices,
                                3 * (size_t)mesh->triangle_count, NULL, NULL, NULL };
        result = sfield_build(&d, &m, &w->field[i], NULL);
    }
    if (result == SFIELD_OK)
        result = sfield_build_emitter(&d, &lamp, &w->field[MESHES], NULL);
    for (int i = 0; i < ENTITIES; i++) {
        sfield_entity *e = &w->entity[i];
        *e = b->entity[i];
        if (e->source)
            e->source = w->field[MESHES];
        else
            e->occlusion = w->field[b->scene.objects[1 + i].mesh - 1];
    }
    return result;
}

static sfield_result shade_wavelets_cpu(wavelets *w, const board *b, const bn_options *options)
{
    sfield_scene_desc d;
    sfield_points set;
    sfield_result result;
    double start = 0;
    memset(&d, 0, sizeof d);
    memset(&set, 0, sizeof set);
    d.basis = SFIELD_BASIS_HAAR;
    d.cube_side = 16;
    d.system.parallel_for = ex_pool_run;
    d.system.user = options->pool;
    set.count = SOME;
    set.positions = b->points.positions;
    set.normals = b->points.normals;
    set.rgb = w->rgb;
    result = sfield_scene_create(&d, &w->cpu);
    if (result == SFIELD_OK)
        result = sfield_scene_entities(w->cpu, w->entity, ENTITIES);
    for (int i = 0; i < 2 && result == SFIELD_OK; i++) {
        start = ex_seconds();
        result = sfield_shade(w->cpu, &set, 1, NULL);
    }
    w->cpu_ms = 1000 * (ex_seconds() - start);
    return result;
}

static glbk_result shade_wavelets_gl(wavelets *w, const board *b, glbk_context *gl)
{
    const glbk_sfield_haar_scene_desc sd = { (const sfield_field *const *)w->field, FIELDS, 16, ENTITIES, 0 };
    const glbk_sfield_haar_desc hd = { ROW, SOME / ROW, 16, 0, 0, 0 };
    glbk_pixel *pixels = calloc(SOME, sizeof *pixels);
    glbk_gbuffer_desc of;
    glbk_result result = pixels ? GLBK_OK : GLBK_ERR_ALLOC;
    double start = 0;
    memset(&of, 0, sizeof of);
    of.width = ROW;
    of.height = SOME / ROW;
    for (size_t i = 0; pixels && i < SOME; i++) {
        memcpy(pixels[i].position, b->points.positions + 3 * i, sizeof pixels[i].position);
        memcpy(pixels[i].normal, b->points.normals + 3 * i, sizeof pixels[i].normal);
    }
    if (result == GLBK_OK)
        result = glbk_sfield_haar_upload(gl, &sd, &w->gl);
    if (result == GLBK_OK)
        result = glbk_sfield_scene_entities(gl, &w->gl, w->entity, ENTITIES);
    if (result == GLBK_OK)
        result = glbk_gbuffer_create(gl, &of, &w->gbuffer);
    if (result == GLBK_OK)
        result = glbk_gbuffer_upload(gl, &w->gbuffer, 0, of.height, pixels);
    if (result == GLBK_OK)
        result = glbk_sfield_haar_create(gl, &hd, &w->haar);
    for (int i = 0; i < 2 && result == GLBK_OK; i++) {
        start = ex_seconds();
        result = glbk_sfield_haar_shade(gl, &w->haar, &w->gbuffer, &w->gl, NULL, 0);
        gl->gl.Finish();
    }
    w->frame_ms = 1000 * (ex_seconds() - start);
    if (result == GLBK_OK)
        result = glbk_target_read(gl, &w->haar.target, 0, 0, 0, ROW, SOME / ROW, w->light);
    free(pixels);
    return result;
}

/* Both sides of wavelets: 16 texels a side, 4 % kept. */
static int measure_wavelets(const board *b, const bn_options *options, glbk_context *gl)
{
    wavelets *w = calloc(1, sizeof *w);
    sfield_result built = w ? build_wavelets(w, b, options) : SFIELD_ERR_ALLOC;
    glbk_result result = GLBK_OK;
    bn_error error = { 0, 0, 0 };
    if (built == SFIELD_OK)
        built = shade_wavelets_cpu(w, b, options);
    if (built == SFIELD_OK)
        result = shade_wavelets_gl(w, b, gl);
    if (built == SFIELD_OK && result == GLBK_OK) {
        for (size_t i = 0; i < 3 * SOME; i++)
            bn_error_add(&error, (double)w->light[4 * (i / 3) + i % 3], (double)w->rgb[i]);
        bn_begin(options, "gl_sfield", options->threads, bn_sfield_simd());
        bn_text("gl_renderer", gl->renderer);
        bn_text("path", w->haar.compute ? "compute" : "core");
        bn_text("op", "wavelets");
        bn_integer("points", SOME);
        bn_integer("entities", PIECES);
        bn_integer("lights", LAMPS);
        bn_integer("texels", w->gl.texels);
        bn_number("frame_ms", w->frame_ms);
        bn_number("cpu_ms", w->cpu_ms);
        bn_number("rmse_vs_cpu", bn_error_relative(&error));
        bn_end(options);
    }
    if (w) {
        glbk_sfield_haar_free(gl, &w->haar);
        glbk_gbuffer_free(gl, &w->gbuffer);
        glbk_sfield_scene_free(gl, &w->gl);
        sfield_scene_free(w->cpu);
        for (int i = 0; i < FIELDS; i++)
            sfield_free(w->field[i]);
    }
    free(w);
    if (built != SFIELD_OK)
        return bn_failed("gl_sfield, wavelets", sfield_result_text(built));
    return result == GLBK_OK ? 0 : bn_gl_failed(result);
}

/* The field of a bishop by the processor and by the GPU. */
static sfield_result measure_build(const board *b, const bn_options *options, glbk_context *gl)
{
    const ex_mesh *mesh = &b->scene.meshes[4];
    const sfield_mesh m = { mesh->positions, mesh->vertex_count, 0, mesh->indices,
                           3 * (size_t)mesh->triangle_count, NULL, NULL, NULL };
    sfield_desc d = bn_sfield_desc(options);
    double ms[2] = { 0, 0 };
    sfield_result result = SFIELD_OK;
    sfield_info info;
    if (!options->full)
        d.position_side = 8;
    for (int gpu = 0; gpu < 2 && result == SFIELD_OK; gpu++) {
        ex_sfield_gpu g = { gl, GLBK_OK };
        sfield_field *f;
        double start = ex_seconds();
        result = gpu ? ex_sfield_build(&g, &d, &m, NULL, &f, NULL) : sfield_build(&d, &m, &f, NULL);
        ms[gpu] = 1000 * (ex_seconds() - start);
        if (result == SFIELD_OK) {
            sfield_get_info(f, &info);
            sfield_free(f);
        }
    }
    if (result != SFIELD_OK)
        return result;
    bn_begin(options, "gl_sfield", options->threads, bn_sfield_simd());
    bn_text("gl_renderer", gl->renderer);
    bn_text("path", gl->compute ? "compute" : "core");
    bn_text("op", "build");
    bn_integer("triangles", mesh->triangle_count);
    bn_integer("views", info.sample_count);
    bn_number("build_ms", ms[1]);
    bn_number("cpu_ms", ms[0]);
    bn_end(options);
    return SFIELD_OK;
}

static int run(board *b, const bn_options *options, int core_only)
{
    bn_gl g;
    glbk_result result;
    sfield_result built = SFIELD_OK;
    if (bn_gl_open(&g, core_only) != 0)
        return -1;
    if (!core_only && !g.gl.compute) {
        bn_gl_close(&g);
        return 0;
    }
    result = upload_fields(b, &g.gl);
    for (int unrolled = 1; unrolled >= 0 && result == GLBK_OK; unrolled--)
        result = measure(b, options, &g.gl, unrolled);
    if (result == GLBK_OK)
        built = measure_build(b, options, &g.gl);
    if (result != GLBK_OK)
        bn_gl_failed(result);
    else if (built != SFIELD_OK)
        bn_failed("gl_sfield", sfield_result_text(built));
    glbk_sfield_scene_free(&g.gl, &b->gl);
    if (result == GLBK_OK && built == SFIELD_OK && measure_wavelets(b, options, &g.gl) != 0)
        result = GLBK_ERR_GL;
    bn_gl_close(&g);
    return result == GLBK_OK && built == SFIELD_OK ? 0 : -1;
}

int bn_gl_sfield(const bn_options *options)
{
    board b;
    char error[EX_ERROR_SIZE];
    int result;
    memset(&b, 0, sizeof b);
    if (ex_scene_builtin(&b.scene, "chess", 1, error) != 0)
        return bn_failed("chess", error);
    result = build(&b, options) == 0 && shade_cpu(&b, options) == 0 ? 0 : bn_failed("gl_sfield", "out of memory");
    for (int core_only = 1; core_only >= 0 && result == 0; core_only--)
        result = run(&b, options, core_only);
    sfield_scene_free(b.cpu);
    for (int i = 0; i < FIELDS; i++)
        sfield_free(b.field[i]);
    sfield_algebra_free(b.algebra);
    bn_points_free(&b.points);
    ex_scene_free(&b.scene);
    free(b.rgb);
    free(b.light);
    return result;
}
