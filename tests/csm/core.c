/* core.c FILE - with the whole csm.h: builds maps, writes them to FILE and asks them. With a csm.h without the
   precomputation: opens FILE and asks its maps. Both print the same: the bits of every answer. tests/scripts/core.sh */

#define CSM_IMPLEMENTATION
#include "csm.h"

#include <stdio.h>

enum { POINTS = 500 };

static float random_in(uint32_t *state, float low, float high)
{
    *state = *state * 1664525u + 1013904223u;
    return low + (high - low) * (float)(*state >> 8) / 16777216.0f;
}

#ifdef COHSM_WITHOUT_BUILD
static cohsm_maps *maps_of(const char *path)
{
    static uint32_t file[1 << 18];
    cohsm_maps *maps = NULL;
    FILE *f = fopen(path, "rb");
    size_t bytes = f ? fread(file, 1, sizeof file, f) : 0;
    if (f) fclose(f);
    return cohsm_open(file, bytes, NULL, &maps) == COHSM_OK ? maps : NULL;
}
#else
static cohsm_maps *maps_of(const char *path)
{
    static const float corners[] = { 0, 1, 0,  1, 0, 0,  0, 0, 1,  -1, 0, 0,  0, 0, -1,  0, -1, 0 };
    static const uint32_t triangles[] = { 0, 2, 1,  0, 3, 2,  0, 4, 3,  0, 1, 4,
                                          5, 1, 2,  5, 2, 3,  5, 3, 4,  5, 4, 1 };
    cohsm_mesh mesh;
    cohsm_desc desc;
    cohsm_maps *maps = NULL;
    const void *block;
    size_t bytes;
    FILE *f;

    memset(&mesh, 0, sizeof mesh);
    mesh.positions = corners;
    mesh.vertex_count = 6;
    mesh.indices = triangles;
    mesh.index_count = 24;
    memset(&desc, 0, sizeof desc);
    desc.domain.side[0] = desc.domain.side[1] = 32;
    desc.map_side = 64;
    if (cohsm_build(&desc, &mesh, &maps, NULL) != COHSM_OK) return NULL;
    block = cohsm_data(maps, &bytes);
    f = fopen(path, "wb");
    if (!f || fwrite(block, 1, bytes, f) != bytes || fclose(f)) return NULL;
    return maps;
}
#endif

/* Returns 0 if a call fails or all answers are alike. */
static int ask(const cohsm_maps *maps, const cohsm_query *query, const float *transform)
{
    static float visible[POINTS];
    cohsm_instance instance;
    uint32_t bits, sum = 0;
    int i, lit = 0;

    instance.maps = maps;
    memcpy(instance.transform, transform, sizeof instance.transform);
    if (cohsm_visible_scene(&instance, 1, query, visible, NULL) != COHSM_OK) return 0;
    for (i = 0; i < POINTS; i++) {
        memcpy(&bits, &visible[i], 4);
        sum = (sum << 5 | sum >> 27) ^ bits;
        lit += visible[i] > 0.5f;
    }
    printf("%08lx %d\n", (unsigned long)sum, lit);
    return lit > POINTS / 10 && lit < POINTS;
}

int main(int count, char **arguments)
{
    static const float transform[16] = { 0, 2, 0, 0,  -2, 0, 0, 0,  0, 0, 2, 0,  0.5f, 0, 0, 1 };
    static const cohsm_filter filters[3] = { COHSM_FILTER_NEAREST, COHSM_FILTER_PCF, COHSM_FILTER_ROULETTE };
    static float points[3 * POINTS], lights[3 * POINTS];
    cohsm_maps *maps = count > 1 ? maps_of(arguments[1]) : NULL;
    cohsm_query query;
    cohsm_info info;
    uint32_t state = 7;
    int i, k, good = maps != NULL;

    for (i = 0; i < 3 * POINTS; i++) points[i] = random_in(&state, -3, 3);
    for (i = 0; i < 3 * POINTS; i++) lights[i] = random_in(&state, -1, 1);
    for (i = 0; i < 12 && good; i++) {
        memset(&query, 0, sizeof query);
        query.positions = points;
        query.count = POINTS;
        query.lights = lights;
        query.filter = filters[i % 3];
        query.one_light = i % 6 > 2;
        if (i >= 6) query.light_kind = COHSM_LIGHT_POSITION;
        for (k = 0; k < 3 * POINTS && i == 6; k++) lights[k] *= 12.0f;
        good = ask(maps, &query, transform);
    }
    if (!good) return 1;
    cohsm_get_info(maps, &info);
    printf("%lu segments, %lu bytes\n", (unsigned long)info.segment_count, (unsigned long)info.bytes);
    cohsm_free(maps);
    return 0;
}
