/* ---- the context ---- */

struct glbk_context {               /* read only; the fields after max_point_side are private */
    glbk_functions gl;              /* gl.BindTexture(...): yours to call, too */
    uint32_t       program;         /* GL's name of the program that glbk_begin bound last, for uniforms of
                                       functions of yours */
    const char    *renderer;        /* the driver's name, valid while the GL context lives */
    int            es;              /* not 0: OpenGL ES or WebGL */
    int            webgl;           /* not 0: WebGL, which always restarts primitives, without a switch */
    uint32_t       version;         /* 330 .. 460, or 300 .. 320 with es */
    int            compute;         /* not 0: OpenGL 4.3, compute shaders and storage buffers */
    int            float_targets;   /* not 0: RGBA32F and the other formats of floats are renderable */
    int            float_blend;     /* not 0: these can be blended into */
    int            float_linear;    /* not 0: 32-bit float textures can be filtered */
    int            clip_control;    /* not 0: glClipControl is there */
    uint32_t       max_side;        /* texels a side of a 2D texture */
    uint32_t       max_layers;      /* layers of an array texture */
    uint32_t       max_targets;     /* colour attachments that can be drawn to at once */
    float          max_point_side;  /* pixels a side of a point */
    uint32_t       vertex_array;    /* empty, for passes that need no attributes */
    uint32_t       shown;           /* buffer of the block glbk_shown of gl_gbuffer.h */
    int            lost;            /* not 0: no call reaches GL any more */
    glbk_system    system;
    uint32_t       first_unit, first_block;
    uint32_t       unit_count, block_count;     /* that the context has from those on, at most
                                                   GLBK_MAX_UNITS and GLBK_MAX_BLOCKS */
    int            each_target;     /* not 0: colour mask and blending are switched for each target */
    int            each_blend;      /* not 0: each target has blend functions of its own */
    int            offset_clamp;    /* not 0: glPolygonOffsetClamp is there */
    int            check;           /* desc.check */
    uint32_t       inner;           /* the framebuffer that glbk_begin bound last, if it is a technique's */
    size_t         max_storage;     /* bytes of a storage buffer */
};

GLBK_DEF void glbk_abandon(glbk_context *ctx);
/* Says that the GL context is gone or not current: from now on the _free functions touch memory only, and all
   other calls return GLBK_ERR_LOST or do nothing. Call it if your window system reports a lost context, then
   free everything, glbk_free the context last, and begin anew with glbk_init. ctx may be NULL. */
