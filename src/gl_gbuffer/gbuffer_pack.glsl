// gbuffer_pack - declares what a pixel of the G-buffer says, and packs its unit vectors into 32 bits.
#define GLBK_LAMBERT 1u             // the numbers of lsamp_material_kind
#define GLBK_PHONG 2u
#define GLBK_LAFORTUNE 3u
#define GLBK_METAL_ROUGH 4u

struct glbk_point {
    vec3 position;                  // world
    vec3 normal;                    // unit, for shading, on the side that is seen
    vec3 geometric;                 // unit, the surface's own normal, on that side too
    vec3 tangent;                   // unit, the x axis of Lafortune's lobes; 0: any
    uint kind;                      // GLBK_LAMBERT to GLBK_METAL_ROUGH; 0: nothing is seen
    vec3 diffuse;                   // albedo; metal-rough: the base colour
    vec3 specular;                  // Phong, else 0
    float exponent;                 // Phong, else 0
    float metallic;                 // metal-rough, else 0
    float roughness;                // metal-rough, else 0
    uint lobe;                      // Lafortune: number of its first lobe in the technique's table; else 0
    uint lobe_count;                // Lafortune, else 0
    float occlusion;                // share of bounced light that does not reach the point, 0..1
    uint entity;                    // number of the entity that the point lies on, from 1; 0: none
    uint plane;                     // number of the receiver plane that it lies on, from 1; 0: none
};

// Returns v with length 1, or 0 where it has no length or one that is not a number.
vec3 glbk_unit(vec3 v)
{
    float d = dot(v, v);
    return d > 0.0 ? v * inversesqrt(d) : vec3(0.0);
}

// Returns the unit vector that the octahedral map has at a point of the square -1..1.
vec3 glbk_unit_of_square(vec2 p)
{
    float z = 1.0 - abs(p.x) - abs(p.y), t = max(-z, 0.0);
    return glbk_unit(vec3(p.x + (p.x >= 0.0 ? -t : t), p.y + (p.y >= 0.0 ? -t : t), z));
}

// Packs a unit vector, off by less than 5e-5; a vector of no length becomes 0xffffffff.
uint glbk_pack_unit(vec3 n)
{
    float sum = abs(n.x) + abs(n.y) + abs(n.z);
    if (!(sum > 0.0)) return 0xffffffffu;
    n /= sum;
    vec2 p = n.z >= 0.0 ? n.xy : (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
    uvec2 q = uvec2(floor(clamp(p * 0.5 + 0.5, 0.0, 1.0) * 65534.0 + 0.5));
    return q.x | (q.y << 16);
}

// Unpacks what glbk_pack_unit packed; 0xffffffff becomes a vector of no length.
vec3 glbk_unpack_unit(uint bits)
{
    if (bits == 0xffffffffu) return vec3(0.0);
    return glbk_unit_of_square(vec2(float(bits & 0xffffu), float(bits >> 16)) * (2.0 / 65534.0) - 1.0);
}
