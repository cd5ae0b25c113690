// sfield_haar_gloss - wavelets: the BRDFs of a pixel on the texels of a cube. C twin: gloss of wavelets in
// shadowfield.h.
// uses: sfield_haar gbuffer
#ifndef SFIELD_GLOSS
#define SFIELD_GLOSS 0              // 1: Phong's lobe and the metal-rough BRDF, as each pixel's material says
#endif
#if SFIELD_GLOSS
// How a pixel looks to its eye.
struct sfield_look {
    vec3 n, v, mirror;              // the normal, to the eye, and where a mirror would look
    bool metal;                     // the metal-rough BRDF
    float exponent;                 // of Phong's lobe; 0: none
    float a2, nv, go;               // metal-rough: alpha^2, n . v and what Smith's shadowing has of both
    float width;                    // of the lobe's half vectors, or of the lobe: a tangent
    vec3 facing;                    // what colors the second kernel: F0 of the metal-rough BRDF, or 1
};

// Prepares the BRDF of a pixel. Returns false if nothing is lit there: metal-rough without a direction to the
// eye. A metal-rough lobe is at least a seventh of a texel wide, and more for an eye along the surface, where
// parts of texels would miss it.
bool sfield_read_look(const in glbk_point p, out sfield_look b)
{
    vec3 view = glbk_haar_batch.eye.xyz - p.position;
    bool seen = dot(view, view) > 0.0;
    b.n = p.normal;
    b.v = seen ? normalize(view) : p.normal;
    b.nv = dot(b.n, b.v);
    float least = mix(0.08, 0.105 / float(glbk_haar_batch.side), clamp(10.0 * b.nv, 0.0, 1.0));
    float alpha = clamp(p.roughness * p.roughness, least, 1.0);
    b.mirror = 2.0 * b.nv * b.n - b.v;
    b.metal = p.kind == GLBK_METAL_ROUGH;
    b.exponent = p.exponent > 0.0 && seen ? clamp(p.exponent, 1.0, 1000.0) : 0.0;
    b.facing = vec3(1.0);
    if (b.metal) b.facing = 0.04 + clamp(p.metallic, 0.0, 1.0) * (clamp(p.diffuse, 0.0, 1.0) - 0.04);
    if (b.nv < 1e-3 && b.metal) {   // below the horizon an eye looks along the surface
        vec3 t = b.v - b.nv * b.n, x = abs(b.n.x) < 0.6 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0);
        if (dot(t, t) < 1e-12) t = cross(b.n, x);
        b.nv = 1e-3;
        b.v = normalize(t) + 1e-3 * b.n;
    }
    b.a2 = alpha * alpha;
    b.go = sqrt(b.a2 + (1.0 - b.a2) * b.nv * b.nv);
    b.width = b.metal ? alpha : sqrt(2.0 / max(b.exponent, 1.0));
    return seen || !b.metal;
}

// Returns x^e for x of 0 to 1 and e up to 1023, with the accuracy of products: drivers' pow() has less.
float sfield_power(float x, float e)
{
    float whole = floor(e), power = pow(max(x, 1e-30), e - whole);
    for (int i = 0; i < 10; i++) {
        float half_of = floor(0.5 * whole);
        power *= whole > 2.0 * half_of ? x : 1.0;
        whole = half_of;
        x *= x;
    }
    return power;
}

// Returns the three kernels times cosine in a direction. Without metal the first is the cosine.
vec3 sfield_response(const in sfield_look b, vec3 l)
{
    float nl = max(dot(b.n, l), 0.0), along = max(dot(b.mirror, l), 0.0);
    float lobe = b.exponent > 0.0 ? (b.exponent + 2.0) * 0.159154943 * sfield_power(along, b.exponent) : 0.0;
    vec3 h = l + b.v, off = cross(h, b.n);      // h has the length 2 v . h
    float hh = max(dot(h, h), 4e-6), nh = dot(h, b.n);
    float q = (dot(off, off) + nh * nh * b.a2) / hh;            // 1 - (n . h)^2 (1 - a2)
    float fifth = 1.0 - sqrt(min(0.25 * hh, 1.0));
    fifth *= fifth * fifth * (fifth * fifth);
    float all = nl * 0.159154943 * b.a2 / (q * q);
    all /= nl * b.go + b.nv * sqrt(b.a2 + (1.0 - b.a2) * nl * nl);
    vec3 metal = vec3(nl * 0.318309886 * (1.0 - fifth), all * (1.0 - fifth), all * fifth);
    vec3 plain = vec3(nl, nl * lobe, 0.0);
    if (nl == 0.0) metal = vec3(0.0);
    return b.metal ? metal : plain;
}

// Returns into how many parts a side a texel is divided, so that one part is not wider than half of what the
// lobe changes over there.
uint sfield_count_parts(const in sfield_look b, vec3 l)
{
    float texel = 1.57079633 / float(glbk_haar_batch.side);
    vec3 h = l + b.v;
    float hh = dot(h, h), off = dot(h, b.n), hv = dot(h, b.v);
    float turned = texel * 0.5 * sqrt(hh) / max(hv, 1e-3);      // h turns by half of what l turns, or more
    float tail = sqrt(max(hh / max(off * off, 1e-12) - 1.0, 0.0));
    float wide = max(0.5 * (tail - turned), b.width);
    uint parts = off > 0.0 ? min(uint(2.0 * turned / wide) + 1u, 16u) : 1u;
    bool far = b.exponent == 0.0 || dot(l, b.mirror) < 1.0 - 8.0 * b.width * b.width - texel;
    uint of_lobe = far ? 1u : uint(2.0 * texel / b.width) + 1u;
    return b.metal ? parts : of_lobe;
}

// Returns the means of the three kernels times cosine over a texel; of Phong's lobe alone the cosine is that
// of the texel's middle.
vec3 sfield_kernels(const in sfield_look b, uint face, ivec2 texel)
{
    vec3 middle = normalize(sfield_from_face(face, sfield_middle(texel))), sum = vec3(0.0);
    uint parts = sfield_count_parts(b, middle);
    float side = float(glbk_haar_batch.side * parts);
    for (uint i = 0u; i < parts * parts; i++) {
        vec2 at = vec2(texel) * float(parts) + vec2(float(i % parts), float(i / parts));
        sum += sfield_response(b, normalize(sfield_from_face(face, (2.0 * at + 1.0) / side - 1.0)));
    }
    sum /= float(parts * parts);
    vec3 plain = vec3(max(dot(middle, b.n), 0.0), sum.y, 0.0);
    return b.metal ? sum : plain;
}
#endif
