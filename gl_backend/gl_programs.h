/* gl_programs.h - v0.9.0 - programs with the GLSL of gl_*.h, OpenGL 3.3, ES 3.0, WebGL 2 - MIT-0 OR Unlicense

   What it does

   gl_csm.h, gl_shadowfield.h, gl_envshadow.h, gl_rsm.h and gl_ism.h keep their GLSL in themselves. This
   header makes programs of it: from your text and the functions that the text calls it assembles what a
   driver compiles, compiles and links that, and gives textures and uniform blocks their slots. For a renderer
   that compiles its shaders itself it writes the text alone. All headers above include it.

   What it does not do

   - It needs gl_backend.h beside it, which makes the context object, textures, targets and passes, and whose
     conventions, errors and rules about GL's state hold here.
   - It is of no use without a technique. A program that needs gl_backend.h only, with shaders that it links
     itself, leaves this header out and makes its program the one in use after glbk_begin, or gives glbk_begin
     a glbk_program that holds GL's name alone.
   - It has no cache of programs and no include directives: your text names the functions that it uses.

   Quick start

       #define GL_BACKEND_IMPLEMENTATION
       #define GL_PROGRAMS_IMPLEMENTATION
       #include "gl_backend/gl_programs.h"
       #include <stdio.h>
       #include <string.h>

       // With GLFW: return glfwGetProcAddress(name);  with EGL: return eglGetProcAddress(name);
       static glbk_proc_fn get_proc(const char *name, void *user)
       {
           (void)name; (void)user;
           return NULL;                                     // no GL here: init says so below
       }

       int main(void)
       {
           static const char fragment[] =
               "out vec4 color;\n"
               "void main() { color = vec4(gl_FragCoord.xy / 512.0, 0.5, 1.0); }\n";
           glbk_context gl;
           glbk_program program;
           glbk_desc desc;
           glbk_source source;
           glbk_pass pass;
           glbk_result result;

           memset(&desc, 0, sizeof desc);
           desc.get_proc_fn = get_proc;                     // a context is current
           result = glbk_init(&gl, &desc);
           if (result != GLBK_OK) {
               printf("no GL: %s\n", glbk_result_text(result));
               return result != GLBK_ERR_FUNCTION;
           }
           memset(&source, 0, sizeof source);
           source.fragment = fragment;                      // parts and uses: those of a technique
           result = glbk_program_compile(&gl, &source, &program);
           memset(&pass, 0, sizeof pass);
           pass.viewport[2] = pass.viewport[3] = 512;       // of the framebuffer that is bound
           if (result == GLBK_OK) result = glbk_begin(&gl, &pass, &program);
           if (result == GLBK_OK) glbk_draw_screen(&gl);
           printf("%s\n", glbk_result_text(result));
           glbk_program_free(&gl, &program);
           glbk_free(&gl);
           return result != GLBK_OK;
       }

   With functions of a technique: examples/06_csm_gl_minimal.c (07 to 10 for the others). With functions of
   two techniques in one shader: examples/11_sky_bounce_gl_minimal.c. In a program that the renderer links
   itself: examples/13_deferred_gl.c.

   Conventions

     file       a piece of GLSL in a header: a library file (functions) or a program's main
     part       all files of one header, and the slots of what they declare
     base       the part of this header
     set        defines that a program is compiled with: "FILTER=1 COUNT=4"
     slot       number of a texture unit, uniform block, storage buffer or image as the lists of bindings give
                it; the context adds desc.first_unit to those of textures and desc.first_block to those of
                uniform blocks
     table      an array of texels, addressed by one number: a 2D array texture 1024 wide and 1024 high

   How it works

   GLSL is kept without its comments, a text for each file under src/gl_programs and src/gl_*. A program is
   version line, defines, lib/prelude.glsl, the library files that it names, and its own. One text serves 330
   core and 300 es. Names, units and block layouts come from one list for each header that C, GLSL and the
   tests share.

   Floats on ES 3.0 and WebGL 2 are renderable with EXT_color_buffer_float only. Without it a target of format
   GLBK_FORMAT_COLOR holds the bits of floats in integers, and lib/prelude.glsl hides the difference
   (glbk_color).

   Configuration

     GL_PROGRAMS_IMPLEMENTATION   in one source file: compiles the code; another file may have gl_backend.h's

   Memory comes from the allocator of the context's desc, only while a program is compiled.
   Layouts: docs/gpu-layouts.md.  State: docs/gl-state.md.  Licence: end of file. */
/* This include stands outside the guard, because a second inclusion of this file may ask for its
   implementation. */
#include "gl_backend.h"

#ifndef GL_PROGRAMS_H
#define GL_PROGRAMS_H

#if GLBK_VERSION != 900
#error "gl_programs.h and gl_backend.h are of different versions"
#endif
#if defined(GLBK_STATIC) && !defined(GL_PROGRAMS_IMPLEMENTATION)
#error "GLBK_STATIC makes all functions private: GL_PROGRAMS_IMPLEMENTATION belongs into the same file"
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ==== src/gl_programs/api.h ==== */

/* ---- page one: a program of your own, with functions of the library ---- */

struct glbk_source;                 /* your text, and whose functions it calls */
struct glbk_part;                   /* the GLSL of one header, as glbk_csm_part() returns it */

GLBK_DEF glbk_result glbk_program_compile(glbk_context *ctx, const struct glbk_source *source,
                                          glbk_program *out);
/* Compiles and links a program from your text, which has no #version line: the text that the driver gets
   begins with that line and lib/prelude.glsl. Compiling takes milliseconds to seconds: do it before the first
   frame.
   source   is read during the call only
   out      is zeroed on errors; free it with glbk_program_free
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL.
            GLBK_ERR_DESC: not exactly one of fragment and compute is given, or outputs are too many or long.
            GLBK_ERR_NAME: a library file is unknown, or defines do not parse.
            GLBK_ERR_COMPILE, GLBK_ERR_LINK: the log has the driver's words, in which line 2007 is line 7 of
            file 2; the log lists the files, too.
            GLBK_ERR_FEATURE: compute without ctx->compute.
            GLBK_ERR_MISMATCH: two samplers or uniform blocks that the program declares have the same texture
            unit or binding, so that one part needs an offset; or two storage buffers or images have the same
            number, so that each of these parts needs a program of its own. The log has both names.
            GLBK_ERR_LIMIT: an offset leads beyond GLBK_MAX_UNITS, GLBK_MAX_BLOCKS or what the context has
            from first_unit on, or a text is longer than INT32_MAX. GLBK_ERR_ALLOC */

GLBK_DEF void glbk_program_free(glbk_context *ctx, glbk_program *program);
/* Deletes a program and zeroes the struct. NULL and zeroed ones are allowed. */

GLBK_DEF glbk_result glbk_dispatch(glbk_context *ctx, glbk_program *program, uint32_t x, uint32_t y,
                                   uint32_t z);
/* Runs x * y * z groups of a compute program, for which everything is bound, and makes what it wrote visible
   to everything after it.
   x, y, z  each 0 .. 65535, which every context allows
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the program was not created; GLBK_ERR_FEATURE: there is
            no ctx->compute; GLBK_ERR_LOST */

/* ---- structs of page one ---- */

typedef struct glbk_source {
    const char *vertex;             /* main of the vertex shader as text; NULL = a triangle over the whole
                                       screen */
    const char *fragment;           /* main of the fragment shader as text, or NULL with compute */
    const char *compute;            /* main of a compute shader as text, in place of both */
    const char *uses;               /* library files by their bare names, in order, without what they use
                                       themselves; uniform blocks of the library that your text names are
                                       found */
    const char *defines;            /* "FILTER=1 FAST", or NULL; the vertex shader sees them too */
    const char *outputs;            /* names for transform feedback, at most 16 and 511 characters, separated
                                       by blanks, interleaved; or NULL */
    const struct glbk_part *parts[GLBK_MAX_PARTS];  /* whose files it uses: glbk_csm_part(), ...; NULLs are
                                       left out */
    glbk_offset offsets[GLBK_MAX_PARTS];    /* of the slots of each of these parts. What a technique's
                                       glbk_..._bind binds for this program needs the same offset */
} glbk_source;

/* ---- the GLSL of the headers ---- */

typedef struct glbk_file {      /* one file of GLSL, as a header holds it: strings one after the other, each
                                   ended by 0, since tables of pointers would take more than the strings */
    const char *name;           /* "lib/table.glsl", "prog/copy.frag". Private strings follow it: the bare
                                   names of the library files that go before this one, the vertex shader that
                                   a .frag goes with, the define sets that are tested, separated by " | ", and
                                   the uniform block that the file declares and nothing else. Behind them is
                                   what glbk_file_text returns */
} glbk_file;

/* The GLSL of one header. Each header has a function that returns its own: glbk_csm_part for gl_csm.h and so
   on. Nothing is registered anywhere: a program is given the parts whose files it uses, and a linker leaves
   out the GLSL of all others. The base is the GLSL of this header, which every program has. */
typedef struct glbk_part {
    const char      *name;          /* "csm" */
    const glbk_file *files;
    uint32_t         file_count;
    const char      *slots;         /* which slot each name of its GLSL has, "3 glbk_csm_maps": a number, one
                                       blank, the name. Four lists of such strings, each string ended by 0 and
                                       each list by an empty string: textures, uniform blocks, storage
                                       buffers, images. Never NULL: "\0\0\0" has four empty lists */
} glbk_part;

GLBK_DEF const glbk_file *glbk_find_file(const glbk_part *part, const char *name);
/* Returns a file of the part or else of the base by its name ("lib/table.glsl"), NULL if neither has it. It
   needs no context.
   part   NULL = the base's files alone */

GLBK_DEF const char *glbk_file_text(const glbk_file *file);
/* Returns a file's text without comments and idle blanks. It comes in pieces: the others follow the first,
   each ended by 0, and an empty string follows the last.
   file   NULL = NULL is returned */

/* ---- programs that you link yourself ---- */

typedef enum glbk_dialect {
    GLBK_GLSL_DEFAULT,              /* = GLBK_GLSL_330 */
    GLBK_GLSL_330,
    GLBK_GLSL_300_ES,
    GLBK_GLSL_430,
    GLBK_GLSL_COUNT
} glbk_dialect;

typedef struct glbk_shader {        /* one stage of a program */
    const char *uses, *defines;     /* as in glbk_source, or NULL */
    const char *name;               /* the file with its main ("prog/copy.frag", which brings its own uses),
                                       or NULL */
    const char *text;               /* your text, before that file if both are given; or NULL */
    const glbk_part *parts[GLBK_MAX_PARTS];     /* as in glbk_source */
} glbk_shader;

