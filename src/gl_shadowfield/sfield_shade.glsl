// sfield_shade - returns the light at a point in the scene that glbk_sfield_bind bound, near to far (paper,
// figure 5).
// uses: sfield_access sfield_field

// An entity has SFIELD_ENTITY texels in the table: the occluder's centre and the square of its reach (0 hides
// nothing), the source's centre and radius (0 does not shine), three rows of the turn into field space (with
// the inscribed radius, the radius of the occluder and the time in w), (occluder, source, rotation, 0), the
// tint. Lengths are in world units.
#ifndef SFIELD_ENTITY
#define SFIELD_ENTITY 7u
#endif
#define SFIELD_TERMS uvec2(glbk_sfield_contents.term_texel, glbk_sfield_contents.term_count)
#define SFIELD_TURNS_LIGHT (SFIELD_GLOSS > 1 || SFIELD_EXP)
#if SFIELD_GLOSS > 1                // a third function of direction, with its comma or as a statement
#define SFIELD_AND_H(x) , x
#define SFIELD_WITH_H(x) x
#else
#define SFIELD_AND_H(x)
#define SFIELD_WITH_H(x)
#endif
#if SFIELD_EXP                      // the visibility before a light
#define SFIELD_AND_E(x) , x
#else
#define SFIELD_AND_E(x)
#endif
#define SFIELD_BATCH 8              // entities that are found at a time
#define SFIELD_OCCLUDERS 4           // inscribed spheres that are remembered

struct sfield_sums {
    vec3 light;                     // times albedo it is radiance, as sfield_points.rgb
    vec3 gloss;                     // of g: Phong's lobe; times the specular colour it is radiance
    float open;                     // share of the cosine-weighted sky that nothing hides
    vec3 grazing;                   // of h, if SFIELD_GLOSS is 2
};

sfield_sums sfield_no_light() { return sfield_sums(vec3(0.0), vec3(0.0), 0.0, vec3(0.0)); }

// Returns the first texel of entity i, counted from 0; points name the entity that they lie on from 1, 0
// being none.
uint sfield_at(uint i) { return glbk_sfield_contents.entity_texel + i * SFIELD_ENTITY; }

// All entities of the table are gone through, or those that sfield_list found. Number i has a name, which
// rises with the entity's number in the table and leads to its texels; NEAR and FAR bound its squared
// distances from the points.
#ifndef SFIELD_NAME
#define SFIELD_COUNT glbk_sfield_contents.entity_count
#define SFIELD_NAME(i) i
#define SFIELD_NUMBER(name) name
#define SFIELD_RECORD(name, k) SFIELD_MOVING(sfield_at(name) + k)
#define SFIELD_NEAR(i) 0.0
#define SFIELD_FAR(i) 3e38
#endif
#define SFIELD_HIDES 0x80000000u

// Returns v, a vector of the world, in the space of an entity's fields.
vec3 sfield_turn(uint entity, vec3 v)
{
    return vec3(dot(uintBitsToFloat(SFIELD_RECORD(entity, 2u).xyz), v),
                dot(uintBitsToFloat(SFIELD_RECORD(entity, 3u).xyz), v),
                dot(uintBitsToFloat(SFIELD_RECORD(entity, 4u).xyz), v));
}

// Finds the next SFIELD_BATCH lights and occluders in distance after (d2, id); SFIELD_NONE ends them. The id
// of a light is its entity's name, that of an occluder SFIELD_HIDES more, so that of the same distance lights
// come first. An entity does not hide its own light, since it follows the light, and neither hides nor lights
// its own points. Entities before `first` have been gone through.
void sfield_find(vec3 position, uint own, float d2, uint id, inout uint first, out float key[SFIELD_BATCH],
                 out uint name[SFIELD_BATCH])
{
    uint count = SFIELD_COUNT;
    while (first < count && SFIELD_FAR(first) < d2) first++;
    for (int i = 0; i < SFIELD_BATCH; i++) {
        key[i] = 3e38;
        name[i] = SFIELD_NONE;
    }
    for (uint at = first; at < count && SFIELD_NEAR(at) <= key[SFIELD_BATCH - 1]; at++) {
        uint e = SFIELD_NAME(at);
        if (SFIELD_NUMBER(e) + 1u == own) continue;
        vec4 occluder = uintBitsToFloat(SFIELD_RECORD(e, 0u)), source = uintBitsToFloat(SFIELD_RECORD(e, 1u));
        vec3 v = occluder.xyz - position, w = source.xyz - position;
        float far = dot(v, v), light = source.w > 0.0 ? dot(w, w) : 0.0;
        for (int what = 0; what < 2; what++) {
            float k = what == 0 ? light : max(far, light);
            uint n = what == 0 ? e : e | SFIELD_HIDES;
            bool there = what == 0 ? source.w > 0.0 : far < occluder.w;
            if (!there || !(k > d2 || (k == d2 && (id == SFIELD_NONE || n > id)))) continue;
            for (int i = 0; i < SFIELD_BATCH; i++)
                if (k < key[i] || (k == key[i] && n < name[i])) {
                    float a = key[i];
                    uint b = name[i];
                    key[i] = k;
                    name[i] = n;
                    k = a;
                    n = b;
                }
        }
    }
}

