/* cli_test - render and compare as a user's script calls them: exit status, one line of complaint, JSON, files. */
#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <math.h>
#include <sys/wait.h>
#include <unistd.h>
#include <cmocka.h>

#include "common.h"
#include "json.h"

static char folder[] = "/tmp/dapple-cli-XXXXXX";
static char output[8192];      /* of the last command: stdout, then stderr */
static int  lines_of_error;

#define CORNELL "--technique reference --scene builtin:cornell --size 24x16 --samples 8 --set bounces=2 "

static const char *build_folder(void)
{
    const char *build = getenv("BUILD");
    return build && *build ? build : "build";
}

static void need(const char *program)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", build_folder(), program);
    if (access(path, X_OK) == 0)
        return;
    printf("skip: %s is not built\n", path);
    skip();
}

static size_t read_into(const char *name, size_t at)
{
    char path[256];
    FILE *file;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    file = fopen(path, "rb");
    assert_non_null(file);
    at += fread(output + at, 1, sizeof output - 1 - at, file);
    output[at] = 0;
    fclose(file);
    return at;
}

/* Runs a program of the build folder; %s in arguments is the scratch folder. Returns its exit status. */
static int run(const char *program, const char *arguments)
{
    char command[2048], filled[1536];
    size_t at, out;
    int status;
    snprintf(filled, sizeof filled, arguments, folder, folder, folder);
    snprintf(command, sizeof command, "%s/%s %s > %s/stdout 2> %s/stderr", build_folder(), program, filled, folder,
             folder);
    status = system(command);
    assert_true(status != -1 && WIFEXITED(status));
    at = read_into("stdout", 0);
    out = at;
    read_into("stderr", at);
    lines_of_error = 0;
    for (at = out; output[at]; at++)
        lines_of_error += output[at] == '\n';
    return WEXITSTATUS(status);
}

static void expect_line(const char *program, const char *arguments, int status, const char *text)
{
    int found = run(program, arguments);
    if (found != status || lines_of_error != 1 || !strstr(output, text))
        fail_msg("%s %s: status %d (expected %d), output: %s", program, arguments, found, status, output);
}

static double number(const char *name) { return json_number(output, name); }

static void near(double a, double b, double epsilon, int line)
{
    if (!(fabs(a - b) <= epsilon))
        fail_msg("line %d: %.9g is not within %.3g of %.9g", line, a, epsilon, b);
}

#define assert_near(a, b, e) near(a, b, e, __LINE__)

/* ---- compare ---- */

static void write_picture(const char *name, uint32_t width, uint32_t height, const float *rgb)
{
    char path[256], error[EX_ERROR_SIZE];
    ex_image image;
    assert_int_equal(ex_image_alloc(&image, width, height), 0);
    memcpy(image.rgb, rgb, 3 * sizeof(float) * width * height);
    snprintf(path, sizeof path, "%s/%s", folder, name);
    assert_int_equal(ex_image_write(&image, path, 0, error), 0);
    ex_image_free(&image);
}

static void compare_prints_the_errors_of_two_pictures(void **state)
{
    /* the third pixel is 0 in both and does not count */
    static const float a[12] = { 1, 1, 1, 2, 2, 2, 0, 0, 0, 0, 0, 0 }, b[12] = { 1, 1, 1, 1, 1, 1, 0, 0, 0, 1, 1, 1 };
    (void)state;
    need("compare");
    write_picture("a.pfm", 2, 2, a);
    write_picture("b.pfm", 2, 2, b);
    assert_int_equal(run("compare", "%s/a.pfm %s/b.pfm --diff %s/diff.png"), 0);
    assert_near(number("pixels"), 3, 0);
    assert_near(number("nonfinite"), 0, 0);
    assert_near(number("rmse"), sqrt(2.0 / 3), 1e-6);
    assert_near(number("relative_rmse"), sqrt(2.0 / 3), 1e-6);
    assert_near(number("mean_ratio"), 1, 1e-6);
    assert_near(number("ev"), log2(0.9), 1e-5);
    /* sRGB of 0.9 is 0.95468; A's second pixel is clamped to 1, its fourth is 0 */
    assert_near(number("psnr"), -10 * log10((0.04532 * 0.04532 + 0.95468 * 0.95468) / 3), 1e-3);
    assert_true(number("ssim") < 0.9 && number("ssim") > -1);
    assert_int_equal(run("compare", "%s/b.pfm %s/b.pfm"), 0);
    assert_near(number("rmse"), 0, 0);
    assert_near(number("ssim"), 1, 1e-12);
    assert_non_null(strstr(output, "\"psnr\": null"));
}