GLBK_DEF size_t glbk_write_glsl(glbk_dialect dialect, int float_bits, const glbk_shader *shader, char *out,
                                size_t bytes);
/* Writes the text that glbk_program_compile gives to the driver for one stage, for a renderer that compiles
   its shaders itself. Returns the bytes that the text needs with its 0, or 0 if a name is unknown or defines
   do not parse. It needs no context, and so has no log.
   float_bits   not 0: GLBK_FORMAT_COLOR targets hold integers, as they do without ctx->float_targets
   out          receives the text, cut to `bytes` bytes and ended by 0; it may be NULL with bytes 0 */

enum { GLBK_SLOT_glbk_user0 = 12, GLBK_SLOT_glbk_user1, GLBK_SLOT_glbk_user2, GLBK_SLOT_glbk_user3 };

GLBK_DEF glbk_result glbk_set_slots(glbk_context *ctx, const glbk_part *part, const glbk_offset *offset,
                                    uint32_t gl_program);
/* Gives the textures and blocks of a program that you linked yourself their slots, as glbk_program_use does
   for the library's: those of the part's and the base's lists that the program declares, and samplers of
   yours that are called glbk_user0 to glbk_user3, which have the slots above. Call it once for each part,
   after linking; the program need not be in use. The slots 12 to 15 are free beside the functions for your
   own shaders; the programs of rsm and ism themselves have textures there.
   part         NULL = the base alone
   offset       moves the part's slots; NULL = not at all. The base's stay where they are
   gl_program   GL's name of a linked program
   Errors       GLBK_ERR_ARGUMENT: ctx is NULL, or gl_program is 0; GLBK_ERR_LIMIT: as glbk_program_compile
                says; GLBK_ERR_MISMATCH: a sampler or block of the part would have the unit or binding of
                another one of the program, whatever gave it to that one; the log has both names. A sampler of
                yours with another name counts if its unit is not 0, GL's default; GLBK_ERR_LOST. Nothing is
                set then
   A sampler or block of a part whose turn is still to come is put out of the way, to the last unit or binding
   that GL has. */

/* ==== src/gl_programs/bindings.h ==== */

/* ---- bindings ----

   Each part (this header, and each technique's) has four lists, empty where it needs none:

     GLBK_part_TEXTURES(X)   X(GLSL type, name, slot)
     GLBK_part_BLOCKS(X)     X(name, slot, MEMBERS), each with a list MEMBERS(X): X(GLSL type, name, count)
     GLBK_part_STORAGE(X)    X(qualifiers, GLSL type, name, slot), an array without size, for compute
     GLBK_part_IMAGES(X)     X(qualifiers, format, GLSL type, name, slot), for compute

   A list may consist of other lists, each named with (X) after it. Slots of textures count from 0 to
   GLBK_UNITS - 1, those of blocks, storage and images to 7, anew in each part. A program that uses several
   parts gives each a glbk_offset, so that they do not meet; the base is one too, whose slots stay. From the
   lists come GLBK_SLOT_name, the C struct of each block, and the library file "part_bindings". Members are
   read as block.member. Their layout is std140 and that of C at the same time: members are mat4, vec4, ivec4,
   uvec4, arrays of these, and float and uint, four of which fill the place of a vec4. tools/check-glsl
   compares both layouts. */

#define GLBK_BASE_TEXTURES(X) X(glbk_color_sampler, glbk_source, 0)
#define GLBK_BASE_BLOCKS(X)
#define GLBK_BASE_STORAGE(X)
#define GLBK_BASE_IMAGES(X)

#define GLBK__SLOT_TEXTURE(type, name, slot) GLBK_SLOT_##name = slot,
#define GLBK__SLOT_BLOCK(name, slot, members) GLBK_SLOT_##name = slot,
#define GLBK__SLOT_STORAGE(qualifiers, type, name, slot) GLBK_SLOT_##name = slot,
#define GLBK__SLOT_IMAGE(qualifiers, format, type, name, slot) GLBK_SLOT_##name = slot,
#define GLBK__MEMBER_mat4(name, count) float name[16 * (count)];
#define GLBK__MEMBER_vec4(name, count) float name[4 * (count)];
#define GLBK__MEMBER_ivec4(name, count) int32_t name[4 * (count)];
#define GLBK__MEMBER_uvec4(name, count) uint32_t name[4 * (count)];
#define GLBK__MEMBER_float(name, count) float name;     /* count is 1: std140 would spread an array */
#define GLBK__MEMBER_uint(name, count) uint32_t name;
#define GLBK__MEMBER(type, name, count) GLBK__MEMBER_##type(name, count)
#define GLBK__STRUCT(name, slot, members) typedef struct name { members(GLBK__MEMBER) } name;
#define GLBK__PART(PART)                        \
    enum {                                      \
        GLBK_##PART##_TEXTURES(GLBK__SLOT_TEXTURE)  \
        GLBK_##PART##_BLOCKS(GLBK__SLOT_BLOCK)      \
        GLBK_##PART##_STORAGE(GLBK__SLOT_STORAGE)   \
        GLBK_##PART##_IMAGES(GLBK__SLOT_IMAGE)      \
        GLBK__LAST_SLOT_##PART                  \
    };                                          \
    GLBK_##PART##_BLOCKS(GLBK__STRUCT)
GLBK__PART(BASE)

/* ==== src/gl_programs/inside.h ==== */

/* ---- for the techniques' headers: not for you, may change without notice ----

   Their implementations may stand in other files than this header's, hence no static functions: GLBK__DEF is
   GLBK_DEF for them. */

/* GLBK__TIGHT stands behind the name of a file of GLSL: gcc would begin each at a multiple of 32 bytes. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define GLBK__TIGHT __attribute__((aligned(1)))
#else
#define GLBK__TIGHT
#endif

/* Lists of slots as glbk_part has them. */
#define GLBK__TEXTURE_ENTRY(type, name, slot) #slot " " #name "\0"
#define GLBK__BLOCK_ENTRY(name, slot, members) #slot " " #name "_block\0"
#define GLBK__STORAGE_ENTRY(qualifiers, type, name, slot) #slot " " #name "_storage\0"
#define GLBK__IMAGE_ENTRY(qualifiers, format, type, name, slot) #slot " " #name "\0"
#define GLBK__LISTS_CODE(part, PART)                                                               \
    static const char glbk__##part##_slots[] =                                                     \
        GLBK_##PART##_TEXTURES(GLBK__TEXTURE_ENTRY) "\0" GLBK_##PART##_BLOCKS(GLBK__BLOCK_ENTRY)   \
        "\0" GLBK_##PART##_STORAGE(GLBK__STORAGE_ENTRY) "\0"                                       \
        GLBK_##PART##_IMAGES(GLBK__IMAGE_ENTRY) "\0";
#define GLBK__PART_DATA(part)                                                                      \
    static const glbk_part glbk__##part##_part = {                                                 \
        #part, glbk__##part##_files, sizeof glbk__##part##_files / sizeof glbk__##part##_files[0], \
        glbk__##part##_slots                                                                       \
    };
#define GLBK__PART_CODE(part, PART)                                                                \
    GLBK__LISTS_CODE(part, PART)                                                                   \
    GLBK__PART_DATA(part)                                                                          \
    GLBK_DEF const glbk_part *glbk_##part##_part(void) { return &glbk__##part##_part; }

/* Returns the base, which the public functions take for a part that is NULL. */
GLBK__DEF const glbk_part *glbk__base(void);

/* Returns *offset, or zeros for NULL. */
GLBK__DEF glbk_offset glbk__offset(const glbk_offset *offset);

/* Compiles and links a program of the library.
   part     has it; NULL = the base
   others   more parts whose library files it uses, NULLs left out; or NULL
   texts    of a user, before the vertex and the fragment shader; NULL, or one of them NULL = none
   name     is that of its last stage: "copy.frag", "csm_query.comp"
   defines  one of its sets, or NULL = none
   Errors   those of glbk_program_compile; GLBK_ERR_NAME where the part has no such file */
GLBK__DEF glbk_result glbk__program_create(glbk_context *ctx, const glbk_part *part, const char *name,
                                           const char *defines, glbk_program *out);
GLBK__DEF glbk_result glbk__program_of_parts(glbk_context *ctx, const glbk_part *part,
                                             const glbk_part *const others[2], const char *name,
                                             const char *defines, const char *const texts[2],
                                             glbk_program *out);

/* Returns one of the strings that follow the name of a file. */
enum { GLBK__FILE_USES = 1, GLBK__FILE_WITH, GLBK__FILE_SETS, GLBK__FILE_BLOCK, GLBK__FILE_TEXT };
GLBK__DEF const char *glbk__file_fact(const glbk_file *file, int which);

/* Text that is counted in `used` and written as far as there is room: glbk__append adds so many characters,
   glbk__append_text a string, glbk__append_number its digits, glbk__append_file a file of GLSL.
   glbk__begin_line begins a line for the log, which is always ended by 0. */
enum { GLBK__LINE_ROOM = 256 };     /* characters; of longer lines the end is cut off */
typedef struct glbk__sink {
    char  *out;
    size_t bytes, used;
} glbk__sink;
GLBK__DEF void glbk__append(glbk__sink *sink, const char *text, size_t length);
GLBK__DEF void glbk__append_text(glbk__sink *sink, const char *text);
GLBK__DEF void glbk__append_number(glbk__sink *sink, uint64_t number);
GLBK__DEF void glbk__append_file(glbk__sink *sink, const glbk_file *file);
GLBK__DEF void glbk__begin_line(glbk__sink *sink, char out[GLBK__LINE_ROOM]);

/* Logs "FUNCTION: MESH: index 2 of triangle 17 is 90, but the mesh has 80 vertices" and returns the result;
   position counts indices from 0. */
GLBK__DEF glbk_result glbk__refuse_index(const glbk_context *ctx, glbk_result result, const char *function,
                                         const char *mesh, size_t position, size_t index,
                                         size_t vertex_count);

/* Gives a uniform block all its values for the draws that follow, and binds it to its slot. */
GLBK__DEF glbk_result glbk__put_block(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer,
                                      const void *values);

/* Makes a texture and a target of it, with `depth` if that is not NULL. The target is a technique's own, as
   those of glbk__target_create are. */
GLBK__DEF glbk_result glbk__canvas(glbk_context *ctx, glbk_format format, uint32_t width, uint32_t height,
                                   const glbk_texture *depth, glbk_texture *texture, glbk_target *target);

/* Makes what a technique sums light in: one canvas, or two where passes draw from one into the other, which
   is so without compute. What there is of them goes when an error comes. */
GLBK__DEF glbk_result glbk__sums_create(glbk_context *ctx, int compute, uint32_t width, uint32_t height,
                                        glbk_texture sums[2], glbk_target targets[2]);
