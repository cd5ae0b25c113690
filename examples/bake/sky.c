/* sky.c - bake shadowfield --set kind=sky: a distant sky shines on all places alike, so that its field has no shells
   but one cube, whose harmonics are bands^2 numbers a channel. They are written as JSON, for shaders. */
#include "shadowfield.h"
#include "bake.h"
#include "glb.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The settings that say something about a sky; all others must be as they are unless set. */
static int check(const bk_args *args, char *error)
{
    const rd_settings *s = &args->settings;
    for (const rd_key *k = bk_shadowfield.keys; k->name; k++)
        if (strcmp(k->name, "kind") != 0 && strcmp(k->name, "bands") != 0 && !rd_setting_is(s, k->name, k->standard))
            return bk_fail(error, "kind=sky: harmonics of so many bands= are all that it has, without ", k->name);
    if (args->shards > 1 || args->node[0])
        return bk_fail(error, "kind=sky: it has neither shards nor nodes", "");
    return 0;
}

/* Coefficients of all channels, for free(), of a sky as the scene of shadowfield.h has it. */
static int project(const ex_sky *sky, uint32_t bands, float **coefs, char *error)
{
    sfield_scene_desc d;
    sfield_scene *scene = NULL;
    sfield_result result;
    memset(&d, 0, sizeof d);
    d.bands = bands;
    *coefs = calloc(3 * (size_t)bands * bands, sizeof **coefs);
    if (!*coefs)
        return bk_fail(error, "out of memory", "");
    result = sfield_scene_create(&d, &scene);
    if (result == SFIELD_OK)
        result = sfield_scene_environment(scene, sky->rgb, (uint32_t)sky->width, (uint32_t)sky->height, NULL);
    if (result == SFIELD_OK)
        result = sfield_scene_sky(scene, *coefs);
    sfield_scene_free(scene);
    return result == SFIELD_OK ? 0 : bk_fail(error, "kind=sky: ", sfield_result_text(result));
}

int bk_sky_run(const bk_args *args, char *error)
{
    static const char *const begin[] = { "{\"kind\":\"sky\",\"bands\":%u,\"coefficients\":[\n[", "],\n[", "],\n[" };
    const char *path = args->files[0];
    const uint32_t bands = (uint32_t)rd_setting_integer(&args->settings, "bands"), n = bands * bands;
    bk_text text = { NULL, 0, 0, 0 };
    float *coefs = NULL;
    ex_sky sky;
    int result;
    if (check(args, error) != 0)
        return -1;
    if ((strncmp(path, "builtin:", 8) ? ex_sky_load(&sky, path, error) : ex_sky_builtin(&sky, path + 8, error)) != 0)
        return -1;
    result = project(&sky, bands, &coefs, error);
    ex_sky_free(&sky);
    for (uint32_t i = 0; i < 3 * n && result == 0; i++) {
        if (i % n == 0)
            bk_text_add(&text, begin[i / n], (unsigned)bands);
        bk_text_add(&text, "%s%.9g", i % n ? "," : "", (double)coefs[i]);
    }
    bk_text_add(&text, "]]}\n");
    if (result == 0)
        result = text.failed ? bk_fail(error, "out of memory", "") : bk_write(args->out, text.bytes, text.size, error);
    free(text.bytes);
    free(coefs);
    return result;
}
