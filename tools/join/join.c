/* join - makes the headers that users copy from their parts under src/, and takes an edited header apart again.

   join                       writes every header that a parts.txt under src/ describes, if it differs from its parts
   join HEADER...             only these, as csm.h or gl_backend/gl_csm.h
   join --check [HEADER...]   writes nothing; exit status 1 and the commands that repair it if a header differs
   join --back FILE           writes what was edited in FILE, a header, into its parts and names them. Edits of shared
                              units and GLSL, which lie in FILE under other names or without comments, are shown only

   --to FOLDER                writes under FOLDER instead of over the headers
   --without "NAME..."        leaves out optional parts, all of them for "all"; defines PREFIX_WITHOUT_NAME for what
                              else speaks of them, decides every #if by it, and leaves out private functions
                              that nothing calls any more
   --lines                    with #line directives, so that compilers and debuggers name the parts

   A parts.txt says in its lines, in the order of the header:

   header csm.h               the file that is made
   prefix cohsm               the prefix of its names: a shared unit's P_v3 becomes cohsm__v3, its P_X86 COHSM__X86
   query.h                    a part
   pack.h optional pack       a part that --without "pack" leaves out
   peel.vert optional build   GLSL that is left out so; without such a line a file of the folder is in every header
   optional simd X86=0        without "simd", COHSM__X86 is 0 in every #if, which is decided by it
   units glbk_csm             another prefix for shared units and WITHOUT macros alone: headers of one prefix that lie
                              in one file
   shared v3 m4               units of src/shared, without functions, structs and macros that this header does not use
   glsl glbk__csm_files       the folder's GLSL and a table of this name (glsl.h); behind it the names of files of
                              src/shared that several headers have: glsl glbk__csm_files cohsm_math
   # ...                      a comment */

#define _POSIX_C_SOURCE 200809L
#include "fold.h"
#include "glsl.h"
#include "text.h"
#include "units.h"

#include <ctype.h>
#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SHARED "src/shared"
#define MARK "/* ==== "
#define MARK_END " ==== */\n"
#define MAX_PARTS 256

typedef enum kind { PART, UNIT, GLSL } kind;

/* What lies under one mark of a header. */
typedef struct part {
    kind what;
    char name[2 * MAX_NAME];    /* as its mark says it: src/csm/query.h */
    char table[MAX_NAME];
    char shared[MAX_NAME];      /* of GLSL: files of src/shared, separated by blanks */
    int unit;
    text body;                  /* as it stands in the header */
} part;

typedef struct header {
    char folder[MAX_NAME], path[MAX_NAME], prefix[MAX_NAME];    /* src/csm, csm.h, cohsm__ */
    char unit_prefix[MAX_NAME];     /* empty: prefix */
    part parts[MAX_PARTS];
    int count;
    units shared;
    text optional;              /* the names of its optional parts */
    text left_out;              /* defines for those that are left out */
    text left_out_files;        /* GLSL of these */
    text values;                /* what #if are decided by in a lean header: see fold.h */
} header;

typedef struct options {
    int check, lines;
    const char *to, *without, *back;
} options;

/* ---- parts.txt ---- */

static part *add_part(header *h, kind what)
{
    if (h->count == MAX_PARTS) fail(h->path, "has too many parts");
    memset(&h->parts[h->count], 0, sizeof(part));
    h->parts[h->count].what = what;
    return &h->parts[h->count++];
}

static const char *unit_prefix(const header *h) { return h->unit_prefix[0] ? h->unit_prefix : h->prefix; }

/* The units named, after those that they need and that are not there yet, a part each. */
static void add_units(header *h, const char *list)
{
    const char *values = h->left_out.size ? h->values.data : NULL;
    char name[MAX_NAME];
    int i = h->shared.count;
    while (next_word(&list, name)) add_unit(&h->shared, SHARED, name, unit_prefix(h), values);
    for (; i < h->shared.count; i++) {
        part *p = add_part(h, UNIT);
        p->unit = i;
        print_to(p->name, sizeof p->name, "%s/%s.h", SHARED, h->shared.names[i]);
    }
}

