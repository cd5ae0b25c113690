/* settings.h - the key=value pairs of --set, checked against tables of keys. */
#ifndef RD_SETTINGS_H
#define RD_SETTINGS_H

#include <stddef.h>
#include <stdint.h>

typedef enum rd_key_kind { RD_WORD, RD_INTEGER, RD_NUMBER } rd_key_kind;

typedef struct rd_key {
    const char *name;
    rd_key_kind kind;
    const char *words;         /* values allowed as text, "auto|0|1"; also beside a number; NULL for none */
    double      low, high;     /* of an integer or a number, both allowed */
    const char *standard;      /* the default, as it would be typed */
    const char *help;
} rd_key;

#define RD_MAX_SETTINGS 64

typedef struct rd_settings {
    const rd_key *common, *own;                /* tables ended by a NULL name; own may be NULL */
    const char   *listed;                      /* by which command: "render --list" */
    struct { const rd_key *key; char value[64]; } set[RD_MAX_SETTINGS];
    size_t count;
} rd_settings;

extern const rd_key rd_common_keys[];          /* ev, background, ...: main.c treats them for every technique */

/* Takes one "key=value"; a later one replaces an earlier one. -1 with one line in error: unknown key or value. */
int         rd_settings_add(rd_settings *settings, const char *pair, char *error);
/* The value of a key in the tables, given or default. The key must exist (asserted). */
const char *rd_setting_text(const rd_settings *settings, const char *key);
double      rd_setting_number(const rd_settings *settings, const char *key);
int         rd_setting_integer(const rd_settings *settings, const char *key);
int         rd_setting_is(const rd_settings *settings, const char *key, const char *word);

/* A line of a list for each key of a table: name, values, default, help. */
void        rd_print_keys(const rd_key *keys);

/* The whole of text as a finite number. */
int         rd_parse_number(const char *text, double *value);

#endif
