/* cycles_test - objects of every technique made and destroyed a thousand times (in a browser, where each call of GL
   takes its time, as often as there are calls that can fail): no name is left, neither by our count nor by GL's; half
   of the time only a part of them, as an error leaves them. Programs are names only (gl_fake.h); gl_backend/fault_test
   has the base layer's objects and real programs. */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl_backend/gl_csm.h"
#include "gl_backend/gl_wavelets.h"
#include "gl_backend/gl_envshadow.h"
#include "gl_backend/gl_rsm.h"
#include "gl_backend/gl_ism.h"

#include "gl_test.h"
#include "gl_fake.h"

enum { CYCLES = 1000 };

static const float zeros[64];

/* make: the first failure ends it; destroy: always of all. */
typedef struct technique {
    glbk_result (*make)(gl_test *t);
    void        (*destroy)(gl_test *t);
} technique;

/* ---- the G-buffer ---- */

static glbk_gbuffer seen;

static glbk_result make_gbuffer(gl_test *t)
{
    glbk_gbuffer_desc size;
    glbk_result result;
    memset(&size, 0, sizeof size);
    size.width = size.height = 4;
    result = glbk_gbuffer_create(&t->gl, &size, &seen);
    size.width = 5;
    return result == GLBK_OK ? glbk_gbuffer_resize(&t->gl, &seen, &size) : result;
}

static void destroy_gbuffer(gl_test *t) { glbk_gbuffer_free(&t->gl, &seen); }

/* ---- csm ---- */

static struct {
    glbk_csm_maps     maps;
    glbk_csm_lights   lights;
    glbk_csm_renderer renderer;
    glbk_csm_asker    asker;
    glbk_csm_builder  builder;
} csm;

static void no_view(void *user, uint32_t index, cohsm_view *out) { (void)user, (void)index, (void)out; }
static void no_draw(void *user, glbk_context *ctx) { (void)user, (void)ctx; }

static glbk_result make_csm(gl_test *t)
{
    static const glbk_csm_renderer_desc renderer = { 4, 4, 0, 0, NULL };
    cohsm_query questions;
    lsamp_light_desc light;
    glbk_csm_lights_desc lights;
    glbk_csm_builder_desc builder;
    cohsm_desc maps;
    glbk_result result;
    uint32_t start;
    memset(&csm, 0, sizeof csm);
    memset(&light, 0, sizeof light);
    memset(&lights, 0, sizeof lights);
    memset(&questions, 0, sizeof questions);
    memset(&builder, 0, sizeof builder);
    memset(&maps, 0, sizeof maps);
    questions.count = 8;
    questions.positions = questions.lights = (const float *)(const void *)zeros;
    light.kind = LSAMP_LIGHT_SUN;
    light.direction[2] = 1;
    lights.lights = &light;
    lights.light_count = 1;
    maps.map_side = 4;
    builder.maps = &maps;
    builder.view_fn = no_view;
    builder.draw_fn = no_draw;
    result = glbk_csm_maps_create(&t->gl, NULL, 0, 1, NULL, &csm.maps);
    if (result == GLBK_OK) result = glbk_csm_lights_create(&t->gl, &lights, &start, &csm.lights);
    if (result == GLBK_OK) result = glbk_csm_renderer_create(&t->gl, &renderer, &csm.renderer);
    if (result == GLBK_OK) result = glbk_csm_asker_create(&t->gl, 8, &csm.asker);
    if (result == GLBK_OK) result = glbk_csm_ask_upload(&t->gl, &csm.asker, &questions);
    if (result == GLBK_OK) result = glbk_csm_builder_create(&t->gl, &builder, &csm.builder);
    if (result == GLBK_OK) result = glbk_csm_renderer_resize(&t->gl, &csm.renderer, 5, 3);
    return result;
}

static void destroy_csm(gl_test *t)
{
    glbk_csm_builder_free(&t->gl, &csm.builder);
    glbk_csm_asker_free(&t->gl, &csm.asker);
    glbk_csm_renderer_free(&t->gl, &csm.renderer);
    glbk_csm_lights_free(&t->gl, &csm.lights);
    glbk_csm_maps_free(&t->gl, &csm.maps);
}

/* ---- sfield ---- */

