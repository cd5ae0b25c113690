/* ---- glsl: the text of a program ---- */

enum { GLBK__MAX_FILES = 32 };

/* Returns whether a name is the three parts together, as "lib/table.glsl" is "lib/", "table" and ".glsl";
   length counts the middle. */
static int glbk__is_named(const char *name, const char *before, const char *middle, size_t length,
                          const char *after)
{
    size_t n = strlen(before);
    return strncmp(name, before, n) == 0 && strncmp(name + n, middle, length) == 0 &&
           strcmp(name + n + length, after) == 0;
}

static const glbk_file *glbk__find_in(const glbk_part *part, const char *before, const char *middle,
                                      size_t length, const char *after)
{
    uint32_t i;
    for (i = 0; i < part->file_count; i++)
        if (glbk__is_named(part->files[i].name, before, middle, length, after)) return &part->files[i];
    return NULL;
}

GLBK__DEF const char *glbk__file_fact(const glbk_file *file, int which)
{
    const char *s = file->name;
    while (which--) s += strlen(s) + 1;
    return s;
}

GLBK_DEF const char *glbk_file_text(const glbk_file *file)
{
    return file ? glbk__file_fact(file, GLBK__FILE_TEXT) : NULL;
}

GLBK_DEF const glbk_file *glbk_find_file(const glbk_part *part, const char *name)
{
    const glbk_file *file = part && name ? glbk__find_in(part, "", name, strlen(name), "") : NULL;
    return file || !name ? file : glbk__find_in(glbk__base(), "", name, strlen(name), "");
}

/* Library files in the order in which they are compiled, and the parts in which they are looked for: the
   shader's, then the base. */
typedef struct glbk__list {
    const glbk_file *file[GLBK__MAX_FILES];
    uint32_t         count;
    const glbk_part *parts[GLBK_MAX_PARTS + 1];
    const char      *unknown;       /* the first name that no part has; NULL = none, or too many files */
    size_t           unknown_length;
} glbk__list;

static const glbk_file *glbk__find_listed(const glbk__list *list, const char *before, const char *middle,
                                          size_t length, const char *after)
{
    const glbk_file *file = NULL;
    uint32_t i;
    for (i = 0; i <= GLBK_MAX_PARTS && !file; i++)
        if (list->parts[i]) file = glbk__find_in(list->parts[i], before, middle, length, after);
    return file;
}

/* Moves *s to the next word of a list that is separated by blanks. Returns the word's length, 0 at the end.
 */
static size_t glbk__next_word(const char **s)
{
    size_t length = 0;
    while (**s == ' ') (*s)++;
    while ((*s)[length] && (*s)[length] != ' ') length++;
    return length;
}

static int glbk__is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
static int glbk__is_name(char c) { return glbk__is_letter(c) || (c >= '0' && c <= '9'); }

static int glbk__gather(glbk__list *list, const char *names);

/* Adds a library file after the files that it uses itself, unless it is in the list. The recursion is as deep
   as the embedded files make it (backend_test.c walks all). Returns 0 for an unknown file, or too many. */
static int glbk__gather_file(glbk__list *list, const glbk_file *file)
{
    uint32_t i;
    if (!file || !glbk__gather(list, glbk__file_fact(file, GLBK__FILE_USES))) return 0;
    for (i = 0; i < list->count && list->file[i] != file; i++) {}
    if (i < list->count) return 1;
    if (list->count == GLBK__MAX_FILES) return 0;
    list->file[list->count++] = file;
    return 1;
}

/* Adds the library files named. Returns 0 if one is unknown, which the list then keeps. */
static int glbk__gather(glbk__list *list, const char *names)
{
    size_t length;
    for (; (length = glbk__next_word(&names)) != 0; names += length) {
        const glbk_file *file = glbk__find_listed(list, "lib/", names, length, ".glsl");
        if (!file && !list->unknown) {
            list->unknown = names;
            list->unknown_length = length;
        }
        if (!glbk__gather_file(list, file)) return 0;
    }
    return 1;
}

/* Adds the uniform blocks that a text names. No others are declared, since a block that is declared needs a
   buffer whether it is read or not (std140; WebGL 2 refuses to draw). Returns 0 as glbk__gather_file does. */
static int glbk__gather_blocks(glbk__list *list, const glbk_part *part, const char *text)
{
    uint32_t i;
    for (i = 0; i < part->file_count; i++) {
        const char *name = glbk__file_fact(&part->files[i], GLBK__FILE_BLOCK), *at = text;
        size_t length = strlen(name);
        if (!length) continue;
        while ((at = strstr(at, "glbk_")) != NULL &&
               (strncmp(at, name, length) != 0 || glbk__is_name(at[length])))
            at++;
        if (at && !glbk__gather_file(list, &part->files[i])) return 0;
    }
    return 1;
}

/* Gathers the files before a shader's own text, and writes its main file, or NULL if it has none. Returns 0
   if a name is unknown. */
