/* lights.c - bake lights: a sky as directional lights, and a folder of skies, frame after frame, as lights that
 * persist. */
#define _POSIX_C_SOURCE 200809L
#include "bake.h"
#include "envlights.h"
#include "glb.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

const rd_key bk_lights_keys[] = {
    { "count", RD_INTEGER, NULL, 1, ENVLT_MAX_LIGHTS, "128", "lights; the same as --count" },
    { "method", RD_WORD, "variance|structured|median_cut|cdf", 0, 0, "variance", "the same as --method" },
    { "split_sun", RD_WORD, "0|1", 0, 0, "0", "1: a small bright spot is a light of its own" },
    { "hemisphere", RD_WORD, "0|1", 0, 0, "0", "1: no lights from below the horizon" },
    { NULL, RD_WORD, NULL, 0, 0, NULL, NULL }
};

typedef struct frame { char *name; envlt_light *lights; uint32_t count; } frame;

typedef struct film { frame *frames; size_t count; int is_folder; } film;

static void film_free(film *f)
{
    for (size_t i = 0; i < f->count; i++) {
        free(f->frames[i].name);
        free(f->frames[i].lights);
    }
    free(f->frames);
}

static int add_frame(film *f, const char *folder, const char *file)
{
    frame *grown = realloc(f->frames, (f->count + 1) * sizeof *grown);
    char *name = malloc(strlen(folder) + strlen(file) + 2);
    if (grown)
        f->frames = grown;
    if (!grown || !name) {
        free(name);
        return -1;
    }
    sprintf(name, "%s%s%s", folder, *folder ? "/" : "", file);
    memset(&grown[f->count], 0, sizeof *grown);
    grown[f->count++].name = name;
    return 0;
}

static int by_name(const void *a, const void *b) { return strcmp(((const frame *)a)->name, ((const frame *)b)->name); }

static int ends_with(const char *name, const char *end)
{
    const size_t n = strlen(name), m = strlen(end);
    return n > m && strcasecmp(name + n - m, end) == 0;
}

/* The sky, or all skies of a folder, by name. */
static int find_frames(film *f, const char *path, char *error)
{
    DIR *d = strncmp(path, "builtin:", 8) ? opendir(path) : NULL;
    struct dirent *e;
    int result = 0;
    if (!d)
        return add_frame(f, "", path) == 0 ? 0 : bk_fail(error, "out of memory", "");
    f->is_folder = 1;
    while ((e = readdir(d)) != NULL && result == 0)
        if (ends_with(e->d_name, ".hdr"))
            result = add_frame(f, path, e->d_name);
    closedir(d);
    if (result != 0)
        return bk_fail(error, "out of memory", "");
    if (!f->count)
        return bk_fail(error, "no .hdr in the folder ", path);
    qsort(f->frames, f->count, sizeof *f->frames, by_name);
    return 0;
}

/* Lights of a frame: new ones, or those of the frame before, which follow. */
static int light_frame(const bk_args *args, envlt_lights **lights, frame *f, char *error)
{
    static const char *const methods[] = { "structured", "median_cut", "variance", "cdf" };
    static const envlt_method values[] = { ENVLT_METHOD_STRUCTURED, ENVLT_METHOD_MEDIAN_CUT, ENVLT_METHOD_VARIANCE,
                                           ENVLT_METHOD_CDF };
    const rd_settings *s = &args->settings;
    envlt_desc d;
    ex_sky sky;
    envlt_map map;
    envlt_result result;
    const envlt_light *list;
    memset(&d, 0, sizeof d);
    memset(&map, 0, sizeof map);
    if ((strncmp(f->name, "builtin:", 8) ? ex_sky_load(&sky, f->name, error)
                                         : ex_sky_builtin(&sky, f->name + 8, error)) != 0)
        return -1;
    d.light_count = (uint32_t)rd_setting_integer(s, "count");
    for (int i = 0; i < 4; i++)
        if (rd_setting_is(s, "method", methods[i]))
            d.method = values[i];
    d.split_sun = rd_setting_is(s, "split_sun", "1");
    d.hemisphere = rd_setting_is(s, "hemisphere", "1");
    map.projection = ENVLT_PROJECTION_LATLONG;
    map.width = sky.width;
    map.height = sky.height;
    map.rgb = sky.rgb;
    result = *lights ? envlt_follow(*lights, &map, 0, NULL) : envlt_create(&d, &map, lights, NULL);
    ex_sky_free(&sky);
    if (result != ENVLT_OK) {
        snprintf(error, EX_ERROR_SIZE, "%.150s: %s", f->name,
                 result == ENVLT_ERR_MISMATCH ? "a sky of another size than the first" : envlt_result_text(result));
        return -1;
    }
    list = envlt_get_lights(*lights, &f->count);
    f->lights = malloc((f->count + (size_t)1) * sizeof *f->lights);
    if (!f->lights)
        return bk_fail(error, "out of memory", "");
    if (f->count)
        memcpy(f->lights, list, f->count * sizeof *list);
    return 0;
}

