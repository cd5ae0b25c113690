/* fuzz_samples - libFuzzer target: bytes choose a light, materials, points and a sampling. A light that is made answers
   with unit directions where there is a receiver, finite weights that are not negative, coordinates in 0..1; calls that
   fail write nothing. */

#define LSAMP_STATIC
#define LIGHTSAMPLING_IMPLEMENTATION
#include "lightsampling.h"
#include <float.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { POINTS = 6, SAMPLES = 8, TEXELS = 3 * 8 * 8 * 3, VERTICES = 12, INDICES = 18 };

typedef struct input { const uint8_t *data; size_t size, at; } input;

/* What a desc and points refer to. */
typedef struct room {
    float texels[TEXELS], vertices[3 * VERTICES];
    uint32_t indices[INDICES];
    uint16_t indices16[INDICES];
    lsamp_mesh mesh;
    lsamp_lobe lobes[LSAMP_MAX_LOBES];
    lsamp_material materials[POINTS];
    float positions[3 * POINTS], normals[3 * POINTS], views[3 * POINTS], tangents[3 * POINTS];
    float patterns[2 * SAMPLES * LSAMP_PATTERN_COUNT];
    float directions[3 * POINTS * SAMPLES], distances[POINTS * SAMPLES], coords[3 * POINTS * SAMPLES];
    float weights[3 * POINTS * SAMPLES];
} room;

static void need(int holds)
{
    if (!holds) abort();
}

static uint32_t take(input *in) { return in->at < in->size ? in->data[in->at++] : 0u; }

/* Mostly in -1..1, seldom any bits at all. */
static float take_float(input *in)
{
    uint32_t a = take(in), b = take(in);
    if (a == 255) {
        uint32_t bits = b << 24 | take(in) << 16 | take(in) << 8 | take(in);
        float f;
        memcpy(&f, &bits, sizeof f);
        return f;
    }
    return (float)((int)(a << 8 | b) - 32640) / 32640.0f;
}

/* Mostly unit. */
static void take_unit(input *in, float *v)
{
    uint32_t how = take(in);
    float length;
    int k;
    for (k = 0; k < 3; k++) v[k] = take_float(in);
    length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (k = 0; k < 3 && how < 250u && length > 0 && length < 1e6f; k++) v[k] /= length;
}

static void take_positive(input *in, float *v, int count)
{
    uint32_t how = take(in);
    int k;
    for (k = 0; k < count; k++) v[k] = how < 250u ? (float)take(in) / 255.0f : take_float(in);
}

static void shape(void *user, float time, const float x[3], float position[3], float normal[3], float *area)
{
    const float *numbers = (const float *)user;
    int k;
    for (k = 0; k < 3; k++) {
        position[k] = x[k] * numbers[k] + time;
        normal[k] = k == 1 && x[0] < 0.75f ? 1.0f : 0.0f;
    }
    *area = numbers[3];
}

static void emission(void *user, float time, const float x[3], const float direction[3], float rgb[3])
{
    const float *numbers = (const float *)user;
    (void)time;
    rgb[0] = numbers[4];
    rgb[1] = x[0];
    rgb[2] = direction[1];
}

static void take_mesh(input *in, room *r, lsamp_light_desc *d)
{
    int k;
    for (k = 0; k < 3 * VERTICES; k++) r->vertices[k] = take_float(in);
    for (k = 0; k < INDICES; k++) {
        r->indices[k] = take(in) % (VERTICES + (take(in) == 255 ? 1u : 0u));
        r->indices16[k] = (uint16_t)r->indices[k];
    }
    memset(&r->mesh, 0, sizeof r->mesh);
    r->mesh.positions = r->vertices;
    r->mesh.vertex_count = VERTICES;
    k = (int)(take(in) % 3u);
    r->mesh.indices = k == 1 ? r->indices : NULL;
    r->mesh.indices16 = k == 2 ? r->indices16 : NULL;
    r->mesh.index_count = take(in) % 8u ? INDICES : take(in) % INDICES;
    d->mesh = &r->mesh;
    d->place_count = take(in);
}

