#define _POSIX_C_SOURCE 200809L
#include "glsl.h"

#include <ctype.h>
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_FILES 256
#define MAX_ARGUMENTS 8

typedef struct file {
    char name[2 * MAX_NAME];    /* lib/NAME.glsl is for other files and for users, prog/NAME.frag is a program */
    const char *owner;          /* begins the name of its array: one C file may hold several headers */
    text body;
    char block[MAX_NAME];       /* the uniform block that it declares, or empty */
} file;

typedef struct files { file at[MAX_FILES]; int count; } files;

static file *add_file(files *all, const char *kind, const char *name)
{
    file *f = &all->at[all->count];
    if (all->count == MAX_FILES) fail(name, "is one file too many");
    all->count++;
    memset(f, 0, sizeof *f);
    f->owner = "glbk__glsl";
    print_to(f->name, sizeof f->name, "%s%s", kind, name);
    return f;
}

/* ---- the lists of bindings, read from the text of the parts ---- */

typedef char arguments[MAX_ARGUMENTS][MAX_NAME];

/* Appends the text behind "#define NAME(X)", without its line ends and comments; for another list that is named in it,
   "OTHER(X)", that list's text. */
static void append_list(text *out, const text *own, const char *name)
{
    char begin[MAX_NAME + 16], other[MAX_NAME];
    const char *s;
    size_t n;

    print_to(begin, sizeof begin, "#define %s(X)", name);
    s = strstr(own->data, begin);
    if (!s) fail(name, "is not defined in any part");
    for (s += strlen(begin); *s && *s != '\n'; s++) {
        n = strspn(s, "ABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789");
        if (*s == '\\' && s[1] == '\n') s++;
        else if (strncmp(s, "/*", 2) == 0) s = strstr(s, "*/") + 1;
        else if (n > 1 && n < MAX_NAME && strncmp(s + n, "(X)", 3) == 0) {
            memcpy(other, s, n);
            other[n] = 0;
            append_list(out, own, other);
            s += n + 2;
        } else append(out, s, 1);
    }
}

static void find_list(text *out, const text *own, const char *name)
{
    append(out, "", 0);
    append_list(out, own, name);
}

/* The next X(a, b, c) of a list; 0 at its end. */
static int next_entry(const char **s, arguments out)
{
    int i = 0;
    size_t n = 0;

    *s = strstr(*s, "X(");
    if (!*s) return 0;
    memset(out, 0, sizeof(arguments));
    for (*s += 2; **s != ')'; (*s)++) {
        if (!**s || n + 1 == MAX_NAME || i == MAX_ARGUMENTS) fail("a list of bindings", "has an entry that is broken");
        if (**s == ',') i++, n = 0;
        else if (n || **s != ' ') out[i][n++] = **s;
    }
    return i + 1;
}

/* Puts "TYPE NAME", or ", NAME" where the declaration before has the same type: its words need not be said again. */
static void put_declarator(text *out, char *type, const char *before, const char *of_type, const char *name)
{
    const char *line = strrchr(out->data, '\n');
    if (strcmp(type, of_type) == 0) put(out, strlen(line) + strlen(name) < 90 ? ", " : ",\n    ");
    else {
        if (*type) put(out, ";\n");
        put_format(out, "%s%s ", before, of_type);
    }
    put(out, name);
    print_to(type, MAX_NAME, "%s", of_type);
}

/* A file of its own for each block, for those who name it: all members of a std140 block are active whether a program
   reads them or not, and WebGL 2 refuses to draw with an active block without a buffer (ES 3.0 leaves it undefined). */
static void add_blocks(files *all, const text *own, const char *list)
{
    text members = { NULL, 0, 0 };
    const char *s = list, *m;
    char name[MAX_NAME + 8], type[MAX_NAME];
    arguments block, member;
    file *f;

    while (next_entry(&s, block)) {
        print_to(name, sizeof name, "%s.glsl", block[0] + strlen("glbk_"));
        f = add_file(all, "lib/", name);
        strcpy(f->block, block[0]);
        put_format(&f->body, "// %s, uniform block\n", block[0]);
        put_format(&f->body, "layout(std140) uniform %s_block {\n", block[0]);
        find_list(&members, own, block[2]);
        *type = 0;
        for (m = members.data; next_entry(&m, member);) {
            put_declarator(&f->body, type, "    ", member[0], member[1]);
            if (strcmp(member[2], "1") != 0) put_format(&f->body, "[%s]", member[2]);
        }
        put_format(&f->body, ";\n} %s;\n", block[0], "", "", "");
        free_text(&members);
    }
}

