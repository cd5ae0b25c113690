/* bytes - hashes of the blocks that csm.h builds, and of what it answers on them: the same on every compiler,
   option and byte order. Meshes are made of integers, so that only the header computes. golden_bytes.txt keeps
   the lines. */

#define CSM_IMPLEMENTATION
#include "csm.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BYTES_TRIANGLES = 48, BYTES_POINTS = 200 };

static uint32_t bytes_next(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

static float bytes_unit(uint32_t *state) { return (float)(int32_t)(bytes_next(state) % 2049u) / 1024.0f - 1.0f; }

static uint32_t bytes_hash(uint32_t h, const void *data, size_t size)
{
    const uint8_t *p = (const uint8_t *)data;
    size_t i;
    for (i = 0; i < size; i++) h = (h ^ p[i]) * 16777619u;
    return h;
}

/* An open soup, large and small triangles; or a closed shape: an octahedron with every face raised to a pyramid. */
static uint32_t bytes_mesh(float *p, int closed)
{
    uint32_t state = 12345, t, k, c, n = 0;
    if (!closed) {
        for (t = 0; t < BYTES_TRIANGLES; t++) {
            float at[3];
            for (c = 0; c < 3; c++) at[c] = 0.5f * bytes_unit(&state);
            for (k = 0; k < 3; k++)
                for (c = 0; c < 3; c++) p[n++] = at[c] + bytes_unit(&state) * (t % 4 ? 0.125f : 0.5f);
        }
        return n / 9;
    }
    for (t = 0; t < 8; t++) {
        float corner[4][3];
        for (k = 0; k < 4; k++)
            for (c = 0; c < 3; c++) {
                float sign = t >> c & 1u ? -1.0f : 1.0f;
                corner[k][c] = k == 3 ? sign * (c == t % 3 ? 0.75f : 0.5f) : k == c ? sign : 0.0f;
            }
        for (k = 0; k < 3; k++) {
            memcpy(p + n, corner[k], 12);
            memcpy(p + n + 3, corner[(k + 1) % 3], 12);
            memcpy(p + n + 6, corner[3], 12);
            n += 9;
        }
    }
    return n / 9;
}

static uint32_t bytes_answers(const cohsm_maps *maps)
{
    static float p[3 * BYTES_POINTS], l[3 * BYTES_POINTS], v[BYTES_POINTS];
    uint32_t h = 2166136261u, state = 99, i, light, filter;
    cohsm_info info;

    cohsm_get_info(maps, &info);
    for (light = 0; light < 4; light++)
        for (filter = 0; filter < 3; filter++) {
            cohsm_query q = { 0 };
            for (i = 0; i < 3 * BYTES_POINTS; i++) {
                p[i] = 1.25f * bytes_unit(&state);
                l[i] = bytes_unit(&state);
                if (light == COHSM_LIGHT_PARAMETER) l[i] = 0.5f * l[i] + 0.5f;
                if (light == COHSM_LIGHT_POSITION) l[i] *= 4.0f;
            }
            for (i = 0; light == COHSM_LIGHT_INDEX && i < BYTES_POINTS; i++) {
                uint32_t index = bytes_next(&state) % info.map_count;
                memcpy(l + 3 * i, &index, 4);
            }
            q.positions = p;
            q.lights = l;
            q.light_stride = 12;
            q.count = BYTES_POINTS;
            q.light_kind = (cohsm_light_kind)light;
            q.filter = (cohsm_filter)filter;
            if (cohsm_visible(maps, &q, v, NULL) != COHSM_OK) continue;
            for (i = 0; i < BYTES_POINTS; i++) {
                int32_t thousandth = (int32_t)(v[i] * 4096.0f + (v[i] < 0.0f ? -0.5f : 0.5f));
                uint8_t b[2];
                b[0] = (uint8_t)(thousandth & 255);
                b[1] = (uint8_t)(thousandth >> 8 & 255);
                if (filter == COHSM_FILTER_PCF) b[0] &= 0xf0;       /* rounding of the weights' sum */
                h = bytes_hash(h, b, 2);
            }
        }
    return h;
}

/* One line: the desc, the hash of the file, of the answers, and its length. */
static int bytes_line(char *out, size_t room, const char *name, const cohsm_desc *d, int closed)
{
    static float positions[9 * BYTES_TRIANGLES];
    cohsm_mesh mesh;
    cohsm_maps *maps = NULL, *again = NULL;
    cohsm_info info;
    uint8_t *file;
    cohsm_result r;

    memset(&mesh, 0, sizeof mesh);
    mesh.positions = positions;
    mesh.vertex_count = 3 * (size_t)bytes_mesh(positions, closed);
    r = cohsm_build(d, &mesh, &maps, NULL);
    if (r != COHSM_OK) return snprintf(out, room, "%s: %s\n", name, cohsm_result_text(r));
    cohsm_get_info(maps, &info);
    file = (uint8_t *)malloc(info.bytes);
    if (!file || cohsm_write(maps, file, info.bytes) != COHSM_OK ||
        cohsm_open(file, info.bytes, NULL, &again) != COHSM_OK) {
        free(file);
        cohsm_free(maps);
        return snprintf(out, room, "%s: cannot be read again\n", name);
    }
    snprintf(out, room, "%s: %08lx %08lx %lu\n", name, (unsigned long)bytes_hash(2166136261u, file, info.bytes),
             (unsigned long)bytes_answers(again), (unsigned long)info.bytes);
    free(file);
    cohsm_free(again);
    cohsm_free(maps);
    return 0;
}

enum { BYTES_LINES = 46 };

/* Line i, or 0 beyond the last one. */
static int bytes_case(int i, char *out, size_t room)
{
    static const char *const names[9] = { "latlong", "octahedral", "line",  "rectangle", "disc",
                                          "sphere",  "volume",     "table", "list" };
    static const float where[24] = { 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 5, 0, -1, 0, 0.5f, 0, 0, -1, 0, 0, 1, 1, 1, 0 };
    cohsm_desc d;
    char name[96];
    int kind = i % 9, round = i / 9;

    if (i >= BYTES_LINES) return 0;
    memset(&d, 0, sizeof d);
    d.domain.kind = (cohsm_domain_kind)(kind + 1);
    d.domain.side[0] = kind == 6 ? 3 : kind < 2 ? 9 : kind == 7 ? 3 : 5;
    d.domain.side[1] = kind == 2 ? 0 : kind == 7 ? 2 : kind == 6 ? 4 : kind == 1 ? 9 : kind == 0 ? 8 : 4;
    d.domain.side[2] = kind == 6 ? 2 : 0;
    if (kind >= 7) {
        d.domain.locations = where;
        d.domain.location_count = 6;
    }
    if (kind == 8) memset(d.domain.side, 0, sizeof d.domain.side);
    d.domain.origin[0] = -1;
    d.domain.origin[1] = round % 2 ? 0.25f : 1.75f;
    d.domain.origin[2] = -1;
    d.domain.u[0] = 2;
    d.domain.v[2] = 2;
    d.domain.w[1] = 1;
    d.map_side = 16 + 3 * (uint32_t)round;
    d.layers = (cohsm_layers)(1 + (kind + round) % 3);
    d.order = (cohsm_order)(i == 45 ? 0 : 1 + i % 4);
    d.orientation = (cohsm_orientation)(1 + (i / 2) % 3);
    d.depth_bits = 4 + (uint32_t)(i * 3 % 5);
    d.self_only = i % 7 == 5;
    if (round == 2) {
        d.pixel_begin = 37;
        d.pixel_end = 201;
    }
    if (i == 45) {                                  /* every default that a build can choose for itself */
        memset(&d, 0, sizeof d);
        d.domain.side[0] = d.domain.side[1] = 12;
        d.map_side = 32;
    }
    snprintf(name, sizeof name, "%02d %s layers %d order %d frame %d bits %u", i, i == 45 ? "defaults" : names[kind],
             (int)d.layers, (int)d.order, (int)d.orientation, (unsigned)d.depth_bits);
    bytes_line(out, room, name, &d, (kind + round) % 2 || d.layers > COHSM_LAYERS_Z1Z2);
    return 1;
}

#ifndef CSM_BYTES_NO_MAIN
int main(void)
{
    char line[256];
    int i;
    for (i = 0; bytes_case(i, line, sizeof line); i++) fputs(line, stdout);
    return 0;
}
#endif
