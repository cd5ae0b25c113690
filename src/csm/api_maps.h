/* ---- facts of maps ---- */

typedef struct cohsm_info {         /* what has no comment is as in cohsm_desc, its defaults filled in */
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
    uint64_t segment_count;         /* of all pixels together */
    size_t   bytes;                 /* of the block */
    cohsm_layout layout;            /* COHSM_LAYOUT_COMPACT or COHSM_LAYOUT_FAST */
    size_t   fast_bytes;            /* of the trays beside the block; 0 where the layout is compact */
    size_t   memory_bytes;          /* that the maps take of the allocator: block, trays and tables; without
                                       the block if they read a file in place (cohsm_open_file) */
    double   ratio;                 /* the paper's compression ratio: view_count * pixels * 2 bytes of plain
                                       16-bit maps / bytes; pixels are M * M, or those of a shard */
} cohsm_info;

COHSM_DEF void cohsm_get_info(const cohsm_maps *maps, cohsm_info *out);
/* Writes what the maps were built with and how large they are. Does nothing if a pointer is NULL. */

COHSM_DEF cohsm_result cohsm_location(const cohsm_maps *maps, uint32_t map, float out[4]);
/* Writes where a map looks from, x, y, z, w: the value of D at the centre of the map's cell.
   map      0..map_count - 1, counted with the first dimension fastest, not in the order of storage
   out      w = 0: x, y, z is the unit direction towards the light; w = 1: a position
   Errors   COHSM_ERR_ARGUMENT (NULL, or map is not below map_count) */

COHSM_DEF cohsm_result cohsm_depths(const cohsm_maps *maps, uint32_t view, uint16_t *out);
/* Decompresses one view, for tests, and for renderers that want one plain shadow map. Writes the stored
   depths of its pixels, M * M or those of a shard, row 0 at y = 0: z * 65533, 65534 for the sphere's far
   side, 65535 for infinity.
   view     the map's number as cohsm_location counts; for maps of positions face * N + the map's number
   Errors   COHSM_ERR_ARGUMENT (NULL, or a view that is too large)
   Cost     one search for each pixel */

/* ---- files ---- */

COHSM_DEF const void *cohsm_data(const cohsm_maps *maps, size_t *bytes);
/* Returns the block, which is the plain file as it stands and is what a GPU gets, and writes its bytes. The
   block consists of 32-bit words without pointers (docs/csm-format.md) in the byte order of the host; the
   file is little-endian, so write it by cohsm_write on big-endian hosts. The block lives as long as the maps;
   of maps that read a file in place it is that file.
   maps     NULL gives NULL
   bytes    may be NULL */

COHSM_DEF const void *cohsm_fast_data(const cohsm_maps *maps, size_t *bytes);
/* Returns what a GPU gets in place of the block if it is to answer faster, and writes its bytes: the block's
   header and directions, then the trays of COHSM_LAYOUT_FAST (docs/gpu-layouts.md), in the byte order of the
   host. It is no file, and lives as long as the maps. Returns NULL and 0 bytes for maps in the compact layout
   and for trays of 4 GB or more.
   maps     NULL gives NULL
   bytes    may be NULL */

COHSM_DEF cohsm_result cohsm_write(const cohsm_maps *maps, void *memory, size_t memory_bytes);
/* Writes the plain file, cohsm_info.bytes bytes that are the same on a host of any byte order.
   Errors   COHSM_ERR_ARGUMENT (NULL), COHSM_ERR_MEMORY (memory_bytes is below cohsm_info.bytes) */

COHSM_DEF cohsm_result cohsm_open(const void *data, size_t bytes, const cohsm_system *system,
                                  cohsm_maps **out);
/* Makes maps from a plain or packed file in memory; cohsm_free takes the maps back. The file is copied and
   need not outlive the call. It may come from anywhere: version, sizes, checksum and every list are checked
   before anything is used.
   system   NULL: malloc and free, no progress, no log
   Errors   COHSM_ERR_ARGUMENT (NULL), COHSM_ERR_DESC (allocator), COHSM_ERR_FORMAT, COHSM_ERR_VERSION,
            COHSM_ERR_ALLOC, COHSM_ERR_CANCELLED, COHSM_ERR_MISMATCH (a packed file, in a header that was
            joined without pack)
   Cost     at most 64 bytes of memory for each byte of the file, and 256 KB; for the time see cohsm_pack */

#ifndef COHSM_WITHOUT_FAST
COHSM_DEF cohsm_result cohsm_open_as(const void *data, size_t bytes, cohsm_layout layout, size_t layout_bytes,
                                     const cohsm_system *system, cohsm_maps **out);
/* Does what cohsm_open does, and lays the maps out in memory for size or for speed.
   layout        COHSM_LAYOUT_FAST makes trays from the block; COHSM_LAYOUT_BUDGET only if they fit
   layout_bytes  of COHSM_LAYOUT_BUDGET: the most bytes that block and trays may take together
   Errors        those of cohsm_open; COHSM_ERR_ARGUMENT also for layout; COHSM_ERR_LIMIT (256 GiB of trays)
   Cost          that of cohsm_open, and for trays 0.2 to 0.3 microseconds and 2 bytes to 1 KB of memory for
                 each pixel and 256 views; while they are made 0.5 MB more, or eight times that with a
                 parallel_for. The bytes of trays do not follow from those of the file: if files are not
                 trusted, COHSM_LAYOUT_BUDGET keeps block and trays within layout_bytes */
#endif