static struct {
    sfield_algebra      *algebra;
    glbk_sfield_scene    scene;
    glbk_sfield_renderer renderer;
    glbk_sfield_builder  builder;
    glbk_sfield_scene    trees;
    glbk_sfield_haar     haar;
} sfield;

static glbk_result make_sfield(gl_test *t)
{
    static const float corners[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };
    static const uint32_t indices[3] = { 0, 1, 2 };
    const sfield_mesh mesh = { corners, 3, 0, indices, 3, NULL, NULL, NULL };
    glbk_sfield_scene_desc scene;
    glbk_sfield_renderer_desc renderer;
    glbk_sfield_builder_desc builder;
    const glbk_sfield_haar_scene_desc trees = { NULL, 0, 4, 1, 0 };
    const glbk_sfield_haar_desc haar = { 4, 4, 4, 0, 1, 0 };
    sfield_desc field;
    glbk_result result;
    memset(&sfield, 0, sizeof sfield);
    memset(&scene, 0, sizeof scene);
    memset(&renderer, 0, sizeof renderer);
    memset(&builder, 0, sizeof builder);
    memset(&field, 0, sizeof field);
    if (sfield_algebra_create(1, NULL, &sfield.algebra) != SFIELD_OK) return GLBK_ERR_ALLOC;
    scene.algebra = renderer.algebra = sfield.algebra;
    scene.entity_capacity = 1;
    renderer.width = renderer.height = 4;
    field.basis = SFIELD_BASIS_HAAR;
    field.cube_side = 4;
    builder.field = &field;
    builder.mesh = &mesh;
    result = glbk_sfield_scene_create(&t->gl, &scene, &sfield.scene);
    if (result == GLBK_OK) result = glbk_sfield_renderer_create(&t->gl, &renderer, &sfield.renderer);
    if (result == GLBK_OK) result = glbk_sfield_builder_create(&t->gl, &builder, &sfield.builder);
    if (result == GLBK_OK) result = glbk_sfield_renderer_resize(&t->gl, &sfield.renderer, 5, 3);
    if (result == GLBK_OK) result = glbk_sfield_haar_upload(&t->gl, &trees, &sfield.trees);
    if (result == GLBK_OK) result = glbk_sfield_haar_create(&t->gl, &haar, &sfield.haar);
    return result;
}

static void destroy_sfield(gl_test *t)
{
    glbk_sfield_haar_free(&t->gl, &sfield.haar);
    glbk_sfield_scene_free(&t->gl, &sfield.trees);
    glbk_sfield_builder_free(&t->gl, &sfield.builder);
    glbk_sfield_renderer_free(&t->gl, &sfield.renderer);
    glbk_sfield_scene_free(&t->gl, &sfield.scene);
    sfield_algebra_free(sfield.algebra);
}

/* ---- envsh ---- */

static struct { glbk_envsh_maps maps; glbk_envsh_renderer renderer; } envsh;

static glbk_result make_envsh(gl_test *t)
{
    const envsh_maps_desc layout = { .map_side = 16, .rgba = 1 };
    glbk_envsh_maps_desc maps;
    glbk_result result;
    memset(&envsh, 0, sizeof envsh);
    memset(&maps, 0, sizeof maps);
    maps.capacity = 2;
    maps.maps = &layout;
    result = glbk_envsh_maps_create(&t->gl, &maps, &envsh.maps);
    if (result == GLBK_OK)
        result = glbk_envsh_renderer_create(&t->gl, &(glbk_envsh_renderer_desc){ 4, 4 }, &envsh.renderer);
    if (result == GLBK_OK) result = glbk_envsh_renderer_resize(&t->gl, &envsh.renderer, 5, 3);
    return result;
}

static void destroy_envsh(gl_test *t)
{
    glbk_envsh_renderer_free(&t->gl, &envsh.renderer);
    glbk_envsh_maps_free(&t->gl, &envsh.maps);
}

/* ---- rsm ---- */

static struct { glbk_rsm_map map; glbk_rsm_renderer renderer; } rsm;