/* Two flat pictures: the windows have no variance, ssim is its luminance term alone. */
static void flat_pictures_are_alike_by_their_luminance(void **state)
{
    static float a[3 * 16 * 16], b[3 * 16 * 16];
    double x = 1.055 * pow(0.45, 1 / 2.4) - 0.055, y = 1.055 * pow(0.9, 1 / 2.4) - 0.055;
    (void)state;
    need("compare");
    for (int i = 0; i < 3 * 16 * 16; i++)
        a[i] = 2, b[i] = 4;
    write_picture("a.pfm", 16, 16, a);
    write_picture("b.pfm", 16, 16, b);
    assert_int_equal(run("compare", "%s/a.pfm %s/b.pfm"), 0);
    assert_near(number("ssim"), (2 * x * y + 1e-4) / (x * x + y * y + 1e-4), 1e-5);
    assert_near(number("psnr"), -20 * log10(y - x), 1e-4);
    assert_near(number("relative_rmse"), 0.5, 1e-6);
    assert_near(number("mean_ratio"), 0.5, 1e-6);
}

static void compare_refuses_what_it_cannot_compare(void **state)
{
    static float a[3 * 4 * 4];
    (void)state;
    need("compare");
    write_picture("a.pfm", 4, 4, a);
    write_picture("b.pfm", 4, 3, a);
    expect_line("compare", "%s/a.pfm %s/b.pfm", 1, "sizes differ");
    a[5] = NAN;
    write_picture("b.pfm", 4, 4, a);
    expect_line("compare", "%s/a.pfm %s/b.pfm", 1, "1 pixels are not finite");
    assert_near(number("nonfinite"), 1, 0);
    expect_line("compare", "%s/a.pfm %s/missing.pfm", 1, "missing.pfm");
    expect_line("compare", "%s/a.pfm", 2, "two pictures");
    expect_line("compare", "a b c", 2, "unexpected");
    expect_line("compare", "a b --diff c.jpg", 2, ".png");
    assert_int_equal(run("compare", "--help"), 0);
}

/* ---- render ---- */

/* csm is in every build; the reference is not. */
#define KNOT_OF(technique) "--technique " technique " --scene builtin:knot --size 8x6 --samples 4 --out %s/x.pfm "
#define KNOT KNOT_OF("csm")
#define KNOT_REFERENCE KNOT_OF("reference")
#define FIELD "--technique shadowfield --scene builtin:knot --size 8x6 --out %s/x.pfm "

static int has_reference(void)
{
    run("render", "--list");
    return !strstr(output, "needs Embree");
}

