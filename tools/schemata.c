/* schemata - puts many mutants into one copy of a header, each behind a switch, so that tools/mutate compiles once for
   all of them and not once for each.
   schemata HEADER CHOSEN PLACED > COPY

   CHOSEN has a line for each mutant: number, line, column (both from 1), length and replacement, by tabs. The copy
   says "MUTATE_(7) ? a <= b : a < b" where HEADER says "a < b" and mutant 7 turns < into <=. An operator's operands are
   found by precedence alone: the copy needs to be right where the mutant sleeps, which the header's own tests show, and
   where it does not compile the mutant is dropped by tools/mutate. PLACED gets number, first and last line of each
   mutant that got its place. Line numbers of the copy are the header's. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct token {
    size_t at, length;
    int    match;       /* of a bracket: the other one, or -1 */
    char   kind;        /* a word, 0 number, " string or character, # directive, o operator or bracket */
} token;

typedef struct edit {
    size_t at, other;   /* where the text goes; where its mutant's other end is */
    int    number, closes;
    char  *text;
} edit;

enum { ASSIGNMENT = -1, UNARY = 99, NOT_BINARY = -9 };

static char  *source;
static token *tokens;
static int    token_count;
static edit  *edits;
static size_t edit_count;

static void fail(const char *what)
{
    fprintf(stderr, "schemata: %s\n", what);
    exit(1);
}

static void *more(void *memory, size_t bytes)
{
    void *p = realloc(memory, bytes);
    if (!p) fail("no memory");
    return p;
}

static char *read_all(const char *path)
{
    FILE *f = fopen(path, "rb");
    char *text = NULL;
    size_t size = 0, got;
    if (!f) fail(path);
    do {
        text = more(text, size + 65537);
        got = fread(text + size, 1, 65536, f);
        size += got;
    } while (got > 0);
    text[size] = '\0';
    fclose(f);
    return text;
}

/* ---- tokens ---- */

