// cohsm_emission - a light as it lies in the table of lights, and what a point of it emits: its function L
// (how much), read from texels, or picked in proportion to them. C twin: src/lightsampling/emitter.h.
//
// COHSM_LIGHT_TEXEL(i) is texel i of the table of lights, a uvec4, as glbk_csm_light_write writes it
// (docs/gpu-layouts.md). COHSM_ONE_SHAPE may be defined as the shape of all lights; the code for others is
// gone then. COHSM_OWN_LIGHT may be defined if the program has glbk_light_point and glbk_light_emission, the
// user's functions for shapes and emission.
// uses: cohsm_math
#ifndef COHSM_LIGHT_TEXEL
#error "cohsm_emission: COHSM_LIGHT_TEXEL(i), texel i of the lights"
#endif

#define COHSM_SHAPE_ENVIRONMENT 1u
#define COHSM_SHAPE_SUN 2u
#define COHSM_SHAPE_POINT 3u
#define COHSM_SHAPE_SPOT 4u
#define COHSM_SHAPE_LINE 5u
#define COHSM_SHAPE_RECTANGLE 6u
#define COHSM_SHAPE_DISC 7u
#define COHSM_SHAPE_SPHERE 8u
#define COHSM_SHAPE_OWN 9u      // the user's glbk_light_point
#define COHSM_SHAPE_MESH 10u    // a table of triangles: u.x picks one by area, y and z a point in it
#define COHSM_SHAPE_SURFACE 11u // a grid of points
#ifdef COHSM_OWN_LIGHT
void glbk_light_point(vec4 own, vec3 x, out vec3 position, out vec3 normal, out float area);
vec3 glbk_light_emission(vec4 own, vec3 x, vec3 direction);
#endif
#ifdef COHSM_ONE_SHAPE
#define COHSM_SHAPE_OF(l) uint(COHSM_ONE_SHAPE)
#else
#define COHSM_SHAPE_OF(l) l.shape
#endif
#define COHSM_INFINITY 3.402823466e38

struct cohsm_light {
    uint  base;                 // its first texel
    uint  shape;                // COHSM_SHAPE_...
    uint  width;                // of L
    uint  height;
    uint  flags;                // 1: L is there; 2: a rectangle with right angles; 4: L is linear between
                                // centres; 8: its columns go round, 16: those of a surface; 32: own emission
    uint  texels_at;            // texels of L, of running sums, of triangles
    uint  sums_at;
    uint  triangles_at;
    uint  triangle_count;       // of a surface: its width, and its height in the upper half
    vec3  origin;               // position, centre, corner or start
    vec3  n;                    // normal, axis or direction
    vec3  ex;                   // dual edge of u; of a disc its x axis
    vec3  ey;                   // dual edge of v; of a disc its y axis
    vec3  u;
    vec3  v;
    vec3  radiance;
    vec4  own;                  // numbers of the user's
    float radius,
          lx,                   // length of u
          ly,                   // length of v
          area,
          cos_cone,             // of the half angle
          turn,                 // rotation of a sky, as a share of a whole turn
          cosine_power;         // of the emission
};

struct cohsm_aim {              // a light as one point sees it
    vec3  p;                    // the point
    vec3  axis;                 // sphere, line: unit, to the centre or the nearest point of the infinite line
    float range,                // sphere, line: along the axis
          spread,               // sphere: 1 - cosine of the cone; line: greatest sine of a seen normal
          solid_pdf,            // density per solid angle, where it is constant; else 0
          solid;                // solid angle, about
    vec4  edges;                // rectangle: x0 x1 y0 y1, as Urena, Fajardo and King name them
    vec4  cap;                  // rectangle: z b0 b1 k
};

struct cohsm_emission {
    vec3  direction;            // to it, unit
    float range;                // COHSM_INFINITY for sky and sun
    vec3  coords;               // of the light, 0..1
    vec3  radiance;
    float pdf;                  // per solid angle
};

