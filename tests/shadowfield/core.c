/* core.c FILE - with the whole shadowfield.h: builds a field, writes it to FILE and shades points with it. With a
   shadowfield.h without the precomputation: opens FILE and shades the same points. Both print the same: the bits of all
   results. tests/scripts/core.sh */

#define SFIELD_NO_SIMD      /* as the core is: instruction sets round otherwise */
#define SHADOWFIELD_IMPLEMENTATION
#include "shadowfield.h"

#include <stdio.h>

enum { POINTS = 400, SKY = 8, ROOM = 1 << 21 };

static uint8_t file[ROOM];

static float random_in(uint32_t *state, float low, float high)
{
    *state = *state * 1664525u + 1013904223u;
    return low + (high - low) * (float)(*state >> 8) / 16777216.0f;
}

#ifdef SFIELD_WITHOUT_BUILD
static sfield_field *field_of(const char *path)
{
    sfield_field *field = NULL;
    FILE *f = fopen(path, "rb");
    size_t bytes = f ? fread(file, 1, sizeof file, f) : 0;
    if (f) fclose(f);
    return sfield_open(file, bytes, NULL, &field) == SFIELD_OK ? field : NULL;
}
#else
static sfield_field *field_of(const char *path)
{
    static const float corners[] = { 0, 1, 0,  1, 0, 0,  0, 0, 1,  -1, 0, 0,  0, 0, -1,  0, -1, 0 };
    static const uint32_t triangles[] = { 0, 2, 1,  0, 3, 2,  0, 4, 3,  0, 1, 4,
                                          5, 1, 2,  5, 2, 3,  5, 3, 4,  5, 4, 1 };
    sfield_desc desc;
    sfield_mesh mesh;
    sfield_field *field = NULL;
    size_t bytes;
    FILE *f;

    memset(&desc, 0, sizeof desc);
    memset(&mesh, 0, sizeof mesh);
    desc.shell_count = 6;
    desc.position_side = 4;
    mesh.positions = corners;
    mesh.vertex_count = 6;
    mesh.indices = triangles;
    mesh.index_count = 24;
    if (sfield_build(&desc, &mesh, &field, NULL) != SFIELD_OK) return NULL;
    bytes = sfield_bytes(field);
    if (bytes > sizeof file || sfield_write(field, file, sizeof file) != SFIELD_OK) return NULL;
    f = fopen(path, "wb");
    if (!f || fwrite(file, 1, bytes, f) != bytes || fclose(f)) return NULL;
    return field;
}
#endif

static int print_bits(const char *name, const float *values, size_t count)
{
    uint32_t bits, sum = 0;
    size_t i, differ = 0;
    for (i = 0; i < count; i++) {
        memcpy(&bits, &values[i], 4);
        sum = (sum << 5 | sum >> 27) ^ bits;
        differ += values[i] > values[0] || values[i] < values[0];
    }
    printf("%s %08lx\n", name, (unsigned long)sum);
    return differ > count / 2;
}

int main(int count, char **arguments)
{
    static const float transform[16] = { 0, 2, 0, 0,  -2, 0, 0, 0,  0, 0, 2, 0,  0.5f, 0, 0, 1 };
    static float positions[3 * POINTS], normals[3 * POINTS], sky[3 * SKY * SKY], rgb[3 * POINTS], ambient[POINTS],
        coefs[16 * POINTS];
    sfield_field *field = count > 1 ? field_of(arguments[1]) : NULL;
    sfield_scene *scene = NULL;
    sfield_entity entities[2];
    sfield_points points;
    uint32_t state = 7;
    int i, good;

    if (!field || sfield_scene_create(NULL, &scene) != SFIELD_OK) return 1;
    for (i = 0; i < 3 * POINTS; i++) positions[i] = random_in(&state, -4, 4);
    for (i = 0; i < POINTS; i++) normals[3 * i + 1] = 1;
    for (i = 0; i < 3 * SKY * SKY; i++) sky[i] = random_in(&state, 0, 2);
    memset(entities, 0, sizeof entities);
    memset(&points, 0, sizeof points);
    entities[0].occlusion = entities[1].occlusion = field;
    memcpy(entities[0].transform, transform, sizeof transform);
    entities[1].transform[0] = entities[1].transform[5] = entities[1].transform[10] = entities[1].transform[15] = 1;
    entities[1].transform[13] = 3;
    points.count = POINTS;
    points.positions = positions;
    points.normals = normals;
    points.rgb = rgb;
    points.ambient = ambient;
    good = sfield_scene_entities(scene, entities, 2) == SFIELD_OK &&
           sfield_scene_environment(scene, sky, SKY, SKY, NULL) == SFIELD_OK &&
           sfield_shade(scene, &points, 1, NULL) == SFIELD_OK &&
           sfield_query(field, POINTS, positions, 0, coefs) == SFIELD_OK &&
           print_bits("rgb", rgb, 3 * POINTS) && print_bits("ambient", ambient, POINTS) &&
           print_bits("coefs", coefs, 16 * POINTS) &&
           sfield_ambient(field, POINTS, positions, ambient) == SFIELD_OK && print_bits("open", ambient, POINTS);
    sfield_scene_free(scene);
    sfield_free(field);
    return !good;
}
