/* ---- BRDFs as harmonics ---- */

SFIELD_DEF size_t sfield_sh_brdf(uint32_t bands, const sfield_system *system, float *table);
/* Writes the kernels of glTF's metal-rough BRDF as harmonics, for shaders: of points that have `materials`
   sfield_shade interpolates the same table. docs/shadowfield.md says what the kernels are.
   bands    1..8
   system   its parallel_for alone is used; NULL = this thread
   table    for each of 24 roughnesses, 0 to 1, and 48 views, whose sqrt(1 - cosine) goes from 0 to 1: three
            kernels times the cosine, then three without it; of each the bands (bands + 1) / 2 coefficients of
            order m >= 0, band by band. NULL = nothing is written
   Returns  how many floats the table has, 6,912 times bands (bands + 1) / 2; 0 for other bands
   Cost     0.2 s (4 bands) to 0.5 s (8) of one core */
