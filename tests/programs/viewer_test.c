/* The program viewer and the minimal GL example under Xvfb: keys are pressed from outside (xdotool), screenshots are
   compared with one another and with what render writes for the same scene, technique and seeds. */
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

#if DAPPLE_HAVE_X11
#include <X11/Xlib.h>
enum { HAS_X11 = 1 };
#else
enum { HAS_X11 = 0 };
#endif

#if DAPPLE_HAVE_STB
#include <stb/stb_image.h>
#endif

static const char *self;       /* this program, which drops files when the script calls it */
static char folder[] = "/tmp/dapple-viewer-XXXXXX";

static const char *build_folder(void)
{
    const char *build = getenv("BUILD");
    return build && *build ? build : "build";
}

/* The programs that the script needs; with CI=true none may be missing. */
static void need(void)
{
    static const char *const tools[] = { "xvfb-run", "xdotool" };
    const char *ci = getenv("CI");
    char text[300];
    size_t i;
    for (i = 0; i < 3; i++) {
        if (i < 2) snprintf(text, sizeof text, "command -v %s >/dev/null 2>&1", tools[i]);
        else snprintf(text, sizeof text, "test -x %s/viewer -a -x %s/render", build_folder(), build_folder());
        if (system(text) == 0) continue;
        printf("skip: %s\n", i < 2 ? tools[i] : "the viewer is not built (no GLFW)");
        assert_false(ci && strcmp(ci, "true") == 0);
        skip();
    }
}

static void write_script(const char *name, const char *body)
{
    char path[256];
    FILE *f;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    f = fopen(path, "w");
    assert_non_null(f);
    assert_true(fputs(body, f) >= 0 && fclose(f) == 0);
}

/* Runs the script with the viewer's path, in the scratch folder. Each of its commands must succeed. */
static void run_viewer(const char *arguments, const char *keys)
{
    static char body[4000];
    char command[1200], here[512];
    int status;
    snprintf(body, sizeof body,
             "set -e\n"
             "export DAPPLE_GL_DEBUG=1\n"               /* GL errors are exit statuses */
             "export ASAN_OPTIONS=detect_leaks=0\n"     /* X and Mesa keep what they had at the end */
             "cd %s && rm -f viewer-* out\n"
             "$VIEWER %s > out 2>&1 &\n"
             "viewer=$!\n"
             "trap 'kill $viewer 2>/dev/null || true' EXIT\n"
             "window=$(timeout 60 xdotool search --sync --onlyvisible --name Dapple | head -n 1)\n"
             "xdotool windowfocus --sync $window\n"
             "key() { xdotool key \"$@\"; }\n"
             /* S or F, and until the line about it stands in out */
             "lines() { wc -l < out; }\n"
             "shot() { n=$(lines); key $1; i=0\n"
             "while [ $(lines) = $n ] && [ $i -lt 600 ]; do sleep 0.1; i=$((i+1)); done; }\n"
             "%s\n"
             "key q\n"
             "wait $viewer\n"
             "trap - EXIT\n",
             folder, arguments, keys);
    write_script("script", body);
    assert_non_null(getcwd(here, sizeof here));
    snprintf(command, sizeof command,
             "SELF='%s' VIEWER=%s%s%s/viewer "
             "timeout 240 xvfb-run -a -s '-screen 0 800x600x24' sh -e %s/script > %s/log 2>&1",
             self, build_folder()[0] == '/' ? "" : here, build_folder()[0] == '/' ? "" : "/", build_folder(),
             folder, folder);
    status = system(command);
    if (status != 0) {
        snprintf(command, sizeof command, "cat %s/log %s/out", folder, folder);
        (void)(system(command) + 1);
    }
    assert_int_equal(status, 0);
}

static size_t read_file(const char *name, unsigned char *to, size_t room)
{
    char path[256];
    size_t size;
    FILE *f;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    f = fopen(path, "rb");
    if (!f) fail_msg("no %s", path);
    size = fread(to, 1, room, f);
    fclose(f);
    return size;
}

static int same_file(const char *a, const char *b)
{
    static unsigned char data[2][1 << 20];
    size_t n[2];
    n[0] = read_file(a, data[0], sizeof data[0]);
    n[1] = read_file(b, data[1], sizeof data[1]);
    assert_true(n[0] > 500 && n[1] > 500);
    return n[0] == n[1] && memcmp(data[0], data[1], n[0]) == 0;
}

