/* csm_golden_test - the lines of tests/determinism/csm_bytes.c against tests/golden/csm_bytes.txt, in whatever way this
   test was built (config=scalar: without intrinsics). A new format makes new lines: cc -std=c99 -O2 -I. -Itests
   tests/determinism/csm_bytes.c -lm -o /tmp/b && /tmp/b > tests/golden/csm_bytes.txt */

#define CSM_BYTES_NO_MAIN
#include "../determinism/csm_bytes.c"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>

static void blocks_and_answers_are_what_they_were(void **state)
{
    FILE *f = fopen("tests/golden/csm_bytes.txt", "r");
    char line[256], expected[256];
    int i, differ = 0;
    (void)state;
    if (!f) fail_msg("tests/golden/csm_bytes.txt cannot be read");
    for (i = 0; bytes_case(i, line, sizeof line); i++) {
        if (!fgets(expected, (int)sizeof expected, f)) expected[0] = 0;
        if (strcmp(line, expected) == 0) continue;
        if (differ++ < 3) print_message("now  %sonce %s", line, expected);
    }
    fclose(f);
    if (differ) fail_msg("%d of %d lines differ", differ, i);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(blocks_and_answers_are_what_they_were) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
