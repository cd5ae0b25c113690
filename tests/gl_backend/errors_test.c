/* errors_test - one fault, one code, in every header of gl_backend/: the table of src/README.md ("Errors"), row by row,
   as together/errors_test has it for the headers of the CPU. A rule has a call for each header, or `none` where the
   header takes nothing of the kind; a new header goes into the enum, and every rule fails until it says what the header
   does. Every single argument: arguments_test. */
#define _POSIX_C_SOURCE 200809L
#include "csm.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl_backend/gl_csm.h"
#include "gl_backend/gl_envshadow.h"
#include "gl_backend/gl_rsm.h"
#include "gl_backend/gl_ism.h"
#include "gl_backend/gl_wavelets.h"

#include "gl_test.h"

enum { BASE, PROGRAMS, GBUFFER, CSM, ENVSHADOW, RSM, ISM, SHADOWFIELD, WAVELETS, HEADERS };
enum { SIDE = 4 };

static const char *const names[HEADERS] = { "gl_backend", "gl_programs", "gl_gbuffer", "gl_csm", "gl_envshadow",
                                            "gl_rsm",     "gl_ism",      "gl_shadowfield", "gl_wavelets" };

typedef glbk_result (*faulty_call)(void);

/* Stands where a header takes nothing that could be wrong so. */
static glbk_result none(void) { return GLBK_OK; }

/* Calls each header's function, all of which must return this code. */
static void all_return(glbk_result code, const faulty_call calls[HEADERS])
{
    int i, wrong = 0;
    for (i = 0; i < HEADERS; i++) {
        glbk_result result;
        if (!calls[i]) fail_msg("the rule has no call for %s, nor says `none`", names[i]);
        if (calls[i] == none) continue;
        result = calls[i]();
        if (result == code) continue;
        print_message("%s: %s, not %s\n", names[i], glbk_result_text(result), glbk_result_text(code));
        wrong++;
    }
    assert_int_equal(wrong, 0);
}

/* ---- what is right: each call has one fault ---- */

static glbk_context     *gl;
static sfield_algebra   *algebra;
static glbk_gbuffer      seen, small;
static glbk_csm_maps     csm;
static glbk_csm_renderer csm_renderer;
static glbk_envsh_maps   envsh;
static glbk_rsm_renderer rsm;
static glbk_ism_maps     ism;
static glbk_ism_renderer ism_renderer;
static glbk_sfield_scene sfield, trees;
static glbk_sfield_haar  haar;

