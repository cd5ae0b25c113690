#include "fold.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#define MAX_DEPTH 32

/* ---- the value of a condition ---- */

/* A number, or one that depends on what is not known here. */
typedef struct value { int known; long number; } value;

typedef struct condition { const char *s, *values; } condition;

static const value unknown = { 0, 0 };

static value known(long number)
{
    value v;
    v.known = 1;
    v.number = number;
    return v;
}

static value evaluate(condition *c);

static int take(condition *c, const char *sign)
{
    while (*c->s == ' ') c->s++;
    if (strncmp(c->s, sign, strlen(sign)) != 0) return 0;
    c->s += strlen(sign);
    return 1;
}

static int take_name(condition *c, char *name)
{
    size_t n = 0;
    while (*c->s == ' ') c->s++;
    if (isdigit((unsigned char)*c->s)) return 0;
    while (is_word(*c->s) && n + 1 < MAX_NAME) name[n++] = *c->s++;
    name[n] = 0;
    return n > 0;
}

/* Where the list says something of this name: behind it; else NULL. */
static const char *look_up(const condition *c, const char *name)
{
    const char *at = find_word(c->values, name);
    return at ? at + strlen(name) : NULL;
}

static value evaluate_defined(condition *c)
{
    char name[MAX_NAME];
    const char *at;
    int bracket = take(c, "(");
    if (!take_name(c, name)) return unknown;
    if (bracket) take(c, ")");
    at = look_up(c, name);
    return at ? known(*at == '=') : unknown;
}

static void skip_arguments(condition *c)
{
    int depth = 0;
    do {
        depth += *c->s == '(';
        depth -= *c->s == ')';
    } while (*c->s++ && depth > 0);
}

static value evaluate_primary(condition *c)
{
    char name[MAX_NAME], *end;
    const char *at;
    value v;

    if (take(c, "!")) {
        v = evaluate_primary(c);
        return v.known ? known(!v.number) : unknown;
    }
    if (take(c, "(")) {
        v = evaluate(c);
        take(c, ")");
        return v;
    }
    if (take_name(c, name)) {
        if (strcmp(name, "defined") == 0) return evaluate_defined(c);
        if (*c->s == '(') skip_arguments(c);
        at = look_up(c, name);
        return at ? known(*at == '=' ? strtol(at + 1, NULL, 10) : 0) : unknown;
    }
    v = known(strtol(c->s, &end, 0));
    if (end == c->s) return unknown;
    c->s = end;
    while (isalpha((unsigned char)*c->s)) c->s++;
    return v;
}

static value evaluate_comparison(condition *c)
{
    static const char *const signs[6] = { "==", "!=", "<=", ">=", "<", ">" };
    value a = evaluate_primary(c), b;
    int i, holds[6];

    for (i = 0; i < 6 && !take(c, signs[i]); i++) {}
    if (i == 6) return a;
    b = evaluate_primary(c);
    if (!a.known || !b.known) return unknown;
    holds[0] = a.number == b.number;
    holds[1] = a.number != b.number;
    holds[2] = a.number <= b.number;
    holds[3] = a.number >= b.number;
    holds[4] = a.number < b.number;
    holds[5] = a.number > b.number;
    return known(holds[i]);
}

static value evaluate_and(condition *c)
{
    value a = evaluate_comparison(c), b;
    while (take(c, "&&")) {
        b = evaluate_comparison(c);
        if ((a.known && !a.number) || (b.known && !b.number)) a = known(0);
        else a = a.known && b.known ? known(1) : unknown;
    }
    return a;
}

static value evaluate(condition *c)
{
    value a = evaluate_and(c), b;
    while (take(c, "||")) {
        b = evaluate_and(c);
        if ((a.known && a.number) || (b.known && b.number)) a = known(1);
        else a = a.known && b.known ? known(0) : unknown;
    }
    return a;
}

