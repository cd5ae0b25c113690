/* ---- kernels: which to call ---- */

typedef struct cohsm__kernels {
    void (*address)(cohsm__tile *t);
#ifndef COHSM_WITHOUT_SIMD
    void (*cells)(cohsm__tile *t);
    void (*project)(cohsm__tile *t, uint32_t map);
    void (*corner)(cohsm__tile *t, uint32_t corner);
#endif
    void (*search)(cohsm__tile *t);
    size_t (*load_vectors)(const cohsm__tile *t, const float *packed, cohsm__v3 center, float scale,
                           float (*out)[COHSM__TILE]);
    void (*one_light)(cohsm__stream *s, float *visible);
    void (*meet_spheres)(const cohsm_query *q, size_t first, size_t count, cohsm__bunch *b);
#ifndef COHSM_WITHOUT_BUILD
    void (*find)(const cohsm__target *t, cohsm__v3 up, const cohsm__soup *soup, uint32_t begin, uint32_t end,
                 cohsm__sight *sight);
    void (*find_slab)(const cohsm__target *t, const cohsm__camera *cam, const cohsm__soup *soup,
                      const cohsm__sight *sight, uint32_t first, cohsm__slab *slab);
    void (*enqueue_slab)(const cohsm__target *t, const cohsm__camera *cam, const cohsm__slab *slab,
                          cohsm__queue *q);
    void (*draw_queue)(const cohsm__target *t, const cohsm__camera *cam, cohsm__queue *q, int all);
    uint32_t (*narrow)(cohsm__narrowing *n, const uint16_t *z, int32_t *span, uint32_t pixels, int32_t *left);
#endif
} cohsm__kernels;

static cohsm__kernels cohsm__choose_kernels(int simd)
{
    cohsm__kernels k;
    k.address = cohsm__address_latlong_plain;
#ifndef COHSM_WITHOUT_SIMD
    k.cells = cohsm__cells_latlong_plain;
    k.project = cohsm__project_latlong_plain;
    k.corner = cohsm__corner_latlong_plain;
#endif
    k.search = cohsm__search_tile_plain;
    k.load_vectors = cohsm__load_vectors_plain;
    k.one_light = cohsm__one_light_plain;
    k.meet_spheres = cohsm__meet_spheres_plain;
#ifndef COHSM_WITHOUT_BUILD
    k.find = cohsm__find_clusters_plain;
    k.find_slab = cohsm__find_slab_plain;
    k.enqueue_slab = cohsm__enqueue_slab_plain;
    k.draw_queue = cohsm__draw_queue_plain;
    k.narrow = cohsm__narrow_plain;
#endif
#if COHSM__SIMD_SETS
    if (simd) {
        k.address = cohsm__address_latlong_avx2;
        k.cells = cohsm__cells_latlong_avx2;
        k.project = cohsm__project_latlong_avx2;
        k.corner = cohsm__corner_latlong_avx2;
        k.search = cohsm__search_tile_avx2;
        k.load_vectors = cohsm__load_vectors_avx2;
        k.meet_spheres = simd == 2 ? cohsm__meet_spheres_avx512 : cohsm__meet_spheres_avx2;
        k.one_light = simd == 2 ? cohsm__one_light_avx512 : cohsm__one_light_avx2;
#ifndef COHSM_WITHOUT_BUILD
        k.find = cohsm__find_clusters_avx2;
        k.find_slab = simd == 2 ? cohsm__find_slab_avx512 : cohsm__find_slab_avx2;
        k.enqueue_slab = simd == 2 ? cohsm__enqueue_slab_avx512 : cohsm__enqueue_slab_avx2;
        k.draw_queue = simd == 2 ? cohsm__draw_queue_avx512 : cohsm__draw_queue_avx2;
        k.narrow = simd == 2 ? cohsm__narrow_avx512 : cohsm__narrow_avx2;
#endif
    }
#else
    (void)simd;
#endif
    return k;
}
