/* gl_fault_test - glbk_csm when GL or memory fails in any call: the error is named, nothing is left; GL's state round
   every call, from a hostile one too; a lost context. */
#define _POSIX_C_SOURCE 200809L
#include "csm.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl_backend/gl_csm.h"

#include "gl_test.h"
#include "gl_fake.h"
#include "gl_state.h"
#include "util.h"

enum { SIDE = 8, PIXELS = SIDE * SIDE, MAP = 8, QUESTIONS = 20 };

typedef struct things {
    glbk_csm_maps     maps;
    glbk_csm_lights   lights;
    glbk_csm_renderer renderer;
    glbk_gbuffer      seen;
    glbk_csm_asker    asker;
    glbk_csm_builder  builder;
    glbk_csm_instance plate;
    uint32_t          start;
    float             picture[PIXELS][4], drawn[PIXELS][4], visible[QUESTIONS];
} things;

/* What is there before anything fails: a plate over the left half of the pixels, as csm.h built it; a square to draw; a
   target to resolve to. */
typedef struct stage {
    cohsm_maps *plate;
    gl_canvas   screen;
    uint32_t    square, corners;
} stage;

static stage world;

static void set_stage(gl_test *t)
{
    static const double low[3] = { -0.8, -0.4, 0.2 }, high[3] = { -0.2, 0.4, 0.25 };
    static const float v[4][6] = { { -1, -1, 0, 0, 0, 1 }, { 1, -1, 0, 0, 0, 1 },
                                   { -1, 1, 0, 0, 0, 1 }, { 1, 1, 0, 0, 0, 1 } };
    const glbk_functions *gl = &t->gl.gl;
    model m = model_box(low, high, 0);
    cohsm_mesh mesh = mesh_of(&m);
    cohsm_desc d = desc_of(COHSM_DOMAIN_OCTAHEDRAL, 8, 32);
    assert_int_equal(cohsm_build(&d, &mesh, &world.plate, NULL), COHSM_OK);
    model_free(&m);
    world.screen = gl_canvas_make(t, GLBK_FORMAT_COLOR, SIDE, SIDE, 0);
    gl->GenVertexArrays(1, &world.square);
    gl->GenBuffers(1, &world.corners);
    gl->BindVertexArray(world.square);
    gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, world.corners);
    gl->BufferData(GLBK_GL_ARRAY_BUFFER, sizeof v, v, GLBK_GL_STATIC_DRAW);
    gl->EnableVertexAttribArray(0);
    gl->EnableVertexAttribArray(1);
    gl->VertexAttribPointer(0, 3, GLBK_GL_FLOAT, 0, sizeof v[0], NULL);
    gl->VertexAttribPointer(1, 3, GLBK_GL_FLOAT, 0, sizeof v[0], (const void *)12);
    gl->BindVertexArray(0);
    gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, 0);
}

static void strike_stage(gl_test *t)
{
    cohsm_free(world.plate);
    gl_canvas_free(t, &world.screen);
    t->gl.gl.DeleteVertexArrays(1, &world.square);
    t->gl.gl.DeleteBuffers(1, &world.corners);
}

/* One view along z; nothing is drawn. */
static void view_of(void *user, uint32_t index, cohsm_view *out)
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

static lsamp_light_desc disc(void)
{
    lsamp_light_desc d;
    memset(&d, 0, sizeof d);
    d.kind = LSAMP_LIGHT_DISC;
    d.position[2] = 2;
    d.direction[2] = -1;
    d.radius = 0.5f;
    d.radiance[0] = d.radiance[1] = d.radiance[2] = 1;
    return d;
}

static void fill_pixels(glbk_pixel *pixels)
{
    int i;
    memset(pixels, 0, PIXELS * sizeof *pixels);
    for (i = 0; i < PIXELS; i++) {
        pixels[i].position[0] = (float)(i % SIDE) / SIDE - 0.5f;
        pixels[i].normal[2] = pixels[i].geometric_normal[2] = 1;
        pixels[i].material.diffuse[0] = 0.5f;
    }
}

