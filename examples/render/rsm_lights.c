/* rsm_lights.c - see rsm_parts.h */
#include "rsm_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265f

typedef struct list { rsm_light *lights; size_t count, room; const rd_job *job; } list;

static rsm_light *add(list *l, rsm_light_kind kind)
{
    rsm_light *to = &l->lights[l->count++];
    memset(to, 0, sizeof *to);
    to->kind = kind;
    to->radius = l->job->radius;
    /* Larger than the scene, so that the ground about it counts too. */
    to->near_depth = 1e-4f * l->job->radius;
    to->far_depth = 1e3f * l->job->radius;
    return to;
}

/* The map of a sun: the scene without its ground, and some ground around it. rs_rings_build has the rest. */
static void add_sun(list *l, const float direction[3], const float value[3])
{
    rsm_light *to = add(l, RSM_LIGHT_SUN);
    memcpy(to->position, l->job->center, sizeof to->position);
    memcpy(to->direction, direction, sizeof to->direction);
    to->up[fabsf(direction[1]) < 0.9f ? 1 : 2] = 1;
    memcpy(to->value, value, sizeof to->value);
    to->radius = 1.05f * l->job->radius;
    to->near_depth = -10 * to->radius;
    to->far_depth = 10 * to->radius;
}

static void add_hard(list *l, const ex_light *light)
{
    rsm_light *to;
    if (light->kind == EX_LIGHT_SUN) {
        add_sun(l, light->direction, light->value);
        return;
    }
    to = add(l, light->kind == EX_LIGHT_SPOT ? RSM_LIGHT_SPOT : RSM_LIGHT_POINT);
    memcpy(to->position, light->position, sizeof to->position);
    memcpy(to->direction, light->direction, sizeof to->direction);
    memcpy(to->value, light->value, sizeof to->value);
    if (light->kind == EX_LIGHT_SPOT)
        to->cone_half_angle = acosf(light->cos_half_angle);
}

/* ---- area lights and emissive triangles ---- */

static float length_of(const float v[3]) { return sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }
static float mean_of(const float v[3]) { return (v[0] + v[1] + v[2]) / 3; }