static glbk_result make_rsm(gl_test *t)
{
    static const glbk_rsm_renderer_desc renderer = { 4, 4, 1, 1, 0, { 0, 0, 0, 0, NULL, NULL } };
    static const rsm_material materials[2];
    rsm_gather_desc tables;
    rsm_light lamp;
    glbk_result result;
    memset(&rsm, 0, sizeof rsm);
    memset(&lamp, 0, sizeof lamp);
    memset(&tables, 0, sizeof tables);
    tables.pattern = RSM_PATTERN_LOG_RADIAL;
    tables.sample_count = 8;
    tables.noise = zeros;
    tables.noise_side = 4;
    tables.materials = materials;
    tables.material_count = 2;
    lamp.kind = RSM_LIGHT_SUN;
    lamp.direction[1] = 1;
    lamp.radius = 1;
    result = glbk_rsm_map_create(&t->gl, &lamp, 4, &rsm.map);
    if (result == GLBK_OK) result = glbk_rsm_renderer_create(&t->gl, &renderer, &rsm.renderer);
    if (result == GLBK_OK) result = glbk_rsm_tables_upload(&t->gl, &rsm.renderer, &tables, zeros);
    if (result == GLBK_OK) result = glbk_rsm_renderer_resize(&t->gl, &rsm.renderer, 5, 3);
    return result;
}

static void destroy_rsm(gl_test *t)
{
    glbk_rsm_renderer_free(&t->gl, &rsm.renderer);
    glbk_rsm_map_free(&t->gl, &rsm.map);
}

/* ---- ism ---- */

static struct { glbk_ism_maps maps; glbk_ism_renderer renderer; } ism;

static glbk_result make_ism(gl_test *t)
{
    static const uint32_t indices[3] = { 0, 1, 2 };
    const ism_mesh mesh = { zeros, 3, 0, indices, 3, NULL, NULL, NULL, NULL, NULL };
    ism_desc maps;
    glbk_result result;
    memset(&ism, 0, sizeof ism);
    memset(&maps, 0, sizeof maps);
    maps.vpl_count = maps.lazy_frames = 1;
    maps.surfel_count = maps.tile_side = 8;
    result = glbk_ism_maps_create(&t->gl, &maps, &ism.maps);
    if (result == GLBK_OK) result = glbk_ism_mesh_upload(&t->gl, &ism.maps, &mesh);
    if (result == GLBK_OK) result = glbk_ism_renderer_create(&t->gl, &(glbk_ism_renderer_desc){ 4, 4 }, &ism.renderer);
    if (result == GLBK_OK) result = glbk_ism_renderer_resize(&t->gl, &ism.renderer, 5, 3);
    return result;
}

static void destroy_ism(gl_test *t)
{
    glbk_ism_renderer_free(&t->gl, &ism.renderer);
    glbk_ism_maps_free(&t->gl, &ism.maps);
}

/* ---- cycles ---- */

static void cycle(gl_test *t, technique a)
{
    int i, before = gl_names_in_use(t), asked, cycles = CYCLES;
    fake_begin_hollow(t, 0x0505);
    assert_glbk(t, a.make(t));
    assert_true(gl_names_in_use(t) > before && fake.live > 4);      /* the counts count */
    asked = fake.calls;
    a.destroy(t);
#ifdef __EMSCRIPTEN__
    cycles = 2 * asked;
#endif
    for (i = 0; i < cycles; i++) {
        glbk_result result;
        fake.calls = 0;
        fake.at = i % 2 ? 1 + i / 2 % asked : 0;
        result = a.make(t);
        assert_true(i % 2 ? result == GLBK_ERR_GL_MEMORY || result == GLBK_ERR_PENDING : result == GLBK_OK);
        a.destroy(t);
        assert_int_equal(fake.live, 0);
    }
    t->gl.gl = fake.real;
    assert_int_equal(gl_names_in_use(t), before);
}

#define CYCLE(name)                                                         \
    static void cycles_of_##name##_leave_nothing(void **state)              \
    {                                                                       \
        GL_TEST(t, state)                                                   \
        const technique a = { make_##name, destroy_##name };    \
        cycle(t, a);                                            \
    }
CYCLE(gbuffer)
CYCLE(csm)
CYCLE(sfield)
CYCLE(envsh)
CYCLE(rsm)
CYCLE(ism)

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(cycles_of_csm_leave_nothing),   gl_unit_test(cycles_of_sfield_leave_nothing),
        gl_unit_test(cycles_of_envsh_leave_nothing), gl_unit_test(cycles_of_rsm_leave_nothing),
        gl_unit_test(cycles_of_ism_leave_nothing),   gl_unit_test(cycles_of_gbuffer_leave_nothing),
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE45 | GL_ES30_BARE);
}