static int glbk__gather_all(glbk__list *list, const glbk_shader *shader, const glbk_file **main_file)
{
    uint32_t i;
    int known;
    list->count = 0;
    list->unknown = NULL;
    list->unknown_length = 0;
    memcpy(list->parts, shader->parts, sizeof shader->parts);
    list->parts[GLBK_MAX_PARTS] = glbk__base();
    *main_file = shader->name ? glbk__find_listed(list, "", shader->name, strlen(shader->name), "") : NULL;
    if (shader->name && !*main_file) {
        list->unknown = shader->name;
        list->unknown_length = strlen(shader->name);
    }
    known = (!shader->name || *main_file) && glbk__gather(list, "prelude") &&
            glbk__gather(list, shader->uses ? shader->uses : "") &&
            glbk__gather(list, *main_file ? glbk__file_fact(*main_file, GLBK__FILE_USES) : "");
    for (i = 0; i <= GLBK_MAX_PARTS && known && shader->text; i++)
        if (list->parts[i]) known = glbk__gather_blocks(list, list->parts[i], shader->text);
    return known;
}

GLBK__DEF void glbk__append(glbk__sink *sink, const char *text, size_t length)
{
    size_t room = sink->bytes > sink->used + 1 ? sink->bytes - 1 - sink->used : 0;
    if (room > length) room = length;
    if (room) memcpy(sink->out + sink->used, text, room);
    sink->used += length;
}

GLBK__DEF void glbk__append_text(glbk__sink *sink, const char *text)
{
    glbk__append(sink, text, strlen(text));
}

GLBK__DEF void glbk__append_number(glbk__sink *sink, uint64_t number)
{
    char digits[24];
    size_t at = sizeof digits;
    do digits[--at] = (char)('0' + number % 10);
    while ((number /= 10) != 0);
    glbk__append(sink, digits + at, sizeof digits - at);
}

GLBK__DEF void glbk__begin_line(glbk__sink *sink, char out[GLBK__LINE_ROOM])
{
    memset(out, 0, GLBK__LINE_ROOM);
    sink->out = out;
    sink->bytes = GLBK__LINE_ROOM;
    sink->used = 0;
}

/* Appends "#line n001 n", so that line 4 of file 3 is line 3004 in the driver's messages. The number alone
   would do, but Mesa's messages leave it out. */
static void glbk__append_line(glbk__sink *sink, uint32_t n)
{
    glbk__append_text(sink, "#line ");
    glbk__append_number(sink, n);
    glbk__append_text(sink, "001 ");
    glbk__append_number(sink, n);
    glbk__append_text(sink, "\n");
}

GLBK__DEF void glbk__append_file(glbk__sink *sink, const glbk_file *file)
{
    const char *s;
    for (s = glbk_file_text(file); *s; s += strlen(s) + 1) glbk__append_text(sink, s);
}

static int glbk__is_value(char c) { return glbk__is_name(c) || c == '.' || c == '-'; }

/* Appends defines: "A=1 B" becomes "#define A 1", "#define B 1". Returns 0 if they do not parse. */
static int glbk__append_defines(glbk__sink *sink, const char *defines)
{
    size_t length;
    for (; (length = glbk__next_word(&defines)) != 0; defines += length) {
        size_t name = 0, i;
        while (name < length && defines[name] != '=') name++;
        if (!name || !glbk__is_letter(defines[0])) return 0;
        for (i = 0; i < length; i++)
            if (i != name && !glbk__is_value(defines[i])) return 0;
        glbk__append_text(sink, "#define ");
        glbk__append(sink, defines, name);
        glbk__append_text(sink, " ");
        if (name < length) glbk__append(sink, defines + name + 1, length - name - 1);
        else glbk__append_text(sink, "1");
        glbk__append_text(sink, "\n");
    }
    return 1;
}

GLBK_DEF size_t glbk_write_glsl(glbk_dialect dialect, int float_bits, const glbk_shader *shader, char *out,
                                size_t bytes)
{
    static const char versions[][19] = { "#version 330 core\n", "#version 330 core\n", "#version 300 es\n",
                                         "#version 430 core\n" };
    const glbk_file *main_file;
    glbk__list list;
    glbk__sink sink;
    uint32_t i;

    if ((unsigned)dialect >= GLBK_GLSL_COUNT || !shader || (!out && bytes)) return 0;
    if (!glbk__gather_all(&list, shader, &main_file)) return 0;
    sink.out = out;
    sink.bytes = bytes;
    sink.used = 0;
    glbk__append_text(&sink, versions[dialect]);
    glbk__append_text(&sink, float_bits ? "#define GLBK_FLOAT_BITS 1\n" : "#define GLBK_FLOAT_BITS 0\n");
    if (!glbk__append_defines(&sink, shader->defines ? shader->defines : "")) return 0;
    for (i = 0; i < list.count; i++) {
        glbk__append_line(&sink, i + 1);
        glbk__append_file(&sink, list.file[i]);
    }
    /* What a text declares must stand before main: Firefox writes zeros to varyings there. */
    if (main_file && shader->text) {
        glbk__append_line(&sink, list.count + 2);
        glbk__append_text(&sink, shader->text);
        glbk__append_text(&sink, "\n");
    }
    glbk__append_line(&sink, list.count + 1);
    if (main_file) glbk__append_file(&sink, main_file);
    else if (shader->text) glbk__append_text(&sink, shader->text);
    if (bytes) out[sink.used < bytes ? sink.used : bytes - 1] = 0;
    return sink.used + 1;
}
