/* bake_ao_test - bake ao against closed forms, by maps and by rays: a plane, two planes that meet, in one object and in
   two, turned, mirrored and sheared; what it leaves as it is; images; shards and parts; files that it must refuse. */
#define _POSIX_C_SOURCE 200809L
#include "bake.h"
#include "glb.h"

#include <signal.h>
#include <sys/stat.h>

static const float o[3] = { -1, 0, 0 }, x2[3] = { 2, 0, 0 }, z2[3] = { 0, 0, 2 }, y1[3] = { 0, 1, 0 };

enum { SIDE = 12 };

static int has_rays(void)
{
    run("render", "--list");
    return !strstr(output, "needs Embree");
}

static void need_gltf(void)
{
    glb_writer w;
    char path[PATH_ROOM];
    memset(&w, 0, sizeof w);
    path_of(path, "probe.glb");
    glb_grid(&w, 0, o, z2, x2, 1, NULL, "");
    glb_save(&w, path, "{\"mesh\":0}", 1, "");
    need_parser("ao probe.glb -o probe-out.glb --set side=4 --set map_side=8");
}

/* What part of a hemisphere a polygon hides, weighted by the cosine, by Lambert's formula. */
static double hidden(const float *p, const double *n, const double (*q)[3], int corners)
{
    double sum = 0;
    for (int i = 0; i < corners; i++) {
        double a[3], b[3], c[3], la = 0, lb = 0, lc = 0, cosine = 0, along = 0;
        for (int k = 0; k < 3; k++) {
            a[k] = q[i][k] - (double)p[k];
            b[k] = q[(i + 1) % corners][k] - (double)p[k];
            la += a[k] * a[k];
            lb += b[k] * b[k];
            cosine += a[k] * b[k];
        }
        for (int k = 0; k < 3; k++) {
            c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
            lc += c[k] * c[k];
            along += c[k] * n[k];
        }
        cosine /= sqrt(la * lb);
        if (lc > 1e-20)
            sum += acos(cosine < -1 ? -1 : cosine > 1 ? 1 : cosine) * along / sqrt(lc);
    }
    return fabs(sum) / (2 * 3.14159265358979);
}

/* Mean of |COLOR_0 - expected| over the vertices of the first primitive, the floor, that do not lie on the wall. */
static double floor_error(const char *name)
{
    static const double wall[4][3] = { { -1, 0, 0 }, { 1, 0, 0 }, { 1, 1, 0 }, { -1, 1, 0 } }, up[3] = { 0, 1, 0 };
    glb_file f;
    char path[PATH_ROOM];
    const char *primitive;
    const uint8_t *colors;
    const float *positions;
    double sum = 0;
    int count, used = 0;
    path_of(path, name);
    glb_load(&f, path);
    primitive = strstr(f.json, "\"attributes\"");
    assert_non_null(primitive);
    colors = glb_data(&f, glb_integer(primitive, "COLOR_0"), &count);
    positions = (const float *)(const void *)glb_data(&f, glb_integer(primitive, "POSITION"), &count);
    for (int i = 0; i < count; i++) {
        const double value = (colors[8 * i] + 256.0 * colors[8 * i + 1]) / 65535;
        assert_int_equal(colors[8 * i + 7], 255);
        if (!(positions[3 * i + 2] > 1e-6f))
            continue;
        sum += fabs(value - (1 - hidden(positions + 3 * i, up, wall, 4)));
        used++;
    }
    assert_true(used > 100);
    glb_unload(&f);
    return sum / used;
}

