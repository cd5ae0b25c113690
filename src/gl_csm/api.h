/* ---- maps, lights, frames ---- */

GLBK_DEF void glbk_csm_maps_free(glbk_context *ctx, glbk_csm_maps *maps);
/* Deletes the maps' objects of GL and zeroes the struct. NULL is allowed. */

GLBK_DEF glbk_result glbk_csm_lights_update(glbk_context *ctx, glbk_csm_lights *lights, uint32_t start,
                                            const lsamp_light_desc *desc);
/* Replaces a light that has moved or changed, or whose desc->time went on. Its texture must have the size
   that it had, and its mesh as many triangles.
   start    what glbk_csm_lights_create wrote for it
   Errors   those of glbk_csm_lights_create. GLBK_ERR_ARGUMENT, too: start is that of no light with as many
            texels */

GLBK_DEF void glbk_csm_lights_free(glbk_context *ctx, glbk_csm_lights *lights);
/* Deletes the table and zeroes the struct. NULL is allowed. */

GLBK_DEF glbk_result glbk_csm_prepare(glbk_context *ctx, glbk_csm_renderer *renderer,
                                      const glbk_csm_frame_desc *desc);
/* Compiles the programs that such a frame needs, so that the first one does not stutter.
   Errors   those of glbk_csm_render that are not about the G-buffer */

GLBK_DEF void glbk_csm_reset(glbk_csm_renderer *renderer);
/* Forgets all frames: the next one begins the sum. Call it if the camera, a light or an object has moved.
   NULL is allowed. */

GLBK_DEF glbk_result glbk_csm_read(glbk_context *ctx, glbk_csm_renderer *renderer, float *rgba);
/* Waits for the GPU and reads the mean of the frames.
   rgba     receives 4 floats a pixel, rows from the bottom up: linear radiance, and how many samples of a
            frame were refused, because their light lies inside a hull
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the renderer was not created. GLBK_ERR_ORDER: there is no
            frame yet. Those of glbk_target_read */

GLBK_DEF glbk_result glbk_csm_renderer_resize(glbk_context *ctx, glbk_csm_renderer *renderer, uint32_t width,
                                              uint32_t height);
/* Gives the renderer another size, without frames. Its programs stay, whereas a new renderer would compile
   them anew, seconds on some drivers; so call it when a window has changed its size, with
   glbk_gbuffer_resize. Its textures are new ones.
   Errors   GLBK_ERR_ARGUMENT: the renderer is NULL or was not created. GLBK_ERR_DESC, GLBK_ERR_LIMIT: as for
            glbk_csm_renderer_create. After these it is as it was, after those of textures and targets it is
            freed and zeroed */

GLBK_DEF void glbk_csm_renderer_free(glbk_context *ctx, glbk_csm_renderer *renderer);
/* Deletes the renderer's objects of GL and zeroes the struct. NULL is allowed. */

/* ---- shaders of your own ----

   After glbk_csm_bind, shaders of your own ask the maps of a scene by lib/csm_visible.glsl:

       cohsm_query cohsm_ask(int light, int filtering, float bias);
       float csm_visible(uint entity, cohsm_query query, vec3 point, vec3 light);

   cohsm_ask takes a COHSM_LIGHT_..., a COHSM_FILTER_... and a bias in pixels of a map. csm_visible returns 1
   lit, 0 dark, something between with PCF, or -1 if the light lies inside an object's hull.

       entity   the instance that the point lies on, counted from 1; 0 = none
       point    world space
       light    COHSM_LIGHT_DIRECTION: the unit direction to it; _POSITION: a place in world space;
                _PARAMETER: its coordinates 0..1; _INDEX: the cell, as uintBitsToFloat(cell) in x

   With COHSM_FILTER_ROULETTE also set query.seed, and query.id to another number for each sample.
   docs/gpu-layouts.md has all layouts, for those who bring their own API. */

GLBK_DEF const glbk_part *glbk_csm_part(void);
/* Returns the GLSL of this header, for glbk_source.parts of a program of yours that uses its library
   files. */

GLBK_DEF void glbk_csm_bind(glbk_context *ctx, const glbk_csm_maps *maps, const glbk_offset *offset);
/* Binds textures and uniform block of the maps for a program of yours that uses lib/csm_visible.glsl and is
   bound (glbk_begin). A program that was compiled with maps->defines among its own is much faster, since it
   holds the code of one domain, one order and one orientation. Such a program gives right answers
   for maps with the same defines only.
   offset   what glbk_source.offsets gives this part in the program; NULL = none */

