/* shadowfield_render_test - `render --technique shadowfield` as a user calls it, where time passes: a video that shines
   beside the reference, meshes that deform, lamps that alone move. */
#define _POSIX_C_SOURCE 200809L
#include "program.h"

/* Small fields: this is about what follows the time, not about quality. */
#define SMALL " --set position_side=2 --set shell_count=3 --set point_spacing=0.1"

/* Where render kept the first frame's field, the mean was 1.37 at frame 8 (and 26 at frame 40). 0.15: frames 8 and 16
   with fields this small are off by 0.01 and 0.09, frame 40 with position_side=6 by 0.02. */
static void video_follows_time(void **state)
{
    static const char scene[] = "--scene builtin:explosion --size 64x36 --frames 8 --out";
    char line[400];
    (void)state;
    need_reference();
    snprintf(line, sizeof line, "--technique reference --samples 256 %s ref.pfm", scene);
    expect(0, "", line);
    snprintf(line, sizeof line, "--technique shadowfield %s a.pfm" SMALL " --set source_position_side=3 "
             "--set source_shell_count=6", scene);
    expect(0, "", line);
    assert_int_equal(run("compare", "a.pfm ref.pfm"), 0);
    printf("frame 8 of a blast: mean_ratio %.3f\n", number("mean_ratio"));
    assert_true(number("mean_ratio") > 0.85 && number("mean_ratio") < 1.15);
}

/* As it hangs at the start a cloth is a mesh like others; fields of another time would be wrong. */
static void deforming_meshes_are_refused(void **state)
{
    (void)state;
    expect(0, "", "--technique shadowfield --scene builtin:cloth --size 32x18 --out a.pfm" SMALL);
    expect(1, "shadowfield: object cloth deforms",
           "--technique shadowfield --scene builtin:cloth --size 32x18 --frames 2 --out a.pfm" SMALL);
}

/* Under a sky, while two lamps circle: what hides the lights is taken from the last frame, and the picture stays. */
static void lazy_frames_are_the_same(void **state)
{
    static const char scene[] = "--technique shadowfield --scene builtin:knot --set still=1 --env builtin:overcast "
                                "--size 32x18 --set position_side=2 --set shell_count=3 --set point_spacing=0.4";
    char line[400];
    (void)state;
    snprintf(line, sizeof line, "%s --set lamp_count=2 --frames 3 --out a.pfm", scene);
    expect(0, "", line);
    snprintf(line, sizeof line, "%s --set lamp_count=2 --out first.pfm", scene);
    expect(0, "", line);
    snprintf(line, sizeof line, "%s --set lamp_count=2 --frames 3 --set lazy=1 --out b.pfm --json -", scene);
    expect(0, "", line);
    printf("points times lights that were kept: %.0f of %.0f\n", number("reused"), 3 * number("points"));
    assert_true(number("reused") > 0.9 * 3 * number("points"));      /* a lamp may have passed the knot's middle */
    assert_true(number("cache_bytes") > 0);
    assert_int_equal(run("compare", "b.pfm a.pfm"), 0);
    assert_true(number("relative_rmse") < 1e-4);     /* of 16 bits, in which it is kept */
    assert_int_equal(run("compare", "a.pfm first.pfm"), 0);
    assert_true(number("relative_rmse") > 1e-3);
    snprintf(line, sizeof line, "%s --set lazy=1 --set materials=full --out a.pfm", scene);
    expect(0, "", line);
    snprintf(line, sizeof line, "%s --set materials=full --out b.pfm", scene);
    expect(0, "", line);
    assert_int_equal(run("compare", "a.pfm b.pfm"), 0);
    assert_true(number("relative_rmse") < 0.01);
}

/* A knot of rough metal: glTF's BRDF, in both bases, is nearer to the reference than Phong's lobe. */
static void metal_is_as_in_the_reference(void **state)
{
    static const char scene[] = "--scene builtin:knot --env builtin:overcast --size 64x36 --set materials=full "
                                "--set roughness=0.6 --set metallic=1";
    static const char *const ways[3] = { "gloss=gltf", "gloss=phong", "basis=haar" };
    double off[3];
    char line[500];
    (void)state;
    need_reference();
    snprintf(line, sizeof line, "--technique reference --set only=direct --samples 192 %s --out ref.pfm", scene);
    expect(0, "", line);
    for (int i = 0; i < 3; i++) {
        snprintf(line, sizeof line, "--technique shadowfield %s --set position_side=%d --set shell_count=%d "
                 "--set point_spacing=0.1 --set %s --out a.pfm", scene, i < 2 ? 4 : 2, i < 2 ? 6 : 4, ways[i]);
        expect(0, "", line);
        assert_int_equal(run("compare", "a.pfm ref.pfm"), 0);
        off[i] = number("relative_rmse");
        printf("metal, %s: relative rmse %.4f\n", ways[i], off[i]);
    }
    assert_true(off[0] < 0.06 && off[1] > 1.3 * off[0] && off[2] < 0.12);
}

