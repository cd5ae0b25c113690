/* references_test.c - kept pictures of the path tracer: half floats in a PNG, the hash of what a picture shows, render
   --kept, and those of docs/references, each of the scene that its line says and what the tracer still draws. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>

#include "program.h"
#include "common.h"

#define CORNELL "--technique reference --scene builtin:cornell --size 32x18 "

/* Without stb pictures are written alone, and render draws what it would take. */
static void need_stb(void)
{
#if !defined DAPPLE_HAVE_STB || !DAPPLE_HAVE_STB
    printf("skip: needs stb\n");
    skip();
#endif
}

/* A half float has 11 binary digits, and multiples of 2^-24 below 2^-14. */
static void half_floats_come_back(void **state)
{
    float in[3 * 8] = { 0, 0x1p-25f, 0x1.8p-25f, 0x1p-24f, 0x1.8p-24f, 0x1p-14f, 0.1f, 1.0f / 3, 1, 1.00048828125f,
                        1.00146484375f, 2049, 65504, 65519, 1e6f, -1, NAN, 3.14159274f, 7e-6f, 5e-5f, 6.1e-5f, 123.456f,
                        40000, 1e-9f };
    const float exact[3 * 8] = { 0, 0, 0x1p-24f, 0x1p-24f, 0x1p-23f, 0x1p-14f, -1, -1, 1, 1, 1.001953125f, 2048, 65504,
                                 65504, 65504, 0, 65504, -1, -1, -1, -1, -1, 40000, 0 };     /* -1: near is enough */
    ex_image image = { 8, 1, NULL }, back;
    char error[EX_ERROR_SIZE], path[80];
    (void)state;
    need_stb();
    image.rgb = in;
    snprintf(path, sizeof path, "%s/values.half.png", folder);
    assert_int_equal(ex_image_write(&image, path, 0, error), 0);
    assert_int_equal(ex_image_read_half(&back, path, error), 0);
    assert_int_equal(back.width, 8);
    assert_int_equal(back.height, 1);
    for (int i = 0; i < 24; i++) {
        if (exact[i] < 0) assert_true(fabsf(back.rgb[i] - in[i]) <= fmaxf(in[i] * 0x1p-11f, 0x1p-25f));
        else assert_true(fabsf(back.rgb[i] - exact[i]) <= 0);
    }
    ex_image_free(&back);
}

/* The number that render prints for these arguments. */
static uint64_t hash_of(const char *arguments)
{
    char line[600], *end;
    uint64_t hash;
    need_reference();
    snprintf(line, sizeof line, "%s --hash", arguments);
    assert_int_equal(run("render", line), 0);
    hash = strtoull(output, &end, 16);
    assert_int_equal(end - output, 16);
    return hash;
}

static void a_hash_is_of_what_is_shown(void **state)
{
    static const char *const alike[] = { "--samples 3", "--threads 1", "--set ev=2", "--seed 5", "--time 1" };
    static const char *const others[] = { "--light point:0,0.5,0", "--set bounces=1", "--set only=direct", "--set aa=2",
                                          "--size 32x19", "--set emitters=0", "--set emission=1", "--env builtin:sky",
                                          "--set roughness=0.5", "--camera 0,1,3.5,0,1,0,40", "--set lamp_count=1" };
    uint64_t all[16], hash = hash_of(CORNELL);
    size_t count = sizeof others / sizeof *others;
    char line[300];
    (void)state;
    for (size_t i = 0; i < sizeof alike / sizeof *alike; i++) {
        snprintf(line, sizeof line, CORNELL "%s", alike[i]);
        assert_true(hash_of(line) == hash);
    }
    for (size_t i = 0; i < count; i++) {
        snprintf(line, sizeof line, CORNELL "%s", others[i]);
        all[i] = hash_of(line);
        assert_true(all[i] != hash);
        for (size_t j = 0; j < i; j++) assert_true(all[i] != all[j]);
    }
    /* A sky turned by a fifth of a degree, lamps and robots a few centimetres on their way. */
    assert_true(hash_of(CORNELL "--env builtin:sky --set env_rotation=0.2") != hash_of(CORNELL "--env builtin:sky"));
    assert_true(hash_of(CORNELL "--set lamp_count=1 --time 0.1") != hash_of(CORNELL "--set lamp_count=1"));
    assert_true(hash_of("--technique reference --scene builtin:robots --time 0.1") !=
                hash_of("--technique reference --scene builtin:robots"));
    /* The last of some frames is what is shown. */
    assert_true(hash_of("--technique reference --scene builtin:robots --frames 4") ==
                hash_of("--technique reference --scene builtin:robots --time 0.1"));
}