GLBK_DEF size_t glbk_csm_light_texels(const lsamp_light_desc *desc);
/* Returns how many texels, of 16 bytes each, a light takes in a table, or 0 if it is refused or desc is NULL.
   This call and the next need no context. They serve renderers on another API, whose shaders have
   lib/cohsm_light.glsl or a translation of it: examples/06b_csm_own_api.c; there LSAMP_LIGHT_CALLBACK and
   emission_fn are what your shader does with COHSM_OWN_LIGHT. This one has no log: the next says
   why a light is refused. */

GLBK_DEF glbk_result glbk_csm_light_write(const lsamp_light_desc *desc, uint32_t *words);
/* Writes a light as it stands in a table, at desc->time; docs/gpu-layouts.md has the layout.
   words    receives 4 words for each of glbk_csm_light_texels(desc) texels
   Errors   those of glbk_csm_lights_create, but for memory. desc->system.log is told which field is wrong;
            there is no log if desc is NULL */

/* ---- many questions at once ----

   An asker answers queries of points and lights in bulk, as cohsm_visible_scene does. If ctx->compute is set,
   it uses storage buffers, unless they may not be as large as 32 bytes a question; else a pass draws the
   answers into a texture. */

typedef struct glbk_csm_asker {     /* read only; zeroed = none */
    glbk_csm_programs programs;
    uint32_t     capacity;          /* the most questions */
    uint32_t     question;          /* private: 1 + 3 light_kind + filter of those uploaded; 0 = none */
    glbk_texture questions;         /* core path: questions and answers, the answers as the bits of floats,
                                       question i at (i & 1023, i >> 10) */
    glbk_texture answers;
    glbk_target  target;            /* private */
    glbk_buffer  frame;             /* private */
    glbk_buffer  asked;             /* compute path: questions and answers, a float each */
    glbk_buffer  answered;
} glbk_csm_asker;

GLBK_DEF glbk_result glbk_csm_asker_create(glbk_context *ctx, uint32_t capacity, glbk_csm_asker *out);
/* Makes room on the GPU for questions and their answers, which glbk_csm_asker_free takes back.
   capacity   the most questions at once, 1..2^22; 2^20 is what GL guarantees on the core path, whose answers
              are rows of 1024 texels, of which there are ctx->max_side at most
   Memory     36 bytes a question
   Errors     GLBK_ERR_ARGUMENT: a pointer is NULL, or capacity is out of range. Those of textures and
              buffers */

GLBK_DEF glbk_result glbk_csm_ask_upload(glbk_context *ctx, glbk_csm_asker *asker, const cohsm_query *query);
/* Uploads the points and lights of a query, 1 .. capacity of them. With COHSM_LIGHT_PARAMETER light_stride
   must be 12 or more, and three floats are read for each light, since the dimensions of the maps are not
   known yet.
   Memory   32 bytes a question while it runs
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, the asker was not created, or a count or stride is out of
            range. GLBK_ERR_DESC: light_kind, filter or bias is out of range. GLBK_ERR_LIMIT: query->count is
            above the capacity. GLBK_ERR_ALLOC */

GLBK_DEF glbk_result glbk_csm_ask_run(glbk_context *ctx, glbk_csm_asker *asker, const glbk_csm_maps *maps,
                                      uint32_t count);
/* Answers the first questions of those uploaded, on the GPU. The call may be repeated, with other maps, too.
   The first use of a combination of maps->defines, light_kind and filter compiles a program. Maps that cannot
   answer this kind of light give numbers without a meaning: ask cohsm_visible with the same query once, which
   returns COHSM_ERR_MISMATCH then.
   count    1 .. asker->capacity
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, an object was not created, or count is 0. GLBK_ERR_LIMIT:
            count is above the capacity. GLBK_ERR_ORDER: nothing was uploaded yet. Those of
            glbk_program_compile */

GLBK_DEF glbk_result glbk_csm_ask_read(glbk_context *ctx, glbk_csm_asker *asker, uint32_t count,
                                       float *visible);
/* Waits for the GPU and copies the first answers: 1 lit, 0 dark, something between with PCF, -1 if the light
   lies inside an object's hull.
   visible   receives count floats, count being 1 .. asker->capacity
   Errors    GLBK_ERR_ARGUMENT: a pointer is NULL, the asker was not created, or count is 0. GLBK_ERR_LIMIT:
             count is above the capacity. Those of glbk_buffer_read and glbk_target_read */

GLBK_DEF void glbk_csm_asker_free(glbk_context *ctx, glbk_csm_asker *asker);
/* Deletes the asker's objects of GL and zeroes the struct. NULL is allowed. */
