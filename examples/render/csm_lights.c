/* csm_lights.c - the scene's lights as emitters of csm.h, and the places on them that maps are made of.

   Sun, sky, spot, point and the area lights have shapes of their own there. Emissive triangles are gathered by object
   and material: a flat parallelogram becomes a rectangle; the rest is cut into patches that are equal in area at most
   and put in the order of a space-filling curve, so that the one parameter of a table of maps runs along them. */
#include "csm_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MOST_LINE_MAPS 1024u     /* of a domain of one dimension */
#define PATCHES_PER_MAP 2u

/* ---- patches of an emissive mesh ---- */

typedef struct patch {
    float    v[3][3], normal[3];
    float    area;
    uint64_t key;                /* place on the curve */
    size_t   number;             /* as they were made: breaks ties, so that the order is the same everywhere */
    double   end;                /* share of all area up to the end of this one */
} patch;

struct cs_patches { patch *at; size_t count, room; double area; };

static int add_patch(cs_patches *p, const patch *one)
{
    if (p->count == p->room) {
        patch *grown = realloc(p->at, (p->room = 2 * p->room + 64) * sizeof *grown);
        if (!grown)
            return -1;
        p->at = grown;
    }
    p->at[p->count] = *one;
    p->at[p->count].number = p->count;
    p->count++;
    return 0;
}

/* Halves the longest edge until the pieces are small enough. */
static int add_pieces(cs_patches *p, const patch *one, float most_area)
{
    float longest = -1;
    int edge = 0, next;
    patch half[2];
    if (one->area <= most_area)
        return add_patch(p, one);
    for (int i = 0; i < 3; i++) {
        float length = 0;
        for (int k = 0; k < 3; k++) {
            float d = one->v[(i + 1) % 3][k] - one->v[i][k];
            length += d * d;
        }
        if (length > longest) {
            longest = length;
            edge = i;
        }
    }
    next = (edge + 1) % 3;
    half[0] = half[1] = *one;
    for (int k = 0; k < 3; k++)
        half[0].v[next][k] = half[1].v[edge][k] = 0.5f * (one->v[edge][k] + one->v[next][k]);
    half[0].area = half[1].area = 0.5f * one->area;
    return add_pieces(p, &half[0], most_area) || add_pieces(p, &half[1], most_area) ? -1 : 0;
}

static uint64_t spread_bits(uint64_t x)          /* 16 bits to every third of 48 */
{
    uint64_t out = 0;
    for (int bit = 0; bit < 16; bit++)
        out |= (x >> bit & 1) << 3 * bit;
    return out;
}

/* Pieces that face the same way lie together, so that a thin plate's sides do not mix; among them a Morton curve. */
static void set_key(patch *p, const float *low, float size)
{
    int axis = 0;
    p->key = 0;
    for (int k = 1; k < 3; k++)
        if (fabsf(p->normal[k]) > fabsf(p->normal[axis]))
            axis = k;
    for (int k = 0; k < 3; k++) {
        float x = ((p->v[0][k] + p->v[1][k] + p->v[2][k]) / 3 - low[k]) / size;
        x = x > 0 ? x < 1 ? x : 1 : 0;
        p->key |= spread_bits((uint64_t)(x * 65535)) << k;
    }
    p->key |= (uint64_t)(2 * axis + (p->normal[axis] < 0)) << 48;
}

static int by_key(const void *a, const void *b)
{
    const patch *x = a, *y = b;
    if (x->key != y->key)
        return x->key < y->key ? -1 : 1;
    return x->number < y->number ? -1 : 1;
}

static void put_in_order(cs_patches *p)
{
    float low[3], high[3], size = 1e-30f;
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        low[k] = high[k] = p->at[0].v[0][k];
        for (size_t i = 0; i < p->count; i++)
            for (int j = 0; j < 3; j++) {
                low[k] = fminf(low[k], p->at[i].v[j][k]);
                high[k] = fmaxf(high[k], p->at[i].v[j][k]);
            }
        size = fmaxf(size, high[k] - low[k]);
    }
    for (size_t i = 0; i < p->count; i++)
        set_key(&p->at[i], low, size);
    qsort(p->at, p->count, sizeof *p->at, by_key);
    for (size_t i = 0; i < p->count; i++) {
        sum += (double)p->at[i].area;
        p->at[i].end = sum;
    }
    p->area = sum;
    for (size_t i = 0; i < p->count; i++)
        p->at[i].end /= sum;
}

