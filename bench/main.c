/* main.c - build/bench: figures of the headers, a JSON line each; docs/programs.md lists them. */
#define _POSIX_C_SOURCE 200809L
#include "bench.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

extern const char dapple_commit[], dapple_version[];

#define USAGE "bench NAME|all [--model FILE.glb|builtin:NAME] [--assets DIR] [--threads N] [--full] [--side N] " \
              "[--map-side N] [--json FILE], or bench --list"

static const struct { const char *name, *what; int (*run)(const bn_options *options);
} benches[] = {
    { "csm_compression", "size and build time of coherent shadow maps, by layers and order", bn_csm_compression },
    { "csm_query", "visibility queries a second and their errors, beside Embree", bn_csm_query },
    { "csm_scene", "queries of a forest of up to 1,024 instances", bn_csm_scene },
    { "csm_render", "pictures by csm beside the reference", bn_csm_render },
    { "bake_ao", "bake ao by maps and by Embree's rays: time of all of it, error against brute force", bn_bake_ao },
    { "rsm_gather", "bounced light by rsm: full, interpolated and denoised, beside the reference", bn_rsm_gather },
    { "rsm_maps", "a frame's map by rsm: drawn anew, kept, drawn since one object moved", bn_rsm_maps },
    { "rsm_masks", "a map by rsm of leaves: whole, and with the holes of a mask", bn_rsm_masks },
    { "gl_csm_query", "visibility queries a second on OpenGL, core and compute path", bn_gl_csm_query },
    { "gl_csm_scene", "queries of a forest of up to 1,024 instances on OpenGL", bn_gl_csm_scene },
    { "gl_csm_render", "the Monte Carlo renderer on OpenGL", bn_gl_csm_render },
    { "gl_csm_build", "maps drawn and compressed on OpenGL", bn_gl_csm_build },
    { "gl_ism", "imperfect shadow maps on OpenGL: times of the stages, difference from the CPU", bn_gl_ism },
    { "gl_envshadow", "shadow maps and light of k lights in clusters of c on OpenGL, and the cost model",
      bn_gl_envshadow },
    { "gl_sfield", "shadow fields in harmonics on OpenGL: 30,000 points, 32 occluders, 4 lamps", bn_gl_sfield },
    { "sfield_build", "shadow fields of a sphere, a lamp and a real model: time to build", bn_sfield_build },
    { "sfield_algebra", "products, rotations and dot products of spherical harmonics a second", bn_sfield_algebra },
    { "sfield_chess", "shadow fields in harmonics: 32 moving chess pieces, errors against rays", bn_sfield_chess },
    { "sfield_crowd", "shadow fields in harmonics: 1,000 bodies and 64 lamps beside 32 and 4", bn_sfield_crowd },
    { "sfield_bones", "what parts of a figure hide of points close to them, against rays", bn_sfield_bones },
    { "sfield_robots", "shadow fields in harmonics: walking robots, errors against rays", bn_sfield_robots },
    { "sfield_wavelet", "shadow fields in wavelets: spaceships, budgets, both ways of the product", bn_sfield_wavelet },
    { "sfield_accuracy", "shadows on a plane against rays, split into the steps of the method", bn_sfield_accuracy },
    { "sfield_places", "fields of a model: the paper's shells, the default's and placed ones", bn_sfield_places },
    { "envshadow_lights", "time, energy and error of k lights by each method", bn_envshadow_lights },
    { "ism", "pictures by ism beside the one-bounce reference, times of its stages", bn_ism },
    { "ism_causes", "the error of ism's pictures with one cause taken away after the other", bn_ism_causes },
    { "ism_frames", "a frame of ism by stage: the first one, the next, the next since an object moved", bn_ism_frames },
    { "ism_rivals", "what the paper compares its method with, at the processor time of ism.h", bn_ism_rivals },
    { "ism_vpls", "error at equal VPL count by flux, bidirectional and guided importance", bn_ism_vpls },
    { "ism_visibility", "visibilities that differ from Embree's, even and adaptive points", bn_ism_visibility },
    { "ism_flicker", "difference of successive frames, with and without persistence", bn_ism_flicker },
};

