/* stamp - writes units of src/shared into the headers, with the header's private prefix.

   A header holds blocks that begin and end with these lines, the dots standing for the list of units:

       / * >>> shared ...: written by tools/stamp from src/shared, edit there * /
       / * <<< shared * /

   (without the blanks inside the comment marks). What lies between is replaced by the units named, each after the ones
   that its own first line says it needs ("/ * unit octa, needs v3 trig: ... * /"), none twice in a header.
   Functions and structs that neither the header nor what it calls asks for are left out, so that nobody carries dead
   code. An identifier P_x becomes cohsm__x in csm.h, and COHSM__X where it has no lower-case letter, that is, for
   macros.

   stamp SHARED_DIR HEADER...           rewrites the headers that differ
   stamp --check SHARED_DIR HEADER...   compares only; exit 1 and the two commands that repair it on a difference */

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BEGIN "/* >>> shared "
#define END "/* <<< shared */"
#define MAX_UNITS 64
#define MAX_BLOCKS 8
#define MAX_ITEMS 512
#define MAX_DEFINED 8
#define MAX_NAME 64

typedef struct text { char *data; size_t size, room; } text;

/* What stands between two blank lines of a unit, its comment included. */
typedef struct item {
    const char *text;
    size_t size;
    char defines[MAX_DEFINED][MAX_NAME];    /* functions and structs, without P_ */
    int defined;                            /* 0: goes with its unit */
    int unit, used;
} item;

/* Of one header. */
typedef struct units {
    char names[MAX_UNITS][MAX_NAME];
    text texts[MAX_UNITS];
    int used[MAX_UNITS], count;
    item items[MAX_ITEMS];
    int item_count;
} units;

static const char *const prefixes[][2] = {
    { "csm.h", "cohsm__" }, { "shadowfield.h", "sfield__" }, { "envshadow.h", "envsh__" },
    { "rsm.h", "rsm__" },   { "ism.h", "ism__" },            { "gl_backend.h", "glbk__" }
};

static void append(text *t, const char *s, size_t size)
{
    if (t->size + size + 1 > t->room) {
        t->room = 2 * (t->size + size + 1);
        t->data = (char *)realloc(t->data, t->room);
        if (!t->data) exit(1);
    }
    memcpy(t->data + t->size, s, size);
    t->size += size;
    t->data[t->size] = 0;
}

static int read_file(const char *path, text *t)
{
    char buffer[4096];
    size_t n;
    FILE *f = fopen(path, "rb");

    if (!f) return 0;
    append(t, "", 0);
    while ((n = fread(buffer, 1, sizeof buffer, f)) > 0) append(t, buffer, n);
    fclose(f);
    return 1;
}

static int is_word(int c) { return isalnum(c) || c == '_'; }

