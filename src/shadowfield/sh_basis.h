/* ---- harmonics: the basis, quadrature over the sphere, windows ---- */

static const double sfield__pi = 3.14159265358979323846;

/* Computes sine and cosine in double, with the same bits everywhere, for |x| <= 2 pi. Taylor series on |r| <=
   pi / 4 are exact to the last bits. */
static void sfield__sincos_d(double x, double *s, double *c)
{
    int k = (int)(x / (0.5 * sfield__pi) + (x < 0 ? -0.5 : 0.5)), i;
    double r = x - (double)k * (0.5 * sfield__pi), z = r * r, sine = 0, cosine = 0;
    for (i = 10; i >= 1; i--) {
        sine = (1 + sine) * -z / (double)(2 * i * (2 * i + 1));
        cosine = (1 + cosine) * -z / (double)(2 * i * (2 * i - 1));
    }
    sine = r * (1 + sine);
    cosine = 1 + cosine;
    *s = k & 1 ? cosine : sine;
    *c = k & 1 ? sine : cosine;
    if (k & 2) *s = -*s;
    if ((k + 1) & 2) *c = -*c;
}

/* The recurrences are those of normalised associated Legendre functions without their power of sin(theta).
   That power goes with the cosine and sine of m phi into the polynomials cm + i sm = (x + i y)^m. There is no
   sign of Condon and Shortley. */
SFIELD_DEF void sfield_sh_basis(uint32_t bands, const double direction[3], double *y)
{
    double z = direction[2], cm = 1, sm = 0;
    double older, diagonal = 0.28209479177387814347;
    uint32_t l, m;
    for (m = 0; m < bands; m++) {
        double now = diagonal, two = m ? 1.41421356237309504880 : 1;
        older = 0;
        for (l = m; l < bands; l++) {
            double a, next;
            y[l * l + l + m] = two * now * cm;
            if (m) y[l * l + l - m] = two * now * sm;
            a = sqrt((4.0 * (l + 1) * (l + 1) - 1) / ((double)(l + 1) * (l + 1) - (double)m * m));
            next = a * z * now;
            if (l > m)
                next -= older * a * sqrt(((double)l * l - (double)m * m) / (4.0 * l * l - 1));
            older = now;
            now = next;
        }
        diagonal *= sqrt((2.0 * m + 3) / (2.0 * m + 2));
        older = cm;
        cm = cm * direction[0] - sm * direction[1];
        sm = older * direction[1] + sm * direction[0];
    }
}

static size_t sfield__grid_size(uint32_t degree) { return (size_t)(degree / 2 + 1) * (degree + 1); }

/* Writes x, y, z and weight of the nodes of a grid: Gauss-Legendre in z times equal steps in phi. Sums over
   the grid are exact for polynomials up to the degree. */
static void sfield__fill_grid(uint32_t degree, double *node)
{
    uint32_t n = degree / 2 + 1, m = degree + 1, i;
    uint32_t j, step;
    for (i = 0; i < n; i++) {
        double z, unused, slope = 1, radius;
        sfield__sincos_d(sfield__pi * (i + 0.75) / (n + 0.5), &unused, &z);
        for (step = 0; step < 8; step++) {
            double p0 = 1, p1 = z, p;
            for (j = 2; j <= n; j++) {
                p = ((2.0 * j - 1) * z * p1 - (j - 1.0) * p0) / j;
                p0 = p1;
                p1 = p;
            }
            slope = n * (p0 - z * p1) / (1 - z * z);
            z -= p1 / slope;
        }
        radius = sqrt(1 - z * z);
        for (j = 0; j < m; j++) {
            double s, c;
            sfield__sincos_d(2 * sfield__pi * j / m, &s, &c);
            node[0] = radius * c;
            node[1] = radius * s;
            node[2] = z;
            node[3] = 2 / ((1 - z * z) * slope * slope) * 2 * sfield__pi / m;
            node += 4;
        }
    }
}

static void sfield__evaluate_basis(const double *node, size_t nodes, uint32_t bands, double *basis)
{
    size_t g;
    for (g = 0; g < nodes; g++) sfield_sh_basis(bands, node + 4 * g, basis + g * bands * bands);
}

SFIELD_DEF void sfield_sh_window(uint32_t bands, float strength, float factors[SFIELD_MAX_BANDS])
{
    uint32_t l;
    for (l = 0; l < bands && l < SFIELD_MAX_BANDS; l++)
        factors[l] = 1.0f / (1.0f + strength * (float)(l * l * (l + 1) * (l + 1)));
}

/* Returns whether a function, its bands multiplied by factors, is at least `lowest` in 36 x 72 directions. */
static int sfield__is_above(uint32_t bands, const float *factors, const float *coefs, float lowest)
{
    uint32_t i, k, l;
    for (i = 0; i < 36 * 72; i++) {
        double d[3], y[SFIELD_MAX_COEFS], value = 0;
        double s, c, ring;
        sfield__sincos_d(sfield__pi * (i / 72) / 35, &ring, &d[2]);
        sfield__sincos_d(sfield__pi * (i % 72) / 36, &s, &c);
        d[0] = ring * c;
        d[1] = ring * s;
        sfield_sh_basis(bands, d, y);
        for (l = 0, k = 0; l < bands; l++)
            for (; k < (l + 1) * (l + 1); k++) value += (double)(factors[l] * coefs[k]) * y[k];
        if (!(value >= (double)lowest)) return 0;
    }
    return 1;
}

SFIELD_DEF float sfield_sh_window_fit(uint32_t bands, const float *coefs, float lowest)
{
    float factors[SFIELD_MAX_BANDS], low = 0, high = 1, strength = 0;
    uint32_t step;
    if (!coefs || bands < 1 || bands > SFIELD_MAX_BANDS) return 0;
    for (step = 0; step < 20; step++) {         /* the first try is no window at all */
        sfield_sh_window(bands, strength, factors);
        if (!sfield__is_above(bands, factors, coefs, lowest)) low = strength;
        else if (strength == 0) return 0;
        else high = strength;
        strength = 0.5f * (low + high);
    }
    return high;
}

SFIELD_DEF void sfield_sh_cosine(uint32_t bands, float factors[SFIELD_MAX_BANDS])
{
    double binomial = 1;                        /* l! / (2^l (l/2)!^2) */
    uint32_t l;
    for (l = 0; l < bands && l < SFIELD_MAX_BANDS; l++) {
        if (l & 1) factors[l] = l == 1 ? (float)(2 * sfield__pi / 3) : 0.0f;
        else {
            if (l) binomial *= (l - 1.0) / l;
            factors[l] = (float)(2 * sfield__pi * (l % 4 == 0 ? -1 : 1) / ((l + 2.0) * (l - 1.0)) * binomial);
        }
    }
}
