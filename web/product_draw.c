/* product_draw.c - see product.h: the light of a frame.

   The sky stays where it is, and the scene and the camera turn the other way: to see a sky turn is the same, and the
   table of its light need not be made anew. So transforms below go to the space in which the sky rests. */
#include "product.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

int pd_model_load(pg_model *model, const char *path, char *error)
{
    static const char builtin[] = "builtin:";
    ex_scene scene;
    memset(model, 0, sizeof *model);
    if (strncmp(path, builtin, sizeof builtin - 1) == 0) {
        if (ex_scene_builtin(&scene, path + sizeof builtin - 1, 0, error) != 0) return -1;
    } else {
        ex_normal_maps = 1;
        if (ex_scene_load(&scene, path, error) != 0) return -1;
    }
    return pg_model_take(model, &scene, 1, error);
}

/* ---- what stays ---- */

int pd_picture_create(pd_picture *p, glbk_context *gl, char *error)
{
    memset(p, 0, sizeof *p);
    p->how.filter = COHSM_FILTER_ROULETTE;
    p->how.offset = 0.01f;
    return pg_stage_create(&p->stage, gl, error);
}

void pd_picture_free(pd_picture *p)
{
    glbk_csm_renderer_free(p->stage.gl, &p->renderer);
    glbk_csm_lights_free(p->stage.gl, &p->lights);
    glbk_csm_maps_free(p->stage.gl, &p->maps);
    pg_stage_free(&p->stage);
}

int pd_picture_resize(pd_picture *p, uint32_t width, uint32_t height, char *error)
{
    glbk_csm_renderer_desc desc;
    glbk_result result = GLBK_OK;
    if (pg_stage_resize(&p->stage, width, height, error) != 0) return -1;
    if (p->renderer.width == width && p->renderer.height == height) return 0;
    memset(&desc, 0, sizeof desc);
    desc.width = width;
    desc.height = height;
    if (p->renderer.width) result = glbk_csm_renderer_resize(p->stage.gl, &p->renderer, width, height);
    else result = glbk_csm_renderer_create(p->stage.gl, &desc, &p->renderer);
    return result == GLBK_OK ? 0 : pg_failed("the picture's textures", result, error);
}

int pd_picture_maps(pd_picture *p, const void *data, size_t bytes, float radius, char *error)
{
    glbk_csm_block block = { data, bytes };
    glbk_csm_instance instance;
    glbk_csm_maps maps;
    glbk_result result;
    memset(&instance, 0, sizeof instance);
    result = glbk_csm_maps_create(p->stage.gl, &block, 1, 1, &instance.start, &maps);
    if (result != GLBK_OK) return pg_failed("the maps", result, error);
    glbk_csm_maps_free(p->stage.gl, &p->maps);
    p->maps = maps;
    p->stage.frames = 0;
    p->radius = radius;
    return 0;
}

int pd_picture_sky(pd_picture *p, const ex_sky *sky, char *error)
{
    glbk_csm_lights_desc lights;
    glbk_csm_lights fresh;
    lsamp_light_desc light;
    glbk_result result;
    uint32_t start;
    float *texels;
    memset(&lights, 0, sizeof lights);
    memset(&light, 0, sizeof light);
    if (pg_stage_sky(&p->stage, sky, &texels, &light.width, &light.height, error) != 0) return -1;
    light.kind = LSAMP_LIGHT_ENVIRONMENT;
    light.radiance[0] = light.radiance[1] = light.radiance[2] = 1;
    light.texels = texels;
    lights.lights = &light;
    lights.light_count = 1;
    result = glbk_csm_lights_create(p->stage.gl, &lights, &start, &fresh);
    free(texels);
    if (result != GLBK_OK) return pg_failed("the sky", result, error);
    glbk_csm_lights_free(p->stage.gl, &p->lights);
    p->lights = fresh;
    p->sky_start = start;
    return 0;
}

/* ---- a frame ---- */

static glbk_result shade(pd_picture *p, const pg_model *model, uint32_t samples, const float transform[16])
{
    glbk_csm_use use;
    glbk_csm_frame_desc desc;
    glbk_csm_instance instance;
    glbk_pass pass;
    glbk_result result;
    memset(&use, 0, sizeof use);
    memset(&desc, 0, sizeof desc);
    memset(&instance, 0, sizeof instance);
    memset(&pass, 0, sizeof pass);
    memcpy(instance.transform, transform, sizeof instance.transform);
    instance.offset = p->how.offset * p->radius;
    result = glbk_csm_maps_place(p->stage.gl, &p->maps, &instance, 1);
    use.start = p->sky_start;
    use.kind = LSAMP_LIGHT_ENVIRONMENT;
    use.maps = &p->maps;
    use.sample_count = samples ? samples : 8;
    desc.lights = &p->lights;
    desc.uses = &use;
    desc.use_count = 1;
    memcpy(desc.eye, p->stage.camera.eye, sizeof desc.eye);
    desc.planes[0][1] = 1;
    desc.planes[0][3] = model->ground;
    desc.plane_count = 1;
    desc.filter = p->how.filter;
    desc.bias = p->how.bias;
    desc.sampling = p->how.sampling;
    desc.frame = p->stage.frames;
    glbk_csm_reset(&p->renderer);
    if (result == GLBK_OK) result = glbk_csm_render(p->stage.gl, &p->renderer, &p->stage.seen, &desc);
    pass.target = &p->stage.light_target;
    return result == GLBK_OK ? glbk_csm_resolve(p->stage.gl, &p->renderer, &p->stage.seen, &pass, NULL) : result;
}

int pd_picture_frame(pd_picture *p, const pg_model *model, const pg_view *view, float sky_turn, uint32_t samples,
                     int anew, char *error)
{
    const float co = cosf(-sky_turn), si = sinf(-sky_turn);
    const float transform[16] = { co, 0, -si, 0, 0, 1, 0, 0, si, 0, co, 0, 0, 0, 0, 1 };
    glbk_result result;
    if (!p->maps.blocks.name || !p->lights.texels.name || !model->parts) return 0;
    if (anew) p->stage.frames = 0;
    pg_stage_look(&p->stage, model, view, -sky_turn);
    result = pg_stage_draw(&p->stage, model, transform, 0);
    if (result == GLBK_OK) result = shade(p, model, samples, transform);
    if (result == GLBK_OK) result = pg_stage_mix(&p->stage);
    if (result == GLBK_OK) result = pg_stage_show(&p->stage);
    return result == GLBK_OK ? 0 : pg_failed("a frame", result, error);
}
