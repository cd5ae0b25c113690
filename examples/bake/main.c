/* main.c - the program `bake`: what can be precomputed of one rigid object, into a file. docs/programs.md is its
   definition, docs/bake.md tells how to spread it over processes and machines.

   A long bake is done in parts, each kept beside the output as soon as it is whole (OUT.part-KEY-1of4: KEY stands for
   mesh and settings); the same command again goes on where it was stopped. */
#include "bake.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

extern const char dapple_version[];        /* of CHANGELOG.md, by the Makefile */

enum { DONE = 0, FAILED = 1, BAD_ARGUMENTS = 2 };
enum { MOST_PARTS = 256, LINE = 1024 };
#define SECONDS_OF_A_PART 60.0

static const rd_key common_keys[] = {
    { "node", RD_WORD, NULL, 0, 0, "", "bake this node alone, in its own space; else the whole file as one object" },
    { "parts", RD_INTEGER, NULL, 0, MOST_PARTS, "0", "parts kept on the way, not of a shard; 0: about one a minute" },
    { NULL, RD_WORD, NULL, 0, 0, NULL, NULL }
};

/* ---- commands ---- */

typedef struct bk_command {
    const char *name;
    const bk_technique *technique;      /* of those that bake one object into a file of their own */
    const rd_key *keys;                 /* of the others */
    size_t least, most;                 /* files */
    int    writes, shares;              /* it has an output; it can be one of many shards */
    int    has_sky;                     /* --env and --light are for it */
    int  (*run)(const bk_args *args, char *error);
} bk_command;

static int run_bake(const bk_args *args, char *error);
static int run_merge(const bk_args *args, char *error);
static int run_info(const bk_args *args, char *error);
static int run_verify(const bk_args *args, char *error);

static const bk_command commands[] = {
    { "csm", &bk_csm, NULL, 1, 1, 1, 1, 0, run_bake },
    { "shadowfield", &bk_shadowfield, NULL, 1, 1, 1, 1, 0, run_bake },
    { "ao", NULL, bk_ao_keys, 1, 1, 1, 1, 0, bk_ao_run },
    { "model", NULL, bk_model_keys, 1, 1, 1, 0, 0, bk_model_run },
    { "light", NULL, bk_light_keys, 1, 1, 1, 1, 1, bk_light_run },
    { "probes", NULL, bk_probes_keys, 1, 1, 1, 1, 1, bk_probes_run },
    { "lights", NULL, bk_lights_keys, 1, 1, 1, 0, 0, bk_lights_run },
    { "merge", &bk_csm, NULL, 1, BK_MOST_FILES, 1, 0, 0, run_merge },
    { "info", &bk_csm, NULL, 1, 1, 0, 0, 0, run_info },
    { "verify", &bk_csm, NULL, 2, 2, 0, 0, 0, run_verify }
};

enum { COMMANDS = sizeof commands / sizeof *commands };

static const bk_command *command_of(const char *name)
{
    for (size_t i = 0; i < COMMANDS; i++)
        if (strcmp(name, commands[i].name) == 0)
            return &commands[i];
    return NULL;
}

