/* bytes - hashes of the files that shadowfield.h makes: the same on every compiler, option and byte order.
   Meshes are made of integers, so that only the header computes. golden_bytes.txt keeps the lines. */

#define SHADOWFIELD_IMPLEMENTATION
#include "shadowfield.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BYTES_TRIANGLES = 24, BYTES_CASES = 14 };

static uint32_t bytes_next(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

static float bytes_unit(uint32_t *state) { return (float)(int32_t)(bytes_next(state) % 2049u) / 1024.0f - 1.0f; }

static uint32_t bytes_hash(const void *data, size_t size)
{
    const uint8_t *p = (const uint8_t *)data;
    uint32_t h = 2166136261u;
    size_t i;
    for (i = 0; i < size; i++) h = (h ^ p[i]) * 16777619u;
    return h;
}

/* Line i of the output; 0: there is none. */
static int bytes_case(int i, char *line, size_t size)
{
    static float p[9 * BYTES_TRIANGLES], radiance[6 * BYTES_TRIANGLES], normals[9];
    sfield_mesh mesh;
    sfield_desc d;
    sfield_emitter e;
    sfield_points receivers;
    sfield_field *f = NULL;
    sfield_result r;
    uint32_t state = 7, t, k, c, n = 0;
    uint8_t *data;
    if (i >= BYTES_CASES) return 0;
    for (t = 0; t < BYTES_TRIANGLES; t++) {
        float at[3];
        for (c = 0; c < 3; c++) at[c] = 0.5f * bytes_unit(&state);
        for (k = 0; k < 3; k++)
            for (c = 0; c < 3; c++) p[n++] = at[c] + bytes_unit(&state) * (t % 4 ? 0.125f : 0.5f);
    }
    for (t = 0; t < 6 * BYTES_TRIANGLES; t++) radiance[t] = (float)(bytes_next(&state) % 5u);
    memset(normals, 0, sizeof normals);
    normals[1] = normals[3] = normals[8] = 1;
    memset(&mesh, 0, sizeof mesh);
    memset(&d, 0, sizeof d);
    memset(&e, 0, sizeof e);
    memset(&receivers, 0, sizeof receivers);
    mesh.positions = p;
    mesh.vertex_count = 3 * BYTES_TRIANGLES;
    d.basis = i & 1 ? SFIELD_BASIS_HAAR : SFIELD_BASIS_SH;
    d.shell_count = 4;
    d.position_side = 4;
    d.cube_side = 16;
    d.bands = i & 1 ? 0 : i == 8 ? 6 : 4;
    d.window = i & 1 ? 0 : 0.01f * (float)i;
    d.spacing = i == 9 ? SFIELD_SPACING_UNIFORM : SFIELD_SPACING_DEFAULT;
    if (i == 10) {                                  /* a closed box: positions inside are moved out */
        static const uint32_t sides[36] = { 1, 3, 7, 1, 7, 5, 0, 4, 6, 0, 6, 2, 2, 6, 7, 2, 7, 3,
                                            0, 1, 5, 0, 5, 4, 4, 5, 7, 4, 7, 6, 0, 2, 3, 0, 3, 1 };
        for (t = 0; t < 24; t++) p[t] = (t / 3 >> t % 3 & 1 ? 1.0f : -1.0f) * (t % 3 == 1 ? 0.25f : 1);
        mesh.indices = sides;
        mesh.index_count = 36;
        mesh.vertex_count = 8;
    }
    if (i > 10)                                     /* slivers, lines, doubled triangles, one over another */
        for (t = 1; t < BYTES_TRIANGLES; t++) {
            float *q = p + 9 * t;
            if (t % 6 == 1) memcpy(q, q - 9, 9 * sizeof *q);
            for (c = 0; t % 6 == 2 && c < 3; c++) q[6 + c] = 0.5f * (q[c] + q[3 + c]) + (c == 1 ? 0.0009765625f : 0);
            for (c = 0; t % 6 == 3 && c < 3; c++) q[6 + c] = 2 * q[3 + c] - q[c];
            for (k = 0; t % 6 == 4 && k < 3; k++) memcpy(q + 3 * k, q - 9 - 3 * k + 6, 3 * sizeof *q);
            for (c = 0; t % 6 == 5 && c < 3; c++) q[3 * c + 2] = 0.5f;
        }
    e.radius = 0.75f;
    e.radiance[0] = 3;
    e.radiance[2] = 1.5f;
    if (i < 2 || (i >= 8 && i < 12)) r = sfield_build(&d, &mesh, &f, NULL);
    else if (i < 4 || i > 11) {
        d.frame_count = 2;
        r = sfield_build_emissive(&d, &mesh, radiance, &f, NULL);
    } else if (i < 6) r = sfield_build_emitter(&d, &e, &f, NULL);
    else {
        receivers.count = 3;
        receivers.positions = p;
        receivers.normals = normals;
        r = sfield_build_self(&d, &mesh, &receivers, 0.0625f, &f, NULL);
    }
    if (r != SFIELD_OK) {
        snprintf(line, size, "%d: %s\n", i, sfield_result_text(r));
        return 1;
    }
    data = (uint8_t *)malloc(sfield_bytes(f));
    if (data) sfield_write(f, data, sfield_bytes(f));
    snprintf(line, size, "%d: %lu bytes %08lx\n", i, (unsigned long)sfield_bytes(f),
             data ? (unsigned long)bytes_hash(data, sfield_bytes(f)) : 0ul);
    free(data);
    sfield_free(f);
    return 1;
}

#ifndef SFIELD_BYTES_NO_MAIN
int main(void)
{
    char line[256];
    int i;
    for (i = 0; bytes_case(i, line, sizeof line); i++) fputs(line, stdout);
    return 0;
}
#endif