/* A name in capitals behind the prefix of the header's units: "COHSM_WITHOUT_PACK" of "_WITHOUT_" and "pack". */
static void make_macro(char macro[4 * MAX_NAME], const header *h, const char *between, const char *name)
{
    size_t i;
    print_to(macro, 4 * MAX_NAME, "%.*s%s%s", (int)strlen(unit_prefix(h)) - 2, unit_prefix(h), between, name);
    for (i = 0; macro[i]; i++) macro[i] = (char)toupper((unsigned char)macro[i]);
}

/* Notes an optional part, once. Returns whether it is left out. */
static int is_left_out(header *h, const char *name, const options *o)
{
    const int out = o->without && (find_word(o->without, name) || strcmp(o->without, "all") == 0);
    char macro[4 * MAX_NAME];

    if (h->optional.size && find_word(h->optional.data, name)) return out;
    put_format(&h->optional, "%s ", name);
    make_macro(macro, h, "_WITHOUT_", name);
    put_format(&h->values, "%s%s ", macro, out ? "=1" : "");
    if (out) put_format(&h->left_out, "#define %s\n", macro);
    return out;
}

/* "simd X86=0 WIDTH=1", what #if know where simd is left out. */
static void add_values(header *h, const char *s, const options *o)
{
    char word[MAX_NAME], macro[4 * MAX_NAME];
    if (!next_word(&s, word)) fail(h->folder, "has a line optional without a name");
    if (!is_left_out(h, word, o)) return;
    while (next_word(&s, word)) {
        make_macro(macro, h, "__", word);
        put_format(&h->values, "%s ", macro);
    }
}

/* A part, or GLSL that may be left out. */
static void add_file_part(header *h, const char *name, const char *rest, const options *o)
{
    const int is_glsl = !strstr(name, ".h");
    char word[MAX_NAME];
    int left_out = 0;
    char path[2 * MAX_NAME];
    text body = { NULL, 0, 0 };
    part *p;

    print_to(path, sizeof path, "%s/%s", h->folder, name);
    if (!read_file(path, &body)) fail(path, "cannot be read");
    if (!body.size || body.data[body.size - 1] != '\n') fail(path, "does not end with a new line");
    if (next_word(&rest, word)) {
        if (strcmp(word, "optional") != 0 || !next_word(&rest, word)) fail(name, "may be followed by: optional NAME");
        left_out = is_left_out(h, word, o);
    }
    if (is_glsl && left_out) put_format(&h->left_out_files, "%s ", name);
    if (is_glsl || left_out) {
        free_text(&body);
        return;
    }
    p = add_part(h, PART);
    strcpy(p->name, path);
    p->body = body;
}

static void read_line(header *h, const char *s, const options *o)
{
    char word[MAX_NAME], list[MAX_NAME];
    part *p;

    if (*s == '#' || !next_word(&s, word)) return;
    if (strcmp(word, "header") == 0) next_word(&s, h->path);
    else if (strcmp(word, "prefix") == 0) {
        next_word(&s, word);
        print_to(h->prefix, sizeof h->prefix, "%s__", word);
    } else if (strcmp(word, "units") == 0) {
        next_word(&s, word);
        print_to(h->unit_prefix, sizeof h->unit_prefix, "%s__", word);
    } else if (strcmp(word, "optional") == 0) add_values(h, s, o);
    else if (strcmp(word, "shared") == 0) add_units(h, s);
    else if (strcmp(word, "glsl") == 0) {
        p = add_part(h, GLSL);
        print_to(p->name, sizeof p->name, "GLSL of %s", h->folder);
        next_word(&s, p->table);
        while (next_word(&s, word)) print_to(p->shared, sizeof p->shared, "%s %s", strcpy(list, p->shared), word);
    } else add_file_part(h, word, s, o);
}

static header *read_header(const char *list, const options *o)
{
    header *h = (header *)calloc(1, sizeof *h);
    text lines = { NULL, 0, 0 };
    const char *s;
    size_t folder = strlen(list) - strlen("/parts.txt");

    if (!h || folder >= sizeof h->folder) fail(list, "is too long a name");
    memcpy(h->folder, list, folder);
    if (!read_file(list, &lines)) fail(list, "cannot be read");
    for (s = lines.data; *s; s += strcspn(s, "\n") + 1) {
        read_line(h, s, o);
        if (!strchr(s, '\n')) break;
    }
    free_text(&lines);
    if (!h->path[0] || !h->prefix[0] || !h->count || h->parts[0].what != PART)
        fail(list, "needs the lines header and prefix, and a part before all others");
    return h;
}