/* The floor and the wall: 0 in one mesh, 1 in two, 2 the wall turned, 3 mirrored, 4 made of a sheared square. */
static void save_corner(const char *name, int kind)
{
    static const char *const nodes[5] = {
        "{\"mesh\":0}", "{\"mesh\":0},{\"mesh\":1}", "{\"mesh\":0},{\"mesh\":1,\"rotation\":[0,1,0,0]}",
        "{\"mesh\":0},{\"mesh\":1,\"scale\":[-1,1,1]}",
        "{\"mesh\":0},{\"mesh\":1,\"matrix\":[1,0,0,0,1,1,0,0,0,0,1,0,0,0,0,1]}" };
    static const float slanted[3] = { -1, 1, 0 };
    glb_writer w;
    char path[PATH_ROOM];
    memset(&w, 0, sizeof w);
    path_of(path, name);
    glb_grid(&w, 0, o, z2, x2, SIDE, NULL, "");
    glb_grid(&w, kind == 0, o, x2, kind == 4 ? slanted : y1, SIDE, NULL, "");
    glb_save(&w, path, nodes[kind], kind ? 2 : 1, "");
}

static void a_plane_is_white(void **state)
{
    static const char *const engines[2] = { "csm", "embree" };
    (void)state;
    need_gltf();
    for (int e = 0; e < 1 + has_rays(); e++) {
        glb_writer w;
        glb_file f;
        char path[PATH_ROOM], line[300];
        const uint8_t *colors;
        double sum = 0;
        int count;
        memset(&w, 0, sizeof w);
        path_of(path, "plane.glb");
        glb_grid(&w, 0, o, z2, x2, SIDE, NULL, "");
        glb_save(&w, path, "{\"mesh\":0}", 1, "");
        snprintf(line, sizeof line, "ao plane.glb --out plane-ao.glb --engine %s", engines[e]);
        bake(line);
        path_of(path, "plane-ao.glb");
        glb_load(&f, path);
        colors = glb_data(&f, glb_integer(strstr(f.json, "\"attributes\""), "COLOR_0"), &count);
        for (int i = 0; i < count; i++) sum += colors[4 * i] / 255.0 / count;
        printf("plane by %s: %.4f\n", engines[e], sum);
        assert_true(sum > (e ? 0.9999 : 0.995));
        glb_unload(&f);
    }
}

/* The shadow of the wall on the floor, which one formula gives however the wall is made. */
static void a_wall_shades_the_floor_by_lamberts_formula(void **state)
{
    static const char *const kinds[5] = { "one object", "two", "turned", "mirrored", "sheared" };
    const int rays = has_rays();
    (void)state;
    need_gltf();
    for (int kind = 0; kind < 5; kind++)
        for (int e = 0; e <= rays; e++) {
            char line[300];
            double error;
            save_corner("corner.glb", kind);
            snprintf(line, sizeof line, "ao corner.glb -o corner-ao.glb --set bits=16 --engine %s",
                     e ? "embree" : "csm");
            bake(line);
            error = floor_error("corner-ao.glb");
            printf("%s by %s: mean absolute error %.4f\n", kinds[kind], e ? "embree" : "csm", error);
            assert_true(error < (e ? 0.005 : 0.01));
        }
}

/* A wall twice as far as `distance` shades nothing; a ground just below darkens nothing above it, but what looks down.
 */
static void the_distance_ends_occlusion_and_a_ground_adds_it(void **state)
{
    glb_writer w;
    glb_file f;
    char path[PATH_ROOM];
    const uint8_t *colors;
    int count;
    (void)state;
    need_gltf();
    memset(&w, 0, sizeof w);
    path_of(path, "down.glb");
    glb_grid(&w, 0, o, x2, z2, 4, NULL, "");           /* faces down */
    glb_save(&w, path, "{\"mesh\":0,\"translation\":[0,1,0]}", 1, "");
    bake("ao down.glb -o down-ao.glb --engine csm --set ground=0.5");
    path_of(path, "down-ao.glb");
    glb_load(&f, path);
    colors = glb_data(&f, glb_integer(strstr(f.json, "\"attributes\""), "COLOR_0"), &count);
    for (int i = 0; i < count; i++) assert_int_equal(colors[4 * i], 0);
    glb_unload(&f);
    if (!has_rays()) return;
    bake("ao down.glb -o down-ao.glb --set ground=0.5 --set distance=0.4");
    glb_load(&f, path);
    colors = glb_data(&f, glb_integer(strstr(f.json, "\"attributes\""), "COLOR_0"), &count);
    for (int i = 0; i < count; i++) assert_int_equal(colors[4 * i], 255);
    glb_unload(&f);
    save_corner("corner.glb", 1);
    bake("ao corner.glb -o near.glb --set distance=0.01 --set bits=16");
    assert_true(floor_error("near.glb") > 0.02);        /* nothing shades: far from the formula */
    assert_int_equal(run("bake", "ao corner.glb -o x.glb --engine csm --set distance=1"), 1);
    assert_non_null(strstr(output, "distance needs --engine embree"));
}

