// cohsm_brdf - Lambert, Phong, Lafortune and glTF's metal-rough GGX: evaluation, densities, sampling.
// C twins: lsamp_brdf_eval and lsamp_brdf_sample of lightsampling.h.
//
// COHSM_LOBES: lobes that a surface may have, 1 unless there are Lafortune materials of more, at most 8. Registers grow
// with it. COHSM_LOBE(i): uvec4 texel i of the lobes' table, two each: axis and exponent, scale (as float bits).
// uses: cohsm_math
#ifndef COHSM_LOBES
#error "cohsm_brdf.glsl needs COHSM_LOBES, 1..8"
#endif
#ifndef COHSM_LOBE
#error "cohsm_brdf.glsl needs COHSM_LOBE(i), the uvec4 at texel i of the lobes"
#endif

#define COHSM_BRDF_LAMBERT 1u
#define COHSM_BRDF_PHONG 2u
#define COHSM_BRDF_LAFORTUNE 3u
#define COHSM_BRDF_METAL_ROUGH 4u

struct cohsm_material {
    uint type;
    vec3 diffuse;               // albedo; metal-rough: base colour
    vec3 specular;              // PHONG
    float exponent;             // PHONG
    float metallic, roughness;  // METAL_ROUGH
    uint lobe, lobe_count;      // LAFORTUNE: the first one
};

struct cohsm_surface {          // a material at a point; directions in the frame t, b, n
    vec3  t, b, n, wo, diffuse, f0;
    float alpha;                // GGX; 0: cosine lobes
    int   lobe_count;
    vec4  lobes[COHSM_LOBES];   // axis, exponent
    vec4  scales[COHSM_LOBES];  // scale, share of the roulette
    float diffuse_share, peak;
    bool  black;
};

struct cohsm_response { vec3 diffuse, specular; float diffuse_pdf, specular_pdf; };

float cohsm_mean(vec3 c) { return (c.x + c.y + c.z) * (1.0 / 3.0); }
vec3 cohsm_to_frame(cohsm_surface s, vec3 w) { return vec3(dot(w, s.t), dot(w, s.b), dot(w, s.n)); }
vec3 cohsm_from_frame(cohsm_surface s, vec3 w) { return s.t * w.x + s.b * w.y + s.n * w.z; }

vec3 cohsm_schlick(vec3 f0, float cosine)
{
    float x = 1.0 - cosine, f = x * x * (x * x) * x;
    return f0 * (1.0 - f) + f;
}

float cohsm_add_lobe(inout cohsm_surface s, vec3 c, float exponent, vec3 scale)
{
    vec3 a = c * s.wo;
    float size = sqrt(dot(a, a));
    if (!(size > 0.0) || s.lobe_count >= COHSM_LOBES) return 0.0;
    a /= size;
    if (exponent > 0.0) scale *= cohsm_pow(size, exponent);
    float albedo = cohsm_mean(scale) * 2.0 * COHSM_PI / (exponent + 2.0) * max(a.z, 0.1);
    if (!(albedo > 0.0) || !cohsm_finite3(scale)) return 0.0;
    s.lobes[s.lobe_count] = vec4(a, exponent);
    s.scales[s.lobe_count] = vec4(scale, albedo);
    s.lobe_count++;
    return albedo;
}

float cohsm_specular_init(inout cohsm_surface s, cohsm_material m)
{
    if (m.type == COHSM_BRDF_METAL_ROUGH) {
        s.alpha = max(m.roughness * m.roughness, 0.002);
        s.f0 = vec3(0.04) * (1.0 - m.metallic) + m.diffuse * m.metallic;
        s.diffuse = m.diffuse * (1.0 - m.metallic);
        s.lobe_count = 1;
        float share = cohsm_mean(cohsm_schlick(s.f0, s.wo.z));
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
            sum += cohsm_add_lobe(s, axis.xyz, axis.w, uintBitsToFloat(COHSM_LOBE(2u * (m.lobe + i) + 1u)).xyz);
        }
    return sum;
}

