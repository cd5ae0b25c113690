/* ---- Haar wavelets ---- */

/* The 6 side^2 coefficients of a cube come face by face. On a face, [0] is the scaling coefficient, and
   [4^j + 3 node + t] is wavelet t (0 in x, 1 in y, 2 in both) of square `node` of level j. */

SFIELD_DEF sfield_result sfield_haar_forward(uint32_t side, const float *texels, float *coefs);
SFIELD_DEF sfield_result sfield_haar_inverse(uint32_t side, const float *coefs, float *texels);
/* Transform all six faces in 2D, and back. The basis is orthonormal over the texels of the planar face, so
   that solid angles play no part.
   side           a power of two, 2..64
   texels, coefs  6 side^2 floats each, not the same array
   Errors         there is no log. SFIELD_ERR_ARGUMENT (a pointer is NULL, side is out of range, or both
                  arrays are one) */

SFIELD_DEF sfield_result sfield_haar_product(uint32_t side, const float *a, const float *b, float *out);
/* Multiplies two functions that are given by their coefficients (Ng, Ramamoorthi and Hanrahan, SIGGRAPH
   2004).
   a, b, out  6 side^2 coefficients each; out is another array
   Errors     there is no log. SFIELD_ERR_ARGUMENT (a pointer is NULL, side is out of range, or out is a or b)
   Cost       grows with the coefficients that are not 0, not with the texels: a square without any is not
              walked into */
