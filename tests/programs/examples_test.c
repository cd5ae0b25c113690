/* The examples that need no GL, as a reader runs them: each ends well, and its picture is the one that was looked at
   when its line was written, by size and mean colour. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>

#include "program.h"

typedef struct example {
    const char *program;
    int         width, height;
    double      mean[3];            /* of the picture's bytes */
    const char *more;               /* an argument behind the picture's name, or NULL */
} example;

static const example examples[] = {
    { "01_csm_minimal", 320, 200, { 195.56, 195.56, 195.56 }, NULL },
    { "01b_lightsampling_minimal", 320, 200, { 81.72, 86.21, 96.21 }, NULL },
    { "01c_lightsampling_path_tracer", 240, 150, { 88.00, 91.53, 100.18 }, NULL },
    { "01d_csm_own_views", 320, 200, { 181.35, 181.35, 181.35 }, NULL },
    { "01d_csm_own_views", 320, 200, { 188.82, 188.82, 188.82 }, "ball" },
    { "01f_csm_final_gathering", 160, 128, { 61.42, 56.53, 43.55 }, NULL },
    { "01g_csm_surface_light", 320, 200, { 88.55, 84.60, 90.70 }, NULL },
    { "01h_csm_skinned", 800, 320, { 164.71, 168.93, 173.16 }, NULL },
    { "02_shadowfield_minimal", 256, 256, { 148.16, 146.64, 143.47 }, NULL },
    { "02c_shadowfield_robot", 800, 320, { 153.89, 155.54, 159.90 }, NULL },
    { "03_envshadow_minimal", 320, 200, { 188.60, 189.54, 194.12 }, NULL },
    { "03b_envlights_minimal", 256, 128, { 98.84, 103.10, 99.46 }, NULL },
    { "03c_envshadow_own_maps", 320, 200, { 123.05, 113.91, 112.70 }, NULL },
    { "04a_rsm_minimal", 320, 200, { 101.65, 83.66, 75.48 }, NULL },
    { "04b_ism_minimal", 320, 200, { 104.13, 66.35, 66.35 }, NULL },
    { "04c_gifilter_minimal", 320, 200, { 176.57, 176.57, 176.57 }, NULL },
    { "04d_ism_stages", 768, 192, { 103.29, 100.01, 96.70 }, NULL },
    { "04e_rsm_own_renderer", 640, 120, { 106.32, 101.72, 91.10 }, NULL },
    { "04f_rsm_shadows", 720, 160, { 90.28, 58.41, 58.41 }, NULL }
};

static void look(const example *e)
{
    char path[64], arguments[64];
    double sum[3] = { 0, 0, 0 };
    int width = 0, height = 0, byte, most = 0, k;
    FILE *file;
    snprintf(arguments, sizeof arguments, "picture.ppm %s", e->more ? e->more : "");
    if (run(e->program, arguments) != 0) fail_msg("%s: %s", e->program, output);
    snprintf(path, sizeof path, "%s/picture.ppm", folder);
    file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fscanf(file, "P6 %d %d %d", &width, &height, &most), 3);
    assert_int_equal(fgetc(file), '\n');
    if (width != e->width || height != e->height || most != 255)
        fail_msg("%s: %d x %d", e->program, width, height);
    for (k = 0; k < 3 * width * height; k++) {
        byte = fgetc(file);
        assert_true(byte != EOF);
        sum[k % 3] += byte;
    }
    fclose(file);
    remove(path);
    for (k = 0; k < 3; k++)         /* half a step of 255: another math library rounds a few pixels otherwise */
        if (fabs(sum[k] / (width * height) - e->mean[k]) > 0.5)
            fail_msg("%s: channel %d is %.2f, was %.2f", e->program, k, sum[k] / (width * height), e->mean[k]);
}

static void examples_draw_what_was_looked_at(void **state)
{
    size_t i;
    (void)state;
    for (i = 0; i < sizeof examples / sizeof *examples; i++) look(&examples[i]);
}

static void probes_print_what_was_looked_at(void **state)
{
    (void)state;
    assert_int_equal(run("02b_shadowfield_probes", ""), 0);
    assert_non_null(strstr(output, "probe 0: 85 % of all directions open, 1.88 W/m^2 from above"));
    assert_non_null(strstr(output, "three walls leave 0.3308 of all directions: wavelets 0.3308"));
    assert_non_null(strstr(output, "of a sun above them 1.00 is seen, of one below 0.00"));
}

/* The light of the sky by maps of rigid parts, beside rays that meet the skin: where it bends twice as far off as maps
   alone are on straight limbs, elsewhere and on the floor no farther than there. */
static void a_skin_by_rigid_parts_costs_little(void **state)
{
    static const char *const poses[] = { "straight", "bent" };
    double off[2][3];
    int i;
    (void)state;
    assert_int_equal(run("01h_csm_skinned", "picture.ppm"), 0);
    for (i = 0; i < 2; i++) {
        const char *line = strstr(output, poses[i]);
        assert_non_null(line);
        assert_int_equal(sscanf(strchr(line, ':'), ": light of the sky off by %lf on the floor, %lf where limbs bend, "
                                "%lf elsewhere", &off[i][0], &off[i][1], &off[i][2]), 3);
    }
    assert_true(off[0][0] < 0.0035 && off[0][1] < 0.006 && off[0][2] < 0.006);
    assert_true(off[1][0] < 0.004 && off[1][1] < 0.01 && off[1][2] < 0.006);
}

/* 200 rocks in a quarter of their memory: what the example compares itself, and that it had to let rocks go. */
static void a_stream_walks_past_what_memory_cannot_hold(void **state)
{
    (void)state;
    assert_int_equal(run("01e_csm_streaming", "objects.csms"), 0);
    assert_non_null(strstr(output, "we were at 34 steps; 0 steps differ from all rocks in memory"));
    assert_null(strstr(output, " 0 left"));
}

/* A reading of a map by eye, without its bias, is the library's but at edges. */
static void stages_are_asked_and_read(void **state)
{
    (void)state;
    assert_int_equal(run("04d_ism_stages", "picture.ppm"), 0);
    assert_non_null(strstr(output, "sees 77 % of the pixels before it"));
    assert_non_null(strstr(output, "ism_visible agrees on 96."));
}

/* What 06b writes for other APIs is a shader that compiles for Vulkan, a block and a light. */
static void own_api_example_writes_a_shader(void **state)
{
    char command[200];
    (void)state;
    assert_int_equal(run("06b_csm_own_api", "own"), 0);
    assert_non_null(strstr(output, "lights: 10 texels"));
    if (system("command -v glslangValidator > /dev/null 2>&1") != 0) return;
    snprintf(command, sizeof command, "cd %s && glslangValidator -V own.comp -o own.spv > /dev/null", folder);
    assert_int_equal(system(command), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(examples_draw_what_was_looked_at),
                                        cmocka_unit_test(probes_print_what_was_looked_at),
                                        cmocka_unit_test(a_skin_by_rigid_parts_costs_little),
                                        cmocka_unit_test(a_stream_walks_past_what_memory_cannot_hold),
                                        cmocka_unit_test(stages_are_asked_and_read),
                                        cmocka_unit_test(own_api_example_writes_a_shader) };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
