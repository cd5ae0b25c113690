/* ---- harmonics: products of sixteen pairs of vectors ---- */

typedef struct sfield__entry { uint32_t pair; float c; } sfield__entry;

struct sfield_algebra {
    sfield__allocator allocator;
    sfield__logger log;             /* of the system that the tables were made with */
    uint32_t       bands, coefs;    /* n, n^2 */
    int            simd;            /* 0 none, 1 AVX2, 2 AVX-512 */
    uint32_t       pair_count;      /* of i >= j >= 1 with any tripling coefficient */
    uint32_t       row[SFIELD_MAX_COEFS + 1];     /* first pair with this i */
    uint32_t       first[SFIELD_MAX_COEFS + 1];   /* first entry of output k */
    uint8_t       *pair;            /* j of each pair; i is its row */
    uint8_t       *pair_i;
    sfield__entry *entry;
    uint32_t       node_count;      /* quadrature of degree 2 (n - 1) for rotations */
    double        *node;            /* x, y, z, weight */
    double        *basis;           /* n^2 at each node, times weight */
    void          *memory;
};

static const float sfield__y00 = 0.282094792f;      /* Y_00, and C_0jj for every j */