static void print_help(void)
{
    puts("usage: bake csm|shadowfield SCENE -o FILE [--set key=value ...] [--shard i/n] [--threads N]\n"
         "       bake csm SCENE -o FILE --domain DOMAIN ...\n"
         "       bake ao MODEL.glb -o OUT.glb [--engine auto|csm|embree] [--set key=value ...] [--shard i/n] [--threads N]\n"
         "               [--report FILE.json]\n"
         "       bake model SCENE -o OUT.glb [--set time=0]\n"
         "       bake light MODEL.glb -o OUT.glb [--env SKY.hdr] [--light LIGHT ...] [--bounces N] [--set key=value ...]\n"
         "       bake probes SCENE -o OUT.json [--grid AxBxC | --points FILE] [--env SKY.hdr] [--light LIGHT ...] [--bounces N]\n"
         "       bake lights SKY.hdr|FOLDER -o OUT.glb|.gltf|.json [--count N] [--method NAME] [--set key=value ...]\n"
         "       bake merge -o OUT PART... [--set packed=1]\n"
         "       bake merge -o OUT.glb MODEL.glb PART...\n"
         "       bake info FILE\n"
         "       bake verify FILE SCENE [--set key=value ...]\n"
         "       bake [COMMAND] --help | --version\n"
         "\n"
         "  SCENE is FILE.glb, FILE.gltf or builtin:NAME: one rigid object, unless --set node=NAME\n"
         "  MODEL.glb keeps all its bytes but for what is added to it\n"
         "  --out FILE     the same as -o\n"
         "  --domain       csm: where maps look from. latlong, octahedral: all directions; line:OX,OY,OZ,UX,UY,UZ,\n"
         "                 rectangle:O,U,V, disc:O,U,V, sphere:O,RADIUS, volume:O,U,V,W: places from O on; table:FILE,\n"
         "                 list:FILE of lines x y z w, w = 1 a place, 0 a direction; emissive: places on what shines\n"
         "  --report FILE  the way that was taken, and seconds of the processor for each step, as one line of JSON\n"
         "  --limit-memory MB  what reading the scene may take, nearly; 1000\n"
         "  --shard i/n    only the i-th of n shards, 1 <= i <= n; merge joins all n, in order\n"
         "  verify         csm: every stored depth against the object; shadowfield: built again, same settings");
    printf("\nsettings of csm and shadowfield (--set key=value):\n");
    rd_print_keys(common_keys);
    for (size_t i = 0; i < COMMANDS; i++)
        if (commands[i].keys || commands[i].run == run_bake) {
            printf("\nsettings of %s (--set key=value):\n", commands[i].name);
            rd_print_keys(commands[i].keys ? commands[i].keys : commands[i].technique->keys);
        }
    puts("\nexit status: 0 done, 1 failed, 2 bad arguments");
}

static const bk_technique *technique_of(const void *data, size_t size)
{
    if (size >= 4 && memcmp(data, "SFLD", 4) == 0)
        return &bk_shadowfield;
    return size >= 4 && memcmp(data, "DCS", 3) == 0 ? &bk_csm : NULL;
}

/* ---- arguments ---- */

int bk_fail(char *error, const char *what, const char *value)
{
    snprintf(error, EX_ERROR_SIZE, "%s%.180s", what, value);
    return -1;
}

static int take_shard(bk_args *args, const char *value)
{
    unsigned i, n;
    char rest;
    if (sscanf(value, "%6u/%6u%c", &i, &n, &rest) != 2 || i < 1 || i > n || n > 65536)
        return -1;
    args->shard = i;
    args->shards = n;
    return 0;
}

/* Settings that have an option of their own name. */
static int is_short(const char *name)
{
    return strcmp(name, "--engine") == 0 || strcmp(name, "--count") == 0 || strcmp(name, "--bounces") == 0 ||
           strcmp(name, "--method") == 0;
}

static int take_grid(bk_args *args, const char *value, char *error)
{
    unsigned size[3];
    char rest, pair[32];
    if (sscanf(value, "%3ux%3ux%3u%c", &size[0], &size[1], &size[2], &rest) != 3)
        return bk_fail(error, "--grid AxBxC: ", value);
    for (int k = 0; k < 3; k++) {
        snprintf(pair, sizeof pair, "grid_%c=%u", 'x' + k, size[k]);
        if (rd_settings_add(&args->settings, pair, error) != 0)
            return -1;
    }
    return 0;
}

