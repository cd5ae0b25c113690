/* ref_lights.c - see ref_lights.h */
#include "ref_lights.h"

#include <stdlib.h>
#include <string.h>

static int is_delta(const ex_light *light)
{
    return light->kind == EX_LIGHT_SUN || light->kind == EX_LIGHT_SPOT || light->kind == EX_LIGHT_POINT;
}

/* ---- tables ---- */

static int make_table(rf_lights *lights, rf_table *table, size_t count)
{
    table->count = count;
    table->cdf = calloc(count + 1, sizeof *table->cdf);
    table->guide = calloc(count + 1, sizeof *table->guide);
    lights->bytes += (count + 1) * (sizeof *table->cdf + sizeof *table->guide);
    return table->cdf && table->guide ? 0 : -1;
}

static void free_table(rf_table *table)
{
    free(table->cdf);
    free(table->guide);
}

/* Call it when the weights stand in cdf[1 .. count]. */
static void sum_table(rf_table *table)
{
    size_t i = 0;
    for (size_t k = 0; k < table->count; k++)
        table->cdf[k + 1] += table->cdf[k];
    for (size_t k = 0; k <= table->count; k++) {
        double x = table->cdf[table->count] * (double)k / (double)table->count;
        while (i + 1 < table->count && table->cdf[i + 1] <= x)
            i++;
        table->guide[k] = (uint32_t)i;
    }
}

static double total_of(const rf_table *table) { return table->cdf[table->count]; }

static double probability(const rf_table *table, size_t i)
{
    return total_of(table) > 0 ? (table->cdf[i + 1] - table->cdf[i]) / total_of(table) : 0;
}

/* The interval that u in [0, 1) falls into, never an empty one; *rest: where inside, 0 to 1. The sum is positive. */
static size_t search(const rf_table *table, double u, double *rest)
{
    const double *cdf = table->cdf;
    double x = u * total_of(table);
    size_t i = table->guide[(size_t)(u * (double)table->count)];
    while (i + 1 < table->count && cdf[i + 1] <= x)
        i++;
    while (i > 0 && !(cdf[i + 1] > cdf[i]))        /* x rounded up to the end: the last one that counts */
        i--;
    *rest = rf_least(rf_most((x - cdf[i]) / (cdf[i + 1] - cdf[i]), 0), 1);
    return i;
}

static rf_v3 emission_of(const rf_lights *lights, size_t emitter)
{
    return rf_load(lights->scene->materials[lights->emitters[emitter].material].emission);
}

static int build_emitters(rf_lights *lights, size_t count)
{
    rf_table *table = &lights->emitter_table;
    if (make_table(lights, table, count) != 0)
        return -1;
    for (size_t i = 0; i < count; i++)
        table->cdf[i + 1] = (double)lights->emitters[i].area * rf_mean(emission_of(lights, i));
    sum_table(table);
    lights->emitter_power = total_of(table);
    return 0;
}

static double row_edge(const ex_sky *sky, size_t row)      /* cosine of the polar angle above a row */
{
    return cos(RF_PI * (double)row / (double)sky->height);
}

static double texel_solid_angle(const ex_sky *sky, size_t row)
{
    return 2 * RF_PI / (double)sky->width * (row_edge(sky, row) - row_edge(sky, row + 1));
}

static int build_sky(rf_lights *lights)
{
    const ex_sky *sky = &lights->scene->sky;
    size_t width = sky->width, height = sky->height;
    lights->sky_cos = cos((double)sky->rotation);
    lights->sky_sin = sin((double)sky->rotation);
    if (!width || !height)
        return 0;
    lights->texels = calloc(height, sizeof *lights->texels);
    if (!lights->texels || make_table(lights, &lights->rows, height) != 0)
        return -1;
    for (size_t row = 0; row < height; row++) {
        rf_table *table = &lights->texels[row];
        if (make_table(lights, table, width) != 0)
            return -1;
        for (size_t x = 0; x < width; x++)
            table->cdf[x + 1] = rf_mean(rf_load(sky->rgb + 3 * (row * width + x)));
        sum_table(table);
        lights->rows.cdf[row + 1] = total_of(table) * texel_solid_angle(sky, row);
    }
    sum_table(&lights->rows);
    lights->sky_power = total_of(&lights->rows);
    return 0;
}

