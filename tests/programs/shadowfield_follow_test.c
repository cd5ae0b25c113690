/* shadowfield_follow_test - the technique shadowfield of render where lights change between frames in ways that no
   scene of the command line has: brighter, turned, larger, of another shape, suns and skies; and a receiver that
   shines. What it follows is what it shows when it is opened then. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "../../examples/render/setup.h"

enum { WIDTH = 40, HEIGHT = 24, PIXELS = WIDTH * HEIGHT };

typedef struct stage {
    rd_args     args;
    rd_job      job;
    ex_scene    scene;
    ex_gbuffer  gbuffer;
    rd_emitter *emitters;
    void       *state;
    char        error[EX_ERROR_SIZE];
} stage;

#define OK(s, call) do { if ((call) != 0) fail_msg("%s: %s", #call, (s)->error); } while (0)

/* As main.c of render, up to the technique. */
static void open_stage(stage *s, int count, char **values)
{
    memset(s, 0, sizeof *s);
    OK(s, rd_args_parse(&s->args, count, values, s->error));
    OK(s, rd_setup(&s->scene, &s->job, &s->emitters, &s->args, 0, s->error));
    OK(s, ex_gbuffer_render(&s->gbuffer, &s->scene, WIDTH, HEIGHT, 1, 1, s->error));
    s->job.scene = &s->scene;
    s->job.gbuffer = &s->gbuffer;
    s->job.settings = &s->args.settings;
    s->job.aa = s->job.frames = 1;
    s->job.pool = ex_pool_create(2);
    assert_non_null(s->job.pool);
    s->job.threads = ex_pool_threads(s->job.pool);
}

static void close_stage(stage *s)
{
    rd_shadowfield.close(s->state);
    ex_pool_free(s->job.pool);
    ex_gbuffer_free(&s->gbuffer);
    ex_scene_free(&s->scene);
    free(s->emitters);
    rd_args_free(&s->args);
}

static void shade(stage *s, ex_image *out)
{
    assert_int_equal(ex_image_alloc(out, WIDTH, HEIGHT), 0);
    memset(out->rgb, 0, 3 * PIXELS * sizeof *out->rgb);
    OK(s, rd_shadowfield.frame(s->state, &s->job, out, s->error));
}

static void follow(stage *s, ex_image *out)
{
    OK(s, rd_shadowfield.update(s->state, &s->job, s->error));
    shade(s, out);
}

/* Closed and opened with all as it is now. */
static void anew(stage *s, ex_image *out)
{
    rd_shadowfield.close(s->state);
    s->state = NULL;
    OK(s, rd_shadowfield.open(&s->state, &s->job, s->error));
    shade(s, out);
}

/* RMSE by the mean of b. */
static double difference(const ex_image *a, const ex_image *b)
{
    double square = 0, sum = 0;
    int i;
    for (i = 0; i < 3 * PIXELS; i++) {
        square += pow((double)a->rgb[i] - (double)b->rgb[i], 2);
        sum += (double)b->rgb[i];
    }
    return sqrt(square / (3 * PIXELS)) / (sum / (3 * PIXELS));
}

/* An even number of positions: none in the plane of a rectangle, where rounding says on which side they are. */
#define SMALL "--set", "position_side=4", "--set", "shell_count=5", "--set", "point_spacing=0.2"

/* After each change the picture that follows against the one that is opened anew, and against the one before. */
static void follows(stage *s, ex_image *before, const char *what, double bound)
{
    ex_image now, opened;
    double moved;
    follow(s, &now);
    anew(s, &opened);
    moved = difference(before, &opened);
    printf("%s: off the one opened then by %.1e, off the one before by %.2g\n", what, difference(&now, &opened), moved);
    assert_true(difference(&now, &opened) <= bound);
    assert_true(moved > 0.05 && moved > 5 * bound);
    ex_image_free(&now);
    ex_image_free(before);
    *before = opened;
}

static void turn_rect(ex_light *l, float angle, float scale)
{
    float *edges[2], c = cosf(angle), sn = sinf(angle);
    int i;
    edges[0] = l->u;
    edges[1] = l->v;
    for (i = 0; i < 2; i++) {
        float x = edges[i][0], y = edges[i][1];
        edges[i][0] = scale * (c * x - sn * y);
        edges[i][1] = scale * (sn * x + c * y);
        edges[i][2] *= scale;
    }
}

