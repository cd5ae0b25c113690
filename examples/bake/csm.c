/* csm.c - bake's technique csm: maps of all directions; units are the pixels of a map. */
#include "csm.h"
#include "bake.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const rd_key keys[] = {
    { "side", RD_INTEGER, NULL, 1, 1024, "128", "maps a side of the domain" },
    { "m", RD_INTEGER, NULL, 4, 1024, "128", "pixels a side of a map" },
    { "layers", RD_WORD, "z1z2|z1z3_sphere|z1z3_far", 0, 0, "z1z2", "which hit the stored depths lie in front of" },
    { "order", RD_WORD, "auto|scanline|zigzag|zigzag_theta|hilbert", 0, 0, "hilbert",
      "auto: by trial, in every shard" },
    { "packed", RD_WORD, "0|1", 0, 0, "0", "1: entropy-coded file, about half as large; shards are never" },
    { NULL, RD_WORD, NULL, 0, 0, NULL, NULL }
};

static int failed(const char *what, cohsm_result result, char *error)
{
    snprintf(error, EX_ERROR_SIZE, "csm: %s: %s", what, cohsm_result_text(result));
    return -1;
}

static uint32_t word(const rd_settings *settings, const char *key, const char *const *words)
{
    uint32_t i = 0;
    while (strcmp(rd_setting_text(settings, key), words[i]) != 0)
        i++;
    return i;
}

/* For calls that build nothing. */
static cohsm_desc services(char *label)
{
    cohsm_desc d;
    memset(&d, 0, sizeof d);
    d.progress = ex_progress;
    d.progress_user = label;
    return d;
}

static cohsm_desc desc_of(const rd_settings *settings, ex_pool *pool)
{
    static const char *const orders[] = { "auto", "scanline", "zigzag", "zigzag_theta", "hilbert" };
    static const char *const layers[] = { "", "z1z2", "z1z3_sphere", "z1z3_far" };
    static char label[] = "csm maps";
    cohsm_desc d = services(label);
    d.domain.side[0] = d.domain.side[1] = (uint32_t)rd_setting_integer(settings, "side");
    d.map_size = (uint32_t)rd_setting_integer(settings, "m");
    d.order = (cohsm_order)word(settings, "order", orders);
    d.layers = (cohsm_layers)word(settings, "layers", layers);
    if (d.order != COHSM_ORDER_DEFAULT)
        d.frame = COHSM_FRAME_POLAR;
    d.parallel_for = ex_pool_run;
    d.parallel_user = pool;
    return d;
}

static cohsm_mesh mesh_of(const bk_mesh *m)
{
    cohsm_mesh mesh = { m->positions, m->vertices, 0, m->indices, 3 * m->triangles };
    return mesh;
}

/* About 50 ns a triangle and 15 ns a pixel of each view. */
static int plan(const rd_settings *settings, const bk_mesh *mesh, uint32_t *units, double *seconds, char *error)
{
    double side = rd_setting_number(settings, "side");
    uint32_t m = (uint32_t)rd_setting_integer(settings, "m");
    (void)error;
    *units = m * m;
    *seconds = side * side * (50e-9 * (double)mesh->triangles + 15e-9 * (double)*units);
    return 0;
}

/* Every pixel costs something, those of the bounding sphere's disc the most. */
static double weight(const rd_settings *settings, uint32_t units, uint32_t unit)
{
    double m = rd_setting_number(settings, "m"), x, y;
    (void)units;
    x = 2 * (fmod(unit, m) + 0.5) / m - 1;
    y = 2 * (floor(unit / m) + 0.5) / m - 1;
    return 0.1 + fmax(0, 1 - x * x - y * y) / (1 + fabs(y));
}

/* The file's bytes, and frees the maps. */
static int bytes_of(cohsm_maps *maps, int packed, void **data, size_t *size, char *error)
{
    static char label[] = "packing";
    cohsm_desc d = services(label);
    cohsm_result result;
    if (packed) {
        result = cohsm_pack(maps, &d, data, size);
        ex_progress(NULL, 1);
    } else {
        cohsm_data(maps, size);
        *data = malloc(*size);
        result = *data ? cohsm_write(maps, *data, *size) : COHSM_ERR_ALLOC;
    }
    cohsm_free(maps);
    return result == COHSM_OK ? 0 : failed("file", result, error);
}

