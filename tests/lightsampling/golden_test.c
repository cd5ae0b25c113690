/* golden_test - the lines of tests/lightsampling/bytes.c against tests/lightsampling/golden_bytes.txt, in whatever way
   this test was built. A deliberate change of method makes new lines:
       cc -std=c99 -O2 -I. -Itests tests/lightsampling/bytes.c -lm -o /tmp/b
       /tmp/b > tests/lightsampling/golden_bytes.txt */

#define LSAMP_BYTES_NO_MAIN
#include "bytes.c"

#include "golden.h"

static void patterns_materials_and_samples_are_what_they_were(void **state)
{
    FILE *now = tmpfile();
    (void)state;
    assert_true(now && bytes_lines(now) == 0);
    golden_same("tests/lightsampling/golden_bytes.txt", now);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(patterns_materials_and_samples_are_what_they_were) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
