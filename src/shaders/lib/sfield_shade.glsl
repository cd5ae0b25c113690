// sfield_shade - light at a point in the scene that glbk_sfield_bind bound, near to far (paper, figure 5).
// uses: sfield_access sfield_field

// Entities of the table, SFIELD_ENTITY texels each: three rows of the turn into field space (w: inscribed radius, reach,
// time), centre and radius of occluder and of source, (occluder, source, rotation, 0), tint. World units.
#define SFIELD_ENTITY 7u

struct sfield_sums { vec3 light, gloss; float open; };      // without 1 / pi; T(0) after all

uint sfield_at(uint entity) { return glbk_sfield_scene.table.x + entity * SFIELD_ENTITY; }

vec3 sfield_turn(uint at, vec3 v)
{
    return vec3(dot(uintBitsToFloat(SFIELD_TEXEL(at).xyz), v), dot(uintBitsToFloat(SFIELD_TEXEL(at + 1u).xyz), v),
                dot(uintBitsToFloat(SFIELD_TEXEL(at + 2u).xyz), v));
}

// How much of an occluder counts: it fades over the last quarter of its reach, and hides nothing below the horizon.
float sfield_factor(uint at, vec4 sphere, float d2, vec3 position, vec3 normal)
{
    float fade = 4.0 * (1.0 - sqrt(d2) / uintBitsToFloat(SFIELD_TEXEL(at + 1u).w));
    return dot(sphere.xyz - position, normal) > -sphere.w ? clamp(fade, 0.0, 1.0) : 0.0;
}

// Is the bounding sphere of an occluder inside the cone of a nearer inscribed sphere?
bool sfield_hidden(uint entity, vec4 sphere, float d2, vec3 position, vec3 normal, uint own)
{
    float sin_a = sphere.w * inversesqrt(d2);
    if (!(sin_a < 1.0)) return false;
    float cos_a = sqrt(1.0 - sin_a * sin_a);
    for (uint e = 0u; e < glbk_sfield_scene.table.y; e++) {
        uint at = sfield_at(e);
        vec4 nearer = uintBitsToFloat(SFIELD_TEXEL(at + 3u));
        vec3 v = nearer.xyz - position;
        float e2 = dot(v, v), inscribed = uintBitsToFloat(SFIELD_TEXEL(at).w), r2 = inscribed * inscribed;
        if (e == entity || e == own || !(inscribed > 0.0) || e2 >= d2 || r2 * d2 <= sphere.w * sphere.w * e2 || r2 >= e2) continue;
        if (sfield_factor(at, nearer, e2, position, normal) < 1.0) continue;
        float sin_b = inscribed * inversesqrt(e2), cos_b = sqrt(1.0 - sin_b * sin_b);
        if (dot(sphere.xyz - position, v) >= (cos_a * cos_b + sin_a * sin_b) * sqrt(d2 * e2)) return true;
    }
    return false;
}

// The next in distance after (d2, id): a light has its entity's number as id, an occluder count more: of the same distance,
// lights come first. An entity does not hide itself from its own light: it follows then. false: none is left.
bool sfield_next(vec3 position, uint own, inout float d2, inout uint id)
{
    uint count = glbk_sfield_scene.table.y, best = SFIELD_NONE;
    float least = 3e38;
    for (uint e = 0u; e < count; e++) {
        uint at = sfield_at(e);
        uvec4 what = SFIELD_TEXEL(at + 5u);
        float light = 0.0;
        if (what.y != SFIELD_NONE) {
            vec3 v = uintBitsToFloat(SFIELD_TEXEL(at + 4u).xyz) - position;
            light = dot(v, v);
            if (light < least && (light > d2 || (light == d2 && (id == SFIELD_NONE || e > id)))) {
                least = light;
                best = e;
            }
        }
        if (what.x == SFIELD_NONE || e == own) continue;
        vec3 v = uintBitsToFloat(SFIELD_TEXEL(at + 3u).xyz) - position;
        float reach = uintBitsToFloat(SFIELD_TEXEL(at + 1u).w), far = dot(v, v);
        if (!(far < reach * reach)) continue;
        far = max(far, light);
        if (far < least && (far > d2 || (far == d2 && (id == SFIELD_NONE || count + e > id)))) {
            least = far;
            best = count + e;
        }
    }
    d2 = least;
    id = best;
    return best != SFIELD_NONE;
}

