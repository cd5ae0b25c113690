// cohsm_visible - is a point lit: distant, local and semi-local light, all filters, one object or a scene of
// instances, receivers. Needs what cohsm_lookup.glsl needs. C twins: cohsm_visible and
// cohsm_visible_scene of csm.h, for one sample.
//
//     cohsm_maps maps = cohsm_open(0u);
//     float lit = cohsm_visible(maps, cohsm_ask(COHSM_LIGHT_DIRECTION, COHSM_FILTER_PCF, 1.0), point, direction);
// uses: cohsm_math cohsm_lookup

#define COHSM_LIGHT_DIRECTION 0     // light: the unit direction to it; maps of directions
#define COHSM_LIGHT_POSITION 1      // light: a position outside the hulls, in the space of the point
#define COHSM_LIGHT_PARAMETER 2     // light: coordinates in 0..1 of the maps' domain
#define COHSM_LIGHT_INDEX 3         // light.x: uintBitsToFloat(cell)
#define COHSM_FILTER_NEAREST 0
#define COHSM_FILTER_PCF 1          // 2^d maps x 4 pixels
#define COHSM_FILTER_ROULETTE 2     // one of them at random
#define COHSM_REFUSED (-1.0)        // the light lies inside an object's hull
#define COHSM_NO_PIXEL 0xffffffffu  // beside the map: lit

struct cohsm_query {
    int   light, filtering;
    float bias;                     // map pixels
    uint  seed, id;                 // of roulette; id: number of the sample
};

cohsm_query cohsm_ask(int light, int filtering, float bias) { return cohsm_query(light, filtering, bias, 0u, 0u); }

// ---- domains ----

vec3 cohsm_affine(cohsm_maps m, float s, float t, float r)
{
    return ((cohsm_floats(m, 33u) + cohsm_floats(m, 36u) * s) + cohsm_floats(m, 39u) * t) + cohsm_floats(m, 42u) * r;
}

// D at coordinates s: a unit direction or a position.
vec3 cohsm_map_parameter(cohsm_maps m, vec3 s)
{
    if (m.domain == COHSM_DOMAIN_OCTAHEDRAL) return cohsm_octa_direction(s.xy);
    if (m.domain == COHSM_DOMAIN_LATLONG || m.domain == COHSM_DOMAIN_SPHERE) {
        vec2 around = cohsm_sincos((s.x - 0.5) * 6.28318531);
        if (m.domain == COHSM_DOMAIN_LATLONG) {
            vec2 down = cohsm_sincos(s.y * 3.14159265);
            return vec3(down.x * around.y, down.y, down.x * around.x);
        }
        float y = 1.0 - 2.0 * s.y, ring = y >= 1.0 || y <= -1.0 ? 0.0 : sqrt(1.0 - y * y);
        vec3 u = cohsm_floats(m, 36u);
        return cohsm_floats(m, 33u) + vec3(ring * around.y, y, ring * around.x) * sqrt(dot(u, u));
    }
    if (m.domain == COHSM_DOMAIN_DISC) {
        vec2 p = cohsm_concentric(s.xy);
        return cohsm_affine(m, p.x, p.y, 0.0);
    }
    return cohsm_affine(m, s.x, s.y, s.z);
}

uint cohsm_cell(cohsm_maps m, uvec3 c) { return c.x + m.side.x * (c.y + m.side.y * c.z); }

uvec3 cohsm_cell_split(cohsm_maps m, uint cell)
{
    return uvec3(cell % m.side.x, cell / m.side.x % m.side.y, cell / (m.side.x * m.side.y));
}

vec3 cohsm_cell_location(cohsm_maps m, uvec3 c)
{
    if (m.domain >= COHSM_DOMAIN_TABLE) return cohsm_floats(m, m.locations_at + 4u * cohsm_cell(m, c));
    return cohsm_map_parameter(m, (vec3(c) + 0.5) / vec3(m.side));
}

