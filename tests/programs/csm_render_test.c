/* csm_render_test - `render --technique csm` as a user calls it: pictures beside the reference for every kind of light,
   bytes that do not depend on threads, baked files, refusals. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>

#include "common.h"
#include "conformance.h"
#include "csm.h"
#include "program.h"
#include "masked.h"

/* csm against the reference: relative_rmse (with both pictures' noise) and the mean. */
static void compare_with_reference(const char *scene, const char *settings, double most_error, double most_mean)
{
    char arguments[768];
    double error, mean;
    snprintf(arguments, sizeof arguments, "--technique csm --scene %s --samples 256 --out csm.pfm %s", scene, settings);
    expect(0, "", arguments);
    snprintf(arguments, sizeof arguments, "--technique reference --scene %s --samples 256 --out ref.pfm", scene);
    expect(0, "", arguments);
    assert_int_equal(run("compare", "csm.pfm ref.pfm"), 0);
    error = number("relative_rmse");
    mean = number("mean_ratio") - 1;
    if (!(error <= most_error) || !(mean <= most_mean && mean >= -most_mean))
        fail_msg("%s: relative_rmse %.4f (limit %.4f), mean off by %.4f (limit %.4f)", scene, error, most_error, mean,
                 most_mean);
}

static void read_picture(ex_image *image, const char *name)
{
    char path[256], error[EX_ERROR_SIZE];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    if (ex_image_read_pfm(image, path, error) != 0)
        fail_msg("%s", error);
}

/* Does a shadow's edge pass the 3 x 3 pixels about x, y? */
static int is_edge(const ex_image *image, uint32_t x, uint32_t y)
{
    int lit = 0, dark = 0;
    for (uint32_t j = y ? y - 1 : 0; j <= y + 1 && j < image->height; j++)
        for (uint32_t i = x ? x - 1 : 0; i <= x + 1 && i < image->width; i++) {
            float value = image->rgb[3 * ((size_t)j * image->width + i)];
            lit |= value > 0;
            dark |= value == 0;
        }
    return lit && dark;
}

/* Lights without size: a pixel is the reference's to 1 %, or it lies at the edge of a shadow. An edge may be off by one
   pixel of the map, half for its pixel and half for the receiver's offset: at most 2 * 6 / 1024 = 0.012 at the knot,
   where a pixel of the picture is 0.03 wide and the edge's pixels make a strip of two or three. That would be a sixth
   of them if every edge were off by all of it; a twentieth is allowed. */
static void hard_light_matches_reference(const char *light)
{
    char arguments[512];
    uint32_t differ = 0, edge = 0, x, y;
    ex_image a, b;
    snprintf(arguments, sizeof arguments, "--technique csm --scene builtin:knot --size 128x96 --light %s --out csm.pfm",
             light);
    expect(0, "", arguments);
    snprintf(arguments, sizeof arguments, "--technique reference --scene builtin:knot --size 128x96 --samples 4 "
             "--light %s --out ref.pfm", light);
    expect(0, "", arguments);
    read_picture(&a, "csm.pfm");
    read_picture(&b, "ref.pfm");
    for (y = 0; y < b.height; y++)
        for (x = 0; x < b.width; x++) {
            const size_t at = 3 * ((size_t)y * b.width + x);
            int at_edge = is_edge(&b, x, y);
            float larger = a.rgb[at] > b.rgb[at] ? a.rgb[at] : b.rgb[at];
            edge += (uint32_t)at_edge;
            if (!(fabsf(a.rgb[at] - b.rgb[at]) > 0.01f * larger))
                continue;
            differ++;
            if (!at_edge)
                fail_msg("%s: (%u, %u) is %g, not %g, and no edge is near", light, x, y, (double)a.rgb[at],
                         (double)b.rgb[at]);
        }
    print_message("%s: %u of %u pixels at edges differ\n", light, differ, edge);
    if (edge < 50 || 20 * differ > edge)
        fail_msg("%s: %u of %u pixels at edges differ", light, differ, edge);
    ex_image_free(&a);
    ex_image_free(&b);
}

static void cornell_matches_reference(void **state)
{
    (void)state;
    need_reference();
    compare_with_reference("builtin:cornell --size 96x72", "", 0.03, 0.004);
    CONFORM_MAX("image", "Cornell box beside the reference, relative rmse", 0.03, number("relative_rmse"));
    CONFORM_MIN("image", "Cornell box beside the reference, ssim", 0.998, number("ssim"));
}

