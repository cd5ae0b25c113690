/* fuzz_builder - libFuzzer target: bytes choose a desc, layers and a mesh; what is built must hold its intervals,
   verify, and open again from a plain and from a packed file. */

#define CSM_IMPLEMENTATION
#include "csm.h"
#include "use.h"

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

static void take_desc(input *in, cohsm_desc *d, float *locations)
{
    uint32_t i;
    memset(d, 0, sizeof *d);
    d->domain.kind = (cohsm_domain_kind)(take(in) % (COHSM_DOMAIN_COUNT + 1));
    for (i = 0; i < 3; i++) d->domain.side[i] = take(in) % 12;
    d->map_side = 4 + take(in) % 21;
    d->layers = (cohsm_layers)(take(in) % (COHSM_LAYERS_COUNT + 1));
    d->order = (cohsm_order)(take(in) % COHSM_ORDER_COUNT);
    d->orientation = (cohsm_orientation)(take(in) % COHSM_ORIENTATION_COUNT);
    d->depth_bits = take(in) % 10;
    d->self_only = (int)(take(in) & 1u);
    if (take(in) & 1u) {
        d->pixel_begin = take(in);
        d->pixel_end = d->pixel_begin + take(in);
    }
    if (take(in) & 1u) {
        for (i = 0; i < 3; i++) {
            d->domain.origin[i] = 3 * take_float(in);
            d->domain.u[i] = take_float(in);
            d->domain.v[i] = take_float(in);
            d->domain.w[i] = take_float(in);
        }
    } else {
        d->domain.origin[1] = 2;
        d->domain.u[0] = d->domain.v[2] = d->domain.w[1] = 1;
    }
    d->domain.location_count = take(in) % 17;
    for (i = 0; i < 64; i++) locations[i] = i % 4 == 3 ? (float)(take(in) & 1u) : take_float(in);
    d->domain.locations = locations;
    if (!d->domain.side[0]) d->domain.side[0] = 2;
    if (!d->domain.side[1]) d->domain.side[1] = d->domain.kind == COHSM_DOMAIN_LINE ? 0 : 2;
    if (!d->domain.side[2] && d->domain.kind == COHSM_DOMAIN_VOLUME) d->domain.side[2] = 2;
}

static void check(cohsm_maps *maps, const cohsm_mesh *mesh)
{
    cohsm_report report;
    if (mesh && cohsm_verify(maps, NULL, mesh, &report) == COHSM_OK && report.wrong) abort();
    if (!use_maps(maps) || !use_packed(maps)) abort();
    cohsm_free(maps);
}

static void from_layers(input *in, cohsm_desc *d)
{
    cohsm_builder *b;
    cohsm_maps *maps;
    float z[3][24 * 24];
    uint32_t views, i, p, pixels = d->map_side * d->map_side;

    d->radius = 1;
    if (d->order == COHSM_ORDER_DEFAULT) d->order = COHSM_ORDER_HILBERT;
    if (cohsm_builder_create(d, &b) != COHSM_OK) return;
    views = cohsm_builder_view_count(b);
    for (i = 0; i < views; i++) {
        float base = take_float(in), step = 0.01f * take_float(in);
        for (p = 0; p < pixels; p++) {
            z[0][p] = base + step * (float)(p % 7);
            z[1][p] = z[0][p] + (p % 5 ? 0.02f : 0.0f);
            z[2][p] = z[1][p] + (i % 3 ? 0.5f : 2.0f);
        }
        if (cohsm_builder_add(b, i, z[0], z[1], z[2]) != COHSM_OK) break;
    }
    if (cohsm_builder_finish(b, &maps, NULL) == COHSM_OK) check(maps, NULL);
    cohsm_builder_free(b);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in;
    cohsm_desc d;
    cohsm_mesh mesh;
    cohsm_maps *maps;
    float locations[64], positions[3 * 40];
    uint32_t indices[60], i;

    in.data = data;
    in.size = size;
    in.at = 0;
    take_desc(&in, &d, locations);
    if (d.map_side > 24) d.map_side = 24;
    if (d.domain.kind == COHSM_DOMAIN_VOLUME && d.domain.side[0] * d.domain.side[1] * d.domain.side[2] > 200) return 0;
    if (take(&in) & 1u) {
        from_layers(&in, &d);
        return 0;
    }
    memset(&mesh, 0, sizeof mesh);
    for (i = 0; i < 120; i++) positions[i] = take_float(&in);
    for (i = 0; i < 60; i++) indices[i] = take(&in) % 41u;
    mesh.positions = positions;
    mesh.vertex_count = 40;
    mesh.index_count = 3 * (take(&in) % 21u);
    if (take(&in) & 3u) mesh.indices = indices;
    else mesh.vertex_count = 39;
    if (cohsm_build(&d, &mesh, &maps, NULL) == COHSM_OK) check(maps, &mesh);
    return 0;
}
