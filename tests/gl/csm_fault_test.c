/* csm_fault_test - glbk_csm when GL or memory fails in any call: the error is named, nothing is left; a hostile state;
   a lost context. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl_backend.h"

#include "gl/gl_test.h"
#include "gl/gl_fake.h"

enum { SIDE = 8, PIXELS = SIDE * SIDE, MAP = 8, QUESTIONS = 20 };

typedef struct things {
    glbk_csm_maps     maps;
    glbk_csm_lights   lights;
    glbk_csm_renderer renderer;
    glbk_csm_asker    asker;
    glbk_csm_builder  builder;
    uint32_t          start;
    float             picture[PIXELS][4], visible[QUESTIONS];
} things;

/* One view along z; nothing is drawn. */
static void view_of(void *user, uint32_t index, glbk_csm_view *out)
{
    int i;
    (void)user;
    (void)index;
    memset(out, 0, sizeof *out);
    for (i = 0; i < 4; i++) out->matrix[5 * i] = 1;
    out->depth_scale = 1;
}

static void draw_nothing(void *user, glbk_context *ctx)
{
    (void)user;
    (void)ctx;
}

static glbk_csm_light_desc disc(void)
{
    glbk_csm_light_desc d;
    memset(&d, 0, sizeof d);
    d.shape = GLBK_CSM_SHAPE_DISC;
    d.position[2] = 2;
    d.direction[2] = -1;
    d.radius = 0.5f;
    d.radiance[0] = d.radiance[1] = d.radiance[2] = 1;
    return d;
}

static glbk_result make(gl_test *t, things *x)
{
    static const glbk_csm_pixel none;
    const glbk_csm_light_desc light = disc();
    glbk_csm_lights_desc lights;
    glbk_csm_renderer_desc renderer = { SIDE, SIDE, 0, 0, NULL };
    glbk_csm_builder_desc builder;
    glbk_csm_pixel pixels[PIXELS];
    glbk_result result;
    int i;

    memset(x, 0, sizeof *x);
    memset(&lights, 0, sizeof lights);
    memset(&builder, 0, sizeof builder);
    for (i = 0; i < PIXELS; i++) {
        pixels[i] = none;
        pixels[i].position[0] = (float)(i % SIDE) / SIDE - 0.5f;
        pixels[i].normal[2] = pixels[i].geometric[2] = 1;
        pixels[i].surface.brdf = GLBK_CSM_BRDF_LAMBERT;
        pixels[i].surface.diffuse[0] = 0.5f;
        pixels[i].surface.self = GLBK_CSM_NO_SELF;
    }
    lights.lights = &light;
    lights.light_count = 1;
    builder.map_size = MAP;
    builder.view_fn = view_of;
    builder.draw_fn = draw_nothing;
    result = glbk_csm_maps_create(&t->gl, NULL, 0, 1, NULL, &x->maps);
    if (result == GLBK_OK) result = glbk_csm_lights_create(&t->gl, &lights, &x->start, &x->lights);
    if (result == GLBK_OK) result = glbk_csm_lights_update(&t->gl, &x->lights, x->start, &light);
    if (result == GLBK_OK) result = glbk_csm_renderer_create(&t->gl, &renderer, &x->renderer);
    if (result == GLBK_OK) result = glbk_csm_gbuffer_upload(&t->gl, &x->renderer, 0, SIDE, pixels);
    if (result == GLBK_OK) result = glbk_csm_asker_create(&t->gl, QUESTIONS, &x->asker);
    if (result == GLBK_OK) result = glbk_csm_builder_create(&t->gl, &builder, &x->builder);
    return result;
}

static void destroy(gl_test *t, things *x)
{
    glbk_csm_builder_destroy(&t->gl, &x->builder);
    glbk_csm_asker_destroy(&t->gl, &x->asker);
    glbk_csm_renderer_destroy(&t->gl, &x->renderer);
    glbk_csm_lights_destroy(&t->gl, &x->lights);
    glbk_csm_maps_destroy(&t->gl, &x->maps);
}

