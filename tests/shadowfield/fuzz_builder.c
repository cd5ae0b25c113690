/* fuzz_builder - libFuzzer target: bytes choose a desc and a mesh; what is built must be usable and open again. */

#define SHADOWFIELD_IMPLEMENTATION
#include "shadowfield.h"
#include "use.h"

/* Receivers as a literal: count positions and normals. */
#define AT(p, n, number) &(const sfield_points){ .count = (number), .positions = (p), .normals = (n) }

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

typedef struct input { const uint8_t *data; size_t size, at; } input;

static uint32_t take(input *in) { return in->at < in->size ? in->data[in->at++] : 0u; }

/* Mostly in -1..1, seldom any bits at all. */
static float take_float(input *in)
{
    uint32_t a = take(in), b = take(in);
    if (a == 255) {
        uint32_t bits = b << 24 | take(in) << 16 | take(in) << 8 | take(in);
        float f;
        memcpy(&f, &bits, sizeof f);
        return f;
    }
    return (float)((int)(a << 8 | b) - 32640) / 32640.0f;
}

static void take_desc(input *in, sfield_desc *d)
{
    memset(d, 0, sizeof *d);
    d->basis = (sfield_basis)(take(in) % (SFIELD_BASIS_COUNT + 1));
    d->bands = take(in) % 5;
    d->cube_side = 4u << take(in) % 3;
    d->shell_count = 2 + take(in) % 3;
    d->position_side = 2 + take(in) % 2;
    d->spacing = (sfield_spacing)(take(in) % (SFIELD_SPACING_COUNT + 1));
    if (take(in) & 1u) {
        d->inner = take_float(in);
        d->outer = 8 * take_float(in);
        d->keep = take_float(in);
        d->window = take_float(in);
    }
    d->logarithm = (int)(take(in) & 1u);
    d->frame_count = take(in) % 3;
    if (take(in) & 1u) {
        d->center[0] = take_float(in);
        d->radius = take_float(in);
    }
}

static void check(sfield_field *f)
{
    size_t size = sfield_bytes(f);
    uint8_t *bytes = (uint8_t *)malloc(size);
    sfield_field *again;
    if (!bytes || !use_field(f)) abort();
    if (sfield_write(f, bytes, size) != SFIELD_OK || sfield_open(bytes, size, NULL, &again) != SFIELD_OK) abort();
    sfield_free(again);
    sfield_free(f);
    free(bytes);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in;
    sfield_desc d;
    sfield_mesh mesh;
    sfield_emitter e;
    sfield_field *f;
    float p[24], radiance[48];
    uint32_t index[24], i, what;

    in.data = data;
    in.size = size;
    in.at = 0;
    what = take(&in) % 4;
    take_desc(&in, &d);
    for (i = 0; i < 24; i++) p[i] = take_float(&in);
    for (i = 0; i < 24; i++) {
        uint32_t at = take(&in);
        index[i] = at < 255 ? at % 8 : 8;       /* 8 is refused */
    }
    for (i = 0; i < 48; i++) radiance[i] = (float)(take(&in) % 7u);
    memset(&mesh, 0, sizeof mesh);
    memset(&e, 0, sizeof e);
    mesh.positions = p;
    mesh.vertex_count = 8;
    mesh.indices = index;
    mesh.index_count = take(&in) % 25;
    e.kind = (sfield_emitter_kind)(take(&in) % SFIELD_EMITTER_COUNT);
    e.radius = take_float(&in);
    e.normal[take(&in) % 3] = 1;
    e.cone_half_angle = take_float(&in);
    for (i = 0; i < 3; i++) {
        e.u[i] = take_float(&in);
        e.v[i] = take_float(&in);
        e.radiance[i] = radiance[i];
    }
    if (what == 0 && sfield_build(&d, &mesh, &f, NULL) == SFIELD_OK) check(f);
    if (what == 1 && d.frame_count < 3 && sfield_build_emissive(&d, &mesh, radiance, &f, NULL) == SFIELD_OK) check(f);
    if (what == 2 && sfield_build_emitter(&d, &e, &f, NULL) == SFIELD_OK) check(f);
    if (what == 3 && sfield_build_self(&d, &mesh, AT(p, p + 12, 4), 0.01f, &f, NULL) == SFIELD_OK) check(f);
    return 0;
}