static void take_light(input *in, room *r, lsamp_light_desc *d)
{
    static float numbers[5];
    int k;
    memset(d, 0, sizeof *d);
    d->kind = (lsamp_light_kind)(take(in) % (LSAMP_LIGHT_COUNT + 1));
    for (k = 0; k < 3; k++) d->position[k] = 3 * take_float(in);
    take_unit(in, d->direction);
    for (k = 0; k < 3; k++) {
        d->u[k] = take_float(in);
        d->v[k] = take_float(in);
    }
    take_positive(in, &d->radius, 1);
    take_positive(in, &d->cone_half_angle, 1);
    take_positive(in, d->radiance, 3);
    d->cosine_power = take(in) & 1u ? (float)take(in) : 0.0f;
    d->rotation = take_float(in);
    d->time = take_float(in);
    take_positive(in, numbers, 5);
    d->user = numbers;
    if (take(in) & 1u) d->emission_fn = emission;
    if (d->kind == LSAMP_LIGHT_CALLBACK || take(in) == 255) d->shape_fn = shape;
    if (d->kind == LSAMP_LIGHT_MESH) take_mesh(in, r, d);
    if (take(in) & 1u) {
        for (k = 0; k < TEXELS; k++) r->texels[k] = (float)(k * 7 % 11) / 11.0f;
        for (k = 0; k < 6; k++) r->texels[take(in) * 2u] = take_float(in);
        d->texels = r->texels;
        d->width = take(in) % 9u;
        d->height = d->kind == LSAMP_LIGHT_LINE ? 1 : take(in) % 9u;
        d->frame_count = take(in) % 4u;
        d->loop = (int)(take(in) & 1u);
        d->frames_per_second = (float)take(in);
    }
}

static void take_points(input *in, room *r, lsamp_points *p)
{
    int i;
    memset(p, 0, sizeof *p);
    memset(r->materials, 0, sizeof r->materials);
    for (i = 0; i < (int)LSAMP_MAX_LOBES; i++) {
        int k;
        for (k = 0; k < 3; k++) r->lobes[i].axis[k] = take_float(in);
        r->lobes[i].exponent = (float)take(in);
        take_positive(in, r->lobes[i].scale, 3);
    }
    for (i = 0; i < POINTS; i++) {
        lsamp_material *m = &r->materials[i];
        int k;
        m->kind = (lsamp_material_kind)(take(in) % (LSAMP_MATERIAL_COUNT + (take(in) == 255 ? 1u : 0u)));
        take_positive(in, m->diffuse, 3);
        take_positive(in, m->specular, 3);
        m->exponent = (float)(take(in) * take(in));
        take_positive(in, &m->metallic, 1);
        take_positive(in, &m->roughness, 1);
        m->lobes = r->lobes;
        m->lobe_count = take(in) % (LSAMP_MAX_LOBES + 1);
        for (k = 0; k < 3; k++) r->positions[3 * i + k] = 2 * take_float(in);
        take_unit(in, r->normals + 3 * i);
        take_unit(in, r->views + 3 * i);
        take_unit(in, r->tangents + 3 * i);
    }
    p->count = POINTS;
    p->positions = r->positions;
    p->normals = r->normals;
    p->to_eye = take(in) & 1u ? r->views : NULL;
    p->tangents = take(in) & 1u ? r->tangents : NULL;
    p->materials = r->materials;
    p->material_stride = take(in) % 4u ? sizeof(lsamp_material) : 0;
}

static int is_unit(const float *v)
{
    float length2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    return length2 > 0.94f && length2 < 1.07f;
}

