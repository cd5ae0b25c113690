/* The example within raylib, under Xvfb, where raylib is installed: what raylib draws before and after us stands right,
   so that its state came back; our meshes are lit, and one throws its shadow onto the floor. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>

#include "program.h"

enum { W = 800, H = 500 };

static unsigned char rgba[H][W][4];

/* No package of Debian 12 has raylib: with CI=true, too, this may be missing. */
static void need(void)
{
    const char *build = getenv("BUILD");
    char text[300];
    snprintf(text, sizeof text, "command -v xvfb-run >/dev/null 2>&1 && test -x %s/12_raylib",
             build && *build ? build : "build");
    if (system(text) == 0) return;
    printf("skip: 12_raylib is not built (no raylib), or there is no xvfb-run\n");
    skip();
}

/* Under Xvfb, in the scratch folder; the exit status is 1 where GL had an error. */
static int run_example(const char *arguments)
{
    const char *build = getenv("BUILD");
    char here[512], command[1200];
    int status;
    assert_non_null(getcwd(here, sizeof here));
    snprintf(command, sizeof command,
             "cd %s && DAPPLE_GL_DEBUG=1 ASAN_OPTIONS=detect_leaks=0 xvfb-run -a %s%s%s/12_raylib %s >out 2>&1",
             folder, build && *build == '/' ? "" : here, build && *build == '/' ? "" : "/",
             build && *build ? build : "build", arguments);
    status = system(command);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

/* The pixel where a point of the world is seen by the example's camera: at 1 4 8, towards 0 1 0, 45 degrees. */
static const unsigned char *seen_at(double x, double y, double z)
{
    const double length = sqrt(1 + 9 + 64), forward[3] = { -1 / length, -3 / length, -8 / length };
    const double side = sqrt(64 + 1), right[3] = { 8 / side, 0, -1 / side };
    const double up[3] = { right[1] * forward[2] - right[2] * forward[1], right[2] * forward[0] - right[0] * forward[2],
                           right[0] * forward[1] - right[1] * forward[0] };
    const double d[3] = { x - 1, y - 4, z - 8 };
    double deep = d[0] * forward[0] + d[1] * forward[1] + d[2] * forward[2], scale = H / 2 / tan(atan(1) / 2) / deep;
    int column = (int)(W / 2 + scale * (d[0] * right[0] + d[1] * right[1] + d[2] * right[2]));
    int row = (int)(H / 2 - scale * (d[0] * up[0] + d[1] * up[1] + d[2] * up[2]));
    assert_true(column >= 0 && column < W && row >= 0 && row < H);
    return rgba[row][column];
}

static int bright(const unsigned char *pixel) { return pixel[0] + pixel[1] + pixel[2]; }

static void draws_within_a_frame_of_raylib(void **state)
{
    static const unsigned char sky[3] = { 102, 191, 255 }, bar[3] = { 0, 82, 172 };
    const unsigned char *lit, *dark, *ball;
    char path[64];
    FILE *file;
    (void)state;
    need();
    assert_int_equal(run_example("--lights 40 --frames 2 --screenshot shot.raw"), 0);
    snprintf(path, sizeof path, "%s/shot.raw", folder);
    file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fread(rgba, 1, sizeof rgba, file), sizeof rgba);
    fclose(file);
    assert_memory_equal(rgba[5][5], sky, 3);                /* what raylib cleared */
    assert_memory_equal(rgba[H - 5][W - 5], bar, 3);        /* 2D after us */
    lit = seen_at(4.5, -0.01, 1.5);
    dark = seen_at(1.97, -0.01, 0.6);                     /* where the ball's shadow lies, away from the sun */
    ball = seen_at(2.7, 1.0, 1.6);
    assert_true(lit[2] > 100 && abs(lit[2] - lit[0]) < 60); /* grey, not the sky's blue */
    if (!(bright(dark) < 0.8 * bright(lit))) fail_msg("shadow %d, light %d", bright(dark), bright(lit));
    assert_true(ball[2] > ball[0] + 20 && ball[2] > 80);    /* a blue one */
}

static void refuses_what_it_does_not_know(void **state)
{
    (void)state;
    need();
    assert_int_equal(run_example("--lights 0"), 2);
    assert_int_equal(run_example("--frames -1"), 2);
    assert_int_equal(run_example("--frames"), 2);
    assert_int_equal(run_example("--frames 1 --mesh nothing.obj"), 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(draws_within_a_frame_of_raylib),
                                        cmocka_unit_test(refuses_what_it_does_not_know) };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