// Right and up of a direction's map.
void cohsm_frame(cohsm_maps m, uvec3 c, out vec3 right, out vec3 up, out vec3 back)
{
    back = cohsm_cell_location(m, c);
    if (m.frame == COHSM_FRAME_POLAR && m.domain == COHSM_DOMAIN_LATLONG) {
        vec2 around = cohsm_sincos(((float(c.x) + 0.5) / float(m.side.x) - 0.5) * 6.28318531);
        vec2 down = cohsm_sincos((float(c.y) + 0.5) / float(m.side.y) * 3.14159265);
        right = vec3(-around.x, 0.0, around.y);
        up = vec3(-down.y * around.y, down.x, -down.y * around.x);
        return;
    }
    if (m.frame == COHSM_FRAME_POLAR) {
        float h = sqrt(back.x * back.x + back.z * back.z);
        right = h > 1e-6 ? vec3(-back.z / h, 0.0, back.x / h) : vec3(0.0, 0.0, 1.0);
        up = cross(right, back);
        return;
    }
    float s = m.frame == COHSM_FRAME_MINIMAL || back.y >= 0.0 ? 1.0 : -1.0;
    if (abs(s + back.y) < 1e-6) {
        right = vec3(1.0, 0.0, 0.0);
        up = vec3(0.0, 0.0, 1.0);
        return;
    }
    float a = -1.0 / (s + back.y);
    right = vec3(1.0 + s * back.x * back.x * a, -s * back.x, s * back.x * back.z * a);
    up = vec3(back.x * back.z * a, -back.z, s + back.z * back.z * a);
}

// Continuous position in the domain, cell centres at whole numbers.
vec3 cohsm_domain_position(cohsm_maps m, vec3 light, int kind)
{
    vec3 u = light, top = vec3(m.side);
    if (kind == COHSM_LIGHT_DIRECTION || kind == COHSM_LIGHT_POSITION) {
        if (m.domain == COHSM_DOMAIN_LATLONG) {
            u.x = 0.5 + cohsm_atan2(light.z, light.x) * 0.159154943;
            u.y = cohsm_acos(light.y / sqrt(dot(light, light))) * 0.318309886;
        } else
            u.xy = cohsm_octa_square(cohsm_normalize(light));
    }
    u = clamp(u * top, vec3(0.0), top);
    return vec3(m.dimensions > 0u ? u.x : 0.0, m.dimensions > 1u ? u.y : 0.0, m.dimensions > 2u ? u.z : 0.0) - 0.5;
}

// Brings a cell one step outside back: round the seam, over a pole, across the octahedral square's edge, to the border.
uvec3 cohsm_wrap(cohsm_maps m, ivec3 c)
{
    ivec3 n = ivec3(m.side);
    if (m.domain == COHSM_DOMAIN_LATLONG || m.domain == COHSM_DOMAIN_SPHERE) {
        if (c.y < 0 || c.y >= n.y) c.x += n.x / 2;
        if (c.x < 0) c.x += n.x;
        if (c.x >= n.x) c.x -= n.x;
        if (c.x >= n.x) c.x -= n.x;
    } else if (m.domain == COHSM_DOMAIN_OCTAHEDRAL) {
        if (c.x < 0 || c.x >= n.x) c.y = n.y - 1 - c.y;
        else if (c.y < 0 || c.y >= n.y) c.x = n.x - 1 - c.x;
    }
    return uvec3(clamp(c, ivec3(0), n - 1));
}

// Place of a cell in the sequence of maps.
uint cohsm_place(cohsm_maps m, uvec3 c)
{
    if (m.order == COHSM_ORDER_ZIGZAG) {
        uint line = ((c.z & 1u) != 0u ? m.side.y - 1u - c.y : c.y) + m.side.y * c.z;
        return line * m.side.x + ((line & 1u) != 0u ? m.side.x - 1u - c.x : c.x);
    }
    if (m.order == COHSM_ORDER_ZIGZAG_THETA) {
        uint line = ((c.z & 1u) != 0u ? m.side.x - 1u - c.x : c.x) + m.side.x * c.z;
        return line * m.side.y + ((line & 1u) != 0u ? m.side.y - 1u - c.y : c.y);
    }
    uint cell = cohsm_cell(m, c);
    if (m.order != COHSM_ORDER_HILBERT) return cell;
    return m.map_count <= 65536u ? cohsm_half_word(m, m.order_at, cell) : cohsm_word(m, m.order_at + cell);
}

