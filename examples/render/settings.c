/* settings.c - see settings.h */
#include "settings.h"
#include "../common/common.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

const rd_key rd_common_keys[] = {
    { "ev", RD_NUMBER, "auto", -100, 100, "auto", "exposure of a PNG: 2^ev times radiance" },
    { "background", RD_WORD, "0|1", 0, 0, "0", "1 shows the sky behind the scene" },
    { "emission", RD_WORD, "0|1", 0, 0, "0", "1 shows the emission of directly seen emitters" },
    { "aa", RD_INTEGER, NULL, 1, 16, "1", "aa x aa primary rays a pixel; --samples are shared among them" },
    { "materials", RD_WORD, "diffuse|full", 0, 0, "diffuse", "Lambert of the base colour, or the full BRDF" },
    { "roughness", RD_NUMBER, "auto", 0, 1, "auto", "of all of the scene's materials; auto: each its own" },
    { "metallic", RD_NUMBER, "auto", 0, 1, "auto", "of all of the scene's materials; auto: each its own" },
    { "ground", RD_WORD, "auto|0|1", 0, 0, "auto", "a plane of albedo 0.5 below; auto: without camera and emitters" },
    { "env_rotation", RD_NUMBER, NULL, -360000, 360000, "0", "of the sky about +Y, in degrees" },
    { "env_scale", RD_NUMBER, NULL, 0, 1e9, "1", "factor on the sky's radiance" },
    { "emitters", RD_WORD, "0|1|removed", 0, 0, "1",
      "0: emissive surfaces shed no light; removed: nor stand in its way" },
    { "lamp_count", RD_INTEGER, NULL, 0, 16, "0", "spheres of light that circle round the scene, once in 8 seconds" },
    { "sun_turn", RD_NUMBER, NULL, -3600, 3600, "0",
      "degrees a second by which the first sun goes on its way, from +X in the east over +Z in the south" },
    { "animation", RD_INTEGER, NULL, 0, 9999, "0", "of a glTF file: which of its animations moves it or the figure" },
    { "still", RD_WORD, "0|1", 0, 0, "0", "1: only those lamps and that sun move with time" },
    { "warm_up", RD_INTEGER, NULL, 0, 1000, "0", "times that the first frame is drawn before it is timed and kept" },
    { "compute", RD_WORD, "auto|0|1", 0, 0, "auto",
      "--backend gl: 4.3's compute shaders; auto: not on software drivers" },
    { NULL, RD_WORD, NULL, 0, 0, NULL, NULL }
};

static const rd_key *find_in(const rd_key *table, const char *name, size_t length)
{
    for (; table && table->name; table++)
        if (strlen(table->name) == length && memcmp(table->name, name, length) == 0)
            return table;
    return NULL;
}

static const rd_key *find(const rd_settings *settings, const char *name, size_t length)
{
    const rd_key *key = find_in(settings->common, name, length);
    return key ? key : find_in(settings->own, name, length);
}

static int is_word_of(const char *words, const char *value)
{
    size_t length = strlen(value);
    while (words && *words) {
        size_t word = strcspn(words, "|");
        if (word == length && memcmp(words, value, length) == 0)
            return 1;
        words += word + (words[word] == '|');
    }
    return 0;
}

int rd_parse_number(const char *text, double *value)
{
    char *end;
    if (!*text || strchr(" \t\n\v\f\r", *text))
        return -1;
    *value = strtod(text, &end);
    return *end || !isfinite(*value) ? -1 : 0;
}

static int is_valid(const rd_key *key, const char *value)
{
    double number;
    if (is_word_of(key->words, value))
        return 1;
    if (key->kind == RD_WORD || rd_parse_number(value, &number) != 0 || number < key->low || number > key->high)
        return 0;
    return key->kind == RD_NUMBER || floor(number) >= number;
}

static void describe_range(const rd_key *key, char *text, size_t size)
{
    if (key->kind == RD_WORD)
        snprintf(text, size, "%s", key->words);
    else
        snprintf(text, size, "%s%s%s from %g to %g", key->words ? key->words : "", key->words ? " or " : "",
                 key->kind == RD_INTEGER ? "an integer" : "a number", key->low, key->high);
}