static void keys_change_what_is_shown(void **state)
{
    (void)state;
    need();
    run_viewer("--size 320x240 builtin:knot",
               "shot s\nkey h\nshot s\nkey h\nshot s\n"                /* 1, 2, 3: help on and off */
               "key p\nshot s\n"                                       /* 4: without the panel */
               "xdotool mousemove --window $window 100 100\n"
               "xdotool mousedown 1 mousemove_relative 40 10 mousemove_relative 40 10 mouseup 1\n"
               "sleep 1\nshot s\n"                                     /* 5: turned */
               "key r\nsleep 1\nshot s\n"                              /* 6: as 4 again */
               "key Down\nkey Right\nsleep 1\nshot s\n");              /* 7: the next scene */
    assert_false(same_file("viewer-001.png", "viewer-002.png"));
    assert_false(same_file("viewer-002.png", "viewer-004.png"));
    assert_false(same_file("viewer-004.png", "viewer-005.png"));
    assert_true(same_file("viewer-004.png", "viewer-006.png"));
    assert_false(same_file("viewer-006.png", "viewer-007.png"));
}

/* Mean of the squared difference over the mean of b, both squared. */
static double relative_rmse(const char *a, const char *b)
{
    char path[256], error[EX_ERROR_SIZE] = "";
    ex_image x, y;
    double sum = 0, squares = 0;
    size_t i, n;
    snprintf(path, sizeof path, "%s/%s", folder, a);
    if (ex_image_read_pfm(&x, path, error) != 0) fail_msg("%s", error);
    snprintf(path, sizeof path, "%s/%s", folder, b);
    if (ex_image_read_pfm(&y, path, error) != 0) fail_msg("%s", error);
    assert_int_equal(x.width, y.width);
    assert_int_equal(x.height, y.height);
    n = 3 * (size_t)x.width * x.height;
    for (i = 0; i < n; i++) {
        double d = (double)x.rgb[i] - (double)y.rgb[i];
        squares += d * d;
        sum += (double)y.rgb[i];
    }
    ex_image_free(&x);
    ex_image_free(&y);
    assert_true(sum > 0);
    return sqrt(squares / (double)n) / (sum / (double)n);
}

/* Time passes while it plays and stands while it does not, in the preview and in a technique. */
static void space_plays_and_pauses(void **state)
{
    (void)state;
    need();
    run_viewer("--size 160x120 builtin:knot",
               "key p\nshot s\n"                                       /* 1 */
               "key space\nsleep 1\nkey space\nsleep 1\nshot s\n"     /* 2: another time */
               "sleep 1\nshot s\n"                                     /* 3: the same */
               "key t\ni=0\n"
               "while ! grep -q 'pfm, ' out && [ $i -lt 100 ]; do sleep 0.3; shot f; i=$((i+1)); done\n"       /* 4 */
               "key space\nsleep 3\nkey space\nsleep 1\nshot f\n");    /* 5: another time */
    assert_false(same_file("viewer-001.png", "viewer-002.png"));
    assert_true(same_file("viewer-002.png", "viewer-003.png"));
    assert_true(relative_rmse("viewer-004.pfm", "viewer-005.pfm") > 0.02);
}

/* A glTF file's animation: the preview gets the vertices of each time. */
static void a_file_that_walks_plays_and_pauses(void **state)
{
    char text[4000];
    (void)state;
    need();
    run_viewer("--size 160x120 $(dirname $VIEWER)/walker.glb",
               "key p\nshot s\n"                                       /* 1 */
               "key space\nsleep 1\nkey space\nsleep 1\nshot s\n"     /* 2: another time */
               "sleep 1\nshot s\n");                                   /* 3: the same */
    text[read_file("out", (unsigned char *)text, sizeof text - 1)] = 0;
    if (strstr(text, "libtinygltf-dev")) skip();
    assert_false(same_file("viewer-001.png", "viewer-002.png"));
    assert_true(same_file("viewer-002.png", "viewer-003.png"));
}

/* Frame i of the viewer has the samples of frame i of render, so that the means of a static scene agree but for
 * rounding. */
