/* ---- the steps of glbk_envsh_illuminate ---- */

GLBK_DEF glbk_result glbk_envsh_maps_render(glbk_context *ctx, glbk_envsh_maps *maps, const envsh_view *views,
                                            uint32_t count, glbk_envsh_draw_fn draw_fn, void *user);
/* Draws the shadow maps of a frame, and what is known of their cells.
   views    those of envsh_views, of an envsh_maps_desc with the same map_side and guard as the desc of
            these maps. Where the views say that their tiles lie plays no part
   count    at most the capacity; 0 = no light
   draw_fn  draws what casts shadows; user is given to it
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the maps were not created. GLBK_ERR_LIMIT: count is above
            the capacity. GLBK_ERR_MISMATCH: the views are for tiles of another size or guard. What draw_fn
            returned. With desc.check of the context GLBK_ERR_ORDER: draw_fn did not call glbk_envsh_cast, or
            drew fewer instances of a caster than it was given. To find that out, the maps are drawn once more
            with the instances in the opposite order, and both results are read back and compared. A draw_fn
            that draws nothing at all is not noticed, since all casters may lie beyond the bounds */

GLBK_DEF glbk_result glbk_envsh_shade(glbk_context *ctx, glbk_envsh_renderer *renderer,
                                      const glbk_gbuffer *gbuffer, glbk_envsh_maps *maps,
                                      const envsh_query *query, uint32_t lights_per_pass);
/* Computes the irradiance that each pixel gets from the lights whose maps glbk_envsh_maps_render drew last:
   the sum of visibility times cosine times the light's own irradiance. The sum replaces the light that the
   renderer has or, with query->add, is added to it. The first use of a filter compiles a program.
   gbuffer          the points that are lit, of the renderer's size
   query            how the maps are filtered; NULL = all defaults
   lights_per_pass  how many lights one pass adds up; 0 = all, as in the paper. Give fewer if the driver stops
                    passes that take long
   Cost             grows with pixels, lights and the query's taps; taps are spared if all texels about them
                    are on one side of the point
   Errors           GLBK_ERR_ARGUMENT: a pointer is NULL, or an object was not created. GLBK_ERR_DESC: a field
                    of the query is out of range. GLBK_ERR_MISMATCH: the G-buffer has another size. Those of
                    glbk_program_compile at first use */

GLBK_DEF glbk_result glbk_envsh_read(glbk_context *ctx, glbk_envsh_renderer *renderer, float *rgba);
/* Reads the irradiance, W/m^2, back to the CPU, and waits for the GPU meanwhile.
   rgba     gets 4 floats for each pixel, row 0 of the G-buffer first; the last of four is 0
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the renderer was not created. GLBK_ERR_LOST */

GLBK_DEF void glbk_envsh_maps_free(glbk_context *ctx, glbk_envsh_maps *maps);
/* Frees what glbk_envsh_maps_create made, and zeroes the struct. NULL and zeroed maps are allowed. */

GLBK_DEF glbk_result glbk_envsh_renderer_resize(glbk_context *ctx, glbk_envsh_renderer *renderer,
                                                uint32_t width, uint32_t height);
/* Gives the renderer another size, without what it had drawn. Its programs stay, whereas a new renderer would
   compile them anew; so call it when a window has changed its size, with glbk_gbuffer_resize. Its textures
   are new ones.
   Errors   GLBK_ERR_ARGUMENT: the renderer is NULL or was not created. GLBK_ERR_DESC, GLBK_ERR_LIMIT: as for
            glbk_envsh_renderer_create. After these it is as it was, after those of textures and targets
            it is freed and zeroed */

GLBK_DEF void glbk_envsh_renderer_free(glbk_context *ctx, glbk_envsh_renderer *renderer);
/* Frees what glbk_envsh_renderer_create made, and zeroes the struct. NULL and a zeroed renderer are
   allowed. */

/* ---- shaders of your own ----

   After glbk_envsh_bind they call these functions of lib/envsh_light.glsl:

       vec3 envsh_light(vec3 p, vec3 n, vec3 flat_n, uint index);  // irradiance by all lights, W/m^2
       float envsh_visible(envsh_query q, uint light, vec3 p, vec3 n, uint index);     // 0 hidden .. 1 seen
       envsh_query envsh_bound_query();                            // the query that was bound
       vec3 envsh_direction(uint light);                           // unit, to the light
       vec3 envsh_power(uint light);                               // its irradiance where it is faced, W/m^2

   p is a point in world space. Normals are unit and on the side that is seen: n of envsh_light is the shading
   normal, flat_n and n of envsh_visible are the surface's own. index turns the pattern of taps: give each
   pixel another one. glbk_envsh_scene.light_count is the number of lights. docs/gpu-layouts.md describes all
   textures and blocks. */

GLBK_DEF const glbk_part *glbk_envsh_part(void);
/* Returns the GLSL of this header, for programs of your own that use its library files: see
   glbk_source.parts. */

GLBK_DEF glbk_result glbk_envsh_bind(glbk_context *ctx, glbk_envsh_maps *maps, const envsh_query *query,
                                     const glbk_offset *offset);
/* Binds textures and uniform blocks for a program of your own, which is in use (glbk_begin). The program has
   envsh_light among its library files, and among its defines ENVSH_FILTER, the number of the query's filter,
   and ENVSH_RGBA, 1 if the maps were made with rgba and else 0.
   query    NULL = all defaults; its add plays no part
   offset   the offset that the part envsh has in the program; NULL = none
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, or the maps were not created. GLBK_ERR_DESC: a field of the
            query is out of range */