// Writes the squared distance and the id of number i of those that sfield_find found.
void sfield_pick(float key[SFIELD_BATCH], uint name[SFIELD_BATCH], uint i, out float d2, out uint id)
{
    d2 = key[0];
    id = name[0];
    for (int k = 1; k < SFIELD_BATCH; k++)
        if (uint(k) == i) {
            d2 = key[k];
            id = name[k];
        }
}

// These are the inscribed spheres of occluders that were met, as cones: axis, cosine of the half angle.
struct sfield_occluders {
    vec4 cone[SFIELD_OCCLUDERS];
    int count;
};

// Returns whether a bounding sphere, in direction v and with a half angle of that sine, is inside one of the
// cones.
bool sfield_hidden(sfield_occluders b, vec3 v, float sin_a)
{
    float cos_a = sqrt(max(1.0 - sin_a * sin_a, 0.0));
    bool hidden = false;
    for (int i = 0; i < SFIELD_OCCLUDERS; i++) {
        float cos_b = b.cone[i].w, sin_b = sqrt(max(1.0 - cos_b * cos_b, 0.0));
        bool within = dot(v, b.cone[i].xyz) >= cos_a * cos_b + sin_a * sin_b;
        hidden = hidden || (i < b.count && sin_a < sin_b && within);
    }
    return hidden;
}

// Returns a point in the space of an entity's field, in radii about its centre.
vec3 sfield_local(uint entity, vec4 sphere, vec3 position)
{
    return sfield_turn(entity, position - sphere.xyz) / sphere.w;
}

// Writes alpha of an occluder, in the world, and returns whether any of it counts. The occluder fades over
// the last quarter of its reach, and hides nothing below the horizon or behind an inscribed sphere.
bool sfield_occlusion(uint entity, vec3 position, vec3 normal, inout sfield_occluders met,
                      out float o[SFIELD_COEFS])
{
    uvec4 what = SFIELD_RECORD(entity, 5u);
    vec4 place = uintBitsToFloat(SFIELD_RECORD(entity, 0u));
    float radius = uintBitsToFloat(SFIELD_RECORD(entity, 3u).w);
    float inscribed = uintBitsToFloat(SFIELD_RECORD(entity, 2u).w);
    vec3 v = place.xyz - position;
    float d = length(v), factor = clamp(4.0 * (1.0 - d * inversesqrt(place.w)), 0.0, 1.0);
    if (!(factor > 0.0) || !(dot(v, normal) > -radius)) return false;
    if (radius < d && sfield_hidden(met, v / d, radius / d)) return false;
    if (inscribed > 0.0 && inscribed < d && factor >= 1.0 && met.count < SFIELD_OCCLUDERS) {
        for (int i = 0; i < SFIELD_OCCLUDERS; i++)
            if (i == met.count) met.cone[i] = vec4(v / d, sqrt(1.0 - inscribed * inscribed / (d * d)));
        met.count++;
    }
    for (int k = 0; k < SFIELD_COEFS; k++) o[k] = 0.0;
    vec3 local = sfield_local(entity, vec4(place.xyz, radius), position);
    sfield_fetch(what.x, sfield_locate(what.x, local), 0u, 0.0, factor, o);
    if (what.z != SFIELD_NONE) sfield_rotate(what.z, false, o);
    return true;
}

// Returns rgb with a sum in channel c and those after it, so that a source of one channel has three equal
// ones.
vec3 sfield_channel(vec3 rgb, uint c, float sum)
{
    return c == 0u ? vec3(sum) : c == 1u ? vec3(rgb.x, sum, sum) : vec3(rgb.xy, sum);
}