static double area_of(const ex_light *light)
{
    double r = (double)light->radius;
    switch (light->kind) {
    case EX_LIGHT_SPHERE: return 4 * RF_PI * r * r;
    case EX_LIGHT_RECT:   return rf_length(rf_cross(rf_load(light->u), rf_load(light->v)));
    case EX_LIGHT_DISC:   return RF_PI * r * r;
    case EX_LIGHT_LINE:   return 2 * RF_PI * r * rf_length(rf_load(light->u));
    default:              return 0;
    }
}

static double power_of(const ex_light *light, double radius)
{
    double value = rf_mean(rf_load(light->value));
    switch (light->kind) {
    case EX_LIGHT_SUN:   return RF_PI * radius * radius * value;
    case EX_LIGHT_SPOT:  return 2 * RF_PI * (1 - (double)light->cos_half_angle) * value;
    case EX_LIGHT_POINT: return 4 * RF_PI * value;
    default:             return RF_PI * area_of(light) * value;
    }
}

/* Half of the samples go evenly to every source, so that a weak one nearby is not starved; half by power. */
static int build_pick(rf_lights *lights, int area_only, double radius)
{
    size_t count = lights->source_count, n = lights->scene->light_count, used = 0;
    rf_table *table = &lights->pick[area_only];
    double total = 0;
    if (make_table(lights, table, count) != 0)
        return -1;
    for (size_t i = 0; i < count; i++) {
        const ex_light *light = i < n ? &lights->scene->lights[i] : NULL;
        double power = i == n ? RF_PI * lights->emitter_power : RF_PI * radius * radius * lights->sky_power;
        if (light)
            power = area_only && is_delta(light) ? 0 : power_of(light, radius);
        table->cdf[i + 1] = power;
        total += power;
        used += power > 0;
    }
    for (size_t i = 0; i < count; i++)
        if (table->cdf[i + 1] > 0)
            table->cdf[i + 1] = 0.5 / (double)used + 0.5 * table->cdf[i + 1] / total;
    sum_table(table);
    return 0;
}

int rf_lights_init(rf_lights *lights, const rd_job *job, double epsilon, char *error)
{
    memset(lights, 0, sizeof *lights);
    lights->scene = job->scene;
    lights->emitters = job->emitters;
    lights->epsilon = epsilon;
    lights->source_count = (size_t)job->scene->light_count + 2;
    if (build_emitters(lights, job->emitter_count) || build_sky(lights) || build_pick(lights, 0, (double)job->radius) ||
        build_pick(lights, 1, (double)job->radius)) {
        rf_lights_free(lights);
        snprintf(error, EX_ERROR_SIZE, "out of memory");
        return -1;
    }
    return 0;
}

void rf_lights_free(rf_lights *lights)
{
    for (size_t row = 0; lights->texels && row < lights->rows.count; row++)
        free_table(&lights->texels[row]);
    free(lights->texels);
    free_table(&lights->rows);
    free_table(&lights->emitter_table);
    free_table(&lights->pick[0]);
    free_table(&lights->pick[1]);
    memset(lights, 0, sizeof *lights);
}

/* ---- sampling ---- */

/* A point q of a surface with normal n, chosen with density pdf_area; 0: p is behind it. */
static int sample_surface(rf_v3 p, rf_v3 q, rf_v3 n, double pdf_area, double epsilon, rf_light_sample *s)
{
    rf_v3 d = rf_sub(q, p);
    double distance = rf_length(d), cosine;
    if (!(distance > 0))
        return 0;
    s->direction = rf_scale(d, 1 / distance);
    cosine = -rf_dot(s->direction, n);
    s->pdf = pdf_area * distance * distance / cosine;
    s->target = rf_mad(q, n, epsilon);
    return cosine > 0 && s->pdf < 1e30;
}

/* The cone that a sphere fills as seen from outside: 1 - cos of its half angle, without cancellation. */
static double cone_of(double radius, double distance)
{
    double sine = radius / distance;
    return sine * sine / (1 + sqrt(1 - sine * sine));
}