/* Straight up: from the open right half, and from below the plate in turn. */
static cohsm_query questions_of(float words[QUESTIONS][6])
{
    cohsm_query q;
    uint32_t i;
    memset(&q, 0, sizeof q);
    memset(words, 0, 24 * QUESTIONS);
    q.positions = words[0];
    q.lights = words[0] + 3;
    q.position_stride = q.light_stride = sizeof words[0];
    q.count = QUESTIONS;
    for (i = 0; i < QUESTIONS; i++) {
        words[i][0] = i % 2 ? -0.5f : 0.3f;
        words[i][5] = 1;
    }
    return q;
}

static glbk_csm_frame_desc frame_of(const things *x, glbk_csm_use *use)
{
    glbk_csm_frame_desc f;
    memset(use, 0, sizeof *use);
    memset(&f, 0, sizeof f);
    use->start = x->start;
    use->kind = LSAMP_LIGHT_DISC;
    use->maps = &x->maps;
    use->sample_count = 4;
    f.lights = &x->lights;
    f.uses = use;
    f.use_count = 1;
    f.eye[2] = 3;
    f.bias = 1;
    f.samples_per_pass = 3;
    return f;
}

static glbk_result make(gl_test *t, things *x)
{
    const lsamp_light_desc light = disc();
    glbk_csm_lights_desc lights;
    glbk_csm_renderer_desc renderer = { SIDE, SIDE, 0, 0, NULL };
    glbk_gbuffer_desc seen = { SIDE, SIDE, { 0, 0, 0, 0, NULL, NULL }, NULL };
    glbk_csm_builder_desc builder;
    cohsm_desc maps;
    glbk_pixel pixels[PIXELS];
    glbk_csm_block block;
    glbk_csm_frame_desc f;
    glbk_csm_use use;
    cohsm_query q;
    float words[QUESTIONS][6];
    glbk_result r = GLBK_OK;
    int i;

    memset(x, 0, sizeof *x);
    memset(&lights, 0, sizeof lights);
    memset(&builder, 0, sizeof builder);
    memset(&maps, 0, sizeof maps);
    fill_pixels(pixels);
    q = questions_of(words);
    block.data = cohsm_data(world.plate, &block.bytes);
    for (i = 0; i < 4; i++) x->plate.transform[5 * i] = 1;
    lights.lights = &light;
    lights.light_count = 1;
    maps.map_side = MAP;
    builder.maps = &maps;
    builder.view_fn = view_of;
    builder.draw_fn = draw_nothing;
    GL_THEN_SAME(t, r, glbk_csm_maps_create(&t->gl, &block, 1, 2, &x->plate.start, &x->maps));
    GL_THEN_SAME(t, r, glbk_csm_maps_place(&t->gl, &x->maps, &x->plate, 1));
    GL_THEN_SAME(t, r, glbk_csm_lights_create(&t->gl, &lights, &x->start, &x->lights));
    GL_THEN_SAME(t, r, glbk_csm_lights_update(&t->gl, &x->lights, x->start, &light));
    GL_THEN_SAME(t, r, glbk_csm_renderer_create(&t->gl, &renderer, &x->renderer));
    GL_THEN_SAME(t, r, glbk_gbuffer_create(&t->gl, &seen, &x->seen));
    GL_THEN_SAME(t, r, glbk_gbuffer_upload(&t->gl, &x->seen, 0, SIDE, pixels));
    f = frame_of(x, &use);
    GL_THEN_SAME(t, r, glbk_csm_prepare(&t->gl, &x->renderer, &f));
    GL_THEN_SAME(t, r, glbk_csm_asker_create(&t->gl, QUESTIONS, &x->asker));
    GL_THEN_SAME(t, r, glbk_csm_ask_upload(&t->gl, &x->asker, &q));
    GL_THEN_SAME(t, r, glbk_csm_builder_create(&t->gl, &builder, &x->builder));
    return r;
}