// Adds t . radiance of a light to the light, and g . radiance to the gloss. t and g are turned into the
// light's space; with h, and its part of the gloss, or with e the radiance is turned in their place. e is the
// visibility of what lies before the light, where it is not in t: (t e) . radiance is t . (e radiance).
void sfield_light(uint entity, vec3 position, float t[SFIELD_COEFS], float g[SFIELD_COEFS]
                  SFIELD_AND_H(float h[SFIELD_COEFS]) SFIELD_AND_E(float e[SFIELD_COEFS]),
                  inout sfield_sums sums)
{
    uvec4 what = SFIELD_RECORD(entity, 5u);
    vec4 sphere = uintBitsToFloat(SFIELD_RECORD(entity, 1u));
    sfield_place place = sfield_locate(what.y, sfield_local(entity, sphere, position));
    float time = uintBitsToFloat(SFIELD_RECORD(entity, 4u).w), v[SFIELD_COEFS];
    vec3 light = vec3(0.0), gloss = vec3(0.0), tint = uintBitsToFloat(SFIELD_RECORD(entity, 6u).xyz);
#if SFIELD_GLOSS > 1
    vec3 grazing = vec3(0.0);
#endif
#if SFIELD_EXP
    float open[SFIELD_COEFS];
#endif
#if !SFIELD_TURNS_LIGHT
    if (what.z != SFIELD_NONE) {
        sfield_rotate(what.z, true, t);
#if SFIELD_GLOSS
        sfield_rotate(what.z, true, g);
#endif
    }
#endif
    for (uint c = 0u; c < SFIELD_TEXEL(what.y + 1u).x; c++) {    // of 3 channels
        sfield_fetch(what.y, place, c, time, 1.0, v);
#if SFIELD_TURNS_LIGHT
        if (what.z != SFIELD_NONE) sfield_rotate(what.z, false, v);
#endif
#if SFIELD_EXP
        sfield_product(SFIELD_TERMS, v, e, open);
        v = open;
#endif
#if SFIELD_GLOSS > 1
        grazing = sfield_channel(grazing, c, sfield_dot(v, h));
#endif
        light = sfield_channel(light, c, sfield_dot(v, t));
#if SFIELD_GLOSS
        gloss = sfield_channel(gloss, c, sfield_dot(v, g));
#endif
    }
#if SFIELD_GLOSS > 1
    sums.grazing += grazing * tint;
#endif
    sums.light += light * tint;
    sums.gloss += gloss * tint;
}

// Returns t . radiance of the sky.
vec3 sfield_sky(float t[SFIELD_COEFS])
{
    uint at = glbk_sfield_contents.sky_texel;
    vec3 rgb = vec3(0.0);
    for (int k = 0; k < SFIELD_COEFS; k++) rgb += t[k] * uintBitsToFloat(SFIELD_MOVING(at + uint(k)).xyz);
    return rgb;
}

// Adds the sky to all sums.
void sfield_add_sky(float t[SFIELD_COEFS], float g[SFIELD_COEFS] SFIELD_AND_H(float h[SFIELD_COEFS]),
                    inout sfield_sums sums)
{
    sums.light += sfield_sky(t);
#if SFIELD_GLOSS
    sums.gloss += sfield_sky(g);
#endif
    SFIELD_WITH_H(sums.grazing += sfield_sky(h);)
}

// Takes the part that an occluder hides from t.
void sfield_apply(float o[SFIELD_COEFS], inout float t[SFIELD_COEFS])
{
    float r[SFIELD_COEFS];
    sfield_product(SFIELD_TERMS, t, o, r);
    for (int k = 0; k < SFIELD_COEFS; k++) t[k] -= r[k];
}