/* Every byte of the buffer, and every byte of the JSON but for insertions, is in the output, in order. */
static void all_else_stays(void **state)
{
    static const char more[] = ",\"materials\":[{\"name\":\"a \\\"quoted\\\" one\",\"extras\":{\"n\":1.0e-3}}],"
                               "\"extensionsUsed\":[\"X_unknown\"],\"extensions\":{\"X_unknown\":{\"deep\":[[[0.10]]]}}";
    glb_writer w;
    glb_file before, after;
    char path[PATH_ROOM];
    size_t at = 0;
    (void)state;
    need_gltf();
    memset(&w, 0, sizeof w);
    path_of(path, "kept.glb");
    glb_grid(&w, 0, o, z2, x2, 4, NULL, ",\"material\":0,\"extras\":{\"COLOR_0\":7}");
    glb_save(&w, path, "{\"mesh\":0,\"name\":\"n\"}", 1, more);
    bake("ao kept.glb -o kept-ao.glb --set side=8 --set map_side=16 --set bent=1");
    glb_load(&before, path);
    path_of(path, "kept-ao.glb");
    glb_load(&after, path);
    assert_memory_equal(before.bin, after.bin, before.bin_size);
    for (size_t i = 0; i < before.json_size; i++) {
        if (strncmp(before.json + i, "\"byteLength\":", 13) == 0 &&
            strstr(before.json, "\"buffers\"") < before.json + i) {
            i += strcspn(before.json + i, "}");         /* the buffer's length is another */
        }
        while (at < after.json_size && after.json[at] != before.json[i]) at++;
        if (before.json[i] == ' ' && i + 4 >= before.json_size) break;
        assert_true(at++ < after.json_size);
    }
    assert_non_null(
        strstr(after.json, "\"asset\" : {\"version\":\"2.0\", \"extras\":{\"kept\":[1,2.50,\"\\u00e9\"]}}"));
    assert_non_null(strstr(after.json, more + 1));
    assert_non_null(strstr(after.json, "\"extras\":{\"COLOR_0\":7}"));
    assert_non_null(strstr(after.json, "\"_BENT_NORMAL\":"));
    glb_unload(&before);
    glb_unload(&after);
}

/* Bent normals of a floor beside a wall lean away from it. */
static void bent_normals_lean_away(void **state)
{
    glb_file f;
    char path[PATH_ROOM];
    const float *bent, *positions;
    int count;
    (void)state;
    need_gltf();
    save_corner("corner.glb", 0);
    bake("ao corner.glb -o bent.glb --engine csm --set bent=1");
    path_of(path, "bent.glb");
    glb_load(&f, path);
    bent = (const float *)(const void *)glb_data(&f, glb_integer(strstr(f.json, "\"attributes\""), "_BENT_NORMAL"),
                                                 &count);
    positions =
        (const float *)(const void *)glb_data(&f, glb_integer(strstr(f.json, "\"attributes\""), "POSITION"), &count);
    for (int i = 0; i < count; i++) {
        const float *b = bent + 3 * i;
        assert_true(fabsf(b[0] * b[0] + b[1] * b[1] + b[2] * b[2] - 1) < 1e-5f);
        if (positions[3 * i + 2] > 0.01f && positions[3 * i + 2] < 0.5f && fabsf(positions[3 * i]) < 0.5f)
            assert_true(b[2] > 0.15f && b[1] > 0.5f);
    }
    glb_unload(&f);
}

