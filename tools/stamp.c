/* stamp - writes units of src/shared into the headers, with the header's private prefix.

   A header holds blocks that begin and end with these lines, the dots standing for the list of units:

       / * >>> shared ...: written by tools/stamp from src/shared, edit there * /
       / * <<< shared * /

   (without the blanks inside the comment marks). What lies between is replaced by the units named, each after the ones
   that its own first line says it needs ("/ * unit octa, needs v3 trig: ... * /"), none twice in a header. An
   identifier P_x becomes cohsm__x in csm.h, and COHSM__X where it has no lower-case letter, that is, for macros.

   stamp SHARED_DIR HEADER...           rewrites the headers that differ
   stamp --check SHARED_DIR HEADER...   compares only; exit 1 and the two commands that repair it on a difference */

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BEGIN "/* >>> shared "
#define END "/* <<< shared */"
#define MAX_UNITS 64
#define MAX_NAME 64

typedef struct text { char *data; size_t size, room; } text;
typedef struct units { char names[MAX_UNITS][MAX_NAME]; int count; } units;

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

/* Adds the unit to out after what it needs. done lists those begun, which also stops circles. */
static int add_unit(text *out, const char *folder, const char *name, const char *prefix, units *done)
{
    char path[1024], word[MAX_NAME];
    const char *s, *line_end;
    text unit = { NULL, 0, 0 };
    int i, ok = 1;

    for (i = 0; i < done->count; i++)
        if (strcmp(done->names[i], name) == 0) return 1;
    if (done->count == MAX_UNITS || strlen(folder) + strlen(name) + 4 > sizeof path) return 0;
    strcpy(done->names[done->count++], name);
    sprintf(path, "%s/%s.h", folder, name);
    if (!read_file(path, &unit)) {
        fprintf(stderr, "stamp: no unit %s\n", path);
        return 0;
    }
    s = unit.data;
    line_end = strchr(s, '\n');
    if (strncmp(s, "/* unit ", 8) != 0 || !line_end) {
        fprintf(stderr, "stamp: %s does not begin with /* unit\n", path);
        ok = 0;
    } else {
        s += 8;
        next_word(&s, word);
        if (next_word(&s, word) && strcmp(word, "needs") == 0)
            while (ok && next_word(&s, word)) ok = add_unit(out, folder, word, prefix, done);
        append(out, "\n", 1);
        append_renamed(out, unit.data, unit.size, prefix);
    }
    free(unit.data);
    return ok;
}

/* The header as it should be. 0 and a message where a block is broken. */
static int stamp(const text *in, text *out, const char *folder, const char *path, const char *prefix)
{
    const char *s = in->data, *begin, *line_end, *end;
    char word[MAX_NAME];
    static units done;

    done.count = 0;
    while ((begin = strstr(s, BEGIN)) != NULL) {
        line_end = strchr(begin, '\n');
        end = line_end ? strstr(line_end, END) : NULL;
        if (!end || (begin != in->data && begin[-1] != '\n')) {
            fprintf(stderr, "stamp: %s: a shared block without its end\n", path);
            return 0;
        }
        append(out, s, (size_t)(line_end + 1 - s));
        begin += strlen(BEGIN);
        while (next_word(&begin, word))
            if (!add_unit(out, folder, word, prefix, &done)) return 0;
        append(out, "\n", 1);
        s = end;
    }
    append(out, s, strlen(s));
    return 1;
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
