// rsm_gather - bounced light of a receiver: from the list of pixel lights, and from texels about its projection.
// Defines: RSM_SURFACES=1, where near_field makes surfaces of near texels; 0, the default: all lights are points.
// uses: rsm_pick
#ifndef RSM_SURFACES
#define RSM_SURFACES 0
#endif
// Equation (1) without flux: cos cos / d^2, cosines times d over d^4. Both must exceed the rounding of positions, so
// that a plane does not light itself (T40).
float rsm_near = 0.0;     // 1 / squared distance of the nearest light so far that is not edge-on, for interpolation

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
// Half the sides of the surface under a texel at p: the cross section of its beam, along the beam onto the plane of n.
// Their parallelogram has rsm_area's area, since grazing ones are bounded alike, along the light.
void rsm_texel_sides(rsm_light l, int face, vec3 p, vec3 n, out vec3 side, out vec3 other)
{
    vec3 a, d;
    float scale = l.extent / l.side;
    rsm_face_frame(l, face, side, other, a);
    d = a;
    if (l.kind != RSM_SUN) {
        float depth = dot(p - l.position, a);
        d = (p - l.position) / depth;
        scale *= depth;
    }
    float facing = dot(d, n), least = 0.05 * length(d), bounded = max(abs(facing), least) * (facing < 0.0 ? -1.0 : 1.0);
    vec3 along = d - n * facing;
    vec2 off = vec2(dot(side, n), dot(other, n)), stretched = off / bounded;
    if (abs(facing) < least)
        stretched += vec2(dot(side, along), dot(other, along)) * ((1.0 - abs(facing) / least) / dot(along, along));
    side = (side - n * off.x - along * stretched.x) * scale;
    other = (other - n * off.y - along * stretched.y) * scale;
}

// An edge's share of Lambert's sum: angle(a, b) n . (b x a) / |b x a|.
float rsm_edge(vec3 n, vec3 a, vec3 b)
{
    vec3 c = cross(b - a, a);
    float size = length(c);
    return size > 0.0 ? atan(size, dot(a, b)) * (dot(n, c) / size) : 0.0;
}

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

// Integral of cos cos / d^2 over the parallelogram c +- u +- v, seen from the origin and clipped at the horizon of n:
// pi times the form factor (Baum, Rushmeier and Winget 1989). The horizon cuts it once at most: where it leaves and
// where it comes back are joined. No loop, since it is called in one: llvmpipe counts the rounds of all of them
// together.
float rsm_form_of(vec3 n, vec3 c, vec3 u, vec3 v)
{
    vec3 p = c - u - v, q = c + u - v, r = c + u + v, s = c - u + v, leave = c, come = c;
    float sum = rsm_clipped_edge(n, p, q, leave, come) + rsm_clipped_edge(n, q, r, leave, come);
    sum += rsm_clipped_edge(n, r, s, leave, come) + rsm_clipped_edge(n, s, p, leave, come);
    return 0.5 * abs(sum + rsm_edge(n, leave, come));
}
#endif

// rsm_form where the light is a texel of a face: nearer than the root of near2 the mean over the surface that it is. To
// receivers that face it nearer than half its side to its plane no more than a point, by degrees: so lie the backs of
// bent sheets, through which the parallelogram reaches.
float rsm_texel_form(rsm_light l, vec3 p, vec3 n, int face, vec3 light, vec3 light_normal, float bound, float near2)
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

// The glossy part towards p: a Phong lobe about the mirrored direction of the light, of energy `specular`.
vec3 rsm_gloss(rsm_light l, vec3 p, vec3 light, vec3 light_normal, float form, vec3 incident, vec4 material)
{
    vec3 to = rsm_to_light(l, light), mirror = 2.0 * dot(light_normal, to) * light_normal - to, d = p - light;
    float c = dot(mirror, d) / max(sqrt(dot(d, d)), 1e-9);
    if (!(c > 0.0)) return vec3(0.0);
    return incident * material.xyz * (0.5 * (material.w + 2.0) * pow(min(c, 1.0), material.w)) * form;
}

