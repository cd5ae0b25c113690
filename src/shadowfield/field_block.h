/* ---- fields: the block that is kept and written ---- */

/* 32-bit words, little-endian in files, in the host's order in memory:

     header    SFIELD__HEADER words
     radii     shells floats, in r (SELF: none)
     SH        scale, then bias: `stride` floats a group (a shell of a frame; SELF: one), then the samples,
               `stride` bytes each: per channel n^2 bytes filled up to a multiple of 8. value = scale byte +
               bias
     HAAR      samples + 1 offsets into the entries, samples scales (floats), entries: `stride` words each:
               index << 16 | value, or index << 16 | r, g << 16 | b; values are signed 16 bit times the
               sample's scale

   Sample ((frame shells + shell) 6 + face) side^2 + y side + x of a field lies on the grid of nodes of a
   face, edges and corners included: those are stored by each face that has them, so that no query looks
   beyond its face. */
enum {
    SFIELD__MAGIC = 0x444c4653,     /* "SFLD" */
    SFIELD__FORMAT = 1,
    SFIELD__HEADER = 32
};

/* These numbers stand in files. */
typedef enum sfield__kind { SFIELD__KIND_OCCLUSION, SFIELD__KIND_SOURCE, SFIELD__KIND_SELF } sfield__kind;

typedef struct sfield__header {     /* 32-bit fields only */
    uint32_t magic, format, bytes, crc;
    uint32_t kind, basis, logarithm, bands;
    uint32_t cube_side, shells, position_side, spacing;
    uint32_t frames, loop;
    uint32_t channels, samples, stride, entries;
    float center[3], radius, inscribed;
    float frames_per_second, window;
    uint32_t shard_begin, shard_end, reserved[5];
} sfield__header;

struct sfield_field {
    sfield__allocator allocator;
    sfield__logger    log;          /* of the system that the field was made with */
    sfield__header    h;
    uint32_t         *words;        /* the block */
    const float      *radii, *scale, *bias;
    const uint8_t    *sample;
    const uint32_t   *offset, *entry;
    const float      *sample_scale;
    size_t            word_count;   /* of the block, samples of SH left out: these are bytes */
    float             radius2[64];  /* (radius of a shell / r)^2 */
    float             measure[64];  /* what weights are linear in, of each shell */
    uint32_t          planes;       /* floats a channel: n^2 up to a multiple of 8 */
    uint32_t          tone;         /* channels are multiples of this one, or 3 */
    float             ratio[3];
    float            *angle;        /* occlusion in wavelets: the solid angles of a face's texels, as
                                       wavelets */
};

static uint32_t sfield__groups(const sfield__header *h)
{
    return h->kind == SFIELD__KIND_SELF ? 1 : h->shells * h->frames;
}
static uint32_t sfield__planes(uint32_t bands) { return (bands * bands + 7) / 8 * 8; }

/* Returns a bound on every value of a field, coefficient or wavelet, far above what a build makes: with it no
   light comes near the largest float. What is hidden is 0..1 of each texel, radiance is 1e18 at most. */
static float sfield__most_value(const sfield__header *h)
{
    return h->kind == SFIELD__KIND_SOURCE ? 1e20f : 1e4f;
}

/* Counts the words before the bytes of harmonics, or all words of wavelets. */
static uint64_t sfield__block_words(const sfield__header *h)
{
    uint64_t n = SFIELD__HEADER + (uint64_t)h->shells;
    if (h->basis == SFIELD_BASIS_SH) return n + 2 * (uint64_t)sfield__groups(h) * h->stride;
    return n + 2 * (uint64_t)h->samples + 1 + (uint64_t)h->entries * h->stride;
}

static uint64_t sfield__block_bytes(const sfield__header *h)
{
    return 4 * sfield__block_words(h) + (h->basis == SFIELD_BASIS_SH ? (uint64_t)h->samples * h->stride : 0);
}

/* Returns what weights are linear in: the solid angle that a sphere of radius 1 fills at distance d > 1, over
   2 pi; below, and for lights, 1 / d^2; for uniform shells -d. */
SFIELD__INLINE float sfield__measure_of(float d2, uint32_t kind, uint32_t spacing)
{
    float inverse = 1 / d2, u = inverse < 1 ? inverse : 1.0f, g = u / (1 + sqrtf(1 - u));
    if (spacing == SFIELD_SPACING_UNIFORM) return -sqrtf(d2);
    return kind == SFIELD__KIND_SOURCE || d2 < 1 ? inverse : g;
}

static void sfield__bind_block(sfield_field *f)
{
    const sfield__header *h = &f->h;
    const uint32_t *w = f->words + SFIELD__HEADER;
    f->word_count = (size_t)sfield__block_words(h);
    f->planes = sfield__planes(h->bands);
    f->radii = (const float *)(const void *)w;
    w += h->shells;
    if (h->basis == SFIELD_BASIS_SH) {
        f->scale = (const float *)(const void *)w;
        f->bias = f->scale + (size_t)sfield__groups(h) * h->stride;
        f->sample = (const uint8_t *)(f->words + f->word_count);
    } else {
        f->offset = w;
        f->sample_scale = (const float *)(const void *)(w + h->samples + 1);
        f->entry = w + 2 * (size_t)h->samples + 1;
    }
}

#ifndef SFIELD_WITHOUT_WAVELETS
/* Transforms the solid angles of a face's texels. Haar wavelets are orthonormal, so that the solid angle that
   a list hides is its dot product with these, the same for all six faces. */
static void sfield__find_angles(sfield_field *f)
{
    float texels[4096], direction[3];
    uint32_t i;
    for (i = 0; i < f->h.cube_side * f->h.cube_side; i++)
        texels[i] = sfield_cube_texel(f->h.cube_side, i, direction);
    sfield__haar_face(f->h.cube_side, texels, f->angle, 0);
}
#endif