static int sample_sphere(const ex_light *light, rf_v3 p, const double u[2], rf_light_sample *s)
{
    rf_v3 z = rf_sub(rf_load(light->position), p), x, y;
    double distance = rf_length(z), radius = (double)light->radius, cone, c, sine, phi = 2 * RF_PI * u[1];
    if (!(distance > radius))
        return 0;
    z = rf_scale(z, 1 / distance);
    cone = cone_of(radius, distance);
    c = 1 - u[0] * cone;
    sine = sqrt(u[0] * cone * (2 - u[0] * cone));
    rf_frame(z, &x, &y);
    s->direction = rf_unit(rf_from_frame(x, y, z, rf_make(sine * cos(phi), sine * sin(phi), c)));
    s->pdf = 1 / (2 * RF_PI * cone);
    s->target = rf_mad(p, s->direction,
                       distance * c - sqrt(rf_most(0, radius * radius - distance * distance * sine * sine)));
    return 1;
}

/* A line light as p sees it: its visible arc, and its length as an angle at p. Sampling is uniform in both angles, so
   that the part nearby gets more samples. */
typedef struct line_view {
    rf_v3  axis, x, y;         /* x: from the axis towards p */
    double length, radius, distance;   /* of p from the axis */
    double foot;               /* of p along the axis */
    double arc;                /* half of what is visible */
    double first, last;        /* angles of the ends */
} line_view;

static int view_line(const ex_light *light, rf_v3 p, line_view *view)
{
    rf_v3 from = rf_sub(p, rf_load(light->position));
    view->axis = rf_load(light->u);
    view->length = rf_length(view->axis);
    view->axis = rf_scale(view->axis, 1 / view->length);
    view->radius = (double)light->radius;
    view->foot = rf_dot(from, view->axis);
    view->x = rf_mad(from, view->axis, -view->foot);
    view->distance = rf_length(view->x);
    if (!(view->distance > view->radius))
        return 0;
    view->x = rf_scale(view->x, 1 / view->distance);
    view->y = rf_cross(view->axis, view->x);
    view->arc = acos(view->radius / view->distance);
    view->first = atan(-view->foot / view->distance);
    view->last = atan((view->length - view->foot) / view->distance);
    return 1;
}

static double line_pdf_area(const line_view *view, double along)
{
    double t = along - view->foot, d = view->distance;
    return d / ((d * d + t * t) * (view->last - view->first)) / (2 * view->arc * view->radius);
}

static int sample_line(const ex_light *light, rf_v3 p, const double u[2], double epsilon, rf_light_sample *s)
{
    line_view view;
    rf_v3 n;
    double angle, along;
    if (!view_line(light, p, &view))
        return 0;
    angle = (2 * u[1] - 1) * view.arc;
    along = view.foot + view.distance * tan(view.first + u[0] * (view.last - view.first));
    n = rf_add(rf_scale(view.x, cos(angle)), rf_scale(view.y, sin(angle)));
    return sample_surface(p, rf_mad(rf_mad(rf_load(light->position), view.axis, along), n, view.radius), n,
                          line_pdf_area(&view, along), epsilon, s);
}

static int sample_shape(const rf_lights *lights, const ex_light *light, rf_v3 p, const double u[2], rf_light_sample *s)
{
    rf_v3 q = rf_load(light->position), eu = rf_load(light->u), ev = rf_load(light->v), n, x, y;
    double r = (double)light->radius, phi = 2 * RF_PI * u[1];
    if (light->kind == EX_LIGHT_SPHERE)
        return sample_sphere(light, p, u, s);
    if (light->kind == EX_LIGHT_LINE)
        return sample_line(light, p, u, lights->epsilon, s);
    if (light->kind == EX_LIGHT_RECT) {
        n = rf_unit(rf_cross(eu, ev));
        q = rf_mad(rf_mad(q, eu, u[0]), ev, u[1]);
    } else {
        n = rf_load(light->direction);
        rf_frame(n, &x, &y);
        q = rf_mad(rf_mad(q, x, r * sqrt(u[0]) * cos(phi)), y, r * sqrt(u[0]) * sin(phi));
    }
    return sample_surface(p, q, n, 1 / area_of(light), lights->epsilon, s);
}

static int sample_emitter(const rf_lights *lights, rf_v3 p, const double u[2], rf_light_sample *s)
{
    double rest, root, a, b;
    size_t i = search(&lights->emitter_table, u[0], &rest);
    const rd_emitter *emitter = &lights->emitters[i];
    rf_v3 v0 = rf_load(emitter->v[0]), v1 = rf_load(emitter->v[1]), v2 = rf_load(emitter->v[2]), q;
    rf_v3 n = rf_unit(rf_cross(rf_sub(v1, v0), rf_sub(v2, v0)));
    root = sqrt(rest);
    a = root * (1 - u[1]);
    b = root * u[1];
    q = rf_mad(rf_mad(v0, rf_sub(v1, v0), a), rf_sub(v2, v0), b);
    if (lights->scene->materials[emitter->material].double_sided && rf_dot(n, rf_sub(p, q)) < 0)
        n = rf_scale(n, -1);
    s->value = emission_of(lights, i);
    return sample_surface(p, q, n, rf_mean(s->value) / lights->emitter_power, lights->epsilon, s);
}