/* UV squares beside each other make one image; a second object with the same material gets a copy of it; where squares
   overlap, vertices are taken. */
static void objects_whose_charts_do_not_overlap_get_images(void **state)
{
    static const float left[3] = { 0, 0, 0.45f }, right[3] = { 0.5f, 0.5f, 0.45f };
    static const char more[] = ",\"materials\":[{\"name\":\"m\",\"occlusionTexture\":{\"index\":0,\"strength\":0.5}}]"
                               ",\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"none.png\"}]";
    glb_writer w;
    glb_file f;
    char path[PATH_ROOM];
    (void)state;
    need_gltf();
    memset(&w, 0, sizeof w);
    path_of(path, "uv.glb");
    glb_grid(&w, 0, o, z2, x2, 4, left, ",\"material\":0");
    glb_grid(&w, 1, o, x2, y1, 4, right, "");
    glb_save(&w, path, "{\"mesh\":0}", 1, more);
    bake("ao uv.glb -o uv-ao.glb --set image_side=64 --set bent=1 --set denoise=1 --set bits=16");
    path_of(path, "uv-ao.glb");
    glb_load(&f, path);
    assert_null(strstr(f.json, "COLOR_0"));
    assert_non_null(strstr(f.json, "\"occlusionTexture\":{\"index\":1}"));
    assert_null(strstr(f.json, "\"strength\""));
    assert_non_null(strstr(f.json, "\"extras\":{\"bentNormalTexture\":{\"index\":2}}"));
    assert_non_null(strstr(f.json, "\"name\":\"m\""));
    assert_non_null(strstr(f.json, "\"material\":1"));                  /* the one that had none */
    assert_int_equal(
        f.bin[glb_integer(glb_item(&f, "bufferViews", glb_integer(glb_item(&f, "images", 1), "bufferView")),
                          "byteOffset") +
              24],
        16); /* bits of the PNG */
    glb_unload(&f);
    path_of(path, "uv2.glb");
    glb_grid(&w, 0, o, z2, x2, 4, left, ",\"material\":0");
    glb_grid(&w, 0, o, x2, y1, 4, left, ",\"material\":0");
    glb_save(&w, path, "{\"mesh\":0},{\"mesh\":1}", 2, more);
    bake("ao uv2.glb -o uv2-ao.glb --set image_side=64");
    path_of(path, "uv2-ao.glb");
    glb_load(&f, path);
    assert_non_null(strstr(f.json, "\"occlusionTexture\":{\"index\":1},\"name\":\"m\""));
    assert_non_null(strstr(f.json, "\"occlusionTexture\":{\"index\":2},\"name\":\"m\""));
    glb_unload(&f);
    path_of(path, "uv3.glb");
    glb_grid(&w, 0, o, z2, x2, 4, left, "");
    glb_grid(&w, 1, o, x2, y1, 4, left, "");
    glb_save(&w, path, "{\"mesh\":0}", 1, "");
    bake("ao uv3.glb -o uv3-ao.glb --set image_side=64");                /* one image each: two materials */
    assert_int_equal(run("bake", "ao plane.glb -o x.glb --set into=texture"), 1);
    assert_non_null(strstr(output, "no UV set without overlaps"));
}

static void same_bytes(const char *a, const char *b)
{
    char line[400];
    snprintf(line, sizeof line, "cmp %s/%s %s/%s", folder, a, folder, b);
    if (system(line) != 0)
        fail_msg("%s and %s differ", a, b);
}

