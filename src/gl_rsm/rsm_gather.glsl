// rsm_gather - computes bounced light of a receiver: from the list of pixel lights, and from texels about its
// projection. RSM_SURFACES=1 is defined where near_field makes surfaces of near texels. With 0, the default,
// all lights are points.
// uses: rsm_pick
#ifndef RSM_SURFACES
#define RSM_SURFACES 0
#endif

// Interpolation needs 1 / the squared distance of the nearest light so far that is not edge-on.
float rsm_near = 0.0;

struct rsm_sampling {       // how points about a receiver are taken
    float r_max;            // radius of the pattern, as a share of the map; 0 = up to the map's border
    float offset;           // as in rsm_gather_desc
    float clamp_at;         // rsm_gather_desc.clamp; 0 = no limit
    float near_limit;       // as in rsm_gather_desc
    float near_field;       // as in rsm_gather_desc
    float set_count;        // sets of pixels that share the points
    float mixed;            // scale of RSM_PATTERN_MIXED; 0 = another pattern
    float picked;           // lights that RSM_PATTERN_MIXED picks by flux
    bool  glossy;           // whether there are materials
};

struct rsm_centre {         // where a pattern about a receiver has its centre
    vec3 at;                // a place in the unit square, or a unit direction
    vec3 right, up;         // the axes across that direction
};

// Returns equation (1) without flux: cos cos / d^2, at most bound. Both cosines times d must exceed the
// rounding of positions, so that a plane does not light itself (T40).
float rsm_form(vec3 p, vec3 n, vec3 light, vec3 light_normal, float bound)
{
    vec3 d = light - p, most = max(abs(p), abs(light));
    float rounding = 4e-7 * max(max(most.x, most.y), most.z), inverse = 1.0 / max(dot(d, d), 1e-18);
    float receives = max(dot(n, d) - rounding, 0.0), emits = max(-dot(light_normal, d) - rounding, 0.0);
    float form = (receives * inverse) * (emits * inverse);
    if (form * dot(d, d) > 1e-3) rsm_near = max(rsm_near, inverse);
    return min(form, bound);
}

#if RSM_SURFACES
// Computes half the sides of the surface under a texel at p: the cross section of its beam, projected along
// the beam onto the plane of n. Their parallelogram has rsm_area's area, since both bound grazing surfaces
// alike, along the light.
void rsm_texel_sides(rsm_light l, int face, vec3 p, vec3 n, out vec3 side, out vec3 other)
{
    vec3 a, d;
    float scale = l.extent / l.side;
    rsm_face_axes(l, face, side, other, a);
    d = a;
    if (l.kind != RSM_SUN) {
        float depth = dot(p - l.position, a);
        d = (p - l.position) / depth;
        scale *= depth;
    }
    float facing = dot(d, n), least = 0.05 * length(d),
          bounded = max(abs(facing), least) * (facing < 0.0 ? -1.0 : 1.0);
    vec3 along = d - n * facing;
    vec2 off = vec2(dot(side, n), dot(other, n)), stretched = off / bounded;
    if (abs(facing) < least)
        stretched += vec2(dot(side, along), dot(other, along)) *
                     ((1.0 - abs(facing) / least) / dot(along, along));
    side = (side - n * off.x - along * stretched.x) * scale;
    other = (other - n * off.y - along * stretched.y) * scale;
}

// Returns the share that an edge has in Lambert's sum: angle(a, b) n . (b x a) / |b x a|.
float rsm_edge(vec3 n, vec3 a, vec3 b)
{
    vec3 c = cross(b - a, a);
    float size = length(c);
    return size > 0.0 ? atan(size, dot(a, b)) * (dot(n, c) / size) : 0.0;
}