static void every_light_matches_reference(void **state)
{
    static const struct { const char *light; double most_error; } lights[] = {
        { "sphere:3,5,2,0.5,20", 0.05 }, { "rect:2,5,1,1,0,0,0,0,1,20", 0.06 },
        { "disc:3,5,2,0,-1,0,0.7,20", 0.06 }, { "line:2,5,1,4,5,1,0.05,40", 0.1 },
    };
    static const char *const hard[] = { "sun:0.48,0.8,0.36", "point:3,5,2", "spot:3,5,2,-0.48,-0.8,-0.36,50",
                                        "spot:3,5,2,-0.48,-0.8,-0.36,200" };
    (void)state;
    need_reference();
    for (size_t i = 0; i < sizeof hard / sizeof hard[0]; i++)
        hard_light_matches_reference(hard[i]);
    for (size_t i = 0; i < sizeof lights / sizeof lights[0]; i++) {
        char scene[256];
        snprintf(scene, sizeof scene, "builtin:knot --size 64x48 --light %s", lights[i].light);
        compare_with_reference(scene, "", lights[i].most_error, 0.02);
    }
}

/* A ball of fire with 16 places for each of its colours: where its own body hid what lies under it from the places
   above, a fifth of the light was lost. 0.05 is five deviations of the noise of both pictures. */
static void closed_lamps_do_not_hide_their_light(void **state)
{
    (void)state;
    need_reference();
    compare_with_reference("builtin:explosion --size 64x36", "--set light_side=4 --set light_map_side=64", 0.6, 0.05);
}

static void sky_matches_reference(void **state)
{
    (void)state;
    need_reference();
    compare_with_reference("builtin:knot --size 64x48", "--set side=64 --set filter=roulette", 0.06, 0.01);
}

/* Without the holes the shadow is twice as large. */
static void holes_of_alpha_masks_are_lit(void **state)
{
    (void)state;
    need_reference();
    need_masked();
    compare_with_reference("masked.gltf --size 64x48 --camera 0,7,6,0,0,0,45 --set ground=0 --light sun:0.3,0.9,0.2",
                           "", 0.02, 0.005);
    compare_with_reference("masked.gltf --size 64x48 --camera 0,7,6,0,0,0,45 --set ground=0 --env builtin:sky",
                           "--set side=32 --set filter=pcf", 0.06, 0.02);
    /* one object's part above another, local maps: stored depths right before the ground once let it be lit */
    compare_with_reference("masked.gltf --size 64x48 --camera 0,7,6,0,0,0,45 --set ground=0 "
                           "--light disc:1,5,1,0,-1,0,0.5,20", "", 0.12, 0.01);
}

static size_t read_file(const char *name, void *data, size_t room)
{
    char path[256];
    FILE *file;
    size_t size;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    file = fopen(path, "rb");
    assert_non_null(file);
    size = fread(data, 1, room, file);
    fclose(file);
    return size;
}

static void assert_same_files(const char *a, const char *b)
{
    static char x[200000], y[200000];
    size_t size = read_file(a, x, sizeof x);
    assert_true(size > 1000);
    assert_int_equal(size, read_file(b, y, sizeof y));
    assert_memory_equal(x, y, size);
}

#define SMALL "--technique csm --scene builtin:knot --size 48x27 --samples 32 --set side=8 --set map_side=32 "

static void threads_do_not_matter(void **state)
{
    (void)state;
    expect(0, "", SMALL "--set filter=roulette --threads 1 --out one.pfm");
    expect(0, "", SMALL "--set filter=roulette --threads 3 --out three.pfm");
    assert_same_files("one.pfm", "three.pfm");
    expect(0, "", SMALL "--light rect:2,5,1,1,0,0,0,0,1,20 --set light_side=2 --threads 1 --out one.pfm");
    expect(0, "", SMALL "--light rect:2,5,1,1,0,0,0,0,1,20 --set light_side=2 --threads 2 --out three.pfm");
    assert_same_files("one.pfm", "three.pfm");
}

static void frame_is_seed(void **state)
{
    (void)state;
    expect(0, "", SMALL "--seed 7 --out a.pfm");
    expect(0, "", SMALL "--seed 8 --out b.pfm");
    expect(0, "", SMALL "--seed 7 --out c.pfm");
    assert_same_files("a.pfm", "c.pfm");
    assert_int_equal(run("compare", "a.pfm b.pfm"), 0);
    assert_true(number("rmse") > 0);
}

static void lights_inside_hulls_are_refused(void **state)
{
    (void)state;
    expect(1, "hull", "--technique csm --scene builtin:cornell --size 32x24 --samples 16 --set light_maps=semi "
           "--set side=4 --set map_side=16 --out refused.pfm");
    expect(0, "", SMALL "--light rect:2,5,1,1,0,0,0,0,1,20 --set light_maps=semi --out semi.pfm");
}

static void bad_settings_are_bad_arguments(void **state)
{
    (void)state;
    expect(2, "side", SMALL "--set side=0 --out x.pfm");
    expect(2, "layers", SMALL "--set layers=z2 --out x.pfm");
    expect(1, "missing.csm", SMALL "--baked missing.csm --out x.pfm");
}

