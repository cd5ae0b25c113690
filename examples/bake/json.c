/* json.c - see glb.h. Reads JSON in place: what it says stays where it is, so that all but what is changed keeps its
   bytes. The depth of the text was checked before (ex_gltf_check): reading goes down as deep as that. */
#include "glb.h"
#include "bake.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct reader { bk_json *json; size_t at, length; int no_memory; } reader;

enum { MOST_DEPTH = 256 };

static int add_value(reader *r, char kind, uint32_t *number)
{
    bk_json *j = r->json;
    if (j->count == j->room) {
        bk_value *grown = realloc(j->values, (2 * (size_t)j->room + 256) * sizeof *grown);
        if (!grown) {
            r->no_memory = 1;
            return -1;
        }
        j->values = grown;
        j->room = 2 * j->room + 256;
    }
    *number = j->count++;
    memset(&j->values[*number], 0, sizeof *j->values);
    j->values[*number].kind = kind;
    j->values[*number].begin = (uint32_t)r->at;
    return 0;
}

static void skip_space(reader *r)
{
    while (r->at < r->length && strchr(" \t\r\n", r->json->text[r->at]) && r->json->text[r->at])
        r->at++;
}

static int next_is(reader *r, char c)
{
    skip_space(r);
    return r->at < r->length && r->json->text[r->at] == c;
}

static void close_value(reader *r, uint32_t number)
{
    r->json->values[number].end = (uint32_t)r->at;
    r->json->values[number].after = r->json->count;
}

static int read_string(reader *r)
{
    const char *text = r->json->text;
    uint32_t number;
    if (!next_is(r, '"') || add_value(r, '"', &number) != 0)
        return -1;
    for (r->at++; r->at < r->length && text[r->at] != '"'; r->at++)
        r->at += text[r->at] == '\\';
    if (r->at >= r->length)
        return -1;
    r->at++;
    close_value(r, number);
    return 0;
}

static int read_word(reader *r)
{
    uint32_t number;
    size_t from = r->at;
    if (add_value(r, '0', &number) != 0)
        return -1;
    while (r->at < r->length && r->json->text[r->at] && !strchr(" \t\r\n,:]}[{\"", r->json->text[r->at]))
        r->at++;
    close_value(r, number);
    return r->at > from ? 0 : -1;
}

static int read_value(reader *r, int depth);

static int read_list(reader *r, int depth)
{
    const char open = r->json->text[r->at], shut = open == '{' ? '}' : ']';
    uint32_t number;
    if (add_value(r, open, &number) != 0)
        return -1;
    r->at++;
    while (!next_is(r, shut)) {
        if (r->json->values[number].count++) {
            if (!next_is(r, ','))
                return -1;
            r->at++;
        }
        if (open == '{') {
            if (read_string(r) != 0 || !next_is(r, ':'))
                return -1;
            r->at++;
        }
        if (read_value(r, depth + 1) != 0)
            return -1;
    }
    r->at++;
    close_value(r, number);
    return 0;
}

static int read_value(reader *r, int depth)
{
    skip_space(r);
    if (r->at >= r->length || depth > MOST_DEPTH)
        return -1;
    if (r->json->text[r->at] == '"')
        return read_string(r);
    if (r->json->text[r->at] == '{' || r->json->text[r->at] == '[')
        return read_list(r, depth);
    return read_word(r);
}

int bk_json_parse(bk_json *json, const char *text, size_t length, char *error)
{
    reader r = { json, 0, length, 0 };
    int result;
    memset(json, 0, sizeof *json);
    json->text = text;
    result = length < UINT32_MAX ? read_value(&r, 0) : -1;
    skip_space(&r);
    while (result == 0 && r.at < length && !text[r.at])          /* some writers pad by zeros */
        r.at++;
    if (result == 0 && r.at == length && json->values[0].kind == '{')
        return 0;
    snprintf(error, EX_ERROR_SIZE, "%s", r.no_memory ? "out of memory" : "its JSON is damaged");
    bk_json_free(json);
    return -1;
}

void bk_json_free(bk_json *json)
{
    free(json->values);
    memset(json, 0, sizeof *json);
}

uint32_t bk_json_member(bk_json *json, uint32_t object, const char *name)
{
    const size_t length = strlen(name);
    uint32_t found = 0, key;
    if (json->values[object].kind != '{')
        return 0;
    for (key = object + 1; key < json->values[object].after; key = json->values[key + 1].after) {
        const char *at = json->text + json->values[key].begin + 1;
        const size_t size = json->values[key].end - json->values[key].begin - 2;
        json->escaped |= memchr(at, '\\', size) != NULL;
        if (size == length && memcmp(at, name, length) == 0)
            found = key + 1;
    }
    return found;
}

uint32_t *bk_json_items(const bk_json *json, uint32_t array, uint32_t *count)
{
    const bk_value *a = &json->values[array];
    uint32_t *list;
    *count = 0;
    list = malloc(((size_t)a->count + 1) * sizeof *list);
    if (!list || a->kind != '[')
        return list;
    for (uint32_t i = array + 1; i < a->after; i = json->values[i].after)
        list[(*count)++] = i;
    return list;
}

double bk_json_number(const bk_json *json, uint32_t value, double otherwise)
{
    char text[40], *end;
    const bk_value *v = &json->values[value];
    const size_t size = v->end - v->begin;
    double number;
    if (!value || v->kind != '0' || size >= sizeof text)
        return otherwise;
    memcpy(text, json->text + v->begin, size);
    text[size] = 0;
    number = strtod(text, &end);
    return *end ? otherwise : number;
}
