/* stones.c - a made scene for bake_ao: 1,000 stones of four shapes that lie close together, as a .glb file. */
#include "bench.h"
#include "stones.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SHAPES = 4, AROUND = 16, RINGS = 7, VERTICES = AROUND * RINGS + 2, TRIANGLES = 2 * AROUND * RINGS, ACROSS = 32 };

static void put_word(FILE *file, uint32_t word)
{
    for (int i = 0; i < 4; i++)
        putc((int)(word >> 8 * i & 255), file);
}

/* A sphere of radius about 1/2, pushed in and out by three waves. */
static void put_vertices(FILE *file, uint64_t *seed)
{
    float wave[3][4];
    for (int i = 0; i < 12; i++)
        wave[i / 4][i % 4] = bn_random_in(seed, -4, 4);
    for (int i = 0; i < VERTICES; i++) {
        const float up = i < 2 ? (float)i * 3.14159265f : 3.14159265f * (float)((i - 2) / AROUND + 1) / (RINGS + 1);
        const float turn = 6.2831853f * (float)((i - 2) % AROUND) / AROUND;
        const float p[3] = { sinf(up) * cosf(turn), cosf(up), sinf(up) * sinf(turn) };
        float size = 0.5f;
        for (int k = 0; k < 3; k++)
            size += 0.04f * sinf(wave[k][0] * p[0] + wave[k][1] * p[1] + wave[k][2] * p[2] + wave[k][3]);
        for (int k = 0; k < 3; k++) {
            const float x = size * p[k];
            uint32_t word;
            memcpy(&word, &x, sizeof word);
            put_word(file, word);
        }
    }
}

static void put_triangle(FILE *file, int a, int b, int c)
{
    put_word(file, (uint32_t)a);
    put_word(file, (uint32_t)b);
    put_word(file, (uint32_t)c);
}

static void put_triangles(FILE *file)
{
    for (int i = 0; i < AROUND; i++) {
        const int next = (i + 1) % AROUND, last = 2 + AROUND * (RINGS - 1);
        put_triangle(file, 0, 2 + next, 2 + i);
        put_triangle(file, 1, last + i, last + next);
        for (int ring = 2; ring < 2 + last - AROUND; ring += AROUND) {
            put_triangle(file, ring + i, ring + next, ring + AROUND + next);
            put_triangle(file, ring + i, ring + AROUND + next, ring + AROUND + i);
        }
    }
}

/* Everything of the file but its bytes of vertices and triangles; returns its length. */
static size_t write_json(char *text, size_t room, uint64_t *seed)
{
    const unsigned mesh_bytes = 12 * VERTICES + 12 * TRIANGLES;
    size_t n = (size_t)snprintf(text, room, "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,"
                                "\"buffers\":[{\"byteLength\":%u}]", SHAPES * mesh_bytes);
    for (int list = 0; list < 3; list++) {
        static const char *const names[3] = { "bufferViews", "accessors", "meshes" };
        n += (size_t)snprintf(text + n, room - n, ",\"%s\":[", names[list]);
        for (unsigned i = 0; i < SHAPES; i++)
            n += list == 0 ? (size_t)snprintf(text + n, room - n,
                                 "%s{\"buffer\":0,\"byteOffset\":%u,\"byteLength\":%u},"
                                 "{\"buffer\":0,\"byteOffset\":%u,\"byteLength\":%u}", i ? "," : "", i * mesh_bytes,
                                 12u * VERTICES, i * mesh_bytes + 12u * VERTICES, 12u * TRIANGLES)
                 : list == 1 ? (size_t)snprintf(text + n, room - n,
                                   "%s{\"bufferView\":%u,\"componentType\":5126,\"count\":%u,\"type\":\"VEC3\","
                                   "\"min\":[-0.7,-0.7,-0.7],\"max\":[0.7,0.7,0.7]},{\"bufferView\":%u,"
                                   "\"componentType\":5125,\"count\":%u,\"type\":\"SCALAR\"}", i ? "," : "", 2 * i,
                                   (unsigned)VERTICES, 2 * i + 1, 3u * TRIANGLES)
                             : (size_t)snprintf(text + n, room - n,
                                   "%s{\"primitives\":[{\"attributes\":{\"POSITION\":%u},\"indices\":%u}]}",
                                   i ? "," : "", 2 * i, 2 * i + 1);
        n += (size_t)snprintf(text + n, room - n, "]");
    }
    n += (size_t)snprintf(text + n, room - n, ",\"nodes\":[");
    for (int i = 0; i < BN_STONES; i++) {
        float q[4], length = 0;
        for (int k = 0; k < 4; k++) {
            q[k] = bn_random_in(seed, -1, 1);
            length += q[k] * q[k];
        }
        for (int k = 0; k < 4; k++)
            q[k] /= sqrtf(fmaxf(length, 1e-6f));
        const float x = (float)(i % ACROSS) + bn_random_in(seed, -0.25f, 0.25f);
        const float y = bn_random_in(seed, -0.25f, 0.25f);
        const float z = (float)(i / ACROSS) + bn_random_in(seed, -0.25f, 0.25f), size = bn_random_in(seed, 0.6f, 1.3f);
        n += (size_t)snprintf(text + n, room - n, "%s{\"mesh\":%d,\"translation\":[%.5f,%.5f,%.5f],"
                              "\"rotation\":[%.6f,%.6f,%.6f,%.6f],\"scale\":[%.5f,%.5f,%.5f]}", i ? "," : "", i % SHAPES,
                              (double)x, (double)y, (double)z, (double)q[0], (double)q[1], (double)q[2], (double)q[3],
                              (double)size, (double)size, (double)size);
    }
    n += (size_t)snprintf(text + n, room - n, "],\"scenes\":[{\"nodes\":[");
    for (int i = 0; i < BN_STONES; i++)
        n += (size_t)snprintf(text + n, room - n, "%s%d", i ? "," : "", i);
    n += (size_t)snprintf(text + n, room - n, "]}]}");
    while (n % 4)
        text[n++] = ' ';
    return n;
}

int bn_stones_write(const char *path)
{
    enum { ROOM = 256 * BN_STONES + 8192, DATA = SHAPES * 12 * (VERTICES + TRIANGLES) };
    char *text = malloc(ROOM);
    FILE *file = text ? fopen(path, "wb") : NULL;
    uint64_t seed = 7;
    size_t length;
    if (!file) {
        free(text);
        return bn_failed(path, "cannot be written");
    }
    length = write_json(text, ROOM, &seed);
    fwrite("glTF", 1, 4, file);
    put_word(file, 2);
    put_word(file, (uint32_t)(12 + 8 + length + 8 + DATA));
    put_word(file, (uint32_t)length);
    fwrite("JSON", 1, 4, file);
    fwrite(text, 1, length, file);
    put_word(file, DATA);
    fwrite("BIN", 1, 4, file);
    for (int i = 0; i < SHAPES; i++) {
        put_vertices(file, &seed);
        put_triangles(file);
    }
    free(text);
    if (ferror(file) | fclose(file))
        return bn_failed(path, "cannot be written");
    return 0;
}