static void shards_parts_and_threads_give_the_same_bytes(void **state)
{
    char line[200];
    (void)state;
    need_gltf();
    save_corner("corner.glb", 1);
    bake("ao corner.glb -o whole.glb --engine csm --set side=16 --set map_side=32");
    bake("ao corner.glb -o parts.glb --engine csm --set side=16 --set map_side=32 --set parts=5 --threads 1");
    same_bytes("whole.glb", "parts.glb");
    for (int i = 1; i <= 3; i++) {
        snprintf(line, sizeof line,
                 "ao corner.glb -o ao.%dof3 --engine csm --set side=16 --set map_side=32 --shard %d/3", i, i);
        bake(line);
    }
    bake("merge -o merged.glb corner.glb ao.1of3 ao.2of3 ao.3of3");
    same_bytes("whole.glb", "merged.glb");
    assert_int_equal(run("bake", "merge -o x.glb corner.glb ao.1of3 ao.3of3"), 1);
    assert_non_null(strstr(output, "not the next part of this bake"));
    assert_int_equal(run("bake", "merge -o x.glb corner.glb ao.1of3 ao.2of3"), 1);
    assert_non_null(strstr(output, "parts are missing"));
    assert_int_equal(run("bake", "merge -o x.glb down.glb ao.1of3 ao.2of3 ao.3of3"), 1);
    assert_int_equal(run("bake", "merge -o x.glb ao.1of3"), 1);
    snprintf(line, sizeof line, "ls %s | grep -q 'x.glb\\|part-\\|tmp'", folder);
    assert_int_not_equal(system(line), 0);
}

/* One line of error, exit status 1, and no file; what was there stays. */
static void refuse(const char *what)
{
    char path[PATH_ROOM];
    struct stat status;
    const int found = run("bake", "ao bad.glb -o bad-out.glb --set side=4 --set map_side=8");
    path_of(path, "bad-out.glb");
    if (found != 1 || strncmp(output, "bake: ", 6) != 0 || strchr(output, '\n') != output + strlen(output) - 1 ||
        stat(path, &status) == 0)
        fail_msg("%s: status %d, %s", what, found, output);
}

static void hostile_models_leave_no_file(void **state)
{
    glb_writer w;
    char path[PATH_ROOM];
    uint8_t *bytes;
    uint32_t seed = 1;
    size_t size;
    FILE *file;
    (void)state;
    need_gltf();
    path_of(path, "bad.glb");
    memset(&w, 0, sizeof w);
    glb_grid(&w, 0, o, z2, x2, 2, NULL, "");
    glb_save(&w, path, "{\"mesh\":0}", 1, ",\"\\u0062ufferz\":0");
    refuse("a name with a backslash");
    glb_grid(&w, 0, o, z2, x2, 2, NULL, ",\"material\":5");
    glb_save(&w, path, "{\"mesh\":0}", 1, "");
    refuse("a material that is not there");
    glb_grid(&w, 0, o, z2, x2, 2, NULL, ",\"mode\":1");
    glb_save(&w, path, "{\"mesh\":0}", 1, "");
    refuse("lines");
    glb_grid(&w, 0, o, z2, x2, 2, NULL, "");
    glb_save(&w, path, "{\"mesh\":0}", 1, "");
    bytes = (uint8_t *)calloc(1, 65536);
    file = fopen(path, "rb");
    assert_true(bytes && file);
    size = fread(bytes, 1, 65536, file);
    fclose(file);
    for (int i = 0; i < 60; i++) {                     /* faults: either it is done, or refused in one line */
        uint8_t *copy = (uint8_t *)malloc(size);
        size_t length = size;
        int found;
        assert_non_null(copy);
        memcpy(copy, bytes, size);
        seed = seed * 1664525u + 1013904223u;
        if (i % 3 == 0) length = (seed >> 8) % size;
        else copy[(seed >> 8) % (i % 3 == 1 ? size / 2 : size)] = (uint8_t)(seed >> 3);
        file = fopen(path, "wb");
        assert_non_null(file);
        assert_int_equal(fwrite(copy, 1, length, file), length);
        fclose(file);
        free(copy);
        found = run("bake", "ao bad.glb -o bad-out.glb --set side=4 --set map_side=8 --engine csm");
        if (found != 0 && (found != 1 || strncmp(output, "bake: ", 6) != 0 ||
                           strchr(output, '\n') != output + strlen(output) - 1))
            fail_msg("fault %d: status %d, %s", i, found, output);
    }
    free(bytes);
}

