#include "units.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

/* Copies code with every identifier that begins with P_ under the new prefix: P_x becomes cohsm__x in csm.h, and
   COHSM__X if it has no lower-case letter, that is, for macros. */
static void append_renamed(text *out, const char *s, size_t size, const char *prefix)
{
    size_t i = 0, end, k;

    while (i < size) {
        if (!is_word(s[i])) {
            append(out, s + i++, 1);
            continue;
        }
        for (end = i; end < size && is_word(s[end]); end++) {}
        if (end - i > 2 && s[i] == 'P' && s[i + 1] == '_') {
            int macro = 1;
            for (k = i + 2; k < end; k++) macro = macro && !islower((unsigned char)s[k]);
            for (k = 0; prefix[k]; k++) {
                char c = (char)(macro ? toupper((unsigned char)prefix[k]) : prefix[k]);
                append(out, &c, 1);
            }
            i += 2;
        }
        append(out, s + i, end - i);
        i = end;
    }
}

/* ---- reading units ---- */

static void add_name(item *it, const char *s)
{
    size_t n = 0;
    if (strncmp(s, "P_", 2) != 0 || it->defined == MAX_DEFINED) return;
    for (s += 2; is_word(s[n]) && n + 1 < MAX_NAME; n++) it->defines[it->defined][n] = s[n];
    it->defines[it->defined++][n] = 0;
}

/* The word before the first parenthesis of a line that begins with "static inline", the one behind "typedef struct". */
static void find_names(item *it)
{
    const char *line, *next, *s;
    for (line = it->text; line < it->text + it->size; line = next) {
        next = line + strcspn(line, "\n") + 1;
        if (strncmp(line, "typedef struct ", 15) == 0) add_name(it, line + 15);
        if (strncmp(line, "static inline ", 14) != 0) continue;
        for (s = line + strcspn(line, "("); is_word(s[-1]); s--) {}
        add_name(it, s);
    }
}

/* A blank line ends an item unless it stands in a function: then an indented one follows. */
static void add_items(units *u, int unit)
{
    const char *s = u->texts[unit].data, *end;
    unsigned long line = 1;

    while (*s) {
        item *it = &u->items[u->item_count++];
        if (u->item_count == MAX_ITEMS) fail(u->names[unit], "makes too many functions for MAX_ITEMS");
        for (end = strchr(s, '\n'); end && end[1] && (end[1] != '\n' || end[2] == ' '); end = strchr(end + 1, '\n')) {}
        if (!end) fail(u->names[unit], "a unit must end with a new line");
        memset(it, 0, sizeof *it);
        it->text = s;
        it->size = (size_t)(end + 1 - s);
        it->unit = unit;
        it->line = line;
        find_names(it);
        end += strspn(end, "\n");
        for (; s < end; s++) line += *s == '\n';
    }
}

void add_unit(units *u, const char *folder, const char *name)
{
    static int depth;
    char path[1024], word[MAX_NAME];
    const char *s;
    text t = { NULL, 0, 0 };
    int i;

    for (i = 0; i < u->count; i++)
        if (strcmp(u->names[i], name) == 0) return;
    if (++depth > MAX_UNITS) fail(name, "is a unit that needs itself");
    if (u->count == MAX_UNITS) fail(name, "is one unit too many");
    print_to(path, sizeof path, "%s/%s.h", folder, name);
    if (!read_file(path, &t)) fail(path, "is no unit: the file cannot be read");
    s = t.data;
    if (strncmp(s, "/* unit ", 8) != 0) fail(path, "does not begin with /* unit");
    s += 8;
    next_word(&s, word);
    if (next_word(&s, word) && strcmp(word, "needs") == 0)
        while (next_word(&s, word)) add_unit(u, folder, word);
    strcpy(u->names[u->count], name);
    u->texts[u->count] = t;
    add_items(u, u->count++);
    depth--;
}

/* ---- what is used ---- */

static int defines(const item *it, const char *name, size_t size)
{
    int i;
    for (i = 0; i < it->defined; i++)
        if (strncmp(it->defines[i], name, size) == 0 && !it->defines[i][size]) return 1;
    return 0;
}

static void mark(units *u, const char *s, size_t size, const char *prefix)
{
    const size_t skip = strlen(prefix);
    const char *text_end = s + size, *end;
    int i;

    for (; s < text_end; s = end + (end == s)) {
        for (end = s; end < text_end && is_word(*end); end++) {}
        if ((size_t)(end - s) <= skip || (size_t)(end - s) - skip >= MAX_NAME) continue;
        if (strncmp(s, prefix, skip) != 0) continue;
        for (i = 0; i < u->item_count; i++) {
            item *it = &u->items[i];
            if (it->used || !defines(it, s + skip, (size_t)(end - s) - skip)) continue;
            it->used = 1;
            mark(u, it->text, it->size, "P_");
        }
    }
}

/* What defines no names is used if any name of its unit is, or if the unit has no names at all. */
void mark_used(units *u, const text *own, const char *prefix)
{
    int named[MAX_UNITS] = { 0 }, i;

    mark(u, own->data, own->size, prefix);
    for (i = 0; i < u->item_count; i++) {
        named[u->items[i].unit] |= u->items[i].defined;
        u->used[u->items[i].unit] |= u->items[i].used;
    }
    for (i = 0; i < u->item_count; i++)
        if (!u->items[i].defined) u->items[i].used = u->used[u->items[i].unit] || !named[u->items[i].unit];
    for (i = 0; i < u->item_count; i++) u->used[u->items[i].unit] |= u->items[i].used;
}

int put_unit(text *out, const units *u, int unit, const char *folder, const char *prefix, int lines)
{
    int i;
    for (i = 0; i < u->item_count; i++) {
        const item *it = &u->items[i];
        if (it->unit != unit || !it->used) continue;
        put(out, "\n");
        if (lines) {
            put(out, "#line ");
            put_number(out, it->line);
            put(out, " \"");
            put(out, folder);
            put(out, "/");
            put(out, u->names[unit]);
            put(out, ".h\"\n");
        }
        append_renamed(out, it->text, it->size, prefix);
    }
    return u->used[unit];
}
