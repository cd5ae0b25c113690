/* rays.c - Embree's occlusion rays in each of its modes, and tinybvh's beside them. */
#include "bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *bn_rays_mode_name(bn_ray_mode mode)
{
    static const char *const names[] = { "rtcOccluded1", "rtcOccluded8", "rtcOccluded16", "stream", "tinybvh" };
    return names[mode];
}

#if defined(DAPPLE_EMBREE) && DAPPLE_EMBREE > 0

#if DAPPLE_EMBREE == 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

struct bn_rays { RTCDevice device; RTCScene scene; bn_tinybvh *peer; };

const char *bn_rays_version(void) { return "Embree " RTC_VERSION_STRING; }

#if defined(DAPPLE_TINYBVH)
const char *bn_rays_peer_version(void) { return bn_tinybvh_version(); }
#else
const char *bn_rays_peer_version(void) { return NULL; }
#endif

bn_rays *bn_rays_create(const bn_model *model, int threads)
{
    bn_rays *r = calloc(1, sizeof *r);
    char config[64];
    RTCGeometry geometry;
    void *vertices, *indices;
    if (!r)
        return NULL;
    snprintf(config, sizeof config, "threads=%d", threads);
    r->device = rtcNewDevice(config);
    r->scene = rtcNewScene(r->device);
    geometry = rtcNewGeometry(r->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, model->vertices);
    indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, model->triangles);
    if (!vertices || !indices) {
        rtcReleaseGeometry(geometry);
        bn_rays_free(r);
        return NULL;
    }
    memcpy(vertices, model->positions, 12 * model->vertices);
    memcpy(indices, model->indices, 12 * model->triangles);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(r->scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(r->scene);
#if defined(DAPPLE_TINYBVH)
    r->peer = bn_tinybvh_create(model);
    if (!r->peer) {
        bn_rays_free(r);
        return NULL;
    }
#endif
    return r;
}

void bn_rays_free(bn_rays *r)
{
    if (!r)
        return;
    rtcReleaseScene(r->scene);
    rtcReleaseDevice(r->device);
#if defined(DAPPLE_TINYBVH)
    bn_tinybvh_free(r->peer);
#endif
    free(r);
}

/* The arguments of the two versions, which differ. */
#if DAPPLE_EMBREE == 4
typedef struct RTCOccludedArguments arguments;
static void init(arguments *a, int coherent)
{
    rtcInitOccludedArguments(a);
    a->flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
}
#else
typedef struct RTCIntersectContext arguments;
static void init(arguments *a, int coherent)
{
    rtcInitIntersectContext(a);
    a->flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
}
#endif

static void fill(struct RTCRay *ray, const float *p, const float *d)
{
    memset(ray, 0, sizeof *ray);
    ray->org_x = p[0], ray->org_y = p[1], ray->org_z = p[2];
    ray->dir_x = d[0], ray->dir_y = d[1], ray->dir_z = d[2];
    ray->tfar = HUGE_VALF;
    ray->mask = UINT32_MAX;
}

static void trace_1(const bn_rays *r, arguments *a, const float *p, const float *d, size_t count, float *lit)
{
    for (size_t i = 0; i < count; i++) {
        struct RTCRay ray;
        fill(&ray, p + 3 * i, d + 3 * i);
#if DAPPLE_EMBREE == 4
        rtcOccluded1(r->scene, &ray, a);
#else
        rtcOccluded1(r->scene, a, &ray);
#endif
        lit[i] = ray.tfar >= 0 ? 1.0f : 0.0f;
    }
}

void bn_rays_segments(const bn_rays *r, const float *from, const float *to, size_t count, float *lit)
{
    arguments a;
    init(&a, 0);
    for (size_t i = 0; i < count; i++) {
        struct RTCRay ray;
        float d[3];
        for (int k = 0; k < 3; k++)
            d[k] = to[3 * i + (size_t)k] - from[3 * i + (size_t)k];
        fill(&ray, from + 3 * i, d);
        ray.tfar = 1;
#if DAPPLE_EMBREE == 4
        rtcOccluded1(r->scene, &ray, &a);
#else
        rtcOccluded1(r->scene, &a, &ray);
#endif
        lit[i] = ray.tfar >= 0 ? 1.0f : 0.0f;
    }
}

