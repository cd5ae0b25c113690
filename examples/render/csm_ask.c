/* csm_ask.c - visibility queries of the technique csm in scenes of several objects: each object is asked about those
   samples only whose ray passes near it, the receiver's own object first. The answers are those of cohsm_visible_scene
   over all objects; only roulette draws other numbers. */
#include "csm_parts.h"

#include <math.h>
#include <string.h>

/* May the object's maps shadow the point? A map is of another direction than the ray, up to `slack` away, and a filter
   reads a pixel beside: the ray must pass the bounding sphere, widened by both, or the sphere must lie behind. */
static int is_near(const cs_reach *r, const float *p, const float *to_light)
{
    float v[3], d = 0, v2 = 0, w2 = 0, reach, across;
    for (int k = 0; k < 3; k++) {
        v[k] = r->center[k] - p[k];
        d += v[k] * to_light[k];
        v2 += v[k] * v[k];
        w2 += to_light[k] * to_light[k];
    }
    reach = r->radius + r->slack * sqrtf(v2);
    across = v2 * w2 - d * d;
    return across < reach * reach * w2 && (d > 0 || d * d < reach * reach * w2);
}

/* Those samples of a query that instance o may shadow: own = 1 the ones on it, 0 all others that are still lit. */
static size_t gather_near(const cs_casters *c, uint32_t o, int own, const cohsm_query *query, cs_near *near,
                          const float *visible)
{
    size_t n = 0;
    for (size_t i = 0; i < query->count; i++) {
        const float *p = query->positions + 3 * i;
        const float *light = (const float *)query->lights + (query->one_light ? 0 : 3 * i);
        float to_light[3];
        if ((query->entities[i] == o + 1) != own || !(visible[i] > 0))
            continue;
        for (int k = 0; k < 3; k++)
            to_light[k] = query->light_kind == COHSM_LIGHT_POSITION ? light[k] - p[k] : light[k];
        if (!is_near(&c->reach[o], p, to_light))
            continue;
        memcpy(near->point + 3 * n, p, 3 * sizeof *p);
        memcpy(near->light + 3 * n, light, 3 * sizeof *light);
        near->sample[n++] = (uint32_t)i;
    }
    return n;
}

cohsm_result cs_visible(const cs_casters *c, const cohsm_query *query, cs_near *near, float *visible, size_t *refused)
{
    cohsm_query some = *query;
    if (c->count < 2 || (query->light_kind != COHSM_LIGHT_DIRECTION && query->light_kind != COHSM_LIGHT_POSITION))
        return cohsm_visible_scene(c->instances, c->count, query, visible, refused);
    some.entities = NULL;
    *refused = 0;
    for (size_t i = 0; i < query->count; i++)
        visible[i] = 1;
    for (int own = 1; own >= 0; own--)
        for (uint32_t o = 0; o < c->count; o++) {
            size_t here = 0;
            cohsm_result result;
            some.count = gather_near(c, o, own, query, near, visible);
            if (!some.count)
                continue;
            some.positions = near->point;
            some.lights = query->one_light ? query->lights : near->light;
            some.seed = query->seed + o * 0x9e3779b9u;
            result = cohsm_visible_scene(c->instances + o, 1, &some, near->answer, &here);
            if (result != COHSM_OK)
                return result;
            *refused += here;
            for (size_t i = 0; i < some.count; i++) {
                float *v = &visible[near->sample[i]];
                *v = near->answer[i] < 0 ? near->answer[i] : *v * near->answer[i];
            }
        }
    return COHSM_OK;
}
