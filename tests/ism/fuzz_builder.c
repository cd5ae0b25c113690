/* fuzz_builder - libFuzzer target: bytes choose a desc, sources, a mesh and a view; two frames are rendered by all
   stages, and what comes out must be finite and not negative. The last bytes choose odd services (kit/odd.h), by which
   the same is rendered. */

#define ISM_STATIC
#define ISM_IMPLEMENTATION
#include "ism.h"
#include "input.h"
#include "odd.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void take_desc(input *in, ism_desc *d)
{
    memset(d, 0, sizeof *d);
    d->vpl_count = 1 + take(in) % 20;
    d->surfel_count = 8 + take(in);
    d->tile_side = 8u << take(in) % 3;
    d->importance = (ism_importance)(take(in) % (ISM_IMPORTANCE_COUNT + 1));
    d->spread = (ism_spread)(take(in) % (ISM_SPREAD_COUNT + 1));
    d->projection = (ism_projection)(take(in) % (ISM_PROJECTION_COUNT + 1));
    d->view_grid_side = take(in) % 5;
    d->blur_radius = (int32_t)(take(in) % 4u);
    d->lazy_frames = take(in) % 9;
    d->unstable = (int)(take(in) & 1u);
    d->vary_surfels = (int)(take(in) & 1u);
    d->keep_hits = (int)(take(in) & 1u);        /* 0: with windows */
    d->splat_scale = (float)(take(in) % 17);
    d->window_rim = (int32_t)(take(in) % 4u);
    d->window_rim = d->window_rim == 1 ? (int32_t)d->tile_side / 2 : d->window_rim;
}

/* Two frames, the mesh moved between. A frame that a service failed is rendered again, with what it had begun. */
static void render(odd *o, const ism_desc *d, const ism_frame *frames, const ism_mesh *mesh, float *positions,
                   const ism_shading *shading)
{
    static float bounced[3][3 * 20 * 64], out[3 * 32];
    ism_frame frame = *frames;
    ism_maps *maps;
    ism_result result;
    uint32_t i;
    ODD_TRY(o, result, ism_create(d, &maps));
    if (result != ISM_OK) return;
    for (frame.index = 0; frame.index < 2; frame.index++) {
        ODD_TRY(o, result, ism_render(maps, &frame, shading, out, NULL));
        odd_keep_result(o, (int)result);
        if (result != ISM_OK) continue;
        odd_keep(o, out, sizeof out);
        for (i = 0; i < 96; i++)
            if (!(out[i] >= 0.0f)) abort();
        ODD_TRY(o, result, ism_bounce(maps, mesh, 8, bounced[0], bounced[1], bounced[2]));
        odd_keep_result(o, (int)result);
        for (i = 0; i < 72; i++) positions[i] += 0.01f;
    }
    ism_free(maps);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in;
    odd o, none;
    ism_desc d;
    ism_maps *maps;
    ism_mesh mesh;
    ism_source source[2];
    ism_points view;
    ism_frame frame;
    ism_shading shading = { 0 };
    float positions[3 * 24], opacities[8], lit[3][3 * 16], lobes[4 * 16], eye[3][3 * 32];
    float still[3 * 24];
    uint32_t indices[24], i, k;

    in = input_of(data, size);
    take_desc(&in, &d);
    if (ism_create(&d, &maps) != ISM_OK) return 0;
    ism_free(maps);
    memset(&mesh, 0, sizeof mesh);
    memset(source, 0, sizeof source);
    memset(&view, 0, sizeof view);
    for (i = 0; i < 72; i++) positions[i] = take_float(&in);
    for (i = 0; i < 24; i++) indices[i] = take(&in) % 25u;
    for (i = 0; i < 8; i++) opacities[i] = take_float(&in);
    for (i = 0; i < 48; i++) {
        lit[0][i] = take_float(&in);
        lit[1][i] = i % 3 == take(&in) % 3u ? 1.0f : 0.0f;
        lit[2][i] = take_float(&in);
        if (!(lit[2][i] < 1e10f)) lit[2][i] = 1;         /* light without bounds has no finite sum */
    }
    for (i = 0; i < 64; i++) lobes[i] = i % 4 == 3 ? (float)take(&in) : i % 4 == 1 ? 1.0f : 0.0f;
    for (i = 0; i < 96; i++) {
        eye[0][i] = take_float(&in);
        eye[1][i] = i % 3 == i / 3 % 3 ? 1.0f : 0.0f;
        eye[2][i] = take_float(&in);
    }
    mesh.positions = positions;
    mesh.vertex_count = 24;
    mesh.index_count = 3 * (take(&in) % 9u);
    if (take(&in) & 1u) mesh.indices = indices;
    if (take(&in) & 1u) mesh.opacities = opacities;
    for (k = 0; k < 2; k++) {
        source[k].kind = k ? ISM_SOURCE_DIRECTIONS : ISM_SOURCE_SURFACE;
        source[k].width = source[k].height = 4;
        source[k].positions = k ? lit[1] : lit[0];
        source[k].normals = lit[1];
        source[k].fluxes = lit[2];
        if (take(&in) & 1u) source[k].lobes = lobes;
        source[k].scattered = (int)(take(&in) & 1u);
    }
    view.positions = eye[0];
    view.normals = eye[1];
    view.albedos = take(&in) & 1u ? eye[1] : NULL;
    view.count = 8 * 4;
    view.width = 8;
    for (i = 0; i < 16; i++) view.world_to_clip[i] = take(&in) & 1u ? take_float(&in) : 0.0f;
    view.rows = ISM_ROWS_TOP_FIRST;
    frame.mesh = &mesh;
    frame.sources = source;
    frame.source_count = take(&in) % 3u;
    frame.points = &view;
    shading.interleave = take(&in) % 4u;
    shading.near_mode = (ism_near)(take(&in) % (ISM_NEAR_NONE));     /* NONE may be infinite */
    shading.cull = (int)(take(&in) & 1u);
    frame.index = 0;
    memcpy(still, positions, sizeof still);
    odd_take(&none, NULL, 0);
    render(&none, &d, &frame, &mesh, positions, &shading);
    memcpy(positions, still, sizeof still);
    odd_take(&o, data, size);
    ODD_SYSTEM(&d.system, &o);
    render(&o, &d, &frame, &mesh, positions, &shading);
    if (!o.failures && o.hash != none.hash) ODD_ABORT("odd services change the light");
    odd_done(&o);
    return 0;
}
