/* embed - writes src/shaders into gl_backend.h, as arrays of lines with one table.

   What lies between these two lines of the header (without the blanks inside the comment marks) is replaced:

       / * >>> glsl: written by tools/embed from src/shaders and GLBK_PARTS, edit there * /
       / * <<< glsl * /

   Library files come first, in the order of their names, and among them those made here from the header's lists of
   bindings: PART_bindings.glsl with textures, buffers and images, and a file for each uniform block, glbk_csm_scene in
   csm_scene.glsl. Then the programs. What a file needs is read from its own comments:

       // uses: table noise           library files that go before it; blocks that it names are found
       // with: screen.vert           the vertex shader of a .frag
       // sets: A=0 | A=1 B=2         the define sets that are tested

   embed SHADER_DIR HEADER            rewrites the header where it differs
   embed --check SHADER_DIR HEADER    compares only; exit 1 and the two commands that repair it on a difference */

#define _POSIX_C_SOURCE 200809L
#include "../gl_backend.h"

#include <ctype.h>
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BEGIN "/* >>> glsl: written by tools/embed from src/shaders and GLBK_PARTS, edit there */\n"
#define END "/* <<< glsl */\n"
#define MAX_FILES 256

typedef struct text { char *data; size_t size, room; } text;
typedef struct file { char name[128]; text body; const char *block; } file;   /* block: what it declares, or NULL */

static file files[MAX_FILES];
static int  file_count;

static void fail(const char *what, const char *name)
{
    fprintf(stderr, "embed: %s: %s\n", name, what);
    exit(2);
}

static void append(text *t, const char *s, size_t size)
{
    if (t->size + size + 1 > t->room) {
        t->room = 2 * (t->size + size + 1);
        t->data = (char *)realloc(t->data, t->room);
        if (!t->data) exit(2);
    }
    memcpy(t->data + t->size, s, size);
    t->size += size;
    t->data[t->size] = 0;
}

static void put(text *t, const char *s) { append(t, s, strlen(s)); }

static void put_number(text *t, unsigned long n)
{
    char digits[24];
    sprintf(digits, "%lu", n);
    put(t, digits);
}

static void read_file(const char *path, text *t)
{
    char buffer[4096];
    size_t n;
    FILE *f = fopen(path, "rb");

    if (!f) fail("cannot be read", path);
    append(t, "", 0);
    while ((n = fread(buffer, 1, sizeof buffer, f)) > 0) append(t, buffer, n);
    fclose(f);
}

static file *add_file(const char *folder, const char *name, const char *suffix)
{
    file *f = &files[file_count];
    if (file_count == MAX_FILES || strlen(folder) + strlen(name) + strlen(suffix) + 2 > sizeof f->name)
        fail("too many files or too long a name", name);
    file_count++;
    sprintf(f->name, "%s/%s%s", folder, name, suffix);
    return f;
}

/* ---- the lists of bindings as GLSL ---- */

