/* message_test - the lines that failed calls write into the caller's log: unit message of src/shared. */

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "src/shared/message.h"

static char line[512];
static int  calls;

static void keep(void *user, const char *message)
{
    (void)user;
    calls++;
    strcpy(line, message);
}

static const P_logger logger = { keep, NULL, "cohsm_build" };

static const char *number(double value)
{
    static P_message m;
    m.used = 0;
    P_message_number(&m, value);
    return m.text;
}

static void whole_numbers_have_all_their_digits(void **state)
{
    (void)state;
    assert_string_equal(number(0.0), "0");
    assert_string_equal(number(-3.0), "-3");
    assert_string_equal(number(16777217.0), "16777217");
    assert_string_equal(number(4294967295.0), "4294967295");
}

static void other_numbers_have_six_digits(void **state)
{
    (void)state;
    assert_string_equal(number(0.25), "0.25");
    assert_string_equal(number(3.14159265), "3.14159");
    assert_string_equal(number(0.0001), "0.0001");
    assert_string_equal(number(1.5e-7), "1.5e-7");
    assert_string_equal(number(-1e300), "-1e300");
    assert_string_equal(number(999999.96), "1000000");
    assert_string_equal(number(5e-324), "4.94066e-324");
    assert_string_equal(number(strtod("inf", NULL)), "infinity");
    assert_string_equal(number(-strtod("inf", NULL)), "-infinity");
    assert_string_equal(number(strtod("nan", NULL)), "not a number");
}

/* The last of six digits may be one off where a value lies between two: 1e-5 of the value is allowed. */
static void random_numbers_read_back(void **state)
{
    uint32_t seed = 1, i;
    (void)state;
    for (i = 0; i < 200000; i++) {
        double value, back;
        seed = seed * 1664525u + 1013904223u;
        value = (double)(seed >> 8) * (i % 2 ? 1e-9 : 37.25);
        back = strtod(number(value), NULL);
        assert_true(back >= value * (1.0 - 1e-5) && back <= value * (1.0 + 1e-5));
    }
}

static void a_line_names_function_field_value_and_range(void **state)
{
    (void)state;
    P_log_value(&logger, "desc.map_side", 3.0, "0 or 4..1024");
    assert_string_equal(line, "cohsm_build: desc.map_side is 3; it must be 0 or 4..1024");
    P_log_text(&logger, "mesh.positions", "is NULL");
    assert_string_equal(line, "cohsm_build: mesh.positions is NULL");
    P_log_element(&logger, "normals", 17, "has the length", 0.5, "1 (0.97..1.03), or 0");
    assert_string_equal(line, "cohsm_build: normals[17] has the length 0.5; it must be 1 (0.97..1.03), or 0");
}

static void a_bad_mesh_is_told_by_index_and_triangle(void **state)
{
    (void)state;
    P_log_index(&logger, "mesh", 53, 90, 80);
    assert_string_equal(line, "cohsm_build: mesh: index 2 of triangle 17 is 90, but the mesh has 80 vertices");
    P_log_index(&logger, "meshes[1]", 0, 1, 1);
    assert_string_equal(line, "cohsm_build: meshes[1]: index 0 of triangle 0 is 1, but the mesh has 1 vertex");
}

static void long_texts_are_cut_off(void **state)
{
    char text[400];
    (void)state;
    memset(text, 'a', sizeof text - 1);
    text[sizeof text - 1] = 0;
    P_log_text(&logger, "desc", text);
    assert_int_equal(strlen(line), sizeof((P_message *)NULL)->text - 1);
}

static void without_a_log_nothing_is_called(void **state)
{
    const P_logger none = { NULL, NULL, "f" };
    (void)state;
    calls = 0;
    P_log_value(&none, "a", 1.0, "2");
    P_log_text(&none, "a", "b");
    P_log_element(&none, "a", 1, "b", 1.0, "2");
    P_log_index(&none, "a", 1, 2, 3);
    assert_int_equal(calls, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whole_numbers_have_all_their_digits),
        cmocka_unit_test(other_numbers_have_six_digits),
        cmocka_unit_test(random_numbers_read_back),
        cmocka_unit_test(a_line_names_function_field_value_and_range),
        cmocka_unit_test(a_bad_mesh_is_told_by_index_and_triangle),
        cmocka_unit_test(long_texts_are_cut_off),
        cmocka_unit_test(without_a_log_nothing_is_called)
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