/* A folder with one picture, of 2 paths a pixel, in `kept` within the scratch folder. */
static void keep_one(void)
{
    char path[80], text[300];
    uint64_t hash = hash_of(CORNELL);
    FILE *file;
    need_stb();
    snprintf(text, sizeof text, "mkdir -p %s/kept", folder);
    assert_int_equal(system(text), 0);
    assert_int_equal(run("render", CORNELL "--samples 2 --out kept/box.half.png"), 0);
    snprintf(path, sizeof path, "%s/kept/list.tsv", folder);
    file = fopen(path, "w");
    assert_non_null(file);
    fprintf(file, "0000000000000001\tother\t7\t0.5\t8\targuments\n%016llx\tbox\t2\t0.25\t1234.5\targuments\n",
            (unsigned long long)hash);
    assert_int_equal(fclose(file), 0);
}

static void a_kept_picture_is_taken(void **state)
{
    (void)state;
    keep_one();
    assert_int_equal(run("render", CORNELL "--samples 64 --kept kept --out taken.pfm --json -"), 0);
    assert_true(number("samples") > 1.5 && number("samples") < 2.5);
    assert_true(fabs(number("noise") - 0.25) < 1e-6);
    assert_true(fabs(number("kept_ms") - 1234.5) < 1e-3);
    assert_null(strstr(output, "frame_ms"));
    assert_int_equal(run("render", CORNELL "--samples 2 --out drawn.pfm"), 0);
    assert_int_equal(run("compare", "taken.pfm drawn.pfm"), 0);
    assert_true(number("relative_rmse") < 1e-3);
    /* What shows something else is drawn. */
    expect(0, "frame_ms", CORNELL "--light point:0,0.5,0 --samples 2 --kept kept --out drawn.pfm --json -");
    assert_null(strstr(output, "kept_ms"));
}

static void what_is_wrong_is_said(void **state)
{
    char command[200];
    (void)state;
    keep_one();
    expect(1, "nowhere/list.tsv: cannot open", CORNELL "--kept nowhere --out a.pfm");
    expect(2, "--kept: pictures are kept of technique reference alone",
           "--technique rsm --scene builtin:cornell --kept kept --out a.pfm");
    snprintf(command, sizeof command, "cd %s/kept && head -c 300 box.half.png > x && mv x box.half.png", folder);
    assert_int_equal(system(command), 0);
    expect(1, "kept/box.half.png: ", CORNELL "--kept kept --out a.pfm");
    expect(0, "", CORNELL "--samples 1 --out kept/box.png");
    snprintf(command, sizeof command, "mv %s/kept/box.png %s/kept/box.half.png", folder, folder);
    assert_int_equal(system(command), 0);
    expect(1, "not a PNG of 3 channels of 16 bits", CORNELL "--kept kept --out a.pfm");
    expect(0, "", "--technique reference --scene builtin:cornell --size 31x18 --samples 1 --out kept/box.half.png");
    expect(1, "has not the 32 x 18 pixels of its hash", CORNELL "--kept kept --out a.pfm");
}

/* docs/references: lines of the list are of what the program draws today, and the tracer's picture by few paths differs
   from the kept one by its noise and no more. */
static void kept_references_are_what_is_drawn_today(void **state)
{
    char line[1024], here[200], command[700];
    int lines = 0, drawn = 0;
    FILE *list = fopen("docs/references/list.tsv", "r");
    (void)state;
    need_stb();
    assert_non_null(list);
    assert_non_null(getcwd(here, sizeof here));
    while (fgets(line, sizeof line, list)) {
        char name[64] = "", *arguments = strstr(line, "--technique");
        double noise;
        assert_non_null(arguments);
        line[strcspn(line, "\n")] = 0;
        assert_int_equal(sscanf(line, "%*x %63s", name), 1);
        if (hash_of(arguments) != strtoull(line, NULL, 16)) fail_msg("%s shows something else: tools/references", name);
        lines++;
        if (strcmp(name, "cornell-direct") != 0 && strcmp(name, "knot-sun-direct") != 0) continue;
        snprintf(command, sizeof command, "%.400s --kept %s/docs/references --out kept.pfm --json -", arguments, here);
        assert_int_equal(run("render", command), 0);
        assert_non_null(strstr(output, "kept_ms"));
        snprintf(command, sizeof command, "%.400s --samples 4 --out drawn.pfm --json -", arguments);
        assert_int_equal(run("render", command), 0);
        noise = number("noise");
        assert_int_equal(run("compare", "drawn.pfm kept.pfm"), 0);
        assert_true(fabs(number("mean_ratio") - 1) < 0.01);
        assert_true(number("relative_rmse") < 1.25 * noise + 0.001);
        drawn++;
    }
    fclose(list);
    assert_true(lines >= 2);
    assert_int_equal(drawn, 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(half_floats_come_back),
        cmocka_unit_test(a_hash_is_of_what_is_shown),
        cmocka_unit_test(a_kept_picture_is_taken),
        cmocka_unit_test(what_is_wrong_is_said),
        cmocka_unit_test(kept_references_are_what_is_drawn_today),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