#define TRACE_PACKET(WIDTH, CALL)                                                                                 \
    static void trace_##WIDTH(const bn_rays *r, arguments *a, const float *p, const float *d, size_t count,       \
                              float *lit)                                                                         \
    {                                                                                                             \
        struct RTCRay##WIDTH rays;                                                                                \
        RTC_ALIGN(64) int valid[WIDTH];                                                                           \
        memset(&rays, 0, sizeof rays);                                                                            \
        for (size_t first = 0; first < count; first += WIDTH) {                                                   \
            for (size_t k = 0; k < WIDTH; k++) {                                                                  \
                size_t i = first + k < count ? first + k : count - 1;                                             \
                valid[k] = first + k < count ? -1 : 0;                                                            \
                rays.org_x[k] = p[3 * i], rays.org_y[k] = p[3 * i + 1], rays.org_z[k] = p[3 * i + 2];             \
                rays.dir_x[k] = d[3 * i], rays.dir_y[k] = d[3 * i + 1], rays.dir_z[k] = d[3 * i + 2];             \
                rays.tfar[k] = HUGE_VALF;                                                                         \
                rays.mask[k] = UINT32_MAX;                                                                        \
            }                                                                                                     \
            CALL;                                                                                                 \
            for (size_t k = 0; k < WIDTH && first + k < count; k++)                                               \
                lit[first + k] = rays.tfar[k] >= 0 ? 1.0f : 0.0f;                                                 \
        }                                                                                                         \
    }

#if DAPPLE_EMBREE == 4
TRACE_PACKET(8, rtcOccluded8(valid, r->scene, &rays, a))
TRACE_PACKET(16, rtcOccluded16(valid, r->scene, &rays, a))
#else
TRACE_PACKET(8, rtcOccluded8(valid, r->scene, a, &rays))
TRACE_PACKET(16, rtcOccluded16(valid, r->scene, a, &rays))

enum { STREAM = 1024 };

static void trace_stream(const bn_rays *r, arguments *a, const float *p, const float *d, size_t count, float *lit)
{
    static const size_t size = sizeof(struct RTCRay);
    struct RTCRay rays[STREAM];
    for (size_t first = 0; first < count; first += STREAM) {
        size_t n = count - first < STREAM ? count - first : STREAM;
        for (size_t i = 0; i < n; i++)
            fill(&rays[i], p + 3 * (first + i), d + 3 * (first + i));
        rtcOccluded1M(r->scene, a, rays, (unsigned)n, size);
        for (size_t i = 0; i < n; i++)
            lit[first + i] = rays[i].tfar >= 0 ? 1.0f : 0.0f;
    }
}
#endif

int bn_rays_trace(const bn_rays *r, bn_ray_mode mode, int coherent, const float *points, const float *directions,
                  size_t count, float *lit)
{
    arguments a;
    init(&a, coherent);
    switch (mode) {
    case BN_RAY1: trace_1(r, &a, points, directions, count, lit); return 1;
    case BN_RAY8: trace_8(r, &a, points, directions, count, lit); return 1;
    case BN_RAY16: trace_16(r, &a, points, directions, count, lit); return 1;
#if DAPPLE_EMBREE == 3
    case BN_RAY_STREAM: trace_stream(r, &a, points, directions, count, lit); return 1;
#endif
#if defined(DAPPLE_TINYBVH)
    case BN_RAY_TINYBVH: bn_tinybvh_trace(r->peer, points, directions, count, lit); return 1;
#endif
    default: return 0;
    }
}

#else

const char *bn_rays_version(void) { return NULL; }
const char *bn_rays_peer_version(void) { return NULL; }
void bn_rays_free(bn_rays *rays) { (void)rays; }

bn_rays *bn_rays_create(const bn_model *model, int threads)
{
    (void)model, (void)threads;
    return NULL;
}

void bn_rays_segments(const bn_rays *rays, const float *from, const float *to, size_t count, float *lit)
{
    (void)rays, (void)from, (void)to, (void)count, (void)lit;
}

int bn_rays_trace(const bn_rays *rays, bn_ray_mode mode, int coherent, const float *points, const float *directions,
                  size_t count, float *lit)
{
    (void)rays, (void)mode, (void)coherent, (void)points, (void)directions, (void)count, (void)lit;
    return 0;
}

#endif
