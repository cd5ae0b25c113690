/* unit mask: holes of alpha masks, asked for at the samples of rasters */

/* Writes the weights of a triangle's corners where the ray through x, y meets the triangle. c holds x, y and
   w of each corner as the view has them; w is the depth in units of the view's half width, and 1 where rays
   are parallel. A sample that rounding puts beyond an edge is moved onto the edge. */
static inline void P_mask_weights(const double *c, double x, double y, float weights[3])
{
    double e[3], sum, sign;
    int k;
    for (k = 0; k < 3; k++) {
        const double *a = c + 3 * ((k + 1) % 3), *b = c + 3 * ((k + 2) % 3);
        e[k] = x * (a[1] * b[2] - a[2] * b[1]) + y * (a[2] * b[0] - a[0] * b[2]);
        e[k] += a[0] * b[1] - a[1] * b[0];
    }
    sign = e[0] + e[1] + e[2] < 0.0 ? -1.0 : 1.0;
    for (k = 0, sum = 0.0; k < 3; k++) {
        e[k] = sign * e[k] > 0.0 ? sign * e[k] : 0.0;
        sum += e[k];
    }
    for (k = 0; k < 3; k++) weights[k] = sum > 0.0 ? (float)(e[k] / sum) : 1.0f / 3.0f;
}
