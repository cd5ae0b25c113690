// cohsm_visible - says whether a point is lit: by distant, local or semi-local light, with all filters, by
// the maps of one object or of a scene of instances. It needs what cohsm_lookup.glsl needs. C twins:
// cohsm_visible and cohsm_visible_scene of csm.h, for one sample. COHSM_ONE_LIGHT and COHSM_ONE_FILTER may be
// defined as the number that all queries have there; the code for others is gone then.
//
//     cohsm_maps maps = cohsm_open(0u);
//     cohsm_query query = cohsm_ask(COHSM_LIGHT_DIRECTION, COHSM_FILTER_PCF, 1.0);
//     float lit = cohsm_visible(maps, query, point, direction);
// uses: cohsm_math cohsm_octa cohsm_random cohsm_lookup

#define COHSM_LIGHT_DIRECTION 0     // light is the unit direction to it; maps of directions
#define COHSM_LIGHT_POSITION 1      // light is a position outside the hulls, in the space of the point
#define COHSM_LIGHT_PARAMETER 2     // light is its coordinates in 0..1 of the maps' domain
#define COHSM_LIGHT_INDEX 3         // light.x is uintBitsToFloat(cell)
#define COHSM_FILTER_NEAREST 0
#define COHSM_FILTER_PCF 1          // 4 pixels of each of 2^d maps, weighted
#define COHSM_FILTER_ROULETTE 2     // one of these pixels at random
#ifdef COHSM_ONE_LIGHT
#define COHSM_LIGHT_OF(q) COHSM_ONE_LIGHT
#else
#define COHSM_LIGHT_OF(q) q.light
#endif
#ifdef COHSM_ONE_FILTER
#define COHSM_FILTER_OF(q) COHSM_ONE_FILTER
#else
#define COHSM_FILTER_OF(q) q.filtering
#endif
#define COHSM_REFUSED (-1.0)        // the light lies inside an object's hull
#define COHSM_NO_PIXEL 0xffffffffu  // of a point beside the map, which is lit

struct cohsm_query {
    int   light;                    // COHSM_LIGHT_...
    int   filtering;                // COHSM_FILTER_...
    float bias;                     // receivers count as nearer to the light by so many pixels of a map
    uint  seed;                     // of roulette
    uint  id;                       // of roulette: number of the sample
};

// Returns a query; with roulette set its seed and id, too.
cohsm_query cohsm_ask(int light, int filtering, float bias)
{
    return cohsm_query(light, filtering, bias, 0u, 0u);
}

// ---- domains ----

// Returns origin + s u + t v + r w of the domain.
vec3 cohsm_affine(const in cohsm_maps m, float s, float t, float r)
{
    vec3 plane = (cohsm_floats(m, 33u) + cohsm_floats(m, 36u) * s) + cohsm_floats(m, 39u) * t;
    return plane + cohsm_floats(m, 42u) * r;
}

// Returns D at coordinates s in 0..1: a unit direction or a position.
vec3 cohsm_map_parameter(const in cohsm_maps m, vec3 s)
{
    if (COHSM_DOMAIN_OF(m) == COHSM_DOMAIN_OCTAHEDRAL) return cohsm_octa_direction(s.xy);
    if (COHSM_DOMAIN_OF(m) == COHSM_DOMAIN_LATLONG || COHSM_DOMAIN_OF(m) == COHSM_DOMAIN_SPHERE) {
        vec2 around = cohsm_sincos((s.x - 0.5) * 6.28318531);
        if (COHSM_DOMAIN_OF(m) == COHSM_DOMAIN_LATLONG) {
            vec2 down = cohsm_sincos(s.y * 3.14159265);
            return vec3(down.x * around.y, down.y, down.x * around.x);
        }
        float y = 1.0 - 2.0 * s.y, ring = cohsm_if(y >= 1.0 || y <= -1.0, 0.0, sqrt(1.0 - y * y));
        vec3 u = cohsm_floats(m, 36u);
        return cohsm_floats(m, 33u) + vec3(ring * around.y, y, ring * around.x) * sqrt(dot(u, u));
    }
    if (COHSM_DOMAIN_OF(m) == COHSM_DOMAIN_DISC) {
        vec2 p = cohsm_concentric(s.xy);
        return cohsm_affine(m, p.x, p.y, 0.0);
    }
    return cohsm_affine(m, s.x, s.y, s.z);
}