// Returns texel i of the table as floats.
vec4 cohsm_floats(uint i) { return uintBitsToFloat(COHSM_LIGHT_TEXEL(i)); }

// Reads the light that begins at a texel.
cohsm_light cohsm_light_open(uint base)
{
    cohsm_light l;
    uvec4 a = COHSM_LIGHT_TEXEL(base), b = COHSM_LIGHT_TEXEL(base + 1u);
    vec4 c = cohsm_floats(base + 2u), d = cohsm_floats(base + 3u);
    vec4 e = cohsm_floats(base + 4u), f = cohsm_floats(base + 5u);
    vec4 g = cohsm_floats(base + 6u), h = cohsm_floats(base + 7u);
    l.base = base;
    l.shape = a.x;
    l.width = a.y;
    l.height = a.z;
    l.flags = a.w;
    l.texels_at = base + b.x;
    l.sums_at = base + b.y;
    l.triangles_at = base + b.z;
    l.triangle_count = b.w;
    l.origin = c.xyz;
    l.radius = c.w;
    l.n = d.xyz;
    l.lx = d.w;
    l.ex = e.xyz;
    l.ly = e.w;
    l.ey = f.xyz;
    l.area = f.w;
    l.radiance = g.xyz;
    l.cos_cone = g.w;
    l.own = vec4(0.0);
    l.turn = h.w;
    c = cohsm_floats(base + 8u);
    l.u = c.xyz;
    l.cosine_power = c.w;
    l.v = cohsm_floats(base + 9u).xyz;
    return l;
}

bool cohsm_light_textured(const in cohsm_light l) { return (l.flags & 1u) != 0u; }

// Returns whether a light is a sun, point or spot, which cannot be hit.
bool cohsm_light_is_delta(const in cohsm_light l)
{
    return COHSM_SHAPE_OF(l) >= COHSM_SHAPE_SUN && COHSM_SHAPE_OF(l) <= COHSM_SHAPE_SPOT;
}

// Returns the cell of `count` that x in 0..1 falls into.
uint cohsm_index(float x, uint count) { return min(uint(x * float(count)), count - 1u); }

// Returns texel x, y of L, and in w the density of its samples.
vec4 cohsm_light_texel(const in cohsm_light l, uint x, uint y)
{
    return cohsm_floats(l.texels_at + y * l.width + x);
}

// Returns L at coordinates x, and in w the density of samples there, which is 1 in the mean. L is that of the
// nearest texel, or linear between centres; the density is that of the nearest texel.
vec4 cohsm_texel_at(const in cohsm_light l, vec2 x)
{
    if (!cohsm_light_textured(l)) return vec4(1.0);
    uint i = cohsm_index(x.x, l.width), j = cohsm_index(x.y, l.height);
    vec4 a = cohsm_light_texel(l, i, j);
    if ((l.flags & 4u) == 0u) return a;
    vec2 f = vec2(x.x * float(l.width) - (float(i) + 0.5), x.y * float(l.height) - (float(j) + 0.5));
    bool round_about = (l.flags & 8u) != 0u;
    uint before = cohsm_if(i > 0u, i - 1u, cohsm_if(round_about, l.width - 1u, 0u));
    uint after = cohsm_if(i + 1u < l.width, i + 1u, cohsm_if(round_about, 0u, i));
    uint i2 = f.x < 0.0 ? before : after;
    uint j2 = cohsm_if(f.y < 0.0, max(j, 1u) - 1u, min(j + 1u, l.height - 1u));
    f = abs(f);
    vec3 row = a.xyz * (1.0 - f.x) + cohsm_light_texel(l, i2, j).xyz * f.x;
    vec3 other = cohsm_light_texel(l, i, j2).xyz * (1.0 - f.x) + cohsm_light_texel(l, i2, j2).xyz * f.x;
    return vec4(row * (1.0 - f.y) + other * f.y, a.w);
}

