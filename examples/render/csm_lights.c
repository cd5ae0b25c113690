/* csm_lights.c - the scene's lights as those of lightsampling.h, and the places on them that maps are made of.

   Sun, sky, spot, point and the area lights have shapes of their own there. Emissive triangles are gathered by object
   and material: a flat parallelogram becomes a rectangle, the rest a mesh with a place for each map. */
#include "csm_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MOST_LINE_MAPS 1024u     /* of a domain of one dimension */

/* ---- lights ---- */

static cs_light *add_light(cs_state *state, char *error)
{
    cs_light *grown = realloc(state->lights, (state->light_count + 1) * sizeof *grown);
    if (!grown) {
        cs_out_of_memory(error);
        return NULL;
    }
    state->lights = grown;
    memset(&grown[state->light_count], 0, sizeof *grown);
    return &grown[state->light_count++];
}

static int make_emitter(cs_state *state, cs_light *light, const lsamp_light_desc *desc, char *error)
{
    lsamp_result result;
    light->desc = *desc;
    light->bytes = lsamp_light_bytes(desc);
    if (!light->bytes)
        return cs_failed("a light", COHSM_ERR_DESC, error);
    light->memory = malloc(light->bytes);
    if (!light->memory)
        return cs_out_of_memory(error);
    result = lsamp_light_init(desc, light->memory, light->bytes, &light->emitter, NULL);
    if (result != LSAMP_OK)
        return cs_failed("a light", (cohsm_result)result, error);
    light->is_delta = desc->kind == LSAMP_LIGHT_SUN || desc->kind == LSAMP_LIGHT_SPOT ||
                      desc->kind == LSAMP_LIGHT_POINT;
    light->at_infinity = desc->kind == LSAMP_LIGHT_SUN || desc->kind == LSAMP_LIGHT_ENVIRONMENT;
    state->area_count += !light->is_delta;
    return 0;
}

static void copy3(float *to, const float *from)
{
    memcpy(to, from, 3 * sizeof *to);
}

static int add_listed(cs_state *state, const ex_light *source, char *error)
{
    static const lsamp_light_kind shapes[] = {
        LSAMP_LIGHT_SUN, LSAMP_LIGHT_SPOT, LSAMP_LIGHT_POINT, LSAMP_LIGHT_SPHERE, LSAMP_LIGHT_RECTANGLE,
        LSAMP_LIGHT_DISC, LSAMP_LIGHT_LINE
    };
    lsamp_light_desc desc;
    cs_light *light;
    if (!(source->value[0] > 0 || source->value[1] > 0 || source->value[2] > 0))
        return 0;
    light = add_light(state, error);
    if (!light)
        return -1;
    memset(&desc, 0, sizeof desc);
    desc.kind = shapes[source->kind];
    copy3(desc.position, source->position);
    copy3(desc.direction, source->direction);
    copy3(light->sun, source->direction);
    copy3(desc.u, source->u);
    copy3(desc.v, source->v);
    desc.radius = source->radius;
    copy3(desc.radiance, source->value);
    if (source->kind == EX_LIGHT_SPOT && source->cos_half_angle > 1e-3f) {
        desc.cone_half_angle = acosf(source->cos_half_angle);
    } else if (source->kind == EX_LIGHT_SPOT) {
        desc.kind = LSAMP_LIGHT_POINT;
        light->wide_spot = source;
    }
    return make_emitter(state, light, &desc, error);
}

static int add_sky(cs_state *state, const ex_sky *sky, char *error)
{
    lsamp_light_desc desc;
    cs_light *light = add_light(state, error);
    if (!light)
        return -1;
    memset(&desc, 0, sizeof desc);
    desc.kind = LSAMP_LIGHT_ENVIRONMENT;
    desc.radiance[0] = desc.radiance[1] = desc.radiance[2] = 1;
    desc.texels = sky->rgb;
    desc.width = sky->width;
    desc.height = sky->height;
    desc.rotation = sky->rotation;
    return make_emitter(state, light, &desc, error);
}

/* ---- emissive meshes ---- */

/* Places of maps stand off the emitting surface, which would hide everything from itself. */
static float clearance(const rd_job *job)
{
    return 1e-4f * job->radius;
}

static void oriented(const rd_emitter *e, int back, float v[9])
{
    for (int i = 0; i < 3; i++)
        copy3(v + 3 * i, e->v[back ? (3 - i) % 3 : i]);
}