/* Is point i a receiver: finite, and no vector of it 0 0 0? */
static int is_receiver(const lsamp_points *p, size_t i)
{
    const float *vector[4] = { p->positions + 3 * i, p->normals + 3 * i, p->to_eye ? p->to_eye + 3 * i : NULL,
                               p->tangents ? p->tangents + 3 * i : NULL };
    int k, c;
    for (k = 0; k < 4; k++) {
        for (c = 0; c < 3; c++)
            if (vector[k] && !(fabsf(vector[k][c]) <= FLT_MAX)) return 0;
        if (k > 0 && vector[k] && vector[k][0] == 0 && vector[k][1] == 0 && vector[k][2] == 0) return 0;
    }
    return 1;
}

static int in_unit(const float *x)
{
    return x[0] >= 0 && x[0] < 1 && x[1] >= 0 && x[1] < 1 && x[2] >= 0 && x[2] < 1;
}

static void use_light(input *in, room *r, const lsamp_light *light, int *lines)
{
    lsamp_sample_desc d;
    lsamp_points p;
    lsamp_samples out;
    lsamp_domain domain;
    size_t useful = 77, i;
    float sums[3 * POINTS] = { 0 };
    memset(&d, 0, sizeof d);
    take_points(in, r, &p);
    d.sample_count = 1 + take(in) % SAMPLES;
    d.sampling = (lsamp_sampling)(take(in) % (LSAMP_SAMPLING_COUNT + (take(in) == 255 ? 1u : 0u)));
    d.seed = take(in);
    d.frame = take(in) * take(in);
    if (take(in) & 1u) {
        need(lsamp_patterns_build(d.sample_count, d.seed, r->patterns, sizeof r->patterns) == LSAMP_OK);
        d.patterns = r->patterns;
    }
    out.directions = r->directions;
    out.distances = r->distances;
    out.coords = r->coords;
    out.weights = r->weights;
    *lines = 0;
    need((lsamp_light_domain(light, &domain) != LSAMP_OK) == (*lines == 1));
    if (lsamp_sample(&d, light, &p, &out, &useful) != LSAMP_OK) {
        need(useful == 77);
        return;
    }
    need(useful <= (size_t)POINTS * d.sample_count);
    for (i = 0; i < (size_t)POINTS * d.sample_count; i++) {
        const float *w = r->weights + 3 * i, *u = r->directions + 3 * i;
        int k;
        need(r->distances[i] > 0);
        need(is_receiver(&p, i / d.sample_count) ? is_unit(u) : u[0] == 0 && u[1] == 0 && u[2] == 0);
        need(in_unit(r->coords + 3 * i));
        for (k = 0; k < 3; k++) need(w[k] >= 0 && w[k] <= 3.4e38f);
    }
    need(lsamp_accumulate(POINTS, d.sample_count, r->weights, NULL, sums, 0) == LSAMP_OK);
    for (i = 0; i < 3 * POINTS; i++) need(sums[i] >= 0);
}

/* A desc, or the question for a domain, is refused with one line in the log, which names the function. */
static void heard(void *user, const char *message)
{
    ++*(int *)user;
    need(strncmp(message, "lsamp_light_init: ", 18) == 0 || strncmp(message, "lsamp_light_domain: ", 20) == 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static room r;
    static uint64_t memory[1 << 15];
    input in = { data, size, 0 };
    lsamp_light_desc d;
    lsamp_light *light = NULL;
    size_t bytes;
    int lines = 0;
    lsamp_result result;
    take_light(&in, &r, &d);
    d.system.log = heard;
    d.system.user = &lines;
    bytes = lsamp_light_bytes(&d);
    if (bytes > sizeof memory) return 0;
    result = lsamp_light_init(&d, memory, sizeof memory, &light, NULL);
    need((result != LSAMP_OK) == (lines == 1));
    need((result == LSAMP_OK) == (light != NULL));
    need(bytes != 0 || result == LSAMP_ERR_DESC || result == LSAMP_ERR_ARGUMENT || result == LSAMP_ERR_INPUT ||
         result == LSAMP_ERR_LIMIT);
    if (result == LSAMP_OK) use_light(&in, &r, light, &lines);
    return 0;
}