int bn_failed(const char *what, const char *why)
{
    fprintf(stderr, "bench: %s: %s\n", what, why);
    return -1;
}

uint32_t bn_random(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(*seed >> 32);
}

float bn_random_in(uint64_t *seed, float low, float high)
{
    return low + (high - low) * ((float)(bn_random(seed) >> 8) / 16777216.0f);
}

/* ---- lines ---- */

static char line[4096];
static size_t line_length;

static void append(const char *format, ...)
{
    va_list list;
    int written;
    va_start(list, format);
    written = vsnprintf(line + line_length, sizeof line - line_length, format, list);
    va_end(list);
    if (written > 0)
        line_length += (size_t)written;
    if (line_length >= sizeof line)
        line_length = sizeof line - 1;
}

static void append_quoted(const char *text)
{
    append("\"");
    for (; *text; text++)
        append(*text == '"' || *text == '\\' ? "\\%c" : (unsigned char)*text < 0x20 ? "\\u%04x" : "%c",
               (unsigned char)*text);
    append("\"");
}

static void append_name(const char *name)
{
    append("%s\"%s\": ", line_length ? ", " : "{", name);
}

void bn_text(const char *name, const char *value)
{
    append_name(name);
    if (value)
        append_quoted(value);
    else
        append("null");
}

void bn_number(const char *name, double value)
{
    append_name(name);
    if (!isfinite(value))
        append("null");
    else if (fabs(value) >= 1e6) /* bytes and counts are read as such, not as 1.12411e+07 */
        append("%.0f", value);
    else
        append("%.6g", value);
}

void bn_integer(const char *name, uint64_t value)
{
    append_name(name);
    append("%llu", (unsigned long long)value);
}

void bn_flag(const char *name, int value)
{
    append_name(name);
    append(value ? "true" : "false");
}

static void read_cpu_name(char *name, size_t size)
{
    FILE *file = fopen("/proc/cpuinfo", "r");
    char text[256];
    snprintf(name, size, "unknown");
    while (file && fgets(text, sizeof text, file)) {
        char *colon = strchr(text, ':');
        if (!colon || (strncmp(text, "model name", 10) != 0 && strncmp(text, "Model", 5) != 0))
            continue;
        text[strcspn(text, "\n")] = 0;
        snprintf(name, size, "%s", colon + 2);
        break;
    }
    if (file)
        fclose(file);
}

void bn_begin(const bn_options *options, const char *bench, int threads, const char *simd)
{
    static char cpu[128];
    (void)options;
    if (!cpu[0])
        read_cpu_name(cpu, sizeof cpu);
    line_length = 0;
    bn_text("bench", bench);
    bn_text("cpu", cpu);
    bn_integer("threads", (uint64_t)threads);
    bn_text("simd", simd);
    bn_text("commit", dapple_commit);
}

void bn_end(const bn_options *options)
{
    printf("%s}\n", line);
    fflush(stdout);
    if (options->json)
        fprintf(options->json, "%s}\n", line);
}

const char *bn_simd(void)
{
#if defined(COHSM_NO_SIMD)
    return "none";
#elif defined(__x86_64__) && (defined(__GNUC__) || defined(__clang__))
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("bmi2"))
        return "none";
    return __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
                   __builtin_cpu_supports("avx512vl") ? "avx512" : "avx2";
#else
    return "none";
#endif
}

/* ---- models ---- */

cohsm_mesh bn_model_mesh(const bn_model *m)
{
    cohsm_mesh mesh = { m->positions, m->vertices, 0, m->indices, 3 * m->triangles, NULL, NULL, NULL };
    return mesh;
}

cohsm_desc bn_desc(const bn_options *options)
{
    cohsm_desc desc;
    ex_pool_label(options->pool, "build");
    memset(&desc, 0, sizeof desc);
    desc.system.parallel_for = ex_pool_run;
    desc.system.progress = ex_pool_progress;
    desc.system.user = options->pool;
    return desc;
}