static void destroy(gl_test *t, things *x)
{
    GL_SAME(t, glbk_csm_builder_free(&t->gl, &x->builder));
    GL_SAME(t, glbk_csm_asker_free(&t->gl, &x->asker));
    GL_SAME(t, glbk_csm_renderer_free(&t->gl, &x->renderer));
    GL_SAME(t, glbk_gbuffer_free(&t->gl, &x->seen));
    GL_SAME(t, glbk_csm_lights_free(&t->gl, &x->lights));
    GL_SAME(t, glbk_csm_maps_free(&t->gl, &x->maps));
}

/* The square into the G-buffer. */
static glbk_result draw_square(gl_test *t, things *x)
{
    static const float identity[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    static const float eye[3] = { 0, 0, 3 };
    glbk_surface d;
    glbk_result r;
    memset(&d, 0, sizeof d);
    d.material.diffuse[1] = 0.5f;
    r = glbk_gbuffer_begin(&t->gl, &x->seen, identity, eye);
    if (r == GLBK_OK) r = glbk_gbuffer_object(&t->gl, &x->seen, &d);
    if (r != GLBK_OK) return r;
    t->gl.gl.BindVertexArray(world.square);
    t->gl.gl.DrawArrays(GLBK_GL_TRIANGLE_STRIP, 0, 4);
    return GLBK_OK;
}

/* One frame of the uploaded pixels, then one of the square; questions; a builder's turn. */
static glbk_result run(gl_test *t, things *x)
{
    glbk_pixel pixels[PIXELS];
    glbk_csm_use use;
    glbk_csm_frame_desc f = frame_of(x, &use);
    glbk_pass pass;
    glbk_result r = GLBK_OK;
    uint32_t row[4 * MAP], y;
    memset(&pass, 0, sizeof pass);
    pass.target = &world.screen.target;
    fill_pixels(pixels);
    glbk_csm_reset(&x->renderer);
    GL_THEN_SAME(t, r, glbk_csm_maps_place(&t->gl, &x->maps, &x->plate, 1));
    GL_THEN_SAME(t, r, glbk_gbuffer_upload(&t->gl, &x->seen, 0, SIDE, pixels));
    GL_THEN_SAVED(t, r, glbk_csm_render(&t->gl, &x->renderer, &x->seen, &f));
    GL_THEN_SAME(t, r, glbk_csm_read(&t->gl, &x->renderer, x->picture[0]));
    GL_THEN_SAVED(t, r, draw_square(t, x));
    glbk_csm_reset(&x->renderer);
    GL_THEN_SAVED(t, r, glbk_csm_render(&t->gl, &x->renderer, &x->seen, &f));
    GL_THEN_SAVED(t, r, glbk_csm_resolve(&t->gl, &x->renderer, &x->seen, &pass, NULL));
    GL_THEN_SAME(t, r, glbk_target_read(&t->gl, &world.screen.target, 0, 0, 0, SIDE, SIDE, x->drawn));
    GL_SAVED(t, glbk_csm_bind(&t->gl, &x->maps, NULL));
    GL_THEN_SAVED(t, r, glbk_csm_ask_run(&t->gl, &x->asker, &x->maps, QUESTIONS));
    GL_THEN_SAME(t, r, glbk_csm_ask_read(&t->gl, &x->asker, QUESTIONS, x->visible));
    GL_THEN_SAVED(t, r, glbk_csm_builder_draw(&t->gl, &x->builder, 0, 1));
    for (y = 0; y < MAP; y++)
        GL_THEN_SAME(t, r, glbk_target_read(&t->gl, &x->builder.layer_targets[0], 0, 0, y, MAP, 1, row));
    if (x->builder.next_view == 0) GL_THEN_SAVED(t, r, glbk_csm_builder_compress(&t->gl, &x->builder));
    GL_THEN_SAME(t, r, glbk_csm_builder_end(&t->gl, &x->builder));
    if (r == GLBK_OK) assert_true(x->builder.segment_count >= MAP * MAP);
    return r;
}

/* Objects are made anew for each error; a frame has them already, with its programs. */
static void gl_fails_in_every_call(void **state)
{
    GL_TEST(t, state)
    static things x;
    int failures[2] = { 0, 0 }, running, live;
    t->gl.check = 1;
    set_stage(t);
    for (running = 0; running < 2; running++) {
        glbk_result result = GLBK_ERR_GL;
        if (running) {
            fake_begin(t, 0x0505);
            assert_glbk(t, make(t, &x));
            assert_glbk(t, run(t, &x));
        } else fake_begin_hollow(t, 0x0505);
        live = fake.live;
        for (fake.at = 1; result != GLBK_OK; fake.at++) {
            fake.calls = 0;
            t->log[0] = 0;
            result = running ? run(t, &x) : make(t, &x);
            if (!running) destroy(t, &x);
            assert_int_equal(fake.live, live);
            assert_true(result == GLBK_OK || result == GLBK_ERR_GL_MEMORY || result == GLBK_ERR_PENDING);
            if (result != GLBK_OK) assert_true(t->log[0]);
            failures[running] += result != GLBK_OK;
            assert_true(fake.at < 300);
        }
        if (running) destroy(t, &x);
        assert_int_equal(fake.live, 0);
        t->gl.gl = fake.real;
    }
    printf("failures: %d while making, %d while running\n", failures[0], failures[1]);
    assert_true(failures[0] > 80 && failures[1] > 45);
    strike_stage(t);
}

/* Passes do not make a driver or a browser answer, and an object is a block bound and filled. */
static void a_frame_asks_nothing(void **state)
{
    GL_TEST(t, state)
    static const float one[16] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    static things x;
    glbk_surface d;
    int i;
    memset(&d, 0, sizeof d);
    set_stage(t);
    assert_glbk(t, make(t, &x));
    assert_glbk(t, run(t, &x));             /* compiles */
    gl_count_begin(&t->gl);
    assert_glbk(t, run(t, &x));
    assert_glbk(t, glbk_gbuffer_begin(&t->gl, &x.seen, one, one));
    gl_count_reset();
    for (i = 0; i < 10; i++) assert_glbk(t, glbk_gbuffer_object(&t->gl, &x.seen, &d));
    assert_int_equal(gl_counted.calls, 20);
    gl_count_end(&t->gl);
    destroy(t, &x);
    strike_stage(t);
}

static void memory_runs_out(void **state)
{
    GL_TEST(t, state)
    static things x;
    glbk_result result = GLBK_ERR_ALLOC;
    int given;
    set_stage(t);
    t->gl.system.allocator.alloc_fn = fake_alloc;
    t->gl.system.allocator.free_fn = fake_free;
    fake_begin_hollow(t, 0);
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
    strike_stage(t);
}

static void a_lost_context_is_called_no_more(void **state)
{
    GL_TEST(t, state)
    static things x, other;
    glbk_context ctx;
    float visible[QUESTIONS];
    set_stage(t);
    assert_glbk(t, make(t, &x));
    assert_glbk(t, run(t, &x));
    ctx = t->gl;
    memset(&t->gl.gl, 0, sizeof t->gl.gl);      /* from here on a call of GL would crash */
    glbk_abandon(&t->gl);
    assert_int_equal(run(t, &x), GLBK_ERR_LOST);
    assert_int_equal(make(t, &other), GLBK_ERR_LOST);
    assert_int_equal(glbk_csm_ask_read(&t->gl, &x.asker, QUESTIONS, visible), GLBK_ERR_LOST);
    assert_int_equal(glbk_csm_builder_draw(&t->gl, &x.builder, 0, 1), GLBK_ERR_LOST);
    glbk_csm_bind(&t->gl, &x.maps, NULL);
    destroy(t, &other);
    other = x;
    other.builder = (glbk_csm_builder){ 0 };    /* these own memory */
    other.maps.heads = NULL;
    destroy(t, &other);
    t->gl = ctx;
    destroy(t, &x);
    strike_stage(t);
}

static void foreign_state_changes_no_result(void **state)
{
    GL_TEST(t, state)
    static things calm, x;
    gl_hostile h;
    float dark = 1, lit = 0;
    int i;
    set_stage(t);
    gl_state_watch(t, 1);
    assert_glbk(t, make(t, &calm));
    assert_glbk(t, run(t, &calm));
    for (i = 0; i < PIXELS; i++) {
        dark = fminf(dark, calm.picture[i][0]);
        lit = fmaxf(lit, calm.picture[i][0]);
    }
    assert_true(dark == 0 && lit > 0.01f && calm.visible[0] == 1 && calm.visible[1] == 0);
    gl_hostile_make(t, &h);
    gl_hostile_set(t, &h);
    assert_glbk(t, make(t, &x));
    assert_glbk(t, run(t, &x));
    assert_memory_equal(calm.picture, x.picture, sizeof x.picture);
    assert_memory_equal(calm.drawn, x.drawn, sizeof x.drawn);
    assert_memory_equal(calm.visible, x.visible, sizeof x.visible);
    destroy(t, &x);
    destroy(t, &calm);
    gl_hostile_free(t, &h);
    strike_stage(t);
}

/* A frame's programs stay; those of frames before make room, and a frame that needs more is refused, since each of its
   programs would be compiled again in every frame. */
static void programs_of_a_frame_stay(void **state)
{
    GL_TEST(t, state)
    enum { MANY = GLBK_CSM_MAX_PROGRAMS + 1 };
    static things x;
    static glbk_csm_maps maps[2][MANY];
    static glbk_csm_use uses[MANY];
    glbk_csm_frame_desc f;
    uint32_t i, names;
    set_stage(t);
    fake_begin_hollow(t, 0);
    assert_glbk(t, make(t, &x));
    for (i = 0; i < 2 * MANY; i++) {
        maps[i / MANY][i % MANY] = x.maps;
        maps[i / MANY][i % MANY].key = i;           /* as many kinds of maps */
    }
    f = frame_of(&x, &uses[0]);
    for (i = 0; i < MANY; i++) {
        uses[i] = uses[0];
        uses[i].maps = &maps[0][i];
    }
    f.uses = uses;
    f.use_count = MANY - 1;
    assert_glbk(t, glbk_csm_prepare(&t->gl, &x.renderer, &f));
    names = fake.names;
    assert_glbk(t, glbk_csm_prepare(&t->gl, &x.renderer, &f));
    assert_int_equal(fake.names, names);            /* nothing is compiled twice */
    f.use_count = MANY;
    assert_int_equal(glbk_csm_prepare(&t->gl, &x.renderer, &f), GLBK_ERR_LIMIT);
    assert_string_equal(t->log, "glbk_csm_prepare: the number of programs that the uses of one frame need is 65; "
                                "it must be 0..64");
    f.use_count = 1;
    assert_glbk(t, glbk_csm_prepare(&t->gl, &x.renderer, &f));
    names = fake.names;
    for (i = 1; i < MANY; i++) uses[i].maps = &maps[1][i];
    f.use_count = MANY - 1;
    assert_glbk(t, glbk_csm_prepare(&t->gl, &x.renderer, &f));      /* those that this frame leaves out go */
    assert_true(fake.names >= names + MANY - 2);
    names = fake.names;
    assert_glbk(t, glbk_csm_prepare(&t->gl, &x.renderer, &f));
    assert_int_equal(fake.names, names);
    destroy(t, &x);
    assert_int_equal(fake.live, 0);
    t->gl.gl = fake.real;
    strike_stage(t);
}

/* The core path, taken where storage buffers are too small, draws whole rows of 1024 answers: behind the last question
   there is none. */
static void only_what_was_asked_is_answered(void **state)
{
    GL_TEST(t, state)
    static uint32_t row[4 * 1024];
    static things x;
    float answer;
    int i;
    set_stage(t);
    t->gl.max_storage = 64 * MAP * MAP;
    assert_glbk(t, make(t, &x));
    assert_int_equal(x.asker.asked.name != 0, t->gl.compute);
    assert_int_equal(x.builder.compute, t->gl.compute);
    destroy(t, &x);
    t->gl.max_storage = 32 * QUESTIONS - 1;
    assert_glbk(t, make(t, &x));
    assert_int_equal(x.asker.asked.name + (unsigned)x.builder.compute, 0);
    assert_int_equal(x.renderer.compute, t->gl.compute);
    assert_glbk(t, glbk_csm_ask_run(&t->gl, &x.asker, &x.maps, QUESTIONS));
    assert_glbk(t, glbk_target_read(&t->gl, &x.asker.target, 0, 0, 0, 1024, 1, row));
    for (i = 0; i < QUESTIONS; i++) {
        memcpy(&answer, row + 4 * i, 4);
        assert_true(answer == (i % 2 ? 0 : 1));
    }
    for (; i < 1024; i++) assert_int_equal(row[4 * i], 0);
    assert_glbk(t, run(t, &x));
    destroy(t, &x);
    strike_stage(t);
}

/* Instances in the uniform block are one upload into it, more are one into their table and one into the block, however
   many there are; the answers are the same. */
static void placing_is_one_upload(void **state)
{
    GL_TEST(t, state)
    enum { MANY = 40 };
    static things x;
    glbk_csm_instance many[MANY];
    glbk_csm_block block;
    uint32_t i, capacity;
    set_stage(t);
    assert_glbk(t, make(t, &x));
    block.data = cohsm_data(world.plate, &block.bytes);
    for (capacity = 16; capacity <= MANY; capacity += MANY - 16) {
        glbk_csm_maps maps;
        assert_glbk(t, glbk_csm_maps_create(&t->gl, &block, 1, capacity, &many[0].start, &maps));
        for (i = 0; i < capacity; i++) {
            many[i] = x.plate;
            many[i].start = many[0].start;
            many[i].transform[12] = i + 1 < capacity ? 100.0f + (float)i : 0.0f;    /* the last one is in the way */
        }
        gl_count_begin(&t->gl);
        assert_glbk(t, glbk_csm_maps_place(&t->gl, &maps, many, capacity));
        printf("%u instances: %d calls of GL, %d of them ask\n", capacity, gl_counted.calls, gl_counted.asks);
        assert_int_equal(gl_counted.errors, 0);
        assert_int_equal(gl_counted.uploads, capacity > 16);
        assert_int_equal(gl_counted.data, 1);
        assert_true(gl_counted.calls <= (capacity > 16 ? 36 : 4));
        gl_count_end(&t->gl);
        assert_glbk(t, glbk_csm_ask_run(&t->gl, &x.asker, &maps, QUESTIONS));
        assert_glbk(t, glbk_csm_ask_read(&t->gl, &x.asker, QUESTIONS, x.visible));
        for (i = 0; i < QUESTIONS; i++) assert_true(x.visible[i] == (i % 2 ? 0.0f : 1.0f));
        glbk_csm_maps_free(&t->gl, &maps);
    }
    destroy(t, &x);
    strike_stage(t);
}

int main(int count, char **values)
{
    struct CMUnitTest tests[] = {
        gl_unit_test(gl_fails_in_every_call), gl_unit_test(memory_runs_out), gl_unit_test(a_frame_asks_nothing),
        gl_unit_test(placing_is_one_upload), gl_unit_test(a_lost_context_is_called_no_more),
        gl_unit_test(foreign_state_changes_no_result), gl_unit_test(programs_of_a_frame_stay),
        gl_unit_test(only_what_was_asked_is_answered)
    };
    (void)count;
    GL_TEST_MAIN(values, tests, GL_CORE45 | GL_CORE33 | GL_ES30_BARE);
}
