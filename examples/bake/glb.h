/* glb.h - a .glb file whose bytes stay as they are but for what is added: its JSON is read as a list of places in the
   text, edits of that text are collected, and new bytes go behind those of its buffer. */
#ifndef BAKE_GLB_H
#define BAKE_GLB_H

#include <stddef.h>
#include <stdint.h>

/* ---- text of JSON, read in place ---- */

typedef struct bk_value {            /* an object, an array, a string, or a number or word */
    uint32_t begin, end;             /* its bytes in the text, quotes and brackets included */
    uint32_t after;                  /* number of the first value behind it and all that it holds */
    uint32_t count;                  /* of an array: its items; of an object: its members, each a string and a value */
    char     kind;                   /* '{', '[', '"' or '0' */
} bk_value;

typedef struct bk_json {
    const char *text;
    bk_value   *values;              /* in the order of the text: value 0 is the whole */
    uint32_t    count, room;
    int         escaped;             /* a name that was looked at is written with a backslash */
} bk_json;

/* All return 0, or -1 with one line in error. Text and values live until bk_json_free. */
int      bk_json_parse(bk_json *json, const char *text, size_t length, char *error);
void     bk_json_free(bk_json *json);
/* Number of the value of an object's member, the last of that name; 0: none, or not an object. */
uint32_t bk_json_member(bk_json *json, uint32_t object, const char *name);
/* Numbers of the items of an array, for free(); *count is 0 where it is none. NULL: out of memory. */
uint32_t *bk_json_items(const bk_json *json, uint32_t array, uint32_t *count);
double   bk_json_number(const bk_json *json, uint32_t value, double otherwise);   /* value 0: otherwise */

/* ---- the file ---- */

typedef struct bk_text { char *bytes; size_t size, room; int failed; } bk_text;      /* grows */

void bk_text_add(bk_text *text, const char *format, ...);       /* out of memory is remembered in `failed` */
void bk_text_bytes(bk_text *text, const void *bytes, size_t size);

typedef enum bk_list {               /* arrays of a glTF file that items are added to */
    BK_ACCESSORS, BK_VIEWS, BK_IMAGES, BK_TEXTURES, BK_MATERIALS, BK_BUFFERS, BK_LISTS
} bk_list;

typedef struct bk_edit { size_t at, remove, order; char *text; } bk_edit;

typedef struct bk_glb {
    uint8_t *data;                   /* the file */
    size_t   size;
    bk_json  json;
    const uint8_t *bin, *rest;       /* the buffer within the file, and the chunks behind it */
    size_t   bin_size, rest_size;
    bk_text  added;                  /* behind bin */
    bk_text  lists[BK_LISTS];        /* items added */
    uint32_t list_value[BK_LISTS], list_count[BK_LISTS];
    bk_edit *edits;
    size_t   edit_count;
    int      failed;                 /* out of memory */
} bk_glb;

int  bk_glb_open(bk_glb *glb, const char *path, char *error);
void bk_glb_free(bk_glb *glb);
/* In place of `remove` bytes of the JSON from `at` on; edits at one place stand in their order. */
void bk_glb_edit(bk_glb *glb, size_t at, size_t remove, const char *text);
/* A member of an object, "name":value; in place of the one that is there. */
void bk_glb_set(bk_glb *glb, uint32_t object, const char *name, const char *value);
/* Adds an item to a list; returns its number. */
uint32_t bk_glb_add(bk_glb *glb, bk_list list, const char *format, ...);
/* Adds bytes to the buffer, as a view of their own, which begins at a multiple of 4; target: 34962 for vertices, or 0.
 */
uint32_t bk_glb_view(bk_glb *glb, const void *bytes, size_t size, int stride, int target);
/* The bytes of the changed file, for free(). */
int  bk_glb_bytes(bk_glb *glb, void **data, size_t *size, char *error);

#endif