GLBK__DEF void glbk__sums_free(glbk_context *ctx, glbk_texture sums[2], glbk_target targets[2]);

/* A table is an array texture that lib/table.glsl reads by one number: texel i stands at (i & 1023, i >> 10 &
   1023, i >> 20). texels: count of them, 1 .. ctx->max_layers * 2^20, in any format but the depth formats, or
   NULL = undefined. On the GPU a table takes count rounded up to rows of 1024, above 2^20 texels to layers of
   2^20; beyond ctx->max_layers of them it is GLBK_ERR_LIMIT. Updating sets count texels from number first on,
   as a call of a frame. */
GLBK__DEF glbk_result glbk__table_create(glbk_context *ctx, glbk_format format, const void *texels,
                                         size_t count, glbk_texture *out);
GLBK__DEF glbk_result glbk__table_update(glbk_context *ctx, const glbk_texture *table, size_t first,
                                         size_t count, const void *texels);

/* ==== src/gl_programs/begin.h ==== */

/* ---- end of the declarations ---- */

#ifdef __cplusplus
}
#endif

#endif /* GL_PROGRAMS_H */

/* ==== implementation ==================================================================================== */

#if defined(GL_PROGRAMS_IMPLEMENTATION) && !defined(GL_PROGRAMS_IMPLEMENTED)
#define GL_PROGRAMS_IMPLEMENTED

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ==== src/shared/mem.h ==== */

/* unit mem: checked sizes, and the caller's allocator with malloc and free as its default */

typedef struct glbk_prog__allocator {
    void *(*alloc_fn)(size_t size, void *user);
    void (*free_fn)(void *memory, void *user);
    void *user;
} glbk_prog__allocator;

static inline void *glbk_prog__default_alloc(size_t size, void *user)
{
    (void)user;
    return malloc(size);
}

static inline void glbk_prog__default_free(void *memory, void *user)
{
    (void)user;
    free(memory);
}

static inline glbk_prog__allocator glbk_prog__allocator_make(void *(*alloc_fn)(size_t, void *),
                                           void (*free_fn)(void *, void *), void *user)
{
    glbk_prog__allocator a;
    a.alloc_fn = alloc_fn && free_fn ? alloc_fn : glbk_prog__default_alloc;
    a.free_fn = alloc_fn && free_fn ? free_fn : glbk_prog__default_free;
    a.user = user;
    return a;
}

/* Returns NULL if there is no memory, and also if the size is 0, so that a caller has one thing to test. */
static inline void *glbk_prog__alloc(const glbk_prog__allocator *a, size_t size)
{
    return size ? a->alloc_fn(size, a->user) : NULL;
}

static inline void glbk_prog__free(const glbk_prog__allocator *a, void *memory)
{
    if (memory) a->free_fn(memory, a->user);
}

/* ==== src/shared/gl_memory.h ==== */

/* unit gl_memory, needs mem: the allocator of a glbk_context (gl_backend.h) */

static inline glbk_prog__allocator glbk_prog__memory(const glbk_context *ctx)
{
    const glbk_allocator *a = &ctx->system.allocator;
    return glbk_prog__allocator_make(a->alloc_fn, a->free_fn, a->user);
}

/* ==== GLSL of src/gl_programs ==== */


static const struct { char facts[27];
    char s0[42]; char end; } glbk__glsl_lib_base_bindings_glsl GLBK__TIGHT = {
    "lib/base_bindings.glsl\0" "" "\0" "" "\0"
    "" "\0" "",
    "\nuniform glbk_color_sampler glbk_source;\n", 0
};

static const struct { char facts[27];
    char s0[338]; char end; } glbk__glsl_lib_mesh_fragment_glsl GLBK__TIGHT = {
    "lib/mesh_fragment.glsl\0" "" "\0" "" "\0"
    "" "\0" "",
    "\n\n#ifdef GLBK_OWN_FRAGMENT\n"
    "bool glbk_fragment(vec2 uv,inout vec4 color);\n"
    "#else\n"
    "bool glbk_fragment(vec2 uv,inout vec4 color){return true;}\n"
    "#endif\n"
    "#ifdef GLBK_PLACE\n"
    "#ifdef GLBK_OWN_FRAGMENT\n"
    "in vec2 glbk_uv;\n"
    "#else\n"
    "const vec2 glbk_uv=vec2(.0);\n"
    "#endif\n"
    "\nbool glbk_is_hole()\n"
    "{\n"
    "vec4 color=vec4(1.);\n"
    "return!glbk_fragment(glbk_uv,color);\n"
    "}\n"
    "#endif\n", 0
};

static const struct { char facts[25];
    char s0[1217]; char end; } glbk__glsl_lib_mesh_vertex_glsl GLBK__TIGHT = {
    "lib/mesh_vertex.glsl\0" "" "\0" "" "\0"
    "" "\0" "",
    "\n\n\n#ifdef GLBK_OWN_VERTEX\n"
    "void glbk_vertex(out vec3 position,out vec3 normal,out vec2 uv,out vec4 tangent);\n"
    "#else\n"
    "#ifndef GBUFFER_POSITION\n"
    "#define GBUFFER_POSITION 0\n"
    "#define GBUFFER_NORMAL 1\n"
    "#define GBUFFER_UV 2\n"
    "#define GBUFFER_TANGENT 3\n"
    "#endif\n"
    "layout(location=GBUFFER_POSITION)in vec3 glbk_in_position;\n"
    "#if GBUFFER_NORMAL >= 0 && !defined(GLBK_PLACE)\n"
    "layout(location=GBUFFER_NORMAL)in vec3 glbk_in_normal;\n"
    "#else\n"
    "const vec3 glbk_in_normal=vec3(.0);\n"
    "#endif\n"
    "#if GBUFFER_UV >= 0 && (!defined(GLBK_PLACE) || defined(GLBK_OWN_FRAGMENT))\n"
    "layout(location=GBUFFER_UV)in vec2 glbk_in_uv;\n"
    "#else\n"
    "const vec2 glbk_in_uv=vec2(.0);\n"
    "#endif\n"
    "#if GBUFFER_TANGENT >= 0 && !defined(GLBK_PLACE)\n"
    "layout(location=GBUFFER_TANGENT)in vec4 glbk_in_tangent;\n"
    "#else\n"
    "const vec4 glbk_in_tangent=vec4(.0);\n"
    "#endif\n"
    "\nvoid glbk_vertex(out vec3 position,out vec3 normal,out vec2 uv,out vec4 tangent)\n"
    "{\n"
    "position=glbk_in_position;\n"
    "normal=glbk_in_normal;\n"
    "uv=glbk_in_uv;\n"
    "tangent=glbk_in_tangent;\n"
    "}\n"
    "#endif\n"
    "#ifdef GLBK_PLACE\n"
    "#ifdef GLBK_OWN_FRAGMENT\n"
    "out vec2 glbk_uv;\n"
    "#endif\n"
    "\n\nvec3 glbk_vertex_place()\n"
    "{\n"
    "vec3 position,normal;\n"
    "vec2 uv;\n"
    "vec4 tangent;\n"
    "glbk_vertex(position,normal,uv,tangent);\n"
    "#ifdef GLBK_OWN_FRAGMENT\n"
    "glbk_uv=uv;\n"
    "#endif\n"
    "return position;\n"
    "}\n"
    "#endif\n", 0
};

static const struct { char facts[21];
    char s0[844]; char end; } glbk__glsl_lib_prelude_glsl GLBK__TIGHT = {
    "lib/prelude.glsl\0" "" "\0" "" "\0"
    "" "\0" "",
    "\n#ifdef GL_ES\n"
    "precision highp float;\n"
    "precision highp int;\n"
    "precision highp sampler2D;\n"
    "precision highp sampler3D;\n"
    "precision highp samplerCube;\n"
    "precision highp sampler2DArray;\n"
    "precision highp sampler2DShadow;\n"
    "precision highp sampler2DArrayShadow;\n"
    "precision highp isampler2D;\n"
    "precision highp isampler2DArray;\n"
    "precision highp usampler2D;\n"
    "precision highp usampler2DArray;\n"
    "#endif\n"
    "\n#ifndef GLBK_FLOAT_BITS\n"
    "#error \"GLBK_FLOAT_BITS: 1 where GLBK_FORMAT_COLOR is RGBA32UI, else 0\"\n"
    "#endif\n"
    "\n\n\n#if GLBK_FLOAT_BITS\n"
    "#define glbk_color uvec4\n"
    "#define glbk_color_sampler usampler2D\n"
    "uvec4 glbk_pack(vec4 color){return floatBitsToUint(color);}\n"
    "vec4 glbk_unpack(uvec4 bits){return uintBitsToFloat(bits);}\n"
    "#else\n"
    "#define glbk_color vec4\n"
    "#define glbk_color_sampler sampler2D\n"
    "vec4 glbk_pack(vec4 color){return color;}\n"
    "vec4 glbk_unpack(vec4 color){return color;}\n"
    "#endif\n", 0
};

static const struct { char facts[19];
    char s0[82]; char end; } glbk__glsl_lib_table_glsl GLBK__TIGHT = {
    "lib/table.glsl\0" "" "\0" "" "\0"
    "" "\0" "",
    "\nivec3 glbk_table_at(uint i)\n"
    "{\n"
    "return ivec3(uvec3(i&1023u,i>>10&1023u,i>>20));\n"
    "}\n", 0
};

static const struct { char facts[55];
    char s0[307]; char end; } glbk__glsl_prog_copy_frag GLBK__TIGHT = {
    "prog/copy.frag\0" "base_bindings" "\0" "" "\0"
    "TO_COLOR=0 | TO_COLOR=1" "\0" "",
    "\n\n\n\n\n#ifndef TO_COLOR\n"
    "#define TO_COLOR 0\n"
    "#endif\n"
    "#if TO_COLOR\n"
    "layout(location=0)out vec4 result;\n"
    "#else\n"
    "layout(location=0)out glbk_color result;\n"
    "#endif\n"
    "\nvoid main()\n"
    "{\n"
    "vec4 color=glbk_unpack(texelFetch(glbk_source,ivec2(gl_FragCoord.xy),0));\n"
    "#if TO_COLOR\n"
    "result=color;\n"
    "#else\n"
    "result=glbk_pack(color);\n"
    "#endif\n"
    "}\n", 0
};

static const struct { char facts[21];
    char s0[87]; char end; } glbk__glsl_prog_screen_vert GLBK__TIGHT = {
    "prog/screen.vert\0" "" "\0" "" "\0"
    "" "\0" "",
    "\nvoid main()\n"
    "{\n"
    "gl_Position=vec4(gl_VertexID==1?3.:-1.,gl_VertexID==2?3.:-1.,.0,1.);\n"
    "}\n", 0
};

