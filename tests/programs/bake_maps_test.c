/* bake_maps_test - light maps of bake light in each format, against closed forms of a sun and a lamp above a plane:
   which texel is where, harmonics of order 1, how exact each format is; names of files; what a full disk leaves. */
#define _POSIX_C_SOURCE 200809L
#include "bake.h"
#include "glb.h"
#include "scene.h"

static const float o[3] = { -1, 0, 0 }, x2[3] = { 2, 0, 0 }, z2[3] = { 0, 0, 2 };

enum { SIDE = 64 };

#define SUN "--light sun:0,3,4,2,4,6 --set samples=1 --set image_side=64 --bounces 0 "

typedef struct picture { uint32_t side; float *rgb; } picture;

/* A plane that looks up, whose chart is a square in the middle of its image. */
static void save_plane(const char *name, int n)
{
    static const float uv[3] = { 0.1f, 0.1f, 0.8f };
    glb_writer w;
    char path[PATH_ROOM];
    memset(&w, 0, sizeof w);
    path_of(path, name);
    glb_grid(&w, 0, o, z2, x2, n, uv, ",\"material\":0");
    glb_save(&w, path, "{\"mesh\":0}", 1, ",\"materials\":[{\"extras\":{\"mine\":1}}]");
}

static void need_all(void)
{
    need_reference();
    save_plane("plane.glb", 3);
    need_parser("light plane.glb -o probe.glb --set samples=1 --set image_side=16");
}

/* The JSON of a model, and the member of a material's extras up to its closing brace, into `member`. */
static void find_member(const char *model, const char *name, char member[600])
{
    glb_file f;
    char path[PATH_ROOM], key[60];
    const char *at;
    path_of(path, model);
    glb_load(&f, path);
    snprintf(key, sizeof key, "\"%s\":{", name);
    at = strstr(f.json, key);
    if (!at) fail_msg("no %s in %s", name, f.json);
    assert_non_null(strstr(f.json, "\"mine\":1"));
    at += strlen(key) - 1;
    snprintf(member, 600, "%.*s", (int)strcspn(at, "}") + 1, at);
    glb_unload(&f);
}

/* The path of the file that a member names. */
static void find_file(const char *model, const char *name, char path[PATH_ROOM])
{
    char member[600], *uri, whole[340];
    find_member(model, name, member);
    uri = strstr(member, "\"uri\":\"");
    assert_non_null(uri);
    snprintf(whole, sizeof whole, "%.*s", (int)strcspn(uri + 7, "\""), uri + 7);
    assert_non_null(strstr(whole, "-"));
    path_of(path, whole);
}

/* ---- pictures, read without the code that is tested ---- */

static uint64_t word_at(const uint8_t *p, int bytes)
{
    uint64_t word = 0;
    for (int i = bytes; i-- > 0;) word = word << 8 | p[i];
    return word;
}

static float half_at(const uint8_t *p)
{
    const int word = (int)word_at(p, 2), exponent = word >> 10 & 31;
    const float value = ldexpf((float)((word & 1023) + (exponent ? 1024 : 0)), (exponent ? exponent : 1) - 25);
    return word & 0x8000 ? -value : value;
}

static float float_at(const uint8_t *p)
{
    const uint32_t word = (uint32_t)word_at(p, 4);
    float value;
    memcpy(&value, &word, 4);
    return value;
}

