/* The example with all five techniques, headless, one small picture: each has run, what is seen stands right. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "common.h"

enum { W = 96, H = 54 };

static const char *build_folder(void)
{
    const char *build = getenv("BUILD");
    return build && *build ? build : "build";
}

static void need(void)
{
    const char *ci = getenv("CI");
    char path[300];
    snprintf(path, sizeof path, "%s/05_all_in_a_renderer", build_folder());
    if (access(path, X_OK) == 0) return;
    printf("skip: no OpenGL\n");
    assert_false(ci && strcmp(ci, "true") == 0);
    skip();
}

/* Mean of 5 x 5 pixels, x and y in shares of the picture. */
static void mean_at(const ex_image *image, float x, float y, double *rgb)
{
    uint32_t left = (uint32_t)(x * W) - 2, top = (uint32_t)(y * H) - 2;
    memset(rgb, 0, 3 * sizeof *rgb);
    for (uint32_t i = 0; i < 25; i++)
        for (uint32_t k = 0; k < 3; k++) rgb[k] += (double)image->rgb[3 * ((top + i / 5) * W + left + i % 5) + k] / 25;
}

static void run(const char *arguments, const char *picture, char *said, size_t size, ex_image *image)
{
    char command[600], error[EX_ERROR_SIZE];
    FILE *pipe;
    size_t got;
    snprintf(command, sizeof command, "ASAN_OPTIONS=detect_leaks=0 DAPPLE_GL_DEBUG=1 %s/05_all_in_a_renderer "
             "--headless %s --size %dx%d --bands 3 %s", build_folder(), picture, W, H, arguments);
    pipe = popen(command, "r");
    assert_non_null(pipe);
    got = fread(said, 1, size - 1, pipe);
    said[got] = 0;
    assert_int_equal(pclose(pipe), 0);
    assert_int_equal(ex_image_read_pfm(image, picture, error), 0);
    assert_true(image->width == W && image->height == H);
    for (size_t i = 0; i < 3 * (size_t)W * H; i++) assert_true(isfinite(image->rgb[i]) && image->rgb[i] >= 0);
}

static void draws_what_it_should(void **state)
{
    static const char *const names[] = { "csm", "shadowfield", "envshadow", "rsm", "ism", "direct" };
    char folder[] = "/tmp/dapple-all-XXXXXX", picture[64], said[1000];
    double left[3], right[3], floor_lit[3], floor_dark[3], under_lamp[3], ceiling[3];
    int slow = strstr(build_folder(), "sanitize") != NULL;      /* the shaders of one technique are enough then */
    ex_image image;
    (void)state;
    need();
    assert_non_null(mkdtemp(folder));
    snprintf(picture, sizeof picture, "%s/all.pfm", folder);
    run(slow ? "--only csm" : "", picture, said, sizeof said, &image);
    unlink(picture);
    rmdir(folder);
    for (int i = 0; i < (slow ? 1 : 6); i++) {
        const char *at = strstr(said, names[i]);
        assert_true(at && strtod(at + strlen(names[i]), NULL) > 0);
    }
    mean_at(&image, 0.10f, 0.5f, left);
    mean_at(&image, 0.92f, 0.6f, right);
    mean_at(&image, 0.60f, 0.93f, floor_lit);
    mean_at(&image, 0.78f, 0.84f, floor_dark);
    mean_at(&image, 0.53f, 0.05f, under_lamp);
    mean_at(&image, 0.35f, 0.19f, ceiling);
    assert_true(left[0] > 2 * left[2] && left[0] > 0.05);       /* red wall, blue wall */
    assert_true(right[2] > 2 * right[0] && right[2] > 0.02);
    assert_true(under_lamp[0] > 3 * ceiling[0]);
    assert_true(floor_dark[0] < 0.8 * floor_lit[0]);            /* in the shadow of the block */
    ex_image_free(&image);
}

static void refuses_what_it_does_not_know(void **state)
{
    static const char *const bad[] = { "--size 0x10", "--only nothing", "--step 9", "--colour red", "--headless" };
    char command[300];
    (void)state;
    need();
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        snprintf(command, sizeof command, "%s/05_all_in_a_renderer %s 2>/dev/null", build_folder(), bad[i]);
        assert_int_equal(WEXITSTATUS(system(command)), 2);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(refuses_what_it_does_not_know),
        cmocka_unit_test(draws_what_it_should),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
