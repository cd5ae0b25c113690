/* cmocka.h - the part of cmocka that our tests use, for targets that lack it: tcc, musl, mingw, s390x, wasm, or a
   machine with only a compiler. Same names and same lines of output, so that tools/run-tests reads both. Arguments are
   evaluated once. Include <stdarg.h>, <stddef.h>, <setjmp.h> and <stdint.h> before, as with cmocka itself. */
#ifndef CMOCKA_H_
#define CMOCKA_H_

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

typedef void (*CMUnitTestFunction)(void **state);
typedef int (*CMFixtureFunction)(void **state);

struct CMUnitTest {
    const char        *name;
    CMUnitTestFunction test_func;
    CMFixtureFunction  setup_func, teardown_func;
    void              *initial_state;
};

#define cmocka_unit_test(f) { #f, f, NULL, NULL, NULL }
#define cmocka_unit_test_setup_teardown(f, setup, teardown) { #f, f, setup, teardown, NULL }
#define cmocka_unit_test_prestate(f, state) { #f, f, NULL, NULL, state }

static jmp_buf shim_exit;      /* 1 from a failed check, 2 from skip() */

static inline void shim_fail(const char *file, int line, const char *format, ...)
{
    va_list args;
    fprintf(stderr, "[  ERROR   ] --- ");
    va_start(args, format);
    vfprintf(stderr, format, args);
    va_end(args);
    fprintf(stderr, "\n[   LINE   ] --- %s:%d: error: Failure!\n", file, line);
    longjmp(shim_exit, 1);
}

static inline void shim_int(intmax_t a, intmax_t b, int equal, const char *file, int line)
{
    if ((a == b) != equal) shim_fail(file, line, "%lld %s %lld", (long long)a, equal ? "!=" : "==", (long long)b);
}

static inline void shim_range(uintmax_t v, uintmax_t lo, uintmax_t hi, const char *file, int line)
{
    if (v < lo || v > hi)
        shim_fail(file, line, "%llu is not within %llu and %llu", (unsigned long long)v, (unsigned long long)lo,
                  (unsigned long long)hi);
}

static inline void shim_string(const char *a, const char *b, int equal, const char *file, int line)
{
    if ((strcmp(a, b) == 0) != equal) shim_fail(file, line, "\"%s\" %s \"%s\"", a, equal ? "!=" : "==", b);
}

static inline void shim_float(double a, double b, double epsilon, int equal, const char *file, int line)
{
    double d = a > b ? a - b : b - a;
    if ((d <= epsilon) != equal) shim_fail(file, line, "%.9g %s %.9g", a, equal ? "!=" : "==", b);
}

static inline void shim_memory(const void *a, const void *b, size_t size, int equal, const char *file, int line)
{
    if ((memcmp(a, b, size) == 0) != equal) shim_fail(file, line, equal ? "memory differs" : "memory is equal");
}

#define assert_true(c) ((c) ? (void)0 : shim_fail(__FILE__, __LINE__, "%s", #c))
#define assert_false(c) ((c) ? shim_fail(__FILE__, __LINE__, "not %s", #c) : (void)0)
#define assert_null(p) assert_true((p) == NULL)
#define assert_non_null(p) assert_true((p) != NULL)
#define assert_ptr_equal(a, b) assert_true((const void *)(a) == (const void *)(b))
#define assert_int_equal(a, b) shim_int((intmax_t)(a), (intmax_t)(b), 1, __FILE__, __LINE__)
#define assert_int_not_equal(a, b) shim_int((intmax_t)(a), (intmax_t)(b), 0, __FILE__, __LINE__)
#define assert_in_range(v, lo, hi) shim_range((uintmax_t)(v), (uintmax_t)(lo), (uintmax_t)(hi), __FILE__, __LINE__)
#define assert_float_equal(a, b, e) shim_float((double)(a), (double)(b), (double)(e), 1, __FILE__, __LINE__)
#define assert_float_not_equal(a, b, e) shim_float((double)(a), (double)(b), (double)(e), 0, __FILE__, __LINE__)
#define assert_string_equal(a, b) shim_string(a, b, 1, __FILE__, __LINE__)
#define assert_string_not_equal(a, b) shim_string(a, b, 0, __FILE__, __LINE__)
#define assert_memory_equal(a, b, n) shim_memory(a, b, n, 1, __FILE__, __LINE__)
#define assert_memory_not_equal(a, b, n) shim_memory(a, b, n, 0, __FILE__, __LINE__)
#define assert_return_code(rc, error) assert_true((rc) >= 0)
#define fail() shim_fail(__FILE__, __LINE__, "fail()")
#define fail_msg(...) shim_fail(__FILE__, __LINE__, __VA_ARGS__)
#define skip() longjmp(shim_exit, 2)
#define print_message(...) ((void)printf(__VA_ARGS__))
#define print_error(...) ((void)fprintf(stderr, __VA_ARGS__))

/* 0 passed, 1 failed, 2 skipped */
static inline int shim_run_one(const struct CMUnitTest *test, void *group_state)
{
    void *state = test->initial_state ? test->initial_state : group_state;
    int result;

    if (test->setup_func && test->setup_func(&state) != 0) return 1;
    result = setjmp(shim_exit);
    if (result == 0) test->test_func(&state);
    if (test->teardown_func && test->teardown_func(&state) != 0 && result == 0) result = 1;
    return result;
}

static inline int shim_run_group(const char *name, const struct CMUnitTest *tests, size_t count,
                                 CMFixtureFunction setup, CMFixtureFunction teardown)
{
    static const char *const line[3] = { "[       OK ] ", "[  FAILED  ] ", "[  SKIPPED ] " };
    int totals[3] = { 0, 0, 0 };
    void *state = NULL;
    size_t i;

    printf("[==========] Running %lu test(s).\n", (unsigned long)count);
    if (setup && setup(&state) != 0) {
        fprintf(stderr, "[  FAILED  ] GROUP SETUP of %s\n", name);
        return (int)count;
    }
    for (i = 0; i < count; i++) {
        int result;
        printf("[ RUN      ] %s\n", tests[i].name);
        fflush(stdout);
        result = shim_run_one(&tests[i], state);
        totals[result]++;
        fprintf(result == 1 ? stderr : stdout, "%s%s\n", line[result], tests[i].name);
        fflush(stdout);
#ifdef SHIM_STOP        /* for tools/mutate, which asks only whether all pass */
        if (result == 1) break;
#endif
    }
    if (teardown && teardown(&state) != 0) totals[1]++;
    printf("[==========] %lu test(s) run.\n", (unsigned long)count);
    fprintf(stderr, "[  PASSED  ] %d test(s).\n", totals[0]);
    return totals[1];
}

#define cmocka_run_group_tests(tests, setup, teardown) \
    shim_run_group(#tests, tests, sizeof(tests) / sizeof((tests)[0]), setup, teardown)
#define cmocka_run_group_tests_name(name, tests, setup, teardown) \
    shim_run_group(name, tests, sizeof(tests) / sizeof((tests)[0]), setup, teardown)

#endif
