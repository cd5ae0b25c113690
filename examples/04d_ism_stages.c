/* 04d_ism_stages.c - ism.h stage by stage, with a look at what each stage leaves: for those who want to know why a
   picture is as it is, or who choose lights in their own way.

   cc -O2 04d_ism_stages.c -lm -o stages && ./stages stages.ppm

   Four panels: what the lit floor's texels are worth to the picture (bright: chosen often) with the lights that were
   chosen (green); one light's depth map, and over it, seen from above, the surfels that it is made of (green); the
   light of the first bounce; the light of the second, whose sources come out of the first one's maps. On stdout: what
   the map shows, texel by texel; how much light the second bounce brings; and a list of one's own, every other light
   with twice the flux, over the whole list. */
#define ISM_IMPLEMENTATION
#include "ism.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { SIDE = 192, RSM = 64, VPLS = 256, SURFELS = 2048, TILE = 64, BOUNCE = 4 };

static unsigned char picture[SIDE][4 * SIDE][3];

/* ---- the scene: a room without a front wall, a block that hangs in it, the sun's square on the floor ---- */

static float corners[16 * 3], lit_at[3 * RSM * RSM], lit_normal[3 * RSM * RSM], lit_flux[3 * RSM * RSM];
static float seen_at[3 * SIDE * SIDE], seen_normal[3 * SIDE * SIDE];
static const uint16_t triangles[] = { 0, 2, 3, 0, 3, 1, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3,
                                      0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5,
                                      8, 10, 11, 8, 11, 9, 12, 13, 15, 12, 15, 14, 8, 9, 13, 8, 13, 12,
                                      10, 14, 15, 10, 15, 11, 8, 12, 14, 8, 14, 10, 9, 11, 15, 9, 15, 13 };
enum { CORNERS = 16, INDICES = sizeof triangles / sizeof triangles[0] };

static void make_corners(void)
{
    static const float boxes[2][2][3] = { { { -2, 0, -2 }, { 2, 3, 2 } },
                                          { { -0.7f, 1, -0.7f }, { 0.7f, 1.3f, 0.7f } } };
    int b, i, k;
    for (b = 0; b < 2; b++)
        for (i = 0; i < 8; i++)
            for (k = 0; k < 3; k++) corners[3 * (8 * b + i) + k] = boxes[b][i >> k & 1][k];
}

/* What an eye in front of the room sees of walls and ceiling and of the block's lower side, looking up a little. */
static void look(void)
{
    const float lo[3] = { -2, 0, -2 }, hi[3] = { 2, 3, 9 }, eye[3] = { 0, 0.4f, 5 };
    int x, y, k;
    for (y = 0; y < SIDE; y++)
        for (x = 0; x < SIDE; x++) {
            float d[3] = { ((float)x + 0.5f) / SIDE - 0.5f, 0.62f - ((float)y + 0.5f) / SIDE, -1.2f }, t = 1e9f;
            float *p = seen_at + 3 * (y * SIDE + x), *n = seen_normal + 3 * (y * SIDE + x);
            int axis = 0;
            for (k = 0; k < 3; k++) {
                float to = ((d[k] > 0 ? hi[k] : lo[k]) - eye[k]) / d[k];
                if (to < t) t = to, axis = k;
            }
            n[0] = n[1] = n[2] = 0;
            n[axis] = d[axis] > 0 ? -1.0f : 1.0f;
            if (d[1] > 0 && (1 - eye[1]) / d[1] < t) {          /* the plane of the block's lower side */
                float to = (1 - eye[1]) / d[1], px = eye[0] + to * d[0], pz = eye[2] + to * d[2];
                if (px > -0.7f && px < 0.7f && pz > -0.7f && pz < 0.7f) {
                    t = to;
                    n[0] = n[2] = 0;
                    n[1] = -1;
                }
            }
            for (k = 0; k < 3; k++) p[k] = eye[k] + t * d[k];
        }
}