static const patch *find_patch(const cs_patches *p, double x)
{
    size_t low = 0, high = p->count - 1;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (p->at[middle].end > x)
            high = middle;
        else
            low = middle + 1;
    }
    return &p->at[low];
}

static void point_of_mesh(void *user, float time, const float x[3], float position[3], float normal[3], float *area)
{
    const cs_patches *patches = user;
    const patch *p = find_patch(patches, (double)x[0]);
    float root = sqrtf(x[1]), a = 1 - root, b = root * (1 - x[2]), c = root * x[2];
    (void)time;
    for (int k = 0; k < 3; k++) {
        position[k] = a * p->v[0][k] + b * p->v[1][k] + c * p->v[2][k];
        normal[k] = p->normal[k];
    }
    *area = (float)patches->area;
}

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

static int make_emitter(cs_state *state, cs_light *light, const cohsm_emitter_desc *desc, char *error)
{
    cohsm_result result;
    light->desc = *desc;
    light->bytes = cohsm_emitter_size(desc);
    if (!light->bytes)
        return cs_failed("a light", COHSM_ERR_DESC, error);
    light->memory = malloc(light->bytes);
    if (!light->memory)
        return cs_out_of_memory(error);
    result = cohsm_emitter_build(desc, light->memory, light->bytes, &light->emitter, NULL);
    if (result != COHSM_OK)
        return cs_failed("a light", result, error);
    light->is_delta = desc->shape == COHSM_SHAPE_SUN || desc->shape == COHSM_SHAPE_SPOT ||
                      desc->shape == COHSM_SHAPE_POINT;
    light->at_infinity = desc->shape == COHSM_SHAPE_SUN || desc->shape == COHSM_SHAPE_ENVIRONMENT;
    state->area_count += !light->is_delta;
    return 0;
}

static void copy3(float *to, const float *from)
{
    memcpy(to, from, 3 * sizeof *to);
}

static int add_listed(cs_state *state, const ex_light *source, char *error)
{
    static const cohsm_shape shapes[] = {
        COHSM_SHAPE_SUN, COHSM_SHAPE_SPOT, COHSM_SHAPE_POINT, COHSM_SHAPE_SPHERE, COHSM_SHAPE_RECTANGLE,
        COHSM_SHAPE_DISC, COHSM_SHAPE_LINE
    };
    cohsm_emitter_desc desc;
    cs_light *light;
    if (!(source->value[0] > 0 || source->value[1] > 0 || source->value[2] > 0))
        return 0;
    light = add_light(state, error);
    if (!light)
        return -1;
    memset(&desc, 0, sizeof desc);
    desc.shape = shapes[source->kind];
    copy3(desc.position, source->position);
    copy3(desc.direction, source->direction);
    copy3(light->sun, source->direction);
    copy3(desc.u, source->u);
    copy3(desc.v, source->v);
    desc.radius = source->radius;
    copy3(desc.radiance, source->value);
    if (source->kind == EX_LIGHT_SPOT && source->cos_half_angle > 1e-3f) {
        desc.cone_angle = 2 * acosf(source->cos_half_angle);
    } else if (source->kind == EX_LIGHT_SPOT) {
        desc.shape = COHSM_SHAPE_POINT;
        light->wide_spot = source;
    }
    return make_emitter(state, light, &desc, error);
}

