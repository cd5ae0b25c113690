/* product.c - what the page "product" calls, see product.h. All functions return 0, or -1 with a line that pd_error
   returns. Only one picture and one model are there at a time. */
#include "product.h"

#include <emscripten.h>
#include <emscripten/html5.h>
#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_BYTES = 512 << 20 };    /* of maps that are laid out for speed */

static struct product {
    glbk_context gl;
    pd_picture   picture;
    pg_model     model;
    cohsm_maps  *maps;              /* of the last build or pd_open */
    void        *packed;            /* the same, of the last pd_pack, and its bytes */
    size_t       packed_bytes;
    int          has_gl;
    char         error[EX_ERROR_SIZE];
} page;

/* The page is told how far a build is; not 0 ends it. */
EM_JS(int, tell_progress, (float fraction), { return Module.onProgress && Module.onProgress(fraction) ? 1 : 0; })

static int progress(void *user, float fraction)
{
    (void)user;
    return tell_progress(fraction);
}

static void hear(void *user, const char *message)
{
    (void)user;
    snprintf(page.error, sizeof page.error, "%s", message);
}

static glbk_proc_fn get_proc(const char *name, void *user)
{
    (void)user;
    return (glbk_proc_fn)emscripten_webgl_get_proc_address(name);
}

EMSCRIPTEN_KEEPALIVE const char *pd_error(void) { return page.error; }

/* ---- the picture ---- */

/* context: a WebGL 2 context that the page has registered and made current. */
EMSCRIPTEN_KEEPALIVE int pd_start(void)
{
    glbk_desc desc;
    glbk_result result;
    memset(&desc, 0, sizeof desc);
    page.error[0] = 0;
    desc.get_proc_fn = get_proc;
    desc.system.log = hear;
    result = glbk_init(&page.gl, &desc);
    if (result != GLBK_OK) {
        if (!page.error[0]) snprintf(page.error, sizeof page.error, "WebGL 2: %s", glbk_result_text(result));
        return -1;
    }
    page.has_gl = 1;
    return pd_picture_create(&page.picture, &page.gl, page.error);
}

/* After the context was lost: everything of GL is forgotten. pd_start, pd_size, pd_sky, pd_show begin anew. */
EMSCRIPTEN_KEEPALIVE void pd_lost(void)
{
    glbk_abandon(&page.gl);
    pd_picture_free(&page.picture);
    pg_model_free(&page.model, &page.gl);
    glbk_free(&page.gl);
    memset(&page.picture, 0, sizeof page.picture);
    page.has_gl = 0;
}

EMSCRIPTEN_KEEPALIVE int pd_size(unsigned width, unsigned height)
{
    page.error[0] = 0;
    return pd_picture_resize(&page.picture, width, height, page.error);
}

/* builtin:NAME, or the path of a .hdr file; "dark": of two texels, to begin with. */
EMSCRIPTEN_KEEPALIVE int pd_sky(const char *path)
{
    static const char builtin[] = "builtin:";
    ex_sky sky;
    int result;
    page.error[0] = 0;
    memset(&sky, 0, sizeof sky);
    if (strcmp(path, "dark") == 0) {
        static float texels[6] = { 0.1f, 0.1f, 0.1f, 0.1f, 0.1f, 0.1f };
        sky.width = 2;
        sky.height = 1;
        sky.rgb = texels;
        return pd_picture_sky(&page.picture, &sky, page.error);
    }
    if (strncmp(path, builtin, sizeof builtin - 1) == 0)
        result = ex_sky_builtin(&sky, path + sizeof builtin - 1, page.error);
    else result = ex_sky_load(&sky, path, page.error);
    if (result == 0) result = pd_picture_sky(&page.picture, &sky, page.error);
    ex_sky_free(&sky);
    return result;
}

/* ---- model and maps ---- */

/* The model that was there stays if the file cannot be read. */
EMSCRIPTEN_KEEPALIVE int pd_load(const char *path)
{
    pg_model fresh;
    page.error[0] = 0;
    if (pd_model_load(&fresh, path, page.error) != 0) return -1;
    if (page.has_gl && pg_model_upload(&fresh, &page.gl, page.error) != 0) {
        pg_model_free(&fresh, &page.gl);
        return -1;
    }
    pg_model_free(&page.model, &page.gl);
    page.model = fresh;
    return 0;
}

EMSCRIPTEN_KEEPALIVE unsigned pd_triangles(void) { return (unsigned)ex_scene_triangles(&page.model.scene); }

/* Maps of a mesh. All have one order and one orientation, so that one program asks those of every model. */
static int build_maps(cohsm_desc *desc, const cohsm_mesh *mesh)
{
    cohsm_result result;
    desc->system.log = hear;
    desc->order = COHSM_ORDER_HILBERT;
    desc->orientation = COHSM_ORIENTATION_POLAR;
    cohsm_free(page.maps);
    page.maps = NULL;
    result = cohsm_build(desc, mesh, &page.maps, NULL);
    if (result == COHSM_OK) return 0;
    if (!page.error[0]) snprintf(page.error, sizeof page.error, "%s", cohsm_result_text(result));
    return -1;
}

