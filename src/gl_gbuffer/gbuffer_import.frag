// Fills the G-buffer from textures of the user's own.
// uses: gbuffer_bindings gbuffer_imported gbuffer_write
// with: screen.vert
// sets: GBUFFER_DEPTH=0 | GBUFFER_DEPTH=1
#ifndef GBUFFER_DEPTH
#define GBUFFER_DEPTH 0             // not 0: depths are drawn, to the G-buffer's own depth texture
#endif

// These are the bits of the block's `given`.
const uint has_places = 1u, has_depth = 2u, has_flat = 4u, has_colors = 8u;
const uint has_gloss = 16u, has_occlusion = 32u, has_entities = 64u, reversed = 128u;

bool has(uint what) { return (glbk_gbuffer_imported.given & what) != 0u; }
float depth_at(ivec2 at) { return texelFetch(glbk_gbuffer_depth_in, at, 0).x; }

// Returns the place of a pixel in world space; w is 0 where nothing is seen, as far as places and depths say
// so, and beside the picture.
vec4 place_at(ivec2 at)
{
    ivec2 sides = ivec2(glbk_gbuffer_imported.width, glbk_gbuffer_imported.height);
    if (at.x < 0 || at.y < 0 || at.x >= sides.x || at.y >= sides.y) return vec4(0.0);
    float depth = has(has_depth) ? depth_at(at) : 0.5;
    bool seen = has(reversed) ? depth > 0.0 : depth < 1.0;
    if (!seen) return vec4(0.0);
    if (has(has_places)) {
        vec4 p = texelFetch(glbk_gbuffer_place_in, at, 0);
        return p.w == 0.0 ? vec4(0.0) : vec4((glbk_gbuffer_imported.to_world * vec4(p.xyz, 1.0)).xyz, 1.0);
    }
    vec2 xy = (vec2(at) + 0.5) / vec2(sides) * 2.0 - 1.0;
    float z = depth * glbk_gbuffer_imported.depth_scale + glbk_gbuffer_imported.depth_offset;
    vec4 p = glbk_gbuffer_imported.from_clip * vec4(xy, z, 1.0);
    return vec4(p.xyz / p.w, 1.0);
}

// These are numbers of glbk_normal_packing; with the others, normals come as floats.
const uint packed_unit = 2u, packed_octahedral = 3u, packed_octahedral_unit = 4u;

// Returns the unit normal in world space that a texel holds, or 0 where it holds none.
vec3 normal_of(vec3 v)
{
    uint packing = glbk_gbuffer_imported.normal_packing;
    if (packing == packed_unit || packing == packed_octahedral_unit) v = v * 2.0 - 1.0;
    if (packing >= packed_octahedral) v = glbk_unit_of_square(v.xy);
    float d = dot(v, v);
    if (!(d > 0.25 && d < 2.25)) return vec3(0.0);
    return glbk_unit(mat3(glbk_gbuffer_imported.to_world) * v);
}

// Returns by how much the place changes with the step `by` from a pixel at p with the normal n, or 0 if no
// neighbour is seen. Of the two neighbours along this step, the one nearer to the plane of p and n counts,
// since an edge mostly lies at one side only.
vec3 step_along(ivec2 at, ivec2 by, vec3 p, vec3 n)
{
    vec4 a = place_at(at + by), b = place_at(at - by);
    vec3 da = a.xyz - p, db = p - b.xyz;
    float off_a = dot(da, n) * dot(da, n) * dot(db, db), off_b = dot(db, n) * dot(db, n) * dot(da, da);
    bool first = a.w != 0.0 && (b.w == 0.0 || off_a <= off_b);
    return first ? da : b.w != 0.0 ? db : vec3(0.0);
}

// Returns the unit normal of the surface itself, as it is given or from the places of neighbours.
vec3 flat_normal(ivec2 at, vec3 place, vec3 n)
{
    if (has(has_flat)) return normal_of(texelFetch(glbk_gbuffer_flat_in, at, 0).xyz);
    return glbk_unit(cross(step_along(at, ivec2(1, 0), place, n), step_along(at, ivec2(0, 1), place, n)));
}

#if GBUFFER_DEPTH
// Returns the depth 0..1 that OpenGL would have drawn, or 0 where it is not known.
float drawn_depth(ivec2 at, vec3 place)
{
    if (has(has_depth)) return has(reversed) ? 1.0 - depth_at(at) : depth_at(at);
    vec4 clip = glbk_gbuffer_imported.to_clip * vec4(place, 1.0);
    return clip.w > 0.0 ? clamp(clip.z / clip.w * 0.5 + 0.5, 0.0, 1.0) : 0.0;
}
#endif

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 place = place_at(at);
    vec3 n = normal_of(texelFetch(glbk_gbuffer_normal_in, at, 0).xyz);
    if (place.w == 0.0 || dot(n, n) == 0.0) discard;
    vec3 view = glbk_gbuffer_imported.eye.xyz - place.xyz;
    vec3 flat_n = flat_normal(at, place.xyz, n);
    if (dot(flat_n, view) < 0.0) flat_n = -flat_n;
    if (dot(n, flat_n) < 0.0) n = -n;
    if (!has(has_flat) && dot(n, flat_n) < 0.25) {      // all neighbours lie across edges, or are not seen
        flat_n = dot(n, view) < 0.0 ? -n : n;
        n = flat_n;
    }
    vec3 map = vec3(1.0);
    glbk_point p;
    p.position = place.xyz;
    p.normal = n;
    p.geometric = flat_n;
    p.tangent = vec3(0.0);
    p.kind = glbk_gbuffer_imported.kind;
    p.plane = glbk_gbuffer_imported.plane;
    p.lobe = glbk_gbuffer_imported.first_lobe;
    p.lobe_count = glbk_gbuffer_imported.lobe_count;
    p.diffuse = glbk_gbuffer_imported.diffuse.xyz;
    p.occlusion = glbk_gbuffer_imported.occlusion;
    p.entity = glbk_gbuffer_imported.entity;
    if (has(has_colors)) p.diffuse *= texelFetch(glbk_gbuffer_color_map, at, 0).xyz;
    if (has(has_gloss)) map = texelFetch(glbk_gbuffer_gloss_map, at, 0).xyz;
    if (has(has_occlusion)) p.occlusion = 1.0 - texelFetch(glbk_gbuffer_open_in, at, 0).x;
    if (has(has_entities)) p.entity = texelFetch(glbk_gbuffer_entity_in, at, 0).x;
    glbk_set_gloss(p, glbk_gbuffer_imported.gloss, map);
#if GBUFFER_DEPTH
    gl_FragDepth = drawn_depth(at, place.xyz);
#endif
    glbk_write_point(p);
}