static void shows_what_render_writes(void **state)
{
    char text[4000], command[600];
    char *line;
    unsigned frames = 0;
    (void)state;
    need();
    run_viewer("--size 160x120 builtin:uroom", "key t\ni=0\n"
               "while ! grep -q 'pfm, ' out && [ $i -lt 100 ]; do sleep 0.3; shot f; i=$((i+1)); done\n"
               "shot s\nkey p\nshot s\n");
    text[read_file("out", (unsigned char *)text, sizeof text - 1)] = 0;
    line = strstr(text, "viewer-001.pfm");
    if (!line || sscanf(line, "viewer-001.pfm, %u frames", &frames) != 1 || frames == 0) fail_msg("out: %s", text);
    snprintf(command, sizeof command,
             "%s/render --technique csm --scene builtin:uroom --size 160x120 --samples 16 --frames %u --set side=64 "
             "--set map_side=64 --set order=hilbert --out %s/render.pfm",
             build_folder(), frames, folder);
    assert_int_equal(system(command), 0);
    assert_true(relative_rmse("viewer-001.pfm", "render.pfm") < 1e-3);
    assert_false(same_file("viewer-002.png", "viewer-003.png"));
}

/* Where a line stands that is white from top to bottom: its left column, or -1. */
static int white_line(const char *name)
{
    int at = -1;
#if DAPPLE_HAVE_STB
    char path[256];
    int width, height, x, y, channels;
    unsigned char *rgb;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    rgb = stbi_load(path, &width, &height, &channels, 3);
    assert_non_null(rgb);
    for (x = width - 1; x >= 0; x--) {
        for (y = 0; y < height && rgb[3 * (y * width + x)] >= 254 && rgb[3 * (y * width + x) + 2] >= 254;) y++;
        if (y == height) at = x;
    }
    stbi_image_free(rgb);
#else
    (void)name;
#endif
    return at;
}

/* What a line of out says of a screenshot beside the path tracer. */
typedef struct beside { char name[16]; double rmse, mean; unsigned paths; } beside;

static int read_beside(const char *text, beside *all, int most)
{
    int count = 0;
    unsigned frames;
    for (; text && count < most; text = strchr(text, '\n'), text += text != NULL)
        count += sscanf(text, "%15[^,], %u frames, relative rmse %lf, mean %lf of %u paths", all[count].name, &frames,
                        &all[count].rmse, &all[count].mean, &all[count].paths) == 5;
    return count;
}

/* The technique lies left of the line, which the mouse drags, and the path tracer of its light right of it; the more
   paths, the nearer, and the mean is the same. */
static void reference_is_beside_the_line(void **state)
{
    char text[4000];
    beside all[40], *first = all, *last;
    int count;
    (void)state;
    need();
    if (!DAPPLE_EMBREE || !DAPPLE_HAVE_STB) {
        printf("skip: needs Embree and stb\n");
        skip();
    }
    run_viewer("--size 160x120 builtin:cornell", "key p\nkey t\nkey c\ni=0\n"
               "while ! grep -q ' paths' out && [ $i -lt 100 ]; do sleep 0.3; shot s; i=$((i+1)); done\n"
               "sleep 3\nshot s\n"
               "xdotool mousemove --window $window 120 60\n"
               "xdotool mousedown 1 mousemove_relative -- -40 0 mousemove_relative -- -40 0 mouseup 1\n"
               "sleep 0.5\nshot s\n");
    text[read_file("out", (unsigned char *)text, sizeof text - 1)] = 0;
    count = read_beside(text, all, 40);
    if (count < 3) fail_msg("out: %s", text);
    last = &all[count - 1];
    assert_in_range(white_line(all[count - 2].name), 118, 120);
    assert_in_range(white_line(last->name), 38, 40);
    if (!(fabs(last->mean - 1) < 0.03) || !(last->rmse < first->rmse) || !(last->paths > first->paths))
        fail_msg("first rmse %.4f of %u paths, last %.4f of %u, mean %.4f", first->rmse, first->paths, last->rmse,
                 last->paths, last->mean);
}