static void baked_fields_are_used(void **state)
{
    static const char scene[] = "--technique shadowfield --scene builtin:knot --env builtin:overcast --size 32x18 "
                                "--set shell_count=3 --set point_spacing=0.4";
    char line[400];
    (void)state;
    if (run("bake", "shadowfield builtin:knot -o knot.sf --set shell_count=3 --set position_side=4") != 0)
        fail_msg("%s", output);
    snprintf(line, sizeof line, "%s --set position_side=4 --out built.pfm", scene);
    expect(0, "", line);
    snprintf(line, sizeof line, "%s --set position_side=2 --baked knot.sf --out baked.pfm", scene);
    expect(0, "", line);
    snprintf(line, sizeof line, "%s --set position_side=2 --out other.pfm", scene);
    expect(0, "", line);
    assert_int_equal(run("compare", "baked.pfm built.pfm"), 0);
    assert_true(number("relative_rmse") <= 0);
    assert_int_equal(run("compare", "other.pfm built.pfm"), 0);
    assert_true(number("relative_rmse") > 1e-4);
    snprintf(line, sizeof line, "%s --set bands=3 --baked knot.sf --out x.pfm", scene);
    expect(1, "these bands", line);
    expect(1, "another object",
           "--technique shadowfield --scene builtin:plant --size 32x18 --baked knot.sf --out x.pfm" SMALL);
}

/* A square lamp that shines up and down, 2 over a floor, both of 2 x 2; its radiance is 8, 8 green, 8. */
static void write_lamp(const char *name, double green)
{
    char path[256];
    FILE *file;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    file = fopen(path, "wb");
    assert_non_null(file);
    fprintf(file, "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":60,"
        "\"uri\":\"data:application/octet-stream;base64,"
        "AACAvwAAAAAAAIC/AACAvwAAAAAAAIA/AACAPwAAAAAAAIA/AACAPwAAAAAAAIC/AAABAAIAAAACAAMA"
        "\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48,\"byteLength\":12}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
        "{\"bufferView\":1,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}],"
        "\"extensionsUsed\":[\"KHR_materials_emissive_strength\"],\"materials\":[{\"doubleSided\":true,"
        "\"emissiveFactor\":[1,%g,1],\"extensions\":{\"KHR_materials_emissive_strength\":{\"emissiveStrength\":8}}}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]},"
        "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}],"
        "\"nodes\":[{\"name\":\"lamp\",\"mesh\":0,\"translation\":[0,2,0]},{\"name\":\"floor\",\"mesh\":1}],"
        "\"scenes\":[{\"nodes\":[0,1]}],\"scene\":0}", green);
    assert_int_equal(fclose(file), 0);
}

static void bake(const char *arguments)
{
    if (run("bake", arguments) != 0) fail_msg("bake %s: %s", arguments, output);
}

#define LAMP "--technique shadowfield --size 48x27 --camera 0,1.4,3.5,0,0.2,0,40 --set ground=0 " \
             "--set point_spacing=0.1 --set shell_count=4 "

/* Of one lamp: with what bake wrote the picture is that of what render builds, to the bit; of another lamp the file is
   refused. position_side=2 would give another picture. */