// Returns the number of a cell.
uint cohsm_cell(const in cohsm_maps m, uvec3 c) { return c.x + m.side.x * (c.y + m.side.y * c.z); }

// Returns the cell with a number.
uvec3 cohsm_cell_split(const in cohsm_maps m, uint cell)
{
    return uvec3(cell % m.side.x, cell / m.side.x % m.side.y, cell / (m.side.x * m.side.y));
}

// Returns the direction or position of the map of a cell.
vec3 cohsm_cell_location(const in cohsm_maps m, uvec3 c)
{
    if (COHSM_DOMAIN_OF(m) >= COHSM_DOMAIN_TABLE)
        return cohsm_floats(m, m.locations_at + 4u * cohsm_cell(m, c));
    return cohsm_map_parameter(m, (vec3(c) + 0.5) / vec3(m.side));
}

// Writes the axes of the map of a cell of directions; back points to the light.
void cohsm_axes(const in cohsm_maps m, uvec3 c, out vec3 right, out vec3 up, out vec3 back)
{
    back = cohsm_cell_location(m, c);
    if (COHSM_ORIENTATION_OF(m) == COHSM_ORIENTATION_POLAR && COHSM_DOMAIN_OF(m) == COHSM_DOMAIN_LATLONG) {
        vec2 around = cohsm_sincos(((float(c.x) + 0.5) / float(m.side.x) - 0.5) * 6.28318531);
        vec2 down = cohsm_sincos((float(c.y) + 0.5) / float(m.side.y) * 3.14159265);
        right = vec3(-around.x, 0.0, around.y);
        up = vec3(-down.y * around.y, down.x, -down.y * around.x);
        return;
    }
    if (COHSM_ORIENTATION_OF(m) == COHSM_ORIENTATION_POLAR) {
        float h = sqrt(back.x * back.x + back.z * back.z);
        right = cohsm_if(h > 1e-6, vec3(-back.z / h, 0.0, back.x / h), vec3(0.0, 0.0, 1.0));
        up = cross(right, back);
        return;
    }
    float s = COHSM_ORIENTATION_OF(m) == COHSM_ORIENTATION_MINIMAL || back.y >= 0.0 ? 1.0 : -1.0;
    if (abs(s + back.y) < 1e-6) {
        right = vec3(1.0, 0.0, 0.0);
        up = vec3(0.0, 0.0, 1.0);
        return;
    }
    float a = -1.0 / (s + back.y);
    right = vec3(1.0 + s * back.x * back.x * a, -s * back.x, s * back.x * back.z * a);
    up = vec3(back.x * back.z * a, -back.z, s + back.z * back.z * a);
}

// Returns v in the dimensions that the domain has, `rest` in the others.
vec3 cohsm_used(const in cohsm_maps m, vec3 v, float rest)
{
    return vec3(cohsm_if(m.dimensions > 0u, v.x, rest),
                cohsm_if(m.dimensions > 1u, v.y, rest),
                cohsm_if(m.dimensions > 2u, v.z, rest));
}

// Returns the continuous position of a light in the domain, with cell centres at whole numbers.
vec3 cohsm_domain_position(const in cohsm_maps m, vec3 light, int kind)
{
    vec3 u = light, top = vec3(m.side);
    if (kind == COHSM_LIGHT_DIRECTION || kind == COHSM_LIGHT_POSITION) {
        if (COHSM_DOMAIN_OF(m) == COHSM_DOMAIN_LATLONG) {
            u.x = 0.5 + cohsm_atan2(light.z, light.x) * 0.159154943;
            u.y = cohsm_acos(light.y / sqrt(dot(light, light))) * 0.318309886;
        } else
            u.xy = cohsm_octa_square(cohsm_normalize(light));
    }
    u = clamp(u * top, vec3(0.0), top);
    return cohsm_used(m, u, 0.0) - 0.5;
}

