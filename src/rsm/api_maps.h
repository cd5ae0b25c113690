/* ---- maps ---- */

typedef struct rsm_info {           /* what a map is like */
    uint32_t side;                  /* texels a side of each face */
    uint32_t face_count;            /* 1, 5 (patch) or 6 (point, wide spot) */
    size_t   texel_count;           /* side x side x face_count */
    int      finished;              /* not 0: rsm_finish has been called */
} rsm_info;

RSM_DEF void rsm_get_info(const rsm_map *map, rsm_info *out);
/* Writes what a map is like. If map or out is NULL, nothing is written. */

#define RSM_FAR 3.0e38f             /* depth of a texel in which the light sees nothing */

typedef struct rsm_texel {          /* what the light sees through one pixel; also a pixel light: 48 bytes */
    float    position[3];           /* of the surface at the texel's centre */
    float    depth;                 /* along the face's axis, counted from the light's position; RSM_FAR: the
                                       light sees nothing there */
    float    normal[3];             /* unit */
    uint32_t material;              /* number of its Phong lobe in rsm_gather_desc.materials, from 1;
                                       0 = none */
    float    flux[3];               /* r, g, b, W that leave the surface: light through the texel x albedo */
    float    area;                  /* area of surface that the texel stands for, unit^2; 0 = unknown */
} rsm_texel;

RSM_DEF const rsm_texel *rsm_map_texels(const rsm_map *map);
/* Returns the map's texels, face by face and row by row, row 0 at the bottom (v = 0), as they are at this
   moment. NULL for NULL. */

RSM_DEF rsm_result rsm_map_restart(rsm_map *map, const rsm_light *light);
/* Empties a map for the next frame, in the memory that the map has.
   light    the light as it is now; NULL = as it was. The map keeps its side, and it cannot have more faces
            than it was made with: a spot that widens to a cube needs a map that was made for a cube
   Errors   after these the map is as it was.
            RSM_ERR_ARGUMENT: map is NULL.
            RSM_ERR_DESC: a field of light is out of range.
            RSM_ERR_LIMIT: the light needs more faces than the map was made with. */

RSM_DEF rsm_result rsm_redraw(rsm_map *map, const rsm_light *light, const rsm_mesh *meshes, size_t mesh_count,
                              int *kept, struct rsm_stats *stats);
/* Draws a map for the next frame as rsm_map_restart, rsm_rasterize and rsm_finish do, unless it would come
   out as it is: then the map is kept, byte for byte. Nobody has to say what moved: light and meshes are read,
   and compared with those of the last such call by a key of 64 bits, so that a change is missed once in 2^64.
   What is compared is what the arrays hold, not where they lie. What functions of a mesh say cannot be read:
   such a mesh is drawn in every frame unless its version is not 0.
   light    the light as it is now; NULL = as it was
   kept     whether the map was kept, written on RSM_OK; may be NULL
   stats    those of rsm_finish, of kept maps too; may be NULL
   Errors   those of the three calls but RSM_ERR_ORDER. After RSM_ERR_ARGUMENT and RSM_ERR_DESC the map is as
            it was; after others it may be empty, and no map for rsm_gather
   Cost     of a kept map: reading all vertices and indices, and scratch of 40 bytes for 32,768 of them */

RSM_DEF size_t rsm_map_bytes(const rsm_desc *desc);
/* Returns the bytes of memory that rsm_map_init needs: 56 a texel, 8 a row and at most 1 KB more. Returns 0
   if desc is NULL, and also, with a line in the log, if a field of desc is out of range. */

RSM_DEF rsm_result rsm_map_init(const rsm_desc *desc, void *memory, size_t memory_bytes, rsm_map **out);
/* Makes an empty map inside memory of yours. Nothing is allocated, and rsm_map_free leaves the map alone.
   memory   at least rsm_map_bytes(desc) bytes, 8-byte aligned; they must outlive *out
   Errors   RSM_ERR_ARGUMENT: desc, memory or out is NULL.
            RSM_ERR_DESC: a field of desc is out of range.
            RSM_ERR_LIMIT: size_t cannot count the bytes.
            RSM_ERR_MEMORY: the memory is too small, or not 8-byte aligned. */

/* ---- maps from your renderer ---- */

