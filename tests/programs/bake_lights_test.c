/* bake_lights_test - bake lights: the energy of a sky is that of its lights, by every method; lights of a folder of
   skies keep their numbers; what cannot be read leaves no file. And a sky's harmonics, by bake shadowfield. */
#define _POSIX_C_SOURCE 200809L
#include "bake.h"

#include <math.h>
#include <sys/stat.h>

/* The whole file, for free(). */
static char *text_of(const char *name)
{
    char path[PATH_ROOM], *text = (char *)calloc(1 << 20, 1);
    FILE *file;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    file = fopen(path, "rb");
    if (!file) fail_msg("no %s", path);
    assert_non_null(text);
    assert_true(fread(text, 1, (1 << 20) - 1, file) > 0);
    fclose(file);
    return text;
}

/* A flat .hdr of 64 x 32 texels: grey above, and one bright texel in column x. */
static void save_sky(const char *name, int x)
{
    char path[PATH_ROOM];
    FILE *file;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    file = fopen(path, "wb");
    assert_non_null(file);
    fputs("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 32 +X 64\n", file);
    for (int i = 0; i < 64 * 32; i++) {
        const int row = i / 64, sun = row == 8 && i % 64 == x;
        fputc(row < 16 ? 128 : 16, file);
        fputc(row < 16 ? 128 : 16, file);
        fputc(row < 16 ? 128 : 16, file);
        fputc(sun ? 135 : 129, file);
    }
    assert_int_equal(fclose(file), 0);
}

static void the_energy_is_that_of_the_sky(void **state)
{
    static const char *const methods[] = { "variance", "structured", "median_cut", "cdf" };
    (void)state;
    for (int m = 0; m < 4; m++) {
        char line[200], *text;
        double sum = 0;
        int count = 0;
        snprintf(line, sizeof line, "lights builtin:uniform --count 60 --method %s -o uniform.json", methods[m]);
        bake(line);
        text = text_of("uniform.json");
        for (const char *at = text; (at = strstr(at, "\"irradiance\":[")) != NULL; at++, count++)
            sum += strtod(at + strlen("\"irradiance\":["), NULL);
        printf("%s: %d lights of %.5f W/m^2, 4 pi is %.5f\n", methods[m], count, sum, 4 * 3.14159265);
        assert_true(count > 40 && count <= 60);
        assert_true(fabs(sum - 4 * 3.14159265358979) < 1e-4);
        free(text);
    }
    bake("lights builtin:sky --count 300 --set split_sun=1 --set hemisphere=1 --out sky.gltf");
    bake("lights builtin:sky --count 300 --set split_sun=1 --set hemisphere=1 --out sky.json");
    {
        char *gltf = text_of("sky.gltf"), *json = text_of("sky.json");
        assert_non_null(strstr(gltf, "KHR_lights_punctual"));
        assert_non_null(strstr(json, "\"id\":0,\"sun\":true"));
        free(gltf);
        free(json);
    }
}

/* Numbers of the lights of a frame, in order, into ids. */
static int ids_of(const char *text, int frame, int *ids)
{
    int count = 0;
    const char *end;
    for (; frame >= 0 && text; frame--) text = strstr(text + 1, "{\"sky\"");
    assert_non_null(text);
    end = strstr(text + 1, "{\"sky\"");
    while ((text = strstr(text + 1, "{\"id\":")) != NULL && (!end || text < end)) ids[count++] = atoi(text + 6);
    return count;
}

static void lights_of_a_folder_persist(void **state)
{
    char path[PATH_ROOM], *text;
    int first[64], second[64], third[64], kept = 0;
    struct stat status;
    (void)state;
    snprintf(path, sizeof path, "%s/film", folder);
    assert_int_equal(mkdir(path, 0777), 0);
    save_sky("film/c.hdr", 20);
    save_sky("film/a.hdr", 10);
    save_sky("film/b.HDR", 10);
    bake("lights film --count 40 -o film.json");
    if (strstr(output, "built without stb")) return;
    text = text_of("film.json");
    assert_true(strstr(text, "film/a.hdr") < strstr(text, "film/b.HDR") &&
                strstr(text, "film/b.HDR") < strstr(text, "film/c.hdr"));
    assert_int_equal(ids_of(text, 0, first), 40);
    assert_int_equal(ids_of(text, 1, second), 40);
    assert_int_equal(ids_of(text, 2, third), 40);
    assert_memory_equal(first, second, 40 * sizeof *first);             /* the same sky */
    for (int i = 0; i < 40; i++)
        for (int k = 0; k < 40; k++) kept += second[i] == third[k];
    printf("%d of 40 lights stay when the sun moves\n", kept);
    assert_true(kept >= 35);
    free(text);
    bake("lights film --count 40 -o film.glb");
    snprintf(path, sizeof path, "%s/film-0003.glb", folder);
    assert_int_equal(stat(path, &status), 0);
    snprintf(path, sizeof path, "%s/film.glb", folder);
    assert_int_not_equal(stat(path, &status), 0);
}

