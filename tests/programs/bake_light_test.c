/* bake_light_test - bake light against closed forms: a plane in an even sky, a slanted sun, a closed box whose walls
   shine and throw light back; light maps; shards; what it refuses. */
#define _POSIX_C_SOURCE 200809L
#include "bake.h"
#include "glb.h"

static const float o[3] = { -1, 0, 0 }, x2[3] = { 2, 0, 0 }, z2[3] = { 0, 0, 2 };

/* A plane that looks up, with a UV set or without. */
static void save_plane(const char *name, int with_uv)
{
    static const float uv[3] = { 0.1f, 0.1f, 0.8f };
    glb_writer w;
    char path[PATH_ROOM];
    memset(&w, 0, sizeof w);
    path_of(path, name);
    glb_grid(&w, 0, o, z2, x2, 3, with_uv ? uv : NULL, "");
    glb_save(&w, path, "{\"mesh\":0}", 1, "");
}

static void need_all(void)
{
    need_reference();
    save_plane("plane.glb", 0);
    need_parser("light plane.glb -o probe.glb --set samples=1");
}

/* Mean and greatest distance from the mean of an attribute's component, over all vertices of all primitives that lie on
   no edge of the box from -1 to 1. */
static double mean_of(const char *name, const char *attribute, int component, double *spread)
{
    glb_file f;
    char path[PATH_ROOM];
    double sum = 0, low = 1e30, high = -1e30;
    int total = 0;
    path_of(path, name);
    glb_load(&f, path);
    for (const char *at = f.json; (at = strstr(at, "\"attributes\"")) != NULL; at++) {
        int count;
        const float *v = (const float *)(const void *)glb_data(&f, glb_integer(at, attribute), &count);
        const float *p = (const float *)(const void *)glb_data(&f, glb_integer(at, "POSITION"), &count);
        for (int i = 0; i < count; i++) {
            int faces = 0;
            for (int k = 0; k < 3; k++) faces += fabsf(p[3 * i + k]) > 0.99f;
            if (faces > 1) continue;
            total++;
            sum += (double)v[3 * i + component];
            low = fmin(low, (double)v[3 * i + component]);
            high = fmax(high, (double)v[3 * i + component]);
        }
    }
    glb_unload(&f);
    *spread = fmax(sum / total - low, high - sum / total);
    return sum / total;
}

static void a_plane_gets_pi_of_an_even_sky_and_the_cosine_of_a_sun(void **state)
{
    double spread, mean;
    (void)state;
    need_all();
    bake("light plane.glb -o sky.glb --env builtin:uniform --set samples=4096 --bounces 0");
    mean = mean_of("sky.glb", "_IRRADIANCE", 1, &spread);
    printf("even sky: %.4f, up to %.4f apart\n", mean, spread);
    assert_true(fabs(mean - 3.14159265) < 0.02 && spread < 0.15);
    bake("light plane.glb -o sun.glb --light sun:0,3,4,2,4,6 --set samples=1 --set directional=1");
    for (int k = 0; k < 3; k++) {
        mean = mean_of("sun.glb", "_IRRADIANCE", k, &spread);
        assert_true(fabs(mean - 0.6 * 2 * (k + 1)) < 1e-5 && spread < 1e-5);
    }
    mean = mean_of("sun.glb", "_SH2", 0, &spread);              /* sqrt(3 / 4 pi) z E */
    assert_true(fabs(mean - 0.4886025 * 0.8 * 2) < 1e-5);
    mean = mean_of("sun.glb", "_SH0", 1, &spread);
    assert_true(fabs(mean - 0.2820948 * 4) < 1e-5);
}

