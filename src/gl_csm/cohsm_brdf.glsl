// cohsm_brdf - evaluates and samples the BRDFs of Lambert, Phong and Lafortune and glTF's metal-rough one,
// with GGX. C twins: lsamp_brdf_eval and lsamp_brdf_sample of lightsampling.h.
//
// COHSM_LOBES is how many lobes a surface may have, 1..8: more than 1 are for Lafortune materials, and take
// registers. COHSM_LOBE(i) is texel i of the lobes' table, a uvec4 of the bits of floats. Each lobe has two
// texels: the first holds axis and exponent, the second the scale.
// uses: cohsm_math
#ifndef COHSM_LOBES
#error "cohsm_brdf: COHSM_LOBES, 1..8"
#endif
#ifndef COHSM_LOBE
#error "cohsm_brdf: COHSM_LOBE(i), texel i of the lobes"
#endif

#define COHSM_BRDF_LAMBERT 1u
#define COHSM_BRDF_PHONG 2u
#define COHSM_BRDF_LAFORTUNE 3u
#define COHSM_BRDF_METAL_ROUGH 4u

struct cohsm_material {
    uint type;                  // COHSM_BRDF_...
    vec3 diffuse,               // albedo; METAL_ROUGH: base colour
         specular;              // PHONG
    float exponent,             // PHONG
          metallic,             // METAL_ROUGH
          roughness;            // METAL_ROUGH
    uint lobe,                  // LAFORTUNE: number of the first lobe in the table
         lobe_count;            // LAFORTUNE
};

struct cohsm_surface {          // a material at a point; its axes are t, b and n
    vec3  t;
    vec3  b;
    vec3  n;
    vec3  to_eye;                   // unit, to the eye, along these axes
    vec3  diffuse;
    vec3  f0;                   // GGX: what is reflected along the normal
    float alpha;                // GGX; 0: cosine lobes
    int   lobe_count;
    vec4  lobes[COHSM_LOBES];   // axis, exponent
    vec4  scales[COHSM_LOBES];  // scale, share among the lobes
    float diffuse_share,        // of the samples
          peak;                 // about the greatest density of a sample
    bool  black;                // it reflects nothing
};

struct cohsm_response {         // of a surface to a direction
    vec3  diffuse;              // f
    vec3  specular;
    float diffuse_pdf,          // per solid angle
          specular_pdf;
};

float cohsm_mean(vec3 c) { return (c.x + c.y + c.z) * (1.0 / 3.0); }

// These turn a direction of the world to the axes of a surface, and back.
vec3 cohsm_to_axes(cohsm_surface s, vec3 w) { return vec3(dot(w, s.t), dot(w, s.b), dot(w, s.n)); }
vec3 cohsm_from_axes(cohsm_surface s, vec3 w) { return s.t * w.x + s.b * w.y + s.n * w.z; }

// Returns Fresnel's reflectance by Schlick's approximation.
vec3 cohsm_schlick(vec3 f0, float cosine)
{
    float x = 1.0 - cosine, f = x * x * (x * x) * x;
    return f0 * (1.0 - f) + f;
}

// Adds a cosine lobe about c times the mirrored view, unless there is no room; returns its albedo, about.
float cohsm_add_lobe(inout cohsm_surface s, vec3 c, float exponent, vec3 scale)
{
    vec3 a = c * s.to_eye;
    float size = sqrt(dot(a, a));
    if (!(size > 0.0) || s.lobe_count >= COHSM_LOBES) return 0.0;
    a /= size;
    if (exponent > 0.0) scale *= cohsm_pow(size, exponent);
    float albedo = cohsm_mean(scale) * 2.0 * COHSM_PI / (exponent + 2.0) * max(a.z, 0.1);
    if (!(albedo > 0.0) || !cohsm_finite3(scale)) return 0.0;
    for (int i = 0; i < COHSM_LOBES; i++)
        if (i == s.lobe_count) {
            s.lobes[i] = vec4(a, exponent);
            s.scales[i] = vec4(scale, albedo);
        }
    s.lobe_count++;
    return albedo;
}