/* Every attribute of the head is walked through by its size; each row is found by the table of offsets. */
static void read_exr(picture *out, const char *path, int half)
{
    uint8_t *bytes = (uint8_t *)calloc(1 << 20, 1);
    const uint8_t *at = bytes + 8;
    FILE *file = fopen(path, "rb");
    const size_t texel = half ? 2 : 4;
    size_t size;
    int seen = 0;
    assert_true(bytes && file);
    size = fread(bytes, 1, 1 << 20, file);
    fclose(file);
    assert_int_equal(word_at(bytes, 4), 20000630);
    assert_int_equal(word_at(bytes + 4, 4), 2);
    while (*at) {
        const char *name = (const char *)at, *type = name + strlen(name) + 1;
        const uint8_t *data = (const uint8_t *)type + strlen(type) + 5;
        if (strcmp(name, "channels") == 0)
            for (int k = 0; k < 3; k++, seen++) {
                assert_int_equal(data[18 * k], "BGR"[k]);
                assert_int_equal(word_at(data + 18 * k + 2, 4), half ? 1 : 2);
            }
        else if (strcmp(name, "compression") == 0) seen += *data == 0;
        else if (strcmp(name, "dataWindow") == 0) out->side = (uint32_t)word_at(data + 8, 4) + 1, seen++;
        at = data + word_at(data - 4, 4);
        assert_true((size_t)(at - bytes) < size);
    }
    assert_int_equal(seen, 5);
    out->rgb = (float *)calloc(3 * (size_t)out->side * out->side, sizeof(float));
    assert_non_null(out->rgb);
    for (size_t y = 0; y < out->side; y++) {
        const uint64_t offset = word_at(at + 1 + 8 * y, 8);
        assert_true(offset + 8 + 3 * out->side * texel <= size);
        assert_int_equal(word_at(bytes + offset, 4), y);
        assert_int_equal(word_at(bytes + offset + 4, 4), 3 * out->side * texel);
        for (size_t k = 0; k < 3; k++)
            for (size_t x = 0; x < out->side; x++) {
                const uint8_t *p = bytes + offset + 8 + ((2 - k) * out->side + x) * texel;
                out->rgb[3 * (y * out->side + x) + k] = half ? half_at(p) : float_at(p);
            }
        if (y + 1 == out->side) assert_int_equal(offset + 8 + 3 * out->side * texel, size);
    }
    free(bytes);
}

/* By stb; 0 where the programs are built without it. */
static int read_hdr(picture *out, const char *path)
{
    ex_sky sky;
    char error[EX_ERROR_SIZE];
    if (ex_sky_load(&sky, path, error) != 0) {
        if (strstr(error, "built without stb")) return 0;
        fail_msg("%s", error);
    }
    assert_int_equal(sky.width, sky.height);
    out->side = sky.width;
    out->rgb = sky.rgb;
    return 1;
}

/* The image of a member, by making it the base colour of the material: as many bytes in the place of the member. */
static void read_png(picture *out, const char *model, const char *name, int exponent)
{
    glb_file f;
    ex_scene scene;
    char path[PATH_ROOM], member[600], key[700], error[EX_ERROR_SIZE], text[700], *at;
    FILE *file;
    int index;
    path_of(path, model);
    find_member(model, name, member);
    index = glb_integer(member, "index");
    glb_load(&f, path);
    at = strstr(f.json, "\"materials\":[");
    assert_non_null(at);
    at += 13;
    snprintf(key, sizeof key, "%.*s", (int)(strstr(at, "}]") - at) + 1, at);
    snprintf(text, sizeof text, "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":%d}}}", index);
    assert_true(strlen(text) <= strlen(key));
    memset(f.bytes + 20 + (at - f.json), ' ', strlen(key));
    memcpy(f.bytes + 20 + (at - f.json), text, strlen(text));
    path_of(path, "shown.glb");
    file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(f.bytes, 1, f.size, file), f.size);
    fclose(file);
    glb_unload(&f);
    if (ex_scene_load(&scene, path, error) != 0) fail_msg("%s", error);
    assert_true(scene.texture_count >= 1);
    {
        const ex_texture *t = &scene.textures[scene.materials[scene.meshes[0].materials[0]].base_texture];
        out->side = t->width;
        out->rgb = (float *)calloc(3 * (size_t)t->width * t->height, sizeof(float));
        assert_non_null(out->rgb);
        for (size_t i = 0; i < 3 * (size_t)t->width * t->height; i++) {
            const uint8_t *p = t->rgba + 4 * (i / 3);
            out->rgb[i] = exponent ? ldexpf((float)p[i % 3], p[3] - 136) : (float)p[i % 3] / 255;
        }
    }
    ex_scene_free(&scene);
}

/* Every texel: the plane's light is even, and what is beside the chart is filled. tolerance: as a share of the largest
   channel. Frees the picture. */
