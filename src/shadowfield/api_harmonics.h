/* ---- spherical harmonics ---- */

#define SFIELD_MAX_BANDS 8u
#define SFIELD_MAX_COEFS 64u

typedef struct sfield_algebra sfield_algebra;      /* tables of one number of bands; read-only once made */

SFIELD_DEF sfield_result sfield_algebra_create(uint32_t bands, const sfield_system *system,
                                               sfield_algebra **out);
/* Makes the tables for 1..8 bands. system may be NULL. Errors SFIELD_ERR_ARGUMENT, SFIELD_ERR_DESC
   (allocator), SFIELD_ERR_ALLOC. Cost 1 to 100 ms, 0.1 to 1 MB. */
SFIELD_DEF void sfield_algebra_free(sfield_algebra *algebra);      /* accepts NULL */

SFIELD_DEF void sfield_sh_basis(uint32_t bands, const double direction[3], double *y);
/* Writes bands^2 (bands 1..8) values of the real basis at a unit direction. */

SFIELD_DEF sfield_result sfield_sh_product(const sfield_algebra *algebra, size_t count, const float *a,
                                           const float *b, float *out, size_t stride);
/* Computes out = a b, projected on the same bands (the tripling coefficients, all of them): exact up to that
   truncation.
   a, b, out  planes of count vectors, stride >= count floats from coefficient to coefficient; out may be a or
              b
   Errors     SFIELD_ERR_ARGUMENT. Cost: about 30 ns (4 bands, AVX2) over 3, see docs */

SFIELD_DEF size_t sfield_sh_terms(const sfield_algebra *algebra, uint32_t *terms, float *factors);
/* Lists the terms of the product, for shaders: out_k += factor (a_i b_j + a_j b_i), once where i = j, for i
   >= j >= 1 and k >= 1; a term with an index 0 is 0.2821 (a_0 b_k + a_k b_0), and 0.2821 a.b for k = 0.
   terms    i | j << 8 | k << 16, rising in k; NULL, like factors, to be told only how many. Returns their
            number */

SFIELD_DEF sfield_result sfield_sh_dot(uint32_t bands, size_t count, const float *a, const float *b,
                                       float *out, size_t stride);
/* Writes out[i], the integral of a_i b_i over the sphere. Arguments as above; out holds count floats. */

typedef struct sfield_rotation {
    uint32_t bands;
    int      identity;
    float    block[680];        /* (2l+1) x (2l+1) for each band, by rows */
} sfield_rotation;

SFIELD_DEF sfield_result sfield_sh_rotation(const sfield_algebra *algebra, const float matrix[16],
                                            sfield_rotation *out);
/* Makes the matrices that turn a function f into f(R^-1 w).
   matrix  a rotation times one scale > 0; its translation is ignored
   Errors  SFIELD_ERR_ARGUMENT, SFIELD_ERR_INPUT (matrix). Cost 2 us (4 bands) to 50 us (8): once for each
           entity and frame, not for each vector */

SFIELD_DEF sfield_result sfield_sh_rotate(const sfield_rotation *rotation, size_t count, const float *in,
                                          float *out, size_t stride);
/* Turns count vectors, in planes; out may be in. Errors SFIELD_ERR_ARGUMENT. */

SFIELD_DEF sfield_result sfield_sh_product_n(uint32_t bands, uint32_t functions, const float *coefs,
                                             const sfield_system *system, double *out);
/* Computes the product of several functions without truncation between them, on a grid of full order:
   exactly.
   functions  1..32; coefs holds bands^2 floats of each, one after the other
   out        bands^2 coefficients of the product; its integral is sqrt(4 pi) out[0]
   Errors     SFIELD_ERR_ARGUMENT, SFIELD_ERR_DESC (allocator), SFIELD_ERR_ALLOC. system may be NULL */

SFIELD_DEF sfield_result sfield_sh_log(const sfield_algebra *algebra, const float *visibility, float *out);
SFIELD_DEF sfield_result sfield_sh_exp(const sfield_algebra *algebra, size_t count, const float *in,
                                       float *out, size_t stride);
/* Compute the logarithm of one vector, by the eigenvalues of its product matrix, which are clipped below at
   0.02, and the exponential of vectors in planes, by scaling and squaring. A product of visibilities is the
   exponential of the sum of their logarithms, whatever their order (Ren et al. 2006). Errors
   SFIELD_ERR_ARGUMENT, SFIELD_ERR_ALLOC (logarithm). */

SFIELD_DEF void sfield_sh_window(uint32_t bands, float strength, float factors[SFIELD_MAX_BANDS]);
/* Writes factors against ringing, 1 / (1 + strength l^2 (l+1)^2) for band l. */
SFIELD_DEF float sfield_sh_window_fit(uint32_t bands, const float *coefs, float lowest);
/* Returns the least strength (0..1) with which the function stays >= lowest everywhere (checked at 2,592
   directions); 1 also where none does, as with a mean below lowest. */

SFIELD_DEF void sfield_sh_cosine(uint32_t bands, float factors[SFIELD_MAX_BANDS]);
/* Writes A_l of max(0, cos): radiance coefficients convolved with them are irradiance. */

/* ---- cubes ---- */

SFIELD_DEF float sfield_cube_texel(uint32_t side, uint32_t texel, float direction[3]);
/* Writes the unit direction of a texel's centre and returns its solid angle. side: a power of two, 2..64. */
SFIELD_DEF uint32_t sfield_cube_find(uint32_t side, const float direction[3]);
/* Returns the texel that a direction of any length falls into. */
SFIELD_DEF sfield_result sfield_cube_basis(uint32_t bands, uint32_t side, uint32_t texel, float *out);
/* Writes the exact integrals of the bands^2 basis functions over a texel: sums of texels times these are a
   function's coefficients. It serves projection elsewhere, as on a GPU. Errors SFIELD_ERR_ARGUMENT. */

SFIELD_DEF sfield_result sfield_sh_project(uint32_t bands, uint32_t side, const float *texels,
                                           uint32_t channels, float *coefs);
/* Integrates a cube of texels (channels values each, 1..3) against the basis, exactly over each texel; coefs:
   bands^2 for each channel, one channel after the other. Errors SFIELD_ERR_ARGUMENT. */
