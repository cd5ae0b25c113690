/* glb_mutations_test - render and bake with .glb files in which something was changed: numbers that are huge, negative
   or none, text that is cut out or stands twice, bytes that flip. Each command does what it is told or refuses in one
   line that a terminal can show, and none crashes or goes on for ever. GLB_MUTATIONS: how many of each command. */
#define _POSIX_C_SOURCE 200809L
#include "program.h"
#include "glb.h"

enum { JSON_ROOM = 1 << 16, PATH_ROOM = 200 };

static uint32_t seed;
static uint32_t below(uint32_t n)
{
    seed = seed * 1664525u + 1013904223u;
    return (seed >> 8) % n;
}

/* Two objects, one of them with charts, a textureless material, a lamp, a camera and an animation. */
static void save_model(const char *path)
{
    static const float o[3] = { -1, 0, -1 }, x[3] = { 2, 0, 0 }, z[3] = { 0, 0, 2 }, up[3] = { 0, 1.5f, 0 },
                       uv[3] = { 0.1f, 0.1f, 0.8f }, times[2] = { 0, 1 }, places[6] = { 0, 0, 0, 0.2f, 0, 0 };
    glb_writer w;
    int input, output_at;
    char more[2000];
    memset(&w, 0, sizeof w);
    glb_grid(&w, 0, o, z, x, 3, uv, ",\"material\":0");
    glb_grid(&w, 0, o, up, x, 2, NULL, ",\"material\":1");
    input = glb_add(&w, times, sizeof times, 5126, 2, "SCALAR");
    output_at = glb_add(&w, places, sizeof places, 5126, 2, "VEC3");
    snprintf(more, sizeof more,
             ",\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.8,0.7,0.6,1],\"metallicFactor\":0,"
             "\"roughnessFactor\":0.9}},{\"emissiveFactor\":[0.5,0.4,0.3],\"doubleSided\":true,\"alphaMode\":\"MASK\","
             "\"alphaCutoff\":0.4}],\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.8,\"znear\":0.1,"
             "\"aspectRatio\":1.5}}],\"extensionsUsed\":[\"KHR_lights_punctual\"],\"extensions\":{"
             "\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\",\"intensity\":40,\"color\":[1,0.9,0.8]}]}},"
             "\"animations\":[{\"samplers\":[{\"input\":%d,\"output\":%d,\"interpolation\":\"LINEAR\"}],\"channels\":"
             "[{\"sampler\":0,\"target\":{\"node\":1,\"path\":\"translation\"}}]}]", input, output_at);
    glb_save(&w, path,
             "{\"mesh\":0},{\"mesh\":1,\"translation\":[0,0.1,0.5],\"rotation\":[0,0.1,0,0.995],\"scale\":[1,1,1]},"
             "{\"camera\":0,\"translation\":[0,2,5]},{\"translation\":[0,3,1],\"extensions\":{\"KHR_lights_punctual\":"
             "{\"light\":0}}}", 4, more);
}

/* Puts text in place of `cut` bytes at a place of the JSON. */
static void put(char *json, size_t at, size_t cut, const char *text)
{
    const size_t size = strlen(json), length = strlen(text);
    if (cut > size - at) cut = size - at;
    if (size - cut + length + 8 > JSON_ROOM) return;
    memmove(json + at + length, json + at + cut, size - at - cut + 1);
    memcpy(json + at, text, length);
}

/* Another number in place of one that stands there, or in place of its digits. */
static void change_number(char *json)
{
    static const char *const numbers[] = { "-1", "0", "1e38", "-3e38", "1e308", "4294967295", "4294967296",
                                           "2147483647", "18446744073709551616", "0.5", "1e-300", "7", "255", "65536",
                                           "null", "[]", "\"3\"", "true", "{}", "-0.0" };
    const size_t size = strlen(json);
    size_t at = below((uint32_t)size), tried, end;
    for (tried = 0; tried < size && !strchr("0123456789", json[at]); tried++) at = (at + 1) % size;
    while (at > 0 && strchr("0123456789.-e", json[at - 1])) at--;
    for (end = at; strchr("0123456789.-e", json[end]) && json[end]; end++) {}
    put(json, at, end - at, numbers[below(sizeof numbers / sizeof *numbers)]);
}

