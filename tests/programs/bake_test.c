/* bake_test - the program bake: shards and parts give the bytes of the whole, a killed bake goes on where it was, bad
   arguments and files have their exit status and one line. BUILD names the folder of the programs. */
#define _POSIX_C_SOURCE 200809L

#include <dirent.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#include <cmocka.h>

static char folder[] = "/tmp/dapple-bake-XXXXXX", program[512];

static int make_folder(void **state)
{
    const char *build = getenv("BUILD");
    (void)state;
    snprintf(program, sizeof program, "%s/bake", build ? build : "build");
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    char command[128];
    (void)state;
    snprintf(command, sizeof command, "rm -rf %s", folder);
    return system(command);
}

/* Exit status of bake with these arguments, @ standing for the folder; stdout and the error line go to `text`. */
static int run(char *text, size_t room, const char *arguments)
{
    char command[4096];
    size_t n = (size_t)snprintf(command, sizeof command, "%s ", program), got;
    FILE *pipe;
    int status;
    for (; *arguments && n + 64 < sizeof command; arguments++)
        if (*arguments == '@') n += (size_t)snprintf(command + n, sizeof command - n, "%s", folder);
        else command[n++] = *arguments;
    snprintf(command + n, sizeof command - n, " 2>&1");
    pipe = popen(command, "r");
    assert_non_null(pipe);
    got = fread(text, 1, room - 1, pipe);
    text[got] = 0;
    status = pclose(pipe);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static void done(const char *arguments)
{
    char text[2048];
    if (run(text, sizeof text, arguments) != 0) fail_msg("bake %s: %s", arguments, text);
}

static size_t bytes_of(const char *name, char **out)
{
    char path[256];
    FILE *file;
    size_t size;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    file = fopen(path, "rb");
    if (!file) fail_msg("no %s", path);
    fseek(file, 0, SEEK_END);
    size = (size_t)ftell(file);
    rewind(file);
    *out = (char *)malloc(size + 1);
    assert_non_null(*out);
    assert_int_equal(fread(*out, 1, size, file), size);
    fclose(file);
    return size;
}

static void same(const char *a, const char *b)
{
    char *x, *y;
    size_t n = bytes_of(a, &x), m = bytes_of(b, &y);
    if (n != m || memcmp(x, y, n) != 0) fail_msg("%s and %s differ", a, b);
    free(x);
    free(y);
}

/* Files in the folder whose names contain a text. */
static int files_with(const char *text)
{
    DIR *d = opendir(folder);
    struct dirent *e;
    int n = 0;
    assert_non_null(d);
    while ((e = readdir(d)) != NULL) n += strstr(e->d_name, text) != NULL;
    closedir(d);
    return n;
}

#define KNOT "csm builtin:knot --set side=10 --set map_side=32 "
#define FIELD "shadowfield builtin:cornell --set position_side=3 --set shell_count=5 "

static void shards_and_parts_are_the_whole(void **state)
{
    char text[2048], line[256];
    int i;
    (void)state;
    done(KNOT "-o @/a.csm");
    done(KNOT "-o @/parts.csm --set parts=7");
    same("a.csm", "parts.csm");
    done(FIELD "-o @/a.sf");
    done(FIELD "-o @/parts.sf --set parts=3 --threads 1");
    same("a.sf", "parts.sf");
    assert_int_equal(files_with(".part-"), 0);
    for (i = 1; i <= 5; i++) {
        snprintf(line, sizeof line, KNOT "-o @/s%d.csm --shard %d/5", i, i);
        done(line);
        snprintf(line, sizeof line, FIELD "-o @/s%d.sf --shard %d/5", i, i);
        done(line);
    }
    done("merge -o @/merged.csm @/s1.csm @/s2.csm @/s3.csm @/s4.csm @/s5.csm");
    same("a.csm", "merged.csm");
    done("merge -o @/merged.sf @/s1.sf @/s2.sf @/s3.sf @/s4.sf @/s5.sf");
    same("a.sf", "merged.sf");
    done(KNOT "-o @/packed.csm --set packed=1");
    done("merge -o @/merged-packed.csm @/s1.csm @/s2.csm @/s3.csm @/s4.csm @/s5.csm --set packed=1");
    same("packed.csm", "merged-packed.csm");
    assert_int_equal(run(text, sizeof text, "merge -o @/x @/s2.csm @/s1.csm"), 1);
    assert_int_equal(run(text, sizeof text, "merge -o @/x @/s1.sf @/s1.csm"), 1);
    assert_int_equal(run(text, sizeof text, "merge -o @/x @/s1.sf @/s2.sf"), 1);
    assert_int_equal(files_with("x"), 0);
}

static void files_are_described_and_verified(void **state)
{
    char text[2048];
    (void)state;
    done(KNOT "-o @/v.csm");
    done(FIELD "-o @/v.sf");
    assert_int_equal(run(text, sizeof text, "info @/v.csm"), 0);
    assert_non_null(strstr(text, "\"maps\": 100, \"map_side\": 32"));
    assert_int_equal(run(text, sizeof text, "info @/v.sf"), 0);
    assert_non_null(strstr(text, "\"shell_count\": 5, \"position_side\": 3"));
    assert_int_equal(run(text, sizeof text, "verify @/v.csm builtin:knot"), 0);
    assert_non_null(strstr(text, "\"entries\": 102400, \"wrong\": 0"));
    assert_int_equal(run(text, sizeof text, "verify @/v.csm builtin:plant"), 1);
    assert_non_null(strstr(text, "bake: wrong: "));
    assert_int_equal(run(text, sizeof text, "verify @/v.sf builtin:cornell --set position_side=3 "
                                            "--set shell_count=5"), 0);
    assert_int_equal(run(text, sizeof text, "verify @/v.sf builtin:knot --set position_side=3 --set shell_count=5"), 1);
}

/* The size of maps is found for so many bytes in memory, in every shard alike; a larger budget is used. */
static void a_budget_of_memory_chooses_the_size(void **state)
{
    static const char *const budgets[] = { "0.1", "0.4" };
    char text[2048], line[256], *end;
    unsigned long bytes[2];
    int i;
    (void)state;
    for (i = 0; i < 2; i++) {
        snprintf(line, sizeof line, "csm builtin:knot --set budget=%s -o @/b%d.csm", budgets[i], i);
        done(line);
        snprintf(line, sizeof line, "info @/b%d.csm", i);
        assert_int_equal(run(text, sizeof text, line), 0);
        bytes[i] = strtoul(strstr(text, "\"bytes\": ") + 9, &end, 10);
        assert_true(bytes[i] > 0 && (double)bytes[i] <= 1e6 * strtod(budgets[i], &end));
    }
    assert_true(bytes[1] > 2 * bytes[0]);
    for (i = 1; i <= 2; i++) {
        snprintf(line, sizeof line, "csm builtin:knot --set budget=0.1 -o @/b.csm.%d --shard %d/2", i, i);
        done(line);
    }
    done("merge -o @/b.csm @/b.csm.1 @/b.csm.2");
    same("b0.csm", "b.csm");
    assert_int_equal(run(text, sizeof text, "csm builtin:knot --set budget=0.001 -o @/b.none"), 1);
    assert_non_null(strstr(text, "budget below what side 8 and map_side 16 take"));
    assert_int_equal(files_with("b.none"), 0);
}

#define LAMP "shadowfield builtin:cornell --set position_side=3 --set shell_count=5 --set node=lamp --set kind=source "
#define LAMP_SETTINGS "--set position_side=3 --set shell_count=5 --set node=lamp"

/* What an object shines, and what it hides from its own points: one file or shards of it; the file says what it is. */
static void sources_and_points_are_baked(void **state)
{
    char text[2048], line[256];
    int i;
    (void)state;
    done(LAMP "-o @/lamp.sf");
    done(LAMP "-o @/lamp-parts.sf --set parts=4");
    same("lamp.sf", "lamp-parts.sf");
    for (i = 1; i <= 3; i++) {
        snprintf(line, sizeof line, LAMP "-o @/lamp%d.sf --shard %d/3", i, i);
        done(line);
    }
    done("merge -o @/lamp-merged.sf @/lamp1.sf @/lamp2.sf @/lamp3.sf");
    same("lamp.sf", "lamp-merged.sf");
    assert_int_equal(run(text, sizeof text, "info @/lamp.sf"), 0);
    assert_non_null(strstr(text, "\"kind\": \"source\""));
    assert_int_equal(run(text, sizeof text, "verify @/lamp.sf builtin:cornell " LAMP_SETTINGS), 0);
    assert_non_null(strstr(text, "\"wrong\": 0"));
    assert_int_equal(run(text, sizeof text, "verify @/lamp2.sf builtin:cornell " LAMP_SETTINGS), 0);
    assert_int_equal(run(text, sizeof text, "verify @/lamp.sf builtin:robots --set node=bullet --set position_side=3 "
                                            "--set shell_count=5"), 1);
    assert_non_null(strstr(text, "bake: wrong: "));
    assert_int_equal(run(text, sizeof text, "verify @/lamp.sf builtin:knot"), 1);
    assert_non_null(strstr(text, "nothing shines there"));
    done("shadowfield builtin:robots -o @/points.sf --set kind=self --set node=body");
    assert_int_equal(run(text, sizeof text, "info @/points.sf"), 0);
    assert_non_null(strstr(text, "\"kind\": \"self\""));
    assert_int_equal(run(text, sizeof text, "verify @/points.sf builtin:robots --set node=body"), 0);
    done("shadowfield disc:0,0,0,0,1,0,0.5 -o @/bulb.sf --set kind=lamp --set shell_count=4 --set position_side=2");
    for (i = 1; i <= 2; i++) {
        snprintf(line, sizeof line, "shadowfield disc:0,0,0,0,1,0,0.5 -o @/bulb.%d --set kind=lamp --set shell_count=4 "
                 "--set position_side=2 --shard %d/2", i, i);
        done(line);
    }
    done("merge -o @/merged.sf @/bulb.1 @/bulb.2");
    same("bulb.sf", "merged.sf");
    assert_int_equal(run(text, sizeof text, "verify @/bulb.sf disc:0,0,0,0,1,0,0.5 --set shell_count=4 "
                         "--set position_side=2"), 0);
    assert_int_equal(run(text, sizeof text, "verify @/bulb.sf disc:0,0,0,0,1,0,0.6 --set shell_count=4 "
                         "--set position_side=2"), 1);
    done("shadowfield builtin:robots -o @/few.sf --set kind=self --set node=body --set point_spacing=0.05");
    assert_int_equal(run(text, sizeof text, "info @/few.sf"), 0);
    assert_non_null(strstr(text, "\"kind\": \"self\""));
    assert_int_equal(run(text, sizeof text, "verify @/few.sf builtin:robots --set node=body"), 1);
    assert_int_equal(run(text, sizeof text, "merge -o @/x @/points.sf @/lamp.sf"), 1);
}

static void bad_arguments_and_files_are_named(void **state)
{
    static const struct { const char *arguments; int status; const char *says;
    } bad[] = { { "", 2, "csm, shadowfield, ao" },
                { "soup", 2, "csm, shadowfield, ao" },
                { "csm", 2, "-o FILE is missing" },
                { "csm -o @/o", 2, "wrong number of files" },
                { "csm builtin:knot -o", 2, "no value" },
                { "csm builtin:knot -o @/o --set sied=3", 2, "sied" },
                { "csm builtin:knot -o @/o --set side=0", 2, "side" },
                { "csm builtin:knot -o @/o --set kind=source", 2, "kind" },
                { "shadowfield builtin:knot -o @/o --set kind=light", 2, "occlusion|source|self" },
                { "shadowfield builtin:knot -o @/o --set kind=source", 1, "nothing shines there" },
                { LAMP "-o @/o --set logarithm=1", 1, "logarithm=1 is of occlusion" },
                { "shadowfield builtin:knot -o @/o --set kind=self --set logarithm=1", 1,
                  "logarithm=1 is of occlusion" },
                { "shadowfield builtin:knot -o @/o --set kind=self --shard 1/2", 1, "more shards" },
                { "shadowfield builtin:knot -o @/o --set kind=lamp", 1, "kind=lamp and a lamp" },
                { "shadowfield sphere:0,0,0,1 -o @/o", 1, "kind=lamp and a lamp" },
                { "shadowfield sphere:0,0,0 -o @/o --set kind=lamp", 1, "sphere" },
                { "shadowfield sphere:0,0,0,1 -o @/o --set kind=lamp --set frames=2", 1, "frames are of kind=source" },
                { "shadowfield builtin:knot -o @/o --set kind=self --set frames=2", 1, "frames are of kind=source" },
                { "shadowfield point:0,0,0 -o @/o --set kind=lamp", 1, "lamp_radius" },
                { "shadowfield sphere:0,0,0,1 -o @/o --set kind=lamp --set logarithm=1", 1, "of occlusion" },
                { "csm sphere:0,0,0,1 -o @/o", 1, "a lamp hides nothing" },
                { "csm builtin:knot -o @/o --shard 0/4", 2, "--shard" },
                { "csm builtin:knot -o @/o --shard 5/4", 2, "--shard" },
                { "csm builtin:knot -o @/o --shard 1/4x", 2, "--shard" },
                { "csm builtin:knot -o @/o --shard 1/4 --set parts=3", 2, "parts=N is for a bake without --shard" },
                { "info @/o --set parts=3", 2, "parts=N is for a bake" },
                { "merge -o @/o @/none --shard 1/2", 2, "--shard is not for this command" },
                { "csm builtin:knot -o @/o --threads many", 2, "--threads" },
                { "csm builtin:knot -o @/o --frobnicate 1", 2, "unknown option" },
                { "info @/none", 1, "cannot read" },
                { "info /dev/null", 1, "neither" },
                { "csm builtin:nothing -o @/o", 1, "" },
                { "csm @/none.glb -o @/o", 1, "" },
                { "csm builtin:knot -o @/no/folder/o --set side=2 --set map_side=8", 1, "cannot write" },
                { "csm builtin:knot -o @/o --set node=nobody", 1, "no node" },
                { FIELD "-o @/o --shard 6/6", 1, "more shards" },
                { "merge -o @/o @/none", 1, "cannot read" },
                { "verify @/none builtin:knot", 1, "cannot read" } };
    char text[4096];
    size_t i;
    (void)state;
    for (i = 0; i < sizeof bad / sizeof *bad; i++) {
        int status = run(text, sizeof text, bad[i].arguments);
        if (status != bad[i].status || !strstr(text, bad[i].says) || strncmp(text, "bake: ", 6) != 0 ||
            strchr(text, '\n') != text + strlen(text) - 1)
            fail_msg("bake %s: status %d, %s", bad[i].arguments, status, text);
    }
    assert_int_equal(files_with("o."), 0);
}

/* 1 and the name of the file that ends so. */
static int find(const char *end, char *name, size_t room)
{
    DIR *d = opendir(folder);
    struct dirent *e;
    int found = 0;
    assert_non_null(d);
    while ((e = readdir(d)) != NULL && !found) {
        size_t n = strlen(e->d_name), m = strlen(end);
        found = n > m && strcmp(e->d_name + n - m, end) == 0;
        if (found) snprintf(name, room, "%s", e->d_name);
    }
    closedir(d);
    return found;
}

#define LONGER "--set side=48 --set map_side=64 "

/* Killed as soon as its second part is there. That finished parts are not baked again shows when one of them is another
   object's: then the parts do not belong together. */
static void a_killed_bake_goes_on(void **state)
{
    char out[128], part[256], line[600], text[2048];
    int status, tries;
    pid_t child = fork();
    (void)state;
    assert_true(child >= 0);
    snprintf(out, sizeof out, "%s/killed.csm", folder);
    if (child == 0) {
        execl(program, program, "csm", "builtin:knot", "-o", out, "--set", "side=48", "--set", "map_side=64", "--set",
              "parts=8", "--threads", "1", (char *)NULL);
        _exit(127);
    }
    for (tries = 0; tries < 12000 && !find("-2of8", part, sizeof part); tries++) {
        struct timespec pause = { 0, 5000000 };
        nanosleep(&pause, NULL);
    }
    kill(child, SIGKILL);
    waitpid(child, &status, 0);
    assert_true(WIFSIGNALED(status));           /* it had not ended */
    assert_false(find("killed.csm", line, sizeof line));
    assert_true(find("-1of8", part, sizeof part));
    snprintf(line, sizeof line, "cp %s/%s %s/saved", folder, part, folder);
    assert_int_equal(system(line), 0);
    snprintf(line, sizeof line, "csm builtin:plant " LONGER "--shard 1/8 -o @/%s", part);
    done(line);
    assert_int_equal(run(text, sizeof text, "csm builtin:knot -o @/killed.csm " LONGER "--set parts=8"), 1);
    assert_non_null(strstr(text, "does not belong together"));
    snprintf(line, sizeof line, "cp %s/saved %s/%s", folder, folder, part);
    assert_int_equal(system(line), 0);
    done("csm builtin:knot -o @/killed.csm " LONGER "--set parts=8");
    assert_int_equal(files_with("of8"), files_with(".tmp"));        /* a part that was being written when it died */
    done("csm builtin:knot -o @/again.csm " LONGER);
    same("killed.csm", "again.csm");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shards_and_parts_are_the_whole),
        cmocka_unit_test(files_are_described_and_verified),
        cmocka_unit_test(a_budget_of_memory_chooses_the_size),
        cmocka_unit_test(sources_and_points_are_baked),
        cmocka_unit_test(bad_arguments_and_files_are_named),
        cmocka_unit_test(a_killed_bake_goes_on),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