static void render_refuses_bad_arguments(void **state)
{
    static const char *const bad[][2] = {
        { "", "--technique is missing" },
        { "--bogus 1", "unknown option" },
        { "--technique", "value is missing" },
        { "--technique magic --scene builtin:knot --out x.png", "magic" },
        { "--technique csm --scene builtin:nowhere --out x.png", "nowhere" },
        { "--technique csm --scene model.obj --out x.png", "model.obj" },
        { "--technique csm --scene builtin:knot", "--out is missing" },
        { "--technique csm --scene builtin:knot --out x.jpg", ".pfm" },
        { KNOT "--size 0x5", "--size" }, { KNOT "--size 5", "--size" }, { KNOT "--size 99999x5", "--size" },
        { KNOT "--samples 0", "--samples" }, { KNOT "--samples 1.5", "--samples" }, { KNOT "--frames 0", "--frames" },
        { KNOT "--seed -1", "--seed" }, { KNOT "--threads 257", "--threads" },
        { KNOT "--time -1", "--time" }, { KNOT "--time nan", "--time" }, { KNOT "--time 3601", "--time" },
        { KNOT "--limit-memory 0", "--limit-memory" },
        { KNOT "--backend vulkan", "backend" },
        { KNOT "--env builtin:disco", "disco" }, { KNOT "--env sky.png", "sky.png" },
        { KNOT "--camera 1,2,3", "--camera" }, { KNOT "--camera 1,2,3,1,2,3,40", "same" },
        { KNOT "--camera 1,2,3,0,0,0,180", "fovy" }, { KNOT "--camera 1,2,3,0,0,nan,40", "--camera" },
        { KNOT "--light lamp:1,2,3", "lamp" }, { KNOT "--light sun:0,0,0", "zero" }, { KNOT "--light sun:0,1", "sun:" },
        { KNOT "--light sun:0,1,0,1,2", "sun:" }, { KNOT "--light sun:0,1,0,-1", "negative" },
        { KNOT "--light sun:0,1,0,1e13", "1e12" }, { KNOT "--light sphere:0,3,0,1e38,1", "-1e9 to 1e9" },
        { KNOT "--light rect:0,3,0,1e39,0,0,0,0,1", "-1e9 to 1e9" }, { KNOT "--camera 0,0,1e39,0,0,0,40", "1e9" },
        { KNOT "--light sphere:0,1,0,0", "radius" }, { KNOT "--light rect:0,0,0,1,0,0,2,0,0", "area" },
        { KNOT "--light line:0,0,0,0,0,0,1", "length" }, { KNOT "--light spot:0,0,0,0,1,0,400", "degrees" },
        { KNOT "--light disc:0,0,0,0,1,0,1,inf", "disc:" },
        { KNOT "--set bounces", "key=value" }, { KNOT "--set colour=1", "unknown key for this technique (see" },
        { KNOT_OF("ism") "--set tile=64", "unknown key for this technique; nearest is tile_side (see" },
        { KNOT_OF("rsm") "--set light_points=4", "nearest is light_point_count" },
        { KNOT "--set ev=bright", "auto" },
        { KNOT "--set materials=shiny", "diffuse|full" }, { KNOT "--set aa=0", "1 to 16" },
        { KNOT_OF("rsm") "--set interleave=3", "0|1|2|4|8" }, { KNOT_OF("rsm") "--set step=9", "8|16" },
        { KNOT_OF("ism") "--set tile_side=9", "8|16" }, { KNOT_OF("ism") "--samples 0", "1 to 16384" },
        { FIELD "--set shell_count=1", "0 or an integer from 2 to 64" },
        { FIELD "--set position_side=1", "from 2 to 64" },
    };
    static const char *const bad_reference[][2] = {
        { KNOT_REFERENCE "--set bounces=-1", "0 to 1000" }, { KNOT_REFERENCE "--set bounces=1.5", "an integer" },
        { KNOT_REFERENCE "--set only=some", "direct|indirect|all" }, { KNOT_REFERENCE "--baked x.csm", "--baked" },
    };
    (void)state;
    need("render");
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        expect_line("render", bad[i][0], 2, bad[i][1]);
    for (size_t i = 0; has_reference() && i < sizeof bad_reference / sizeof bad_reference[0]; i++)
        expect_line("render", bad_reference[i][0], 2, bad_reference[i][1]);
}

static void render_fails_with_one_line(void **state)
{
    (void)state;
    need("render");
    if (has_reference())
        expect_line("render", KNOT_REFERENCE "--backend gl", 1, "gl");
    expect_line("render", "--technique csm --scene builtin:knot --baked %s/missing.csm --out %s/x.png", 1,
                "missing.csm");
    expect_line("render", "--technique csm --scene %s/missing.glb --out %s/x.png", 1, "missing.glb");
    expect_line("render", KNOT_OF("rsm") "--light sphere:0,9,0,2,1e12", 1, "light.value is ");     /* a header's log */
    expect_line("render", "--technique csm --scene builtin:knot --env %s/missing.hdr --out %s/x.png", 1,
                "missing.hdr");
    expect_line("render", "--technique csm --scene builtin:knot --size 8x6 --samples 1 --set side=2 --set map_side=4 "
                "--out %s/no/x.png", 1,
                "x.png");
    if (has_reference())
        expect_line("render", KNOT_REFERENCE "--set indirect_visibility=0", 1, "bounces=1");
}

