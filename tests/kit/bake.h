/* bake.h - what tests that call bake share, after program.h. */
#ifndef BAKE_TEST_H
#define BAKE_TEST_H

#include "program.h"

enum { PATH_ROOM = 400 };

/* The path of a file in the scratch folder. */
static inline void path_of(char path[PATH_ROOM], const char *name)
{
    snprintf(path, PATH_ROOM, "%.40s/%.350s", folder, name);
}

static inline void bake(const char *arguments)
{
    if (run("bake", arguments) != 0)
        fail_msg("bake %s: %s", arguments, output);
}

/* Skips the test where bake, called so, says that it cannot read models. */
static inline void need_parser(const char *arguments)
{
    if (run("bake", arguments) != 0 && strstr(output, "glTF parser")) {
        printf("skip: built without a glTF parser\n");
        skip();
    }
}

#endif