static void add_part(files *all, const text *own, const char *part)
{
    text list = { NULL, 0, 0 };
    char name[MAX_NAME + 32], lower[MAX_NAME], type[MAX_NAME] = "";
    const char *s;
    arguments a;
    file *f;
    size_t i;
    int compute = 0;

    for (i = 0; part[i]; i++) lower[i] = (char)tolower((unsigned char)part[i]);
    lower[i] = 0;
    print_to(name, sizeof name, "%s_bindings.glsl", lower);
    f = add_file(all, "lib/", name);
    put_format(&f->body, "// %s_bindings - from the lists GLBK_%s_* of the header.\n", lower, part);
    print_to(name, sizeof name, "GLBK_%s_TEXTURES", part);
    find_list(&list, own, name);
    for (s = list.data; next_entry(&s, a);) put_declarator(&f->body, type, "uniform ", a[0], a[1]);
    if (*type) put(&f->body, ";\n");
    free_text(&list);
    print_to(name, sizeof name, "GLBK_%s_STORAGE", part);
    find_list(&list, own, name);
    for (s = list.data; next_entry(&s, a);) {
        if (!compute++) put(&f->body, "#if __VERSION__ >= 430\n");
        put_format(&f->body, "layout(std430, binding = %s) %s buffer ", a[3], a[0]);
        put_format(&f->body, "%s_storage { %s %s[]; };\n", a[2], a[1], a[2], "");
    }
    free_text(&list);
    print_to(name, sizeof name, "GLBK_%s_IMAGES", part);
    find_list(&list, own, name);
    for (s = list.data; next_entry(&s, a);) {
        if (!compute++) put(&f->body, "#if __VERSION__ >= 430\n");
        put_format(&f->body, "layout(%s, binding = %s) ", a[1], a[4]);
        put_format(&f->body, "%s uniform %s %s;\n", a[0], a[2], a[3], "");
    }
    free_text(&list);
    if (compute) put(&f->body, "#endif\n");
    print_to(name, sizeof name, "GLBK_%s_BLOCKS", part);
    find_list(&list, own, name);
    add_blocks(all, own, list.data);
    free_text(&list);
}

/* Every part with a list of textures, which may be empty. */
static void add_parts(files *all, const text *own)
{
    const char *s = own->data, *end;
    char part[MAX_NAME];

    while ((s = strstr(s, "#define GLBK_")) != NULL) {
        s += strlen("#define GLBK_");
        for (end = s; isupper((unsigned char)*end); end++) {}
        if (strncmp(end, "_TEXTURES(X)", 12) != 0 || end - s >= MAX_NAME) continue;
        memcpy(part, s, (size_t)(end - s));
        part[end - s] = 0;
        add_part(all, own, part);
    }
}

/* ---- the files ---- */

static int ends_with(const char *s, const char *end)
{
    size_t n = strlen(s), m = strlen(end);
    return n > m && strcmp(s + n - m, end) == 0;
}

/* FOLDER/NAME, if it is GLSL: the file, else NULL. */
static file *add_source(files *all, const char *folder, const char *name)
{
    char path[1024];
    int is_library = ends_with(name, ".glsl");
    int is_program = ends_with(name, ".vert") || ends_with(name, ".frag") || ends_with(name, ".comp");
    file *f;

    if (!is_library && !is_program) return NULL;
    f = add_file(all, is_library ? "lib/" : "prog/", name);
    print_to(path, sizeof path, "%s/%s", folder, name);
    if (!read_file(path, &f->body)) fail(path, "cannot be read");
    if (!f->body.size || f->body.data[f->body.size - 1] != '\n') fail(path, "does not end with a new line");
    return f;
}

static void add_folder(files *all, const char *folder, const char *without)
{
    DIR *dir = opendir(folder);
    struct dirent *entry;

    if (!dir) fail(folder, "is no folder");
    while ((entry = readdir(dir)) != NULL)
        if (!without || !find_word(without, entry->d_name)) (void)add_source(all, folder, entry->d_name);
    closedir(dir);
}

static int compare_names(const void *a, const void *b)
{
    return strcmp(((const file *)a)->name, ((const file *)b)->name);
}

/* ---- as C ---- */

static const file *find_library(const files *all, const char *name)
{
    char path[2 * MAX_NAME];
    int i;
    print_to(path, sizeof path, "lib/%s.glsl", name);
    for (i = 0; i < all->count; i++)
        if (strcmp(all->at[i].name, path) == 0) return &all->at[i];
    return NULL;
}

