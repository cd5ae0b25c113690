/* 06b_csm_own_api.c - coherent shadow maps and an area light on an API of your own: what a renderer on
   Vulkan, Direct3D, Metal or WebGPU compiles and uploads. No GL is called.

   cc -O2 06b_csm_own_api.c -lm -o csm_own_api && ./csm_own_api own
   glslangValidator -V own.comp -o own.spv

   It writes own.comp, a compute shader that says how much of a rectangular light reaches each of many points,
   and own.blocks and own.lights, the bytes of its first two storage buffers. docs/gpu-layouts.md has their
   layouts. */
#define CSM_IMPLEMENTATION
#include "csm.h"
#define GL_BACKEND_IMPLEMENTATION
#define GL_PROGRAMS_IMPLEMENTATION
#define GL_GBUFFER_IMPLEMENTATION
#define GL_CSM_IMPLEMENTATION
#include "gl_backend/gl_csm.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- the shader ---- */

/* Buffers, and the macros by which the library reads them. */
static const char head[] =
    "#version 450\n"
    "layout(local_size_x = 64) in;\n"
    "layout(std430, binding = 0) readonly buffer blocks_buffer { uvec4 blocks[]; };\n"
    "layout(std430, binding = 1) readonly buffer lights_buffer { uvec4 lights[]; };\n"
    "layout(std430, binding = 2) readonly buffer points_buffer { vec4 points[]; };\n"
    "layout(std430, binding = 3) writeonly buffer shares_buffer { float shares[]; };\n"
    "#define COHSM_TEXEL(i) blocks[i]\n"
    "#define COHSM_LIGHT_TEXEL(i) lights[i]\n";

static const char body[] =
    "void main()\n"
    "{\n"
    "    uint i = gl_GlobalInvocationID.x;\n"
    "    if (i >= uint(points.length())) return;\n"
    "    cohsm_maps maps = cohsm_open(0u);                   // the block that begins at texel 0\n"
    "    cohsm_light light = cohsm_light_open(0u);           // the light that begins at texel 0\n"
    "    cohsm_query query = cohsm_ask(COHSM_LIGHT_POSITION, COHSM_FILTER_NEAREST, 1.0);\n"
    "    cohsm_aim aim;\n"
    "    float sum = 0.0;\n"
    "    if (cohsm_aim_at(light, points[i].xyz, aim))\n"
    "        for (uint k = 0u; k < 64u; k++) {\n"
    "            cohsm_emission found;\n"
    "            if (!cohsm_light_draw(light, aim, vec3(cohsm_sobol2(k, i), 0.0), found)) continue;\n"
    "            vec3 place = points[i].xyz + found.direction * found.range;\n"
    "            sum += max(cohsm_visible(maps, query, points[i].xyz, place), 0.0);\n"
    "        }\n"
    "    shares[i] = sum / 64.0;\n"
    "}\n";

/* The library's functions, each file after those that it uses: "// uses:" in its first lines says which. */
static const char *const files[] = {
    "cohsm_math", "cohsm_octa", "cohsm_random", "cohsm_lookup", "cohsm_visible", "cohsm_emission", "cohsm_light"
};

static int write_shader(FILE *out)
{
    fputs(head, out);
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char name[64];
        const glbk_file *file;
        snprintf(name, sizeof name, "lib/%s.glsl", files[i]);
        file = glbk_find_file(glbk_csm_part(), name);
        if (!file) return 0;
        for (const char *text = glbk_file_text(file); *text; text += strlen(text) + 1) fputs(text, out);
    }
    fputs(body, out);
    return 1;
}

/* ---- the buffers ---- */

/* Maps of a box, as csm.h keeps them: their bytes are what is uploaded. */
static int write_blocks(FILE *out)
{
    static const float corners[8][3] = { { -1, -1, -1 }, { 1, -1, -1 }, { -1, 1, -1 }, { 1, 1, -1 },
                                         { -1, -1, 1 },  { 1, -1, 1 },  { -1, 1, 1 },  { 1, 1, 1 } };
    static const uint32_t indices[36] = { 0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                          2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5 };
    const cohsm_mesh box = { corners[0], 8, 0, indices, 36, NULL, NULL, NULL };
    cohsm_desc desc;
    cohsm_maps *maps;
    const void *data;
    size_t bytes;
    int ok;
    memset(&desc, 0, sizeof desc);
    desc.domain.side[0] = desc.domain.side[1] = 32;
    desc.map_side = 64;
    if (cohsm_build(&desc, &box, &maps, NULL) != COHSM_OK) return 0;
    data = cohsm_data(maps, &bytes);
    ok = fwrite(data, 1, bytes, out) == bytes;
    printf("blocks: %zu texels\n", bytes / 16);
    cohsm_free(maps);
    return ok;
}

static void say(void *user, const char *message)
{
    (void)user;
    fprintf(stderr, "%s\n", message);
}

/* A rectangle above the box that shines down; a table of several lights is one after the other. */
static int write_lights(FILE *out)
{
    lsamp_light_desc light;
    uint32_t *words;
    size_t texels;
    int ok;
    memset(&light, 0, sizeof light);
    light.system.log = say;
    light.kind = LSAMP_LIGHT_RECTANGLE;
    light.position[0] = light.position[2] = -1;
    light.position[1] = 4;
    light.u[0] = light.v[2] = 2;
    light.radiance[0] = light.radiance[1] = light.radiance[2] = 1;
    texels = glbk_csm_light_texels(&light);
    words = malloc(16 * (texels + 1));
    ok = texels && words && glbk_csm_light_write(&light, words) == GLBK_OK &&
         fwrite(words, 16, texels, out) == texels;
    printf("lights: %zu texels\n", texels);
    free(words);
    return ok;
}

static int write_file(const char *name, const char *ending, int (*write)(FILE *out))
{
    char path[512];
    FILE *out;
    int ok;
    snprintf(path, sizeof path, "%s%s", name, ending);
    out = fopen(path, "wb");
    ok = out && write(out);
    if (out && fclose(out) != 0) ok = 0;
    if (!ok) fprintf(stderr, "%s: cannot be written\n", path);
    return ok;
}

int main(int count, char **values)
{
    const char *name = count > 1 ? values[1] : "own";
    return !(write_file(name, ".comp", write_shader) && write_file(name, ".blocks", write_blocks) &&
             write_file(name, ".lights", write_lights));
}