// Returns the cell that stands for one a step outside the domain: round the seam, over a pole, across the
// edge of the octahedral square, or at the border.
uvec3 cohsm_wrap(const in cohsm_maps m, ivec3 c)
{
    ivec3 n = ivec3(m.side);
    if (COHSM_DOMAIN_OF(m) == COHSM_DOMAIN_LATLONG || COHSM_DOMAIN_OF(m) == COHSM_DOMAIN_SPHERE) {
        if (c.y < 0 || c.y >= n.y) c.x += n.x / 2;
        if (c.x < 0) c.x += n.x;
        if (c.x >= n.x) c.x -= n.x;
        if (c.x >= n.x) c.x -= n.x;
    } else if (COHSM_DOMAIN_OF(m) == COHSM_DOMAIN_OCTAHEDRAL) {
        if (c.x < 0 || c.x >= n.x) c.y = n.y - 1 - c.y;
        else if (c.y < 0 || c.y >= n.y) c.x = n.x - 1 - c.x;
    }
    return uvec3(clamp(c, ivec3(0), n - 1));
}

// Returns the place of a cell in the sequence of maps.
uint cohsm_place(const in cohsm_maps m, uvec3 c)
{
    bool theta = COHSM_ORDER_OF(m) == COHSM_ORDER_ZIGZAG_THETA;
    bool zigzag = theta || COHSM_ORDER_OF(m) == COHSM_ORDER_ZIGZAG;
    uvec2 n = cohsm_if(theta, m.side.yx, m.side.xy), p = cohsm_if(theta, c.yx, c.xy);
    uint line = cohsm_if((c.z & 1u) != 0u, n.y - 1u - p.y, p.y) + n.y * c.z;
    uint along = line * n.x + cohsm_if((line & 1u) != 0u, n.x - 1u - p.x, p.x), cell = cohsm_cell(m, c);
    uint place = zigzag ? along : cell;
    if (COHSM_ORDER_OF(m) == COHSM_ORDER_HILBERT) {
        bool halves = m.map_count <= 65536u;
        uint word = cohsm_word(m, m.order_at + cohsm_if(halves, cell >> 1, cell));
        place = cohsm_if(halves, (word >> (16u * (cell & 1u))) & 0xffffu, word);
    }
    return place;
}

// ---- one map ----

// Returns q as coordinates of the face of a cube that it lies in: along the face's axis, then the two next
// ones.
vec3 cohsm_face_coordinates(vec3 q, out uint face)
{
    vec3 a = abs(q);
    bool x = a.x >= max(a.y, a.z), y = a.y >= a.z;
    vec3 f = cohsm_if(x, q, cohsm_if(y, q.yzx, q.zxy));       // along the face's axis first
    face = cohsm_if(x, 0u, cohsm_if(y, 2u, 4u)) + uint(f.x < 0.0);
    return vec3(abs(f.x), f.yz);
}

// Returns where a point p, in radii about the centre, lies in the map of a cell: x and y in pixels, and its
// depth in 1/65533 of the range, less the bias. Maps of positions have six faces.
vec3 cohsm_see(const in cohsm_maps m, uvec3 c, vec3 p, float bias, out uint face)
{
    float size = float(m.map_size), middle = 0.5 * size;
    face = 0u;
    if (!COHSM_POSITIONAL(m)) {
        vec3 right, up, back;
        cohsm_axes(m, c, right, up, back);
        return vec3(dot(p, right) * middle + middle, dot(p, up) * middle + middle,
                    (0.5 - 0.5 * dot(p, back) - bias / size) * 65533.0);
    }
    vec3 q = p - (cohsm_cell_location(m, c) - m.center) * (1.0 / m.radius);
    vec3 f = cohsm_face_coordinates(q, face);
    float depth = f.x * (1.0 - 2.0 * bias / size) * (m.radius / m.depth_far) * 65533.0;
    return vec3(f.yz / f.x * middle + middle, depth);
}

