#include "units.h"
#include "fold.h"

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

/* A public function with its body, which goes if its declaration is gone: COHSM_DEF int cohsm_x(void) { ... }. */
static int is_public_definition(const item *it, const char *line)
{
    size_t n = 0;
    while (is_word(line[n])) n++;
    return n > 4 && strncmp(line + n - 4, "_DEF ", 5) == 0 && it->size > 1 && it->text[it->size - 2] == '}';
}

/* The word that begins at s, or with ends the one that ends before it. Only private names count, cohsm__v3, COHSM__X86,
   and public ones where they are defined. Returns whether it is one. */
static int add_name(item *it, const char *begin, const char *s, int ends)
{
    const char *end = s, *at;
    int counts = ends && is_public_definition(it, begin);

    if (ends) for (; s > begin && s[-1] == ' '; s--, end--) {}
    if (ends) for (; s > begin && is_word(s[-1]); s--) {}
    else for (; is_word(*end); end++) {}
    for (at = s; at + 1 < end; at++) counts |= at > s && at[0] == '_' && at[1] == '_';
    if (!counts || *s == '_' || (ends && s == begin)) return 0;
    if (it->defined < MAX_DEFINED) {
        it->defines[it->defined].s = s;
        it->defines[it->defined].size = (size_t)(end - s);
    }
    it->defined++;
    return 1;
}

/* What follows the word that the line begins with, perhaps behind typedef; or NULL. */
static const char *behind(const char *line, const char *word)
{
    if (strncmp(line, "typedef ", 8) == 0) line += 8;
    return strncmp(line, word, strlen(word)) == 0 ? line + strlen(word) : NULL;
}

/* What a line in the first column defines: a macro, a struct, a function or an array. Returns 0 if it may define more
   than private names: what it calls a macro for, enums, other types, public names. */
static int find_name(item *it, const char *line)
{
    const char *s;
    if ((s = behind(line, "#define ")) != NULL || (s = behind(line, "struct ")) != NULL ||
        (s = behind(line, "union ")) != NULL) return add_name(it, line, s, 0);
    if (!isalpha((unsigned char)*line)) return 1;
    if (strncmp(line, "typedef ", 8) == 0 || strncmp(line, "enum", 4) == 0) return 0;
    return add_name(it, line, line + strcspn(line, "([=;,\n"), 1);
}

/* The end of a comment that begins here, or s. */
static const char *skip_comment(const char *s, const char *end)
{
    if (end - s < 4 || s[0] != '/' || s[1] != '*') return s;
    for (s += 3; s < end && !(s[-1] == '*' && s[0] == '/'); s++) {}
    return s < end ? s + 1 : end;
}

/* An item that opens an #if and does not end it, or ends another's, or speaks to the compiler, or defines what is not
   known here, has no names: whether it stays is not a matter of what it defines. */
static void find_names(item *it)
{
    const char *line, *next, *end = it->text + it->size, *code;
    int depth = 0, whole = 1;

    it->comment = 1;
    for (line = it->text; line < end; line = next) {
        code = skip_comment(line, end);
        if (code > line) {
            next = code + strspn(code, " ");
            if (next < end && *next == '\n') next++;
            if (next == code) it->comment = 0;
            continue;
        }
        next = line + strcspn(line, "\n") + 1;
        if (*line != '\n') it->comment = 0;
        depth += strncmp(line, "#if", 3) == 0;
        depth -= strncmp(line, "#endif", 6) == 0;
        whole &= depth >= 0 && strncmp(line, "#pragma", 7) != 0 && find_name(it, line);
    }
    if (depth || !whole || it->defined > MAX_DEFINED) it->defined = 0;
}

/* A line of a list of names that every instruction set has of its own (unit simd). */
static int is_listed(const char *line)
{
    const char *at = strstr(line, "__NAME_IN_SET(");
    return strncmp(line, "#define ", 8) == 0 && at && at < line + strcspn(line, "\n") && !strchr("( ", at[-1]) &&
           line[8 + strcspn(line + 8, "( \n")] == ' ';
}

/* A function that follows another one at once: one-liners often do. */
static int is_next_function(const char *begin, const char *end)
{
    const char *last = end;
    if (strncmp(end + 1, "static ", 7) != 0 || end == begin || end[-1] != '}') return 0;
    while (last > begin && last[-1] != '\n') last--;
    return *last == '}' || strncmp(last, "static ", 7) == 0;
}

/* The line end that ends the item. A blank line does, unless it stands in a function: then an indented one follows. */
static const char *find_end(const char *s)
{
    const char *end = strchr(s, '\n');
    if (is_listed(s)) return end;
    for (; end && end[1] && (end[1] != '\n' || end[2] == ' '); end = strchr(end + 1, '\n'))
        if (is_listed(end + 1) || is_next_function(s, end)) break;
    return end;
}

