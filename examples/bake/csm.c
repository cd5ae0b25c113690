/* csm.c - bake's technique csm: maps of all directions; units are the pixels of a map. */
#include "csm.h"
#include "bake.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const rd_key keys[] = {
    { "side", RD_INTEGER, NULL, 1, 1024, "128", "maps a side of the domain; emissive: side x side places" },
    { "side_v", RD_INTEGER, NULL, 0, 4096, "0", "maps along the second dimension; 0: as side, of a table 1" },
    { "side_w", RD_INTEGER, NULL, 0, 4096, "0", "maps along the third dimension; 0: as side, of a table 1" },
    { "map_side", RD_INTEGER, NULL, 4, 1024, "128", "pixels a side of a map" },
    { "layers", RD_WORD, "z1z2|z1z3_sphere|z1z3_far", 0, 0, "z1z2", "which hit the stored depths lie in front of" },
    { "order", RD_WORD, "auto|scanline|zigzag|zigzag_theta|hilbert", 0, 0, "hilbert",
      "auto: by trial, in every shard" },
    { "orientation", RD_WORD, "auto|polar|minimal|two_poles", 0, 0, "auto",
      "which way is up in a map of a direction; auto: with order=auto by trial, else polar" },
    { "depth_bits", RD_INTEGER, NULL, 4, 8, "8", "of the grid of stored depths" },
    { "open_thickness", RD_NUMBER, NULL, 0, 1024, "0", "pixels that a surface without a back is thick; 0: 8" },
    { "self_only", RD_WORD, "0|1", 0, 0, "0", "1: smaller, and answers only for points on the object itself" },
    { "center_x", RD_NUMBER, NULL, -1e9, 1e9, "0", "of the sphere that the maps hold" },
    { "center_y", RD_NUMBER, NULL, -1e9, 1e9, "0", "" },
    { "center_z", RD_NUMBER, NULL, -1e9, 1e9, "0", "" },
    { "radius", RD_NUMBER, NULL, 0, 1e9, "0", "of that sphere, which must hold the object; 0: both are fitted" },
    { "packed", RD_WORD, "0|1", 0, 0, "0", "1: entropy-coded file, about half as large; shards are never" },
    { "budget", RD_NUMBER, NULL, 0, 1e6, "0",
      "MB in memory: takes the side and map_side, below it, of the least expected error; 0: as given" },
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
    d.system.progress = ex_progress;
    d.system.user = label;
    return d;
}

static const bk_domain all_directions;

static const bk_domain *domain_of(const bk_mesh *mesh) { return mesh->domain ? mesh->domain : &all_directions; }

static cohsm_desc desc_of(const rd_settings *settings, const bk_mesh *mesh, ex_pool *pool)
{
    static const char *const orientations[] = { "auto", "polar", "minimal", "two_poles" };
    static const char *const centers[] = { "center_x", "center_y", "center_z" };
    static const char *const orders[] = { "auto", "scanline", "zigzag", "zigzag_theta", "hilbert" };
    static const char *const layers[] = { "", "z1z2", "z1z3_sphere", "z1z3_far" };
    static char label[] = "csm maps";
    cohsm_desc d = services(label);
    bk_domain_fill(domain_of(mesh), settings, &d.domain);
    d.map_side = (uint32_t)rd_setting_integer(settings, "map_side");
    d.order = (cohsm_order)word(settings, "order", orders);
    d.layers = (cohsm_layers)word(settings, "layers", layers);
    d.orientation = (cohsm_orientation)word(settings, "orientation", orientations);
    if (d.order != COHSM_ORDER_DEFAULT && d.orientation == COHSM_ORIENTATION_DEFAULT)
        d.orientation = COHSM_ORIENTATION_POLAR;
    d.depth_bits = (uint32_t)rd_setting_integer(settings, "depth_bits");
    d.open_thickness = (float)rd_setting_number(settings, "open_thickness");
    d.self_only = rd_setting_is(settings, "self_only", "1");
    d.radius = (float)rd_setting_number(settings, "radius");
    for (int k = 0; k < 3; k++)
        d.center[k] = (float)rd_setting_number(settings, centers[k]);
    ex_pool_label(pool, label);
    d.system.parallel_for = ex_pool_run;
    d.system.progress = ex_pool_progress;
    d.system.user = pool;
    return d;
}