float rsm_bound_of(float area, float limit_clamp, float near_limit)
{
    float bound = limit_clamp > 0.0 ? limit_clamp : 3.0e38;
    return near_limit > 0.0 && area > 0.0 ? min(bound, near_limit * RSM_PI / area) : bound;
}

// A texel's place: in the unit square, or on the sphere of diameter 1.
vec3 rsm_mixed_place(rsm_light l, ivec3 t)
{
    vec2 q = vec2(rsm_texel_centre(l, t.x), rsm_texel_centre(l, t.y));
    vec3 r, u, a;
    if (l.faces == 1) return vec3(q * 0.5 + 0.5, 0.0);
    rsm_face_frame(l, t.z, r, u, a);
    return rsm_normalize(a + r * q.x + u * q.y) * 0.5;
}

// Where patterns about p have their centre: in the unit square, or a direction, with its frame.
vec3 rsm_centre_of(rsm_light l, vec3 p, bool inside, out vec3 right, out vec3 up)
{
    right = up = vec3(0.0);
    if (l.faces != 1) {
        vec3 c = rsm_normalize(p - l.position);
        if (!(dot(c, c) > 0.25)) c = l.axis;
        float s = c.z >= 0.0 ? 1.0 : -1.0, a = -1.0 / (s + c.z), b = c.x * c.y * a;
        right = vec3(1.0 + s * c.x * c.x * a, s * b, -s * c.x);
        up = vec3(b, s + c.y * c.y * a, -c.y);
        return c;
    }
    vec3 q = rsm_to_face(l, 0, p);
    if (l.kind != RSM_SUN && !(q.z > 0.0)) q = vec3(0.0);
    q = vec3(q.xy * 0.5 + 0.5, 0.0);
    return inside ? vec3(clamp(q.xy, 0.02, 0.98), 0.0) : q;
}

// Which texel is under a sample of a pattern about the receiver, and how many texels' worth it stands for. turn: cosine
// and sine of the pixel's rotation. r_max 0: up to the map's border. false: outside.
bool rsm_place_sample(rsm_light l, float r_max, vec3 centre, vec3 right, vec3 up, vec3 point, vec2 turn, out ivec3 t,
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
            room.x = abs(d.x) > 1e-9 ? (d.x > 0.0 ? 1.0 - centre.x : centre.x) / abs(d.x) : 4.0;
            room.y = abs(d.y) > 1e-9 ? (d.y > 0.0 ? 1.0 - centre.y : centre.y) / abs(d.y) : 4.0;
            r = min(room.x, room.y);
        }
        weight = point.z * r * r * l.side * l.side;
        q = (centre.xy + r * q) * l.side;
        if (!(r_max > 0.0)) q = clamp(q, vec2(0.0), vec2(l.side - 0.5));
        if (any(lessThan(q, vec2(0.0))) || any(greaterThanEqual(q, vec2(l.side)))) return false;
        t = ivec3(ivec2(q), 0);
        return true;
    }
    float r = r_max > 0.0 && r_max < 1.0 ? r_max : 1.0;
    q *= r;
    float s = dot(q, q), k = 2.0 * sqrt(max(1.0 - s, 0.0));
    vec3 d = centre * (1.0 - 2.0 * s) + right * (q.x * k) + up * (q.y * k), a, fr, fu;
    t.z = rsm_face_of_direction(l, d);
    if (t.z >= l.faces) return false;
    rsm_face_frame(l, t.z, fr, fu, a);
    q = vec2(dot(d, fr), dot(d, fu)) / dot(d, a);
    t.xy = min(ivec2((q * 0.5 + 0.5) * l.side), ivec2(size - 1));
    q = vec2(rsm_texel_centre(l, t.x), rsm_texel_centre(l, t.y));
    s = 1.0 + dot(q, q);
    weight = point.z * r * r * l.side * l.side * s * sqrt(s);
    return true;
}

