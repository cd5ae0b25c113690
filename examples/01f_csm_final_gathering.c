/* 01f_csm_final_gathering.c - bounced light by final gathering: the surfaces of a room are the light.

   cc -O2 01f_csm_final_gathering.c -lm -o gathering && ./gathering room.ppm

   lightsampling.h takes all surfaces as one emissive mesh and gives PLACES places on them, in an order that runs along
   the surfaces; csm.h makes cube maps there, and a few more on the lamp. The lamp lights the places, whose light is
   gathered from all others, bounce by bounce; then every pixel gathers it once more. At last the maps of an eighth of
   the places, chosen by measured error, answer in place of all; as many maps spread evenly are compared with them. */
#define CSM_IMPLEMENTATION
#define LIGHTSAMPLING_IMPLEMENTATION
#include "csm.h"
#include "lightsampling.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 160, HEIGHT = 128, PIXELS = WIDTH * HEIGHT, PLACES = 1024, FEW = PLACES / 8, LAMP = 16, SAMPLES = 96,
       BOUNCES = 4, FACES = 16, LAMP_FACE = 5, BOXES = 7 };

/* ---- the room: inner faces that are lit and shine (corner, edge, edge; normal = edge x edge; colour), and boxes that
        hide: walls of some thickness, and two blocks ---- */

typedef struct face { float p[3], u[3], v[3], color[3]; } face;

static const face room[6] = {
    { { -1, 0, 1 }, { 2, 0, 0 }, { 0, 0, -2 }, { 0.7f, 0.7f, 0.7f } },              /* floor */
    { { -1, 2, -1 }, { 2, 0, 0 }, { 0, 0, 2 }, { 0.7f, 0.7f, 0.7f } },              /* ceiling */
    { { -1, 0, -1 }, { 2, 0, 0 }, { 0, 2, 0 }, { 0.7f, 0.7f, 0.7f } },              /* back */
    { { -1, 0, 1 }, { 0, 0, -2 }, { 0, 2, 0 }, { 0.7f, 0.1f, 0.08f } },             /* left */
    { { 1, 0, -1 }, { 0, 0, 2 }, { 0, 2, 0 }, { 0.1f, 0.6f, 0.12f } },              /* right */
    { { -0.3f, 1.98f, -0.3f }, { 0.6f, 0, 0 }, { 0, 0, 0.6f }, { 0, 0, 0 } }        /* the lamp */
};
static const float boxes[BOXES][6] = {
    { -1.2f, -0.2f, -1.2f, 1.2f, 0, 1.2f },
    { -1.2f, 2, -1.2f, 1.2f, 2.2f, 1.2f },
    { -1.2f, 0, -1.2f, 1.2f, 2, -1 },
    { -1.2f, 0, -1, -1, 2, 1.2f },
    { 1, 0, -1, 1.2f, 2, 1.2f },
    { -0.65f, 0, -0.6f, -0.1f, 1.2f, -0.1f },
    { 0.15f, 0, 0, 0.7f, 0.55f, 0.55f }
};
static face faces[FACES];
static int face_count;

static void add_face(const face *f) { faces[face_count++] = *f; }

static void make_faces(void)
{
    int i, b;
    for (i = 0; i < 6; i++) add_face(&room[i]);
    for (b = 5; b < BOXES; b++) {                           /* of blocks all sides but the bottom */
        const float *lo = boxes[b], *hi = boxes[b] + 3;
        const float w = hi[0] - lo[0], h = hi[1] - lo[1], d = hi[2] - lo[2];
        const face sides[5] = {
            { { lo[0], hi[1], hi[2] }, { w, 0, 0 }, { 0, 0, -d }, { 0.7f, 0.7f, 0.7f } },
            { { lo[0], lo[1], hi[2] }, { w, 0, 0 }, { 0, h, 0 }, { 0.7f, 0.7f, 0.7f } },
            { { hi[0], lo[1], lo[2] }, { -w, 0, 0 }, { 0, h, 0 }, { 0.7f, 0.7f, 0.7f } },
            { { hi[0], lo[1], hi[2] }, { 0, 0, -d }, { 0, h, 0 }, { 0.7f, 0.7f, 0.7f } },
            { { lo[0], lo[1], lo[2] }, { 0, 0, d }, { 0, h, 0 }, { 0.7f, 0.7f, 0.7f } }
        };
        for (i = 0; i < 5; i++) add_face(&sides[i]);
    }
}