static cohsm_mesh mesh_of(const bk_mesh *m)
{
    cohsm_mesh mesh = { m->positions, m->vertices, 0, m->indices, 3 * m->triangles, NULL, NULL, NULL };
    return mesh;
}

/* With a budget, side and map_side are those that cohsm_budget finds; all shards find the same. */
static int settle(rd_settings *settings, const bk_mesh *mesh, ex_pool *pool, char *error)
{
    const double budget = rd_setting_number(settings, "budget");
    char pair[40];
    cohsm_desc d = desc_of(settings, mesh, pool);
    cohsm_mesh m = mesh_of(mesh);
    uint32_t side, map_side;
    cohsm_result result;
    if (budget == 0)
        return 0;
    result = cohsm_budget(&d, &m, (size_t)(budget * 1e6), &side, &map_side);
    ex_progress(NULL, 1);
    if (result != COHSM_OK)
        return failed(result == COHSM_ERR_LIMIT ? "budget below what side 8 and map_side 16 take" : "budget", result,
                      error);
    snprintf(pair, sizeof pair, "side=%u", (unsigned)side);
    if (rd_settings_add(settings, pair, error) != 0)
        return -1;
    snprintf(pair, sizeof pair, "map_side=%u", (unsigned)map_side);
    return rd_settings_add(settings, pair, error);
}

/* About 10 ns a triangle and 15 ns a pixel of each view. */
static int plan(const rd_settings *settings, const bk_mesh *mesh, uint32_t *units, double *seconds, char *error)
{
    uint32_t m = (uint32_t)rd_setting_integer(settings, "map_side"), side[3];
    double maps;
    (void)error;
    bk_domain_sides(domain_of(mesh), settings, side);
    maps = domain_of(mesh)->count ? (double)domain_of(mesh)->count : (double)side[0] * side[1] * side[2];
    *units = m * m;
    *seconds = maps * (10e-9 * (double)mesh->triangles + 15e-9 * (double)*units);
    return 0;
}

/* The vertex farthest from a point, and how far. */
static const float *farthest(const bk_mesh *mesh, const float *from, float *distance)
{
    const float *far = mesh->positions;
    float most = -1;
    for (size_t v = 0; v < mesh->vertices; v++) {
        const float *p = mesh->positions + 3 * v;
        float x = p[0] - from[0], y = p[1] - from[1], z = p[2] - from[2], d = x * x + y * y + z * z;
        if (d > most)
            most = d, far = p;
    }
    *distance = sqrtf(most);
    return far;
}

/* Some triangles' middles, in units of the sphere about the object, nearly. Returns how many. */
static size_t middles(const bk_mesh *mesh, float (*out)[3], size_t room)
{
    size_t step = mesh->triangles / room + 1, n = 0;
    float middle[3] = { mesh->positions[0], mesh->positions[1], mesh->positions[2] }, radius;
    for (int k = 0; k < 16; k++) {
        const float *p = farthest(mesh, middle, &radius);
        for (int i = 0; i < 3; i++)
            middle[i] += (p[i] - middle[i]) / (float)(k + 2);
    }
    farthest(mesh, middle, &radius);
    for (size_t t = 0; t < mesh->triangles; t += step, n++)
        for (int k = 0; k < 3; k++) {
            float sum = 0;
            for (size_t c = 0; c < 3; c++)
                sum += mesh->positions[3 * (size_t)mesh->indices[3 * t + c] + (size_t)k];
            out[n][k] = radius > 0 ? (sum / 3 - middle[k]) / radius : 0;
        }
    return n;
}

/* A row costs what triangles lie on it, seen from all around, whole if one pixel is wanted; and each pixel something.
   Of what lies on the row at a limit about as much again is set up, for clusters that overhang. Shares as measured of
   200,000 triangles at M = 128. */