void bn_model_free(bn_model *model)
{
    free(model->positions);
    free(model->indices);
    memset(model, 0, sizeof *model);
}

static void add_object(bn_model *m, const ex_mesh *mesh, const float *t)
{
    for (size_t i = 0; i < mesh->vertex_count; i++)
        for (size_t k = 0; k < 3; k++) {
            const float *p = mesh->positions + 3 * i;
            float x = t[k] * p[0] + t[4 + k] * p[1] + t[8 + k] * p[2] + t[12 + k];
            m->positions[3 * (m->vertices + i) + k] = x;
            m->low[k] = fminf(m->low[k], x);
            m->high[k] = fmaxf(m->high[k], x);
        }
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++)
        m->indices[3 * m->triangles + i] = (uint32_t)m->vertices + mesh->indices[i];
    m->vertices += mesh->vertex_count;
    m->triangles += mesh->triangle_count;
}

int bn_model_flatten(bn_model *m, const ex_scene *scene, uint32_t objects)
{
    size_t vertices = 0, triangles = 0;
    memset(m, 0, sizeof *m);
    for (uint32_t i = 0; i < objects; i++) {
        vertices += scene->meshes[scene->objects[i].mesh].vertex_count;
        triangles += scene->meshes[scene->objects[i].mesh].triangle_count;
    }
    m->positions = malloc((3 * vertices + 1) * sizeof *m->positions);
    m->indices = malloc((3 * triangles + 1) * sizeof *m->indices);
    if (!m->positions || !m->indices || vertices > UINT32_MAX)
        return -1;
    for (int k = 0; k < 3; k++) {
        m->low[k] = HUGE_VALF;
        m->high[k] = -HUGE_VALF;
    }
    for (uint32_t i = 0; i < objects; i++)
        add_object(m, &scene->meshes[scene->objects[i].mesh], scene->objects[i].transform);
    return 0;
}

/* "folder/bunny.glb" and "builtin:knot" are bunny and knot. */
static void set_name(bn_model *m, const char *scene)
{
    const char *slash = strrchr(scene, '/'), *start = slash ? slash + 1 : scene;
    start = strncmp(start, "builtin:", 8) == 0 ? start + 8 : start;
    snprintf(m->name, sizeof m->name, "%.*s", (int)strcspn(start, "."), start);
}

int bn_model_load(bn_model *m, const char *scene)
{
    char error[EX_ERROR_SIZE];
    ex_scene loaded;
    int result;
    result = strncmp(scene, "builtin:", 8) == 0 ? ex_scene_builtin(&loaded, scene + 8, 0, error)
                                                : ex_scene_load(&loaded, scene, error);
    if (result != 0)
        return bn_failed(scene, error);
    result = bn_model_flatten(m, &loaded, loaded.object_count);
    set_name(m, scene);
    ex_scene_free(&loaded);
    if (result == 0)
        return 0;
    bn_model_free(m);
    return bn_failed(scene, "out of memory");
}

const char *bn_asset(const bn_options *options, const char *file, const char *other, char path[1024])
{
    const char *names[2] = { file, other };
    for (int i = 0; i < 2 && options->assets && names[i]; i++) {
        FILE *found;
        snprintf(path, 1024, "%.900s/%s", options->assets, names[i]);
        found = fopen(path, "rb");
        if (found) {
            fclose(found);
            return path;
        }
    }
    if (options->assets)
        fprintf(stderr, "bench: left out: %s has no %s%s%s\n", options->assets, file, other ? " and no " : "",
                other ? other : "");
    return NULL;
}

int bn_models_load(const bn_options *options, bn_model *models, size_t *count)
{
    static const char *const files[] = { "bunny.glb", "dragon.glb" };
    static const char *const made[] = { "builtin:knot", "builtin:plant" };
    size_t most = options->model ? 1 : 2;
    for (*count = 0; *count < most; ++*count) {
        char path[1024];
        const char *scene = options->model ? options->model : bn_asset(options, files[*count], NULL, path);
        if (!scene)
            scene = made[*count];
        if (bn_model_load(&models[*count], scene) != 0) {
            while (*count)
                bn_model_free(&models[--*count]);
            return -1;
        }
    }
    return 0;
}