static int add_sky(cs_state *state, const ex_sky *sky, char *error)
{
    cohsm_emitter_desc desc;
    cs_light *light = add_light(state, error);
    if (!light)
        return -1;
    memset(&desc, 0, sizeof desc);
    desc.shape = COHSM_SHAPE_ENVIRONMENT;
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

static void oriented(const rd_emitter *e, int back, patch *out)
{
    memset(out, 0, sizeof *out);
    for (int i = 0; i < 3; i++)
        copy3(out->v[i], e->v[back ? (3 - i) % 3 : i]);
    for (int k = 0; k < 3; k++)
        out->normal[k] = back ? -e->normal[k] : e->normal[k];
    out->area = e->area;
}

/* Two triangles that share an edge and make a flat parallelogram: corner, u and v with u x v along their normal. */
static int is_parallelogram(const patch *a, const patch *b, cohsm_emitter_desc *desc)
{
    float size = sqrtf(a->area);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const float *corner = a->v[i], *p = a->v[(i + 1) % 3], *q = a->v[(i + 2) % 3];
            const float *fourth = b->v[j], *q2 = b->v[(j + 1) % 3], *p2 = b->v[(j + 2) % 3];
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

static int add_patches(cs_state *state, const rd_emitter *group, size_t count, int back, cs_light *light,
                       cohsm_emitter_desc *desc, char *error)
{
    const cs_options *options = &state->options;
    uint32_t maps = options->light_side * options->light_side;
    float area = 0;
    cs_patches *p = light->patches = calloc(1, sizeof *p);
    if (!p)
        return cs_out_of_memory(error);
    for (size_t i = 0; i < count; i++)
        area += group[i].area;
    for (size_t i = 0; i < count; i++) {
        patch whole;
        oriented(&group[i], back, &whole);
        if (add_pieces(p, &whole, area / (float)(maps * PATCHES_PER_MAP)) != 0)
            return cs_out_of_memory(error);
    }
    put_in_order(p);
    desc->shape = COHSM_SHAPE_CALLBACK;
    desc->shape_fn = point_of_mesh;
    desc->user = p;
    return 0;
}

/* One side of the triangles of one object with one material. */
static int add_emissive(cs_state *state, const rd_job *job, const rd_emitter *group, size_t count, int back,
                        char *error)
{
    cohsm_emitter_desc desc;
    cs_light *light = add_light(state, error);
    patch a, b;
    if (!light)
        return -1;
    light->object = group->object;
    memset(&desc, 0, sizeof desc);
    copy3(desc.radiance, job->scene->materials[group->material].emission);
    if (count == 2) {
        oriented(&group[0], back, &a);
        oriented(&group[1], back, &b);
        if (is_parallelogram(&a, &b, &desc))
            desc.shape = COHSM_SHAPE_RECTANGLE;
    }
    if (desc.shape != COHSM_SHAPE_RECTANGLE &&
        add_patches(state, group, count, back, light, &desc, error) != 0)
        return -1;
    if (desc.shape == COHSM_SHAPE_RECTANGLE)
        for (int k = 0; k < 3; k++)
            desc.position[k] += clearance(job) * a.normal[k];
    return make_emitter(state, light, &desc, error);
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

int cs_light_domain(const cs_light *light, const rd_job *job, const cs_options *options, cohsm_domain *out,
                    float **locations, char *error)
{
    uint32_t n = options->light_side * options->light_side;
    *locations = NULL;
    if (!light->patches) {
        cohsm_result result = cohsm_emitter_domain(light->emitter, out);
        if (result != COHSM_OK)
            return cs_failed("a light", result, error);
        out->side[0] = out->side[1] = options->light_side;
        if (out->kind == COHSM_DOMAIN_LINE) {
            out->side[0] = n < MOST_LINE_MAPS ? n : MOST_LINE_MAPS;
            out->side[1] = 1;
        }
        return 0;
    }
    *locations = malloc(4 * (size_t)n * sizeof **locations);
    if (!*locations)
        return cs_out_of_memory(error);
    for (uint32_t i = 0; i < n; i++) {
        const patch *p = find_patch(light->patches, (i + 0.5) / n);
        float *to = *locations + 4 * (size_t)i;
        for (int k = 0; k < 3; k++)
            to[k] = (p->v[0][k] + p->v[1][k] + p->v[2][k]) / 3 + clearance(job) * p->normal[k];
        to[3] = 1;
    }
    memset(out, 0, sizeof *out);
    out->kind = COHSM_DOMAIN_TABLE;
    out->side[0] = n;
    out->side[1] = out->side[2] = 1;
    out->locations = *locations;
    out->location_count = n;
    return 0;
}

size_t cs_light_triangles(const cs_light *light, float *out)
{
    for (size_t i = 0; out && i < light->patches->count; i++)
        for (size_t k = 0; k < 3; k++)
            copy3(out + 9 * i + 3 * k, light->patches->at[i].v[k]);
    return light->patches->count;
}

void cs_light_free(cs_light *light)
{
    if (light->patches)
        free(light->patches->at);
    free(light->patches);
    free(light->memory);
    cs_casters_free(&light->own);
}
