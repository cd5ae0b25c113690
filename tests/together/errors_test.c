/* errors_test - one fault, one code, in every header: the table of src/README.md ("Errors"), row by row. A rule has a
   call for each header, or `none` where the header takes nothing of the kind; a new header goes into the enum, and
   every rule fails until it says what the header does. What else each header refuses: errors_test of its folder. GL's
   headers: gl_backend/errors_test. */
#include "csm.h"
#include "lightsampling.h"
#include "shadowfield.h"
#include "envlights.h"
#include "envshadow.h"
#include "rsm.h"
#include "ism.h"
#include "gifilter.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { CSM, LIGHTSAMPLING, SHADOWFIELD, ENVLIGHTS, ENVSHADOW, RSM, ISM, GIFILTER, HEADERS };
enum { SIDE = 4, PIXELS = SIDE * SIDE };

/* The codes have the same numbers in all headers, which the first test asserts: csm.h's stand for them. */
enum {
    ARGUMENT = COHSM_ERR_ARGUMENT, DESC = COHSM_ERR_DESC, INPUT = COHSM_ERR_INPUT, LIMIT = COHSM_ERR_LIMIT,
    ORDER = COHSM_ERR_ORDER, MISMATCH = COHSM_ERR_MISMATCH
};

static const char *const names[HEADERS] = { "csm", "lightsampling", "shadowfield", "envlights",
                                            "envshadow", "rsm", "ism", "gifilter" };

typedef unsigned (*faulty_call)(void);

/* Stands where a header takes nothing that could be wrong so. */
static unsigned none(void) { return ~0u; }

/* Calls each header's function, all of which must return this code. */
static void all_return(unsigned code, const faulty_call calls[HEADERS])
{
    unsigned result;
    int i, wrong = 0;
    for (i = 0; i < HEADERS; i++) {
        if (!calls[i]) fail_msg("the rule has no call for %s, nor says `none`", names[i]);
        if (calls[i] == none) continue;
        result = calls[i]();
        if (result == code) continue;
        print_message("%s: %s, not %s\n", names[i], cohsm_result_text((cohsm_result)result),
                      cohsm_result_text((cohsm_result)code));
        wrong++;
    }
    assert_int_equal(wrong, 0);
}

/* ---- what is right: each call has one fault, in copies of these ---- */

/* The first members of every x_mesh. */
typedef struct any_mesh {
    const float    *positions;
    size_t          vertex_count;
    size_t          vertex_stride;
    const uint32_t *indices;
    size_t          index_count;
    const uint16_t *indices16;
} any_mesh;

static const float    corners[12] = { 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1 };
static const uint32_t triangles[12] = { 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3 };
static const any_mesh tetrahedron = { corners, 4, 0, triangles, 12, NULL };
static const cohsm_mesh  whole_csm = { corners, 4, 0, triangles, 12, NULL, NULL, NULL };
static const sfield_mesh whole_sfield = { corners, 4, 0, triangles, 12, NULL, NULL, NULL };
static const float    identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
static float positions[3 * PIXELS], normals[3 * PIXELS], bent[3 * PIXELS], out[3 * PIXELS];
static const envlt_light above = { { 0, 1, 0 }, { 1, 1, 1 }, 0, { 0, 0, 0 }, { 0, 0, 0 }, 0, 0 };

static envlt_map      sky;
static cohsm_maps    *maps;
static lsamp_light   *sun;
static double         sun_memory[256];
static sfield_field  *field;
static sfield_scene  *scene;
static envlt_lights  *lights;
static envsh_maps    *tiles;
static rsm_map       *map, *open_map;
static ism_maps      *images;
static gifilt_filter *filter;

static cohsm_desc small_maps(void)
{
    cohsm_desc d;
    memset(&d, 0, sizeof d);
    d.domain.side[0] = d.domain.side[1] = 4;
    d.map_side = 8;
    return d;
}

static sfield_desc small_field(void)
{
    sfield_desc d;
    memset(&d, 0, sizeof d);
    d.bands = 2;
    d.cube_side = 4;
    d.shell_count = d.position_side = 2;
    return d;
}

static envlt_map small_sky(void)
{
    static float texels[3 * 8 * 4];
    envlt_map m;
    texels[0] = 1;
    memset(&m, 0, sizeof m);
    m.width = 8;
    m.height = 4;
    m.rgb = texels;
    return m;
}

static envlt_desc few_lights(void)
{
    envlt_desc d;
    memset(&d, 0, sizeof d);
    d.light_count = 4;
    return d;
}

static envsh_maps_desc small_tiles(void)
{
    envsh_maps_desc d;
    memset(&d, 0, sizeof d);
    d.map_side = 16;
    return d;
}

static rsm_desc small_rsm(void)
{
    rsm_desc d;
    memset(&d, 0, sizeof d);
    d.light.direction[1] = -1;
    d.light.value[0] = d.light.radius = 1;
    d.side = 8;
    return d;
}

static ism_desc small_ism(void)
{
    ism_desc d;
    memset(&d, 0, sizeof d);
    d.vpl_count = 4;
    d.surfel_count = d.tile_side = 8;
    d.lazy_frames = 1;
    return d;
}

static gifilt_desc small_picture(void)
{
    gifilt_desc d;
    memset(&d, 0, sizeof d);
    d.width = d.height = SIDE;
    return d;
}

static lsamp_light_desc downward_sun(void)
{
    lsamp_light_desc d;
    memset(&d, 0, sizeof d);
    d.kind = LSAMP_LIGHT_SUN;
    d.radiance[0] = d.direction[1] = 1;
    return d;
}

