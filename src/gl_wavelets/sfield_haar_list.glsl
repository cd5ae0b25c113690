// sfield_haar_list - wavelets: finds what a point meets, from near to far. C twins: shadowfield.h.
// uses: sfield_haar sfield_field
// Returns whether (d2, id) comes after the pair of the list.
bool sfield_after(float d2, uint id, float of, uint other) { return d2 > of || (d2 == of && id > other); }

// Returns the squared distance of an entity that hides, or -1 if it is out of reach or below the horizon.
float sfield_reach(uint entity, vec3 position, vec3 normal, out vec3 v)
{
    vec4 place = uintBitsToFloat(sfield_entity(entity, 0u));
    v = place.xyz - position;
    float d2 = dot(v, v);
    bool counts = d2 < place.w && dot(v, normal) > -uintBitsToFloat(sfield_entity(entity, 3u).w);
    return counts ? d2 : -1.0;
}

// Finds the next light, a channel at a time, or occluder after (d2, id). An id is 4 x entity + the channel,
// or + 3 of an occluder; SFIELD_NONE ends the list. Here as below, a call looks at entities first, first +
// step and so on.
void sfield_find(vec3 position, vec3 normal, uint own, uint first, uint step, inout float d2, inout uint id)
{
    float best = 3e38;
    uint found = SFIELD_NONE;
    for (uint e = first; e < glbk_sfield_contents.entity_count; e += step) {
        vec4 source = uintBitsToFloat(sfield_entity(e, 1u));
        vec3 v, w = source.xyz - position;
        float far = sfield_reach(e, position, normal, v), light = source.w > 0.0 ? dot(w, w) : -1.0;
        for (uint k = 0u; k < 4u; k++) {
            float d = k == 3u ? far : light;
            uint n = 4u * e + k;
            bool counts = e + 1u != own && d >= 0.0;
            if (counts && sfield_after(d, n, d2, id) && sfield_after(best, found, d, n)) {
                best = d;
                found = n;
            }
        }
    }
    d2 = best;
    id = found;
}

// Returns whether the bounding sphere of an occluder lies within the cone of a nearer inscribed sphere.
bool sfield_hidden(vec3 position, vec3 normal, uint own, uint first, uint step, float d2, uint id)
{
    uint a = id >> 2;
    vec3 v = uintBitsToFloat(sfield_entity(a, 0u).xyz) - position;
    float sin_a = uintBitsToFloat(sfield_entity(a, 3u).w) * inversesqrt(d2);
    bool hidden = false;
    for (uint b = first; b < glbk_sfield_contents.entity_count; b += step) {
        vec3 w;
        float inscribed = uintBitsToFloat(sfield_entity(b, 2u).w);
        float reach = uintBitsToFloat(sfield_entity(b, 0u).w);
        float e2 = sfield_reach(b, position, normal, w), sin_b = inscribed * inversesqrt(max(e2, 1e-30));
        float cosines = sqrt(max(1.0 - sin_a * sin_a, 0.0) * max(1.0 - sin_b * sin_b, 0.0));
        bool counts = b != a && b + 1u != own && inscribed > 0.0 && inscribed * inscribed < e2;
        bool nearer = sfield_after(d2, id, e2, 4u * b + 3u) && e2 <= 0.5625 * reach;
        bool within = sin_a < sin_b && dot(v, w) >= (cosines + sin_a * sin_b) * sqrt(d2 * e2);
        hidden = hidden || (counts && nearer && within);
    }
    return hidden;
}

// Finds the samples of the field round the point: what, corner and weight, as docs/gpu-layouts.md has them.
void sfield_surround(vec3 position, float d2, uint id, out uvec4 what, out uvec4 corner, out uvec4 weight)
{
    uint entity = id >> 2, before, after;
    bool hides = (id & 3u) == 3u;
    uint field = hides ? sfield_entity(entity, 5u).x : sfield_entity(entity, 5u).y;
    vec4 reach = uintBitsToFloat(sfield_entity(entity, 0u));
    vec4 sphere = hides ? vec4(reach.xyz, uintBitsToFloat(sfield_entity(entity, 3u).w))
                        : uintBitsToFloat(sfield_entity(entity, 1u));
    sfield_place place = sfield_locate(field, sfield_turn(entity, position - sphere.xyz) / sphere.w);
    float fade = hides ? clamp(4.0 * (1.0 - sqrt(d2) * inversesqrt(reach.w)), 0.0, 1.0) : 1.0;
    uvec4 head = SFIELD_TEXEL(field);
    uint frame = 6u * head.w * head.w * head.z;
    float t = sfield_frames(field, uintBitsToFloat(sfield_entity(entity, 4u).w), before, after);
    uint kind = hides ? SFIELD_OCCLUDER : SFIELD_LIGHT + (id & 3u);
    what = uvec4(kind, place.first + before * frame, entity, field);
    corner = floatBitsToUint(place.corner);
    weight = uvec4(floatBitsToUint(vec3(place.weight * fade, t)), after * frame - before * frame);
}