// ---- one map ----

// Coordinates of a cube's face: along the axis, then the two next ones.
vec3 cohsm_face_coordinates(vec3 q, out uint face)
{
    vec3 a = abs(q);
    if (a.x >= a.y && a.x >= a.z) {
        face = q.x < 0.0 ? 1u : 0u;
        return vec3(a.x, q.y, q.z);
    }
    if (a.y >= a.z) {
        face = q.y < 0.0 ? 3u : 2u;
        return vec3(a.y, q.z, q.x);
    }
    face = q.z < 0.0 ? 5u : 4u;
    return vec3(a.z, q.x, q.y);
}

// Point p, in radii about the centre, in the map of a cell: pixels, and depth in 16 bits.
vec3 cohsm_see(cohsm_maps m, uvec3 c, vec3 p, float bias, out uint face)
{
    float size = float(m.map_size), middle = 0.5 * size;
    face = 0u;
    if (!m.positional) {
        vec3 right, up, back;
        cohsm_frame(m, c, right, up, back);
        return vec3(dot(p, right) * middle + middle, dot(p, up) * middle + middle,
                    (0.5 - 0.5 * dot(p, back) - bias / size) * 65533.0);
    }
    vec3 q = p - (cohsm_cell_location(m, c) - m.center) * (1.0 / m.radius);
    vec3 f = cohsm_face_coordinates(q, face);
    return vec3(f.yz / f.x * middle + middle, f.x * (1.0 - 2.0 * bias / size) * (m.radius / m.depth_far) * 65533.0);
}

int cohsm_compared_depth(float depth)
{
    if (!(depth >= 0.0)) return -1;
    return depth < 65535.0 ? int(depth) : 65535;
}

uint cohsm_pixel(cohsm_maps m, vec2 at)
{
    float top = float(m.map_size);
    if (m.positional) {                                 // rounding may leave the face by a hair
        at.x = at.x < 0.0 ? 0.0 : at.x >= top ? top - 0.5 : at.x;
        at.y = at.y < 0.0 ? 0.0 : at.y >= top ? top - 0.5 : at.y;
    }
    if (!(at.x >= 0.0 && at.x < top && at.y >= 0.0 && at.y < top)) return COHSM_NO_PIXEL;
    uint p = uint(at.y) * m.map_size + uint(at.x);
    return p >= m.pixel_begin && p < m.pixel_end ? p - m.pixel_begin : COHSM_NO_PIXEL;
}

float cohsm_lit(cohsm_maps m, vec2 at, uint place, int depth)
{
    if (depth < 0) return 1.0;
    uint pixel = cohsm_pixel(m, at);
    if (pixel == COHSM_NO_PIXEL) return 1.0;
    return depth > int(cohsm_stored_depth(m, pixel, place)) ? 0.0 : 1.0;
}

// ---- generalised PCF: what is dark, weighted ----

float cohsm_pcf_map(cohsm_maps m, uvec3 c, vec3 p, float bias)
{
    uint face;
    vec3 seen = cohsm_see(m, c, p, bias, face);
    if (!(abs(seen.x) < 1e6 && abs(seen.y) < 1e6)) return 0.0;
    uint place = cohsm_place(m, c) + face * m.map_count;
    int depth = cohsm_compared_depth(seen.z);
    vec2 low = floor(seen.xy - 0.5), f = seen.xy - 0.5 - low;
    float dark = 0.0;
    for (int i = 0; i < 4; i++) {
        vec2 corner = vec2(float(i & 1), float(i >> 1));
        float weight = (corner.x > 0.0 ? f.x : 1.0 - f.x) * (corner.y > 0.0 ? f.y : 1.0 - f.y);
        if (weight > 0.0) dark += weight * (1.0 - cohsm_lit(m, low + corner + 0.5, place, depth));
    }
    return dark;
}

