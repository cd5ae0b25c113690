/* viewer.h - the parts of the program `viewer`: what is shown (show.c), from where (orbit.c), on which pixels (draw.c),
   with what text (panel.c, font.c) and by which keys (main.c, keys.c). Techniques are those of `render`, run a frame at
   a time. */
#ifndef VW_VIEWER_H
#define VW_VIEWER_H

#include "../common/gl_context.h"
#include "../render/setup.h"

/* ---- orbit.c: a camera that turns round a point ---- */

typedef struct vw_orbit {
    float target[3], distance, azimuth, elevation;     /* angles in radians, azimuth from +X towards +Z */
    float fovy;
} vw_orbit;

void vw_orbit_from(vw_orbit *orbit, const ex_camera *camera);
void vw_orbit_to(const vw_orbit *orbit, ex_camera *camera);
void vw_orbit_turn(vw_orbit *orbit, float right, float down);          /* radians */
void vw_orbit_move(vw_orbit *orbit, float right, float down);          /* in units of the picture's height */
void vw_orbit_zoom(vw_orbit *orbit, float steps);
void vw_orbit_matrix(const vw_orbit *orbit, float aspect, float radius, float out[16]);    /* world to clip */

/* ---- show.c: a scene under a technique, frame by frame ---- */

enum { VW_MAX_CHANGES = 32, VW_MAX_FRAMES = 4096 };

/* A technique at work on what is loaded. */
typedef struct vw_side {
    rd_args             args;
    rd_job              job;
    void               *state;
    int                 is_open;
    ex_image            frame, picture;                /* the last one, and the mean of all */
    uint32_t            frames;
    double              open_ms, frame_ms, spent;      /* spent: seconds for all frames */
} vw_side;

/* The reference is the path tracer, with as many bounces as the technique has. */
enum { VW_TECHNIQUE, VW_REFERENCE, VW_SIDES };

typedef struct vw_show {
    /* What is wanted; vw_show_step follows. */
    char                scene[512], sky[512];          /* as --scene and --env; sky "" = the scene's own light */
    const char         *figure;                        /* as --figure; NULL = none */
    const rd_technique *technique;                     /* NULL: the preview, drawn by GL */
    char                changes[VW_MAX_CHANGES][100];  /* --set key=value */
    int                 change_count;
    uint32_t            samples;                       /* a pixel and frame; 0 = a sixteenth of the technique's own */
    glbk_context       *gl;
    int                 use_gl;                        /* for techniques that have a GL path */
    int                 compares;                      /* with the reference, too */
    uint32_t            width, height;
    vw_orbit            orbit;
    int                 new_scene, new_technique, new_reference, new_view;     /* set where the above changed */
    int                 plays;                         /* time passes, 1/30 s a picture */
    int                 keeps_orbit;                   /* the new scene is the old one in another light */
    /* What is there. */
    rd_args             args;
    ex_scene            loaded;
    char                loaded_scene[512], loaded_sky[512];    /* where from */
    vw_orbit            home;                          /* the scene's own camera, which home_camera has exactly */
    ex_camera           home_camera;
    unsigned            loads;                         /* counts scenes, so that draw.c knows of a new one */
    rd_emitter         *emitters;
    ex_gbuffer          gbuffer;
    rd_job              job;                           /* of both sides, but for settings */
    vw_side             side[VW_SIDES];
    uint32_t            time;                          /* of the scene, in 1/30 s */
    uint32_t            moves;                         /* steps of it since the last wish */
    double              moved;                         /* when the last one was, seconds */
    double              gbuffer_ms;
    char                error[EX_ERROR_SIZE];          /* "" = none; nothing is shown with one */
} vw_show;

/* Does the next piece of work: load, a G-buffer, open, a frame. 1 where the picture changed, 0 where all is done. */
int  vw_show_step(vw_show *show);
int  vw_show_will_build(const vw_show *show);          /* the next step may take long */
void vw_show_free(vw_show *show);
/* Of the technique's picture from the reference's as it is now, as build/compare has them. 0 where one is missing. */
int  vw_show_error(const vw_show *show, double *relative_rmse, double *mean_ratio);
/* The keys of --set that can be changed now, in order; NULL at the end. */
const rd_key *vw_show_key(const vw_show *show, int index);
const char   *vw_show_value(const vw_show *show, const rd_key *key);
void          vw_show_change(vw_show *show, const rd_key *key, int direction);

/* ---- panel.c: text as an image ---- */

enum { VW_GLYPH_WIDTH = 5, VW_GLYPH_HEIGHT = 7, VW_LINE_HEIGHT = 20 };

typedef struct vw_panel {
    uint32_t       width, height;
    unsigned char *rgba;           /* rows from the top down */
} vw_panel;

int         vw_panel_size(vw_panel *panel, uint32_t width, uint32_t height);    /* 0, or -1: out of memory */
void        vw_panel_clear(vw_panel *panel);
/* A line of text, twice the glyphs' size, on a dark strip; returns the y of the next line. */
uint32_t    vw_panel_text(vw_panel *panel, uint32_t x, uint32_t y, const char *text, int is_selected);

/* ---- draw.c: all GL ---- */

typedef struct vw_draw vw_draw;

vw_draw *vw_draw_create(glbk_context *gl, char *error);
void     vw_draw_free(vw_draw *draw);
void     vw_draw_preview(vw_draw *draw, const vw_show *show);
/* Right of `split`, a part of the width, the reference's picture where there is one, and a line between the two. */
void     vw_draw_picture(vw_draw *draw, const vw_show *show, float scale, float split);
void     vw_draw_panel(vw_draw *draw, const vw_panel *panel);
/* What stands in the window now, rows from the top down, 3 bytes a pixel; freed by the caller. NULL: out of memory. */
unsigned char *vw_draw_read(vw_draw *draw, uint32_t width, uint32_t height);

/* ---- keys.c: what the user does ---- */

typedef struct viewer {
    vw_show  show;
    vw_panel panel;
    int      has_panel, has_help, is_dirty;
    int      selected;             /* row of the panel */
    float    ev;                   /* added to the automatic exposure */
    float    split;                /* where the line between technique and reference is, a part of the width */
    int      shots;                /* screenshots so far */
    int      wants_shot, wants_pfm, wants_end;
    float    ev_automatic;
    char     message[300];
} viewer;

enum { VW_ROW_TECHNIQUE, VW_ROW_SCENE, VW_ROW_SKY, VW_ROW_SAMPLES, VW_ROW_EXPOSURE, VW_ROW_KEYS };

void vw_key(viewer *v, int key, int is_shifted);       /* GLFW's number of a key */
void vw_drop(viewer *v, const char *path);
void vw_choose(vw_show *show, const rd_technique *technique);  /* NULL: the preview */
void vw_lines(viewer *v);                              /* fills the panel */

#endif