/* The functions below make points, and call what takes them. A fault is a stride, or the normals' array. */
typedef struct faults { size_t stride; const float *normals; } faults;

static unsigned ask_csm(faults f)
{
    cohsm_query q;
    memset(&q, 0, sizeof q);
    q.count = PIXELS;
    q.positions = q.lights = positions;
    q.position_stride = f.stride;
    return cohsm_visible(maps, &q, out, NULL);
}

static unsigned sample_light(faults f, const lsamp_material *material)
{
    static float directions[3 * PIXELS], distances[PIXELS];
    lsamp_material plain;
    lsamp_sample_desc d;
    lsamp_points p;
    lsamp_samples s = { directions, distances, NULL, out };
    memset(&plain, 0, sizeof plain);
    memset(&d, 0, sizeof d);
    memset(&p, 0, sizeof p);
    d.sample_count = 1;
    p.count = PIXELS;
    p.positions = positions;
    p.position_stride = f.stride;
    p.normals = f.normals;
    p.materials = material ? material : &plain;
    return lsamp_sample(&d, sun, &p, &s, NULL);
}

static unsigned shade_field(faults f, uint32_t entity)
{
    sfield_points p;
    memset(&p, 0, sizeof p);
    p.count = PIXELS;
    p.positions = positions;
    p.position_stride = f.stride;
    p.normals = f.normals;
    p.entity = entity;
    p.rgb = out;
    return sfield_shade(scene, &p, 1, NULL);
}

static unsigned shade_tiles(faults f, envsh_maps *of)
{
    envsh_points p;
    memset(&p, 0, sizeof p);
    p.count = PIXELS;
    p.positions = positions;
    p.position_stride = f.stride;
    p.normals = f.normals;
    return envsh_shade(of, NULL, &p, out);
}

static unsigned gather_rsm(faults f, const rsm_gather_desc *desc, const uint32_t *index)
{
    rsm_points p;
    memset(&p, 0, sizeof p);
    p.count = PIXELS;
    p.positions = positions;
    p.position_stride = f.stride;
    p.normals = f.normals;
    p.indices = index;
    p.index_count = index != NULL;
    return rsm_gather((const rsm_map *const *)&map, 1, desc, &p, out, NULL);
}

static ism_points pixels_of(faults f)
{
    ism_points p;
    memset(&p, 0, sizeof p);
    p.count = PIXELS;
    p.width = SIDE;
    p.positions = positions;
    p.position_stride = f.stride;
    p.normals = f.normals;
    return p;
}

static unsigned shade_images(faults f)
{
    const ism_points p = pixels_of(f);
    return ism_shade(images, &p, NULL, out, NULL);
}

static unsigned filter_picture(faults f, size_t count)
{
    gifilt_points p;
    memset(&p, 0, sizeof p);
    p.count = count;
    p.positions = positions;
    p.position_stride = f.stride;
    p.normals = f.normals;
    return gifilt_apply(filter, NULL, &p, positions, out);
}

static int make_objects(void **state)
{
    const cohsm_desc csm = small_maps();
    const sfield_desc sfield = small_field();
    const rsm_desc rsm = small_rsm();
    const ism_desc ism = small_ism();
    const gifilt_desc gifilt = small_picture();
    const lsamp_light_desc light = downward_sun();
    const faults right = { 0, normals };
    int i;
    (void)state;
    sky = small_sky();
    for (i = 0; i < PIXELS; i++) {
        positions[3 * i] = (float)i;
        normals[3 * i + 1] = 1;
        bent[3 * i + 1] = i == 7 ? 1.5f : 1.0f;         /* one of them is not unit */
    }
    assert_int_equal(cohsm_build(&csm, &whole_csm, &maps, NULL), COHSM_OK);
    assert_int_equal(lsamp_light_init(&light, sun_memory, sizeof sun_memory, &sun, NULL), LSAMP_OK);
    assert_int_equal(sfield_build(&sfield, &whole_sfield, &field, NULL), SFIELD_OK);
    assert_int_equal(sfield_scene_create(NULL, &scene), SFIELD_OK);
    assert_int_equal(envlt_create(NULL, &sky, &lights, NULL), ENVLT_OK);
    assert_int_equal(envsh_maps_create(NULL, 1, &tiles), ENVSH_OK);
    assert_int_equal(rsm_map_create(&rsm, &open_map), RSM_OK);
    assert_int_equal(rsm_map_create(&rsm, &map), RSM_OK);
    assert_int_equal(rsm_finish(map, NULL), RSM_OK);
    assert_int_equal(ism_create(&ism, &images), ISM_OK);
    assert_int_equal(gifilt_create(&gifilt, &filter), GIFILT_OK);
    /* Each call works as it is, but for those that ask for a call before, which comes after all checks. */
    assert_int_equal(ask_csm(right), COHSM_OK);
    assert_int_equal(sample_light(right, NULL), LSAMP_OK);
    assert_int_equal(shade_field(right, 0), SFIELD_OK);
    assert_int_equal(shade_tiles(right, tiles), ENVSH_ERR_ORDER);
    assert_int_equal(gather_rsm(right, NULL, NULL), RSM_OK);
    assert_int_equal(shade_images(right), ISM_ERR_ORDER);
    assert_int_equal(filter_picture(right, PIXELS), GIFILT_OK);
    return 0;
}

static int free_objects(void **state)
{
    (void)state;
    cohsm_free(maps);
    sfield_free(field);
    sfield_scene_free(scene);
    envlt_free(lights);
    envsh_maps_free(tiles);
    rsm_map_free(map);
    rsm_map_free(open_map);
    ism_free(images);
    gifilt_free(filter);
    return 0;
}