// Returns the share of an edge that is clipped at the horizon of n. leave and come get the points at which
// the outline goes below the horizon and comes back.
float rsm_clipped_edge(vec3 n, vec3 a, vec3 b, inout vec3 leave, inout vec3 come)
{
    float ha = dot(n, a), hb = dot(n, b);
    if (!(ha > 0.0) && !(hb > 0.0)) return 0.0;
    if (!(ha > 0.0 && hb > 0.0)) {
        vec3 at = a + (b - a) * (ha / (ha - hb));
        if (ha > 0.0) b = leave = at;
        else a = come = at;
    }
    return rsm_edge(n, a, b);
}

// Returns the integral of cos cos / d^2 over the parallelogram c +- u +- v, seen from the origin and clipped
// at the horizon of n: pi times the form factor (Baum, Rushmeier and Winget 1989). The horizon cuts the
// parallelogram at most once, so the points at which the outline goes below and comes back are joined. There
// is no loop here, since a loop calls this function and llvmpipe counts the rounds of nested loops together.
float rsm_form_of(vec3 n, vec3 c, vec3 u, vec3 v)
{
    vec3 p = c - u - v, q = c + u - v, r = c + u + v, s = c - u + v;
    vec3 leave = c, come = c;
    float sum = rsm_clipped_edge(n, p, q, leave, come) + rsm_clipped_edge(n, q, r, leave, come);
    sum += rsm_clipped_edge(n, r, s, leave, come) + rsm_clipped_edge(n, s, p, leave, come);
    return 0.5 * abs(sum + rsm_edge(n, leave, come));
}
#endif

// Returns rsm_form for a light that is a texel of a face; nearer than the root of near2, returns the mean
// over the surface that the texel is. Receivers that face the surface, nearer to its plane than half its
// side, get by degrees no more than from a point: there lie the backs of bent sheets, through which the
// parallelogram reaches.
float rsm_texel_form(rsm_light l, vec3 p, vec3 n, int face, vec3 light, vec3 light_normal, float bound,
                     float near2)
{
    float form = rsm_form(p, n, light, light_normal, bound);
#if RSM_SURFACES
    vec3 d = light - p, most = max(abs(p), abs(light)), u, v;
    float height = -dot(light_normal, d), d2 = dot(d, d), facing = -2.0 * dot(n, light_normal);
    if (!(d2 < near2)) return form;
    if (!(height > 4e-7 * max(max(most.x, most.y), most.z))) return 0.0;
    rsm_texel_sides(l, face, light, light_normal, u, v);
    float area = 4.0 * length(cross(u, v)), point = max(dot(n, d) / d2, 0.0) * (height / d2);
    form = area > 0.0 ? rsm_form_of(n, d, u, v) / area : 0.0;
    if (form > point && facing > 0.0 && 4.0 * height * height < area)
        form += min(facing, 1.0) * (1.0 - 2.0 * height / sqrt(area)) * (point - form);
    form = min(form, bound);
#endif
    return form;
}

// Returns the glossy part of light towards p: a Phong lobe about the mirrored direction of the light.
// material has specular reflectance and exponent.
vec3 rsm_gloss(rsm_light l, vec3 p, vec3 light, vec3 light_normal, float form, vec3 incident, vec4 material)
{
    vec3 to = rsm_to_light(l, light), mirror = 2.0 * dot(light_normal, to) * light_normal - to, d = p - light;
    float c = dot(mirror, d) / max(sqrt(dot(d, d)), 1e-9);
    if (!(c > 0.0)) return vec3(0.0);
    return incident * material.xyz * (0.5 * (material.w + 2.0) * pow(min(c, 1.0), material.w)) * form;
}

// Returns the most that a pair's form may be, for a light of an area.
float rsm_bound_of(float area, float limit_clamp, float near_limit)
{
    float bound = limit_clamp > 0.0 ? limit_clamp : 3.0e38;
    return near_limit > 0.0 && area > 0.0 ? min(bound, near_limit * RSM_PI / area) : bound;
}

