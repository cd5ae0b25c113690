#include "text.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void fail(const char *name, const char *what)
{
    fprintf(stderr, "join: %s: %s\n", name, what);
    exit(2);
}

void append(text *t, const char *s, size_t size)
{
    if (t->size + size + 1 > t->room) {
        t->room = 2 * (t->size + size + 1);
        t->data = (char *)realloc(t->data, t->room);
        if (!t->data) fail("memory", "there is not enough");
    }
    memcpy(t->data + t->size, s, size);
    t->size += size;
    t->data[t->size] = 0;
}

void put(text *t, const char *s) { append(t, s, strlen(s)); }

void print_to(char *out, size_t room, const char *format, ...)
{
    va_list arguments;
    int n;
    va_start(arguments, format);
    n = vsnprintf(out, room, format, arguments);
    va_end(arguments);
    if (n < 0 || (size_t)n >= room) fail(out, "is too long a name");
}

void put_format(text *t, const char *format, ...)
{
    char line[1024];
    va_list arguments;
    int n;
    va_start(arguments, format);
    n = vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    if (n < 0 || (size_t)n >= sizeof line) fail(line, "is too long a line");
    append(t, line, (size_t)n);
}

void put_number(text *t, unsigned long n)
{
    char digits[24];
    sprintf(digits, "%lu", n);
    put(t, digits);
}

void free_text(text *t)
{
    free(t->data);
    memset(t, 0, sizeof *t);
}

int read_file(const char *path, text *t)
{
    char buffer[4096];
    size_t n;
    FILE *f = fopen(path, "rb");

    if (!f) return 0;
    append(t, "", 0);
    while ((n = fread(buffer, 1, sizeof buffer, f)) > 0) append(t, buffer, n);
    if (fclose(f) != 0) fail(path, "cannot be read to its end");
    return 1;
}

void write_file(const char *path, const text *t)
{
    FILE *f = fopen(path, "wb");
    if (!f || fwrite(t->data, 1, t->size, f) != t->size || fclose(f) != 0) fail(path, "cannot be written");
}

int is_word(int c) { return isalnum((unsigned char)c) || c == '_'; }

int next_word(const char **s, char *word)
{
    size_t n = 0;
    while (**s == ' ' || **s == ',') (*s)++;
    while (**s && !strchr(" ,:\n", **s) && n + 1 < MAX_NAME) word[n++] = *(*s)++;
    word[n] = 0;
    return n > 0;
}

const char *find_word(const char *s, const char *name)
{
    const char *at;
    size_t length = strlen(name);
    for (at = strstr(s, name); at; at = strstr(at + 1, name))
        if ((at == s || !is_word(at[-1])) && !is_word(at[length])) return at;
    return NULL;
}
