/* ---- spherical harmonics of your own: what no scene needs ---- */

SFIELD_DEF sfield_result sfield_sh_product(const sfield_algebra *algebra, size_t count, const float *a,
                                           const float *b, float *out, size_t stride);
/* Multiplies two functions, count pairs at a time: out is a b, projected on the bands that a and b have. All
   tripling coefficients are used (section 4.1 of the paper), so that only the bands above are lost.
   a, b, out  vectors in planes; out may be a or b
   Errors     SFIELD_ERR_ARGUMENT (a pointer is NULL, which leaves no log if it is algebra; stride is below
              count)
   Cost       about 10 ns a product with 4 bands and AVX2, 5 ns with 3: docs/measured/performance.md */

SFIELD_DEF size_t sfield_sh_terms(const sfield_algebra *algebra, uint32_t *terms, float *factors);
/* Lists the terms of sfield_sh_product, for shaders that multiply functions themselves, and returns how many
   there are. A term says out_k += factor (a_i b_j + a_j b_i), of which only one half is added if i = j. The
   list has i >= j >= 1 and k >= 1 alone; what has an index 0 is simple: out_k += 0.2821 (a_0 b_k + a_k b_0)
   for k >= 1, and out_0 is 0.2821 times the dot product of a and b.
   terms     i | j << 8 | k << 16, rising in k
   factors   one for each term; if terms or factors is NULL, nothing is written */

SFIELD_DEF sfield_result sfield_sh_dot(uint32_t bands, size_t count, const float *a, const float *b,
                                       float *out, size_t stride);
/* Writes out[i], the integral of a_i b_i over the sphere, which is the dot product of their coefficients.
   a, b     vectors of bands^2 coefficients (bands 1..8), in planes
   out      count floats
   Errors   there is no log. SFIELD_ERR_ARGUMENT (a pointer is NULL, bands is out of range, or stride is below
            count) */

SFIELD_DEF sfield_result sfield_sh_rotate(const sfield_rotation *rotation, size_t count, const float *in,
                                          float *out, size_t stride);
/* Turns count vectors, in planes. out may be in.
   Errors   there is no log. SFIELD_ERR_ARGUMENT (a pointer is NULL, stride is below count, or the rotation
            was not made by sfield_sh_rotation) */

SFIELD_DEF sfield_result sfield_sh_product_n(uint32_t bands, uint32_t functions, const float *coefs,
                                             const sfield_system *system, double *out);
/* Multiplies several functions exactly, as a reference: on a grid that is fine enough for the full product,
   of which the lowest bands are then projected. sfield_sh_product projects after each of its products
   instead.
   bands      1..8
   functions  1..32
   coefs      bands^2 floats of each function, one function after the other
   system     may be NULL
   out        bands^2 coefficients of the product, whose integral is sqrt(4 pi) out[0]
   Errors     SFIELD_ERR_ARGUMENT (coefs or out is NULL; bands or functions is out of range), SFIELD_ERR_DESC
              (allocator), SFIELD_ERR_ALLOC */

SFIELD_DEF sfield_result sfield_sh_log(const sfield_algebra *algebra, const float *visibility, float *out);
/* Computes the logarithm of one vector by the eigenvalues of its product matrix, which are clipped below at
   0.02. A product of visibilities is the exponential of the sum of their logarithms, in any order (Ren et
   al., SIGGRAPH 2006).
   Errors   SFIELD_ERR_ARGUMENT (a pointer is NULL, which leaves no log if it is algebra), SFIELD_ERR_ALLOC */

SFIELD_DEF sfield_result sfield_sh_exp(const sfield_algebra *algebra, size_t count, const float *in,
                                       float *out, size_t stride);
/* Computes the exponentials of vectors in planes, by scaling and squaring.
   Errors   as sfield_sh_product */

SFIELD_DEF float sfield_sh_window_fit(uint32_t bands, const float *coefs, float lowest);
/* Returns the least strength, 0..1, with which a function stays >= lowest in each of 2,592 directions.
   Returns 1 also if no strength is enough, as for a function whose mean is below lowest, and 0 for bad
   arguments. */

SFIELD_DEF sfield_result sfield_cube_basis(uint32_t bands, uint32_t side, uint32_t texel, float *out);
/* Writes the exact integrals of the bands^2 basis functions over one texel. The sum over all texels of value
   x these integrals are a function's coefficients: a table for projection elsewhere, as on a GPU.
   Errors  there is no log. SFIELD_ERR_ARGUMENT (out is NULL, or a number is out of range) */