/* Returns the fewest letters to change, add or leave out so that `name`, of `length` letters, becomes the beginning of
   `word`; length is at most 40. */
static size_t letters_apart(const char *name, size_t length, const char *word)
{
    size_t row[41], best;
    for (size_t i = 0; i <= length; i++)
        row[i] = i;
    best = row[length];
    for (size_t at = 0; word[at]; at++) {
        size_t diagonal = row[0]++;
        for (size_t i = 1; i <= length; i++) {
            size_t changed = diagonal + (name[i - 1] != word[at]);
            diagonal = row[i];
            row[i] = row[i] < row[i - 1] ? row[i] + 1 : row[i - 1] + 1;
            row[i] = changed < row[i] ? changed : row[i];
        }
        best = row[length] < best ? row[length] : best;
    }
    return best;
}

/* Returns the key of both tables that `name` is most like, the technique's own first, or NULL where none is near: more
   than a third of its letters differ, or it has only one or two. */
static const rd_key *nearest(const rd_settings *settings, const char *name, size_t length)
{
    const rd_key *tables[2] = { settings->own, settings->common }, *found = NULL;
    size_t least = length / 3 + 1;
    for (int t = 0; t < 2 && length > 2 && length <= 40; t++)
        for (const rd_key *key = tables[t]; key && key->name; key++) {
            size_t apart = letters_apart(name, length, key->name);
            if (apart >= least)
                continue;
            least = apart;
            found = key;
        }
    return found;
}

static int unknown_key(const rd_settings *settings, const char *pair, size_t length, char *error)
{
    const rd_key *key = nearest(settings, pair, length);
    snprintf(error, EX_ERROR_SIZE, "--set %.60s: unknown key for this technique%s%s (see %s)", pair,
             key ? "; nearest is " : "", key ? key->name : "", settings->listed);
    return -1;
}

int rd_settings_add(rd_settings *settings, const char *pair, char *error)
{
    const char *equals = strchr(pair, '=');
    const rd_key *key = equals ? find(settings, pair, (size_t)(equals - pair)) : NULL;
    char range[120];
    size_t i;
    if (!equals) {
        snprintf(error, EX_ERROR_SIZE, "--set %.60s: expected key=value", pair);
        return -1;
    }
    if (!key)
        return unknown_key(settings, pair, (size_t)(equals - pair), error);
    if (strlen(equals + 1) >= sizeof settings->set[0].value || !is_valid(key, equals + 1)) {
        describe_range(key, range, sizeof range);
        snprintf(error, EX_ERROR_SIZE, "--set %.60s: the value must be %s", pair, range);
        return -1;
    }
    for (i = 0; i < settings->count && settings->set[i].key != key; i++)
        continue;
    if (i == RD_MAX_SETTINGS) {
        snprintf(error, EX_ERROR_SIZE, "--set: too many keys");
        return -1;
    }
    settings->set[i].key = key;
    strcpy(settings->set[i].value, equals + 1);
    settings->count += i == settings->count;
    return 0;
}

const char *rd_setting_text(const rd_settings *settings, const char *name)
{
    const rd_key *key = find(settings, name, strlen(name));
    for (size_t i = 0; i < settings->count; i++)
        if (settings->set[i].key == key)
            return settings->set[i].value;
    assert(key);
    return key ? key->standard : "";
}

double rd_setting_number(const rd_settings *settings, const char *key)
{
    return strtod(rd_setting_text(settings, key), NULL);
}

int rd_setting_integer(const rd_settings *settings, const char *key)
{
    return (int)rd_setting_number(settings, key);
}

int rd_setting_is(const rd_settings *settings, const char *key, const char *word)
{
    return strcmp(rd_setting_text(settings, key), word) == 0;
}

void rd_print_keys(const rd_key *keys)
{
    for (; keys->name; keys++) {
        char range[100] = "";
        if (keys->kind != RD_WORD)
            snprintf(range, sizeof range, "%s%g..%g", keys->words ? "|" : "", keys->low, keys->high);
        printf("  %-20s %s%s [%s] %s\n", keys->name, keys->words ? keys->words : "", range, keys->standard, keys->help);
    }
}