static void render_lists_what_it_can_do(void **state)
{
    (void)state;
    need("render");
    assert_int_equal(run("render", "--help"), 0);
    assert_non_null(strstr(output, "--technique"));
    assert_int_equal(run("render", "--list"), 0);
    assert_true(strstr(output, "reference") && strstr(output, "builtin:cornell") && strstr(output, "light_side"));
}

/* The version that the change log and the packages have. */
static void expect_version(const char *program)
{
    char line[128], version[32] = "", expected[64];
    FILE *log = fopen("CHANGELOG.md", "r");
    assert_non_null(log);
    while (!version[0] && fgets(line, sizeof line, log))
        if (strncmp(line, "## Dapple ", 10) == 0)
            snprintf(version, sizeof version, "%.*s", (int)strcspn(line + 10, " \n"), line + 10);
    fclose(log);
    assert_true(version[0]);
    need(program);
    assert_int_equal(run(program, "--version"), 0);
    snprintf(expected, sizeof expected, "%s %s\n", program, version);
    assert_string_equal(output, expected);
}

static void programs_say_their_version(void **state)
{
    (void)state;
    expect_version("render");
    expect_version("compare");
    expect_version("bake");
}

/* On stdout, where it was asked for. */
static void expect_help(const char *program, const char *arguments, const char *text)
{
    need(program);
    assert_int_equal(run(program, arguments), 0);
    assert_int_equal(lines_of_error, 0);
    if (!strstr(output, text))
        fail_msg("%s %s: no \"%s\": %s", program, arguments, text, output);
}

static void programs_print_their_help(void **state)
{
    (void)state;
    expect_help("render", "--help", "usage: render");
    expect_help("render", "--list", "  shell_count          0|2..64 [0] ");
    expect_help("compare", "--help", "usage: compare");
    expect_help("bake", "--help", "usage: bake");
    expect_help("bake", "--help", "  shell_count          0|2..64 [0] ");
    expect_help("bake", "csm --help", "  position_side        0|2..64 [0] ");
    expect_help("bake", "verify --help", "usage: bake");
    expect_line("bake", "magic --help", 2, "or --help");
    expect_line("bake", "csm builtin:knot -o %s/x.csm --set foo=1", 2, "see bake --help");
    expect_line("render", KNOT "--set foo=1", 2, "see render --list");
}

static void bench_prints_its_usage(void **state)
{
    (void)state;
    expect_version("bench");
    expect_help("bench", "--help", "usage: bench");
    expect_line("bench", "", 2, "bench NAME|all");
}

static void gallery_prints_its_usage(void **state)
{
    (void)state;
    expect_version("gallery");
    expect_help("gallery", "--help", "usage: gallery");
    expect_line("gallery", "", 2, "usage: gallery");
    expect_line("gallery", "%s/nowhere", 1, "gallery.tsv");
}

static void need_reference(void)
{
    need("render");
    run("render", "--list");
    if (!strstr(output, "needs Embree"))
        return;
    puts("skip: render was built without Embree");
    skip();
}

/* What is in index.html of the folder, into `page`. */
static void read_page(char *page, size_t size)
{
    char path[300];
    FILE *file;
    snprintf(path, sizeof path, "%s/index.html", folder);
    file = fopen(path, "r");
    assert_non_null(file);
    page[fread(page, 1, size - 1, file)] = 0;
    fclose(file);
}

static void holds(const char *page, const char *a, const char *b, const char *c)
{
    const char *const texts[] = { a, b, c };
    for (int i = 0; i < 3; i++)
        if (!strstr(page, texts[i])) fail_msg("the page lacks %s", texts[i]);
}