/* The casters of a scene in world space, as `bake` takes a file. */
static void write_baked(const char *name)
{
    char error[EX_ERROR_SIZE], path[256];
    ex_scene scene;
    cohsm_desc desc;
    cohsm_mesh mesh;
    cohsm_maps *maps;
    cohsm_info info;
    void *memory;
    FILE *file;
    assert_int_equal(ex_scene_builtin(&scene, "knot", 0, error), 0);
    assert_int_equal(scene.object_count, 1);
    memset(&desc, 0, sizeof desc);
    memset(&mesh, 0, sizeof mesh);
    desc.domain.side[0] = desc.domain.side[1] = 8;
    desc.map_side = 32;
    mesh.positions = scene.meshes[0].positions;
    mesh.vertex_count = scene.meshes[0].vertex_count;
    mesh.indices = scene.meshes[0].indices;
    mesh.index_count = 3 * (size_t)scene.meshes[0].triangle_count;
    assert_int_equal(cohsm_build(&desc, &mesh, &maps, NULL), COHSM_OK);
    cohsm_get_info(maps, &info);
    memory = malloc(info.bytes);
    assert_non_null(memory);
    assert_int_equal(cohsm_write(maps, memory, info.bytes), COHSM_OK);
    snprintf(path, sizeof path, "%s/%s", folder, name);
    file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(memory, 1, info.bytes, file), info.bytes);
    assert_int_equal(fclose(file), 0);
    free(memory);
    cohsm_free(maps);
    ex_scene_free(&scene);
}

static void baked_file_is_used(void **state)
{
    (void)state;
    write_baked("knot.csm");
    expect(0, "", SMALL "--out built.pfm");
    expect(0, "", SMALL "--baked knot.csm --out baked.pfm");
    assert_int_equal(run("compare", "built.pfm baked.pfm"), 0);
    assert_true(number("relative_rmse") < 1e-3);
    expect(0, "", SMALL "--baked knot.csm --set layout=fast --out fast.pfm --json -");
    assert_true(number("fast_bytes") > 0);
    assert_int_equal(run("compare", "fast.pfm baked.pfm"), 0);
    assert_true(!(number("relative_rmse") > 0));
    expect(1, "another object",
           "--technique csm --scene builtin:plant --size 32x24 --samples 4 --baked knot.csm --out x.pfm");
    expect(1, "no light", SMALL "--baked knot.csm --light sun:0,1,0 --out x.pfm");
}