/* Bright above, dark below, and a sun of 64 in one texel: the first bands in closed form. Radiance is 1 above the
   horizon and 1/8 below, the texel's solid angle is a strip of the sphere over 64. */
static void a_sky_has_its_harmonics(void **state)
{
    const double pi = 3.14159265358979, polar = pi * 8.5 / 32, turn = 2 * pi * (10.5 / 64 - 0.5);
    const double sun = 63 * 2 * pi / 64 * (cos(pi * 8 / 32) - cos(pi * 9 / 32));
    const double exact[4] = { 0.28209479 * (2 * pi * 1.125 + sun), 0.48860251 * (pi * 0.875 + sun * cos(polar)),
                              0.48860251 * sun * sin(polar) * sin(turn),
                              0.48860251 * sun * sin(polar) * cos(turn) };
    char *text;
    const char *at;
    (void)state;
    save_sky("harmonics.rgbe", 10);
    bake("shadowfield harmonics.rgbe -o sky.sh --set kind=sky --set bands=3");
    if (strstr(output, "built without stb")) return;
    text = text_of("sky.sh");
    at = strstr(text, "\"bands\":3,\"coefficients\":[\n[");
    assert_non_null(at);
    at = strchr(at, '\n') + 2;
    for (int i = 0; i < 27; i++) {
        char *end;
        const double got = strtod(at, &end);
        if (i % 9 < 4) {
            printf("channel %d, coefficient %d: %.5f, exactly %.5f\n", i / 9, i % 9, got, exact[i % 9]);
            assert_true(fabs(got - exact[i % 9]) < 0.002);      /* the cube map's texels are as wide as the sun */
        }
        assert_true(end > at);
        at = end + (i % 9 == 8 ? strlen("],\n[") : 1);
    }
    free(text);
    bake("shadowfield builtin:uniform -o sky.sh --set kind=sky --set bands=1");
    text = text_of("sky.sh");
    at = strstr(text, "[\n[");
    assert_non_null(at);
    assert_true(fabs(strtod(at + 3, NULL) - sqrt(4 * pi)) < 1e-5);
    free(text);
}

static void what_cannot_be_read_leaves_no_file(void **state)
{
    static const struct { const char *arguments; int status; const char *says; } bad[] = {
        { "lights builtin:sky -o o.png", 1, "must end in .glb, .gltf or .json" },
        { "lights builtin:nothing -o o.json", 1, "no built-in sky" }, { "lights none.hdr -o o.json", 1, "cannot read" },
        { "lights . -o o.json", 1, "no .hdr in the folder" }, { "lights mixed -o o.json", 1, "another size" },
        { "lights builtin:sky -o o.json --count 9000", 2, "from 1 to 8192" },
        { "lights builtin:sky -o o.json --method best", 2, "variance|structured" },
        { "lights builtin:sky -o o.json --shard 1/2", 2, "--shard is not for this command" },
        { "shadowfield builtin:sky -o o.json --set kind=sky --set basis=haar", 1, "without basis" },
        { "shadowfield builtin:sky -o o.json --set kind=sky --set shell_count=4", 1, "without shell_count" },
        { "shadowfield builtin:sky -o o.json --set kind=sky --shard 1/2", 1, "neither shards nor nodes" },
        { "shadowfield builtin:sky -o o.json --set kind=sky --set node=sun", 1, "neither shards nor nodes" },
        { "shadowfield builtin:knot -o o.json --set kind=sky", 1, "no built-in sky" } };
    char line[200];
    (void)state;
    snprintf(line, sizeof line, "mkdir %s/mixed", folder);
    assert_int_equal(system(line), 0);
    save_sky("mixed/a.hdr", 3);
    snprintf(line, sizeof line,
             "printf '#?RADIANCE\\nFORMAT=32-bit_rle_rgbe\\n\\n-Y 1 +X 1\\n\\1\\1\\1\\200' > %s/mixed/b.hdr", folder);
    assert_int_equal(system(line), 0);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const int status = run("bake", bad[i].arguments);
        if (strstr(output, "built without stb")) continue;
        if (status != bad[i].status || !strstr(output, bad[i].says) ||
            strchr(output, '\n') != output + strlen(output) - 1)
            fail_msg("bake %s: status %d, %s", bad[i].arguments, status, output);
    }
    snprintf(line, sizeof line, "ls %s | grep -q '^o\\.'", folder);
    assert_int_not_equal(system(line), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_energy_is_that_of_the_sky),
        cmocka_unit_test(lights_of_a_folder_persist),
        cmocka_unit_test(a_sky_has_its_harmonics),
        cmocka_unit_test(what_cannot_be_read_leaves_no_file),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