/* The floor is lit far away and dark under the torus on the side that the light does not come from. */
static void minimal_example_draws(void **state)
{
    enum { W = 640, H = 400, HEAD = 15 };
    static unsigned char picture[HEAD + 3 * W * H + 1];
    char command[600];
    const unsigned char *lit = picture + HEAD + 3 * (50 * W + 320), *dark = picture + HEAD + 3 * (290 * W + 195);
    const unsigned char *torus = picture + HEAD + 3 * (240 * W + 320);
    (void)state;
    need();
    snprintf(command, sizeof command,
             "ASAN_OPTIONS=detect_leaks=0 timeout 240 xvfb-run -a %s/06_csm_gl_minimal %s/minimal.ppm", build_folder(),
             folder);
    assert_int_equal(system(command), 0);
    assert_int_equal(read_file("minimal.ppm", picture, sizeof picture), HEAD + 3 * W * H);
    assert_in_range(lit[0], 200, 250);
    assert_true(lit[0] == lit[1] && dark[0] == dark[1]);        /* the floor is grey */
    assert_in_range(dark[0], 60, 170);
    assert_true(torus[0] > torus[2] + 20);
}

/* Where two strands of the knot pass each other, they shade each other. The GPU answers as the CPU does but for what
   rounding takes to the pixel beside: fewer than one question in a thousand. */
static void occlusion_example_answers_as_the_cpu(void **state)
{
    enum { W = 480, H = 400, HEAD = 15 };
    static unsigned char picture[HEAD + 3 * W * H + 1];
    const unsigned char *open = picture + HEAD + 3 * (300 * W + 130), *dark = picture + HEAD + 3 * (230 * W + 215);
    const unsigned char *sky = picture + HEAD + 3 * (20 * W + 20);
    char command[600], said[300] = "", *counts;
    unsigned questions = 0, differ = 1;
    float mean = 0, low = 0;
    (void)state;
    need();
    snprintf(command, sizeof command,
             "ASAN_OPTIONS=detect_leaks=0 timeout 240 xvfb-run -a %s/06c_csm_gl_build %s/occlusion.ppm > %s/said",
             build_folder(), folder, folder);
    assert_int_equal(system(command), 0);
    assert_int_equal(read_file("occlusion.ppm", picture, sizeof picture), HEAD + 3 * W * H);
    assert_in_range(read_file("said", (unsigned char *)said, sizeof said - 1), 100, sizeof said - 1);
    assert_ptr_equal(strstr(said, "1024 maps in "), said);
    counts = strchr(said, '\n');
    assert_non_null(counts);
    assert_int_equal(sscanf(counts, " %u questions, %u answers differ from the CPU's; vertices see %f of the sky, at "
                            "least %f", &questions, &differ, &mean, &low), 4);
    assert_int_equal(questions, 256 * 24 * 64);
    assert_true(differ < questions / 1000);
    assert_true(mean > 0.72f && mean < 0.76f && low > 0.25f && low < 0.45f);
    assert_true(open[0] > dark[0] + 40 && dark[0] > dark[2] + 20);
    assert_in_range(sky[2], 240, 244);
}

/* No light goes up: what is seen on the ceiling came by way of the red wall and the floor. */
static void bounced_light_example_draws(void **state)
{
    enum { W = 640, H = 480, HEAD = 15 };
    static unsigned char picture[HEAD + 3 * W * H + 1];
    char command[600];
    const unsigned char *spot = picture + HEAD + 3 * (300 * W + 180), *ceiling = picture + HEAD + 3 * (80 * W + 250);
    (void)state;
    need();
    snprintf(command, sizeof command,
             "ASAN_OPTIONS=detect_leaks=0 timeout 240 xvfb-run -a %s/07_rsm_gl_minimal %s/rsm.ppm", build_folder(),
             folder);
    assert_int_equal(system(command), 0);
    assert_int_equal(read_file("rsm.ppm", picture, sizeof picture), HEAD + 3 * W * H);
    assert_true(spot[0] > 150 && spot[0] > spot[2] + 50);       /* direct light on the red wall */
    assert_in_range(ceiling[0], 40, 200);                       /* which colours the white ceiling */
    assert_true(ceiling[0] > ceiling[2] + 10);
}

