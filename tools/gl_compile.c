/* gl_compile - how long the OpenGL of this machine takes to compile and link every program of gl_backend/, from the
   texts that tools/glsl writes: a line "program stage seconds" each, the longest last, and their sum. A user waits so
   long at the first draw. A driver's cache of programs must be off (NVIDIA: __GL_SHADER_DISK_CACHE=0, Mesa:
   MESA_SHADER_CACHE_DISABLE=true), or the second run measures the cache.

   gl_compile FOLDER [PART-OF-A-NAME]

   Programs of 4.3 need compute shaders; all others are compiled as 3.3. Exit 1: one does not compile. */
#define _POSIX_C_SOURCE 200809L
#include "../examples/common/common.h"
#include "../examples/common/gl_context.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 1000, TEXT = 1 << 20 };

typedef struct row { char name[80]; const char *stage; double seconds; } row;

/* The functions of OpenGL that compile; the backend keeps its own to itself. */
static struct {
    uint32_t (GLBK_CALL *CreateShader)(uint32_t type);
    void     (GLBK_CALL *ShaderSource)(uint32_t shader, int32_t count, const char *const *texts,
                                       const int32_t *lengths);
    void     (GLBK_CALL *CompileShader)(uint32_t shader);
    uint32_t (GLBK_CALL *CreateProgram)(void);
    void     (GLBK_CALL *AttachShader)(uint32_t program, uint32_t shader);
    void     (GLBK_CALL *LinkProgram)(uint32_t program);
    void     (GLBK_CALL *GetProgramiv)(uint32_t program, uint32_t name, int32_t *value);
    void     (GLBK_CALL *GetProgramInfoLog)(uint32_t program, int32_t size, int32_t *length, char *text);
    void     (GLBK_CALL *DeleteShader)(uint32_t shader);
    void     (GLBK_CALL *DeleteProgram)(uint32_t program);
} gl;

static int load(ex_gl *context)
{
#define LOAD(name)                                                      \
    do {                                                                \
        glbk_proc_fn proc = ex_gl_get_proc("gl" #name, context);        \
        if (!proc)                                                      \
            return -1;                                                  \
        memcpy(&gl.name, &proc, sizeof proc);                           \
    } while (0)
    LOAD(CreateShader);
    LOAD(ShaderSource);
    LOAD(CompileShader);
    LOAD(CreateProgram);
    LOAD(AttachShader);
    LOAD(LinkProgram);
    LOAD(GetProgramiv);
    LOAD(GetProgramInfoLog);
    LOAD(DeleteShader);
    LOAD(DeleteProgram);
#undef LOAD
    return 0;
}

/* Attaches the shader whose text stands in that file; returns 0, or -1 where there is no such file. */
static int attach(uint32_t program, uint32_t type, const char *path)
{
    static char text[TEXT];
    const char *texts = text;
    uint32_t shader;
    size_t size;
    FILE *f = fopen(path, "rb");
    if (!f)
        return -1;
    size = fread(text, 1, sizeof text - 1, f);
    fclose(f);
    text[size] = 0;
    shader = gl.CreateShader(type);
    gl.ShaderSource(shader, 1, &texts, NULL);
    gl.CompileShader(shader);
    gl.AttachShader(program, shader);
    gl.DeleteShader(shader);            /* with its program */
    return 0;
}

static int is_linked(const char *name, uint32_t program)
{
    char log[2000] = "";
    int32_t ok = 0;
    gl.GetProgramiv(program, 0x8B82 /* LINK_STATUS */, &ok);
    if (ok)
        return 1;
    gl.GetProgramInfoLog(program, sizeof log, NULL, log);
    fprintf(stderr, "gl_compile: %s: %s\n", name, log);
    return 0;
}

/* Compiles the program of NAME-330.frag, with NAME-330.vert or the vertex shader of screens, or of NAME-430.comp. */
static int compile(const char *folder, row *r)
{
    char path[1400];
    double start = ex_seconds();
    uint32_t program = gl.CreateProgram();
    int ok;
    if (strcmp(r->stage, "compute") == 0) {
        snprintf(path, sizeof path, "%.1200s/%.79s-430.comp", folder, r->name);
        attach(program, 0x91B9 /* COMPUTE_SHADER */, path);
    } else {
        snprintf(path, sizeof path, "%.1200s/%.79s-330.vert", folder, r->name);
        if (attach(program, 0x8B31 /* VERTEX_SHADER */, path) != 0) {
            snprintf(path, sizeof path, "%.1200s/screen-0-330.vert", folder);
            attach(program, 0x8B31, path);
        }
        snprintf(path, sizeof path, "%.1200s/%.79s-330.frag", folder, r->name);
        attach(program, 0x8B30 /* FRAGMENT_SHADER */, path);
    }
    gl.LinkProgram(program);
    ok = is_linked(r->name, program);
    r->seconds = ex_seconds() - start;
    gl.DeleteProgram(program);
    return ok;
}

static int by_seconds(const void *a, const void *b)
{
    const row *x = a, *y = b;
    return (x->seconds > y->seconds) - (x->seconds < y->seconds);
}

/* Lists the programs of a folder; returns how many there are. */
static size_t list(const char *folder, const char *part, int compute, row *rows)
{
    size_t count = 0;
    DIR *dir = opendir(folder);
    for (struct dirent *d; dir && count < MOST && (d = readdir(dir)) != NULL;) {
        const char *end = strstr(d->d_name, "-330.frag"), *kernel = strstr(d->d_name, "-430.comp");
        size_t length;
        if (!end && compute)
            end = kernel;
        if (!end || !strstr(d->d_name, part))
            continue;
        length = (size_t)(end - d->d_name);
        if (length >= sizeof rows->name)
            continue;
        memcpy(rows[count].name, d->d_name, length);
        rows[count].name[length] = 0;
        rows[count++].stage = kernel ? "compute" : "fragment";
    }
    if (dir)
        closedir(dir);
    return count;
}

int main(int argc, char **argv)
{
    static row rows[MOST];
    ex_gl_options options = { EX_GL_HEADLESS, 0, 0, 0, 0, 0, 0, 0, 0, NULL };
    char error[EX_ERROR_SIZE];
    double sum = 0;
    int failed = 0;
    ex_gl *context;
    glbk_desc desc = { 0 };
    glbk_context base;
    if (argc < 2 || argc > 3)
        return fprintf(stderr, "usage: gl_compile FOLDER [PART-OF-A-NAME]\n"), 2;
    context = ex_gl_create(&options, error);
    if (!context)
        return fprintf(stderr, "gl_compile: %s\n", error), 1;
    desc.get_proc_fn = ex_gl_get_proc;
    desc.user = context;
    if (glbk_init(&base, &desc) != GLBK_OK || load(context) != 0)
        return fprintf(stderr, "gl_compile: this OpenGL lacks what the backend needs\n"), 1;
    size_t count = list(argv[1], argc > 2 ? argv[2] : "", base.compute, rows);
    for (size_t i = 0; i < count; i++) {
        failed |= !compile(argv[1], &rows[i]);
        sum += rows[i].seconds;
    }
    qsort(rows, count, sizeof *rows, by_seconds);
    for (size_t i = 0; i < count; i++)
        printf("%-28s %-8s %.3f\n", rows[i].name, rows[i].stage, rows[i].seconds);
    printf("%zu programs by %s: %.1f s\n", count, base.renderer, sum);
    glbk_free(&base);
    ex_gl_free(context);
    return failed || count == 0;
}