static int take_option(bk_args *args, const char *name, const char *value, char *error)
{
    double threads, limit;
    if (strcmp(name, "-o") == 0 || strcmp(name, "--out") == 0) args->out = value;
    else if (!args->technique && is_short(name)) {
        char pair[64];
        snprintf(pair, sizeof pair, "%s=%.50s", name + 2, value);
        return rd_settings_add(&args->settings, pair, error);
    } else if (strcmp(name, "--env") == 0 && command_of(args->command)->has_sky) args->env = value;
    else if (strcmp(name, "--points") == 0 && strcmp(args->command, "probes") == 0) args->points = value;
    else if (strcmp(name, "--domain") == 0 && strcmp(args->command, "csm") == 0)
        return bk_domain_parse(&args->domain, value, error);
    else if (strcmp(name, "--report") == 0 && strcmp(args->command, "ao") == 0) args->report = value;
    else if (strcmp(name, "--grid") == 0 && strcmp(args->command, "probes") == 0) return take_grid(args, value, error);
    else if (strcmp(name, "--light") == 0 && command_of(args->command)->has_sky) {
        if (args->light_count == sizeof args->lights / sizeof *args->lights)
            return bk_fail(error, "too many lights: ", value);
        args->lights[args->light_count++] = value;
    } else if (strcmp(name, "--set") == 0) {
        if (args->technique && strncmp(value, "node=", 5) == 0) {          /* any text: not a value of a list */
            if (!value[5] || strlen(value + 5) >= sizeof args->node)
                return bk_fail(error, "bad node: ", value + 5);
            strcpy(args->node, value + 5);
            return 0;
        }
        return rd_settings_add(&args->settings, value, error);
    } else if (strcmp(name, "--shard") == 0) {
        if (take_shard(args, value) != 0)
            return bk_fail(error, "--shard i/n, 1 <= i <= n: ", value);
    } else if (strcmp(name, "--threads") == 0) {
        if (rd_parse_number(value, &threads) != 0 || !(threads >= 0 && threads <= 1024))
            return bk_fail(error, "bad --threads: ", value);
        args->threads = (int)threads;
    } else if (strcmp(name, "--limit-memory") == 0) {
        if (rd_parse_number(value, &limit) != 0 || !(limit >= 1 && limit <= 1e6))
            return bk_fail(error, "bad --limit-memory: ", value);
        ex_memory_limit = (size_t)(limit * 1e6);
    } else return bk_fail(error, "unknown option: ", name);
    return 0;
}

static int take_all(bk_args *args, int count, char **values, char *error)
{
    for (int i = 0; i < count; i++)
        if (values[i][0] == '-' && values[i][1]) {
            if (i + 1 == count)
                return bk_fail(error, "no value: ", values[i]);
            if (take_option(args, values[i], values[i + 1], error) != 0)
                return -1;
            i++;
        } else if (args->file_count == BK_MOST_FILES)
            return bk_fail(error, "too many files: ", values[i]);
        else args->files[args->file_count++] = values[i];
    return 0;
}

/* ---- bake ---- */

/* What units from..to - 1 take; unit and row of the work hold sums of all before. */
static double work_of(const bk_work *w, uint32_t from, uint32_t to)
{
    uint32_t first = from / w->row_units, last = (to - 1) / w->row_units;
    double sum = w->unit[to] - w->unit[from] + w->row[last + 1] - w->row[first];
    sum += from ? w->overhang * (w->row[first + 1] - w->row[first]) : 0;
    return sum + (to < w->units ? w->overhang * (w->row[last + 1] - w->row[last]) : 0);
}

/* Limits of count shards, each as long as it may be to take no more than cap; 1 where they reach the end. */
static int fill(const bk_work *w, uint32_t count, double cap, uint32_t *limit)
{
    limit[0] = 0;
    for (uint32_t k = 0; k < count; k++) {
        uint32_t least = limit[k] + 1, most = w->units - (count - k - 1);      /* one unit at least for each */
        while (least < most) {
            uint32_t middle = least + (most - least + 1) / 2;
            if (work_of(w, limit[k], middle) <= cap)
                least = middle;
            else most = middle - 1;
        }
        limit[k + 1] = least;
    }
    return limit[count] == w->units && work_of(w, limit[count - 1], w->units) <= cap;
}

/* Limits of count shards or parts, the slowest of which takes as little as can be: limit[0] = 0 .. limit[count] =
   units. */
static void divide(const bk_work *w, uint32_t count, uint32_t *limit)
{
    double low = 0, high = 4 * work_of(w, 0, w->units);
    for (int step = 0; step < 30; step++) {
        double middle = (low + high) / 2;
        if (fill(w, count, middle, limit))
            high = middle;
        else low = middle;
    }
    fill(w, count, high, limit);
}

/* Sums of all before, in place of each. */
static void add_up(double *value, uint32_t count)
{
    double sum = 0;
    for (uint32_t i = 0; i <= count; i++) {
        double own = value[i];
        value[i] = sum;
        sum += own;
    }
}

static int weigh(const bk_args *args, const bk_mesh *mesh, uint32_t units, bk_work *work)
{
    memset(work, 0, sizeof *work);
    work->units = units;
    work->row_units = 1;
    work->unit = calloc((size_t)units + 1, sizeof *work->unit);
    work->row = calloc((size_t)units + 1, sizeof *work->row);
    if (!work->unit || !work->row)
        return -1;
    args->technique->weigh(&args->settings, mesh, work);
    add_up(work->unit, units);
    add_up(work->row, (units + work->row_units - 1) / work->row_units);
    return 0;
}

