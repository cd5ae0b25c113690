/* warm_up_test - `render --backend gl --set warm_up=N`: frames that are drawn and thrown away leave nothing behind, so
   that the picture after them is the first one's to the byte, for each technique. */
#define _POSIX_C_SOURCE 200809L
#include "program.h"

#define SIZE 160000

/* A file of the scratch folder; returns its size. */
static size_t read_picture(const char *name, unsigned char *out)
{
    char path[64];
    FILE *file;
    size_t size;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    file = fopen(path, "rb");
    assert_non_null(file);
    size = fread(out, 1, SIZE, file);
    fclose(file);
    assert_true(size < SIZE);
    return size;
}

static void render_to(const char *name, const char *technique, const char *backend, int times)
{
    char arguments[400];
    snprintf(arguments, sizeof arguments, "--technique %s --size 48x36 --backend %s --set warm_up=%d --out %s",
             technique, backend, times, name);
    render_or_skip(arguments);
}

/* Whether the picture after two others is the first one. */
static int is_same(const char *technique, const char *backend)
{
    static unsigned char cold[SIZE], warm[SIZE];
    size_t size;
    render_to("cold.pfm", technique, backend, 0);
    render_to("warm.pfm", technique, backend, 2);
    size = read_picture("cold.pfm", cold);
    assert_true(size > 48 * 36 * 12);
    assert_int_equal(read_picture("warm.pfm", warm), size);
    return memcmp(cold, warm, size) == 0;
}

static void same_after_others(const char *technique)
{
    if (!is_same(technique, "cpu"))
        fail_msg("%s on the processor: another picture after warming up", technique);
    if (!is_same(technique, "gl"))
        fail_msg("%s on OpenGL: another picture after warming up", technique);
}

static void csm_is_the_same_after_others(void **state)
{
    (void)state;
    same_after_others("csm --scene builtin:knot --samples 16 --set side=8 --set filter=roulette");
}

static void shadowfield_is_the_same_after_others(void **state)
{
    (void)state;
    same_after_others("shadowfield --scene builtin:knot --set position_side=2 --set point_spacing=0.3");
}

static void envshadow_is_the_same_after_others(void **state)
{
    (void)state;
    same_after_others("envshadow --scene builtin:knot --set light_count=16");
}

static void rsm_is_the_same_after_others(void **state)
{
    (void)state;
    same_after_others("rsm --scene builtin:cornell --samples 32 --set side=32 --set mode=interpolated");
}

static void ism_is_the_same_after_others(void **state)
{
    (void)state;
    same_after_others("ism --scene builtin:cornell --set vpl_count=64");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(csm_is_the_same_after_others), cmocka_unit_test(shadowfield_is_the_same_after_others),
        cmocka_unit_test(envshadow_is_the_same_after_others), cmocka_unit_test(rsm_is_the_same_after_others),
        cmocka_unit_test(ism_is_the_same_after_others)
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