static void lights_that_change_are_followed(void **state)
{
    char *values[] = { "render", "--technique", "shadowfield", "--scene", "builtin:knot", "--out", "a.pfm", "--light",
                       "rect:-1,4,-1,2,0,0,0,0,2,20", "--light", "sphere:3,3,0,0.3,20", "--light", "sun:1,2,0,1",
                       "--light", "spot:0,5,3,0,-0.86,-0.5,50,80", "--env", "builtin:overcast",
                       "--set", "ground=1", SMALL };
    ex_image picture;
    stage s;
    ex_light *l;
    (void)state;
    open_stage(&s, sizeof values / sizeof values[0], values);
    assert_int_equal(s.scene.light_count, 4);
    l = s.scene.lights;
    OK(&s, rd_shadowfield.open(&s.state, &s.job, s.error));
    shade(&s, &picture);
    l[0].value[0] = 60;
    l[0].value[1] = 0;
    l[1].value[2] = 90;
    l[3].value[1] = 300;
    follows(&s, &picture, "brightness", 1e-6);
    l[1].radius = 0.6f;
    l[0].position[1] = 3;
    follows(&s, &picture, "size and place", 1e-6);
    turn_rect(&l[0], -1.5707963f, 1.5f);        /* brings samples of its field onto others */
    l[0].position[0] = 2;
    follows(&s, &picture, "a rectangle turned and enlarged", 5e-3);     /* 8 bits */
    l[0].u[0] *= 0.2f, l[0].u[1] *= 0.2f, l[0].u[2] *= 0.2f;
    l[3].cos_half_angle = 0.98f;
    follows(&s, &picture, "shapes", 1e-6);
    l[2].direction[0] = -0.8f, l[2].direction[1] = 0.6f;
    l[2].value[0] = 6;
    follows(&s, &picture, "a sun", 1e-6);
    ex_image_free(&picture);
    close_stage(&s);
}

/* The deck shines, on robots alone: its own pixels are what they were. */
static void a_receiver_that_shines_lights_others_alone(void **state)
{
    char *values[] = { "render", "--technique", "shadowfield", "--scene", "builtin:robots", "--out", "a.pfm", SMALL };
    ex_image dull, lit;
    double worst = 0, deck = 0, robots = 0, before = 0;
    uint32_t i, k, object = UINT32_MAX;
    stage s;
    (void)state;
    open_stage(&s, sizeof values / sizeof values[0], values);
    OK(&s, rd_shadowfield.open(&s.state, &s.job, s.error));
    shade(&s, &dull);
    for (i = 0; i < s.scene.object_count; i++)
        if (strcmp(s.scene.objects[i].name, "deck") == 0) object = i;
    assert_true(object != UINT32_MAX && s.scene.objects[object].receiver_only);
    i = ex_object_material(&s.scene, &s.scene.objects[object], 0);
    for (k = 0; k < 3; k++) s.scene.materials[i].emission[k] = 5;
    free(s.emitters);
    assert_int_equal(rd_emitters_build(&s.scene, &s.emitters, &s.job.emitter_count), 0);
    s.job.emitters = s.emitters;
    follow(&s, &lit);
    for (i = 0; i < PIXELS; i++) {
        const ex_pixel *p = &s.gbuffer.pixels[i];
        for (k = 0; k < 3 && p->object != UINT32_MAX; k++) {
            double x = (double)dull.rgb[3 * i + k], y = (double)lit.rgb[3 * i + k];
            if (p->object == object) {
                worst = fmax(worst, fabs(x - y));
                deck = fmax(deck, x);
            } else {
                before += x;
                robots += y;
            }
        }
    }
    printf("a deck that shines: its pixels change by %.1e of %.2g, others from %.3g to %.3g\n", worst, deck, before,
           robots);
    assert_true(deck > 0.05 && worst <= 1e-5 * deck);
    assert_true(robots > 2 * before);
    ex_image_free(&dull);
    ex_image_free(&lit);
    close_stage(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(lights_that_change_are_followed),
                                        cmocka_unit_test(a_receiver_that_shines_lights_others_alone) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
