/* ---- objects: read only ---- */

struct glbk_rsm_map {                   /* the map of a light; read only; zeroed = none */
    uint32_t       side;                /* texels a side of a face */
    uint32_t       face_count;          /* 1, 5 or 6 */
    rsm_light      light;               /* with its defaults */
    glbk_rsm_light block;               /* the light as shaders know it */
    glbk_buffer    buffer;              /* the block on the GPU */
    glbk_texture   texels;              /* three layers for each face: see glbk_rsm_texels */
    glbk_texture   depth;               /* the depth buffer that a face is drawn with */
    glbk_texture   sums[2];             /* running sums along rows: one is read while the other is drawn */
    glbk_texture   rows[2];             /* running sums of rows, in the same way */
    glbk_target    face_targets[6];     /* of texels */
    glbk_target    sum_targets[2][6];   /* of sums */
    glbk_target    row_targets[2][6];   /* of rows */
    glbk_texture   stats;               /* of glbk_rsm_map_stats, made when it is first called */
    glbk_target    stats_target;        /* of stats */
    int            summed;              /* not 0: the sums are those of the texels */
    int            sums_at;             /* which of sums holds them */
    int            rows_at;             /* which of rows holds them */
};

#define GLBK_RSM_PROGRAM_COUNT 28u

struct glbk_rsm_renderer {              /* the light of a picture; read only; zeroed = none */
    glbk_program    programs[GLBK_RSM_PROGRAM_COUNT];   /* compiled when they are first needed */
    glbk_texture    sums[3];            /* pictures: direct light, bounced light, and one to draw to */
    glbk_texture    grids[3];           /* grids of interpolation; by compute one */
    glbk_texture    history[2];         /* light that the filter remembers */
    glbk_texture    kept[2];            /* places and normals of that light */
    glbk_texture    lights;             /* the list of pixel lights */
    glbk_target     targets[3];         /* of sums */
    glbk_target     grid_targets[3];    /* of grids */
    glbk_target     history_targets[2]; /* of history and kept */
    glbk_target     lights_target;      /* of lights */
    glbk_texture    pattern;            /* the points of glbk_rsm_tables_upload */
    glbk_texture    noise;              /* the noise of the same call */
    glbk_texture    materials;          /* the materials of the same call */
    rsm_gather_desc tables;             /* the desc of that call, without its pointers */
    uint32_t        point_count;        /* points of the pattern */
    uint32_t        noise_side;         /* texels a side of the noise; 0 = none */
    uint32_t        material_count;     /* materials of the table */
    glbk_buffer     frame;              /* the uniform block of passes */
    glbk_buffer     object;             /* the uniform block of objects that are drawn */
    glbk_buffer     imported;           /* the uniform block of imports */
    glbk_rsm_frame  values;             /* what frame holds, or will hold */
    glbk_rsm_drawn  drawn;              /* what object holds, or will hold */
    float           before[16];         /* world to clip space of the last frame */
    uint32_t        width;              /* pixels */
    uint32_t        height;
    uint32_t        lights_per_pass;    /* as in the desc, with its default */
    glbk_attributes attributes;         /* the same */
    uint32_t        direct;             /* which of sums holds direct light; 9 = none */
    uint32_t        bounce;             /* which of sums holds bounced light; 3 and 4 = history; 9 = none */
    uint32_t        remembers;          /* 1 + which history is the newest; 0 = none */
    int             has_before;         /* not 0: before is set */
    int             drawing;            /* not 0: within a glbk_rsm_draw_fn */
    int             filtered;           /* not 0: bounced light was filtered */
    glbk_result     failed;             /* the first error of glbk_rsm_object while drawing */
    int             compute;            /* not 0: gathering and filtering are done by compute */
    glbk_buffer     counts;             /* by compute, with interpolate: lengths of the lists */
    glbk_buffer     pending[2];         /* lists of pixels that stay pending */
    glbk_buffer     wanted;             /* the list of nodes that are wanted */
    glbk_buffer     marks;              /* a bit for each node that was ever wanted */
};
