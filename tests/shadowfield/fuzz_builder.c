/* fuzz_builder - libFuzzer target: bytes choose a desc and a mesh; what is built must be usable and open again.
   The last bytes choose odd services (kit/odd.h), by which the same is built, opened and shaded. */

#define SFIELD_STATIC
#define SHADOWFIELD_IMPLEMENTATION
#include "shadowfield.h"
#include "use.h"
#include "input.h"
#include "odd.h"

/* Receivers as a literal: count positions and normals. */
#define AT(p, n, number) &(const sfield_points){ .count = (number), .positions = (p), .normals = (n) }

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

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

typedef struct asked {          /* what a field is built of */
    uint32_t              what;
    const sfield_mesh    *mesh;
    const sfield_emitter *emitter;
    const float          *radiance, *points;
} asked;

static sfield_result build(const sfield_desc *d, const asked *a, sfield_field **f)
{
    switch (a->what) {
    case 0: return sfield_build(d, a->mesh, f, NULL);
    case 1: return d->frame_count < 3 ? sfield_build_emissive(d, a->mesh, a->radiance, f, NULL) : SFIELD_ERR_DESC;
    case 2: return sfield_build_emitter(d, a->emitter, f, NULL);
    default: return sfield_build_self(d, a->mesh, AT(a->points, a->points + 12, 4), 0.01f, f, NULL);
    }
}

/* Light of a sky on four points past the field, by a scene with these services. Zero where there is no such scene. */
static void shade(const sfield_field *f, const sfield_system *system, odd *o, float *rgb)
{
    static const float sky[3] = { 1, 0.5f, 0.25f };
    static const float p[12] = { 0, 0, 0, 1, 2, 3, -5, 0.1f, 0, 0.3f, -1, 3 },
                       n[12] = { 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0 };
    sfield_scene_desc desc;
    sfield_entity e = upright;
    sfield_points set;
    sfield_scene *s;
    sfield_info info;
    sfield_get_info(f, &info);
    memset(&desc, 0, sizeof desc);
    memset(&set, 0, sizeof set);
    desc.basis = info.basis;
    desc.bands = info.bands;
    desc.cube_side = info.basis == SFIELD_BASIS_HAAR ? info.cube_side : 4;
    if (info.logarithm) desc.product = SFIELD_PRODUCT_EXP;
    desc.system = *system;
    memset(rgb, 0, 12 * sizeof *rgb);
    if (info.kind == SFIELD_KIND_SELF || info.shard_end) return;
    if (info.kind == SFIELD_KIND_OCCLUSION) e.occlusion = f;
    else e.source = f;
    set.count = 4;
    set.positions = p;
    set.normals = n;
    set.rgb = rgb;
    ODDLY(o, SFIELD_OK, sfield_scene_create(&desc, &s));
    ODDLY(o, SFIELD_OK, sfield_scene_environment(s, sky, 1, 1, NULL));
    ODDLY(o, SFIELD_OK, sfield_scene_entities(s, &e, 1));
    ODDLY(o, SFIELD_OK, sfield_shade(s, &set, 1, NULL));
    sfield_scene_free(s);
}

static void build_oddly(odd *o, const sfield_desc *d, const asked *a, sfield_result calm, const sfield_field *f)
{
    sfield_desc mine = *d;
    sfield_field *built, *again;
    size_t size;
    uint8_t *bytes;
    float rgb[2][12];
    odd none;

    ODD_SYSTEM(&mine.system, o);
    ODDLY(o, calm, build(&mine, a, &built));
    if (calm != SFIELD_OK) return;
    size = sfield_bytes(f);
    bytes = (uint8_t *)malloc(2 * size);
    if (!bytes || sfield_bytes(built) != size || sfield_write(f, bytes, size) != SFIELD_OK ||
        sfield_write(built, bytes + size, size) != SFIELD_OK)
        abort();
    odd_equal(bytes, bytes + size, size);
    if (!use_field(built)) abort();
    ODDLY(o, SFIELD_OK, sfield_open(bytes, size, &mine.system, &again));
    odd_take(&none, NULL, 0);
    shade(f, &d->system, &none, rgb[0]);
    shade(again, &mine.system, o, rgb[1]);
    odd_equal(rgb[0], rgb[1], sizeof rgb[0]);
    sfield_free(again);
    sfield_free(built);
    free(bytes);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in;
    asked a;
    odd o;
    sfield_result result;
    sfield_desc d;
    sfield_mesh mesh;
    sfield_emitter e;
    sfield_field *f;
    float p[24], radiance[48];
    uint32_t index[24], i;

    in = input_of(data, size);
    odd_take(&o, data, size);
    a.what = take(&in) % 4;
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
    a.mesh = &mesh;
    a.emitter = &e;
    a.radiance = radiance;
    a.points = p;
    result = build(&d, &a, &f);
    build_oddly(&o, &d, &a, result, f);
    odd_done(&o);
    if (result == SFIELD_OK) check(f);
    return 0;
}