// Returns a depth as it is compared with stored ones; below 0: the point is lit.
int cohsm_compared_depth(float depth)
{
    int whole = cohsm_if(depth < 65535.0, int(depth), 65535);
    return depth >= 0.0 ? whole : -1;
}

// Returns the number of the pixel at a position in a map, or COHSM_NO_PIXEL.
uint cohsm_pixel(const in cohsm_maps m, vec2 at)
{
    float top = float(m.map_size);
    if (COHSM_POSITIONAL(m)) {                                 // rounding may leave the face by a hair
        at.x = cohsm_if(at.x < 0.0, 0.0, cohsm_if(at.x >= top, top - 0.5, at.x));
        at.y = cohsm_if(at.y < 0.0, 0.0, cohsm_if(at.y >= top, top - 0.5, at.y));
    }
    uint p = uint(at.y) * m.map_size + uint(at.x), pixel = p - m.pixel_begin;
    bvec4 there = bvec4(at.x >= 0.0, at.x < top, at.y >= 0.0, at.y < top);
    bool kept = all(bvec3(all(there), p >= m.pixel_begin, p < m.pixel_end));
    return kept ? pixel : COHSM_NO_PIXEL;
}

// ---- generalised PCF ----

// Returns how much of the four nearest pixels of one map is dark, bilinearly weighted, 0..1.
float cohsm_pcf_map(const in cohsm_maps m, uvec3 c, vec3 p, float bias)
{
    uint face;
    vec3 seen = cohsm_see(m, c, p, bias, face);
    if (!(abs(seen.x) < 1e6 && abs(seen.y) < 1e6)) return 0.0;
    uint place = cohsm_place(m, c) + face * m.map_count;
    int depth = cohsm_compared_depth(seen.z);
    if (depth < 0) return 0.0;
    vec2 low = floor(seen.xy - 0.5), f = seen.xy - 0.5 - low, g = 1.0 - f, at = low + 0.5;
    uvec4 pixels = uvec4(cohsm_pixel(m, at), cohsm_pixel(m, at + vec2(1.0, 0.0)),
                         cohsm_pixel(m, at + vec2(0.0, 1.0)), cohsm_pixel(m, at + 1.0));
    bvec4 beside = equal(pixels, uvec4(COHSM_NO_PIXEL));
    uvec4 stored = cohsm_stored_depths(m, pixels * uvec4(not(beside)), place) | (65535u * uvec4(beside));
    vec4 dark = vec4(greaterThan(ivec4(depth), ivec4(stored)));
    return ((g.x * g.y * dark.x + f.x * g.y * dark.y) + g.x * f.y * dark.z) + f.x * f.y * dark.w;
}

// Returns how much of the 2^d nearest maps is dark, weighted by their distances in the domain, 0..1.
float cohsm_pcf(const in cohsm_maps m, vec3 at, vec3 p, float bias)
{
    int corners = 1 << int(m.dimensions);
    vec3 low = floor(at), f = at - low;
    float dark = 0.0;
    for (int i = 0; i < corners; i++) {
        ivec3 step = ivec3(i & 1, (i >> 1) & 1, i >> 2);
        float weight = cohsm_if(step.x != 0, f.x, 1.0 - f.x);
        ivec3 c = ivec3(low) + step;
        if (m.dimensions > 1u) weight *= cohsm_if(step.y != 0, f.y, 1.0 - f.y);
        else c.y = 0;
        if (m.dimensions > 2u) weight *= cohsm_if(step.z != 0, f.z, 1.0 - f.z);
        else c.z = 0;
        if (weight > 0.0) dark += weight * cohsm_pcf_map(m, cohsm_wrap(m, c), p, bias);
    }
    return dark;
}

// ---- semi-local light ----