static void expect_even(picture *p, const double *rgb, double tolerance)
{
    const double most = fmax(rgb[0], fmax(rgb[1], rgb[2]));
    assert_int_equal(p->side, SIDE);
    for (size_t i = 0; i < 3 * SIDE * SIDE; i++)
        if (fabs((double)p->rgb[i] - rgb[i % 3]) > tolerance * most)
            fail_msg("texel %d: %g, not %g", (int)i, (double)p->rgb[i], rgb[i % 3]);
    free(p->rgb);
}

/* ---- tests ---- */

static const double irradiance[3] = { 1.2, 2.4, 3.6 };     /* 0.6 of the sun's 2, 4, 6 */

static void every_format_holds_the_irradiance(void **state)
{
    char path[PATH_ROOM], member[600];
    picture p;
    double scaled[3], full;
    (void)state;
    need_all();
    for (int half = 0; half < 2; half++) {
        bake(half ? "light plane.glb -o a.glb " SUN "--set maps=exr"
                  : "light plane.glb -o a.glb " SUN "--set maps=exr --set bits=32");
        find_file("a.glb", "lightMapTexture", path);
        read_exr(&p, path, half);
        expect_even(&p, irradiance, half ? 5e-4 : 1e-5);
    }
    bake("light plane.glb -o a.glb " SUN "--set maps=hdr");
    find_file("a.glb", "lightMapTexture", path);
    if (read_hdr(&p, path))
        expect_even(&p, irradiance, 1.0 / 250);
    bake("light plane.glb -o a.glb " SUN "--set maps=rgbe");
    find_member("a.glb", "lightMapTexture", member);
    assert_string_equal(member, "{\"index\":0,\"encoding\":\"rgbe\"}");
    read_png(&p, "a.glb", "lightMapTexture", 1);
    expect_even(&p, irradiance, 1.0 / 250);
    bake("light plane.glb -o a.glb " SUN "--set maps=png --set bits=8");
    find_member("a.glb", "lightMapTexture", member);
    assert_non_null(strstr(member, "\"full\":"));
    full = strtod(strstr(member, "\"full\":") + 7, NULL);
    assert_true(fabs(full - 3.6 / 0.9) < 1e-3);
    for (int k = 0; k < 3; k++) scaled[k] = irradiance[k] / full;
    read_png(&p, "a.glb", "lightMapTexture", 0);
    expect_even(&p, scaled, 0.008);
}

/* Harmonic 0 is E / 0.6 times its value; those of order 1 are halves of the sun's direction, above 1/2. */
static void harmonics_of_order_1_hold_the_direction(void **state)
{
    static const double direction[3] = { 0.6, 0.8, 0 };     /* y, z, x */
    double expected[3];
    char path[PATH_ROOM], name[40];
    picture p;
    (void)state;
    need_all();
    for (int format = 0; format < 2; format++) {
        bake(format ? "light plane.glb -o a.glb " SUN "--set directional=1 --set maps=rgbe"
                    : "light plane.glb -o a.glb " SUN "--set directional=1 --set maps=exr --set bits=32");
        for (int j = 0; j < 4; j++) {
            snprintf(name, sizeof name, "lightMapSH%dTexture", j);
            for (int k = 0; k < 3; k++)
                expected[k] = j ? 0.5 + 0.5 * direction[j - 1] : 0.28209479 / 0.6 * irradiance[k];
            if (format) read_png(&p, "a.glb", name, 1);
            else {
                find_file("a.glb", name, path);
                read_exr(&p, path, 0);
            }
            expect_even(&p, expected, format ? 1.0 / 250 : 1e-5);
        }
    }
    bake("light plane.glb -o a.glb " SUN "--set directional=1 --set bits=8");
    read_png(&p, "a.glb", "lightMapSH2Texture", 0);
    expect_even(&p, (const double[3]){ 0.9, 0.9, 0.9 }, 0.005);
}

/* A lamp at (0.5, 1, 0.3): intensity h / d^3 at each texel of the chart, which is neither turned nor mirrored. Rays
   begin a little nearer to it, which 3e-4 allows for. */