static const glbk_file glbk__base_files[] = {
    { (const char *)&glbk__glsl_lib_base_bindings_glsl },
    { (const char *)&glbk__glsl_lib_mesh_fragment_glsl },
    { (const char *)&glbk__glsl_lib_mesh_vertex_glsl },
    { (const char *)&glbk__glsl_lib_prelude_glsl },
    { (const char *)&glbk__glsl_lib_table_glsl },
    { (const char *)&glbk__glsl_prog_copy_frag },
    { (const char *)&glbk__glsl_prog_screen_vert }
};


/* ==== src/gl_programs/part.h ==== */

/* ---- part: the base's own GLSL, textures and blocks ---- */

GLBK__LISTS_CODE(base, BASE)
GLBK__PART_DATA(base)

GLBK__DEF const glbk_part *glbk__base(void) { return &glbk__base_part; }

/* ==== src/gl_programs/assembly.h ==== */

/* ---- glsl: the text of a program ---- */

enum { GLBK__MAX_FILES = 32 };

/* Returns whether a name is the three parts together, as "lib/table.glsl" is "lib/", "table" and ".glsl";
   length counts the middle. */
static int glbk__is_named(const char *name, const char *before, const char *middle, size_t length,
                          const char *after)
{
    size_t n = strlen(before);
    return strncmp(name, before, n) == 0 && strncmp(name + n, middle, length) == 0 &&
           strcmp(name + n + length, after) == 0;
}

static const glbk_file *glbk__find_in(const glbk_part *part, const char *before, const char *middle,
                                      size_t length, const char *after)
{
    uint32_t i;
    for (i = 0; i < part->file_count; i++)
        if (glbk__is_named(part->files[i].name, before, middle, length, after)) return &part->files[i];
    return NULL;
}

GLBK__DEF const char *glbk__file_fact(const glbk_file *file, int which)
{
    const char *s = file->name;
    while (which--) s += strlen(s) + 1;
    return s;
}

GLBK_DEF const char *glbk_file_text(const glbk_file *file)
{
    return file ? glbk__file_fact(file, GLBK__FILE_TEXT) : NULL;
}

GLBK_DEF const glbk_file *glbk_find_file(const glbk_part *part, const char *name)
{
    const glbk_file *file = part && name ? glbk__find_in(part, "", name, strlen(name), "") : NULL;
    return file || !name ? file : glbk__find_in(glbk__base(), "", name, strlen(name), "");
}

/* Library files in the order in which they are compiled, and the parts in which they are looked for: the
   shader's, then the base. */
typedef struct glbk__list {
    const glbk_file *file[GLBK__MAX_FILES];
    uint32_t         count;
    const glbk_part *parts[GLBK_MAX_PARTS + 1];
    const char      *unknown;       /* the first name that no part has; NULL = none, or too many files */
    size_t           unknown_length;
} glbk__list;

static const glbk_file *glbk__find_listed(const glbk__list *list, const char *before, const char *middle,
                                          size_t length, const char *after)
{
    const glbk_file *file = NULL;
    uint32_t i;
    for (i = 0; i <= GLBK_MAX_PARTS && !file; i++)
        if (list->parts[i]) file = glbk__find_in(list->parts[i], before, middle, length, after);
    return file;
}

/* Moves *s to the next word of a list that is separated by blanks. Returns the word's length, 0 at the end.
 */
static size_t glbk__next_word(const char **s)
{
    size_t length = 0;
    while (**s == ' ') (*s)++;
    while ((*s)[length] && (*s)[length] != ' ') length++;
    return length;
}

static int glbk__is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
static int glbk__is_name(char c) { return glbk__is_letter(c) || (c >= '0' && c <= '9'); }

static int glbk__gather(glbk__list *list, const char *names);

/* Adds a library file after the files that it uses itself, unless it is in the list. The recursion is as deep
   as the embedded files make it (backend_test.c walks all). Returns 0 for an unknown file, or too many. */
static int glbk__gather_file(glbk__list *list, const glbk_file *file)
{
    uint32_t i;
    if (!file || !glbk__gather(list, glbk__file_fact(file, GLBK__FILE_USES))) return 0;
    for (i = 0; i < list->count && list->file[i] != file; i++) {}
    if (i < list->count) return 1;
    if (list->count == GLBK__MAX_FILES) return 0;
    list->file[list->count++] = file;
    return 1;
}

/* Adds the library files named. Returns 0 if one is unknown, which the list then keeps. */
static int glbk__gather(glbk__list *list, const char *names)
{
    size_t length;
    for (; (length = glbk__next_word(&names)) != 0; names += length) {
        const glbk_file *file = glbk__find_listed(list, "lib/", names, length, ".glsl");
        if (!file && !list->unknown) {
            list->unknown = names;
            list->unknown_length = length;
        }
        if (!glbk__gather_file(list, file)) return 0;
    }
    return 1;
}

/* Adds the uniform blocks that a text names. No others are declared, since a block that is declared needs a
   buffer whether it is read or not (std140; WebGL 2 refuses to draw). Returns 0 as glbk__gather_file does. */
static int glbk__gather_blocks(glbk__list *list, const glbk_part *part, const char *text)
{
    uint32_t i;
    for (i = 0; i < part->file_count; i++) {
        const char *name = glbk__file_fact(&part->files[i], GLBK__FILE_BLOCK), *at = text;
        size_t length = strlen(name);
        if (!length) continue;
        while ((at = strstr(at, "glbk_")) != NULL &&
               (strncmp(at, name, length) != 0 || glbk__is_name(at[length])))
            at++;
        if (at && !glbk__gather_file(list, &part->files[i])) return 0;
    }
    return 1;
}

/* Gathers the files before a shader's own text, and writes its main file, or NULL if it has none. Returns 0
   if a name is unknown. */
static int glbk__gather_all(glbk__list *list, const glbk_shader *shader, const glbk_file **main_file)
{
    uint32_t i;
    int known;
    list->count = 0;
    list->unknown = NULL;
    list->unknown_length = 0;
    memcpy(list->parts, shader->parts, sizeof shader->parts);
    list->parts[GLBK_MAX_PARTS] = glbk__base();
    *main_file = shader->name ? glbk__find_listed(list, "", shader->name, strlen(shader->name), "") : NULL;
    if (shader->name && !*main_file) {
        list->unknown = shader->name;
        list->unknown_length = strlen(shader->name);
    }
    known = (!shader->name || *main_file) && glbk__gather(list, "prelude") &&
            glbk__gather(list, shader->uses ? shader->uses : "") &&
            glbk__gather(list, *main_file ? glbk__file_fact(*main_file, GLBK__FILE_USES) : "");
    for (i = 0; i <= GLBK_MAX_PARTS && known && shader->text; i++)
        if (list->parts[i]) known = glbk__gather_blocks(list, list->parts[i], shader->text);
    return known;
}

GLBK__DEF void glbk__append(glbk__sink *sink, const char *text, size_t length)
{
    size_t room = sink->bytes > sink->used + 1 ? sink->bytes - 1 - sink->used : 0;
    if (room > length) room = length;
    if (room) memcpy(sink->out + sink->used, text, room);
    sink->used += length;
}

GLBK__DEF void glbk__append_text(glbk__sink *sink, const char *text)
{
    glbk__append(sink, text, strlen(text));
}

GLBK__DEF void glbk__append_number(glbk__sink *sink, uint64_t number)
{
    char digits[24];
    size_t at = sizeof digits;
    do digits[--at] = (char)('0' + number % 10);
    while ((number /= 10) != 0);
    glbk__append(sink, digits + at, sizeof digits - at);
}

GLBK__DEF void glbk__begin_line(glbk__sink *sink, char out[GLBK__LINE_ROOM])
{
    memset(out, 0, GLBK__LINE_ROOM);
    sink->out = out;
    sink->bytes = GLBK__LINE_ROOM;
    sink->used = 0;
}

/* Appends "#line n001 n", so that line 4 of file 3 is line 3004 in the driver's messages. The number alone
   would do, but Mesa's messages leave it out. */
static void glbk__append_line(glbk__sink *sink, uint32_t n)
{
    glbk__append_text(sink, "#line ");
    glbk__append_number(sink, n);
    glbk__append_text(sink, "001 ");
    glbk__append_number(sink, n);
    glbk__append_text(sink, "\n");
}

GLBK__DEF void glbk__append_file(glbk__sink *sink, const glbk_file *file)
{
    const char *s;
    for (s = glbk_file_text(file); *s; s += strlen(s) + 1) glbk__append_text(sink, s);
}

static int glbk__is_value(char c) { return glbk__is_name(c) || c == '.' || c == '-'; }

/* Appends defines: "A=1 B" becomes "#define A 1", "#define B 1". Returns 0 if they do not parse. */
static int glbk__append_defines(glbk__sink *sink, const char *defines)
{
    size_t length;
    for (; (length = glbk__next_word(&defines)) != 0; defines += length) {
        size_t name = 0, i;
        while (name < length && defines[name] != '=') name++;
        if (!name || !glbk__is_letter(defines[0])) return 0;
        for (i = 0; i < length; i++)
            if (i != name && !glbk__is_value(defines[i])) return 0;
        glbk__append_text(sink, "#define ");
        glbk__append(sink, defines, name);
        glbk__append_text(sink, " ");
        if (name < length) glbk__append(sink, defines + name + 1, length - name - 1);
        else glbk__append_text(sink, "1");
        glbk__append_text(sink, "\n");
    }
    return 1;
}

GLBK_DEF size_t glbk_write_glsl(glbk_dialect dialect, int float_bits, const glbk_shader *shader, char *out,
                                size_t bytes)
{
    static const char versions[][19] = { "#version 330 core\n", "#version 330 core\n", "#version 300 es\n",
                                         "#version 430 core\n" };
    const glbk_file *main_file;
    glbk__list list;
    glbk__sink sink;
    uint32_t i;

    if ((unsigned)dialect >= GLBK_GLSL_COUNT || !shader || (!out && bytes)) return 0;
    if (!glbk__gather_all(&list, shader, &main_file)) return 0;
    sink.out = out;
    sink.bytes = bytes;
    sink.used = 0;
    glbk__append_text(&sink, versions[dialect]);
    glbk__append_text(&sink, float_bits ? "#define GLBK_FLOAT_BITS 1\n" : "#define GLBK_FLOAT_BITS 0\n");
    if (!glbk__append_defines(&sink, shader->defines ? shader->defines : "")) return 0;
    for (i = 0; i < list.count; i++) {
        glbk__append_line(&sink, i + 1);
        glbk__append_file(&sink, list.file[i]);
    }
    /* What a text declares must stand before main: Firefox writes zeros to varyings there. */
    if (main_file && shader->text) {
        glbk__append_line(&sink, list.count + 2);
        glbk__append_text(&sink, shader->text);
        glbk__append_text(&sink, "\n");
    }
    glbk__append_line(&sink, list.count + 1);
    if (main_file) glbk__append_file(&sink, main_file);
    else if (shader->text) glbk__append_text(&sink, shader->text);
    if (bytes) out[sink.used < bytes ? sink.used : bytes - 1] = 0;
    return sink.used + 1;
}

