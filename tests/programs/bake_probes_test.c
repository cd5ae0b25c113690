/* bake_probes_test - bake probes: irradiance of an even sky and of a sun by closed forms, distances in a box, given
   points, shards and parts; its GLSL compiles. */
#define _POSIX_C_SOURCE 200809L
#include "bake.h"
#include "glb.h"

/* The .json and the floats of its .bin. */
static char *load(const char *name, float **floats, size_t *count)
{
    char path[PATH_ROOM], bin[128], *text = (char *)calloc(1 << 16, 1);
    const char *at;
    FILE *file;
    path_of(path, name);
    file = fopen(path, "rb");
    if (!file) fail_msg("no %s", path);
    assert_non_null(text);
    assert_true(fread(text, 1, (1 << 16) - 1, file) > 0);
    fclose(file);
    at = strstr(text, "\"bin\":\"");
    assert_non_null(at);
    assert_int_equal(sscanf(at + 7, "%100[^\"]", bin), 1);
    snprintf(path, sizeof path, "%s/%s", folder, bin);
    file = fopen(path, "rb");
    if (!file) fail_msg("no %s", path);
    *floats = (float *)calloc(1 << 16, sizeof **floats);
    assert_non_null(*floats);
    *count = fread(*floats, sizeof **floats, 1 << 16, file);
    fclose(file);
    return text;
}

/* Irradiance that the harmonics of a probe have for a normal, channel 1. */
static double shade(const float *c, double x, double y, double z)
{
    return 0.28209479 * (double)c[1] + 0.48860251 * (y * (double)c[4] + z * (double)c[7] + x * (double)c[10]) +
           1.09254843 * (x * y * (double)c[13] + y * z * (double)c[16] + x * z * (double)c[22]) +
           0.31539157 * (3 * z * z - 1) * (double)c[19] + 0.54627422 * (x * x - y * y) * (double)c[25];
}

/* A square so small and far below that it hides next to nothing. */
static void save_speck(void)
{
    static const float o[3] = { 0, -1, 0 }, u[3] = { 0, 0, 0.001f }, v[3] = { 0.001f, 0, 0 };
    glb_writer w;
    char path[PATH_ROOM];
    memset(&w, 0, sizeof w);
    path_of(path, "speck.glb");
    glb_grid(&w, 0, o, u, v, 1, NULL, "");
    glb_save(&w, path, "{\"mesh\":0}", 1, "");
    path_of(path, "points.txt");
    {
        FILE *file = fopen(path, "w");
        assert_non_null(file);
        fputs("0 0 0\n1 2 3\n", file);
        fclose(file);
    }
}

static void need_all(void)
{
    need_reference();
    save_speck();
    need_parser("probes speck.glb -o probe.json --grid 1x1x1 --set samples=1");
}

static void an_even_sky_shines_pi_and_a_sun_its_harmonics(void **state)
{
    float *floats;
    size_t count;
    char *text;
    (void)state;
    need_all();
    bake("probes speck.glb -o sky.json --points points.txt --env builtin:uniform --bounces 0 --set samples=4096");
    text = load("sky.json", &floats, &count);
    assert_int_equal(count, 2 * 155);
    assert_non_null(strstr(text, "\"positions\":[[0,0,0],[1,2,3]]"));
    for (int p = 0; p < 2; p++)
        for (int way = 0; way < 6; way++) {
            const double s = way % 2 ? -1 : 1, e = shade(floats + 155 * p, way / 2 == 0 ? s : 0, way / 2 == 1 ? s : 0,
                                                         way / 2 == 2 ? s : 0);
            assert_true(fabs(e - 3.14159265) < 0.02);
        }
    free(text);
    free(floats);
    bake("probes speck.glb -o sun.json --points points.txt --light sun:0,3,4,2 --bounces 0 --set samples=4");
    text = load("sun.json", &floats, &count);
    for (int p = 0; p < 2; p++) { /* to the sun: (1 / 4 + 1 / 2 + 5 / 16) of its irradiance; away: what rings */
        assert_true(fabs(shade(floats + 155 * p, 0, 0.6, 0.8) - 2 * 1.0625) < 1e-4);
        assert_true(fabs(shade(floats + 155 * p, 0, -0.6, -0.8) - 2 * 0.0625) < 1e-4);
    }
    free(text);
    free(floats);
}

/* Mean distance from the middle of a box from -1 to 1 within a texel of the octahedral map: see docs/probes.md. */
static double box_distance(int i)
{
    double sum = 0;
    for (int k = 0; k < 400; k++) {
        const double u = 2 * (i % 8 + (k % 20 + 0.5) / 20) / 8 - 1, v = 2 * (i / 8 + (k / 20 + 0.5) / 20) / 8 - 1;
        const double z = 1 - fabs(u) - fabs(v), x = z >= 0 ? u : (1 - fabs(v)) * (u < 0 ? -1 : 1);
        const double y = z >= 0 ? v : (1 - fabs(u)) * (v < 0 ? -1 : 1);
        sum += sqrt(x * x + y * y + z * z) / fmax(fabs(x), fmax(fabs(y), fabs(z))) / 400;
    }
    return sum;
}

