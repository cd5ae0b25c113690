/* child.c - programs that benchmarks run as a user does, and the figures that those write. */
#define _XOPEN_SOURCE 700
#include "bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

static double seconds_of_children(void)
{
    struct rusage u;
    if (getrusage(RUSAGE_CHILDREN, &u) != 0)
        return HUGE_VAL;
    return (double)(u.ru_utime.tv_sec + u.ru_stime.tv_sec) + 1e-6 * (double)(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
}

void bn_program(const bn_options *options, const char *name, char path[1024])
{
    const char *slash = strrchr(options->program, '/');
    snprintf(path, 1024, "%.*s%s", slash ? (int)(slash + 1 - options->program) : 0, options->program, name);
}

int bn_start(const char *program, const char *const *arguments, double *cpu)
{
    const double before = seconds_of_children();
    int status;
    pid_t child = fork();
    if (child == 0) {
        execv(program, (char *const *)(size_t)arguments);
        _exit(127);
    }
    if (child < 0 || waitpid(child, &status, 0) != child)
        return -1;
    if (cpu)
        *cpu = seconds_of_children() - before;
    return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? 0 : -1;
}

static char *text_behind(const char *path, const char *name, char *text, size_t room)
{
    char key[64], *at;
    FILE *file = fopen(path, "rb");
    size_t length = file ? fread(text, 1, room - 1, file) : 0;
    if (file)
        fclose(file);
    text[length] = 0;
    snprintf(key, sizeof key, "\"%s\": ", name);
    at = strstr(text, key);
    return at ? at + strlen(key) : NULL;
}

double bn_read_number(const char *path, const char *name)
{
    char text[4096], *at = text_behind(path, name, text, sizeof text), *end = NULL;
    const double value = at ? strtod(at, &end) : 0;
    return at && end != at ? value : HUGE_VAL;
}

void bn_read_text(const char *path, const char *name, char *out, size_t room)
{
    char text[4096], *at = text_behind(path, name, text, sizeof text);
    snprintf(out, room, "%.*s", at && *at == '"' ? (int)strcspn(at + 1, "\"") : 0, at ? at + 1 : "");
}
