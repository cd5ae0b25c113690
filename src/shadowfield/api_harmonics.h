/* ---- spherical harmonics ---- */

/* Coefficient number l^2 + l + m belongs to band l, 0 <= l < bands. Functions that take `stride` work on
   count vectors at a time, in planes: coefficient k of vector i is v[k * stride + i], and stride >= count. A
   single plain vector has count 1 and stride 1. */

#define SFIELD_MAX_BANDS 8u
#define SFIELD_MAX_COEFS 64u

typedef struct sfield_algebra sfield_algebra;      /* tables of one number of bands; read-only once made */

SFIELD_DEF sfield_result sfield_algebra_create(uint32_t bands, const sfield_system *system,
                                               sfield_algebra **out);
/* Makes the tables for 1..8 bands. system may be NULL.
   Errors  SFIELD_ERR_ARGUMENT (out is NULL, or bands is out of range), SFIELD_ERR_DESC (allocator),
           SFIELD_ERR_ALLOC
   Cost    1 to 100 ms, 0.1 to 1 MB */
SFIELD_DEF void sfield_algebra_free(sfield_algebra *algebra);
/* Takes back tables and their memory. Accepts NULL. */

SFIELD_DEF void sfield_sh_basis(uint32_t bands, const double direction[3], double *y);
/* Writes the values of the bands^2 real basis functions at a unit direction. Nothing is checked.
   bands   1..8 */

typedef struct sfield_rotation {    /* a rotation of functions, from sfield_sh_rotation */
    uint32_t bands;
    int      identity;              /* not 0: the rotation is none */
    float    block[680];            /* (2l+1) x (2l+1) floats for each band l, by rows */
} sfield_rotation;

SFIELD_DEF sfield_result sfield_sh_rotation(const sfield_algebra *algebra, const float matrix[16],
                                            sfield_rotation *out);
/* Makes the matrices that turn a function f(w) into f(R^-1 w): what f has in direction w goes to R w.
   matrix  R, a rotation, which may be multiplied by one scale > 0; its translation is ignored
   Errors  SFIELD_ERR_ARGUMENT (NULL), SFIELD_ERR_INPUT (matrix)
   Cost    2 us (4 bands) to 50 us (8): once for each entity and frame, not for each vector */

SFIELD_DEF void sfield_sh_window(uint32_t bands, float strength, float factors[SFIELD_MAX_BANDS]);
/* Writes factors for each band l against ringing, 1 / (1 + strength l^2 (l+1)^2).
   bands   1..8; of more, eight factors are written */

SFIELD_DEF void sfield_sh_cosine(uint32_t bands, float factors[SFIELD_MAX_BANDS]);
/* Writes factors for each band, those of max(0, cos): coefficients of radiance times these are coefficients
   of irradiance. bands as in sfield_sh_window. */

/* ---- cubes ---- */

SFIELD_DEF float sfield_cube_texel(uint32_t side, uint32_t texel, float direction[3]);
/* Writes the unit direction of a texel's centre and returns the texel's solid angle in sr. Returns 0 and
   writes nothing if an argument is out of range.
   side    a power of two, 2..64
   texel   below 6 side^2: number face side^2 + morton(x, y) */

SFIELD_DEF uint32_t sfield_cube_find(uint32_t side, const float direction[3]);
/* Returns the texel that a direction of any length falls into; 0 if an argument is out of range. */

SFIELD_DEF sfield_result sfield_sh_project(uint32_t bands, uint32_t side, const float *texels,
                                           uint32_t channels, float *coefs);
/* Projects a cube of texels on the basis, exactly over each texel.
   side      a power of two, 2..64
   texels    6 side^2 texels of `channels` (1..3) floats each
   coefs     bands^2 for each channel, one channel after the other
   Errors    there is no log. SFIELD_ERR_ARGUMENT (a pointer is NULL, or a number is out of range) */