static void write_text(const char *name, const char *text)
{
    char path[256];
    FILE *file;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    file = fopen(path, "wb");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

/* With what bake made of places on a light the picture is that of what render builds, to the bit; maps of other places
   are refused, with the domain that the light wants. */
static void same_as_baked(const char *bake, const char *render, const char *settings)
{
    char line[768];
    snprintf(line, sizeof line, "csm %s -o places.csm", bake);
    if (run("bake", line) != 0) fail_msg("bake %s: %s", line, output);
    snprintf(line, sizeof line, "%s %s --set order=hilbert --out built.pfm --json -", render, settings);
    expect(0, "", line);
    snprintf(line, sizeof line, "%s %s --baked places.csm --out baked.pfm --json -", render, settings);
    expect(0, "", line);
    assert_int_equal(run("compare", "baked.pfm built.pfm"), 0);
    if (!(number("rmse") <= 0 && number("pixels") > 100)) fail_msg("%s: %s", bake, output);
}

static void baked_places_are_used(void **state)
{
#define PLACES "--set light_side=3 --set light_map_side=32"
#define BAKED " --set side=3 --set map_side=32"
    (void)state;
    same_as_baked("builtin:knot --domain sphere:1,4,1,0.4" BAKED, SMALL "--light sphere:1,4,1,0.4,20", PLACES);
    same_as_baked("builtin:knot --domain disc:1,4,1,0.5,0,0,0,0,0.5" BAKED, SMALL,
                  PLACES " --light disc:1,4,1,0,-1,0,0.5,20");
    same_as_baked("builtin:knot --domain rectangle:1,4,1,1,0,0,0,0,1" BAKED, SMALL,
                  PLACES " --light rect:1,4,1,1,0,0,0,0,1,20");
    /* other sides than the settings say: the file's count */
    expect(0, "", SMALL "--light rect:1,4,1,1,0,0,0,0,1,20 --set light_side=2 --baked places.csm --out other.pfm");
    assert_int_equal(run("compare", "baked.pfm other.pfm"), 0);
    assert_true(!(number("rmse") > 0));
    expect(1, "places.csm: maps of places where no light is: a light wants --domain rectangle:1,4.25,1,1,0,0,0,0,1",
           SMALL "--light rect:1,4.25,1,1,0,0,0,0,1,20 --baked places.csm --out x.pfm");
    expect(1, "a light wants --domain sphere:0,4,0,0.5",
           SMALL "--light sphere:0,4,0,0.5,20 --baked places.csm --out x.pfm");
    expect(1, "another object",
           "--technique csm --scene builtin:plant --size 32x24 --samples 4 --baked places.csm --out x.pfm");
    write_text("place.txt", "1 4 1 1\n");
    same_as_baked("builtin:knot --domain list:place.txt --set map_side=64", SMALL "--light point:1,4,1,20",
                  "--set hard_map_side=64");
    expect(1, "a light wants --domain list: of one place, 1 5 1 1",
           SMALL "--light point:1,5,1,20 --baked places.csm --out x.pfm");
    if (run("bake", "csm builtin:knot --domain rectangle:1,4,1,1,0,0,0,0,1 -o places.csm" BAKED) != 0) fail();
    /* beside maps of directions, in any order */
    write_baked("knot.csm");
    expect(0, "", SMALL "--env builtin:sky --light rect:1,4,1,1,0,0,0,0,1,20 --baked places.csm --baked knot.csm "
           "--out both.pfm --json -");
    assert_true(number("blocks") >= 2 && number("blocks") <= 2);
#undef PLACES
#undef BAKED
}

/* An octahedron that shines, 2 above a floor of 4 x 4 with a small sheet between them. */
static void write_octahedron(const char *name)
{
    char path[256];
    FILE *file;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    file = fopen(path, "wb");
    assert_non_null(file);
    fprintf(file, "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":180,"
        "\"uri\":\"data:application/octet-stream;base64,"
        "AACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AACAvwAAAAAAAAAAAAAAAAAAgL8AAAAAAAAAAAAAAAAAAIC/AACAvwAA"
        "AAAAAIC/AACAvwAAAAAAAIA/AACAPwAAAAAAAIA/AACAPwAAAAAAAIC/AAAFAAEAAQACAAAAAAACAAQAAAAEAAUAAwACAAEAAQAFAAMA"
        "BAACAAMAAwAFAAQAAAABAAIAAAACAAMA"
        "\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":72},{\"buffer\":0,\"byteOffset\":72,\"byteLength\":48},"
        "{\"buffer\":0,\"byteOffset\":120,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":168,\"byteLength\":12}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":6,\"type\":\"VEC3\"},"
        "{\"bufferView\":1,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
        "{\"bufferView\":2,\"componentType\":5123,\"count\":24,\"type\":\"SCALAR\"},"
        "{\"bufferView\":3,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}],"
        "\"materials\":[{\"emissiveFactor\":[1,1,1]}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":2,\"material\":0}]},"
        "{\"primitives\":[{\"attributes\":{\"POSITION\":1},\"indices\":3}]}],"
        "\"nodes\":[{\"mesh\":0,\"translation\":[0,2,0],\"scale\":[0.3,0.3,0.3]},{\"mesh\":1,\"scale\":[2,2,2]},"
        "{\"mesh\":1,\"translation\":[0.2,0.8,0],\"scale\":[0.3,0.3,0.3]}],"
        "\"scenes\":[{\"nodes\":[0,1,2]}],\"scene\":0}");
    assert_int_equal(fclose(file), 0);
}

/* The places of bake are those that lightsampling.h gives render's light. */
static void baked_emissive_mesh_is_used(void **state)
{
    (void)state;
    if (!DAPPLE_HAVE_TINYGLTF) {
        printf("skip: needs tinygltf\n");
        skip();
    }
    write_octahedron("lamp.gltf");
    same_as_baked("lamp.gltf --domain emissive --set side=4 --set map_side=64",
                  "--technique csm --scene lamp.gltf --size 48x36 --samples 16",
                  "--set light_side=4 --set light_map_side=64 --set lamp_shadow=own");
    expect(1, "a light wants --domain emissive, 9 places",
           "--technique csm --scene lamp.gltf --size 48x36 --samples 16 --set light_side=3 --baked places.csm --out x.pfm");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cornell_matches_reference), cmocka_unit_test(every_light_matches_reference),
        cmocka_unit_test(closed_lamps_do_not_hide_their_light),
        cmocka_unit_test(sky_matches_reference), cmocka_unit_test(holes_of_alpha_masks_are_lit),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(frame_is_seed), cmocka_unit_test(lights_inside_hulls_are_refused),
        cmocka_unit_test(bad_settings_are_bad_arguments), cmocka_unit_test(baked_file_is_used),
        cmocka_unit_test(baked_places_are_used), cmocka_unit_test(baked_emissive_mesh_is_used),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
