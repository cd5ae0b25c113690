/* native_scene.c - what the pages room, game, sky and filter draw, by the same code on a GL context of this machine,
   each a program of its own: native_NAME WIDTH HEIGHT FRAMES TIME AZIMUTH ELEVATION DISTANCE UP OUT.png KNOB...
   tests/web/pages.mjs compares the page's picture with it. With EXACT=PATHS in the environment OUT.png is what a path
   tracer has for it, of so many paths a pixel. */
#include "exact.h"
#include "native.h"

static int draw(pg_stage *stage, const pg_view *view, const float knobs[PG_KNOBS], float time, char *error)
{
    glbk_result result;
    pg_stage_look(stage, pg_scene_model(), view, 0);
    if (pg_scene_light(stage, knobs, time, error) != 0) return -1;
    result = pg_stage_mix(stage);
    if (result == GLBK_OK) result = pg_stage_show(stage);
    return result == GLBK_OK ? 0 : pg_failed("a frame", result, error);
}

/* A frame sets exposure and backdrop, and moves what moves; for a path tracer a few pixels of it do. */
static int draw_small(pg_stage *stage, const pg_view *view, const float knobs[PG_KNOBS], float time, char *error)
{
    if (pg_stage_resize(stage, 16, 9, error) != 0) return -1;
    pg_stage_look(stage, pg_scene_model(), view, 0);
    return pg_scene_light(stage, knobs, time, error);
}

static int draw_exact(pg_stage *stage, const pg_view *view, const float knobs[PG_KNOBS], const char *paths, char *error)
{
    pg_lights lights;
    int result = pg_scene_lights(stage, knobs, &lights, error);
    if (result != 0) return -1;
    result = exact_show(stage, pg_scene_model(), view, &lights, (uint32_t)atoi(paths), error);
    ex_sky_free(&lights.sky);
    return result;
}

int main(int count, char **values)
{
    static glbk_context gl;
    static pg_stage stage;
    glbk_texture texture;
    glbk_target target;
    float knobs[PG_KNOBS] = { 0 };
    char error[EX_ERROR_SIZE] = "";
    pg_view view;
    const char *paths = getenv("EXACT");
    int failed;
    if (count < 10 || count > 10 + PG_KNOBS) return 2;
    view.azimuth = (float)atof(values[5]);
    view.elevation = (float)atof(values[6]);
    view.distance = (float)atof(values[7]);
    view.up = (float)atof(values[8]);
    for (int i = 10; i < count; i++) knobs[i - 10] = (float)atof(values[i]);
    failed = native_open(&gl, error) != 0 || pg_stage_create(&stage, &gl, error) != 0 ||
             pg_scene_create(&stage, error) != 0 ||
             (paths && draw_small(&stage, &view, knobs, (float)atof(values[4]), error) != 0) ||
             pg_stage_resize(&stage, (uint32_t)atoi(values[1]), (uint32_t)atoi(values[2]), error) != 0 ||
             native_window(&gl, &stage, &texture, &target) != 0;
    for (int i = 0; i < atoi(values[3]) && !failed && !paths; i++)
        failed = draw(&stage, &view, knobs, (float)atof(values[4]), error) != 0;
    if (!failed && paths) failed = draw_exact(&stage, &view, knobs, paths, error) != 0;
    if (!failed) failed = native_save(&stage, &target, values[9], error) != 0;
    if (failed) fprintf(stderr, "%s: %s\n", values[0], error);
    return failed;
}