static float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void face_normal(const face *f, float *n)
{
    float length;
    int k;
    for (k = 0; k < 3; k++) n[k] = f->u[(k + 1) % 3] * f->v[(k + 2) % 3] - f->u[(k + 2) % 3] * f->v[(k + 1) % 3];
    length = sqrtf(dot(n, n));
    for (k = 0; k < 3; k++) n[k] /= length;
}

/* Distance along a ray to a face that is seen from its front; 0: none. */
static float hit_face(const face *f, const float *from, const float *direction)
{
    float n[3], d[3], t, along;
    int k;
    face_normal(f, n);
    for (k = 0; k < 3; k++) d[k] = f->p[k] - from[k];
    along = dot(n, direction);
    t = along < 0 ? dot(n, d) / along : 0;
    if (t <= 1e-4f) return 0;
    for (k = 0; k < 3; k++) d[k] = t * direction[k] - d[k];
    if (dot(d, f->u) < 0 || dot(d, f->u) > dot(f->u, f->u)) return 0;
    return dot(d, f->v) < 0 || dot(d, f->v) > dot(f->v, f->v) ? 0 : t;
}

/* ---- what shines: the light that leaves each place, along the whole piece that it stands for ---- */

static float leaving[PLACES][3];

static void shine(void *user, float time, const float x[3], const float direction[3], float rgb[3])
{
    (void)user, (void)time, (void)direction;
    memcpy(rgb, leaving[(int)(x[0] * PLACES) % PLACES], 12);
}

/* Makes a light of faces; by what leaves the places, or, of the lamp, of this radiance. */
static lsamp_light *make_light(const face *f, int n, uint32_t places, const float *radiance)
{
    static float corners[FACES * 4][3];
    static uint32_t triangles[FACES * 6];
    static const uint32_t order[6] = { 0, 1, 2, 2, 1, 3 };
    static const float one[3] = { 1, 1, 1 };
    lsamp_mesh mesh;
    lsamp_light_desc desc;
    lsamp_light *light = NULL;
    void *memory;
    int i, k;
    for (i = 0; i < n; i++) {
        for (k = 0; k < 12; k++) {
            const int c = k / 3, a = k % 3;
            corners[4 * i + c][a] = f[i].p[a] + (c & 1 ? f[i].u[a] : 0) + (c & 2 ? f[i].v[a] : 0);
        }
        for (k = 0; k < 6; k++) triangles[6 * i + k] = (uint32_t)(4 * i) + order[k];
    }
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = corners[0];
    mesh.vertex_count = (size_t)(4 * n);
    mesh.indices = triangles;
    mesh.index_count = (size_t)(6 * n);
    memset(&desc, 0, sizeof desc);
    desc.kind = LSAMP_LIGHT_MESH;
    desc.mesh = &mesh;
    desc.place_count = places;
    desc.radius = 0.01f;                                    /* so far off the surfaces maps stand */
    desc.emission_fn = radiance ? NULL : shine;
    memcpy(desc.radiance, radiance ? radiance : one, sizeof desc.radiance);
    memory = malloc(lsamp_light_bytes(&desc));
    return memory && lsamp_light_init(&desc, memory, lsamp_light_bytes(&desc), &light, NULL) == LSAMP_OK ? light : NULL;
}

/* ---- maps ---- */

