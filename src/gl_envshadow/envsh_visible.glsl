// envsh_visible - finds the visibility of directional lights by their shadow maps. Its C twins stand in
// envshadow.h (src/envshadow/filter.h and shade.h).
// The program defines:
//   ENVSH_FILTER             envsh_filter: 1 plain, 2 smoothing, 3 percentage closer, 4 or 0 penumbra
//   ENVSH_TEXEL(i)           uvec4, texel i of the lights' table (docs/gpu-layouts.md)
//   ENVSH_STORED(view, at)   float, the depth at texel `at` of the view's tile
//   ENVSH_CELL(view, at, l)  vec2, least and greatest depth of a cell of 8 << l texels a side
//   ENVSH_DISC(i)            vec2, tap i on the unit disc
#if !(defined ENVSH_FILTER && defined ENVSH_TEXEL && defined ENVSH_STORED)
#error "envsh_visible: define ENVSH_FILTER, ENVSH_TEXEL and ENVSH_STORED"
#endif
#if !(defined ENVSH_CELL && defined ENVSH_DISC)
#error "envsh_visible: define ENVSH_CELL and ENVSH_DISC"
#endif
#if ENVSH_FILTER == 0
#undef ENVSH_FILTER
#define ENVSH_FILTER 4
#endif

struct envsh_query {
    float radius, bias, extent_scale;       // these five as in envshadow.h's envsh_query
    uint taps, seed;
    int side;                       // texels a side of a tile
    int levels;                     // levels of cells
};

struct envsh_view {
    vec4 row_x, row_y;              // rows that take a world point to texels of the tile
    vec4 row_z;                     // and to its depth
    vec3 right, up;                 // unit axes of the tile
    vec2 texel;                     // world size of a texel
    float depth_range;              // world distance of depth 0..1
    vec4 spread;                    // half axes of the light's extent, in texels for each unit of depth
    uint light;                     // its number
    uint place;                     // column, row and page of its tile: 11, 11, 10 bits
};

struct envsh_receiver {
    vec2 at;                        // texels of the tile
    vec2 slope;                     // how much the depth of its plane grows with each texel
    float z;                        // depth
    float limit;                    // the most by which the slope may bring a tap nearer to the light
};

// Returns texel i of the eight that a light has in the table.
vec4 envsh_texel(uint light, uint i) { return uintBitsToFloat(ENVSH_TEXEL(8u * light + i)); }

// Returns the unit direction to a light.
vec3 envsh_direction(uint light) { return envsh_texel(light, 5u).xyz; }

// Returns the irradiance by a light, W/m^2, of a plane that faces it.
vec3 envsh_power(uint light) { return envsh_texel(light, 6u).xyz; }

// Reads all that the table says of a light.
envsh_view envsh_read_view(uint light)
{
    envsh_view v;
    vec4 right = envsh_texel(light, 3u), up = envsh_texel(light, 4u);
    v.row_x = envsh_texel(light, 0u);
    v.row_y = envsh_texel(light, 1u);
    v.row_z = envsh_texel(light, 2u);
    v.right = right.xyz;
    v.up = up.xyz;
    v.texel = vec2(right.w, up.w);
    v.depth_range = envsh_texel(light, 5u).w;
    v.place = ENVSH_TEXEL(8u * light + 6u).w;
    v.spread = envsh_texel(light, 7u);
    v.light = light;
    return v;
}

// Returns a hash of x, the one of envshadow.h.
uint envsh_hash32(uint x)
{
    uint state = x * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return (word >> 22) ^ word;
}

// Returns a hash of two numbers.
uint envsh_hash_combine(uint a, uint b) { return envsh_hash32(a + 0x9e3779b9u * envsh_hash32(b)); }

// Returns cosine and sine of 0 .. 2 pi with the digits of envshadow.h. The functions of drivers are off by
// enough to move a tap to another texel.
vec2 envsh_turn(float x)
{
    int k = int(x * 0.636619772 + 0.5);
    float r = ((x - float(k) * 1.5703125) - float(k) * 4.837512969970703125e-4) -
              float(k) * 7.5497899548918822e-8;
    float z = r * r, s = r + r * z * (-0.1666665494 + z * (0.008332178146 + z * -0.0001951729898));
    float c = (1.0 - 0.5 * z) + z * z * (0.04166664687 + z * (-0.001388736752 + z * 2.443845159e-5));
    vec2 cs = (k & 1) != 0 ? vec2(s, c) : vec2(c, s);
    return vec2(((k + 1) & 2) != 0 ? -cs.x : cs.x, (k & 2) != 0 ? -cs.y : cs.y);
}

// Returns the texel at a place, which is held where whole numbers are exact.
ivec2 envsh_place(vec2 at) { return ivec2(floor(clamp(at, vec2(-64.0), vec2(8192.0)))); }

