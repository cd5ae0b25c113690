/* bytes - hashes of what ism.h computes: the same on every compiler, option and byte order. Inputs are made of
   integers, so that only the header computes. */

#define ISM_IMPLEMENTATION
#include "ism.h"

#include <stdio.h>

/* 1: without what is optional, as core.c has it. */
#ifndef BYTES_CORE
#define BYTES_CORE 0
#endif

static uint32_t next(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

static float unit(uint32_t *state) { return (float)(int32_t)(next(state) % 2049u) / 1024.0f - 1.0f; }

/* By value, not by the bytes in memory. */
static uint32_t hash(const float *v, size_t count)
{
    uint32_t h = 2166136261u, bits;
    size_t i;
    for (i = 0; i < count; i++) {
        memcpy(&bits, v + i, sizeof bits);
        h = (h ^ bits) * 16777619u;
    }
    return h;
}

/* 0: written. */
static int bytes_lines(FILE *lines)
{
    static float mesh_points[9 * 64], at[3 * 256], up[3 * 256], flux[3 * 256], eye[3 * 128], down[3 * 128],
        out[3 * 128];
    uint32_t state = 12345, i, projection;
    for (i = 0; i < 9 * 64; i++) mesh_points[i] = unit(&state);
    for (i = 0; i < 256; i++) {
        at[3 * i] = (float)(i % 16) * 0.25f - 2.0f;
        at[3 * i + 1] = -1.5f;
        at[3 * i + 2] = (float)(i / 16) * 0.25f - 2.0f;
        up[3 * i + 1] = 1.0f;
        flux[3 * i] = flux[3 * i + 1] = flux[3 * i + 2] = unit(&state) + 1.5f;
    }
    for (i = 0; i < 128; i++) {
        eye[3 * i] = (float)(i % 16) * 0.25f - 2.0f;
        eye[3 * i + 1] = 1.5f;
        eye[3 * i + 2] = (float)(i / 16) * 0.5f - 2.0f;
        down[3 * i + 1] = -1.0f;
    }
    for (projection = 0; projection < 8; projection++) {
        ism_mesh mesh;
        ism_source source;
        ism_points view;
        ism_frame frame;
        ism_desc d;
        ism_maps *m;
        ism_shading s = { 0 };
        uint32_t side;
        memset(&mesh, 0, sizeof mesh);
        memset(&source, 0, sizeof source);
        memset(&view, 0, sizeof view);
        memset(&d, 0, sizeof d);
        mesh.positions = mesh_points;
        mesh.vertex_count = 3 * 64;
        source.width = source.height = 16;
        source.positions = at;
        source.normals = up;
        source.fluxes = flux;
        view.positions = eye;
        view.normals = down;
        view.count = 16 * 8;
        view.width = 16;
        view.world_to_clip[0] = 0.5f;
        view.world_to_clip[9] = 0.5f;
        view.world_to_clip[15] = 1.0f;
        view.rows = ISM_ROWS_TOP_FIRST;
        frame.mesh = &mesh;
        frame.sources = &source;
        frame.source_count = 1;
        frame.points = &view;
        frame.index = 0;
        d.vpl_count = 64;
        d.near_point_count = BYTES_CORE ? -1 : 0;
        d.spread = BYTES_CORE ? ISM_SPREAD_VIEW_8 : ISM_SPREAD_DEFAULT;
        d.no_fill = d.no_inter_texel = BYTES_CORE;
        d.surfel_count = 256;
        d.tile_side = 32;
        d.projection = (ism_projection)(1 + projection % 4);
        d.window_rim = projection < 4 || BYTES_CORE ? -1 : 0;
        s.interleave = BYTES_CORE ? 1 : 2;
        s.near_mode = (ism_near)(1 + projection % 4);
        if (ism_create(&d, &m) != ISM_OK || ism_render(m, &frame, &s, out, NULL) != ISM_OK) return 1;
        {
            const float *atlas = ism_atlas(m, &side, NULL);
            fprintf(lines, "projection %u%s: BRSM %08x atlas %08x light %08x\n", (unsigned)projection % 4,
                   projection < 4 ? "" : ", windows", (unsigned)hash(ism_importances(m, 0, NULL), 256),
                   (unsigned)hash(atlas, (size_t)side * side), (unsigned)hash(out, 3 * 128));
        }
        ism_free(m);
    }
    return 0;
}

#ifndef ISM_BYTES_NO_MAIN
int main(void) { return bytes_lines(stdout); }
#endif