/* One scene of two, then both: the page is there in between, says so, and opens with the best picture that it has. */
static void gallery_shows_what_is_drawn_so_far(void **state)
{
    static char page[60000];
    char path[300];
    FILE *list;
    (void)state;
    need_reference();
    need("gallery");
    assert_int_equal(run("render", CORNELL "--out %s/one.pfm --json %s/one.json"), 0);
    assert_int_equal(run("render", CORNELL "--seed 3 --out %s/two.pfm --json %s/two.json"), 0);
    snprintf(path, sizeof path, "%s/gallery.tsv", folder);
    list = fopen(path, "w");
    assert_non_null(list);
    fputs("run\ta test\nbest\ttwo\ngroup\tbox\tdirect\tA <box>\t\nrow\tcsm\tcpu\tplain\tone\nscenes\t2\t1\n", list);
    fclose(list);
    assert_int_equal(run("gallery", "%s"), 0);
    read_page(page, sizeof page);
    holds(page, "Still drawing: 1 of 2 scenes", "class=\"best\"><img src=\"one.png\"", "A &lt;box&gt;");
    assert_null(strstr(page, "type=\"range\""));           /* no reference, no line */
    list = fopen(path, "a");
    assert_non_null(list);
    fputs("group\tbox\tbounced\tLight\tone\nrow\tism\tgl\tplain\ttwo\nscenes\t2\t2\n", list);
    fclose(list);
    assert_int_equal(run("gallery", "%s"), 0);
    read_page(page, sizeof page);
    assert_null(strstr(page, "Still drawing"));
    holds(page, "class=\"best\"><img src=\"two.png\"", "<a href=\"#box-bounced\"><img src=\"two.png\"",
          "<section id=\"box-bounced\">");
    holds(page, "<img src=\"one.png\" alt=\"reference\"", "type=\"range\"", ">ism, OpenGL</button>");
}

/* Without a window: arguments are looked at first. */
static void the_viewer_refuses_before_it_opens_a_window(void **state)
{
    (void)state;
    expect_version("viewer");
    expect_line("viewer", "--bogus", 2, "usage: viewer");
    expect_line("viewer", "builtin:knot builtin:plant", 2, "usage: viewer");
    expect_line("viewer", "--size 4x4", 2, "usage: viewer");
    assert_int_equal(run("viewer", "--help"), 0);
    assert_int_equal(lines_of_error, 0);
}

static void same_files(const char *a, const char *b, int expected)
{
    char command[600];
    snprintf(command, sizeof command, "cmp -s %s/%s %s/%s", folder, a, folder, b);
    assert_int_equal(system(command) == 0, expected);
}

static void render_writes_what_it_measured_as_json(void **state)
{
    static const char *const names[] = { "technique", "backend", "gl_renderer", "path", "scene", "triangles", "width",
                                         "height", "samples", "ev", "precompute_ms", "frame_ms", "memory_bytes",
                                         "peak_bytes", "noise" };
    (void)state;
    need_reference();
    assert_int_equal(run("render", KNOT_REFERENCE "--json -"), 0);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        number(names[i]);
    assert_near(number("width"), 8, 0);
    assert_near(number("samples"), 4, 0);
    assert_true(number("memory_bytes") > 0 && number("peak_bytes") >= number("memory_bytes"));
    assert_int_equal(run("render", "--technique reference --scene builtin:knot --size 8x6 --samples 1 --set ev=1.5 "
                                   "--out %s/x.png --json -"), 0);
    assert_near(number("ev"), 1.5, 0);
    assert_non_null(strstr(output, "\"noise\": null"));
}

static void render_is_deterministic(void **state)
{
    (void)state;
    need_reference();
    assert_int_equal(run("render", CORNELL "--threads 1 --out %s/one.pfm"), 0);
    assert_int_equal(run("render", CORNELL "--threads 3 --out %s/three.pfm"), 0);
    same_files("one.pfm", "three.pfm", 1);
    assert_int_equal(run("render", CORNELL "--seed 1 --out %s/seed.pfm"), 0);
    same_files("one.pfm", "seed.pfm", 0);
}