/* ---- the codes themselves ---- */

#define NUMBER_OF(name, text) { (int)(name), text },
static const struct code { int number; const char *text; } codes[HEADERS][16] = {
    { COHSM_RESULTS(NUMBER_OF) }, { LSAMP_RESULTS(NUMBER_OF) }, { SFIELD_RESULTS(NUMBER_OF) },
    { ENVLT_RESULTS(NUMBER_OF) }, { ENVSH_RESULTS(NUMBER_OF) }, { RSM_RESULTS(NUMBER_OF) },
    { ISM_RESULTS(NUMBER_OF) },   { GIFILT_RESULTS(NUMBER_OF) },
};

static void a_code_has_the_same_number_and_text_in_every_header(void **state)
{
    int i, k;
    (void)state;
    for (i = 0; i < HEADERS; i++)
        for (k = 0; k < COHSM_RESULT_COUNT; k++) {
            assert_int_equal(codes[i][k].number, k);
            assert_string_equal(codes[i][k].text, codes[CSM][k].text);
        }
}

/* ---- meshes ---- */

static any_mesh mesh;       /* the one that is wrong */

static unsigned mesh_of_csm(void)
{
    const cohsm_desc d = small_maps();
    cohsm_maps *made = NULL;
    cohsm_mesh m;
    unsigned result;
    memset(&m, 0, sizeof m);
    memcpy(&m, &mesh, sizeof mesh);
    result = cohsm_build(&d, &m, &made, NULL);
    cohsm_free(made);
    return result;
}

static unsigned mesh_of_lightsampling(void)
{
    static double memory[8192];
    lsamp_light_desc d = downward_sun();
    lsamp_light *made;
    lsamp_mesh m;
    memcpy(&m, &mesh, sizeof m);
    d.kind = LSAMP_LIGHT_MESH;
    d.mesh = &m;
    d.place_count = 4;
    return lsamp_light_init(&d, memory, sizeof memory, &made, NULL);
}

static unsigned mesh_of_shadowfield(void)
{
    const sfield_desc d = small_field();
    sfield_field *made = NULL;
    sfield_mesh m;
    unsigned result;
    memset(&m, 0, sizeof m);
    memcpy(&m, &mesh, sizeof mesh);
    result = sfield_build(&d, &m, &made, NULL);
    sfield_free(made);
    return result;
}

static unsigned mesh_of_envshadow(void)
{
    const envsh_lights one = { 1, above.direction, above.irradiance, NULL, NULL, 0 };
    const envsh_bounds box = { { 0, 0, 0 }, { 1, 1, 1 } };
    envsh_maps *made;
    envsh_mesh m;
    unsigned result;
    memset(&m, 0, sizeof m);
    memcpy(&m, &mesh, sizeof mesh);
    assert_int_equal(envsh_maps_create(NULL, 1, &made), ENVSH_OK);
    assert_int_equal(envsh_maps_begin(made, &one, box), ENVSH_OK);
    result = envsh_maps_draw(made, &m, NULL);
    envsh_maps_free(made);
    return result;
}

static unsigned mesh_of_rsm(void)
{
    rsm_mesh m;
    memset(&m, 0, sizeof m);
    memcpy(&m, &mesh, sizeof mesh);
    return rsm_rasterize(open_map, &m, 1);
}

static unsigned mesh_of_ism(void)
{
    const faults right = { 0, normals };
    const ism_points p = pixels_of(right);
    static const float up[3] = { 0, 1, 0 }, point[3] = { 0, 2, 0 }, watt[3] = { 1, 1, 1 };
    ism_source s;
    ism_frame f;
    ism_mesh m;
    memset(&m, 0, sizeof m);
    memset(&s, 0, sizeof s);
    memset(&f, 0, sizeof f);
    memcpy(&m, &mesh, sizeof mesh);
    s.width = s.height = 1;
    s.positions = point;
    s.normals = up;
    s.fluxes = watt;
    f.mesh = &m;
    f.sources = &s;
    f.source_count = 1;
    f.points = &p;
    assert_int_equal(ism_choose(images, &f), ISM_OK);
    return ism_build(images, &f);
}

static const faulty_call mesh_calls[HEADERS] = {
    [CSM] = mesh_of_csm, [LIGHTSAMPLING] = mesh_of_lightsampling, [SHADOWFIELD] = mesh_of_shadowfield,
    [ENVLIGHTS] = none, [ENVSHADOW] = mesh_of_envshadow, [RSM] = mesh_of_rsm, [ISM] = mesh_of_ism, [GIFILTER] = none,
};

/* Every header takes the mesh, then returns the code for the mesh with this change. */
#define EVERY_MESH(code, change)            \
    do {                                    \
        mesh = tetrahedron;                 \
        all_return(COHSM_OK, mesh_calls);   \
        change;                             \
        all_return(code, mesh_calls);       \
    } while (0)

static void a_bad_stride_of_a_mesh_is_an_argument_in_every_header(void **state)
{
    (void)state;
    EVERY_MESH(ARGUMENT, mesh.vertex_stride = 8);
    EVERY_MESH(ARGUMENT, mesh.vertex_stride = 13);
}

static void a_mesh_without_positions_is_an_argument_in_every_header(void **state)
{
    (void)state;
    EVERY_MESH(ARGUMENT, mesh.positions = NULL);
}

static void both_kinds_of_indices_are_an_argument_in_every_header(void **state)
{
    static const uint16_t narrow[12] = { 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3 };
    (void)state;
    EVERY_MESH(ARGUMENT, mesh.indices16 = narrow);
}