// Returns the place of a texel: in the unit square, or on the sphere of diameter 1.
vec3 rsm_mixed_place(rsm_light l, ivec3 t)
{
    vec2 q = vec2(rsm_texel_centre(l, t.x), rsm_texel_centre(l, t.y));
    vec3 r, u, a;
    if (l.faces == 1) return vec3(q * 0.5 + 0.5, 0.0);
    rsm_face_axes(l, t.z, r, u, a);
    return rsm_normalize(a + r * q.x + u * q.y) * 0.5;
}

// Returns where patterns about p have their centre. If inside is true, the centre is kept away from the map's
// border.
rsm_centre rsm_centre_of(rsm_light l, vec3 p, bool inside)
{
    rsm_centre centre = rsm_centre(vec3(0.0), vec3(0.0), vec3(0.0));
    if (l.faces != 1) {
        vec3 c = rsm_normalize(p - l.position);
        if (!(dot(c, c) > 0.25)) c = l.axis;
        float s = c.z >= 0.0 ? 1.0 : -1.0, a = -1.0 / (s + c.z), b = c.x * c.y * a;
        centre.right = vec3(1.0 + s * c.x * c.x * a, s * b, -s * c.x);
        centre.up = vec3(b, s + c.y * c.y * a, -c.y);
        centre.at = c;
        return centre;
    }
    vec3 q = rsm_to_face(l, 0, p);
    if (l.kind != RSM_SUN && !(q.z > 0.0)) q = vec3(0.0);
    q = vec3(q.xy * 0.5 + 0.5, 0.0);
    centre.at = inside ? vec3(clamp(q.xy, 0.02, 0.98), 0.0) : q;
    return centre;
}

// Finds the texel under a point of a pattern about the receiver, and how many texels the point stands for.
// turn is cosine and sine of the pixel's rotation. With r_max 0 the pattern reaches the map's border. Returns
// false if the point is outside the map.
bool rsm_place_sample(rsm_light l, float r_max, rsm_centre centre, vec3 point, vec2 turn, out ivec3 t,
                      out float weight)
{
    vec2 q = vec2(point.x * turn.x - point.y * turn.y, point.x * turn.y + point.y * turn.x);
    int size = int(l.side);
    t = ivec3(0);
    weight = 0.0;
    if (l.faces == 1) {
        float r = r_max;
        if (!(r > 0.0)) {
            float len = length(q);
            vec2 d = len > 0.0 ? q / len : vec2(0.0), room;
            room.x = abs(d.x) > 1e-9 ? (d.x > 0.0 ? 1.0 - centre.at.x : centre.at.x) / abs(d.x) : 4.0;
            room.y = abs(d.y) > 1e-9 ? (d.y > 0.0 ? 1.0 - centre.at.y : centre.at.y) / abs(d.y) : 4.0;
            r = min(room.x, room.y);
        }
        weight = point.z * r * r * l.side * l.side;
        q = (centre.at.xy + r * q) * l.side;
        if (!(r_max > 0.0)) q = clamp(q, vec2(0.0), vec2(l.side - 0.5));
        if (any(lessThan(q, vec2(0.0))) || any(greaterThanEqual(q, vec2(l.side)))) return false;
        t = ivec3(ivec2(q), 0);
        return true;
    }
    float r = r_max > 0.0 && r_max < 1.0 ? r_max : 1.0;
    q *= r;
    float s = dot(q, q), k = 2.0 * sqrt(max(1.0 - s, 0.0));
    vec3 d = centre.at * (1.0 - 2.0 * s) + centre.right * (q.x * k) + centre.up * (q.y * k), a, fr, fu;
    t.z = rsm_face_of_direction(l, d);
    if (t.z >= l.faces) return false;
    rsm_face_axes(l, t.z, fr, fu, a);
    q = vec2(dot(d, fr), dot(d, fu)) / dot(d, a);
    t.xy = min(ivec2((q * 0.5 + 0.5) * l.side), ivec2(size - 1));
    q = vec2(rsm_texel_centre(l, t.x), rsm_texel_centre(l, t.y));
    s = 1.0 + dot(q, q);
    weight = point.z * r * r * l.side * l.side * s * sqrt(s);
    return true;
}