/* A picture of an example, RGB, rows from the top; `more` are arguments behind its name. */
static const unsigned char *example_picture_with(const char *name, const char *more, size_t width, size_t height)
{
    static unsigned char picture[15 + 3 * 640 * 480 + 1];
    char command[600];
    need();
    snprintf(command, sizeof command, "ASAN_OPTIONS=detect_leaks=0 timeout 240 xvfb-run -a %s/%s %s/own.ppm %s",
             build_folder(), name, folder, more);
    assert_int_equal(system(command), 0);
    assert_int_equal(read_file("own.ppm", picture, sizeof picture), 15 + 3 * width * height);
    return picture + 15;
}

static const unsigned char *example_picture(const char *name, size_t width, size_t height)
{
    return example_picture_with(name, "", width, height);
}

/* Draws a second picture and compares it with a first one of 640 x 480, byte by byte. */
static void draws_the_same(const char *first, const char *second, const char *more, int most, double mean)
{
    enum { BYTES = 3 * 640 * 480 };
    static unsigned char drawn[BYTES];
    const unsigned char *p = example_picture(first, 640, 480);
    double sum = 0;
    size_t i;
    int worst = 0;
    memcpy(drawn, p, BYTES);
    p = example_picture_with(second, more, 640, 480);
    for (i = 0; i < BYTES; i++) {
        const int off = abs((int)p[i] - (int)drawn[i]);
        worst = off > worst ? off : worst;
        sum += off;
    }
    printf("%s %s: off by %.3f in the mean, %d at most\n", second, more, sum / BYTES, worst);
    assert_true(worst <= most);
    assert_true(sum / BYTES < mean);
}

/* A map that another renderer drew, in colours and normals of 8 bits, gives the picture of the library's own. */
static void own_map_example_draws_the_same(void **state)
{
    (void)state;
    draws_the_same("07_rsm_gl_minimal", "07b_rsm_own_maps_gl_minimal", "", 12, 0.2);
}

/* A ray through the plate, in GLSL of the example, shadows as the maps do; without the plate's shadow the floor under
   it is 40 and more brighter (shadowed_bounce_example_draws). */
static void own_visibility_draws_the_shadows_of_the_maps(void **state)
{
    (void)state;
    draws_the_same("10b_rsm_ism_gl_minimal", "10b_rsm_ism_gl_minimal", "exact", 20, 0.2);
}

/* Shadows of the sun are blue, since the sky still lights them. */
static void sky_example_draws(void **state)
{
    const unsigned char *p = example_picture("08_envshadow_gl_minimal", 640, 400);
    const unsigned char *lit = p + 3 * (380 * 640 + 600), *dark = p + 3 * (250 * 640 + 150);
    const unsigned char *torus = p + 3 * (230 * 640 + 230);
    (void)state;
    assert_in_range(lit[0], 180, 255);
    assert_true(dark[0] + 30 < lit[0] && dark[2] > dark[0] + 10);
    assert_true(torus[0] > torus[2] + 10);
}

static void fields_example_draws(void **state)
{
    const unsigned char *p = example_picture("09_shadowfield_gl_minimal", 640, 400);
    const unsigned char *lit = p + 3 * (380 * 640 + 620), *dark = p + 3 * (375 * 640 + 390);
    const unsigned char *torus = p + 3 * (230 * 640 + 300);
    (void)state;
    assert_in_range(lit[0], 200, 255);
    assert_true(dark[0] + 40 < lit[0] && dark[0] > 20);
    assert_true(torus[0] > torus[2] + 10);
}

/* Behind a board none of the lamp is seen, a few pixels beside all of it: wavelets have edges of shadows. Without any
   light but the constant of the example's shader the floor has 57. */
static void wavelets_example_draws(void **state)
{
    const unsigned char *row = example_picture("09c_wavelets_gl_minimal", 192, 120) + 3 * (75 * 192);
    (void)state;
    assert_in_range(row[3 * 24], 55, 64);
    assert_in_range(row[3 * 72], 120, 140);
    assert_true(row[3 * 8] > row[3 * 24] + 20 && row[3 * 40] > row[3 * 24] + 30);
}

