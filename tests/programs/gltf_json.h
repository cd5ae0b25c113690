/* gltf_json.h - glTF files that a test writes as JSON, with one buffer of bytes that it has put before. For one test
   program: after cmocka.h, common.h, math.h, stdio.h, stdlib.h, string.h and unistd.h. */
#ifndef GLTF_JSON_H
#define GLTF_JSON_H

#define assert_near(a, b, tolerance) assert_true(fabs((double)(a) - (double)(b)) <= (tolerance))

static char folder[40], file_name[64];

static int make_file(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/dapple_gltf_XXXXXX");
    if (!mkdtemp(folder)) return -1;
    snprintf(file_name, sizeof file_name, "%s/a.gltf", folder);
    return 0;
}

static int remove_file(void **state)
{
    (void)state;
    unlink(file_name);
    return rmdir(folder);
}

/* ---- writing small files ---- */

static uint8_t bytes[4096];
static size_t byte_count;

static void put(const void *data, size_t size)
{
    assert_true(byte_count + size <= sizeof bytes);
    memcpy(bytes + byte_count, data, size);
    byte_count += size;
}

static void base64(FILE *file)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < byte_count; i += 3) {
        uint32_t left = (uint32_t)(byte_count - i), v = (uint32_t)bytes[i] << 16;
        if (left > 1) v |= (uint32_t)bytes[i + 1] << 8;
        if (left > 2) v |= bytes[i + 2];
        fprintf(file, "%c%c%c%c", digits[v >> 18], digits[v >> 12 & 63], left > 1 ? digits[v >> 6 & 63] : '=',
                left > 2 ? digits[v & 63] : '=');
    }
}

/* Writes the bytes put so far as the one buffer, `json` as the rest, and loads the file. */
static int load_json(ex_scene *scene, char *error, const char *json)
{
    FILE *file = fopen(file_name, "wb");
    assert_non_null(file);
    fprintf(file, "{\"asset\":{\"version\":\"2.0\"},");
    if (byte_count) {
        fprintf(file, "\"buffers\":[{\"byteLength\":%u,\"uri\":\"data:application/octet-stream;base64,",
            (unsigned)byte_count);
        base64(file);
        fprintf(file, "\"}],");
    }
    fprintf(file, "%s}", json);
    assert_int_equal(fclose(file), 0);
    memset(error, 0, EX_ERROR_SIZE);
    int result = ex_scene_load(scene, file_name, error);
    if (result != 0) {
        assert_true(strlen(error) > 0 && strlen(error) < EX_ERROR_SIZE);
        assert_null(strchr(error, '\n'));
        assert_null(scene->meshes);
        assert_int_equal(scene->object_count, 0);
    }
    return result;
}

static void skip_without_parser(void)
{
    char error[EX_ERROR_SIZE];
    ex_scene scene;
    byte_count = 0;
    if (load_json(&scene, error, "\"nodes\":[]") != 0 && strstr(error, "libtinygltf-dev")) skip();
}

#endif