/* Changes the file's text or its bytes, once or twice, and writes it with lengths that are true but for some. */
static void save_mutant(const glb_file *whole, const char *path)
{
    static char json[JSON_ROOM];
    uint8_t *bin = (uint8_t *)malloc(whole->bin_size);
    uint32_t head[5] = { 0x46546c67, 2, 0, 0, 0x4e4f534a }, chunk[2] = { (uint32_t)whole->bin_size, 0x004e4942 };
    uint32_t times = 1 + below(2);
    FILE *file = fopen(path, "wb");
    assert_true(bin && file && whole->json_size + 8 < JSON_ROOM);
    memcpy(json, whole->json, whole->json_size);
    json[whole->json_size] = 0;
    memcpy(bin, whole->bin, whole->bin_size);
    while (times--) {
        const size_t size = strlen(json), at = below((uint32_t)size);
        char piece[64] = { 0 };
        switch (below(8)) {
        case 0: put(json, at, 1 + below(40), ""); break;                        /* cut out */
        case 1:                                                                 /* twice */
            memcpy(piece, json + at, size - at < 60 ? size - at : 60);
            put(json, at, 0, piece);
            break;
        case 2: json[at] = (char)(1 + below(255)); break;
        case 3: bin[below((uint32_t)whole->bin_size)] ^= (uint8_t)(1u << below(8)); break;
        case 4: memset(bin + below((uint32_t)whole->bin_size - 4), 0xff, 4); break; /* not a number, the last index */
        default: change_number(json);
        }
    }
    while (strlen(json) % 4) strcat(json, " ");
    head[3] = (uint32_t)strlen(json);
    head[2] = 28 + head[3] + chunk[0];
    if (below(20) == 0) head[below(4)] ^= 1u << below(32);
    assert_int_equal(fwrite(head, 1, 20, file), 20);
    assert_int_equal(fwrite(json, 1, strlen(json), file), strlen(json));
    assert_int_equal(fwrite(chunk, 1, 8, file), 8);
    assert_int_equal(fwrite(bin, 1, whole->bin_size, file), whole->bin_size);
    assert_int_equal(fclose(file), 0);
    free(bin);
}

/* What was said: one line at most if nothing was done, and nothing that a terminal obeys. */
static void check_words(const char *program, const char *arguments, int i, int found)
{
    const char *c, *line = strchr(output, '\n');
    for (c = output; *c; c++)
        if ((unsigned char)*c < 32 && *c != '\n')
            fail_msg("mutant %d, %s %s: control character %d", i, program, arguments, *c);
    if (found == 0) return;
    if (found != 1 || !line || line[1] || strncmp(output, program, strlen(program)) != 0)
        fail_msg("mutant %d, %s %s: status %d, %s", i, program, arguments, found, output);
}

static void each_mutant_is_read_or_refused_in_a_line(void **state)
{
    static const struct { const char *program, *arguments; } commands[] = {
        { "render", "--technique rsm --scene m.glb --size 8x6 --samples 4 --set side=16 --threads 1 --out o.pfm" },
        { "render", "--technique csm --scene m.glb --size 8x6 --samples 4 --set side=4 --set map_side=8 "
                    "--set light_side=1 --set hard_map_side=16 --set light_map_side=8 --time 0.3 --threads 1 --out o.pfm" },
        { "render", "--technique ism --scene m.glb --size 8x6 --set vpl_count=8 --set surfel_count=64 "
                    "--set rsm_side=16 --set shadow_map_side=16 --set light_point_count=2 --threads 1 --out o.pfm" },
        { "bake", "csm m.glb -o o.csm --set side=4 --set map_side=8 --threads 1" },
        { "bake", "ao m.glb -o o.glb --set side=4 --set map_side=8 --engine csm --threads 1" },
        { "bake", "model m.glb -o o.glb" },
    };
    const char *more = getenv("GLB_MUTATIONS");
    const int count = more ? atoi(more) : 40;
    char path[PATH_ROOM], limited[600];
    glb_file whole;
    size_t k;
    int i, done = 0;
    (void)state;
    snprintf(path, sizeof path, "%s/m.glb", folder);
    save_model(path);
    if (run("bake", "model m.glb -o o.glb") != 0) {
        if (!strstr(output, "libtinygltf-dev")) fail_msg("the whole model: %s", output);
        print_message("skip: this build reads no .glb\n");
        skip();
    }
    glb_load(&whole, path);
    for (k = 0; k < sizeof commands / sizeof *commands; k++) {
        seed = 26;                                  /* the same files for all of them */
        snprintf(limited, sizeof limited, "%s", commands[k].arguments);
        if (run(commands[k].program, limited) != 0)
            fail_msg("the whole model, %s %s: %s", commands[k].program, limited, output);
        for (i = 0; i < count; i++) {
            int found;
            save_mutant(&whole, path);
            alarm(120);                             /* a file that goes on for ever ends the test */
            found = run(commands[k].program, limited);
            alarm(0);
            done += found == 0;
            check_words(commands[k].program, limited, i, found);
        }
        save_model(path);
    }
    print_message("%d of %d commands were done, the others refused\n", done, (int)k * count);
    assert_true(done > (int)k * count / 10 && done < (int)k * count * 9 / 10);
    glb_unload(&whole);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(each_mutant_is_read_or_refused_in_a_line) };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