// Sets what a surface reflects beside the diffuse part, and returns its albedo, about.
float cohsm_specular_init(inout cohsm_surface s, const in cohsm_material m)
{
    if (m.type == COHSM_BRDF_METAL_ROUGH) {
        s.alpha = max(m.roughness * m.roughness, 0.002);
        s.f0 = vec3(0.04) * (1.0 - m.metallic) + m.diffuse * m.metallic;
        s.diffuse = m.diffuse * (1.0 - m.metallic);
        s.lobe_count = 1;
        float share = cohsm_mean(cohsm_schlick(s.f0, s.to_eye.z));
        s.scales[0] = vec4(0.0, 0.0, 0.0, share);
        return share;
    }
    if (m.type == COHSM_BRDF_PHONG)
        return cohsm_add_lobe(s, vec3(-1.0, -1.0, 1.0), m.exponent,
                              m.specular * ((m.exponent + 2.0) / (2.0 * COHSM_PI)));
    float sum = 0.0;
    if (m.type == COHSM_BRDF_LAFORTUNE)
        for (uint i = 0u; i < m.lobe_count; i++) {
            vec4 axis = uintBitsToFloat(COHSM_LOBE(2u * (m.lobe + i)));
            vec3 scale = uintBitsToFloat(COHSM_LOBE(2u * (m.lobe + i) + 1u)).xyz;
            sum += cohsm_add_lobe(s, axis.xyz, axis.w, scale);
        }
    return sum;
}

// Returns a material at a point. normal and to_eye have about unit length, tangent any; 0 is none.
cohsm_surface cohsm_surface_at(const in cohsm_material m, vec3 normal, vec3 tangent, vec3 to_eye)
{
    cohsm_surface s;
    s.n = cohsm_normalize(normal);
    vec3 t = tangent - s.n * dot(tangent, s.n);
    if (dot(t, t) > 1e-6) {
        s.t = cohsm_normalize(t);
        s.b = cross(s.n, s.t);
    } else
        cohsm_basis(s.n, s.t, s.b);
    s.to_eye = cohsm_to_axes(s, cohsm_normalize(to_eye));
    if (s.to_eye.z < 1e-3) s.to_eye = cohsm_normalize(vec3(s.to_eye.xy, 1e-3));
    s.to_eye.z = min(s.to_eye.z, 1.0);
    s.diffuse = m.diffuse;
    s.f0 = vec3(0.0);
    s.alpha = 0.0;
    s.lobe_count = 0;
    for (int i = 0; i < COHSM_LOBES; i++) {
        s.lobes[i] = vec4(0.0);
        s.scales[i] = vec4(0.0);
    }
    float specular = cohsm_specular_init(s, m), diffuse = cohsm_mean(s.diffuse);
    s.black = !(diffuse + specular > 0.0);
    s.diffuse_share = cohsm_if(s.black, 1.0, diffuse / (diffuse + specular));
    s.peak = s.diffuse_share * (1.0 / COHSM_PI);
    for (int i = 0; i < COHSM_LOBES; i++)
        if (i < s.lobe_count) {
            s.scales[i].w /= specular;
            float lobe = (s.lobes[i].w + 1.0) / (2.0 * COHSM_PI);
            if (s.alpha > 0.0) lobe = 0.25 / (COHSM_PI * s.alpha * s.alpha);
            s.peak += (1.0 - s.diffuse_share) * s.scales[i].w * lobe;
        }
    return s;
}

// Adds GGX to a response: with Smith's height-correlated shadowing, and the density of visible normals.
void cohsm_ggx(cohsm_surface s, vec3 wi, inout cohsm_response r)
{
    vec3 h = cohsm_normalize(s.to_eye + wi);
    float a2 = s.alpha * s.alpha, q = h.x * h.x + h.y * h.y + a2 * h.z * h.z, d = a2 / (COHSM_PI * q * q);
    float go = sqrt(a2 + (1.0 - a2) * s.to_eye.z * s.to_eye.z), gi = sqrt(a2 + (1.0 - a2) * wi.z * wi.z);
    vec3 f = cohsm_schlick(s.f0, clamp(dot(s.to_eye, h), 0.0, 1.0));
    r.specular = f * (0.5 * d / (wi.z * go + s.to_eye.z * gi));
    r.diffuse *= 1.0 - f;
    r.specular_pdf = 0.5 * d / (s.to_eye.z + go);
}

