/* gl_wrong.h - calls that must be refused: with a wrong argument, with a field of a desc that is wrong for one call,
   with a result that stays zero. Include cmocka.h, gl_backend.h and gl_test.h before. */
#ifndef GL_WRONG_H
#define GL_WRONG_H

/* Calls with the test's context have a log: it must have got one line, which names the function, or glbk_begin where a
   pass is wrong, and then what is wrong. `call` is the text of the call, which may stand in brackets behind
   assignments. */
static inline void gl_said_why(const char *call, glbk_result result, const char *file, int line)
{
    const char *name = strstr(call, "glbk_"), *argument;
    size_t length;
    while (name && name[strcspn(name, "( ,;)")] != '(') name = strstr(name + 1, "glbk_");
    if (!name) return;
    length = strcspn(name, "(");
    argument = name + length + 1;
    if (strncmp(argument, "gl,", 3) != 0 && strncmp(argument, "&t->gl,", 7) != 0) return;
    if (gl_lines == 1 && !strchr(gl_line, '\n') &&
        ((strncmp(gl_line, name, length) == 0 && strncmp(gl_line + length, ": ", 2) == 0) ||
         strncmp(gl_line, "glbk_begin: pass.", 17) == 0))
        return;
    printf("%s:%d: %s: %s, with %u lines in the log, the last: %s\n", file, line, call, glbk_result_text(result),
           gl_lines, gl_line);
    assert_string_equal("no line", "one line that says why the call is refused");
}

/* The call returns an error and says why. */
#define ERROR_IS(result, call)                          \
    do {                                                \
        gl_lines = 0;                                   \
        gl_line[0] = 0;                                 \
        assert_int_equal(call, result);                 \
        gl_said_why(#call, result, __FILE__, __LINE__); \
    } while (0)
#define REFUSED(call) ERROR_IS(GLBK_ERR_ARGUMENT, call)

/* `result` comes out of the call, which holds `field` as `value`. */
#define BAD_IS(result, field, value, call)              \
    do {                                                \
        unsigned char gl_kept[sizeof(field)];           \
        memcpy(gl_kept, &(field), sizeof gl_kept);      \
        (field) = (value);                              \
        ERROR_IS(result, call);                         \
        memcpy(&(field), gl_kept, sizeof gl_kept);      \
    } while (0)
#define BAD(field, value, call) BAD_IS(GLBK_ERR_ARGUMENT, field, value, call)

/* The call makes nothing: `out`, which held rubbish, is zero. */
static inline void gl_is_zero(const void *out, size_t size)
{
    const unsigned char *bytes = (const unsigned char *)out;
    size_t i;
    for (i = 0; i < size; i++) assert_int_equal(bytes[i], 0);
}

#define MAKES_IS(result, out, call)                     \
    do {                                                \
        memset(&(out), 0xA5, sizeof(out));              \
        ERROR_IS(result, call);                         \
        gl_is_zero(&(out), sizeof(out));                \
    } while (0)
#define MAKES(out, call) MAKES_IS(GLBK_ERR_ARGUMENT, out, call)

#define WRONG_IS(result, out, field, value, call)       \
    do {                                                \
        memset(&(out), 0xA5, sizeof(out));              \
        BAD_IS(result, field, value, call);             \
        gl_is_zero(&(out), sizeof(out));                \
    } while (0)
#define WRONG(out, field, value, call) WRONG_IS(GLBK_ERR_ARGUMENT, out, field, value, call)

/* The same with a field that the desc must not have so. */
#define DESC_BAD(field, value, call) BAD_IS(GLBK_ERR_DESC, field, value, call)
#define DESC_WRONG(out, field, value, call) WRONG_IS(GLBK_ERR_DESC, out, field, value, call)

/* Transforms that are no rotation with one scale and a translation. */
static const struct { int at; float value; } wrong_transforms[] = {
    { 3, 1 }, { 7, 1 }, { 11, 1 }, { 15, 2 },                   /* projective */
    { 0, NAN }, { 14, INFINITY }, { 0, 1e30f },
    { 0, 0 }, { 5, 0 }, { 10, 0 },                              /* flat */
    { 0, 2 }, { 5, 2 }, { 10, 2 },                              /* of several scales */
    { 4, 0.01f }, { 8, 0.01f }, { 9, 0.01f },                   /* sheared */
    { 0, -1 },                                                  /* mirrored */
};
enum { wrong_transform_count = sizeof wrong_transforms / sizeof wrong_transforms[0] };

static inline void wrong_transform(size_t i, float m[16])
{
    m[wrong_transforms[i].at] = wrong_transforms[i].value;
}

#endif
