/* gl_says.h - calls that must fail and write exactly one line to the log, which is given whole: function, field or
   element, value, range. Include cmocka.h, gl_backend.h and gl_test.h before. */
#ifndef GL_SAYS_H
#define GL_SAYS_H

#include <stdio.h>

static struct { char line[256]; int lines; } gl_said;

static inline void gl_say(void *user, const char *message)
{
    (void)user;
    gl_said.lines++;
    snprintf(gl_said.line, sizeof gl_said.line, "%s", message);
}

/* From here on the context logs to gl_said. */
static inline void gl_listen(gl_test *t) { t->gl.system.log = gl_say; }

#define SAYS(call, result, text)                        \
    do {                                                \
        gl_said.lines = 0;                              \
        gl_said.line[0] = 0;                            \
        assert_int_equal(call, result);                 \
        assert_string_equal(gl_said.line, text);        \
        assert_int_equal(gl_said.lines, 1);             \
    } while (0)

/* The same while a field has a wrong value. */
#define SAYS_OF(field, value, call, result, text)       \
    do {                                                \
        unsigned char gl_was[sizeof(field)];            \
        memcpy(gl_was, &(field), sizeof gl_was);        \
        (field) = (value);                              \
        SAYS(call, result, text);                       \
        memcpy(&(field), gl_was, sizeof gl_was);        \
    } while (0)

#endif