/* The bowl's rim and its outside throw shadows into it and onto the floor. */
static void own_shadow_example_draws(void **state)
{
    const unsigned char *p = example_picture("09b_shadowfield_gl_passes", 640, 400);
    const unsigned char *lit = p + 3 * (150 * 640 + 270), *dark = p + 3 * (140 * 640 + 400);
    const unsigned char *ground = p + 3 * (270 * 640 + 500), *shadow = p + 3 * (235 * 640 + 260);
    (void)state;
    assert_in_range(lit[0], 120, 200);
    assert_true(dark[0] + 80 < lit[0]);
    assert_in_range(ground[0], 180, 255);
    assert_true(shadow[0] + 100 < ground[0]);
    assert_true(lit[0] > lit[2] + 20);
}

/* The red floor lights the ceiling, gets none of its own light, and the block is darker towards it than the ceiling. */
static void vpls_example_draws(void **state)
{
    const unsigned char *p = example_picture("10_ism_gl_minimal", 480, 300);
    const unsigned char *ceiling = p + 3 * (60 * 480 + 240), *ground = p + 3 * (260 * 480 + 240);
    (void)state;
    assert_true(ceiling[0] > 150 && ceiling[0] > ceiling[2] + 5);
    assert_true(ground[0] < 10);
}

/* The red wall lights floor and ceiling, and the plate shadows the floor. The wall does not light itself, but is lit
   red by what it lights, the second bounce. */
static void shadowed_bounce_example_draws(void **state)
{
    const unsigned char *p = example_picture("10b_rsm_ism_gl_minimal", 640, 480);
    const unsigned char *ceiling = p + 3 * (80 * 640 + 220), *ground = p + 3 * (395 * 640 + 230);
    const unsigned char *shadow = p + 3 * (382 * 640 + 420), *spot = p + 3 * (190 * 640 + 170);
    const unsigned char *wall = p + 3 * (300 * 640 + 160);
    (void)state;
    assert_true(spot[0] > 200 && spot[0] > spot[2] + 60);
    assert_true(ceiling[0] > 150 && ceiling[0] > ceiling[2] + 60);
    assert_in_range(ground[0], 90, 160);
    assert_true(shadow[0] + 40 < ground[0]);
    assert_in_range(wall[0], 40, 110);
    assert_true(wall[1] < 30);
}

/* Through the screen's holes light falls on the green wall and, past the column, on the back; the column leans to the
   left over what would be lit wall. */
static void own_vertices_example_draws(void **state)
{
    const unsigned char *p = example_picture("10c_own_vertices_gl_minimal", 640, 480);
    const unsigned char *hole = p + 3 * (225 * 640 + 448), *between = p + 3 * (240 * 640 + 456);
    const unsigned char *behind = p + 3 * (220 * 640 + 385), *column = p + 3 * (245 * 640 + 335);
    (void)state;
    assert_true(hole[1] > 150 && hole[1] > hole[0] + 60);
    assert_true(between[1] < 110);
    assert_true(behind[0] > 190);
    assert_true(column[1] < 110 && 4 * column[2] < 3 * column[1]);
}

/* The block's side away from the sun: the sky alone would make it blue, the sun's light from the red wall makes it red.
   Its shadow on the ground is the sky's work. */
static void sky_and_bounce_example_draws(void **state)
{
    const unsigned char *p = example_picture("11_sky_bounce_gl_minimal", 640, 400);
    const unsigned char *side = p + 3 * (240 * 640 + 217), *shadow = p + 3 * (265 * 640 + 185);
    const unsigned char *lit = p + 3 * (350 * 640 + 420);
    (void)state;
    assert_in_range(lit[0], 180, 255);
    assert_true(shadow[0] + 40 < lit[0] && shadow[0] > 20);
    assert_true(side[0] > side[2] + 20 && side[0] > side[1] + 10);
}

/* The background is the renderer's own to the last digit; of its nine beads those before the ring stay whole, and those
   behind it are covered. The ring is warm by the lamp, and its shadow lies on the ground. */
static void deferred_example_draws(void **state)
{
    const unsigned char *p = example_picture("13_deferred_gl", 640, 400);
    const unsigned char *ring = p + 3 * (80 * 640 + 215), *behind = p + 3 * (20 * 640 + 600);
    const unsigned char *lit = p + 3 * (350 * 640 + 100), *dark = p + 3 * (310 * 640 + 330);
    int beads = 0, i;
    (void)state;
    for (i = 0; i < 640 * 400; i++) beads += p[3 * i + 1] > 200 && p[3 * i + 1] > p[3 * i] + 60;
    assert_in_range(beads, 1800, 1900);
    assert_in_range(behind[0], 101, 103);
    assert_in_range(behind[2], 185, 187);
    assert_true(ring[0] > 240 && ring[0] > ring[2] + 60);
    assert_true(dark[0] + 40 < lit[0] && dark[0] > 60);
}

