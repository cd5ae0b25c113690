/* json.c - see json.h */
#include "json.h"
#include "../common/common.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void append(rd_json *json, const char *text, size_t length)
{
    if (json->failed)
        return;
    if (json->length + length + 1 > json->capacity) {
        size_t capacity = 2 * (json->length + length) + 256;
        char *grown = realloc(json->text, capacity);
        if (!grown) {
            json->failed = 1;
            return;
        }
        json->text = grown;
        json->capacity = capacity;
    }
    memcpy(json->text + json->length, text, length);
    json->length += length;
    json->text[json->length] = 0;
}

static void append_quoted(rd_json *json, const char *text)
{
    append(json, "\"", 1);
    for (; *text; text++) {
        unsigned char c = (unsigned char)*text;
        char escaped[8];
        if (c == '"' || c == '\\') {
            escaped[0] = '\\';
            escaped[1] = (char)c;
            append(json, escaped, 2);
        } else if (c < 0x20) {
            append(json, escaped, (size_t)snprintf(escaped, sizeof escaped, "\\u%04x", (unsigned)c));
        } else {
            append(json, text, 1);
        }
    }
    append(json, "\"", 1);
}

static void append_name(rd_json *json, const char *name)
{
    append(json, json->length ? ", " : "{", json->length ? 2 : 1);
    append_quoted(json, name);
    append(json, ": ", 2);
}

void rd_json_text(rd_json *json, const char *name, const char *value)
{
    append_name(json, name);
    if (value)
        append_quoted(json, value);
    else
        append(json, "null", 4);
}

void rd_json_number(rd_json *json, const char *name, double value)
{
    char digits[40];
    append_name(json, name);
    append(json, digits, (size_t)(isfinite(value) ? snprintf(digits, sizeof digits, "%.7g", value)
                                                  : snprintf(digits, sizeof digits, "null")));
}

void rd_json_integer(rd_json *json, const char *name, uint64_t value)
{
    char digits[40];
    append_name(json, name);
    append(json, digits, (size_t)snprintf(digits, sizeof digits, "%llu", (unsigned long long)value));
}

void rd_json_append(rd_json *json, const rd_json *more)
{
    json->failed |= more->failed;
    if (!more->length)
        return;
    append(json, json->length ? ", " : "{", json->length ? 2 : 1);
    append(json, more->text + 1, more->length - 1);        /* without its opening brace */
}

int rd_json_write(rd_json *json, const char *path, char *error)
{
    int to_stdout = strcmp(path, "-") == 0, bad;
    FILE *file;
    append(json, json->length ? "}\n" : "{}\n", json->length ? 2 : 3);
    if (json->failed) {
        snprintf(error, EX_ERROR_SIZE, "out of memory");
        return -1;
    }
    file = to_stdout ? stdout : fopen(path, "wb");
    if (!file) {
        snprintf(error, EX_ERROR_SIZE, "cannot write %.150s: %s", path, strerror(errno));
        return -1;
    }
    bad = fwrite(json->text, 1, json->length, file) != json->length;
    bad |= to_stdout ? fflush(file) : fclose(file);
    if (bad)
        snprintf(error, EX_ERROR_SIZE, "cannot write %.150s", path);
    return bad ? -1 : 0;
}

void rd_json_free(rd_json *json)
{
    free(json->text);
    memset(json, 0, sizeof *json);
}
