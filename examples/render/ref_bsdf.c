/* ref_bsdf.c - see ref_bsdf.h */
#include "ref_bsdf.h"

static rf_v3 schlick(rf_v3 f0, double cosine)
{
    double m = 1 - cosine, w = m * m * m * m * m;
    return rf_make(f0.x + (1 - f0.x) * w, f0.y + (1 - f0.y) * w, f0.z + (1 - f0.z) * w);
}

void rf_bsdf_init(rf_bsdf *b, rf_v3 normal, rf_v3 view, rf_v3 base, double metallic, double roughness, int full)
{
    double specular, diffuse;
    b->normal = normal;
    rf_frame(normal, &b->x, &b->y);
    b->view = rf_make(rf_dot(view, b->x), rf_dot(view, b->y), rf_dot(view, normal));
    if (b->view.z < 1e-3) {
        b->view.z = 1e-3;
        b->view = rf_unit(b->view);
    }
    b->diffuse = base;
    b->f0 = rf_make(0, 0, 0);
    b->alpha = b->specular_share = 0;
    if (!full)
        return;
    b->alpha = rf_most(roughness * roughness, 0.002);
    b->diffuse = rf_scale(base, 1 - metallic);
    b->f0 = rf_add(rf_scale(base, metallic), rf_scale(rf_make(0.04, 0.04, 0.04), 1 - metallic));
    specular = rf_mean(schlick(b->f0, b->view.z));
    diffuse = rf_mean(b->diffuse);
    b->specular_share = diffuse > 0 ? rf_least(rf_most(specular / (specular + diffuse), 0.1), 0.9) : 1;
}

/* Smith's shadowing term, as Lambda of Heitz, "Understanding the masking-shadowing function" (2014), equation 72. */
static double lambda(rf_v3 w, double alpha)
{
    return 0.5 * (sqrt(1 + alpha * alpha * (w.x * w.x + w.y * w.y) / (w.z * w.z)) - 1);
}

static double ggx(rf_v3 h, double alpha)
{
    double a2 = alpha * alpha, d = h.z * h.z * a2 + (h.x * h.x + h.y * h.y);
    return a2 / (RF_PI * d * d);
}

static rf_v3 eval_local(const rf_bsdf *b, rf_v3 l, double *pdf)
{
    rf_v3 value = rf_make(0, 0, 0), h, f;
    double vh, density, lambda_view;
    *pdf = 0;
    if (!(l.z > 0))
        return value;
    if (!(b->alpha > 0)) {
        *pdf = l.z / RF_PI;
        return rf_scale(b->diffuse, l.z / RF_PI);
    }
    h = rf_unit(rf_add(b->view, l));
    vh = rf_least(rf_dot(b->view, h), 1);
    f = schlick(b->f0, vh);
    density = ggx(h, b->alpha) / (4 * b->view.z);       /* D / (4 n.v): the cosine of f cos cancels n.l */
    lambda_view = lambda(b->view, b->alpha);
    value = rf_scale(f, density / (1 + lambda_view + lambda(l, b->alpha)));
    value = rf_add(value, rf_scale(rf_mul(b->diffuse, rf_sub(rf_make(1, 1, 1), f)), l.z / RF_PI));
    *pdf = b->specular_share * density / (1 + lambda_view) + (1 - b->specular_share) * l.z / RF_PI;
    return value;
}

rf_v3 rf_bsdf_eval(const rf_bsdf *b, rf_v3 direction, double *pdf)
{
    rf_v3 l = rf_make(rf_dot(direction, b->x), rf_dot(direction, b->y), rf_dot(direction, b->normal));
    return eval_local(b, l, pdf);
}

/* Half vector among the normals that the view sees, after Dupuy and Benyoub, "Sampling visible GGX normals with
   spherical caps" (2023): in the space where the surface is a hemisphere, reflect the view about it into a cap. */
static rf_v3 sample_half(const rf_bsdf *b, const double u[2])
{
    rf_v3 view = rf_unit(rf_make(b->alpha * b->view.x, b->alpha * b->view.y, b->view.z)), h;
    double phi = 2 * RF_PI * u[0], z = (1 - u[1]) * (1 + view.z) - view.z, r = sqrt(rf_most(0, 1 - z * z));
    h = rf_add(rf_make(r * cos(phi), r * sin(phi), z), view);
    return rf_unit(rf_make(b->alpha * h.x, b->alpha * h.y, rf_most(h.z, 0)));
}

int rf_bsdf_sample(const rf_bsdf *b, const double u[2], rf_v3 *direction, rf_v3 *value, double *pdf)
{
    double v[2] = { u[0], u[1] };
    rf_v3 l;
    if (v[0] < b->specular_share) {
        rf_v3 h;
        v[0] /= b->specular_share;
        h = sample_half(b, v);
        l = rf_sub(rf_scale(h, 2 * rf_dot(b->view, h)), b->view);
    } else {
        double r, phi;
        v[0] = (v[0] - b->specular_share) / (1 - b->specular_share);
        r = sqrt(v[1]);
        phi = 2 * RF_PI * v[0];
        l = rf_make(r * cos(phi), r * sin(phi), sqrt(rf_most(0, 1 - v[1])));
    }
    *value = eval_local(b, l, pdf);
    if (!(*pdf > 0))
        return 0;
    *value = rf_scale(*value, 1 / *pdf);
    *direction = rf_unit(rf_from_frame(b->x, b->y, b->normal, l));
    return 1;
}