/* Whether a file that f uses, one way or another, names the block. */
static int brings(const files *all, const file *f, const char *block)
{
    const char *s = f->body.data;
    char name[MAX_NAME];

    for (; s; s = strchr(s, '\n')) {
        s += *s == '\n';
        if (strncmp(s, "// uses:", 8) != 0) continue;
        s += 8;
        while (next_word(&s, name)) {
            const file *used = find_library(all, name);
            if (used && (find_word(used->body.data, block) || brings(all, used, block))) return 1;
        }
    }
    return 0;
}

/* Appends the value of a comment "// key: value" as a C string; to that of uses, the blocks that the file names and
   that none of those brings. A value that is too long for a line goes on in another one with the same key. */
static void put_value(text *out, const files *all, const file *f, const char *key)
{
    const char *s = f->body.data;
    const char *usual = strcmp(key, "with") == 0 ? "screen.vert\n" : "\n";     /* a .frag has it without a word */
    size_t length = strlen(key), before;
    int i;

    put(out, "\"");
    before = out->size;
    while (s && *s) {
        if (strncmp(s, "// ", 3) == 0 && strncmp(s + 3, key, length) == 0 && s[3 + length] == ':') {
            s += 4 + length;
            while (*s == ' ') s++;
            if (out->size > before) put(out, strcmp(key, "sets") == 0 ? " | " : " ");
            if (strncmp(s, usual, strlen(usual)) != 0) append(out, s, strcspn(s, "\n"));
        }
        s = strchr(s, '\n');
        if (s) s++;
    }
    for (i = 0; i < all->count && strcmp(key, "uses") == 0; i++) {
        const file *other = &all->at[i];
        const char *name = other->name + strlen("lib/");
        if (!other->block[0] || other == f || !find_word(f->body.data, other->block)) continue;
        if (brings(all, f, other->block)) continue;
        if (out->size > before) put(out, " ");
        append(out, name, strcspn(name, "."));
    }
    put(out, "\"");
}

static void put_identifier(text *out, const file *f)
{
    const char *name = f->name;
    put_format(out, "%s_", f->owner);
    for (; *name; name++) {
        char c = *name;
        if (!is_word(c)) c = '_';
        append(out, &c, 1);
    }
}

static unsigned long count_lines(const char *s)
{
    unsigned long count = 0;
    for (; *s; s++) count += *s == '\n';
    return count;
}

static void put_escaped(text *out, const char *name, const char *s, size_t size)
{
    for (; size; s++, size--) {
        if (*s != '\n' && ((unsigned char)*s < 32 || (unsigned char)*s > 126))
            fail(name, "has a character beyond ASCII");
        if (*s == '\n') put(out, "\\n");
        else {
            if (*s == '"' || *s == '\\') put(out, "\\");
            append(out, s, 1);
        }
    }
}

/* Whether tokens change if the blank between these two goes: words would become one, and so might operators, whose last
   characters are = and those that stand twice. */
static int divides(char before, char after)
{
    if (is_word(before) || is_word(after)) return is_word(before) && is_word(after);
    return (after == '=' && strchr("=!<>+-*/%&|^", before)) || (before == after && strchr("+-&|^<>", after)) ||
           (before == '/' && strchr("/*", after)) || (before == '.' && after == '.');
}

/* Whether s begins a zero of a number that says nothing: that before the point of 0.5, that behind it in 1.0. */
static int is_idle_zero(const text *out, const char *s)
{
    const char before = out->size ? out->data[out->size - 1] : ' ';
    if (*s != '0') return 0;
    if (s[1] == '.' && s[2] >= '0' && s[2] <= '9') return !is_word(before) && before != '.';
    return before == '.' && out->size > 1 && out->data[out->size - 2] >= '0' && out->data[out->size - 2] <= '9' &&
           !is_word(s[1]) && s[1] != '.';
}

/* The text without comments, without blanks that divide nothing, of which a quarter of it is made, and without zeros
   and "in" that say nothing. Lines stay lines, so that a driver's message names the right one; those of the
   preprocessor stay whole. */
static void strip(text *out, const char *s)
{
    int whole = 0, begins = 1;

    append(out, "", 0);
    while (*s) {
        if (begins) {
            s += strspn(s, " ");
            whole = *s == '#' || (whole && out->size > 1 && out->data[out->size - 2] == '\\');
            begins = 0;
        }
        if (strncmp(s, "//", 2) == 0) s += strcspn(s, "\n");
        else if (strncmp(s, "/*", 2) == 0) {
            for (; *s && strncmp(s, "*/", 2) != 0; s++)
                if (*s == '\n') append(out, s, 1);
            if (*s) s += 2;
            append(out, " ", 1);
        } else if (*s == '\n') {
            while (out->size && out->data[out->size - 1] == ' ') out->data[--out->size] = 0;
            append(out, s++, 1);
            begins = 1;
        } else if (!whole && is_idle_zero(out, s)) s++;
        else if (strncmp(s, "const in ", 9) == 0) {     /* the same as const */
            append(out, s, 6);
            s += 9;
        }
        else if (*s == ' ' && !whole && (s[1] == ' ' || (out->size && !divides(out->data[out->size - 1], s[1])))) s++;
        else append(out, s++, 1);
    }
}

