/* rsm_parts.h - what the files of the technique "rsm" share. */
#ifndef RS_PARTS_H
#define RS_PARTS_H

#include "ground.h"
#include "technique.h"
#include "../../gifilter.h"
#include "../../rsm.h"

typedef struct rs_memory { uint64_t now, peak; } rs_memory;

typedef enum rs_mode { RS_FULL, RS_INTERPOLATED, RS_DENOISED } rs_mode;

typedef struct rs_state {
    rs_memory    memory;
    rsm_system   system;
    rsm_map    **maps;
    size_t       map_count, lamp_count;                     /* the rest are rings of the ground: no direct light */
    gifilt_filter *filter;
    rs_mode      mode;
    int          direct, indirect;
    uint32_t     size, points;
    int          keep;                                      /* maps that would come out as they are are not drawn */
    size_t       kept_count;                                /* of the last frame's maps */
    rsm_gather_desc gather;
    rsm_direct_desc shadow;
    rsm_interpolation interpolation;
    uint32_t     passes, history;
    float        noise[64 * 64];
    float       *normals, *positions, *light, *bounce;      /* of the G-buffer's pixels */
    uint64_t     bytes;                                     /* of these */
    rsm_gather_stats stats;
    uint64_t     lit_texels, bad_texels, pixels;
    double       maps_ms, direct_ms, gather_ms;
    struct rs_gl *gl;                                       /* --backend gl */
    uint64_t     gl_bytes;
} rs_state;

/* All return 0, or -1 with one line in error. */
int      rs_fail(char *error, const char *what, rsm_result result);
uint32_t rs_map_side(const rs_state *state, const rsm_light *light);
void     rs_view_projection(const ex_camera *camera, float aspect, float matrix[16]);

/* rsm_gl.c. frame fills state->light and state->bounce. */
int    rs_gl_open(rs_state *state, const rd_job *job, char *error);
int    rs_gl_frame(rs_state *state, const rd_job *job, char *error);
size_t rs_gl_maps(const rs_state *state);
void   rs_gl_close(rs_state *state);

/* The scene's lights as lights of rsm.h: one for each sun, spot and point; `points` for all area lights and emitters
   together, in proportion to their power; `points` directions for a sky. *lights is freed with free(). */
int rs_lights_build(rsm_light **lights, size_t *count, const rd_job *job, uint32_t points, char *error);

/* The ground beyond the maps of the suns among the lights, and a finished map of one of its rings. */
int       rs_rings_build(rd_ring **rings, size_t *ring_count, const rd_job *job, const rsm_light *lights, size_t count,
                         char *error);
rsm_light rs_ring_light(const rd_ring *ring);
int       rs_ring_map(const rd_ring *ring, const rsm_system *system, rsm_map **map, char *error);

#endif