/* ---- command line ---- */

static int bad_arguments(const char *what, const char *why)
{
    bn_failed(what, why);
    return 2;
}

/* A number within its limits. */
static int parse_size(const char *text, long low, long high, uint32_t *out)
{
    char *end;
    const long value = strtol(text, &end, 10);
    if (*end || end == text || value < low || value > high)
        return -1;
    *out = (uint32_t)value;
    return 0;
}

static int parse(bn_options *o, int count, char **values, const char **json)
{
    for (int i = 2; i < count; i++) {
        const char *value = i + 1 < count ? values[i + 1] : NULL;
        char *end;
        if (strcmp(values[i], "--full") == 0) {
            o->full = 1;
            continue;
        }
        if (!value)
            return bad_arguments(values[i], "unknown option, or its value is missing");
        if (strcmp(values[i], "--model") == 0) {
            o->model = value;
        } else if (strcmp(values[i], "--assets") == 0) {
            o->assets = value;
        } else if (strcmp(values[i], "--json") == 0) {
            *json = value;
        } else if (strcmp(values[i], "--threads") == 0) {
            o->threads = (int)strtol(value, &end, 10);
            if (*end || end == value || o->threads < 0 || o->threads > 256)
                return bad_arguments("--threads", "must be 0 to 256");
        } else if (strcmp(values[i], "--side") == 0) {
            if (parse_size(value, 1, 1024, &o->side) != 0)
                return bad_arguments("--side", "must be 1 to 1024");
        } else if (strcmp(values[i], "--map-side") == 0) {
            if (parse_size(value, 4, 1024, &o->m) != 0)
                return bad_arguments("--map-side", "must be 4 to 1024");
        } else {
            return bad_arguments(values[i], "unknown option");
        }
        i++;
    }
    return 0;
}

static int run(const char *name, const bn_options *options)
{
    int result = 0;
    for (size_t i = 0; i < sizeof benches / sizeof benches[0]; i++)
        if ((strcmp(name, "all") == 0 || strcmp(name, benches[i].name) == 0) && benches[i].run(options) != 0)
            result = 1;
    return result;
}

static int is_known(const char *name)
{
    for (size_t i = 0; i < sizeof benches / sizeof benches[0]; i++)
        if (strcmp(name, benches[i].name) == 0)
            return 1;
    return strcmp(name, "all") == 0;
}

int main(int count, char **values)
{
    bn_options options;
    const char *json = NULL;
    int result;
    if (count == 2 && strcmp(values[1], "--list") == 0) {
        for (size_t i = 0; i < sizeof benches / sizeof benches[0]; i++)
            printf("%-18s %s\n", benches[i].name, benches[i].what);
        return 0;
    }
    if (count == 2 && strcmp(values[1], "--help") == 0)
        return puts("usage: " USAGE " | --help | --version"), 0;
    if (count == 2 && strcmp(values[1], "--version") == 0)
        return printf("bench %s\n", dapple_version), 0;
    if (count < 2 || !is_known(values[1]))
        return bad_arguments(count < 2 ? "usage" : values[1], USAGE);
    memset(&options, 0, sizeof options);
    options.program = values[0];
    options.assets = getenv("ASSETS") && *getenv("ASSETS") ? getenv("ASSETS") : NULL;
    if (parse(&options, count, values, &json) != 0)
        return 2;
    options.pool = ex_pool_create(options.threads);
    if (!options.pool)
        return bn_failed("threads", "out of memory"), 1;
    options.threads = ex_pool_threads(options.pool);
    options.json = json ? fopen(json, "w") : NULL;
    if (json && !options.json) {
        ex_pool_free(options.pool);
        return bn_failed(json, "cannot be written"), 1;
    }
    result = run(values[1], &options);
    if (options.json && fclose(options.json) != 0)
        result = bn_failed(json, "cannot be written") != 0;
    ex_pool_free(options.pool);
    return result;
}
