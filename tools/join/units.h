/* units - small pieces of C in src/shared, which a header gets under its own prefix, but for the functions, structs and
   macros that it does not use. The parts of a lean header lose what nothing uses any more in the same way. */

#ifndef JOIN_UNITS_H
#define JOIN_UNITS_H

#include "text.h"

#define MAX_UNITS 320
#define MAX_ITEMS 4096
#define MAX_DEFINED 24

/* A name within a text. */
typedef struct span { const char *s; size_t size; } span;

/* What stands between two blank lines, its comment included; a line of a list of names (unit simd) by itself. */
typedef struct item {
    const char *text;
    size_t size;
    unsigned long line;
    span defines[MAX_DEFINED];  /* private functions, structs and macros: those with two underscores in a row */
    int defined;                /* 0: goes with its unit, as what defines more than MAX_DEFINED does */
    int comment;                /* nothing else stands in it */
    int tight;                  /* it follows the item before it without a blank line */
    int unit, used;
} item;

/* Those of one header. */
typedef struct units {
    char names[MAX_UNITS][MAX_NAME];
    text texts[MAX_UNITS];      /* units: with the header's prefix in place of P_ */
    int used[MAX_UNITS], is_part[MAX_UNITS], count;
    item items[MAX_ITEMS];
    int item_count;
} units;

/* Adds src/shared/NAME.h after the units that its first line says it needs, unless it is there. values: see fold.h,
   NULL for a whole header. */
void add_unit(units *u, const char *folder, const char *name, const char *prefix, const char *values);

/* Adds a part of which only what is used is wanted. Returns its number. */
int add_part_as_unit(units *u, const char *name, const text *body);

/* Marks which functions, structs and macros the text asks for, and what these ask for in turn. */
void mark_used(units *u, const text *own);

/* What is used of unit i; with lines, behind #line directives. 0: nothing is. */
int put_unit(text *out, const units *u, int unit, const char *folder, int lines);

#endif
