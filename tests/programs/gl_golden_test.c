/* gl_golden_test - a small picture of each technique on OpenGL, by `render --backend gl` as a user calls it: on
   llvmpipe the same 8-bit pixels for all time (gl_golden_hashes.txt, by Mesa's and LLVM's version) and for other
   widths of its vectors, on softpipe, a driver that shares no arithmetic with it, the same but for one pixel in a
   thousand. Pictures that are not what they should be lie in the build folder, as gl-NAME.png and
   gl-NAME-softpipe.png; differences as gl-NAME-diff.png, white where they pass 2 / 255.

   Two things are left out that Mesa 22.3's softpipe gets wrong, level and index of a quad's first pixel for all four
   (docs/troubleshooting.md): the penumbra filter with several levels of cells, shadow fields of more than 2 bands. */
#define _POSIX_C_SOURCE 200809L
#include "program.h"

#include "common.h"
#include "gl_context.h"

#include <math.h>

#define HASHES "tests/programs/gl_golden_hashes.txt"

static const struct { const char *name, *arguments; float gain; } pictures[] = {
    { "csm", "csm --scene builtin:cornell --samples 4 --set light_side=2 --set light_map_side=32", 4 },
    { "sfield",
      "shadowfield --scene builtin:chess --set position_side=2 --set shell_count=2 --set point_spacing=0.2 --set bands=2", 2 },
    { "envsh", "envshadow --scene builtin:chess --set light_count=16 --set map_side=64 --set filter=smooth", 2 },
    { "rsm", "rsm --scene builtin:cornell --samples 32 --set side=32 --set light_point_count=2", 4 },
    { "ism", "ism --scene builtin:cornell --set vpl_count=16 --set surfel_count=32 --set tile_side=16 "
             "--set rsm_side=16 --set shadow_map_side=32", 4 }
};
enum { PICTURES = sizeof pictures / sizeof pictures[0], WIDTH = 64, HEIGHT = 48, PIXELS = WIDTH * HEIGHT };

typedef struct picture { uint8_t rgb[3 * PIXELS]; } picture;

static void save(const picture *p, const char *name, const char *what)
{
    const char *build = getenv("BUILD");
    char path[300], error[EX_ERROR_SIZE];
    snprintf(path, sizeof path, "%s/gl-%s%s.png", build && *build ? build : "build", name, what);
    if (ex_png_write(path, WIDTH, HEIGHT, p->rgb, error) == 0) printf("%s\n", path);
    else printf("%s\n", error);
}

/* Picture i by a driver of Mesa, in sRGB. Skips the test where another driver answers. */
static void draw(int i, const char *driver, picture *out)
{
    char arguments[400], path[64], error[EX_ERROR_SIZE], wanted[32];
    ex_image image;
    setenv("GALLIUM_DRIVER", driver, 1);
    snprintf(arguments, sizeof arguments, "--technique %s --backend gl --size %dx%d --out p.pfm --json -",
             pictures[i].arguments, WIDTH, HEIGHT);
    render_or_skip(arguments);
    snprintf(wanted, sizeof wanted, "\"%s", driver);
    if (!strstr(output, wanted)) {
        printf("skip: no %s here\n", driver);
        skip();
    }
    snprintf(path, sizeof path, "%s/p.pfm", folder);
    if (ex_image_read_pfm(&image, path, error) != 0) fail_msg("%s", error);
    assert_true(image.width == WIDTH && image.height == HEIGHT);
    for (int k = 0; k < 3 * PIXELS; k++) {
        float x = fminf(fmaxf(image.rgb[k] * pictures[i].gain, 0), 1);
        out->rgb[k] = (uint8_t)(255 * (x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1 / 2.4f) - 0.055f) + 0.5f);
    }
    ex_image_free(&image);
}

/* FNV-1a */
static uint64_t hash_of(const picture *p)
{
    uint64_t h = 0xcbf29ce484222325u;
    for (size_t k = 0; k < sizeof p->rgb; k++) h = (h ^ p->rgb[k]) * 0x100000001b3u;
    return h;
}

/* "22.3.6 15.0.6 x86_64": versions of Mesa and LLVM, and the processor's kind; "" where it is not llvmpipe. The width
   of vectors is no part of it: it changes nothing, which is tested. */
