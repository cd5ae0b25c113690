/* dapple_rows_test - the rows of rows.c by Dapple's headers: csm.h answers visibility, lightsampling.h draws the
   samples of direct light, rsm.h and ism.h bring the light that is thrown back. */
#include "csm.h"
#include "ism.h"
#include "lightsampling.h"
#include "rsm.h"

#include "conformance.h"                /* its lines are on the page */
#include "rows.c"

static adapter_scene scene;
static float scene_middle[3], scene_radius;
static cohsm_maps *scene_maps;          /* made when they are first asked */

const char *adapter_name(void) { return "Dapple"; }

int adapter_open(const adapter_scene *opened)
{
    double lo[3] = { 1e30, 1e30, 1e30 }, hi[3] = { -1e30, -1e30, -1e30 };
    size_t k;
    int i;
    scene = *opened;
    for (k = 0; k < 3 * scene.vertex_count; k++) {
        lo[k % 3] = fmin(lo[k % 3], (double)scene.positions[k]);
        hi[k % 3] = fmax(hi[k % 3], (double)scene.positions[k]);
    }
    for (i = 0; i < 3; i++) scene_middle[i] = (float)((lo[i] + hi[i]) / 2);
    scene_radius = 0;
    for (k = 0; k < scene.vertex_count; k++) {
        const float *p = scene.positions + 3 * k, x = p[0] - scene_middle[0], y = p[1] - scene_middle[1],
                    z = p[2] - scene_middle[2];
        /* no silhouette at a map's border */
        scene_radius = fmaxf(scene_radius, 1.03f * sqrtf(x * x + y * y + z * z));
    }
    return 1;
}

void adapter_close(void)
{
    cohsm_free(scene_maps);
    scene_maps = NULL;
}

/* ---- visibility ---- */

static void make_maps(void)
{
    const cohsm_mesh mesh = { scene.positions, scene.vertex_count, 0, scene.indices, 3 * scene.triangle_count,
                              NULL, NULL,
                              NULL };
    cohsm_desc desc;
    if (scene_maps) return;
    memset(&desc, 0, sizeof desc);
    memcpy(desc.center, scene_middle, sizeof desc.center);
    desc.radius = scene_radius;
    desc.domain.side[0] = desc.domain.side[1] = 48;
    desc.order = COHSM_ORDER_HILBERT;
    desc.orientation = COHSM_ORIENTATION_POLAR;
    assert_int_equal(cohsm_build(&desc, &mesh, &scene_maps, NULL), COHSM_OK);
}

int adapter_visible(const float *positions, const float *ends, int at_infinity, size_t count, float *visible)
{
    cohsm_query query;
    size_t refused = 0, k;
    if (!scene.triangle_count) {
        for (k = 0; k < count; k++) visible[k] = 1;
        return 1;
    }
    make_maps();
    memset(&query, 0, sizeof query);
    query.count = count;
    query.positions = positions;
    query.lights = ends;
    query.light_kind = at_infinity ? COHSM_LIGHT_DIRECTION : COHSM_LIGHT_POSITION;
    query.filter = COHSM_FILTER_PCF;
    query.bias = -1;                    /* points lie on no surface */
    assert_int_equal(cohsm_visible(scene_maps, &query, visible, &refused), COHSM_OK);
    return refused == 0;                /* places within the hull are not csm.h's, as long as maps look from outside */
}

/* ---- direct light ---- */

static void copy3(float *to, const float *from) { memcpy(to, from, 3 * sizeof *to); }

static lsamp_light_desc light_of(const adapter_light *l)
{
    static const lsamp_light_kind kinds[] = { LSAMP_LIGHT_ENVIRONMENT, LSAMP_LIGHT_SUN, LSAMP_LIGHT_POINT,
                                              LSAMP_LIGHT_SPOT, LSAMP_LIGHT_RECTANGLE, LSAMP_LIGHT_DISC,
                                              LSAMP_LIGHT_SPHERE };
    lsamp_light_desc d;
    memset(&d, 0, sizeof d);
    d.kind = kinds[l->kind];
    copy3(d.position, l->position);
    copy3(d.direction, l->direction);
    copy3(d.u, l->u);
    copy3(d.v, l->v);
    copy3(d.radiance, l->value);
    d.radius = l->radius;
    d.cone_half_angle = l->cone_half_angle;
    d.texels = l->texels;
    d.width = l->width;
    d.height = l->height;
    return d;
}

/* Irradiance of one point by SAMPLES samples. */
static int light_point(const lsamp_light *light, int at_infinity, const float *position, const float *normal, float *e)
{
    enum { SAMPLES = 4096 };
    static float directions[3 * SAMPLES], distances[SAMPLES], weights[3 * SAMPLES], from[3 * SAMPLES],
        ends[3 * SAMPLES],
        visible[SAMPLES];
    const lsamp_samples samples = { directions, distances, NULL, weights };
    lsamp_material white;
    lsamp_points points;
    lsamp_sample_desc desc;
    size_t k, i;
    memset(&white, 0, sizeof white);
    memset(&points, 0, sizeof points);
    memset(&desc, 0, sizeof desc);
    white.diffuse[0] = white.diffuse[1] = white.diffuse[2] = 1;
    points.count = 1;
    points.positions = position;
    points.normals = normal;
    points.materials = &white;
    desc.sample_count = SAMPLES;
    assert_int_equal(lsamp_sample(&desc, light, &points, &samples, NULL), LSAMP_OK);
    for (k = 0; k < SAMPLES; k++)
        for (i = 0; i < 3; i++) {
            from[3 * k + i] = position[i];
            ends[3 * k + i] = directions[3 * k + i];
            if (!at_infinity) ends[3 * k + i] = position[i] + distances[k] * directions[3 * k + i];
        }
    if (!adapter_visible(from, ends, at_infinity, SAMPLES, visible)) return 0;
    e[0] = e[1] = e[2] = 0;
    assert_int_equal(lsamp_accumulate(1, SAMPLES, weights, visible, e, 0), LSAMP_OK);
    for (i = 0; i < 3; i++) e[i] *= (float)ROW_PI;      /* of a white surface's radiance */
    return 1;
}

