/* ---- spread: surfels are spread over triangles, and over clusters of them ---- */

enum { ISM__TRIANGLES = 4096,       /* triangles of one task */
       ISM__CLUSTERS = 32768,       /* the most clusters that there are */
       ISM__VIEWS = 8 };            /* the most receivers from which a triangle is looked at */

/* Clusters are successive triangles that are taken together, to estimate what a VPL sees of them: their
   centroid, the mean squared distance from it, their area, and the mean of n n^T over their normals, which
   gives |n . direction| exactly if all normals are equal. Sixteen clusters lie together in arrays, so that
   kernels work on several at a time. */
enum { ISM__BUNDLE = 16 };
typedef struct ism__clusters {
    float at[3][ISM__BUNDLE], radius2[ISM__BUNDLE], area[ISM__BUNDLE];
    float n[6][ISM__BUNDLE];        /* xx, yy, zz, yz, zx, xy */
} ism__clusters;

struct ism__spread_work;

/* Writes for each cluster about which share of the VPL's map it fills. */
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
    int              fresh, fewer;  /* there are no points yet; there were more triangles */
    ism__cdf         cdf;
    ism__clusters   *clusters;
    double          *seen;          /* each cluster's share of all points by what the view sees */
    uint32_t         cluster_count;
    uint32_t         cluster_size;  /* triangles of each cluster but the last */
    ism__cluster_kernel  weigh_clusters;
    ism__triangle_kernel mean_solid_angle;
} ism__spread_work;