static int count_views(void *user, uint32_t index, const float *z1, const float *z2, const float *z3)
{
    (void)index;
    (void)z3;
    *(int *)user += z1[0] > 1 && z2[0] > 1;         /* nothing was hit */
    return 0;
}

/* A frame of everything; the picture is that of the first of a sum. */
static glbk_result run(gl_test *t, things *x)
{
    glbk_csm_use use;
    glbk_csm_frame_desc f;
    glbk_result result;
    float depths[MAP * MAP];
    int views = 0;
    memset(&use, 0, sizeof use);
    memset(&f, 0, sizeof f);
    use.start = x->start;
    use.shape = GLBK_CSM_SHAPE_DISC;
    use.maps = &x->maps;
    use.samples = 4;
    f.lights = &x->lights;
    f.uses = &use;
    f.use_count = 1;
    f.eye[2] = 3;
    f.samples_per_pass = 3;
    glbk_csm_reset(&x->renderer);
    result = glbk_csm_render(&t->gl, &x->renderer, &f);
    if (result == GLBK_OK) result = glbk_csm_read(&t->gl, &x->renderer, x->picture[0]);
    if (result == GLBK_OK) result = glbk_csm_builder_draw(&t->gl, &x->builder, 0, 1);
    if (result == GLBK_OK) result = glbk_csm_builder_layers(&t->gl, &x->builder, 0, 0, depths);
    if (result == GLBK_OK && x->builder.next_view == 0) result = glbk_csm_builder_compress(&t->gl, &x->builder);
    if (result == GLBK_OK) result = glbk_csm_builder_replay(&t->gl, &x->builder, count_views, &views);
    if (result == GLBK_OK) assert_int_equal(views, 1);
    return result;
}

/* Objects are made anew for each error; a frame has them already, with its programs. */
static void gl_fails_in_every_call(void **state)
{
    GL_TEST(t, state)
    static things x;
    int failures[2] = { 0, 0 }, running, live;
    for (running = 0; running < 2; running++) {
        glbk_result result = GLBK_ERR_GL;
        fake_begin(t, 0x0505);
        if (running) {
            assert_glbk(t, make(t, &x));
            assert_glbk(t, run(t, &x));
        }
        live = fake.live;
        for (fake.at = 1; result != GLBK_OK; fake.at++) {
            fake.calls = 0;
            result = running ? run(t, &x) : make(t, &x);
            if (!running) destroy(t, &x);
            assert_int_equal(fake.live, live);
            assert_true(result == GLBK_OK || result == GLBK_ERR_GL_MEMORY || result == GLBK_ERR_PENDING);
            failures[running] += result != GLBK_OK;
            assert_true(fake.at < 300);
        }
        if (running) destroy(t, &x);
        assert_int_equal(fake.live, 0);
        t->gl.gl = fake.real;
    }
    printf("failures: %d while making, %d while running\n", failures[0], failures[1]);
    assert_true(failures[0] > 30 && failures[1] > 4);
}

static void memory_runs_out(void **state)
{
    GL_TEST(t, state)
    static things x;
    glbk_result result = GLBK_ERR_ALLOC;
    int given;
    t->gl.allocator.alloc_fn = fake_alloc;
    t->gl.allocator.free_fn = fake_free;
    fake_begin(t, 0);
    for (given = 0; result != GLBK_OK; given++) {
        fake_memory.left = given;
        result = make(t, &x);
        destroy(t, &x);
        assert_int_equal(fake.live, 0);
        assert_int_equal(fake_memory.live, 0);
        assert_true(result == GLBK_OK || result == GLBK_ERR_ALLOC);
        assert_true(given < 100);
    }
    t->gl.gl = fake.real;
    assert_true(given > 4);
}