static cohsm_maps *make_maps(const float *locations, uint32_t count)
{
    static float corners[BOXES * 8][3];
    static uint32_t triangles[BOXES * 36];
    static const uint8_t quads[6][4] = { { 1, 3, 7, 5 }, { 0, 4, 6, 2 }, { 2, 6, 7, 3 }, { 0, 1, 5, 4 }, { 4, 5, 7, 6 },
                                         { 0, 2, 3, 1 } };
    cohsm_mesh mesh;
    cohsm_desc desc;
    cohsm_maps *maps = NULL;
    uint32_t b, i, k, n = 0;
    for (b = 0; b < BOXES; b++) {
        for (i = 0; i < 24; i++) corners[8 * b + i / 3][i % 3] = boxes[b][i % 3 + (i / 3 >> i % 3 & 1 ? 3 : 0)];
        for (i = 0; i < 6; i++)
            for (k = 0; k < 6; k++) triangles[n++] = 8 * b + quads[i][k < 3 ? k : (k == 3 ? 0 : k - 2)];
    }
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = corners[0];
    mesh.vertex_count = BOXES * 8;
    mesh.indices = triangles;
    mesh.index_count = n;
    memset(&desc, 0, sizeof desc);
    desc.domain.kind = COHSM_DOMAIN_LIST;
    desc.domain.locations = locations;
    desc.domain.location_count = count;
    desc.map_side = 48;
    return cohsm_build(&desc, &mesh, &maps, NULL) == COHSM_OK ? maps : NULL;
}

/* ---- gathering ---- */

typedef struct points { size_t count; float *positions, *normals, *radiance; lsamp_material *materials; } points;

static points make_points(size_t count)
{
    points p;
    p.count = count;
    p.positions = (float *)calloc(9 * count, sizeof(float));
    p.materials = (lsamp_material *)calloc(count, sizeof *p.materials);
    if (!p.positions || !p.materials) {
        fputs("out of memory\n", stderr);
        exit(1);
    }
    p.normals = p.positions + 3 * count;
    p.radiance = p.normals + 3 * count;
    return p;
}

static void set_point(points *p, size_t i, const face *f, const float *position)
{
    memcpy(p->positions + 3 * i, position, 12);
    face_normal(f, p->normals + 3 * i);
    memcpy(p->materials[i].diffuse, f->color, 12);
}

typedef struct source { lsamp_light *light; lsamp_domain domain; cohsm_maps *maps; } source;

static int make_source(source *s, const face *f, int n, uint32_t places, const float *radiance)
{
    s->light = make_light(f, n, places, radiance);
    if (!s->light || lsamp_light_domain(s->light, &s->domain) != LSAMP_OK) return 0;
    s->maps = make_maps(s->domain.locations, places);
    return s->maps != NULL;
}

static void free_source(source *s)
{
    cohsm_free(s->maps);
    free(s->light);
}

/* Adds what each point receives from a source, through its material, to its radiance. `maps` answer, those with the
   numbers in `instead`; NULL: each place's own. The answers are written to `answers` unless that is NULL. */
static int gather(const points *p, const source *s, const cohsm_maps *maps, const uint32_t *instead, float *answers)
{
    enum { BLOCK = 1024 };
    static float directions[BLOCK * SAMPLES * 3], distances[BLOCK * SAMPLES], coords[BLOCK * SAMPLES * 3];
    static float weights[BLOCK * SAMPLES * 3], from[BLOCK * SAMPLES * 3], visible[BLOCK * SAMPLES];
    static uint32_t pixels[BLOCK], index[BLOCK * SAMPLES];
    const lsamp_samples out = { directions, distances, coords, weights };
    lsamp_sample_desc desc;
    lsamp_points batch;
    cohsm_query query;
    size_t first, i, k, n;

    memset(&desc, 0, sizeof desc);
    memset(&batch, 0, sizeof batch);
    memset(&query, 0, sizeof query);
    desc.sample_count = SAMPLES;
    batch.material_stride = sizeof(lsamp_material);
    batch.pixels = pixels;
    query.positions = from;
    query.lights = index;
    query.light_kind = COHSM_LIGHT_INDEX;
    for (first = 0; first < p->count; first += n) {
        n = p->count - first < BLOCK ? p->count - first : BLOCK;
        for (i = 0; i < n; i++) pixels[i] = (uint32_t)(first + i);
        batch.count = n;
        batch.positions = p->positions + 3 * first;
        batch.normals = p->normals + 3 * first;
        batch.materials = p->materials + first;
        if (lsamp_sample(&desc, s->light, &batch, &out, NULL) != LSAMP_OK) return 0;
        for (i = 0; i < n * SAMPLES; i++) {
            const uint32_t places = s->domain.side[0], place = (uint32_t)(coords[3 * i] * (float)places) % places;
            /* What lies within 7 cm or so counts less: its share would be noise. */
            const float d = distances[i] < 10 ? distances[i] : 10, share = d * d / (d * d + 0.005f);
            for (k = 0; k < 3; k++) weights[3 * i + k] *= share;
            index[i] = instead ? instead[place] : place;
            memcpy(from + 3 * i, p->positions + 3 * (first + i / SAMPLES), 12);
        }
        query.count = n * SAMPLES;
        if (cohsm_visible(maps, &query, visible, NULL) != COHSM_OK ||
            lsamp_accumulate(n, SAMPLES, weights, visible, p->radiance + 3 * first, 0) != LSAMP_OK)
            return 0;
        if (answers) memcpy(answers + first * SAMPLES, visible, n * SAMPLES * sizeof *visible);
    }
    return 1;
}

