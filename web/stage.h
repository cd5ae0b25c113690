/* stage.h - what the programs of all pages share: a model on the GPU (model.c); and the stage on which models stand
   (stage.c), which has camera, G-buffer, the mean over frames, the backdrop and the picture in the window. The pages
   room, game, sky and filter are a scene each (room.c, game.c, sky.c, filter.c) behind the same few functions, which page.c calls. */
#ifndef WEB_STAGE_H
#define WEB_STAGE_H

#include "../gl_backend/gl_gbuffer.h"
#include "../examples/common/common.h"

/* ---- a model ---- */

typedef struct pg_part {            /* triangles of one object with one material */
    uint32_t object, material;
    uint32_t first, count;          /* of the index buffer */
} pg_part;

typedef struct pg_mesh {            /* a mesh of the scene on the GPU, triangles in the order of materials */
    uint32_t    vertex_array;
    glbk_buffer vertices, indices;
} pg_mesh;

enum { PG_GROUND_END = 6 };         /* radii of the model from its middle, where its ground has become the backdrop */

typedef struct pg_model {
    ex_scene      scene;            /* without its sky; the ground is its last object, unless there is none */
    float         center[3], radius;/* without the ground */
    float         ground;           /* its height */
    pg_mesh      *meshes;           /* one a mesh of the scene; NULL until pg_model_upload */
    pg_part      *parts;
    uint32_t      part_count;
    glbk_texture *textures;         /* one a texture of the scene */
    glbk_texture *plain_maps;       /* the same, of those that hold normals, or roughness and metal */
} pg_model;

/* Takes the scene, which is the model's from now on, whether or not that succeeds, and adds a ground if it has none and
   is to have one. 0, or -1 with one line in error (EX_ERROR_SIZE). */
int  pg_model_take(pg_model *model, ex_scene *scene, int with_ground, char *error);
int  pg_model_upload(pg_model *model, glbk_context *gl, char *error);
/* Uploads the vertices of meshes that deform, as ex_scene_set_time or a scene of ours has left them. */
int  pg_model_update(pg_model *model, glbk_context *gl, char *error);
void pg_model_release(pg_model *model, glbk_context *gl);   /* what is on the GPU */
void pg_model_free(pg_model *model, glbk_context *gl);      /* gl may be NULL where nothing was uploaded */

/* Draws all triangles, part by part; set is called before each, with what is drawn. transform: turns the scene, before
   its own transforms. Its ground has plane 1; all other objects are entity 1. Or some objects are entities of their
   own: the first of these is entity 1, those before it are none. */
typedef glbk_result (*pg_set_fn)(void *user, glbk_context *gl, const glbk_surface *surface);
typedef struct pg_draw {
    const float *transform;         /* NULL = the identity */
    pg_set_fn    set;
    void        *user;
    uint32_t     instances;         /* of each part; 0 = one, not instanced */
    int          casters;           /* not 0: without the ground */
    uint32_t     first_entity;      /* the object; 0: all are one */
} pg_draw;
glbk_result pg_model_draw(const pg_model *model, glbk_context *gl, const pg_draw *draw);

/* All that casts shadows as one object in world space. The arrays are freed by the caller. 0, or -1: out of memory. */
int  pg_model_merge(const pg_model *model, float **positions, size_t *vertex_count, uint32_t **indices,
                    size_t *index_count);

/* ---- the stage ---- */

typedef struct pg_view {            /* what the page asks of the camera */
    float azimuth, elevation, distance;     /* about the model, radians, and in radii of the model */
    float up;                       /* how far above the model's centre it looks, in radii */
} pg_view;

typedef struct pg_camera { float eye[3], clip[16], unclip[16]; } pg_camera;

typedef enum pg_track {             /* where a handle goes when it is dragged */
    PG_TRACK_PLANE,                 /* at its height */
    PG_TRACK_WALLS                  /* on the walls, floor and ceiling of the stage's box */
} pg_track;

typedef struct pg_handle {          /* something that the user may drag */
    float    position[3];
    float    radius;                /* how near by the pointer takes hold of it */
    pg_track track;
    float    color[3];              /* of the dot that is drawn there; black = none */
} pg_handle;

enum { PG_HANDLES = 40, PG_DOTS = 4 };