static void a_lost_context(void **state)
{
    GL_TEST(t, state)
    static things x, other;
    glbk_context ctx;
    float visible[QUESTIONS];
    assert_glbk(t, make(t, &x));
    assert_glbk(t, run(t, &x));
    ctx = t->gl;
    memset(&t->gl.gl, 0, sizeof t->gl.gl);      /* from here on a call of GL would crash */
    glbk_abandon(&t->gl);
    assert_int_equal(run(t, &x), GLBK_ERR_LOST);
    assert_int_equal(make(t, &other), GLBK_ERR_LOST);
    assert_int_equal(glbk_csm_ask_read(&t->gl, &x.asker, QUESTIONS, visible), GLBK_ERR_LOST);
    assert_int_equal(glbk_csm_builder_draw(&t->gl, &x.builder, 0, 1), GLBK_ERR_LOST);
    assert_int_equal(glbk_csm_gbuffer_begin(&t->gl, &x.renderer), GLBK_ERR_LOST);
    glbk_csm_bind(&t->gl, &x.maps);
    destroy(t, &other);
    other = x;
    other.builder = (glbk_csm_builder){ 0 };    /* it owns memory */
    destroy(t, &other);
    t->gl = ctx;
    destroy(t, &x);
}

static const uint32_t switches[] = { 0x0BE2, 0x0B44, 0x0B71, 0x0BD0, 0x8037, 0x0C11, 0x0B90, 0x809E };
static const uint32_t numbers[] = { 0x84E0, 0x8B8D, 0x85B5, 0x8CA6, 0x8CAA, 0x8894, 0x8F37, 0x0B74, 0x0B45,
                                    0x0B46, 0x8069, 0x8C1D, 0x8A28, 0x88ED, 0x88EF, 0x0CF5, 0x0D05 };
enum { SWITCHES = sizeof switches / sizeof *switches, NUMBERS = sizeof numbers / sizeof *numbers };

static void read_state(const glbk_functions *gl, int32_t *out)
{
    int i;
    for (i = 0; i < SWITCHES; i++) *out++ = gl->IsEnabled(switches[i]);
    for (i = 0; i < NUMBERS; i++) gl->GetIntegerv(numbers[i], out++);
    gl->GetIntegerv(0x0BA2 /* viewport */, out);
}

static void turn_over(const glbk_functions *gl)
{
    int i;
    for (i = 0; i < SWITCHES; i++) {
        if (gl->IsEnabled(switches[i])) gl->Disable(switches[i]);
        else gl->Enable(switches[i]);
    }
}

static void hostile_state(void **state)
{
    GL_TEST(t, state)
    static things x;
    static float calm[PIXELS][4];
    const glbk_functions *gl = &t->gl.gl;
    int32_t before[SWITCHES + NUMBERS + 4], after[SWITCHES + NUMBERS + 4];
    gl_canvas theirs = gl_canvas_make(t, GLBK_FORMAT_RGBA8, 4, 4, 0);
    glbk_state saved;
    int i;
    assert_glbk(t, make(t, &x));
    assert_glbk(t, run(t, &x));
    memcpy(calm, x.picture, sizeof calm);
    assert_true(calm[0][0] > 0.01f);
    turn_over(gl);
    gl->Viewport(1, 2, 3, 4);
    gl->Scissor(1, 1, 1, 1);
    gl->ColorMask(0, 1, 0, 1);
    gl->DepthMask(0);
    gl->DepthFunc(0x0200 /* never */);
    gl->CullFace(0x0408 /* both */);
    gl->BlendFuncSeparate(0x0307, 0, 0x0306, 1);
    gl->BindFramebuffer(GLBK_GL_FRAMEBUFFER, theirs.target.name);
    gl->ActiveTexture(GLBK_GL_TEXTURE0 + 3);
    gl->BindTexture(GLBK_GL_TEXTURE_2D, theirs.color.name);
    read_state(gl, before);
    glbk_state_save(&t->gl, &saved);
    assert_glbk(t, run(t, &x));
    glbk_state_restore(&t->gl, &saved);
    read_state(gl, after);
    for (i = 0; i < SWITCHES + NUMBERS + 4; i++) assert_int_equal(before[i], after[i]);
    assert_memory_equal(calm, x.picture, sizeof calm);
    turn_over(gl);
    gl->ColorMask(1, 1, 1, 1);
    gl_canvas_free(t, &theirs);
    destroy(t, &x);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = { gl_unit_test(gl_fails_in_every_call), gl_unit_test(memory_runs_out),
                                  gl_unit_test(a_lost_context), gl_unit_test(hostile_state) };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE45 | GL_ES30_BARE);
}