/* Puts the member for a string of `length` characters: " char s2[1235];", three on a line. */
static void put_member(text *out, unsigned long number, size_t length)
{
    if (number && number % 3 == 0) put(out, "\n   ");
    put(out, " char s");
    put_number(out, number);
    put(out, "[");
    put_number(out, (unsigned long)length + 1);
    put(out, "];");
}

/* Puts what is known of a file, a C string each, each ended by 0: its name and its values. */
static void put_facts(text *out, const files *all, const file *f)
{
    static const char *const keys[] = { "uses", "with", "sets" };
    int k;
    put(out, "\"");
    put(out, f->name);
    put(out, "\\0\"");
    for (k = 0; k < 3; k++) {
        put(out, k == 2 ? "\n    " : " ");
        put_value(out, all, f, keys[k]);
        put(out, " \"\\0\"");
    }
    put(out, " \"");
    put(out, f->block);
    put(out, "\"");
}

/* The characters of C strings that stand side by side, of which "\0" is one. */
static size_t literal_length(const char *s)
{
    size_t length = 0;
    int inside = 0;
    for (; *s; s++) {
        if (*s == '"') inside = !inside;
        else if (inside) {
            if (*s == '\\') s++;
            length++;
        }
    }
    return length;
}

/* Puts C strings one behind the other into a struct, which needs no pointers: what is known of the file, then its text
   in strings of up to LONGEST characters, since a compiler for C99 need not take more than 4,095, and an empty one
   behind the last. Each line of the header has one of the text, with the empty lines before it. */
static void put_strings(text *out, const files *all, const file *f)
{
    enum { LONGEST = 4000 };
    text plain = { NULL, 0, 0 }, strings = { NULL, 0, 0 }, facts = { NULL, 0, 0 };
    const char *s;
    size_t length = 0, line;
    unsigned long count = 0;

    strip(&plain, f->body.data);
    put_facts(&facts, all, f);
    put(out, "\nstatic const struct { char facts[");
    put_number(out, (unsigned long)literal_length(facts.data) + 1);
    put(out, "];\n   ");
    put(&strings, "\"");
    for (s = plain.data; *s; s += line) {
        line = strspn(s, "\n");
        line += s[line] ? strcspn(s + line, "\n") + 1 : 0;
        if (length && length + line > LONGEST) {
            put_member(out, count++, length);
            length = 0;
            put(&strings, "\",\n    \"");
        } else if (length) put(&strings, "\"\n    \"");
        length += line;
        put_escaped(&strings, f->name, s, line);
    }
    put_member(out, count, length);
    put(out, " char end; } ");
    put_identifier(out, f);
    put(out, " GLBK__TIGHT = {\n    ");
    append(out, facts.data, facts.size);
    put(out, ",\n    ");
    append(out, strings.data, strings.size);
    put(out, "\", 0\n};\n");
    free_text(&facts);
    free_text(&strings);
    free_text(&plain);
}

static void put_table(text *out, const files *all, const char *table)
{
    int i;
    put(out, "\nstatic const glbk_file ");
    put(out, table);
    put(out, "[] = {\n");
    for (i = 0; i < all->count; i++) {
        put(out, "    { (const char *)&");
        put_identifier(out, &all->at[i]);
        put(out, i + 1 < all->count ? " },\n" : " }\n};\n\n");
    }
}

void put_glsl(text *out, const char *folder, const char *shared, const char *names, const char *without,
              const text *own, const char *table)
{
    static files all;
    char name[MAX_NAME], path[2 * MAX_NAME];
    int i;

    all.count = 0;
    add_parts(&all, own);
    add_folder(&all, folder, without);
    while (next_word(&names, name)) {
        print_to(path, sizeof path, "%s.glsl", name);
        add_source(&all, shared, path)->owner = table;
    }
    qsort(all.at, (size_t)all.count, sizeof all.at[0], compare_names);
    for (i = 0; i < all.count; i++) {
        put_strings(out, &all, &all.at[i]);
        if (count_lines(all.at[i].body.data) > 999)
            fail(all.at[i].name, "has more than 999 lines, which the messages of drivers could not tell apart");
    }
    put_table(out, &all, table);
    for (i = 0; i < all.count; i++) free_text(&all.at[i].body);
}
