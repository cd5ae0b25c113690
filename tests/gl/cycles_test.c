/* cycles_test - objects of every technique made and destroyed a thousand times: no name is left, neither by our count
   nor by GL's; half of the time only a part of them, as an error leaves them. Programs are names only (gl_fake.h);
   fault_test has the base layer's objects and real programs. */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl_backend.h"

#include "gl/gl_test.h"
#include "gl/gl_fake.h"

enum { CYCLES = 1000 };

static const float zeros[64];

/* make: the first failure ends it; destroy: always of all. */
typedef struct technique {
    glbk_result (*make)(gl_test *t);
    void        (*destroy)(gl_test *t);
} technique;

/* ---- csm ---- */

static struct {
    glbk_csm_maps     maps;
    glbk_csm_lights   lights;
    glbk_csm_renderer renderer;
    glbk_csm_asker    asker;
    glbk_csm_builder  builder;
} csm;

static void no_view(void *user, uint32_t index, glbk_csm_view *out) { (void)user, (void)index, (void)out; }
static void no_draw(void *user, glbk_context *ctx) { (void)user, (void)ctx; }

static glbk_result make_csm(gl_test *t)
{
    static const glbk_csm_renderer_desc renderer = { 4, 4, 0, 0, NULL };
    const glbk_csm_questions questions = { GLBK_CSM_ASK_DIRECTION, GLBK_CSM_FILTER_NEAREST, 0, 0,
                                           (const uint32_t *)(const void *)zeros, 8 };
    glbk_csm_light_desc light;
    glbk_csm_lights_desc lights;
    glbk_csm_builder_desc builder;
    glbk_result result;
    uint32_t start;
    memset(&csm, 0, sizeof csm);
    memset(&light, 0, sizeof light);
    memset(&lights, 0, sizeof lights);
    memset(&builder, 0, sizeof builder);
    light.shape = GLBK_CSM_SHAPE_SUN;
    light.direction[2] = 1;
    lights.lights = &light;
    lights.light_count = 1;
    builder.map_size = 4;
    builder.view_fn = no_view;
    builder.draw_fn = no_draw;
    result = glbk_csm_maps_create(&t->gl, NULL, 0, 1, NULL, &csm.maps);
    if (result == GLBK_OK) result = glbk_csm_lights_create(&t->gl, &lights, &start, &csm.lights);
    if (result == GLBK_OK) result = glbk_csm_renderer_create(&t->gl, &renderer, &csm.renderer);
    if (result == GLBK_OK) result = glbk_csm_asker_create(&t->gl, 8, &csm.asker);
    if (result == GLBK_OK) result = glbk_csm_ask_upload(&t->gl, &csm.asker, &questions);
    if (result == GLBK_OK) result = glbk_csm_builder_create(&t->gl, &builder, &csm.builder);
    return result;
}

static void destroy_csm(gl_test *t)
{
    glbk_csm_builder_destroy(&t->gl, &csm.builder);
    glbk_csm_asker_destroy(&t->gl, &csm.asker);
    glbk_csm_renderer_destroy(&t->gl, &csm.renderer);
    glbk_csm_lights_destroy(&t->gl, &csm.lights);
    glbk_csm_maps_destroy(&t->gl, &csm.maps);
}

/* ---- sfield ---- */

static struct {
    glbk_sfield_world    world;
    glbk_sfield_renderer renderer;
    glbk_sfield_builder  builder;
} sfield;

static glbk_result make_sfield(gl_test *t)
{
    static const float corners[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };
    static const uint32_t indices[3] = { 0, 1, 2 };
    glbk_sfield_desc world;
    glbk_sfield_renderer_desc renderer;
    glbk_sfield_builder_desc builder;
    glbk_result result;
    memset(&sfield, 0, sizeof sfield);
    memset(&world, 0, sizeof world);
    memset(&renderer, 0, sizeof renderer);
    memset(&builder, 0, sizeof builder);
    world.bands = renderer.bands = 1;
    world.capacity = 1;
    renderer.width = renderer.height = 4;
    builder.cube_side = 4;
    builder.positions = corners;
    builder.vertex_count = 3;
    builder.indices = indices;
    builder.index_count = 3;
    result = glbk_sfield_create(&t->gl, &world, NULL, &sfield.world);
    if (result == GLBK_OK) result = glbk_sfield_renderer_create(&t->gl, &renderer, &sfield.renderer);
    if (result == GLBK_OK) result = glbk_sfield_builder_create(&t->gl, &builder, &sfield.builder);
    return result;
}