static glbk_rsm_renderer_desc small_rsm(void)
{
    glbk_rsm_renderer_desc d;
    memset(&d, 0, sizeof d);
    d.width = d.height = SIDE;
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

static glbk_envsh_maps_desc small_envsh(void)
{
    static const envsh_maps_desc maps = { .map_side = 16 };
    glbk_envsh_maps_desc d;
    memset(&d, 0, sizeof d);
    d.capacity = 1;
    d.maps = &maps;
    return d;
}

static glbk_sfield_scene_desc small_sfield(void)
{
    glbk_sfield_scene_desc d;
    memset(&d, 0, sizeof d);
    d.algebra = algebra;
    d.entity_capacity = 1;
    return d;
}

static glbk_sfield_haar_desc small_haar(void)
{
    glbk_sfield_haar_desc d;
    memset(&d, 0, sizeof d);
    d.width = d.height = d.cube_side = SIDE;
    return d;
}

static glbk_sfield_haar_scene_desc small_trees(void)
{
    glbk_sfield_haar_scene_desc d;
    memset(&d, 0, sizeof d);
    d.cube_side = SIDE;
    d.entity_capacity = 1;
    return d;
}

static void make_objects(gl_test *t)
{
    const glbk_gbuffer_desc g = { SIDE, SIDE, { 0, 0, 0, 0, NULL, NULL }, NULL };
    const glbk_gbuffer_desc half = { SIDE, SIDE / 2, { 0, 0, 0, 0, NULL, NULL }, NULL };
    const glbk_csm_renderer_desc c = { SIDE, SIDE, 0, 0, NULL };
    const glbk_rsm_renderer_desc r = small_rsm();
    const glbk_envsh_maps_desc e = small_envsh();
    const ism_desc i = small_ism();
    const glbk_sfield_haar_scene_desc w = small_trees();
    const glbk_sfield_haar_desc h = small_haar();
    glbk_sfield_scene_desc s;
    gl = &t->gl;
    assert_int_equal(sfield_algebra_create(2, NULL, &algebra), SFIELD_OK);
    s = small_sfield();
    assert_glbk(t, glbk_gbuffer_create(gl, &g, &seen));
    assert_glbk(t, glbk_gbuffer_create(gl, &half, &small));
    assert_glbk(t, glbk_csm_maps_create(gl, NULL, 0, 1, NULL, &csm));
    assert_glbk(t, glbk_csm_renderer_create(gl, &c, &csm_renderer));
    assert_glbk(t, glbk_envsh_maps_create(gl, &e, &envsh));
    assert_glbk(t, glbk_rsm_renderer_create(gl, &r, &rsm));
    assert_glbk(t, glbk_ism_maps_create(gl, &i, &ism));
    assert_glbk(t, glbk_ism_renderer_create(gl, &(glbk_ism_renderer_desc){ SIDE, SIDE }, &ism_renderer));
    assert_glbk(t, glbk_sfield_scene_create(gl, &s, &sfield));
    assert_glbk(t, glbk_sfield_haar_upload(gl, &w, &trees));
    assert_glbk(t, glbk_sfield_haar_create(gl, &h, &haar));
}

static void free_objects(void)
{
    glbk_gbuffer_free(gl, &seen);
    glbk_gbuffer_free(gl, &small);
    glbk_csm_maps_free(gl, &csm);
    glbk_csm_renderer_free(gl, &csm_renderer);
    glbk_envsh_maps_free(gl, &envsh);
    glbk_rsm_renderer_free(gl, &rsm);
    glbk_ism_maps_free(gl, &ism);
    glbk_ism_renderer_free(gl, &ism_renderer);
    glbk_sfield_scene_free(gl, &sfield);
    glbk_sfield_scene_free(gl, &trees);
    glbk_sfield_haar_free(gl, &haar);
    sfield_algebra_free(algebra);
}

/* A test that calls all headers with these faults, whose objects are made before. */
#define RULE(name, code, ...)                                           \
    static void name(void **state)                                      \
    {                                                                   \
        static const faulty_call calls[HEADERS] = { __VA_ARGS__ };      \
        GL_TEST(t, state)                                               \
        make_objects(t);                                                \
        all_return(code, calls);                                        \
        free_objects();                                                 \
    }

/* ---- sizes ---- */

static uint32_t width;      /* the one that is wrong */

static glbk_result width_of_base(void)
{
    glbk_texture_desc d;
    glbk_texture made;
    memset(&d, 0, sizeof d);
    d.format = GLBK_FORMAT_RGBA8;
    d.width = width;
    d.height = SIDE;
    return glbk_texture_create(gl, &d, &made);
}

static glbk_result width_of_gbuffer(void)
{
    const glbk_gbuffer_desc d = { width, SIDE, { 0, 0, 0, 0, NULL, NULL }, NULL };
    glbk_gbuffer made;
    return glbk_gbuffer_create(gl, &d, &made);
}

static glbk_result width_of_csm(void)
{
    const glbk_csm_renderer_desc d = { width, SIDE, 0, 0, NULL };
    glbk_csm_renderer made;
    return glbk_csm_renderer_create(gl, &d, &made);
}

static glbk_result width_of_envshadow(void)
{
    glbk_envsh_renderer made;
    return glbk_envsh_renderer_create(gl, &(glbk_envsh_renderer_desc){ width, SIDE }, &made);
}

static glbk_result width_of_rsm(void)
{
    glbk_rsm_renderer_desc d = small_rsm();
    glbk_rsm_renderer made;
    d.width = width;
    return glbk_rsm_renderer_create(gl, &d, &made);
}

static glbk_result width_of_ism(void)
{
    glbk_ism_renderer made;
    return glbk_ism_renderer_create(gl, &(glbk_ism_renderer_desc){ width, SIDE }, &made);
}

static glbk_result width_of_shadowfield(void)
{
    glbk_sfield_renderer_desc d;
    glbk_sfield_renderer made;
    memset(&d, 0, sizeof d);
    d.width = width;
    d.height = SIDE;
    d.algebra = algebra;
    return glbk_sfield_renderer_create(gl, &d, &made);
}

static glbk_result width_of_wavelets(void)
{
    glbk_sfield_haar_desc d = small_haar();
    glbk_sfield_haar made;
    d.width = width;
    return glbk_sfield_haar_create(gl, &d, &made);
}

static const faulty_call widths[HEADERS] = {
    [BASE] = width_of_base, [PROGRAMS] = none, [GBUFFER] = width_of_gbuffer, [CSM] = width_of_csm,
    [ENVSHADOW] = width_of_envshadow, [RSM] = width_of_rsm, [ISM] = width_of_ism,
    [SHADOWFIELD] = width_of_shadowfield, [WAVELETS] = width_of_wavelets,
};

static void a_width_above_that_of_the_context_is_a_limit_in_every_header(void **state)
{
    GL_TEST(t, state)
    make_objects(t);
    width = gl->max_side + 1;
    all_return(GLBK_ERR_LIMIT, widths);
    free_objects();
}

static void no_width_is_a_fault_of_the_desc_in_every_header(void **state)
{
    GL_TEST(t, state)
    make_objects(t);
    width = 0;
    all_return(GLBK_ERR_DESC, widths);
    free_objects();
}

/* ---- parameters, objects ---- */

static glbk_result null_of_base(void) { return glbk_texture_update(gl, &csm.blocks, NULL, ""); }
static glbk_result null_of_csm(void) { return glbk_csm_maps_place(gl, &csm, NULL, 1); }
static glbk_result null_of_envshadow(void) { return glbk_envsh_maps_render(gl, &envsh, NULL, 0, NULL, NULL); }
static glbk_result null_of_rsm(void) { return glbk_rsm_map_create(gl, NULL, 4, &(glbk_rsm_map){ 0 }); }
static glbk_result null_of_ism(void) { return glbk_ism_read(gl, &ism_renderer, NULL); }
static glbk_result null_of_shadowfield(void) { return glbk_sfield_scene_entities(gl, &sfield, NULL, 1); }

static glbk_result null_of_wavelets(void) { return glbk_sfield_haar_shade(gl, &haar, NULL, &trees, NULL, 0); }

static glbk_result null_of_programs(void)
{
    glbk_program made;
    return glbk_program_compile(gl, NULL, &made);
}

static glbk_result null_of_gbuffer(void)
{
    const float eye[3] = { 0, 0, 0 };
    return glbk_gbuffer_begin(gl, &seen, NULL, eye);
}

RULE(a_pointer_that_is_missing_is_an_argument_in_every_header, GLBK_ERR_ARGUMENT, [BASE] = null_of_base,
     [PROGRAMS] = null_of_programs, [GBUFFER] = null_of_gbuffer, [CSM] = null_of_csm, [ENVSHADOW] = null_of_envshadow,
     [RSM] = null_of_rsm, [ISM] = null_of_ism, [SHADOWFIELD] = null_of_shadowfield, [WAVELETS] = null_of_wavelets)

static glbk_result unmade_of_base(void) { return glbk_buffer_update(gl, &(glbk_buffer){ 0 }, 0, 0, ""); }
static glbk_result unmade_of_programs(void) { return glbk_dispatch(gl, &(glbk_program){ 0 }, 1, 1, 1); }
static glbk_result unmade_of_gbuffer(void) { return glbk_gbuffer_bind(gl, &(glbk_gbuffer){ 0 }, NULL); }
static glbk_result unmade_of_csm(void) { return glbk_csm_maps_place(gl, &(glbk_csm_maps){ 0 }, NULL, 0); }
static glbk_result unmade_of_envshadow(void) { return glbk_envsh_bind(gl, &(glbk_envsh_maps){ 0 }, NULL, NULL); }
static glbk_result unmade_of_rsm(void) { return glbk_rsm_tables_upload(gl, &(glbk_rsm_renderer){ 0 }, NULL, NULL); }
static glbk_result unmade_of_ism(void) { return glbk_ism_draw(gl, &(glbk_ism_maps){ 0 }, 0); }
static glbk_result unmade_of_shadowfield(void) { return glbk_sfield_scene_sky(gl, &(glbk_sfield_scene){ 0 }, NULL); }

static glbk_result unmade_of_wavelets(void)
{
    return glbk_sfield_haar_shade(gl, &(glbk_sfield_haar){ 0 }, &seen, &trees, NULL, 0);
}

RULE(an_object_that_was_not_created_is_an_argument_in_every_header, GLBK_ERR_ARGUMENT, [BASE] = unmade_of_base,
     [PROGRAMS] = unmade_of_programs, [GBUFFER] = unmade_of_gbuffer, [CSM] = unmade_of_csm,
     [ENVSHADOW] = unmade_of_envshadow, [RSM] = unmade_of_rsm, [ISM] = unmade_of_ism,
     [SHADOWFIELD] = unmade_of_shadowfield, [WAVELETS] = unmade_of_wavelets)

static glbk_result number_of_base(void) { return glbk_buffer_create(gl, 0, NULL, &(glbk_buffer){ 0 }); }
static glbk_result number_of_csm(void) { return glbk_csm_asker_create(gl, 0, &(glbk_csm_asker){ 0 }); }

static glbk_result number_of_gbuffer(void)
{
    static glbk_pixel row[SIDE];
    return glbk_gbuffer_upload(gl, &seen, SIDE, 1, row);
}

static glbk_result number_of_rsm(void)
{
    rsm_light l;
    glbk_rsm_map made;
    memset(&l, 0, sizeof l);
    l.direction[1] = -1;
    l.radius = 1;
    return glbk_rsm_map_create(gl, &l, 3, &made);
}

static glbk_result number_of_ism(void)
{
    static const ism_surfel surfels[32];
    return glbk_ism_surfels_upload(gl, &ism, 1, surfels, 32);
}

RULE(a_number_out_of_range_is_an_argument_in_every_header, GLBK_ERR_ARGUMENT, [BASE] = number_of_base,
     [PROGRAMS] = none, [GBUFFER] = number_of_gbuffer, [CSM] = number_of_csm, [ENVSHADOW] = none,
     [RSM] = number_of_rsm, [ISM] = number_of_ism, [SHADOWFIELD] = none, [WAVELETS] = none)

/* ---- descs ---- */

static glbk_result field_of_base(void)
{
    glbk_texture_desc d;
    glbk_texture made;
    memset(&d, 0, sizeof d);
    d.format = GLBK_FORMAT_COUNT;
    d.width = d.height = SIDE;
    return glbk_texture_create(gl, &d, &made);
}

static glbk_result field_of_gbuffer(void)
{
    const glbk_gbuffer_desc d = { SIDE, SIDE, { 0, 16, 2, 3, NULL, NULL }, NULL };
    glbk_gbuffer made;
    return glbk_gbuffer_create(gl, &d, &made);
}

static glbk_result field_of_csm(void)
{
    const glbk_csm_renderer_desc d = { SIDE, SIDE, 9, 0, NULL };
    glbk_csm_renderer made;
    return glbk_csm_renderer_create(gl, &d, &made);
}

static glbk_result field_of_envshadow(void)
{
    const envsh_maps_desc maps = { .map_side = 16, .guard = 5 };
    glbk_envsh_maps_desc d = small_envsh();
    glbk_envsh_maps made;
    d.maps = &maps;
    return glbk_envsh_maps_create(gl, &d, &made);
}

static glbk_result field_of_rsm(void)
{
    glbk_rsm_renderer_desc d = small_rsm();
    glbk_rsm_renderer made;
    d.lights_per_pass = 32769;
    return glbk_rsm_renderer_create(gl, &d, &made);
}

static glbk_result field_of_ism(void)
{
    ism_desc d = small_ism();
    glbk_ism_maps made;
    d.tile_side = 9;
    return glbk_ism_maps_create(gl, &d, &made);
}

static glbk_result field_of_shadowfield(void)
{
    glbk_sfield_scene_desc d = small_sfield();
    glbk_sfield_scene made;
    d.reach = NAN;
    return glbk_sfield_scene_create(gl, &d, &made);
}

static glbk_result field_of_wavelets(void)
{
    glbk_sfield_haar_scene_desc d = small_trees();
    glbk_sfield_scene made;
    d.cube_side = 5;
    return glbk_sfield_haar_upload(gl, &d, &made);
}

RULE(a_field_out_of_range_is_a_desc_in_every_header, GLBK_ERR_DESC, [BASE] = field_of_base, [PROGRAMS] = none,
     [GBUFFER] = field_of_gbuffer, [CSM] = field_of_csm, [ENVSHADOW] = field_of_envshadow, [RSM] = field_of_rsm,
     [ISM] = field_of_ism, [SHADOWFIELD] = field_of_shadowfield, [WAVELETS] = field_of_wavelets)

static glbk_result pointer_of_base(void)
{
    glbk_context made;
    glbk_desc d;
    memset(&d, 0, sizeof d);
    return glbk_init(&made, &d);
}

static glbk_result pointer_of_programs(void)
{
    glbk_program made;
    glbk_source s;
    memset(&s, 0, sizeof s);
    return glbk_program_compile(gl, &s, &made);
}

static glbk_result pointer_of_gbuffer(void)
{
    glbk_import d;
    memset(&d, 0, sizeof d);
    return glbk_gbuffer_import(gl, &seen, &d);
}

static glbk_result pointer_of_csm(void)
{
    glbk_csm_lights_desc d;
    glbk_csm_lights made;
    uint32_t start;
    memset(&d, 0, sizeof d);
    d.light_count = 1;
    return glbk_csm_lights_create(gl, &d, &start, &made);
}

static glbk_result pointer_of_rsm(void)
{
    rsm_gather_desc d;
    memset(&d, 0, sizeof d);
    d.material_count = 1;
    return glbk_rsm_tables_upload(gl, &rsm, &d, NULL);
}

static glbk_result pointer_of_shadowfield(void)
{
    glbk_sfield_scene_desc d = small_sfield();
    glbk_sfield_scene made;
    d.algebra = NULL;
    return glbk_sfield_scene_create(gl, &d, &made);
}

static glbk_result pointer_of_wavelets(void)
{
    glbk_sfield_haar_scene_desc d = small_trees();
    glbk_sfield_scene made;
    d.field_count = 1;
    return glbk_sfield_haar_upload(gl, &d, &made);
}

RULE(a_pointer_missing_in_a_desc_is_a_desc_in_every_header, GLBK_ERR_DESC, [BASE] = pointer_of_base,
     [PROGRAMS] = pointer_of_programs, [GBUFFER] = pointer_of_gbuffer, [CSM] = pointer_of_csm,
     [ENVSHADOW] = none, [RSM] = pointer_of_rsm, [ISM] = none, [SHADOWFIELD] = pointer_of_shadowfield,
     [WAVELETS] = pointer_of_wavelets)

static void *no_memory(size_t bytes, void *user)
{
    (void)bytes;
    (void)user;
    return NULL;
}

static void half_an_allocator_is_a_desc_as_it_is_without_gl(void **state)
{
    glbk_context made;
    glbk_desc d;
    GL_TEST(t, state)
    memset(&d, 0, sizeof d);
    d.get_proc_fn = ex_gl_get_proc;
    d.user = t->context;
    d.system.allocator.alloc_fn = no_memory;
    assert_int_equal(glbk_init(&made, &d), GLBK_ERR_DESC);
}

/* ---- meshes and other data ---- */

static const float    corners[12] = { 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1 };
static const uint32_t triangles[12] = { 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3 };
static const sfield_mesh tetrahedron = { corners, 4, 0, triangles, 12, NULL, NULL, NULL };
static sfield_mesh mesh;    /* the one that is wrong; its members are the first of every mesh */

static glbk_result mesh_of_csm(void)
{
    lsamp_light_desc light;
    glbk_csm_lights_desc d;
    glbk_csm_lights made;
    glbk_result result;
    lsamp_mesh m;
    uint32_t start;
    memcpy(&m, &mesh, sizeof m);
    memset(&light, 0, sizeof light);
    memset(&d, 0, sizeof d);
    light.kind = LSAMP_LIGHT_MESH;
    light.mesh = &m;
    d.lights = &light;
    d.light_count = 1;
    result = glbk_csm_lights_create(gl, &d, &start, &made);
    glbk_csm_lights_free(gl, &made);
    return result;
}

static glbk_result mesh_of_ism(void)
{
    ism_mesh m;
    memset(&m, 0, sizeof m);
    memcpy(&m, &mesh, offsetof(sfield_mesh, mask_fn));
    return glbk_ism_mesh_upload(gl, &ism, &m);
}

static glbk_result mesh_of_shadowfield(void)
{
    glbk_sfield_builder_desc d;
    glbk_sfield_builder made;
    glbk_result result;
    memset(&d, 0, sizeof d);
    d.mesh = &mesh;
    result = glbk_sfield_builder_create(gl, &d, &made);
    glbk_sfield_builder_free(gl, &made);
    return result;
}

static const faulty_call mesh_calls[HEADERS] = {
    [BASE] = none, [PROGRAMS] = none, [GBUFFER] = none, [CSM] = mesh_of_csm, [ENVSHADOW] = none, [RSM] = none,
    [ISM] = mesh_of_ism, [SHADOWFIELD] = mesh_of_shadowfield, [WAVELETS] = none,
};

#define EVERY_MESH(code, change)        \
    do {                                \
        mesh = tetrahedron;             \
        change;                         \
        all_return(code, mesh_calls);   \
    } while (0)

static void a_bad_mesh_has_the_code_that_it_has_without_gl(void **state)
{
    static const uint16_t narrow[12] = { 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3 };
    GL_TEST(t, state)
    make_objects(t);
    EVERY_MESH(GLBK_OK, (void)0);
    EVERY_MESH(GLBK_ERR_ARGUMENT, mesh.vertex_stride = 13);
    EVERY_MESH(GLBK_ERR_ARGUMENT, mesh.positions = NULL);
    EVERY_MESH(GLBK_ERR_ARGUMENT, mesh.indices16 = narrow);
    EVERY_MESH(GLBK_ERR_ARGUMENT, mesh.index_count = 5);
    EVERY_MESH(GLBK_ERR_ARGUMENT, mesh.indices = NULL);         /* four vertices */
    EVERY_MESH(GLBK_ERR_LIMIT, mesh.index_count = (size_t)3 << 30);
    EVERY_MESH(GLBK_ERR_INPUT, mesh.vertex_count = 3);
    free_objects();
}

static glbk_result value_of_gbuffer(void)
{
    static glbk_pixel row[SIDE];
    row[2].normal[1] = 1.5f;
    return glbk_gbuffer_upload(gl, &seen, 0, 1, row);
}

static glbk_result value_of_csm(void)
{
    glbk_csm_instance instance;
    memset(&instance, 0, sizeof instance);
    instance.start = csm.texel_count;
    return glbk_csm_maps_place(gl, &csm, &instance, 1);
}

static glbk_result value_of_rsm(void)
{
    static const rsm_material shining = { { 2, 0, 0 }, 1 };
    rsm_gather_desc d;
    memset(&d, 0, sizeof d);
    d.materials = &shining;
    d.material_count = 1;
    return glbk_rsm_tables_upload(gl, &rsm, &d, NULL);
}

static glbk_result value_of_ism(void)
{
    const ism_info info = { 0 };
    ism_vpl v;
    memset(&v, 0, sizeof v);
    v.normal[1] = v.axis[1] = 1;
    v.flux[0] = -1;
    return glbk_ism_vpls_upload(gl, &ism, &v, 1, &info);
}

static glbk_result value_of_shadowfield(void)
{
    sfield_entity e;
    memset(&e, 0, sizeof e);
    e.tint[0] = NAN;
    return glbk_sfield_scene_entities(gl, &sfield, &e, 1);
}

static glbk_result value_of_wavelets(void)
{
    sfield_entity e;
    memset(&e, 0, sizeof e);
    e.time = INFINITY;
    return glbk_sfield_scene_entities(gl, &trees, &e, 1);
}

RULE(a_value_of_the_callers_data_is_input_in_every_header, GLBK_ERR_INPUT, [BASE] = none, [PROGRAMS] = none,
     [GBUFFER] = value_of_gbuffer, [CSM] = value_of_csm, [ENVSHADOW] = none, [RSM] = value_of_rsm,
     [ISM] = value_of_ism, [SHADOWFIELD] = value_of_shadowfield, [WAVELETS] = value_of_wavelets)

/* ---- too much, too early, not together ---- */

static glbk_result draw_nothing(void *user, glbk_context *ctx, glbk_envsh_maps *maps, uint32_t instances)
{
    (void)user, (void)ctx, (void)maps, (void)instances;
    return GLBK_OK;
}

static glbk_result limit_of_csm(void)
{
    static const glbk_csm_instance two[2];
    return glbk_csm_maps_place(gl, &csm, two, 2);
}

static glbk_result limit_of_envshadow(void)
{
    static const envsh_view two[2];
    return glbk_envsh_maps_render(gl, &envsh, two, 2, draw_nothing, NULL);
}

static glbk_result limit_of_rsm(void)
{
    static const float noise[1];
    rsm_gather_desc d;
    memset(&d, 0, sizeof d);
    d.noise = noise;
    d.noise_side = 1025;            /* right for rsm_gather */
    return glbk_rsm_tables_upload(gl, &rsm, &d, NULL);
}

static glbk_result limit_of_ism(void)
{
    static const ism_vpl five[5];
    const ism_info info = { 0 };
    return glbk_ism_vpls_upload(gl, &ism, five, 5, &info);
}

static glbk_result limit_of_shadowfield(void)
{
    static const sfield_entity two[2];
    return glbk_sfield_scene_entities(gl, &sfield, two, 2);
}

static glbk_result limit_of_wavelets(void)
{
    static const sfield_entity two[2];
    return glbk_sfield_scene_entities(gl, &trees, two, 2);
}

RULE(more_than_there_is_room_for_is_a_limit_in_every_header, GLBK_ERR_LIMIT, [BASE] = none, [PROGRAMS] = none,
     [GBUFFER] = none, [CSM] = limit_of_csm, [ENVSHADOW] = limit_of_envshadow, [RSM] = limit_of_rsm,
     [ISM] = limit_of_ism, [SHADOWFIELD] = limit_of_shadowfield, [WAVELETS] = limit_of_wavelets)

static float picture[4 * SIDE * SIDE];

static glbk_result order_of_gbuffer(void) { return glbk_gbuffer_object(gl, &seen, &(glbk_surface){ 0 }); }
static glbk_result order_of_csm(void) { return glbk_csm_read(gl, &csm_renderer, picture); }
static glbk_result order_of_rsm(void) { return glbk_rsm_read(gl, &rsm, 1, picture); }
static glbk_result order_of_ism(void) { return glbk_ism_mesh_move(gl, &ism, corners, 0); }

RULE(a_call_that_comes_too_early_is_an_order_in_every_header, GLBK_ERR_ORDER, [BASE] = none, [PROGRAMS] = none,
     [GBUFFER] = order_of_gbuffer, [CSM] = order_of_csm, [ENVSHADOW] = none, [RSM] = order_of_rsm,
     [ISM] = order_of_ism, [SHADOWFIELD] = none, [WAVELETS] = none)

static glbk_result mismatch_of_ism(void) { return glbk_ism_shade(gl, &ism_renderer, &small, &ism, NULL, 0); }
static glbk_result mismatch_of_rsm(void) { return glbk_rsm_denoise(gl, &rsm, &seen, NULL, NULL); }

static glbk_result mismatch_of_base(void)
{
    glbk_target_desc d;
    glbk_target made;
    memset(&d, 0, sizeof d);
    d.color[0] = &seen.words[0];
    d.color[1] = &small.words[0];
    return glbk_target_create(gl, &d, &made);
}

static glbk_result mismatch_of_gbuffer(void)
{
    glbk_import d;
    memset(&d, 0, sizeof d);
    d.normals = d.positions = &small.words[0];
    return glbk_gbuffer_import(gl, &seen, &d);
}

static glbk_result mismatch_of_csm(void)
{
    const glbk_pass pass = { 0 };
    return glbk_csm_resolve(gl, &csm_renderer, &small, &pass, NULL);
}

static glbk_result mismatch_of_envshadow(void)
{
    static const envsh_view other = { .guard = 3 };
    return glbk_envsh_maps_render(gl, &envsh, &other, 1, draw_nothing, NULL);
}

static glbk_result mismatch_of_shadowfield(void)
{
    const sfield_desc d = { .bands = 2, .cube_side = 4, .shell_count = 2, .position_side = 2 };
    sfield_entity e;
    sfield_field *field;
    glbk_result result;
    memset(&e, 0, sizeof e);
    assert_int_equal(sfield_build(&d, &tetrahedron, &field, NULL), SFIELD_OK);
    e.occlusion = field;                /* which was not uploaded */
    result = glbk_sfield_scene_entities(gl, &sfield, &e, 1);
    sfield_free(field);
    return result;
}

static glbk_result mismatch_of_wavelets(void) { return glbk_sfield_haar_shade(gl, &haar, &small, &trees, NULL, 0); }

RULE(what_does_not_belong_together_is_a_mismatch_in_every_header, GLBK_ERR_MISMATCH, [BASE] = mismatch_of_base,
     [PROGRAMS] = none, [GBUFFER] = mismatch_of_gbuffer, [CSM] = mismatch_of_csm, [ENVSHADOW] = mismatch_of_envshadow,
     [RSM] = mismatch_of_rsm, [ISM] = mismatch_of_ism, [SHADOWFIELD] = mismatch_of_shadowfield,
     [WAVELETS] = mismatch_of_wavelets)

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(a_width_above_that_of_the_context_is_a_limit_in_every_header),
        gl_unit_test(no_width_is_a_fault_of_the_desc_in_every_header),
        gl_unit_test(a_pointer_that_is_missing_is_an_argument_in_every_header),
        gl_unit_test(an_object_that_was_not_created_is_an_argument_in_every_header),
        gl_unit_test(a_number_out_of_range_is_an_argument_in_every_header),
        gl_unit_test(a_field_out_of_range_is_a_desc_in_every_header),
        gl_unit_test(a_pointer_missing_in_a_desc_is_a_desc_in_every_header),
        gl_unit_test(half_an_allocator_is_a_desc_as_it_is_without_gl),
        gl_unit_test(a_bad_mesh_has_the_code_that_it_has_without_gl),
        gl_unit_test(a_value_of_the_callers_data_is_input_in_every_header),
        gl_unit_test(more_than_there_is_room_for_is_a_limit_in_every_header),
        gl_unit_test(a_call_that_comes_too_early_is_an_order_in_every_header),
        gl_unit_test(what_does_not_belong_together_is_a_mismatch_in_every_header),
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE45 | GL_ES30_BARE);
}
