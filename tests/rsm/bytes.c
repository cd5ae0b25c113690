/* bytes - hashes of maps that rsm.h draws and of what it gathers from them, filtered by gifilter.h as well: the same on
   every compiler, option and byte order. Meshes are made of integers, so that only the headers compute. */

#define RSM_IMPLEMENTATION
#include "rsm.h"
#define GIFILTER_IMPLEMENTATION
#include "gifilter.h"

#include <stdio.h>

enum { BYTES_TRIANGLES = 40, BYTES_POINTS = 48, BYTES_WIDTH = 8 };

static uint32_t bytes_next(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

static float bytes_unit(uint32_t *state) { return (float)(int32_t)(bytes_next(state) % 2049u) / 1024.0f - 1.0f; }

/* Values, not memory: the same for both byte orders. */
static uint32_t bytes_hash(uint32_t h, const float *values, size_t count)
{
    size_t i;
    uint32_t bits, k;
    for (i = 0; i < count; i++) {
        memcpy(&bits, values + i, sizeof bits);
        for (k = 0; k < 4; k++) h = (h ^ (bits >> 8 * k & 255u)) * 16777619u;
    }
    return h;
}

/* Few lights a set, so that receivers are taken together; then two frames through the filter. */
static int bytes_filter(const rsm_map *map, const rsm_points *points, float *e)
{
    static const float matrix[16] = { 1, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0.01f, 0.02f, 0, 1 };
    rsm_gather_desc g;
    gifilt_points pixels;
    gifilt_desc size;
    gifilt_frame f;
    gifilt_filter *filter;
    int frame, ok = 1;
    memset(&g, 0, sizeof g);
    memset(&size, 0, sizeof size);
    size.width = BYTES_WIDTH;
    size.height = BYTES_POINTS / BYTES_WIDTH;
    memset(&f, 0, sizeof f);
    memset(&pixels, 0, sizeof pixels);
    pixels.count = points->count;
    pixels.positions = points->positions;
    pixels.position_stride = points->position_stride;
    pixels.normals = points->normals;
    pixels.normal_stride = points->normal_stride;
    g.sample_count = 100;
    g.interleave = 2;
    f.world_to_clip = matrix;
    f.rows = GIFILT_ROWS_TOP_FIRST;
    f.passes = 3;
    if (gifilt_create(&size, &filter) != GIFILT_OK) return 0;
    for (frame = 0; frame < 2 && ok; frame++) {
        g.seed = (uint32_t)frame;
        ok = rsm_gather(&map, 1, &g, points, e, NULL) == RSM_OK &&
             gifilt_apply(filter, &f, &pixels, e, e) == GIFILT_OK;
    }
    gifilt_free(filter);
    return ok;
}

/* 0: written. */
static int bytes_lines(FILE *lines)
{
    static float corners[9 * BYTES_TRIANGLES], p[3 * BYTES_POINTS], n[3 * BYTES_POINTS], e[3 * BYTES_POINTS],
        noise[256];
    const rsm_material shiny = { { 0.5f, 0.25f, 0.125f }, 20 };
    uint32_t state = 777, i, kind, pattern;
    rsm_mesh mesh;
    rsm_points points;
    memset(&mesh, 0, sizeof mesh);
    memset(&points, 0, sizeof points);
    for (i = 0; i < 9 * BYTES_TRIANGLES; i++) corners[i] = bytes_unit(&state) * (i < 90 ? 1.0f : 0.5f);
    for (i = 0; i < BYTES_POINTS; i++) {
        p[3 * i] = (float)(i % BYTES_WIDTH) * 0.125f - 0.5f;
        p[3 * i + 1] = 0.25f;
        p[3 * i + 2] = (float)(i / BYTES_WIDTH) * 0.125f - 0.5f;
        n[3 * i + 1] = i % 3 ? 1.0f : -1.0f;
    }
    mesh.positions = corners;
    mesh.vertex_count = 3 * BYTES_TRIANGLES;
    mesh.albedo[0] = 0.5f;
    mesh.albedo[1] = 0.25f;
    mesh.albedo[2] = 0.75f;
    mesh.material = 1;
    points.count = BYTES_POINTS;
    points.width = BYTES_WIDTH;
    points.positions = p;
    points.normals = n;
    if (rsm_blue_noise(16, 1, NULL, noise) != RSM_OK) return 1;
    fprintf(lines, "noise %08x\n", (unsigned)bytes_hash(2166136261u, noise, 256));
    for (kind = RSM_LIGHT_SUN; kind < RSM_LIGHT_COUNT; kind++) {
        rsm_desc desc;
        rsm_map *map;
        uint32_t h = 2166136261u;
        rsm_info info;
        size_t texels, at;
        memset(&desc, 0, sizeof desc);
        desc.light.kind = (rsm_light_kind)kind;
        desc.light.position[1] = kind == RSM_LIGHT_SUN ? 0.0f : 1.5f;
        desc.light.direction[1] = kind == RSM_LIGHT_SUN ? 1.0f : -1.0f;
        desc.light.value[0] = desc.light.value[1] = 3;
        desc.light.value[2] = 1;
        desc.light.radius = 1.5f;
        desc.light.cone_half_angle = 0.625f;
        desc.side = 32;
        if (rsm_map_create(&desc, &map) != RSM_OK || rsm_rasterize(map, &mesh, 1) != RSM_OK) return 1;
        if (rsm_finish(map, NULL) != RSM_OK) return 1;
        rsm_get_info(map, &info);
        texels = info.texel_count;
        for (at = 0; at < texels; at++) {
            const rsm_texel *t = rsm_map_texels(map) + at;
            h = bytes_hash(h, t->position, 3);
            h = bytes_hash(h, &t->depth, 1);
            h = bytes_hash(h, t->normal, 3);
            h = bytes_hash(h, t->flux, 3);
            h = bytes_hash(h, &t->area, 1);
        }
        fprintf(lines, "map %u %08x\n", (unsigned)kind, (unsigned)h);
        for (pattern = RSM_PATTERN_FLUX; pattern < RSM_PATTERN_COUNT + 2u; pattern++) {
            const int near_texels = pattern >= RSM_PATTERN_COUNT;       /* as surfaces: of every texel, of MIXED */
            rsm_gather_desc g;
            rsm_gather_stats stats;
            memset(&g, 0, sizeof g);
            g.pattern = near_texels ? RSM_PATTERN_MIXED : (rsm_pattern)pattern;
            g.sample_count = pattern == RSM_PATTERN_COUNT ? 0 : 100;
            g.near_limit = 0.5f;
            g.near_field = near_texels ? 6.0f : 0.0f;
            g.interleave = near_texels ? 1 : 2;
            g.noise = noise;
            g.noise_side = 16;
            g.materials = &shiny;
            g.material_count = 1;
            if (rsm_gather((const rsm_map *const *)&map, 1, &g, &points, e, &stats) != RSM_OK) return 1;
            fprintf(lines, "gather %u %u %08x\n", (unsigned)kind, (unsigned)pattern,
                   (unsigned)bytes_hash(2166136261u, e, 3 * BYTES_POINTS));
        }
        if (!bytes_filter(map, &points, e)) return 1;
        fprintf(lines, "filter %u %08x\n", (unsigned)kind, (unsigned)bytes_hash(2166136261u, e, 3 * BYTES_POINTS));
        rsm_map_free(map);
    }
    return 0;
}

#ifndef RSM_BYTES_NO_MAIN
int main(void) { return bytes_lines(stdout); }
#endif
