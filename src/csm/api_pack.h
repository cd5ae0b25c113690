COHSM_DEF cohsm_result cohsm_pack(const cohsm_maps *maps, const cohsm_system *system, void **data,
                                  size_t *bytes);
/* Makes the packed file, from which cohsm_open makes the same block again. It is entropy-coded against
   neighbouring pixels, and takes about half of the plain size, for simple objects far less.
   system   NULL: malloc and free, no progress
   data     written on COHSM_OK only, memory from the system's allocator: give it back there
   Errors   COHSM_ERR_ARGUMENT, COHSM_ERR_DESC (allocator), COHSM_ERR_ALLOC, COHSM_ERR_LIMIT,
            COHSM_ERR_CANCELLED
   Cost     about 1 microsecond a segment, half of it to check that the file decodes to the same block;
            cohsm_open takes the other half. Memory: twice the block, and the packed file */