/* Of everything that decides the bytes. */
static uint64_t key_of(const bk_args *args, const bk_mesh *mesh, uint32_t from, uint32_t to)
{
    uint64_t h = bk_hash(BK_HASH, args->technique->name, strlen(args->technique->name));
    for (const rd_key *k = args->technique->keys; k->name; k++) {
        const char *value = rd_setting_text(&args->settings, k->name);
        h = bk_hash(h, value, strlen(value) + 1);
    }
    if (mesh->domain && mesh->domain->text)
        h = bk_hash(h, mesh->domain->text, strlen(mesh->domain->text) + 1);
    if (mesh->domain)
        h = bk_hash(h, mesh->domain->locations, 16 * mesh->domain->count);
    if (mesh->lamp_text)
        h = bk_hash(h, mesh->lamp_text, strlen(mesh->lamp_text) + 1);
    h = bk_hash(h, mesh->positions, 12 * mesh->vertices);
    h = bk_hash(h, mesh->indices, 12 * mesh->triangles);
    h = bk_hash(h, mesh->radiance, 12 * mesh->lit_count);
    h = bk_hash(h, &from, sizeof from);
    return bk_hash(h, &to, sizeof to);
}

typedef struct bk_parts {
    uint32_t count, limit[MOST_PARTS + 1];
    char *name[MOST_PARTS];
    void *data[MOST_PARTS];
    size_t size[MOST_PARTS];
} bk_parts;

/* Part k from its file or built and kept there. */
static int make_part(const bk_args *args, const bk_mesh *mesh, ex_pool *pool, bk_parts *p, uint32_t k, char *error)
{
    char line[LINE];
    if (bk_read(p->name[k], &p->data[k], &p->size[k], error) == 0) {
        if (args->technique->info(p->data[k], p->size[k], line, sizeof line, error) == 0)
            return 0;
        free(p->data[k]);
        p->data[k] = NULL;
    }
    if (args->technique->bake(&args->settings, mesh, p->limit[k], p->limit[k + 1], pool, &p->data[k], &p->size[k],
                              error) != 0)
        return -1;
    return bk_write(p->name[k], p->data[k], p->size[k], error);
}

/* The range from..to in parts. Of a shard the parts cannot be joined alone, so that it is one. */
static int bake_parts(const bk_args *args, const bk_mesh *mesh, ex_pool *pool, bk_parts *p, void **data, size_t *size,
                      char *error)
{
    int packed = args->technique == &bk_csm && rd_setting_is(&args->settings, "packed", "1");
    int result = 0;
    for (uint32_t k = 0; k < p->count; k++) {
        p->name[k] = malloc(strlen(args->out) + 64);
        if (!p->name[k])
            return bk_fail(error, "out of memory", "");
        sprintf(p->name[k], "%s.part-%016llx-%uof%u", args->out,
                (unsigned long long)key_of(args, mesh, p->limit[k], p->limit[k + 1]), (unsigned)k + 1,
                (unsigned)p->count);
    }
    for (uint32_t k = 0; k < p->count && result == 0; k++)
        result = make_part(args, mesh, pool, p, k, error);
    if (result == 0)
        result = args->technique->merge((const void *const *)p->data, p->size, p->count, packed, data, size, error);
    return result;
}

static int bake_range(const bk_args *args, const bk_mesh *mesh, ex_pool *pool, uint32_t units, double seconds,
                      char *error)
{
    bk_parts *p = calloc(1, sizeof *p);
    uint32_t *limit = calloc((size_t)args->shards + 1, sizeof *limit);
    bk_work work;
    void *data = NULL;
    size_t size = 0;
    int result = -1, asked = rd_setting_integer(&args->settings, "parts");
    if (weigh(args, mesh, units, &work) != 0 || !p || !limit)
        bk_fail(error, "out of memory", "");
    else if (args->shards > units)
        bk_fail(error, "more shards than there is to share", "");
    else {
        divide(&work, args->shards, limit);
        seconds /= SECONDS_OF_A_PART * ex_pool_threads(pool);
        p->count = asked ? (uint32_t)asked : seconds < 1 ? 1 : seconds < MOST_PARTS ? (uint32_t)seconds : MOST_PARTS;
        p->count = p->count < units ? p->count : units;
        if (args->shards > 1 || p->count == 1)
            result = args->technique->bake(&args->settings, mesh, limit[args->shard - 1], limit[args->shard], pool,
                                           &data, &size, error);
        else {
            divide(&work, p->count, p->limit);
            result = bake_parts(args, mesh, pool, p, &data, &size, error);
        }
        if (result == 0)
            result = bk_write(args->out, data, size, error);
        for (uint32_t k = 0; k < p->count; k++)
            if (p->name[k] && result == 0)
                remove(p->name[k]);         /* only once the output is there */
    }
    for (uint32_t k = 0; p && k < MOST_PARTS; k++) {
        free(p->name[k]);
        free(p->data[k]);
    }
    free(p);
    free(limit);
    free(work.unit);
    free(work.row);
    free(data);
    return result;
}

