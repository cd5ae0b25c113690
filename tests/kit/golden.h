/* golden.h - for golden_test.c of each header: what its bytes.c prints, beside lines kept of an earlier day. */
#ifndef DAPPLE_GOLDEN_H
#define DAPPLE_GOLDEN_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

/* now: written from its beginning; is closed. */
static void golden_same(const char *path, FILE *now)
{
    FILE *once = fopen(path, "r");
    char line[256], expected[256];
    int lines = 0, differ = 0;

    assert_non_null(now);
    if (!once) fail_msg("%s cannot be read", path);
    rewind(now);
    for (; fgets(line, (int)sizeof line, now); lines++) {
        if (!fgets(expected, (int)sizeof expected, once)) strcpy(expected, "nothing\n");
        if (strcmp(line, expected) == 0) continue;
        if (differ++ < 3) print_message("now  %sonce %s", line, expected);
    }
    if (fgets(expected, (int)sizeof expected, once)) fail_msg("%s has more lines than the %d of now", path, lines);
    fclose(once);
    fclose(now);
    if (differ || !lines) fail_msg("%d of %d lines differ", differ, lines);
}

#endif