typedef struct pg_stage {
    glbk_context *gl;
    uint32_t      width, height;
    uint32_t      window;           /* the framebuffer that is shown: 0 in a page */
    glbk_gbuffer  seen;
    glbk_texture  light;            /* of this frame: what the page's technique computes, radiance */
    glbk_target   light_target;
    glbk_texture  sum[2];           /* sum[now] has the mean of all frames */
    glbk_target   sum_target[2];
    int           now;
    uint32_t      frames;           /* in the mean */
    int           no_mean;          /* not 0: each frame is shown by itself, and the camera is not moved within a pixel */
    glbk_program  mix, show;
    pg_camera     camera;
    glbk_texture  sky;              /* its texels, for the backdrop; of one black texel at first */
    float         sky_light;        /* what a white surface that looks up reflects of it, luminance */
    float         sky_mean[3];
    float         backdrop[3];      /* behind everything, unless the sky is shown */
    int           show_sky;
    float         sky_turn;         /* radians about +Y */
    float         ground[4];        /* the ground's middle, and where it ends */
    float         exposure;         /* from radiance to what is shown */
    float         box[2][3];        /* handles stay in it */
    pg_handle     handles[PG_HANDLES];
    uint32_t      handle_count;
    int           held;             /* the handle that the pointer has, or -1 */
} pg_stage;

/* stage: zeroed at first; what is not on the GPU stays through pg_stage_free and another pg_stage_create. */
int  pg_stage_create(pg_stage *stage, glbk_context *gl, char *error);
void pg_stage_free(pg_stage *stage);
int  pg_stage_resize(pg_stage *stage, uint32_t width, uint32_t height, char *error);
/* Makes the sky the backdrop. texels, if not NULL, gets the same in at most 512 x 256 texels, r, g, b, for the
   caller to free; rotation is left to the caller. */
int  pg_stage_sky(pg_stage *stage, const ex_sky *sky, float **texels, uint32_t *width, uint32_t *height, char *error);
/* Sets the camera: round a model, all of it turned about +Y by an angle. Still pictures become smooth by it. */
void pg_stage_look(pg_stage *stage, const pg_model *model, const pg_view *view, float turn);
glbk_result pg_stage_draw(pg_stage *stage, const pg_model *model, const float transform[16], uint32_t first_entity);
/* A texture of colours of the picture's size, as light is; and a program that draws a screen, which may read the G-buffer. */
glbk_result pg_stage_target(pg_stage *stage, glbk_texture *texture, glbk_target *target);
glbk_result pg_stage_compile(pg_stage *stage, const char *text, glbk_program *out);
/* Adds the light to the mean, with the backdrop, and shows the mean in the window. */
glbk_result pg_stage_mix(pg_stage *stage);
glbk_result pg_stage_show(pg_stage *stage);
/* The pointer at x, y of the window, -1..1, +y up. press: 1 if it took hold of a handle. */
int  pg_stage_press(pg_stage *stage, float x, float y);
void pg_stage_drag(pg_stage *stage, float x, float y);
/* Where a point of the world is in the window, -1..1. */
void pg_stage_project(const pg_stage *stage, const float point[3], float out[2]);

int  pg_failed(const char *what, glbk_result result, char *error);      /* -1, with a line in error unless it has one */

/* ---- what room.c, game.c, sky.c and filter.c have ---- */

enum { PG_KNOBS = 20 };

/* Builds what stands on the stage and does not depend on knobs, with handles and box, if that was not done before (a
   lost context takes what is on the GPU alone), and uploads it. */
int  pg_scene_create(pg_stage *stage, char *error);
const pg_model *pg_scene_model(void);
/* Draws the frame of a time in seconds into the stage's G-buffer and its light. The camera is set. */
int  pg_scene_light(pg_stage *stage, const float knobs[PG_KNOBS], float time, char *error);
void pg_scene_free(pg_stage *stage);        /* what is on the GPU */

/* The light of the frame that was drawn last, as a path tracer takes it: what the picture is compared with
   (tests/web/exact.h). The page itself does not call it. */
typedef struct pg_lights {
    ex_light lights[2];
    uint32_t count;
    ex_sky   sky;                   /* freed by the caller */
    int      bounces;               /* between the first surface and a light */
    int      full;                  /* materials=full of `render`; 0: Lambert */
} pg_lights;
int  pg_scene_lights(const pg_stage *stage, const float knobs[PG_KNOBS], pg_lights *out, char *error);
/* One spot lamp; the direction may have any length, value is intensity along it. */
void pg_lights_spot(pg_lights *lights, const float position[3], const float direction[3], float cone_half_angle,
                    const float value[3]);
/* A built-in sky, or a .hdr file's, without the light from below the horizon, which the ground hides. */
int  pg_lights_sky(pg_lights *lights, const char *name, float rotation, char *error);

#endif
