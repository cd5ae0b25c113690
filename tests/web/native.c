/* native.c - what the page "product" draws, by the same code on a GL context of this machine: native MODEL SKY WIDTH
   HEIGHT FRAMES SIDE MAP_SIDE TURN OUT.png. tests/web/pages.mjs compares the page's picture with it. */
#include "gl_context.h"
#include "../../web/product.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int build(const pd_model *model, unsigned side, unsigned map_side, cohsm_maps **maps)
{
    cohsm_desc desc = { 0 };
    cohsm_mesh mesh = { 0 };
    float *positions;
    uint32_t *indices;
    int result;
    if (pd_model_merge(model, &positions, &mesh.vertex_count, &indices, &mesh.index_count) != 0) return -1;
    mesh.positions = positions;
    mesh.indices = indices;
    desc.domain.side[0] = desc.domain.side[1] = side;
    desc.map_side = map_side;
    desc.order = COHSM_ORDER_HILBERT;
    result = cohsm_build(&desc, &mesh, maps, NULL) == COHSM_OK ? 0 : -1;
    free(positions);
    free(indices);
    return result;
}

static int save(glbk_context *gl, uint32_t width, uint32_t height, const glbk_target *target, const char *path,
                char *error)
{
    float *rgba = malloc(4 * (size_t)width * height * sizeof *rgba);
    unsigned char *rgb = malloc(3 * (size_t)width * height);
    int result = -1;
    if (rgba && rgb && glbk_target_read(gl, target, 0, 0, 0, width, height, rgba) == GLBK_OK) {
        for (uint32_t y = 0; y < height; y++)
            for (uint32_t x = 0; x < 3 * width; x++)
                rgb[3 * (size_t)width * (height - 1 - y) + x] =
                    (unsigned char)(rgba[4 * ((size_t)y * width + x / 3) + x % 3] * 255 + 0.5f);
        result = ex_png_write(path, width, height, rgb, error);
    }
    free(rgba);
    free(rgb);
    return result;
}

/* The page draws to the window; here the framebuffer that is bound is a target's. */
static int make_window(glbk_context *gl, uint32_t width, uint32_t height, glbk_texture *texture, glbk_target *target)
{
    const glbk_texture_desc desc = { GLBK_FORMAT_RGBA8, width, height, 0, 0, GLBK_SAMPLING_DEFAULT, 0, NULL };
    glbk_target_desc to = { { NULL }, { 0 }, NULL, 0, 0 };
    to.color[0] = texture;
    if (glbk_texture_create(gl, &desc, texture) != GLBK_OK) return -1;
    return glbk_target_create(gl, &to, target) == GLBK_OK ? 0 : -1;
}

typedef struct native {
    glbk_context gl;
    pd_picture   picture;
    pd_model     model;
    ex_sky       sky;
    glbk_texture texture;
    glbk_target  target;
    cohsm_maps  *maps;
} native;

/* The arguments from MODEL to MAP_SIDE. */
static int open_all(native *n, char **values, char *error)
{
    static const ex_gl_options options = { EX_GL_HEADLESS, 0, 0, 0, 0, 0, 0, 0, 0, NULL };
    const uint32_t width = (uint32_t)atoi(values[2]), height = (uint32_t)atoi(values[3]);
    ex_gl *context = ex_gl_create(&options, error);
    glbk_desc desc = { 0 };
    const void *block;
    size_t bytes;
    desc.get_proc_fn = ex_gl_get_proc;
    desc.user = context;
    desc.system.log = ex_gl_log;
    desc.core_only = 1;                 /* as in a browser */
    if (!context || glbk_init(&n->gl, &desc) != GLBK_OK) return -1;
    if (pd_picture_create(&n->picture, &n->gl, error) != 0 || pd_model_load(&n->model, values[0], error) != 0 ||
        pd_model_upload(&n->model, &n->gl, error) != 0 || ex_sky_load(&n->sky, values[1], error) != 0 ||
        pd_picture_sky(&n->picture, &n->sky, error) != 0 ||
        pd_picture_resize(&n->picture, width, height, error) != 0)
        return -1;
    if (build(&n->model, (unsigned)atoi(values[5]), (unsigned)atoi(values[6]), &n->maps) != 0 ||
        make_window(&n->gl, width, height, &n->texture, &n->target) != 0)
        return -1;
    n->picture.window = n->target.name;
    block = cohsm_data(n->maps, &bytes);
    return pd_picture_maps(&n->picture, block, bytes, n->model.radius, error);
}

int main(int count, char **values)
{
    static native n;
    pd_view view = { 0.9f, 0.35f, 3.6f, -0.1f, 0, 1, 4, 0 };      /* product.js's at first */
    char error[EX_ERROR_SIZE] = "";
    int failed, frames;
    if (count != 10) return 2;
    frames = atoi(values[5]);
    view.sky_turn = (float)atof(values[8]) * 3.14159265f / 180;
    failed = open_all(&n, values + 1, error);
    for (int i = 0; i < frames && !failed; i++)
        failed = pd_picture_frame(&n.picture, &n.model, &view, i == 0, error);
    if (!failed) failed = save(&n.gl, n.picture.width, n.picture.height, &n.target, values[9], error);
    if (failed) fprintf(stderr, "native: %s\n", error);
    return failed != 0;
}
