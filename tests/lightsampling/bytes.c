/* bytes - hashes of what lightsampling.h makes: patterns, points of every kind of light, samples with every material
   by every sampling, their sums. The same on every compiler, option and byte order. Lights and points are made of
   integers, so that only the header computes. */

#define LIGHTSAMPLING_IMPLEMENTATION
#include "lightsampling.h"

#include <stdio.h>

enum { BYTES_POINTS = 32, BYTES_SAMPLES = 16, BYTES_WIDTH = 8, BYTES_HEIGHT = 4, BYTES_FRAMES = 3, BYTES_KINDS = 5 };

/* What one light is asked with, and room for the answers. */
typedef struct bytes_room {
    float texels[3 * BYTES_WIDTH * BYTES_HEIGHT * BYTES_FRAMES];
    float positions[3 * BYTES_POINTS], normals[3 * BYTES_POINTS], views[3 * BYTES_POINTS], tangents[3 * BYTES_POINTS];
    lsamp_material materials[BYTES_KINDS], of_points[BYTES_POINTS];
    lsamp_lobe lobes[2];
    float directions[3 * BYTES_POINTS * BYTES_SAMPLES], distances[BYTES_POINTS * BYTES_SAMPLES];
    float coords[3 * BYTES_POINTS * BYTES_SAMPLES], weights[3 * BYTES_POINTS * BYTES_SAMPLES];
    float patterns[2 * BYTES_SAMPLES * LSAMP_PATTERN_COUNT];
    float corners[9 * 20];
    uint64_t memory[8192];
} bytes_room;