static void light_the_floor(void)
{
    int i;
    for (i = 0; i < RSM * RSM; i++) {
        lit_at[3 * i] = 2.4f * ((float)(i % RSM) + 0.5f) / RSM - 1.6f;
        lit_at[3 * i + 2] = 2.4f * ((float)(i / RSM) + 0.5f) / RSM - 0.8f;
        lit_normal[3 * i + 1] = 1;
        lit_flux[3 * i] = 20 * 0.8f * (2.4f / RSM) * (2.4f / RSM);     /* irradiance x albedo x area; a warm floor */
        lit_flux[3 * i + 1] = 0.7f * lit_flux[3 * i];
        lit_flux[3 * i + 2] = 0.5f * lit_flux[3 * i];
    }
}

/* ---- pictures of what the stages leave ---- */

static void put(int panel, int x, int y, float r, float g, float b)
{
    const float value[3] = { r, g, b };
    int k;
    if (x < 0 || y < 0 || x >= SIDE || y >= SIDE) return;
    for (k = 0; k < 3; k++) {
        float v = value[k] > 0 ? powf(value[k], 1 / 2.2f) : 0;
        picture[y][panel * SIDE + x][k] = (unsigned char)(255 * (v < 1 ? v : 1) + 0.5f);
    }
}

static void show_choice(const ism_maps *maps)
{
    size_t count, i;
    const float *importance = ism_importances(maps, 0, &count);
    const ism_vpl *vpls;
    float most = 0;
    int x, y;
    for (i = 0; i < count; i++) most = importance[i] > most ? importance[i] : most;
    for (y = 0; y < SIDE; y++)
        for (x = 0; x < SIDE; x++) {
            float v = importance[y * RSM / SIDE * RSM + x * RSM / SIDE] / most;
            put(0, x, y, v, v, v);
        }
    vpls = ism_vpls(maps, &count);
    for (i = 0; i < count; i++)
        put(0, (int)(vpls[i].texel % RSM) * SIDE / RSM + 1, (int)(vpls[i].texel / RSM) * SIDE / RSM + 1, 0, 1, 0);
}

/* The map as it lies in the atlas, near things bright, and the surfels where they lie in the room, seen from above. */
static int show_map(const ism_maps *maps, uint32_t vpl)
{
    static ism_surfel surfels[SURFELS];
    uint32_t side, across;
    size_t count, i;
    int x, y, k;
    const float *atlas = ism_atlas(maps, &side, &across);
    if (!atlas || ism_surfels(maps, vpl, surfels, SURFELS, &count) != ISM_OK) return 0;
    atlas += (size_t)(vpl / across) * TILE * side + (size_t)(vpl % across) * TILE;
    for (y = 0; y < SIDE; y++)
        for (x = 0; x < SIDE; x++) {
            float depth = atlas[(size_t)(y * TILE / SIDE) * side + (size_t)(x * TILE / SIDE)];
            float v = depth < ISM_FAR ? 0.6f / (1 + depth * depth) : 0;
            put(1, x, y, v, v, depth < ISM_FAR ? v : 0.1f);
        }
    for (i = 0; i < count; i++) {
        const uint16_t *t = triangles + 3 * surfels[i].triangle;
        const float *b = surfels[i].barycentric;
        float at[3];
        for (k = 0; k < 3; k++)
            at[k] = (1 - b[0] - b[1]) * corners[3 * t[0] + k] + b[0] * corners[3 * t[1] + k] +
                    b[1] * corners[3 * t[2] + k];
        put(1, (int)((at[0] + 2) / 4 * SIDE), (int)((at[2] + 2) / 4 * SIDE), 0, 0.5f, 0);
    }
    return 1;
}

/* The axes of a tile, as ism.h has them: z is the light's normal. */
static void axes_of(const float z[3], float axes[3][3])
{
    const float s = z[2] >= 0 ? 1.0f : -1.0f, t = -1 / (s + z[2]);
    const float xy[2][3] = { { 1 + s * t * z[0] * z[0], s * t * z[0] * z[1], -s * z[0] },
                             { t * z[0] * z[1], s + t * z[1] * z[1], -z[1] } };
    memcpy(axes[0], xy, sizeof xy);
    memcpy(axes[2], z, 3 * sizeof *z);
}