/* ---- files ---- */

static void add_word(bk_text *out, size_t value)
{
    uint8_t bytes[4];
    for (int i = 0; i < 4; i++)
        bytes[i] = (uint8_t)(value >> (8 * i));
    bk_text_bytes(out, bytes, 4);
}

/* A glTF document of one frame, as text or as a .glb file without a buffer. */
static void write_gltf(const frame *f, int binary, bk_text *out)
{
    const size_t bytes = envlt_gltf_bytes(f->lights, f->count), size = bytes ? bytes - 1 : 0, room = (size + 3) / 4 * 4;
    char *text = malloc(room + 4);
    if (!text || !bytes || envlt_gltf_write(f->lights, f->count, text, bytes) != ENVLT_OK) {
        out->failed = 1;
        free(text);
        return;
    }
    memset(text + size, ' ', room - size);
    if (binary) {
        bk_text_add(out, "glTF");
        add_word(out, 2);
        add_word(out, 20 + room);
        add_word(out, room);
        bk_text_add(out, "JSON");
    }
    bk_text_bytes(out, text, binary ? room : size);
    free(text);
}

static void add_vector(bk_text *out, const char *name, const float *v)
{
    bk_text_add(out, ",\"%s\":[%.9g,%.9g,%.9g]", name, (double)v[0], (double)v[1], (double)v[2]);
}

/* Every frame with the name of its sky and its lights. Names lose what JSON would need a backslash for. */
static void write_json(const film *f, bk_text *out)
{
    bk_text_add(out, "{\"frames\":[");
    for (size_t i = 0; i < f->count; i++) {
        bk_text_add(out, "%s\n{\"sky\":\"", i ? "," : "");
        for (const char *c = f->frames[i].name; *c; c++)
            bk_text_bytes(out, *c == '"' || *c == '\\' || (unsigned char)*c < 32 ? "?" : c, 1);
        bk_text_add(out, "\",\"lights\":[");
        for (uint32_t k = 0; k < f->frames[i].count; k++) {
            const envlt_light *l = &f->frames[i].lights[k];
            bk_text_add(out, "%s\n {\"id\":%u,\"sun\":%s", k ? "," : "", (unsigned)l->id,
                        l->flags & ENVLT_LIGHT_SUN ? "true" : "false");
            add_vector(out, "direction", l->direction);
            add_vector(out, "irradiance", l->irradiance);
            add_vector(out, "axis_u", l->axis_u);
            add_vector(out, "axis_v", l->axis_v);
            bk_text_add(out, ",\"solid_angle\":%.9g}", (double)l->solid_angle);
        }
        bk_text_add(out, "]}");
    }
    bk_text_add(out, "]}\n");
}

static int write_text(bk_text *text, const char *path, char *error)
{
    int result = text->failed ? bk_fail(error, "out of memory", "") : bk_write(path, text->bytes, text->size, error);
    free(text->bytes);
    memset(text, 0, sizeof *text);
    return result;
}

/* OUT.json holds all frames; OUT.glb and OUT.gltf one, which of a folder is OUT-0001.glb and so on. */
static int write_files(const film *f, const char *path, char *error)
{
    const int binary = ends_with(path, ".glb");
    const size_t stem = strlen(path) - (binary ? 4 : 5);
    bk_text text = { NULL, 0, 0, 0 };
    int result = 0;
    if (ends_with(path, ".json")) {
        write_json(f, &text);
        return write_text(&text, path, error);
    }
    for (size_t i = 0; i < f->count && result == 0; i++) {
        char *name = malloc(strlen(path) + 16);
        if (!name)
            return bk_fail(error, "out of memory", "");
        strcpy(name, path);
        if (f->is_folder)
            sprintf(name + stem, "-%04u%s", (unsigned)i + 1, path + stem);
        write_gltf(&f->frames[i], binary, &text);
        result = write_text(&text, name, error);
        free(name);
    }
    return result;
}

int bk_lights_run(const bk_args *args, char *error)
{
    film f;
    envlt_lights *lights = NULL;
    int result;
    memset(&f, 0, sizeof f);
    if (!ends_with(args->out, ".glb") && !ends_with(args->out, ".gltf") && !ends_with(args->out, ".json"))
        return bk_fail(error, "the name must end in .glb, .gltf or .json: ", args->out);
    result = find_frames(&f, args->files[0], error);
    for (size_t i = 0; i < f.count && result == 0; i++)
        result = light_frame(args, &lights, &f.frames[i], error);
    if (result == 0)
        result = write_files(&f, args->out, error);
    envlt_free(lights);
    film_free(&f);
    return result;
}
