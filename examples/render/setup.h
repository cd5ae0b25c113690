/* setup.h - from the command line to a scene that is ready to be shaded. */
#ifndef RD_SETUP_H
#define RD_SETUP_H

#include "args.h"

/* Loads the scene at `time` with lights, sky, ground and camera as docs/programs.md has them where nothing is given.
   Fills bounds (without the ground) and emitters of the job; the caller frees *emitters. 0, or -1 with error filled
   in. */
int rd_setup(ex_scene *scene, rd_job *job, rd_emitter **emitters, const rd_args *args, float time, char *error);

/* Moves what rd_setup made on to another time; camera, ground and the command line's lights stay where they are. */
int rd_move(ex_scene *scene, rd_job *job, rd_emitter **emitters, float time, char *error);

#endif
