/* native.c - what the page "product" draws, by the same code on a GL context of this machine: native MODEL SKY WIDTH
   HEIGHT FRAMES SIDE MAP_SIDE TURN OUT.png. tests/web/pages.mjs compares the page's picture with it. */
#include "../../web/product.h"
#include "native.h"

static int build(const pg_model *model, unsigned side, unsigned map_side, cohsm_maps **maps)
{
    cohsm_desc desc = { 0 };
    cohsm_mesh mesh = { 0 };
    float *positions;
    uint32_t *indices;
    int result;
    if (pg_model_merge(model, &positions, &mesh.vertex_count, &indices, &mesh.index_count) != 0) return -1;
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

typedef struct native {
    glbk_context gl;
    pd_picture   picture;
    pg_model     model;
    ex_sky       sky;
    glbk_texture texture;
    glbk_target  target;
    cohsm_maps  *maps;
} native;

/* The arguments from MODEL to MAP_SIDE. */
static int open_all(native *n, char **values, char *error)
{
    const uint32_t width = (uint32_t)atoi(values[2]), height = (uint32_t)atoi(values[3]);
    const void *block;
    size_t bytes;
    if (native_open(&n->gl, error) != 0) return -1;
    if (pd_picture_create(&n->picture, &n->gl, error) != 0 || pd_model_load(&n->model, values[0], error) != 0 ||
        pg_model_upload(&n->model, &n->gl, error) != 0 || ex_sky_load(&n->sky, values[1], error) != 0 ||
        pd_picture_sky(&n->picture, &n->sky, error) != 0 ||
        pd_picture_resize(&n->picture, width, height, error) != 0)
        return -1;
    if (build(&n->model, (unsigned)atoi(values[5]), (unsigned)atoi(values[6]), &n->maps) != 0 ||
        native_window(&n->gl, &n->picture.stage, &n->texture, &n->target) != 0)
        return -1;
    block = cohsm_data(n->maps, &bytes);
    return pd_picture_maps(&n->picture, block, bytes, n->model.radius, error);
}

int main(int count, char **values)
{
    static native n;
    const pg_view view = { 0.9f, 0.35f, 3.6f, -0.1f };            /* product.js's at first */
    char error[EX_ERROR_SIZE] = "";
    int failed, frames;
    float turn;
    if (count != 10) return 2;
    frames = atoi(values[5]);
    turn = (float)atof(values[8]) * 3.14159265f / 180;
    failed = open_all(&n, values + 1, error);
    n.picture.stage.exposure = 0.9f / n.picture.stage.sky_light;
    for (int i = 0; i < frames && !failed; i++)
        failed = pd_picture_frame(&n.picture, &n.model, &view, turn, 4, i == 0, error);
    if (!failed) failed = native_save(&n.picture.stage, &n.target, values[9], error);
    if (failed) fprintf(stderr, "native: %s\n", error);
    return failed != 0;
}