/* Bounce by bounce: each place sends on what it receives from the lamp, and from all places in the bounce before. */
static int bounce(const source *all, const source *lamp)
{
    const float *locations = all->domain.locations;
    static float direct[PLACES * 3];
    points p = make_points(PLACES);
    int i, k, n, f;
    for (i = 0; i < PLACES; i++)
        for (f = 0; f < face_count; f++) {                  /* the face that the place stands before */
            float normal[3], down[3], at[3], t;
            face_normal(&faces[f], normal);
            for (k = 0; k < 3; k++) down[k] = -normal[k];
            t = hit_face(&faces[f], locations + 4 * i, down);
            if (t <= 0 || t > 0.011f) continue;
            for (k = 0; k < 3; k++) at[k] = locations[4 * i + k] + t * down[k];
            set_point(&p, (size_t)i, &faces[f], at);
        }
    if (!gather(&p, lamp, lamp->maps, NULL, NULL)) return 0;
    memcpy(direct, p.radiance, sizeof direct);
    for (n = 0; n < BOUNCES; n++) {
        memcpy(leaving, p.radiance, sizeof leaving);
        memcpy(p.radiance, direct, sizeof direct);
        if (!gather(&p, all, all->maps, NULL, NULL)) return 0;
    }
    free(p.positions);
    free(p.materials);
    return 1;
}

static points see(void)
{
    points p = make_points(PIXELS);
    int i, f, k;
    for (i = 0; i < PIXELS; i++) {
        const float eye[3] = { 0, 1, 4.2f };
        float direction[3], nearest = 1e9f, at[3];
        direction[0] = ((float)(i % WIDTH) + 0.5f - WIDTH / 2) / (HEIGHT * 1.35f);
        direction[1] = (HEIGHT / 2 - (float)(i / WIDTH) - 0.5f) / (HEIGHT * 1.35f);
        direction[2] = -1;
        p.radiance[3 * i] = 0;
        for (f = 0; f < face_count; f++) {
            const float t = hit_face(&faces[f], eye, direction);
            if (t <= 0 || t >= nearest) continue;
            nearest = t;
            for (k = 0; k < 3; k++) at[k] = eye[k] + t * direction[k];
            set_point(&p, (size_t)i, &faces[f], at);
            for (k = 0; k < 3 && f == LAMP_FACE; k++) p.normals[3 * i + k] = 0;     /* no receiver: drawn white */
        }
    }
    return p;
}

static int save(const points *p, const char *path)
{
    FILE *f = fopen(path, "wb");
    int i, k;
    if (!f) return 0;
    fprintf(f, "P6 %d %d 255\n", WIDTH, HEIGHT);
    for (i = 0; i < PIXELS; i++)
        for (k = 0; k < 3; k++) {
            const int lamp = p->normals[3 * i + 1] == 0 && p->normals[3 * i] == 0 && p->normals[3 * i + 2] == 0 &&
                             p->positions[3 * i + 1] > 1.9f;
            const float v = lamp ? 1.0f : powf(p->radiance[3 * i + k] > 1 ? 1.0f : p->radiance[3 * i + k], 1 / 2.2f);
            putc((int)(255 * v + 0.5f), f);
        }
    return fclose(f) == 0;
}

