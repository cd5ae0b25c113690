/* 04f_rsm_shadows.c - the light of a reflective shadow map with shadows: rsm.h gathers, and the maps of ism.h or csm.h
   say what each pixel sees of each light. One field of a desc is all that changes.

   cc -O2 04f_rsm_shadows.c -lm -o shadows && ./shadows bounce.ppm

   Three pictures side by side: sun falls through an open roof onto the red floor of a room, under a block that hangs in
   the air. Left nothing hides the light that the floor sends back, in the middle imperfect shadow maps do, drawn anew
   from a few points in no time, on the right coherent shadow maps, built once for lights that stay. */
#define RSM_IMPLEMENTATION
#include "rsm.h"
#define ISM_IMPLEMENTATION
#include "ism.h"
#define CSM_IMPLEMENTATION
#include "csm.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 240, HEIGHT = 160, PIXELS = WIDTH * HEIGHT, LIGHTS = 96 };

/* ---- the scene: boxes; a renderer has it anyway ---- */

typedef struct box { float lo[3], hi[3]; int inside; } box;

static const box boxes[2] = { { { -3, 0, -3 }, { 3, 3, 3 }, 1 }, { { -0.8f, 1, -1.2f }, { 0.8f, 1.3f, 0.4f }, 0 } };
static float corners[3 * 8 * 2];
static uint32_t triangles[2 * 36];
static float positions[3 * PIXELS], normals[3 * PIXELS], light[3][3 * PIXELS];

static void make_mesh(void)
{
    static const uint32_t faces[36] = { 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                        2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5 };
    uint32_t b, i, k;
    for (b = 0; b < 2; b++) {
        for (i = 0; i < 8; i++)
            for (k = 0; k < 3; k++) corners[3 * (8 * b + i) + k] = i >> k & 1u ? boxes[b].hi[k] : boxes[b].lo[k];
        for (i = 0; i < 36; i++) triangles[36 * b + i] = 8 * b + faces[i];
    }
}

/* Nearest wall along a ray: position and normal. */
static void trace(const float *o, const float *d, float *p, float *n)
{
    float best = 1e30f;
    int b, k, side, j;
    for (b = 0; b < 2; b++)
        for (k = 0; k < 3; k++)
            for (side = 0; side < 2; side++) {
                float plane = side ? boxes[b].hi[k] : boxes[b].lo[k], t = (plane - o[k]) / d[k], q[3];
                int out = side ? 1 : -1,
                    hit = t > 1e-4f && t < best && (d[k] > 0) == (boxes[b].inside ? out > 0 : out < 0);
                for (j = 0; j < 3 && hit; j++) {
                    q[j] = j == k ? plane : o[j] + t * d[j];
                    hit = j == k || (q[j] >= boxes[b].lo[j] && q[j] <= boxes[b].hi[j]);
                }
                if (!hit) continue;
                best = t;
                for (j = 0; j < 3; j++) {
                    p[j] = q[j];
                    n[j] = j == k ? (float)(boxes[b].inside ? -out : out) : 0.0f;
                }
            }
}

/* The sun's map of floor and block; its depths begin below the roof, so that sun falls through. */
static rsm_map *make_map(void)
{
    rsm_mesh meshes[2] = { { 0 }, { 0 } };
    rsm_desc desc = { 0 };
    rsm_map *map;
    int i, k;
    desc.light.direction[0] = -0.1f;
    desc.light.direction[1] = 1;
    desc.light.direction[2] = 0.05f;
    desc.light.position[1] = 1;
    desc.light.radius = 2.5f;
    desc.light.near_depth = -1.7f;
    desc.light.far_depth = 2;
    desc.side = 128;
    for (i = 0; i < 2; i++) {
        meshes[i].positions = corners;
        meshes[i].vertex_count = 16;
        meshes[i].indices = triangles + 36 * i;
        meshes[i].index_count = 36;
        for (k = 0; k < 3; k++) {
            meshes[i].albedo[k] = i == 0 && k ? 0.2f : 0.7f;
            desc.light.value[k] = 20;
        }
    }
    if (rsm_map_create(&desc, &map) != RSM_OK) return NULL;
    if (rsm_rasterize(map, meshes, 2) == RSM_OK && rsm_finish(map, NULL) == RSM_OK) return map;
    rsm_map_free(map);
    return NULL;
}

/* ---- maps of what hides the lights: ism.h, csm.h ---- */

