/* text - growing texts, files and words: what the sources of join share. */

#ifndef JOIN_TEXT_H
#define JOIN_TEXT_H

#include <stddef.h>

#define MAX_NAME 128

typedef struct text { char *data; size_t size, room; } text;

/* Prints "join: NAME: WHAT" and ends the program with status 2. */
void fail(const char *name, const char *what);

/* Each of these leaves a zero behind the text, which is not counted. */
void append(text *t, const char *s, size_t size);
void put(text *t, const char *s);
/* snprintf that ends the program where the room does not suffice. */
void print_to(char *out, size_t room, const char *format, ...);
void put_format(text *t, const char *format, ...);      /* lines of up to 1,023 characters */
void put_number(text *t, unsigned long n);
void free_text(text *t);

/* 0 if the file cannot be read. */
int read_file(const char *path, text *t);
void write_file(const char *path, const text *t);

int is_word(int c);

/* Copies the next word of a list with blanks or commas between its words; 0 at the end of the line. */
int next_word(const char **s, char *word);

/* The first whole word NAME in the text, or NULL. */
const char *find_word(const char *s, const char *name);

#endif