static void weigh(const rd_settings *settings, const bk_mesh *mesh, bk_work *work)
{
    enum { VIEWS = 16, MIDDLES = 2048 };
    static float middle[MIDDLES][3];
    int m = rd_setting_integer(settings, "map_side");
    size_t count = middles(mesh, middle, MIDDLES - 1);
    work->row_units = (uint32_t)m;
    work->overhang = 0.7;
    for (uint32_t u = 0; u < work->units; u++)
        work->unit[u] = 0.2 / work->units;
    for (int view = 0; view < VIEWS * VIEWS; view++) {
        float theta = ((float)(view / VIEWS) + 0.5f) * 3.14159265f / VIEWS, phi = (float)view * 6.2831853f / VIEWS;
        float up[3] = { -cosf(theta) * cosf(phi), sinf(theta), -cosf(theta) * sinf(phi) };
        for (size_t i = 0; i < count; i++) {
            float y = middle[i][0] * up[0] + middle[i][1] * up[1] + middle[i][2] * up[2];
            int row = (int)((y + 1) * 0.5f * (float)m);
            if (row >= 0 && row < m)
                work->row[row] += 0.8 / (VIEWS * VIEWS) / (double)count;
        }
    }
}

/* The file's bytes, and frees the maps. */
static int bytes_of(cohsm_maps *maps, int packed, void **data, size_t *size, char *error)
{
    static char label[] = "packing";
    cohsm_desc d = services(label);
    cohsm_result result;
    if (packed) {
        result = cohsm_pack(maps, &d.system, data, size);
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
    cohsm_desc d = desc_of(settings, mesh, pool);
    cohsm_mesh m = mesh_of(mesh);
    cohsm_maps *maps;
    cohsm_result result;
    d.pixel_begin = from;
    d.pixel_end = to;
    result = cohsm_build(&d, &m, &maps, NULL);
    ex_progress(NULL, 1);
    if (result != COHSM_OK)
        return failed("build", result, error);
    return bytes_of(maps, to - from == d.map_side * d.map_side && rd_setting_is(settings, "packed", "1"), data, size,
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
        result = cohsm_merge((const cohsm_maps *const *)maps, count, &d.system, &whole);
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
    cohsm_result result = cohsm_open(data, size, &d.system, &maps);
    ex_progress(NULL, 1);
    if (result != COHSM_OK)
        return failed("file", result, error);
    cohsm_get_info(maps, &i);
    cohsm_free(maps);
    snprintf(line, room,
             "{\"technique\": \"csm\", \"file_bytes\": %lu, \"bytes\": %lu, \"domain\": \"%s\", \"side\": %u, \"side_v\": %u, \"side_w\": %u, \"maps\": %u, \"map_side\": %u, "
             "\"layers\": \"%s\", \"order\": \"%s\", \"segments\": %llu, \"ratio\": %.3f, \"pixel_begin\": %u, "
             "\"pixel_end\": %u, "
             "\"center\": [%.9g, %.9g, %.9g], \"radius\": %.9g}",
             (unsigned long)size, (unsigned long)i.bytes, bk_domain_name((int)i.domain), (unsigned)i.side[0],
             (unsigned)i.side[1], (unsigned)i.side[2], (unsigned)i.map_count,
             (unsigned)i.map_side, layers[i.layers], orders[i.order], (unsigned long long)i.segment_count, i.ratio,
             (unsigned)i.pixel_begin, (unsigned)i.pixel_end, (double)i.center[0], (double)i.center[1],
             (double)i.center[2], (double)i.radius);
    return 0;
}

static int verify(const rd_settings *settings, const void *data, size_t size, const bk_mesh *mesh, ex_pool *pool,
                  char *line, size_t room, char *error)
{
    cohsm_desc d = desc_of(settings, mesh, pool);
    cohsm_mesh m = mesh_of(mesh);
    cohsm_maps *maps;
    cohsm_report report;
    cohsm_result result = cohsm_open(data, size, &d.system, &maps);
    if (result != COHSM_OK)
        return failed("file", result, error);
    result = cohsm_verify(maps, &d.system, &m, &report);
    ex_progress(NULL, 1);
    cohsm_free(maps);
    if (result != COHSM_OK)
        return failed("verify", result, error);
    snprintf(line, room, "{\"technique\": \"csm\", \"entries\": %llu, \"wrong\": %llu, \"empty\": %llu}",
             (unsigned long long)report.entries, (unsigned long long)report.wrong, (unsigned long long)report.empty);
    return report.wrong != 0;
}

const bk_technique bk_csm = { "csm", keys, settle, plan, weigh, bake, merge, info, verify };