static void corners_that_make_no_triangles_are_an_argument_in_every_header(void **state)
{
    (void)state;
    EVERY_MESH(ARGUMENT, mesh.index_count = 5);
    EVERY_MESH(ARGUMENT, mesh.indices = NULL);          /* four vertices */
}

static void an_index_beyond_the_vertices_is_input_in_every_header(void **state)
{
    static const uint16_t narrow[3] = { 0, 1, 4 };
    (void)state;
    EVERY_MESH(INPUT, mesh.vertex_count = 3);
    EVERY_MESH(INPUT, (mesh.indices = NULL, mesh.indices16 = narrow, mesh.index_count = 3));
}

static unsigned emitters_of_nothing(void)
{
    ism_mesh m;
    memset(&m, 0, sizeof m);
    return ism_emitter_points(&m, positions, 1, 0, NULL, out, out, out);
}

static void a_mesh_without_triangles_is_an_argument_where_some_are_needed(void **state)
{
    /* The maps of envshadow, rsm and ism may be of an empty scene. */
    static const faulty_call calls[HEADERS] = {
        [CSM] = mesh_of_csm, [LIGHTSAMPLING] = mesh_of_lightsampling, [SHADOWFIELD] = mesh_of_shadowfield,
        [ENVLIGHTS] = none, [ENVSHADOW] = none, [RSM] = none, [ISM] = emitters_of_nothing, [GIFILTER] = none,
    };
    (void)state;
    mesh = tetrahedron;
    mesh.index_count = 0;
    all_return(ARGUMENT, calls);
}

static void a_mesh_of_one_place_is_input_where_triangles_are_needed(void **state)
{
    static const float nothing[12];
    static const faulty_call calls[HEADERS] = {
        [CSM] = mesh_of_csm, [LIGHTSAMPLING] = mesh_of_lightsampling, [SHADOWFIELD] = mesh_of_shadowfield,
        [ENVLIGHTS] = none, [ENVSHADOW] = none, [RSM] = none, [ISM] = none, [GIFILTER] = none,
    };
    (void)state;
    mesh = tetrahedron;
    mesh.positions = nothing;
    all_return(INPUT, calls);
}

/* ---- points and other arrays ---- */

static const faults wrong_stride = { 13, normals }, no_normals = { 0, NULL }, wrong_normals = { 0, bent };

static unsigned stride_of_csm(void) { return ask_csm(wrong_stride); }
static unsigned stride_of_lightsampling(void) { return sample_light(wrong_stride, NULL); }
static unsigned stride_of_shadowfield(void) { return shade_field(wrong_stride, 0); }
static unsigned stride_of_envshadow(void) { return shade_tiles(wrong_stride, tiles); }
static unsigned stride_of_rsm(void) { return gather_rsm(wrong_stride, NULL, NULL); }
static unsigned stride_of_ism(void) { return shade_images(wrong_stride); }
static unsigned stride_of_gifilter(void) { return filter_picture(wrong_stride, PIXELS); }

static unsigned stride_of_envlights(void)
{
    envlt_map m = small_sky();
    envlt_lights *made;
    m.texel_stride = 13;
    return envlt_create(NULL, &m, &made, NULL);
}

static void a_bad_stride_of_an_array_is_an_argument_in_every_header(void **state)
{
    static const faulty_call calls[HEADERS] = {
        [CSM] = stride_of_csm, [LIGHTSAMPLING] = stride_of_lightsampling, [SHADOWFIELD] = stride_of_shadowfield,
        [ENVLIGHTS] = stride_of_envlights, [ENVSHADOW] = stride_of_envshadow, [RSM] = stride_of_rsm,
        [ISM] = stride_of_ism, [GIFILTER] = stride_of_gifilter,
    };
    (void)state;
    all_return(ARGUMENT, calls);
}

static unsigned null_of_lightsampling(void) { return sample_light(no_normals, NULL); }
static unsigned null_of_shadowfield(void) { return shade_field(no_normals, 0); }
static unsigned null_of_envshadow(void) { return shade_tiles(no_normals, tiles); }
static unsigned null_of_rsm(void) { return gather_rsm(no_normals, NULL, NULL); }
static unsigned null_of_ism(void) { return shade_images(no_normals); }
static unsigned null_of_gifilter(void) { return filter_picture(no_normals, PIXELS); }

static unsigned null_of_csm(void)
{
    cohsm_query q;
    memset(&q, 0, sizeof q);
    q.count = 1;
    q.positions = positions;
    return cohsm_visible(maps, &q, out, NULL);
}

static unsigned null_of_envlights(void)
{
    envlt_map m = small_sky();
    envlt_lights *made;
    m.rgb = NULL;
    return envlt_create(NULL, &m, &made, NULL);
}

static void an_array_that_is_missing_is_an_argument_in_every_header(void **state)
{
    static const faulty_call calls[HEADERS] = {
        [CSM] = null_of_csm, [LIGHTSAMPLING] = null_of_lightsampling, [SHADOWFIELD] = null_of_shadowfield,
        [ENVLIGHTS] = null_of_envlights, [ENVSHADOW] = null_of_envshadow, [RSM] = null_of_rsm,
        [ISM] = null_of_ism, [GIFILTER] = null_of_gifilter,
    };
    (void)state;
    all_return(ARGUMENT, calls);
}

