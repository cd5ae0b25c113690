/* gl_entity_test - what a point's entity means to csm's scenes: instances are counted from 1, and 0, which structs of
   zeros hold, is none of them. For csm.h, for questions and shaders on the GPU, and for pixels of a G-buffer. */
#define _POSIX_C_SOURCE 200809L
#include "csm.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

#include "gl_backend/gl_csm.h"

#include "gl_test.h"
#include "util.h"

enum { ENTITIES = 4 };              /* none, the two instances, one beyond them */

/* A box of side 1 about the origin. */
typedef struct box { cohsm_maps *maps; glbk_csm_block block; } box;

static box make_box(void)
{
    static const double low[3] = { -0.5, -0.5, -0.5 }, high[3] = { 0.5, 0.5, 0.5 };
    model m = model_box(low, high, 0);
    cohsm_mesh mesh = mesh_of(&m);
    cohsm_desc d = desc_of(COHSM_DOMAIN_OCTAHEDRAL, 8, 32);
    box b;
    assert_int_equal(cohsm_build(&d, &mesh, &b.maps, NULL), COHSM_OK);
    model_free(&m);
    b.block.data = cohsm_data(b.maps, &b.block.bytes);
    return b;
}

static void place(float transform[16], float x, float y, float z)
{
    memset(transform, 0, 16 * sizeof *transform);
    transform[0] = transform[5] = transform[10] = transform[15] = 1;
    transform[12] = x;
    transform[13] = y;
    transform[14] = z;
}

/* Instance 1 hides the light, instance 2 refuses it, since it stands inside. Whoever is asked first decides: the
   instance that the point lies on, if there is one, else the first. */
static void the_instance_of_a_point_is_asked_first(void **state)
{
    GL_TEST(t, state)
    static const uint32_t entities[ENTITIES] = { 0, 1, 2, 3 };
    static const float points[3 * ENTITIES] = { 0, 0, -2, 0, 0, -2, 0, 0, -2, 0, 0, -2 }, light[3] = { 0, 0, 4 };
    static const float first[ENTITIES] = { 0, 0, COHSM_REFUSED, 0 };
    const box b = make_box();
    cohsm_instance on_cpu[2];
    glbk_csm_instance on_gpu[2];
    glbk_csm_maps maps;
    glbk_csm_asker asker;
    cohsm_query q;
    float visible[ENTITIES];
    uint32_t start;
    int i, none;

    memset(on_gpu, 0, sizeof on_gpu);
    assert_glbk(t, glbk_csm_maps_create(&t->gl, &b.block, 1, 2, &start, &maps));
    assert_glbk(t, glbk_csm_asker_create(&t->gl, ENTITIES, &asker));
    for (i = 0; i < 2; i++) {
        on_cpu[i].maps = b.maps;
        on_gpu[i].start = start;
        place(on_cpu[i].transform, 0, 0, i ? 4.0f : 0.0f);
        if (i) place(on_gpu[i].transform, 0, 0, 4);         /* zeros: the identity */
    }
    assert_glbk(t, glbk_csm_maps_place(&t->gl, &maps, on_gpu, 2));
    for (none = 0; none < 2; none++) {
        memset(&q, 0, sizeof q);                    /* zeros: no point lies on anything */
        q.count = ENTITIES;
        q.positions = points;
        q.lights = light;
        q.one_light = 1;
        q.light_kind = COHSM_LIGHT_POSITION;
        if (!none) q.entities = entities;
        assert_int_equal(cohsm_visible_scene(on_cpu, 2, &q, visible, NULL), COHSM_OK);
        for (i = 0; i < ENTITIES; i++) assert_float_equal(visible[i], first[none ? 0 : i], 0);
        assert_glbk(t, glbk_csm_ask_upload(&t->gl, &asker, &q));
        assert_glbk(t, glbk_csm_ask_run(&t->gl, &asker, &maps, ENTITIES));
        assert_glbk(t, glbk_csm_ask_read(&t->gl, &asker, ENTITIES, visible));
        for (i = 0; i < ENTITIES; i++) assert_float_equal(visible[i], first[none ? 0 : i], 0);
    }
    glbk_csm_asker_free(&t->gl, &asker);
    glbk_csm_maps_free(&t->gl, &maps);
    cohsm_free(b.maps);
}