static void cross(const float a[3], const float b[3], float out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static int is_area(const ex_light *light)
{
    return light->kind != EX_LIGHT_SUN && light->kind != EX_LIGHT_SPOT && light->kind != EX_LIGHT_POINT;
}

static float area_of(const ex_light *light)
{
    float n[3];
    switch (light->kind) {
    case EX_LIGHT_SPHERE: return 4 * PI * light->radius * light->radius;
    case EX_LIGHT_DISC: return PI * light->radius * light->radius;
    case EX_LIGHT_LINE: return 2 * PI * light->radius * length_of(light->u);
    case EX_LIGHT_RECT: cross(light->u, light->v, n); return length_of(n);
    default: return 0;
    }
}

/* Two unit vectors across n. */
static void frame_of(const float n[3], float a[3], float b[3])
{
    float other[3] = { 0, 0, 0 }, length;
    other[fabsf(n[0]) < 0.6f ? 0 : 1] = 1;
    cross(n, other, a);
    length = length_of(a);
    for (int k = 0; k < 3; k++)
        a[k] /= length;
    cross(n, a, b);
}

static void unit(float v[3])
{
    float length = length_of(v);
    for (int k = 0; k < 3; k++)
        v[k] /= length > 0 ? length : 1;
}

/* The point (s, t) of an area light and its normal; s, t in 0..1, all of equal area. */
static void area_point(const ex_light *light, float s, float t, float p[3], float n[3])
{
    float a[3], b[3], r, phi = 2 * PI * t, c = 1 - 2 * s;
    switch (light->kind) {
    case EX_LIGHT_RECT:
        cross(light->u, light->v, n);
        unit(n);
        for (int k = 0; k < 3; k++)
            p[k] = light->position[k] + s * light->u[k] + t * light->v[k];
        return;
    case EX_LIGHT_DISC:
        memcpy(n, light->direction, 3 * sizeof *n);
        frame_of(n, a, b);
        r = light->radius * sqrtf(s);
        for (int k = 0; k < 3; k++)
            p[k] = light->position[k] + r * cosf(phi) * a[k] + r * sinf(phi) * b[k];
        return;
    case EX_LIGHT_LINE:
        memcpy(a, light->u, sizeof a);
        unit(a);
        frame_of(a, b, n);
        for (int k = 0; k < 3; k++)
            n[k] = cosf(phi) * b[k] + sinf(phi) * n[k];
        for (int k = 0; k < 3; k++)
            p[k] = light->position[k] + s * light->u[k] + light->radius * n[k];
        return;
    default:
        r = sqrtf(1 - c * c);
        n[0] = r * cosf(phi);
        n[1] = c;
        n[2] = r * sinf(phi);
        for (int k = 0; k < 3; k++)
            p[k] = light->position[k] + light->radius * n[k];
        return;
    }
}

static void add_patch(list *l, const float p[3], const float n[3], const float radiance[3], float area)
{
    rsm_light *to = add(l, RSM_LIGHT_PATCH);
    memcpy(to->position, p, sizeof to->position);
    memcpy(to->direction, n, sizeof to->direction);
    for (int k = 0; k < 3; k++)
        to->value[k] = radiance[k] * area;
}

/* Source i of the area lights first, then of the emitters: power, and the point (s, t) with a share of it. Both sides
   of a double-sided emitter take turns. */
static float source_power(const rd_job *job, size_t i)
{
    const rd_emitter *e;
    if (i < job->scene->light_count)
        return is_area(&job->scene->lights[i]) ? area_of(&job->scene->lights[i]) * mean_of(job->scene->lights[i].value)
                                               : 0;
    e = &job->emitters[i - job->scene->light_count];
    return e->area * mean_of(job->scene->materials[e->material].emission) *
           (job->scene->materials[e->material].double_sided ? 2.0f : 1.0f);
}

static void add_source_point(list *l, size_t i, float s, float t, float share)
{
    const rd_job *job = l->job;
    const rd_emitter *e;
    const ex_material *m;
    float p[3], n[3], sides, root = sqrtf(s);
    if (i < job->scene->light_count) {
        const ex_light *light = &job->scene->lights[i];
        area_point(light, s, t, p, n);
        add_patch(l, p, n, light->value, share * area_of(light));
        return;
    }
    e = &job->emitters[i - job->scene->light_count];
    m = &job->scene->materials[e->material];
    sides = m->double_sided ? 2 : 1;
    for (int k = 0; k < 3; k++) {
        p[k] = (1 - root) * e->v[0][k] + root * (1 - t) * e->v[1][k] + root * t * e->v[2][k];
        n[k] = m->double_sided && l->count % 2 ? -e->normal[k] : e->normal[k];
    }
    add_patch(l, p, n, m->emission, share * e->area * sides);
}

/* `points` places in proportion to power: even steps along the running sum of power, so that a source gets the points
   that it is due or one more; where a step falls in a source is one coordinate of the point, a golden ratio
   the other. */
static void add_area_points(list *l, uint32_t points)
{
    const rd_job *job = l->job;
    size_t sources = job->scene->light_count + job->emitter_count, i;
    double total = 0, before = 0;
    for (i = 0; i < sources; i++)
        total += (double)source_power(job, i);
    if (!(total > 0))
        return;
    for (i = 0; i < sources; i++) {
        double power = (double)source_power(job, i), step = total / points;
        double first = ceil(before / step - 0.5), end = ceil((before + power) / step - 0.5);
        for (double k = first; k < end && power > 0; k++) {
            double s = ((k + 0.5) * step - before) / power, t = k * 0.6180339887498949;
            add_source_point(l, i, (float)s, (float)(t - floor(t)), (float)(step / power));
        }
        before += power;
    }
}

/* ---- sky ---- */

static void rotate(float d[3], float angle)
{
    float c = cosf(angle), s = sinf(angle), x = d[0], z = d[2];
    d[0] = c * x + s * z;
    d[2] = -s * x + c * z;
}

/* Suns for a sky: even steps along its power, row by row, columns by a golden ratio in the row's own distribution. */
static int add_sky(list *l, uint32_t points, char *error)
{
    const ex_sky *sky = &l->job->scene->sky;
    size_t width = sky->width, height = sky->height;
    double *rows = calloc(height + 1, sizeof *rows), total;
    if (!rows) {
        snprintf(error, EX_ERROR_SIZE, "out of memory");
        return -1;
    }
    for (size_t y = 0; y < height; y++) {
        double solid = 2 * 3.14159265358979 / (double)width *
                       (cos(3.14159265358979 * (double)y / (double)height) -
                        cos(3.14159265358979 * (double)(y + 1) / (double)height));
        rows[y + 1] = rows[y];
        for (size_t x = 0; x < width; x++)
            rows[y + 1] += solid * (double)mean_of(sky->rgb + 3 * (y * width + x));
    }
    total = rows[height];
    for (uint32_t i = 0; i < points && total > 0; i++) {
        double at = (i + 0.5) / points * total, sum = 0, row_sum = 0, wanted = (i + 0.5) * 0.6180339887498949;
        size_t y = 0, x;
        float direction[3], value[3], mean;
        while (y + 1 < height && rows[y + 1] <= at)
            y++;
        for (x = 0; x < width; x++)
            row_sum += (double)mean_of(sky->rgb + 3 * (y * width + x));
        wanted = (wanted - floor(wanted)) * row_sum;
        for (x = 0; x + 1 < width; x++) {
            sum += (double)mean_of(sky->rgb + 3 * (y * width + x));
            if (sum > wanted)
                break;
        }
        mean = mean_of(sky->rgb + 3 * (y * width + x));
        if (!(mean > 0))
            continue;
        ex_sky_texel_direction(sky->width, sky->height, (float)x + 0.5f, (float)y + 0.5f, direction);
        rotate(direction, sky->rotation);
        for (int k = 0; k < 3; k++)
            value[k] = sky->rgb[3 * (y * width + x) + (size_t)k] / mean * (float)(total / points);
        add_sun(l, direction, value);
    }
    free(rows);
    return 0;
}

/* ---- the ground beyond the maps of suns ---- */

/* The planes of a sun's map. */
static void cover_of(const rsm_light *sun, rd_cover *cover)
{
    float axes[3][3];
    memset(cover, 0, sizeof *cover);
    cross(sun->up, sun->direction, axes[0]);
    unit(axes[0]);
    cross(sun->direction, axes[0], axes[1]);
    memcpy(axes[2], sun->direction, sizeof axes[2]);
    for (int i = 0; i < 6; i++) {
        double *plane = cover->planes[cover->plane_count++], sign = i & 1 ? -1 : 1;
        for (int k = 0; k < 3; k++) {
            plane[k] = sign * (double)axes[i / 2][k];
            plane[3] -= plane[k] * (double)sun->position[k];
        }
        plane[3] += (double)(i < 4 ? sun->radius : i & 1 ? -sun->near_depth : sun->far_depth);
    }
    for (int k = 0; k < 3; k++)
        cover->irradiance[k] = sun->value[k] * fmaxf(sun->direction[1], 0);
}

int rs_rings_build(rd_ring **rings, size_t *ring_count, const rd_job *job, const rsm_light *lights, size_t count,
                   char *error)
{
    rd_cover *covers = malloc((count + 1) * sizeof *covers);
    size_t suns = 0;
    int result = -1;
    for (size_t i = 0; i < count && covers; i++)
        if (lights[i].kind == RSM_LIGHT_SUN)
            cover_of(&lights[i], &covers[suns++]);
    if (covers)
        result = rd_rings_build(rings, ring_count, job, covers, suns);
    free(covers);
    if (result != 0)
        snprintf(error, EX_ERROR_SIZE, "out of memory");
    return result;
}

/* A ring's texels as those of a sun's map that looks straight down: irradiance 1, all light in the albedo. */
rsm_light rs_ring_light(const rd_ring *ring)
{
    rsm_light light;
    memset(&light, 0, sizeof light);
    light.kind = RSM_LIGHT_SUN;
    memcpy(light.position, ring->center, sizeof light.position);
    light.direction[1] = 1;
    light.up[2] = -1;
    light.value[0] = light.value[1] = light.value[2] = 1;
    light.radius = ring->half;
    return light;
}

int rs_ring_map(const rd_ring *ring, const rsm_system *system, rsm_map **map, char *error)
{
    rsm_desc desc;
    rsm_buffers buffers;
    rsm_result result;
    memset(&desc, 0, sizeof desc);
    memset(&buffers, 0, sizeof buffers);
    desc.light = rs_ring_light(ring);
    desc.side = RD_RING_SIDE;
    desc.system = *system;
    buffers.positions = ring->positions;
    buffers.normals = ring->normals;
    buffers.albedo = ring->radiosity;
    result = rsm_map_create(&desc, map);
    if (result != RSM_OK)
        return rs_fail(error, "a map of the ground", result);
    result = rsm_fill(*map, 0, &buffers);
    if (result == RSM_OK)
        result = rsm_finish(*map, NULL);
    if (result == RSM_OK)
        return 0;
    rsm_map_free(*map);
    *map = NULL;
    return rs_fail(error, "a map of the ground", result);
}

/* ---- all ---- */

int rs_lights_build(rsm_light **lights, size_t *count, const rd_job *job, uint32_t points, char *error)
{
    list l = { NULL, 0, 0, job };
    int result = 0;
    l.room = job->scene->light_count + 2 * (size_t)points + 16;
    l.lights = calloc(l.room, sizeof *l.lights);
    if (!l.lights) {
        snprintf(error, EX_ERROR_SIZE, "out of memory");
        return -1;
    }
    for (uint32_t i = 0; i < job->scene->light_count; i++)
        if (!is_area(&job->scene->lights[i]))
            add_hard(&l, &job->scene->lights[i]);
    add_area_points(&l, points);
    if (job->scene->sky.width)
        result = add_sky(&l, points, error);
    if (result != 0)
        free(l.lights);
    else {
        *lights = l.lights;
        *count = l.count;
    }
    return result;
}
