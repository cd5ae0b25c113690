/* json.h - one flat JSON object on one line, and what a technique reports into it. */
#ifndef RD_JSON_H
#define RD_JSON_H

#include <stddef.h>
#include <stdint.h>

typedef struct rd_json { char *text; size_t length, capacity; int failed; } rd_json;   /* zero it first */

void rd_json_text(rd_json *json, const char *name, const char *value);      /* NULL writes null */
void rd_json_number(rd_json *json, const char *name, double value);         /* not finite writes null */
void rd_json_integer(rd_json *json, const char *name, uint64_t value);
void rd_json_append(rd_json *json, const rd_json *more);                    /* the members of more */
int  rd_json_write(rd_json *json, const char *path, char *error);           /* "-": stdout; -1 with error filled in */
void rd_json_free(rd_json *json);

typedef struct rd_report {
    uint64_t memory_bytes;     /* what the technique keeps */
    uint64_t peak_bytes;       /* of its allocator */
    rd_json *json;             /* its own figures go here */
} rd_report;

#endif