static int word_char(int c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

static size_t operator_length(const char *s)
{
    static const char *const longer[] = { "<<=", ">>=", "...", "->", "++", "--", "<<", ">>", "<=", ">=", "==", "!=",
                                          "&&", "||", "+=", "-=", "*=", "/=", "%=", "&=", "^=", "|=", "##" };
    size_t i;
    for (i = 0; i < sizeof longer / sizeof longer[0]; i++)
        if (strncmp(s, longer[i], strlen(longer[i])) == 0) return strlen(longer[i]);
    return 1;
}

/* The end of what begins at s: a directive with its continued lines, a comment, a string, a number, a word. */
static size_t directive_length(const char *s)
{
    size_t n = 0;
    while (s[n] && (s[n] != '\n' || s[n - 1] == '\\')) n++;
    return n;
}

static size_t comment_length(const char *s)
{
    const char *end = strstr(s + 2, "*/");
    return end ? (size_t)(end - s) + 2 : strlen(s);
}

static size_t string_length(const char *s)
{
    size_t n = 1;
    while (s[n] && s[n] != s[0]) n += s[n] == '\\' && s[n + 1] ? 2 : 1;
    return s[n] ? n + 1 : n;
}

static size_t word_length(const char *s, int number)
{
    size_t n = 1;
    while (word_char(s[n]) || (number && (s[n] == '.' || ((s[n] == '-' || s[n] == '+') && strchr("eEpP", s[n - 1]) &&
                                                         !(s[0] == '0' && s[1] == 'x' && strchr("eE", s[n - 1]))))))
        n++;
    return n;
}

static void add_token(size_t at, size_t length, char kind)
{
    if ((token_count & (token_count - 1)) == 0)
        tokens = more(tokens, (size_t)(token_count ? 2 * token_count : 1) * sizeof *tokens);
    tokens[token_count].at = at;
    tokens[token_count].length = length;
    tokens[token_count].kind = kind;
    tokens[token_count].match = -1;
    token_count++;
}

static void read_tokens(void)
{
    size_t at = 0, length;
    int line_begins = 1;
    while (source[at]) {
        const char *s = source + at;
        char kind = 0;
        if (*s == '\n') {
            line_begins = 1;
            at++;
            continue;
        }
        if (*s == ' ' || *s == '\t') length = 1;
        else if (*s == '#' && line_begins) length = directive_length(s), kind = '#';
        else if (s[0] == '/' && s[1] == '*') length = comment_length(s);
        else if (*s == '"' || *s == '\'') length = string_length(s), kind = '"';
        else if ((*s >= '0' && *s <= '9') || (*s == '.' && s[1] >= '0' && s[1] <= '9'))
            length = word_length(s, 1), kind = '0';
        else if (word_char(*s)) length = word_length(s, 0), kind = 'a';
        else length = operator_length(s), kind = 'o';
        if (kind) add_token(at, length, kind), line_begins = 0;
        at += length;
    }
}

static int is(int i, const char *text)
{
    return i >= 0 && i < token_count && tokens[i].length == strlen(text) &&
           strncmp(source + tokens[i].at, text, tokens[i].length) == 0;
}

static int is_one_of(int i, const char *const *list)
{
    for (; *list; list++)
        if (is(i, *list)) return 1;
    return 0;
}

static void match_brackets(void)
{
    int *open = more(NULL, (size_t)(token_count + 1) * sizeof *open), depth = 0, i;
    for (i = 0; i < token_count; i++) {
        if (is(i, "(") || is(i, "[") || is(i, "{")) open[depth++] = i;
        if ((is(i, ")") || is(i, "]") || is(i, "}")) && depth > 0) {
            depth--;
            tokens[i].match = open[depth];
            tokens[open[depth]].match = i;
        }
    }
    free(open);
}

/* ---- operands ---- */

static int precedence(int i)
{
    static const char *const by_precedence[][6] = { { "||" }, { "&&" }, { "|" }, { "^" }, { "&" }, { "==", "!=" },
        { "<", ">", "<=", ">=" }, { "<<", ">>" }, { "+", "-" }, { "*", "/", "%" } };
    int p;
    for (p = 0; p < 10; p++)
        if (is_one_of(i, by_precedence[p])) return p + 1;
    return NOT_BINARY;
}

static int is_assignment(int i)
{
    static const char *const list[] = { "=", "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^=", "<<=", ">>=", NULL };
    return is_one_of(i, list);
}

/* After these an operand begins. */
static int is_keyword(int i)
{
    static const char *const list[] = { "return", "case", "else", "do", "goto", "sizeof", NULL };
    return is_one_of(i, list);
}

static int is_control(int i)
{
    static const char *const list[] = { "if", "while", "for", "switch", NULL };
    return is_one_of(i, list);
}

static int names_type(int i)
{
    static const char *const list[] = { "float", "double", "int",  "char",   "unsigned", "signed", "long", "short",
                                        "const", "void",   "struct", "enum", NULL };
    size_t n = tokens[i].length;
    return is_one_of(i, list) || (n > 2 && strncmp(source + tokens[i].at + n - 2, "_t", 2) == 0);
}

/* Whether the parenthesis that closes at i is a cast's. */
static int is_cast(int i)
{
    int open = tokens[i].match, k, typed = 0;
    if (!is(i, ")") || open < 0 || i == open + 1) return 0;
    if (open > 0 && tokens[open - 1].kind == 'a' && !is_keyword(open - 1)) return 0;
    for (k = open + 1; k < i; k++) {
        if (tokens[k].kind != 'a' && !is(k, "*")) return 0;
        typed = typed || (tokens[k].kind == 'a' && names_type(k)) || (is(k, "*") && k == i - 1);
    }
    return typed;
}

static int ends_operand(int i)
{
    if (i < 0 || tokens[i].kind == '#') return 0;
    if (tokens[i].kind == 'a') return !is_keyword(i);
    if (tokens[i].kind != 'o') return 1;
    if (is(i, "++") || is(i, "--")) return ends_operand(i - 1);
    return is(i, "]") || (is(i, ")") && !is_cast(i));
}

static int is_unary(int i)
{
    static const char *const list[] = { "-", "+", "*", "&", NULL };
    return is(i, "!") || is(i, "~") || is(i, "++") || is(i, "--") || (is_one_of(i, list) && !ends_operand(i - 1));
}

static int begins_operand(int i)
{
    return tokens[i].kind == 'a' || tokens[i].kind == '0' || tokens[i].kind == '"' || is(i, "(") ||
           (is_unary(i) && !ends_operand(i - 1));
}

/* The first token of the left operand of the operator at i, which binds like p; i if there is none. */
static int left_of(int i, int p)
{
    int first = i, k = i - 1;
    while (k >= 0 && tokens[k].kind != '#') {
        if (is(k, ")") || is(k, "]") || is(k, "}")) {
            int open = tokens[k].match;
            if (open < 0 || (is(k, "}") && k != i - 1)) break;
            if (is(k, ")") && first != i && begins_operand(first) && (is_control(open - 1) || !is_cast(k))) break;
            first = open;
        } else if (tokens[k].kind == 'a') {
            if (is_keyword(k) && !is(k, "sizeof")) break;
            first = k;
        } else if (tokens[k].kind != 'o' || is(k, ".") || is(k, "->") || is_unary(k) || is(k, "++") || is(k, "--")) {
            first = k;
        } else if (precedence(k) >= p && precedence(k) > 0) {
            first = k;
        } else {
            break;
        }
        k = first - 1;
    }
    return first;
}

/* The last token of the right operand; i if there is none. */
static int right_of(int i, int p)
{
    int last = i, k = i + 1;
    while (k < token_count && tokens[k].kind != '#') {
        if (is(k, "(") || is(k, "[") || (is(k, "{") && is(k - 1, ")"))) {
            if (tokens[k].match < 0) break;
            last = tokens[k].match;
        } else if (tokens[k].kind != 'o' || is(k, ".") || is(k, "->") || is_unary(k) || is(k, "++") || is(k, "--")) {
            last = k;
        } else if (precedence(k) > 0 ? precedence(k) > p
                                     : p == ASSIGNMENT && (is(k, "?") || is(k, ":") || is_assignment(k))) {
            last = k;
        } else {
            break;
        }
        k = last + 1;
    }
    return last;
}

/* ---- edits ---- */

static size_t end_of(int i)
{
    return tokens[i].at + tokens[i].length;
}

static void add_edit(size_t at, size_t other, int number, int closes, const char *text)
{
    if ((edit_count & (edit_count - 1)) == 0) edits = more(edits, (edit_count ? 2 * edit_count : 1) * sizeof *edits);
    edits[edit_count].at = at;
    edits[edit_count].other = other;
    edits[edit_count].number = number;
    edits[edit_count].closes = closes;
    edits[edit_count].text = strcpy(more(NULL, strlen(text) + 1), text);
    edit_count++;
}

/* Texts at one place: what ends there before what begins, and of those the inner before the outer, the outer before the
   inner. */
static int compare_edits(const void *pa, const void *pb)
{
    const edit *a = pa, *b = pb;
    if (a->at != b->at) return a->at < b->at ? -1 : 1;
    if (a->closes != b->closes) return a->closes ? -1 : 1;
    if (a->other != b->other) return a->other > b->other ? -1 : 1;
    return (a->number < b->number) == !a->closes ? -1 : 1;
}

/* source[from..to) with source[at..at + length) replaced, on one line. */
static char *mutated(size_t from, size_t to, size_t at, size_t length, const char *replacement)
{
    size_t size = to - from + strlen(replacement) + 1;
    char *text = more(NULL, size), *c;
    snprintf(text, size, "%.*s%s%.*s", (int)(at - from), source + from, replacement, (int)(to - at - length),
             source + at + length);
    for (c = text; *c; c++)
        if (*c == '\n') *c = ' ';
    return text;
}

/* "MUTATE_(n) ? mutant : " before the tokens first to last. */
static void choose(int number, int first, int last, size_t at, size_t length, const char *replacement, int lower)
{
    char *mutant = mutated(tokens[first].at, end_of(last), at, length, replacement);
    char *text = more(NULL, strlen(mutant) + 64);
    sprintf(text, lower ? "(MUTATE_(%d) ? (%s) : (" : "(MUTATE_(%d) ? %s : ", number, mutant);
    add_edit(tokens[first].at, end_of(last), number, 0, text);
    add_edit(end_of(last), tokens[first].at, number, 1, lower ? "))" : ")");
    free(mutant);
    free(text);
}

/* A statement that is left out: up to its semicolon. */
static int choose_statement(int number, int first, int *last)
{
    static const char *const before[] = { ";", "{", "}", ")", "else", NULL };
    char text[64];
    int k;
    if (!is_one_of(first - 1, before)) return 0;
    for (k = first; k < token_count && !is(k, ";"); k++) {
        if (tokens[k].kind == '#' || is(k, "}") || is(k, ")") || is(k, "]")) return 0;
        if (tokens[k].match > k) k = tokens[k].match;
    }
    sprintf(text, "{ if (!MUTATE_(%d)) ", number);
    add_edit(tokens[first].at, end_of(k), number, 0, text);
    add_edit(end_of(k), tokens[first].at, number, 1, " }");
    *last = k;
    return 1;
}

static int place(int number, int i, size_t at, size_t length, const char *replacement, int *first, int *last)
{
    int p = precedence(i), assignment = is_assignment(i);
    *first = *last = i;
    if (strcmp(replacement, ";") == 0) return choose_statement(number, i, last);
    if (is(i, "!")) {
        *last = right_of(i, UNARY);
        if (*last == i) return 0;
        choose(number, i, *last, at, length, "0 != ", 0);
        return 1;
    }
    if (tokens[i].kind == '0') {
        choose(number, i, i, at, length, replacement, 0);
        return 1;
    }
    if (p < 0 && !assignment) return 0;
    *first = left_of(i, assignment ? UNARY : p);
    *last = right_of(i, assignment ? ASSIGNMENT : p);
    if (*first == i || *last == i) return 0;
    choose(number, *first, *last, at, length, replacement, assignment);
    return 1;
}

static int token_at(size_t at)
{
    int low = 0, high = token_count;
    while (low < high) {
        int middle = (low + high) / 2;
        if (tokens[middle].at < at) low = middle + 1;
        else high = middle;
    }
    return low < token_count && tokens[low].at == at ? low : -1;
}

static void print_copy(void)
{
    size_t at = 0, i;
    /* before the first line that is kept: the line numbers stay */
    printf("extern unsigned char mutate_hit[]; extern int mutate_active; ");
    for (i = 0; i < edit_count; i++) {
        fwrite(source + at, 1, edits[i].at - at, stdout);
        fputs(edits[i].text, stdout);
        at = edits[i].at;
    }
    fputs(source + at, stdout);
}

static size_t *line_starts(void)
{
    size_t *starts = more(NULL, (strlen(source) + 3) * sizeof *starts), at, count = 2;
    starts[0] = starts[1] = 0;
    for (at = 0; source[at]; at++)
        if (source[at] == '\n') starts[count++] = at + 1;
    starts[count] = at + 1;
    return starts;
}

static int line_of(size_t at)
{
    int line = 1;
    size_t i;
    for (i = 0; i < at; i++) line += source[i] == '\n';
    return line;
}

int main(int argc, char **argv)
{
    char row[256], replacement[64];
    unsigned line, column, length;
    size_t *starts;
    FILE *chosen, *placed;
    int number;
    if (argc != 4) fail("schemata HEADER CHOSEN PLACED > COPY");
    source = read_all(argv[1]);
    read_tokens();
    match_brackets();
    starts = line_starts();
    chosen = fopen(argv[2], "r");
    placed = fopen(argv[3], "w");
    if (!chosen || !placed) fail("cannot open CHOSEN or PLACED");
    while (fgets(row, sizeof row, chosen)) {
        int got = sscanf(row, "%d\t%u\t%u\t%u\t%63[^\n]", &number, &line, &column, &length, replacement);
        int i, first, last;
        if (got < 4) continue;
        if (got == 4) replacement[0] = '\0';
        i = token_at(starts[line] + column - 1);
        if (i >= 0 && place(number, i, tokens[i].at, length, replacement, &first, &last))
            fprintf(placed, "%d %d %d\n", number, line_of(tokens[first].at), line_of(end_of(last)));
    }
    fclose(chosen);
    if (fclose(placed) != 0) fail(argv[3]);
    if (edit_count) qsort(edits, edit_count, sizeof *edits, compare_edits);
    print_copy();
    return fflush(stdout) != 0;
}
