/* ---- Haar wavelets ---- */

SFIELD_DEF sfield_result sfield_haar_forward(uint32_t side, const float *texels, float *coefs);
SFIELD_DEF sfield_result sfield_haar_inverse(uint32_t side, const float *coefs, float *texels);
/* Transform all six faces in 2D and back, orthonormal over the texels of the planar face. Both arrays have 6
   side^2 floats; they are not the same.
   On a face, [0] is the scaling coefficient, and [4^j + 3 node + t] wavelet t (x, y, both) of level j. */
SFIELD_DEF sfield_result sfield_haar_product(uint32_t side, const float *a, const float *b, float *out);
/* Computes the coefficients of the product of two functions from their coefficients. Only squares below which
   both have any are walked through (Ng, Ramamoorthi and Hanrahan 2004), so that non-zero coefficients cost
   time, not texels. out is another array. Errors SFIELD_ERR_ARGUMENT */