/* More than half of the pixels are lit ground, so the median is theirs: by the exposure of 0.3 over the middle of their
   bin, a quarter of a power of two wide, they are 127 to 137. All pixels are counted, and the sky is the brightest. */
static void compute_example_draws(void **state)
{
    static unsigned char picture[15 + 3 * 640 * 400 + 1];
    const unsigned char *p = picture + 15, *lit = p + 3 * (380 * 640 + 320), *dark = p + 3 * (330 * 640 + 250);
    const unsigned char *torus = p + 3 * (230 * 640 + 320);
    char command[600], said[100] = "";
    int status;
    (void)state;
    need();
    snprintf(command, sizeof command,
             "ASAN_OPTIONS=detect_leaks=0 timeout 240 xvfb-run -a %s/14_own_compute_gl %s/own.ppm > %s/said",
             build_folder(), folder, folder);
    status = system(command);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 77) {
        puts("skip: no OpenGL 4.3");
        skip();
    }
    assert_int_equal(status, 0);
    assert_int_equal(read_file("own.ppm", picture, sizeof picture), 15 + 3 * 640 * 400);
    assert_in_range(read_file("said", (unsigned char *)said, sizeof said - 1), 20, 99);
    assert_ptr_equal(strstr(said, "256000 pixels, from "), said);
    assert_in_range(lit[0], 127, 137);
    assert_true(dark[0] + 40 < lit[0] && dark[0] > 20);
    assert_true(torus[0] > torus[2] + 10);
}

/* ---- drag and drop ---- */

#if DAPPLE_HAVE_X11

/* One message of the protocol XDND, version 5. */
static void send_message(Display *d, Window from, Window to, const char *type, const long data[4])
{
    XEvent e;
    memset(&e, 0, sizeof e);
    e.xclient.type = ClientMessage;
    e.xclient.window = to;
    e.xclient.message_type = XInternAtom(d, type, False);
    e.xclient.format = 32;
    e.xclient.data.l[0] = (long)from;
    memcpy(e.xclient.data.l + 1, data, 4 * sizeof *data);
    XSendEvent(d, to, False, 0, &e);
}

/* The window asks for what is being dropped. */
static void answer(Display *d, const XSelectionRequestEvent *asked, const char *text)
{
    XEvent e;
    memset(&e, 0, sizeof e);
    XChangeProperty(d, asked->requestor, asked->property, asked->target, 8, PropModeReplace,
                    (const unsigned char *)text, (int)strlen(text));
    e.xselection.type = SelectionNotify;
    e.xselection.requestor = asked->requestor;
    e.xselection.selection = asked->selection;
    e.xselection.target = asked->target;
    e.xselection.property = asked->property;
    e.xselection.time = asked->time;
    XSendEvent(d, asked->requestor, False, 0, &e);
}

/* What a file manager does when the user lets go of a file over the window. 0: the window has taken it. */
static int drop(const char *window, const char *path)
{
    Display *d = XOpenDisplay(NULL);
    Window to = (Window)strtoul(window, NULL, 0), from;
    char text[600];
    long enter[4] = { 5L << 24, 0, 0, 0 }, over[4] = { 0, 100L << 16 | 100, CurrentTime, 0 };
    const long let_go[4] = { 0, 0, 0, 0 };
    if (!d) return 1;
    alarm(60);                 /* no answer: this process ends */
    snprintf(text, sizeof text, "file://%s\r\n", path);
    from = XCreateSimpleWindow(d, DefaultRootWindow(d), 0, 0, 1, 1, 0, 0, 0);
    XSetSelectionOwner(d, XInternAtom(d, "XdndSelection", False), from, CurrentTime);
    enter[1] = (long)XInternAtom(d, "text/uri-list", False);
    over[3] = (long)XInternAtom(d, "XdndActionCopy", False);
    send_message(d, from, to, "XdndEnter", enter);
    send_message(d, from, to, "XdndPosition", over);
    for (;;) {
        XEvent e;
        XNextEvent(d, &e);
        if (e.type == SelectionRequest) {
            answer(d, &e.xselectionrequest, text);
        } else if (e.type == ClientMessage && e.xclient.message_type == XInternAtom(d, "XdndStatus", False)) {
            if (!(e.xclient.data.l[1] & 1)) return 2;
            send_message(d, from, to, "XdndDrop", let_go);
        } else if (e.type == ClientMessage && e.xclient.message_type == XInternAtom(d, "XdndFinished", False)) {
            XCloseDisplay(d);
            return e.xclient.data.l[1] ? 0 : 3;        /* GLFW writes how many bytes it took, not the one bit */
        }
    }
}