// tangent: any length; zero for none. normal and wo: about unit length.
cohsm_surface cohsm_surface_at(cohsm_material m, vec3 normal, vec3 tangent, vec3 wo)
{
    cohsm_surface s;
    s.n = cohsm_normalize(normal);
    vec3 t = tangent - s.n * dot(tangent, s.n);
    if (dot(t, t) > 1e-6) {
        s.t = cohsm_normalize(t);
        s.b = cross(s.n, s.t);
    } else
        cohsm_basis(s.n, s.t, s.b);
    s.wo = cohsm_to_frame(s, cohsm_normalize(wo));
    if (s.wo.z < 1e-3) s.wo = cohsm_normalize(vec3(s.wo.xy, 1e-3));
    s.wo.z = min(s.wo.z, 1.0);
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
    s.diffuse_share = s.black ? 1.0 : diffuse / (diffuse + specular);
    s.peak = s.diffuse_share * (1.0 / COHSM_PI);
    for (int i = 0; i < s.lobe_count; i++) {
        s.scales[i].w /= specular;
        float lobe = s.alpha > 0.0 ? 0.25 / (COHSM_PI * s.alpha * s.alpha) : (s.lobes[i].w + 1.0) / (2.0 * COHSM_PI);
        s.peak += (1.0 - s.diffuse_share) * s.scales[i].w * lobe;
    }
    return s;
}

// GGX, Smith's height-correlated shadowing, density of visible normals.
void cohsm_ggx(cohsm_surface s, vec3 wi, inout cohsm_response r)
{
    vec3 h = cohsm_normalize(s.wo + wi);
    float a2 = s.alpha * s.alpha, q = h.x * h.x + h.y * h.y + a2 * h.z * h.z, d = a2 / (COHSM_PI * q * q);
    float go = sqrt(a2 + (1.0 - a2) * s.wo.z * s.wo.z), gi = sqrt(a2 + (1.0 - a2) * wi.z * wi.z);
    vec3 f = cohsm_schlick(s.f0, clamp(dot(s.wo, h), 0.0, 1.0));
    r.specular = f * (0.5 * d / (wi.z * go + s.wo.z * gi));
    r.diffuse *= 1.0 - f;
    r.specular_pdf = 0.5 * d / (s.wo.z + go);
}

// f and the densities for wi in the frame, the diffuse and the specular part apart.
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
    for (int i = 0; i < s.lobe_count; i++) {
        float c = dot(s.lobes[i].xyz, wi);
        if (!(c > 0.0)) continue;
        c = cohsm_pow(c, s.lobes[i].w);
        r.specular += s.scales[i].xyz * c;
        r.specular_pdf += s.scales[i].w * c * (s.lobes[i].w + 1.0) / (2.0 * COHSM_PI);
    }
    return r;
}

float cohsm_brdf_pdf(cohsm_surface s, cohsm_response r)
{
    return s.diffuse_share * r.diffuse_pdf + (1.0 - s.diffuse_share) * r.specular_pdf;
}

// Visible normals by spherical caps (Dupuy and Benyoub 2023).
vec3 cohsm_ggx_draw(cohsm_surface s, vec2 u)
{
    vec3 o = cohsm_normalize(vec3(s.wo.xy * s.alpha, s.wo.z));
    float z = (1.0 - u.x) * (1.0 + o.z) - o.z, r = cohsm_safe_sqrt(1.0 - z * z);
    vec2 sc = cohsm_sincos(2.0 * COHSM_PI * u.y);
    vec3 h = vec3(r * sc.y, r * sc.x, z) + o;
    h = cohsm_normalize(vec3(h.xy * s.alpha, h.z));
    return cohsm_normalize(h * (2.0 * dot(s.wo, h)) - s.wo);
}

vec3 cohsm_lobe_draw(vec4 lobe, vec2 u)
{
    vec3 t, b;
    float c = cohsm_pow(1.0 - u.x, 1.0 / (lobe.w + 1.0)), r = cohsm_safe_sqrt(1.0 - c * c);
    vec2 sc = cohsm_sincos(2.0 * COHSM_PI * u.y);
    cohsm_basis(lobe.xyz, t, b);
    return t * (r * sc.y) + b * (r * sc.x) + lobe.xyz * c;
}

// wi in the frame, the lobe picked by u.x.
vec3 cohsm_brdf_draw(cohsm_surface s, float diffuse_share, vec2 u)
{
    if (u.x < diffuse_share || s.lobe_count == 0) {
        vec2 p = cohsm_concentric(vec2(diffuse_share > 0.0 ? cohsm_clamp_unit(u.x / diffuse_share) : u.x, u.y));
        return vec3(p, cohsm_safe_sqrt(1.0 - p.x * p.x - p.y * p.y));
    }
    u.x = (u.x - diffuse_share) / (1.0 - diffuse_share);
    if (s.alpha > 0.0) return cohsm_ggx_draw(s, vec2(cohsm_clamp_unit(u.x), u.y));
    int i = 0;
    for (; i + 1 < s.lobe_count && u.x >= s.scales[i].w; i++) u.x -= s.scales[i].w;
    return cohsm_lobe_draw(s.lobes[i], vec2(cohsm_clamp_unit(u.x / s.scales[i].w), u.y));
}