/* Copies code with every identifier that begins with P_ under the new prefix. */
static void append_renamed(text *out, const char *s, size_t size, const char *prefix)
{
    size_t i = 0, end, k;

    while (i < size) {
        if (!is_word((unsigned char)s[i])) {
            append(out, s + i++, 1);
            continue;
        }
        for (end = i; end < size && is_word((unsigned char)s[end]); end++) {}
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

/* The next word of a list in a comment; 0 at its end, the first character that is no blank or comma. */
static int next_word(const char **s, char *word)
{
    size_t n = 0;
    while (**s == ' ' || **s == ',') (*s)++;
    while (is_word((unsigned char)**s) && n + 1 < MAX_NAME) word[n++] = *(*s)++;
    word[n] = 0;
    return n > 0;
}

/* ---- units and their items ---- */

static void add_name(item *it, const char *s)
{
    if (strncmp(s, "P_", 2) != 0 || it->defined == MAX_DEFINED) return;
    s += 2;
    next_word(&s, it->defines[it->defined++]);
}

/* The word before the first parenthesis of a line that begins with "static inline", the one behind "typedef struct". */
static void find_names(item *it)
{
    const char *line, *next, *s;
    for (line = it->text; line < it->text + it->size; line = next) {
        next = line + strcspn(line, "\n") + 1;
        if (strncmp(line, "typedef struct ", 15) == 0) add_name(it, line + 15);
        if (strncmp(line, "static inline ", 14) != 0) continue;
        for (s = line + strcspn(line, "("); is_word((unsigned char)s[-1]); s--) {}
        add_name(it, s);
    }
}

/* A blank line ends an item unless it stands in a function: then an indented one follows. */
static int add_items(units *u, int unit)
{
    const char *s = u->texts[unit].data, *end;
    while (*s) {
        item *it = &u->items[u->item_count];
        if (u->item_count == MAX_ITEMS) return 0;
        for (end = strchr(s, '\n'); end && end[1] && (end[1] != '\n' || end[2] == ' '); end = strchr(end + 1, '\n')) {}
        if (!end) return 0;
        memset(it, 0, sizeof *it);
        it->text = s;
        it->size = (size_t)(end + 1 - s);
        it->unit = unit;
        find_names(it);
        u->item_count++;
        s = end + strspn(end, "\n");
    }
    return 1;
}

/* Adds the unit after what it needs. names holds those begun, which also stops circles. */
static int add_unit(units *u, const char *folder, const char *name)
{
    char path[1024], word[MAX_NAME];
    const char *s;
    int i, unit = u->count, ok = 1;

    for (i = 0; i < u->count; i++)
        if (strcmp(u->names[i], name) == 0) return 1;
    if (u->count == MAX_UNITS || strlen(folder) + strlen(name) + 4 > sizeof path) return 0;
    strcpy(u->names[u->count++], name);
    sprintf(path, "%s/%s.h", folder, name);
    if (!read_file(path, &u->texts[unit])) {
        fprintf(stderr, "stamp: no unit %s\n", path);
        return 0;
    }
    s = u->texts[unit].data;
    if (strncmp(s, "/* unit ", 8) != 0) {
        fprintf(stderr, "stamp: %s does not begin with /* unit\n", path);
        return 0;
    }
    s += 8;
    next_word(&s, word);
    if (next_word(&s, word) && strcmp(word, "needs") == 0)
        while (ok && next_word(&s, word)) ok = add_unit(u, folder, word);
    return ok && add_items(u, unit);
}

static int defines(const item *it, const char *name, size_t size)
{
    int i;
    for (i = 0; i < it->defined; i++)
        if (strncmp(it->defines[i], name, size) == 0 && !it->defines[i][size]) return 1;
    return 0;
}

/* Marks what a text asks for by names that begin with the prefix, and what that asks for in turn. */
static void mark(units *u, const char *s, size_t size, const char *prefix)
{
    const size_t skip = strlen(prefix);
    const char *text_end = s + size, *end;
    int i;

    for (; s < text_end; s = end + (end == s)) {
        for (end = s; end < text_end && is_word((unsigned char)*end); end++) {}
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

/* What defines no names is used where its unit is: if any of its names is, or it has none at all. */
static void mark_units(units *u)
{
    int named[MAX_UNITS] = { 0 }, i;
    for (i = 0; i < u->item_count; i++) {
        named[u->items[i].unit] |= u->items[i].defined;
        u->used[u->items[i].unit] |= u->items[i].used;
    }
    for (i = 0; i < u->item_count; i++)
        if (!u->items[i].defined) u->items[i].used = u->used[u->items[i].unit] || !named[u->items[i].unit];
}

static void append_items(text *out, const units *u, int from, int to, const char *prefix)
{
    for (; from < to; from++) {
        if (!u->items[from].used) continue;
        append(out, "\n", 1);
        append_renamed(out, u->items[from].text, u->items[from].size, prefix);
    }
    append(out, "\n", 1);
}

/* ---- headers ---- */

/* The next block: its first line, the line after that, its end. 0: none; -1: broken. */
static int find_block(const char *s, const char **begin, const char **inside, const char **end)
{
    *begin = strstr(s, BEGIN);
    if (!*begin) return 0;
    *inside = strchr(*begin, '\n');
    *end = *inside ? strstr(*inside, END) : NULL;
    if (!*end || (*begin != s && (*begin)[-1] != '\n')) return -1;
    ++*inside;
    return 1;
}

/* The units of all blocks, ends of their items, and the text outside of them. */
static int read_blocks(const char *s, units *u, int *ends, text *own, const char *folder)
{
    const char *begin, *inside, *end, *list;
    char word[MAX_NAME];
    int blocks = 0, found;

    while ((found = find_block(s, &begin, &inside, &end)) > 0 && blocks < MAX_BLOCKS) {
        append(own, s, (size_t)(begin - s));
        list = begin + strlen(BEGIN);
        while (next_word(&list, word))
            if (!add_unit(u, folder, word)) return 0;
        ends[blocks++] = u->item_count;
        s = end;
    }
    append(own, s, strlen(s));
    return found == 0;
}

/* The header as it should be. 0 and a message where a block is broken. */
static int stamp(const text *in, text *out, const char *folder, const char *path, const char *prefix)
{
    static units u;
    text own = { NULL, 0, 0 };
    const char *s = in->data, *begin, *inside, *end;
    int ends[MAX_BLOCKS], i, block = 0, ok;

    memset(&u, 0, sizeof u);
    ok = read_blocks(s, &u, ends, &own, folder);
    if (ok) {
        mark(&u, own.data, own.size, prefix);
        mark_units(&u);
        for (; find_block(s, &begin, &inside, &end) > 0; s = end, block++) {
            append(out, s, (size_t)(inside - s));
            append_items(out, &u, block ? ends[block - 1] : 0, ends[block], prefix);
        }
        append(out, s, strlen(s));
    } else {
        fprintf(stderr, "stamp: %s: a shared block without its end, or with a unit that cannot be read\n", path);
    }
    for (i = 0; i < u.count; i++) free(u.texts[i].data);
    free(own.data);
    return ok;
}

static const char *prefix_of(const char *path)
{
    const char *name = strrchr(path, '/');
    size_t i;
    name = name ? name + 1 : path;
    for (i = 0; i < sizeof prefixes / sizeof prefixes[0]; i++)
        if (strcmp(name, prefixes[i][0]) == 0) return prefixes[i][1];
    return NULL;
}

/* 0 on failure; *differs is set where the header is not as it should be. */
static int treat(const char *folder, const char *path, int check, int *differs)
{
    text in = { NULL, 0, 0 }, out = { NULL, 0, 0 };
    const char *prefix = prefix_of(path);
    int ok = prefix && read_file(path, &in) && stamp(&in, &out, folder, path, prefix);

    if (!ok) fprintf(stderr, "stamp: cannot treat %s%s\n", path, prefix ? "" : ": no prefix is known for it");
    if (ok && (in.size != out.size || memcmp(in.data, out.data, in.size) != 0)) {
        *differs = 1;
        printf("stamp: %s %s\n", path, check ? "differs from src/shared" : "written");
        if (!check) {
            FILE *f = fopen(path, "wb");
            ok = f && fwrite(out.data, 1, out.size, f) == out.size;
            if (f && fclose(f) != 0) ok = 0;
            if (!ok) fprintf(stderr, "stamp: cannot write %s\n", path);
        }
    }
    free(in.data);
    free(out.data);
    return ok;
}

int main(int argc, char **argv)
{
    int check = argc > 1 && strcmp(argv[1], "--check") == 0, differs = 0, ok = 1, i;

    if (argc < 2 + check) {
        fprintf(stderr, "usage: stamp [--check] SHARED_DIR HEADER...\n");
        return 2;
    }
    for (i = 2 + check; i < argc; i++) ok = treat(argv[1 + check], argv[i], check, &differs) && ok;
    if (check && differs) {
        printf("repair with:\n    make stamp\n    git commit -m \"stamp: Follow src/shared\" -- src");
        for (i = 2 + check; i < argc; i++) printf(" %s", argv[i]);
        printf("\n");
    }
    return ok && !(check && differs) ? 0 : 1;
}
