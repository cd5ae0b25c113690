/* units - small pieces of C in src/shared, which a header gets under its own prefix, but for the functions and structs
   that it does not use. */

#ifndef JOIN_UNITS_H
#define JOIN_UNITS_H

#include "text.h"

#define MAX_UNITS 64
#define MAX_ITEMS 1024
#define MAX_DEFINED 8

/* What stands between two blank lines of a unit, its comment included. */
typedef struct item {
    const char *text;
    size_t size;
    unsigned long line;
    char defines[MAX_DEFINED][MAX_NAME];    /* functions and structs, without P_ */
    int defined;                            /* 0: goes with its unit */
    int unit, used;
} item;

/* Those of one header. */
typedef struct units {
    char names[MAX_UNITS][MAX_NAME];
    text texts[MAX_UNITS];
    int used[MAX_UNITS], count;
    item items[MAX_ITEMS];
    int item_count;
} units;

/* Adds src/shared/NAME.h after the units that its first line says it needs, unless it is there. */
void add_unit(units *u, const char *folder, const char *name);

/* Marks which functions and structs the header's own text asks for under its prefix, and what these ask for in turn. */
void mark_used(units *u, const text *own, const char *prefix);

/* What is used of unit i, P_x under the header's prefix; with lines, behind #line directives. 0: nothing is. */
int put_unit(text *out, const units *u, int unit, const char *folder, const char *prefix, int lines);

#endif