/* Two triangles that share an edge and make a flat parallelogram: corner, u and v with u x v along their normal. */
static int is_parallelogram(const float *a, const float *b, float area, lsamp_light_desc *desc)
{
    float size = sqrtf(area);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const float *corner = a + 3 * i, *p = a + 3 * ((i + 1) % 3), *q = a + 3 * ((i + 2) % 3);
            const float *fourth = b + 3 * j, *q2 = b + 3 * ((j + 1) % 3), *p2 = b + 3 * ((j + 2) % 3);
            float off = 0;
            for (int k = 0; k < 3; k++)
                off = fmaxf(off, fmaxf(fmaxf(fabsf(p[k] - p2[k]), fabsf(q[k] - q2[k])),
                                       fabsf(p[k] + q[k] - corner[k] - fourth[k])));
            if (off > 1e-4f * size)
                continue;
            for (int k = 0; k < 3; k++) {
                desc->position[k] = corner[k];
                desc->u[k] = p[k] - corner[k];
                desc->v[k] = q[k] - corner[k];
            }
            return 1;
        }
    return 0;
}

/* One side of the triangles of one object with one material. */
static int add_emissive(cs_state *state, const rd_job *job, const rd_emitter *group, size_t count, int back,
                        char *error)
{
    lsamp_light_desc desc;
    lsamp_mesh mesh;
    cs_light *light = add_light(state, error);
    float *corners = light ? malloc(9 * count * sizeof *corners) : NULL;
    int result;
    if (!corners)
        return light ? cs_out_of_memory(error) : -1;
    for (size_t i = 0; i < count; i++)
        oriented(&group[i], back, corners + 9 * i);
    light->object = group->object;
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = corners;
    mesh.vertex_count = 3 * count;
    memset(&desc, 0, sizeof desc);
    copy3(desc.radiance, job->scene->materials[group->material].emission);
    if (count == 2 && is_parallelogram(corners, corners + 9, group->area, &desc)) {
        desc.kind = LSAMP_LIGHT_RECTANGLE;
        for (int k = 0; k < 3; k++)
            desc.position[k] += clearance(job) * (back ? -group->normal[k] : group->normal[k]);
    } else {
        light->is_mesh = 1;
        desc.kind = LSAMP_LIGHT_MESH;
        desc.mesh = &mesh;
        desc.place_count = state->options.light_side * state->options.light_side;
        desc.radius = clearance(job);
    }
    result = make_emitter(state, light, &desc, error);
    light->desc.mesh = NULL;                     /* copied */
    free(corners);
    return result;
}

static int by_owner(const void *a, const void *b)
{
    const rd_emitter *x = a, *y = b;
    if (x->object != y->object)
        return x->object < y->object ? -1 : 1;
    if (x->material != y->material)
        return x->material < y->material ? -1 : 1;
    return x->triangle < y->triangle ? -1 : x->triangle > y->triangle;
}

static int add_emitters(cs_state *state, const rd_job *job, char *error)
{
    size_t count = job->emitter_count, end;
    rd_emitter *sorted = malloc((count + 1) * sizeof *sorted);
    int result = 0;
    if (!sorted)
        return cs_out_of_memory(error);
    if (count)
        memcpy(sorted, job->emitters, count * sizeof *sorted);
    qsort(sorted, count, sizeof *sorted, by_owner);
    for (size_t i = 0; i < count && result == 0; i = end) {
        int sides = 1 + (job->scene->materials[sorted[i].material].double_sided != 0);
        for (end = i + 1; end < count && sorted[end].object == sorted[i].object &&
                          sorted[end].material == sorted[i].material;)
            end++;
        for (int back = 0; back < sides && result == 0; back++)
            result = add_emissive(state, job, &sorted[i], end - i, back, error);
    }
    free(sorted);
    return result;
}

int cs_lights_build(cs_state *state, const rd_job *job, char *error)
{
    for (uint32_t i = 0; i < job->scene->light_count; i++)
        if (add_listed(state, &job->scene->lights[i], error) != 0)
            return -1;
    if (job->scene->sky.width && add_sky(state, &job->scene->sky, error) != 0)
        return -1;
    return add_emitters(state, job, error);
}

/* ---- places of maps ---- */

int cs_light_domain(const cs_light *light, const cs_options *options, cohsm_domain *out, char *error)
{
    uint32_t n = options->light_side * options->light_side;
    lsamp_domain domain;
    lsamp_result result = lsamp_light_domain(light->emitter, &domain);
    if (result != LSAMP_OK)
        return cs_failed("a light", (cohsm_result)result, error);
    memset(out, 0, sizeof *out);
    out->kind = (cohsm_domain_kind)domain.kind;
    memcpy(out->side, domain.side, sizeof out->side);
    copy3(out->origin, domain.origin);
    copy3(out->u, domain.u);
    copy3(out->v, domain.v);
    out->locations = domain.locations;
    out->location_count = domain.location_count;
    if (light->is_mesh)                          /* a place for each map already */
        return 0;
    out->side[0] = out->side[1] = options->light_side;
    if (out->kind == COHSM_DOMAIN_LINE) {
        out->side[0] = n < MOST_LINE_MAPS ? n : MOST_LINE_MAPS;
        out->side[1] = 1;
    }
    return 0;
}

void cs_light_free(cs_light *light)
{
    free(light->memory);
    cs_casters_free(&light->own);
}