/* Points in a box's shadow, with a sun above the box. Those that lie on instance 1 are moved by its offset, beyond the
   box and into the light; instance 2 stands aside and moves none. A pixel of zeros lies on none, hence stays dark. */
static void points_of_no_entity_lie_on_none(void **state)
{
    GL_TEST(t, state)
    static const float eye[3] = { 0, 0, 5 };
    const box b = make_box();
    glbk_gbuffer_desc size;
    glbk_csm_renderer_desc d;
    glbk_csm_instance instances[2];
    glbk_csm_lights_desc table;
    glbk_csm_frame_desc f;
    glbk_csm_use use;
    glbk_csm_maps maps;
    glbk_csm_lights lights;
    glbk_csm_renderer r;
    glbk_gbuffer seen;
    lsamp_light_desc sun;
    glbk_pixel pixels[ENTITIES];
    float rgba[4 * ENTITIES];
    uint32_t start, light;
    int i;

    memset(&size, 0, sizeof size);
    memset(&d, 0, sizeof d);
    memset(instances, 0, sizeof instances);
    memset(&table, 0, sizeof table);
    memset(&f, 0, sizeof f);
    memset(&use, 0, sizeof use);
    memset(&sun, 0, sizeof sun);
    memset(pixels, 0, sizeof pixels);
    size.width = d.width = ENTITIES;
    size.height = d.height = 1;
    sun.kind = LSAMP_LIGHT_SUN;
    sun.direction[1] = 1;
    sun.radiance[0] = sun.radiance[1] = sun.radiance[2] = 1;
    table.lights = &sun;
    table.light_count = 1;
    assert_glbk(t, glbk_csm_maps_create(&t->gl, &b.block, 1, 2, &start, &maps));
    assert_glbk(t, glbk_csm_lights_create(&t->gl, &table, &light, &lights));
    assert_glbk(t, glbk_csm_renderer_create(&t->gl, &d, &r));
    assert_glbk(t, glbk_gbuffer_create(&t->gl, &size, &seen));
    place(instances[0].transform, 0, 0, 0);
    place(instances[1].transform, 10, 0, 0);
    instances[0].start = instances[1].start = start;
    instances[0].offset = 3;
    assert_glbk(t, glbk_csm_maps_place(&t->gl, &maps, instances, 2));
    for (i = 0; i < ENTITIES; i++) {
        pixels[i].position[1] = -1;
        pixels[i].normal[1] = 1;
        pixels[i].material.diffuse[0] = pixels[i].material.diffuse[1] = pixels[i].material.diffuse[2] = 1;
        if (i) pixels[i].entity = (uint32_t)i;      /* the first pixel has zeros */
    }
    assert_glbk(t, glbk_gbuffer_upload(&t->gl, &seen, 0, 1, pixels));
    use.start = light;
    use.kind = sun.kind;
    use.maps = &maps;
    use.sample_count = 1;
    f.lights = &lights;
    f.uses = &use;
    f.use_count = 1;
    memcpy(f.eye, eye, sizeof eye);
    assert_glbk(t, glbk_csm_render(&t->gl, &r, &seen, &f));
    assert_glbk(t, glbk_csm_read(&t->gl, &r, rgba));
    for (i = 0; i < ENTITIES; i++) assert_int_equal(rgba[4 * i] > 0, i == 1);
    assert_float_equal(rgba[4], 1 / 3.14159265f, 1e-5);
    memset(pixels, 0xff, sizeof pixels);
    assert_glbk(t, glbk_gbuffer_read(&t->gl, &seen, 0, 1, pixels));
    for (i = 0; i < ENTITIES; i++) assert_int_equal(pixels[i].entity, i);
    glbk_gbuffer_free(&t->gl, &seen);
    glbk_csm_renderer_free(&t->gl, &r);
    glbk_csm_lights_free(&t->gl, &lights);
    glbk_csm_maps_free(&t->gl, &maps);
    cohsm_free(b.maps);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = { gl_unit_test(the_instance_of_a_point_is_asked_first),
                                  gl_unit_test(points_of_no_entity_lie_on_none) };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE45 | GL_CORE33 | GL_ES30_BARE);
}