// From numbers from to to - 1 of the list. mixed: MIXED's scale; 0 = all by flux.
vec3 rsm_gather_list(rsm_light l, vec3 p, vec3 n, uint from, uint to, bool glossy, float mixed)
{
    vec3 sum = vec3(0.0), right, up, centre = vec3(0.0);
    if (mixed > 0.0) centre = rsm_centre_of(l, p, true, right, up) * (l.faces == 1 ? 1.0 : 0.5);
    for (uint i = from; i < to; i++) {
        vec4 a = uintBitsToFloat(RSM_LIGHT(i, 0)), b = uintBitsToFloat(RSM_LIGHT(i, 1));
        uvec4 c = RSM_LIGHT(i, 2);
        float w = 1.0, form = rsm_texel_form(l, p, n, int(c.w >> 24), a.xyz, b.xyz, a.w, mixed > 0.0 ? 0.0 : b.w);
        if (mixed > 0.0) {
            ivec3 t = ivec3(c.w & 4095u, (c.w >> 12) & 4095u, c.w >> 24);
            vec3 d = rsm_mixed_place(l, t) - centre;
            w = (dot(d, d) + 2.7127e-5) * b.w;
            w = w / (w + mixed);
        }
        vec3 light = uintBitsToFloat(c.xyz) * form;
        if (glossy) {
            uvec4 g = RSM_LIGHT(i, 3);
            if (g.w != 0u) light += rsm_gloss(l, p, a.xyz, b.xyz, form, uintBitsToFloat(g.xyz), RSM_MATERIAL(g.w - 1u));
        }
        sum += light * w;
    }
    return sum;
}

// From points first, first + step, ... of the pattern, count of them, about the projection of p. limits: offset, clamp,
// near_limit, sets that share the points. mixed, picked: MIXED; else 0. near_field: texels nearer than so many of their
// sides are surfaces.
vec3 rsm_gather_about(rsm_light l, vec3 p, vec3 n, float r_max, vec2 turn, uint first, uint step, uint count,
                      vec4 limits, bool glossy, float mixed, float picked, float near_field)
{
    vec3 sum = vec3(0.0), right, up, centre = rsm_centre_of(l, p, !(r_max > 0.0), right, up);
    float total = picked > 0.0 ? rsm_total(l) : 0.0;
    for (uint i = 0u; i < count; i++) {
        ivec3 t;
        float weight;
        if (!rsm_place_sample(l, r_max, centre, right, up, RSM_POINT_AT(first + i * step), turn, t, weight)) continue;
        vec4 flux = uintBitsToFloat(RSM_TEXEL(t, 2));
        float mean = rsm_mean3(flux.xyz);
        if (!(mean > 0.0) && !glossy) continue;
        if (total > 0.0) {
            vec3 d = rsm_mixed_place(l, t) - centre * (l.faces == 1 ? 1.0 : 0.5);
            weight *= mixed / ((dot(d, d) + 2.7127e-5) * picked * mean / total + mixed);
        }
        vec3 light = uintBitsToFloat(RSM_TEXEL(t, 0).xyz);
        uvec4 b = RSM_TEXEL(t, 1);
        vec3 light_normal = uintBitsToFloat(b.xyz);
        light -= limits.x * light_normal;
        float bound = rsm_bound_of(flux.w * weight, limits.y, limits.z);
        float form = rsm_texel_form(l, p, n, t.z, light, light_normal, bound, near_field * near_field * flux.w);
        vec3 e = flux.xyz * form;
        if (glossy && b.w != 0u)
            e += rsm_gloss(l, p, light, light_normal, form, rsm_incident(l, t.z, t.xy) * l.value,
                           RSM_MATERIAL(b.w - 1u));
        sum += e * (weight * limits.w);
    }
    return sum;
}