static void each_texel_has_the_light_of_its_place(void **state)
{
    static const double strength[3] = { 100, 2e4, 1e-3 };
    char path[PATH_ROOM];
    (void)state;
    need_all();
    for (int format = 0; format < 3; format++) {
        static const double tolerance[3] = { 3e-4, 1e-3, 1.0 / 250 };
        char line[300];
        picture p;
        snprintf(line, sizeof line, "light plane.glb -o lamp.glb --light point:0.5,1,0.3,100,20000,0.001 "
                 "--set samples=1 --set image_side=64 --bounces 0 --set maps=%s",
                 format == 2 ? "hdr" : format ? "exr" : "exr --set bits=32");
        bake(line);
        find_file("lamp.glb", "lightMapTexture", path);
        if (format < 2) read_exr(&p, path, format);
        else if (!read_hdr(&p, path)) continue;
        for (int i = 0; i < SIDE * SIDE; i++) {
            const double u = ((i % SIDE + 0.5) / SIDE - 0.1) / 0.8, v = ((i / SIDE + 0.5) / SIDE - 0.1) / 0.8;
            const double x = -1 + 2 * v - 0.5, z = 2 * u - 0.3, expected = pow(x * x + z * z + 1, -1.5);
            if (u < 0.02 || u > 0.98 || v < 0.02 || v > 0.98) continue;
            for (int k = 0; k < (format == 2 ? 2 : 3); k++) {
                const double e = expected * strength[k], found = (double)p.rgb[3 * i + k];
                if (fabs(found - e) > tolerance[format] * (format == 2 ? 2e4 * expected : e) + (format == 1 ? 1e-7 : 0))
                    fail_msg("%s: texel %d, channel %d: %g, not %g", line, i, k, found, e);
            }
        }
        free(p.rgb);
    }
}

static int files_like(const char *pattern)
{
    char line[500];
    FILE *pipe;
    int count = 0;
    snprintf(line, sizeof line, "ls %s | grep -c -e '%s'", folder, pattern);
    pipe = popen(line, "r");
    assert_non_null(pipe);
    assert_int_equal(fscanf(pipe, "%d", &count), 1);
    pclose(pipe);
    return count;
}

/* Names say what is in a file: the same bake again writes the same, another leaves it for the old model. */
static void a_model_always_finds_its_own_maps(void **state)
{
    char path[PATH_ROOM], other[400], line[900], member[600];
    (void)state;
    need_all();
    bake("light plane.glb -o 'my room%.glb' " SUN "--set maps=exr");
    find_member("my room%.glb", "lightMapTexture", member);
    assert_non_null(strstr(member, "\"uri\":\"my%20room%25-"));
    assert_int_equal(files_like("^my room%-[0-9a-f]*.exr$"), 1);
    bake("light plane.glb -o names.glb " SUN "--set maps=exr");
    find_file("names.glb", "lightMapTexture", path);
    bake("light plane.glb -o names.glb " SUN "--set maps=exr");
    assert_int_equal(files_like("^names-.*exr$"), 1);
    bake("light plane.glb -o names.glb --light sun:0,1,0,1 --set samples=1 --set image_side=64 --set maps=exr");
    find_file("names.glb", "lightMapTexture", other);
    assert_string_not_equal(path, other);
    assert_int_equal(files_like("^names-.*exr$"), 2);
    for (int i = 1; i <= 2; i++) {
        snprintf(line, sizeof line, "light plane.glb -o %dof2 " SUN "--set maps=exr --shard %d/2", i, i);
        bake(line);
    }
    bake("merge -o merged.glb plane.glb 1of2 2of2");
    find_file("merged.glb", "lightMapTexture", other);
    snprintf(line, sizeof line, "cmp %s %s", path, other);
    assert_int_equal(system(line), 0);
}

