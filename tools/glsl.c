/* glsl - writes every embedded program with every set of its defines and for every promised dialect to a folder, for
   the validator of tools/check-glsl: NAME-SET-DIALECT.STAGE, and beside it .layout, what its uniform blocks must look
   like.

   glsl FOLDER */

#define SHADOWFIELD_IMPLEMENTATION      /* gl_shadowfield.h calls it */
#define GL_BACKEND_IMPLEMENTATION
#define GL_PROGRAMS_IMPLEMENTATION
#define GL_CSM_IMPLEMENTATION
#define GL_SHADOWFIELD_IMPLEMENTATION
#define GL_ENVSHADOW_IMPLEMENTATION
#define GL_GBUFFER_IMPLEMENTATION
#define GL_RSM_IMPLEMENTATION
#define GL_ISM_IMPLEMENTATION
#define GL_WAVELETS_IMPLEMENTATION
#include "../gl_backend/gl_csm.h"
#include "../gl_backend/gl_envshadow.h"
#include "../gl_backend/gl_gbuffer.h"
#include "../gl_backend/gl_ism.h"
#include "../gl_backend/gl_rsm.h"
#include "../gl_backend/gl_wavelets.h"

#include <stdio.h>

static const struct { glbk_dialect dialect; const char *name; } dialects[] = {
    { GLBK_GLSL_330, "330" }, { GLBK_GLSL_300_ES, "300es" }, { GLBK_GLSL_430, "430" }
};

static int write_text(const char *path, const char *text)
{
    FILE *f = fopen(path, "wb");
    int ok = f && fputs(text, f) >= 0;
    if (f && fclose(f) != 0) ok = 0;
    if (!ok) fprintf(stderr, "glsl: cannot write %s\n", path);
    return ok;
}

/* "block.member offset": C's view, which the validator must share. */
#define MEMBER(type, name, count)                                                                                      \
    fprintf(f, "%s.%s %u\n", block, #name, (unsigned)offset), offset += 4 * SIZE_##type * (count);
#define SIZE_mat4 16
#define SIZE_vec4 4
#define SIZE_ivec4 4
#define SIZE_uvec4 4
#define SIZE_float 1
#define SIZE_uint 1
#define BLOCK(name, slot, members)              \
    {                                           \
        const char *block = #name "_block";     \
        size_t offset = 0;                      \
        members(MEMBER)                         \
        ok = ok && offset == sizeof(name);      \
    }

static int write_layout(const char *path)
{
    FILE *f = fopen(path, "wb");
    int ok = f != NULL;
    if (!f) return 0;
    GLBK_BASE_BLOCKS(BLOCK)
    GLBK_GBUFFER_BLOCKS(BLOCK)
    GLBK_CSM_BLOCKS(BLOCK)
    GLBK_SFIELD_BLOCKS(BLOCK)
    GLBK_HAAR_BLOCKS(BLOCK)
    GLBK_ENVSH_BLOCKS(BLOCK)
    GLBK_RSM_BLOCKS(BLOCK)
    GLBK_ISM_BLOCKS(BLOCK)
    return fclose(f) == 0 && ok;
}

static int write_set(const char *folder, const glbk_part *part, const glbk_file *file, const char *defines, int set)
{
    static char text[1 << 20];
    char path[1024];
    const char *name = file->name + 5, *stage = strrchr(name, '.');
    size_t i;

    for (i = 0; i < sizeof dialects / sizeof dialects[0]; i++) {
        int is_compute = strcmp(stage, ".comp") == 0, bits;
        if (is_compute && dialects[i].dialect != GLBK_GLSL_430) continue;
        /* Targets that hold bits are for ES alone. */
        for (bits = 0; bits <= (dialects[i].dialect == GLBK_GLSL_300_ES); bits++) {
            glbk_shader shader = { NULL, defines, file->name, NULL, { part, glbk_gbuffer_part(), glbk_sfield_part() } };
            size_t size = glbk_write_glsl(dialects[i].dialect, bits, &shader, text, sizeof text);
            if (size == 0 || size > sizeof text) {
                fprintf(stderr, "glsl: %s: an unknown file in uses, or bad defines: %s\n", file->name, defines);
                return 0;
            }
            snprintf(path, sizeof path, "%s/%.*s-%d-%s%s%s", folder, (int)(stage - name), name, set, dialects[i].name,
                     bits ? "bits" : "", stage);
            if (!write_text(path, text)) return 0;
        }
    }
    return 1;
}

static int write_part(const char *folder, const glbk_part *part)
{
    uint32_t i;
    for (i = 0; i < part->file_count; i++) {
        const char *s = glbk__file_fact(&part->files[i], GLBK__FILE_SETS);
        int set = 0;
        if (strncmp(part->files[i].name, "prog/", 5) != 0) continue;
        do {
            char defines[256];
            const char *bar = strstr(s, "|");
            snprintf(defines, sizeof defines, "%.*s", (int)(bar ? bar - s : (ptrdiff_t)strlen(s)), s);
            if (!write_set(folder, part, &part->files[i], defines, set++)) return 0;
            s = bar ? bar + 1 : NULL;
        } while (s);
    }
    return 1;
}

int main(int argc, char **argv)
{
    const glbk_part *const parts[] = { glbk__base(), glbk_gbuffer_part(), glbk_csm_part(), glbk_sfield_part(),
                                       glbk_envsh_part(), glbk_rsm_part(), glbk_ism_part(), glbk__wavelets() };
    char path[1024];
    size_t i;

    if (argc != 2) return fprintf(stderr, "usage: glsl FOLDER\n"), 2;
    for (i = 0; i < sizeof parts / sizeof parts[0]; i++)
        if (!write_part(argv[1], parts[i])) return 1;
    snprintf(path, sizeof path, "%s/layout", argv[1]);
    return write_layout(path) ? 0 : 1;
}
