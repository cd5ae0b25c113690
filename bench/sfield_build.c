/* sfield_build.c - how long fields take to build at the default size: of a sphere, a lamp, and a real model; occlusion
   and light of its triangles. Threads as bench was given; `cpu_seconds` is what all of them took together. Wavelets
   have 8 positions a side; with --full the default's 32. */
#include "sfield_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* A sphere of 9,800 triangles, counter-clockwise from outside: positions inside are moved out. */
enum { ROWS = 50, COLUMNS = 100 };

static int make_sphere(float **positions, uint32_t **indices, sfield_mesh *mesh)
{
    float *p = *positions = malloc(3 * (size_t)COLUMNS * (ROWS + 1) * sizeof *p);
    uint32_t *i = *indices = malloc(6 * (size_t)COLUMNS * ROWS * sizeof *i);
    if (!p || !i)
        return -1;
    for (uint32_t y = 0; y <= ROWS; y++)
        for (uint32_t x = 0; x < COLUMNS; x++) {
            const double t = 3.14159265358979 * y / ROWS, f = 6.28318530717959 * x / COLUMNS;
            const double s = y == 0 || y == ROWS ? 0 : sin(t);
            *p++ = (float)(s * cos(f));
            *p++ = (float)cos(t);
            *p++ = (float)(-s * sin(f));
        }
    for (uint32_t y = 0; y < ROWS; y++)
        for (uint32_t x = 0; x < COLUMNS; x++) {
            const uint32_t a = y * COLUMNS + x, b = y * COLUMNS + (x + 1) % COLUMNS;
            const uint32_t quad[6] = { a, a + COLUMNS, b, b, a + COLUMNS, b + COLUMNS };
            if (y > 0)
                for (int k = 0; k < 3; k++)
                    *i++ = quad[k];
            if (y < ROWS - 1)
                for (int k = 3; k < 6; k++)
                    *i++ = quad[k];
        }
    memset(mesh, 0, sizeof *mesh);
    mesh->positions = *positions;
    mesh->vertex_count = (size_t)COLUMNS * (ROWS + 1);
    mesh->indices = *indices;
    mesh->index_count = (size_t)(i - *indices);
    return 0;
}

/* kind: occlusion, emissive, emitter. mesh: NULL for an emitter. */
static int measure(const bn_options *options, const char *name, const char *kind, const sfield_mesh *mesh,
                   sfield_basis basis)
{
    const size_t triangles = mesh ? mesh->index_count / 3 : 0;
    sfield_desc d = bn_sfield_desc(options);
    sfield_emitter lamp;
    sfield_stats stats;
    sfield_field *field = NULL;
    float *radiance = strcmp(kind, "emissive") == 0 ? malloc(3 * triangles * sizeof *radiance) : NULL;
    double start = ex_seconds(), seconds, spent;
    clock_t cpu = clock();
    sfield_result result;
    d.basis = basis;
    if (basis == SFIELD_BASIS_HAAR && !options->full)
        d.position_side = 8;
    memset(&lamp, 0, sizeof lamp);
    lamp.radius = 0.25f;
    lamp.radiance[0] = lamp.radiance[1] = lamp.radiance[2] = 1;
    for (size_t i = 0; i < 3 * triangles && radiance; i++)
        radiance[i] = (float)(i % 5);
    result = !mesh      ? sfield_build_emitter(&d, &lamp, &field, &stats)
             : radiance ? sfield_build_emissive(&d, mesh, radiance, &field, &stats)
                        : sfield_build(&d, mesh, &field, &stats);
    seconds = ex_seconds() - start;
    spent = (double)(clock() - cpu) / CLOCKS_PER_SEC;
    free(radiance);
    if (result != SFIELD_OK)
        return bn_failed("sfield_build", sfield_result_text(result));
    bn_begin(options, "sfield_build", options->threads, bn_sfield_simd());
    bn_text("object", name);
    bn_text("kind", kind);
    bn_text("basis", basis == SFIELD_BASIS_HAAR ? "wavelets" : "harmonics");
    bn_integer("triangles", triangles);
    bn_integer("moved", stats.moved);
    bn_number("build_seconds", seconds);
    bn_number("cpu_seconds", spent);
    bn_integer("bytes", sfield_bytes(field));
    bn_integer("peak_bytes", stats.peak_bytes);
    bn_end(options);
    sfield_free(field);
    return 0;
}

/* Of --model, the teapot of the assets, or a built-in knot. */
static int measure_model(const bn_options *options)
{
    char path[1024];
    const char *scene = options->model ? options->model : bn_asset(options, "teapot.glb", NULL, path);
    bn_model model;
    sfield_mesh mesh;
    int result;
    if (bn_model_load(&model, scene ? scene : "builtin:knot") != 0)
        return -1;
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = model.positions;
    mesh.vertex_count = model.vertices;
    mesh.indices = model.indices;
    mesh.index_count = 3 * model.triangles;
    result = measure(options, model.name, "occlusion", &mesh, SFIELD_BASIS_SH);
    bn_model_free(&model);
    return result;
}

int bn_sfield_build(const bn_options *options)
{
    float *positions = NULL;
    uint32_t *indices = NULL;
    sfield_mesh sphere;
    int result = make_sphere(&positions, &indices, &sphere) != 0 ? bn_failed("sfield_build", "out of memory") : 0;
    if (result == 0)
        result = measure(options, "sphere", "occlusion", &sphere, SFIELD_BASIS_SH) != 0 ||
                 measure(options, "sphere", "occlusion", &sphere, SFIELD_BASIS_HAAR) != 0 ||
                 measure(options, "sphere", "emissive", &sphere, SFIELD_BASIS_SH) != 0 ||
                 measure(options, "lamp", "emitter", NULL, SFIELD_BASIS_SH) != 0 ? -1 : 0;
    if (result == 0)
        result = measure_model(options);
    free(positions);
    free(indices);
    return result;
}