float cohsm_pcf(cohsm_maps m, vec3 at, vec3 p, float bias)
{
    int corners = 1 << int(m.dimensions);
    vec3 low = floor(at), f = at - low;
    float dark = 0.0;
    for (int i = 0; i < corners; i++) {
        ivec3 step = ivec3(i & 1, (i >> 1) & 1, i >> 2);
        float weight = step.x != 0 ? f.x : 1.0 - f.x;
        ivec3 c = ivec3(low) + step;
        if (m.dimensions > 1u) weight *= step.y != 0 ? f.y : 1.0 - f.y;
        else c.y = 0;
        if (m.dimensions > 2u) weight *= step.z != 0 ? f.z : 1.0 - f.z;
        else c.z = 0;
        if (weight > 0.0) dark += weight * cohsm_pcf_map(m, cohsm_wrap(m, c), p, bias);
    }
    return dark;
}

// ---- semi-local light ----

vec3 cohsm_dop_axis(int i)
{
    if (i < 3) return vec3(i == 0, i == 1, i == 2);
    if (i < 9) {
        float s = (i & 1) != 0 ? 1.0 : -1.0;
        return i < 5 ? vec3(1.0, s, 0.0) : i < 7 ? vec3(1.0, 0.0, s) : vec3(0.0, 1.0, s);
    }
    return i == 9 ? vec3(1.0) : i == 10 ? vec3(1.0, 1.0, -1.0) : i == 11 ? vec3(1.0, -1.0, 1.0) : vec3(-1.0, 1.0, 1.0);
}

// Least and greatest extent of the object along the axis, in radii about the centre.
vec2 cohsm_dop(cohsm_maps m, int i, vec3 axis)
{
    uint at = 45u + 2u * uint(i);
    return (uintBitsToFloat(uvec2(cohsm_word(m, at), cohsm_word(m, at + 1u))) - dot(axis, m.center)) / m.radius;
}

// 0: the hull is not between point and light; 1: it may be; 2: the light lies inside. All in radii about the centre.
int cohsm_hull(cohsm_maps m, vec3 p, vec3 light)
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
    return inside ? 2 : between && enter <= leave ? 1 : 0;
}

// ---- one object ----

bool cohsm_usable(vec3 light)
{
    float square = dot(light, light);
    return square > 0.0 && square < COHSM_HUGE;
}

float cohsm_jitter(cohsm_query q, uint dimension)
{
    return q.filtering == COHSM_FILTER_ROULETTE ? cohsm_random(q.seed, q.id, dimension) : 0.5;
}

// p and, for COHSM_LIGHT_POSITION, light in radii about the sphere's centre.
float cohsm_visible_unit(cohsm_maps m, cohsm_query q, vec3 p, vec3 light)
{
    bool by_index = q.light == COHSM_LIGHT_INDEX;
    if (q.light == COHSM_LIGHT_PARAMETER)
        light = vec3(light.x, m.dimensions > 1u ? light.y : 0.0, m.dimensions > 2u ? light.z : 0.0);
    if (!by_index && !cohsm_finite3(light)) return 1.0;
    if (q.light == COHSM_LIGHT_POSITION) {
        int hull = cohsm_hull(m, p, light);
        if (hull != 1) return hull == 2 ? COHSM_REFUSED : 1.0;
        light -= p;
    }
    if (!cohsm_finite3(p)) return 1.0;
    if (q.light < COHSM_LIGHT_PARAMETER && !cohsm_usable(light)) return 1.0;
    vec3 at = by_index ? vec3(0.0) : cohsm_domain_position(m, light, q.light);
    uvec3 c;
    if (by_index) {
        if (floatBitsToUint(light.x) >= m.map_count) return 1.0;
        c = cohsm_cell_split(m, floatBitsToUint(light.x));
    } else {
        vec3 moved = at + vec3(m.dimensions > 0u ? cohsm_jitter(q, 0u) : 0.5,
                               m.dimensions > 1u ? cohsm_jitter(q, 1u) : 0.5,
                               m.dimensions > 2u ? cohsm_jitter(q, 2u) : 0.5);
        c = cohsm_wrap(m, ivec3(floor(moved)));
    }
    if (q.filtering == COHSM_FILTER_PCF) {
        float dark = by_index ? cohsm_pcf_map(m, c, p, q.bias) : cohsm_pcf(m, at, p, q.bias);
        return dark >= 0.999999 ? 0.0 : 1.0 - dark;
    }
    uint face;
    vec3 seen = cohsm_see(m, c, p, q.bias, face);
    if (q.filtering == COHSM_FILTER_ROULETTE)
        seen.xy += vec2(cohsm_jitter(q, 3u) - 0.5, cohsm_jitter(q, 4u) - 0.5);
    int depth = cohsm_compared_depth(seen.z);
    uint pixel = depth < 0 ? COHSM_NO_PIXEL : cohsm_pixel(m, seen.xy);
    if (pixel == COHSM_NO_PIXEL) return 1.0;
    return depth > int(cohsm_stored_depth(m, pixel, cohsm_place(m, c) + face * m.map_count)) ? 0.0 : 1.0;
}