/* Directions of the sky turn about +Y against its map. */
static rf_v3 sky_to_world(const rf_lights *lights, rf_v3 d)
{
    return rf_make(d.x * lights->sky_cos + d.z * lights->sky_sin, d.y, d.z * lights->sky_cos - d.x * lights->sky_sin);
}

static rf_v3 world_to_sky(const rf_lights *lights, rf_v3 d)
{
    return rf_make(d.x * lights->sky_cos - d.z * lights->sky_sin, d.y, d.z * lights->sky_cos + d.x * lights->sky_sin);
}

static int sample_sky(const rf_lights *lights, const double u[2], rf_light_sample *s)
{
    const ex_sky *sky = &lights->scene->sky;
    double down, along, c, sine, phi;
    size_t row = search(&lights->rows, u[1], &down);
    size_t x = search(&lights->texels[row], u[0], &along);
    c = row_edge(sky, row) + down * (row_edge(sky, row + 1) - row_edge(sky, row));
    sine = sqrt(rf_most(0, 1 - c * c));
    phi = 2 * RF_PI * (((double)x + along) / (double)sky->width - 0.5);
    s->direction = rf_unit(sky_to_world(lights, rf_make(sine * cos(phi), c, sine * sin(phi))));
    s->value = rf_load(sky->rgb + 3 * (row * sky->width + x));
    s->pdf = rf_mean(s->value) / lights->sky_power;
    s->at_infinity = 1;
    return s->pdf > 0;
}

int rf_lights_delta(const rf_lights *lights, uint32_t index, rf_v3 p, rf_light_sample *s)
{
    const ex_light *light = &lights->scene->lights[index];
    double distance;
    if (!is_delta(light))
        return 0;
    memset(s, 0, sizeof *s);
    s->is_delta = 1;
    s->pdf = 1;
    s->value = rf_load(light->value);
    s->direction = rf_load(light->direction);
    s->at_infinity = light->kind == EX_LIGHT_SUN;
    if (s->at_infinity)
        return 1;
    s->target = rf_load(light->position);
    s->direction = rf_sub(s->target, p);
    distance = rf_length(s->direction);
    if (!(distance > 0))
        return 0;
    s->direction = rf_scale(s->direction, 1 / distance);
    s->value = rf_scale(s->value, 1 / (distance * distance));
    return light->kind == EX_LIGHT_POINT ||
           -rf_dot(s->direction, rf_load(light->direction)) >= (double)light->cos_half_angle;
}

int rf_lights_sample(const rf_lights *lights, rf_v3 p, int area_only, const double u[2], rf_light_sample *s)
{
    const rf_table *pick = &lights->pick[area_only];
    size_t source, n = lights->scene->light_count;
    double v[2];
    int reached;
    if (!(total_of(pick) > 0))
        return 0;
    source = search(pick, u[0], &v[0]);
    v[1] = u[1];
    memset(s, 0, sizeof *s);
    if (source < n && is_delta(&lights->scene->lights[source])) {
        reached = rf_lights_delta(lights, (uint32_t)source, p, s);
    } else if (source < n) {
        s->value = rf_load(lights->scene->lights[source].value);
        reached = sample_shape(lights, &lights->scene->lights[source], p, v, s);
    } else {
        reached = source == n ? sample_emitter(lights, p, v, s) : sample_sky(lights, v, s);
    }
    s->pdf *= probability(pick, source);
    return reached;
}

/* ---- what rays meet ---- */

static int hit_sphere(const ex_light *light, rf_v3 o, rf_v3 d, double *t, double *pdf)
{
    rf_v3 c = rf_sub(rf_load(light->position), o);
    double distance = rf_length(c), radius = (double)light->radius, along = rf_dot(c, d), cone, miss;
    if (!(distance > radius) || along <= 0)
        return 0;
    cone = cone_of(radius, distance);
    miss = rf_length(rf_mad(c, d, -along));
    if (miss >= radius)
        return 0;
    *t = along - sqrt(radius * radius - miss * miss);
    *pdf = 1 / (2 * RF_PI * cone);
    return 1;
}

