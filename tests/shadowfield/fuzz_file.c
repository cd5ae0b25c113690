/* fuzz_file - libFuzzer target: any bytes as a file of shadowfield.h, then every function on what was accepted. An
   odd first byte mends the checksum, so that the checks behind it are reached. The file begins at byte 1. Its last
   three bytes choose odd services (kit/odd.h), by which it is opened as well. */

#define SFIELD_STATIC
#define SHADOWFIELD_IMPLEMENTATION
#include "shadowfield.h"
#include "use.h"
#include "odd.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void open_oddly(const uint8_t *data, size_t size, sfield_result calm)
{
    sfield_system system;
    sfield_field *f;
    odd o;
    odd_take(&o, data, size);
    memset(&system, 0, sizeof system);
    ODD_SYSTEM(&system, &o);
    ODDLY(&o, calm, sfield_open(data, size, &system, &f));
    if (calm == SFIELD_OK) {
        if (!use_field(f)) abort();
        sfield_free(f);
    }
    odd_done(&o);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    sfield_field *f;
    sfield_result result;
    uint8_t *copy;

    if (size < 1) return 0;
    copy = (uint8_t *)malloc(size);
    if (!copy) return 0;
    memcpy(copy, data + 1, size - 1);
    if ((data[0] & 1) && size > 17) sfield__put_u32(copy + 12, sfield__crc32(0, copy + 16, size - 17));
    result = sfield_open(copy, size - 1, NULL, &f);
    open_oddly(copy, size - 1, result);
    if (result == SFIELD_OK) {
        if (!use_field(f)) abort();
        sfield_free(f);
    }
    free(copy);
    return 0;
}