static void free_header(header *h)
{
    int i;
    for (i = 0; i < h->count; i++) free_text(&h->parts[i].body);
    for (i = 0; i < h->shared.count; i++) free_text(&h->shared.texts[i]);
    free_text(&h->optional);
    free_text(&h->left_out);
    free_text(&h->left_out_files);
    free_text(&h->values);
    free(h);
}

/* ---- joining ---- */

/* Makes a lean header's parts items of which only the used ones are put. The first part is for people. */
static void make_lean(header *h)
{
    int i;
    for (i = 1; i < h->count; i++) {
        part *p = &h->parts[i];
        if (p->what != PART) continue;
        p->unit = add_part_as_unit(&h->shared, p->name, &p->body);
        p->what = UNIT;
    }
}

/* Fills in the bodies that are made from others. */
static void make_bodies(header *h, int lines)
{
    text own = { NULL, 0, 0 };
    int i;

    append(&own, "", 0);
    for (i = 0; i < h->count; i++) {
        part *p = &h->parts[i];
        if (p->what != PART) continue;
        if (h->left_out.size) fold(&p->body, h->values.data);
        append(&own, p->body.data, p->body.size);
    }
    if (h->left_out.size) make_lean(h);
    mark_used(&h->shared, h->left_out.size ? &h->parts[0].body : &own);
    for (i = 0; i < h->count; i++) {
        part *p = &h->parts[i];
        if (p->what == UNIT) {
            free_text(&p->body);
            put_unit(&p->body, &h->shared, p->unit, SHARED, lines);
        }
        if (p->what == GLSL) put_glsl(&p->body, h->folder, SHARED, p->shared, h->left_out_files.data, &own, p->table);
    }
    free_text(&own);
}

/* The first part begins with the title and therefore has no mark. */
static void join(text *out, const header *h, int lines)
{
    int i;
    for (i = 0; i < h->count; i++) {
        const part *p = &h->parts[i];
        if (!p->body.size) continue;
        if (i) {
            put(out, "\n" MARK);
            put(out, p->name);
            put(out, MARK_END "\n");
        }
        if (lines && p->what == PART) {
            put(out, "#line 1 \"");
            put(out, p->name);
            put(out, "\"\n");
        }
        append(out, p->body.data, p->body.size);
        if (!i && h->left_out.size) append(out, h->left_out.data, h->left_out.size);
    }
}

/* Returns 1 if the header differs from what is there already. */
static int write_header(const header *h, const options *o)
{
    char path[1024];
    text made = { NULL, 0, 0 }, there = { NULL, 0, 0 };
    int differs;

    print_to(path, sizeof path, "%s%s%s", o->to ? o->to : "", o->to ? "/" : "", h->path);
    join(&made, h, o->lines);
    differs = !read_file(path, &there) || made.size != there.size || memcmp(made.data, there.data, made.size) != 0;
    if (differs) {
        printf("join: %s %s\n", path, o->check ? "differs from its parts" : "written");
        if (!o->check) write_file(path, &made);
    }
    free_text(&made);
    free_text(&there);
    return differs;
}

/* ---- and back ---- */

static part *find_part(header *h, const char *name, size_t length)
{
    int i;
    for (i = 0; i < h->count; i++)
        if (strncmp(h->parts[i].name, name, length) == 0 && !h->parts[i].name[length]) return &h->parts[i];
    return NULL;
}

/* One piece of an edited header. Returns 1 if it could not be put into its part. */
static int take_back(part *p, const char *s, size_t size)
{
    text edited = { NULL, 0, 0 };
    if (size == p->body.size && memcmp(s, p->body.data, size) == 0) return 0;
    if (p->what != PART) {
        printf("join: %s was edited in the header: edit it there, this is not taken back\n", p->name);
        return 1;
    }
    append(&edited, s, size);
    write_file(p->name, &edited);
    printf("join: %s written\n", p->name);
    free_text(&edited);
    return 0;
}