// Returns the cell of running sums that u falls into, and where inside. Each of the `count` texels from `at`
// on holds the sum before its cell and the sum after it, and, as integers, where the search begins and ends
// for numbers that fall into that fraction of 0..1.
uint cohsm_invert(uint at, uint count, float u, out float fraction)
{
    uvec4 t = COHSM_LIGHT_TEXEL(at + cohsm_index(u, count));
    uint lo = t.z, hi = t.w;
    while (hi - lo > 1u) {
        uint middle = lo + (hi - lo) / 2u;
        bool later = cohsm_floats(at + middle).x <= u;
        lo = later ? middle : lo;
        hi = later ? hi : middle;
    }
    vec2 sums = cohsm_floats(at + lo).xy;
    while (lo + 1u < count && sums.y <= u) sums = cohsm_floats(at + ++lo).xy;
    while (lo > 0u && (sums.x > u || !(sums.y > sums.x)))
        sums = cohsm_floats(at + --lo).xy;
    fraction = cohsm_clamp_unit((u - sums.x) / (sums.y - sums.x));
    return lo;
}

// Returns the texel that u picks in proportion to its density, and where inside.
uvec2 cohsm_pick_cell(const in cohsm_light l, vec2 u, out vec2 inside)
{
    uint y = cohsm_invert(l.sums_at, l.height, u.y, inside.y);
    uint x = cohsm_invert(l.sums_at + l.height + y * l.width, l.width, u.x, inside.x);
    return uvec2(x, y);
}

// Returns the coordinates that u picks in proportion to their density.
vec2 cohsm_pick_coords(const in cohsm_light l, vec2 u)
{
    if (!cohsm_light_textured(l)) return u;
    vec2 inside;
    uvec2 cell = cohsm_pick_cell(l, u, inside);
    return vec2(cohsm_clamp_unit((float(cell.x) + inside.x) / float(l.width)),
                cohsm_clamp_unit((float(cell.y) + inside.y) / float(l.height)));
}

// Sets the radiance of an emission, and returns whether there is any.
bool cohsm_emit(const in cohsm_light l, vec3 texel, float cosine, inout cohsm_emission e)
{
    e.radiance = l.radiance * texel;
    if (l.cosine_power > 0.0) e.radiance *= cohsm_pow(cosine, l.cosine_power);
#ifdef COHSM_OWN_LIGHT
    if ((l.flags & 32u) != 0u) {
        vec3 away = cohsm_if(COHSM_SHAPE_OF(l) == COHSM_SHAPE_ENVIRONMENT, e.direction, -e.direction);
        e.radiance *= max(glbk_light_emission(l.own, e.coords, away), vec3(0.0));
    }
#endif
    return cohsm_finite3(e.radiance) && e.radiance.x + e.radiance.y + e.radiance.z > 0.0;
}

// Sets the emission of a point q of the surface, with the normal n (0: a volume) and coordinates x, as the
// aim's point sees it; returns whether it sees any. area_pdf is the density of samples per area where that
// over the coordinates is 1.
bool cohsm_emit_area(const in cohsm_light l, const in cohsm_aim a, vec3 q, vec3 n, vec2 x, float area_pdf,
                     inout cohsm_emission e)
{
    vec3 d = q - a.p;
    float square = dot(d, d), range = sqrt(square);
    if (!(range > 0.0) || !cohsm_finite(square)) return false;
    vec3 w = d * (1.0 / range);
    float cosine = -dot(n, w);
#ifdef COHSM_OWN_LIGHT
    cosine = n == vec3(0.0) ? 1.0 : cosine;
#endif
    if (!(cosine > 1e-7)) return false;
    cosine = min(cosine, 1.0);
    e.coords.xy = vec2(cohsm_clamp_unit(x.x), cohsm_clamp_unit(x.y));
    e.range = range;
    vec4 texel = cohsm_texel_at(l, x);
    e.pdf = cohsm_if(a.solid_pdf > 0.0, a.solid_pdf, texel.w * area_pdf * square / cosine);
    e.direction = w;
    return cohsm_emit(l, texel.xyz, cosine, e);
}
