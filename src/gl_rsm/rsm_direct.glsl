// rsm_direct - computes direct light with shadows by the light's own map: percentage-closer filter, bias by
// slope.
// uses: rsm_access rsm_bound
// Returns the irradiance by a light of value 1 without its shadow, which is 0 outside a cone or behind a
// patch.
float rsm_unshadowed(rsm_light l, vec3 p, vec3 n)
{
    vec3 to = rsm_to_light(l, p), d = p - l.position;
    float d2 = dot(d, d), cosine = dot(n, to), along = -dot(l.axis, to);
    if (!(cosine > 0.0)) return 0.0;
    if (l.kind == RSM_SUN) return cosine;
    if (!(d2 > 0.0)) return 0.0;
    if (l.kind == RSM_SPOT && !(along >= l.cos_half)) return 0.0;
    if (l.kind == RSM_SQUARE_SPOT) {
        vec3 q = rsm_to_face(l, 0, p);
        if (!(q.z > 0.0 && abs(q.x) <= 1.0 && abs(q.y) <= 1.0)) return 0.0;
    }
    if (l.kind == RSM_PATCH) cosine *= max(along, 0.0);
    return cosine / d2;
}

// Returns the lit share of taps x taps texels about p, weighted as by a box that moves by fractions of a
// texel. 2 taps are bilinear. cosine is that of normal and light; bias and slope_bias are those of
// rsm_direct_desc, in texels.
float rsm_pcf(rsm_light l, vec3 p, float cosine, int taps, float bias, float slope_bias)
{
    int face = rsm_face_of_direction(l, p - l.position), size = int(l.side);
    if (face >= l.faces) return 0.0;
    vec3 q = rsm_to_face(l, face, p);
    if (l.kind != RSM_SUN && !(q.z > 0.0)) return 0.0;
    if (!(abs(q.x) <= 1.0 && abs(q.y) <= 1.0)) return l.kind == RSM_SUN ? 1.0 : 0.0;
    float texel = 2.0 / l.side * l.extent * (l.kind == RSM_SUN ? 1.0 : q.z);
    float slope = cosine < 1.0 ? min(sqrt(1.0 - cosine * cosine) / max(cosine, 0.1), 10.0) : 0.0;
    float reach = q.z - texel * (bias + slope_bias * slope * 0.7072 * float(taps));
    vec2 first = (q.xy * 0.5 + 0.5) * l.side - 0.5 * float(taps - 1), f = first - floor(first);
    float sum = 0.0, total = 0.0;
    for (int j = 0; j < taps; j++)
        for (int i = 0; i < taps; i++) {
            vec2 w = vec2(i == 0 ? 1.0 - f.x : i == taps - 1 ? f.x : 1.0,
                          j == 0 ? 1.0 - f.y : j == taps - 1 ? f.y : 1.0);
            float weight = taps == 1 ? 1.0 : w.x * w.y;
            ivec3 t = ivec3(clamp(ivec2(floor(first)) + ivec2(i, j), ivec2(0), ivec2(size - 1)), face);
            total += weight;
            if (reach <= uintBitsToFloat(RSM_TEXEL(t, 0).w)) sum += weight;
        }
    return total > 0.0 ? sum / total : 0.0;
}

// Returns the irradiance of p by a light whose map is bound, W/m^2. n is the unit normal; taps, bias and
// slope_bias are those of rsm_direct_desc, without defaults.
vec3 rsm_direct(rsm_light l, vec3 p, vec3 n, int taps, float bias, float slope_bias)
{
    float light = rsm_unshadowed(l, p, n);
    if (light > 0.0) light *= rsm_pcf(l, p, dot(n, rsm_to_light(l, p)), taps, bias, slope_bias);
    return light * l.value;
}
