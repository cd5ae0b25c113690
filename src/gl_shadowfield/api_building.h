/* ---- building on the GPU ----

   A builder draws the object as seen from the sample points of a field, up to 256 faces of cubes at a time in
   one atlas, counts samples into texels and projects these on harmonics. shadowfield.h asks for the samples
   and makes the field:

       int see(void *user, const sfield_views *views)
       {
           return glbk_sfield_builder_see(gl, &builder, views) != GLBK_OK;
       }
       ... sfield_build_views(&desc, 0, &mesh, see, NULL, &field, NULL); */

typedef void (*glbk_sfield_draw_fn)(void *user, glbk_context *ctx, int32_t instances);
/* Draws so many instances of your object, which lies within the field's sphere. The function binds a vertex
   array with the position in the field's space and, for sources, the radiance of the triangle. It must change
   neither program nor state. */

typedef struct glbk_sfield_builder glbk_sfield_builder; /* see below */

typedef struct glbk_sfield_builder_desc {
    const sfield_desc  *field;      /* the desc that sfield_build_views gets: its basis, bands and cube_side
                                       tell the projection. NULL = all defaults */
    const sfield_mesh  *mesh;       /* the object in the field's space, without a mask; NULL = draw_fn draws
                                       the object */
    int                 source;     /* not 0: radiance is built, else alpha */
    const float        *radiance;   /* sources: r, g, b of each triangle of mesh, 0..1e18, which is one frame;
                                       draw_fn draws others */
    glbk_sfield_draw_fn draw_fn;    /* used without a mesh */
    void               *user;       /* given to draw_fn */
    glbk_attributes     attributes; /* of what draw_fn draws: position counts, all zero = 0 */
    uint32_t            radiance_attribute; /* location of its radiance, 1..15; 0 = 1 */
} glbk_sfield_builder_desc;         /* keep all of it until glbk_sfield_builder_create returns */

GLBK_DEF glbk_result glbk_sfield_builder_create(glbk_context *ctx, const glbk_sfield_builder_desc *desc,
                                                glbk_sfield_builder *out);
/* Makes a builder for one object.
   Memory   on the GPU 4 MB (sources 20), cubes of a batch, the mesh, and bands^2 x 24 side^2 bytes; here the
            numbers that are read back of a batch, and while the call runs the mesh or the basis
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, a pointer, count or stride of the mesh is out of range, or
            the mesh has a mask.
            GLBK_ERR_DESC: a field is out of range. GLBK_ERR_INPUT: an index of the mesh or radiance is out of
            range, or no triangle can be used. GLBK_ERR_LIMIT: the mesh is too large. GLBK_ERR_ALLOC. Those of
            textures and glbk_program_compile */

GLBK_DEF glbk_result glbk_sfield_builder_see(glbk_context *ctx, glbk_sfield_builder *builder,
                                             const sfield_views *views);
/* Draws the faces of cubes round all eyes of views, writes views->values and waits for the GPU. Samples are
   those of sfield_build: 64 to 512 a side of a face (sources 256), by distance. No float targets are needed.
   Errors   GLBK_ERR_ARGUMENT: a pointer is NULL, the builder was not created, or views->count is 0.
            GLBK_ERR_INPUT: views are not finite. Those of glbk_begin and of reading, after which values may
            be half written */

GLBK_DEF void glbk_sfield_builder_free(glbk_context *ctx, glbk_sfield_builder *builder);
/* Deletes the builder's objects of GL, frees its memory and zeroes the struct. Accepts NULL. */

struct glbk_sfield_builder {            /* draws one object from all sides; read only; zeroed = none */
    uint32_t      batch;                /* the most eyes of which cubes are kept at once */
    uint32_t      side;                 /* private, like all that follows: texels a side of a face */
    uint32_t      bands;                /* of the coefficients; 0 = texels are wanted */
    uint32_t      groups;               /* groups of four coefficients */
    uint32_t      height;               /* pixels of the atlas */
    int           source;               /* as in the desc, like the next two */
    glbk_sfield_draw_fn draw_fn;
    void         *user;
    float         center[3];            /* of the sphere round your mesh */
    float         radius;               /* of that sphere */
    uint32_t      vertex_array;
    uint32_t      index_count;
    glbk_buffer   vertices;
    glbk_buffer   indices;
    glbk_buffer   block;
    glbk_texture  seen;                 /* the atlas */
    glbk_texture  depth;
    glbk_texture  cube;
    glbk_texture  coefs;
    glbk_texture  basis;                /* integrals of the basis over texels */
    glbk_target   seen_target;
    glbk_target   cube_target;
    glbk_target   coef_target;
    glbk_program  see;
    glbk_program  sum;
    glbk_program  project;
    struct glbk_sfield_views *views;    /* the block's values */
    uint32_t     *words;                /* texels that were read back */
    int           compute;
};