vec3 sfield_local(uint at, vec4 sphere, vec3 position) { return sfield_turn(at, position - sphere.xyz) / sphere.w; }

// Alpha of an occluder, in the world; false: nothing of it counts.
bool sfield_occlusion(uint entity, vec3 position, vec3 normal, uint own, out float o[SFIELD_COEFS])
{
    uint at = sfield_at(entity);
    vec4 sphere = uintBitsToFloat(SFIELD_TEXEL(at + 3u));
    uvec4 what = SFIELD_TEXEL(at + 5u);
    vec3 v = sphere.xyz - position;
    float factor = sfield_factor(at, sphere, dot(v, v), position, normal);
    for (int k = 0; k < SFIELD_COEFS; k++) o[k] = 0.0;
    if (!(factor > 0.0) || sfield_hidden(entity, sphere, dot(v, v), position, normal, own)) return false;
    sfield_fetch(what.x, sfield_locate(what.x, sfield_local(at, sphere, position)), 0u, 0.0, factor, o);
    if (what.z != SFIELD_NONE) sfield_rotate(what.z, false, o);
    return true;
}

// T . radiance of a light; t is turned into its space.
vec3 sfield_light(uint entity, vec3 position, float t[SFIELD_COEFS])
{
    uint at = sfield_at(entity);
    uvec4 what = SFIELD_TEXEL(at + 5u);
    vec4 sphere = uintBitsToFloat(SFIELD_TEXEL(at + 4u));
    sfield_place place = sfield_locate(what.y, sfield_local(at, sphere, position));
    float time = uintBitsToFloat(SFIELD_TEXEL(at + 2u).w), v[SFIELD_COEFS];
    vec3 rgb;
    if (what.z != SFIELD_NONE) sfield_rotate(what.z, true, t);
    for (int c = 0; c < 3; c++) {
        sfield_fetch(what.y, place, uint(c), time, 1.0, v);
        rgb[c] = sfield_dot(v, t);
    }
    return rgb * uintBitsToFloat(SFIELD_TEXEL(at + 6u).xyz);
}

vec3 sfield_sky(float t[SFIELD_COEFS])
{
    uint at = glbk_sfield_scene.parts.z;
    vec3 rgb = vec3(0.0);
    for (int k = 0; k < SFIELD_COEFS; k++) rgb += t[k] * uintBitsToFloat(SFIELD_TEXEL(at + uint(k)).xyz);
    return rgb;
}

void sfield_apply(float o[SFIELD_COEFS], inout float t[SFIELD_COEFS])
{
    float r[SFIELD_COEFS];
    sfield_product(glbk_sfield_scene.parts.xy, t, o, r);
    for (int k = 0; k < SFIELD_COEFS; k++) t[k] -= r[k];
}

// own: the entity that the point lies on, which does not hide it (its start does), or SFIELD_NONE.
// t: own visibility x cosine, in the world (sfield_cosine, or what was recorded, turned); g: the same x Phong's lobe, used
// where SFIELD_GLOSS is 1.
sfield_sums sfield_shade(vec3 position, vec3 normal, uint own, float t[SFIELD_COEFS], float g[SFIELD_COEFS])
{
    sfield_sums sums = sfield_sums(vec3(0.0), vec3(0.0), 0.0);
    uint count = glbk_sfield_scene.table.y, left = glbk_sfield_scene.table.z, id = SFIELD_NONE;
    bool sky = glbk_sfield_scene.table.w != 0u;
    float d2 = 0.0, o[SFIELD_COEFS];
    while ((left > 0u || sky) && sfield_next(position, own, d2, id)) {
        if (id < count) {
            sums.light += sfield_light(id, position, t);
#if SFIELD_GLOSS
            sums.gloss += sfield_light(id, position, g);
#endif
            left--;
        } else if (sfield_occlusion(id - count, position, normal, own, o)) {
            sfield_apply(o, t);
#if SFIELD_GLOSS
            sfield_apply(o, g);
#endif
        }
    }
    if (sky) {
        sums.light += sfield_sky(t);
#if SFIELD_GLOSS
        sums.gloss += sfield_sky(g);
#endif
    }
    sums.open = t[0];
    return sums;
}