/* Answers of the maps of few places in the gathering of all pixels, off those of all places, in percent. */
static double compare(points *p, const source *all, const uint32_t *places, const uint32_t *instead,
                      const float *wanted, size_t *bytes)
{
    static float few[FEW][4];
    float *answers = (float *)malloc((size_t)PIXELS * SAMPLES * sizeof *answers);
    cohsm_maps *maps;
    cohsm_info info;
    double off = 0;
    size_t i;
    for (i = 0; i < FEW; i++) memcpy(few[i], all->domain.locations + 4 * places[i], 16);
    maps = make_maps(few[0], FEW);
    if (!answers || !maps || !gather(p, all, maps, instead, answers)) return -1;
    for (i = 0; i < (size_t)PIXELS * SAMPLES; i++) off += fabs((double)answers[i] - (double)wanted[i]);
    cohsm_get_info(maps, &info);
    *bytes = info.bytes;
    cohsm_free(maps);
    free(answers);
    return 100 * off / ((double)PIXELS * SAMPLES);
}

int main(int count, char **values)
{
    static uint32_t places[FEW], instead[PLACES], even[FEW], even_instead[PLACES];
    float *wanted = (float *)malloc((size_t)PIXELS * SAMPLES * sizeof *wanted), *some;
    static const float radiance[3] = { 14, 12, 10 };
    cohsm_places_desc choice;
    cohsm_info info;
    source all, lamp;
    points seen;
    size_t bytes[2] = { 0, 0 };
    double error, off[2];
    int i;

    make_faces();
    if (!wanted || !make_source(&all, faces, face_count, PLACES, NULL) ||
        !make_source(&lamp, &faces[LAMP_FACE], 1, LAMP, radiance) || !bounce(&all, &lamp))
        return 1;
    seen = see();
    if (!gather(&seen, &lamp, lamp.maps, NULL, NULL) || !gather(&seen, &all, all.maps, NULL, wanted) ||
        !save(&seen, count > 1 ? values[1] : "room.ppm"))
        return 1;

    some = (float *)calloc(3 * (PIXELS / 16), sizeof *some);                        /* points as those that ask */
    if (!some) return 1;
    for (i = 0; i < PIXELS / 16; i++) memcpy(some + 3 * i, seen.positions + 3 * (16 * i + i % 16), 12);
    memset(&choice, 0, sizeof choice);
    choice.candidates = all.maps;
    choice.receivers = some;
    choice.receiver_count = PIXELS / 16;
    choice.place_count = FEW;
    if (cohsm_places_choose(&choice, places, instead, &error) != COHSM_OK) return 1;
    for (i = 0; i < PLACES; i++) even_instead[i] = (uint32_t)(i * FEW / PLACES);
    for (i = 0; i < FEW; i++) even[i] = (uint32_t)((2 * i + 1) * (PLACES / FEW) / 2);
    cohsm_get_info(all.maps, &info);
    off[0] = compare(&seen, &all, places, instead, wanted, &bytes[0]);
    off[1] = compare(&seen, &all, even, even_instead, wanted, &bytes[1]);
    printf("maps of %d places: %.2f MB\n", PLACES, (double)info.bytes / 1e6);
    printf("maps of %d, chosen by error: %.2f MB, %.2f %% of the answers differ\n", FEW, (double)bytes[0] / 1e6,
           off[0]);
    printf("maps of %d, spread evenly:   %.2f MB, %.2f %%\n", FEW, (double)bytes[1] / 1e6, off[1]);
    free_source(&all);
    free_source(&lamp);
    free(seen.positions);
    free(seen.materials);
    free(some);
    free(wanted);
    return !(off[0] >= 0 && off[0] < off[1]);
}
