/* conformance.h - rows of docs/conformance.md, written by the tests that measure them. Include after cmocka.h.

       CONFORM("T72", "blocked by a sphere 2 r away, percent", 6.699, measured, 0.01);
       CONFORM_MAX("T70", "answers that differ from rays", 0, wrong);
       CONFORM_MIN("T15", "p of chi-square, 64 x 32 texels", 0.001, p);
       CONFORM_NOTE("T62", "wrongly lit between z2 and the sphere, z1z3_far", share);

   Each fails the test where the value is not within its limit, except the last, which only reports; beside the call a
   comment says where the tolerance comes from. With CONFORMANCE=FILE in the environment each adds a line to FILE,
   of which tools/conformance makes the page. Rows and their titles are in tests/kit/rows.txt. A test of the
   GL back end defines CONFORM_BACKEND as "gl" before it includes this, and uses the same words as the CPU's test. */
#ifndef CONFORMANCE_H
#define CONFORMANCE_H

#include <stdio.h>
#include <stdlib.h>

#ifndef CONFORM_BACKEND
#define CONFORM_BACKEND "cpu"
#endif

/* Writes the line; returns whether measured is within lo and hi. NaN is not. */
static inline int conform_row(const char *file, const char *test, const char *row, const char *what,
                              const char *expected, const char *tolerance, double measured, double lo, double hi)
{
    const char *path = getenv("CONFORMANCE"), *name = file, *last = file, *c;
    FILE *f = path && *path ? fopen(path, "a") : NULL;
    for (c = file; *c; c++) {           /* the file and its folder, which says whose row this is */
        if (*c != '/' && *c != '\\') continue;
        name = last;
        last = c + 1;
    }
    if (f) {
        fprintf(f, "%s\t%s\t%s\t%s\t%s\t%.7g\t%s\t%s\n", row, what, expected, tolerance, CONFORM_BACKEND, measured,
                name, test);
        fclose(f);
    }
    return measured >= lo && measured <= hi;
}

static inline const char *conform_number(char *text, size_t size, const char *sign, double value)
{
    snprintf(text, size, "%s%.7g", sign, value);
    return text;
}

#define CONFORM_ROW_(row, what, sign, expected, tolerance, measured, lo, hi) \
    do { \
        char conform_a_[40], conform_b_[40]; \
        double conform_m_ = (double)(measured), conform_t_ = (double)(tolerance); \
        if (!conform_row(__FILE__, __func__, row, what, \
                         conform_number(conform_a_, sizeof conform_a_, sign, (double)(expected)), \
                         conform_t_ > 0.0 ? conform_number(conform_b_, sizeof conform_b_, "", conform_t_) : "", \
                         conform_m_, lo, hi)) \
            fail_msg("%s, %s: %.9g is not within %.9g and %.9g", row, what, conform_m_, lo, hi); \
    } while (0)

#define CONFORM(row, what, expected, measured, tolerance) \
    CONFORM_ROW_(row, what, "", expected, tolerance, measured, (double)(expected) - (double)(tolerance), \
                 (double)(expected) + (double)(tolerance))
#define CONFORM_MAX(row, what, bound, measured) \
    CONFORM_ROW_(row, what, "at most ", bound, 0, measured, -1e300, (double)(bound))
#define CONFORM_MIN(row, what, bound, measured) \
    CONFORM_ROW_(row, what, "at least ", bound, 0, measured, (double)(bound), 1e300)
#define CONFORM_NOTE(row, what, measured) \
    ((void)conform_row(__FILE__, __func__, row, what, "(reported)", "", (double)(measured), 0.0, 0.0))

#endif