// Returns whether a texel lies outside the tile.
bool envsh_outside(envsh_query q, ivec2 at)
{
    return any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(q.side)));
}

// Returns whether light reaches the receiver's plane at the centre of a texel. Beyond the tile nothing is in
// the way. stored gets the depth that the tile has there.
bool envsh_lit(envsh_query q, envsh_view v, envsh_receiver r, ivec2 at, out float stored)
{
    stored = 1.0;
    if (envsh_outside(q, at)) return true;
    stored = ENVSH_STORED(v, at);
    float z = r.z + max(dot(r.slope, vec2(at) + 0.5 - r.at), -r.limit);
    return stored >= 1.0 || z <= stored;
}

// Returns 1 if depths nearest .. farthest are lit everywhere within reach of `at`, 0 if they are dark, -1 if
// that is not known. Four cells of at least that size tell.
int envsh_decide_box(envsh_query q, envsh_view v, vec2 at, vec2 reach, float nearest, float farthest)
{
    ivec2 low = envsh_place(at - reach), high = envsh_place(at + reach), last = ivec2(q.side - 1);
    if (any(lessThan(high, ivec2(0))) || any(greaterThan(low, last))) return 1;
    bool outside = envsh_outside(q, low) || envsh_outside(q, high);
    low = max(low, ivec2(0));
    high = min(high, last);
    int wide = max(high.x - low.x, high.y - low.y), level = 0;
    while (level + 1 < q.levels && (8 << level) < wide) level++;
    low >>= 3 + level;
    high >>= 3 + level;
    vec2 a = ENVSH_CELL(v, low, level), b = ENVSH_CELL(v, ivec2(high.x, low.y), level);
    vec2 c = ENVSH_CELL(v, ivec2(low.x, high.y), level), d = ENVSH_CELL(v, high, level);
    float least = min(min(a.x, b.x), min(c.x, d.x)), most = max(max(a.y, b.y), max(c.y, d.y));
    if (least >= 1.0 || farthest <= least) return 1;
    return !outside && most < 1.0 && nearest > most ? 0 : -1;
}

// Returns what envsh_decide_box does, for a receiver's kernel with these half widths in texels.
int envsh_decide(envsh_query q, envsh_view v, envsh_receiver r, vec2 reach)
{
    float slope = dot(abs(r.slope), reach + 1.0);
    return envsh_decide_box(q, v, r.at, reach, r.z - min(slope, r.limit), r.z + slope);
}

// Returns the lit share of all texels within radius + 1 along both axes. Their weights fall to 0 at that
// distance.
float envsh_smooth(envsh_query q, envsh_view v, envsh_receiver r)
{
    int reach = int(q.radius) + 1;
    ivec2 center = envsh_place(r.at);
    float sum = 0.0, weights = 0.0, stored;
    for (int y = -reach; y <= reach; y++)
        for (int x = -reach; x <= reach; x++) {
            ivec2 at = center + ivec2(x, y);
            vec2 w = q.radius + 1.0 - abs(vec2(at) + 0.5 - r.at);
            if (!(w.x > 0.0) || !(w.y > 0.0)) continue;
            weights += w.x * w.y;
            if (envsh_lit(q, v, r, at, stored)) sum += w.x * w.y;
        }
    return weights > 0.0 ? sum / weights : 1.0;
}

// Returns the texel of tap i on the ellipse with half axes a and b, the taps turned by the unit vector cs.
ivec2 envsh_tap(envsh_receiver r, uint i, vec2 a, vec2 b, vec2 cs)
{
    vec2 d = ENVSH_DISC(i);
    return envsh_place(r.at + (d.x * cs.x - d.y * cs.y) * a + (d.x * cs.y + d.y * cs.x) * b);
}

// Returns the lit share of all taps on that ellipse.
float envsh_taps(envsh_query q, envsh_view v, envsh_receiver r, vec2 a, vec2 b, vec2 cs)
{
    float lit = 0.0, stored;
    for (uint i = 0u; i < q.taps; i++)
        lit += envsh_lit(q, v, r, envsh_tap(r, i, a, b, cs), stored) ? 1.0 : 0.0;
    return lit / float(q.taps);
}

// Shortens both half axes so that neither reaches beyond `most` texels, and lengthens them to at least 0.7 of
// one.
void envsh_limit(inout vec2 a, inout vec2 b, float most)
{
    float la = length(a), lb = length(b), least = min(0.7, most), f;
    f = la > most ? most / la : 1.0;
    a *= f;
    la *= f;
    f = lb > most ? most / lb : 1.0;
    b *= f;
    lb *= f;
    if (la < least) {
        a = vec2(least, 0.0);
        b = vec2(0.0, least);
    } else if (lb < least) {
        b = vec2(-a.y, a.x) * (least / la);
    }
}