/* Takes the radii of the shells from a block that is complete. */
static void sfield__bind_shells(sfield_field *f)
{
    uint32_t k;
    sfield__bind_block(f);
#ifndef SFIELD_WITHOUT_WAVELETS
    if (f->angle) sfield__find_angles(f);
#endif
    for (k = 0; k < f->h.shells; k++) {
        f->radius2[k] = f->radii[k] * f->radii[k];
        f->measure[k] = sfield__measure_of(f->radius2[k], f->h.kind, f->h.spacing);
    }
}

/* Allocates the block that a header describes. The header itself is written at the end of a build. */
static sfield_result sfield__alloc_field(const sfield__allocator *a, const sfield__logger *log,
                                         const sfield__header *h, sfield_field **out)
{
    const int angles = h->basis == SFIELD_BASIS_HAAR && h->kind == SFIELD__KIND_OCCLUSION;
    uint64_t bytes = sfield__block_bytes(h);
    sfield_field *f;
    if (bytes > 0xffffffffu || bytes > SIZE_MAX - 8) return SFIELD_ERR_LIMIT;
    f = (sfield_field *)sfield__alloc(a, sizeof *f +
                                             (angles ? h->cube_side * h->cube_side * sizeof *f->angle : 0));
    if (!f) return SFIELD_ERR_ALLOC;
    memset(f, 0, sizeof *f);
    f->angle = angles ? (float *)(void *)(f + 1) : NULL;
    f->allocator = *a;
    f->log = *log;
    f->h = *h;
    f->h.bytes = (uint32_t)bytes;
    f->words = (uint32_t *)sfield__alloc(a, (size_t)bytes + 8);     /* kernels read as far past samples */
    if (!f->words) {
        sfield__free(a, f);
        return SFIELD_ERR_ALLOC;
    }
    memset(f->words + bytes / 4, 0, 8);
    sfield__bind_block(f);
    *out = f;
    return SFIELD_OK;
}

SFIELD_DEF void sfield_free(sfield_field *field)
{
    sfield__allocator a;
    if (!field) return;
    a = field->allocator;
    sfield__free(&a, field->words);
    sfield__free(&a, field);
}

/* Returns whether everything in the header is right, so that sizes computed from it are true. */
static int sfield__header_good(const sfield__header *h)
{
    uint32_t i, self = h->kind == SFIELD__KIND_SELF, haar = h->basis == SFIELD_BASIS_HAAR;
    if (h->kind > SFIELD__KIND_SELF || h->basis < SFIELD_BASIS_SH || h->basis > SFIELD_BASIS_HAAR) return 0;
#ifdef SFIELD_WITHOUT_WAVELETS
    if (haar) return 0;
#endif
    if (h->logarithm > 1 || (h->logarithm && (h->kind != SFIELD__KIND_OCCLUSION || haar)) || h->loop > 1)
        return 0;
    if (haar ? h->bands != 0 : h->bands < 1 || h->bands > SFIELD_MAX_BANDS) return 0;
    if (!sfield__is_side(h->cube_side, 4) || h->channels != (h->kind == SFIELD__KIND_SOURCE ? 3u : 1u))
        return 0;
    if (h->spacing < SFIELD_SPACING_GEOMETRIC || h->spacing > SFIELD_SPACING_UNIFORM) return 0;
    if (h->frames < 1 || h->frames > 256 || (h->frames > 1 && h->kind != SFIELD__KIND_SOURCE)) return 0;
    if (!sfield__in(h->frames_per_second, 1e-6f, 1e6f) || !sfield__in(h->window, 0, 1e6f)) return 0;
    for (i = 0; i < 3; i++)
        if (!sfield__in(h->center[i], -1e18f, 1e18f)) return 0;
    if (!sfield__in(h->radius, 1e-18f, 1e18f) || !sfield__in(h->inscribed, 0, h->radius)) return 0;
    for (i = 0; i < 5; i++)
        if (h->reserved[i]) return 0;
    if (h->shard_end ? self || h->shard_begin >= h->shard_end || h->shard_end > sfield__groups(h)
                     : h->shard_begin)
        return 0;
    if (haar ? h->stride != (h->channels == 3 ? 2u : 1u)
             : h->stride != h->channels * sfield__planes(h->bands))
        return 0;
    if (!haar && h->entries) return 0;
    if (self) return h->shells == 0 && h->position_side == 0 && h->samples >= 1;
    if (h->shells < 2 || h->shells > 64 || h->position_side < 2 || h->position_side > 64) return 0;
    return h->samples == h->frames * h->shells * 6 * h->position_side * h->position_side;
}

SFIELD_DEF void sfield_get_info(const sfield_field *field, sfield_info *out)
{
    const sfield__header *h;
    if (!field || !out) return;
    h = &field->h;
    memset(out, 0, sizeof *out);
    out->kind = (sfield_kind)(h->kind + 1);
    out->basis = (sfield_basis)h->basis;
    out->bands = h->bands;
    out->cube_side = h->cube_side;
    out->shell_count = h->shells;
    out->position_side = h->position_side;
    out->frame_count = h->frames;
    out->spacing = (sfield_spacing)h->spacing;
    out->logarithm = (int)h->logarithm;
    out->sample_count = h->samples;
    out->coefficient_count = h->entries;
    out->bytes = h->bytes;
    memcpy(out->center, h->center, sizeof h->center);
    out->radius = h->radius;
    out->inscribed = h->inscribed;
    out->inner = h->shells ? field->radii[0] : 0;
    out->outer = h->shells ? field->radii[h->shells - 1] : 0;
    out->shard_begin = h->shard_begin;
    out->shard_end = h->shard_end;
}