static int run_bake(const bk_args *args, char *error)
{
    bk_args settled = *args;
    bk_mesh mesh;
    uint32_t units;
    double seconds;
    ex_pool *pool;
    int result;
    if (args->technique == &bk_shadowfield && rd_setting_is(&args->settings, "kind", "sky"))
        return bk_sky_run(args, error);
    result = bk_object(&mesh, args->files[0], args->node, error);
    if (result != 0)
        return -1;
    mesh.domain = &settled.domain;
    pool = ex_pool_create(args->threads);
    if (!pool)
        result = bk_fail(error, "no threads", "");
    else if (args->technique == &bk_csm && mesh.lamp_text)
        result = bk_fail(error, "csm: a lamp hides nothing: ", mesh.lamp_text);
    else if (args->technique == &bk_csm && bk_domain_load(&settled.domain, &mesh, &settled.settings, error) != 0)
        result = -1;
    else if (args->technique->settle && args->technique->settle(&settled.settings, &mesh, pool, error) != 0)
        result = -1;
    else if (args->technique->plan(&settled.settings, &mesh, &units, &seconds, error) != 0)
        result = -1;
    else
        result = bake_range(&settled, &mesh, pool, units, seconds, error);
    ex_pool_free(pool);
    free(settled.domain.locations);
    bk_object_free(&mesh);
    return result;
}

/* ---- merge, info, verify ---- */

/* Shards of a bake into a model: its command again, with their settings, and their values in place of computing. */
static int merge_parts(const bk_args *args, const bk_command *c, const void *part, size_t size, char *error)
{
    bk_args again = *args;
    again.command = c->name;
    again.technique = NULL;
    again.parts = args->files + 1;
    again.part_count = args->file_count - 1;
    memset(&again.settings, 0, sizeof again.settings);
    again.settings.own = c->keys;
    again.settings.listed = "bake --help";
    if (bk_part_settings(part, size, &again, error) != 0)
        return -1;
    return c->run(&again, error);
}

static int merge_into_model(const bk_args *args, int *is_one, char *error)
{
    const bk_command *c = NULL;
    char command[32];
    void *data;
    size_t size;
    int result = bk_read(args->files[args->file_count - 1], &data, &size, error);
    *is_one = result == 0 && bk_part_look(data, size, command, sizeof command);
    if (*is_one) {
        c = command_of(command);
        result = !c || !c->keys ? bk_fail(error, "a part of an unknown command: ", command)
                 : args->file_count < 2 ? bk_fail(error, "merge: the model comes first, then its parts", "")
                                        : merge_parts(args, c, data, size, error);
    }
    free(data);
    return result;
}

static int run_merge(const bk_args *args, char *error)
{
    void **data = calloc(args->file_count, sizeof(void *)), *whole = NULL;
    size_t *sizes = calloc(args->file_count, sizeof *sizes), size = 0;
    const bk_technique *technique = NULL;
    int is_one, result = merge_into_model(args, &is_one, error);
    if (is_one || result != 0) {
        free(data);
        free(sizes);
        return result;
    }
    result = data && sizes ? 0 : bk_fail(error, "out of memory", "");
    for (size_t i = 0; i < args->file_count && result == 0; i++) {
        result = bk_read(args->files[i], &data[i], &sizes[i], error);
        if (result == 0 && (!technique_of(data[i], sizes[i]) ||
                            (technique && technique != technique_of(data[i], sizes[i]))))
            result = bk_fail(error, "not a part of this bake: ", args->files[i]);
        if (result == 0)
            technique = technique_of(data[i], sizes[i]);
    }
    if (result == 0)
        result = technique->merge((const void *const *)data, sizes, args->file_count,
                                  rd_setting_is(&args->settings, "packed", "1"), &whole, &size, error);
    if (result == 0)
        result = bk_write(args->out, whole, size, error);
    for (size_t i = 0; i < args->file_count && data; i++)
        free(data[i]);
    free(data);
    free(sizes);
    free(whole);
    return result;
}