// Computes the half axes of the kernel, in texels: as far as the light's extent spreads over a distance in
// depth. They are held where their squares are still numbers.
void envsh_kernel(envsh_query q, envsh_view v, float away, out vec2 a, out vec2 b)
{
    away = min(max(away, 0.0) * q.extent_scale, 1e9);
    a = clamp(v.spread.xy * away, -1e15, 1e15);
    b = clamp(v.spread.zw * away, -1e15, 1e15);
    envsh_limit(a, b, q.radius);
}

// Returns the lit share of a kernel as wide as the penumbra. A first round of taps finds the mean depth of
// what is in the way, over which the light's extent spreads.
float envsh_penumbra(envsh_query q, envsh_view v, envsh_receiver r, vec2 cs)
{
    float occluders = 0.0, found = 0.0, stored;
    vec2 a, b;
    envsh_kernel(q, v, r.z, a, b);
    int known = envsh_decide(q, v, r, abs(a) + abs(b));
    if (known >= 0) return float(known);
    for (uint i = 0u; i < q.taps; i++)
        if (!envsh_lit(q, v, r, envsh_tap(r, i, a, b, cs), stored)) {
            occluders += stored;
            found += 1.0;
        }
    if (found == 0.0) return 1.0;
    envsh_kernel(q, v, r.z - occluders / found, a, b);
    return envsh_taps(q, v, r, a, b, cs);
}

// Returns how far a tap may follow the receiver's plane towards the light, in depth.
float envsh_plane_limit(envsh_query q, envsh_view v)
{
    float texels = 4.0;
    if (ENVSH_FILTER == 1) texels = 3.0;
    if (ENVSH_FILTER == 2) texels = q.radius + 4.0;
    if (ENVSH_FILTER == 3) texels = q.radius + 3.0;
    return texels * max(v.texel.x, v.texel.y) / v.depth_range;
}

// Moves a point along its normal by the bias and takes it into the tile. cosine, of normal and light, is
// above 0.
envsh_receiver envsh_receive(envsh_query q, envsh_view v, vec3 p, vec3 n, float cosine)
{
    envsh_receiver r;
    vec2 flat_n = vec2(dot(n, v.right), dot(n, v.up));
    float texel = max(v.texel.x, v.texel.y);
    p += n * (q.bias * texel * (0.25 + 0.75 * length(flat_n)));
    r.at = vec2(dot(v.row_x, vec4(p, 1.0)), dot(v.row_y, vec4(p, 1.0)));
    r.z = dot(v.row_z, vec4(p, 1.0));
    r.slope = flat_n * v.texel / (max(cosine, 0.1) * v.depth_range);
    r.limit = envsh_plane_limit(q, v);
    return r;
}

// Returns the visibility of a light from a point, 0..1. n is the surface's own unit normal on the side that
// is seen. index turns the taps: give each pixel another one.
float envsh_visible(envsh_query q, uint light, vec3 p, vec3 n, uint index)
{
    float cosine = dot(n, envsh_direction(light)), stored;
    if (!(cosine > 0.0)) return 0.0;
    envsh_view v = envsh_read_view(light);
    envsh_receiver r = envsh_receive(q, v, p, n, cosine);
#if ENVSH_FILTER == 1
    return envsh_lit(q, v, r, envsh_place(r.at), stored) ? 1.0 : 0.0;
#elif ENVSH_FILTER == 2
    int known = envsh_decide(q, v, r, vec2(q.radius + 1.0));
    return known >= 0 ? float(known) : envsh_smooth(q, v, r);
#else
    vec2 cs = envsh_turn(6.28318531 * (float(envsh_hash_combine(q.seed, index) >> 8) * (1.0 / 16777216.0)));
#if ENVSH_FILTER == 3
    int known = envsh_decide(q, v, r, vec2(q.radius));
    return known >= 0 ? float(known) : envsh_taps(q, v, r, vec2(q.radius, 0.0), vec2(0.0, q.radius), cs);
#else
    return envsh_penumbra(q, v, r, cs);
#endif
#endif
}

// Returns the irradiance by lights from .. to - 1, W/m^2: the sum of visibility times cosine times their own.
// n is the shading normal, flat_n the surface's own.
vec3 envsh_irradiance(envsh_query q, uint from, uint to, vec3 p, vec3 n, vec3 flat_n, uint index)
{
    vec3 sum = vec3(0.0);
    for (uint light = from; light < to; light++) {
        float cosine = dot(n, envsh_direction(light));
        if (cosine > 0.0) sum += envsh_visible(q, light, p, flat_n, index) * cosine * envsh_power(light);
    }
    return sum;
}