/* Two objects with one material: each gets a copy of its own, though not one byte goes into the model's buffer. */
static void objects_that_share_a_material_get_their_own_maps(void **state)
{
    static const float uv[3] = { 0, 0, 1 };
    glb_writer w;
    glb_file f;
    char path[PATH_ROOM];
    (void)state;
    need_all();
    memset(&w, 0, sizeof w);
    path_of(path, "two.glb");
    for (int i = 0; i < 2; i++) glb_grid(&w, 0, o, z2, x2, 2, uv, ",\"material\":0");
    glb_save(&w, path, "{\"mesh\":0},{\"mesh\":1,\"translation\":[5,0,0]}", 2, ",\"materials\":[{\"name\":\"m\"}]");
    bake("light two.glb -o two-maps.glb " SUN "--set maps=exr");
    path_of(path, "two-maps.glb");
    glb_load(&f, path);
    for (int i = 1; i <= 2; i++)
        assert_memory_equal(glb_item(&f, "materials", i), "{\"extras\":{\"lightMapTexture\":{\"uri\":\"two-maps-", 46);
    assert_non_null(strstr(f.json, "\"material\":1"));
    assert_non_null(strstr(f.json, "\"material\":2"));
    assert_int_equal(glb_integer(glb_item(&f, "buffers", 0), "byteLength"), f.bin_size);
    glb_unload(&f);
}

/* No room for a map; room for the maps but not for the model: the old model and its maps stay, nothing new does. */
static void a_full_disk_leaves_the_old_model_and_its_maps(void **state)
{
    static const char *const last[2] = { "maps=exr --set bits=32", "maps=hdr" };
    char line[1200];
    (void)state;
    need_all();
    save_plane("large.glb", 40);
    bake("light large.glb -o full.glb --light sun:0,1,0,1 --set samples=1 --set image_side=16 --set maps=exr");
    snprintf(line, sizeof line, "cd %s && cat full.glb full-*.exr > full.before && ls > full.list", folder);
    assert_int_equal(system(line), 0);
    for (int i = 0; i < 2; i++) {
        snprintf(line, sizeof line,
                 "(ulimit -f 32; trap '' XFSZ; cd %s && case $BUILD in /*) b=$BUILD;; *) b=$OLDPWD/${BUILD:-build};; "
                 "esac; $b/bake light large.glb -o full.glb " SUN "--set %s 2> full.list2); test $? = 1 && cd %s && "
                 "grep -q 'bake: cannot write %s' full.list2 && test $(wc -l < full.list2) = 1 && rm full.list2 && "
                 "cat full.glb full-* | cmp - full.before && ls | cmp - full.list",
                 folder, last[i], folder, i ? "full.glb" : "full-");
        if (system(line) != 0) fail_msg("%s", line);
    }
}

static void bad_arguments_get_one_line_and_leave_no_file(void **state)
{
    static const struct { const char *arguments; int status; const char *says; } bad[] = {
        { "light plane.glb -o x.glb --set maps=tiff", 2, "png|rgbe|hdr|exr" },
        { "light plane.glb -o x.glb --set bits=32", 1, "bits=32 is of maps=exr" },
        { "light plane.glb -o x.glb --set bits=32 --set maps=hdr", 1, "bits=32 is of maps=exr" },
        { "light plane.glb -o x.glb --set bits=8 --set maps=exr", 1, "maps=exr has 16 or 32 bits" },
        { "light plane.glb -o x.glb --set directional=2", 2, "0|1" },
        { "light plane.glb -o none/x.glb --set maps=exr --set samples=1 --set image_side=16", 1, "cannot write" } };
    (void)state;
    need_all();
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const int status = run("bake", bad[i].arguments);
        if (status != bad[i].status || !strstr(output, bad[i].says) ||
            strchr(output, '\n') != output + strlen(output) - 1)
            fail_msg("bake %s: status %d, %s", bad[i].arguments, status, output);
    }
    assert_int_equal(run("bake", "light plane.glb -o x.glb --set samples=0"), 2);
    {
        char line[200];
        snprintf(line, sizeof line, "ls %s | grep -q '^x'", folder);
        assert_int_not_equal(system(line), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_format_holds_the_irradiance),
        cmocka_unit_test(harmonics_of_order_1_hold_the_direction),
        cmocka_unit_test(each_texel_has_the_light_of_its_place),
        cmocka_unit_test(a_model_always_finds_its_own_maps),
        cmocka_unit_test(objects_that_share_a_material_get_their_own_maps),
        cmocka_unit_test(a_full_disk_leaves_the_old_model_and_its_maps),
        cmocka_unit_test(bad_arguments_get_one_line_and_leave_no_file),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
