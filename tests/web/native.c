/* native.c - what the page "product" draws, by the same code on a GL context of this machine: native MODEL SKY WIDTH
   HEIGHT FRAMES SIDE MAP_SIDE TURN OUT.png. tests/web/pages.mjs compares the page's picture with it. SKY may be
   builtin:NAME, too. With EXACT=PATHS in the environment OUT.png is what a path tracer has for it, of so many paths a
   pixel. */
#include "../../web/product.h"
#include "exact.h"
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
    desc.orientation = COHSM_ORIENTATION_POLAR;
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

static int load_sky(ex_sky *sky, const char *name, char *error)
{
    static const char builtin[] = "builtin:";
    if (strncmp(name, builtin, sizeof builtin - 1) == 0) return ex_sky_builtin(sky, name + sizeof builtin - 1, error);
    return ex_sky_load(sky, name, error);
}

/* The arguments from MODEL to MAP_SIDE. */
static int open_all(native *n, char **values, char *error)
{
    const uint32_t width = (uint32_t)atoi(values[2]), height = (uint32_t)atoi(values[3]);
    const void *block;
    size_t bytes;
    if (native_open(&n->gl, error) != 0) return -1;
    if (pd_picture_create(&n->picture, &n->gl, error) != 0 || pd_model_load(&n->model, values[0], error) != 0 ||
        pg_model_upload(&n->model, &n->gl, error) != 0 || load_sky(&n->sky, values[1], error) != 0 ||
        pd_picture_sky(&n->picture, &n->sky, error) != 0 ||
        pd_picture_resize(&n->picture, width, height, error) != 0)
        return -1;
    if (native_window(&n->gl, &n->picture.stage, &n->texture, &n->target) != 0) return -1;
    if (getenv("EXACT")) return 0;                                /* needs no maps */
    if (build(&n->model, (unsigned)atoi(values[5]), (unsigned)atoi(values[6]), &n->maps) != 0) return -1;
    block = cohsm_data(n->maps, &bytes);
    return pd_picture_maps(&n->picture, block, bytes, n->model.radius, error);
}

/* The page turns the scene below a sky that rests; here the sky is turned. */
static int draw_exact(native *n, const pg_view *view, const char *sky, float turn, const char *paths, char *error)
{
    pg_lights lights;
    int result;
    memset(&lights, 0, sizeof lights);
    lights.full = 1;
    if (pg_lights_sky(&lights, sky, turn, error) != 0) return -1;
    result = exact_show(&n->picture.stage, &n->model, view, &lights, (uint32_t)atoi(paths), error);
    ex_sky_free(&lights.sky);
    return result;
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
    for (int i = 0; i < frames && !failed && !getenv("EXACT"); i++)
        failed = pd_picture_frame(&n.picture, &n.model, &view, turn, 4, i == 0, error);
    if (!failed && getenv("EXACT")) failed = draw_exact(&n, &view, values[2], turn, getenv("EXACT"), error);
    if (!failed) failed = native_save(&n.picture.stage, &n.target, values[9], error);
    if (failed) fprintf(stderr, "native: %s\n", error);
    return failed != 0;
}