static void distances_are_those_of_a_box(void **state)
{
    static const float c[2][3] = { { -1, -1, -1 }, { 1, 1, 1 } };
    static const float e[2][3][3] = { { { 2, 0, 0 }, { 0, 2, 0 }, { 0, 0, 2 } },
                                      { { -2, 0, 0 }, { 0, -2, 0 }, { 0, 0, -2 } } };
    glb_writer w;
    char path[PATH_ROOM], *text;
    float *floats;
    double worst = 0;
    size_t count;
    (void)state;
    need_all();
    memset(&w, 0, sizeof w);
    path_of(path, "box.glb");
    for (int end = 0; end < 2; end++)
        for (int k = 0; k < 3; k++) {
            const int a = end ? (k + 2) % 3 : (k + 1) % 3, b = end ? (k + 1) % 3 : (k + 2) % 3;
            glb_grid(&w, end || k, c[end], e[end][a], e[end][b], 1, NULL, "");
        }
    glb_save(&w, path, "{\"mesh\":0}", 1, "");
    bake("probes box.glb -o box.json --grid 1x1x1 --set samples=1 --set rays=64");
    text = load("box.json", &floats, &count);
    assert_int_equal(count, 155);
    assert_non_null(strstr(text, "\"grid\":[1,1,1],\"origin\":[0,0,0],\"step\":[2,2,2]"));
    for (int i = 0; i < 64; i++) {
        const float mean = floats[27 + 2 * i], square = floats[28 + 2 * i];
        assert_true(square >= mean * mean - 1e-5f && square < mean * mean + 0.1f);
        worst = fmax(worst, fabs((double)mean - box_distance(i)));
    }
    printf("distances are right within %.3f\n", worst);
    assert_true(worst < 0.06);
    free(text);
    free(floats);
}

static void shards_and_parts_give_the_same_bytes(void **state)
{
    char line[300];
    (void)state;
    need_all();
    bake("probes builtin:cornell -o whole.json --grid 3x2x2 --set samples=16");
    bake("probes builtin:cornell -o parts.json --grid 3x2x2 --set samples=16 --set parts=5 --threads 1");
    for (int i = 1; i <= 3; i++) {
        snprintf(line, sizeof line, "probes builtin:cornell -o %dof3 --grid 3x2x2 --set samples=16 --shard %d/3", i, i);
        bake(line);
    }
    bake("merge -o merged.json builtin:cornell 1of3 2of3 3of3");
    snprintf(line, sizeof line,
             "cd %s && cmp whole.json.*.bin parts.json.*.bin && cmp whole.json.*.bin merged.json.*.bin", folder);
    assert_int_equal(system(line), 0);
    assert_int_equal(run("bake", "probes builtin:cornell -o x.json --grid 3x2"), 2);
    assert_int_equal(run("bake", "probes builtin:cornell -o x.json --grid 3x2x0"), 2);
    assert_int_equal(run("bake", "probes builtin:cornell -o x.json --points none.txt"), 1);
    assert_int_equal(run("bake", "probes builtin:cornell -o x.json --points speck.glb"), 1);
    assert_non_null(strstr(output, "not three numbers a point"));
    snprintf(line, sizeof line, "ls %s | grep -q '^x.json'", folder);
    assert_int_not_equal(system(line), 0);
}

static void the_glsl_compiles(void **state)
{
    char line[900];
    (void)state;
    if (system("command -v glslangValidator > /dev/null") != 0) {
        printf("skip: glslangValidator is not installed\n");
        skip();
    }
    for (int es = 0; es < 2; es++) {
        snprintf(
            line, sizeof line,
            "(printf '#version %s\\nuniform sampler2D probes;in vec3 p;in vec3 n;out vec4 c;\\n' && "
            "cat examples/bake/probes.glsl && echo 'void main(){c=vec4(dapple_probe_irradiance(probes,ivec3(4),vec3(0),"
            "vec3(1),8,p,n),1.0);}') > %s/p.frag && glslangValidator %s/p.frag",
            es ? "300 es\\nprecision highp float;" : "330", folder, folder);
        assert_int_equal(system(line), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_even_sky_shines_pi_and_a_sun_its_harmonics),
        cmocka_unit_test(distances_are_those_of_a_box),
        cmocka_unit_test(shards_and_parts_give_the_same_bytes),
        cmocka_unit_test(the_glsl_compiles),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