/* Its parts are not whole. */
static int is_lean(const header *h, const char *file)
{
    char macro[4 * MAX_NAME], line[5 * MAX_NAME];
    make_macro(macro, h, "_WITHOUT_", "");
    print_to(line, sizeof line, "\n#define %s", macro);
    return strstr(file, line) != NULL;
}

/* A piece ends before the blank line above the next mark. */
static int back(header *h, const char *path)
{
    text file = { NULL, 0, 0 };
    const char *s, *next, *end;
    part *p = &h->parts[0];
    int failed = 0;

    if (!read_file(path, &file)) fail(path, "cannot be read");
    if (is_lean(h, file.data)) fail(path, "is without optional parts: mend the whole header");
    for (s = file.data; s; s = next) {
        next = strstr(s, "\n" MARK);
        failed |= take_back(p, s, next ? (size_t)(next - s) : strlen(s));
        if (!next) break;
        next += strlen("\n" MARK);
        end = strstr(next, MARK_END "\n");
        p = end ? find_part(h, next, (size_t)(end - next)) : NULL;
        if (!p) fail(path, "has a mark /* ==== of a part that parts.txt does not name");
        next = end + strlen(MARK_END "\n");
    }
    free_text(&file);
    return failed;
}

/* ---- arguments ---- */

static int is_wanted(const header *h, char **names, int count)
{
    int i;
    for (i = 0; i < count; i++)
        if (strcmp(names[i], h->path) == 0) return 1;
    return count == 0;
}

/* The header that a path ends with: work/csm.h is csm.h, which x_csm.h is not. */
static int is_header(const header *h, const char *path)
{
    size_t n = strlen(path), m = strlen(h->path);
    const char *file = strrchr(h->path, '/') ? strrchr(h->path, '/') + 1 : h->path;
    if (n < m) m = strlen(file);
    if (n < m) return 0;
    return strcmp(path + n - m, h->path + strlen(h->path) - m) == 0 && (n == m || path[n - m - 1] == '/');
}

/* A list with a name that means nothing is a mistake. */
static void check_names(const header *h, const char *list)
{
    char name[MAX_NAME];
    while (next_word(&list, name))
        if (!h->optional.size || !find_word(h->optional.data, name)) fail(name, "is no optional part of this header");
}

static int treat_all(const options *o, char **names, int count)
{
    glob_t lists;
    size_t i;
    int differs = 0, found = 0;

    if (glob("src/*/parts.txt", 0, NULL, &lists) != 0) fail("src/*/parts.txt", "there is none: start join in the root");
    for (i = 0; i < lists.gl_pathc; i++) {
        header *h = read_header(lists.gl_pathv[i], o);
        int wanted = o->back ? is_header(h, o->back) : is_wanted(h, names, count);
        if (wanted) {
            found++;
            if (o->without && strcmp(o->without, "all") != 0) check_names(h, o->without);
            make_bodies(h, o->lines);
            differs |= o->back ? back(h, o->back) : write_header(h, o);
        }
        free_header(h);
    }
    globfree(&lists);
    if (!found || (!o->back && count && found < count)) fail("arguments", "name a header that no parts.txt makes");
    return differs;
}

int main(int argc, char **argv)
{
    options o = { 0, 0, NULL, NULL, NULL };
    int i = 1, differs;

    for (; i < argc && argv[i][0] == '-'; i++) {
        if (strcmp(argv[i], "--check") == 0) o.check = 1;
        else if (strcmp(argv[i], "--lines") == 0) o.lines = 1;
        else if (strcmp(argv[i], "--to") == 0 && i + 1 < argc) o.to = argv[++i];
        else if (strcmp(argv[i], "--without") == 0 && i + 1 < argc) o.without = argv[++i];
        else if (strcmp(argv[i], "--back") == 0 && i + 1 < argc) o.back = argv[++i];
        else fail(argv[i], "is no option; they are --check --back FILE --to FOLDER --without NAMES --lines");
    }
    differs = treat_all(&o, argv + i, argc - i);
    if (o.check && differs) printf("repair with:\n    make join\n    git commit -- src '*.h'\n");
    return differs && (o.check || o.back) ? 1 : 0;
}