/* ==== src/gl_programs/slots.h ==== */

/* ---- slots: which unit or binding each texture and block of a program has ---- */

enum {
    GLBK__ACTIVE_UNIFORMS = 0x8B86, GLBK__CURRENT_PROGRAM = 0x8B8D, GLBK__ACTIVE_UNIFORM_BLOCKS = 0x8A36,
    GLBK__UNIFORM_BLOCK_BINDING = 0x8A3F, GLBK__SHADER_STORAGE_BLOCK = 0x92E6,
    GLBK__MAX_COMBINED_TEXTURE_IMAGE_UNITS = 0x8B4D, GLBK__MAX_UNIFORM_BUFFER_BINDINGS = 0x8A2F
};
#define GLBK__INVALID_INDEX 0xFFFFFFFFu

GLBK__DEF glbk_offset glbk__offset(const glbk_offset *offset)
{
    const glbk_offset none = { 0, 0 };
    return offset ? *offset : none;
}

/* The list of a user's own samplers: GLBK_SLOT_glbk_user0 to GLBK_SLOT_glbk_user3. */
static const char glbk__user_slots[] = "12 glbk_user0\0" "13 glbk_user1\0" "14 glbk_user2\0"
                                       "15 glbk_user3\0";

/* ---- places: which name has which unit or binding ---- */

/* The kinds of places. Slots of units and blocks count from the context's first ones on and move with a
   part's offset; GLSL says the numbers of the others. */
enum { GLBK__PLACE_UNIT, GLBK__PLACE_BLOCK, GLBK__PLACE_STORAGE, GLBK__PLACE_IMAGE, GLBK__PLACE_COUNT };

/* Returns a part's list of the slots of one kind of places. */
static const char *glbk__slots_of(const glbk_part *part, int kind)
{
    const char *s = part->slots;
    for (; kind; kind--, s++)
        while (*s) s += strlen(s) + 1;
    return s;
}

/* Moves *list, of strings such as "3 glbk_csm_maps", behind its first string, and writes the slot that this
   one has. Returns the name in it, NULL at the end of the list. */
static const char *glbk__next_slot(const char **list, uint32_t *slot)
{
    const char *s = *list;
    if (!*s) return NULL;
    for (*slot = 0; *s != ' '; s++) *slot = 10 * *slot + (uint32_t)(*s - '0');
    *list = s + strlen(s) + 1;
    return s + 1;
}

/* The names that hold the places of a program, of those that it declares. */
typedef struct glbk__holders {
    const char *names[GLBK__PLACE_COUNT][GLBK_MAX_UNITS];
    const char *function;           /* the public function that looks */
    uint32_t    gl_program;
} glbk__holders;

static uint32_t glbk__place_count(const glbk_context *ctx, int kind)
{
    if (kind == GLBK__PLACE_UNIT) return ctx->unit_count;
    return kind == GLBK__PLACE_BLOCK ? ctx->block_count : GLBK_BLOCKS;
}

/* Returns the number that GL knows the first place of a kind by. */
static uint32_t glbk__first_place(const glbk_context *ctx, int kind)
{
    if (kind == GLBK__PLACE_UNIT) return ctx->first_unit;
    return kind == GLBK__PLACE_BLOCK ? ctx->first_block : 0;
}

static int glbk__declares(const glbk_context *ctx, uint32_t gl_program, const char *name, int kind)
{
    if (kind == GLBK__PLACE_BLOCK)
        return ctx->gl.GetUniformBlockIndex(gl_program, name) != GLBK__INVALID_INDEX;
    if (kind == GLBK__PLACE_STORAGE)
        return ctx->gl.GetProgramResourceIndex(gl_program, GLBK__SHADER_STORAGE_BLOCK, name) !=
               GLBK__INVALID_INDEX;
    return ctx->gl.GetUniformLocation(gl_program, name) >= 0;
}

/* Logs "FUNCTION: A and B both have texture unit 3: give one part an offset". place is GL's number. */
static glbk_result glbk__refuse_place(const glbk_context *ctx, const glbk__holders *h, const char *first,
                                      const char *second, uint32_t place, int kind)
{
    static const char texts[][42] = { " both have texture unit ", " both have the binding of uniform blocks ",
                                      " both have storage buffer ", " both have image " };
    char line[GLBK__LINE_ROOM];
    glbk__sink sink;
    glbk__begin_line(&sink, line);
    glbk__append_text(&sink, "and ");
    glbk__append_text(&sink, second);
    glbk__append_text(&sink, texts[kind]);
    glbk__append_number(&sink, place);
    glbk__append_text(&sink, kind < GLBK__PLACE_STORAGE ? ": give one part an offset"
                                                        : ": give each part a program of its own");
    return glbk__refuse(ctx, GLBK_ERR_MISMATCH, h->function, first, line);
}

/* Gives the declared names of one list their places, which are moved by `offset`. */
static glbk_result glbk__take_places(const glbk_context *ctx, const char *list, uint32_t offset, int kind,
                                     glbk__holders *h)
{
    const uint32_t count = glbk__place_count(ctx, kind);
    const char **names = h->names[kind], *name;
    uint32_t slot;
    while ((name = glbk__next_slot(&list, &slot)) != NULL) {
        if (!glbk__declares(ctx, h->gl_program, name, kind)) continue;
        if (offset >= count || slot >= count - offset)
            return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, h->function, name, (double)offset + slot, 0,
                                      (double)count - 1);
        if (names[offset + slot])
            return glbk__refuse_place(ctx, h, names[offset + slot], name,
                                      glbk__first_place(ctx, kind) + offset + slot, kind);
        names[offset + slot] = name;
    }
    return GLBK_OK;
}

static glbk_result glbk__take_part(const glbk_context *ctx, const glbk_part *part, const glbk_offset *offset,
                                   glbk__holders *h)
{
    const glbk_offset at = glbk__offset(offset);
    const int kinds = ctx->compute ? GLBK__PLACE_COUNT : GLBK__PLACE_STORAGE;
    glbk_result result = GLBK_OK;
    int kind;
    for (kind = 0; kind < kinds && result == GLBK_OK; kind++) {
        const uint32_t first = kind == GLBK__PLACE_UNIT ? at.unit : kind == GLBK__PLACE_BLOCK ? at.block : 0;
        result = glbk__take_places(ctx, glbk__slots_of(part, kind), first, kind, h);
    }
    return result;
}

/* Gives the names that every program may declare their places: the base's, and samplers of the user's. */
static glbk_result glbk__take_base(const glbk_context *ctx, const char *function, uint32_t gl_program,
                                   glbk__holders *h)
{
    glbk_result result;
    memset(h, 0, sizeof *h);
    h->function = function;
    h->gl_program = gl_program;
    result = glbk__take_part(ctx, glbk__base(), NULL, h);
    return result == GLBK_OK ? glbk__take_places(ctx, glbk__user_slots, 0, GLBK__PLACE_UNIT, h) : result;
}

/* Refuses a linked program in which two names of its parts and the base have one place. */
static glbk_result glbk__check_places(const glbk_context *ctx, const char *function,
                                      const glbk_program *program)
{
    glbk__holders h;
    glbk_result result = glbk__take_base(ctx, function, program->name, &h);
    uint32_t i;
    for (i = 0; i < GLBK_MAX_PARTS && result == GLBK_OK; i++)
        if (program->parts[i] && program->parts[i] != glbk__base())
            result = glbk__take_part(ctx, program->parts[i], &program->offsets[i], &h);
    return result;
}

/* ---- setting slots ---- */

static void glbk__set_units(const glbk_context *ctx, const char *list, uint32_t offset, uint32_t gl_program)
{
    const char *name;
    uint32_t slot;
    while ((name = glbk__next_slot(&list, &slot)) != NULL) {
        const int32_t location = ctx->gl.GetUniformLocation(gl_program, name);
        if (location >= 0) ctx->gl.Uniform1i(location, (int32_t)(ctx->first_unit + offset + slot));
    }
}

static void glbk__set_part_slots(const glbk_context *ctx, const glbk_part *part, const glbk_offset *offset,
                                 uint32_t gl_program)
{
    const glbk_offset at = glbk__offset(offset);
    const char *blocks = glbk__slots_of(part, GLBK__PLACE_BLOCK), *name;
    uint32_t slot;
    glbk__set_units(ctx, glbk__slots_of(part, GLBK__PLACE_UNIT), at.unit, gl_program);
    while ((name = glbk__next_slot(&blocks, &slot)) != NULL) {
        const uint32_t index = ctx->gl.GetUniformBlockIndex(gl_program, name);
        if (index != GLBK__INVALID_INDEX)
            ctx->gl.UniformBlockBinding(gl_program, index, ctx->first_block + at.block + slot);
    }
}

/* Gives the base's names and the user's own samplers their slots. */
static void glbk__set_base_slots(const glbk_context *ctx, uint32_t gl_program)
{
    glbk__set_part_slots(ctx, glbk__base(), NULL, gl_program);
    glbk__set_units(ctx, glbk__user_slots, 0, gl_program);
}

/* Gives all names of a program that is in use for the first time their slots: glbk_program.slots_fn. */
static void glbk__set_program_slots(const glbk_context *ctx, const glbk_program *program)
{
    uint32_t i;
    glbk__set_base_slots(ctx, program->name);
    for (i = 0; i < GLBK_MAX_PARTS; i++)
        if (program->parts[i])
            glbk__set_part_slots(ctx, program->parts[i], &program->offsets[i], program->name);
}

/* ---- programs that the user linked ----

   A call of glbk_set_slots knows one part. What was set for other parts, or by the user, is asked of GL. GL's
   default is 0, which might as well have been set; so the first call for a program moves what belongs to
   other parts, by its name, and is still at 0 to the last place that GL has, the waiting place. From then on,
   0 was set. (Where GL has 32 units only, slot 31 is the waiting place, and what meets there is not seen.) */

typedef struct glbk__active {       /* a sampler or uniform block that a program declares, as GL lists it */
    char     name[128];
    int      kind;                  /* GLBK__PLACE_UNIT or _BLOCK */
    uint32_t index;                 /* of the block */
    int32_t  count, location;       /* elements of an array of samplers; the first one's location */
    int32_t  place;                 /* unit of the first element, or binding of the block */
} glbk__active;

