/* page.c - what the pages room, game, sky and filter call; their scenes are room.c, game.c, sky.c and filter.c, see stage.h. All
   functions that can fail return 0, or -1 with a line that pg_error returns. */
#include "stage.h"

#include <emscripten.h>
#include <emscripten/html5.h>
#include <stdio.h>
#include <string.h>

static struct page {
    glbk_context gl;
    pg_stage     stage;
    char         error[EX_ERROR_SIZE];
} page;

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

EMSCRIPTEN_KEEPALIVE const char *pg_error(void) { return page.error; }

/* The page has registered a WebGL 2 context and made it current. Handles are where they were before one was lost. */
EMSCRIPTEN_KEEPALIVE int pg_start(void)
{
    glbk_desc desc;
    glbk_result result;
    memset(&desc, 0, sizeof desc);
    page.error[0] = 0;
    desc.get_proc_fn = get_proc;
    desc.system.log = hear;
    result = glbk_init(&page.gl, &desc);
    if (result != GLBK_OK) return pg_failed("WebGL 2", result, page.error);
    if (pg_stage_create(&page.stage, &page.gl, page.error) != 0) return -1;
    return pg_scene_create(&page.stage, page.error);
}

/* After the context was lost: everything of GL is forgotten. pg_start begins anew. */
EMSCRIPTEN_KEEPALIVE void pg_lost(void)
{
    glbk_abandon(&page.gl);
    pg_scene_free(&page.stage);
    pg_stage_free(&page.stage);
    glbk_free(&page.gl);
}

EMSCRIPTEN_KEEPALIVE int pg_size(unsigned width, unsigned height)
{
    page.error[0] = 0;
    return pg_stage_resize(&page.stage, width, height, page.error);
}

/* Adds a frame to the mean, or begins a new one, and shows it. knobs: PG_KNOBS numbers. */
EMSCRIPTEN_KEEPALIVE int pg_frame(float azimuth, float elevation, float distance, float up, const float *knobs,
                                  float time, int anew)
{
    const pg_view view = { azimuth, elevation, distance, up };
    glbk_result result;
    page.error[0] = 0;
    if (anew) page.stage.frames = 0;
    pg_stage_look(&page.stage, pg_scene_model(), &view, 0);
    if (pg_scene_light(&page.stage, knobs, time, page.error) != 0) return -1;
    result = pg_stage_mix(&page.stage);
    if (result == GLBK_OK) result = pg_stage_show(&page.stage);
    return result == GLBK_OK ? 0 : pg_failed("a frame", result, page.error);
}

/* How many frames the mean has that is shown. */
EMSCRIPTEN_KEEPALIVE unsigned pg_frames(void) { return page.stage.frames; }

/* The pointer, see stage.h. press returns whether it took hold of something. */
EMSCRIPTEN_KEEPALIVE int  pg_press(float x, float y) { return pg_stage_press(&page.stage, x, y); }
EMSCRIPTEN_KEEPALIVE void pg_drag(float x, float y) { pg_stage_drag(&page.stage, x, y); }
EMSCRIPTEN_KEEPALIVE void pg_release(void) { page.stage.held = -1; }

/* Where the window of the last frame shows a point, two floats, -1..1. */
EMSCRIPTEN_KEEPALIVE const float *pg_window_at(float x, float y, float z)
{
    static float out[2];
    const float point[3] = { x, y, z };
    pg_stage_project(&page.stage, point, out);
    return out;
}

/* x, y, z of a handle and where the window shows it, five floats; NULL: there is none of this number. */
EMSCRIPTEN_KEEPALIVE const float *pg_handle_at(unsigned i)
{
    static float out[5];
    if (i >= page.stage.handle_count) return NULL;
    memcpy(out, page.stage.handles[i].position, 3 * sizeof *out);
    pg_stage_project(&page.stage, page.stage.handles[i].position, out + 3);
    return out;
}