/* A disk without room: the old output stays as it was, and nothing else is left. */
static void a_full_disk_leaves_the_old_output(void **state)
{
    char line[400];
    (void)state;
    need_gltf();
    save_corner("corner.glb", 0);
    bake("ao corner.glb -o old.glb --engine csm --set side=8 --set map_side=16");
    snprintf(line, sizeof line,
             "cp %s/old.glb %s/copy.glb && (ulimit -f 8; trap '' XFSZ; cd %s && case $BUILD in /*) b=$BUILD;; "
             "*) b=$OLDPWD/${BUILD:-build};; esac; $b/bake ao corner.glb -o old.glb --set side=8 --set map_side=16 "
             "--set bent=1 2> full.txt); test $? = 1 && grep -q 'bake: cannot write' %s/full.txt",
             folder, folder, folder, folder);
    assert_int_equal(system(line), 0);
    same_bytes("old.glb", "copy.glb");
    snprintf(line, sizeof line, "ls %s | grep -q tmp", folder);
    assert_int_not_equal(system(line), 0);
}

/* What --report says: the way that was taken. */
static void report_of(const char *arguments)
{
    char path[PATH_ROOM];
    FILE *file;
    bake(arguments);
    path_of(path, "report.json");
    file = fopen(path, "rb");
    assert_non_null(file);
    output[fread(output, 1, sizeof output - 1, file)] = 0;
    fclose(file);
    remove(path);
}

/* One solid object: maps. Leaves, thinner than a pixel: rays. Chessmen side by side and few directions: rays. A room
   that no ray leaves: rays, which end at once. */
static void the_library_takes_the_engine_that_is_fast_and_right(void **state)
{
    static const float inside[2][3] = { { -1, -1, -1 }, { 1, 1, 1 } };
    glb_writer w;
    char path[PATH_ROOM];
    (void)state;
    need_gltf();
    bake("model builtin:knot -o knot.glb");
    report_of("ao knot.glb -o x-knot.glb --engine csm --set side=8 --report report.json");
    assert_non_null(strstr(output, "\"engine\": \"csm\""));
    assert_non_null(strstr(output, "\"directions\": 64"));
    assert_non_null(strstr(output, "\"maps_from_rays\": null"));
    assert_true(number("build_s") > 0 && number("ask_s") > 0);
    if (!has_rays()) return;
    for (int side = 8; side <= 16; side += 8) {
        char line[200];
        snprintf(line, sizeof line, "ao knot.glb -o x-knot.glb --set side=%d --report report.json", side);
        report_of(line);
        assert_non_null(strstr(output, "\"engine\": \"csm\""));
        assert_true(number("maps_from_rays") < 0.016);
    }
    bake("model builtin:plant -o plant.glb");
    report_of("ao plant.glb -o x-plant.glb --set into=vertex --set side=16 --report report.json");
    assert_non_null(strstr(output, "\"engine\": \"embree\""));
    assert_true(number("maps_from_rays") > 0.03);
    bake("model builtin:chess -o chess.glb");
    report_of("ao chess.glb -o x-chess.glb --set into=vertex --set side=6 --report report.json");
    assert_non_null(strstr(output, "\"engine\": \"embree\""));
    assert_non_null(strstr(output, "\"maps_from_rays\": null"));
    memset(&w, 0, sizeof w);
    for (int end = 0; end < 2; end++)
        for (int k = 0; k < 3; k++) {
            float e[3][3] = { { 0 } };
            for (int j = 0; j < 3; j++) e[j][j] = end ? -2 : 2;
            glb_grid(&w, end || k, inside[end], e[end ? (k + 2) % 3 : (k + 1) % 3],
                     e[end ? (k + 1) % 3 : (k + 2) % 3], 24, NULL, "");
        }
    path_of(path, "room.glb");
    glb_save(&w, path, "{\"mesh\":0}", 1, "");
    report_of("ao room.glb -o x-room.glb --set side=16 --report report.json");
    assert_non_null(strstr(output, "\"engine\": \"embree\""));
}