#if SFIELD_EXP
// Writes the exponential of a sum of logarithms. The constant is taken apart; of the rest h, exp(h) = (1 +
// h/s + (h/s)^2/2 + (h/s)^3/6)^s, where the power of two s is so large that |h/s| is small.
void sfield_exponentiate(float h[SFIELD_COEFS], out float e[SFIELD_COEFS])
{
    float constant = exp(h[0] * SFIELD_Y00), most = 0.0, scale = 1.0, r[SFIELD_COEFS];
    int squares = 0;
    for (int k = 1; k < SFIELD_COEFS; k++) most += h[k] * h[k];
    while (squares < 12 && most * scale * scale > 0.25) {
        scale *= 0.5;
        squares++;
    }
    h[0] = 0.0;
    for (int k = 0; k < SFIELD_COEFS; k++) {
        h[k] *= scale;
        e[k] = h[k] * (1.0 / 3.0);
    }
    e[0] += 1.0 / SFIELD_Y00;
    for (int i = 0; i < 2 + squares; i++) {         // Horner: 1 + h (1 + h/2 (1 + h/3)), and then squares
        bool horner = i < 2;
        if (i > 1)
            for (int k = 0; k < SFIELD_COEFS; k++) h[k] = e[k];
        sfield_product(SFIELD_TERMS, e, h, r);
        for (int k = 0; k < SFIELD_COEFS; k++) e[k] = i == 0 ? 0.5 * r[k] : r[k];
        if (horner) e[0] += 1.0 / SFIELD_Y00;
    }
    for (int k = 0; k < SFIELD_COEFS; k++) e[k] *= constant;
}

// Multiplies t by a visibility.
void sfield_open(float e[SFIELD_COEFS], inout float t[SFIELD_COEFS])
{
    float r[SFIELD_COEFS];
    sfield_product(SFIELD_TERMS, t, e, r);
    t = r;
}
#endif

// Returns the light at a point of the world with a unit normal. own is the entity that the point lies on,
// counted from 1, which neither hides the point, since t does, nor lights it; 0 is none. t is self-visibility
// x cosine, in the world: that of sfield_cosine, or recorded and turned. g is t x Phong's lobe, and is used
// if SFIELD_GLOSS is not 0. If it is 2, h follows, and any of the three may be kernels of sfield_kernel.
sfield_sums sfield_shade(vec3 position, vec3 normal, uint own, float t[SFIELD_COEFS], float g[SFIELD_COEFS]
                         SFIELD_AND_H(float h[SFIELD_COEFS]))
{
    sfield_sums sums = sfield_no_light();
    uint count = glbk_sfield_contents.entity_count, left = glbk_sfield_contents.light_count;
    uint id = SFIELD_NONE, first = 0u;
    uint name[SFIELD_BATCH];
    if (own - 1u < count && uintBitsToFloat(SFIELD_MOVING(sfield_at(own - 1u) + 1u).w) > 0.0) left--;
    bool sky = glbk_sfield_contents.wants_sky != 0u, more = left > 0u || sky;
    float d2 = 0.0, o[SFIELD_COEFS], key[SFIELD_BATCH];
#if SFIELD_EXP
    float logs[SFIELD_COEFS], e[SFIELD_COEFS];
    bool fresh = false;             // e is the exponential of logs
    for (int k = 0; k < SFIELD_COEFS; k++) logs[k] = 0.0;
#endif
    sfield_occluders met;
    met.count = 0;
    for (int i = 0; i < SFIELD_OCCLUDERS; i++) met.cone[i] = vec4(0.0);
    while (more) {
        sfield_find(position, own, d2, id, first, key, name);
        for (uint i = 0u; i < min(uint(SFIELD_BATCH), 2u * count + 1u) && more; i++) {
            sfield_pick(key, name, i, d2, id);
            if (id == SFIELD_NONE) {
                more = false;
            } else if (id < SFIELD_HIDES) {
#if SFIELD_EXP
                if (!fresh) sfield_exponentiate(logs, e);
                fresh = true;
#endif
                sfield_light(id, position, t, g SFIELD_AND_H(h) SFIELD_AND_E(e), sums);
                left--;
                more = left > 0u || sky;
            } else if (sfield_occlusion(id & ~SFIELD_HIDES, position, normal, met, o)) {
#if SFIELD_EXP
                for (int k = 0; k < SFIELD_COEFS; k++) logs[k] += o[k];
                fresh = false;
#else
                sfield_apply(o, t);
#if SFIELD_GLOSS
                sfield_apply(o, g);
#endif
                SFIELD_WITH_H(sfield_apply(o, h);)
#endif
            }
        }
    }
    if (sky) {
#if SFIELD_EXP
        if (!fresh) sfield_exponentiate(logs, e);
        sfield_open(e, t);
        sfield_open(e, g);
        SFIELD_WITH_H(sfield_open(e, h);)
#endif
        sfield_add_sky(t, g SFIELD_AND_H(h), sums);
    }
    sums.light *= 1.0 / SFIELD_PI;
    sums.open = t[0] * (1.0 / (SFIELD_PI * SFIELD_Y00));
    return sums;
}
