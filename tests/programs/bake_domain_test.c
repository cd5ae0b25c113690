/* bake_domain_test - bake csm --domain: where the maps of each domain look from, against its formula; that the file's
   depths are right; shards and parts; what lamps behind a wall see; domains and files of places that it must refuse. */
#define _POSIX_C_SOURCE 200809L
#include "bake.h"
#include "csm.h"
#include "glb.h"

#define SMALL "--set map_side=16 "

static void write_text(const char *name, const char *text)
{
    char path[PATH_ROOM];
    FILE *file;
    path_of(path, name);
    file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

/* The maps of a file; *data outlives them, for free(). */
static cohsm_maps *open_maps(const char *name, void **data)
{
    cohsm_maps *maps;
    char path[PATH_ROOM];
    FILE *file;
    size_t size;
    path_of(path, name);
    file = fopen(path, "rb");
    if (!file) fail_msg("no %s", path);
    *data = calloc(1, 1 << 22);
    assert_non_null(*data);
    size = fread(*data, 1, 1 << 22, file);
    fclose(file);
    assert_int_equal(cohsm_open(*data, size, NULL, &maps), COHSM_OK);
    return maps;
}

/* Every map's location against the formula of its domain. side: what the file must say. */
static void expect_locations(const char *arguments, const char *name, const uint32_t side[3],
                             void (*formula)(const double *s, double *out))
{
    char line[400];
    void *data;
    cohsm_maps *maps;
    cohsm_info info;
    uint32_t at = 0;
    snprintf(line, sizeof line, "csm builtin:knot -o d.csm " SMALL "%s", arguments);
    bake(line);
    assert_int_equal(run("bake", "verify d.csm builtin:knot"), 0);
    assert_non_null(strstr(output, "\"wrong\": 0"));
    assert_int_equal(run("bake", "info d.csm"), 0);
    snprintf(line, sizeof line, "\"domain\": \"%s\", \"side\": %u, \"side_v\": %u, \"side_w\": %u, ", name,
             (unsigned)side[0], (unsigned)side[1], (unsigned)side[2]);
    if (!strstr(output, line)) fail_msg("%s: %s", line, output);
    maps = open_maps("d.csm", &data);
    cohsm_get_info(maps, &info);
    assert_int_equal(info.map_count, side[0] * side[1] * side[2]);
    for (uint32_t r = 0; r < side[2]; r++)
        for (uint32_t t = 0; t < side[1]; t++)
            for (uint32_t s = 0; s < side[0]; s++) {
                const double cell[3] = { (s + 0.5) / side[0], (t + 0.5) / side[1], (r + 0.5) / side[2] };
                double expected[4] = { 0, 0, 0, 1 };
                float found[4];
                assert_int_equal(cohsm_location(maps, at++, found), COHSM_OK);
                formula(cell, expected);
                for (int k = 0; k < 4; k++)
                    if (fabs((double)found[k] - expected[k]) > 2e-5)
                        fail_msg("%s, map %u: %g, not %g", name, (unsigned)at - 1, (double)found[k], expected[k]);
            }
    cohsm_free(maps);
    free(data);
}

static const double pi = 3.14159265358979;

static void latlong(const double *s, double *out)
{
    const double up = pi * s[1], turn = 2 * pi * (s[0] - 0.5);
    out[0] = sin(up) * cos(turn), out[1] = cos(up), out[2] = sin(up) * sin(turn), out[3] = 0;
}

static void line_of(const double *s, double *out) { out[0] = 3, out[1] = 2 * s[0], out[2] = -1; }
static void rectangle(const double *s, double *out) { out[0] = -1 + 2 * s[0], out[1] = 4, out[2] = 1 - 3 * s[1]; }

static void sphere(const double *s, double *out)
{
    const double y = 1 - 2 * s[1], turn = 2 * pi * (s[0] - 0.5), r = sqrt(1 - y * y);
    out[0] = 5 + 0.5 * r * cos(turn), out[1] = 1 + 0.5 * y, out[2] = 0.5 * r * sin(turn);
}

static void volume(const double *s, double *out) { out[0] = 4 + s[0], out[1] = 2 * s[1], out[2] = -3 * s[2]; }

static void maps_look_from_the_places_of_their_domain(void **state)
{
    static const uint32_t sides[][3] = { { 6, 4, 1 }, { 5, 1, 1 }, { 3, 2, 1 }, { 4, 4, 1 }, { 3, 2, 4 } };
    (void)state;
    expect_locations("--set side=6 --set side_v=4", "latlong", sides[0], latlong);
    expect_locations("--set side=6 --set side_v=4 --domain latlong", "latlong", sides[0], latlong);
    expect_locations("--set side=5 --domain line:3,0,-1,0,2,0", "line", sides[1], line_of);
    expect_locations("--set side=3 --set side_v=2 --domain rectangle:-1,4,1,2,0,0,0,0,-3", "rectangle", sides[2],
                     rectangle);
    expect_locations("--set side=4 --domain sphere:5,1,0,0.5", "sphere", sides[3], sphere);
    expect_locations("--set side=3 --set side_v=2 --set side_w=4 --domain volume:4,0,0,1,0,0,0,2,0,0,0,-3", "volume",
                     sides[4], volume);
}

/* Discs and octahedra have no short formula: every place of a disc lies in its plane, within it, as many on each side;
   directions of an octahedron are unit and their mean is nothing. */
static void discs_and_octahedra_are_even(void **state)
{
    void *data;
    (void)state;
    for (int disc = 0; disc < 2; disc++) {
        cohsm_maps *maps;
        double sum[3] = { 0, 0, 0 }, most = 0;
        bake(disc ? "csm builtin:knot -o e.csm " SMALL "--set side=8 --domain disc:1,4,2,0.5,0,0,0,0,0.5"
                  : "csm builtin:knot -o e.csm " SMALL "--set side=8 --domain octahedral");
        maps = open_maps("e.csm", &data);
        for (uint32_t i = 0; i < 64; i++) {
            float l[4];
            double r;
            assert_int_equal(cohsm_location(maps, i, l), COHSM_OK);
            if (disc) l[0] -= 1, l[1] -= 4, l[2] -= 2;
            for (int k = 0; k < 3; k++) sum[k] += (double)l[k] / 64;
            r = sqrt((double)(l[0] * l[0] + l[1] * l[1] + l[2] * l[2]));
            most = fmax(most, r);
            if (disc) assert_true(fabsf(l[1]) < 1e-6f && r < 0.5);
            else assert_true(fabs(r - 1) < 1e-5);
        }
        for (int k = 0; k < 3; k++) assert_true(fabs(sum[k]) < 1e-5);
        assert_true(!disc || most > 0.4);
        cohsm_free(maps);
        free(data);
    }
}

static void lists_and_tables_come_from_files(void **state)
{
    static const float expected[3][4] = { { 5, 0, 0, 1 }, { 0, 7.5f, 0, 1 }, { -1, -2, 6, 1 } };
    void *data;
    (void)state;
    write_text("places.txt", "# lamps\n5 0 0 1\n\n0 7.5e0 0 1\r\n  -1 -2 6 1");
    for (int table = 0; table < 2; table++) {
        cohsm_maps *maps;
        cohsm_info info;
        bake(table ? "csm builtin:knot -o l.csm " SMALL "--set side=3 --domain table:places.txt"
                   : "csm builtin:knot -o l.csm " SMALL "--domain list:places.txt");
        assert_int_equal(run("bake", "verify l.csm builtin:knot"), 0);
        maps = open_maps("l.csm", &data);
        cohsm_get_info(maps, &info);
        assert_int_equal(info.domain, table ? COHSM_DOMAIN_TABLE : COHSM_DOMAIN_LIST);
        assert_int_equal(info.map_count, 3);
        for (uint32_t i = 0; i < 3; i++) {
            float l[4];
            assert_int_equal(cohsm_location(maps, i, l), COHSM_OK);
            assert_memory_equal(l, expected[i], sizeof l);
        }
        cohsm_free(maps);
        free(data);
    }
}

/* The lamp of the Cornell box shines down from its ceiling: places in its rectangle, and what stands on the floor below
   sees them, while what lies under the floor does not. */
static void places_on_what_shines_light_what_is_below(void **state)
{
    void *data;
    cohsm_maps *maps;
    cohsm_info info;
    float points[6], visible[2];
    uint32_t lights[2];
    cohsm_query q;
    (void)state;
    bake("csm builtin:cornell -o lamp.csm --set map_side=64 --set side=4 --domain emissive");
    assert_int_equal(run("bake", "verify lamp.csm builtin:cornell"), 0);
    maps = open_maps("lamp.csm", &data);
    cohsm_get_info(maps, &info);
    assert_int_equal(info.map_count, 16);
    for (uint32_t i = 0; i < 16; i++) {
        float l[4], first[4];
        assert_int_equal(cohsm_location(maps, i, l), COHSM_OK);
        assert_int_equal(cohsm_location(maps, 0, first), COHSM_OK);
        assert_true(l[3] > 0 && fabsf(l[1] - first[1]) < 1e-5f);
        for (int side = 0; side < 2; side++) {
            const float down = side ? 1.2f * l[1] : 0.1f * l[1];       /* a tenth below the lamp; below the floor */
            for (int k = 0; k < 3; k++) points[3 * side + k] = l[k];
            points[3 * side + 1] -= down;
            lights[side] = i;
        }
        memset(&q, 0, sizeof q);
        q.count = 2;
        q.positions = points;
        q.lights = lights;
        q.light_kind = COHSM_LIGHT_INDEX;
        assert_int_equal(cohsm_visible(maps, &q, visible, NULL), COHSM_OK);
        assert_true(visible[0] > 0.5f && visible[1] < 0.5f);
    }
    cohsm_free(maps);
    free(data);
}

/* Every other setting comes into the file. */
static void settings_come_into_the_file(void **state)
{
    void *data;
    cohsm_maps *maps;
    cohsm_info info;
    (void)state;
    bake("csm builtin:knot -o s.csm " SMALL "--set side=6 --set orientation=two_poles --set depth_bits=5 "
         "--set self_only=1 --set center_x=0.25 --set center_y=0.5 --set center_z=-0.25 --set radius=9 "
         "--set open_thickness=3 --set order=zigzag");
    maps = open_maps("s.csm", &data);
    cohsm_get_info(maps, &info);
    assert_int_equal(info.orientation, COHSM_ORIENTATION_TWO_POLES);
    assert_int_equal(info.order, COHSM_ORDER_ZIGZAG);
    assert_int_equal(info.depth_bits, 5);
    assert_true(info.self_only != 0);
    assert_true(fabsf(info.radius - 9) < 1e-6f && fabsf(info.center[0] - 0.25f) < 1e-6f &&
                fabsf(info.center[1] - 0.5f) < 1e-6f && fabsf(info.center[2] + 0.25f) < 1e-6f);
    cohsm_free(maps);
    free(data);
}

static void shards_and_parts_are_the_whole(void **state)
{
    char line[300];
    (void)state;
    bake("csm builtin:knot -o whole.csm " SMALL "--set side=4 --domain sphere:5,1,0,0.5");
    bake("csm builtin:knot -o parts.csm " SMALL "--set side=4 --domain sphere:5,1,0,0.5 --set parts=3");
    for (int i = 1; i <= 2; i++) {
        snprintf(line, sizeof line,
                 "csm builtin:knot -o s%d " SMALL "--set side=4 --domain sphere:5,1,0,0.5 --shard %d/2", i, i);
        bake(line);
    }
    bake("merge -o merged.csm s1 s2");
    bake("csm builtin:knot -o other " SMALL "--set side=4 --domain sphere:5,1,0,0.6 --shard 2/2");
    assert_int_equal(run("bake", "merge -o x.csm s1 other"), 1);
    snprintf(line, sizeof line, "cd %s && cmp whole.csm parts.csm && cmp whole.csm merged.csm && ! ls | grep '^x'",
             folder);
    assert_int_equal(system(line), 0);
}

static void bad_domains_get_one_line_and_leave_no_file(void **state)
{
    static const struct { const char *arguments; int status; const char *says; } bad[] = {
        { "--domain cube", 2, "line|rectangle|disc" }, { "--domain", 2, "no value" },
        { "--domain line:1,2,3", 2, "line takes 6 numbers" }, { "--domain line:1,2,3,4,5,6,7", 2, "takes 6 numbers" },
        { "--domain line:1,2,3,4,5,x", 2, "takes 6 numbers" }, { "--domain sphere:1,2,3,nan", 2, "takes 4 numbers" },
        { "--domain latlong:1", 2, "takes 0 numbers" }, { "--domain list:", 2, "a file is missing" },
        { "--domain list:none.txt", 1, "cannot read none.txt" }, { "--domain list:words.txt", 1, "words.txt, line 2" },
        { "--domain list:empty.txt", 1, "no places" }, { "--domain list:far.txt", 1, "csm: build" },
        { "--domain table:places2.txt --set side=3", 1, "csm: build" },
        { "--domain emissive", 1, "nothing shines there" },
        { "--domain octahedral --set side=4 --set side_v=5", 1, "csm: build" },
        { "--domain line:0,0,0,1,0,0 --set budget=1", 1, "csm: budget" },
        { "--set depth_bits=9", 2, "depth_bits" }, { "--set orientation=up", 2, "polar" },
        { "--set radius=0.001 --set side=2", 1, "csm: build" } };
    char line[300];
    (void)state;
    write_text("words.txt", "1 2 3 1\n1 2 3\n");
    write_text("empty.txt", "# nothing\n\n");
    write_text("far.txt", "1 2 3 1\n0 1 0 0\n");
    write_text("places2.txt", "5 0 0 1\n0 7 0 1\n");
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        int status;
        snprintf(line, sizeof line, "csm builtin:knot -o x.csm --set map_side=8 %s", bad[i].arguments);
        status = run("bake", line);
        if (status != bad[i].status || !strstr(output, bad[i].says) || strncmp(output, "bake: ", 6) != 0 ||
            strchr(output, '\n') != output + strlen(output) - 1)
            fail_msg("bake %s: status %d, %s", line, status, output);
    }
    assert_int_equal(run("bake", "shadowfield builtin:knot -o x.sf --domain line:1,2,3,4,5,6"), 2);
    snprintf(line, sizeof line, "ls %s | grep -q '^x'", folder);
    assert_int_not_equal(system(line), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(maps_look_from_the_places_of_their_domain),
        cmocka_unit_test(discs_and_octahedra_are_even),
        cmocka_unit_test(lists_and_tables_come_from_files),
        cmocka_unit_test(places_on_what_shines_light_what_is_below),
        cmocka_unit_test(settings_come_into_the_file),
        cmocka_unit_test(shards_and_parts_are_the_whole),
        cmocka_unit_test(bad_domains_get_one_line_and_leave_no_file),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
