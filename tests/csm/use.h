/* use.h - calls every function of csm.h on maps that a file gave, whatever it holds; for the file test and the fuzz
   targets. Include csm.h before. Returns 0 if an answer is out of range. */
#ifndef CSM_USE_H
#define CSM_USE_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

static inline int use_queries(const cohsm_maps *maps, const cohsm_info *info)
{
    enum { N = 24 };
    static const float odd[6] = { 0.0f, -1.0f, 1e30f, 1e-40f, 0.5f, 1.0f };
    float p[N][3], l[N][3], v[N];
    uint32_t self[N];
    cohsm_instance inst[2];
    size_t refused;
    int i, k, light, filter;

    memset(inst, 0, sizeof inst);
    for (k = 0; k < 2; k++) {
        inst[k].maps = maps;
        for (i = 0; i < 16; i += 5) inst[k].transform[i] = i < 15 ? (k ? 0.5f : 1.0f) : 1.0f;
        inst[k].transform[12] = info->center[0];
    }
    for (light = 0; light < 4; light++)
        for (filter = 0; filter < 3; filter++) {
            int one = (int)((uint32_t)(light + filter) + info->map_count + info->map_side) & 1;      /* by turns */
            cohsm_query q = { 0 };
            for (i = 0; i < N; i++) {
                self[i] = (uint32_t)(i % 4);
                for (k = 0; k < 3; k++) {
                    int h = i * 37 + k * 101 + light * 7 + filter * 13;
                    p[i][k] = info->center[k] + info->radius * ((float)(h % 61) / 30.0f - 1.0f);
                    l[i][k] = (float)(h % 53) / 26.0f - 1.0f;
                    if (i % 7 == 6) p[i][k] = odd[h % 6];
                    if (i % 5 == 4) l[i][k] = odd[h % 6];
                    if (light == COHSM_LIGHT_POSITION) l[i][k] = info->center[k] + 3 * info->radius * l[i][k];
                    if (light == COHSM_LIGHT_PARAMETER) l[i][k] = 0.5f * l[i][k] + 0.5f;
                }
                if (light == COHSM_LIGHT_INDEX) {
                    uint32_t index =
                        (uint32_t)(((uint64_t)(uint32_t)i * 2654435761u % 1000u) * info->map_count / 1000u);
                    memcpy(l[i], &index, 4);
                }
            }
            q.positions = p[0];
            q.lights = l[0];
            q.light_stride = 12;
            q.count = N;
            q.one_light = one;
            q.light_kind = (cohsm_light_kind)light;
            q.filter = (cohsm_filter)filter;
            q.bias = one ? 1.0f : -1.0f;
            q.seed = 3;
            if (cohsm_visible(maps, &q, v, &refused) == COHSM_OK)
                for (i = 0; i < N; i++)
                    if (!((v[i] >= 0.0f && v[i] <= 1.00001f) || (v[i] < 0.0f && v[i] > -1.00001f))) return 0;
            q.entities = self;
            (void)cohsm_visible_scene(inst, 2, &q, v, &refused);
        }
    return 1;
}

static inline int use_maps(const cohsm_maps *maps)
{
    cohsm_info info;
    cohsm_maps *other = NULL;
    const cohsm_maps *list[2];
    float at[4];
    size_t size = 0;
    uint16_t *depths;
    void *copy;
    uint32_t i, step;
    int ok;

    cohsm_get_info(maps, &info);
    if (!cohsm_data(maps, &size) || size != info.bytes) return 0;
    if (!use_queries(maps, &info)) return 0;
    step = info.view_count / 5 + 1;
    depths = (uint16_t *)malloc(2 * (size_t)info.map_side * info.map_side);
    copy = malloc(info.bytes);
    if (!depths || !copy) abort();
    for (i = 0; i < info.view_count; i += step) (void)cohsm_depths(maps, i, depths);
    (void)cohsm_depths(maps, info.view_count - 1, depths);
    (void)cohsm_location(maps, info.map_count - 1, at);
    /* what was accepted once is accepted again */
    ok = cohsm_write(maps, copy, info.bytes) == COHSM_OK && cohsm_open(copy, info.bytes, NULL, &other) == COHSM_OK;
    cohsm_free(other);
    other = NULL;
    list[0] = maps;
    list[1] = maps;
    if (cohsm_merge(list, 1, NULL, &other) == COHSM_OK) {
        ok &= use_queries(other, &info);
        cohsm_free(other);
    }
    if (cohsm_merge(list, 2, NULL, &other) == COHSM_OK) cohsm_free(other);
    /* views of a small scene against it; where there are few entries */
    if ((uint64_t)info.view_count * info.map_side * info.map_side < 4000u) {
        static const uint32_t index[6] = { 0, 1, 2, 1, 2, 3 };
        float p[12];
        cohsm_mesh mesh;
        cohsm_report report;
        for (i = 0; i < 12; i++) p[i] = info.center[i % 3] + info.radius * 0.5f * (float)((int)(i * 7 % 5) - 2) / 4.0f;
        memset(&mesh, 0, sizeof mesh);
        mesh.positions = p;
        mesh.vertex_count = 4;
        mesh.indices = index;
        mesh.index_count = 6;
        (void)cohsm_verify(maps, NULL, &mesh, &report);
    }
    free(copy);
    free(depths);
    return ok;
}

/* Packed and opened again it is the same block. */
static inline int use_packed(const cohsm_maps *maps)
{
    cohsm_maps *back = NULL;
    void *data = NULL;
    size_t size = 0, a, b;
    int ok;

    if (cohsm_pack(maps, NULL, &data, &size) != COHSM_OK) return 1;      /* out of memory, or 4 GB */
    ok = cohsm_open(data, size, NULL, &back) == COHSM_OK;
    if (ok) {
        const void *p = cohsm_data(maps, &a), *q = cohsm_data(back, &b);
        ok = a == b && memcmp(p, q, a) == 0;
    }
    cohsm_free(back);
    free(data);
    return ok;
}

#endif