static int hit_flat(const ex_light *light, rf_v3 o, rf_v3 d, double *t, double *cosine)
{
    rf_v3 corner = rf_load(light->position), u = rf_load(light->u), v = rf_load(light->v), n, q;
    int is_disc = light->kind == EX_LIGHT_DISC;
    double a, b, squared;
    n = is_disc ? rf_load(light->direction) : rf_cross(u, v);
    squared = rf_dot(n, n);
    *cosine = -rf_dot(d, n) / sqrt(squared);
    *t = rf_dot(rf_sub(corner, o), n) / rf_dot(d, n);
    if (!(*cosine > 0) || !(*t > 0))
        return 0;
    q = rf_sub(rf_mad(o, d, *t), corner);
    if (is_disc)
        return rf_dot(q, q) < (double)light->radius * (double)light->radius;
    a = rf_dot(rf_cross(q, v), n) / squared;
    b = rf_dot(rf_cross(u, q), n) / squared;
    return a >= 0 && a < 1 && b >= 0 && b < 1;
}

/* The density is per area here: that of the caller's other shapes is constant. */
static int hit_line(const ex_light *light, rf_v3 o, rf_v3 d, double *t, double *cosine, double *pdf_area)
{
    line_view view;
    rf_v3 across, offset;
    double a, b, root, along, step = rf_dot(d, rf_unit(rf_load(light->u)));
    if (!view_line(light, o, &view))
        return 0;
    across = rf_mad(d, view.axis, -step);
    offset = rf_scale(view.x, view.distance);
    a = rf_dot(across, across);
    b = rf_dot(across, offset);
    root = b * b - a * (view.distance * view.distance - view.radius * view.radius);
    if (b >= 0 || root <= 0)
        return 0;
    *t = (-b - sqrt(root)) / a;
    along = view.foot + *t * step;
    *cosine = -rf_dot(d, rf_unit(rf_mad(offset, across, *t)));
    *pdf_area = line_pdf_area(&view, along);
    return along >= 0 && along <= view.length && *cosine > 0;
}

int rf_lights_hit(const rf_lights *lights, uint32_t index, int area_only, rf_v3 origin, rf_v3 direction, double limit,
                  rf_v3 *radiance, double *pdf)
{
    const ex_light *light = &lights->scene->lights[index];
    double t, cosine, pdf_area;
    if (is_delta(light))
        return 0;
    if (light->kind == EX_LIGHT_SPHERE) {
        if (!hit_sphere(light, origin, direction, &t, pdf))
            return 0;
    } else {
        pdf_area = 1 / area_of(light);
        if (!(light->kind == EX_LIGHT_LINE ? hit_line(light, origin, direction, &t, &cosine, &pdf_area)
                                           : hit_flat(light, origin, direction, &t, &cosine)))
            return 0;
        *pdf = pdf_area * t * t / cosine;
    }
    *pdf *= probability(&lights->pick[area_only], index);
    *radiance = rf_load(light->value);
    return t < limit;
}

double rf_lights_emitter_pdf(const rf_lights *lights, int area_only, rf_v3 radiance, double distance, double cosine)
{
    if (!(lights->emitter_power > 0) || !(cosine > 0))
        return 0;
    return probability(&lights->pick[area_only], lights->scene->light_count) * rf_mean(radiance) /
           lights->emitter_power * distance * distance / cosine;
}

rf_v3 rf_lights_sky(const rf_lights *lights, int area_only, rf_v3 direction, double *pdf)
{
    const ex_sky *sky = &lights->scene->sky;
    rf_v3 d = world_to_sky(lights, direction), radiance;
    size_t row, x;
    *pdf = 0;
    if (!(lights->sky_power > 0))
        return rf_make(0, 0, 0);
    row = (size_t)(acos(rf_least(rf_most(d.y, -1), 1)) / RF_PI * (double)sky->height);
    x = (size_t)((0.5 + atan2(d.z, d.x) / (2 * RF_PI)) * (double)sky->width);
    row = row < sky->height ? row : sky->height - 1u;
    x = x < sky->width ? x : 0;
    radiance = rf_load(sky->rgb + 3 * (row * sky->width + x));
    *pdf = probability(&lights->pick[area_only], lights->source_count - 1) * rf_mean(radiance) / lights->sky_power;
    return radiance;
}
