/* golden_test - the lines of tests/envshadow/bytes.c against tests/envshadow/golden_bytes.txt, in whatever
   way this test was built. A deliberate change of method makes new lines:
       cc -std=c99 -O2 -I. -Itests tests/envshadow/bytes.c -lm -o /tmp/b
       /tmp/b > tests/envshadow/golden_bytes.txt */

#define ENVSH_BYTES_NO_MAIN
#include "bytes.c"

#include "golden.h"

static void lights_and_shading_are_what_they_were(void **state)
{
    FILE *now = tmpfile();
    char line[256];
    int i;
    (void)state;
    for (i = 0; now && bytes_case(i, line, sizeof line); i++) fputs(line, now);
    golden_same("tests/envshadow/golden_bytes.txt", now);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(lights_and_shading_are_what_they_were) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
