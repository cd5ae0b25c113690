/* fuzz_file - libFuzzer target: any bytes as a file of shadowfield.h, then every function on what was accepted. An
   odd first byte mends the checksum, so that the checks behind it are reached. The file begins at byte 1. */

#define SHADOWFIELD_IMPLEMENTATION
#include "shadowfield.h"
#include "use.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    sfield_field *f;
    uint8_t *copy;

    if (size < 1) return 0;
    copy = (uint8_t *)malloc(size);
    if (!copy) return 0;
    memcpy(copy, data + 1, size - 1);
    if ((data[0] & 1) && size > 17) sfield__put_u32(copy + 12, sfield__crc32(0, copy + 16, size - 17));
    if (sfield_open(copy, size - 1, NULL, &f) == SFIELD_OK) {
        if (!use_field(f)) abort();
        sfield_free(f);
    }
    free(copy);
    return 0;
}