static void baked_sources_are_used(void **state)
{
    static const char *const bases[] = { "sh", "haar" };
    char line[500];
    (void)state;
    if (!DAPPLE_HAVE_TINYGLTF) {
        printf("skip: needs tinygltf\n");
        skip();
    }
    write_lamp("lamp.gltf", 0.5);
    write_lamp("other.gltf", 0.45);
    for (int b = 0; b < 2; b++) {
        snprintf(line, sizeof line,
                 "shadowfield lamp.gltf -o source.sf --set kind=source --set node=lamp --set basis=%s "
                 "--set shell_count=4 --set position_side=3", bases[b]);
        bake(line);
        snprintf(line, sizeof line,
                 LAMP "--scene lamp.gltf --set basis=%s --set position_side=3 --out built.pfm --json -",
                 bases[b]);
        expect(0, "", line);
        assert_true(number("source_bytes") > 1000);
        snprintf(line, sizeof line, LAMP "--scene lamp.gltf --set basis=%s --set position_side=3 "
                 "--set source_position_side=2 --baked source.sf --out baked.pfm", bases[b]);
        expect(0, "", line);
        assert_int_equal(run("compare", "baked.pfm built.pfm"), 0);
        if (!(number("rmse") <= 0 && number("pixels") > 100)) fail_msg("%s: %s", bases[b], output);
        snprintf(line, sizeof line, LAMP "--scene lamp.gltf --set basis=%s --set position_side=3 "
                 "--set source_position_side=2 --out other.pfm", bases[b]);
        expect(0, "", line);
        assert_int_equal(run("compare", "other.pfm built.pfm"), 0);
        assert_true(number("relative_rmse") > 1e-4);
        snprintf(line, sizeof line, LAMP "--scene other.gltf --set basis=%s --set position_side=3 --baked source.sf "
                 "--out x.pfm", bases[b]);
        expect(1, "source.sf: the field of another object", line);
    }
    snprintf(line, sizeof line,
             LAMP "--scene lamp.gltf --set emitters=0 --set basis=haar --baked source.sf --out x.pfm");
    expect(1, "source.sf: the field of another object", line);
}

/* All three kinds at once, of objects that share a mesh; the points are those of render's spacing. */
static void baked_files_go_together(void **state)
{
    static const char scene[] = "--technique shadowfield --scene builtin:robots --size 32x18 --set shell_count=4 "
                                "--set point_spacing=0.2 --set position_side=3 ";
    char line[500];
    (void)state;
    bake("shadowfield builtin:robots -o body.sf --set node=body --set shell_count=4 --set position_side=3");
    bake("shadowfield builtin:robots -o bullet.sf --set kind=source --set node=bullet --set shell_count=4 "
         "--set position_side=3");
    bake("shadowfield builtin:robots -o points.sf --set kind=self --set node=body --set point_spacing=0.2");
    snprintf(line, sizeof line, "%s --out built.pfm", scene);
    expect(0, "", line);
    snprintf(line, sizeof line, "%s --baked body.sf --baked bullet.sf --baked points.sf --out baked.pfm", scene);
    expect(0, "", line);
    assert_int_equal(run("compare", "baked.pfm built.pfm"), 0);
    assert_true(number("rmse") <= 0 && number("pixels") > 100);
    snprintf(line, sizeof line, "%s --set point_spacing=0.21 --baked points.sf --out x.pfm", scene);
    expect(1, "points.sf: the field of another object", line);
    snprintf(line, sizeof line, "%s --baked points.sf --baked none.sf --out x.pfm", scene);
    expect(1, "none.sf", line);
    expect(2, "rsm reads no baked file", "--technique rsm --scene builtin:knot --baked a.csm --out x.pfm");
}

/* Lamps: with the file the picture is that of what render builds, to the bit, wherever the lamp stands and however
   bright it is; a lamp of another kind, size or direction refuses it, as it would come out otherwise. */
