/* work.c - see bake.h: values that take long, in parts or shards. A part is a file: eight bytes that say so, then what
   part_head holds, the command and its settings as text, floats as this machine has them, and a hash of all that. */
#include "bake.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_PARTS = 256, TEXT = 4096 };
#define SECONDS_OF_A_PART 60.0

static const char magic[8] = { 'B', 'K', 'P', 'A', 'R', 'T', '1', '\n' };

typedef struct part_head { uint64_t key, count, from, to, unit, text; } part_head;

uint64_t bk_hash(uint64_t h, const void *data, size_t size)
{
    for (size_t i = 0; i < size; i++)
        h = (h ^ ((const unsigned char *)data)[i]) * 1099511628211u;
    return h;
}

/* "command\nkey=value\n..." with every key of the command. */
static size_t write_settings(const bk_args *args, char *text)
{
    size_t n = (size_t)snprintf(text, TEXT, "%s\n", args->command);
    for (const rd_key *k = args->settings.own; k->name; k++)
        n += (size_t)snprintf(text + n, TEXT - n, "%s=%s\n", k->name, rd_setting_text(&args->settings, k->name));
    n += (size_t)snprintf(text + n, TEXT - n, "--env %.500s\n", args->env ? args->env : "");
    n += (size_t)snprintf(text + n, TEXT - n, "--points %.500s\n", args->points ? args->points : "");
    for (size_t i = 0; i < args->light_count && n + 300 < TEXT; i++)
        n += (size_t)snprintf(text + n, TEXT - n, "--light %.200s\n", args->lights[i]);
    return n;
}

uint64_t bk_hash_settings(uint64_t h, const bk_args *args)
{
    char text[TEXT];
    return bk_hash(h, text, write_settings(args, text));
}

/* ---- one part as a file ---- */

static int write_part(const bk_args *args, const bk_items *items, size_t from, size_t to, const float *values,
                      const char *path, char *error)
{
    char text[TEXT];
    const part_head head = { items->key, items->count, from, to, items->unit, write_settings(args, text) };
    const size_t floats = (to - from) * items->unit * sizeof *values;
    const size_t size = sizeof magic + sizeof head + head.text + floats + sizeof head.key;
    char *bytes = malloc(size), *at = bytes;
    uint64_t hash;
    int result;
    if (!bytes)
        return bk_fail(error, "out of memory", "");
    memcpy(at, magic, sizeof magic);
    memcpy(at += sizeof magic, &head, sizeof head);
    memcpy(at += sizeof head, text, head.text);
    memcpy(at += head.text, values, floats);
    hash = bk_hash(BK_HASH, bytes, size - sizeof hash);
    memcpy(at + floats, &hash, sizeof hash);
    result = bk_write(path, bytes, size, error);
    free(bytes);
    return result;
}

/* The head of a whole part, or -1. */
static int open_part(const void *data, size_t size, part_head *head)
{
    uint64_t hash;
    if (size < sizeof magic + sizeof *head + sizeof hash || memcmp(data, magic, sizeof magic) != 0)
        return -1;
    memcpy(head, (const char *)data + sizeof magic, sizeof *head);
    memcpy(&hash, (const char *)data + size - sizeof hash, sizeof hash);
    size -= sizeof magic + sizeof *head + sizeof hash;
    if (head->text >= TEXT || head->text > size || head->to < head->from || head->to > head->count || !head->unit ||
        head->unit > 1024 || (head->to - head->from) > size ||
        (head->to - head->from) * head->unit * 4 != size - head->text)
        return -1;
    return hash == bk_hash(BK_HASH, data, size + sizeof magic + sizeof *head) ? 0 : -1;
}

static const char *text_of(const void *data) { return (const char *)data + sizeof magic + sizeof(part_head); }

int bk_part_look(const void *data, size_t size, char *command, size_t room)
{
    part_head head;
    size_t n = 0;
    if (open_part(data, size, &head) != 0)
        return 0;
    for (; n + 1 < room && n < head.text && text_of(data)[n] != '\n'; n++)
        command[n] = text_of(data)[n];
    command[n] = 0;
    return 1;
}

int bk_part_settings(const void *data, size_t size, bk_args *args, char *error)
{
    static char text[TEXT];          /* env and lights point into it */
    part_head head;
    char *line;
    if (open_part(data, size, &head) != 0)
        return bk_fail(error, "a damaged part", "");
    memcpy(text, text_of(data), head.text);
    text[head.text] = 0;
    strtok(text, "\n");
    while ((line = strtok(NULL, "\n")) != NULL)
        if (strncmp(line, "--env ", 6) == 0)
            args->env = line[6] ? line + 6 : NULL;
        else if (strncmp(line, "--points ", 9) == 0)
            args->points = line[9] ? line + 9 : NULL;
        else if (strncmp(line, "--light ", 8) == 0) {
            if (args->light_count < sizeof args->lights / sizeof *args->lights)
                args->lights[args->light_count++] = line + 8;
        } else if (rd_settings_add(&args->settings, line, error) != 0)
            return -1;
    return 0;
}