static int bake(const rd_settings *settings, const bk_mesh *mesh, uint32_t from, uint32_t to, ex_pool *pool,
                void **data, size_t *size, char *error)
{
    cohsm_desc d = desc_of(settings, pool);
    cohsm_mesh m = mesh_of(mesh);
    cohsm_maps *maps;
    cohsm_result result;
    d.pixel_begin = from;
    d.pixel_end = to;
    result = cohsm_build(&d, &m, &maps, NULL);
    ex_progress(NULL, 1);
    if (result != COHSM_OK)
        return failed("build", result, error);
    return bytes_of(maps, to - from == d.map_size * d.map_size && rd_setting_is(settings, "packed", "1"), data, size,
                    error);
}

static int merge(const void *const *parts, const size_t *sizes, size_t count, int packed, void **data, size_t *size,
                 char *error)
{
    static char label[] = "merging";
    cohsm_desc d = services(label);
    cohsm_maps **maps = calloc(count, sizeof(cohsm_maps *)), *whole = NULL;
    cohsm_result result = maps ? COHSM_OK : COHSM_ERR_ALLOC;
    for (size_t i = 0; i < count && result == COHSM_OK; i++)
        result = cohsm_open(parts[i], sizes[i], NULL, &maps[i]);
    if (result == COHSM_OK)
        result = cohsm_merge((const cohsm_maps *const *)maps, count, &d, &whole);
    ex_progress(NULL, 1);
    for (size_t i = 0; i < count && maps; i++)
        cohsm_free(maps[i]);
    free(maps);
    return result == COHSM_OK ? bytes_of(whole, packed, data, size, error) : failed("merge", result, error);
}

static int info(const void *data, size_t size, char *line, size_t room, char *error)
{
    static const char *const layers[] = { "", "z1z2", "z1z3_sphere", "z1z3_far" };
    static const char *const orders[] = { "", "scanline", "zigzag", "zigzag_theta", "hilbert" };
    static char label[] = "reading";
    cohsm_desc d = services(label);
    cohsm_maps *maps;
    cohsm_info i;
    cohsm_result result = cohsm_open(data, size, &d, &maps);
    ex_progress(NULL, 1);
    if (result != COHSM_OK)
        return failed("file", result, error);
    cohsm_get_info(maps, &i);
    cohsm_free(maps);
    snprintf(line, room,
             "{\"technique\": \"csm\", \"file_bytes\": %lu, \"bytes\": %lu, \"side\": %u, \"maps\": %u, \"m\": %u, "
             "\"layers\": \"%s\", \"order\": \"%s\", \"segments\": %llu, \"ratio\": %.3f, \"pixel_begin\": %u, "
             "\"pixel_end\": %u, "
             "\"center\": [%.9g, %.9g, %.9g], \"radius\": %.9g}",
             (unsigned long)size, (unsigned long)i.bytes, (unsigned)i.side[0], (unsigned)i.map_count,
             (unsigned)i.map_size, layers[i.layers], orders[i.order], (unsigned long long)i.segments, i.ratio,
             (unsigned)i.pixel_begin, (unsigned)i.pixel_end, (double)i.center[0], (double)i.center[1],
             (double)i.center[2], (double)i.radius);
    return 0;
}

static int verify(const rd_settings *settings, const void *data, size_t size, const bk_mesh *mesh, ex_pool *pool,
                  char *line, size_t room, char *error)
{
    cohsm_desc d = desc_of(settings, pool);
    cohsm_mesh m = mesh_of(mesh);
    cohsm_maps *maps;
    cohsm_report report;
    cohsm_result result = cohsm_open(data, size, &d, &maps);
    if (result != COHSM_OK)
        return failed("file", result, error);
    result = cohsm_verify(maps, &d, &m, &report);
    ex_progress(NULL, 1);
    cohsm_free(maps);
    if (result != COHSM_OK)
        return failed("verify", result, error);
    snprintf(line, room, "{\"technique\": \"csm\", \"entries\": %llu, \"wrong\": %llu, \"empty\": %llu}",
             (unsigned long long)report.entries, (unsigned long long)report.wrong, (unsigned long long)report.empty);
    return report.wrong != 0;
}

const bk_technique bk_csm = { "csm", keys, plan, weight, bake, merge, info, verify };