/* The first and last type of each of GL's ranges of sampler types. */
static const uint32_t glbk__sampler_types[][2] = {
    { 0x8B5D /* SAMPLER_1D */, 0x8B64 /* SAMPLER_2D_RECT_SHADOW */ },
    { 0x8DC0 /* SAMPLER_1D_ARRAY */, 0x8DC5 /* SAMPLER_CUBE_SHADOW */ },
    { 0x8DC9 /* INT_SAMPLER_1D */, 0x8DD8 /* UNSIGNED_INT_SAMPLER_BUFFER */ },
    { 0x900C /* SAMPLER_CUBE_MAP_ARRAY */, 0x900F /* UNSIGNED_INT_SAMPLER_CUBE_MAP_ARRAY */ },
    { 0x9108 /* SAMPLER_2D_MULTISAMPLE */, 0x910D /* UNSIGNED_INT_SAMPLER_2D_MULTISAMPLE_ARRAY */ }
};

static int glbk__is_sampler(uint32_t type)
{
    size_t i;
    for (i = 0; i < sizeof glbk__sampler_types / sizeof glbk__sampler_types[0]; i++)
        if (type >= glbk__sampler_types[i][0] && type <= glbk__sampler_types[i][1]) return 1;
    return 0;
}

/* Reads number i of GL's lists of uniforms or blocks. Returns 0 for a uniform that is no sampler. */
static int glbk__read_active(const glbk_context *ctx, uint32_t gl_program, int kind, uint32_t i,
                             glbk__active *out)
{
    uint32_t type = 0;
    memset(out, 0, sizeof *out);
    out->kind = kind;
    out->index = i;
    if (kind == GLBK__PLACE_BLOCK) {
        ctx->gl.GetActiveUniformBlockName(gl_program, i, sizeof out->name, NULL, out->name);
        ctx->gl.GetActiveUniformBlockiv(gl_program, i, GLBK__UNIFORM_BLOCK_BINDING, &out->place);
        return 1;
    }
    ctx->gl.GetActiveUniform(gl_program, i, sizeof out->name, NULL, &out->count, &type, out->name);
    if (!glbk__is_sampler(type)) return 0;
    out->location = ctx->gl.GetUniformLocation(gl_program, out->name);
    if (out->location < 0) return 0;        /* its name is longer than the room for it */
    ctx->gl.GetUniformiv(gl_program, out->location, &out->place);
    return 1;
}

static uint32_t glbk__count_active(const glbk_context *ctx, uint32_t gl_program, int kind)
{
    int32_t count = 0;
    ctx->gl.GetProgramiv(
        gl_program, kind == GLBK__PLACE_UNIT ? GLBK__ACTIVE_UNIFORMS : GLBK__ACTIVE_UNIFORM_BLOCKS, &count);
    return count > 0 ? (uint32_t)count : 0;
}

/* Returns whether this call gives the name its place: every name that it declares is among the holders. */
static int glbk__is_held(const glbk__holders *h, const glbk__active *a)
{
    uint32_t i;
    for (i = 0; i < GLBK_MAX_UNITS; i++)
        if (h->names[a->kind][i] && strcmp(h->names[a->kind][i], a->name) == 0) return 1;
    return 0;
}

static int glbk__is_of_a_part(const glbk__active *a) { return strncmp(a->name, "glbk_", 5) == 0; }

/* Returns whether no call of glbk_set_slots has given this call's names their places: there are some, and all
   are at 0. */
static int glbk__is_first_call(const glbk_context *ctx, const glbk__holders *h, int kind)
{
    const uint32_t count = glbk__count_active(ctx, h->gl_program, kind);
    glbk__active a;
    uint32_t i;
    int first_call = 0;
    for (i = 0; i < count; i++) {
        if (!glbk__read_active(ctx, h->gl_program, kind, i, &a) || !glbk__is_held(h, &a)) continue;
        if (a.place) return 0;
        first_call = 1;
    }
    return first_call;
}

static int32_t glbk__waiting_place(const glbk_context *ctx, int kind)
{
    return (int32_t)glbk__get_integer(ctx, kind == GLBK__PLACE_UNIT ? GLBK__MAX_COMBINED_TEXTURE_IMAGE_UNITS
                                                                    : GLBK__MAX_UNIFORM_BUFFER_BINDINGS) - 1;
}

/* Returns the unit of one element of an array of samplers, whose name is NAME[0], or the block's binding. */
static int32_t glbk__place_of(const glbk_context *ctx, const glbk__holders *h, const glbk__active *a,
                              int32_t i)
{
    const size_t length = strlen(a->name);
    char element[GLBK__LINE_ROOM];
    glbk__sink sink;
    int32_t place = 0;
    if (i == 0 || length < 3) return a->place;
    glbk__begin_line(&sink, element);
    glbk__append(&sink, a->name, length - 2);               /* without "0]" */
    glbk__append_number(&sink, (uint64_t)i);
    glbk__append_text(&sink, "]");
    i = ctx->gl.GetUniformLocation(h->gl_program, element);
    if (i >= 0) ctx->gl.GetUniformiv(h->gl_program, i, &place);
    return place;
}

/* Refuses names of the call whose places GL has given to others. */
static glbk_result glbk__check_active(const glbk_context *ctx, const glbk__holders *h, int kind)
{
    const uint32_t count = glbk__count_active(ctx, h->gl_program, kind);
    const int first_call = glbk__is_first_call(ctx, h, kind);
    const int32_t waiting = glbk__waiting_place(ctx, kind);
    glbk__active a;
    uint32_t i;
    int32_t k;
    for (i = 0; i < count; i++) {
        if (!glbk__read_active(ctx, h->gl_program, kind, i, &a) || glbk__is_held(h, &a)) continue;
        for (k = 0; k < (a.count > 1 ? a.count : 1); k++) {
            const int32_t place = glbk__place_of(ctx, h, &a, k);
            const int64_t slot = (int64_t)place - glbk__first_place(ctx, kind);
            if (place == waiting || (!place && (first_call || !glbk__is_of_a_part(&a)))) continue;
            if (slot >= 0 && slot < glbk__place_count(ctx, kind) && h->names[kind][slot])
                return glbk__refuse_place(ctx, h, a.name, h->names[kind][slot], (uint32_t)place, kind);
        }
    }
    return GLBK_OK;
}

/* Moves what other parts declare and nobody has set to the waiting place. */
static void glbk__let_wait(const glbk_context *ctx, const glbk__holders *h, int kind)
{
    const uint32_t count = glbk__count_active(ctx, h->gl_program, kind);
    const int32_t waiting = glbk__waiting_place(ctx, kind);
    glbk__active a;
    uint32_t i;
    if (!glbk__is_first_call(ctx, h, kind)) return;
    for (i = 0; i < count; i++) {
        if (!glbk__read_active(ctx, h->gl_program, kind, i, &a) || a.place || glbk__is_held(h, &a) ||
            !glbk__is_of_a_part(&a))
            continue;
        if (kind == GLBK__PLACE_UNIT) ctx->gl.Uniform1i(a.location, waiting);
        else ctx->gl.UniformBlockBinding(h->gl_program, a.index, (uint32_t)waiting);
    }
}

/* Uniforms can be set in the program in use alone before OpenGL 4.1, and Emscripten finds the places of
   uniforms, which are read here too, in that program alone: the program that was in use is put back.
   If that one was to be deleted once it is no longer in use, GL has done so by now, and none is in use. */
GLBK_DEF glbk_result glbk_set_slots(glbk_context *ctx, const glbk_part *part, const glbk_offset *offset,
                                    uint32_t gl_program)
{
    glbk__holders h;
    glbk_result result;
    uint32_t used;
    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (ctx->lost) return GLBK_ERR_LOST;
    if (!gl_program) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "gl_program", "is 0");
    result = glbk__take_base(ctx, __func__, gl_program, &h);
    if (result == GLBK_OK && part && part != glbk__base()) result = glbk__take_part(ctx, part, offset, &h);
    if (result != GLBK_OK) return result;
    used = glbk__get_integer(ctx, GLBK__CURRENT_PROGRAM);
    if (used != gl_program) ctx->gl.UseProgram(gl_program);
    result = glbk__check_active(ctx, &h, GLBK__PLACE_UNIT);
    if (result == GLBK_OK) result = glbk__check_active(ctx, &h, GLBK__PLACE_BLOCK);
    if (result == GLBK_OK) {
        glbk__let_wait(ctx, &h, GLBK__PLACE_UNIT);
        glbk__let_wait(ctx, &h, GLBK__PLACE_BLOCK);
        glbk__set_base_slots(ctx, gl_program);
        if (part) glbk__set_part_slots(ctx, part, offset, gl_program);
    }
    if (used != gl_program) ctx->gl.UseProgram(ctx->gl.IsProgram(used) ? used : 0);
    return result;
}

/* ==== src/gl_programs/linking.h ==== */

/* ---- linking: programs of the library, and programs of a user's text ---- */

enum {
    GLBK__FRAGMENT_SHADER = 0x8B30, GLBK__VERTEX_SHADER = 0x8B31, GLBK__COMPUTE_SHADER = 0x91B9,
    GLBK__COMPILE_STATUS = 0x8B81, GLBK__LINK_STATUS = 0x8B82, GLBK__INFO_LOG_LENGTH = 0x8B84
};

/* One stage of a program, before it is compiled. */
typedef struct glbk__stage {
    uint32_t    type;
    glbk_shader shader;             /* has a name or a text, one of them */
} glbk__stage;

/* Appends which number of the driver's messages is which file. */
static void glbk__append_files(glbk__sink *sink, const glbk_shader *shader)
{
    const glbk_file *main_file;
    glbk__list list;
    uint32_t i;

    (void)glbk__gather_all(&list, shader, &main_file);      /* all are there: the text was compiled */
    glbk__append_text(sink, "files: 0 defines");
    for (i = 0; i <= list.count; i++) {
        glbk__append_text(sink, ", ");
        glbk__append_number(sink, i + 1);
        glbk__append_text(sink, " ");
        glbk__append_text(sink, i < list.count ? list.file[i]->name
                                : shader->name ? shader->name
                                               : "your text");
    }
    if (shader->name && shader->text) {
        glbk__append_text(sink, ", ");
        glbk__append_number(sink, list.count + 2);
        glbk__append_text(sink, " your text");
    }
    glbk__append_text(sink, "\n");
}

