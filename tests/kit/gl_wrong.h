/* gl_wrong.h - calls that must be refused: with a wrong argument, with a field of a desc that is wrong for one call,
   with a result that stays zero. Include cmocka.h, gl_backend.h and gl_test.h before. */
#ifndef GL_WRONG_H
#define GL_WRONG_H

#define REFUSED(call) assert_int_equal(call, GLBK_ERR_ARGUMENT)

/* `result` comes out of the call, which holds `field` as `value`. */
#define BAD_IS(result, field, value, call)              \
    do {                                                \
        unsigned char gl_kept[sizeof(field)];           \
        memcpy(gl_kept, &(field), sizeof gl_kept);      \
        (field) = (value);                              \
        assert_int_equal(call, result);                 \
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
        assert_int_equal(call, result);                 \
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
