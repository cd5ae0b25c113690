/* ---- spread: what surfels are spread over, triangles and clusters of them ---- */

enum { ISM__TRIANGLES = 4096,       /* a task's */
       ISM__CLUSTERS = 32768,       /* at most */
       ISM__VIEWS = 8 };            /* receivers, from which a triangle is looked at */

/* Successive triangles as one, for what a VPL sees of them: centroid, mean squared distance from it, area,
   and the mean of n n^T, which gives |n . direction| exactly where there is one normal. Sixteen clusters in
   arrays, so that kernels work on several at a time. */
enum { ISM__BUNDLE = 16 };
typedef struct ism__clusters {
    float at[3][ISM__BUNDLE], radius2[ISM__BUNDLE], area[ISM__BUNDLE];
    float n[6][ISM__BUNDLE];        /* xx, yy, zz, yz, zx, xy */
} ism__clusters;

struct ism__spread_work;

/* Writes for each cluster which share of the VPL's map it fills, about. */
typedef void (*ism__cluster_kernel)(const struct ism__spread_work *w, const ism_vpl *v, float *effect);

/* Returns the mean solid angle of a triangle from `count` receivers, ISM__VIEWS at most, whose positions are
   in views. normal2 is the cross product of its edges. */
typedef float (*ism__triangle_kernel)(const ism__v3 p[3], ism__v3 normal2,
                                      const float views[3][ISM__VIEWS], uint32_t count);

typedef struct ism__spread_work {
    ism_maps        *m;
    const ism_mesh  *mesh;
    const ism__view *view;
    const uint32_t  *valid;         /* pixels that are no background */
    uint32_t         valid_count;
    float           *area, *solid;  /* of each triangle */
    size_t           triangles;
    uint32_t         frame, period;
    int              fresh;
    ism__cdf         cdf;
    ism__clusters   *clusters;
    double          *seen;          /* share of each cluster by what the view sees */
    uint32_t         cluster_count, cluster_size;   /* size: triangles of each but the last */
    ism__cluster_kernel  weigh_clusters;
    ism__triangle_kernel mean_solid_angle;
} ism__spread_work;
