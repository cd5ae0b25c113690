/* golden_test - the lines of tests/shadowfield/bytes.c against tests/shadowfield/golden_bytes.txt, in whatever way
   this test was built (config=scalar: without intrinsics). A new format makes new lines: cc -std=c99 -O2 -I. -Itests
   tests/shadowfield/bytes.c -lm -o /tmp/b && /tmp/b > tests/shadowfield/golden_bytes.txt */

#define SFIELD_BYTES_NO_MAIN
#include "bytes.c"

#include "golden.h"

static void files_are_what_they_were(void **state)
{
    FILE *now = tmpfile();
    char line[256];
    int i;
    (void)state;
    for (i = 0; now && bytes_case(i, line, sizeof line); i++) fputs(line, now);
    golden_same("tests/shadowfield/golden_bytes.txt", now);
}

/* Files that an earlier build wrote: every later 1.x opens them, says the same of eight places, writes equal bytes. */
static void files_of_format_1_open(void **state)
{
    static const struct { const char *name; double sum, squares; } files[] = {
        { "tests/shadowfield/format1.sf", 102.136039, 98.557784 },
        { "tests/shadowfield/format1-wavelets.sf", 3038.051629, 753.679940 },
    };
    static uint8_t data[4096], again[4096];
    static float out[8 * 6 * 32 * 32];
    float places[24];
    size_t i, k;
    (void)state;
    for (k = 0; k < 24; k++) places[k] = (k % 3 == k / 3 % 3 ? 1.5f : 0.25f) * (k & 1 ? -1.0f : 1.0f);
    for (i = 0; i < sizeof files / sizeof *files; i++) {
        FILE *f = fopen(files[i].name, "rb");
        double sum = 0, squares = 0;
        sfield_field *field;
        sfield_info info;
        size_t size, each;
        if (!f) fail_msg("%s cannot be read", files[i].name);
        size = fread(data, 1, sizeof data, f);
        fclose(f);
        assert_int_equal(sfield_open(data, size, NULL, &field), SFIELD_OK);
        assert_int_equal(sfield_bytes(field), size);
        assert_int_equal(sfield_write(field, again, sizeof again), SFIELD_OK);
        assert_memory_equal(again, data, size);
        sfield_get_info(field, &info);
        each = info.basis == SFIELD_BASIS_HAAR ? 6 * info.cube_side * info.cube_side : info.bands * info.bands;
        assert_true(info.kind == SFIELD_KIND_OCCLUSION && 8 * each <= sizeof out / sizeof *out);
        assert_int_equal(sfield_query(field, 8, places, 0, out), SFIELD_OK);
        for (k = 0; k < 8 * each; k++) {
            sum += (double)out[k] * (double)(k % 7 + 1);
            squares += (double)out[k] * (double)out[k];
        }
        if (!(fabs(sum - files[i].sum) < 1e-4 * sum && fabs(squares - files[i].squares) < 1e-4 * squares))
            fail_msg("%s: %.6f %.6f, once %.6f %.6f", files[i].name, sum, squares, files[i].sum, files[i].squares);
        sfield_free(field);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(files_are_what_they_were),
                                        cmocka_unit_test(files_of_format_1_open) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