#else

static int drop(const char *window, const char *path) { return (void)window, (void)path, 1; }

#endif

static void dropped_files_are_shown(void **state)
{
    static const char triangle[] =
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":36,"
        "\"uri\":\"data:application/octet-stream;base64,"
        "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"nodes\":[{\"mesh\":0}]}";
    char keys[2000];
    (void)state;
    need();
    if (!HAS_X11) {
        printf("skip: no headers of X11\n");
        skip();
    }
    write_script("triangle.gltf", triangle);
    write_script("broken.glb", "not a model");
    write_script("sky.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\nabc\201def\201");
    snprintf(keys, sizeof keys,
             "drop() { \"$SELF\" --drop $window %s/$1; sleep 1; }\n"
             "key p\nshot s\n"                         /* 1: the scene of the command line */
             "drop triangle.gltf\nshot s\n"            /* 2: another one */
             "drop broken.glb\nshot s\n"               /* 3: the same and a line that says why */
             "key r\nsleep 1\nshot s\n"               /* 4: without the line */
             "key p\nshot s\n"                         /* 5: the panel */
             "drop sky.hdr\nshot s\n"                  /* 6: names the sky */
             "key p\nshot s\n", folder);              /* 7: which does not show in the preview */
    run_viewer("--size 320x240 builtin:knot", keys);
    assert_false(same_file("viewer-001.png", "viewer-002.png"));
    assert_false(same_file("viewer-002.png", "viewer-003.png"));
    assert_true(same_file("viewer-002.png", "viewer-004.png"));
    assert_false(same_file("viewer-005.png", "viewer-006.png"));
    assert_true(same_file("viewer-004.png", "viewer-007.png"));
}

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    char command[200];
    (void)state;
    snprintf(command, sizeof command, "rm -rf %s", folder);
    return system(command);
}

int main(int count, char **values)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(keys_change_what_is_shown),
        cmocka_unit_test(space_plays_and_pauses),
        cmocka_unit_test(a_file_that_walks_plays_and_pauses),
        cmocka_unit_test(shows_what_render_writes),
        cmocka_unit_test(reference_is_beside_the_line),
        cmocka_unit_test(dropped_files_are_shown),
        cmocka_unit_test(minimal_example_draws),
        cmocka_unit_test(occlusion_example_answers_as_the_cpu),
        cmocka_unit_test(bounced_light_example_draws),
        cmocka_unit_test(own_map_example_draws_the_same), cmocka_unit_test(sky_example_draws),
        cmocka_unit_test(fields_example_draws), cmocka_unit_test(own_shadow_example_draws),
        cmocka_unit_test(wavelets_example_draws),
        cmocka_unit_test(vpls_example_draws), cmocka_unit_test(shadowed_bounce_example_draws),
        cmocka_unit_test(own_visibility_draws_the_shadows_of_the_maps),
        cmocka_unit_test(own_vertices_example_draws),
        cmocka_unit_test(sky_and_bounce_example_draws), cmocka_unit_test(deferred_example_draws),
        cmocka_unit_test(compute_example_draws),
    };
    char path[600], here[512];
    if (count == 4 && strcmp(values[1], "--drop") == 0) return drop(values[2], values[3]);
    if (!getcwd(here, sizeof here)) return 1;
    snprintf(path, sizeof path, "%s%s%s", values[0][0] == '/' ? "" : here, values[0][0] == '/' ? "" : "/", values[0]);
    self = path;
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
