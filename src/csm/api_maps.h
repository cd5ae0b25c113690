/* ---- facts of maps ---- */

typedef struct cohsm_info {
    cohsm_domain_kind domain;
    cohsm_layers layers;
    cohsm_order  order;
    cohsm_orientation orientation;
    uint32_t side[3];
    uint32_t map_count;             /* N */
    uint32_t view_count;            /* N, or 6 N for positions, whose maps have the six faces of a cube */
    uint32_t map_side;              /* M */
    uint32_t depth_bits;
    uint32_t dimensions;            /* d */
    int      positional;            /* not 0: maps of positions, w = 1 */
    int      self_only;
    uint32_t pixel_begin, pixel_end;
    float    center[3], radius;
    float    depth_far;             /* positions: the distance that a depth of 1 stands for */
    uint64_t segments;
    size_t   bytes;                 /* of the block */
    double   ratio;                 /* view_count * pixels * 2 / bytes, as in the paper; pixels are M * M, or
                                       those of a shard */
} cohsm_info;

COHSM_DEF void cohsm_get_info(const cohsm_maps *maps, cohsm_info *out);
/* Writes what the maps were built with, and how large they are. Does nothing if one of the two is NULL. */

COHSM_DEF cohsm_result cohsm_location(const cohsm_maps *maps, uint32_t map, float out[4]);
/* Writes x, y, z, w of a map: D at the centre of its cell. Cells are counted with the first dimension
   fastest, not in the order of storage.
   Errors   COHSM_ERR_ARGUMENT (NULL, or map is not below map_count) */

/* ---- files ---- */

COHSM_DEF const void *cohsm_data(const cohsm_maps *maps, size_t *bytes);
/* Returns the block and its size: little-endian 32-bit words without pointers, which are the plain file and
   what is uploaded to a GPU. On big-endian hosts use cohsm_write. The block lives as long as the maps. */

COHSM_DEF cohsm_result cohsm_write(const cohsm_maps *maps, void *memory, size_t memory_bytes);
/* Writes the bytes of the plain file, cohsm_info.bytes of them, the same on a host of any byte order.
   Errors   COHSM_ERR_ARGUMENT, COHSM_ERR_MEMORY */

COHSM_DEF cohsm_result cohsm_open(const void *data, size_t bytes, const cohsm_system *system,
                                  cohsm_maps **out);
/* Makes maps from a plain or packed file in memory, which is copied, so that data may go. Version, sizes,
   checksum and every list are checked before anything is used. It asks for at most 64 bytes a byte of file +
   256 KB.
   system   NULL: malloc and free, no progress
   Errors   COHSM_ERR_ARGUMENT, COHSM_ERR_DESC (allocator), COHSM_ERR_FORMAT, COHSM_ERR_VERSION,
            COHSM_ERR_ALLOC, COHSM_ERR_CANCELLED */