/* The map read as a shader would: from a place to its texel and the depth there, and from a texel back to a place; and
   the library's own answers, which follow the receiver's plane within a texel. */
static ism_result read_map(const ism_maps *maps, uint32_t number, const ism_points *points)
{
    static float visible[SIDE * SIDE];
    const float middle[2] = { 0.5f, 0.5f };
    uint32_t side, across, seen = 0, same = 0;
    size_t count;
    const ism_vpl *v = ism_vpls(maps, &count) + number;
    const float *atlas = ism_atlas(maps, &side, &across) + (size_t)(number / across) * TILE * side +
                         (size_t)(number % across) * TILE;
    float axes[3][3], local[3], place[3];
    float uv[2], at[2], depth, alike = 0;
    int i, k, j;
    ism_result result = ism_visible(maps, number, points, 0, visible);
    axes_of(v->normal, axes);
    for (i = 0; i < SIDE * SIDE; i++) {
        float d[3], length = 0;
        for (k = 0; k < 3; k++) {
            d[k] = seen_at[3 * i + k] - v->position[k];
            length += d[k] * d[k];
        }
        length = sqrtf(length);
        for (k = 0; k < 3; k++)
            for (local[k] = 0, j = 0; j < 3; j++) local[k] += axes[k][j] * d[j] / length;
        if (!ism_map_coordinates(ISM_PROJECTION_COSINE, 1, local, uv)) continue;        /* behind the light */
        ism_zoom(v->window, TILE, TILE / 8, uv, at);
        for (k = 0; k < 2; k++) at[k] = at[k] < 0.999f ? at[k] : 0.999f;
        depth = atlas[(size_t)(at[1] * TILE) * side + (size_t)(at[0] * TILE)];
        seen++;
        same += depth > 0.9f * length;
        alike += depth > 0.9f * length ? visible[i] : 1 - visible[i];
    }
    ism_unzoom(v->window, TILE, TILE / 8, middle, uv);
    ism_map_direction(ISM_PROJECTION_COSINE, 1, uv, local);
    depth = atlas[(size_t)(TILE / 2) * side + TILE / 2];
    for (k = 0; k < 3; k++)
        for (place[k] = v->position[k], j = 0; j < 3; j++) place[k] += depth * axes[j][k] * local[j];
    printf("light %u at %.2f %.2f %.2f sees %.0f %% of the pixels before it, and %.2f %.2f %.2f in its map's middle;\n"
           "ism_visible agrees on %.1f %% of the pixels\n",
           (unsigned)number, (double)v->position[0], (double)v->position[1], (double)v->position[2],
           100.0 * same / (seen ? seen : 1), (double)place[0], (double)place[1], (double)place[2],
           100.0 * (double)alike / (seen ? seen : 1));
    return result;
}

static void show_light(int panel, const float *light, float scale)
{
    int i;
    for (i = 0; i < SIDE * SIDE; i++)
        put(panel, i % SIDE, i / SIDE, scale * light[3 * i], scale * light[3 * i + 1], scale * light[3 * i + 2]);
}

/* ---- what a program of your own does ---- */

static void say(void *user, const char *message) { fprintf((FILE *)user, "%s\n", message); }

static int fail(const char *what, ism_result result)
{
    return fprintf(stderr, "%s: %s\n", what, ism_result_text(result)), 1;
}

static double sum_of(const float *light)
{
    double sum = 0;
    int i;
    for (i = 0; i < 3 * SIDE * SIDE; i++) sum += (double)light[i];
    return sum;
}

