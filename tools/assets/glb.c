/* glb - triangles from stdin to a .glb on stdout: an ASCII PLY, or the arrays "positions" and "cells" of the mesh
   modules of npm. Written by make assets. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void fail(const char *what)
{
    fprintf(stderr, "glb: %s\n", what);
    exit(1);
}

static char *read_all(size_t *size)
{
    char *text = NULL;
    size_t room = 0, got = 1;
    for (*size = 0; got; *size += got) {
        if (room - *size < 2) text = (char *)realloc(text, room = 2 * room + 65536);
        if (!text) fail("out of memory");
        got = fread(text + *size, 1, room - *size - 1, stdin);
    }
    text[*size] = 0;
    return text;
}

typedef struct numbers { double *value; size_t count, room; } numbers;

static void push(numbers *n, double value)
{
    if (n->count == n->room) n->value = (double *)realloc(n->value, (n->room = 2 * n->room + 1024) * sizeof(double));
    if (!n->value) fail("out of memory");
    n->value[n->count++] = value;
}

/* All numbers of an array of arrays; the text behind it. */
static char *take_array(char *at, numbers *out)
{
    int depth = 0;
    for (at = strchr(at, '['); at && *at;) {
        if (*at == '[') depth++;
        if (*at == ']' && --depth == 0) return at + 1;
        if (*at == '-' || *at == '.' || (*at >= '0' && *at <= '9')) push(out, strtod(at, &at));
        else at++;
    }
    fail("an array does not end");
    return at;
}

static void take_ply(char *text, numbers *positions, numbers *cells)
{
    unsigned long vertices = 0, faces = 0, i, k, n;
    int of_vertex = 0, wide = 0;
    char *line, *at;
    if (!strstr(text, "format ascii")) fail("only ASCII PLY");
    for (line = text; strncmp(line, "end_header", 10) != 0; line = at + 1) {
        if (sscanf(line, "element vertex %lu", &vertices) == 1) of_vertex = 1;
        else if (strncmp(line, "element", 7) == 0) of_vertex = 0;
        sscanf(line, "element face %lu", &faces);
        wide += of_vertex && strncmp(line, "property", 8) == 0;
        at = strchr(line, '\n');
        if (!at) fail("the header does not end");
    }
    at = strchr(line, '\n');
    if (!at || wide < 3) fail("no vertices");
    for (i = 0; i < vertices * (unsigned long)wide; i++) {
        double x = strtod(at, &at);
        if (i % (unsigned long)wide < 3) push(positions, x);
    }
    for (i = 0; i < faces; i++) {
        unsigned long corner[3] = { 0, 0, 0 };
        n = strtoul(at, &at, 10);
        if (n < 3 || n > 64) fail("a face of no known size");
        for (k = 0; k < n; k++) {           /* polygons as fans */
            unsigned long v = strtoul(at, &at, 10);
            if (k > 2) corner[1] = corner[2];
            corner[k < 2 ? k : 2] = v;
            if (k >= 2) {
                push(cells, (double)corner[0]);
                push(cells, (double)corner[1]);
                push(cells, (double)corner[2]);
            }
        }
    }
}

static void put_u32(uint32_t x)
{
    int i;
    for (i = 0; i < 4; i++) putchar((int)(x >> 8 * i & 255u));
}

static void write_glb(const numbers *positions, const numbers *cells)
{
    static char json[1024];
    double low[3] = { 1e30, 1e30, 1e30 }, high[3] = { -1e30, -1e30, -1e30 };
    uint32_t bytes = 4 * (uint32_t)(positions->count + cells->count), length;
    size_t i;
    for (i = 0; i < positions->count; i++) {
        double x = (double)(float)positions->value[i];
        low[i % 3] = x < low[i % 3] ? x : low[i % 3];
        high[i % 3] = x > high[i % 3] ? x : high[i % 3];
    }
    sprintf(json, "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
            "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}],"
            "\"buffers\":[{\"byteLength\":%lu}],"
            "\"bufferViews\":[{\"buffer\":0,\"byteLength\":%lu},{\"buffer\":0,\"byteOffset\":%lu,\"byteLength\":%lu}],"
            "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":%lu,\"type\":\"VEC3\","
            "\"min\":[%.9g,%.9g,%.9g],"
            "\"max\":[%.9g,%.9g,%.9g]},{\"bufferView\":1,\"componentType\":5125,\"count\":%lu,\"type\":\"SCALAR\"}]}",
            (unsigned long)bytes, 4ul * positions->count, 4ul * positions->count, 4ul * cells->count,
            (unsigned long)(positions->count / 3), low[0], low[1], low[2], high[0], high[1], high[2],
            (unsigned long)cells->count);
    while (strlen(json) % 4) strcat(json, " ");
    length = (uint32_t)strlen(json);
    put_u32(0x46546c67);
    put_u32(2);
    put_u32(12 + 8 + length + 8 + bytes);
    put_u32(length);
    put_u32(0x4e4f534a);
    fputs(json, stdout);
    put_u32(bytes);
    put_u32(0x004e4942);
    for (i = 0; i < positions->count; i++) {
        float x = (float)positions->value[i];
        uint32_t bits;
        memcpy(&bits, &x, 4);
        put_u32(bits);
    }
    for (i = 0; i < cells->count; i++) put_u32((uint32_t)cells->value[i]);
}

int main(void)
{
    size_t size, i;
    char *text = read_all(&size), *at, *cells_at;
    numbers positions = { NULL, 0, 0 }, cells = { NULL, 0, 0 };
    if (strncmp(text, "ply", 3) == 0) take_ply(text, &positions, &cells);
    else {
        at = strstr(text, "positions");
        cells_at = strstr(text, "cells");
        if (!at || !cells_at) fail("neither PLY nor positions and cells");
        take_array(at, &positions);
        take_array(cells_at, &cells);
    }
    if (!positions.count || positions.count % 3 || !cells.count || cells.count % 3 || positions.count > 100000000 ||
        cells.count > 100000000)
        fail("no triangles");
    for (i = 0; i < positions.count; i++)
        if (!isfinite(positions.value[i])) fail("a position is not finite");
    for (i = 0; i < cells.count; i++)
        if (!(cells.value[i] >= 0 && cells.value[i] < (double)(positions.count / 3)))
            fail("an index beyond the vertices");
    write_glb(&positions, &cells);
    return fflush(stdout) != 0;
}
