/* csm_compression.c - what coherent shadow maps cost in bytes and build time. Every row is verified. */
#include "bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_ROWS = 64 };

typedef struct row {
    const char  *domain;
    uint32_t     side, m;
    cohsm_layers layers;
    cohsm_info   info;
    cohsm_stats  stats;
    double       seconds, packed_bytes;
    int          verified, best;
} row;

static const char *layers_name(cohsm_layers layers)
{
    static const char *const names[] = { "default", "z1z2", "z1z3_sphere", "z1z3_far" };
    return names[layers];
}

static const char *order_name(cohsm_order order)
{
    static const char *const names[] = { "default", "scanline", "zigzag", "zigzag_theta", "hilbert" };
    return names[order];
}

static void print(const bn_options *options, const bn_model *model, const row *r)
{
    double pixels = (double)r->info.map_side * r->info.map_side, cubes = r->info.positional ? 6 : 1;
    double raw = r->info.ratio * (double)r->info.bytes;
    bn_begin(options, "csm_compression", options->threads, bn_simd());
    bn_text("model", model->name);
    bn_integer("triangles", r->stats.triangles);
    bn_text("domain", r->domain);
    bn_integer("map_count", r->info.map_count);
    bn_integer("side", r->side);
    bn_integer("map_side", r->m);
    bn_text("order", order_name(r->info.order));
    bn_text("layers", layers_name(r->layers));
    bn_number("ratio", r->info.ratio);
    bn_integer("bytes", r->info.bytes);
    bn_number("packed_ratio", raw / r->packed_bytes);
    bn_number("packed_bytes", r->packed_bytes);
    bn_number("paper_ratio", raw / (4 * (double)r->info.segment_count + 4 * pixels * cubes));
    bn_number("segments_per_pixel", (double)r->info.segment_count / pixels);
    bn_number("build_s", r->seconds);
    bn_integer("peak_bytes", r->stats.peak_bytes);
    bn_flag("verified", r->verified);
    bn_flag("best", r->best);
    bn_end(options);
}

/* One diameter of the bounding sphere above the object, and one wide. */
static void local_area(const bn_model *model, cohsm_domain *domain)
{
    float diameter = 0;
    for (int k = 0; k < 3; k++)
        diameter += (model->high[k] - model->low[k]) * (model->high[k] - model->low[k]);
    diameter = sqrtf(diameter);
    domain->kind = COHSM_DOMAIN_RECTANGLE;
    for (int k = 0; k < 3; k++)
        domain->origin[k] = 0.5f * (model->low[k] + model->high[k]);
    domain->origin[0] -= 0.5f * diameter;
    domain->origin[1] = model->high[1] + diameter;
    domain->origin[2] -= 0.5f * diameter;
    domain->u[0] = domain->v[2] = diameter;
}

static int measure(const bn_options *options, const bn_model *model, const char *domain, uint32_t side, uint32_t m,
                   cohsm_layers layers, cohsm_order order, row *r)
{
    cohsm_desc desc = bn_desc(options);
    cohsm_mesh mesh = bn_model_mesh(model);
    cohsm_maps *maps;
    cohsm_report report;
    cohsm_result result;
    void *packed = NULL;
    size_t packed_size = 0;
    memset(r, 0, sizeof *r);
    r->domain = domain;
    r->side = side;
    r->m = m;
    r->layers = layers;
    if (strcmp(domain, "local_area") == 0)
        local_area(model, &desc.domain);
    else if (strcmp(domain, "octahedral") == 0)
        desc.domain.kind = COHSM_DOMAIN_OCTAHEDRAL;
    desc.domain.side[0] = desc.domain.side[1] = side;
    desc.map_side = m;
    desc.layers = layers;
    desc.order = order;
    r->seconds = ex_seconds();
    result = cohsm_build(&desc, &mesh, &maps, &r->stats);
    r->seconds = ex_seconds() - r->seconds;
    ex_progress(NULL, 1);
    if (result != COHSM_OK)
        return bn_failed(model->name, cohsm_result_text(result));
    cohsm_get_info(maps, &r->info);
    result = cohsm_verify(maps, &desc.system, &mesh, &report);
    r->verified = result == COHSM_OK && report.wrong == 0;
    if (result == COHSM_OK)
        result = cohsm_pack(maps, &desc.system, &packed, &packed_size);
    ex_progress(NULL, 1);
    r->packed_bytes = (double)packed_size;
    free(packed);
    cohsm_free(maps);
    return result == COHSM_OK ? 0 : bn_failed(model->name, cohsm_result_text(result));
}

/* All layers, in all orders or in the one that the trial takes. The smallest of each layers is best. */
static int measure_orders(const bn_options *options, const bn_model *model, const char *domain, uint32_t side,
                          int all_orders)
{
    for (int layers = COHSM_LAYERS_Z1Z2; layers < COHSM_LAYERS_COUNT; layers++) {
        row rows[COHSM_ORDER_COUNT];
        size_t count = 0, best = 0;
        int first = all_orders ? COHSM_ORDER_SCANLINE : COHSM_ORDER_DEFAULT;
        int last = all_orders ? COHSM_ORDER_COUNT - 1 : COHSM_ORDER_DEFAULT;
        for (int order = first; order <= last; order++, count++) {
            if (measure(options, model, domain, side, 128, (cohsm_layers)layers, (cohsm_order)order, &rows[count]))
                return -1;
            if (rows[count].info.bytes < rows[best].info.bytes)
                best = count;
        }
        rows[best].best = 1;
        for (size_t i = 0; i < count; i++)
            print(options, model, &rows[i]);
    }
    return 0;
}

static int measure_one(const bn_options *options, const bn_model *model, const char *domain, uint32_t side, uint32_t m,
                       cohsm_layers layers)
{
    row r;
    if (measure(options, model, domain, side, m, layers, COHSM_ORDER_DEFAULT, &r) != 0)
        return -1;
    r.best = 1;
    print(options, model, &r);
    return 0;
}

/* What the default leaves out for its time. */
static int measure_more(const bn_options *options, const bn_model *model)
{
    static const uint32_t sides[] = { 32, 256 };
    for (size_t i = 0; i < 2; i++)
        if (measure_one(options, model, "latlong", sides[i], 128, COHSM_LAYERS_Z1Z2) != 0)
            return -1;
    return measure_one(options, model, "latlong", 128, 256, COHSM_LAYERS_Z1Z2) ||
           measure_orders(options, model, "octahedral", 128, 0) ? -1 : 0;
}

/* All orders, or local light: both of the dragon take above ten minutes. */
static int measure_model(const bn_options *options, const bn_model *model, int is_first)
{
    if (measure_orders(options, model, "latlong", 128, options->model || options->full) != 0)
        return -1;
    if ((options->full || (is_first && !options->model)) &&
        measure_one(options, model, "local_area", 128, 128, COHSM_LAYERS_Z1Z2) != 0)
        return -1;
    return options->full ? measure_more(options, model) : 0;
}

int bn_csm_compression(const bn_options *options)
{
    bn_model models[BN_MOST_MODELS];
    size_t count;
    int result = 0;
    if (bn_models_load(options, models, &count) != 0)
        return -1;
    for (size_t i = 0; i < count; i++) {
        if (result == 0)
            result = measure_model(options, &models[i], i == 0);
        bn_model_free(&models[i]);
    }
    if (result == 0 && options->full && bn_model_load(&models[0], "builtin:knot") == 0) {
        result = measure_one(options, &models[0], "latlong", 1024, 128, COHSM_LAYERS_Z1Z2);    /* a million maps */
        bn_model_free(&models[0]);
    }
    return result;
}
