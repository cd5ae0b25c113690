/* json.h - a number of the one-line JSON that the programs print. */
#ifndef JSON_H
#define JSON_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The first value under that name; the test fails if there is none. */
static inline double json_number(const char *json, const char *name)
{
    char quoted[64];
    const char *at;
    snprintf(quoted, sizeof quoted, "\"%s\": ", name);
    at = strstr(json, quoted);
    if (!at)
        fail_msg("no %s in %s", name, json);
    return strtod(at + strlen(quoted), NULL);
}

#endif
