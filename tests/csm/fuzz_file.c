/* fuzz_file - libFuzzer target: any bytes as a plain or packed file of csm.h, then every function on what was accepted,
   and a round trip through the packed form. The file begins at byte 1; byte 0 says bit 0   mend the checksum, so that
   the checks behind it are reached bit 1   the file is packed first, and eight places of the packed form changed as the
   last 32 bytes say. The last three choose odd services (kit/odd.h), by which it is opened as well. */

#define COHSM_STATIC
#define CSM_IMPLEMENTATION
#include "csm.h"
#include "use.h"
#include "odd.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* The checksum of a packed file is that of the block it holds: decode that, whatever the sum says. */
static void mend(uint8_t *file, size_t size)
{
    const cohsm__logger log = cohsm__logger_of(NULL, "fuzz_file");
    cohsm__allocator a;
    cohsm__part part;
    cohsm__header h;
    uint8_t *inner = file + COHSM__PACK_HEADER;
    uint32_t *words;

    if (size < 16 || cohsm__get_u32(file) != COHSM__PACK_MAGIC) {
        if (size > 16) cohsm__put_u32(file + 12, cohsm__crc32(0, file + 16, size - 16));
        return;
    }
    if (size >= COHSM__PACK_HEADER + 16 && cohsm__get_u32(file + 12) == 0) {      /* a plain file in it */
        cohsm__put_u32(inner + 12, cohsm__crc32(0, inner + 16, size - COHSM__PACK_HEADER - 16));
        return;
    }
    if (size < COHSM__PACK_HEADER + sizeof h) return;
    memcpy(&h, inner, sizeof h);
    cohsm__host_words((uint32_t *)(void *)&h, COHSM__HEADER_WORDS);
    if (!cohsm__header_sound(&h) || cohsm__pack_head(&h) > size || h.words > 64 * size ||
        cohsm__get_u32(file + 12) > h.view_count || !cohsm__services_of(NULL, &log, &a, &part))
        return;
    words = (uint32_t *)calloc(h.words, 4);
    if (!words) return;
    (void)cohsm__unpack_words(file, size, &a, part, &h, words);
    cohsm__put_u32(inner + 12, cohsm__block_crc(words, h.words));
    free(words);
}

/* Takes the maps. */
static void check(cohsm_maps *maps)
{
    if (!use_maps(maps) || !use_packed(maps)) abort();
    cohsm_free(maps);
}

static void change_packed(const cohsm_maps *maps, const uint8_t *changes, int mended)
{
    cohsm_maps *back;
    void *packed;
    size_t size, i;

    if (cohsm_pack(maps, NULL, &packed, &size) != COHSM_OK) return;
    for (i = 0; i < 32; i += 4) {
        uint8_t *file = (uint8_t *)packed;
        file[(changes[i] | (size_t)changes[i + 1] << 8) % size] ^= changes[i + 2];
        if (changes[i + 3] & 128) file[16 + changes[i + 3] % 64 * 4] ^= changes[i + 2];      /* the header, often */
    }
    if (mended) mend((uint8_t *)packed, size);
    if (cohsm_open(packed, size, NULL, &back) == COHSM_OK) check(back);
    free(packed);
}

/* The same answer by odd services, in either layout; what they opened can be asked. */
static void open_oddly(odd *o, const uint8_t *file, size_t size, cohsm_result calm)
{
    cohsm_layout layout = o->order & 64 ? COHSM_LAYOUT_FAST : COHSM_LAYOUT_COMPACT;
    cohsm_system system;
    cohsm_maps *maps;

    memset(&system, 0, sizeof system);
    ODD_SYSTEM(&system, o);
    ODDLY(o, calm, cohsm_open_as(file, size, layout, 0, &system, &maps));
    if (calm == COHSM_OK) {
        if (!use_maps(maps)) abort();
        cohsm_free(maps);
    }
    odd_done(o);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    cohsm_maps *maps;
    uint8_t *copy;
    cohsm_result result;
    odd o;

    if (size < 1) return 0;
    copy = (uint8_t *)malloc(size);
    if (!copy) return 0;
    memcpy(copy, data + 1, size - 1);
    if (data[0] & 2 && size > 33) {
        size_t room = size - 33;
        mend(copy, room);
        if (cohsm_open(copy, room, NULL, &maps) == COHSM_OK) {
            change_packed(maps, copy + room, data[0] & 1);
            cohsm_free(maps);
        }
    } else {
        if (data[0] & 1) mend(copy, size - 1);
        result = cohsm_open(copy, size - 1, NULL, &maps);
        odd_take(&o, data, size);
        open_oddly(&o, copy, size - 1, result);
        if (result == COHSM_OK) check(maps);
    }
    free(copy);
    return 0;
}
