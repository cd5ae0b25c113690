/* fuzz_builder - libFuzzer target: bytes choose lights, meshes or buffers, patterns and receivers; every result must be
   finite and not negative, flux must add up, and nothing may be read or written out of bounds. The last bytes choose
   odd services (kit/odd.h), by which all results are the same. */

#define RSM_STATIC
#define RSM_IMPLEMENTATION
#include "rsm.h"
#include "input.h"
#include "odd.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { POINTS = 24, WIDTH = 6 };

static uint32_t side_of(const rsm_map *map)
{
    rsm_info info = { 0 };
    rsm_get_info(map, &info);
    return info.side;
}

static uint32_t faces_of(const rsm_map *map)
{
    rsm_info info = { 0 };
    rsm_get_info(map, &info);
    return info.face_count;
}

/* Mostly in -2..2. */
static float take_wide(input *in) { return 2 * take_float(in); }

static void take_desc(input *in, rsm_desc *d)
{
    static const float axes[6][3] = { { 0, 1, 0 },  { 0.6f, 0.8f, 0 }, { 0, 0, 1 }, { 0.48f, 0.6f, 0.64f },
                                      { 0, -1, 0 }, { 1, 0, 0 } };
    uint32_t i;
    memset(d, 0, sizeof *d);
    d->light.kind = (rsm_light_kind)(take(in) % (RSM_LIGHT_COUNT + 1u));
    memcpy(d->light.direction, axes[take(in) % 6u], sizeof d->light.direction);
    for (i = 0; i < 3; i++) {
        d->light.position[i] = take_wide(in);
        d->light.up[i] = take_wide(in);
        d->light.value[i] = fabsf(take_wide(in));
    }
    d->light.radius = take_wide(in);
    d->light.cone_half_angle = 1.5f * take_wide(in);
    if (take(in) & 1u) {
        d->light.near_depth = take_wide(in);
        d->light.far_depth = take_wide(in);
    }
    d->side = take(in) % 20u;
    d->clip_depth = (rsm_clip_depth)(take(in) & 3u);
    d->clip_y = (rsm_clip_y)(in->at < in->size ? in->data[in->at] & 3u : 0);
    d->rows = (rsm_rows)(take(in) >> 2 & 3u);
}

static void any_color(void *user, const rsm_mesh *mesh, uint32_t triangle, const float weights[3], float albedo[3])
{
    (void)user;
    (void)mesh;
    (void)triangle;
    albedo[0] = weights[0];
    albedo[1] = albedo[2] = 0.5f;
}

static int hole_or_not(void *user, uint32_t triangle, const float weights[3])
{
    (void)user;
    return triangle % 3u != 0 && weights[1] < 0.8f;
}

static int draw(input *in, rsm_map *map, odd *o)
{
    rsm_result result;
    float positions[3 * 30], transform[16];
    uint32_t indices[48], i;
    rsm_mesh mesh;
    memset(&mesh, 0, sizeof mesh);
    for (i = 0; i < 90; i++) positions[i] = take_wide(in);
    for (i = 0; i < 48; i++) indices[i] = take(in) % 31u;
    for (i = 0; i < 16; i++) transform[i] = take_wide(in);
    mesh.positions = positions;
    mesh.vertex_count = 30;
    if (take(in) & 3u) mesh.indices = indices;
    mesh.index_count = 3u * (take(in) % 17u);
    if (take(in) & 1u) mesh.transform = transform;
    mesh.albedo[0] = mesh.albedo[1] = 0.5f;
    mesh.albedo[2] = take_wide(in);
    mesh.material = take(in) % 4u;
    if (take(in) & 1u) mesh.surface_fn = any_color;
    if (take(in) & 1u) mesh.mask_fn = hole_or_not;
    mesh.tap_side = take(in) % 18u;
    ODD_TRY(o, result, rsm_rasterize(map, &mesh, 1));
    odd_keep_result(o, (int)result);
    return result == RSM_OK;
}

static int fill(input *in, rsm_map *map, odd *o)
{
    rsm_result result;
    static float positions[3 * 256 * 256], normals[3 * 256 * 256], depth[256 * 256];
    size_t i, count = (size_t)side_of(map) * side_of(map);
    rsm_buffers b;
    uint32_t face;
    if (side_of(map) > 256) return 0;
    memset(&b, 0, sizeof b);
    for (i = 0; i < count; i++) {
        int k;
        for (k = 0; k < 3 && i < 40; k++) {
            positions[3 * i + (size_t)k] = take_wide(in);
            normals[3 * i + (size_t)k] = take_wide(in);
        }
        if (i >= 40) {
            memcpy(positions + 3 * i, positions + 3 * (i % 40), 12);
            memcpy(normals + 3 * i, normals + 3 * (i % 40), 12);
        }
        depth[i] = i < 40 ? take_wide(in) : depth[i % 40];
    }
    b.normals = normals;
    if (take(in) & 1u) b.positions = positions;
    if (take(in) & 1u) b.depth = depth;
    b.albedo = positions;
    for (face = 0; face < faces_of(map); face++) {
        ODD_TRY(o, result, rsm_fill(map, face, &b));
        odd_keep_result(o, (int)result);
        if (result != RSM_OK) return 0;
    }
    return 1;
}

