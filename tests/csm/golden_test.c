/* golden_test - the lines of tests/csm/bytes.c against tests/csm/golden_bytes.txt, in whatever way this test was
   built (config=scalar: without intrinsics). A new format makes new lines: cc -std=c99 -O2 -I. -Itests
   tests/csm/bytes.c -lm -o /tmp/b && /tmp/b > tests/csm/golden_bytes.txt */

#define CSM_BYTES_NO_MAIN
#include "bytes.c"

#include "golden.h"

static void blocks_and_answers_are_what_they_were(void **state)
{
    FILE *now = tmpfile();
    char line[256];
    int i;
    (void)state;
    for (i = 0; now && bytes_case(i, line, sizeof line); i++) fputs(line, now);
    golden_same("tests/csm/golden_bytes.txt", now);
}

/* Files that an earlier build wrote: every later 1.x opens them and answers as before. */
static void files_of_format_1_open(void **state)
{
    static const struct { const char *name; unsigned long answers; } files[] = {
        { "tests/csm/format1.csm", 0xe649bcceul },
        { "tests/csm/format1-list.csm", 0x7b4e0e59ul },
        { "tests/csm/format1-packed.csm", 0xe649bcceul },
    };
    static uint8_t data[16384];
    size_t i;
    (void)state;
    for (i = 0; i < sizeof files / sizeof *files; i++) {
        FILE *f = fopen(files[i].name, "rb");
        cohsm_maps *maps;
        unsigned long now;
        size_t size;
        if (!f) fail_msg("%s cannot be read", files[i].name);
        size = fread(data, 1, sizeof data, f);
        fclose(f);
        assert_int_equal(cohsm_open(data, size, NULL, &maps), COHSM_OK);
        now = (unsigned long)bytes_answers(maps);
        if (now != files[i].answers)
            fail_msg("%s: answers 0x%08lx, once 0x%08lx", files[i].name, now, files[i].answers);
        cohsm_free(maps);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(blocks_and_answers_are_what_they_were),
                                        cmocka_unit_test(files_of_format_1_open) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