/* The second bounce: its source are texels of the first one's maps, its lights are chosen among them. */
static ism_result bounce_again(const ism_maps *first, const ism_desc *desc, const ism_frame *frame,
                               const ism_shading *shading, float *light)
{
    static float block[3][3 * VPLS * BOUNCE * BOUNCE];
    ism_source source = { ISM_SOURCE_SURFACE, VPLS * BOUNCE * BOUNCE, 1, 1, block[0], 0, block[1], 0, block[2], 0,
                          NULL, 0, NULL, 0 };
    ism_frame next = *frame;
    ism_maps *maps = NULL;
    ism_result result = ism_bounce(first, frame->mesh, BOUNCE, block[0], block[1], block[2]);
    next.sources = &source;
    if (result == ISM_OK) result = ism_create(desc, &maps);
    if (result == ISM_OK) result = ism_render(maps, &next, shading, light, NULL);
    ism_free(maps);
    return result;
}

/* A list of one's own: here the even ones of those that were chosen, with twice their flux. */
static ism_result take_half(ism_maps *maps, const ism_frame *frame, const ism_shading *shading, float *light)
{
    static ism_vpl half[VPLS];
    size_t count, i, kept = 0;
    int k;
    const ism_vpl *vpls = ism_vpls(maps, &count);
    ism_result result;
    for (i = 0; i < count; i += 2) {
        half[kept] = vpls[i];
        for (k = 0; k < 3; k++) half[kept].flux[k] *= 2;
        kept++;
    }
    result = ism_set_vpls(maps, half, kept);
    if (result == ISM_OK) result = ism_build(maps, frame);
    return result == ISM_OK ? ism_shade(maps, frame->points, shading, light, NULL) : result;
}

int main(int count, char **values)
{
    static float light[3 * SIDE * SIDE], second[3 * SIDE * SIDE], half[3 * SIDE * SIDE];
    ism_mesh mesh = { corners, CORNERS, 0, NULL, INDICES, triangles, NULL, NULL, NULL, NULL };
    ism_source source = { ISM_SOURCE_SURFACE, RSM, RSM, 0, lit_at, 0, lit_normal, 0, lit_flux, 0, NULL, 0, NULL, 0 };
    ism_points points = { 0 };
    ism_frame frame = { &mesh, &source, 1, &points, 0 };
    ism_desc desc = { 0 };
    ism_shading shading = { 0 };
    ism_maps *maps;
    ism_info info;
    ism_result result;
    FILE *file;
    make_corners();
    look();
    light_the_floor();
    points.count = SIDE * SIDE;
    points.positions = seen_at;
    points.normals = seen_normal;
    points.width = SIDE;
    desc.vpl_count = VPLS;
    desc.surfel_count = SURFELS;
    desc.tile_side = TILE;
    desc.keep_hits = 1;                     /* for the next bounce */
    desc.system.log = say;
    desc.system.user = stderr;
    shading.interleave = 4;
    result = ism_create(&desc, &maps);
    if (result == ISM_OK) result = ism_choose(maps, &frame);
    if (result == ISM_OK) result = ism_build(maps, &frame);
    if (result == ISM_OK) result = ism_shade(maps, &points, &shading, light, NULL);
    if (result != ISM_OK) return fail("the first bounce", result);
    show_choice(maps);
    if (!show_map(maps, VPLS / 2)) return fail("a map", ISM_ERR_ORDER);
    result = read_map(maps, VPLS / 2, &points);
    if (result != ISM_OK) return fail("asking a map", result);
    show_light(2, light, 0.2f);
    result = bounce_again(maps, &desc, &frame, &shading, second);
    if (result != ISM_OK) return fail("the second bounce", result);
    show_light(3, second, 0.2f);
    result = take_half(maps, &frame, &shading, half);
    if (result != ISM_OK) return fail("half of the lights", result);
    ism_get_info(maps, &info);
    printf("second bounce over first %.2f, half of the lights over all %.3f, %u lights now, %.1f MB\n",
           sum_of(second) / sum_of(light), sum_of(half) / sum_of(light), (unsigned)info.vpl_count,
           (double)info.stats.bytes * 1e-6);
    ism_free(maps);
    file = fopen(count > 1 ? values[1] : "stages.ppm", "wb");
    if (!file) return fprintf(stderr, "cannot write the picture\n"), 1;
    fprintf(file, "P6 %d %d 255\n", 4 * SIDE, SIDE);
    fwrite(picture, 1, sizeof picture, file);
    return fclose(file) != 0;
}