#define TEXTURE(type, name, slot) put(t, "uniform " #type " " #name ";\n");
#define MEMBER(type, name, count) put_member(t, #type, #name, count);
#define STORAGE(qualifiers, type, name, slot)                                           \
    put(t, "#if __VERSION__ >= 430\nlayout(std430, binding = ");                        \
    put_number(t, slot);                                                                \
    put(t, ") " #qualifiers " buffer " #name "_storage { " #type " " #name "[]; };\n#endif\n");
#define IMAGE(qualifiers, format, type, name, slot)                                     \
    put(t, "#if __VERSION__ >= 430\nlayout(" #format ", binding = ");                   \
    put_number(t, slot);                                                                \
    put(t, ") " #qualifiers " uniform " #type " " #name ";\n#endif\n");
#define PART(part, PART)                                            \
    bindings_##part(&add_file("lib", #part, "_bindings.glsl")->body);   \
    GLBK_##PART##_BLOCKS(BLOCK)
#define BLOCK(name, slot, members) block_##name(&add_block(#name)->body);
#define BINDINGS(part, PART)                                        \
    static void bindings_##part(text *t)                            \
    {                                                               \
        put(t, "// " #part "_bindings - from the lists GLBK_" #PART "_* of gl_backend.h.\n");   \
        GLBK_##PART##_TEXTURES(TEXTURE)                             \
        GLBK_##PART##_STORAGE(STORAGE)                              \
        GLBK_##PART##_IMAGES(IMAGE)                                 \
    }                                                               \
    GLBK_##PART##_BLOCKS(WRITE_BLOCK)
#define WRITE_BLOCK(name, slot, members)                            \
    static void block_##name(text *t)                               \
    {                                                               \
        put(t, "// " #name ", uniform block\n");                    \
        put(t, "layout(std140) uniform " #name "_block {\n");       \
        members(MEMBER)                                             \
        put(t, "} " #name ";\n");                                   \
    }

static inline void put_member(text *t, const char *type, const char *name, int count)
{
    put(t, "    ");
    put(t, type);
    put(t, " ");
    put(t, name);
    if (count > 1) {
        put(t, "[");
        put_number(t, (unsigned long)count);
        put(t, "]");
    }
    put(t, ";\n");
}

GLBK_PARTS(BINDINGS)

/* All members of a std140 block are active, whether a program reads them or not, and WebGL 2 refuses to draw with an
   active block that has no buffer (ES 3.0 leaves it undefined): hence a file each, for those who name it. */
static inline file *add_block(const char *name)
{
    file *f = add_file("lib", name + strlen("glbk_"), ".glsl");
    f->block = name;
    return f;
}

/* ---- the files ---- */

static int compare_names(const void *a, const void *b)
{
    return strcmp(((const file *)a)->name, ((const file *)b)->name);
}

static void add_folder(const char *root, const char *folder)
{
    char path[1024];
    DIR *dir;
    struct dirent *entry;

    if (strlen(root) + 300 > sizeof path) fail("too long a path", root);
    sprintf(path, "%s/%s", root, folder);
    dir = opendir(path);
    if (!dir) fail("no such folder", path);
    while ((entry = readdir(dir)) != NULL) {
        file *f;
        if (entry->d_name[0] == '.') continue;
        f = add_file(folder, entry->d_name, "");
        sprintf(path, "%s/%s", root, f->name);
        read_file(path, &f->body);
        if (!f->body.size || f->body.data[f->body.size - 1] != '\n') fail("does not end with a new line", f->name);
    }
    closedir(dir);
}

/* Is the name a word of the text? */
static int names(const file *f, const char *name)
{
    size_t length = strlen(name);
    const char *s;
    for (s = strstr(f->body.data, name); s; s = strstr(s + 1, name))
        if (!isalnum((unsigned char)s[length]) && s[length] != '_') return 1;
    return 0;
}

/* The value of a comment "// key: value", as a C string; of uses with the blocks that the file names. */
static void put_value(text *out, const file *f, const char *key)
{
    const char *s = f->body.data;
    size_t length = strlen(key), before;
    int i;

    put(out, "\"");
    before = out->size;
    while (s && *s) {
        if (strncmp(s, "// ", 3) == 0 && strncmp(s + 3, key, length) == 0 && s[3 + length] == ':') {
            s += 4 + length;
            while (*s == ' ') s++;
            append(out, s, strcspn(s, "\n"));
            break;
        }
        s = strchr(s, '\n');
        if (s) s++;
    }
    for (i = 0; i < file_count && strcmp(key, "uses") == 0; i++) {
        const char *name = files[i].name + strlen("lib/");
        if (!files[i].block || &files[i] == f || !names(f, files[i].block)) continue;
        if (out->size > before) put(out, " ");
        append(out, name, strcspn(name, "."));
    }
    put(out, "\"");
}

static void put_identifier(text *out, const char *name)
{
    put(out, "glbk__glsl_");
    for (; *name; name++) {
        char c = isalnum((unsigned char)*name) ? *name : '_';
        append(out, &c, 1);
    }
}

/* One C string a line. Returns the number of lines. */
static unsigned long put_lines(text *out, const file *f)
{
    const char *s = f->body.data;
    unsigned long count = 0;

    put(out, "\nstatic const char *const ");
    put_identifier(out, f->name);
    put(out, "[] = {\n    \"");
    for (; *s; s++) {
        if (*s == '\n') {
            count++;
            put(out, s[1] ? "\\n\",\n    \"" : "\\n\"\n};\n");
        } else {
            if (*s == '"' || *s == '\\') put(out, "\\");
            if ((unsigned char)*s < 32 || (unsigned char)*s > 126) fail("a tab, or a character beyond ASCII", f->name);
            append(out, s, 1);
        }
    }
    return count;
}

static void put_all(text *out)
{
    text table = { NULL, 0, 0 };
    int i;

    put(&table, "\nstatic const glbk_file glbk__files[] = {\n");
    for (i = 0; i < file_count; i++) {
        unsigned long lines = put_lines(out, &files[i]);
        if (lines > 999)
            fail("has more than 999 lines, which the messages of drivers could not tell apart", files[i].name);
        put(&table, "    { \"");
        put(&table, files[i].name);
        put(&table, "\", ");
        put_identifier(&table, files[i].name);
        put(&table, ", ");
        put_number(&table, lines);
        put(&table, ", ");
        put_value(&table, &files[i], "uses");
        put(&table, ", ");
        put_value(&table, &files[i], "with");
        put(&table, ",\n      ");
        put_value(&table, &files[i], "sets");
        put(&table, i + 1 < file_count ? " },\n" : " }\n};\n\n");
    }
    append(out, table.data, table.size);
    free(table.data);
}

int main(int argc, char **argv)
{
    int check = argc > 1 && strcmp(argv[1], "--check") == 0, lib_count;
    const char *header, *begin, *end;
    text in = { NULL, 0, 0 }, out = { NULL, 0, 0 };

    if (argc != 3 + check) {
        fprintf(stderr, "usage: embed [--check] SHADER_DIR HEADER\n");
        return 2;
    }
    header = argv[2 + check];
    add_folder(argv[1 + check], "lib");
    GLBK_PARTS(PART)
    lib_count = file_count;
    add_folder(argv[1 + check], "prog");
    qsort(files, (size_t)lib_count, sizeof files[0], compare_names);
    qsort(files + lib_count, (size_t)(file_count - lib_count), sizeof files[0], compare_names);

    read_file(header, &in);
    begin = strstr(in.data, BEGIN);
    end = begin ? strstr(begin, END) : NULL;
    if (!end) fail("no >>> glsl block", header);
    begin += strlen(BEGIN);
    append(&out, in.data, (size_t)(begin - in.data));
    put_all(&out);
    put(&out, end);
    if (in.size == out.size && memcmp(in.data, out.data, in.size) == 0) return 0;
    printf("embed: %s %s\n", header, check ? "differs from src/shaders" : "written");
    if (check) {
        printf("repair with:\n    make embed\n    git commit -m \"embed: Follow src/shaders\" -- src %s\n", header);
        return 1;
    } else {
        FILE *f = fopen(header, "wb");
        if (!f || fwrite(out.data, 1, out.size, f) != out.size || fclose(f) != 0) fail("cannot be written", header);
    }
    return 0;
}
