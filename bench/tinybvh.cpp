/* tinybvh.cpp - occlusion rays of tinybvh (Bikker 2024 and later, github.com/jbikker/tinybvh), a header that programs
   copy as they copy ours: its tree of eight children a node, which wants AVX2, built with spatial splits, one ray at a
   time.
   Built where make has TINYBVH=FOLDER, the folder of its tiny_bvh.h; in C++20, with the intrinsics that it asks for. */
#ifdef DAPPLE_TINYBVH

#define TINYBVH_IMPLEMENTATION
#include "tiny_bvh.h"

#include <cstdio>
#include <memory>
#include <new>
#include <vector>

extern "C" {
#include "bench.h"
}

#if !defined(__AVX2__) || !defined(__FMA__)
#error "tinybvh's BVH8_CPU wants a processor with AVX2 and FMA: build without TINYBVH"
#endif

struct bn_tinybvh {
    tinybvh::BVH8_CPU tree;
    std::vector<tinybvh::bvhvec4> corners;      /* three for each triangle, which the tree reads as it is built */
};

const char *bn_tinybvh_version(void)
{
    static char text[32];
    snprintf(text, sizeof text, "%d.%d.%d", TINY_BVH_VERSION_MAJOR, TINY_BVH_VERSION_MINOR, TINY_BVH_VERSION_SUB);
    return text;
}

bn_tinybvh *bn_tinybvh_create(const bn_model *model)
{
    try {
        std::unique_ptr<bn_tinybvh> r(new bn_tinybvh);
        r->corners.reserve(3 * model->triangles);
        for (size_t i = 0; i < 3 * model->triangles; i++) {
            const float *p = model->positions + 3 * (size_t)model->indices[i];
            r->corners.push_back(tinybvh::bvhvec4(p[0], p[1], p[2], 0));
        }
        r->tree.BuildHQ(r->corners.data(), (uint32_t)model->triangles);
        return r.release();
    } catch (const std::bad_alloc &) {
        return NULL;
    }
}

void bn_tinybvh_free(bn_tinybvh *rays) { delete rays; }

void bn_tinybvh_trace(const bn_tinybvh *rays, const float *points, const float *directions, size_t count, float *lit)
{
    for (size_t i = 0; i < count; i++) {
        const float *p = points + 3 * i, *d = directions + 3 * i;
        const tinybvh::Ray ray(tinybvh::bvhvec3(p[0], p[1], p[2]), tinybvh::bvhvec3(d[0], d[1], d[2]));
        lit[i] = rays->tree.IsOccluded(ray) ? 0.0f : 1.0f;
    }
}

#endif