static unsigned vector_of_lightsampling(void) { return sample_light(wrong_normals, NULL); }
static unsigned vector_of_shadowfield(void) { return shade_field(wrong_normals, 0); }
static unsigned vector_of_envshadow(void) { return shade_tiles(wrong_normals, tiles); }
static unsigned vector_of_rsm(void) { return gather_rsm(wrong_normals, NULL, NULL); }
static unsigned vector_of_ism(void) { return shade_images(wrong_normals); }
static unsigned vector_of_gifilter(void) { return filter_picture(wrong_normals, PIXELS); }

static unsigned vector_of_envlights(void)
{
    envlt_light l = above;
    l.direction[1] = 1.5f;
    return envlt_rotate(&l, 1, identity);
}

static void a_vector_that_is_not_unit_is_input_in_every_header(void **state)
{
    static const faulty_call calls[HEADERS] = {
        [CSM] = none, [LIGHTSAMPLING] = vector_of_lightsampling, [SHADOWFIELD] = vector_of_shadowfield,
        [ENVLIGHTS] = vector_of_envlights, [ENVSHADOW] = vector_of_envshadow, [RSM] = vector_of_rsm,
        [ISM] = vector_of_ism, [GIFILTER] = vector_of_gifilter,
    };
    (void)state;
    all_return(INPUT, calls);
}

static unsigned number_of_csm(void)
{
    static const float endless[4] = { HUGE_VALF, 0, 0, 1 };
    cohsm_desc d = small_maps();
    cohsm_maps *made;
    d.domain.kind = COHSM_DOMAIN_LIST;
    d.domain.side[0] = d.domain.side[1] = 0;
    d.domain.locations = endless;
    d.domain.location_count = 1;
    return cohsm_build(&d, &whole_csm, &made, NULL);
}

static unsigned number_of_lightsampling(void)
{
    lsamp_material m;
    memset(&m, 0, sizeof m);
    m.diffuse[0] = 2;
    return sample_light((faults){ 0, normals }, &m);
}

static unsigned number_of_shadowfield(void) { return shade_field((faults){ 0, normals }, 1); }

static unsigned number_of_envlights(void)
{
    envlt_map m = small_sky();
    envlt_lights *made;
    m.projection = ENVLT_PROJECTION_COUNT;
    return envlt_create(NULL, &m, &made, NULL);
}

static unsigned number_of_envshadow(void)
{
    const float endless[3] = { 0, HUGE_VALF, 0 };
    const envsh_lights one = { 1, above.direction, endless, NULL, NULL, 0 };
    const envsh_bounds box = { { 0, 0, 0 }, { 1, 1, 1 } };
    return envsh_maps_begin(tiles, &one, box);
}

static unsigned number_of_rsm(void)
{
    static const uint32_t beyond = PIXELS;
    return gather_rsm((faults){ 0, normals }, NULL, &beyond);
}

static unsigned number_of_ism(void)
{
    ism_vpl v;
    memset(&v, 0, sizeof v);
    v.normal[1] = v.axis[1] = 1;
    v.flux[0] = -1;
    return ism_set_vpls(images, &v, 1);
}

static void a_value_of_the_callers_data_is_input_in_every_header(void **state)
{
    static const faulty_call calls[HEADERS] = {
        [CSM] = number_of_csm, [LIGHTSAMPLING] = number_of_lightsampling, [SHADOWFIELD] = number_of_shadowfield,
        [ENVLIGHTS] = number_of_envlights, [ENVSHADOW] = number_of_envshadow, [RSM] = number_of_rsm,
        [ISM] = number_of_ism, [GIFILTER] = none,
    };
    (void)state;
    all_return(INPUT, calls);
}

/* ---- materials, matrices ---- */

static unsigned material_of_lightsampling(void)
{
    static const float up[3] = { 0, 1, 0 };
    float pdf;
    lsamp_material m;
    memset(&m, 0, sizeof m);
    m.diffuse[0] = 2;
    return lsamp_brdf_eval(&m, up, NULL, up, up, out, &pdf);
}

static unsigned material_of_rsm(void)
{
    static const rsm_material shining = { { 2, 0, 0 }, 1 };
    rsm_gather_desc d;
    memset(&d, 0, sizeof d);
    d.materials = &shining;
    d.material_count = 1;
    return gather_rsm((faults){ 0, normals }, &d, NULL);
}

/* In an array (number_of_lightsampling), by itself, and in an array that a desc points to. */
static void a_bad_material_is_input_in_every_header(void **state)
{
    static const faulty_call calls[HEADERS] = {
        [CSM] = none, [LIGHTSAMPLING] = material_of_lightsampling, [SHADOWFIELD] = none, [ENVLIGHTS] = none,
        [ENVSHADOW] = none, [RSM] = material_of_rsm, [ISM] = none, [GIFILTER] = none,
    };
    (void)state;
    all_return(INPUT, calls);
}

static const float sheared[16] = { 1, 0, 0, 1, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };

static unsigned matrix_of_csm(void)
{
    cohsm_instance instance;
    cohsm_query q;
    memset(&q, 0, sizeof q);
    memset(&instance, 0, sizeof instance);
    q.count = 1;
    q.positions = q.lights = positions;
    instance.maps = maps;
    memcpy(instance.transform, sheared, sizeof sheared);
    return cohsm_visible_scene(&instance, 1, &q, out, NULL);
}

static unsigned matrix_of_shadowfield(void)
{
    sfield_entity e;
    memset(&e, 0, sizeof e);
    memcpy(e.transform, sheared, sizeof sheared);
    return sfield_scene_entities(scene, &e, 1);
}

static unsigned matrix_of_envlights(void)
{
    envlt_light l = above;
    return envlt_rotate(&l, 1, sheared);
}

