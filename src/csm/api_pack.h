COHSM_DEF cohsm_result cohsm_pack(const cohsm_maps *maps, const cohsm_system *system, void **data,
                                  size_t *bytes);
/* Makes a packed file, from which cohsm_open makes the same block again. The lists of a pixel are
   entropy-coded with those of its neighbours as context, which takes about half of the plain size, and far
   less for simple objects.
   system   NULL: malloc and free, no progress, no log
   data     receives memory from the system's allocator, on COHSM_OK only: give it back to that allocator
   bytes    receives the size of the file, on COHSM_OK only
   Errors   COHSM_ERR_ARGUMENT (NULL), COHSM_ERR_DESC (allocator), COHSM_ERR_ALLOC, COHSM_ERR_LIMIT,
            COHSM_ERR_CANCELLED
   Cost     About 1 microsecond a segment, half of it to check that the file decodes to the same block;
            cohsm_open needs half a microsecond a segment. The memory needed is twice the block and the packed
            file */