// Returns axis i of the 13 pairs of planes that bound the hull.
vec3 cohsm_dop_axis(int i)
{
    if (i < 3) return vec3(i == 0, i == 1, i == 2);
    if (i < 9) {
        float s = (i & 1) != 0 ? 1.0 : -1.0;
        return cohsm_if(i < 5, vec3(1.0, s, 0.0), cohsm_if(i < 7, vec3(1.0, 0.0, s), vec3(0.0, 1.0, s)));
    }
    return vec3(i == 12 ? -1.0 : 1.0, i == 11 ? -1.0 : 1.0, i == 10 ? -1.0 : 1.0);
}

// Returns the least and greatest extent of the object along axis i, in radii about the centre.
vec2 cohsm_dop(const in cohsm_maps m, int i, vec3 axis)
{
    uint at = 45u + 2u * uint(i);
    uvec2 extent = uvec2(cohsm_word(m, at), cohsm_word(m, at + 1u));
    return (uintBitsToFloat(extent) - dot(axis, m.center)) / m.radius;
}

// Returns 0 if the hull is not between point and light, 1 if it may be, 2 if the light lies inside. Both are
// in radii about the centre.
int cohsm_hull(const in cohsm_maps m, vec3 p, vec3 light)
{
    float enter = 0.0, leave = 1.0;
    bool inside = true, between = true;
    for (int i = 0; i < 13; i++) {
        vec3 a = cohsm_dop_axis(i);
        vec2 extent = cohsm_dop(m, i, a);
        float to = dot(a, light), from = dot(a, p), step = to - from;
        inside = inside && to >= extent.x && to <= extent.y;
        if (step == 0.0) {
            between = between && from >= extent.x && from <= extent.y;
            continue;
        }
        vec2 t = (extent - from) / step;
        enter = max(enter, min(t.x, t.y));
        leave = min(leave, max(t.x, t.y));
    }
    return cohsm_if(inside, 2, between && enter <= leave ? 1 : 0);
}

// ---- one object ----

// Returns whether a direction has a length that can be divided by.
bool cohsm_usable(vec3 light)
{
    float square = dot(light, light);
    return square > 0.0 && square < COHSM_HUGE;
}

// Returns by how much roulette moves a coordinate before it is rounded down, 0..1; 0.5 rounds to the nearest.
float cohsm_jitter(const in cohsm_query q, uint dimension)
{
    return COHSM_FILTER_OF(q) == COHSM_FILTER_ROULETTE ? cohsm_random(q.seed, q.id, dimension) : 0.5;
}