static unsigned matrix_of_envshadow(void)
{
    envsh_mesh m;
    memset(&m, 0, sizeof m);
    memcpy(&m, &tetrahedron, sizeof tetrahedron);
    return envsh_maps_draw(tiles, &m, sheared);
}

static unsigned matrix_of_rsm(void)
{
    static const float endless[16] = { HUGE_VALF };
    rsm_mesh m;
    memset(&m, 0, sizeof m);
    memcpy(&m, &tetrahedron, sizeof tetrahedron);
    m.transform = endless;
    return rsm_rasterize(open_map, &m, 1);
}

static unsigned matrix_of_ism(void)
{
    ism_points p = pixels_of((faults){ 0, normals });
    p.world_to_clip[5] = HUGE_VALF;
    return ism_shade(images, &p, NULL, out, NULL);
}

static void a_matrix_of_another_kind_is_input_in_every_header(void **state)
{
    static const faulty_call calls[HEADERS] = {
        [CSM] = matrix_of_csm, [LIGHTSAMPLING] = none, [SHADOWFIELD] = matrix_of_shadowfield,
        [ENVLIGHTS] = matrix_of_envlights, [ENVSHADOW] = matrix_of_envshadow, [RSM] = matrix_of_rsm,
        [ISM] = matrix_of_ism, [GIFILTER] = none,
    };
    (void)state;
    all_return(INPUT, calls);
}

/* ---- descs, allocators ---- */

static void *no_memory(size_t bytes, void *user)
{
    (void)bytes;
    (void)user;
    return NULL;
}

/* A call that makes an object by a desc with this change. */
#define MAKES(name, type, desc_of, object, change, call)    \
    static unsigned name(void)                              \
    {                                                       \
        type d = desc_of;                                   \
        object *made;                                       \
        change;                                             \
        return call;                                        \
    }
#define HALF d.system.allocator.alloc_fn = no_memory

MAKES(half_of_csm, cohsm_desc, small_maps(), cohsm_maps, HALF, cohsm_build(&d, &whole_csm, &made, NULL))
MAKES(half_of_shadowfield, sfield_desc, small_field(), sfield_field, HALF,
      sfield_build(&d, &whole_sfield, &made, NULL))
MAKES(half_of_envlights, envlt_desc, few_lights(), envlt_lights, HALF, envlt_create(&d, &sky, &made, NULL))
MAKES(half_of_envshadow, envsh_maps_desc, small_tiles(), envsh_maps, HALF, envsh_maps_create(&d, 1, &made))
MAKES(half_of_rsm, rsm_desc, small_rsm(), rsm_map, HALF, rsm_map_create(&d, &made))
MAKES(half_of_ism, ism_desc, small_ism(), ism_maps, HALF, ism_create(&d, &made))
MAKES(half_of_gifilter, gifilt_desc, small_picture(), gifilt_filter, HALF, gifilt_create(&d, &made))

static void half_an_allocator_is_a_desc_in_every_header(void **state)
{
    static const faulty_call calls[HEADERS] = {
        [CSM] = half_of_csm, [LIGHTSAMPLING] = none, [SHADOWFIELD] = half_of_shadowfield,
        [ENVLIGHTS] = half_of_envlights, [ENVSHADOW] = half_of_envshadow, [RSM] = half_of_rsm,
        [ISM] = half_of_ism, [GIFILTER] = half_of_gifilter,
    };
    (void)state;
    all_return(DESC, calls);
}

static unsigned half_given_to_csm(void)
{
    static const cohsm_system half = { .allocator = { .alloc_fn = no_memory } };
    cohsm_maps *made;
    return cohsm_merge((const cohsm_maps *const *)&maps, 1, &half, &made);
}

static unsigned half_given_to_shadowfield(void)
{
    static const sfield_system half = { .allocator = { .alloc_fn = no_memory } };
    sfield_algebra *made;
    return sfield_algebra_create(2, &half, &made);
}

static unsigned half_given_to_rsm(void)
{
    static const rsm_system half = { .allocator = { .alloc_fn = no_memory } };
    return rsm_blue_noise(4, 1, &half, out);
}

static unsigned half_given_to_ism(void)
{
    static const ism_system half = { .allocator = { .alloc_fn = no_memory } };
    ism_mesh m;
    memset(&m, 0, sizeof m);
    memcpy(&m, &tetrahedron, sizeof tetrahedron);
    return ism_emitter_points(&m, positions, 1, 0, &half, out, out, out);
}

static void half_an_allocator_is_a_desc_where_the_system_is_a_parameter_too(void **state)
{
    static const faulty_call calls[HEADERS] = {
        [CSM] = half_given_to_csm, [LIGHTSAMPLING] = none, [SHADOWFIELD] = half_given_to_shadowfield,
        [ENVLIGHTS] = none, [ENVSHADOW] = none, [RSM] = half_given_to_rsm, [ISM] = half_given_to_ism,
        [GIFILTER] = none,
    };
    (void)state;
    all_return(DESC, calls);
}

MAKES(field_of_csm, cohsm_desc, small_maps(), cohsm_maps, d.map_side = 3,
      cohsm_build(&d, &whole_csm, &made, NULL))
MAKES(field_of_lightsampling, lsamp_light_desc, downward_sun(), lsamp_light, d.time = HUGE_VALF,
      lsamp_light_init(&d, sun_memory, 0, &made, NULL))
MAKES(field_of_shadowfield, sfield_desc, small_field(), sfield_field, d.bands = 9,
      sfield_build(&d, &whole_sfield, &made, NULL))