/* Builds the maps of the model that is loaded. What the numbers mean: cohsm_desc. */
EMSCRIPTEN_KEEPALIVE int pd_build(unsigned side, unsigned map_side, unsigned layers, unsigned depth_bits,
                                  float open_thickness)
{
    cohsm_desc desc;
    cohsm_mesh mesh;
    float *positions;
    uint32_t *indices;
    int result;
    memset(&desc, 0, sizeof desc);
    memset(&mesh, 0, sizeof mesh);
    page.error[0] = 0;
    if (pg_model_merge(&page.model, &positions, &mesh.vertex_count, &indices, &mesh.index_count) != 0) {
        snprintf(page.error, sizeof page.error, "out of memory");
        return -1;
    }
    mesh.positions = positions;
    mesh.indices = indices;
    desc.system.progress = progress;
    desc.domain.side[0] = desc.domain.side[1] = side;
    desc.map_side = map_side;
    desc.layers = (cohsm_layers)layers;
    desc.depth_bits = depth_bits;
    desc.open_thickness = open_thickness;
    result = build_maps(&desc, &mesh);
    free(positions);
    free(indices);
    return result;
}

EMSCRIPTEN_KEEPALIVE const void *pd_block(void)
{
    size_t bytes;
    return page.maps ? cohsm_data(page.maps, &bytes) : NULL;
}

EMSCRIPTEN_KEEPALIVE size_t pd_block_bytes(void)
{
    size_t bytes = 0;
    if (page.maps) cohsm_data(page.maps, &bytes);
    return bytes;
}

/* Packs the maps: half as many bytes, which pd_open takes as well. For web/first.cjs; the page does not call it. */
EMSCRIPTEN_KEEPALIVE int pd_pack(void)
{
    cohsm_result result;
    free(page.packed);
    page.packed = NULL;
    page.packed_bytes = 0;
    result = cohsm_pack(page.maps, NULL, &page.packed, &page.packed_bytes);
    if (result == COHSM_OK) return 0;
    snprintf(page.error, sizeof page.error, "%s", cohsm_result_text(result));
    return -1;
}

EMSCRIPTEN_KEEPALIVE const void *pd_packed(void) { return page.packed; }
EMSCRIPTEN_KEEPALIVE size_t      pd_packed_bytes(void) { return page.packed_bytes; }

/* Takes a block, whose bytes may go afterwards, as the maps of the model that is loaded. It may be anybody's file:
   csm.h checks it. fast: they are laid out for speed, unless they are too large so. */
EMSCRIPTEN_KEEPALIVE int pd_open(const void *data, size_t bytes, int fast)
{
    const cohsm_layout layout = fast ? COHSM_LAYOUT_BUDGET : COHSM_LAYOUT_COMPACT;
    const void *block;
    cohsm_system system;
    cohsm_maps *maps;
    cohsm_result result;
    memset(&system, 0, sizeof system);
    page.error[0] = 0;
    system.log = hear;
    result = cohsm_open_as(data, bytes, layout, MOST_BYTES, &system, &maps);
    if (result != COHSM_OK) {
        if (!page.error[0]) snprintf(page.error, sizeof page.error, "%s", cohsm_result_text(result));
        return -1;
    }
    cohsm_free(page.maps);
    page.maps = maps;
    block = cohsm_fast_data(maps, &bytes);
    if (!block) block = cohsm_data(maps, &bytes);       /* a packed file is unpacked now */
    return pd_picture_maps(&page.picture, block, bytes, page.model.radius, page.error);
}

/* Bytes that are taken of the program's memory, for tests. */
EMSCRIPTEN_KEEPALIVE unsigned pd_memory(void) { return (unsigned)mallinfo().uordblks; }

/* ---- frames ---- */

EMSCRIPTEN_KEEPALIVE int pd_frame(float azimuth, float elevation, float distance, float up, float sky_turn,
                                  float exposure, unsigned samples, int show_sky, int anew)
{
    const pg_view view = { azimuth, elevation, distance, up };
    page.error[0] = 0;
    page.picture.stage.exposure = 0.9f * exposure / page.picture.stage.sky_light;
    page.picture.stage.show_sky = show_sky;
    return pd_picture_frame(&page.picture, &page.model, &view, sky_turn, samples, anew, page.error);
}

/* How maps are asked and lights sampled from now on: see pd_question. */
EMSCRIPTEN_KEEPALIVE void pd_ask(int filter, float bias, float offset, int sampling)
{
    page.picture.how.filter = (cohsm_filter)filter;
    page.picture.how.bias = bias;
    page.picture.how.offset = offset;
    page.picture.how.sampling = (lsamp_sampling)sampling;
}

/* How many frames the mean has that is shown. */
EMSCRIPTEN_KEEPALIVE unsigned pd_frames(void) { return page.picture.stage.frames; }