static void baked_lamps_are_used(void **state)
{
    static const struct { const char *lamp, *placed, *other; } rows[] = {
        { "sphere:0,0,0,0.2", "sphere:0,1.5,0.3,0.2,20", "sphere:0,1.5,0.3,0.25,20" },
        { "disc:0,0,0,0,-1,0,0.3", "disc:0,2,0,0,-1,0,0.3,20", "disc:0,2,0,1,0,0,0.3,20" },
        { "rect:0,0,0,0.4,0,0,0,0,0.2", "rect:0,2,0,0.4,0,0,0,0,0.2,20", "rect:0,2,0,0,0,0.2,0.4,0,0,20" },
        { "spot:0,0,0,0,-1,0,50 --set lamp_radius=0.1", "spot:0,2,0,0,-1,0,50,20", "spot:0,2,0,0,-1,0,90,20" } };
    static const char scene[] = "--technique shadowfield --scene builtin:knot --size 32x18 --set shell_count=4 "
                                "--set position_side=4 --set ground=1 --set lamp_radius=0.05";
    char line[500];
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        snprintf(line, sizeof line,
                 "shadowfield %s -o lamp.sf --set kind=lamp --set shell_count=4 --set position_side=4",
                 rows[i].lamp);
        bake(line);
        if (i + 1 == sizeof rows / sizeof *rows) break;
        snprintf(line, sizeof line, "%s --light %s --out built.pfm", scene, rows[i].placed);
        expect(0, "", line);
        snprintf(line, sizeof line, "%s --light %s --baked lamp.sf --out baked.pfm", scene, rows[i].placed);
        expect(0, "", line);
        assert_int_equal(run("compare", "baked.pfm built.pfm"), 0);
        if (!(number("rmse") <= 0 && number("pixels") > 100)) fail_msg("%s: %s", rows[i].lamp, output);
        snprintf(line, sizeof line, "%s --light %s --baked lamp.sf --out x.pfm", scene, rows[i].other);
        expect(1, "lamp.sf: the field of another object", line);
    }
    /* a spot's radius is render's lamp_radius times that of the scene: another one */
    snprintf(line, sizeof line, "%s --light %s --baked lamp.sf --out x.pfm", scene, rows[3].placed);
    expect(1, "lamp.sf: the field of another object", line);
}

/* The film of a fire: the file is of its first picture, and the next ones are built. */
static void baked_video_goes_on(void **state)
{
    static const char scene[] = "--technique shadowfield --scene builtin:explosion --size 32x18 "
                                "--set source_position_side=2 --set source_shell_count=3" SMALL;
    char line[500];
    (void)state;
    bake("shadowfield builtin:explosion -o fire.sf --set kind=source --set node=fire --set shell_count=3 "
         "--set position_side=2");
    for (int frames = 1; frames < 4; frames += 2) {
        snprintf(line, sizeof line, "%s --frames %d --out built.pfm", scene, frames);
        expect(0, "", line);
        snprintf(line, sizeof line, "%s --frames %d --baked fire.sf --out baked.pfm", scene, frames);
        expect(0, "", line);
        assert_int_equal(run("compare", "baked.pfm built.pfm"), 0);
        assert_true(number("rmse") <= 0 && number("pixels") > 100);
    }
}

/* All pictures of that film in one file: each frame's picture is that of a field built then, to the bit; long after the
   last one the fire is another, and the file is refused. */
static void baked_films_play(void **state)
{
    static const char scene[] = "--technique shadowfield --scene builtin:explosion --size 32x18 "
                                "--set source_position_side=2 --set source_shell_count=3" SMALL;
    char line[500];
    (void)state;
    bake("shadowfield builtin:explosion -o film.sf --set kind=source --set node=fire --set shell_count=3 "
         "--set position_side=2 --set frames=5");
    assert_int_equal(run("bake", "info film.sf"), 0);
    assert_true(number("frame_count") >= 5 && number("frame_count") <= 5);
    snprintf(line, sizeof line, "%s --frames 4 --out built.pfm --json -", scene);
    expect(0, "", line);
    snprintf(line, sizeof line, "%s --frames 4 --baked film.sf --out baked.pfm --json -", scene);
    expect(0, "", line);
    assert_int_equal(run("compare", "baked.pfm built.pfm"), 0);
    if (!(number("rmse") <= 0 && number("pixels") > 100)) fail_msg("%s", output);
    snprintf(line, sizeof line, "%s --time 1 --baked film.sf --out late.pfm", scene);
    expect(1, "film.sf: the field of another object", line);
    if (run("bake", "shadowfield builtin:explosion -o x.sf --set kind=source --set frames=3") != 1 ||
        !strstr(output, "name the node")) fail_msg("%s", output);
    if (run("bake", "shadowfield builtin:explosion -o x.sf --set frames=3") != 1 ||
        !strstr(output, "frames are of kind=source")) fail_msg("%s", output);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(video_follows_time),
                                        cmocka_unit_test(deforming_meshes_are_refused),
                                        cmocka_unit_test(lazy_frames_are_the_same),
                                        cmocka_unit_test(metal_is_as_in_the_reference),
                                        cmocka_unit_test(baked_fields_are_used),
                                        cmocka_unit_test(baked_sources_are_used),
                                        cmocka_unit_test(baked_files_go_together),
                                        cmocka_unit_test(baked_lamps_are_used),
                                        cmocka_unit_test(baked_video_goes_on),
                                        cmocka_unit_test(baked_films_play) };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