// Returns pi times the light of numbers from .. to - 1 of the list. glossy says whether there are materials.
// mixed is the scale of RSM_PATTERN_MIXED; if it is 0, all lights were picked by flux.
vec3 rsm_gather_list(rsm_light l, vec3 p, vec3 n, uint from, uint to, bool glossy, float mixed)
{
    vec3 sum = vec3(0.0), centre = vec3(0.0);
    if (mixed > 0.0) centre = rsm_centre_of(l, p, true).at * (l.faces == 1 ? 1.0 : 0.5);
    for (uint i = from; i < to; i++) {
        vec4 a = uintBitsToFloat(RSM_LIGHT(i, 0)), b = uintBitsToFloat(RSM_LIGHT(i, 1));
        uvec4 c = RSM_LIGHT(i, 2);
        float w = 1.0, near2 = mixed > 0.0 ? 0.0 : b.w;
        float form = rsm_texel_form(l, p, n, int(c.w >> 24), a.xyz, b.xyz, a.w, near2);
        if (mixed > 0.0) {
            ivec3 t = ivec3(c.w & 4095u, (c.w >> 12) & 4095u, c.w >> 24);
            vec3 d = rsm_mixed_place(l, t) - centre;
            w = (dot(d, d) + 2.7127e-5) * b.w;
            w = w / (w + mixed);
        }
        vec3 light = uintBitsToFloat(c.xyz) * form;
        if (glossy) {
            uvec4 g = RSM_LIGHT(i, 3);
            if (g.w != 0u)
                light += rsm_gloss(l, p, a.xyz, b.xyz, form, uintBitsToFloat(g.xyz), RSM_MATERIAL(g.w - 1u));
        }
        sum += light * w;
    }
    return sum;
}

// Returns pi times the light of points first, first + step, ... of the pattern, count of them, about the
// projection of p.
vec3 rsm_gather_about(rsm_light l, vec3 p, vec3 n, rsm_sampling s, vec2 turn, uint first, uint step,
                      uint count)
{
    vec3 sum = vec3(0.0);
    rsm_centre centre = rsm_centre_of(l, p, !(s.r_max > 0.0));
    float total = s.picked > 0.0 ? rsm_total(l) : 0.0;
    for (uint i = 0u; i < count; i++) {
        ivec3 t;
        float weight;
        if (!rsm_place_sample(l, s.r_max, centre, RSM_POINT_AT(first + i * step), turn, t, weight)) continue;
        vec4 flux = uintBitsToFloat(RSM_TEXEL(t, 2));
        float mean = rsm_mean3(flux.xyz);
        if (!(mean > 0.0) && !s.glossy) continue;
        if (total > 0.0) {
            vec3 d = rsm_mixed_place(l, t) - centre.at * (l.faces == 1 ? 1.0 : 0.5);
            weight *= s.mixed / ((dot(d, d) + 2.7127e-5) * s.picked * mean / total + s.mixed);
        }
        vec3 light = uintBitsToFloat(RSM_TEXEL(t, 0).xyz);
        uvec4 b = RSM_TEXEL(t, 1);
        vec3 light_normal = uintBitsToFloat(b.xyz);
        light -= s.offset * light_normal;
        float bound = rsm_bound_of(flux.w * weight, s.clamp_at, s.near_limit);
        float near2 = s.near_field * s.near_field * flux.w;
        float form = rsm_texel_form(l, p, n, t.z, light, light_normal, bound, near2);
        vec3 e = flux.xyz * form;
        if (s.glossy && b.w != 0u)
            e += rsm_gloss(l, p, light, light_normal, form, rsm_incident(l, t.z, t.xy) * l.value,
                           RSM_MATERIAL(b.w - 1u));
        sum += e * (weight * s.set_count);
    }
    return sum;
}