static ism_maps *draw_points(const rsm_texel *lights, uint32_t count)
{
    ism_mesh mesh = { corners, 16, 0, triangles, 72, NULL, NULL, NULL, NULL, NULL };
    ism_source source = { ISM_SOURCE_SURFACE, 0, 1, 1, lights->position, sizeof *lights, lights->normal, sizeof *lights,
                          lights->flux, sizeof *lights, &lights->area, sizeof *lights, NULL, 0 };
    ism_points view = { 0 };
    ism_frame frame = { &mesh, &source, 1, &view, 0 };
    ism_desc desc = { 0 };
    ism_maps *maps;
    source.width = count;
    view.count = PIXELS;
    view.positions = positions;
    view.normals = normals;
    desc.vpl_count = LIGHTS;
    desc.surfel_count = 4096;
    if (ism_create(&desc, &maps) != ISM_OK) return NULL;
    if (ism_set_sources(maps, &source, 1) == ISM_OK && ism_build(maps, &frame) == ISM_OK) return maps;
    ism_free(maps);
    return NULL;
}

static cohsm_maps *build_maps(const rsm_texel *lights, size_t count)
{
    static float locations[4 * LIGHTS];
    cohsm_mesh mesh = { corners, 16, 0, triangles, 72, NULL, NULL, NULL };
    cohsm_desc desc = { 0 };
    cohsm_maps *maps;
    cohsm_light_locations(lights->position, sizeof *lights, lights->normal, sizeof *lights, count, 0.01f, locations);
    desc.domain.kind = COHSM_DOMAIN_LIST;
    desc.domain.locations = locations;
    desc.domain.location_count = count;
    desc.order = COHSM_ORDER_SCANLINE;
    desc.map_side = 64;
    return cohsm_build(&desc, &mesh, &maps, NULL) == COHSM_OK ? maps : NULL;
}

static int write_picture(const char *name)
{
    FILE *file = fopen(name, "wb");
    int x, y, i, k;
    if (!file) return 0;
    fprintf(file, "P6 %d %d 255\n", 3 * WIDTH, HEIGHT);
    for (y = 0; y < HEIGHT; y++)
        for (i = 0; i < 3; i++)
            for (x = 0; x < WIDTH; x++)
                for (k = 0; k < 3; k++) {
                    float v = powf(0.06f * light[i][3 * (y * WIDTH + x) + k], 1 / 2.2f);
                    fputc((int)(255 * (v < 1 ? v : 1) + 0.5f), file);
                }
    return fclose(file) == 0;
}

int main(int count, char **values)
{
    static rsm_texel lights[LIGHTS];
    const float eye[3] = { 0, 1.6f, 2.9f };
    rsm_points points = { 0 };
    rsm_gather_desc gather = { 0 };
    cohsm_instance instance = { 0 };
    cohsm_sight coherent = { 0 };
    ism_sight imperfect = { 0 };
    ism_maps *drawn = NULL;
    cohsm_maps *built = NULL;
    rsm_map *map;
    size_t found = 0;
    double sum[3] = { 0, 0, 0 };
    int x, y, i, ok;

    make_mesh();
    for (y = 0; y < HEIGHT; y++)            /* the G-buffer */
        for (x = 0; x < WIDTH; x++) {
            float d[3] = { ((float)x + 0.5f - WIDTH / 2) / HEIGHT, (HEIGHT / 2 - (float)y - 0.5f) / HEIGHT, -0.7f };
            trace(eye, d, positions + 3 * (y * WIDTH + x), normals + 3 * (y * WIDTH + x));
        }
    points.count = PIXELS;
    points.positions = positions;
    points.normals = normals;
    gather.sample_count = LIGHTS;           /* by flux: these lights have numbers, and rsm_pixel_lights lists them */
    gather.near_limit = 0.25f;
    map = make_map();
    ok = map && rsm_pixel_lights((const rsm_map *const *)&map, 1, LIGHTS, 0, lights, LIGHTS, &found) == RSM_OK;
    if (ok) drawn = draw_points(lights, (uint32_t)found);
    if (ok) built = build_maps(lights, found);
    ok = drawn && built;
    imperfect.maps = drawn;
    instance.maps = built;
    coherent.instances = &instance;
    coherent.instance_count = 1;
    coherent.query.light_kind = COHSM_LIGHT_INDEX;
    for (i = 0; i < 3 && ok; i++) {
        gather.visible_fn = i == 0 ? NULL : i == 1 ? ism_see : cohsm_see;
        gather.visible_user = i == 1 ? (void *)&imperfect : (void *)&coherent;
        ok = rsm_gather((const rsm_map *const *)&map, 1, &gather, &points, light[i], NULL) == RSM_OK;
        for (x = 0; x < 3 * PIXELS; x++) sum[i] += (double)light[i][x];
    }
    if (ok)
        printf("%u lights; of their light imperfect maps let %.1f %% through, coherent maps %.1f %%\n",
               (unsigned)found, 100 * sum[1] / sum[0], 100 * sum[2] / sum[0]);
    ok = ok && write_picture(count > 1 ? values[1] : "bounce.ppm");
    cohsm_free(built);
    ism_free(drawn);
    rsm_map_free(map);
    if (!ok) fprintf(stderr, "no memory, or the picture cannot be written\n");
    return !ok;
}