static int run_info(const bk_args *args, char *error)
{
    char line[LINE];
    void *data;
    size_t size;
    const bk_technique *technique;
    int result;
    if (bk_read(args->files[0], &data, &size, error) != 0)
        return -1;
    technique = technique_of(data, size);
    result = technique ? technique->info(data, size, line, sizeof line, error)
                       : bk_fail(error, "neither of csm nor of shadowfield: ", args->files[0]);
    if (result == 0)
        puts(line);
    free(data);
    return result;
}

static int run_verify(const bk_args *args, char *error)
{
    char line[LINE];
    void *data;
    size_t size;
    bk_mesh mesh;
    ex_pool *pool = NULL;
    int result = bk_object(&mesh, args->files[1], args->node, error);
    if (result != 0)
        return -1;
    result = bk_read(args->files[0], &data, &size, error);
    if (result == 0 && !(pool = ex_pool_create(args->threads)))
        result = bk_fail(error, "no threads", "");
    if (result == 0)
        result = args->technique->verify(&args->settings, data, size, &mesh, pool, line, sizeof line, error);
    if (result >= 0)
        puts(line);
    if (result > 0)
        result = bk_fail(error, "wrong: ", args->files[0]);
    ex_pool_free(pool);
    bk_object_free(&mesh);
    free(data);
    return result;
}

/* ---- main ---- */

static int check(const bk_args *args, const bk_command *c, char *error)
{
    if (c->writes && !args->out)
        return bk_fail(error, c->name, ": -o FILE is missing");
    if (args->file_count < c->least || args->file_count > c->most)
        return bk_fail(error, c->name, ": wrong number of files");
    if (args->shards > 1 && !c->shares)
        return bk_fail(error, c->name, ": --shard is not for this command");
    if (c->keys && c->shares && args->shards > 1 && rd_setting_integer(&args->settings, "parts"))
        return bk_fail(error, c->name, ": parts=N is for a bake without --shard, whose parts are the shards");
    if (c->technique && rd_setting_integer(&args->settings, "parts") && (args->shards > 1 || c->run != run_bake))
        return bk_fail(error, c->name, ": parts=N is for a bake without --shard, whose parts are the shards");
    return 0;
}

/* The settings that verify accepts are those of the file's technique. */
static void look_into(bk_args *args, int count, char **values, char *error)
{
    void *data;
    size_t size;
    for (int i = 0; i < count; i++)
        if (values[i][0] == '-') i++;
        else {
            if (bk_read(values[i], &data, &size, error) != 0)
                return;
            if (technique_of(data, size))
                args->technique = technique_of(data, size);
            free(data);
            return;
        }
}

int main(int count, char **values)
{
    static bk_args args;
    static char error[EX_ERROR_SIZE];
    const bk_command *c = count > 1 ? command_of(values[1]) : NULL;
    if (count == (c ? 3 : 2) && strcmp(values[count - 1], "--help") == 0) {
        print_help();
        return DONE;
    }
    if (count == 2 && strcmp(values[1], "--version") == 0) {
        printf("bake %s\n", dapple_version);
        return DONE;
    }
    args.shard = args.shards = 1;
    if (!c)
        bk_fail(error, "csm, shadowfield, ao, light, probes, lights, model, merge, info or verify, or --help", "");
    else {
        args.command = c->name;
        args.technique = c->technique;
        if (c->run == run_verify) look_into(&args, count - 2, values + 2, error);
        args.settings.common = c->technique ? common_keys : NULL;
        args.settings.listed = "bake --help";
        args.settings.own = c->technique ? args.technique->keys : c->keys;
        if (take_all(&args, count - 2, values + 2, error) != 0 || check(&args, c, error) != 0)
            c = NULL;
    }
    if (!c) {
        ex_complain("bake", error);
        return BAD_ARGUMENTS;
    }
    if (c->run(&args, error) != 0) {
        ex_complain("bake", error);
        return FAILED;
    }
    return DONE;
}