/* Walls of a closed box shine with radiance 1 and throw half back: pi (1 + 1/2 + 1/4 + ...), everywhere the same. */
static void a_furnace_has_the_sum_of_its_bounces(void **state)
{
    static const float c[2][3] = { { -1, -1, -1 }, { 1, 1, 1 } };
    static const float e[2][3][3] = { { { 2, 0, 0 }, { 0, 2, 0 }, { 0, 0, 2 } },
                                      { { -2, 0, 0 }, { 0, -2, 0 }, { 0, 0, -2 } } };
    glb_writer w;
    char path[PATH_ROOM];
    (void)state;
    need_all();
    memset(&w, 0, sizeof w);
    path_of(path, "box.glb");
    for (int end = 0; end < 2; end++)
        for (int k = 0; k < 3; k++) {           /* at the low corner u x v looks inside, at the high one v x u */
            const int a = end ? (k + 2) % 3 : (k + 1) % 3, b = end ? (k + 1) % 3 : (k + 2) % 3;
            glb_grid(&w, end || k, c[end], e[end][a], e[end][b], 4, NULL, ",\"material\":0");
        }
    glb_save(&w, path, "{\"mesh\":0}", 1, ",\"materials\":[{\"emissiveFactor\":[1,1,1],\"pbrMetallicRoughness\":"
                                          "{\"baseColorFactor\":[0.5,0.5,0.5,1],\"metallicFactor\":0}}]");
    for (int bounces = 0; bounces < 4; bounces += 3) {
        const double exact = 3.14159265358979 * (bounces ? 1.875 : 1);
        double spread, mean;
        char line[200];
        snprintf(line, sizeof line, "light box.glb -o furnace.glb --bounces %d --set samples=256", bounces);
        bake(line);
        mean = mean_of("furnace.glb", "_IRRADIANCE", 0, &spread);
        printf("furnace, %d bounces: %.4f, exact %.4f\n", bounces, mean, exact);
        assert_true(fabs(mean - exact) < 0.03 * exact);
    }
}

static void light_maps_are_the_same_by_shards(void **state)
{
    glb_file f;
    char path[PATH_ROOM], line[300];
    (void)state;
    need_all();
    save_plane("uv.glb", 1);
    bake("light uv.glb -o map.glb --env builtin:uniform --set image_side=32 --set samples=16 --bounces 0");
    path_of(path, "map.glb");
    glb_load(&f, path);
    assert_non_null(strstr(f.json, "\"extras\":{\"lightMapTexture\":{\"index\":0,\"full\":"));
    assert_null(strstr(f.json, "COLOR_0"));
    glb_unload(&f);
    bake("light plane.glb -o whole.glb --env builtin:sky --light point:0,2,1 --set samples=8");
    bake("light plane.glb -o parts.glb --env builtin:sky --light point:0,2,1 --set samples=8 --set parts=3");
    for (int i = 1; i <= 2; i++) {
        snprintf(line, sizeof line, "light plane.glb -o %dof2 --env builtin:sky --light point:0,2,1 --set samples=8 "
                                    "--shard %d/2 --threads 1", i, i);
        bake(line);
    }
    bake("merge -o merged.glb plane.glb 1of2 2of2");
    snprintf(line, sizeof line, "cd %s && cmp whole.glb parts.glb && cmp whole.glb merged.glb", folder);
    assert_int_equal(system(line), 0);
}

static void bad_arguments_get_one_line(void **state)
{
    static const struct { const char *arguments; int status; const char *says; } bad[] = {
        { "light plane.glb -o x.glb --light moon:1,2,3", 1, "moon" },
        { "light plane.glb -o x.glb --env builtin:none", 1, "no built-in sky" },
        { "light plane.glb -o x.glb --bounces many", 2, "bounces" }, { "light none.glb -o x.glb", 1, "cannot read" },
        { "light plane.glb -o x.glb --set into=texture", 1, "no UV set without overlaps" } };
    char line[200];
    (void)state;
    need_all();
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const int status = run("bake", bad[i].arguments);
        if (status != bad[i].status || !strstr(output, bad[i].says) ||
            strchr(output, '\n') != output + strlen(output) - 1)
            fail_msg("bake %s: status %d, %s", bad[i].arguments, status, output);
    }
    snprintf(line, sizeof line, "ls %s | grep -q '^x.glb'", folder);
    assert_int_not_equal(system(line), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_plane_gets_pi_of_an_even_sky_and_the_cosine_of_a_sun),
        cmocka_unit_test(a_furnace_has_the_sum_of_its_bounces),
        cmocka_unit_test(light_maps_are_the_same_by_shards),
        cmocka_unit_test(bad_arguments_get_one_line),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
