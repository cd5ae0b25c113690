/* rays.c - see ask.h: Embree's occlusion rays, sixteen at once. */
#include "ask.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#if defined(DAPPLE_EMBREE) && DAPPLE_EMBREE > 0

#if DAPPLE_EMBREE == 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

struct bk_rays { RTCDevice device; RTCScene scene; };

int bk_rays_there(void) { return 1; }

bk_rays *bk_rays_create(const float *positions, size_t vertices, const uint32_t *indices, size_t triangles)
{
    bk_rays *r = calloc(1, sizeof *r);
    RTCGeometry geometry;
    void *to[2];
    if (!r || !(r->device = rtcNewDevice(NULL)) || !(r->scene = rtcNewScene(r->device))) {
        bk_rays_free(r);
        return NULL;
    }
    rtcSetSceneFlags(r->scene, RTC_SCENE_FLAG_ROBUST);
    geometry = rtcNewGeometry(r->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    to[0] = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, vertices);
    to[1] = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, triangles);
    if (to[0] && to[1]) {
        memcpy(to[0], positions, 12 * vertices);
        memcpy(to[1], indices, 12 * triangles);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(r->scene, geometry);
        rtcCommitScene(r->scene);
    }
    rtcReleaseGeometry(geometry);
    if (to[0] && to[1] && rtcGetDeviceError(r->device) == RTC_ERROR_NONE)
        return r;
    bk_rays_free(r);
    return NULL;
}

void bk_rays_free(bk_rays *r)
{
    if (r && r->scene)
        rtcReleaseScene(r->scene);
    if (r && r->device)
        rtcReleaseDevice(r->device);
    free(r);
}

/* The call of the two versions, which differ. */
static void occluded(const bk_rays *r, const int *valid, struct RTCRay16 *rays, int coherent)
{
#if DAPPLE_EMBREE == 4
    struct RTCOccludedArguments a;
    rtcInitOccludedArguments(&a);
    a.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    rtcOccluded16(valid, r->scene, rays, &a);
#else
    struct RTCIntersectContext a;
    rtcInitIntersectContext(&a);
    a.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    rtcOccluded16(valid, r->scene, &a, rays);
#endif
}

void bk_rays_trace(const bk_rays *r, const float *p, const float *d, int each, size_t count, float distance,
                   float *visible)
{
    struct RTCRay16 rays;
    RTC_ALIGN(64) int valid[16];
    memset(&rays, 0, sizeof rays);
    for (size_t first = 0; first < count; first += 16) {
        for (size_t k = 0; k < 16; k++) {
            const size_t i = first + k < count ? first + k : count - 1, j = each ? i : 0;
            valid[k] = first + k < count ? -1 : 0;
            rays.org_x[k] = p[3 * i], rays.org_y[k] = p[3 * i + 1], rays.org_z[k] = p[3 * i + 2];
            rays.dir_x[k] = d[3 * j], rays.dir_y[k] = d[3 * j + 1], rays.dir_z[k] = d[3 * j + 2];
            rays.tfar[k] = distance > 0 ? distance : HUGE_VALF;
            rays.mask[k] = UINT32_MAX;
        }
        occluded(r, valid, &rays, !each);
        for (size_t k = 0; k < 16 && first + k < count; k++)
            visible[first + k] = rays.tfar[k] >= 0 ? 1.0f : 0.0f;
    }
}

#else

int  bk_rays_there(void) { return 0; }
void bk_rays_free(bk_rays *rays) { (void)rays; }

bk_rays *bk_rays_create(const float *positions, size_t vertices, const uint32_t *indices, size_t triangles)
{
    (void)positions, (void)vertices, (void)indices, (void)triangles;
    return NULL;
}

void bk_rays_trace(const bk_rays *rays, const float *points, const float *directions, int each, size_t count,
                   float distance, float *visible)
{
    (void)rays, (void)points, (void)directions, (void)each, (void)count, (void)distance, (void)visible;
}

#endif
