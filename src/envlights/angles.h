/* ---- math: sine, cosine and arc tangent in double, the same bits everywhere ---- */

#define ENVLT__PI 3.14159265358979324

/* Writes sine and cosine of x, |x| <= 100. x is taken to an eighth of a turn about 0, with pi / 2 in two
   parts so that nothing cancels, and Taylor series of ten terms do the rest. */
static void envlt__sincos64(double x, double *sine, double *cosine)
{
    int k = (int)(x * (2.0 / ENVLT__PI) + (x < 0.0 ? -0.5 : 0.5)), j;
    double r = (x - (double)k * 1.5707963267948966) - (double)k * 6.123233995736766e-17, z = r * r, s = 1.0;
    double c = 1.0;
    for (j = 9; j > 0; j--) {
        s = 1.0 - s * z / (double)(2 * j * (2 * j + 1));
        c = 1.0 - c * z / (double)(2 * j * (2 * j - 1));
    }
    s *= r;
    *sine = k & 2 ? -(k & 1 ? c : s) : k & 1 ? c : s;
    *cosine = (k + 1) & 2 ? -(k & 1 ? s : c) : k & 1 ? s : c;
}

/* Returns the arc tangent. The angle is halved twice, by tan(a / 2) = tan a / (1 + sqrt(1 + tan^2 a)), so
   that the series converges quickly, and the result is four times the angle found. */
static double envlt__atan64(double x)
{
    double y = x / (1.0 + sqrt(1.0 + x * x)), z, sum = 0.0;
    int j;
    y = y / (1.0 + sqrt(1.0 + y * y));
    z = y * y;
    for (j = 21; j >= 0; j--) sum = 1.0 / (double)(2 * j + 1) - z * sum;
    return 4.0 * y * sum;
}