// Returns what cohsm_visible does; p and, for COHSM_LIGHT_POSITION, light are in radii about the sphere's
// centre.
float cohsm_visible_unit(const in cohsm_maps m, const in cohsm_query q, vec3 p, vec3 light)
{
    if (COHSM_LIGHT_OF(q) == COHSM_LIGHT_PARAMETER)
        light = vec3(light.x, cohsm_used(m, light, 0.0).yz);
    if (COHSM_LIGHT_OF(q) != COHSM_LIGHT_INDEX && !cohsm_finite3(light)) return 1.0;
    if (COHSM_LIGHT_OF(q) == COHSM_LIGHT_POSITION) {
        int hull = cohsm_hull(m, p, light);
        if (hull != 1) return hull == 2 ? COHSM_REFUSED : 1.0;
        light -= p;
    }
    if (!cohsm_finite3(p)) return 1.0;
    if (COHSM_LIGHT_OF(q) < COHSM_LIGHT_PARAMETER && !cohsm_usable(light)) return 1.0;
    vec3 at = COHSM_LIGHT_OF(q) == COHSM_LIGHT_INDEX ? vec3(0.0)
                                                     : cohsm_domain_position(m, light, COHSM_LIGHT_OF(q));
    uvec3 c;
    if (COHSM_LIGHT_OF(q) == COHSM_LIGHT_INDEX) {
        if (floatBitsToUint(light.x) >= m.map_count) return 1.0;
        c = cohsm_cell_split(m, floatBitsToUint(light.x));
    } else {
        vec3 jitter = cohsm_used(m, vec3(cohsm_jitter(q, 0u), cohsm_jitter(q, 1u), cohsm_jitter(q, 2u)), 0.5);
        c = cohsm_wrap(m, ivec3(floor(at + jitter)));
    }
    if (COHSM_FILTER_OF(q) == COHSM_FILTER_PCF) {
        float dark = COHSM_LIGHT_OF(q) == COHSM_LIGHT_INDEX ? cohsm_pcf_map(m, c, p, q.bias)
                                                            : cohsm_pcf(m, at, p, q.bias);
        return cohsm_if(dark >= 0.999999, 0.0, 1.0 - dark);
    }
    uint face;
    vec3 seen = cohsm_see(m, c, p, q.bias, face);
    if (COHSM_FILTER_OF(q) == COHSM_FILTER_ROULETTE)
        seen.xy += vec2(cohsm_jitter(q, 3u) - 0.5, cohsm_jitter(q, 4u) - 0.5);
    int depth = cohsm_compared_depth(seen.z);
    uint pixel = depth < 0 ? COHSM_NO_PIXEL : cohsm_pixel(m, seen.xy);
    if (pixel == COHSM_NO_PIXEL) return 1.0;
    return depth > int(cohsm_stored_depth(m, pixel, cohsm_place(m, c) + face * m.map_count)) ? 0.0 : 1.0;
}

// Returns 1 lit, 0 dark, between them with PCF, or COHSM_REFUSED. Point and light are in the object's space.
float cohsm_visible(const in cohsm_maps m, const in cohsm_query q, vec3 point, vec3 light)
{
    float scale = 1.0 / m.radius;
    if (COHSM_LIGHT_OF(q) == COHSM_LIGHT_POSITION) light = (light - m.center) * scale;
    return cohsm_visible_unit(m, q, (point - m.center) * scale, light);
}

// ---- scenes ----

// A table of instances is `count` records of 5 texels from texel `table` on: three rows of the matrix from
// world to object as floats, then the block's first texel, a float of yours (cohsm_instance_note) and two
// floats that cohsm_misses explains, then four floats, centre and radius of a sphere in world space. If you
// keep records and headers elsewhere, define COHSM_INSTANCE(table, i, k), which is texel k of record i, and
// COHSM_HEADER(i, k), which is texel k of its block.
#ifndef COHSM_INSTANCE
#define COHSM_INSTANCE(table, i, k) COHSM_TEXEL((table) + 5u * (i) + (k))
#endif

// Returns whether the way to a light surely misses an instance: for COHSM_LIGHT_POSITION a segment misses the
// sphere (centre, radius), else a cone about the direction, since the map that answers lies up to a cell off.
// cone has the angle of a cell and the radius that the sphere then has. What rounding adds is allowed for,
// and comparisons with NaN are false.
bool cohsm_misses(vec4 sphere, vec2 cone, const in cohsm_query q, vec3 point, vec3 light)
{
    vec3 p = point - sphere.xyz;
    float reach = sphere.w, slope = 0.0, size, along, t, wide;
    bool segment = COHSM_LIGHT_OF(q) == COHSM_LIGHT_POSITION;
    if (segment) light -= point;
    else {
        slope = cone.x * cohsm_if(COHSM_FILTER_OF(q) == COHSM_FILTER_NEAREST, 0.5, 1.0) + 2e-3;
        if (slope >= 1.0) return false;
        slope *= 1.0 + 0.558 * slope * slope;       // no less than the tangent, up to 1
        reach = cone.y;
    }
    reach += 1e-5 * dot(abs(point), vec3(1.0));
    size = dot(light, light);
    along = -dot(p, light) * inversesqrt(size);
    t = cohsm_if(segment, min(along, sqrt(size)), along);
    wide = reach * (1.0 + 0.5 * slope * slope) + along * slope;
    return along < -reach || 0.999997 * dot(p, p) + t * (t - 2.0 * along) > wide * wide;
}