static void add_items(units *u, int unit)
{
    const char *s = u->texts[unit].data, *end;
    unsigned long line = 1;

    for (; *s == '\n'; s++) line++;
    while (*s) {
        item *it = &u->items[u->item_count++];
        if (u->item_count == MAX_ITEMS) fail(u->names[unit], "makes too many functions for MAX_ITEMS");
        end = find_end(s);
        if (!end) fail(u->names[unit], "a unit must end with a new line");
        memset(it, 0, sizeof *it);
        it->text = s;
        it->size = (size_t)(end + 1 - s);
        it->unit = unit;
        it->line = line;
        it->tight = s >= u->texts[unit].data + 2 && s[-2] != '\n';
        find_names(it);
        end += strspn(end, "\n");
        for (; s < end; s++) line += *s == '\n';
    }
}

static int add_text(units *u, const char *name)
{
    if (u->count == MAX_UNITS) fail(name, "is one unit too many");
    print_to(u->names[u->count], MAX_NAME, "%s", name);
    return u->count++;
}

void add_unit(units *u, const char *folder, const char *name, const char *prefix, const char *values)
{
    static int depth;
    char path[1024], word[MAX_NAME];
    const char *s;
    text t = { NULL, 0, 0 };
    int i;

    for (i = 0; i < u->count; i++)
        if (strcmp(u->names[i], name) == 0) return;
    if (++depth > MAX_UNITS) fail(name, "is a unit that needs itself");
    print_to(path, sizeof path, "%s/%s.h", folder, name);
    if (!read_file(path, &t)) fail(path, "is no unit: the file cannot be read");
    s = t.data;
    if (strncmp(s, "/* unit ", 8) != 0) fail(path, "does not begin with /* unit");
    s += 8;
    next_word(&s, word);
    if (next_word(&s, word) && strcmp(word, "needs") == 0)
        while (next_word(&s, word)) add_unit(u, folder, word, prefix, values);
    i = add_text(u, name);
    append_renamed(&u->texts[i], t.data, t.size, prefix);
    free_text(&t);
    if (values) fold(&u->texts[i], values);
    add_items(u, i);
    depth--;
}

int add_part_as_unit(units *u, const char *name, const text *body)
{
    const int i = add_text(u, name);
    u->is_part[i] = 1;
    append(&u->texts[i], body->data, body->size);
    add_items(u, i);
    return i;
}

/* ---- what is used ---- */

/* The length of a kernel's name without the set that it was compiled for: cohsm__find of cohsm__find_avx2. */
static size_t without_set(const char *s, size_t size)
{
    static const char *const sets[3] = { "_plain", "_avx2", "_avx512" };
    int i;
    for (i = 0; i < 3; i++) {
        const size_t n = strlen(sets[i]);
        if (size > n && memcmp(s + size - n, sets[i], n) == 0) return size - n;
    }
    return size;
}

static int defines(const item *it, const char *s, size_t size)
{
    int i;
    for (i = 0; i < it->defined; i++)
        if (it->defines[i].size == size && memcmp(it->defines[i].s, s, size) == 0) return 1;
    return 0;
}

/* What the words of a text need, but for those of its comments and of #undef. */
static void mark(units *u, const char *s, size_t size)
{
    const char *text_end = s + size, *end;
    size_t size_of_word, of_all_sets;
    int i;

    for (; s < text_end; s = end + (end == s)) {
        end = skip_comment(s, text_end);
        if (strncmp(s, "#undef", 6) == 0) end += strcspn(s, "\n");
        if (end > s) continue;
        for (; end < text_end && is_word(*end); end++) {}
        if (end - s < 4) continue;
        size_of_word = (size_t)(end - s);
        of_all_sets = without_set(s, size_of_word);
        for (i = 0; i < u->item_count; i++) {
            item *it = &u->items[i];
            if (it->used || (!defines(it, s, size_of_word) && !defines(it, s, of_all_sets))) continue;
            it->used = 1;
            u->used[it->unit] = 1;
            mark(u, it->text, it->size);
        }
    }
}

/* What defines no names is used if any name of its unit is, if the unit has no names at all, and always in a part; but
   comments that stand alone make neither a used one. */
void mark_used(units *u, const text *own)
{
    int named[MAX_UNITS] = { 0 }, i, more = 1;

    mark(u, own->data, own->size);
    for (i = 0; i < u->item_count; i++) named[u->items[i].unit] |= u->items[i].defined;
    while (more) {
        more = 0;
        for (i = 0; i < u->item_count; i++) {
            item *it = &u->items[i];
            if (it->used || it->defined) continue;
            if (!u->used[it->unit] && (it->comment || (named[it->unit] && !u->is_part[it->unit]))) continue;
            it->used = u->used[it->unit] = more = 1;
            mark(u, it->text, it->size);
        }
    }
}

int put_unit(text *out, const units *u, int unit, const char *folder, int lines)
{
    int i, begun = 0;
    for (i = 0; i < u->item_count; i++) {
        const item *it = &u->items[i];
        if (it->unit != unit || !it->used) continue;
        if (begun && !it->tight) put(out, "\n");
        begun = 1;
        if (lines) put_format(out, "#line %lu \"%s/%s.h\"\n", it->line, folder, u->names[unit]);
        append(out, it->text, it->size);
    }
    return u->used[unit];
}