static void check(odd *o, rsm_result result, const float *e, size_t count)
{
    size_t i;
    odd_keep_result(o, (int)result);
    if (result != RSM_OK) return;
    odd_keep(o, e, count * sizeof *e);
    for (i = 0; i < count; i++)
        if (!rsm__finite(e[i]) || e[i] < 0.0f) abort();
}

static void use(input *in, const rsm_map *map, const rsm_system *system, odd *o)
{
    rsm_result result;
    const rsm_material materials[2] = { { { 0.5f, 0.5f, 0.5f }, 5 }, { { 1, 0, 0 }, 1e4f } };
    float p[3 * POINTS], n[3 * POINTS], e[3 * POINTS];
    rsm_texel clusters[8];
    rsm_points points;
    rsm_gather_desc g;
    rsm_interpolation inter;
    rsm_direct_desc direct;
    size_t count, i;
    memset(&points, 0, sizeof points);
    memset(&g, 0, sizeof g);
    memset(&inter, 0, sizeof inter);
    memset(&direct, 0, sizeof direct);
    for (i = 0; i < 3 * POINTS; i++) {
        p[i] = take_wide(in);
        n[i] = i % 3 == 1 ? 1.0f : 0.0f;
    }
    g.system = *system;
    points.count = POINTS;
    points.width = WIDTH;
    points.positions = p;
    points.normals = n;
    g.pattern = (rsm_pattern)(take(in) % RSM_PATTERN_COUNT);
    g.sample_count = take(in) % 70u;
    g.r_max = fabsf(take_wide(in));
    g.offset = fabsf(take_wide(in));
    g.near_limit = fabsf(take_wide(in));
    g.paper_weights = (int)(take(in) & 1u);
    g.seed = take(in);
    g.near_field = (float)(g.seed % 34u);       /* 33 is refused */
    if (take(in) & 1u) {
        g.materials = materials;
        g.material_count = 2;
    }
    ODD_TRY(o, result, rsm_interpolate(&map, 1, &g, &inter, &points, e, NULL));
    check(o, result, e, 3 * POINTS);
    g.interleave = 1u << take(in) % 4u;
    ODD_TRY(o, result, rsm_gather(&map, 1, &g, &points, e, NULL));
    check(o, result, e, 3 * POINTS);
    direct.tap_side = take(in) % 6u;
    direct.system = *system;
    ODD_TRY(o, result, rsm_direct(map, &direct, &points, e));
    check(o, result, e, 3 * POINTS);
    ODD_TRY(o, result,
            rsm_cluster(rsm_map_texels(map), (size_t)side_of(map) * side_of(map), 8, system, clusters, &count));
    odd_keep_result(o, (int)result);
    if (result != RSM_OK) return;
    ODD_TRY(o, result, rsm_gather_list(clusters, count, &g, &points, e, NULL));
    check(o, result, e, 3 * POINTS);
}

static void run(input *in, const rsm_system *system, odd *o)
{
    rsm_result result;
    rsm_desc d;
    rsm_map *map;
    rsm_stats stats;
    take_desc(in, &d);
    if (d.side == 0) d.side = 4;
    d.system = *system;
    ODD_TRY(o, result, rsm_map_create(&d, &map));
    odd_keep_result(o, (int)result);
    if (result != RSM_OK) return;
    if (take(in) & 1u ? draw(in, map, o) : fill(in, map, o)) {
        ODD_TRY(o, result, rsm_finish(map, &stats));
        odd_keep_result(o, (int)result);
        if (result == RSM_OK) {
            if (!(stats.reflected[0] >= 0.0)) abort();
            use(in, map, system, o);
        }
    }
    rsm_map_free(map);
    odd_done(o);
}

static void run_by(input *in, odd *o, int is_odd)
{
    rsm_system system;
    memset(&system, 0, sizeof system);
    if (is_odd) ODD_SYSTEM(&system, o);
    run(in, &system, o);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    odd o;
    if (odd_changes(run_by, data, size, &o)) ODD_ABORT("odd services change a result");
    return 0;
}
