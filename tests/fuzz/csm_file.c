/* csm_file - libFuzzer target: any bytes as a file of csm.h, then every function on what was accepted. An even first byte
   leaves the checksum as it is; an odd one mends it, so that the checks behind it are reached. The file begins at byte 1. */

#define CSM_IMPLEMENTATION
#include "csm.h"
#include "unit/csm_use.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    cohsm_maps *maps;
    uint8_t *copy;

    if (size < 1) return 0;
    copy = (uint8_t *)malloc(size);
    if (!copy) return 0;
    memcpy(copy, data + 1, size - 1);
    if ((data[0] & 1) && size > 17) cohsm__put_u32(copy + 12, cohsm__crc32(0, copy + 16, size - 17));
    if (cohsm_open(copy, size - 1, NULL, &maps) == COHSM_OK) {
        if (!use_maps(maps)) abort();
        cohsm_free(maps);
    }
    free(copy);
    return 0;
}