/* Logs the driver's words on a shader, after the list of its files, or on a program: shader is NULL then. */
static void glbk__log_driver(const glbk_context *ctx, uint32_t object, const glbk_shader *shader)
{
    glbk_prog__allocator memory = glbk_prog__memory(ctx);
    glbk__sink sink = { NULL, 0, 0 };
    int32_t length = 0;

    if (!ctx->system.log) return;
    if (shader) ctx->gl.GetShaderiv(object, GLBK__INFO_LOG_LENGTH, &length);
    else ctx->gl.GetProgramiv(object, GLBK__INFO_LOG_LENGTH, &length);
    if (length < 0) length = 0;
    if (shader) glbk__append_files(&sink, shader);
    sink.bytes = sink.used + (size_t)length + 2;
    sink.out = (char *)glbk_prog__alloc(&memory, sink.bytes);
    if (!sink.out) {
        ctx->system.log(ctx->system.user, "no memory for the driver's words");
        return;
    }
    sink.used = 0;
    if (shader) glbk__append_files(&sink, shader);
    memset(sink.out + sink.used, 0, sink.bytes - sink.used);
    if (shader) ctx->gl.GetShaderInfoLog(object, length + 1, NULL, sink.out + sink.used);
    else ctx->gl.GetProgramInfoLog(object, length + 1, NULL, sink.out + sink.used);
    sink.used = strlen(sink.out);
    while (sink.used && sink.out[sink.used - 1] == '\n') sink.out[--sink.used] = 0;
    ctx->system.log(ctx->system.user, sink.used ? sink.out : "the driver says nothing");
    glbk_prog__free(&memory, sink.out);
}

/* Logs why a stage has no text: "FUNCTION: the library file NAME is unknown", or defines that do not parse.
 */
static glbk_result glbk__refuse_shader(const glbk_context *ctx, const glbk_shader *shader)
{
    static const char function[] = "glbk_program_compile";
    const glbk_file *main_file;
    glbk__list list;
    char line[GLBK__LINE_ROOM];
    glbk__sink sink;
    glbk__begin_line(&sink, line);
    if (glbk__gather_all(&list, shader, &main_file)) {
        glbk__append_text(&sink, "do not parse: ");
        glbk__append_text(&sink, shader->defines);
        return glbk__refuse(ctx, GLBK_ERR_NAME, function, "defines", line);
    }
    if (!list.unknown)
        return glbk__refuse_range(ctx, GLBK_ERR_NAME, function, "the number of library files",
                                  (double)GLBK__MAX_FILES + 1, 0, GLBK__MAX_FILES);
    glbk__append(&sink, list.unknown, list.unknown_length);
    glbk__append_text(&sink, " is in none of the parts");
    return glbk__refuse(ctx, GLBK_ERR_NAME, function, "the library file", line);
}

/* Compiles one stage and attaches it. */
static glbk_result glbk__add_stage(glbk_context *ctx, uint32_t program, const glbk__stage *stage)
{
    glbk_dialect dialect = ctx->es                               ? GLBK_GLSL_300_ES
                           : stage->type == GLBK__COMPUTE_SHADER ? GLBK_GLSL_430
                                                                 : GLBK_GLSL_330;
    glbk_prog__allocator memory = glbk_prog__memory(ctx);
    int bits = !ctx->float_targets;
    size_t bytes = glbk_write_glsl(dialect, bits, &stage->shader, NULL, 0);
    char *text;
    uint32_t shader;
    int32_t compiled = 0;

    if (!bytes) return glbk__refuse_shader(ctx, &stage->shader);
    if (bytes > INT32_MAX)
        return glbk__refuse_range(ctx, GLBK_ERR_LIMIT, "glbk_program_compile",
                                  "the bytes of a shader's text", (double)bytes, 1, INT32_MAX);
    text = (char *)glbk_prog__alloc(&memory, bytes);
    if (!text) return GLBK_ERR_ALLOC;
    glbk_write_glsl(dialect, bits, &stage->shader, text, bytes);
    shader = ctx->gl.CreateShader(stage->type);
    if (shader) {
        const char *const texts[1] = { text };
        ctx->gl.ShaderSource(shader, 1, texts, NULL);
        ctx->gl.CompileShader(shader);
        ctx->gl.GetShaderiv(shader, GLBK__COMPILE_STATUS, &compiled);
        if (compiled) {
            ctx->gl.AttachShader(program, shader);
        } else {
            glbk__log_driver(ctx, shader, &stage->shader);
        }
        ctx->gl.DeleteShader(shader);       /* GL keeps it as long as it is attached */
    }
    glbk_prog__free(&memory, text);
    return compiled ? GLBK_OK : shader ? GLBK_ERR_COMPILE : GLBK_ERR_GL;
}

/* Gives GL the names for transform feedback, which it wants as an array. */
static glbk_result glbk__set_outputs(const glbk_context *ctx, uint32_t program, const char *outputs)
{
    char text[512];
    const char *names[16];
    int32_t count = 0;
    size_t length, used = 0;

    for (; (length = glbk__next_word(&outputs)) != 0; outputs += length) {
        if (count == 16 || length + 1 > sizeof text - used)
            return glbk__refuse(ctx, GLBK_ERR_DESC, "glbk_program_compile", "source.outputs",
                                count == 16 ? "has more than 16 names" : "has more than 511 characters");
        names[count++] = text + used;
        memcpy(text + used, outputs, length);
        text[used + length] = 0;
        used += length + 1;
    }
    if (count) ctx->gl.TransformFeedbackVaryings(program, count, names, GLBK_GL_INTERLEAVED_ATTRIBS);
    return GLBK_OK;
}

static glbk_result glbk__link(glbk_context *ctx, const glbk__stage *stages, int count, const char *outputs,
                              glbk_program *out)
{
    glbk_result result = GLBK_OK, errors;
    int32_t linked = 0;
    int i;

    memcpy(out->parts, stages[0].shader.parts, sizeof out->parts);
    out->slots_fn = glbk__set_program_slots;
    out->name = ctx->gl.CreateProgram();
    if (!out->name) result = GLBK_ERR_GL;
    for (i = 0; i < count && result == GLBK_OK; i++)
        result = glbk__add_stage(ctx, out->name, &stages[i]);
    if (result == GLBK_OK) result = glbk__set_outputs(ctx, out->name, outputs);
    if (result == GLBK_OK) {
        ctx->gl.LinkProgram(out->name);
        ctx->gl.GetProgramiv(out->name, GLBK__LINK_STATUS, &linked);
        if (!linked) {
            glbk__log_driver(ctx, out->name, NULL);
            result = GLBK_ERR_LINK;
        }
    }
    errors = glbk__leave(ctx);
    if (errors != GLBK_OK) result = errors;
    if (result != GLBK_OK) glbk_program_free(ctx, out);
    return result;
}

GLBK__DEF glbk_result glbk__program_of_parts(glbk_context *ctx, const glbk_part *part,
                                             const glbk_part *const others[2], const char *name,
                                             const char *defines, const char *const texts[2],
                                             glbk_program *out)
{
    static const char function[] = "glbk__program_create";
    glbk__stage stages[2];
    const glbk_file *file, *vertex;
    char path[64] = "prog/";
    const char *with;
    size_t length;
    glbk_result result;

    result = glbk__enter_create(ctx, function, out, sizeof *out);
    if (result != GLBK_OK) return result;
    if (!name) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, function, "name", "is NULL");
    length = strlen(name);
    if (length < sizeof path - 5) memcpy(path + 5, name, length + 1);
    file = glbk_find_file(part, path);
    if (!file) return glbk__refuse(ctx, GLBK_ERR_NAME, function, name, "is no file of the part");
    memset(stages, 0, sizeof stages);
    stages[0].shader.parts[0] = part;
    if (others) memcpy(stages[0].shader.parts + 1, others, 2 * sizeof *others);
    stages[0].shader.uses = "";
    stages[0].shader.defines = defines;
    stages[1].shader = stages[0].shader;
    stages[0].shader.name = file->name;
    stages[0].shader.text = texts ? texts[1] : NULL;
    if (length > 5 && strcmp(name + length - 5, ".comp") == 0) {
        if (!ctx->compute) return glbk__refuse(ctx, GLBK_ERR_FEATURE, function, name, "needs OpenGL 4.3");
        stages[0].type = GLBK__COMPUTE_SHADER;
        return glbk__link(ctx, stages, 1, "", out);
    }
    with = glbk__file_fact(file, GLBK__FILE_WITH);
    if (!*with && length > 5 && strcmp(name + length - 5, ".frag") == 0) with = "screen.vert";
    strcpy(path + 5, with);
    vertex = glbk_find_file(part, path);
    if (!vertex)
        return glbk__refuse(ctx, GLBK_ERR_NAME, function, name, "is no program: it has no vertex shader");
    stages[0].type = GLBK__FRAGMENT_SHADER;
    stages[1].type = GLBK__VERTEX_SHADER;
    stages[1].shader.name = vertex->name;
    stages[1].shader.text = texts ? texts[0] : NULL;
    return glbk__link(ctx, stages, 2, "", out);
}

GLBK__DEF glbk_result glbk__program_create(glbk_context *ctx, const glbk_part *part, const char *name,
                                           const char *defines, glbk_program *out)
{
    return glbk__program_of_parts(ctx, part, NULL, name, defines, NULL, out);
}

/* Links the program of a user's text, whose parts must not meet. */
static glbk_result glbk__link_source(glbk_context *ctx, const glbk__stage *stages, int count,
                                     const glbk_source *s, glbk_program *out)
{
    glbk_result result = glbk__link(ctx, stages, count, s->outputs && count == 2 ? s->outputs : "", out);
    if (result != GLBK_OK) return result;
    memcpy(out->offsets, s->offsets, sizeof out->offsets);
    result = glbk__check_places(ctx, "glbk_program_compile", out);
    if (result != GLBK_OK) glbk_program_free(ctx, out);
    return result;
}

GLBK_DEF glbk_result glbk_program_compile(glbk_context *ctx, const glbk_source *s, glbk_program *out)
{
    glbk__stage stages[2];
    glbk_result result;

    result = glbk__enter_create(ctx, __func__, out, sizeof *out);
    if (result != GLBK_OK) return result;
    if (!s) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "source", "is NULL");
    if (!s->fragment && !s->compute)
        return glbk__refuse(ctx, GLBK_ERR_DESC, __func__, "source.fragment",
                            "is NULL, and so is source.compute");
    if (s->fragment && s->compute)
        return glbk__refuse(ctx, GLBK_ERR_DESC, __func__, "source.fragment",
                            "is given, and so is source.compute: a program has one of them");
    memset(stages, 0, sizeof stages);
    memcpy(stages[0].shader.parts, s->parts, sizeof s->parts);
    stages[0].shader.uses = s->uses ? s->uses : "";
    stages[0].shader.defines = s->defines;
    stages[1].shader = stages[0].shader;
    if (s->compute) {
        if (!ctx->compute)
            return glbk__refuse(ctx, GLBK_ERR_FEATURE, __func__, "source.compute", "needs OpenGL 4.3");
        stages[0].type = GLBK__COMPUTE_SHADER;
        stages[0].shader.text = s->compute;
        return glbk__link_source(ctx, stages, 1, s, out);
    }
    stages[0].type = GLBK__FRAGMENT_SHADER;
    stages[0].shader.text = s->fragment;
    stages[1].type = GLBK__VERTEX_SHADER;
    stages[1].shader.name = s->vertex ? NULL : "prog/screen.vert";
    if (!s->vertex) stages[1].shader.uses = "";     /* a library file may speak of gl_FragCoord */
    stages[1].shader.text = s->vertex;
    return glbk__link_source(ctx, stages, 2, s, out);
}