static uint32_t bytes_next(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

static float bytes_unit(uint32_t *state) { return (float)(int32_t)(bytes_next(state) % 2049u) / 1024.0f - 1.0f; }

/* Values, not memory: the same for both byte orders. */
static uint32_t bytes_hash(uint32_t h, const float *values, size_t count)
{
    size_t i;
    uint32_t bits, k;
    for (i = 0; i < count; i++) {
        memcpy(&bits, values + i, sizeof bits);
        for (k = 0; k < 4; k++) h = (h ^ (bits >> 8 * k & 255u)) * 16777619u;
    }
    return h;
}

/* Unit vectors of fractions that floats hold nearly: 3/5, 4/5, 2/7, 3/7, 6/7 and signs. */
static void bytes_direction(uint32_t n, float *d)
{
    static const float parts[3][3] = { { 0.6f, 0.8f, 0.0f }, { 2.0f / 7.0f, 3.0f / 7.0f, 6.0f / 7.0f },
                                       { 0.0f, 1.0f, 0.0f } };
    uint32_t k;
    for (k = 0; k < 3; k++) d[k] = parts[n % 3u][(k + n / 3u) % 3u] * (n >> k & 8u ? -1.0f : 1.0f);
}

static void bytes_materials(bytes_room *room)
{
    lsamp_material *m = room->materials;
    uint32_t k, c;
    memset(m, 0, sizeof room->materials);
    memset(room->lobes, 0, sizeof room->lobes);
    for (k = 0; k < BYTES_KINDS; k++) {
        m[k].kind = (lsamp_material_kind)k;         /* the default first */
        for (c = 0; c < 3; c++) {
            m[k].diffuse[c] = 0.5f - 0.125f * (float)c;
            m[k].specular[c] = 0.25f;
        }
        m[k].exponent = 20;
        m[k].metallic = 0.25f;
        m[k].roughness = 0.375f;
    }
    for (k = 0; k < 2; k++) {
        room->lobes[k].axis[0] = -1.0f + 0.25f * (float)k;
        room->lobes[k].axis[1] = -1;
        room->lobes[k].axis[2] = 0.75f;
        room->lobes[k].exponent = k ? 3.0f : 12.0f;
        room->lobes[k].scale[0] = room->lobes[k].scale[1] = room->lobes[k].scale[2] = 0.125f;
    }
    m[LSAMP_MATERIAL_LAFORTUNE].lobes = room->lobes;
    m[LSAMP_MATERIAL_LAFORTUNE].lobe_count = 2;
    for (k = 0; k < BYTES_POINTS; k++) room->of_points[k] = m[k % BYTES_KINDS];
}

static void bytes_fill(bytes_room *room)
{
    uint32_t state = 99, i;
    for (i = 0; i < sizeof room->texels / sizeof *room->texels; i++)
        room->texels[i] = (float)(bytes_next(&state) % 64u) / 16.0f;
    for (i = 0; i < sizeof room->corners / sizeof *room->corners; i++) room->corners[i] = 2.0f * bytes_unit(&state);
    for (i = 0; i < BYTES_POINTS; i++) {
        room->positions[3 * i] = 2.0f * bytes_unit(&state);
        room->positions[3 * i + 1] = 0.5f * bytes_unit(&state) - 1.5f;
        room->positions[3 * i + 2] = 2.0f * bytes_unit(&state);
        bytes_direction(i % 9u, room->normals + 3 * i);
        bytes_direction(i * 5u % 9u, room->views + 3 * i);
        bytes_direction((i + 1u) % 9u, room->tangents + 3 * i);
        if (i == 7) memset(room->normals + 3 * i, 0, 3 * sizeof *room->normals);
    }
    bytes_materials(room);
}

static void bytes_shape(void *user, float time, const float x[3], float position[3], float normal[3], float *area)
{
    (void)user;
    position[0] = 2.0f * x[0] - 1.0f;
    position[1] = 2.0f + time;
    position[2] = 2.0f * x[1] - 1.0f;
    normal[0] = normal[2] = 0;
    normal[1] = -1;
    *area = 4;
}

static void bytes_emission(void *user, float time, const float x[3], const float direction[3], float rgb[3])
{
    (void)user;
    (void)time;
    rgb[0] = 0.5f + 0.5f * x[0];
    rgb[1] = 1;
    rgb[2] = 1.0f + 0.5f * direction[1];
}

static void bytes_light(lsamp_light_desc *d, const bytes_room *room, uint32_t kind, const lsamp_mesh *mesh)
{
    uint32_t c;
    memset(d, 0, sizeof *d);
    d->kind = (lsamp_light_kind)kind;
    for (c = 0; c < 3; c++) d->radiance[c] = 1.0f + 0.5f * (float)c;
    d->position[0] = 0.25f;
    d->position[1] = 2;
    d->direction[1] = kind == LSAMP_LIGHT_SUN ? 1.0f : -1.0f;
    d->u[0] = 1.5f;
    d->v[2] = 1.25f;
    d->radius = 0.5f;
    d->cone_half_angle = 0.75f;
    d->time = 0.0625f;
    d->rotation = 0.5f;
    if (kind == LSAMP_LIGHT_DISC || kind == LSAMP_LIGHT_RECTANGLE) d->cosine_power = 2.5f;
    if (kind == LSAMP_LIGHT_CALLBACK) {
        d->shape_fn = bytes_shape;
        d->emission_fn = bytes_emission;
    }
    if (kind == LSAMP_LIGHT_MESH) {
        d->mesh = mesh;
        d->place_count = 64;
    }
    if (kind <= LSAMP_LIGHT_ENVIRONMENT || (kind >= LSAMP_LIGHT_LINE && kind <= LSAMP_LIGHT_SPHERE)) {
        d->texels = room->texels;
        d->width = BYTES_WIDTH;
        d->height = kind == LSAMP_LIGHT_LINE ? 1 : BYTES_HEIGHT;
        d->frame_count = BYTES_FRAMES;
        d->loop = (int)(kind & 1u);
    }
}

static uint32_t bytes_emission_hash(uint32_t h, const lsamp_emission *e)
{
    h = bytes_hash(h, e->direction, 3);
    h = bytes_hash(h, &e->distance, 1);
    h = bytes_hash(h, e->coords, 3);
    h = bytes_hash(h, e->radiance, 3);
    return bytes_hash(h, &e->pdf, 1);
}

/* The light point by point: sampled, hit again, where maps of it look from, its pieces. */
static uint32_t bytes_points_of(const lsamp_light *light, const bytes_room *room)
{
    static float pieces[9 * 4096];
    uint32_t h = 2166136261u, state = 5, i, k;
    lsamp_domain domain;
    size_t count = lsamp_light_triangles(light, NULL);
    for (i = 0; i < BYTES_POINTS; i++) {
        const float *p = room->positions + 3 * i;
        float u[3];
        lsamp_emission e;
        for (k = 0; k < 3; k++) u[k] = (float)(bytes_next(&state) % 1024u) / 1024.0f;
        if (!lsamp_light_sample(light, p, u, &e)) continue;
        h = bytes_emission_hash(h, &e);
        if (lsamp_light_hit(light, p, e.direction, &e)) h = bytes_emission_hash(h ^ 1u, &e);
    }
    if (lsamp_light_domain(light, &domain) == LSAMP_OK) {
        h = bytes_hash(h ^ (uint32_t)domain.kind, domain.origin, 3);
        h = bytes_hash(bytes_hash(h, domain.u, 3), domain.v, 3);
        h = bytes_hash(h, domain.locations, 4 * domain.location_count);
    }
    if (count && count <= 4096u) {
        lsamp_light_triangles(light, pieces);
        h = bytes_hash(h ^ (uint32_t)count, pieces, 9 * count);
    }
    return h;
}

/* All points by one sampling, and their sum; 0 in *failed stays where all went well. */
static uint32_t bytes_samples_of(const lsamp_light *light, bytes_room *room, uint32_t sampling, int *failed)
{
    float sums[3 * BYTES_POINTS], visibility[BYTES_POINTS * BYTES_SAMPLES];
    uint32_t h = 2166136261u, i, with;
    for (with = 0; with < 2; with++) {
        lsamp_sample_desc desc;
        lsamp_points points;
        lsamp_samples samples;
        size_t useful = 0;
        memset(&desc, 0, sizeof desc);
        memset(&points, 0, sizeof points);
        desc.sample_count = BYTES_SAMPLES;
        desc.sampling = (lsamp_sampling)sampling;
        desc.seed = 3;
        desc.frame = with ? 300 : 1;
        desc.patterns = with ? room->patterns : NULL;
        points.count = BYTES_POINTS;
        points.positions = room->positions;
        points.normals = room->normals;
        points.to_eye = room->views;
        points.tangents = with ? NULL : room->tangents;
        points.materials = room->of_points;
        points.material_stride = sizeof(lsamp_material);
        samples.directions = room->directions;
        samples.distances = room->distances;
        samples.coords = room->coords;
        samples.weights = room->weights;
        if (lsamp_sample(&desc, light, &points, &samples, &useful) != LSAMP_OK) *failed = 1;
        h = bytes_hash(h ^ (uint32_t)useful, room->directions, 3 * BYTES_POINTS * BYTES_SAMPLES);
        h = bytes_hash(h, room->distances, BYTES_POINTS * BYTES_SAMPLES);
        h = bytes_hash(h, room->coords, 3 * BYTES_POINTS * BYTES_SAMPLES);
        h = bytes_hash(h, room->weights, 3 * BYTES_POINTS * BYTES_SAMPLES);
        for (i = 0; i < BYTES_POINTS * BYTES_SAMPLES; i++) visibility[i] = (float)(i % 5u) / 4.0f;
        memset(sums, 0, sizeof sums);
        if (lsamp_accumulate(BYTES_POINTS, BYTES_SAMPLES, room->weights, visibility, sums, 0) != LSAMP_OK) *failed = 1;
        h = bytes_hash(h, sums, 3 * BYTES_POINTS);
    }
    return h;
}

/* Each material by itself, direction by direction. */
static uint32_t bytes_material(const lsamp_material *m, const bytes_room *room, int *failed)
{
    uint32_t h = 2166136261u, i;
    for (i = 0; i < BYTES_POINTS; i++) {
        const float *n = room->normals + 3 * (i == 7 ? 0 : i), *wo = room->views + 3 * i;
        float u[2], wi[3], f[3], pdf;
        u[0] = (float)i / BYTES_POINTS;
        u[1] = (float)(i * 7u % BYTES_POINTS) / BYTES_POINTS;
        if (lsamp_brdf_sample(m, n, NULL, wo, u, wi, f, &pdf) != LSAMP_OK) *failed = 1;
        h = bytes_hash(bytes_hash(bytes_hash(h, wi, 3), f, 3), &pdf, 1);
        if (lsamp_brdf_eval(m, n, NULL, wo, room->views + 3 * ((i + 1u) % BYTES_POINTS), f, &pdf) != LSAMP_OK)
            *failed = 1;
        h = bytes_hash(bytes_hash(h, f, 3), &pdf, 1);
    }
    return h;
}

/* 0: written. */
static int bytes_lines(FILE *lines)
{
    static bytes_room room;
    uint32_t kind, sampling;
    lsamp_mesh mesh;
    int failed = 0;
    bytes_fill(&room);
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = room.corners;
    mesh.vertex_count = 60;
    if (lsamp_patterns_build(BYTES_SAMPLES, 4, room.patterns, sizeof room.patterns) != LSAMP_OK) return 1;
    fprintf(lines, "patterns %08x\n",
            (unsigned)bytes_hash(2166136261u, room.patterns, sizeof room.patterns / sizeof *room.patterns));
    for (kind = 0; kind < BYTES_KINDS; kind++)
        fprintf(lines, "material %u %08x\n", (unsigned)kind,
                (unsigned)bytes_material(&room.materials[kind], &room, &failed));
    for (kind = 0; kind <= LSAMP_LIGHT_MESH; kind++) {
        lsamp_light_desc d;
        lsamp_light *light;
        bytes_light(&d, &room, kind, &mesh);
        if (lsamp_light_init(&d, room.memory, sizeof room.memory, &light, NULL) != LSAMP_OK) return 1;
        fprintf(lines, "light %u %08x\n", (unsigned)kind, (unsigned)bytes_points_of(light, &room));
        for (sampling = 0; sampling < LSAMP_SAMPLING_COUNT; sampling++)
            fprintf(lines, "sample %u %u %08x\n", (unsigned)kind, (unsigned)sampling,
                    (unsigned)bytes_samples_of(light, &room, sampling, &failed));
    }
    return failed;
}

#ifndef LSAMP_BYTES_NO_MAIN
int main(void) { return bytes_lines(stdout); }
#endif