int adapter_direct(const adapter_light *light, const float *positions, const float *normals, size_t count,
                   float *irradiance)
{
    const lsamp_light_desc desc = light_of(light);
    const size_t bytes = lsamp_light_bytes(&desc);
    void *memory = malloc(bytes + 1);
    lsamp_light *made = NULL;
    int answered = 1;
    size_t k;
    assert_non_null(memory);
    assert_int_equal(lsamp_light_init(&desc, memory, bytes, &made, NULL), LSAMP_OK);
    for (k = 0; k < count && answered; k++)
        answered = light_point(made, light->kind <= ADAPTER_SUN, positions + 3 * k, normals + 3 * k,
                               irradiance + 3 * k);
    free(memory);
    return answered;
}

/* ---- light that is thrown back once ---- */

static void albedo_of(void *user, const rsm_mesh *mesh, uint32_t triangle, const float weights[3], float albedo[3])
{
    (void)user, (void)mesh, (void)weights;
    albedo[0] = albedo[1] = albedo[2] = scene.albedos[triangle];
}

/* The light's reflective shadow map of the scene; NULL for lights that have none here. */
static rsm_map *map_of(const adapter_light *light)
{
    rsm_mesh mesh;
    rsm_desc desc;
    rsm_map *map = NULL;
    memset(&mesh, 0, sizeof mesh);
    memset(&desc, 0, sizeof desc);
    desc.side = 128;
    copy3(desc.light.value, light->value);
    if (light->kind == ADAPTER_SUN) {
        desc.light.kind = RSM_LIGHT_SUN;
        copy3(desc.light.position, scene_middle);
        copy3(desc.light.direction, light->direction);
        desc.light.radius = scene_radius;
    } else if (light->kind == ADAPTER_POINT) {
        desc.light.kind = RSM_LIGHT_POINT;
        copy3(desc.light.position, light->position);
    } else {
        return NULL;
    }
    mesh.positions = scene.positions;
    mesh.vertex_count = scene.vertex_count;
    mesh.indices = scene.indices;
    mesh.index_count = 3 * scene.triangle_count;
    if (scene.albedos) mesh.surface_fn = albedo_of;
    assert_int_equal(rsm_map_create(&desc, &map), RSM_OK);
    assert_int_equal(rsm_rasterize(map, &mesh, 1), RSM_OK);
    assert_int_equal(rsm_finish(map, NULL), RSM_OK);
    return map;
}

int adapter_bounced(const adapter_light *light, const float *positions, const float *normals, size_t count,
                    float *irradiance)
{
    enum { FACES = 6 };
    ism_source sources[FACES];
    ism_mesh mesh;
    ism_points points;
    ism_frame frame;
    ism_desc desc;
    ism_maps *maps = NULL;
    rsm_map *map = map_of(light);
    rsm_info info;
    const rsm_texel *texels;
    uint32_t k;
    if (!map) return 0;
    texels = rsm_map_texels(map);
    rsm_get_info(map, &info);
    memset(sources, 0, sizeof sources);
    for (k = 0; k < info.face_count; k++) {
        const rsm_texel *face = texels + (size_t)k * info.side * info.side;
        sources[k].width = sources[k].height = info.side;
        sources[k].positions = face->position;
        sources[k].normals = face->normal;
        sources[k].fluxes = face->flux;
        sources[k].areas = &face->area;
        sources[k].position_stride = sources[k].normal_stride = sources[k].flux_stride = sources[k].area_stride =
            sizeof *face;
    }
    memset(&mesh, 0, sizeof mesh);
    memset(&points, 0, sizeof points);
    memset(&frame, 0, sizeof frame);
    memset(&desc, 0, sizeof desc);
    mesh.positions = scene.positions;
    mesh.vertex_count = scene.vertex_count;
    mesh.indices = scene.indices;
    mesh.index_count = 3 * scene.triangle_count;
    points.count = count;
    points.positions = positions;
    points.normals = normals;
    frame.mesh = &mesh;
    frame.sources = sources;
    frame.source_count = info.face_count;
    frame.points = &points;
    desc.importance = ISM_IMPORTANCE_FLUX;      /* the light of all places, not that of one receiver */
    desc.surfel_count = 1024;
    assert_int_equal(ism_create(&desc, &maps), ISM_OK);
    assert_int_equal(ism_render(maps, &frame, NULL, irradiance, NULL), ISM_OK);
    ism_free(maps);
    rsm_map_free(map);
    return 1;
}