GLBK_DEF void glbk_program_free(glbk_context *ctx, glbk_program *program)
{
    if (!program) return;
    if (ctx && !ctx->lost && program->name) ctx->gl.DeleteProgram(program->name);
    memset(program, 0, sizeof *program);
}

GLBK_DEF glbk_result glbk_dispatch(glbk_context *ctx, glbk_program *program, uint32_t x, uint32_t y,
                                   uint32_t z)
{
    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!program || !program->name)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "program", "was not created");
    if (ctx->lost) return GLBK_ERR_LOST;
    if (!ctx->compute)
        return glbk__refuse(ctx, GLBK_ERR_FEATURE, __func__, "ctx", "is older than OpenGL 4.3");
    glbk_program_use(ctx, program);
    ctx->gl.DispatchCompute(x, y, z);
    ctx->gl.Barrier(GLBK_GL_ALL_BARRIER_BITS);
    return GLBK_OK;
}

/* ==== src/gl_programs/techniques.h ==== */

/* ---- what only the techniques need: logs of meshes, blocks of a pass, pictures ---- */

GLBK__DEF glbk_result glbk__refuse_index(const glbk_context *ctx, glbk_result result, const char *function,
                                         const char *mesh, size_t position, size_t index, size_t vertex_count)
{
    char field[GLBK__LINE_ROOM], text[GLBK__LINE_ROOM];
    glbk__sink sink;
    glbk__begin_line(&sink, field);
    glbk__append_text(&sink, mesh);
    glbk__append_text(&sink, ":");
    glbk__begin_line(&sink, text);
    glbk__append_text(&sink, "index ");
    glbk__append_number(&sink, position % 3);
    glbk__append_text(&sink, " of triangle ");
    glbk__append_number(&sink, position / 3);
    glbk__append_text(&sink, " is ");
    glbk__append_number(&sink, index);
    glbk__append_text(&sink, ", but the mesh has ");
    glbk__append_number(&sink, vertex_count);
    glbk__append_text(&sink, vertex_count == 1 ? " vertex" : " vertices");
    return glbk__refuse(ctx, result, function, field, text);
}

/* Two calls of GL, which go through the binding that a pass changes anyway. The storage is new each time, so
   that nothing waits for the draws before, copies what they read or, on GPUs that draw tile by tile, splits
   their pass. */
GLBK__DEF glbk_result glbk__put_block(glbk_context *ctx, uint32_t slot, const glbk_buffer *buffer,
                                      const void *values)
{
    const uint32_t target = GLBK_GL_UNIFORM_BUFFER;
    glbk_result result = glbk__enter_frame(ctx);
    if (ctx->lost) return GLBK_ERR_LOST;
    if (!buffer->name)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, "a technique's pass", "its uniform block",
                            "was not created");
    /* The buffer is bound in spite of an error, since a callback may draw all the same. */
    ctx->gl.BindBufferBase(target, ctx->first_block + slot, buffer->name);
    if (result != GLBK_OK) return result;
    ctx->gl.BufferData(target, (ptrdiff_t)buffer->bytes, values, GLBK_GL_STREAM_DRAW);
    return glbk__leave_frame(ctx);
}

GLBK__DEF glbk_result glbk__canvas(glbk_context *ctx, glbk_format format, uint32_t width, uint32_t height,
                                   const glbk_texture *depth, glbk_texture *texture, glbk_target *target)
{
    glbk_texture_desc d;
    glbk_target_desc t;
    glbk_result result;
    if (!width || !height)
        return glbk__refuse_value(ctx, GLBK_ERR_ARGUMENT, "a picture", width ? "height" : "width", 0,
                                  "1 or more");
    memset(&d, 0, sizeof d);
    memset(&t, 0, sizeof t);
    d.format = format;
    d.width = width;
    d.height = height;
    t.color[0] = texture;
    t.depth = depth;
    result = glbk_texture_create(ctx, &d, texture);
    return result == GLBK_OK ? glbk__target_create(ctx, &t, target) : result;
}

GLBK__DEF void glbk__sums_free(glbk_context *ctx, glbk_texture sums[2], glbk_target targets[2])
{
    int i;
    for (i = 0; i < 2; i++) {
        glbk_target_free(ctx, &targets[i]);
        glbk_texture_free(ctx, &sums[i]);
    }
}

GLBK__DEF glbk_result glbk__sums_create(glbk_context *ctx, int compute, uint32_t width, uint32_t height,
                                        glbk_texture sums[2], glbk_target targets[2])
{
    glbk_result result = GLBK_OK;
    int i;
    for (i = 0; i < (compute ? 1 : 2) && result == GLBK_OK; i++)
        result = glbk__canvas(ctx, GLBK_FORMAT_COLOR, width, height, NULL, &sums[i], &targets[i]);
    if (result != GLBK_OK) glbk__sums_free(ctx, sums, targets);
    return result;
}

/* ---- tables: texel i at (i & 1023, i >> 10 & 1023, i >> 20) ---- */

enum { GLBK__TABLE_BITS = 10, GLBK__TABLE_SIDE = 1 << GLBK__TABLE_BITS };

GLBK__DEF glbk_result glbk__table_create(glbk_context *ctx, glbk_format format, const void *texels,
                                         size_t count, glbk_texture *out)
{
    const size_t side = GLBK__TABLE_SIDE;
    glbk_texture_desc d;
    glbk_result result;
    size_t rows;

    if (out) memset(out, 0, sizeof *out);
    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (ctx->lost) return GLBK_ERR_LOST;
    if (!out) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "out", "is NULL");
    rows = count ? (count - 1) / side + 1 : 0;
    if (!count || (rows - 1) / side >= ctx->max_layers)
        return glbk__refuse_range(ctx, count ? GLBK_ERR_LIMIT : GLBK_ERR_ARGUMENT, __func__, "count",
                                  (double)count, 1, (double)ctx->max_layers * 1048576.0);
    memset(&d, 0, sizeof d);
    d.format = format;
    d.width = GLBK__TABLE_SIDE;
    d.height = (uint32_t)(rows < side ? rows : side);
    d.layers = (uint32_t)((rows - 1) / side + 1);
    result = glbk_texture_create(ctx, &d, out);
    if (result == GLBK_OK && texels)
        result = glbk__leave_created(ctx, glbk__table_update(ctx, out, 0, count, texels));
    if (result != GLBK_OK) glbk_texture_free(ctx, out);
    return result;
}

/* A run of texels is up to three boxes in each layer: the rest of a row, whole rows, the beginning of a
   row. */
GLBK__DEF glbk_result glbk__table_update(glbk_context *ctx, const glbk_texture *table, size_t first,
                                         size_t count, const void *texels)
{
    const size_t side = GLBK__TABLE_SIDE;
    const unsigned char *from = (const unsigned char *)texels;
    glbk__upload old;
    size_t room;
    glbk_result result;

    if (!ctx) return GLBK_ERR_ARGUMENT;
    if (!table || !table->name || table->width != side || !table->layers)
        return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "table", "was not made by glbk__table_create");
    if (!texels) return glbk__refuse(ctx, GLBK_ERR_ARGUMENT, __func__, "texels", "is NULL");
    room = side * table->height * table->layers;
    if (first > room)
        return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, __func__, "first", (double)first, 0, (double)room);
    if (count > room - first)
        return glbk__refuse_range(ctx, GLBK_ERR_ARGUMENT, __func__, "count", (double)count, 0,
                                  (double)(room - first));
    result = glbk__enter_frame(ctx);
    if (result != GLBK_OK || !count) return result;
    glbk__upload_begin(ctx, table, &old);
    while (count) {
        const size_t x = first % side, y = first / side % side;
        glbk_box box = { 0, 0, 0, 0, 0, 1, 1 };
        size_t texels_in_box;
        box.x = (uint32_t)x;
        box.y = (uint32_t)y;
        box.layer = (uint32_t)(first / side / side);
        if (x || count < side) {
            box.width = (uint32_t)(count < side - x ? count : side - x);
        } else {
            box.width = GLBK__TABLE_SIDE;
            box.height = (uint32_t)(count / side < side - y ? count / side : side - y);
        }
        glbk__upload_box(ctx, table, &box, from);
        texels_in_box = (size_t)box.width * box.height;
        from += texels_in_box * glbk__texel_bytes(table->format);
        first += texels_in_box;
        count -= texels_in_box;
    }
    glbk__upload_end(ctx, table, &old);
    return glbk__leave_frame(ctx);
}

/* ==== src/gl_programs/end.h ==== */

#endif /* GL_PROGRAMS_IMPLEMENTATION */

/*
Dapple is available under either of the two licences below, at your choice:
MIT-0 OR Unlicense.

------------------------------------------------------------------------------
MIT No Attribution

Copyright 2026 The Dapple authors

Permission is hereby granted, free of charge, to any person obtaining a copy
of this software and associated documentation files (the "Software"), to deal
in the Software without restriction, including without limitation the rights
to use, copy, modify, merge, publish, distribute, sublicense, and/or sell
copies of the Software, and to permit persons to whom the Software is
furnished to do so.

THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR
IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY,
FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE
AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER
LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM,
OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE
SOFTWARE.

------------------------------------------------------------------------------
The Unlicense

This is free and unencumbered software released into the public domain.

Anyone is free to copy, modify, publish, use, compile, sell, or distribute
this software, either in source code form or as a compiled binary, for any
purpose, commercial or non-commercial, and by any means.

In jurisdictions that recognize copyright laws, the author or authors of this
software dedicate any and all copyright interest in the software to the public
domain. We make this dedication for the benefit of the public at large and to
the detriment of our heirs and successors. We intend this dedication to be an
overt act of relinquishment in perpetuity of all present and future rights to
this software under copyright law.

THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR
IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY,
FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE
AUTHORS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN
ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION
WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE.

For more information, please refer to <https://unlicense.org/>
*/