MAKES(field_of_envlights, envlt_desc, few_lights(), envlt_lights, d.light_count = ENVLT_MAX_LIGHTS + 1,
      envlt_create(&d, &sky, &made, NULL))
MAKES(field_of_envshadow, envsh_maps_desc, small_tiles(), envsh_maps, d.map_side = 3,
      envsh_maps_create(&d, 1, &made))
MAKES(field_of_rsm, rsm_desc, small_rsm(), rsm_map, d.side = 3, rsm_map_create(&d, &made))
MAKES(field_of_ism, ism_desc, small_ism(), ism_maps, d.tile_side = 9, ism_create(&d, &made))
MAKES(field_of_gifilter, gifilt_desc, small_picture(), gifilt_filter, d.width = 0, gifilt_create(&d, &made))

static void a_field_out_of_range_is_a_desc_in_every_header(void **state)
{
    static const faulty_call calls[HEADERS] = {
        [CSM] = field_of_csm, [LIGHTSAMPLING] = field_of_lightsampling, [SHADOWFIELD] = field_of_shadowfield,
        [ENVLIGHTS] = field_of_envlights, [ENVSHADOW] = field_of_envshadow, [RSM] = field_of_rsm,
        [ISM] = field_of_ism, [GIFILTER] = field_of_gifilter,
    };
    (void)state;
    all_return(DESC, calls);
}

/* ---- parameters ---- */

static unsigned parameter_of_csm(void) { return cohsm_location(maps, 16, out); }
static unsigned parameter_of_lightsampling(void) { return lsamp_patterns_build(0, 1, out, sizeof out); }
static unsigned parameter_of_rsm(void) { return rsm_map_matrix(map, 1, out); }

static unsigned parameter_of_shadowfield(void)
{
    sfield_algebra *made;
    return sfield_algebra_create(9, NULL, &made);
}

static unsigned parameter_of_envlights(void)
{
    const envlt_map m = small_sky();
    return envlt_follow(lights, &m, ENVLT_MAX_LIGHTS + 1, NULL);
}

static unsigned parameter_of_envshadow(void)
{
    envsh_maps *made;
    return envsh_maps_create(NULL, ENVSH_MAX_LIGHTS + 1, &made);
}

static unsigned parameter_of_ism(void)
{
    size_t count;
    return ism_surfels(images, 4, NULL, 0, &count);
}

static void a_number_out_of_range_is_an_argument_in_every_header(void **state)
{
    static const faulty_call calls[HEADERS] = {
        [CSM] = parameter_of_csm, [LIGHTSAMPLING] = parameter_of_lightsampling,
        [SHADOWFIELD] = parameter_of_shadowfield, [ENVLIGHTS] = parameter_of_envlights,
        [ENVSHADOW] = parameter_of_envshadow, [RSM] = parameter_of_rsm, [ISM] = parameter_of_ism, [GIFILTER] = none,
    };
    (void)state;
    all_return(ARGUMENT, calls);
}

/* ---- too much, too early, not together ---- */

static unsigned limit_of_csm(void)
{
    mesh = tetrahedron;
    mesh.vertex_count = 0x80000000u;
    return mesh_of_csm();
}

static unsigned limit_of_lightsampling(void)
{
    mesh = tetrahedron;
    mesh.vertex_count = 0x80000000u;
    return mesh_of_lightsampling();
}

static unsigned limit_of_shadowfield(void)
{
    sfield_entity e;
    memset(&e, 0, sizeof e);
    return sfield_scene_entities(scene, &e, 65536);
}

static unsigned limit_of_envlights(void)
{
    envlt_map m = small_sky();
    envlt_lights *made;
    m.width = m.height = 65536;
    return envlt_create(NULL, &m, &made, NULL);
}

static unsigned limit_of_envshadow(void)
{
    const float two[6] = { 0, 1, 0, 0, 1, 0 };
    const envsh_lights pair = { 2, two, two, NULL, NULL, 0 };
    const envsh_bounds box = { { 0, 0, 0 }, { 1, 1, 1 } };
    return envsh_maps_begin(tiles, &pair, box);
}

static unsigned limit_of_rsm(void)
{
    rsm_light point;
    memset(&point, 0, sizeof point);
    point.kind = RSM_LIGHT_POINT;       /* six faces, where the map has one */
    return rsm_map_restart(open_map, &point);
}

static unsigned limit_of_ism(void)
{
    static const ism_vpl five[5];
    return ism_set_vpls(images, five, 5);
}

static void more_than_there_is_room_for_is_a_limit_in_every_header(void **state)
{
    static const faulty_call calls[HEADERS] = {
        [CSM] = limit_of_csm, [LIGHTSAMPLING] = limit_of_lightsampling, [SHADOWFIELD] = limit_of_shadowfield,
        [ENVLIGHTS] = limit_of_envlights, [ENVSHADOW] = limit_of_envshadow, [RSM] = limit_of_rsm,
        [ISM] = limit_of_ism, [GIFILTER] = none,
    };
    (void)state;
    all_return(LIMIT, calls);
}

static unsigned order_of_envshadow(void) { return envsh_maps_end(tiles); }
static unsigned order_of_rsm(void) { return rsm_finish(map, NULL); }

static unsigned order_of_csm(void)
{
    cohsm_desc d = small_maps();
    cohsm_builder *b;
    cohsm_maps *made;
    unsigned result;
    d.radius = 1;
    assert_int_equal(cohsm_builder_create(&d, &b), COHSM_OK);
    result = cohsm_builder_finish(b, &made, NULL);
    cohsm_builder_free(b);
    return result;
}