static void destroy_sfield(gl_test *t)
{
    glbk_sfield_builder_destroy(&t->gl, &sfield.builder);
    glbk_sfield_renderer_destroy(&t->gl, &sfield.renderer);
    glbk_sfield_destroy(&t->gl, &sfield.world);
}

/* ---- envsh ---- */

static struct { glbk_envsh_maps maps; glbk_envsh_renderer renderer; } envsh;

static glbk_result make_envsh(gl_test *t)
{
    glbk_envsh_maps_desc maps;
    glbk_result result;
    memset(&envsh, 0, sizeof envsh);
    memset(&maps, 0, sizeof maps);
    maps.capacity = 2;
    maps.map_size = 16;
    maps.rgba = 1;
    result = glbk_envsh_maps_create(&t->gl, &maps, &envsh.maps);
    if (result == GLBK_OK) result = glbk_envsh_renderer_create(&t->gl, 4, 4, &envsh.renderer);
    return result;
}

static void destroy_envsh(gl_test *t)
{
    glbk_envsh_renderer_destroy(&t->gl, &envsh.renderer);
    glbk_envsh_maps_destroy(&t->gl, &envsh.maps);
}

/* ---- rsm ---- */

static struct { glbk_rsm_map map; glbk_rsm_renderer renderer; } rsm;

static glbk_result make_rsm(gl_test *t)
{
    static const glbk_rsm_renderer_desc renderer = { 4, 4, 1, 1 };
    const glbk_rsm_tables tables = { zeros, 8, zeros, 4, zeros, 2 };
    glbk_rsm_lamp lamp;
    glbk_result result;
    memset(&rsm, 0, sizeof rsm);
    memset(&lamp, 0, sizeof lamp);
    lamp.kind = GLBK_RSM_SUN;
    lamp.direction[1] = 1;
    lamp.radius = 1;
    result = glbk_rsm_map_create(&t->gl, &lamp, 4, &rsm.map);
    if (result == GLBK_OK) result = glbk_rsm_renderer_create(&t->gl, &renderer, &rsm.renderer);
    if (result == GLBK_OK) result = glbk_rsm_tables_upload(&t->gl, &rsm.renderer, &tables);
    return result;
}

static void destroy_rsm(gl_test *t)
{
    glbk_rsm_renderer_destroy(&t->gl, &rsm.renderer);
    glbk_rsm_map_destroy(&t->gl, &rsm.map);
}

/* ---- ism ---- */

static struct { glbk_ism_maps maps; glbk_ism_renderer renderer; } ism;

static glbk_result make_ism(gl_test *t)
{
    static const glbk_ism_desc maps = { 1, 8, 8, 0, 1, 0, 0, 0, 0, 0 };
    static const uint32_t indices[3] = { 0, 1, 2 };
    const glbk_ism_mesh mesh = { zeros, 3, 0, indices, 3, NULL };
    glbk_result result;
    memset(&ism, 0, sizeof ism);
    result = glbk_ism_maps_create(&t->gl, &maps, &ism.maps);
    if (result == GLBK_OK) result = glbk_ism_mesh_upload(&t->gl, &ism.maps, &mesh);
    if (result == GLBK_OK) result = glbk_ism_renderer_create(&t->gl, 4, 4, &ism.renderer);
    return result;
}

static void destroy_ism(gl_test *t)
{
    glbk_ism_renderer_destroy(&t->gl, &ism.renderer);
    glbk_ism_maps_destroy(&t->gl, &ism.maps);
}

/* ---- cycles ---- */

static void cycle(gl_test *t, technique a)
{
    int i, before = gl_names_in_use(t), asked;
    fake_begin_hollow(t, 0x0505);
    assert_glbk(t, a.make(t));
    assert_true(gl_names_in_use(t) > before && fake.live > 4);      /* the counts count */
    asked = fake.calls;
    a.destroy(t);
    for (i = 0; i < CYCLES; i++) {
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

#define CYCLE(name)                                             \
    static void a_thousand_cycles_of_##name(void **state)       \
    {                                                           \
        GL_TEST(t, state)                                       \
        const technique a = { make_##name, destroy_##name };    \
        cycle(t, a);                                            \
    }
CYCLE(csm)
CYCLE(sfield)
CYCLE(envsh)
CYCLE(rsm)
CYCLE(ism)

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(a_thousand_cycles_of_csm), gl_unit_test(a_thousand_cycles_of_sfield),
        gl_unit_test(a_thousand_cycles_of_envsh), gl_unit_test(a_thousand_cycles_of_rsm),
        gl_unit_test(a_thousand_cycles_of_ism),
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE45 | GL_ES30_BARE);
}