/* A scene that brings no light: a sun for rsm and ism, the sky for the others. */
static void a_scene_without_light_gets_a_sun_or_the_sky(void **state)
{
    (void)state;
    need("render");
#define UNLIT(technique) "--technique " technique " --scene builtin:knot --size 8x6 --set ground=1 "
    assert_int_equal(run("render", UNLIT("rsm") "--out %s/none.pfm"), 0);
    assert_int_equal(run("render", UNLIT("rsm") "--light sun:0.48,0.8,0.36 --out %s/sun.pfm"), 0);
    same_files("none.pfm", "sun.pfm", 1);
    assert_int_equal(run("render", UNLIT("ism") "--set vpl_count=16 --out %s/none.pfm"), 0);
    assert_int_equal(run("render", UNLIT("ism") "--set vpl_count=16 --light sun:0.48,0.8,0.36 --out %s/sun.pfm"), 0);
    same_files("none.pfm", "sun.pfm", 1);
    assert_int_equal(run("render", UNLIT("envshadow") "--out %s/none.pfm"), 0);
    assert_int_equal(run("render", UNLIT("envshadow") "--env builtin:sky --out %s/sun.pfm"), 0);
    same_files("none.pfm", "sun.pfm", 1);
}

/* Frames of a static scene are averaged; frame i has seed + i. */
static void frames_of_a_static_scene_are_averaged(void **state)
{
    ex_image both, first, second;
    char path[256], error[EX_ERROR_SIZE];
    (void)state;
    need_reference();
    assert_int_equal(run("render", CORNELL "--frames 2 --seed 5 --out %s/both.pfm"), 0);
    assert_int_equal(run("render", CORNELL "--seed 5 --out %s/first.pfm"), 0);
    assert_int_equal(run("render", CORNELL "--seed 6 --out %s/second.pfm"), 0);
    snprintf(path, sizeof path, "%s/both.pfm", folder);
    assert_int_equal(ex_image_read_pfm(&both, path, error), 0);
    snprintf(path, sizeof path, "%s/first.pfm", folder);
    assert_int_equal(ex_image_read_pfm(&first, path, error), 0);
    snprintf(path, sizeof path, "%s/second.pfm", folder);
    assert_int_equal(ex_image_read_pfm(&second, path, error), 0);
    for (size_t i = 0; i < 3 * 24 * 16; i++)
        assert_near((double)both.rgb[i], 0.5 * ((double)first.rgb[i] + (double)second.rgb[i]), 1e-5);
    ex_image_free(&both);
    ex_image_free(&first);
    ex_image_free(&second);
}

/* A default point light makes E = pi at the scene's centre: so does the default sun, from the same side. */
static void default_point_spot_and_sun_light_the_centre_alike(void **state)
{
    (void)state;
    need_reference();
    need("compare");
#define FAR "--technique reference --scene builtin:knot --size 32x24 --samples 1 --set ground=0 "
    assert_int_equal(run("render", FAR "--light point:0,4000,0 --out %s/point.pfm"), 0);
    assert_int_equal(run("render", FAR "--light spot:0,4000,0,0,-1,0,30 --out %s/spot.pfm"), 0);
    assert_int_equal(run("render", FAR "--light sun:0,1,0 --out %s/sun.pfm"), 0);
    assert_int_equal(run("compare", "%s/point.pfm %s/sun.pfm"), 0);
    assert_near(number("mean_ratio"), 1, 0.01);
    assert_int_equal(run("compare", "%s/spot.pfm %s/sun.pfm"), 0);
    assert_near(number("mean_ratio"), 1, 0.01);
}