static unsigned order_of_lightsampling(void)
{
    double sums[3] = { 0, 0, 0 };
    lsamp_progressive p;
    memset(&p, 0, sizeof p);
    p.sums = sums;
    p.count = 3;
    return lsamp_progressive_mean(&p, out);
}

static unsigned order_of_ism(void)
{
    const ism_desc d = small_ism();
    const ism_points p = pixels_of((faults){ 0, normals });
    ism_maps *fresh;
    unsigned result;
    assert_int_equal(ism_create(&d, &fresh), ISM_OK);
    result = ism_shade(fresh, &p, NULL, out, NULL);
    ism_free(fresh);
    return result;
}

static void a_call_that_comes_too_early_is_an_order_in_every_header(void **state)
{
    static const faulty_call calls[HEADERS] = {
        [CSM] = order_of_csm, [LIGHTSAMPLING] = order_of_lightsampling, [SHADOWFIELD] = none, [ENVLIGHTS] = none,
        [ENVSHADOW] = order_of_envshadow, [RSM] = order_of_rsm, [ISM] = order_of_ism, [GIFILTER] = none,
    };
    (void)state;
    all_return(ORDER, calls);
}

static unsigned mismatch_of_shadowfield(void) { return sfield_self(field, 0, 1, out); }
static unsigned mismatch_of_gifilter(void) { return filter_picture((faults){ 0, normals }, PIXELS - 1); }

static unsigned mismatch_of_csm(void)
{
    static const float place[4] = { 3, 0, 0, 1 };
    cohsm_desc d = small_maps();
    cohsm_maps *list;
    cohsm_query q;
    unsigned result;
    memset(&q, 0, sizeof q);
    d.domain.kind = COHSM_DOMAIN_LIST;
    d.domain.side[0] = d.domain.side[1] = 0;
    d.domain.locations = place;
    d.domain.location_count = 1;
    q.count = 1;
    q.positions = q.lights = positions;         /* directions, of which a list of places knows none */
    assert_int_equal(cohsm_build(&d, &whole_csm, &list, NULL), COHSM_OK);
    result = cohsm_visible(list, &q, out, NULL);
    cohsm_free(list);
    return result;
}

static unsigned mismatch_of_envlights(void)
{
    envlt_map m = small_sky();
    m.width = 4;
    return envlt_follow(lights, &m, 0, NULL);
}

static unsigned mismatch_of_envshadow(void)
{
    envsh_maps_desc d;
    envsh_maps *layout;
    unsigned result;
    memset(&d, 0, sizeof d);
    d.no_depth = 1;
    assert_int_equal(envsh_maps_create(&d, 1, &layout), ENVSH_OK);
    result = shade_tiles((faults){ 0, normals }, layout);
    envsh_maps_free(layout);
    return result;
}

static unsigned mismatch_of_ism(void)
{
    ism_mesh m;
    memset(&m, 0, sizeof m);
    return ism_bounce(images, &m, 4, out, out, out);        /* the maps do not keep their hits */
}

static void an_object_made_without_what_the_call_needs_is_a_mismatch(void **state)
{
    static const faulty_call calls[HEADERS] = {
        [CSM] = mismatch_of_csm, [LIGHTSAMPLING] = none, [SHADOWFIELD] = mismatch_of_shadowfield,
        [ENVLIGHTS] = mismatch_of_envlights, [ENVSHADOW] = mismatch_of_envshadow, [RSM] = none,
        [ISM] = mismatch_of_ism, [GIFILTER] = mismatch_of_gifilter,
    };
    (void)state;
    all_return(MISMATCH, calls);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_code_has_the_same_number_and_text_in_every_header),
        cmocka_unit_test(a_bad_stride_of_a_mesh_is_an_argument_in_every_header),
        cmocka_unit_test(a_mesh_without_positions_is_an_argument_in_every_header),
        cmocka_unit_test(both_kinds_of_indices_are_an_argument_in_every_header),
        cmocka_unit_test(corners_that_make_no_triangles_are_an_argument_in_every_header),
        cmocka_unit_test(an_index_beyond_the_vertices_is_input_in_every_header),
        cmocka_unit_test(a_mesh_without_triangles_is_an_argument_where_some_are_needed),
        cmocka_unit_test(a_mesh_of_one_place_is_input_where_triangles_are_needed),
        cmocka_unit_test(a_bad_stride_of_an_array_is_an_argument_in_every_header),
        cmocka_unit_test(an_array_that_is_missing_is_an_argument_in_every_header),
        cmocka_unit_test(a_vector_that_is_not_unit_is_input_in_every_header),
        cmocka_unit_test(a_value_of_the_callers_data_is_input_in_every_header),
        cmocka_unit_test(a_bad_material_is_input_in_every_header),
        cmocka_unit_test(a_matrix_of_another_kind_is_input_in_every_header),
        cmocka_unit_test(half_an_allocator_is_a_desc_in_every_header),
        cmocka_unit_test(half_an_allocator_is_a_desc_where_the_system_is_a_parameter_too),
        cmocka_unit_test(a_field_out_of_range_is_a_desc_in_every_header),
        cmocka_unit_test(a_number_out_of_range_is_an_argument_in_every_header),
        cmocka_unit_test(more_than_there_is_room_for_is_a_limit_in_every_header),
        cmocka_unit_test(a_call_that_comes_too_early_is_an_order_in_every_header),
        cmocka_unit_test(an_object_made_without_what_the_call_needs_is_a_mismatch),
    };
    return cmocka_run_group_tests(tests, make_objects, free_objects);
}