/* The benchmark's brute force is another way to the same answer: both engines are within what 256 directions allow. */
static void the_benchmark_agrees_with_both_engines(void **state)
{
    const char *build = getenv("BUILD");
    char path[300];
    int rows = 0;
    (void)state;
    need_gltf();
    snprintf(path, sizeof path, "%s/bench", build && *build ? build : "build");
    if (access(path, X_OK) != 0) {                              /* sanitizers build no benchmarks */
        printf("skip: %s is not built\n", path);
        skip();
    }
    assert_int_equal(run("bench", "bake_ao --model builtin:knot --side 16 --threads 1"), 0);
    for (char *at = output, *end; (end = strchr(at, '\n')) != NULL; at = end + 1, rows++) {
        const char *error = strstr(at, "\"mean_error\": ");
        *end = 0;
        assert_non_null(error);
        printf("%s\n", strstr(at, "\"engine\""));
        if (strncmp(error + 14, "null", 4) != 0) assert_true(strtod(error + 14, NULL) < 0.015);
    }
    assert_true(rows == 1 || rows == 3);
}

static void bad_options_are_named(void **state)
{
    static const struct { const char *arguments; int status; const char *says; } bad[] = {
        { "ao", 2, "-o FILE is missing" }, { "ao a.glb b.glb -o c.glb", 2, "wrong number of files" },
        { "ao a.glb -o c.glb --set into=paint", 2, "auto|vertex|texture" },
        { "ao a.glb -o c.glb --engine optix", 2, "auto|csm|embree" },
        { "ao a.glb -o c.glb --set node=a", 2, "unknown key" }, { "ao a.glb -o c.glb --env sky.hdr", 2, "unknown option" },
        { "ao a.glb -o c.glb --set parts=2 --shard 1/2", 2, "parts=N is for a bake without --shard" },
        { "ao a.glb -o c.glb --report", 2, "no value" }, { "light a.glb -o c.glb --report x", 2, "unknown option" },
        { "ao none.glb -o c.glb", 1, "cannot read none.glb" }, { "csm builtin:knot -o c --engine csm", 2, "unknown option" } };
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const int status = run("bake", bad[i].arguments);
        if (status != bad[i].status || !strstr(output, bad[i].says))
            fail_msg("bake %s: status %d, %s", bad[i].arguments, status, output);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_plane_is_white),
        cmocka_unit_test(a_wall_shades_the_floor_by_lamberts_formula),
        cmocka_unit_test(the_distance_ends_occlusion_and_a_ground_adds_it),
        cmocka_unit_test(all_else_stays),
        cmocka_unit_test(bent_normals_lean_away),
        cmocka_unit_test(objects_whose_charts_do_not_overlap_get_images),
        cmocka_unit_test(shards_parts_and_threads_give_the_same_bytes),
        cmocka_unit_test(hostile_models_leave_no_file),
        cmocka_unit_test(a_full_disk_leaves_the_old_output),
        cmocka_unit_test(the_library_takes_the_engine_that_is_fast_and_right),
        cmocka_unit_test(the_benchmark_agrees_with_both_engines),
        cmocka_unit_test(bad_options_are_named),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