// Point and light in the object's space: 1 lit, 0 dark, between with PCF, or COHSM_REFUSED.
float cohsm_visible(cohsm_maps m, cohsm_query q, vec3 point, vec3 light)
{
    float scale = 1.0 / m.radius;
    if (q.light == COHSM_LIGHT_POSITION) light = (light - m.center) * scale;
    return cohsm_visible_unit(m, q, (point - m.center) * scale, light);
}

// ---- scenes ----

// A table of instances is `count` records of 4 texels from texel `table` on: three rows of the matrix from world to
// object as floats, then the block's first texel, a float of yours (cohsm_instance_note), 0, 0. If you keep records and
// headers elsewhere: COHSM_INSTANCE(table, i, k), texel k of record i, and COHSM_HEADER(i, k), texel k of its block.
#ifndef COHSM_INSTANCE
#define COHSM_INSTANCE(table, i, k) COHSM_TEXEL((table) + 4u * (i) + (k))
#endif

cohsm_maps cohsm_instance_maps(uint table, uint i)
{
    uint base = COHSM_INSTANCE(table, i, 3u).x;
#ifdef COHSM_HEADER
    return cohsm_unpack(base, COHSM_HEADER(i, 1u), COHSM_HEADER(i, 2u), COHSM_HEADER(i, 3u), COHSM_HEADER(i, 4u),
                        COHSM_HEADER(i, 5u), COHSM_HEADER(i, 6u), COHSM_HEADER(i, 7u));
#else
    return cohsm_open(base);
#endif
}

float cohsm_visible_instance(uint table, uint i, cohsm_query q, vec3 point, vec3 light)
{
    vec4 x = uintBitsToFloat(COHSM_INSTANCE(table, i, 0u)), y = uintBitsToFloat(COHSM_INSTANCE(table, i, 1u));
    vec4 z = uintBitsToFloat(COHSM_INSTANCE(table, i, 2u));
    cohsm_maps m = cohsm_instance_maps(table, i);
    q.seed += 0x9e3779b9u * i;          // roulette: each instance draws for itself
    point = vec3(dot(x.xyz, point) + x.w, dot(y.xyz, point) + y.w, dot(z.xyz, point) + z.w);
    if (q.light < COHSM_LIGHT_PARAMETER) {
        light = vec3(dot(x.xyz, light), dot(y.xyz, light), dot(z.xyz, light));
        if (q.light == COHSM_LIGHT_POSITION) light += vec3(x.w, y.w, z.w);
    }
    return cohsm_visible(m, q, point, light);
}

float cohsm_instance_note(uint table, uint i) { return uintBitsToFloat(COHSM_INSTANCE(table, i, 3u).y); }

// The product over all instances, the one that the point lies on first. entity: its number, counted from 1; 0 or a
// number beyond the list: none, the point is a receiver only.
float cohsm_visible_scene(uint table, uint count, uint entity, cohsm_query q, vec3 point, vec3 light)
{
    float visible = 1.0;
    uint self = entity - 1u;                                    // of none: beyond any count
    for (uint i = 0u; i < count && visible > 0.0; i++) {        // one call, which is inlined, and no turn for nothing
        uint instance = self >= count || i > self ? i : i == 0u ? self : i - 1u;
        float one = cohsm_visible_instance(table, instance, q, point, light);
        visible = one < 0.0 ? COHSM_REFUSED : visible * one;
    }
    return visible;
}