/* background=1 fills exactly the pixels that are black without, aa keeps the mean. */
static void a_background_fills_black_pixels_alone(void **state)
{
    (void)state;
    need_reference();
    need("compare");
#define UNIFORM "--technique reference --scene builtin:knot --env builtin:uniform --size 48x36 --set ground=0 "
    assert_int_equal(run("render", UNIFORM "--samples 16 --set background=1 --out %s/bg.pfm"), 0);
    assert_int_equal(run("render", UNIFORM "--samples 16 --out %s/black.pfm"), 0);
    assert_int_equal(run("compare", "%s/bg.pfm %s/black.pfm"), 0);
    assert_near(number("pixels"), 48 * 36, 0);
    assert_true(number("mean_ratio") > 1.5);
    assert_int_equal(run("render", UNIFORM "--samples 16 --set background=1 --set aa=4 --out %s/aa.pfm"), 0);
    assert_int_equal(run("compare", "%s/aa.pfm %s/bg.pfm"), 0);
    assert_near(number("mean_ratio"), 1, 0.01);
    assert_true(number("relative_rmse") > 0.005);
}

/* Nothing given: a ground under a scene without camera and emitters, and only there; builtin:sky as its light. */
static void a_bare_scene_gets_a_ground_and_a_sky(void **state)
{
    double with, without;
    (void)state;
    need_reference();
    need("compare");
#define SMALL "--technique reference --size 32x24 --samples 64 --json - "
    assert_int_equal(run("render", SMALL "--scene builtin:knot --out %s/with.pfm"), 0);
    with = number("triangles");
    assert_int_equal(run("render", SMALL "--scene builtin:knot --set ground=0 --out %s/without.pfm"), 0);
    without = number("triangles");
    assert_near(with - without, 2, 0);
    assert_int_equal(run("render", SMALL "--scene builtin:cornell --set ground=1 --out %s/x.pfm"), 0);
    with = number("triangles");
    assert_int_equal(run("render", SMALL "--scene builtin:cornell --out %s/x.pfm"), 0);
    assert_near(with - number("triangles"), 2, 0);
    assert_int_equal(run("render", SMALL "--scene builtin:knot --env builtin:sky --out %s/sky.pfm"), 0);
    same_files("with.pfm", "sky.pfm", 1);
    assert_int_equal(run("render", SMALL "--scene builtin:knot --set env_scale=2 --out %s/twice.pfm"), 0);
    assert_int_equal(run("compare", "%s/twice.pfm %s/sky.pfm"), 0);
    assert_near(number("mean_ratio"), 2, 1e-4);
    assert_int_equal(run("render", SMALL "--scene builtin:knot --set env_rotation=120 --out %s/turned.pfm"), 0);
    assert_int_equal(run("compare", "%s/turned.pfm %s/sky.pfm"), 0);
    assert_true(number("relative_rmse") > 0.1);
}

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    char command[300];
    (void)state;
    snprintf(command, sizeof command, "rm -rf %s", folder);
    return system(command);
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(compare_prints_the_errors_of_two_pictures),
        cmocka_unit_test(flat_pictures_are_alike_by_their_luminance),
        cmocka_unit_test(compare_refuses_what_it_cannot_compare), cmocka_unit_test(render_refuses_bad_arguments),
        cmocka_unit_test(render_fails_with_one_line), cmocka_unit_test(render_lists_what_it_can_do),
        cmocka_unit_test(programs_say_their_version), cmocka_unit_test(programs_print_their_help),
        cmocka_unit_test(bench_prints_its_usage), cmocka_unit_test(gallery_prints_its_usage),
        cmocka_unit_test(gallery_shows_what_is_drawn_so_far),
        cmocka_unit_test(the_viewer_refuses_before_it_opens_a_window),
        cmocka_unit_test(render_writes_what_it_measured_as_json), cmocka_unit_test(render_is_deterministic),
        cmocka_unit_test(frames_of_a_static_scene_are_averaged),
        cmocka_unit_test(default_point_spot_and_sun_light_the_centre_alike),
        cmocka_unit_test(a_scene_without_light_gets_a_sun_or_the_sky),
        cmocka_unit_test(a_background_fills_black_pixels_alone),
        cmocka_unit_test(a_bare_scene_gets_a_ground_and_a_sky)
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
