/* ---- files in place, and more objects than memory holds ---- */

typedef struct cohsm_open_desc {    /* how cohsm_open_file opens a file */
    cohsm_system system;
    cohsm_layout layout;            /* as for cohsm_open_as */
    size_t       layout_bytes;      /* of COHSM_LAYOUT_BUDGET: the most bytes that block and trays may take
                                       together, the block counting where it is read in place, too */
    size_t       budget_bytes;      /* the most bytes of memory that the file may cost; 0 = any number. What
                                       counts are the maps, their trays, and what a packed file takes while
                                       it is decoded; a file that is read in place does not. All but the
                                       trays is known by the header, and compared before any memory is asked
                                       for. What works on trays while they are made comes on top, 0.5 MB, or
                                       eight times that with a parallel_for */
    int          in_place;          /* not 0: the maps read the file where it lies, such as a file that the
                                       system has mapped into memory, and keep no copy of it. The file must
                                       begin at a multiple of 64 bytes, and stay as it is until cohsm_free.
                                       Packed files, and all files on big-endian hosts, are decoded into
                                       memory all the same */
} cohsm_open_desc;

COHSM_DEF cohsm_result cohsm_open_file(const cohsm_open_desc *desc, const void *data, size_t bytes,
                                       cohsm_maps **out);
/* Does what cohsm_open does, within a budget or without a copy. Everything is checked here, too, so that the
   whole file is read once; later, a query reads the few lines that it asks for.
   desc     NULL = all defaults: that is cohsm_open
   Errors   those of cohsm_open_as, but COHSM_ERR_DESC for the layout; COHSM_ERR_LIMIT also if the file costs
            more than budget_bytes (the log says how much), or with the trays of COHSM_LAYOUT_FAST would;
            COHSM_ERR_MEMORY (in_place, and data is not at a multiple of 64 bytes) */

COHSM_DEF cohsm_result cohsm_file_info(const void *data, size_t bytes, const cohsm_system *system,
                                       cohsm_info *out);
/* Writes what a plain or packed file holds, by its header alone, which is checked; the rest is not read.
   out      receives what cohsm_get_info would write for the maps that cohsm_open makes of the file
   system   NULL: no log. Nothing else of it is used
   Errors   COHSM_ERR_ARGUMENT (NULL), COHSM_ERR_FORMAT, COHSM_ERR_VERSION, COHSM_ERR_MISMATCH (a packed file,
            in a header that was joined without pack) */

typedef struct cohsm_stream cohsm_stream;   /* many objects, of which as many as fit are in memory, in
                                               COHSM_LAYOUT_COMPACT */

typedef struct cohsm_stream_desc {
    cohsm_system system;            /* its allocator and log: parallel_for and progress are not called */
    uint32_t     object_count;      /* 1..2^24; each has a file */
    size_t       budget_bytes;      /* above 0: the most bytes that the objects in memory may take together:
                                       what the maps of each take (cohsm_info.memory_bytes), its file's bytes
                                       if it is read in place, and while a packed file is decoded what that
                                       takes. Beside them the stream takes 0.5 KB for each object */
    int          in_place;          /* as in cohsm_open_desc */
    int (*load_fn)(void *user, uint32_t object, const void **data, size_t *bytes);
    /* Writes where the file of an object is, read or mapped into memory, and its bytes; the same file each
       time. Returns 0; or another number if there is none, when unload_fn is not called and the call that
       wants the object ends with COHSM_ERR_CANCELLED. Neither function may call this stream's. */
    void (*unload_fn)(void *user, uint32_t object, const void *data, size_t bytes);
    /* Takes back what load_fn gave: as soon as the file has been copied or decoded or was refused, or, if it
       is read in place, when the object leaves memory. NULL = there is nothing to do. */
    void        *user;              /* given to load_fn and unload_fn */
} cohsm_stream_desc;

COHSM_DEF cohsm_result cohsm_stream_create(const cohsm_stream_desc *desc, cohsm_stream **out);
/* Makes a stream, which cohsm_stream_free takes back. Nothing is loaded yet.
   Errors   COHSM_ERR_ARGUMENT (NULL), COHSM_ERR_DESC, COHSM_ERR_ALLOC */

COHSM_DEF cohsm_result cohsm_stream_use(cohsm_stream *stream, uint32_t object, const cohsm_maps **out);
/* Gives the maps of an object and holds it: the maps stay in memory until cohsm_stream_end was called as
   often as this function. If they are not there yet, the file is loaded and opened; as long as the budget has
   no room for it, objects that nobody holds leave, first the one whose last hold ended first. A stream
   belongs to one thread at a time; the maps may be asked by any number of threads.
   out      receives the maps, on COHSM_OK only
   Errors   COHSM_ERR_ARGUMENT (NULL, object), COHSM_ERR_CANCELLED (load_fn), COHSM_ERR_LIMIT (beside the
            objects that are held the budget has no room), those of cohsm_open_file, COHSM_ERR_INPUT (the
            object has another file than before). The log says which object */

COHSM_DEF void cohsm_stream_end(cohsm_stream *stream, uint32_t object);
/* Ends one hold of cohsm_stream_use. The maps stay in memory until others need the room, which may be in
   any later call: do not ask them any more. Does nothing for NULL, and for an object that is not held. */

typedef struct cohsm_stream_instance {  /* an object of a scene; several may name the same object */
    uint32_t object;                /* 0..object_count - 1 */
    float    transform[16];         /* as in cohsm_instance */
} cohsm_stream_instance;

COHSM_DEF cohsm_result cohsm_stream_visible_scene(cohsm_stream *stream,
                                                  const cohsm_stream_instance *instances,
                                                  size_t instance_count, const cohsm_query *query,
                                                  float *visible, size_t *refused);
/* Writes what cohsm_visible_scene writes, to the last bit, for a scene whose objects need not fit into memory
   together: one after the other is held and asked by all points. An object that was never loaded is loaded
   for its header. After that it is loaded only if the way of a point that still sees some light meets the
   object's sphere (or for any such point, where lights are parameters or indices).
   Errors   those of cohsm_visible_scene and cohsm_stream_use, when `visible` is untouched; COHSM_ERR_INPUT
            also if an instance names an object that the stream does not have. The log is that of the stream
   Cost     that of cohsm_visible_scene, and of loading; 4 bytes of memory for each point. A scene whose
            points meet more objects than fit, in the same order each time, loads all of them each time: order
            instances from near to far, or ask for the points of one region at a time */

typedef struct cohsm_stream_stats {
    uint32_t objects, held;         /* in memory; of them those that are held */
    size_t   bytes, peak_bytes;     /* what they take now, and took at most, by the rule of budget_bytes */
    uint64_t hits, loads, evictions;    /* holds that found the object in memory; that did not; objects that
                                           left for others */
} cohsm_stream_stats;

COHSM_DEF void cohsm_stream_get_stats(const cohsm_stream *stream, cohsm_stream_stats *out);
/* Does nothing if a pointer is NULL. */

COHSM_DEF void cohsm_stream_free(cohsm_stream *stream);
/* Gives back a stream and all its objects, held or not: their maps end with it. NULL is allowed. */
