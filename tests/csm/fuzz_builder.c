/* fuzz_builder - libFuzzer target: bytes choose a desc, layers and a mesh; what is built must hold its intervals,
   verify, and open again from a plain and from a packed file. The last bytes choose odd services (kit/odd.h), by which
   the same is built. */

#define COHSM_STATIC
#define CSM_IMPLEMENTATION
#include "csm.h"
#include "use.h"
#include "input.h"
#include "odd.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

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

static void expect_same(const cohsm_maps *a, const cohsm_maps *b)
{
    size_t size, other;
    const void *p = cohsm_data(a, &size), *q = cohsm_data(b, &other);
    if (size != other) abort();
    odd_equal(p, q, size);
}

/* By odd services maps are built that are the same, and may be asked, packed, opened, merged and verified. */
static void build_oddly(odd *o, const cohsm_desc *d, const cohsm_mesh *mesh, cohsm_result calm, const cohsm_maps *maps)
{
    cohsm_desc mine = *d;
    cohsm_maps *built, *again;
    const cohsm_maps *shards[1];
    cohsm_result merged, verified;
    cohsm_report report;
    void *packed;
    size_t size;

    ODD_SYSTEM(&mine.system, o);
    ODDLY(o, calm, cohsm_build(&mine, mesh, &built, NULL));
    if (calm != COHSM_OK) return;
    expect_same(maps, built);
    if (!use_maps(built)) abort();
    shards[0] = built;
    merged = cohsm_merge(shards, 1, NULL, &again);
    if (merged == COHSM_OK) cohsm_free(again);
    ODDLY(o, merged, cohsm_merge(shards, 1, &mine.system, &again));
    if (merged == COHSM_OK) cohsm_free(again);
    verified = cohsm_verify(built, NULL, mesh, &report);
    ODDLY(o, verified, cohsm_verify(built, &mine.system, mesh, &report));
    ODDLY(o, COHSM_OK, cohsm_pack(built, &mine.system, &packed, &size));
    ODDLY(o, COHSM_OK, cohsm_open(packed, size, &mine.system, &again));
    expect_same(built, again);
    cohsm_free(again);
    ODDLY(o, COHSM_OK, cohsm_open_as(packed, size, COHSM_LAYOUT_FAST, 0, &mine.system, &again));
    expect_same(built, again);
    cohsm_free(again);
    ledger_free(packed, &o->memory);
    cohsm_free(built);
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
    cohsm_result result;
    odd o;

    in = input_of(data, size);
    odd_take(&o, data, size);
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
    result = cohsm_build(&d, &mesh, &maps, NULL);
    build_oddly(&o, &d, &mesh, result, maps);
    odd_done(&o);
    if (result == COHSM_OK) check(maps, &mesh);
    return 0;
}