RSM_DEF rsm_result rsm_map_matrix(const rsm_map *map, uint32_t face, float world_to_clip[16]);
/* Writes the matrix, world to clip, with which your renderer draws a face of the map. The faces of a cube
   look forward, right, left, up, down and back in the orientation of the light's direction and up.
   Errors   RSM_ERR_ARGUMENT: map or world_to_clip is NULL, or there is no such face. */

RSM_DEF rsm_result rsm_map_project(const rsm_map *map, const float point[3], uint32_t *face, float uv[2],
                                   float *depth);
/* Writes where the light sees a point in the world.
   face     the face that the point lies in
   uv       0..1 from the left and from the bottom of the face; beyond if the point lies outside the map
   depth    as in rsm_texel. In a perspective map depth <= 0 says that the point lies behind the light; face
            is then 0 and uv the middle
   Errors   RSM_ERR_ARGUMENT: a pointer is NULL. RSM_ERR_INPUT: the point is not finite or beyond 1e9. */

typedef struct rsm_buffers {        /* one face as your renderer drew it: `side` rows of `side` pixels each,
                                       row after row */
    const float    *positions;      /* world; NULL: computed from depth */
    size_t          position_stride; /* bytes from one pixel to the next, a multiple of 4, >= 12; 0 = 12 */
    const float    *depth;          /* what a depth buffer holds, as clip_depth says. If there are positions,
                                       depth only marks the background, by the far value, and may be NULL */
    size_t          depth_stride;   /* bytes, a multiple of 4; 0 = 4 */
    const float    *normals;        /* world, any length. 0 0 0 marks the background */
    size_t          normal_stride;  /* as position_stride */
    const float    *albedo;         /* linear reflectance, 0..1: more is not refused */
    size_t          albedo_stride;  /* as position_stride */
    const uint8_t  *albedo_srgb;    /* 8-bit sRGB, used if albedo is NULL. If both are NULL the albedo is 1 */
    size_t          albedo_srgb_stride; /* bytes, >= 3; 0 = 4 */
    const uint32_t *materials;      /* numbers of Phong lobes; NULL: none */
    size_t          material_stride; /* as depth_stride */
} rsm_buffers;

RSM_DEF rsm_result rsm_fill(rsm_map *map, uint32_t face, const rsm_buffers *buffers);
/* Fills one face from your renderer's buffers. Pixels with a value that is not finite or a negative albedo
   become empty and are counted.
   Errors   RSM_ERR_ARGUMENT: map, buffers or normals are NULL, there are neither positions nor depth, there
            is no such face, or a stride is out of range.
            RSM_ERR_ORDER: the map is finished.
            RSM_ERR_CANCELLED: the face is empty. */

typedef struct rsm_stats {          /* what rsm_finish counts */
    uint64_t lit_texels;            /* texels that have flux */
    uint64_t bad_texels;            /* texels that were left empty, since a value of theirs was not finite,
                                       negative or above 1e18 */
    uint64_t skipped_triangles;     /* triangles of rsm_rasterize without area, or with a vertex that is not
                                       finite or beyond 1e9 */
    double   incident[3];           /* light that falls on texels with a surface, r, g, b, W */
    double   reflected[3];          /* light that leaves these: the sum of their flux, r, g, b, W */
} rsm_stats;

#ifndef RSM_WITHOUT_DIRECT
/* ---- direct light by the same map ---- */

typedef struct rsm_direct_desc {    /* zero it, then set what you care about */
    rsm_system system;              /* without a log, as without a desc, the map's is told */
    uint32_t   tap_side;            /* percentage-closer filter of tap_side x tap_side texels, 1..15; 0 = 2,
                                       bilinear */
    float      bias;                /* texels, towards the light, up to 1e6; 0 = 0.5, negative = none */
    float      slope_bias;          /* a factor, up to 1e6, on the further bias that keeps a plane out of its
                                       own shadow: what its slope, counted up to 10, makes over all taps.
                                       0 = 1, negative = none */
    int        add;                 /* not 0: results are added to what the output holds */
} rsm_direct_desc;

RSM_DEF rsm_result rsm_direct(const rsm_map *map, const rsm_direct_desc *desc, const rsm_points *points,
                              float *irradiance);
/* Writes the irradiance of the light itself, shadowed by the map: 3 floats for each point. A point that lies
   outside the map is lit by a sun, dark otherwise. points.open is not used.
   desc     NULL = all defaults
   Errors   those of rsm_gather, without RSM_ERR_ALLOC */
#endif