/* Of #if, #ifdef, #ifndef and #elif. What is not understood to the end of its line is not known. */
static value evaluate_directive(const char *line, const char *values)
{
    char copy[1024];
    condition c;
    value v;
    size_t n = strcspn(line, "\n");

    if (n >= sizeof copy) return unknown;
    memcpy(copy, line, n);
    copy[n] = 0;
    c.s = copy + strcspn(copy, " ");
    c.values = values;
    if (strncmp(copy, "#if ", 4) != 0 && strncmp(copy, "#elif ", 6) != 0) {
        v = evaluate_defined(&c);
        if (copy[3] == 'n' && v.known) v.number = !v.number;
    } else v = evaluate(&c);
    while (*c.s == ' ') c.s++;
    return *c.s && strncmp(c.s, "/*", 2) != 0 ? unknown : v;
}

/* ---- the lines ---- */

/* An #if whose #endif has not come yet. */
typedef struct open_if {
    int live;       /* this branch is kept, if what stands around it is */
    int decided;    /* a branch that is taken has come: the others are not */
    int written;    /* an #if of it stands in the output */
} open_if;

typedef struct folding {
    text out;
    const char *values;
    open_if ifs[MAX_DEPTH];
    int depth;
    int left_out;   /* lines were left out since the last one that was kept */
} folding;

static int is_live(const folding *f)
{
    int i;
    for (i = 0; i < f->depth; i++)
        if (!f->ifs[i].live) return 0;
    return 1;
}

/* No blank line comes behind another one only because lines between them are gone. */
static void keep_line(folding *f, const char *line, size_t size)
{
    const text *o = &f->out;
    const int behind_blank = o->size > 1 && o->data[o->size - 1] == '\n' && o->data[o->size - 2] == '\n';
    if (size != 1 || !f->left_out || !behind_blank) append(&f->out, line, size);
    f->left_out = 0;
}

/* A branch begins: #if and its kind, or #elif, or #else with the value 1. */
static void begin_branch(folding *f, value v, const char *line, size_t size)
{
    open_if *o = &f->ifs[f->depth - 1];
    const int around = (f->depth--, is_live(f));
    const char *rest = line + strcspn(line, " \n");

    f->depth++;
    o->live = !o->decided && !(v.known && !v.number);
    f->left_out = 1;
    if (!o->live) return;
    if (v.known) o->decided = 1;
    if (v.known && !o->written) return;
    f->left_out = 0;
    if (around && v.known) put(&f->out, "#else\n");
    else if (around && strncmp(line, "#elif", 5) == 0 && !o->written) {
        put(&f->out, "#if");
        append(&f->out, rest, size - (size_t)(rest - line));
    } else if (around) append(&f->out, line, size);
    o->written = 1;
}

static void end_if(folding *f, const char *line, size_t size)
{
    const int written = f->ifs[--f->depth].written;
    if (written && is_live(f)) keep_line(f, line, size);
    else f->left_out = 1;
}

static void fold_line(folding *f, const char *line, size_t size)
{
    if (strncmp(line, "#if", 3) == 0) {
        if (f->depth == MAX_DEPTH) fail("an #if", "stands in too many others");
        memset(&f->ifs[f->depth++], 0, sizeof *f->ifs);
        begin_branch(f, evaluate_directive(line, f->values), line, size);
    } else if (strncmp(line, "#elif", 5) == 0 && f->depth) {
        begin_branch(f, evaluate_directive(line, f->values), line, size);
    } else if (strncmp(line, "#else", 5) == 0 && f->depth) {
        begin_branch(f, known(1), line, size);
    } else if (strncmp(line, "#endif", 6) == 0 && f->depth) {
        end_if(f, line, size);
    } else if (is_live(f)) keep_line(f, line, size);
}

void fold(text *t, const char *values)
{
    folding *f = (folding *)calloc(1, sizeof *f);
    const char *line, *end;

    if (!f) fail("memory", "there is not enough");
    f->values = values;
    append(&f->out, "", 0);
    for (line = t->data; *line; line = end) {
        end = line + strcspn(line, "\n");
        end += *end == '\n';
        fold_line(f, line, (size_t)(end - line));
    }
    free_text(t);
    *t = f->out;
    free(f);
}
