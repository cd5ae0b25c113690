/* lean_program.h - a build, its file and questions of every kind, for csm.h with or without its optional parts: prints
   the same numbers whichever parts there are. */
#define CSM_IMPLEMENTATION
#include "csm.h"
#include <stdio.h>
#include <stdlib.h>

enum { POINTS = 600 };

static float random_in(uint32_t *state, float low, float high)
{
    *state = *state * 1664525u + 1013904223u;
    return low + (high - low) * (float)(*state >> 8) / 16777216.0f;
}

/* Mean of the answers for one way of asking; -1 where the call fails. */
static double asked(const cohsm_maps *maps, cohsm_query query)
{
    static float visible[POINTS];
    double sum = 0;
    int i;
    if (cohsm_visible(maps, &query, visible, NULL) != COHSM_OK) return -1;
    for (i = 0; i < POINTS; i++) sum += (double)visible[i];
    return sum / (double)POINTS;
}

int main(void)
{
    static const float corners[] = { 0, 1, 0,  1, 0, 0,  0, 0, 1,  -1, 0, 0,  0, 0, -1,  0, -1, 0 };
    static const uint32_t triangles[] = { 0, 2, 1,  0, 3, 2,  0, 4, 3,  0, 1, 4,
                                          5, 1, 2,  5, 2, 3,  5, 3, 4,  5, 4, 1 };
    static float points[3 * POINTS], lights[3 * POINTS];
    static const cohsm_filter filters[3] = { COHSM_FILTER_NEAREST, COHSM_FILTER_PCF, COHSM_FILTER_ROULETTE };
    cohsm_mesh mesh;
    cohsm_desc desc;
    cohsm_query query;
    cohsm_maps *maps, *again;
    cohsm_report report;
    const void *bytes;
    size_t count, i;
    uint32_t state = 7;
    double mean;
    int f;

    memset(&mesh, 0, sizeof mesh);
    memset(&query, 0, sizeof query);
    mesh.positions = corners;
    mesh.vertex_count = 6;
    mesh.indices = triangles;
    mesh.index_count = 24;
    memset(&desc, 0, sizeof desc);
    desc.domain.side[0] = desc.domain.side[1] = 32;
    desc.map_side = 64;
    if (cohsm_build(&desc, &mesh, &maps, NULL) != COHSM_OK) return 1;
    if (cohsm_verify(maps, NULL, &mesh, &report) != COHSM_OK || report.wrong) return 2;
    bytes = cohsm_data(maps, &count);
    if (cohsm_open(bytes, count, NULL, &again) != COHSM_OK) return 3;
    cohsm_free(maps);
    printf("%lu bytes\n", (unsigned long)count);
    for (i = 0; i < 3 * POINTS; i++) points[i] = random_in(&state, -2, 2);
    for (i = 0; i < 3 * POINTS; i++) lights[i] = random_in(&state, -1, 1);
    query.positions = points;
    query.count = POINTS;
    query.lights = lights;
    for (f = 0; f < 6; f++) {
        query.filter = filters[f % 3];
        query.one_light = f > 2;
        mean = asked(again, query);
        if (!(mean > 0.3 && mean < 0.99)) return 4;
        printf("%.17g\n", mean);
    }
    cohsm_free(again);
#ifdef COHSM_WITHOUT_PACK
    {                                   /* a packed file is named, not called damaged */
        const unsigned char packed[16] = { 'D', 'C', 'S', 'P', 1 };
        if (cohsm_open(packed, sizeof packed, NULL, &again) != COHSM_ERR_MISMATCH) return 5;
    }
#endif
    return 0;
}