/* The values of a part of this bake into `values`, which are all; -1: it is not there, or of another bake. */
static int read_part(const bk_items *items, const char *path, float *values, size_t *from, size_t *to)
{
    char error[EX_ERROR_SIZE];
    part_head head;
    void *data;
    size_t size;
    int result = -1;
    if (bk_read(path, &data, &size, error) != 0)
        return -1;
    if (open_part(data, size, &head) == 0 && head.key == items->key && head.count == items->count &&
        head.unit == items->unit) {
        memcpy(values + head.from * head.unit, text_of(data) + head.text,
               (size_t)((head.to - head.from) * head.unit) * sizeof *values);
        *from = (size_t)head.from;
        *to = (size_t)head.to;
        result = 0;
    }
    free(data);
    return result;
}

/* ---- parts and shards ---- */

static uint32_t parts_of(const bk_args *args, const bk_items *items)
{
    const int asked = rd_setting_integer(&args->settings, "parts");
    const double wanted = asked ? asked : items->seconds / (SECONDS_OF_A_PART * (args->threads ? args->threads : 1));
    const double most = items->count < MOST_PARTS ? (double)items->count : MOST_PARTS;
    return wanted < 1 ? 1 : (uint32_t)(wanted < most ? wanted : most);
}

static size_t limit_of(const bk_items *items, uint32_t part, uint32_t parts)
{
    return (size_t)((double)items->count * part / parts);
}

static char *part_name(const bk_args *args, const bk_items *items, uint32_t part, uint32_t parts)
{
    char *name = malloc(strlen(args->out) + 64);
    if (name)
        sprintf(name, "%s.part-%016llx-%uof%u", args->out, (unsigned long long)items->key, (unsigned)part + 1,
                (unsigned)parts);
    return name;
}

static int run_parts(const bk_args *args, const bk_items *items, float *values, char *error)
{
    const uint32_t parts = parts_of(args, items);
    int result = 0;
    for (uint32_t i = 0; i < parts && result == 0; i++) {
        const size_t from = limit_of(items, i, parts), to = limit_of(items, i + 1, parts);
        char *name = part_name(args, items, i, parts);
        size_t first, last;
        if (!name)
            result = bk_fail(error, "out of memory", "");
        else if (parts == 1 || read_part(items, name, values, &first, &last) != 0 || first != from || last != to) {
            result = items->compute(items->context, from, to, values + from * items->unit, error);
            if (result == 0 && parts > 1)
                result = write_part(args, items, from, to, values + from * items->unit, name, error);
        }
        free(name);
    }
    return result;
}

/* All values from shards, which must follow each other. */
static int read_shards(const bk_args *args, const bk_items *items, float *values, char *error)
{
    size_t at = 0, from, to;
    for (size_t i = 0; i < args->part_count; i++) {
        if (read_part(items, args->parts[i], values, &from, &to) != 0 || from != at)
            return bk_fail(error, "not the next part of this bake: ", args->parts[i]);
        at = to;
    }
    return at == items->count ? 0 : bk_fail(error, "parts are missing behind ", args->parts[args->part_count - 1]);
}

int bk_items_run(const bk_args *args, const bk_items *items, float **out, char *error)
{
    const size_t from = (size_t)((double)items->count * (args->shard - 1) / args->shards);
    const size_t to = (size_t)((double)items->count * args->shard / args->shards);
    float *values = malloc((items->count * items->unit + 1) * sizeof *values);
    int result;
    *out = NULL;
    if (!values)
        return bk_fail(error, "out of memory", "");
    if (args->shards > items->count)
        result = bk_fail(error, "more shards than there is to share", "");
    else if (args->parts)
        result = read_shards(args, items, values, error);
    else if (args->shards == 1)
        result = run_parts(args, items, values, error);
    else {
        result = items->compute(items->context, from, to, values, error);
        if (result == 0)
            result = write_part(args, items, from, to, values, args->out, error);
    }
    if (result == 0 && args->shards == 1)
        *out = values;
    else free(values);
    return result;
}

void bk_items_done(const bk_args *args, const bk_items *items)
{
    const uint32_t parts = parts_of(args, items);
    for (uint32_t i = 0; i < parts && parts > 1 && !args->parts; i++) {
        char *name = part_name(args, items, i, parts);
        if (name)
            remove(name);
        free(name);
    }
}