// Returns the maps of an instance.
cohsm_maps cohsm_instance_maps(uint table, uint i)
{
    uint base = COHSM_INSTANCE(table, i, 3u).x;
#ifdef COHSM_HEADER
    return cohsm_unpack(base, COHSM_HEADER(i, 1u), COHSM_HEADER(i, 2u), COHSM_HEADER(i, 3u),
                        COHSM_HEADER(i, 4u), COHSM_HEADER(i, 5u), COHSM_HEADER(i, 6u), COHSM_HEADER(i, 7u));
#else
    return cohsm_open(base);
#endif
}

// Returns what cohsm_visible does for instance i of a table, with point and light in world space.
float cohsm_visible_instance(uint table, uint i, cohsm_query q, vec3 point, vec3 light)
{
    vec4 x = uintBitsToFloat(COHSM_INSTANCE(table, i, 0u)), y = uintBitsToFloat(COHSM_INSTANCE(table, i, 1u));
    vec4 z = uintBitsToFloat(COHSM_INSTANCE(table, i, 2u));
    cohsm_maps m = cohsm_instance_maps(table, i);
    float scale = 1.0 / m.radius;
    point = vec3(dot(x.xyz, point) + x.w, dot(y.xyz, point) + y.w, dot(z.xyz, point) + z.w);
    if (COHSM_LIGHT_OF(q) < COHSM_LIGHT_PARAMETER) {
        light = vec3(dot(x.xyz, light), dot(y.xyz, light), dot(z.xyz, light));
        if (COHSM_LIGHT_OF(q) == COHSM_LIGHT_POSITION)
            light = (light + vec3(x.w, y.w, z.w) - m.center) * scale;
    }
    q.seed += 0x9e3779b9u * i;          // roulette: each instance draws for itself
    return cohsm_visible_unit(m, q, (point - m.center) * scale, light);
}

// Returns the float of yours that the record of an instance holds.
float cohsm_instance_note(uint table, uint i) { return uintBitsToFloat(COHSM_INSTANCE(table, i, 3u).y); }

// Returns whether the way to the light surely misses instance i. It reads one texel, or two for directions.
bool cohsm_misses_instance(uint table, uint i, const in cohsm_query q, vec3 point, vec3 light)
{
    if (COHSM_LIGHT_OF(q) >= COHSM_LIGHT_PARAMETER) return false;
    vec4 sphere = uintBitsToFloat(COHSM_INSTANCE(table, i, 4u));
    vec2 cone = vec2(0.0);
    if (COHSM_LIGHT_OF(q) == COHSM_LIGHT_DIRECTION) cone = uintBitsToFloat(COHSM_INSTANCE(table, i, 3u).zw);
    return cohsm_misses(sphere, cone, q, point, light);
}

// Returns the product of what all instances let through, or COHSM_REFUSED. The one that the point lies on is
// asked first: entity is its number, counted from 1; 0 or a number beyond the list is none, and the point is
// a receiver only. Each invocation first goes on to the next instance that it may meet, so that neighbours
// ask theirs together.
float cohsm_visible_scene(uint table, uint count, uint entity, const in cohsm_query q, vec3 point, vec3 light)
{
    float visible = 1.0;
    uint self = entity - 1u;                                    // where there is none, it is beyond any count
    uint i = 0u, instance = 0u;
    while (visible > 0.0) {                                     // one call in one loop: it is inlined once
        for (; i < count; i++) {
            instance = cohsm_if(self >= count || i > self, i, cohsm_if(i == 0u, self, i - 1u));
#ifdef COHSM_ONE_INSTANCE
            break;
#endif
            if (!cohsm_misses_instance(table, instance, q, point, light)) break;
        }
        if (i >= count) break;
        float one = cohsm_visible_instance(table, instance, q, point, light);
        visible = cohsm_if(one < 0.0, COHSM_REFUSED, visible * one);
        i++;
    }
    return visible;
}