// Returns f and the densities of the diffuse and the specular part for wi, a direction along the axes.
cohsm_response cohsm_respond(cohsm_surface s, vec3 wi)
{
    cohsm_response r = cohsm_response(vec3(0.0), vec3(0.0), 0.0, 0.0);
    if (!(wi.z > 0.0)) return r;
    r.diffuse = s.diffuse * (1.0 / COHSM_PI);
    r.diffuse_pdf = wi.z * (1.0 / COHSM_PI);
    if (s.lobe_count > 0 && s.alpha > 0.0) {
        cohsm_ggx(s, wi, r);
        return r;
    }
    for (int i = 0; i < COHSM_LOBES; i++) {
        float c = dot(s.lobes[i].xyz, wi);
        if (i < s.lobe_count && c > 0.0) {
            c = cohsm_pow(c, s.lobes[i].w);
            r.specular += s.scales[i].xyz * c;
            r.specular_pdf += s.scales[i].w * c * (s.lobes[i].w + 1.0) / (2.0 * COHSM_PI);
        }
    }
    return r;
}

// Returns the density of samples by cohsm_brdf_draw with the surface's diffuse_share.
float cohsm_brdf_pdf(cohsm_surface s, const in cohsm_response r)
{
    return s.diffuse_share * r.diffuse_pdf + (1.0 - s.diffuse_share) * r.specular_pdf;
}

// Returns a direction mirrored at a visible normal, which is drawn by spherical caps (Dupuy and Benyoub
// 2023).
vec3 cohsm_ggx_draw(cohsm_surface s, vec2 u)
{
    vec3 o = cohsm_normalize(vec3(s.to_eye.xy * s.alpha, s.to_eye.z));
    float z = (1.0 - u.x) * (1.0 + o.z) - o.z, r = cohsm_safe_sqrt(1.0 - z * z);
    vec2 sc = cohsm_sincos(2.0 * COHSM_PI * u.y);
    vec3 h = vec3(r * sc.y, r * sc.x, z) + o;
    h = cohsm_normalize(vec3(h.xy * s.alpha, h.z));
    return cohsm_normalize(h * (2.0 * dot(s.to_eye, h)) - s.to_eye);
}

// Returns a direction of a cosine lobe.
vec3 cohsm_lobe_draw(vec4 lobe, vec2 u)
{
    vec3 t, b;
    float c = cohsm_pow(1.0 - u.x, 1.0 / (lobe.w + 1.0)), r = cohsm_safe_sqrt(1.0 - c * c);
    vec2 sc = cohsm_sincos(2.0 * COHSM_PI * u.y);
    cohsm_basis(lobe.xyz, t, b);
    return t * (r * sc.y) + b * (r * sc.x) + lobe.xyz * c;
}

// Returns a direction along the axes; u.x picks the lobe.
vec3 cohsm_brdf_draw(cohsm_surface s, float diffuse_share, vec2 u)
{
    if (u.x < diffuse_share || s.lobe_count == 0) {
        if (diffuse_share > 0.0) u.x = cohsm_clamp_unit(u.x / diffuse_share);
        vec2 p = cohsm_concentric(u);
        return vec3(p, cohsm_safe_sqrt(1.0 - p.x * p.x - p.y * p.y));
    }
    u.x = (u.x - diffuse_share) / (1.0 - diffuse_share);
    if (s.alpha > 0.0) return cohsm_ggx_draw(s, vec2(cohsm_clamp_unit(u.x), u.y));
    vec4 lobe = s.lobes[0];
    float share = s.scales[0].w;
    bool on = true;
    for (int i = 1; i < COHSM_LOBES; i++) {
        on = on && i < s.lobe_count && u.x >= share;
        if (on) {
            u.x -= share;
            share = s.scales[i].w;
            lobe = s.lobes[i];
        }
    }
    return cohsm_lobe_draw(lobe, vec2(cohsm_clamp_unit(u.x / share), u.y));
}