static void driver_key(char *key, size_t size)
{
    const uint8_t *(GLBK_CALL *get_string)(uint32_t) = NULL;
    char error[EX_ERROR_SIZE], mesa[32] = "", llvm[32] = "";
    ex_gl_options options;
    const char *at, *machine = "other";
    ex_gl *gl;
    glbk_proc_fn proc;
#if defined(__x86_64__)
    machine = "x86_64";
#elif defined(__aarch64__)
    machine = "aarch64";
#endif
    *key = 0;
    memset(&options, 0, sizeof options);
    setenv("GALLIUM_DRIVER", "llvmpipe", 1);
    gl = ex_gl_create(&options, error);
    if (!gl) return;
    proc = ex_gl_get_proc("glGetString", gl);
    memcpy(&get_string, &proc, sizeof proc);
    at = strstr((const char *)get_string(0x1F02 /* VERSION */), "Mesa ");
    if (at) sscanf(at, "Mesa %31s", mesa);
    at = strstr((const char *)get_string(0x1F01 /* RENDERER */), "llvmpipe (LLVM ");
    if (at) sscanf(at, "llvmpipe (LLVM %31[^,]", llvm);
    if (*mesa && *llvm) snprintf(key, size, "%s %s %s", mesa, llvm, machine);
    ex_gl_free(gl);
}

/* The line of a picture and a driver in gl_golden_hashes.txt: 1 and its hash, or 0. */
static int known(const char *name, const char *key, uint64_t *hash)
{
    FILE *file = fopen(HASHES, "r");
    char line[200], wanted[140];
    int found = 0;
    assert_non_null(file);
    snprintf(wanted, sizeof wanted, "%s %s ", name, key);
    while (!found && fgets(line, sizeof line, file))
        if (strncmp(line, wanted, strlen(wanted)) == 0) {
            *hash = strtoull(line + strlen(wanted), NULL, 16);
            found = 1;
        }
    fclose(file);
    return found;
}

static void llvmpipe_draws_the_golden_pictures(void **state)
{
    static picture p, narrow;
    char key[100];
    int bad = 0, new_ones = 0;
    (void)state;
    driver_key(key, sizeof key);
    if (!*key) {
        printf("skip: no llvmpipe here\n");
        skip();
    }
    for (int i = 0; i < PICTURES; i++) {
        uint64_t hash, golden;
        int lit = 0;
        draw(i, "llvmpipe", &p);
        for (int k = 0; k < PIXELS; k++) lit += p.rgb[3 * k] > 20 && p.rgb[3 * k] < 250;
        if (lit < PIXELS / 4) fail_msg("%s: a picture of nothing: %d pixels", pictures[i].name, lit);
        setenv("LP_NATIVE_VECTOR_WIDTH", "128", 1);
        draw(i, "llvmpipe", &narrow);
        unsetenv("LP_NATIVE_VECTOR_WIDTH");
        if (memcmp(&p, &narrow, sizeof p) != 0) fail_msg("%s: vectors of 128 bits draw it otherwise", pictures[i].name);
        hash = hash_of(&p);
        if (!known(pictures[i].name, key, &golden)) {
            if (!new_ones++)
                printf("note: no pictures of this driver; if they are right, add to " HASHES ":\n");
            printf("%s %s %016llx\n", pictures[i].name, key, (unsigned long long)hash);
        } else if (hash != golden) {
            printf("%s is another picture; where that was meant, its line in " HASHES " is:\n"
                   "%s %s %016llx\n", pictures[i].name, pictures[i].name, key, (unsigned long long)hash);
            save(&p, pictures[i].name, "");
            bad++;
        }
    }
    assert_int_equal(bad, 0);
}

static void softpipe_draws_the_same(void **state)
{
    static picture a, b, off;
    int bad = 0;
    (void)state;
    for (int i = 0; i < PICTURES; i++) {
        int differ = 0, most = 0;
        draw(i, "llvmpipe", &a);
        draw(i, "softpipe", &b);
        for (int k = 0; k < PIXELS; k++) {
            int worst = 0;
            for (int c = 0; c < 3; c++) {
                int d = abs(a.rgb[3 * k + c] - b.rgb[3 * k + c]);
                worst = d > worst ? d : worst;
            }
            differ += worst > 2;
            most = worst > most ? worst : most;
            memset(off.rgb + 3 * k, worst > 2 ? 255 : 60 * worst, 3);
        }
        printf("%s: %d of %d pixels off by more than 2 / 255, at most by %d\n", pictures[i].name, differ, PIXELS, most);
        if (1000 * differ <= PIXELS) continue;
        save(&a, pictures[i].name, "");
        save(&b, pictures[i].name, "-softpipe");
        save(&off, pictures[i].name, "-diff");
        bad++;
    }
    assert_int_equal(bad, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(llvmpipe_draws_the_golden_pictures),
                                        cmocka_unit_test(softpipe_draws_the_same) };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
