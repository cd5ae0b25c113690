/* args.h - the command line of `render`; docs/programs.md defines it. */
#ifndef RD_ARGS_H
#define RD_ARGS_H

#include "technique.h"

typedef struct rd_light_arg {
    ex_light light;
    int      has_value;        /* 0: spot and point still need their default, which depends on the scene */
} rd_light_arg;

typedef struct rd_args {
    const rd_technique *technique;
    int          use_gl;
    const char  *scene, *env, *out, *json, *kept;      /* NULL where not given */
    int          hash;         /* --hash: nothing is drawn */
    char         figure[512];  /* file of --figure; "" where not given */
    float        figure_at[3];
    const char  *baked[RD_MOST_BAKED];
    size_t       baked_count;
    rd_light_arg *lights;      /* freed by rd_args_free */
    uint32_t     light_count;
    ex_camera    camera;
    int          has_camera;
    uint32_t     width, height, samples, frames, seed;
    float        time;         /* seconds, of the first frame */
    int          threads;      /* 0: all cores */
    rd_settings  settings;
} rd_args;

/* 0, or -1 with one line in error: the arguments are bad. */
int  rd_args_parse(rd_args *args, int count, char **values, char *error);
void rd_args_free(rd_args *args);

/* One LIGHT, "sun:0,1,0,3.14". Exposed for tests. */
int  rd_light_parse(rd_light_arg *out, const char *text, char *error);

#endif
